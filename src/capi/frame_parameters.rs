//! Frame techniques: how a picture is made with fewer rays.

use super::constants::*;
use super::guard::guard;
use super::refusal::unknown;
use super::types::*;
use crate::api::{Context, Error, FrameParameter, Result, Upsampling};
use std::time::Duration;

fn upsampling(value: RTint) -> Result<Upsampling> {
    match RTenum::try_from(value) {
        Ok(RT_BILINEAR) => Ok(Upsampling::Bilinear),
        Ok(RT_MIDPOINT) => Ok(Upsampling::Midpoint),
        _ => Err(unknown("param", value as RTenum, "a way of up-sampling")),
    }
}

pub(super) fn upsampling_number(scheme: Upsampling) -> RTenum {
    match scheme {
        Upsampling::Bilinear => RT_BILINEAR,
        Upsampling::Midpoint => RT_MIDPOINT,
    }
}

fn frame_parameter(cx: &mut Context, pname: RTenum, value: RTint) -> Result<()> {
    cx.frame_parameter(match pname {
        RT_SUBSAMPLING => FrameParameter::Subsampling(value),
        RT_UPSAMPLING => FrameParameter::Upsampling(upsampling(value)?),
        RT_FRAMELESS => FrameParameter::Frameless(value),
        RT_TIME_BUDGET => time_budget(value.into())?,
        _ => return Err(unknown("pname", pname, "a parameter of frames")),
    })
}

/// Negative numbers, and those that are too large to end, are no budget.
fn time_budget(milliseconds: RTdouble) -> Result<FrameParameter> {
    if milliseconds.is_nan() {
        return Err(Error::invalid_value("param is NaN"));
    }
    Ok(FrameParameter::TimeBudget(Duration::try_from_secs_f64(milliseconds / 1e3).ok()))
}

/// Sets how pictures are made from fewer rays, from the next frame on. rtGetIntegerv() gives the values back.
///
/// RT_SUBSAMPLING: only one pixel in each block of param x param is sampled; param is 1, the default, to
/// RT_MAX_FRAME_SIZE. Columns and rows 0, param, 2 * param ... of the viewport and its last ones are sampled and show what
/// they show without sub-sampling; pixels in between get colours in between, and depth, normal and names of the nearest
/// sampled one. It works with every rendering object, with rtSamplesPerPixel() and with RT_ACCUMULATE, which then
/// count for the sampled pixels. A sub-sampled frame that is cancelled leaves the whole picture as it was.
///
/// RT_UPSAMPLING: how colours in between are found. RT_BILINEAR, the default, or RT_MIDPOINT: linear in each of the four
/// triangles that meet at the middle of a block, where the colour is the mean of the corners (Larsson and Akenine-Moller
/// 2003).
///
/// RT_FRAMELESS: each frame renders one in param pixels, in an order that looks random and gives every pixel its turn once in
/// param frames; the others keep what older frames left there. param is 1, the default, to 1024. The first frame of a
/// size, viewport or sub-sampling renders all. Above 1, RT_ACCUMULATE and RT_PROGRESSIVE have no effect.
///
/// RT_TIME_BUDGET: milliseconds from the start of a frame after which it shall be finished; -1, the default, and every negative
/// number: as long as it takes. All rays from the camera are sent first, and make the picture of the rendering object raycast
/// with one sample per pixel; then parts of it are rendered in full, from the middle on, until the time is up. A part of
/// 16 x 16 samples that was begun is finished. So 0 sends rays from the camera only, but for those that shaders of the
/// application ask for. refined of RTframeStats says which share was rendered in full. While frames are averaged, see rtEnable(), they
/// go on where the one before stopped.
///
/// Errors: RT_INVALID_ENUM for another parameter or an unknown constant as its value, RT_INVALID_VALUE for a number out of
/// range, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtFrameParameteri(pname: RTenum, param: RTint) {
    guard(|cx| frame_parameter(cx, pname, param))
}

/// See rtFrameParameteri(); values but RT_TIME_BUDGET are rounded. RT_INVALID_VALUE for NaN.
#[unsafe(no_mangle)]
pub extern "C" fn rtFrameParameterf(pname: RTenum, param: RTfloat) {
    // For all others, a float that is not a number becomes 0, which they do not accept.
    guard(|cx| match pname {
        RT_TIME_BUDGET => cx.frame_parameter(time_budget(param.into())?),
        _ => frame_parameter(cx, pname, param.round() as RTint),
    })
}
