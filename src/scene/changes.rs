//! Commands that wait for a frame, without those that a later one has made void.
//!
//! An application may change the same things many times between two frames, or while a frame takes long. What waits is bounded by what it changes,
//! not by how often: a definition takes the place of an earlier one and of all updates before it, a setting that of the same setting, an update of
//! vertices that of an update of the same vertices, and updates of many small parts are merged from time to time. Updates of an object whose
//! definition waits itself go right into its mesh.
//!
//! Applied one after the other, what is left does the same as everything that was added. Adding costs a look at what waits for the same thing,
//! and merging the logarithm of the number of vertices for each one updated.

use super::{Command, Mesh, Name, Scene};
use crate::memory::{OutOfMemory, Room};
use glam::Vec3;
use std::collections::{HashMap, TryReserveError};

/// Kinds of things that commands change. A void command is of the same thing as the one that makes it void, but for positions and
/// normals, which a definition makes void.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Thing {
    Object,
    Positions,
    Normals,
    Class,
    Shader,
    Texture,
}

/// See the module head.
#[derive(Default)]
pub struct Changes {
    waiting: Vec<Waiting>,
    chains: HashMap<(Thing, Name), Chain>,
    /// Places of `waiting` whose command is void.
    holes: usize,
}

struct Waiting {
    /// None: void.
    command: Option<Command>,
    /// Place of the command before for the same thing, or [`NONE`].
    before: usize,
}

/// What waits for one thing.
struct Chain {
    last: usize,
    /// Vertices in updates, and something for each update.
    weight: usize,
    /// Updates are merged when they weigh more.
    limit: usize,
}

const NONE: usize = usize::MAX;
/// What an update weighs beside its vertices.
const UPDATE_WEIGHT: usize = 8;
const LEAST_LIMIT: usize = 4096;
/// So few void commands are not cleared away.
const FEW_HOLES: usize = 64;

impl Changes {
    /// Makes room for `n` commands, which [`Changes::add`] then takes without fail.
    ///
    /// # Errors
    /// No memory.
    pub fn reserve(&mut self, n: usize) -> Result<(), TryReserveError> {
        self.waiting.try_reserve(n)?;
        self.chains.try_reserve(n)
    }

    /// Adds a command behind those that wait. `scene` is what they will be applied to, if it is at hand: then the deletion of
    /// something that never got there leaves no trace.
    pub fn add(&mut self, mut command: Command, scene: Option<&Scene>) {
        let Some(key) = thing_of(&command) else { return };
        match &mut command {
            Command::UpdatePositions { name, first, positions } => {
                if let Some(mesh) = self.waiting_mesh(*name) {
                    return overwrite(&mut mesh.positions, *first, positions);
                }
            }
            Command::MovePositions { name, vertices, positions } => {
                if let Some(mesh) = self.waiting_mesh(*name) {
                    return scatter(&mut mesh.positions, vertices, positions);
                }
            }
            Command::UpdateNormals { name, first, normals } => {
                if let Some(mesh) = self.waiting_mesh(*name) {
                    return overwrite(&mut mesh.normals, *first, normals);
                }
            }
            Command::DefineObject { name, .. } | Command::DeleteObject { name } => {
                self.clear((Thing::Positions, *name));
                self.clear((Thing::Normals, *name));
            }
            _ => {}
        }
        self.make_void(key, &command);
        let unknown = match command {
            Command::DeleteObject { name } => scene.is_some_and(|s| !s.objects.contains_key(&name)),
            Command::DeleteShader { name } => scene.is_some_and(|s| !s.shaders.contains_key(&name)),
            Command::DeleteTexture { name } => scene.is_some_and(|s| !s.textures.contains_key(&name)),
            _ => false,
        };
        if !unknown {
            self.push(key, command);
        }
        if self.holes > FEW_HOLES.max(self.waiting.len() / 2) {
            self.close_holes();
        }
    }

