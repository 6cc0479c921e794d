//! What is asked of a picture.

use crate::rows::Lighting;
use crate::scene::EffectSet;
use crate::trace::{Kernel, Width};
use glam::Vec3;

/// Which effects are simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Demand {
    /// Those that the materials in use call for, each where its material calls for it.
    #[default]
    Materials,
    /// Exactly these, on every surface: where the material does not call for one, its rays are cast all the same, one
    /// generation of them, and what they see counts for nothing. An effect not in the set is off, whoever calls for it.
    Forced(EffectSet),
    /// A lighting case of the thesis instead of the scene's materials: every surface a mirror whose ray is followed to its
    /// own hit (`Reflection`), every surface of opacity ½ (`Opacity`), or primary rays alone.
    Thesis(Lighting),
}

/// How a scene is made ready for pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageOptions {
    /// The effects.
    pub demand: Demand,
    /// What traces; pictures are the same by every exact kernel (default: `bvh8`).
    pub kernel: Kernel,
    /// How many mirrors and clear surfaces a ray is followed over (default 16).
    pub depth: u32,
    /// Rays whose share in their pixel would be below this are not cast (default 1/512, a step of 8-bit sRGB in the darks).
    pub least_weight: f32,
    /// Radiance where nothing is hit, linear RGB; of a scene that has lights of its own there is none.
    pub background: Vec3,
}

impl Default for StageOptions {
    fn default() -> Self {
        Self {
            demand: Demand::Materials,
            kernel: Kernel::Wide { width: Width::Eight, fast: false },
            depth: 16,
            least_weight: 1.0 / 512.0,
            background: Vec3::new(0.86, 0.88, 0.92),
        }
    }
}

/// The size of a picture, and its anti-aliasing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Rays through every pixel: 1 goes through its centre, more are spread over its area. 0 is taken for 1.
    pub rays_per_pixel: u32,
}
