//! Walking accelerators: zeros, NaN, planes, ends.

use glam::Vec3;

use super::input::{
    NOTHING, Triangle, all, as_brute_force, bits, build, cast, differences, differences_among,
    globe, grid, icosphere, rays_at, stairs, toward,
};
use super::random::Rng;
use super::{Case, Check, Figure, naive, pictures, ray_ends};
use crate::geometry::{Geometry, Primitive, Primitives};
use crate::math::{Aabb, Ray};
use crate::settings::AccelKind;
use crate::shape::Sphere;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "V01",
        title: "a direction with −0",
        failure: "−0 ≥ 0, but 1/−0 = −∞: the order of children and the distances of planes \
                  contradict each other, and everything is missed (madmann91/bvh issue 20, tinybvh \
                  pull request 282).",
        cure: "The order follows the sign of 1/d; −0 and +0 give the same hits.",
        check: Check::Probe(negative_zero),
        scene: None,
        picture: Some(pictures::negative_zero),
    },
    Case {
        id: "V02",
        title: "a ray that starts in a split plane",
        failure: "(s − o)/d is 0/0: with NaN for a bound, the box is missed (embree pull request 589).",
        cure: "1/d is limited to a finite number, so nothing becomes NaN; the ray is a beam that \
               meets such planes everywhere.",
        check: Check::Probe(in_split_plane),
        scene: None,
        picture: None,
    },
    Case {
        id: "V03",
        title: "a hit beyond the cell",
        failure: "A triangle that reaches into several cells is hit in a later one, and a nearer \
                  hit there is never looked for.",
        cure: "The walk goes on to every cell that begins before the nearest hit.",
        check: Check::Probe(beyond_the_cell),
        scene: None,
        picture: None,
    },
    Case {
        id: "V04",
        title: "rays in the plane between two leaves",
        failure: "t of the plane equals the interval's end, and < visits neither child.",
        cure: "Ties visit both.",
        check: Check::Probe(between_leaves),
        scene: None,
        picture: None,
    },
    Case {
        id: "V05",
        title: "flat boxes, scalar and SIMD",
        failure: "0 · ∞ is NaN in the slab test; f32::max ignores it and maxps returns its second \
                  operand, so scalar and SIMD code disagree.",
        cure: "No NaN arises; every kernel is compared with brute force bit for bit.",
        check: Check::Probe(flat_boxes),
        scene: None,
        picture: None,
    },
    Case {
        id: "V06",
        title: "rays of NaN and infinity",
        failure: "Hangs, panics, or hits at NaN.",
        cure: "Such rays hit nothing, found out before the walk.",
        check: Check::Probe(ray_ends::no_rays),
        scene: None,
        picture: None,
    },
    Case {
        id: "V07",
        title: "the ends of a ray",
        failure: "Off by one at t = t_max; hits at t_max ≤ 0.",
        cure: "0 < t ≤ t_max, for every shape in every accelerator.",
        check: Check::Probe(ray_ends::ends),
        scene: None,
        picture: None,
    },
    Case {
        id: "V08",
        title: "a chain 64 deep",
        failure: "Points at ever halved distances make a tree as deep as there are points, and the walk's stack \
                  overflows.",
        cure: "The builder's greatest depth is the stack's capacity.",
        check: Check::Probe(deep),
        scene: None,
        picture: None,
    },
    Case {
        id: "V09",
        title: "any hit and nearest hit",
        failure: "Two walks that are written twice, and disagree.",
        cure: "One walk for both.",
        check: Check::Probe(any_and_nearest),
        scene: None,
        picture: None,
    },
    Case {
        id: "V10",
        title: "boxes met at a grazing angle",
        failure: "The triangle would be hit, but rounding in the slab test misses its box: a hole \
                  (Ize 2013).",
        cure: "The ray is a beam as wide as all rounding together.",
        check: Check::Probe(grazing),
        scene: None,
        picture: None,
    },
    Case {
        id: "V11",
        title: "rays along an axis",
        failure: "Reciprocals of 0 keep every cell in play: 7 s instead of 10 ms.",
        cure: "A beam of finite width; rays along an axis visit no more than others, and on three million \
               triangles take no longer.",
        check: Check::Test(ALONG_AN_AXIS),
        scene: None,
        picture: None,
    },
    Case {
        id: "V12",
        title: "quantised boxes",
        failure: "Child boxes on a coarse grid, rounded inward, lose what touches their faces.",
        cure: "Nothing is quantised.",
        check: Check::Absent("split planes and boxes are stored as f32, boxes rounded outward."),
        scene: None,
        picture: None,
    },
];

