//! Tests of the file readers: odd files of our own, and real scenes where they are at hand.

mod damaged;
mod formats;
mod twin;

use super::*;
use glam::Vec3;
use std::fs;
use std::path::PathBuf;

/// Reads `text` as the file `scene.obj` beside the given files.
fn obj(text: impl AsRef<[u8]>, beside: &[(&str, &str)]) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in beside {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let path = folder.path().join("scene.obj");
    fs::write(&path, text).unwrap();
    load(&path)
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn accepted_oddities() {
    let latin1 = [b"# caf\xe9\n", TRIANGLE.as_bytes()].concat();
    assert_eq!(obj(latin1, &[]).unwrap().triangles.len(), 1);
    for text in [
        TRIANGLE.to_owned(),
        format!("\u{feff}{TRIANGLE}"),
        TRIANGLE.replace('\n', "\r"),
        TRIANGLE.replace('\n', "\r\n"),
        TRIANGLE.replace('\n', " # remark\n"),
        TRIANGLE.replace("2 3", "\\\n2 \\\n3"),
        TRIANGLE.replace("1 2 3", "-3/1/1 -2//4 -1/2"),
        TRIANGLE.replacen("0 0 0", "0 0 0 1 0 0", 1),
        TRIANGLE.replacen("0 0 0", "0 0 0 7", 1),
        format!("f 1 2 3\no later\n{}", TRIANGLE.replace("f 1 2 3\n", "")),
        TRIANGLE.trim_end().to_owned(),
        format!("usemtl\n{TRIANGLE}"),
    ] {
        let scene = obj(&text, &[]).unwrap_or_else(|error| panic!("{text:?}: {error}"));
        assert_eq!(scene.triangles, [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)], "{text:?}");
        assert_eq!((scene.objects.len(), scene.material_ids.as_slice()), (1, [0].as_slice()));
    }
}

#[test]
fn what_is_no_finite_triangle_is_counted() {
    let more = "v nan 0 0\nv 0 1e39 0\nl 1 2\np 1\nf 2 3\nf 1\nf 1 2 4\nf 1 2 5 3\nf 1 1 1\nf 1 2 3\n";
    let scene = obj(format!("{TRIANGLE}{more}"), &[]).unwrap();
    assert_eq!(scene.triangles.len(), 3, "degenerate and duplicate triangles are kept");
    let expected = Dropped { not_finite: 3, points_and_lines: 4 };
    assert_eq!(scene.dropped, expected);
    assert!(scene.triangles.iter().all(Triangle::is_finite));
}

#[test]
fn objects_and_materials_are_told_apart() {
    let text = "mtllib no.mtl\nmtllib my first.mtl\nmtllib sub\\ b.mtl c.mtl\n\
        v 0 0 0\nv 1 0 0\nv 0 1 0\n\
        o one\nusemtl red paint\nf 1 2 3\nusemtl ghost\nf 1 2 3\nusemtl ghost\nf 1 2 3\n\
        g one\nf 1 2 3\no empty\ng two parts\nusemtl lamp\nf 1 2 3\nusemtl\nf 1 2 3\n";
    let beside = [
        ("my first.mtl", "newmtl red paint # red\nKd 1 0 0 # so\nKs .5\nd -halo 0.25\nTr 0.1\nNi 1.5\nillum 7\n"),
        (
            "sub b.mtl",
            "Kd 9 9 9\nnewmtl lamp\nKe 1 2 3\nTr 0.75\nNs 10\nKd spectral x.rfl\nillum 77\nKs nan 0 0\nmap_Kd\n",
        ),
        ("c.mtl", "newmtl\nKd 0 0 1\n"),
    ];
    let scene = obj(text, &beside).unwrap();
    let objects: Vec<_> = scene.objects.iter().map(|o| (o.name.as_str(), o.triangles.clone())).collect();
    assert_eq!(objects, [("one", 0..3), ("one", 3..4), ("two parts", 4..6)]);
    let names: Vec<_> = scene.material_ids.iter().map(|&id| scene.materials[usize::from(id)].name.as_str()).collect();
    assert_eq!(names, ["red paint", "default", "default", "default", "lamp", "(nameless)"]);
    let red = Material {
        name: "red paint".into(),
        diffuse: Vec3::X,
        specular: Vec3::splat(0.5),
        refraction_index: 1.5,
        opacity: 0.25,
        illumination_model: 7,
        ..Material::default()
    };
    let lamp = Material {
        name: "lamp".into(),
        emission: Vec3::new(1.0, 2.0, 3.0),
        shininess: 10.0,
        opacity: 0.25,
        ..Material::default()
    };
    assert_eq!(scene.materials[1..3], [red, lamp]);
    let warned = |words: &str| scene.warnings.iter().filter(|w| w.contains(words)).count();
    assert_eq!((warned("no.mtl"), warned("'ghost' is not defined")), (1, 1), "{:?}", scene.warnings);
    assert_eq!(
        (warned("'spectral'"), warned("illum"), warned("'nan'"), warned("map_Kd without")),
        (1, 1, 1, 1),
        "{:?}",
        scene.warnings
    );
    assert_eq!(scene.warnings.len(), 6, "{:?}", scene.warnings);
}

