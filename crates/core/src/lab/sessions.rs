//! Many threads, many changes, many samples: what a viewer does to a renderer.

use glam::Vec3;

use super::trial::{bits, picture, scene, view};
use super::{Bound, Case, Check, Figure};
use crate::Filter;
use crate::film::Film;
use crate::filter::FilterSampler;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "W01",
        title: "any number of threads",
        failure: "Generators per thread and sums in the order of arrival give another picture at \
                  each run.",
        cure: "Numbers by pixel and sample, exact sums: the same bits.",
        check: Check::Probe(threads),
        scene: None,
        picture: None,
    },
    Case {
        id: "W02",
        title: "a thousand camera moves in the middle of a pass",
        failure: "A tile of an older view is blended into the new picture.",
        cure: "A change starts a new film: late tiles have nowhere to land.",
        check: Check::Test("crates/viewer/tests/stability.rs::moves_leave_nothing_behind"),
        scene: None,
        picture: None,
    },
    Case {
        id: "W03",
        title: "windows without size, and larger than a texture",
        failure: "A texture of 0 pixels, or above the driver's limit, ends the program.",
        cure: "Impossible sizes are refused in a line; the picture there is stays.",
        check: Check::Test("crates/viewer/tests/stability.rs::impossible_sizes_are_survived"),
        scene: None,
        picture: None,
    },
    Case {
        id: "W04",
        title: "a thread that panics, a window closed during a build",
        failure: "A poisoned lock stops the window; closing waits for a build that takes minutes.",
        cure: "Panics cost one picture; locks are taken over; nobody waits for a loader.",
        check: Check::Test("crates/viewer/tests/stability.rs::panics_and_closing_do_not_hang"),
        scene: None,
        picture: None,
    },
    Case {
        id: "W05",
        title: "3.4·10¹¹ samples",
        failure: "A counter of 32 bits wraps, one in f32 stops.",
        cure: "64 bits.",
        check: Check::Probe(counters),
        scene: None,
        picture: None,
    },
];

fn threads() -> Vec<Figure> {
    let scene = scene(
        "background = [0.3, 0.4, 0.5]
[render]
width = 50
height = 37
samples = 8
[[material]]
name = 'grey'
mirror = 0.3
[[material]]
name = 'glass'
glass = 1.5
[[material]]
name = 'lamp'
emission = [3, 2, 1]
[[quad]]
material = 'grey'
corners = [[-2, -1, 2], [2, -1, 2], [2, -1, -2], [-2, -1, -2]]
[[quad]]
material = 'lamp'
corners = [[-1, 1.5, -1], [1, 1.5, -1], [1, 1.5, 1], [-1, 1.5, 1]]
[[sphere]]
material = 'glass'
center = [-0.5, -0.5, 0.5]
radius = 0.5
[[sphere]]
material = 'grey'
center = [0.6, -0.4, 0]
radius = 0.6
",
    );
    let view = view(&scene, |_| ());
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map(|pool| bits(&pool.install(|| picture(&view))))
            .unwrap_or_default()
    };
    let one = on(1);
    let differ: usize = [2, 3, 8, 64]
        .iter()
        .map(|threads| {
            let other = on(*threads);
            if other.len() == one.len() {
                other.iter().zip(&one).filter(|(a, b)| a != b).count()
            } else {
                one.len()
            }
        })
        .sum();
    // 8 samples of 1850 pixels added in f32 as they might arrive: forwards or backwards.
    let samples = |pixel: usize| {
        (0..8u32).map(move |i| {
            let sampler = crate::sampler::Sampler::new(
                crate::SamplerKind::Independent,
                31,
                [pixel as u32, 0],
                i.into(),
            );
            sampler.get_2d(crate::sampler::Dim::Pixel)[0]
        })
    };
    let naive = (0..one.len()).filter(|pixel| {
        let forward = samples(*pixel).fold(0.0f32, |sum, x| sum + x);
        forward != samples(*pixel).rev().fold(0.0f32, |sum, x| sum + x)
    });
    vec![Figure {
        what: "pixels that differ on 2, 3, 8 and 64 threads (naive: f32 sums by arrival)",
        naive: Some(naive.count() as f64),
        lightbox: differ as f64,
        bound: Bound::Exactly(0.0),
    }]
}

fn counters() -> Vec<Figure> {
    // 20 000 samples of 4096² pixels, all counted in one pixel.
    let total = 20_000u64 * 4096 * 4096;
    let film = Film::new(1, 1, &FilterSampler::new(Filter::default()));
    let (mut batch, _) = film.batch(0);
    batch.add([0, 0], total - 2, 0, Vec3::ONE);
    batch.add([0, 0], total - 1, 0, Vec3::ONE);
    film.merge(0, &batch, 0, total);
    let (mut late, first) = film.batch(0);
    late.add([0, 0], total, 0, Vec3::ONE);
    let accepted = film.merge(0, &late, first, total + 1);
    vec![
        Figure {
            what: "samples counted",
            naive: Some(f64::from((total + 1) as u32)),
            lightbox: film.samples() as f64,
            bound: Bound::Exactly((total + 1) as f64),
        },
        Figure {
            what: "batches refused at such an index",
            naive: None,
            lightbox: f64::from(u8::from(!accepted)),
            bound: Bound::Exactly(0.0),
        },
    ]
}
