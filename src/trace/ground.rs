//! What [`super::turns`] and [`super::traverse_bvh`] ask of a tree.

use super::traverse_packet::Nodes;
use crate::accel::{Bvh, ChildRef, Node8, Tri4};
use std::ops::Deref;

/// A tree with blocks below its leaves.
pub(super) trait Blocks: Nodes {
    /// The blocks of a leaf that leads to them.
    ///
    /// # Safety
    /// - It is a leaf of the tree, and has been reached.
    unsafe fn blocks(&self, leaf: ChildRef) -> impl Iterator<Item = impl Deref<Target = Tri4>>;
}

/// The tree that rays take turns in.
pub(super) trait Ground: Blocks {
    /// Where a leaf leads that has been reached.
    ///
    /// # Safety
    /// - It is a leaf of the tree.
    #[inline(always)]
    unsafe fn lead(&self, _leaf: ChildRef) -> Lead {
        Lead::Blocks
    }

    /// [`Blocks::blocks`], of which the first is `at` an address.
    ///
    /// # Safety
    /// - As there.
    #[inline(always)]
    unsafe fn blocks_at(&self, leaf: ChildRef, _at: *const u8) -> impl Iterator<Item = impl Deref<Target = Tri4>> {
        // SAFETY: the caller's promise.
        unsafe { self.blocks(leaf) }
    }

    /// Where nodes and blocks begin, and how many bytes a block takes.
    fn beginnings(&self) -> (*const Node8, *const u8, usize);
}

/// See [`Ground::lead`].
pub(super) enum Lead {
    Blocks,
    On(ChildRef),
    /// The ray has to be traced in another way.
    Elsewhere,
}

/// A [`Bvh`]: all of it is up to date, and every leaf is of blocks.
pub(super) struct Plain<'a> {
    nodes: &'a [Node8],
    blocks: &'a [Tri4],
}

impl<'a> Plain<'a> {
    #[inline(always)]
    pub(super) fn new(bvh: &'a Bvh) -> Self {
        Self { nodes: bvh.nodes(), blocks: bvh.blocks() }
    }
}

impl Nodes for Plain<'_> {
    #[inline(always)]
    unsafe fn node(&self, index: usize) -> &Node8 {
        // SAFETY: the caller's promise.
        unsafe { self.nodes.get_unchecked(index) }
    }
}

impl Blocks for Plain<'_> {
    #[inline(always)]
    unsafe fn blocks(&self, leaf: ChildRef) -> impl Iterator<Item = impl Deref<Target = Tri4>> {
        // SAFETY: the caller's promise.
        unsafe { self.blocks.get_unchecked(leaf.blocks()).iter() }
    }
}

impl Ground for Plain<'_> {
    #[inline(always)]
    unsafe fn blocks_at(&self, leaf: ChildRef, at: *const u8) -> impl Iterator<Item = impl Deref<Target = Tri4>> {
        // SAFETY: the caller's promise.
        unsafe { std::slice::from_raw_parts(at.cast::<Tri4>(), leaf.blocks().len()).iter() }
    }

    #[inline(always)]
    fn beginnings(&self) -> (*const Node8, *const u8, usize) {
        (self.nodes.as_ptr(), self.blocks.as_ptr().cast(), size_of::<Tri4>())
    }
}
