//! The lab tested in turn: known defects are planted in the core, and the case meant for each
//! must fail. A binary of its own, because a planted defect is one of the whole process.

use lightbox_core::agreement::{Agreement, Light};
use lightbox_core::planted::{Bug, plant};
use lightbox_core::{Film, Filter, FilterKind, Method, lab};
use lightbox_tests::{built, film, shipped, view, written};

/// Defects and the case that must find each.
const CAUGHT_BY: &[(Bug, &str)] = &[
    (Bug::CosineDropped, "L01"),
    (Bug::PdfTimes1_02, "L07"),
    (Bug::OneSidedFlagFlipped, "L03"),
    (Bug::RouletteWeightOmitted, "G03"),
    (Bug::LastBounceEmissionDoubled, "G02"),
    (Bug::MirrorWeighted, "B03"),
    (Bug::UReachesOne, "Y01"),
    (Bug::DimensionsShared, "Y07"),
    (Bug::InvalidSamplesKept, "F04"),
    (Bug::StrictEdges, "T02"),
    (Bug::SeedRootRule, "S04"),
    (Bug::EpsilonTimes100, "I04"),
];

/// Whether every figure of a case is within its bound. A probe that panics does not hold.
fn holds(id: &str) -> bool {
    let case = lab::find(id).unwrap_or_else(|| panic!("no case {id}"));
    let lab::Check::Probe(probe) = case.check else {
        panic!("{id} has no probe");
    };
    std::panic::catch_unwind(probe).is_ok_and(|figures| figures.iter().all(lab::Figure::holds))
}

#[test]
fn every_planted_defect_is_found_by_the_case_meant_for_it() {
    for (bug, id) in CAUGHT_BY {
        plant(None);
        assert!(holds(id), "{id} fails with nothing planted");
        plant(Some(*bug));
        assert!(!holds(id), "{id} does not see {bug:?}");
    }
    plant(None);
    agreement_sees_biased_methods();
    what_is_shared_falls_where_it_belongs();
    caustics_in_a_mirror_are_those_of_the_room();
    outlines_of_lamps_settle_where_they_belong();
}

/// A lamp and a mirror that shows it, and nothing else.
const LAMP: &str = r#"
[camera]
eye = [0, 0, 4]
target = [0, 0, 0]
fov = 40

[[material]]
name = "lamp"
albedo = [0, 0, 0]
emission = [50, 50, 50]

[[material]]
name = "mirror"
mirror = 0.9

[[quad]]
material = "lamp"
corners = [[-0.7, 0.11, 0], [0.7, 0.2, 0], [0.7, 0.93, 0], [-0.7, 0.8, 0]]

[[quad]]
material = "mirror"
corners = [[-1, -0.1, 2], [1, -0.1, 2], [1, -0.1, -2], [-1, -0.1, -2]]
"#;

/// Lamps that are seen, straight or by mirrors, are as large as ever, and their outlines take fewer samples.
fn outlines_of_lamps_settle_where_they_belong() {
    let scene = written(LAMP);
    for kind in [FilterKind::Box, FilterKind::Gaussian] {
        let picture = |method, samples| {
            film(&view(&scene, |s| {
                (s.width, s.height) = (40, 40);
                (s.method, s.samples, s.filter) = (method, samples, Filter::new(kind));
            }))
            .develop()
            .pixels
        };
        let truth = picture(Method::Naive, 1 << 14);
        let error = |method| {
            let pixels = picture(method, 64);
            let errors = pixels.iter().zip(&truth).map(|(a, b)| (a.y - b.y).powi(2));
            errors.sum::<f32>()
        };
        let naive = error(Method::Naive);
        for bug in [None, Some(Bug::SightedTwice)] {
            plant(bug);
            let mis = error(Method::Mis);
            plant(None);
            let settles = mis < naive / 15.0;
            assert_eq!(settles, bug.is_none(), "{kind:?}, {bug:?}: {naive} {mis}");
        }
    }
}

/// A room with a glass sphere, seen in a mirror that fills the picture and is a caster itself.
const MIRRORED: &str = r#"
[camera]
eye = [0, 0, 0]
target = [0, -0.1, -1]
fov = 60

[[material]]
name = "plaster"
albedo = [0.6, 0.6, 0.6]

[[material]]
name = "mirror"
mirror = 1

[[material]]
name = "glass"
glass = 1.5

[[material]]
name = "lamp"
albedo = [0, 0, 0]
emission = [40, 40, 40]

[[quad]]
material = "mirror"
corners = [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1]]

[[quad]]
material = "plaster"
corners = [[-1, -1, 2], [1, -1, 2], [1, -1, -1], [-1, -1, -1]]

[[quad]]
material = "plaster"
corners = [[-1, 1, -1], [1, 1, -1], [1, 1, 2], [-1, 1, 2]]

[[quad]]
material = "plaster"
corners = [[1, -1, 2], [-1, -1, 2], [-1, 1, 2], [1, 1, 2]]

[[quad]]
material = "plaster"
corners = [[-1, -1, 2], [-1, -1, -1], [-1, 1, -1], [-1, 1, 2]]

[[quad]]
material = "plaster"
corners = [[1, -1, -1], [1, -1, 2], [1, 1, 2], [1, 1, -1]]

[[sphere]]
material = "glass"
center = [0.2, -0.5, 1.2]
radius = 0.35

[[quad]]
material = "lamp"
corners = [[-0.2, 0.99, 0.2], [0.2, 0.99, 0.2], [0.2, 0.99, 0.6], [-0.2, 0.99, 0.6]]
"#;

