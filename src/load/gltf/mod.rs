//! glTF 2.0 (`.gltf` and `.glb`), through the `gltf` crate: node tree, meshes with morph targets and skins,
//! materials, cameras, punctual lights, and the first animation of the file.
//!
//! Geometry below nodes that never move is baked into one static object; a mesh under a moving node, a morphed or a
//! skinned mesh becomes an object of its own. Metallic-roughness is mapped onto Whitted's terms: a dielectric keeps its base
//! colour as diffuse and reflects 4 %, a metal reflects in its base colour and has no diffuse part; smooth
//! surfaces mirror, rough ones only show a highlight of exponent 2/α² − 2, α = roughness².

mod buffers;
mod motion;

use crate::load::LoadError;
use crate::load::build::{Baked, Builder, Corner};
use crate::load::input::files::{self, Tree, line_of};
use crate::load::model::{
    Camera, Deform, Light, LightKind, Local, Material, Mesh, MorphTarget, Node, Object, Projection, SceneFile, Skin,
    TextureData, TextureSource, View,
};
use buffers::Buffers;
use glam::{DAffine3, DMat4, DVec3, Mat4, Vec2, Vec3, Vec4};
use std::collections::HashMap;
use std::path::Path;

pub fn load(path: &Path) -> Result<SceneFile, LoadError> {
    let bytes = files::read(path, files::MAX_FILE_BYTES)?;
    let tree = Tree::of(path)?;
    let mut gltf = parse(path, &bytes)?;
    let buffers = Buffers::load(path, &tree, &mut gltf)?;
    let mut scene = SceneFile::new("glTF", path.to_path_buf());
    scene.counts.files = 1;
    scene.srgb = true;
    for name in gltf.extensions_required() {
        let known = [
            "KHR_lights_punctual",
            "KHR_materials_emissive_strength",
            "KHR_materials_ior",
            "KHR_materials_transmission",
        ];
        if !known.contains(&name) {
            return Err(buffers.error(format!("the file requires extension `{name}`, which is not supported")));
        }
    }
    let motion = motion::read(&gltf, &buffers, &mut scene)?;
    let nodes = tree_of_nodes(&gltf, &motion, &mut scene);
    materials(&gltf, &buffers, &mut scene)?;
    let mut builder = Builder::default();
    for (node, index) in &nodes.order {
        if let Some(mesh) = node.mesh() {
            add_mesh(&mut scene, &mut builder, &buffers, node, *index, &mesh, &nodes)?;
        }
        add_camera(&mut scene, node, *index);
        add_light(&mut scene, node, *index);
    }
    let file = path.file_stem().map_or("mesh".into(), |s| s.to_string_lossy().into_owned());
    scene.objects.extend(builder.finish(|_| file.clone()));
    Ok(scene)
}

/// Parses and validates. The crate's validation looks up the position accessor of every primitive before it has checked that
/// there is one, and panics; so that is checked first.
fn parse(path: &Path, bytes: &[u8]) -> Result<gltf::Gltf, LoadError> {
    let unchecked = gltf::Gltf::from_slice_without_validation(bytes).map_err(|e| json_error(path, bytes, &e))?;
    let json = unchecked.document.as_json();
    for accessor in json.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values()) {
        if accessor.value() >= json.accessors.len() {
            let text = format!("a mesh names accessor {}, which does not exist", accessor.value());
            return Err(LoadError::new(path, None, text));
        }
    }
    gltf::Gltf::from_slice(bytes).map_err(|e| json_error(path, bytes, &e))
}

fn json_error(path: &Path, bytes: &[u8], error: &gltf::Error) -> LoadError {
    let text = error.to_string();
    // serde_json ends its messages with "at line L column C"; in a .glb the line is that of the JSON chunk.
    let is_binary = bytes.starts_with(b"glTF");
    let line = text.rsplit_once(" at line ").and_then(|(_, t)| t.split(' ').next()?.parse().ok());
    let text = text.split(" at line ").next().unwrap_or(&text).to_string();
    let line = line.filter(|_| !is_binary).map(|l: u32| l.min(line_of(bytes, bytes.len())));
    LoadError::new(path, line, text)
}

