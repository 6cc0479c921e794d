//! Wavefront OBJ, read here line by line.
//!
//! `tobj`, which read it once, names no line in its errors, makes triangles of points and lines, panics on short colours,
//! and refuses trailing comments, continuations, byte order marks, vertices that are partly coloured and faces before their
//! vertices. Handing it a plain rewriting of the file took parsing everything twice and several times the file in memory;
//! as the first parse knows all that is needed, the second is gone. Tests hold the reader to what `tobj` makes of plain files.

mod mtl;
mod numbers;
mod parse;

use super::text::{self, Lines};
use super::{Parts, Source};
use crate::scene::{Dropped, SceneError};
use mtl::Library;
pub(super) use mtl::shininess_of;
use parse::Parser;

pub(super) fn read(source: &mut Source<'_>) -> Result<Parts, SceneError> {
    let mut reading = Reading::default();
    reading.run(source)?;
    if reading.missed_texture {
        // Textures turned up after coordinates and faces had been passed over: once more, with them.
        reading = Reading::default();
        reading.parser.with_texture = true;
        reading.run(source)?;
    }
    Ok(reading.finish())
}

/// A file that is being read.
#[derive(Default)]
struct Reading {
    parser: Parser,
    library: Library,
    /// Whether texture coordinates are wanted that were passed over.
    missed_texture: bool,
    warnings: Vec<String>,
}

impl Reading {
    fn run(&mut self, source: &mut Source<'_>) -> Result<(), SceneError> {
        let path = source.path;
        let mut lines = Lines::new(source.reader()?);
        while let Some(line) = lines.next().map_err(|fault| super::unreadable(path, fault))? {
            let (keyword, rest) = line.split();
            if keyword == b"mtllib" {
                self.library.add(path, line.number, &text::decode(rest), &mut self.warnings);
                if self.library.has_textures() && !self.parser.with_texture {
                    self.parser.with_texture = !self.parser.is_under_way;
                    self.missed_texture = self.parser.is_under_way;
                }
                continue;
            }
            self.parser.statement(keyword, rest, &line).map_err(|fault| fault.into_error(path))?;
        }
        self.parser.finish().map_err(|fault| fault.into_error(path))
    }

    fn finish(self) -> Parts {
        let Self { parser, library, mut warnings, .. } = self;
        let (materials, ids) = library.scene_materials(&parser.materials, &mut warnings);
        for ((line, name), _) in parser.materials.iter().zip(&ids).filter(|(_, id)| id.is_none()) {
            let name = name.escape_debug();
            warnings.push(format!("line {line}: material '{name}' is not defined; the default material is used"));
        }
        parser.account(&mut warnings);
        let mut mesh = parser.mesh;
        for slot in &mut mesh.material_ids {
            *slot = slot.checked_sub(1).and_then(|at| ids[usize::from(at)]).unwrap_or(0);
        }
        let is_used = |id: u16| {
            materials[usize::from(id)].diffuse_map.is_some() || materials[usize::from(id)].opacity_map.is_some()
        };
        if !mesh.material_ids.iter().any(|&id| is_used(id)) {
            mesh.texture_coordinates = Vec::new();
        }
        let dropped = Dropped { points_and_lines: parser.points_and_lines, ..Dropped::default() };
        mesh.finish(materials, dropped, warnings)
    }
}
