//! Frame techniques: how a picture is made with fewer rays.

use super::constants::*;
use super::guard::guard;
use super::types::*;
use crate::api::{Context, Error, FrameParameter, Result, Upsampling};

fn upsampling(value: RTint) -> Result<Upsampling> {
    match RTenum::try_from(value) {
        Ok(RT_BILINEAR) => Ok(Upsampling::Bilinear),
        Ok(RT_MIDPOINT) => Ok(Upsampling::Midpoint),
        _ => Err(Error::invalid_enum("not a way of up-sampling")),
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
        _ => return Err(Error::invalid_enum("not a parameter of frames")),
    })
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
/// Errors: RT_INVALID_ENUM for another parameter or an unknown constant as its value, RT_INVALID_VALUE for a number out of
/// range, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtFrameParameteri(pname: RTenum, param: RTint) {
    guard(|cx| frame_parameter(cx, pname, param))
}

/// See rtFrameParameteri(); values are rounded.
#[unsafe(no_mangle)]
pub extern "C" fn rtFrameParameterf(pname: RTenum, param: RTfloat) {
    // A float that is not a number becomes 0, which no parameter accepts.
    guard(|cx| frame_parameter(cx, pname, param.round() as RTint))
}
