//! Boxes of triangles from their vertices alone, each vertex once (Larsson03 §3.2).
//!
//! A mesh has half as many vertices as triangles, and each is read once instead of six times. The box contains the box of every usable triangle between
//! the vertices ([`super::aabb::padded`]), and is larger by a few units in the last place of the whole, as the padding grows with the extent.
//!
//! A vertex that is not a number, or so far out that none of its triangles can be usable, is left out, so the box is finite. A coordinate that is
//! not a number leaves out itself alone, which the minimum does by itself: the box then contains more than it must. Vertices that no
//! triangle uses, and those of unusable triangles, count as well.
//!
//! Vertices that follow each other in the mesh are loaded as runs of four ([`super::vertex_runs`]), three vectors instead of four and one number instead of four: with three quarters
//! of the vertices in runs, the update before the first ray is 1.15 to 1.2 times as fast as by single numbers.
//!
//! *Tried*: four boxes that grow side by side, as a minimum waits for the one before it. Not faster (`cargo bench --bench papers -- larsson1`, update before the first ray:
//! 1.3 to 1.7 ms of one thread against 1.5 to 1.7 for 737,280 triangles); what is waited for are the vertices.

use super::Aabb;
use super::aabb::{MAX_COORDINATE, padded};
use super::block_loader::vertex;
use super::vertex_runs::{RUN, VertexSet};
use crate::simd::{self, Kernel, Level, components, prefetch_at};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use std::ops::Range;

/// Vertices between asking for one and loading it. On nine bodies of 81,920 triangles the update before the first ray is 7 to 8 times cheaper than a refit with 16, 9 times with
/// 32, 11 times with 64; with 256 no more, and rays that update short lists lose.
pub(super) const AHEAD: usize = 64;
/// Likewise runs.
const AHEAD_RUNS: usize = 24;
/// Vertices per task.
const CHUNK: usize = 1 << 15;
/// A usable triangle has no coordinate beyond this, see [`super::triangle_bounds`].
pub(super) const LIMIT: f32 = 3.0 * MAX_COORDINATE;

/// The box of all triangles between the vertices of a set in `lists`; empty if no vertex is usable.
pub(super) fn box_of_set(positions: &[Vec3], lists: &[u32], set: &VertexSet) -> Aabb {
    finish(simd::run(Level::detect(), Listed { positions, lists, set }), || {
        usable(set.vertices(lists).map(|v| positions[v as usize]))
    })
}

/// The box of all triangles between `positions`. To be called inside the pool.
pub(super) fn box_of_all(positions: &[Vec3]) -> Aabb {
    let chunks = positions.par_chunks(CHUNK);
    let tight = chunks.map(|points| simd::run(Level::detect(), All(points))).reduce(|| Aabb::EMPTY, Aabb::union);
    finish(tight, || usable(positions.iter().copied()))
}

/// Pads a box; takes another one where an unusable vertex has made it too large.
fn finish(tight: Aabb, again: impl FnOnce() -> Aabb) -> Aabb {
    let within = tight.lo.cmpge(Vec3::splat(-LIMIT)).all() && tight.hi.cmple(Vec3::splat(LIMIT)).all();
    let tight = if within || tight.is_empty() { tight } else { again() };
    if tight.is_empty() { Aabb::EMPTY } else { padded(tight) }
}

#[cold]
fn usable(points: impl Iterator<Item = Vec3>) -> Aabb {
    // Written so that NaN fails.
    let usable = points.filter(|p| p.abs().cmple(Vec3::splat(LIMIT)).all());
    usable.fold(Aabb::EMPTY, |mut all, p| {
        all.grow(p);
        all
    })
}

struct Listed<'a> {
    positions: &'a [Vec3],
    lists: &'a [u32],
    set: &'a VertexSet,
}

impl Kernel for Listed<'_> {
    type Output = Aabb;

    #[inline(always)]
    fn run(self) -> Aabb {
        let Self { positions, lists, set } = self;
        let coordinates = components(positions);
        let mut of_runs = RunBounds::EMPTY;
        each_listed(positions, lists, set.runs.clone(), AHEAD_RUNS, |first| of_runs.grow(run(coordinates, first)));
        let mut all = of_runs.into_bounds();
        each_listed(positions, lists, set.rest.clone(), AHEAD, |index| all.grow(vertex(coordinates, index)));
        all.into_aabb()
    }
}

/// The coordinates of a run of vertices.
#[inline(always)]
fn run(coordinates: &[f32], first: u32) -> &[f32; 3 * RUN] {
    coordinates[3 * first as usize..].first_chunk().expect("a run is among the vertices")
}

/// Asks for the first vertices of a list that is not the one after the last.
#[inline(always)]
pub(super) fn ask_for_first(positions: &[Vec3], list: &[u32]) {
    for &index in &list[..list.len().min(AHEAD)] {
        prefetch_at(positions.as_ptr().wrapping_add(index as usize));
    }
}

/// Hands out the numbers of a list. Vertices are asked for `ahead` numbers before that, and towards the end the first
/// of the next list: lists are most often gone through in order, and there are many short ones.
#[inline(always)]
pub(super) fn each_listed(
    positions: &[Vec3],
    lists: &[u32],
    which: Range<usize>,
    ahead: usize,
    mut to: impl FnMut(u32),
) {
    let Range { start, end } = which;
    let later = &lists[(start + ahead).min(lists.len())..];
    let list = &lists[start..end];
    // Two loops, as to ask whether there still are later ones takes as long as all else.
    for (&index, &later) in list.iter().zip(later) {
        prefetch_at(positions.as_ptr().wrapping_add(later as usize));
        to(index);
    }
    for &index in list.get(later.len()..).unwrap_or(&[]) {
        to(index);
    }
}

