//! The instances of one frame, placed: inverse matrices, world boxes, and who is where.
//!
//! Everything here is per instance and per frame, so it is what a scene of many instances pays for moving (Wald03 §6). Instances
//! are independent, so many are placed in parallel, each at the index of its number; then those that draw
//! nothing, if there are any, are taken out. All vectors are kept.

use super::instance::{InstanceRecord, Reach, Space, invert, reach};
use super::{Aabb, OutOfMemory};
use crate::scene::{Instance, Mask};
use glam::{Affine3A, DMat3, Mat3, Vec3};
use rayon::prelude::*;

/// Fewer instances are placed by one thread.
const PARALLEL: usize = 1024;
/// Instances per task.
const CHUNK: usize = 256;

/// The box of outliers.
const EVERYWHERE: Aabb = Aabb { lo: Vec3::NEG_INFINITY, hi: Vec3::INFINITY };
const NOWHERE: InstanceRecord = InstanceRecord {
    instance: 0,
    slot: 0,
    object: 0,
    world_from_object: Affine3A::IDENTITY,
    space: Space::Merged,
    mask: Mask::ALL,
};

/// What the instances of a frame became.
#[derive(Debug, Default)]
pub(super) struct Placed {
    /// Those that can be hit, in ascending order of their number.
    pub records: Vec<InstanceRecord>,
    /// Per record; apart from them, as the build and the leaves of the top level read nothing else. Infinite for an outlier, empty
    /// for an instance that is merged.
    pub boxes: Vec<Aabb>,
    /// Indices of records without a box.
    pub outliers: Vec<u32>,
    /// Indices of records with a box.
    pub boxed: Vec<u32>,
    /// See [`super::WorldView::origin_error`].
    pub origin_error: Mat3,
    /// See [`super::WorldView::some_untransformed`].
    pub some_untransformed: bool,
    /// Of all records.
    pub triangles: u64,
    fates: Vec<Fate>,
}

/// What an object's slot tells of its instances: where they are, which rays see them, and how many triangles each has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seated {
    pub seat: Seat,
    pub mask: Mask,
    pub triangles: u64,
}

/// Where the triangles of an object's instances are.
#[derive(Clone, Copy, Debug)]
pub(super) enum Seat {
    /// The structure's box in object space.
    Object(Aabb),
    /// The structure's box in world space.
    World(Aabb),
    /// The triangles are in the merged tree.
    Merged,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fate {
    Boxed,
    Outlier,
    /// There, but rays find it by way of the merged tree.
    Merged,
    Nothing,
}

/// What is gathered over the instances.
struct Sum {
    error: DMat3,
    untransformed: bool,
    triangles: u64,
}

impl Sum {
    const ZERO: Sum = Sum { error: DMat3::ZERO, untransformed: false, triangles: 0 };

    fn join(self, other: Self) -> Self {
        Self {
            error: larger(self.error, other.error),
            untransformed: self.untransformed | other.untransformed,
            triangles: self.triangles + other.triangles,
        }
    }
}

impl Placed {
    pub fn memory_bytes(&self) -> usize {
        self.records.capacity() * size_of::<InstanceRecord>()
            + self.boxes.capacity() * size_of::<Aabb>()
            + (self.outliers.capacity() + self.boxed.capacity()) * size_of::<u32>()
            + self.fates.capacity()
    }

    pub fn clear(&mut self) {
        self.records.clear();
        self.boxes.clear();
        self.outliers.clear();
        self.boxed.clear();
        self.fates.clear();
        self.triangles = 0;
    }

