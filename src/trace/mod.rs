//! Tracing kernels, one file each, and the probes that count their work; ray sets and the thesis' pictures.

mod batch;
mod closest;
mod first_leaf;
mod gather;
mod hits;
mod kernels;
mod lighting;
mod oracle;
mod probe;
mod published_camera;
mod ray_file;
mod ray_sets;
mod scratch;
mod secondary;
mod slab;
mod tracer;
mod wide;

#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

pub use batch::{Batch, count_batch, trace_batch};
pub use closest::{FastTest, TriangleTest, any_hit, brute_force, closest_hit};
pub use first_leaf::{FirstLeafOptions, first_leaf};
pub use gather::{all_hits, brute_force_all};
pub use hits::{HitRecord, hit_bytes, hit_hash, write_hits};
pub use kernels::{Bits, KERNELS, Kernel, KernelInfo, Query, Width};
pub use lighting::{
    ImageCounts, ImageDigest, PUBLISHED_CHAIN, Reading, StudyView, TEXT_CHAIN, run_image, run_image_parallel,
    trace_image,
};
pub use oracle::{Arithmetic, Crossing, Oracle, Verdict};
pub use probe::{TraceCounters, TraceProbe};
pub use published_camera::{PublishedCamera, THESIS_SIZE};
pub use ray_file::{RayFileError, read_rays, write_rays};
pub use ray_sets::{diffuse_rays, primary_rays, shadow_rays};
pub use scratch::Scratch;
pub use secondary::{enter_surface, facing_normal, leave_surface, mirror};
pub use tracer::Tracer;
pub use wide::WideBvh;
