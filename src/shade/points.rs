//! The hit points of a packet, eight at a time: what [`super::interaction`] has for one.
//!
//! The same operations in the same order, so a point has the same bits either way; a test (`render::tests`) holds both against each other. What is not arithmetic
//! (texture coordinates, colours) is left to [`Points::interaction`], for the few surfaces that ask.
//! Matrices are written to lanes only where the instance changes from one row to the next.

use crate::scene::Mesh;
use crate::shade::footprint::Cone;
use crate::shade::interaction::{CLEARANCE, GRAZING, Interaction, Placement, TEST_CLEARANCE};
use crate::shade::rows::{GROUPS, Held, Rows, Rows3, SLOTS, Words, ZEROS, lanes_of, row3, row3_mut, vec3};
use crate::shade::shade_scene::ShadeScene;
use crate::simd::{Isa, LANES, Level, Proof, Wide, Wide3, WideKernel, components, run_wide};
use crate::trace::{Hit, RayPacket};
use glam::{Mat4, Vec3, Vec4};

/// Points of up to 64 samples.
pub(super) struct Points {
    pub position: Rows3,
    pub geometric_normal: Rows3,
    pub normal: Rows3,
    /// Distance along the geometric normal that a secondary ray's origin needs; only where it was asked for.
    pub clearance: Rows,
    /// Of the hits, as [`Points::take`] found them: also of rays that hit nothing.
    pub distance: Rows,
    u: Rows,
    v: Rows,
    pub prim: Words,
    pub object: Words,
    pub instance: Words,
    pub back_facing: u64,
    /// On the way to the clearance: how far errors reach, and two shares that do not depend on the normal.
    reach: Rows3,
    of_test: [Rows; 2],
    corners: [Corners; GROUPS],
    placed: Held<24>,
}

/// What is read of hits and meshes for one row.
#[derive(Clone, Copy)]
struct Corners {
    /// Three numbers of each corner.
    positions: [[f32; LANES]; 9],
    /// Likewise; then, in the world, the sum of the three and the one at the point.
    normals: [[f32; LANES]; 9],
    /// Of the first hit where a lane has none.
    instance: [u32; LANES],
    /// Lanes whose mesh has normals.
    smooth: u32,
}

impl Points {
    pub fn new() -> Self {
        let zeros = [[0.0; LANES]; 9];
        let corners = Corners { positions: zeros, normals: zeros, instance: [0; LANES], smooth: 0 };
        Self {
            position: [ZEROS; 3],
            geometric_normal: [ZEROS; 3],
            normal: [ZEROS; 3],
            clearance: ZEROS,
            distance: ZEROS,
            u: ZEROS,
            v: ZEROS,
            prim: [[0; LANES]; GROUPS],
            object: [[0; LANES]; GROUPS],
            instance: [[0; LANES]; GROUPS],
            back_facing: 0,
            reach: [ZEROS; 3],
            of_test: [ZEROS; 2],
            corners: [corners; GROUPS],
            placed: Held::new(),
        }
    }

    /// Forgets which instances are held.
    pub fn forget(&mut self) {
        self.placed.forget();
    }

    /// Takes in what the rays of `mask` have hit. Returns those that hit anything; the others have normal 0.
    pub fn take(&mut self, level: Level, hits: &[Hit; SLOTS], mask: u64) -> u64 {
        run_wide(level, Take { points: self, hits, mask })
    }

