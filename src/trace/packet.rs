//! Up to 64 rays of one space, as structure of arrays, and what they have found so far.
//!
//! Rays are numbered 0..64; ray `8 g + l` is lane `l` of group `g`, and bit `8 g + l` of a mask. Every number here is computed by the operations
//! of [`PreparedRay::new`] and of the transform in `traverse_scene`, in 8 lanes, so a ray has the same bits in a packet as alone.
//! Lanes without a ray hold copies of another one: they cost nothing and are masked wherever it matters.

use super::packet_query::RayPacket;
use super::tracer::USUAL_LENGTH;
use super::turns::Habits;
use super::{Hit, PreparedRay, Ray, ray::MIN_DIRECTION};
use crate::accel::MAX_COORDINATE;
use crate::simd::{Eight, Isa, Vector};
use glam::{Affine3A, Vec3};

/// Rays per SIMD vector.
pub(super) const LANES: usize = 8;
/// Vectors per packet.
pub(super) const GROUPS: usize = 8;
/// Rays per packet.
pub(super) const RAYS: usize = LANES * GROUPS;

/// One number per ray.
pub type Rows = [[f32; LANES]; GROUPS];

/// The rays, prepared for box and triangle tests.
#[repr(C, align(64))]
pub(super) struct Packet {
    pub org: [Rows; 3],
    pub dir: [Rows; 3],
    pub inv_dir: [Rows; 3],
    pub shear: [Rows; 3],
    pub tmin: Rows,
    /// Per axis, the rays whose `inv_dir` is below 0.
    pub negative: [u64; 3],
    /// Per axis, the rays whose direction is longest there.
    pub dominant: [u64; 3],
    /// That axis of each ray.
    longest: [[u8; LANES]; GROUPS],
    /// The rays that can hit anything (see [`PreparedRay::new`]).
    pub usable: u64,
}

/// What the rays of a packet have found, in all spaces alike, and what is kept from packet to packet.
#[derive(Clone)]
#[repr(C, align(64))]
pub(super) struct Found {
    /// Distance of the best hit, at first the ray's `tmax`.
    pub t: Rows,
    /// The best hits; they mean nothing when any hit will do.
    pub hits: [Hit; RAYS],
    /// The rays that are still searching. A ray looking for any hit leaves when it has one.
    pub open: u64,
    /// See [`Habits::NONE`].
    pub habits: [[Habits; 2]; 2],
}

impl Found {
    pub(super) fn new() -> Self {
        Self { t: [[0.0; LANES]; GROUPS], hits: [Hit::none(0.0); RAYS], open: 0, habits: Habits::NONE }
    }

    /// The rays of group `g` have no hits yet, up to `tmax`.
    #[inline(always)]
    fn clear_hits(&mut self, g: usize, tmax: &[f32; LANES]) {
        for (hit, &tmax) in self.hits[LANES * g..][..LANES].iter_mut().zip(tmax) {
            *hit = Hit::none(tmax);
        }
    }

    /// Those of packets whose directions `differ` much or do not.
    #[inline(always)]
    pub(super) fn habits<const ANY: bool>(&mut self, differ: bool) -> &mut Habits {
        &mut self.habits[usize::from(ANY)][usize::from(differ)]
    }
}

/// Numbers of the groups that have a ray in `mask`.
#[inline(always)]
pub(super) fn groups(mask: u64) -> impl Iterator<Item = usize> {
    let mut rest = groups_of(mask);
    std::iter::from_fn(move || {
        if rest == 0 {
            return None;
        }
        let g = rest.trailing_zeros() as usize / LANES % GROUPS;
        rest &= rest - 1;
        Some(g)
    })
}

/// Row `g` of each axis.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn load3<I: Isa>(rows: &[Rows; 3], g: usize) -> [I::F8; 3] {
    // SAFETY: the caller's promise.
    unsafe { [I::F8::load(&rows[0][g]), I::F8::load(&rows[1][g]), I::F8::load(&rows[2][g])] }
}

/// Three numbers in all lanes.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn splat3<I: Isa>(v: [f32; 3]) -> [I::F8; 3] {
    // SAFETY: the caller's promise.
    unsafe { [I::F8::splat(v[0]), I::F8::splat(v[1]), I::F8::splat(v[2])] }
}

