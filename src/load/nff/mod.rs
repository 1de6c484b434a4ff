//! NFF (Haines, "A Proposal for Standard Graphics Environments", 1987) and AFF, its extension for moving scenes
//! (Lext, Assarsson, Möller, "BART: A Benchmark for Animated Ray Tracing", 2000).
//!
//! This file reads what stands around the geometry: view, lights, materials, includes, transforms and key frames;
//! shapes are in `geometry`, key frames in `keys`. Where the formats are silent:
//!
//! - a light without a colour is white with the share 1/√n of n lights, as NFF proposes;
//! - `fm` is taken as Whitted's model with the specular colour also as mirror colour, `f r g b Kd Ks …` as
//!   diffuse Kd·rgb, white highlight and mirror Ks, and no ambient light; T is the share of light refracted through, and an index
//!   of refraction of 0 means 1 (BART writes 0 for opaque things);
//! - textures lie with the first row of the file at v = 0 and repeat;
//! - `am` defaults to white, so that materials of scenes without it show their ambient colour;
//! - triangles without normals are flat;
//! - a surface of `f` with T > 0 and Ks = 0 still mirrors a little, since SPD counts a reflected ray for each transmitter;
//! - an unknown statement is left out to the end of its line, with a warning.

mod geometry;
mod keys;

use crate::load::LoadError;
use crate::load::build::{Baked, Builder, MaterialTable};
use crate::load::input::files::{self, Tree};
use crate::load::input::lexer::{Lexer, show};
use crate::load::input::lines;
use crate::load::model::{
    Animation, Background, Camera, KeyedTransform, Light, LightKind, Local, Material, Node, Projection, SceneFile,
    TextureData, TextureSource, View,
};
use crate::load::report::Report;
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Files nested in one another; BART needs 4.
const MAX_DEPTH: usize = 32;
/// Files read in all, repeats counted: two files that include each other's neighbours twice grow like 2^depth.
const MAX_FILES: u64 = 50_000;
/// Bytes parsed in all, repeats counted.
const MAX_BYTES: u64 = 1 << 31;
/// Triangles in all, tessellated ones included: vertices are numbered with 32 bits.
const MAX_TRIANGLES: usize = 400_000_000;

/// What a surface that lets light through reflects at least.
const LEAST_REFLECTION: f32 = 0.05;

/// An open `{`.
struct Block {
    line: u32,
    /// What to go back to at the `}`.
    node: u32,
    inside: Baked,
}

/// Light whose colour may depend on how many there are.
struct PendingLight {
    light: Light,
    colored: bool,
    /// Name of its key frames, and where it stands.
    animated: Option<String>,
}

struct Aff {
    pub scene: SceneFile,
    pub builder: Builder,
    pub materials: MaterialTable,
    /// What `f` or `fm` said last, without a texture.
    pub fill: Material,
    pub fill_index: u32,
    /// Node that geometry hangs on, and the static transform inside it.
    pub node: u32,
    pub inside: Baked,
    tree: Tree,
    detail: f64,
    /// Files being read, outermost first.
    open: Vec<PathBuf>,
    cache: HashMap<PathBuf, Arc<[u8]>>,
    bytes: u64,
    lights: Vec<PendingLight>,
    /// By name of the transform.
    pub keys: HashMap<String, KeyedTransform>,
    textures: HashMap<String, Option<u32>>,
    view: Option<Camera>,
    /// One for each file that something was told about.
    reports: Vec<Report>,
    /// Words that stood where a statement begins, and those of them that are none.
    statements: u64,
    unknown: u64,
}

