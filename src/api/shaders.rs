//! Shader classes, shaders, and parameters by handle.
//!
//! A handle names one parameter of one class. Values are bound late: what a parameter holds when a frame starts counts for the whole
//! frame, so only the last of many changes travels to the back-end. Per-vertex and per-triangle parameters are captured
//! where `vertex` is called or a triangle is completed.

use super::class_check::check_class;
use super::context::Context;
use super::error::{Error, Result};
use super::names::Names;
use super::near_miss::NearMiss;
use super::objects::no_names;
use super::parameter_value::{Described, from_bytes, zero_padded};
use crate::memory::{self, collected, repeated};
use crate::scene::{Command, Name, ParamScope, ParamType, ParamValue, ShaderClass};
use std::collections::HashMap;
use std::sync::Arc;

/// A shader of the application's.
pub(super) struct ShaderState {
    pub class_name: Name,
    pub class: Arc<ShaderClass>,
    pub values: Vec<ParamValue>,
    given: Vec<bool>,
    /// Which values the back-end has not been sent.
    changed: Vec<bool>,
    any_changed: bool,
}

#[derive(Default)]
pub(super) struct Shaders {
    class_names: Names,
    classes: HashMap<Name, Arc<ShaderClass>>,
    /// Handle → (class, parameter); handle 0 is none, so entry 0 is handle 1.
    handles: Vec<(Name, u32)>,
    first_handle: HashMap<Name, u32>,
    shader_names: Names,
    shaders: HashMap<Name, ShaderState>,
    /// Shaders with a changed value, in the order of the first change.
    changed: Vec<Name>,
    bound_class: Name,
    bound: Name,
    built_in: Vec<Arc<ShaderClass>>,
    /// What built-in classes (of no file) and those of shader libraries were named: file, zero byte, class.
    named: HashMap<String, Name>,
}

impl Shaders {
    #[inline]
    pub fn bound(&self) -> Name {
        self.bound
    }

    pub fn bound_class(&self) -> Name {
        self.bound_class
    }

    pub fn get(&self, shader: Name) -> Option<&ShaderState> {
        self.shaders.get(&shader)
    }

    /// The class that the library itself brings under this name.
    pub fn built_in(&mut self, name: &str) -> Option<Arc<ShaderClass>> {
        if self.built_in.is_empty() {
            self.built_in = crate::backend::builtin_classes();
        }
        self.built_in.iter().find(|c| &*c.name == name).cloned()
    }

    /// The parameter behind `handle`, which must belong to the class of the bound shader.
    fn resolve(&mut self, handle: u32) -> Result<(&mut ShaderState, usize)> {
        let entry = (handle as usize).checked_sub(1).and_then(|i| self.handles.get(i));
        let &(class, param) =
            entry.ok_or_else(|| Error::invalid_value(format_args!("{handle} is not a parameter handle")))?;
        let state = self.shaders.get_mut(&self.bound).ok_or_else(|| Error::invalid_operation("no shader is bound"))?;
        if state.class_name != class {
            let text = |class: &Name| self.classes.get(class).map_or("none", |class| &*class.name);
            let (of, bound) = (text(&class), &state.class.name);
            return Err(Error::invalid_operation(format_args!(
                "handle {handle} is of shader class \"{of}\", and the bound shader of class \"{bound}\""
            )));
        }
        Ok((state, param as usize))
    }
}

impl Context {
    /// The name of the built-in class `class`, the same whenever it is asked for, and binds it.
    ///
    /// # Errors
    /// `InvalidValue` when there is no built-in class of this name.
    pub fn gen_new_shader_class(&mut self, class: &str) -> Result<Name> {
        self.outside_begin()?;
        self.named_class("", class, |cx| {
            cx.shaders.built_in(class).ok_or_else(|| {
                let known = cx.shaders.built_in.iter().map(|class| &*class.name);
                Error::invalid_value(format_args!(
                    "there is no built-in shader class \"{class}\"{}",
                    NearMiss::among(class, known)
                ))
            })
        })
    }

    /// Binds the class called `class` of the shader library `file`, which `load` reads when it is first asked for.
    ///
    /// # Errors
    /// Those of `load`; `InvalidValue` when the class contradicts itself.
    pub(crate) fn gen_loaded_shader_class(
        &mut self,
        file: &str,
        class: &str,
        load: impl FnOnce() -> Result<ShaderClass>,
    ) -> Result<Name> {
        self.outside_begin()?;
        self.named_class(file, class, |_| {
            let class = load()?;
            check_class(&class)?;
            Ok(Arc::new(class))
        })
    }

