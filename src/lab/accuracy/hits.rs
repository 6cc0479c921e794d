//! Hits held against a reference: how many are wrong, and by how much.
//!
//! The reference is kernel `scalar` with the watertight test, which is brute force's answer bit for bit; some of its own
//! answers are held against all triangles in f64, without a tree and without its test.

use super::trees::put_rate;
use super::{AccuracyStudy, Subject, reference_tree};
use crate::geom::{Hit, Ray, Triangle};
use crate::lab::measure::spread;
use crate::rows::{AccuracyRow, Status};
use crate::trace::{Arithmetic, Batch, HitRecord, Kernel, Oracle, Query, Tracer, count_batch, trace_batch};
use glam::{DVec3, Vec3};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;
use std::time::Instant;

/// A hit this near the reference's, in units in the last place of t, is right.
const NEAR: u32 = 4;

/// Rays whose reference is held against all triangles in f64.
const ORACLE_RAYS: usize = 256;

/// How a set of answers differs from the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verdict {
    /// Nothing, where the reference has a hit.
    pub missed: usize,
    /// Another triangle at another place, or a hit where the reference has none.
    pub other: usize,
    /// The same triangle, at a t more than 4 units in the last place off.
    pub off: usize,
    /// The greatest distance in units in the last place among the rays that are right.
    pub largest_ulp: u32,
}

/// Holds `answers` against the `reference`, ray by ray. Another triangle is right where it is as near: at an edge both
/// of its triangles are.
///
/// # Panics
/// If there are not as many answers as references.
pub fn compare_hits(reference: &[HitRecord], answers: &[HitRecord]) -> Verdict {
    assert_eq!(reference.len(), answers.len());
    let mut verdict = Verdict::default();
    for (expected, found) in reference.iter().zip(answers) {
        match (expected.is_hit(), found.is_hit()) {
            (false, false) => {}
            (true, false) => verdict.missed += 1,
            (false, true) => verdict.other += 1,
            (true, true) => match ulps_between(expected.t, found.t) {
                ulps if ulps <= NEAR => verdict.largest_ulp = verdict.largest_ulp.max(ulps),
                _ if expected.triangle == found.triangle => verdict.off += 1,
                _ => verdict.other += 1,
            },
        }
    }
    verdict
}

/// Numbers of f32 between two, one end included.
fn ulps_between(a: f32, b: f32) -> u32 {
    // In the order of the numbers themselves, both zeros as one.
    let place = |x: f32| {
        let bits = x.to_bits() as i32;
        i64::from(if bits < 0 { i32::MIN.wrapping_sub(bits) } else { bits })
    };
    u32::try_from((place(a) - place(b)).unsigned_abs()).unwrap_or(u32::MAX)
}

/// Measures one group: every kernel on every kind of rays, in turns.
pub(super) fn measure(study: &AccuracyStudy, subject: &Subject, rows: Vec<AccuracyRow>) -> Vec<AccuracyRow> {
    let triangles = &subject.stage.triangles;
    let tree = reference_tree(&subject.stage);
    let edges = edge_rays(triangles, subject.primary.len());
    let sets: Vec<(&str, &[Ray])> =
        vec![("primary", &subject.primary), ("diffuse", &subject.diffuse), ("edges", &edges)];
    let scalar = Tracer::new(Kernel::Scalar, &tree, triangles);
    let references: Vec<(Vec<HitRecord>, Result<usize, String>)> = sets
        .iter()
        .map(|&(_, rays)| {
            let hits = count_batch(&Batch { tracer: &scalar, query: Query::Closest, rays }).0;
            let checked = oracle(triangles, rays, &hits);
            (hits, checked)
        })
        .collect();
    let mut entries = Vec::new();
    for mut row in rows {
        let kernel = Kernel::from_id(&row.method).expect("rows name kernels that are registered");
        let set = sets.iter().position(|s| s.0 == row.rays).expect("rows name kinds of rays that there are");
        let rays = sets[set].1;
        let tracer = Tracer::new(kernel, &tree, triangles);
        let (hits, work) = count_batch(&Batch { tracer: &tracer, query: Query::Closest, rays });
        let per_ray = |n: u64| (!rays.is_empty()).then(|| n as f64 / rays.len() as f64);
        row.traced = Some(rays.len());
        row.nodes_per_ray = per_ray(work.nodes);
        row.box_tests_per_ray = per_ray(work.box_tests);
        row.tri_tests_per_ray = per_ray(work.triangle_tests);
        let (reference, checked) = &references[set];
        let verdict = compare_hits(reference, &hits);
        row.missed = Some(verdict.missed);
        row.other = Some(verdict.other);
        row.off = Some(verdict.off);
        row.largest_ulp = Some(verdict.largest_ulp);
        match checked {
            Ok(_) if kernel.is_exact() && hits != *reference => {
                (row.status, row.note) =
                    (Status::Error, "an exact kernel hits something else than the reference".into());
            }
            Ok(n) => (row.status, row.oracle_rays) = (Status::Ok, Some(*n)),
            Err(why) => (row.status, row.note) = (Status::Error, why.clone()),
        }
        entries.push(Entry { row, tracer, rays, hits, rates: Vec::new() });
    }
    let mut hits = Vec::new();
    for _ in 0..study.runs.max(1) {
        entries.iter_mut().for_each(|entry| entry.time(&mut hits));
    }
    entries.into_iter().map(Entry::finish).collect()
}

