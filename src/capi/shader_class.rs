//! Shader classes made of C functions: their description, and the programs that call them.

use super::constants::*;
use super::current::UserData;
use super::pointer::{array_at, slice, text, value};
use super::refusal::unknown;
use super::shading::RTshadingContext;
use super::types::*;
use crate::api::{
    CameraShader, EnvironmentShader, Error, Layout, LightSample, LightShader, ParamDef, ParamScope, ParamType,
    ParamValue, PrimaryRay, Program, Result, ShaderClass, ShaderKind, ShadingContext, SurfaceShader, check_sizes,
};
use crate::memory;
use glam::{Vec2, Vec3, Vec4};
use std::ffi::{c_char, c_void};
use std::sync::Arc;

/// The point that a surface shader colours. World space, except where said.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RTsurfacePoint {
    /// Where the ray met the surface.
    pub position: [RTfloat; 3],
    /// Unit interpolated normal, turned to the side from which the ray came.
    pub normal: [RTfloat; 3],
    /// Unit normal of the triangle, turned to the side from which the ray came.
    pub geometricNormal: [RTfloat; 3],
    /// Unit direction of the ray, towards the surface.
    pub incoming: [RTfloat; 3],
    /// Interpolated texture coordinate.
    pub texCoord: [RTfloat; 2],
    /// Interpolated vertex colour; white for objects without.
    pub color: [RTfloat; 4],
    /// Barycentric weights of the second and third corner.
    pub barycentric: [RTfloat; 2],
    /// Distance that the ray has come.
    pub distance: RTfloat,
    /// Name of the object.
    pub object: RTuint,
    /// Number of the instance in its frame.
    pub instance: RTuint,
    /// Number of the triangle in its object.
    pub primitive: RTuint,
    /// Bounces so far; 0 for a ray from the camera.
    pub depth: RTuint,
    /// RT_TRUE when the ray came from the side on which the corners appear clockwise.
    pub backFacing: RTboolean,
}

/// Light that arrives at a point.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RTlightSample {
    /// Unit direction from the point to the light.
    pub direction: [RTfloat; 3],
    /// Distance to the light; INFINITY for directional light.
    pub distance: RTfloat,
    /// Linear red, green and blue, before anything stands in the way.
    pub radiance: [RTfloat; 3],
}

/// Colours a point: stores at result linear red, green and blue that leave it towards the ray's origin, and its
/// opacity (1 hides what is behind). params is the parameter block of the shader at this point, userData that
/// of the class. context is valid during the call only. Called from several threads at once; must not leave by
/// longjmp() or by a C++ exception, nor call rt functions (the rts functions are for it).
pub type RTshadeFunction = Option<
    unsafe extern "C" fn(
        context: *mut RTshadingContext,
        params: *const c_void,
        userData: *mut c_void,
        result: *mut RTfloat,
    ),
>;

/// Stores at sample the light that arrives at the point position (three floats) and returns RT_TRUE; or returns
/// RT_FALSE where the light does not shine. Point and answer are in the space of the light: that of the world, moved by
/// the matrix that rtUseLight() was called with. Rules as for RTshadeFunction.
pub type RTilluminateFunction = Option<
    unsafe extern "C" fn(
        params: *const c_void,
        userData: *mut c_void,
        position: *const RTfloat,
        sample: *mut RTlightSample,
    ) -> RTboolean,
>;

/// Stores at ray the ray through (x, y), both from 0 to 1 with (0, 0) the lower left of the picture, and
/// returns RT_TRUE; or returns RT_FALSE to show the clear colour there. aspect is the width of the picture
/// divided by its height. Only origin and direction of the ray are used. Rules as for RTshadeFunction.
pub type RTprimaryRayFunction = Option<
    unsafe extern "C" fn(
        params: *const c_void,
        userData: *mut c_void,
        x: RTfloat,
        y: RTfloat,
        aspect: RTfloat,
        ray: *mut RTray,
    ) -> RTboolean,
>;

/// Stores at radiance linear red, green and blue that arrive against the unit direction (three floats) from
/// outside the scene. Rules as for RTshadeFunction.
pub type RTradianceFunction = Option<
    unsafe extern "C" fn(
        params: *const c_void,
        userData: *mut c_void,
        direction: *const RTfloat,
        radiance: *mut RTfloat,
    ),
