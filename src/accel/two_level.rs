//! The two-level structure of one frame: a tree over instances, instances over object structures (Wald03 §4.1, figure 3).
//!
//! The tree is an 8-wide bounding volume hierarchy ([`super::top_level_bvh`]), or on request the BSP of Wald03 §4.5. Against the BSP it
//! is built in half the time or less (161 instances 0.05 ms against 0.10, 661 0.17 against 0.49, 10,000 4.9
//! against 13.7) and traced faster by single rays: 1.4 to 1.5 times on 161 parts of robots, 1.2 to 1.8 on 661
//! trees, 1.3 to 2.3 on 10,000 overlapping instances; only for shadow rays among instances that overlap tenfold are they equal. So it is what
//! is built unless something else is asked for. (AVX2, one thread, both in one run.)
//!
//! An update brings the structures of the objects that are *instanced in this frame* in line with the scene, in parallel,
//! drops those of deleted objects, and rebuilds everything that is per instance: inverse matrices, world boxes, top level. Objects that
//! are not shown cost nothing; they catch up when they are shown again. All vectors are kept, so that a frame like the one
//! before allocates nothing here.

use super::by_rays::{Balance, Done, LARGE, Ledger, Stakes};
use super::degenerate::is_degenerate;
use super::instance::invert;
use super::object_accel::{ObjectState, Outcome, Spent, Work};
use super::place::{Placed, Seat, Seated};
use super::statics::{Merged, Merging, Shown, Statics, Traversed};
use super::strategy::{forced_by_environment, forced_top_level};
use super::top_level_bsp::TopLevelBsp;
use super::top_level_bvh::TopLevelBvh;
use super::world_view::{TopLevel, WorldView};
use crate::scene::{Instance, InstanceList, Mask, Motion, NameMap, Scene, Strategy, TopLevelKind};
use crate::simd::Level;
use rayon::prelude::*;
use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// What an update did and what is held now.
#[derive(Clone, Copy, Debug, Default)]
pub struct UpdateStats {
    /// Structures built anew.
    pub objects_built: u32,
    /// Structures brought up to date in place.
    pub objects_refitted: u32,
    /// Objects whose vertices have moved and whose structures wait for a ray, as none came in the frame before.
    pub objects_waiting: u32,
    /// Objects whose structures are brought up to date by the rays that reach them, as the automatic choice has found that to pay.
    pub objects_by_rays: u32,
    /// Nodes of object structures written by this update. A BSP is built by the first ray, which is not counted.
    pub nodes_updated: u64,
    /// Triangles after instancing.
    pub triangles: u64,
    /// Bytes held by all structures, those of objects not in this frame included.
    pub bytes: u64,
    /// Instances, world boxes and the top-level BSP.
    pub top_level_seconds: f64,
    /// Bytes that could not be had for an object's structure, which is then invisible, or for the top level: nothing is visible
    /// then. 0 if all went well.
    pub out_of_memory: u64,
    /// Static instances that are traced by way of the merged tree.
    pub merged_instances: u32,
}

/// What rays traverse ([`WorldView`]), and what brings it up to date.
pub struct TwoLevel {
    forced: Option<Strategy>,
    asked_top: TopLevelKind,
    forced_top: Option<TopLevelKind>,
    view: Arc<WorldView>,
    /// Objects by slot; unused slots have name 0.
    states: Vec<ObjectState>,
    slot_of: NameMap<u32>,
    /// Of the degenerate instances of the frame, one for each.
    own_slots: Vec<u32>,
    free_slots: Vec<u32>,
    /// Per slot: what this frame's update did, `None` if the object is not in it.
    outcomes: Vec<Option<Outcome>>,
    /// Per instance of the frame: its object's slot, or `u32::MAX`.
    slots: Vec<u32>,
    /// Per slot.
    shown: Vec<Shown>,
    balance: Balance,
    /// What rays took since the last update, in nanoseconds.
    traced: AtomicU64,
    statics: Statics,
}

