//! Rewrites an OBJ file as plainly as the format allows, and finds what is wrong with it, by line.

use super::super::text::{self, Line};
use std::collections::HashSet;
use std::fmt::Write;

/// What stands for the material name where a `usemtl` or `newmtl` has none.
pub(super) const NAMELESS: &str = "(nameless)";

/// A plain rewriting: only vertices of three numbers, faces of positive vertex indices, objects and materials.
#[derive(Debug, Default)]
pub(super) struct Repaired {
    /// All `v` lines.
    pub(super) vertices: String,
    /// All `f`, `o` (with a number into `objects`) and `usemtl` lines.
    pub(super) elements: String,
    /// Names of the objects (`o` and `g` alike) that have faces.
    pub(super) objects: Vec<String>,
    /// Arguments of the `mtllib` lines, with the lines.
    pub(super) libraries: Vec<(usize, String)>,
    /// Names of the materials asked for, each with the first line that does.
    pub(super) materials: Vec<(usize, String)>,
    /// Elements that are no polygons: `p`, `l`, and `f` with one or two vertices.
    pub(super) points_and_lines: usize,
    /// What was ignored.
    pub(super) warnings: Vec<String>,
}

impl Repaired {
    /// The name of the object that the rewriting numbers so.
    pub(super) fn object_name(&self, number: &str) -> String {
        let index = number.parse::<usize>().ok();
        index.and_then(|index| self.objects.get(index)).map_or_else(|| number.to_owned(), Clone::clone)
    }
}

/// What makes a file useless, and where.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) line: usize,
    pub(super) reason: String,
}

/// Reads the vertices' positions (no weights, no colours) and the faces' vertex indices (no texture coordinates, no
/// normals); a face may stand before its vertices.
///
/// # Errors
/// A vertex that is no three numbers, a face without vertices, an index that is no vertex's.
pub(super) fn repair(text: &str) -> Result<Repaired, Fault> {
    let mut file = Repaired::default();
    let mut state = State::default();
    for line in text::lines(text) {
        match line.keyword() {
            "v" => state.vertex(&line, &mut file)?,
            "f" => state.face(&line, &mut file)?,
            "p" | "l" => file.points_and_lines += 1,
            "o" | "g" => state.object = Some(line.rest().to_owned()),
            "usemtl" => {
                let name = if line.rest().is_empty() { NAMELESS } else { line.rest() };
                if state.materials.insert(name.to_owned()) {
                    file.materials.push((line.number, name.to_owned()));
                }
                write_line(&mut file.elements, format_args!("usemtl {name}"));
            }
            "mtllib" => file.libraries.push((line.number, line.rest().to_owned())),
            "curv" | "curv2" | "surf" => state.free_form += 1,
            _ => {}
        }
    }
    if state.highest.0 > state.vertices {
        return Err(out_of_range(state.highest.1, &state.highest.0.to_string(), state.vertices));
    }
    if state.free_form > 0 {
        file.warnings.push(format!("{} free-form curves or surfaces are ignored", state.free_form));
    }
    Ok(file)
}

#[derive(Default)]
struct State {
    vertices: u64,
    /// The highest positive index so far, and its line.
    highest: (u64, usize),
    /// The name of an object that has no faces yet.
    object: Option<String>,
    materials: HashSet<String>,
    free_form: usize,
}

impl State {
    fn vertex(&mut self, line: &Line<'_>, file: &mut Repaired) -> Result<(), Fault> {
        let mut coordinates = line.words();
        file.vertices.push('v');
        for _ in 0..3 {
            let word = coordinates
                .next()
                .ok_or_else(|| Fault { line: line.number, reason: "a vertex needs three numbers".into() })?;
            word.parse::<f32>().map_err(|_| Fault {
                line: line.number,
                reason: format!("'{}' is not a number", word.escape_debug()),
            })?;
            file.vertices.push(' ');
            file.vertices.push_str(word);
        }
        file.vertices.push('\n');
        self.vertices += 1;
        Ok(())
    }

    fn face(&mut self, line: &Line<'_>, file: &mut Repaired) -> Result<(), Fault> {
        let count = line.words().count();
        if count == 0 {
            return Err(Fault { line: line.number, reason: "a face without vertices".into() });
        }
        let is_polygon = count > 2;
        if !is_polygon {
            file.points_and_lines += 1;
        } else if let Some(name) = self.object.take().or(file.objects.is_empty().then(String::new)) {
            let name = if name.is_empty() { "unnamed".to_owned() } else { name };
            write_line(&mut file.elements, format_args!("o {}", file.objects.len()));
            file.objects.push(name);
        }
        if is_polygon {
            file.elements.push('f');
        }
        for word in line.words() {
            let index = self.index(word, line.number)?;
            if is_polygon {
                file.elements.push(' ');
                file.elements.push_str(&index.to_string());
            }
        }
        if is_polygon {
            file.elements.push('\n');
        }
        Ok(())
    }

    /// The absolute vertex index, from 1, of a corner such as `7`, `-1` or `7/1/3`.
    fn index(&mut self, corner: &str, line: usize) -> Result<u64, Fault> {
        let word = corner.split('/').next().unwrap_or_default();
        let index: i128 = word
            .parse()
            .map_err(|_| Fault { line, reason: format!("'{}' is not a vertex index", corner.escape_debug()) })?;
        let absolute = if index < 0 { i128::from(self.vertices) + 1 + index } else { index };
        match u64::try_from(absolute) {
            Ok(absolute) if absolute > 0 => {
                if absolute > self.highest.0 {
                    self.highest = (absolute, line);
                }
                Ok(absolute)
            }
            _ => Err(out_of_range(line, word, self.vertices)),
        }
    }
}

fn out_of_range(line: usize, index: &str, vertices: u64) -> Fault {
    Fault {
        line,
        reason: match vertices {
            0 => format!("vertex index {index}, but there are no vertices"),
            _ if index == "0" => "vertex index 0; indices count from 1, or backwards from -1".into(),
            _ => format!("vertex index {index} is out of range: there are {vertices} vertices"),
        },
    }
}

fn write_line(text: &mut String, line: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_odd_comes_out_plain() {
        let text = "g\nf 1/1/1 -1 3//2 # ahead\nv 0 0 0 1 1 1\nv 1 2 3 0.5\nv nan 1e99 -0\nf -3 -2 \\\n-1 1\nusemtl a b\nl 1 2\np 1\nf 1 2\n";
        // An index from behind counts from the vertices seen so far: there are none yet at the first face.
        let fault = repair(text).unwrap_err();
        assert_eq!((fault.line, fault.reason.as_str()), (2, "vertex index -1, but there are no vertices"));
        let file = repair(&text.replacen("-1", "2", 1)).unwrap();
        assert_eq!(file.vertices, "v 0 0 0\nv 1 2 3\nv nan 1e99 -0\n");
        assert_eq!(file.elements, "o 0\nf 1 2 3\nf 1 2 3 1\nusemtl a b\n");
        assert_eq!((file.objects, file.points_and_lines), (vec!["unnamed".to_owned()], 3));
        assert_eq!(file.materials, [(8, "a b".to_owned())]);
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
            ("v 0 0 0\nf 9 9", 2, "out of range"),
        ] {
            let fault = repair(text).expect_err(text);
            assert_eq!(fault.line, line, "{text}");
            assert!(fault.reason.contains(reason), "{text}: {}", fault.reason);
        }
    }
}
