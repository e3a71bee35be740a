//! A stage for a bare mesh: the enclosed box under an area light, with the mesh scaled, stood on
//! the floor and framed. A mesh that brings its own lights is framed as it is.

use std::path::Path;

use glam::Vec3;

use super::desc::{CameraDesc, MaterialDesc, MeshDesc, QuadDesc, SceneDesc};
use super::obj::ObjMesh;
use crate::math::Aabb;

/// Height and width that the mesh may fill, in a box of edge 2.
const ROOM_FOR_MESH: Vec3 = Vec3::new(1.4, 1.3, 1.4);

/// A mesh entry named after its file.
pub(super) fn mesh_desc(path: &Path) -> MeshDesc {
    MeshDesc {
        name: path
            .file_stem()
            .map(|s| s.to_string_lossy().into_owned())
            .unwrap_or_default(),
        material: None,
        file: None,
        boulder: None,
        scale: 1.0,
        rotate: Vec3::ZERO,
        translate: Vec3::ZERO,
    }
}

/// A scene around a mesh.
pub(super) fn around_mesh(mesh: &ObjMesh, desc: MeshDesc) -> SceneDesc {
    let bounds = mesh.bounds();
    let emits = |m: u32| {
        mesh.materials
            .get(m as usize)
            .is_some_and(|m| m.emission != Vec3::ZERO)
    };
    if mesh.triangle_materials.iter().any(|m| emits(*m)) {
        return SceneDesc {
            camera: facing(&bounds),
            meshes: vec![desc],
            ..SceneDesc::default()
        };
    }
    // The largest of three ratios fits; a flat mesh has only two.
    let scale = (bounds.extent() / ROOM_FOR_MESH).max_element().recip();
    let scale = if scale.is_finite() { scale } else { 1.0 };
    let foot = Vec3::new(bounds.center().x, bounds.min.y, bounds.center().z);
    let translate = Vec3::new(0.0, -1.0, 0.0) - foot * scale;
    let mut scene = room();
    scene.meshes = vec![MeshDesc {
        scale,
        translate,
        ..desc
    }];
    scene
}

/// A camera in front (+z) of a box that sees all of it.
fn facing(bounds: &Aabb) -> CameraDesc {
    let camera = CameraDesc::default();
    let target = bounds.center();
    let half = bounds.extent() * 0.5;
    let distance = half.z + 1.05 * half.x.max(half.y) / libm::tanf(camera.fov.to_radians() * 0.5);
    CameraDesc {
        eye: target + Vec3::new(0.0, 0.0, distance),
        target,
        ..camera
    }
}

/// The empty box of edge 2 around the origin, open towards the camera, with a lamp just below
/// the ceiling.
fn room() -> SceneDesc {
    let material = |name: &str, albedo: [f32; 3], emission: [f32; 3]| MaterialDesc {
        name: name.into(),
        albedo: albedo.into(),
        emission: emission.into(),
        ..MaterialDesc::default()
    };
    let quad = |name: &str, material: &str, corners: [[f32; 3]; 4]| QuadDesc {
        name: name.into(),
        material: material.into(),
        corners: corners.map(Vec3::from),
    };
    let (l, r, b, t, n, f) = (-1.0, 1.0, -1.0, 1.0, 1.0, -1.0);
    let (x, y, z) = (0.25, 0.99, 0.2);
    SceneDesc {
        materials: vec![
            material("white", [0.73; 3], [0.0; 3]),
            material("red", [0.63, 0.065, 0.05], [0.0; 3]),
            material("green", [0.14, 0.45, 0.09], [0.0; 3]),
            material("lamp", [0.0; 3], [17.0, 12.0, 4.0]),
        ],
        quads: vec![
            quad(
                "floor",
                "white",
                [[l, b, n], [r, b, n], [r, b, f], [l, b, f]],
            ),
            quad(
                "ceiling",
                "white",
                [[l, t, f], [r, t, f], [r, t, n], [l, t, n]],
            ),
            quad(
                "back wall",
                "white",
                [[l, b, f], [r, b, f], [r, t, f], [l, t, f]],
            ),
            quad(
                "left wall",
                "red",
                [[l, b, n], [l, b, f], [l, t, f], [l, t, n]],
            ),
            quad(
                "right wall",
                "green",
                [[r, b, f], [r, b, n], [r, t, n], [r, t, f]],
            ),
            quad(
                "lamp",
                "lamp",
                [[-x, y, -z], [x, y, -z], [x, y, z], [-x, y, z]],
            ),
        ],
        ..SceneDesc::default()
    }
}
