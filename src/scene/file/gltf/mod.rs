//! glTF 2.0, as JSON or binary: the crate `gltf` reads the document, numbers are taken from its buffers here.

mod material;
mod numbers;

use super::mesh::{Mesh, strip};
use super::{Parts, Source, malformed, told};
use crate::scene::{Camera, Dropped, Material, NamedCamera, SceneError};
use base64::Engine;
use glam::{Mat4, Vec2, Vec3};
use gltf::mesh::{Mode, Primitive, Semantic};
use numbers::{Buffers, indices, vectors};
use std::path::{Path, PathBuf};

/// The most triangles that the nodes of a file may ask for: the same mesh may stand in many places.
const MOST_TRIANGLES: usize = 1 << 31;

pub(super) fn read(source: &mut Source<'_>) -> Result<Parts, SceneError> {
    let path = source.path;
    let bytes = source.bytes()?;
    let fail = |reason: String| malformed(path, None, reason);
    let file = document(&bytes).map_err(fail)?;
    drop(bytes);
    let buffers = buffers(path, &file).map_err(fail)?;
    let mut reading = Reading::new(path, &file.document, &buffers);
    reading.run().map_err(fail)?;
    Ok(reading.finish())
}

/// The document and its binary part. What the library's own validation takes for granted is looked at before it.
fn document(bytes: &[u8]) -> Result<gltf::Gltf, String> {
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice_without_validation(bytes).map_err(|e| told(&e))?;
    let root = document.into_json();
    let positions = gltf::json::validation::Checked::Valid(Semantic::Positions);
    for (index, mesh) in root.meshes.iter().enumerate() {
        let places = mesh.primitives.iter().filter_map(|primitive| primitive.attributes.get(&positions));
        if places.into_iter().any(|place| place.value() >= root.accessors.len()) {
            return Err(format!("mesh {index}: there is no accessor for its positions"));
        }
    }
    for (index, image) in root.images.iter().enumerate() {
        let is_told = if image.buffer_view.is_some() { image.mime_type.is_some() } else { image.uri.is_some() };
        if !is_told {
            return Err(format!("image {index} says neither where nor what it is"));
        }
    }
    for (index, camera) in root.cameras.iter().enumerate() {
        use gltf::json::{camera::Type, validation::Checked::Valid};
        let has_lens = match camera.type_ {
            Valid(Type::Perspective) => camera.perspective.is_some(),
            _ => camera.orthographic.is_some(),
        };
        if !has_lens {
            return Err(format!("camera {index} has no lens"));
        }
    }
    let document = gltf::Document::from_json(root).map_err(|e| told(&e))?;
    Ok(gltf::Gltf { document, blob })
}

/// The bytes of every buffer: the binary part, embedded, or from files beside this one.
fn buffers(path: &Path, file: &gltf::Gltf) -> Result<Vec<Vec<u8>>, String> {
    let mut blob = file.blob.clone();
    let read = |buffer: gltf::Buffer<'_>| {
        let bytes = match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().ok_or("it has no binary part")?,
            gltf::buffer::Source::Uri(uri) => fetch(path, uri)?,
        };
        if bytes.len() < buffer.length() {
            let (index, there, wanted) = (buffer.index(), bytes.len(), buffer.length());
            return Err(format!("buffer {index} has {there} of {wanted} bytes"));
        }
        Ok(bytes)
    };
    file.document.buffers().map(read).collect()
}

/// What a URI of the file at `path` stands for: data of its own, or a file beside it.
fn fetch(path: &Path, uri: &str) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, encoded) = data.split_once(";base64,").ok_or("embedded data that is not base64")?;
        let decoded = base64::engine::general_purpose::STANDARD.decode(encoded);
        return decoded.map_err(|e| format!("embedded data is damaged: {e}"));
    }
    let file = beside(path, uri)?;
    std::fs::read(&file).map_err(|e| format!("cannot read {}: {e}", crate::scene::error::one_line(&file)))
}