    /// Gets the memory that applying takes, also for `more` objects that are yet to come; then it cannot fail.
    ///
    /// # Errors
    /// No memory. The scene is what it was.
    pub fn prepare(&self, scene: &mut Scene, more: usize) -> Result<(), OutOfMemory> {
        let commands = || self.waiting.iter().filter_map(|waiting| waiting.command.as_ref());
        let count = |is_one: fn(&Command) -> bool| commands().filter(|command| is_one(command)).count();
        scene.classes.room(count(|command| matches!(command, Command::DefineClass { .. })))?;
        scene.shaders.room(count(|command| matches!(command, Command::DefineShader { .. })))?;
        scene.textures.room(count(|command| matches!(command, Command::DefineTexture { .. })))?;
        for command in commands() {
            scene.prepare(command)?;
        }
        scene.objects.room(more)
    }

    /// Applies what waits, in order; nothing waits afterwards.
    pub fn apply_to(&mut self, scene: &mut Scene) {
        self.chains.clear();
        self.holes = 0;
        self.waiting.drain(..).filter_map(|w| w.command).for_each(|command| scene.apply(command));
    }

    fn push(&mut self, key: (Thing, Name), command: Command) {
        let weight = command.update_weight();
        let last = self.waiting.len();
        let chain = self.chains.entry(key).or_insert(Chain { last: NONE, weight: 0, limit: LEAST_LIMIT });
        self.waiting.push(Waiting { command: Some(command), before: chain.last });
        chain.last = last;
        chain.weight += weight;
        if chain.weight > chain.limit {
            self.merge(key);
        }
    }

    /// Takes out what `new` makes void. Of updates only the last ones are looked at, so that many small ones do not cost their square.
    fn make_void(&mut self, key: (Thing, Name), new: &Command) {
        let Some(chain) = self.chains.get_mut(&key) else { return };
        let mut after = NONE;
        let mut place = chain.last;
        while place != NONE {
            let before = self.waiting[place].before;
            let old = self.waiting[place].command.as_ref().expect("a chain leads through what waits");
            if new.voids(old) {
                chain.weight -= old.update_weight();
                self.waiting[place].command = None;
                self.holes += 1;
                match after {
                    NONE => chain.last = before,
                    _ => self.waiting[after].before = before,
                }
            } else if matches!(key.0, Thing::Positions | Thing::Normals) {
                break;
            } else {
                after = place;
            }
            place = before;
        }
        if chain.last == NONE {
            self.chains.remove(&key);
        }
    }

    /// Takes out all that waits for a thing.
    fn clear(&mut self, key: (Thing, Name)) {
        let mut place = self.chains.remove(&key).map_or(NONE, |chain| chain.last);
        while place != NONE {
            self.waiting[place].command = None;
            self.holes += 1;
            place = self.waiting[place].before;
        }
    }

    /// The mesh of an object whose definition waits.
    fn waiting_mesh(&mut self, name: Name) -> Option<&mut Mesh> {
        let mut place = self.chains.get(&(Thing::Object, name))?.last;
        while place != NONE && !matches!(self.waiting[place].command, Some(Command::DefineObject { .. })) {
            place = self.waiting[place].before;
        }
        match self.waiting.get_mut(place)?.command.as_mut()? {
            Command::DefineObject { mesh, .. } => Some(mesh),
            _ => None,
        }
    }

    /// Makes one update of all that wait for positions or normals. Without memory for it they stay as they are.
    fn merge(&mut self, key: (Thing, Name)) {
        let Some(chain) = self.chains.get_mut(&key) else { return };
        // Tried again when there is twice as much.
        chain.limit = 2 * chain.weight;
        if self.waiting[chain.last].before == NONE {
            return;
        }
        let mut places = Vec::new();
        let mut place = chain.last;
        while place != NONE {
            if places.try_reserve(1).is_err() {
                return;
            }
            places.push(place);
            place = self.waiting[place].before;
        }
        let updates = places.iter().rev().filter_map(|&place| self.waiting[place].command.as_ref());
        let Ok(merged) = merged(key, updates) else { return };
        let chain = self.chains.get_mut(&key).expect("found above");
        chain.weight = merged.update_weight();
        chain.limit = LEAST_LIMIT.max(2 * chain.weight);
        // The last of them takes it in: what waits behind is of other things.
        let [last, earlier @ ..] = &places[..] else { return };
        self.waiting[*last] = Waiting { command: Some(merged), before: NONE };
        for &place in earlier {
            self.waiting[place].command = None;
        }
        self.holes += earlier.len();
    }

