//! Whether all methods find the same light in scenes that nobody has chosen.

use std::fmt::Write as _;
use std::sync::Arc;

use glam::Vec3;
use lightbox_core::lab::random::Rng;
use lightbox_core::lab::stats::{Comparisons, REPLICATES, Replicates};
use lightbox_core::math::Frame;
use lightbox_core::{Method, Scene};
use lightbox_tests::{picture, view, written};
use rayon::prelude::*;

/// Edge of the pictures.
const SIZE: u32 = 16;

/// What is compared: the quarters of a picture, in each channel.
const FIGURES: usize = 12;

/// Samples per pixel; where methods differ that have so many, it may be that one of them has missed what is
/// bright and rare. Then it has to show again with other seeds and the next number.
const SAMPLES: [u64; 3] = [16, 256, 2048];

/// Compares all methods in so many scenes, and prints those in which they differ.
pub fn run(count: u64, _: bool) -> bool {
    let mut differ = 0;
    let mut repeated = 0;
    for seed in 0..count {
        let text = scene(&mut Rng::new(seed));
        let scene = written(&text);
        let mut found = String::new();
        for (stage, samples) in SAMPLES.into_iter().enumerate() {
            found = differences(&scene, samples, 1000 * (stage as u64 + 1));
            if found.is_empty() {
                break;
            }
            repeated += u64::from(stage == 0);
        }
        if !found.is_empty() {
            differ += 1;
            println!("scene {seed}: {found}\n{text}");
        }
    }
    println!(
        "{differ} scenes in which methods differ; {repeated} were looked at again with more samples"
    );
    differ == 0
}

/// The methods that differ from `mis`, and by how much of the critical distance.
fn differences(scene: &Arc<Scene>, samples: u64, first_seed: u64) -> String {
    let estimates = |method| -> Vec<[f64; FIGURES]> {
        let quarters = |seed| figures(scene, method, samples, first_seed + seed);
        let seeds = (0..REPLICATES as u64).into_par_iter();
        seeds.map(quarters).collect()
    };
    let mis = estimates(Method::Mis);
    let mut text = String::new();
    for method in Method::ALL.iter().filter(|m| **m != Method::Mis) {
        let other = estimates(*method);
        let mut comparisons = Comparisons::default();
        // What is black in all pictures cannot differ.
        let lit = |k: &usize| mis.iter().chain(&other).any(|figures| figures[*k] != 0.0);
        for k in (0..FIGURES).filter(lit) {
            let column = |of: &[[f64; FIGURES]]| Replicates::of(|seed| of[seed as usize][k]);
            comparisons.agree(&column(&other), &column(&mis));
        }
        if !(comparisons.deviation <= 1.0) {
            let _ = write!(text, "{method} {:.2} ", comparisons.deviation);
        }
    }
    text
}

/// Means of a picture's quarters, by channel.
fn figures(scene: &Arc<Scene>, method: Method, samples: u64, seed: u64) -> [f64; FIGURES] {
    let image = picture(&view(scene, |s| {
        (s.width, s.height, s.samples) = (SIZE, SIZE, samples);
        (s.method, s.seed) = (method, seed);
    }));
    let mut sums = [0.0; FIGURES];
    for (i, p) in image.pixels.iter().enumerate() {
        let [x, y] = [i as u32 % SIZE, i as u32 / SIZE].map(|x| 2 * x / SIZE);
        for channel in 0..3 {
            sums[(3 * (x + 2 * y)) as usize + channel] += f64::from(p[channel]);
        }
    }
    sums.map(|sum| sum / f64::from(SIZE * SIZE / 4))
}

