//! Shader classes and shaders.

use super::constants::*;
use super::guard::guard;
use super::plugin;
use super::pointer::{OutArray, answer, text, value};
use super::refusal::unknown;
use super::shader_class::{RTshaderClass, check_version, class_of};
use super::types::*;
use crate::api::{Error, ParamScope, ParamType, ShaderClass, ShaderKind};
use std::ffi::c_char;

/// Returns a name for a shader class, and binds the class; 0 on failure. With file NULL the class is one of
/// those that the library brings, which the table before this function lists. Otherwise file is the path of a
/// shader library that exports the function openrtQueryShaderClass (see RTqueryShaderClass); the library stays
/// loaded until the process ends. Asked again for the same class of the same file, it returns the same name.
///
/// A shader library calls the rts functions of the program's own openrt: link it against libopenrt.so, or, if
/// the program contains libopenrt.a, link the program with -rdynamic and the shader library against nothing.
///
/// Errors: RT_INVALID_VALUE when name is NULL, there is no such class, or the class contradicts itself;
/// RT_IO_ERROR when the library cannot be loaded, has no openrtQueryShaderClass or is made for another version;
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGenNewShaderClass(name: *const c_char, file: *const c_char) -> RTuint {
    guard(|cx| {
        // SAFETY: `name` is NULL or a string, says the manual; it is read before we return.
        let name = unsafe { text("name", name)? };
        cx.is_shader(0)?;
        if file.is_null() {
            return cx.gen_new_shader_class(name);
        }
        // SAFETY: `file` is not NULL, so a string, says the manual; it is read before we return.
        let file = unsafe { text("file", file)? };
        cx.gen_loaded_shader_class(file, name, || plugin::load(name, file))
    })
}

/// Makes a shader class of the application's own functions, binds the class and returns its name; 0 on failure.
/// The structure and what it points to are copied, except userData. The functions must stay valid, and are
/// called from several threads at once while frames are rendered.
///
/// Errors: RT_INVALID_VALUE when the pointer is NULL, the version is not RT_SHADER_CLASS_VERSION, or the class
/// contradicts itself, as rtGetErrorString() says; RT_INVALID_ENUM for an unknown kind, type or scope;
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtRegisterShaderClass(shaderClass: *const RTshaderClass) -> RTuint {
    guard(|cx| {
        cx.is_shader(0)?;
        // The version comes first in the structure, whatever follows in other versions.
        // SAFETY: `shaderClass` is NULL or points to a class, says the manual.
        check_version(unsafe { value("shaderClass", shaderClass.cast::<RTuint>())? })?;
        // SAFETY: as above, and of our version; it is copied before we return.
        let class = unsafe { value("shaderClass", shaderClass)? };
        // SAFETY: the pointers in it are valid until we return, says the manual.
        cx.register_shader_class(unsafe { class_of(&class)? })
    })
}

/// Makes a shader of the bound class with the default parameters of the class, binds it, and returns its name;
/// 0 on failure.
///
/// Errors: RT_INVALID_OPERATION when no class is bound, or between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtGenNewShader() -> RTuint {
    guard(|cx| cx.gen_new_shader())
}

/// Binds a shader class, for rtGenNewShader() and rtParameterHandle(), and unbinds the shader. 0 binds none.
///
/// Errors: RT_INVALID_VALUE when there is no such class, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtBindShaderClass(shaderClass: RTuint) {
    guard(|cx| cx.bind_shader_class(shaderClass))
}

/// Binds a shader and its class: parameters are set on it, and triangles that follow have it as their surface.
/// 0 binds the default surface, which is grey.
///
/// Errors: RT_INVALID_VALUE when there is no such shader, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtBindShader(shader: RTuint) {
    guard(|cx| cx.bind_shader(shader))
}

/// Deletes a shader; 0 is passed over. It is unbound, and no longer a light, camera, environment or rendering
/// object. Triangles that have it get the default surface from the next frame on.
///
/// Errors: RT_INVALID_VALUE when there is no such shader, RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtDeleteShader(shader: RTuint) {
    guard(|cx| cx.delete_shader(shader))
}

/// RT_TRUE when shader names a shader.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub extern "C" fn rtIsShader(shader: RTuint) -> RTboolean {
    guard(|cx| cx.is_shader(shader).map(RTboolean::from))
}

/// Returns the handle of the parameter called name of the bound class; 0 on failure. It serves all shaders of
/// the class.
///
/// Errors: RT_INVALID_OPERATION when no class is bound, or between rtBegin() and rtEnd(); RT_INVALID_VALUE when
/// name is NULL or the class has no such parameter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtParameterHandle(name: *const c_char) -> RTuint {
    // SAFETY: `name` is NULL or a string, says the manual; it is read before we return.
    let name = unsafe { text("name", name) };
    guard(|cx| cx.parameter_handle(name?))
}

