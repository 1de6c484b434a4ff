//! One ray through a grid of grids.
//!
//! ```text
//! from cell to cell of the top grid: step over the nearest of the next planes of the three axes (Amanatides and Woo 1987)
//!     a cell that holds something: its box → from cell to cell of its grid, likewise → the triangles of these
//!     stop when the next plane is beyond the best hit
//! ```
//!
//! *Planes that are equally far but for rounding.* A plain walk goes round such an edge on one side, and what is in the cell on the other side is lost. Let `t` be
//! the hit that wins, clamped to the box of its triangle. On each axis this box touches the cells `a..=b` in the ray's order. It lies wholly beyond plane `a`
//! and before plane `b + 1` (unless these are the outermost ones, which are not asked), so that there is a cell `i` of these with
//! `distance(i) <= t <= distance(i + 1) * SLAB_PAD`. All cells that are so on every axis refer to the triangle, and one of them must be visited. They differ by planes
//! in `t / SLAB_PAD ..= t`, which follow each other within that factor. So *planes of different axes within [`TIED`] of the nearest are stepped over
//! together, and the cells between are visited as well*. Planes of one axis are farther from each other than that, or the ray takes the slower walk of
//! [`super::traverse_grid_far`].
//!
//! Distances are computed from the planes' numbers, never added up. The grid in a top cell is over what the boxes in it and the cell have in common, and
//! `t` lies in both: so it is entered, and the same holds for its cells. A triangle in several cells is tested in each.

use super::gathered::gather;
use super::shells::Shells;
use super::traverse_grid_far::traverse_far;
use super::triangle4::{RayLanes, edges4};
use super::{Hit, PreparedRay, SLAB_PAD};
use crate::accel::{BLOCK, Grid, Lattice, TopCell, block_of, plane};
use crate::simd::{Isa, prefetch};
use glam::Vec3;

/// Planes in this factor of the nearest may be as near.
const TIED: f32 = SLAB_PAD * SLAB_PAD * (1.0 + f32::EPSILON);
/// Planes of an axis have to be farther from each other than this share of the distance.
const APART: f32 = 1.0 / (1 << 16) as f32;

/// Triangles that are asked for before they are tested.
const MOST_AHEAD: usize = 60;

/// The planes of one axis in the order in which the ray meets them.
#[derive(Clone, Copy)]
pub(super) struct Axis {
    lo: f32,
    step: f32,
    org: f32,
    inv_dir: f32,
    pub cells: usize,
}

impl Axis {
    #[inline(always)]
    pub(super) fn new(lattice: &Lattice, step: Vec3, ray: &PreparedRay, axis: usize) -> Self {
        let (lo, step) = (lattice.bounds().lo[axis], step[axis]);
        Self { lo, step, org: ray.org[axis], inv_dir: ray.inv_dir[axis], cells: lattice.cells()[axis] }
    }

    /// Where the ray meets the plane before cell `i`. The outermost planes do not limit anything.
    #[inline(always)]
    pub(super) fn distance(&self, i: usize) -> f32 {
        let number = if self.inv_dir < 0.0 { self.cells - i } else { i };
        let distance = (plane(self.lo, self.step, number) - self.org) * self.inv_dir;
        let distance = if i == 0 { f32::NEG_INFINITY } else { distance };
        if i == self.cells { f32::INFINITY } else { distance }
    }

    /// How far planes are from each other along the ray; infinite if there are none.
    #[inline(always)]
    fn pace(&self) -> f32 {
        if self.cells == 1 { f32::INFINITY } else { self.step * self.inv_dir.abs() }
    }

    /// The number of a cell in the grid.
    #[inline(always)]
    pub(super) fn cell(&self, i: usize) -> usize {
        if self.inv_dir < 0.0 { self.cells - 1 - i } else { i }
    }

