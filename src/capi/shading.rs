//! What a shader written in C may ask while it runs: the `rts` functions.
//!
//! They run on threads of the pool, on which no context is current; so they record no errors. A bad argument
//! gives 0. A panic must not cross the C shader: it is kept in the context and goes on when the shader has
//! returned.

use super::constants::RT_FALSE;
use super::pointer::{Out, OutArray, array_at};
use super::shader_class::{RTlightSample, RTsurfacePoint};
use super::types::*;
use crate::api::ShadingContext;
use glam::{Vec2, Vec3};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// What the rts functions work on: the point being shaded and the frame around it. Valid while the shader
/// function runs, and only on its thread.
pub struct RTshadingContext {
    /// Valid while `lend` runs, which is while anybody has the address of this structure.
    inner: *mut (dyn ShadingContext + 'static),
    panic: Option<Box<dyn Any + Send>>,
}

impl RTshadingContext {
    /// Calls `run` with the address of a context that stands for `inner`.
    pub(super) fn lend(inner: &mut dyn ShadingContext, run: impl FnOnce(*mut Self)) {
        let inner: *mut (dyn ShadingContext + '_) = inner;
        // SAFETY: the two pointer types differ only in the lifetime bound of the trait object. The pointer is used only in `ask`, under the
        // contract that the shader function has not returned, that is, while `inner` is borrowed here.
        let inner: *mut (dyn ShadingContext + 'static) = unsafe { std::mem::transmute(inner) };
        let mut context = Self { inner, panic: None };
        run(&mut context);
        if let Some(payload) = context.panic {
            resume_unwind(payload);
        }
    }
}

/// Runs `question` on the context; `otherwise` for NULL, and after a panic.
///
/// # Safety
/// `context` is NULL or the argument of a shader function that has not returned, on its thread, and no `ask` is
/// running on it.
unsafe fn ask<T>(
    context: *mut RTshadingContext,
    otherwise: T,
    question: impl FnOnce(&mut dyn ShadingContext) -> T,
) -> T {
    if context.is_null() {
        return otherwise;
    }
    // SAFETY: not NULL, so the context of a shader that has not returned, on which nobody else works.
    let context = unsafe { &mut *context };
    if context.panic.is_some() {
        return otherwise;
    }
    // SAFETY: `lend` borrows what this points to until the shader function returns.
    let inner = unsafe { &mut *context.inner };
    match catch_unwind(AssertUnwindSafe(|| question(inner))) {
        Ok(answer) => answer,
        Err(payload) => {
            context.panic = Some(payload);
            otherwise
        }
    }
}

/// For shaders: stores what is known of the point being shaded at point.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtsGetPoint(context: *mut RTshadingContext, point: *mut RTsurfacePoint) {
    // SAFETY: `point` is NULL or a place for a point, says the manual.
    let out = unsafe { Out::new("point", point) };
    // SAFETY: the manual asks for the shader function's own context.
    unsafe {
        ask(context, (), |cx| {
            let p = cx.point();
            out.set(RTsurfacePoint {
                position: p.position.into(),
                normal: p.normal.into(),
                geometricNormal: p.geometric_normal.into(),
                incoming: p.incoming.into(),
                texCoord: p.tex_coord.into(),
                color: p.color.into(),
                barycentric: p.barycentric.into(),
                distance: p.distance,
                object: p.object,
                instance: p.instance,
                primitive: p.primitive,
                depth: p.depth,
                backFacing: p.back_facing.into(),
            });
        })
    }
}

/// For shaders: number of lights in the frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtsLightCount(context: *mut RTshadingContext) -> RTuint {
    // SAFETY: the manual asks for the shader function's own context.
    unsafe { ask(context, 0, |cx| cx.light_count()) }
}

/// For shaders: stores at sample the light that comes from light index to the point, as if nothing were in the
/// way (see rtsShadowed()), and returns RT_TRUE; or returns RT_FALSE when there is no such light or it does not
/// shine there. For a light with an area, each call may choose another point on it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtsIlluminate(
    context: *mut RTshadingContext,
    index: RTuint,
    sample: *mut RTlightSample,
) -> RTboolean {
    // SAFETY: `sample` is NULL or a place for a sample, says the manual.
    let out = unsafe { Out::new("sample", sample) };
    // SAFETY: the manual asks for the shader function's own context.
    unsafe {
        ask(context, RT_FALSE, |cx| {
            let Some(light) = cx.illuminate(index) else { return RT_FALSE };
            out.set(RTlightSample {
                direction: light.direction.into(),
                distance: light.distance,
                radiance: light.radiance.into(),
            });
            true.into()
        })
    }
}

/// For shaders: RT_TRUE when something opaque is between the point and the place at distance (in units of its
/// length, INFINITY for none) along direction (three floats).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtsShadowed(
    context: *mut RTshadingContext,
    direction: *const RTfloat,
    distance: RTfloat,
) -> RTboolean {
    // SAFETY: `direction` is NULL or three floats, says the manual.
    let Ok(direction) = (unsafe { array_at("direction", direction) }) else { return RT_FALSE };
    // SAFETY: the manual asks for the shader function's own context.
    unsafe { ask(context, RT_FALSE, |cx| cx.shadowed(Vec3::from_array(direction), distance).into()) }
}