/// The nodes that the default scene reaches.
struct Nodes<'a> {
    /// Parents first, with the index in `SceneFile::nodes`.
    order: Vec<(gltf::Node<'a>, u32)>,
    /// By glTF node index.
    index_of: HashMap<usize, u32>,
    /// By index in `SceneFile::nodes`: the node or one above it moves.
    moving: Vec<bool>,
    /// By index in `SceneFile::nodes`: placement at rest.
    rest: Vec<DAffine3>,
}

fn tree_of_nodes<'a>(gltf: &'a gltf::Gltf, motion: &motion::Motion, scene: &mut SceneFile) -> Nodes<'a> {
    let mut nodes =
        Nodes { order: Vec::new(), index_of: HashMap::new(), moving: vec![false], rest: vec![DAffine3::IDENTITY] };
    let root = gltf.default_scene().or_else(|| gltf.scenes().next());
    // Without a scene every node without a parent counts.
    let mut roots: Vec<gltf::Node> = match root {
        Some(root) => root.nodes().collect(),
        None => {
            let children: std::collections::HashSet<usize> =
                gltf.nodes().flat_map(|n| n.children().map(|c| c.index()).collect::<Vec<_>>()).collect();
            gltf.nodes().filter(|n| !children.contains(&n.index())).collect()
        }
    };
    roots.reverse();
    let mut stack: Vec<(gltf::Node, u32)> = roots.into_iter().map(|n| (n, 0)).collect();
    while let Some((node, parent)) = stack.pop() {
        // A file may name a node twice or in a circle; the first visit counts.
        if nodes.index_of.contains_key(&node.index()) {
            continue;
        }
        let index = scene.nodes.len() as u32;
        nodes.index_of.insert(node.index(), index);
        let local = match motion.channels.get(&node.index()) {
            Some(channels) => Local::Channels(Box::new(channels.clone())),
            None => {
                let columns = node.transform().matrix();
                Local::Fixed(DAffine3::from_mat4(DMat4::from_cols_array_2d(&columns.map(|c| c.map(f64::from)))))
            }
        };
        let name = node.name().map_or_else(|| format!("node {}", node.index()), str::to_string);
        let scene_node = Node { name, parent: Some(parent), local };
        if scene_node.moves() {
            scene.named_transforms.push(scene_node.name.clone());
        } else {
            scene.counts.static_transforms += 1;
        }
        let own = match &scene_node.local {
            Local::Fixed(m) => *m,
            Local::Channels(c) => c.at(0.0),
            Local::Keyed { before, .. } => *before,
        };
        nodes.moving.push(nodes.moving[parent as usize] || scene_node.moves());
        nodes.rest.push(nodes.rest[parent as usize] * own);
        scene.nodes.push(scene_node);
        let mut children: Vec<_> = node.children().map(|c| (c, index)).collect();
        children.reverse();
        stack.extend(children);
        nodes.order.push((node, index));
    }
    nodes
}

fn add_mesh(
    scene: &mut SceneFile,
    builder: &mut Builder,
    buffers: &Buffers,
    node: &gltf::Node,
    index: u32,
    mesh: &gltf::Mesh,
    nodes: &Nodes,
) -> Result<(), LoadError> {
    for primitive in mesh.primitives() {
        let Some(part) = read_primitive(scene, buffers, mesh, &primitive)? else { continue };
        scene.counts.meshes += 1;
        scene.counts.mesh_triangles += part.mesh.triangles.len() as u64;
        let skin = match node.skin() {
            Some(skin) => read_skin(buffers, &skin, &primitive, part.mesh.positions.len(), nodes)?,
            None => None,
        };
        let rigid = part.targets.is_empty() && skin.is_none();
        if rigid && !nodes.moving[index as usize] && part.mesh.colors.is_empty() {
            let m = &part.mesh;
            let corners: Vec<Corner> = (0..m.positions.len())
                .map(|i| Corner {
                    position: m.positions[i],
                    normal: m.normals.get(i).copied(),
                    tex_coord: m.tex_coords.get(i).copied().unwrap_or(Vec2::ZERO),
                })
                .collect();
            let baked = Baked::new(nodes.rest[index as usize]);
            let material = m.materials.first().copied().unwrap_or(0);
            builder.add(0, &baked, &corners, &m.triangles, material);
            continue;
        }
        let weights = node.weights().or(mesh.weights()).map_or_else(|| vec![0.0; part.targets.len()], <[f32]>::to_vec);
        let deform = if rigid { Deform::Rigid } else { Deform::Blend { targets: part.targets, weights, skin } };
        let name = mesh.name().map_or_else(|| format!("mesh {}", mesh.index()), str::to_string);
        scene.objects.push(Object::new(name, index, part.mesh, deform));
    }
    Ok(())
}