    /// The first cell that the ray has not left before `begin`. `at` is about the number of the one in which it is then.
    #[inline(always)]
    pub(super) fn first(&self, begin: f32, at: f32) -> usize {
        let guess = (at as usize).min(self.cells - 1);
        // The comparisons decide.
        let mut first = self.cell(guess);
        while first > 0 && self.distance(first) * SLAB_PAD >= begin {
            first -= 1;
        }
        while first + 1 < self.cells && self.distance(first + 1) * SLAB_PAD < begin {
            first += 1;
        }
        first
    }
}

/// Looks for hits of `ray` in `grid`, by the contract of [`super::traverse_bvh::traverse`].
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn traverse<I: Shells, const ANY: bool>(
    grid: &Grid,
    ray: &PreparedRay,
    numbers: (u32, u32),
    best: &mut Hit,
) -> bool {
    let Some(top) = grid.top() else { return false };
    let Some((enter, exit)) = meet(top, ray, best.t) else { return false };
    // SAFETY: the caller's promise.
    unsafe {
        let lanes = RayLanes::<I>::new(ray);
        let mut search = Search::<I, ANY> { grid, ray, lanes, numbers, found: false, is_far: false };
        walk(top, ray, (enter, exit), best, &mut InTop(&mut search));
        if search.is_far {
            return traverse_far::<ANY>(grid, ray, numbers, best) | search.found;
        }
        search.found
    }
}

/// A ray's search in a grid.
struct Search<'a, I: Isa, const ANY: bool> {
    grid: &'a Grid,
    ray: &'a PreparedRay,
    lanes: RayLanes<I>,
    numbers: (u32, u32),
    found: bool,
    /// Planes are too near to each other for the distance.
    is_far: bool,
}

impl<I: Shells, const ANY: bool> Search<'_, I, ANY> {
    /// Tests the triangles of a cell below; returns whether the search is over.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn test(&mut self, top_cell: &TopCell, below: usize, best: &mut Hit) -> bool {
        let all = self.grid.refs(top_cell, below);
        // Crowded cells wait for one triangle after the other otherwise.
        for &index in all.iter().skip(BLOCK).take(MOST_AHEAD) {
            prefetch(self.grid.triangles(), index as usize);
        }
        for refs in all.chunks(BLOCK) {
            // SAFETY: the caller's promise; a grid refers to its own triangles (by its construction).
            unsafe {
                let block = gather(self.grid.triangles(), block_of(refs));
                let Some((candidates, edges)) = edges4(&self.lanes, &block) else { continue };
                self.found |= I::resolve::<ANY, _>(self.ray, &block, candidates, &edges, self.numbers, best);
            }
            if ANY && self.found {
                return true;
            }
        }
        false
    }
}

/// What is done with the cells of a lattice that a ray meets. (No closure, as that could be a function without the instruction set.)
trait Visit {
    /// Whether the walk is over.
    ///
    /// # Safety
    /// - The processor has the instruction set of the search.
    unsafe fn visit(&mut self, cell: usize, best: &mut Hit) -> bool;

    /// The lattice cannot be walked through: see [`APART`].
    fn give_up(&mut self);
}

struct InTop<'s, 'a, I: Isa, const ANY: bool>(&'s mut Search<'a, I, ANY>);

impl<I: Shells, const ANY: bool> Visit for InTop<'_, '_, I, ANY> {
    #[inline(always)]
    unsafe fn visit(&mut self, cell: usize, best: &mut Hit) -> bool {
        let Self(search) = self;
        let cell = &search.grid.cells()[cell];
        if cell.is_empty() {
            return false;
        }
        let Some(interval) = meet(&cell.lattice, search.ray, best.t) else { return false };
        // SAFETY: the caller's promise.
        unsafe {
            if cell.lattice.count() == 1 {
                return search.test(cell, 0, best);
            }
            walk(&cell.lattice, search.ray, interval, best, &mut Below(search, cell))
        }
    }

    fn give_up(&mut self) {
        self.0.is_far = true;
    }
}

