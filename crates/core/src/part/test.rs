//! Tests of parts: whatever the split, the bits are those of one run.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::Vec3;

use super::*;
use crate::scene::load;

/// A small view of a shipped scene, as changed by `edit`.
fn view(edit: impl FnOnce(&mut SceneDesc)) -> View {
    view_of("cornell-box", edit)
}

fn view_of(name: &str, edit: impl FnOnce(&mut SceneDesc)) -> View {
    let path = format!("builtin:{name}.toml");
    let source = load(Path::new(&path)).expect("a shipped scene");
    let mut desc = source.desc.clone();
    // More than one tile, not all of them whole; a filter with two strata.
    (desc.render.width, desc.render.height) = (37, 21);
    desc.render.filter = "lanczos".parse().expect("a filter");
    edit(&mut desc);
    let scene = source
        .build_edited(desc, &crate::scene::unwatched)
        .expect("a scene");
    View::of(Arc::new(scene)).expect("a view")
}

/// The film of some samples, rendered in steps of `step`.
fn film(view: &View, samples: Range<u64>, step: u64) -> Film {
    let film = view.film().starting_at(samples.start);
    let mut end = samples.start;
    while end < samples.end {
        end = samples.end.min(end + step);
        view.render(&film, end, &AtomicBool::new(false));
    }
    film
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::TempDir::new().expect("a folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A part with some samples.
    fn part(&self, view: &View, samples: Range<u64>) -> PathBuf {
        let path = self.path(&format!("{}-{}.part", samples.start, samples.end));
        self.save(&path, view, &film(view, samples, 3));
        path
    }

    fn save(&self, path: &Path, view: &View, film: &Film) {
        let head = Head::new(view, ToneMap::default(), film, 1.5);
        write(path, &head, film).expect("a part");
    }
}

fn bits(image: &crate::Image) -> Vec<[u32; 3]> {
    let pixels = image.pixels.iter();
    pixels.map(|p| p.to_array().map(f32::to_bits)).collect()
}

#[test]
fn any_split_in_any_order_and_grouping_gives_the_bits_of_one_run() {
    // Without and with light that lands in other tiles.
    for name in ["cornell-box", "glass-sphere"] {
        any_split_gives_the_bits_of_one_run(&view_of(name, |_| ()));
    }
}

fn any_split_gives_the_bits_of_one_run(view: &View) {
    let folder = Folder::new();
    let whole = film(view, 0..11, 11);
    let picture = whole.develop();
    let [a, b, c, d] = [0..1, 1..4, 4..9, 9..11].map(|run| folder.part(view, run));
    let group = |name: &str, parts: &[&PathBuf]| {
        let parts: Vec<PathBuf> = parts.iter().map(|p| (*p).clone()).collect();
        let path = folder.path(name);
        Parts::open(&parts).unwrap().write(&path).unwrap();
        path
    };
    let ac = group("ac.part", &[&c, &a]);
    let bd = group("bd.part", &[&b, &d]);
    let bcd = group("bcd.part", &[&d, &b, &c]);
    for parts in [
        vec![&a, &b, &c, &d],
        vec![&d, &b, &a, &c],
        vec![&bd, &ac],
        vec![&bcd, &a],
    ] {
        let parts: Vec<PathBuf> = parts.into_iter().cloned().collect();
        let (sum, image) = Parts::open(&parts).unwrap().develop().unwrap();
        assert_eq!(bits(&image), bits(&picture));
        assert_eq!(sum.error, whole.error());
        assert_eq!([sum.paths, sum.rays], whole.work());
        assert!(sum.head.samples().eq(std::iter::once(0..11)));
        assert_eq!(sum.head.seconds, 1.5 * 4.0);
    }
    // One part over everything is that of one run, byte for byte but for the seconds.
    let (one, all) = (folder.path("one.part"), group("all.part", &[&bd, &ac]));
    let head = Head::new(view, ToneMap::default(), &whole, 6.0);
    write(&one, &head, &whole).unwrap();
    assert!(std::fs::read(one).unwrap() == std::fs::read(all).unwrap());
}

#[test]
fn invalid_samples_are_kept_with_their_places() {
    let (view, folder) = (view(|_| ()), Folder::new());
    let add = |film: &Film, samples: Range<u64>| {
        for tile in 0..film.tiles() {
            let (mut batch, first) = film.batch(tile);
            for sample in samples.clone() {
                let radiance = if sample % 3 == 1 {
                    Vec3::NAN
                } else {
                    Vec3::ONE
                };
                batch.add([4, 2], sample, 0, radiance);
            }
            assert!(film.merge(tile, &batch, first, samples.end));
        }
    };
    let whole = view.film();
    add(&whole, 0..300);
    let parts = [150..300, 0..150].map(|samples| {
        let film = view.film().starting_at(samples.start);
        add(&film, samples.clone());
        let path = folder.path(&format!("{}.part", samples.start));
        folder.save(&path, &view, &film);
        path
    });
    let (sum, image) = Parts::open(&parts).unwrap().develop().unwrap();
    assert_eq!(sum.invalid, whole.invalid());
    assert_eq!((sum.invalid.0, sum.invalid.1.len()), (600, 64));
    assert_eq!(bits(&image), bits(&whole.develop()));
}

#[test]
fn a_film_is_taken_up_where_it_was_left() {
    for name in ["cornell-box", "glass-sphere"] {
        a_film_of_a_view_is_taken_up(&view_of(name, |_| ()));
    }
}

fn a_film_of_a_view_is_taken_up(view: &View) {
    let folder = Folder::new();
    let path = folder.path("left.part");
    assert!(resume(&path, view, 2).unwrap().is_none());
    let left = view.film().starting_at(2);
    // Some tiles are a pass ahead.
    view.render(&left, 5, &AtomicBool::new(false));
    view.render_tiles(&left, &[0, 1, 2], 7, &AtomicBool::new(false));
    folder.save(&path, view, &left);
    let (taken_up, seconds) = resume(&path, view, 2).unwrap().expect("a film");
    assert_eq!(
        (taken_up.samples(), taken_up.most_samples(), seconds),
        (5, 7, 1.5)
    );
    view.render(&taken_up, 9, &AtomicBool::new(false));
    let whole = film(view, 2..9, 7);
    assert_eq!(bits(&taken_up.develop()), bits(&whole.develop()));
    assert_eq!(taken_up.work(), whole.work());
    // Of no use to others.
    let error = Parts::open(std::slice::from_ref(&path)).unwrap_err();
    assert!(
        error.contains("left.part: the render is not finished"),
        "{error}"
    );
    let error = resume(&path, view, 0).unwrap_err();
    assert!(
        error.contains("samples 2..5 instead of those from 0 on"),
        "{error}"
    );
}

#[test]
fn whatever_changes_the_picture_makes_a_part_foreign() {
    let folder = Folder::new();
    let plain = view(|_| ());
    let first = folder.part(&plain, 0..1);
    type Edit = (&'static str, fn(&mut SceneDesc));
    let edits: [Edit; 14] = [
        ("size 38x21 instead of 37x21", |d| d.render.width += 1),
        ("seed 1 instead of 0", |d| d.render.seed = 1),
        ("depth unlimited instead of", |d| d.render.depth = UNLIMITED),
        ("filter lanczos:2 instead of lanczos", |d| {
            d.render.filter.radius = 2.0
        }),
        ("method nee instead of reuse", |d| {
            d.render.method = crate::Method::Nee
        }),
        ("sampler independent instead of sobol", |d| {
            d.render.sampler = crate::SamplerKind::Independent;
        }),
        ("another camera", |d| d.camera.fov += 0.001),
        ("another camera", |d| d.camera.eye.x += 0.001),
        ("other shapes, materials or textures", |d| {
            d.background.z = 1e-9
        }),
        ("other shapes, materials or textures", |d| {
            d.materials[0].albedo.x *= 0.999
        }),
        ("other shapes, materials or textures", |d| {
            d.materials[0].mirror = 0.1
        }),
        ("other shapes, materials or textures", |d| {
            d.materials[0].glass = Some(1.5)
        }),
        ("other shapes, materials or textures", |d| {
            let lamp = d.materials.iter_mut().find(|m| m.emission != Vec3::ZERO);
            lamp.expect("a lamp").emission.y += 0.01;
        }),
        ("other shapes, materials or textures", |d| {
            d.quads.truncate(d.quads.len() - 1);
        }),
    ];
    for (i, (expected, edit)) in edits.into_iter().enumerate() {
        let other = view(edit);
        let path = folder.path(&format!("other {i}.part"));
        folder.save(&path, &other, &film(&other, 1..2, 1));
        let error = Parts::open(&[first.clone(), path.clone()]).unwrap_err();
        assert!(
            error.contains(&format!("other {i}.part: is of another picture"))
                && error.contains(expected),
            "{error}"
        );
        assert!(!error.contains('\n'));
        let error = resume(&path, &plain, 1).unwrap_err();
        assert!(error.contains("holds another render"), "{error}");
    }
    // What does not change it does not.
    let same = view(|d| {
        d.render.accel = crate::AccelKind::Brute;
        d.render.samples = 7;
        for material in &mut d.materials {
            material.name.push('x');
        }
        d.quads.iter_mut().for_each(|q| q.material.push('x'));
        d.spheres.iter_mut().for_each(|s| s.material.push('x'));
        d.meshes
            .iter_mut()
            .filter_map(|m| m.material.as_mut())
            .for_each(|m| m.push('x'));
    });
    let second = folder.part(&same, 1..2);
    Parts::open(&[first, second]).unwrap();
}

#[test]
fn gaps_and_overlaps_are_told_by_name() {
    let (view, folder) = (view(|_| ()), Folder::new());
    let [a, b, c] = [0..2, 2..4, 3..6].map(|run| folder.part(&view, run));
    let open =
        |parts: &[&PathBuf]| Parts::open(&parts.iter().map(|p| (*p).clone()).collect::<Vec<_>>());
    let error = open(&[&c, &b]).unwrap_err();
    assert!(
        error.contains("3-6.part: holds samples 3..4, as does") && error.contains("2-4.part"),
        "{error}"
    );
    let error = open(&[&a, &a]).unwrap_err();
    assert!(error.contains("0-2.part: holds samples 0..2"), "{error}");
    let error = open(&[&c, &a]).unwrap().develop().unwrap_err();
    assert!(
        error.contains("3-6.part: samples 2..3 are missing before it"),
        "{error}"
    );
    let error = open(&[&b]).unwrap().develop().unwrap_err();
    assert!(
        error.contains("2-4.part: samples 0..2 are missing before it"),
        "{error}"
    );
    let empty = folder.part(&view, 2..2);
    assert!(
        open(&[&a, &empty])
            .unwrap_err()
            .contains("2-2.part: holds no samples")
    );
}

#[test]
fn a_file_cut_short_or_changed_in_any_byte_is_refused() {
    let (view, folder) = (
        view(|d| (d.render.width, d.render.height) = (17, 3)),
        Folder::new(),
    );
    let path = folder.part(&view, 0..2);
    let good = std::fs::read(&path).unwrap();
    let picture = Parts::open(std::slice::from_ref(&path))
        .unwrap()
        .develop()
        .unwrap()
        .1;
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        Parts::open(std::slice::from_ref(&path))?.develop()
    };
    assert_eq!(bits(&read(&good).unwrap().1), bits(&picture));
    for length in (0..good.len()).step_by(7) {
        let error = read(&good[..length]).expect_err("cut short");
        let told = if length < MAGIC.len() {
            "is not a part"
        } else {
            "is cut short"
        };
        assert!(
            error.contains(told) && error.contains("0-2.part: "),
            "{length}: {error}"
        );
    }
    for i in (0..good.len()).step_by(3) {
        let mut bad = good.clone();
        bad[i] ^= 1 << (i % 8);
        let error = read(&bad).expect_err("a flipped bit");
        assert!(
            error.contains("0-2.part: ") && !error.contains('\n'),
            "{i}: {error}"
        );
    }
    let error = read(&[&good[..], &[0]].concat()).unwrap_err();
    assert!(error.contains("is damaged"), "{error}");
    let mut later = good.clone();
    later[MAGIC.len() - 2] = b'3';
    assert!(read(&later).unwrap_err().contains("another version"));
    assert!(read(b"").unwrap_err().contains("is not a part"));
}

#[test]
fn packing_keeps_every_bit_and_leaves_out_zeros() {
    let view = view(|d| (d.render.width, d.render.height) = (16, 16));
    let film = film(&view, 0..64, 64);
    let mut bytes = Vec::new();
    film.pack_tile(0, &mut bytes);
    let mut tile = film.empty_tile(0);
    assert_eq!(tile.add_packed(&bytes), Some(64));
    let mut again = Vec::new();
    tile.pack(&mut again);
    assert!(bytes == again);
    // Four cells of 56 bytes to a pixel.
    assert!(bytes.len() < 256 * 4 * 56 / 2, "{}", bytes.len());
    // A tile without samples costs next to nothing.
    let mut empty = Vec::new();
    view.film().pack_tile(0, &mut empty);
    assert!(empty.len() < 100);
}
