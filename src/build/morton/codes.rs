//! Morton codes of boxes: the bits of the centre on a grid, interleaved (Morton 1966; Lauterbach et al. 2009).

use super::at_each_level;
use crate::build::{BuildError, check_boxes};
use crate::geom::{Aabb, lower, upper};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::mem::MaybeUninit;

/// Bits of a code for each axis.
pub(super) const AXIS_BITS: u32 = 21;

/// Boxes that one task looks at.
const CHUNK: usize = 1 << 14;

/// Boxes that vector instructions work on side by side.
const LANES: usize = 8;

/// The grid that centres are put on: a cube around all of them, with the lower corner at theirs.
///
/// Cells are cubes: with cells as flat as the scene, a terrain's heights would be split as often as its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    /// The least of each coordinate of twice a centre.
    pub low: DVec3,
    /// From twice a coordinate to cells.
    pub scale: f64,
}

/// What one look at boxes tells.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    /// Around all boxes.
    around: Aabb,
    /// Least and greatest of twice the centres.
    low: DVec3,
    high: DVec3,
    /// Whether all boxes have a lower corner no higher than the upper; false if there is a NaN.
    ordered: bool,
}

impl Extremes {
    fn with(&self, other: &Self) -> Self {
        Self {
            around: self.around.union(&other.around),
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            ordered: self.ordered && other.ordered,
        }
    }
}

/// Twice the centre: exact in f64 unless the corners are 2²⁹ times as far from the origin as from each other, and finite
/// for all finite corners.
#[inline(always)]
fn twice_centre(aabb: &Aabb) -> [f64; 3] {
    let (low, high) = (aabb.min.to_array(), aabb.max.to_array());
    std::array::from_fn(|axis| f64::from(low[axis]) + f64::from(high[axis]))
}

#[inline(always)]
fn extremes_body(boxes: &[Aabb]) -> Extremes {
    let (mut min, mut max) = ([[f32::INFINITY; LANES]; 3], [[f32::NEG_INFINITY; LANES]; 3]);
    let (mut low, mut high) = ([[f64::INFINITY; LANES]; 3], [[f64::NEG_INFINITY; LANES]; 3]);
    let mut ordered = [true; LANES];
    for boxes in boxes.chunks(LANES) {
        // The last boxes are looked at several times.
        let boxes: [&Aabb; LANES] = std::array::from_fn(|lane| &boxes[lane.min(boxes.len() - 1)]);
        for axis in 0..3 {
            let (from, to) = (boxes.map(|b| b.min[axis]), boxes.map(|b| b.max[axis]));
            for lane in 0..LANES {
                let twice = f64::from(from[lane]) + f64::from(to[lane]);
                ordered[lane] &= from[lane] <= to[lane];
                min[axis][lane] = lower(min[axis][lane], from[lane]);
                max[axis][lane] = upper(max[axis][lane], to[lane]);
                low[axis][lane] = if twice < low[axis][lane] { twice } else { low[axis][lane] };
                high[axis][lane] = if twice > high[axis][lane] { twice } else { high[axis][lane] };
            }
        }
    }
    Extremes {
        around: Aabb::new(
            Vec3::from(min.map(|lanes| lanes.into_iter().fold(f32::INFINITY, lower))),
            Vec3::from(max.map(|lanes| lanes.into_iter().fold(f32::NEG_INFINITY, upper))),
        ),
        low: DVec3::from(low.map(|lanes| lanes.into_iter().fold(f64::INFINITY, f64::min))),
        high: DVec3::from(high.map(|lanes| lanes.into_iter().fold(f64::NEG_INFINITY, f64::max))),
        ordered: ordered == [true; LANES],
    }
}

at_each_level! {
    fn extremes(boxes: &[Aabb]) -> Extremes = extremes_body
}

