//! The rays that the laboratory's leaf count variability is about.

use crate::bvh::Bvh;
use crate::geom::Ray;
use crate::scene::Scene;
use crate::trace::{Batch, HitRecord, Kernel, Query, Tracer, diffuse_rays, primary_rays, trace_batch};

/// Seed of the rays that are drawn by chance, wherever the laboratory draws some for a scene: the same ones every time.
pub const RAY_SEED: u64 = 1;

/// Pixels of the camera's rays that the set starts from.
const SIZE: (u32, u32) = (512, 512);

/// The scene's diffuse rays, exactly those of `trace SCENE --rays diffuse`, each ending at its closest hit, if it has one: what a
/// path tracer traces, and incoherent, as rays are where lanes wait for each other. At most 512 × 512 rays; none where the camera
/// sees nothing.
///
/// The rays are those of the scene, whatever the tree: any valid one of it does (but one whose rule Q8 hides triangles). To
/// compare trees, take them once and give them to [`crate::cost::leaf_counts`] with each tree.
pub fn leaf_count_rays(scene: &Scene, bvh: &Bvh) -> Vec<Ray> {
    let primary = primary_rays(&scene.camera, SIZE.0, SIZE.1);
    let mut rays = diffuse_rays(bvh, &scene.triangles, &primary, RAY_SEED);
    let mut hits = Vec::new();
    let tracer = Tracer::new(Kernel::Scalar, bvh, &scene.triangles);
    trace_batch(&Batch { tracer: &tracer, query: Query::Closest, rays: &rays }, &mut hits);
    end_at_hits(&mut rays, &hits);
    rays
}

/// Lets every ray that hits something end there.
pub(super) fn end_at_hits(rays: &mut [Ray], hits: &[HitRecord]) {
    for (ray, hit) in rays.iter_mut().zip(hits).filter(|(_, hit)| hit.is_hit()) {
        ray.t_max = beyond(hit);
    }
}

/// A hair beyond the hit, so that the leaf that is hit counts however t was rounded.
fn beyond(hit: &HitRecord) -> f32 {
    hit.t * (1.0 + 1.0 / (1 << 20) as f32) + f32::MIN_POSITIVE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{Brake, BuildOptions, Input, find};
    use crate::cost::leaf_counts;
    use crate::geom::WatertightRay;
    use crate::trace::brute_force;

    #[test]
    fn rays_are_the_scenes_and_end_where_they_hit() {
        let scene = Scene::load("thesis:tiny").unwrap();
        let boxes = scene.boxes();
        let trees = ["sweep-sah", "agglo-local"].map(|id| {
            let options = BuildOptions { arity: 4, ..BuildOptions::default() };
            (find(id).unwrap().timed)(Input::of_boxes(&boxes), &options, &mut Brake::default()).unwrap()
        });
        let sets = [0, 1].map(|i| leaf_count_rays(&scene, &trees[i]));
        assert!(sets[0] == sets[1] && sets[0].len() > 1000);
        let ended = sets[0].iter().filter(|r| r.t_max < f32::INFINITY).count();
        assert!(ended > 100 && ended < sets[0].len(), "{ended} of {}", sets[0].len());
        for ray in sets[0].iter().step_by(997) {
            let whole = Ray { t_max: f32::INFINITY, ..*ray };
            match brute_force::<WatertightRay>(&scene.triangles, &whole) {
                Some(hit) => assert!(hit.t <= ray.t_max && ray.t_max <= hit.t * 1.000_01),
                None => assert_eq!(ray.t_max, f32::INFINITY),
            }
        }
        // What ends sooner meets less; every ray that hits something meets the leaf of what it hits.
        let whole: Vec<Ray> = sets[0].iter().map(|r| Ray { t_max: f32::INFINITY, ..*r }).collect();
        for bvh in &trees {
            assert!(leaf_counts(bvh, &sets[0]).unwrap().mean < leaf_counts(bvh, &whole).unwrap().mean);
            for ray in sets[0].iter().filter(|r| r.t_max < f32::INFINITY).step_by(17) {
                assert!(leaf_counts(bvh, &[*ray]).unwrap().mean >= 1.0, "{ray:?}");
            }
        }
    }
}
