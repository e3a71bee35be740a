//! Triangles: cracks, edges, degenerate and extreme shapes.

use glam::{Quat, Vec3};

use super::input::{Triangle, all, cast, globe, toward, trees};
use super::naive::{self, Edges};
use super::random::Rng;
use super::{Case, Check, Figure, pictures, slivers};
use crate::geometry::SurfacePoint;
use crate::math::Ray;
use crate::shape::{ShearedRay, edge, triangle_normal};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "T01",
        title: "the edge between two triangles",
        failure: "With strict edges, or rounding of its own in each triangle, rays through a shared \
                  edge find neither.",
        cure: "Edge functions that are each other's exact negative in the two triangles, edges \
               closed, zeros decided in f64 (Woop, Benthin & Wald 2013).",
        check: Check::Probe(shared_edge),
        scene: None,
        picture: None,
    },
    Case {
        id: "T02",
        title: "the diagonal of a square",
        failure: "A ray down the middle of a square lies on the diagonal, and with strict edges \
                  misses both halves.",
        cure: "Edges belong to their triangles.",
        check: Check::Probe(diagonal),
        scene: None,
        picture: Some(pictures::edges),
    },
    Case {
        id: "T03",
        title: "rays at the vertices of a closed mesh",
        failure: "Six triangles round a vertex, each with its own rounding, leave pinholes.",
        cure: "As T01: the vertex's shear is the same in all of them.",
        check: Check::Probe(vertices),
        scene: None,
        picture: None,
    },
    Case {
        id: "T04",
        title: "a closed mesh far from the origin",
        failure: "At coordinates of 10⁵ an ulp is 1/128, and cracks grow with it.",
        cure: "Vertices are taken relative to the ray first; boxes are met conservatively.",
        check: Check::Probe(far_mesh),
        scene: None,
        picture: None,
    },
    Case {
        id: "T05",
        title: "a triangle behind the ray",
        failure: "Without a test of t it is hit at −1.",
        cure: "0 < t ≤ t_max.",
        check: Check::Probe(behind),
        scene: None,
        picture: None,
    },
    Case {
        id: "T06",
        title: "a ray in the triangle's plane",
        failure: "The determinant is 0: 1/0, then NaN, which passes a test that asks for < 0.",
        cure: "A determinant of 0 is no hit.",
        check: Check::Probe(in_plane),
        scene: None,
        picture: None,
    },
    Case {
        id: "T07",
        title: "triangles without area",
        failure: "Collinear or repeated vertices give weights of rounding noise, which may agree.",
        cure: "f64 edge functions see the 0; what rounding of the vertices makes of a line is a \
               sliver that is hit within its box or not at all.",
        check: Check::Probe(slivers::degenerate),
        scene: None,
        picture: None,
    },
    Case {
        id: "T08",
        title: "minute triangles",
        failure: "A test of the squared area, or a product of edges, underflows at edges of 10⁻¹².",
        cure: "No absolute test; weights and t in f64.",
        check: Check::Probe(slivers::minute),
        scene: None,
        picture: None,
    },
    Case {
        id: "T09",
        title: "huge triangles",
        failure: "At edges of 10²⁰ the determinant is ∞, so they are missed, and as lights have no pdf.",
        cure: "Coordinates beyond 10¹⁸ are refused at load; up to there hits scale bit for bit.",
        check: Check::Probe(slivers::huge),
        scene: None,
        picture: None,
    },
    Case {
        id: "T10",
        title: "slivers at a grazing angle",
        failure: "A nearly degenerate triangle is hit far beyond its vertices (embree issue 387: at \
                  12291, all vertices within 600).",
        cure: "t is an average of the vertices' depths, with weights of one sign.",
        check: Check::Probe(slivers::slivers),
        scene: None,
        picture: Some(pictures::sliver),
    },
    Case {
        id: "T11",
        title: "the order of vertices",
        failure: "Fused multiply-add breaks e(a,b) = −e(b,a): cracks, and hits that depend on the \
                  instruction set (embree issue 423).",
        cure: "No contraction; the order of vertices changes no hit.",
        check: Check::Probe(vertex_order),
        scene: None,
        picture: None,
    },
    Case {
        id: "T12",
        title: "rays that start on a triangle",
        failure: "The hit point is off the plane by rounding, and the ray finds its own triangle at \
                  t ≈ 10⁻⁷.",
        cure: "The start is moved beyond the rounding of the hit point, and in f64 the plane has to \
               lie ahead of it.",
        check: Check::Probe(slivers::leaving),
        scene: None,
        picture: None,
    },
    Case {
        id: "T13",
        title: "what a hit says",
        failure: "u and v swapped or scaled, normals flipped.",
        cure: "Barycentrics of the second and third vertex, normals by the order of vertices.",
        check: Check::Probe(answers),
        scene: None,
        picture: None,
    },
];

