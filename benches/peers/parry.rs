//! The crate parry3d: its two builders, binned and PLOC, a triangle a leaf, and its best-first ray cast.

use crate::subject::{Built, Prepared, Subject};
use crate::tree::{Opened, PeerTree};
use bvh_lab::geom::{Aabb, Ray, Triangle};
use bvh_lab::trace::{HitRecord, Query};
use parry3d::bounding_volume::Aabb as OwnAabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhNodeIndex, TraversalAction};
use parry3d::query::RayCast;
use parry3d::shape::Triangle as OwnTriangle;

struct Parry {
    preset: &'static str,
    strategy: BvhBuildStrategy,
}

/// Its strategies.
pub fn subjects() -> Vec<Box<dyn Subject>> {
    let all = [("binned", BvhBuildStrategy::Binned), ("ploc", BvhBuildStrategy::Ploc)];
    all.map(|(preset, strategy)| Box::new(Parry { preset, strategy }) as Box<dyn Subject>).into()
}

impl Subject for Parry {
    fn library(&self) -> &'static str {
        "parry3d"
    }

    fn version(&self) -> String {
        crate::versions::of("parry3d")
    }

    fn preset(&self) -> String {
        self.preset.into()
    }

    fn prepare<'a>(&'a self, triangles: &'a [Triangle], _threads: usize) -> Box<dyn Prepared + 'a> {
        let own = |t: &Triangle| OwnTriangle::new(vector(t.v[0]), vector(t.v[1]), vector(t.v[2]));
        Box::new(Input { strategy: self.strategy, triangles: triangles.iter().map(own).collect() })
    }
}

fn vector(p: glam::Vec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

struct Input {
    strategy: BvhBuildStrategy,
    triangles: Vec<OwnTriangle>,
}

impl Prepared for Input {
    fn build(&self) -> Result<Box<dyn Built + '_>, String> {
        let boxes = self.triangles.iter().map(OwnTriangle::local_aabb).enumerate();
        Ok(Box::new(Tree { bvh: Bvh::from_iter(self.strategy, boxes), triangles: &self.triangles }))
    }
}

struct Tree<'a> {
    bvh: Bvh,
    triangles: &'a [OwnTriangle],
}

fn ours(aabb: &OwnAabb) -> Aabb {
    Aabb::new(aabb.mins.to_array().into(), aabb.maxs.to_array().into())
}

impl Tree<'_> {
    /// The two nodes below `index`, or below the root that no node stands for. Only a walk shows them: it is stopped after
    /// the first two.
    fn children(&self, index: Option<BvhNodeIndex>) -> Vec<BvhNodeIndex> {
        let mut met = Vec::with_capacity(2);
        self.bvh.traverse_indexed(index, |_, at| {
            if Some(at) == index {
                return TraversalAction::Continue;
            }
            met.push(at);
            if met.len() < 2 { TraversalAction::Prune } else { TraversalAction::EarlyExit }
        });
        met
    }

    fn open(&self, index: BvhNodeIndex) -> Opened<Option<BvhNodeIndex>> {
        let mut found = None;
        self.bvh.traverse_indexed(Some(index), |node, _| {
            found = Some((ours(&node.aabb()), node.leaf_data()));
            TraversalAction::EarlyExit
        });
        match found.expect("a walk from a node meets it first") {
            (aabb, Some(triangle)) => Opened::Leaf(aabb, vec![triangle]),
            (aabb, None) => {
                let children = self.children(Some(index));
                Opened::Inner(aabb, Some(children[0]), Some(children[1]))
            }
        }
    }
}

impl Built for Tree<'_> {
    fn tree(&self) -> Option<PeerTree> {
        let root = self.children(None);
        Some(match root[..] {
            [only] => PeerTree::convert(Some(only), |index| self.open(index.unwrap_or(only))),
            _ => PeerTree::convert(None, |index| match index {
                Some(index) => self.open(index),
                None => Opened::Inner(ours(&self.bvh.root_aabb()), Some(root[0]), Some(root[1])),
            }),
        })
    }

    fn traversals(&self, query: Query) -> Vec<&'static str> {
        if query == Query::Closest { vec!["cast_ray"] } else { Vec::new() }
    }

    fn trace(&self, _query: Query, _traversal: usize, rays: &[Ray], hits: &mut [HitRecord]) {
        for (ray, record) in rays.iter().zip(hits) {
            let own = parry3d::query::Ray::new(vector(ray.origin), vector(ray.direction));
            let hit = self.bvh.cast_ray(&own, ray.t_max, |triangle, best| {
                self.triangles[triangle as usize].cast_local_ray(&own, best, false)
            });
            *record = hit.map_or(HitRecord::MISS, |(triangle, t)| HitRecord { triangle, t });
        }
    }
}
