//! Which tiles a triangle covers: scan conversion, row by row, erring on the side of more (Khanna04 §2).

/// Tiles are grown by this much, in tiles: far more than rounding in f64 can move a border, far less than anybody can measure.
const MARGIN: f64 = 1e-7;

/// A part of a triangle in one tile, in the plane of the tiles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub tile: [usize; 2],
    /// What the triangle covers of the tile at most.
    pub lo: [f64; 2],
    pub hi: [f64; 2],
}

/// The column or row of a coordinate; those outside count to the outermost one.
#[inline(always)]
pub(crate) fn tile_of(x: f64, count: usize) -> usize {
    // What is below 0 or not a number becomes 0.
    (x as usize).min(count - 1)
}

/// The columns and rows of the box around a triangle: first and last.
#[inline(always)]
fn cells(points: &[[f64; 2]; 3], axis: usize, count: usize) -> (f64, f64, usize, usize) {
    let [a, b, c] = [points[0][axis], points[1][axis], points[2][axis]];
    let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
    (lo, hi, tile_of(lo - MARGIN, count), tile_of(hi + MARGIN, count))
}

/// Calls `each` for every one of `counts` tiles that the triangle touches, and now and then for one that it just misses.
#[inline(always)]
pub(super) fn cover(points: &[[f64; 2]; 3], counts: [usize; 2], mut each: impl FnMut(Piece)) {
    let (x_lo, x_hi, first_column, last_column) = cells(points, 0, counts[0]);
    let (y_lo, y_hi, first_row, last_row) = cells(points, 1, counts[1]);
    for row in first_row..=last_row {
        // The outermost rows reach on for ever.
        let below = if row == first_row { f64::NEG_INFINITY } else { row as f64 - MARGIN };
        let above = if row == last_row { f64::INFINITY } else { (row + 1) as f64 + MARGIN };
        let (lo, hi) = if first_row == last_row || first_column == last_column {
            (x_lo, x_hi)
        } else {
            let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..3 {
                let (p, q) = (points[i], points[(i + 1) % 3]);
                if p[1] >= below && p[1] <= above {
                    (lo, hi) = (lo.min(p[0]), hi.max(p[0]));
                }
                for line in [below, above] {
                    if (p[1] < line) != (q[1] < line) {
                        let x = p[0] + (q[0] - p[0]) * ((line - p[1]) / (q[1] - p[1]));
                        (lo, hi) = (lo.min(x), hi.max(x));
                    }
                }
            }
            (lo.max(x_lo), hi.min(x_hi))
        };
        if lo > hi {
            continue;
        }
        for column in tile_of(lo - MARGIN, counts[0])..=tile_of(hi + MARGIN, counts[0]) {
            let (left, bottom) = (column as f64, row as f64);
            each(Piece {
                tile: [column, row],
                lo: [lo.max(left), y_lo.max(bottom)],
                hi: [hi.min(left + 1.0), y_hi.min(bottom + 1.0)],
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test_meshes::Random;

    #[test]
    fn every_point_of_a_triangle_is_in_a_piece_of_its_tile() {
        let mut random = Random::new(Random::seed(72));
        for round in 0..3000 {
            let counts = [1 + random.below(9), 1 + random.below(7)];
            let size = [0.1, 1.0, 8.0][round % 3];
            let at = |random: &mut Random| f64::from(random.unit());
            let base = [at(&mut random) * 9.0, at(&mut random) * 7.0];
            let mut points = [[0.0; 2]; 3]
                .map(|_| [base[0] + (at(&mut random) - 0.5) * size, base[1] + (at(&mut random) - 0.5) * size]);
            match round % 7 {
                0 => points[1][0] = points[0][0],
                1 => points[2] = points[0],
                2 => points = points.map(|p| p.map(f64::round)),
                _ => {}
            }
            let mut pieces = Vec::new();
            cover(&points, counts, |piece| pieces.push(piece));
            for i in 0..pieces.len() {
                assert!(pieces[..i].iter().all(|p| p.tile != pieces[i].tile), "a tile twice");
            }
            for _ in 0..20 {
                let (mut u, mut v) = (at(&mut random), at(&mut random));
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                let p = [0, 1]
                    .map(|k| points[0][k] + (points[1][k] - points[0][k]) * u + (points[2][k] - points[0][k]) * v);
                let tile = [tile_of(p[0], counts[0]), tile_of(p[1], counts[1])];
                let outside = (0..2).any(|k| p[k] < 0.0 || p[k] > counts[k] as f64);
                let inside = |piece: &Piece| (0..2).all(|k| piece.lo[k] <= p[k] + 2e-7 && p[k] <= piece.hi[k] + 2e-7);
                assert!(
                    pieces.iter().any(|piece| piece.tile == tile && (outside || inside(piece))),
                    "{p:?} of {points:?} is in none of {pieces:?}"
                );
            }
        }
    }

    #[test]
    fn a_diagonal_sliver_covers_few_of_the_tiles_of_its_box() {
        let mut count = 0;
        cover(&[[0.1, 0.2], [19.8, 19.9], [19.9, 19.8]], [20, 20], |_| count += 1);
        assert!((20..=60).contains(&count), "{count} tiles");
    }
}
