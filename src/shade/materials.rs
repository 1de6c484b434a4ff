//! Which samples of a packet are lit together, and the colours of their surfaces in lanes.
//!
//! Hits of a packet mostly have one surface: rows of eight that look alike are taken as they are, others hit by hit, and what belongs to the
//! surface is written to lanes only where it has changed since the packet before.

use crate::scene::{Mesh, Name};
use crate::shade::points::Points;
use crate::shade::rows::{GROUPS, Held, Rows3, Words, lanes_of, set_vec3, vec3};
use crate::shade::shade_scene::{MANY, ShadeScene};
use crate::shade::surface::{Phong, Surface};
use crate::simd::{LANES, bits};
use glam::Vec3;

/// Surfaces of the samples of a packet, those that can be lit in lanes.
pub(super) struct Materials {
    /// Per row: diffuse, ambient and emitted colour.
    pub held: [Held<9>; GROUPS],
    /// Number of the surface; of lit samples only.
    surface: Words,
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
            surface: [[0; LANES]; GROUPS],
            base: [[[1.0; LANES]; GROUPS]; 3],
            coloured: 0,
            lit: 0,
            textured: 0,
            highlights: 0,
            bouncing: 0,
        }
    }

    /// Forgets which surfaces are held.
    pub fn forget(&mut self) {
        self.held.iter_mut().for_each(Held::forget);
    }

    /// Sorts what the rays of `mask` have hit, which has been taken in: afterwards `lit` are the samples that can be lit together.
    pub fn sort(&mut self, scene: &ShadeScene, points: &Points, mask: u64) {
        for slot in bits(std::mem::take(&mut self.coloured)) {
            set_vec3(&mut self.base, slot, Vec3::ONE);
        }
        (self.lit, self.textured, self.highlights, self.bouncing) = (0, 0, 0, 0);
        let mut last = Last { mesh: None, look: MANY, whole: false, name: None, number: 0, kind: Kind::default() };
        for g in 0..GROUPS {
            let lanes = lanes_of(mask, g);
            if lanes == 0 {
                continue;
            }
            let (instances, prims) = (&points.instance[g], &points.prim[g]);
            // Lanes without a hit go with the first. (As much for each, as which have one is not to be foreseen.)
            let first = lanes.trailing_zeros() as usize % LANES;
            let look = scene.look(instances[first]);
            let mut others = 0;
            for (l, &instance) in instances.iter().enumerate() {
                others |= scene.look(if lanes >> l & 1 == 1 { instance } else { instances[first] }) ^ look;
            }
            if others == 0 && look != MANY {
                if look != last.look {
                    last.look = look;
                    last.enter(scene, instances[first]);
                }
                self.take(last.kind, u64::from(lanes) << (LANES * g));
                self.surface[g] = [last.number; LANES];
                continue;
            }
            last.look = MANY;
            let mut numbers = [0; LANES];
            for l in bits(u64::from(lanes)).map(|l| l % LANES) {
                last.enter(scene, instances[l]);
                last.meet(scene, prims[l]);
                if l == first {
                    numbers = [last.number; LANES];
                }
                numbers[l] = last.number;
                self.take(last.kind, 1 << (LANES * g + l));
            }
            self.surface[g] = numbers;
        }
        for g in 0..GROUPS {
            let lanes = lanes_of(self.lit, g);
            if lanes != 0 {
                let mut keys = self.surface[g];
                if lanes != lanes_of(mask, g) {
                    // Not all are of Phong's model.
                    let own = keys;
                    keys = [own[lanes.trailing_zeros() as usize % LANES]; LANES];
                    bits(u64::from(lanes)).for_each(|l| keys[l] = own[l]);
                }
                self.held[g].hold(&keys, |number| numbers(phong(scene, number)));
            }
        }
    }

    /// Takes in the samples of `run`, whose surfaces are of one kind.
    #[inline(always)]
    fn take(&mut self, kind: Kind, run: u64) {
        let those = |asked: bool| if asked { run } else { 0 };
        self.lit |= those(kind.lit);
        self.textured |= those(kind.textured);
        self.highlights |= those(kind.highlight);
        self.bouncing |= those(kind.bouncing);
    }

    /// The surface of a lit sample.
    pub fn phong<'s>(&self, scene: &'s ShadeScene, slot: usize) -> &'s Phong {
        phong(scene, self.surface[slot / LANES][slot % LANES])
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

/// The last hit that was sorted.
struct Last<'a> {
    mesh: Option<(u32, &'a Mesh)>,
    /// The look of the last row, if all of it had one.
    look: u32,
    /// Whether all of the instance has this surface.
    whole: bool,
    /// Of the surface. The name is None where it is not that of a triangle of the mesh.
    name: Option<Name>,
    number: u32,
    kind: Kind,
}

impl<'a> Last<'a> {
    /// Goes on to an instance.
    #[inline(always)]
    fn enter(&mut self, scene: &ShadeScene<'a>, instance: u32) {
        if self.mesh.is_none_or(|(last, _)| last != instance) {
            let mesh = scene.mesh(instance);
            self.mesh = Some((instance, mesh));
            // It is a matter of the mesh too what kind a surface is of.
            self.name = None;
            let look = scene.look(instance);
            self.whole = look != MANY;
            if self.whole {
                self.number = look >> 1;
                self.kind = Kind::of(scene.numbered_surface(self.number), mesh);
            }
        }
    }

    /// Goes on to a triangle of the instance.
    #[inline(always)]
    fn meet(&mut self, scene: &ShadeScene, prim: u32) {
        let Some((_, mesh)) = self.mesh.filter(|_| !self.whole) else { return };
        let name = mesh.shader_of_triangle.get(prim as usize).copied().unwrap_or(0);
        if self.name != Some(name) {
            self.name = Some(name);
            self.number = scene.surface_number(name);
            self.kind = Kind::of(scene.numbered_surface(self.number), mesh);
        }
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
            Surface::Phong(phong) if phong.alpha.is_opaque() => Self {
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
