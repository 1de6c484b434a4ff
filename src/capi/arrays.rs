//! Vertex arrays: descriptions of application memory, read when something is drawn.
//!
//! The descriptions hold pointers, so they live here and not in the safe state machine, which is given byte
//! slices of exactly the length that a draw touches.

use super::constants::*;
use super::current::Session;
use super::guard::{guard, guard_session};
use super::immediate::primitive;
use super::pointer::{OutArray, slice};
use super::refusal::{not_negative, unknown};
use super::types::*;
use crate::api::{Component, Error, Indices, Result, VertexArray, VertexArrays, decode_vectors};
use std::ffi::c_void;

/// One array as the application described it.
#[derive(Clone, Copy)]
pub(super) struct ClientArray {
    pub enabled: bool,
    pub size: RTint,
    pub component: Component,
    /// As given: 0 when the vertices follow each other without a gap.
    pub stride: RTsizei,
    pub pointer: *const c_void,
}

// SAFETY: only an address; it is read through in `ClientArray::view`, on the thread that draws, as the manual of rtVertexPointer says.
unsafe impl Send for ClientArray {}

impl ClientArray {
    const fn new(size: RTint) -> Self {
        Self { enabled: false, size, component: Component::Float, stride: 0, pointer: std::ptr::null() }
    }

    /// The array as far as its first `vertices` vertices reach.
    ///
    /// # Safety
    /// The pointer is NULL or that much memory is readable, and stays unchanged for `'a`.
    unsafe fn view<'a>(&self, vertices: usize) -> Result<VertexArray<'a>> {
        let mut view =
            VertexArray { size: self.size as u32, component: self.component, stride: self.stride as usize, bytes: &[] };
        let bytes = view.bytes_needed(vertices).filter(|&n| n <= isize::MAX as usize);
        let bytes = bytes.ok_or_else(|| {
            Error::invalid_value(format_args!(
                "{vertices} vertices that are {} bytes apart are larger than memory",
                self.stride
            ))
        })?;
        if self.pointer.is_null() {
            return Err(Error::invalid_value("an enabled vertex array is at NULL"));
        }
        // SAFETY: not NULL; readable and unchanged by contract; the size was checked; bytes need no alignment.
        view.bytes = unsafe { std::slice::from_raw_parts(self.pointer.cast(), bytes) };
        Ok(view)
    }
}

/// The arrays of a context.
#[derive(Clone, Copy)]
pub(super) struct ClientArrays {
    pub vertex: ClientArray,
    pub normal: ClientArray,
    pub color: ClientArray,
    pub tex_coord: ClientArray,
}

impl Default for ClientArrays {
    fn default() -> Self {
        Self {
            vertex: ClientArray::new(4),
            normal: ClientArray::new(3),
            color: ClientArray::new(4),
            tex_coord: ClientArray::new(4),
        }
    }
}

impl ClientArrays {
    pub fn of(&mut self, array: RTenum) -> Option<&mut ClientArray> {
        Some(match array {
            RT_VERTEX_ARRAY => &mut self.vertex,
            RT_NORMAL_ARRAY => &mut self.normal,
            RT_COLOR_ARRAY => &mut self.color,
            RT_TEXTURE_COORD_ARRAY => &mut self.tex_coord,
            _ => return None,
        })
    }

    /// What a draw of the first `vertices` vertices reads; None without positions, when nothing is drawn.
    ///
    /// # Safety
    /// As [`ClientArray::view`], for every enabled array.
    unsafe fn view<'a>(&self, vertices: usize) -> Result<Option<VertexArrays<'a>>> {
        if !self.vertex.enabled || vertices == 0 {
            return Ok(None);
        }
        let view = |array: &ClientArray| -> Result<Option<VertexArray<'a>>> {
            // SAFETY: passed on.
            if array.enabled { unsafe { array.view(vertices) }.map(Some) } else { Ok(None) }
        };
        Ok(Some(VertexArrays {
            // SAFETY: passed on.
            positions: unsafe { self.vertex.view(vertices)? },
            normals: view(&self.normal)?,
            colors: view(&self.color)?,
            tex_coords: view(&self.tex_coord)?,
        }))
    }
}

