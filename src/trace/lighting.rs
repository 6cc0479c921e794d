//! The thesis' study: one picture, three lighting cases, two readings; what every pixel costs in nodes and tests.

use super::closest::closest_hit;
use super::first_leaf::{FirstLeafOptions, first_leaf};
use super::probe::{TraceCounters, TraceProbe};
use super::published_camera::PublishedCamera;
use super::scratch::Scratch;
use super::secondary::{leave_surface, mirror};
use crate::bvh::Bvh;
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::rows::Lighting;
use glam::Vec3;
use rayon::prelude::*;

/// See-through rays of one pixel after which the `published` reading cuts the chain, and counts the cut.
pub const PUBLISHED_CHAIN: u64 = 100;
/// The same for the `text` reading: a guard only, as its chains end with the scene.
pub const TEXT_CHAIN: u64 = 10_000;

/// What is looked at.
#[derive(Clone, Copy, Debug)]
pub struct StudyView<'a> {
    /// The tree.
    pub bvh: &'a Bvh,
    /// The scene's triangles, by id.
    pub triangles: &'a [Triangle],
    /// Unit smooth normals of the three vertices of every triangle, by id; zero where there is none.
    pub normals: &'a [[Vec3; 3]],
    /// From where, and how many pixels.
    pub camera: PublishedCamera,
}

/// Which of the two readings of the thesis traces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// What the program did: kernel `first-leaf`; secondary rays start at direction · t, *without the ray's origin added*.
    /// The mirror direction is that of v = start − (ray origin), not of the ray's direction.
    Published(FirstLeafOptions),
    /// What the thesis says: kernel `scalar`; secondary rays start where the ray hit. The mirrored ray starts a rounding's
    /// breadth off the surface ([`leave_surface`]), the see-through ray is the same ray from the next greater t on, so
    /// that triangles at exactly the same t count as one surface.
    Text,
}

/// What a picture took. All sums are of integers, so they are the same for any number of threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImageCounts {
    /// Pixels.
    pub pixels: u64,
    /// Rays cast, primary and secondary.
    pub rays: u64,
    /// Pixels whose primary ray hit something.
    pub hits: u64,
    /// See-through chains that were cut ([`PUBLISHED_CHAIN`], [`TEXT_CHAIN`]).
    pub cut: u64,
    /// Nodes entered, inner and leaf.
    pub nodes: u64,
    /// Boxes tested.
    pub box_tests: u64,
    /// Triangles tested.
    pub triangle_tests: u64,
    /// Wrapping sum over all hits of all rays: two runs that agree here saw the same.
    pub checksum: u64,
}

/// What a timed picture returns: enough that nothing is optimised away, and that it can be held against the counted one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ImageDigest {
    /// Rays cast, primary and secondary.
    pub rays: u64,
    /// Pixels whose primary ray hit something.
    pub hits: u64,
    /// See-through chains that were cut.
    pub cut: u64,
    /// As [`ImageCounts::checksum`].
    pub checksum: u64,
}

impl std::ops::Add for ImageDigest {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            cut: self.cut + other.cut,
            checksum: self.checksum.wrapping_add(other.checksum),
        }
    }
}

impl ImageCounts {
    /// The part that a timed run returns as well.
    pub fn digest(&self) -> ImageDigest {
        ImageDigest { rays: self.rays, hits: self.hits, cut: self.cut, checksum: self.checksum }
    }
}

/// Counts the work of a picture, on the current rayon pool.
pub fn trace_image(view: &StudyView, lighting: Lighting, reading: Reading) -> ImageCounts {
    let (digest, work) = (0..view.camera.height())
        .into_par_iter()
        .map_init(Scratch::default, |scratch, y| {
            let mut work = TraceCounters::default();
            (trace_row(view, lighting, reading, y, scratch, &mut work), work)
        })
        .reduce(Default::default, |a, b| (a.0 + b.0, a.1 + b.1));
    ImageCounts {
        pixels: u64::from(view.camera.width()) * u64::from(view.camera.height()),
        rays: digest.rays,
        hits: digest.hits,
        cut: digest.cut,
        nodes: work.nodes,
        box_tests: work.box_tests,
        triangle_tests: work.triangle_tests,
        checksum: digest.checksum,
    }
}