struct Below<'s, 'a, I: Isa, const ANY: bool>(&'s mut Search<'a, I, ANY>, &'s TopCell);

impl<I: Shells, const ANY: bool> Visit for Below<'_, '_, I, ANY> {
    #[inline(always)]
    unsafe fn visit(&mut self, cell: usize, best: &mut Hit) -> bool {
        let Self(search, top_cell) = self;
        // SAFETY: the caller's promise.
        unsafe { search.test(top_cell, cell, best) }
    }

    fn give_up(&mut self) {
        self.0.is_far = true;
    }
}

/// The interval in which a ray is in the box of a lattice and before `limit`. Its end is padded.
#[inline(always)]
pub(super) fn meet(lattice: &Lattice, ray: &PreparedRay, limit: f32) -> Option<(f32, f32)> {
    let (enter, exit) = ray.slab(lattice.bounds());
    let enter = if ray.tmin > enter { ray.tmin } else { enter };
    let exit = if limit < exit { limit } else { exit } * SLAB_PAD;
    // Written so that an empty grid's NaN or infinities fail.
    (enter <= exit).then_some((enter, exit))
}

/// Visits the cells of a lattice that the ray meets in an interval, in the ray's order, until the visitor says that it is enough. Returns whether
/// it did.
///
/// # Safety
/// - That of the visitor.
#[inline(always)]
unsafe fn walk(
    lattice: &Lattice,
    ray: &PreparedRay,
    (enter, exit): (f32, f32),
    best: &mut Hit,
    visitor: &mut impl Visit,
) -> bool {
    let step = lattice.step();
    let axes = [Axis::new(lattice, step, ray, 0), Axis::new(lattice, step, ray, 1), Axis::new(lattice, step, ray, 2)];
    let pace = axes[0].pace().min(axes[1].pace()).min(axes[2].pace());
    // Written so that NaN fails.
    if !(pace > exit * APART) {
        visitor.give_up();
        return true;
    }
    let at = (ray.org + ray.dir * enter - lattice.bounds().lo) / step;
    let mut cell = [axes[0].first(enter, at.x), axes[1].first(enter, at.y), axes[2].first(enter, at.z)];
    let mut next = [axes[0].distance(cell[0] + 1), axes[1].distance(cell[1] + 1), axes[2].distance(cell[2] + 1)];
    // Of the cell, and what a step of each axis adds to it.
    let mut number = lattice.number([axes[0].cell(cell[0]), axes[1].cell(cell[1]), axes[2].cell(cell[2])]);
    let [nx, ny, _] = lattice.cells();
    let stride = |axis: usize, cells: usize| if axes[axis].inv_dir < 0.0 { cells.wrapping_neg() } else { cells };
    let strides = [stride(0, 1), stride(1, nx), stride(2, nx * ny)];
    loop {
        // SAFETY: the caller's promise.
        if unsafe { visitor.visit(number, best) } {
            return true;
        }
        let nearest = next[0].min(next[1]).min(next[2]);
        if nearest > best.t || nearest > exit {
            return false;
        }
        let tied = |axis: usize| u32::from(next[axis] <= nearest * TIED) << axis;
        let tied = tied(0) | tied(1) | tied(2);
        if tied & (tied - 1) != 0 {
            // All cells between the planes but the first, which has been visited, and the last, which comes next.
            for some in 1..tied {
                let is_part = some & !tied == 0;
                let inside = (0..3).all(|axis| some >> axis & 1 == 0 || cell[axis] + 1 < axes[axis].cells);
                let on = |axis: usize| if some >> axis & 1 == 1 { strides[axis] } else { 0 };
                let between = number.wrapping_add(on(0)).wrapping_add(on(1)).wrapping_add(on(2));
                // SAFETY: the caller's promise.
                if is_part && inside && unsafe { visitor.visit(between, best) } {
                    return true;
                }
            }
        }
        let mut rest = tied;
        while rest != 0 {
            let axis = rest.trailing_zeros() as usize % 3;
            rest &= rest - 1;
            cell[axis] += 1;
            if cell[axis] == axes[axis].cells {
                return false;
            }
            next[axis] = axes[axis].distance(cell[axis] + 1);
            number = number.wrapping_add(strides[axis]);
        }
    }
}