/// The data types of vertices, indices and pixels.
pub(super) fn component(kind: RTenum) -> Result<Component> {
    Ok(match kind {
        RT_BYTE => Component::Byte,
        RT_UNSIGNED_BYTE => Component::UnsignedByte,
        RT_SHORT => Component::Short,
        RT_UNSIGNED_SHORT => Component::UnsignedShort,
        RT_INT => Component::Int,
        RT_UNSIGNED_INT => Component::UnsignedInt,
        RT_FLOAT => Component::Float,
        RT_DOUBLE => Component::Double,
        _ => return Err(unknown("type", kind, "a data type")),
    })
}

pub(super) fn number_of_component(component: Component) -> RTenum {
    match component {
        Component::Byte => RT_BYTE,
        Component::UnsignedByte => RT_UNSIGNED_BYTE,
        Component::Short => RT_SHORT,
        Component::UnsignedShort => RT_UNSIGNED_SHORT,
        Component::Int => RT_INT,
        Component::UnsignedInt => RT_UNSIGNED_INT,
        Component::Float => RT_FLOAT,
        Component::Double => RT_DOUBLE,
    }
}

/// Stores the description of `array`; `sizes` and `types` are those that OpenGL allows for it.
fn describe(
    session: &mut Session,
    array: RTenum,
    (size, sizes): (RTint, std::ops::RangeInclusive<RTint>),
    (kind, types): (RTenum, &[RTenum]),
    stride: RTsizei,
    pointer: *const c_void,
) -> Result<()> {
    session.outside_begin()?;
    if !types.contains(&kind) {
        return Err(unknown("type", kind, "a data type of this vertex array"));
    }
    let component = component(kind)?;
    if !sizes.contains(&size) || stride < 0 {
        let (least, most) = (sizes.start(), sizes.end());
        return Err(Error::invalid_value(format_args!(
            "size is {size} and stride {stride}; this array has {least} to {most} components, and a stride of 0 or more"
        )));
    }
    let slot = session.arrays.of(array).expect("one of the four arrays");
    *slot = ClientArray { enabled: slot.enabled, size, component, stride, pointer };
    Ok(())
}

/// Says where vertices come from: size (2, 3 or 4) numbers of type RT_SHORT, RT_INT, RT_FLOAT or RT_DOUBLE
/// each, stride bytes apart (0 for no gap), beginning at pointer. The memory stays the application's. It is
/// read when rtDrawArrays() or rtDrawElements() is called, as far as they need, and may be changed or freed
/// after that.
///
/// Errors: RT_INVALID_ENUM for another type, RT_INVALID_VALUE for another size or a negative stride,
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtVertexPointer(size: RTint, type_: RTenum, stride: RTsizei, pointer: *const c_void) {
    let types = &[RT_SHORT, RT_INT, RT_FLOAT, RT_DOUBLE];
    guard_session(|s| describe(s, RT_VERTEX_ARRAY, (size, 2..=4), (type_, types), stride, pointer))
}

/// Says where normals come from: three numbers of type RT_BYTE, RT_SHORT, RT_INT, RT_FLOAT or RT_DOUBLE each.
/// See rtVertexPointer().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtNormalPointer(type_: RTenum, stride: RTsizei, pointer: *const c_void) {
    let types = &[RT_BYTE, RT_SHORT, RT_INT, RT_FLOAT, RT_DOUBLE];
    guard_session(|s| describe(s, RT_NORMAL_ARRAY, (3, 3..=3), (type_, types), stride, pointer))
}

