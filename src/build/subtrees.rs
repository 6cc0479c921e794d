//! Subtrees that threads grow on their own, put together.

use crate::bvh::Node;
use rayon::prelude::*;
use std::mem::MaybeUninit;
use std::sync::{Mutex, PoisonError};

/// Grows a subtree for each of `tasks`, of which one thread grows one at a time, and puts it into its place and behind the
/// last node, in the order of the tasks. Each has at most as many nodes as `room` says, not counting the root.
///
/// `grow` writes its subtree from the root on, counted from 0, but with slots of the whole tree, into an empty vector, and
/// returns the place of the root and whatever else is to be known. That comes back, and with it by how much the places of
/// that subtree's nodes are further behind now, the root's apart.
///
/// A subtree is moved as soon as those before it are grown, most often while it still is in the cache of its thread: a tree
/// is large, and a fast builder would feel it if all of it went to memory twice.
pub(super) fn grow_behind<T: Send, S, R: Send>(
    nodes: &mut Vec<Node>,
    tasks: Vec<T>,
    room: impl Fn(&T) -> usize + Sync + Send,
    state: impl Fn() -> S + Sync + Send,
    grow: impl Fn(&mut S, T, &mut Vec<Node>) -> (usize, R) + Sync + Send,
) -> Vec<(usize, R)> {
    let all = tasks.iter().map(&room).sum();
    nodes.reserve(all);
    let first = nodes.len();
    let count = tasks.len();
    let queue = Queue {
        rest: &mut nodes.spare_capacity_mut()[..all],
        shift: first - 1,
        next: 0,
        waiting: (0..count).map(|_| None).collect(),
        spare: Vec::new(),
        roots: Vec::with_capacity(count),
    };
    let queue = Mutex::new(queue);
    let lock = || queue.lock().unwrap_or_else(PoisonError::into_inner);
    let run = |(state, spare): &mut (S, Option<Vec<Node>>), (index, task): (usize, T)| {
        // The one last moved is still in this thread's cache.
        let mut block = spare.take().or_else(|| lock().spare.pop()).unwrap_or_default();
        block.reserve_exact(1 + room(&task));
        let (place, result) = grow(state, task, &mut block);
        let ready = lock().put(index, place, block);
        for (mut block, to, shift) in ready {
            to.iter_mut().zip(&block[1..]).for_each(|(to, node)| {
                to.write(moved(node, shift));
            });
            block.clear();
            if let Some(more) = spare.replace(block) {
                lock().spare.push(more);
            }
        }
        (index, result)
    };
    // In their order, so that few have to wait for those before them.
    let tasks = tasks.into_iter().enumerate().par_bridge();
    let mut results: Vec<_> = tasks.map_init(|| (state(), None), run).collect();
    results.sort_unstable_by_key(|(index, _)| *index);
    let Queue { rest, roots, .. } = queue.into_inner().unwrap_or_else(PoisonError::into_inner);
    let more = all - rest.len();
    assert_eq!(roots.len(), count, "all subtrees are grown");
    // SAFETY: all that `put` has given out were written.
    unsafe { nodes.set_len(first + more) };
    let results = results.into_iter().zip(&roots).map(|((_, result), (.., shift))| (*shift, result)).collect();
    for (place, root, shift) in roots {
        nodes[place] = moved(&root, shift);
    }
    results
}

/// Subtrees on their way to their places.
struct Queue<'a> {
    /// Room behind those that have their places.
    rest: &'a mut [MaybeUninit<Node>],
    /// By how much nodes of the next one move, its root apart.
    shift: usize,
    /// The next one.
    next: usize,
    /// Those that were grown before the next one: the place of the root, and the nodes.
    waiting: Vec<Option<(usize, Vec<Node>)>>,
    /// Empty ones, to be filled again.
    spare: Vec<Vec<Node>>,
    /// Where each root belongs to, and the shift of its children.
    roots: Vec<(usize, Node, usize)>,
}

/// A subtree, where its nodes go to but for the root, and by how much they move.
type Ready<'a> = (Vec<Node>, &'a mut [MaybeUninit<Node>], usize);

