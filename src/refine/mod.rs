//! Refinement: from a tree to a tree.
