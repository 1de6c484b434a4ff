//! Writing triangles into cells.
//!
//! The top grid's references are counted by atomic additions and written in any order, then sorted; triangles are ordered by their first cells
//! likewise. The grid in a top cell is filled by one thread, from what is sorted already, in memory that fits the cache.

use super::lattice::{Lattice, Touched};
use super::{CHUNK, COARSER, Grid, LEAF_DENSITY, LEAF_REFS, TOP_DENSITY, TOP_REFS, TopCell, UNDIVIDED};
use crate::accel::corners::Corners;
use crate::accel::memory::{ask, filled, recycled, reserve};
use crate::accel::{Aabb, OutOfMemory, triangle_bounds};
use crate::scene::Mesh;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Top cells whose grids one task fills.
const CELLS: usize = 16;

/// What a build works with.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// References of the top grid.
    sorted: Sorted,
}

impl Scratch {
    pub(super) fn memory_bytes(&self) -> usize {
        let Sorted { items, starts, cursors } = &self.sorted;
        (items.capacity() + starts.capacity() + cursors.capacity()) * size_of::<u32>()
    }
}

/// Numbers by cell, ascending, and where those of each cell begin; one more than cells.
#[derive(Debug, Default)]
struct Sorted {
    items: Vec<AtomicU32>,
    starts: Vec<u32>,
    cursors: Vec<AtomicU32>,
}

impl Sorted {
    /// Sorts `0..count` into `cells` cells, of which each is in those that `touched` tells: `references` in all. In the memory of a former sorting.
    fn new(
        old: Sorted,
        count: usize,
        lattice: &Lattice,
        references: usize,
        touched: impl Fn(usize) -> Option<Touched> + Sync,
    ) -> Result<Self, OutOfMemory> {
        let cells = lattice.count();
        let numbers = || (0..count).into_par_iter().with_min_len(CHUNK);
        let cursors = zeros(old.cursors, cells)?;
        numbers().for_each(|item| {
            if let Some(touched) = touched(item) {
                touched.for_each(lattice, |cell| {
                    cursors[cell].fetch_add(1, Relaxed);
                });
            }
        });
        let mut starts = recycled(old.starts, cells + 1)?;
        starts.clear();
        starts.push(0);
        let mut sum = 0;
        for cursor in &cursors {
            // The cursor goes to the cell's first reference.
            sum += cursor.swap(sum, Relaxed);
            starts.push(sum);
        }
        assert_eq!(sum as usize, references, "all passes go through the same cells");
        let mut items = zeros(old.items, references)?;
        numbers().for_each(|item| {
            if let Some(touched) = touched(item) {
                touched.for_each(lattice, |cell| {
                    items[cursors[cell].fetch_add(1, Relaxed) as usize].store(item as u32, Relaxed);
                });
            }
        });
        let mut parts: Vec<&mut [AtomicU32]> = reserve(cells.div_ceil(CELLS))?;
        let mut rest = &mut items[..];
        for first in (0..cells).step_by(CELLS) {
            let length = starts[(first + CELLS).min(cells)] - starts[first];
            let (these, others) = rest.split_at_mut(length as usize);
            parts.push(these);
            rest = others;
        }
        parts.into_par_iter().zip(starts[..cells].par_chunks(CELLS)).for_each(|(items, firsts)| {
            for (cell, &first) in firsts.iter().enumerate() {
                let begin = (first - firsts[0]) as usize;
                let end = firsts.get(cell + 1).map_or(items.len(), |next| (next - firsts[0]) as usize);
                items[begin..end].sort_unstable_by_key(|item| item.load(Relaxed));
            }
        });
        Ok(Self { items, starts, cursors })
    }
}

/// The cells of `lattice` that a triangle touches; none for an unusable one.
#[inline(always)]
fn touched(lattice: &Lattice, corners: [Vec3; 3]) -> Option<Touched> {
    let bounds = triangle_bounds(corners);
    (!bounds.is_empty()).then(|| lattice.touched(&bounds))
}