    /// Places `instances`, whose objects are in the slots `slots`, of which `seat_of` tells.
    /// Instances without a slot (`u32::MAX`) or with empty bounds draw nothing, nor do those
    /// whose matrix is not finite. One that cannot be inverted must be in world space (see [`super::degenerate`]).
    ///
    /// # Errors
    /// No memory; there are no instances then.
    pub fn place(
        &mut self,
        instances: &[Instance],
        slots: &[u32],
        seat_of: impl Fn(u32) -> Seated + Sync,
    ) -> Result<(), OutOfMemory> {
        self.outliers.clear();
        self.boxed.clear();
        let Self { records, boxes, outliers, boxed, fates, .. } = self;
        let count = instances.len().min(slots.len());
        let reserved = records.try_reserve(count).and(boxes.try_reserve(count)).and(fates.try_reserve(count));
        let bytes = count.saturating_mul(size_of::<InstanceRecord>());
        if reserved.and(boxed.try_reserve(count)).is_err() {
            self.clear();
            return Err(OutOfMemory { bytes });
        }
        // What the frame before left is written over.
        records.resize(count, NOWHERE);
        boxes.resize(count, Aabb::EMPTY);
        fates.resize(count, Fate::Nothing);

        let (instances, slots) = (&instances[..count], &slots[..count]);
        let one = |number: usize, record: &mut InstanceRecord, aabb: &mut Aabb, sum: &mut Sum| {
            let (Instance { object, world_from_object, mask }, slot) = (instances[number], slots[number]);
            if slot == u32::MAX {
                return Fate::Nothing;
            }
            let Seated { seat, mask: of_object, triangles } = seat_of(slot);
            if matches!(seat, Seat::Object(b) | Seat::World(b) if b.is_empty()) {
                return Fate::Nothing;
            }
            let (space, fate) = match seat {
                // Nothing to transform, whatever the object is declared to be.
                Seat::Object(bounds) if world_from_object == Affine3A::IDENTITY => {
                    *aabb = bounds;
                    (Space::World, Fate::Boxed)
                }
                Seat::Object(bounds) => {
                    let Some(object_from_world) = invert(&world_from_object) else { return Fate::Nothing };
                    let space = Space::Object { object_from_world };
                    match reach(&bounds, &object_from_world) {
                        None => return Fate::Nothing,
                        Some(Reach::Outlier) => {
                            *aabb = EVERYWHERE;
                            (space, Fate::Outlier)
                        }
                        Some(Reach::Box { bounds, error: own }) => {
                            *aabb = bounds;
                            sum.error = larger(sum.error, own);
                            (space, Fate::Boxed)
                        }
                    }
                }
                Seat::World(bounds) => {
                    *aabb = bounds;
                    (Space::World, Fate::Boxed)
                }
                Seat::Merged => {
                    *aabb = Aabb::EMPTY;
                    (Space::Merged, Fate::Merged)
                }
            };
            sum.untransformed |= !matches!(space, Space::Object { .. });
            let mask = mask.and(of_object);
            *record = InstanceRecord { instance: number as u32, slot, object, world_from_object, space, mask };
            sum.triangles += triangles;
            fate
        };
        let chunk = |first: usize, records: &mut [InstanceRecord], boxes: &mut [Aabb], fates: &mut [Fate]| {
            let mut sum = Sum::ZERO;
            for (i, ((record, aabb), fate)) in records.iter_mut().zip(boxes).zip(fates).enumerate() {
                *fate = one(first + i, record, aabb, &mut sum);
            }
            sum
        };
        let sum = if count < PARALLEL {
            chunk(0, records, boxes, fates)
        } else {
            let parts = records.par_chunks_mut(CHUNK).zip(boxes.par_chunks_mut(CHUNK)).zip(fates.par_chunks_mut(CHUNK));
            parts
                .enumerate()
                .map(|(i, ((records, boxes), fates))| chunk(i * CHUNK, records, boxes, fates))
                .reduce(|| Sum::ZERO, Sum::join)
        };
        // Rounding to f32 is covered by the slack in the error's constant.
        self.origin_error = sum.error.as_mat3();
        self.some_untransformed = sum.untransformed;
        self.triangles = sum.triangles;

        if outliers.try_reserve(fates.iter().filter(|fate| matches!(fate, Fate::Outlier)).count()).is_err() {
            self.clear();
            return Err(OutOfMemory { bytes });
        }
        // Taking out is rare: one object that is not there, one matrix that is singular.
        let mut kept = 0;
        for i in 0..count {
            match fates[i] {
                Fate::Boxed => boxed.push(kept as u32),
                Fate::Outlier => outliers.push(kept as u32),
                Fate::Merged => {}
                Fate::Nothing => continue,
            }
            if kept < i {
                records[kept] = records[i];
                boxes[kept] = boxes[i];
            }
            kept += 1;
        }
        records.truncate(kept);
        boxes.truncate(kept);
        Ok(())
    }

    /// Adds the record of the merged tree, which has the box `bounds`.
    ///
    /// # Errors
    /// No memory; there are no instances then.
    pub fn add_merged(&mut self, bounds: Aabb) -> Result<(), OutOfMemory> {
        let Self { records, boxes, boxed, .. } = self;
        let reserved = records.try_reserve(1).and(boxes.try_reserve(1)).and(boxed.try_reserve(1));
        if reserved.is_err() {
            self.clear();
            return Err(OutOfMemory { bytes: self.memory_bytes() });
        }
        boxed.push(records.len() as u32);
        boxes.push(bounds);
        records.push(InstanceRecord { instance: u32::MAX, ..NOWHERE });
        Ok(())
    }
}

/// Component by component.
fn larger(a: DMat3, b: DMat3) -> DMat3 {
    DMat3::from_cols(a.x_axis.max(b.x_axis), a.y_axis.max(b.y_axis), a.z_axis.max(b.z_axis))
}
