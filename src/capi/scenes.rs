//! Snapshots of a scene, which any thread may ask, and questions beyond the closest hit.

use super::constants::*;
use super::guard::{guard, guard_thread};
use super::pointer::{Out, array, slice, slice_mut};
use super::queries::{hit_of, hits_at, intersect, is_coherent, occlude, rays_at, truths_at};
use super::types::*;
use crate::api::{Error, Hit, Mask, Queries, Ray, Result, SceneView};
use std::ffi::c_void;

/// A snapshot of a scene; see rtAcquireScene().
pub struct RTsceneView(SceneView);

/// A snapshot of a scene, made by rtAcquireScene(). Functions that take one take NULL for the scene of the current context, as it was last
/// rendered or committed.
pub type RTscene = *mut RTsceneView;

/// Decides whether a hit counts: RT_TRUE, or RT_FALSE to let the ray go on behind it. Called on the thread that asks, with the pointer of
/// the question. It must not leave by longjmp() or by a C++ exception, nor call functions that need the context that is asked.
pub type RTfilter =
    Option<unsafe extern "C" fn(userData: *mut c_void, ray: *const RTray, hit: *const RThit) -> RTboolean>;

/// How a question is meant. With all members 0 it is that of rtSceneIntersect().
#[repr(C)]
#[derive(Clone, Copy)]
pub struct RTquery {
    /// 0 or RT_COHERENT.
    pub flags: RTbitfield,
    /// The rays meet instances that have a bit in common with this, see RT_MASK; 0 stands for RT_QUERY_RAYS.
    pub mask: RTuint,
    /// NULL, or a mask for each ray in the place of mask; here 0 meets nothing.
    pub masks: *const RTuint,
    /// NULL, or what decides which hits count. Rays are then traced one by one.
    pub filter: RTfilter,
    /// Handed to filter.
    pub userData: *mut c_void,
}

/// What lies at a hit, in world space.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RTsurface {
    /// The point itself.
    pub position: [RTfloat; 3],
    /// Unit length; to the side from which the triangle's corners run counter-clockwise, or to that of its vertices' normals if it has some.
    pub geometricNormal: [RTfloat; 3],
    /// Unit length: interpolated from the vertices' normals, else the geometric one.
    pub normal: [RTfloat; 3],
    /// Interpolated from the vertices; 0 without.
    pub texCoord: [RTfloat; 2],
    /// Linear RGBA, interpolated from the vertices; 1 without.
    pub color: [RTfloat; 4],
    /// The shader that was bound at the triangle; 0 is the default surface.
    pub shader: RTuint,
    /// RT_TRUE when the ray came from the side to which the geometric normal points.
    pub frontFacing: RTboolean,
}

/// The nearest point of a scene or an object.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RTclosestPoint {
    /// The point itself.
    pub position: [RTfloat; 3],
    /// How far away it is; negative when there is none. The other fields are then 0.
    pub distance: RTfloat,
    /// Barycentric weight of the triangle's second corner.
    pub u: RTfloat,
    /// Barycentric weight of the triangle's third corner.
    pub v: RTfloat,
    /// Number of the triangle in its object.
    pub primitive: RTuint,
    /// Name of the object.
    pub object: RTuint,
    /// Number of the instance in its frame; 0 for a question about one object.
    pub instance: RTuint,
}

/// Puts a question to a snapshot, or to the current context for NULL.
unsafe fn ask<T: super::guard::Refused>(scene: RTscene, question: impl FnOnce(&Queries<'_>) -> Result<T>) -> T {
    if scene.is_null() {
        guard(|cx| question(&cx.queries()?))
    } else {
        // SAFETY: not NULL, so a snapshot that is not released before the call has ended, says the manual.
        guard_thread(|| question(&unsafe { &*scene }.0.queries()))
    }
}

/// Takes a snapshot of the scene that was last rendered or committed. Any number of threads may ask it at a time, also ones on which no context is
/// current, without lock, memory or system call, while the context goes on: frames, commits and even rtDestroyContext() leave it as it is. Its memory is
/// shared with the context as far as nothing has changed since; what changes is copied while a snapshot holds it. Waits for a frame that is being rendered.
/// Returns NULL on an error.
///
/// Errors: RT_INVALID_OPERATION between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject(); RT_OUT_OF_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn rtAcquireScene() -> RTscene {
    guard(|cx| Ok(Box::into_raw(Box::new(RTsceneView(cx.snapshot()?)))))
}