    /// Computes the points of the hits in `mask`, which have been taken in.
    pub fn find(&mut self, level: Level, scene: &ShadeScene, rays: &RayPacket, mask: u64, clearance: bool) {
        self.back_facing = 0;
        run_wide(level, Find { points: self, scene, rays, mask, clearance });
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

    /// Reads the vertex numbers of the triangles in row `g`; lanes without a hit get those of the first.
    #[inline(always)]
    fn numbers<'s>(&mut self, scene: &ShadeScene<'s>, g: usize, lanes: u32) -> Row<'s> {
        let (instances, prims) = (&self.instance[g], &self.prim[g]);
        let first = lanes.trailing_zeros() as usize % LANES;
        let instance = instances[first];
        let mesh = scene.mesh(instance);
        let keys = &mut self.corners[g].instance;
        *keys = [instance; LANES];
        let mut triangles = [[0; 3]; LANES];
        if lanes == 0xff && *instances == *keys {
            for (triangle, &prim) in triangles.iter_mut().zip(prims) {
                *triangle = mesh.triangles[prim as usize];
            }
            return Row { triangles, mesh: Some(mesh) };
        }
        // As much for each lane, whether it has a hit or not: which do is not to be foreseen.
        let mut others = 0;
        for l in 0..LANES {
            let from = if lanes >> l & 1 == 1 { l } else { first };
            keys[l] = instances[from];
            others |= instances[from] ^ instance;
            let mesh = scene.mesh(keys[l]);
            triangles[l] = mesh.triangles[prims[from] as usize];
        }
        Row { triangles, mesh: (others == 0).then_some(mesh) }
    }

    /// Fetches the corners of the triangles in row `g`.
    #[inline(always)]
    fn gather(&mut self, scene: &ShadeScene, g: usize, row: &Row) {
        let corners = &mut self.corners[g];
        if let Some(mesh) = row.mesh {
            corners.smooth = if mesh.normals.is_empty() { 0 } else { 0xff };
            let positions = components(&mesh.positions);
            corners_of(|_| positions, &row.triangles, &mut corners.positions);
            if corners.smooth != 0 {
                let normals = components(&mesh.normals);
                corners_of(|_| normals, &row.triangles, &mut corners.normals);
            }
            return;
        }
        let meshes = corners.instance.map(|instance| scene.mesh(instance));
        corners_of(|l| components(&meshes[l].positions), &row.triangles, &mut corners.positions);
        corners.smooth = 0;
        for (l, mesh) in meshes.iter().enumerate() {
            if !mesh.normals.is_empty() {
                corners.smooth |= 1 << l;
                for (c, &i) in row.triangles[l].iter().enumerate() {
                    for (k, n) in mesh.normals[i as usize].to_array().into_iter().enumerate() {
                        corners.normals[3 * c + k][l] = n;
                    }
                }
            }
        }
    }
}

/// The triangles of a row.
#[derive(Clone, Copy)]
struct Row<'a> {
    /// Numbers of their vertices.
    triangles: [[u32; 3]; LANES],
    /// That of all, if it is one.
    mesh: Option<&'a Mesh>,
}

/// Three numbers of each corner of eight triangles, read from the `coordinates` of each.
#[inline(always)]
fn corners_of<'a>(coordinates: impl Fn(usize) -> &'a [f32], triangles: &[[u32; 3]; LANES], to: &mut [[f32; LANES]; 9]) {
    for c in 0..3 {
        for half in [0, 4] {
            let of = |l: usize| vertex(coordinates(half + l), triangles[half + l][c]);
            let lanes = Mat4::from_cols(of(0), of(1), of(2), of(3)).transpose();
            for (k, axis) in [lanes.x_axis, lanes.y_axis, lanes.z_axis].into_iter().enumerate() {
                to[3 * c + k][half..half + 4].copy_from_slice(&axis.to_array());
            }
        }
    }
}

/// A vertex; the last lane is meaningless.
#[inline(always)]
fn vertex(coordinates: &[f32], number: u32) -> Vec4 {
    let start = 3 * number as usize;
    match coordinates.get(start..start + 4) {
        Some(point) => Vec4::from_slice(point),
        // The last vertex of the mesh.
        None => Vec4::new(coordinates[start], coordinates[start + 1], coordinates[start + 2], 0.0),
    }
}

struct Take<'a> {
    points: &'a mut Points,
    hits: &'a [Hit; SLOTS],
    mask: u64,
}

