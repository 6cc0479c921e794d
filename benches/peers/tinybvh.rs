//! tinybvh: as the crate tinybvh-rs ships it, and by a shim on the header inside that crate, which has more builders.

use crate::subject::{Built, Prepared, Subject};
use crate::tree::{Opened, PeerTree};
use bvh_lab::geom::{Aabb, Ray, Triangle};
use bvh_lab::trace::{HitRecord, Query};
use std::ffi::{CStr, c_char, c_void};
use std::marker::PhantomData;
use tinybvh_rs::bvh::{BVH, Node};
use tinybvh_rs::{INFINITE, Intersector};

/// Below this many triangles tinybvh builds with one thread.
const THREADED_FROM: usize = 50_000;

unsafe extern "C" {
    fn bvh_lab_tinybvh_version() -> *const c_char;
    fn bvh_lab_tinybvh_build(vertices: *const f32, triangles: u32, preset: u32, threaded: bool) -> *mut c_void;
    fn bvh_lab_tinybvh_free(tree: *mut c_void);
    fn bvh_lab_tinybvh_nodes(tree: *const c_void, count: *mut u32) -> *const Node;
    fn bvh_lab_tinybvh_indices(tree: *const c_void, count: *mut u32) -> *const u32;
    fn bvh_lab_tinybvh_trace(tree: *const c_void, rays: *const f32, count: u32, hits: *mut u32);
    fn bvh_lab_tinybvh_occluded(tree: *const c_void, rays: *const f32, count: u32, hits: *mut u32);
}

/// A builder of the header; the discriminants are those of the shim.
#[derive(Clone, Copy, PartialEq)]
enum Preset {
    Reference,
    Avx,
    Sweep,
    Hq,
    AvxOptimized,
    AvxExtreme,
    SweepExtreme,
    SingleExtreme,
    HqExtreme,
    Wide,
    WideHq,
}

const PRESETS: [(Preset, &str); 11] = [
    (Preset::Reference, "Build"),
    (Preset::Avx, "BuildAVX"),
    (Preset::Sweep, "full sweep"),
    (Preset::Hq, "BuildHQ"),
    (Preset::AvxOptimized, "BuildAVX+Optimize"),
    (Preset::AvxExtreme, "BuildAVX+Optimize extreme"),
    (Preset::SweepExtreme, "full sweep+Optimize extreme"),
    (Preset::SingleExtreme, "BuildAVX+SplitLeafs+Optimize extreme"),
    (Preset::HqExtreme, "BuildHQ+Optimize extreme"),
    (Preset::Wide, "BVH8_CPU"),
    (Preset::WideHq, "BVH8_CPU HQ"),
];

struct Shim {
    preset: Preset,
    name: &'static str,
}

struct Shipped;

/// The crate's own call and the builders of its header.
pub fn subjects() -> Vec<Box<dyn Subject>> {
    let shim = PRESETS.map(|(preset, name)| Box::new(Shim { preset, name }) as Box<dyn Subject>);
    std::iter::once(Box::new(Shipped) as Box<dyn Subject>).chain(shim).collect()
}

/// Vertices of 16 bytes.
fn vertices(triangles: &[Triangle]) -> Vec<[f32; 4]> {
    triangles.iter().flat_map(|t| t.v.map(|p| [p.x, p.y, p.z, 0.0])).collect()
}

fn ours(node: &Node) -> Aabb {
    Aabb::new(node.min.into(), node.max.into())
}

fn convert(nodes: &[Node], ids: &[u32]) -> PeerTree {
    PeerTree::convert(0usize, |index| {
        let node = &nodes[index];
        let first = node.left_first as usize;
        if node.is_leaf() {
            Opened::Leaf(ours(node), ids[first..first + node.tri_count as usize].to_vec())
        } else {
            Opened::Inner(ours(node), first, first + 1)
        }
    })
}

fn threads_there_are() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

impl Subject for Shipped {
    fn library(&self) -> &'static str {
        "tinybvh-rs"
    }

    fn version(&self) -> String {
        crate::versions::of("tinybvh-rs")
    }

    fn preset(&self) -> String {
        "build".into()
    }

    /// Large scenes are always built with every thread of the machine.
    fn builds_with(&self, threads: usize) -> bool {
        threads == threads_there_are()
    }

    fn prepare<'a>(&'a self, triangles: &'a [Triangle], _threads: usize) -> Box<dyn Prepared + 'a> {
        Box::new(ShippedInput { vertices: vertices(triangles) })
    }
}

struct ShippedInput {
    vertices: Vec<[f32; 4]>,
}

impl Prepared for ShippedInput {
    fn build(&self) -> Result<Box<dyn Built + '_>, String> {
        let bvh = BVH::new(self.vertices.as_slice().into()).map_err(|e| format!("{e:?}"))?;
        Ok(Box::new(ShippedTree { bvh }))
    }
}

/// The crate gives its rays 16 bytes of alignment where the header counts on 64: its own constructor crashes.
#[repr(align(64))]
struct AlignedRay(tinybvh_rs::Ray);

