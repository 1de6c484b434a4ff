//! Textures: an image, how it is wrapped and filtered, and where it lies on surfaces.

use super::file::document::{Document, Located};
use super::json::{Sampler, TextureInfo, TextureTransform};
use crate::api::{Filter, Wrap};
use crate::load::LoadError;
use crate::load::model::{SceneFile, TextureData, TextureSource};
use glam::{Affine2, Mat2, Vec2};
use std::collections::HashMap;

/// What the values of an image are.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Values {
    /// On the sRGB curve.
    Color,
    /// As they are: roughness, normals.
    Data,
}

/// All that distinguishes two textures, with the transform by its bits.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    image: u32,
    wrap: [Wrap; 2],
    filter: Filter,
    values: Values,
    transform: [u32; 6],
}

/// The textures of the scene so far, each once.
#[derive(Default)]
pub struct Textures {
    known: HashMap<Key, u32>,
    /// By image and by what it is made of: data that several textures share; `None` where it cannot be had.
    images: HashMap<u32, Option<TextureData>>,
    views: HashMap<u32, TextureData>,
}

impl Textures {
    /// Index in `SceneFile::textures`; `None`, and a note, where the texture cannot be had.
    pub fn index(
        &mut self,
        document: &Document,
        scene: &mut SceneFile,
        info: &TextureInfo,
        values: Values,
        place: impl Fn() -> String,
    ) -> Result<Option<u32>, LoadError> {
        let root = &document.root;
        let texture = document.get(&root.textures, "textures", info.index, &place)?;
        let webp = texture.extensions.as_ref().and_then(|e| e.webp.as_ref()).map(|w| w.source);
        let Some(number) = texture.source.or(webp) else {
            document.left_out(place(), "textures whose images are of no kind that is read are left out");
            return Ok(None);
        };
        let sampler = match texture.sampler {
            Some(sampler) => document.get(&root.samplers, "samplers", sampler, &place)?,
            None => &Sampler::default(),
        };
        let transform = transform_of(info.extensions.as_ref().and_then(|e| e.transform));
        let key = Key {
            image: number,
            wrap: [wrap(sampler.wrap_s), wrap(sampler.wrap_t)],
            filter: filter(sampler),
            values,
            transform: transform.to_cols_array().map(f32::to_bits),
        };
        if let Some(&known) = self.known.get(&key) {
            return Ok(Some(known));
        }
        let image = document.get(&root.images, "images", number, &place)?;
        let Some(data) = self.data(document, number)? else { return Ok(None) };
        let name = texture.name.as_deref().or(image.name.as_deref());
        scene.textures.push(TextureSource {
            name: name.map_or_else(|| format!("image {number}"), str::to_string),
            data,
            first_row_at_zero: true,
            wrap: key.wrap,
            filter: key.filter,
            srgb: values == Values::Color,
            transform,
        });
        let index = scene.textures.len() as u32 - 1;
        self.known.insert(key, index);
        Ok(Some(index))
    }

    fn data(&mut self, document: &Document, number: u32) -> Result<Option<TextureData>, LoadError> {
        if let Some(known) = self.images.get(&number) {
            return Ok(known.clone());
        }
        let image = &document.root.images[number as usize];
        let place = || format!("images[{number}]");
        let data = match (&image.uri, image.buffer_view) {
            (_, Some(view)) => match self.views.get(&view) {
                Some(known) => Some(known.clone()),
                None => {
                    let data = TextureData::Bytes(document.view(view, place)?.1.into());
                    self.views.insert(view, data.clone());
                    Some(data)
                }
            },
            (Some(uri), None) => match document.locate(uri) {
                Ok(Located::Bytes(bytes)) => Some(TextureData::Bytes(bytes.into())),
                Ok(Located::File(path)) => Some(TextureData::File(path)),
                Err(why) => {
                    document.left_out(place(), why);
                    None
                }
            },
            (None, None) => {
                document.left_out(place(), "images without data are left out");
                None
            }
        };
        self.images.insert(number, data.clone());
        Ok(data)
    }
}

fn wrap(number: u32) -> Wrap {
    match number {
        33071 => Wrap::ClampToEdge,
        33648 => Wrap::MirroredRepeat,
        _ => Wrap::Repeat,
    }
}

fn filter(sampler: &Sampler) -> Filter {
    const NEAREST: u32 = 9728;
    const LINEAR: u32 = 9729;
    match (sampler.mag_filter, sampler.min_filter) {
        (Some(NEAREST), _) => Filter::Nearest,
        (_, Some(NEAREST)) => Filter::Nearest,
        (_, Some(LINEAR)) => Filter::Linear,
        _ => Filter::LinearMipmapLinear,
    }
}

/// Offset · rotation · scale. The rotation is counter-clockwise as seen with t growing downwards.
fn transform_of(transform: Option<TextureTransform>) -> Affine2 {
    let Some(t) = transform else { return Affine2::IDENTITY };
    let rotation = Mat2::from_angle(-t.rotation);
    let matrix = rotation * Mat2::from_diagonal(Vec2::from_array(t.scale));
    Affine2::from_mat2_translation(matrix, Vec2::from_array(t.offset))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the extension: the lower left quarter of the image, turned clockwise by a right angle.
    #[test]
    fn transform_of_the_example() {
        let t = TextureTransform {
            offset: [0.0, 1.0],
            rotation: std::f32::consts::FRAC_PI_2,
            scale: [0.5, 0.5],
            tex_coord: None,
        };
        let at = |u: f32, v: f32| transform_of(Some(t)).transform_point2(Vec2::new(u, v));
        assert!((at(0.0, 0.0) - Vec2::new(0.0, 1.0)).length() < 1e-6);
        assert!((at(1.0, 0.0) - Vec2::new(0.0, 0.5)).length() < 1e-6);
        assert!((at(0.0, 1.0) - Vec2::new(0.5, 1.0)).length() < 1e-6);
    }
}