impl TwoLevel {
    /// An empty world, whose kernels are those of `level`.
    pub fn new(level: Level) -> Self {
        Self {
            view: Arc::new(WorldView::new(level)),
            forced: forced_by_environment(),
            asked_top: TopLevelKind::Auto,
            forced_top: forced_top_level(),
            states: Vec::new(),
            slot_of: NameMap::default(),
            own_slots: Vec::new(),
            free_slots: Vec::new(),
            outcomes: Vec::new(),
            slots: Vec::new(),
            shown: Vec::new(),
            balance: Balance::default(),
            traced: AtomicU64::new(0),
            statics: Statics::new(),
        }
    }

    /// Builds every object by `strategy` whatever it asks for, as `OPENRT_ACCEL` does; `None` ends that.
    pub fn force_strategy(&mut self, strategy: Option<Strategy>) {
        self.forced = strategy.filter(|s| *s != Strategy::Auto);
    }

    /// The kind of top level that the application asks for. Counts from the next update on.
    pub fn choose_top_level(&mut self, kind: TopLevelKind) {
        self.asked_top = kind;
    }

    /// Builds the top level as `kind` whatever is asked for, as `OPENRT_TOPLEVEL` does; `None` or `Auto` ends that. Counts from the next update on.
    pub fn force_top_level(&mut self, kind: Option<TopLevelKind>) {
        self.forced_top = kind.filter(|k| *k != TopLevelKind::Auto);
    }

    /// When static instances are merged; `OPENRT_MERGE` says so at first. Counts from the next update on.
    pub fn set_merging(&mut self, merging: Merging) {
        self.statics.merging = merging;
    }

    /// Waits for the tree of static instances that is being built beside the frames, if there is one. The next update takes it in.
    pub fn wait_for_merge(&mut self) {
        self.statics.wait();
    }

    /// What rays traverse, to be held as long as one likes: the next update leaves it as it is.
    pub fn view(&self) -> &Arc<WorldView> {
        &self.view
    }

    /// Says how long the rays of a picture or a batch have taken, in seconds of wall clock. [`Strategy::Auto`] weighs updates against it, and so does
    /// [`Strategy::Rotate`] builds of worn trees; who does not say so gets structures that are up to date before the first ray, and built where they are worn.
    pub fn add_traced(&self, seconds: f64) {
        self.traced.fetch_add((seconds * 1e9) as u64, Ordering::Relaxed);
    }

    /// Brings everything in line with the scene and the frame's instances. Instances of objects that do not exist or
    /// have no triangles, and instances with a matrix that is not finite, draw nothing.
    /// To be called inside the pool.
    pub fn update(&mut self, scene: &Scene, instances: &[Instance]) -> UpdateStats {
        self.update_list(scene, InstanceList::plain(instances))
    }

    /// As [`TwoLevel::update`], for instances that the application knows by other numbers, see [`WorldView::number_of`].
    pub fn update_list(&mut self, scene: &Scene, list: InstanceList<'_>) -> UpdateStats {
        let instances = list.instances;
        let mut stats = UpdateStats::default();
        if Arc::get_mut(&mut self.view).is_none() {
            // A snapshot keeps the one before.
            match self.view.successor() {
                Ok(view) => self.view = Arc::new(view),
                Err(_) => {
                    let objects = self.view.objects();
                    return UpdateStats { out_of_memory: size_of_val(objects) as u64, ..stats };
                }
            }
        }
        if exclusive(&mut self.view).set_numbers(list.numbers).is_err() {
            return UpdateStats { out_of_memory: size_of_val(list.numbers) as u64, ..stats };
        }
        self.drop_deleted(scene);
        self.update_objects(scene, instances, &mut stats);
        let Self { view, states, statics, shown, .. } = self;
        let view = exclusive(view);
        let traversed = Traversed { objects: &mut view.objects, merged: &mut view.merged };
        if let Err(error) = statics.update(scene, states, traversed, shown) {
            stats.out_of_memory += error.bytes as u64;
        }
        stats.merged_instances = view.merged.as_deref().map_or(0, Merged::live) as u32;
        let begin = Instant::now();
        self.update_top_level(instances, &mut stats);
        stats.top_level_seconds = begin.elapsed().as_secs_f64();
        let states = self.states.iter().map(ObjectState::memory_bytes).sum::<usize>();
        stats.bytes = (self.view.memory_bytes() + states) as u64;
        stats
    }

