//! Static instances, merged into one tree (Wald03 §6: "all static triangles in one object").
//!
//! An instance of a [`crate::scene::Motion::Static`] object that the frame places exactly once is evaluated in *world space*:
//! its vertices are transformed once, its structure is built over triangles of the world ([`ObjectState`]), and rays reach
//! it untransformed. When several such instances have stayed the same for some frames, one tree is built over all their
//! triangles on a thread beside the frames, and takes the place of their structures between two of them. Then a
//! scene that was split into objects is traced as if it had not been.
//!
//! # Why the picture does not change by a bit
//!
//! * The triangles are the same: corners come from the same operations ([`append_to_world`]) on the same vertices, and a
//!   triangle's test depends on the ray and on its corners alone.
//! * The winner is the same: merged triangles are numbered in ascending order of (instance, triangle), so ties inside
//!   the merged tree fall as they do between instances. Against the rest of the scene its winner is given its true numbers
//!   first ([`Merged::locate`]) and then compared. When the application places its instances in another order, the
//!   merged triangles are numbered anew.
//!
//! # Change
//!
//! A member that moves, is redefined or vanishes is taken out at once: its triangles get NaN corners, which no ray hits, in one
//! parallel sweep over the blocks; and the object gets a structure of its own as any other does. What was merged of
//! the others stays. So nothing is kept twice: members have no structure of their own, and there is one tree's memory, except while the next one
//! is being built. An object that left has to stay the same for twice as long before it is merged again, each time,
//! so that one that blinks does not keep us building.
//!
//! The copy of the triangles that is built from is made between frames, the build beside them by one thread that exists only as long: on the
//! pool's workers it would keep a frame waiting.

use super::build_sah;
use super::bvh::{Bvh, OutOfMemory};
use super::instance::{append_to_world, mesh_with_room};
use super::object_accel::{Identity, ObjectAccel, ObjectState};
use crate::memory::{cloned, collected, copied, push, repeated, vec_of};
use crate::scene::{Mesh, Name, Scene};
use crate::threads::Pool;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::{Arc, Mutex};

/// Updates for which an instance has to stay the same before it is merged.
const WAIT: u32 = 4;

/// When static instances are merged. None of these changes the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Merging {
    /// Beside the frames, once instances have stayed the same for some.
    #[default]
    Background,
    /// Within the update that first sees them: for tests, and for one long frame.
    AtOnce,
    /// Nothing is begun; what has been merged stays so.
    Never,
}

impl Merging {
    /// From the environment variable `OPENRT_MERGE`: `now` or `never`.
    pub(super) fn from_environment() -> Self {
        match std::env::var("OPENRT_MERGE").as_deref().map(str::trim) {
            Ok("now") => Merging::AtOnce,
            Ok("never") => Merging::Never,
            _ => Merging::Background,
        }
    }
}

/// How often an object is placed in a frame, the number of its last instance, and whether that is masked.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shown {
    pub times: u32,
    pub number: u32,
    /// Some kinds of rays do not see it: it has to stay an instance of its own.
    pub masked: bool,
    /// It is one degenerate instance, which is evaluated in world space whether or not the object is static.
    pub in_world: bool,
}

/// One tree over the triangles of several static instances, in world space.
#[derive(Debug)]
pub struct Merged {
    bvh: Bvh,
    /// In ascending order of `first`, and of `instance`.
    members: Vec<Member>,
    /// The members of triangles `0`, `1 << shift`, `2 << shift`, …, and the last one. Empty without memory for it.
    every: Vec<u32>,
    shift: u32,
}

/// So many entries per member has [`Merged::every`]: then most spans of triangles are of one member.
const SPANS: usize = 8;

#[derive(Clone, Copy, Debug)]
struct Member {
    /// Its triangles have the numbers `first..first + count` in the tree.
    first: u32,
    count: u32,
    slot: u32,
    /// Number within the frame.
    instance: u32,
    object: Name,
    /// False from when it has been taken out.
    live: bool,
}