impl Grid {
    pub(super) fn fill(&mut self, mesh: &Mesh, bounds: Aabb, usable: u64) -> Result<(), OutOfMemory> {
        let (top, references) = choose_top(mesh, bounds, usable)?;
        let old = std::mem::take(&mut self.scratch.sorted);
        let count = mesh.triangles.len();
        let first = |prim| Some(touched(&top, mesh.corners(prim as u32))?.first());
        let order = Sorted::new(old, count, &top, in_32_bits(usable)?, first)?;
        let mut triangles = filled(std::mem::take(&mut self.triangles), order.items.len(), Corners::NONE)?;
        triangles.par_iter_mut().zip(&order.items).with_min_len(CHUNK).for_each(|(to, prim)| {
            let prim = prim.load(Relaxed);
            *to = Corners::new(prim, mesh.corners(prim));
        });
        let all = |index: usize| touched(&top, triangles[index].corners());
        self.scratch.sorted = Sorted::new(order, triangles.len(), &top, references, all)?;
        self.triangles = triangles;
        self.choose_below(&top)?;
        self.fill_below()?;
        self.top = Some(top);
        Ok(())
    }

    /// The numbers of the triangles of a top cell, ascending.
    #[inline(always)]
    fn numbers(&self, cell: usize) -> impl Iterator<Item = u32> {
        let Sorted { items, starts, .. } = &self.scratch.sorted;
        items[starts[cell] as usize..starts[cell + 1] as usize].iter().map(|item| item.load(Relaxed))
    }

    /// The triangles of a top cell.
    #[inline(always)]
    fn held(&self, cell: usize) -> impl Iterator<Item = &Corners> {
        self.numbers(cell).map(|index| &self.triangles[index as usize])
    }

    /// The grids in the top cells, where their cells begin, and how many references there are.
    fn choose_below(&mut self, top: &Lattice) -> Result<(), OutOfMemory> {
        let cells = top.count();
        let nothing = TopCell { lattice: Lattice::whole(*top.bounds()), first: 0, count: 0 };
        let mut all = filled(std::mem::take(&mut self.cells), cells, nothing)?;
        let grid = &*self;
        all.par_iter_mut().with_min_len(CELLS).enumerate().for_each(|(cell, to)| {
            let (lattice, count) = grid.choose(top.cell(cell), cell);
            *to = TopCell { lattice, first: 0, count };
        });
        let (mut sum, mut references) = (0u64, 0u64);
        for cell in &mut all {
            cell.first = sum as u32;
            sum += cell.lattice.count() as u64;
            references += u64::from(cell.count);
        }
        let sum = in_32_bits(sum + 1)?;
        self.starts = filled(std::mem::take(&mut self.starts), sum, 0)?;
        self.refs = filled(std::mem::take(&mut self.refs), in_32_bits(references)?, 0)?;
        self.cells = all;
        Ok(())
    }

    /// The grid of one top cell with box `bounds`, and its references.
    fn choose(&self, bounds: Aabb, cell: usize) -> (Lattice, u32) {
        let boxes = || self.held(cell).map(|triangle| triangle_bounds(triangle.corners()));
        let (mut held, mut count) = (Aabb::EMPTY, 0u64);
        for around in boxes() {
            (held, count) = (held.union(around), count + 1);
        }
        let bounds = if count == 0 { bounds } else { held.intersection(bounds) };
        if count as usize <= UNDIVIDED {
            return (Lattice::whole(bounds), count as u32);
        }
        let mut wanted = LEAF_DENSITY * count as f64;
        loop {
            let lattice = Lattice::new(bounds, wanted.max(1.0));
            let references: u64 = boxes().map(|around| lattice.touched(&around).count()).sum();
            if references <= LEAF_REFS * count || wanted <= 1.0 {
                return (lattice, references.min(u64::from(u32::MAX)) as u32);
            }
            wanted *= COARSER;
        }
    }

