//! Cutting triangles by planes, for trees in which a triangle may be in several leaves, with a smaller box in each.
//!
//! After Stich, Friedrich, Dietrich, *Spatial Splits in Bounding Volume Hierarchies* (HPG 2009). A *reference* is a triangle and a box around a
//! part of it. Cutting one at a plane gives two, with boxes around what of the triangle lies on either side, as far as the box reached.
//!
//! # Why no hit is lost
//!
//! A triangle's test knows nothing of boxes around parts: its distance `t` is what it is in every structure ([`crate::trace::triangle`]). So a ray that hits
//! triangle T at `t` must enter the box R of one of T's references, at a distance that traversal does not take for farther than
//! `t`. With u half an ulp, e the largest side of T's box, and X the point of T with the exact weights of the (rounded) edge functions:
//!
//! * *X is in a reference.* A cut puts every point of T on one side or both. Every side of R is a side of T's own box or lies at least
//!   a pad of e/8192 and 8 u of the coordinate beyond the part of T, of which 512 u e cover the rounding of the cut itself.
//! * *The ray passes X*, by 4 u of its way per axis and by 6 u e, which is what shearing adds. With 3 u for a slab distance, the ray
//!   enters R's planes before `X's distance * (1 + 7 u)` and leaves after `(1 - 7 u)` of it: `SLAB_PAD` is 16 u.
//! * *`t` is X's distance*, but for 10 u of it (two of them in common with the planes), and for what rounding of the edge functions does to
//!   the weights: at most `24 u e (e² / twice the area seen)`. [`super::least_area`] keeps that below 1536 u e: smaller ones are weighed in f64. In
//!   the direction of the ray the pad is as much or more. So no plane of R is entered beyond `t * (1 + 15 u)`, and best distances are padded
//!   by 16 u where boxes are tested.
//! * *Clamping* `t` to T's box moves it towards the interval of R, which lies inside.
//!
//! The union of a triangle's boxes is its own box, bit for bit, so bounds of objects do not change. Tests twice are harmless: they give the same bits.

use super::aabb::{PAD_ABSOLUTE, PAD_ULP};
use super::binning::{PARALLEL, blocks_of};
use super::prim_ref::{Box4, PrimRef};
use crate::memory::vec_of;
use crate::scene::Mesh;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Boxes around parts are padded by this share of the triangle's largest side: see the module head and [`super::least_area`].
const PAD_PART: f32 = 1.0 / 8192.0;
/// And by this multiple of the coordinate.
const PAD_COORDINATE: f32 = 4.0 * PAD_ULP;
/// Slices per axis at most.
const BINS: usize = 16;
/// References per task when many are divided.
const CHUNK: usize = 1 << 13;

/// Corners of a box that is still empty.
const NOTHING: (Vec4, Vec4) = (Vec4::INFINITY, Vec4::NEG_INFINITY);

#[inline(always)]
fn grow((lo, hi): &mut (Vec4, Vec4), p: Vec4) {
    (*lo, *hi) = (lo.min(p), hi.max(p));
}

/// A triangle to be cut, with the pad of its parts.
struct Triangle {
    corners: [Vec4; 3],
    pad: Vec4,
}

impl Triangle {
    #[inline(always)]
    fn new(corners: [Vec3; 3]) -> Self {
        let corners = corners.map(|p| p.extend(0.0));
        let [a, b, c] = corners;
        let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
        let side = (hi - lo).max_element();
        Self { corners, pad: lo.abs().max(hi.abs()) * PAD_COORDINATE + Vec4::splat(side * PAD_PART + PAD_ABSOLUTE) }
    }

