//! Scenes whose vertices have moved: any scene, twisted about its vertical axis. What refitting is tried on.

use super::Scene;
use crate::geom::Triangle;
use glam::DVec3;

/// Turns every vertex about the vertical line through the middle of the scene, by an angle in degrees that grows evenly with its
/// height: −`degrees`/2 at the bottom, +`degrees`/2 at the top. Triangles, their ids and the camera stay; a scene without height
/// does not change. In f64, with one rounding to f32: the same bits on every machine.
///
/// Returns whether all vertices are still finite; if not, nothing has been moved.
#[must_use]
pub fn twist(scene: &mut Scene, degrees: f64) -> bool {
    let bounds = scene.bounds();
    let (middle, height) = (bounds.centre(), bounds.extent().y);
    let turned = |t: &Triangle| Triangle {
        v: t.v.map(|p| {
            let p = p.as_dvec3();
            let angle = if height > 0.0 { degrees.to_radians() * ((p.y - middle.y) / height) } else { 0.0 };
            if angle == 0.0 {
                return p.as_vec3();
            }
            let (sin, cos, arm) = (libm::sin(angle), libm::cos(angle), p - middle);
            let (x, z) = (cos * arm.x + sin * arm.z, cos * arm.z - sin * arm.x);
            DVec3::new(middle.x + x, p.y, middle.z + z).as_vec3()
        }),
    };
    let triangles: Vec<Triangle> = scene.triangles.iter().map(turned).collect();
    let finite = triangles.iter().all(Triangle::is_finite);
    if finite {
        scene.triangles = triangles;
    }
    finite
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;
    use glam::Vec3;

    fn of(triangles: &[Triangle]) -> Scene {
        Scene { triangles: triangles.to_vec(), ..Scene::load("gen:soup:1").unwrap() }
    }

    #[test]
    fn the_top_turns_one_way_and_the_bottom_the_other() {
        let at = |y: f32| Triangle::new(Vec3::new(2.0, y, 0.0), Vec3::new(-2.0, y, 0.0), Vec3::new(0.0, y, 2.0));
        let mut scene = of(&[at(-1.0), at(0.0), at(1.0), at(0.5)]);
        // The middle of the bounds is (0, 0, 1).
        assert!(twist(&mut scene, 180.0));
        let first = |i: usize| scene.triangles[i].v[0];
        let near = |a: Vec3, x, y, z| assert!(a.distance(Vec3::new(x, y, z)) < 1e-6, "{a}");
        near(first(0), 1.0, -1.0, 3.0);
        assert_eq!(first(1), Vec3::new(2.0, 0.0, 0.0));
        near(first(2), -1.0, 1.0, -1.0);
        let middle = DVec3::new(0.0, 0.0, 1.0);
        for (before, after) in [at(-1.0), at(0.0), at(1.0), at(0.5)].iter().zip(&scene.triangles) {
            for (p, q) in before.v.iter().zip(after.v) {
                let arm = |p: Vec3| (p.as_dvec3() - middle).length();
                assert!((arm(*p) - arm(q)).abs() < 1e-6 && p.y == q.y);
            }
        }
    }

    #[test]
    fn no_angle_no_height_no_change_and_no_infinity() {
        let soup = Scene::load("gen:soup:50").unwrap();
        let mut same = soup.clone();
        assert!(twist(&mut same, 0.0) && same.triangles == soup.triangles);
        let flat = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Z);
        let mut scene = of(&[flat]);
        assert!(twist(&mut scene, 90.0) && scene.triangles == [flat]);
        // A corner that would turn to where no f32 is.
        let huge = Triangle::new(Vec3::splat(f32::MAX), -Vec3::splat(f32::MAX), Vec3::new(f32::MAX, 0.0, f32::MAX));
        let mut scene = of(&[huge]);
        assert!(!twist(&mut scene, 90.0) && scene.triangles == [huge]);
        assert!(Aabb::around(huge.v).is_valid());
    }
}
