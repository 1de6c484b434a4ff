//! One ray through a visibility field (Khanna04 §2).
//!
//! ```text
//! the nearest direction's subfield; the ray in its frame: a line that drifts across tiles as it goes down
//! column by column as the ray meets them, the rows between where it enters and leaves:
//!     the tile's list from the ray's depth on → those that cover the ray's place at their depth → the triangle test
//! stop when a column begins beyond the best hit
//! ```
//!
//! # Why no hit is lost
//!
//! Let a ray hit triangle T at `t` by the test, `X` be the point of T with the exact weights of the test's rounded edge functions, D the distance from the ray's origin
//! to the farthest corner of the box of all, u half an ulp. By the head of `accel/spatial`: the ray passes X, within `10 u D` per
//! axis, and `t` is where, but for `10 u D` and 1/8192 of T's side; clamping to T's box does not change this, as the ray is in that box there. So
//!
//! * the tile of X lists T, at the depth of X, with the part of the tile where X is: computed in f64, rounded outwards (`accel/visibility`);
//! * moving the ray's place by up to [`DRIFT`] D per axis it goes through that tile and depth: rows, columns and depths are looked at with that much
//!   to spare;
//! * cutting the ray at its ends, or at the best hit, with [`DRIFT`] D and 1/2048 of the largest side to spare, leaves that place in.
//!
//! A ray whose error is not small against a tile, from an origin far out, or one with a direction too small for reciprocals to be true, looks at all triangles.

use super::{Hit, PreparedRay, triangle};
use crate::accel::{Candidates, Frame, Subfield, TileRef, VisibilityField, tile_of};

/// How far a ray may pass from a point that it hits, as a part of the distance: 32 half ulps.
const DRIFT: f64 = 1.0 / (1 << 19) as f64;
/// How far a hit may be from that point along the ray, as a part of the triangle's side.
const ALONG: f64 = 1.0 / 2048.0;
/// Directions below this have reciprocals that are not (`trace/ray`).
const LEAST_DIRECTION: f64 = 1e-30;
/// Tiles that a ray's error may span.
const MOST_ERROR: f64 = 0.25;
/// Steps of a reference's cover per tile, and the last one.
const STEPS: f64 = 256.0;
const LAST_STEP: f32 = 255.0;
/// Ways across a tile, in steps, that f32 can tell.
const STEEPEST: f64 = 1e6;

/// The closest hit, by the contract of [`super::Kernels::intersect`].
pub(super) fn intersect(
    field: &VisibilityField,
    ray: &PreparedRay,
    object: u32,
    instance: u32,
    best: &mut Hit,
) -> bool {
    traverse::<false>(field, ray, object, instance, best)
}

/// Whether there is any hit, by the contract of [`super::Kernels::occluded`].
pub(super) fn occluded(field: &VisibilityField, ray: &PreparedRay) -> bool {
    traverse::<true>(field, ray, 0, 0, &mut Hit::none(ray.tmax))
}

fn traverse<const ANY: bool>(
    field: &VisibilityField,
    ray: &PreparedRay,
    object: u32,
    instance: u32,
    best: &mut Hit,
) -> bool {
    let Some(line) = Line::new(field, ray, best.t) else { return false };
    let mut search = Search::<ANY> { field, ray, object, instance, best, found: false };
    search.among(field.resting(ray.dir), &line) || search.among(field.moving(ray.dir), &line) || search.found
}

/// A ray in f64, cut to where it can hit anything.
struct Line {
    enter: f64,
    exit: f64,
    /// See the module head: across, in the object's units, and along, in units of `t`.
    drift: f64,
    along: f64,
    /// Its direction is too small.
    vague: bool,
}