/// Gives a snapshot back, on any thread; nobody may be asking it any more. NULL is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtReleaseScene(scene: RTscene) {
    guard_thread(|| {
        if !scene.is_null() {
            // SAFETY: not NULL, so it came from `rtAcquireScene` and is given back once, says the manual.
            drop(unsafe { Box::from_raw(scene) });
        }
        Ok(())
    })
}

/// As rtIntersectRays(), in a snapshot: on the calling thread, however many rays there are. Any thread may call it at any time. For NULL it is
/// rtIntersectRays().
///
/// Errors: RT_INVALID_VALUE when n is negative, a pointer is NULL, or flags are unknown. They are kept for the calling thread, or for the context
/// that is current on it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtSceneIntersect(
    scene: RTscene,
    n: RTsizei,
    rays: *const RTray,
    hits: *mut RThit,
    flags: RTbitfield,
) {
    if scene.is_null() {
        // SAFETY: the same promises.
        return guard(|cx| unsafe { intersect(cx, n, rays, hits, flags) });
    }
    guard_thread(|| {
        is_coherent(flags)?;
        // SAFETY: `rays` is NULL or points to n rays, says the manual, and `hits` is NULL or a place for n hits elsewhere.
        let (rays, hits) = unsafe { (rays_at(rays, n)?, hits_at(hits, n)?) };
        // SAFETY: not NULL, so a snapshot that is not released before the call has ended, says the manual.
        unsafe { &*scene }.0.intersect_into(rays, hits);
        Ok(())
    })
}

/// As rtOccludedRays(), in a snapshot; otherwise as rtSceneIntersect().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtSceneOccluded(
    scene: RTscene,
    n: RTsizei,
    rays: *const RTray,
    occluded: *mut RTubyte,
    flags: RTbitfield,
) {
    if scene.is_null() {
        // SAFETY: the same promises.
        return guard(|cx| unsafe { occlude(cx, n, rays, occluded, flags) });
    }
    guard_thread(|| {
        is_coherent(flags)?;
        // SAFETY: `rays` is NULL or points to n rays, says the manual, and `occluded` is NULL or a place for n bytes elsewhere.
        let (rays, occluded) = unsafe { (rays_at(rays, n)?, truths_at(occluded, n)?) };
        // SAFETY: not NULL, so a snapshot that is not released before the call has ended, says the manual.
        unsafe { &*scene }.0.occluded_into(rays, occluded);
        Ok(())
    })
}

/// What an `RTquery` says, checked.
struct Question<'a> {
    mask: Mask,
    masks: Option<&'a [RTuint]>,
    filter: Option<Filter>,
}

struct Filter {
    function: unsafe extern "C" fn(*mut c_void, *const RTray, *const RThit) -> RTboolean,
    user_data: *mut c_void,
}

impl<'a> Question<'a> {
    /// # Safety
    /// `query` is NULL or points to an `RTquery`, whose masks, if any, are `n` and stay unchanged for `'a`.
    unsafe fn read(query: *const RTquery, n: RTsizei) -> Result<Self> {
        if query.is_null() {
            return Ok(Self { mask: Mask::QUERY, masks: None, filter: None });
        }
        // SAFETY: not NULL, so an `RTquery` by contract.
        let RTquery { flags, mask, masks, filter, userData } = unsafe { query.read_unaligned() };
        is_coherent(flags)?;
        let mask = if mask == 0 { Mask::QUERY } else { Mask(mask) };
        // SAFETY: not NULL, so n masks by contract.
        let masks = if masks.is_null() { None } else { Some(unsafe { slice("masks", masks, n)? }) };
        let filter = filter.map(|function| Filter { function, user_data: userData });
        Ok(Self { mask, masks, filter })
    }

