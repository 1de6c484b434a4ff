//! Which shaders the triangles of an object have: what decides whether shadow rays of a frame may meet something that
//! lets them pass. One such shader that no object of the frame uses must not put all shadow rays on the slow path. And where all triangles have
//! one shader, nobody has to look up which.

use crate::memory::{OutOfMemory, Room, push};
use crate::scene::{Instance, Name, Object, Scene};
use std::collections::HashMap;

/// Shaders by object, found by one look at each triangle and kept until the object is defined anew.
#[derive(Default)]
pub struct SurfaceUse {
    shaders: HashMap<Name, Used>,
}

struct Used {
    topology_version: u64,
    /// Each once, but 0, which is the default.
    names: Vec<Name>,
    /// That of all triangles, if it is one.
    only: Option<Name>,
}

impl Used {
    fn of(object: &Object) -> Result<Self, OutOfMemory> {
        let mut names: Vec<Name> = Vec::new();
        // Triangles with the same shader mostly follow one another.
        let mut last = 0;
        for &name in &object.mesh.shader_of_triangle {
            if name != last && !names.contains(&name) {
                push(&mut names, name)?;
            }
            last = name;
        }
        let of_triangle = &object.mesh.shader_of_triangle;
        let listed = of_triangle.len() >= object.mesh.triangles.len();
        let only = match names[..] {
            [] => Some(0),
            [name] => (listed && !of_triangle.contains(&0)).then_some(name),
            _ => None,
        };
        Ok(Self { topology_version: object.topology_version, names, only })
    }
}

impl SurfaceUse {
    /// Looks at the objects of `instances` that are new, or defined anew.
    ///
    /// # Errors
    /// No memory; the next update tries again.
    pub fn update(&mut self, scene: &Scene, instances: &[Instance]) -> Result<(), OutOfMemory> {
        if self.shaders.len() > scene.objects.len() {
            self.shaders.retain(|name, _| scene.objects.contains_key(name));
        }
        // Neighbours in the list are often instances of one object.
        let mut last = 0;
        for instance in instances {
            if instance.object == std::mem::replace(&mut last, instance.object) {
                continue;
            }
            let Some(object) = scene.objects.get(&instance.object) else { continue };
            let known = self.shaders.get(&instance.object);
            if known.is_none_or(|used| used.topology_version != object.topology_version) {
                self.shaders.room(1)?;
                self.shaders.insert(instance.object, Used::of(object)?);
            }
        }
        Ok(())
    }

    /// Whether one of `instances`, which it was updated for, has a triangle with a shader for which `wanted` holds; shader 0, the
    /// default, is not asked for.
    pub fn any(&self, instances: &[Instance], wanted: impl Fn(Name) -> bool) -> bool {
        let mut last = 0;
        instances.iter().any(|instance| {
            instance.object != std::mem::replace(&mut last, instance.object)
                && self.shaders.get(&instance.object).is_some_and(|used| used.names.iter().any(|&name| wanted(name)))
        })
    }

    /// The shader that all triangles of an object have, if it is one; None as well for an object that is not there.
    pub fn only(&self, object: Name) -> Option<Name> {
        self.shaders.get(&object).and_then(|used| used.only)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Command, Instance, Mesh, Motion};
    use glam::Affine3A;

    #[test]
    fn only_what_the_frame_shows_counts_and_a_new_definition_is_seen() {
        let mesh = |shaders: &[Name]| Mesh { shader_of_triangle: shaders.to_vec(), ..Mesh::default() };
        let mut scene = Scene::default();
        let define = |scene: &mut Scene, name, shaders: &[Name]| {
            scene.apply(Command::DefineObject { name, mesh: mesh(shaders), motion: Motion::Affine });
        };
        define(&mut scene, 1, &[5, 5, 6, 5, 0]);
        define(&mut scene, 2, &[7]);
        let frame = |objects: &[Name]| -> Vec<Instance> {
            objects.iter().map(|&object| Instance::new(object, Affine3A::IDENTITY)).collect()
        };
        let mut used = SurfaceUse::default();
        let mut any = |scene: &Scene, objects: &[Name], wanted: Name| {
            let frame = frame(objects);
            used.update(scene, &frame).expect("memory");
            used.any(&frame, |n| n == wanted)
        };
        assert!(any(&scene, &[1], 5) && any(&scene, &[1], 6));
        assert!(!any(&scene, &[1], 7) && any(&scene, &[1, 1, 9, 2], 7));
        define(&mut scene, 2, &[8]);
        assert!(!any(&scene, &[1, 2], 7) && any(&scene, &[1, 2], 8));
    }

    #[test]
    fn one_shader_of_all_triangles_is_known() {
        let mut scene = Scene::default();
        let mut used = SurfaceUse::default();
        let mut only = |shaders: &[Name], triangles| {
            let mesh =
                Mesh { shader_of_triangle: shaders.to_vec(), triangles: vec![[0, 1, 2]; triangles], ..Mesh::default() };
            scene.apply(Command::DefineObject { name: 1, mesh, motion: Motion::Affine });
            used.update(&scene, &[Instance::new(1, Affine3A::IDENTITY)]).expect("memory");
            used.only(1)
        };
        assert_eq!(only(&[], 3), Some(0));
        assert_eq!(only(&[0, 0], 2), Some(0));
        assert_eq!(only(&[4, 4, 4], 3), Some(4));
        assert_eq!(only(&[4, 4, 5], 3), None);
        assert_eq!(only(&[4, 0, 4], 3), None, "0 is the default shader");
        assert_eq!(only(&[4, 4], 3), None, "triangles beyond the list have the default shader");
        assert_eq!(used.only(2), None);
    }
}