/// Traces a picture without counting, on the calling thread: what is timed for Tables 4, 6 and 8.
pub fn run_image(view: &StudyView, lighting: Lighting, reading: Reading) -> ImageDigest {
    let mut scratch = Scratch::default();
    (0..view.camera.height())
        .map(|y| trace_row(view, lighting, reading, y, &mut scratch, &mut ()))
        .fold(ImageDigest::default(), |a, b| a + b)
}

/// As [`run_image`], on the current rayon pool.
pub fn run_image_parallel(view: &StudyView, lighting: Lighting, reading: Reading) -> ImageDigest {
    (0..view.camera.height())
        .into_par_iter()
        .map_init(Scratch::default, |scratch, y| trace_row(view, lighting, reading, y, scratch, &mut ()))
        .reduce(ImageDigest::default, |a, b| a + b)
}

fn trace_row<P: TraceProbe>(
    view: &StudyView,
    lighting: Lighting,
    reading: Reading,
    y: u32,
    scratch: &mut Scratch,
    probe: &mut P,
) -> ImageDigest {
    let mut tracer = Tracer { view, reading, scratch, probe, digest: ImageDigest::default() };
    for x in 0..view.camera.width() {
        let ray = view.camera.ray(x, y);
        let Some(hit) = tracer.cast(&ray) else { continue };
        tracer.digest.hits += 1;
        match lighting {
            Lighting::Primary => {}
            Lighting::Reflection => tracer.reflect(&ray, &hit),
            Lighting::Opacity => tracer.see_through(ray, hit),
        }
    }
    tracer.digest
}

/// One row's work in progress.
struct Tracer<'a, P> {
    view: &'a StudyView<'a>,
    reading: Reading,
    scratch: &'a mut Scratch,
    probe: &'a mut P,
    digest: ImageDigest,
}

impl<P: TraceProbe> Tracer<'_, P> {
    fn cast(&mut self, ray: &Ray) -> Option<Hit> {
        let StudyView { bvh, triangles, .. } = *self.view;
        let hit = match self.reading {
            Reading::Published(options) => first_leaf(bvh, triangles, ray, options, self.scratch, self.probe),
            Reading::Text => closest_hit::<WatertightRay, P>(bvh, triangles, ray, self.scratch, self.probe),
        };
        self.digest.rays += 1;
        if let Some(hit) = hit {
            let mixed =
                (u64::from(hit.triangle) << 32 | u64::from(hit.t.to_bits())).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            self.digest.checksum = self.digest.checksum.wrapping_add(mixed ^ (mixed >> 29));
        }
        hit
    }

    /// Depth 2: one mirrored ray, whose own hit ends it.
    fn reflect(&mut self, ray: &Ray, hit: &Hit) {
        let normal = self.view.normals[hit.triangle as usize][0];
        let mirrored = match self.reading {
            Reading::Published(_) => {
                let start = ray.direction * hit.t;
                Ray::new(start, mirror(start - ray.origin, normal))
            }
            Reading::Text => {
                let start = leave_surface(ray, hit, &self.view.triangles[hit.triangle as usize]);
                Ray::new(start, mirror(ray.direction, normal))
            }
        };
        self.cast(&mirrored);
    }

    /// Opacity ½: the ray goes on behind each hit.
    fn see_through(&mut self, mut ray: Ray, mut hit: Hit) {
        let longest = match self.reading {
            Reading::Published(_) => PUBLISHED_CHAIN,
            Reading::Text => TEXT_CHAIN,
        };
        for _ in 0..longest {
            match self.reading {
                Reading::Published(_) => ray.origin = ray.direction * hit.t,
                Reading::Text => ray.t_min = hit.t.next_up(),
            }
            match self.cast(&ray) {
                Some(next) => hit = next,
                None => return,
            }
        }
        self.digest.cut += 1;
    }
}