/// Reads the scene whose main file is `path`; includes of a level above `detail` are skipped until the file says `d`.
pub fn load(path: &Path, detail: f64) -> Result<SceneFile, LoadError> {
    let is_nff = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("nff"));
    let format = if is_nff { "NFF" } else { "AFF" };
    let mut aff = Aff {
        scene: SceneFile::new(format, path.to_path_buf()),
        builder: Builder::default(),
        materials: MaterialTable::new(Material::default()),
        fill: Material::default(),
        fill_index: 0,
        node: 0,
        inside: Baked::new(DAffine3::IDENTITY),
        tree: Tree::of(path)?,
        detail,
        open: Vec::new(),
        cache: HashMap::new(),
        bytes: 0,
        lights: Vec::new(),
        keys: HashMap::new(),
        textures: HashMap::new(),
        view: None,
        reports: Vec::new(),
        statements: 0,
        unknown: 0,
    };
    aff.scene.background = Background::Color(Vec3::ZERO);
    aff.file(path)?;
    if aff.statements == aff.unknown {
        let what = if aff.statements == 0 { "the file is empty" } else { "no statement of the file is NFF or AFF" };
        return Err(LoadError::new(path, None, what));
    }
    Ok(aff.finish())
}

impl Aff {
    /// Reads one file; nesting is bounded by [`MAX_DEPTH`].
    fn file(&mut self, path: &Path) -> Result<(), LoadError> {
        let bytes = match self.cache.get(path) {
            Some(bytes) => bytes.clone(),
            None => {
                let bytes: Arc<[u8]> = files::read(path, files::MAX_FILE_BYTES)?.into();
                self.cache.insert(path.to_path_buf(), bytes.clone());
                bytes
            }
        };
        self.bytes += bytes.len() as u64;
        self.scene.counts.files += 1;
        if self.bytes > MAX_BYTES || self.scene.counts.files > MAX_FILES {
            return Err(LoadError::new(path, None, "the included files are too many or too large"));
        }
        let text = lines::text(path, &bytes)?;
        self.open.push(path.to_path_buf());
        let mut lexer = Lexer::new(path, text);
        other_dialect(&lexer)?;
        let mut blocks: Vec<Block> = Vec::new();
        while let Some(word) = lexer.word() {
            self.statement(word, &mut lexer, &mut blocks)?;
        }
        if let Some(block) = blocks.last() {
            return Err(LoadError::new(path, Some(block.line), "this `{` is not closed in its file"));
        }
        self.open.pop();
        Ok(())
    }

    fn statement(&mut self, word: &[u8], lexer: &mut Lexer, blocks: &mut Vec<Block>) -> Result<(), LoadError> {
        self.statements += 1;
        match word {
            b"v" => self.view = Some(view(lexer)?),
            b"b" => self.scene.background = Background::Color(Vec3::from_array(lexer.floats("a background colour")?)),
            b"am" => self.scene.ambient = Vec3::from_array(lexer.floats("an ambient colour")?),
            b"l" => self.light(lexer, None)?,
            b"la" => {
                let name = lexer.name("the name of an animated light")?.to_string();
                self.light(lexer, Some(name))?;
            }
            b"f" => {
                let fill = nff_fill(self, lexer)?;
                self.set_fill(fill);
            }
            b"fm" => {
                let fill = aff_fill(lexer)?;
                self.set_fill(fill);
            }
            b"a" => {
                let [start, end] = lexer.numbers("a time of the animation")?;
                let frames = lexer.count("the number of frames", 10_000_000)?;
                if end < start || frames == 0 {
                    return Err(lexer.error("an animation needs start ≤ end and at least one frame"));
                }
                self.scene.animation = Some(Animation { start, end, frames });
            }
            b"d" => self.detail = lexer.number("a level of detail")?,
            b"i" => self.include(lexer)?,
            b"xs" => {
                let line = lexer.line();
                let matrix = static_transform(lexer)?;
                lexer.expect("{")?;
                blocks.push(Block { line, node: self.node, inside: self.inside });
                self.inside = Baked::new(self.inside.matrix() * matrix);
                self.scene.counts.static_transforms += 1;
            }
            b"x" => {
                let line = lexer.line();
                let name = lexer.name("the name of a transform")?.to_string();
                lexer.expect("{")?;
                blocks.push(Block { line, node: self.node, inside: self.inside });
                self.open_node(name);
            }
            b"}" => match blocks.pop() {
                Some(block) => {
                    self.node = block.node;
                    self.inside = block.inside;
                }
                None => return Err(lexer.error("`}` without a `{` in this file")),
            },
            b"k" => self.key_frames(lexer)?,
            _ => {
                if !geometry::statement(self, word, lexer)? {
                    self.warn(lexer, &format!("unknown statement `{}` is left out", show(word)));
                    lexer.skip_line();
                    self.unknown += 1;
                }
            }
        }
        if self.builder.len() > MAX_TRIANGLES {
            return Err(lexer.error(format!("more than {MAX_TRIANGLES} triangles")));
        }
        Ok(())
    }

