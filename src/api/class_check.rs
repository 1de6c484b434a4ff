//! Whether a shader class of the application's makes sense.

use super::error::{Error, Result};
use super::parameter_value::byte_size;
use crate::scene::{ParamDef, ParamScope, ParamType, ParamValue, Program, ShaderClass, ShaderKind};
use std::collections::HashSet;

/// More parameters, or a larger block, are surely a mistake.
const MAX_PARAMS: usize = 4096;
const MAX_BLOCK_SIZE: u32 = 1 << 20;

/// Refuses classes whose parts contradict each other, so that nothing below needs to check again.
pub(super) fn check_class(class: &ShaderClass) -> Result<()> {
    let refuse = |why: &str| Err(Error::invalid_value(format!("shader class \"{}\": {why}", class.name)));
    if class.name.is_empty() {
        return refuse("the name is empty");
    }
    let matches = matches!(
        (&class.program, class.kind),
        (Program::Surface(_), ShaderKind::Surface)
            | (Program::Light(_), ShaderKind::Light)
            | (Program::Camera(_), ShaderKind::Camera)
            | (Program::Environment(_), ShaderKind::Environment)
    );
    if !matches {
        return refuse(&format!("its program is not that of a {:?} shader", class.kind));
    }
    if class.params.len() > MAX_PARAMS || class.block_size > MAX_BLOCK_SIZE {
        let (params, bytes) = (class.params.len(), class.block_size);
        return refuse(&format!(
            "{params} parameters in a block of {bytes} bytes; there may be {MAX_PARAMS} in {MAX_BLOCK_SIZE} bytes"
        ));
    }
    let mut names = HashSet::new();
    for param in &class.params {
        if let Err(why) = check_param(param, class) {
            return refuse(&format!("parameter \"{}\": {why}", param.name));
        }
        if !names.insert(&param.name) {
            return refuse(&format!("two parameters are called \"{}\"", param.name));
        }
    }
    Ok(())
}

fn check_param(param: &ParamDef, class: &ShaderClass) -> std::result::Result<(), &'static str> {
    if param.name.is_empty() {
        return Err("the name is empty");
    }
    let fits = match (param.ty, &param.default) {
        (ParamType::Int(n), ParamValue::Int(_)) | (ParamType::Float(n), ParamValue::Float(_)) => (1..=4).contains(&n),
        (ParamType::Matrix, ParamValue::Matrix(_)) | (ParamType::String, ParamValue::String(_)) => true,
        (ParamType::Texture, &ParamValue::Texture(name)) => name == 0,
        (ParamType::Raw(n), ParamValue::Raw(bytes)) => bytes.len() == n as usize,
        _ => false,
    };
    if !fits {
        return Err("the default is not of the parameter's type");
    }
    if param.scope != ParamScope::Shader && !matches!(param.ty, ParamType::Float(_)) {
        return Err("only floats can be given per triangle or per vertex");
    }
    if param.scope != ParamScope::Shader && class.kind != ShaderKind::Surface {
        return Err("only surfaces have parameters per triangle or per vertex");
    }
    if u64::from(param.offset) + byte_size(param.ty) as u64 > u64::from(class.block_size) {
        return Err("it lies outside the parameter block");
    }
    Ok(())
}
