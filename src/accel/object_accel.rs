//! The acceleration structure of one object, and its way from frame to frame.
//!
//! A closed enum instead of trait objects: three kinds of structure exist, and traversal matches once per object and ray. Which one, and how it
//! follows changes, is decided in [`super::strategy`]; what has changed is told by the version counters of the
//! [`Object`]. Instances share the structure (Wald03 §4.1).
//!
//! The structure of a static object that is placed once is built in world space (see [`super::statics`]); where it is placed then counts
//! as its vertices do. It has none of its own while its triangles are in the merged tree.

use super::bsp::Bsp;
use super::bsp_build::Quality;
use super::build_fast::{FastScratch, build_fast, rebuild_fast};
use super::build_sah::{SahScratch, rebuild_sah};
use super::build_spatial::build_spatial;
use super::bvh::{Bvh, OutOfMemory};
use super::grid::Grid;
use super::instance::{append_to_world, mesh_with_room};
use super::key_trees::KeyTrees;
use super::lazy::{LazyBvh, Source};
use super::links::Links;
use super::rotate::Wear;
use super::strategy::{Method, Moved, WORN};
use super::visibility::VisibilityField;
use super::waiting::{Attention, Waiting};
use super::{Aabb, Refit, build_sah};
use crate::scene::{Mesh, Name, Object, Strategy};
use glam::Affine3A;
use std::ops::Deref;
use std::sync::Arc;

/// After so many defeats in a row a refit is tried in every eighth frame.
const MOST_DEFEATS: u32 = 3;

/// What rays of one object traverse.
#[derive(Debug, Default)]
pub enum Structure {
    /// Nothing is built: the object has not been instanced yet, or memory ran out.
    #[default]
    None,
    Bvh(Bvh),
    Bsp(Bsp),
    Grid(Grid),
    Lazy(LazyBvh),
    Field(VisibilityField),
}

impl Structure {
    pub(super) fn memory_bytes(&self) -> usize {
        match self {
            Structure::None => 0,
            Structure::Bvh(bvh) => bvh.memory_bytes(),
            Structure::Bsp(bsp) => bsp.memory_bytes(),
            Structure::Grid(grid) => grid.memory_bytes(),
            Structure::Lazy(lazy) => lazy.memory_bytes(),
            Structure::Field(field) => field.memory_bytes(),
        }
    }
}

/// One object's structure and what it was made from.
#[derive(Debug, Default)]
pub struct ObjectAccel {
    name: Name,
    structure: Structure,
    made_with: Option<Method>,
    topology_version: u64,
    vertex_version: u64,
    /// SAH cost after the last build, where wear is watched.
    cost_when_built: f64,
    definitions: u64,
    triangles: u64,
    /// Where the structure is, if it is in world space.
    placed: Option<Affine3A>,
    /// The triangles are in the merged tree; there is no structure here.
    merged: bool,
    /// Updates without a change, and how often the object left the merged tree.
    calm: u32,
    exits: u32,
    /// The structure, while it waits for a ray; there is no other then.
    waiting: Option<Box<Waiting>>,
    attention: Attention,
    defeats: Defeats,
    /// What rotations remember of the tree.
    wear: Wear,
    /// For partial refits, once there has been one, and how many nodes these have looked at since wear was.
    links: Option<Links>,
    patched: usize,
    keys: KeyTrees,
    scratch: Scratch,
}

/// Refits, with rotations or without, that left the tree worn. A motion that defeats them in one frame most likely does so in the next, and to try costs as much
/// as a quarter of the build that follows: so they are not tried in the next frame, then in the next three, then seven.
#[derive(Debug, Default)]
struct Defeats {
    in_a_row: u32,
    /// Updates that are builds without trying.
    pause: u32,
}

impl Defeats {
    /// Whether to build without trying.
    fn pauses(&mut self) -> bool {
        let pauses = self.pause > 0;
        self.pause -= u32::from(pauses);
        pauses
    }

    /// The tree was tried, and is worn or not.
    fn tell(&mut self, worn: bool) {
        self.in_a_row = if worn { (self.in_a_row + 1).min(MOST_DEFEATS) } else { 0 };
        self.pause = (1 << self.in_a_row) - 1;
    }
}

/// What builders worked with, kept for an object that is built again and again.
#[derive(Debug, Default)]
struct Scratch {
    sah: SahScratch,
    fast: FastScratch,
}

/// How waiting for a ray ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Waited {
    InVain,
    AndWasReached,
}

