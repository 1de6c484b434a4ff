//! Sorting a few boxes into as many groups as before, so that the areas of the groups are small.
//!
//! A rotation exchanges two grandchildren of a node, or a grandchild and a child. On a node of eight children, each of
//! which has eight, 1792 such exchanges are possible, and the best of them is the first step of a long way. This is where that way leads: all
//! grandchildren are sorted into the children anew, from the top down by a sweep of the surface area heuristic along the axis in which
//! centres spread most. It takes as long as looking for one best exchange. (That was tried: each grandchild that makes its
//! parent large against all grandchildren of all siblings, eight at a time, 670 ns per node; it kept a sixth of the cost that sorting
//! keeps off on flying spheres.)

use super::bvh::{BLOCK, MAX_LEAF_BLOCKS, WIDTH};
use glam::Vec4;

/// Boxes at most: the grandchildren of a node, or the triangles of the leaves below one.
pub(super) const MOST: usize = if WIDTH * WIDTH > WIDTH * BLOCK * 2 { WIDTH * WIDTH } else { WIDTH * BLOCK * 2 };
/// Groups at most: children, or blocks.
pub(super) const GROUPS: usize = MOST / BLOCK;
const _: () = assert!(GROUPS >= WIDTH && GROUPS >= MAX_LEAF_BLOCKS);

/// A box to be sorted; the last lanes are meaningless.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub lo: Vec4,
    pub hi: Vec4,
    /// What the caller knows it by.
    pub tag: u32,
}

impl Item {
    pub const EMPTY: Item = Item { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY, tag: 0 };

    #[inline(always)]
    pub fn union(self, other: &Item) -> Item {
        Item { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi), tag: self.tag }
    }

    /// Half the surface area; 0 for an empty box.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let e = (self.hi - self.lo).max(Vec4::ZERO);
        e.x * e.y + (e.y * e.z + e.z * e.x)
    }

    /// Twice the centre; NaN for an empty box.
    #[inline(always)]
    fn center2(&self) -> Vec4 {
        self.lo + self.hi
    }
}

/// The box around all of some items.
#[inline(always)]
pub(super) fn around(items: &[Item]) -> Item {
    items.iter().fold(Item::EMPTY, Item::union)
}

/// Lengths of groups, in order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Groups {
    lengths: [u8; GROUPS],
    count: usize,
}

impl Groups {
    fn push(&mut self, len: usize) {
        self.lengths[self.count] = len as u8;
        self.count += 1;
    }

    pub fn lengths(&self) -> impl Iterator<Item = usize> + '_ {
        self.lengths[..self.count].iter().map(|&len| usize::from(len))
    }
}

/// Puts `items` in such an order that runs of them are groups: `count` of them, none empty and none longer than `capacity`. Equal for equal
/// items in equal order.
///
/// # Panics
/// When there are fewer items than groups, more than fit, or more than [`MOST`].
pub(super) fn regroup(items: &mut [Item], count: usize, capacity: usize) -> Groups {
    let mut groups = Groups::default();
    assert!(items.len() <= MOST && count <= GROUPS, "{} boxes for {count} groups", items.len());
    divide(items, count, capacity, &mut groups);
    groups
}

fn divide(items: &mut [Item], count: usize, capacity: usize, groups: &mut Groups) {
    let len = items.len();
    assert!((1..=len).contains(&count) && len <= count * capacity, "{len} boxes for {count} groups of {capacity}");
    if count == 1 {
        return groups.push(len);
    }
    sort_by_center(items);
    let mut beyond = [0.0f32; MOST];
    let mut all = Item::EMPTY;
    for (i, item) in items.iter().enumerate().rev() {
        all = all.union(item);
        beyond[i] = all.half_area();
    }
    let mut best: Option<(f32, usize, usize)> = None;
    let mut before = Item::EMPTY;
    for at in 1..len {
        before = before.union(&items[at - 1]);
        let rest = len - at;
        // Groups on the near side: in proportion, if both sides fit in theirs and none stays empty.
        let least = at.div_ceil(capacity).max(count.saturating_sub(rest));
        let most = at.min(count.saturating_sub(rest.div_ceil(capacity)));
        if least > most {
            continue;
        }
        let near = ((count * at + len / 2) / len).clamp(least, most);
        let cost = before.half_area() * at as f32 + beyond[at] * rest as f32;
        if best.is_none_or(|(least, ..)| cost < least) {
            best = Some((cost, at, near));
        }
    }
    let (_, at, near) = best.expect("the first `capacity` boxes fit in a group, and the others in the rest");
    let (lower, upper) = items.split_at_mut(at);
    divide(lower, near, capacity, groups);
    divide(upper, count - near, capacity, groups);
}

