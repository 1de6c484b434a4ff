//! The triangles at each vertex, so that an update of some vertices costs what hangs on them.

use crate::accel::OutOfMemory;
use crate::accel::memory::reserve;
use crate::scene::Mesh;

/// Triangles of vertex `v`: `triangles[first[v]..first[v + 1]]`.
#[derive(Debug)]
pub(super) struct Links {
    first: Vec<u32>,
    triangles: Vec<u32>,
}

impl Links {
    /// Of a mesh whose triangles stay what they are.
    pub fn new(mesh: &Mesh) -> Result<Self, OutOfMemory> {
        let (vertices, corners) = (mesh.positions.len(), 3 * mesh.triangles.len());
        if u32::try_from(corners).is_err() {
            return Err(OutOfMemory { bytes: corners * size_of::<u32>() });
        }
        let mut first: Vec<u32> = reserve(vertices + 1)?;
        first.resize(vertices + 1, 0);
        mesh.triangles.iter().flatten().for_each(|&v| first[v as usize] += 1);
        let mut sum = 0;
        for count in &mut first {
            sum += *count;
            *count = sum;
        }
        let mut triangles = reserve(corners)?;
        triangles.resize(corners, 0);
        // Backwards, so that each entry ends as the first of its vertex.
        for (prim, triangle) in mesh.triangles.iter().enumerate().rev() {
            for &v in triangle {
                first[v as usize] -= 1;
                triangles[first[v as usize] as usize] = prim as u32;
            }
        }
        Ok(Self { first, triangles })
    }

    /// The triangles at any of `vertices`, ascending, each once.
    pub fn triangles_of(&self, vertices: &[u32]) -> Result<Vec<u32>, OutOfMemory> {
        let range = |v: u32| self.first[v as usize] as usize..self.first[v as usize + 1] as usize;
        let mut all = reserve(vertices.iter().map(|&v| range(v).len()).sum())?;
        all.extend(vertices.iter().flat_map(|&v| &self.triangles[range(v)]));
        all.sort_unstable();
        all.dedup();
        Ok(all)
    }

    pub fn memory_bytes(&self) -> usize {
        (self.first.capacity() + self.triangles.capacity()) * size_of::<u32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test_meshes::bumpy_sphere;

    #[test]
    fn triangles_of_vertices_are_those_that_name_them() {
        let mesh = bumpy_sphere(9, 11);
        let links = Links::new(&mesh).expect("memory");
        for vertices in [vec![0], vec![5, 6, 5, 40], vec![], (0..mesh.positions.len() as u32).collect()] {
            let named = |prim: &u32| mesh.triangles[*prim as usize].iter().any(|v| vertices.contains(v));
            let expected: Vec<u32> = (0..mesh.triangles.len() as u32).filter(named).collect();
            assert_eq!(links.triangles_of(&vertices).expect("memory"), expected);
        }
    }
}
