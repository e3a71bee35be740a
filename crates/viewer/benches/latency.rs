//! How soon a picture that covers the window follows a camera move: drives the real session as a
//! drag at 60 moves a second does. `cargo bench -p lightbox`.

use std::path::Path;
use std::time::{Duration, Instant};

use lightbox::session::{Activity, Session};

fn main() {
    println!(
        "{:<24}{:>8}{:>8}{:>8}{:>8}  ms from a camera move to a full picture (1280x720)",
        "scene", "median", "90 %", "99 %", "worst"
    );
    for name in ["teddy-diffuse", "million"] {
        let session = Session::new(0, || ()).expect("a session");
        session.open(Path::new(&format!("builtin:{name}.toml")));
        while session.status().activity != Activity::Rendering {
            std::thread::sleep(Duration::from_millis(5));
        }
        let mut desc = (*session.status().desc).clone();
        (desc.render.width, desc.render.height) = (1280, 720);
        session.edit(1, desc.clone());
        std::thread::sleep(Duration::from_millis(500));

        let mut delays = Vec::new();
        for step in 0..180 {
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
                    break;
                }
                seen = seen.max(number);
                assert!(moved.elapsed() < Duration::from_secs(5), "no picture");
                std::thread::sleep(Duration::from_micros(200));
            }
            delays.push(moved.elapsed().as_secs_f64() * 1e3);
        }
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
}
