//! Rays against single shapes.

use glam::{DVec3, Vec3};
use lightbox_core::AccelKind;
use lightbox_core::geometry::{Geometry, Primitives};
use lightbox_core::math::Ray;
use lightbox_core::shape::{Quad, ShearedRay, Sphere};

use super::draw::{Draw, unit};

/// Half of the distance between 1 and the next f32.
const E: f64 = (f32::EPSILON * 0.5) as f64;

/// A ray at a shape given by a few points: from anywhere, often at one of them, along an axis or
/// with an end.
fn ray(draw: &mut Draw, points: &[Vec3], wild: bool) -> Ray {
    let origin = match draw.below(4) {
        0 => draw.of(points),
        1 if wild => draw.any_point(),
        _ => draw.point(12),
    };
    let dir = match draw.below(4) {
        0 => draw.direction(),
        1 if wild => draw.any_point(),
        2 => unit(draw.of(points) - origin),
        _ => unit(draw.of(points) * 0.5 + draw.of(points) * 0.25 + draw.of(points) * 0.25 - origin),
    };
    let t_max = match draw.below(4) {
        0 => draw.coordinate(12).abs(),
        1 if wild => draw.any().min(f32::MAX),
        _ => f32::MAX,
    };
    Ray { origin, dir, t_max }
}

/// Sphere, triangle and quad against rays. Any numbers give no hit or a finite distance in
/// (0, t_max]; moderate ones what f64 says, unless that is within the rounding errors of f32.
pub fn intersectors(bytes: &[u8]) {
    let mut draw = Draw::new(bytes);
    let wild = draw.below(3) == 0;
    let point = |draw: &mut Draw| {
        if wild {
            draw.any_point()
        } else {
            draw.point(12)
        }
    };
    match draw.below(3) {
        0 => {
            let center = point(&mut draw);
            let radius = if wild {
                draw.any()
            } else {
                draw.coordinate(12)
            }
            .abs();
            if !(radius > 0.0) {
                return; // Scenes have no others.
            }
            let sphere = Sphere { center, radius };
            let towards = [
                center,
                center + radius * draw.direction(),
                center + radius * Vec3::X,
            ];
            let ray = ray(&mut draw, &towards, wild);
            let t = in_range(sphere.intersect(&ray, ray.t_max), &ray);
            if !wild {
                check_sphere(&sphere, &ray, t);
            }
        }
        1 => {
            let triangle = [0; 3].map(|_| point(&mut draw));
            let ray = ray(&mut draw, &triangle, wild);
            let hit = ShearedRay::new(&ray).triangle(triangle, ray.t_max);
            let t = in_range(hit.map(|h| h.t), &ray);
            if let Some(h) = hit {
                assert!(
                    h.b1 >= 0.0 && h.b2 >= 0.0 && h.b1 + h.b2 <= 1.0 + 4.0 * f32::EPSILON,
                    "{h:?}"
                );
            }
            if !wild {
                check_triangle(triangle, &ray, t);
                check_invariance(triangle, &ray, t);
            }
        }
        _ => {
            let [a, b, c] = [0; 3].map(|_| point(&mut draw));
            let corners = [a, b, c, a + (c - b)];
            let ray = ray(&mut draw, &corners, wild);
            let quad = Quad::new(corners);
            let geometry = Geometry::build(
                Primitives {
                    quads: vec![quad],
                    ..Primitives::default()
                },
                AccelKind::Brute,
            );
            let hit = geometry.intersect(&ray, |_| false);
            let t = in_range(hit.map(|h| h.t), &ray);
            // As good as its two triangles.
            let sheared = ShearedRay::new(&ray);
            let halves = quad
                .triangles()
                .map(|half| sheared.triangle(half, ray.t_max));
            let nearest = halves.iter().flatten().map(|h| h.t).min_by(f32::total_cmp);
            if !wild {
                assert_eq!(
                    t.map(f32::to_bits),
                    nearest.map(f32::to_bits),
                    "{corners:?} {ray:?}"
                );
            }
            if let Some(h) = hit {
                let inside = |x: f32| (0.0..=1.0 + 4.0 * f32::EPSILON).contains(&x);
                assert!(inside(h.u) && inside(h.v), "{h:?}");
            }
        }
    }
}