#[test]
fn broken_files_are_told_by_file_and_line() {
    for (text, words) in [
        ("v 0 0\n", "scene.obj:1: a vertex needs three numbers"),
        ("v 0 0 0\nv 0 1.#IND 0\n", "scene.obj:2: '1.#IND' is not a number"),
        ("\u{feff}f -1 -2 -3\n", "scene.obj:1: vertex index -1, but there are no vertices"),
        ("v 0 0 0\nf 1 1 99999999999999999999\n", "scene.obj:2: vertex index 99999999999999999999 is out of range"),
        ("v 0 0 0\nf\n", "scene.obj:2: a face without vertices"),
        ("v 0 0 0\nv 0 0 0\r\rf 1 2 3", "scene.obj:4: vertex index 3 is out of range: there are 2 vertices"),
        ("f 0 1 2", "scene.obj:1: vertex index 0"),
        ("v\u{0}", "encoding"),
    ] {
        let error = obj(text, &[]).expect_err(text);
        assert!(matches!(error, SceneError::Malformed { .. }));
        assert!(error.to_string().contains(words) && !error.to_string().contains('\n'), "{error}");
    }
    for (text, words) in [("", "no triangles;"), ("v 0 0 0\np 1\n", "no triangles (only 1 points and lines);")] {
        let error = obj(text, &[]).expect_err(text);
        assert!(matches!(error, SceneError::Empty { .. }) && error.to_string().contains(words), "{error}");
    }
}

#[test]
fn places_without_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("x.step"), "solid").unwrap();
    fs::write(at("plain"), "x").unwrap();
    fs::create_dir(at("folder.obj")).unwrap();
    let load = |name: &str| Scene::load(at(name).to_str().unwrap()).unwrap_err();
    for name in ["missing.obj", "missing.xyz", "no\nsuch.obj"] {
        let error = load(name);
        assert!(matches!(error, SceneError::Unreadable { .. }) && !error.to_string().contains('\n'), "{error}");
    }
    for (name, words) in [("x.step", ".obj or .ply"), ("plain", ".obj or .ply"), ("folder.obj", "directory")] {
        let error = load(name);
        assert!(matches!(error, SceneError::Malformed { .. }) && error.to_string().contains(words), "{error}");
    }
    assert!(matches!(load("missing"), SceneError::Unknown { .. }));
}

