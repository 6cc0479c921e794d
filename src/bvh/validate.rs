//! The validator: whether a tree is a tree, and what it covers.

mod cover;
mod violation;

pub use violation::{Violation, Violations};

use super::{Bvh, NodeKind};
use crate::geom::{Aabb, Triangle};
use cover::is_covered;
use rayon::prelude::*;

/// What a valid tree is held to, besides its own arity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The most triangles a leaf may hold.
    pub max_leaf: usize,
    /// Whether the tree comes from a builder with the thesis' rule Q8, whose nodes hold empty leaves, share triangles
    /// with their neighbours and have boxes of their own making.
    pub q8: bool,
    /// Whether spatial splits may have put a triangle into several leaves, each with a part of it.
    pub spatial: bool,
}

impl Default for Limits {
    /// The thesis' leaf limit of 4, without rule Q8, without spatial splits.
    fn default() -> Self {
        Self { max_leaf: 4, q8: false, spatial: false }
    }
}

/// What a valid tree covers. Without rule Q8 all but `references` are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    /// Triangles over all leaves, each as often as it stands there.
    pub references: usize,
    /// Triangles that stand in more than one leaf.
    pub duplicated: usize,
    /// Triangles that every leaf holding them hides below some box, its own included, that does not contain them, so
    /// that a ray may miss them.
    pub hidden: usize,
    /// Leaves without triangles.
    pub empty_leaves: usize,
    /// Nodes that rule Q8 made.
    pub q8_nodes: usize,
}

/// Checks a tree over triangles with the given boxes (indexed by triangle id), in time linear in nodes, slots and boxes.
///
/// Checked: there is a root; every node but the root is the child of exactly one node, which stands before it; ranges
/// are in bounds; degrees and leaves keep their limits; no leaf is empty; every triangle stands in exactly one leaf;
/// every box is exactly the union of the boxes below it.
///
/// With [`Limits::q8`] the following is exempt, and nothing else:
/// - A node of eight children, of which the first seven are empty leaves and the last is not, is one that rule Q8 made.
///   Its seven leaves may be empty. Its box need not contain its last child's, which must be the union of its own and
///   of the box of the second to seventh leaf (all alike).
/// - A triangle may stand in several leaves (but not twice in one). A leaf with such a triangle need not be tight: its
///   slots may have been permuted after its box was taken.
///
/// With [`Limits::spatial`] a triangle may stand in several leaves, but not twice in one. A leaf with such a triangle need
/// not be tight, but must lie within the boxes of its triangles; and the leaves with a triangle must reach all
/// six faces of its box, which is all that can be said without the triangle: see [`validate_parts`].
///
/// # Errors
/// The violations found; garbage of any kind is a violation, never a panic.
pub fn validate(bvh: &Bvh, boxes: &[Aabb], limits: &Limits) -> Result<Coverage, Violations> {
    Check { bvh, boxes, triangles: None, limits, found: Violations { first: Vec::new(), total: 0 } }.result()
}

/// [`validate`], and with [`Limits::spatial`] that every point of every triangle lies in a leaf that holds it. A gap no
/// wider than 2⁻²⁵ of the triangle's longest extent does not count.
///
/// # Errors
/// As [`validate`].
///
/// # Panics
/// Where there are not as many boxes as triangles.
pub fn validate_parts(
    bvh: &Bvh,
    triangles: &[Triangle],
    boxes: &[Aabb],
    limits: &Limits,
) -> Result<Coverage, Violations> {
    assert_eq!(triangles.len(), boxes.len());
    let found = Violations { first: Vec::new(), total: 0 };
    Check { bvh, boxes, triangles: Some(triangles), limits, found }.result()
}

struct Check<'a> {
    bvh: &'a Bvh,
    boxes: &'a [Aabb],
    triangles: Option<&'a [Triangle]>,
    limits: &'a Limits,
    found: Violations,
}

/// What the walk from the root finds out about a node.
#[derive(Clone, Copy)]
struct Place {
    reached: bool,
    /// Whether the node is one of the seven empty leaves of a node that rule Q8 made.
    filler: bool,
    /// Intersection of the boxes on the path from the root, the node's own included: it contains exactly the boxes that
    /// all of these contain.
    seen_through: Aabb,
}

