//! The cells of a node's grid: between which planes each triangle's centre lies, counted in slabs that hold one.

use super::Triangle;
use crate::geom::Aabb;

/// Cells of the triangles of one node after another.
pub struct Cells {
    /// Planes per axis.
    planes: usize,
    /// Per triangle and axis its slab; the fourth byte is not used.
    cells: Vec<[u8; 4]>,
    /// Slabs per axis. All hold a triangle's centre.
    pub slabs: [usize; 3],
}

impl Cells {
    pub fn new(planes: usize) -> Self {
        Self { planes, cells: Vec::new(), slabs: [0; 3] }
    }

    /// Per triangle and axis, its slab.
    pub fn of_triangles(&self) -> &[[u8; 4]] {
        &self.cells
    }

    /// Finds the cells of the triangles of a node with box `node`.
    pub fn fill(&mut self, triangles: &[Triangle], node: &Aabb) {
        let planes = self.planes;
        let axes = Axes {
            origin: node.min.as_dvec3().to_array(),
            extent: node.extent().to_array(),
            inverse: node.extent().recip().to_array(),
            planes: planes as i32,
        };
        let mut seen = [[false; 256]; 3];
        self.cells.clear();
        self.cells.extend(triangles.iter().map(|t| {
            let centre = t.aabb.centre().to_array();
            let [x, y, z] = [0, 1, 2].map(|axis| axes.bin(centre, axis));
            seen[0][usize::from(x)] = true;
            seen[1][usize::from(y)] = true;
            seen[2][usize::from(z)] = true;
            [x, y, z, 0]
        }));
        let mut slab_of = [[0u8; 256]; 3];
        for axis in 0..3 {
            let mut slabs = 0;
            for bin in 0..=planes {
                slab_of[axis][bin] = slabs as u8;
                slabs += usize::from(seen[axis][bin]);
            }
            self.slabs[axis] = slabs;
        }
        for cell in &mut self.cells {
            for axis in 0..3 {
                cell[axis] = slab_of[axis][usize::from(cell[axis])];
            }
        }
    }
}

/// The axes of a node.
struct Axes {
    origin: [f64; 3],
    extent: [f64; 3],
    inverse: [f64; 3],
    planes: i32,
}

impl Axes {
    /// How many planes a centre is not below: those of (i + 1)·extent ≤ (centre − min)·(planes + 1).
    ///
    /// Division by the extent is off by less than one plane, so the inequality itself corrects it at once. Nothing is
    /// below a plane where the node is flat.
    #[inline(always)]
    fn bin(&self, centre: [f64; 3], axis: usize) -> u8 {
        let (planes, extent) = (self.planes, self.extent[axis]);
        if extent == 0.0 {
            return planes as u8;
        }
        let offset = (centre[axis] - self.origin[axis]) * f64::from(planes + 1);
        let beyond = |i: i32| f64::from(i) * extent <= offset;
        let guess = ((offset * self.inverse[axis]) as i32).min(planes);
        let bin = guess - i32::from(!beyond(guess)) + i32::from(guess < planes && beyond(guess + 1));
        bin as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_centre_on_or_next_to_a_plane_has_the_bin_that_the_inequality_says() {
        for extent in [1.0, 3.0, 49.0, 0.1f32, 7.7, 1e-40, 3e38].map(f64::from) {
            for planes in [1, 2, 6, 25, 50, 100, 254, 255] {
                let axes = Axes { origin: [0.0; 3], extent: [extent; 3], inverse: [extent.recip(); 3], planes };
                for i in 0..=planes + 1 {
                    let on = f64::from(i) * extent / f64::from(planes + 1);
                    for centre in [on, on.next_up(), on.next_down().max(0.0)] {
                        let offset = centre * f64::from(planes + 1);
                        let expected = (0..planes).filter(|&i| f64::from(i + 1) * extent <= offset).count();
                        assert_eq!(usize::from(axes.bin([centre; 3], 1)), expected, "{centre} {extent} {planes}");
                    }
                }
            }
        }
        let flat = Axes { origin: [5.0; 3], extent: [0.0; 3], inverse: [f64::INFINITY; 3], planes: 9 };
        assert_eq!(flat.bin([5.0; 3], 0), 9);
    }
}