/// A room or a floor with things of every kind in it, as TOML.
fn scene(rng: &mut Rng) -> String {
    let mut text = String::new();
    let depth = ["2", "3", "4", "6", "16", "\"unlimited\""][rng.below(6)];
    let filter = ["box", "tent", "gaussian:1.5", "mitchell", "lanczos"][rng.below(5)];
    let _ = write!(text, "[render]\ndepth = {depth}\nfilter = \"{filter}\"\n");
    let is_room = rng.below(3) > 0;
    let light = if is_room {
        0.0
    } else {
        [0.0, 0.3][rng.below(2)]
    };
    text.insert_str(0, &format!("background = [{light}, {light}, {light}]\n"));
    let (eye, target) = (rng.cube() * 0.9, rng.cube() * 0.5);
    let fov = 30.0 + 60.0 * rng.unit();
    let _ = write!(
        text,
        "[camera]\neye = {eye}\ntarget = {target}\nfov = {fov}\n"
    );

    let materials = 3 + rng.below(4);
    for i in 0..materials {
        let _ = write!(
            text,
            "[[material]]\nname = \"m{i}\"\n{}",
            material(rng, i == 0)
        );
    }
    // The sides of the cube, their fronts inside.
    let sides = [Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .flat_map(|axis| [axis, -axis]);
    for out in sides.filter(|out| is_room || *out == -Vec3::Y) {
        let material = format!("m{}", rng.below(materials).min(1));
        quad(&mut text, &material, out, [1.0; 2], -out);
    }
    for _ in 0..1 + rng.below(4) {
        let material = rng.below(materials);
        let (center, size) = (rng.cube() * 0.7, 0.1 + 0.4 * rng.unit());
        thing(&mut text, rng, &format!("m{material}"), center, size);
    }
    for i in 0..1 + rng.below(3) {
        let emission = (rng.cube() + 1.0) * (4.0 * rng.magnitude(0.7));
        let rest = [
            "albedo = [0, 0, 0]\n",
            "albedo = [0.5, 0.4, 0.3]\n",
            "albedo = [0.5, 0.4, 0.3]\nmirror = 0.4\n",
        ][rng.below(3)];
        let _ = write!(
            text,
            "[[material]]\nname = \"lamp{i}\"\nemission = {emission}\n{rest}"
        );
        let (center, size) = (rng.cube() * 0.8, 0.3 * rng.magnitude(0.3));
        thing(&mut text, rng, &format!("lamp{i}"), center, size);
    }
    text
}

/// What a surface is made of.
fn material(rng: &mut Rng, is_diffuse: bool) -> String {
    let color = (rng.cube() + 1.0) * 0.45;
    match if is_diffuse { 0 } else { rng.below(5) } {
        0 | 1 => format!("albedo = {color}\n"),
        2 => format!("mirror = 1\nmirror_color = {color}\n"),
        3 => format!("albedo = {color}\nmirror = {}\n", rng.unit()),
        _ => format!("glass = {}\n", [1.0, 1.1, 1.5, 2.4][rng.below(4)]),
    }
}

/// A rectangle by its middle, half its edges and the normal of its front.
fn quad(text: &mut String, material: &str, center: Vec3, [a, b]: [f32; 2], n: Vec3) {
    let Frame { s, t, .. } = Frame::around(n);
    let (s, t) = (a * s, b * t);
    let [a, b, c, d] = [-s - t, s - t, s + t, t - s].map(|v| center + v);
    let _ = write!(
        text,
        "[[quad]]\nmaterial = \"{material}\"\ncorners = [{a}, {b}, {c}, {d}]\n"
    );
}

/// A sphere, a quad, or a rock.
fn thing(text: &mut String, rng: &mut Rng, material: &str, center: Vec3, size: f32) {
    let shape = match rng.below(3) {
        0 => format!("[[sphere]]\ncenter = {center}\nradius = {size}"),
        1 => {
            let edges = [size, size * (0.2 + rng.unit())];
            return quad(text, material, center, edges, rng.direction());
        }
        _ => {
            let triangles = 20 * (1 + rng.below(80));
            format!("[[mesh]]\nboulder = {triangles}\nscale = {size}\ntranslate = {center}")
        }
    };
    let _ = write!(text, "{shape}\nmaterial = \"{material}\"\n");
}
