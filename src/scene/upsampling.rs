//! How pixels between sampled ones get their colours.

/// How a sub-sampled frame is scaled to the size of the picture (Larsson and Akenine-Möller 2003, §4). A block of pixels has a
/// sampled pixel at each of its four corners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Upsampling {
    /// Bilinear between the four corners.
    #[default]
    Bilinear,
    /// Linear in each of four triangles between two corners and the middle of the block, which is the mean of the corners.
    Midpoint,
}

impl Upsampling {
    /// Every scheme, for tests that loop over all of them.
    pub const ALL: [Upsampling; 2] = [Upsampling::Bilinear, Upsampling::Midpoint];
}
