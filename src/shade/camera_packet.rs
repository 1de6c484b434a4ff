//! Camera rays of 8×8 pixels, eight at a time.
//!
//! A packet is a square of pixels, in an order in which each row of eight lanes is a block of 4×2 and two rows are one of 4×4: whatever is
//! done by rows stays in a compact part of the picture. Pinhole and orthographic cameras go in lanes, by the operations of
//! [`Camera::primary_ray`]; others are asked pixel by pixel.

use crate::shade::camera::{Camera, Kind, Window};
use crate::shade::rows::{GROUPS, SLOTS, lanes_of, row3_mut};
use crate::shade::sampler::Rng;
use crate::simd::{Isa, LANES, Level, Proof, Wide, Wide3, WideKernel, bits, run_wide};
use crate::trace::{Ray, RayPacket};
use glam::Vec2;

/// Pixels along each side of a packet.
pub const PACKET_SIZE: u32 = 8;

/// Column and row of a sample in its packet.
#[inline]
pub const fn place(slot: usize) -> [u32; 2] {
    let (block, half, pixel) = (slot as u32 >> 4 & 3, slot as u32 >> 3 & 1, slot as u32 & 7);
    [(block & 1) * 4 + (pixel & 3), (block >> 1) * 4 + half * 2 + (pixel >> 2)]
}

/// Of each sample its column, and its row.
const PLACES: [[f32; SLOTS]; 2] = {
    let mut places = [[0.0; SLOTS]; 2];
    let mut slot = 0;
    while slot < SLOTS {
        let [x, y] = place(slot);
        places[0][slot] = x as f32;
        places[1][slot] = y as f32;
        slot += 1;
    }
    places
};

/// One camera sample in each of 8×8 pixels, which are neighbours or the nodes of a lattice.
pub struct CameraPacket {
    pub rays: RayPacket,
    /// The samples that have a ray; the camera leaves the others clear, or nobody has asked for them.
    pub mask: u64,
    /// Column and row of the lower left pixel.
    pixel: [u32; 2],
    step: u32,
    last: [u32; 2],
    /// Of the sample, among all that the pixel has ever had.
    number: u32,
}

/// Which samples a packet shall have.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Column and row of the lower left pixel in the picture, and in the viewport.
    pub pixel: [u32; 2],
    pub corner: Vec2,
    /// Pixels from one sample to the next. Those that would lie beyond column or row `last` of the picture, which is the
    /// viewport's last, lie on it.
    pub step: u32,
    pub last: [u32; 2],
    /// The samples: bit `s` is that at [`place`] `s`.
    pub mask: u64,
    /// Of the sample, among all that a pixel has ever had, and where it is inside of its pixel.
    pub number: u32,
    pub offset: Vec2,
}

impl CameraPacket {
    pub fn new() -> Self {
        Self { rays: RayPacket::new(), mask: 0, pixel: [0; 2], step: 1, last: [0; 2], number: 0 }
    }

    /// Makes this the camera rays through `wanted`, in a viewport of `size` pixels.
    pub fn aim(&mut self, camera: &Camera, level: Level, wanted: &Wanted, size: Vec2, aspect: f32) {
        (self.pixel, self.number) = (wanted.pixel, wanted.number);
        (self.step, self.last) = (wanted.step, wanted.last);
        if matches!(camera.kind, Kind::Pinhole(_) | Kind::Orthographic(_)) {
            run_wide(level, Aim { packet: self, camera, wanted, size, aspect });
            return;
        }
        self.mask = 0;
        let has_lens = camera.has_lens();
        for slot in bits(wanted.mask) {
            let place = Vec2::new(PLACES[0][slot], PLACES[1][slot]);
            let pixel = (wanted.corner + place * wanted.step as f32).min(size - 1.0);
            let screen = (pixel + wanted.offset) / size;
            let lens = if has_lens { self.lens(slot) } else { Vec2::ZERO };
            if let Some(ray) = camera.primary_ray(screen, aspect, lens) {
                self.rays.set(slot, &Ray::new(ray.origin, ray.direction));
                self.mask |= 1 << slot;
            }
        }
    }

