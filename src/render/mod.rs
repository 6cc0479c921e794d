//! Pictures: rays from a camera, followed as far as the scene's materials and lights call for, onto a film.
//!
//! ```
//! use bvh_lab::render::{Frame, RayKind, Stage, StageOptions};
//! use bvh_lab::{build, scene::Scene};
//!
//! let scene = Scene::load("thesis:tiny")?;
//! let builder = build::find("binned-sah").expect("it is registered");
//! let boxes = scene.boxes();
//! let input = build::Input::of_boxes(&boxes);
//! let bvh = (builder.timed)(input, &build::BuildOptions::default(), &mut build::Brake::default())?;
//! let stage = Stage::new(&scene, &bvh, &StageOptions::default())?;
//! let picture = stage.render(&scene.camera.upright(), &Frame { width: 32, height: 24, rays_per_pixel: 4 });
//! assert_eq!(picture.rays.of(RayKind::Primary), 32 * 24 * 4);
//! assert_eq!(picture.rays.of(RayKind::Reflection), 0);
//! let png = picture.film.to_srgb(stage.exposure(&picture.film));
//! assert_eq!(png.dimensions(), (32, 24));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod counts;
mod crowd;
mod direct;
mod film;
mod framing;
mod heatmap;
mod integrator;
mod lights;
mod optics;
mod options;
mod reflectance;
mod sampler;
mod solid_angle;
mod split;
mod stage;
mod studio;
mod surface;
#[cfg(test)]
mod tests;
mod winding;

pub use counts::{RayCounts, RayKind};
pub use film::{Film, FilmError};
pub use heatmap::{DrawError, HeatMap, Quantity, draw, heat_colour};
pub use options::{Demand, Frame, StageOptions};
pub use stage::{Picture, Stage, StageError};
