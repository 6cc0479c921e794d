//! What a step tells of its work while it works, and whether it is to go on.

/// Counts of a step's work, and a question to whoever waits for it.
pub struct Watch<'a> {
    /// Searches for a better place of a subtree.
    pub searches: u64,
    /// Nodes that they looked at.
    pub visits: u64,
    /// Changes of the tree that were kept: reinsertions and rotations.
    pub moves: u64,
    /// Nodes looked at, of any kind, since it was asked last.
    steps: u64,
    go_on: &'a mut dyn FnMut(u64) -> bool,
    stopped: bool,
}

impl<'a> Watch<'a> {
    /// `go_on` is told of the nodes looked at since it was called last; where it says `false` the step is to end with the tree
    /// as it is.
    pub fn new(go_on: &'a mut dyn FnMut(u64) -> bool) -> Self {
        Self { searches: 0, visits: 0, moves: 0, steps: 0, go_on, stopped: false }
    }

    /// Whether a step was told to end.
    pub fn stopped(&self) -> bool {
        self.stopped
    }

    /// A search looked at so many nodes.
    #[inline]
    pub(super) fn searched(&mut self, visits: u32) {
        self.searches += 1;
        self.visits += u64::from(visits);
        self.steps += u64::from(visits);
    }

    /// So many nodes were looked at in no search.
    #[inline]
    pub(super) fn stepped(&mut self, nodes: u64) {
        self.steps += nodes;
    }

    /// Whether to go on. Once it is not, it never is.
    pub(super) fn go_on(&mut self) -> bool {
        self.stopped |= !(self.go_on)(std::mem::take(&mut self.steps));
        !self.stopped
    }
}
