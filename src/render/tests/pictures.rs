//! Surfaces drawn with pictures: holes where one is clear, colours where it has them.

use super::{FRAME, camera, counts, glass, lamp, matt, picture, scene};
use crate::geom::Triangle;
use crate::render::{Demand, RayKind, Stage, StageOptions};
use crate::scene::{EffectSet, Material, Scene, Texture, TextureSource};
use crate::trace::testing::median_split;
use glam::{Vec2, Vec3};
use std::io::Cursor;

/// Two pixels side by side, the border going on outside.
fn two_pixels(left: [u8; 4], right: [u8; 4]) -> Texture {
    let image = image::RgbaImage::from_raw(2, 1, [left, right].concat()).unwrap();
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    Texture { clamps: true, ..Texture::of(TextureSource::Embedded("two".into(), bytes.into_inner().into())) }
}

/// A square drawn with `material` before a matt wall, the picture across it.
fn square_before_wall(material: Material) -> Scene {
    let mut scene = scene(&[(0.0, 0.5, material), (-1.0, 9.0, matt())]);
    scene.texture_coordinates = scene.triangles.iter().map(|t| t.v.map(|p| Vec2::new(p.x + 0.5, p.y + 0.5))).collect();
    scene
}

/// Whether a pixel shows the left half of the square, and whether the right one.
fn halves() -> Vec<(bool, bool)> {
    let view = camera().view(FRAME.width, FRAME.height);
    let at = |i: u32| {
        let ray = view.ray(i % FRAME.width, i / FRAME.width);
        let p = ray.at(-ray.origin.z / ray.direction.z);
        let inside = p.x.abs().max(p.y.abs()) <= 0.5;
        (inside && p.x < 0.0, inside && p.x > 0.0)
    };
    (0..FRAME.width * FRAME.height).map(at).collect()
}

#[test]
fn a_hole_shows_what_is_behind_it_for_one_ray_each() {
    let map = two_pixels([255, 255, 255, 0], [255, 255, 255, 255]);
    let cut = square_before_wall(Material { opacity_map: Some(map), diffuse: Vec3::X, ..matt() });
    let taken = picture(&cut, Demand::Materials);
    let holes = halves().iter().filter(|(left, _)| *left).count() as u64;
    assert!(holes > 30);
    assert_eq!(counts(&taken.rays), [1200, 0, 0, 0, 0, holes]);
    for (pixel, (left, right)) in taken.film.pixels.iter().zip(halves()) {
        assert_eq!(pixel.y == 0.0, right, "{left} {right}");
    }
    let closed = picture(&cut, Demand::Forced(EffectSet::EMPTY));
    assert_eq!(counts(&closed.rays), [1200, 0, 0, 0, 0, 0]);
    assert!(closed.film.pixels.iter().zip(halves()).all(|(p, (left, right))| (p.y == 0.0) == (left || right)));
}

#[test]
fn a_texture_colours_what_it_is_on() {
    let map = two_pixels([0, 255, 0, 255], [0, 0, 255, 255]);
    let drawn = square_before_wall(Material { diffuse_map: Some(map), ..matt() });
    let taken = picture(&drawn, Demand::Materials);
    assert_eq!(counts(&taken.rays), [1200, 0, 0, 0, 0, 0]);
    for (pixel, (left, right)) in taken.film.pixels.iter().zip(halves()) {
        assert_eq!(pixel.x == 0.0, left || right);
        assert!(!left || pixel.y >= pixel.z, "green to the left, {pixel}");
        assert!(!right || pixel.z >= pixel.y, "blue to the right, {pixel}");
    }
    let plain = picture(&drawn, Demand::Forced(EffectSet::EMPTY));
    assert!(plain.film.pixels.iter().all(|p| p.x > 0.0));
}

#[test]
fn a_picture_that_cannot_be_read_is_told_and_left_out() {
    let broken = Texture::of(TextureSource::Embedded("broken".into(), b"no picture".as_slice().into()));
    let scene = square_before_wall(Material { diffuse_map: Some(broken), ..matt() });
    let bvh = median_split(&scene.triangles, 2);
    let stage = Stage::new(&scene, &bvh, &StageOptions::default()).unwrap();
    assert!(stage.warnings()[0].contains("broken") && stage.warnings().len() == 1);
    assert!(stage.render(&camera(), &FRAME).film.pixels.iter().all(|p| p.x > 0.0));
}

#[test]
fn a_clear_body_bends_light_the_same_way_however_it_is_wound() {
    let ball = |is_inward: bool| {
        let mut scene = scene(&[(-3.0, 9.0, matt()), (3.0, 5.0, lamp())]);
        scene.materials.push(glass());
        let octahedron = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * 0.7);
        for (x, y, z) in (0..8).map(|i| (i & 1 == 0, i & 2 == 0, i & 4 == 0)) {
            let [a, b, c] = [(x, 0), (y, 1), (z, 2)].map(|(plus, i)| if plus { octahedron[i] } else { -octahedron[i] });
            let faces_out = (x == y) == z;
            let corners = if faces_out != is_inward { [a, b, c] } else { [a, c, b] };
            scene.triangles.push(Triangle { v: corners });
            scene.material_ids.push(3);
        }
        scene
    };
    let [right, wrong] = [false, true].map(|is_inward| {
        let scene = ball(is_inward);
        let bvh = median_split(&scene.triangles, 2);
        let stage = Stage::new(&scene, &bvh, &StageOptions::default()).unwrap();
        (stage.render(&camera(), &FRAME).rays, stage.warnings().to_vec())
    });
    assert!(right.0.of(RayKind::Refraction) > 100);
    // Rays are the same, one for one; radiance may differ in a last bit, as corners come in another order.
    assert_eq!(right.0, wrong.0);
    assert_eq!(right.1, [""; 0]);
    assert_eq!(wrong.1, ["1 closed clear object is wound inwards; light bends as if turned outwards"]);
}
