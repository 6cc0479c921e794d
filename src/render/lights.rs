//! Area lights: triangles whose material emits, the choice of a point of one, and the light that they leave in the air.

use super::solid_angle::SolidAngle;
use crate::geom::{Ray, Triangle};
use crate::scene::{Effect, Material};
use crate::trace::{Query, Scratch, Tracer};
use arrayvec::ArrayVec;
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

/// Up to so many lights, one is picked by what each looks like from the point that is lit; of more, by power alone.
const FEW: usize = 32;
/// The solid angle in steradians from which on points are uniform by it. Below, the square of the distance and the cosine at the
/// light are nearly the same all over the triangle, and points uniform by area are as good.
const WIDE: f64 = 0.02;

/// Every triangle that emits light. Both sides do, as which one is out is not known of every mesh; but not a side that has
/// something close before it: what a lamp is mounted on.
#[derive(Clone, Debug)]
pub(super) struct Lights {
    /// By triangle id.
    lights: Vec<Light>,
    /// Shares of the power of all lights up to and with each; the last is 1.
    cumulative: Vec<f32>,
    /// Irradiance that light reflected more than once is taken for.
    ambient: Vec3,
}

/// A triangle that emits light.
#[derive(Clone, Debug)]
struct Light {
    corners: [DVec3; 3],
    /// Twice the area long, at the front.
    cross: DVec3,
    emission: Vec3,
    /// Whether it shines on its front (counter-clockwise) and on its back.
    sides: [bool; 2],
}

/// A point of a light as it is seen from one that it may light.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightPoint {
    /// From the one to the other.
    pub(super) way: DVec3,
    /// Emitted radiance.
    pub(super) emission: Vec3,
    /// How dense [`Lights::sample`] is about it, per steradian.
    pub(super) density: f64,
}

impl Light {
    /// Whether the side that is seen from `from` shines.
    fn shines_at(&self, from: DVec3) -> bool {
        let height = self.cross.dot(self.corners[0] - from);
        let [front, back] = self.sides;
        (height < 0.0 && front) || (height > 0.0 && back)
    }

    /// How much of it is likely to arrive on a surface: emission by solid angle and mean cosine at the corners, up to a factor.
    /// Zero only where nothing arrives.
    fn importance(&self, from: DVec3, normal: DVec3) -> f64 {
        if !self.shines_at(from) {
            return 0.0;
        }
        let seen = SolidAngle::of(self.corners.map(|corner| corner - from));
        let cosines: f64 = seen.towards().iter().map(|t| t.dot(normal).max(0.0)).sum();
        seen.stand_in() * cosines * f64::from(self.emission.element_sum())
    }

    /// The point of it on the line along `way`, as seen from `from`, for a light picked with probability `picked`; none where the
    /// numbers do not suffice.
    fn point(&self, seen: &SolidAngle, way: DVec3, picked: f64) -> Option<LightPoint> {
        let steradians = seen.steradians();
        let density = if steradians >= WIDE {
            1.0 / steradians
        } else {
            // The cross product is twice the area long: area times cosine is half of this.
            let squared = way.length_squared();
            squared / (0.5 * (self.cross.dot(way) / squared.sqrt()).abs())
        };
        let density = density * picked;
        let is_usable = way.is_finite() && density.is_finite() && density > 0.0;
        is_usable.then_some(LightPoint { way, emission: self.emission, density })
    }

    /// A point of it as seen from `from`, by two numbers of [0, 1), for a light picked with probability `picked`.
    fn sample(&self, from: DVec3, picked: f64, [u, v]: [f64; 2]) -> Option<LightPoint> {
        let [a, b, c] = self.corners;
        let seen = SolidAngle::of(self.corners.map(|corner| corner - from));
        let way = if seen.steradians() >= WIDE {
            let direction = seen.sample([u, v]);
            direction * (self.cross.dot(a - from) / self.cross.dot(direction))
        } else {
            // Uniform over the triangle (Turk 1990): parallel strips by the root, along them evenly.
            let root = u.sqrt();
            a + (b - a) * (root * (1.0 - v)) + (c - a) * (root * v) - from
        };
        self.point(&seen, way, picked)
    }

    /// How far it is along `direction`, of unit length; none where that misses it.
    fn distance(&self, from: DVec3, direction: DVec3) -> Option<f64> {
        let [a, b, c] = self.corners.map(|corner| corner - from);
        let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| p.cross(q).dot(direction));
        let is_inside = sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0);
        let distance = self.cross.dot(a) / self.cross.dot(direction);
        (is_inside && distance > 0.0 && distance.is_finite()).then_some(distance)
    }
}