/// Which triangles in world space a structure stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Identity {
    name: Name,
    topology_version: u64,
    vertex_version: u64,
    pub world_from_object: Affine3A,
}

/// What an update did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    Unchanged,
    /// Built anew, with so many nodes (0 for a BSP, whose tree comes with the first ray).
    Built(usize),
    Refitted(usize),
    /// Put off until a ray comes.
    Waits,
    /// The object has no structure and cannot be hit.
    Failed(OutOfMemory),
}

impl ObjectAccel {
    pub(super) fn new(name: Name) -> Self {
        Self { name, ..Self::default() }
    }

    #[inline]
    pub fn name(&self) -> Name {
        self.name
    }

    /// What a ray traverses that has come to the object. One that waited for it is brought up to date.
    #[inline(always)]
    pub fn structure(&self) -> &Structure {
        self.attention.reach();
        match &self.waiting {
            None => &self.structure,
            Some(waiting) => waiting.structure(),
        }
    }

    /// The box around everything that can be hit, in object space.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        if let Some(waiting) = &self.waiting {
            return waiting.bounds();
        }
        match &self.structure {
            Structure::None => Aabb::EMPTY,
            Structure::Bvh(bvh) => bvh.bounds(),
            Structure::Bsp(bsp) => bsp.bounds(),
            Structure::Grid(grid) => grid.bounds(),
            Structure::Lazy(lazy) => lazy.bounds(),
            Structure::Field(field) => field.bounds(),
        }
    }

    /// Triangles of the object, those that no ray can hit included.
    #[inline]
    pub fn triangles(&self) -> u64 {
        self.triangles
    }

    /// Bytes held; 0 while nothing is built.
    pub fn memory_bytes(&self) -> usize {
        let links = self.links.as_ref().map_or(0, Links::memory_bytes);
        let waiting = self.waiting.as_ref().map_or(0, |w| w.memory_bytes());
        let structure = self.structure.memory_bytes() + waiting + self.keys.memory_bytes();
        let rotations = self.wear.memory_bytes();
        structure + links + rotations + self.scratch.sah.memory_bytes() + self.scratch.fast.memory_bytes()
    }

    /// What rays have had brought up to date since [`ObjectAccel::forget_touched`]: subtrees and nodes, or subfields and references.
    pub(super) fn touched(&self) -> (u32, u64) {
        match (&self.waiting, &self.structure) {
            (Some(waiting), _) => waiting.touched(),
            (None, Structure::Lazy(lazy)) => lazy.touched(),
            (None, Structure::Field(field)) => field.touched(),
            _ => (0, 0),
        }
    }

    pub(super) fn forget_touched(&mut self) {
        match &mut self.structure {
            Structure::Lazy(lazy) => lazy.forget_touched(),
            Structure::Field(field) => field.forget_touched(),
            _ => {}
        }
    }

    /// Where the structure is, if it is in world space: then rays are not transformed.
    #[inline]
    pub fn placed(&self) -> Option<&Affine3A> {
        self.placed.as_ref()
    }

    /// Whether the triangles are in the merged tree, and there is no structure here.
    #[inline]
    pub fn is_merged(&self) -> bool {
        self.merged
    }

    /// What a structure in world space stands for. None for other structures, and if memory ran out.
    pub(super) fn identity(&self) -> Option<Identity> {
        let Self { name, topology_version, vertex_version, .. } = *self;
        self.made_with?;
        self.placed.map(|world_from_object| Identity { name, topology_version, vertex_version, world_from_object })
    }

    /// Whether the triangles may go to the merged tree, after at least `wait` updates without a change: those of a
    /// tree like the merged one. Who left that before has to wait longer.
    pub(super) fn may_merge(&self, wait: u32) -> bool {
        let like_merged = Method::Bvh { fast: false, moved: Moved::Rebuild };
        self.made_with == Some(like_merged) && self.triangles > 0 && self.calm >= wait << self.exits.min(10)
    }

    /// The triangles are in the merged tree from now on.
    pub(super) fn enter_merged(&mut self) {
        self.structure = Structure::None;
        self.waiting = None;
        self.links = None;
        self.merged = true;
    }

    /// The triangles are not in the merged tree any more; the next update builds a structure.
    pub(super) fn leave_merged(&mut self) {
        self.merged = false;
        self.made_with = None;
        self.exits += 1;
    }

    /// Brings the structure in line with `object`, in world space if `placed` tells where. To be called inside the pool.
    pub(super) fn update(&mut self, object: &Object, forced: Option<Strategy>, placed: Option<Affine3A>) -> Outcome {
        self.triangles = object.mesh.triangles.len() as u64;
        let same_topology = self.made_with.is_some() && self.topology_version == object.topology_version;
        let same_place = self.placed == placed;
        let same_vertices = same_topology && same_place && self.vertex_version == object.vertex_version;
        let redefined = self.definitions > 1 || (self.definitions == 1 && !same_topology);
        let method = Method::choose(object, forced, redefined);
        let same_method = self.made_with == Some(method);
        let follows = method.follows_keys() && placed.is_none() && !object.keys.is_empty();
        if same_vertices && same_method && self.keys.are_current(object, follows) {
            self.calm = self.calm.saturating_add(1);
            // At rest, it needs no memory for builds.
            self.scratch = Scratch::default();
            if let (Structure::Lazy(lazy), None) = (&mut self.structure, moved_by(placed)) {
                lazy.set_source(Source::Scene(Arc::downgrade(&object.mesh)));
            }
            if let Structure::Field(field) = &mut self.structure {
                field.rest();
            }
            if let Some(waiting) = &mut self.waiting {
                waiting.set_source(Source::Scene(Arc::downgrade(&object.mesh)));
            }
            return Outcome::Unchanged;
        }
        // Said to be static, and moved all the same: the next move must not cost as much again.
        let hurried = self.made_with.is_some() && self.placed.is_some() && placed.is_some() && !same_place;
        if std::mem::take(&mut self.merged) {
            self.exits += 1;
        }
        self.calm = 0;
        self.placed = placed;
        let waited = self.stop_waiting();
        let outcome = world_mesh(&object.mesh, placed).and_then(|mesh| {
            let stays = same_place && matches!(mesh, Located::Object(_));
            // A tree that has waited in vain is behind by more than the last move.
            let stays = stays && waited != Some(Waited::InVain);
            let moved = if stays { object.moves.since(self.vertex_version.max(self.topology_version)) } else { None };
            let same_tree = same_topology && same_method;
            let (moved, built) = self.follow_keys(object, &mesh, method, (follows, same_tree), moved)?;
            let kept = same_tree || built > 0;
            if same_tree && method.may_wait() && self.wait(&mesh, waited) {
                return Ok(Outcome::Waits);
            }
            match if kept { self.refit(&mesh, method, moved) } else { None } {
                Some(Outcome::Refitted(nodes)) if built > 0 => Ok(Outcome::Built(nodes)),
                Some(outcome) => Ok(outcome),
                None => self.build(object, &mesh, method, hurried),
            }
        });
        self.topology_version = object.topology_version;
        self.vertex_version = object.vertex_version;
        match outcome {
            Ok(outcome) => {
                self.made_with = Some(method);
                outcome
            }
            Err(error) => {
                self.structure = Structure::None;
                self.keys.clear();
                self.made_with = None;
                Outcome::Failed(error)
            }
        }
    }

    /// Changes to the tree of the active key frame. Returns which vertices it still has to follow, out of those that `moved`, and how many trees were built.
    fn follow_keys(
        &mut self,
        object: &Object,
        mesh: &Located<'_>,
        method: Method,
        (follows, same_tree): (bool, bool),
        moved: Option<Vec<u32>>,
    ) -> Result<(Option<Vec<u32>>, usize), OutOfMemory> {
        let mut keys = std::mem::take(&mut self.keys);
        if !same_tree {
            keys.clear();
        }
        let mut tree = if same_tree || !follows { std::mem::take(&mut self.structure) } else { Structure::None };
        let followed = keys.follow(object, follows, &mut tree, |key| {
            Ok(match method {
                Method::Lazy(shape) => Structure::Lazy(LazyBvh::new(key, mesh.source(), shape)?),
                _ => Structure::Bvh(build_sah(key)?),
            })
        })?;
        self.structure = tree;
        self.keys = keys;
        if !followed.switched {
            return Ok((moved, followed.built));
        }
        self.links = None;
        Ok((None, followed.built))
    }

    /// Answers a vertex update by a refit, of what hangs on the vertices `moved` if it is known which; `None` where the method or the result asks
    /// for a build.
    fn refit(&mut self, mesh: &Located<'_>, method: Method, moved: Option<Vec<u32>>) -> Option<Outcome> {
        if let Structure::Lazy(lazy) = &mut self.structure {
            // Without memory for a partial update it is a complete one.
            let some = moved.and_then(|vertices| lazy.moved_some(mesh, mesh.source(), &vertices).ok());
            return some.or_else(|| lazy.moved(mesh, mesh.source())).map(Outcome::Refitted);
        }
        if let Structure::Field(field) = &mut self.structure {
            return field.moved(mesh, moved.as_deref()).map(Outcome::Refitted);
        }
        if let Some(nodes) = moved.and_then(|vertices| self.refit_moved(mesh, method, &vertices)) {
            return Some(Outcome::Refitted(nodes));
        }
        let (Structure::Bvh(bvh), Method::Bvh { moved, .. }) = (&mut self.structure, method) else { return None };
        if moved == Moved::Rotate {
            return self.rotate(mesh);
        }
        if moved == Moved::RefitUntilWorn && bvh.can_hold(mesh) && self.defeats.pauses() {
            return self.renew(mesh);
        }
        if moved == Moved::Rebuild || bvh.refit(mesh) == Refit::NeedsRebuild {
            return None;
        }
        self.patched = 0;
        if moved == Moved::RefitUntilWorn {
            let worn = bvh.sah_cost() > WORN * self.cost_when_built;
            self.defeats.tell(worn);
            if worn {
                return self.renew(mesh);
            }
        }
        Some(Outcome::Refitted(bvh.nodes().len()))
    }

    /// Refits with rotations.
    fn rotate(&mut self, mesh: &Mesh) -> Option<Outcome> {
        let Structure::Bvh(bvh) = &mut self.structure else { return None };
        if bvh.can_hold(mesh) && self.defeats.pauses() {
            return self.renew(mesh);
        }
        let worn = bvh.rotate(mesh, &mut self.wear)? > WORN * self.cost_when_built;
        self.defeats.tell(worn);
        if worn { self.renew(mesh) } else { Some(Outcome::Refitted(bvh.nodes().len())) }
    }

    /// Puts a tree that waited for a ray back in its place.
    fn stop_waiting(&mut self) -> Option<Waited> {
        let waiting = self.waiting.take()?;
        let waited = if waiting.was_reached() { Waited::AndWasReached } else { Waited::InVain };
        self.structure = Structure::Bvh(waiting.into_tree());
        Some(waited)
    }

    /// Lets the tree wait for a ray, if none was there lately.
    fn wait(&mut self, mesh: &Located<'_>, waited: Option<Waited>) -> bool {
        let should = self.attention.should_wait(waited == Some(Waited::AndWasReached));
        match std::mem::take(&mut self.structure) {
            Structure::Bvh(bvh) if should && bvh.may_wait(mesh) => {
                self.waiting = Some(Box::new(Waiting::new(bvh, mesh, mesh.source())));
                true
            }
            other => {
                self.structure = other;
                false
            }
        }
    }

    /// Builds the worn tree anew, fast. `None` if memory ran out: then [`ObjectAccel::build`] tells how much.
    fn renew(&mut self, mesh: &Mesh) -> Option<Outcome> {
        let old = match std::mem::take(&mut self.structure) {
            Structure::Bvh(bvh) => bvh,
            _ => Bvh::default(),
        };
        self.links = None;
        self.wear.clear();
        let bvh = rebuild_fast(mesh, old, &mut self.scratch.fast).ok()?;
        self.cost_when_built = bvh.sah_cost();
        let nodes = bvh.nodes().len();
        self.structure = Structure::Bvh(bvh);
        Some(Outcome::Built(nodes))
    }

    /// The partial refit, which says how many nodes it looked at; `None` where a complete one or a build is due.
    fn refit_moved(&mut self, mesh: &Mesh, method: Method, vertices: &[u32]) -> Option<usize> {
        let (Structure::Bvh(bvh), Method::Bvh { moved, .. }) = (&mut self.structure, method) else { return None };
        if !matches!(moved, Moved::Refit | Moved::RefitUntilWorn) {
            return None;
        }
        let links = match self.links.take() {
            Some(links) => links,
            None => bvh.links(mesh).ok()?,
        };
        let (refit, nodes) = bvh.refit_moved(mesh, vertices, self.links.insert(links));
        self.patched += nodes;
        // Wear is a property of all nodes, so it is looked at when as many have been.
        let looks = moved == Moved::RefitUntilWorn && self.patched > bvh.nodes().len();
        (refit == Refit::Done && !looks).then_some(nodes)
    }

    fn build(
        &mut self,
        object: &Object,
        mesh: &Located<'_>,
        method: Method,
        hurried: bool,
    ) -> Result<Outcome, OutOfMemory> {
        // The old structure goes first, or becomes the new one's memory: both together may not fit.
        let old = std::mem::take(&mut self.structure);
        self.links = None;
        if self.topology_version != object.topology_version || self.made_with.is_none() {
            self.definitions += 1;
        }
        let nodes = match method {
            Method::Bsp { fast } => {
                let recycled = if let Structure::Bsp(bsp) = old { Some(bsp) } else { None };
                let quality = if fast { Quality::Fast } else { Quality::Sah };
                let bsp = Bsp::new(mesh, quality, recycled)?;
                self.structure = Structure::Bsp(bsp);
                0
            }
            Method::Grid => {
                let recycled = if let Structure::Grid(grid) = old { grid } else { Grid::default() };
                self.structure = Structure::Grid(Grid::new(mesh, recycled)?);
                0
            }
            Method::Field => {
                let recycled = if let Structure::Field(field) = old { Some(field) } else { None };
                self.structure = Structure::Field(VisibilityField::new(mesh, recycled)?);
                0
            }
            Method::Lazy(shape) => {
                drop(old);
                let lazy = LazyBvh::new(mesh, mesh.source(), shape)?;
                let nodes = lazy.nodes();
                self.structure = Structure::Lazy(lazy);
                nodes
            }
            Method::SpatialSplits => {
                drop(old);
                let bvh = if hurried { build_fast(mesh)? } else { build_spatial(mesh)? };
                let nodes = bvh.nodes().len();
                self.structure = Structure::Bvh(bvh);
                nodes
            }
            Method::Bvh { fast, moved } => {
                let recycled = if let Structure::Bvh(bvh) = old { bvh } else { Bvh::default() };
                let bvh = self.build_bvh(mesh, fast || hurried, recycled)?;
                if moved == Moved::Rotate {
                    (self.wear, self.defeats) = (Wear::default(), Defeats::default());
                }
                let nodes = bvh.nodes().len();
                if matches!(moved, Moved::RefitUntilWorn | Moved::Rotate) {
                    self.cost_when_built = bvh.sah_cost();
                }
                self.structure = Structure::Bvh(bvh);
                nodes
            }
        };
        Ok(Outcome::Built(nodes))
    }

    /// Builds in the memory of a former tree. What a second build needed is kept, a third one will need it again; most objects
    /// are built once.
    fn build_bvh(&mut self, mesh: &Mesh, fast: bool, old: Bvh) -> Result<Bvh, OutOfMemory> {
        let again = self.made_with.is_some();
        let mut scratch = std::mem::take(&mut self.scratch);
        let bvh = if fast {
            scratch.sah = SahScratch::default();
            rebuild_fast(mesh, old, &mut scratch.fast)?
        } else {
            scratch.fast = FastScratch::default();
            rebuild_sah(mesh, old, &mut scratch.sah)?
        };
        if again {
            self.scratch = scratch;
        }
        Ok(bvh)
    }
}

