//! Texts of OBJ and MTL files as they are found in the wild.

use std::path::Path;

use super::{Bound, Case, Check, Figure, mesh_materials};
use crate::scene::SceneWarning;
use crate::scene::obj::{self, ObjMesh};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "D01",
        title: "coordinates that are no numbers",
        failure: "tobj returns NaN and ∞ as they stand.",
        cure: "Every number is checked before tobj sees it; the line is named.",
        check: Check::Probe(numbers),
        scene: None,
        picture: None,
    },
    Case {
        id: "D02",
        title: "colours of one number, or of none",
        failure: "tobj 4.0.5 panics on `Kd 0.5`, which is legal, and on `Kd`.",
        cure: "Material files are checked and written out in full.",
        check: Check::Probe(mesh_materials::colors),
        scene: None,
        picture: None,
    },
    Case {
        id: "D03",
        title: "indices before the first",
        failure: "tobj 4.0.5 overflows: a panic, or a mesh with another vertex's normal.",
        cure: "Relative indices are resolved while reading, with the count at that line.",
        check: Check::Probe(indices),
        scene: None,
        picture: None,
    },
    Case {
        id: "D04",
        title: "corners of different forms in one face",
        failure: "Normals or coordinates for some corners only: lists of different lengths, and an \
                  index beyond the end.",
        cure: "A face that lacks some is taken without any.",
        check: Check::Probe(mixed),
        scene: None,
        picture: None,
    },
    Case {
        id: "D05",
        title: "faces without area",
        failure: "Points and lines become triangles of one vertex; their normals are 0/0.",
        cure: "Left out, and counted in a warning.",
        check: Check::Probe(no_area),
        scene: None,
        picture: None,
    },
    Case {
        id: "D06",
        title: "a concave polygon",
        failure: "A fan from the first corner covers 3.5 for an area of 2.5, one triangle upside \
                  down.",
        cure: "Ears are cut one by one (Meisters 1975).",
        check: Check::Probe(concave),
        scene: None,
        picture: None,
    },
    Case {
        id: "D07",
        title: "materials that are not there",
        failure: "The material is missing in silence, or the whole file is refused.",
        cure: "The default material, and a warning with the line.",
        check: Check::Probe(mesh_materials::missing),
        scene: None,
        picture: None,
    },
    Case {
        id: "D08",
        title: "materials that no surface has",
        failure: "Reflectances of NaN, 2 and −1 pass into the render.",
        cure: "Clamped with a warning, or refused where no number is meant.",
        check: Check::Probe(mesh_materials::impossible),
        scene: None,
        picture: None,
    },
    Case {
        id: "D09",
        title: "texts as programs write them",
        failure: "Carriage returns, continued lines, decimal commas, indices of 0, empty files.",
        cure: "What is legal is read; what is not gets one line with the line number.",
        check: Check::Probe(dialects),
        scene: None,
        picture: None,
    },
];

/// A unit square with texture coordinates and a normal: eight lines.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n";

/// What must come of a text.
pub(super) enum Outcome {
    /// A mesh of this area, with one kind of warning that begins so, or none if empty.
    Loads(f64, &'static str),
    /// An error of one line that names this line and holds this part.
    Refused(usize, &'static str),
}

use Outcome::{Loads, Refused};

fn area(mesh: &ObjMesh) -> f64 {
    let corner = |v: u32| mesh.positions[v as usize].as_dvec3();
    mesh.triangles
        .iter()
        .map(|t| t.map(corner))
        .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
        .sum()
}

/// Whether every index of a mesh has its vertex, and every number is finite.
fn is_sound(mesh: &ObjMesh) -> bool {
    let (v, vt) = (mesh.positions.len() as u32, mesh.uvs.len() as u32);
    let mut corners = mesh.uv_triangles.iter().flatten();
    mesh.positions.iter().all(|p| p.is_finite())
        && mesh.uvs.iter().all(|uv| uv.is_finite())
        && mesh.triangles.iter().flatten().all(|i| *i < v)
        && corners.all(|i| *i < vt || *i == u32::MAX)
        && mesh.triangle_materials.len() == mesh.triangles.len()
}

/// Whether warnings are one that begins, after its place, with `expected`, or none if it is empty.
pub(super) fn are_as_told(warnings: &[SceneWarning], expected: &str) -> bool {
    match warnings {
        [] => expected.is_empty(),
        [one] => !expected.is_empty() && one.to_string().contains(expected),
        _ => false,
    }
}

fn is_as_told(text: &str, outcome: &Outcome) -> bool {
    match (obj::parse(text.as_bytes(), Path::new("lab.obj")), outcome) {
        (Ok(mesh), Loads(expected, warning)) => {
            is_sound(&mesh) && area(&mesh) == *expected && are_as_told(&mesh.warnings, warning)
        }
        (Err(e), Refused(line, part)) => {
            e.line == Some(*line) && e.message.contains(part) && !e.message.contains('\n')
        }
        _ => false,
    }
}

/// Texts appended to the square that come out otherwise than told.
pub(super) fn astray(table: &[(&str, Outcome)]) -> f64 {
    let wrong =
        |(text, outcome): &&(&str, Outcome)| !is_as_told(&format!("{SQUARE}{text}"), outcome);
    table.iter().filter(wrong).count() as f64
}

/// What tobj alone makes of a text.
fn tobj(text: &str, single_index: bool) -> Option<tobj::Mesh> {
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index,
        ..tobj::LoadOptions::default()
    };
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| {
        Err(tobj::LoadError::GenericFailure)
    })
    .ok()?;
    models.into_iter().next().map(|model| model.mesh)
}

