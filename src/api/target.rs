//! Where the pixels go: the application's memory, or a framebuffer of the library's own.

use super::context::Context;
use super::error::{Error, Result};
use crate::frame::Target;
use crate::scene::Viewport;

/// Largest width and height of a framebuffer.
pub const MAX_FRAME_SIZE: u32 = 1 << 16;

enum Place {
    /// The library's framebuffer, as large as the viewport asks for.
    Viewport,
    /// The library's framebuffer, of a size given.
    Size([u32; 2]),
    Target(Target),
}

/// The framebuffer and the part of it that is rendered.
pub(super) struct FrameTarget {
    place: Place,
    /// None until `viewport`: the whole framebuffer.
    viewport: Option<Viewport>,
}

impl Default for FrameTarget {
    fn default() -> Self {
        Self { place: Place::Viewport, viewport: None }
    }
}

impl FrameTarget {
    pub fn target(&self) -> Option<&Target> {
        match &self.place {
            Place::Target(target) => Some(target),
            _ => None,
        }
    }

    /// Width and height of the framebuffer; None before anything was said about it.
    pub fn size(&self) -> Option<[u32; 2]> {
        match (&self.place, self.viewport) {
            (Place::Target(target), _) => Some([target.layout.width, target.layout.height]),
            (Place::Size(size), _) => Some(*size),
            (Place::Viewport, Some(v)) => Some([v.x + v.width, v.y + v.height]),
            (Place::Viewport, None) => None,
        }
    }

    /// The viewport as set or by default; all 0 before anything was said about the framebuffer.
    pub fn shown_viewport(&self) -> Viewport {
        let [width, height] = self.size().unwrap_or_default();
        self.viewport.unwrap_or(Viewport { x: 0, y: 0, width, height })
    }

    /// The part that is rendered.
    ///
    /// # Errors
    /// No framebuffer, or the viewport reaches beyond it.
    pub fn viewport(&self) -> Result<Viewport> {
        let [width, height] = self.size().ok_or_else(|| {
            Error::invalid_operation("there is no frame buffer: neither its size nor a viewport was set")
        })?;
        let viewport = self.shown_viewport();
        if viewport.x + viewport.width > width || viewport.y + viewport.height > height {
            let Viewport { x, y, width: w, height: h } = viewport;
            return Err(Error::invalid_operation(format_args!(
                "the viewport of {w} x {h} pixels at ({x}, {y}) reaches beyond the frame buffer of {width} x {height}"
            )));
        }
        Ok(viewport)
    }
}

impl Context {
    /// Delivers the frames that start from now on to memory of the application's, which the sink reaches; None goes
    /// back to the library's own framebuffer. The library keeps a copy of the frame either way, for [`Context::read_pixels`].
    ///
    /// # Errors
    /// `InvalidValue` for a side that is 0 or beyond [`MAX_FRAME_SIZE`], a stride shorter than a row, or an image larger than the address space.
    pub fn set_frame_buffer(&mut self, target: Option<Target>) -> Result<()> {
        self.outside_begin()?;
        let place = match target {
            None => Place::Viewport,
            Some(target) => {
                let layout = &target.layout;
                check_size(layout.width, layout.height)?;
                let row = layout.width as usize * layout.format.bytes_per_pixel();
                if layout.stride < row {
                    let stride = layout.stride;
                    return Err(Error::invalid_value(format_args!(
                        "stride is {stride}, less than the {row} bytes of a row"
                    )));
                }
                // Offsets must fit a pointer difference.
                let size = layout.stride.checked_mul(layout.height as usize);
                if size.is_none_or(|size| size > isize::MAX as usize) {
                    return Err(Error::invalid_value(format_args!(
                        "{} rows that are {} bytes apart are larger than memory",
                        layout.height, layout.stride
                    )));
                }
                Place::Target(target)
            }
        };
        self.target.place = place;
        Ok(())
    }

    /// Renders into a framebuffer of the library's own with this size. Without a size and without memory of the application's it is
    /// as large as the viewport asks for.
    ///
    /// # Errors
    /// `InvalidValue` for a side that is 0 or beyond [`MAX_FRAME_SIZE`].
    pub fn set_frame_size(&mut self, width: u32, height: u32) -> Result<()> {
        self.outside_begin()?;
        check_size(width, height)?;
        self.target.place = Place::Size([width, height]);
        Ok(())
    }

    /// Renders only these pixels, and lets the camera's window fill them; origin at the lower left. Without a call, the whole
    /// framebuffer.
    ///
    /// # Errors
    /// `InvalidValue` for a negative number, a side of 0, or a rectangle beyond [`MAX_FRAME_SIZE`]. A viewport that does not fit the
    /// framebuffer is an error when a frame starts.
    pub fn viewport(&mut self, x: i32, y: i32, width: i32, height: i32) -> Result<()> {
        self.outside_begin()?;
        let number = |n: i32| u32::try_from(n).map_err(|_| Error::invalid_value(format_args!("{n} is negative")));
        let viewport = Viewport { x: number(x)?, y: number(y)?, width: number(width)?, height: number(height)? };
        check_size(viewport.width, viewport.height)?;
        check_size(viewport.x + viewport.width, viewport.y + viewport.height)?;
        self.target.viewport = Some(viewport);
        Ok(())
    }
}

fn check_size(width: u32, height: u32) -> Result<()> {
    let valid = 1..=MAX_FRAME_SIZE;
    if valid.contains(&width) && valid.contains(&height) {
        Ok(())
    } else {
        Err(Error::invalid_value(format_args!(
            "{width} x {height} pixels; a picture has 1 to {MAX_FRAME_SIZE} on a side"
        )))
    }
}
