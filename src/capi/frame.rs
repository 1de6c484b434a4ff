//! Frames: where pixels go, when they are rendered, how they are read back.

use super::constants::*;
use super::current::UserData;
use super::guard::{guard, guard_thread};
use super::pointer::{Out, slice_mut, text};
use super::refusal::{not_negative, null, unknown};
use super::types::*;
use crate::api::{
    Context, Error, FrameCallback, FrameStats, PixelFormat, PixelKind, PixelSink, Result, Target, TargetLayout,
};
use std::ffi::{c_char, c_void};
use std::sync::Arc;
use std::time::Duration;

/// An image in the application's memory.
struct AppMemory {
    base: *mut u8,
    size: usize,
}

// SAFETY: the manual of rtSetFrameBuffer leaves the memory to the library from the start of a frame to its end; the renderer writes
// from several threads, each byte from one thread at a time (contract of PixelSink).
unsafe impl Send for AppMemory {}
// SAFETY: as above; nothing is read through it.
unsafe impl Sync for AppMemory {}

impl PixelSink for AppMemory {
    fn write(&self, offset: usize, bytes: &[u8]) {
        let end = offset.checked_add(bytes.len());
        assert!(end.is_some_and(|end| end <= self.size), "the renderer keeps within the layout of the sink");
        // SAFETY: offset + length is within `size`, and that many bytes at `base` are writable until the frame has ended, says the manual. `bytes` is
        // ours and cannot overlap them.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), self.base.add(offset), bytes.len()) }
    }
}

fn pixel_format(format: RTenum) -> Result<PixelFormat> {
    Ok(match format {
        RT_RGBA8 => PixelFormat::Rgba8,
        RT_BGRA8 => PixelFormat::Bgra8,
        RT_RGB8 => PixelFormat::Rgb8,
        RT_BGR8 => PixelFormat::Bgr8,
        RT_RGB32F => PixelFormat::Rgb32F,
        RT_RGBA32F => PixelFormat::Rgba32F,
        RT_BGR32F => PixelFormat::Bgr32F,
        RT_BGRA32F => PixelFormat::Bgra32F,
        _ => return Err(unknown("format", format, "a frame buffer format")),
    })
}

/// `stride` None: rows without gaps.
fn set_frame_buffer(
    cx: &mut Context,
    pixels: *mut c_void,
    (width, height): (RTsizei, RTsizei),
    format: RTenum,
    stride: Option<RTsizei>,
) -> Result<()> {
    if pixels.is_null() && width == 0 && height == 0 {
        return cx.set_frame_buffer(None);
    }
    cx.is_object(0)?;
    let format = pixel_format(format)?;
    let (width, height) = (not_negative("width", width)?, not_negative("height", height)?);
    let stride = match stride {
        None => width as usize * format.bytes_per_pixel(),
        Some(stride) => not_negative("stride", stride)? as usize,
    };
    if pixels.is_null() {
        return Err(null("pixels"));
    }
    let size = stride.checked_mul(height as usize);
    let size = size.ok_or_else(|| {
        Error::invalid_value(format_args!("{height} rows that are {stride} bytes apart are larger than memory"))
    })?;
    let layout = TargetLayout { width, height, format, stride, origin_top_left: false };
    cx.set_frame_buffer(Some(Target { layout, sink: Arc::new(AppMemory { base: pixels.cast(), size }) }))
}

/// Lets frames be stored in the application's memory: height rows of width pixels without gaps, the lowest row
/// first unless RT_ORIGIN_TOP_LEFT is enabled. format is RT_RGBA8, RT_BGRA8, RT_RGB8, RT_BGR8, RT_RGB32F,
/// RT_RGBA32F, RT_BGR32F or RT_BGRA32F.
/// Pixels of 8 bits hold linear values, or values on the sRGB curve when RT_FRAMEBUFFER_SRGB is enabled.
///
/// The memory stays the application's. The library writes to it while a frame is rendered that was started with
/// it, that is, until rtRender(), rtEndRendering() or rtDestroyContext() returns; it must exist until then, and
/// it counts for all frames until another is set. NULL with a size of 0 by 0 goes back to the library's own
/// frame buffer, which rtReadPixels() and rtWriteImage() read in any case.
///
/// Errors: RT_INVALID_ENUM for another format; RT_INVALID_VALUE when pixels is NULL, or width or height is
/// below 1 or above RT_MAX_FRAME_SIZE; RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtSetFrameBuffer(pixels: *mut c_void, width: RTsizei, height: RTsizei, format: RTenum) {
    guard(|cx| set_frame_buffer(cx, pixels, (width, height), format, None))
}

