//! lightbox's ray casting behind a small C ABI: build a mesh, cast a batch of rays, nearest or
//! any. It calls what a user of the library calls, one ray at a time or in batches.
//!
//! Meshes are triangles only; a miss is t = ∞ and prim = 2³² − 1.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ffi::{CStr, c_char};
use std::sync::{Arc, Mutex, PoisonError};

use glam::Vec3;
use lightbox_core::AccelKind;
use lightbox_core::geometry::{Geometry, Primitives};
use lightbox_core::math::Ray;
use lightbox_core::simd::Kernel;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// Mode names, parted by blanks, in the order of [`MODES`].
const NAMES: &CStr = c"lightbox-bvh lightbox-bvh-many lightbox-bvh-portable lightbox-bvh-portable-many lightbox-kdtree lightbox-kdtree-many";

/// The accelerator, whether on the portable kernel, whether many rays in one call.
const MODES: [(AccelKind, bool, bool); 6] = [
    (AccelKind::Bvh, false, false),
    (AccelKind::Bvh, false, true),
    (AccelKind::Bvh, true, false),
    (AccelKind::Bvh, true, true),
    (AccelKind::KdTree, false, false),
    (AccelKind::KdTree, false, true),
];

/// A mesh as one of the modes casts rays at it.
pub struct Built {
    geometry: Geometry,
    many: bool,
}

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
) -> *mut Built {
    // SAFETY: the caller's promise.
    let (xyz, abc, bytes) = unsafe {
        (
            std::slice::from_raw_parts(xyz, vertices as usize),
            std::slice::from_raw_parts(abc, triangles as usize),
            &mut *bytes,
        )
    };
    let (accel, portable, many) = MODES[mode as usize];
    let kernel = if portable {
        Kernel::Portable
    } else {
        Kernel::detect()
    };
    let build = || {
        let corner = |i: u32| Vec3::from_array(xyz[i as usize]);
        let primitives = Primitives {
            triangles: abc
                .par_iter()
                .map(|t| t.map(corner))
                .collect::<Vec<_>>()
                .into(),
            ..Primitives::default()
        };
        Geometry::build_for(primitives, accel, kernel)
    };
    let geometry = match pool(threads) {
        Ok(pool) => pool.install(build),
        Err(_) => build(),
    };
    *bytes = (geometry.accel_bytes() + geometry.primitives().bytes()) as u64;
    Box::into_raw(Box::new(Built { geometry, many }))
}

/// So many threads, started once: a program keeps its own from build to build.
fn pool(threads: u32) -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
    static POOLS: Mutex<BTreeMap<u32, Arc<ThreadPool>>> = Mutex::new(BTreeMap::new());
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(match pools.entry(threads) {
        Entry::Occupied(pool) => pool.get().clone(),
        Entry::Vacant(place) => {
            let pool = ThreadPoolBuilder::new().num_threads(threads as usize);
            place.insert(Arc::new(pool.build()?)).clone()
        }
    })
}

/// The nearest hit of each ray.
///
/// # Safety
/// `geometry` must come from [`rays_build`], and the arrays must hold `count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rays_closest(
    geometry: *const Built,
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
    let Built { geometry, many } = geometry;
    if *many {
        geometry.intersect_many(
            rays,
            RawRay::ray,
            |_| false,
            |i, hit| {
                (t[i], prim[i]) = hit.map_or((f32::INFINITY, u32::MAX), |h| (h.t, h.prim));
            },
        );
        return;
    }
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
    geometry: *const Built,
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
    let Built { geometry, many } = geometry;
    if *many {
        geometry.occluded_many(
            rays,
            |ray| (ray.ray(), u32::MAX),
            |i, shaded| hit[i] = u8::from(shaded),
        );
        return;
    }
    for (ray, hit) in rays.iter().zip(hit) {
        *hit = u8::from(geometry.occluded(&ray.ray(), u32::MAX));
    }
}

/// Frees what [`rays_build`] made.
///
/// # Safety
/// `geometry` must come from [`rays_build`] and not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rays_free(geometry: *mut Built) {
    // SAFETY: the caller's promise.
    drop(unsafe { Box::from_raw(geometry) });
}
