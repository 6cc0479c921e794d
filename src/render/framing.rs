//! Where a scene without a camera is looked at from: from inside where it is a room, through its open side where it has one,
//! near what many of its triangles are in where that is small.

use super::crowd::crowded;
use crate::geom::{Aabb, Ray};
use crate::scene::{Camera, Scene};
use crate::trace::{Query, Scratch, Tracer};
use glam::{DVec3, Vec3};

/// Directions looked in from the middle.
const SIGHTS: u32 = 128;
/// Rays along each side of a trial picture.
const GRID: u32 = 24;
/// Field of view inside a room, in degrees.
const ROOM_FOV: f32 = 65.0;
/// The camera of the scene's file, upright; or one that shows what there is to see.
pub(super) fn viewpoint(scene: &Scene, tracer: &Tracer) -> Camera {
    let bounds = scene.bounds();
    if !bounds.is_valid() || !scene.cameras.is_empty() || scene.camera != Camera::framing(&bounds) {
        return scene.camera.upright();
    }
    let mut eye = Eye { scene, tracer, scratch: Scratch::default() };
    if let Some(room) = eye.inside(&bounds) {
        return room;
    }
    let up = upwards(&bounds);
    let bounds = crowded(scene, &bounds);
    let from = |side: DVec3| Camera::framing_from(&bounds, if up == Vec3::Z { z_up(side) } else { side }, up);
    let three_quarter = from(DVec3::new(0.5, 0.4, 0.75));
    // What is open to one side shows its inside there: half as deep again as it looks from the corner.
    let sides = [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::NEG_X, DVec3::Y];
    let open = sides
        .map(|side| from(side + DVec3::Y * 0.02))
        .map(|camera| (eye.depth_seen(&camera, &bounds), camera))
        .into_iter()
        .reduce(|best, other| if other.0 > best.0 * 1.05 { other } else { best });
    match open {
        Some((depth, camera)) if depth > 1.5 * eye.depth_seen(&three_quarter, &bounds) => camera,
        _ => three_quarter,
    }
}

/// What is flat lies on the ground: z is up where it is by far the scene's least extent, else y.
fn upwards(bounds: &Aabb) -> Vec3 {
    let extent = bounds.extent();
    if extent.z > 0.0 && extent.z * 3.0 < extent.x.min(extent.y) { Vec3::Z } else { Vec3::Y }
}

/// A direction in a world whose y is up, in one whose z is.
fn z_up(v: DVec3) -> DVec3 {
    DVec3::new(v.x, -v.z, v.y)
}

struct Eye<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer<'a>,
    scratch: Scratch,
}

impl Eye<'_> {
    /// Distance to the first surface, and whether it is the front of a wall; none where there is nothing.
    fn look(&mut self, from: DVec3, direction: DVec3) -> Option<(f64, bool)> {
        let ray = Ray::new(from.as_vec3(), direction.as_vec3());
        let hit = self.tracer.trace(Query::Closest, &ray, &mut self.scratch, &mut ())?;
        let id = hit.triangle as usize;
        let is_front = self.scene.triangles[id].cross().dot(direction) < 0.0;
        let material = &self.scene.materials[usize::from(self.scene.material_ids[id])];
        Some((f64::from(hit.t), is_front && material.transmittance() == 0.0))
    }

    /// A camera in the room around the middle of the scene: one that has walls, floor and ceiling whose fronts are inside. (Of a
    /// closed body, the backs are.)
    fn inside(&mut self, bounds: &Aabb) -> Option<Camera> {
        let middle = bounds.centre();
        let fronts = (0..SIGHTS).filter(|&i| self.look(middle, on_sphere(i)).is_some_and(|(_, front)| front)).count();
        if fronts * 10 < SIGHTS as usize * 9 {
            return None;
        }
        // Along the longest line of sight through the middle, from its one end to the other.
        let line = |eye: &mut Self, i: u32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 32.0;
            let along = DVec3::new(libm::cos(angle), 0.0, libm::sin(angle));
            let reach = |eye: &mut Self, d: DVec3| eye.look(middle, d).map_or(0.0, |(t, _)| t);
            (reach(eye, along), reach(eye, -along), along)
        };
        let lines = (0..32).map(|i| line(self, i));
        let (ahead, behind, along) = lines.reduce(|a, b| if b.0 + b.1 > (a.0 + a.1) * 1.01 { b } else { a })?;
        let eye = (middle - along * (0.9 * behind)).as_vec3();
        let drop = DVec3::Y * (0.1 * bounds.extent().y);
        let look_at = (middle + along * ahead - drop).as_vec3();
        (eye != look_at).then_some(Camera { eye, look_at, up: Vec3::Y, fov_degrees: ROOM_FOV })
    }

    /// How far into the box the camera sees, in shares of the box along each ray: the mean over rays that hit something.
    fn depth_seen(&mut self, camera: &Camera, bounds: &Aabb) -> f64 {
        let view = camera.view(GRID, GRID);
        let pixels = (0..GRID).flat_map(|y| (0..GRID).map(move |x| (x, y)));
        let depths: Vec<f64> = pixels
            .filter_map(|(x, y)| {
                let ray = view.ray(x, y);
                let (entry, exit) = interval(&ray, bounds)?;
                let (t, _) = self.look(ray.origin.as_dvec3(), ray.direction.as_dvec3())?;
                Some(((t - entry) / (exit - entry)).clamp(0.0, 1.0))
            })
            .collect();
        depths.iter().sum::<f64>() / depths.len().max(1) as f64
    }
}

