//! Where secondary rays start and where they go.

use crate::geom::{Hit, Ray, Triangle};
use glam::{DVec3, Vec3};

/// Reflects `v` about the unit vector `normal`: v − 2(v·N)N.
#[inline]
pub fn mirror(v: Vec3, normal: Vec3) -> Vec3 {
    v - 2.0 * v.dot(normal) * normal
}

/// The unit geometric normal of `triangle` on the side that `ray` comes from; zero for a triangle without area.
pub fn facing_normal(triangle: &Triangle, ray: &Ray) -> DVec3 {
    let normal = triangle.cross().normalize_or_zero();
    if normal.dot(ray.direction.as_dvec3()) > 0.0 { -normal } else { normal }
}

/// A start for rays that leave the surface at `hit` on the side that `ray` came from: the hit point moved along the
/// geometric normal n by no more than rounding calls for.
///
/// The point o + t·d is computed in f64, so two roundings to f32 remain: that of t moves it by up to 2⁻²⁴·t·|dᵢ| along
/// axis i, that of the stored point by 2⁻²⁴·|pᵢ|. Its distance from the triangle's plane is then at most
/// Σ|nᵢ|·2⁻²⁴·(t·|dᵢ| + |pᵢ|). The point is moved by twice that bound, with |pᵢ| counted twice for the rounding of the
/// moved point: it cannot lie behind the plane, and stays within about 10⁻⁶ of the coordinates' size of it, far below the
/// gap of any wall one would model.
pub fn leave_surface(ray: &Ray, hit: &Hit, triangle: &Triangle) -> Vec3 {
    off_surface(ray, hit, facing_normal(triangle, ray))
}

/// As [`leave_surface`], on the other side: for rays that go on through the surface.
pub fn enter_surface(ray: &Ray, hit: &Hit, triangle: &Triangle) -> Vec3 {
    off_surface(ray, hit, -facing_normal(triangle, ray))
}

fn off_surface(ray: &Ray, hit: &Hit, normal: DVec3) -> Vec3 {
    const HALF_ULP: f64 = 1.0 / (1u64 << 24) as f64;
    let step = ray.direction.as_dvec3() * f64::from(hit.t);
    let point = ray.origin.as_dvec3() + step;
    let bound = normal.abs().dot(step.abs() + 2.0 * point.abs()) * HALF_ULP;
    (point + normal * (2.0 * bound)).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::Random;

    #[test]
    fn mirrors_about_the_normal() {
        assert_eq!(mirror(Vec3::new(1.0, -1.0, 0.5), Vec3::Y), Vec3::new(1.0, 1.0, 0.5));
        assert_eq!(mirror(Vec3::new(1.0, -1.0, 0.5), Vec3::ZERO), Vec3::new(1.0, -1.0, 0.5));
    }

    #[test]
    fn the_start_is_in_front_of_the_plane_and_close_to_it() {
        let mut random = Random(7);
        for scale in [1.0, 1e6, 1e-6] {
            for offset in [Vec3::ZERO, Vec3::new(1e3, -2e3, 5e2) * scale] {
                for _ in 0..2000 {
                    let triangle = Triangle { v: [(); 3].map(|()| random.point(1.0) * scale + offset) };
                    let inside = (triangle.v[0] + triangle.v[1] + triangle.v[2]) / 3.0;
                    let origin = random.point(1.0) * scale * 20.0 + offset;
                    let ray = Ray::new(origin, inside - origin);
                    let Some(t) = crate::geom::WatertightRay::new(&ray).meets(&triangle) else {
                        continue;
                    };
                    let start = leave_surface(&ray, &Hit { triangle: 0, t }, &triangle).as_dvec3();
                    let height = facing_normal(&triangle, &ray).dot(start - triangle.v[0].as_dvec3());
                    let size = f64::from(start.abs().max_element() as f32 + origin.length());
                    assert!(height > -1e-15 * size && height < 1.5e-6 * size, "{height:e} {size}");
                    let inside = enter_surface(&ray, &Hit { triangle: 0, t }, &triangle).as_dvec3();
                    let depth = facing_normal(&triangle, &ray).dot(triangle.v[0].as_dvec3() - inside);
                    assert!(depth > -1e-15 * size && depth < 1.5e-6 * size, "{depth:e} {size}");
                }
            }
        }
    }
}
