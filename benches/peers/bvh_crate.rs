//! The crate bvh (svenstaro): its binned SAH builder, a triangle a leaf, and its nearest-child traversal.

use crate::subject::{Built, Prepared, Subject};
use crate::tree::{Opened, PeerTree};
use bvh_crate::aabb::{Aabb as OwnAabb, Bounded};
use bvh_crate::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh_crate::bvh::{Bvh, BvhNode};
use bvh_lab::geom::{Aabb, Ray, Triangle};
use bvh_lab::trace::{HitRecord, Query};
use nalgebra::{Point3, Vector3};

struct SvenstaroBvh;

/// Its one builder.
pub fn subjects() -> Vec<Box<dyn Subject>> {
    vec![Box::new(SvenstaroBvh)]
}

/// A triangle with the box that the builder asks for again and again.
struct Shape {
    aabb: OwnAabb<f32, 3>,
    triangle: u32,
    node: usize,
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> OwnAabb<f32, 3> {
        self.aabb
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl Subject for SvenstaroBvh {
    fn library(&self) -> &'static str {
        "bvh"
    }

    fn version(&self) -> String {
        crate::versions::of("bvh")
    }

    fn preset(&self) -> String {
        "sah".into()
    }

    fn builds_with(&self, _threads: usize) -> bool {
        true
    }

    fn prepare<'a>(&'a self, triangles: &'a [Triangle], threads: usize) -> Box<dyn Prepared + 'a> {
        Box::new(Input { triangles, threads })
    }
}

struct Input<'a> {
    triangles: &'a [Triangle],
    threads: usize,
}

impl Prepared for Input<'_> {
    fn build(&self) -> Result<Box<dyn Built + '_>, String> {
        let point = |p: glam::Vec3| Point3::new(p.x, p.y, p.z);
        let shape = |(triangle, t): (usize, &Triangle)| {
            let aabb = t.aabb();
            let aabb = OwnAabb::with_bounds(point(aabb.min), point(aabb.max));
            Shape { aabb, triangle: triangle as u32, node: 0 }
        };
        let mut shapes: Vec<_> = self.triangles.iter().enumerate().map(shape).collect();
        let bvh = if self.threads == 1 { Bvh::build(&mut shapes) } else { Bvh::build_par(&mut shapes) };
        Ok(Box::new(Tree { bvh, shapes, triangles: self.triangles }))
    }
}

struct Tree<'a> {
    bvh: Bvh<f32, 3>,
    shapes: Vec<Shape>,
    triangles: &'a [Triangle],
}

fn ours(aabb: &OwnAabb<f32, 3>) -> Aabb {
    Aabb::new(glam::Vec3::new(aabb.min.x, aabb.min.y, aabb.min.z), glam::Vec3::new(aabb.max.x, aabb.max.y, aabb.max.z))
}

impl Built for Tree<'_> {
    fn tree(&self) -> Option<PeerTree> {
        // Boxes stand with the parent; the root's is never stored.
        let root = match self.bvh.nodes[0] {
            BvhNode::Leaf { shape_index, .. } => ours(&self.shapes[shape_index].aabb),
            BvhNode::Node { child_l_aabb, child_r_aabb, .. } => ours(&child_l_aabb).union(&ours(&child_r_aabb)),
        };
        Some(PeerTree::convert((0usize, root), |(index, aabb)| match self.bvh.nodes[index] {
            BvhNode::Leaf { shape_index, .. } => Opened::Leaf(aabb, vec![self.shapes[shape_index].triangle]),
            BvhNode::Node { child_l_index, child_l_aabb, child_r_index, child_r_aabb, .. } => {
                Opened::Inner(aabb, (child_l_index, ours(&child_l_aabb)), (child_r_index, ours(&child_r_aabb)))
            }
        }))
    }

    fn traversals(&self, query: Query) -> Vec<&'static str> {
        if query == Query::Closest { vec!["nearest_child_traverse_iterator"] } else { Vec::new() }
    }

    /// The library's iterator brings leaves roughly front to back and knows nothing of hits, so all that the ray's line
    /// meets are tested. Its own triangle test passes through triangles seen from behind: the laboratory's is used.
    fn trace(&self, _query: Query, _traversal: usize, rays: &[Ray], hits: &mut [HitRecord]) {
        for (ray, record) in rays.iter().zip(hits) {
            let origin = Point3::new(ray.origin.x, ray.origin.y, ray.origin.z);
            let direction = Vector3::new(ray.direction.x, ray.direction.y, ray.direction.z);
            let own = bvh_crate::ray::Ray::new(origin, direction);
            let mut limited = *ray;
            let mut best = HitRecord::MISS;
            for shape in self.bvh.nearest_child_traverse_iterator(&own, &self.shapes) {
                if let Some(t) = self.triangles[shape.triangle as usize].intersect(&limited)
                    && t < best.t
                {
                    best = HitRecord { triangle: shape.triangle, t };
                    limited.t_max = t;
                }
            }
            *record = best;
        }
    }
}
