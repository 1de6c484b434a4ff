//! One ray through one object BSP (Wald03 §4.2).
//!
//! ```text
//! loop: node  → the distances of its seven planes → the ray's interval in each of the eight cells → to the nearest cell that is met, others to the stack
//!       leaf  → its triangles, four at a time
//!       next  → pop; stop when a cell begins beyond the best hit
//! ```
//!
//! Going down, the far side of a plane begins at its distance and the near side ends there; which side is near is told by the sign of the direction and not by
//! the origin's side, for a ray in the plane. A cell is met if its interval is not empty. A triangle in several cells is tested in each.
//!
//! # Why no hit is lost
//!
//! Let `t` be the hit that wins, on triangle T, and u half an ulp. *By induction the ray goes down with `enter <= t (1 + 16 u)` and `exit >= t (1 - 16 u)` to a leaf
//! that refers to T*; as [`BSP_PAD`] is more than the ratio of both and a cell is left out only for `enter > best t * BSP_PAD`, that leaf is visited
//! before the search ends, and equal distances are still compared by number. At a plane with distance `s`:
//!
//! * *A box around all of T is on one side.* The clamped `t` lies in the ray's interval in it, up to `SLAB_PAD`, and slab distances are monotone in the plane. So
//!   the plane does not cut `t` off.
//! * *T was cut before* (`accel/spatial`). Let X be the exact point of T that was hit, and e T's largest side. The ray passes it by 6 u e and
//!   by what is relative to its way; `t` is off by up to 1536 u e in its direction and by relative 10 u. What is left of T on one side of the plane ends a pad
//!   of 2048 u e before it. If it holds X, then `s` is on the other side of `t` but for 15 u.
//! * *Both sides refer to T*, or so they do because X is nearer to the plane than the pad: then the side is taken on which `s` leaves `t`, and it is right exactly.
//! * A cut keeps X on each side of which it is not a pad away.

use super::gathered::gather;
use super::one_ray::OneRay;
use super::shells::Shells;
use super::triangle4::{RayLanes, edges4};
use super::{Hit, PreparedRay, SLAB_PAD, triangle};
use crate::accel::{BSP_MAX_NODES, Bsp, BspNode, BspPart, BspTree, ChildRef, Corners, LEVELS, WIDTH};
use crate::simd::{Eight, Isa, Vector};
use std::mem::MaybeUninit;

/// By how much an interval is taken for longer than it is: see the module head.
const BSP_PAD: f32 = 1.0 + 40.0 * (f32::EPSILON * 0.5);

/// A cell to come back to, and the ray's interval in it.
#[derive(Clone, Copy)]
pub(super) struct Pending {
    pub enter: f32,
    pub exit: f32,
    pub child: ChildRef,
}

/// A node leaves all cells but one on the stack, and they are of one path.
const STACK: usize = BSP_MAX_NODES * (WIDTH - 1) + 1;

/// Written below the `depth` that goes with it.
pub(super) type BspStack = [MaybeUninit<Pending>; STACK];

/// Nothing written.
pub(super) const EMPTY_STACK: BspStack = [const { MaybeUninit::uninit() }; STACK];

/// Which plane of a node cuts a lane at each level, in the bits of a number.
static PLANE_OF: [[f32; WIDTH]; LEVELS] = {
    let planes = [[0; WIDTH], [1, 1, 1, 1, 2, 2, 2, 2], [3, 3, 4, 4, 5, 5, 6, 6]];
    let mut bits = [[0.0; WIDTH]; LEVELS];
    let mut i = 0;
    while i < LEVELS * WIDTH {
        bits[i / WIDTH][i % WIDTH] = f32::from_bits(planes[i / WIDTH][i % WIDTH]);
        i += 1;
    }
    bits
};
/// Which side of it the lane is on: 1 above, -1 below.
static SIDE: [[f32; WIDTH]; LEVELS] = [
    [-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0],
    [-1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0],
    [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0],
];

/// A ray's numbers by axis, twice; those of the fourth "axis" are 0.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct AxisTable([f32; 8]);

