//! What probes of light transport share: scenes from text, and what a picture of them measures.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::Vec3;

use super::stats::Replicates;
use crate::integrator::{Transport, Wave};
use crate::math::Ray;
use crate::plan::Plan;
use crate::sampler::{Dim, Sampler};
use crate::scene::Source;
use crate::settings::UNLIMITED;
use crate::work::Stopwatch;
use crate::{Camera, Image, Method, RenderSettings, SamplerKind, Scene, View};

/// The largest random number.
pub const LAST: f32 = 1.0 - f32::EPSILON / 2.0;

/// Reflectance of the surfaces called `grey`.
pub const RHO: f64 = 0.5;

/// A floor around the origin, seen from above.
pub const FLOOR: &str = "[-2, 0, 2], [2, 0, 2], [2, 0, -2], [-2, 0, -2]";

/// Builds a scene from TOML text, which must be right.
pub fn scene(text: &str) -> Arc<Scene> {
    Arc::new(build(text).unwrap_or_else(|e| panic!("{e}")))
}

/// Whether a scene can be built from TOML text.
pub fn is_accepted(text: &str) -> bool {
    build(text).is_ok()
}

fn build(text: &str) -> Result<Scene, crate::scene::SceneError> {
    let path = std::path::Path::new("lab.toml");
    crate::scene::parse(text, path)
        .and_then(|desc| Source::from_desc(desc, path).build(&crate::scene::unwatched))
}

/// A built-in scene of the lab, by its name without folder and extension.
pub fn built_in(name: &str) -> Arc<Scene> {
    let path = format!("builtin:lab/{name}.toml");
    let built =
        crate::scene::load(path.as_ref()).and_then(|source| source.build(&crate::scene::unwatched));
    Arc::new(built.unwrap_or_else(|e| panic!("{e}")))
}

/// A scene whose only pixel looks at the origin from `eye`, with a diffuse `grey` of
/// reflectance ½ and a black `lamp` of radiance 1.
pub fn one_pixel(eye: &str, shapes: &str) -> Arc<Scene> {
    scene(&format!(
        "{shapes}
[camera]
eye = {eye}
target = [0, 0, 0]
fov = 0.0001
[render]
width = 1
height = 1
[[material]]
name = 'grey'
albedo = [0.5, 0.5, 0.5]
[[material]]
name = 'lamp'
albedo = [0, 0, 0]
emission = [1, 1, 1]
"
    ))
}

/// A scene of `lamp`s of radiance 1 only.
pub fn lamps(shapes: &str) -> Arc<Scene> {
    scene(&format!(
        "{shapes}[[material]]\nname = 'lamp'\nemission = [1, 1, 1]\n"
    ))
}

/// A quad as TOML.
pub fn quad(material: &str, corners: &str) -> String {
    format!("[[quad]]\nmaterial = '{material}'\ncorners = [{corners}]\n")
}

/// A sphere as TOML.
pub fn sphere(material: &str, center: [f64; 3], radius: f64) -> String {
    format!("[[sphere]]\nmaterial = '{material}'\ncenter = {center:?}\nradius = {radius}\n")
}

/// The inside of a cube of edge 2 whose faces emit 1 and reflect `rho`, seen by 8×8 pixels. Every
/// point of it sees 1/(1 − ρ).
pub fn closed_box(rho: f64) -> Arc<Scene> {
    let faces = [
        "[-1, -1, 1], [1, -1, 1], [1, -1, -1], [-1, -1, -1]",
        "[-1, 1, -1], [1, 1, -1], [1, 1, 1], [-1, 1, 1]",
        "[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1]",
        "[-1, -1, 1], [-1, 1, 1], [1, 1, 1], [1, -1, 1]",
        "[-1, -1, 1], [-1, -1, -1], [-1, 1, -1], [-1, 1, 1]",
        "[1, -1, -1], [1, -1, 1], [1, 1, 1], [1, 1, -1]",
    ];
    let faces: String = faces.iter().map(|corners| quad("wall", corners)).collect();
    scene(&format!(
        "{faces}
[camera]
eye = [0.3, 0.2, 0.1]
target = [0.9, -0.4, -0.8]
fov = 90
[render]
width = 8
height = 8
[[material]]
name = 'wall'
albedo = [{rho}, {rho}, {rho}]
emission = [1, 1, 1]
"
    ))
}

/// A view of a scene as its description wants it, with changed settings.
pub fn view(scene: &Arc<Scene>, change: impl FnOnce(&mut RenderSettings)) -> View {
    let mut settings = scene.desc().render;
    change(&mut settings);
    View::new(scene.clone(), &scene.desc().camera, settings).unwrap_or_else(|e| panic!("{e}"))
}

/// The picture of a view.
pub fn picture(view: &View) -> Image {
    let film = view.film();
    view.render(&film, view.settings.samples, &AtomicBool::new(false));
    film.develop()
}

/// Mean of the green channel.
pub fn mean(image: &Image) -> f64 {
    let sum: f64 = image.pixels.iter().map(|p| f64::from(p.y)).sum();
    sum / image.pixels.len() as f64
}

/// Means of the green channel of pictures with different seeds. Samples of a low-discrepancy
/// sampler are not independent of each other, but those of different seeds are.
pub fn replicates(scene: &Arc<Scene>, change: impl Fn(&mut RenderSettings) + Sync) -> Replicates {
    Replicates::of(|i| {
        mean(&picture(&view(scene, |s| {
            change(s);
            s.seed = 1000 + i;
        })))
    })
}

/// The radiance of one path, and the rays it took.
pub fn path(scene: &Scene, method: Method, ray: Ray, sampler: Sampler) -> (Vec3, u64) {
    let (mut wave, mut rays) = (Wave::default(), 0);
    wave.push(ray, sampler);
    let never = AtomicBool::new(false);
    let camera = Camera::new(&scene.desc().camera, 1, 1).unwrap_or_else(|e| panic!("{e}"));
    let transport = Transport {
        scene,
        plan: Plan::FULL,
        method,
        depth: UNLIMITED,
        camera: &camera,
        margin: 0.0,
        guide: None,
    };
    let found = wave.trace(&transport, &never, &mut rays, &mut Stopwatch::start(), None);
    (found.map_or(Vec3::NAN, |radiance| radiance[0]), rays)
}

/// Independent random numbers, a pair for each `i`.
pub fn numbers(i: u32, dim: Dim) -> [f32; 2] {
    Sampler::new(SamplerKind::Independent, 77, [i, 3], 0).get_2d(dim)
}

/// The bits of a picture.
pub fn bits(image: &Image) -> Vec<[u32; 3]> {
    let bits = |p: &Vec3| p.to_array().map(f32::to_bits);
    image.pixels.iter().map(bits).collect()
}
