//! Pictures of geometry going wrong, and of the same by lightbox. Surfaces are lit from the eye;
//! where a ray finds nothing although there is something, the pixel is magenta.

use std::cell::Cell;

use glam::Vec3;
use rayon::prelude::*;

use super::input::{Triangle, build, cast, grid, stairs};
use super::naive::{self, Edges};
use super::triangles::hit;
use super::{Side, quads, tree_size};
use crate::geometry::SurfacePoint;
use crate::math::{Aabb, Ray};
use crate::sampler::{Dim, Sampler};
use crate::scene::load;
use crate::settings::AccelKind;
use crate::shape::{Sphere, triangle_normal};
use crate::{Camera, Image, SamplerKind};

/// Edge of a picture, pixels.
pub(super) const SIZE: u32 = 160;

const NOTHING: Vec3 = Vec3::new(0.02, 0.03, 0.05);
pub(super) const HOLE: Vec3 = Vec3::new(1.0, 0.0, 1.0);
const LAMP: Vec3 = Vec3::new(1.0, 0.9, 0.6);

/// A picture by a function of the pixel and of its middle, from −1 to 1 to the right and up.
pub(super) fn draw(color: impl Fn([u32; 2], [f32; 2]) -> Vec3 + Sync) -> Image {
    let pixels = (0..SIZE * SIZE).into_par_iter().map(|i| {
        let pixel = [i % SIZE, i / SIZE];
        let middle = pixel.map(|k| (2 * k + 1) as f32 / SIZE as f32 - 1.0);
        color(pixel, [middle[0], -middle[1]])
    });
    Image {
        width: SIZE,
        height: SIZE,
        pixels: pixels.collect(),
    }
}

/// A surface with normal `n`, lit from where the ray comes from.
fn lit(n: Vec3, ray: &Ray) -> Vec3 {
    Vec3::splat(0.05 + 0.7 * n.dot(ray.dir).abs())
}

/// A ray from `eye` through a point of a picture; the directions are `right`, `up` and `ahead`.
pub(super) fn look(
    eye: Vec3,
    [right, up, ahead]: [Vec3; 3],
    [x, y]: [f32; 2],
    half_width: f32,
) -> Ray {
    let d = ahead + half_width * (x * right + y * up);
    Ray::new(eye, d.as_dvec3().normalize().as_vec3())
}

/// S01: from 10⁴ radii away, along parallel rays.
pub(super) fn distant_sphere(side: Side) -> Image {
    let sphere = Sphere {
        center: Vec3::ZERO,
        radius: 1.0,
    };
    draw(|_, [x, y]| {
        let ray = Ray::new(Vec3::new(1.5 * x, 1.5 * y, -1e4), Vec3::Z);
        let t = match side {
            Side::Naive => naive::sphere(&sphere, &ray),
            Side::Lightbox => sphere.intersect(&ray, f32::INFINITY),
        };
        t.map_or(NOTHING, |t| lit(ray.at(t).normalize_or_zero(), &ray))
    })
}

/// S02: squares of 1 on a floor that is a sphere of radius 10⁵, towards the horizon.
pub(super) fn planet(side: Side) -> Image {
    let sphere = Sphere {
        center: Vec3::new(0.0, -1e5, 0.0),
        radius: 1e5,
    };
    draw(|_, at| {
        let ray = look(
            Vec3::Y,
            [Vec3::X, Vec3::Y, Vec3::Z - 0.12 * Vec3::Y],
            at,
            0.15,
        );
        let t = match side {
            Side::Naive => naive::sphere(&sphere, &ray),
            Side::Lightbox => sphere.intersect(&ray, f32::INFINITY),
        };
        let Some(t) = t.filter(|t| *t > 0.0) else {
            return NOTHING;
        };
        let p = ray.at(t);
        let dark = (p.x.floor() + p.z.floor()).rem_euclid(2.0) == 0.0;
        Vec3::splat(if dark { 0.15 } else { 0.7 })
    })
}

/// Which root of the mirror ball is taken, in the report's room.
#[derive(Clone, Copy, PartialEq)]
enum Root {
    /// The smaller positive one, and off the surface.
    Lightbox,
    /// As the report prints it, and from the bare surface.
    Printed,
    /// The larger: the back of the ball, seen from within.
    Far,
}

/// S05: the report's rule for the root, with its reflected rays.
pub(super) fn mirror_ball(side: Side) -> Image {
    mirror(match side {
        Side::Naive => Root::Printed,
        Side::Lightbox => Root::Lightbox,
    })
}

/// S07: the larger root, which is what the report's picture shows.
pub(super) fn inverted_ball(side: Side) -> Image {
    mirror(match side {
        Side::Naive => Root::Far,
        Side::Lightbox => Root::Lightbox,
    })
}

