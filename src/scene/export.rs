//! Writes a scene as Wavefront OBJ, such that reading it gives the same triangles bit for bit.

use super::{Material, Scene, SceneError};
use glam::Vec3;
use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes `path` and, where any material is not the default one, an `.mtl` file of the same name beside it.
///
/// Numbers have as many digits as it takes to read back the same f32 (at most nine significant ones). Vertices at the
/// same place, bit for bit, are written once. Characters that would break a line are replaced in names.
///
/// # Errors
/// [`SceneError::Unwritable`] where the system refuses.
pub fn export_obj(scene: &Scene, path: &Path) -> Result<(), SceneError> {
    let write_file = |path: &Path, write: &dyn Fn(&mut BufWriter<File>) -> io::Result<()>| {
        let written = File::create(path).map(BufWriter::new).and_then(|mut out| {
            write(&mut out)?;
            out.flush()
        });
        written.map_err(|source| SceneError::Unwritable { path: path.to_owned(), source })
    };
    let names = material_names(&scene.materials);
    let library = path.with_extension("mtl");
    let has_library = scene.materials.iter().any(|material| *material != Material::default());
    if has_library {
        write_file(&library, &|out| write_materials(out, &scene.materials, &names))?;
    }
    let library_name = library.file_name().filter(|_| has_library).map(|name| name.display().to_string());
    write_file(path, &|out| {
        if let Some(name) = &library_name {
            writeln!(out, "mtllib {name}")?;
        }
        write_geometry(out, scene, if has_library { &names } else { &[] })
    })
}

/// The vertices, then the objects with their faces; without names for them, no materials.
fn write_geometry(out: &mut impl Write, scene: &Scene, material_names: &[String]) -> io::Result<()> {
    let mut indices: HashMap<[u32; 3], usize> = HashMap::new();
    let mut faces = Vec::with_capacity(scene.triangles.len());
    for triangle in &scene.triangles {
        let mut face = [0; 3];
        for (index, p) in face.iter_mut().zip(triangle.v) {
            let next = indices.len() + 1;
            *index = *indices.entry(p.to_array().map(f32::to_bits)).or_insert(next);
            if *index == next {
                writeln!(out, "v {}", point(p))?;
            }
        }
        faces.push(face);
    }
    let mut material = None;
    for object in &scene.objects {
        writeln!(out, "o {}", plain(&object.name))?;
        for id in object.triangles.clone() {
            let wanted = usize::from(scene.material_ids[id]);
            if material != Some(wanted)
                && let Some(name) = material_names.get(wanted)
            {
                writeln!(out, "usemtl {name}")?;
                material = Some(wanted);
            }
            let [a, b, c] = faces[id];
            writeln!(out, "f {a} {b} {c}")?;
        }
    }
    Ok(())
}

fn write_materials(out: &mut impl Write, materials: &[Material], names: &[String]) -> io::Result<()> {
    for (material, name) in materials.iter().zip(names) {
        writeln!(out, "newmtl {name}")?;
        writeln!(out, "Kd {}", point(material.diffuse))?;
        writeln!(out, "Ks {}", point(material.specular))?;
        writeln!(out, "Ke {}", point(material.emission))?;
        writeln!(out, "Ns {}", number(material.shininess))?;
        writeln!(out, "Ni {}", number(material.refraction_index))?;
        writeln!(out, "d {}", number(material.opacity))?;
        writeln!(out, "Tf {}", point(material.transmission_filter))?;
        writeln!(out, "illum {}", material.illumination_model)?;
    }
    Ok(())
}

/// Names fit for a line, no two alike.
fn material_names(materials: &[Material]) -> Vec<String> {
    let mut taken = HashSet::new();
    materials
        .iter()
        .map(|material| {
            let plain = plain(&material.name);
            let mut name = plain.clone();
            let mut count = 1;
            while !taken.insert(name.clone()) {
                count += 1;
                name = format!("{plain}.{count}");
            }
            name
        })
        .collect()
}

