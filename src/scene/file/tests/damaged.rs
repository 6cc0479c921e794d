//! Small valid files, damaged: whatever comes of it is a valid scene or one line, never a panic.

use super::formats::{
    PLY_TEXT, STL_TEXT, binary_ply, binary_stl, glb, gltf_buffer, gltf_document, gzip, read, zstandard,
};
use super::*;
use proptest::prelude::*;

/// One valid file a format, and a name for it.
fn valid() -> Vec<(&'static str, Vec<u8>)> {
    use base64::Engine;
    let encoded = base64::engine::general_purpose::STANDARD.encode(gltf_buffer());
    let obj = "mtllib m.mtl\no one\nv 0 0 0\nv 1 0 0 0.5\nv -1.5e0 1 0\nvt 0 1\nusemtl a\nf 1/1/1 2//1 -1\nf 1 2 3 \\\n2\ng x # y\nl 1 2\n";
    let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y); 3];
    vec![
        ("a.obj", obj.into()),
        ("a.ply", PLY_TEXT.into()),
        ("b.ply", binary_ply("binary_little_endian", false)),
        ("a.stl", STL_TEXT.into()),
        ("b.stl", binary_stl("solid", &triangles)),
        ("a.gltf", gltf_document(&format!("data:;base64,{encoded}")).into()),
        ("a.glb", glb()),
        ("a.tri", vec![0x3f; 36 * 3]),
        ("a.obj.gz", gzip(obj.as_bytes())),
        ("a.obj.zst", zstandard(obj.as_bytes())),
        ("a.glb.gz", gzip(&glb())),
    ]
}

/// What is done to a file at a place.
#[derive(Clone, Debug)]
enum Damage {
    Byte(u8),
    Bit(u8),
    Cut,
    Remove(usize),
    Double(usize),
    Number(&'static str),
}

fn damage() -> impl Strategy<Value = Damage> {
    let numbers =
        ["-1", "0", "4294967295", "18446744073709551615", "nan", "-inf", "1e39", "1e999", "", "\n", "/", "\u{feff}"];
    prop_oneof![
        any::<u8>().prop_map(Damage::Byte),
        (0..8_u8).prop_map(Damage::Bit),
        Just(Damage::Cut),
        (1..40_usize).prop_map(Damage::Remove),
        (1..40_usize).prop_map(Damage::Double),
        prop::sample::select(numbers.to_vec()).prop_map(Damage::Number),
    ]
}

fn damaged(mut bytes: Vec<u8>, damages: &[(prop::sample::Index, Damage)]) -> Vec<u8> {
    for (place, damage) in damages {
        if bytes.is_empty() {
            break;
        }
        let at = place.index(bytes.len());
        let until = |n: &usize| (at + n).min(bytes.len());
        match damage {
            Damage::Byte(byte) => bytes[at] = *byte,
            Damage::Bit(bit) => bytes[at] ^= 1 << bit,
            Damage::Cut => bytes.truncate(at),
            Damage::Remove(n) => drop(bytes.drain(at..until(n))),
            Damage::Double(n) => {
                let part = bytes[at..until(n)].to_vec();
                bytes.splice(at..at, part);
            }
            Damage::Number(text) => drop(bytes.splice(at..until(&1), text.bytes())),
        }
    }
    bytes
}

#[test]
fn the_files_are_valid_before() {
    for (name, bytes) in valid() {
        let scene = read(name, &bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(!scene.triangles.is_empty());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]
    #[test]
    fn nothing_panics_and_nothing_infinite_gets_through(
        which in any::<prop::sample::Index>(),
        damages in prop::collection::vec((any::<prop::sample::Index>(), damage()), 1..5),
    ) {
        let files = valid();
        let (name, bytes) = files[which.index(files.len())].clone();
        match read(name, &damaged(bytes, &damages)) {
            Ok(scene) => {
                prop_assert!(scene.triangles.iter().all(Triangle::is_finite));
                prop_assert_eq!(scene.material_ids.len(), scene.triangles.len());
                prop_assert!(scene.material_ids.iter().all(|&id| usize::from(id) < scene.materials.len()));
                let coordinates = scene.texture_coordinates.len();
                prop_assert!(coordinates == 0 || coordinates == scene.triangles.len());
                prop_assert_eq!(scene.objects.last().map(|o| o.triangles.end), Some(scene.triangles.len()));
                prop_assert!(scene.warnings.iter().all(|w| w.lines().count() == 1));
            }
            Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1, "{}", error),
        }
    }
}
