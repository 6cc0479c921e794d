//! Whole ray sets at once, in parallel, with the same answers for any number of threads.

use super::hits::HitRecord;
use super::kernels::Query;
use super::probe::{TraceCounters, TraceProbe};
use super::scratch::Scratch;
use super::tracer::Tracer;
use crate::geom::Ray;
use rayon::prelude::*;

/// Rays that one thread takes at a time.
const CHUNK: usize = 1024;

/// What is traced, through what, and how.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// The kernel, made ready for its tree.
    pub tracer: &'a Tracer<'a>,
    /// What is asked of every ray.
    pub query: Query,
    /// The rays.
    pub rays: &'a [Ray],
}

/// Traces the rays on the current rayon pool, one record a ray, into `hits` (grown or cut to fit, so that a repeated run
/// allocates next to nothing).
pub fn trace_batch(batch: &Batch, hits: &mut Vec<HitRecord>) {
    hits.resize(batch.rays.len(), HitRecord::MISS);
    batch.rays.par_chunks(CHUNK).zip(hits.par_chunks_mut(CHUNK)).for_each_init(
        Scratch::default,
        |scratch, (rays, hits)| {
            batch.trace_chunk(rays, hits, scratch, &mut ());
        },
    );
}

/// As [`trace_batch`], with the work counted: a separate pass, never the timed one.
pub fn count_batch(batch: &Batch) -> (Vec<HitRecord>, TraceCounters) {
    let mut hits = vec![HitRecord::MISS; batch.rays.len()];
    let work = batch
        .rays
        .par_chunks(CHUNK)
        .zip(hits.par_chunks_mut(CHUNK))
        .map_init(Scratch::default, |scratch, (rays, hits)| {
            let mut work = TraceCounters::default();
            batch.trace_chunk(rays, hits, scratch, &mut work);
            work
        })
        .reduce(TraceCounters::default, |a, b| a + b);
    (hits, work)
}

impl Batch<'_> {
    fn trace_chunk<P: TraceProbe>(&self, rays: &[Ray], hits: &mut [HitRecord], scratch: &mut Scratch, probe: &mut P) {
        self.tracer.trace_all(self.query, rays, hits, scratch, probe);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{Random, soup};
    use crate::trace::kernels::KERNELS;
    use crate::trace::testing::{any_ray, median_split};

    #[test]
    fn answers_and_counts_do_not_depend_on_the_number_of_threads() {
        let mut random = Random(3);
        let triangles = soup(3, 3000, 0.05);
        let rays: Vec<_> = (0..5000).map(|_| any_ray(&mut random)).collect();
        let bvh = median_split(&triangles, 4);
        for info in KERNELS {
            for query in [Query::Closest, Query::Any] {
                let tracer = Tracer::new(info.kernel, &bvh, &triangles);
                let batch = Batch { tracer: &tracer, query, rays: &rays };
                let answers = [1, 2, 7].map(|threads| {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                    pool.install(|| {
                        let mut hits = Vec::new();
                        trace_batch(&batch, &mut hits);
                        let (counted, work) = count_batch(&batch);
                        assert_eq!(hits, counted);
                        (hits, work)
                    })
                });
                assert!(answers[0] == answers[1] && answers[0] == answers[2], "{}", info.id);
                assert!(answers[0].0.iter().any(HitRecord::is_hit) && answers[0].0.iter().any(|h| !h.is_hit()));
            }
        }
    }
}
