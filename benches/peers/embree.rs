//! Embree 3, where its library is installed: opened when the benchmark runs, so that nothing needs it to compile.
//!
//! Two views of it: scenes, as users build and trace them, whose trees nobody sees (`scene …`); and its open builder with
//! binary nodes and the laboratory's leaf limit, whose trees can be scored (`rtcBuildBVH …`).

mod ffi;

use crate::subject::{Built, Prepared, Subject};
use crate::tree::{Opened, PeerTree};
use bvh_lab::geom::{Aabb, Ray, Triangle};
use bvh_lab::trace::{HitRecord, Query};
use ffi::{Api, BuildArguments, BuildPrimitive, Device, Hit, IntersectContext, Quality, RayHit};
use std::ffi::{c_uint, c_void};
use std::ptr::null_mut;
use std::sync::Arc;

/// The leaf limit of the trees that are scored.
const MAX_LEAF: u32 = 4;
/// Room for spatial splits, in references a triangle; Embree's own scenes have about as much.
const ROOM: f64 = 2.0;

const QUALITIES: [(Quality, &str); 3] = [(Quality::Low, "low"), (Quality::Medium, "medium"), (Quality::High, "high")];

/// Whether a scene or a tree is built.
#[derive(Clone, Copy, PartialEq)]
enum View {
    Scene,
    Tree,
}

struct Embree {
    api: Arc<Api>,
    quality: Quality,
    name: &'static str,
    view: View,
}

/// Both views at every quality.
///
/// # Errors
/// One line that says what to install where there is no such library.
pub fn subjects() -> Result<Vec<Box<dyn Subject>>, String> {
    let api = Arc::new(Api::open()?);
    let each = |view: View| {
        let api = &api;
        QUALITIES.map(|(quality, name)| Box::new(Embree { api: api.clone(), quality, name, view }) as Box<dyn Subject>)
    };
    Ok(each(View::Scene).into_iter().chain(each(View::Tree)).collect())
}

impl Subject for Embree {
    fn library(&self) -> &'static str {
        "embree"
    }

    fn version(&self) -> String {
        self.api.version()
    }

    fn preset(&self) -> String {
        let what = if self.view == View::Scene { "scene" } else { "rtcBuildBVH" };
        format!("{what} {}", self.name)
    }

    fn builds_with(&self, _threads: usize) -> bool {
        true
    }

    fn spatial(&self) -> bool {
        self.quality == Quality::High
    }

    fn traced(&self) -> bool {
        self.view == View::Scene
    }

    fn prepare<'a>(&'a self, triangles: &'a [Triangle], threads: usize) -> Box<dyn Prepared + 'a> {
        let device = self.api.device(threads);
        // Embree reads 16 bytes at every vertex, the last one too.
        let vertices = triangles.iter().flat_map(|t| t.v).chain([glam::Vec3::ZERO]).collect();
        Box::new(Input { subject: self, triangles, vertices, device })
    }
}

struct Input<'a> {
    subject: &'a Embree,
    triangles: &'a [Triangle],
    /// Three a triangle, and one more.
    vertices: Vec<glam::Vec3>,
    device: Device<'a>,
}

impl Prepared for Input<'_> {
    fn build(&self) -> Result<Box<dyn Built + '_>, String> {
        Ok(match self.subject.view {
            View::Scene => Box::new(self.scene()?),
            View::Tree => Box::new(self.binary()?),
        })
    }
}

