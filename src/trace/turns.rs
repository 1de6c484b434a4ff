//! Rays that share nothing take turns in one 8-wide tree: a step of one, then a step of another.
//!
//! ```text
//! turn: done   → new rays take the place of those at their end
//!       nodes  → every ray at a node tests all children, goes to the nearest, and leaves the others on its stack
//!       leaves → every ray at a leaf tests its triangles and goes back to what it left
//!       missed → those that hit no child go back likewise
//! ```
//!
//! The next node of one ray is known only when the boxes of this one have been tested: some forty cycles from address to address, or hundreds if
//! it comes from memory, in which a processor that follows one ray has little else to do. And where it guesses, it often guesses wrong: whether a
//! child is hit, and how many, is hard to foresee. So [`SLOTS`] rays go at the same time, as queries to an index do when they are
//! interleaved by hand (Kocberber, Falsafi, Grot, *Asynchronous Memory Access Chaining*, 2015). What a ray needs next is prefetched, and the others
//! take their steps until it has come. The step of a node has no branch on what was hit: the nearest child is found by a minimum over lanes, the
//! others are packed to the stack in the order of their lanes, and a ray goes to one list or another by adding 0 or 1 to their lengths.
//! Lists are of addresses, a slot has its stack within it and the address that it goes to: a tenth of the instructions was to work these out from numbers.
//!
//! Where the others are popped, the nearest of them is not always first. That costs visits, no hits (hits do not depend on the order).
//!
//! # Measured
//!
//! Diffuse bounces, one thread, against the better of one ray at a time and packets: 1.35 times the rays per second in a soup of triangles, 1.2 among
//! trees, 1.15 among small spheres, and no difference on a bumpy sphere; with 1.4 to 1.55 times the instructions that one ray at a time takes.
//! Rows of planes known at compile time, per octant, give a tenth.
//!
//! *Tried*: children sorted as for one ray, with branches on how many were hit, and two of a node's four cache lines asked for, each a tenth
//! slower in the soup; the second nearest child on top of the stack (fewer visits for more instructions, no gain); eight rays (a seventh slower), 12, 16 and 32 (a few per cent); no
//! prefetching, in an earlier attempt (40 % slower than packets).
//!
//! # When
//!
//! Rays that stay together are better off in a packet ([`super::traverse_packet`]), which shares what it fetches. Bounces in a soup do not, those
//! from a cloth into the open do, and nothing seen beforehand tells one from the other. So it is measured: how many times a packet leaves a few
//! rays to go on alone, per ray, tells the seven scenes of the bench apart (median 0.3 on the cloth, where packets are 1.3 times as fast, 0.7 where both are alike,
//! 0.9 to 3.6 where turns are up to 1.5 times as fast). [`Habits`] keeps that in mind for packets whose directions differ much and for those that do not.
//! To look again with one packet in 16 cost up to 8 %, as each batch began anew; so habits outlive a batch, and probes become rare.
//!
//! *Tried besides*: rays read where they are in the packet, rather than copied to the slot's own lines (8 % slower); lists chosen by number, a tenth fewer
//! instructions, but lengths in memory (10 to 15 % slower, as each push waits for the last); a branch for rays that hit no child of a node, one in twelve to twenty (a
//! tenth fewer instructions, 5 to 8 % slower, as a wrong guess throws away the steps of others); packets that give the rays they leave behind to turns at their end (6 % faster
//! than packets where those are many, and slower than turns from the root; 6 to 13 % slower where they are few, as hits come late).

use super::ground::{Ground, Lead};
use super::packet::{Found, GROUPS, LANES, Packet, RAYS, load3};
use super::shells::Shells;
use super::triangle4::{Edges, RayLanes, edges4};
use super::{Hit, PreparedRay, SLAB_PAD};
use crate::accel::{ChildRef, Node8, Tri4, WIDTH};
use crate::simd::{Eight, Isa, Vector, prefetch_at};
use std::hint::select_unpredictable;
use std::mem::{MaybeUninit, take};

/// Rays at the same time.
const SLOTS: usize = 24;