impl Grid {
    /// The grid for `boxes`, and the box around them all.
    ///
    /// # Errors
    /// Boxes that [`check_boxes`] refuses.
    pub fn around(boxes: &[Aabb], simd: crate::simd::Simd) -> Result<(Self, Aabb), BuildError> {
        let parts = boxes.par_chunks(CHUNK).map(|chunk| extremes(simd, chunk));
        let all = parts.reduce_with(|a, b| a.with(&b));
        let sound = |e: &Extremes| e.ordered && e.around.is_valid();
        let Some(all) = all.filter(|e| sound(e) && boxes.len() < 1 << 31) else {
            check_boxes(boxes)?;
            unreachable!("boxes without fault have sound extremes");
        };
        let widest = (all.high - all.low).max_element();
        // The greatest coordinate is to be the last cell, and is rounded to the nearest.
        let cells = f64::from((1u32 << AXIS_BITS) - 1);
        Ok((Self { low: all.low, scale: if widest > 0.0 { cells / widest } else { 0.0 } }, all.around))
    }
}

/// Added to a number below 2⁵¹, leaves it, rounded to an integer, in the lower bits.
const ROUND: f64 = (1u64 << 52) as f64;

/// Puts two zeros before each of the 21 bits of `v`.
#[inline(always)]
fn spread(v: u64) -> u64 {
    let v = (v | v << 32) & 0x001f_0000_0000_ffff;
    let v = (v | v << 16) & 0x001f_0000_ff00_00ff;
    let v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
    let v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
    (v | v << 2) & 0x1249_2492_4924_9249
}

/// The codes of up to [`LANES`] boxes, 63 bits from the top of 64. The x axis has the first bit.
#[inline(always)]
fn codes_of(boxes: &[Aabb], grid: &Grid) -> [u64; LANES] {
    let mut twice = [[0.0; LANES]; 3];
    for (lane, aabb) in boxes.iter().enumerate() {
        let centre = twice_centre(aabb);
        (0..3).for_each(|axis| twice[axis][lane] = centre[axis]);
    }
    let mut codes = [0; LANES];
    let cell = |twice: f64, low: f64| ((twice - low) * grid.scale + ROUND).to_bits() & ((1 << AXIS_BITS) - 1);
    // One loop over lanes without another inside, or they are not taken together.
    for lane in 0..LANES {
        let x = spread(cell(twice[0][lane], grid.low.x));
        let y = spread(cell(twice[1][lane], grid.low.y));
        let z = spread(cell(twice[2][lane], grid.low.z));
        codes[lane] = x << 3 | y << 2 | z << 1;
    }
    codes
}

#[inline(always)]
fn encode_body(
    boxes: &[Aabb],
    grid: &Grid,
    first: usize,
    upper: &mut [MaybeUninit<u64>],
    lower: &mut [MaybeUninit<u32>],
) {
    let outputs = upper.chunks_mut(LANES).zip(lower.chunks_mut(LANES));
    for (block, (boxes, (upper, lower))) in boxes.chunks(LANES).zip(outputs).enumerate() {
        let codes = codes_of(boxes, grid);
        let id = (first + block * LANES) as u64;
        for lane in 0..boxes.len() {
            upper[lane].write(codes[lane] >> 32 << 32 | (id + lane as u64));
            lower[lane].write(codes[lane] as u32);
        }
    }
}

at_each_level! {
    fn encode(
        boxes: &[Aabb],
        grid: &Grid,
        first: usize,
        upper: &mut [MaybeUninit<u64>],
        lower: &mut [MaybeUninit<u32>],
    ) = encode_body
}

/// Codes of boxes, in two halves.
pub(super) struct Codes {
    /// The upper halves, each with the box's id below.
    pub upper: Vec<u64>,
    /// The lower halves.
    pub lower: Vec<u32>,
}

/// The codes of `boxes` on `grid`.
pub(super) fn codes(boxes: &[Aabb], grid: &Grid, simd: crate::simd::Simd) -> Codes {
    let n = boxes.len();
    let (mut upper, mut lower) = (Vec::with_capacity(n), Vec::with_capacity(n));
    let outputs = upper.spare_capacity_mut()[..n].par_chunks_mut(CHUNK);
    let outputs = outputs.zip(lower.spare_capacity_mut()[..n].par_chunks_mut(CHUNK));
    let tasks = boxes.par_chunks(CHUNK).zip(outputs).enumerate();
    tasks.for_each(|(chunk, (boxes, (upper, lower)))| encode(simd, boxes, grid, chunk * CHUNK, upper, lower));
    // SAFETY: chunks of boxes and of outputs have the same lengths, and every task writes one code a box.
    unsafe {
        upper.set_len(n);
        lower.set_len(n);
    }
    Codes { upper, lower }
}
