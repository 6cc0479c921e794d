//! Pixels at which a traversal does not see the closest surface: counted, and pictured.

use super::measure::Subject;
use crate::build::{self, Brake, BuildOptions, Input};
use crate::bvh::Bvh;
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::lab::trace_cell::Stage;
use crate::rows::{RowError, write_whole};
use crate::trace::{Reading, Scratch, closest_hit, first_leaf};
use image::{ImageFormat, Rgb, RgbImage};
use rayon::prelude::*;
use std::io::Cursor;
use std::path::Path;

/// The picture's name in the folder of the rows.
pub const PIXELS_FILE: &str = "wrong-pixels.png";
/// The scene that it shows.
pub(super) const SCENE: &str = "thesis:large";

/// What a pixel sees.
pub(super) type Seen = Option<Hit>;

/// How many pixels see something else than the closest surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Wrong {
    /// They see a farther one.
    pub farther: usize,
    /// They see nothing, though there is something.
    pub missed: usize,
    /// They see something where there is nothing: the triangle tests differ on edges.
    pub extra: usize,
}

/// What is wrong with a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    Farther,
    Missed,
    Extra,
}

/// The same surface within rounding: another triangle at its edge, or another formula for t.
const SAME: f32 = 1e-4;

fn fault(closest: &Seen, seen: &Seen) -> Option<Fault> {
    match (closest, seen) {
        (Some(_), None) => Some(Fault::Missed),
        (None, Some(_)) => Some(Fault::Extra),
        (Some(near), Some(far)) if far.t > near.t * (1.0 + SAME) => Some(Fault::Farther),
        _ => None,
    }
}

fn rays(stage: &Stage, bvh: &Bvh) -> Vec<Ray> {
    let camera = stage.view(bvh).camera.upright();
    let pixels = (0..camera.height()).flat_map(|y| (0..camera.width()).map(move |x| (x, y)));
    pixels.map(|(x, y)| camera.ray(x, y)).collect()
}

fn hits(stage: &Stage, bvh: &Bvh, reading: Reading) -> Vec<Seen> {
    let one = |scratch: &mut Scratch, ray: Ray| match reading {
        Reading::Published(options) => first_leaf(bvh, &stage.triangles, &ray, options, scratch, &mut ()),
        Reading::Text => closest_hit::<WatertightRay, ()>(bvh, &stage.triangles, &ray, scratch, &mut ()),
    };
    rays(stage, bvh).into_par_iter().map_init(Scratch::default, one).collect()
}

/// The closest hit of every pixel, row by row from the top, through a tree that was verified by brute force.
pub(super) fn closest_hits(stage: &Stage) -> Vec<Seen> {
    let boxes: Vec<_> = stage.triangles.iter().map(Triangle::aabb).collect();
    let builder = build::find("sweep-sah").expect("it is registered");
    let input = Input::of_triangles(&stage.triangles, &boxes);
    let bvh = (builder.timed)(input, &BuildOptions::default(), &mut Brake::default())
        .expect("a scene that was loaded has triangles, and no budget stops this build");
    hits(stage, &bvh, Reading::Text)
}

/// Holds what `reading` sees through `bvh` against the closest hits.
pub(super) fn compare(closest: &[Seen], stage: &Stage, bvh: &Bvh, reading: Reading) -> Wrong {
    let mut wrong = Wrong::default();
    for (near, seen) in closest.iter().zip(hits(stage, bvh, reading)) {
        match fault(near, &seen) {
            Some(Fault::Farther) => wrong.farther += 1,
            Some(Fault::Missed) => wrong.missed += 1,
            Some(Fault::Extra) => wrong.extra += 1,
            None => {}
        }
    }
    wrong
}

/// Draws the six trees of the program side by side, top-down above bottom-up, arity 2, 4 and 8: grey as it should be, farther surfaces red,
/// missed ones blue, surfaces that are not there green. A whole picture that is there already is kept.
///
/// # Errors
/// The file system's.
pub(super) fn picture(rows: &Path, subject: &Subject) -> Result<(), RowError> {
    let path = rows.join(PIXELS_FILE);
    if image::open(&path).is_ok() {
        return Ok(());
    }
    let broken = |why: String| RowError::Io { what: "draw", path: path.clone(), source: std::io::Error::other(why) };
    let closest = closest_hits(subject.stage);
    let trees = subject.published_trees().map_err(|(_, why)| broken(why))?;
    let (width, height) = crate::trace::THESIS_SIZE;
    let mut sheet = RgbImage::new(3 * width, 2 * height);
    for (i, (bvh, reading)) in trees.iter().enumerate() {
        let seen = hits(subject.stage, bvh, *reading);
        let rays = rays(subject.stage, bvh);
        let (left, top) = (i as u32 % 3 * width, i as u32 / 3 * height);
        for (pixel, (near, seen)) in closest.iter().zip(&seen).enumerate() {
            let colour = match fault(near, seen) {
                Some(Fault::Farther) => Rgb([214, 40, 40]),
                Some(Fault::Missed) => Rgb([30, 90, 230]),
                Some(Fault::Extra) => Rgb([0, 160, 60]),
                None => Rgb([grey(subject.stage, &rays[pixel], near); 3]),
            };
            sheet.put_pixel(left + pixel as u32 % width, top + pixel as u32 / width, colour);
        }
    }
    let mut png = Vec::new();
    sheet.write_to(&mut Cursor::new(&mut png), ImageFormat::Png).map_err(|e| broken(e.to_string()))?;
    write_whole(&path, &png)
}

/// How much a surface faces the camera; white where there is none.
fn grey(stage: &Stage, ray: &Ray, seen: &Seen) -> u8 {
    seen.as_ref().map_or(255, |hit| {
        let normal = stage.triangles[hit.triangle as usize].cross().normalize_or_zero();
        let facing = normal.dot(ray.direction.as_dvec3().normalize_or_zero()).abs();
        (70.0 + 150.0 * facing) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_told_apart() {
        let at = |t| Some(Hit { triangle: 0, t });
        assert_eq!(fault(&at(1.0), &at(1.0)), None);
        assert_eq!(fault(&at(1.0), &at(1.00001)), None);
        assert_eq!(fault(&at(1.0), &at(1.1)), Some(Fault::Farther));
        assert_eq!(fault(&at(1.0), &None), Some(Fault::Missed));
        assert_eq!(fault(&None, &at(1.0)), Some(Fault::Extra));
        assert_eq!(fault(&None, &None), None);
    }
}
