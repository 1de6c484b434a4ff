//! What a kernel may ask of a vector.

use std::mem::MaybeUninit;

/// An instruction set: its 4-wide vector (triangle blocks) and its 8-wide one (nodes).
pub trait Isa: Copy {
    type F4: Vector<Array = [f32; 4]>;
    type F8: Eight;
}

/// Lanes of `f32`. Every operation is the IEEE one in each lane, so all implementations agree bit for bit.
///
/// Implementations are `#[inline(always)]` and never carry `#[target_feature]`: they must inline into the caller's
/// shell, which does.
///
/// # Safety of every method
/// - The processor has the instruction set that the implementing type stands for.
#[allow(clippy::missing_safety_doc)] // said once, above
pub trait Vector: Copy {
    /// The same lanes in memory.
    type Array;

    unsafe fn splat(value: f32) -> Self;
    unsafe fn load(from: &Self::Array) -> Self;
    unsafe fn store(self, to: &mut Self::Array);

    unsafe fn add(self, other: Self) -> Self;
    unsafe fn sub(self, other: Self) -> Self;
    unsafe fn mul(self, other: Self) -> Self;
    unsafe fn div(self, other: Self) -> Self;
    /// The square root, correctly rounded as all other operations are.
    unsafe fn sqrt(self) -> Self;
    /// The magnitude: clears the sign bit, also of a NaN.
    unsafe fn abs(self) -> Self;

    /// `if self < other { self } else { other }`: the second operand where either is NaN, as `minps` does.
    unsafe fn min(self, other: Self) -> Self;
    /// `if self > other { self } else { other }`: the second operand where either is NaN, as `maxps` does.
    unsafe fn max(self, other: Self) -> Self;

    /// In each lane `if self <= other { yes } else { no }`; `no` where either is NaN.
    unsafe fn select_le(self, other: Self, yes: Self, no: Self) -> Self;

    /// Lane `i` of `self` where bit `i` of `mask` is set, else of `other`. Bits beyond the lanes are ignored.
    unsafe fn select_bits(self, other: Self, mask: u32) -> Self;

    /// Bit `i` is set where lane `i` of `self <= other`; false for NaN.
    unsafe fn le(self, other: Self) -> u32;
    /// Bit `i` is set where lane `i` of `self < other`; false for NaN.
    unsafe fn lt(self, other: Self) -> u32;
}

/// What only vectors of eight lanes are asked. The safety rule is that of [`Vector`].
#[allow(clippy::missing_safety_doc)] // said there
pub trait Eight: Vector<Array = [f32; 8]> {
    /// The least of the lanes, none of which is NaN.
    #[inline(always)]
    unsafe fn least(self) -> f32 {
        let mut lanes = [0.0; 8];
        // SAFETY: the caller's promise.
        unsafe { self.store(&mut lanes) };
        lanes.into_iter().fold(f32::INFINITY, |least, lane| if lane < least { lane } else { least })
    }

    /// The greatest of the lanes, none of which is NaN.
    #[inline(always)]
    unsafe fn greatest(self) -> f32 {
        let mut lanes = [0.0; 8];
        // SAFETY: the caller's promise.
        unsafe { self.store(&mut lanes) };
        lanes.into_iter().fold(f32::NEG_INFINITY, |most, lane| if lane > most { lane } else { most })
    }

    /// The lanes where `self <= limit`, a bit each, and the one of them with the least of `self` by its highest 16 bits; any lane if there is none.
    /// No lane of `self` that is `<= limit` has its sign bit set.
    #[inline(always)]
    unsafe fn nearest_le(self, limit: Self) -> (u32, usize) {
        let mut lanes = [0.0f32; 8];
        // SAFETY: the caller's promise.
        let mask = unsafe {
            self.store(&mut lanes);
            self.le(limit)
        };
        let mut least = u32::MAX;
        for (i, lane) in (0..8).zip(lanes) {
            let key = if mask >> i & 1 == 1 { lane.to_bits() >> 16 } else { 0xffff };
            least = least.min(key << 3 | i);
        }
        (mask, (least & 7) as usize)
    }

    /// Lane `i` is the lane of `self` that the lowest three bits of lane `i` of `which` tell.
    #[inline(always)]
    unsafe fn pick(self, which: Self) -> Self {
        let (mut from, mut index) = ([0.0f32; 8], [0.0f32; 8]);
        // SAFETY: the caller's promise.
        unsafe {
            self.store(&mut from);
            which.store(&mut index);
            Self::load(&index.map(|i| from[i.to_bits() as usize & 7]))
        }
    }

    /// Writes the lanes in `mask`, in order, to the front of `to`, as words of 64 bits: the lane's own bits above `low[lane]`.
    /// What lies behind them becomes anything.
    #[inline(always)]
    unsafe fn pack_words(self, low: &[u32; 8], mask: u32, to: &mut [MaybeUninit<u64>; 8]) {
        let mut lanes = [0.0f32; 8];
        // SAFETY: the caller's promise.
        unsafe { self.store(&mut lanes) };
        let mut next = 0;
        for i in 0..8 {
            to[next & 7].write(u64::from(lanes[i].to_bits()) << 32 | u64::from(low[i]));
            next += (mask >> i & 1) as usize;
        }
    }

    /// Lane `i` of row `k` becomes lane `k` of row `i`.
    #[inline(always)]
    unsafe fn transpose(rows: [Self; 8]) -> [Self; 8] {
        let (mut from, mut to) = ([[0.0; 8]; 8], rows);
        // SAFETY: the caller's promise.
        unsafe {
            for (row, array) in rows.into_iter().zip(&mut from) {
                row.store(array);
            }
            for (i, row) in to.iter_mut().enumerate() {
                *row = Self::load(&[
                    from[0][i], from[1][i], from[2][i], from[3][i], from[4][i], from[5][i], from[6][i], from[7][i],
                ]);
            }
        }
        to
    }
}
