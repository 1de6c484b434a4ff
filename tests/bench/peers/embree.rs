//! The peer: Embree 3, loaded at run time, through as much of its C interface as the bench needs.
//!
//! Constants and layouts are facts of its headers (version 3.13). Ray packets of any width are structures of arrays of 32-bit words:
//! 12 rows for a ray, 8 more for its hit; a single ray is a packet of width 1.

use crate::scenes::BenchScene;
use glam::{Affine3A, Vec3};
use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::sync::atomic::{AtomicIsize, Ordering};

pub type Handle = *mut c_void;

/// `RTCBuildQuality`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum Quality {
    Low = 0,
    Medium = 1,
    High = 2,
    Refit = 3,
}

const GEOMETRY_TRIANGLE: c_int = 0;
const GEOMETRY_INSTANCE: c_int = 121;
const BUFFER_INDEX: c_int = 0;
const BUFFER_VERTEX: c_int = 1;
const FORMAT_UINT3: c_int = 0x5003;
const FORMAT_FLOAT3: c_int = 0x9003;
const FORMAT_FLOAT3X4_COLUMN_MAJOR: c_int = 0x9234;
pub const SCENE_DYNAMIC: c_int = 1;
pub const SCENE_ROBUST: c_int = 4;
const PROPERTY_VERSION: c_int = 0;
const PROPERTY_NATIVE_RAY16: c_int = 34;
pub const NO_GEOMETRY: u32 = u32::MAX;

/// `RTCIntersectContext`.
#[repr(C)]
pub struct Context {
    flags: c_int,
    filter: *const c_void,
    instance: c_uint,
}

impl Context {
    pub fn new(coherent: bool) -> Self {
        Self { flags: c_int::from(coherent), filter: std::ptr::null(), instance: NO_GEOMETRY }
    }
}

type One = unsafe extern "C" fn(Handle, *mut Context, *mut u32);
type Packet = unsafe extern "C" fn(*const c_int, Handle, *mut Context, *mut u32);
type Stream = unsafe extern "C" fn(Handle, *mut Context, *mut u32, c_uint, usize);
type MemoryMonitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;

/// Declares the table of functions and how it is filled.
macro_rules! functions {
    ($($field:ident = $symbol:literal: $kind:ty;)*) => {
        /// The functions of the library, which stays loaded to the end of the process.
        #[derive(Clone, Copy)]
        pub struct Embree { $(pub $field: $kind,)* }

        impl Embree {
            fn resolve(library: *mut c_void) -> Result<Self, String> {
                Ok(Self { $($field: {
                    let name = CString::new($symbol).expect("no zero in a name");
                    // SAFETY: a valid library and a valid name.
                    let address = unsafe { libc::dlsym(library, name.as_ptr()) };
                    if address.is_null() {
                        return Err(format!("libembree3 has no function {}", $symbol));
                    }
                    // SAFETY: Embree 3's header declares this symbol with this signature.
                    unsafe { std::mem::transmute::<*mut c_void, $kind>(address) }
                },)* })
            }
        }
    };
}

functions! {
    new_device = "rtcNewDevice": unsafe extern "C" fn(*const c_char) -> Handle;
    release_device = "rtcReleaseDevice": unsafe extern "C" fn(Handle);
    device_property = "rtcGetDeviceProperty": unsafe extern "C" fn(Handle, c_int) -> isize;
    device_error = "rtcGetDeviceError": unsafe extern "C" fn(Handle) -> c_int;
    set_memory_monitor = "rtcSetDeviceMemoryMonitorFunction": unsafe extern "C" fn(Handle, MemoryMonitor, *mut c_void);
    new_scene = "rtcNewScene": unsafe extern "C" fn(Handle) -> Handle;
    release_scene = "rtcReleaseScene": unsafe extern "C" fn(Handle);
    scene_quality = "rtcSetSceneBuildQuality": unsafe extern "C" fn(Handle, Quality);
    scene_flags = "rtcSetSceneFlags": unsafe extern "C" fn(Handle, c_int);
    commit_scene = "rtcCommitScene": unsafe extern "C" fn(Handle);
    new_geometry = "rtcNewGeometry": unsafe extern "C" fn(Handle, c_int) -> Handle;
    release_geometry = "rtcReleaseGeometry": unsafe extern "C" fn(Handle);
    commit_geometry = "rtcCommitGeometry": unsafe extern "C" fn(Handle);
    geometry_quality = "rtcSetGeometryBuildQuality": unsafe extern "C" fn(Handle, Quality);
    new_buffer = "rtcSetNewGeometryBuffer": unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void;
    buffer_data = "rtcGetGeometryBufferData": unsafe extern "C" fn(Handle, c_int, c_uint) -> *mut c_void;
    update_buffer = "rtcUpdateGeometryBuffer": unsafe extern "C" fn(Handle, c_int, c_uint);
    attach = "rtcAttachGeometry": unsafe extern "C" fn(Handle, Handle) -> c_uint;
    set_instanced = "rtcSetGeometryInstancedScene": unsafe extern "C" fn(Handle, Handle);
    set_transform = "rtcSetGeometryTransform": unsafe extern "C" fn(Handle, c_uint, c_int, *const f32);
    intersect1 = "rtcIntersect1": One;
    intersect8 = "rtcIntersect8": Packet;
    intersect16 = "rtcIntersect16": Packet;
    intersect_stream = "rtcIntersect1M": Stream;
    occluded1 = "rtcOccluded1": One;
    occluded8 = "rtcOccluded8": Packet;
    occluded16 = "rtcOccluded16": Packet;
    occluded_stream = "rtcOccluded1M": Stream;
}