struct Part {
    mesh: Mesh,
    targets: Vec<MorphTarget>,
}

fn vec3s(values: &[f32]) -> Vec<Vec3> {
    values.as_chunks::<3>().0.iter().map(|&v| Vec3::from_array(v)).collect()
}

/// One list of triangles; `None` for points and lines.
fn read_primitive(
    scene: &mut SceneFile,
    buffers: &Buffers,
    mesh: &gltf::Mesh,
    primitive: &gltf::Primitive,
) -> Result<Option<Part>, LoadError> {
    use gltf::Semantic;
    use gltf::mesh::Mode;
    let here = || format!("primitive {} of mesh {}", primitive.index(), mesh.index());
    let mode = primitive.mode();
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        scene.warnings.push(buffers.error(format!("{} has no triangles; it is not drawn", here())).to_string());
        return Ok(None);
    }
    let Some(positions) = primitive.get(&Semantic::Positions) else {
        scene.warnings.push(buffers.error(format!("{} has no positions; it is not drawn", here())).to_string());
        return Ok(None);
    };
    let positions = vec3s(&buffers.floats(&positions, 3)?);
    let indices = match primitive.indices() {
        Some(indices) => buffers.integers(&indices, 1)?,
        None => (0..positions.len() as u32).collect(),
    };
    if let Some(bad) = indices.iter().find(|&&i| i as usize >= positions.len()) {
        return Err(buffers.error(format!("{} uses vertex {bad}, but has only {}", here(), positions.len())));
    }
    let triangles: Vec<[u32; 3]> = match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(k, w)| if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect(),
        Mode::TriangleFan => indices.windows(2).skip(1).map(|w| [indices[0], w[0], w[1]]).collect(),
        _ => indices.as_chunks::<3>().0.to_vec(),
    };
    let count = positions.len();
    let attribute = |semantic: Semantic, width: usize| -> Result<Option<Vec<f32>>, LoadError> {
        match primitive.get(&semantic) {
            Some(accessor) => {
                let values = buffers.floats(&accessor, width)?;
                if values.len() != count * width {
                    return Err(buffers.error(format!("attributes of {} differ in length", here())));
                }
                Ok(Some(values))
            }
            None => Ok(None),
        }
    };
    let colors = match primitive.get(&Semantic::Colors(0)).map(|a| a.dimensions()) {
        None => Vec::new(),
        Some(gltf::accessor::Dimensions::Vec3) => {
            let rgb = attribute(Semantic::Colors(0), 3)?.unwrap_or_default();
            vec3s(&rgb).into_iter().map(|c| c.extend(1.0)).collect()
        }
        Some(_) => {
            let rgba = attribute(Semantic::Colors(0), 4)?.unwrap_or_default();
            rgba.as_chunks::<4>().0.iter().map(|&c| Vec4::from_array(c)).collect()
        }
    };
    let mut targets = Vec::new();
    for target in primitive.morph_targets() {
        let read = |accessor: Option<gltf::Accessor>| -> Result<Vec<Vec3>, LoadError> {
            let values = accessor.map_or(Ok(Vec::new()), |a| buffers.floats(&a, 3))?;
            if !values.is_empty() && values.len() != count * 3 {
                return Err(buffers.error(format!("morph targets of {} differ in length", here())));
            }
            Ok(vec3s(&values))
        };
        targets.push(MorphTarget { positions: read(target.positions())?, normals: read(target.normals())? });
    }
    let material = primitive.material().index().map_or(0, |m| m as u32 + 1);
    let tex_coord_set = primitive.material().pbr_metallic_roughness().base_color_texture().map_or(0, |t| t.tex_coord());
    let tex_coords = attribute(Semantic::TexCoords(tex_coord_set), 2)?.unwrap_or_default();
    let mesh = Mesh {
        normals: vec3s(&attribute(Semantic::Normals, 3)?.unwrap_or_default()),
        tex_coords: tex_coords.as_chunks::<2>().0.iter().map(|&t| Vec2::from_array(t)).collect(),
        colors,
        materials: vec![material; triangles.len()],
        triangles,
        positions,
    };
    Ok(Some(Part { mesh, targets }))
}