impl Merged {
    /// The tree; its triangles are numbered through.
    #[inline(always)]
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Instance, object and triangle of the triangle that has number `prim` in the tree.
    #[inline]
    pub fn locate(&self, prim: u32) -> (u32, Name, u32) {
        let span = (prim >> self.shift) as usize;
        let (first, last) = match self.every.get(span..span + 2) {
            Some(ends) => (ends[0] as usize, ends[1] as usize),
            None => (0, self.members.len() - 1),
        };
        let later = self.members[first + 1..=last].partition_point(|m| m.first <= prim);
        let member = &self.members[first + later];
        (member.instance, member.object, prim - member.first)
    }

    /// The number in the tree of triangle `prim` of `instance`, or of the first one that comes after it in the order of instances and triangles.
    pub fn first_from(&self, instance: u32, prim: u32) -> u32 {
        // One by one: those taken out keep numbers that are out of order.
        match self.members.iter().filter(|m| m.live).find(|m| m.instance >= instance) {
            Some(member) if member.instance == instance => member.first + prim.min(member.count),
            Some(member) => member.first,
            None => u32::MAX,
        }
    }

    /// Makes [`Merged::locate`] find its way among the members.
    fn index(&mut self) {
        self.every.clear();
        let Some(last) = self.members.last() else { return };
        let triangles = last.first as usize + last.count as usize;
        self.shift = (0..31).find(|shift| triangles >> shift <= SPANS * self.members.len()).unwrap_or(31);
        let spans = (triangles >> self.shift) + 1;
        if self.every.try_reserve_exact(spans + 1).is_err() {
            return;
        }
        let mut member = 0;
        for span in 0..spans {
            let prim = (span << self.shift) as u32;
            while self.members.get(member + 1).is_some_and(|next| next.first <= prim) {
                member += 1;
            }
            self.every.push(member as u32);
        }
        self.every.push(self.members.len() as u32 - 1);
    }

    /// Instances in the tree.
    pub(super) fn live(&self) -> usize {
        self.members.iter().filter(|m| m.live).count()
    }

    pub(super) fn memory_bytes(&self) -> usize {
        let numbers = self.members.capacity() * size_of::<Member>() + self.every.capacity() * size_of::<u32>();
        self.bvh.memory_bytes() + numbers
    }

    /// A copy.
    fn try_clone(&self) -> Result<Self, OutOfMemory> {
        let (members, every) = (cloned(&self.members)?, copied(&self.every)?);
        Ok(Self { bvh: self.bvh.try_clone()?, members, every, shift: self.shift })
    }

    /// Takes the triangles of the members `gone` out.
    fn erase(&mut self, gone: &[usize]) {
        let Self { bvh, members, .. } = self;
        let is_gone =
            |prim: &u32| gone.iter().any(|&i| (members[i].first..members[i].first + members[i].count).contains(prim));
        bvh.blocks.par_iter_mut().with_min_len(1024).for_each(|block| {
            for lane in 0..block.prims.len() {
                if is_gone(&block.prims[lane]) {
                    block.set_corners(lane, [Vec3::NAN; 3]);
                }
            }
        });
    }

    /// Whether the numbers of the instances are those of the frame.
    fn is_numbered(&self, shown: &[Shown]) -> bool {
        self.members.iter().filter(|m| m.live).all(|m| m.instance == shown[m.slot as usize].number)
    }

