//! A snapshot of what was last rendered or committed.

use super::queries::{Meshes, Queries};
use crate::accel::WorldView;
use crate::scene::{Mask, Mesh, Name, Scene};
use crate::trace::{Hit, Ray, Tracer};
use std::collections::{HashMap, TryReserveError};
use std::sync::Arc;

/// The scene as it was when the snapshot was taken, whatever happens to the context since: frames, commits, its end.
///
/// Any number of threads ask it at a time, without lock, context or allocation. Cheap to clone. Its memory is shared with the context and other
/// snapshots as far as nothing has changed; what changes is copied while a snapshot holds it, so those that are not needed any more should be dropped.
#[derive(Clone)]
pub struct SceneView {
    held: Arc<Held>,
    mask: Mask,
}

struct Held {
    world: Arc<WorldView>,
    /// Of the objects that the frame shows.
    meshes: HashMap<Name, Arc<Mesh>>,
}

impl SceneView {
    pub(super) fn new(world: &Arc<WorldView>, scene: &Scene) -> Result<Self, TryReserveError> {
        let mut meshes = HashMap::new();
        meshes.try_reserve(world.objects().len())?;
        for record in world.instances() {
            if let Some(object) = scene.objects.get(&record.object) {
                meshes.entry(record.object).or_insert_with(|| object.mesh.clone());
            }
        }
        Ok(Self { held: Arc::new(Held { world: world.clone(), meshes }), mask: Mask::QUERY })
    }

    /// The same scene for rays that see the instances which have a bit in common with `mask`.
    pub fn masked(&self, mask: Mask) -> Self {
        Self { mask, ..self.clone() }
    }

    /// Everything that can be asked.
    #[inline]
    pub fn queries(&self) -> Queries<'_> {
        Queries::new(Tracer::new(&self.held.world), Meshes::Held(&self.held.meshes)).masked(self.mask)
    }

    /// See [`Queries::intersect`].
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.queries().intersect(ray)
    }

    /// See [`Queries::is_occluded`].
    #[inline]
    pub fn is_occluded(&self, ray: &Ray) -> bool {
        self.queries().is_occluded(ray)
    }

    /// See [`Queries::intersect_into`].
    #[inline]
    pub fn intersect_into(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.queries().intersect_into(rays, hits);
    }

    /// See [`Queries::occluded_into`].
    #[inline]
    pub fn occluded_into(&self, rays: &[Ray], answers: &mut [bool]) {
        self.queries().occluded_into(rays, answers);
    }
}

impl std::fmt::Debug for SceneView {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SceneView of {} instances", self.held.world.instances().len())
    }
}