pub(super) const CORNER: Triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];

pub(super) fn hit(triangle: Triangle, ray: &Ray) -> Option<f32> {
    ShearedRay::new(ray)
        .triangle(triangle, ray.t_max)
        .map(|hit| hit.t)
}

/// Rays that miss, over all accelerators.
fn missed(triangles: &[Triangle], rays: &[Ray]) -> usize {
    all(triangles)
        .iter()
        .map(|g| rays.iter().filter(|ray| cast(g, ray).is_none()).count())
        .sum()
}

fn missed_naively(triangles: &[Triangle], rays: &[Ray], edges: Edges) -> usize {
    let lost = |ray: &&Ray| naive::nearest(triangles, ray, edges).is_none();
    rays.iter().filter(lost).count()
}

fn shared_edge() -> Vec<Figure> {
    let axis = Vec3::ONE.normalize();
    let turn = Quat::from_axis_angle(axis, std::f32::consts::FRAC_PI_2);
    let [a, b, c, d] =
        [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y].map(|p| turn * (p - 0.5 * Vec3::ONE));
    let triangles = [[a, b, c], [a, c, d]];
    let (middle, n) = (0.5 * (a + c), triangle_normal([a, b, d]));
    let frame = crate::math::Frame::around(n);
    let rays: Vec<Ray> = (0..1024)
        .map(|i| {
            let u = [i % 32, i / 32].map(|k| (k as f32 + 0.5) / 32.0);
            let w = frame.world_from_local(crate::math::warp::cosine_hemisphere(u));
            let origin = middle + w;
            Ray::new(origin, toward(origin, middle))
        })
        .collect();
    let found = missed(&triangles, &rays);
    [Edges::Strict, Edges::Closed]
        .into_iter()
        .zip([
            "rays of 1024 through the edge that miss (naive: strict edges)",
            "rays of 1024 through the edge that miss (naive: Möller & Trumbore)",
        ])
        .map(|(edges, what)| {
            let naive = missed_naively(&triangles, &rays, edges);
            Figure::none(what, Some(naive), found)
        })
        .collect()
}

fn diagonal() -> Vec<Figure> {
    let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
    let triangles = [[a, b, c], [a, c, d]];
    let ray = Ray::new(Vec3::new(0.5, 0.5, 1.0), -Vec3::Z);
    let wrong = triangles
        .iter()
        .filter(|t| hit(**t, &ray) != Some(1.0))
        .count();
    let naive = triangles
        .iter()
        .filter(|t| naive::triangle(**t, &ray, Edges::Strict).is_none())
        .count();
    vec![Figure::none(
        "halves of 2 that miss t = 1",
        Some(naive),
        wrong,
    )]
}

const MILLION: usize = 1_000_000;

/// Leaks per million of `rays(rng)` out of a closed mesh: naively, by the first 10⁴ of them, and
/// over all trees, which share a million.
fn leaks(triangles: &[Triangle], mut ray: impl FnMut() -> Ray) -> Figure {
    let sample: Vec<Ray> = (0..10_000).map(|_| ray()).collect();
    let naive = missed_naively(triangles, &sample, Edges::Closed) * (MILLION / sample.len());
    let trees = trees(triangles);
    let mut lost = 0;
    for i in 0..MILLION {
        lost += usize::from(cast(&trees[i % trees.len()], &ray()).is_none());
    }
    Figure::none("leaks per million rays", Some(naive), lost)
}

fn vertices() -> Vec<Figure> {
    let mut rng = Rng(3);
    let star = globe(Vec3::ZERO, [16, 16], || 1.0 + 5.0 * rng.unit());
    let mut rng = Rng(4);
    vec![leaks(&star, || {
        let target = star[rng.below(star.len())][rng.below(3)];
        let origin = 0.1 * rng.cube();
        Ray::new(origin, toward(origin, target))
    })]
}

