//! A scene as a file describes it, before any of it is given to the library.
//!
//! The loaders of all formats fill the same [`SceneFile`]: a tree of nodes that move with time, objects whose
//! triangles are stored relative to one node each, and what is needed to shade and see them. Everything that does not
//! move relative to its node is baked into the object, so a BART kitchen is one static object and one object for
//! each moving part; that is the two-level scene that the engine is made for (Wald03 §3).
//!
//! Times are seconds on the file's own clock, angles degrees, matrices `parent_from_local` in double precision.

mod animation;
mod material;
mod mesh;
mod pose;
mod spline;
mod track;
mod view;

pub use animation::{KeyedTransform, VisibilityKey};
pub use material::{Material, MetallicRoughness, TextureData, TextureSource};
pub use mesh::{Deform, Deformed, KeyedTriangle, Mesh, MorphTarget, Object, Skin, TriangleKey};
pub use pose::{Local, Node, Pose};
pub use spline::{PositionKey, PositionSpline, RotationKey, RotationSpline, Tcb};
pub use track::{Interpolation, Track, TrsChannels};
pub use view::{Camera, Light, LightKind, Projection, View};

use glam::{DVec3, Vec3};
use std::path::PathBuf;

/// Interval and number of frames of the animation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Animation {
    pub start: f64,
    pub end: f64,
    pub frames: u32,
}

impl Animation {
    /// Time of a frame: frame 0 is at the start and the last frame at the end. Later frames go on at the same pace.
    pub fn time(&self, frame: u32) -> f64 {
        let intervals = self.frames.saturating_sub(1).max(1);
        self.start + (self.end - self.start) * f64::from(frame) / f64::from(intervals)
    }
}

/// Key frames that are played together: what a file calls an animation, or several that do not meet.
#[derive(Clone, Debug)]
pub struct Clip {
    pub name: String,
    pub animation: Animation,
    /// What moves: indices into `SceneFile::nodes`, each once, with their channels.
    pub channels: Vec<(u32, TrsChannels)>,
}

/// What rays see that leave the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    Color(Vec3),
    /// A mild sky, for formats that do not know of a background: metals need something to mirror.
    Sky,
}

/// What the file said, for `openrt info`; counted with included files expanded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    pub files: u64,
    pub meshes: u64,
    pub mesh_triangles: u64,
    pub polygons: u64,
    pub polygon_triangles: u64,
    pub textured_triangles: u64,
    pub animated_triangles: u64,
    pub spheres: u64,
    pub cones: u64,
    /// Triangles made from spheres and cones.
    pub tessellated_triangles: u64,
    pub static_transforms: u64,
    pub translation_keys: u64,
    pub rotation_keys: u64,
    pub scale_keys: u64,
    pub visibility_keys: u64,
}

impl Counts {
    /// Triangles that the file itself gives, at rest; without tessellated surfaces and key-framed triangles.
    pub fn triangles(&self) -> u64 {
        self.mesh_triangles + self.polygon_triangles + self.textured_triangles
    }
}

/// A whole scene. `nodes[0]` is the root; a node comes after its parent.
#[derive(Clone, Debug)]
pub struct SceneFile {
    pub format: &'static str,
    pub path: PathBuf,
    pub nodes: Vec<Node>,
    pub objects: Vec<Object>,
    /// `materials[0]` is what triangles without a material get.
    pub materials: Vec<Material>,
    pub textures: Vec<TextureSource>,
    pub lights: Vec<Light>,
    /// The first camera is the one that is used.
    pub cameras: Vec<Camera>,
    pub background: Background,
    /// Multiplies the ambient colour of every material.
    pub ambient: Vec3,
    pub animation: Option<Animation>,
    /// What can be played by [`SceneFile::play_clip`]; empty for formats with one animation.
    pub clips: Vec<Clip>,
    /// Names of moving transforms, each once.
    pub named_transforms: Vec<String>,
    /// Colours and textures are meant for a display with the sRGB curve.
    pub srgb: bool,
    pub counts: Counts,
    /// Something in the file was not understood or is missing; `path:line: text`.
    pub warnings: Vec<String>,
    /// Oddities with a defined meaning, such as keys that time never reaches.
    pub notes: Vec<String>,
}