pub(super) fn figure(what: &'static str, naive: Option<f64>, lightbox: f64) -> Figure {
    Figure {
        what,
        naive,
        lightbox,
        bound: Bound::Exactly(0.0),
    }
}

fn numbers() -> Vec<Figure> {
    let table = [
        ("v nan 0 0\nf 1 2 3", Refused(9, "finite")),
        ("v inf 0 0\nf 1 2 3", Refused(9, "finite")),
        ("v 0 0 -inf\nf 1 2 3", Refused(9, "finite")),
        ("v 0 1e999 0\nf 1 2 3", Refused(9, "finite")),
        ("v 0 2e18 0\nf 1 2 3", Refused(9, "beyond 1e18")),
        ("v 1e9 0 0 1e-30\nf 1 2 3", Refused(9, "beyond 1e18")),
        ("v 1e18 0 0\nf 1 2 3", Loads(0.5, "")),
        (
            "vt nan 0\nvt 0 inf\nf 1 2 3",
            Loads(0.5, "texture coordinates that are not"),
        ),
        ("vn nan nan nan\nf 1 2 3", Loads(0.5, "")),
    ];
    let passed = table[..4].iter().filter(|(text, _)| {
        let text = text.replace("f 1 2 3", "f 1 2 5");
        tobj(&format!("{SQUARE}{text}"), false)
            .is_some_and(|mesh| mesh.positions.iter().any(|x| !x.is_finite()))
    });
    vec![figure(
        "texts of 9 with another outcome (naive: NaN or ∞ let through, of 4)",
        Some(passed.count() as f64),
        astray(&table),
    )]
}

fn indices() -> Vec<Figure> {
    let table = [
        (
            "f 1 2 -5",
            Refused(9, "vertex -5 is before the first one; 4 precede"),
        ),
        ("f 1/1 2/-9 3/3", Refused(9, "texture coordinate -9")),
        ("f 1//-9 2//1 3//1", Refused(9, "normal -9")),
        (
            "f 1//-6148914691236517207 2 3",
            Refused(9, "normal -6148914691236517207"),
        ),
        (
            "f 1 2 -9223372036854775808",
            Refused(9, "vertex -9223372036854775808"),
        ),
        ("f 1 2 99999999999999999999", Refused(9, "is not an index")),
        ("f -4 -3 -2 -1", Loads(1.0, "")),
    ];
    vec![figure(
        "texts of 7 with another outcome",
        None,
        astray(&table),
    )]
}

fn mixed() -> Vec<Figure> {
    let lack = "faces that lack the texture coordinate";
    let table = [
        ("f 1//1 2//1 3", Loads(0.5, "")),
        ("f 1/1 2/2 3", Loads(0.5, lack)),
        ("f 1/1/1 2//1 3/3", Loads(0.5, lack)),
        ("f 1 2/2/1 3", Loads(0.5, lack)),
    ];
    let uneven = table.iter().filter(|(text, _)| {
        // By one index for all attributes of a corner.
        tobj(&format!("{SQUARE}{text}\n"), true).is_some_and(|mesh| {
            let (v, vt) = (mesh.positions.len() / 3, mesh.texcoords.len() / 2);
            let vn = mesh.normals.len() / 3;
            (vt != 0 && vt != v) || (vn != 0 && vn != v)
        })
    });
    vec![figure(
        "texts of 4 with another outcome (naive: lists of different lengths)",
        Some(uneven.count() as f64),
        astray(&table),
    )]
}