    fn close_holes(&mut self) {
        // Chains are made anew: their order is that of the commands.
        self.chains.values_mut().for_each(|chain| chain.last = NONE);
        let mut kept = 0;
        for place in 0..self.waiting.len() {
            let Some(command) = self.waiting[place].command.take() else { continue };
            let chain = thing_of(&command).and_then(|key| self.chains.get_mut(&key)).expect("it was in a chain");
            let before = std::mem::replace(&mut chain.last, kept);
            self.waiting[kept] = Waiting { command: Some(command), before };
            kept += 1;
        }
        self.waiting.truncate(kept);
        self.holes = 0;
    }
}

/// What a command changes; None for one that changes nothing.
fn thing_of(command: &Command) -> Option<(Thing, Name)> {
    Some(match command {
        Command::UpdatePositions { positions, .. } | Command::MovePositions { positions, .. }
            if positions.is_empty() =>
        {
            return None;
        }
        Command::UpdateNormals { normals, .. } | Command::MoveNormals { normals, .. } if normals.is_empty() => {
            return None;
        }
        Command::DefineObject { name, .. }
        | Command::SetStrategy { name, .. }
        | Command::SetMotion { name, .. }
        | Command::SetSpatialSplits { name, .. }
        | Command::SetMask { name, .. }
        | Command::SetChildren { name, .. }
        | Command::SetLazyShape { name, .. }
        | Command::SetKeyFrame { name, .. }
        | Command::DeleteKeyFrames { name }
        | Command::SetTime { name, .. }
        | Command::DeleteObject { name } => (Thing::Object, *name),
        Command::UpdatePositions { name, .. } | Command::MovePositions { name, .. } => (Thing::Positions, *name),
        Command::UpdateNormals { name, .. } | Command::MoveNormals { name, .. } => (Thing::Normals, *name),
        Command::DefineClass { name, .. } => (Thing::Class, *name),
        Command::DefineShader { name, .. }
        | Command::SetParameter { shader: name, .. }
        | Command::DeleteShader { name } => (Thing::Shader, *name),
        Command::DefineTexture { name, .. } | Command::DeleteTexture { name } => (Thing::Texture, *name),
    })
}

impl Command {
    /// Whether `old`, which came before and changes the same thing, has no effect any more.
    fn voids(&self, old: &Command) -> bool {
        match (self, old) {
            (Command::DeleteObject { .. }, _)
            | (Command::DefineShader { .. } | Command::DeleteShader { .. }, _)
            | (Command::DefineTexture { .. } | Command::DeleteTexture { .. }, _) => true,
            // Other settings outlive definitions.
            (
                Command::DefineObject { .. },
                Command::DefineObject { .. }
                | Command::SetMotion { .. }
                | Command::SetKeyFrame { .. }
                | Command::DeleteKeyFrames { .. },
            ) => true,
            (Command::DeleteKeyFrames { .. }, Command::SetKeyFrame { .. }) => true,
            (Command::SetKeyFrame { time: new, .. }, Command::SetKeyFrame { time: old, .. }) => new == old,
            (Command::SetParameter { param: new, .. }, Command::SetParameter { param: old, .. }) => new == old,
            (
                Command::UpdatePositions { first, positions: values, .. },
                Command::UpdatePositions { first: start, positions: old, .. },
            )
            | (
                Command::UpdateNormals { first, normals: values, .. },
                Command::UpdateNormals { first: start, normals: old, .. },
            ) => first <= start && *start as usize + old.len() <= *first as usize + values.len(),
            (Command::MovePositions { vertices: new, .. }, Command::MovePositions { vertices: old, .. }) => new == old,
            (
                Command::SetStrategy { .. }
                | Command::SetMotion { .. }
                | Command::SetSpatialSplits { .. }
                | Command::SetMask { .. }
                | Command::SetLazyShape { .. }
                | Command::SetTime { .. }
                | Command::DeleteKeyFrames { .. },
                old,
            ) => std::mem::discriminant(self) == std::mem::discriminant(old),
            _ => false,
        }
    }