/// The room of the report with its mirror ball, lit from the eye and by its lamp's colour alone:
/// what counts is what the ball shows of it.
fn mirror(root: Root) -> Image {
    let name = "builtin:sphere-mirror.toml";
    let source = load(std::path::Path::new(name)).expect("a built-in scene");
    let mut room = source.desc.clone();
    let ball = room.spheres.pop().expect("the scene has a ball");
    let ball = Sphere {
        center: ball.center,
        radius: ball.radius,
    };
    let camera = Camera::new(&room.camera, SIZE, SIZE).expect("the scene's own camera");
    let room = source
        .build_edited(room, &crate::scene::unwatched)
        .expect("the scene without its ball");
    let meets = |ray: &Ray| match root {
        Root::Lightbox => ball.intersect(ray, f32::INFINITY),
        Root::Printed => naive::sphere(&ball, ray).filter(|t| *t > 0.0),
        Root::Far => naive::sphere_roots(&ball, ray)
            .map(|(t0, t1)| t0.max(t1))
            .filter(|t| *t > 0.0),
    };
    const SAMPLES: u64 = 16;
    draw(|pixel, _| {
        let sum: Vec3 = (0..SAMPLES)
            .map(|sample| {
                let sampler = Sampler::new(SamplerKind::Sobol, 0, pixel, sample);
                let offset = sampler.get_2d(Dim::Pixel).map(|u| u - 0.5);
                let mut ray = camera.ray(pixel, offset);
                // Reflections until the ray leaves the ball for good.
                for _ in 0..64 {
                    let wall = room.intersect(&ray).map_or(f32::INFINITY, |hit| hit.t);
                    let Some(t) = meets(&ray).filter(|t| *t < wall) else {
                        break;
                    };
                    let point = SurfacePoint::of_sphere(&ball, ray.at(t));
                    let d = (ray.dir - 2.0 * ray.dir.dot(point.n) * point.n).normalize();
                    ray = Ray::new(
                        match root {
                            Root::Lightbox => point.leave(d),
                            Root::Printed | Root::Far => ray.at(t),
                        },
                        d,
                    );
                    if root == Root::Far {
                        break; // Once, to see what the back of the ball reflects.
                    }
                }
                let Some(hit) = room.intersect(&ray) else {
                    return NOTHING;
                };
                let material = room.material(hit.prim);
                if material.emits() {
                    return Vec3::ONE;
                }
                let point = room.primitives().surface_point(&ray, &hit);
                // Darker with depth, so that corners show.
                let falloff = 1.0 / (1.0 + 0.1 * (point.p - Vec3::Y).length_squared());
                material.albedo * falloff * (0.3 + 0.7 * point.n.dot(ray.dir).abs())
            })
            .sum();
        sum / SAMPLES as f32
    })
}

/// Along the z axis, parallel, at pixel middles that lie on a lattice of 2⁻⁴.
fn straight([x, y]: [f32; 2], span: f32, zero: f32) -> Ray {
    let lattice = |k: f32| (k * SIZE as f32 * 0.5 - 0.5).round() / SIZE as f32 * 2.0;
    let at = |k: f32| span * (0.5 + 0.5 * lattice(k));
    Ray::new(Vec3::new(at(x), at(y), -10.0), Vec3::new(zero, zero, 1.0))
}

fn face(triangles: &[Triangle], id: usize, ray: &Ray) -> Vec3 {
    let [a, b, c] = triangles[id];
    let tint = Vec3::new(1.0, 0.9, 0.8) - 0.25 * (id % 2) as f32;
    lit(triangle_normal([a, b, c]), ray) * tint
}

/// T02: a grid of squares, each two triangles, with rays exactly on edges and diagonals.
pub(super) fn edges(side: Side) -> Image {
    let triangles: Vec<Triangle> = grid(8)
        .into_iter()
        .filter(|t| t.iter().all(|p| p.z == t[0].z))
        .collect();
    let geometry = build(&triangles, AccelKind::Auto);
    draw(|_, at| {
        let ray = straight(at, 8.0, 0.0);
        let hit = match side {
            Side::Naive => naive::nearest(&triangles, &ray, Edges::Strict).map(|hit| hit.1),
            Side::Lightbox => cast(&geometry, &ray).map(|hit| hit.prim as usize),
        };
        hit.map_or(HOLE, |id| face(&triangles, id, &ray))
    })
}

/// Q01: the measured Cornell box from within, towards the wall that is no parallelogram. The more
/// magenta, the further off the measured corners' surface, up to 3.2 units.
pub(super) fn cornell(side: Side) -> Image {
    let faces = quads::cornell_faces();
    let scene = quads::scene(&faces).expect("a box of convex quads");
    draw(|_, at| {
        let axes = [Vec3::Z, Vec3::Y, Vec3::X];
        let ray = look(Vec3::new(40.0, 270.0, 280.0), axes, at, 0.62);
        let Some(hit) = scene.intersect(&ray) else {
            return HOLE;
        };
        let color = lit(scene.primitives().surface_point(&ray, &hit).n, &ray);
        let t = match side {
            Side::Naive => faces
                .iter()
                .filter_map(|q| quads::naive_quad(*q, &ray))
                .min_by(f32::total_cmp),
            Side::Lightbox => Some(hit.t),
        };
        t.map_or(HOLE, |t| {
            color.lerp(HOLE, ((t - hit.t).abs() / 3.2).min(1.0))
        })
    })
}