>;

/// One parameter of a shader class.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct RTshaderParam {
    /// For rtParameterHandle().
    pub name: *const c_char,
    /// RT_INT, RT_INT_VEC2 to RT_INT_VEC4, RT_FLOAT, RT_FLOAT_VEC2 to RT_FLOAT_VEC4, RT_FLOAT_MAT4, RT_TEXTURE
    /// (an RTuint in the block), RT_STRING (a const char * in the block) or RT_RAW.
    pub type_: RTenum,
    /// RT_PER_SHADER, RT_PER_TRIANGLE or RT_PER_VERTEX; the latter two for floats of surface shaders only.
    pub scope: RTenum,
    /// Where the value lies in the parameter block: offsetof() of the member of your structure.
    pub offset: RTuint,
    /// Bytes of a RT_RAW parameter; not used for others.
    pub size: RTuint,
    /// The default: as many bytes as the type has, or the text of a RT_STRING. NULL for zeros, or an empty
    /// text. Textures have none.
    pub defaultValue: *const c_void,
}

/// A shader class: what rtRegisterShaderClass() takes, and what shader libraries return. Of the four functions,
/// the one for the kind is needed and the others are NULL.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct RTshaderClass {
    /// RT_SHADER_CLASS_VERSION.
    pub version: RTuint,
    /// RT_SURFACE_SHADER, RT_LIGHT_SHADER, RT_CAMERA_SHADER or RT_ENVIRONMENT_SHADER.
    pub kind: RTenum,
    /// For messages.
    pub name: *const c_char,
    /// Bytes of the parameter block, sizeof your structure. Blocks are given aligned to 16 bytes.
    pub blockSize: RTuint,
    /// Number of params.
    pub paramCount: RTuint,
    /// The parameters; NULL if there are none.
    pub params: *const RTshaderParam,
    /// For RT_SURFACE_SHADER.
    pub shade: RTshadeFunction,
    /// For RT_LIGHT_SHADER.
    pub illuminate: RTilluminateFunction,
    /// For RT_CAMERA_SHADER.
    pub primaryRay: RTprimaryRayFunction,
    /// For RT_ENVIRONMENT_SHADER.
    pub radiance: RTradianceFunction,
    /// Handed to the functions, otherwise not touched.
    pub userData: *mut c_void,
}

/// The type of the function that a shader library exports under the name openrtQueryShaderClass. It returns the
/// class called name, valid until the process ends, or NULL if the library has no such class.
pub type RTqueryShaderClass = Option<unsafe extern "C" fn(name: *const c_char) -> *const RTshaderClass>;

/// Fails unless `version` is the one that our structures have.
pub(super) fn check_version(version: RTuint) -> Result<()> {
    if version == RT_SHADER_CLASS_VERSION {
        return Ok(());
    }
    let message = format!("the shader class has version {version}, this library has {RT_SHADER_CLASS_VERSION}");
    Err(Error::invalid_value(message))
}

/// The safe class that `class`, which is of our version, describes.
///
/// # Safety
/// Its pointers are NULL or point to what the manual says, until this returns; its functions are valid for
/// ever.
pub(super) unsafe fn class_of(class: &RTshaderClass) -> Result<ShaderClass> {
    // SAFETY: NULL or a string, by contract.
    let name = unsafe { text("the name of the class", class.name)? };
    let user_data = UserData(class.userData);
    let missing = || Error::invalid_value(format!("shader class \"{name}\" has no function for its kind"));
    let (kind, program) = match class.kind {
        RT_SURFACE_SHADER => {
            let shade = class.shade.ok_or_else(missing)?;
            (ShaderKind::Surface, Program::Surface(Arc::new(CSurface { shade, user_data })))
        }
        RT_LIGHT_SHADER => {
            let illuminate = class.illuminate.ok_or_else(missing)?;
            (ShaderKind::Light, Program::Light(Arc::new(CLight { illuminate, user_data })))
        }
        RT_CAMERA_SHADER => {
            let primary_ray = class.primaryRay.ok_or_else(missing)?;
            (ShaderKind::Camera, Program::Camera(Arc::new(CCamera { primary_ray, user_data })))
        }
        RT_ENVIRONMENT_SHADER => {
            let radiance = class.radiance.ok_or_else(missing)?;
            (ShaderKind::Environment, Program::Environment(Arc::new(CEnvironment { radiance, user_data })))
        }
        _ => return Err(unknown("kind", class.kind, "a kind of shader that an application can bring")),
    };
    check_sizes(name, class.paramCount.into(), class.blockSize)?;
    let count = RTsizei::try_from(class.paramCount)
        .map_err(|_| Error::invalid_value(format_args!("{} parameters are too many", class.paramCount)))?;
    // SAFETY: NULL or that many parameters, by contract.
    let described = unsafe { slice("params", class.params, count)? };
    let mut params = Vec::new();
    params.try_reserve_exact(described.len())?;
    let mut layout = Layout::new(class.blockSize);
    for param in described {
        // SAFETY: passed on.
        params.push(unsafe { param_of(param, name, &mut layout)? });
    }
    Ok(ShaderClass { name: name.into(), kind, params, block_size: class.blockSize, program })
}

