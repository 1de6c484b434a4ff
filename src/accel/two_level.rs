//! The two-level structure: instances over object structures (Wald03 §4.1).

use super::{Aabb, triangle_bounds};
use crate::scene::{Instance, Mesh, Name, Scene};
use glam::{Affine3A, Vec3};

pub struct ObjectAccel {
    pub name: Name,
    pub bounds: Aabb,
    pub corners: Vec<[Vec3; 3]>,
}

pub struct InstanceRecord {
    pub instance: u32,
    pub slot: u32,
    pub object: Name,
    pub world_from_object: Affine3A,
    pub object_from_world: Affine3A,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct UpdateStats {
    pub objects_built: u32,
    pub nodes_updated: u64,
    pub bytes: u64,
}

#[derive(Default)]
pub struct TwoLevel {
    pub objects: Vec<ObjectAccel>,
    pub instances: Vec<InstanceRecord>,
}

impl TwoLevel {
    pub fn update(&mut self, scene: &Scene, instances: &[Instance]) -> UpdateStats {
        self.objects.clear();
        self.instances.clear();
        for (i, inst) in instances.iter().enumerate() {
            let Some(object) = scene.objects.get(&inst.object) else { continue };
            let m: &Mesh = &object.mesh;
            let corners: Vec<_> = (0..m.triangles.len() as u32).map(|p| m.corners(p)).collect();
            let bounds = corners.iter().fold(Aabb::EMPTY, |b, c| b.union(triangle_bounds(*c)));
            self.instances.push(InstanceRecord {
                instance: i as u32,
                slot: self.objects.len() as u32,
                object: inst.object,
                world_from_object: inst.world_from_object,
                object_from_world: inst.world_from_object.inverse(),
            });
            self.objects.push(ObjectAccel { name: inst.object, bounds, corners });
        }
        UpdateStats::default()
    }
}
