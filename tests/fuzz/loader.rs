//! A file of any format from bytes: a scene that is what the library promises, or an error in one line.

use bvh_lab::bvh::file;
use bvh_lab::geom::Triangle;
use bvh_lab::scene::Scene;
use std::path::Path;
use std::sync::LazyLock;

/// Endings, by the first byte; `bvh` is a tree over [`SCENE`].
pub const ENDINGS: [&str; 9] = ["obj", "tri", "ply", "stl", "gltf", "glb", "obj.gz", "ply.zst", "bvh"];

/// What trees are read for.
pub static SCENE: LazyLock<Vec<Triangle>> =
    LazyLock::new(|| Scene::load("gen:soup:9").expect("a generated scene").triangles);

/// One execution; the file is written into `folder`.
///
/// # Panics
/// On what must not be.
pub fn run(folder: &Path, data: &[u8]) {
    let Some((&first, content)) = data.split_first() else { return };
    let ending = ENDINGS[usize::from(first) % ENDINGS.len()];
    let path = folder.join(format!("input.{ending}"));
    let mut content = content.to_vec();
    if ending == "bvh" && content.len() > 4 {
        // A wrong checksum would be all that is ever found.
        let end = content.len() - 4;
        let sum = crc32fast::hash(&content[..end]);
        content[end..].copy_from_slice(&sum.to_le_bytes());
    }
    std::fs::write(&path, content).expect("room for a small file");
    if ending == "bvh" {
        tree(&path);
    } else {
        scene(&path);
    }
}

fn tree(path: &Path) {
    if let Err(e) = file::read(path, &SCENE) {
        one_line(&e.to_string());
    }
    match file::read_unfitted(path) {
        Ok(mut tree) if tree.scene.triangles == SCENE.len() => {
            let boxes: Vec<_> = SCENE.iter().map(Triangle::aabb).collect();
            bvh_lab::refine::refit(&mut tree.bvh, &boxes);
        }
        Ok(_) => {}
        Err(e) => one_line(&e.to_string()),
    }
}

fn scene(path: &Path) {
    let scene = match Scene::load(path.to_str().expect("a name of ours")) {
        Ok(scene) => scene,
        Err(e) => return one_line(&e.to_string()),
    };
    let n = scene.triangles.len();
    assert!(n > 0 && scene.triangles.iter().all(Triangle::is_finite));
    assert!(scene.material_ids.len() == n && !scene.materials.is_empty());
    assert!(scene.material_ids.iter().all(|&id| usize::from(id) < scene.materials.len()));
    assert!(scene.texture_coordinates.is_empty() || scene.texture_coordinates.len() == n);
    scene.warnings.iter().for_each(|warning| one_line(warning));
}

fn one_line(message: &str) {
    assert!(!message.is_empty() && !message.contains('\n'), "{message:?}");
}