    /// The class that was named before, or another one, which `make` makes; it is bound.
    fn named_class(
        &mut self,
        file: &str,
        class: &str,
        make: impl FnOnce(&mut Self) -> Result<Arc<ShaderClass>>,
    ) -> Result<Name> {
        let mut key = String::new();
        key.try_reserve_exact(file.len() + 1 + class.len())?;
        [file, "\0", class].iter().for_each(|part| key.push_str(part));
        if let Some(&name) = self.shaders.named.get(&key) {
            self.bind_shader_class(name)?;
            return Ok(name);
        }
        self.shaders.named.try_reserve(1)?;
        let class = make(self)?;
        let name = self.add_class(class)?;
        self.shaders.named.insert(key, name);
        Ok(name)
    }

    /// Names a class of the application's and binds it.
    ///
    /// # Errors
    /// `InvalidValue` when the class contradicts itself; the message says where.
    pub fn register_shader_class(&mut self, class: ShaderClass) -> Result<Name> {
        self.outside_begin()?;
        check_class(&class)?;
        self.add_class(Arc::new(class))
    }

    fn add_class(&mut self, class: Arc<ShaderClass>) -> Result<Name> {
        self.backend.reserve(1)?;
        let shaders = &mut self.shaders;
        shaders.classes.try_reserve(1)?;
        shaders.first_handle.try_reserve(1)?;
        shaders.handles.try_reserve(class.params.len())?;
        let name = shaders.class_names.generate(1).ok_or_else(|| no_names(1))?;
        shaders.first_handle.insert(name, shaders.handles.len() as u32 + 1);
        shaders.handles.extend((0..class.params.len() as u32).map(|param| (name, param)));
        shaders.classes.insert(name, class.clone());
        shaders.bound_class = name;
        shaders.bound = 0;
        self.backend.send(Command::DefineClass { name, class });
        Ok(name)
    }

    /// Binds a class for `gen_new_shader` and `parameter_handle`, and unbinds the current shader. 0 binds none.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such class.
    pub fn bind_shader_class(&mut self, class: Name) -> Result<()> {
        self.outside_begin()?;
        if class != 0 && !self.shaders.classes.contains_key(&class) {
            return Err(no_class(class));
        }
        self.shaders.bound_class = class;
        self.shaders.bound = 0;
        Ok(())
    }

    /// Makes a shader of the bound class, with the defaults of the class, and binds it.
    ///
    /// # Errors
    /// `InvalidOperation` when no class is bound.
    pub fn gen_new_shader(&mut self) -> Result<Name> {
        self.outside_begin()?;
        let class_name = self.shaders.bound_class;
        let Some(class) = self.shaders.classes.get(&class_name).cloned() else {
            return Err(Error::invalid_operation("no shader class is bound"));
        };
        self.backend.reserve(1)?;
        let shaders = &mut self.shaders;
        shaders.shaders.try_reserve(1)?;
        let name = shaders.shader_names.generate(1).ok_or_else(|| no_names(1))?;
        let values = collected(class.params.iter().map(|p| p.default.clone()))?;
        let (changed, given) = (repeated(false, class.params.len())?, repeated(false, class.params.len())?);
        shaders.shaders.insert(name, ShaderState { class_name, class, values, given, changed, any_changed: false });
        shaders.bound = name;
        self.backend.send(Command::DefineShader { name, class: class_name });
        Ok(name)
    }

    /// Binds a shader, and its class: the one that parameters go to and that following triangles have. 0 binds the default
    /// surface, grey and lit as if by a lamp at the eye when the frame has no lights.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such shader.
    pub fn bind_shader(&mut self, shader: Name) -> Result<()> {
        self.outside_begin()?;
        self.shaders.bound_class = match self.shaders.get(shader) {
            Some(state) => state.class_name,
            None if shader == 0 => 0,
            None => return Err(no_shader(shader)),
        };
        self.shaders.bound = shader;
        Ok(())
    }

    /// Deletes a shader; 0 is ignored. It is unbound, and no longer a light, camera, environment or rendering object; triangles that
    /// refer to it are shown with the default surface from the next frame on.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such shader.
    pub fn delete_shader(&mut self, shader: Name) -> Result<()> {
        self.outside_begin()?;
        if shader == 0 {
            return Ok(());
        }
        if self.shaders.get(shader).is_none() {
            return Err(no_shader(shader));
        }
        self.backend.reserve(1)?;
        self.shaders.shaders.remove(&shader);
        self.shaders.shader_names.release(shader, shader + 1);
        self.shaders.changed.retain(|&n| n != shader);
        if self.shaders.bound == shader {
            self.shaders.bound = 0;
        }
        self.content.forget_shader(shader);
        self.backend.send(Command::DeleteShader { name: shader });
        Ok(())
    }