const ALONG_AN_AXIS: &str =
    "tests/tests/steps.rs::v11_rays_along_an_axis_take_no_more_on_a_heightfield";

/// Rays along and across the lattice of a grid, each with the zeros of a direction as +0 and −0.
fn lattice_rays(n: usize) -> Vec<[Ray; 2]> {
    let mut rays = Vec::new();
    for axis in 0..3 {
        for i in 0..(n + 1) * (n + 1) {
            let at = [(i % (n + 1)) as f32, (i / (n + 1)) as f32];
            for (along, start) in [(-1.0, n as f32 + 1.0), (1.0, -1.0), (1.0, 0.0)] {
                let turned = |[x, y, z]: [f32; 3]| {
                    Vec3::from_array([0, 1, 2].map(|k| [x, y, z][(axis + k) % 3]))
                };
                rays.push([0.0, -0.0].map(|zero| {
                    Ray::new(turned([at[0], at[1], start]), turned([zero, zero, along]))
                }));
            }
        }
    }
    rays
}

fn negative_zero() -> Vec<Figure> {
    let triangle = |z: f32| [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| p.with_z(z));
    let mut triangles = vec![triangle(1.0), triangle(2.1)];
    triangles.extend(grid(6));
    let mut rays = lattice_rays(6);
    let origin = Vec3::new(0.25, 0.25, 0.0);
    rays.push([
        Ray::new(origin, Vec3::Z),
        Ray::new(origin, Vec3::new(0.0, -0.0, 1.0)),
    ]);
    let found: usize = all(&triangles)
        .iter()
        .map(|g| {
            let unlike = |[a, b]: &&[Ray; 2]| bits(cast(g, a)) != bits(cast(g, b));
            rays.iter().filter(unlike).count()
        })
        .sum();
    let tree = naive::Tree::of(&triangles, 8);
    let naive = rays.iter().filter(|[a, b]| {
        let t = |ray| tree.cast(&triangles, ray).map(|hit| hit.0);
        t(a) != t(b)
    });
    let rays: Vec<Ray> = rays.iter().flatten().copied().collect();
    // As reported: two triangles and nothing else, the last two rays.
    let reported = all(&triangles[..2]);
    let one_ahead = |ray: &&Ray| {
        reported
            .iter()
            .all(|g| cast(g, ray).is_some_and(|h| h.t == 1.0))
    };
    let missed = rays[rays.len() - 2..].iter().filter(|ray| !one_ahead(ray));
    vec![
        Figure::none(
            "rays of 2 that miss the triangle 1 ahead",
            None,
            missed.count(),
        ),
        Figure::none("rays that −0 changes", Some(naive.count()), found),
        as_brute_force(differences(&triangles, &rays)),
    ]
}

