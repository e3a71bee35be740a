//! How soon the viewer follows: the time from a camera move to a picture that covers the window,
//! with the real session driven as a drag at 60 moves a second does, and the time from a wish to
//! the moment when the renderer has let go. `cargo bench -p lightbox`.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use lightbox::session::{Activity, Session};
use lightbox_core::settings::UNLIMITED;
use lightbox_core::{RenderSettings, View, scene};

const SIZE: [u32; 2] = [1280, 720];

fn main() {
    heading("from a camera move to a full picture");
    for name in ["teddy-diffuse", "million"] {
        row(name, camera_moves(name));
    }
    heading("from cancel to the return of a render of unlimited depth");
    for name in ["teddy-diffuse", "sphere-mirror", "million"] {
        row(name, cancels(name));
    }
}

fn camera_moves(name: &str) -> Vec<f64> {
    let session = Session::new(0, || ()).expect("a session");
    session.open(Path::new(&format!("builtin:{name}.toml")));
    while session.status().activity != Activity::Rendering {
        std::thread::sleep(Duration::from_millis(5));
    }
    let mut desc = (*session.status().desc).clone();
    [desc.render.width, desc.render.height] = SIZE;
    session.edit(1, desc.clone());
    std::thread::sleep(Duration::from_millis(500));

    let delay = |step| {
        let angle = step as f32 * 0.02;
        desc.camera.eye = 3.9 * glam::Vec3::new(angle.sin() * 0.2, 0.05, angle.cos());
        let before = session.snapshot().map_or(0, |s| s.number);
        let moved = Instant::now();
        session.edit(1, desc.clone());
        // Finer previews of the old camera are interrupted; one that comes at once was already
        // on its way and does not count.
        let mut seen = before;
        loop {
            let number = session.snapshot().map_or(0, |s| s.number);
            if number > seen && moved.elapsed() > Duration::from_millis(2) {
                return moved.elapsed().as_secs_f64() * 1e3;
            }
            seen = seen.max(number);
            assert!(moved.elapsed() < Duration::from_secs(5), "no picture");
            std::thread::sleep(Duration::from_micros(200));
        }
    };
    (0..180).map(delay).collect()
}

fn cancels(name: &str) -> Vec<f64> {
    let source = scene::load(Path::new(&format!("builtin:{name}.toml"))).expect("a scene");
    let scene = Arc::new(source.build(&scene::unwatched).expect("a scene"));
    let settings = RenderSettings {
        width: SIZE[0],
        height: SIZE[1],
        depth: UNLIMITED,
        ..source.desc.render
    };
    let view = View::new(scene, &source.desc.camera, settings).expect("a view");
    let delay = |round: u64| {
        let (film, cancel) = (view.film(), AtomicBool::new(false));
        std::thread::scope(|scope| {
            // Many samples of a pixel at a time, as late in a render.
            let render = scope.spawn(|| {
                view.render(&film, 256, &cancel);
                Instant::now()
            });
            std::thread::sleep(Duration::from_millis(20 + 7 * (round % 11)));
            let wish = Instant::now();
            cancel.store(true, Ordering::Relaxed);
            let end = render.join().expect("the render ends");
            (end - wish).as_secs_f64() * 1e3
        })
    };
    (0..100).map(delay).collect()
}

fn heading(what: &str) {
    println!(
        "{:<24}{:>8}{:>8}{:>8}{:>8}  ms {what} ({}x{})",
        "scene", "median", "90 %", "99 %", "worst", SIZE[0], SIZE[1]
    );
}

fn row(name: &str, mut delays: Vec<f64>) {
    delays.sort_by(f64::total_cmp);
    let at = |share: f64| delays[((delays.len() - 1) as f64 * share) as usize];
    println!(
        "{name:<24}{:>8.1}{:>8.1}{:>8.1}{:>8.1}",
        at(0.5),
        at(0.9),
        at(0.99),
        at(1.0)
    );
}
