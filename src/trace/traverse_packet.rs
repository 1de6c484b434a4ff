//! A packet of up to 64 rays through one 8-wide tree.
//!
//! ```text
//! loop: pop a child and the rays that enter it; drop those that have found something nearer
//!       leaf              → triangles (packet_triangles)
//!       few rays left     → the single-ray kernel, below this child
//!       node, rays dense  → one interval test of all children for the whole packet; then 8 rays at a time against each child left
//!       node, rays sparse → ray by ray against all children
//! ```
//!
//! Sharing of node fetches between rays and the bounds test of the whole packet are those of Wald et al. (*Ray Tracing Deformable Scenes using Dynamic
//! BVHs*, 2007) and Reshetov et al. (*Multi-Level Ray Tracing*, 2005), with interval arithmetic for origins and reciprocal directions
//! (Boulos et al. 2006); going ray by ray over a shared node is the stream traversal of Wald et al. (2007) and
//! Barringer and Akenine-Möller (2014). Rays of different direction signs go one after the other.
//!
//! Measured (see `packet_batch` for the scenes): prefetching what goes to the stack gives 3 to 10 %, which it does not for one ray: here a child is
//! rarely left out. The interval test of the packet needs its bounds in lanes; ray by ray they cost a tenth of the time.
//! Giving up to four or six rays to the single-ray kernel, rather than the last one, is 5 to 10 % faster for bounces (it was slower when that kernel took a
//! sixth more instructions); ten are too many. So is [`ONE_RAY`] by [`EIGHT_RAYS`], another 5 %; [`DENSE`] alone, from 1.5 to 3, changes little.
//!
//! Instructions per ray (cloth of 92,000 triangles): camera rays 305, shadow rays 530, diffuse bounces 860. To leave out the test
//! of a child that is a node, once its interval is met, takes fewer instructions and is no faster. To give bounces to the single-ray kernel from the root on takes as many instructions and is slower, more so on large meshes, where
//! packets share what they fetch. Rays of packets that soon fall apart take turns instead ([`super::turns`]).

use super::packet::{Found, groups_of};
use super::packet_boxes::{Bounds, Slabs, best_range, ray_by_ray, still_before};
use super::stack::STACK;
use crate::accel::{ChildRef, Node8, WIDTH};
use crate::simd::{Isa, Vector, bits};
use std::mem::MaybeUninit;

/// From this many rays per vector the node is tested against the whole packet.
const DENSE: u32 = 2;
/// What is left of the node then is tested in vectors of rays or ray by ray, whichever takes fewer instructions: so many for one ray and all children, and
/// so many for a vector of eight rays and one child.
const ONE_RAY: u32 = 45;
const EIGHT_RAYS: u32 = 28;

/// A child to come back to, with the rays that enter it, none of them before `enter`.
#[derive(Clone, Copy)]
struct Pending {
    rays: u64,
    enter: f32,
    child: ChildRef,
}

/// What rays that go together have in common.
#[derive(Clone, Copy)]
pub(super) struct Alike {
    /// The axes on which their directions are below 0.
    pub down: [bool; 3],
    /// Whether all begin at one point.
    pub one_origin: bool,
}

/// Where the nodes of a tree are.
pub(super) trait Nodes {
    /// # Safety
    /// - It is a node of the tree, to which a child refers that has been visited, or the root.
    unsafe fn node(&self, index: usize) -> &Node8;
}

impl Nodes for [Node8] {
    #[inline(always)]
    unsafe fn node(&self, index: usize) -> &Node8 {
        // SAFETY: the caller's promise.
        unsafe { self.get_unchecked(index) }
    }
}

/// What hangs below the leaves of a tree.
pub(super) trait Leaves<I: Isa> {
    /// Rays up to this many are given to [`Leaves::alone`].
    const FEW: u32;

    /// The node to go on to, if a leaf stands for one.
    ///
    /// # Safety
    /// - `leaf` is of the tree.
    #[inline(always)]
    unsafe fn lead(&self, _leaf: ChildRef) -> Option<ChildRef> {
        None
    }

    /// Tests the rays of `mask` against a leaf. Returns whether a best hit was replaced.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`; `leaf` is of the tree.
    unsafe fn test(&mut self, leaf: ChildRef, mask: u64, alike: Alike, found: &mut Found) -> bool;

    /// One ray from `child` down, whose direction is below 0 on the axes of `down`.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`; `child` is of the tree.
    unsafe fn alone(&mut self, child: ChildRef, r: usize, down: [bool; 3], found: &mut Found);

    /// Takes the rays of `mask`, of one octant, from the root down in another way than as a packet, if that seems better. Returns whether it did.
    ///
    /// # Safety
    /// - The processor has the instruction set `I`.
    #[inline(always)]
    unsafe fn apart(&mut self, _mask: u64, _down: [bool; 3], _found: &mut Found) -> bool {
        false
    }

    /// Learns that of the so many rays of a packet one went on alone so many times.
    #[inline(always)]
    fn went_alone(&mut self, _rays: u32, _alone: u32, _found: &mut Found) {}

    /// Says that `child` will be visited soon.
    fn prefetch(&self, child: ChildRef);
}

