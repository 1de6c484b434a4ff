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
use crate::simd::{Eight, Isa, Vector, bits};
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
    /// The rays that can hit anything (see [`PreparedRay::new`]).
    pub usable: u64,
}

/// What the rays of a packet have found, in all spaces alike, and what is kept from packet to packet.
#[derive(Clone)]
#[repr(C, align(64))]
pub(super) struct Found {
    /// Distance of the best hit, at first the ray's `tmax`.
    pub t: Rows,
    /// The best hits; kept only when the closest hit is looked for.
    pub hits: [Hit; RAYS],
    /// The rays that are still searching. A ray looking for any hit leaves when it has one.
    pub open: u64,
    /// Of packets whose directions are much alike, and of others.
    pub habits: [Habits; 2],
}

impl Found {
    pub(super) fn new() -> Self {
        Self { t: [[0.0; LANES]; GROUPS], hits: [Hit::none(0.0); RAYS], open: 0, habits: [Habits::NONE; 2] }
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
            usable: 0,
        }
    }

    /// Takes in `rays[which[0]], rays[which[1]], …`, at most 64 and at least one. Lanes beyond, up to the end of a group, repeat the
    /// last one.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn gather<I: Isa>(&mut self, found: &mut Found, rays: &[Ray], which: &[u16]) {
        let count = which.len();
        assert!((1..=RAYS).contains(&count), "a packet has 1 to 64 rays");
        let last = which[count - 1];
        for (g, run) in which.chunks(LANES).enumerate() {
            let ray = |l: usize| &rays[usize::from(*run.get(l).unwrap_or(&last))];
            // SAFETY: the caller's promise.
            unsafe { self.turn::<I>(found, g, [ray(0), ray(1), ray(2), ray(3), ray(4), ray(5), ray(6), ray(7)]) };
        }
        // SAFETY: the caller's promise.
        unsafe { self.begin::<I>(found, u64::MAX >> (RAYS - count)) };
    }

    /// Takes in `rays`, at most 64 and at least one, and returns true if their directions are of usual length (see [`super::tracer`]) and have the same signs.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn gather_alike<I: Isa>(&mut self, found: &mut Found, rays: &[Ray]) -> bool {
        let count = rays.len();
        assert!((1..=RAYS).contains(&count), "a packet has 1 to 64 rays");
        let last = &rays[count - 1];
        for (g, run) in rays.chunks(LANES).enumerate() {
            let ray = |l: usize| run.get(l).unwrap_or(last);
            // SAFETY: the caller's promise.
            unsafe { self.turn::<I>(found, g, [ray(0), ray(1), ray(2), ray(3), ray(4), ray(5), ray(6), ray(7)]) };
        }
        let mask = u64::MAX >> (RAYS - count);
        // SAFETY: the caller's promise.
        unsafe {
            self.begin::<I>(found, mask);
            self.usual::<I>(mask) == mask && self.negative.iter().all(|n| n & mask == 0 || n & mask == mask)
        }
    }

    /// Eight rays become the lanes of group `g`.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn turn<I: Isa>(&mut self, found: &mut Found, g: usize, rays: [&Ray; LANES]) {
        // SAFETY: the caller's promise.
        unsafe {
            let mut rows = [I::F8::splat(0.0); LANES];
            for (row, ray) in rows.iter_mut().zip(rays) {
                *row = I::F8::load(&ray.numbers());
            }
            let [ox, oy, oz, tmin, dx, dy, dz, tmax] = I::F8::transpose(rows);
            for (k, (org, dir)) in [(ox, dx), (oy, dy), (oz, dz)].into_iter().enumerate() {
                org.store(&mut self.org[k][g]);
                dir.store(&mut self.dir[k][g]);
            }
            // NaN gives 0, the second operand.
            tmin.max(I::F8::splat(0.0)).store(&mut self.tmin[g]);
            tmax.store(&mut found.t[g]);
        }
        for (hit, &tmax) in found.hits[LANES * g..][..LANES].iter_mut().zip(&found.t[g]) {
            *hit = Hit::none(tmax);
        }
    }

    /// The rays of `mask` whose directions are of usual length.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn usual<I: Isa>(&self, mask: u64) -> u64 {
        let mut usual = 0;
        // SAFETY: the caller's promise.
        unsafe {
            let (least, most) = (I::F8::splat(*USUAL_LENGTH.start()), I::F8::splat(*USUAL_LENGTH.end()));
            for g in groups(mask) {
                let [x, y, z] = load3::<I>(&self.dir, g);
                let longest = x.abs().max(y.abs().max(z.abs()));
                usual |= u64::from(least.le(longest) & longest.le(most)) << (LANES * g);
            }
        }
        usual & mask
    }

    /// Takes in the rays of `mask`, of which there is at least one. Returns those whose direction is too long or too short to be traced
    /// as it is (see [`super::tracer`]); they are left out.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    pub(super) unsafe fn take_in<I: Isa>(&mut self, found: &mut Found, rays: &RayPacket, mask: u64) -> u64 {
        // SAFETY: the caller's promise.
        let usual = unsafe {
            for g in groups(mask) {
                for k in 0..3 {
                    self.org[k][g] = rays.org[k][g];
                    self.dir[k][g] = rays.dir[k][g];
                }
                self.tmin[g] = [0.0; LANES];
                // Of lanes without a ray, so that they do not hold up the farthest distance of all.
                let tmax = I::F8::load(&rays.tmax[g]).select_bits(I::F8::splat(0.0), (mask >> (LANES * g)) as u32);
                tmax.store(&mut found.t[g]);
            }
            let usual = self.usual::<I>(mask);
            self.begin::<I>(found, usual);
            usual
        };
        for r in bits(mask) {
            found.hits[r] = Hit::none(rays.tmax[r / LANES][r % LANES]);
        }
        mask & !usual
    }

    /// The rays of `mask` are taken in: those with an interval that is not empty begin to search.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn begin<I: Isa>(&mut self, found: &mut Found, mask: u64) {
        // SAFETY: the caller's promise.
        unsafe {
            self.prepare::<I>(mask);
            let mut interval = 0;
            for g in groups(mask) {
                let holds = I::F8::load(&self.tmin[g]).le(I::F8::load(&found.t[g]));
                interval |= u64::from(holds) << (LANES * g);
            }
            self.usable &= interval;
        }
        found.open = self.usable;
    }

    /// Makes this the packet of `rays`' space seen from an instance, for the groups that have a ray in `mask`.
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
            self.prepare::<I>(mask);
        }
    }

    /// Everything that follows from origins, directions and `tmin`.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn prepare<I: Isa>(&mut self, mask: u64) {
        let (mut negative, mut dominant, mut usable) = ([0u64; 3], [0u64; 3], 0u64);
        // SAFETY: the caller's promise.
        unsafe {
            let (one, zero, most) = (I::F8::splat(1.0), I::F8::splat(0.0), I::F8::splat(f32::MAX));
            let range = I::F8::splat(MAX_COORDINATE);
            for g in groups(mask) {
                let [x, y, z] = load3::<I>(&self.dir, g);
                let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
                let at = LANES * g;
                // The first of the largest, as in `PreparedRay::new`: x if it is not below the others, then y.
                let others = ay.max(az);
                let is_x = others.le(ax);
                let is_y = az.le(ay) & !is_x;
                dominant[0] |= u64::from(is_x) << at;
                dominant[1] |= u64::from(is_y) << at;
                dominant[2] |= u64::from(!(is_x | is_y) & 0xff) << at;
                let depth = others.select_le(ax, x, az.select_le(ay, y, z));
                let first = others.select_le(ax, y, az.select_le(ay, z, x));
                let second = others.select_le(ax, z, az.select_le(ay, x, y));
                first.div(depth).store(&mut self.shear[0][g]);
                second.div(depth).store(&mut self.shear[1][g]);
                one.div(depth).store(&mut self.shear[2][g]);
                let dir = [x, y, z];
                for k in 0..3 {
                    let inv = one.div(dir[k]).max(zero.sub(most)).min(most);
                    inv.store(&mut self.inv_dir[k][g]);
                    negative[k] |= u64::from(inv.lt(zero)) << at;
                }
                let mut good = I::F8::splat(MIN_DIRECTION).le(depth.abs()) & ax.add(ay).add(az).le(most);
                for k in 0..3 {
                    good &= I::F8::load(&self.org[k][g]).abs().le(range);
                }
                usable |= u64::from(good) << at;
            }
        }
        (self.negative, self.dominant, self.usable) = (negative, dominant, usable & mask);
    }

    /// Ray `r` alone. `tmax` may be its best distance so far instead of its own end.
    #[inline]
    pub(super) fn ray(&self, r: usize, tmax: f32) -> PreparedRay {
        let (g, l) = (r / LANES % GROUPS, r % LANES);
        let vec = |rows: &[Rows; 3]| Vec3::new(rows[0][g][l], rows[1][g][l], rows[2][g][l]);
        let z = self.axis(r);
        PreparedRay {
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
        ((self.dominant[1] >> r & 1) + 2 * (self.dominant[2] >> r & 1)) as usize
    }
}
