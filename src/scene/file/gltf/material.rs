//! Metallic-roughness materials in the terms of MTL.

use super::super::obj::shininess_of;
use super::numbers::{self, Buffers};
use crate::scene::{Material, Texture, TextureSource};
use glam::Vec3;
use gltf::material::AlphaMode;
use std::path::Path;

/// The roughness up to which a metal mirrors; beyond, it has a highlight.
const MIRROR_ROUGHNESS: f32 = 0.25;
/// Metallic share from which a surface is a metal.
const METAL: f32 = 0.5;
/// Reflectance of what is no metal, seen straight on (glTF 2.0, appendix B).
const DIELECTRIC: f32 = 0.04;

/// The material as this lab draws it; what has no counterpart is told.
pub(super) fn convert(
    source: &gltf::Material<'_>,
    path: &Path,
    buffers: Buffers<'_>,
    warnings: &mut Vec<String>,
) -> Material {
    let surface = source.pbr_metallic_roughness();
    let name = source.name().map_or_else(|| format!("material{}", source.index().unwrap_or(0)), str::to_owned);
    let [r, g, b, alpha] = surface.base_color_factor();
    let base = Vec3::new(r, g, b);
    let (metallic, roughness) = (surface.metallic_factor().clamp(0.0, 1.0), surface.roughness_factor().clamp(0.0, 1.0));
    let transmission = source.transmission().map_or(0.0, |t| t.transmission_factor().clamp(0.0, 1.0));
    let mut material = Material {
        diffuse: base * (1.0 - metallic),
        specular: Vec3::splat(DIELECTRIC).lerp(base, metallic),
        emission: Vec3::from(source.emissive_factor()) * source.emissive_strength().unwrap_or(1.0),
        shininess: shininess_of(roughness),
        illumination_model: if metallic >= METAL && roughness <= MIRROR_ROUGHNESS { 3 } else { 2 },
        ..Material::default()
    };
    let mut unused = Vec::new();
    if let Some(info) = surface.base_color_texture() {
        match texture(&info.texture(), path, buffers) {
            Ok(texture) => {
                if info.tex_coord() != 0 {
                    unused.push("texture coordinates beyond the first set");
                }
                if source.alpha_mode() != AlphaMode::Opaque {
                    material.opacity_map = Some(texture.clone());
                }
                material.diffuse_map = Some(texture);
            }
            Err(reason) => warnings.push(format!("material '{}': {reason}", name.escape_debug())),
        }
    }
    if source.alpha_mode() == AlphaMode::Blend {
        material.opacity = alpha.clamp(0.0, 1.0);
    }
    if transmission > 0.0 {
        material.opacity = 1.0 - transmission;
        material.transmission_filter = base;
        material.refraction_index = source.ior().unwrap_or(1.5);
        material.illumination_model = 7;
    }
    unused.extend(surface.metallic_roughness_texture().map(|_| "metallicRoughnessTexture"));
    unused.extend(source.normal_texture().map(|_| "normalTexture"));
    unused.extend(source.emissive_texture().map(|_| "emissiveTexture"));
    if !unused.is_empty() {
        warnings.push(format!("material '{}': no use here for {}", name.escape_debug(), unused.join(", ")));
    }
    Material { name, ..material }
}

fn texture(texture: &gltf::Texture<'_>, path: &Path, buffers: Buffers<'_>) -> Result<Texture, String> {
    use gltf::texture::WrappingMode::ClampToEdge;
    let image = texture.source();
    let name = image.name().map_or_else(|| format!("image{}", image.index()), str::to_owned);
    let source = match image.source() {
        gltf::image::Source::View { view, .. } => {
            let bytes = numbers::bytes(buffers, &view).ok_or("its image reaches beyond its buffer")?;
            TextureSource::Embedded(name, bytes.into())
        }
        gltf::image::Source::Uri { uri, .. } if uri.starts_with("data:") => {
            TextureSource::Embedded(name, super::fetch(path, uri)?.into())
        }
        gltf::image::Source::Uri { uri, .. } => {
            let file = super::beside(path, uri)?;
            if !file.is_file() {
                return Err(format!("there is no file {}", crate::scene::error::one_line(&file)));
            }
            TextureSource::File(file)
        }
    };
    let clamps = texture.sampler().wrap_s() == ClampToEdge && texture.sampler().wrap_t() == ClampToEdge;
    Ok(Texture { clamps, ..Texture::of(source) })
}
