//! Rays through the tree of [`LazyBvh`], whose segments are brought up to date when a ray reaches them: one ray, a packet, or the rays of a packet in turn.
//!
//! The loops are those of [`super::traverse_bvh`], [`super::traverse_packet`] and [`super::turns`]. What is new is at the leaves. One beyond all blocks stands for a segment: its
//! stamp is looked at, and the loop goes on at its root as if that had been the child. So the stamp of a segment is looked at once per visit, and never in the loop
//! over nodes. And blocks refer to vertices, which are gathered when a block is tested.
//!
//! Where another thread is writing the segment, the ray gets a copy of it, which is a tree in another place ([`View`]): it is entered by a call of the same kernel
//! ([`Shells`]). A ray that takes turns with others starts over, alone.
//!
//! *Measured*: with turns, rays through nine bodies whose segments are up to date need 1.2 to 1.3 times what they need after a refit, at 5x5 and at 10x10; without,
//! 1.55 and 1.7 times (`cargo bench --bench papers -- larsson1`).
//!
//! *Tried*: every segment entered by a call. Bounds of the packet and of its best distances are then made again in each, and a ray per pixel on nine bodies took
//! a fifth longer (`cargo bench --bench papers -- larsson1`, 1x1).

use super::ground::{self, Blocks, Ground};
use super::one_ray::{InPacket, OneRay};
use super::packet::{Found, GROUPS, LANES, Packet};
use super::packet_boxes::Slabs;
use super::packet_triangles::intersect_leaf;
use super::shells::Shells;
use super::traverse_bvh::{Lead, SlabLanes, Tree, descend};
use super::traverse_packet::{Alike, Leaves, Nodes, traverse_packet};
use super::triangle4::RayLanes;
use super::turns::differ_much;
use super::{Hit, PreparedRay};
use crate::accel::{ChildRef, LazyBlock, LazyBvh, LazyPart, MAX_LEAF_BLOCKS, Node8, Tri4};
use crate::simd::{bits, corners_at, prefetch, prefetch_at};
use glam::Vec4;
use std::marker::PhantomData;
use std::mem::MaybeUninit;
use std::ops::Deref;

/// A lazy tree as a ray sees it: with one segment in another place, if that is private.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    lazy: &'a LazyBvh,
    /// Node and vertex number 0. Those that may be read are of segments that are up to date, or of the private one, whose references lead to it alone or to segments.
    nodes: *const Node8,
    vertices: *const Vec4,
}

impl<'a> View<'a> {
    fn shared(lazy: &'a LazyBvh) -> Self {
        let (nodes, vertices) = lazy.beginnings();
        Self { lazy, nodes, vertices }
    }

    fn private(lazy: &'a LazyBvh, part: LazyPart<'a>) -> Self {
        let LazyPart { nodes, vertices, first_node, first_vertex } = part;
        let nodes = nodes.as_ptr().wrapping_sub(first_node);
        let vertices = vertices.as_ptr().wrapping_sub(first_vertex);
        Self { lazy, nodes, vertices }
    }

    fn is_shared(&self) -> bool {
        self.nodes == self.lazy.beginnings().0
    }

    /// Where to go on at a segment, which is brought up to date. None if that is in another place: another thread is writing it, or this one is private.
    #[inline(always)]
    fn root_of(&self, segment: usize) -> Option<ChildRef> {
        let lazy = self.lazy;
        if !self.is_shared() {
            return None;
        }
        lazy.current_root(segment).or_else(|| lazy.touch(segment))
    }

    /// Four triangles with their corners.
    ///
    /// # Safety
    /// - The block is of a segment that may be read.
    #[inline(always)]
    unsafe fn gather(&self, block: &LazyBlock) -> Tri4 {
        // SAFETY: the caller's promise; corners are among the vertices of the block's segment (the invariants of the topology).
        let corners = unsafe { corners_at(self.vertices, &block.corners) };
        Tri4 { corners, prims: block.prims }
    }
}

impl Blocks for View<'_> {
    #[inline(always)]
    unsafe fn blocks(&self, leaf: ChildRef) -> impl Iterator<Item = impl Deref<Target = Tri4>> {
        // SAFETY: the caller's promise: the leaf has been reached and is of blocks.
        let run = unsafe { self.lazy.blocks().get_unchecked(leaf.blocks()) };
        // SAFETY: likewise.
        run.iter().map(|block| Gathered(unsafe { self.gather(block) }))
    }
}

