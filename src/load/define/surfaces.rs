//! Materials and lights as shaders of the built-in classes.

use crate::api::{Context, Error, Name};
use crate::load::{LightKind, Material, MetallicRoughness};
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
        if let Some(color) = m.unlit {
            let shader = self.make(context, "constant")?;
            self.floats(context, "color", &color.to_array())?;
            self.coverage(context, m, textures)?;
            return Ok(shader);
        }
        if let Some(surface) = &m.metallic_roughness {
            let shader = self.make(context, "metallic_roughness")?;
            self.metallic_roughness(context, surface, textures)?;
            self.coverage(context, m, textures)?;
            return Ok(shader);
        }
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
        self.coverage(context, m, textures)?;
        Ok(shader)
    }

    /// Sets the base texture, and what depends on its alpha.
    fn coverage(&self, context: &mut Context, m: &Material, textures: &[Name]) -> Result<(), Error> {
        if let Some(cutoff) = m.alpha_cutoff {
            self.floats(context, "alpha_threshold", &[cutoff])?;
        }
        if m.opacity != 1.0 {
            self.floats(context, "opacity", &[m.opacity])?;
        }
        if m.alpha_blend {
            let handle = context.parameter_handle("alpha_blend")?;
            context.parameter_i(handle, &[1])?;
        }
        self.texture(context, "texture", m.texture, textures)
    }

    fn texture(
        &self,
        context: &mut Context,
        parameter: &str,
        texture: Option<u32>,
        textures: &[Name],
    ) -> Result<(), Error> {
        let Some(&name) = texture.and_then(|t| textures.get(t as usize)) else { return Ok(()) };
        let handle = context.parameter_handle(parameter)?;
        context.parameter_texture(handle, name)
    }

    fn metallic_roughness(&self, context: &mut Context, m: &MetallicRoughness, textures: &[Name]) -> Result<(), Error> {
        let colors = [
            ("color", m.color),
            ("specular", m.specular),
            ("emission", m.emission),
            // Little, as the ambient light that scenes get stands for light that has met many surfaces.
            ("ambient", Vec3::splat(0.05)),
        ];
        for (parameter, color) in colors {
            self.floats(context, parameter, &color.to_array())?;
        }
        let numbers = [
            ("metallic", m.metallic),
            ("roughness", m.roughness),
            ("transmission", m.transmission),
            ("ior", m.ior),
            ("occlusion_strength", m.occlusion_strength),
        ];
        for (parameter, number) in numbers {
            self.floats(context, parameter, &[number])?;
        }
        self.floats(context, "normal_scale", &m.normal_scale.to_array())?;
        for (parameter, texture) in [
            ("metallic_roughness_texture", m.metallic_roughness_texture),
            ("normal_texture", m.normal_texture),
            ("occlusion_texture", m.occlusion_texture),
            ("emission_texture", m.emission_texture),
        ] {
            self.texture(context, parameter, texture, textures)?;
        }
        Ok(())
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
