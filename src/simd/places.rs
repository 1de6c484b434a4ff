//! Points of four coordinates, found by their places in a row.
//!
//! A place counts halves of a point, 8 bytes: the largest unit that an address is made of without a shift. The places of four triangles are checked
//! four at a time, so that loads need no check each.

use glam::{Mat4, Vec4};

/// Points per row of [`Places`].
const LANES: usize = 4;

/// Where the corners of four triangles are: `[corner][lane]`.
pub type Places = [[u32; LANES]; 3];

/// The place of a point.
///
/// # Panics
/// When there are too many points.
pub fn place_of(number: usize) -> u32 {
    i32::try_from(2 * number).expect("fewer than 2^30 points") as u32
}

/// The number of the point at a place.
pub fn number_at(place: u32) -> usize {
    place as usize / 2
}

/// The box around the points at `places`, least and most; `points` are those from number `first` on.
///
/// # Panics
/// When a place is not among the points.
#[inline(always)]
pub fn box_at(points: &[Vec4], first: usize, places: &Places) -> (Vec4, Vec4) {
    let of = |number: usize| (2 * number).min(i32::MAX as usize) as i32;
    assert!(are_between(places, of(first), of(first + points.len()) - 2), "a corner is among the points");
    let base = points.as_ptr().wrapping_sub(first);
    let mut lo = Vec4::INFINITY;
    let mut hi = Vec4::NEG_INFINITY;
    for row in places {
        for &place in row {
            // SAFETY: it has just been checked.
            let point = unsafe { at(base, place) };
            lo = lo.min(point);
            hi = hi.max(point);
        }
    }
    (lo, hi)
}

/// Places of eight points, counted from that of the first.
pub type FewPlaces = [u16; 8];

/// The place of a point counted from the first, if it is small enough.
pub fn few_place_of(number: usize) -> Option<u16> {
    u16::try_from(2 * number).ok()
}

/// Likewise the box around eight points.
///
/// # Panics
/// When a place is not among the points.
#[inline(always)]
pub fn box_at_few(points: &[Vec4], places: &FewPlaces) -> (Vec4, Vec4) {
    // The last place that is one. Places are even.
    let most = (2 * points.len()).min(1 << 16);
    assert!(most > 0 && are_at_most(places, (most - 2) as u16), "a corner is among the points");
    let mut lo = Vec4::INFINITY;
    let mut hi = Vec4::NEG_INFINITY;
    for &place in places {
        // SAFETY: it has just been checked.
        let point = unsafe { at(points.as_ptr(), u32::from(place)) };
        lo = lo.min(point);
        hi = hi.max(point);
    }
    (lo, hi)
}

#[inline(always)]
fn are_at_most(places: &FewPlaces, most: u16) -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{
            _mm_cmpeq_epi16, _mm_loadu_si128, _mm_movemask_epi8, _mm_set1_epi16, _mm_setzero_si128, _mm_subs_epu16,
        };
        // SAFETY: SSE2, which x86-64 always has; the load is of all eight.
        unsafe {
            let above = _mm_subs_epu16(_mm_loadu_si128(places.as_ptr().cast()), _mm_set1_epi16(most as i16));
            _mm_movemask_epi8(_mm_cmpeq_epi16(above, _mm_setzero_si128())) == 0xffff
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    places.iter().all(|&place| place <= most)
}

/// Whether all places are at least `least` and at most `most`, which are below 2^31.
#[inline(always)]
fn are_between(places: &Places, least: i32, most: i32) -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{
            _mm_castsi128_ps, _mm_cmpgt_epi32, _mm_loadu_si128, _mm_movemask_ps, _mm_or_si128, _mm_set1_epi32,
        };
        // SAFETY: SSE2, which x86-64 always has; the loads are of rows.
        unsafe {
            let [a, b, c] = places;
            let outside = |row: &[u32; LANES]| {
                // A place of 2^31 or more is negative here, so below.
                let row = _mm_loadu_si128(row.as_ptr().cast());
                let below = _mm_cmpgt_epi32(_mm_set1_epi32(least), row);
                _mm_or_si128(below, _mm_cmpgt_epi32(row, _mm_set1_epi32(most)))
            };
            let outside = _mm_or_si128(_mm_or_si128(outside(a), outside(b)), outside(c));
            _mm_movemask_ps(_mm_castsi128_ps(outside)) == 0
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    places.as_flattened().iter().all(|&place| least <= place as i32 && place as i32 <= most)
}

