//! Cameras: framing a scene, reading one from the command line, and ordinary primary rays.
//!
//! The thesis' own camera, with its integer pixel offsets, is the tracer's.

use super::Camera;
use crate::geom::{Aabb, Ray};
use glam::{DVec2, DVec3, Vec3};
use std::str::FromStr;

/// Where a framing camera stands, as seen from the middle of the scene: right of it, above it and in front of it.
const THREE_QUARTER: DVec3 = DVec3::new(0.5, 0.4, 0.75);
/// Vertical field of view of a framing camera, in degrees.
const FRAMING_FOV: f32 = 45.0;
/// How much further back than necessary a framing camera stands.
const MARGIN: f64 = 1.05;

impl Camera {
    /// A camera that has the whole box in view, from a three-quarter direction with y up, in any picture at least as
    /// wide as high.
    ///
    /// A point is seen from a distance of 1, or of what f32 can tell apart where it lies; an empty or non-finite box is
    /// taken for the origin. Eyes are kept within the range of f32, so a box that fills it cannot be seen whole.
    pub fn framing(bounds: &Aabb) -> Self {
        Self::framing_from(bounds, THREE_QUARTER, Vec3::Y)
    }

    /// As [`Self::framing`], from the direction `side` as seen from the middle of the box, and with `up` upwards; of any length
    /// but zero.
    pub fn framing_from(bounds: &Aabb, side: DVec3, up_axis: Vec3) -> Self {
        let (centre, half) =
            if bounds.is_valid() { (bounds.centre(), bounds.extent() * 0.5) } else { (DVec3::ZERO, DVec3::ZERO) };
        let backward = side.normalize_or(THREE_QUARTER.normalize());
        let (right, up) = picture_axes(-backward, up_axis.as_dvec3());
        let slope = libm::tan(f64::from(FRAMING_FOV).to_radians() / 2.0);
        // A corner at height h and depth z in the picture's axes is in view from distance h / slope + z on.
        let reach = |axis: DVec3, signs: DVec3| (half * signs).dot(axis);
        let needed = (0..8_u8)
            .map(|corner| DVec3::from([1, 2, 4].map(|bit| if corner & bit == 0 { -1.0 } else { 1.0 })))
            .map(|s| reach(right, s).abs().max(reach(up, s).abs()) / slope + reach(backward, s))
            .fold(0.0, f64::max);
        let least = centre.abs().max_element() * f64::from(f32::EPSILON) * 16.0;
        let distance = match needed {
            0.0 => least.max(1.0),
            _ => (needed * MARGIN).max(least).max(f64::from(f32::MIN_POSITIVE)),
        };
        let limit = DVec3::splat(f64::from(f32::MAX));
        Self {
            eye: (centre + backward * distance).clamp(-limit, limit).as_vec3(),
            look_at: centre.as_vec3(),
            up: up_axis,
            fov_degrees: FRAMING_FOV,
        }
    }

    /// This camera with world up (+y) upwards in the picture: the thesis' own camera has its up vector upside down, and its
    /// picture, turned by 180°, is that of this camera.
    #[must_use]
    pub fn upright(self) -> Self {
        Self { up: if self.up.y < 0.0 { -self.up } else { self.up }, ..self }
    }

    /// A picture of `width` × `height` pixels through this camera.
    pub fn view(&self, width: u32, height: u32) -> View {
        let forward = (self.look_at.as_dvec3() - self.eye.as_dvec3()).try_normalize().unwrap_or(DVec3::NEG_Z);
        let (right, up) = picture_axes(forward, self.up.as_dvec3());
        let slope = libm::tan(f64::from(self.fov_degrees).to_radians() / 2.0);
        let size = DVec2::new(f64::from(width), f64::from(height));
        View { eye: self.eye, forward, right: right * slope, up: up * slope, size }
    }

    /// The ray through the centre of pixel (`px`, `py`), counted from the upper left, of unit direction.
    ///
    /// For more than a few rays of one picture, [`Camera::view`] saves work.
    pub fn primary_ray(&self, px: u32, py: u32, width: u32, height: u32) -> Ray {
        self.view(width, height).ray(px, py)
    }
}

