//! MTL files: found, checked line by line, parsed by `tobj`, turned into materials.
//!
//! A statement that makes no sense costs itself and a warning, never the scene.

use super::super::text::{self, Line};
use super::repair::NAMELESS;
use crate::scene::Material;
use crate::scene::error::one_line;
use glam::Vec3;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// All materials of a scene's MTL files.
pub(super) struct Library {
    /// As `tobj` reads them.
    pub(super) materials: Vec<tobj::Material>,
    /// Where to find a name among them.
    pub(super) index: HashMap<String, usize>,
}

impl Library {
    /// Reads what the `mtllib` lines of the OBJ file at `obj` name; later definitions replace earlier ones.
    pub(super) fn load(obj: &Path, names: &[(usize, String)], warnings: &mut Vec<String>) -> Self {
        let mut library = Self { materials: Vec::new(), index: HashMap::new() };
        let mut seen = Vec::new();
        for (line, argument) in names {
            for path in find(obj, argument) {
                if seen.contains(&path) {
                    continue;
                }
                match library.read(&path, warnings) {
                    Ok(()) => {}
                    Err(reason) => warnings.push(format!("line {line}: cannot use {}: {reason}", one_line(&path))),
                }
                seen.push(path);
            }
        }
        library
    }

    fn read(&mut self, path: &Path, warnings: &mut Vec<String>) -> Result<(), String> {
        let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
        let text = text::decode(&bytes)?;
        let mut plain = String::new();
        for line in text::lines(&text) {
            match rewrite(&line) {
                Ok(statement) => plain.extend(statement.map(|s| s + "\n")),
                Err(reason) => warnings.push(format!("{}:{}: {reason}; ignored", one_line(path), line.number)),
            }
        }
        let (materials, index) = tobj::load_mtl_buf(&mut plain.as_bytes()).map_err(|error| error.to_string())?;
        let offset = self.materials.len();
        self.materials.extend(materials);
        self.index.extend(index.into_iter().map(|(name, i)| (name, i + offset)));
        Ok(())
    }

    /// Whether there is a material of that name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.index.contains_key(name)
    }

    /// The scene's materials, the default one first, and the place in them of each that `tobj` knows.
    ///
    /// A definition that says what the default one says is the default one.
    pub(super) fn scene_materials(&self, warnings: &mut Vec<String>) -> (Vec<Material>, Vec<u16>) {
        let mut materials = vec![Material::default()];
        let mut homeless = 0;
        let ids = self
            .materials
            .iter()
            .map(|source| {
                let material = convert(source);
                let Ok(id) = u16::try_from(materials.len()) else {
                    homeless += 1;
                    return 0;
                };
                if material == materials[0] {
                    return 0;
                }
                materials.push(material);
                id
            })
            .collect();
        if homeless > 0 {
            let most = materials.len();
            warnings.push(format!("more than {most} materials; the last {homeless} are taken for the default"));
        }
        (materials, ids)
    }
}

/// The files an `mtllib` line means: all of it as one name where such a file exists, else word by word, with `\ ` for
/// a space inside a word. A backslash elsewhere may stand for a slash.
fn find(obj: &Path, argument: &str) -> Vec<PathBuf> {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let resolve = |name: &str| {
        let plain = folder.join(name);
        let slashed = folder.join(name.replace('\\', "/"));
        if !plain.is_file() && slashed.is_file() { slashed } else { plain }
    };
    let whole = resolve(argument);
    if whole.is_file() {
        return vec![whole];
    }
    const SPACE: &str = "\u{0}";
    let escaped = argument.replace("\\ ", SPACE);
    escaped.split_whitespace().map(|word| resolve(&word.replace(SPACE, " "))).collect()
}

/// A statement as `tobj` takes it without fail; none where it says nothing a scene needs.
fn rewrite(line: &Line<'_>) -> Result<Option<String>, String> {
    let keyword = line.keyword();
    let statement = match keyword {
        "newmtl" => match line.rest() {
            "" => format!("newmtl {NAMELESS}"),
            name => format!("newmtl {name}"),
        },
        "Kd" | "Ks" | "Ke" => {
            let values = numbers(line)?;
            match values[..] {
                [r, g, b, ..] => format!("{keyword} {r:e} {g:e} {b:e}"),
                // The format's rule: green and blue, left out, are as red.
                [r, ..] => format!("{keyword} {r:e} {r:e} {r:e}"),
                [] => return Err(format!("{keyword} without a number")),
            }
        }
        "Ns" | "Ni" | "d" | "Tr" => match numbers(line)?.first() {
            Some(value) => format!("{keyword} {value:e}"),
            None => return Err(format!("{keyword} without a number")),
        },
        "illum" => match numbers(line)?.first() {
            Some(&model) if (0.0..=10.0).contains(&model) => format!("illum {}", model as u8),
            _ => return Err("illum is a number from 0 to 10".into()),
        },
        _ => return Ok(None),
    };
    Ok(Some(statement))
}

/// The numbers after the keyword; options such as `-halo` are passed over.
fn numbers(line: &Line<'_>) -> Result<Vec<f32>, String> {
    let is_option = |word: &&str| word.starts_with('-') && word[1..].starts_with(|c: char| c.is_ascii_alphabetic());
    line.words()
        .filter(|word| !is_option(word))
        .map(|word| {
            let number = word.parse::<f32>().ok().filter(|x| x.is_finite());
            number.ok_or_else(|| format!("'{}' is not a finite number", word.escape_debug()))
        })
        .collect()
}

fn convert(source: &tobj::Material) -> Material {
    let default = Material::default();
    let colour = |value: Option<[f32; 3]>, otherwise| value.map_or(otherwise, Vec3::from);
    let transparency = source.unknown_param.get("Tr").and_then(|tr| tr.parse::<f32>().ok());
    // Where both are given, d counts.
    let opacity = source.dissolve.or(transparency.map(|tr| 1.0 - tr)).unwrap_or(default.opacity);
    Material {
        name: source.name.clone(),
        diffuse: colour(source.diffuse, default.diffuse),
        specular: colour(source.specular, default.specular),
        emission: colour(source.emissive, default.emission),
        shininess: source.shininess.unwrap_or(default.shininess),
        refraction_index: source.optical_density.unwrap_or(default.refraction_index),
        opacity: opacity.clamp(0.0, 1.0),
        illumination_model: source.illumination_model.unwrap_or(default.illumination_model),
    }
}
