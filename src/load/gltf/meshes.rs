//! Meshes as objects: where they stand, and which of them are one.
//!
//! A mesh that one resting node shows is baked into the object of everything that rests. One that several resting nodes show, or
//! that EXT_mesh_gpu_instancing repeats, is one object that stands often, so no number of places multiplies its triangles. Each
//! node that moves, or whose mesh has morph targets or a skin, has an object of its own.

use super::file::document::Document;
use super::json;
use super::material::Needs;
use super::nodes::Nodes;
use super::primitive::{Part, Source};
use super::skin;
use crate::load::LoadError;
use crate::load::build::{Baked, Builder, Corner};
use crate::load::model::{Deform, Object, SceneFile};
use glam::{Affine3, DAffine3, DQuat, DVec3, Vec2};
use std::collections::HashMap;
use std::sync::Arc;

/// A node that shows a mesh.
struct Shown {
    number: u32,
    index: u32,
    /// Under the node, where instancing repeats the mesh; else nothing but the node's own place.
    copies: Option<Vec<DAffine3>>,
}

pub fn read(
    document: &Document,
    nodes: &Nodes,
    needs: &[Needs],
    scene: &mut SceneFile,
    builder: &mut Builder,
) -> Result<(), LoadError> {
    let mut meshes: Vec<(u32, Vec<Shown>)> = Vec::new();
    let mut at: HashMap<u32, usize> = HashMap::new();
    for &(number, index) in &nodes.order {
        let node = &document.root.nodes[number as usize];
        let Some(mesh) = node.mesh else { continue };
        document.get(&document.root.meshes, "meshes", mesh, || format!("nodes[{number}]"))?;
        let instancing = node.extensions.as_ref().and_then(|e| e.instancing.as_ref());
        let copies = match instancing {
            Some(instancing) => Some(read_copies(document, &instancing.attributes, number)?),
            None => None,
        };
        let next = meshes.len();
        let slot = *at.entry(mesh).or_insert(next);
        if slot == next {
            meshes.push((mesh, Vec::new()));
        }
        meshes[slot].1.push(Shown { number, index, copies });
    }
    for (mesh, shown) in meshes {
        for p in 0..document.root.meshes[mesh as usize].primitives.len() {
            Reader { document, nodes, needs, mesh, primitive: p }.add(&shown, scene, builder)?;
        }
    }
    Ok(())
}

/// Placements of EXT_mesh_gpu_instancing.
fn read_copies(
    document: &Document,
    attributes: &json::InstanceAttributes,
    number: u32,
) -> Result<Vec<DAffine3>, LoadError> {
    let place = || format!("nodes[{number}]: EXT_mesh_gpu_instancing");
    let translations = attributes.translation.map(|a| document.accessor_of::<3>(a, place)).transpose()?;
    let rotations = attributes.rotation.map(|a| document.accessor_of::<4>(a, place)).transpose()?;
    let scales = attributes.scale.map(|a| document.accessor_of::<3>(a, place)).transpose()?;
    let counts: Vec<usize> = [&translations, &rotations, &scales].into_iter().flatten().map(|a| a.len()).collect();
    let count = counts.first().copied().unwrap_or(0);
    if counts.iter().any(|&c| c != count) {
        return Err(document.error(format!("{}: the attributes differ in length", place())));
    }
    document.spend(count as u64, place)?;
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let copy = |i: usize| {
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |a| {
            let q = DQuat::from_array(a.floats::<4>(i).map(f64::from));
            if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY }
        });
        let scale = scales.as_ref().map_or(DVec3::ONE, |a| vector(a.floats(i)));
        let translation = translations.as_ref().map_or(DVec3::ZERO, |a| vector(a.floats(i)));
        DAffine3::from_scale_rotation_translation(scale, rotation, translation)
    };
    Ok((0..count).map(copy).collect())
}

struct Reader<'r, 'd> {
    document: &'r Document<'d>,
    nodes: &'r Nodes,
    needs: &'r [Needs],
    mesh: u32,
    primitive: usize,
}

