//! Which way is out of a clear body: by the volume that its surface encloses, whatever way its triangles are wound.
//!
//! Light bends towards the normal where it enters glass and away from it where it leaves, so a body wound inwards bends it the wrong
//! way. A surface is closed where its triangles run along every edge as often one way as the other; its signed volume is then the same
//! from any point, and below zero where the triangles face inwards. What is not closed is taken as it is wound.

use crate::geom::{Aabb, Triangle};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Bodies that are wound inwards.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Inward {
    /// Whether each triangle faces into its body; empty where none does.
    pub(super) triangles: Vec<bool>,
    /// How many bodies.
    pub(super) bodies: usize,
}

/// A connected closed surface of one material.
struct Body {
    material: u16,
    triangles: Vec<usize>,
    bounds: Aabb,
    volume: f64,
}

/// Finds them among the triangles that have a `clear` material, connected where corners are in the same place. A body within
/// another of the same material, a hollow or a bubble, faces inwards by right: it is turned where what is around it is.
pub(super) fn inward(triangles: &[Triangle], clear: impl Fn(usize) -> Option<u16>) -> Inward {
    let mut bodies = closed(triangles, (0..triangles.len()).filter_map(|id| Some((id, clear(id)?))).collect());
    // The largest first, so that what is around is decided before what is in it.
    bodies.sort_by(|a, b| b.bounds.surface_area().total_cmp(&a.bounds.surface_area()));
    let mut found = Inward::default();
    let mut turned: Vec<bool> = Vec::with_capacity(bodies.len());
    for (i, body) in bodies.iter().enumerate() {
        let is_around = |outer: &Body| outer.material == body.material && outer.bounds.contains(&body.bounds);
        let around = (0..i).rev().find(|&outer| is_around(&bodies[outer]));
        let is_inward = around.map_or(body.volume < 0.0, |outer| turned[outer]);
        turned.push(is_inward);
        if is_inward {
            found.bodies += 1;
            found.triangles.resize(triangles.len(), false);
            body.triangles.iter().for_each(|&id| found.triangles[id] = true);
        }
    }
    found
}

/// The closed surfaces among the triangles `ids`, each with its material, by their first triangle.
fn closed(triangles: &[Triangle], ids: Vec<(usize, u16)>) -> Vec<Body> {
    let mut places: HashMap<([u32; 3], u16), usize> = HashMap::new();
    let mut corners: Vec<[usize; 3]> = Vec::with_capacity(ids.len());
    for &(id, material) in &ids {
        corners.push(triangles[id].v.map(|p| {
            let next = places.len();
            *places.entry(((p + Vec3::ZERO).to_array().map(f32::to_bits), material)).or_insert(next)
        }));
    }
    let mut parts = Parts((0..places.len()).collect());
    for &[a, b, c] in &corners {
        parts.join(a, b);
        parts.join(b, c);
    }
    // Of every edge, how often more it is run along from its first to its second place than back.
    let mut edges: HashMap<(usize, usize), i64> = HashMap::new();
    for &[a, b, c] in &corners {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from.min(to), from.max(to))).or_default() += i64::from(from < to) - i64::from(from > to);
        }
    }
    let mut is_open = vec![false; places.len()];
    for (&(from, _), &more) in &edges {
        is_open[parts.of(from)] |= more != 0;
    }
    let mut bodies: Vec<Body> = Vec::new();
    let mut body_of: HashMap<usize, usize> = HashMap::new();
    for (&(id, material), &[a, ..]) in ids.iter().zip(&corners) {
        let part = parts.of(a);
        if is_open[part] {
            continue;
        }
        let at = *body_of.entry(part).or_insert_with(|| {
            bodies.push(Body { material, triangles: Vec::new(), bounds: Aabb::EMPTY, volume: 0.0 });
            bodies.len() - 1
        });
        let body = &mut bodies[at];
        body.triangles.push(id);
        body.bounds = body.bounds.union(&triangles[id].aabb());
        // From a corner of its own, so that little cancels.
        let origin = triangles[body.triangles[0]].v[0].as_dvec3();
        let [a, b, c] = triangles[id].v.map(|p| p.as_dvec3() - origin);
        body.volume += a.dot(DVec3::cross(b, c));
    }
    bodies
}

/// Disjoint sets of places (Tarjan 1975, with path halving).
struct Parts(Vec<usize>);

impl Parts {
    fn of(&mut self, mut place: usize) -> usize {
        while self.0[place] != place {
            self.0[place] = self.0[self.0[place]];
            place = self.0[place];
        }
        place
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The four sides of a tetrahedron, counter-clockwise from outside, or from inside.
    fn tetrahedron(at: Vec3, size: f32, faces_out: bool) -> Vec<Triangle> {
        let [o, x, y, z] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|p| at + p * size);
        let sides = [[o, y, x], [o, z, y], [o, x, z], [x, y, z]];
        sides.map(|[a, b, c]| if faces_out { Triangle::new(a, b, c) } else { Triangle::new(a, c, b) }).to_vec()
    }

    fn turned(bodies: &[Vec<Triangle>]) -> (usize, Vec<bool>) {
        let found = inward(&bodies.concat(), |_| Some(0));
        (found.bodies, found.triangles)
    }

    #[test]
    fn a_closed_body_faces_out_by_its_volume() {
        let far = Vec3::splat(1e4);
        assert_eq!(turned(&[tetrahedron(far, 1.0, true)]), (0, vec![]));
        let both = [tetrahedron(far, 1.0, false), tetrahedron(Vec3::ZERO, 1.0, true)];
        assert_eq!(turned(&both), (1, [[true; 4], [false; 4]].concat()));
        // The same place, once as −0.
        let mut signed = tetrahedron(Vec3::ZERO, 1.0, false);
        signed[0].v[0] = Vec3::splat(-0.0);
        assert_eq!(turned(&[signed]).0, 1);
    }

    #[test]
    fn what_is_open_or_not_clear_stays_as_it_is_wound() {
        let mut open = tetrahedron(Vec3::ZERO, 1.0, false);
        open.pop();
        assert_eq!(turned(&[open]).0, 0);
        let mut mixed = tetrahedron(Vec3::ZERO, 1.0, false);
        mixed[3].v.swap(1, 2);
        assert_eq!(turned(&[mixed]).0, 0, "one side is wound otherwise than the others");
        let solid = tetrahedron(Vec3::ZERO, 1.0, false);
        assert_eq!(inward(&solid, |_| None), Inward::default());
        assert_eq!(inward(&solid, |id| (id > 0).then_some(0)), Inward::default(), "one side is a matt wall");
    }

    #[test]
    fn a_hollow_turns_with_what_is_around_it() {
        let within = Vec3::splat(0.1);
        let hollow = |outer, inner| turned(&[tetrahedron(within, 0.2, inner), tetrahedron(Vec3::ZERO, 1.0, outer)]).0;
        assert_eq!((hollow(true, false), hollow(true, true)), (0, 0), "glass around air; glass in glass");
        assert_eq!((hollow(false, true), hollow(false, false)), (2, 2), "the whole is inside out");
        let filled = [tetrahedron(within, 0.2, false), tetrahedron(Vec3::ZERO, 1.0, true)].concat();
        assert_eq!(inward(&filled, |id| Some(u16::from(id < 4))).bodies, 1, "what is in a glass is a body of its own");
    }
}
