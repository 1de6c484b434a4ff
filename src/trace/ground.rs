//! What [`super::turns`] asks of a tree.

use super::traverse_packet::Nodes;
use crate::accel::{Bvh, ChildRef, Node8, Tri4};
use std::ops::Deref;

/// The tree that rays take turns in.
pub(super) trait Ground: Nodes {
    /// Where a leaf leads that has been reached.
    ///
    /// # Safety
    /// - It is a leaf of the tree.
    #[inline(always)]
    unsafe fn lead(&self, _leaf: ChildRef) -> Lead {
        Lead::Blocks
    }

    /// The blocks of a leaf that leads to them.
    ///
    /// # Safety
    /// - It is a leaf of the tree, and has been reached.
    unsafe fn blocks(&self, leaf: ChildRef) -> impl Iterator<Item = impl Deref<Target = Tri4>>;

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

impl Ground for Bvh {
    #[inline(always)]
    unsafe fn blocks(&self, leaf: ChildRef) -> impl Iterator<Item = impl Deref<Target = Tri4>> {
        // SAFETY: the caller's promise.
        unsafe { Bvh::blocks(self).get_unchecked(leaf.blocks()).iter() }
    }

    #[inline(always)]
    fn beginnings(&self) -> (*const Node8, *const u8, usize) {
        (self.nodes().as_ptr(), Bvh::blocks(self).as_ptr().cast(), size_of::<Tri4>())
    }
}

impl Nodes for Bvh {
    #[inline(always)]
    unsafe fn node(&self, index: usize) -> &Node8 {
        // SAFETY: the caller's promise.
        unsafe { self.nodes().get_unchecked(index) }
    }
}