    #[inline(always)]
    fn edges(&self) -> [(Vec4, Vec4); 3] {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)]
    }

    /// Grows `parts[first..=last]` by what lies in these slices, for choosing a plane: not exact to the bit.
    #[inline(always)]
    fn chop(&self, slices: &Slices, axis: usize, first: usize, last: usize, parts: &mut [(Vec4, Vec4); BINS]) {
        for (p, q) in self.edges() {
            let (p, q) = if p[axis] <= q[axis] { (p, q) } else { (q, p) };
            let (from, to) = (slices.bin(p[axis], axis), slices.bin(q[axis], axis));
            for (corner, bin) in [(p, from), (q, to)] {
                if (first as i32..=last as i32).contains(&bin) {
                    grow(&mut parts[bin as usize], corner);
                }
            }
            if from == to {
                continue;
            }
            let step = (q - p) / (q[axis] - p[axis]);
            for border in (from + 1).max(first as i32) as usize..=to.min(last as i32 + 1).max(0) as usize {
                let on = p + step * (slices.border(axis, border) - p[axis]);
                if border > first {
                    grow(&mut parts[border - 1], on);
                }
                if border <= last {
                    grow(&mut parts[border], on);
                }
            }
        }
    }
}

/// The parts of a reference below and above a plane; either may be empty.
#[inline]
fn cut(mesh: &Mesh, r: &PrimRef, axis: usize, plane: f32) -> [PrimRef; 2] {
    let triangle = Triangle::new(mesh.corners(r.prim()));
    let (mut below, mut above) = (NOTHING, NOTHING);
    for (p, q) in triangle.edges() {
        if p[axis] <= plane {
            grow(&mut below, p);
        }
        if p[axis] >= plane {
            grow(&mut above, p);
        }
        if let Some(on) = crossing(p, q, axis, plane) {
            grow(&mut below, on);
            grow(&mut above, on);
        }
    }
    [below, above].map(|(lo, hi)| r.clipped(lo - triangle.pad, hi + triangle.pad))
}

/// Where an edge goes through a plane, if its ends are on different sides.
#[inline(always)]
fn crossing(p: Vec4, q: Vec4, axis: usize, plane: f32) -> Option<Vec4> {
    let (from, to) = (p[axis], q[axis]);
    ((from < plane) != (to < plane) && from != plane && to != plane).then(|| {
        let mut on = (p + (q - p) * ((plane - from) / (to - from))).max(p.min(q)).min(p.max(q));
        on[axis] = plane;
        on
    })
}

/// [`cut`] for cells without boxes of their own ([`super::Bsp`]): each part reaches as far beyond the plane as parts are padded.
#[inline]
pub(super) fn cut_for_cells(corners: [Vec3; 3], r: &PrimRef, axis: usize, plane: f32) -> [PrimRef; 2] {
    let triangle = Triangle::new(corners);
    let part = |limit: f32, is_in: fn(f32, f32) -> bool| {
        let mut part = NOTHING;
        for (p, q) in triangle.edges() {
            if is_in(p[axis], limit) {
                grow(&mut part, p);
            }
            if let Some(on) = crossing(p, q, axis, limit) {
                grow(&mut part, on);
            }
        }
        r.clipped(part.0 - triangle.pad, part.1 + triangle.pad)
    };
    let pad = triangle.pad[axis];
    [part(plane + pad, |x, limit| x <= limit), part(plane - pad, |x, limit| x >= limit)]
}

/// A plane, and what dividing references at it would give.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpatialSplit {
    axis: usize,
    plane: f32,
    /// Sum over both sides of half area times blocks.
    pub cost: f32,
    counts: [usize; 2],
    bounds: [Box4; 2],
}

/// Boxes of the parts of references in equal slices along each axis, and how many references begin and end there.
#[derive(Clone)]
struct Bins {
    boxes: [[Box4; BINS]; 3],
    begins: [[u32; BINS]; 3],
    ends: [[u32; BINS]; 3],
}

/// The slices of a box.
struct Slices {
    lo: Vec4,
    width: Vec4,
    scale: Vec4,
    count: usize,
}

