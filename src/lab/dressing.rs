//! The thesis' scene in materials and light of ours: what Figure 3 could have shown.

use crate::geom::Triangle;
use crate::scene::{Material, Object, Scene};
use glam::Vec3;

/// Height of the floor, in scene units: just under the cup of the finer levels.
const FLOOR: f32 = -1.5;

/// The scene with a material for each of its objects, on a floor, under two lamps out of the picture: a large warm one over the
/// viewer's left shoulder and a small cool one on the right.
pub(super) fn dressed(mut scene: Scene) -> Scene {
    let named: Vec<_> =
        scene.objects.iter().map(|object| (material_of(&object.name), object.triangles.clone())).collect();
    for (material, triangles) in named {
        scene.material_ids[triangles].fill(scene.materials.len() as u16);
        scene.materials.push(material);
    }
    add(
        &mut scene,
        matt("floor", [0.42, 0.41, 0.40]),
        [[-160.0, FLOOR, -160.0], [-160.0, FLOOR, 160.0], [160.0, FLOOR, 160.0]],
    );
    add(&mut scene, lamp("key", [15.0, 13.6, 11.6]), [[2.0, 34.0, 30.0], [-14.0, 34.0, 16.0], [0.0, 38.0, 2.0]]);
    add(&mut scene, lamp("fill", [5.0, 6.0, 7.5]), [[46.0, 8.0, -4.0], [46.0, 8.0, 8.0], [40.0, 20.0, 8.0]]);
    scene
}

/// A parallelogram of three corners, the second between the others, as an object of its own.
fn add(scene: &mut Scene, material: Material, corners: [[f32; 3]; 3]) {
    let [a, b, c] = corners.map(Vec3::from);
    let start = scene.triangles.len();
    scene.triangles.extend([Triangle::new(a, b, c), Triangle::new(a, c, a + c - b)]);
    scene.material_ids.extend([scene.materials.len() as u16; 2]);
    scene.objects.push(Object { name: material.name.clone(), triangles: start..start + 2 });
    scene.materials.push(material);
}

/// What an object of the thesis' scene is made of: the cup and two blobs of glass, the slab and the largest blob polished, the torus
/// of brass, the other blobs of lacquer.
fn material_of(object: &str) -> Material {
    match object {
        "cup" | "A" => Material {
            name: object.into(),
            diffuse: Vec3::ZERO,
            illumination_model: 7,
            specular: Vec3::ONE,
            refraction_index: 1.5,
            opacity: 0.0,
            transmission_filter: Vec3::new(0.86, 0.96, 0.93),
            ..Material::default()
        },
        "slab" => polished(object, [0.80, 0.82, 0.84]),
        "H" => polished(object, [0.92, 0.91, 0.90]),
        "torus" => polished(object, [0.90, 0.66, 0.30]),
        "B" => lacquer(object, [0.05, 0.16, 0.42]),
        "C" => lacquer(object, [0.55, 0.04, 0.04]),
        "D" => lacquer(object, [0.04, 0.30, 0.12]),
        "E" => lacquer(object, [0.70, 0.27, 0.03]),
        _ => lacquer(object, [0.60, 0.58, 0.55]),
    }
}

fn matt(name: &str, diffuse: [f32; 3]) -> Material {
    Material { name: name.into(), diffuse: diffuse.into(), ..Material::default() }
}

fn lamp(name: &str, emission: [f32; 3]) -> Material {
    Material { name: name.into(), diffuse: Vec3::ZERO, emission: emission.into(), ..Material::default() }
}

/// Metal that mirrors, more at grazing angles.
fn polished(name: &str, specular: [f32; 3]) -> Material {
    Material { illumination_model: 5, specular: specular.into(), ..matt(name, [0.0; 3]) }
}

fn lacquer(name: &str, diffuse: [f32; 3]) -> Material {
    Material { illumination_model: 2, specular: Vec3::splat(0.05), shininess: 120.0, ..matt(name, diffuse) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Effect, effects};

    #[test]
    fn every_object_has_its_material_and_nothing_hangs_below_the_floor() {
        for level in ["large", "huge"] {
            let bare = Scene::load(&format!("thesis:{level}")).unwrap();
            let count = bare.triangles.len();
            assert!(bare.bounds().min.y > FLOOR && bare.bounds().min.y < FLOOR + 0.5, "{}", bare.bounds().min.y);
            let scene = dressed(bare.clone());
            assert_eq!(scene.triangles[..count], bare.triangles);
            assert_eq!((scene.material_ids.len(), scene.triangles.len()), (count + 6, count + 6));
            for object in &scene.objects {
                for id in object.triangles.clone() {
                    assert_eq!(scene.materials[usize::from(scene.material_ids[id])].name, object.name);
                }
            }
            let on: Vec<_> = effects(&scene).into_iter().map(|found| found.effect).collect();
            let expected = [Effect::Shadow, Effect::Mirror, Effect::Transparency, Effect::Refraction, Effect::Emission];
            assert_eq!(on, expected);
        }
    }
}
