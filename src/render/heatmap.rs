//! Heat maps: what every pixel of a picture costs in nodes or triangle tests, drawn with a legend.

use super::film::srgb;
use crate::bvh::Bvh;
use crate::geom::{Ray, Triangle};
use crate::scene::Camera;
use crate::trace::{Kernel, Query, Scratch, TraceCounters, Tracer};
use glam::{Mat3, Vec3};
use image::RgbImage;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use rayon::prelude::*;
use std::sync::OnceLock;

/// What is counted per pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Nodes entered.
    Nodes,
    /// Triangles tested.
    TriangleTests,
}

impl Quantity {
    /// Its name in the legend.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Nodes => "nodes per pixel",
            Self::TriangleTests => "triangle tests per pixel",
        }
    }

    fn of(self, work: &TraceCounters) -> u64 {
        match self {
            Self::Nodes => work.nodes,
            Self::TriangleTests => work.triangle_tests,
        }
    }
}

/// Counts per pixel, row by row from the upper left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HeatMap {
    /// What was counted.
    pub quantity: Quantity,
    /// Pixels in a row.
    pub width: u32,
    /// One count a pixel.
    pub counts: Vec<u64>,
}

/// Why a heat map was not drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot draw the heat map: {0}")]
pub struct DrawError(String);

/// Pixels that the legend takes to the right of the picture.
const LEGEND: u32 = 84;
/// Pixels that the caption takes below it.
const CAPTION: u32 = 26;
/// The legend's bar, from the picture's edge.
const BAR: std::ops::Range<u32> = 10..26;
const FONT: &str = "bvh-lab-sans";

impl HeatMap {
    /// Traces one primary ray through the centre of every pixel and counts.
    pub fn trace(
        quantity: Quantity,
        kernel: Kernel,
        (bvh, triangles): (&Bvh, &[Triangle]),
        camera: &Camera,
        (width, height): (u32, u32),
    ) -> Self {
        let view = camera.view(width, height);
        let tracer = Tracer::new(kernel, bvh, triangles);
        let count = |scratch: &mut Scratch, ray: &Ray| {
            let mut work = TraceCounters::default();
            tracer.trace(Query::Closest, ray, scratch, &mut work);
            quantity.of(&work)
        };
        let counts = (0..height)
            .into_par_iter()
            .map_init(Scratch::default, |scratch, y| {
                (0..width).map(|x| count(scratch, &view.ray(x, y))).collect::<Vec<_>>()
            })
            .flatten_iter()
            .collect();
        Self { quantity, width, counts }
    }

    /// Mean and greatest count; zeros for a picture without pixels.
    pub fn mean_and_max(&self) -> (f64, u64) {
        let sum: u64 = self.counts.iter().sum();
        let mean = sum as f64 / self.counts.len().max(1) as f64;
        (mean, self.counts.iter().copied().max().unwrap_or(0))
    }

    /// The map at one pixel a pixel, with a legend to the right and a caption below.
    ///
    /// # Errors
    /// [`DrawError`] where the text cannot be set.
    pub fn draw(&self) -> Result<RgbImage, DrawError> {
        let fail = |e: &dyn std::fmt::Display| DrawError(e.to_string());
        font().map_err(|e| fail(&e))?;
        let height = (self.counts.len() / self.width.max(1) as usize) as u32;
        let (mean, max) = self.mean_and_max();
        let top = max.max(1) as f32;
        let size = (self.width + LEGEND, height + CAPTION);
        let mut pixels = vec![255; size.0 as usize * size.1 as usize * 3];
        let at = |x: u32, y: u32| (y as usize * size.0 as usize + x as usize) * 3;
        for (i, &count) in self.counts.iter().enumerate() {
            let start = at(i as u32 % self.width, i as u32 / self.width);
            pixels[start..start + 3].copy_from_slice(&heat_colour(count as f32 / top));
        }
        for y in 0..height {
            let colour = heat_colour(1.0 - (y as f32 + 0.5) / height as f32);
            for x in BAR {
                let start = at(self.width + x, y);
                pixels[start..start + 3].copy_from_slice(&colour);
            }
        }
        {
            let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
            let style = (FONT, 13).into_font().color(&BLACK);
            let write = |text: String, x: u32, y: u32| {
                area.draw(&Text::new(text, (x as i32, y as i32), style.clone())).map_err(|e| fail(&e))
            };
            for tick in ticks(height, max) {
                let y = (1.0 - tick as f32 / top) * height.saturating_sub(15) as f32 + 1.0;
                write(tick.to_string(), self.width + BAR.end + 5, y as u32)?;
            }
            write(format!("{}: mean {mean:.2}, max {max}", self.quantity.label()), 4, height + 7)?;
            area.present().map_err(|e| fail(&e))?;
        }
        RgbImage::from_raw(size.0, size.1, pixels).ok_or_else(|| DrawError("the picture's size is off".into()))
    }
}

