//! The statements of an OBJ file, line by line.

use super::super::mesh::Mesh;
use super::super::text::{self, Line};
use super::numbers::{integer, number};
use crate::scene::Object;
use crate::scene::SceneError;
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// What stands for the material name where a `usemtl` or `newmtl` has none.
pub(super) const NAMELESS: &str = "(nameless)";

/// What makes a file useless, and where.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) line: usize,
    pub(super) reason: String,
}

impl Fault {
    fn at(line: &Line<'_>, reason: impl Into<String>) -> Self {
        Self { line: line.number, reason: reason.into() }
    }

    pub(super) fn into_error(self, path: &std::path::Path) -> SceneError {
        super::super::malformed(path, Some(self.line), self.reason)
    }
}

/// What a file holds, and where the reading of it is.
#[derive(Debug, Default)]
pub(super) struct Parser {
    vertices: Vec<Vec3>,
    texture: Vec<Vec2>,
    /// Material ids are places in `materials`, from 1; 0 is no material.
    pub(super) mesh: Mesh,
    /// Names of the materials asked for, each with the first line that does.
    pub(super) materials: Vec<(usize, String)>,
    material_slots: HashMap<String, u16>,
    material: u16,
    /// Materials asked for beyond what an id can tell.
    pub(super) homeless: usize,
    /// Whether texture coordinates are read.
    pub(super) with_texture: bool,
    /// Whether there has been a texture coordinate or a face.
    pub(super) is_under_way: bool,
    /// Elements that are no polygons: `p`, `l`, and `f` with one or two vertices.
    pub(super) points_and_lines: usize,
    /// Curves and surfaces.
    pub(super) free_form: usize,
    /// Numbers in odd spellings, and the first of them.
    pub(super) repaired: usize,
    first_repaired: Option<(usize, String)>,
    /// Corners whose texture coordinate is missing or does not exist, of faces that have some.
    pub(super) lost_texture: usize,
    /// The name of an object that has no faces yet.
    object: Option<String>,
    /// The highest positive index so far, and its line.
    highest: (u64, usize),
    /// Faces that stand before their vertices: the first of their triangles, and their corners.
    ahead: Vec<(usize, Vec<Corner>)>,
    corners: Vec<Corner>,
    positions: Vec<Vec3>,
    coordinates: Vec<Vec2>,
}

/// A corner of a face; places count from 0.
#[derive(Clone, Copy, Debug)]
struct Corner {
    vertex: u64,
    texture: Option<u64>,
}

impl Parser {
    /// A statement that this format knows; `mtllib` is the caller's.
    #[inline]
    pub(super) fn statement(&mut self, keyword: &[u8], rest: &[u8], line: &Line<'_>) -> Result<(), Fault> {
        match keyword {
            b"v" => return self.vertex(rest, line),
            b"f" => return self.face(rest, line),
            b"vt" => {
                self.is_under_way = true;
                if self.with_texture {
                    self.texture_coordinate(rest, line)?;
                }
            }
            b"p" | b"l" => self.points_and_lines += 1,
            b"o" | b"g" => self.object = Some(text::decode(rest).into_owned()),
            b"usemtl" => self.use_material(&text::decode(rest), line.number),
            b"curv" | b"curv2" | b"surf" => self.free_form += 1,
            _ => {}
        }
        Ok(())
    }

    fn number(&mut self, word: &[u8], line: &Line<'_>) -> Result<f32, Fault> {
        match number(word) {
            Some((value, false)) => Ok(value),
            Some((value, true)) => {
                self.repaired += 1;
                let first = || (line.number, text::decode(word).into_owned());
                self.first_repaired.get_or_insert_with(first);
                Ok(value)
            }
            None => Err(Fault::at(line, format!("'{}' is not a number", text::decode(word).escape_debug()))),
        }
    }

    #[inline]
    fn vertex(&mut self, rest: &[u8], line: &Line<'_>) -> Result<(), Fault> {
        let mut words = text::words(rest);
        let mut point = [0.0; 3];
        for coordinate in &mut point {
            let word = words.next().ok_or_else(|| Fault::at(line, "a vertex needs three numbers"))?;
            *coordinate = self.number(word, line)?;
        }
        self.vertices.push(point.into());
        Ok(())
    }

    fn texture_coordinate(&mut self, rest: &[u8], line: &Line<'_>) -> Result<(), Fault> {
        let mut words = text::words(rest);
        let word = words.next().ok_or_else(|| Fault::at(line, "a texture coordinate needs a number"))?;
        let u = self.number(word, line)?;
        let v = words.next().map_or(Ok(0.0), |word| self.number(word, line))?;
        let point = Vec2::new(u, v);
        self.texture.push(if point.is_finite() { point } else { Vec2::ZERO });
        Ok(())
    }