/// Children that a ray can leave behind. Those of very deep trees may leave more: such a ray starts over, alone. Few in unit tests, so that they
/// see it happen.
const STACK: usize = if cfg!(test) { 9 } else { 56 };

/// Difference of the shares that an axis has in the directions of two rays of a packet, from which on they differ much.
const APART: f32 = 0.5;

/// So many times do the rays of a packet go on alone, on average, where taking turns is better; and where any hit will do, which a packet's rays find together
/// and then leave.
const OFTEN_ALONE: f32 = 0.8;
const OFTEN_ALONE_ANY: f32 = 1.1;

/// After so many packets whose rays took turns one is traced as a packet all the same, to see whether that has changed; after twice as many if it has not,
/// and so on up to the second number.
const PROBE: u32 = 16;
const RARE_PROBE: u32 = 256;

/// Packets whose mean counts, about.
const REMEMBERED: f32 = 16.0;

/// What packets were like lately: whatever they do next changes how long it takes, and no hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Habits {
    /// How many times a ray went on alone, and from when on that is too often.
    alone: f32,
    often: f32,
    /// Packets until the next probe, and from that one to the one after it.
    wait: u32,
    pause: u32,
}

impl Habits {
    /// Undecided: the first packet tips the scale.
    const CLOSEST: Habits = Habits { alone: OFTEN_ALONE, often: OFTEN_ALONE, wait: PROBE, pause: PROBE };
    const ANY: Habits = Habits { alone: OFTEN_ALONE_ANY, often: OFTEN_ALONE_ANY, ..Self::CLOSEST };

    /// Of nothing seen yet: of rays that look for the closest hit and of those that look for any, whose directions are alike and whose are not.
    pub(super) const NONE: [[Habits; 2]; 2] = [[Self::CLOSEST; 2], [Self::ANY; 2]];

    /// Whether the rays of the next packet should take turns.
    #[inline]
    pub(super) fn are_to_part(&mut self) -> bool {
        if self.alone <= self.often {
            return false;
        }
        if self.wait == 0 {
            self.pause = RARE_PROBE.min(2 * self.pause);
            self.wait = self.pause;
            return false;
        }
        self.wait -= 1;
        true
    }

    /// In a packet of `rays`, so many times one of them went on alone.
    #[inline]
    pub(super) fn saw(&mut self, rays: u32, alone: u32) {
        let share = alone as f32 / rays as f32;
        self.alone += (share - self.alone) / REMEMBERED;
        if share <= self.often {
            (self.wait, self.pause) = (self.wait.min(PROBE), PROBE);
        }
    }
}

/// One ray on its way.
#[repr(C, align(64))]
struct Slot<I: Isa> {
    org: [f32; 3],
    tmin: f32,
    /// Of opposite sign, as in `SlabLanes`.
    neg_inv_dir: [f32; 3],
    /// Distance of the best hit.
    best: f32,
    /// Where the node or the first block of `current` is.
    at: *const u8,
    current: ChildRef,
    /// Words on its stack.
    depth: u32,
    /// Number in the packet.
    number: u32,
    ray: PreparedRay,
    lanes: RayLanes<I>,
    /// Distances above, children below; written eight at a time.
    stack: [MaybeUninit<u64>; STACK + WIDTH],
}

/// A list of slots. No slot is in two of them, so there is room in each.
type List<I> = [*mut Slot<I>; SLOTS];

struct Lists<I: Isa> {
    at_node: List<I>,
    at_leaf: List<I>,
    /// Those that hit no child, and go back to their stack.
    missed: List<I>,
    /// Those that have nothing left.
    done: List<I>,
}

/// Their lengths, which are to stay in registers.
#[derive(Default)]
struct Lengths {
    at_node: usize,
    at_leaf: usize,
    missed: usize,
    done: usize,
}

/// Puts `slot` at the end of a list if `so` is 1 and not 0, without a branch.
///
/// # Safety
/// - There is room for one more.
#[inline(always)]
unsafe fn push_if<I: Isa>(list: &mut List<I>, len: &mut usize, slot: *mut Slot<I>, so: usize) {
    // SAFETY: the caller's promise.
    unsafe { *list.get_unchecked_mut(*len) = slot };
    *len += so;
}