fn no_area() -> Vec<Figure> {
    let table = [
        (
            "f 1 2 3\nf 1\nf\nf 1 2",
            Loads(
                0.5,
                "faces of fewer than three corners have no area; skipped (3 times)",
            ),
        ),
        (
            "l 1 2\np 1\nf 1 2 3",
            Loads(0.5, "points and lines have no area; skipped (2 times)"),
        ),
        (
            "f 1 1 1\nf 1 2 3\nf 1 2 1 2\nf 1 2 2",
            Loads(0.5, "faces without area are skipped (3 times)"),
        ),
    ];
    let degenerate = ["f 1", "l 1 2", "f 1 1 1"].iter().filter(|text| {
        tobj(&format!("{SQUARE}{text}\n"), false).is_some_and(|mesh| {
            let mut triangles = mesh.indices.chunks_exact(3);
            triangles.any(|t| t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
        })
    });
    vec![figure(
        "texts of 3 with another outcome (naive: triangles of one vertex let through)",
        Some(degenerate.count() as f64),
        astray(&table),
    )]
}

fn concave() -> Vec<Figure> {
    let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 .5 0\nv 0 2 0\nf 1 2 3 4 5\n";
    let covered = obj::parse(text.as_bytes(), Path::new("lab.obj")).map_or(f64::NAN, |m| area(&m));
    let fan = tobj(text, false).map(|mesh| {
        let corner = |i: u32| {
            let p = &mesh.positions[3 * i as usize..][..3];
            glam::DVec3::new(p[0].into(), p[1].into(), p[2].into())
        };
        let double = |t: &[u32]| {
            let [a, b, c] = [corner(t[0]), corner(t[1]), corner(t[2])];
            (b - a).cross(c - a).length()
        };
        mesh.indices.chunks_exact(3).map(double).sum::<f64>() / 2.0
    });
    vec![Figure {
        what: "sum of the triangles' areas",
        naive: fan,
        lightbox: covered,
        bound: Bound::Exactly(2.5),
    }]
}

fn dialects() -> Vec<Figure> {
    let table = [
        ("f 0 1 2", Refused(9, "vertex 0 does not exist")),
        (
            "f 1 2 3\nf 1 2 999",
            Refused(10, "vertex 999 does not exist; the file has 4"),
        ),
        (
            "f 1/4 2/1 3/1",
            Refused(9, "texture coordinate 4 does not exist; the file has 3"),
        ),
        (
            "f 1//2 2//1 3//1",
            Refused(9, "normal 2 does not exist; the file has 1"),
        ),
        ("f 1 2 3/1/1/1", Refused(9, "more than three indices")),
        ("f 1 2 /1", Refused(9, "\"\" is not an index")),
        ("f 1 2 x", Refused(9, "\"x\" is not an index")),
        ("v 1,5 2,0 3,1", Refused(9, "decimal point")),
        ("v 1 2\nf 1 2 3", Refused(9, "three numbers")),
        ("v 1 2 3 0\nf 1 2 3", Refused(9, "w, is 0")),
        ("vt\nf 1 2 3", Refused(9, "a texture coordinate needs")),
        ("f 1 2\\\n 3 \\\r\n 4 \\", Loads(1.0, "")),
        ("# here: C:\\\nf 1 2 3 4", Loads(1.0, "")),
        ("f\t1  2\t3 4 # a square\r\n", Loads(1.0, "")),
        ("v 2 0 0 2\nv 2 2 0 2\nf 1 5 6 4", Loads(1.0, "")),
        (
            "v 0 0 0 1 0 0\nv 0 0 0 .5 .5 .5 1\nf 1 2 3",
            Loads(0.5, "vertex colours"),
        ),
        (
            "g a\no b\ns off\ncurv 0 1\nf 1 2 3",
            Loads(0.5, "records of type \"curv\""),
        ),
    ];
    // Whole files: nothing in them, line ends of all kinds, faces before their vertices.
    let whole = [
        (String::new(), false),
        ("\n \t\n".into(), false),
        ("v 0 0 0\n".into(), false),
        (format!("{SQUARE}f 1 2 3 4\n").replace('\n', "\r\n"), true),
        (format!("{SQUARE}f 1 2 3 4\n").replace('\n', "\r"), true),
        (format!("\u{feff}{SQUARE}f 1 2 3 4"), true),
        (format!("f 1/1 2/2 3/3\n{SQUARE}"), true),
    ];
    let wrong = whole.iter().filter(|(text, loads)| {
        obj::parse(text.as_bytes(), Path::new("lab.obj")).is_ok() != *loads
    });
    let refused = table[11..].iter().filter(|(text, _)| {
        tobj(&format!("{SQUARE}{text}\n"), false).is_none_or(|mesh| mesh.indices.is_empty())
    });
    vec![figure(
        "texts of 24 with another outcome (naive: legal texts refused, of 6)",
        Some(refused.count() as f64),
        astray(&table) + wrong.count() as f64,
    )]
}