/// Stores what a shader class is at params: RT_SHADER_KIND (RT_SURFACE_SHADER, RT_LIGHT_SHADER,
/// RT_CAMERA_SHADER, RT_ENVIRONMENT_SHADER or RT_RENDERING_OBJECT) or RT_PARAMETER_COUNT.
///
/// Errors: RT_INVALID_ENUM for another pname; RT_INVALID_VALUE when there is no such class or params is NULL;
/// RT_INVALID_OPERATION between rtBegin() and rtEnd().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetShaderClassiv(shaderClass: RTuint, pname: RTenum, params: *mut RTint) {
    // SAFETY: `params` is NULL or a place for one value, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard(|cx| {
        let class = cx.get_shader_class(shaderClass)?;
        params.set(&[match pname {
            RT_SHADER_KIND => number_of_kind(class.kind) as RTint,
            RT_PARAMETER_COUNT => class.params.len() as RTint,
            _ => return Err(unknown("pname", pname, "a property of shader classes")),
        }])
    })
}

/// Stores what parameter index of a shader class is at params: RT_PARAMETER_TYPE (as in RTshaderParam),
/// RT_PARAMETER_SCOPE or RT_PARAMETER_SIZE in bytes. Errors: as rtGetShaderClassiv(); RT_INVALID_VALUE also
/// when the class has no more parameters.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtGetShaderClassParameteriv(
    shaderClass: RTuint,
    index: RTuint,
    pname: RTenum,
    params: *mut RTint,
) {
    // SAFETY: `params` is NULL or a place for one value, says the manual.
    let params = unsafe { OutArray::new(params) };
    guard(|cx| {
        let class = cx.get_shader_class(shaderClass)?;
        let param = class.params.get(index as usize).ok_or_else(|| no_parameter(&class, index))?;
        let (kind, size) = number_of_type(param.ty);
        params.set(&[match pname {
            RT_PARAMETER_TYPE => kind as RTint,
            RT_PARAMETER_SIZE => size as RTint,
            RT_PARAMETER_SCOPE => number_of_scope(param.scope) as RTint,
            _ => return Err(unknown("pname", pname, "a property of shader parameters")),
        }])
    })
}

/// Returns the name of a shader class; NULL on failure. The text is valid until the process ends. Errors: as
/// rtGetShaderClassiv().
#[unsafe(no_mangle)]
pub extern "C" fn rtGetShaderClassName(shaderClass: RTuint) -> *const c_char {
    guard(|cx| answer(&cx.get_shader_class(shaderClass)?.name))
}

/// Returns the name of parameter index of a shader class; NULL on failure. See rtGetShaderClassName().
#[unsafe(no_mangle)]
pub extern "C" fn rtGetShaderClassParameterName(shaderClass: RTuint, index: RTuint) -> *const c_char {
    guard(|cx| {
        let class = cx.get_shader_class(shaderClass)?;
        answer(&class.params.get(index as usize).ok_or_else(|| no_parameter(&class, index))?.name)
    })
}

fn no_parameter(class: &ShaderClass, index: RTuint) -> Error {
    let (name, count) = (&class.name, class.params.len());
    Error::invalid_value(format_args!("shader class \"{name}\" has no parameter number {index}, only {count}"))
}

fn number_of_kind(kind: ShaderKind) -> RTenum {
    match kind {
        ShaderKind::Surface => RT_SURFACE_SHADER,
        ShaderKind::Light => RT_LIGHT_SHADER,
        ShaderKind::Camera => RT_CAMERA_SHADER,
        ShaderKind::Environment => RT_ENVIRONMENT_SHADER,
        ShaderKind::Renderer => RT_RENDERING_OBJECT,
    }
}

/// Number and size in bytes.
fn number_of_type(ty: ParamType) -> (RTenum, u32) {
    match ty {
        ParamType::Int(2) => (RT_INT_VEC2, 8),
        ParamType::Int(3) => (RT_INT_VEC3, 12),
        ParamType::Int(4) => (RT_INT_VEC4, 16),
        ParamType::Int(_) => (RT_INT, 4),
        ParamType::Float(2) => (RT_FLOAT_VEC2, 8),
        ParamType::Float(3) => (RT_FLOAT_VEC3, 12),
        ParamType::Float(4) => (RT_FLOAT_VEC4, 16),
        ParamType::Float(_) => (RT_FLOAT, 4),
        ParamType::Matrix => (RT_FLOAT_MAT4, 64),
        ParamType::String => (RT_STRING, size_of::<usize>() as u32),
        ParamType::Texture => (RT_TEXTURE, 4),
        ParamType::Raw(n) => (RT_RAW, n),
    }
}

fn number_of_scope(scope: ParamScope) -> RTenum {
    match scope {
        ParamScope::Shader => RT_PER_SHADER,
        ParamScope::Triangle => RT_PER_TRIANGLE,
        ParamScope::Vertex => RT_PER_VERTEX,
    }
}