impl WideKernel for Take<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<I: Isa>(self, isa: Proof<I>) -> u64 {
        let Self { points, hits, mask } = self;
        let numbers = Hit::numbers(hits).as_flattened();
        let mut hit = 0;
        for g in 0..GROUPS {
            let lanes = lanes_of(mask, g);
            if lanes == 0 {
                continue;
            }
            let mut rows = [isa.splat(0.0); LANES];
            for (l, row) in rows.iter_mut().enumerate() {
                // Six numbers, and two of the next hit.
                let rest = &numbers[6 * (LANES * g + l)..];
                *row = match rest.first_chunk() {
                    Some(numbers) => isa.load(numbers),
                    None => isa.load(&[rest[0], rest[1], rest[2], rest[3], rest[4], rest[5], 0.0, 0.0]),
                };
            }
            let [t, u, v, prim, object, instance, _, _] = isa.transposed(rows);
            t.store(&mut points.distance[g]);
            u.store(&mut points.u[g]);
            v.store(&mut points.v[g]);
            prim.store_bits(&mut points.prim[g]);
            object.store_bits(&mut points.object[g]);
            instance.store_bits(&mut points.instance[g]);
            let mut found = 0;
            for (l, &prim) in points.prim[g].iter().enumerate() {
                found |= u32::from(prim != Hit::NOTHING) << l;
            }
            let found = found & lanes;
            hit |= u64::from(found) << (LANES * g);
            if found != 0xff {
                isa.splat3(Vec3::ZERO).store(row3_mut(&mut points.normal, g));
            }
        }
        hit
    }
}

struct Find<'a, 's> {
    points: &'a mut Points,
    scene: &'a ShadeScene<'s>,
    rays: &'a RayPacket,
    mask: u64,
    clearance: bool,
}

impl WideKernel for Find<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: Proof<I>) {
        if self.clearance { self.all::<I, true>(isa) } else { self.all::<I, false>(isa) }
    }
}