/// As rtSetFrameBuffer(), with stride bytes from one row to the next.
///
/// Errors: also RT_INVALID_VALUE when stride is negative or less than a row.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtSetFrameBufferStride(
    pixels: *mut c_void,
    width: RTsizei,
    height: RTsizei,
    format: RTenum,
    stride: RTsizei,
) {
    guard(|cx| set_frame_buffer(cx, pixels, (width, height), format, Some(stride)))
}

/// Lets frames be stored in the library's own frame buffer, with this size. Without this call and without
/// rtSetFrameBuffer() it is as large as rtViewport() asks for.
///
/// Errors: RT_INVALID_VALUE when a number is below 1 or above RT_MAX_FRAME_SIZE, RT_INVALID_OPERATION between
/// rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtSetFrameSize(width: RTsizei, height: RTsizei) {
    guard(|cx| {
        // A negative number becomes one that is too large.
        cx.set_frame_size(width as u32, height as u32)
    })
}

/// Renders only a rectangle of the frame buffer, and lets the camera's picture fill it; (x, y) is its lower
/// left corner. Without this call, the whole frame buffer.
///
/// Errors: RT_INVALID_VALUE when x or y is negative, width or height is below 1, or the rectangle reaches
/// beyond RT_MAX_FRAME_SIZE; RT_INVALID_OPERATION between rtBegin() and rtEnd(). Whether it fits the frame
/// buffer is asked when a frame starts.
#[unsafe(no_mangle)]
pub extern "C" fn rtViewport(x: RTint, y: RTint, width: RTsizei, height: RTsizei) {
    guard(|cx| cx.viewport(x, y, width, height))
}

/// Renders the frame that was assembled and waits for it, or, if a frame was started by rtStartRendering(),
/// waits for that one. Then a new frame without instances begins.
///
/// Errors: RT_INVALID_OPERATION without a frame buffer or viewport, when the viewport reaches beyond the frame
/// buffer, between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject(). RT_OUT_OF_MEMORY: when the
/// frame could not start, it is still assembled; otherwise it is over, and the picture is that of the frame before.
/// Objects, shaders and settings are what they were in either case.
#[unsafe(no_mangle)]
pub extern "C" fn rtRender() {
    guard(|cx| cx.render().map(|_| ()))
}

/// Starts rendering the frame that was assembled, and returns at once. The scene, all shader parameters and the
/// frame buffer are those of this moment: whatever is called now shows in the next frame, which begins without
/// instances.
///
/// Errors: as rtRender(); RT_INVALID_OPERATION also when a frame is being rendered already.
#[unsafe(no_mangle)]
pub extern "C" fn rtStartRendering() {
    guard(|cx| cx.start_rendering())
}

/// Waits until the frame of rtStartRendering() is finished. Then its pixels are in the frame buffer, and the
/// callback of rtFrameCallback() has returned.
///
/// Errors: RT_INVALID_OPERATION without rtStartRendering(), between rtBegin() and rtEnd(), or between
/// rtNewObject() and rtEndObject(); RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtEndRendering() {
    guard(|cx| cx.end_rendering().map(|_| ()))
}

/// Ends the frame in OpenRT's order of calls: another name of rtRender().
#[unsafe(no_mangle)]
pub extern "C" fn rtSwapBuffers() {
    guard(|cx| cx.swap_buffers().map(|_| ()))
}

/// RT_TRUE when the frame of rtStartRendering() is finished, or none was started. Does not wait.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtIsFrameDone() -> RTboolean {
    guard(|cx| cx.is_frame_done().map(RTboolean::from))
}

