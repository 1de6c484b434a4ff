//! A grid of grids, made anew in linear time whenever vertices have moved (Larsson03 §5; Fujimoto, Tanaka, Iwata, *ARTS*, 1986; in two levels
//! after Kalojanov, Billeter, Slusallek, *Two-Level Grids for Ray Tracing on GPUs*, 2011).
//!
//! ```text
//! top    TOP_DENSITY cells per triangle over the box of everything
//! order  triangles come to lie by the first cell that they touch, so that those of a cell are near each other
//! sort   references to triangles by top cell: counted, summed up, written, and sorted by number
//! below  each top cell has a grid of its own over what it holds, LEAF_DENSITY cells per triangle in it
//! ```
//!
//! For a soup of triangles that move without any order, the paper's last resort. One uniform grid has empty cells where there is nothing, and
//! hundreds of triangles in one where a mesh is dense; two levels take 2 to 4 times fewer cells and half of the tests.
//!
//! Triangles that are large against a cell are in many cells: where there would be more than [`TOP_REFS`] references per triangle, or
//! [`LEAF_REFS`] per triangle of a top cell, that grid is made coarser. So memory is bounded for any mesh, and the time by a few passes; at worst there
//! is one cell. A flat box has cells in two directions only, a thin one in one. All of a build is parallel.
//!
//! A cell refers to all triangles whose padded box touches it, border included: what `trace/traverse_grid` needs for never missing a hit.

mod fill;
mod lattice;
mod validate;

pub use lattice::{Lattice, plane};

use self::fill::Scratch;
use super::corners::Corners;
use super::{Aabb, OutOfMemory, triangle_bounds};
use crate::scene::Mesh;
use rayon::prelude::*;

/// Cells of the top grid per triangle.
const TOP_DENSITY: f64 = 0.03;
/// Cells of a grid below per triangle in it.
const LEAF_DENSITY: f64 = 2.0;
/// So few triangles are not divided.
const UNDIVIDED: usize = 8;
/// References per triangle beyond which a grid is made coarser.
const TOP_REFS: u64 = 4;
const LEAF_REFS: u64 = 5;
/// By how much.
const COARSER: f64 = 0.35;
/// Triangles that are worked on together.
const CHUNK: usize = 4096;

/// A cell of the top grid: the grid in it, and the number of its first cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TopCell {
    pub lattice: Lattice,
    first: u32,
    /// References in it.
    count: u32,
}

impl TopCell {
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }
}

/// The triangles of one object, and the cells in which they are looked for.
#[derive(Debug, Default)]
pub struct Grid {
    /// By the first top cell that they touch, then by number. Those that no ray can hit are not here.
    triangles: Vec<Corners>,
    /// `None` if nothing can be hit.
    top: Option<Lattice>,
    cells: Vec<TopCell>,
    /// Where the references of each cell below begin; one more than cells.
    starts: Vec<u32>,
    refs: Vec<u32>,
    /// Of the build, kept for the next one.
    scratch: Scratch,
}

impl PartialEq for Grid {
    /// Whether rays meet the same triangles in the same order.
    fn eq(&self, other: &Self) -> bool {
        let corners = |grid: &Grid| grid.triangles.iter().map(|t| (t.prim(), t.corners())).collect::<Vec<_>>();
        corners(self) == corners(other)
            && self.top == other.top
            && self.cells == other.cells
            && self.starts == other.starts
            && self.refs == other.refs
    }
}

impl Grid {
    /// Sorts the triangles of `mesh` into cells, in the memory of a former grid. To be called inside the pool.
    ///
    /// # Errors
    /// No memory.
    pub fn new(mesh: &Mesh, old: Grid) -> Result<Self, OutOfMemory> {
        let count = mesh.triangles.len();
        let (bounds, usable) = (0..count)
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|prim| {
                let around = triangle_bounds(mesh.corners(prim as u32));
                (around, u64::from(!around.is_empty()))
            })
            .reduce(|| (Aabb::EMPTY, 0), |a, b| (a.0.union(b.0), a.1 + b.1));
        let mut grid = Grid { top: None, ..old };
        if usable > 0 {
            grid.fill(mesh, bounds, usable)?;
        } else {
            grid.triangles.clear();
            grid.cells.clear();
            grid.starts.clear();
            grid.refs.clear();
        }
        Ok(grid)
    }

    /// The top grid; `None` if nothing can be hit.
    #[inline(always)]
    pub fn top(&self) -> Option<&Lattice> {
        self.top.as_ref()
    }

    /// Cells of the top grid, by number.
    #[inline(always)]
    pub fn cells(&self) -> &[TopCell] {
        &self.cells
    }

    /// What a cell below refers to, in ascending order.
    #[inline(always)]
    pub fn refs(&self, top: &TopCell, number: usize) -> &[u32] {
        let cell = top.first as usize + number;
        &self.refs[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// The box around everything that can be hit.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.top.map_or(Aabb::EMPTY, |top| *top.bounds())
    }

    /// The triangles that [`Grid::refs`] refer to.
    #[inline(always)]
    pub fn triangles(&self) -> &[Corners] {
        &self.triangles
    }

    /// Bytes held, capacity included.
    pub fn memory_bytes(&self) -> usize {
        self.triangles.capacity() * size_of::<Corners>()
            + self.cells.capacity() * size_of::<TopCell>()
            + (self.starts.capacity() + self.refs.capacity()) * size_of::<u32>()
            + self.scratch.memory_bytes()
    }
}