fn far_mesh() -> Vec<Figure> {
    let center = Vec3::new(148_376.0, 1234.0, -223_423.0);
    let mut rng = Rng(5);
    let mut figures = Vec::new();
    for (segments, what) in [
        (50, "leaks per million rays, 50 segments"),
        (200, "leaks per million rays, 200 segments"),
    ] {
        let sphere = globe(center, [segments, segments], || 2.0);
        let trees = trees(&sphere);
        let mut lost = 0;
        for i in 0..MILLION {
            let target = sphere[rng.below(sphere.len())];
            let origin = center + rng.cube();
            let target = if i % 2 == 0 {
                target[rng.below(3)]
            } else {
                target[0].lerp(target[1], rng.unit())
            };
            let ray = Ray::new(origin, toward(origin, target));
            lost += usize::from(cast(&trees[i % trees.len()], &ray).is_none());
        }
        figures.push(Figure::none(what, None, lost));
    }
    figures
}

fn behind() -> Vec<Figure> {
    let ray = Ray::new(Vec3::new(0.25, 0.25, -1.0), -Vec3::Z);
    let naive = naive::triangle(CORNER, &ray, Edges::Closed);
    vec![Figure::none(
        "hits behind the origin",
        Some(usize::from(naive.is_some())),
        usize::from(hit(CORNER, &ray).is_some()),
    )]
}

fn in_plane() -> Vec<Figure> {
    let ray = Ray::new(Vec3::new(-1.0, 0.25, 0.0), Vec3::X);
    let naive = naive::triangle(CORNER, &ray, Edges::Closed);
    vec![Figure::none(
        "hits, NaN included",
        Some(usize::from(naive.is_some())),
        usize::from(hit(CORNER, &ray).is_some()),
    )]
}

fn vertex_order() -> Vec<Figure> {
    // The edge function with and without a fused multiply-add.
    let fused = |p: [f32; 3], q: [f32; 3]| q[0].mul_add(p[1], -(q[1] * p[0]));
    let mut rng = Rng(10);
    let mut broken = [0; 2];
    for _ in 0..MILLION {
        let [p, q] = [0; 2].map(|_| rng.cube().to_array());
        broken[0] += usize::from(fused(p, q) != -fused(q, p));
        broken[1] += usize::from(edge(p, q) != -edge(q, p));
    }
    let mut differing = 0;
    for i in 0..200_000 {
        let triangle = [0; 3].map(|_| rng.cube());
        let origin = 3.0 * rng.cube();
        // At vertices and edges as well as insides.
        let target = match i % 3 {
            0 => triangle[0],
            1 => triangle[0].lerp(triangle[1], rng.unit()),
            _ => rng.point_of(triangle),
        };
        let ray = Ray::new(origin, toward(origin, target));
        let [a, b, c] = triangle;
        let orders = [[b, c, a], [c, a, b], [a, c, b], [c, b, a], [b, a, c]];
        let expected = hit(triangle, &ray).is_some();
        differing += orders
            .iter()
            .filter(|t| hit(**t, &ray).is_some() != expected)
            .count();
    }
    vec![
        Figure::none(
            "hits of 200000 that depend on the order of vertices",
            None,
            differing,
        ),
        Figure::none(
            "edge functions of 10⁶ that are not the negative of the other way (naive: fused)",
            Some(broken[0]),
            broken[1],
        ),
    ]
}

fn answers() -> Vec<Figure> {
    let origin = -Vec3::Z;
    let mut worst = 0.0f32;
    let mut flipped = 0;
    for i in 0..256 {
        let (u, v) = ((i % 16) as f32 / 16.0, (i / 16) as f32 / 16.0);
        let (u, v) = (u * (1.0 - v) + 1e-3, v * 0.99 + 1e-3);
        if u + v > 1.0 {
            continue;
        }
        let target = Vec3::new(u, v, 0.0);
        let ray = Ray::new(origin, toward(origin, target));
        let Some(found) = ShearedRay::new(&ray).triangle(CORNER, f32::INFINITY) else {
            worst = f32::NAN;
            continue;
        };
        let point = SurfacePoint::of_triangle(CORNER, [found.b1, found.b2]);
        flipped += usize::from(point.n != Vec3::Z);
        for error in [
            (found.t - (target - origin).length()).abs(),
            (found.b1 - u).abs(),
            (found.b2 - v).abs(),
            (ray.at(found.t) - point.p).abs().max_element(),
        ] {
            // max would drop a NaN.
            if !(error <= worst) {
                worst = error;
            }
        }
    }
    vec![
        Figure::at_most(
            "largest error of t, u, v and the point, ulp of 1",
            None,
            f64::from(worst / f32::EPSILON),
            16.0,
        ),
        Figure::none("normals that are not +z", None, flipped),
    ]
}
