//! Area lights: triangles whose material emits, picked by their power, and the light that they leave in the air.

use crate::geom::{Ray, Triangle};
use crate::scene::{Effect, Material};
use crate::trace::{Query, Scratch, Tracer};
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

/// Every triangle that emits light. Both sides do, as which one is out is not known of every mesh; but not a side that has
/// something close before it: what a lamp is mounted on.
#[derive(Clone, Debug)]
pub(super) struct Lights {
    /// Triangle ids, by id.
    triangles: Vec<u32>,
    /// Shares of the power of all lights up to and with each; the last is 1.
    cumulative: Vec<f32>,
    /// Whether each shines on its front (counter-clockwise) and on its back.
    sides: Vec<[bool; 2]>,
    /// Irradiance that light reflected more than once is taken for.
    ambient: Vec3,
}

/// A point on a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightPoint {
    pub(super) point: DVec3,
    /// Of unit length, at the front.
    normal: DVec3,
    sides: [bool; 2],
    /// Emitted radiance over the density of the choice, per unit of area.
    pub(super) radiance: Vec3,
}

impl LightPoint {
    /// The cosine at the light of the way `towards` it, of unit length; 0 where it comes from a side that does not shine.
    pub(super) fn cosine(&self, towards: DVec3) -> f64 {
        let cosine = self.normal.dot(towards);
        let [front, back] = self.sides;
        if (cosine < 0.0 && front) || (cosine > 0.0 && back) { cosine.abs() } else { 0.0 }
    }
}

impl Lights {
    /// The lights among the tracer's triangles, or none.
    pub(super) fn of(ids: &[u16], materials: &[Material], tracer: &Tracer) -> Option<Self> {
        let triangles = tracer.triangles();
        let emission = |id: usize| {
            let material = &materials[usize::from(ids[id])];
            if Effect::Shadow.is_called_for_by(material) { material.emission } else { Vec3::ZERO }
        };
        let power = |id: usize| triangles[id].area() * f64::from(emission(id).max(Vec3::ZERO).element_sum());
        let lights: Vec<usize> = (0..triangles.len()).filter(|&id| power(id) > 0.0 && power(id).is_finite()).collect();
        let total: f64 = lights.iter().map(|&id| power(id)).sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut sum = 0.0;
        let mut cumulative: Vec<f32> = Vec::with_capacity(lights.len());
        for &id in &lights {
            sum += power(id);
            cumulative.push((sum / total) as f32);
        }
        *cumulative.last_mut()? = 1.0;
        let flux = lights.iter().map(|&id| emission(id) * (triangles[id].area() as f32 * PI)).sum();
        let triangle_ids = lights.iter().map(|&id| id as u32).collect();
        let mut scratch = Scratch::default();
        let sides = lights.iter().map(|&id| open_sides(&triangles[id], tracer, &mut scratch)).collect();
        Some(Self { triangles: triangle_ids, cumulative, sides, ambient: ambient(flux, triangles, ids, materials) })
    }

    /// Irradiance of light that was reflected more than once.
    pub(super) fn ambient(&self) -> Vec3 {
        self.ambient
    }

    /// A point on a light, by two numbers of [0, 1): lights are picked by power, points by area.
    pub(super) fn sample(
        &self,
        triangles: &[Triangle],
        ids: &[u16],
        materials: &[Material],
        [u, v]: [f32; 2],
    ) -> LightPoint {
        let place = self.cumulative.partition_point(|&c| c <= u).min(self.cumulative.len() - 1);
        let below = if place == 0 { 0.0 } else { self.cumulative[place - 1] };
        let share = self.cumulative[place] - below;
        // What is left of the number after the pick is as good as a new one.
        let u = f64::from(((u - below) / share).clamp(0.0, 1.0));
        let id = self.triangles[place] as usize;
        let [a, b, c] = triangles[id].v.map(|p| p.as_dvec3());
        let cross = triangles[id].cross();
        // Uniform over the triangle (Turk 1990): parallel strips by the root, along them evenly.
        let (root, v) = (u.sqrt(), f64::from(v));
        let point = a + (b - a) * (root * (1.0 - v)) + (c - a) * (root * v);
        let area = 0.5 * cross.length();
        let emission = materials[usize::from(ids[id])].emission;
        let sides = self.sides[place];
        LightPoint { point, normal: cross.normalize_or_zero(), sides, radiance: emission * (area as f32 / share) }
    }
}

/// Front and back of a triangle: closed is one that sees less than a hundredth as far, straight ahead, as the other, nothing
/// being as far as the scene is wide.
fn open_sides(triangle: &Triangle, tracer: &Tracer, scratch: &mut Scratch) -> [bool; 2] {
    let width = tracer.bvh().root().aabb.extent().length() as f32;
    let normal = triangle.cross().normalize_or_zero();
    let middle = triangle.v.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / 3.0;
    let mut free = |normal: DVec3| {
        // The light itself is not in its own way.
        let ray = Ray { t_min: width * 1e-6, ..Ray::new(middle.as_vec3(), normal.as_vec3()) };
        tracer.trace(Query::Closest, &ray, scratch, &mut ()).map_or(width, |hit| hit.t)
    };
    let (front, back) = (free(normal), free(-normal));
    [front * 100.0 >= back, back * 100.0 >= front]
}