/// The file that a URI without a scheme names.
fn beside(path: &Path, uri: &str) -> Result<PathBuf, String> {
    if uri.contains(':') {
        return Err(format!("'{}' is neither embedded data nor a file beside it", told(&uri.escape_debug())));
    }
    let name = percent_decoded(uri).ok_or_else(|| format!("'{}' is no file name", told(&uri.escape_debug())))?;
    Ok(path.parent().unwrap_or(Path::new("")).join(name))
}

fn percent_decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first == b'%' {
            let (digits, tail) = tail.split_at_checked(2)?;
            bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
            rest = tail;
        } else {
            bytes.push(*first);
        }
    }
    String::from_utf8(bytes).ok()
}

/// A document whose scene is being gathered.
struct Reading<'a> {
    path: &'a Path,
    document: &'a gltf::Document,
    buffers: Buffers<'a>,
    mesh: Mesh,
    /// The default one, then the file's.
    materials: Vec<Material>,
    cameras: Vec<NamedCamera>,
    points_and_lines: usize,
    warnings: Vec<String>,
    has_textures: bool,
}

impl<'a> Reading<'a> {
    fn new(path: &'a Path, document: &'a gltf::Document, buffers: Buffers<'a>) -> Self {
        Self {
            path,
            document,
            buffers,
            mesh: Mesh::default(),
            materials: vec![Material::default()],
            cameras: Vec::new(),
            points_and_lines: 0,
            warnings: Vec::new(),
            has_textures: false,
        }
    }

    /// Goes through the nodes of the default scene, each once, whatever the file says: cycles end, depth is no matter.
    fn run(&mut self) -> Result<(), String> {
        self.materials()?;
        let roots: Vec<_> = match self.document.default_scene().or_else(|| self.document.scenes().next()) {
            Some(scene) => scene.nodes().collect(),
            None => self.document.nodes().collect(),
        };
        let mut seen = vec![false; self.document.nodes().len()];
        let mut open: Vec<_> = roots.into_iter().rev().map(|node| (node, Mat4::IDENTITY)).collect();
        while let Some((node, parent)) = open.pop() {
            if std::mem::replace(&mut seen[node.index()], true) {
                continue;
            }
            let placed = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
            if let Some(mesh) = node.mesh() {
                let name = node.name().or(mesh.name()).unwrap_or("mesh").to_owned();
                self.mesh.begin(name);
                for primitive in mesh.primitives() {
                    self.primitive(&primitive, placed).map_err(|e| format!("mesh {}: {e}", mesh.index()))?;
                }
            }
            if let Some(camera) = node.camera() {
                self.camera(node.name(), &camera, placed);
            }
            open.extend(node.children().map(|child| (child, placed)).collect::<Vec<_>>().into_iter().rev());
        }
        Ok(())
    }

