//! Polygons as triangles.
//!
//! Convex ones are fans; others are cut ear by ear (Meisters, "Polygons Have Ears", 1975). An ear is looked for behind
//! the one cut last and tested against reflex corners only, so the cost is the number of corners times that of
//! reflex ones. Every corner stays a corner of a triangle, also one on a straight edge: neighbours may share it.

use glam::{DVec2, DVec3, Vec3};

/// Most corners of a concave polygon that is cut, and most corners times reflex corners.
const MOST_CORNERS: usize = 1 << 16;
const MOST_TESTS: usize = 200_000_000;

/// Newell's normal: right for concave and for slightly bent polygons, as long as twice the area.
pub fn newell(corners: &[Vec3]) -> DVec3 {
    let Some(first) = corners.first().map(|c| c.as_dvec3()) else { return DVec3::ZERO };
    let edge = |i: usize| corners[i % corners.len()].as_dvec3() - first;
    (1..corners.len()).map(|i| edge(i).cross(edge(i + 1))).sum()
}

/// Triangles of a flat simple polygon, as corner numbers: always n − 2 of them. `None` when it is concave and has too many
/// corners to be cut.
pub fn triangulate(corners: &[Vec3]) -> Option<Vec<[u32; 3]>> {
    let n = corners.len() as u32;
    if n < 3 {
        return Some(Vec::new());
    }
    let Some(plane) = Plane::of(corners) else { return Some(fan(n)) };
    let at = |i: usize| plane.flat(corners[i % corners.len()]);
    let reflex = (0..corners.len()).filter(|&i| turn(at(i), at(i + 1), at(i + 2)) < 0.0).count();
    if reflex == 0 {
        return Some(fan(n));
    }
    if corners.len() > MOST_CORNERS || reflex * corners.len() > MOST_TESTS {
        return None;
    }
    let flat: Vec<DVec2> = (0..corners.len()).map(at).collect();
    Some(Ring::new(&flat).cut())
}

/// All triangles from the first corner.
pub fn fan(n: u32) -> Vec<[u32; 3]> {
    (1..n.saturating_sub(1)).map(|i| [0, i, i + 1]).collect()
}

/// The plane of a polygon, seen so that it turns anticlockwise.
struct Plane {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
}

impl Plane {
    /// `None` without an area.
    fn of(corners: &[Vec3]) -> Option<Self> {
        let normal = newell(corners);
        // Corners of 1e-20 are a polygon, too: f64 holds their area, but not its square.
        let normal = (normal / normal.abs().max_element()).try_normalize()?;
        let (x, y) = normal.any_orthonormal_pair();
        Some(Self { origin: corners[0].as_dvec3(), x, y })
    }

    fn flat(&self, corner: Vec3) -> DVec2 {
        let seen = corner.as_dvec3() - self.origin;
        DVec2::new(seen.dot(self.x), seen.dot(self.y))
    }
}

/// Twice the area of a triangle, positive when it is anticlockwise.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - b)
}

/// What is left of a polygon.
struct Ring<'a> {
    points: &'a [DVec2],
    next: Vec<u32>,
    before: Vec<u32>,
    /// The polygon turns the other way here, or not at all.
    reflex: Vec<bool>,
}

impl<'a> Ring<'a> {
    fn new(points: &'a [DVec2]) -> Self {
        let n = points.len() as u32;
        let mut ring = Self {
            points,
            next: (0..n).map(|i| (i + 1) % n).collect(),
            before: (0..n).map(|i| (i + n - 1) % n).collect(),
            reflex: vec![false; points.len()],
        };
        for i in 0..n {
            ring.reflex[i as usize] = ring.turn_at(i) < 0.0;
        }
        ring
    }

    fn corners(&self, i: u32) -> [u32; 3] {
        [self.before[i as usize], i, self.next[i as usize]]
    }

    fn turn_at(&self, i: u32) -> f64 {
        let [a, b, c] = self.corners(i).map(|i| self.points[i as usize]);
        turn(a, b, c)
    }

    /// A triangle that can be cut off: a convex corner with no other corner inside.
    fn is_ear(&self, i: u32, reflex: &[u32]) -> bool {
        let [a, b, c] = self.corners(i).map(|i| self.points[i as usize]);
        if turn(a, b, c) <= 0.0 {
            return false;
        }
        // A corner that lies on one of the three is where a polygon with a hole returns along its seam.
        reflex
            .iter()
            .map(|&p| self.points[p as usize])
            .filter(|&p| p != a && p != b && p != c)
            .all(|p| turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0)
    }

