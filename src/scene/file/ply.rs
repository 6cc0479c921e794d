//! PLY, parsed by `ply-rs-bw`: vertices, faces, triangle strips.
//!
//! Elements are read one kind after the other into what they are here, so that a large file is never held as properties.

use super::mesh::{Mesh, strip};
use super::{Parts, Source, malformed, told};
use crate::scene::{Dropped, Material, SceneError};
use glam::Vec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Header, Property, PropertyAccess, PropertyAccessResult};
use std::io::{BufRead, BufReader};
use std::path::Path;

pub(super) fn read(source: &mut Source<'_>) -> Result<Parts, SceneError> {
    let path = source.path;
    let mut reader = Reader::new(BufReader::with_capacity(1 << 16, source.reader()?));
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(|e| fault(path, &e))?;
    let mut file = File { path, reader, header: &header, found: Found::default() };
    for (_, element) in &header.elements {
        file.element(element)?;
    }
    file.found.parts(path)
}

/// A file whose header is read.
struct File<'a, R: BufRead> {
    path: &'a Path,
    reader: Reader<R>,
    header: &'a Header,
    found: Found,
}

#[derive(Default)]
struct Found {
    vertices: Vec<Vec3>,
    faces: Vec<Face>,
    strips: Vec<Face>,
    /// Kinds of elements that say nothing of a surface.
    ignored: Vec<String>,
}

impl<R: BufRead> File<'_, R> {
    fn element(&mut self, element: &ElementDef) -> Result<(), SceneError> {
        if element.properties.is_empty() && element.count > 0 {
            let reason = format!("{} elements '{}' without properties", element.count, element.name.escape_debug());
            return Err(malformed(self.path, None, reason));
        }
        match element.name.as_str() {
            "vertex" => {
                for axis in ["x", "y", "z"] {
                    if !element.properties.contains_key(axis) {
                        return Err(malformed(self.path, None, format!("its vertices have no {axis}")));
                    }
                }
                let vertices: Vec<Vertex> = self.elements(element)?;
                self.found.vertices.extend(vertices.into_iter().map(|vertex| vertex.0));
            }
            "face" => self.found.faces = self.elements(element)?,
            "tristrips" => self.found.strips = self.elements(element)?,
            name => {
                let _: Vec<Skipped> = self.elements(element)?;
                self.found.ignored.push(format!("{} {}", element.count, name.escape_debug()));
            }
        }
        Ok(())
    }

    fn elements<E: PropertyAccess>(&mut self, element: &ElementDef) -> Result<Vec<E>, SceneError> {
        let elements = Parser::<E>::new().read_payload_for_element(&mut self.reader, element, self.header);
        elements.map_err(|e| fault(self.path, &e))
    }
}

impl Found {
    fn parts(self, path: &Path) -> Result<Parts, SceneError> {
        let mut mesh = Mesh::default();
        let mut points_and_lines = 0;
        let mut corners = Vec::new();
        let place = |index: i64, which: usize, what: &str| {
            let found = usize::try_from(index).ok().and_then(|at| self.vertices.get(at));
            found.copied().ok_or_else(|| {
                let there = self.vertices.len();
                malformed(
                    path,
                    None,
                    format!("{what} {which}: vertex index {index} is out of range: there are {there} vertices"),
                )
            })
        };
        mesh.begin("mesh".into());
        for (which, face) in self.faces.iter().enumerate() {
            corners.clear();
            for &index in &face.0 {
                corners.push(place(index, which, "face")?);
            }
            match corners.len() {
                0..3 => points_and_lines += 1,
                _ => mesh.polygon(&corners, &[], 0),
            }
        }
        for (which, band) in self.strips.iter().enumerate() {
            // −1 ends a strip within the list.
            for run in band.0.split(|&index| index == -1) {
                corners.clear();
                for &index in run {
                    corners.push(place(index, which, "strip")?);
                }
                strip(&corners).for_each(|triangle| mesh.polygon(&triangle, &[], 0));
            }
        }
        let mut warnings = Vec::new();
        if !self.ignored.is_empty() {
            warnings.push(format!("elements that have no use here: {}", self.ignored.join(", ")));
        }
        let used = Dropped { points_and_lines, ..Dropped::default() };
        if mesh.triangles.is_empty() && self.faces.is_empty() && self.strips.is_empty() {
            // A point cloud: say what is there instead of triangles.
            let dropped = Dropped { points_and_lines: self.vertices.len(), ..used };
            return Ok(mesh.finish(vec![Material::default()], dropped, warnings));
        }
        Ok(mesh.finish(vec![Material::default()], used, warnings))
    }
}

fn fault(path: &Path, error: &ParseError) -> SceneError {
    let told = told(error);
    let without_line =
        told.strip_prefix("Line ").and_then(|rest| rest.split_once(": ")).map(|(_, reason)| reason.to_owned());
    malformed(path, error.line(), without_line.unwrap_or(told))
}

/// A vertex: its position.
struct Vertex(Vec3);

/// A face or strip: its vertex indices.
#[derive(Default)]
struct Face(Vec<i64>);

/// An element that is passed over.
struct Skipped;

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self(Vec3::NAN)
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(coordinate) = ["x", "y", "z"].iter().position(|axis| *axis == name) else {
            return PropertyAccessResult::Ignored;
        };
        let Some(value) = property.to_f32_lossy() else { return PropertyAccessResult::UnsupportedType };
        self.0[coordinate] = value;
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