fn in_split_plane() -> Vec<Figure> {
    // The camera's ray down the middle of a symmetric box, and the like.
    let mut triangles = icosphere(2);
    triangles.extend(grid(4));
    let mut rng = Rng(2);
    let mut rays = Vec::new();
    for _ in 0..2000 {
        let mut origin = (rng.cube() * 8.0).round() * 0.5;
        let mut dir = rng.direction();
        let axis = rng.below(3);
        dir[axis] = [0.0, -0.0][rng.below(2)];
        if rng.below(2) == 0 {
            origin[axis] = 0.0;
        }
        rays.push(Ray::new(origin, dir.normalize()));
    }
    let bounds = Aabb::of_points([Vec3::ZERO, Vec3::splat(4.0)]);
    let inside = [0.0, 4.0].into_iter().flat_map(|x| {
        [0.0, -0.0].map(|zero| Ray::new(Vec3::new(x, 2.0, -1.0), Vec3::new(zero, 0.0, 1.0)))
    });
    let naive = inside.filter(|ray| !naive::slabs(&bounds, ray)).count();
    vec![Figure::none(
        "answers that differ from brute force (naive: boxes of 4 missed)",
        Some(naive),
        differences(&triangles, &rays),
    )]
}

fn beyond_the_cell() -> Vec<Figure> {
    // A long triangle behind; small ones and spheres before it further along the ray's cells.
    let scene = || {
        let mut rng = Rng(3);
        let mut triangles = vec![[
            Vec3::new(-9.0, -1.0, -1.0),
            Vec3::new(9.0, 1.0, 3.0),
            Vec3::new(9.0, -1.0, 3.0),
        ]];
        let mut spheres = Vec::new();
        for i in 0..60 {
            let center = Vec3::new(9.0 * rng.unit(), 0.5 * (rng.unit() - 0.5), 2.0 * rng.unit());
            if i % 2 == 0 {
                triangles.push([0; 3].map(|_| center + 0.2 * rng.cube()));
            } else {
                let radius = 0.1 * rng.unit() + 0.01;
                spheres.push(Sphere { center, radius });
            }
        }
        Primitives {
            slots: vec![0; triangles.len() + spheres.len()],
            triangles: triangles.into(),
            spheres,
            ..Primitives::default()
        }
    };
    let primitives = scene();
    let boxes: Vec<Aabb> = (0..primitives.len() as u32)
        .map(|id| primitives.bounds(id))
        .collect();
    let mut rng = Rng(33);
    let rays: Vec<Ray> = (0..4000)
        .map(|_| {
            let origin = Vec3::new(-10.0, rng.unit() - 0.5, -1.0 + rng.unit());
            let target = match primitives.get(rng.below(boxes.len()) as u32) {
                Primitive::Sphere(s) => s.center + 0.9 * s.radius * rng.cube(),
                Primitive::Triangle(t) => rng.point_of(t),
                Primitive::Quad(q) => q.corners()[0],
            };
            Ray::new(origin, toward(origin, target))
        })
        .collect();
    let tree = naive::Tree::build(&boxes, 8);
    let brute = Geometry::build(scene(), AccelKind::Brute);
    let naive = rays.iter().filter(|ray| {
        let sheared = crate::shape::ShearedRay::new(ray);
        let found = tree.walk(ray, (0.0, ray.t_max), &|id| match primitives.get(id) {
            Primitive::Sphere(sphere) => sphere.intersect(ray, ray.t_max),
            Primitive::Triangle(triangle) => sheared.triangle(triangle, ray.t_max).map(|h| h.t),
            Primitive::Quad(_) => None,
        });
        found.map(|hit| hit.0) != cast(&brute, ray).map(|hit| hit.t)
    });
    vec![Figure::none(
        "answers of 4000 that differ from brute force",
        Some(naive.count()),
        differences_among(&scene, &rays),
    )]
}

fn between_leaves() -> Vec<Figure> {
    let triangles = grid(8);
    let mut rays: Vec<Ray> = lattice_rays(8).into_iter().flatten().collect();
    rays.extend(rays_at(&triangles, 6000, &mut Rng(11)));
    let tree = naive::Tree::of(&triangles, 10);
    let brute = build(&triangles, AccelKind::Brute);
    let naive = rays.iter().filter(|ray| {
        tree.cast(&triangles, ray).map(|hit| hit.0) != cast(&brute, ray).map(|hit| hit.t)
    });
    vec![Figure::none(
        "answers that differ from brute force",
        Some(naive.count()),
        differences(&triangles, &rays),
    )]
}