impl Slices {
    /// Few references do not need many.
    fn new(bounds: &Box4, references: usize) -> Self {
        let count = (4 + references / 8).min(BINS);
        let width = bounds.extent() / count as f32;
        let scale = Vec4::select(width.cmpgt(Vec4::splat(1e-30)), width.recip(), Vec4::ZERO);
        Self { lo: bounds.lo(), width, scale, count }
    }

    /// Where slice `bin` begins.
    fn border(&self, axis: usize, bin: usize) -> f32 {
        self.lo[axis] + self.width[axis] * bin as f32
    }

    /// The slices that a box reaches from and to.
    #[inline(always)]
    fn reach(&self, r: &PrimRef, axis: usize) -> (usize, usize) {
        let bin = |x: f32| (((x - self.lo[axis]) * self.scale[axis]) as usize).min(self.count - 1);
        (bin(r.bounds().lo()[axis]), bin(r.bounds().hi()[axis]))
    }

    /// The slice of a coordinate, which may lie outside of them all.
    #[inline(always)]
    fn bin(&self, x: f32, axis: usize) -> i32 {
        let position = (x - self.lo[axis]) * self.scale[axis];
        // The cast rounds towards 0.
        if position < 0.0 { -1 } else { (position as i32).min(self.count as i32) }
    }
}

impl Bins {
    fn new() -> Self {
        Self { boxes: [[Box4::EMPTY; BINS]; 3], begins: [[0; BINS]; 3], ends: [[0; BINS]; 3] }
    }

    /// Counts a reference in all slices that its triangle reaches into.
    fn add(&mut self, mesh: &Mesh, r: &PrimRef, slices: &Slices) {
        let mut triangle = None;
        for axis in 0..3 {
            let (first, last) = slices.reach(r, axis);
            let (mut begin, mut end) = (first, last);
            if first == last {
                self.boxes[axis][first].grow(r.bounds());
            } else {
                let triangle = triangle.get_or_insert_with(|| Triangle::new(mesh.corners(r.prim())));
                let mut parts = [NOTHING; BINS];
                triangle.chop(slices, axis, first, last, &mut parts);
                (begin, end) = (last, first);
                for (bin, (lo, hi)) in (first..=last).zip(&parts[first..=last]) {
                    let here = r.clipped(*lo - triangle.pad, *hi + triangle.pad);
                    if here.is_usable() {
                        self.boxes[axis][bin].grow(here.bounds());
                        (begin, end) = (begin.min(bin), bin);
                    }
                }
            }
            self.begins[axis][begin] += 1;
            self.ends[axis][end] += 1;
        }
    }

    fn merge(mut self, other: Self) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.boxes[axis][bin].grow(&other.boxes[axis][bin]);
                self.begins[axis][bin] += other.begins[axis][bin];
                self.ends[axis][bin] += other.ends[axis][bin];
            }
        }
        self
    }

    /// The cheapest border that leaves no side empty.
    fn best(&self, slices: &Slices, count: usize) -> Option<SpatialSplit> {
        let mut best: Option<SpatialSplit> = None;
        for axis in 0..3 {
            if slices.scale[axis] == 0.0 {
                continue;
            }
            let mut above = [(Box4::EMPTY, 0); BINS];
            let (mut bounds, mut number) = (Box4::EMPTY, 0);
            for bin in (1..slices.count).rev() {
                bounds.grow(&self.boxes[axis][bin]);
                number += self.ends[axis][bin] as usize;
                above[bin] = (bounds, number);
            }
            let (mut bounds, mut number) = (Box4::EMPTY, 0);
            for (bin, &(beyond, others)) in above.iter().enumerate().take(slices.count).skip(1) {
                bounds.grow(&self.boxes[axis][bin - 1]);
                number += self.begins[axis][bin - 1] as usize;
                if number == 0 || others == 0 || (number == count && others == count) {
                    continue;
                }
                let cost = bounds.half_area() * blocks_of(number) + beyond.half_area() * blocks_of(others);
                if best.is_none_or(|b| cost < b.cost) {
                    let plane = slices.border(axis, bin);
                    best = Some(SpatialSplit { axis, plane, cost, counts: [number, others], bounds: [bounds, beyond] });
                }
            }
        }
        best
    }
}