impl Input<'_> {
    /// A scene of one mesh. Its vertices are shared, not copied: 36 bytes a triangle, three indices counting up.
    fn scene(&self) -> Result<Scene<'_>, String> {
        let api = &self.subject.api;
        let indices: Vec<u32> = (0..3 * self.triangles.len() as u32).collect();
        let scene = Scene { api, scene: api.scene(&self.device), indices };
        // SAFETY: the scene borrows the vertices, which are one more than the indices name, and owns the indices.
        unsafe { api.commit(&self.device, scene.scene, self.subject.quality, &self.vertices, &scene.indices) }?;
        Ok(scene)
    }

    fn binary(&self) -> Result<Tree<'_>, String> {
        let api = &self.subject.api;
        let spatial = self.subject.spatial();
        let capacity = if spatial { (self.triangles.len() as f64 * ROOM) as usize } else { self.triangles.len() };
        let mut primitives = Vec::with_capacity(capacity);
        primitives.extend(self.triangles.iter().enumerate().map(|(id, t)| {
            let aabb = t.aabb();
            BuildPrimitive { lower: aabb.min, geometry: 0, upper: aabb.max, id: id as u32 }
        }));
        let user = User { api, triangles: self.triangles };
        let bvh = api.bvh(&self.device);
        let mut tree = Tree { api, bvh, root: null_mut() };
        let arguments = BuildArguments {
            byte_size: size_of::<BuildArguments>(),
            quality: self.subject.quality,
            flags: 0,
            max_branching: 2,
            // Deep enough for every scene here; beyond it Embree gives up on quality.
            max_depth: 1024,
            block_size: 1,
            min_leaf: 1,
            max_leaf: MAX_LEAF,
            traversal_cost: 1.0,
            intersection_cost: 1.0,
            bvh,
            primitives: primitives.as_mut_ptr(),
            count: primitives.len(),
            capacity,
            create_node: Some(create_node),
            set_children: Some(set_children),
            set_bounds: Some(set_bounds),
            create_leaf: Some(create_leaf),
            split: if spatial { Some(split) } else { None },
            progress: None,
            user: (&raw const user).cast_mut().cast(),
        };
        // SAFETY: all that the arguments point at lives until the call returns; the callbacks keep to their contracts.
        tree.root = unsafe { (api.build_bvh)(&arguments) }.cast();
        if tree.root.is_null() { Err(api.error(&self.device)) } else { Ok(tree) }
    }
}

/// What the callbacks are told.
struct User<'a> {
    api: &'a Api,
    triangles: &'a [Triangle],
}

/// A node of the binary tree, in Embree's own memory: an inner node, or a leaf with its triangles behind it.
#[repr(C)]
struct TreeNode {
    /// Triangles of a leaf; 0 for an inner node.
    count: u32,
    /// The boxes of both children, or the leaf's in the first place.
    boxes: [Aabb; 2],
    children: [*mut TreeNode; 2],
}

unsafe extern "C" fn create_node(allocator: *mut c_void, _children: c_uint, user: *mut c_void) -> *mut c_void {
    // SAFETY: the user pointer is the one handed in; the allocator gives as many bytes as asked for.
    unsafe {
        let user = &*user.cast::<User>();
        let node: *mut TreeNode = (user.api.alloc)(allocator, size_of::<TreeNode>(), 16).cast();
        node.write(TreeNode { count: 0, boxes: [Aabb::EMPTY; 2], children: [null_mut(); 2] });
        node.cast()
    }
}

unsafe extern "C" fn set_children(node: *mut c_void, children: *mut *mut c_void, count: c_uint, _user: *mut c_void) {
    // SAFETY: the node is one that `create_node` made, with `count` children, two at most.
    unsafe {
        for i in 0..(count as usize).min(2) {
            (*node.cast::<TreeNode>()).children[i] = (*children.add(i)).cast();
        }
    }
}

unsafe extern "C" fn set_bounds(
    node: *mut c_void,
    bounds: *const *const ffi::Bounds,
    count: c_uint,
    _user: *mut c_void,
) {
    // SAFETY: as for `set_children`.
    unsafe {
        for i in 0..(count as usize).min(2) {
            let bounds = &**bounds.add(i);
            (*node.cast::<TreeNode>()).boxes[i] = Aabb::new(bounds.lower, bounds.upper);
        }
    }
}

unsafe extern "C" fn create_leaf(
    allocator: *mut c_void,
    primitives: *const BuildPrimitive,
    count: usize,
    user: *mut c_void,
) -> *mut c_void {
    // SAFETY: as many bytes as asked for, the ids right behind the node; `count` primitives.
    unsafe {
        let user = &*user.cast::<User>();
        let bytes = size_of::<TreeNode>() + count * size_of::<u32>();
        let node: *mut TreeNode = (user.api.alloc)(allocator, bytes, 16).cast();
        let ids: *mut u32 = node.add(1).cast();
        let mut aabb = Aabb::EMPTY;
        for i in 0..count {
            let primitive = &*primitives.add(i);
            ids.add(i).write(primitive.id);
            aabb = aabb.union(&Aabb::new(primitive.lower, primitive.upper));
        }
        node.write(TreeNode { count: count as u32, boxes: [aabb; 2], children: [null_mut(); 2] });
        node.cast()
    }
}

