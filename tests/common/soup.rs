//! Unconnected triangles, for unit and integration tests. The including module has `Mesh` and `Random` in scope.

use super::{Mesh, Random};
use glam::Vec3;

/// Unconnected triangles as a mesh.
pub fn mesh(triangles: impl IntoIterator<Item = [Vec3; 3]>) -> Mesh {
    let positions: Vec<Vec3> = triangles.into_iter().flatten().collect();
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Triangles of size `size` with a corner in the cube `[-1, 1]³`.
pub fn soup(random: &mut Random, count: usize, size: f32) -> Mesh {
    mesh((0..count).map(|_| {
        let at = random.vec();
        [at, at + random.vec() * size, at + random.vec() * size]
    }))
}