fn read_skin(
    buffers: &Buffers,
    skin: &gltf::Skin,
    primitive: &gltf::Primitive,
    vertices: usize,
    nodes: &Nodes,
) -> Result<Option<Skin>, LoadError> {
    use gltf::Semantic;
    let (Some(joints), Some(weights)) = (primitive.get(&Semantic::Joints(0)), primitive.get(&Semantic::Weights(0)))
    else {
        return Ok(None);
    };
    // Joints outside the scene stay at the origin.
    let joint_nodes: Vec<u32> = skin.joints().map(|j| nodes.index_of.get(&j.index()).copied().unwrap_or(0)).collect();
    let inverse_bind: Vec<Mat4> = match skin.inverse_bind_matrices() {
        Some(accessor) => {
            let values = buffers.floats(&accessor, 16)?;
            values.as_chunks::<16>().0.iter().map(Mat4::from_cols_array).collect()
        }
        None => vec![Mat4::IDENTITY; joint_nodes.len()],
    };
    let indices = buffers.integers(&joints, 4)?;
    let weights = buffers.floats(&weights, 4)?;
    let bad = indices.iter().any(|&i| i as usize >= joint_nodes.len());
    if bad || inverse_bind.len() < joint_nodes.len() || indices.len() != vertices * 4 || weights.len() != vertices * 4 {
        return Err(buffers.error(format!("skin {} does not fit its mesh", skin.index())));
    }
    Ok(Some(Skin {
        joints: joint_nodes,
        inverse_bind,
        indices: indices.as_chunks::<4>().0.iter().map(|&i| i.map(|i| i.min(0xffff) as u16)).collect(),
        weights: weights.as_chunks::<4>().0.iter().map(|&w| Vec4::from_array(w)).collect(),
    }))
}

fn materials(gltf: &gltf::Gltf, buffers: &Buffers, scene: &mut SceneFile) -> Result<(), LoadError> {
    let mut textures: HashMap<usize, Option<u32>> = HashMap::new();
    for material in gltf.materials() {
        let pbr = material.pbr_metallic_roughness();
        let texture = match pbr.base_color_texture() {
            Some(info) => {
                let index = info.texture().index();
                match textures.get(&index) {
                    Some(known) => *known,
                    None => {
                        let read = read_texture(&info.texture(), buffers);
                        let found = match read {
                            Ok(source) => {
                                scene.textures.push(source);
                                Some(scene.textures.len() as u32 - 1)
                            }
                            Err(e) => {
                                scene.warnings.push(e.to_string());
                                None
                            }
                        };
                        textures.insert(index, found);
                        found
                    }
                }
            }
            None => None,
        };
        scene.materials.push(translate(&material, texture));
    }
    Ok(())
}