/// # Safety
/// As [`class_of`].
unsafe fn param_of(param: &RTshaderParam, class: &str, layout: &mut Layout) -> Result<ParamDef> {
    let ty = match param.type_ {
        RT_INT => ParamType::Int(1),
        RT_INT_VEC2 => ParamType::Int(2),
        RT_INT_VEC3 => ParamType::Int(3),
        RT_INT_VEC4 => ParamType::Int(4),
        RT_FLOAT => ParamType::Float(1),
        RT_FLOAT_VEC2 => ParamType::Float(2),
        RT_FLOAT_VEC3 => ParamType::Float(3),
        RT_FLOAT_VEC4 => ParamType::Float(4),
        RT_FLOAT_MAT4 => ParamType::Matrix,
        RT_TEXTURE => ParamType::Texture,
        RT_STRING => ParamType::String,
        RT_RAW => ParamType::Raw(param.size),
        _ => return Err(unknown("type", param.type_, "a type of shader parameters")),
    };
    let scope = match param.scope {
        RT_PER_SHADER => ParamScope::Shader,
        RT_PER_TRIANGLE => ParamScope::Triangle,
        RT_PER_VERTEX => ParamScope::Vertex,
        _ => return Err(unknown("scope", param.scope, "a scope of shader parameters")),
    };
    // SAFETY: NULL or a string, by contract.
    let name = unsafe { text("the name of a parameter", param.name)? };
    // Before the default takes as much memory.
    layout
        .place(ty, param.offset)
        .map_err(|why| Error::invalid_value(format_args!("shader class \"{class}\": parameter \"{name}\": {why}")))?;
    // SAFETY: NULL or a value of the type, by contract.
    let default = unsafe { default_of(ty, param.defaultValue)? };
    Ok(ParamDef { name: name.into(), ty, scope, default, choices: &[], offset: param.offset })
}

/// The default at `p`, zeros for NULL.
///
/// # Safety
/// `p` is NULL or points to a value of type `ty`.
unsafe fn default_of(ty: ParamType, p: *const c_void) -> Result<ParamValue> {
    /// The first `n` values at `p`, followed by zeros.
    ///
    /// # Safety
    /// `p` is NULL or points to `n` values.
    unsafe fn padded<T: Copy + Default>(p: *const T, n: u8) -> Result<[T; 4]> {
        let mut out = [T::default(); 4];
        for (i, out) in out.iter_mut().enumerate().take(if p.is_null() { 0 } else { n.into() }) {
            // SAFETY: not NULL, so `n` values by contract.
            *out = unsafe { value("defaultValue", p.wrapping_add(i))? };
        }
        Ok(out)
    }
    Ok(match ty {
        // SAFETY: NULL or n integers, by contract.
        ParamType::Int(n) => ParamValue::Int(unsafe { padded(p.cast(), n)? }),
        // SAFETY: NULL or n floats, by contract.
        ParamType::Float(n) => ParamValue::Float(unsafe { padded(p.cast(), n)? }),
        ParamType::Matrix if p.is_null() => ParamValue::Matrix([0.0; 16]),
        // SAFETY: not NULL, so 16 floats by contract.
        ParamType::Matrix => ParamValue::Matrix(unsafe { array_at("defaultValue", p.cast())? }),
        ParamType::Texture => ParamValue::Texture(0),
        ParamType::String if p.is_null() => ParamValue::String("".into()),
        ParamType::String => {
            // SAFETY: not NULL, so a string by contract.
            let text = unsafe { text("defaultValue", p.cast())? };
            ParamValue::String(memory::made(text.len(), || text.into())?)
        }
        ParamType::Raw(n) => {
            let n = RTsizei::try_from(n)
                .map_err(|_| Error::invalid_value(format_args!("a parameter of {n} bytes is too large")))?;
            if p.is_null() {
                let zeros = memory::repeated(0u8, n as usize)?;
                ParamValue::Raw(memory::made(zeros.len(), || zeros.into())?)
            } else {
                // SAFETY: not NULL, so n bytes by contract.
                let bytes = unsafe { slice("defaultValue", p.cast::<u8>(), n)? };
                ParamValue::Raw(memory::made(bytes.len(), || bytes.into())?)
            }
        }
    })
}