struct All<'a>(&'a [Vec3]);

impl Kernel for All<'_> {
    type Output = Aabb;

    #[inline(always)]
    fn run(self) -> Aabb {
        let coordinates = components(self.0);
        let (runs, rest) = coordinates.as_chunks();
        let mut of_runs = RunBounds::EMPTY;
        for run in runs {
            of_runs.grow(run);
        }
        let mut all = of_runs.into_bounds();
        for index in (coordinates.len() - rest.len()) / 3..self.0.len() {
            all.grow(vertex(coordinates, index as u32));
        }
        all.into_aabb()
    }
}

/// Least and most of the coordinates of runs, as they lie in memory.
struct RunBounds {
    lo: [Vec4; 3],
    hi: [Vec4; 3],
}

impl RunBounds {
    const EMPTY: Self = Self { lo: [Vec4::INFINITY; 3], hi: [Vec4::NEG_INFINITY; 3] };

    #[inline(always)]
    fn grow(&mut self, run: &[f32; 3 * RUN]) {
        for k in 0..3 {
            let p = Vec4::new(run[4 * k], run[4 * k + 1], run[4 * k + 2], run[4 * k + 3]);
            // In this order, see `Bounds`.
            self.lo[k] = p.min(self.lo[k]);
            self.hi[k] = p.max(self.hi[k]);
        }
    }

    #[inline(always)]
    fn into_bounds(self) -> Bounds {
        let points = |[a, b, c]: [Vec4; 3]| {
            [a, Vec4::new(a.w, b.x, b.y, 0.0), Vec4::new(b.z, b.w, c.x, 0.0), Vec4::new(c.y, c.z, c.w, 0.0)]
        };
        let ([a, b, c, d], [e, f, g, h]) = (points(self.lo), points(self.hi));
        Bounds { lo: a.min(b).min(c.min(d)), hi: e.max(f).max(g.max(h)) }
    }
}

/// The last lanes are meaningless.
struct Bounds {
    lo: Vec4,
    hi: Vec4,
}

impl Bounds {
    #[inline(always)]
    fn grow(&mut self, p: Vec4) {
        // In this order: the second operand is taken where the first is not a number.
        self.lo = p.min(self.lo);
        self.hi = p.max(self.hi);
    }

    #[inline(always)]
    fn into_aabb(self) -> Aabb {
        Aabb { lo: self.lo.truncate(), hi: self.hi.truncate() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test_meshes::degenerate;
    use crate::accel::triangle_bounds;
    use crate::accel::vertex_runs::Marks;

    #[test]
    fn the_box_contains_that_of_every_triangle_and_is_finite() {
        for (name, mesh) in degenerate() {
            let count = mesh.triangles.len() as u32;
            let all = box_of_all(&mesh.positions);
            let listed: Vec<u32> = (0..mesh.positions.len() as u32).collect();
            let alone = VertexSet { runs: 0..0, rest: 0..listed.len() };
            assert_eq!(all, box_of_set(&mesh.positions, &listed, &alone), "{name}");
            let mut marks = Marks::default();
            marks.prepare(listed.len()).expect("memory");
            for part in listed.chunks(23) {
                marks.mark(part);
                let [runs, rest] = marks.take().expect("memory");
                let in_runs = VertexSet { runs: 0..runs.len(), rest: runs.len()..runs.len() + rest.len() };
                let lists = [runs, rest].concat();
                let alone = VertexSet { runs: 0..0, rest: 0..part.len() };
                let expected = box_of_set(&mesh.positions, part, &alone);
                assert_eq!(box_of_set(&mesh.positions, &lists, &in_runs), expected, "{name}");
            }
            assert!(all.is_empty() || (all.lo.is_finite() && all.hi.is_finite()), "{name}: {all:?}");
            for prim in 0..count {
                let own = triangle_bounds(mesh.corners(prim));
                assert!(all.contains(&own), "{name}: {all:?} lacks {own:?}");
                let alone = VertexSet { runs: 0..0, rest: 0..3 };
                let listed = box_of_set(&mesh.positions, &mesh.triangles[prim as usize], &alone);
                assert!(listed.contains(&own), "{name}: {listed:?} lacks {own:?}");
                if !own.is_empty() {
                    assert_eq!(listed, own, "{name}: the box of one triangle is not looser");
                }
            }
        }
    }

    #[test]
    fn no_usable_vertex_means_an_empty_box() {
        let bad = [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, 1e30, 0.0), Vec3::new(f32::NEG_INFINITY, 0.0, 0.0)];
        assert_eq!(box_of_all(&bad), Aabb::EMPTY);
        assert_eq!(box_of_all(&[]), Aabb::EMPTY);
        let one = [bad[0], Vec3::ONE, bad[2]];
        assert!(box_of_all(&one).contains(&Aabb { lo: Vec3::ONE, hi: Vec3::ONE }));
        assert!(box_of_all(&one).extent().max_element() < 1e-6);
    }
}