impl Line {
    /// None if it misses the box of all.
    #[inline(always)]
    fn new(field: &VisibilityField, ray: &PreparedRay, end: f32) -> Option<Self> {
        let bounds = field.bounds();
        let mut distance = 0.0f64;
        for k in 0..3 {
            let org = f64::from(ray.org[k]);
            distance = distance.max(f64::from(bounds.hi[k]) - org).max(org - f64::from(bounds.lo[k]));
        }
        let drift = distance * DRIFT;
        let speed = f64::from(ray.dir.abs().max_element());
        let along = (drift + f64::from(field.side()) * ALONG) / speed;
        let (mut enter, mut exit) = (f64::from(ray.tmin) - along, f64::from(end) + along);
        for k in 0..3 {
            let (org, dir) = (f64::from(ray.org[k]), f64::from(ray.dir[k]));
            let (lo, hi) = (f64::from(bounds.lo[k]) - drift, f64::from(bounds.hi[k]) + drift);
            if dir == 0.0 {
                if org < lo || org > hi {
                    return None;
                }
                continue;
            }
            let inv = 1.0 / dir;
            let (a, b) = ((lo - org) * inv, (hi - org) * inv);
            enter = enter.max(a.min(b));
            exit = exit.min(a.max(b));
        }
        (!bounds.is_empty() && enter <= exit).then_some(Self {
            enter,
            exit,
            drift,
            along,
            vague: speed < LEAST_DIRECTION,
        })
    }
}

/// A line's place in a frame: at its origin, and per unit of `t`.
struct Path {
    at: [f64; 3],
    by: [f64; 3],
    /// The most that it may be off, in tiles and in units of depth.
    error: [f64; 3],
}

impl Path {
    #[inline(always)]
    fn new(frame: &Frame, ray: &PreparedRay, drift: f64) -> Self {
        // A place is moved by the shear as well, which is at most 1.
        let error = [2.0 * drift * frame.scale[0], 2.0 * drift * frame.scale[1], drift * frame.scale[2] + 1e-6];
        Self { at: frame.point(ray.org), by: frame.vector(ray.dir), error }
    }

    #[inline(always)]
    fn place(&self, axis: usize, t: f64) -> f64 {
        self.at[axis] + self.by[axis] * t
    }
}

/// What is looked for, and what has been found.
struct Search<'a, const ANY: bool> {
    field: &'a VisibilityField,
    ray: &'a PreparedRay,
    object: u32,
    instance: u32,
    best: &'a mut Hit,
    found: bool,
}