    /// Tells what is left out, once per file and kind.
    pub fn warn(&mut self, lexer: &Lexer, kind: &str) {
        let path = lexer.path();
        let known = self.reports.iter().position(|r| r.path() == path);
        let index = known.unwrap_or_else(|| {
            self.reports.push(Report::new(path));
            self.reports.len() - 1
        });
        self.reports[index].once(Some(lexer.line()), kind);
    }

    fn open_node(&mut self, name: String) {
        if !self.scene.named_transforms.contains(&name) {
            self.scene.named_transforms.push(name.clone());
        }
        let local = Local::Keyed { before: self.inside.matrix(), keys: None };
        self.scene.nodes.push(Node { name, parent: Some(self.node), local });
        self.node = self.scene.nodes.len() as u32 - 1;
        self.inside = Baked::new(DAffine3::IDENTITY);
    }

    fn include(&mut self, lexer: &mut Lexer) -> Result<(), LoadError> {
        let level = lexer.number("the level of detail of an include")?;
        let name = lexer.name("a file name")?;
        if level > self.detail {
            return Ok(());
        }
        if self.open.len() >= MAX_DEPTH {
            return Err(lexer.error(format!("files include each other more than {MAX_DEPTH} deep")));
        }
        let folder = folder_of(self.open.last().expect("a file is open while its statements are read"));
        let path = self.tree.find(name, &folder).map_err(|why| lexer.error(format!("included file `{name}` {why}")))?;
        if self.open.contains(&path) {
            return Err(lexer.error(format!("`{name}` includes itself")));
        }
        self.file(&path)
    }

    fn light(&mut self, lexer: &mut Lexer, animated: Option<String>) -> Result<(), LoadError> {
        let position = DVec3::from_array(lexer.numbers("a light position")?);
        let colored = lexer.number_follows();
        let color = if colored { Vec3::from_array(lexer.floats("a light colour")?) } else { Vec3::ONE };
        let n = self.lights.len() + 1;
        let light = Light {
            name: animated.clone().unwrap_or_else(|| format!("light {n}")),
            kind: LightKind::Point { attenuated: false },
            color,
            position: self.inside.matrix().transform_point3(position),
            direction: DVec3::NEG_Z,
            node: (self.node != 0).then_some(self.node),
            keys: None,
        };
        self.lights.push(PendingLight { light, colored, animated });
        Ok(())
    }

    fn set_fill(&mut self, fill: Material) {
        self.fill_index = self.materials.index(&fill);
        self.fill = fill;
    }

    /// Material of the last fill with texture `name`; without the texture, and with one warning, when it cannot be found.
    pub fn textured_fill(&mut self, name: &str, lexer: &Lexer) -> u32 {
        let texture = match self.textures.get(name) {
            Some(known) => *known,
            None => {
                let folder = folder_of(self.open.last().expect("a file is open while its statements are read"));
                let found = match self.tree.find_texture(name, &folder) {
                    Ok(path) => {
                        self.scene.textures.push(TextureSource {
                            name: name.to_string(),
                            data: TextureData::File(path),
                            first_row_at_zero: true,
                            wrap: Default::default(),
                            filter: Default::default(),
                            srgb: false,
                            transform: glam::Affine2::IDENTITY,
                        });
                        Some(self.scene.textures.len() as u32 - 1)
                    }
                    Err(why) => {
                        self.warn(lexer, &format!("texture `{name}` {why}"));
                        None
                    }
                };
                self.textures.insert(name.to_string(), found);
                found
            }
        };
        self.materials.index(&Material { texture, ..self.fill.clone() })
    }