fn in_range(t: Option<f32>, ray: &Ray) -> Option<f32> {
    if let Some(t) = t {
        assert!(t > 0.0 && t <= ray.t_max, "{t} on {ray:?}");
    }
    t
}

/// The roots in f64, known to `tolerance` in f32.
fn check_sphere(sphere: &Sphere, ray: &Ray, t: Option<f32>) {
    let (f, d, r) = (
        ray.origin.as_dvec3() - sphere.center.as_dvec3(),
        ray.dir.as_dvec3(),
        f64::from(sphere.radius),
    );
    let b = -f.dot(d) / d.length_squared();
    let l = (f + b * d).length();
    let slack = 32.0 * E * (f.length() + r);
    if l > r + slack {
        assert_eq!(t, None, "{sphere:?} {ray:?}: passes at {l}");
        return;
    }
    if l > r - slack {
        return; // f32 cannot tell.
    }
    let half_chord = ((r - l) * (r + l) / d.length_squared()).sqrt();
    let tolerance = slack * (1.0 + r / half_chord);
    let roots = [b - half_chord, b + half_chord];
    let t_max = f64::from(ray.t_max);
    match t.map(f64::from) {
        Some(t) => {
            assert!(
                roots.iter().any(|r| (r - t).abs() <= tolerance),
                "{sphere:?} {ray:?}: {t} for {roots:?}"
            );
            let nearer = roots[0] > tolerance && t > roots[0] + tolerance;
            assert!(!nearer, "{sphere:?} {ray:?}: {t} for {roots:?}");
        }
        None => {
            let missed = roots
                .iter()
                .any(|r| *r > tolerance && *r < t_max - tolerance);
            assert!(!missed, "{sphere:?} {ray:?}: none for {roots:?}");
        }
    }
}

/// The edge functions in f64 with a bound on their error in f32.
fn check_triangle(triangle: [Vec3; 3], ray: &Ray, t: Option<f32>) {
    let d = ray.dir.as_dvec3();
    let z = ray.dir.abs().max_position();
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    // Per vertex: sheared coordinates, and bounds on their errors.
    let sheared = triangle.map(|v| {
        let v = v.as_dvec3() - ray.origin.as_dvec3();
        let p = DVec3::new(
            v[x] - d[x] / d[z] * v[z],
            v[y] - d[y] / d[z] * v[z],
            v[z] / d[z],
        );
        let error = DVec3::new(
            v[x].abs() + (d[x] / d[z] * v[z]).abs(),
            v[y].abs() + (d[y] / d[z] * v[z]).abs(),
            p.z.abs(),
        );
        (p, 8.0 * E * error)
    });
    let edge = |i: usize, j: usize| {
        let ((p, dp), (q, dq)) = (sheared[i], sheared[j]);
        let e = q.x * p.y - q.y * p.x;
        let error = q.x.abs() * dp.y
            + dq.x * p.y.abs()
            + dq.x * dp.y
            + q.y.abs() * dp.x
            + dq.y * p.x.abs()
            + dq.y * dp.x;
        (e, error + 8.0 * E * e.abs())
    };
    let edges = [edge(1, 2), edge(2, 0), edge(0, 1)];
    let surely = |sign: f64| edges.iter().filter(|(e, error)| sign * e > *error).count();
    let (positive, negative) = (surely(1.0), surely(-1.0));
    if positive > 0 && negative > 0 {
        assert_eq!(t, None, "{triangle:?} {ray:?}: outside by {edges:?}");
    }
    if positive < 3 && negative < 3 {
        return; // Outside, or f32 cannot tell.
    }
    let det: f64 = edges.iter().map(|e| e.0).sum();
    let exact = (0..3).map(|i| edges[i].0 * sheared[i].0.z).sum::<f64>() / det;
    let depth = sheared.iter().map(|(p, _)| p.z.abs()).fold(0.0, f64::max);
    let tolerance = (0..3)
        .map(|i| edges[i].1 * (sheared[i].0.z - exact).abs())
        .sum::<f64>()
        / (det.abs() - edges.iter().map(|e| e.1).sum::<f64>())
        + 16.0 * E * depth;
    match t.map(f64::from) {
        Some(t) => assert!(
            (t - exact).abs() <= tolerance,
            "{triangle:?} {ray:?}: {t} for {exact}"
        ),
        None => {
            // Hits too near to be told from behind are left out when the triangle reaches there.
            let missed = exact > 64.0 * tolerance && exact < f64::from(ray.t_max) - tolerance;
            assert!(
                !missed,
                "{triangle:?} {ray:?}: none for {exact} ± {tolerance}"
            );
        }
    }
}

