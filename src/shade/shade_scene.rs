//! The scene as one frame sees it: late binding happens here. Names become dense indices, parameters become typed
//! values, and nothing is looked up by name again while rays fly.

use crate::memory::{OutOfMemory, Room, emptied};
use crate::scene::{DEFAULT_AMBIENT, FrameDesc, InstanceList, Mesh, Name, Program, Scene, Shader};
use crate::shade::block::Blocks;
use crate::shade::camera::Camera;
use crate::shade::environment::Environment;
use crate::shade::footprint::Cone;
use crate::shade::integrator::Integrator;
use crate::shade::interaction::Interaction;
use crate::shade::light::Light;
use crate::shade::names::NameTable;
use crate::shade::placed::{Placed, PlacedInstances};
use crate::shade::surface::{Surface, UserSurface};
use crate::shade::surface_use::SurfaceUse;
use crate::shade::textures::{TextureCache, Textures};
use crate::shade::values::Values;
use crate::trace::{Hit, Ray};
use glam::{Vec3, Vec4};

/// The [look](ShadeScene::look) of instances that have several.
pub(super) const MANY: u32 = u32::MAX;

/// What shading keeps from frame to frame: what it has found out of the scene, and the memory of a frame's lists.
#[derive(Default)]
pub struct ShadeMemory {
    pub textures: TextureCache,
    pub blocks: Blocks,
    used: SurfaceUse,
    lists: Lists<'static>,
}

impl ShadeMemory {
    /// Brings everything in line with the scene.
    ///
    /// # Errors
    /// No memory; the next update tries again.
    pub fn update(&mut self, scene: &Scene) -> Result<(), OutOfMemory> {
        self.textures.update(scene)?;
        self.blocks.update(scene)
    }
}

/// What a frame has one of per instance, surface, texture or light.
#[derive(Default)]
struct Lists<'a> {
    /// The mesh of each instance; None where the object does not exist.
    meshes: Vec<Option<&'a Mesh>>,
    /// Of each instance that a ray of this frame has hit.
    placed: PlacedInstances,
    /// See [`ShadeScene::look`].
    looks: Vec<u32>,
    /// Number 0 is the default surface.
    surfaces: Vec<Surface>,
    /// Of each surface its shader.
    names: Vec<Name>,
    surface_of: NameTable,
    textures: Textures,
    lights: Vec<Light>,
}

/// Everything that shading reads during one frame.
pub struct ShadeScene<'a> {
    list: InstanceList<'a>,
    meshes: Vec<Option<&'a Mesh>>,
    placed: PlacedInstances,
    looks: Vec<u32>,
    surfaces: Vec<Surface>,
    names: Vec<Name>,
    surface_of: NameTable,
    pub textures: Textures,
    /// Lights in the order of use, without the ambient ones.
    pub lights: Vec<Light>,
    /// The frame uses no light at all, so the eye carries a lamp.
    pub headlight: bool,
    pub camera: Camera,
    pub environment: Environment,
    pub integrator: Integrator,
    /// Some surface of the frame lets shadow rays pass.
    pub see_through: bool,
}

