//! The visibility field (Khanna, Mortensen, Yu, Slater, *A Visibility Field for Dynamic Ray Tracing*, 2004).
//!
//! ```text
//! for some directions, the corners of a subdivided tetrahedron     directions
//!     a grid of tiles across the direction                         subfield
//!         the triangles that the tile's beam meets, by depth       raster
//! a ray: the nearest direction → the tiles along it → the triangles at its depths → the library's own test
//! ```
//!
//! *Resting and moving triangles* (§3). All triangles begin as resting ones: their tiles are ordered by depth, and searched in logarithmic time. Those that an update moves
//! become moving ones, in subfields of their own, whose lists are linear; what the ordered tiles say of them is out of date, and harmless,
//! since the test looks at where they are now. So an update costs O(moved): their corners, and one number that outdates all moving subfields. These are drawn again when a
//! ray asks. When more than half of what the ordered subfields hold has moved, or drawing triangles
//! that have come to rest has cost as much as new ordered subfields would, resting and moving ones are told apart anew.
//!
//! *Exact.* A subfield proposes, the library's triangle test decides. A ray's way through a subfield is not along its direction, so it drifts across tiles, all of which
//! are visited (`trace/traverse_field`): the paper projects both ends of the ray, "typically both end-points are in one tile", and we go on to the
//! tiles between. So the choice of the direction is a matter of speed alone; it needs no cone of directions and no triangle need be grown.
//!
//! *Measured* (`cargo bench --bench peers -- field --quick`; single rays, one thread of a busy machine, so the ratios count; Mrays/s of primary, shadow and bounce
//! rays). S4, a soup of 65,536: field 1.25, 0.71, 0.30; BSP 0.40, 0.26, 0.16; BVH 2.9, 1.8, 1.3. S6, cloth of 92,000: field 1.3, 1.4, 0.42; BSP of a moving object
//! 0.15, 0.44, 0.18; BVH 5.5, 4.1, 3.0. S1, 1.3 million, with coarse subfields only: field 0.23, 0.32, 0.08; BSP 0.80, 0.59, 0.44; BVH 3.5, 3.1, 2.6. So the field is faster
//! than a BSP that is built fast, slower than one built by SAH (S1, and the room of figure 2: 200 ms per frame against 102), and the BVH is two to seven times as
//! fast, on S1 ten to thirty. It holds 172 MiB for S4 and 228 for S6, the BVH 4 and 6. Figure 2: one body of 564 moving triangles among 51,000 resting ones costs 2.5 ms
//! per frame and 6 % more time for rays, or as an object of its own 0.8 ms and 14 %. Most of a ray's time are triangle tests. Tried: twice as many tiles, no gain; four times as many, a quarter to a third slower.
//!
//! *Where we differ.* Subfields are made when rays ask, in a budget of memory ([`subfields`]); the paper makes all of them first. A shear in place of a rotation
//! ([`subfield`]). Beams of both ways are one. A reference says which part of its tile a triangle covers.

mod directions;
mod links;
mod raster;
mod subfield;
mod subfields;

pub use directions::{Directions, MOST_LEVELS};
pub(crate) use raster::tile_of;
pub use subfield::{Frame, Subfield, TileList, TileRef};

use super::memory::filled;
use super::{Aabb, OutOfMemory, triangle_bounds};
use crate::memory::Room;
use crate::scene::Mesh;
use glam::Vec3;
use links::Links;
use rayon::prelude::*;
use subfield::Chosen;
use subfields::Subfields;

/// So many triangles are looked at one by one.
const FEW: usize = 12;
/// Triangles that are worked on together.
const CHUNK: usize = 4096;
/// Drawing an ordered subfield costs about as much as so many of moving triangles.
const ORDERED_COST: u64 = 3;

/// The triangles of one object and the subfields made of them so far.
#[derive(Debug)]
pub struct VisibilityField {
    corners: Vec<[Vec3; 3]>,
    /// Around everything that can be hit.
    bounds: Aabb,
    /// The largest side of a triangle's box.
    side: f32,
    resting: Subfields,
    moving: Subfields,
    /// Which triangles are moving ones, as a list and by number.
    movers: Vec<u32>,
    is_mover: Vec<bool>,
    /// Those that the last update moved, and how many there were in each chunk: room for the next.
    moved: Vec<u32>,
    counts: Vec<usize>,
    /// So many were moving ones when they were told apart; the others are still in the ordered subfields.
    first_movers: usize,
    /// Triangles that were moving ones and did not move, over all updates since then.
    wasted: u64,
    links: Option<Links>,
}

/// Where to look for the triangles that a ray may hit.
#[derive(Clone, Copy, Debug)]
pub enum Candidates<'a> {
    Nothing,
    Tiles(&'a Subfield),
    Listed(&'a [u32]),
    Every,
}

/// What a visibility field holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FieldSize {
    /// Subfields of resting triangles, and their references.
    pub resting: (usize, usize),
    /// Subfields of moving triangles, and their references.
    pub moving: (usize, usize),
    /// Moving triangles.
    pub movers: usize,
}

