//! Sampling of lights.

use glam::{DVec3, Vec3};
use lightbox_core::geometry::{Primitive, Primitives};
use lightbox_core::light::Lights;
use lightbox_core::shape::{Quad, Sphere, triangle_normal};

use super::draw::Draw;

/// Samples of a few emitters from reference points anywhere: a finite positive density or none,
/// the point on the emitter and its front towards the reference, and the same density when asked.
pub fn lights(bytes: &[u8]) {
    let mut draw = Draw::new(bytes);
    let mut primitives = Primitives::default();
    for _ in 0..=draw.below(4) {
        let [a, b, c] = [0; 3].map(|_| draw.point(16));
        match draw.below(4) {
            0 => primitives.triangles.push([a, b, c]),
            1 => add(&mut primitives, [a, b, c, a + (c - b)]),
            2 => {
                // A rectangle: what most lamps are.
                let (x, y) = (draw.direction(), draw.coordinate(16));
                let (x, y) = (x * draw.coordinate(16), x.any_orthonormal_vector() * y);
                add(&mut primitives, [a, a + x, a + x + y, a + y]);
            }
            _ => {
                let radius = draw.coordinate(16).abs();
                if radius > 0.0 {
                    primitives.spheres.push(Sphere { center: a, radius });
                }
            }
        }
    }
    let emitters = (0..primitives.len() as u32).map(|id| (id, f64::from(primitives.area(id))));
    let lights = Lights::new(&primitives, emitters);
    for _ in 0..8 {
        let p = match draw.below(4) {
            0 => draw.any_point(),
            1 if !primitives.is_empty() => {
                let box_ = primitives.bounds(draw.below(primitives.len()) as u32);
                draw.of(&[box_.min, box_.max, box_.center()])
            }
            _ => draw.point(16),
        };
        let (pick, u) = (draw.unit(), [draw.unit(), draw.unit()]);
        let Some(sample) = lights.sample(p, || pick, || u) else {
            continue;
        };
        let what = || format!("{:?} from {p:?}: {sample:?}", primitives.get(sample.prim));
        assert!(sample.pdf > 0.0 && sample.pdf.is_finite(), "{}", what());
        let asked = lights.pdf(p, sample.prim, sample.point.p);
        assert_eq!(asked, sample.pdf, "{}", what());
        assert!((sample.point.n.length() - 1.0).abs() < 1e-6, "{}", what());
        let size = f64::from(p.abs().max_element() + sample.point.p.abs().max_element());
        // The least number is as far as a coordinate can be moved by rounding when it is minute.
        let moved = 1e-6 * size + 2.0 * f64::from(f32::from_bits(1));
        check_on(&primitives.get(sample.prim), sample.point.p, moved, &what);
        let q = sample.point.p.as_dvec3();
        let side = (p.as_dvec3() - q).dot(sample.point.n.as_dvec3());
        // How far rounding moves the point, and on a sphere how far that turns the normal.
        let (turn, off) = match primitives.get(sample.prim) {
            Primitive::Sphere(sphere) => (moved / f64::from(sphere.radius), 0.0),
            Primitive::Triangle(_) => (1e-6, 0.0),
            // Its corners are rounded, and its halves off the whole and tilted against it.
            Primitive::Quad(quad) => {
                let tilt = quad.normal().as_dvec3().distance(sample.point.n.as_dvec3());
                let [a, b, c, d] = quad.corners();
                (1e-6 + tilt, off_plane([a, b, c], d))
            }
        };
        // From next to a corner of a large lamp f64 does not tell the sides apart: it counts from another.
        let bounds = primitives.bounds(sample.prim);
        let reach = (p - bounds.min)
            .abs()
            .max((p - bounds.max).abs())
            .max_element();
        let blur = 4.0 * f64::EPSILON * f64::from(reach);
        let error = turn * p.as_dvec3().distance(q) + moved + off + blur;
        assert!(side > -error, "{}: from behind", what());
    }
}

/// Adds a quad, unless a half of it is a line: scenes have no such.
fn add(primitives: &mut Primitives, corners: [Vec3; 4]) {
    let quad = Quad::new(corners);
    if quad
        .triangles()
        .map(triangle_normal)
        .iter()
        .all(|n| *n != Vec3::ZERO)
    {
        primitives.quads.push(quad);
    }
}

/// Whether `q` is no further from the shape than `error`, some ulp of the coordinates.
fn check_on(shape: &Primitive, q: Vec3, error: f64, what: &dyn Fn() -> String) {
    let off = match *shape {
        Primitive::Triangle(triangle) => off_plane(triangle, q),
        // Its corners are not exactly in one plane.
        Primitive::Quad(quad) => {
            let [a, b, c, d] = quad.corners();
            off_plane([a, b, c], q).min(off_plane([a, c, d], q))
        }
        Primitive::Sphere(Sphere { center, radius }) => {
            // Known to f64 only, which is computed in from the centre.
            let computed = f64::EPSILON * f64::from(center.abs().max_element() + radius);
            ((q.as_dvec3() - center.as_dvec3()).length() - f64::from(radius)).abs() - computed
        }
    };
    assert!(off <= error, "{}: off by {off}", what());
}

/// From the vertex between the two shortest edges, whose cross product cancels least, and along
/// the normal from the vertex next to `q`.
fn off_plane(triangle: [Vec3; 3], q: Vec3) -> f64 {
    let (corners, q) = (triangle.map(|p| p.as_dvec3()), q.as_dvec3());
    let [a, b, c] = corners;
    let edges = [(b - a, c - a), (c - b, a - b), (a - c, b - c)];
    let length = |(e, f): &(DVec3, DVec3)| e.length() + f.length();
    let least = |x: &(DVec3, DVec3), y: &(DVec3, DVec3)| length(x).total_cmp(&length(y));
    let n = edges.into_iter().min_by(least).map(|(e, f)| e.cross(f));
    let from = corners.map(|corner| q - corner);
    let nearest = from
        .into_iter()
        .min_by(|x, y| x.length().total_cmp(&y.length()));
    let n = n.unwrap_or_default().normalize_or_zero();
    nearest.unwrap_or_default().dot(n).abs()
}
