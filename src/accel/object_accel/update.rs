//! How the structure of one object follows it from frame to frame: left alone, refit, put off or built anew.
//!
//! What has changed is told by the version counters of the [`Object`]; what is done about it is decided in [`crate::accel::strategy`].

use super::state::Scratch;
use super::worth::Worth;
use super::{ObjectAccel, ObjectState, Outcome, Spent, Structure, Work, exclusive};
use crate::accel::bsp::{Bsp, Quality};
use crate::accel::build_fast::{FastScratch, build_fast, rebuild_fast};
use crate::accel::build_sah::{SahScratch, rebuild_sah};
use crate::accel::build_spatial::build_spatial;
use crate::accel::bvh::{Bvh, OutOfMemory};
use crate::accel::by_rays::LARGE;
use crate::accel::grid::Grid;
use crate::accel::instance::{append_to_world, mesh_with_room};
use crate::accel::lazy::{LazyBvh, Source};
use crate::accel::refit::SweepScratch;
use crate::accel::rotate::Wear;
use crate::accel::strategy::{Method, Moved, WORN};
use crate::accel::visibility::VisibilityField;
use crate::accel::waiting::Waiting;
use crate::accel::{Refit, build_sah};
use crate::scene::{LazyShape, Mesh, Object, Strategy};
use glam::Affine3A;
use std::ops::Deref;
use std::sync::Arc;
use std::time::Instant;

/// The first fast build takes so many times as long, in memory that nobody has touched.
const COLD: f64 = 2.0;

/// How waiting for a ray ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Waited {
    InVain,
    AndWasReached,
}

impl ObjectState {
    /// Brings the object's structure in line with `object`, in world space if `placed` tells where. A structure that a snapshot holds stays as it is:
    /// then `shared` is another one afterwards. `build_price`: seconds that a fast build takes per triangle, if that is known. To be called inside the
    /// pool.
    pub(in crate::accel) fn update(
        &mut self,
        shared: &mut Arc<ObjectAccel>,
        object: &Object,
        forced: Option<Strategy>,
        placed: Option<Affine3A>,
        by_rays: bool,
        build_price: Option<f64>,
    ) -> Outcome {
        self.spent = Spent::default();
        let same_topology = self.made_with.is_some() && self.topology_version == object.topology_version;
        let same_place = self.placed == placed;
        let same_vertices = same_topology && same_place && self.vertex_version == object.vertex_version;
        let redefined = self.definitions > 1 || (self.definitions == 1 && !same_topology);
        let method = Method::choose(object, forced, redefined);
        let same_method = self.made_with == Some(method);
        let follows = method.follows_keys() && placed.is_none() && !object.keys.is_empty();
        let unchanged = same_vertices && same_method && self.keys.are_current(object, follows);
        if unchanged && self.stays(shared, object, placed) {
            return Outcome::Unchanged;
        }
        let begin = Instant::now();
        // Said to be static, and moved all the same: the next move must not cost as much again.
        let hurried = self.made_with.is_some() && self.placed.is_some() && placed.is_some() && !same_place;
        if std::mem::take(&mut self.merged) {
            self.exits += 1;
        }
        self.calm = 0;
        self.placed = placed;
        let same_tree = same_topology && same_method;
        let outcome = world_mesh(&object.mesh, placed).and_then(|mesh| {
            let (accel, waited) = take_over(shared, &mesh, same_tree && method.follows_moves());
            accel.triangles = mesh.triangles.len() as u64;
            let stays = same_place && matches!(mesh, Located::Object(_));
            // A tree that has waited in vain is behind by more than the last move.
            let stays = stays && waited != Some(Waited::InVain);
            let moved = if stays { object.moves.since(self.vertex_version.max(self.topology_version)) } else { None };
            let mut change = Change { state: self, accel };
            let (moved, built) = change.follow_keys(object, &mesh, method, (follows, same_tree), moved)?;
            let kept = same_tree || built > 0;
            if same_tree && method.may_wait() && change.wait(&mesh, waited) {
                return Ok(Outcome::Waits);
            }
            let whole = same_tree && method.may_wait() && moved.is_none();
            if let Some(outcome) = if whole { change.leave_to_rays(&mesh, by_rays) } else { None } {
                return Ok(outcome);
            }
            match if kept { change.refit(&mesh, method, moved, build_price) } else { None } {
                Some(Outcome::Refitted(nodes)) if built > 0 => Ok(Outcome::Built(nodes)),
                Some(outcome) => Ok(outcome),
                None => change.build(object, &mesh, method, hurried),
            }
        });
        self.topology_version = object.topology_version;
        self.vertex_version = object.vertex_version;
        self.spent.seconds = begin.elapsed().as_secs_f64();
        match outcome {
            Ok(outcome) => {
                self.made_with = Some(method);
                outcome
            }
            Err(error) => {
                exclusive(shared).structure = Structure::None;
                self.keys.clear();
                self.made_with = None;
                Outcome::Failed(error)
            }
        }
    }