/// Where the ray's line is inside of the box.
fn interval(ray: &Ray, bounds: &Aabb) -> Option<(f64, f64)> {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (a, b) = ((bounds.min.as_dvec3() - origin) / direction, (bounds.max.as_dvec3() - origin) / direction);
    let (entry, exit) = (a.min(b).max_element(), a.max(b).min_element());
    (entry > 0.0 && exit > entry).then_some((entry, exit))
}

/// The `i`-th of [`SIGHTS`] directions spread evenly (a spherical Fibonacci lattice).
fn on_sphere(i: u32) -> DVec3 {
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    let y = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(SIGHTS);
    let (r, angle) = ((1.0 - y * y).sqrt(), GOLDEN_ANGLE * f64::from(i));
    DVec3::new(r * libm::cos(angle), y, r * libm::sin(angle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Triangle;
    use crate::trace::Kernel;
    use crate::trace::testing::median_split;

    /// A scene of boxes, each turned inside out or not; the first side of each can be left out.
    fn boxes(list: &[(Vec3, Vec3, bool, bool)]) -> Scene {
        let mut scene = Scene::load("gen:soup:1").unwrap();
        scene.triangles.clear();
        for &(min, max, is_room, is_open) in list {
            let corner =
                |i: usize| Vec3::from([0, 1, 2].map(|axis| if i >> axis & 1 == 0 { min[axis] } else { max[axis] }));
            // Corners of each side, counter-clockwise from outside; +z comes first.
            let sides = [[4, 5, 7, 6], [0, 2, 3, 1], [1, 3, 7, 5], [0, 4, 6, 2], [2, 6, 7, 3], [0, 1, 5, 4]];
            for [a, b, c, d] in sides.into_iter().skip(usize::from(is_open)) {
                let [a, b, c, d] = [a, b, c, d].map(corner);
                for [p, q, r] in [[a, b, c], [a, c, d]] {
                    scene.triangles.push(if is_room { Triangle::new(p, r, q) } else { Triangle::new(p, q, r) });
                }
            }
        }
        scene.material_ids = vec![0; scene.triangles.len()];
        scene.camera = Camera::framing(&scene.bounds());
        scene
    }

    fn found(scene: &Scene) -> Camera {
        let bvh = median_split(&scene.triangles, 2);
        viewpoint(scene, &Tracer::new(Kernel::Scalar, &bvh, &scene.triangles))
    }

    const UNIT: (Vec3, Vec3) = (Vec3::ZERO, Vec3::ONE);

    #[test]
    fn a_body_is_seen_from_its_corner() {
        let body = boxes(&[(UNIT.0, UNIT.1, false, false)]);
        assert_eq!(found(&body), body.camera);
    }

    #[test]
    fn an_open_box_is_looked_into() {
        for is_room in [true, false] {
            let camera = found(&boxes(&[(UNIT.0, UNIT.1, is_room, true)]));
            assert!(camera.eye.z > 1.5 && (camera.eye.x - 0.5).abs() < 0.01, "{camera:?}");
        }
    }

    #[test]
    fn a_room_is_seen_from_inside_along_its_length() {
        let camera = found(&boxes(&[(Vec3::ZERO, Vec3::new(8.0, 3.0, 4.0), true, false)]));
        let (eye, towards) = (camera.eye, camera.look_at - camera.eye);
        assert!(eye.cmpgt(Vec3::ZERO).all() && eye.cmplt(Vec3::new(8.0, 3.0, 4.0)).all(), "{camera:?}");
        assert!(towards.length() > 6.0, "{camera:?}");
    }

    #[test]
    fn what_is_flat_lies_on_the_ground() {
        let camera = found(&boxes(&[(Vec3::ZERO, Vec3::new(9.0, 9.0, 1.0), false, false)]));
        assert!(camera.up == Vec3::Z && camera.eye.z > 2.0, "{camera:?}");
    }

    #[test]
    fn the_files_own_camera_stays() {
        let scene = Scene::load("thesis:tiny").unwrap();
        assert_eq!(found(&scene), scene.camera.upright());
    }
}
