//! From the nodes of a sub-sampled frame to its pixels, tile by tile and in parallel.

use crate::frame::{Framebuffer, Lattice, Target, TileRect};
use crate::scene::{FrameDesc, Upsampling};
use rayon::prelude::*;

/// Fills the pixels of `viewport` between the `nodes` of its lattice.
pub fn upsample(
    nodes: &Framebuffer,
    lattice: &Lattice,
    frame: &FrameDesc,
    picture: &mut Framebuffer,
    viewport: TileRect,
    target: Option<&Target>,
) {
    let grid = picture.grid();
    let fill = match frame.upsampling {
        Upsampling::Bilinear => Lattice::fill_bilinear,
        Upsampling::Midpoint => Lattice::fill_midpoint,
    };
    picture.tiles_mut().0.par_iter_mut().enumerate().for_each(|(index, tile)| {
        let rect = grid.rect(index);
        let visible = rect.intersection(viewport);
        if visible.is_empty() {
            return;
        }
        fill(lattice, nodes, [rect.x0, rect.y0], visible, tile);
        if let Some(target) = target {
            target.write_rect(visible, frame.srgb, |x, y| tile.color(x - rect.x0, y - rect.y0));
        }
    });
}
