//! Readings of the thesis' top-down search that lie between `published` and `text`: all splits of a node on one axis, at ranks or
//! at planes, by weighted areas or by plain ones.
//!
//! Source: Beick 2014, "Construction Algorithms", which says neither whether the "evenly spaced" candidates are spaced in space or
//! among the triangles, nor what one sum of areas means for nodes of different size. Ranks with weighted areas are `published`
//! without rule Q8 ([`super::published_exact`]); at arity 2, planes with plain areas are `text` ([`super::text_exact`]): tests hold this
//! search to both. It is for comparing readings, so it is plain: a table of all runs, O(k·m²) a node and axis.
//!
//! Ties: the first axis, then the first splits in lexicographic order. Where an axis has too few candidates for `arity` children, fewer
//! are made, and an axis that makes more children goes first; where none makes two, the triangles are halved by id.

use super::Published;
use crate::build::{BuildError, ChildCost, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use ordered_float::OrderedFloat;

/// Where the candidates of a node lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// Evenly spaced among the triangles, sorted by lower coordinate.
    Ranks,
    /// Evenly spaced in the node's box; a triangle is on the side of its box centre.
    Planes,
}

/// What a child costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighing {
    /// Its area alone.
    Area,
    /// Its area times one less than its triangles.
    Weighted,
}

/// Parameters of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OneAxis {
    /// Children per inner node: 2 to 8.
    pub arity: usize,
    /// Candidates per axis.
    pub candidates: usize,
    /// Where they lie.
    pub placement: Placement,
    /// What a child costs.
    pub weighing: Weighing,
}

/// Builds the tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, an arity or a number of candidates that [`Published::check`] refuses, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &OneAxis, probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    params.ranks().check()?;
    let mut ids: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Node::leaf(Aabb::union_of(boxes), 0, boxes.len())];
    let mut pending = vec![(0, 0..boxes.len())];
    while let Some((node, slots)) = pending.pop() {
        if slots.len() <= MAX_LEAF {
            continue;
        }
        let search = Search { boxes, params, node: nodes[node].aabb };
        let ends = search.split(&mut ids[slots.clone()], probe);
        if !probe.go_on(slots.len() as u64) {
            let sizes = pending.iter().map(|(_, slots)| slots.len()).chain([slots.len()]);
            return Err(BuildError::Stopped(Unfinished { pending: sizes.collect() }));
        }
        let first = nodes.len();
        nodes[node] = Node::inner(nodes[node].aabb, first, ends.len());
        let lined_up = pending.len();
        let mut start = slots.start;
        for (k, end) in ends.into_iter().map(|end| slots.start + end).enumerate() {
            let aabb = Aabb::union_of(ids[start..end].iter().map(|&t| &boxes[t as usize]));
            nodes.push(Node::leaf(aabb, start, end - start));
            pending.push((first + k, start..end));
            start = end;
        }
        pending[lined_up..].reverse();
    }
    Ok(Bvh { nodes, triangle_ids: ids, arity: params.arity })
}

impl OneAxis {
    /// The ranks of `published` with as many candidates.
    const fn ranks(&self) -> Published {
        Published { arity: self.arity, candidates: self.candidates, q8: false }
    }
}

/// The search in one node.
struct Search<'a> {
    boxes: &'a [Aabb],
    params: &'a OneAxis,
    node: Aabb,
}

/// The best division on one axis.
struct Division {
    axis: usize,
    cost: i64,
    /// Triangles before which its children end.
    ends: Vec<usize>,
}

