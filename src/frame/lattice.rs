//! Sub-sampled pictures: which pixels are sampled, and what the others show.
//!
//! A ray tracer of few processors reaches interactive rates where it samples one pixel in each block of n × n and interpolates the others (Larsson
//! and Akenine-Möller, *Strategies for Bounding Volume Hierarchy Updates for Ray Tracing of Deformable Models*, 2003, §4): each group of 2 × 2
//! sampled pixels is a quadrilateral between whose corners colours are interpolated. Two ways, both from the paper: bilinear, and, which the authors found
//! to look somewhat better, linear in the four triangles that meet at the middle of the quadrilateral, where the colour is the mean of the corners.
//!
//! Where we differ: the paper stretches the small picture over the large one in graphics hardware. Here nodes are pixels of the
//! picture: columns and rows 0, n, 2n, … of the viewport and the last ones, wherever these are. So a node shows what the same
//! pixel shows without sub-sampling, bit for bit; blocks at the right and upper border may be narrower; and nothing is extrapolated. That takes
//! a node more per row and column than pixels divided by n: at 640 × 480 2 % more rays than 1/25 of the pixels at 5 × 5, 4 % more than 1/100 at 10 × 10.
//!
//! Cost: 4.6 ns per pixel bilinearly and 8 by triangles, in one thread: 1.4 and 2.5 ms at 640 × 480 (`c_examples/build/bodies --triangles 180 --subsampling 100
//! --threads 1`, the least of 30 frames).
//!
//! What cannot be interpolated (depth, normal, names) is that of the nearest node.

use super::{Framebuffer, Pixel, TILE_SIZE, Tile, TileRect};

/// Nodes that the columns of a tile lie between, at the most: with a step of 1.
const NODES: usize = TILE_SIZE as usize + 1;

/// The pixels of a viewport that are sampled: one in `step` along rows and columns, and the last of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    origin: [u32; 2],
    size: [u32; 2],
    step: u32,
}

/// Where a column or row lies between two nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Between {
    node: u32,
    /// The same as `node` on a node.
    next: u32,
    /// 0 on `node`, towards 1 on `next`.
    share: f32,
}

impl Lattice {
    /// `viewport` is not empty, `step` at least 1.
    pub fn new(viewport: TileRect, step: u32) -> Self {
        let size = [viewport.x1 - viewport.x0, viewport.y1 - viewport.y0];
        Self { origin: [viewport.x0, viewport.y0], size, step }
    }

    /// Columns and rows of nodes.
    pub fn nodes(&self) -> [u32; 2] {
        self.size.map(|pixels| (pixels - 1).div_ceil(self.step) + 1)
    }

    /// Pixels from one node to the next, but for the last.
    pub fn step(&self) -> u32 {
        self.step
    }

    /// Fills the `visible` pixels of the tile at `tile` between `nodes`, bilinearly.
    pub fn fill_bilinear(&self, nodes: &Framebuffer, tile: [u32; 2], visible: TileRect, pixels: &mut Tile) {
        self.fill(nodes, tile, visible, pixels, |[a, b, c, d], [x, y]| mix(mix(a, c, y), mix(b, d, y), x));
    }

    /// Fills the `visible` pixels of the tile at `tile` between `nodes`, linearly in four triangles.
    pub fn fill_midpoint(&self, nodes: &Framebuffer, tile: [u32; 2], visible: TileRect, pixels: &mut Tile) {
        self.fill(nodes, tile, visible, pixels, midpoint);
    }

    #[inline(always)]
    fn fill(
        &self,
        nodes: &Framebuffer,
        tile: [u32; 2],
        visible: TileRect,
        pixels: &mut Tile,
        blend: impl Fn([[f32; 4]; 4], [f32; 2]) -> [f32; 4],
    ) {
        let mut across = [Between::default(); TILE_SIZE as usize];
        for x in visible.x0..visible.x1 {
            across[(x - tile[0]) as usize] = self.between(0, x);
        }
        let columns = &across[(visible.x0 - tile[0]) as usize..(visible.x1 - tile[0]) as usize];
        let (Some(first), Some(last)) = (columns.first(), columns.last()) else { return };
        let (first, count) = (first.node, (last.next - first.node + 1) as usize);
        let [mut lower, mut upper] = [[Pixel::EMPTY; NODES]; 2];
        let mut rows = None;
        for y in visible.y0..visible.y1 {
            let up = self.between(1, y);
            // Rows of pixels mostly lie between the same rows of nodes as those below.
            if rows.replace([up.node, up.next]) != Some([up.node, up.next]) {
                for (row, line) in [(up.node, &mut lower), (up.next, &mut upper)] {
                    for (node, to) in (first..).zip(&mut line[..count]) {
                        *to = nodes.pixel(node, row).expect("a picture of all nodes");
                    }
                }
            }
            let near = if up.share <= 0.5 { &lower } else { &upper };
            for (at, x) in (visible.x0 - tile[0]..).zip(columns) {
                let [i, j] = [x.node, x.next].map(|node| (node - first) as usize);
                let corners = [lower[i].color, lower[j].color, upper[i].color, upper[j].color];
                let nearest = near[if x.share <= 0.5 { i } else { j }];
                let color = blend(corners, [x.share, up.share]);
                pixels.set(at, y - tile[1], Pixel { color, ..nearest });
            }
        }
    }

