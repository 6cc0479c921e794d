//! Subtrees shared out between threads.

use super::grow::{Grower, Open, Part, SHARED, Tally};
use super::lanes::Survey;
use super::small::SMALL;
use crate::build::subtrees::grow_behind;
use crate::bvh::Node;
use crate::geom::Aabb;
use crate::simd::Simd;

/// A node that is to be divided, with its part of the references.
pub(super) struct Task<'a> {
    open: Open,
    part: Part<'a>,
}

impl Task<'_> {
    /// Its references.
    pub fn count(&self) -> usize {
        self.open.place.count
    }
}

/// Threads that grow a tree. The tree and the order of its nodes do not depend on how many they are.
pub(super) struct Team {
    simd: Simd,
    max_leaf: usize,
    bins: usize,
    threads: usize,
    /// What they grow with together.
    together: Grower,
    /// Work that each did apart.
    apart: Tally,
}

impl Team {
    pub fn new(simd: Simd, max_leaf: usize, bins: usize, threads: usize) -> Self {
        let together = Grower::new(simd, max_leaf, bins, threads);
        Self { simd, max_leaf, bins, threads, together, apart: Tally::default() }
    }

    /// The root over all references of `part`, which are in its first array, if it needs dividing.
    ///
    /// # Safety
    /// They have been written there.
    pub unsafe fn root<'a>(&mut self, mut part: Part<'a>, survey: &Survey, nodes: &mut Vec<Node>) -> Option<Task<'a>> {
        // SAFETY: the caller's.
        let open = unsafe { self.together.root(&mut part, survey, nodes)? };
        Some(Task { open, part })
    }

    /// Divides each node once. What is left to divide comes in the order of the nodes.
    pub fn divide<'a>(&mut self, tasks: Vec<Task<'a>>, nodes: &mut Vec<Node>) -> Vec<Task<'a>> {
        let largest = tasks.iter().map(Task::count).max().unwrap_or(0);
        let all: usize = tasks.iter().map(Task::count).sum();
        // Apart, threads need not count first how many references go where; but all wait for the largest node, which, if it is
        // worth sharing at all, is to be at most three fifths of a thread's share.
        if largest >= SHARED && 5 * largest * self.threads > 3 * all {
            let divide = |Task { open, mut part }| {
                let left = self.together.divide(open, &mut part, nodes);
                tasks_of(part, left)
            };
            return tasks.into_iter().flat_map(divide).collect();
        }
        // Two children, and whole subtrees below small ones.
        let room = |task: &Task| (2 * task.count() - 2).min(2 + 2 * (2 * SMALL - 2));
        self.each(tasks, nodes, room, |grower, Task { open, mut part }, block| {
            let left = grower.divide(open, &mut part, block);
            tasks_of(part, left)
        })
    }

    /// Grows everything below each node.
    pub fn finish(&mut self, tasks: Vec<Task>, nodes: &mut Vec<Node>) {
        let room = |task: &Task| 2 * task.count() - 2;
        self.each(tasks, nodes, room, |grower, Task { open, mut part }, block| {
            grower.grow(open, &mut part, block);
            Vec::new()
        });
    }

    /// Has one thread `work` on each, with nodes of its own, as many as there is `room` for, and puts these behind the others.
    fn each<'a>(
        &mut self,
        tasks: Vec<Task<'a>>,
        nodes: &mut Vec<Node>,
        room: impl Fn(&Task) -> usize + Sync + Send,
        work: impl Fn(&mut Grower, Task<'a>, &mut Vec<Node>) -> Vec<Task<'a>> + Sync,
    ) -> Vec<Task<'a>> {
        if self.threads == 1 {
            return tasks.into_iter().flat_map(|task| work(&mut self.together, task, nodes)).collect();
        }
        let worker = || Grower::new(self.simd, self.max_leaf, self.bins, 1);
        let work = |grower: &mut Grower, mut task: Task<'a>, block: &mut Vec<Node>| {
            let place = std::mem::replace(&mut task.open.place.node, 0);
            block.push(Node::leaf(Aabb::EMPTY, 0, 0));
            grower.tally = Tally::default();
            let left = work(grower, task, block);
            (place, (left, grower.tally))
        };
        let mut all_left = Vec::new();
        for (shift, (mut left, tally)) in grow_behind(nodes, tasks, room, worker, work) {
            left.iter_mut().for_each(|task| task.open.place.node += shift);
            all_left.append(&mut left);
            self.apart.add(&tally);
        }
        all_left
    }

    /// All the work done.
    pub fn tally(&self) -> Tally {
        let mut all = self.apart;
        all.add(&self.together.tally);
        all
    }
}

/// `nodes`, which are in rising order, each with its share of `part`.
fn tasks_of<'a>(part: Part<'a>, nodes: impl IntoIterator<Item = Open>) -> Vec<Task<'a>> {
    let Part { start: mut at, arrays: [mut first, mut second], mut ids } = part;
    let mut take = |open: Open| {
        let (start, count) = (open.place.start, open.place.count);
        let (one, more_first) = std::mem::take(&mut first)[start - at..].split_at_mut(count);
        let (two, more_second) = std::mem::take(&mut second)[start - at..].split_at_mut(count);
        let (slots, more_ids) = std::mem::take(&mut ids)[start - at..].split_at_mut(count);
        (first, second, ids, at) = (more_first, more_second, more_ids, start + count);
        Task { open, part: Part { start, arrays: [one, two], ids: slots } }
    };
    nodes.into_iter().map(&mut take).collect()
}
