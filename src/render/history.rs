//! What a frame can go on from: what was averaged, what is shown, and whose turn it is.
//!
//! Frames of an unchanged scene may be averaged, and may refine what is there (`progressive`): blocks of pixels that are sampled once get half as
//! long from frame to frame (10, 5, 2, 1) until every pixel is sampled, and then samples are averaged. Whatever changes the picture begins anew.
//! Interpolated pixels are replaced, never averaged: the nodes of one step are a handful of the next one's.

use super::frameless::Turn;
use crate::memory::{OutOfMemory, copy_into};
use crate::scene::{FrameDesc, Viewport};

/// What the pixels that are stored belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stored {
    size: [u32; 2],
    viewport: Viewport,
    step: u32,
}

/// What is known of the frames before.
#[derive(Default)]
pub struct History {
    /// What the tiles' averages belong to, if there are any.
    averaged: FrameDesc,
    epoch: u64,
    averages: bool,
    /// Frames since then that were not cancelled.
    frames: u32,
    stored: Option<Stored>,
    /// All stored pixels have been rendered, if not by the last frame.
    complete: bool,
    /// All tiles have had at least their primary rays, in the scene that is averaged.
    primary: bool,
    /// Turns of frameless rendering since the picture was complete.
    turns: u32,
}

/// How the next frame is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// See [`FrameDesc::subsampling`].
    pub step: u32,
    /// Tiles may be averaged with what they hold.
    pub continues: bool,
    /// Tiles that hold nothing still want their primary rays, if the frame has a budget.
    pub wants_primary: bool,
    /// None renders every pixel.
    pub turn: Option<Turn>,
}

impl History {
    /// Plans `frame`, of a scene with this `epoch`. [`History::ended`] must follow.
    ///
    /// # Errors
    /// No memory; nothing can be gone on with then.
    pub fn plan(&mut self, epoch: u64, frame: &FrameDesc) -> Result<Plan, OutOfMemory> {
        let averages = (frame.accumulate || frame.progressive) && frame.frameless <= 1;
        let same = averages && self.averages && self.epoch == epoch && same_picture(&self.averaged, frame);
        if !same {
            (self.averages, self.epoch, self.frames) = (false, epoch, 0);
            if averages {
                copy_frame(&mut self.averaged, frame)?;
                self.averages = true;
            }
        }
        let halvings = if frame.progressive && averages { self.frames.min(31) } else { 0 };
        let step = (frame.subsampling >> halvings).max(1);
        let stored = Some(Stored { size: frame.size, viewport: frame.viewport, step });
        let kept = self.stored == stored;
        self.stored = stored;
        self.complete &= kept;
        let continues = same && kept;
        self.primary &= continues;
        let turn = (frame.frameless > 1 && self.complete)
            .then(|| Turn { number: self.turns % frame.frameless, cycle: frame.frameless });
        if turn.is_none() {
            self.turns = 0;
        }
        Ok(Plan { step, continues, wants_primary: !self.primary, turn })
    }

    /// The frame that was planned has ended: by itself, or cancelled.
    pub fn ended(&mut self, plan: &Plan, cancelled: bool) {
        if cancelled {
            return;
        }
        self.complete = true;
        self.primary = true;
        self.frames = self.frames.saturating_add(1);
        self.turns += u32::from(plan.turn.is_some());
    }
}

/// Makes `to` a copy of a frame, in the memory of its lists.
fn copy_frame(to: &mut FrameDesc, frame: &FrameDesc) -> Result<(), OutOfMemory> {
    let FrameDesc { mut instances, mut lights, .. } = std::mem::take(to);
    copy_into(&mut instances, &frame.instances)?;
    copy_into(&mut lights, &frame.lights)?;
    *to = frame.with_lists(instances, lights);
    Ok(())
}

