//! Texture objects.

use super::context::Context;
use super::error::{Error, Result};
use super::names::{FIRST_RESERVED, Names};
use super::objects::{no_names, positive};
use super::texture_image::{ImageDesc, decode_level, level_size};
use crate::backend::read_image;
use crate::scene::{Command, Filter, Name, Texture, TextureFormat, TextureLevel, Wrap};
use glam::Affine2;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// Largest width and height of a texture.
pub const MAX_TEXTURE_SIZE: u32 = 1 << 15;

/// A settable property of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TextureParameter {
    WrapS(Wrap),
    WrapT(Wrap),
    /// When a pixel covers many texels.
    MinFilter(Filter),
    /// When a texel covers many pixels: `Nearest` makes the whole texture use the nearest texel.
    MagFilter(Filter),
    Format(TextureFormat),
    /// From the coordinates of surfaces to those of the image, where 0 to 1 is the whole of it.
    Transform(Affine2),
}

/// What a texture is, for getters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TextureInfo {
    /// Size of level 0; 0 without an image.
    pub width: u32,
    pub height: u32,
    pub wrap_s: Wrap,
    pub wrap_t: Wrap,
    pub min_filter: Filter,
    pub mag_filter: Filter,
    pub format: TextureFormat,
    pub transform: Affine2,
}

struct TextureState {
    /// `filter` is derived from the two that follow.
    texture: Arc<Texture>,
    min_filter: Filter,
    mag_filter: Filter,
    changed: bool,
}

#[derive(Default)]
pub(super) struct Textures {
    names: Names,
    /// Those that were bound or loaded once.
    states: HashMap<Name, TextureState>,
    changed: Vec<Name>,
    bound: Name,
}

impl Textures {
    /// Whether the name is in use, with or without an image.
    pub fn contains(&self, name: Name) -> bool {
        self.names.contains(name)
    }

    pub fn bound(&self) -> Name {
        self.bound
    }

    /// Makes a texture without an image under a name in use.
    fn create(&mut self, name: Name) -> Result<()> {
        self.states.try_reserve(1)?;
        self.states.entry(name).or_insert_with(|| TextureState {
            texture: Arc::default(),
            min_filter: Filter::LinearMipmapLinear,
            mag_filter: Filter::Linear,
            changed: false,
        });
        Ok(())
    }

    fn bound_state(&mut self) -> Result<&mut TextureState> {
        self.states.get_mut(&self.bound).ok_or_else(|| Error::invalid_operation("no texture is bound"))
    }

    /// Replaces the bound texture's content.
    fn store(&mut self, texture: Texture) -> Result<()> {
        self.changed.try_reserve(1)?;
        let bound = self.bound;
        let state = self.bound_state()?;
        state.texture = Arc::new(texture);
        if !std::mem::replace(&mut state.changed, true) {
            self.changed.push(bound);
        }
        Ok(())
    }
}

impl Context {
    /// The first of `n` new consecutive texture names.
    ///
    /// # Errors
    /// `InvalidValue` for `n` < 1, `OutOfMemory` when there are not `n` consecutive names left.
    pub fn gen_textures(&mut self, n: i32) -> Result<Name> {
        self.outside_begin()?;
        let n = positive(n)?;
        self.textures.names.generate(n).ok_or_else(|| no_names(n))
    }

    /// Binds a texture, the one that `tex_image_2d` and `tex_parameter` change; a name that is not in use becomes a texture. 0 binds none.
    ///
    /// # Errors
    /// `InvalidValue` for one of the topmost 256 names.
    pub fn bind_texture(&mut self, texture: Name) -> Result<()> {
        self.outside_begin()?;
        if texture != 0 {
            self.textures.states.try_reserve(1)?;
            if !self.textures.names.claim(texture) {
                return Err(Error::invalid_value(format_args!(
                    "{texture} is not a name for a texture: these are 1 to {}",
                    FIRST_RESERVED - 1
                )));
            }
            self.textures.create(texture)?;
        }
        self.textures.bound = texture;
        Ok(())
    }