    fn materials(&mut self) -> Result<(), String> {
        for source in self.document.materials() {
            if self.materials.len() > usize::from(u16::MAX) {
                let (most, there) = (self.materials.len(), self.document.materials().len());
                self.warnings
                    .push(format!("more than {most} materials; {there} are there, the last are taken for the default"));
                break;
            }
            let material = material::convert(&source, self.path, self.buffers, &mut self.warnings);
            self.has_textures |= material.diffuse_map.is_some() || material.opacity_map.is_some();
            self.materials.push(material);
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive<'_>, placed: Mat4) -> Result<(), String> {
        let Some(positions) = primitive.get(&Semantic::Positions) else {
            return Ok(());
        };
        let positions = vectors::<3>(self.buffers, &positions)?;
        let order = match primitive.indices() {
            Some(accessor) => indices(self.buffers, &accessor)?,
            None => (0..u32::try_from(positions.len()).map_err(|_| "too many vertices")?).collect(),
        };
        let triangles: Vec<[u32; 3]> = match primitive.mode() {
            Mode::Triangles => order.as_chunks::<3>().0.to_vec(),
            Mode::TriangleStrip => strip(&order).collect(),
            Mode::TriangleFan => {
                let rest = order.get(1..).unwrap_or_default();
                rest.windows(2).map(|pair| [order[0], pair[0], pair[1]]).collect()
            }
            mode => {
                self.points_and_lines += match mode {
                    Mode::Lines => order.len() / 2,
                    Mode::LineStrip => order.len().saturating_sub(1),
                    _ => order.len(),
                };
                return Ok(());
            }
        };
        if self.mesh.triangles.len() + triangles.len() > MOST_TRIANGLES {
            return Err(format!("its nodes ask for more than {MOST_TRIANGLES} triangles"));
        }
        let material = primitive.material().index().map_or(0, |at| at + 1);
        let material = if material < self.materials.len() { material as u16 } else { 0 };
        let texture = self.texture_coordinates(primitive)?;
        // A mirrored placement turns triangles over; glTF says they are wound the other way then.
        let mirrored = placed.determinant() < 0.0;
        let places: Vec<Vec3> = positions.iter().map(|&p| placed.transform_point3(Vec3::from(p))).collect();
        let find = |index: u32| {
            let there = places.len();
            let found = places.get(index as usize).copied();
            found.ok_or_else(|| format!("vertex index {index} is out of range: there are {there} vertices"))
        };
        for [a, b, c] in triangles {
            let order = if mirrored { [a, c, b] } else { [a, b, c] };
            let corners = [find(order[0])?, find(order[1])?, find(order[2])?];
            let at = |index: u32| texture.get(index as usize).copied().unwrap_or_default();
            let coordinates = order.map(at);
            self.mesh.polygon(&corners, if self.has_textures { &coordinates } else { &[] }, material);
        }
        Ok(())
    }

    /// The first set of texture coordinates, v upwards.
    fn texture_coordinates(&self, primitive: &Primitive<'_>) -> Result<Vec<Vec2>, String> {
        let Some(accessor) = primitive.get(&Semantic::TexCoords(0)).filter(|_| self.has_textures) else {
            return Ok(Vec::new());
        };
        let found = vectors::<2>(self.buffers, &accessor)?;
        let finite = |p: Vec2| if p.is_finite() { p } else { Vec2::ZERO };
        Ok(found.into_iter().map(|[u, v]| finite(Vec2::new(u, 1.0 - v))).collect())
    }

    fn camera(&mut self, name: Option<&str>, camera: &gltf::Camera<'_>, placed: Mat4) {
        let number = self.cameras.len() + 1;
        let name = name.or(camera.name()).map_or_else(|| format!("camera{number}"), str::to_owned);
        let gltf::camera::Projection::Perspective(lens) = camera.projection() else {
            self.warnings.push(format!("camera '{}' is orthographic and left out", name.escape_debug()));
            return;
        };
        let eye = placed.transform_point3(Vec3::ZERO);
        let forward = placed.transform_vector3(Vec3::NEG_Z).normalize_or(Vec3::NEG_Z);
        let up = placed.transform_vector3(Vec3::Y).normalize_or(Vec3::Y);
        let fov = lens.yfov().to_degrees();
        if eye.is_finite() && fov > 0.0 && fov < 180.0 {
            let reach = eye.abs().max_element().max(1.0);
            let camera = Camera { eye, look_at: eye + forward * reach, up, fov_degrees: fov };
            self.cameras.push(NamedCamera { name, camera });
        } else {
            self.warnings.push(format!("camera '{}' is damaged and left out", name.escape_debug()));
        }
    }

    fn finish(self) -> Parts {
        let dropped = Dropped { points_and_lines: self.points_and_lines, ..Dropped::default() };
        let mut parts = self.mesh.finish(self.materials, dropped, self.warnings);
        parts.cameras = self.cameras;
        parts
    }
}
