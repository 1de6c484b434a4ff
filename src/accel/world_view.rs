//! What rays of one frame traverse: a tree over instances, instances over object structures (Wald03 §4.1, figure 3).
//!
//! Traversal changes nothing here but what a ray brings up to date on its way, so any number of threads may trace at a time. A snapshot is a second
//! owner of the view. An update that finds one makes another view, in which the structures of objects that do not change are the same ones
//! ([`ObjectAccel`]); so a snapshot costs memory for what has changed since, and the instances.

use super::Aabb;
use super::instance::InstanceRecord;
use super::object_accel::ObjectAccel;
use super::place::Placed;
use super::statics::Merged;
use super::top_level_bsp::TopLevelBsp;
use super::top_level_bvh::TopLevelBvh;
use crate::scene::TopLevelKind;
use crate::simd::Level;
use glam::Mat3;
use std::collections::TryReserveError;
use std::sync::Arc;

/// The structure over the instances that have a box; its references are indices of [`WorldView::instances`].
#[derive(Debug)]
pub enum TopLevel {
    Bsp(TopLevelBsp),
    Bvh(TopLevelBvh),
}

impl TopLevel {
    pub(super) fn kind(&self) -> TopLevelKind {
        match self {
            TopLevel::Bsp(_) => TopLevelKind::Bsp,
            TopLevel::Bvh(_) => TopLevelKind::Bvh,
        }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        match self {
            TopLevel::Bsp(bsp) => bsp.memory_bytes(),
            TopLevel::Bvh(bvh) => bvh.memory_bytes(),
        }
    }
}

impl Default for TopLevel {
    fn default() -> Self {
        TopLevel::Bvh(TopLevelBvh::default())
    }
}

/// See the module head.
pub struct WorldView {
    level: Level,
    /// By slot ([`InstanceRecord::slot`]).
    pub(super) objects: Vec<Arc<ObjectAccel>>,
    pub(super) merged: Option<Arc<Merged>>,
    pub(super) placed: Placed,
    pub(super) top_level: TopLevel,
    /// See [`WorldView::number_of`]; empty where all numbers are the same.
    numbers: Vec<u32>,
}

impl WorldView {
    /// An empty world, whose kernels are those of `level`.
    pub(super) fn new(level: Level) -> Self {
        let (placed, top_level) = (Placed::default(), TopLevel::default());
        Self { level, objects: Vec::new(), merged: None, placed, top_level, numbers: Vec::new() }
    }

    /// A view of the same objects, whose instances are to be placed.
    pub(super) fn successor(&self) -> Result<Self, TryReserveError> {
        let mut objects = Vec::new();
        objects.try_reserve(self.objects.len())?;
        objects.extend_from_slice(&self.objects);
        Ok(Self { objects, merged: self.merged.clone(), ..Self::new(self.level) })
    }

    /// The tree of the static instances that have been merged.
    #[inline(always)]
    pub fn merged(&self) -> Option<&Merged> {
        self.merged.as_deref()
    }

    /// The instruction set that was asked for.
    #[inline(always)]
    pub fn level(&self) -> Level {
        self.level
    }

    /// Objects by slot ([`InstanceRecord::slot`]).
    #[inline(always)]
    pub fn objects(&self) -> &[Arc<ObjectAccel>] {
        &self.objects
    }

    /// The instances of the frame that can be hit, in ascending order of their number; then the record of the merged tree, if there is one.
    #[inline(always)]
    pub fn instances(&self) -> &[InstanceRecord] {
        &self.placed.records
    }

    /// Where each of [`WorldView::instances`] can be hit by a ray from near the origin (see `accel/instance`); infinite for an
    /// outlier, empty for an instance in the merged tree.
    #[inline(always)]
    pub fn boxes(&self) -> &[Aabb] {
        &self.placed.boxes
    }

    /// Over the instances that have a box; its references are indices of [`WorldView::instances`].
    #[inline(always)]
    pub fn top_level(&self) -> &TopLevel {
        &self.top_level
    }

    /// The number by which the application knows the instance that hits call `instance`: they differ where composites have been resolved.
    #[inline]
    pub fn number_of(&self, instance: u32) -> u32 {
        self.numbers.get(instance as usize).copied().unwrap_or(instance)
    }

    /// Whether [`WorldView::number_of`] makes a difference.
    #[inline]
    pub fn has_numbers(&self) -> bool {
        !self.numbers.is_empty()
    }

    pub(super) fn set_numbers(&mut self, numbers: &[u32]) -> Result<(), TryReserveError> {
        self.numbers.try_reserve(numbers.len().saturating_sub(self.numbers.len()))?;
        self.numbers.clear();
        self.numbers.extend_from_slice(numbers);
        Ok(())
    }

    /// What rays can hit of the instance that the application knows by this number: one, or the parts of a composite.
    pub fn instances_of(&self, number: u32) -> impl Iterator<Item = &InstanceRecord> {
        // Numbers grow with the records.
        let records = &self.placed.records;
        let first = records.partition_point(|record| self.number_of(record.instance) < number);
        let same = records[first..].iter().take_while(move |record| self.number_of(record.instance) == number);
        same.filter(|record| record.object != 0)
    }

    /// Indices of instances that every ray has to be offered to.
    #[inline(always)]
    pub fn outliers(&self) -> &[u32] {
        &self.placed.outliers
    }

    /// Indices of instances with a box: those that the top level was built over.
    #[inline(always)]
    pub fn boxed(&self) -> &[u32] {
        &self.placed.boxed
    }

    /// World boxes hold for a ray whose planes are moved by this matrix times the magnitudes of its origin (see
    /// `accel/instance`).
    #[inline(always)]
    pub fn origin_error(&self) -> &Mat3 {
        &self.placed.origin_error
    }

    /// Whether some instances are met by rays as they are in the world: those in world space and merged ones.
    #[inline(always)]
    pub fn some_untransformed(&self) -> bool {
        self.placed.some_untransformed
    }

    /// What rays have had brought up to date since the last update, in objects of `RT_LAZY` and in those that waited for one: subtrees, and nodes in
    /// them; of `RT_VISIBILITY_FIELD`: subfields, and references in them.
    pub fn touched(&self) -> (u64, u64) {
        self.objects.iter().map(|object| object.touched()).fold((0, 0), |sum, (s, n)| (sum.0 + u64::from(s), sum.1 + n))
    }

    /// Bytes held by all structures, those of objects not in this frame included.
    pub(super) fn memory_bytes(&self) -> usize {
        self.objects.iter().map(|object| object.memory_bytes()).sum::<usize>()
            + self.merged.as_deref().map_or(0, Merged::memory_bytes)
            + self.top_level.memory_bytes()
            + self.placed.memory_bytes()
    }
}