/// The cheapest plane among equal slices of `bounds`, the box around `refs`.
pub(super) fn find_spatial_split(mesh: &Mesh, refs: &[PrimRef], bounds: &Box4) -> Option<SpatialSplit> {
    let slices = Slices::new(bounds, refs.len());
    let fill = |refs: &[PrimRef]| {
        let mut bins = Bins::new();
        refs.iter().for_each(|r| bins.add(mesh, r, &slices));
        bins
    };
    let bins = if refs.len() <= PARALLEL {
        fill(refs)
    } else {
        refs.par_chunks(CHUNK).map(fill).reduce_with(Bins::merge).expect("there are chunks")
    };
    bins.best(&slices, refs.len())
}

/// The references of both sides.
#[derive(Default)]
pub(super) struct Sides {
    pub below: Vec<PrimRef>,
    pub above: Vec<PrimRef>,
}

impl SpatialSplit {
    /// Divides references, cutting those on both sides unless leaving them whole on one side costs less (*reference unsplitting*, Stich et al.
    /// section 4.4, against the boxes and counts that the bins gave). None if there are more than `room` of them then, or no memory.
    pub fn divide(&self, mesh: &Mesh, refs: &[PrimRef], room: usize) -> Option<Sides> {
        let usable = |below: usize, above: usize| below + above <= room && below > 0 && above > 0;
        if refs.len() <= PARALLEL {
            return self.divide_chunk(mesh, refs).filter(|sides| usable(sides.below.len(), sides.above.len()));
        }
        let mut chunks: Vec<Option<Sides>> = vec_of(refs.len().div_ceil(CHUNK)).ok()?;
        refs.par_chunks(CHUNK).map(|refs| self.divide_chunk(mesh, refs)).collect_into_vec(&mut chunks);
        if chunks.iter().any(Option::is_none) {
            return None;
        }
        let below: usize = chunks.iter().flatten().map(|c| c.below.len()).sum();
        let above: usize = chunks.iter().flatten().map(|c| c.above.len()).sum();
        if !usable(below, above) {
            return None;
        }
        let mut all = Sides { below: vec_of(below).ok()?, above: vec_of(above).ok()? };
        for chunk in chunks.into_iter().flatten() {
            all.below.extend_from_slice(&chunk.below);
            all.above.extend_from_slice(&chunk.above);
        }
        Some(all)
    }

    fn divide_chunk(&self, mesh: &Mesh, refs: &[PrimRef]) -> Option<Sides> {
        let Self { axis, plane, counts, bounds, .. } = *self;
        let areas = bounds.map(|b| b.half_area());
        let mut sides = Sides { below: vec_of(refs.len()).ok()?, above: vec_of(refs.len()).ok()? };
        for r in refs {
            if r.bounds().hi()[axis] <= plane {
                sides.below.push(*r);
                continue;
            }
            if r.bounds().lo()[axis] >= plane {
                sides.above.push(*r);
                continue;
            }
            let [below, above] = cut(mesh, r, axis, plane);
            if !above.is_usable() {
                sides.below.push(*r);
                continue;
            }
            if !below.is_usable() {
                sides.above.push(*r);
                continue;
            }
            let grown = |side: usize| {
                let mut all = bounds[side];
                all.grow(r.bounds());
                all.half_area()
            };
            let [n_below, n_above] = counts.map(|n| n as f32);
            let both = areas[0] * n_below + areas[1] * n_above;
            let only_below = grown(0) * n_below + areas[1] * (n_above - 1.0);
            let only_above = areas[0] * (n_below - 1.0) + grown(1) * n_above;
            if both < only_below.min(only_above) {
                sides.below.push(below);
                sides.above.push(above);
            } else if only_below <= only_above {
                sides.below.push(*r);
            } else {
                sides.above.push(*r);
            }
        }
        Some(sides)
    }
}
