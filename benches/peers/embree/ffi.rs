//! The few functions and structures of Embree 3's C interface that the benchmark needs, looked up at run time.

use bvh_lab::geom::Ray;
use glam::Vec3;
use libloading::Library;
use std::ffi::{CString, c_char, c_int, c_uint, c_void};

/// Names under which the library is looked for.
const NAMES: [&str; 4] = ["libembree3.so.3", "libembree3.so", "libembree3.dylib", "embree3.dll"];
/// `RTC_GEOMETRY_TYPE_TRIANGLE`, `RTC_BUFFER_TYPE_INDEX`, `RTC_BUFFER_TYPE_VERTEX`, `RTC_FORMAT_UINT3`, `RTC_FORMAT_FLOAT3`.
const TRIANGLE: c_int = 0;
const INDEX: c_int = 0;
const VERTEX: c_int = 1;
const UINT3: c_int = 0x5003;
const FLOAT3: c_int = 0x9003;
/// `RTC_DEVICE_PROPERTY_VERSION_MAJOR` and the two after it.
const VERSION: [c_int; 3] = [1, 2, 3];

/// `RTCBuildQuality`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub enum Quality {
    /// Morton codes.
    Low = 0,
    /// Binned SAH.
    Medium = 1,
    /// Spatial splits.
    High = 2,
}

/// `RTCBuildPrimitive`.
#[repr(C, align(32))]
pub struct BuildPrimitive {
    pub lower: Vec3,
    pub geometry: u32,
    pub upper: Vec3,
    pub id: u32,
}

/// `RTCBounds`.
#[repr(C, align(16))]
pub struct Bounds {
    pub lower: Vec3,
    align0: f32,
    pub upper: Vec3,
    align1: f32,
}

/// `RTCBuildArguments`.
#[repr(C)]
pub struct BuildArguments {
    pub byte_size: usize,
    pub quality: Quality,
    pub flags: c_int,
    pub max_branching: c_uint,
    pub max_depth: c_uint,
    pub block_size: c_uint,
    pub min_leaf: c_uint,
    pub max_leaf: c_uint,
    pub traversal_cost: f32,
    pub intersection_cost: f32,
    pub bvh: *mut c_void,
    pub primitives: *mut BuildPrimitive,
    pub count: usize,
    pub capacity: usize,
    pub create_node: Option<unsafe extern "C" fn(*mut c_void, c_uint, *mut c_void) -> *mut c_void>,
    pub set_children: Option<unsafe extern "C" fn(*mut c_void, *mut *mut c_void, c_uint, *mut c_void)>,
    pub set_bounds: Option<unsafe extern "C" fn(*mut c_void, *const *const Bounds, c_uint, *mut c_void)>,
    pub create_leaf:
        Option<unsafe extern "C" fn(*mut c_void, *const BuildPrimitive, usize, *mut c_void) -> *mut c_void>,
    pub split: Option<unsafe extern "C" fn(*const BuildPrimitive, c_uint, f32, *mut Bounds, *mut Bounds, *mut c_void)>,
    pub progress: Option<unsafe extern "C" fn(*mut c_void, f64) -> bool>,
    pub user: *mut c_void,
}

/// `RTCHit`.
#[repr(C, align(16))]
pub struct Hit {
    normal: Vec3,
    u: f32,
    v: f32,
    pub primitive: u32,
    pub geometry: u32,
    instance: [u32; 1],
}

impl Hit {
    /// `RTC_INVALID_GEOMETRY_ID`.
    pub const NONE: u32 = u32::MAX;
}

/// `RTCRayHit`: a ray, then its hit.
#[repr(C, align(16))]
pub struct RayHit {
    origin: Vec3,
    t_near: f32,
    direction: Vec3,
    time: f32,
    pub t_far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    pub hit: Hit,
}

impl RayHit {
    /// A ray that has hit nothing yet.
    pub fn new(ray: &Ray) -> Self {
        let hit = Hit {
            normal: Vec3::ZERO,
            u: 0.0,
            v: 0.0,
            primitive: Hit::NONE,
            geometry: Hit::NONE,
            instance: [Hit::NONE],
        };
        Self {
            origin: ray.origin,
            t_near: ray.t_min,
            direction: ray.direction,
            time: 0.0,
            t_far: ray.t_max,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            hit,
        }
    }
}

/// `RTCIntersectContext`.
#[repr(C)]
pub struct IntersectContext {
    flags: c_int,
    filter: *const c_void,
    instance: [u32; 1],
    // Where the library was built with minimal widths of curves.
    minimum_width: f32,
}

impl IntersectContext {
    /// As `rtcInitIntersectContext` makes it.
    pub fn incoherent() -> Self {
        Self { flags: 0, filter: std::ptr::null(), instance: [u32::MAX], minimum_width: 0.0 }
    }
}

/// Defines the table of functions and its loader from one list.
macro_rules! api {
    ($($field:ident = $symbol:literal: $type:ty;)*) => {
        /// Functions of the library, which stays open as long as this lives.
        pub struct Api {
            $(pub $field: $type,)*
            _library: Library,
        }

        impl Api {
            fn load(library: Library) -> Result<Self, String> {
                // SAFETY: the types are those of Embree 3's headers.
                unsafe {
                    $(let $field = *library.get::<$type>($symbol).map_err(|e| e.to_string())?;)*
                    Ok(Self { $($field,)* _library: library })
                }
            }
        }
    };
}

type Handle = *mut c_void;

