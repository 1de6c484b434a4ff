//! Checking a grid, for tests.

use super::Grid;
use crate::accel::{Aabb, triangle_bounds};
use crate::scene::Mesh;
use glam::Vec3;

impl Grid {
    /// Checks that every usable triangle of `mesh` is, with its corners, in all cells that its box touches and in no other. Describes the first violation.
    pub fn validate(&self, mesh: &Mesh) -> Result<(), String> {
        let boxes: Vec<Aabb> =
            (0..mesh.triangles.len() as u32).map(|prim| triangle_bounds(mesh.corners(prim))).collect();
        let bits = |corners: [Vec3; 3]| corners.map(|c| c.to_array().map(f32::to_bits));
        for triangle in &self.triangles {
            let prim = triangle.prim();
            if prim as usize >= boxes.len() || bits(triangle.corners()) != bits(mesh.corners(prim)) {
                return Err(format!("triangle {prim} has other corners than in the mesh"));
            }
        }
        let touch = |a: &Aabb, b: &Aabb| a.lo.cmple(b.hi).all() && b.lo.cmple(a.hi).all();
        let mut found = vec![0u64; boxes.len()];
        let mut expected = vec![0u64; boxes.len()];
        let top = self.top.filter(|top| !top.bounds().is_empty());
        for number in 0..top.map_or(0, |top| top.count()) {
            let whole = top.expect("there are cells").endless_cell(number);
            let cell = &self.cells[number];
            for below in 0..cell.lattice.count() {
                let bounds = cell.lattice.endless_cell(below);
                let mut last = None;
                for &index in self.refs(cell, below) {
                    let prim = self.triangles[index as usize].prim();
                    if last >= Some(index) {
                        return Err(format!("triangle {prim} comes after {last:?} in cell {below} of {number}"));
                    }
                    last = Some(index);
                    if !touch(&boxes[prim as usize], &whole) || !touch(&boxes[prim as usize], &bounds) {
                        return Err(format!("triangle {prim} does not touch cell {below} of {number}"));
                    }
                    found[prim as usize] += 1;
                }
            }
            let touching = boxes.iter().enumerate().filter(|(_, b)| !b.is_empty() && touch(b, &whole));
            for (prim, b) in touching {
                let cells = (0..cell.lattice.count()).filter(|&below| touch(b, &cell.lattice.endless_cell(below)));
                expected[prim] += cells.count() as u64;
            }
        }
        for (prim, (found, expected)) in (0..).zip(found.into_iter().zip(expected)) {
            if found != expected {
                return Err(format!("triangle {prim} is in {found} cells, not {expected}"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LEAF_REFS, TOP_REFS};
    use super::*;
    use crate::accel::test_meshes::{Random, bumpy_sphere, degenerate, soup};

    #[test]
    fn every_mesh_gets_a_valid_grid_of_bounded_size() {
        let mut all = degenerate();
        all.push(("sphere".to_owned(), bumpy_sphere(30, 40)));
        let mut old = Grid::default();
        for (name, mesh) in all {
            let grid = Grid::new(&mesh, std::mem::take(&mut old)).expect("memory");
            if mesh.triangles.len() < 10_000 {
                grid.validate(&mesh).unwrap_or_else(|e| panic!("{name}: {e}"));
            }
            let most = mesh.triangles.len() as u64 * TOP_REFS * LEAF_REFS;
            assert!(grid.refs.len() as u64 <= most, "{name}: {} references", grid.refs.len());
            let cells = grid.starts.len();
            let most = 8 + 3 * TOP_REFS as usize * mesh.triangles.len();
            assert!(grid.top.is_none() || cells <= most, "{name}: {cells} cells");
            old = grid;
        }
    }

    #[test]
    fn validate_sees_what_is_wrong() {
        let mesh = soup(&mut Random::new(Random::seed(9)), 500, 0.2);
        let grid = || Grid::new(&mesh, Grid::default()).expect("memory");
        let mut other = grid();
        other.refs[17] = other.refs[16];
        assert!(other.validate(&mesh).is_err());
        let mut other = grid();
        other.triangles[3] = crate::accel::Corners::NONE;
        assert!(other.validate(&mesh).is_err());
        let mut other = grid();
        let cell = other.cells.iter().position(|cell| cell.lattice.count() > 1).expect("there are grids below");
        other.cells[cell].lattice = super::super::Lattice::whole(*other.cells[cell].lattice.bounds());
        assert!(other.validate(&mesh).is_err());
        assert!(grid().validate(&mesh).is_ok());
    }
}
