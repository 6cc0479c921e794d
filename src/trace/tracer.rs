//! A kernel made ready for one tree: what it walks is laid out once, then any number of rays follow.

use super::closest::{Any, Closest, FastTest, Goal, any_hit, closest_hit};
use super::first_leaf::first_leaf;
use super::gather::{all_hits, in_order};
use super::hits::HitRecord;
use super::kernels::{Bits, Kernel, Query, Width};
use super::probe::TraceProbe;
use super::scratch::Scratch;
use super::slab::Slabs;
use super::wide::{Fast, GridNode, Leaves, OutOfRange, Watertight, WideBvh, wide_all_hits, wide_hit, wide_hits};
use crate::bvh::Bvh;
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::simd::Simd;

/// A kernel, the tree that it walks, and the layout that it wants of it.
#[derive(Clone, Debug)]
pub struct Tracer<'a> {
    kernel: Kernel,
    bvh: &'a Bvh,
    triangles: &'a [Triangle],
    wide: Wide,
    level: Simd,
}

#[derive(Clone, Debug)]
enum Wide {
    /// The kernel walks the tree as it is.
    None,
    Four(WideBvh<4>),
    Eight(WideBvh<8>),
    InSixteenBits(WideBvh<8, GridNode<8, u16>>),
    InEightBits(WideBvh<8, GridNode<8, u8>>),
}

impl<'a> Tracer<'a> {
    /// Makes `kernel` ready for `bvh` over `triangles` (by id): next to nothing for those that walk it as it is, a pass over
    /// nodes and triangles for the wide ones.
    ///
    /// # Panics
    /// On a triangle id beyond `triangles`.
    pub fn new(kernel: Kernel, bvh: &'a Bvh, triangles: &'a [Triangle]) -> Self {
        let wide = match kernel {
            Kernel::Wide { width: Width::Four, .. } => Wide::Four(WideBvh::new(bvh, triangles)),
            Kernel::Wide { width: Width::Eight, .. } => Wide::Eight(WideBvh::new(bvh, triangles)),
            Kernel::Quantised(Bits::Sixteen) => Wide::InSixteenBits(WideBvh::<8>::new(bvh, triangles).of_nodes()),
            Kernel::Quantised(Bits::Eight) => Wide::InEightBits(WideBvh::<8>::new(bvh, triangles).of_nodes()),
            Kernel::FirstLeaf(_) | Kernel::Scalar | Kernel::ScalarFast => Wide::None,
        };
        Self { kernel, bvh, triangles, wide, level: Simd::detect() }
    }

    /// The same with the vector instructions of `level`, for comparisons; answers do not depend on it.
    ///
    /// # Panics
    /// Where the processor does not have them.
    #[must_use]
    pub fn at_level(mut self, level: Simd) -> Self {
        assert!(level <= Simd::detect(), "this processor has no {level:?}");
        self.level = level;
        self
    }

