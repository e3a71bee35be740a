//! Meshes as surfaces: closed ones, T-junctions, what lies in one plane.

use glam::{Quat, Vec3};

use super::input::{Triangle, bits, build, cast, icosphere, toward, trees};
use super::naive::{self, Edges};
use super::random::Rng;
use super::{Case, Check, Figure, pictures, quads};
use crate::math::Ray;
use crate::settings::AccelKind;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "M01",
        title: "no way out of a closed mesh",
        failure: "Rays along axes and at vertices slip out between 81920 triangles.",
        cure: "Watertight triangles in boxes that are met conservatively.",
        check: Check::Probe(closed),
        scene: None,
        picture: None,
    },
    Case {
        id: "M02",
        title: "T-junctions",
        failure: "A vertex in the middle of a neighbour's edge rounds off it: the crack is in the \
                  model.",
        cure: "None: what is not joined is not closed. The crack is as thin as rounding makes it.",
        check: Check::Probe(t_junction),
        scene: None,
        picture: None,
    },
    Case {
        id: "M03",
        title: "a lamp in the plane of the ceiling",
        failure: "At equal distance the first in the list wins: whether the lamp is lit depends on \
                  the order of the primitives (the measured Cornell box has this).",
        cure: "Emitters count as nearer by 2⁻²⁰ of the distance, else the lowest id wins.",
        check: Check::Probe(coplanar_lamp),
        scene: Some("builtin:lab/lamp-in-ceiling.toml"),
        picture: Some(pictures::lamp_in_ceiling),
    },
];

fn closed() -> Vec<Figure> {
    const RAYS: usize = 300_000;
    let mesh = icosphere(6);
    let mut rng = Rng(1);
    let mut ray = |i: usize| {
        let origin = 0.5 * rng.cube();
        let triangle = mesh[rng.below(mesh.len())];
        match i % 4 {
            0 => Ray::new(origin, Vec3::AXES[rng.below(3)] * [1.0, -1.0][rng.below(2)]),
            1 => Ray::new(origin, toward(origin, triangle[0])),
            2 => Ray::new(
                origin,
                toward(origin, triangle[0].lerp(triangle[1], rng.unit())),
            ),
            _ => Ray::new(origin, rng.direction()),
        }
    };
    let trees = trees(&mesh);
    let (mut lost, mut even) = (0, 0);
    for i in 0..RAYS {
        let tree = &trees[(i / 4) % trees.len()];
        let ray = ray(i);
        let Some(hit) = cast(tree, &ray) else {
            lost += 1;
            continue;
        };
        // The mesh is convex: one crossing, and nothing beyond.
        let point = tree.primitives().surface_point(&ray, &hit);
        even += usize::from(cast(tree, &Ray::new(point.leave(ray.dir), ray.dir)).is_some());
    }
    let lost_naive = (0..1000)
        .filter(|i| naive::nearest(&mesh, &ray(*i), Edges::Strict).is_none())
        .count();
    vec![
        Figure::none(
            "rays of 300000 that escape (naive: strict edges)",
            Some(lost_naive * RAYS / 1000),
            lost,
        ),
        Figure::none("rays of 300000 that cross twice", None, even),
    ]
}

fn t_junction() -> Vec<Figure> {
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 1.1);
    let p = |x: f32, y: f32| turn * Vec3::new(x, y, 0.5);
    let triangles: [Triangle; 3] = [
        [p(0.0, 0.0), p(2.0, 0.0), p(1.0, -1.0)],
        [p(0.0, 0.0), p(1.0, 0.0), p(0.5, 1.0)],
        [p(1.0, 0.0), p(2.0, 0.0), p(1.5, 1.0)],
    ];
    let mut rng = Rng(2);
    let mut lost = 0;
    const RAYS: usize = 1_000_000;
    let geometries: Vec<_> = AccelKind::ALL
        .iter()
        .map(|a| build(&triangles, *a))
        .collect();
    let eye = turn * Vec3::new(1.0, 0.0, 4.0);
    for i in 0..RAYS {
        let target = rng.point_of(triangles[i % 3]);
        let ray = Ray::new(eye, toward(eye, target));
        lost += usize::from(cast(&geometries[i % geometries.len()], &ray).is_none());
    }
    vec![Figure::at_most(
        "leaks per million rays over the surface",
        None,
        lost as f64,
        99.0,
    )]
}

fn coplanar_lamp() -> Vec<Figure> {
    let square = |half: f32, y: f32| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, z)| Vec3::new(278.0 + half * x, y, 280.0 + half * z))
    };
    let (ceiling, lamp, lowered) = (
        square(278.0, 548.8),
        square(65.0, 548.8),
        square(65.0, 548.799),
    );
    let rays: Vec<Ray> = (0..4096)
        .map(|i| {
            let (x, z) = ((i % 64) as f32 / 63.0, (i / 64) as f32 / 63.0);
            let target = Vec3::new(200.0 + 160.0 * x, 548.8, 200.0 + 160.0 * z);
            // From far below, nearly straight up, so that the lowered lamp covers the same rays.
            let origin = target.with_y(0.0);
            Ray::new(origin, toward(origin, target))
        })
        .collect();
    let (mut unlike, mut unlike_naive, mut differing) = (0, 0, 0);
    for accel in AccelKind::ALL {
        let first = quads::geometry(&[lamp, ceiling], *accel);
        let last = quads::geometry(&[ceiling, lamp], *accel);
        let low = quads::geometry(&[ceiling, lowered], *accel);
        for ray in &rays {
            let sees = |geometry: &crate::geometry::Geometry, id: u32| {
                geometry
                    .intersect(ray, |prim| prim == id)
                    .is_some_and(|hit| hit.prim == id)
            };
            let truth = sees(&low, 1);
            unlike += usize::from(sees(&first, 0) != truth) + usize::from(sees(&last, 1) != truth);
            let t = |hit: Option<crate::geometry::Hit>| bits(hit).map(|b| b.0);
            differing += usize::from(
                t(first.intersect(ray, |p| p == 0)) != t(last.intersect(ray, |p| p == 1)),
            );
            // Without a preference for emitters.
            let naive = cast(&last, ray).is_some_and(|hit| hit.prim == 1);
            unlike_naive += usize::from(naive != truth);
        }
    }
    vec![
        Figure::none(
            "rays of 4096 that see another lamp than one lowered by 10⁻³",
            Some(unlike_naive),
            unlike,
        ),
        Figure::none("distances that depend on the order", None, differing),
    ]
}
