//! Which shaders the triangles of an object have: what decides whether shadow rays of a frame may meet something that
//! lets them pass. One such shader that no object of the frame uses must not put all shadow rays on the slow path.

use crate::scene::{FrameDesc, Name, Object, Scene};
use std::collections::HashMap;

/// Shaders by object, found by one look at each triangle and kept until the object is defined anew.
#[derive(Default)]
pub struct SurfaceUse {
    shaders: HashMap<Name, Used>,
}

struct Used {
    topology_version: u64,
    /// Each once.
    names: Vec<Name>,
}

impl Used {
    fn of(object: &Object) -> Self {
        let mut names: Vec<Name> = Vec::new();
        // Triangles with the same shader mostly follow one another.
        let mut last = 0;
        for &name in &object.mesh.shader_of_triangle {
            if name != last && !names.contains(&name) {
                names.push(name);
            }
            last = name;
        }
        Self { topology_version: object.topology_version, names }
    }
}

impl SurfaceUse {
    /// Whether an instance of the frame has a triangle with a shader for which `wanted` holds; shader 0, the default, is
    /// not asked for.
    pub fn any(&mut self, scene: &Scene, frame: &FrameDesc, wanted: impl Fn(Name) -> bool) -> bool {
        self.shaders.retain(|name, _| scene.objects.contains_key(name));
        // Neighbours in the list are often instances of one object.
        let mut last = 0;
        frame.instances.iter().any(|instance| {
            if instance.object == last {
                return false;
            }
            last = instance.object;
            let Some(object) = scene.objects.get(&instance.object) else { return false };
            let used = self.shaders.entry(instance.object).or_insert_with(|| Used::of(object));
            if used.topology_version != object.topology_version {
                *used = Used::of(object);
            }
            used.names.iter().any(|&name| wanted(name))
        })
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
        let frame = |objects: &[Name]| FrameDesc {
            instances: objects
                .iter()
                .map(|&object| Instance { object, world_from_object: Affine3A::IDENTITY })
                .collect(),
            ..FrameDesc::default()
        };
        let mut used = SurfaceUse::default();
        let mut any = |scene: &Scene, objects: &[Name], wanted: Name| used.any(scene, &frame(objects), |n| n == wanted);
        assert!(any(&scene, &[1], 5) && any(&scene, &[1], 6));
        assert!(!any(&scene, &[1], 7) && any(&scene, &[1, 1, 9, 2], 7));
        define(&mut scene, 2, &[8]);
        assert!(!any(&scene, &[1, 2], 7) && any(&scene, &[1, 2], 8));
    }
}