impl Check<'_> {
    fn result(mut self) -> Result<Coverage, Violations> {
        let coverage = self.run();
        if self.found.total == 0 { Ok(coverage) } else { Err(self.found) }
    }

    fn report(&mut self, violation: Violation) {
        if self.found.first.len() < Violations::KEPT {
            self.found.first.push(violation);
        }
        self.found.total += 1;
    }

    fn run(&mut self) -> Coverage {
        let mut coverage = Coverage::default();
        if self.bvh.nodes.is_empty() {
            self.report(Violation::NoRoot);
            return coverage;
        }
        let places = self.walk(&mut coverage);
        self.triangles(&places, &mut coverage);
        coverage
    }

    /// Checks inner nodes. As children stand behind their parents, a pass over the nodes is a walk from the root.
    fn walk(&mut self, coverage: &mut Coverage) -> Vec<Place> {
        let nodes = &self.bvh.nodes;
        let mut places = vec![Place { reached: false, filler: false, seen_through: Aabb::EMPTY }; nodes.len()];
        places[0].reached = true;
        places[0].seen_through = nodes[0].aabb;
        for (index, node) in nodes.iter().enumerate() {
            let place = places[index];
            if !place.reached {
                self.report(Violation::Orphan(index));
                continue;
            }
            let NodeKind::Inner(children) = node.kind() else {
                continue;
            };
            if children.is_empty() {
                self.report(Violation::NoChildren(index));
                continue;
            }
            if children.start <= index {
                self.report(Violation::ChildNotBehind(index));
                continue;
            }
            if children.end > nodes.len() {
                self.report(Violation::ChildrenOutOfBounds(index));
                continue;
            }
            if children.len() > self.bvh.arity {
                self.report(Violation::TooManyChildren {
                    node: index,
                    children: children.len(),
                    arity: self.bvh.arity,
                });
            }
            let q8 = self.limits.q8 && self.made_by_q8(children.clone());
            coverage.q8_nodes += usize::from(q8);
            let shared = children.clone().find(|&child| places[child].reached);
            if let Some(child) = shared {
                // The rest is not looked at: so no garbage costs more than linear time.
                self.report(Violation::Shared { child, parent: index });
                continue;
            }
            for child in children.clone() {
                places[child] = Place {
                    reached: true,
                    filler: q8 && child + 1 < children.end,
                    seen_through: intersection(&place.seen_through, &nodes[child].aabb),
                };
            }
            let tight = if q8 {
                self.q8_boxes_fit(index, children)
            } else {
                node.aabb == Aabb::union_of(nodes[children].iter().map(|n| &n.aabb))
            };
            if !tight {
                self.report(Violation::LooseBox(index));
            }
        }
        places
    }

    fn made_by_q8(&self, children: std::ops::Range<usize>) -> bool {
        let is_empty_leaf = |child: usize| self.bvh.nodes[child].is_leaf() && self.bvh.nodes[child].count() == 0;
        let last = children.end - 1;
        children.len() == 8 && !is_empty_leaf(last) && (children.start..last).all(is_empty_leaf)
    }

    /// What follows of the boxes from the rule's text: the first leaf has the box of one of the node's triangles, the
    /// next six have that of its left neighbour, and the last child covers the node's triangles and the neighbour.
    fn q8_boxes_fit(&self, index: usize, children: std::ops::Range<usize>) -> bool {
        let node = &self.bvh.nodes[index].aabb;
        let child = |k: usize| &self.bvh.nodes[children.start + k].aabb;
        node.contains(child(0)) && (2..7).all(|k| child(k) == child(1)) && child(7) == &Aabb::union_of([node, child(1)])
    }

    /// Checks leaves and what they hold.
    fn triangles(&mut self, places: &[Place], coverage: &mut Coverage) {
        let (nodes, ids) = (&self.bvh.nodes, &self.bvh.triangle_ids);
        let reached = || (0..nodes.len()).filter(|&i| places[i].reached && nodes[i].is_leaf());
        // Rule Q8 lets no slot stand in more than a few leaves; beyond that it is garbage that would take long to walk.
        let claimed = reached().map(|leaf| nodes[leaf].count()).fold(0, usize::saturating_add);
        let slots = ids.len();
        let claims_fit = claimed <= 64 + slots.saturating_mul(8);
        if !claims_fit {
            self.report(Violation::SlotsClaimed { claimed, slots });
        }
        let mut sound = Vec::new();
        for leaf in reached() {
            let slots = nodes[leaf].range();
            if slots.is_empty() {
                coverage.empty_leaves += 1;
                if !places[leaf].filler {
                    self.report(Violation::EmptyLeaf(leaf));
                }
            } else if slots.end > ids.len() {
                self.report(Violation::SlotsOutOfBounds(leaf));
            } else {
                if slots.len() > self.limits.max_leaf {
                    self.report(Violation::TooManyTriangles {
                        leaf,
                        triangles: slots.len(),
                        max_leaf: self.limits.max_leaf,
                    });
                }
                sound.push(leaf);
            }
        }
        if claims_fit {
            coverage.references = claimed;
            let holders = self.holders(&sound, places, coverage);
            self.leaf_boxes(&sound, &holders);
            if self.limits.spatial {
                self.parts(&sound, &holders);
            }
        }
    }

    /// Checks that every triangle is held, and how often. Returns for every triangle how many leaves hold it.
    fn holders(&mut self, leaves: &[usize], places: &[Place], coverage: &mut Coverage) -> Vec<u32> {
        let mut held = vec![0u32; self.boxes.len()];
        let mut last_holder = vec![usize::MAX; self.boxes.len()];
        let mut visible = vec![false; self.boxes.len()];
        for &leaf in leaves {
            for &triangle in self.bvh.leaf_triangles(leaf) {
                let t = triangle as usize;
                if t >= self.boxes.len() {
                    self.report(Violation::UnknownTriangle { leaf, triangle });
                    continue;
                }
                let may_repeat = self.limits.q8 || self.limits.spatial;
                if held[t] > 0 && (!may_repeat || last_holder[t] == leaf) {
                    self.report(Violation::Repeated { leaf, triangle });
                }
                held[t] += u32::from(last_holder[t] != leaf);
                last_holder[t] = leaf;
                // Where parts are held, whether each is in its leaf is asked of them all together.
                visible[t] |= self.limits.spatial || places[leaf].seen_through.contains(&self.boxes[t]);
            }
        }
        for t in 0..self.boxes.len() {
            match held[t] {
                0 => self.report(Violation::Missing(t)),
                n => {
                    coverage.duplicated += usize::from(n > 1);
                    coverage.hidden += usize::from(!visible[t]);
                }
            }
        }
        held
    }

    fn leaf_boxes(&mut self, leaves: &[usize], held: &[u32]) {
        for &leaf in leaves {
            let ids = self.bvh.leaf_triangles(leaf);
            if ids.iter().any(|&t| t as usize >= held.len()) {
                continue;
            }
            let repeated = ids.iter().any(|&t| held[t as usize] > 1);
            let union = Aabb::union_of(ids.iter().map(|&t| &self.boxes[t as usize]));
            let aabb = &self.bvh.nodes[leaf].aabb;
            let tight = aabb == &union
                || (repeated && self.limits.q8)
                || (repeated && self.limits.spatial && !aabb.is_empty() && union.contains(aabb));
            if !tight {
                self.report(Violation::LooseBox(leaf));
            }
        }
    }

    /// Checks that the leaves with a triangle hold all of it.
    fn parts(&mut self, leaves: &[usize], held: &[u32]) {
        // Leaves by triangle: those of triangle t are `holders[starts[t] .. starts[t + 1]]`.
        let mut starts = vec![0usize; held.len() + 1];
        for (t, &n) in held.iter().enumerate() {
            starts[t + 1] = starts[t] + n as usize;
        }
        let mut next = starts.clone();
        let mut holders = vec![Aabb::EMPTY; starts[held.len()]];
        for &leaf in leaves {
            for &t in self.bvh.leaf_triangles(leaf) {
                // One that stands twice in a leaf is reported, and counted once.
                let Some(place) = next.get_mut(t as usize).filter(|at| **at < starts[t as usize + 1]) else { continue };
                holders[*place] = self.bvh.nodes[leaf].aabb;
                *place += 1;
            }
        }
        let (boxes, triangles) = (self.boxes, self.triangles);
        let uncovered: Vec<usize> = (0..held.len())
            .into_par_iter()
            .filter(|&t| {
                let holders = &holders[starts[t]..starts[t + 1]];
                let (whole, union) = (&boxes[t], Aabb::union_of(holders));
                // One that no leaf holds is reported as missing.
                let alone = holders.is_empty() || holders.iter().any(|leaf| leaf.contains(whole));
                !(alone || union.contains(whole) && triangles.is_none_or(|all| is_covered(&all[t], holders)))
            })
            .collect();
        uncovered.into_iter().for_each(|t| self.report(Violation::Uncovered(t)));
    }
}

/// The box of the points in both; one that contains nothing where a corner is NaN.
fn intersection(a: &Aabb, b: &Aabb) -> Aabb {
    if a.is_empty() || b.is_empty() {
        return Aabb::EMPTY;
    }
    Aabb::new(a.min.max(b.min), a.max.min(b.max))
}

#[cfg(test)]
mod tests;
