//! glTF files in a few words.

use crate::api::{Context, PixelFormat, PixelKind};
use crate::load::{LoadError, LoadedScene, Parts, SceneFile, gltf};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

pub const FLOAT: u32 = 5126;

/// A file in the making: JSON, and the bytes of its buffer.
#[derive(Clone)]
pub struct File {
    pub json: Value,
    pub bytes: Vec<u8>,
}

impl File {
    /// The square from 0 to 1 with z = 0 that faces +z, with texture coordinates 0 to `tiles`: accessors 0 (positions),
    /// 1 (indices) and 2 (texture coordinates) of mesh 0 under node 0.
    pub fn quad(tiles: f32) -> Self {
        let mut file = Self {
            json: json!({
                "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1}]}],
                "accessors": [], "bufferViews": []
            }),
            bytes: Vec::new(),
        };
        file.floats("VEC3", &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
        file.add(5123, "SCALAR", 6, &[0_u16, 1, 2, 0, 2, 3].map(u16::to_le_bytes).concat());
        file.floats("VEC2", &[0., 0., tiles, 0., tiles, tiles, 0., tiles]);
        file
    }

    /// A view of the bytes, at a multiple of 4.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend(bytes);
        push(&mut self.json["bufferViews"], view)
    }

    pub fn add(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        push(&mut self.json["accessors"], accessor)
    }

    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        self.add(FLOAT, kind, values.len() / width, &values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>())
    }

    /// Puts a value at a JSON pointer whose parent is there.
    pub fn set(&mut self, pointer: &str, value: Value) -> &mut Self {
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let parent = self.json.pointer_mut(parent).unwrap_or_else(|| panic!("{pointer}: no parent"));
        match (parent, key.parse::<usize>()) {
            (Value::Array(list), Ok(i)) => list[i] = value,
            (parent, _) => parent[key] = value,
        }
        self
    }

    /// Gives the mesh a material.
    pub fn material(&mut self, material: Value) -> &mut Self {
        self.set("/materials", json!([material])).set("/meshes/0/primitives/0/material", json!(0))
    }

    /// Puts a lamp without light in the scene, so that there is none at the eye.
    pub fn dark(&mut self) -> &mut Self {
        let lights = json!({"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 0.0}]}});
        push(&mut self.json["nodes"], json!({"extensions": {"KHR_lights_punctual": {"light": 0}}}));
        self.set("/extensions", lights).set("/scenes/0/nodes", json!([0, 1]))
    }

    /// An image of RGBA texels as a PNG, and a texture of it with nearest filtering; the answer is the texture's index.
    pub fn texture(&mut self, width: u32, texels: &[[u8; 4]]) -> usize {
        let image =
            image::RgbaImage::from_raw(width, texels.len() as u32 / width, texels.concat()).expect("whole rows");
        let mut png = std::io::Cursor::new(Vec::new());
        image.write_to(&mut png, image::ImageFormat::Png).expect("memory takes all");
        let uri = format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png.into_inner()));
        let source = push(&mut self.json["images"], json!({"uri": uri}));
        let sampler = push(&mut self.json["samplers"], json!({"magFilter": 9728, "minFilter": 9728}));
        push(&mut self.json["textures"], json!({"source": source, "sampler": sampler}))
    }

    pub fn text(&self) -> String {
        let mut json = self.json.clone();
        let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&self.bytes));
        json["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        serde_json::to_string(&json).expect("JSON is text")
    }

    pub fn load(&self) -> Result<SceneFile, LoadError> {
        load("scene.gltf", self.text().as_bytes())
    }

    /// The scene, of which nothing is left out.
    pub fn whole(&self) -> SceneFile {
        let scene = self.load().expect("the file is right");
        assert_eq!(scene.warnings, [""; 0]);
        scene
    }

    /// What is said about the file, without its path.
    pub fn warnings(&self) -> Vec<String> {
        let scene = self.load().expect("the file is right");
        scene.warnings.iter().map(|w| after_name(w).to_string()).collect()
    }

    /// The error of a file that cannot be read, without its path.
    pub fn error(&self) -> String {
        after_name(&self.load().expect_err("the file is wrong").to_string()).to_string()
    }
}

fn after_name(text: &str) -> &str {
    text.split_once("scene.gltf: ").unwrap_or_else(|| panic!("{text} does not name its file")).1
}

/// Appends to a list that may not be there yet.
pub fn push(list: &mut Value, value: Value) -> usize {
    if list.is_null() {
        *list = json!([]);
    }
    let list = list.as_array_mut().expect("a list");
    list.push(value);
    list.len() - 1
}

/// Reads bytes as a file of that name.
pub fn load(name: &str, bytes: &[u8]) -> Result<SceneFile, LoadError> {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let folder: PathBuf = std::env::temp_dir().join(format!("openrt-gltf-{}-{number}", std::process::id()));
    fs::create_dir_all(&folder).expect("the temporary folder can be written");
    let path = folder.join(name);
    fs::write(&path, bytes).expect("the temporary folder can be written");
    // Not through `read`, which makes panics errors.
    let scene = gltf::load(&path);
    let _ = fs::remove_dir_all(&folder);
    scene
}

/// The picture of a scene, as linear RGBA from the lowest row.
pub struct Picture {
    pub width: usize,
    pub pixels: Vec<[f32; 4]>,
}

impl Picture {
    pub fn at(&self, x: f32, y: f32) -> [f32; 3] {
        let height = self.pixels.len() / self.width;
        let (x, y) = ((x * self.width as f32) as usize, (y * height as f32) as usize);
        let [r, g, b, _] = self.pixels[y * self.width + x];
        [r, g, b]
    }

    pub fn middle(&self) -> [f32; 3] {
        self.at(0.5, 0.5)
    }
}

/// What `scene` looks like at its start; `look` may change the context before.
pub fn picture(scene: SceneFile) -> Picture {
    picture_of(scene, |_| ())
}

/// The square from 0 to 1 from straight ahead, filling the picture.
pub fn facing(scene: SceneFile) -> Picture {
    picture_of(scene, |cx| {
        cx.ortho(-0.5, 0.5, -0.5, 0.5, 0.1, 10.0).expect("a valid projection");
        let (eye, at) = (glam::DVec3::new(0.5, 0.5, 2.0), glam::DVec3::new(0.5, 0.5, 0.0));
        cx.look_at(eye, at, glam::DVec3::Y).expect("a valid view");
    })
}

fn picture_of(scene: SceneFile, look: impl Fn(&mut Context)) -> Picture {
    const SIZE: u32 = 32;
    let said = scene.warnings.len();
    let mut cx = Context::new().expect("a context");
    cx.set_frame_size(SIZE, SIZE).expect("a small frame");
    let mut scene = LoadedScene::define(&mut cx, scene).expect("the scene can be defined");
    assert_eq!(scene.file().warnings[said..], [""; 0], "defining has nothing to say");
    scene.instantiate(&mut cx, 0.0, Parts::ALL).expect("the scene can be placed");
    look(&mut cx);
    cx.render().expect("a picture");
    let mut bytes = vec![0; (SIZE * SIZE * 16) as usize];
    let kind = PixelKind::Color(PixelFormat::Rgba32F);
    cx.read_pixels(0, 0, SIZE, SIZE, kind, 0, &mut bytes).expect("the picture can be read");
    let float = |b: &[u8; 4]| f32::from_ne_bytes(*b);
    let pixels =
        bytes.as_chunks::<16>().0.iter().map(|p| std::array::from_fn(|i| float(&p.as_chunks().0[i]))).collect();
    Picture { width: SIZE as usize, pixels }
}
