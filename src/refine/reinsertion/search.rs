//! The search for the place where a subtree costs least, by branch and bound.

use crate::refine::dynamic::{Dynamic, NONE, ROOT, Wide};

/// So many nodes are looked at, then a search ends with what it has. Twenty are usual; among long subtrees that all overlap
/// it is some hundred, and in a tree as deep as it has nodes there would be no end.
const MOST_VISITS: u32 = 1000;

/// The best place found for a subtree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// The subtree's slot.
    pub from: u32,
    /// The slot beside which it would stand; [`NONE`] where no place is better than what was asked for.
    pub to: u32,
    /// By how much the half areas of the inner nodes would fall.
    pub gain: f32,
    /// Nodes looked at.
    pub visits: u32,
}

/// A search under way.
struct Search<'a> {
    tree: &'a Dynamic<'a>,
    own: Wide,
    own_area: f32,
    best: Found,
    /// Pairs of nodes still to be looked at, each with what is saved if the subtree comes somewhere below their parent:
    /// what its removal saves without what it adds to the boxes on the way there.
    stack: &'a mut Vec<(u32, f32)>,
}

/// Searches for the place that makes the half areas of the inner nodes fall most if the subtree at `from`, not the root, is
/// taken out and put in there, and by more than `least`. `stack` is scratch.
///
/// From the old place upwards: at each ancestor, the subtree of the child that was not seen yet, then the ancestor's own
/// place. Of equal gains the first is taken.
pub(super) fn search(tree: &Dynamic, from: u32, least: f32, stack: &mut Vec<(u32, f32)>) -> Found {
    let node = tree.at(from);
    let (own, sibling) = (node.wide(), tree.at(from ^ 1));
    let best = Found { from, to: NONE, gain: least, visits: 1 };
    let mut search = Search { tree, own, own_area: own.half_area(), best, stack };
    // What is left below the pivot when the subtree is gone. Its parent is gone as well.
    let mut pivot = node.parent;
    let mut rest = sibling.wide();
    let mut whole = tree.at(pivot).wide();
    let mut saved = whole.half_area();
    if let Some(pair) = sibling.pair() {
        search.below(pair, rest.half_area());
    }
    // Where nothing got smaller, no ancestor does, and the savings are final.
    while pivot != ROOT && search.best.visits <= MOST_VISITS && (rest != whole || search.hopes(saved)) {
        if let (Some(pair), left) = search.look(pivot ^ 1, saved) {
            search.below(pair, left);
        }
        search.best.visits += 1;
        rest = rest.union(&tree.at(pivot ^ 1).wide());
        pivot = tree.at(pivot).parent;
        whole = tree.at(pivot).wide();
        // Beside all the rest, the new parent is as large as the pivot was.
        search.offer(pivot, saved - rest.half_area());
        saved += whole.half_area() - rest.half_area();
    }
    search.best
}

impl Search<'_> {
    /// Takes the place if it gains more than the best so far.
    #[inline(always)]
    fn offer(&mut self, to: u32, gain: f32) {
        if gain > self.best.gain {
            (self.best.to, self.best.gain) = (to, gain);
        }
    }

    /// Whether any place with such savings can be better than the best: the new parent is never smaller than the subtree.
    #[inline(always)]
    fn hopes(&self, saved: f32) -> bool {
        saved - self.own_area > self.best.gain
    }

    /// Looks at the place beside `slot`. Its children, if it has any, and what is saved below it.
    #[inline(always)]
    fn look(&mut self, slot: u32, saved: f32) -> (Option<u32>, f32) {
        let here = self.tree.at(slot);
        let wide = here.wide();
        let joined = wide.union(&self.own).half_area();
        self.offer(slot, saved - joined);
        (here.pair(), saved - (joined - wide.half_area()))
    }

    /// Looks at a pair and all that stands below it as far as there is hope, the nearer of two first.
    #[inline(always)]
    fn below(&mut self, pair: u32, saved: f32) {
        self.stack.push((pair, saved));
        while let Some((pair, saved)) = self.stack.pop() {
            if !self.hopes(saved) {
                continue;
            }
            self.best.visits += 2;
            let mut far = self.look(pair, saved);
            let mut near = self.look(pair + 1, saved);
            if near.1 < far.1 {
                std::mem::swap(&mut near, &mut far);
            }
            for (pair, saved) in [far, near] {
                if let Some(pair) = pair
                    && self.hopes(saved)
                {
                    self.stack.push((pair, saved));
                }
            }
            if self.best.visits > MOST_VISITS {
                self.stack.clear();
            }
        }
    }
}