    fn mask(&self, ray: usize) -> Mask {
        self.masks.map_or(self.mask, |masks| Mask(masks[ray]))
    }

    fn counts(&self, ray: &Ray, hit: &Hit) -> bool {
        self.filter.as_ref().is_none_or(|filter| {
            let hit = hit_of(*hit);
            // SAFETY: the application gave the function for such calls; both arguments live until it returns.
            unsafe { (filter.function)(filter.user_data, std::ptr::from_ref(ray).cast(), &raw const hit) != RT_FALSE }
        })
    }
}

/// As rtSceneIntersect(), by the masks and the filter of query (NULL for none of them): stores at hits, for each of the n rays at rays, the first hit that counts.
///
/// Errors: as rtSceneIntersect(). RT_INVALID_OPERATION for the scene NULL between rtBegin() and rtEnd(), or between rtNewObject() and rtEndObject().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtSceneQuery(
    scene: RTscene,
    n: RTsizei,
    rays: *const RTray,
    hits: *mut RThit,
    query: *const RTquery,
) {
    let question = |queries: &Queries<'_>| {
        // SAFETY: `query` is NULL or as the manual says, with a mask for each of n rays if any.
        let question = unsafe { Question::read(query, n)? };
        // SAFETY: `rays` is NULL or points to n rays, says the manual, and `hits` is NULL or a place for n hits elsewhere.
        let (rays, hits) = unsafe { (rays_at(rays, n)?, hits_at(hits, n)?) };
        if question.filter.is_some() {
            for (i, (ray, to)) in rays.iter().zip(hits).enumerate() {
                *to = Hit::MISS;
                queries.masked(question.mask(i)).each_hit(ray, |hit| {
                    let counts = question.counts(ray, hit);
                    if counts {
                        *to = *hit;
                    }
                    !counts
                });
            }
            return Ok(());
        }
        // Runs of one mask go together.
        let mut first = 0;
        while first < rays.len() {
            let mask = question.mask(first);
            let run = first..(first..rays.len()).find(|&i| question.mask(i) != mask).unwrap_or(rays.len());
            queries.masked(mask).intersect_into(&rays[run.clone()], &mut hits[run.clone()]);
            first = run.end;
        }
        Ok(())
    };
    // SAFETY: the manual's promise about `scene`.
    unsafe { ask(scene, question) }
}

/// Stores at hits the first max hits of a ray that count by query (NULL: all), sorted by distance, hits at the same distance by instance and primitive. Returns
/// how many it has stored. Each costs the search for a closest hit.
///
/// Errors: as rtSceneQuery().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtSceneAllHits(
    scene: RTscene,
    ray: *const RTray,
    max: RTsizei,
    hits: *mut RThit,
    query: *const RTquery,
) -> RTsizei {
    let question = |queries: &Queries<'_>| {
        // SAFETY: as the manual says, each is NULL or points to what its type tells; `hits` to max places elsewhere.
        let (question, ray, hits) = unsafe { (Question::read(query, 1)?, rays_at(ray, 1)?, hits_at(hits, max)?) };
        let (ray, mut count) = (&ray[0], 0);
        if hits.is_empty() {
            return Ok(0);
        }
        queries.masked(question.mask(0)).each_hit(ray, |hit| {
            if question.counts(ray, hit) {
                hits[count] = *hit;
                count += 1;
            }
            count < hits.len()
        });
        Ok(count as RTsizei)
    };
    // SAFETY: the manual's promise about `scene`.
    unsafe { ask(scene, question) }
}

