//! A uniform grid, made anew in linear time whenever vertices have moved (Larsson03 §5; Fujimoto, Tanaka, Iwata, *ARTS*, 1986).
//!
//! ```text
//! cells = cubes, about as many as DENSITY per triangle, over the box of everything
//! count  the references of every cell                      in parallel, by atomic additions
//! sum up where each cell's references begin
//! write  every triangle's number into the cells that its box touches
//! sort   the references of each cell, which the threads have written in any order
//! ```
//!
//! For a soup of triangles that move without any order and fill their box evenly, the paper's last resort. Triangles that are large
//! against a cell are in many cells: where there would be more than [`MOST_REFS`] references per triangle, the grid is made
//! coarser. So memory is bounded for any mesh, and the time by a few passes; at worst there is one cell. A flat box has cells in
//! two directions only, a thin one in one.
//!
//! *Cost.* 350–510 ns per triangle on a busy core that builds the Morton tree in 110–130 (soup of 65,536, flying spheres of 146,000):
//! every triangle is written into about nine cells, in no order of memory. 64–72 bytes per triangle.
//!
//! Planes are kept as numbers, one list per axis, and are the same bits for who fills cells and for who walks through them. A cell refers to all
//! triangles whose padded box touches it, border included: what `trace/traverse_grid` needs for never missing a hit.

use super::memory::{filled, recycled, reserve};
use super::{Aabb, OutOfMemory, triangle_bounds};
use crate::scene::Mesh;
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Cells per triangle.
const DENSITY: f64 = 2.0;
/// References per triangle beyond which the grid is made coarser.
const MOST_REFS: u64 = 10;
/// Cells along an axis at most.
const MOST_CELLS: usize = 2048;
/// By how much a grid with too many references is made coarser.
const COARSER: f64 = 0.35;
/// Triangles, and cells, that are worked on together.
const CHUNK: usize = 4096;

/// The triangles of one object, and the cells in which they are looked for.
#[derive(Debug)]
pub struct Grid {
    corners: Vec<[Vec3; 3]>,
    bounds: Aabb,
    /// Borders of the cells, ascending, one more than cells on that axis.
    planes: [Vec<f32>; 3],
    /// Where the references of each cell begin, x fastest; one more than cells.
    starts: Vec<u32>,
    refs: Vec<AtomicU32>,
    /// Of the build, kept for the next one.
    cursors: Vec<AtomicU32>,
}

impl PartialEq for Grid {
    /// Whether rays meet the same triangles in the same order.
    fn eq(&self, other: &Self) -> bool {
        let load = |refs: &[AtomicU32]| refs.iter().map(|prim| prim.load(Relaxed)).collect::<Vec<_>>();
        self.corners == other.corners
            && self.planes == other.planes
            && self.starts == other.starts
            && load(&self.refs) == load(&other.refs)
    }
}

/// Sorts the references of each cell; `starts` is where cells begin, and where the last one ends.
fn sort_cells(refs: &mut [AtomicU32], starts: &[u32]) {
    let cells = starts.len() - 1;
    let first = starts[0];
    if cells > CHUNK {
        let (left, right) = (&starts[..=cells / 2], &starts[cells / 2..]);
        let (left_refs, right_refs) = refs.split_at_mut((right[0] - first) as usize);
        rayon::join(|| sort_cells(left_refs, left), || sort_cells(right_refs, right));
        return;
    }
    for pair in starts.windows(2) {
        let cell = (pair[0] - first) as usize..(pair[1] - first) as usize;
        refs[cell].sort_unstable_by_key(|prim| prim.load(Relaxed));
    }
}

impl Default for Grid {
    /// The grid of nothing.
    fn default() -> Self {
        let (starts, refs, cursors) = (Vec::new(), Vec::new(), Vec::new());
        Self { corners: Vec::new(), bounds: Aabb::EMPTY, planes: Default::default(), starts, refs, cursors }
    }
}