    /// Deletes the named textures; 0 and names that are not in use are ignored. Shaders that refer to one see white from the
    /// next frame on.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn delete_textures(&mut self, names: &[Name]) -> Result<()> {
        self.outside_begin()?;
        self.backend.reserve(names.len().min(self.textures.states.len()))?;
        for &name in names {
            if self.textures.states.remove(&name).is_some() {
                self.textures.changed.retain(|&n| n != name);
                self.backend.send(Command::DeleteTexture { name });
            }
            if name != 0 {
                self.textures.names.release(name, name.saturating_add(1));
            }
            if self.textures.bound == name {
                self.textures.bound = 0;
            }
        }
        Ok(())
    }

    /// Whether `texture` is a texture: bound or loaded once, and not deleted.
    ///
    /// # Errors
    /// `InvalidOperation` between begin and end.
    pub fn is_texture(&self, texture: Name) -> Result<bool> {
        self.outside_begin()?;
        Ok(self.textures.states.contains_key(&texture))
    }

    /// Gives the bound texture an image. Level 0 takes away all others; levels that are not given are averaged from the one
    /// above. Row 0 of `data` is at t = 0. Channels are kept with 8 bits; floats are clamped to 0…1. None leaves the image transparent black.
    ///
    /// # Errors
    /// `InvalidOperation` when no texture is bound, or a level above 0 comes before the one above it or has not the size that
    /// level 0 asks for; `InvalidValue` when a side is beyond [`MAX_TEXTURE_SIZE`] or `data` is too short; `OutOfMemory`.
    pub fn tex_image_2d(&mut self, level: u32, image: &ImageDesc, data: Option<&[u8]>) -> Result<()> {
        self.outside_begin()?;
        let old = self.textures.bound_state()?.texture.clone();
        if image.width > MAX_TEXTURE_SIZE || image.height > MAX_TEXTURE_SIZE {
            return Err(Error::invalid_value(format_args!(
                "{} x {} texels; a texture has at most {MAX_TEXTURE_SIZE} on a side",
                image.width, image.height
            )));
        }
        let decoded = decode_level(image, data)?;
        let mut levels = Vec::new();
        if level > 0 {
            if level as usize > old.levels.len()
                || level_size(&old.levels[0], level) != Some((image.width, image.height))
            {
                return Err(Error::invalid_operation(format_args!(
                    "level {level} of {} x {} texels does not fit the levels above it",
                    image.width, image.height
                )));
            }
            levels = copy_levels(&old.levels)?;
            levels.truncate(level as usize);
            levels.try_reserve(old.levels.len())?;
        }
        if image.width > 0 && image.height > 0 {
            levels.push(decoded);
            for below in old.levels.get(level as usize + 1..).unwrap_or_default().iter().filter(|_| level > 0) {
                levels.push(copy_level(below)?);
            }
        }
        self.textures.store(Texture { levels, ..settings(&old) })
    }

    /// Sets a property of the bound texture.
    ///
    /// # Errors
    /// `InvalidOperation` when no texture is bound; `InvalidValue` for a mip-mapped magnification filter.
    pub fn tex_parameter(&mut self, parameter: TextureParameter) -> Result<()> {
        self.outside_begin()?;
        let state = self.textures.bound_state()?;
        let old = state.texture.clone();
        let (mut min_filter, mut mag_filter) = (state.min_filter, state.mag_filter);
        let mut new = settings(&old);
        match parameter {
            TextureParameter::WrapS(wrap) => new.wrap_s = wrap,
            TextureParameter::WrapT(wrap) => new.wrap_t = wrap,
            TextureParameter::MinFilter(filter) => min_filter = filter,
            TextureParameter::MagFilter(Filter::LinearMipmapLinear) => {
                return Err(Error::invalid_value("a magnified texture has no use for smaller levels"));
            }
            TextureParameter::MagFilter(filter) => mag_filter = filter,
            TextureParameter::Format(format) => new.format = format,
            TextureParameter::Transform(transform) => new.transform = transform,
        }
        new.filter = if mag_filter == Filter::Nearest { Filter::Nearest } else { min_filter };
        new.levels = copy_levels(&old.levels)?;
        self.textures.store(new)?;
        let state = self.textures.bound_state()?;
        (state.min_filter, state.mag_filter) = (min_filter, mag_filter);
        Ok(())
    }

    /// What the bound texture is.
    ///
    /// # Errors
    /// `InvalidOperation` when no texture is bound.
    pub fn get_tex_parameters(&self) -> Result<TextureInfo> {
        self.outside_begin()?;
        let state = self.textures.states.get(&self.textures.bound);
        let state = state.ok_or_else(|| Error::invalid_operation("no texture is bound"))?;
        let texture = &state.texture;
        let (width, height) = texture.levels.first().map_or((0, 0), |l| (l.width, l.height));
        Ok(TextureInfo {
            width,
            height,
            wrap_s: texture.wrap_s,
            wrap_t: texture.wrap_t,
            min_filter: state.min_filter,
            mag_filter: state.mag_filter,
            format: texture.format,
            transform: texture.transform,
        })
    }

    /// Reads an image file (PNG, JPEG, EXR, HDR or PNM, told by its content) into a new texture and binds it.
    ///
    /// # Errors
    /// `Io` with the cause, `OutOfMemory`; `InvalidOperation` where image files were left out of the build.
    pub fn load_texture(&mut self, path: impl AsRef<Path>) -> Result<Name> {
        self.outside_begin()?;
        let path = path.as_ref();
        let image = read_image(path, MAX_TEXTURE_SIZE)?;
        let base = TextureLevel { width: image.width, height: image.height, texels: image.texels };
        let levels = vec![base];
        self.textures.states.try_reserve(1)?;
        self.textures.changed.try_reserve(1)?;
        let name = self.textures.names.generate(1).ok_or_else(|| no_names(1))?;
        self.textures.create(name)?;
        self.textures.bound = name;
        self.textures.store(Texture { levels, ..Texture::default() })?;
        Ok(name)
    }

    /// Sends every texture that changed.
    pub(super) fn send_textures(&mut self) -> Result<()> {
        self.backend.reserve(self.textures.changed.len())?;
        for name in self.textures.changed.drain(..) {
            let state = self.textures.states.get_mut(&name).expect("deleted textures leave the list");
            state.changed = false;
            self.backend.send(Command::DefineTexture { name, texture: state.texture.clone() });
        }
        Ok(())
    }
}

/// A texture that differs from `texture` in having no levels.
fn settings(texture: &Texture) -> Texture {
    Texture {
        levels: Vec::new(),
        wrap_s: texture.wrap_s,
        wrap_t: texture.wrap_t,
        filter: texture.filter,
        format: texture.format,
        transform: texture.transform,
    }
}

fn copy_level(level: &TextureLevel) -> Result<TextureLevel> {
    let mut texels = Vec::new();
    texels.try_reserve_exact(level.texels.len())?;
    texels.extend_from_slice(&level.texels);
    Ok(TextureLevel { texels, ..*level })
}

fn copy_levels(levels: &[TextureLevel]) -> Result<Vec<TextureLevel>> {
    levels.iter().map(copy_level).collect()
}