#[test]
fn raw_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.TRI");
    let mut numbers: Vec<f32> = (0..27).map(|i| i as f32).collect();
    numbers[13] = f32::NEG_INFINITY;
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    fs::write(&path, &bytes).unwrap();
    let scene = load(&path).unwrap();
    assert_eq!((scene.triangles.len(), scene.dropped.not_finite), (2, 1));
    assert_eq!(scene.triangles[1].v[2], Vec3::new(24.0, 25.0, 26.0));
    assert_eq!(scene.name, path.display().to_string());
    fs::write(&path, &bytes[..107]).unwrap();
    assert!(load(&path).unwrap_err().to_string().contains("107 bytes"));
    fs::write(&path, []).unwrap();
    assert!(matches!(load(&path), Err(SceneError::Empty { .. })));
}

/// The folder of real scenes, or none with a word about it.
fn real_scenes(test: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    let folder = std::env::var_os("BVH_LAB_SCENES").map_or(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: {test} needs the real scenes (BVH_LAB_SCENES)");
    None
}

#[test]
fn real_scenes_have_their_triangles() {
    let Some(folder) = real_scenes("real_scenes_have_their_triangles") else {
        return;
    };
    for (file, triangles) in [
        ("cornell_box/CornellBox-Original.obj", 36),
        ("cornell_box/CornellBox-Water.obj", 7_088),
        ("teapot/teapot.obj", 6_320),
        ("spot/spot.obj", 5_856),
        ("stanford_bunny/stanford-bunny.obj", 69_451),
        ("dragon_res2/dragon_vrip_res2.obj", 202_520),
        ("dragon_full/dragon_vrip.obj", 871_414),
        ("scorpion/scorpion.obj", 99_990),
        ("teapot_full/teapot_full.obj", 126_744),
        ("teapot_in_stadium/teapot_in_stadium.obj", 18_298),
        ("classroom/classroom.obj", 103_832),
        ("staircase/staircase.obj", 262_663),
        ("coffee/coffee.obj", 235_271),
        ("munich/munich.obj", 38_936),
        ("slivers/sliver_tet.obj", 4),
        ("slivers/mengerSponge3.obj", 21_598),
    ] {
        let scene = load(&folder.join(file)).unwrap();
        assert_eq!(scene.triangles.len(), triangles, "{file}");
        assert_eq!((scene.dropped.total(), scene.warnings), (0, vec![]), "{file}");
        assert_eq!(scene.material_ids.len(), triangles);
        let covered = scene.objects.iter().fold(0, |end, o| {
            assert_eq!(o.triangles.start, end);
            o.triangles.end
        });
        assert_eq!(covered, triangles);
    }
}

#[test]
fn statements_without_use_are_counted_and_numbers_repaired() {
    let beside =
        [("m.mtl", "newmtl a\nKa 1 1 1\nmap_bump b.png\nmap_bump c.png\nPs 0.3\nmap_Kd no.png\nKd 1,5D-1 0 0\n")];
    let scene = obj(format!("mtllib m.mtl\nusemtl a\n{}", TRIANGLE.replace("v 1 0 0", "v 1,0 0 0")), &beside).unwrap();
    assert_eq!(scene.triangles, [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)]);
    assert_eq!(scene.materials[1].diffuse, Vec3::new(0.15, 0.0, 0.0));
    let warned = |words: &str| scene.warnings.iter().any(|w| w.contains(words));
    assert!(warned("no use here: Ps (1), map_bump (2)") && warned("m.mtl:6: map_Kd: there is no file "));
    assert!(warned("1 numbers in odd spellings were understood, the first in line 4: '1,0'"), "{:?}", scene.warnings);
    assert_eq!(scene.warnings.len(), 3);
}

