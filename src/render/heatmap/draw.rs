//! Heat maps drawn: side by side on one scale, with a caption each and a legend.

use super::{HeatMap, Quantity};
use image::RgbImage;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::sync::OnceLock;

/// Why a heat map was not drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot draw the heat map: {0}")]
pub struct DrawError(String);

/// Pixels that the legend takes to the right of the pictures.
const LEGEND: u32 = 84;
/// Pixels that a caption takes below its picture.
const CAPTION: u32 = 42;
/// White pixels between two pictures.
const GAP: u32 = 10;
/// The legend's bar, from the last picture's edge.
const BAR: std::ops::Range<u32> = 10..26;
const FONT: &str = "bvh-lab-sans";
/// Of times, the share of pixels that the scale reaches over; counts have no outliers.
const TIMED: f64 = 0.999;

/// The maps side by side at one pixel a pixel, all on the scale of the greatest value, each with its name, mean and maximum
/// below, and one legend to the right.
///
/// # Errors
/// [`DrawError`] where the text cannot be set, or the maps differ in what they show or in size.
pub fn draw(maps: &[(&str, &HeatMap)]) -> Result<RgbImage, DrawError> {
    let fail = |e: &dyn std::fmt::Display| DrawError(e.to_string());
    let Some((_, first)) = maps.first() else { return Err(fail(&"there is none")) };
    let alike =
        |m: &HeatMap| (m.quantity, m.width, m.values.len()) == (first.quantity, first.width, first.values.len());
    if !maps.iter().all(|(_, map)| alike(map)) {
        return Err(fail(&"the maps differ in size or in what they show"));
    }
    font().map_err(|e| fail(&e))?;
    let height = (first.values.len() / first.width.max(1) as usize) as u32;
    let step = first.width + GAP;
    let legend = step * maps.len() as u32 - GAP;
    let (size, top) = ((legend + LEGEND, height + CAPTION), scale(maps));
    let mut pixels = vec![255; size.0 as usize * size.1 as usize * 3];
    let mut paint = |x: u32, y: u32, share: f64| {
        let start = (y as usize * size.0 as usize + x as usize) * 3;
        pixels[start..start + 3].copy_from_slice(&heat_colour(share));
    };
    for (place, (_, map)) in (0..).zip(maps) {
        for (i, &value) in (0..).zip(&map.values) {
            paint(place * step + i % map.width, i / map.width, value / top as f64);
        }
    }
    for y in 0..height {
        BAR.for_each(|x| paint(legend + x, y, 1.0 - (f64::from(y) + 0.5) / f64::from(height)));
    }
    {
        let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
        let style = (FONT, 13).into_font().color(&BLACK);
        let write = |text: String, x: u32, y: u32| {
            area.draw(&Text::new(text, (x as i32, y as i32), style.clone())).map_err(|e| fail(&e))
        };
        for tick in ticks(height, top) {
            let y = (1.0 - tick as f64 / top as f64) * f64::from(height.saturating_sub(15)) + 1.0;
            write(tick.to_string(), legend + BAR.end + 5, y as u32)?;
        }
        for (place, (name, map)) in (0..).zip(maps) {
            let (mean, max) = map.mean_and_max();
            write((*name).to_owned(), place * step + 4, height + 6)?;
            write(format!("{}: mean {mean:.2}, max {max:.0}", map.quantity.label()), place * step + 4, height + 23)?;
        }
        area.present().map_err(|e| fail(&e))?;
    }
    RgbImage::from_raw(size.0, size.1, pixels).ok_or_else(|| fail(&"the picture's size is off"))
}

/// The value at the upper end of the scale, at least 1.
fn scale(maps: &[(&str, &HeatMap)]) -> u64 {
    let mut values: Vec<f64> = maps.iter().flat_map(|(_, map)| map.values.iter().copied()).collect();
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    let place = if maps[0].1.quantity == Quantity::Time { (last as f64 * TIMED) as usize } else { last };
    values.get(place).map_or(1, |&top| (top.ceil() as u64).max(1))
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

/// The colour of a `share` from 0 to 1: the map `inferno` (van der Walt and Smith, for Matplotlib), whose lightness rises
/// evenly, so that equal steps look equal, to the colour-blind too, and survive in grey.
pub fn heat_colour(share: f64) -> [u8; 3] {
    colorous::INFERNO.eval_continuous(share.clamp(0.0, 1.0)).into_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(width: u32, values: &[f64]) -> HeatMap {
        HeatMap { quantity: Quantity::Nodes, width, values: values.to_vec() }
    }

    #[test]
    fn colours_grow_evenly_lighter() {
        let grey = |s: f64| {
            let [r, g, b] = heat_colour(s).map(|c| (f64::from(c) / 255.0).powf(2.2));
            (0.2126 * r + 0.7152 * g + 0.0722 * b).cbrt()
        };
        let steps: Vec<f64> = (0..=20).map(|i| grey(f64::from(i) / 20.0)).collect();
        assert!(steps.windows(2).all(|w| w[1] > w[0]), "{steps:?}");
        assert_eq!(heat_colour(-1.0), heat_colour(0.0));
    }

    #[test]
    fn maps_stand_side_by_side_on_one_scale() {
        let (cold, hot) = (map(80, &[50.0; 80 * 60]), map(80, &[100.0; 80 * 60]));
        let drawn = draw(&[("one", &cold), ("two", &hot)]).unwrap();
        assert_eq!(drawn.dimensions(), (80 + GAP + 80 + LEGEND, 60 + CAPTION));
        assert_eq!(drawn.get_pixel(40, 30).0, heat_colour(0.5));
        assert_eq!(drawn.get_pixel(85, 30).0, [255; 3]);
        assert_eq!(drawn.get_pixel(130, 30).0, heat_colour(1.0));
        let black = drawn.pixels().filter(|p| p.0.iter().all(|&c| c < 60)).count();
        assert!(black > 40, "no text: {black}");
        assert!(draw(&[("one", &cold), ("two", &map(40, &[1.0; 4800]))]).is_err());
        assert!(draw(&[]).is_err());
        assert!(draw(&[("nothing", &map(0, &[]))]).is_ok());
    }

    #[test]
    fn an_outlier_of_time_does_not_set_the_scale() {
        let mut time = HeatMap { quantity: Quantity::Time, ..map(100, &[200.0; 10_000]) };
        time.values[17] = 1e6;
        assert_eq!(scale(&[("", &time)]), 200);
        assert_eq!(scale(&[("", &HeatMap { quantity: Quantity::Nodes, ..time })]), 1_000_000);
    }

    #[test]
    fn ticks_are_round_and_end_at_the_greatest_count() {
        assert_eq!(ticks(400, 113), [0, 20, 40, 60, 80, 100, 113]);
        assert_eq!(ticks(400, 3), [0, 1, 2, 3]);
        assert_eq!(ticks(60, 7), [0, 7]);
        assert_eq!(ticks(10, 0), [0]);
        assert_eq!(ticks(400, u64::MAX).last(), Some(&u64::MAX));
    }
}
