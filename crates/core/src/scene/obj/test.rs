//! What OBJ and MTL files meet in the wild, and what must come of it.

use std::path::Path;

use glam::{Vec2, Vec3};

use super::mtl_test::assert_physical;
use super::{ObjMesh, parse};
use crate::scene::error::SceneError;

/// Four corners of the unit square, and as many texture coordinates and normals as it takes.
pub(super) const SQUARE: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n";

fn read(text: &str) -> Result<ObjMesh, SceneError> {
    let mesh = parse(text.as_bytes(), Path::new("test.obj"));
    mesh.as_ref().map_or_else(assert_readable, assert_sound);
    mesh
}

/// The square, which ends on line 8, and some more.
fn with_square(text: &str) -> Result<ObjMesh, SceneError> {
    read(&format!("{SQUARE}{text}"))
}

pub(super) fn assert_readable(error: &SceneError) {
    let line = error.to_string();
    assert!(line.len() < 300 && !line.contains(['\n', '\r']), "{line}");
    assert!(
        line.starts_with(&*error.path.to_string_lossy()) && !error.message.is_empty(),
        "{line}"
    );
}

/// What the rest of lightbox relies on.
pub(super) fn assert_sound(mesh: &ObjMesh) {
    assert!(!mesh.triangles.is_empty());
    assert!(mesh.positions.iter().all(|p| p.abs().max_element() <= 1e18));
    assert!(mesh.uvs.iter().all(|uv| uv.is_finite()));
    assert_eq!(mesh.triangle_materials.len(), mesh.triangles.len());
    let uv_triangles = if mesh.uvs.is_empty() {
        0
    } else {
        mesh.triangles.len()
    };
    assert_eq!(mesh.uv_triangles.len(), uv_triangles);
    assert!(
        mesh.triangles
            .iter()
            .flatten()
            .all(|v| (*v as usize) < mesh.positions.len())
    );
    for corners in &mesh.uv_triangles {
        let inside = corners.iter().all(|v| (*v as usize) < mesh.uvs.len());
        assert!(inside || *corners == [u32::MAX; 3]);
    }
    let known = |m: &u32| *m == u32::MAX || (*m as usize) < mesh.materials.len();
    assert!(mesh.triangle_materials.iter().all(known));
    for triangle in &mesh.triangles {
        assert!(normal(mesh, triangle).length() > 0.0);
    }
    for material in &mesh.materials {
        assert_physical(material);
    }
    assert!(
        mesh.warnings
            .iter()
            .all(|w| w.count > 0 && !w.message.contains('\n'))
    );
}

/// Twice the area long.
fn normal(mesh: &ObjMesh, triangle: &[u32; 3]) -> glam::DVec3 {
    let [a, b, c] = triangle.map(|v| mesh.positions[v as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// Warnings as `line×count message`.
pub(super) fn warnings(mesh: &ObjMesh) -> Vec<String> {
    let text =
        |w: &super::SceneWarning| format!("{}×{} {}", w.line.unwrap_or(0), w.count, w.message);
    mesh.warnings.iter().map(text).collect()
}

#[test]
fn corners_keep_their_texture_coordinates() {
    // The first face has none, at which tobj would make some up.
    let mesh = with_square("f 1 3 4\nf 1/1 2/2 3/-1\nvt 9").unwrap();
    assert_eq!(mesh.uv_triangles[0], [u32::MAX; 3]);
    let corner = |c: usize| {
        let (v, vt) = (
            mesh.triangles[1][c] as usize,
            mesh.uv_triangles[1][c] as usize,
        );
        (mesh.positions[v], mesh.uvs[vt])
    };
    assert_eq!(corner(0), (Vec3::ZERO, Vec2::ZERO));
    assert_eq!(corner(1), (Vec3::X, Vec2::X));
    assert_eq!(corner(2), (Vec3::new(1.0, 1.0, 0.0), Vec2::ONE));
    assert!(with_square("f 1 2 3").unwrap().uvs.is_empty());
    // One number is legal; the other is then 0.
    let mesh = with_square("vt .5\nf 1/4 2/4 3/4").unwrap();
    assert!(
        mesh.uv_triangles[0]
            .iter()
            .all(|v| mesh.uvs[*v as usize] == Vec2::new(0.5, 0.0))
    );
}

#[test]
fn a_convex_quadrilateral_is_split_between_its_first_and_third_corner() {
    let mesh = with_square("f 2 3 4 1").unwrap();
    let ends = [Vec3::X, Vec3::Y];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|v| mesh.positions[v as usize]);
        assert!(ends.iter().all(|end| corners.contains(end)), "{corners:?}");
    }
}

#[test]
fn what_is_no_obj_file_is_refused_in_one_clear_line() {
    let noise: Vec<u8> = (0..4096)
        .map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    let cases: [(&[u8], &str); 16] = [
        (b"", "is empty"),
        (b" \r\n\t\n", "is empty"),
        (b"\xEF\xBB\xBF\n", "has no faces"),
        (b"\x89PNG\r\n\x1A\n\0\0\0\rIHDR", "binary"),
        (b"\xFF\xD8\xFF\xE0\0\x10JFIF", "binary"),
        (b"\x1F\x8B\x08\0\0\0\0\0", "binary"),
        (b"\x7FELF\x02\x01\x01\0", "binary"),
        (&noise, "binary"),
        (b"\xFF\xFEv\0 \x001\0", "UTF-16"),
        (
            b"ply\nformat ascii 1.0\nelement vertex 8\n",
            "not an OBJ file: no record of one begins with \"ply\"",
        ),
        (
            b"solid cube\n facet normal 0 0 1\n",
            "begins with \"solid\"",
        ),
        (b"{\"asset\": {\"version\": \"2.0\"}}", "not an OBJ file"),
        (b"<?xml version=\"1.0\"?>\n<COLLADA>", "not an OBJ file"),
        (b"\xE9\xE8\xFF \xFE\xC0", "not an OBJ file"),
        (b"# only a comment", "has no faces"),
        (b"v 0 0 0\nv 1 0 0\nl 1 2", "has no faces"),
    ];
    for (bytes, part) in cases {
        let error = parse(bytes, Path::new("junk.obj")).expect_err(part);
        assert_readable(&error);
        assert!(error.message.contains(part), "{error}");
    }
}

#[test]
pub(super) fn warnings_of_many_kinds_are_bounded() {
    let records: String = (0..1000).map(|i| format!("odd{i} 1\n")).collect();
    let mesh = with_square(&format!("{records}f 1 2 3")).unwrap();
    assert!(mesh.warnings.len() < 50);
    assert_eq!(mesh.warnings.iter().map(|w| w.count).sum::<usize>(), 1000);
}