/// A kernel on one kind of rays.
struct Entry<'a> {
    row: AccuracyRow,
    tracer: Tracer<'a>,
    rays: &'a [Ray],
    /// What the counted pass saw.
    hits: Vec<HitRecord>,
    rates: Vec<f64>,
}

impl Entry<'_> {
    fn time(&mut self, hits: &mut Vec<HitRecord>) {
        let begin = Instant::now();
        trace_batch(&Batch { tracer: &self.tracer, query: Query::Closest, rays: self.rays }, hits);
        self.rates.push(self.rays.len() as f64 * 1e-6 / begin.elapsed().as_secs_f64());
        if *hits != self.hits {
            (self.row.status, self.row.note) =
                (Status::Error, "a timed pass saw other hits than the counted one".into());
        }
    }

    fn finish(self) -> AccuracyRow {
        let mut row = self.row;
        row.runs = self.rates.len();
        if let Some(rate) = spread(self.rates).filter(|_| row.status == Status::Ok) {
            put_rate(&mut row, rate);
        }
        row
    }
}

/// Rays from around the scene at corners and middles of edges: where a ray may slip between two triangles.
fn edge_rays(triangles: &[Triangle], count: usize) -> Vec<Ray> {
    let bounds = triangles.iter().fold(crate::geom::Aabb::EMPTY, |b, t| b.union(&t.aabb()));
    let (centre, extent) = (bounds.centre(), bounds.extent());
    let ray = |i: usize| {
        let mut random = Pcg32::new(super::RAY_SEED, i as u64);
        let triangle = &triangles[random.next_u32() as usize % triangles.len()];
        let corner = random.next_u32() as usize % 6;
        let [a, b] = [triangle.v[corner % 3], triangle.v[(corner + 1) % 3]];
        let target = if corner < 3 { a } else { a * 0.5 + b * 0.5 };
        let mut unit = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
        let origin = (centre + extent * DVec3::new(unit(), unit(), unit()) * 3.0).as_vec3();
        Ray::new(origin, target - origin)
    };
    let rays = (0..count).into_par_iter().map(ray);
    rays.filter(|r| r.direction != Vec3::ZERO).collect()
}

/// Holds the reference of some rays against all triangles in f64; how many were.
fn oracle(triangles: &[Triangle], rays: &[Ray], reference: &[HitRecord]) -> Result<usize, String> {
    let step = (rays.len() / ORACLE_RAYS).max(1);
    let some: Vec<usize> = (0..rays.len()).step_by(step).collect();
    let is_wrong = |&&i: &&usize| {
        let found = reference[i];
        let hit = found.is_hit().then_some(Hit { triangle: found.triangle, t: found.t });
        !Oracle::new(triangles, &rays[i], Arithmetic::Watertight).judge(hit).is_right()
    };
    let wrong = some.par_iter().filter(is_wrong).count();
    match wrong {
        0 => Ok(some.len()),
        _ => Err(format!("{wrong} of {} reference hits are not those of all triangles in f64", some.len())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hit(triangle: u32, t: f32) -> HitRecord {
        HitRecord { triangle, t }
    }

    #[test]
    fn every_way_to_be_wrong_is_told_apart() {
        let next = |x: f32, n: u32| f32::from_bits(x.to_bits() + n);
        let reference =
            [hit(1, 2.0), hit(1, 2.0), hit(1, 2.0), hit(1, 2.0), hit(1, 2.0), HitRecord::MISS, HitRecord::MISS];
        let answers = [
            hit(1, 2.0),
            HitRecord::MISS,
            hit(2, 3.0),
            hit(1, next(2.0, 5)),
            hit(2, next(2.0, 4)),
            hit(9, 1.0),
            HitRecord::MISS,
        ];
        let verdict = compare_hits(&reference, &answers);
        assert_eq!(verdict, Verdict { missed: 1, other: 2, off: 1, largest_ulp: 4 });
    }

    #[test]
    fn places_are_counted_through_zero() {
        assert_eq!(ulps_between(0.0, -0.0), 0);
        assert_eq!(ulps_between(f32::from_bits(1), -f32::from_bits(1)), 2);
        assert_eq!(ulps_between(1.0, 1.0f32.next_up()), 1);
        assert_eq!(ulps_between(-1.0, (-1.0f32).next_up()), 1);
        assert!(ulps_between(f32::MAX, f32::MIN) > 1 << 31);
    }

    #[test]
    fn a_wrong_reference_is_noticed() {
        let triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
        let rays = [Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z)];
        assert_eq!(oracle(&[triangle], &rays, &[hit(0, 1.0)]), Ok(1));
        assert!(oracle(&[triangle], &rays, &[hit(0, 1.001)]).is_err());
        assert!(oracle(&[triangle], &rays, &[HitRecord::MISS]).is_err());
    }
}
