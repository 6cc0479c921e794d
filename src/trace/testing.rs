//! What the tests of this folder share: a plain tree of any arity, awkward triangles, and rays.

use crate::bvh::testing::{Random, boxes, tighten};
use crate::bvh::{Bvh, Node};
use crate::geom::{Aabb, Ray, Triangle};
use glam::Vec3;

/// Splits into `arity` equal parts along the widest extent; leaves hold up to 4 triangles.
pub fn median_split(triangles: &[Triangle], arity: usize) -> Bvh {
    let boxes = boxes(triangles);
    let mut ids: Vec<u32> = (0..triangles.len() as u32).collect();
    let mut nodes = vec![Node::leaf(Aabb::EMPTY, 0, 0)];
    let mut work = vec![(0, 0..ids.len())];
    while let Some((node, range)) = work.pop() {
        if range.len() <= 4 {
            nodes[node] = Node::leaf(Aabb::EMPTY, range.start, range.len());
            continue;
        }
        let part = &mut ids[range.clone()];
        let extent = Aabb::union_of(part.iter().map(|&id| &boxes[id as usize])).extent();
        let axis = extent.max_position();
        let key = |id: u32| boxes[id as usize].centre()[axis];
        part.sort_by(|&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
        let children = arity.min(range.len());
        let first = nodes.len();
        nodes[node] = Node::inner(Aabb::EMPTY, first, children);
        nodes.resize(first + children, Node::leaf(Aabb::EMPTY, 0, 0));
        let cut = |i: usize| range.start + range.len() * i / children;
        work.extend((0..children).map(|i| (first + i, cut(i)..cut(i + 1))));
    }
    let mut bvh = Bvh { nodes, triangle_ids: ids, arity };
    tighten(&mut bvh, &boxes);
    bvh
}

/// Triangles on a grid of small integers: full of ties, shared planes and triangles without area.
pub fn grid_soup(seed: u64, n: usize) -> Vec<Triangle> {
    let mut random = Random(seed);
    let mut corner = || Vec3::from([(); 3].map(|()| random.below(4) as f32));
    (0..n).map(|_| Triangle { v: [(); 3].map(|()| corner()) }).collect()
}

/// From around the unit cube or inside it, through it, any direction.
pub fn any_ray(random: &mut Random) -> Ray {
    let origin = match random.below(2) {
        0 => random.point(1.0),
        _ => random.point(5.0) - 2.0,
    };
    Ray::new(origin, random.point(1.0) - origin)
}

/// Integer origin and direction, zeros of either sign.
pub fn grid_ray(random: &mut Random) -> Ray {
    let mut signed = |n: usize| {
        let value = random.below(n) as f32;
        if random.below(2) == 0 { value } else { -value }
    };
    let origin = Vec3::new(signed(5), signed(5), signed(5));
    Ray::new(origin, Vec3::new(signed(3), signed(3), signed(3)))
}

/// A closed sphere of `rings` × 2·`rings` facets around `centre`; neighbours share their vertices bit for bit.
pub fn sphere(centre: Vec3, radius: f32, rings: usize) -> Vec<Triangle> {
    let segments = 2 * rings;
    let vertex = |ring: usize, segment: usize| {
        let theta = std::f64::consts::PI * ring as f64 / rings as f64;
        let phi = std::f64::consts::TAU * (segment % segments) as f64 / segments as f64;
        // The poles' sine is not exactly 0: there every segment would have a vertex of its own.
        let r = if ring.is_multiple_of(rings) { 0.0 } else { libm::sin(theta) };
        let p = glam::DVec3::new(r * libm::cos(phi), libm::cos(theta), r * libm::sin(phi));
        (centre.as_dvec3() + p * f64::from(radius)).as_vec3()
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let [a, b] = [vertex(ring, segment), vertex(ring, segment + 1)];
            let [c, d] = [vertex(ring + 1, segment), vertex(ring + 1, segment + 1)];
            if ring > 0 {
                triangles.push(Triangle::new(a, b, c));
            }
            if ring + 1 < rings {
                triangles.push(Triangle::new(b, d, c));
            }
        }
    }
    triangles
}