/// All rays on their way.
struct Turns<'a, I: Isa, T> {
    tree: &'a T,
    root: ChildRef,
    /// See [`Ground::beginnings`].
    nodes: *const u8,
    blocks: *const u8,
    block: usize,
    lists: Lists<I>,
    /// Rays whose stack was too small, or that came where they cannot go on.
    stuck: u64,
}

/// Keeps what happens rarely out of the way of the rest.
#[cold]
#[inline(never)]
fn rarely() {}

/// Whether the directions of the rays in `mask`, all of one octant, differ much: those of its first and last groups.
///
/// # Safety
/// - The processor has the instruction set `I`; `mask` is not empty.
#[inline(always)]
pub(super) unsafe fn differ_much<I: Isa>(packet: &Packet, mask: u64) -> bool {
    let ends = [mask.trailing_zeros(), RAYS as u32 - 1 - mask.leading_zeros()];
    // SAFETY: the caller's promise.
    unsafe {
        let (infinity, zero) = (I::F8::splat(f32::INFINITY), I::F8::splat(0.0));
        let (mut least, mut most) = ([infinity; 3], [zero; 3]);
        for end in ends {
            let g = end as usize / LANES % GROUPS;
            let here = (mask >> (LANES * g)) as u32;
            let [x, y, z] = load3::<I>(&packet.dir, g);
            let (x, y, z) = (x.abs(), y.abs(), z.abs());
            let scale = I::F8::splat(1.0).div(x.add(y).add(z));
            let shares = [x.mul(scale), y.mul(scale), z.mul(scale)];
            for k in 0..3 {
                least[k] = shares[k].select_bits(infinity, here).min(least[k]);
                most[k] = shares[k].select_bits(zero, here).max(most[k]);
            }
        }
        let apart = |k: usize| most[k].greatest() - least[k].least() > APART;
        apart(0) || apart(1) || apart(2)
    }
}

/// Looks for hits of the rays of `packet` in `mask`, whose directions have the signs of `down`, below a node, by the contract of
/// `packet_object::traverse_object`. Returns the rays that have to be traced in another way.
///
/// # Safety
/// - The processor has the instruction set `I`; `root` is a node of the tree.
#[inline(always)]
pub(super) unsafe fn take_turns<I: Shells, const ANY: bool, T: Ground>(
    tree: &T,
    root: ChildRef,
    packet: &Packet,
    mask: u64,
    down: [bool; 3],
    numbers: (u32, u32),
    found: &mut Found,
) -> u64 {
    let mut slots = [const { MaybeUninit::<Slot<I>>::uninit() }; SLOTS];
    let slots = slots.as_mut_ptr().cast::<Slot<I>>();
    let none = [slots; SLOTS];
    let (nodes, blocks, block) = tree.beginnings();
    let mut turns = Turns::<I, T> {
        tree,
        root,
        nodes: nodes.cast(),
        blocks,
        block,
        lists: Lists { at_node: none, at_leaf: none, missed: none, done: none },
        stuck: 0,
    };
    let mut rest = mask;
    let mut ends = Lengths::default();
    // SAFETY: the caller's promise. Slots are begun before they are put into a list other than that of those that are done.
    unsafe {
        for slot in 0..SLOTS {
            push_if(&mut turns.lists.done, &mut ends.done, slots.add(slot), 1);
        }
        let octant = usize::from(down[0]) | usize::from(down[1]) << 1 | usize::from(down[2]) << 2;
        loop {
            turns.begin(&mut ends, packet, &mut rest, found);
            if ends.at_node + ends.at_leaf + ends.missed == 0 {
                return turns.stuck;
            }
            match octant {
                0 => turns.nodes::<0>(&mut ends),
                1 => turns.nodes::<1>(&mut ends),
                2 => turns.nodes::<2>(&mut ends),
                3 => turns.nodes::<3>(&mut ends),
                4 => turns.nodes::<4>(&mut ends),
                5 => turns.nodes::<5>(&mut ends),
                6 => turns.nodes::<6>(&mut ends),
                _ => turns.nodes::<7>(&mut ends),
            }
            turns.leaves::<ANY>(&mut ends, numbers, found);
            for i in 0..take(&mut ends.missed) {
                let slot = *turns.lists.missed.get_unchecked(i);
                turns.back::<ANY>(&mut ends, slot);
            }
        }
    }
}

