//! One tile: camera samples to pixels.
//!
//! A tile is four packets of 8×8 pixels, whose rays are made, traced and shaded together (one per pixel at a time), in the order in which a block of the picture keeps its pixels. A frame of one
//! sample per pixel that averages nothing writes its pixels at once; sums are kept for the others only.
//!
//! Of a sub-sampled frame a tile holds nodes ([`crate::frame::Lattice`]) instead of neighbouring pixels: the packets are
//! packets still, of rays that are farther apart.

use super::desk::Desk;
use super::frameless::Turn;
use crate::frame::{BLOCK_PIXELS, Block, NO_INSTANCE, Pixel, TILE_SIZE, Tile, TileRect, block_place};
use crate::scene::{FrameDesc, Viewport};
use crate::shade::{Cone, PACKET_SIZE, RayCounts, Samples, Seen, ShadeScene, Wanted, Worker, place};
use crate::simd::{Level, bits, prefetch_at};
use crate::trace::{Hit, RayPacket, Tracer};
use glam::{Vec2, Vec4};
use std::sync::atomic::AtomicBool;

/// What all tiles of a frame share.
pub struct TileJob<'a> {
    pub scene: &'a ShadeScene<'a>,
    pub tracer: Tracer<'a>,
    pub frame: &'a FrameDesc,
    pub aspect: f32,
    pub cone: Cone,
    /// Raised by who does not want the frame any more.
    pub cancel: &'a AtomicBool,
    /// Pixels from one stored pixel to the next, and which pixel of the picture the first is.
    step: u32,
    base: [u32; 2],
    /// Sends primary rays only, whatever the frame asks for.
    primary_only: bool,
}

/// Packets along each side of a tile.
const PACKETS: u32 = TILE_SIZE / PACKET_SIZE;

impl<'a> TileJob<'a> {
    /// `step` 1 renders pixels of the picture; others render nodes of a lattice over the viewport, which begins at its corner.
    pub fn new(
        scene: &'a ShadeScene<'a>,
        tracer: Tracer<'a>,
        frame: &'a FrameDesc,
        step: u32,
        cancel: &'a AtomicBool,
    ) -> Self {
        let aspect = aspect(frame.viewport);
        // Samples share a pixel's footprint.
        let rows = frame.viewport.height.max(1) as f32 * (frame.samples.max(1) as f32).sqrt();
        let cone = scene.camera.cone(rows, aspect);
        let base = if step == 1 { [0, 0] } else { [frame.viewport.x, frame.viewport.y] };
        Self { scene, tracer, frame, aspect, cone, cancel, step, base, primary_only: false }
    }

    /// The same pixels as the rendering object `raycast` shows them, with one sample each.
    pub fn primary_only(&self) -> Self {
        let cone = self.scene.camera.cone(self.frame.viewport.height.max(1) as f32, self.aspect);
        Self { cone, primary_only: true, ..*self }
    }

    /// Whether there is nothing in the frame but what [`TileJob::primary_only`] shows.
    pub fn is_primary_only(&self) -> bool {
        self.frame.samples <= 1 && self.scene.is_primary_only()
    }

