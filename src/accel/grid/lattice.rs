//! A box divided into equal cells.

use crate::accel::Aabb;
use glam::Vec3;
use std::ops::Range;

/// Cells along an axis at most.
const MOST_CELLS: usize = 2048;

/// Planes are computed by the same operations for who fills cells and for who walks through them, so they are the same bits. They ascend, as
/// rounding is monotone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    bounds: Aabb,
    /// Cells per axis, at least one.
    cells: [u16; 3],
}

impl Lattice {
    /// The box as one cell.
    pub(super) fn whole(bounds: Aabb) -> Self {
        Self { bounds, cells: [1; 3] }
    }

    /// About `wanted` cells: cubes, or squares or pieces of a line where the box is thinner than a cube would be.
    pub(super) fn new(bounds: Aabb, wanted: f64) -> Self {
        Self { bounds, cells: resolution(bounds.extent(), wanted).map(|cells| cells as u16) }
    }

    #[inline(always)]
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// Cells per axis.
    #[inline(always)]
    pub fn cells(&self) -> [usize; 3] {
        self.cells.map(usize::from)
    }

    /// Cells in all.
    #[inline(always)]
    pub fn count(&self) -> usize {
        let [x, y, z] = self.cells();
        x * y * z
    }

    /// How far planes are from each other.
    #[inline(always)]
    pub fn step(&self) -> Vec3 {
        let [x, y, z] = self.cells;
        self.bounds.extent() / Vec3::new(f32::from(x), f32::from(y), f32::from(z))
    }

    /// The plane before cell `i` of an axis; what lies beyond the outermost cells counts to them.
    #[inline(always)]
    pub(super) fn plane(&self, axis: usize, step: Vec3, i: usize) -> f32 {
        plane(self.bounds.lo[axis], step[axis], i)
    }

    /// The number of a cell, x fastest.
    #[inline(always)]
    pub fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        let [nx, ny, _] = self.cells();
        (z * ny + y) * nx + x
    }

    /// The box of a cell.
    pub(super) fn cell(&self, number: usize) -> Aabb {
        self.endless_cell(number).intersection(self.bounds)
    }

    /// The box of a cell, which has no end where it is the outermost one.
    pub(super) fn endless_cell(&self, number: usize) -> Aabb {
        let cells = self.cells();
        let at = [number % cells[0], number / cells[0] % cells[1], number / cells[0] / cells[1]];
        let step = self.step();
        let mut cell = Aabb { lo: Vec3::NEG_INFINITY, hi: Vec3::INFINITY };
        for axis in 0..3 {
            if at[axis] > 0 {
                cell.lo[axis] = self.plane(axis, step, at[axis]);
            }
            if at[axis] + 1 < cells[axis] {
                cell.hi[axis] = self.plane(axis, step, at[axis] + 1);
            }
        }
        cell
    }

    /// The cells that a box touches, borders included.
    #[inline(always)]
    pub(super) fn touched(&self, of: &Aabb) -> Touched {
        let step = self.step();
        let [x, y, z] = [0, 1, 2].map(|axis| self.touched_on(axis, step, of.lo[axis], of.hi[axis]));
        Touched { x, y, z }
    }

    #[inline(always)]
    fn touched_on(&self, axis: usize, step: Vec3, lo: f32, hi: f32) -> Range<usize> {
        let last = self.cells()[axis] - 1;
        // Nearly right, and 0 for an axis without extent; the comparisons decide.
        let scale = 1.0 / step[axis];
        let guess = |x: f32| (((x - self.bounds.lo[axis]) * scale) as usize).min(last);
        let plane = |i: usize| self.plane(axis, step, i);
        let mut first = guess(lo);
        while first > 0 && plane(first) >= lo {
            first -= 1;
        }
        while first < last && plane(first + 1) < lo {
            first += 1;
        }
        let mut upper = guess(hi);
        while upper > 0 && plane(upper) > hi {
            upper -= 1;
        }
        while upper < last && plane(upper + 1) <= hi {
            upper += 1;
        }
        first..upper + 1
    }
}

/// Where plane `i` of equal cells is.
#[inline(always)]
pub fn plane(lo: f32, step: f32, i: usize) -> f32 {
    lo + step * i as f32
}

/// A block of cells.
pub(super) struct Touched {
    pub x: Range<usize>,
    pub y: Range<usize>,
    pub z: Range<usize>,
}

impl Touched {
    pub fn count(&self) -> u64 {
        (self.x.len() * self.y.len() * self.z.len()) as u64
    }

    /// The first of them alone.
    pub fn first(&self) -> Self {
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|range| range.start..range.start + 1);
        Self { x, y, z }
    }

    /// Calls `f` for the number of every cell.
    #[inline(always)]
    pub fn for_each(&self, lattice: &Lattice, mut f: impl FnMut(usize)) {
        for z in self.z.clone() {
            for y in self.y.clone() {
                let row = lattice.number([0, y, z]);
                (row + self.x.start..row + self.x.end).for_each(&mut f);
            }
        }
    }
}

fn resolution(extent: Vec3, wanted: f64) -> [usize; 3] {
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| extent[b].total_cmp(&extent[a]));
    let e = axes.map(|axis| f64::from(extent[axis]));
    let cube = (e[0] * e[1] * e[2] / wanted).cbrt();
    let square = (e[0] * e[1] / wanted).sqrt();
    let side = if e[2] > 0.0 && e[2] >= cube {
        cube
    } else if e[1] > 0.0 && e[1] >= square {
        square
    } else {
        e[0] / wanted
    };
    let mut numbers = [1; 3];
    for (axis, extent) in axes.into_iter().zip(e) {
        // A float that is not a number becomes 0.
        numbers[axis] = ((extent / side) as usize).clamp(1, MOST_CELLS);
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_cubes_where_the_box_allows_it() {
        assert_eq!(resolution(Vec3::new(1.0, 2.0, 4.0), 8010.0), [10, 20, 40]);
        assert_eq!(resolution(Vec3::new(10.0, 1e-9, 40.0), 401.0), [10, 1, 40]);
        assert_eq!(resolution(Vec3::new(0.0, 5.0, 0.0), 50.5), [1, 50, 1]);
        assert_eq!(resolution(Vec3::ZERO, 50.0), [1, 1, 1]);
        assert_eq!(resolution(Vec3::new(1e18, 1.0, 1.0), 1e9), [MOST_CELLS, 1, 1]);
    }

    #[test]
    fn a_box_touches_its_neighbours_by_a_border() {
        let lattice = Lattice::new(Aabb { lo: Vec3::ZERO, hi: Vec3::splat(4.0) }, 64.5);
        assert_eq!(lattice.cells(), [4; 3]);
        let touched = lattice.touched(&Aabb { lo: Vec3::new(1.0, 1.5, -9.0), hi: Vec3::new(2.0, 1.6, 9.0) });
        assert_eq!((touched.x, touched.y, touched.z), (0..3, 1..2, 0..4));
        let inner = lattice.number([1, 2, 3]);
        assert_eq!(lattice.cell(inner), Aabb { lo: Vec3::new(1.0, 2.0, 3.0), hi: Vec3::new(2.0, 3.0, 4.0) });
    }
}
