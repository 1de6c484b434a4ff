//! The passes of a frame over its tiles.
//!
//! A frame without a budget is one pass: every tile gets all that it asks for. A frame with a budget is traced breadth-first, so that all primary rays
//! are sent before any shadow, reflection or refraction ray (Larsson and Akenine-Möller 2003, §5, *time-critical ray tracing*): a first pass renders every
//! tile as the rendering object `raycast` would, with one sample per pixel, and delivers it; a second one renders tiles anew in full until the time is up. So
//! the frame is a complete picture whenever it ends. Tiles in the middle of the picture come first, in every frame the same, so that
//! the border between refined and other tiles does not jump about; while frames are averaged, tiles that have had least come before.
//!
//! Cost: a refined tile has its primary rays traced and shaded twice. A frame that is refined to its end takes half as many instructions again as one
//! without a budget (`c_examples/build/bodies --triangles 720 --size 320x240`, counted by callgrind: 112 million for the first pass, 221 for a
//! frame, 333 for both). Keeping the hits of all pixels would save part of it at 24 bytes for each, and helps only frames that reach most tiles.

use super::desk::Desks;
use super::frameless::Turn;
use super::tile::TileJob;
use crate::frame::{self, Framebuffer, Target, TileGrid, TileRect};
use crate::memory::{OutOfMemory, Room, emptied};
use crate::shade::RayCounts;
use rayon::prelude::*;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};

/// What a pass has done.
#[derive(Clone, Copy, Default)]
pub struct Counts {
    pub rays: RayCounts,
    /// Tiles left out because the frame was cancelled.
    pub skipped: u64,
}

impl Counts {
    pub fn plus(self, other: Self) -> Self {
        Self {
            rays: RayCounts {
                primary: self.rays.primary + other.rays.primary,
                shadow: self.rays.shadow + other.rays.shadow,
                secondary: self.rays.secondary + other.rays.secondary,
            },
            skipped: self.skipped + other.skipped,
        }
    }
}

/// What all passes of a frame share.
pub struct Passes<'a> {
    /// The part of the framebuffer that is rendered.
    pub wanted: TileRect,
    pub turn: Option<Turn>,
    pub target: Option<&'a Target>,
    pub desks: &'a Desks,
}

/// A tile: its pixels, and the samples that are averaged in them.
type Tile<'f> = (usize, (&'f mut frame::Tile, &'f mut u32));

/// The memory of a list of tiles, kept from frame to frame.
#[derive(Default)]
pub struct Order(Vec<Option<Tile<'static>>>);

impl Order {
    /// Makes room for so many tiles.
    ///
    /// # Errors
    /// No memory.
    pub fn prepare(&mut self, tiles: usize) -> Result<(), OutOfMemory> {
        self.0.room(tiles)
    }
}

impl Passes<'_> {
    /// Renders all tiles in full.
    pub fn all(&self, fb: &mut Framebuffer, job: &TileJob<'_>) -> Counts {
        let grid = fb.grid();
        tiles(fb).map(|tile| self.tile(job, grid, tile, true)).reduce(Counts::default, Counts::plus)
    }

    /// Renders the tiles that hold nothing of the frame's picture, by primary rays; they still count as holding nothing.
    pub fn primary(&self, fb: &mut Framebuffer, job: &TileJob<'_>) -> Counts {
        let grid = fb.grid();
        tiles(fb)
            .filter(|(_, (_, rounds))| **rounds == 0)
            .map(|tile| self.tile(job, grid, tile, false))
            .reduce(Counts::default, Counts::plus)
    }

    /// Renders tiles in full, one after the other, until `time_is_up`. `order` has room for them all.
    pub fn refine(
        &self,
        fb: &mut Framebuffer,
        job: &TileJob<'_>,
        order: &mut Order,
        time_is_up: &(dyn Fn() -> bool + Sync),
    ) -> Counts {
        let grid = fb.grid();
        let (tiles, rounds) = fb.tiles_mut();
        let mut list: Vec<Option<Tile>> = emptied(std::mem::take(&mut order.0));
        let all = tiles.iter_mut().zip(rounds).enumerate();
        list.extend(all.filter(|(index, _)| !grid.rect(*index).intersection(self.wanted).is_empty()).map(Some));
        let middle = |a: u32, b: u32| i64::from(a) + i64::from(b);
        let (x, y) = (middle(self.wanted.x0, self.wanted.x1), middle(self.wanted.y0, self.wanted.y1));
        list.sort_unstable_by_key(|tile| {
            tile.as_ref().map(|(index, (_, rounds))| {
                let rect = grid.rect(*index);
                let (dx, dy) = (middle(rect.x0, rect.x1) - x, middle(rect.y0, rect.y1) - y);
                (**rounds, dx * dx + dy * dy, *index)
            })
        });
        // Handed out in their order, whatever the number of threads.
        let rest = Mutex::new(list.iter_mut());
        let next = || rest.lock().unwrap_or_else(PoisonError::into_inner).next().and_then(Option::take);
        let one_thread = |_| {
            let mut counts = Counts::default();
            while let Some(tile) = next().filter(|_| !time_is_up()) {
                counts = counts.plus(self.tile(job, grid, tile, true));
            }
            counts
        };
        let threads = (0..rayon::current_num_threads()).into_par_iter().with_max_len(1);
        let counts = threads.map(one_thread).reduce(Counts::default, Counts::plus);
        order.0 = emptied(list);
        counts
    }

    /// Renders a tile and delivers it. `counts` says that it is averaged, and holds the frame's picture then.
    fn tile(&self, job: &TileJob<'_>, grid: TileGrid, (index, (pixels, rounds)): Tile, counts: bool) -> Counts {
        let rect = grid.rect(index);
        let visible = rect.intersection(self.wanted);
        if visible.is_empty() {
            return Counts::default();
        }
        const SKIPPED: Counts = Counts { rays: RayCounts { primary: 0, shadow: 0, secondary: 0 }, skipped: 1 };
        if job.cancel.load(Ordering::Relaxed) {
            return SKIPPED;
        }
        let origin = [rect.x0, rect.y0];
        let rays = self.desks.at_one(|desk| job.render(desk, origin, visible, self.turn, *rounds, pixels));
        let Some(rays) = rays else { return SKIPPED };
        if counts {
            *rounds = rounds.saturating_add(1);
        }
        if let Some(target) = self.target {
            target.write_rect(visible, job.frame.srgb, |x, y| pixels.color(x - rect.x0, y - rect.y0));
        }
        Counts { rays, skipped: 0 }
    }

    /// The share of the wanted pixels whose tiles hold the frame's picture.
    pub fn refined(&self, fb: &mut Framebuffer) -> f64 {
        let grid = fb.grid();
        let area = |r: TileRect| if r.is_empty() { 0 } else { u64::from(r.x1 - r.x0) * u64::from(r.y1 - r.y0) };
        let held = fb.tiles_mut().1.iter().enumerate().filter(|(_, rounds)| **rounds > 0);
        let held: u64 = held.map(|(index, _)| area(grid.rect(index).intersection(self.wanted))).sum();
        held as f64 / area(self.wanted) as f64
    }
}

fn tiles(fb: &mut Framebuffer) -> impl IndexedParallelIterator<Item = Tile<'_>> {
    let (tiles, rounds) = fb.tiles_mut();
    tiles.par_iter_mut().zip(rounds.par_iter_mut()).enumerate()
}