impl Grid {
    /// Sorts the triangles of `mesh` into cells, in the memory of a former grid. To be called inside the pool.
    ///
    /// # Errors
    /// No memory.
    pub fn new(mesh: &Mesh, old: Grid) -> Result<Self, OutOfMemory> {
        let count = mesh.triangles.len();
        let mut corners = filled(old.corners, count, [Vec3::ZERO; 3])?;
        let (bounds, usable) = corners
            .par_chunks_mut(CHUNK)
            .enumerate()
            .map(|(chunk, corners)| {
                let (mut bounds, mut usable) = (Aabb::EMPTY, 0);
                for (prim, to) in (chunk * CHUNK..).zip(corners) {
                    *to = mesh.corners(prim as u32);
                    let around = triangle_bounds(*to);
                    usable += u64::from(!around.is_empty());
                    bounds = bounds.union(around);
                }
                (bounds, usable)
            })
            .reduce(|| (Aabb::EMPTY, 0), |a, b| (a.0.union(b.0), a.1 + b.1));
        let mut grid = Grid { corners, bounds, planes: old.planes, ..Grid::default() };
        if usable == 0 {
            grid.planes = Default::default();
            return Ok(grid);
        }
        let mut wanted = DENSITY * usable as f64;
        let references = loop {
            grid.divide(wanted)?;
            let boxes = |corners: &[Vec3; 3]| grid.cells(corners).map_or(0, |cells| cells.count());
            let references: u64 = grid.corners.par_iter().with_min_len(CHUNK).map(boxes).sum();
            if references <= MOST_REFS * usable || wanted <= 1.0 {
                // References are counted in 32 bits.
                let bytes = references.saturating_mul(4) as usize;
                break u32::try_from(references).map_err(|_| OutOfMemory { bytes })? as usize;
            }
            wanted *= COARSER;
        };
        grid.sort_in(references, old.starts, old.refs, old.cursors)?;
        Ok(grid)
    }

    /// Makes about so many cells, as near to cubes as it goes.
    fn divide(&mut self, wanted: f64) -> Result<(), OutOfMemory> {
        let numbers = resolution(self.bounds.extent(), wanted);
        for (axis, planes) in self.planes.iter_mut().enumerate() {
            let cells = numbers[axis];
            let (lo, hi) = (self.bounds.lo[axis], self.bounds.hi[axis]);
            let mut all = recycled(std::mem::take(planes), cells + 1)?;
            all.clear();
            // Rounding is monotonic, so the planes are in order.
            all.extend((0..cells).map(|i| lo + (hi - lo) * (i as f32 / cells as f32)));
            all.push(hi);
            *planes = all;
        }
        Ok(())
    }

    fn sort_in(
        &mut self,
        references: usize,
        starts: Vec<u32>,
        refs: Vec<AtomicU32>,
        cursors: Vec<AtomicU32>,
    ) -> Result<(), OutOfMemory> {
        let [nx, ny, nz] = self.resolution();
        let cells = nx * ny * nz;
        let cursors = zeros(cursors, cells)?;
        self.corners.par_iter().with_min_len(CHUNK).for_each(|corners| {
            self.each_cell(corners, &cursors, |cursor| {
                cursor.fetch_add(1, Relaxed);
            });
        });
        let mut starts = recycled(starts, cells + 1)?;
        starts.clear();
        starts.push(0);
        let mut sum = 0;
        for cursor in &cursors {
            // The cursor goes to the cell's first reference.
            sum += cursor.swap(sum, Relaxed);
            starts.push(sum);
        }
        assert_eq!(sum as usize, references, "both passes go through the same cells");
        let mut refs = zeros(refs, references)?;
        self.corners.par_iter().with_min_len(CHUNK).enumerate().for_each(|(prim, corners)| {
            self.each_cell(corners, &cursors, |cursor| {
                refs[cursor.fetch_add(1, Relaxed) as usize].store(prim as u32, Relaxed);
            });
        });
        sort_cells(&mut refs, &starts);
        (self.starts, self.refs, self.cursors) = (starts, refs, cursors);
        Ok(())
    }

    /// Calls `f` for the cursor of every cell that a triangle is in.
    #[inline(always)]
    fn each_cell(&self, corners: &[Vec3; 3], cursors: &[AtomicU32], f: impl Fn(&AtomicU32)) {
        let Some(cells) = self.cells(corners) else { return };
        for (y, z) in cells.rows() {
            let row = self.cell(y, z);
            cursors[row + cells.x.start..row + cells.x.end].iter().for_each(&f);
        }
    }

