use std::path::Path;

use lightbox_core::color::ToneMap;
use lightbox_core::scene;

use super::*;
use crate::aov::Aov;

/// A picture of 4×4 tiles, and a governor that takes it for very slow.
fn picture(samples: u64) -> (Picture, Governor) {
    let source = scene::load(Path::new("builtin:sphere-mirror.toml")).expect("a scene");
    let scene = Arc::new(source.build(&scene::unwatched).expect("a scene"));
    let settings = RenderSettings {
        width: 64,
        height: 64,
        samples,
        depth: 3,
        ..source.desc.render
    };
    let view = View::new(scene, &source.desc.camera, settings).expect("a view");
    let mut governor = Governor::default();
    governor.measured(Duration::from_secs(1), 1);
    let picture = Picture::new(view, source.desc.camera, &governor);
    (picture, governor)
}

/// Runs on two threads, as many in every place.
fn on_two_threads<T: Send>(run: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
    pool.expect("threads").install(run)
}

const LOOK: Look = Look {
    tone: ToneMap {
        exposure: 0.5,
        offset: 0.0,
        curve: lightbox_core::color::ToneCurve::Filmic,
    },
    aov: Aov::COLOR,
};

#[test]
fn a_preview_is_named_until_the_film_covers_the_picture() {
    on_two_threads(|| {
        let (mut picture, mut governor) = picture(1);
        let go_on = AtomicBool::new(false);
        let mut scales = Vec::new();
        let mut preview = Vec::new();
        while picture.has_previews() {
            let snapshot = picture.preview(&mut governor, &go_on, LOOK).expect("shown");
            assert_eq!(snapshot.picture, [64, 64]);
            scales.extend(snapshot.preview);
            preview = enlarge(&snapshot.rgb(), *scales.last().expect("a scale"), 64, 64);
        }
        assert_eq!(scales, [32, 16, 8, 4, 2]);
        // Half of the tiles, with the preview in the corners.
        governor.measured(Duration::from_secs(1), 1);
        let half = picture.slice(&mut governor, &go_on, LOOK).expect("shown");
        assert_eq!((half.preview, half.size), (Some(2), [64, 64]));
        assert!(half.rgb()[..16 * 3] == preview[..16 * 3] && half.rgb() != preview);
        let redrawn = picture.redraw(LOOK, &go_on).expect("shown");
        assert!(redrawn.rgb() == half.rgb() && redrawn.preview == Some(2));
        let mut last = half;
        while !picture.is_done() {
            assert_eq!(last.preview, Some(2));
            last = picture.slice(&mut governor, &go_on, LOOK).expect("shown");
        }
        assert_eq!(last.preview, None);
    });
}

#[test]
fn a_slice_changes_its_patches_and_no_other() {
    on_two_threads(|| {
        let (small, mut governor) = picture(1);
        // Eight patches, and as many tiles for each of two threads in the middle two.
        let settings = RenderSettings {
            width: 256,
            height: 128,
            ..small.view.settings
        };
        let view = View::new(small.view.scene.clone(), &small.camera, settings).expect("a view");
        let mut picture = Picture::new(view, small.camera, &governor);
        let go_on = AtomicBool::new(false);
        picture.previews.clear();
        picture.prefer(Some([0.3, 0.1, 0.4, 0.2]));
        let before = picture.slice(&mut governor, &go_on, LOOK).expect("shown");
        let rect = |tile: usize| picture.film.tile_rect(tile);
        let patch = |tile: usize| [rect(tile).x, rect(tile).y].map(|n| n as usize / 64 * 64);
        let first = picture.next_tile;
        // Very slow, whatever it took.
        (picture.work.paths, picture.progress.seconds) = (1, 1.0);
        let next: Vec<_> = picture.order[first..first + 8]
            .iter()
            .map(|i| patch(*i))
            .collect();
        let after = picture.slice(&mut governor, &go_on, LOOK).expect("shown");
        assert!(picture.next_tile == first + 8 && picture.is_in_pass());
        let changed: Vec<_> = after
            .patches
            .since(&before.patches)
            .map(|(at, _)| at)
            .collect();
        assert!(next.iter().all(|at| changed.contains(at)));
        assert!(
            changed.iter().all(|at| next.contains(at)) && changed.len() < 8,
            "{changed:?}"
        );
        let same = picture.snapshot(LOOK);
        assert_eq!(same.patches.since(&after.patches).count(), 0);
    });
}

#[test]
fn slices_come_to_the_picture_of_one_render() {
    on_two_threads(|| {
        let (mut picture, mut governor) = picture(24);
        let (go_on, stop) = (AtomicBool::new(false), AtomicBool::new(true));
        while picture.has_previews() {
            picture.preview(&mut governor, &go_on, LOOK);
        }
        let mut last = None;
        while !picture.is_done() {
            // An interrupted slice loses nothing.
            assert!(picture.slice(&mut governor, &stop, LOOK).is_none());
            last = picture.slice(&mut governor, &go_on, LOOK);
        }
        let whole = picture.view.film();
        let work = picture.view.render(&whole, 24, &go_on);
        assert_eq!(
            [picture.work.paths, picture.work.rays],
            [work.paths, work.rays]
        );
        assert_eq!(
            [picture.film.samples(), picture.film.most_samples()],
            [24; 2]
        );
        assert!(last.expect("shown").rgb() == tone_mapped(&whole.develop(), LOOK.tone));
        assert_eq!(picture.error(), whole.error());
        assert!(picture.error().is_some());
    });
}

