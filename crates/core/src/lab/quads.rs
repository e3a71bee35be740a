//! Quads: what is no parallelogram, edges, corners.

use std::path::Path;

use glam::Vec3;

use super::input::{NOTHING, cast, toward};
use super::random::Rng;
use super::stats::{Comparisons, Replicates};
use super::{Bound, Case, Check, Figure, pictures, trial};
use crate::geometry::{Geometry, Primitives, SurfacePoint};
use crate::math::{Frame, Ray, warp};
use crate::scene::{MaterialDesc, QuadDesc, SceneDesc, SceneError, Source};
use crate::settings::{AccelKind, UNLIMITED};
use crate::shape::Quad;
use crate::{Method, Scene};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "Q01",
        title: "a wall that is no parallelogram",
        failure: "The measured Cornell box has a wall whose fourth corner is 3 units off the plane of \
                  a parallelogram, and a floor that is a trapezoid: taken for one, it leaves gaps.",
        cure: "A quad whose diagonals do not halve each other becomes two triangles.",
        check: Check::Probe(cornell),
        scene: Some("builtin:lab/measured-cornell-box.toml"),
        picture: Some(pictures::cornell),
    },
    Case {
        id: "Q02",
        title: "a closed cube of quads",
        failure: "A plane and 0 < u, v < 1, each quad with rounding of its own: light escapes at edges \
                  and corners, and the view factors sum to less than 1 (embree issue 538).",
        cure: "A quad is tested as two watertight triangles.",
        check: Check::Probe(cube),
        scene: None,
        picture: None,
    },
    Case {
        id: "Q03",
        title: "the diagonal of a quad",
        failure: "Two triangles give two hits at equal t (embree issue 188): wrong for whoever counts.",
        cure: "One primitive with one id.",
        check: Check::Probe(diagonal),
        scene: None,
        picture: None,
    },
    Case {
        id: "Q04",
        title: "corners in the wrong order",
        failure: "Crossed, concave or coinciding corners give negative areas and NaN normals.",
        cure: "Refused when a scene is loaded, in one line.",
        check: Check::Probe(corners),
        scene: None,
        picture: None,
    },
];

/// A scene of white quads.
pub(super) fn scene(quads: &[[Vec3; 4]]) -> Result<Scene, SceneError> {
    let desc = SceneDesc {
        materials: vec![MaterialDesc {
            name: "white".into(),
            ..MaterialDesc::default()
        }],
        quads: quads
            .iter()
            .map(|corners| QuadDesc {
                name: String::new(),
                material: "white".into(),
                corners: *corners,
            })
            .collect(),
        ..SceneDesc::default()
    };
    Source::from_desc(desc, Path::new("quads.toml")).build(&crate::scene::unwatched)
}

/// Quads as one primitive each.
pub(super) fn geometry(quads: &[[Vec3; 4]], accel: AccelKind) -> Geometry {
    let primitives = Primitives {
        quads: quads.iter().map(|q| Quad::new(*q)).collect(),
        slots: vec![0; quads.len()],
        ..Primitives::default()
    };
    Geometry::build(primitives, accel)
}

/// The faces of the cube [−1, 1]³, seen from within.
pub(super) fn cube_faces() -> [[Vec3; 4]; 6] {
    std::array::from_fn(|i| {
        let (axis, sign) = (i / 2, if i % 2 == 0 { 1.0 } else { -1.0 });
        let [u, v, w] = [1, 2, 0].map(|k| Vec3::AXES[(axis + k) % 3]);
        let v = v * -sign;
        let corner = |a: f32, b: f32| w * sign + u * a + v * b;
        [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ]
    })
}

/// A parallelogram by its plane and 0 < s, t < 1 in f32; the fourth corner is not looked at.
pub(super) fn naive_quad([a, b, _, d]: [Vec3; 4], ray: &Ray) -> Option<f32> {
    let (e1, e2) = (b - a, d - a);
    let n = e1.cross(e2);
    let t = (a - ray.origin).dot(n) / ray.dir.dot(n);
    let p = ray.at(t) - a;
    let (s, r) = (
        p.cross(e2).dot(n) / n.length_squared(),
        e1.cross(p).dot(n) / n.length_squared(),
    );
    (t > 0.0 && s > 0.0 && s < 1.0 && r > 0.0 && r < 1.0).then_some(t)
}