    /// Cells per axis.
    #[inline(always)]
    pub fn resolution(&self) -> [usize; 3] {
        [0, 1, 2].map(|axis| self.planes[axis].len().saturating_sub(1))
    }

    /// Borders of the cells on an axis, ascending.
    #[inline(always)]
    pub fn planes(&self, axis: usize) -> &[f32] {
        &self.planes[axis]
    }

    #[inline(always)]
    fn cell(&self, y: usize, z: usize) -> usize {
        let [nx, ny, _] = self.resolution();
        (z * ny + y) * nx
    }

    /// The triangles of a cell, in ascending order.
    #[inline(always)]
    pub fn refs(&self, [x, y, z]: [usize; 3]) -> impl Iterator<Item = u32> + '_ {
        let cell = self.cell(y, z) + x;
        self.refs[self.starts[cell] as usize..self.starts[cell + 1] as usize].iter().map(|prim| prim.load(Relaxed))
    }

    /// The box around everything that can be hit.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Corners of all triangles, those that no ray can hit included.
    #[inline(always)]
    pub fn corners(&self) -> &[[Vec3; 3]] {
        &self.corners
    }

    /// The cells that the box of a triangle touches; none for an unusable one.
    #[inline(always)]
    fn cells(&self, corners: &[Vec3; 3]) -> Option<Cells> {
        let bounds = triangle_bounds(*corners);
        (!bounds.is_empty()).then(|| {
            let [x, y, z] = [0, 1, 2].map(|axis| touched(&self.planes[axis], bounds.lo[axis], bounds.hi[axis]));
            Cells { x, y, z }
        })
    }

    /// Bytes held, capacity included.
    pub fn memory_bytes(&self) -> usize {
        self.corners.capacity() * size_of::<[Vec3; 3]>()
            + (self.starts.capacity() + self.refs.capacity() + self.cursors.capacity()) * size_of::<u32>()
            + self.planes.iter().map(|p| p.capacity() * size_of::<f32>()).sum::<usize>()
    }

    /// Checks that every usable triangle of `mesh` is, with its corners, in all cells that its box touches and in no other. Describes the first violation.
    pub fn validate(&self, mesh: &Mesh) -> Result<(), String> {
        if self.corners.len() != mesh.triangles.len() {
            return Err(format!("{} triangles, the mesh has {}", self.corners.len(), mesh.triangles.len()));
        }
        let [nx, ny, nz] = self.resolution();
        let mut found = vec![0u64; self.corners.len()];
        for (z, y, x) in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (z, y, x)))) {
            let mut last = None;
            for prim in self.refs([x, y, z]) {
                if last >= Some(prim) {
                    return Err(format!("triangle {prim} comes after {last:?} in cell {x}, {y}, {z}"));
                }
                last = Some(prim);
                let bounds = triangle_bounds(mesh.corners(prim));
                let touches = [x, y, z].iter().enumerate().all(|(axis, &i)| {
                    let planes = &self.planes[axis];
                    bounds.lo[axis] <= planes[i + 1] && planes[i] <= bounds.hi[axis]
                });
                if !touches {
                    return Err(format!("triangle {prim} does not touch cell {x}, {y}, {z}"));
                }
                found[prim as usize] += 1;
            }
        }
        for (prim, found) in (0..).zip(found) {
            let same = self.corners[prim as usize].map(|c| c.to_array().map(f32::to_bits))
                == mesh.corners(prim).map(|c| c.to_array().map(f32::to_bits));
            let bounds = triangle_bounds(mesh.corners(prim));
            let touched = |axis: usize| {
                let (planes, lo, hi) = (&self.planes[axis], bounds.lo[axis], bounds.hi[axis]);
                planes.windows(2).filter(|p| lo <= p[1] && p[0] <= hi).count() as u64
            };
            let expected = if bounds.is_empty() { 0 } else { touched(0) * touched(1) * touched(2) };
            if !same || found != expected {
                return Err(format!("triangle {prim} is in {found} cells, not {expected}; the same corners: {same}"));
            }
        }
        Ok(())
    }
}

