//! What a finished tree is worth and looks like: walks the tree, never changes it.