/// Says where colours come from: size (3 or 4) numbers each, of any data type from RT_BYTE to RT_DOUBLE. See
/// rtVertexPointer().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtColorPointer(size: RTint, type_: RTenum, stride: RTsizei, pointer: *const c_void) {
    let types = &[RT_BYTE, RT_UNSIGNED_BYTE, RT_SHORT, RT_UNSIGNED_SHORT, RT_INT, RT_UNSIGNED_INT, RT_FLOAT, RT_DOUBLE];
    guard_session(|s| describe(s, RT_COLOR_ARRAY, (size, 3..=4), (type_, types), stride, pointer))
}

/// Says where texture coordinates come from: size (1 to 4) numbers of type RT_SHORT, RT_INT, RT_FLOAT or
/// RT_DOUBLE each. See rtVertexPointer().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtTexCoordPointer(size: RTint, type_: RTenum, stride: RTsizei, pointer: *const c_void) {
    let types = &[RT_SHORT, RT_INT, RT_FLOAT, RT_DOUBLE];
    guard_session(|s| describe(s, RT_TEXTURE_COORD_ARRAY, (size, 1..=4), (type_, types), stride, pointer))
}

fn enable(session: &mut Session, array: RTenum, enabled: bool) -> Result<()> {
    session.outside_begin()?;
    let array = session.arrays.of(array).ok_or_else(|| unknown("array", array, "a vertex array"))?;
    array.enabled = enabled;
    Ok(())
}

/// Lets draws read an array: RT_VERTEX_ARRAY, RT_NORMAL_ARRAY, RT_COLOR_ARRAY or RT_TEXTURE_COORD_ARRAY. All
/// begin disabled. While an array is disabled, the current normal, colour or texture coordinate is used;
/// without RT_VERTEX_ARRAY nothing is drawn.
///
/// Errors: RT_INVALID_ENUM for something else, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtEnableClientState(array: RTenum) {
    guard_session(|session| enable(session, array, true))
}

/// Undoes rtEnableClientState().
#[unsafe(no_mangle)]
pub extern "C" fn rtDisableClientState(array: RTenum) {
    guard_session(|session| enable(session, array, false))
}

/// Draws count vertices of the enabled arrays, from vertex first on, as if by rtBegin(mode), an rtVertex each,
/// and rtEnd().
///
/// Errors: RT_INVALID_ENUM for another mode, RT_INVALID_VALUE when first or count is negative or an enabled
/// array is at NULL, RT_INVALID_OPERATION between rtBegin() and rtEnd(), RT_OUT_OF_MEMORY. Nothing is drawn
/// then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtDrawArrays(mode: RTenum, first: RTint, count: RTsizei) {
    guard_session(|session| {
        session.outside_begin()?;
        let mode = primitive(mode)?;
        let (Ok(begin), Ok(length)) = (usize::try_from(first), usize::try_from(count)) else {
            return Err(Error::invalid_value(format_args!(
                "first is {first} and count {count}; neither may be negative"
            )));
        };
        // A draw of no vertices reads none, wherever it begins.
        let reach = if length == 0 { 0 } else { begin + length };
        // SAFETY: enabled arrays hold the vertices up to first + count, says the manual; they are read before we return.
        match unsafe { session.arrays.view(reach)? } {
            Some(arrays) => session.context.draw_arrays(mode, &arrays, first, count),
            None => Ok(()),
        }
    })
}

