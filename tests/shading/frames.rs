//! Frames: threads, cancelling, viewports, targets.

use crate::kit::*;
use glam::{Vec3, Vec4};
use openrt::render::Renderer;
use openrt::scene::*;
use openrt::simd::Level;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let mut w = zoo(50);
    w.frame.samples = 2;
    let path = w.shader("path", &[]);
    let occlusion = w.shader("ambient_occlusion", &[]);
    for renderer in [0, path, occlusion] {
        w.frame.renderer = renderer;
        let reference = pool(1).install(|| w.render());
        assert!(reference.iter().any(|c| *c != reference[0]));
        for threads in [2, 3, 7] {
            assert!(pool(threads).install(|| w.render()) == reference, "{threads} threads");
        }
    }
}

#[test]
fn a_cancelled_frame_keeps_the_old_picture_and_says_so() {
    let mut w = zoo(40);
    let mut renderer = Renderer::new(Level::detect());
    let stats = renderer.render(&w.scene, &w.frame, None, &AtomicBool::new(false)).unwrap();
    assert!(!stats.cancelled && stats.primary_rays == 1600);
    assert!(stats.shadow_rays > 0 && stats.secondary_rays > 0 && stats.instances == 4);
    let before = colors(&renderer);
    w.frame.lights.clear();
    let stats = renderer.render(&w.scene, &w.frame, None, &AtomicBool::new(true)).unwrap();
    assert!(stats.cancelled && stats.primary_rays == 0);
    assert_eq!(colors(&renderer), before);
}

#[test]
fn a_viewport_renders_its_pixels_only() {
    let mut w = World::new(40);
    let red = w.shader("constant", &[("color", rgb(1.0, 0.0, 0.0))]);
    w.add(wall(-1.0, red));
    w.frame.viewport = Viewport { x: 3, y: 20, width: 17, height: 9 };
    let picture = w.render();
    for (i, color) in picture.iter().enumerate() {
        let (x, y) = (i % 40, i / 40);
        let inside = (3..20).contains(&x) && (20..29).contains(&y);
        assert_eq!(*color, if inside { Vec4::new(1.0, 0.0, 0.0, 1.0) } else { Vec4::ZERO }, "{x} {y}");
    }
    // A viewport beyond the framebuffer is cut.
    w.frame.viewport = Viewport { x: 30, y: 30, width: 20, height: 20 };
    assert_eq!(w.render().iter().filter(|c| c.x > 0.0).count(), 100);
    w.frame.viewport = Viewport { x: 0, y: 0, width: 0, height: 0 };
    assert!(w.render().iter().all(|c| *c == Vec4::ZERO));
}

#[test]
fn pixels_know_what_they_show_and_picking_agrees() {
    let w = zoo(64);
    let renderer = w.renderer();
    let mut kinds = std::collections::BTreeSet::new();
    for y in 0..64 {
        for x in 0..64 {
            let pixel = renderer.framebuffer().pixel(x, y).unwrap();
            match renderer.pick(&w.scene, x as f32 + 0.5, y as f32 + 0.5).expect("memory") {
                Some(hit) => {
                    assert_eq!((pixel.object, pixel.instance, pixel.depth), (hit.object, hit.instance, hit.t));
                    let n = Vec3::from_array(pixel.normal);
                    assert!((n.length() - 1.0).abs() < 1e-5);
                    kinds.insert(hit.instance);
                }
                None => {
                    assert_eq!((pixel.object, pixel.instance), (0, openrt::frame::NO_INSTANCE));
                    assert!(pixel.depth == f32::INFINITY && pixel.normal == [0.0; 3]);
                }
            }
        }
    }
    assert_eq!(kinds.len(), 4);
    assert!(
        renderer.pick(&w.scene, -0.1, 3.0).expect("memory").is_none()
            && renderer.pick(&w.scene, f32::NAN, 3.0).expect("memory").is_none()
    );
    assert!(renderer.pick(&w.scene, 3.0, 64.0).expect("memory").is_none());
}

/// An image in memory.
struct Image(std::sync::Mutex<Vec<u8>>);

impl openrt::frame::PixelSink for Image {
    fn write(&self, offset: usize, bytes: &[u8]) {
        self.0.lock().unwrap()[offset..offset + bytes.len()].copy_from_slice(bytes);
    }
}

#[test]
fn a_target_gets_the_pixels_of_the_framebuffer() {
    use openrt::frame::{PixelFormat, Target, TargetLayout};
    let mut w = zoo(37);
    w.frame.srgb = true;
    for origin_top_left in [false, true] {
        let stride = 37 * 4 + 12;
        let image = Arc::new(Image(std::sync::Mutex::new(vec![7; stride * 37])));
        let layout = TargetLayout { width: 37, height: 37, format: PixelFormat::Bgra8, stride, origin_top_left };
        let target = Target { layout, sink: image.clone() };
        let mut renderer = Renderer::new(Level::detect());
        pool(3).install(|| renderer.render(&w.scene, &w.frame, Some(&target), &AtomicBool::new(false))).unwrap();
        let bytes = image.0.lock().unwrap();
        for y in 0..37u32 {
            let row = if origin_top_left { 36 - y } else { y } as usize;
            for x in 0..37u32 {
                let [r, g, b, a] = renderer.framebuffer().pixel(x, y).unwrap().color;
                let code = openrt::frame::srgb::encode_srgb8;
                let expected = [code(b), code(g), code(r), (a * 255.0 + 0.5) as u8];
                assert_eq!(bytes[row * stride + x as usize * 4..][..4], expected);
            }
            assert!(bytes[row * stride + 37 * 4..(row + 1) * stride].iter().all(|&b| b == 7));
        }
    }
}
