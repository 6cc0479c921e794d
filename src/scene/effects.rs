//! The effects that a scene's materials and lights call for, derived from their MTL statements.

use super::{Material, Scene};
use glam::Vec3;
use std::fmt;
use std::str::FromStr;

/// Something a renderer has to do for a scene to look as its file says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effect {
    /// Shadows: rays towards the lights, called for by what emits light.
    Shadow,
    /// Mirror reflection: illumination models 3, 5 and 8 with `Ks` above 0, and see-through surfaces of models 4, 6, 7
    /// and 9, which reflect as glass does.
    Mirror,
    /// Seeing through: opacity below 1, or illumination models 6 and 7.
    Transparency,
    /// Bending of what is seen through: illumination models 6 and 7, or an index of refraction other than 1.
    Refraction,
    /// Emitted light: `Ke` above 0.
    Emission,
    /// Shapes cut out of a surface by a picture: `map_d`.
    CutOut,
    /// Colours from a picture: `map_Kd`.
    Texture,
}

impl Effect {
    /// Every effect.
    pub const ALL: [Self; 7] =
        [Self::Shadow, Self::Mirror, Self::Transparency, Self::Refraction, Self::Emission, Self::CutOut, Self::Texture];

    /// Its name in rows, JSON and on the command line.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Shadow => "shadow",
            Self::Mirror => "mirror",
            Self::Transparency => "transparency",
            Self::Refraction => "refraction",
            Self::Emission => "emission",
            Self::CutOut => "cut-out",
            Self::Texture => "texture",
        }
    }

    /// Whether the material calls for it (MTL format, Wavefront 1995, illumination models 0 to 10).
    pub fn is_called_for_by(self, material: &Material) -> bool {
        let model = material.illumination_model;
        match self {
            Self::Mirror => {
                let glass = matches!(model, 4 | 6 | 7 | 9) && material.transmittance() > 0.0;
                let polished = matches!(model, 3 | 5 | 8) && material.specular.cmpgt(Vec3::ZERO).any();
                polished || (glass && material.refraction_index != 1.0)
            }
            Self::Transparency => material.transmittance() > 0.0,
            Self::Refraction => {
                material.transmittance() > 0.0 && (matches!(model, 6 | 7) || material.refraction_index != 1.0)
            }
            Self::Shadow | Self::Emission => material.emission.cmpgt(Vec3::ZERO).any(),
            Self::CutOut => material.opacity_map.is_some(),
            Self::Texture => material.diffuse_map.is_some(),
        }
    }
}

impl Material {
    /// The share of light that its surface lets in: 1 − opacity, but all of it for illumination models 6 and 7, which bend
    /// what passes through, where the file leaves the opacity at 1.
    pub fn transmittance(&self) -> f32 {
        if self.opacity >= 1.0 && matches!(self.illumination_model, 6 | 7) { 1.0 } else { 1.0 - self.opacity }
    }
}

/// A set of effects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EffectSet(u8);

impl EffectSet {
    /// No effect.
    pub const EMPTY: Self = Self(0);
    /// Every effect.
    pub const ALL: Self = Self((1 << Effect::ALL.len()) - 1);

    /// This set and one more.
    #[must_use]
    pub const fn with(self, effect: Effect) -> Self {
        Self(self.0 | 1 << effect as u8)
    }

    /// Whether it holds `effect`.
    pub const fn has(self, effect: Effect) -> bool {
        self.0 >> effect as u8 & 1 == 1
    }

    /// What is in both.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// What is in this set and not in the other.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Whether it holds nothing.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// What is in either.
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// One bit an effect, the first of [`Effect::ALL`] lowest.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// The set of such bits; bits beyond those of [`Effect::ALL`] are no effects.
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits & Self::ALL.0)
    }

    /// Its effects, in the order of [`Effect::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.into_iter().filter(move |&effect| self.has(effect))
    }

    /// What a material calls for.
    pub fn of(material: &Material) -> Self {
        Effect::ALL.into_iter().filter(|effect| effect.is_called_for_by(material)).collect()
    }
}

impl FromIterator<Effect> for EffectSet {
    fn from_iter<T: IntoIterator<Item = Effect>>(effects: T) -> Self {
        effects.into_iter().fold(Self::EMPTY, Self::with)
    }
}

impl fmt::Display for EffectSet {
    /// `mirror, shadow`, or `none`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.write_str("none");
        }
        f.write_str(&self.iter().map(Effect::id).collect::<Vec<_>>().join(", "))
    }
}

/// What is wrong with the words for a set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no effect '{0}'; there are all, none, {known}", known = EffectSet::ALL)]
pub struct UnknownEffect(String);

impl FromStr for EffectSet {
    type Err = UnknownEffect;