impl Find<'_, '_> {
    #[inline(always)]
    fn all<I: Isa, const SPAWN: bool>(self, isa: Proof<I>) {
        let Self { points, scene, rays, mask, .. } = self;
        // All rows at a time, step by step: the processor waits for several meshes at once, and not for single numbers on their way to a vector, nor
        // for one division after the other.
        let mut rows = [Row { triangles: [[0; 3]; LANES], mesh: None }; GROUPS];
        for (g, row) in rows.iter_mut().enumerate() {
            if lanes_of(mask, g) != 0 {
                *row = points.numbers(scene, g, lanes_of(mask, g));
            }
        }
        for (g, row) in rows.iter().enumerate() {
            if lanes_of(mask, g) != 0 {
                points.gather(scene, g, row);
            }
        }
        for g in 0..GROUPS {
            if lanes_of(mask, g) != 0 {
                points.placed.hold_wide(isa, &points.corners[g].instance, |instance| &scene.placed(instance).numbers);
                points.lay::<I, SPAWN>(isa, g);
            }
        }
        for g in 0..GROUPS {
            let lanes = lanes_of(mask, g);
            if lanes != 0 {
                let back_facing = points.face::<I, SPAWN>(isa, isa.load3(row3(&rays.dir, g)), g, lanes);
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
    /// The points of row `g`, of which everything has been fetched, and normals of any length. With `SPAWN`, also what the clearance takes.
    #[inline(always)]
    fn lay<I: Isa, const SPAWN: bool>(&mut self, isa: Proof<I>, g: usize) {
        let fetched = &mut self.corners[g];
        let (u, v) = (isa.load(&self.u[g]), isa.load(&self.v[g]));
        let weights = [(isa.splat(1.0) - u) - v, u, v];
        let numbers = &self.placed.rows;
        let linear = columns(isa, numbers, 0);
        let cofactor = columns(isa, numbers, 12);
        let orientation = isa.load(&numbers[21]);

        let corners = columns(isa, &fetched.positions, 0);
        let position = times(&linear, mix(&corners, &weights)) + vector(isa, numbers, 9);
        position.store(row3_mut(&mut self.position, g));
        let edges = [corners[1] - corners[0], corners[2] - corners[0]];
        let size = edges[0].abs().max_element().max(edges[1].abs().max_element());
        let shrink = reciprocal(isa, size);
        let object_normal = (edges[0] * shrink).cross(edges[1] * shrink);
        (times(&cofactor, object_normal) * orientation).store(row3_mut(&mut self.geometric_normal, g));
        if fetched.smooth != 0 {
            let n = columns(isa, &fetched.normals, 0);
            let outward = times(&cofactor, n[0] + n[1] + n[2]) * orientation;
            let mixed = times(&cofactor, mix(&n, &weights)) * orientation;
            let [x, y, z, u, v, w, ..] = &mut fetched.normals;
            outward.store([x, y, z]);
            mixed.store([u, v, w]);
        }
        if SPAWN {
            let translation = vector(isa, numbers, 9).abs();
            let (linear_abs, cofactor_abs) = (magnitudes(&linear), magnitudes(&cofactor));
            let magnitude = corners[0].abs().max(corners[1].abs()).max(corners[2].abs());
            let reach = times(&linear_abs, magnitude) + translation;
            // The transposed cofactors: rows instead of columns.
            let returned = transposed(&cofactor_abs);
            let back = times(&linear_abs, times(&returned, reach)) * isa.load(&numbers[22]);
            let most = isa.splat(f32::MAX);
            let finite = back.x.abs().le(most) & back.y.abs().le(most) & back.z.abs().le(most);
            back.max(reach).select(reach, finite).store(row3_mut(&mut self.reach, g));
            let world_edges = [times(&linear, edges[0]), times(&linear, edges[1])];
            let world_size = world_edges[0].abs().max(world_edges[1].abs()).max_element();
            let double_area = world_edges[0].cross(world_edges[1]).length();
            let one = isa.splat(1.0);
            let shrink = reciprocal(isa, world_size);
            let stretch = isa.load(&numbers[23]);
            let of_test = isa.splat(TEST_CLEARANCE) * size * stretch * (one + reciprocal(isa, object_normal.length()));
            of_test.store(&mut self.of_test[0][g]);
            let of_world = isa.splat(TEST_CLEARANCE) * world_size * reciprocal(isa, double_area * (shrink * shrink));
            of_world.store(&mut self.of_test[1][g]);
        }
    }

    /// Makes the normals of row `g` unit vectors towards the viewer. Returns the lanes that are seen from behind.
    #[inline(always)]
    fn face<I: Isa, const SPAWN: bool>(&mut self, isa: Proof<I>, incoming: Wide3<I>, g: usize, lanes: u32) -> u32 {
        let raised = isa.load3(row3(&self.geometric_normal, g));
        let mut geometric_normal = raised.normalize_or(-incoming, isa);
        let mut normal = geometric_normal;
        let Corners { smooth, normals: [x, y, z, u, v, w, ..], .. } = &self.corners[g];
        let smooth = *smooth;
        if smooth != 0 {
            let (outward, mixed) = (isa.load3([x, y, z]), isa.load3([u, v, w]));
            let inward = outward.dot(geometric_normal).lt(isa.splat(0.0)) & smooth;
            if inward != 0 {
                geometric_normal = (-geometric_normal).select(geometric_normal, inward);
            }
            let mixed = mixed.normalize_or(geometric_normal, isa);
            normal = if smooth == 0xff { mixed } else { mixed.select(geometric_normal, smooth) };
        }
        let back_facing = isa.splat(0.0).lt(geometric_normal.dot(incoming));
        if back_facing != 0 {
            geometric_normal = (-geometric_normal).select(geometric_normal, back_facing);
            normal = (-normal).select(normal, back_facing);
        }
        normal = towards_viewer(isa, normal, incoming);
        geometric_normal.store(row3_mut(&mut self.geometric_normal, g));
        if lanes != 0xff {
            normal = normal.select(isa.load3(row3(&self.normal, g)), lanes);
        }
        normal.store(row3_mut(&mut self.normal, g));
        if SPAWN {
            let clearance = isa.splat(CLEARANCE) * geometric_normal.abs().dot(isa.load3(row3(&self.reach, g)))
                + isa.load(&self.of_test[0][g])
                + isa.load(&self.of_test[1][g]);
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
