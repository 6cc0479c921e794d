//! Wavefront OBJ: repaired here, parsed by `tobj`, triangulated here.
//!
//! `tobj` alone names no line in its errors, makes triangles of points and lines, panics on short colours, and refuses
//! trailing comments, continuations, byte order marks, vertices that are partly coloured and faces before their
//! vertices. So it is handed a plain rewriting of the file (see [`repair`]) in which all of that is settled.

mod mtl;
mod polygon;
mod repair;

use super::{Parts, malformed, text};
use crate::geom::Triangle;
use crate::scene::{Dropped, Object, SceneError};
use glam::Vec3;
use mtl::Library;
use std::io::Read;
use std::path::Path;

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Parts, SceneError> {
    let text = text::decode(bytes).map_err(|reason| malformed(path, None, reason))?;
    let mut file = repair::repair(&text).map_err(|fault| malformed(path, Some(fault.line), fault.reason))?;
    let mut warnings = std::mem::take(&mut file.warnings);
    let library = Library::load(path, &file.libraries, &mut warnings);
    for (line, name) in &file.materials {
        if !library.has(name) {
            let name = name.escape_debug();
            warnings.push(format!("line {line}: material '{name}' is not defined; the default material is used"));
        }
    }
    let models = parse(&file, &library).map_err(|error| malformed(path, None, format!("tobj refuses it: {error}")))?;
    let (materials, ids) = library.scene_materials(&mut warnings);
    let mut parts = Parts {
        triangles: Vec::new(),
        objects: Vec::new(),
        materials,
        material_ids: Vec::new(),
        dropped: Dropped { not_finite: 0, points_and_lines: file.points_and_lines },
        warnings,
    };
    // A change of material starts a new model of the same object; objects are numbered in the rewriting, so that
    // two objects of one name stay two.
    let mut current = None;
    for model in &models {
        let start = parts.triangles.len();
        parts.dropped.not_finite += add_faces(&mut parts.triangles, &model.mesh);
        let end = parts.triangles.len();
        if start == end {
            continue;
        }
        let id = model.mesh.material_id.and_then(|index| ids.get(index));
        parts.material_ids.resize(end, id.copied().unwrap_or(0));
        match parts.objects.last_mut() {
            Some(object) if current == Some(&model.name) => object.triangles.end = end,
            _ => parts.objects.push(Object { name: file.object_name(&model.name), triangles: start..end }),
        }
        current = Some(&model.name);
    }
    Ok(parts)
}

/// Has `tobj` parse the rewriting: the vertices first, so that faces may stand before theirs.
fn parse(file: &repair::Repaired, library: &Library) -> Result<Vec<tobj::Model>, tobj::LoadError> {
    let options = tobj::LoadOptions { single_index: true, triangulate: false, ..Default::default() };
    let vertices = file.vertices.as_bytes().chain(b"mtllib all\n".as_slice());
    let mut reader = vertices.chain(file.elements.as_bytes());
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, |_| {
        Ok((library.materials.clone(), library.index.clone().into_iter().collect()))
    })?;
    Ok(models)
}

/// Adds a mesh's faces, cut into triangles; returns how many were dropped because a vertex is not finite.
fn add_faces(triangles: &mut Vec<Triangle>, mesh: &tobj::Mesh) -> usize {
    let position = |index: u32| Vec3::from_slice(&mesh.positions[3 * index as usize..][..3]);
    let mut dropped = 0;
    let mut add = |corners: &[Vec3]| {
        polygon::triangulate(corners, |triangle| {
            if triangle.is_finite() {
                triangles.push(triangle);
            } else {
                dropped += 1;
            }
        });
    };
    if mesh.face_arities.is_empty() {
        for corners in mesh.indices.as_chunks::<3>().0 {
            add(&corners.map(position));
        }
        return dropped;
    }
    let (mut rest, mut corners) = (mesh.indices.as_slice(), Vec::new());
    for &arity in &mesh.face_arities {
        let (face, tail) = rest.split_at(arity as usize);
        rest = tail;
        corners.clear();
        corners.extend(face.iter().map(|&index| position(index)));
        add(&corners);
    }
    dropped
}
