//! How many rays were cast, by kind.

use serde::ser::{Serialize, SerializeMap, Serializer};
use std::ops::Add;

/// What a ray was cast for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RayKind {
    /// From the camera.
    Primary,
    /// Towards a light; one that passes clear or cut-out surfaces is cast anew behind each.
    Shadow,
    /// Off a mirror or a glass surface.
    Reflection,
    /// Into or out of a body that bends light, or turned back inside of it.
    Refraction,
    /// On through a clear surface, in a straight line.
    Transparency,
    /// On through a hole that a picture cuts into a surface.
    CutOut,
}

impl RayKind {
    /// Every kind.
    pub const ALL: [Self; 6] =
        [Self::Primary, Self::Shadow, Self::Reflection, Self::Refraction, Self::Transparency, Self::CutOut];

    /// Its name in JSON.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::Reflection => "reflection",
            Self::Refraction => "refraction",
            Self::Transparency => "transparency",
            Self::CutOut => "cut-out",
        }
    }
}

/// Rays cast, by kind: sums of integers, so they are the same for any number of threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts([u64; RayKind::ALL.len()]);

impl RayCounts {
    /// Rays of a kind.
    pub const fn of(&self, kind: RayKind) -> u64 {
        self.0[kind as usize]
    }

    /// Rays of all kinds.
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }

    #[inline(always)]
    pub(super) fn add(&mut self, kind: RayKind) {
        self.0[kind as usize] += 1;
    }
}

impl Add for RayCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Serialize for RayCounts {
    /// An object with every kind's name, zeros included.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(RayKind::ALL.len()))?;
        for kind in RayKind::ALL {
            map.serialize_entry(kind.id(), &self.of(kind))?;
        }
        map.end()
    }
}
