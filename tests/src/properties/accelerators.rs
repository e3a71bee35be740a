//! Every accelerator against brute force.

use glam::Vec3;
use lightbox_core::AccelKind;
use lightbox_core::geometry::{Geometry, Hit, Primitives};
use lightbox_core::math::Ray;
use lightbox_core::shape::{Quad, Sphere};

use super::draw::{Draw, unit};

/// Coordinates within which every accelerator promises the same bits: 2⁻⁵⁹ to 2⁵⁹.
const RANGE: i32 = 59;

/// Shapes over a few shared points, so that edges are shared, points line up and shapes repeat.
struct Shapes {
    points: Vec<Vec3>,
    triangles: Vec<[Vec3; 3]>,
    quads: Vec<Quad>,
    spheres: Vec<Sphere>,
}

impl Shapes {
    /// Of any numbers at all if `wild`.
    fn draw(draw: &mut Draw, wild: bool) -> Self {
        let range = draw.of(&[2, 8, 20, RANGE]);
        let mut points: Vec<Vec3> = Vec::new();
        for i in 0..1 + draw.below(14) {
            let mut p = if wild {
                draw.any_point()
            } else {
                draw.point(range)
            };
            if i > 0 && draw.below(2) == 0 {
                // In an axis-parallel plane with another point.
                let axis = draw.below(3);
                p[axis] = points[draw.below(i)][axis];
            }
            points.push(p);
        }
        let (mut triangles, mut quads, mut spheres) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..draw.below(48) {
            let [a, b, c] = [0; 3].map(|_| points[draw.below(points.len())]);
            match draw.below(8) {
                0 => quads.push(Quad::new([a, b, c, a + (c - b)])),
                1 => {
                    let radius = if wild {
                        draw.any()
                    } else {
                        draw.coordinate(range).abs()
                    };
                    // Scenes have no others.
                    if radius > 0.0 {
                        spheres.push(Sphere { center: a, radius });
                    }
                }
                _ => triangles.push([a, b, c]),
            }
        }
        Self {
            points,
            triangles,
            quads,
            spheres,
        }
    }

    fn build(&self, accel: AccelKind) -> Geometry {
        let primitives = Primitives {
            triangles: self.triangles.clone().into(),
            quads: self.quads.clone(),
            spheres: self.spheres.clone(),
            ..Primitives::default()
        };
        Geometry::build(primitives, accel)
    }

    /// A point that a ray may start from or run to: a vertex, on an edge, in the middle, or off.
    fn target(&self, draw: &mut Draw) -> Vec3 {
        let [a, b, c] = [0; 3].map(|_| self.points[draw.below(self.points.len())]);
        match draw.below(4) {
            0 => a,
            1 => a * 0.5 + b * 0.5,
            2 => a * 0.5 + b * 0.25 + c * 0.25,
            _ => a + draw.point(4),
        }
    }

    fn ray(&self, draw: &mut Draw, wild: bool) -> Ray {
        let (origin, target) = (self.target(draw), self.target(draw));
        let dir = match draw.below(3) {
            0 => draw.direction(),
            1 if wild => draw.any_point(),
            _ => unit(target - origin),
        };
        let t_max = match draw.below(4) {
            0 => (target - origin).length(),
            1 if wild => draw.any(),
            _ => f32::INFINITY,
        };
        Ray { origin, dir, t_max }
    }
}

fn bits(hit: Option<Hit>) -> Option<(u32, [u32; 3])> {
    hit.map(|h| (h.prim, [h.t, h.u, h.v].map(f32::to_bits)))
}

/// More rays in one call than are cast one by one.
const TOGETHER: usize = 160;

/// Builds every accelerator over a few shapes and casts rays. Within the promised range hits have
/// the bits of brute force; for any other numbers they are finite and on the ray.
pub fn accelerators(bytes: &[u8]) {
    let mut draw = Draw::new(bytes);
    let wild = draw.below(4) == 0;
    let shapes = Shapes::draw(&mut draw, wild);
    let emitters = draw.word();
    let is_emitter = |id: u32| emitters >> (id % 32) & 1 == 1;
    let brute = shapes.build(AccelKind::Brute);
    let others: Vec<Geometry> = AccelKind::ALL
        .iter()
        .map(|kind| shapes.build(*kind))
        .collect();
    let rays: [(Ray, u32); 10] =
        std::array::from_fn(|_| (shapes.ray(&mut draw, wild), u32::from(draw.byte())));
    let expected = rays.map(|(ray, except)| {
        let any = brute.occluded(&ray, u32::MAX);
        assert_eq!(brute.intersect(&ray, |_| false).is_some(), any, "{ray:?}");
        let hit = brute.intersect(&ray, is_emitter);
        (bits(hit), brute.occluded(&ray, except), any)
    });
    for (other, kind) in others.iter().zip(AccelKind::ALL) {
        let check_hit = |i: usize, found: Option<Hit>| {
            let (ray, _) = rays[i % rays.len()];
            if let Some(Hit { t, .. }) = found {
                assert!(
                    t > 0.0 && t <= ray.t_max && t < f32::INFINITY,
                    "{kind}: {t} on {ray:?}"
                );
            }
            if !wild {
                assert_eq!(bits(found), expected[i % rays.len()].0, "{kind}: {ray:?}");
            }
        };
        let check_shadow = |i: usize, found: bool| {
            let (ray, _) = rays[i % rays.len()];
            assert!(
                wild || found == expected[i % rays.len()].1,
                "{kind}: {ray:?}"
            );
        };
        for (i, (ray, except)) in rays.iter().enumerate() {
            check_hit(i, other.intersect(ray, is_emitter));
            check_shadow(i, other.occluded(ray, *except));
            let any = other.occluded(ray, u32::MAX);
            assert!(wild || any == expected[i].2, "{kind}: {ray:?}");
        }
        // Often enough that they go together.
        let together: Vec<(Ray, u32)> = rays.iter().copied().cycle().take(TOGETHER).collect();
        other.intersect_many(&together, |(ray, _)| *ray, is_emitter, check_hit);
        other.occluded_many(&together, |segment| *segment, check_shadow);
    }
}
