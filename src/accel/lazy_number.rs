//! Numbers the vertices of a segment of a lazy tree, and outlines its blocks.

use super::OutOfMemory;
use super::bvh::BLOCK;
use super::lazy_cut::LazyBlock;
use super::memory::{ask, copied};
use crate::scene::Mesh;
use crate::simd::{FewPlaces, few_place_of, prefetch};

/// The vertices of a block, each once or more often, from the first of its segment on; or [`MANY`] if there are more than eight, or some are too far from it.
///
/// What is read of a block to write its box: a quarter of it, as four triangles that are neighbours have six vertices, and not twelve.
pub(super) type Outline = FewPlaces;

/// Blocks between asking for triangles and numbering their corners.
const AHEAD: usize = 6;

/// No place is odd.
pub(super) const MANY: Outline = [u16::MAX; 8];

/// Numbers vertices in the order of their first use: those of a leaf then are neighbours, which they rarely are in a mesh.
///
/// A hash table of the vertices of one segment stays in the nearest cache, where marks for those of the whole mesh would not (sorting, which was here before,
/// took four fifths of a cut's 120 ns per triangle). It begins small, as most vertices have six triangles.
#[derive(Default)]
pub(super) struct Distinct {
    /// Vertex and number; a power of two of them, more than there are vertices.
    table: Vec<(u32, u32)>,
    list: Vec<u32>,
}

impl Distinct {
    const FREE: (u32, u32) = (u32::MAX, 0);

    /// Gets ready for so many corners.
    fn begin(&mut self, corners: usize) -> Result<(), OutOfMemory> {
        self.list.clear();
        // Room for all that may come, so that none is asked for later.
        ask(&mut self.list, corners)?;
        ask(&mut self.table, (2 * corners).next_power_of_two())?;
        self.table.clear();
        self.table.resize((corners / 2).next_power_of_two(), Self::FREE);
        Ok(())
    }

    #[inline]
    fn number(&mut self, vertex: u32) -> u32 {
        let mask = self.table.len() - 1;
        let mut at = (vertex.wrapping_mul(0x9E37_79B1) >> 7) as usize & mask;
        loop {
            match self.table[at] {
                (known, number) if known == vertex => return number,
                Self::FREE => {
                    let number = self.list.len() as u32;
                    self.table[at] = (vertex, number);
                    self.list.push(vertex);
                    if 2 * self.list.len() > self.table.len() {
                        self.grow();
                    }
                    return number;
                }
                _ => at = (at + 1) & mask,
            }
        }
    }

    #[cold]
    fn grow(&mut self) {
        let size = 2 * self.table.len();
        self.table.clear();
        self.table.resize(size, Self::FREE);
        for (number, &vertex) in (0..).zip(&self.list) {
            let mut at = (vertex.wrapping_mul(0x9E37_79B1) >> 7) as usize & (size - 1);
            while self.table[at] != Self::FREE {
                at = (at + 1) & (size - 1);
            }
            self.table[at] = (vertex, number);
        }
    }

    /// The vertices of some blocks, each once, whose numbers these and their outlines get.
    pub fn number_corners(
        &mut self,
        mesh: &Mesh,
        blocks: &mut [LazyBlock],
        outlines: &mut [Outline],
    ) -> Result<Vec<u32>, OutOfMemory> {
        self.begin(blocks.len() * BLOCK * 3)?;
        for (i, outline) in outlines.iter_mut().enumerate() {
            for prim in blocks.get(i + AHEAD).map_or([0; BLOCK], |later| later.prims) {
                prefetch(&mesh.triangles, prim as usize);
            }
            let block = &mut blocks[i];
            for (lane, &prim) in block.prims.iter().enumerate() {
                if lane > 0 && prim == block.prims[lane - 1] {
                    // The block is not full.
                    block.corners.iter_mut().for_each(|row| row[lane] = row[lane - 1]);
                    continue;
                }
                for (corner, &vertex) in mesh.triangles[prim as usize].iter().enumerate() {
                    block.corners[corner][lane] = self.number(vertex);
                }
            }
            *outline = outline_of(&block.corners).unwrap_or(MANY);
        }
        copied(&self.list)
    }
}

/// The outline of a block, if it has one.
///
/// *Tried*: comparisons of whole vectors without branches. The cut took a seventh longer: a vector cannot be loaded at once from where one of its places has just been stored.
fn outline_of(corners: &[[u32; BLOCK]; 3]) -> Option<Outline> {
    let [first, ..] = *corners.as_flattened() else { return None };
    let mut outline = [few_place_of(first as usize)?; 8];
    let mut count = 1;
    for &number in &corners.as_flattened()[1..] {
        let place = few_place_of(number as usize)?;
        if !outline[..count].contains(&place) {
            *outline.get_mut(count)? = place;
            count += 1;
        }
    }
    Some(outline)
}
