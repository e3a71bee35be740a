//! Pictures of light transport going wrong, and of the same scene as lightbox shows it.

use glam::Vec3;

use super::Side;
use super::trial::{built_in, picture, view};
use crate::film::Film;
use crate::filter::FilterSampler;
use crate::geometry::{Primitive, SurfacePoint};
use crate::math::Ray;
use crate::sampler::{Dim, Sampler};
use crate::settings::UNLIMITED;
use crate::{Filter, Image, Method, RenderSettings, SamplerKind, Scene, View};

/// Edge of a picture, pixels.
const SIZE: u32 = 160;

/// A built-in scene of the lab at the gallery's size.
fn small(name: &str, samples: u64, change: impl FnOnce(&mut RenderSettings)) -> View {
    view(&built_in(name), |s| {
        (s.width, s.height, s.samples) = (SIZE, SIZE, samples);
        change(s);
    })
}

/// A picture whose pixels are means of `samples` calls of `radiance`, added as f32.
fn plain(view: &View, radiance: impl Fn(Ray, &Sampler) -> Vec3) -> Image {
    pixels(|pixel| {
        let samples = view.settings.samples;
        let sum: Vec3 = (0..samples)
            .map(|sample| {
                let sampler = Sampler::new(SamplerKind::Independent, 1, pixel, sample);
                let offset = sampler.get_2d(Dim::Pixel).map(|u| u - 0.5);
                radiance(view.camera.ray(pixel, offset), &sampler)
            })
            .sum();
        sum / samples as f32
    })
}

fn pixels(mut value: impl FnMut([u32; 2]) -> Vec3) -> Image {
    let at = (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| [x, y]));
    Image {
        width: SIZE,
        height: SIZE,
        pixels: at.map(&mut value).collect(),
    }
}

/// L01: points uniform over the lamp's area, against solid angle.
pub(super) fn touching_light(side: Side) -> Image {
    let view = small("touching-light", 16, |_| ());
    match side {
        Side::Naive => plain(&view, |ray, sampler| by_area(&view.scene, &ray, sampler)),
        Side::Lightbox => picture(&view),
    }
}

/// Direct light from a point uniform over the area of the only lamp.
fn by_area(scene: &Scene, ray: &Ray, sampler: &Sampler) -> Vec3 {
    let Some(hit) = scene.intersect(ray) else {
        return Vec3::ZERO;
    };
    let primitives = scene.primitives();
    let point = primitives.surface_point(ray, &hit);
    let material = scene.material(hit.prim);
    let n = if point.n.dot(ray.dir) < 0.0 {
        point.n
    } else {
        -point.n
    };
    let shines = n == point.n;
    if material.emits() {
        return if shines {
            material.emission
        } else {
            Vec3::ZERO
        };
    }
    let Some(lamp) = (0..primitives.len() as u32).find(|id| scene.material(*id).emits()) else {
        return Vec3::ZERO;
    };
    let Primitive::Quad(quad) = primitives.get(lamp) else {
        return Vec3::ZERO;
    };
    let [u, v] = sampler.get_2d(Dim::LightPoint(0));
    let on_lamp = SurfacePoint::of_quad(&quad, u, v);
    let toward = on_lamp.p - point.p;
    let (distance, dir) = (toward.length(), toward.normalize());
    let cosines = n.dot(dir).max(0.0) * on_lamp.n.dot(-dir).max(0.0);
    let shadow = Ray {
        origin: point.leave(dir),
        dir,
        t_max: distance,
    };
    if cosines == 0.0 || scene.occluded(&shadow, lamp) {
        return Vec3::ZERO;
    }
    let weight = cosines / (distance * distance) * quad.area() * std::f32::consts::FRAC_1_PI;
    material.albedo * scene.material(lamp).emission * weight
}