impl AxisTable {
    #[inline(always)]
    fn new(of: impl Fn(usize) -> f32) -> Self {
        let (x, y, z) = (of(0), of(1), of(2));
        Self([x, y, z, 0.0, x, y, z, 0.0])
    }
}

/// What planes ask of a ray.
#[derive(Clone, Copy)]
pub(super) struct PlaneRay {
    org: AxisTable,
    inv_dir: AxisTable,
}

impl PlaneRay {
    #[inline(always)]
    pub(super) fn new(ray: impl OneRay) -> Self {
        Self { org: AxisTable::new(|k| ray.org(k)), inv_dir: AxisTable::new(|k| ray.inv_dir(k)) }
    }
}

/// The interval in which a ray is in the box of everything; `None` if it misses it before `limit`.
#[inline(always)]
pub(super) fn interval(bsp: &Bsp, ray: &PreparedRay, limit: f32) -> Option<(f32, f32)> {
    let bounds = bsp.bounds();
    let (enter, exit) = ray.slab(&bounds);
    let enter = if ray.tmin > enter { ray.tmin } else { enter };
    let exit = if limit < exit { limit } else { exit };
    // Written so that an empty object's NaN or infinities fail.
    (!bounds.is_empty() && enter <= exit * SLAB_PAD).then_some((enter, exit))
}

/// The cells of a node that a ray meets in an interval before `limit`: leaves all on the stack but the nearest, which it returns.
///
/// # Safety
/// - The processor has the instruction set `I`.
/// - Nodes are visited from the root of one tree down, and each but the root comes from this stack: so there is room, and what is below
///   `depth` has been written.
#[inline(always)]
pub(super) unsafe fn meet<I: Isa>(
    node: &BspNode,
    ray: &PlaneRay,
    (from, to): (f32, f32),
    limit: f32,
    stack: &mut BspStack,
    depth: &mut usize,
) -> Option<Pending> {
    // SAFETY: the caller's promise; lanes are below WIDTH.
    unsafe {
        let planes = I::F8::load(node.rows());
        let inv = I::F8::load(&ray.inv_dir.0).pick(planes);
        let distances = planes.sub(I::F8::load(&ray.org.0).pick(planes)).mul(inv);
        let (mut enter, mut exit) = (I::F8::splat(from), I::F8::splat(to));
        let (zero, infinity) = (I::F8::splat(0.0), I::F8::splat(f32::INFINITY));
        for level in 0..LEVELS {
            let which = I::F8::load(&PLANE_OF[level]);
            let distance = distances.pick(which);
            // Not below 0 on the far side, and without a plane.
            let way = inv.pick(which).mul(I::F8::load(&SIDE[level]));
            enter = zero.select_le(way, distance, I::F8::splat(f32::NEG_INFINITY)).max(enter);
            exit = zero.select_le(way, infinity, distance).min(exit);
        }
        let end = exit.mul(I::F8::splat(BSP_PAD)).min(I::F8::splat(limit * BSP_PAD));
        let mut mask = enter.le(end) & node.used();
        if mask == 0 {
            return None;
        }
        let (mut enters, mut exits) = ([0.0f32; WIDTH], [0.0f32; WIDTH]);
        enter.store(&mut enters);
        exit.store(&mut exits);
        let children = node.children();
        let entry = |mask: u32| {
            let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
            Pending {
                enter: *enters.get_unchecked(lane),
                exit: *exits.get_unchecked(lane),
                child: *children.get_unchecked(lane),
            }
        };
        // Insertion from the top: the nearest stays in `carried`.
        let base = *depth;
        let mut carried = entry(mask);
        mask &= mask - 1;
        while mask != 0 {
            let next = entry(mask);
            mask &= mask - 1;
            let (near, far) = if next.enter < carried.enter { (next, carried) } else { (carried, next) };
            carried = near;
            let mut at = *depth;
            while at > base && stack.get_unchecked(at - 1).assume_init_ref().enter < far.enter {
                *stack.get_unchecked_mut(at) = *stack.get_unchecked(at - 1);
                at -= 1;
            }
            stack.get_unchecked_mut(at).write(far);
            *depth += 1;
        }
        Some(carried)
    }
}