/// What vertices are moved by, if anything.
fn moved_by(placed: Option<Affine3A>) -> Option<Affine3A> {
    placed.filter(|m| *m != Affine3A::IDENTITY)
}

/// A mesh in the space of its structure.
enum Located<'a> {
    /// The scene's own.
    Object(&'a Arc<Mesh>),
    World(Arc<Mesh>),
}

impl Deref for Located<'_> {
    type Target = Mesh;

    fn deref(&self) -> &Mesh {
        match self {
            Located::Object(mesh) => mesh,
            Located::World(mesh) => mesh,
        }
    }
}

impl Located<'_> {
    /// Where a structure finds it later.
    fn source(&self) -> Source {
        match self {
            Located::Object(mesh) => Source::Scene(Arc::downgrade(mesh)),
            Located::World(mesh) => Source::Own(mesh.clone()),
        }
    }
}

/// The mesh in world space, if it is placed there.
fn world_mesh(mesh: &Arc<Mesh>, placed: Option<Affine3A>) -> Result<Located<'_>, OutOfMemory> {
    let Some(place) = moved_by(placed) else { return Ok(Located::Object(mesh)) };
    let mut world = mesh_with_room(mesh.positions.len(), mesh.triangles.len())?;
    append_to_world(&mut world, mesh, &place);
    Ok(Located::World(Arc::new(world)))
}