    fn update_weight(&self) -> usize {
        match self {
            Command::UpdatePositions { positions: values, .. }
            | Command::MovePositions { positions: values, .. }
            | Command::UpdateNormals { normals: values, .. }
            | Command::MoveNormals { normals: values, .. } => values.len() + UPDATE_WEIGHT,
            _ => 0,
        }
    }
}

/// One update that does what `updates` do, in their order.
fn merged<'a>(
    (thing, name): (Thing, Name),
    updates: impl Iterator<Item = &'a Command> + Clone,
) -> Result<Command, TryReserveError> {
    let values_of = |command: &'a Command| -> (Option<&'a [u32]>, u32, &'a [Vec3]) {
        match command {
            Command::UpdatePositions { first, positions: values, .. }
            | Command::UpdateNormals { first, normals: values, .. } => (None, *first, values),
            Command::MovePositions { vertices, positions: values, .. }
            | Command::MoveNormals { vertices, normals: values, .. } => (Some(vertices), 0, values),
            _ => (None, 0, &[]),
        }
    };
    let count = updates.clone().map(|update| values_of(update).2.len()).sum();
    // Vertex, number of the update counted down, so that the last comes first, and value.
    let mut latest: Vec<(u32, u32, Vec3)> = Vec::new();
    latest.try_reserve_exact(count)?;
    let mut turn = u32::MAX;
    for update in updates {
        let (vertices, first, values) = values_of(update);
        for (i, &value) in (0..).zip(values) {
            let vertex = vertices.map_or(first.saturating_add(i), |v| v[i as usize]);
            latest.push((vertex, turn, value));
            // Of a vertex that one list names twice the last counts, too.
            turn = turn.saturating_sub(vertices.is_some().into());
        }
        turn = turn.saturating_sub(1);
    }
    latest.sort_unstable_by_key(|&(vertex, turn, _)| (vertex, turn));
    latest.dedup_by_key(|&mut (vertex, ..)| vertex);
    let mut values = Vec::new();
    values.try_reserve_exact(latest.len())?;
    values.extend(latest.iter().map(|&(_, _, value)| value));
    let first = latest.first().map_or(0, |&(vertex, ..)| vertex);
    let is_run = latest.last().is_none_or(|&(vertex, ..)| (vertex - first) as usize + 1 == latest.len());
    if is_run {
        return Ok(match thing {
            Thing::Normals => Command::UpdateNormals { name, first, normals: values },
            _ => Command::UpdatePositions { name, first, positions: values },
        });
    }
    let mut vertices = Vec::new();
    vertices.try_reserve_exact(latest.len())?;
    vertices.extend(latest.iter().map(|&(vertex, ..)| vertex));
    Ok(match thing {
        Thing::Normals => Command::MoveNormals { name, vertices, normals: values },
        _ => Command::MovePositions { name, vertices, positions: values },
    })
}

/// Puts `values` over `target[first..]`, as far as it reaches; all of them by moving.
pub(super) fn overwrite<T: Copy>(target: &mut Vec<T>, first: u32, values: &mut Vec<T>) {
    if first == 0 && values.len() == target.len() {
        *target = std::mem::take(values);
    } else if let Some(tail) = target.get_mut(first as usize..) {
        let n = tail.len().min(values.len());
        tail[..n].copy_from_slice(&values[..n]);
    }
}

/// Puts each of `values` to its place in `target`, if there is one.
pub(super) fn scatter<T: Copy>(target: &mut [T], places: &[u32], values: &[T]) {
    for (&place, &value) in places.iter().zip(values) {
        if let Some(target) = target.get_mut(place as usize) {
            *target = value;
        }
    }
}

#[cfg(test)]
#[path = "changes_tests.rs"]
mod tests;
