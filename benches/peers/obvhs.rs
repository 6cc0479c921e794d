//! The crate obvhs: PLOC with reinsertion, binary (`bvh2`) or as a compressed wide tree (`cwbvh`); all of its presets.

use crate::subject::{Built, Prepared, Subject};
use crate::tree::{Opened, PeerTree};
use bvh_lab::geom::{Aabb, Ray, Triangle};
use bvh_lab::trace::{HitRecord, Query};
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::RayHit;
use std::time::Duration;

/// Its presets, fastest build first.
const PRESETS: [(&str, BvhBuildParams); 6] = [
    ("fastest", BvhBuildParams::fastest_build()),
    ("very_fast", BvhBuildParams::very_fast_build()),
    ("fast", BvhBuildParams::fast_build()),
    ("medium", BvhBuildParams::medium_build()),
    ("slow", BvhBuildParams::slow_build()),
    ("very_slow", BvhBuildParams::very_slow_build()),
];

/// The presets that are measured in other forms, too.
const MORE: [&str; 3] = ["fastest", "medium", "very_slow"];

/// What becomes of the binary tree.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    /// As the preset has it.
    Binary,
    /// With the laboratory's leaf limit and cost of traversal in place of the preset's 8 and 3.
    Leaf4,
    /// Compressed, eight children a node.
    Wide,
}

struct Obvhs {
    preset: &'static str,
    parameters: BvhBuildParams,
    form: Form,
}

/// Every preset as it is, and some of them in other forms.
pub fn subjects() -> Vec<Box<dyn Subject>> {
    let mut all: Vec<Box<dyn Subject>> = Vec::new();
    for form in [Form::Binary, Form::Leaf4, Form::Wide] {
        for (preset, mut parameters) in PRESETS.into_iter().filter(|(p, _)| form == Form::Binary || MORE.contains(p)) {
            if form == Form::Leaf4 {
                (parameters.max_prims_per_leaf, parameters.collapse_traversal_cost) = (4, 1.0);
            }
            all.push(Box::new(Obvhs { preset, parameters, form }));
        }
    }
    all
}

fn ours(aabb: &obvhs::aabb::Aabb) -> Aabb {
    Aabb::new(aabb.min.into(), aabb.max.into())
}

impl Subject for Obvhs {
    fn library(&self) -> &'static str {
        "obvhs"
    }

    fn version(&self) -> String {
        crate::versions::of("obvhs")
    }

    fn preset(&self) -> String {
        match self.form {
            Form::Binary => self.preset.into(),
            Form::Leaf4 => format!("{} leaf4", self.preset),
            Form::Wide => format!("cwbvh {}", self.preset),
        }
    }

    fn builds_with(&self, threads: usize) -> bool {
        threads == 1 || cfg!(feature = "peers-parallel")
    }

    fn spatial(&self) -> bool {
        self.parameters.pre_split
    }

    fn prepare<'a>(&'a self, triangles: &'a [Triangle], _threads: usize) -> Box<dyn Prepared + 'a> {
        let own = |t: &Triangle| obvhs::triangle::Triangle { v0: t.v[0].into(), v1: t.v[1].into(), v2: t.v[2].into() };
        Box::new(Input { subject: self, triangles: triangles.iter().map(own).collect() })
    }
}

struct Input<'a> {
    subject: &'a Obvhs,
    triangles: Vec<obvhs::triangle::Triangle>,
}

impl Prepared for Input<'_> {
    fn build(&self) -> Result<Box<dyn Built + '_>, String> {
        let (parameters, triangles) = (self.subject.parameters, self.triangles.as_slice());
        let mut core = Duration::ZERO;
        Ok(if self.subject.form == Form::Wide {
            Box::new(Wide { bvh: build_cwbvh_from_tris(triangles, parameters, &mut core), triangles })
        } else {
            Box::new(Binary { bvh: build_bvh2_from_tris(triangles, parameters, &mut core), triangles })
        })
    }
}

struct Binary<'a> {
    bvh: Bvh2,
    triangles: &'a [obvhs::triangle::Triangle],
}

struct Wide<'a> {
    bvh: CwBvh,
    triangles: &'a [obvhs::triangle::Triangle],
}

fn own_ray(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(ray.origin.into(), ray.direction.into(), ray.t_min, ray.t_max)
}

impl Built for Binary<'_> {
    fn tree(&self) -> Option<PeerTree> {
        let ids = &self.bvh.primitive_indices;
        Some(PeerTree::convert(0usize, |index| {
            let node = &self.bvh.nodes[index];
            let (first, aabb) = (node.first_index as usize, ours(node.aabb()));
            if node.is_leaf() {
                Opened::Leaf(aabb, ids[first..first + node.prim_count as usize].to_vec())
            } else {
                Opened::Inner(aabb, first, first + 1)
            }
        }))
    }

    fn traversals(&self, query: Query) -> Vec<&'static str> {
        if query == Query::Closest { vec!["bvh2"] } else { Vec::new() }
    }

    fn trace(&self, _query: Query, _traversal: usize, rays: &[Ray], hits: &mut [HitRecord]) {
        let ids = &self.bvh.primitive_indices;
        for (ray, record) in rays.iter().zip(hits) {
            let mut hit = RayHit::none();
            let found = self
                .bvh
                .ray_traverse(own_ray(ray), &mut hit, |ray, slot| self.triangles[ids[slot] as usize].intersect(ray));
            *record =
                if found { HitRecord { triangle: ids[hit.primitive_id as usize], t: hit.t } } else { HitRecord::MISS };
        }
    }
}

impl Built for Wide<'_> {
    fn tree(&self) -> Option<PeerTree> {
        None
    }

    fn traversals(&self, query: Query) -> Vec<&'static str> {
        if query == Query::Closest { vec!["cwbvh"] } else { Vec::new() }
    }

    fn trace(&self, _query: Query, _traversal: usize, rays: &[Ray], hits: &mut [HitRecord]) {
        let ids = &self.bvh.primitive_indices;
        for (ray, record) in rays.iter().zip(hits) {
            let mut hit = RayHit::none();
            let found = self
                .bvh
                .ray_traverse(own_ray(ray), &mut hit, |ray, slot| self.triangles[ids[slot] as usize].intersect(ray));
            *record =
                if found { HitRecord { triangle: ids[hit.primitive_id as usize], t: hit.t } } else { HitRecord::MISS };
        }
    }
}
