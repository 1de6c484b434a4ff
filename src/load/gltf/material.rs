//! Materials, and which of their properties are left out.

use super::file::document::Document;
use super::json::{self, TextureInfo};
use super::texture::{Textures, Values};
use crate::load::LoadError;
use crate::load::model::{Material, MetallicRoughness, SceneFile};
use glam::{Vec2, Vec3, Vec4};

/// What a primitive must know of its material.
#[derive(Clone, Copy, Default)]
pub struct Needs {
    /// Set of texture coordinates.
    pub tex_coord: u32,
}

/// Adds all materials behind the default one. The answer is by index in `SceneFile::materials`.
pub fn read(document: &Document, scene: &mut SceneFile) -> Result<Vec<Needs>, LoadError> {
    let mut textures = Textures::default();
    let mut needs = vec![Needs::default()];
    scene.materials[0] = Reader::new(document, scene, &mut textures, &json::Material::default(), None).read()?;
    scene.materials[0].name = "default".into();
    for (i, material) in document.root.materials.iter().enumerate() {
        let mut reader = Reader::new(document, scene, &mut textures, material, Some(i));
        let translated = reader.read()?;
        needs.push(Needs { tex_coord: reader.tex_coord.unwrap_or(0) });
        scene.materials.push(translated);
    }
    Ok(needs)
}

struct Reader<'r, 'a> {
    document: &'r Document<'a>,
    scene: &'r mut SceneFile,
    textures: &'r mut Textures,
    material: &'r json::Material,
    number: Option<usize>,
    /// Set of the first texture, which all must share.
    tex_coord: Option<u32>,
}

impl<'r, 'a> Reader<'r, 'a> {
    fn new(
        document: &'r Document<'a>,
        scene: &'r mut SceneFile,
        textures: &'r mut Textures,
        material: &'r json::Material,
        number: Option<usize>,
    ) -> Self {
        Self { document, scene, textures, material, number, tex_coord: None }
    }

    fn place(&self) -> String {
        match (self.number, &self.material.name) {
            (Some(i), Some(name)) => format!("materials[{i}] `{name}`"),
            (Some(i), None) => format!("materials[{i}]"),
            (None, _) => "the default material".into(),
        }
    }

    fn left_out(&self, what: &str) {
        self.document.left_out(self.place(), what);
    }

    fn texture(&mut self, info: Option<&TextureInfo>, values: Values, what: &str) -> Result<Option<u32>, LoadError> {
        let Some(info) = info else { return Ok(None) };
        let moved = info.extensions.as_ref().and_then(|e| e.transform.as_ref()).and_then(|t| t.tex_coord);
        let set = moved.unwrap_or(info.tex_coord);
        if *self.tex_coord.get_or_insert(set) != set {
            self.left_out(&format!(
                "{what} textures on another set of coordinates than the base colour's are left out"
            ));
            return Ok(None);
        }
        let place = self.place();
        self.textures.index(self.document, self.scene, info, values, || place.clone())
    }

    fn read(&mut self) -> Result<Material, LoadError> {
        let material = self.material;
        let extensions = material.extensions.as_deref();
        let none = json::MaterialExtensions::default();
        let extensions = extensions.unwrap_or(&none);
        let pbr = &material.pbr_metallic_roughness;
        let old = extensions.specular_glossiness.as_ref();
        let (factor, base_info) = match old {
            Some(old) => (old.diffuse_factor, old.diffuse_texture.as_deref()),
            None => (pbr.base_color_factor, pbr.base_color_texture.as_deref()),
        };
        let base = Vec4::from_array(factor);
        let texture = self.texture(base_info, Values::Color, "base colour")?;
        let mut translated =
            Material { name: material.name.as_deref().unwrap_or("").to_string(), texture, ..Material::default() };
        self.alpha(base.w, &mut translated);
        if extensions.unlit.is_some() {
            translated.unlit = Some(base.truncate());
            return Ok(translated);
        }
        let ior = extensions.ior.as_ref().map_or(1.5, |i| i.ior);
        let mut surface = MetallicRoughness {
            color: base.truncate(),
            metallic: pbr.metallic_factor,
            roughness: pbr.roughness_factor,
            // Reflectance at right angles: 4 % for the usual index of 1.5. Index 0 stands for a perfect mirror.
            specular: Vec3::splat(if ior == 0.0 { 1.0 } else { ((ior - 1.0) / (ior + 1.0)).powi(2) }),
            ..MetallicRoughness::default()
        };
        match old {
            Some(old) => {
                (surface.metallic, surface.roughness) = (0.0, 1.0 - old.glossiness_factor);
                surface.specular = Vec3::from_array(old.specular_factor);
                if old.specular_glossiness_texture.is_some() {
                    self.left_out("textures of specular colour and glossiness are left out");
                }
            }
            None => {
                let info = pbr.metallic_roughness_texture.as_deref();
                surface.metallic_roughness_texture = self.texture(info, Values::Data, "metallic-roughness")?;
            }
        }
        self.specular(extensions.specular.as_ref(), &mut surface);
        if let Some(t) = &extensions.transmission {
            surface.transmission = t.transmission_factor;
            // Without a volume the surface is a thin sheet, which does not bend light.
            let solid = extensions.volume.as_ref().is_some_and(|v| v.thickness_factor > 0.0);
            surface.ior = if solid && ior > 0.0 { ior } else { 1.0 };
            if t.transmission_texture.is_some() {
                self.left_out("textures of transmission are left out");
            }
        }
        let strength = extensions.emissive_strength.as_ref().map_or(1.0, |e| e.emissive_strength);
        surface.emission = Vec3::from_array(material.emissive_factor) * strength;
        if surface.emission != Vec3::ZERO {
            surface.emission_texture = self.texture(material.emissive_texture.as_deref(), Values::Color, "emissive")?;
        }
        if let Some(info) = material.normal_texture.as_deref() {
            surface.normal_texture = self.texture(Some(info), Values::Data, "normal")?;
            // The green of a normal points up in the image, which is against t.
            surface.normal_scale = Vec2::new(info.scale, -info.scale);
        }
        if let Some(info) = material.occlusion_texture.as_deref() {
            surface.occlusion_texture = self.texture(Some(info), Values::Data, "occlusion")?;
            surface.occlusion_strength = info.strength;
        }
        translated.metallic_roughness = Some(Box::new(surface));
        Ok(translated)
    }

    fn specular(&self, specular: Option<&json::Specular>, surface: &mut MetallicRoughness) {
        let Some(specular) = specular else { return };
        let color = Vec3::from_array(specular.specular_color_factor);
        surface.specular = (surface.specular * color).min(Vec3::ONE) * specular.specular_factor;
        if specular.specular_texture.is_some() || specular.specular_color_texture.is_some() {
            self.left_out("textures of KHR_materials_specular are left out");
        }
    }

    /// `factor` is the alpha of the base colour, which texture and vertices multiply.
    fn alpha(&self, factor: f32, translated: &mut Material) {
        match self.material.alpha_mode.as_deref().unwrap_or("OPAQUE") {
            "OPAQUE" => {}
            "MASK" => {
                let cutoff = self.material.alpha_cutoff;
                // Compared with what multiplies the factor.
                translated.alpha_cutoff = (cutoff > 0.0).then(|| (cutoff / factor.max(0.0)).min(f32::MAX));
            }
            "BLEND" => {
                translated.opacity = factor.clamp(0.0, 1.0);
                translated.alpha_blend = true;
            }
            other => self.left_out(&format!("alpha mode `{other}` is taken as OPAQUE")),
        }
    }
}