/// The mean irradiance by light reflected at least once, if all of it stayed in the scene: flux · ρ / (area · (1 − ρ)), with
/// ρ the mean reflectance by area (the ambient term of Cohen, Chen, Wallace and Greenberg 1988, section 3.4, before the
/// first shot). Clear surfaces let light through and are left out.
fn ambient(flux: Vec3, triangles: &[Triangle], ids: &[u16], materials: &[Material]) -> Vec3 {
    let most = Vec3::splat(0.9);
    let (mut area, mut reflecting) = (0.0, glam::DVec3::ZERO);
    for (triangle, &id) in triangles.iter().zip(ids) {
        let material = &materials[usize::from(id)];
        if material.transmittance() > 0.5 || Effect::Emission.is_called_for_by(material) {
            continue;
        }
        let mirrored = if Effect::Mirror.is_called_for_by(material) { material.specular } else { Vec3::ZERO };
        let reflectance = material.diffuse.max(mirrored).clamp(Vec3::ZERO, Vec3::ONE);
        area += triangle.area();
        reflecting += reflectance.as_dvec3() * triangle.area();
    }
    if area == 0.0 {
        return Vec3::ZERO;
    }
    let mean = (reflecting / area).as_vec3().min(most);
    let irradiance = flux / area as f32 * mean / (Vec3::ONE - mean);
    if irradiance.is_finite() { irradiance } else { Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::Kernel;
    use crate::trace::testing::median_split;

    fn lamp(emission: f32) -> Material {
        Material { emission: Vec3::splat(emission), ..Material::default() }
    }

    /// A triangle of area 2, one of area ½ that shines eight times as bright, one without area, and one that is dark.
    fn scene() -> (Vec<Triangle>, Vec<u16>, Vec<Material>) {
        let right = |x: f32, leg: f32| Triangle::new(Vec3::X * x, Vec3::X * (x + leg), Vec3::new(x, leg, 0.0));
        let triangles = vec![right(0.0, 2.0), right(10.0, 1.0), right(20.0, 0.0), right(30.0, 1.0)];
        (triangles, vec![1, 2, 2, 0], vec![Material::default(), lamp(1.0), lamp(8.0)])
    }

    fn lights(triangles: &[Triangle], ids: &[u16], materials: &[Material]) -> Option<Lights> {
        let bvh = median_split(triangles, 2);
        Lights::of(ids, materials, &Tracer::new(Kernel::Scalar, &bvh, triangles))
    }

    #[test]
    fn a_side_against_a_wall_does_not_shine() {
        let square = |z: f32| Triangle::new(Vec3::new(-4.0, -4.0, z), Vec3::new(8.0, -4.0, z), Vec3::new(-4.0, 8.0, z));
        let materials = [Material::default(), lamp(1.0)];
        let towards = |wall: f32, z: f64| {
            let triangles = [square(0.0), square(wall), square(3.0)];
            let lights = lights(&triangles, &[1, 0, 0], &materials).unwrap();
            lights.sample(&triangles, &[1, 0, 0], &materials, [0.5; 2]).cosine(DVec3::Z * z)
        };
        assert_eq!((towards(-1.0, 1.0), towards(-1.0, -1.0)), (1.0, 1.0), "open to both sides");
        assert_eq!((towards(-0.01, 1.0), towards(-0.01, -1.0)), (0.0, 1.0), "the wall is behind it");
        assert_eq!((towards(0.01, 1.0), towards(0.01, -1.0)), (1.0, 0.0), "before it, and nothing is behind");
    }

    #[test]
    fn lights_are_picked_by_power_and_points_by_area() {
        let (triangles, ids, materials) = scene();
        let lights = lights(&triangles, &ids, &materials).unwrap();
        assert_eq!(lights.triangles, [0, 1]);
        let n = 64;
        let (mut first, mut inner) = (0, 0);
        for i in 0..n * n {
            let u = [(i % n) as f32, (i / n) as f32].map(|k| (k + 0.5) / n as f32);
            let light = lights.sample(&triangles, &ids, &materials, u);
            assert_eq!(light.normal, DVec3::Z);
            // Radiance · area / probability is the whole power over π, whichever was picked.
            assert!((light.radiance.x - 6.0).abs() < 1e-4, "{}", light.radiance);
            if light.point.x < 5.0 {
                first += 1;
                // A quarter of the area is nearer to the right angle than the line between the middles of the legs.
                inner += usize::from(light.point.x + light.point.y < 1.0);
            }
        }
        assert_eq!(first, n * n / 3 / n * n);
        assert!((inner as f64 / first as f64 - 0.25).abs() < 0.03, "{inner} of {first}");
    }

    #[test]
    fn without_power_there_are_no_lights() {
        let (triangles, ids, mut materials) = scene();
        materials[1..].fill(lamp(0.0));
        assert!(lights(&triangles, &ids, &materials).is_none());
        materials[1..].fill(lamp(f32::INFINITY));
        assert!(lights(&triangles, &ids, &materials).is_none());
    }

    #[test]
    fn reflected_light_is_a_geometric_series() {
        let (triangles, ids, materials) = scene();
        let lights = lights(&triangles, &ids, &materials).unwrap();
        // 6 π of flux on half a unit of area of reflectance 0.8.
        assert!((lights.ambient().x / (12.0 * PI * 4.0) - 1.0).abs() < 1e-5, "{}", lights.ambient());
    }
}
