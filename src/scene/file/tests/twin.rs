//! The OBJ reader beside `tobj`, on files so plain that it reads them.

use super::*;
use proptest::prelude::*;

/// Triangles as `tobj` reads them: plain indices, no fans.
fn by_tobj(text: &str) -> Vec<Triangle> {
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..Default::default() };
    let none = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, none).unwrap();
    models
        .iter()
        .flat_map(|model| {
            let place = |&index: &u32| Vec3::from_slice(&model.mesh.positions[3 * index as usize..][..3]);
            model
                .mesh
                .indices
                .as_chunks::<3>()
                .0
                .iter()
                .map(|corners| Triangle { v: corners.each_ref().map(place) })
                .collect::<Vec<_>>()
        })
        .collect()
}

proptest! {
    #[test]
    fn plain_files_are_read_alike(
        vertices in prop::collection::vec(prop::array::uniform3(-1e6_f32..1e6), 4..40),
        faces in prop::collection::vec((prop::array::uniform3(0..1_000_usize), 0..6_usize), 1..40),
    ) {
        let mut text = String::new();
        for [x, y, z] in &vertices {
            text += &format!("v {x} {y:e} {z}\n");
        }
        for (i, (corners, kind)) in faces.iter().enumerate() {
            let n = vertices.len();
            let [a, b, c] = corners.map(|corner| corner % n);
            text += &match kind {
                0 => format!("o part{i}\nf {} {} {}\n", a + 1, b + 1, c + 1),
                1 => format!("f {} {} {}\n", a as i64 - n as i64, b as i64 - n as i64, c as i64 - n as i64),
                2 => format!("g group{i}\nf {}//1 {}//1 {}//1\nvn 0 0 1\n", a + 1, b + 1, c + 1),
                _ => format!("f {} {} {}\n", a + 1, b + 1, c + 1),
            };
        }
        let text = format!("vn 0 0 1\n{text}");
        prop_assert_eq!(obj(&text, &[]).unwrap().triangles, by_tobj(&text));
    }
}
