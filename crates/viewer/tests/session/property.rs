//! The session as a state machine, also a fuzz target: whatever was done before, the picture in
//! the end is the one that a fresh headless render gives.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use glam::Vec3;
use lightbox::aov::Aov;
use lightbox::session::{Activity, Look, Session, Status};
use lightbox_core::color::{ToneCurve, ToneMap};
use lightbox_core::filter::{Filter, FilterKind};
use lightbox_core::image_io::{read, tone_mapped};
use lightbox_core::scene::{CameraDesc, MeshDesc, Source};
use lightbox_core::{AccelKind, Camera, Image, Method, SamplerKind, SceneDesc, View};
use lightbox_tests::properties::Draw;
use lightbox_tests::shipped;

/// Samples of the last picture; pictures before have fewer.
const LAST: u64 = 5;

/// Random edits of a session with a few threads; panics if the picture in the end differs in a
/// bit from a headless render of the same description.
pub fn session(bytes: &[u8]) {
    let mut draw = Draw::new(bytes);
    let folder = tempfile::tempdir().expect("a folder");
    let session = Session::new(1 + draw.below(3), || ()).expect("a session");
    let mut opens = 0;
    let mut path = open(&session, &mut draw, folder.path(), &mut opens);
    let mut is_superseded = false;
    for _ in 0..24 {
        if !draw.has_more() {
            break;
        }
        match draw.below(16) {
            0 => {
                path = open(&session, &mut draw, folder.path(), &mut opens);
                is_superseded = false;
            }
            1 => {
                session.open(&folder.path().join("missing.toml"));
                is_superseded = true;
            }
            2 => session.set_paused(draw.below(2) == 0),
            3 => {
                let aovs: Vec<Aov> = Aov::all().collect();
                let aov = draw.of(&aovs);
                let tone = tone(&mut draw);
                session.set_look(Look { tone, aov });
            }
            4 => session.save(folder.path().join(draw.of(&[
                "a.png",
                "b.exr",
                "no/folder.png",
                "c.gif",
            ]))),
            5 | 6 => std::thread::sleep(Duration::from_micros(50 * u64::from(draw.byte()))),
            _ => {
                let status = session.status();
                let mut desc = (*status.desc).clone();
                edit(&mut draw, &mut desc);
                session.edit(status.opened, desc);
            }
        }
    }

    if is_superseded {
        path = open(&session, &mut draw, folder.path(), &mut opens);
    }
    let status = wait(&session, |s| {
        s.scene.as_ref().is_some_and(|s| s.path() == path)
    });
    let mut desc = (*status.desc).clone();
    for _ in 0..draw.below(3) {
        edit(&mut draw, &mut desc);
        session.edit(status.opened, desc.clone());
    }
    // Whatever is wrong with the description is put right by the last edit.
    desc.materials
        .iter_mut()
        .for_each(|m| m.albedo = m.albedo.min(Vec3::ONE));
    desc.spheres
        .iter_mut()
        .for_each(|s| s.radius = s.radius.abs());
    desc.render.width = desc.render.width.max(1);
    if Camera::new(&desc.camera, desc.render.width, desc.render.height).is_err() {
        desc.camera = shipped("cornell-box").desc.camera;
    }
    desc.render.samples = LAST;
    session.set_paused(true);
    session.edit(status.opened, desc.clone());
    session.set_paused(false);
    let tone = tone(&mut draw);
    session.set_look(Look {
        tone,
        aov: Aov::COLOR,
    });

    wait(&session, |s| {
        let is_taken_up = s.scene.as_ref().is_some_and(|scene| {
            scene.desc().same_shapes(&desc)
                && (&scene.desc().materials, scene.desc().background)
                    == (&desc.materials, desc.background)
                && scene.desc().same_assignments(&desc)
        });
        is_taken_up && s.samples == LAST && s.activity == Activity::Done && s.loading.is_none()
    });
    let expected = headless(&desc, &path);
    let file = folder.path().join("last.exr");
    session.save(file.clone());
    let is_it = |text: &str| text.starts_with("saved") && text.ends_with("last.exr");
    until("the picture was not saved", || {
        session.take_notices().iter().any(|n| is_it(&n.text))
    });
    let saved = read(&file).unwrap_or_else(|e| panic!("{e}"));
    assert!(
        bits(&saved) == bits(&expected),
        "the saved picture differs: {:?}",
        desc.render
    );
    // The screen follows the tone map a moment later.
    let shown = tone_mapped(&expected, tone);
    until("the shown picture differs", || {
        let snapshot = session.snapshot();
        snapshot.is_some_and(|s| s.preview.is_none() && s.rgb() == shown)
    });
}

