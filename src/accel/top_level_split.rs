//! How the top-level tree divides boxes of instances in two.
//!
//! The binned surface area heuristic (Wald, *On Fast Construction of SAH-based Bounding Volume Hierarchies*, 2007), with half
//! area times instances on both sides as the cost. Up to [`SWEEP`] boxes are swept exactly, along three sorted orders:
//! that is cheaper than filling bins.

use super::Aabb;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Bins per axis of large ranges.
const BINS: usize = 16;
/// Ranges of up to this many boxes are swept exactly.
const SWEEP: usize = 8;
/// Ranges above are binned in parallel, in chunks of this size.
pub(super) const CHUNK: usize = 2048;

/// An instance's box and number, 32 bytes. The number sits in the unused lane of `lo`, in the mantissa and the low bits of the
/// exponent of an ordinary number: denormals make arithmetic slow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    lo: Vec4,
    hi: Vec4,
}

impl Item {
    const EXPONENT: u32 = 0x4000_0000;

    #[inline]
    pub fn new(index: u32, bounds: &Aabb) -> Self {
        Self { lo: bounds.lo.extend(f32::from_bits(Self::EXPONENT | index)), hi: bounds.hi.extend(0.0) }
    }

    #[inline]
    pub fn index(&self) -> u32 {
        self.lo.w.to_bits() ^ Self::EXPONENT
    }

    pub fn to_aabb(self) -> Aabb {
        Box4 { lo: self.lo, hi: self.hi }.to_aabb()
    }

    /// Halves first: the sum of two coordinates may overflow. The fourth lane is meaningless.
    #[inline]
    fn center(&self) -> Vec4 {
        self.lo * 0.5 + self.hi * 0.5
    }
}

/// A box of four lanes, of which the last is meaningless.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box4 {
    lo: Vec4,
    hi: Vec4,
}

impl Box4 {
    const EMPTY: Box4 = Box4 { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    #[inline]
    fn grow(&mut self, lo: Vec4, hi: Vec4) {
        self.lo = self.lo.min(lo);
        self.hi = self.hi.max(hi);
    }

    /// Not finite, or NaN, for boxes beyond 10¹⁹.
    #[inline]
    pub fn half_area(&self) -> f32 {
        let e = (self.hi - self.lo).max(Vec4::ZERO);
        e.x * e.y + (e.y * e.z + e.z * e.x)
    }

    pub fn to_aabb(self) -> Aabb {
        Aabb { lo: self.lo.truncate(), hi: self.hi.truncate() }
    }
}

/// Items `start..start + count` of a node's items, with the boxes around them and around their centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    pub start: usize,
    pub count: usize,
    pub bounds: Box4,
    centers: Box4,
}

impl Range {
    pub fn of(items: &[Item], start: usize) -> Self {
        let mut range = Range { start, count: 0, bounds: Box4::EMPTY, centers: Box4::EMPTY };
        items.iter().for_each(|item| range.add(item));
        range
    }

    #[inline]
    fn add(&mut self, item: &Item) {
        self.count += 1;
        self.bounds.grow(item.lo, item.hi);
        let c = item.center();
        self.centers.grow(c, c);
    }

    pub fn join(mut self, other: Self) -> Self {
        self.count += other.count;
        self.bounds.grow(other.bounds.lo, other.bounds.hi);
        self.centers.grow(other.centers.lo, other.centers.hi);
        self
    }
}

/// Divides at least two items in two ranges, neither empty.
pub(super) fn split(items: &mut [Item], range: &Range) -> (Range, Range) {
    if items.len() == 2 {
        return (Range::of(&items[..1], range.start), Range::of(&items[1..], range.start + 1));
    }
    if items.len() <= SWEEP {
        return sweep(items, range);
    }
    let Some(found) = find_split(items, range) else { return halve(items, range) };
    let goes_left = |item: &Item| found.map.bins(item)[found.axis] < found.bin;
    let mut left = Range { count: 0, bounds: Box4::EMPTY, centers: Box4::EMPTY, ..*range };
    let mut right = left;
    let (mut i, mut j) = (0, items.len());
    loop {
        while i < j && goes_left(&items[i]) {
            left.add(&items[i]);
            i += 1;
        }
        while i < j && !goes_left(&items[j - 1]) {
            right.add(&items[j - 1]);
            j -= 1;
        }
        if i >= j {
            break;
        }
        items.swap(i, j - 1);
    }
    right.start = range.start + i;
    (left, right)
}

/// Divides 3 to [`SWEEP`] items at the border of least cost among all of the three sorted orders.
fn sweep(items: &mut [Item], range: &Range) -> (Range, Range) {
    let count = items.len();
    let mut best = (f32::INFINITY, 0, count / 2);
    let mut orders = [[0u8; SWEEP]; 3];
    for (axis, order) in orders.iter_mut().enumerate() {
        let mut keys = [0.0f32; SWEEP];
        for (i, item) in items.iter().enumerate() {
            // Insertion: stable, so items of equal centres keep their order.
            let key = item.center()[axis];
            let mut at = i;
            while at > 0 && keys[at - 1] > key {
                (keys[at], order[at]) = (keys[at - 1], order[at - 1]);
                at -= 1;
            }
            (keys[at], order[at]) = (key, i as u8);
        }
        let mut right = [0.0f32; SWEEP];
        let mut bounds = Box4::EMPTY;
        for at in (1..count).rev() {
            let item = &items[order[at] as usize & (SWEEP - 1)];
            bounds.grow(item.lo, item.hi);
            right[at] = bounds.half_area() * (count - at) as f32;
        }
        let mut bounds = Box4::EMPTY;
        for at in 1..count {
            let item = &items[order[at - 1] as usize & (SWEEP - 1)];
            bounds.grow(item.lo, item.hi);
            let cost = bounds.half_area() * at as f32 + right[at];
            if cost < best.0 {
                best = (cost, axis, at);
            }
        }
    }
    let (_, axis, middle) = best;
    let mut sorted = [items[0]; SWEEP];
    for (to, &from) in sorted.iter_mut().zip(&orders[axis][..count]) {
        *to = items[from as usize];
    }
    items.copy_from_slice(&sorted[..count]);
    let (left, right) = items.split_at(middle);
    (Range::of(left, range.start), Range::of(right, range.start + middle))
}