/// A camera with a picture size: what primary rays are made from.
#[derive(Clone, Copy, Debug)]
pub struct View {
    eye: Vec3,
    forward: DVec3,
    /// Half the picture's height, to the right.
    right: DVec3,
    /// Half the picture's height, upwards.
    up: DVec3,
    size: DVec2,
}

impl View {
    /// The ray through the centre of pixel (`px`, `py`), counted from the upper left, of unit direction.
    pub fn ray(&self, px: u32, py: u32) -> Ray {
        self.ray_through(f64::from(px) + 0.5, f64::from(py) + 0.5)
    }

    /// The ray through a point of the picture, in pixels from its upper left corner, of unit direction.
    pub fn ray_through(&self, x: f64, y: f64) -> Ray {
        let x = (2.0 * x - self.size.x) / self.size.y;
        let y = (self.size.y - 2.0 * y) / self.size.y;
        let direction = self.forward + self.right * x + self.up * y;
        Ray::new(self.eye, direction.normalize().as_vec3())
    }
}

/// Unit vectors to the right and upwards in the picture. Where `up` is no help (zero, or along the view), the axis
/// furthest from the view stands in for it.
fn picture_axes(forward: DVec3, up: DVec3) -> (DVec3, DVec3) {
    let cross = forward.cross(up.normalize_or_zero());
    let right = if cross.length() > 1e-9 {
        cross
    } else {
        let axis = [DVec3::Y, DVec3::Z, DVec3::X].into_iter().min_by(|a, b| {
            let along = |v: &DVec3| forward.dot(*v).abs();
            along(a).total_cmp(&along(b))
        });
        forward.cross(axis.unwrap_or(DVec3::Y))
    }
    .normalize();
    (right, right.cross(forward))
}

/// The parts of a camera that were spelled out, as in `eye=22,22,32,look=0,0,0,up=0,1,0,fov=30`; any may be missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraSpec {
    /// Position (`eye`).
    pub eye: Option<Vec3>,
    /// The point in the middle of the picture (`look`).
    pub look_at: Option<Vec3>,
    /// Roughly upwards (`up`).
    pub up: Option<Vec3>,
    /// Vertical field of view in degrees (`fov`).
    pub fov_degrees: Option<f32>,
}

/// What is wrong with a camera's words.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// A part is not `name=values`, or its name is unknown.
    #[error("camera: '{0}' is not one of eye=x,y,z look=x,y,z up=x,y,z fov=degrees")]
    UnknownPart(String),
    /// A part was given twice.
    #[error("camera: '{0}' is given twice")]
    Repeated(&'static str),
    /// A part has the wrong number of values, or one is no finite number.
    #[error("camera: '{name}' takes {wanted}, got '{found}'")]
    Values {
        /// The part.
        name: &'static str,
        /// What it takes.
        wanted: &'static str,
        /// What was there.
        found: String,
    },
    /// The field of view is not between 0 and 180 degrees.
    #[error("camera: fov must lie between 0 and 180 degrees, got {0}")]
    FieldOfView(f32),
    /// Eye and look are the same point.
    #[error("camera: eye and look are the same point, so there is no direction to look in")]
    NoDirection,
    /// Up is zero or points along the view.
    #[error("camera: up is zero or along the view; choose another")]
    NoUp,
}

impl FromStr for CameraSpec {
    type Err = CameraError;

    fn from_str(text: &str) -> Result<Self, CameraError> {
        let mut spec = Self::default();
        let words: Vec<&str> = text.split(',').map(str::trim).collect();
        let mut rest = words.as_slice();
        while let [first, tail @ ..] = rest {
            let unknown = || CameraError::UnknownPart(first.escape_debug().to_string());
            let (name, value) = first.split_once('=').ok_or_else(unknown)?;
            let more = tail.iter().take_while(|word| !word.contains('=')).count();
            let values: Vec<&str> = std::iter::once(value.trim()).chain(tail[..more].iter().copied()).collect();
            rest = &tail[more..];
            match name.trim() {
                "eye" => set("eye", &mut spec.eye, point("eye", &values)?)?,
                "look" => set("look", &mut spec.look_at, point("look", &values)?)?,
                "up" => set("up", &mut spec.up, point("up", &values)?)?,
                "fov" => set("fov", &mut spec.fov_degrees, angle(&values)?)?,
                _ => return Err(unknown()),
            }
        }
        Ok(spec)
    }
}

