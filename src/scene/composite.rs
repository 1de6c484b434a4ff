//! Composites: objects that hold instances of other objects, and their resolution at the start of a frame.
//!
//! Children are named, so they are bound late: a child that is defined anew shows in all its composites from the next frame on, and one that does not exist
//! shows nothing. The application's calls form no cycles; see `api/objects`.
//!
//! The resolved list holds an instance for each object with triangles, depth first and in the order of definition, an object before its children. Its order
//! decides between hits at the same distance. What an application is told is the number of the instance that it placed itself.

use super::{Instance, Scene};
use std::collections::TryReserveError;

/// The instances of a frame with their composites resolved. Memory is kept from frame to frame.
#[derive(Debug, Default)]
pub struct Resolved {
    instances: Vec<Instance>,
    numbers: Vec<u32>,
    open: Vec<Open>,
    /// Some composite was met; otherwise the frame's own list is the resolved one.
    some: bool,
}

/// The instances of a frame, each of an object with triangles of its own or of none.
#[derive(Clone, Copy, Debug)]
pub struct InstanceList<'a> {
    pub instances: &'a [Instance],
    /// For each the number of the frame's own instance that it belongs to. Empty where these are the same.
    pub numbers: &'a [u32],
}

impl<'a> InstanceList<'a> {
    /// The instances themselves: none of them is a composite.
    pub fn plain(instances: &'a [Instance]) -> Self {
        Self { instances, numbers: &[] }
    }

    /// By which number the application knows the instance that has this one here.
    #[inline]
    pub fn number_of(&self, instance: u32) -> u32 {
        self.numbers.get(instance as usize).copied().unwrap_or(instance)
    }
}

/// A composite whose children are being resolved: its place in the world, and the next child.
#[derive(Debug)]
struct Open {
    composite: Instance,
    next: usize,
}

/// More instances than there are numbers, or than there is memory for.
#[derive(Debug)]
pub struct TooMany;

impl From<TryReserveError> for TooMany {
    fn from(_: TryReserveError) -> Self {
        TooMany
    }
}

impl Resolved {
    /// Resolves the composites among the instances of a frame.
    ///
    /// # Errors
    /// No memory, or more than 2³² - 2 instances. Nothing is resolved then.
    pub fn resolve(&mut self, scene: &Scene, instances: &[Instance]) -> Result<(), TooMany> {
        self.instances.clear();
        self.numbers.clear();
        self.open.clear();
        self.some = scene.composites > 0 && instances.iter().any(|instance| scene.is_composite(instance.object));
        if !self.some {
            return Ok(());
        }
        self.instances.try_reserve(instances.len())?;
        self.numbers.try_reserve(instances.len())?;
        let done = (0..).zip(instances).try_for_each(|(number, instance)| self.place(scene, *instance, number));
        if done.is_err() {
            *self = Self::default();
        }
        done
    }

    /// Adds an instance, and those that it is made of.
    fn place(&mut self, scene: &Scene, instance: Instance, number: u32) -> Result<(), TooMany> {
        // Each step counts, so that composites of nothing but composites come to an end too.
        let mut steps = self.instances.len();
        self.enter(scene, instance, number)?;
        while let Some(Open { composite, next }) = self.open.last_mut() {
            let children = scene.objects.get(&composite.object).map_or(&[][..], |object| &object.children);
            let Some(child) = children.get(*next) else {
                self.open.pop();
                continue;
            };
            *next += 1;
            steps += 1;
            let world_from_object = composite.world_from_object * child.world_from_object;
            let child = Instance { world_from_object, mask: composite.mask.and(child.mask), ..*child };
            if steps >= u32::MAX as usize - 1 || self.open.len() > scene.composites {
                return Err(TooMany);
            }
            self.enter(scene, child, number)?;
        }
        Ok(())
    }

