//! `render`: pictures of the right size with something in them.

use crate::support::Lab;
use image::RgbImage;
use std::collections::HashSet;

fn picture(lab: &Lab, name: &str) -> RgbImage {
    image::load_from_memory_with_format(&lab.read(name), image::ImageFormat::Png).unwrap().to_rgb8()
}

/// Colours among the upper left `width` × `height` pixels.
fn colours(picture: &RgbImage, width: u32, height: u32) -> usize {
    let at = |x| (0..height).map(move |y| (x, y));
    (0..width).flat_map(at).map(|(x, y)| picture.get_pixel(x, y).0).collect::<HashSet<_>>().len()
}

#[test]
fn a_picture_has_its_size_and_is_not_blank() {
    let lab = Lab::new();
    let said = lab.fine("render thesis:tiny --size 60x40 --samples 1 -o shot.png");
    assert!(said.contains("shot.png") && said.contains("60 × 40"), "{said}");
    let shot = picture(&lab, "shot.png");
    assert_eq!(shot.dimensions(), (60, 40));
    assert!(colours(&shot, 60, 40) > 20);
    // The tree is how the picture is made, not what it shows.
    lab.fine("render thesis:tiny -b bottom-up -k 8 --size 60x40 --samples 1 -o other.PNG");
    assert!(picture(&lab, "other.PNG") == shot);
}

#[test]
fn a_heat_map_shows_the_work_beside_its_legend() {
    let lab = Lab::new();
    lab.fine("render thesis:tiny --size 60x40 --heatmap nodes -o nodes.png");
    lab.fine("render thesis:tiny --size 60x40 --heatmap tests -o tests.png");
    lab.fine("render thesis:tiny -k 4 --size 60x40 --heatmap nodes -o other.png");
    let maps = ["nodes.png", "tests.png", "other.png"].map(|name| picture(&lab, name));
    for map in &maps {
        // Legend and caption stand outside of the map.
        assert!(map.width() >= 60 && map.height() >= 40);
        assert!(colours(map, 60, 40) > 5);
    }
    assert!(maps[0] != maps[1] && maps[0] != maps[2]);
}

#[test]
fn another_camera_another_picture_and_samples_smooth_it() {
    let lab = Lab::new();
    lab.fine("render thesis:tiny --size 30x30 --samples 1 -o a.png");
    lab.fine("render thesis:tiny --size 30x30 --samples 1 --camera eye=0,40,1,look=0,0,0,fov=50 -o b.png");
    lab.fine("render thesis:tiny --size 30x30 --samples 3 -o c.png");
    let shots = ["a.png", "b.png", "c.png"].map(|name| picture(&lab, name));
    assert!(shots[0] != shots[1] && shots[0] != shots[2]);
    assert!(shots.iter().all(|s| colours(s, 30, 30) > 5));
}

#[test]
fn without_a_name_the_picture_is_called_as_its_scene() {
    let lab = Lab::new();
    lab.fine("render thesis:tiny --size 4x4 --samples 1");
    assert_eq!(picture(&lab, "thesis-tiny.png").dimensions(), (4, 4));
    lab.fine("scene gen:soup:9 --export some.obj");
    lab.fine("render some.obj --size 5x4 --samples 1");
    assert_eq!(picture(&lab, "some.png").dimensions(), (5, 4));
}
