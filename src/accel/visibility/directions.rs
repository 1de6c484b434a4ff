//! The directions of a visibility field, and which of them is nearest to a ray's, in constant time (Slater, *Constant Time Queries on Uniformly
//! Distributed Points on a Hemisphere*, 2002).
//!
//! A regular tetrahedron is subdivided recursively: every triangle into four, by the midpoints of its sides, moved out to the sphere. The corners are
//! the directions. A parallel subfield serves rays both ways, so of two opposite directions one is kept: 4, 7, 25, 109 and 469 are left, the
//! farthest direction 54, 36, 19, 10 and 5 degrees from one of them.
//!
//! *Look-up.* The hemisphere is unfolded onto a square (the octahedral map), whose small squares each hold the number of the direction nearest to their
//! middle: a few operations and one load for any number of directions. Near the border between two directions the answer may be the second nearest, which
//! is as right: a subfield answers rays of all directions, those near its own fastest. Where the paper looks up the closest one among directions on a
//! hemisphere, whose rim has no neighbours beyond, ours are lines, which have no rim.

use crate::memory::{OutOfMemory, collected, push, vec_of};
use glam::Vec3;
use std::sync::OnceLock;

/// Subdivisions at most.
pub const MOST_LEVELS: usize = 4;

/// Small squares per side of the unfolded hemisphere, for each level.
const SQUARES: [usize; MOST_LEVELS + 1] = [32, 32, 64, 96, 128];

/// The directions of one subdivision.
#[derive(Debug)]
pub struct Directions {
    lines: Vec<Vec3>,
    nearest: Vec<u16>,
    squares: usize,
}

/// Directions on each level.
const COUNTS: [usize; MOST_LEVELS + 1] = [4, 7, 25, 109, 469];

static LEVELS: [OnceLock<Directions>; MOST_LEVELS + 1] = [const { OnceLock::new() }; MOST_LEVELS + 1];

impl Directions {
    /// The directions after `level` subdivisions, at most [`MOST_LEVELS`]. Made once per process: the finest takes some milliseconds.
    ///
    /// # Errors
    /// No memory for them.
    pub fn of_level(level: usize) -> Result<&'static Directions, OutOfMemory> {
        let level = level.min(MOST_LEVELS);
        if let Some(known) = LEVELS[level].get() {
            return Ok(known);
        }
        let made = Directions::new(level)?;
        Ok(LEVELS[level].get_or_init(|| made))
    }

    /// How many there are on a level: those of [`Directions::of_level`].
    pub fn count_on(level: usize) -> usize {
        COUNTS[level.min(MOST_LEVELS)]
    }

    fn new(level: usize) -> Result<Self, OutOfMemory> {
        let lines = lines(level)?;
        let squares = SQUARES[level];
        let middle = |i: usize| (i as f32 + 0.5) * (2.0 / squares as f32) - 1.0;
        let nearest = (0..squares * squares).map(|square| {
            let to = folded(middle(square % squares), middle(square / squares));
            let closer =
                |best: usize, i: usize| if lines[i].dot(to).abs() > lines[best].dot(to).abs() { i } else { best };
            (1..lines.len()).fold(0, closer) as u16
        });
        let nearest = collected(nearest)?;
        Ok(Self { lines, nearest, squares })
    }

    /// How many there are.
    #[inline]
    pub fn count(&self) -> usize {
        self.lines.len()
    }

    /// Unit vectors, of each pair of opposite ones one.
    #[inline]
    pub fn lines(&self) -> &[Vec3] {
        &self.lines
    }

    /// The number of a direction (nearly) nearest to that of `dir`, or to the opposite one. Any number for a vector that is 0 or not finite.
    #[inline(always)]
    pub fn nearest(&self, dir: Vec3) -> usize {
        let up = if dir.z < 0.0 { -dir } else { dir };
        let scale = 1.0 / ((up.x.abs() + up.y.abs()) + up.z);
        let (x, y) = (up.x * scale, up.y * scale);
        let half = self.squares as f32 * 0.5;
        // A float that is not a number becomes 0.
        let square = |v: f32| (((v + 1.0) * half) as usize).min(self.squares - 1);
        usize::from(self.nearest[square(x + y) + self.squares * square(x - y)])
    }
}

/// The direction that is unfolded to this point of the square.
fn folded(u: f32, v: f32) -> Vec3 {
    let (x, y) = ((u + v) * 0.5, (u - v) * 0.5);
    Vec3::new(x, y, 1.0 - x.abs() - y.abs()).normalize()
}

/// Corners of the subdivided tetrahedron, without opposites of former ones.
fn lines(level: usize) -> Result<Vec<Vec3>, OutOfMemory> {
    let corners =
        [Vec3::new(1.0, 1.0, 1.0), Vec3::new(1.0, -1.0, -1.0), Vec3::new(-1.0, 1.0, -1.0), Vec3::new(-1.0, -1.0, 1.0)];
    let [a, b, c, d] = corners.map(Vec3::normalize);
    let mut faces = vec_of(4)?;
    faces.extend([[a, b, c], [a, c, d], [a, d, b], [b, d, c]]);
    for _ in 0..level {
        let mut finer = vec_of(4 * faces.len())?;
        finer.extend(faces.iter().flat_map(|&[a, b, c]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        }));
        faces = finer;
    }
    let mut lines: Vec<Vec3> = vec_of(COUNTS[level])?;
    for corner in faces.into_iter().flatten() {
        // Midpoints of a side shared by two faces differ by rounding at most; neighbours are much farther apart.
        if !lines.iter().any(|line| line.cross(corner).length_squared() < 1e-6) {
            push(&mut lines, corner)?;
        }
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test_meshes::Random;

    #[test]
    fn subdivision_gives_as_many_lines_as_the_sphere_has_pairs() {
        let count = |level: usize| Directions::of_level(level).expect("memory").count();
        assert_eq!([0, 1, 2, 3, 4].map(count), COUNTS);
        assert_eq!([0, 1, 2, 3, 4].map(Directions::count_on), COUNTS);
    }

    #[test]
    fn the_look_up_is_as_near_as_the_squares_are_small() {
        let mut random = Random::new(Random::seed(71));
        for (level, farthest) in [(0, 0.95), (1, 0.63), (2, 0.34), (3, 0.18), (4, 0.09)] {
            let directions = Directions::of_level(level).expect("memory");
            // A small square of the unfolded hemisphere spans at most so much.
            let slack = 6.0 / directions.squares as f32;
            let mut worst = 0.0f32;
            for i in 0..3000 {
                let dir = if i % 50 == 0 { [Vec3::X, Vec3::NEG_Y, Vec3::NEG_Z][i / 50 % 3] } else { random.vec() };
                let angle = |line: &Vec3| line.cross(dir.normalize()).length().min(1.0).asin();
                let found = angle(&directions.lines()[directions.nearest(dir * 1e-3)]);
                let best = directions.lines().iter().map(angle).fold(f32::INFINITY, f32::min);
                assert!(found <= best + slack, "level {level}: {found} instead of {best} for {dir}");
                worst = worst.max(found);
            }
            assert!(worst < farthest + slack, "level {level}: {worst} from the nearest direction");
        }
        for dir in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::splat(f32::MAX), Vec3::X * 1e-45] {
            assert!(Directions::of_level(2).expect("memory").nearest(dir) < 25);
        }
    }
}