impl Embree {
    /// Finds the library.
    ///
    /// # Errors
    /// The reason, in words, for which there is none.
    pub fn load() -> Result<Embree, String> {
        for name in [c"libembree3.so.3", c"libembree3.so"] {
            // SAFETY: a valid name; the library's initialisers are trusted as those of any linked one.
            let library = unsafe { libc::dlopen(name.as_ptr(), libc::RTLD_NOW | libc::RTLD_LOCAL) };
            if !library.is_null() {
                return Embree::resolve(library);
            }
        }
        // SAFETY: dlopen has just failed, so there is a text, valid until the next call.
        let text = unsafe { CStr::from_ptr(libc::dlerror()) };
        Err(format!("Embree 3 is not installed ({})", text.to_string_lossy()))
    }

    /// A device whose builders use so many threads.
    pub fn device(&self, threads: usize) -> Device<'_> {
        let config = CString::new(format!("threads={threads}")).expect("no zero");
        // SAFETY: a valid configuration string.
        let handle = unsafe { (self.new_device)(config.as_ptr()) };
        assert!(!handle.is_null(), "Embree gives a device");
        // SAFETY: the device is new, and the function lives as long as the process.
        unsafe { (self.set_memory_monitor)(handle, count_memory, std::ptr::null_mut()) };
        Device { embree: self, handle }
    }
}

/// Bytes that the devices of this process hold, as they report it.
static HELD: AtomicIsize = AtomicIsize::new(0);

unsafe extern "C" fn count_memory(_: *mut c_void, bytes: isize, _: bool) -> bool {
    HELD.fetch_add(bytes, Ordering::Relaxed);
    true
}

/// An Embree device.
pub struct Device<'a> {
    pub embree: &'a Embree,
    pub handle: Handle,
}

impl Device<'_> {
    /// As 31305 for 3.13.5.
    pub fn version(&self) -> isize {
        // SAFETY: the device lives.
        unsafe { (self.embree.device_property)(self.handle, PROPERTY_VERSION) }
    }

    /// Whether packets of 16 are traced as such on this processor.
    pub fn has_16(&self) -> bool {
        // SAFETY: the device lives.
        unsafe { (self.embree.device_property)(self.handle, PROPERTY_NATIVE_RAY16) != 0 }
    }

    /// Bytes that all devices hold now, buffers of geometries included.
    pub fn bytes_held() -> isize {
        HELD.load(Ordering::Relaxed)
    }

    /// Panics with what went wrong since the last call, if anything.
    pub fn check(&self) {
        // SAFETY: the device lives.
        let error = unsafe { (self.embree.device_error)(self.handle) };
        assert_eq!(error, 0, "Embree reports an error (RTCError)");
    }

    /// An empty scene.
    pub fn scene(&self, quality: Quality, flags: c_int) -> PeerScene<'_> {
        // SAFETY: the device lives, and the scene is new.
        let handle = unsafe {
            let handle = (self.embree.new_scene)(self.handle);
            (self.embree.scene_quality)(handle, quality);
            (self.embree.scene_flags)(handle, flags);
            handle
        };
        PeerScene { device: self, handle, geometries: Vec::new(), marked: Vec::new() }
    }

    /// A whole scene of the bench: parts straight in the scene, or instances of a scene per part. `flags` go to every level.
    pub fn build(&self, bench: &BenchScene, frame: u32, quality: Quality, flags: c_int) -> Built<'_> {
        let part = |scene: &mut PeerScene, i: usize| {
            let part = &bench.parts[i];
            scene.add_mesh(&(part.positions)(frame), &part.triangles, quality);
        };
        let built = if bench.instanced {
            let parts: Vec<PeerScene> = (0..bench.parts.len())
                .map(|i| {
                    let mut scene = self.scene(quality, flags);
                    part(&mut scene, i);
                    scene.commit();
                    scene
                })
                .collect();
            let mut top = self.scene(Quality::Medium, flags);
            for placement in (bench.place)(frame) {
                top.add_instance(&parts[placement.part], &placement.transform);
            }
            top.commit();
            Built { top, _parts: parts }
        } else {
            let mut top = self.scene(quality, flags);
            (0..bench.parts.len()).for_each(|i| part(&mut top, i));
            top.commit();
            Built { top, _parts: Vec::new() }
        };
        self.check();
        built
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        // SAFETY: scenes borrow the device, so none is left.
        unsafe { (self.embree.release_device)(self.handle) };
    }
}