    /// Brings the numbers of the instances in line with the frame.
    ///
    /// # Errors
    /// No memory; the tree is of no use then.
    fn renumber(&mut self, shown: &[Shown]) -> Result<(), OutOfMemory> {
        for member in self.members.iter_mut().filter(|m| m.live) {
            member.instance = shown[member.slot as usize].number;
        }
        let mut last = None;
        if self.members.iter().filter(|m| m.live).all(|m| last.replace(m.instance) < Some(m.instance)) {
            return Ok(());
        }
        let old = cloned(&self.members)?;
        let mut order: Vec<usize> = collected(0..old.len())?;
        // Those taken out have no order; at the end they are out of the way.
        order.sort_unstable_by_key(|&i| (!old[i].live, old[i].instance, i));
        let mut firsts = repeated(0, old.len())?;
        let mut first = 0;
        for (member, &i) in self.members.iter_mut().zip(&order) {
            *member = Member { first, ..old[i] };
            firsts[i] = first;
            first += old[i].count;
        }
        self.bvh.blocks.par_iter_mut().with_min_len(1024).for_each(|block| {
            for prim in &mut block.prims {
                let i = old.partition_point(|m| m.first <= *prim) - 1;
                *prim = *prim - old[i].first + firsts[i];
            }
        });
        self.index();
        Ok(())
    }
}

/// A tree that is being built.
struct Task {
    /// Of one thread, at work on this and nothing else. None after it has been waited for.
    pool: Option<Pool>,
    /// A forked child has the task but not the thread.
    process: u32,
    result: Arc<Mutex<Option<Result<Bvh, OutOfMemory>>>>,
    members: Vec<(Member, Identity)>,
}

/// The tree to come, in the place of what is merged.
pub(super) struct Statics {
    pub merging: Merging,
    task: Option<Task>,
    /// A set of instances for which there was no memory; not tried again.
    refused: Vec<Identity>,
    /// What a frame might merge.
    candidates: Vec<(Member, Identity)>,
}

/// What rays traverse, by slot: the objects, and the merged tree.
pub(super) struct Traversed<'a> {
    pub objects: &'a mut [Arc<ObjectAccel>],
    pub merged: &'a mut Option<Arc<Merged>>,
}

impl Traversed<'_> {
    /// The merged tree, to be changed: a copy if a snapshot holds it.
    fn merged(&mut self) -> Result<Option<&mut Merged>, OutOfMemory> {
        let Some(merged) = self.merged else { return Ok(None) };
        if Arc::get_mut(merged).is_none() {
            *merged = Arc::new(merged.try_clone()?);
        }
        Ok(Arc::get_mut(merged))
    }
}

impl Statics {
    pub fn new() -> Self {
        Self { merging: Merging::from_environment(), task: None, refused: Vec::new(), candidates: Vec::new() }
    }

    /// Waits until the tree that is being built is finished; the next update takes it in.
    pub fn wait(&mut self) {
        if let Some(task) = &mut self.task {
            // Its end waits for the job.
            task.pool = None;
        }
    }

    /// To be called when the objects have been brought in line with the frame, of which `shown` tells by slot. Takes out what
    /// has changed, takes in what has been built, and begins what is worth it.
    ///
    /// # Errors
    /// No memory for a copy of a merged tree that a snapshot holds. Its members are not there for rays until the next update.
    pub fn update(
        &mut self,
        scene: &Scene,
        states: &mut [ObjectState],
        mut traversed: Traversed<'_>,
        shown: &[Shown],
    ) -> Result<(), OutOfMemory> {
        let kept = take_out(states, &mut traversed, shown);
        self.take_in(states, &mut traversed, shown);
        if self.merging != Merging::Never && self.task.is_none() {
            self.begin(scene, states, traversed.objects, shown);
            self.take_in(states, &mut traversed, shown);
        }
        let numbered = traversed.merged.as_ref().is_none_or(|merged| merged.is_numbered(shown));
        let numbered = if numbered {
            Ok(())
        } else {
            let renumbered =
                traversed.merged().and_then(|merged| merged.map_or(Ok(()), |merged| merged.renumber(shown)));
            renumbered.inspect_err(|_| dissolve(states, traversed.merged))
        };
        kept.and(numbered)
    }