    /// Nothing that concerns the structure has changed. False if it must be made again all the same: a snapshot holds it, with the mesh that it was made
    /// from, which is not the scene's any more.
    fn stays(&mut self, shared: &mut Arc<ObjectAccel>, object: &Object, placed: Option<Affine3A>) -> bool {
        let here = || Source::Scene(Arc::downgrade(&object.mesh));
        match Arc::get_mut(shared) {
            Some(accel) => {
                if let (Structure::Lazy(lazy), None) = (&mut accel.structure, moved_by(placed)) {
                    lazy.set_source(here());
                }
                if let Structure::Field(field) = &mut accel.structure {
                    field.rest();
                }
                if let Some(waiting) = &mut accel.waiting {
                    waiting.set_source(here());
                }
            }
            None => {
                let source = match (&shared.waiting, &shared.structure) {
                    (Some(waiting), _) => Some(waiting.source()),
                    (None, Structure::Lazy(lazy)) => Some(lazy.source()),
                    _ => None,
                };
                if source.is_some_and(|source| source.is_elsewhere(&object.mesh)) {
                    return false;
                }
            }
        }
        self.calm = self.calm.saturating_add(1);
        // At rest, it needs no memory for builds.
        self.scratch = Scratch::default();
        true
    }
}

/// The object for an update to change, and how its waiting for a ray ended. Of what a snapshot holds, a tree that `follows` moves is copied.
fn take_over<'a>(
    shared: &'a mut Arc<ObjectAccel>,
    mesh: &Located<'_>,
    follows: bool,
) -> (&'a mut ObjectAccel, Option<Waited>) {
    let reached = |waiting: &Waiting| if waiting.was_reached() { Waited::AndWasReached } else { Waited::InVain };
    let waited = shared.waiting.as_deref().map(reached);
    if Arc::get_mut(shared).is_none() {
        let copy = if follows { shared.copied(mesh, mesh.source()) } else { None };
        exclusive(shared).structure = copy.unwrap_or_default();
    }
    let accel = exclusive(shared);
    accel.forget_proximity();
    if let Some(waiting) = accel.waiting.take() {
        accel.structure = Structure::Bvh(waiting.into_tree());
    }
    (accel, waited)
}

/// An update at work.
struct Change<'a> {
    state: &'a mut ObjectState,
    accel: &'a mut ObjectAccel,
}