/// The same room, darker, with the lamp in the glass, and the camera between two mirrors that throw its rays to and fro
/// before they leave: roulette may end them where they do.
fn mirrored_at_length() -> String {
    let mut text = MIRRORED.to_string();
    for (from, to) in [
        ("eye = [0, 0, 0]", "eye = [0, -0.98, 0.5]"),
        ("target = [0, -0.1, -1]", "target = [0, 0, -0.5]"),
        ("fov = 60", "fov = 20"),
        ("[0.6, 0.6, 0.6]", "[0.1, 0.1, 0.1]"),
        ("radius = 0.35", "radius = 0.5"),
    ] {
        assert!(text.contains(from));
        text = text.replace(from, to);
    }
    text.truncate(text.rfind("[[quad]]").expect("the lamp"));
    text += "[[sphere]]\nmaterial = \"lamp\"\ncenter = [0.2, -0.5, 1.2]\nradius = 0.4\n";
    for z in [0.45, 0.55] {
        let corners = [
            [-1.0, -1.0, z],
            [1.0, -1.0, z],
            [1.0, -0.6, z],
            [-1.0, -0.6, z],
        ];
        text += &format!("[[quad]]\nmaterial = \"mirror\"\ncorners = {corners:?}\n");
    }
    text
}

/// What mirrors show of caustics is found by anchors and their probes, and met by paths: the same light.
fn caustics_in_a_mirror_are_those_of_the_room() {
    agrees_with_mis(
        MIRRORED,
        &[
            (None, Method::Caustics),
            (None, Method::Reuse),
            (Some(Bug::ProbesCountedTwice), Method::Caustics),
            (Some(Bug::CausticsCountedTwice), Method::Caustics),
            (Some(Bug::BranchesCountedTwice), Method::Caustics),
        ],
    );
    agrees_with_mis(
        &mirrored_at_length(),
        &[
            (None, Method::Caustics),
            (Some(Bug::RouletteChanceOmitted), Method::Caustics),
        ],
    );
}

/// A method finds the light that paths alone find if and only if nothing is planted.
fn agrees_with_mis(text: &str, cases: &[(Option<Bug>, Method)]) {
    let scene = written(text);
    // The mean, and the variance of it.
    let mean = |method, samples| {
        let means: Vec<f64> = (0..8)
            .map(|seed| {
                let picture = film(&view(&scene, |s| {
                    (s.width, s.height, s.depth) = (20, 20, 9);
                    (s.method, s.samples, s.seed) = (method, samples, seed);
                }))
                .develop();
                picture.pixels.iter().map(|p| f64::from(p.y)).sum::<f64>() / 400.0
            })
            .collect();
        let mean = means.iter().sum::<f64>() / 8.0;
        let squares = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>();
        (mean, squares / 56.0)
    };
    let (truth, variance) = mean(Method::Mis, 2048);
    for &(bug, method) in cases {
        plant(bug);
        let (found, of_found) = mean(method, 512);
        plant(None);
        let sigmas = (found - truth).abs() / (variance + of_found).sqrt();
        assert_eq!(
            sigmas < 4.0,
            bug.is_none(),
            "{bug:?}: {found} for {truth}, {sigmas} σ"
        );
    }
}

/// Pixels share within a tile: what one gets too much another lacks, which means of tiles do not see.
fn what_is_shared_falls_where_it_belongs() {
    let scene = built(&shipped("cornell-box"));
    let render = |method, samples| {
        film(&view(&scene, |s| {
            (s.width, s.height) = (16, 16);
            (s.method, s.samples) = (method, samples);
        }))
    };
    let noise = |film: &Film| film.error().expect("two samples").rel_mse;
    let mis = render(Method::Mis, 4096);
    let truth = mis.develop();
    for bug in [
        None,
        Some(Bug::ReusedCosineDropped),
        Some(Bug::ReusedUnseen),
    ] {
        plant(bug);
        let reuse = render(Method::Reuse, 4096);
        plant(None);
        let shared = reuse.develop();
        let pairs = shared.pixels.iter().zip(&truth.pixels);
        let error = pairs.map(|(a, b)| ((*a - b).powf(2.0) / (b * b + 0.01)).element_sum());
        let error = f64::from(error.sum::<f32>()) / (3.0 * 256.0);
        let ratio = error / (noise(&mis) + noise(&reuse));
        assert_eq!(ratio < 2.0, bug.is_none(), "{bug:?}: {ratio}");
    }
}

/// A defect that one method has and another has not makes them disagree; without it they agree.
fn agreement_sees_biased_methods() {
    let light = |name, method, seed| {
        let scene = built(&shipped(name));
        Light::of(&film(&view(&scene, |s| {
            (s.width, s.height, s.samples) = (32, 32, 1024);
            (s.method, s.seed) = (method, seed);
        })))
        .expect("two samples")
    };
    for (name, bug, method) in [
        ("cornell-box", None, Method::Mis),
        ("cornell-box", None, Method::Nee),
        ("cornell-box", Some(Bug::CosineDropped), Method::Nee),
        ("cornell-box", Some(Bug::CosineDropped), Method::Mis),
        ("cornell-box", Some(Bug::OneSidedFlagFlipped), Method::Mis),
        ("cornell-box", None, Method::Reuse),
        ("sphere-mirror", None, Method::Mis),
        ("sphere-mirror", Some(Bug::DetoursCountedTwice), Method::Mis),
        ("glass-sphere", None, Method::Caustics),
        (
            "glass-sphere",
            Some(Bug::CausticsCountedTwice),
            Method::Caustics,
        ),
    ] {
        let naive = light(name, Method::Naive, 1);
        plant(bug);
        let light = light(name, method, 2);
        plant(None);
        let agreement = Agreement::between(&naive, &light);
        assert_eq!(
            agreement.holds(),
            bug.is_none(),
            "{bug:?} in {method}, {name}: p = {}",
            agreement.p
        );
    }
}
