//! Heat maps: what every pixel of a picture costs in nodes, triangle tests or time.

mod draw;

pub use draw::{DrawError, draw, heat_colour};

use crate::bvh::Bvh;
use crate::geom::{Ray, Triangle};
use crate::scene::Camera;
use crate::trace::{Kernel, Query, Scratch, TraceCounters, Tracer};
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// What is measured per pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Nodes entered.
    Nodes,
    /// Triangles tested.
    TriangleTests,
    /// Nanoseconds, on one thread: the least of a few measurements of a few traces each, as what disturbs a measurement only
    /// ever adds to it.
    Time,
}

impl Quantity {
    /// Its name in the legend.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Nodes => "nodes per pixel",
            Self::TriangleTests => "triangle tests per pixel",
            Self::Time => "ns per pixel",
        }
    }
}

/// One value a pixel, row by row from the upper left.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatMap {
    /// What was measured.
    pub quantity: Quantity,
    /// Pixels in a row.
    pub width: u32,
    /// One value a pixel.
    pub values: Vec<f64>,
}

impl HeatMap {
    /// Traces one primary ray through the centre of every pixel and measures.
    pub fn trace(
        quantity: Quantity,
        kernel: Kernel,
        (bvh, triangles): (&Bvh, &[Triangle]),
        camera: &Camera,
        (width, height): (u32, u32),
    ) -> Self {
        let view = camera.view(width, height);
        let tracer = Tracer::new(kernel, bvh, triangles);
        let row = |scratch: &mut Scratch, y: u32| -> Vec<f64> {
            (0..width).map(|x| measure(quantity, &tracer, &view.ray(x, y), scratch)).collect()
        };
        let values = match quantity {
            Quantity::Time => {
                let mut scratch = Scratch::default();
                (0..height).flat_map(|y| row(&mut scratch, y)).collect()
            }
            Quantity::Nodes | Quantity::TriangleTests => {
                (0..height).into_par_iter().map_init(Scratch::default, row).flatten_iter().collect()
            }
        };
        Self { quantity, width, values }
    }

    /// Mean and greatest value; zeros for a picture without pixels.
    pub fn mean_and_max(&self) -> (f64, f64) {
        let sum: f64 = self.values.iter().sum();
        let mean = sum / self.values.len().max(1) as f64;
        (mean, self.values.iter().copied().fold(0.0, f64::max))
    }
}

fn measure(quantity: Quantity, tracer: &Tracer, ray: &Ray, scratch: &mut Scratch) -> f64 {
    if quantity == Quantity::Time {
        return nanoseconds(tracer, ray, scratch);
    }
    let mut work = TraceCounters::default();
    tracer.trace(Query::Closest, ray, scratch, &mut work);
    if quantity == Quantity::Nodes { work.nodes as f64 } else { work.triangle_tests as f64 }
}

/// Time of one trace.
fn nanoseconds(tracer: &Tracer, ray: &Ray, scratch: &mut Scratch) -> f64 {
    const MEASUREMENTS: usize = 5;
    const TRACES: u32 = 8;
    let mut once = || {
        let begin = Instant::now();
        for _ in 0..TRACES {
            black_box(tracer.trace(Query::Closest, black_box(ray), scratch, &mut ()));
        }
        begin.elapsed().as_nanos() as f64 / f64::from(TRACES)
    };
    (0..MEASUREMENTS).map(|_| once()).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::trace::testing::median_split;

    #[test]
    fn every_quantity_is_measured_at_every_pixel() {
        let scene = Scene::load("thesis:tiny").unwrap();
        let bvh = median_split(&scene.triangles, 4);
        let map =
            |quantity| HeatMap::trace(quantity, Kernel::Scalar, (&bvh, &scene.triangles), &scene.camera, (40, 30));
        let nodes = map(Quantity::Nodes);
        assert_eq!(nodes.values.len(), 1200);
        assert!(nodes.values.iter().all(|&n| n >= 1.0 && n.fract() == 0.0), "the root is entered by every ray");
        let tests = map(Quantity::TriangleTests);
        assert!(tests.mean_and_max().1 > 5.0 && tests.values.contains(&0.0));
        let time = map(Quantity::Time);
        assert!(time.values.iter().all(|&t| t > 0.0));
        assert_eq!(HeatMap { quantity: Quantity::Nodes, width: 0, values: Vec::new() }.mean_and_max(), (0.0, 0.0));
    }
}