api! {
    new_device = b"rtcNewDevice": unsafe extern "C" fn(*const c_char) -> Handle;
    release_device = b"rtcReleaseDevice": unsafe extern "C" fn(Handle);
    get_property = b"rtcGetDeviceProperty": unsafe extern "C" fn(Handle, c_int) -> isize;
    get_error = b"rtcGetDeviceError": unsafe extern "C" fn(Handle) -> c_int;
    new_scene = b"rtcNewScene": unsafe extern "C" fn(Handle) -> Handle;
    set_scene_quality = b"rtcSetSceneBuildQuality": unsafe extern "C" fn(Handle, Quality);
    commit_scene = b"rtcCommitScene": unsafe extern "C" fn(Handle);
    release_scene = b"rtcReleaseScene": unsafe extern "C" fn(Handle);
    new_geometry = b"rtcNewGeometry": unsafe extern "C" fn(Handle, c_int) -> Handle;
    set_geometry_quality = b"rtcSetGeometryBuildQuality": unsafe extern "C" fn(Handle, Quality);
    set_shared_buffer = b"rtcSetSharedGeometryBuffer":
        unsafe extern "C" fn(Handle, c_int, c_uint, c_int, *const c_void, usize, usize, usize);
    commit_geometry = b"rtcCommitGeometry": unsafe extern "C" fn(Handle);
    attach_geometry = b"rtcAttachGeometry": unsafe extern "C" fn(Handle, Handle) -> c_uint;
    release_geometry = b"rtcReleaseGeometry": unsafe extern "C" fn(Handle);
    intersect1 = b"rtcIntersect1": unsafe extern "C" fn(Handle, *mut IntersectContext, *mut RayHit);
    // Its ray is the front part of a `RayHit`.
    occluded1 = b"rtcOccluded1": unsafe extern "C" fn(Handle, *mut IntersectContext, *mut RayHit);
    new_bvh = b"rtcNewBVH": unsafe extern "C" fn(Handle) -> Handle;
    build_bvh = b"rtcBuildBVH": unsafe extern "C" fn(*const BuildArguments) -> *mut c_void;
    alloc = b"rtcThreadLocalAlloc": unsafe extern "C" fn(*mut c_void, usize, usize) -> *mut c_void;
    release_bvh = b"rtcReleaseBVH": unsafe extern "C" fn(Handle);
}

/// A device of its own number of threads.
pub struct Device<'a> {
    api: &'a Api,
    handle: Handle,
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        // SAFETY: made by this library, released once.
        unsafe { (self.api.release_device)(self.handle) }
    }
}

impl Api {
    /// Looks for the library.
    ///
    /// # Errors
    /// One line that says what to install.
    pub fn open() -> Result<Self, String> {
        for name in NAMES {
            // SAFETY: Embree's initialisers do nothing but set up its own state.
            if let Ok(library) = unsafe { Library::new(name) } {
                return Self::load(library);
            }
        }
        Err("Embree 3 is not installed: there is no libembree3 (Debian: apt-get install libembree-dev); leave the \
             feature peers-embree out to measure without it"
            .into())
    }

    /// A device.
    pub fn device(&self, threads: usize) -> Device<'_> {
        let configuration = CString::new(format!("threads={threads},start_threads=1")).expect("no NUL in it");
        // SAFETY: a configuration that ends in NUL.
        let handle = unsafe { (self.new_device)(configuration.as_ptr()) };
        assert!(!handle.is_null(), "Embree refuses its own configuration");
        Device { api: self, handle }
    }

    /// The library's version.
    pub fn version(&self) -> String {
        let device = self.device(1);
        // SAFETY: a live device.
        let parts = VERSION.map(|property| unsafe { (self.get_property)(device.handle, property) });
        parts.map(|part| part.to_string()).join(".")
    }

    /// What the device last complained of.
    pub fn error(&self, device: &Device) -> String {
        // SAFETY: a live device.
        format!("Embree's error {}", unsafe { (self.get_error)(device.handle) })
    }

    /// An empty scene.
    pub fn scene(&self, device: &Device) -> Handle {
        // SAFETY: a live device.
        unsafe { (self.new_scene)(device.handle) }
    }

    /// An empty tree.
    pub fn bvh(&self, device: &Device) -> Handle {
        // SAFETY: a live device.
        unsafe { (self.new_bvh)(device.handle) }
    }

    /// Gives the scene one mesh and builds it.
    ///
    /// # Safety
    /// Both buffers stay alive and unchanged as long as the scene; no index names the last vertex, which is padding.
    ///
    /// # Errors
    /// Embree's error code.
    pub unsafe fn commit(
        &self,
        device: &Device,
        scene: Handle,
        quality: Quality,
        vertices: &[Vec3],
        indices: &[u32],
    ) -> Result<(), String> {
        // SAFETY: by the caller's promise; counts and strides are those of the slices.
        unsafe {
            (self.set_scene_quality)(scene, quality);
            let mesh = (self.new_geometry)(device.handle, TRIANGLE);
            (self.set_geometry_quality)(mesh, quality);
            (self.set_shared_buffer)(mesh, VERTEX, 0, FLOAT3, vertices.as_ptr().cast(), 0, 12, vertices.len() - 1);
            (self.set_shared_buffer)(mesh, INDEX, 0, UINT3, indices.as_ptr().cast(), 0, 12, indices.len() / 3);
            (self.commit_geometry)(mesh);
            (self.attach_geometry)(scene, mesh);
            (self.release_geometry)(mesh);
            (self.commit_scene)(scene);
            match (self.get_error)(device.handle) {
                0 => Ok(()),
                code => Err(format!("Embree's error {code}")),
            }
        }
    }
}