/// How long the engine may take for what should take milliseconds.
const PATIENCE: Duration = Duration::from_secs(60);

/// Waits until something holds.
fn until(complaint: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < PATIENCE, "{complaint}");
        std::thread::sleep(Duration::from_micros(100));
    }
}

/// Waits for a state.
fn wait(session: &Session, is_there: impl Fn(&Status) -> bool) -> Status {
    let mut status = session.status();
    until("the session never came to rest", || {
        status = session.status();
        is_there(&status)
    });
    status
}

/// Size and bits.
fn bits(image: &Image) -> (u32, u32, Vec<[u32; 3]>) {
    let bits = |p: &Vec3| p.to_array().map(f32::to_bits);
    (
        image.width,
        image.height,
        image.pixels.iter().map(bits).collect(),
    )
}

/// Opens a scene under a name that it has not had before.
fn open(session: &Session, draw: &mut Draw, folder: &Path, opens: &mut u32) -> PathBuf {
    let name = draw.of(&[
        "cornell-box",
        "sphere-mirror",
        "glass-sphere",
        "white-furnace",
    ]);
    *opens += 1;
    let path = folder.join(format!("{opens}.toml"));
    let text = std::fs::read_to_string(
        lightbox_tests::scenes_folder()
            .join(name)
            .with_extension("toml"),
    );
    // Small from the start: only the last picture is looked at.
    let text = format!(
        "{}\n[render]\nwidth = 20\nheight = 15\nsamples = 2\n",
        text.expect("a shipped scene")
    );
    std::fs::write(&path, text).expect("a file");
    session.open(&path);
    path
}

/// Changes something that the panels or the mouse can change.
fn edit(draw: &mut Draw, desc: &mut SceneDesc) {
    if desc.materials.is_empty() {
        return; // Nothing has been opened yet.
    }
    match draw.below(12) {
        0 | 1 => desc.camera.eye += draw.point(3) * 0.1,
        2 => {
            desc.camera = CameraDesc {
                fov: 20.0 + f32::from(draw.byte()) * 0.5,
                ..desc.camera
            }
        }
        3 => desc.render.samples = 1 + draw.below(LAST as usize - 1) as u64,
        4 => {
            (desc.render.width, desc.render.height) =
                (draw.below(40) as u32, 1 + draw.below(24) as u32)
        }
        5 => {
            desc.render.method = draw.of(Method::ALL);
            desc.render.sampler = draw.of(SamplerKind::ALL);
            desc.render.seed = u64::from(draw.word());
        }
        6 => {
            desc.render.filter = Filter::new(draw.of(&FilterKind::ALL));
            desc.render.depth = 1 + draw.below(6) as u32;
        }
        7 => desc.render.accel = draw.of(AccelKind::ALL),
        8 => {
            let i = draw.below(desc.materials.len());
            // Twice what is possible, now and then.
            desc.materials[i].albedo = draw.of(&[Vec3::ONE, Vec3::splat(0.3), Vec3::splat(2.0)]);
            desc.materials[i].mirror = draw.unit();
        }
        9 => desc.background = Vec3::splat(draw.unit()),
        10 if !desc.spheres.is_empty() => {
            let i = draw.below(desc.spheres.len());
            desc.spheres[i].radius = draw.of(&[0.1, 0.3, 0.5, -0.3]);
        }
        _ if desc.meshes.is_empty() => desc.meshes.push(MeshDesc {
            name: "rock".into(),
            material: Some(desc.materials[0].name.clone()),
            file: None,
            boulder: Some(20 + u32::from(draw.byte()) * 8),
            scale: 0.3,
            rotate: Vec3::ZERO,
            translate: draw.point(2) * 0.1,
        }),
        _ => desc.meshes.clear(),
    }
}

fn tone(draw: &mut Draw) -> ToneMap {
    ToneMap {
        exposure: draw.unit(),
        offset: draw.unit() - 0.5,
        curve: draw.of(&ToneCurve::ALL),
    }
}

fn headless(desc: &SceneDesc, path: &Path) -> Image {
    let scene = Source::from_desc(desc.clone(), path)
        .build(&lightbox_core::scene::unwatched)
        .unwrap_or_else(|e| panic!("{e}"));
    let view = View::of(scene.into()).unwrap_or_else(|e| panic!("{e}"));
    let film = view.film();
    view.render(&film, desc.render.samples, &AtomicBool::new(false));
    film.develop()
}
