//! The effects a scene's materials call for, derived from their MTL statements.

use super::{Material, Scene};
use glam::Vec3;

/// Something a renderer would have to do for a material to look as its file says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effect {
    /// Mirror reflection: illumination models 3, 4, 5, 8 and 9.
    Mirror,
    /// Seeing through: opacity below 1, or illumination models 4 and 9 (glass).
    Transparency,
    /// Bending of light: illumination models 6 and 7, or opacity below 1 with an index of refraction other than 1.
    Refraction,
    /// Emitted light: `Ke` above 0.
    Emission,
}

impl Effect {
    /// Every effect.
    pub const ALL: [Self; 4] = [Self::Mirror, Self::Transparency, Self::Refraction, Self::Emission];

    /// Its name in rows, JSON and on the command line.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Mirror => "mirror",
            Self::Transparency => "transparency",
            Self::Refraction => "refraction",
            Self::Emission => "emission",
        }
    }

    /// Whether the material calls for it (MTL format, Wavefront 1995, illumination models 0 to 10).
    pub fn is_called_for_by(self, material: &Material) -> bool {
        let model = material.illumination_model;
        let see_through = material.opacity < 1.0;
        match self {
            Self::Mirror => matches!(model, 3 | 4 | 5 | 8 | 9),
            Self::Transparency => see_through || matches!(model, 4 | 9),
            Self::Refraction => matches!(model, 6 | 7) || (see_through && material.refraction_index != 1.0),
            Self::Emission => material.emission.cmpgt(Vec3::ZERO).any(),
        }
    }
}

/// An effect and the materials that call for it.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct EffectUse {
    /// The effect.
    pub effect: Effect,
    /// Names of the materials, in the scene's order.
    pub materials: Vec<String>,
}

/// The effects called for by materials that some triangle has, in the order of [`Effect::ALL`].
pub fn effects(scene: &Scene) -> Vec<EffectUse> {
    let mut is_used = vec![false; scene.materials.len()];
    for &id in &scene.material_ids {
        is_used[usize::from(id)] = true;
    }
    let used = || scene.materials.iter().zip(&is_used).filter(|&(_, &used)| used);
    Effect::ALL
        .into_iter()
        .map(|effect| EffectUse {
            effect,
            materials: used()
                .filter(|(material, _)| effect.is_called_for_by(material))
                .map(|(material, _)| material.name.clone())
                .collect(),
        })
        .filter(|found| !found.materials.is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn called_for(material: Material) -> Vec<Effect> {
        Effect::ALL.into_iter().filter(|effect| effect.is_called_for_by(&material)).collect()
    }

    fn model(illumination_model: u8) -> Material {
        Material { illumination_model, ..Material::default() }
    }

    #[test]
    fn statements_call_for_effects() {
        use Effect::{Emission, Mirror, Refraction, Transparency};
        let calls = (0..=10).map(|illum| called_for(model(illum)));
        let expected: [&[Effect]; 11] = [
            &[],
            &[],
            &[],
            &[Mirror],
            &[Mirror, Transparency],
            &[Mirror],
            &[Refraction],
            &[Refraction],
            &[Mirror],
            &[Mirror, Transparency],
            &[],
        ];
        assert!(calls.eq(expected));
        let see_through = |refraction_index| Material { opacity: 0.5, refraction_index, ..Material::default() };
        assert_eq!(called_for(see_through(1.0)), [Transparency]);
        assert_eq!(called_for(see_through(1.5)), [Transparency, Refraction]);
        let opaque = Material { refraction_index: 1.5, ..Material::default() };
        assert_eq!(called_for(opaque), []);
        let lamp = Material { emission: Vec3::Z, ..Material::default() };
        assert_eq!(called_for(lamp), [Emission]);
    }

    #[test]
    fn only_materials_in_use_count() {
        let mut scene = Scene::load("gen:soup:3").unwrap();
        assert_eq!(effects(&scene), []);
        let named = |name: &str, illum| Material { name: name.into(), ..model(illum) };
        scene.materials.extend([named("a", 3), named("unused", 7), named("b", 9)]);
        scene.material_ids = vec![3, 0, 1];
        let found: Vec<_> = effects(&scene).into_iter().map(|e| (e.effect, e.materials.join(","))).collect();
        assert_eq!(found, [(Effect::Mirror, "a,b".into()), (Effect::Transparency, "b".into())]);
        let json = serde_json::to_string(&effects(&scene)[1]).unwrap();
        assert_eq!(json, r#"{"effect":"transparency","materials":["b"]}"#);
    }
}