    /// Joins names with key frames and makes the objects.
    fn finish(mut self) -> SceneFile {
        for node in &mut self.scene.nodes {
            if let Local::Keyed { keys, .. } = &mut node.local {
                *keys = self.keys.get(&node.name).cloned().map(Box::new);
                if keys.is_none() {
                    self.scene.notes.push(format!("transform `{}` has no key frames and rests", node.name));
                }
            }
        }
        let share = 1.0 / (self.lights.len().max(1) as f32).sqrt();
        for PendingLight { mut light, colored, animated } in self.lights {
            if !colored {
                light.color = Vec3::splat(share);
            }
            light.keys = animated.and_then(|name| self.keys.get(&name).cloned()).map(Box::new);
            self.scene.lights.push(light);
        }
        let camera_keys = self.keys.get("camera").cloned().map(Box::new);
        if let Some(mut camera) = self.view {
            camera.keys = camera_keys;
            self.scene.cameras.push(camera);
        } else if camera_keys.is_some() {
            let mut camera = default_camera();
            camera.keys = camera_keys;
            self.scene.cameras.push(camera);
        }
        let nodes = &self.scene.nodes;
        self.scene.objects = self.builder.finish(|n| nodes[n as usize].name.clone());
        let curved = self.scene.objects.iter().filter(|o| !o.copies.is_empty());
        self.scene.counts.tessellated_triangles = curved.map(|o| (o.count() * o.mesh.triangles.len()) as u64).sum();
        self.scene.materials = self.materials.materials;
        self.scene.warnings = self.reports.into_iter().flat_map(Report::into_warnings).collect();
        if self.scene.objects.is_empty() {
            let text = LoadError::new(&self.scene.path, None, "there is nothing to draw in the file");
            self.scene.warnings.push(text.to_string());
        }
        self.scene
    }
}

/// Refuses formats that have the same name.
fn other_dialect(lexer: &Lexer) -> Result<(), LoadError> {
    let mut lexer = lexer.clone();
    match lexer.word() {
        Some(word) if word.eq_ignore_ascii_case(b"nff") => Err(lexer
            .error("this is the Neutral File Format of Sense8's WorldToolKit, which is not read; NFF is that of SPD")),
        _ => Ok(()),
    }
}

fn folder_of(path: &Path) -> PathBuf {
    path.parent().map_or_else(|| PathBuf::from("."), Path::to_path_buf)
}

/// `sx sy sz  rx ry rz degrees  tx ty tz`: T · R · S.
fn static_transform(lexer: &mut Lexer) -> Result<DAffine3, LoadError> {
    let scale = DVec3::from_array(lexer.numbers("a scale")?);
    let axis = DVec3::from_array(lexer.numbers("a rotation axis")?);
    let degrees = lexer.number("a rotation angle")?;
    let rotation = match axis.try_normalize() {
        Some(axis) => DQuat::from_axis_angle(axis, degrees.to_radians()),
        None if degrees == 0.0 => DQuat::IDENTITY,
        None => return Err(lexer.error("the rotation axis has no length")),
    };
    let translation = DVec3::from_array(lexer.numbers("a translation")?);
    Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
}

fn default_camera() -> Camera {
    Camera {
        name: "view".into(),
        rest: View { from: DVec3::ZERO, forward: DVec3::NEG_Z, up: DVec3::Y },
        node: None,
        keys: None,
        projection: Projection::Perspective { fov_y: 45.0 },
        resolution: None,
    }
}

