//! Scene files as pictures: what small files of each kind look like in the middle, through `LoadedScene`.

use openrt::Context;
use openrt::api::glam::{DVec3, Vec3};
use openrt::api::{Config, Mode, Motion, PixelFormat, PixelKind, Primitive, State};
use openrt::load::{LoadedScene, Parts, SceneFile, read};
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder that goes with its guard.
struct Folder(PathBuf);

impl Folder {
    fn with(files: &[(&str, &[u8])]) -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let name = format!("openrt-pictures-{}-{}", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
        let folder = Self(std::env::temp_dir().join(name));
        fs::create_dir_all(&folder.0).expect("a scratch folder");
        for (name, bytes) in files {
            fs::write(folder.0.join(name), bytes).expect("a file in it");
        }
        folder
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const SIZE: [u32; 2] = [60, 40];

/// The pixel in the middle, 0 to 1.
fn middle(cx: &mut Context) -> Vec3 {
    cx.render().expect("a frame");
    let mut pixel = [0; 4];
    cx.read_pixels(SIZE[0] / 2, SIZE[1] / 2, 1, 1, PixelKind::Color(PixelFormat::Rgba8), 0, &mut pixel)
        .expect("a pixel");
    Vec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into()) / 255.0
}

fn context() -> Context {
    let mut cx = Context::with_config(Config::with_threads(1)).expect("a context");
    cx.set_frame_size(SIZE[0], SIZE[1]).expect("a frame");
    cx
}

fn shown(file: SceneFile) -> Vec3 {
    let mut cx = context();
    let time = file.animation.map_or(0.0, |a| a.start);
    let mut scene = LoadedScene::define(&mut cx, file).expect("a scene");
    assert_eq!(scene.file().warnings, [""; 0], "a texture that cannot be read");
    scene.instantiate(&mut cx, time, Parts::ALL).expect("its parts");
    middle(&mut cx)
}

/// What the last of the files looks like.
fn look(files: &[(&str, &[u8])]) -> Vec3 {
    let folder = Folder::with(files);
    let file = read(folder.0.join(files[files.len() - 1].0)).expect("a scene");
    shown(file)
}

fn is_red(c: Vec3) -> bool {
    c.x > 0.2 && c.y < 0.02 && c.z < 0.02
}

/// Faces the camera that shows everything.
const TRIANGLE: &str = "v -9 -9 0\nv 9 -9 0\nv 0 9 0\n";
const RED_TEXEL: &[u8] = b"P3 1 1 255 255 0 0";

#[test]
fn materials_of_obj() {
    let obj = format!("\u{feff}mtllib a.mtl\n{TRIANGLE}vt 0 0\nusemtl m\nf 1/1 2/1 3/1\n");
    let with =
        |library: &str| look(&[("a.mtl", library.as_bytes()), ("red.ppm", RED_TEXEL), ("a.obj", obj.as_bytes())]);
    let grey = with("newmtl m\nKd 0.5\n");
    assert!(grey.x > 0.2 && grey.x == grey.y && grey.y == grey.z, "a short colour is grey: {grey}");
    assert!(is_red(with("newmtl m\nKd 1 0 0\n")), "a library behind a byte order mark");
    let dull = with("newmtl m\nKd .2 .2 .2\nKs .8 .8 .8\nNs 0\n");
    assert!(dull.x > 0.02 && dull.x < 0.3, "an exponent of 0 is no highlight: {dull}");
    assert!(is_red(with("newmtl m\nmap_Kd -s 2 2 1 red.ppm\n")), "options come before the file");
}

#[test]
fn colours_of_vertices() {
    let red = TRIANGLE.replace('\n', " 1 0 0\n");
    assert!(is_red(look(&[("a.obj", format!("{red}f 1 2 3\n").as_bytes())])));
    let some = look(&[("a.obj", format!("{}f 1 2 3\n", TRIANGLE.replace(" 9 0\n", " 9 0 1 0 0\n")).as_bytes())]);
    assert!(some.x > some.y && some.y > 0.1, "one corner is red, the others are white: {some}");
}

#[test]
fn images_of_ply() {
    let text = "ply\nformat ascii 1.0\ncomment TextureFile red.ppm\nelement vertex 3\nproperty float x\nproperty float y\n\
                property float z\nproperty float s\nproperty float t\nelement face 1\n\
                property list uchar int vertex_indices\nend_header\n-9 -9 0 0 0\n9 -9 0 0 0\n0 9 0 0 0\n3 0 1 2\n";
    assert!(is_red(look(&[("red.ppm", RED_TEXEL), ("a.ply", text.as_bytes())])));
    let faces =
        text.replace("property list", "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty list");
    let faces = faces.replace("comment TextureFile red.ppm\n", "").replace("3 0 1 2", "255 0 0 3 0 1 2");
    assert!(is_red(look(&[("a.ply", faces.as_bytes())])), "a red face");
}

#[test]
fn curved_surfaces_of_nff() {
    let view = "b 0 0 1\nv\nfrom 0 0 9\nat 0 0 0\nup 0 1 0\nangle 40\nl 0 5 9\n";
    let with = |rest: &str| look(&[("a.nff", format!("{view}f 1 0 0 1 0 0 0 0\n{rest}\n").as_bytes())]);
    assert!(is_red(with("s 0 0 0 1")), "a sphere");
    assert!(is_red(with("s 3 0 0 1\ns 0 0 0 .5")), "the second of two");
    assert!(
        is_red(with("c 0 -1 0 1  0 1 0 1")) && is_red(with("c 0 -1 0 0  0 1 0 2")),
        "a cylinder and a cone on its tip"
    );
    assert!(is_red(with("s 0 0 9 -20")), "a sphere around everything, seen from inside");
    assert_eq!(with("s 3 0 0 1"), Vec3::Z, "past a sphere");
}

/// A transmitter without Ks sends a refracted and a mirror ray; an opaque surface none.
#[test]
fn transmitters_of_nff_send_a_mirror_ray() {
    let rays = |fill: &str| {
        let text =
            format!("v\nfrom 0 0 9\nat 0 0 0\nup 0 1 0\nangle 40\nl 0 5 9\nf {fill}\np 3 -99 -99 0 99 -99 0 0 99 0\n");
        let folder = Folder::with(&[("a.nff", text.as_bytes())]);
        let mut cx = context();
        let mut scene = LoadedScene::define(&mut cx, read(folder.0.join("a.nff")).expect("a scene")).expect("defined");
        scene.instantiate(&mut cx, 0.0, Parts::ALL).expect("placed");
        cx.render().expect("a frame").secondary_rays
    };
    let pixels = u64::from(SIZE[0] * SIZE[1]);
    assert_eq!(rays("1 1 1 .2 0 0 .8 1.1"), 2 * pixels);
    assert_eq!(rays("1 1 1 1 0 0 0 0"), 0);
}

/// Defining and placing leave what is current as it is, and the current matrix places the scene.
#[test]
fn the_state_of_the_context_is_kept() {
    let folder = Folder::with(&[("a.obj", format!("{TRIANGLE}f 1 2 3\n").as_bytes())]);
    let file = read(folder.0.join("a.obj")).expect("a scene");
    let mut cx = context();
    cx.gen_new_shader_class("diffuse").expect("a class");
    let shader = cx.gen_new_shader().expect("a shader");
    let texture = cx.gen_textures(1).expect("a name");
    cx.bind_texture(texture).expect("a texture");
    cx.color(Vec3::new(0.25, 0.5, 0.75).extend(1.0)).expect("a colour");
    cx.normal(Vec3::X).expect("a normal");
    cx.push_matrix().expect("room");
    cx.translate(DVec3::new(100.0, 0.0, 0.0)).expect("a matrix");
    let states = [
        State::CurrentMatrix,
        State::MatrixDepth,
        State::CurrentColor,
        State::CurrentNormal,
        State::CurrentTexCoord,
        State::BoundShaderClass,
        State::BoundShader,
        State::BoundTexture,
    ];
    let all = |cx: &Context| states.map(|s| cx.get(s).expect("outside begin").as_slice().to_vec());
    let before = all(&cx);
    let mut scene = LoadedScene::define(&mut cx, file.clone()).expect("defined");
    assert_eq!(all(&cx), before);
    scene.instantiate(&mut cx, 0.0, Parts { instances: true, ..Parts::NONE }).expect("placed");
    assert_eq!(all(&cx), before);
    assert_eq!(cx.get(State::BoundShader).expect("a state").as_slice()[0], f64::from(shader));
    // The triangle stands at x = 100.
    cx.look_at(DVec3::new(100.0, 0.0, 30.0), DVec3::new(100.0, 0.0, 0.0), DVec3::Y).expect("a view");
    assert!(middle(&mut cx).x > 0.1);
    // Inside a definition and between begin and end both are refused, and nothing is defined.
    let object = cx.gen_objects(1).expect("a name");
    cx.new_object(object, Mode::Compile, Motion::Affine).expect("a definition");
    assert!(LoadedScene::define(&mut cx, file.clone()).is_err());
    assert!(scene.instantiate(&mut cx, 0.0, Parts::ALL).is_err());
    cx.begin(Primitive::Triangles).expect("begin");
    assert!(LoadedScene::define(&mut cx, file).is_err());
    cx.end().expect("end");
    cx.end_object().expect("the end");
    assert_eq!(cx.gen_objects(1).expect("a name"), object + 1, "no name was taken");
    let name = scene.objects().next().expect("an object");
    scene.delete(&mut cx).expect("deleted");
    assert!(!cx.is_object(name).expect("a state"));
}
