//! The plan leaves out nothing that can be seen, and what it leaves out shows in no bit.

use std::sync::Arc;

use glam::Vec3;

use super::*;
use crate::color::ToneMap;
use crate::image_io;
use crate::lab::trial::{bits, picture, scene, view};
use crate::scene::{BUILTIN, Source};
use crate::{Image, SamplerKind, Scene, View};

/// A shipped scene by its path.
fn read(path: &str) -> Arc<Scene> {
    let built =
        crate::scene::load(path.as_ref()).and_then(|source| source.build(&crate::scene::unwatched));
    Arc::new(built.unwrap_or_else(|e| panic!("{e}")))
}

/// A shipped scene by its name.
pub(crate) fn shipped(name: &str) -> Arc<Scene> {
    read(&format!("builtin:{name}.toml"))
}

/// A small view of a scene.
fn small(scene: &Arc<Scene>, method: Method) -> View {
    view(scene, |s| {
        (s.width, s.height, s.samples, s.method) = (40, 24, 4, method);
    })
}

/// Mirror, glass, a blend, a texture, lights of each kind and a background.
fn everything() -> Arc<Scene> {
    let folder = tempfile::tempdir().expect("a folder");
    let texels = [Vec3::ONE, Vec3::X, Vec3::Y, Vec3::splat(0.25)];
    let image = Image {
        width: 2,
        height: 2,
        pixels: texels.into(),
    };
    let texture = folder.path().join("texture.png");
    image_io::write(&texture, &image, ToneMap::default(), "").expect("a texture");
    let mesh = "v -2 -1 -2\nv 2 -1 -2\nv 2 -1 2\nv -2 -1 2\nvt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\nf 1/1 4/4 3/3 2/2\n";
    std::fs::write(folder.path().join("floor.obj"), mesh).expect("a mesh");
    let text = r#"
background = [0.1, 0.2, 0.3]
[camera]
eye = [0, 0.5, 4]
target = [0, -0.3, 0]
fov = 50
[[material]]
name = "tiles"
texture = "texture.png"
[[material]]
name = "mirror"
mirror = 1
[[material]]
name = "polished"
albedo = [0.8, 0.4, 0.2]
mirror = 0.4
[[material]]
name = "glass"
glass = 1.5
[[material]]
name = "lamp"
emission = [9, 8, 7]
[[mesh]]
file = "floor.obj"
material = "tiles"
[[sphere]]
material = "mirror"
center = [-1, -0.5, 0]
radius = 0.5
[[sphere]]
material = "polished"
center = [0, -0.5, -0.5]
radius = 0.5
[[sphere]]
material = "glass"
center = [1, -0.5, 0.3]
radius = 0.5
[[sphere]]
material = "lamp"
center = [0, -0.8, 0.6]
radius = 0.1
[[quad]]
material = "lamp"
corners = [[-0.5, 1.5, -0.5], [0.5, 1.5, -0.5], [0.5, 1.5, 0.5], [-0.5, 1.5, 0.5]]
[[quad]]
material = "lamp"
corners = [[-2, 0, -2], [-1, 0, -2], [-0.5, 1, -2], [-1.5, 1, -2]]
[[quad]]
material = "lamp"
corners = [[1, 0, -2], [2, 0, -2], [1.7, 1, -2], [1.1, 1, -2]]
"#;
    let path = folder.path().join("everything.toml");
    let desc = crate::scene::parse(text, &path).unwrap_or_else(|e| panic!("{e}"));
    let built = Source::from_desc(desc, &path).build(&crate::scene::unwatched);
    Arc::new(built.unwrap_or_else(|e| panic!("{e}")))
}

/// A view that leaves out certain parts, whether the scene needs them or not.
fn without(view: &View, parts: &[Part]) -> View {
    let mut plan = Plan::FULL;
    for part in parts {
        plan.without[*part as usize] = true;
    }
    view.planned(plan)
}

fn left_out(view: &View) -> Vec<Part> {
    view.plan().left_out().collect()
}

#[test]
fn every_shipped_scene_is_counted() {
    use Part::{LightChoice, Tree};
    // Triangles, quads, spheres; diffuse, blends, mirrors, glasses; lights; background; what the
    // default method goes without.
    type Row = (
        &'static str,
        [usize; 3],
        [usize; 4],
        usize,
        bool,
        &'static [Part],
    );
    let expected: [Row; 7] = [
        (
            "teddy-diffuse",
            [3200, 6, 0],
            [5, 0, 0, 0],
            1,
            false,
            &[LightChoice],
        ),
        (
            "teddy-mirror",
            [3200, 6, 0],
            [4, 0, 1, 0],
            1,
            false,
            &[LightChoice],
        ),
        (
            "sphere-mirror",
            [0, 6, 1],
            [4, 0, 1, 0],
            1,
            false,
            &[Tree, LightChoice],
        ),
        (
            "cornell-box",
            [10, 11, 0],
            [4, 0, 0, 0],
            1,
            false,
            &[LightChoice],
        ),
        (
            "glass-sphere",
            [0, 6, 2],
            [4, 0, 1, 1],
            1,
            false,
            &[Tree, LightChoice],
        ),
        ("white-furnace", [0, 0, 4], [1, 1, 1, 1], 0, true, &[Tree]),
        (
            "million",
            [1_003_520, 6, 0],
            [5, 0, 0, 0],
            1,
            false,
            &[LightChoice],
        ),
    ];
    assert_eq!(expected.len(), BUILTIN.len());
    for (name, shapes, materials, lights, background, parts) in expected {
        let scene = shipped(name);
        let census = scene.census();
        let kinds = census.materials;
        assert_eq!(
            (
                [census.triangles, census.quads, census.spheres],
                [kinds.diffuse, kinds.blend, kinds.mirror, kinds.glass],
                (census.lights.total(), census.background, census.textures),
            ),
            (shapes, materials, (lights, background, 0)),
            "{name}"
        );
        assert_eq!(left_out(&small(&scene, Method::Mis)), parts, "{name}");
    }
}

