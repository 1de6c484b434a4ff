//! From a stream of vertices to triangles, as OpenGL's primitives say.
//!
//! The assembler sees only vertex numbers. Strips alternate their winding; fans and polygons fan out from the first vertex (a
//! polygon is expected to be convex, as in OpenGL); quads are cut between their second and fourth corner. What is
//! incomplete at the end is dropped.

/// What the vertices between begin and end form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Primitive {
    Triangles,
    TriangleStrip,
    TriangleFan,
    Quads,
    QuadStrip,
    Polygon,
}

/// Up to two triangles that a vertex completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Completed {
    None,
    One([u32; 3]),
    Two([u32; 3], [u32; 3]),
}

/// The vertices of an unfinished primitive.
#[derive(Clone, Copy, Debug)]
pub struct Assembler {
    primitive: Primitive,
    /// The first `held` are waiting.
    waiting: [u32; 3],
    held: u8,
    /// The next triangle of a strip has its first two vertices swapped.
    odd: bool,
}

impl Assembler {
    pub fn new(primitive: Primitive) -> Self {
        Self { primitive, waiting: [0; 3], held: 0, odd: false }
    }

    pub fn primitive(&self) -> Primitive {
        self.primitive
    }

    /// Takes the next vertex.
    #[inline]
    pub fn push(&mut self, vertex: u32) -> Completed {
        let needed = match self.primitive {
            Primitive::Quads | Primitive::QuadStrip => 3,
            _ => 2,
        };
        if self.held < needed {
            self.waiting[self.held as usize] = vertex;
            self.held += 1;
            return Completed::None;
        }
        let [a, b, c] = self.waiting;
        match self.primitive {
            Primitive::Triangles => {
                self.held = 0;
                Completed::One([a, b, vertex])
            }
            Primitive::TriangleStrip => {
                self.waiting = [b, vertex, 0];
                self.odd = !self.odd;
                Completed::One(if self.odd { [a, b, vertex] } else { [b, a, vertex] })
            }
            Primitive::TriangleFan | Primitive::Polygon => {
                self.waiting[1] = vertex;
                Completed::One([a, b, vertex])
            }
            Primitive::Quads => {
                self.held = 0;
                Completed::Two([a, b, vertex], [vertex, b, c])
            }
            Primitive::QuadStrip => {
                self.waiting = [c, vertex, 0];
                self.held = 2;
                Completed::Two([a, b, c], [c, b, vertex])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assemble(primitive: Primitive, vertices: u32) -> Vec<[u32; 3]> {
        let mut assembler = Assembler::new(primitive);
        let mut out = Vec::new();
        for v in 0..vertices {
            match assembler.push(v) {
                Completed::None => {}
                Completed::One(t) => out.push(t),
                Completed::Two(t, u) => out.extend([t, u]),
            }
        }
        out
    }

    #[test]
    fn every_primitive_at_every_incomplete_length() {
        use Primitive::*;
        let expected: [(Primitive, u32, &[[u32; 3]]); 6] = [
            (Triangles, 6, &[[0, 1, 2], [3, 4, 5]]),
            (TriangleStrip, 5, &[[0, 1, 2], [2, 1, 3], [2, 3, 4]]),
            (TriangleFan, 5, &[[0, 1, 2], [0, 2, 3], [0, 3, 4]]),
            (Polygon, 5, &[[0, 1, 2], [0, 2, 3], [0, 3, 4]]),
            (Quads, 8, &[[0, 1, 3], [3, 1, 2], [4, 5, 7], [7, 5, 6]]),
            (QuadStrip, 6, &[[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]]),
        ];
        for (primitive, vertices, triangles) in expected {
            assert_eq!(assemble(primitive, vertices), triangles, "{primitive:?}");
            for fewer in 0..vertices {
                let got = assemble(primitive, fewer);
                assert_eq!(got, triangles[..got.len()], "{primitive:?} of {fewer}");
                let complete = match primitive {
                    Triangles => fewer / 3,
                    TriangleStrip | TriangleFan | Polygon => fewer.saturating_sub(2),
                    Quads => fewer / 4 * 2,
                    QuadStrip => fewer.saturating_sub(2) / 2 * 2,
                };
                assert_eq!(got.len() as u32, complete, "{primitive:?} of {fewer}");
            }
        }
    }
}