impl SceneFile {
    pub fn new(format: &'static str, path: PathBuf) -> Self {
        Self {
            format,
            path,
            nodes: vec![Node::root()],
            objects: Vec::new(),
            materials: vec![Material::default()],
            textures: Vec::new(),
            lights: Vec::new(),
            cameras: Vec::new(),
            background: Background::Sky,
            ambient: Vec3::ONE,
            animation: None,
            clips: Vec::new(),
            named_transforms: Vec::new(),
            srgb: false,
            counts: Counts::default(),
            warnings: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Placement of every node at `time`.
    pub fn pose(&self, time: f64) -> Vec<Pose> {
        pose::pose(&self.nodes, time)
    }

    /// Makes `clips[index]` the one that is played; all others rest. An index that is out of range changes nothing. To be called
    /// before the scene is defined in a context.
    pub fn play_clip(&mut self, index: usize) {
        if index >= self.clips.len() {
            return;
        }
        for clip in &self.clips {
            for (node, channels) in &clip.channels {
                if let Local::Channels(current) = &mut self.nodes[*node as usize].local {
                    **current = channels.at_rest();
                }
            }
        }
        let clip = &self.clips[index];
        for (node, channels) in &clip.channels {
            if let Local::Channels(current) = &mut self.nodes[*node as usize].local {
                **current = channels.clone();
            }
        }
        self.animation = Some(clip.animation);
    }

    /// For each node, whether it or one above it can move.
    pub fn moving_nodes(&self) -> Vec<bool> {
        let mut moving: Vec<bool> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let parent = node.parent.is_some_and(|p| moving.get(p as usize).copied().unwrap_or(false));
            moving.push(parent || node.moves());
        }
        moving
    }

    /// A camera that shows everything, for files without one: from the front, the right and a little above.
    pub fn overview(&self) -> Camera {
        let start = self.animation.map_or(0.0, |a| a.start);
        let (low, high) = self.bounds(start).unwrap_or((Vec3::NEG_ONE, Vec3::ONE));
        let center = (low.as_dvec3() + high.as_dvec3()) * 0.5;
        let radius = ((high.as_dvec3() - low.as_dvec3()).length() * 0.5).max(1e-6);
        let fov = 45.0_f64;
        let distance = radius / (fov.to_radians() * 0.5).sin();
        let towards = DVec3::new(0.5, 0.4, 1.0).normalize();
        Camera {
            name: "overview".into(),
            rest: View { from: center + towards * distance, forward: -towards, up: DVec3::Y },
            node: None,
            keys: None,
            projection: Projection::Overview { fov },
            resolution: None,
        }
    }

    /// Smallest box around all objects at `time`, in world space; `None` without a finite vertex.
    pub fn bounds(&self, time: f64) -> Option<(Vec3, Vec3)> {
        let poses = self.pose(time);
        let mut low = Vec3::INFINITY;
        let mut high = Vec3::NEG_INFINITY;
        for object in &self.objects {
            let deformed = object.deformed(time, &poses, &self.nodes);
            let positions = deformed.as_ref().map_or(&object.mesh.positions, |d| &d.positions);
            // What stands often is taken as its box, which may be a little larger when it is turned.
            let corners = (object.count() > 1).then(|| corners_of_box(positions));
            let positions: &[Vec3] = corners.as_ref().map_or(positions, |c| c);
            for world in object.placements(&poses) {
                let world = world.as_affine3();
                for p in positions.iter().map(|&p| world.transform_point3(p)).filter(|p| p.is_finite()) {
                    low = low.min(p);
                    high = high.max(p);
                }
            }
        }
        (low.cmple(high).all()).then_some((low, high))
    }
}

/// Corners of the smallest box around the finite ones of some points.
fn corners_of_box(points: &[Vec3]) -> [Vec3; 8] {
    let finite = || points.iter().copied().filter(|p| p.is_finite());
    let low = finite().fold(Vec3::INFINITY, Vec3::min);
    let high = finite().fold(Vec3::NEG_INFINITY, Vec3::max);
    std::array::from_fn(|i| Vec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), high, low))
}