/// The corners of four triangles in lanes, `[corner][axis][lane]`. `points` is where number 0 is or would be.
///
/// # Safety
/// - What `places` refer to may be read.
#[inline(always)]
pub unsafe fn corners_at(points: *const Vec4, places: &Places) -> [[[f32; LANES]; 3]; 3] {
    // Written out: closures given to `array::map` would not be compiled for the caller's instruction set.
    let mut corners = [[[0.0; LANES]; 3]; 3];
    for (to, &[a, b, c, d]) in corners.iter_mut().zip(places) {
        // SAFETY: the caller's promise.
        let lanes = unsafe { Mat4::from_cols(at(points, a), at(points, b), at(points, c), at(points, d)) }.transpose();
        *to = [lanes.x_axis.to_array(), lanes.y_axis.to_array(), lanes.z_axis.to_array()];
    }
    corners
}

/// # Safety
/// - The 16 bytes at the place may be read. They need not be those of one point.
#[inline(always)]
unsafe fn at(points: *const Vec4, place: u32) -> Vec4 {
    // SAFETY: the caller's promise.
    unsafe { points.cast::<[f32; 2]>().wrapping_add(place as usize).cast::<Vec4>().read_unaligned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Vec<Vec4> {
        (0..20).map(|i| Vec4::new(i as f32, (i * 7 % 20) as f32, -((i * 3 % 20) as f32), f32::NAN)).collect()
    }

    #[test]
    fn corners_and_boxes_are_those_of_the_points() {
        let (points, first) = (points(), 100);
        let numbers = [[107, 100, 119, 103], [104, 104, 118, 111], [101, 102, 100, 117]];
        let places = numbers.map(|row| row.map(place_of));
        assert_eq!(places.map(|row| row.map(number_at)), numbers);
        let of = |number: usize| points[number - first].truncate();
        let all = numbers.as_flattened();
        let (lo, hi) = box_at(&points, first, &places);
        assert_eq!(lo.truncate(), all.iter().map(|&n| of(n)).reduce(glam::Vec3::min).expect("twelve"));
        assert_eq!(hi.truncate(), all.iter().map(|&n| of(n)).reduce(glam::Vec3::max).expect("twelve"));
        // SAFETY: all numbers are of points.
        let corners = unsafe { corners_at(points.as_ptr().wrapping_sub(first), &places) };
        for (corner, row) in numbers.iter().enumerate() {
            for (lane, &number) in row.iter().enumerate() {
                assert_eq!(corners[corner].map(|axis| axis[lane]), of(number).to_array());
            }
        }
    }

    #[test]
    fn boxes_of_eight_are_those_of_the_points_and_none_is_outside() {
        let points = points();
        let numbers = [3, 19, 0, 7, 7, 12, 19, 1];
        let mut places = numbers.map(|n| few_place_of(n).expect("small"));
        let (lo, hi) = box_at_few(&points, &places);
        let of = |&n: &usize| points[n].truncate();
        assert_eq!(lo.truncate(), numbers.iter().map(of).reduce(glam::Vec3::min).expect("eight"));
        assert_eq!(hi.truncate(), numbers.iter().map(of).reduce(glam::Vec3::max).expect("eight"));
        assert_eq!((few_place_of((1 << 15) - 1), few_place_of(1 << 15)), (Some(u16::MAX - 1), None));
        for outside in [few_place_of(20).expect("small"), u16::MAX - 1] {
            places[5] = outside;
            assert!(std::panic::catch_unwind(|| box_at_few(&points, &places)).is_err(), "{outside}");
        }
        assert!(std::panic::catch_unwind(|| box_at_few(&[], &[0; 8])).is_err());
    }

    #[test]
    fn a_place_outside_of_the_points_is_noticed() {
        let points = points();
        for (first, number) in [(0, 20), (5, 4), (5, 25)] {
            let mut places = [[place_of(first + 1); LANES]; 3];
            box_at(&points, first, &places);
            places[1][2] = place_of(number);
            assert!(std::panic::catch_unwind(|| box_at(&points, first, &places)).is_err(), "{number} of {first}..");
        }
    }
}