/// Fewer samples than there are, in the midst of a pass: the pass is finished, so that the picture
/// is one that can be made again.
#[test]
fn a_pass_ends_evenly() {
    on_two_threads(|| {
        let (mut picture, mut governor) = picture(24);
        let go_on = AtomicBool::new(false);
        while picture.film.samples() == 0 {
            picture.slice(&mut governor, &go_on, LOOK);
        }
        // As if it had been slow: the next slice is a part of a pass.
        picture.progress.seconds = 1e9;
        picture.slice(&mut governor, &go_on, LOOK);
        let held = |picture: &Picture| [picture.film.samples(), picture.film.most_samples()];
        assert_eq!(held(&picture), [1, 2]);
        picture.limits.samples = Some(1);
        assert!(!picture.is_done());
        while !picture.is_done() {
            picture.slice(&mut governor, &go_on, LOOK);
        }
        assert_eq!(held(&picture), [2; 2]);
    });
}

/// The error that is shown is that of all samples, though passes before were not measured.
#[test]
fn the_last_picture_is_measured() {
    on_two_threads(|| {
        let (mut picture, mut governor) = picture(1000);
        let go_on = AtomicBool::new(false);
        while picture.is_measured() || picture.next_tile < picture.film.tiles() {
            picture.slice(&mut governor, &go_on, LOOK);
        }
        // Enough, all at once.
        picture.limits.samples = Some(picture.film.samples());
        assert!(picture.is_done() && !picture.is_measured());
        assert_ne!(picture.error(), picture.film.error());
        picture.redraw(LOOK, &go_on).expect("shown");
        assert!(picture.is_measured() && picture.point().is_some());
        assert_eq!(picture.error(), picture.film.error());
    });
}

/// A region that is asked for in the midst of a pass comes next; the rest follows, and the picture
/// is the same.
#[test]
fn a_region_comes_first_and_nothing_is_lost() {
    on_two_threads(|| {
        let go_on = AtomicBool::new(false);
        let (mut picture, mut governor) = picture(3);
        picture.previews.clear();
        // The first half of the pass: from the centre.
        picture.slice(&mut governor, &go_on, LOOK).expect("shown");
        // So slow that a slice is never longer than it has to be.
        picture.progress.seconds = 1e6;
        let samples = |picture: &Picture| -> Vec<u64> {
            let all = 0..picture.film.tiles();
            all.map(|i| picture.film.batch(i).1).collect()
        };
        let before = samples(&picture);
        assert!(before.contains(&0) && before.contains(&1), "{before:?}");
        // The left column of 4×4 tiles, and what touches it.
        picture.prefer(Some([0.0, 0.0, 0.1, 1.0]));
        picture.slice(&mut governor, &go_on, LOOK).expect("shown");
        let after = samples(&picture);
        for (i, samples) in after.iter().enumerate() {
            let is_left = picture.film.tile_rect(i).x == 0;
            assert!(
                *samples >= before[i] && (!is_left || *samples == 1),
                "{i}: {after:?}"
            );
        }
        assert!(after.contains(&0), "the rest waits: {after:?}");
        while !picture.is_done() {
            picture.slice(&mut governor, &go_on, LOOK);
        }
        let film = picture.view.film();
        picture.view.render(&film, 3, &go_on);
        assert!(picture.film.develop() == film.develop());
    });
}

/// A view that takes long is drawn slice by slice, and no colour of another one stays beside it.
#[test]
fn a_view_is_drawn_as_far_as_it_is_known() {
    on_two_threads(|| {
        let (go_on, stop) = (AtomicBool::new(false), AtomicBool::new(true));
        let aov = Aov::all().find(|aov| aov.name() == "path length");
        let look = Look {
            aov: aov.expect("a view"),
            ..LOOK
        };
        let (mut picture, mut governor) = picture(1);
        let mut preview = Vec::new();
        while picture.has_previews() {
            preview = picture
                .preview(&mut governor, &go_on, look)
                .expect("shown")
                .rgb();
        }
        // The last preview stands where nothing is drawn yet.
        assert!(picture.redraw(look, &stop).is_none() && !picture.is_drawn());
        let waits = picture.snapshot(look);
        assert!(waits.preview == Some(1) && waits.rgb() == enlarge(&preview, 2, 64, 64));
        let to_the_end = |picture: &mut Picture| loop {
            let drawn = picture.redraw(look, &go_on).expect("shown");
            assert_eq!(drawn.preview.is_none(), picture.is_drawn());
            if picture.is_drawn() {
                return drawn;
            }
        };
        let whole = to_the_end(&mut picture);
        let all: Vec<usize> = (0..picture.film.tiles()).collect();
        let scope = picture.scope(look);
        let painted = paint(look, &scope, &picture.view, &picture.film, &all, &go_on);
        let mut at_once = Patches::black([64, 64]);
        put(&mut at_once, painted.expect("not interrupted"));
        assert!(at_once.rgb() == whole.rgb());

        let light = picture.slice(&mut governor, &go_on, LOOK).expect("shown");
        picture.redraw(LOOK, &go_on).expect("shown");
        assert!(light.rgb() != whole.rgb() && picture.is_drawn());
        assert!(picture.redraw(look, &stop).is_none());
        assert!(picture.snapshot(look).rgb().iter().all(|v| *v == 0));
        assert!(to_the_end(&mut picture).rgb() == whole.rgb());
        // A region that is wanted first is no reason to do it once more.
        picture.prefer(Some([0.0, 0.0, 0.1, 1.0]));
        assert!(picture.is_drawn());
    });
}