    fn use_material(&mut self, name: &str, line: usize) {
        let name = if name.is_empty() { NAMELESS } else { name };
        if let Some(&slot) = self.material_slots.get(name) {
            self.material = slot;
            return;
        }
        let Ok(slot) = u16::try_from(self.materials.len() + 1) else {
            self.homeless += 1;
            self.material = 0;
            return;
        };
        self.materials.push((line, name.to_owned()));
        self.material_slots.insert(name.to_owned(), slot);
        self.material = slot;
    }

    #[inline]
    fn face(&mut self, rest: &[u8], line: &Line<'_>) -> Result<(), Fault> {
        self.is_under_way = true;
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        for word in text::words(rest) {
            corners.push(self.corner(word, line)?);
        }
        match corners.len() {
            0 => return Err(Fault::at(line, "a face without vertices")),
            1 | 2 => self.points_and_lines += 1,
            _ => self.polygon(&corners),
        }
        self.corners = corners;
        Ok(())
    }

    #[inline]
    fn polygon(&mut self, corners: &[Corner]) {
        if let Some(name) = self.object.take().or(self.mesh.objects.is_empty().then(String::new)) {
            self.mesh.begin(if name.is_empty() { "unnamed".to_owned() } else { name });
        }
        let start = self.mesh.triangles.len();
        if corners.iter().all(|corner| corner.vertex < self.vertices.len() as u64) {
            self.look_up(corners);
        } else {
            // The vertices are still to come: NaN holds the place of as many triangles.
            self.positions.clear();
            self.positions.resize(corners.len(), Vec3::NAN);
            self.coordinates.clear();
            self.coordinates.resize(if self.with_texture { corners.len() } else { 0 }, Vec2::ZERO);
            self.ahead.push((start, corners.to_vec()));
        }
        self.mesh.polygon(&self.positions, &self.coordinates, self.material);
    }

    /// Positions and texture coordinates of corners whose vertices are there.
    #[inline]
    fn look_up(&mut self, corners: &[Corner]) {
        self.positions.clear();
        self.positions.extend(corners.iter().map(|corner| self.vertices[corner.vertex as usize]));
        self.coordinates.clear();
        if !self.with_texture {
            return;
        }
        let has_some = corners.iter().any(|corner| corner.texture.is_some());
        for corner in corners {
            let found = corner.texture.and_then(|at| self.texture.get(usize::try_from(at).ok()?));
            self.lost_texture += usize::from(has_some && found.is_none());
            self.coordinates.push(found.copied().unwrap_or_default());
        }
    }

    /// A corner such as `7`, `-1` or `7/1/3`.
    #[inline]
    fn corner(&mut self, word: &[u8], line: &Line<'_>) -> Result<Corner, Fault> {
        let end = word.iter().position(|&byte| byte == b'/').unwrap_or(word.len());
        let (index, others) = word.split_at(end);
        let Some(value) = integer(index) else {
            return Err(self.no_index(word, index, line));
        };
        let vertex = match value {
            1.. => value as u64 - 1,
            _ => match (self.vertices.len() as i64).checked_add(value) {
                Some(place @ 0..) if value < 0 => place as u64,
                _ => return Err(out_of_range(line.number, &text::decode(index), self.vertices.len())),
            },
        };
        if vertex >= self.highest.0 {
            self.highest = (vertex + 1, line.number);
        }
        let mut corner = Corner { vertex, texture: None };
        if self.with_texture
            && let Some(others) = others.get(1..)
        {
            let end = others.iter().position(|&byte| byte == b'/').unwrap_or(others.len());
            corner.texture = match integer(&others[..end]) {
                Some(place @ 1..) => Some(place as u64 - 1),
                Some(back) => (self.texture.len() as i64).checked_add(back).and_then(|place| place.try_into().ok()),
                None => None,
            };
        }
        Ok(corner)
    }

    #[cold]
    fn no_index(&self, word: &[u8], index: &[u8], line: &Line<'_>) -> Fault {
        let digits = index.strip_prefix(b"-").or(index.strip_prefix(b"+")).unwrap_or(index);
        if !digits.is_empty() && digits.iter().all(u8::is_ascii_digit) {
            return out_of_range(line.number, &text::decode(index), self.vertices.len());
        }
        Fault::at(line, format!("'{}' is not a vertex index", text::decode(word).escape_debug()))
    }

    /// Gives the faces that stood before their vertices their places.
    ///
    /// # Errors
    /// An index that is no vertex's.
    pub(super) fn finish(&mut self) -> Result<(), Fault> {
        if self.highest.0 > self.vertices.len() as u64 {
            return Err(out_of_range(self.highest.1, &self.highest.0.to_string(), self.vertices.len()));
        }
        for (start, corners) in std::mem::take(&mut self.ahead) {
            self.look_up(&corners);
            let mut own = Mesh { objects: vec![Object { name: String::new(), triangles: 0..0 }], ..Mesh::default() };
            own.polygon(&self.positions, &self.coordinates, 0);
            let places = start..start + own.triangles.len();
            self.mesh.triangles[places.clone()].copy_from_slice(&own.triangles);
            if self.with_texture {
                self.mesh.texture_coordinates[places].copy_from_slice(&own.texture_coordinates);
            }
        }
        Ok(())
    }