/// Whether two frames of an unchanged scene show the same, so that their samples may be averaged.
fn same_picture(a: &FrameDesc, b: &FrameDesc) -> bool {
    let settings = |f: &FrameDesc| {
        (f.camera, f.environment, f.renderer, f.clear_color, f.size, f.viewport, f.samples, f.max_depth, f.subsampling)
    };
    let same = |(a, b): (&crate::scene::Instance, &crate::scene::Instance)| {
        a.object == b.object && a.world_from_object == b.world_from_object && a.mask == b.mask
    };
    settings(a) == settings(b)
        && a.lights == b.lights
        && a.instances.len() == b.instances.len()
        && a.instances.iter().zip(&b.instances).all(same)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(subsampling: u32) -> FrameDesc {
        FrameDesc { subsampling, ..FrameDesc::default() }
    }

    fn plan(history: &mut History, epoch: u64, frame: &FrameDesc, cancelled: bool) -> Plan {
        let plan = history.plan(epoch, frame).expect("memory");
        history.ended(&plan, cancelled);
        plan
    }

    #[test]
    fn progressive_frames_halve_the_blocks_then_average_and_begin_anew_on_a_change() {
        let mut history = History::default();
        let wanted = FrameDesc { progressive: true, ..frame(10) };
        let steps = |history: &mut History, epoch, n| {
            (0..n).map(|_| plan(history, epoch, &wanted, false)).map(|p| (p.step, p.continues)).collect::<Vec<_>>()
        };
        assert_eq!(steps(&mut history, 1, 6), [(10, false), (5, false), (2, false), (1, false), (1, true), (1, true)]);
        assert_eq!(steps(&mut history, 2, 2), [(10, false), (5, false)]);
        // A cancelled frame is made again.
        assert_eq!(plan(&mut history, 2, &wanted, true).step, 2);
        assert_eq!(steps(&mut history, 2, 3), [(2, true), (1, false), (1, true)]);
        let other = FrameDesc { max_depth: 1, ..wanted.clone() };
        assert_eq!(plan(&mut history, 2, &other, false).step, 10);
    }

    #[test]
    fn a_frameless_cycle_begins_after_a_complete_picture() {
        let mut history = History::default();
        let wanted = FrameDesc { frameless: 3, accumulate: true, ..frame(1) };
        assert_eq!(plan(&mut history, 1, &wanted, true).turn, None, "nothing to keep");
        assert_eq!(plan(&mut history, 1, &wanted, false).turn, None, "the complete picture was cancelled");
        let mut numbers = Vec::new();
        for epoch in 0..7 {
            let plan = plan(&mut history, epoch, &wanted, false);
            assert!(!plan.continues && plan.step == 1);
            numbers.push(plan.turn.map(|turn| (turn.number, turn.cycle)));
        }
        assert_eq!(numbers, [0, 1, 2, 0, 1, 2, 0].map(|number| Some((number, 3))));
        let larger = FrameDesc { size: [7, 7], ..wanted.clone() };
        assert_eq!(plan(&mut history, 7, &larger, false).turn, None);
        assert_eq!(plan(&mut history, 7, &larger, false).turn, Some(Turn { number: 0, cycle: 3 }));
        plan(&mut history, 7, &frame(1), true);
        assert_eq!(plan(&mut history, 7, &wanted, false).turn, None, "the complete picture was cancelled");
        plan(&mut history, 7, &frame(1), false);
        assert_eq!(plan(&mut history, 7, &wanted, false).turn, Some(Turn { number: 0, cycle: 3 }));
    }

    #[test]
    fn primary_rays_are_wanted_once_per_picture() {
        let mut history = History::default();
        let wanted = FrameDesc { accumulate: true, ..frame(1) };
        let primary = [1, 1, 1, 2, 2].map(|epoch| plan(&mut history, epoch, &wanted, false).wants_primary);
        assert_eq!(primary, [true, false, false, true, false]);
        let moving = [2, 2].map(|epoch| plan(&mut history, epoch, &frame(1), false).wants_primary);
        assert_eq!(moving, [true, true]);
    }
}
