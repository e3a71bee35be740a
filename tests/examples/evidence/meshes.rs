//! Meshes that are hard on rays.

use std::f32::consts::PI;

use glam::Vec3;
use lightbox_core::lab::random::Rng;

/// Three vertices.
pub type Triangle = [Vec3; 3];

/// A closed mesh of 2·n·2n triangles around `center`: `radius` by the polar and the azimuth angle.
pub fn closed(n: usize, center: Vec3, mut radius: impl FnMut() -> f32) -> Vec<Triangle> {
    // Each vertex once, so that neighbours share it to the bit; the poles too.
    let mut rings = Vec::new();
    for j in 0..=n {
        let theta = PI * j as f32 / n as f32;
        let is_pole = j == 0 || j == n;
        let pole = center + radius() * if j == 0 { Vec3::Z } else { -Vec3::Z };
        let ring: Vec<Vec3> = (0..2 * n)
            .map(|i| {
                let phi = PI * i as f32 / n as f32;
                let d = Vec3::new(
                    theta.sin() * phi.cos(),
                    theta.sin() * phi.sin(),
                    theta.cos(),
                );
                if is_pole { pole } else { center + radius() * d }
            })
            .collect();
        rings.push(ring);
    }
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..2 * n {
            let k = (i + 1) % (2 * n);
            let ([a, b], [d, c]) = (
                [rings[j][i], rings[j][k]],
                [rings[j + 1][i], rings[j + 1][k]],
            );
            triangles.push([a, d, c]);
            triangles.push([a, c, b]);
        }
    }
    triangles
}

/// A star with spikes from 1 to 6 long.
pub fn star(n: usize, rng: &mut Rng) -> Vec<Triangle> {
    closed(n, Vec3::ZERO, || 1.0 + 5.0 * rng.unit())
}

/// Stairs whose treads and risers lie in the planes that a builder would split at.
pub fn stairs(steps: usize) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    let mut quad = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| triangles.extend([[a, b, c], [a, c, d]]);
    let at = |i: usize, k: usize, z: f32| Vec3::new(i as f32, k as f32, z) / steps as f32;
    let width = steps as f32;
    for i in 0..steps {
        quad(
            at(i, i, 0.0),
            at(i, i + 1, 0.0),
            at(i, i + 1, width),
            at(i, i, width),
        );
        quad(
            at(i, i + 1, 0.0),
            at(i + 1, i + 1, 0.0),
            at(i + 1, i + 1, width),
            at(i, i + 1, width),
        );
    }
    triangles
}

/// Long needles at random angles.
pub fn needles(n: usize, rng: &mut Rng) -> Vec<Triangle> {
    let mut needle = || {
        let (center, along) = (rng.cube(), 500.0 * rng.direction());
        [
            center - along,
            center + along,
            center + along + 1e-3 * rng.cube(),
        ]
    };
    (0..n).map(|_| needle()).collect()
}

/// Triangles of whole coordinates within a small box: most share planes, edges or vertices, many
/// are without area or repeated.
pub fn lattice(n: usize, rng: &mut Rng) -> Vec<Triangle> {
    let mut point = || Vec3::from_array([0; 3].map(|_| rng.below(4) as f32));
    (0..n).map(|_| [point(), point(), point()]).collect()
}

/// Triangles of very different sizes, from 10⁻⁶ to 10³.
pub fn sizes(n: usize, rng: &mut Rng) -> Vec<Triangle> {
    let mut triangle = || {
        let size = 10f32.powf(9.0 * rng.unit() - 6.0);
        let center = size.max(1.0) * rng.cube();
        [0; 3].map(|_| center + size * rng.cube())
    };
    (0..n).map(|_| triangle()).collect()
}