    /// What was repaired or left out, a line each.
    pub(super) fn account(&self, warnings: &mut Vec<String>) {
        if let Some((line, word)) = &self.first_repaired {
            let (count, word) = (self.repaired, word.escape_debug());
            warnings
                .push(format!("{count} numbers in odd spellings were understood, the first in line {line}: '{word}'"));
        }
        if self.free_form > 0 {
            warnings.push(format!("{} free-form curves or surfaces are ignored", self.free_form));
        }
        if self.lost_texture > 0 {
            warnings.push(format!("{} corners of textured faces have no texture coordinate", self.lost_texture));
        }
        if self.homeless > 0 {
            let most = self.materials.len();
            warnings.push(format!("more than {most} materials; the last {} are taken for the default", self.homeless));
        }
    }
}

fn out_of_range(line: usize, index: &str, vertices: usize) -> Fault {
    Fault {
        line,
        reason: match vertices {
            0 => format!("vertex index {index}, but there are no vertices"),
            _ if index == "0" => "vertex index 0; indices count from 1, or backwards from -1".into(),
            _ => format!("vertex index {index} is out of range: there are {vertices} vertices"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::text::Lines;
    use super::*;

    fn parsed(text: &str, with_texture: bool) -> Result<Parser, Fault> {
        let mut parser = Parser { with_texture, ..Parser::default() };
        let mut lines = Lines::new(text.as_bytes());
        while let Some(line) = lines.next().unwrap() {
            let (keyword, rest) = line.split();
            parser.statement(keyword, rest, &line)?;
        }
        parser.finish().map(|()| parser)
    }

    #[test]
    fn what_is_odd_is_read_plainly() {
        let text = "g\nf 1/1/1 -1 3//2 # ahead\nv 0 0 0 1 1 1\nv 1 2 3 0.5\nv 3,5 1.D0 -0\nf -3 -2 \\\n-1 1\nusemtl a b\nl 1 2\np 1\nf 1 2\n";
        // An index from behind counts from the vertices seen so far: there are none yet at the first face.
        let fault = parsed(text, false).unwrap_err();
        assert_eq!((fault.line, fault.reason.as_str()), (2, "vertex index -1, but there are no vertices"));
        let file = parsed(&text.replacen("-1", "2", 1), false).unwrap();
        let [a, b, c] = [Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0), Vec3::new(3.5, 1.0, 0.0)];
        assert_eq!(file.mesh.triangles.iter().map(|t| t.v).collect::<Vec<_>>(), [[a, b, c], [a, b, c], [a, c, a]]);
        assert_eq!(file.mesh.objects, [Object { name: "unnamed".into(), triangles: 0..3 }]);
        assert_eq!((file.points_and_lines, file.repaired), (3, 2));
        assert_eq!(file.materials, [(8, "a b".to_owned())]);
        let mut told = Vec::new();
        file.account(&mut told);
        assert_eq!(told, ["2 numbers in odd spellings were understood, the first in line 5: '3,5'"]);
    }

    #[test]
    fn texture_coordinates_belong_to_corners() {
        let text = "vt 0\nvt 1 0.5\nf 1/1 2/2 3/-1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt nan 1\nf 1/2/9 2/-1 3/9\nf 1 2 3\n";
        let file = parsed(text, true).unwrap();
        let (zero, half) = (Vec2::ZERO, Vec2::new(1.0, 0.5));
        assert_eq!(file.mesh.texture_coordinates, [[zero, half, half], [half, zero, zero], [zero; 3]]);
        assert_eq!(file.lost_texture, 1);
        assert!(parsed(text, false).unwrap().mesh.texture_coordinates.is_empty());
        assert_eq!(parsed("vt\n", true).unwrap_err().line, 1);
    }

    #[test]
    fn faults_name_their_line() {
        for (text, line, reason) in [
            ("v 0 0 0\nv 0 0", 2, "three numbers"),
            ("v 0 1.#IND 0", 1, "'1.#IND' is not a number"),
            ("v 0 0 0\nf", 2, "without vertices"),
            ("v 0 0 0\nf 1 1 x", 2, "'x' is not a vertex index"),
            ("v 0 0 0\nf 1 1 /1", 2, "'/1' is not a vertex index"),
            ("v 0 0 0\nf 0 1 1", 2, "index 0"),
            ("v 0 0 0\nf 1 1 -2", 2, "out of range"),
            ("v 0 0 0\n\nf 1 1 5\nf 1 1 3", 3, "index 5 is out of range: there are 1 vertices"),
            ("v 0 0 0\nf 1 1 99999999999999999999999999", 2, "out of range"),
            ("v 0 0 0\nf 1 1 -9223372036854775808", 2, "out of range"),
            ("v 0 0 0\nf 9 9", 2, "out of range"),
        ] {
            let fault = parsed(text, false).expect_err(text);
            assert_eq!(fault.line, line, "{text}");
            assert!(fault.reason.contains(reason), "{text}: {}", fault.reason);
        }
    }
}