impl<const ANY: bool> Search<'_, ANY> {
    /// Returns whether the search is over.
    #[inline(always)]
    fn test(&mut self, prim: u32) -> bool {
        let Some(h) = triangle::intersect(self.ray, self.field.corners()[prim as usize]) else { return false };
        if ANY {
            return true;
        }
        if self.ray.excludes(h.t, self.instance, prim) {
            return false;
        }
        let hit = Hit { t: h.t, u: h.u, v: h.v, primitive: prim, object: self.object, instance: self.instance };
        self.found |= hit.replaces(self.best);
        false
    }

    /// Returns whether the search is over.
    #[inline(always)]
    fn among(&mut self, candidates: Candidates<'_>, line: &Line) -> bool {
        match candidates {
            Candidates::Nothing => false,
            Candidates::Tiles(subfield) => self.through(subfield, line),
            Candidates::Listed(prims) => prims.iter().any(|&prim| self.test(prim)),
            Candidates::Every => self.test_all(),
        }
    }

    #[cold]
    fn test_all(&mut self) -> bool {
        (0..self.field.corners().len() as u32).any(|prim| self.test(prim))
    }

    /// Returns whether the search is over.
    fn through(&mut self, subfield: &Subfield, line: &Line) -> bool {
        let (Some(frame), counts) = (subfield.frame(), subfield.counts()) else { return false };
        if counts[0] == 0 {
            return false;
        }
        let path = Path::new(frame, self.ray, line.drift);
        // Written so that NaN looks at everything.
        let clear = (0..2).all(|k| counts[k] == 1 || path.error[k] <= MOST_ERROR) && path.error[2] <= MOST_ERROR;
        if line.vague || !clear {
            return self.test_all();
        }
        // Columns are the slices between the borders that the ray meets most of; rows if those are more.
        let major = usize::from(path.by[1].abs() > path.by[0].abs());
        let minor = 1 - major;
        let (enter, mut exit) = (line.enter, line.exit.min(f64::from(self.best.t) + line.along));
        let (from, to) = (path.place(major, enter), path.place(major, exit));
        let forward = path.by[major] >= 0.0;
        let spare = if forward { path.error[major] } else { -path.error[major] };
        let (first, last) = (tile_of(from - spare, counts[major]), tile_of(to + spare, counts[major]));
        // Positive for -0 as well. What is not a number below, 0 times this, is passed over by `min` and `max`.
        let inv = if path.by[major] == 0.0 { f64::INFINITY } else { 1.0 / path.by[major] };
        let mut slice = first;
        loop {
            // The outermost slices of the way reach to its ends.
            let (near, far) = if forward { (slice, slice + 1) } else { (slice + 1, slice) };
            let begin = if slice == first { enter } else { (near as f64 - spare - path.at[major]) * inv };
            let end = if slice == last { exit } else { (far as f64 + spare - path.at[major]) * inv };
            let (begin, end) = (begin.max(enter), end.min(exit));
            if begin > exit {
                return false;
            }
            let (a, b) = (path.place(minor, begin), path.place(minor, end));
            let low = tile_of(a.min(b) - path.error[minor], counts[minor]);
            let high = tile_of(a.max(b) + path.error[minor], counts[minor]);
            for row in low..=high {
                let mut at = [slice; 2];
                at[minor] = row;
                if self.tile(subfield, &path, at, [begin, end]) {
                    return true;
                }
            }
            if slice == last {
                return false;
            }
            exit = exit.min(f64::from(self.best.t) + line.along);
            slice = if forward { slice + 1 } else { slice - 1 };
        }
    }

    /// The list of one tile, between two distances. Returns whether the search is over.
    #[inline(always)]
    fn tile(&mut self, subfield: &Subfield, path: &Path, at: [usize; 2], [begin, end]: [f64; 2]) -> bool {
        let list = subfield.list(at[0], at[1]);
        if list.unordered.is_empty() && list.ordered.is_empty() {
            return false;
        }
        let (from, to) = (path.place(2, begin), path.place(2, end));
        let (low, high) = ((from.min(to) - path.error[2]) as f32, (from.max(to) + path.error[2]) as f32);
        let beam = Beam::new(path, at);
        for r in list.unordered {
            if r.near <= high && r.far >= low && beam.meets(r) && self.test(r.prim) {
                return true;
            }
        }
        if list.ordered.is_empty() {
            return false;
        }
        if path.by[2] >= 0.0 {
            let start = list.ordered.partition_point(|r| r.near + list.reach < low);
            for r in &list.ordered[start..] {
                if r.near > high {
                    break;
                }
                if r.far >= low && beam.meets(r) && self.test(r.prim) {
                    return true;
                }
            }
        } else {
            let start = list.ordered.partition_point(|r| r.near <= high);
            for r in list.ordered[..start].iter().rev() {
                if r.near + list.reach < low {
                    break;
                }
                if r.far >= low && beam.meets(r) && self.test(r.prim) {
                    return true;
                }
            }
        }
        false
    }
}

/// The ray's place in a tile at a depth, in steps of a reference's cover.
struct Beam {
    at: [f32; 2],
    by: [f32; 2],
    spare: [f32; 2],
}

impl Beam {
    #[inline(always)]
    fn new(path: &Path, tile: [usize; 2]) -> Self {
        let mut beam = Beam { at: [0.0; 2], by: [0.0; 2], spare: [0.0; 2] };
        let inv = 1.0 / path.by[2];
        for (k, tile) in tile.into_iter().enumerate() {
            let by = path.by[k] * inv;
            let at = (path.at[k] - path.at[2] * by - tile as f64) * STEPS;
            let by = by * STEPS;
            // Written so that NaN, of a ray across the beam, meets everything.
            if at.abs() + by.abs() <= STEEPEST {
                let spare = (path.error[k] * STEPS + by.abs() * path.error[2]) + (at.abs() + by.abs()) * 1e-6;
                (beam.at[k], beam.by[k], beam.spare[k]) = (at as f32, by as f32, spare as f32 + 0.01);
            } else {
                beam.spare[k] = f32::INFINITY;
            }
        }
        beam
    }

    /// Whether it goes through the part that a reference covers, at the reference's depths.
    #[inline(always)]
    fn meets(&self, r: &TileRef) -> bool {
        let side = |k: usize| {
            let (a, b) = (self.at[k] + self.by[k] * r.near, self.at[k] + self.by[k] * r.far);
            let (low, high) = (if a < b { a } else { b }, if a < b { b } else { a });
            let (from, to) = (f32::from(r.covers[k]), f32::from(r.covers[k + 2]));
            ((low - self.spare[k]).min(LAST_STEP) <= to) & (high + self.spare[k] >= from)
        };
        side(0) & side(1)
    }
}