impl Lights {
    /// The lights among the tracer's triangles, or none.
    pub(super) fn of(ids: &[u16], materials: &[Material], tracer: &Tracer) -> Option<Self> {
        let triangles = tracer.triangles();
        let emission = |id: usize| {
            let material = &materials[usize::from(ids[id])];
            if Effect::Shadow.is_called_for_by(material) { material.emission.max(Vec3::ZERO) } else { Vec3::ZERO }
        };
        let power = |id: usize| triangles[id].area() * f64::from(emission(id).element_sum());
        let shining: Vec<usize> = (0..triangles.len()).filter(|&id| power(id) > 0.0 && power(id).is_finite()).collect();
        let total: f64 = shining.iter().map(|&id| power(id)).sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut sum = 0.0;
        let mut cumulative: Vec<f32> = Vec::with_capacity(shining.len());
        for &id in &shining {
            sum += power(id);
            cumulative.push((sum / total) as f32);
        }
        *cumulative.last_mut()? = 1.0;
        let flux = shining.iter().map(|&id| emission(id) * (triangles[id].area() as f32 * PI)).sum();
        let mut scratch = Scratch::default();
        let lights = shining.iter().map(|&id| Light {
            corners: triangles[id].v.map(|p| p.as_dvec3()),
            cross: triangles[id].cross(),
            emission: emission(id),
            sides: open_sides(&triangles[id], tracer, &mut scratch),
        });
        Some(Self { lights: lights.collect(), cumulative, ambient: ambient(flux, triangles, ids, materials) })
    }

    /// Irradiance of light that was reflected more than once.
    pub(super) fn ambient(&self) -> Vec3 {
        self.ambient
    }

    /// What arrives at `from`, on a surface whose normal there is `normal`, from a point of a light, by two numbers of [0, 1);
    /// none where all lights are behind the surface or show it a side that does not shine.
    pub(super) fn sample(&self, from: DVec3, normal: DVec3, [u, v]: [f64; 2]) -> Option<LightPoint> {
        let (place, below, picked) =
            if self.are_few() { self.pick_by_importance(from, normal, u)? } else { self.pick_by_power(u as f32) };
        let light = &self.lights[place];
        if !light.shines_at(from) {
            return None;
        }
        // What is left of the number after the pick is as good as a new one.
        light.sample(from, picked, [((u - below) / picked).clamp(0.0, 1.0), v])
    }

    /// Whether there are so few that [`Self::along`] knows how [`Self::sample`] picks.
    pub(super) fn are_few(&self) -> bool {
        self.lights.len() <= FEW
    }

    /// The nearest point of a light along `direction`, of unit length, of few lights.
    pub(super) fn along(&self, from: DVec3, normal: DVec3, direction: DVec3) -> Option<LightPoint> {
        let met = self.lights.iter().enumerate().filter_map(|(i, light)| Some((i, light.distance(from, direction)?)));
        let (place, distance) = met.reduce(|a, b| if b.1 < a.1 { b } else { a })?;
        let light = &self.lights[place];
        let importances = self.importances(from, normal);
        let picked = importances[place] / importances.iter().sum::<f64>();
        light.point(&SolidAngle::of(light.corners.map(|corner| corner - from)), direction * distance, picked)
    }

    fn importances(&self, from: DVec3, normal: DVec3) -> ArrayVec<f64, FEW> {
        self.lights.iter().take(FEW).map(|light| light.importance(from, normal)).collect()
    }

    /// The light picked by `u`, the numbers below that pick an earlier one, and the probability of the pick.
    fn pick_by_importance(&self, from: DVec3, normal: DVec3, u: f64) -> Option<(usize, f64, f64)> {
        let importances = self.importances(from, normal);
        let total: f64 = importances.iter().sum();
        let mut below = 0.0;
        let mut last = None;
        for (place, importance) in importances.into_iter().enumerate().filter(|&(_, i)| i > 0.0) {
            let picked = importance / total;
            last = Some((place, below, picked));
            if u < below + picked {
                break;
            }
            below += picked;
        }
        last
    }

    /// As [`Self::pick_by_importance`], by power.
    fn pick_by_power(&self, u: f32) -> (usize, f64, f64) {
        let place = self.cumulative.partition_point(|&c| c <= u).min(self.cumulative.len() - 1);
        let below = if place == 0 { 0.0 } else { f64::from(self.cumulative[place - 1]) };
        (place, below, f64::from(self.cumulative[place]) - below)
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
        let shines = |wall: f32, z: f64| {
            let triangles = [square(0.0), square(wall), square(3.0)];
            let lights = lights(&triangles, &[1, 0, 0], &materials).unwrap();
            lights.sample(DVec3::Z * z, DVec3::Z * -z, [0.5; 2]).is_some()
        };
        assert_eq!((shines(-1.0, 1.0), shines(-1.0, -1.0)), (true, true), "open to both sides");
        assert_eq!((shines(-0.01, 1.0), shines(-0.01, -1.0)), (true, false), "the wall is behind it");
        assert_eq!((shines(0.01, 1.0), shines(0.01, -1.0)), (false, true), "before it, and nothing is behind");
    }