    /// `all`, `none`, or names with commas between.
    fn from_str(text: &str) -> Result<Self, UnknownEffect> {
        let find = |word: &str| {
            let known = Effect::ALL.into_iter().find(|effect| effect.id() == word);
            known.ok_or_else(|| UnknownEffect(word.escape_debug().to_string()))
        };
        match text {
            "all" => Ok(Self::ALL),
            "none" => Ok(Self::EMPTY),
            _ => text.split(',').map(|word| find(word.trim())).collect(),
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

/// Which materials some triangle has, one entry a material.
pub fn used_materials(scene: &Scene) -> Vec<bool> {
    let mut is_used = vec![false; scene.materials.len()];
    for &id in &scene.material_ids {
        is_used[usize::from(id)] = true;
    }
    is_used
}

/// The effects called for by materials that some triangle has, in the order of [`Effect::ALL`].
pub fn effects(scene: &Scene) -> Vec<EffectUse> {
    let is_used = used_materials(scene);
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
    use super::Effect::{CutOut, Emission, Mirror, Refraction, Shadow, Texture, Transparency};
    use super::*;

    fn called_for(material: Material) -> Vec<Effect> {
        EffectSet::of(&material).iter().collect()
    }

    fn model(illumination_model: u8) -> Material {
        Material { illumination_model, specular: Vec3::ONE, ..Material::default() }
    }

    #[test]
    fn statements_call_for_effects() {
        let calls =
            |clear: f32| (0..=10).map(move |illum| called_for(Material { opacity: 1.0 - clear, ..model(illum) }));
        let opaque: [&[Effect]; 11] = [
            &[],
            &[],
            &[],
            &[Mirror],
            &[],
            &[Mirror],
            &[Transparency, Refraction],
            &[Transparency, Refraction],
            &[Mirror],
            &[],
            &[],
        ];
        assert!(calls(0.0).eq(opaque));
        assert_eq!(called_for(Material { specular: Vec3::ZERO, ..model(3) }), [], "nothing is reflected");
        let see_through = |refraction_index, illumination_model| Material {
            opacity: 0.5,
            refraction_index,
            ..model(illumination_model)
        };
        assert_eq!(called_for(see_through(1.0, 1)), [Transparency]);
        assert_eq!(called_for(see_through(1.0, 4)), [Transparency]);
        assert_eq!(called_for(see_through(1.5, 1)), [Transparency, Refraction]);
        for glass in [4, 6, 7, 9] {
            assert_eq!(called_for(see_through(1.5, glass)), [Mirror, Transparency, Refraction]);
        }
        let opaque = Material { refraction_index: 1.5, ..Material::default() };
        assert_eq!(called_for(opaque), []);
        let lamp = Material { emission: Vec3::Z, ..Material::default() };
        assert_eq!(called_for(lamp), [Shadow, Emission]);
        let picture = Some(crate::scene::Texture::file("x.png".into()));
        let leaf = Material { diffuse_map: picture.clone(), opacity_map: picture, ..Material::default() };
        assert_eq!(called_for(leaf), [CutOut, Texture]);
    }

    #[test]
    fn only_materials_in_use_count() {
        let mut scene = Scene::load("gen:soup:3").unwrap();
        assert_eq!(effects(&scene), []);
        let named = |name: &str, illum| Material { name: name.into(), ..model(illum) };
        scene.materials.extend([named("a", 3), named("unused", 9), named("b", 7)]);
        scene.material_ids = vec![3, 0, 1];
        let found: Vec<_> = effects(&scene).into_iter().map(|e| (e.effect, e.materials.join(","))).collect();
        assert_eq!(found, [(Mirror, "a".into()), (Transparency, "b".into()), (Refraction, "b".into())]);
        let json = serde_json::to_string(&effects(&scene)[1]).unwrap();
        assert_eq!(json, r#"{"effect":"transparency","materials":["b"]}"#);
        assert_eq!(serde_json::to_string(&CutOut).unwrap(), r#""cut-out""#);
    }

    #[test]
    fn sets_are_written_and_read() {
        let set: EffectSet = "mirror,cut-out".parse().unwrap();
        assert_eq!((set.to_string(), set.iter().count()), ("mirror, cut-out".into(), 2));
        assert_eq!(("all".parse(), "none".parse()), (Ok(EffectSet::ALL), Ok(EffectSet::EMPTY)));
        assert!(EffectSet::ALL.has(Texture) && EffectSet::EMPTY.is_empty() && EffectSet::EMPTY.to_string() == "none");
        assert_eq!(EffectSet::ALL.without(set).and(set), EffectSet::EMPTY);
        let told = "glitter".parse::<EffectSet>().unwrap_err().to_string();
        assert!(told.contains("no effect 'glitter'; there are all, none, shadow, mirror"), "{told}");
    }
}