/// Up to eight rays, the last one repeated: eight vectors of one number of each.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn transposed<I: Isa>(rays: &[Ray]) -> [I::F8; 8] {
    // SAFETY: the caller's promise.
    unsafe { transposed_by::<I>(rays.len(), |l| &rays[l]) }
}

/// [`transposed`], of the rays that `ray` names.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn transposed_by<'a, I: Isa>(count: usize, ray: impl Fn(usize) -> &'a Ray) -> [I::F8; 8] {
    // SAFETY: the caller's promise.
    unsafe {
        let mut rows = [I::F8::splat(0.0); LANES];
        for (l, row) in rows.iter_mut().enumerate() {
            *row = I::F8::load(&ray(l.min(count - 1)).numbers());
        }
        I::F8::transpose(rows)
    }
}

/// The directions of usual length (see [`super::tracer`]). What is told of a NaN means nothing: such a ray hits nothing either way.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
unsafe fn is_usual<I: Isa>([x, y, z]: [I::F8; 3]) -> u32 {
    // SAFETY: the caller's promise.
    unsafe {
        let longest = x.abs().max(y.abs().max(z.abs()));
        I::F8::splat(*USUAL_LENGTH.start()).le(longest) & longest.le(I::F8::splat(*USUAL_LENGTH.end()))
    }
}

/// A bit per group that has a ray in `mask`: bit 0 of each byte.
#[inline(always)]
pub(super) fn groups_of(mask: u64) -> u64 {
    const LOW: u64 = 0x7f7f_7f7f_7f7f_7f7f;
    ((((mask & LOW) + LOW) | mask) & !LOW) >> 7
}

impl Packet {
    pub(super) fn new() -> Self {
        let rows = [[0.0; LANES]; GROUPS];
        Self {
            org: [rows; 3],
            dir: [rows; 3],
            inv_dir: [rows; 3],
            shear: [rows; 3],
            tmin: rows,
            negative: [0; 3],
            dominant: [0; 3],
            longest: [[0; LANES]; GROUPS],
            usable: 0,
        }
    }

    /// Takes in `rays[which[0]], rays[which[1]], …`, at most 64 and at least one. Lanes beyond, up to the end of a group, repeat the
    /// last one. Returns those whose direction is too long or too short, as [`Packet::take_in`].
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn gather<I: Isa, const ANY: bool>(
        &mut self,
        found: &mut Found,
        rays: &[Ray],
        which: &[u16],
    ) -> u64 {
        let count = which.len();
        assert!((1..=RAYS).contains(&count), "a packet has 1 to 64 rays");
        for (g, run) in which.chunks(LANES).enumerate() {
            // SAFETY: the caller's promise.
            unsafe {
                let rows = transposed_by::<I>(run.len(), |l| &rays[usize::from(run[l])]);
                self.store::<I, ANY>(found, g, rows);
            }
        }
        // SAFETY: the caller's promise.
        unsafe { self.begin_usual::<I>(found, u64::MAX >> (RAYS - count)) }
    }

