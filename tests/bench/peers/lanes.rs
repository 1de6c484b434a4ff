//! The ways in which the peer traces a chunk of rays, and the table of all lanes of a race.

use crate::embree::{Built, Context, Embree, Handle, NO_GEOMETRY};
use crate::measure::{CHUNK, Column, Lane, Worker};
use crate::ours::{AnyWorker, ClosestWorker, MODES};
use crate::rays::Kind;
use openrt::trace::{Ray, Tracer};

/// Rows of a packet for an occlusion query, and with the hit's.
const RAY_ROWS: usize = 12;
const HIT_ROWS: usize = 20;
const ROW_TFAR: usize = 8;
const ROW_GEOMETRY: usize = 18;

/// Rays per call of a stream.
const STREAM: usize = 256;

/// How rays go into one call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Single,
    Packet8,
    Packet16,
    /// An array of single rays.
    Stream,
}

impl Shape {
    fn width(self) -> usize {
        match self {
            Shape::Single | Shape::Stream => 1,
            Shape::Packet8 => 8,
            Shape::Packet16 => 16,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Shape::Single => "1",
            Shape::Packet8 => "8",
            Shape::Packet16 => "16",
            Shape::Stream => "stream",
        }
    }
}

#[derive(Clone, Copy)]
#[repr(align(64))]
struct Line([u32; 16]);

/// Which lanes of a packet are used: -1 or 0.
#[repr(align(64))]
struct Valid([i32; 16]);

/// Traces with Embree.
struct PeerWorker<'a> {
    embree: &'a Embree,
    scene: Handle,
    shape: Shape,
    coherent: bool,
    any: bool,
    rays: usize,
    lines: Vec<Line>,
}

impl PeerWorker<'_> {
    fn rows(&self) -> usize {
        if self.any { RAY_ROWS } else { HIT_ROWS }
    }

    fn packets(&self) -> usize {
        self.rays.div_ceil(self.shape.width())
    }

    fn words(&mut self) -> &mut [u32] {
        let count = self.lines.len() * 16;
        // SAFETY: lines are arrays of words without padding.
        unsafe { std::slice::from_raw_parts_mut(self.lines.as_mut_ptr().cast(), count) }
    }

    fn word(&self, row: usize, ray: usize) -> u32 {
        let width = self.shape.width();
        let at = ray / width * self.rows() * width + row * width + ray % width;
        self.lines[at / 16].0[at % 16]
    }
}

impl Worker for PeerWorker<'_> {
    fn load(&mut self, rays: &[Ray]) {
        self.rays = rays.len();
        let (width, rows) = (self.shape.width(), self.rows());
        let words = self.packets() * width * rows;
        self.lines.resize(words.div_ceil(16), Line([0; 16]));
        let to = self.words();
        for (i, ray) in rays.iter().enumerate() {
            let at = i / width * rows * width + i % width;
            let mut put = |row: usize, bits: u32| to[at + row * width] = bits;
            for axis in 0..3 {
                put(axis, ray.origin[axis].to_bits());
                put(4 + axis, ray.direction[axis].to_bits());
            }
            put(3, ray.tmin.to_bits());
            put(7, 0);
            put(ROW_TFAR, ray.tmax.to_bits());
            put(9, u32::MAX);
            put(10, i as u32);
            put(11, 0);
            if rows == HIT_ROWS {
                put(ROW_GEOMETRY, NO_GEOMETRY);
                put(19, NO_GEOMETRY);
            }
        }
    }

    fn trace(&mut self) {
        let mut context = Context::new(self.coherent);
        let (e, scene, any, shape) = (self.embree, self.scene, self.any, self.shape);
        let width = self.shape.width();
        let step = self.rows() * width;
        let (rays, packets) = (self.rays, self.packets());
        let words = self.words();
        let mut valid = Valid([-1; 16]);
        match shape {
            Shape::Single => {
                let call = if any { e.occluded1 } else { e.intersect1 };
                for ray in words.chunks_exact_mut(step).take(packets) {
                    // SAFETY: the scene is committed; a ray has the layout of RTCRay or RTCRayHit, aligned to 16.
                    unsafe { call(scene, &raw mut context, ray.as_mut_ptr()) };
                }
            }
            Shape::Packet8 | Shape::Packet16 => {
                let call = match (shape, any) {
                    (Shape::Packet8, false) => e.intersect8,
                    (Shape::Packet8, true) => e.occluded8,
                    (_, false) => e.intersect16,
                    (_, true) => e.occluded16,
                };
                for (i, packet) in words.chunks_exact_mut(step).take(packets).enumerate() {
                    if (i + 1) * width > rays {
                        valid.0[rays - i * width..].fill(0);
                    }
                    // SAFETY: as above, aligned to 64; `valid` is as wide as the widest packet and as aligned as Embree reads it.
                    unsafe { call(valid.0.as_ptr(), scene, &raw mut context, packet.as_mut_ptr()) };
                }
            }
            Shape::Stream => {
                let call = if any { e.occluded_stream } else { e.intersect_stream };
                for first in (0..rays).step_by(STREAM) {
                    let count = STREAM.min(rays - first);
                    let begin = words[first * step..(first + count) * step].as_mut_ptr();
                    // SAFETY: as above, for `count` rays, `step` words apart.
                    unsafe { call(scene, &raw mut context, begin, count as u32, step * 4) };
                }
            }
        }
    }

    fn hits(&self) -> usize {
        let hit = |&i: &usize| {
            if self.any {
                f32::from_bits(self.word(ROW_TFAR, i)) == f32::NEG_INFINITY
            } else {
                self.word(ROW_GEOMETRY, i) != NO_GEOMETRY
            }
        };
        (0..self.rays).filter(hit).count()
    }
}

