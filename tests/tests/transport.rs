//! Light transport in the shipped scenes. Small scenes with analytic answers are cases of the
//! stability lab.

use std::sync::Arc;

use lightbox_core::lab::stats::{Comparisons, Replicates};
use lightbox_core::settings::UNLIMITED;
use lightbox_core::{Method, RenderSettings, Scene};
use lightbox_tests::{built, built_as, film, picture, shipped, view, written};

/// Means of the green channel of pictures with different seeds.
fn replicates(scene: &Arc<Scene>, change: impl Fn(&mut RenderSettings) + Sync) -> Replicates {
    Replicates::of(|seed| {
        let image = picture(&view(scene, |s| {
            change(s);
            s.seed = 1000 + seed;
        }));
        image.pixels.iter().map(|p| f64::from(p.y)).sum::<f64>() / image.pixels.len() as f64
    })
}

/// Asserts that all comparisons hold and could have seen a relative error of `resolution`.
fn assert_holds(comparisons: Comparisons, resolution: f64, what: &str) {
    for figure in comparisons.figures("deviation", None, resolution) {
        assert!(figure.holds(), "{what}: {figure:?}");
    }
}

/// The methods share one expectation (the white furnace has its own test).
#[test]
fn methods_agree() {
    let scenes = [
        ("teddy-diffuse", 0.08),
        ("cornell-box", 0.08),
        ("sphere-mirror", 0.1),
        ("teddy-mirror", 0.1),
        ("glass-sphere", 0.15),
    ];
    for (name, resolution) in scenes {
        let scene = built(&shipped(name));
        let means = |method| {
            replicates(&scene, |s| {
                (s.width, s.height, s.samples, s.method) = (20, 20, 96, method);
            })
        };
        let mut comparisons = Comparisons::default();
        let mis = means(Method::Mis);
        comparisons.agree(&means(Method::Naive), &mis);
        // Lights behind glass and mirrors of other shapes, which nobody can aim at, are counted when run into.
        comparisons.agree(&means(Method::Nee), &mis);
        comparisons.agree(&means(Method::Caustics), &mis);
        comparisons.agree(&means(Method::Reuse), &mis);
        assert_holds(comparisons, resolution, name);
    }
}

/// Lamps of every kind between mirror spheres, one of them varnished.
const MIRRORS: &str = r#"
[camera]
eye = [0, 1.5, 5]
target = [0, 0.4, 0]
fov = 40

[[material]]
name = "plaster"
albedo = [0.6, 0.6, 0.6]

[[material]]
name = "silver"
mirror = 1
mirror_color = [0.9, 0.8, 0.7]

[[material]]
name = "varnish"
albedo = [0.5, 0.4, 0.3]
mirror = 0.4

[[material]]
name = "lamp"
albedo = [0.2, 0.2, 0.2]
emission = [3, 4, 5]

[[quad]]
material = "plaster"
corners = [[-3, 0, 3], [3, 0, 3], [3, 0, -3], [-3, 0, -3]]

[[quad]]
material = "lamp"
corners = [[-1, 2.5, -1], [1, 2.5, -1], [1, 2.5, 1], [-1, 2.5, 1]]

[[quad]]
material = "lamp"
corners = [[-2.5, 0.2, -1], [-2.5, 0.5, 1], [-2.3, 2, 1], [-2.3, 1.7, -1]]

[[quad]]
material = "lamp"
corners = [[2.5, 0.2, -2], [2, 1.5, -2.2], [1, 1.2, -2.1], [1.2, 0.3, -2]]

[[sphere]]
material = "lamp"
center = [1.8, 0.9, 0.9]
radius = 0.4

[[sphere]]
material = "silver"
center = [-0.7, 0.6, 0.2]
radius = 0.6

[[sphere]]
material = "varnish"
center = [0.7, 0.5, -0.3]
radius = 0.5
"#;

