//! MTL files: found, and their statements turned into materials.
//!
//! A statement that makes no sense costs itself and a warning, never the scene; what has no use here is counted.

use super::super::text::{self, Fault, Lines};
use super::numbers::number;
use super::parse::NAMELESS;
use crate::scene::error::one_line;
use crate::scene::{Material, Texture};
use glam::{Vec2, Vec3};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::path::{Path, PathBuf};

/// All materials of a scene's MTL files.
#[derive(Debug, Default)]
pub(super) struct Library {
    materials: Vec<Material>,
    /// Where to find a name among them; later definitions replace earlier ones.
    index: HashMap<String, usize>,
    seen: Vec<PathBuf>,
}

impl Library {
    /// Reads what the `mtllib` statement in `line` of the OBJ file at `obj` names.
    pub(super) fn add(&mut self, obj: &Path, line: usize, argument: &str, warnings: &mut Vec<String>) {
        for path in find(obj, argument) {
            if self.seen.contains(&path) {
                continue;
            }
            if let Err(reason) = self.read(&path, warnings) {
                warnings.push(format!("line {line}: cannot use {}: {reason}", one_line(&path)));
            }
            self.seen.push(path);
        }
    }

    fn read(&mut self, path: &Path, warnings: &mut Vec<String>) -> Result<(), String> {
        let mut lines = Lines::new(File::open(path).map_err(|error| error.to_string())?);
        let mut unused: BTreeMap<String, usize> = BTreeMap::new();
        let mut open: Option<Definition> = None;
        let folder = path.parent().unwrap_or(Path::new(""));
        loop {
            let line = match lines.next() {
                Ok(Some(line)) => line,
                Ok(None) => break,
                Err(Fault::Io(error)) => return Err(error.to_string()),
                Err(Fault::Encoding(told)) => return Err(told.into()),
            };
            let (keyword, rest) = line.split();
            if keyword == b"newmtl" {
                self.define(open.take());
                open = Some(Definition::new(&text::decode(rest)));
                continue;
            }
            // What stands before the first name belongs to nothing.
            let Some(definition) = &mut open else { continue };
            match definition.statement(keyword, rest, folder) {
                Ok(true) => {}
                Ok(false) => *unused.entry(text::decode(keyword).into_owned()).or_default() += 1,
                Err(reason) => warnings.push(format!("{}:{}: {reason}; ignored", one_line(path), line.number)),
            }
        }
        self.define(open);
        if !unused.is_empty() {
            let counted: Vec<_> = unused.iter().map(|(word, n)| format!("{} ({n})", word.escape_debug())).collect();
            warnings.push(format!("{}: statements that have no use here: {}", one_line(path), counted.join(", ")));
        }
        Ok(())
    }

    fn define(&mut self, definition: Option<Definition>) {
        let Some(definition) = definition else { return };
        let material = definition.finish();
        self.index.insert(material.name.clone(), self.materials.len());
        self.materials.push(material);
    }

    /// Whether any material has a texture.
    pub(super) fn has_textures(&self) -> bool {
        self.materials.iter().any(|m| m.diffuse_map.is_some() || m.opacity_map.is_some())
    }

