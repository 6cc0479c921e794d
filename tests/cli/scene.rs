//! `scene`: what a scene holds, and that an exported one comes back the same.

use crate::support::{Lab, has_fields, number, tri_bytes, word};

#[test]
fn every_field_is_there() {
    let lab = Lab::new();
    let report = lab.json("scene thesis:tiny");
    has_fields(&report, &["scene", "triangles", "dropped", "bounds", "surface_area", "materials", "effects"]);
    assert_eq!((&report["scene"], &report["triangles"]), (&"thesis:tiny".into(), &648.into()));
    let dropped = report["dropped"].as_object().unwrap();
    assert!(!dropped.is_empty() && dropped.values().all(|n| n == 0));
    assert!((number(&report, "surface_area") - 762.4795).abs() < 1e-3, "{report}");
    for corner in ["min", "max"] {
        assert_eq!(report["bounds"][corner].as_array().unwrap().len(), 3);
    }
    let objects = report["objects"].as_array().unwrap();
    assert_eq!(objects.iter().map(|o| number(o, "triangles")).sum::<f64>(), 648.0);
    let text = lab.fine("scene thesis:tiny");
    assert!(text.contains("thesis:tiny: 648 triangles"), "{text}");
}

#[test]
fn an_exported_scene_comes_back_as_the_same_tree() {
    let lab = Lab::new();
    for (scene, file) in
        [("thesis:tiny", "tiny.obj"), ("gen:soup:500:7", "soup.OBJ"), ("gen:coincident:40", "same.obj")]
    {
        let exported = lab.json(&format!("scene {scene} --export {file}"));
        let loaded = lab.json(&format!("scene {file}"));
        for field in ["triangles", "bounds", "surface_area"] {
            assert_eq!(exported[field], loaded[field], "{scene}: {field}");
        }
        for words in ["-k 4", "-b bottom-up"] {
            let hash = |scene: &str| word(&lab.json(&format!("build {scene} {words} --runs 1")), "tree_hash");
            assert_eq!(hash(scene), hash(file), "{scene} {words}");
        }
    }
}

#[test]
fn effects_are_named_with_the_materials_that_call_for_them() {
    let lab = Lab::new();
    lab.write("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(lab.json("scene plain.obj")["effects"].as_array().map(Vec::len), Some(0));
    lab.write("glass.mtl", "newmtl glass\nKd 0.1 0.1 0.1\nd 0.3\nNi 1.5\nillum 7\n");
    lab.write("glass.obj", "mtllib glass.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass\nf 1 2 3\n");
    let report = lab.json("scene glass.obj");
    let effects = report["effects"].as_array().unwrap();
    assert!(!effects.is_empty(), "{report}");
    for called_for_by in report["called_for_by"].as_array().unwrap() {
        assert_eq!(called_for_by, &serde_json::json!(["glass"]));
    }
    assert_eq!(word(&report["materials"][0], "name"), "glass");
}

#[test]
fn what_was_left_out_is_counted_by_reason() {
    let lab = Lab::new();
    let mut bytes = tri_bytes("gen:soup:3");
    bytes[..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    lab.write("odd.tri", bytes);
    let report = lab.json("scene odd.tri");
    assert_eq!((&report["triangles"], &report["dropped"]["not_finite"]), (&2.into(), &1.into()));
    lab.write("odd.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\np 3\n");
    let report = lab.json("scene odd.obj");
    assert_eq!((&report["triangles"], &report["dropped"]["points_and_lines"]), (&1.into(), &2.into()));
}
