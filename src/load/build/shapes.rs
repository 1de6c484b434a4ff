//! Curved NFF surfaces and polygons as triangles.
//!
//! Spheres become 32 × 16 latitude–longitude patches (960 triangles), cones and cylinders 32 × 1 without end caps
//! (64 triangles), with the exact normals of the curved surface at the vertices: shading is smooth, only the silhouette shows
//! the facets. Vertices are shared, so the meshes have no cracks.

use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Edges of a full circle.
pub const SEGMENTS: u32 = 32;
const STACKS: u32 = SEGMENTS / 2;

/// Vertices (position, normal) and indices.
pub type Patch = (Vec<(Vec3, Vec3)>, Vec<[u32; 3]>);

/// Unit circle point number `i`; bit-equal for i and i + SEGMENTS.
fn circle(i: u32) -> Vec2 {
    Vec2::from_angle(TAU * (i % SEGMENTS) as f32 / SEGMENTS as f32)
}

/// A sphere; a negative radius (seen from inside only) turns the normals inwards.
pub fn sphere(center: Vec3, radius: f32) -> Patch {
    let mut vertices = Vec::new();
    let side = radius.signum();
    let size = radius.abs();
    vertices.push((center + Vec3::Y * size, Vec3::Y * side));
    for stack in 1..STACKS {
        let (sine, cosine) = (PI * stack as f32 / STACKS as f32).sin_cos();
        for i in 0..SEGMENTS {
            let c = circle(i);
            let normal = Vec3::new(c.x * sine, cosine, c.y * sine);
            vertices.push((center + normal * size, normal * side));
        }
    }
    vertices.push((center - Vec3::Y * size, Vec3::NEG_Y * side));
    let south = vertices.len() as u32 - 1;
    let at = |stack: u32, i: u32| 1 + (stack - 1) * SEGMENTS + i % SEGMENTS;
    let mut triangles = Vec::new();
    for i in 0..SEGMENTS {
        triangles.push([0, at(1, i + 1), at(1, i)]);
        for stack in 1..STACKS - 1 {
            let (a, b, c, d) = (at(stack, i), at(stack, i + 1), at(stack + 1, i + 1), at(stack + 1, i));
            triangles.push([a, b, c]);
            triangles.push([a, c, d]);
        }
        triangles.push([south, at(STACKS - 1, i), at(STACKS - 1, i + 1)]);
    }
    (vertices, flip_if(triangles, radius < 0.0))
}

/// A cone or cylinder around the axis from `base` to `apex`, without end caps; negative radii turn it inside out.
/// `None` when base and apex coincide, which gives no direction.
pub fn cone(base: Vec3, base_radius: f32, apex: Vec3, apex_radius: f32) -> Option<Patch> {
    let inside = base_radius < 0.0 || apex_radius < 0.0;
    let (r0, r1) = (base_radius.abs(), apex_radius.abs());
    let axis = (apex - base).try_normalize()?;
    let (x, z) = axis.any_orthonormal_pair();
    // The normal leans towards the thinner end.
    let slope = (r0 - r1) / (apex - base).length();
    let mut vertices = Vec::new();
    for (center, radius) in [(base, r0), (apex, r1)] {
        for i in 0..SEGMENTS {
            let c = circle(i);
            let out = x * c.x + z * c.y;
            let normal = (out + axis * slope).normalize_or(out);
            vertices.push((center + out * radius, if inside { -normal } else { normal }));
        }
    }
    let mut triangles = Vec::new();
    for i in 0..SEGMENTS {
        let (a, b) = (i, (i + 1) % SEGMENTS);
        let (d, c) = (a + SEGMENTS, b + SEGMENTS);
        triangles.push([a, b, c]);
        triangles.push([a, c, d]);
    }
    // any_orthonormal_pair is right-handed with the axis: x × z = axis, so a → b runs anticlockwise seen from the apex.
    Some((vertices, flip_if(triangles, inside)))
}

