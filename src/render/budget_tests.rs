//! Frames with a time budget, by a clock that counts instead of running: it is asked once before each tile that is refined.

use super::Renderer;
use super::tests::{World, vec3, world};
use crate::frame::{FrameStats, PixelFormat, PixelSink, TILE_SIZE, Target, TargetLayout};
use crate::scene::{FrameDesc, LightUse, Viewport};
use crate::simd::Level;
use crate::threads::Pool;
use glam::Affine3A;
use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

const VIEWPORT: Viewport = Viewport { x: 9, y: 4, width: 61, height: 47 };
const SIZE: [u32; 2] = [75, 60];
const PIXELS: u64 = VIEWPORT.width as u64 * VIEWPORT.height as u64;

fn lit_world(renderer: &str) -> World {
    let mut w = world(false);
    let light = w.shader("point", &[("position", vec3(1.0, 4.0, -2.0))]);
    w.frame.lights = vec![LightUse::new(light, Affine3A::IDENTITY)];
    w.frame.renderer = w.shader(renderer, &[]);
    (w.frame.size, w.frame.viewport) = (SIZE, VIEWPORT);
    w
}

/// Renders a frame whose time is up when the clock has been asked `tiles` times.
fn until(renderer: &mut Renderer, w: &World, frame: &FrameDesc, threads: usize, tiles: usize) -> FrameStats {
    let asked = AtomicUsize::new(0);
    let time_is_up = || asked.fetch_add(1, Ordering::Relaxed) >= tiles;
    let pool = Pool::new(Some(threads)).unwrap();
    pool.install(|| renderer.render_until(&w.scene, frame, None, &AtomicBool::new(false), &time_is_up)).unwrap()
}

/// All numbers of the pixels, as bits, row by row.
fn picture(renderer: &Renderer) -> Vec<[u32; 10]> {
    let fb = renderer.framebuffer();
    let words = |p: crate::frame::Pixel| {
        let ([r, g, b, a], [x, y, z]) = (p.color.map(f32::to_bits), p.normal.map(f32::to_bits));
        [r, g, b, a, p.depth.to_bits(), x, y, z, p.object, p.instance]
    };
    (0..fb.height()).flat_map(|y| fb.row(y).map(words).collect::<Vec<_>>()).collect()
}

/// The picture of a frame without a budget, by another renderer.
fn without_budget(w: &World, frame: &FrameDesc) -> Vec<[u32; 10]> {
    let mut renderer = Renderer::new(Level::detect());
    let frame = FrameDesc { time_budget: None, ..frame.clone() };
    until(&mut renderer, w, &frame, 2, 0);
    picture(&renderer)
}

fn with_budget(w: &World) -> FrameDesc {
    FrameDesc { time_budget: Some(Duration::from_secs(1)), ..w.frame.clone() }
}

/// Lower left corners of the tiles of the viewport, the nearest to its middle first.
fn tiles_from_the_middle() -> Vec<[u32; 2]> {
    let end_of_viewport = [VIEWPORT.x + VIEWPORT.width, VIEWPORT.y + VIEWPORT.height];
    let inside = |at: u32, from: u32, to: u32| at < to && at + TILE_SIZE > from;
    let columns = (0..SIZE[0]).step_by(16).filter(|&x| inside(x, VIEWPORT.x, end_of_viewport[0]));
    let mut tiles: Vec<[u32; 2]> = columns
        .flat_map(|x| (0..SIZE[1]).step_by(16).map(move |y| [x, y]))
        .filter(|t| inside(t[1], VIEWPORT.y, end_of_viewport[1]))
        .collect();
    let distance = |t: &[u32; 2]| {
        (0..2)
            .map(|k| {
                let end = (t[k] + 16).min(SIZE[k]);
                let from = [VIEWPORT.x, VIEWPORT.y][k];
                (f64::from(t[k] + end) / 2.0 - f64::from(from + end_of_viewport[k]) / 2.0).powi(2)
            })
            .sum::<f64>()
    };
    tiles.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then((a[1], a[0]).cmp(&(b[1], b[0]))));
    tiles
}

#[test]
fn a_frame_is_refined_from_the_middle_and_the_rest_shows_its_primary_rays() {
    for renderer in ["whitted", "ambient_occlusion", "path"] {
        for samples in [1, 4] {
            let mut w = lit_world(renderer);
            w.frame.samples = samples;
            let full = without_budget(&w, &w.frame);
            let raycast = w.shader("raycast", &[]);
            let primary = without_budget(&w, &FrameDesc { renderer: raycast, samples: 1, ..w.frame.clone() });
            assert!(full != primary);
            let order = tiles_from_the_middle();
            for tiles in [0, 1, 7, order.len(), usize::MAX] {
                let refined: HashSet<[u32; 2]> = order.iter().copied().take(tiles).collect();
                let mut renderer = Renderer::new(Level::detect());
                let stats = until(&mut renderer, &w, &with_budget(&w), 1, tiles);
                let mut count = 0;
                for (i, pixel) in picture(&renderer).into_iter().enumerate() {
                    let [x, y] = [i as u32 % SIZE[0], i as u32 / SIZE[0]];
                    let is_refined = refined.contains(&[x / 16 * 16, y / 16 * 16]);
                    let visible = (VIEWPORT.x..VIEWPORT.x + VIEWPORT.width).contains(&x)
                        && (VIEWPORT.y..VIEWPORT.y + VIEWPORT.height).contains(&y);
                    count += u64::from(is_refined && visible);
                    let expected = if is_refined { full[i] } else { primary[i] };
                    assert_eq!(pixel, expected, "{tiles} tiles, {samples} samples, pixel {x} {y}");
                }
                assert_eq!(stats.refined, count as f64 / PIXELS as f64);
                assert_eq!(stats.primary_rays, PIXELS + count * u64::from(samples));
                assert_eq!(stats.shadow_rays + stats.secondary_rays == 0, tiles == 0);
                assert!(!stats.cancelled);
            }
        }
    }
}