    /// Takes in `rays`, at most 64 and at least one. Returns whether their directions are of usual length (see [`super::tracer`]) and have the
    /// same signs.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn gather_alike<I: Isa, const ANY: bool>(&mut self, found: &mut Found, rays: &[Ray]) -> bool {
        let count = rays.len();
        assert!((1..=RAYS).contains(&count), "a packet has 1 to 64 rays");
        let mask = u64::MAX >> (RAYS - count);
        // SAFETY: the caller's promise.
        unsafe {
            for (g, run) in rays.chunks(LANES).enumerate() {
                self.store::<I, ANY>(found, g, transposed::<I>(run));
            }
            self.begin::<I>(found, mask);
            self.usual::<I>(mask) == mask && self.negative.iter().all(|n| n & mask == 0 || n & mask == mask)
        }
    }

    /// Eight rays, as their eight numbers, become the lanes of group `g`.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn store<I: Isa, const ANY: bool>(&mut self, found: &mut Found, g: usize, rows: [I::F8; 8]) {
        let [ox, oy, oz, tmin, dx, dy, dz, tmax] = rows;
        // SAFETY: the caller's promise.
        unsafe {
            for (k, (org, dir)) in [(ox, dx), (oy, dy), (oz, dz)].into_iter().enumerate() {
                org.store(&mut self.org[k][g]);
                dir.store(&mut self.dir[k][g]);
            }
            // NaN gives 0, the second operand.
            tmin.max(I::F8::splat(0.0)).store(&mut self.tmin[g]);
            tmax.store(&mut found.t[g]);
        }
        if !ANY {
            let tmax = found.t[g];
            found.clear_hits(g, &tmax);
        }
    }

    /// The rays of `mask` whose directions are of usual length.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn usual<I: Isa>(&self, mask: u64) -> u64 {
        let mut usual = 0;
        for g in groups(mask) {
            // SAFETY: the caller's promise.
            usual |= unsafe { u64::from(is_usual::<I>(load3::<I>(&self.dir, g))) } << (LANES * g);
        }
        usual & mask
    }

    /// Takes in the rays of `mask`, of which there is at least one. Returns those whose direction is too long or too short to be traced
    /// as it is (see [`super::tracer`]); they are left out.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn take_in<I: Isa, const ANY: bool>(
        &mut self,
        found: &mut Found,
        rays: &RayPacket,
        mask: u64,
    ) -> u64 {
        // SAFETY: the caller's promise.
        unsafe {
            for g in groups(mask) {
                for k in 0..3 {
                    self.org[k][g] = rays.org[k][g];
                    self.dir[k][g] = rays.dir[k][g];
                }
                self.tmin[g] = [0.0; LANES];
                // Of lanes without a ray, so that they do not hold up the farthest distance of all.
                let tmax = I::F8::load(&rays.tmax[g]).select_bits(I::F8::splat(0.0), (mask >> (LANES * g)) as u32);
                tmax.store(&mut found.t[g]);
                if !ANY {
                    // Those of lanes without a ray mean nothing.
                    found.clear_hits(g, &rays.tmax[g]);
                }
            }
            self.begin_usual::<I>(found, mask)
        }
    }

    /// [`Packet::begin`] with those rays of `mask` whose directions are of usual length. Returns the others.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn begin_usual<I: Isa>(&mut self, found: &mut Found, mask: u64) -> u64 {
        // SAFETY: the caller's promise.
        unsafe {
            let usual = self.usual::<I>(mask);
            self.begin::<I>(found, usual);
            mask & !usual
        }
    }

    /// The rays of `mask` are taken in: those with an interval that is not empty begin to search. For triangle tests they are to be
    /// [prepared](Packet::prepare_triangles) yet.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn begin<I: Isa>(&mut self, found: &mut Found, mask: u64) {
        // SAFETY: the caller's promise.
        unsafe {
            self.prepare_boxes::<I>(mask);
            let mut interval = 0;
            for g in groups(mask) {
                let holds = I::F8::load(&self.tmin[g]).le(I::F8::load(&found.t[g]));
                interval |= u64::from(holds) << (LANES * g);
            }
            self.usable &= interval;
        }
        found.open = self.usable;
    }

    /// Makes this the packet of `rays`' space seen from an instance, for the groups that have a ray in `mask`. For triangle tests they are to be
    /// [prepared](Packet::prepare_triangles) yet.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn transform<I: Isa>(&mut self, object_from_world: &Affine3A, rays: &Packet, mask: u64) {
        let m = &object_from_world.matrix3;
        let columns = [m.x_axis.to_array(), m.y_axis.to_array(), m.z_axis.to_array()];
        let translation = object_from_world.translation.to_array();
        // SAFETY: the caller's promise.
        unsafe {
            for g in groups(mask) {
                let (org, dir) = (load3::<I>(&rays.org, g), load3::<I>(&rays.dir, g));
                for k in 0..3 {
                    let [x, y, z] = splat3::<I>([columns[0][k], columns[1][k], columns[2][k]]);
                    let origin = x.mul(org[0]).add(y.mul(org[1])).add(z.mul(org[2]));
                    origin.add(I::F8::splat(translation[k])).store(&mut self.org[k][g]);
                    x.mul(dir[0]).add(y.mul(dir[1])).add(z.mul(dir[2])).store(&mut self.dir[k][g]);
                }
                self.tmin[g] = rays.tmin[g];
            }
            self.prepare_boxes::<I>(mask);
        }
    }

    /// What box tests need that follows from origins and directions, and which rays can hit anything.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn prepare_boxes<I: Isa>(&mut self, mask: u64) {
        let (mut negative, mut usable) = ([0u64; 3], 0u64);
        // SAFETY: the caller's promise.
        unsafe {
            let (one, zero, most) = (I::F8::splat(1.0), I::F8::splat(0.0), I::F8::splat(f32::MAX));
            let range = I::F8::splat(MAX_COORDINATE);
            for g in groups(mask) {
                let dir = load3::<I>(&self.dir, g);
                let at = LANES * g;
                for k in 0..3 {
                    let inv = one.div(dir[k]).max(zero.sub(most)).min(most);
                    inv.store(&mut self.inv_dir[k][g]);
                    negative[k] |= u64::from(inv.lt(zero)) << at;
                }
                let (ax, ay, az) = (dir[0].abs(), dir[1].abs(), dir[2].abs());
                // Of a NaN the sum is one.
                let longest = ax.max(ay.max(az));
                let mut good = I::F8::splat(MIN_DIRECTION).le(longest) & ax.add(ay).add(az).le(most);
                for k in 0..3 {
                    good &= I::F8::load(&self.org[k][g]).abs().le(range);
                }
                usable |= u64::from(good) << at;
            }
        }
        (self.negative, self.usable) = (negative, usable & mask);
    }

    /// What only triangle tests need of the rays in `mask`: to be asked for once it is known that they come to some.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn prepare_triangles<I: Isa>(&mut self, mask: u64) {
        let mut dominant = [0u64; 3];
        // SAFETY: the caller's promise.
        unsafe {
            for g in groups(mask) {
                let [x, y, z] = load3::<I>(&self.dir, g);
                let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
                // The first of the largest, as in `PreparedRay::new`: x if it is not below the others, then y.
                let others = ay.max(az);
                let is_x = others.le(ax);
                let is_y = az.le(ay) & !is_x;
                let is_z = !(is_x | is_y) & 0xff;
                let at = LANES * g;
                dominant[0] |= u64::from(is_x) << at;
                dominant[1] |= u64::from(is_y) << at;
                dominant[2] |= u64::from(is_z) << at;
                self.longest[g] = (spread(is_y) | spread(is_z) << 1).to_le_bytes();
                let depth = others.select_le(ax, x, az.select_le(ay, y, z));
                let first = others.select_le(ax, y, az.select_le(ay, z, x));
                let second = others.select_le(ax, z, az.select_le(ay, x, y));
                first.div(depth).store(&mut self.shear[0][g]);
                second.div(depth).store(&mut self.shear[1][g]);
                I::F8::splat(1.0).div(depth).store(&mut self.shear[2][g]);
            }
        }
        self.dominant = dominant;
    }

    /// Ray `r` alone. `tmax` may be its best distance so far instead of its own end.
    #[inline]
    pub(super) fn ray(&self, r: usize, tmax: f32) -> PreparedRay {
        let (g, l) = (r / LANES % GROUPS, r % LANES);
        let vec = |rows: &[Rows; 3]| Vec3::new(rows[0][g][l], rows[1][g][l], rows[2][g][l]);
        let z = self.axis(r);
        PreparedRay {
            from: 0,
            org: vec(&self.org),
            dir: vec(&self.dir),
            inv_dir: vec(&self.inv_dir),
            tmin: self.tmin[g][l],
            tmax,
            axis: [(z + 1) % 3, (z + 2) % 3, z],
            shear: vec(&self.shear),
        }
    }

    /// The axis on which ray `r` is longest.
    #[inline(always)]
    pub(super) fn axis(&self, r: usize) -> usize {
        usize::from(self.longest.as_flattened()[r % RAYS])
    }
}

/// Bit `i` of the lowest byte to bit `8 i`.
#[inline(always)]
pub(super) fn spread(byte: u32) -> u64 {
    let byte = u64::from(byte);
    (((byte & 0x7f) * 0x0002_0408_1020_4081) | ((byte & 0x80) << 49)) & 0x0101_0101_0101_0101
}
