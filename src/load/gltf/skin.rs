//! Skins: joints that move vertices.

use super::file::document::Document;
use super::nodes::Nodes;
use super::primitive::Source;
use crate::load::LoadError;
use crate::load::model::Skin;
use glam::{Mat4, Vec4};

/// The skin `number` for the vertices `sources` of a primitive; `None` where the primitive has no weights.
pub fn read(
    document: &Document,
    number: u32,
    source: &Source,
    sources: &[u32],
    nodes: &Nodes,
) -> Result<Option<Skin>, LoadError> {
    let skin = document.get(&document.root.skins, "skins", number, || source.place())?;
    let place = || format!("skins[{number}]");
    let mut sets = Vec::new();
    for set in 0..2 {
        let joints = source.integers::<4>(|a| if set == 0 { a.joints_0 } else { a.joints_1 })?;
        let weights = source.numbers::<4>(|a| if set == 0 { a.weights_0 } else { a.weights_1 })?;
        sets.extend(joints.zip(weights));
    }
    if sets.is_empty() {
        return Ok(None);
    }
    let fits = |len: usize| sources.iter().all(|&v| (v as usize) < len);
    if !sets.iter().all(|(joints, weights)| fits(joints.len()) && fits(weights.len())) {
        return Err(source.fault("there are fewer joints or weights than vertices"));
    }
    // Joints outside the scene stay at the origin.
    let joints: Vec<u32> = skin.joints.iter().map(|j| nodes.index_of.get(j).copied().unwrap_or(0)).collect();
    let inverse_bind = match skin.inverse_bind_matrices {
        Some(index) => {
            let matrices = document.accessor_of::<16>(index, place)?;
            if matrices.len() < joints.len() {
                let text = format!("{}: {} matrices for {} joints", place(), matrices.len(), joints.len());
                return Err(document.error(text));
            }
            (0..joints.len()).map(|j| Mat4::from_cols_array(&matrices.floats::<16>(j))).collect()
        }
        None => vec![Mat4::IDENTITY; joints.len()],
    };
    let (mut indices, mut weights) = (Vec::with_capacity(sources.len()), Vec::with_capacity(sources.len()));
    for &vertex in sources {
        let (of, by) = strongest(sets.iter().flat_map(|(joints, weights)| {
            let [j, w] = [
                joints.integers::<4>(vertex as usize).map(f64::from),
                weights.floats::<4>(vertex as usize).map(f64::from),
            ];
            (0..4).map(move |k| (j[k] as u32, w[k] as f32))
        }));
        if of.iter().zip(by).any(|(&joint, weight)| joint as usize >= joints.len() && weight != 0.0) {
            return Err(source.fault(&format!("a vertex has a joint beyond the {} of {}", joints.len(), place())));
        }
        indices.push(of.map(|joint| joint.min(0xffff) as u16));
        weights.push(Vec4::from_array(by));
    }
    Ok(Some(Skin { joints, inverse_bind, indices, weights }))
}

/// The four joints with the largest weights; the others of a vertex are left out, as their share is small.
fn strongest(influences: impl Iterator<Item = (u32, f32)>) -> ([u32; 4], [f32; 4]) {
    let (mut of, mut by) = ([0; 4], [0.0; 4]);
    for (joint, weight) in influences {
        let least = (0..4).min_by(|&a, &b| f32::total_cmp(&by[a], &by[b])).expect("four slots");
        if weight > by[least] {
            (of[least], by[least]) = (joint, weight);
        }
    }
    (of, by)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_strongest_joints_count() {
        let weights = [0.1, 0.4, 0.0, 0.2, 0.05, 0.25, 0.0, 0.0];
        let (mut of, _) = super::strongest((0..).zip(weights));
        of.sort();
        assert_eq!(of, [0, 1, 3, 5]);
    }
}
