//! What a thread renders tiles in.

use crate::frame::Tile;
use crate::memory::OutOfMemory;
use crate::shade::{CameraPacket, PixelPattern, Samples, WorkerMemory};
use crate::threads;
use crate::trace::RayPacket;
use glam::Vec4;

/// What one thread needs for a tile.
pub struct Desk {
    pub memory: WorkerMemory,
    pub camera: CameraPacket,
    pub samples: Samples,
    pub pattern: PixelPattern,
    pub sums: [Vec4; RayPacket::RAYS],
    /// A tile before samples were added to its averages.
    pub before: Tile,
}

impl Default for Desk {
    fn default() -> Self {
        Self {
            memory: WorkerMemory::default(),
            camera: CameraPacket::new(),
            samples: Samples::new(),
            pattern: PixelPattern::default(),
            sums: [Vec4::ZERO; RayPacket::RAYS],
            before: Tile::EMPTY,
        }
    }
}

/// The desks of a renderer.
pub type Desks = threads::Desks<Desk>;

/// Makes them ready for a frame of so many samples per pixel and with such blocks of parameters ([`crate::shade::ShadeScene::patches`]).
///
/// # Errors
/// No memory.
pub fn prepare(desks: &mut Desks, samples: u32, patches: (usize, usize)) -> Result<(), OutOfMemory> {
    desks.prepare(usize::MAX, |desk| {
        desk.samples.forget();
        desk.pattern.prepare(samples)?;
        desk.memory.prepare(patches)
    })
}
