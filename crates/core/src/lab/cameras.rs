//! The camera: bases, angles, pixels on edges, places far from the origin.

use glam::Vec3;

use super::trial::{scene, view};
use super::{Bound, Case, Check, Figure};
use crate::scene::CameraDesc;
use crate::{Camera, Filter, SceneDesc};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "C01",
        title: "cameras that look along their up vector, or nowhere",
        failure: "The cross product vanishes, its length is divided by: NaN in every ray.",
        cure: "Another axis serves as up; a camera without a direction is refused.",
        check: Check::Probe(bases),
        scene: None,
        picture: None,
    },
    Case {
        id: "C02",
        title: "fields of view from 0 to 180°",
        failure: "A tangent of 0 or ∞; at 10⁻⁶ degrees the offset within a pixel is below an ulp.",
        cure: "More than 0 and less than 180; the axis in f64.",
        check: Check::Probe(angles),
        scene: None,
        picture: None,
    },
    Case {
        id: "C03",
        title: "central rays of symmetric scenes",
        failure: "The ray through the middle has components of 0 and −0, meets edges, and lies in \
                  split planes, all at once.",
        cure: "Closed edges, both sides of a plane on a tie, octants by the sign of 1/d.",
        check: Check::Probe(center),
        scene: None,
        picture: None,
    },
    Case {
        id: "C04",
        title: "an eye at 10⁶",
        failure: "Points of the picture plane at absolute coordinates are quantised: rays come in \
                  steps of pixels.",
        cure: "Directions come from differences, in f64; intersections from vertices less the \
               origin: moved by a multiple of the grid, every hit keeps its bits.",
        check: Check::Probe(far_away),
        scene: None,
        picture: None,
    },
];

fn bases() -> Vec<Figure> {
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let vectors = [
        Vec3::ZERO,
        Vec3::X,
        Vec3::Y,
        -Vec3::Y,
        Vec3::Z,
        Vec3::new(0.0, 1.0, 1e-7),
        Vec3::splat(1e-20),
        Vec3::splat(1e18),
        Vec3::new(1e-30, 1.0, -1e18),
        Vec3::new(nan, 0.0, 1.0),
        Vec3::new(0.0, inf, 0.0),
    ];
    let (mut bad, mut bad_naive, mut worst) = (0u32, 0u32, 0.0f64);
    for eye in vectors {
        for target in vectors {
            for up in vectors {
                let desc = CameraDesc {
                    eye,
                    target,
                    up,
                    fov: 90.0,
                };
                let axis = (target - eye).normalize();
                let right = axis.cross(up).normalize();
                bad_naive += u32::from(!(right.is_finite() && right.cross(axis).is_finite()));
                let nothing = eye == target || up == Vec3::ZERO;
                let infinite = !(eye + target + up).is_finite();
                let Ok(camera) = Camera::new(&desc, 2, 2) else {
                    // Refused rightly only without a direction.
                    bad += u32::from(!(nothing || infinite));
                    continue;
                };
                bad += u32::from(nothing || infinite);
                // The four pixels of a square picture of 90° look along (±½, ±½, 1).
                let d = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|p| camera.ray(p, [0.0; 2]).dir);
                let right = (d[1] - d[0]).as_dvec3();
                let down = (d[2] - d[0]).as_dvec3();
                let forward = camera.forward().as_dvec3();
                for x in [
                    right.dot(down),
                    right.dot(forward),
                    down.dot(forward),
                    right.length() - (2.0f64 / 3.0).sqrt(),
                    down.length() - (2.0f64 / 3.0).sqrt(),
                    forward.length() - 1.0,
                ] {
                    worst = if x.abs() <= worst { worst } else { x.abs() };
                }
            }
        }
    }
    vec![
        Figure {
            what: "cameras of 1331 with a wrong verdict (naive: with NaN in the basis)",
            naive: Some(bad_naive.into()),
            lightbox: bad.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "largest deviation from an orthonormal basis",
            naive: None,
            lightbox: worst,
            bound: Bound::AtMost(1e-6),
        },
    ]
}

fn angles() -> Vec<Figure> {
    let with_fov = |fov: f32, width, height| {
        let desc = CameraDesc {
            eye: Vec3::ZERO,
            target: -Vec3::Z,
            fov,
            ..CameraDesc::default()
        };
        Camera::new(&desc, width, height)
    };
    let bad = [
        0.0,
        -0.0,
        -1.0,
        180.0,
        180.0f32.next_up(),
        1e9,
        f32::NAN,
        f32::INFINITY,
    ];
    let accepted = bad
        .iter()
        .filter(|fov| with_fov(**fov, 4, 4).is_ok())
        .count();
    let naive = bad
        .iter()
        .filter(|fov| !((**fov).to_radians() * 0.5).tan().is_normal());
    let naive = naive.count();
    let (mut worst, mut outside) = (0.0f64, 0u32);
    for fov in [1e-6f32, 0.01, 39.3, 90.0, 179.9] {
        for (width, height) in [(1, 1), (1, 7), (7, 1), (6, 4)] {
            let Ok(camera) = with_fov(fov, width, height) else {
                outside += 1;
                continue;
            };
            let pixel = 2.0 * (f64::from(fov).to_radians() * 0.5).tan() / f64::from(height);
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let d = camera.ray([x, y], [0.0; 2]).dir;
                let expected = glam::DVec3::new(
                    (f64::from(x) + 0.5 - f64::from(width) / 2.0) * pixel,
                    (f64::from(height) / 2.0 - f64::from(y) - 0.5) * pixel,
                    -1.0,
                );
                worst = worst.max((d.as_dvec3() - expected.normalize()).length());
                outside += u32::from(!d.is_finite() || (d.length() - 1.0).abs() > 2e-7);
            }
        }
    }
    vec![
        Figure {
            what: "impossible fields of view accepted (naive: whose tangent is 0, ∞ or NaN)",
            naive: Some(naive as f64),
            lightbox: accepted as f64,
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "largest distance of a pixel centre's direction from the exact one",
            naive: None,
            lightbox: worst,
            bound: Bound::AtMost(4.0 * f64::from(f32::EPSILON)),
        },
        Figure {
            what: "directions that are not of unit length",
            naive: None,
            lightbox: outside.into(),
            bound: Bound::Exactly(0.0),
        },
    ]
}