    fn cut(&mut self) -> Vec<[u32; 3]> {
        let n = self.points.len();
        let mut triangles = Vec::with_capacity(n - 2);
        let mut reflex: Vec<u32> = (0..n as u32).filter(|&i| self.reflex[i as usize]).collect();
        let mut i = 0;
        // Corners looked at since the last ear.
        let mut looked = 0;
        while triangles.len() < n - 3 {
            let left = n - triangles.len();
            let straight = self.turn_at(i) == 0.0;
            // A polygon that crosses itself may have no ear, and one whose corners lie on a line has none: cutting any
            // corner keeps the count right.
            let any = looked >= if straight { left } else { 2 * left };
            if !self.is_ear(i, &reflex) && !any {
                looked += 1;
                i = self.next[i as usize];
                continue;
            }
            let [a, _, c] = self.corners(i);
            triangles.push([a, i, c]);
            self.next[a as usize] = c;
            self.before[c as usize] = a;
            for corner in [a, c] {
                self.reflex[corner as usize] = self.turn_at(corner) < 0.0;
            }
            self.reflex[i as usize] = false;
            reflex.retain(|&r| self.reflex[r as usize]);
            looked = 0;
            // The corner after the next one: cutting in turns gives rounder triangles than a fan from one corner.
            i = self.next[c as usize];
        }
        triangles.push(self.corners(i));
        triangles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
        triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| corners[i as usize].as_dvec3());
                (b - a).cross(c - a).length() / 2.0
            })
            .sum()
    }

    /// Every start corner, both directions, several sizes: the areas of the triangles add up to that of the polygon.
    fn check(flat: &[(f32, f32)], size: f32) {
        let mut corners: Vec<Vec3> = flat.iter().map(|&(x, y)| Vec3::new(x, 3.0, y + 0.25 * x) * size).collect();
        let whole = newell(&corners).length() / 2.0;
        for _ in 0..2 {
            for _ in 0..corners.len() {
                corners.rotate_left(1);
                let triangles = triangulate(&corners).unwrap();
                assert_eq!(triangles.len(), corners.len() - 2);
                let sum = area(&corners, &triangles);
                assert!((sum - whole).abs() <= 1e-5 * whole, "{flat:?} × {size}: {sum} of {whole}");
                let mut used: Vec<u32> = triangles.into_iter().flatten().collect();
                used.sort_unstable();
                used.dedup();
                assert_eq!(used.len(), corners.len(), "every corner is a corner of a triangle");
            }
            corners.reverse();
        }
    }

    #[test]
    fn polygons_keep_their_area() {
        let l = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
        let star: Vec<(f32, f32)> = (0..20)
            .map(|i| {
                let r = if i % 2 == 0 { 1.0 } else { 0.3 };
                let a = std::f32::consts::TAU * i as f32 / 20.0;
                (r * a.cos(), r * a.sin())
            })
            .collect();
        // A square with a square hole, entered and left along one seam.
        let hole = [
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 4.0),
            (0.0, 4.0),
            (0.0, 0.0),
            (1.0, 1.0),
            (1.0, 2.0),
            (2.0, 2.0),
            (2.0, 1.0),
            (1.0, 1.0),
        ];
        // Corners on straight edges.
        let straight = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 1.0), (0.0, 2.0), (0.0, 1.0)];
        for size in [1.0, 1e-12, 1e12] {
            check(&l, size);
            check(&star, size);
            check(&hole, size);
            check(&straight, size);
        }
    }

    #[test]
    fn degenerate_polygons_keep_their_count() {
        assert_eq!(triangulate(&[Vec3::ZERO; 5]).unwrap().len(), 3);
        assert!(triangulate(&[Vec3::ZERO; 2]).unwrap().is_empty());
        let line: Vec<Vec3> = (0..9).map(|i| Vec3::X * (i % 5) as f32).collect();
        assert_eq!(triangulate(&line).unwrap().len(), 7);
        // A bow tie.
        let tie = [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::X, Vec3::Y, Vec3::new(0.5, 3.0, 0.0)];
        assert_eq!(triangulate(&tie).unwrap().len(), 3);
    }

    #[test]
    fn large_polygons_take_reasonable_time() {
        let comb: Vec<Vec3> = (0..8000)
            .map(|i| Vec3::new(i as f32, if i % 2 == 0 { 0.0 } else { 50.0 }, 0.0))
            .chain([Vec3::new(8000.0, -10.0, 0.0), Vec3::new(-1.0, -10.0, 0.0)])
            .collect();
        let triangles = triangulate(&comb).unwrap();
        let whole = newell(&comb).length() / 2.0;
        assert!((area(&comb, &triangles) - whole).abs() < 1e-4 * whole);
        let huge: Vec<Vec3> = comb.iter().cycle().take(10 * comb.len()).copied().collect();
        assert!(triangulate(&huge).is_none());
    }
}
