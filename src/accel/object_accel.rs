//! The acceleration structure of one object, and its way from frame to frame.
//!
//! A closed enum instead of trait objects: two kinds of structure exist, and traversal matches once per object and ray. Which one, and how it
//! follows changes, is decided in [`super::strategy`]; what has changed is told by the version counters of the
//! [`Object`]. Instances share the structure (Wald03 §4.1).

use super::bsp::Bsp;
use super::bsp_build::Quality;
use super::bvh::{Bvh, OutOfMemory};
use super::strategy::{Method, Moved, WORN};
use super::{Aabb, Refit, build_fast, build_sah};
use crate::scene::{Name, Object, Strategy};

/// What rays of one object traverse.
#[derive(Debug, Default)]
pub enum Structure {
    /// Nothing is built: the object has not been instanced yet, or memory ran out.
    #[default]
    None,
    Bvh(Bvh),
    Bsp(Bsp),
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
}

/// What an update did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    Unchanged,
    /// Built anew, with so many nodes (0 for a BSP, whose tree comes with the first ray).
    Built(usize),
    Refitted(usize),
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

    #[inline(always)]
    pub fn structure(&self) -> &Structure {
        &self.structure
    }

    /// The box around everything that can be hit, in object space.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        match &self.structure {
            Structure::None => Aabb::EMPTY,
            Structure::Bvh(bvh) => bvh.bounds(),
            Structure::Bsp(bsp) => bsp.bounds(),
        }
    }

    /// Triangles of the object, those that no ray can hit included.
    #[inline]
    pub fn triangles(&self) -> u64 {
        self.triangles
    }

    /// Bytes held; 0 while nothing is built.
    pub fn memory_bytes(&self) -> usize {
        match &self.structure {
            Structure::None => 0,
            Structure::Bvh(bvh) => bvh.memory_bytes(),
            Structure::Bsp(bsp) => bsp.memory_bytes(),
        }
    }

    /// Brings the structure in line with `object`. To be called inside the pool.
    pub(super) fn update(&mut self, object: &Object, forced: Option<Strategy>) -> Outcome {
        self.triangles = object.mesh.triangles.len() as u64;
        let same_topology = self.made_with.is_some() && self.topology_version == object.topology_version;
        let same_vertices = same_topology && self.vertex_version == object.vertex_version;
        let redefined = self.definitions > 1 || (self.definitions == 1 && !same_topology);
        let method = Method::choose(object, forced, redefined);
        let same_method = self.made_with == Some(method);
        if same_vertices && same_method {
            return Outcome::Unchanged;
        }
        let refitted = if same_topology && same_method { self.refit(object, method) } else { None };
        let outcome = match refitted {
            Some(outcome) => Ok(outcome),
            None => self.build(object, method),
        };
        self.topology_version = object.topology_version;
        self.vertex_version = object.vertex_version;
        match outcome {
            Ok(outcome) => {
                self.made_with = Some(method);
                outcome
            }
            Err(error) => {
                self.structure = Structure::None;
                self.made_with = None;
                Outcome::Failed(error)
            }
        }
    }

    /// Answers a vertex update by a refit; `None` where the method or the result asks for a build.
    fn refit(&mut self, object: &Object, method: Method) -> Option<Outcome> {
        let (Structure::Bvh(bvh), Method::Bvh { moved, .. }) = (&mut self.structure, method) else { return None };
        if moved == Moved::Rebuild || bvh.refit(&object.mesh) == Refit::NeedsRebuild {
            return None;
        }
        if moved == Moved::RefitUntilWorn && bvh.sah_cost() > WORN * self.cost_when_built {
            *bvh = build_fast(&object.mesh).ok()?;
            self.cost_when_built = bvh.sah_cost();
            return Some(Outcome::Built(bvh.nodes().len()));
        }
        Some(Outcome::Refitted(bvh.nodes().len()))
    }

    fn build(&mut self, object: &Object, method: Method) -> Result<Outcome, OutOfMemory> {
        // The old structure goes first: both together may not fit.
        let old = std::mem::take(&mut self.structure);
        if self.topology_version != object.topology_version || self.made_with.is_none() {
            self.definitions += 1;
        }
        let nodes = match method {
            Method::Bsp { fast } => {
                let recycled = if let Structure::Bsp(bsp) = old { Some(bsp) } else { None };
                let quality = if fast { Quality::Fast } else { Quality::Sah };
                let bsp = Bsp::new(&object.mesh, quality, recycled)?;
                self.structure = Structure::Bsp(bsp);
                0
            }
            Method::Bvh { fast, moved } => {
                drop(old);
                let bvh = if fast { build_fast(&object.mesh)? } else { build_sah(&object.mesh)? };
                let nodes = bvh.nodes().len();
                if moved == Moved::RefitUntilWorn {
                    self.cost_when_built = bvh.sah_cost();
                }
                self.structure = Structure::Bvh(bvh);
                nodes
            }
        };
        Ok(Outcome::Built(nodes))
    }
}
