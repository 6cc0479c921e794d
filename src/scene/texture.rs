//! Textures: where a material's pictures come from, and what they hold at a point.

use super::error::one_line;
use glam::{Vec2, Vec3};
use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

/// A picture that a material is drawn with, not read before it is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Where it is.
    pub source: TextureSource,
    /// Added to the texture coordinates, after [`Self::scale`].
    pub offset: Vec2,
    /// The texture coordinates' factors.
    pub scale: Vec2,
    /// Whether the border goes on outside of 0 … 1, instead of the whole picture again.
    pub clamps: bool,
}

/// Where a picture is.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureSource {
    /// In a file of its own.
    File(PathBuf),
    /// In the scene's file: a name, and the bytes as in a file.
    Embedded(String, Arc<[u8]>),
}

/// Why a picture could not be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read the texture {name}: {reason}")]
pub struct TextureError {
    /// The file, or its name in the scene's file.
    pub name: String,
    /// What is wrong with it, in one line.
    pub reason: String,
}

impl Texture {
    /// The whole picture in a file.
    pub fn file(path: PathBuf) -> Self {
        Self::of(TextureSource::File(path))
    }

    /// The whole picture.
    pub fn of(source: TextureSource) -> Self {
        Self { source, offset: Vec2::ZERO, scale: Vec2::ONE, clamps: false }
    }

    /// What it is called: the file, or its name in the scene's file.
    pub fn name(&self) -> String {
        match &self.source {
            TextureSource::File(path) => one_line(path),
            TextureSource::Embedded(name, _) => name.escape_debug().to_string(),
        }
    }

    /// Reads and decodes the picture: PNG, JPEG, TGA or BMP.
    ///
    /// # Errors
    /// [`TextureError`] where there is no such file or it is no such picture.
    pub fn decode(&self) -> Result<Bitmap, TextureError> {
        let fail = |reason: &dyn std::fmt::Display| TextureError {
            name: self.name(),
            reason: reason.to_string().replace(char::is_control, " "),
        };
        let bytes = match &self.source {
            TextureSource::File(path) => &std::fs::read(path).map_err(|e| fail(&e))?,
            TextureSource::Embedded(_, bytes) => bytes.as_ref(),
        };
        let mut reader = image::ImageReader::new(std::io::Cursor::new(bytes));
        // TGA has no signature: the ending has to tell. For all others the bytes do.
        if let TextureSource::File(path) = &self.source
            && let Ok(format) = image::ImageFormat::from_path(path)
        {
            reader.set_format(format);
        }
        let reader = reader.with_guessed_format().map_err(|e| fail(&e))?;
        let decoded = reader.decode().map_err(|e| fail(&e))?;
        let (has_alpha, picture) = (decoded.color().has_alpha(), decoded.into_rgba8());
        if picture.width() == 0 || picture.height() == 0 {
            return Err(fail(&"it has no pixels"));
        }
        let (width, height) = picture.dimensions();
        let pixels = picture.as_raw().as_chunks::<4>().0.to_vec();
        Ok(Bitmap { width, height, has_alpha, pixels, offset: self.offset, scale: self.scale, clamps: self.clamps })
    }
}

/// A decoded picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    width: u32,
    height: u32,
    has_alpha: bool,
    pixels: Vec<[u8; 4]>,
    offset: Vec2,
    scale: Vec2,
    clamps: bool,
}

/// Linear light of each 8-bit sRGB value (IEC 61966-2-1).
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let v = i as f64 / 255.0;
        (if v <= 0.040_45 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) }) as f32
    })
});

impl Bitmap {
    /// The colour at texture coordinates (from the lower left, v upwards): linear RGB, between the four nearest pixels.
    pub fn colour(&self, at: Vec2) -> Vec3 {
        let linear = &*LINEAR;
        self.blend(at, |[r, g, b, _]| Vec3::new(linear[r as usize], linear[g as usize], linear[b as usize]))
    }

