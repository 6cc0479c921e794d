//! Pictures: smooth-shaded objects on a plain background, the look of the thesis' Figure 3.

use super::closest::closest_hit;
use super::scratch::Scratch;
use crate::bvh::Bvh;
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::scene::{Camera, Scene};
use glam::{DVec3, Vec3};
use image::RgbImage;
use rayon::prelude::*;

/// How a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderOptions {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Rays along each side of a pixel: 1 for no anti-aliasing (default 2, so 4 rays a pixel).
    pub samples: u32,
    /// Colour where nothing is hit, linear RGB.
    pub background: Vec3,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { width: 600, height: 600, samples: 2, background: Vec3::new(0.86, 0.88, 0.92) }
    }
}

/// `camera` with world up (+y) upwards in the picture: the thesis' own camera has its up vector upside down, and its
/// picture, turned by 180°, is that of this camera.
#[must_use]
pub fn upright(camera: &Camera) -> Camera {
    Camera { up: if camera.up.y < 0.0 { -camera.up } else { camera.up }, ..*camera }
}

/// Draws the closest hits: a headlight and one directional light, no shadows, diffuse colours (`Kd`) and emission (`Ke`),
/// in sRGB. The same picture for any number of threads.
///
/// `normals` are [`crate::scene::smooth_normals`]; an empty slice shades every triangle flat.
pub fn render(scene: &Scene, normals: &[[Vec3; 3]], bvh: &Bvh, camera: &Camera, options: &RenderOptions) -> RgbImage {
    let samples = options.samples.max(1);
    let view = camera.view(options.width * samples, options.height * samples);
    let light = key_light(camera);
    let mut picture = RgbImage::new(options.width, options.height);
    let row_bytes = options.width as usize * 3;
    picture.par_chunks_mut(row_bytes.max(1)).enumerate().for_each_init(Scratch::default, |scratch, (y, row)| {
        for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
            let mut sum = Vec3::ZERO;
            for sample in 0..samples * samples {
                let (i, j) = (sample % samples, sample / samples);
                let ray = view.ray(x as u32 * samples + i, y as u32 * samples + j);
                sum += match closest_hit::<WatertightRay, ()>(bvh, &scene.triangles, &ray, scratch, &mut ()) {
                    Some(hit) => shade(scene, normals, &ray, &hit, light),
                    None => options.background,
                };
            }
            pixel.copy_from_slice(&srgb(sum / (samples * samples) as f32));
        }
    });
    picture
}

/// Towards the directional light: from over the viewer's left shoulder.
fn key_light(camera: &Camera) -> DVec3 {
    let look = (camera.look_at.as_dvec3() - camera.eye.as_dvec3()).normalize_or(DVec3::NEG_Z);
    let up = camera.up.as_dvec3().normalize_or(DVec3::Y);
    (up - look.cross(up) * 0.6 - look * 0.5).normalize_or(up)
}

fn shade(scene: &Scene, normals: &[[Vec3; 3]], ray: &Ray, hit: &Hit, light: DVec3) -> Vec3 {
    let id = hit.triangle as usize;
    let triangle = &scene.triangles[id];
    let direction = ray.direction.as_dvec3().normalize();
    let flat = triangle.cross().normalize();
    let corners = normals.get(id).map(|corners| corners.map(|n| at_crease(n.as_dvec3(), flat)));
    let smooth = corners.and_then(|corners| interpolate(triangle, &corners, ray, hit)).unwrap_or(flat);
    // Both sides are lit alike: which side is out is not known of every mesh.
    let normal = if flat.dot(direction) > 0.0 { -smooth } else { smooth };
    let material = &scene.materials[usize::from(scene.material_ids[id])];
    let headlight = normal.dot(-direction).max(0.0);
    let key = normal.dot(light).max(0.0);
    material.diffuse * (0.12 + 0.4 * headlight + 0.55 * key) as f32 + material.emission
}

/// A corner's normal, or the triangle's own where the two differ by more than 30°: an edge that is meant to be seen.
/// (Half of the angle between two faces of a box is 45°, between neighbours of a coarse cylinder less than 20°.)
fn at_crease(smooth: DVec3, flat: DVec3) -> DVec3 {
    const COS_30_DEGREES: f64 = 0.866_025_403_784_438_6;
    if smooth.dot(flat) < COS_30_DEGREES { flat } else { smooth }
}

/// The mean of the corners' normals, weighted by the hit's barycentric coordinates.
fn interpolate(triangle: &Triangle, corners: &[DVec3; 3], ray: &Ray, hit: &Hit) -> Option<DVec3> {
    let point = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
    let area = triangle.cross();
    let [a, b, c] = triangle.v.map(|v| v.as_dvec3() - point);
    let weights = [b.cross(c), c.cross(a), a.cross(b)].map(|opposite| opposite.dot(area).max(0.0));
    let sum: DVec3 = weights.iter().zip(corners).map(|(&w, &n)| n * w).sum();
    sum.try_normalize()
}

/// Linear light to 8-bit sRGB (IEC 61966-2-1).
pub(super) fn srgb(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|v| {
        let v = f64::from(v.clamp(0.0, 1.0));
        let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::smooth_normals;
    use crate::trace::testing::median_split;

    fn picture(camera: &Camera, threads: usize) -> RgbImage {
        let scene = Scene::load("thesis:tiny").unwrap();
        let bvh = median_split(&scene.triangles, 4);
        let options = RenderOptions { width: 90, height: 60, ..RenderOptions::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&scene, &smooth_normals(&scene), &bvh, camera, &options))
    }

    #[test]
    fn upright_turns_the_thesis_picture_by_180_degrees() {
        let camera = Scene::load("thesis:tiny").unwrap().camera;
        let background = image::Rgb(srgb(RenderOptions::default().background));
        let (published, shown) = (picture(&camera, 1), picture(&upright(&camera), 1));
        let silhouette = |p: &RgbImage| -> Vec<bool> { p.pixels().map(|c| *c == background).collect() };
        let mut turned = silhouette(&published);
        turned.reverse();
        let shown = silhouette(&shown);
        let different = turned.iter().zip(&shown).filter(|(a, b)| a != b).count();
        assert!(different <= 5, "{different}");
        assert!(shown.iter().any(|&b| b) && shown.iter().any(|&b| !b));
    }

    #[test]
    fn the_picture_does_not_depend_on_the_number_of_threads() {
        let camera = upright(&Scene::load("thesis:tiny").unwrap().camera);
        assert_eq!(picture(&camera, 1), picture(&camera, 3));
    }

    #[test]
    fn srgb_has_its_known_values() {
        assert_eq!(srgb(Vec3::new(0.0, 1.0, 0.5)), [0, 255, 188]);
        assert_eq!(srgb(Vec3::new(-1.0, 7.0, 0.001)), [0, 255, 3]);
    }
}
