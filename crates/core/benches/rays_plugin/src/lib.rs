//! lightbox's ray casting behind a small C ABI: build a mesh, cast a batch of rays, nearest or
//! any. It calls what a user of the library calls, one ray at a time or in batches.
//!
//! Meshes are triangles only; a miss is t = ∞ and prim = 2³² − 1.

use std::ffi::{CStr, c_char};

use glam::Vec3;
use lightbox_core::AccelKind;
use lightbox_core::geometry::{Geometry, Primitives};
use lightbox_core::math::Ray;
use lightbox_core::simd::Kernel;

/// Mode names, parted by blanks, in the order of [`MODES`].
const NAMES: &CStr = c"lightbox-bvh lightbox-bvh-portable lightbox-kdtree";

const MODES: [(AccelKind, bool); 3] = [
    (AccelKind::Bvh, false),
    (AccelKind::Bvh, true),
    (AccelKind::KdTree, false),
];

/// A ray as the caller stores it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct RawRay {
    origin: [f32; 3],
    dir: [f32; 3],
    t_max: f32,
}

impl RawRay {
    fn ray(&self) -> Ray {
        Ray {
            origin: Vec3::from_array(self.origin),
            dir: Vec3::from_array(self.dir),
            t_max: self.t_max,
        }
    }
}

/// Names of the modes.
#[unsafe(no_mangle)]
pub extern "C" fn rays_modes() -> *const c_char {
    NAMES.as_ptr()
}

/// Builds a mesh; `bytes` receives all memory that it takes.
///
/// # Safety
/// The arrays must hold as many entries as their counts say, indices must be in range.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rays_build(
    mode: u32,
    xyz: *const [f32; 3],
    vertices: u32,
    abc: *const [u32; 3],
    triangles: u32,
    threads: u32,
    bytes: *mut u64,
) -> *mut Geometry {
    // SAFETY: the caller's promise.
    let (xyz, abc, bytes) = unsafe {
        (
            std::slice::from_raw_parts(xyz, vertices as usize),
            std::slice::from_raw_parts(abc, triangles as usize),
            &mut *bytes,
        )
    };
    let (accel, portable) = MODES[mode as usize];
    let kernel = if portable { Kernel::Portable } else { Kernel::detect() };
    let primitives = Primitives {
        triangles: abc
            .iter()
            .map(|t| t.map(|i| Vec3::from_array(xyz[i as usize])))
            .collect(),
        ..Primitives::default()
    };
    let build = || Geometry::build_for(primitives, accel, kernel);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads as usize)
        .build();
    let geometry = match pool {
        Ok(pool) => pool.install(build),
        Err(_) => build(),
    };
    let triangles = &geometry.primitives().triangles;
    *bytes = (geometry.accel_bytes() + size_of_val(&triangles[..])) as u64;
    Box::into_raw(Box::new(geometry))
}

/// The nearest hit of each ray.
///
/// # Safety
/// `geometry` must come from [`rays_build`], and the arrays must hold `count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rays_closest(
    geometry: *const Geometry,
    rays: *const RawRay,
    count: u64,
    t: *mut f32,
    prim: *mut u32,
) {
    // SAFETY: the caller's promise.
    let (geometry, rays, t, prim) = unsafe {
        (
            &*geometry,
            std::slice::from_raw_parts(rays, count as usize),
            std::slice::from_raw_parts_mut(t, count as usize),
            std::slice::from_raw_parts_mut(prim, count as usize),
        )
    };
    for ((ray, t), prim) in rays.iter().zip(t).zip(prim) {
        let hit = geometry.intersect(&ray.ray(), |_| false);
        (*t, *prim) = hit.map_or((f32::INFINITY, u32::MAX), |h| (h.t, h.prim));
    }
}

/// Whether each ray hits anything.
///
/// # Safety
/// As for [`rays_closest`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rays_any(
    geometry: *const Geometry,
    rays: *const RawRay,
    count: u64,
    hit: *mut u8,
) {
    // SAFETY: the caller's promise.
    let (geometry, rays, hit) = unsafe {
        (
            &*geometry,
            std::slice::from_raw_parts(rays, count as usize),
            std::slice::from_raw_parts_mut(hit, count as usize),
        )
    };
    for (ray, hit) in rays.iter().zip(hit) {
        *hit = u8::from(geometry.occluded(&ray.ray(), u32::MAX));
    }
}

/// Frees what [`rays_build`] made.
///
/// # Safety
/// `geometry` must come from [`rays_build`] and not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rays_free(geometry: *mut Geometry) {
    // SAFETY: the caller's promise.
    drop(unsafe { Box::from_raw(geometry) });
}