/// Waits at most this many milliseconds for the frame of rtStartRendering(); RT_TRUE when it is finished. It
/// still wants rtEndRendering().
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtWaitFrame(milliseconds: RTuint) -> RTboolean {
    guard(|cx| cx.wait_frame(Duration::from_millis(milliseconds.into())).map(RTboolean::from))
}

/// Stops the frame of rtStartRendering() early, within milliseconds: parts of the picture that are not complete keep what they
/// showed before, and those that were begun may be of both. The frame still wants rtEndRendering(), and its statistics say that it was cancelled. Without a
/// frame this does nothing.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtCancel() {
    guard(|cx| cx.cancel())
}

/// Stops the frame that a context is rendering, as rtCancel() does. May be called on any thread, for a context
/// that is current on another one, for example while that thread waits in rtRender().
///
/// Errors: RT_INVALID_VALUE when there is no such context.
#[unsafe(no_mangle)]
pub extern "C" fn rtCancelContext(context: RTuint) {
    guard_thread(|| super::contexts::cancel(context))
}

/// From now on, callback is called at the end of every frame that starts. NULL stops that. userData is handed
/// to the callback and otherwise not touched; it must stay valid until the last such frame has ended.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtFrameCallback(callback: RTframeCallback, userData: *mut c_void) {
    let user_data = UserData(userData);
    guard(|cx| {
        cx.frame_callback(callback.map(|callback| -> FrameCallback {
            Arc::new(move |outcome| {
                let user_data = user_data;
                let cancelled = outcome.as_ref().is_ok_and(|stats: &FrameStats| stats.cancelled);
                // SAFETY: the application gave this function to rtFrameCallback for such calls.
                unsafe { callback(cancelled.into(), user_data.0) }
            })
        }))
    })
}

/// Brings all acceleration structures up to date with the objects, and with the instances placed in this frame
/// so far, without rendering and without beginning a new frame (rtClearInstances() does that). Ray queries then
/// see them. Waits for a frame that is being rendered.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject();
/// RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtCommitScene() {
    guard(|cx| cx.commit_scene().map(|_| ()))
}

/// Stores at stats what the last finished frame, or the last rtCommitScene(), cost.
///
/// Errors: RT_INVALID_VALUE when stats is NULL, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetFrameStats(stats: *mut RTframeStats) {
    // SAFETY: `stats` is NULL or a place for statistics, says the manual.
    let out = unsafe { Out::new("stats", stats) };
    guard(|cx| {
        let stats = cx.get_frame_stats()?;
        out.check()?.set(RTframeStats {
            updateSeconds: stats.update_seconds,
            topLevelSeconds: stats.top_level_seconds,
            renderSeconds: stats.render_seconds,
            totalSeconds: stats.total_seconds,
            primaryRays: stats.primary_rays as f64,
            shadowRays: stats.shadow_rays as f64,
            secondaryRays: stats.secondary_rays as f64,
            instances: stats.instances as f64,
            triangles: stats.triangles as f64,
            nodesUpdated: stats.nodes_updated as f64,
            subtreesTouched: stats.subtrees_touched as f64,
            nodesTouched: stats.nodes_touched as f64,
            structureBytes: stats.structure_bytes as f64,
            refined: stats.refined,
            subsampling: stats.subsampling,
            objectsBuilt: stats.objects_built,
            objectsRefitted: stats.objects_refitted,
            objectsWaiting: stats.objects_waiting,
            objectsByRays: stats.objects_by_rays,
            mergedInstances: stats.merged_instances,
            cancelled: stats.cancelled.into(),
        });
        Ok(())
    })
}