    /// Puts a finished tree in the place of its members' own structures.
    fn take_in(&mut self, states: &mut [ObjectState], traversed: &mut Traversed<'_>, shown: &[Shown]) {
        let Some(task) = &mut self.task else { return };
        if task.process != std::process::id() {
            self.task = None;
            return;
        }
        // Never waits: the thread holds the lock only to leave its result.
        let Some(result) = task.result.try_lock().ok().and_then(|mut result| result.take()) else { return };
        let Some(task) = self.task.take() else { return };
        let bvh = match result {
            Ok(bvh) => bvh,
            Err(_) => {
                self.refused = identities(&task.members);
                return;
            }
        };
        // Without memory for it the tree is built again.
        let (Ok(members), Ok(mut gone)) = (vec_of(task.members.len()), vec_of(task.members.len())) else { return };
        let mut merged = Merged { bvh, members, every: Vec::new(), shift: 0 };
        for (i, (mut member, identity)) in task.members.into_iter().enumerate() {
            let slot = member.slot as usize;
            member.live = shown[slot].times == 1 && !shown[slot].masked && states[slot].identity() == Some(identity);
            if !member.live {
                gone.push(i);
            }
            merged.members.push(member);
        }
        if merged.live() < 2 {
            return;
        }
        merged.index();
        if !gone.is_empty() {
            merged.erase(&gone);
        }
        for member in merged.members.iter().filter(|m| m.live) {
            let slot = member.slot as usize;
            states[slot].enter_merged(&mut traversed.objects[slot]);
        }
        // Who lives in the tree before is also in this one: nobody joins a tree but in a new one, which begins with them all.
        *traversed.merged = Some(Arc::new(merged));
    }

    /// Has a tree built over all instances that have stayed the same long enough, if that would add one.
    fn begin(&mut self, scene: &Scene, states: &[ObjectState], objects: &[Arc<ObjectAccel>], shown: &[Shown]) {
        let wait = if self.merging == Merging::AtOnce { 0 } else { WAIT };
        self.candidates.clear();
        let mut fresh = false;
        for (slot, ((state, object), shown)) in states.iter().zip(objects).zip(shown).enumerate() {
            if shown.times != 1 || shown.masked {
                continue;
            }
            let Some(identity) = state.identity().filter(|_| state.may_merge(object, wait)) else { continue };
            fresh |= !state.is_merged();
            let (slot, instance, count) = (slot as u32, shown.number, object.triangles() as u32);
            let member = Member { first: 0, count, slot, instance, object: state.name(), live: true };
            if push(&mut self.candidates, (member, identity)).is_err() {
                return;
            }
        }
        if !fresh || self.candidates.len() < 2 {
            return;
        }
        let members = &mut self.candidates;
        members.sort_unstable_by_key(|(member, _)| member.instance);
        let mut first = 0u32;
        for (member, _) in members.iter_mut() {
            member.first = first;
            // More is refused below.
            first = first.saturating_add(member.count);
        }
        if self.refused.iter().eq(members.iter().map(|(_, identity)| identity)) {
            return;
        }
        let mesh = match gather(scene, members) {
            Ok(mesh) => mesh,
            Err(_) => {
                self.refused = identities(members);
                return;
            }
        };
        let result = Arc::new(Mutex::new(None));
        let mut pool = None;
        if self.merging == Merging::AtOnce {
            result.lock().expect("nobody else has it").replace(build_sah(&mesh));
        } else {
            // Without a thread all stays as it is; the next update tries again.
            let Ok(thread) = Pool::new(Some(1)) else { return };
            let result = result.clone();
            let spawned = thread.spawn(move || {
                let built = build_sah(&mesh);
                drop(mesh);
                if let Ok(mut result) = result.lock() {
                    *result = Some(built);
                }
            });
            if spawned.is_err() {
                return;
            }
            pool = Some(thread);
        }
        let members = std::mem::take(&mut self.candidates);
        self.task = Some(Task { pool, process: std::process::id(), result, members });
    }
}