impl AlignedRay {
    /// As the header makes a ray.
    fn new(ray: &Ray) -> Self {
        let hit = tinybvh_rs::Intersection { t: INFINITE, ..Default::default() };
        Self(tinybvh_rs::Ray {
            origin: ray.origin.to_array(),
            // The header's mask: meets every instance.
            padding_0: 0xffff,
            dir: ray.direction.to_array(),
            padding_1: 0,
            r_d: ray.direction.recip().to_array(),
            padding_2: 0,
            hit,
        })
    }
}

struct ShippedTree<'a> {
    bvh: BVH<'a>,
}

impl Built for ShippedTree<'_> {
    fn tree(&self) -> Option<PeerTree> {
        Some(convert(self.bvh.nodes(), self.bvh.indices()))
    }

    fn traversals(&self, query: Query) -> Vec<&'static str> {
        if query == Query::Closest { vec!["BVH"] } else { Vec::new() }
    }

    fn trace(&self, _query: Query, _traversal: usize, rays: &[Ray], hits: &mut [HitRecord]) {
        for (ray, record) in rays.iter().zip(hits) {
            let mut own = AlignedRay::new(ray);
            self.bvh.intersect(&mut own.0);
            let hit = own.0.hit;
            *record = if hit.t < INFINITE { HitRecord { triangle: hit.prim, t: hit.t } } else { HitRecord::MISS };
        }
    }
}

impl Subject for Shim {
    fn library(&self) -> &'static str {
        "tinybvh"
    }

    fn version(&self) -> String {
        // SAFETY: the shim returns a constant string.
        let text = unsafe { CStr::from_ptr(bvh_lab_tinybvh_version()) };
        text.to_string_lossy().into_owned()
    }

    fn preset(&self) -> String {
        self.name.into()
    }

    /// Its threads are one, or all there are.
    fn builds_with(&self, threads: usize) -> bool {
        threads == 1 || threads == threads_there_are()
    }

    fn spatial(&self) -> bool {
        matches!(self.preset, Preset::Hq | Preset::HqExtreme | Preset::WideHq)
    }

    fn prepare<'a>(&'a self, triangles: &'a [Triangle], threads: usize) -> Box<dyn Prepared + 'a> {
        // On a 16-byte boundary, which its vector loads want.
        let vertices = triangles.iter().flat_map(|t| t.v.map(|p| glam::Vec4::from((p, 0.0)))).collect();
        let threaded = threads > 1 && triangles.len() >= THREADED_FROM;
        Box::new(ShimInput { vertices, preset: self.preset, threaded })
    }
}

struct ShimInput {
    vertices: Vec<glam::Vec4>,
    preset: Preset,
    threaded: bool,
}

impl Prepared for ShimInput {
    fn build(&self) -> Result<Box<dyn Built + '_>, String> {
        let vertices: *const f32 = self.vertices.as_ptr().cast();
        let triangles = u32::try_from(self.vertices.len() / 3).map_err(|e| e.to_string())?;
        // SAFETY: three vertices of 16 bytes a triangle, aligned, borrowed by the tree that is returned.
        let tree = unsafe { bvh_lab_tinybvh_build(vertices, triangles, self.preset as u32, self.threaded) };
        let wide = matches!(self.preset, Preset::Wide | Preset::WideHq);
        Ok(Box::new(ShimTree { tree, wide, vertices: PhantomData }))
    }
}

struct ShimTree<'a> {
    tree: *mut c_void,
    wide: bool,
    vertices: PhantomData<&'a [glam::Vec4]>,
}

impl Drop for ShimTree<'_> {
    fn drop(&mut self) {
        // SAFETY: the tree came from the shim and is freed once.
        unsafe { bvh_lab_tinybvh_free(self.tree) }
    }
}

impl Built for ShimTree<'_> {
    /// The wide layout changes the leaves of its binary tree: that one is no builder's.
    fn tree(&self) -> Option<PeerTree> {
        if self.wide {
            return None;
        }
        let (mut nodes, mut ids) = (0, 0);
        // SAFETY: pointers and counts belong together and live as long as the tree.
        let (nodes, ids) = unsafe {
            let first_node = bvh_lab_tinybvh_nodes(self.tree, &mut nodes);
            let first_id = bvh_lab_tinybvh_indices(self.tree, &mut ids);
            (std::slice::from_raw_parts(first_node, nodes as usize), std::slice::from_raw_parts(first_id, ids as usize))
        };
        Some(convert(nodes, ids))
    }

    fn traversals(&self, _query: Query) -> Vec<&'static str> {
        vec![if self.wide { "BVH8_CPU" } else { "BVH" }]
    }

    fn trace(&self, query: Query, _traversal: usize, rays: &[Ray], hits: &mut [HitRecord]) {
        assert!(hits.len() >= rays.len());
        let rays: &[f32] = bytemuck::cast_slice(rays);
        // SAFETY: eight floats a ray and two words a record, checked above to be as many.
        unsafe {
            let (count, hits) = ((rays.len() / 8) as u32, hits.as_mut_ptr().cast());
            match query {
                Query::Closest => bvh_lab_tinybvh_trace(self.tree, rays.as_ptr(), count, hits),
                Query::Any => bvh_lab_tinybvh_occluded(self.tree, rays.as_ptr(), count, hits),
            }
        }
    }
}