/// M03: up at a lamp in the plane of the ceiling, which comes first in the list.
pub(super) fn lamp_in_ceiling(side: Side) -> Image {
    let square = |half: f32| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, z)| Vec3::new(half * x, 5.0, half * z))
    };
    let geometry = quads::geometry(&[square(4.0), square(1.5)], AccelKind::Auto);
    draw(|_, at| {
        let ray = look(Vec3::ZERO, [Vec3::X, Vec3::Z, Vec3::Y], at, 1.0);
        let hit = match side {
            Side::Naive => cast(&geometry, &ray),
            Side::Lightbox => geometry.intersect(&ray, |prim| prim == 1),
        };
        match hit {
            None => NOTHING,
            Some(hit) if hit.prim == 1 => LAMP,
            Some(_) => lit(Vec3::Y, &ray),
        }
    })
}

/// K04: stairs from above.
pub(super) fn stairs_from_above(side: Side) -> Image {
    let triangles = stairs(20);
    let geometry = build(&triangles, AccelKind::Auto);
    let tree = naive::Tree::of(&triangles, 10);
    draw(|_, [x, y]| {
        let ray = Ray::new(Vec3::new(0.5 + 0.5 * x, 0.5 + 0.5 * y, 2.0), -Vec3::Z);
        let hit = match side {
            Side::Naive => tree.cast(&triangles, &ray).map(|hit| hit.0),
            Side::Lightbox => cast(&geometry, &ray).map(|hit| hit.t),
        };
        hit.map_or(HOLE, |t| Vec3::splat(0.05 + 0.8 * (2.0 - t)))
    })
}

/// V01: squares straight ahead, by rays whose directions have −0.
pub(super) fn negative_zero(side: Side) -> Image {
    let triangles = grid(8);
    let geometry = build(&triangles, AccelKind::Auto);
    let tree = naive::Tree::of(&triangles, 8);
    draw(|_, at| {
        let ray = straight(at, 8.0, -0.0);
        let hit = match side {
            Side::Naive => tree.cast(&triangles, &ray).map(|hit| hit.1 as usize),
            Side::Lightbox => cast(&geometry, &ray).map(|hit| hit.prim as usize),
        };
        hit.map_or(HOLE, |id| face(&triangles, id, &ray))
    })
}

/// T10: a sliver seen a twentieth of a degree off its plane, from 300 away; pixels run along it and,
/// finer, across. Magenta: hits outside the triangle's box.
pub(super) fn sliver(side: Side) -> Image {
    let (a, along) = (Vec3::new(300.0, -200.0, 100.0), Vec3::new(0.6, 0.5, 0.62));
    let along = along.normalize();
    let across = along.cross(Vec3::Z).normalize();
    let triangle = [a, a + 11.2 * along, a + 9.75 * along + 0.03 * across];
    let n = triangle_normal(triangle);
    let dir = (across - 0.0009 * n).normalize();
    let up = dir.cross(along);
    let bounds = Aabb::of_points(triangle);
    let slack = 64.0 * f32::EPSILON * 600.0;
    draw(|_, [x, y]| {
        let target = a + (5.6 + 7.0 * x) * along + 4e-5 * (0.35 + y) * up;
        let ray = Ray::new(target - 300.0 * dir, dir);
        let t = match side {
            Side::Naive => naive::triangle(triangle, &ray, Edges::Closed),
            Side::Lightbox => hit(triangle, &ray),
        };
        let Some(p) = t.map(|t| ray.at(t)) else {
            return NOTHING;
        };
        let inside = p.cmpge(bounds.min - slack).all() && p.cmple(bounds.max + slack).all();
        if inside { Vec3::splat(0.6) } else { HOLE }
    })
}

/// K02: triangles that a ray is tested against, of 1000 in one place. A tree that halves its box
/// all the same meets them in every cell; where rays pass by the triangle, white is 16 times each.
pub(super) fn identical(side: Side) -> Image {
    let triangle = [
        Vec3::new(0.1, 0.2, 0.3),
        Vec3::new(1.0, -0.5, 0.7),
        Vec3::new(-0.3, 0.9, 2.0),
    ];
    let triangles = [triangle; 1000];
    let halved = naive::Tree::of(&triangles, 12);
    let tree = tree_size::kd_tree(&triangles);
    let bounds = Aabb::of_points(triangle);
    let (center, reach) = (bounds.center(), bounds.diagonal());
    draw(|_, at| {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        let ray = look(center - 2.0 * reach * Vec3::Z, axes, at, 0.3);
        let tests = Cell::new(0);
        let count = |_| {
            tests.set(tests.get() + 1);
            hit(triangle, &ray)
        };
        match side {
            Side::Naive => drop(halved.walk(&ray, (0.0, ray.t_max), &count)),
            Side::Lightbox => tree.walk(&ray, |id, t_max| count(id).unwrap_or(t_max)),
        }
        Vec3::splat(tests.get() as f32 / (16 * triangles.len()) as f32)
    })
}
