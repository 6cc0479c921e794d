//! The surface of a box lattice {0..nx} × {0..ny} × {0..nz}: what the blobs and the slab are made of.

use super::quad;
use crate::scene::assemble::Triangle64;
use glam::DVec3;

/// Triangles of the six faces, wound outward, with `position` giving the point of a lattice index.
///
/// Faces come as x low, x high, y low, …; quads of a face row by row.
pub(super) fn surface(cells: [usize; 3], position: impl Fn([usize; 3]) -> DVec3) -> Vec<Triangle64> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for high in [false, true] {
            for iu in 0..cells[u] {
                for iv in 0..cells[v] {
                    let corner = |du, dv| {
                        let mut index = [0; 3];
                        index[axis] = if high { cells[axis] } else { 0 };
                        (index[u], index[v]) = (iu + du, iv + dv);
                        position(index)
                    };
                    let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
                    triangles.extend(quad::cut(if high { [a, b, c, d] } else { [a, d, c, b] }));
                }
            }
        }
    }
    triangles
}

/// Points on the surface of the cubic lattice {0..n}³; inner entries are unused.
pub(super) struct Cube {
    /// Cells along an edge.
    pub(super) n: usize,
    points: Vec<DVec3>,
}

impl Cube {
    /// A lattice whose surface points are given by `position`.
    pub(super) fn new(n: usize, position: impl Fn([usize; 3]) -> DVec3) -> Self {
        let side = n + 1;
        let points = (0..side * side * side)
            .map(|i| [i / (side * side), i / side % side, i % side])
            .map(|index| if on_surface(index, n) { position(index) } else { DVec3::ZERO })
            .collect();
        Self { n, points }
    }

    /// The point of a lattice index.
    pub(super) fn at(&self, [x, y, z]: [usize; 3]) -> DVec3 {
        let side = self.n + 1;
        self.points[(x * side + y) * side + z]
    }

    /// Linear subdivision: every cell edge is halved; a new point is the mean of its parents.
    ///
    /// An even coordinate counts its one parent twice, so each mean is over eight points.
    pub(super) fn refined(&self) -> Self {
        Self::new(2 * self.n, |index| {
            let parents = index.map(|i| [i / 2, i.div_ceil(2)]);
            let mut sum = DVec3::ZERO;
            for x in parents[0] {
                for y in parents[1] {
                    for z in parents[2] {
                        sum += self.at([x, y, z]);
                    }
                }
            }
            sum / 8.0
        })
    }

    /// One smoothing pass, all points at once: half the point, half the mean of its neighbours on the surface.
    pub(super) fn smoothed(&self) -> Self {
        Self::new(self.n, |index| {
            let (mut sum, mut count) = (DVec3::ZERO, 0);
            for axis in 0..3 {
                for step in [-1, 1] {
                    let mut near = index;
                    let Some(i) = index[axis].checked_add_signed(step).filter(|&i| i <= self.n) else {
                        continue;
                    };
                    near[axis] = i;
                    if on_surface(near, self.n) {
                        sum += self.at(near);
                        count += 1;
                    }
                }
            }
            (self.at(index) + sum / f64::from(count)) / 2.0
        })
    }
}

fn on_surface(index: [usize; 3], n: usize) -> bool {
    index.iter().any(|&i| i == 0 || i == n)
}