fn translate(material: &gltf::Material, texture: Option<u32>) -> Material {
    let pbr = material.pbr_metallic_roughness();
    let base = Vec4::from_array(pbr.base_color_factor());
    let (metallic, roughness) = (pbr.metallic_factor().clamp(0.0, 1.0), pbr.roughness_factor().clamp(0.0, 1.0));
    let ior = material.ior().unwrap_or(1.5);
    // Reflectance at right angles: 4 % for the usual index of 1.5.
    let dielectric = ((ior - 1.0) / (ior + 1.0)).powi(2);
    let specular = Vec3::splat(dielectric).lerp(base.truncate(), metallic);
    let alpha = (roughness * roughness).max(0.03);
    let smooth = (1.0 - roughness * 2.0).max(0.0);
    let glass = material.transmission().map_or(0.0, |t| t.transmission_factor());
    let see_through = if material.alpha_mode() == gltf::material::AlphaMode::Blend { 1.0 - base.w } else { 0.0 };
    let transmission = glass.max(see_through).clamp(0.0, 1.0);
    let diffuse = base.truncate() * (1.0 - metallic) * (1.0 - transmission);
    Material {
        name: material.name().unwrap_or("").to_string(),
        emission: Vec3::from_array(material.emissive_factor()) * material.emissive_strength().unwrap_or(1.0),
        ambient: diffuse * 0.05,
        diffuse,
        specular,
        shininess: 2.0 / (alpha * alpha) - 2.0,
        reflection: specular * smooth,
        transmission,
        ior: if glass > 0.0 { ior } else { 1.0 },
        texture,
        alpha_cutoff: (material.alpha_mode() == gltf::material::AlphaMode::Mask)
            .then(|| material.alpha_cutoff().unwrap_or(0.5)),
    }
}

fn read_texture(texture: &gltf::Texture, buffers: &Buffers) -> Result<TextureSource, LoadError> {
    use gltf::texture::WrappingMode;
    let bytes = match texture.source().source() {
        gltf::image::Source::View { view, .. } => buffers.view(&view)?.to_vec(),
        gltf::image::Source::Uri { uri, .. } => buffers.uri(uri)?,
    };
    Ok(TextureSource {
        name: texture.name().map_or_else(|| format!("texture {}", texture.index()), str::to_string),
        data: TextureData::Bytes(bytes),
        first_row_at_zero: true,
        clamp_s: texture.sampler().wrap_s() == WrappingMode::ClampToEdge,
        clamp_t: texture.sampler().wrap_t() == WrappingMode::ClampToEdge,
    })
}

fn add_camera(scene: &mut SceneFile, node: &gltf::Node, index: u32) {
    let Some(camera) = node.camera() else { return };
    let projection = match camera.projection() {
        gltf::camera::Projection::Perspective(p) => {
            let degrees = f64::from(p.yfov()).to_degrees();
            Projection::Perspective { fov_y: if degrees > 0.0 && degrees < 180.0 { degrees } else { 45.0 } }
        }
        gltf::camera::Projection::Orthographic(o) => {
            let half_height = f64::from(o.ymag()).abs();
            Projection::Orthographic { half_height: if half_height > 0.0 { half_height } else { 1.0 } }
        }
    };
    scene.cameras.push(Camera {
        name: camera.name().or(node.name()).unwrap_or("camera").to_string(),
        rest: View { from: DVec3::ZERO, forward: DVec3::NEG_Z, up: DVec3::Y },
        node: Some(index),
        keys: None,
        projection,
        resolution: None,
    });
}

fn add_light(scene: &mut SceneFile, node: &gltf::Node, index: u32) {
    use gltf::khr_lights_punctual::Kind;
    let Some(light) = node.light() else { return };
    let kind = match light.kind() {
        Kind::Directional => LightKind::Directional,
        Kind::Point => LightKind::Point { attenuated: true },
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            LightKind::Spot { inner: inner_cone_angle.to_degrees(), outer: outer_cone_angle.to_degrees() }
        }
    };
    scene.lights.push(Light {
        name: light.name().or(node.name()).unwrap_or("light").to_string(),
        kind,
        // Candela or lux; the library counts in what a white surface reflects, which is a π-th.
        color: Vec3::from_array(light.color()) * light.intensity() / std::f32::consts::PI,
        position: DVec3::ZERO,
        direction: DVec3::NEG_Z,
        node: Some(index),
        keys: None,
    });
}