/// For shaders: stores at radiance (three floats) the light that comes to the point from direction (three
/// floats), by tracing a ray. Black beyond the limit of recursion.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtsTrace(context: *mut RTshadingContext, direction: *const RTfloat, radiance: *mut RTfloat) {
    // SAFETY: `direction` is NULL or three floats, says the manual.
    let direction = unsafe { array_at("direction", direction) };
    // SAFETY: `radiance` is NULL or a place for three floats, says the manual.
    let out = unsafe { OutArray::new(radiance) };
    let light = match direction {
        // SAFETY: the manual asks for the shader function's own context.
        Ok(direction) => unsafe { ask(context, Vec3::ZERO, |cx| cx.trace(Vec3::from_array(direction))) },
        Err(_) => Vec3::ZERO,
    };
    // NULL is nobody's error here: see the head of this file.
    let _ = out.set(&light.to_array());
}

/// For shaders: stores at direction (three floats) the unit direction in which the interpolated normal mirrors
/// the ray.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtsReflect(context: *mut RTshadingContext, direction: *mut RTfloat) {
    // SAFETY: `direction` is NULL or a place for three floats, says the manual.
    let out = unsafe { OutArray::new(direction) };
    // SAFETY: the manual asks for the shader function's own context.
    let mirrored = unsafe {
        ask(context, Vec3::ZERO, |cx| {
            let p = cx.point();
            p.incoming - 2.0 * p.incoming.dot(p.normal) * p.normal
        })
    };
    let _ = out.set(&mirrored.to_array());
}

/// For shaders: stores at rgba (four floats) the colour of a texture at (s, t), filtered as the texture asks;
/// white when there is no such texture.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtsTexture(
    context: *mut RTshadingContext,
    texture: RTuint,
    s: RTfloat,
    t: RTfloat,
    rgba: *mut RTfloat,
) {
    // SAFETY: `rgba` is NULL or a place for four floats, says the manual.
    let out = unsafe { OutArray::new(rgba) };
    // SAFETY: the manual asks for the shader function's own context.
    let color = unsafe { ask(context, glam::Vec4::ONE, |cx| cx.texture(texture, Vec2::new(s, t))) };
    let _ = out.set(&color.to_array());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::{LightSample, SurfacePoint};
    use glam::Vec4;

    /// Answers nothing but a ray that goes up, and breaks on one that goes down.
    struct Fragile(SurfacePoint);

    impl ShadingContext for Fragile {
        fn point(&self) -> &SurfacePoint {
            &self.0
        }
        fn light_count(&self) -> u32 {
            3
        }
        fn illuminate(&mut self, _: u32) -> Option<LightSample> {
            None
        }
        fn shadowed(&mut self, _: Vec3, _: f32) -> bool {
            false
        }
        fn trace(&mut self, direction: Vec3) -> Vec3 {
            assert!(direction.y > 0.0, "a defect under the shader");
            Vec3::ONE
        }
        fn texture(&self, _: u32, _: Vec2) -> Vec4 {
            Vec4::ONE
        }
    }

    fn fragile() -> Fragile {
        Fragile(SurfacePoint {
            position: Vec3::ZERO,
            geometric_normal: Vec3::Y,
            normal: Vec3::Y,
            incoming: Vec3::NEG_Y,
            tex_coord: Vec2::ZERO,
            color: Vec4::ONE,
            barycentric: Vec2::ZERO,
            distance: 1.0,
            object: 1,
            instance: 0,
            primitive: 0,
            back_facing: false,
            depth: 0,
        })
    }

    /// What a shader in C would do: three questions, the second of which meets a defect.
    fn shader(context: *mut RTshadingContext, lights_after: &mut u32) {
        let (mut up, mut down) = ([9.0; 3], [9.0; 3]);
        // SAFETY: the context of `lend`, which has not returned; vectors of three floats.
        unsafe {
            rtsTrace(context, [0.0, 1.0, 0.0].as_ptr(), up.as_mut_ptr());
            rtsTrace(context, [0.0, -1.0, 0.0].as_ptr(), down.as_mut_ptr());
            *lights_after = rtsLightCount(context);
        }
        assert_eq!((up, down), ([1.0; 3], [0.0; 3]));
    }

    #[test]
    fn a_defect_passes_the_shader_and_goes_on_behind_it() {
        let mut lights_after = 9;
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            RTshadingContext::lend(&mut fragile(), |context| shader(context, &mut lights_after));
        }));
        assert_eq!(lights_after, 0, "the shader went on, and was told nothing more");
        let payload = outcome.expect_err("the panic goes on");
        assert_eq!(payload.downcast_ref::<&str>(), Some(&"a defect under the shader"));
    }
}