/// A committed scene with the scenes that it has instances of.
pub struct Built<'a> {
    pub top: PeerScene<'a>,
    _parts: Vec<PeerScene<'a>>,
}

impl<'a> Built<'a> {
    /// A scene without instances.
    pub fn plain(top: PeerScene<'a>) -> Self {
        Built { top, _parts: Vec::new() }
    }
}

/// An Embree scene and its geometries.
pub struct PeerScene<'a> {
    device: &'a Device<'a>,
    pub handle: Handle,
    /// With their numbers of vertices; 0 for instances.
    geometries: Vec<(Handle, usize)>,
    /// Meshes that have other vertices since the last commit.
    marked: Vec<usize>,
}

// SAFETY: Embree's queries on a committed scene may be made by any number of threads; the bench changes scenes
// only through `&mut`.
unsafe impl Sync for PeerScene<'_> {}

impl PeerScene<'_> {
    fn embree(&self) -> &Embree {
        self.device.embree
    }

    /// Attaches a triangle mesh with copies of its buffers.
    pub fn add_mesh(&mut self, positions: &[Vec3], triangles: &[[u32; 3]], quality: Quality) {
        let embree = self.embree();
        // SAFETY: the device lives; Embree allocates both buffers for as many items as are then written, and pads the last vertex.
        unsafe {
            let geometry = (embree.new_geometry)(self.device.handle, GEOMETRY_TRIANGLE);
            (embree.geometry_quality)(geometry, quality);
            let to = (embree.new_buffer)(geometry, BUFFER_VERTEX, 0, FORMAT_FLOAT3, 12, positions.len());
            std::ptr::copy_nonoverlapping(positions.as_ptr().cast::<f32>(), to.cast(), positions.len() * 3);
            let to = (embree.new_buffer)(geometry, BUFFER_INDEX, 0, FORMAT_UINT3, 12, triangles.len());
            std::ptr::copy_nonoverlapping(triangles.as_ptr().cast::<u32>(), to.cast(), triangles.len() * 3);
            (embree.commit_geometry)(geometry);
            (embree.attach)(self.handle, geometry);
            self.geometries.push((geometry, positions.len()));
        }
    }

    /// Writes other positions into a mesh's buffer.
    pub fn move_mesh(&mut self, number: usize, positions: &[Vec3]) {
        let embree = self.embree();
        // SAFETY: a mesh of this scene; its buffer was made for as many vertices (checked), and nobody traces meanwhile.
        unsafe {
            let to = (embree.buffer_data)(self.geometries[number].0, BUFFER_VERTEX, 0);
            assert_eq!(self.geometries[number].1, positions.len(), "the topology stays");
            std::ptr::copy_nonoverlapping(positions.as_ptr().cast::<f32>(), to.cast(), positions.len() * 3);
        }
    }

    /// Tells Embree that the vertices of a mesh have moved.
    pub fn touch_mesh(&mut self, number: usize) {
        let embree = self.embree();
        // SAFETY: a mesh of this scene with a vertex buffer.
        unsafe {
            (embree.update_buffer)(self.geometries[number].0, BUFFER_VERTEX, 0);
            (embree.commit_geometry)(self.geometries[number].0);
        }
    }

    /// Remembers that the vertices of a mesh have moved, for [`PeerScene::commit_moved`].
    pub fn mark_mesh(&mut self, number: usize) {
        self.marked.push(number);
    }

    /// Tells Embree which meshes have moved, and brings the scene up to date.
    pub fn commit_moved(&mut self) {
        for number in std::mem::take(&mut self.marked) {
            self.touch_mesh(number);
        }
        self.commit();
    }

    /// Attaches an instance of a committed scene.
    pub fn add_instance(&mut self, of: &PeerScene, transform: &Affine3A) {
        let embree = self.embree();
        // SAFETY: both scenes live, `of` as long as the instance is used.
        unsafe {
            let geometry = (embree.new_geometry)(self.device.handle, GEOMETRY_INSTANCE);
            (embree.set_instanced)(geometry, of.handle);
            (embree.attach)(self.handle, geometry);
            self.geometries.push((geometry, 0));
        }
        self.move_instance(self.geometries.len() - 1, transform);
    }

    /// Gives an instance another matrix.
    pub fn move_instance(&mut self, number: usize, transform: &Affine3A) {
        let columns = transform.to_cols_array();
        let geometry = self.geometries[number].0;
        // SAFETY: an instance of this scene; 12 floats in columns.
        unsafe {
            (self.embree().set_transform)(geometry, 0, FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.as_ptr());
            (self.embree().commit_geometry)(geometry);
        }
    }

    /// Builds, or brings up to date.
    pub fn commit(&mut self) {
        // SAFETY: the scene lives.
        unsafe { (self.embree().commit_scene)(self.handle) };
    }
}

impl Drop for PeerScene<'_> {
    fn drop(&mut self) {
        // SAFETY: own references are given back once.
        unsafe {
            for &(geometry, _) in &self.geometries {
                (self.embree().release_geometry)(geometry);
            }
            (self.embree().release_scene)(self.handle);
        }
    }
}