#[test]
fn see_through_is_understood_as_its_writers_mean_it() {
    let clear = |statements: &str| {
        let beside = [("m.mtl", format!("newmtl a\n{statements}"))];
        let beside = beside.each_ref().map(|(name, text)| (*name, text.as_str()));
        let scene = obj(format!("mtllib m.mtl\nusemtl a\n{TRIANGLE}"), &beside).unwrap();
        let m = &scene.materials[scene.material_ids[0] as usize];
        (m.opacity, m.transmission_filter)
    };
    assert_eq!(clear("d 0.25\nTr 0.1\nTf 0 1 0\n"), (0.25, Vec3::Y));
    assert_eq!(clear("Tr 0.25\n"), (0.75, Vec3::ONE));
    // 3ds Max, opaque; Maya, opaque and clear; a green filter by the format's own rule.
    assert_eq!(clear("d 1\nTr 0\nTf 1 1 1\nillum 2\n"), (1.0, Vec3::ONE));
    assert_eq!(clear("illum 4\nTf 1 1 1\n"), (1.0, Vec3::ONE));
    assert_eq!(clear("illum 4\nTf 0.1 0.1 0.1\n"), (0.1, Vec3::ONE));
    assert_eq!(clear("illum 7\nTf 0 1 0\n"), (1.0, Vec3::Y));
}

#[test]
fn metals_mirror_where_they_are_smooth() {
    let metal = |statements: &str| {
        let beside = [("m.mtl", format!("newmtl a\nKd 1 0.5 0\n{statements}"))];
        let beside = beside.each_ref().map(|(name, text)| (*name, text.as_str()));
        obj(format!("mtllib m.mtl\nusemtl a\n{TRIANGLE}"), &beside).unwrap().materials[1].clone()
    };
    let smooth = metal("Pm 1\nPr 0.1\n");
    assert_eq!((smooth.diffuse, smooth.specular, smooth.illumination_model), (Vec3::ZERO, Vec3::new(1.0, 0.5, 0.0), 3));
    let rough = metal("Pm 0.5\nPr 0.9\n");
    assert_eq!((rough.diffuse, rough.illumination_model), (Vec3::new(0.5, 0.25, 0.0), 2));
    assert!(rough.shininess < smooth.shininess);
}

#[test]
fn textured_files_keep_their_texture_coordinates_wherever_the_library_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.obj");
    image::RgbImage::new(2, 2).save(folder.path().join("a b.png")).unwrap();
    fs::write(folder.path().join("m.mtl"), "newmtl a\nmap_Kd -o 0.5 -s 2 3 a b.png -clamp on\nmap_d a b.png\n")
        .unwrap();
    let body = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1 2 3\n";
    for text in [format!("mtllib m.mtl\n{body}"), body.replace("usemtl", "mtllib m.mtl\nusemtl")] {
        fs::write(&path, text).unwrap();
        let scene = load(&path).unwrap();
        use glam::Vec2;
        assert_eq!(scene.texture_coordinates, [[Vec2::ZERO, Vec2::X, Vec2::Y], [Vec2::ZERO; 3]]);
        let texture = scene.materials[1].diffuse_map.as_ref().unwrap();
        assert_eq!((texture.offset, texture.scale, texture.clamps), (Vec2::new(0.5, 0.0), Vec2::new(2.0, 3.0), true));
        assert!(texture.decode().is_ok());
        assert_eq!(scene.warnings.len(), 1);
        assert!(scene.warnings[0].contains("material 'b' is not defined"), "{:?}", scene.warnings);
    }
    fs::write(&path, body.replace("usemtl a\n", "")).unwrap();
    assert!(load(&path).unwrap().texture_coordinates.is_empty());
}