impl<'a> Queue<'a> {
    /// Takes a subtree. Returns those that can be moved now.
    fn put(&mut self, index: usize, place: usize, block: Vec<Node>) -> Vec<Ready<'a>> {
        self.waiting[index] = Some((place, block));
        let mut ready = Vec::new();
        while let Some((place, block)) = self.waiting.get_mut(self.next).and_then(Option::take) {
            let to = self.rest.split_off_mut(..block.len() - 1).expect("no more nodes than there is room for");
            self.roots.push((place, block[0], self.shift));
            ready.push((block, to, self.shift));
            self.shift += ready.last().map_or(0, |(_, to, _)| to.len());
            self.next += 1;
        }
        ready
    }
}

/// The node, with children so much further behind.
fn moved(node: &Node, shift: usize) -> Node {
    if node.is_leaf() { *node } else { Node::inner(node.aabb, node.range().start + shift, node.count()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;

    fn put(nodes: &mut Vec<Node>, subtrees: &[(usize, &[Node])]) -> Vec<usize> {
        let room = |(_, subtree): &(usize, &[Node])| subtree.len() - 1;
        let grow = |_: &mut (), (place, subtree): (usize, &[Node]), block: &mut Vec<Node>| {
            assert!(block.is_empty());
            block.extend_from_slice(subtree);
            (place, place)
        };
        let results = grow_behind(nodes, subtrees.to_vec(), room, || (), grow);
        assert!(results.iter().zip(subtrees).all(|((_, place), (wanted, _))| place == wanted));
        results.into_iter().map(|(shift, _)| shift).collect()
    }

    #[test]
    fn subtrees_follow_one_another_and_keep_their_children() {
        let leaf = |slot| Node::leaf(Aabb::EMPTY, slot, 1);
        let mut nodes = vec![Node::inner(Aabb::EMPTY, 1, 2), leaf(9), leaf(9)];
        let deep = [Node::inner(Aabb::EMPTY, 1, 2), leaf(0), Node::inner(Aabb::EMPTY, 3, 2), leaf(1), leaf(2)];
        let flat = [Node::inner(Aabb::EMPTY, 1, 2), leaf(3), leaf(4)];
        assert_eq!(put(&mut nodes, &[(2, &deep), (1, &flat)]), [2, 6]);
        let shape: Vec<_> = nodes.iter().map(|n| (n.is_leaf(), n.range().start)).collect();
        let inner = |at| (false, at);
        let slot = |at| (true, at);
        let wanted = [inner(1), inner(7), inner(3), slot(0), inner(5), slot(1), slot(2), slot(3), slot(4)];
        assert_eq!(shape, wanted);
        assert!(put(&mut nodes, &[]).is_empty());
        assert_eq!(nodes.len(), 9);
        assert_eq!(put(&mut nodes, &[(8, &[leaf(7)])]), [8]);
        assert_eq!((nodes.len(), nodes[8].range().start), (9, 7));
    }

    #[test]
    fn the_order_is_that_of_the_tasks_however_long_each_takes() {
        let leaf = |slot| Node::leaf(Aabb::EMPTY, slot, 1);
        // A subtree over as many leaves as its number says, in a list.
        let subtree = |first: usize, leaves: usize| {
            let inner = (0..leaves - 1).flat_map(|i| [Node::inner(Aabb::EMPTY, 2 * i + 1, 2), leaf(first + i)]);
            let mut nodes: Vec<_> = inner.collect();
            nodes.push(leaf(first + leaves - 1));
            // The root, then pairs of a leaf and what is left.
            nodes
        };
        let sizes: Vec<usize> = (0..200).map(|i| 1 + i * 7919 % 97).collect();
        let run = |threads, slow: fn(usize) -> u64| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut nodes = vec![leaf(0); sizes.len() + 1];
            let tasks: Vec<usize> = (0..sizes.len()).collect();
            let results = pool.install(|| {
                grow_behind(
                    &mut nodes,
                    tasks,
                    |&i| 2 * sizes[i],
                    || (),
                    |(), i, block| {
                        std::thread::sleep(std::time::Duration::from_micros(slow(i)));
                        block.extend(subtree(i, sizes[i]));
                        (i + 1, i)
                    },
                )
            });
            (results, nodes.iter().map(|n| (n.is_leaf(), n.range())).collect::<Vec<_>>())
        };
        let expected = run(1, |_| 0);
        assert_eq!(expected.1.len(), 1 + sizes.iter().map(|n| 2 * n - 1).sum::<usize>());
        for (threads, slow) in [(2, (|i| 100 * (i as u64 % 3)) as fn(usize) -> u64), (7, |i| 5 * (200 - i as u64))] {
            assert!(run(threads, slow) == expected, "{threads}");
        }
    }
}