    fn update_top_level(&mut self, instances: &[Instance], stats: &mut UpdateStats) {
        let Self { view, states, slots, asked_top, forced_top, .. } = self;
        let WorldView { objects, merged, placed, top_level, .. } = exclusive(view);
        let kind = match forced_top.unwrap_or(*asked_top) {
            TopLevelKind::Bsp => TopLevelKind::Bsp,
            TopLevelKind::Bvh | TopLevelKind::Auto => TopLevelKind::Bvh,
        };
        if top_level.kind() != kind {
            *top_level = match kind {
                TopLevelKind::Bsp => TopLevel::Bsp(TopLevelBsp::default()),
                TopLevelKind::Bvh | TopLevelKind::Auto => TopLevel::Bvh(TopLevelBvh::default()),
            };
        }
        let seat_of = |slot: u32| {
            let (state, object) = (&states[slot as usize], &objects[slot as usize]);
            let seat = match state.placed() {
                Some(_) if state.is_merged() => Seat::Merged,
                Some(_) => Seat::World(object.bounds()),
                None => Seat::Object(object.bounds()),
            };
            Seated { seat, mask: state.mask(), triangles: object.triangles() }
        };
        let mut result = placed.place(instances, slots, seat_of);
        if let (Some(merged), Ok(())) = (merged, result) {
            result = placed.add_merged(merged.bvh().bounds());
        }
        let Placed { boxes, boxed, .. } = placed;
        let built = match top_level {
            TopLevel::Bsp(bsp) => bsp.build(boxed, |i| boxes[i as usize]),
            TopLevel::Bvh(bvh) => bvh.build(boxed, boxes),
        };
        if let Err(error) = result.and(built) {
            stats.out_of_memory += error.bytes as u64;
        }
        stats.triangles = placed.triangles;
    }

    fn drop_deleted(&mut self, scene: &Scene) {
        let Self { slot_of, own_slots, states, view, free_slots, .. } = self;
        let objects = &mut exclusive(view).objects;
        for &slot in &*own_slots {
            let state = &mut states[slot as usize];
            if !scene.objects.contains_key(&state.name()) {
                *state = ObjectState::default();
                objects[slot as usize] = Arc::default();
            }
        }
        slot_of.retain(|name, slot| {
            let exists = scene.objects.contains_key(name);
            if !exists {
                states[*slot as usize] = ObjectState::default();
                objects[*slot as usize] = Arc::default();
                free_slots.push(*slot);
            }
            exists
        });
    }

