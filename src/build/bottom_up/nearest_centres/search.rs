//! One search for the nearest live centre.
//!
//! Why no radius is too small. The rotation has integer entries and stretches by 75. With u = 2⁻⁵³, a turned coordinate
//! is wrong by at most 5u·129·|p|, where |p| is the largest coordinate of p (129 is the greatest sum of a row's
//! entries, 5 roundings), so a turned point by at most 75·15u·|p|. If p is within r of q, then |p| ≤ |q| + r, and the
//! turned points are at most 75·(r + 15u·(2|q| + r)) apart: 75·(r + 64u·(|q| + r)) is more. The factor 1 + 2⁻⁴⁰, twice,
//! is more than what the root and the square here, and the squares and sums of kiddo, are wrong by. Distances of
//! different centres do not underflow when squared: centres of f32 boxes are multiples of 2⁻¹⁵⁰.

use super::{Cost, NONE, Neighbour, Point};
use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use std::num::NonZeroUsize;

/// A rotation by the quaternion 7 + 3i + j + 4k, times its squared length [`STRETCH`]: no plane or line of points
/// that scenes are made of stays parallel to an axis.
const TURN: [DVec3; 3] = [DVec3::new(41.0, -50.0, 38.0), DVec3::new(62.0, 25.0, -34.0), DVec3::new(10.0, 50.0, 55.0)];
const STRETCH: f64 = 75.0;
/// 64u.
const TURN_ERROR: f64 = 1.0 / (1u64 << 47) as f64;
/// More than kiddo's own rounding, and ours of the radius.
const ROUNDING: f64 = 1.0 + 1.0 / (1u64 << 40) as f64;
/// Where the nearest points were dead, so many times their number, and then their squared distance, comes next.
const GROWTH: NonZeroUsize = NonZeroUsize::new(4).unwrap();

/// A point as the trees see it.
pub(in crate::build::bottom_up) fn turned(p: DVec3) -> [f64; 3] {
    TURN.map(|row| row.x * p.x + row.y * p.y + row.z * p.z)
}

/// What is known so far: in what was looked at, nothing that counts comes before `best`.
pub(super) struct Search<'a> {
    points: &'a [Point],
    centre: DVec3,
    turned: [f64; 3],
    /// The largest coordinate of the centre.
    magnitude: f64,
    except: u32,
    /// With id [`NONE`] where nothing is found yet: then the distance is the limit, inclusive.
    best: Neighbour,
    /// No turned point farther away can matter; squared.
    reach: f64,
    cost: Cost,
}

impl<'a> Search<'a> {
    pub fn new(points: &'a [Point], centre: DVec3, except: Option<u32>, limit: f64) -> Self {
        let mut search = Self {
            points,
            centre,
            turned: turned(centre),
            magnitude: centre.abs().max_element(),
            except: except.unwrap_or(NONE),
            best: Neighbour { distance: limit, id: NONE, point: NONE },
            reach: f64::MAX,
            cost: Cost::default(),
        };
        search.limit_reach();
        search
    }

    /// Looks at the points from `start` to `end`, one by one.
    pub fn scan(&mut self, start: u32, end: u32) {
        for point in start..end {
            self.offer(point);
        }
    }

    /// Looks at the points of `tree` that can matter; returns how many of them were dead.
    pub fn within(&mut self, tree: &ImmutableKdTree<f64, 3>) -> u64 {
        let turned = self.turned;
        let mut dead = 0;
        tree.query(&turned).within::<SquaredEuclidean<f64>>(self.reach).unsorted().visit(|found| {
            if found.distance <= self.reach {
                dead += u64::from(!self.offer(found.item));
            }
        });
        dead
    }

    /// Looks at the points of `tree` that can matter, where the radius may be far too large or there may be none:
    /// nothing in `tree` may be near enough for that to be a small part of it. Returns how many were dead.
    ///
    /// The nearest point gives the radius if it is alive. Otherwise the radius grows from there.
    pub fn approach(&mut self, tree: &ImmutableKdTree<f64, 3>) -> u64 {
        let nearest = tree.query(&self.turned).nearest_one::<SquaredEuclidean<f64>>().execute();
        if nearest.distance > self.reach {
            return 0;
        }
        if self.offer(nearest.item) {
            return self.within(tree);
        }
        let (mut reach, mut met) = (nearest.distance, NonZeroUsize::MIN);
        while reach == 0.0 && met.get() < tree.size() {
            met = met.saturating_mul(GROWTH).min(NonZeroUsize::MIN.saturating_add(tree.size() - 1));
            let found = tree.query(&self.turned).nearest_n::<SquaredEuclidean<f64>>(met).execute();
            reach = found.last().map_or(0.0, |farthest| farthest.distance);
        }
        let mut dead = 0;
        loop {
            reach *= GROWTH.get() as f64;
            if reach >= self.reach || reach == 0.0 {
                return dead + self.within(tree);
            }
            self.reach = reach;
            dead += self.within(tree);
            self.limit_reach();
            if self.reach <= reach {
                return dead;
            }
        }
    }

    /// The best, if anything was found.
    pub fn finish(self, cost: &mut Cost) -> Option<Neighbour> {
        cost.scored += self.cost.scored;
        cost.visits += self.cost.visits;
        (self.best.id != NONE).then_some(self.best)
    }

    /// Takes `point` if it is better; returns whether a live cluster is there that could have been.
    #[inline]
    fn offer(&mut self, point: u32) -> bool {
        let Point { centre, lowest, .. } = self.points[point as usize];
        self.cost.visits += 1;
        if lowest == NONE || point == self.except {
            return false;
        }
        let distance = distance_squared(self.centre, centre);
        self.cost.scored += 1;
        if (distance, lowest) < (self.best.distance, self.best.id) {
            let nearer = distance < self.best.distance;
            self.best = Neighbour { distance, id: lowest, point };
            if nearer {
                self.limit_reach();
            }
        }
        true
    }

    fn limit_reach(&mut self) {
        self.reach = if self.best.distance < f64::INFINITY {
            let radius = self.best.distance.sqrt();
            let turned = STRETCH * (radius + TURN_ERROR * (self.magnitude + radius)) * ROUNDING;
            turned * turned * ROUNDING
        } else {
            f64::MAX
        };
    }
}

/// A lower bound of the squared distance of `centre`, which is in `tree`, and any other point in it.
pub(super) fn gap(tree: &ImmutableKdTree<f64, 3>, centre: DVec3) -> f64 {
    const TWO: NonZeroUsize = NonZeroUsize::new(2).unwrap();
    let found = tree.query(&turned(centre)).nearest_n::<SquaredEuclidean<f64>>(TWO).execute();
    let Some(other) = found.get(1) else { return 0.0 };
    // The inverse of the reach of a radius: all points nearer than this were within the reach.
    let turned = other.distance.sqrt() / STRETCH / (ROUNDING * ROUNDING);
    let radius = (turned - TURN_ERROR * centre.abs().max_element()) / (1.0 + TURN_ERROR) / ROUNDING;
    radius.max(0.0) * radius.max(0.0)
}

/// Squared distance of two centres: differences and squares in f64, added x, y, z.
#[inline(always)]
pub(in crate::build::bottom_up) fn distance_squared(a: DVec3, b: DVec3) -> f64 {
    let (x, y, z) = (a.x - b.x, a.y - b.y, a.z - b.z);
    x * x + y * y + z * z
}
