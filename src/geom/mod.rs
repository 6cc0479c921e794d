//! Geometry: boxes, rays, triangles. The only surface area and the only triangle tests live here.

mod aabb;
mod polygon;
mod ray;
mod triangle;
mod watertight;

pub use aabb::{Aabb, area_of_extent};
pub(crate) use aabb::{lower, upper};
pub(crate) use polygon::{Polygon, cut, polygon_area};
pub use ray::Ray;
pub use triangle::{Hit, Triangle};
pub(crate) use watertight::Axis;
pub use watertight::WatertightRay;
