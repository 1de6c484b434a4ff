//! Where to split a range of triangles: the cheapest bin border (Wald, *On Fast Construction of SAH-based Bounding Volume Hierarchies*, 2007).
//!
//! Triangles are counted into a few equal bins of their box centres along each axis, and only bin borders are tried. All three axes go
//! together: a triangle costs three times two minima of four lanes, a border one vector of three areas, got by a transposition. Counts are rounded
//! up to blocks of four triangles, as the leaves hold them.

use super::bvh::BLOCK;
use super::prim_ref::{Box4, Centers, PrimRef};
use crate::simd::{self, Kernel, Level};
use glam::{Mat4, Vec3, Vec4};
use rayon::prelude::*;

/// Bins per axis for large ranges; Wald 2007 finds no gain beyond.
const BINS: usize = 16;
/// Ranges above are binned in parallel, in chunks of half this size.
pub(super) const PARALLEL: usize = 1 << 15;

/// A bin border: triangles whose bin along `axis` is below `bin` go left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    pub axis: usize,
    pub bin: u32,
    /// Sum over both sides of half area times blocks.
    pub cost: f32,
    /// The boxes of both sides.
    pub bounds: [Box4; 2],
    pub map: BinMap,
}

/// How centres fall into bins. The same operations decide when counting and when dividing.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinMap {
    origin: Vec4,
    scale: Vec4,
    last: Vec4,
}

/// Rounds to an integer by way of the mantissa: vectorises, where a saturating cast does not.
const MAGIC: f32 = (1 << 23) as f32;

impl BinMap {
    /// None if the centres coincide (nearly, in the range of denormals).
    #[inline(always)]
    fn new(centers: &Centers, bins: usize) -> Option<Self> {
        let extent = centers.extent();
        let scale = |e: f32| if e > 1e-30 { bins as f32 * 0.9999 / e } else { 0.0 };
        let scale = Vec3::new(scale(extent.x), scale(extent.y), scale(extent.z));
        (scale != Vec3::ZERO).then(|| Self {
            origin: centers.lo.truncate().extend(0.0),
            scale: scale.extend(0.0),
            last: Vec4::splat(bins as f32 - 1.0),
        })
    }

    /// The bins of a triangle along the three axes, plus [`MAGIC`].
    #[inline(always)]
    fn position(&self, r: &PrimRef) -> Vec4 {
        let position = ((r.center2() - self.origin) * self.scale - Vec4::splat(0.499)).max(Vec4::ZERO).min(self.last);
        position + Vec4::splat(MAGIC)
    }

    #[inline(always)]
    fn bins(&self, r: &PrimRef) -> [usize; 3] {
        let [x, y, z, _] = self.position(r).to_array().map(|x| x.to_bits() as usize & (BINS - 1));
        [x, y, z]
    }
}

impl Split {
    /// Tells whether a triangle belongs to the left side.
    #[inline(always)]
    pub fn side(&self) -> impl Fn(&PrimRef) -> bool {
        let (map, axis, border) = (self.map, self.axis, Vec4::splat(MAGIC + self.bin as f32));
        move |r| map.position(r).cmplt(border).bitmask() >> axis & 1 != 0
    }
}

/// Boxes and counts of the bins of all axes.
#[derive(Clone)]
struct Bins {
    boxes: [[Box4; 3]; BINS],
    counts: [[u32; 4]; BINS],
}

impl Bins {
    const EMPTY: Bins = Bins { boxes: [[Box4::EMPTY; 3]; BINS], counts: [[0; 4]; BINS] };

    #[inline(always)]
    fn add(&mut self, refs: &[PrimRef], map: &BinMap) {
        for r in refs {
            let [x, y, z] = map.bins(r);
            self.boxes[x][0].grow(r.bounds());
            self.boxes[y][1].grow(r.bounds());
            self.boxes[z][2].grow(r.bounds());
            self.counts[x][0] += 1;
            self.counts[y][1] += 1;
            self.counts[z][2] += 1;
        }
    }

    fn merge(mut self, other: Self) -> Self {
        for bin in 0..BINS {
            for axis in 0..3 {
                self.boxes[bin][axis].grow(&other.boxes[bin][axis]);
                self.counts[bin][axis] += other.counts[bin][axis];
            }
        }
        self
    }

