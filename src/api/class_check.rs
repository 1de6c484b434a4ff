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
    check_sizes(&class.name, class.params.len() as u64, class.block_size)?;
    let mut names = HashSet::new();
    let mut layout = Layout::new(class.block_size);
    for param in &class.params {
        if let Err(why) = check_param(param, class, &mut layout) {
            return refuse(&format!("parameter \"{}\": {why}", param.name));
        }
        if !names.insert(&param.name) {
            return refuse(&format!("two parameters are called \"{}\"", param.name));
        }
    }
    Ok(())
}

fn check_param(param: &ParamDef, class: &ShaderClass, layout: &mut Layout) -> std::result::Result<(), &'static str> {
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
    layout.place(param.ty, param.offset)
}

/// Refuses sizes that no class has, before anything is made of what they tell.
///
/// # Errors
/// `InvalidValue`.
pub fn check_sizes(class: &str, params: u64, block_size: u32) -> Result<()> {
    if params > MAX_PARAMS as u64 || block_size > MAX_BLOCK_SIZE {
        let sizes = format!("{params} parameters in a block of {block_size} bytes");
        let most = format!("at most {MAX_PARAMS} in {MAX_BLOCK_SIZE} are possible");
        return Err(Error::invalid_value(format!("shader class \"{class}\": {sizes}; {most}")));
    }
    Ok(())
}

/// The parameter block of a class, while its parameters are gone through.
pub struct Layout {
    block_size: u32,
    /// Bytes of the raw parameters so far. Others are small, and may lie over each other.
    raw: u64,
}

impl Layout {
    pub fn new(block_size: u32) -> Self {
        Self { block_size, raw: 0 }
    }

    /// Refuses a parameter that reaches beyond the block, and a raw one after which all raw ones together are larger than it.
    ///
    /// # Errors
    /// Why.
    pub fn place(&mut self, ty: ParamType, offset: u32) -> std::result::Result<(), &'static str> {
        let size = byte_size(ty) as u64;
        if u64::from(offset) + size > u64::from(self.block_size) {
            return Err("it lies outside the parameter block");
        }
        if matches!(ty, ParamType::Raw(_)) {
            self.raw += size;
        }
        if self.raw > u64::from(self.block_size) {
            return Err("the raw parameters together are larger than the parameter block");
        }
        Ok(())
    }
}
