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
        let (planes, origin, extent) = (self.planes, node.min.as_dvec3(), node.extent());
        let inverse = extent.recip();
        let mut seen = [[false; 256]; 3];
        self.cells.clear();
        self.cells.extend(triangles.iter().map(|t| {
            let offset = (t.aabb.centre() - origin) * (planes + 1) as f64;
            let bin = [0, 1, 2].map(|axis| {
                // Planes that the centre is not below: a division's guess, corrected by the inequality that decides.
                let beyond = |i: usize| (i as f64) * extent[axis] <= offset[axis];
                if extent[axis] == 0.0 {
                    return planes as u8;
                }
                let mut bin = ((offset[axis] * inverse[axis]) as usize).min(planes);
                while bin < planes && beyond(bin + 1) {
                    bin += 1;
                }
                while bin > 0 && !beyond(bin) {
                    bin -= 1;
                }
                bin as u8
            });
            for axis in 0..3 {
                seen[axis][usize::from(bin[axis])] = true;
            }
            [bin[0], bin[1], bin[2], 0]
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