impl Search<'_> {
    /// Puts `ids` in the order of the best division and says where its children end.
    fn split<P: Probe>(&self, ids: &mut [u32], probe: &mut P) -> Vec<usize> {
        let mut best: Option<Division> = None;
        for axis in 0..3 {
            self.sort(ids, axis);
            let here = self.divide(ids, axis, probe);
            let better = |b: &Division| (here.ends.len(), -here.cost) > (b.ends.len(), -b.cost);
            if best.as_ref().is_none_or(better) {
                best = Some(here);
            }
        }
        let best = best.expect("there are three axes");
        if best.ends.len() < 2 {
            ids.sort_unstable();
            return vec![ids.len() / 2, ids.len()];
        }
        self.sort(ids, best.axis);
        best.ends
    }

    fn sort(&self, ids: &mut [u32], axis: usize) {
        let key = |t: u32| match self.params.placement {
            Placement::Ranks => f64::from(self.boxes[t as usize].min[axis]),
            Placement::Planes => self.boxes[t as usize].centre()[axis],
        };
        ids.sort_unstable_by_key(|&t| (OrderedFloat(key(t)), t));
    }

    /// Triangles, in the axis' order, before which a candidate cuts: rising, neither 0 nor all.
    fn candidates(&self, ids: &[u32], axis: usize) -> Vec<usize> {
        let n = ids.len();
        if self.params.placement == Placement::Ranks {
            return (self.params.ranks().stride(n)..n).step_by(self.params.ranks().stride(n)).collect();
        }
        let planes = self.params.candidates;
        let (origin, extent) = (f64::from(self.node.min[axis]), self.node.extent()[axis]);
        // The same product as `text`, so that a centre on a plane falls to the same side.
        let below = |t: u32, plane: usize| {
            let offset = (self.boxes[t as usize].centre()[axis] - origin) * (planes + 1) as f64;
            offset < (plane + 1) as f64 * extent
        };
        let mut cuts: Vec<usize> = (0..planes).map(|plane| ids.partition_point(|&t| below(t, plane))).collect();
        cuts.dedup();
        cuts.retain(|&cut| cut > 0 && cut < n);
        cuts
    }

    fn divide<P: Probe>(&self, ids: &[u32], axis: usize, probe: &mut P) -> Division {
        let mut cuts = self.candidates(ids, axis);
        cuts.insert(0, 0);
        cuts.push(ids.len());
        let segments = cuts.len() - 1;
        let children = self.params.arity.min(segments);
        let terms = self.terms(ids, &cuts);
        probe.add(Work::BoxUnions, (ids.len() + segments * segments / 2) as u64);
        let run = |a: usize, b: usize| terms[a * (segments + 1) + b];
        // least[j][a]: the segments from a on as j + 1 children; what cannot be is out of reach of any sum.
        const IMPOSSIBLE: i64 = i64::MAX / 16;
        let mut least: Vec<Vec<i64>> = vec![(0..segments).map(|a| run(a, segments)).chain([IMPOSSIBLE]).collect()];
        while least.len() < children {
            let fewer = &least[least.len() - 1];
            let cheapest = |a: usize| (a + 1..segments).map(|b| run(a, b) + fewer[b]).fold(IMPOSSIBLE, i64::min);
            let row = (0..=segments).map(cheapest).collect();
            least.push(row);
            probe.add(Work::DpSteps, (segments * segments / 2) as u64);
        }
        let cost = least[children - 1][0];
        let (mut at, mut ends) = (0, Vec::with_capacity(children));
        for j in (1..children).rev() {
            let reaches = |&b: &usize| run(at, b) + least[j - 1][b] == least[j][at];
            at = (at + 1..segments).find(reaches).expect("the least cost is reached");
            ends.push(cuts[at]);
        }
        ends.push(ids.len());
        Division { axis, cost, ends }
    }

    /// The terms of all runs of segments a … b − 1, row by row.
    fn terms(&self, ids: &[u32], cuts: &[usize]) -> Vec<i64> {
        let segments = cuts.len() - 1;
        let of = |k: usize| Aabb::union_of(ids[cuts[k]..cuts[k + 1]].iter().map(|&t| &self.boxes[t as usize]));
        let boxes: Vec<Aabb> = (0..segments).map(of).collect();
        let total = match self.params.weighing {
            Weighing::Area => self.params.arity,
            Weighing::Weighted => ids.len(),
        };
        let cost = ChildCost::new(&self.node, total);
        let mut terms = vec![0; (segments + 1) * (segments + 1)];
        for a in 0..segments {
            let mut run = Aabb::EMPTY;
            for b in a + 1..=segments {
                run = run.union(&boxes[b - 1]);
                let weight = match self.params.weighing {
                    Weighing::Area => 1,
                    Weighing::Weighted => cuts[b] - cuts[a] - 1,
                };
                terms[a * (segments + 1) + b] = cost.term(&run, weight);
            }
        }
        terms
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::top_down::{Text, published_exact, text_exact};
    use crate::bvh::testing::{Random, boxes, soup};
    use crate::bvh::{Limits, tree_hash, validate};
    use crate::cost::{SahParams, sah};
    use glam::Vec3;

    fn scenes() -> Vec<Vec<Aabb>> {
        let mut random = Random(11);
        let grid = (0..300).map(|_| {
            let corner = Vec3::new(random.below(6) as f32, random.below(5) as f32, random.below(4) as f32);
            Aabb::new(corner, corner + Vec3::new(1.0, (random.below(3)) as f32, 1.0))
        });
        let grid: Vec<_> = grid.collect();
        let equal = vec![Aabb::new(Vec3::ZERO, Vec3::ONE); 37];
        let mut all = vec![boxes(&soup(1, 700, 0.1)), boxes(&soup(2, 90, 1.0)), grid, equal];
        all.extend((1..12).map(|n| boxes(&soup(n as u64, n, 0.3))));
        all
    }

    #[test]
    fn ranks_with_weights_are_published_without_its_rule() {
        for boxes in scenes() {
            for arity in [2, 4, 8] {
                let candidates = 200 / arity;
                let params = OneAxis { arity, candidates, placement: Placement::Ranks, weighing: Weighing::Weighted };
                let ours = build(&boxes, &params, &mut ()).unwrap();
                let published = Published { q8: false, ..Published::at_arity(arity) };
                let theirs = published_exact::build(&boxes, &published, &mut ()).unwrap();
                let cost = |bvh| sah(bvh, SahParams::default()).unwrap_or(0.0);
                let (a, b) = (cost(&ours), cost(&theirs));
                assert!((a - b).abs() <= 1e-12 * a, "{} boxes, arity {arity}: {a} {b}", boxes.len());
                // Where there are fewer triangles than children, the program left them in the order of z.
                assert!(arity == 8 || tree_hash(&ours) == tree_hash(&theirs), "{} boxes, arity {arity}", boxes.len());
            }
        }
    }

    #[test]
    fn planes_with_areas_are_text_at_arity_2() {
        for boxes in scenes() {
            let params = OneAxis { arity: 2, candidates: 100, placement: Placement::Planes, weighing: Weighing::Area };
            let ours = build(&boxes, &params, &mut ()).unwrap();
            let theirs = text_exact::build(&boxes, &Text::at_arity(2), &mut ()).unwrap();
            assert_eq!(tree_hash(&ours), tree_hash(&theirs), "{} boxes", boxes.len());
        }
    }

    #[test]
    fn every_reading_makes_valid_trees() {
        for boxes in scenes() {
            for arity in [2, 4, 8] {
                for placement in [Placement::Ranks, Placement::Planes] {
                    for weighing in [Weighing::Area, Weighing::Weighted] {
                        let params = OneAxis { arity, candidates: 200 / arity, placement, weighing };
                        let bvh = build(&boxes, &params, &mut ()).unwrap();
                        validate(&bvh, &boxes, &Limits::default()).unwrap();
                    }
                }
            }
        }
        let refused = OneAxis { arity: 9, candidates: 100, placement: Placement::Ranks, weighing: Weighing::Area };
        assert!(build(&[Aabb::new(Vec3::ZERO, Vec3::ONE)], &refused, &mut ()).is_err());
    }
}