/// Takes the rays in `mask` through the tree of `nodes` from `root` down, octant by octant.
///
/// # Safety
/// - The processor has the instruction set `I`.
/// - `nodes` are a tree: children are nodes of it or leaves, no path has more than `MAX_DEPTH` nodes. `root` is one of them.
#[inline(always)]
pub(super) unsafe fn traverse_packet<I: Isa, L: Leaves<I>>(
    nodes: &(impl Nodes + ?Sized),
    root: ChildRef,
    slabs: &Slabs,
    negative: &[u64; 3],
    mask: u64,
    leaves: &mut L,
    found: &mut Found,
) {
    let mut rest = mask;
    while rest != 0 {
        let first = rest.trailing_zeros();
        let (mut same, mut down) = (rest, [false; 3]);
        for k in 0..3 {
            down[k] = negative[k] >> first & 1 == 1;
            same &= if down[k] { negative[k] } else { !negative[k] };
        }
        rest &= !same;
        // SAFETY: the caller's promise.
        unsafe {
            if same.count_ones() <= L::FEW {
                for r in bits(same) {
                    leaves.alone(root, r, down, found);
                }
            } else if !leaves.apart(same, down, found) {
                let alone = octant::<I, L>(nodes, root, slabs, same, down, leaves, found);
                leaves.went_alone(same.count_ones(), alone, found);
            }
        }
    }
}

/// The rays in `mask`, whose directions have the signs of `down`. Returns how many times one of them went on alone.
///
/// # Safety
/// - As [`traverse_packet`].
#[inline(always)]
unsafe fn octant<I: Isa, L: Leaves<I>>(
    nodes: &(impl Nodes + ?Sized),
    root: ChildRef,
    slabs: &Slabs,
    mask: u64,
    down: [bool; 3],
    leaves: &mut L,
    found: &mut Found,
) -> u32 {
    let mut alone = 0;
    let mut stack = [const { MaybeUninit::<Pending>::uninit() }; STACK];
    stack[0].write(Pending { rays: mask, enter: 0.0, child: root });
    let mut depth = 1usize;
    // SAFETY: the caller's promise, for all vector operations and for the references; every visited node replaces
    // one reference by at most WIDTH, so the stack holds at most STACK, and entries below `depth` have been written.
    unsafe {
        let bounds = Bounds::<I>::new(slabs, mask, down);
        let alike = Alike { down, one_origin: bounds.one_origin };
        // Of the best distances.
        let (mut least, greatest) = best_range::<I>(found, mask);
        let mut farthest = I::F8::splat(greatest);
        while depth > 0 {
            depth -= 1;
            let Pending { rays, enter, mut child } = stack.get_unchecked(depth).assume_init();
            let mut rays = rays & found.open;
            if enter > least {
                rays = still_before::<I>(found, rays, enter);
            }
            if rays == 0 {
                continue;
            }
            if child.is_leaf() {
                let Some(node) = leaves.lead(child) else {
                    if leaves.test(child, rays, alike, found) {
                        let (nearest, greatest) = best_range::<I>(found, mask);
                        (least, farthest) = (nearest, I::F8::splat(greatest));
                    }
                    continue;
                };
                child = node;
            }
            if rays.count_ones() <= L::FEW {
                alone += rays.count_ones();
                for r in bits(rays) {
                    leaves.alone(child, r, down, found);
                }
                continue;
            }
            let node = nodes.node(child.index());
            let base = depth;
            let (count, vectors) = (rays.count_ones(), groups_of(rays).count_ones());
            let (mut candidates, mut by_all, mut distance, mut in_lanes) = (0, 0, [0.0; WIDTH], false);
            if count >= DENSE * vectors {
                (candidates, by_all, distance) = bounds.test(node, I::F8::splat(least), farthest);
                in_lanes = (candidates & !by_all).count_ones() * vectors * EIGHT_RAYS <= count * ONE_RAY;
            }
            if in_lanes {
                for lane in bits(u64::from(candidates)).map(|lane| lane % WIDTH) {
                    let entering =
                        if by_all >> lane & 1 == 1 { rays } else { bounds.entering(slabs, found, rays, node, lane) };
                    if entering != 0 {
                        let next = Pending { rays: entering, enter: distance[lane], child: node.children[lane] };
                        leaves.prefetch(next.child);
                        push(&mut stack, base, &mut depth, next);
                    }
                }
            } else {
                let (entering, distance) = ray_by_ray::<I>(slabs, found, rays, node, bounds.near);
                for lane in 0..WIDTH {
                    if entering[lane] != 0 {
                        let next = Pending { rays: entering[lane], enter: distance[lane], child: node.children[lane] };
                        leaves.prefetch(next.child);
                        push(&mut stack, base, &mut depth, next);
                    }
                }
            }
        }
    }
    alone
}

/// Puts a child of the current node on the stack, below those of its siblings (from `base`) that are nearer.
///
/// # Safety
/// - Entries below `depth` have been written, and there is room for one more.
#[inline(always)]
unsafe fn push(stack: &mut [MaybeUninit<Pending>; STACK], base: usize, depth: &mut usize, next: Pending) {
    let mut at = *depth;
    // SAFETY: the caller's promise.
    unsafe {
        while at > base && stack.get_unchecked(at - 1).assume_init_ref().enter < next.enter {
            *stack.get_unchecked_mut(at) = *stack.get_unchecked(at - 1);
            at -= 1;
        }
        stack.get_unchecked_mut(at).write(next);
    }
    *depth += 1;
}