/// A name without what would end a line, begin a comment or join two lines.
fn plain(name: &str) -> String {
    let words: Vec<_> = name.split(|c: char| c.is_whitespace() || c.is_control()).filter(|w| !w.is_empty()).collect();
    let name = words.join(" ").replace(['#', '\\'], "_");
    if name.is_empty() { "unnamed".into() } else { name }
}

fn point(p: Vec3) -> String {
    p.to_array().map(number).join(" ")
}

/// The shortest decimal that reads back as the same f32.
fn number(x: f32) -> String {
    let plain = x == 0.0 || (1e-4..1e9).contains(&x.abs());
    if plain { x.to_string() } else { format!("{x:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round_trip(scene: &Scene) -> (Scene, String) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.obj");
        export_obj(scene, &path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        (Scene::load(path.to_str().unwrap()).unwrap(), text)
    }

    fn bits(scene: &Scene) -> Vec<u32> {
        let corners = scene.triangles.iter().flat_map(|t| t.v);
        corners.flat_map(|p| p.to_array()).map(f32::to_bits).collect()
    }

    #[test]
    fn triangles_and_objects_come_back_bit_for_bit() {
        for spec in ["thesis:small", "gen:nested:5000", "gen:hairball:777", "gen:boxes:200"] {
            let scene = Scene::load(spec).unwrap();
            let (back, text) = round_trip(&scene);
            assert_eq!(bits(&back), bits(&scene), "{spec}");
            assert_eq!(back.objects, scene.objects);
            assert_eq!((back.materials, back.warnings), (scene.materials, vec![]));
            assert!(!text.contains("mtl"));
        }
        let mut odd = Scene::load("gen:soup:2").unwrap();
        odd.triangles[0].v[0] = Vec3::new(-0.0, f32::MAX, f32::from_bits(1));
        odd.triangles[1].v[2] = Vec3::new(0.0, f32::MAX, -f32::MIN_POSITIVE);
        assert_eq!(bits(&round_trip(&odd).0), bits(&odd));
    }

    #[test]
    fn materials_come_back_under_names_that_fit() {
        let mut scene = Scene::load("gen:soup:5").unwrap();
        scene.objects[0].name = "two\nlines # \\".into();
        let glass = Material {
            name: "my glass".into(),
            diffuse: Vec3::new(0.1, 0.2, 0.3),
            specular: Vec3::splat(1e-7),
            emission: Vec3::new(0.0, 5.0, 1e10),
            shininess: 96.078_43,
            refraction_index: 1.52,
            opacity: 0.25,
            transmission_filter: Vec3::new(1.0, 0.5, 0.25),
            illumination_model: 7,
            ..Material::default()
        };
        let twin = Material { opacity: 0.5, ..glass.clone() };
        let false_default = Material { opacity: 0.75, ..Material::default() };
        scene.materials.extend([glass, twin, false_default]);
        scene.material_ids = vec![0, 1, 2, 0, 3];
        let (back, _) = round_trip(&scene);
        assert_eq!(back.material_ids, scene.material_ids);
        assert_eq!(back.objects[0].name, "two lines _ _");
        assert_eq!(back.materials[2].name, "my glass.2");
        for (found, written) in back.materials.iter().zip(&scene.materials) {
            let renamed = Material { name: written.name.clone(), ..found.clone() };
            assert_eq!(renamed, *written);
        }
        assert_eq!(back.warnings, Vec::<String>::new());
    }

    #[test]
    fn a_place_that_cannot_be_written_is_told() {
        let scene = Scene::load("gen:grid:1").unwrap();
        let error = export_obj(&scene, Path::new("no/such/folder/x.obj")).unwrap_err().to_string();
        assert!(error.starts_with("cannot write no/such/folder/x.obj: "), "{error}");
    }
}