/// Scaled by a power of two the same bits come out; the order of the vertices decides nothing but
/// rounding; minus zero is zero; and a ray that leaves the hit does not come back, unless the
/// normal is too coarse to tell on which side it leaves.
fn check_invariance([a, b, c]: [Vec3; 3], ray: &Ray, t: Option<f32>) {
    for k in [-30, 11] {
        let s = 2f32.powi(k);
        let scaled = Ray {
            origin: ray.origin * s,
            dir: ray.dir,
            t_max: ray.t_max * s,
        };
        let hit = ShearedRay::new(&scaled).triangle([a * s, b * s, c * s], scaled.t_max);
        assert_eq!(
            hit.map(|h| h.t.to_bits()),
            t.map(|t| (t * s).to_bits()),
            "{ray:?} scaled by {s}"
        );
    }
    let unsigned = |v: Vec3| v + Vec3::ZERO; // −0 + 0 is +0.
    let plain = Ray {
        origin: unsigned(ray.origin),
        dir: unsigned(ray.dir),
        t_max: ray.t_max,
    };
    let hit = ShearedRay::new(&plain).triangle([a, b, c].map(unsigned), ray.t_max);
    assert_eq!(
        hit.map(|h| h.t.to_bits()),
        t.map(f32::to_bits),
        "{ray:?} without signs of zeros"
    );
    if ray.t_max == f32::MAX {
        for order in [[b, c, a], [c, a, b], [a, c, b], [c, b, a], [b, a, c]] {
            let hit = ShearedRay::new(ray).triangle(order, ray.t_max);
            // From within the plane, rounding decides whether that lies ahead.
            let reach = (a - ray.origin).abs().max((b - ray.origin).abs());
            let reach = f64::from(reach.max((c - ray.origin).abs()).max_element());
            let least = hit.map(|h| h.t).or(t).map_or(0.0, f64::from);
            let (origin, corner) = (ray.origin.as_dvec3(), a.as_dvec3());
            let n = (b.as_dvec3() - corner).cross(c.as_dvec3() - corner);
            let height = n.normalize_or(DVec3::INFINITY).dot(origin - corner).abs();
            assert!(
                hit.is_some() == t.is_some() || least.min(height) <= 64.0 * E * reach,
                "{order:?} {ray:?}: {hit:?} or {t:?}"
            );
        }
    }
    let geometry = Geometry::build(
        Primitives {
            triangles: vec![[a, b, c]].into(),
            ..Primitives::default()
        },
        AccelKind::Brute,
    );
    if let Some(hit) = geometry.intersect(ray, |_| false) {
        let point = geometry.primitives().surface_point(ray, &hit);
        for w in [ray.dir, -ray.dir, point.n, -point.n] {
            if f64::from(w.dot(point.n).abs()) <= 8.0 * E {
                continue;
            }
            let again = geometry.intersect(&Ray::new(point.leave(w), w), |_| false);
            assert_eq!(
                again,
                None,
                "{:?} {ray:?}: meets itself along {w}",
                [a, b, c]
            );
        }
    }
}