/// `from at up angle hither resolution`, in any order; the first four must be there.
fn view(lexer: &mut Lexer) -> Result<Camera, LoadError> {
    let line = lexer.line();
    let (mut from, mut at, mut up, mut angle) = (None, None, None, None);
    let mut camera = default_camera();
    loop {
        match lexer.peek() {
            Some(b"from") => {
                lexer.word();
                from = Some(DVec3::from_array(lexer.numbers("a viewpoint")?));
            }
            Some(b"at") => {
                lexer.word();
                at = Some(DVec3::from_array(lexer.numbers("a point to look at")?));
            }
            Some(b"up") => {
                lexer.word();
                up = Some(DVec3::from_array(lexer.numbers("an up direction")?));
            }
            Some(b"angle") => {
                lexer.word();
                let degrees = lexer.number("a field of view")?;
                if !(degrees > 0.0 && degrees < 180.0) {
                    return Err(
                        lexer.error(format!("the field of view must lie between 0 and 180 degrees, found {degrees}"))
                    );
                }
                angle = Some(degrees);
            }
            Some(b"hither") => {
                // The near plane of z-buffer renderers; rays start at the eye.
                lexer.word();
                lexer.number("a near distance")?;
            }
            Some(b"resolution") => {
                lexer.word();
                let width = lexer.count("the picture width", 65_536)?;
                let height = lexer.count("the picture height", 65_536)?;
                camera.resolution = (width > 0 && height > 0).then_some((width, height));
            }
            _ => break,
        }
    }
    let (Some(from), Some(at), Some(up), Some(angle)) = (from, at, up, angle) else {
        let missing =
            [("from", from.is_none()), ("at", at.is_none()), ("up", up.is_none()), ("angle", angle.is_none())];
        let missing = missing.iter().find(|m| m.1).map_or("", |m| m.0);
        let mut error = lexer.error(format!("the view has no `{missing}`"));
        error.line = Some(line);
        return Err(error);
    };
    if (at - from).cross(up).length_squared() == 0.0 {
        let mut error = lexer.error("the view has no direction: `from` equals `at`, or `up` is parallel to it");
        error.line = Some(line);
        return Err(error);
    }
    camera.rest = View { from, forward: at - from, up };
    camera.projection = Projection::Perspective { fov_y: angle };
    Ok(camera)
}

/// `f r g b Kd Ks shine T ior`. What is missing at the end is as for a matt surface; some programs name an image behind.
fn nff_fill(aff: &mut Aff, lexer: &mut Lexer) -> Result<Material, LoadError> {
    let color = Vec3::from_array(lexer.floats("a fill colour")?);
    let mut numbers = [0.8, 0.0, 0.0, 0.0, 1.0];
    for (i, number) in numbers.iter_mut().enumerate() {
        if !lexer.number_follows() {
            aff.warn(lexer, &format!("`f` has {} numbers instead of 8", i + 3));
            break;
        }
        *number = lexer.float("a number of a fill")?;
    }
    // A statement on the same line has a short name.
    if let Some(name) = lexer.peek_in_line().filter(|word| word.len() > 3) {
        aff.warn(lexer, &format!("the image `{}` of `f` is left out", show(name)));
        lexer.word();
    }
    let [kd, ks, shine, t, ior] = numbers;
    let mut fill = fill(Vec3::ZERO, color * kd, Vec3::splat(ks), shine, t, ior);
    if fill.transmission > 0.0 && ks == 0.0 {
        // All transmitters reflect (SPD's testing procedures, rule 8): as much as the index of refraction says, and enough to
        // be seen.
        let share = ((fill.ior - 1.0) / (fill.ior + 1.0)).powi(2);
        fill.reflection = Vec3::splat(share.max(LEAST_REFLECTION));
    }
    Ok(fill)
}

/// `fm ambient diffuse specular shine T ior`
fn aff_fill(lexer: &mut Lexer) -> Result<Material, LoadError> {
    let ambient = Vec3::from_array(lexer.floats("an ambient colour")?);
    let diffuse = Vec3::from_array(lexer.floats("a diffuse colour")?);
    let specular = Vec3::from_array(lexer.floats("a specular colour")?);
    let [shine, t, ior] = lexer.floats("shininess, transmittance and index of refraction")?;
    Ok(fill(ambient, diffuse, specular, shine, t, ior))
}

fn fill(ambient: Vec3, diffuse: Vec3, specular: Vec3, shine: f32, t: f32, ior: f32) -> Material {
    Material {
        name: String::new(),
        emission: Vec3::ZERO,
        ambient,
        diffuse,
        specular,
        shininess: shine.max(0.0),
        reflection: specular,
        transmission: t.clamp(0.0, 1.0),
        ior: if ior > 0.0 { ior } else { 1.0 },
        ..Material::default()
    }
}
