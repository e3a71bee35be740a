//! What the geometric probes are fed: meshes and rays; and the comparison of every accelerator with
//! brute force.

use glam::{DVec3, Vec3};

use super::Figure;
use super::random::Rng;
use crate::geometry::{Geometry, Hit, Primitives};
use crate::math::{Aabb, Ray};
use crate::settings::AccelKind;

pub(crate) type Triangle = [Vec3; 3];

/// The unit vector nearest to the direction from one point to another.
pub(super) fn toward(from: Vec3, to: Vec3) -> Vec3 {
    (to.as_dvec3() - from.as_dvec3())
        .normalize_or(DVec3::X)
        .as_vec3()
}

/// Primitives of triangles alone.
pub(super) fn primitives(triangles: &[Triangle]) -> Primitives {
    Primitives {
        triangles: triangles.to_vec().into(),
        slots: vec![0; triangles.len()],
        ..Primitives::default()
    }
}

pub(super) fn build(triangles: &[Triangle], accel: AccelKind) -> Geometry {
    Geometry::build(primitives(triangles), accel)
}

/// The triangles in every accelerator that is none of the others by another name.
pub(super) fn all(triangles: &[Triangle]) -> Vec<Geometry> {
    kinds().map(|accel| build(triangles, accel)).collect()
}

/// The same without brute force.
pub(super) fn trees(triangles: &[Triangle]) -> Vec<Geometry> {
    kinds()
        .filter(|accel| *accel != AccelKind::Brute)
        .map(|accel| build(triangles, accel))
        .collect()
}

fn kinds() -> impl Iterator<Item = AccelKind> {
    AccelKind::ALL
        .iter()
        .copied()
        .filter(|accel| *accel != AccelKind::Auto)
}

/// The nearest hit; nothing emits.
pub(super) fn cast(geometry: &Geometry, ray: &Ray) -> Option<Hit> {
    geometry.intersect(ray, |_| false)
}

/// A hit's bits.
pub(super) fn bits(hit: Option<Hit>) -> Option<(u32, u32, u32, u32)> {
    hit.map(|h| (h.t.to_bits(), h.prim, h.u.to_bits(), h.v.to_bits()))
}

/// No primitive's id: nothing is left out of an occlusion test.
pub(super) const NOTHING: u32 = u32::MAX;

/// Answers, nearest and any, in which some accelerator differs from brute force by a bit.
pub(super) fn differences(triangles: &[Triangle], rays: &[Ray]) -> usize {
    differences_among(&|| primitives(triangles), rays)
}

/// The same for primitives of all kinds.
pub(super) fn differences_among(scene: &dyn Fn() -> Primitives, rays: &[Ray]) -> usize {
    let brute = Geometry::build(scene(), AccelKind::Brute);
    let expected: Vec<_> = rays.iter().map(|ray| bits(cast(&brute, ray))).collect();
    let differing = |geometry: &Geometry| {
        let wrong = |(ray, expected): &(&Ray, &Option<_>)| {
            bits(cast(geometry, ray)) != **expected
                || geometry.occluded(ray, NOTHING) != expected.is_some()
        };
        rays.iter().zip(&expected).filter(wrong).count()
    };
    kinds()
        .filter(|accel| *accel != AccelKind::Brute)
        .map(|accel| differing(&Geometry::build(scene(), accel)))
        .sum()
}

/// The figure that most probes of accelerators have.
pub(super) fn as_brute_force(found: usize) -> Figure {
    Figure::none("answers that differ from brute force", None, found)
}

/// Rays aimed at vertices, edges and insides, from outside, inside and from vertices; along
/// axes with zeros of both signs, in planes of the grid, and with ends at and just before a hit.
pub(super) fn rays_at(triangles: &[Triangle], n: usize, rng: &mut Rng) -> Vec<Ray> {
    let bounds = Aabb::of_points(triangles.iter().flatten().copied());
    let (center, size) = (bounds.center(), bounds.diagonal());
    let mut rays = Vec::new();
    while rays.len() < n {
        let triangle = triangles[rng.below(triangles.len())];
        let target = match rng.below(3) {
            0 => triangle[rng.below(3)],
            1 => triangle[0].lerp(triangle[1], rng.unit()),
            _ => rng.point_of(triangle),
        };
        let origin = match rng.below(4) {
            0 => triangles[rng.below(triangles.len())][rng.below(3)],
            1 => center + 3.0 * size * rng.cube(),
            _ => center + 0.5 * size * rng.cube(),
        };
        let ray = Ray::new(origin, toward(origin, target));
        let axis = Vec3::AXES[rng.below(3)] * [1.0, -1.0][rng.below(2)];
        let along = Ray::new(target - size * axis, axis);
        let flat = (target - origin) * (Vec3::ONE - axis.abs());
        let reach = (target - origin).length();
        rays.extend([
            ray,
            along,
            Ray {
                dir: axis.map(|x| if x == 0.0 { -0.0 } else { x }),
                ..along
            },
            Ray::new(target - flat, toward(target - flat, target)),
            Ray {
                t_max: reach,
                ..ray
            },
            Ray {
                t_max: reach.next_down(),
                ..ray
            },
        ]);
    }
    rays
}