impl CameraSpec {
    /// `base` with the spelled-out parts in place of its own.
    ///
    /// # Errors
    /// [`CameraError::NoDirection`] or [`CameraError::NoUp`] where the parts do not make a camera together.
    pub fn apply(&self, base: &Camera) -> Result<Camera, CameraError> {
        let camera = Camera {
            eye: self.eye.unwrap_or(base.eye),
            look_at: self.look_at.unwrap_or(base.look_at),
            up: self.up.unwrap_or(base.up),
            fov_degrees: self.fov_degrees.unwrap_or(base.fov_degrees),
        };
        let forward = camera.look_at.as_dvec3() - camera.eye.as_dvec3();
        let forward = forward.try_normalize().ok_or(CameraError::NoDirection)?;
        let up = camera.up.as_dvec3().try_normalize().ok_or(CameraError::NoUp)?;
        // An up that was not asked for may well end up along the view; the picture then has another.
        if self.up.is_some() && forward.cross(up).length() <= 1e-6 {
            return Err(CameraError::NoUp);
        }
        Ok(camera)
    }
}

fn set<T>(name: &'static str, slot: &mut Option<T>, value: T) -> Result<(), CameraError> {
    match slot.replace(value) {
        None => Ok(()),
        Some(_) => Err(CameraError::Repeated(name)),
    }
}

fn point(name: &'static str, values: &[&str]) -> Result<Vec3, CameraError> {
    let found = || CameraError::Values {
        name,
        wanted: "three finite numbers x,y,z",
        found: values.join(",").escape_debug().to_string(),
    };
    let [x, y, z] = values else { return Err(found()) };
    let number = |text: &str| text.parse::<f32>().ok().filter(|v| v.is_finite()).ok_or_else(found);
    Ok(Vec3::new(number(x)?, number(y)?, number(z)?))
}