/// Multiples of 1, 2 or 5 times a power of ten up to `max`, as many as there is room for, and `max` itself.
fn ticks(height: u32, max: u64) -> Vec<u64> {
    let room = u64::from(height / 30).clamp(1, 8);
    let step = (0..)
        .flat_map(|exponent| [1, 2, 5].map(|digit| 10_u64.saturating_pow(exponent).saturating_mul(digit)))
        .find(|step| max / step <= room)
        .unwrap_or(max);
    // The last multiple gives way to `max` where the two would overlap.
    let multiples = (0..=room).map(|i| i.saturating_mul(step)).take_while(|tick| tick.saturating_add(step / 2) < max);
    multiples.chain([max]).collect()
}

/// Makes the legend's font known to the drawing library, once.
fn font() -> Result<(), &'static str> {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    let ok = REGISTERED.get_or_init(|| register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).is_ok());
    if *ok { Ok(()) } else { Err("the font is damaged") }
}

/// The colour of a `share` from 0 to 1: dark blue over red to light yellow.
///
/// A path through OKLab (Ottosson 2020) whose lightness rises evenly, so that equal steps look equal and survive in grey:
/// the hue turns from blue through magenta and red to yellow, and the chroma swells and falls again.
pub fn heat_colour(share: f32) -> [u8; 3] {
    let s = share.clamp(0.0, 1.0);
    let lightness = 0.17 + 0.78 * s;
    let (hue, chroma) = ((280.0 + 180.0 * s).to_radians(), 0.06 + 0.12 * (1.0 - (2.0 * s - 1.0).powi(2)));
    srgb(oklab_to_linear(Vec3::new(lightness, chroma * libm::cosf(hue), chroma * libm::sinf(hue))))
}

fn oklab_to_linear(lab: Vec3) -> Vec3 {
    let to_lms = Mat3::from_cols(
        Vec3::ONE,
        Vec3::new(0.396_337_78, -0.105_561_346, -0.089_484_18),
        Vec3::new(0.215_803_76, -0.063_854_17, -1.291_485_5),
    );
    let to_rgb = Mat3::from_cols(
        Vec3::new(4.076_741_7, -1.268_438, -0.004_196_086_3),
        Vec3::new(-3.307_711_6, 2.609_757_4, -0.703_418_6),
        Vec3::new(0.230_969_94, -0.341_319_38, 1.707_614_7),
    );
    let lms = to_lms * lab;
    to_rgb * (lms * lms * lms)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::trace::testing::median_split;

    #[test]
    fn colours_grow_evenly_lighter() {
        let grey = |s: f32| {
            let [r, g, b] = heat_colour(s).map(|c| (f32::from(c) / 255.0).powf(2.2));
            (0.2126 * r + 0.7152 * g + 0.0722 * b).cbrt()
        };
        let steps: Vec<f32> = (0..=20).map(|i| grey(i as f32 / 20.0)).collect();
        assert!(steps.windows(2).all(|w| w[1] > w[0]), "{steps:?}");
        let white = oklab_to_linear(Vec3::X);
        assert!((white - Vec3::ONE).length() < 1e-4, "{white}");
        assert_eq!(heat_colour(-1.0), heat_colour(0.0));
    }

    #[test]
    fn the_map_adds_up_and_has_a_legend() {
        let scene = Scene::load("thesis:tiny").unwrap();
        let bvh = median_split(&scene.triangles, 4);
        let kernel = Kernel::Scalar;
        for quantity in [Quantity::Nodes, Quantity::TriangleTests] {
            let map = HeatMap::trace(quantity, kernel, (&bvh, &scene.triangles), &scene.camera, (80, 60));
            let (mean, max) = map.mean_and_max();
            assert!(mean >= if quantity == Quantity::Nodes { 1.0 } else { 0.0 } && max > 5);
            let drawn = map.draw().unwrap();
            assert_eq!(drawn.dimensions(), (80 + LEGEND, 60 + CAPTION));
            let black = drawn.pixels().filter(|p| p.0.iter().all(|&c| c < 60)).count();
            assert!(black > 40, "no text: {black}");
        }
    }

    #[test]
    fn ticks_are_round_and_end_at_the_greatest_count() {
        assert_eq!(ticks(400, 113), [0, 20, 40, 60, 80, 100, 113]);
        assert_eq!(ticks(400, 3), [0, 1, 2, 3]);
        assert_eq!(ticks(60, 7), [0, 7]);
        assert_eq!(ticks(10, 0), [0]);
        assert_eq!(ticks(400, u64::MAX).last(), Some(&u64::MAX));
    }

    #[test]
    fn a_map_of_nothing_draws() {
        let map = HeatMap { quantity: Quantity::Nodes, width: 0, counts: Vec::new() };
        assert_eq!(map.mean_and_max(), (0.0, 0));
        assert!(map.draw().is_ok());
    }
}