    /// The cheapest border with triangles on both sides.
    #[inline(always)]
    fn best(&self, count: usize, bins: usize, map: &BinMap) -> Option<Split> {
        // From the right: cost of what lies at and beyond each border.
        let mut right = [Vec4::ZERO; BINS];
        let mut side = Side::EMPTY;
        for bin in (1..bins).rev() {
            right[bin] = side.add(&self.boxes[bin], self.counts[bin]);
        }
        let mut side = Side::EMPTY;
        let (mut least, mut at) = (Vec4::INFINITY, Vec4::ZERO);
        let all = Vec4::splat(count as f32);
        for (bin, right) in right.iter().enumerate().take(bins).skip(1) {
            let left = side.add(&self.boxes[bin - 1], self.counts[bin - 1]);
            let number = Vec4::from_array(side.counts.map(|x| x as f32));
            let both = number.cmpgt(Vec4::ZERO) & number.cmplt(all);
            let cost = left + *right;
            let better = cost.cmplt(least) & both;
            least = Vec4::select(better, cost, least);
            at = Vec4::select(better, Vec4::splat(bin as f32), at);
        }
        let mut axis = 0;
        for other in 1..3 {
            if least[other] < least[axis] {
                axis = other;
            }
        }
        if least[axis] == f32::INFINITY {
            return None;
        }
        let bin = at[axis] as usize;
        let mut bounds = [Box4::EMPTY; 2];
        for (i, boxes) in self.boxes[..bins].iter().enumerate() {
            bounds[usize::from(i >= bin)].grow(&boxes[axis]);
        }
        Some(Split { axis, bin: bin as u32, cost: least[axis], bounds, map: *map })
    }
}

/// What lies on one side of a border, for the three axes.
struct Side {
    boxes: [Box4; 3],
    counts: [u32; 4],
}

impl Side {
    const EMPTY: Side = Side { boxes: [Box4::EMPTY; 3], counts: [0; 4] };

    /// Adds a bin of each axis and returns half area times blocks.
    #[inline(always)]
    fn add(&mut self, boxes: &[Box4; 3], counts: [u32; 4]) -> Vec4 {
        for (a, b) in self.boxes.iter_mut().zip(boxes) {
            a.grow(b);
        }
        for (a, b) in self.counts.iter_mut().zip(counts) {
            *a += b;
        }
        let [a, b, c] = [self.boxes[0].extent(), self.boxes[1].extent(), self.boxes[2].extent()];
        let sides = Mat4::from_cols(a, b, c, Vec4::ZERO).transpose();
        let (x, y, z) = (sides.x_axis, sides.y_axis, sides.z_axis);
        let blocks = self.counts.map(|n| ((n + (BLOCK as u32 - 1)) >> BLOCK.trailing_zeros()) as i32 as f32);
        (x * y + (y * z + z * x)) * Vec4::from_array(blocks)
    }
}

struct Find<'a> {
    refs: &'a [PrimRef],
}

impl Kernel for Find<'_> {
    type Output = Option<Split>;

    #[inline(always)]
    fn run(self) -> Option<Split> {
        let count = self.refs.len();
        let bins = bins_for(count);
        let map = BinMap::new(&Centers::of(self.refs), bins)?;
        let mut filled = Bins::EMPTY;
        filled.add(self.refs, &map);
        filled.best(count, bins, &map)
    }
}

struct Measure<'a>(&'a [PrimRef]);

impl Kernel for Measure<'_> {
    type Output = Centers;

    #[inline(always)]
    fn run(self) -> Centers {
        Centers::of(self.0)
    }
}

struct Fill<'a> {
    refs: &'a [PrimRef],
    map: &'a BinMap,
}

impl Kernel for Fill<'_> {
    type Output = Bins;

    #[inline(always)]
    fn run(self) -> Bins {
        let mut bins = Bins::EMPTY;
        bins.add(self.refs, self.map);
        bins
    }
}

struct Best<'a> {
    bins: &'a Bins,
    count: usize,
    map: &'a BinMap,
}

impl Kernel for Best<'_> {
    type Output = Option<Split>;

    #[inline(always)]
    fn run(self) -> Option<Split> {
        self.bins.best(self.count, BINS, self.map)
    }
}

/// Few triangles do not fill many bins: against 16 for all, +0.1 % cost and a fifth of the time saved (1.3 M triangles).
#[inline(always)]
fn bins_for(count: usize) -> usize {
    (4 + count / 8).min(BINS)
}

/// Blocks that so many triangles fill.
pub(super) fn blocks_of(count: usize) -> f32 {
    count.div_ceil(BLOCK) as f32
}

/// The box around the doubled centres.
pub(super) fn centers_of(level: Level, refs: &[PrimRef]) -> Centers {
    if refs.len() <= PARALLEL {
        return simd::run(level, Measure(refs));
    }
    let chunks = refs.par_chunks(PARALLEL / 2);
    chunks.map(|chunk| simd::run(level, Measure(chunk))).reduce(|| Centers::EMPTY, Centers::union)
}

/// The cheapest bin border with triangles on both sides.
pub(super) fn find_split(level: Level, refs: &[PrimRef]) -> Option<Split> {
    if refs.len() <= PARALLEL {
        return simd::run(level, Find { refs });
    }
    let map = BinMap::new(&centers_of(level, refs), BINS)?;
    let bins = refs
        .par_chunks(PARALLEL / 2)
        .map(|refs| simd::run(level, Fill { refs, map: &map }))
        .reduce_with(Bins::merge)
        .expect("there are chunks");
    simd::run(level, Best { bins: &bins, count: refs.len(), map: &map })
}