/// With a leaf that leads nowhere where a segment is in another place.
impl Ground for View<'_> {
    #[inline(always)]
    unsafe fn lead(&self, leaf: ChildRef) -> ground::Lead {
        match self.lazy.segment_of_leaf(leaf) {
            None => ground::Lead::Blocks,
            Some(segment) => self.root_of(segment).map_or(ground::Lead::Elsewhere, ground::Lead::On),
        }
    }

    #[inline(always)]
    fn beginnings(&self) -> (*const Node8, *const u8, usize) {
        (self.nodes, self.lazy.blocks().as_ptr().cast(), size_of::<LazyBlock>())
    }
}

impl Nodes for View<'_> {
    #[inline(always)]
    unsafe fn node(&self, index: usize) -> &Node8 {
        // SAFETY: the caller's promise: it has been reached, so its segment may be read. See above on wrapping.
        unsafe { &*self.nodes.wrapping_add(index) }
    }
}

/// Looks for hits of `ray` in `lazy`, by the contract of [`super::Kernels::intersect`] or with `ANY` of [`super::Kernels::occluded`].
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn traverse<I: Shells, const ANY: bool>(
    lazy: &LazyBvh,
    ray: &PreparedRay,
    numbers: (u32, u32),
    best: &mut Hit,
) -> bool {
    // SAFETY: the caller's promise; a tree that is not empty has a segment.
    unsafe {
        !lazy.is_empty() && {
            let mut any = Hit::none(ray.tmax);
            let best = if ANY { &mut any } else { best };
            enter(lazy, 0, |view, root| I::lazy::<ANY>(&view, root, ray, numbers, best))
        }
    }
}

/// Likewise the rays of `mask`, by the contract of `packet_object::traverse_object`.
///
/// # Safety
/// - The processor has the instruction set `I`.
#[inline(always)]
pub(super) unsafe fn traverse_many<I: Shells, const ANY: bool>(
    lazy: &LazyBvh,
    packet: &Packet,
    mask: u64,
    numbers: (u32, u32),
    found: &mut Found,
) {
    if !lazy.is_empty() {
        // SAFETY: the caller's promise.
        enter(lazy, 0, |view, root| unsafe { I::lazy_packet::<ANY>(&view, root, packet, mask, numbers, found) });
    }
}

/// Goes into a segment by its root, wherever it is.
#[inline(always)]
fn enter<T>(lazy: &LazyBvh, segment: usize, go: impl FnOnce(View<'_>, ChildRef) -> T) -> T {
    if let Some(root) = lazy.current_root(segment).or_else(|| lazy.touch(segment)) {
        return go(View::shared(lazy), root);
    }
    if let Ok(own) = lazy.copy(segment) {
        return go(View::private(lazy, own.part()), ChildRef::node(own.part().first_node));
    }
    // Without memory for that, whoever is at it is waited for.
    loop {
        if let Some(root) = lazy.current_root(segment) {
            return go(View::shared(lazy), root);
        }
        std::thread::yield_now();
    }
}

/// [`traverse`], from a child down.
///
/// # Safety
/// - The processor has the instruction set `I`; the child may be read in this view.
#[inline(always)]
pub(super) unsafe fn below<I: Shells, const ANY: bool>(
    view: &View<'_>,
    child: ChildRef,
    ray: impl OneRay,
    numbers: (u32, u32),
    best: &mut Hit,
) -> bool {
    // SAFETY: the caller's promise; paths have at most MAX_DEPTH nodes (the invariants of the topology).
    unsafe {
        let lanes = (SlabLanes::<I>::new(ray), RayLanes::<I>::new(ray));
        let tree = SeenByOne::<I, _, ANY> { view, ray, numbers, isa: PhantomData };
        descend::<I, ANY, _, _>(&tree, child, &lanes, ray, numbers, best)
    }
}

/// The tree as seen by one ray.
struct SeenByOne<'a, I, R, const ANY: bool> {
    view: &'a View<'a>,
    ray: R,
    numbers: (u32, u32),
    isa: PhantomData<I>,
}

impl<I, R, const ANY: bool> Nodes for SeenByOne<'_, I, R, ANY> {
    #[inline(always)]
    unsafe fn node(&self, index: usize) -> &Node8 {
        // SAFETY: the caller's promise.
        unsafe { self.view.node(index) }
    }
}