/// Sorts along the axis in which centres spread most, equal ones by their place.
fn sort_by_center(items: &mut [Item]) {
    let (mut lo, mut hi) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
    for item in &*items {
        // A NaN as the first operand gives the second.
        lo = item.center2().min(lo);
        hi = item.center2().max(hi);
    }
    let axis = (hi - lo).truncate().max_position();
    let mut keys = [0u64; MOST];
    for (i, (key, item)) in keys.iter_mut().zip(&*items).enumerate() {
        // Floats as integers of the same order; empty boxes come last or first.
        let bits = item.center2()[axis].to_bits();
        let ordered = if bits >> 31 == 0 { bits | 1 << 31 } else { !bits };
        *key = u64::from(ordered) << 32 | i as u64;
    }
    keys[..items.len()].sort_unstable();
    let mut sorted = [Item::EMPTY; MOST];
    for (to, key) in sorted.iter_mut().zip(&keys[..items.len()]) {
        *to = items[*key as u32 as usize];
    }
    items.copy_from_slice(&sorted[..items.len()]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test_meshes::Random;

    fn boxes(random: &mut Random, count: usize) -> Vec<Item> {
        let item = |tag| {
            let (lo, size) = (random.vec(), random.vec().abs() * 0.1);
            Item { lo: lo.extend(0.0), hi: (lo + size).extend(0.0), tag }
        };
        (0..count as u32).map(item).collect()
    }

    #[test]
    fn groups_are_full_neither_too_much_nor_too_little() {
        let seed = Random::seed(5);
        let mut random = Random::new(seed);
        for round in 0..3000 {
            let capacity = [BLOCK, WIDTH][round % 2];
            let count = 1 + random.below(MOST / capacity);
            let len = count + random.below(count * (capacity - 1) + 1);
            let mut items = boxes(&mut random, len);
            if round % 5 == 0 {
                items[0] = Item { tag: 0, ..Item::EMPTY };
                items.iter_mut().skip(len / 2).for_each(|i| (i.lo, i.hi) = (Vec4::ONE, Vec4::ONE));
            }
            let groups = regroup(&mut items, count, capacity);
            let lengths: Vec<usize> = groups.lengths().collect();
            assert_eq!((lengths.len(), lengths.iter().sum()), (count, len), "seed {seed}, round {round}");
            assert!(lengths.iter().all(|l| (1..=capacity).contains(l)), "seed {seed}, round {round}: {lengths:?}");
            let mut tags: Vec<u32> = items.iter().map(|i| i.tag).collect();
            tags.sort_unstable();
            assert!(
                tags.iter().enumerate().all(|(i, &tag)| i as u32 == tag),
                "seed {seed}, round {round}: all are there"
            );
        }
    }

    #[test]
    fn clusters_are_found() {
        let mut random = Random::new(Random::seed(6));
        let mut items = boxes(&mut random, 40);
        for (i, item) in items.iter_mut().enumerate() {
            let to = Vec4::splat((i * 3 % 8) as f32 * 10.0);
            (item.lo, item.hi) = (item.lo + to, item.hi + to);
        }
        let groups = regroup(&mut items, 8, WIDTH);
        let mut at = 0;
        for len in groups.lengths() {
            assert!(len == 5 && around(&items[at..at + len]).half_area() < 20.0, "{items:?}");
            at += len;
        }
    }
}