/// Our lanes for rays of one kind.
pub fn our_lanes(tracer: Tracer<'_>, kind: Kind) -> Vec<Lane<'_>> {
    let lane = |mode: &'static crate::ours::Mode| {
        let column = if mode.single { Column::OursSingle } else { Column::OursMany };
        Lane::new(mode.name, column, move || {
            let rays = Vec::with_capacity(CHUNK);
            if kind == Kind::Shadow {
                Box::new(AnyWorker { tracer, call: mode.any, rays, found: Vec::with_capacity(CHUNK) })
            } else {
                Box::new(ClosestWorker { tracer, call: mode.closest, rays, found: Vec::with_capacity(CHUNK) })
            }
        })
    };
    MODES.iter().map(lane).collect()
}

/// A scene in Embree under the name that its lanes get.
pub struct Variant<'a> {
    pub name: &'static str,
    pub built: Built<'a>,
    pub robust: bool,
}

/// Embree's lanes for rays of one kind: single rays, and every packet that an expert might try. Bounce rays also as if they were coherent.
pub fn peer_lanes<'a>(
    embree: &'a Embree,
    variant: &'a Variant<'a>,
    kind: Kind,
    instanced: bool,
    has_16: bool,
) -> Vec<Lane<'a>> {
    let any = kind == Kind::Shadow;
    let mut shapes = vec![(Shape::Single, kind != Kind::Bounce)];
    for shape in [Shape::Packet8, Shape::Packet16, Shape::Stream] {
        // Without AVX-512 Embree takes packets of 16 apart into single rays.
        if shape == Shape::Packet16 && !has_16 {
            continue;
        }
        shapes.push((shape, true));
        if kind == Kind::Bounce {
            shapes.push((shape, false));
        }
    }
    // Embree 3.13.5 does not come back from these with instances.
    let hangs = |shape| any && instanced && matches!(shape, Shape::Packet16 | Shape::Stream);
    let lane = |(shape, coherent): (Shape, bool)| {
        let column = match (variant.robust, shape) {
            (false, Shape::Single) => Column::PeerSingle,
            (false, _) => Column::PeerPacket,
            (true, Shape::Single) => Column::RobustSingle,
            (true, _) => Column::RobustPacket,
        };
        let name = format!("{} {}{}", variant.name, shape.name(), if coherent { "c" } else { "i" });
        let scene = &variant.built.top;
        Lane::new(name, column, move || {
            let scene = scene.handle;
            Box::new(PeerWorker { embree, scene, shape, coherent, any, rays: 0, lines: Vec::new() })
        })
    };
    shapes.into_iter().filter(|(shape, _)| !hangs(*shape)).map(lane).collect()
}
