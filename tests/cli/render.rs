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
fn heat_maps_of_two_builders_stand_side_by_side() {
    let lab = Lab::new();
    let one = "render thesis:tiny --size 60x40 --heatmap tests -b binned-sah";
    lab.fine(&format!("{one} -o one.png"));
    lab.fine(&format!("{one} --against lbvh -o two.png"));
    let (one, two) = (picture(&lab, "one.png"), picture(&lab, "two.png"));
    assert!(two.width() > one.width() + 60 && two.height() == one.height());
    lab.fine("render thesis:tiny --size 30x20 --heatmap time -o time.png");
    assert!(colours(&picture(&lab, "time.png"), 30, 20) > 5);
    assert!(lab.refuse("render thesis:tiny --against lbvh", 2).contains("--heatmap"));
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

/// Two squares: one mirror before a matt wall, and a lamp if `lit`.
fn write_mirror(lab: &Lab, lit: bool) {
    lab.write(
        "m.mtl",
        "newmtl wall\nKd 0.7 0.7 0.7\nnewmtl mirror\nKd 0 0 0\nKs 1 1 1\nillum 3\nnewmtl lamp\nKe 9 9 9\n",
    );
    let square = |z: f32, half: f32| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| format!("v {} {} {z}\n", x * half, y * half))
            .concat()
    };
    let mut obj = format!("mtllib m.mtl\n{}{}{}", square(-1.0, 9.0), square(0.0, 0.5), square(4.0, 0.5));
    obj += "usemtl wall\nf 1 2 3 4\nusemtl mirror\nf 5 6 7 8\n";
    obj += if lit { "usemtl lamp\nf 9 10 11 12\n" } else { "" };
    lab.write("m.obj", obj);
}

const FRONT: &str = "--camera eye=0,0,2,look=0,0,0,fov=50 --size 40x30 --spp 1";

#[test]
fn explain_names_effects_their_materials_and_their_rays() {
    let lab = Lab::new();
    write_mirror(&lab, true);
    let said = lab.fine(&format!("render m.obj {FRONT} --explain"));
    for line in ["on          shadow, called for by lamp: ", "on          mirror, called for by mirror: "] {
        assert!(said.contains(line), "{said}");
    }
    assert!(said.contains("off         transparency, refraction, cut-out, texture: no ray"), "{said}");
    assert!(said.contains("; the same picture"), "{said}");
    let report = lab.json(&format!("render m.obj {FRONT} --explain"));
    assert_eq!(report["effects"], serde_json::json!(["shadow", "mirror", "emission"]));
    assert_eq!(report["called_for_by"], serde_json::json!([["lamp"], ["mirror"], ["lamp"]]));
    let rays = |kind: &str| report["rays"][kind].as_u64().unwrap();
    assert_eq!((rays("primary"), rays("refraction"), rays("transparency"), rays("cut-out")), (1200, 0, 0, 0));
    assert!(rays("reflection") > 0 && rays("reflection") < 300 && rays("shadow") > 600, "{report}");
    assert_eq!(report["all_effects"]["same_picture"], true);
    assert!(report["all_effects"]["rays"]["refraction"].as_u64().unwrap() > 600);
}

#[test]
fn effects_and_lighting_cases_override_the_scene() {
    let lab = Lab::new();
    write_mirror(&lab, true);
    let rays = |words: &str| lab.json(&format!("render m.obj {FRONT} {words}"))["rays"].clone();
    let none = rays("--effects none");
    assert_eq!((&none["primary"], &none["shadow"], &none["reflection"]), (&1200.into(), &0.into(), &0.into()));
    assert_eq!(rays("--lighting primary"), none);
    // One from every pixel, and from where the mirror's own rays go; the wall's count for nothing.
    let mirrors = rays("--effects mirror")["reflection"].as_u64().unwrap();
    assert!((1200..1500).contains(&mirrors), "{mirrors}");
    assert_eq!(rays("--lighting reflection")["reflection"], 1200);
    assert!(rays("--lighting opacity")["transparency"].as_u64().unwrap() > 1200);
    assert!(lab.refuse("render m.obj --effects mirrors", 2).contains("there is no effect 'mirrors'"));
    lab.refuse("render m.obj --effects all --lighting primary", 2);
}

#[test]
fn light_is_written_as_exr_and_exposure_brightens_png_alone() {
    let lab = Lab::new();
    write_mirror(&lab, true);
    lab.fine(&format!("render m.obj {FRONT} -o a.exr"));
    lab.fine(&format!("render m.obj {FRONT} --exposure 3 -o b.exr"));
    assert!(lab.read("a.exr") == lab.read("b.exr") && lab.read("a.exr").starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    lab.fine(&format!("render m.obj {FRONT} -o a.png"));
    lab.fine(&format!("render m.obj {FRONT} --exposure -1.5 -o b.png"));
    let mean = |name: &str| picture(&lab, name).as_raw().iter().map(|&b| u64::from(b)).sum::<u64>();
    assert!(mean("b.png") < mean("a.png"));
    assert!(lab.refuse("render m.obj -o a.jpg", 2).contains(".png or .exr"));
    assert!(lab.refuse("render m.obj --heatmap nodes -o a.exr", 2).contains(".png"));
}

#[test]
fn several_cameras_take_a_picture_each() {
    let lab = Lab::new();
    let two = "--camera eye=9,9,9,look=0,0,0 --camera eye=9,1,0,look=0,0,0,fov=60";
    let said = lab.fine(&format!("render thesis:tiny {two} --size 20x20 --spp 1 -o shot.png"));
    assert!(said.contains("shot-1.png") && said.contains("shot-2.png"), "{said}");
    assert!(picture(&lab, "shot-1.png") != picture(&lab, "shot-2.png"));
    let reports = lab.json(&format!("render thesis:tiny {two} --size 20x20 --spp 1"));
    assert_eq!(reports.as_array().map(Vec::len), Some(2), "{reports}");
    assert!(lab.refuse("render thesis:tiny --camera nowhere", 2).contains("--camera"));
}

#[test]
fn cameras_of_a_file_go_by_their_names() {
    let lab = Lab::new();
    let positions: Vec<u8> =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    lab.write("data.bin", positions);
    let node = |name: &str, camera: usize, z: f32| serde_json::json!({"camera": camera, "name": name, "translation": [0.3, 0.3, z]});
    let camera = |yfov: f32| serde_json::json!({"type": "perspective", "perspective": {"yfov": yfov, "znear": 0.1}});
    let gltf = serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [{"mesh": 0}, node("near", 0, 2.0), node("far", 1, 5.0)],
        "cameras": [camera(0.8), camera(0.9)],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"uri": "data.bin", "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}]
    });
    lab.write("two.gltf", gltf.to_string());
    lab.fine("render two.gltf --size 20x20 --spp 1 --camera all -o c.png");
    lab.fine("render two.gltf --size 20x20 --spp 1 --camera far -o far.png");
    assert!(
        picture(&lab, "c-2.png") == picture(&lab, "far.png") && picture(&lab, "c-1.png") != picture(&lab, "far.png")
    );
    assert!(lab.refuse("render two.gltf --camera mid", 2).contains("near, far"));
}