/// Light by way of mirror spheres is found by those who aim at it, and met by those who do not.
#[test]
fn methods_agree_among_mirror_spheres() {
    let scene = written(MIRRORS);
    for depth in [2, 3, 4, UNLIMITED] {
        let means = |method| {
            replicates(&scene, |s| {
                (s.width, s.height, s.samples) = (24, 18, 256);
                (s.method, s.depth) = (method, depth);
            })
        };
        let mut comparisons = Comparisons::default();
        let mis = means(Method::Mis);
        comparisons.agree(&means(Method::Naive), &mis);
        comparisons.agree(&means(Method::Nee), &mis);
        comparisons.agree(&means(Method::Caustics), &mis);
        comparisons.agree(&means(Method::Reuse), &mis);
        assert_holds(comparisons, 0.02, &format!("depth {depth}"));
    }
}

/// What stands among the mirror spheres for light to come by way of: plane mirrors, one of them
/// varnished, glass, more lamps in it than one, and a room around.
const CASTERS: &str = r#"
[[material]]
name = "glass"
glass = 1.5

[[sphere]]
material = "glass"
center = [0.2, 1.4, 0.8]
radius = 0.45

[[sphere]]
material = "glass"
center = [-1.9, 1.1, 0.6]
radius = 0.7

[[sphere]]
material = "lamp"
center = [-1.9, 1.2, 0.6]
radius = 0.2

[[quad]]
material = "silver"
corners = [[-3, 0, -2.8], [3, 0, -2.8], [3, 3, -3], [-3, 3, -3]]

[[quad]]
material = "varnish"
corners = [[3, 0, -3], [3, 0, 3], [3, 3, 3], [3, 3, -3]]
"#;

/// Light paths and camera paths find the same light, whatever the filter spreads and wherever
/// the paths end.
#[test]
fn light_paths_agree_with_camera_paths() {
    let scene = written(&format!("{MIRRORS}{CASTERS}"));
    for (depth, filter) in [
        (3, "box"),
        (4, "mitchell"),
        (UNLIMITED, "gaussian:2.5"),
        (UNLIMITED, "lanczos"),
    ] {
        let means = |method| {
            replicates(&scene, |s| {
                (s.width, s.height, s.samples) = (24, 18, 256);
                (s.method, s.depth) = (method, depth);
                s.filter = filter.parse().expect("a filter");
            })
        };
        let mut comparisons = Comparisons::default();
        let naive = means(Method::Naive);
        comparisons.agree(&means(Method::Caustics), &naive);
        comparisons.agree(&means(Method::Reuse), &naive);
        assert_holds(comparisons, 0.02, &format!("depth {depth}, {filter}"));
    }
}

/// So they do in glass, where light goes by other solid angles: what is there is lit from outside, and has a lamp.
#[test]
fn light_paths_agree_with_camera_paths_in_glass() {
    let scene = written(
        r#"
[camera]
eye = [0, 1, 4]
target = [0, 0, 0]
fov = 30

[[material]]
name = "plaster"
albedo = [0.8, 0.8, 0.8]

[[material]]
name = "glass"
glass = 2.0

[[material]]
name = "lamp"
emission = [3, 4, 5]

[[sphere]]
material = "glass"
center = [0, 0, 0]
radius = 1

[[quad]]
material = "plaster"
corners = [[-0.5, -0.4, 0.5], [0.5, -0.4, 0.5], [0.5, -0.4, -0.4], [-0.5, -0.4, -0.4]]

[[quad]]
material = "plaster"
corners = [[-0.5, -0.4, -0.4], [0.5, -0.4, -0.4], [0.5, 0.4, -0.4], [-0.5, 0.4, -0.4]]

[[sphere]]
material = "lamp"
center = [0.5, 0.3, 0]
radius = 0.1

[[quad]]
material = "lamp"
corners = [[-2, 3, -1], [2, 3, -1], [2, 3, 2], [-2, 3, 2]]
"#,
    );
    for depth in [5, UNLIMITED] {
        let means = |method| {
            replicates(&scene, |s| {
                (s.width, s.height, s.samples) = (16, 16, 256);
                (s.method, s.depth) = (method, depth);
            })
        };
        let mut comparisons = Comparisons::default();
        let naive = means(Method::Naive);
        comparisons.agree(&means(Method::Caustics), &naive);
        comparisons.agree(&means(Method::Reuse), &naive);
        assert_holds(comparisons, 0.03, &format!("depth {depth}"));
    }
}