    /// The mean over an n × n grid of numbers of what a surface at `from` receives, and the mean of its square.
    fn irradiance(lights: &Lights, from: DVec3, normal: DVec3, n: u16) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for i in 0..n {
            for j in 0..n {
                let u = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n));
                if let Some(light) = lights.sample(from, normal, u) {
                    let cosine = light.way.normalize().dot(normal).max(0.0);
                    let received = f64::from(light.emission.x) * cosine / light.density;
                    sums[0] += received;
                    sums[1] += received * received;
                }
            }
        }
        sums.map(|sum| sum / f64::from(n * n))
    }

    /// The irradiance by a polygon of radiance 1 that is wholly above the surface (Lambert 1760).
    fn of_polygon(corners: &[DVec3], from: DVec3, normal: DVec3) -> f64 {
        let towards: Vec<_> = corners.iter().map(|c| (c - from).normalize()).collect();
        let edge = |i: usize| {
            let (a, b) = (towards[i], towards[(i + 1) % towards.len()]);
            a.dot(b).acos() * a.cross(b).normalize().dot(normal)
        };
        0.5 * (0..towards.len()).map(edge).sum::<f64>().abs()
    }

    #[test]
    fn a_surface_receives_what_lamberts_formula_says() {
        let (triangles, ids, materials) = scene();
        let lights = lights(&triangles, &ids, &materials).unwrap();
        // From near, by solid angle; from far, by area; and between the two lights.
        for from in [
            DVec3::new(0.6, 0.4, -0.3),
            DVec3::new(1.0, -3.0, 2.0),
            DVec3::new(-30.0, 9.0, 40.0),
            DVec3::new(6.0, 1.0, 4.0),
        ] {
            let normal = -DVec3::Z * from.z.signum();
            let [mean, _] = irradiance(&lights, from, normal, 200);
            let exact: f64 = [(0, 1.0), (1, 8.0)]
                .iter()
                .map(|&(id, radiance): &(usize, f64)| {
                    radiance * of_polygon(&triangles[id].v.map(|p| p.as_dvec3()), from, normal)
                })
                .sum();
            assert!((mean / exact - 1.0).abs() < 0.01, "{from}: {mean} {exact}");
        }
    }

    #[test]
    fn the_light_that_matters_is_picked_and_noise_is_little() {
        let (triangles, ids, materials) = scene();
        let lights = lights(&triangles, &ids, &materials).unwrap();
        // Right under the weaker one: by power it would be picked once in three times, and near points of it would glare.
        let [mean, square] = irradiance(&lights, DVec3::new(0.7, 0.7, -0.1), DVec3::Z, 64);
        assert!(square / (mean * mean) < 1.2, "{mean} {square}");
    }

    #[test]
    fn many_lights_are_picked_by_power() {
        let (mut triangles, mut ids, materials) = scene();
        triangles.extend([triangles[0]; FEW]);
        ids.extend([1; FEW]);
        let lights = lights(&triangles, &ids, &materials).unwrap();
        let from = DVec3::new(1.0, -3.0, 2.0);
        let [mean, _] = irradiance(&lights, from, DVec3::NEG_Z, 200);
        let exact = |id: usize| of_polygon(&triangles[id].v.map(|p| p.as_dvec3()), from, DVec3::NEG_Z);
        let exact = exact(0) * (FEW + 1) as f64 + exact(1) * 8.0;
        assert!((mean / exact - 1.0).abs() < 0.02, "{mean} {exact}");
    }

    #[test]
    fn what_is_behind_the_surface_is_not_picked() {
        let (triangles, ids, materials) = scene();
        let lights = lights(&triangles, &ids, &materials).unwrap();
        assert!(lights.sample(DVec3::new(0.5, 0.5, 1.0), DVec3::Z, [0.3; 2]).is_none());
        assert!(lights.sample(DVec3::new(0.5, 0.5, 0.0), DVec3::Z, [0.3; 2]).is_none(), "in its plane");
        assert!(lights.sample(DVec3::ZERO, DVec3::Z, [0.3; 2]).is_none(), "at its corner");
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