impl<'a> ShadeScene<'a> {
    /// `list` are the instances of the frame. `memory` must be up to date with the scene; [`ShadeScene::end`] gives back what it lends.
    ///
    /// # Errors
    /// No memory.
    pub fn new(
        scene: &'a Scene,
        frame: &FrameDesc,
        list: InstanceList<'a>,
        memory: &mut ShadeMemory,
    ) -> Result<Self, OutOfMemory> {
        let ShadeMemory { textures: cache, blocks, used, lists } = memory;
        used.update(scene, list.instances)?;
        let Lists { meshes, mut placed, mut looks, mut surfaces, mut names, mut surface_of, mut textures, mut lights } =
            std::mem::take(lists);
        let count = list.instances.len();
        let mut meshes: Vec<Option<&'a Mesh>> = emptied(meshes);
        meshes.room(count)?;
        let mut last: (Name, Option<&Mesh>) = (0, None);
        meshes.extend(list.instances.iter().map(|instance| {
            if instance.object != last.0 {
                last = (instance.object, scene.objects.get(&instance.object).map(|object| &*object.mesh));
            }
            last.1
        }));
        placed.begin(count)?;

        lights.room(frame.lights.len())?;
        let mut ambient = Ambient::new(frame);
        for light in &frame.lights {
            let Some(shader) = scene.shaders.get(&light.shader) else { continue };
            let place = &light.world_from_light;
            match &shader.class.program {
                Program::BuiltIn if &*shader.class.name == "ambient" => ambient.add(Values(shader).vec3("color")),
                Program::BuiltIn => lights.extend(Light::built_in(&shader.class.name, Values(shader), place)),
                Program::Light(program) => {
                    lights.extend(blocks.get(light.shader).map(|block| Light::user(program.clone(), block, place)));
                }
                _ => {}
            }
        }

        textures.take(cache)?;
        surfaces.room(scene.shaders.len() + 1)?;
        names.clear();
        names.room(scene.shaders.len() + 1)?;
        names.push(0);
        surfaces.push(Surface::default());
        surfaces[0].reflect_ambient(ambient.of(false));
        for (&name, shader) in &scene.shaders {
            if let Some(mut surface) = compile_surface(name, shader, &textures, blocks) {
                surface.reflect_ambient(ambient.of(shader.is_given("ambient")));
                names.push(name);
                surfaces.push(surface);
            }
        }
        surface_of.rebuild(names.iter().copied())?;
        let is_see_through = |name| surface_of.get(name).is_some_and(|index| surfaces[index as usize].is_see_through());
        let see_through = surfaces.iter().any(Surface::is_see_through) && used.any(list.instances, is_see_through);

        looks.clear();
        looks.room(count)?;
        let mut last: (Name, u32) = (0, MANY);
        looks.extend(list.instances.iter().zip(&meshes).map(|(instance, mesh)| {
            if instance.object != last.0 {
                let coloured = mesh.is_some_and(|mesh| !mesh.colors.is_empty());
                let number = used.only(instance.object).map(|name| surface_of.get(name).unwrap_or(0));
                last = (instance.object, number.map_or(MANY, |number| number << 1 | u32::from(coloured)));
            }
            last.1
        }));

        Ok(Self {
            list,
            meshes,
            placed,
            looks,
            surfaces,
            names,
            surface_of,
            lights,
            headlight: frame.lights.is_empty(),
            camera: compile_camera(scene, frame, blocks),
            environment: compile_environment(scene, frame, &textures, blocks),
            integrator: Integrator::new(scene.shaders.get(&frame.renderer), frame.max_depth),
            see_through,
            textures,
        })
    }

    /// Gives the memory of the lists to the next frame; nothing of the scene stays in them.
    pub fn end(self, memory: &mut ShadeMemory) {
        let Self { meshes, placed, looks, mut surfaces, names, surface_of, mut textures, mut lights, .. } = self;
        surfaces.clear();
        lights.clear();
        textures.clear();
        let meshes = emptied(meshes);
        memory.lists = Lists { meshes, placed, looks, surfaces, names, surface_of, textures, lights };
    }

    /// How much memory a worker needs for parameter blocks of the user's surfaces: of how many at a time, and bytes for each.
    pub fn patches(&self) -> (usize, usize) {
        let bytes = |surface: &Surface| match surface {
            Surface::User(user) => user.block.patch_bytes(),
            _ => 0,
        };
        (self.integrator.max_depth() as usize + 1, self.surfaces.iter().map(bytes).max().unwrap_or(0))
    }

    /// Whether the rendering object of the scene sends no rays but those of the camera.
    pub fn is_primary_only(&self) -> bool {
        self.integrator == Integrator::RAYCAST
    }

