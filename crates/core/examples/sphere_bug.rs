//! The report's inverted mirror sphere, made on purpose: renders the sphere-mirror scene with the
//! right intersection and with two wrong ones. `cargo run --release -p lightbox-core --example
//! sphere_bug -- docs` writes docs/sphere-right.png and its two wrong sisters.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use glam::Vec3;
use lightbox_core::color::ToneMap;
use lightbox_core::integrator::Wave;
use lightbox_core::math::Ray;
use lightbox_core::sampler::{Dim, Sampler};
use lightbox_core::shape::Sphere;
use lightbox_core::{Image, Method, SamplerKind, scene};
use rayon::prelude::*;

const SIZE: u32 = 320;
const SAMPLES: u64 = 64;

/// Ways to choose between the two roots of the ray-sphere equation.
#[derive(Clone, Copy, Debug)]
enum Roots {
    /// The smaller positive one, by lightbox's own intersection.
    Right,
    /// As the report prints it: `t0·t1 ≥ 0 ? min : max`, in f32, with no offset from the surface.
    AsPrinted,
    /// Always the larger: the back of the sphere, seen from within.
    Far,
}

fn intersect(sphere: &Sphere, ray: &Ray, roots: Roots) -> Option<f32> {
    if let Roots::Right = roots {
        return sphere.intersect(ray, f32::INFINITY);
    }
    let f = ray.origin - sphere.center;
    let b = 2.0 * ray.dir.dot(f);
    let c = f.dot(f) - sphere.radius * sphere.radius;
    let discriminant = b * b - 4.0 * c;
    if discriminant < 0.0 {
        return None;
    }
    let (t0, t1) = (
        0.5 * (-b - discriminant.sqrt()),
        0.5 * (-b + discriminant.sqrt()),
    );
    let t = match roots {
        Roots::AsPrinted if t0 * t1 >= 0.0 => t0.min(t1),
        _ => t0.max(t1),
    };
    // Without this test, which the report lacks too, spheres behind the camera would be seen.
    (t > 0.0).then_some(t)
}

fn main() -> Result<(), String> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".into());
    let source = scene::load(Path::new("builtin:sphere-mirror.toml")).map_err(|e| e.to_string())?;
    let mut room = source.desc.clone();
    let ball = room.spheres.pop().ok_or("the scene has a sphere")?;
    let ball = Sphere {
        center: ball.center,
        radius: ball.radius,
    };
    let camera = lightbox_core::Camera::new(&room.camera, SIZE, SIZE)?;
    let room = source
        .build_edited(room, &|_| ())
        .map_err(|e| e.to_string())?;

    for (roots, name) in [
        (Roots::Right, "right"),
        (Roots::AsPrinted, "as-printed"),
        (Roots::Far, "far-root"),
    ] {
        let pixels = (0..SIZE * SIZE).into_par_iter().map(|i| {
            let pixel = [i % SIZE, i / SIZE];
            let mut wave = Wave::default();
            for sample in 0..SAMPLES {
                let sampler = Sampler::new(SamplerKind::Sobol, 0, pixel, sample);
                let [x, y] = sampler.get_2d(Dim::Pixel);
                let mut ray = camera.ray(pixel, [x - 0.5, y - 0.5]);
                // Reflections until the ray leaves the ball for good.
                for _ in 0..64 {
                    let wall = room.intersect(&ray).map_or(f32::INFINITY, |hit| hit.t);
                    let Some(t) = intersect(&ball, &ray, roots).filter(|t| *t < wall) else {
                        break;
                    };
                    let p = ray.at(t);
                    let n = (p - ball.center) / ball.radius;
                    let reflected = (ray.dir - 2.0 * ray.dir.dot(n) * n).normalize();
                    let outside = matches!(roots, Roots::Right);
                    ray = Ray::new(if outside { p + n * 1e-5 } else { p }, reflected);
                    if let Roots::Far = roots {
                        break; // Once, to see what the back of the ball reflects.
                    }
                }
                wave.push(ray, sampler);
            }
            let never = AtomicBool::new(false);
            let found = wave.trace(&room, Method::Mis, 8, &never, &mut 0);
            let sum: Vec3 = found.into_iter().flatten().sum();
            sum / SAMPLES as f32
        });
        let image = Image {
            width: SIZE,
            height: SIZE,
            pixels: pixels.collect(),
        };
        let path = Path::new(&folder).join(format!("sphere-{name}.png"));
        lightbox_core::image_io::write(&path, &image, ToneMap::default(), "")?;
    }
    Ok(())
}
