//! The hit points of a packet, eight at a time: what [`super::interaction`] has for one.
//!
//! The same operations in the same order, so a point has the same bits either way; a test (`render::tests`) holds both against each other. What is not arithmetic
//! (texture coordinates, colours) is left to [`Points::interaction`], for the few surfaces that ask.
//! Matrices are written to lanes only where the instance changes from one row to the next.

use crate::shade::footprint::Cone;
use crate::shade::interaction::{CLEARANCE, GRAZING, Interaction, Placement, TEST_CLEARANCE};
use crate::shade::rows::{GROUPS, Held, Rows, Rows3, SLOTS, ZEROS, lanes_of, row3, row3_mut, vec3};
use crate::shade::shade_scene::ShadeScene;
use crate::simd::{Isa, LANES, Level, Proof, Wide, Wide3, WideKernel, bits, run_wide};
use crate::trace::{Hit, RayPacket};

/// Points of up to 64 samples.
pub(super) struct Points {
    pub position: Rows3,
    pub geometric_normal: Rows3,
    pub normal: Rows3,
    /// Distance along the geometric normal that a secondary ray's origin needs; only where it was asked for.
    pub clearance: Rows,
    pub distance: Rows,
    pub object: [u32; SLOTS],
    pub instance: [u32; SLOTS],
    pub back_facing: u64,
    corners: [Corners; GROUPS],
    placed: Held<24>,
}

/// What is read of hits and meshes for one row.
#[derive(Clone, Copy)]
struct Corners {
    /// Three numbers of each corner.
    positions: [[f32; LANES]; 9],
    normals: [[f32; LANES]; 9],
    u: [f32; LANES],
    v: [f32; LANES],
    instance: [u32; LANES],
    /// Lanes whose mesh has normals.
    smooth: u32,
}

impl Points {
    pub fn new() -> Self {
        let zeros = [[0.0; LANES]; 9];
        let (u, v) = ([0.0; LANES], [0.0; LANES]);
        let corners = Corners { positions: zeros, normals: zeros, u, v, instance: [0; LANES], smooth: 0 };
        Self {
            position: [ZEROS; 3],
            geometric_normal: [ZEROS; 3],
            normal: [ZEROS; 3],
            clearance: ZEROS,
            distance: ZEROS,
            object: [0; SLOTS],
            instance: [0; SLOTS],
            back_facing: 0,
            corners: [corners; GROUPS],
            placed: Held::new(),
        }
    }

    /// Computes the points of the hits in `mask`.
    pub fn find(
        &mut self,
        level: Level,
        scene: &ShadeScene,
        rays: &RayPacket,
        hits: &[Hit; SLOTS],
        mask: u64,
        clearance: bool,
    ) {
        self.back_facing = 0;
        run_wide(level, Find { points: self, scene, rays, hits, mask, clearance });
    }

    /// Everything about one point.
    pub fn interaction<'s>(
        &self,
        scene: &'s ShadeScene,
        rays: &RayPacket,
        hits: &[Hit; SLOTS],
        slot: usize,
        cone: Cone,
    ) -> Interaction<'s> {
        let hit = &hits[slot];
        let at = Placement {
            position: vec3(&self.position, slot),
            geometric_normal: vec3(&self.geometric_normal, slot),
            normal: vec3(&self.normal, slot),
            back_facing: self.back_facing >> slot & 1 == 1,
        };
        let (placed, mesh) = (scene.placed(hit.instance), scene.mesh(hit.instance));
        Interaction::placed_at(at, vec3(&rays.dir, slot), hit, placed, mesh, cone, 0)
    }

    /// Fetches what the hits of row `g` need.
    #[inline(always)]
    fn gather(&mut self, scene: &ShadeScene, hits: &[Hit; SLOTS], g: usize, lanes: u32) {
        let Self { corners, distance, object, instance, .. } = self;
        let (corners, row) = (&mut corners[g], &hits[LANES * g..LANES * (g + 1)]);
        let first = row[lanes.trailing_zeros() as usize % LANES].instance;
        corners.instance = [first; LANES];
        corners.smooth = 0;
        let (mut last, mut mesh) = (first, scene.mesh(first));
        for l in bits(u64::from(lanes)) {
            let (l, hit) = (l % LANES, &row[l % LANES]);
            if hit.instance != last {
                (last, mesh) = (hit.instance, scene.mesh(hit.instance));
            }
            corners.instance[l] = hit.instance;
            corners.u[l] = hit.u;
            corners.v[l] = hit.v;
            distance[g][l] = hit.t;
            object[LANES * g + l] = hit.object;
            instance[LANES * g + l] = hit.instance;
            let triangle = mesh.triangles[hit.prim as usize];
            for (c, i) in triangle.into_iter().enumerate() {
                let p = mesh.positions[i as usize];
                for k in 0..3 {
                    corners.positions[3 * c + k][l] = p[k];
                }
            }
            if !mesh.normals.is_empty() {
                corners.smooth |= 1 << l;
                for (c, i) in triangle.into_iter().enumerate() {
                    let n = mesh.normals[i as usize];
                    for k in 0..3 {
                        corners.normals[3 * c + k][l] = n[k];
                    }
                }
            }
        }
    }
}