fn flat_boxes() -> Vec<Figure> {
    let mut rng = Rng(5);
    let mut found = 0;
    let mut missed = 0;
    for axis in 0..3 {
        let triangles: Vec<Triangle> = rng
            .soup(200, 0.3)
            .iter()
            .map(|t| {
                let plane = (t[0].x * 4.0).round() * 0.25;
                t.map(|mut p| {
                    p[axis] = plane;
                    p
                })
            })
            .collect();
        let mut rays = rays_at(&triangles, 3000, &mut rng);
        for i in 0..1000 {
            // In the plane of a triangle, and straight at it along the other axes.
            let p = rng.point_of(triangles[i % triangles.len()]);
            let dir = Vec3::AXES[(axis + 1 + i % 2) % 3];
            rays.push(Ray::new(p - 3.0 * dir, dir));
            let bounds = Aabb::of_points(triangles[i % triangles.len()]);
            missed += usize::from(!naive::slabs(&bounds, &Ray::new(p - 3.0 * dir, dir)));
        }
        found += differences(&triangles, &rays);
    }
    vec![Figure::none(
        "answers that differ from brute force (naive: boxes of 3000 missed by rays in them)",
        Some(missed),
        found,
    )]
}

fn deep() -> Vec<Figure> {
    let mut triangles = Vec::new();
    for i in 0..100 {
        let corner =
            Vec3::splat(libm::ldexp(1.0, -i / 2) as f32 * if i % 2 == 0 { 1.0 } else { 0.7 });
        triangles.extend([[corner, corner * 1.25, corner * Vec3::new(1.25, 1.0, 1.5)]; 4]);
    }
    let rays = rays_at(&triangles, 3000, &mut Rng(15));
    vec![as_brute_force(differences(&triangles, &rays))]
}

fn any_and_nearest() -> Vec<Figure> {
    let mut rng = Rng(9);
    let sets = [
        rng.soup(500, 0.3),
        grid(6),
        stairs(20),
        icosphere(3),
        globe(Vec3::ZERO, [12, 12], || 1.0 + rng.unit()),
    ];
    let mut found = 0;
    let mut rng = Rng(10);
    for triangles in &sets {
        let rays = rays_at(triangles, 3000, &mut rng);
        for geometry in all(triangles) {
            let disagree =
                |ray: &&Ray| cast(&geometry, ray).is_some() != geometry.occluded(ray, NOTHING);
            found += rays.iter().filter(disagree).count();
        }
    }
    vec![Figure::none(
        "rays of 15000 on which they disagree",
        None,
        found,
    )]
}

fn grazing() -> Vec<Figure> {
    let mut rng = Rng(10);
    let mut triangles = Vec::new();
    for _ in 0..400 {
        // At corners of their boxes, and away from the origin, where rounding is coarse.
        let center = 100.0 * rng.cube();
        let size = 0.01 + rng.unit();
        triangles.push([
            center,
            center + size * rng.direction(),
            center + size * rng.direction(),
        ]);
    }
    let rays: Vec<Ray> = (0..20_000)
        .map(|i| {
            let triangle = triangles[rng.below(triangles.len())];
            let target = match i % 2 {
                0 => triangle[rng.below(3)],
                _ => triangle[0].lerp(triangle[1], rng.unit()),
            };
            let origin = target + 300.0 * rng.direction();
            Ray::new(origin, toward(origin, target))
        })
        .collect();
    let holes = rays.iter().filter(|ray| {
        let sheared = crate::shape::ShearedRay::new(ray);
        triangles.iter().any(|t| {
            sheared.triangle(*t, ray.t_max).is_some() && !naive::slabs(&Aabb::of_points(*t), ray)
        })
    });
    vec![Figure::none(
        "answers that differ from brute force (naive: hits of 20000 whose box is missed)",
        Some(holes.count()),
        differences(&triangles, &rays),
    )]
}
