//! Shading seen from outside: small scenes through `Renderer`, compared with what can be computed by hand.

mod cameras;
mod estimators;
mod frames;
mod kit;
mod lights;
mod metals;
mod optics;
mod programs;
mod spawn;
mod surfaces;

use kit::*;
use openrt::render::Renderer;
use openrt::simd::Level;
use std::sync::atomic::AtomicBool;

/// Not a test of its own: writes the pictures of this file's scene for people to look at.
#[test]
#[ignore = "writes pictures to the folder in OPENRT_PICTURES"]
fn pictures_to_look_at() {
    let folder = std::env::var("OPENRT_PICTURES").expect("OPENRT_PICTURES names a folder");
    let mut w = zoo(400);
    w.frame.samples = 4;
    w.frame.max_depth = 6;
    for (class, samples) in [("whitted", 4), ("raycast", 1), ("ambient_occlusion", 4), ("path", 64)] {
        w.frame.renderer = w.shader(class, &[]);
        w.frame.samples = samples;
        let mut renderer = Renderer::new(Level::detect());
        let stats = renderer.render(&w.scene, &w.frame, None, &AtomicBool::new(false)).unwrap();
        println!("{class}: {stats:?}");
        let path = std::path::Path::new(&folder).join(format!("{class}.png"));
        openrt::frame::write_image(&path, renderer.framebuffer(), true, 92).unwrap();
    }
}