    /// Whether `shader` is a shader.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn is_shader(&self, shader: Name) -> Result<bool> {
        self.outside_begin()?;
        Ok(self.shaders.get(shader).is_some())
    }

    /// The class behind a class name.
    ///
    /// # Errors
    /// `InvalidValue` when there is no such class.
    pub fn get_shader_class(&self, class: Name) -> Result<Arc<ShaderClass>> {
        self.outside_begin()?;
        self.shaders.classes.get(&class).cloned().ok_or_else(|| no_class(class))
    }

    /// The handle of parameter `name` of the bound class.
    ///
    /// # Errors
    /// `InvalidOperation` when no class is bound, `InvalidValue` when it has no such parameter.
    pub fn parameter_handle(&self, name: &str) -> Result<u32> {
        self.outside_begin()?;
        let Some(class) = self.shaders.classes.get(&self.shaders.bound_class) else {
            return Err(Error::invalid_operation("no shader class is bound"));
        };
        match class.param_index(name) {
            Some(param) => Ok(self.shaders.first_handle[&self.shaders.bound_class] + param),
            None => {
                let near = NearMiss::among(name, class.params.iter().map(|param| &*param.name));
                let class = &class.name;
                Err(Error::invalid_value(format_args!("shader class \"{class}\" has no parameter \"{name}\"{near}")))
            }
        }
    }

    /// Sets an integer parameter of the bound shader. A texture parameter takes one integer, the texture's name, too.
    ///
    /// # Errors
    /// `InvalidValue` for a number that is no handle, or no texture; `InvalidOperation` when no shader is bound, the handle belongs
    /// to another class, or the parameter is not `values.len()` integers. Allowed between begin and end.
    pub fn parameter_i(&mut self, handle: u32, values: &[i32]) -> Result<()> {
        self.usable()?;
        let (state, param) = self.shaders.resolve(handle)?;
        match (state.class.params[param].ty, values) {
            (ParamType::Int(n), _) if usize::from(n) == values.len() => {
                self.store(param, ParamValue::Int(zero_padded(values)))
            }
            (ParamType::Texture, &[name]) => self.parameter_texture(handle, name as Name),
            _ => Err(type_mismatch(state, param, ParamType::Int(values.len() as u8))),
        }
    }

    /// Sets a float parameter; as [`Context::parameter_i`].
    ///
    /// # Errors
    /// Also `InvalidValue` for NaN.
    pub fn parameter_f(&mut self, handle: u32, values: &[f32]) -> Result<()> {
        self.usable()?;
        let (state, param) = self.shaders.resolve(handle)?;
        match state.class.params[param].ty {
            ParamType::Float(n) if usize::from(n) == values.len() => {
                not_nan(values)?;
                self.store(param, ParamValue::Float(zero_padded(values)))
            }
            _ => Err(type_mismatch(state, param, ParamType::Float(values.len() as u8))),
        }
    }

    /// Sets a matrix parameter, column-major; as [`Context::parameter_f`].
    ///
    /// # Errors
    /// As [`Context::parameter_f`].
    pub fn parameter_matrix(&mut self, handle: u32, matrix: &[f32; 16]) -> Result<()> {
        self.usable()?;
        let (state, param) = self.shaders.resolve(handle)?;
        if state.class.params[param].ty != ParamType::Matrix {
            return Err(type_mismatch(state, param, ParamType::Matrix));
        }
        not_nan(matrix)?;
        self.store(param, ParamValue::Matrix(*matrix))
    }

    /// Sets a string parameter to a copy of `text`; as [`Context::parameter_i`].
    ///
    /// # Errors
    /// As [`Context::parameter_i`]; `InvalidValue` for a text that the parameter does not take, see [`super::ParamDef::choices`].
    pub fn parameter_string(&mut self, handle: u32, text: &str) -> Result<()> {
        self.usable()?;
        let (state, param) = self.shaders.resolve(handle)?;
        let def = &state.class.params[param];
        if def.ty != ParamType::String {
            return Err(type_mismatch(state, param, ParamType::String));
        }
        if !def.choices.is_empty() && !def.choices.contains(&text) {
            let near = NearMiss::among(text, def.choices.iter().copied());
            let (name, choices) = (&def.name, def.choices);
            return Err(Error::invalid_value(format_args!(
                "parameter \"{name}\" cannot be \"{text}\"{near}; it is one of {choices:?}"
            )));
        }
        let text = memory::made(text.len(), || text.into())?;
        self.store(param, ParamValue::String(text))
    }

    /// Sets a parameter of any type but string from its bytes (native-endian, texture names as `u32`).
    ///
    /// # Errors
    /// As [`Context::parameter_i`]; `InvalidOperation` when the size differs.
    pub fn parameter_raw(&mut self, handle: u32, bytes: &[u8]) -> Result<()> {
        self.usable()?;
        let (state, param) = self.shaders.resolve(handle)?;
        let given = || type_mismatch(state, param, ParamType::Raw(bytes.len() as u32));
        let ty = state.class.params[param].ty;
        match memory::made(bytes.len(), || from_bytes(ty, bytes))?.ok_or_else(given)? {
            ParamValue::Texture(name) => self.parameter_texture(handle, name),
            ParamValue::Float(values) => {
                not_nan(&values)?;
                self.store(param, ParamValue::Float(values))
            }
            ParamValue::Matrix(values) => {
                not_nan(&values)?;
                self.store(param, ParamValue::Matrix(values))
            }
            value => self.store(param, value),
        }
    }

    /// Sets a texture parameter to a texture object; 0 is none.
    ///
    /// # Errors
    /// As [`Context::parameter_i`]; `InvalidValue` when there is no such texture.
    pub fn parameter_texture(&mut self, handle: u32, texture: Name) -> Result<()> {
        self.usable()?;
        let (state, param) = self.shaders.resolve(handle)?;
        if state.class.params[param].ty != ParamType::Texture {
            return Err(type_mismatch(state, param, ParamType::Texture));
        }
        if texture != 0 && !self.textures.contains(texture) {
            return Err(Error::invalid_value(format_args!("there is no texture {texture}")));
        }
        self.store(param, ParamValue::Texture(texture))
    }

    /// The value that a parameter of the bound shader has.
    ///
    /// # Errors
    /// As [`Context::parameter_i`]; `InvalidOperation` between begin and end.
    pub fn get_parameter(&mut self, handle: u32) -> Result<ParamValue> {
        self.outside_begin()?;
        let (state, param) = self.shaders.resolve(handle)?;
        Ok(state.values[param].clone())
    }

    /// Stores a value of the right type in the bound shader.
    fn store(&mut self, param: usize, value: ParamValue) -> Result<()> {
        self.shaders.changed.try_reserve(1)?;
        let bound = self.shaders.bound;
        let state = self.shaders.shaders.get_mut(&bound).expect("resolve() found the bound shader");
        // Programs that set everything in every frame shall not look as if they changed something.
        if std::mem::replace(&mut state.given[param], true) && state.values[param] == value {
            return Ok(());
        }
        if !state.any_changed {
            self.shaders.changed.push(bound);
            state.any_changed = true;
        }
        if state.class.params[param].scope != ParamScope::Shader
            && let ParamValue::Float(value) = value
            && let Some(capture) = self.captures.iter_mut().find(|c| c.param as usize == param)
        {
            // Outside begin and end the list is an old one; begin makes it anew.
            capture.value = value;
        }
        state.changed[param] = true;
        state.values[param] = value;
        Ok(())
    }

    /// Sends the last value of every parameter that changed.
    pub(super) fn send_parameters(&mut self) -> Result<()> {
        let shaders = &mut self.shaders;
        let count = shaders.changed.iter().map(|n| shaders.shaders[n].values.len()).sum();
        self.backend.reserve(count)?;
        for name in shaders.changed.drain(..) {
            let state = shaders.shaders.get_mut(&name).expect("deleted shaders leave the list");
            state.any_changed = false;
            for (param, changed) in state.changed.iter_mut().enumerate() {
                if std::mem::take(changed) {
                    let value = state.values[param].clone();
                    self.backend.send(Command::SetParameter { shader: name, param: param as u32, value });
                }
            }
        }
        Ok(())
    }
}

#[cold]
pub(super) fn no_shader(shader: Name) -> Error {
    Error::invalid_value(format_args!("there is no shader {shader}"))
}

#[cold]
fn no_class(class: Name) -> Error {
    Error::invalid_value(format_args!("there is no shader class {class}"))
}

/// A parameter was given a value of another type.
#[cold]
fn type_mismatch(state: &ShaderState, param: usize, given: ParamType) -> Error {
    let (def, class) = (&state.class.params[param], &state.class.name);
    let (name, wanted, given) = (&def.name, Described(def.ty), Described(given));
    Error::invalid_operation(format_args!(
        "parameter \"{name}\" of shader class \"{class}\" is {wanted}, and was given {given}"
    ))
}

fn not_nan(values: &[f32]) -> Result<()> {
    match values.iter().position(|v| v.is_nan()) {
        Some(at) => Err(Error::invalid_value(format_args!("number {at} of the value is NaN"))),
        None => Ok(()),
    }
}
