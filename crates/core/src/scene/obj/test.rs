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

fn area(mesh: &ObjMesh) -> f64 {
    mesh.triangles
        .iter()
        .map(|t| normal(mesh, t).length() / 2.0)
        .sum()
}

/// Warnings as `line×count message`.
pub(super) fn warnings(mesh: &ObjMesh) -> Vec<String> {
    let text =
        |w: &super::SceneWarning| format!("{}×{} {}", w.line.unwrap_or(0), w.count, w.message);
    mesh.warnings.iter().map(text).collect()
}

/// Asserts an error at `line` whose message has `part` in it.
fn assert_refused(result: Result<ObjMesh, SceneError>, line: usize, part: &str) {
    let error = result.expect_err(part);
    assert_eq!(error.line, Some(line), "{error}");
    assert!(error.message.contains(part), "{error}");
}

/// Asserts a mesh of this area with one warning, `line×count message…`, or none for `""`.
fn assert_loads(result: Result<ObjMesh, SceneError>, expected_area: f64, warning: &str) {
    let mesh = result.unwrap();
    assert_eq!(area(&mesh), expected_area);
    match warnings(&mesh).as_slice() {
        [] => assert_eq!(warning, ""),
        [one] => assert!(!warning.is_empty() && one.starts_with(warning), "{one}"),
        more => panic!("{more:?}"),
    }
}

/// The catalogue's cases of OBJ text.
#[test]
fn odd_records_load_with_a_warning_or_are_refused_by_line() {
    // D01: numbers that are none.
    for number in ["nan", "inf", "-inf", "1e999"] {
        assert_refused(
            with_square(&format!("v {number} 0 0\nf 1 2 3")),
            9,
            "finite",
        );
        assert_refused(
            with_square(&format!("v 0 0 {number}\nf 1 2 3")),
            9,
            "finite",
        );
    }
    assert_refused(with_square("v 0 2e18 0\nf 1 2 3"), 9, "beyond 1e18");
    assert_refused(with_square("v 1e9 0 0 1e-30\nf 1 2 3"), 9, "beyond 1e18");
    assert_loads(with_square("v 1e18 0 0\nf 1 2 3"), 0.5, "");
    assert_loads(
        with_square("vt nan 0\nvt 0 inf\nf 1 2 3"),
        0.5,
        "9×2 texture coordinates that are not",
    );
    assert_loads(with_square("vn nan nan nan\nf 1 2 3"), 0.5, "");
    // D03: indices before the first.
    assert_refused(
        with_square("f 1 2 -5"),
        9,
        "vertex -5 is before the first one; 4 precede",
    );
    assert_refused(with_square("f 1/1 2/-9 3/3"), 9, "texture coordinate -9");
    assert_refused(with_square("f 1//-9 2//1 3//1"), 9, "normal -9");
    assert_refused(
        with_square("f 1//-6148914691236517207 2 3"),
        9,
        "normal -6148914691236517207",
    );
    assert_refused(
        with_square("f 1 2 -9223372036854775808"),
        9,
        "vertex -9223372036854775808",
    );
    // D04: corners of different forms.
    assert_loads(with_square("f 1//1 2//1 3"), 0.5, "");
    assert_loads(
        with_square("f 1/1 2/2 3"),
        0.5,
        "9×1 faces that lack the texture coordinate",
    );
    // D05: nothing with an area.
    assert_loads(
        with_square("f 1 2 3\nf 1\nf\nf 1 2"),
        0.5,
        "10×3 faces of fewer than three",
    );
    assert_loads(
        with_square("l 1 2\np 1\nf 1 2 3"),
        0.5,
        "9×2 points and lines",
    );
    assert_loads(
        with_square("f 1 1 1\nf 1 2 3\nf 1 2 1 2\nf 1 2 2"),
        0.5,
        "9×3 faces without area",
    );
    assert!(
        with_square("f 1 1 1")
            .unwrap_err()
            .message
            .contains("no face with an area")
    );
    // D06: a fan would give 3.5, with one triangle upside down.
    let concave = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 .5 0\nv 0 2 0\nf 1 2 3 4 5";
    assert_loads(read(concave), 2.5, "");
    // D07: materials that are not there.
    assert_loads(
        with_square("usemtl zzz\nf 1 2 3\nusemtl zzz"),
        0.5,
        "9×2 no material \"zzz\"",
    );
    assert_loads(
        with_square("mtllib no such.mtl\nf 1 2 3"),
        0.5,
        "9×1 no material library \"no such.mtl\"",
    );
    assert_loads(
        with_square("usemtl\nf 1 2 3"),
        0.5,
        "9×1 usemtl names no material",
    );
    // D09: indices out of range, and texts as programs write them.
    assert_refused(with_square("f 0 1 2"), 9, "vertex 0 does not exist");
    assert_refused(
        with_square("f 1 2 3\nf 1 2 999"),
        10,
        "vertex 999 does not exist; the file has 4",
    );
    assert_refused(
        with_square("f 1/4 2/1 3/1"),
        9,
        "texture coordinate 4 does not exist; the file has 3",
    );
    assert_refused(
        with_square("f 1//2 2//1 3//1"),
        9,
        "normal 2 does not exist; the file has 1",
    );
    assert_refused(
        with_square("f 1 2 99999999999999999999"),
        9,
        "is not an index",
    );
    assert_refused(with_square("f 1 2 3/1/1/1"), 9, "more than three indices");
    assert_refused(with_square("f 1 2 /1"), 9, "\"\" is not an index");
    assert_refused(with_square("f 1 2 x"), 9, "\"x\" is not an index");
    assert_refused(with_square("v 1,5 2,0 3,1"), 9, "decimal point");
    assert_refused(with_square("v 1 2\nf 1 2 3"), 9, "three numbers");
    assert_refused(with_square("v 1 2 3 0\nf 1 2 3"), 9, "w, is 0");
    assert_refused(with_square("vt\nf 1 2 3"), 9, "a texture coordinate needs");
    assert_loads(
        read(&format!("{SQUARE}f 1 2 3 4\n").replace('\n', "\r\n")),
        1.0,
        "",
    );
    assert_loads(
        read(&format!("{SQUARE}f 1 2 3 4\n").replace('\n', "\r")),
        1.0,
        "",
    );
    assert_loads(with_square("f 1 2\\\n 3 \\\r\n 4 \\"), 1.0, "");
    assert_loads(with_square("# here: C:\\\nf 1 2 3 4"), 1.0, "");
    assert_loads(with_square("f\t1  2\t3 4 # a square"), 1.0, "");
    assert_loads(with_square("f -4 -3 -2 -1"), 1.0, "");
    assert_loads(read(&format!("\u{feff}{SQUARE}f 1 2 3 4")), 1.0, "");
    assert_loads(read(&format!("f 1/1 2/2 3/3\n{SQUARE}")), 0.5, "");
    assert_loads(with_square("v 2 0 0 2\nv 2 2 0 2\nf 1 5 6 4"), 1.0, "");
    assert_loads(
        with_square("v 0 0 0 1 0 0\nv 0 0 0 .5 .5 .5 1\nf 1 2 3"),
        0.5,
        "9×2 vertex colours",
    );
    assert_loads(
        with_square("g a\no b\ns off\ncurv 0 1\nf 1 2 3"),
        0.5,
        "12×1 records of type \"curv\"",
    );
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