impl<I, R, const ANY: bool> Blocks for SeenByOne<'_, I, R, ANY> {
    #[inline(always)]
    unsafe fn blocks(&self, leaf: ChildRef) -> impl Iterator<Item = impl Deref<Target = Tri4>> {
        // SAFETY: the caller's promise.
        unsafe { self.view.blocks(leaf) }
    }
}

/// A block that has been gathered.
struct Gathered(Tri4);

impl Deref for Gathered {
    type Target = Tri4;

    #[inline(always)]
    fn deref(&self) -> &Tri4 {
        &self.0
    }
}

impl<I: Shells, R: OneRay, const ANY: bool> Tree for SeenByOne<'_, I, R, ANY> {
    #[inline(always)]
    unsafe fn lead(&self, leaf: ChildRef, best: &mut Hit) -> Lead {
        let Self { view, ray, numbers, .. } = *self;
        let Some(segment) = view.lazy.segment_of_leaf(leaf) else { return Lead::Blocks };
        match view.root_of(segment) {
            Some(root) => Lead::On(root),
            None => Lead::Back(enter(view.lazy, segment, |view, root| {
                let ray = ray.prepared(best.t);
                // SAFETY: the caller's promise.
                unsafe { I::lazy::<ANY>(&view, root, &ray, numbers, best) }
            })),
        }
    }
}

/// [`traverse_many`], from a node down.
///
/// # Safety
/// - The processor has the instruction set `I`; the node may be read in this view.
#[inline(always)]
pub(super) unsafe fn packet_below<I: Shells, const ANY: bool>(
    view: &View<'_>,
    root: ChildRef,
    packet: &Packet,
    mask: u64,
    numbers: (u32, u32),
    found: &mut Found,
) {
    let slabs = Slabs { near_org: &packet.org, far_org: &packet.org, inv_dir: &packet.inv_dir, tmin: &packet.tmin };
    let mut leaves = LazyLeaves::<ANY> { view, root, packet, numbers, differ: false };
    // SAFETY: the caller's promise; it is a tree (the invariants of the topology).
    unsafe { traverse_packet::<I, _>(view, root, &slabs, &packet.negative, mask, &mut leaves, found) }
}

/// Triangles and segments, as seen by a packet.
struct LazyLeaves<'a, const ANY: bool> {
    view: &'a View<'a>,
    root: ChildRef,
    packet: &'a Packet,
    numbers: (u32, u32),
    /// Whether the directions of the rays that are on their way differ much.
    differ: bool,
}