/// A wall of 16×16 quads, twice as wide as the picture.
fn wall() -> SceneDesc {
    let mut desc = SceneDesc {
        camera: CameraDesc {
            eye: Vec3::Z,
            target: Vec3::ZERO,
            fov: 90.0,
            ..CameraDesc::default()
        },
        ..SceneDesc::default()
    };
    desc.materials.push(crate::scene::MaterialDesc {
        name: "wall".into(),
        ..crate::scene::MaterialDesc::default()
    });
    for (i, j) in (-8..8).flat_map(|i| (-8..8).map(move |j| (i, j))) {
        let corner =
            |di: i32, dj: i32| Vec3::new((i + di) as f32 * 0.25, (j + dj) as f32 * 0.25, 0.0);
        desc.quads.push(crate::scene::QuadDesc {
            name: String::new(),
            material: "wall".into(),
            corners: [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)],
        });
    }
    desc
}

fn center() -> Vec<Figure> {
    let (mut misses, mut misses_naive, mut rays) = (0u32, 0u32, 0u32);
    for accel in crate::AccelKind::ALL {
        let mut desc = wall();
        desc.render.accel = *accel;
        let built = crate::scene::Source::from_desc(desc, "lab.toml".as_ref())
            .build(&crate::scene::unwatched);
        let scene = std::sync::Arc::new(built.unwrap_or_else(|e| panic!("{e}")));
        for size in [1, 2, 3, 15, 16, 64, 65] {
            let view = view(&scene, |s| (s.width, s.height) = (size, size));
            for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
                // The middle of the pixel and its lower corner.
                for offset in [[0.0, 0.0], [-0.5, -0.5]] {
                    let ray = view.camera.ray([x, y], offset);
                    rays += 1;
                    misses += u32::from(scene.intersect(&ray).is_none());
                    let (px, py) = (ray.dir.x / -ray.dir.z * 4.0, ray.dir.y / -ray.dir.z * 4.0);
                    // Open intervals: nothing owns the lines between quads.
                    misses_naive += u32::from(px.fract() == 0.0 || py.fract() == 0.0);
                }
            }
        }
    }
    vec![
        Figure {
            what: "rays through a closed wall (naive: with open edges)",
            naive: Some(misses_naive.into()),
            lightbox: misses.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "rays cast",
            naive: None,
            lightbox: rays.into(),
            bound: Bound::AtLeast(30_000.0),
        },
    ]
}

fn far_away() -> Vec<Figure> {
    let text = "
[camera]
eye = [0, 0.5, 4]
target = [0, 0, 0]
[render]
width = 64
height = 64
accel = 'kdtree'
[[material]]
name = 'grey'
[[quad]]
material = 'grey'
corners = [[-2, -1, 2], [2, -1, 2], [2, -1, -2], [-2, -1, -2]]
[[quad]]
material = 'grey'
corners = [[-2, -1, -2], [2, -1, -2], [1.5, 2, -2], [-2, 2, -2.5]]
[[sphere]]
material = 'grey'
center = [0.25, -0.25, 0]
radius = 0.75
";
    let near = scene(text);
    let here = view(&near, |_| ());
    let mut differ = 0u32;
    let mut worst_naive = 0.0f64;
    for exponent in [10, 17, 20] {
        // All coordinates are multiples of ¼, and stay so: the move is exact.
        let by = Vec3::new(1.0, -1.0, 1.0) * 2f32.powi(exponent);
        let mut desc = near.desc().clone();
        desc.camera.eye += by;
        desc.camera.target += by;
        for quad in &mut desc.quads {
            quad.corners = quad.corners.map(|c| c + by);
        }
        for sphere in &mut desc.spheres {
            sphere.center += by;
        }
        let built = crate::scene::Source::from_desc(desc, "lab.toml".as_ref())
            .build(&crate::scene::unwatched);
        let far = std::sync::Arc::new(built.unwrap_or_else(|e| panic!("{e}")));
        let there = view(&far, |_| ());
        let filter = crate::filter::FilterSampler::new(Filter::default());
        for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let (offset, _) = filter.sample([0.3, 0.8]);
            let (a, b) = (
                here.camera.ray([x, y], offset),
                there.camera.ray([x, y], offset),
            );
            let hits = (near.intersect(&a), far.intersect(&b));
            differ += u32::from(a.dir != b.dir || hits.0 != hits.1);
            // A point of the picture plane at absolute coordinates, then back to a direction.
            let point = b.origin + b.dir;
            let naive = (point - b.origin).normalize();
            let pixel = 2.0 * (f64::from(near.desc().camera.fov).to_radians() * 0.5).tan() / 64.0;
            worst_naive = worst_naive.max(f64::from((naive - b.dir).length()) / pixel);
        }
    }
    vec![Figure {
        what: "hits of 12 288 that change when all is moved (naive: largest error, pixels)",
        naive: Some(worst_naive),
        lightbox: differ.into(),
        bound: Bound::Exactly(0.0),
    }]
}