/// Stores at surfaces what lies at the n hits at hits, which the rays at rays have made in the same scene. Where nothing was hit all members are 0.
///
/// Errors: RT_INVALID_VALUE when n is negative, a pointer is NULL, or a hit is none of this scene (then nothing is stored from there on); else as
/// rtSceneQuery().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtSceneSurfaces(
    scene: RTscene,
    n: RTsizei,
    rays: *const RTray,
    hits: *const RThit,
    surfaces: *mut RTsurface,
) {
    let question = |queries: &Queries<'_>| {
        // SAFETY: as the manual says, each is NULL or points to n of what its type tells.
        let (rays, hits, to) =
            unsafe { (rays_at(rays, n)?, slice("hits", hits.cast::<Hit>(), n)?, slice_mut("surfaces", surfaces, n)?) };
        for (i, ((ray, hit), to)) in rays.iter().zip(hits).zip(to).enumerate() {
            if hit.is_miss() {
                *to = RTsurface::default();
                continue;
            }
            let none = || {
                let Hit { primitive: prim, object, instance, .. } = *hit;
                let what =
                    format!("hit {i} is none of this scene: instance {instance}, object {object}, primitive {prim}");
                Error::invalid_value(what)
            };
            let surface = queries.surface(ray, hit).ok_or_else(none)?;
            *to = RTsurface {
                position: surface.position.into(),
                geometricNormal: surface.geometric_normal.into(),
                normal: surface.normal.into(),
                texCoord: surface.tex_coord.into(),
                color: surface.color.into(),
                shader: surface.shader,
                frontFacing: surface.front_facing.into(),
            };
        }
        Ok(())
    };
    // SAFETY: the manual's promise about `scene`.
    unsafe { ask(scene, question) }
}

/// Stores at closest the point that is nearest to the three numbers at point and no farther away than maxDistance (INFINITY for no limit), and returns whether there is
/// one. object 0 asks for the whole scene, in world space, among instances that have a bit of RT_QUERY_RAYS; the name of an object that the scene shows asks
/// for that object, in its own space. The first question after an object has changed sorts its triangles, on the calling thread.
///
/// Errors: RT_INVALID_VALUE when a pointer is NULL, a number is not finite, maxDistance is negative, or the scene does not show the object; else as
/// rtSceneQuery().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rtSceneClosestPoint(
    scene: RTscene,
    object: RTuint,
    point: *const RTfloat,
    maxDistance: RTfloat,
    closest: *mut RTclosestPoint,
) -> RTboolean {
    // SAFETY: `closest` is NULL or a place for an answer, says the manual.
    let out = unsafe { Out::new("closest", closest) };
    let question = |queries: &Queries<'_>| {
        // SAFETY: `point` is NULL or points to three numbers, says the manual.
        let point = unsafe { array::<RTfloat, 3>(point)? };
        let out = out.check()?;
        if !(point.iter().all(|x| x.is_finite()) && maxDistance >= 0.0) {
            return Err(Error::invalid_value(format!(
                "the point {point:?} is not finite, or the distance {maxDistance} is negative"
            )));
        }
        let found = if object == 0 {
            queries.closest_point(point.into(), maxDistance)
        } else if queries.shows(object) {
            queries.closest_point_on(object, point.into(), maxDistance)
        } else {
            return Err(Error::invalid_value(format!("the scene shows no object {object}")));
        };
        out.set(match found {
            Some(c) => RTclosestPoint {
                position: c.position.into(),
                distance: c.distance,
                u: c.u,
                v: c.v,
                primitive: c.primitive,
                object: c.object,
                instance: c.instance,
            },
            None => RTclosestPoint { distance: -1.0, ..RTclosestPoint::default() },
        });
        Ok(RTboolean::from(found.is_some()))
    };
    // SAFETY: the manual's promise about `scene`.
    unsafe { ask(scene, question) }
}