fn angle(values: &[&str]) -> Result<f32, CameraError> {
    let value = match values {
        [one] => one.parse::<f32>().ok().filter(|v| v.is_finite()),
        _ => None,
    };
    let value = value.ok_or_else(|| CameraError::Values {
        name: "fov",
        wanted: "one number of degrees",
        found: values.join(",").escape_debug().to_string(),
    })?;
    if value > 0.0 && value < 180.0 { Ok(value) } else { Err(CameraError::FieldOfView(value)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::thesis::CAMERA;

    /// Where a point falls in the picture: x and y in −1 … 1 of a square one, and whether it is in front.
    fn project(camera: &Camera, p: DVec3) -> (f64, f64, bool) {
        let view = camera.view(1, 1);
        let d = p - camera.eye.as_dvec3();
        let depth = d.dot(view.forward);
        let along = |axis: DVec3| d.dot(axis) / axis.length_squared() / depth;
        (along(view.right), along(view.up), depth > 0.0)
    }

    #[test]
    fn framing_has_every_corner_in_view() {
        let boxes = [
            (Vec3::ZERO, Vec3::ONE),
            (Vec3::new(-7.4, -1.5, -7.5), Vec3::new(10.7, 11.9, 8.2)),
            (Vec3::ZERO, Vec3::new(100.0, 0.0, 100.0)),
            (Vec3::ZERO, Vec3::new(0.0, 5.0, 0.0)),
            (Vec3::splat(-1e-38), Vec3::splat(1e-38)),
            (Vec3::splat(-1e37), Vec3::splat(1e37)),
            (Vec3::splat(1000.0), Vec3::splat(1000.5)),
            (Vec3::splat(3.0), Vec3::splat(3.0)),
        ];
        for (min, max) in boxes {
            let camera = Camera::framing(&Aabb::new(min, max));
            assert!(camera.eye.is_finite() && camera.eye != camera.look_at);
            let mut widest = 0.0_f64;
            for corner in 0..8 {
                let pick = |i: usize| f64::from(if corner >> i & 1 == 0 { min[i] } else { max[i] });
                let (x, y, in_front) = project(&camera, DVec3::new(pick(0), pick(1), pick(2)));
                assert!(in_front && x.abs() <= 1.0 && y.abs() <= 1.0, "{min} {max}: {x} {y}");
                widest = widest.max(x.abs()).max(y.abs());
            }
            assert!(min == max || widest > 0.7, "{min} {max}: fills {widest}");
        }
    }

    #[test]
    fn framing_survives_what_cannot_be_framed() {
        let whole = Aabb::new(Vec3::splat(f32::MIN), Vec3::splat(f32::MAX));
        for bounds in [Aabb::EMPTY, Aabb::new(Vec3::NAN, Vec3::NAN), whole, Aabb::around([Vec3::splat(1e30)])] {
            let camera = Camera::framing(&bounds);
            assert!(camera.eye.is_finite() && camera.look_at.is_finite() && camera.eye != camera.look_at);
            let ray = camera.primary_ray(0, 0, 3, 2);
            assert!((ray.direction.length() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn rays_go_through_pixel_centres() {
        let camera = Camera { eye: Vec3::new(0.0, 0.0, 5.0), look_at: Vec3::ZERO, up: Vec3::Y, fov_degrees: 90.0 };
        assert_eq!(camera.primary_ray(1, 1, 3, 3).direction, Vec3::NEG_Z);
        let corner = camera.primary_ray(0, 0, 2, 2);
        assert_eq!(corner.origin, camera.eye);
        assert!((corner.direction - Vec3::new(-0.5, 0.5, -1.0).normalize()).length() < 1e-6);
        let wide = camera.primary_ray(3, 1, 4, 2).direction;
        assert!((wide - Vec3::new(1.5, -0.5, -1.0).normalize()).length() < 1e-6);
    }

    #[test]
    fn an_up_along_the_view_is_replaced() {
        let camera = Camera { eye: Vec3::Y, look_at: Vec3::ZERO, up: Vec3::Y, fov_degrees: 45.0 };
        assert!(camera.primary_ray(0, 0, 4, 4).direction.is_finite());
    }

    #[test]
    fn words_replace_parts_and_keep_the_rest() {
        let spec: CameraSpec = "eye=1,2,3.5,look=-1,0,1e2,up=0,1,0,fov=60".parse().unwrap();
        let camera = spec.apply(&CAMERA).unwrap();
        assert_eq!(camera.eye, Vec3::new(1.0, 2.0, 3.5));
        assert_eq!(camera.look_at, Vec3::new(-1.0, 0.0, 100.0));
        assert_eq!((camera.up, camera.fov_degrees), (Vec3::Y, 60.0));
        let partial: CameraSpec = "fov = 12, up = 0, 0, 1".parse().unwrap();
        let expected = Camera { up: Vec3::Z, fov_degrees: 12.0, ..CAMERA };
        assert_eq!(partial.apply(&CAMERA), Ok(expected));
    }

    #[test]
    fn wrong_words_say_what_is_wrong() {
        let message = |text: &str| {
            let spec = text.parse::<CameraSpec>().and_then(|spec| spec.apply(&CAMERA));
            let line = spec.expect_err(text).to_string();
            assert!(line.starts_with("camera: ") && !line.contains('\n'), "{line}");
            line
        };
        assert!(message("").contains("''"));
        assert!(message("eye").contains("'eye'"));
        assert!(message("eye=1,2").contains("three finite numbers"));
        assert!(message("eye=1,2,3,4").contains("'1,2,3,4'"));
        assert!(message("eye=1,NaN,3").contains("finite"));
        assert!(message("eye=1,2,inf").contains("finite"));
        assert!(message("zoom=2").contains("zoom"));
        assert!(message("fov=30,fov=31").contains("twice"));
        assert!(message("fov=180").contains("between 0 and 180"));
        assert!(message("fov=wide").contains("degrees"));
        assert!(message("eye=0,0,0").contains("same point"));
        assert!(message("up=0,0,0").contains("up is zero"));
        assert!(message("up=22,22,32").contains("along the view"));
        assert!(message("a\nb=1").contains("a\\nb"));
    }
}