/// Takes the next cell off that does not begin beyond the best hit.
///
/// # Safety
/// - What is below `depth` has been written.
#[inline(always)]
pub(super) unsafe fn pop(stack: &BspStack, depth: &mut usize, best: f32) -> Option<Pending> {
    while *depth > 0 {
        *depth -= 1;
        // SAFETY: the caller's promise.
        let next = unsafe { stack.get_unchecked(*depth).assume_init() };
        if next.enter <= best * BSP_PAD {
            return Some(next);
        }
    }
    None
}

/// Tests the triangles of a leaf; with `ANY` the first hit ends the test. Returns whether there was a hit that counts.
///
/// # Safety
/// - The processor has the instruction set `I`; the leaf is of the tree, and `lanes` are those of the ray.
#[inline(always)]
pub(super) unsafe fn test_leaf<I: Shells, const ANY: bool, R: OneRay>(
    tree: &BspTree,
    leaf: ChildRef,
    ray: R,
    lanes: &RayLanes<I>,
    numbers: (u32, u32),
    best: &mut Hit,
) -> bool {
    let mut found = false;
    // SAFETY: the caller's promise; blocks refer to triangles of the tree (its invariants).
    unsafe {
        for refs in tree.blocks().get_unchecked(leaf.blocks()) {
            let block = gather(tree.triangles(), *refs);
            let Some((candidates, edges)) = edges4(lanes, &block) else { continue };
            found |= I::resolve::<ANY, _>(ray, &block, candidates, &edges, numbers, best);
            if ANY && found {
                return true;
            }
        }
    }
    found
}

/// Looks for hits of `ray` in `bsp`, by the contract of [`super::traverse_bvh::traverse`].
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn traverse<I: Shells, const ANY: bool>(
    bsp: &Bsp,
    ray: &PreparedRay,
    numbers: (u32, u32),
    best: &mut Hit,
) -> bool {
    let Some(whole) = interval(bsp, ray, best.t) else { return false };
    let tree = match bsp.part() {
        BspPart::Tree(tree) => tree,
        BspPart::List(triangles) => return one_after_another::<ANY>(triangles, ray, numbers, best),
    };
    let mut stack: BspStack = EMPTY_STACK;
    let mut depth = 0;
    let mut found = false;
    let plane_ray = PlaneRay::new(ray);
    let mut current = Pending { enter: whole.0, exit: whole.1, child: ChildRef::ROOT };
    // SAFETY: the caller's promise. Nodes and leaves are the root or from the stack, hence of the tree, no path of which has more than
    // BSP_MAX_NODES nodes (its invariants).
    unsafe {
        let lanes = RayLanes::<I>::new(ray);
        loop {
            let mut next = None;
            if current.child.is_leaf() {
                found |= test_leaf::<I, ANY, _>(tree, current.child, ray, &lanes, numbers, best);
                if ANY && found {
                    return true;
                }
            } else {
                let node = tree.nodes().get_unchecked(current.child.index());
                next = meet::<I>(node, &plane_ray, (current.enter, current.exit), best.t, &mut stack, &mut depth);
            }
            let Some(next) = next.or_else(|| pop(&stack, &mut depth, best.t)) else { return found };
            current = next;
        }
    }
}

/// All triangles, where there is no tree.
#[cold]
pub(super) fn one_after_another<const ANY: bool>(
    triangles: &[Corners],
    ray: &PreparedRay,
    (object, instance): (u32, u32),
    best: &mut Hit,
) -> bool {
    let mut found = false;
    for triangle in triangles {
        let Some(h) = triangle::intersect(ray, triangle.corners()) else { continue };
        if ANY {
            return true;
        }
        if ray.excludes(h.t, instance, triangle.prim()) {
            continue;
        }
        found |= Hit { t: h.t, u: h.u, v: h.v, primitive: triangle.prim(), object, instance }.replaces(best);
    }
    found
}