#[test]
fn a_scene_with_everything_is_counted_and_loses_nothing() {
    let scene = everything();
    let census = scene.census();
    assert_eq!(
        (
            census.triangles,
            census.quads,
            census.spheres,
            census.textures
        ),
        (4, 2, 4, 1)
    );
    let kinds = census.materials;
    let counts = [
        kinds.diffuse,
        kinds.blend,
        kinds.mirror,
        kinds.glass,
        kinds.emitting,
    ];
    assert_eq!(counts, [2, 1, 1, 1, 1]);
    let lights = census.lights;
    let counts = [
        lights.rectangles,
        lights.parallelograms,
        lights.triangles,
        lights.spheres,
    ];
    assert_eq!(counts, [1, 1, 2, 1]);
    for method in Method::ALL {
        // Few primitives need no tree, whatever they are.
        assert_eq!(left_out(&small(&scene, *method)), [Part::Tree]);
    }
}

#[test]
fn the_full_model_gives_the_same_bits() {
    let mut scenes: Vec<Arc<Scene>> = BUILTIN.iter().map(|name| read(name)).collect();
    scenes.push(everything());
    for scene in scenes {
        let name = scene.path().display();
        for method in Method::ALL {
            let planned = small(&scene, *method);
            let full = planned.full().expect("a view");
            assert_eq!(left_out(&full), [], "{name}");
            let expected = bits(&picture(&full));
            assert!(bits(&picture(&planned)) == expected, "{name}, {method}");
            for part in planned.plan().left_out() {
                let more = planned.with(part).expect("a view");
                assert!(
                    bits(&picture(&more)) == expected,
                    "{name}, {method}, {part:?}"
                );
            }
        }
    }
}

/// As a user asks for it, with the tree that it then builds.
#[test]
fn the_full_model_can_be_set() {
    let scene = shipped("sphere-mirror");
    let mut desc = scene.desc().clone();
    desc.render.full_model = true;
    assert!(scene.rebuilds_for(&desc));
    let full = Arc::new(scene.edit(desc, &crate::scene::unwatched).expect("a scene"));
    assert_eq!(full.geometry().accel(), AccelKind::Bvh);
    let [planned, full] = [scene, full].map(|scene| small(&scene, Method::Mis));
    assert!(left_out(&full).is_empty() && !left_out(&planned).is_empty());
    assert!(bits(&picture(&planned)) == bits(&picture(&full)));
}

/// Otherwise the comparison with the full model could not fail.
#[test]
fn a_part_that_is_needed_is_missed() {
    let scene = everything();
    for (method, part, depth) in [
        (Method::Mis, Part::LightChoice, 9),
        // What the mirror shows of the background and of lamps.
        (Method::Nee, Part::LastSegment, 2),
    ] {
        let full = view(&scene, |s| {
            (s.width, s.height, s.samples) = (40, 24, 4);
            (s.method, s.depth) = (method, depth);
        });
        let full = full.full().expect("a view");
        let lacking = without(&full, &[part]);
        assert!(
            bits(&picture(&lacking)) != bits(&picture(&full)),
            "{part:?} is not missed"
        );
    }
}

#[test]
fn direct_light_takes_no_last_segment() {
    let scene = shipped("cornell-box");
    let direct = view(&scene, |s| {
        (s.width, s.height, s.samples) = (40, 24, 4);
        (s.method, s.depth) = (Method::Nee, 2);
    });
    let rays = |view: &View| {
        let film = view.film();
        view.render(&film, 4, &std::sync::atomic::AtomicBool::new(false))
            .rays
    };
    let full = direct.full().expect("a view");
    assert!(left_out(&direct).contains(&Part::LastSegment));
    assert!(rays(&direct) < rays(&full));
    assert!(bits(&picture(&direct)) == bits(&picture(&full)));
    // What the camera sees is seen by a last segment too.
    let seen = view(&scene, |s| {
        (s.width, s.height, s.samples) = (40, 24, 4);
        (s.method, s.depth) = (Method::Nee, 1);
    });
    let image = picture(&seen);
    assert!(image.pixels.iter().any(|p| *p != Vec3::ZERO));
    assert!(bits(&image) == bits(&picture(&seen.full().expect("a view"))));
}

#[test]
fn unused_materials_do_not_count() {
    let scene = scene(
        "[[material]]\nname = 'unused'\nglass = 1.5\n[[material]]\nname = 'used'\n[[sphere]]\nmaterial = 'used'\ncenter = [0, 0, -3]\nradius = 1\n",
    );
    assert_eq!(scene.census().materials.specular(), 0);
}

/// What one method does without, another may need.
#[test]
fn each_method_has_its_own_plan() {
    let settings = |method| {
        view(&shipped("cornell-box"), |s| {
            (s.width, s.height, s.samples) = (40, 24, 4);
            (s.method, s.depth) = (method, 2);
        })
    };
    let (direct, mis) = (settings(Method::Nee), settings(Method::Mis));
    assert!(left_out(&direct).contains(&Part::LastSegment));
    let found = direct.found_by(Method::Mis, SamplerKind::Sobol);
    assert_eq!(left_out(&found), left_out(&mis));
    assert!(bits(&picture(&found)) == bits(&picture(&mis)));
}