impl<I: Shells, const ANY: bool> Leaves<I> for LazyLeaves<'_, ANY> {
    const FEW: u32 = 4;

    #[inline(always)]
    unsafe fn lead(&self, leaf: ChildRef) -> Option<ChildRef> {
        self.view.lazy.segment_of_leaf(leaf).and_then(|segment| self.view.root_of(segment))
    }

    #[inline(always)]
    unsafe fn test(&mut self, leaf: ChildRef, mask: u64, alike: Alike, found: &mut Found) -> bool {
        let Self { view, packet, numbers, .. } = *self;
        // SAFETY: the caller's promise; the leaf is a run of blocks, or a segment.
        unsafe {
            if let Some(segment) = view.lazy.segment_of_leaf(leaf) {
                enter(view.lazy, segment, |view, root| {
                    I::lazy_packet::<ANY>(&view, root, packet, mask, numbers, found);
                });
                return !ANY;
            }
            let run = view.lazy.blocks().get_unchecked(leaf.blocks());
            let mut blocks = [const { MaybeUninit::<Tri4>::uninit() }; MAX_LEAF_BLOCKS];
            for (to, block) in blocks.iter_mut().zip(run) {
                to.write(view.gather(block));
            }
            // A leaf has no more than MAX_LEAF_BLOCKS.
            let blocks = std::slice::from_raw_parts(blocks.as_ptr().cast::<Tri4>(), run.len());
            intersect_leaf::<I, ANY>(packet, mask, alike, blocks, numbers.0, numbers.1, found) && !ANY
        }
    }

    #[inline(always)]
    fn prefetch(&self, child: ChildRef) {
        if child.is_leaf() {
            prefetch(self.view.lazy.blocks(), child.blocks().start);
        } else {
            prefetch_at(self.view.nodes.wrapping_add(child.index()));
        }
    }

    #[inline(always)]
    unsafe fn apart(&mut self, mask: u64, down: [bool; 3], found: &mut Found) -> bool {
        let Self { view, root, packet, numbers, .. } = *self;
        // From a private segment all ways lead elsewhere.
        if !view.is_shared() {
            return false;
        }
        // SAFETY: the caller's promise; the root may be read in this view.
        unsafe {
            self.differ = differ_much::<I>(packet, mask);
            if !found.habits::<ANY>(self.differ).are_to_part() {
                return false;
            }
            for r in bits(I::turns::<ANY, _>(view, root, packet, mask, down, numbers, found)) {
                <Self as Leaves<I>>::alone(self, root, r, down, found);
            }
        }
        true
    }

    #[inline(always)]
    fn went_alone(&mut self, rays: u32, alone: u32, found: &mut Found) {
        found.habits::<ANY>(self.differ).saw(rays, alone);
    }

    #[inline(always)]
    unsafe fn alone(&mut self, child: ChildRef, r: usize, down: [bool; 3], found: &mut Found) {
        let Self { view, packet, numbers, .. } = *self;
        let t = &mut found.t[r / LANES % GROUPS][r % LANES];
        let tmax = *t;
        // SAFETY: the caller's promise.
        unsafe {
            let ray = InPacket::new(packet, r, down);
            if ANY {
                let none = &mut Hit::none(tmax);
                if below::<I, true>(view, child, ray, numbers, none) {
                    found.open &= !(1 << r);
                }
            } else {
                let best = &mut found.hits[r];
                if below::<I, false>(view, child, ray, numbers, best) {
                    *t = best.t;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::accel::test_meshes::{Random, bumpy_sphere};
    use crate::accel::{Structure, TwoLevel};
    use crate::scene::{Command, Instance, LazyShape, Motion, Scene, Strategy};
    use crate::simd::Level;
    use crate::trace::{Ray, Tracer};
    use glam::Affine3A;

    #[test]
    fn rays_that_come_while_a_segment_is_written_see_the_same() {
        let seed = Random::seed(45);
        let mut random = Random::new(seed);
        let mut scene = Scene::default();
        scene.apply(Command::DefineObject { name: 1, mesh: bumpy_sphere(40, 60), motion: Motion::Unstructured });
        let instances = [Instance::new(1, Affine3A::IDENTITY)];
        let rays: Vec<Ray> = (0..700)
            .map(|i| {
                let org = random.vec() * 3.0;
                let to = random.vec() * if i % 3 == 0 { 2.0 } else { 0.5 };
                Ray::new(org, to - org)
            })
            .collect();
        for level in Level::available() {
            let mut plain = TwoLevel::new(level);
            plain.force_strategy(Some(Strategy::Refit));
            plain.update(&scene, &instances);
            for (cut, levels, claimed) in [(0, 0, 2), (0, 1, 2), (100, 0, 3), (100, 1, 1)] {
                scene.apply(Command::SetLazyShape { name: 1, shape: LazyShape { cut, levels } });
                let mut world = TwoLevel::new(level);
                world.force_strategy(Some(Strategy::Lazy));
                world.update(&scene, &instances);
                let Structure::Lazy(lazy) = world.objects()[0].structure() else { unreachable!("it was forced") };
                assert!(lazy.segments() > 8);
                (0..lazy.segments()).filter(|_| random.below(claimed) == 0).for_each(|s| lazy.leave_claimed(s));
                let (expected, tracer) = (Tracer::new(&plain), Tracer::new(&world));
                let many = tracer.intersect_many(&rays);
                let mut dark = vec![false; rays.len()];
                tracer.occluded_many(&rays, &mut dark);
                for (i, ray) in rays.iter().enumerate() {
                    let hit = expected.intersect(ray);
                    let what = format!("seed {seed}, {level:?}, cut {cut}, levels {levels}, ray {i}");
                    assert_eq!(format!("{:?}", tracer.intersect(ray)), format!("{hit:?}"), "{what}");
                    assert_eq!(format!("{:?}", many[i]), format!("{hit:?}"), "{what}, many");
                    assert_eq!((tracer.occluded(ray), dark[i]), (hit.is_some(), hit.is_some()), "{what}");
                }
            }
        }
    }
}