    /// The scene's materials, the default one first, and for each of `names` its place among them, if there is one.
    ///
    /// A definition that says what the default one says is the default one.
    pub(super) fn scene_materials(
        self,
        names: &[(usize, String)],
        warnings: &mut Vec<String>,
    ) -> (Vec<Material>, Vec<Option<u16>>) {
        let mut materials = vec![Material::default()];
        let mut homeless = 0;
        let ids: Vec<u16> = self
            .materials
            .into_iter()
            .map(|material| {
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
        let place = |name: &String| self.index.get(name).map(|&at| ids[at]);
        (materials, names.iter().map(|(_, name)| place(name)).collect())
    }
}

/// The files an `mtllib` line means: all of it as one name where such a file exists, else word by word, with `\ ` for
/// a space inside a word. A backslash elsewhere may stand for a slash.
fn find(obj: &Path, argument: &str) -> Vec<PathBuf> {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let whole = resolve(folder, argument);
    if whole.is_file() {
        return vec![whole];
    }
    const SPACE: &str = "\u{0}";
    let escaped = argument.replace("\\ ", SPACE);
    escaped.split_whitespace().map(|word| resolve(folder, &word.replace(SPACE, " "))).collect()
}

fn resolve(folder: &Path, name: &str) -> PathBuf {
    let plain = folder.join(name);
    let slashed = folder.join(name.replace('\\', "/"));
    if !plain.is_file() && slashed.is_file() { slashed } else { plain }
}

/// A material whose statements are being read.
#[derive(Debug)]
struct Definition {
    material: Material,
    dissolve: Option<f32>,
    transparency: Option<f32>,
    filter: Option<Vec3>,
    metallic: Option<f32>,
    roughness: Option<f32>,
    has_specular: bool,
    has_model: bool,
}

/// The roughness up to which a metal mirrors; beyond, it has a highlight.
const MIRROR_ROUGHNESS: f32 = 0.25;

impl Definition {
    fn new(name: &str) -> Self {
        let name = if name.is_empty() { NAMELESS } else { name };
        Self {
            material: Material { name: name.into(), ..Material::default() },
            dissolve: None,
            transparency: None,
            filter: None,
            metallic: None,
            roughness: None,
            has_specular: false,
            has_model: false,
        }
    }

    /// Takes a statement; false where it is none that has a use.
    fn statement(&mut self, keyword: &[u8], rest: &[u8], folder: &Path) -> Result<bool, String> {
        let m = &mut self.material;
        match keyword {
            b"Kd" => m.diffuse = colour(keyword, rest)?,
            b"Ks" => {
                m.specular = colour(keyword, rest)?;
                self.has_specular = true;
            }
            b"Ke" => m.emission = colour(keyword, rest)?,
            b"Tf" => self.filter = Some(colour(keyword, rest)?.clamp(Vec3::ZERO, Vec3::ONE)),
            b"Ns" => m.shininess = first(keyword, rest)?,
            b"Ni" => m.refraction_index = first(keyword, rest)?,
            b"d" => self.dissolve = Some(first(keyword, rest)?),
            b"Tr" => self.transparency = Some(first(keyword, rest)?),
            b"Pm" => self.metallic = Some(first(keyword, rest)?.clamp(0.0, 1.0)),
            b"Pr" => self.roughness = Some(first(keyword, rest)?.clamp(0.0, 1.0)),
            b"illum" => match numbers(rest)?.first() {
                Some(&model) if (0.0..=10.0).contains(&model) => {
                    m.illumination_model = model as u8;
                    self.has_model = true;
                }
                _ => return Err("illum is a number from 0 to 10".into()),
            },
            b"map_Kd" => m.diffuse_map = Some(texture(keyword, rest, folder)?),
            b"map_d" => m.opacity_map = Some(texture(keyword, rest, folder)?),
            // Ambient light is not the material's here: it is estimated from the scene's lights.
            b"Ka" => {}
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn finish(self) -> Material {
        let mut m = self.material;
        // Where both are given, d counts.
        if let Some(opacity) = self.dissolve.or(self.transparency.map(|tr| 1.0 - tr)) {
            m.opacity = opacity.clamp(0.0, 1.0);
            m.transmission_filter = self.filter.unwrap_or(Vec3::ONE);
        } else if let Some(filter) = self.filter {
            // Maya writes no d: its Tf is the colour of the opacity, 1 for what is opaque. What is not grey is a filter.
            if filter.max_element() - filter.min_element() < 1e-6 {
                m.opacity = filter.x;
            } else {
                m.transmission_filter = filter;
            }
        }
        if let Some(metallic) = self.metallic.filter(|&m| m > 0.0) {
            if !self.has_specular {
                m.specular = m.diffuse * metallic;
            }
            m.diffuse *= 1.0 - metallic;
            if !self.has_model {
                m.illumination_model = if self.roughness.unwrap_or(1.0) <= MIRROR_ROUGHNESS { 3 } else { 2 };
            }
        }
        if let Some(roughness) = self.roughness {
            m.shininess = shininess_of(roughness);
        }
        m
    }
}

/// The exponent of Blinn's highlight as wide as the microfacets of a roughness r, α = r² (Walter et al. 2007, section 5.2).
pub(in super::super) fn shininess_of(roughness: f32) -> f32 {
    let alpha = (roughness * roughness).max(1e-2);
    (2.0 / (alpha * alpha) - 2.0).max(1.0)
}

/// The finite numbers in `text`; options such as `-halo` are passed over.
fn numbers(text: &[u8]) -> Result<Vec<f32>, String> {
    let is_option = |word: &&[u8]| matches!(word, [b'-', letter, ..] if letter.is_ascii_alphabetic());
    text::words(text)
        .filter(|word| !is_option(word))
        .map(|word| {
            let value = number(word).map(|(value, _)| value).filter(|x| x.is_finite());
            value.ok_or_else(|| format!("'{}' is not a finite number", text::decode(word).escape_debug()))
        })
        .collect()
}

fn first(keyword: &[u8], rest: &[u8]) -> Result<f32, String> {
    numbers(rest)?.first().copied().ok_or_else(|| format!("{} without a number", text::decode(keyword)))
}

fn colour(keyword: &[u8], rest: &[u8]) -> Result<Vec3, String> {
    match numbers(rest)?[..] {
        [r, g, b, ..] => Ok(Vec3::new(r, g, b)),
        // The format's rule: green and blue, left out, are as red.
        [r, ..] => Ok(Vec3::splat(r)),
        [] => Err(format!("{} without a number", text::decode(keyword))),
    }
}

/// Options of a texture, and how many words each takes; of those with three, the second and third may be missing.
const TEXTURE_OPTIONS: &[(&str, usize)] = &[
    ("-blendu", 1),
    ("-blendv", 1),
    ("-boost", 1),
    ("-bm", 1),
    ("-cc", 1),
    ("-clamp", 1),
    ("-colorspace", 1),
    ("-imfchan", 1),
    ("-mm", 2),
    ("-o", 3),
    ("-s", 3),
    ("-t", 3),
    ("-texres", 1),
    ("-type", 1),
];

/// A texture: its file (beside the MTL file, spaces in its name allowed), and of its options scale, offset and clamping.
fn texture(keyword: &[u8], rest: &[u8], folder: &Path) -> Result<Texture, String> {
    let mut words = text::words(rest).map(text::decode).peekable();
    let mut name: Vec<String> = Vec::new();
    let (mut offset, mut scale, mut clamps) = (Vec2::ZERO, Vec2::ONE, false);
    while let Some(word) = words.next() {
        let Some(&(option, most)) = TEXTURE_OPTIONS.iter().find(|(option, _)| *option == word) else {
            name.push(word.into_owned());
            continue;
        };
        let mut values: Vec<String> = Vec::new();
        while values.len() < most
            && let Some(value) =
                words.next_if(|w| most == 1 || number(w.as_bytes()).is_some_and(|(value, _)| value.is_finite()))
        {
            values.push(value.into_owned());
        }
        let value = |i: usize, otherwise| {
            values.get(i).and_then(|w: &String| number(w.as_bytes())).map_or(otherwise, |(value, _)| value)
        };
        match option {
            "-o" => offset = Vec2::new(value(0, 0.0), value(1, 0.0)),
            "-s" => scale = Vec2::new(value(0, 1.0), value(1, 1.0)),
            "-clamp" => clamps = values.first().is_some_and(|word| word == "on"),
            _ => {}
        }
    }
    let keyword = text::decode(keyword);
    if name.is_empty() {
        return Err(format!("{keyword} without a file"));
    }
    let path = resolve(folder, &name.join(" "));
    if !path.is_file() {
        return Err(format!("{keyword}: there is no file {}", one_line(&path)));
    }
    Ok(Texture { offset, scale, clamps, ..Texture::file(path) })
}