/// Draws the count vertices whose numbers are at indices, of type RT_UNSIGNED_BYTE, RT_UNSIGNED_SHORT or
/// RT_UNSIGNED_INT. Each vertex that is used becomes one vertex of the object, in the order of the arrays, so
/// that rtUpdateVertices() counts them as the arrays do if none is left out.
///
/// Errors: RT_INVALID_ENUM for another mode or type, RT_INVALID_VALUE when count is negative, or indices or an
/// enabled array is at NULL, RT_INVALID_OPERATION between rtBegin() and rtEnd(), RT_OUT_OF_MEMORY. Nothing is
/// drawn then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtDrawElements(mode: RTenum, count: RTsizei, type_: RTenum, indices: *const c_void) {
    guard_session(|session| {
        session.outside_begin()?;
        let mode = primitive(mode)?;
        let component = component(type_)?;
        Indices::new(component, &[])?;
        let bytes = count.checked_mul(component.bytes() as RTsizei);
        let bytes = bytes.ok_or_else(|| {
            Error::invalid_value(format_args!("count is {count}: more indices than two gigabytes hold"))
        })?;
        // SAFETY: `indices` is NULL or holds `count` indices, says the manual; they are read before we return.
        let indices = Indices::new(component, unsafe { slice("indices", indices.cast::<u8>(), bytes)? })?;
        let reach = indices.max().map_or(0, |highest| highest as usize + 1);
        // SAFETY: enabled arrays hold the vertices up to the highest index, says the manual; they are read before we return.
        match unsafe { session.arrays.view(reach)? } {
            Some(arrays) => session.context.draw_elements(mode, &arrays, indices),
            None => Ok(()),
        }
    })
}

/// `count` vectors of three floats for an update, read before the call returns.
///
/// # Safety
/// `pointer` is NULL or points to that many vectors, `stride` bytes apart.
unsafe fn vectors(count: RTsizei, stride: RTsizei, pointer: *const RTfloat) -> Result<Vec<glam::Vec3>> {
    let (count, _) = (not_negative("count", count)? as usize, not_negative("stride", stride)?);
    if count == 0 {
        return Ok(Vec::new());
    }
    let array = ClientArray { stride, pointer: pointer.cast(), ..ClientArray::new(3) };
    // SAFETY: passed on.
    decode_vectors(&unsafe { array.view(count)? }, count)
}

/// Moves the vertices first to first + count - 1 of an object, counted in the order in which its definition
/// gave them, from the next frame on. Each is three floats in object space, stride bytes apart (0 for no gap),
/// beginning at vertices; the current matrix has no part in it. The triangles stay what they are. The memory is
/// read before the call returns.
///
/// Errors: RT_INVALID_VALUE when there is no such object, it has fewer vertices, a number is negative, or
/// vertices is NULL; RT_INVALID_OPERATION between rtBegin() and rtEnd(); RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtUpdateVertices(
    object: RTuint,
    first: RTsizei,
    count: RTsizei,
    stride: RTsizei,
    vertices: *const RTfloat,
) {
    guard(|cx| {
        let first = vertex_range(cx.get_object_parameters(object)?.vertex_count, first, count)?;
        // SAFETY: NULL or `count` vectors, says the manual.
        cx.update_vertices(object, first, unsafe { vectors(count, stride, vertices)? })
    })
}

/// Moves count vertices of an object whose numbers are at indices, of type RT_UNSIGNED_BYTE, RT_UNSIGNED_SHORT or
/// RT_UNSIGNED_INT, as rtUpdateVertices() moves a range: the first to the position at vertices, and so on. Of a
/// vertex that is named twice the last position counts. What it costs depends on how many vertices are moved, not
/// on how many the object has, if its update strategy is RT_LAZY or RT_REFIT, or RT_AUTO and the object
/// RT_UNSTRUCTURED.
///
/// Errors: RT_INVALID_VALUE when there is no such object, it has no such vertex, a number is negative, or indices or
/// vertices is NULL; RT_INVALID_ENUM for another type; RT_INVALID_OPERATION between rtBegin() and rtEnd();
/// RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtUpdateVertexElements(
    object: RTuint,
    count: RTsizei,
    type_: RTenum,
    indices: *const c_void,
    stride: RTsizei,
    vertices: *const RTfloat,
) {
    guard(|cx| {
        cx.get_object_parameters(object)?;
        let component = component(type_)?;
        Indices::new(component, &[])?;
        let bytes = count.checked_mul(component.bytes() as RTsizei);
        let bytes = bytes.ok_or_else(|| {
            Error::invalid_value(format_args!("count is {count}: more indices than two gigabytes hold"))
        })?;
        // SAFETY: `indices` is NULL or holds `count` indices, says the manual; they are read before we return.
        let indices = Indices::new(component, unsafe { slice("indices", indices.cast::<u8>(), bytes)? })?;
        // SAFETY: NULL or `count` vectors, says the manual.
        cx.update_vertex_elements(object, indices.to_vec()?, unsafe { vectors(count, stride, vertices)? })
    })
}

