//! Smooth vertex normals.

use super::Scene;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// The normal of what has none: a triangle without area whose vertices no other face shares.
const NOWHERE: Vec3 = Vec3::Y;

/// Unit normals, one per triangle and vertex: the direction of the sum of the cross products of all faces of the same
/// object around the vertex (so each face counts by its area), as the thesis' program has it.
///
/// Vertices are the same where their positions are, bit for bit (−0 equals 0). Sums are in f64, in the order of ids.
/// A sum of exactly zero gives the face's own normal, and +y where the face has none either.
pub fn smooth_normals(scene: &Scene) -> Vec<[Vec3; 3]> {
    let faces: Vec<DVec3> = scene.triangles.iter().map(|t| t.cross()).collect();
    let mut normals: Vec<_> = faces.iter().map(|&face| [unit(face).unwrap_or(NOWHERE); 3]).collect();
    let mut sums: HashMap<[u32; 3], DVec3> = HashMap::new();
    for object in &scene.objects {
        sums.clear();
        for id in object.triangles.clone() {
            for p in scene.triangles[id].v {
                *sums.entry(position_key(p)).or_insert(DVec3::ZERO) += faces[id];
            }
        }
        for id in object.triangles.clone() {
            for (normal, p) in normals[id].iter_mut().zip(scene.triangles[id].v) {
                if let Some(smooth) = sums.get(&position_key(p)).and_then(|&sum| unit(sum)) {
                    *normal = smooth;
                }
            }
        }
    }
    normals
}

/// Bits of a position, the same for −0 and 0.
fn position_key(p: Vec3) -> [u32; 3] {
    (p + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// The direction of `v`; none for zero and for what is not finite.
fn unit(v: DVec3) -> Option<Vec3> {
    v.try_normalize().map(|n| n.as_vec3())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Triangle;
    use crate::scene::assemble::Assembly;
    use crate::scene::thesis;

    fn scene(objects: &[&[[[f64; 3]; 3]]]) -> Scene {
        let mut parts = Assembly::with_limit(objects.iter().map(|o| o.len()).sum());
        for triangles in objects {
            parts.begin("part");
            triangles.iter().for_each(|t| parts.push(t.map(DVec3::from)));
        }
        parts.finish("test", thesis::CAMERA)
    }

    const FLOOR: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// Shares (0, 0, 0), once as −0, and (0, 1, 0); four times the area.
    const WALL: [[f64; 3]; 3] = [[-0.0, 0.0, -0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 4.0]];

    #[test]
    fn faces_count_by_area_within_one_object() {
        let joined = smooth_normals(&scene(&[&[FLOOR, WALL]]));
        let mean = Vec3::new(4.0, 0.0, 1.0).normalize();
        for (id, vertex, expected) in [(0, 0, mean), (0, 2, mean), (0, 1, Vec3::Z), (1, 0, mean), (1, 2, Vec3::X)] {
            assert!((joined[id][vertex] - expected).length() < 1e-6);
        }
        let apart = smooth_normals(&scene(&[&[FLOOR], &[WALL]]));
        assert_eq!(apart, vec![[Vec3::Z; 3], [Vec3::X; 3]]);
    }

    #[test]
    fn what_cancels_or_is_degenerate_still_has_a_unit_normal() {
        let back = [FLOOR[0], FLOOR[2], FLOOR[1]];
        assert_eq!(smooth_normals(&scene(&[&[FLOOR, back]])), vec![[Vec3::Z; 3], [Vec3::NEG_Z; 3]]);
        assert_eq!(smooth_normals(&scene(&[&[[[2.0; 3]; 3]]])), vec![[Vec3::Y; 3]]);
        let mut tiny = scene(&[&[FLOOR]]);
        tiny.triangles[0] = Triangle::new(Vec3::ZERO, Vec3::X * 1e-40, Vec3::Y * 1e-40);
        assert_eq!(smooth_normals(&tiny), vec![[Vec3::Z; 3]]);
        tiny.triangles[0] = Triangle::new(Vec3::ZERO, Vec3::X * f32::MAX, Vec3::Y * f32::MAX);
        assert_eq!(smooth_normals(&tiny), vec![[Vec3::Z; 3]]);
    }

    #[test]
    fn the_thesis_scene_has_unit_normals() {
        let scene = thesis::generate(thesis::Level::Large);
        let normals = smooth_normals(&scene);
        assert_eq!(normals.len(), scene.triangles.len());
        assert!(normals.iter().flatten().all(|n| (n.length() - 1.0).abs() < 1e-6));
    }
}