#[test]
fn threads_agree_on_frames_that_end_at_once_or_never() {
    for (budget, tiles) in [(1, 0), (1, usize::MAX)] {
        let w = lit_world("whitted");
        let frame = FrameDesc { time_budget: Some(Duration::from_secs(budget)), ..w.frame.clone() };
        let pictures = [1, 2, 5].map(|threads| {
            let mut renderer = Renderer::new(Level::detect());
            until(&mut renderer, &w, &frame, threads, tiles);
            picture(&renderer)
        });
        assert!(pictures[0] == pictures[1] && pictures[1] == pictures[2]);
    }
}

struct Counter(AtomicUsize);

impl PixelSink for Counter {
    fn write(&self, _: usize, bytes: &[u8]) {
        self.0.fetch_add(bytes.len(), Ordering::Relaxed);
    }
}

#[test]
fn primary_rays_of_all_tiles_are_delivered_first() {
    let w = lit_world("whitted");
    let [width, height] = SIZE;
    let delivered = Arc::new(Counter(AtomicUsize::new(0)));
    let layout =
        TargetLayout { width, height, format: PixelFormat::Rgba8, stride: 4 * width as usize, origin_top_left: false };
    let target = Target { layout, sink: delivered.clone() };
    let asked = AtomicUsize::new(0);
    let time_is_up = || {
        assert!(delivered.0.load(Ordering::Relaxed) as u64 >= 4 * PIXELS, "before any tile is refined");
        asked.fetch_add(1, Ordering::Relaxed) >= 3
    };
    let mut renderer = Renderer::new(Level::detect());
    let pool = Pool::new(Some(2)).unwrap();
    let frame = with_budget(&w);
    let cancel = AtomicBool::new(false);
    pool.install(|| renderer.render_until(&w.scene, &frame, Some(&target), &cancel, &time_is_up)).unwrap();
    assert!(asked.load(Ordering::Relaxed) > 3);
}

#[test]
fn frames_that_accumulate_go_on_where_the_one_before_stopped() {
    for subsampling in [1, 3] {
        let mut w = lit_world("whitted");
        (w.frame.accumulate, w.frame.subsampling) = (true, subsampling);
        let full = without_budget(&w, &w.frame);
        let mut renderer = Renderer::new(Level::detect());
        let mut shares = Vec::new();
        let mut rays = Vec::new();
        while shares.last() != Some(&1.0) {
            let stats = until(&mut renderer, &w, &with_budget(&w), 1, 2);
            shares.push(stats.refined);
            rays.push(stats.primary_rays);
            assert!(shares.len() < 100);
        }
        assert!(shares.is_sorted_by(|a, b| a < b), "{shares:?}");
        let samples = if subsampling == 1 { PIXELS } else { 21 * 17 };
        assert!(rays[0] > samples && rays[1..].iter().all(|&n| n <= 512), "primary rays are sent once: {rays:?}");
        assert_eq!(rays.iter().sum::<u64>(), 2 * samples);
        assert!(picture(&renderer) == full);
        // Then every tile gets its second round before any gets its third.
        (0..shares.len()).for_each(|_| _ = until(&mut renderer, &w, &with_budget(&w), 1, 2));
        let mut twice = Renderer::new(Level::detect());
        (0..2).for_each(|_| _ = until(&mut twice, &w, &w.frame, 1, 0));
        assert!(picture(&renderer) == picture(&twice));
    }
}

#[test]
fn raycast_needs_no_time_beyond_its_primary_rays() {
    let w = lit_world("raycast");
    let mut renderer = Renderer::new(Level::detect());
    let stats = until(&mut renderer, &w, &with_budget(&w), 2, 0);
    assert_eq!((stats.refined, stats.primary_rays), (1.0, PIXELS));
    assert!(picture(&renderer) == without_budget(&w, &w.frame));
}

#[test]
fn a_sub_sampled_frame_that_is_cancelled_leaves_the_picture_as_it_was() {
    let mut w = lit_world("whitted");
    let mut renderer = Renderer::new(Level::detect());
    until(&mut renderer, &w, &w.frame, 2, 0);
    let before = picture(&renderer);
    w.frame.subsampling = 5;
    for time_budget in [None, Some(Duration::from_secs(1))] {
        let frame = FrameDesc { time_budget, ..w.frame.clone() };
        let stats = renderer.render_until(&w.scene, &frame, None, &AtomicBool::new(true), &|| false).unwrap();
        assert!(stats.cancelled && stats.refined == 0.0 && picture(&renderer) == before);
    }
    // A frame with a budget that is cancelled while it refines keeps its primary rays.
    w.frame.subsampling = 1;
    let frame = with_budget(&w);
    let cancel = AtomicBool::new(false);
    let pool = Pool::new(Some(1)).unwrap();
    let cancel_then_go_on = || {
        cancel.store(true, Ordering::Relaxed);
        false
    };
    let stats = pool.install(|| renderer.render_until(&w.scene, &frame, None, &cancel, &cancel_then_go_on)).unwrap();
    assert!(stats.cancelled && stats.refined == 0.0);
    let raycast = w.shader("raycast", &[]);
    assert!(picture(&renderer) == without_budget(&w, &FrameDesc { renderer: raycast, ..w.frame.clone() }));
}