/// Rays from points within to points on the quads' edges, vertices and insides.
fn rays(quads: &[[Vec3; 4]], center: Vec3, size: f32, n: usize, rng: &mut Rng) -> Vec<Ray> {
    (0..n)
        .map(|i| {
            let [a, b, c, d] = quads[rng.below(quads.len())];
            let target = match i % 4 {
                0 => a,
                1 => a.lerp(b, rng.unit()),
                2 => c.lerp(d, rng.unit()),
                _ => a
                    .lerp(b, rng.unit())
                    .lerp(d.lerp(c, rng.unit()), rng.unit()),
            };
            let origin = center + size * rng.cube();
            Ray::new(origin, toward(origin, target))
        })
        .collect()
}

/// The Cornell box as measured in 1984, closed towards the camera.
pub(super) fn cornell_faces() -> [[Vec3; 4]; 6] {
    let p = Vec3::new;
    [
        [
            p(552.8, 0., 0.),
            p(0., 0., 0.),
            p(0., 0., 559.2),
            p(549.6, 0., 559.2),
        ],
        [
            p(556., 548.8, 0.),
            p(556., 548.8, 559.2),
            p(0., 548.8, 559.2),
            p(0., 548.8, 0.),
        ],
        [
            p(549.6, 0., 559.2),
            p(0., 0., 559.2),
            p(0., 548.8, 559.2),
            p(556., 548.8, 559.2),
        ],
        [
            p(0., 0., 559.2),
            p(0., 0., 0.),
            p(0., 548.8, 0.),
            p(0., 548.8, 559.2),
        ],
        [
            p(552.8, 0., 0.),
            p(549.6, 0., 559.2),
            p(556., 548.8, 559.2),
            p(556., 548.8, 0.),
        ],
        [
            p(0., 0., 0.),
            p(552.8, 0., 0.),
            p(556., 548.8, 0.),
            p(0., 548.8, 0.),
        ],
    ]
}

fn cornell() -> Vec<Figure> {
    let quads = cornell_faces();
    let mut rng = Rng(1);
    let rays = rays(
        &quads,
        Vec3::new(275.0, 270.0, 280.0),
        250.0,
        100_000,
        &mut rng,
    );
    let escaped = match scene(&quads) {
        Ok(scene) => rays
            .iter()
            .filter(|ray| scene.intersect(ray).is_none())
            .count(),
        Err(_) => rays.len(),
    };
    let naive = |ray: &&Ray| quads.iter().all(|q| naive_quad(*q, ray).is_none());
    let [a, b, c, d] = quads[4];
    let gap = ((a - b) + (c - d)).length();
    let mut figures = vec![
        Figure {
            what: "corner of the left wall off a parallelogram, units",
            naive: None,
            lightbox: if Quad::is_parallelogram(&quads[4]) {
                0.0
            } else {
                f64::from(gap)
            },
            bound: Bound::Within {
                truth: 3.2,
                tolerance: 1e-3,
            },
        },
        Figure::none(
            "rays of 100000 that escape the closed box",
            Some(rays.iter().filter(naive).count()),
            escaped,
        ),
    ];
    figures.extend(cornell_furnace().figures(
        "deviation from 2 of the box whose walls emit 1 and reflect ½, critical distances",
        None,
        0.05,
    ));
    figures
}

/// The closed box with walls that emit 1 and reflect ½, which shows 2 everywhere.
fn cornell_furnace() -> Comparisons {
    let corners = |face: [Vec3; 4]| {
        face.map(|p| format!("[{}, {}, {}]", p.x, p.y, p.z))
            .join(", ")
    };
    let walls: String = cornell_faces()
        .map(|face| trial::quad("wall", &corners(face)))
        .concat();
    let scene = trial::scene(&format!(
        "{walls}
[camera]
eye = [278, 273, 50]
target = [400, 200, 300]
fov = 90
[render]
width = 8
height = 8
[[material]]
name = 'wall'
albedo = [0.5, 0.5, 0.5]
emission = [1, 1, 1]
"
    ));
    let mut comparisons = Comparisons::default();
    for method in Method::ALL {
        let means = trial::replicates(&scene, |s| {
            (s.method, s.samples, s.depth) = (*method, 50, UNLIMITED);
        });
        comparisons.mean(&means, 2.0);
    }
    comparisons
}