/// The relMSE of 64 samples.
fn noise(scene: &Arc<Scene>, method: Method) -> f64 {
    let film = film(&view(scene, |s| {
        (s.width, s.height, s.samples, s.method) = (64, 64, 64, method);
    }));
    film.error().expect("two halves").rel_mse
}

/// Light paths are worth a factor of 6 to 8 here; 3 is clear of chance.
#[test]
fn caustics_are_found_from_the_lamp() {
    for name in ["teddy-mirror", "glass-sphere"] {
        let scene = built(&shipped(name));
        let ratio = noise(&scene, Method::Mis) / noise(&scene, Method::Caustics);
        assert!(ratio > 3.0, "{name}: {ratio}");
    }
}

/// Where nothing is specular, light paths are not traced: the picture has the bits of `mis`.
#[test]
fn without_casters_there_is_nothing_to_trace() {
    for name in ["cornell-box", "teddy-diffuse", "sphere-mirror"] {
        let scene = built(&shipped(name));
        let pictures = [Method::Mis, Method::Caustics].map(|method| {
            picture(&view(&scene, |s| {
                (s.width, s.height, s.samples, s.method) = (24, 24, 4, method);
            }))
        });
        assert!(pictures[0] == pictures[1], "{name}");
    }
}

/// Aiming by way of the mirror is worth a factor of 50; 15 is clear of chance.
#[test]
fn light_from_a_mirror_sphere_is_found_not_met() {
    let scene = built(&shipped("sphere-mirror"));
    let ratio = noise(&scene, Method::Naive) / noise(&scene, Method::Mis);
    assert!(ratio > 15.0, "{ratio}");
}

/// A lamp seen from behind, or from inside, is dark: none shines on itself, wherever rounding puts the points
/// of its back.
#[test]
fn no_lamp_shines_on_itself() {
    let lamp = "[[material]]\nname = \"lamp\"\nalbedo = [0.5, 0.5, 0.5]\nmirror = 0.4\nemission = [1, 1, 1]\n";
    let quad = "[[quad]]\nmaterial = \"lamp\"\n\
                corners = [[-0.7, -1.1, 0.2], [-0.9, 0.9, 0.5], [1.1, 1.1, -0.1], [1.3, -0.9, -0.4]]\n";
    let sphere = "[[sphere]]\nmaterial = \"lamp\"\ncenter = [0.1, 0.2, 0.3]\nradius = 3\n";
    for shape in [quad, sphere] {
        let eye = "[camera]\neye = [0, 0, 2.5]\ntarget = [0, 0, 0]\n";
        assert_dark(&written(&format!("{eye}{lamp}{shape}")), 0.0);
    }
}

/// Asserts that no method finds more light than some, over all pixels and channels.
fn assert_dark(scene: &Arc<Scene>, most: f32) {
    for method in Method::ALL {
        let image = picture(&view(scene, |s| {
            (s.width, s.height, s.samples, s.method) = (32, 32, 64, *method);
        }));
        let light: f32 = image.pixels.iter().map(|p| p.abs().element_sum()).sum();
        assert!(light <= most, "{method}: {light}");
    }
}

/// No light enters a closed sphere, though from outside its other side is in sight once its near side does not count
/// (then 9 units of light would be in the picture). A ray that meets the inside all but along it can miss the sphere where it
/// goes in, by the rounding of its direction: that is what little is allowed.
#[test]
fn no_light_enters_a_sphere() {
    let room = r#"
[camera]
eye = [0.3, 0.1, 0.2]
target = [-1, -0.3, -0.4]
fov = 90

[[material]]
name = "plaster"
albedo = [0.8, 0.8, 0.8]

[[material]]
name = "silver"
mirror = 1

[[material]]
name = "lamp"
albedo = [0.5, 0.5, 0.5]
emission = [9, 9, 9]

[[sphere]]
material = "lamp"
center = [0, 0, 0]
radius = 1

[[quad]]
material = "silver"
corners = [[-0.5, -0.5, -0.3], [-0.5, -0.5, 0.3], [-0.4, 0.5, 0.3], [-0.4, 0.5, -0.3]]

[[sphere]]
material = "plaster"
center = [0.2, -0.5, 0.3]
radius = 0.2

[[quad]]
material = "silver"
corners = [[-4, -2, 4], [4, -2, 4], [4, -2, -4], [-4, -2, -4]]

[[quad]]
material = "plaster"
corners = [[-3, -4, -3], [3, -4, -3], [3, 4, -3], [-3, 4, -3]]

[[quad]]
material = "lamp"
corners = [[-1, 2.5, -1], [1, 2.5, -1], [1, 2.5, 1], [-1, 2.5, 1]]
"#;
    // Diffuse, and such that light is aimed at by way of its outside.
    for lobe in ["", "mirror = 0.4\n"] {
        let lamp = "emission = [9, 9, 9]\n";
        let text = room.replace(lamp, &format!("{lamp}{lobe}"));
        assert_dark(&written(&text), 1e-4);
    }
}