/// Divides by count, along the axis in which the centres spread most.
pub(super) fn halve(items: &mut [Item], range: &Range) -> (Range, Range) {
    let extent = (range.centers.hi - range.centers.lo).truncate();
    let middle = items.len() / 2;
    if extent.max_element() > 0.0 {
        let axis = extent.max_position();
        items.select_nth_unstable_by(middle, |a, b| {
            a.center()[axis].total_cmp(&b.center()[axis]).then(a.index().cmp(&b.index()))
        });
    }
    let (left, right) = items.split_at(middle);
    (Range::of(left, range.start), Range::of(right, range.start + middle))
}

/// A bin border: items whose bin along `axis` is below `bin` go left.
struct Split {
    axis: usize,
    bin: u32,
    map: BinMap,
}

/// How centres fall into bins. The same operations decide when counting and when dividing.
#[derive(Clone, Copy)]
struct BinMap {
    origin: Vec4,
    scale: Vec4,
    last: Vec4,
}

impl BinMap {
    /// None if the centres coincide or are too far apart to subtract.
    fn new(range: &Range, bins: usize) -> Option<Self> {
        let extent = (range.centers.hi - range.centers.lo).truncate();
        let scale = |e: f32| if e > 1e-30 { bins as f32 * 0.9999 / e } else { 0.0 };
        let scale = Vec3::new(scale(extent.x), scale(extent.y), scale(extent.z));
        (scale != Vec3::ZERO && extent.is_finite()).then(|| Self {
            origin: range.centers.lo.truncate().extend(0.0),
            scale: scale.extend(0.0),
            last: Vec4::splat(bins as f32 - 1.0),
        })
    }

    /// The bins of an item along the three axes.
    #[inline]
    fn bins(&self, item: &Item) -> [u32; 4] {
        // Rounding to an integer by way of the mantissa: vectorises, where a saturating cast does not.
        const MAGIC: f32 = (1 << 23) as f32;
        let position = ((item.center() - self.origin) * self.scale - Vec4::splat(0.499)).max(Vec4::ZERO).min(self.last);
        (position + Vec4::splat(MAGIC)).to_array().map(|x| x.to_bits() & (BINS as u32 - 1))
    }
}

/// Boxes and counts of the bins of all axes.
struct Bins {
    boxes: [[Box4; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    const EMPTY: Bins = Bins { boxes: [[Box4::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };

    fn add(mut self, items: &[Item], map: &BinMap) -> Self {
        for item in items {
            let bins = map.bins(item);
            for (axis, &bin) in bins[..3].iter().enumerate() {
                self.boxes[axis][bin as usize].grow(item.lo, item.hi);
                self.counts[axis][bin as usize] += 1;
            }
        }
        self
    }

    fn merge(mut self, other: Bins) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                let from = &other.boxes[axis][bin];
                self.boxes[axis][bin].grow(from.lo, from.hi);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }
}

/// The bin border of least cost, half area times instances on both sides, with instances on both.
fn find_split(items: &[Item], range: &Range) -> Option<Split> {
    let bins = (4 + items.len() / 8).min(BINS);
    let map = BinMap::new(range, bins)?;
    let filled = if items.len() > 2 * CHUNK {
        items.par_chunks(CHUNK).map(|chunk| Bins::EMPTY.add(chunk, &map)).reduce(|| Bins::EMPTY, Bins::merge)
    } else {
        Bins::EMPTY.add(items, &map)
    };
    let mut best: Option<Split> = None;
    let mut least = f32::INFINITY;
    for axis in 0..3 {
        if map.scale[axis] == 0.0 {
            continue;
        }
        // From the right: cost of what lies at and beyond each border.
        let mut right = [0.0f32; BINS];
        let (mut bounds, mut count) = (Box4::EMPTY, 0);
        for bin in (1..bins).rev() {
            let from = &filled.boxes[axis][bin];
            bounds.grow(from.lo, from.hi);
            count += filled.counts[axis][bin];
            right[bin] = bounds.half_area() * count as f32;
        }
        let (mut bounds, mut count) = (Box4::EMPTY, 0);
        for (bin, right) in right.iter().enumerate().take(bins).skip(1) {
            let from = &filled.boxes[axis][bin - 1];
            bounds.grow(from.lo, from.hi);
            count += filled.counts[axis][bin - 1];
            if count == 0 || count as usize == items.len() {
                continue;
            }
            let cost = bounds.half_area() * count as f32 + right;
            if cost < least {
                least = cost;
                best = Some(Split { axis, bin: bin as u32, map });
            }
        }
    }
    best
}
