//! Rows 1 and 2 at length: rays from inside closed spheres, near the origin and far from it, of which not one may get out.
//!
//! ```text
//! cargo test --release --test matrix -- --ignored --nocapture ten_million
//! ```

use crate::cases::SEED;
use crate::judge::{Tree, trees};
use crate::rays::{Random, bounds, from_inside, towards};
use crate::scenes::sphere;
use crate::variants::variants;
use bvh_lab::geom::{Ray, Triangle};
use bvh_lab::trace::{KERNELS, Query, Scratch, Tracer};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Rays that one stream of random numbers makes.
const CHUNK: usize = 10_000;

/// A closed mesh and where in it rays begin.
struct Room {
    name: &'static str,
    triangles: Vec<Triangle>,
    centre: DVec3,
    reach: DVec3,
}

impl Room {
    fn new(name: &'static str, centre: Vec3, radius: f64) -> Self {
        let triangles = sphere(centre, radius, 32);
        let bounds = bounds(&triangles);
        Self { name, triangles, centre: bounds.centre(), reach: bounds.extent() * 0.25 }
    }

    /// Every other one at a corner or a point of an edge, where a ray is most likely to slip through.
    fn ray(&self, random: &mut Random, i: usize) -> Ray {
        let from = self.centre + self.reach * random.in_cube();
        if i.is_multiple_of(2) {
            return towards(from, from + self.reach * random.in_cube());
        }
        let [a, b, _] = self.triangles[random.below(self.triangles.len())].v.map(|p| p.as_dvec3());
        let along = [0.0, 0.5, random.unit()][random.below(3)];
        towards(from, a + (b - a) * along)
    }

    /// Misses among so many rays, and at all corners and middles of edges seen from the centre; and how many rays they were.
    fn misses(&self, tracer: &Tracer, rays: usize) -> (usize, usize) {
        let chunk = |chunk: usize| {
            let (random, mut scratch) = (&mut Random::new(SEED + chunk as u64), Scratch::default());
            let missed = (0..CHUNK).filter(|&i| {
                let ray = self.ray(random, i);
                tracer.trace(Query::Closest, &ray, &mut scratch, &mut ()).is_none()
            });
            missed.count()
        };
        let chunks = rays.div_ceil(CHUNK);
        let features = from_inside(&self.triangles, SEED, 0);
        let mut scratch = Scratch::default();
        let missed = features.iter().filter(|ray| tracer.trace(Query::Closest, ray, &mut scratch, &mut ()).is_none());
        let missed = missed.count() + (0..chunks).into_par_iter().map(chunk).sum::<usize>();
        (missed, chunks * CHUNK + features.len())
    }
}

fn no_ray_gets_out(rays: usize) {
    for room in [Room::new("here", Vec3::ZERO, 1.0), Room::new("far", Vec3::new(148_376.0, 1234.0, -223_423.0), 2.0)] {
        // Spatial splits put parts of triangles into leaves: there most could go wrong.
        let built = [("sbvh", 2), ("sbvh", 8), ("binned-sah", 8)].map(|(id, arity)| {
            variants().find(|(b, o)| b.id == id && o.arity == arity).expect("a builder that is registered")
        });
        let forest: Vec<Tree> = trees(&room.triangles, &built);
        for (tree, info) in forest.iter().flat_map(|tree| KERNELS.iter().map(move |info| (tree, info))) {
            let exact = info.kernel.is_exact();
            let rays = if exact { rays } else { rays / 10 };
            let (missed, of) = room.misses(&Tracer::new(info.kernel, &tree.bvh, &room.triangles), rays);
            let (name, triangles) = (room.name, room.triangles.len());
            println!("{name}, {triangles} triangles, {}: {} misses {missed} of {of} rays", tree.name, info.id);
            assert!(!exact || missed == 0, "{} on {} misses {missed} rays", info.id, tree.name);
        }
    }
}

#[test]
fn a_hundred_thousand_rays_stay_inside() {
    no_ray_gets_out(100_000);
}

#[test]
#[ignore = "takes minutes"]
fn ten_million_rays_stay_inside() {
    no_ray_gets_out(10_000_000);
}
