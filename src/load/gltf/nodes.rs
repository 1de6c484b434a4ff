//! The tree of nodes of the scene that is shown.

use super::animation::Motion;
use super::file::document::Document;
use super::json;
use crate::load::LoadError;
use crate::load::model::{Local, Node, SceneFile, TrsChannels};
use glam::{DAffine3, DMat4, DQuat, DVec3};
use std::collections::{HashMap, HashSet};

/// The nodes that the scene reaches.
pub struct Nodes {
    /// Parents first: number in the file, and index in `SceneFile::nodes`.
    pub order: Vec<(u32, u32)>,
    /// By number in the file.
    pub index_of: HashMap<u32, u32>,
    /// By index in `SceneFile::nodes`: the node or one above it moves, in one of the animations.
    pub moving: Vec<bool>,
    /// By index in `SceneFile::nodes`: placement at rest.
    pub rest: Vec<DAffine3>,
}

/// Translation, rotation and scale of a node, and what moves them: nothing.
pub fn at_rest(node: &json::Node) -> TrsChannels {
    let (scale, rotation, translation) = match &node.matrix {
        Some(matrix) => matrix_of(matrix).to_scale_rotation_translation(),
        None => (
            node.scale.as_ref().map_or(DVec3::ONE, |v| DVec3::from_array(v.map(f64::from))),
            node.rotation.as_ref().map_or(DQuat::IDENTITY, |v| DQuat::from_array(v.map(f64::from))),
            node.translation.as_ref().map_or(DVec3::ZERO, |v| DVec3::from_array(v.map(f64::from))),
        ),
    };
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    TrsChannels {
        rest_translation: translation,
        rest_rotation: rotation,
        rest_scale: scale,
        translation: None,
        rotation: None,
        scale: None,
        weights: None,
    }
}

fn matrix_of(columns: &[f32; 16]) -> DAffine3 {
    DAffine3::from_mat4(DMat4::from_cols_array(&columns.map(f64::from)))
}

/// Numbers of the nodes without parents in the scene that is shown: the one that the file names, else its first, else all.
fn roots(document: &Document) -> Result<Vec<u32>, LoadError> {
    let root = &document.root;
    if let Some(number) = root.scene.filter(|_| !root.scenes.is_empty()) {
        return Ok(document.get(&root.scenes, "scenes", number, || "scene".into())?.nodes.clone());
    }
    if let Some(first) = root.scenes.first() {
        return Ok(first.nodes.clone());
    }
    if let Some(number) = root.scene {
        document.left_out("scene", format!("there is no scenes[{number}]; all nodes are shown"));
    }
    let children: HashSet<u32> = root.nodes.iter().flat_map(|n| n.children.iter().copied()).collect();
    Ok((0..root.nodes.len() as u32).filter(|n| !children.contains(n)).collect())
}

pub fn read(document: &Document, motion: &Motion, scene: &mut SceneFile) -> Result<Nodes, LoadError> {
    let mut nodes =
        Nodes { order: Vec::new(), index_of: HashMap::new(), moving: vec![false], rest: vec![DAffine3::IDENTITY] };
    let mut stack: Vec<(u32, u32)> = roots(document)?.into_iter().rev().map(|n| (n, 0)).collect();
    while let Some((number, parent)) = stack.pop() {
        let node = document.get(&document.root.nodes, "nodes", number, || "a list of nodes".into())?;
        // A file may name a node twice or in a circle; the first visit counts.
        if nodes.index_of.contains_key(&number) {
            continue;
        }
        let index = scene.nodes.len() as u32;
        nodes.index_of.insert(number, index);
        let local = match motion.targets.contains(&number) {
            true => Local::Channels(Box::new(at_rest(node))),
            false => Local::Fixed(match &node.matrix {
                Some(matrix) => matrix_of(matrix),
                None => at_rest(node).at(0.0),
            }),
        };
        let moves = motion.moved.contains(&number);
        let name = node.name.as_deref().map_or_else(|| format!("node {number}"), str::to_string);
        if moves {
            scene.named_transforms.push(name.clone());
        } else {
            scene.counts.static_transforms += 1;
        }
        let own = match &local {
            Local::Fixed(m) => *m,
            Local::Channels(c) => c.at(0.0),
            Local::Keyed { before, .. } => *before,
        };
        nodes.moving.push(nodes.moving[parent as usize] || moves);
        nodes.rest.push(nodes.rest[parent as usize] * own);
        scene.nodes.push(Node { name, parent: Some(parent), local });
        stack.extend(node.children.iter().rev().map(|&child| (child, index)));
        nodes.order.push((number, index));
    }
    Ok(nodes)
}
