//! Rays that are said to stop trees visit no more nodes and primitives than others, and paths in rooms where everything
//! shows everything take no more rays: what they take is counted, not timed.

use std::sync::atomic::AtomicBool;

use glam::Vec3;
use lightbox_core::geometry::{Geometry, Primitives};
use lightbox_core::lab::random::Rng;
use lightbox_core::math::Ray;
use lightbox_core::scene::boulder;
use lightbox_core::{AccelKind, Method};
use lightbox_tests::{view, written};

fn geometry(positions: &[Vec3], triangles: &[[u32; 3]], accel: AccelKind) -> Geometry {
    let corners = triangles.iter().map(|t| t.map(|v| positions[v as usize]));
    let primitives = Primitives {
        triangles: corners.collect::<Vec<_>>().into(),
        slots: vec![0; triangles.len()],
        ..Primitives::default()
    };
    Geometry::build(primitives, accel)
}

/// Steps that rays take on their own, and how many hit something; in one call they hit the same.
fn measure(geometry: &Geometry, rays: &[Ray]) -> (u64, usize) {
    let steps = rays.iter().map(|ray| geometry.traversal(ray, |_| false));
    let steps = steps.map(|taken| u64::from(taken.steps())).sum();
    let hit = |ray| geometry.intersect(ray, |_| false).is_some();
    let (found, mut together) = (rays.iter().filter(|ray| hit(ray)).count(), 0);
    let add = |_, hit: Option<_>| together += usize::from(hit.is_some());
    geometry.intersect_many(rays, |ray| *ray, |_| false, add);
    assert_eq!(found, together);
    (steps, found)
}

/// Groups of 1000 rays with one number that is none: in the origin, the direction or the reach.
#[test]
fn v06_rays_that_are_none_miss_and_take_no_more() {
    let (positions, triangles) = boulder(5000);
    let mut rng = Rng::new(6);
    let rays: Vec<Ray> = (0..1000)
        .map(|_| {
            let origin = 3.0 * rng.direction();
            Ray::new(origin, (0.5 * rng.cube() - origin).normalize())
        })
        .collect();
    let spoil = |part: usize, axis: usize, x: f32| -> Vec<Ray> {
        let spoilt = rays.iter().map(|ray| {
            let mut ray = *ray;
            match part {
                0 => ray.origin[axis] = x,
                1 => ray.dir[axis] = x,
                _ => ray.t_max = x,
            }
            ray
        });
        spoilt.collect()
    };
    for accel in [AccelKind::Brute, AccelKind::KdTree, AccelKind::Bvh] {
        let geometry = geometry(&positions, &triangles, accel);
        let (usual, hits) = measure(&geometry, &rays);
        assert!(hits > 500, "{hits}");
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for (part, axis) in (0..7).map(|i| (i / 3, i % 3)) {
                // A ray that goes on for ever is one.
                if part == 2 && x == f32::INFINITY {
                    continue;
                }
                let (steps, found) = measure(&geometry, &spoil(part, axis, x));
                assert_eq!(found, 0, "{accel} {part} {axis} {x}");
                assert!(
                    2 * steps <= 5 * usual,
                    "{accel} {part} {axis} {x}: {steps} {usual}"
                );
            }
        }
    }
}

/// Three million triangles over a grid, and rays along each axis: down onto corners, where planes
/// of the tree are, and across, over hills and through them.
#[test]
fn v11_rays_along_an_axis_take_no_more_on_a_heightfield() {
    const SIDE: u32 = 1226;
    let at = |i: u32| (i % SIDE, i / SIDE);
    let height = |x: u32, y: u32| {
        let (x, y) = (x as f32 * 0.021, y as f32 * 0.017);
        20.0 * (x.sin() * y.cos() + 0.3 * (3.1 * x + y).sin())
    };
    let positions: Vec<Vec3> = (0..SIDE * SIDE)
        .map(|i| (at(i).0, at(i).1))
        .map(|(x, y)| Vec3::new(x as f32, y as f32, height(x, y)))
        .collect();
    let corners = (0..SIDE * SIDE).filter(|i| at(*i).0 + 1 < SIDE && at(*i).1 + 1 < SIDE);
    let triangles: Vec<[u32; 3]> = corners
        .flat_map(|i| [[i, i + 1, i + 1 + SIDE], [i, i + 1 + SIDE, i + SIDE]])
        .collect();
    assert!(triangles.len() > 3_000_000);

    let mut rng = Rng::new(11);
    let mut along: Vec<Ray> = Vec::new();
    for _ in 0..5000 {
        let mut corner = || rng.below(SIDE as usize) as f32;
        let (x, y) = (corner(), corner());
        let z = 30.0 * rng.unit() - 5.0;
        along.extend([
            Ray::new(Vec3::new(x, y, 100.0), -Vec3::Z),
            Ray::new(Vec3::new(-1.0, y, z), Vec3::X),
            Ray::new(Vec3::new(x, -1.0, z), Vec3::Y),
        ]);
    }
    // From the same places, off by a thousandth.
    let askew: Vec<Ray> = along
        .iter()
        .map(|ray| Ray::new(ray.origin, (ray.dir + 1e-3 * rng.cube()).normalize()))
        .collect();
    for accel in [AccelKind::KdTree, AccelKind::Bvh] {
        let geometry = geometry(&positions, &triangles, accel);
        let ((steps, found), (usual, hits)) =
            (measure(&geometry, &along), measure(&geometry, &askew));
        assert!(found > 7000 && hits > 7000, "{found} {hits}");
        assert!(steps <= 3 * usual, "{accel}: {steps} {usual}");
    }
}

/// In a room of varnish each surface is an anchor and shows others.
#[test]
fn probes_do_not_multiply() {
    let mut text = r#"
[camera]
eye = [0, 0, 0.9]
target = [0, 0, 0]
fov = 60

[[material]]
name = "varnish"
albedo = [0.999, 0.999, 0.999]
mirror = 0.8

[[material]]
name = "lamp"
albedo = [0, 0, 0]
emission = [5, 5, 5]

[[sphere]]
material = "lamp"
center = [0, 0.7, 0]
radius = 0.1
"#
    .to_string();
    for (axis, at) in (0..6).map(|side| (side / 2, [-1, 1][side % 2])) {
        let corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(|[u, v]| {
            let mut corner = [at; 3];
            (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (u, v);
            corner
        });
        text += &format!("[[quad]]\nmaterial = \"varnish\"\ncorners = {corners:?}\n");
    }
    let scene = written(&text);
    let rays = [Method::Mis, Method::Caustics].map(|method| {
        let view = view(&scene, |s| {
            (s.width, s.height, s.depth) = (8, 8, 100);
            (s.method, s.samples) = (method, 2);
        });
        let work = view.render(&view.film(), 2, &AtomicBool::new(false));
        work.rays as f64 / work.paths as f64
    });
    assert!(rays[1] < 15.0 * rays[0], "{rays:?}");
}