/// B03: lights that are aimed at only, against both strategies.
pub(super) fn mirror_only(side: Side) -> Image {
    let view = small("mirror-only", 64, |_| ());
    match side {
        Side::Naive => plain(&view, |ray, sampler| aimed(&view.scene, ray, sampler)),
        Side::Lightbox => picture(&view),
    }
}

/// A path on which light that is run into counts from the camera only, mirrors or not.
fn aimed(scene: &Scene, mut ray: Ray, sampler: &Sampler) -> Vec3 {
    let (mut radiance, mut throughput) = (Vec3::ZERO, Vec3::ONE);
    for bounce in 0..scene.desc().render.depth {
        let Some(hit) = scene.intersect(&ray) else {
            break;
        };
        let point = scene.primitives().surface_point(&ray, &hit);
        let material = scene.material(hit.prim);
        let front = point.n.dot(ray.dir) < 0.0;
        let n = if front { point.n } else { -point.n };
        if bounce == 0 && front {
            radiance += material.emission;
        }
        let bsdf = material.bsdf(|| scene.primitives().uv(&hit));
        let pick = || sampler.get_1d(Dim::LightPick(bounce));
        let light = scene
            .lights()
            .sample(point.p, pick, || sampler.get_2d(Dim::LightPoint(bounce)));
        if let Some(light) = light {
            let toward = light.point.p - point.p;
            let shadow = Ray {
                origin: point.leave(toward),
                dir: toward.normalize(),
                t_max: toward.length(),
            };
            let cos = n.dot(shadow.dir).max(0.0);
            if !scene.occluded(&shadow, light.prim) {
                let f = bsdf.diffuse() * std::f32::consts::FRAC_1_PI;
                radiance += throughput * f * scene.material(light.prim).emission * cos / light.pdf;
            }
        }
        let lobe = || sampler.get_1d(Dim::Lobe(bounce));
        let u = || sampler.get_2d(Dim::BsdfDirection(bounce));
        let Some(sample) = bsdf.sample(-ray.dir, n, front, lobe, u) else {
            break;
        };
        throughput *= sample.weight;
        ray = Ray::new(point.leave(sample.wi), sample.wi);
    }
    radiance
}

/// B07: mirrors cut at eight segments, against no cut.
pub(super) fn mirror_box(side: Side) -> Image {
    picture(&small("mirror-box", 32, |s| cut(s, side, 8)))
}

/// B06: a white box in uniform light, cut at four segments, against no cut.
pub(super) fn albedo_one(side: Side) -> Image {
    picture(&small("albedo-one", 64, |s| cut(s, side, 4)))
}

/// G02: a room of indirect light cut at four segments, against no cut.
pub(super) fn depth(side: Side) -> Image {
    picture(&small("depth", 64, |s| cut(s, side, 4)))
}

fn cut(settings: &mut RenderSettings, side: Side, segments: u32) {
    settings.depth = match side {
        Side::Naive => segments,
        Side::Lightbox => UNLIMITED,
    };
}

/// G01: survivors of roulette not weighted up, against the series.
pub(super) fn closed_box(side: Side) -> Image {
    let view = small("closed-box", 32, |_| ());
    match side {
        Side::Naive => plain(&view, |ray, sampler| unweighted(&view.scene, ray, sampler)),
        Side::Lightbox => picture(&view),
    }
}

/// A path that dies with one minus its throughput at each bounce and goes on as if it could not.
fn unweighted(scene: &Scene, mut ray: Ray, sampler: &Sampler) -> Vec3 {
    let (mut radiance, mut throughput) = (Vec3::ZERO, Vec3::ONE);
    for bounce in 0.. {
        let Some(hit) = scene.intersect(&ray) else {
            break;
        };
        let point = scene.primitives().surface_point(&ray, &hit);
        let material = scene.material(hit.prim);
        let front = point.n.dot(ray.dir) < 0.0;
        let n = if front { point.n } else { -point.n };
        radiance += throughput * material.emission;
        let u = || sampler.get_2d(Dim::BsdfDirection(bounce));
        let lobe = || sampler.get_1d(Dim::Lobe(bounce));
        let roulette = sampler.get_1d(Dim::Roulette(bounce));
        let bsdf = material.bsdf(|| scene.primitives().uv(&hit));
        let Some(sample) = bsdf.sample(-ray.dir, n, front, lobe, u) else {
            break;
        };
        throughput *= sample.weight;
        if bounce >= 3 && roulette >= throughput.max_element() {
            break;
        }
        ray = Ray::new(point.leave(sample.wi), sample.wi);
    }
    radiance
}

