//! The world as rays of one kind see it.

use crate::accel::{InstanceRecord, WorldView};
use crate::scene::Mask;
use std::ops::Deref;

/// A view, and which of its instances are there for the rays that traverse it. Two words, passed by value.
#[derive(Clone, Copy)]
pub struct Scope<'a> {
    view: &'a WorldView,
    mask: Mask,
}

impl<'a> Scope<'a> {
    #[inline(always)]
    pub fn new(view: &'a WorldView, mask: Mask) -> Self {
        Self { view, mask }
    }

    #[inline(always)]
    pub fn view(&self) -> &'a WorldView {
        self.view
    }

    /// Whether the rays see an instance.
    #[inline(always)]
    pub fn sees(&self, record: &InstanceRecord) -> bool {
        record.mask.meets(self.mask)
    }
}

impl Deref for Scope<'_> {
    type Target = WorldView;

    #[inline(always)]
    fn deref(&self) -> &WorldView {
        self.view
    }
}