    /// Random numbers for the lens.
    fn lens(&self, slot: usize) -> Vec2 {
        self.all_random(slot).next_vec2()
    }

    /// Random numbers for all choices after that of the point of the lens.
    pub(super) fn rng(&self, slot: usize) -> Rng {
        let mut rng = self.all_random(slot);
        rng.next_vec2();
        rng
    }

    fn all_random(&self, slot: usize) -> Rng {
        let place = place(slot);
        let [x, y] = [0, 1].map(|k| (self.pixel[k] + place[k] * self.step).min(self.last[k]));
        Rng::new(x, y, self.number)
    }
}

impl Default for CameraPacket {
    fn default() -> Self {
        Self::new()
    }
}

struct Aim<'a> {
    packet: &'a mut CameraPacket,
    camera: &'a Camera,
    wanted: &'a Wanted,
    size: Vec2,
    aspect: f32,
}

impl WideKernel for Aim<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: Proof<I>) {
        let Self { packet, camera, wanted, size, aspect } = self;
        let (right, up, forward) = (isa.splat3(camera.right), isa.splat3(camera.up), isa.splat3(camera.forward));
        let aspect = if camera.aspect > 0.0 { camera.aspect } else { aspect };
        let eye = isa.splat3(camera.eye);
        packet.mask = 0;
        for g in 0..GROUPS {
            let lanes = lanes_of(wanted.mask, g);
            if lanes == 0 {
                continue;
            }
            let screen = [screen(isa, wanted, size, 0, g), screen(isa, wanted, size, 1, g)];
            let (origin, (direction, mut good)) = match &camera.kind {
                Kind::Pinhole(window) => {
                    let [x, y] = window_at(isa, window, screen, aspect);
                    (eye, (right * x + up * y + forward).try_normalize(isa))
                }
                Kind::Orthographic(window) => {
                    let [x, y] = window_at(isa, window, screen, aspect);
                    let aside = right * x + up * y + forward * isa.splat(0.0);
                    (eye + aside, forward.try_normalize(isa))
                }
                _ => unreachable!("other cameras are asked pixel by pixel"),
            };
            let most = isa.splat(f32::MAX);
            let Wide3 { x, y, z } = origin.abs();
            good &= x.le(most) & y.le(most) & z.le(most);
            origin.store(row3_mut(&mut packet.rays.org, g));
            direction.store(row3_mut(&mut packet.rays.dir, g));
            packet.rays.tmax[g] = [f32::INFINITY; LANES];
            packet.mask |= u64::from(good & lanes) << (LANES * g);
        }
    }
}

/// Component `k` of where row `g` is on the picture.
#[inline(always)]
fn screen<I: Isa>(isa: Proof<I>, wanted: &Wanted, size: Vec2, k: usize, g: usize) -> Wide<I> {
    let places: &[f32; LANES] = PLACES[k][LANES * g..].first_chunk().expect("eight lanes per row");
    let pixel = isa.splat(wanted.corner[k]) + isa.load(places) * isa.splat(wanted.step as f32);
    (pixel.min(isa.splat(size[k] - 1.0)) + isa.splat(wanted.offset[k])) / isa.splat(size[k])
}

/// [`Window::at`].
#[inline(always)]
fn window_at<I: Isa>(isa: Proof<I>, window: &Window, [x, y]: [Wide<I>; 2], aspect: f32) -> [Wide<I>; 2] {
    let (one, two) = (isa.splat(1.0), isa.splat(2.0));
    match window {
        Window::HalfHeight(h) => [(two * x - one) * isa.splat(h * aspect), (two * y - one) * isa.splat(*h)],
        Window::Rect(w) => [isa.splat(w.x) + x * isa.splat(w.y - w.x), isa.splat(w.z) + y * isa.splat(w.w - w.z)],
    }
}