    /// Adds an instance's own triangles, and opens it if it has children.
    fn enter(&mut self, scene: &Scene, instance: Instance, number: u32) -> Result<(), TooMany> {
        let Some(object) = scene.objects.get(&instance.object) else { return Ok(()) };
        if !object.mesh.triangles.is_empty() {
            self.instances.try_reserve(1)?;
            self.numbers.try_reserve(1)?;
            self.instances.push(instance);
            self.numbers.push(number);
        }
        if !object.children.is_empty() {
            self.open.try_reserve(1)?;
            self.open.push(Open { composite: instance, next: 0 });
        }
        Ok(())
    }

    /// The resolved list of the frame whose own list is `own`.
    pub fn list<'a>(&'a self, own: &'a [Instance]) -> InstanceList<'a> {
        InstanceList { instances: if self.some { &self.instances } else { own }, numbers: &self.numbers }
    }

    pub fn memory_bytes(&self) -> usize {
        self.instances.capacity() * size_of::<Instance>()
            + self.numbers.capacity() * size_of::<u32>()
            + self.open.capacity() * size_of::<Open>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Command, Mesh, Motion, Name};
    use glam::{Affine3A, Vec3};

    fn at(object: Name, x: f32) -> Instance {
        Instance::new(object, Affine3A::from_translation(Vec3::X * x))
    }

    fn define(scene: &mut Scene, name: Name, triangles: usize, children: Vec<Instance>) {
        let mesh = Mesh { positions: vec![Vec3::ZERO; 3], triangles: vec![[0, 1, 2]; triangles], ..Mesh::default() };
        scene.apply(Command::DefineObject { name, mesh, motion: Motion::Affine });
        if !children.is_empty() {
            scene.apply(Command::SetChildren { name, children });
        }
    }

    fn resolved(scene: &Scene, instances: &[Instance]) -> Vec<(Name, u32, f32)> {
        let mut resolved = Resolved::default();
        resolved.resolve(scene, instances).expect("there is memory");
        let list = resolved.list(instances);
        let shown = |(i, one): (u32, &Instance)| (one.object, list.number_of(i), one.world_from_object.translation.x);
        (0..).zip(list.instances).map(shown).collect()
    }

    #[test]
    fn composites_are_resolved_depth_first_and_late() {
        let mut scene = Scene::default();
        let frame = [at(3, 100.0), at(1, 200.0), at(2, 300.0)];
        define(&mut scene, 1, 1, vec![]);
        assert_eq!(resolved(&scene, &frame), [(3, 0, 100.0), (1, 1, 200.0), (2, 2, 300.0)]);
        define(&mut scene, 2, 0, vec![at(1, 1.0), at(9, 0.0), at(1, 2.0)]);
        define(&mut scene, 3, 1, vec![at(2, 10.0), at(1, 20.0)]);
        let expected =
            [(3, 0, 100.0), (1, 0, 111.0), (1, 0, 112.0), (1, 0, 120.0), (1, 1, 200.0), (1, 2, 301.0), (1, 2, 302.0)];
        assert_eq!(resolved(&scene, &frame), expected);
        // A child of another kind, a child that is gone, and a composite that is none any more.
        define(&mut scene, 2, 1, vec![]);
        scene.apply(Command::DeleteObject { name: 1 });
        assert_eq!(resolved(&scene, &frame), [(3, 0, 100.0), (2, 0, 110.0), (2, 2, 300.0)]);
        define(&mut scene, 3, 1, vec![]);
        assert_eq!(scene.composites, 0);
        assert_eq!(resolved(&scene, &frame).len(), 3);
    }

    #[test]
    fn a_cycle_ends_in_an_error() {
        let mut scene = Scene::default();
        define(&mut scene, 1, 1, vec![at(2, 0.0)]);
        define(&mut scene, 2, 1, vec![at(1, 0.0)]);
        let mut resolved = Resolved::default();
        assert!(resolved.resolve(&scene, &[at(2, 0.0)]).is_err());
        assert_eq!(resolved.list(&[]).instances.len(), 0);
    }
}