    /// The opacity there: the picture's alpha if it has any, else its brightness.
    pub fn opacity(&self, at: Vec2) -> f32 {
        let level = |[r, g, b, a]: [u8; 4]| {
            if self.has_alpha { f32::from(a) } else { (f32::from(r) + f32::from(g) + f32::from(b)) / 3.0 }
        };
        self.blend(at, |pixel| Vec3::splat(level(pixel) / 255.0)).x
    }

    fn blend(&self, at: Vec2, value: impl Fn([u8; 4]) -> Vec3) -> Vec3 {
        let at = at * self.scale + self.offset;
        // Coordinates that are not finite, or too large to have a fraction, are taken for the corner.
        let at = if at.abs().max_element() < 1e6 { at } else { Vec2::ZERO };
        let at = if self.clamps { at.clamp(Vec2::ZERO, Vec2::ONE) } else { at - at.floor() };
        let size = Vec2::new(self.width as f32, self.height as f32);
        let pixel = Vec2::new(at.x, 1.0 - at.y) * size - 0.5;
        let (base, part) = (pixel.floor(), pixel - pixel.floor());
        let place = |coordinate: f32, step: i64, size: u32| {
            let at = coordinate as i64 + step;
            if self.clamps { at.clamp(0, i64::from(size) - 1) } else { at.rem_euclid(i64::from(size)) }
        };
        let corner = |i: i64, j: i64| {
            let (x, y) = (place(base.x, i, self.width), place(base.y, j, self.height));
            value(self.pixels[(y * i64::from(self.width) + x) as usize])
        };
        let (top, bottom) = (corner(0, 0).lerp(corner(1, 0), part.x), corner(0, 1).lerp(corner(1, 1), part.x));
        top.lerp(bottom, part.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red and green above, blue and half-clear white below.
    fn picture(clamps: bool) -> Bitmap {
        let pixels = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 128]];
        let mut image = image::RgbaImage::new(2, 2);
        image.pixels_mut().zip(pixels).for_each(|(to, from)| to.0 = from);
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        let texture = Texture::of(TextureSource::Embedded("four".into(), bytes.into_inner().into()));
        Texture { clamps, ..texture }.decode().unwrap()
    }

    #[test]
    fn pixels_lie_where_texture_coordinates_say() {
        let picture = picture(false);
        for (u, v, colour) in
            [(0.25, 0.75, Vec3::X), (0.75, 0.75, Vec3::Y), (0.25, 0.25, Vec3::Z), (1.25, -1.25, Vec3::X)]
        {
            assert!((picture.colour(Vec2::new(u, v)) - colour).length() < 1e-6, "{u} {v}");
        }
        assert!((picture.opacity(Vec2::new(0.75, 0.25)) - 128.0 / 255.0).abs() < 1e-6);
        assert!((picture.colour(Vec2::new(0.5, 0.75)) - Vec3::new(0.5, 0.5, 0.0)).length() < 1e-6);
        // Halfway over the border lies the other side, or with clamping the border itself.
        assert!((picture.colour(Vec2::new(0.0, 0.75)) - Vec3::new(0.5, 0.5, 0.0)).length() < 1e-6);
        assert!((self::picture(true).colour(Vec2::new(-3.0, 0.75)) - Vec3::X).length() < 1e-6);
        for odd in [f32::NAN, f32::INFINITY, 1e30, -1e30] {
            assert!(picture.colour(Vec2::splat(odd)).is_finite());
        }
    }

    #[test]
    fn what_is_no_picture_is_told_in_one_line() {
        for texture in [
            Texture::file("no/such.png".into()),
            Texture::of(TextureSource::Embedded("a\nb".into(), b"nonsense".as_slice().into())),
        ] {
            let error = texture.decode().unwrap_err().to_string();
            assert!(error.starts_with("cannot read the texture ") && error.lines().count() == 1, "{error}");
        }
    }
}
