//! What a builder starts from.

use crate::geom::{Aabb, Triangle};

/// Boxes of triangles, and the triangles where they are known.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// Bounding boxes, indexed by triangle id.
    pub boxes: &'a [Aabb],
    /// The triangles themselves, one per box. Only spatial splits look at them; without them they cut boxes.
    pub triangles: Option<&'a [Triangle]>,
}

impl<'a> Input<'a> {
    /// Boxes alone.
    pub const fn of_boxes(boxes: &'a [Aabb]) -> Self {
        Self { boxes, triangles: None }
    }

    /// Triangles with their boxes.
    ///
    /// # Panics
    /// Where there are not as many boxes as triangles.
    pub const fn of_triangles(triangles: &'a [Triangle], boxes: &'a [Aabb]) -> Self {
        assert!(triangles.len() == boxes.len());
        Self { boxes, triangles: Some(triangles) }
    }
}