    /// Writes starts and references of all grids below.
    fn fill_below(&mut self) -> Result<(), OutOfMemory> {
        let (mut all_starts, mut all_refs) = (std::mem::take(&mut self.starts), std::mem::take(&mut self.refs));
        let mut parts: Vec<(&mut [u32], &mut [u32])> = Vec::new();
        ask(&mut parts, self.cells.len().div_ceil(CELLS))?;
        let (mut starts, mut refs) = (&mut all_starts[..], &mut all_refs[..]);
        for cells in self.cells.chunks(CELLS) {
            let (these_starts, other_starts) = starts.split_at_mut(cells.iter().map(|cell| cell.lattice.count()).sum());
            let (these_refs, other_refs) = refs.split_at_mut(cells.iter().map(|cell| cell.count as usize).sum());
            parts.push((these_starts, these_refs));
            (starts, refs) = (other_starts, other_refs);
        }
        assert!(starts.len() == 1 && refs.is_empty(), "every cell and reference is of one top cell");
        let mut before: Vec<u32> = Vec::new();
        ask(&mut before, parts.len())?;
        let mut sum = 0;
        before.extend(self.cells.chunks(CELLS).map(|cells| {
            let first = sum;
            sum += cells.iter().map(|cell| cell.count).sum::<u32>();
            first
        }));
        starts[0] = sum;
        let grid = &*self;
        parts.into_par_iter().zip(&before).enumerate().for_each(|(part, ((starts, refs), &before))| {
            let (mut cell_at, mut ref_at) = (0, 0);
            for (cell, top) in grid.cells.iter().enumerate().skip(part * CELLS).take(CELLS) {
                let starts = &mut starts[cell_at..][..top.lattice.count()];
                let count = top.count as usize;
                grid.fill_one(cell, &top.lattice, starts, &mut refs[ref_at..][..count], before + ref_at as u32);
                cell_at += starts.len();
                ref_at += count;
            }
        });
        (self.starts, self.refs) = (all_starts, all_refs);
        Ok(())
    }

    /// Calls `f` with every cell of a grid below and the triangles in it, triangle by triangle.
    #[inline(always)]
    fn each_reference(&self, cell: usize, lattice: &Lattice, mut f: impl FnMut(usize, u32)) {
        for (index, triangle) in self.numbers(cell).zip(self.held(cell)) {
            let touched = lattice.touched(&triangle_bounds(triangle.corners()));
            touched.for_each(lattice, |cell| f(cell, index));
        }
    }

    /// Writes one grid, whose references begin at `first` among all.
    fn fill_one(&self, cell: usize, lattice: &Lattice, starts: &mut [u32], refs: &mut [u32], first: u32) {
        starts.fill(0);
        self.each_reference(cell, lattice, |cell, _| starts[cell] += 1);
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += std::mem::replace(start, sum);
        }
        assert_eq!(sum as usize, refs.len(), "all passes go through the same cells");
        self.each_reference(cell, lattice, |cell, index| {
            refs[starts[cell] as usize] = index;
            starts[cell] += 1;
        });
        // Each has gone to where the next began.
        let mut begin = first;
        for start in starts.iter_mut() {
            begin = std::mem::replace(start, begin) + first;
        }
    }
}

/// A top grid, and how many references it has.
fn choose_top(mesh: &Mesh, bounds: Aabb, usable: u64) -> Result<(Lattice, usize), OutOfMemory> {
    let mut wanted = TOP_DENSITY * usable as f64;
    loop {
        let top = Lattice::new(bounds, wanted.max(1.0));
        let count = |prim: usize| touched(&top, mesh.corners(prim as u32)).map_or(0, |cells| cells.count());
        let references: u64 = (0..mesh.triangles.len()).into_par_iter().with_min_len(CHUNK).map(count).sum();
        if references <= TOP_REFS * usable || wanted <= 1.0 {
            return Ok((top, in_32_bits(references)?));
        }
        wanted *= COARSER;
    }
}

/// Cells and references are counted in 32 bits.
fn in_32_bits(count: u64) -> Result<usize, OutOfMemory> {
    let bytes = count.saturating_mul(4) as usize;
    Ok(u32::try_from(count).map_err(|_| OutOfMemory { bytes })? as usize)
}

/// So many zeros, in old memory if it fits.
fn zeros(old: Vec<AtomicU32>, len: usize) -> Result<Vec<AtomicU32>, OutOfMemory> {
    let mut all = if old.capacity() == 0 { reserve(len)? } else { recycled(old, len)? };
    all.clear();
    all.resize_with(len, AtomicU32::default);
    Ok(all)
}