    fn update_objects(&mut self, scene: &Scene, instances: &[Instance], stats: &mut UpdateStats) {
        let Self { view, states, slot_of, own_slots, free_slots, outcomes, slots, shown, .. } = self;
        let objects = &mut exclusive(view).objects;
        outcomes.clear();
        outcomes.resize(states.len(), None);
        shown.clear();
        shown.resize(states.len(), Shown::default());
        slots.clear();
        if slots.try_reserve(instances.len()).is_err() {
            stats.out_of_memory += size_of_val(instances) as u64;
            return;
        }
        let mut degenerate = 0;
        for (number, instance) in instances.iter().enumerate() {
            let in_world = is_degenerate(&instance.world_from_object);
            // A slot is there only for an object that exists: see drop_deleted().
            let known = if in_world { own_slots.get(degenerate) } else { slot_of.get(&instance.object) };
            let known = known.copied().filter(|&slot| states[slot as usize].name() == instance.object);
            let slot = known.or_else(|| {
                scene.objects.get(&instance.object)?;
                let fresh = ObjectState::new(instance.object);
                let other = if in_world { own_slots.get(degenerate).copied() } else { None };
                let slot = if let Some(slot) = other.or_else(|| free_slots.pop()) {
                    states[slot as usize] = fresh;
                    objects[slot as usize] = Arc::default();
                    slot
                } else {
                    states.push(fresh);
                    objects.push(Arc::default());
                    outcomes.push(None);
                    shown.push(Shown::default());
                    states.len() as u32 - 1
                };
                if !in_world {
                    slot_of.insert(instance.object, slot);
                } else if other.is_none() {
                    own_slots.push(slot);
                }
                Some(slot)
            });
            slots.push(slot.unwrap_or(u32::MAX));
            if let Some(slot) = slot {
                degenerate += usize::from(in_world);
                outcomes[slot as usize] = Some(Outcome::Unchanged);
                let shown = &mut shown[slot as usize];
                let mask = scene.objects.get(&instance.object).map_or(Mask::ALL, |object| object.mask);
                states[slot as usize].set_mask(mask);
                let masked = mask.and(instance.mask) != Mask::ALL;
                *shown = Shown { times: shown.times.saturating_add(1), number: number as u32, masked, in_world };
            }
        }
        for slot in own_slots.drain(degenerate..) {
            states[slot as usize] = ObjectState::default();
            objects[slot as usize] = Arc::default();
            free_slots.push(slot);
        }
        let mut stakes = Stakes::default();
        for ((state, accel), _) in states.iter().zip(&*objects).zip(&*outcomes).filter(|(_, outcome)| outcome.is_some())
        {
            let part = scene.objects.get(&state.name()).and_then(|object| state.could_be_left_to_rays(accel, object));
            part.inspect(|part| stakes.add(accel.triangles(), *part));
        }
        let traced = std::mem::take(self.traced.get_mut()) as f64 * 1e-9;
        let by_rays = self.balance.decide(traced, &stakes);
        let met = objects.iter().map(|accel| accel.visits.met()).sum::<u64>();
        for (state, accel) in states.iter_mut().zip(&mut *objects) {
            state.tell_traced(traced, accel.visits.take_met(), met);
            if let Some(accel) = Arc::get_mut(accel) {
                accel.forget_touched();
            }
        }
        let build_price = self.balance.fast_build();
        let forced = self.forced;
        let begin = Instant::now();
        let all = states.par_iter_mut().zip(&mut *objects).zip(outcomes).zip(shown);
        all.for_each(|(((state, accel), outcome), shown)| {
            if let (Some(outcome), Some(object)) = (outcome, scene.objects.get(&state.name())) {
                // All rays see the merged tree.
                if shown.masked && state.is_merged() {
                    state.leave_merged();
                }
                let is_static = shown.times == 1 && object.motion == Motion::Static;
                let placed = (is_static || shown.in_world)
                    .then(|| instances[shown.number as usize].world_from_object)
                    // Others draw nothing, see place().
                    .filter(|m| shown.in_world || invert(m).is_some());
                *outcome = state.update(accel, object, forced, placed, by_rays, build_price);
            }
        });
        let wall = begin.elapsed().as_secs_f64();
        let mut ledger = Ledger::default();
        for ((state, accel), outcome) in self.states.iter().zip(&self.view.objects).zip(&self.outcomes) {
            if outcome.is_none() {
                continue;
            }
            let Spent { work, seconds } = state.spent();
            ledger.all += seconds;
            let add = |done: &mut Done| {
                done.triangles += accel.triangles() as f64;
                done.seconds += seconds;
            };
            match work {
                Work::Refit if accel.triangles() >= LARGE => add(&mut ledger.refits),
                Work::Sah if accel.triangles() >= LARGE => add(&mut ledger.builds),
                _ => {}
            }
            stats.objects_by_rays += u32::from(state.is_left_to_rays(accel));
        }
        self.balance.learn(&ledger, wall);
        for outcome in self.outcomes.iter().flatten() {
            match *outcome {
                Outcome::Unchanged => {}
                Outcome::Built(nodes) => {
                    stats.objects_built += 1;
                    stats.nodes_updated += nodes as u64;
                }
                Outcome::Refitted(nodes) => {
                    stats.objects_refitted += 1;
                    stats.nodes_updated += nodes as u64;
                }
                Outcome::Waits => stats.objects_waiting += 1,
                Outcome::Failed(error) => stats.out_of_memory += error.bytes as u64,
            }
        }
    }
}

impl Deref for TwoLevel {
    type Target = WorldView;

    #[inline(always)]
    fn deref(&self) -> &WorldView {
        &self.view
    }
}

