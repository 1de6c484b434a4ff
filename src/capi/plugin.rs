//! Shader libraries: classes loaded from a file by name.

use super::pointer::value;
use super::shader_class::{RTqueryShaderClass, RTshaderClass, check_version, class_of};
use crate::api::{Error, ErrorCode, Result, ShaderClass};
use std::ffi::{CStr, CString, c_char, c_void};

/// What a shader library exports; the header describes it as `RTqueryShaderClass`.
const SYMBOL: &CStr = c"openrtQueryShaderClass";

fn io(message: String) -> Error {
    Error::new(ErrorCode::Io, message)
}

/// The class called `name` of the shader library `file`.
pub(super) fn load(name: &str, file: &str) -> Result<ShaderClass> {
    let c_name = CString::new(name).map_err(|_| Error::invalid_value("the class name holds a zero byte"))?;
    let query = query_function(file)?;
    // SAFETY: the library exports it as RTqueryShaderClass; the name is a string until it returns.
    let class: *const RTshaderClass = unsafe { query(c_name.as_ptr()) };
    if class.is_null() {
        return Err(Error::invalid_value(format!("{file}: the library has no shader class \"{name}\"")));
    }
    // The version comes first in the structure, whatever follows in other versions.
    // SAFETY: not NULL, so a class by the contract of the library.
    let version = unsafe { value("the class", class.cast::<u32>())? };
    check_version(version).map_err(|e| io(format!("{file}, class \"{name}\": {}", e.message)))?;
    // SAFETY: as above, and of our version.
    let class = unsafe { value("the class", class)? };
    // SAFETY: what it points to is valid until the process ends: the library is never unloaded.
    unsafe { class_of(&class) }.map_err(|e| Error::new(e.code, format!("{file}: {}", e.message)))
}

/// Loads `file`, for good, and finds its query function.
fn query_function(file: &str) -> Result<unsafe extern "C" fn(*const c_char) -> *const RTshaderClass> {
    let path = CString::new(file).map_err(|_| Error::invalid_value("the file name holds a zero byte"))?;
    // SAFETY: the path is a string; initialisers of the library are the application's own code.
    let library: *mut c_void = unsafe { libc::dlopen(path.as_ptr(), libc::RTLD_NOW | libc::RTLD_LOCAL) };
    if library.is_null() {
        return Err(io(format!("{file}: {}", last_error())));
    }
    // SAFETY: a handle from dlopen, and a string.
    let symbol = unsafe { libc::dlsym(library, SYMBOL.as_ptr()) };
    if symbol.is_null() {
        let symbol = SYMBOL.to_string_lossy();
        return Err(io(format!("{file}: not a shader library: it does not export {symbol}")));
    }
    // SAFETY: an Option of a function pointer has the size of a pointer; a symbol of this name has this type, says the manual.
    let query = unsafe { std::mem::transmute::<*mut c_void, RTqueryShaderClass>(symbol) };
    query.ok_or_else(|| io(format!("{file}: the query function is at NULL")))
}

fn last_error() -> String {
    // SAFETY: takes no arguments; returns NULL or a string that is valid until the next dl call of this thread.
    let text = unsafe { libc::dlerror() };
    if text.is_null() {
        return "unknown error of the dynamic loader".to_owned();
    }
    // SAFETY: not NULL, so a string, copied at once.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
}