fn flip_if(mut triangles: Vec<[u32; 3]>, flip: bool) -> Vec<[u32; 3]> {
    if flip {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    triangles
}

/// Largest polygon that is tested for concavity; ear clipping is quadratic at best.
const MAX_CLIPPED: usize = 2000;

/// Triangles of a flat simple polygon, as corner numbers: always n − 2 of them. A fan when it is convex,
/// else by cutting ears (Meisters 1975).
pub fn triangulate(corners: &[Vec3]) -> Vec<[u32; 3]> {
    let n = corners.len();
    if n < 3 {
        return Vec::new();
    }
    let fan = || (1..n as u32 - 1).map(|i| [0, i, i + 1]).collect::<Vec<_>>();
    // Newell's normal is right for concave polygons too.
    let normal: Vec3 = (0..n).map(|i| (corners[i] - corners[0]).cross(corners[(i + 1) % n] - corners[0])).sum();
    let Some(normal) = normal.try_normalize() else { return fan() };
    let turn = |a: u32, b: u32, c: u32| {
        let [a, b, c] = [a, b, c].map(|i| corners[i as usize]);
        (b - a).cross(c - b).dot(normal)
    };
    let convex = (0..n as u32).all(|i| turn(i, (i + 1) % n as u32, (i + 2) % n as u32) >= 0.0);
    if convex || n > MAX_CLIPPED {
        return fan();
    }
    let mut ring: Vec<u32> = (0..n as u32).collect();
    let mut triangles = Vec::with_capacity(n - 2);
    while ring.len() > 3 {
        let m = ring.len();
        let ear = (0..m).find(|&i| {
            let (a, b, c) = (ring[(i + m - 1) % m], ring[i], ring[(i + 1) % m]);
            turn(a, b, c) > 0.0
                && ring
                    .iter()
                    .filter(|&&p| p != a && p != b && p != c)
                    .all(|&p| !(turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0))
        });
        // A polygon that crosses itself may have no ear: cutting any corner keeps the count right.
        let i = ear.unwrap_or(1);
        triangles.push([ring[(i + m - 1) % m], ring[i], ring[(i + 1) % m]]);
        ring.remove(i);
    }
    triangles.push([ring[0], ring[1], ring[2]]);
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outward((vertices, triangles): &Patch) -> bool {
        triangles.iter().all(|t| {
            let [a, b, c] = t.map(|i| vertices[i as usize]);
            (b.0 - a.0).cross(c.0 - a.0).dot(a.1 + b.1 + c.1) > 0.0
        })
    }

    /// Every edge is used once in each direction.
    fn closed(triangles: &[[u32; 3]]) -> bool {
        let mut edges: Vec<_> = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        edges.sort_unstable();
        edges.iter().all(|&(a, b)| edges.binary_search(&(b, a)).is_ok()) && edges.windows(2).all(|w| w[0] != w[1])
    }

    #[test]
    fn spheres_are_closed_and_face_outwards() {
        let s = sphere(Vec3::new(1.0, 2.0, 3.0), 2.0);
        assert_eq!(s.1.len(), 960);
        assert!(outward(&s) && closed(&s.1));
        for (p, n) in &s.0 {
            assert!((*p - Vec3::new(1.0, 2.0, 3.0) - *n * 2.0).length() < 1e-5);
        }
        let inside = sphere(Vec3::ZERO, -2.0);
        assert!(outward(&inside) && inside.0[0].1 == Vec3::NEG_Y);
    }

    #[test]
    fn cones_face_outwards_and_lean() {
        for axis in [Vec3::X, Vec3::NEG_Y, Vec3::new(1.0, -2.0, 0.5)] {
            let c = cone(Vec3::ZERO, 2.0, axis, 1.0).unwrap();
            assert_eq!(c.1.len(), 64);
            assert!(outward(&c), "{axis}");
            assert!(c.0[0].1.dot(axis) > 0.0, "the normal leans to the thin end");
        }
        assert!(outward(&cone(Vec3::ZERO, -1.0, Vec3::Y, -1.0).unwrap()));
        assert!(cone(Vec3::ONE, 1.0, Vec3::ONE, 2.0).is_none());
    }

    fn area(corners: &[Vec3], triangles: &[[u32; 3]]) -> f32 {
        triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| corners[i as usize]);
                (b - a).cross(c - a).length() / 2.0
            })
            .sum()
    }

    #[test]
    fn polygons_keep_their_area() {
        let l: Vec<Vec3> =
            [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)].map(|(x, y)| Vec3::new(x as f32, 3.0, y as f32)).to_vec();
        // Every start corner and both directions.
        for turn in 0..l.len() {
            let mut corners = l.clone();
            corners.rotate_left(turn);
            assert_eq!(triangulate(&corners).len(), 4);
            assert!((area(&corners, &triangulate(&corners)) - 3.0).abs() < 1e-5);
            corners.reverse();
            assert!((area(&corners, &triangulate(&corners)) - 3.0).abs() < 1e-5);
        }
        assert_eq!(triangulate(&[Vec3::ZERO; 5]).len(), 3, "degenerate polygons keep their count");
        assert!(triangulate(&[Vec3::ZERO; 2]).is_empty());
    }
}