struct CSurface {
    shade: unsafe extern "C" fn(*mut RTshadingContext, *const c_void, *mut c_void, *mut RTfloat),
    user_data: UserData,
}

impl SurfaceShader for CSurface {
    fn shade(&self, params: &[u8], context: &mut dyn ShadingContext) -> Vec4 {
        let mut result = [0.0, 0.0, 0.0, 1.0];
        RTshadingContext::lend(context, |context| {
            // SAFETY: the application gave this function for such calls; all pointers are valid until it returns.
            unsafe { (self.shade)(context, params.as_ptr().cast(), self.user_data.0, result.as_mut_ptr()) }
        });
        Vec4::from_array(result)
    }
}

struct CLight {
    illuminate: unsafe extern "C" fn(*const c_void, *mut c_void, *const RTfloat, *mut RTlightSample) -> RTboolean,
    user_data: UserData,
}

impl LightShader for CLight {
    fn illuminate(&self, params: &[u8], position: Vec3) -> Option<LightSample> {
        let mut sample = RTlightSample::default();
        let (params, position) = (params.as_ptr().cast(), position.to_array());
        // SAFETY: the application gave this function for such calls; all pointers are valid until it returns.
        let shines = unsafe { (self.illuminate)(params, self.user_data.0, position.as_ptr(), &mut sample) };
        (shines != RT_FALSE).then(|| LightSample {
            direction: sample.direction.into(),
            distance: sample.distance,
            radiance: sample.radiance.into(),
        })
    }
}

struct CCamera {
    primary_ray: unsafe extern "C" fn(*const c_void, *mut c_void, RTfloat, RTfloat, RTfloat, *mut RTray) -> RTboolean,
    user_data: UserData,
}

impl CameraShader for CCamera {
    fn primary_ray(&self, params: &[u8], screen: Vec2, aspect: f32) -> Option<PrimaryRay> {
        let mut ray = RTray { origin: [0.0; 3], tmin: 0.0, direction: [0.0; 3], tmax: RTfloat::INFINITY };
        let params = params.as_ptr().cast();
        // SAFETY: the application gave this function for such calls; all pointers are valid until it returns.
        let made = unsafe { (self.primary_ray)(params, self.user_data.0, screen.x, screen.y, aspect, &mut ray) };
        (made != RT_FALSE).then(|| PrimaryRay { origin: ray.origin.into(), direction: ray.direction.into() })
    }
}

struct CEnvironment {
    radiance: unsafe extern "C" fn(*const c_void, *mut c_void, *const RTfloat, *mut RTfloat),
    user_data: UserData,
}

impl EnvironmentShader for CEnvironment {
    fn radiance(&self, params: &[u8], direction: Vec3) -> Vec3 {
        let (mut radiance, direction) = ([0.0; 3], direction.to_array());
        let params = params.as_ptr().cast();
        // SAFETY: the application gave this function for such calls; all pointers are valid until it returns.
        unsafe { (self.radiance)(params, self.user_data.0, direction.as_ptr(), radiance.as_mut_ptr()) }
        radiance.into()
    }
}
