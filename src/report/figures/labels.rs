//! Labels of points that do not overlap each other or a point: each goes to the nearest free place around its point.

/// A rectangle in units of the canvas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Box2 {
    /// Left.
    pub x0: i32,
    /// Top.
    pub y0: i32,
    /// Right.
    pub x1: i32,
    /// Bottom.
    pub y1: i32,
}

impl Box2 {
    fn overlaps(&self, other: &Self) -> bool {
        self.x0 < other.x1 && other.x0 < self.x1 && self.y0 < other.y1 && other.y0 < self.y1
    }

    fn holds(&self, other: &Self) -> bool {
        self.x0 <= other.x0 && self.y0 <= other.y0 && other.x1 <= self.x1 && other.y1 <= self.y1
    }

    fn around((x, y): (i32, i32), half: i32) -> Self {
        Self { x0: x - half, y0: y - half, x1: x + half, y1: y + half }
    }

    /// The point of it that is nearest to `(x, y)`.
    pub fn nearest(&self, (x, y): (i32, i32)) -> (i32, i32) {
        (x.clamp(self.x0, self.x1), y.clamp(self.y0, self.y1))
    }

    /// Whether the straight line between two points comes inside.
    fn is_crossed(&self, from: (i32, i32), to: (i32, i32)) -> bool {
        const STEPS: i32 = 32;
        (0..=STEPS).any(|i| {
            let at = |a: i32, b: i32| a + (b - a) * i / STEPS;
            let (x, y) = (at(from.0, to.0), at(from.1, to.1));
            self.x0 < x && x < self.x1 && self.y0 < y && y < self.y1
        })
    }
}

/// Half the side of the square that a mark takes.
const MARK: i32 = 9;
/// Directions around a point, and the distances that are tried, the nearest first.
const DIRECTIONS: usize = 24;
const REACH: std::ops::RangeInclusive<i32> = 1..=22;
const STEP: i32 = 14;
/// Beyond this distance a line leads from the point to its label.
const NEAR: i32 = 16;

/// Where a label stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placed {
    /// The label's rectangle.
    pub at: Box2,
    /// Where the line from the point ends that leads to it, if it stands off.
    pub leader: Option<(i32, i32)>,
}

/// A place inside `room` for each label of the given width and height, the first ones first; none where all places are taken.
/// No label covers another one, a mark, or one of the `lines`. Lines that lead to labels keep off other marks and labels where
/// that can be had.
pub(crate) fn place(points: &[(i32, i32)], sizes: &[(i32, i32)], lines: &[Box2], room: Box2) -> Vec<Option<Placed>> {
    let marks: Vec<Box2> = points.iter().map(|p| Box2::around(*p, MARK)).collect();
    let mut placed: Vec<Option<Placed>> = Vec::new();
    for (i, (&point, &size)) in points.iter().zip(sizes).enumerate() {
        let others = || placed.iter().zip(points).filter_map(|(other, from)| other.map(|other| (other, *from)));
        let is_free = |candidate: &Placed| {
            let taken = marks.iter().chain(lines).any(|m| m.overlaps(&candidate.at));
            room.holds(&candidate.at) && !taken && others().all(|(other, _)| !other.at.overlaps(&candidate.at))
        };
        let is_clear = |candidate: &Placed| {
            let crossed = |(other, from): (Placed, (i32, i32))| {
                other.leader.is_some_and(|to| candidate.at.is_crossed(from, to))
                    || candidate.leader.is_some_and(|to| other.at.is_crossed(point, to))
            };
            // Where points lie on each other, no line gets away from one without crossing the other.
            let strange = || marks.iter().filter(|m| !m.overlaps(&marks[i]));
            !others().any(crossed) && candidate.leader.is_none_or(|to| strange().all(|m| !m.is_crossed(point, to)))
        };
        let places = || REACH.flat_map(|reach| around(point, size, reach * STEP)).filter(is_free);
        let found = places().find(is_clear).or_else(|| places().next());
        placed.push(found);
    }
    placed
}

/// Places at a distance, sideways ones first.
fn around((x, y): (i32, i32), (width, height): (i32, i32), distance: i32) -> impl Iterator<Item = Placed> {
    (0..DIRECTIONS).map(move |i| {
        // 0, 1, -1, 2, -2, … from the right round to the left.
        let turn = if i % 2 == 1 { i.div_ceil(2) as f64 } else { -(i as f64) / 2.0 };
        let (sine, cosine) = (turn * std::f64::consts::TAU / DIRECTIONS as f64).sin_cos();
        let (dx, dy) = (f64::from(distance) * cosine, f64::from(distance) * sine);
        // The corner, edge or middle of the label that faces the point keeps the distance.
        let x0 = x + dx as i32 - (f64::from(width) * 0.5 * (1.0 - cosine)) as i32;
        let y0 = y + dy as i32 - (f64::from(height) * 0.5 * (1.0 - sine)) as i32;
        let at = Box2 { x0, y0, x1: x0 + width, y1: y0 + height };
        let leader = (distance > NEAR).then(|| at.nearest((x, y)));
        Placed { at, leader }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Box2 = Box2 { x0: 0, y0: 0, x1: 1400, y1: 600 };

    /// Thirty points, most of them close together.
    fn crowd() -> Vec<(i32, i32)> {
        (0..30)
            .map(|i| if i % 3 == 0 { (100 + 40 * i, 300) } else { (700 + (i * 37) % 90, 280 + (i * 53) % 70) })
            .collect()
    }

    #[test]
    fn labels_of_a_crowd_keep_apart() {
        let points = crowd();
        let sizes: Vec<_> = (0..30).map(|i| (80 + 7 * i, 20)).collect();
        let line = Box2 { x0: 0, y0: 330, x1: 1400, y1: 332 };
        let placed = place(&points, &sizes, &[line], ROOM);
        let all: Vec<_> = placed.iter().flatten().collect();
        assert_eq!(all.len(), 30);
        for (i, a) in all.iter().enumerate() {
            assert!(ROOM.holds(&a.at) && !line.overlaps(&a.at));
            assert!(points.iter().all(|p| !Box2::around(*p, MARK).overlaps(&a.at)));
            assert!(all[..i].iter().all(|b| !a.at.overlaps(&b.at)));
        }
    }

    #[test]
    fn a_lonely_label_stands_beside_its_point() {
        let placed = place(&[(100, 100)], &[(50, 20)], &[], ROOM)[0].unwrap();
        assert_eq!((placed.at, placed.leader), (Box2 { x0: 114, y0: 90, x1: 164, y1: 110 }, None));
        let at_the_edge = place(&[(1390, 100)], &[(50, 20)], &[], ROOM)[0].unwrap();
        assert!(ROOM.holds(&at_the_edge.at));
        assert_eq!(place(&[(5, 5)], &[(2000, 20)], &[], ROOM), [None]);
    }
}