/// A block of cells.
struct Cells {
    x: Range<usize>,
    y: Range<usize>,
    z: Range<usize>,
}

impl Cells {
    fn count(&self) -> u64 {
        (self.x.len() * self.y.len() * self.z.len()) as u64
    }

    /// y and z of each row of cells.
    fn rows(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.z.clone().flat_map(|z| self.y.clone().map(move |y| (y, z)))
    }
}

/// The cells between `planes` that the interval touches, borders included.
#[inline(always)]
fn touched(planes: &[f32], lo: f32, hi: f32) -> Range<usize> {
    let last = planes.len() - 2;
    let (begin, end) = (planes[0], planes[last + 1]);
    let scale = (last + 1) as f32 / (end - begin);
    // Nearly right, and 0 for an axis without extent; the comparisons decide.
    let guess = |x: f32| (((x - begin) * scale) as usize).min(last);
    let mut first = guess(lo);
    while first > 0 && planes[first] >= lo {
        first -= 1;
    }
    while first < last && planes[first + 1] < lo {
        first += 1;
    }
    let mut upper = guess(hi);
    while upper > 0 && planes[upper] > hi {
        upper -= 1;
    }
    while upper < last && planes[upper + 1] <= hi {
        upper += 1;
    }
    first..upper + 1
}

/// Cells per axis of a box, about `wanted` of them: cubes, or squares or pieces of a line where the box is thinner than a cube would be.
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

/// So many zeros, in old memory if it fits.
fn zeros(old: Vec<AtomicU32>, len: usize) -> Result<Vec<AtomicU32>, OutOfMemory> {
    let mut all = if old.capacity() == 0 { reserve(len)? } else { recycled(old, len)? };
    all.clear();
    all.resize_with(len, AtomicU32::default);
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test_meshes::{Random, degenerate, soup};

    #[test]
    fn every_mesh_gets_a_valid_grid_of_bounded_size() {
        let mut old = Grid::default();
        for (name, mesh) in degenerate() {
            let grid = Grid::new(&mesh, std::mem::take(&mut old)).expect("memory");
            grid.validate(&mesh).unwrap_or_else(|e| panic!("{name}: {e}"));
            let [x, y, z] = grid.resolution();
            let most = mesh.triangles.len() as u64 * MOST_REFS;
            assert!(grid.refs.len() as u64 <= most, "{name}: {} references", grid.refs.len());
            assert!(x * y * z <= 8 + 3 * mesh.triangles.len(), "{name}: {x} * {y} * {z} cells");
            old = grid;
        }
    }

    #[test]
    fn validate_sees_what_is_wrong() {
        let mesh = soup(&mut Random::new(Random::seed(9)), 500, 0.2);
        let grid = || Grid::new(&mesh, Grid::default()).expect("memory");
        let mut other = grid();
        other.refs[17] = AtomicU32::new(other.refs[16].load(Relaxed));
        assert!(other.validate(&mesh).is_err());
        let mut other = grid();
        other.corners[3][1].x += 1.0;
        assert!(other.validate(&mesh).is_err());
        let mut other = grid();
        other.planes[1][1] += 0.5;
        assert!(other.validate(&mesh).is_err());
        assert!(grid().validate(&mesh).is_ok());
    }

    #[test]
    fn cells_are_cubes_where_the_box_allows_it() {
        assert_eq!(resolution(Vec3::new(1.0, 2.0, 4.0), 8010.0), [10, 20, 40]);
        assert_eq!(resolution(Vec3::new(10.0, 1e-9, 40.0), 401.0), [10, 1, 40]);
        assert_eq!(resolution(Vec3::new(0.0, 5.0, 0.0), 50.5), [1, 50, 1]);
        assert_eq!(resolution(Vec3::ZERO, 50.0), [1, 1, 1]);
        assert_eq!(resolution(Vec3::new(1e18, 1.0, 1.0), 1e9), [MOST_CELLS, 1, 1]);
    }
}
