//! A tree for other programs' eyes: as JSON, and its boxes level by level as Wavefront OBJ.

use super::{Bvh, NodeKind};
use crate::geom::Aabb;
use serde::Serialize;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Why a tree was not exported.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}: {source}", path = .path.display())]
pub struct ExportError {
    /// The file.
    pub path: PathBuf,
    /// What the system said.
    pub source: io::Error,
}

/// The whole tree.
#[derive(Serialize)]
struct Tree {
    arity: usize,
    nodes: Vec<JsonNode>,
}

/// One node: an inner one has `children`, a leaf has `triangles`.
#[derive(Serialize)]
struct JsonNode {
    /// 0 for the root.
    level: u32,
    min: [f32; 3],
    max: [f32; 3],
    /// Indices of nodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    children: Option<Vec<usize>>,
    /// Ids of triangles.
    #[serde(skip_serializing_if = "Option::is_none")]
    triangles: Option<Vec<u32>>,
}

/// Writes `{"arity": k, "nodes": […]}`: nodes in the tree's order, the root first, each with its `level` (the root's is 0), the
/// corners `min` and `max` of its box in scene units, and either `children`, indices of nodes, or `triangles`, ids.
///
/// # Errors
/// [`ExportError`] where the system refuses.
pub fn export_json(bvh: &Bvh, path: &Path) -> Result<(), ExportError> {
    let node = |(index, level): (usize, u32)| {
        let node = &bvh.nodes[index];
        let (children, triangles) = match node.kind() {
            NodeKind::Inner(children) => (Some(children.collect()), None),
            NodeKind::Leaf(slots) => (None, Some(bvh.triangle_ids[slots].to_vec())),
        };
        JsonNode { level, min: node.aabb.min.into(), max: node.aabb.max.into(), children, triangles }
    };
    let nodes = levels(bvh).into_iter().enumerate().map(node).collect();
    let tree = Tree { arity: bvh.arity, nodes };
    write(path, |out| serde_json::to_writer(out, &tree).map_err(io::Error::from))
}

/// Writes every box that holds something as six quads: one object a level, `level0` the root, so that a modeller can show and
/// hide levels.
///
/// # Errors
/// [`ExportError`] where the system refuses.
pub fn export_boxes(bvh: &Bvh, path: &Path) -> Result<(), ExportError> {
    let levels = levels(bvh);
    let mut by_level: Vec<usize> = (0..levels.len()).filter(|&index| bvh.nodes[index].aabb.is_valid()).collect();
    by_level.sort_by_key(|&index| levels[index]);
    write(path, |out| {
        let mut open = None;
        for (place, &index) in by_level.iter().enumerate() {
            if open.replace(levels[index]) != Some(levels[index]) {
                writeln!(out, "o level{}", levels[index])?;
            }
            write_box(out, &bvh.nodes[index].aabb, 8 * place + 1)?;
        }
        Ok(())
    })
}

/// Eight vertices, the first of them number `first`, and six quads, counter-clockwise from outside.
fn write_box(out: &mut impl Write, b: &Aabb, first: usize) -> io::Result<()> {
    const SIDES: [[usize; 4]; 6] = [[4, 5, 7, 6], [0, 2, 3, 1], [1, 3, 7, 5], [0, 4, 6, 2], [2, 6, 7, 3], [0, 1, 5, 4]];
    for corner in 0..8 {
        let [x, y, z] = [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { b.min[axis] } else { b.max[axis] });
        writeln!(out, "v {x} {y} {z}")?;
    }
    for side in SIDES {
        let [p, q, r, s] = side.map(|corner| first + corner);
        writeln!(out, "f {p} {q} {r} {s}")?;
    }
    Ok(())
}

/// The level of every node; children stand behind their parents.
fn levels(bvh: &Bvh) -> Vec<u32> {
    let mut levels = vec![0; bvh.nodes.len()];
    for index in 0..bvh.nodes.len() {
        for child in bvh.children(index) {
            levels[child] = levels[index] + 1;
        }
    }
    levels
}

fn write(path: &Path, body: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<(), ExportError> {
    let written = File::create(path).map(BufWriter::new).and_then(|mut out| {
        body(&mut out)?;
        out.flush()
    });
    written.map_err(|source| ExportError { path: path.into(), source })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::soup;
    use crate::scene::Scene;
    use crate::trace::testing::median_split;

    #[test]
    fn json_has_every_box_child_and_triangle() {
        let bvh = median_split(&soup(3, 50, 0.2), 4);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tree.json");
        export_json(&bvh, &path).unwrap();
        let tree: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        let nodes = tree["nodes"].as_array().unwrap();
        assert_eq!((tree["arity"].as_u64(), nodes.len()), (Some(4), bvh.nodes.len()));
        let mut triangles = Vec::new();
        for (index, node) in nodes.iter().enumerate() {
            let min: [f32; 3] = serde_json::from_value(node["min"].clone()).unwrap();
            assert_eq!(min, bvh.nodes[index].aabb.min.to_array());
            assert!(node["children"].is_array() != node["triangles"].is_array());
            for child in node["children"].as_array().into_iter().flatten() {
                let child = child.as_u64().unwrap() as usize;
                assert_eq!(nodes[child]["level"].as_u64(), node["level"].as_u64().map(|level| level + 1));
            }
            triangles.extend(node["triangles"].as_array().into_iter().flatten().map(|id| id.as_u64().unwrap()));
        }
        triangles.sort_unstable();
        assert!(triangles.into_iter().eq(0..50));
    }

    #[test]
    fn boxes_come_back_as_objects_by_level() {
        let bvh = median_split(&soup(3, 50, 0.2), 2);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("boxes.obj");
        export_boxes(&bvh, &path).unwrap();
        let scene = Scene::load(path.to_str().unwrap()).unwrap();
        assert_eq!(scene.triangles.len(), 12 * bvh.nodes.len());
        let depth = *levels(&bvh).iter().max().unwrap() as usize;
        assert_eq!(scene.objects.len(), depth + 1);
        assert_eq!((scene.objects[0].name.as_str(), scene.objects[0].triangles.len()), ("level0", 12));
        assert_eq!(scene.bounds(), bvh.root().aabb);
        let extent = bvh.root().aabb.extent();
        let root: f64 = scene.triangles[..12].iter().map(|t| t.area()).sum();
        let area = 2.0 * (extent.x * extent.y + extent.y * extent.z + extent.z * extent.x);
        assert!((root / area - 1.0).abs() < 1e-6);
        let outwards = scene.triangles[..12].iter().all(|t| {
            let middle = t.v.iter().map(|p| p.as_dvec3()).sum::<glam::DVec3>() / 3.0;
            t.cross().dot(middle - bvh.root().aabb.centre()) > 0.0
        });
        assert!(outwards);
    }

    #[test]
    fn a_place_that_cannot_be_written_is_told() {
        let bvh = median_split(&soup(3, 5, 0.2), 2);
        for export in [export_json, export_boxes] {
            let error = export(&bvh, Path::new("no/such/folder/x")).unwrap_err().to_string();
            assert!(error.starts_with("cannot write no/such/folder/x: "), "{error}");
        }
    }
}