/// A06: a lamp that random paths do not find, against one that is aimed at.
pub(super) fn unseen_light(side: Side) -> Image {
    picture(&small("unseen-light", 16, |s| {
        s.method = match side {
            Side::Naive => Method::Naive,
            Side::Lightbox => Method::Mis,
        };
    }))
}

/// A noisy ramp: what sample `sample` of a pixel brings.
fn ramp([x, y]: [u32; 2], sample: u64) -> Vec3 {
    let sampler = Sampler::new(SamplerKind::Independent, 2, [x, y], sample);
    let [noise, _] = sampler.get_2d(Dim::Pixel);
    let ramp = Vec3::new(x as f32, y as f32, (SIZE - x) as f32) / SIZE as f32;
    ramp * (0.5 + noise)
}

/// The ramp on a film to which `extra` samples have been added first, pixel by pixel.
fn on_film(samples: u64, first: impl Fn([u32; 2]) -> Option<Vec3>) -> Image {
    let film = Film::new(SIZE, SIZE, &FilterSampler::new(Filter::default()));
    for tile in 0..film.tiles() {
        let (mut batch, _) = film.batch(tile);
        let rect = batch.rect;
        for (x, y) in (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| (x, y))) {
            let pixel = [rect.x + x, rect.y + y];
            for sample in 0..samples {
                let light = first(pixel).filter(|_| sample == 0);
                let light = light.unwrap_or_else(|| ramp(pixel, sample));
                batch.add([x, y], sample, 0, light);
            }
        }
        film.merge(tile, &batch, 0, samples);
    }
    film.develop()
}

/// F04: one sample in a thousand is NaN, splatted by a filter, against a film that refuses it.
pub(super) fn nan_injection(side: Side) -> Image {
    let samples = 16;
    let is_bad = |[x, y]: [u32; 2]| {
        let sampler = Sampler::new(SamplerKind::Independent, 3, [x, y], 0);
        sampler.get_2d(Dim::LightPick(0))[0] < 0.016
    };
    match side {
        // A tent of radius 1 reaches the four pixels around a position: one NaN takes them all.
        Side::Naive => pixels(|[x, y]| {
            let mut around = (x.saturating_sub(1)..=x)
                .flat_map(|x| (y.saturating_sub(1)..=y).map(move |y| [x, y]));
            if around.any(is_bad) {
                return Vec3::NAN;
            }
            let sum: Vec3 = (0..samples).map(|sample| ramp([x, y], sample)).sum();
            sum / samples as f32
        }),
        Side::Lightbox => on_film(samples, |pixel| is_bad(pixel).then_some(Vec3::NAN)),
    }
}

/// A02: what 200 samples add to a firefly of 2²⁴, in f32 and by integers.
pub(super) fn frozen_firefly(side: Side) -> Image {
    let (samples, firefly) = (200, 16_777_216.0);
    match side {
        Side::Naive => pixels(|pixel| {
            let mut sum = Vec3::splat(firefly);
            for sample in 1..samples {
                sum += ramp(pixel, sample);
            }
            (sum - firefly) / (samples - 1) as f32
        }),
        Side::Lightbox => {
            let mut image = on_film(samples, |_| Some(Vec3::splat(firefly)));
            for p in &mut image.pixels {
                let sum = p.as_dvec3() * samples as f64 - f64::from(firefly);
                *p = (sum / (samples - 1) as f64).as_vec3();
            }
            image
        }
    }
}