/// The boxes of a triangle's parts on either side of a plane, each within the box of the part that is split.
unsafe extern "C" fn split(
    primitive: *const BuildPrimitive,
    dimension: c_uint,
    position: f32,
    left: *mut ffi::Bounds,
    right: *mut ffi::Bounds,
    user: *mut c_void,
) {
    // SAFETY: pointers from Embree, valid for the call; the id is one of the triangles'.
    unsafe {
        let primitive = &*primitive;
        let triangle = &(*user.cast::<User>()).triangles[primitive.id as usize];
        let axis = dimension as usize;
        let mut sides = [Aabb::EMPTY; 2];
        for i in 0..3 {
            let (a, b) = (triangle.v[i], triangle.v[(i + 1) % 3]);
            let point = Aabb::new(a, a);
            if a[axis] <= position {
                sides[0] = sides[0].union(&point);
            }
            if a[axis] >= position {
                sides[1] = sides[1].union(&point);
            }
            if (a[axis] < position) != (b[axis] < position) && a[axis] != b[axis] {
                let mut cut = a + (b - a) * ((position - a[axis]) / (b[axis] - a[axis]));
                cut[axis] = position;
                sides = sides.map(|side| side.union(&Aabb::new(cut, cut)));
            }
        }
        for (side, out) in sides.iter().zip([left, right]) {
            (*out).lower = side.min.max(primitive.lower);
            (*out).upper = side.max.min(primitive.upper);
        }
    }
}

struct Tree<'a> {
    api: &'a Api,
    bvh: *mut c_void,
    root: *mut TreeNode,
}

impl Drop for Tree<'_> {
    fn drop(&mut self) {
        // SAFETY: made by this library, released once; its nodes go with it.
        unsafe { (self.api.release_bvh)(self.bvh) }
    }
}

impl Built for Tree<'_> {
    fn tree(&self) -> Option<PeerTree> {
        // SAFETY: the nodes are as the callbacks wrote them and live as long as the tree.
        unsafe {
            let root = match &*self.root {
                leaf if leaf.count > 0 => leaf.boxes[0],
                inner => inner.boxes[0].union(&inner.boxes[1]),
            };
            Some(PeerTree::convert((self.root, root), |(node, aabb)| match &*node {
                leaf if leaf.count > 0 => {
                    let ids: *const u32 = node.add(1).cast();
                    // What Embree says of a leaf's box may be wider than its triangles.
                    Opened::Leaf(leaf.boxes[0], std::slice::from_raw_parts(ids, leaf.count as usize).to_vec())
                }
                inner => {
                    let child = |i: usize| (inner.children[i], inner.boxes[i]);
                    Opened::Inner(aabb, child(0), child(1))
                }
            }))
        }
    }
}

struct Scene<'a> {
    api: &'a Api,
    scene: *mut c_void,
    indices: Vec<u32>,
}

impl Drop for Scene<'_> {
    fn drop(&mut self) {
        // SAFETY: made by this library, released once, before the buffers that it shares.
        unsafe { (self.api.release_scene)(self.scene) }
    }
}

impl Built for Scene<'_> {
    fn tree(&self) -> Option<PeerTree> {
        None
    }

    fn traversals(&self, query: Query) -> Vec<&'static str> {
        vec![if query == Query::Closest { "rtcIntersect1" } else { "rtcOccluded1" }]
    }

    fn trace(&self, query: Query, _traversal: usize, rays: &[Ray], hits: &mut [HitRecord]) {
        let mut context = IntersectContext::incoherent();
        for (ray, record) in rays.iter().zip(hits) {
            let mut own = RayHit::new(ray);
            if query == Query::Any {
                // SAFETY: as below.
                unsafe { (self.api.occluded1)(self.scene, &mut context, &mut own) };
                let hit = own.t_far == f32::NEG_INFINITY;
                *record = if hit { HitRecord { triangle: 0, t: 0.0 } } else { HitRecord::MISS };
                continue;
            }
            // SAFETY: the scene is committed; both structures are as rtcIntersect1 wants them, aligned to 16.
            unsafe { (self.api.intersect1)(self.scene, &mut context, &mut own) };
            *record = if own.hit.geometry == Hit::NONE {
                HitRecord::MISS
            } else {
                HitRecord { triangle: own.hit.primitive, t: own.t_far }
            };
        }
    }
}
