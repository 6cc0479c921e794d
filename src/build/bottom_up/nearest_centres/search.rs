//! One search for the nearest live centre.

use super::{Cost, NONE, Neighbour, Point};
use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use std::num::NonZeroUsize;

/// A rotation by the quaternion 7 + 3i + j + 4k, times its squared length [`STRETCH`]: no plane or line of points
/// that scenes are made of stays parallel to an axis.
const TURN: [DVec3; 3] = [DVec3::new(41.0, -50.0, 38.0), DVec3::new(62.0, 25.0, -34.0), DVec3::new(10.0, 50.0, 55.0)];
const STRETCH: f64 = 75.0;
/// Bound on the rounding of turned points, relative to their largest coordinate: 64u.
const TURN_ERROR: f64 = 1.0 / (1u64 << 47) as f64;
/// More than kiddo's own rounding, and ours of the radius.
const ROUNDING: f64 = 1.0 + 1.0 / (1u64 << 40) as f64;
/// Nearest points asked for when the nearest ones were all dead: so many times as many as before.
const GROWTH: usize = 8;

/// A point as the trees see it.
pub(super) fn turned(p: DVec3) -> [f64; 3] {
    TURN.map(|row| row.x * p.x + row.y * p.y + row.z * p.z)
}

/// What is known so far: nothing live but the best is at most `best.distance` away, in what was looked at.
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

    /// Looks at the points from `start` on, one by one.
    pub fn scan(&mut self, start: u32) {
        for point in start..self.points.len() as u32 {
            self.offer(point);
        }
    }

    /// Looks at the points of `tree` that can matter; returns how many of them were dead.
    pub fn within(&mut self, tree: &ImmutableKdTree<f64, 3>) -> u64 {
        let mut dead = 0;
        let turned = self.turned;
        tree.query(&turned).within::<SquaredEuclidean<f64>>(self.reach).unsorted().visit(|found| {
            if found.distance <= self.reach {
                dead += u64::from(!self.offer(found.item));
            }
        });
        dead
    }

    /// Finds a live point in `tree`, so that there is a radius to look within; returns how many dead ones were met.
    pub fn approach(&mut self, tree: &ImmutableKdTree<f64, 3>) -> u64 {
        let turned = self.turned;
        let nearest = tree.query(&turned).nearest_one::<SquaredEuclidean<f64>>().execute();
        if nearest.distance > self.reach || self.offer(nearest.item) {
            return 0;
        }
        let mut met = 1;
        while met < tree.size() {
            let wanted = NonZeroUsize::MIN.saturating_add((met * GROWTH).min(tree.size()) - 1);
            let found = tree.query(&turned).nearest_n::<SquaredEuclidean<f64>>(wanted).execute();
            if found[met..].iter().any(|found| found.distance > self.reach || self.offer(found.item)) {
                break;
            }
            met = found.len();
        }
        met as u64
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
        if self.best.distance < f64::INFINITY {
            let radius = self.best.distance.sqrt();
            let turned = STRETCH * (radius + TURN_ERROR * (self.magnitude + radius)) * ROUNDING;
            self.reach = turned * turned * ROUNDING;
        }
    }
}

/// Squared distance of two centres: differences and squares in f64, added x, y, z.
#[inline(always)]
pub(in crate::build::bottom_up) fn distance_squared(a: DVec3, b: DVec3) -> f64 {
    let (x, y, z) = (a.x - b.x, a.y - b.y, a.z - b.z);
    x * x + y * y + z * z
}