    /// Where column (`axis` 0) or row (1) `at` of the picture lies.
    fn between(&self, axis: usize, at: u32) -> Between {
        let at = at - self.origin[axis];
        let node = at / self.step;
        let begin = node * self.step;
        let end = begin.saturating_add(self.step).min(self.size[axis] - 1);
        if at == begin {
            Between { node, next: node, share: 0.0 }
        } else if at == end {
            Between { node: node + 1, next: node + 1, share: 0.0 }
        } else {
            Between { node, next: node + 1, share: (at - begin) as f32 / (end - begin) as f32 }
        }
    }
}

/// A constant stays the same bits.
#[inline(always)]
fn mix(a: [f32; 4], b: [f32; 4], share: f32) -> [f32; 4] {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * share)
}

/// The colour at (`x`, `y`) of a unit square of four triangles, whose corners are lower left, lower right, upper left, upper right.
#[inline(always)]
fn midpoint([a, b, c, d]: [[f32; 4]; 4], [x, y]: [f32; 2]) -> [f32; 4] {
    let [from_side, from_base] = [x.min(1.0 - x), y.min(1.0 - y)];
    // The triangle over the nearest edge, from `p` to `q`; (`along`, `away`) is the point relative to it.
    let (p, q, along, away) = if from_base <= from_side {
        let (p, q) = if y <= 0.5 { (a, b) } else { (c, d) };
        (p, q, x, from_base)
    } else {
        let (p, q) = if x <= 0.5 { (a, c) } else { (b, d) };
        (p, q, y, from_side)
    };
    std::array::from_fn(|k| {
        let middle = 0.25 * ((a[k] + b[k]) + (c[k] + d[k]));
        p[k] + (q[k] - p[k]) * (along - away) + (middle - p[k]) * (2.0 * away)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A viewport with a border around it, in a framebuffer.
    fn viewport(width: u32, height: u32) -> TileRect {
        TileRect { x0: 3, y0: 5, x1: 3 + width, y1: 5 + height }
    }

    /// The pixel of node `i`, by the definition.
    fn column(i: u32, step: u32, pixels: u32) -> u32 {
        (i * step).min(pixels - 1)
    }

    /// Nodes that show `value` of their pixel, scaled up.
    fn scaled(width: u32, height: u32, step: u32, middle: bool, value: impl Fn(u32, u32) -> [f32; 4]) -> Framebuffer {
        let lattice = Lattice::new(viewport(width, height), step);
        let [columns, rows] = lattice.nodes();
        let mut nodes = Framebuffer::default();
        nodes.resize(columns, rows).unwrap();
        let grid = nodes.grid();
        for (i, tile) in nodes.tiles_mut().0.iter_mut().enumerate() {
            let rect = grid.rect(i);
            for y in rect.y0..rect.y1 {
                for x in rect.x0..rect.x1 {
                    let [object, instance] = [column(x, step, width), column(y, step, height)];
                    let color = value(object, instance);
                    tile.set(x - rect.x0, y - rect.y0, Pixel { color, object, instance, ..Pixel::EMPTY });
                }
            }
        }
        let mut out = Framebuffer::default();
        out.resize(width + 7, height + 9).unwrap();
        let grid = out.grid();
        for (i, tile) in out.tiles_mut().0.iter_mut().enumerate() {
            let rect = grid.rect(i);
            let visible = rect.intersection(viewport(width, height));
            let fill = if middle { Lattice::fill_midpoint } else { Lattice::fill_bilinear };
            if !visible.is_empty() {
                fill(&lattice, &nodes, [rect.x0, rect.y0], visible, tile);
            }
        }
        out
    }

    const SIZES: [[u32; 2]; 8] = [[1, 1], [2, 1], [1, 9], [16, 16], [41, 30], [37, 53], [5, 64], [64, 3]];
    const STEPS: [u32; 8] = [1, 2, 3, 4, 5, 10, 16, 70_000];

    /// Where `at` lies between the nodes `a` and `b`, which are pixels.
    fn nodes_around(at: u32, step: u32, pixels: u32) -> (u32, u32, f64) {
        let all = (0..pixels).filter(|&x| x % step == 0 || x == pixels - 1);
        let a = all.clone().filter(|&x| x <= at).max().expect("0 is a node");
        let b = all.clone().filter(|&x| x >= at).min().expect("the last is a node");
        (a, b, if a == b { 0.0 } else { f64::from(at - a) / f64::from(b - a) })
    }

    #[test]
    fn every_pixel_is_what_the_definition_says() {
        let value = |x: u32, y: u32| [((7 * x + 13 * y) % 31) as f32, (x * y % 11) as f32, (x ^ y) as f32, 1.0];
        for [width, height] in SIZES {
            for step in STEPS {
                for middle in [false, true] {
                    let picture = scaled(width, height, step, middle, value);
                    for y in 0..height {
                        for x in 0..width {
                            let (x0, x1, fx) = nodes_around(x, step, width);
                            let (y0, y1, fy) = nodes_around(y, step, height);
                            let pixel = picture.pixel(x + 3, y + 5).unwrap();
                            let at = format!("{width}x{height}, step {step}, middle {middle}, pixel {x} {y}");
                            for k in 0..4 {
                                let [a, b, c, d] =
                                    [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| f64::from(value(x, y)[k]));
                                let m = (a + b + c + d) / 4.0;
                                // Plane through an edge's ends and the middle, for the triangle that the point is in.
                                let expected = if !middle {
                                    a * (1.0 - fx) * (1.0 - fy)
                                        + b * fx * (1.0 - fy)
                                        + c * (1.0 - fx) * fy
                                        + d * fx * fy
                                } else if fy <= fx && fy <= 1.0 - fx {
                                    a + (b - a) * fx + (2.0 * m - a - b) * fy
                                } else if fy >= fx && fy >= 1.0 - fx {
                                    c + (d - c) * fx + (2.0 * m - c - d) * (1.0 - fy)
                                } else if fx <= fy {
                                    a + (c - a) * fy + (2.0 * m - a - c) * fx
                                } else {
                                    b + (d - b) * fy + (2.0 * m - b - d) * (1.0 - fx)
                                };
                                let got = f64::from(pixel.color[k]);
                                assert!((got - expected).abs() < 1e-4, "{at}: {got} for {expected}");
                                if (x0, y0) == (x1, y1) {
                                    assert_eq!(pixel.color[k].to_bits(), value(x, y)[k].to_bits(), "{at}: a node");
                                }
                            }
                            assert_eq!(pixel.object, if fx <= 0.5 { x0 } else { x1 }, "{at}");
                            assert_eq!(pixel.instance, if fy <= 0.5 { y0 } else { y1 }, "{at}");
                        }
                    }
                    let outside = [(2, 5), (3, 4), (3 + width, 5), (3, 5 + height)];
                    for (x, y) in outside {
                        assert_eq!(picture.pixel(x, y), Some(Pixel::EMPTY), "outside of the viewport");
                    }
                }
            }
        }
    }

    #[test]
    fn a_ramp_and_a_constant_are_exact() {
        for [width, height] in SIZES {
            for middle in [false, true] {
                let constant = [0.1, 1e30, 0.7, 1.0];
                let picture = scaled(width, height, 5, middle, |_, _| constant);
                for y in 0..height {
                    assert!(picture.row(y + 5).skip(3).take(width as usize).all(|p| p.color == constant));
                }
                // Shares of blocks of 4 have few binary digits.
                let (width, height) = (width.next_multiple_of(4) + 1, height.next_multiple_of(4) + 1);
                let ramp = |x: u32, y: u32| [x as f32, y as f32, 3.0 * x as f32 - 2.0 * y as f32 + 1.0, 1.0];
                let picture = scaled(width, height, 4, middle, ramp);
                for y in 0..height {
                    for x in 0..width {
                        assert_eq!(picture.pixel(x + 3, y + 5).unwrap().color, ramp(x, y), "{x} {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn nodes_are_few() {
        let nodes = |width, height, step| Lattice::new(viewport(width, height), step).nodes();
        assert_eq!(nodes(640, 480, 5), [129, 97]);
        assert_eq!(nodes(640, 480, 10), [65, 49]);
        assert_eq!(nodes(641, 481, 10), [65, 49]);
        assert_eq!(nodes(642, 471, 10), [66, 48]);
        assert_eq!(nodes(17, 1, 1), [17, 1]);
    }
}
