//! The light that a surface reflects is what the integral over the lights says, and its noise is little.

use super::{clear, lamp, matt, picture, scene};
use crate::geom::{Ray, Triangle};
use crate::render::direct::choose;
use crate::render::lights::Lights;
use crate::render::reflectance::Reflectance;
use crate::render::sampler::Sampler;
use crate::render::surface::Surface;
use crate::render::{Demand, RayKind};
use crate::scene::Material;
use crate::trace::testing::median_split;
use crate::trace::{Kernel, Tracer};
use glam::{DVec3, Vec3};

/// A large light above the floor, and a small bright one.
fn lights() -> [Triangle; 2] {
    let at = |x: f32, z: f32| Vec3::new(x, 2.0, z);
    let small = [Vec3::new(3.0, 1.0, 0.0), Vec3::new(3.0, 1.0, 0.2), Vec3::new(3.0, 1.2, 0.0)];
    [Triangle::new(at(-2.0, -2.0), at(2.0, -2.0), at(-2.0, 2.0)), Triangle { v: small }]
}

const EMISSION: [f32; 2] = [1.0, 20.0];

/// The integral over the lights, by a fine grid of points on each.
fn exact(reflectance: &Reflectance, surface: &Surface, from: DVec3) -> f64 {
    let n = 400;
    let mut sum = 0.0;
    for (triangle, emission) in lights().iter().zip(EMISSION) {
        let [a, b, c] = triangle.v.map(|p| p.as_dvec3());
        let cell = triangle.area() / f64::from(n * n);
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            // The points of a square beyond the diagonal are folded back: two halves of a cell each.
            let [u, v] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n));
            let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
            let way = a + (b - a) * u + (c - a) * v - from;
            let towards = way.normalize();
            let at_light = triangle.cross().normalize().dot(towards).abs();
            let cosines = surface.normal.dot(towards).max(0.0) * at_light;
            sum += f64::from(emission * reflectance.from(surface, towards).x) * cosines / way.length_squared() * cell;
        }
    }
    sum
}

#[test]
fn one_point_of_a_light_is_right_on_average_and_seldom_far_off() {
    let triangles = lights();
    let lamp = |emission: f32| Material { emission: Vec3::splat(emission), ..Material::default() };
    let materials = EMISSION.map(lamp);
    let bvh = median_split(&triangles, 2);
    let lights = Lights::of(&[0, 1], &materials, &Tracer::new(Kernel::Scalar, &bvh, &triangles)).unwrap();
    let surface =
        Surface { flat: DVec3::Y, normal: DVec3::Y, is_front: true, direction: DVec3::new(0.5, -1.0, 0.2).normalize() };
    for (diffuse, specular, shininess) in [(0.5, 0.0, 1.0), (0.5, 0.04, 200.0), (0.0, 0.3, 30.0), (0.01, 0.04, 2000.0)]
    {
        let gloss =
            Material { illumination_model: 2, specular: Vec3::splat(specular), shininess, ..Material::default() };
        let reflectance = Reflectance::of(&gloss, Vec3::splat(diffuse), true);
        for from in [Vec3::ZERO, Vec3::new(-1.5, 1.5, -1.5)] {
            let [mut sum, mut squares] = [0.0; 2];
            let n = 300;
            for (x, y) in (0..n).flat_map(|x| (0..n).map(move |y| (x, y))) {
                let direct = choose(&lights, from, &surface, &reflectance, Sampler::of_pixel(x, y).choice(1));
                let light = direct.map_or(0.0, |direct| f64::from(direct.light.x));
                sum += light;
                squares += light * light;
            }
            let mean = sum / f64::from(n * n);
            let noise = (squares / f64::from(n * n) / (mean * mean) - 1.0).sqrt();
            let exact = exact(&reflectance, &surface, from.as_dvec3());
            let told = format!("Kd {diffuse} Ks {specular} Ns {shininess} {from}: {mean} {exact}, noise {noise}");
            assert!((mean / exact - 1.0).abs() < 4.0 * noise / f64::from(n) + 0.003, "{told}");
            assert!(noise < 4.0, "{told}");
        }
    }
}

#[test]
fn what_reflects_nothing_of_its_own_casts_no_shadow_ray() {
    let before = |material| {
        let rays = picture(&scene(&[(0.0, 9.0, material), (3.0, 0.2, lamp())]), Demand::Materials).rays;
        rays.of(RayKind::Shadow)
    };
    assert_eq!(before(Material { diffuse: Vec3::ZERO, ..matt() }), 0);
    assert_eq!(before(Material { opacity: 0.0, ..clear() }), 0);
    assert_eq!(before(clear()), super::PIXELS);
}

#[test]
fn a_light_in_the_way_of_another_hides_it() {
    let triangles = [
        Triangle::new(Vec3::new(-9.0, 1.0, -9.0), Vec3::new(20.0, 1.0, -9.0), Vec3::new(-9.0, 1.0, 20.0)),
        Triangle::new(Vec3::new(-9.0, 2.0, -9.0), Vec3::new(20.0, 2.0, -9.0), Vec3::new(-9.0, 2.0, 20.0)),
    ];
    let bvh = median_split(&triangles, 2);
    let lights = Lights::of(&[0, 0], &[lamp()], &Tracer::new(Kernel::Scalar, &bvh, &triangles)).unwrap();
    let ray = Ray::new(Vec3::ZERO, Vec3::new(0.1, 1.0, 0.2).normalize());
    let nearest = lights.along(DVec3::ZERO, DVec3::Y, ray.direction.as_dvec3().normalize()).unwrap();
    assert!((nearest.way.y - 1.0).abs() < 1e-6, "{}", nearest.way);
    assert!(lights.along(DVec3::ZERO, DVec3::Y, DVec3::NEG_Y).is_none());
}