/// Has a structure built for where the vertices of an object will be at about a time: count positions, one for each
/// vertex, as rtUpdateVertices() takes them. Nothing moves by that. Of the key frames of an object, the one nearest
/// to its RT_OBJECT_TIME (see rtObjectParameterf()) is active: its structure follows the vertices then, if the
/// update strategy is RT_LAZY or RT_REFIT; others do without. Good for animations that tear a mesh apart. A key
/// frame of the same time is replaced. rtEndObject() and rtDeleteKeyFrames() delete all of an object.
///
/// Errors: RT_INVALID_VALUE when there is no such object, count is not the number of its vertices, the time is not
/// finite, the stride is negative, or vertices is NULL; RT_INVALID_OPERATION between rtBegin() and rtEnd();
/// RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtKeyFrame(
    object: RTuint,
    time: RTfloat,
    count: RTsizei,
    stride: RTsizei,
    vertices: *const RTfloat,
) {
    guard(|cx| {
        vertex_range(cx.get_object_parameters(object)?.vertex_count, 0, count)?;
        // SAFETY: NULL or `count` vectors, says the manual.
        cx.key_frame(object, time, unsafe { vectors(count, stride, vertices)? })
    })
}

/// Deletes the key frames of an object.
///
/// Errors: RT_INVALID_VALUE when there is no such object, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtDeleteKeyFrames(object: RTuint) {
    guard(|cx| cx.delete_key_frames(object))
}

/// Changes the normals of an object as rtUpdateVertices() changes its vertices.
///
/// Errors: as rtUpdateVertices(); RT_INVALID_OPERATION also when the object was defined without normals.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtUpdateNormals(
    object: RTuint,
    first: RTsizei,
    count: RTsizei,
    stride: RTsizei,
    normals: *const RTfloat,
) {
    guard(|cx| {
        let first = vertex_range(cx.get_object_parameters(object)?.vertex_count, first, count)?;
        // SAFETY: NULL or `count` vectors, says the manual.
        cx.update_normals(object, first, unsafe { vectors(count, stride, normals)? })
    })
}

/// Asked before any vertex is read: a range beyond the object may be one beyond the memory, too.
fn vertex_range(vertices: u32, first: RTsizei, count: RTsizei) -> Result<u32> {
    match (u32::try_from(first), u32::try_from(count)) {
        (Ok(first), Ok(count)) if u64::from(first) + u64::from(count) <= u64::from(vertices) => Ok(first),
        _ => Err(Error::invalid_value(format_args!(
            "the object has {vertices} vertices; first is {first} and count {count}"
        ))),
    }
}

/// Stores the address of an array at params: RT_VERTEX_ARRAY_POINTER, RT_NORMAL_ARRAY_POINTER,
/// RT_COLOR_ARRAY_POINTER or RT_TEXTURE_COORD_ARRAY_POINTER.
///
/// Errors: RT_INVALID_ENUM for another pname, RT_INVALID_VALUE when params is NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetPointerv(pname: RTenum, params: *mut *mut c_void) {
    // SAFETY: `params` is NULL or a place for one pointer, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard_session(|session| {
        session.outside_begin()?;
        let array = match pname {
            RT_VERTEX_ARRAY_POINTER => &session.arrays.vertex,
            RT_NORMAL_ARRAY_POINTER => &session.arrays.normal,
            RT_COLOR_ARRAY_POINTER => &session.arrays.color,
            RT_TEXTURE_COORD_ARRAY_POINTER => &session.arrays.tex_coord,
            _ => return Err(unknown("pname", pname, "the pointer of a vertex array")),
        };
        params.set(&[array.pointer.cast_mut()])
    })
}