    /// The kernel.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// The tree.
    pub fn bvh(&self) -> &'a Bvh {
        self.bvh
    }

    /// The scene's triangles.
    pub fn triangles(&self) -> &'a [Triangle] {
        self.triangles
    }

    /// Bytes of what the kernel walks: of its own layout, triangles included, or of the tree without them.
    pub fn bytes(&self) -> usize {
        match &self.wide {
            Wide::None => self.bvh.bytes(),
            Wide::Four(wide) => wide.bytes(),
            Wide::Eight(wide) => wide.bytes(),
            Wide::InSixteenBits(wide) => wide.bytes(),
            Wide::InEightBits(wide) => wide.bytes(),
        }
    }

    /// Traces one ray. For [`Query::Any`] the hit returned is [`Kernel::SOME_HIT`]: which triangle a search meets first
    /// depends on the tree, whether there is one does not.
    #[inline]
    pub fn trace<P: TraceProbe>(&self, query: Query, ray: &Ray, scratch: &mut Scratch, probe: &mut P) -> Option<Hit> {
        let fast = matches!(self.kernel, Kernel::Wide { fast: true, .. });
        match (&self.wide, fast, query) {
            (Wide::None, ..) => self.walk(query, ray, scratch, probe),
            (_, false, Query::Closest) => self.search::<Closest, Watertight, P>(query, ray, scratch, probe),
            (_, true, Query::Closest) => self.search::<Closest, Fast, P>(query, ray, scratch, probe),
            (_, false, Query::Any) => self.search::<Any, Watertight, P>(query, ray, scratch, probe),
            (_, true, Query::Any) => self.search::<Any, Fast, P>(query, ray, scratch, probe),
        }
    }

    /// Traces many rays on this thread, one record a ray into `answers`, the same as [`Self::trace`] gives ray by ray. Wide
    /// kernels have several rays on their way at once, which is quicker.
    ///
    /// # Panics
    /// Where there are not as many answers as rays.
    pub fn trace_all<P: TraceProbe>(
        &self,
        query: Query,
        rays: &[Ray],
        answers: &mut [HitRecord],
        scratch: &mut Scratch,
        probe: &mut P,
    ) {
        assert_eq!(rays.len(), answers.len(), "one answer a ray");
        let fast = matches!(self.kernel, Kernel::Wide { fast: true, .. });
        match (&self.wide, fast, query) {
            (Wide::None, ..) => {
                for (ray, answer) in rays.iter().zip(answers) {
                    *answer = self.walk(query, ray, scratch, probe).into();
                }
            }
            (_, false, Query::Closest) => {
                self.search_all::<Closest, Watertight, P>(query, rays, answers, scratch, probe)
            }
            (_, true, Query::Closest) => self.search_all::<Closest, Fast, P>(query, rays, answers, scratch, probe),
            (_, false, Query::Any) => self.search_all::<Any, Watertight, P>(query, rays, answers, scratch, probe),
            (_, true, Query::Any) => self.search_all::<Any, Fast, P>(query, rays, answers, scratch, probe),
        }
    }

    fn search_all<G: Goal, L: Leaves, P: TraceProbe>(
        &self,
        query: Query,
        rays: &[Ray],
        answers: &mut [HitRecord],
        scratch: &mut Scratch,
        probe: &mut P,
    ) {
        let out_of_range = match &self.wide {
            Wide::Four(wide) => wide_hits::<4, _, G, L, P>(self.level, wide, rays, answers, scratch, probe),
            Wide::Eight(wide) => wide_hits::<8, _, G, L, P>(self.level, wide, rays, answers, scratch, probe),
            Wide::InSixteenBits(wide) => {
                wide_hits::<8, _, G, Watertight, P>(self.level, wide, rays, answers, scratch, probe)
            }
            Wide::InEightBits(wide) => {
                wide_hits::<8, _, G, Watertight, P>(self.level, wide, rays, answers, scratch, probe)
            }
            Wide::None => (0..rays.len()).collect(),
        };
        for place in out_of_range {
            answers[place] = self.search_out_of_range(query, &rays[place], scratch, probe).into();
        }
        if G::FIRST_IS_ENOUGH {
            for answer in answers.iter_mut().filter(|answer| answer.is_hit()) {
                *answer = Some(Kernel::SOME_HIT).into();
            }
        }
    }

    /// The kernels that walk the tree as it is; for rays that the wide ones cannot trace, their like.
    #[inline(never)]
    fn walk<P: TraceProbe>(&self, query: Query, ray: &Ray, scratch: &mut Scratch, probe: &mut P) -> Option<Hit> {
        let (bvh, triangles) = (self.bvh, self.triangles);
        match (self.kernel, query) {
            (Kernel::FirstLeaf(options), Query::Closest) => first_leaf(bvh, triangles, ray, options, scratch, probe),
            (Kernel::FirstLeaf(options), Query::Any) => {
                first_leaf(bvh, triangles, ray, options, scratch, probe).map(|_| Kernel::SOME_HIT)
            }
            (Kernel::Scalar | Kernel::Wide { fast: false, .. } | Kernel::Quantised(_), Query::Closest) => {
                closest_hit::<WatertightRay, P>(bvh, triangles, ray, scratch, probe)
            }
            (Kernel::ScalarFast | Kernel::Wide { fast: true, .. }, Query::Closest) => {
                closest_hit::<FastTest, P>(bvh, triangles, ray, scratch, probe)
            }
            (Kernel::Scalar | Kernel::Wide { fast: false, .. } | Kernel::Quantised(_), Query::Any) => {
                any_hit::<WatertightRay, P>(bvh, triangles, ray, scratch, probe).then_some(Kernel::SOME_HIT)
            }
            (Kernel::ScalarFast | Kernel::Wide { fast: true, .. }, Query::Any) => {
                any_hit::<FastTest, P>(bvh, triangles, ray, scratch, probe).then_some(Kernel::SOME_HIT)
            }
        }
    }

    /// Every hit of one ray with t in `[t_min, t_max]`, into `hits` (emptied first) by t, equal t by triangle id; the first is
    /// the answer to [`Query::Closest`].
    ///
    /// A method of its own beside [`Query`], whose answers are one record a ray. The thesis' program has no such query: for
    /// kernel `first-leaf` the answer is that of `scalar`.
    pub fn all_hits<P: TraceProbe>(&self, ray: &Ray, scratch: &mut Scratch, probe: &mut P, hits: &mut Vec<Hit>) {
        let (bvh, triangles) = (self.bvh, self.triangles);
        let fast = matches!(self.kernel, Kernel::ScalarFast | Kernel::Wide { fast: true, .. });
        let slabs = Slabs::new(ray, &bvh.root().aabb).filter(|_| ray.is_traceable());
        if let Some(slabs) = slabs.filter(|_| self.kernel.is_wide()) {
            hits.clear();
            if fast {
                self.gather::<Fast, P>(ray, &slabs, scratch, probe, hits);
            } else {
                self.gather::<Watertight, P>(ray, &slabs, scratch, probe, hits);
            }
            in_order(hits);
        } else if fast {
            all_hits::<FastTest, P>(bvh, triangles, ray, scratch, probe, hits);
        } else {
            all_hits::<WatertightRay, P>(bvh, triangles, ray, scratch, probe, hits);
        }
    }

    fn gather<L: Leaves, P: TraceProbe>(
        &self,
        ray: &Ray,
        slabs: &Slabs,
        scratch: &mut Scratch,
        probe: &mut P,
        hits: &mut Vec<Hit>,
    ) {
        match &self.wide {
            Wide::Four(wide) => wide_all_hits::<4, _, L, P>(self.level, wide, ray, slabs, scratch, probe, hits),
            Wide::Eight(wide) => wide_all_hits::<8, _, L, P>(self.level, wide, ray, slabs, scratch, probe, hits),
            Wide::InSixteenBits(wide) => {
                wide_all_hits::<8, _, Watertight, P>(self.level, wide, ray, slabs, scratch, probe, hits);
            }
            Wide::InEightBits(wide) => {
                wide_all_hits::<8, _, Watertight, P>(self.level, wide, ray, slabs, scratch, probe, hits);
            }
            Wide::None => {}
        }
    }

    #[inline(always)]
    fn search<G: Goal, L: Leaves, P: TraceProbe>(
        &self,
        query: Query,
        ray: &Ray,
        scratch: &mut Scratch,
        probe: &mut P,
    ) -> Option<Hit> {
        let found = match &self.wide {
            Wide::Four(wide) => wide_hit::<4, _, G, L, P>(self.level, wide, ray, scratch, probe),
            Wide::Eight(wide) => wide_hit::<8, _, G, L, P>(self.level, wide, ray, scratch, probe),
            Wide::InSixteenBits(wide) => wide_hit::<8, _, G, Watertight, P>(self.level, wide, ray, scratch, probe),
            Wide::InEightBits(wide) => wide_hit::<8, _, G, Watertight, P>(self.level, wide, ray, scratch, probe),
            Wide::None => Err(OutOfRange),
        };
        match found {
            Ok(hit) if G::FIRST_IS_ENOUGH => hit.map(|_| Kernel::SOME_HIT),
            Ok(hit) => hit,
            Err(OutOfRange) => self.search_out_of_range(query, ray, scratch, probe),
        }
    }

    /// Rays that the wide kernel has no f32 for, and those that hit nothing because they are no rays.
    #[cold]
    #[inline(never)]
    fn search_out_of_range<P: TraceProbe>(
        &self,
        query: Query,
        ray: &Ray,
        scratch: &mut Scratch,
        probe: &mut P,
    ) -> Option<Hit> {
        if !ray.is_traceable() {
            return None;
        }
        let fast = matches!(self.kernel, Kernel::Wide { fast: true, .. });
        // The watertight test goes on where the products of the fast one overflow.
        if fast && Slabs::new(ray, &self.bvh.root().aabb).is_some() {
            return match query {
                Query::Closest => self.search::<Closest, Watertight, P>(query, ray, scratch, probe),
                Query::Any => self.search::<Any, Watertight, P>(query, ray, scratch, probe),
            };
        }
        // Too large or too small for f32 distances: as kernel `scalar` does it, in f64.
        self.walk(query, ray, scratch, probe)
    }
}
