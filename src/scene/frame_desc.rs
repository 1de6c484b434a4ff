//! What one frame shows: the part of the scene that is cleared every frame.

use super::{Mask, Name, TopLevelKind, Upsampling};
use glam::Affine3A;
use std::time::Duration;

/// One placement of an object in one frame. Its number in [`FrameDesc::instances`] is its instance id.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    pub object: Name,
    pub world_from_object: Affine3A,
    /// Rays see it that are in this mask and in the object's.
    pub mask: Mask,
}

impl Instance {
    /// An instance that all rays see.
    pub const fn new(object: Name, world_from_object: Affine3A) -> Self {
        Self { object, world_from_object, mask: Mask::ALL }
    }
}

/// A light shader that shines in a frame, and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightUse {
    pub shader: Name,
    /// Transforms positions, directions and edges that the shader's parameters give.
    pub world_from_light: Affine3A,
}

impl LightUse {
    pub const fn new(shader: Name, world_from_light: Affine3A) -> Self {
        Self { shader, world_from_light }
    }
}

/// The light from everywhere, until the application sets it: OpenGL's.
pub const DEFAULT_AMBIENT: [f32; 3] = [0.2; 3];

/// Pixel rectangle of the framebuffer that is rendered; origin at the lower left, as in OpenGL.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Viewport {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

/// Everything that a frame needs besides the retained scene.
#[derive(Clone, Debug)]
pub struct FrameDesc {
    pub instances: Vec<Instance>,
    /// In the order of use.
    pub lights: Vec<LightUse>,
    /// Linear RGB of the light that comes from everywhere, beside that of `ambient` lights. None: 0.2 in a frame without such lights, and only for
    /// surfaces whose share of it was set.
    pub ambient: Option<[f32; 3]>,
    /// Camera shader; 0 is the default pinhole at the origin looking down −z, 60° vertical field of view.
    pub camera: Name,
    /// Environment shader; 0 shows `clear_color`.
    pub environment: Name,
    /// Rendering object; 0 is `whitted`.
    pub renderer: Name,
    /// Linear RGBA of rays that leave the scene when there is no environment shader.
    pub clear_color: [f32; 4],
    /// Width and height of the framebuffer in pixels, at least 1; a target has the same size.
    pub size: [u32; 2],
    /// Lies within the framebuffer; pixels outside keep what they showed before.
    pub viewport: Viewport,
    /// Samples per pixel, at least 1; 1 samples the pixel centre.
    pub samples: u32,
    /// Number of bounces after the primary ray.
    pub max_depth: u32,
    /// Encode 8-bit pixels with the sRGB curve instead of storing linear values.
    pub srgb: bool,
    /// Keep averaging into the frame before while neither scene nor camera changed (`path`, anti-aliasing).
    pub accumulate: bool,
    /// The structure over the instances; does not change the picture.
    pub top_level: TopLevelKind,
    /// Only one pixel in each block of so many on a side is sampled, at least 1; 1 samples all.
    pub subsampling: u32,
    /// How the others get their colours.
    pub upsampling: Upsampling,
    /// In how many frames every pixel is rendered once, at least 1; 1 renders all in each. More averages nothing.
    pub frameless: u32,
    /// When the frame shall be finished, from its start. Primary rays are sent in any case, others as long as there is time.
    pub time_budget: Option<Duration>,
    /// As `accumulate`; and while neither scene nor camera changes, each frame samples blocks of half the size.
    pub progressive: bool,
}

impl FrameDesc {
    /// The same frame with other lists.
    pub fn with_lists(&self, instances: Vec<Instance>, lights: Vec<LightUse>) -> Self {
        Self { instances, lights, ..*self }
    }
}

impl Default for FrameDesc {
    fn default() -> Self {
        Self {
            instances: Vec::new(),
            lights: Vec::new(),
            ambient: None,
            camera: 0,
            environment: 0,
            renderer: 0,
            clear_color: [0.0; 4],
            size: [1, 1],
            viewport: Viewport { x: 0, y: 0, width: 1, height: 1 },
            samples: 1,
            max_depth: 3,
            srgb: false,
            accumulate: false,
            top_level: TopLevelKind::Auto,
            subsampling: 1,
            upsampling: Upsampling::Bilinear,
            frameless: 1,
            time_budget: None,
            progressive: false,
        }
    }
}
