//! Geometry: boxes, rays, triangles. The only surface area and the only triangle tests live here.

mod aabb;
mod ray;
mod triangle;
mod watertight;

pub use aabb::{Aabb, area_of_extent};
pub(crate) use aabb::{lower, upper};
pub use ray::Ray;
pub use triangle::{Hit, Triangle};
pub use watertight::WatertightRay;
