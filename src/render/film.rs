//! The film: linear light per pixel, and the files that it goes into.

use glam::Vec3;
use image::{Rgb, Rgb32FImage, RgbImage};
use std::path::{Path, PathBuf};

/// Radiance per pixel, linear RGB with the primaries of sRGB, row by row from the upper left.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Pixels in a row.
    pub width: u32,
    /// One radiance a pixel.
    pub pixels: Vec<Vec3>,
}

/// Why a film was not written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}: {source}", path = .path.display())]
pub struct FilmError {
    /// The file.
    pub path: PathBuf,
    /// What the encoder or the system said.
    pub source: image::ImageError,
}

/// Reflectance of the middle grey that a picture's mean is exposed for.
const MIDDLE_GREY: f64 = 0.18;

impl Film {
    /// Rows.
    pub fn height(&self) -> u32 {
        (self.pixels.len() / self.width.max(1) as usize) as u32
    }

    /// The factor that makes the geometric mean of the luminance middle grey (Reinhard et al. 2002, section 3.1), pixels
    /// without light left out; 1 where there is none at all.
    pub fn auto_exposure(&self) -> f32 {
        let luminance = |p: &Vec3| f64::from(p.dot(Vec3::new(0.2126, 0.7152, 0.0722)));
        let lit: Vec<f64> = self.pixels.iter().map(luminance).filter(|y| *y > 0.0 && y.is_finite()).collect();
        if lit.is_empty() {
            return 1.0;
        }
        // Log and exp from libm: the platform's differ between systems in the last bit.
        let mean = libm::exp(lit.iter().map(|&y| libm::log(y)).sum::<f64>() / lit.len() as f64);
        let exposure = (MIDDLE_GREY / mean) as f32;
        if exposure.is_finite() && exposure > 0.0 { exposure } else { 1.0 }
    }

    /// 8-bit sRGB of the light times `exposure`; what is brighter than white is white.
    pub fn to_srgb(&self, exposure: f32) -> RgbImage {
        let mut picture = RgbImage::new(self.width, self.height());
        for (pixel, &light) in picture.pixels_mut().zip(&self.pixels) {
            *pixel = Rgb(srgb(light * exposure));
        }
        picture
    }

    /// Writes 8-bit sRGB of the light times `exposure` as PNG, or the light itself as 32-bit linear OpenEXR: by the path's
    /// ending, `.exr` or anything else.
    ///
    /// # Errors
    /// [`FilmError`] where the file system refuses.
    pub fn save(&self, path: &Path, exposure: f32) -> Result<(), FilmError> {
        let saved = if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
            self.linear().save_with_format(path, image::ImageFormat::OpenExr)
        } else {
            self.to_srgb(exposure).save_with_format(path, image::ImageFormat::Png)
        };
        saved.map_err(|source| FilmError { path: path.into(), source })
    }

    fn linear(&self) -> Rgb32FImage {
        let mut picture = Rgb32FImage::new(self.width, self.height());
        for (pixel, light) in picture.pixels_mut().zip(&self.pixels) {
            pixel.0 = light.to_array();
        }
        picture
    }
}

/// Linear light to 8-bit sRGB (IEC 61966-2-1); below black is black, NaN too.
pub(super) fn srgb(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|v| {
        let v = f64::from(v).clamp(0.0, 1.0);
        let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_has_its_known_values() {
        assert_eq!(srgb(Vec3::new(0.0, 1.0, 0.5)), [0, 255, 188]);
        assert_eq!(srgb(Vec3::new(-1.0, 7.0, 0.001)), [0, 255, 3]);
        assert_eq!(srgb(Vec3::splat(f32::NAN)), [0; 3]);
    }

    #[test]
    fn the_mean_is_exposed_to_middle_grey() {
        let film = |values: &[f32]| Film { width: 1, pixels: values.iter().map(|&v| Vec3::splat(v)).collect() };
        assert!((film(&[0.09, 0.36, 0.0]).auto_exposure() - 1.0).abs() < 1e-6);
        assert!((film(&[18.0]).auto_exposure() - 0.01).abs() < 1e-6);
        for dark in [&[][..], &[0.0, -1.0], &[f32::NAN, f32::INFINITY]] {
            assert_eq!(film(dark).auto_exposure(), 1.0);
        }
        assert_eq!(film(&[0.25]).to_srgb(2.0).get_pixel(0, 0).0, [188; 3]);
    }

    #[test]
    fn exr_keeps_the_light_bit_for_bit() {
        let pixels = vec![Vec3::new(0.1, 2e5, 1e-20), Vec3::new(-1.0, 0.0, 17.25)];
        let film = Film { width: 2, pixels };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light.EXR");
        film.save(&path, 3.0).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let read = image::load_from_memory_with_format(&bytes, image::ImageFormat::OpenExr).unwrap().into_rgb32f();
        let back: Vec<_> = read.pixels().map(|p| Vec3::from(p.0)).collect();
        assert_eq!(back, film.pixels);
        let error = film.save(&folder.path().join("no/such/x.png"), 1.0).unwrap_err().to_string();
        assert!(error.starts_with("cannot write "), "{error}");
    }
}
