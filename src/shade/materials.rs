//! Which samples of a packet are lit together, and the colours of their surfaces in lanes.
//!
//! Hits of a packet mostly have one surface: they are taken in runs, and what belongs to the surface is written to lanes only where it
//! has changed since the packet before.

use crate::scene::Mesh;
use crate::shade::rows::{GROUPS, Held, Rows3, SLOTS, lanes_of, set_vec3, vec3};
use crate::shade::shade_scene::ShadeScene;
use crate::shade::surface::{Phong, Surface};
use crate::simd::{LANES, bits, prefetch};
use crate::trace::Hit;
use glam::Vec3;

/// Surfaces of the samples of a packet, those that can be lit in lanes.
pub(super) struct Materials {
    /// Per row: diffuse, ambient and emitted colour.
    pub held: [Held<9>; GROUPS],
    /// Number of the surface; of lit samples only.
    surface: [u32; SLOTS],
    /// Base colour factor (texture and vertex colour). White but for `coloured` samples.
    pub base: Rows3,
    coloured: u64,
    /// Samples at opaque surfaces of Phong's model, by what they ask for beyond their own colour.
    pub lit: u64,
    pub textured: u64,
    pub highlights: u64,
    /// A mirror or refracted ray.
    pub bouncing: u64,
}

impl Materials {
    pub fn new() -> Self {
        Self {
            held: std::array::from_fn(|_| Held::new()),
            surface: [0; SLOTS],
            base: [[[1.0; LANES]; GROUPS]; 3],
            coloured: 0,
            lit: 0,
            textured: 0,
            highlights: 0,
            bouncing: 0,
        }
    }

    /// Sorts what the rays of `mask` have hit: afterwards `lit` are the samples that can be lit together. Returns those that hit anything.
    pub fn sort(&mut self, scene: &ShadeScene, hits: &[Hit; SLOTS], mask: u64) -> u64 {
        for slot in bits(std::mem::take(&mut self.coloured)) {
            set_vec3(&mut self.base, slot, Vec3::ONE);
        }
        (self.lit, self.textured, self.highlights, self.bouncing) = (0, 0, 0, 0);
        let mut hit_anything = 0;
        // Of the last hit: instance, mesh, name of the shader.
        let (mut instance, mut mesh, mut name) = (u32::MAX, None, None);
        // Of the hits since the surface has changed.
        let (mut run, mut number, mut kind) = (0, 0, Kind::default());
        let mut left = mask;
        while left != 0 {
            let (slot, bit) = (left.trailing_zeros() as usize, left & left.wrapping_neg());
            left ^= bit;
            let hit = &hits[slot];
            if hit.is_none() {
                continue;
            }
            if hit.instance != instance {
                instance = hit.instance;
                let next = scene.mesh(instance);
                if mesh.is_some_and(|last: &Mesh| last.colors.is_empty() != next.colors.is_empty()) {
                    // Looked at anew, as it is a matter of the mesh whether there is a colour.
                    name = None;
                }
                mesh = Some(next);
            }
            let Some(mesh) = mesh else { continue };
            // It will be read when all hits are sorted.
            prefetch(&mesh.triangles, hit.prim as usize);
            let own = mesh.shader_of_triangle.get(hit.prim as usize).copied().unwrap_or(0);
            if name != Some(own) {
                self.take(kind, run);
                (hit_anything, run) = (hit_anything | run, 0);
                name = Some(own);
                number = scene.surface_number(own);
                kind = Kind::of(scene.numbered_surface(number), mesh);
            }
            self.surface[slot] = number;
            run |= bit;
        }
        self.take(kind, run);
        let uniform = hit_anything == 0 && kind.lit;
        hit_anything |= run;
        for g in 0..GROUPS {
            let lanes = lanes_of(self.lit, g);
            if lanes != 0 {
                let mut keys = [number; LANES];
                if !uniform {
                    let row = &self.surface[LANES * g..LANES * (g + 1)];
                    keys = [row[lanes.trailing_zeros() as usize % LANES]; LANES];
                    bits(u64::from(lanes)).for_each(|l| keys[l] = row[l]);
                }
                self.held[g].hold(&keys, |number| numbers(phong(scene, number)));
            }
        }
        hit_anything
    }

    /// Takes in the samples of `run`, whose surfaces are of one kind.
    fn take(&mut self, kind: Kind, run: u64) {
        let those = |asked: bool| if asked { run } else { 0 };
        self.lit |= those(kind.lit);
        self.textured |= those(kind.textured);
        self.highlights |= those(kind.highlight);
        self.bouncing |= those(kind.bouncing);
    }

    /// The surface of a lit sample.
    pub fn phong<'s>(&self, scene: &'s ShadeScene, slot: usize) -> &'s Phong {
        phong(scene, self.surface[slot])
    }

    /// The base colour of a lit sample.
    pub fn base(&self, slot: usize) -> Vec3 {
        vec3(&self.base, slot)
    }

    /// Gives a sample its base colour.
    pub fn set_base(&mut self, slot: usize, base: Vec3) {
        set_vec3(&mut self.base, slot, base);
        self.coloured |= 1 << slot;
    }
}

/// Whether a surface is lit together with others, and what it asks for then.
#[derive(Clone, Copy, Default)]
struct Kind {
    lit: bool,
    textured: bool,
    highlight: bool,
    bouncing: bool,
}

impl Kind {
    fn of(surface: &Surface, mesh: &Mesh) -> Self {
        match surface {
            // Alpha is 1 everywhere then.
            Surface::Phong(phong) if phong.alpha_threshold <= 0.0 && phong.opacity == 1.0 => Self {
                lit: true,
                textured: phong.texture.is_some() || !mesh.colors.is_empty(),
                highlight: phong.specular != Vec3::ZERO,
                bouncing: phong.reflection != Vec3::ZERO || phong.transmission != Vec3::ZERO,
            },
            _ => Self::default(),
        }
    }
}

fn phong<'s>(scene: &'s ShadeScene, number: u32) -> &'s Phong {
    match scene.numbered_surface(number) {
        Surface::Phong(phong) => phong,
        _ => unreachable!("only surfaces of Phong's model are lit in lanes"),
    }
}

fn numbers(phong: &Phong) -> [f32; 9] {
    let [d, a, e] = [phong.diffuse, phong.ambient, phong.emission];
    [d.x, d.y, d.z, a.x, a.y, a.z, e.x, e.y, e.z]
}
