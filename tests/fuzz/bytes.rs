//! Numbers, boxes, triangles and rays from bytes; where the bytes end, zeros follow.

use bvh_lab::geom::{Aabb, Ray, Triangle};
use glam::Vec3;

pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    pub fn byte(&mut self) -> u8 {
        match self.0.split_first() {
            Some((&first, rest)) => {
                self.0 = rest;
                first
            }
            None => 0,
        }
    }

    /// Below `n`, at most 256.
    pub fn below(&mut self, n: usize) -> usize {
        usize::from(self.byte()) % n
    }

    fn word(&mut self) -> u32 {
        u32::from_le_bytes([self.byte(), self.byte(), self.byte(), self.byte()])
    }

    /// One number in the manner of `style`: small integers, which tie; parts of 1; ordinary; of any size; or any bits at all.
    fn number(&mut self, style: Style) -> f32 {
        match style {
            Style::Grid => f32::from(self.byte() % 5) - if self.byte() & 64 == 0 { 0.0 } else { 4.0 },
            Style::Unit => (self.word() >> 8) as f32 / (1 << 24) as f32,
            Style::Plain => f32::from(i16::from_le_bytes([self.byte(), self.byte()])) * 0.37,
            Style::Sized => {
                let sign = if self.byte() & 1 == 0 { 1.0 } else { -1.0 };
                let exponent = i32::from(self.byte()) % 250 - 140;
                (sign * 2f64.powi(exponent) * (1.0 + f64::from(self.byte()) / 256.0)) as f32
            }
            Style::Bits => f32::from_bits(self.word()),
        }
    }

    pub fn style(&mut self) -> Style {
        [Style::Grid, Style::Unit, Style::Plain, Style::Sized, Style::Bits][self.below(5)]
    }

    pub fn point(&mut self, style: Style) -> Vec3 {
        Vec3::new(self.number(style), self.number(style), self.number(style))
    }

    pub fn triangle(&mut self, style: Style) -> Triangle {
        Triangle { v: [self.point(style), self.point(style), self.point(style)] }
    }

    /// A box, now and then one that is none.
    pub fn aabb(&mut self, style: Style) -> Aabb {
        let (a, b) = (self.point(style), self.point(style));
        if self.byte() == 255 { Aabb::new(a, b) } else { Aabb::new(a.min(b), a.max(b)) }
    }

    /// A ray, sometimes at a corner, a middle of an edge or the inside of one of `triangles`, sometimes with an interval.
    pub fn ray(&mut self, style: Style, triangles: &[Triangle]) -> Ray {
        let origin = self.point(style);
        let kind = self.byte();
        let [a, b, c] = triangles[self.below(triangles.len())].v;
        let direction = match kind % 5 {
            0 => self.point(style),
            1 => a - origin,
            2 => (a * 0.5 + b * 0.5) - origin,
            3 => (a * 0.25 + b * 0.25 + c * 0.5) - origin,
            _ => Vec3::from(std::array::from_fn(|_| [-1.0, -0.0, 0.0, 1.0][self.below(4)])),
        };
        let mut ray = Ray::new(origin, direction);
        if kind & 64 != 0 {
            (ray.t_min, ray.t_max) = (self.number(style), self.number(style));
        }
        ray
    }
}

/// What numbers are like.
#[derive(Clone, Copy, Debug)]
pub enum Style {
    Grid,
    Unit,
    Plain,
    Sized,
    Bits,
}
