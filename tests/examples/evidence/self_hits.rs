//! Rays that leave a surface, at any scale and far from the origin: none may find the point that
//! it comes from.

use lightbox_core::AccelKind;
use lightbox_core::geometry::{Geometry, Primitive, Primitives, SurfacePoint};
use lightbox_core::lab::random::Rng;
use lightbox_core::math::Ray;
use lightbox_core::shape::{Quad, Sphere};

const SCALES: [f32; 6] = [1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6];

/// The fixed offset that ray tracers start with, scene units.
const NAIVE: f32 = 1e-4;

pub fn run(count: u64, is_planted: bool) -> bool {
    println!(
        "{:<32}{:>12}{:>12}{:>14}",
        "shapes", "rays", "self-hits", "fixed offset"
    );
    let share = count.div_ceil(2 * SCALES.len() as u64);
    let mut all = 0;
    for (what, is_size) in [("of size", true), ("of size 1, at distance", false)] {
        for scale in SCALES {
            let (size, distance) = if is_size {
                (scale, scale)
            } else {
                (1.0, scale)
            };
            let geometry = Geometry::build(shapes(size, distance), AccelKind::Auto);
            let [hits, naive] = crate::sum(share, |rng, n| {
                let mut hits = [0; 2];
                for _ in 0..n {
                    let found = spawn(&geometry, rng, is_planted);
                    hits = [hits[0] + found[0], hits[1] + found[1]];
                }
                hits
            });
            all += hits;
            println!(
                "{:<32}{share:>12}{hits:>12}{:>14}",
                format!("{what} {scale:e}"),
                naive
            );
        }
    }
    all == 0
}

/// Triangles, quads and spheres about `size` large, `distance` from the origin.
fn shapes(size: f32, distance: f32) -> Primitives {
    let mut rng = Rng::new(7);
    let mut primitives = Primitives::default();
    for i in 0..60 {
        let center = distance * rng.direction() + size * rng.cube();
        let mut corner = || center + size * rng.cube();
        match i % 3 {
            0 => primitives.triangles.push([corner(), corner(), corner()]),
            1 => {
                let [a, b, c] = [corner(), corner(), corner()];
                primitives.quads.push(Quad::new([a, b, c, a + (c - b)]));
            }
            _ => primitives.spheres.push(Sphere {
                center,
                radius: size * (0.1 + rng.unit()),
            }),
        }
    }
    primitives
}

/// Hits a shape, leaves the hit to either side, and counts what is met of the place left: as
/// lightbox does it, and with a fixed offset.
fn spawn(geometry: &Geometry, rng: &mut Rng, is_planted: bool) -> [u64; 2] {
    let primitives = geometry.primitives();
    let id = rng.below(primitives.len()) as u32;
    let shape = primitives.get(id);
    let (target, reach) = match shape {
        Primitive::Triangle([a, b, c]) => {
            let u = lightbox_core::math::warp::triangle([rng.unit(), rng.unit()]);
            (a + u[0] * (b - a) + u[1] * (c - a), (b - a).length())
        }
        Primitive::Quad(quad) => {
            let [a, b, _, d] = quad.corners();
            (
                a + rng.unit() * (b - a) + rng.unit() * (d - a),
                (b - a).length(),
            )
        }
        Primitive::Sphere(s) => (s.center + 0.99 * s.radius * rng.direction(), s.radius),
    };
    let origin = target + reach * 10f32.powf(3.0 * rng.unit() - 1.0) * rng.direction();
    let ray = Ray::new(origin, (target - origin).normalize());
    let Some(hit) = geometry.intersect(&ray, |_| false) else {
        return [0; 2];
    };
    let mut point = primitives.surface_point(&ray, &hit);
    if is_planted {
        point.surface = [0.0; 2];
    }
    // Along the plane, up to the rounding of the normal, a ray may leave to either side: one
    // direction in four million.
    let w = std::iter::repeat_with(|| rng.direction())
        .find(|w| w.dot(point.n).abs() > f32::EPSILON)
        .unwrap_or(point.n);
    let naive = Ray::new(point.p + NAIVE * point.n * w.dot(point.n).signum(), w);
    let ours = Ray::new(point.leave(w), w);
    let shape = primitives.get(hit.prim);
    [ours, naive].map(|ray| u64::from(meets_itself(&shape, &point, &ray)))
}

/// Whether a ray that has left `point` meets the shape there again. From the inside of a sphere it
/// must meet the other side, at twice the cosine times the radius.
fn meets_itself(shape: &Primitive, point: &SurfacePoint, ray: &Ray) -> bool {
    let mut only = Primitives::default();
    match *shape {
        Primitive::Triangle(triangle) => only.triangles.push(triangle),
        Primitive::Quad(quad) => only.quads.push(quad),
        Primitive::Sphere(sphere) => only.spheres.push(sphere),
    }
    let cos = ray.dir.dot(point.n);
    let chord = match *shape {
        Primitive::Sphere(sphere) if cos < 0.0 => -cos * sphere.radius,
        _ => f32::INFINITY,
    };
    let hit = Geometry::build(only, AccelKind::Brute).intersect(ray, |_| false);
    hit.is_some_and(|h| h.t < chord)
}