impl VisibilityField {
    /// Copies the triangles of `mesh`; subfields come with the rays. To be called inside the pool.
    ///
    /// # Errors
    /// No memory.
    pub fn new(mesh: &Mesh, old: Option<VisibilityField>) -> Result<Self, OutOfMemory> {
        let count = mesh.triangles.len();
        let (corners, is_mover) = old.map_or_else(Default::default, |old| (old.corners, old.is_mover));
        let mut corners = filled(corners, count, [Vec3::ZERO; 3])?;
        corners.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, corners)| {
            for (prim, to) in (chunk * CHUNK..).zip(corners) {
                *to = mesh.corners(prim as u32);
            }
        });
        let mut is_mover = filled(is_mover, count, false)?;
        is_mover.fill(false);
        let mut field = Self {
            corners,
            bounds: Aabb::EMPTY,
            side: 0.0,
            resting: Subfields::new(count, true)?,
            moving: Subfields::new(count, false)?,
            movers: Vec::new(),
            is_mover,
            moved: Vec::new(),
            counts: Vec::new(),
            first_movers: 0,
            wasted: 0,
            links: None,
        };
        field.measure();
        Ok(field)
    }

    /// Box and largest side of all triangles.
    fn measure(&mut self) {
        let none = (Aabb::EMPTY, 0.0f32);
        let both = |a: (Aabb, f32), b: (Aabb, f32)| (a.0.union(b.0), a.1.max(b.1));
        let chunks = self.corners.par_chunks(CHUNK);
        (self.bounds, self.side) = chunks.map(|c| c.iter().map(size).fold(none, both)).reduce(|| none, both);
    }

    /// Says that vertices have moved: `vertices`, or any. Returns how many triangles have, and None if it has to be made anew: there are others, or
    /// memory ran out. To be called inside the pool.
    pub(super) fn moved(&mut self, mesh: &Mesh, vertices: Option<&[u32]>) -> Option<usize> {
        if mesh.triangles.len() != self.corners.len() {
            return None;
        }
        self.follow(mesh, vertices).ok()
    }

    fn follow(&mut self, mesh: &Mesh, vertices: Option<&[u32]>) -> Result<usize, OutOfMemory> {
        match vertices {
            Some(vertices) => {
                let links = match self.links.take() {
                    Some(links) => links,
                    None => Links::new(mesh)?,
                };
                let triangles = self.links.insert(links).triangles_of(vertices)?;
                self.moved.clear();
                self.moved.room(triangles.len())?;
                for prim in triangles {
                    let now = mesh.corners(prim);
                    if !same(&now, &self.corners[prim as usize]) {
                        self.corners[prim as usize] = now;
                        let (bounds, side) = size(&now);
                        (self.bounds, self.side) = (self.bounds.union(bounds), self.side.max(side));
                        self.moved.push(prim);
                    }
                }
            }
            None => {
                self.follow_all(mesh)?;
                self.measure();
            }
        }
        let moved = std::mem::take(&mut self.moved);
        if !moved.is_empty() {
            self.tell_apart(&moved)?;
        }
        let count = moved.len();
        self.moved = moved;
        Ok(count)
    }

    /// Copies all corners, and returns which triangles have others now, in ascending order.
    fn follow_all(&mut self, mesh: &Mesh) -> Result<(), OutOfMemory> {
        let Self { corners, moved, counts, .. } = self;
        let chunks = corners.len().div_ceil(CHUNK);
        counts.clear();
        counts.room(chunks)?;
        counts.resize(chunks, 0);
        moved.clear();
        moved.room(corners.len())?;
        moved.resize(corners.len(), 0);
        let lists = moved.par_chunks_mut(CHUNK).zip(counts.par_iter_mut());
        corners.par_chunks_mut(CHUNK).zip(lists).enumerate().for_each(|(chunk, (corners, (moved, count)))| {
            for (prim, old) in ((chunk * CHUNK) as u32..).zip(corners) {
                let now = mesh.corners(prim);
                if !same(&now, old) {
                    *old = now;
                    moved[*count] = prim;
                    *count += 1;
                }
            }
        });
        let mut end = 0;
        for (chunk, &count) in counts.iter().enumerate() {
            moved.copy_within(chunk * CHUNK..chunk * CHUNK + count, end);
            end += count;
        }
        moved.truncate(end);
        Ok(())
    }

    /// Makes moving triangles of those that moved, and resting ones of the others if it is time for that.
    fn tell_apart(&mut self, moved: &[u32]) -> Result<(), OutOfMemory> {
        let count = self.corners.len();
        let fresh = moved.iter().filter(|&&prim| !self.is_mover[prim as usize]).count();
        self.wasted += (self.movers.len() + fresh - moved.len()) as u64;
        let calmed = self.wasted > ORDERED_COST * count as u64;
        if calmed {
            self.is_mover.fill(false);
            self.movers.clear();
            if self.movers.capacity() / 4 > moved.len() {
                self.movers.shrink_to(moved.len());
            }
        }
        let more = if calmed { moved.len() } else { fresh };
        self.movers.try_reserve(more).map_err(|_| OutOfMemory { bytes: more * size_of::<u32>() })?;
        for &prim in moved {
            if !std::mem::replace(&mut self.is_mover[prim as usize], true) {
                self.movers.push(prim);
            }
        }
        let stale = self.movers.len().saturating_sub(self.first_movers);
        if calmed || 2 * stale > count - self.first_movers {
            (self.first_movers, self.wasted) = (self.movers.len(), 0);
            self.resting.advance();
        } else {
            self.resting.rest();
        }
        self.moving.advance();
        self.moving.remake(&self.chosen_movers());
        Ok(())
    }

    /// An update has changed nothing.
    pub(super) fn rest(&mut self) {
        self.resting.rest();
        self.moving.rest();
    }

    fn chosen_movers(&self) -> Chosen<'_> {
        Chosen { corners: &self.corners, listed: Some(&self.movers), without: None }
    }

    fn chosen_resting(&self) -> Chosen<'_> {
        Chosen { corners: &self.corners, listed: None, without: Some(&self.is_mover) }
    }

    /// Where to look for resting triangles that a ray in direction `dir` may hit. Makes subfields.
    #[inline]
    pub fn resting(&self, dir: Vec3) -> Candidates<'_> {
        if self.corners.len() <= FEW {
            return Candidates::Every;
        }
        if self.movers.len() == self.corners.len() {
            return Candidates::Nothing;
        }
        self.resting.find(dir, &self.chosen_resting()).map_or(Candidates::Every, Candidates::Tiles)
    }

    /// Where to look for moving triangles that a ray in direction `dir` may hit. Makes subfields.
    #[inline]
    pub fn moving(&self, dir: Vec3) -> Candidates<'_> {
        if self.movers.is_empty() || self.corners.len() <= FEW {
            return Candidates::Nothing;
        }
        if self.movers.len() <= FEW {
            return Candidates::Listed(&self.movers);
        }
        let found = self.moving.find(dir, &self.chosen_movers());
        found.map_or(Candidates::Listed(&self.movers), Candidates::Tiles)
    }

    /// A box around everything that can be hit.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// No triangle's box has a longer side.
    #[inline(always)]
    pub fn side(&self) -> f32 {
        self.side
    }

    /// Corners of all triangles, those that no ray can hit included.
    #[inline(always)]
    pub fn corners(&self) -> &[[Vec3; 3]] {
        &self.corners
    }

    /// What is held now.
    pub fn size(&self) -> FieldSize {
        FieldSize { resting: self.resting.held(), moving: self.moving.held(), movers: self.movers.len() }
    }

    /// Subfields that rays have had drawn since [`VisibilityField::forget_touched`], and references written for that.
    pub(super) fn touched(&self) -> (u32, u64) {
        let (resting, moving) = (self.resting.made(), self.moving.made());
        (resting.0 + moving.0, resting.1 + moving.1)
    }

    pub(super) fn forget_touched(&mut self) {
        self.resting.forget_made();
        self.moving.forget_made();
    }

    /// Bytes held, capacity included.
    pub fn memory_bytes(&self) -> usize {
        self.corners.capacity() * size_of::<[Vec3; 3]>()
            + self.is_mover.capacity()
            + (self.movers.capacity() + self.moved.capacity()) * size_of::<u32>()
            + self.resting.memory_bytes()
            + self.moving.memory_bytes()
            + self.links.as_ref().map_or(0, Links::memory_bytes)
    }

    /// Checks that triangles are those of `mesh`, each either resting or moving, and in every subfield that is up to date where rays look for
    /// it. Describes the first violation.
    pub fn validate(&self, mesh: &Mesh) -> Result<(), String> {
        if self.corners.len() != mesh.triangles.len() {
            return Err(format!("{} triangles, the mesh has {}", self.corners.len(), mesh.triangles.len()));
        }
        for (prim, corners) in (0..).zip(&self.corners) {
            let (bounds, side) = size(corners);
            if !same(corners, &mesh.corners(prim)) || !self.bounds.contains(&bounds) || side > self.side {
                return Err(format!("triangle {prim} has other corners, or is not in the box"));
            }
        }
        let mut marked = vec![false; self.corners.len()];
        self.movers.iter().for_each(|&prim| marked[prim as usize] = true);
        if marked != self.is_mover || self.movers.len() > self.corners.len() {
            return Err("moving triangles are not those that are marked".into());
        }
        self.resting.validate(&self.chosen_resting()).map_err(|fault| format!("resting: {fault}"))?;
        self.moving.validate(&self.chosen_movers()).map_err(|fault| format!("moving: {fault}"))
    }
}

/// The box of a triangle, and its largest side.
#[inline(always)]
fn size(corners: &[Vec3; 3]) -> (Aabb, f32) {
    let bounds = triangle_bounds(*corners);
    (bounds, if bounds.is_empty() { 0.0 } else { bounds.extent().max_element() })
}

/// Whether corners are the same, bit for bit.
#[inline(always)]
fn same(a: &[Vec3; 3], b: &[Vec3; 3]) -> bool {
    let bits = |corners: &[Vec3; 3]| corners.map(|p| p.to_array().map(f32::to_bits));
    bits(a) == bits(b)
}