fn pixel_kind(format: RTenum, kind: RTenum) -> Result<PixelKind> {
    Ok(match (format, kind) {
        (RT_RGBA, RT_UNSIGNED_BYTE) => PixelKind::Color(PixelFormat::Rgba8),
        (RT_BGRA, RT_UNSIGNED_BYTE) => PixelKind::Color(PixelFormat::Bgra8),
        (RT_RGB, RT_UNSIGNED_BYTE) => PixelKind::Color(PixelFormat::Rgb8),
        (RT_BGR, RT_UNSIGNED_BYTE) => PixelKind::Color(PixelFormat::Bgr8),
        (RT_RGBA, RT_FLOAT) => PixelKind::Color(PixelFormat::Rgba32F),
        (RT_RGB, RT_FLOAT) => PixelKind::Color(PixelFormat::Rgb32F),
        (RT_BGRA, RT_FLOAT) => PixelKind::Color(PixelFormat::Bgra32F),
        (RT_BGR, RT_FLOAT) => PixelKind::Color(PixelFormat::Bgr32F),
        (RT_DEPTH_COMPONENT, RT_FLOAT) => PixelKind::Depth,
        (RT_NORMAL, RT_FLOAT) => PixelKind::Normal,
        (RT_OBJECT_ID, RT_UNSIGNED_INT) => PixelKind::ObjectId,
        (RT_INSTANCE_ID, RT_UNSIGNED_INT) => PixelKind::InstanceId,
        _ => {
            return Err(Error::invalid_enum(format_args!(
                "frames have no pixels of format 0x{format:04X} and type 0x{kind:04X}"
            )));
        }
    })
}

/// Stores a rectangle of the last frame at pixels, row by row without gaps; row 0 is the lowest, or the topmost
/// when RT_ORIGIN_TOP_LEFT is enabled. (x, y) is the corner of the rectangle where row 0 begins to count.
/// format and type are RT_RGBA, RT_RGB, RT_BGRA or RT_BGR with RT_UNSIGNED_BYTE or RT_FLOAT;
/// RT_DEPTH_COMPONENT or RT_NORMAL (three numbers) with RT_FLOAT; RT_OBJECT_ID or RT_INSTANCE_ID with
/// RT_UNSIGNED_INT. Waits for a frame that is being rendered.
///
/// Errors: RT_INVALID_ENUM for another format or type; RT_INVALID_VALUE when pixels is NULL, a number is
/// negative, or the rectangle reaches beyond the picture; RT_INVALID_OPERATION before the first frame, between
/// rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtReadPixels(
    x: RTint,
    y: RTint,
    width: RTsizei,
    height: RTsizei,
    format: RTenum,
    type_: RTenum,
    pixels: *mut c_void,
) {
    guard(|cx| {
        cx.is_object(0)?;
        let kind = pixel_kind(format, type_)?;
        let (x, y) = (not_negative("x", x)?, not_negative("y", y)?);
        let (width, height) = (not_negative("width", width)?, not_negative("height", height)?);
        // Only a rectangle within the picture has a size that we believe; for another one read_pixels finds the error.
        let [picture_width, picture_height] = cx.frame_size()?;
        let out = if width <= picture_width && height <= picture_height {
            let size = width as usize * height as usize * kind.bytes_per_pixel();
            let size = RTsizei::try_from(size).map_err(|_| {
                Error::invalid_value(format_args!("{width} x {height} pixels are more than two gigabytes"))
            })?;
            // SAFETY: `pixels` is NULL or a place for the rectangle, says the manual; C has no uninitialised bytes.
            unsafe { slice_mut("pixels", pixels.cast::<u8>(), size)? }
        } else {
            &mut []
        };
        cx.read_pixels(x, y, width, height, kind, 0, out)
    })
}

/// Sets how well JPEG files that rtWriteImage() writes show the picture: 1 (small files) to 100; 92 at first.
///
/// Errors: RT_INVALID_VALUE when quality is below 1 or above 100, RT_INVALID_OPERATION between rtBegin() and
/// rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtJpegQuality(quality: RTint) {
    guard(|cx| cx.jpeg_quality(quality))
}

/// Writes the last frame to a file whose extension names the format: .png, .jpg, .ppm, .hdr or .exr. Waits for
/// a frame that is being rendered.
///
/// Errors: RT_IO_ERROR when the file cannot be written or the extension is unknown, RT_INVALID_VALUE when file
/// is NULL, RT_INVALID_OPERATION before the first frame, between rtBegin() and rtEnd(), or between
/// rtNewObject() and rtEndObject().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtWriteImage(file: *const c_char) {
    // SAFETY: `file` is NULL or a string, says the manual; it is read before we return.
    let file = unsafe { text("file", file) };
    guard(|cx| cx.write_image(file?))
}