fn cube() -> Vec<Figure> {
    let faces = cube_faces();
    let mut rng = Rng(2);
    let rays = rays(&faces, Vec3::ZERO, 0.9, 100_000, &mut rng);
    let naive = rays
        .iter()
        .filter(|ray| faces.iter().all(|q| naive_quad(*q, ray).is_none()));
    let escaped = |accel: &AccelKind| {
        let geometry = geometry(&faces, *accel);
        rays.iter().filter(|r| cast(&geometry, r).is_none()).count()
    };
    let mut figures = vec![Figure::none(
        "rays of 100000 that escape",
        Some(naive.count()),
        AccelKind::ALL.iter().map(escaped).sum(),
    )];
    figures.extend(view_factors(&faces).figures(
        "largest deviation of view factors, ΣF = 1 among them, critical distances",
        None,
        0.05,
    ));
    figures
}

/// View factors of the first face: 0.1998249 to the one opposite, 0.2000438 to the four at its
/// sides (Howell, C-11 and C-14), none to itself, 1 to all.
fn view_factors(faces: &[[Vec3; 4]; 6]) -> Comparisons {
    let geometry = geometry(faces, AccelKind::Auto);
    let first = geometry.primitives().quads[0];
    let frame = Frame::around(first.normal());
    let share = |counts: &dyn Fn(Option<u32>) -> bool, seed: u64| {
        const RAYS: u32 = 8192;
        let mut rng = Rng::new(seed);
        let mut seen = 0u32;
        for _ in 0..RAYS {
            let point = SurfacePoint::of_quad(&first, rng.unit(), rng.unit());
            let w = warp::cosine_hemisphere([rng.unit(), rng.unit()]);
            let w = frame.world_from_local(w).normalize();
            let hit = cast(&geometry, &Ray::new(point.leave(w), w));
            seen += u32::from(counts(hit.map(|hit| hit.prim)));
        }
        f64::from(seen) / f64::from(RAYS)
    };
    let mut comparisons = Comparisons::default();
    for face in 1..6 {
        let estimates = Replicates::of(|seed| share(&|id| id == Some(face), seed));
        let truth = if face == 1 { 0.199_824_9 } else { 0.200_043_8 };
        comparisons.mean(&estimates, truth);
    }
    let all = Replicates::of(|seed| share(&|id| id.is_some_and(|id| id != 0), seed));
    comparisons.mean(&all, 1.0);
    comparisons
}

fn diagonal() -> Vec<Figure> {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
    let [a, b, c, d] = corners;
    let (mut wrong, mut wrong_naive) = (0, 0);
    for i in 0..=1024 {
        let x = i as f32 / 1024.0;
        let ray = Ray::new(Vec3::new(x, x, 1.0), -Vec3::Z);
        let sheared = crate::shape::ShearedRay::new(&ray);
        let halves = [[a, b, c], [a, c, d]];
        let hits = halves
            .iter()
            .filter(|t| sheared.triangle(**t, ray.t_max).is_some());
        wrong_naive += usize::from(hits.count() != 1);
        for accel in AccelKind::ALL {
            let geometry = geometry(&[corners], *accel);
            let Some(hit) = cast(&geometry, &ray) else {
                wrong += 1;
                continue;
            };
            // Nothing more beyond the first hit, and nothing at all but the quad.
            let point = geometry.primitives().surface_point(&ray, &hit);
            let onward = Ray::new(point.leave(ray.dir), ray.dir);
            let one = hit.t == 1.0 && cast(&geometry, &onward).is_none();
            wrong += usize::from(!one || geometry.occluded(&ray, hit.prim));
            wrong += usize::from(!geometry.occluded(&ray, NOTHING));
        }
    }
    vec![Figure::none(
        "rays of 1025 along the diagonal with other than one hit (naive: two triangles)",
        Some(wrong_naive),
        wrong,
    )]
}

fn corners() -> Vec<Figure> {
    let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
    let cave = Vec3::new(0.25, 0.25, 0.0);
    let bad = [
        [a, c, b, d],
        [a, b, cave, d],
        [a, b, b, d],
        [a, a, a, a],
        [a, b, 2.0 * b, 3.0 * b],
        [a, b, c, Vec3::NAN],
        [a, b, c, Vec3::INFINITY],
    ];
    vec![
        Figure::none(
            "quads of 7 that are none and accepted",
            None,
            bad.iter().filter(|q| scene(&[**q]).is_ok()).count(),
        ),
        Figure::none(
            "squares refused",
            None,
            usize::from(scene(&[[a, b, c, d]]).is_err()),
        ),
    ]
}