impl Reader<'_, '_> {
    /// Adds one primitive of the mesh wherever it is shown.
    fn add(&self, shown: &[Shown], scene: &mut SceneFile, builder: &mut Builder) -> Result<(), LoadError> {
        let document = self.document;
        let mesh = &document.root.meshes[self.mesh as usize];
        let primitive = &mesh.primitives[self.primitive];
        let place = format!("meshes[{}].primitives[{}]", self.mesh, self.primitive);
        let material = match primitive.material {
            Some(m) => {
                document.get(&document.root.materials, "materials", m, || place.clone())?;
                m + 1
            }
            None => 0,
        };
        let needs = self.needs.get(material as usize).copied().unwrap_or_default();
        let source = Source::new(document, primitive, place)?;
        let name = mesh.name.as_deref().map_or_else(|| format!("mesh {}", self.mesh), str::to_string);
        let deforms = |shown: &Shown| {
            let skinned = document.root.nodes[shown.number as usize].skin.is_some();
            !primitive.targets.is_empty() || skinned && primitive.attributes.joints_0.is_some()
        };
        let (bending, rigid): (Vec<&Shown>, Vec<&Shown>) = shown.iter().partition(|s| deforms(s));
        for shown in bending {
            let Some(part) = source.read(material, needs)? else { return Ok(()) };
            self.count(&part, 1, scene);
            if shown.copies.is_some() {
                document.left_out(source.place(), "instances of a mesh that deforms are left out");
            }
            let object = self.deforming(part, &source, shown, name.clone())?;
            scene.objects.push(object);
        }
        if rigid.is_empty() {
            return Ok(());
        }
        let Some(part) = source.read(material, needs)? else { return Ok(()) };
        let places: usize = rigid.iter().map(|s| s.copies.as_ref().map_or(1, Vec::len)).sum();
        self.count(&part, places as u64, scene);
        // Instances of nothing are nothing.
        let rigid: Vec<&Shown> =
            rigid.into_iter().filter(|s| s.copies.as_ref().is_none_or(|c| !c.is_empty())).collect();
        if let [Shown { index, copies: None, .. }] = rigid[..]
            && !self.nodes.moving[*index as usize]
            && part.mesh.colors.is_empty()
        {
            self.bake(&part, *index, material, builder);
            return Ok(());
        }
        // What rests stands under the root, everything else under its node.
        let mut resting: Vec<Affine3> = Vec::new();
        let mut objects: Vec<(u32, Vec<Affine3>)> = Vec::new();
        for shown in rigid {
            let index = shown.index as usize;
            let copies = shown.copies.as_deref();
            if self.nodes.moving[index] {
                objects.push((shown.index, copies.unwrap_or(&[]).iter().map(DAffine3::as_affine3).collect()));
            } else {
                let rest = self.nodes.rest[index];
                let under = |copy: &DAffine3| (rest * *copy).as_affine3();
                resting.extend(copies.unwrap_or(&[DAffine3::IDENTITY]).iter().map(under));
            }
        }
        if !resting.is_empty() {
            objects.push((0, resting));
        }
        // Every object has triangles of its own in a context.
        document.spend((objects.len() * part.mesh.triangles.len() * 3) as u64, || source.place())?;
        let mesh = Arc::new(part.mesh);
        for (node, copies) in objects {
            let (name, mesh) = (name.clone(), mesh.clone());
            scene.objects.push(Object { name, node, mesh, material: None, deform: Deform::Rigid, copies });
        }
        Ok(())
    }

    /// Counts the part as often as it is seen.
    fn count(&self, part: &Part, places: u64, scene: &mut SceneFile) {
        scene.counts.meshes += places;
        scene.counts.mesh_triangles += places * part.mesh.triangles.len() as u64;
    }

    fn bake(&self, part: &Part, index: u32, material: u32, builder: &mut Builder) {
        let mesh = &part.mesh;
        let corners: Vec<Corner> = (0..mesh.positions.len())
            .map(|i| Corner {
                position: mesh.positions[i],
                normal: mesh.normals.get(i).copied(),
                tex_coord: mesh.tex_coords.get(i).copied().unwrap_or(Vec2::ZERO),
            })
            .collect();
        let baked = Baked::new(self.nodes.rest[index as usize]);
        builder.add(0, &baked, &corners, &mesh.triangles, material);
    }

    fn deforming(&self, part: Part, source: &Source, shown: &Shown, name: String) -> Result<Object, LoadError> {
        let node = &self.document.root.nodes[shown.number as usize];
        let skin = match node.skin {
            Some(number) => skin::read(self.document, number, source, &part.sources, self.nodes)?,
            None => None,
        };
        let rest = node.weights.as_deref().or(self.document.root.meshes[self.mesh as usize].weights.as_deref());
        let weights = rest.map_or_else(|| vec![0.0; part.targets.len()], <[f32]>::to_vec);
        let deform = Deform::Blend { targets: part.targets, weights, skin };
        Ok(Object::new(name, shown.index, part.mesh, deform))
    }
}