/// What should come of a file of the torture set: triangles, or words of the error.
const TORTURE: &[(&str, Result<usize, &str>)] = &[
    ("extra/own_nan_inf_plain.obj", Err("no triangles (only 1 triangles with a NaN")),
    ("extra/tinyobj_numeric-edge-cases.obj", Ok(2)),
    ("tinyobjloader/test-nan.obj", Err("test-nan.obj:14: '1.#IND' is not a number")),
    ("tinyobjloader/invalid-face-definition.obj", Err("no triangles (only 2 points and lines)")),
    ("tobj/lines.obj", Err("no triangles")),
    ("tinyobjloader/line-prim.obj", Err("no triangles")),
    ("tinyobjloader/points-prim.obj", Err("no triangles")),
    ("obj-rs/group.obj", Ok(9)),
    ("extra/own_degenerate_dup.obj", Ok(3)),
    ("tobj/invalid_index.obj", Err("invalid_index.obj:12: vertex index 7")),
    ("tinyobjloader/issue-140-zero-face-idx.obj", Err("issue-140-zero-face-idx.obj:16: vertex index 0")),
    ("tinyobjloader/invalid-relative-vertex-index.obj", Err("invalid-relative-vertex-index.obj:1: ")),
    ("tinyobjloader/invalid-relative-texture-index.obj", Err("invalid-relative-texture-index.obj:2: ")),
    ("extra/own_huge_index.obj", Err("own_huge_index.obj:4: ")),
    ("extra/own_short_vertex.obj", Err("own_short_vertex.obj:1: ")),
    ("assimp_invalid/malformed.obj", Err("malformed.obj:")),
    ("assimp_invalid/malformed2.obj", Err("malformed2.obj:")),
    ("extra/own_face_before_vertex.obj", Ok(1)),
    ("extra/own_latin1_comment.obj", Ok(1)),
    ("extra/own_bom.obj", Ok(1)),
    ("assimp_OBJ/regr01.obj", Ok(0)),
    ("extra/own_backslash.obj", Ok(2)),
    ("extra/own_cr_only.obj", Ok(1)),
    ("extra/own_trailing_comment.obj", Ok(1)),
    ("extra/own_undefined_mtl.obj", Ok(1)),
    ("assimp_OBJ/only_a_part_of_vertexcolors.obj", Ok(3)),
    ("assimp_OBJ/empty_mat.obj", Ok(0)),
    ("assimp_OBJ/box_UTF16BE.obj", Err("encoding")),
    ("assimp_OBJ/box_mat_with_spaces.obj", Ok(12)),
    ("tinyobjloader/mtl filename with whitespace issue46.obj", Ok(12)),
    ("tinyobjloader/issue-295-trianguation-failure.obj", Ok(28)),
    ("obj-rs/empty.obj", Err("no triangles;")),
];

#[test]
fn torture_files_come_out_as_wanted() {
    let Some(folder) = real_scenes("torture_files_come_out_as_wanted") else {
        return;
    };
    for (file, wanted) in TORTURE {
        let found = load(&folder.join("parser_torture").join(file));
        match (found, wanted) {
            // 0 stands for any count that is not zero.
            (Ok(scene), Ok(count)) => assert!(*count == 0 || scene.triangles.len() == *count, "{file}"),
            (Err(error), Err(words)) => assert!(error.to_string().contains(words), "{file}: {error}"),
            (Ok(scene), Err(_)) => panic!("{file} loads, {} triangles", scene.triangles.len()),
            (Err(error), Ok(_)) => panic!("{file}: {error}"),
        }
    }
}

#[test]
fn no_torture_file_panics_or_lets_anything_not_finite_through() {
    let Some(folder) = real_scenes("no_torture_file_panics_or_lets_anything_not_finite_through") else {
        return;
    };
    let mut folders = vec![folder.join("parser_torture")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            files += 1;
            // Whatever the ending: every reader must survive every file.
            let size = fs::metadata(&path).unwrap().len();
            let mut silent = |_, _| {};
            for format in FORMATS {
                let found = (format.read)(&mut Source::new(&path, size, &mut silent));
                if let Err(error) = found {
                    assert_eq!(error.to_string().lines().count(), 1, "{error}");
                }
            }
            let found = obj::read(&mut Source::new(&path, size, &mut silent));
            match (&found, load(&path)) {
                (_, Ok(scene)) => assert!(scene.bounds().is_valid(), "{}", path.display()),
                (_, Err(error)) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
            }
            if let Ok(parts) = found {
                assert!(parts.triangles.iter().all(Triangle::is_finite));
                assert_eq!(parts.material_ids.len(), parts.triangles.len());
            }
        }
    }
    assert!(files > 100, "{files}");
}
