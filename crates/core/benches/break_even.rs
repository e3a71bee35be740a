//! From how many primitives on a tree pays: what it takes to build, what it saves per ray, and
//! after how many rays it has paid. `cargo bench -p lightbox-core --bench break_even`.

use std::hint::black_box;
use std::time::Instant;

use glam::Vec3;
use lightbox_core::AccelKind;
use lightbox_core::geometry::{Geometry, Primitives};
use lightbox_core::math::{Ray, warp};
use lightbox_core::sampler::{Dim, Sampler};
use lightbox_core::settings::SamplerKind;

/// Rays cast at a time, as many as paths advance together.
const RAYS: u32 = 1024;

/// Each time is the least of so many, tree and none in turn.
const ROUNDS: u32 = 200;

fn main() {
    println!(
        "{:>10} {:>12} {:>12} {:>12} {:>8} {:>16}",
        "triangles", "build µs", "tree ns/ray", "none ns/ray", "ratio", "paid after rays"
    );
    let mut rule = None;
    for count in [2, 4, 8, 12, 16, 20, 24, 28, 32, 40, 48, 64, 128, 1024] {
        let [tree, none] = [AccelKind::Bvh, AccelKind::Brute].map(|kind| measure(count, kind));
        let [tree_ns, none_ns] = cast(&tree.0, &none.0);
        let saved = none_ns - tree_ns;
        let build = tree.1 - none.1;
        let paid = if saved > 0.0 {
            format!("{:.0}", build / saved)
        } else {
            rule = None;
            "never".into()
        };
        if saved > 0.0 {
            rule = rule.or(Some(count));
        }
        println!(
            "{count:>10} {:>12.1} {tree_ns:>12.1} {none_ns:>12.1} {:>8.2} {paid:>16}",
            tree.1 / 1e3,
            none_ns / tree_ns
        );
    }
    if let Some(count) = rule {
        println!("a tree pays from {count} triangles on");
    }
}

fn random(i: u32, dimension: u32) -> [f32; 2] {
    let sampler = Sampler::new(SamplerKind::Independent, 5, [i, dimension], 0);
    sampler.get_2d(Dim::Pixel)
}

fn point(i: u32, dimension: u32) -> Vec3 {
    let ([x, y], [z, _]) = (random(i, dimension), random(i, dimension + 1));
    Vec3::new(x, y, z)
}

/// Triangles in the unit cube, smaller the more there are, as parts of objects are.
fn primitives(count: u32) -> Primitives {
    let size = 1.5 / (count as f32).sqrt();
    let triangles: Vec<_> = (0..count)
        .map(|i| {
            let corner = point(i, 0);
            [
                corner,
                corner + size * (point(i, 2) - 0.5),
                corner + size * (point(i, 4) - 0.5),
            ]
        })
        .collect();
    Primitives {
        triangles: triangles.into(),
        slots: vec![0; count as usize],
        ..Primitives::default()
    }
}

/// What is cast at, and the nanoseconds that it takes to build.
fn measure(count: u32, kind: AccelKind) -> (Geometry, f64) {
    let build = || {
        let primitives = primitives(count);
        let start = Instant::now();
        let geometry = Geometry::build(primitives, kind);
        (geometry, start.elapsed().as_nanos() as f64)
    };
    let best = (0..50).map(|_| build().1).fold(f64::INFINITY, f64::min);
    (build().0, best)
}

/// Nanoseconds per ray from inside the cube in all directions: with the tree and without.
fn cast(tree: &Geometry, none: &Geometry) -> [f64; 2] {
    let rays: Vec<Ray> = (0..RAYS)
        .map(|i| Ray::new(point(i, 7), warp::uniform_sphere(random(i, 9))))
        .collect();
    let run = |geometry: &Geometry| {
        let mut found = 0u32;
        let start = Instant::now();
        geometry.intersect_many(
            &rays,
            |ray| *ray,
            |_| false,
            |_, hit| found += u32::from(hit.is_some()),
        );
        let nanoseconds = start.elapsed().as_nanos() as f64;
        black_box(found);
        nanoseconds / f64::from(RAYS)
    };
    let mut best = [f64::INFINITY; 2];
    for _ in 0..ROUNDS {
        for (best, geometry) in best.iter_mut().zip([tree, none]) {
            *best = best.min(run(geometry));
        }
    }
    best
}