    /// Renders the pixels of `visible`, a part of the tile at `origin`, whose `turn` it is. `rounds` frames are already averaged in
    /// the tile; 0 overwrites it. None when the frame is cancelled meanwhile: then a tile of averages is as it was before, and another is new in part.
    pub fn render(
        &self,
        desk: &mut Desk,
        origin: [u32; 2],
        visible: TileRect,
        turn: Option<Turn>,
        rounds: u32,
        pixels: &mut Tile,
    ) -> Option<RayCounts> {
        let Desk { memory, camera, samples, pattern, sums, before } = desk;
        if rounds > 0 {
            before.clone_from(pixels);
        }
        let new = if self.primary_only { Worker::primary_only } else { Worker::new };
        let mut worker = new(self.scene, self.tracer, std::mem::take(memory)).until(self.cancel);
        let pattern = pattern.of(if self.primary_only { 1 } else { self.frame.samples }, rounds);
        let at_once = pattern.len() == 1 && rounds == 0;
        let Viewport { x, y, width, height } = self.frame.viewport;
        let size = Vec2::new(width as f32, height as f32);
        let last = [x + width - 1, y + height - 1];
        let from = |a: u32, b: u32| (i64::from(a) - i64::from(b)) as f32;
        'packets: for (packet, block) in (0..PACKETS * PACKETS).zip(&mut pixels.blocks) {
            let stored = [origin[0] + packet % PACKETS * PACKET_SIZE, origin[1] + packet / PACKETS * PACKET_SIZE];
            let mask = visible_places(stored, visible) & turn.map_or(u64::MAX, |turn| turn.places(stored));
            if mask == 0 {
                continue;
            }
            let pixel = [0, 1].map(|k| self.base[k] + stored[k] * self.step);
            for (i, &offset) in (0..).zip(pattern) {
                let number = rounds.wrapping_mul(pattern.len() as u32).wrapping_add(i);
                let corner = Vec2::new(from(pixel[0], x), from(pixel[1], y));
                let wanted = Wanted { pixel, corner, step: self.step, last, mask, number, offset };
                if i == 0 {
                    // Written by the end of the packet: until then the lines are here.
                    prefetch_at(block);
                }
                camera.aim(&self.scene.camera, self.level(), &wanted, size, self.aspect);
                worker.samples(camera, self.cone, samples);
                if worker.is_cancelled() {
                    break 'packets;
                }
                self.clear(samples, mask & !camera.mask);
                if at_once {
                    show(samples, mask, block);
                    self.number_instances(mask, block);
                    continue;
                }
                for slot in bits(mask) {
                    if i == 0 {
                        block.set(slot, look(block.color(slot), samples.seen(slot)));
                        sums[slot] = Vec4::ZERO;
                    }
                    sums[slot] += samples.color(slot);
                }
            }
            self.number_instances(mask, block);
            if !at_once {
                for slot in bits(mask) {
                    let color = sums[slot] / pattern.len() as f32;
                    let before = Vec4::from_array(block.color(slot));
                    let mean = if rounds == 0 { color } else { before + (color - before) / (rounds as f32 + 1.0) };
                    block.set_color(slot, mean.to_array());
                }
            }
        }
        let counts = (!worker.is_cancelled()).then_some(worker.counts);
        *memory = worker.into_memory();
        if counts.is_none() && rounds > 0 {
            pixels.clone_from(before);
        }
        counts
    }

    fn level(&self) -> Level {
        self.tracer.world().level()
    }

    /// Gives the instances that have just been stored the numbers by which the application knows them.
    fn number_instances(&self, mask: u64, block: &mut Block) {
        let list = self.scene.list();
        if !list.numbers.is_empty() {
            bits(mask).for_each(|slot| block.instance[slot] = list.number_of(block.instance[slot]));
        }
    }

    /// The samples that the camera leaves clear.
    fn clear(&self, samples: &mut Samples, mask: u64) {
        if mask != 0 {
            let clear = Vec4::from_array(self.frame.clear_color);
            bits(mask).for_each(|slot| samples.set_clear(slot, clear));
        }
    }
}

/// The places of a packet, whose lower left pixel is `pixel`, that can be seen.
fn visible_places(pixel: [u32; 2], visible: TileRect) -> u64 {
    let packet = TileRect { x0: pixel[0], y0: pixel[1], x1: pixel[0] + PACKET_SIZE, y1: pixel[1] + PACKET_SIZE };
    let part = packet.intersection(visible);
    if part == packet {
        return u64::MAX;
    }
    (0..RayPacket::RAYS).fold(0, |mask, slot| {
        let [x, y] = [pixel[0] + place(slot)[0], pixel[1] + place(slot)[1]];
        let inside = part.x0 <= x && x < part.x1 && part.y0 <= y && y < part.y1;
        mask | u64::from(inside) << slot
    })
}

/// A packet is a block of the picture, sample by sample, and what has no instance says so in the same way.
const _: () = {
    assert!(RayPacket::RAYS == BLOCK_PIXELS && Hit::NO_INSTANCE == NO_INSTANCE);
    let mut slot = 0;
    while slot < BLOCK_PIXELS {
        let ([x, y], [column, row]) = (place(slot), block_place(slot));
        assert!(x == column && y == row);
        slot += 1;
    }
};

/// Makes pixels what their samples are.
#[inline(always)]
fn show(samples: &Samples, mask: u64, block: &mut Block) {
    if mask == u64::MAX {
        let planes = samples.planes();
        for (to, from) in block.color.iter_mut().zip(planes.color) {
            *to = *from;
        }
        block.depth = *planes.distance;
        for (to, from) in block.normal.iter_mut().zip(planes.normal) {
            *to = *from;
        }
        (block.object, block.instance) = (*planes.object, *planes.instance);
    } else {
        for slot in bits(mask) {
            block.set(slot, look(samples.color(slot).to_array(), samples.seen(slot)));
        }
    }
}

/// Width over height of a viewport.
pub fn aspect(viewport: Viewport) -> f32 {
    viewport.width.max(1) as f32 / viewport.height.max(1) as f32
}

#[inline(always)]
fn look(color: [f32; 4], seen: Option<Seen>) -> Pixel {
    match seen {
        Some(seen) => Pixel {
            color,
            depth: seen.distance,
            normal: seen.normal.to_array(),
            object: seen.object,
            instance: seen.instance,
        },
        None => Pixel { color, ..Pixel::EMPTY },
    }
}