/// Of a tree's members; of none without memory, and then it is tried again.
fn identities(members: &[(Member, Identity)]) -> Vec<Identity> {
    collected(members.iter().map(|(_, identity)| *identity)).unwrap_or_default()
}

/// Takes members that have changed or are not shown out of the merged tree.
fn take_out(states: &mut [ObjectState], traversed: &mut Traversed<'_>, shown: &[Shown]) -> Result<(), OutOfMemory> {
    let Some(merged) = traversed.merged.as_deref() else { return Ok(()) };
    let is_gone = |member: &Member, state: &ObjectState| shown[member.slot as usize].times == 0 || !state.is_merged();
    let leaves = |member: &Member| member.live && is_gone(member, &states[member.slot as usize]);
    if !merged.members.iter().any(leaves) {
        return Ok(());
    }
    let gone = vec_of(merged.members.len());
    let (merged, mut gone) = match (traversed.merged(), gone) {
        (Ok(Some(merged)), Ok(gone)) => (merged, gone),
        (Ok(None), _) => return Ok(()),
        (Err(error), _) | (_, Err(error)) => {
            dissolve(states, traversed.merged);
            return Err(error);
        }
    };
    for (i, member) in merged.members.iter_mut().enumerate().filter(|(_, m)| m.live) {
        let state = &mut states[member.slot as usize];
        if is_gone(member, state) {
            if state.is_merged() {
                state.leave_merged();
            }
            member.live = false;
            gone.push(i);
        }
    }
    if merged.live() == 0 {
        *traversed.merged = None;
    } else {
        merged.erase(&gone);
    }
    Ok(())
}

/// Gives the merged tree up: the next update builds structures for its members.
fn dissolve(states: &mut [ObjectState], merged: &mut Option<Arc<Merged>>) {
    let Some(old) = merged.take() else { return };
    for member in old.members.iter().filter(|m| m.live) {
        let state = &mut states[member.slot as usize];
        if state.is_merged() {
            state.leave_merged();
        }
    }
}

/// The triangles of all members in world space, one after the other.
fn gather(scene: &Scene, members: &[(Member, Identity)]) -> Result<Mesh, OutOfMemory> {
    let mesh_of = |member: &Member| scene.objects.get(&member.object).map(|object| &*object.mesh);
    let sum = |of: fn(&Mesh) -> usize| members.iter().filter_map(|(m, _)| mesh_of(m)).map(of).sum::<usize>();
    let (vertices, triangles) = (sum(|mesh| mesh.positions.len()), sum(|mesh| mesh.triangles.len()));
    let mut all = mesh_with_room(vertices, triangles)?;
    for (member, identity) in members {
        let Some(mesh) = mesh_of(member) else { continue };
        append_to_world(&mut all, mesh, &identity.world_from_object);
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test_meshes::Random;

    #[test]
    fn a_triangle_is_found_among_members_of_all_sizes() {
        let mut random = Random::new(Random::seed(161));
        for members in [1, 2, 3, 50, 400] {
            let mut first = 0;
            let mut one = |i: usize| {
                // Many of one triangle between few of many.
                let count = if random.below(8) == 0 { 1 + random.below(5000) as u32 } else { 1 };
                let number = i as u32;
                first += count;
                Member { first: first - count, count, slot: 0, instance: number, object: 1000 + number, live: true }
            };
            let members: Vec<Member> = (0..members).map(&mut one).collect();
            let mut merged = Merged { bvh: Bvh::default(), members, every: Vec::new(), shift: 0 };
            for indexed in [false, true] {
                if indexed {
                    merged.index();
                    assert!(merged.every.len() <= SPANS * merged.members.len() + 2);
                }
                for member in &merged.members {
                    for prim in [0, member.count / 2, member.count - 1] {
                        let expected = (member.instance, member.object, prim);
                        assert_eq!(merged.locate(member.first + prim), expected, "indexed: {indexed}");
                    }
                }
            }
        }
    }
}