/// A closed surface of latitudes and longitudes about a point, `radius(i, j)` away.
pub(super) fn globe(
    center: Vec3,
    [rows, columns]: [usize; 2],
    mut radius: impl FnMut() -> f32,
) -> Vec<Triangle> {
    let mut points = Vec::new();
    for j in 0..=rows {
        let theta = std::f64::consts::PI * j as f64 / rows as f64;
        // A pole is one point.
        let ring = if j == 0 || j == rows { 1 } else { columns };
        let row: Vec<Vec3> = (0..ring)
            .map(|i| {
                let phi = std::f64::consts::TAU * i as f64 / columns as f64;
                let (s, c) = (libm::sin(theta), libm::cos(theta));
                let d = DVec3::new(s * libm::cos(phi), c, s * libm::sin(phi));
                center + radius() * d.as_vec3()
            })
            .collect();
        points.push(row);
    }
    let at = |i: usize, j: usize| points[j][i % points[j].len()];
    let mut triangles = Vec::new();
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            if j + 1 < rows {
                triangles.push([a, b, c]);
            }
            if j > 0 {
                triangles.push([a, c, d]);
            }
        }
    }
    triangles
}

/// A unit icosahedron, each triangle split into four `times` times, on the sphere.
pub(super) fn icosphere(times: u32) -> Vec<Triangle> {
    let phi = f32::midpoint(1.0, 5f32.sqrt());
    let mut corners = Vec::new();
    for (a, b) in [(1.0, phi), (1.0, -phi), (-1.0, phi), (-1.0, -phi)] {
        corners.extend([
            Vec3::new(0.0, a, b),
            Vec3::new(a, b, 0.0),
            Vec3::new(b, 0.0, a),
        ]);
    }
    // Faces join corners that are all at the length of an edge, 2, from each other.
    let near = |a: Vec3, b: Vec3| (a.distance(b) - 2.0).abs() < 0.1;
    let mut triangles = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in corners.iter().skip(j + 1) {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = (b - a).cross(c - a).dot(a) > 0.0;
                    triangles.push(if outward { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..times {
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                // Symmetric in its ends, so that neighbours agree to the bit.
                let middle = |p: Vec3, q: Vec3| (p + q) * 0.5;
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    triangles.iter().map(|t| t.map(Vec3::normalize)).collect()
}

/// Two triangles per unit square of an n × n grid on each of three planes.
pub(crate) fn grid(n: usize) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let [u, v, w] = [0, 1, 2].map(|k| Vec3::AXES[(axis + k) % 3]);
        for i in 0..n * n {
            let corner = u * (i % n) as f32 + v * (i / n) as f32 + w * (n / 2) as f32;
            triangles.push([corner, corner + u, corner + u + v]);
            triangles.push([corner, corner + u + v, corner + v]);
        }
    }
    triangles
}

/// The steps of a stair in the unit cube, from z = 1/steps up to 1, each a tread and a riser.
pub(super) fn stairs(steps: usize) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    let mut quad = |a: Vec3, u: Vec3, v: Vec3| {
        triangles.push([a, a + u, a + u + v]);
        triangles.push([a, a + u + v, a + v]);
    };
    let at = |i: usize| i as f32 / steps as f32;
    for i in 0..steps {
        let (low, high) = (at(i), at(i + 1));
        quad(Vec3::new(low, 0.0, high), Vec3::X * (high - low), Vec3::Y);
        quad(Vec3::new(low, 0.0, low), Vec3::Y, Vec3::Z * (high - low));
    }
    triangles
}

/// Triangles of length 1000 and width 10⁻³, their centres within `spread` of the origin.
pub(crate) fn needles(n: usize, spread: f32, rng: &mut Rng) -> Vec<Triangle> {
    let mut needle = || {
        let (center, along) = (spread * rng.cube(), 500.0 * rng.direction());
        let tip = center + along;
        [center - along, tip, tip + 1e-3 * rng.cube()]
    };
    (0..n).map(|_| needle()).collect()
}

/// `ray` made into rays without meaning, or with none of it left: no direction, no number or no end
/// in its place, its direction or both, and distances that leave it nothing.
pub(crate) fn meaningless(ray: Ray) -> Vec<Ray> {
    let mut bad = vec![Ray {
        dir: Vec3::ZERO,
        ..ray
    }];
    for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let (mut origin, mut dir) = (ray.origin, ray.dir);
            origin[axis] = x;
            dir[axis] = x;
            bad.extend([
                Ray { origin, ..ray },
                Ray { dir, ..ray },
                Ray { origin, dir, ..ray },
            ]);
        }
    }
    bad.extend([0.0, -0.0, -1.0, f32::NEG_INFINITY, f32::NAN].map(|t_max| Ray { t_max, ..ray }));
    bad
}
