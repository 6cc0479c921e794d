//! Ray sets to measure with: primary, diffuse and shadow-like rays, the same on every machine and for any thread count.

use super::closest::closest_hit;
use super::scratch::Scratch;
use super::secondary::{facing_normal, leave_surface};
use crate::bvh::Bvh;
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::scene::Camera;
use glam::DVec3;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;

/// One ray through the centre of every pixel, row by row from the upper left.
pub fn primary_rays(camera: &Camera, width: u32, height: u32) -> Vec<Ray> {
    let view = camera.view(width, height);
    (0..height).flat_map(|y| (0..width).map(move |x| view.ray(x, y))).collect()
}

/// One ray from the closest hit of every primary ray that has one, in the order of `primary`: its direction drawn from the
/// cosine distribution around the geometric normal on the side the primary ray came from.
///
/// Every ray has its own random stream, (`seed`, index of its primary ray).
pub fn diffuse_rays(bvh: &Bvh, triangles: &[Triangle], primary: &[Ray], seed: u64) -> Vec<Ray> {
    from_hits(bvh, triangles, primary, seed, |ray, hit, random| {
        let triangle = &triangles[hit.triangle as usize];
        // A normal plus a point on the unit sphere is cosine-distributed (Shirley 1992); opposite points give no direction.
        let direction = facing_normal(triangle, ray) + on_sphere(random);
        let direction = direction.try_normalize().unwrap_or(facing_normal(triangle, ray));
        Ray::new(leave_surface(ray, hit, triangle), direction.as_vec3())
    })
}

/// One ray from the closest hit of every primary ray that has one, in the order of `primary`, to a random point on the
/// sphere around the root's box: shadow-like rays with `t_max` = 1 at that point, for [`super::Query::Any`].
///
/// Every ray has its own random stream, (`seed`, index of its primary ray).
pub fn shadow_rays(bvh: &Bvh, triangles: &[Triangle], primary: &[Ray], seed: u64) -> Vec<Ray> {
    let bounds = bvh.root().aabb;
    let (centre, radius) = (bounds.centre(), bounds.extent().length() * 0.5);
    from_hits(bvh, triangles, primary, seed, |ray, hit, random| {
        let start = leave_surface(ray, hit, &triangles[hit.triangle as usize]);
        let light = centre + on_sphere(random) * radius;
        Ray { t_max: 1.0, ..Ray::new(start, (light - start.as_dvec3()).as_vec3()) }
    })
}

fn from_hits(
    bvh: &Bvh,
    triangles: &[Triangle],
    primary: &[Ray],
    seed: u64,
    next: impl Fn(&Ray, &Hit, &mut Pcg32) -> Ray + Sync,
) -> Vec<Ray> {
    primary
        .par_iter()
        .enumerate()
        .map_init(Scratch::default, |scratch, (index, ray)| {
            let hit = closest_hit::<WatertightRay, ()>(bvh, triangles, ray, scratch, &mut ())?;
            Some(next(ray, &hit, &mut Pcg32::new(seed, index as u64)))
        })
        .flatten_iter()
        .collect()
}

/// Uniform on the unit sphere.
fn on_sphere(random: &mut Pcg32) -> DVec3 {
    let mut unit = || f64::from(random.next_u32()) / (1u64 << 32) as f64;
    let (z, angle) = (1.0 - 2.0 * unit(), std::f64::consts::TAU * unit());
    let r = (1.0 - z * z).sqrt();
    // libm's sine and cosine: the platform's differ between systems in the last bit.
    DVec3::new(r * libm::cos(angle), r * libm::sin(angle), z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::soup;
    use crate::trace::testing::median_split;
    use glam::Vec3;

    fn camera() -> Camera {
        Camera { eye: Vec3::new(0.5, 0.7, 3.0), look_at: Vec3::splat(0.5), up: Vec3::Y, fov_degrees: 40.0 }
    }

    #[test]
    fn sets_are_repeatable_and_leave_the_surface() {
        let triangles = soup(5, 500, 0.2);
        let bvh = median_split(&triangles, 2);
        let primary = primary_rays(&camera(), 40, 30);
        assert_eq!(primary.len(), 1200);
        let sets = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| (diffuse_rays(&bvh, &triangles, &primary, 1), shadow_rays(&bvh, &triangles, &primary, 1)))
        });
        assert_eq!(sets[0], sets[1]);
        let (diffuse, shadow) = &sets[0];
        assert!(diffuse.len() > 200, "{}", diffuse.len());
        assert_eq!(diffuse.len(), shadow.len());
        assert_ne!(diffuse, &diffuse_rays(&bvh, &triangles, &primary, 2));
        let bounds = bvh.root().aabb;
        for ray in shadow {
            let end = ray.at(1.0).as_dvec3();
            let radius = bounds.extent().length() * 0.5;
            assert!((end.distance(bounds.centre()) / radius - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn diffuse_directions_follow_the_cosine() {
        let floor = [Triangle::new(Vec3::new(-9.0, 0.0, -9.0), Vec3::new(-9.0, 0.0, 99.0), Vec3::new(99.0, 0.0, -9.0))];
        let bvh = median_split(&floor, 2);
        let rays = diffuse_rays(&bvh, &floor, &vec![Ray::new(Vec3::Y, Vec3::NEG_Y); 20_000], 9);
        assert_eq!(rays.len(), 20_000);
        assert!(rays.iter().all(|r| r.direction.y >= 0.0 && r.direction.is_normalized()));
        let mean = rays.iter().map(|r| f64::from(r.direction.y)).sum::<f64>() / 20_000.0;
        assert!((mean - 2.0 / 3.0).abs() < 0.01, "{mean}");
    }
}