    /// By which numbers the application knows the instances.
    pub fn list(&self) -> &InstanceList<'a> {
        &self.list
    }

    #[inline]
    pub fn mesh(&self, instance: u32) -> &'a Mesh {
        self.meshes[instance as usize].expect("only instances of existing objects are hit")
    }

    /// The surface of the triangle that was hit.
    #[inline]
    pub fn surface(&self, hit: &Hit) -> &Surface {
        let name = self.mesh(hit.instance).shader_of_triangle.get(hit.primitive as usize).copied().unwrap_or(0);
        self.numbered_surface(self.surface_number(name))
    }

    /// The number of a shader's surface.
    #[inline]
    pub(super) fn surface_number(&self, name: Name) -> u32 {
        self.surface_of.get(name).unwrap_or(0)
    }

    /// What is the same for all triangles of an instance: twice the number of their surface, and 1 if vertices have colours. [`MANY`] where they
    /// have several surfaces.
    #[inline(always)]
    pub(super) fn look(&self, instance: u32) -> u32 {
        self.looks[instance as usize]
    }

    #[inline]
    pub(super) fn numbered_surface(&self, number: u32) -> &Surface {
        &self.surfaces[number as usize]
    }

    #[inline(always)]
    pub fn interaction(&self, ray: &Ray, hit: &Hit, cone: Cone, depth: u32) -> Interaction<'_> {
        Interaction::new(ray, hit, self.placed(hit.instance), self.mesh(hit.instance), cone, depth)
    }

    #[inline(always)]
    pub(super) fn placed(&self, instance: u32) -> &Placed {
        self.placed.get(instance, || self.list.instances[instance as usize].world_from_object)
    }
}

/// The light from everywhere.
struct Ambient {
    /// Sum of the lights of class `ambient`.
    lights: Option<Vec3>,
    /// That of the frame, if the application has set it.
    frame: Option<Vec3>,
}

impl Ambient {
    fn new(frame: &FrameDesc) -> Self {
        Self { lights: None, frame: frame.ambient.map(Vec3::from_array) }
    }

    fn add(&mut self, color: Vec3) {
        *self.lights.get_or_insert(Vec3::ZERO) += color;
    }

    /// What a surface gets whose share of it was set, or was not.
    fn of(&self, share_is_set: bool) -> Vec3 {
        match (self.lights, self.frame) {
            (None, None) if share_is_set => Vec3::from_array(DEFAULT_AMBIENT),
            (lights, frame) => lights.unwrap_or(Vec3::ZERO) + frame.unwrap_or(Vec3::ZERO),
        }
    }
}

pub(super) fn compile_surface(name: Name, shader: &Shader, textures: &Textures, blocks: &Blocks) -> Option<Surface> {
    match &shader.class.program {
        Program::BuiltIn => Surface::built_in(&shader.class.name, Values(shader), textures),
        Program::Surface(program) => Some(Surface::User(UserSurface {
            program: program.clone(),
            block: blocks.get(name)?,
            shader: name,
            class: shader.class.clone(),
        })),
        _ => None,
    }
}

/// The frame's camera; the default one where the frame names none.
pub fn compile_camera(scene: &Scene, frame: &FrameDesc, blocks: &Blocks) -> Camera {
    let camera = scene.shaders.get(&frame.camera).and_then(|shader| match &shader.class.program {
        Program::BuiltIn => Camera::built_in(&shader.class.name, Values(shader)),
        Program::Camera(program) => Some(Camera::user(program.clone(), blocks.get(frame.camera)?)),
        _ => None,
    });
    camera.unwrap_or_default()
}

fn compile_environment(scene: &Scene, frame: &FrameDesc, textures: &Textures, blocks: &Blocks) -> Environment {
    let environment = scene.shaders.get(&frame.environment).and_then(|shader| match &shader.class.program {
        Program::BuiltIn => Environment::built_in(&shader.class.name, Values(shader), |name| textures.get(name)),
        Program::Environment(program) => {
            Some(Environment::User { program: program.clone(), block: blocks.get(frame.environment)? })
        }
        _ => None,
    });
    environment.unwrap_or(Environment::Clear(Vec4::from_array(frame.clear_color)))
}