struct Find<'a, 's> {
    points: &'a mut Points,
    scene: &'a ShadeScene<'s>,
    rays: &'a RayPacket,
    hits: &'a [Hit; SLOTS],
    mask: u64,
    clearance: bool,
}

impl WideKernel for Find<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: Proof<I>) {
        let Self { points, scene, rays, hits, mask, clearance } = self;
        // All rows first: the processor waits for several meshes at a time, and not for single numbers on their way to a vector.
        for g in 0..GROUPS {
            if lanes_of(mask, g) != 0 {
                points.gather(scene, hits, g, lanes_of(mask, g));
            }
        }
        for g in 0..GROUPS {
            if lanes_of(mask, g) != 0 {
                points.placed.hold(&points.corners[g].instance, |instance| scene.placed(instance).numbers());
                let back_facing = points.place(isa, isa.load3(row3(&rays.dir, g)), g, clearance);
                points.back_facing |= u64::from(back_facing) << (LANES * g);
            }
        }
    }
}

/// Columns of a matrix.
type Columns<I> = [Wide3<I>; 3];

#[inline(always)]
fn times<I: Isa>(m: &Columns<I>, v: Wide3<I>) -> Wide3<I> {
    m[0] * v.x + m[1] * v.y + m[2] * v.z
}

/// Rows `i` to `i + 2` as a vector.
#[inline(always)]
fn vector<I: Isa>(isa: Proof<I>, rows: &[[f32; LANES]], i: usize) -> Wide3<I> {
    isa.load3([&rows[i], &rows[i + 1], &rows[i + 2]])
}

/// The nine rows from `i` on. (Not by `map`: what it calls would not get the kernel's instructions.)
#[inline(always)]
fn columns<I: Isa>(isa: Proof<I>, rows: &[[f32; LANES]], i: usize) -> Columns<I> {
    [vector(isa, rows, i), vector(isa, rows, i + 3), vector(isa, rows, i + 6)]
}

