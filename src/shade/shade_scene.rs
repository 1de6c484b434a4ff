//! The scene as one frame sees it: late binding happens here. Names become dense indices, parameters become typed
//! values, and nothing is looked up by name again while rays fly.

use crate::scene::{DEFAULT_AMBIENT, FrameDesc, Instance, InstanceList, Mesh, Name, Program, Scene, Shader};
use crate::shade::block::Block;
use crate::shade::camera::Camera;
use crate::shade::environment::Environment;
use crate::shade::footprint::Cone;
use crate::shade::integrator::Integrator;
use crate::shade::interaction::Interaction;
use crate::shade::light::Light;
use crate::shade::names::NameTable;
use crate::shade::placed::Placed;
use crate::shade::surface::{Surface, UserSurface};
use crate::shade::surface_use::SurfaceUse;
use crate::shade::textures::{TextureCache, Textures};
use crate::shade::values::Values;
use crate::trace::{Hit, Ray};
use glam::{Vec3, Vec4};
use std::sync::OnceLock;

/// The [look](ShadeScene::look) of instances that have several.
pub(super) const MANY: u32 = u32::MAX;

/// Everything that shading reads during one frame.
pub struct ShadeScene<'a> {
    list: InstanceList<'a>,
    /// The mesh of each instance; None where the object does not exist.
    meshes: Vec<Option<&'a Mesh>>,
    /// Of each instance that a ray of this frame has hit.
    placed: Vec<OnceLock<Box<Placed>>>,
    /// See [`ShadeScene::look`].
    looks: Vec<u32>,
    /// Number 0 is the default surface.
    surfaces: Vec<Surface>,
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
    /// `list` are the instances of the frame. `cache` must be up to date with the scene.
    pub fn new(
        scene: &'a Scene,
        frame: &FrameDesc,
        list: InstanceList<'a>,
        cache: &TextureCache,
        used: &mut SurfaceUse,
    ) -> Self {
        let textures = Textures::new(cache);
        let mut last: (Name, Option<&Mesh>) = (0, None);
        let mesh = |instance: &Instance| {
            if instance.object != last.0 {
                last = (instance.object, scene.objects.get(&instance.object).map(|object| &*object.mesh));
            }
            last.1
        };
        let meshes: Vec<_> = list.instances.iter().map(mesh).collect();
        let placed = list.instances.iter().map(|_| OnceLock::new()).collect();

        let mut lights = Vec::new();
        let mut ambient = Ambient::new(frame);
        for light in &frame.lights {
            let Some(shader) = scene.shaders.get(&light.shader) else { continue };
            let place = &light.world_from_light;
            match &shader.class.program {
                Program::BuiltIn if &*shader.class.name == "ambient" => ambient.add(Values(shader).vec3("color")),
                Program::BuiltIn => lights.extend(Light::built_in(&shader.class.name, Values(shader), place)),
                Program::Light(program) => lights.push(Light::user(program.clone(), Block::pack(shader), place)),
                _ => {}
            }
        }

        let mut surfaces = vec![Surface::default()];
        surfaces[0].reflect_ambient(ambient.of(false));
        let mut names = vec![0];
        for (&name, shader) in &scene.shaders {
            if let Some(mut surface) = compile_surface(name, shader, &textures) {
                surface.reflect_ambient(ambient.of(shader.is_given("ambient")));
                names.push(name);
                surfaces.push(surface);
            }
        }
        let surface_of = NameTable::new(names.iter().copied());
        let is_see_through = |name| surface_of.get(name).is_some_and(|index| surfaces[index as usize].is_see_through());
        let see_through =
            surfaces.iter().any(Surface::is_see_through) && used.any(scene, list.instances, is_see_through);

        let mut last: (Name, u32) = (0, MANY);
        let look = |(instance, mesh): (&Instance, &Option<&Mesh>)| {
            if instance.object != last.0 {
                let coloured = mesh.is_some_and(|mesh| !mesh.colors.is_empty());
                let number = used.only(scene, instance.object).map(|name| surface_of.get(name).unwrap_or(0));
                last = (instance.object, number.map_or(MANY, |number| number << 1 | u32::from(coloured)));
            }
            last.1
        };
        let looks = list.instances.iter().zip(&meshes).map(look).collect();

        Self {
            list,
            meshes,
            placed,
            looks,
            surfaces,
            surface_of,
            lights,
            headlight: frame.lights.is_empty(),
            camera: compile_camera(scene, frame),
            environment: compile_environment(scene, frame, &textures),
            integrator: Integrator::new(scene.shaders.get(&frame.renderer), frame.max_depth),
            see_through,
            textures,
        }
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
        let name = self.mesh(hit.instance).shader_of_triangle.get(hit.prim as usize).copied().unwrap_or(0);
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
        let number = instance as usize;
        self.placed[number].get_or_init(|| Box::new(Placed::new(self.list.instances[number].world_from_object)))
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

pub(super) fn compile_surface(name: Name, shader: &Shader, textures: &Textures) -> Option<Surface> {
    match &shader.class.program {
        Program::BuiltIn => Surface::built_in(&shader.class.name, Values(shader), textures),
        Program::Surface(program) => Some(Surface::User(UserSurface {
            program: program.clone(),
            block: Block::pack(shader),
            shader: name,
            class: shader.class.clone(),
        })),
        _ => None,
    }
}

/// The frame's camera; the default one where the frame names none.
pub fn compile_camera(scene: &Scene, frame: &FrameDesc) -> Camera {
    let camera = scene.shaders.get(&frame.camera).and_then(|shader| match &shader.class.program {
        Program::BuiltIn => Camera::built_in(&shader.class.name, Values(shader)),
        Program::Camera(program) => Some(Camera::user(program.clone(), Block::pack(shader))),
        _ => None,
    });
    camera.unwrap_or_default()
}

fn compile_environment(scene: &Scene, frame: &FrameDesc, textures: &Textures) -> Environment {
    let environment = scene.shaders.get(&frame.environment).and_then(|shader| match &shader.class.program {
        Program::BuiltIn => Environment::built_in(&shader.class.name, Values(shader), |name| textures.get(name)),
        Program::Environment(program) => {
            Some(Environment::User { program: program.clone(), block: Block::pack(shader) })
        }
        _ => None,
    });
    environment.unwrap_or(Environment::Clear(Vec4::from_array(frame.clear_color)))
}