/// Surfaces that reflect everything vanish in uniform light: exactly for a convex body without
/// roulette, in the mean for all of the shipped furnace.
#[test]
fn white_furnace() {
    let source = shipped("white-furnace");
    let scene = built(&source);
    let mut comparisons = Comparisons::default();
    for method in Method::ALL {
        let means = replicates(&scene, |s| {
            (s.width, s.height, s.samples) = (24, 24, 16);
            (s.method, s.depth) = (*method, UNLIMITED);
        });
        comparisons.mean(&means, 1.0);
    }
    assert_holds(comparisons, 0.006, "shipped furnace");
    let mut alone = source.desc.clone();
    alone.spheres.truncate(1);
    let scene = built_as(&source, alone);
    let image = picture(&view(&scene, |s| {
        (s.width, s.height, s.samples) = (32, 32, 4)
    }));
    for p in &image.pixels {
        assert!((*p - 1.0).abs().max_element() < 1e-5, "{p}");
    }
}

/// Lambert's cosines between a floor and a lamp straight above in the plane of the ceiling, as the Cornell box has it: what is
/// in the lamp's place neither hides nor shades it, whichever way rounding goes.
#[test]
fn a_lamp_in_the_plane_of_a_ceiling_is_not_shaded_by_it() {
    let height = 548.8;
    let room = format!(
        r#"
[camera]
eye = [0, 300, 0]
target = [0, 0, 0]
up = [0, 0, 1]
fov = 10

[[material]]
name = "white"
albedo = [0.5, 0.5, 0.5]

[[material]]
name = "lamp"
emission = [10, 10, 10]

[[quad]]
material = "white"
corners = [[-300, 0, 300], [300, 0, 300], [300, 0, -300], [-300, 0, -300]]

[[quad]]
material = "white"
corners = [[-300, {height}, -300], [300, {height}, -300], [300, {height}, 300], [-300, {height}, 300]]

[[quad]]
material = "lamp"
corners = [[-65, {height}, -52.5], [65, {height}, -52.5], [65, {height}, 52.5], [-65, {height}, 52.5]]
"#
    );
    // Over the lamp and, as the picture is small but no point, over what it shows of the floor.
    let steps =
        |n: u32, half: f64| (0..n).map(move |i| half * ((2 * i + 1) as f64 / n as f64 - 1.0));
    let shown = 300.0 * 5.0f64.to_radians().tan();
    let mut form = 0.0;
    for (x, z) in steps(8, shown).flat_map(|x| steps(8, shown).map(move |z| (x, z))) {
        for (u, v) in steps(40, 65.0).flat_map(|u| steps(40, 52.5).map(move |v| (u, v))) {
            let square = height * height + (u - x).powi(2) + (v - z).powi(2);
            form += (height / square).powi(2) / (64.0 * 1600.0);
        }
    }
    let expected = 0.5 / std::f64::consts::PI * 10.0 * form * (130.0 * 105.0);
    let scene = written(&room);
    for method in [Method::Nee, Method::Mis, Method::Caustics, Method::Reuse] {
        let image = picture(&view(&scene, |s| {
            (s.width, s.height, s.samples) = (32, 32, 64);
            (s.depth, s.method) = (2, method);
        }));
        let sum: f64 = image.pixels.iter().map(|p| f64::from(p.y)).sum();
        let mean = sum / image.pixels.len() as f64;
        assert!(
            (mean / expected - 1.0).abs() < 2e-3,
            "{method}: {mean} for {expected}"
        );
    }
}
