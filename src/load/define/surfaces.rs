//! Materials and lights as shaders of the built-in classes.

use crate::api::{Context, Error, Name};
use crate::load::{LightKind, Material};
use glam::Vec3;
use std::collections::HashMap;

/// Makes shaders, with one class of each kind.
#[derive(Default)]
pub struct ShaderMaker {
    classes: HashMap<&'static str, Name>,
}

impl ShaderMaker {
    /// A new shader of a built-in class; it is bound afterwards.
    pub fn make(&mut self, context: &mut Context, class: &'static str) -> Result<Name, Error> {
        match self.classes.get(class) {
            Some(&name) => context.bind_shader_class(name)?,
            None => {
                let name = context.gen_new_shader_class(class)?;
                self.classes.insert(class, name);
            }
        }
        context.gen_new_shader()
    }

    pub fn floats(&self, context: &mut Context, parameter: &str, values: &[f32]) -> Result<(), Error> {
        let handle = context.parameter_handle(parameter)?;
        context.parameter_f(handle, values)
    }

    pub fn surface(&mut self, context: &mut Context, m: &Material, textures: &[Name]) -> Result<Name, Error> {
        let shader = self.make(context, "phong")?;
        let colors = [
            ("emission", m.emission),
            ("ambient", m.ambient),
            ("diffuse", m.diffuse),
            ("specular", m.specular),
            ("reflection", m.reflection),
            ("transmission", Vec3::splat(m.transmission)),
        ];
        for (parameter, color) in colors {
            self.floats(context, parameter, &color.to_array())?;
        }
        self.floats(context, "shininess", &[m.shininess])?;
        self.floats(context, "ior", &[m.ior])?;
        if let Some(cutoff) = m.alpha_cutoff {
            self.floats(context, "alpha_threshold", &[cutoff])?;
        }
        if let Some(&texture) = m.texture.and_then(|t| textures.get(t as usize)) {
            let handle = context.parameter_handle("texture")?;
            context.parameter_texture(handle, texture)?;
        }
        Ok(shader)
    }

    pub fn light(&mut self, context: &mut Context, kind: LightKind, color: Vec3) -> Result<Name, Error> {
        let class = match kind {
            LightKind::Point { .. } => "point",
            LightKind::Directional => "directional",
            LightKind::Spot { .. } => "spot",
        };
        let shader = self.make(context, class)?;
        self.floats(context, "color", &color.to_array())?;
        if matches!(kind, LightKind::Point { attenuated: true } | LightKind::Spot { .. }) {
            self.floats(context, "attenuation", &[0.0, 0.0, 1.0])?;
        }
        if let LightKind::Spot { inner, outer } = kind {
            self.floats(context, "cutoff", &[outer])?;
            self.floats(context, "penumbra", &[(outer - inner).max(0.0)])?;
        }
        Ok(shader)
    }
}
