//! Prints what docs/speed.md records: rays and paths per second, build seconds, bytes per
//! triangle. `cargo bench -p lightbox-core`; figures are for the machine it runs on.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use glam::Vec3;
use lightbox_core::math::{Frame, Ray, warp};
use lightbox_core::sampler::{Dim, Sampler};
use lightbox_core::scene::{self, Source};
use lightbox_core::{AccelKind, SamplerKind, Scene, SceneDesc, View};
use rayon::prelude::*;

/// Rays of each kind: one per pixel of a square picture of this edge.
const EDGE: u32 = 512;

fn main() {
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| {
            println!("\n{threads} thread(s)");
            println!(
                "{:<28}{:>9}{:>9}{:>9}  million rays/s",
                "scene", "primary", "shadow", "diffuse"
            );
            for name in ["teddy-diffuse", "sphere-mirror", "cornell-box"] {
                let scene = build(&source(name), |_| ());
                rays(name, &scene);
            }
            println!(
                "{:<28}{:>9}{:>9}  (256x256, default method, 16 spp)",
                "scene", "Mpaths/s", "Mrays/s"
            );
            for name in ["sphere-mirror", "teddy-diffuse", "teddy-mirror"] {
                for accel in [AccelKind::KdTree, AccelKind::Auto] {
                    paths(name, accel);
                }
            }
            println!(
                "{:<28}{:>9}{:>9}{:>9}",
                "triangles", "build s", "B/tri", "refs/tri"
            );
            for accel in [AccelKind::KdTree, AccelKind::Bvh] {
                for triangles in [3_000, 100_000, 1_000_000] {
                    builds(triangles, accel);
                }
            }
        });
    }
}

fn source(name: &str) -> Source {
    scene::load(Path::new(&format!("builtin:{name}.toml"))).unwrap_or_else(|e| panic!("{e}"))
}

fn build(source: &Source, change: impl FnOnce(&mut SceneDesc)) -> Arc<Scene> {
    let mut desc = source.desc.clone();
    change(&mut desc);
    Arc::new(
        source
            .build_edited(desc, &scene::unwatched)
            .unwrap_or_else(|e| panic!("{e}")),
    )
}

/// Best of three, million per second.
fn rate(count: usize, run: impl Fn()) -> f64 {
    let seconds = (0..3).map(|_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    });
    count as f64 / seconds.fold(f64::INFINITY, f64::min) / 1e6
}

fn rays(name: &str, scene: &Arc<Scene>) {
    let camera = lightbox_core::Camera::new(&scene.desc().camera, EDGE, EDGE).expect("a camera");
    let sampler = |i: u32| Sampler::new(SamplerKind::Independent, 1, [i % EDGE, i / EDGE], 0);
    let primary: Vec<Ray> = (0..EDGE * EDGE)
        .map(|i| camera.ray([i % EDGE, i / EDGE], [0.0; 2]))
        .collect();
    let (mut shadow, mut diffuse) = (Vec::new(), Vec::new());
    for (i, ray) in primary.iter().enumerate() {
        let Some(hit) = scene.intersect(ray) else {
            continue;
        };
        let point = scene.primitives().surface_point(ray, &hit);
        let n = point.n * -ray.dir.dot(point.n).signum();
        let sampler = sampler(i as u32);
        let wi = Frame::around(n).world_from_local(warp::cosine_hemisphere(
            sampler.get_2d(Dim::BsdfDirection(0)),
        ));
        diffuse.push(Ray::new(point.leave(wi), wi.normalize()));
        let light = scene
            .lights()
            .sample(point.p, || 0.5, || sampler.get_2d(Dim::LightPoint(0)));
        if let Some(light) = light {
            let d: Vec3 = light.point.p - point.p;
            let from = point.leave(d);
            shadow.push((
                Ray {
                    origin: from,
                    dir: d.normalize(),
                    t_max: d.length(),
                },
                light.prim,
            ));
        }
    }
    let closest = |rays: &[Ray]| {
        rate(rays.len(), || {
            let hits = rays
                .par_iter()
                .with_min_len(4096)
                .filter(|r| scene.intersect(r).is_some())
                .count();
            std::hint::black_box(hits);
        })
    };
    let any = rate(shadow.len(), || {
        let hits = shadow
            .par_iter()
            .with_min_len(4096)
            .filter(|(r, light)| scene.occluded(r, *light))
            .count();
        std::hint::black_box(hits);
    });
    println!(
        "{name:<28}{:>9.2}{any:>9.2}{:>9.2}",
        closest(&primary),
        closest(&diffuse)
    );
}

fn paths(name: &str, accel: AccelKind) {
    let scene = build(&source(name), |desc| {
        (desc.render.width, desc.render.height, desc.render.samples) = (256, 256, 16);
        desc.render.accel = accel;
    });
    let view = View::of(scene).expect("a view");
    let film = view.film();
    let start = Instant::now();
    let work = view.render(&film, view.settings.samples, &AtomicBool::new(false));
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{:<28}{:>9.3}{:>9.2}",
        format!("{name} {accel}"),
        work.paths as f64 / seconds / 1e6,
        work.rays as f64 / seconds / 1e6
    );
}

fn builds(triangles: u32, accel: AccelKind) {
    let source = source("million");
    let (start, end) = (OnceLock::new(), OnceLock::new());
    let mut desc = source.desc.clone();
    desc.meshes[0].boulder = Some(triangles);
    desc.render.accel = accel;
    let scene = source
        .build_edited(desc, &|phase| {
            let when = match phase {
                scene::Phase::BuildingAccelerator { .. } => Some(&start),
                scene::Phase::Ready => Some(&end),
                scene::Phase::Reading => None,
            };
            when.map(|when| when.get_or_init(Instant::now));
            ControlFlow::Continue(())
        })
        .unwrap_or_else(|e| panic!("{e}"));
    let stats = scene.geometry().tree_stats().expect("a tree");
    let n = scene.primitives().triangles.len() as f64;
    println!(
        "{:<28}{:>9.3}{:>9.1}{:>9.2}",
        format!("{n} {accel}"),
        (*end.get().expect("built") - *start.get().expect("begun")).as_secs_f64(),
        (scene.geometry().accel_bytes() + scene.primitives().triangles.bytes()) as f64 / n,
        stats.references as f64 / n
    );
}