#[inline(always)]
fn mix<I: Isa>(corners: &Columns<I>, weights: &[Wide<I>; 3]) -> Wide3<I> {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

#[inline(always)]
fn magnitudes<I: Isa>(m: &Columns<I>) -> Columns<I> {
    [m[0].abs(), m[1].abs(), m[2].abs()]
}

/// 1/x, or 1 where that is of no use, as in [`super::placed`].
#[inline(always)]
fn reciprocal<I: Isa>(isa: Proof<I>, x: Wide<I>) -> Wide<I> {
    let (one, r) = (isa.splat(1.0), isa.splat(1.0) / x);
    let good = r.le(isa.splat(f32::MAX)) & isa.splat(0.0).lt(r);
    if good == 0xff { r } else { r.select(one, good) }
}

impl Points {
    /// The points of row `g`, of which everything has been fetched. Returns the lanes that are seen from behind.
    #[inline(always)]
    fn place<I: Isa>(&mut self, isa: Proof<I>, incoming: Wide3<I>, g: usize, clearance: bool) -> u32 {
        let fetched = &self.corners[g];
        let (u, v) = (isa.load(&fetched.u), isa.load(&fetched.v));
        let weights = [(isa.splat(1.0) - u) - v, u, v];
        let numbers = &self.placed.rows;
        let linear = columns(isa, numbers, 0);
        let cofactor = columns(isa, numbers, 12);
        let orientation = isa.load(&numbers[21]);

        let corners = columns(isa, &fetched.positions, 0);
        let position = times(&linear, mix(&corners, &weights)) + vector(isa, numbers, 9);
        let edges = [corners[1] - corners[0], corners[2] - corners[0]];
        let size = edges[0].abs().max_element().max(edges[1].abs().max_element());
        let shrink = reciprocal(isa, size);
        let object_normal = (edges[0] * shrink).cross(edges[1] * shrink);
        let mut geometric_normal = (times(&cofactor, object_normal) * orientation).normalize_or(-incoming, isa);
        let mut normal = geometric_normal;
        let smooth = fetched.smooth;
        if smooth != 0 {
            let n = columns(isa, &fetched.normals, 0);
            let outward = times(&cofactor, n[0] + n[1] + n[2]) * orientation;
            let inward = outward.dot(geometric_normal).lt(isa.splat(0.0)) & smooth;
            if inward != 0 {
                geometric_normal = (-geometric_normal).select(geometric_normal, inward);
            }
            let mixed = (times(&cofactor, mix(&n, &weights)) * orientation).normalize_or(geometric_normal, isa);
            normal = if smooth == 0xff { mixed } else { mixed.select(geometric_normal, smooth) };
        }
        let back_facing = isa.splat(0.0).lt(geometric_normal.dot(incoming));
        if back_facing != 0 {
            geometric_normal = (-geometric_normal).select(geometric_normal, back_facing);
            normal = (-normal).select(normal, back_facing);
        }
        normal = towards_viewer(isa, normal, incoming);
        position.store(row3_mut(&mut self.position, g));
        geometric_normal.store(row3_mut(&mut self.geometric_normal, g));
        normal.store(row3_mut(&mut self.normal, g));
        if clearance {
            let translation = vector(isa, numbers, 9).abs();
            let (linear_abs, cofactor_abs) = (magnitudes(&linear), magnitudes(&cofactor));
            let magnitude = corners[0].abs().max(corners[1].abs()).max(corners[2].abs());
            let reach = times(&linear_abs, magnitude) + translation;
            // The transposed cofactors: rows instead of columns.
            let returned = transposed(&cofactor_abs);
            let back = times(&linear_abs, times(&returned, reach)) * isa.load(&numbers[22]);
            let most = isa.splat(f32::MAX);
            let finite = back.x.abs().le(most) & back.y.abs().le(most) & back.z.abs().le(most);
            let bound = back.max(reach).select(reach, finite);
            let world_edges = [times(&linear, edges[0]), times(&linear, edges[1])];
            let world_size = world_edges[0].abs().max(world_edges[1].abs()).max_element();
            let double_area = world_edges[0].cross(world_edges[1]).length();
            let one = isa.splat(1.0);
            let shrink = reciprocal(isa, world_size);
            let stretch = isa.load(&numbers[23]);
            let clearance = isa.splat(CLEARANCE) * geometric_normal.abs().dot(bound)
                + isa.splat(TEST_CLEARANCE) * size * stretch * (one + reciprocal(isa, object_normal.length()))
                + isa.splat(TEST_CLEARANCE) * world_size * reciprocal(isa, double_area * (shrink * shrink));
            clearance.store(&mut self.clearance[g]);
        }
        back_facing
    }
}

#[inline(always)]
fn transposed<I: Isa>(m: &Columns<I>) -> Columns<I> {
    let [a, b, c] = *m;
    [Wide3 { x: a.x, y: b.x, z: c.x }, Wide3 { x: a.y, y: b.y, z: c.y }, Wide3 { x: a.z, y: b.z, z: c.z }]
}

/// See [`super::interaction`].
#[inline(always)]
fn towards_viewer<I: Isa>(isa: Proof<I>, n: Wide3<I>, incoming: Wide3<I>) -> Wide3<I> {
    let grazing = isa.splat(GRAZING);
    let cosine = -n.dot(incoming);
    let visible = grazing.le(cosine);
    if visible == 0xff {
        return n;
    }
    let bent = (n - incoming * (grazing - cosine)).normalize_or(-incoming, isa);
    n.select(bent, visible)
}