/// What the triangles of `block` that are `candidates` say. Returns whether the ray has finished.
///
/// Rare, and not inlined so that nothing of it is worked out beforehand.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(never)]
unsafe fn resolve<I: Shells, const ANY: bool>(
    slot: &mut Slot<I>,
    block: &Tri4,
    (candidates, edges): (u32, &Edges<I>),
    numbers: (u32, u32),
    found: &mut Found,
) -> bool {
    let number = slot.number as usize % RAYS;
    // SAFETY: the caller's promise.
    unsafe {
        if ANY {
            let none = &mut Hit::none(slot.best);
            let is_hit = I::resolve::<true, _>(&slot.ray, block, candidates, edges, numbers, none);
            if is_hit {
                found.open &= !(1 << number);
                slot.depth = 0;
            }
            return is_hit;
        }
        let best = &mut found.hits[number];
        if I::resolve::<false, _>(&slot.ray, block, candidates, edges, numbers, best) {
            slot.best = best.t;
            found.t[number / LANES][number % LANES] = slot.best;
        }
        false
    }
}

impl<I: Shells, T: Ground> Turns<'_, I, T> {
    /// Puts the next rays of `rest` at the root, in the slots that are done.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn begin(&mut self, ends: &mut Lengths, packet: &Packet, rest: &mut u64, found: &Found) {
        while ends.done != 0 && *rest != 0 {
            ends.done -= 1;
            let number = rest.trailing_zeros() as usize % RAYS;
            *rest &= *rest - 1;
            let best = found.t[number / LANES % GROUPS][number % LANES];
            let ray = packet.ray(number, best);
            // SAFETY: the caller's promise; the list has been written up to here, and what is in it is in no other; the fields are those of one slot.
            unsafe {
                let slot = *self.lists.done.get_unchecked(ends.done);
                (*slot).org = ray.org.to_array();
                (*slot).tmin = ray.tmin;
                (*slot).neg_inv_dir = (-ray.inv_dir).to_array();
                (*slot).best = best;
                (*slot).depth = 0;
                (*slot).number = number as u32;
                (*slot).lanes = RayLanes::<I>::new(&ray);
                (*slot).ray = ray;
                self.send(ends, slot, self.root, true);
            }
        }
    }

    /// Sends a slot to `child` where `so`, and has that fetched.
    ///
    /// # Safety
    /// - `slot` has begun.
    #[inline(always)]
    unsafe fn send(&mut self, ends: &mut Lengths, slot: *mut Slot<I>, child: ChildRef, so: bool) {
        let so = usize::from(so);
        let leaf = usize::from(child.is_leaf()) & so;
        // Where nothing was hit the child is any of the node's, or none: an address all the same.
        let base = select_unpredictable(child.is_leaf(), self.blocks, self.nodes);
        let size = select_unpredictable(child.is_leaf(), self.block, size_of::<Node8>());
        let at = base.wrapping_add(child.blocks().start * size);
        // SAFETY: the caller's promise.
        unsafe {
            (*slot).current = child;
            (*slot).at = at;
            push_if(&mut self.lists.at_leaf, &mut ends.at_leaf, slot, leaf);
            push_if(&mut self.lists.at_node, &mut ends.at_node, slot, so - leaf);
        }
        // A node's four lines hold a block's three.
        prefetch_at(at.cast::<Node8>());
    }

    /// A step of every ray at a node. Bit `k` of `DOWN`: directions are negative along axis `k`.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn nodes<const DOWN: usize>(&mut self, ends: &mut Lengths) {
        let near = [DOWN & 1, 2 + (DOWN >> 1 & 1), 4 + (DOWN >> 2 & 1)];
        let count = take(&mut ends.at_node);
        for i in 0..count {
            // SAFETY: the caller's promise; a slot in a list has begun, and its node is one of the tree; on its stack is room for the words of eight children;
            // a `ChildRef` is an u32.
            unsafe {
                // The list is written up to here at most.
                let s = *self.lists.at_node.get_unchecked(i);
                let slot = &mut *s;
                let node = &*slot.at.cast::<Node8>();
                let (mut enter, mut exit) = (I::F8::splat(slot.tmin), I::F8::splat(slot.best));
                for (k, near) in near.into_iter().enumerate() {
                    let (org, inv) = (I::F8::splat(slot.org[k]), I::F8::splat(slot.neg_inv_dir[k]));
                    enter = org.sub(I::F8::load(&node.bounds[near])).mul(inv).max(enter);
                    exit = org.sub(I::F8::load(&node.bounds[near ^ 1])).mul(inv).min(exit);
                }
                let (mut mask, nearest) = enter.nearest_le(exit.mul(I::F8::splat(SLAB_PAD)));
                let mut depth = slot.depth as usize;
                if depth > STACK {
                    // Nothing is lost of what it has found.
                    rarely();
                    self.stuck |= 1 << slot.number;
                    (mask, depth) = (0, 0);
                }
                let others = mask & !(1 << nearest);
                let free = &mut *slot.stack.as_mut_ptr().add(depth).cast::<[MaybeUninit<u64>; WIDTH]>();
                enter.pack_words(&*(&raw const node.children).cast::<[u32; WIDTH]>(), others, free);
                slot.depth = depth as u32 + others.count_ones();
                push_if(&mut self.lists.missed, &mut ends.missed, s, usize::from(mask == 0));
                self.send(ends, s, *node.children.get_unchecked(nearest), mask != 0);
            }
        }
    }

    /// The triangles of every ray at a leaf, which then goes back; or on, where a leaf leads to a node.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn leaves<const ANY: bool>(&mut self, ends: &mut Lengths, numbers: (u32, u32), found: &mut Found) {
        let count = take(&mut ends.at_leaf);
        for i in 0..count {
            let tree = self.tree;
            // SAFETY: the caller's promise; a slot in a list has begun, and its leaf is one of the tree.
            unsafe {
                let s = *self.lists.at_leaf.get_unchecked(i);
                let slot = &mut *s;
                let leaf = slot.current;
                match tree.lead(leaf) {
                    Lead::On(node) => {
                        self.send(ends, s, node, true);
                        continue;
                    }
                    Lead::Elsewhere => {
                        rarely();
                        slot.depth = 0;
                        self.stuck |= 1 << slot.number;
                    }
                    Lead::Blocks => {
                        for block in tree.blocks_at(leaf, slot.at) {
                            let block = &*block;
                            let Some((candidates, edges)) = edges4(&slot.lanes, block) else { continue };
                            if resolve::<I, ANY>(slot, block, (candidates, &edges), numbers, found) {
                                break;
                            }
                        }
                    }
                }
                self.back::<ANY>(ends, s);
            }
        }
    }

    /// Sends a slot to what it has left.
    ///
    /// # Safety
    /// - `slot` has begun.
    #[inline(always)]
    unsafe fn back<const ANY: bool>(&mut self, ends: &mut Lengths, s: *mut Slot<I>) {
        // SAFETY: the caller's promise; what is below `depth` was written.
        unsafe {
            let slot = &mut *s;
            let (limit, mut depth) = (slot.best * SLAB_PAD, slot.depth as usize);
            loop {
                if depth == 0 {
                    push_if(&mut self.lists.done, &mut ends.done, s, 1);
                    return;
                }
                depth -= 1;
                let word = slot.stack.get_unchecked(depth).assume_init();
                if ANY || f32::from_bits((word >> 32) as u32) <= limit {
                    slot.depth = depth as u32;
                    self.send(ends, s, ChildRef::from_bits(word as u32), true);
                    return;
                }
            }
        }
    }
}