/// The view, for an update to change: at its beginning it has seen to that nobody else holds it.
fn exclusive(view: &mut Arc<WorldView>) -> &mut WorldView {
    Arc::get_mut(view).expect("a snapshot is taken between updates")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Structure;
    use crate::accel::test_meshes::{Random, bumpy_sphere, soup};
    use crate::scene::{Command, Mesh, Motion};
    use glam::Affine3A;

    fn scene(mesh: Mesh, motion: Motion) -> Scene {
        let mut scene = Scene::default();
        scene.apply(Command::DefineObject { name: 1, mesh, motion });
        scene
    }

    fn shake(scene: &mut Scene, random: &mut Random, size: f32) {
        let positions = scene.objects[&1].mesh.positions.iter().map(|p| *p + random.vec() * size).collect();
        scene.apply(Command::UpdatePositions { name: 1, first: 0, positions });
    }

    const HERE: [Instance; 1] = [Instance::new(1, Affine3A::IDENTITY)];

    fn world(strategy: Strategy) -> TwoLevel {
        let mut world = TwoLevel::new(Level::Scalar);
        world.force_strategy(Some(strategy));
        world
    }

    #[test]
    fn moving_vertices_are_refit_until_the_tree_is_worn() {
        let mut random = Random::new(Random::seed(1));
        let mut scene = scene(bumpy_sphere(20, 30), Motion::Unstructured);
        let mut world = world(Strategy::Auto);
        let mut update = |scene: &Scene| {
            let stats = world.update(scene, &HERE);
            // A ray comes.
            world.objects()[0].structure();
            (stats.objects_built, stats.objects_refitted)
        };
        assert_eq!(update(&scene), (1, 0));
        assert_eq!(update(&scene), (0, 0));
        shake(&mut scene, &mut random, 1e-3);
        assert_eq!(update(&scene), (0, 1));
        // Far from what it was built for.
        shake(&mut scene, &mut random, 2.0);
        assert_eq!(update(&scene), (1, 0));
        shake(&mut scene, &mut random, 1e-3);
        assert_eq!(update(&scene), (0, 1), "a single defeat says nothing of the next move");
        scene.apply(Command::DefineObject { name: 1, mesh: bumpy_sphere(5, 5), motion: Motion::Unstructured });
        assert_eq!(update(&scene), (1, 0));
    }

    #[test]
    fn who_is_met_by_few_rays_is_built_anew_when_these_have_lost_enough() {
        for strategy in [Strategy::Rotate, Strategy::Auto] {
            let mut random = Random::new(Random::seed(3));
            let mut scene = Scene::default();
            for name in [1, 2] {
                let mesh = bumpy_sphere(20, 30);
                scene.apply(Command::DefineObject { name, mesh, motion: Motion::Unstructured });
            }
            let both = [1, 2].map(|object| Instance { object, ..HERE[0] });
            let mut world = world(strategy);
            world.update(&scene, &both);
            // 4 us per triangle for building fast. Objects as small as these teach nothing else.
            let refits = Done { triangles: 1e6, seconds: 1.0 };
            world.balance.learn(&Ledger { refits, all: 1.0, ..Ledger::default() }, 1.0);
            let mut update = |scene: &Scene| {
                (0..1000).for_each(|_| _ = world.objects()[0].structure());
                (0..3).for_each(|_| _ = world.objects()[1].structure());
                world.add_traced(0.002);
                let stats = world.update(scene, &both);
                let built = |slot: usize| matches!(world.outcomes[slot], Some(Outcome::Built(_)));
                assert_eq!(stats.objects_built, u32::from(built(0)) + u32::from(built(1)));
                [built(0), built(1)]
            };
            let shaken = [1, 2].map(|name: u32| {
                let positions: Vec<_> =
                    scene.objects[&name].mesh.positions.iter().map(|p| *p + random.vec() * 2.0).collect();
                (name, positions)
            });
            let mut apply = || {
                for (name, positions) in &shaken {
                    let positions = positions.clone();
                    scene.apply(Command::UpdatePositions { name: *name, first: 0, positions });
                }
                update(&scene)
            };
            assert_eq!(apply(), [true, false], "{}", strategy.name());
            let later: Vec<_> = (0..1000).map(|_| apply()).collect();
            assert!(later[..5].iter().all(|built| *built == [false, false]), "{}", strategy.name());
            assert_eq!(later.iter().filter(|built| built[1]).count(), 1, "lost little by little, {}", strategy.name());
        }
    }

    #[test]
    fn every_strategy_answers_a_vertex_update_its_own_way() {
        let mut random = Random::new(Random::seed(2));
        for (strategy, built, refitted) in [
            (Strategy::Sah, 1, 0),
            (Strategy::FastBuild, 1, 0),
            (Strategy::Refit, 0, 1),
            (Strategy::Rotate, 1, 0),
            (Strategy::Grid, 1, 0),
            (Strategy::VisibilityField, 0, 1),
            (Strategy::Bsp, 1, 0),
        ] {
            let mut scene = scene(bumpy_sphere(8, 9), Motion::Affine);
            let mut world = world(strategy);
            assert_eq!(world.update(&scene, &HERE).objects_built, 1);
            assert_eq!(matches!(world.objects()[0].structure(), Structure::Bsp(_)), strategy == Strategy::Bsp);
            shake(&mut scene, &mut random, 3.0);
            let stats = world.update(&scene, &HERE);
            assert_eq!((stats.objects_built, stats.objects_refitted), (built, refitted), "{}", strategy.name());
        }
    }

    #[test]
    fn the_top_level_is_the_one_asked_for_and_only_that_is_held() {
        let scene = scene(bumpy_sphere(3, 4), Motion::Affine);
        let mut world = TwoLevel::new(Level::Scalar);
        world.force_top_level(None);
        let mut kind = |change: &dyn Fn(&mut TwoLevel)| {
            change(&mut world);
            world.update(&scene, &HERE);
            world.top_level().kind()
        };
        assert_eq!(kind(&|_| {}), TopLevelKind::Bvh);
        assert_eq!(kind(&|w| w.choose_top_level(TopLevelKind::Bsp)), TopLevelKind::Bsp);
        assert_eq!(kind(&|w| w.force_top_level(Some(TopLevelKind::Bvh))), TopLevelKind::Bvh);
        assert_eq!(kind(&|w| w.force_top_level(Some(TopLevelKind::Auto))), TopLevelKind::Bsp);
        assert_eq!(kind(&|w| w.choose_top_level(TopLevelKind::Auto)), TopLevelKind::Bvh);
    }

    #[test]
    fn only_what_is_shown_is_built_and_only_what_exists_is_kept() {
        let mut random = Random::new(Random::seed(3));
        let mut scene = scene(soup(&mut random, 500, 0.1), Motion::Affine);
        scene.apply(Command::DefineObject { name: 2, mesh: soup(&mut random, 500, 0.1), motion: Motion::Affine });
        let mut world = world(Strategy::Sah);
        let both = [1, 2, 1].map(|object| Instance::new(object, Affine3A::IDENTITY));
        let one = world.update(&scene, &HERE);
        assert_eq!((one.objects_built, one.triangles), (1, 500));
        let two = world.update(&scene, &both);
        assert_eq!((two.objects_built, two.triangles), (1, 1500));
        assert!(two.bytes > one.bytes + 20_000);
        // Hidden, it stays; deleted, it goes, and its slot is used again.
        assert!(world.update(&scene, &HERE).bytes > one.bytes + 20_000);
        scene.apply(Command::DeleteObject { name: 2 });
        let after = world.update(&scene, &both);
        assert_eq!((after.objects_built, world.instances().len()), (0, 2));
        assert!(after.bytes < one.bytes + 5_000, "{} bytes, {} with one object", after.bytes, one.bytes);
        scene.apply(Command::DefineObject { name: 3, mesh: soup(&mut random, 10, 0.1), motion: Motion::Affine });
        let third = [Instance::new(3, Affine3A::IDENTITY)];
        assert_eq!(world.update(&scene, &third).objects_built, 1);
        assert_eq!(world.objects().len(), 2);
        assert!(world.update(&scene, &[]).triangles == 0 && world.instances().is_empty());
    }
}