impl Change<'_> {
    /// Changes to the tree of the active key frame. Returns which vertices it still has to follow, out of those that `moved`, and how many trees were built.
    fn follow_keys(
        &mut self,
        object: &Object,
        mesh: &Located<'_>,
        method: Method,
        (follows, same_tree): (bool, bool),
        moved: Option<Vec<u32>>,
    ) -> Result<(Option<Vec<u32>>, usize), OutOfMemory> {
        let mut keys = std::mem::take(&mut self.state.keys);
        if !same_tree {
            keys.clear();
        }
        let mut tree = if same_tree || !follows { std::mem::take(&mut self.accel.structure) } else { Structure::None };
        let followed = keys.follow(object, follows, &mut tree, |key| {
            Ok(match method {
                Method::Lazy(shape) => Structure::Lazy(LazyBvh::new(key, mesh.source(), shape)?),
                _ => Structure::Bvh(build_sah(key)?),
            })
        })?;
        self.accel.structure = tree;
        self.state.keys = keys;
        if !followed.switched {
            return Ok((moved, followed.built));
        }
        self.state.links = None;
        Ok((None, followed.built))
    }

    /// Answers a vertex update by a refit, of what hangs on the vertices `moved` if it is known which; `None` where the method or the result asks
    /// for a build.
    fn refit(
        &mut self,
        mesh: &Located<'_>,
        method: Method,
        moved: Option<Vec<u32>>,
        build_price: Option<f64>,
    ) -> Option<Outcome> {
        if let Structure::Lazy(lazy) = &mut self.accel.structure {
            // Without memory for a partial update it is a complete one.
            let some = moved.and_then(|vertices| lazy.moved_some(mesh, mesh.source(), &vertices).ok());
            let moved = some.or_else(|| lazy.moved(mesh, mesh.source(), self.accel.visits.take_reached()));
            return moved.map(Outcome::Refitted);
        }
        if let Structure::Field(field) = &mut self.accel.structure {
            return field.moved(mesh, moved.as_deref()).map(Outcome::Refitted);
        }
        if let Some(nodes) = moved.and_then(|vertices| self.refit_moved(mesh, method, &vertices)) {
            return Some(Outcome::Refitted(nodes));
        }
        let (Structure::Bvh(bvh), Method::Bvh { moved, .. }) = (&mut self.accel.structure, method) else { return None };
        match moved {
            Moved::Rebuild => None,
            Moved::Refit => match bvh.refit(mesh, &mut self.state.scratch.sweeps) {
                Ok(Refit::Done) => Some(Outcome::Refitted(bvh.nodes().len())),
                // Without memory for this there may be some for a build.
                _ => None,
            },
            Moved::Rotate | Moved::Auto => self.rotate(mesh, build_price),
        }
    }

    /// Refits with rotations.
    fn rotate(&mut self, mesh: &Mesh, build_price: Option<f64>) -> Option<Outcome> {
        let Structure::Bvh(bvh) = &mut self.accel.structure else { return None };
        let cold = if self.state.scratch.fast.memory_bytes() == 0 { COLD } else { 1.0 };
        let price = build_price.map(|per_triangle| per_triangle * self.accel.triangles as f64 * cold);
        if bvh.can_hold(mesh) && self.state.worth.needs_no_trial(price) {
            return self.renew(mesh);
        }
        self.state.patched = 0;
        self.state.spent.work = Work::Refit;
        let cost = bvh.rotate(mesh, &mut self.state.wear)?;
        let wear = if cost > self.state.cost_when_built { cost / self.state.cost_when_built } else { 1.0 };
        let builds = self.state.worth.try_refit(wear, wear > WORN, price);
        if self.state.wear.was_restructured() {
            // They are ways through another tree.
            self.state.links = None;
            self.state.spent.work = Work::Other;
            self.state.by_rays.wore();
        }
        if builds { self.renew(mesh) } else { Some(Outcome::Refitted(bvh.nodes().len())) }
    }

    /// What a move of all vertices asks for if rays are to bring the tree up to date (`by_rays`), or did so. None if it is to be refit now.
    fn leave_to_rays(&mut self, mesh: &Located<'_>, by_rays: bool) -> Option<Outcome> {
        if let Structure::Lazy(lazy) = &mut self.accel.structure {
            let was_reached = self.state.attention.was_reached();
            let worn = was_reached && self.state.by_rays.wear(lazy) > WORN;
            if worn {
                self.state.by_rays.wore();
            }
            if worn || (was_reached && !by_rays) {
                return self.renew(mesh);
            }
            let nodes = lazy.moved(mesh, mesh.source(), was_reached)?;
            return Some(if was_reached { Outcome::Refitted(nodes) } else { Outcome::Waits });
        }
        let may =
            self.state.by_rays.may() && by_rays && self.accel.triangles >= LARGE && self.state.attention.was_reached();
        match &self.accel.structure {
            Structure::Bvh(bvh) if may && bvh.may_wait(mesh) => {
                // Without memory it goes on as it was.
                let lazy = LazyBvh::of(bvh, mesh, mesh.source(), LazyShape::default()).ok()?;
                let nodes = lazy.nodes();
                self.accel.structure = Structure::Lazy(lazy);
                self.state.links = None;
                self.state.wear = Wear::default();
                self.state.by_rays.begin();
                Some(Outcome::Built(nodes))
            }
            _ => None,
        }
    }

    /// Lets the tree wait for a ray, if none was there lately.
    fn wait(&mut self, mesh: &Located<'_>, waited: Option<Waited>) -> bool {
        let should =
            self.state.attention.should_wait(self.accel.visits.take_reached(), waited == Some(Waited::AndWasReached));
        let mut scratch = SweepScratch::default();
        match std::mem::take(&mut self.accel.structure) {
            // Without memory it does not wait.
            Structure::Bvh(bvh) if should && bvh.may_wait(mesh) && bvh.prepare_alone(&mut scratch).is_ok() => {
                self.accel.waiting = Some(Box::new(Waiting::new(bvh, scratch, mesh, mesh.source())));
                true
            }
            other => {
                self.accel.structure = other;
                false
            }
        }
    }

    /// Builds the worn tree anew, fast. `None` if memory ran out: then [`Change::build`] tells how much.
    fn renew(&mut self, mesh: &Mesh) -> Option<Outcome> {
        let old = match std::mem::take(&mut self.accel.structure) {
            Structure::Bvh(bvh) => bvh,
            _ => Bvh::default(),
        };
        self.state.links = None;
        self.state.wear.clear();
        self.state.spent.work = Work::Other;
        let bvh = rebuild_fast(mesh, old, &mut self.state.scratch.fast).ok()?;
        self.state.cost_when_built = bvh.sah_cost();
        self.state.worth.renewed();
        let nodes = bvh.nodes().len();
        self.accel.structure = Structure::Bvh(bvh);
        Some(Outcome::Built(nodes))
    }

    /// The partial refit, which says how many nodes it looked at; `None` where a complete one or a build is due.
    fn refit_moved(&mut self, mesh: &Mesh, method: Method, vertices: &[u32]) -> Option<usize> {
        let (Structure::Bvh(bvh), Method::Bvh { moved, .. }) = (&mut self.accel.structure, method) else { return None };
        if !matches!(moved, Moved::Refit | Moved::Auto) {
            return None;
        }
        let links = match self.state.links.take() {
            Some(links) => links,
            None => bvh.links(mesh).ok()?,
        };
        let (refit, nodes) = bvh.refit_moved(mesh, vertices, self.state.links.insert(links)).ok()?;
        self.state.patched += nodes;
        // Wear is a property of all nodes, so it is looked at when as many have been.
        let looks = moved == Moved::Auto && self.state.patched > bvh.nodes().len();
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
        let old = std::mem::take(&mut self.accel.structure);
        self.state.links = None;
        if self.state.topology_version != object.topology_version || self.state.made_with.is_none() {
            self.state.definitions += 1;
        }
        let nodes = match method {
            Method::Bsp { fast } => {
                let recycled = if let Structure::Bsp(bsp) = old { Some(bsp) } else { None };
                let quality = if fast { Quality::Fast } else { Quality::Sah };
                let bsp = Bsp::new(mesh, quality, recycled)?;
                self.accel.structure = Structure::Bsp(bsp);
                0
            }
            Method::Grid => {
                let recycled = if let Structure::Grid(grid) = old { grid } else { Grid::default() };
                self.accel.structure = Structure::Grid(Grid::new(mesh, recycled)?);
                0
            }
            Method::Field => {
                let recycled = if let Structure::Field(field) = old { Some(field) } else { None };
                self.accel.structure = Structure::Field(VisibilityField::new(mesh, recycled)?);
                0
            }
            Method::Lazy(shape) => {
                drop(old);
                let lazy = LazyBvh::new(mesh, mesh.source(), shape)?;
                let nodes = lazy.nodes();
                self.accel.structure = Structure::Lazy(lazy);
                nodes
            }
            Method::SpatialSplits => {
                drop(old);
                let bvh = if hurried { build_fast(mesh)? } else { build_spatial(mesh)? };
                let nodes = bvh.nodes().len();
                self.accel.structure = Structure::Bvh(bvh);
                nodes
            }
            Method::Bvh { fast, moved } => {
                self.state.spent.work = if fast || hurried { Work::Other } else { Work::Sah };
                let rotates = matches!(moved, Moved::Rotate | Moved::Auto);
                let recycled = match old {
                    Structure::Bvh(bvh) => bvh,
                    _ if rotates => Bvh::with_room_to_grow(),
                    _ => Bvh::default(),
                };
                let bvh = self.build_bvh(mesh, fast || hurried, recycled)?;
                if rotates {
                    (self.state.wear, self.state.worth) = (Wear::default(), Worth::default());
                    self.state.cost_when_built = bvh.sah_cost();
                }
                let nodes = bvh.nodes().len();
                self.accel.structure = Structure::Bvh(bvh);
                nodes
            }
        };
        Ok(Outcome::Built(nodes))
    }

    /// Builds in the memory of a former tree. What a second build needed is kept, a third one will need it again; most objects
    /// are built once.
    fn build_bvh(&mut self, mesh: &Mesh, fast: bool, old: Bvh) -> Result<Bvh, OutOfMemory> {
        let again = self.state.made_with.is_some();
        let mut scratch = std::mem::take(&mut self.state.scratch);
        let bvh = if fast {
            scratch.sah = SahScratch::default();
            rebuild_fast(mesh, old, &mut scratch.fast)?
        } else {
            scratch.fast = FastScratch::default();
            rebuild_sah(mesh, old, &mut scratch.sah)?
        };
        if again {
            self.state.scratch = scratch;
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
