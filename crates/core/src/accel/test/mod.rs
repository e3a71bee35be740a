//! The trees, on every kernel, against brute force over the same primitives and the same visitor:
//! distances and ids bit for bit. Names that begin with a letter and a number are cases of the
//! stability catalogue.

mod traverse;

use glam::{DVec3, Vec3, Vec3Swizzles};

pub(crate) use crate::lab::input::{Triangle, grid, meaningless, needles};
pub use crate::lab::random::Rng;

use super::bvh::Leaves;
use super::{Bvh, KdTree, bvh, kdtree};
use crate::math::{Aabb, Ray};
use crate::simd::{Kernel, Lanes, Task};

/// A tree, and how it is walked.
pub enum Walker {
    Kd(KdTree),
    Bvh(bvh::Built, Kernel),
}

impl Walker {
    /// Calls `visit(id, t_max)` for primitives along a ray, as `KdTree::walk` does.
    pub fn walk(&self, ray: &Ray, visit: Visit) {
        match self {
            Self::Kd(tree) => tree.walk(ray, visit),
            Self::Bvh(built, kernel) => kernel.run(Walk { built, ray, visit }),
        }
    }
}

/// A walk through a tree of eight-wide boxes.
struct Walk<'a> {
    built: &'a bvh::Built,
    ray: &'a Ray,
    visit: Visit<'a>,
}

impl Task for Walk<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut each = Each {
            order: &self.built.order,
            visit: self.visit,
        };
        self.built.tree.walk::<L>(self.ray, &mut each);
    }
}

/// Shows the primitives of leaves to a visitor, one after the other.
struct Each<'a> {
    order: &'a [bvh::Ordered],
    visit: Visit<'a>,
}

impl Leaves for Each<'_> {
    fn visit<L: Lanes>(&mut self, first: u32, count: u32, mut t_max: f32) -> f32 {
        for place in &self.order[first as usize..][..count as usize] {
            let id = place.id();
            t_max = (self.visit)(id, t_max);
            if t_max == f32::NEG_INFINITY {
                break;
            }
        }
        t_max
    }
}

/// What a walk calls.
pub type Visit<'a> = &'a mut dyn FnMut(u32, f32) -> f32;

/// Distance to a triangle, after Woop, Benthin & Wald (2013), with edge functions in f64.
pub fn intersect([a, b, c]: Triangle, ray: &Ray, t_max: f32) -> Option<f32> {
    let d = ray.dir.to_array();
    let z = ray.dir.abs().max_position();
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let (sx, sy, sz) = (d[x] / d[z], d[y] / d[z], 1.0 / d[z]);
    let [a, b, c] = [a, b, c].map(|v| {
        let v = v - ray.origin;
        [v[x] - sx * v[z], v[y] - sy * v[z], sz * v[z]]
    });
    let edge = |p: [f32; 3], q: [f32; 3]| {
        f64::from(q[0]) * f64::from(p[1]) - f64::from(q[1]) * f64::from(p[0])
    };
    let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
    let det = u + v + w;
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) || det == 0.0 {
        return None;
    }
    let t = (u * f64::from(a[2]) + v * f64::from(b[2]) + w * f64::from(c[2])) / det;
    let t = t as f32;
    (t > 0.0 && t <= t_max).then_some(t)
}

/// Box around the part of a triangle in a cell (Sutherland & Hodgman 1974).
pub fn clip(triangle: &Triangle, cell: &Aabb) -> Aabb {
    let mut polygon: Vec<DVec3> = triangle.iter().map(|p| p.as_dvec3()).collect();
    for axis in 0..3 {
        for (bound, sign) in [(cell.min[axis], 1.0), (cell.max[axis], -1.0)] {
            let height = |p: DVec3| sign * (p[axis] - f64::from(bound));
            let mut kept = Vec::new();
            for (i, &p) in polygon.iter().enumerate() {
                let q = polygon[(i + 1) % polygon.len()];
                let (dp, dq) = (height(p), height(q));
                if dp >= 0.0 {
                    kept.push(p);
                }
                if dp * dq < 0.0 {
                    kept.push(p + (q - p) * (dp / (dp - dq)));
                }
            }
            polygon = kept;
        }
    }
    Aabb::of_points(polygon.into_iter().map(DVec3::as_vec3))
}

/// Every tree on every kernel.
pub fn build(triangles: &[Triangle]) -> Vec<Walker> {
    let bounds: Vec<Aabb> = triangles.iter().map(|t| Aabb::of_points(*t)).collect();
    let kd = kdtree::test::build(triangles);
    let bvh = Kernel::available().into_iter().map(|kernel| {
        let built = Bvh::build(bounds.len(), |id| bounds[id as usize]);
        bvh::test::validate(&built, &bounds);
        Walker::Bvh(built, kernel)
    });
    std::iter::once(Walker::Kd(kd)).chain(bvh).collect()
}

/// Distance bits and id of the nearest hit, by a given walk over the primitives.
fn closest(triangles: &[Triangle], ray: &Ray, walk: impl FnOnce(Visit)) -> Option<(u32, u32)> {
    let mut best: Option<(f32, u32)> = None;
    walk(
        &mut |id, t_max| match intersect(triangles[id as usize], ray, t_max) {
            Some(t) if best.is_none_or(|b| (t, id) < b) => {
                best = Some((t, id));
                t
            }
            _ => t_max,
        },
    );
    best.map(|(t, id)| (t.to_bits(), id))
}

/// The nearest hit, in which all trees must agree.
fn closest_in_trees(trees: &[Walker], triangles: &[Triangle], ray: &Ray) -> Option<(u32, u32)> {
    let hits: Vec<_> = trees
        .iter()
        .map(|tree| closest(triangles, ray, |visit| tree.walk(ray, visit)))
        .collect();
    assert!(hits.iter().all(|hit| *hit == hits[0]), "{ray:?} {hits:?}");
    hits[0]
}

/// Compares all rays' hits, nearest and any, with brute force; gives the number of hits.
pub fn check(trees: &[Walker], triangles: &[Triangle], rays: &[Ray]) -> usize {
    let mut hits = 0;
    for ray in rays {
        let found = closest_in_trees(trees, triangles, ray);
        let expected = closest(triangles, ray, |visit| {
            let mut t_max = ray.t_max;
            for id in 0..triangles.len() as u32 {
                t_max = visit(id, t_max);
            }
        });
        assert_eq!(found, expected, "{ray:?}");
        for tree in trees {
            let mut any = false;
            tree.walk(ray, &mut |id, t_max| {
                assert!(!any, "visited after the stop");
                any = intersect(triangles[id as usize], ray, t_max).is_some();
                if any { f32::NEG_INFINITY } else { t_max }
            });
            assert_eq!(any, expected.is_some(), "{ray:?}");
        }
        hits += usize::from(found.is_some());
    }
    hits
}

/// Rays aimed at vertices, edges and insides, from outside, inside and from vertices; along
/// axes, in planes, and with ends.
pub fn rays_at(triangles: &[Triangle], n: usize, rng: &mut Rng) -> Vec<Ray> {
    let bounds = Aabb::of_points(triangles.iter().flatten().copied());
    let (center, size) = (bounds.center(), bounds.diagonal());
    let aimed = |origin: Vec3, target: Vec3, t_max: f32| Ray {
        origin,
        dir: (target - origin).normalize_or(Vec3::X),
        t_max,
    };
    let mut rays = Vec::new();
    while rays.len() < n {
        let triangle = triangles[rng.below(triangles.len())];
        let target = match rng.below(3) {
            0 => triangle[rng.below(3)],
            1 => triangle[0].lerp(triangle[1], rng.unit()),
            _ => rng.point_of(triangle),
        };
        let other = triangles[rng.below(triangles.len())];
        let origin = match rng.below(4) {
            0 => other[rng.below(3)],
            1 => center + 3.0 * size * rng.cube(),
            _ => center + 0.5 * size * rng.cube(),
        };
        let ray = aimed(origin, target, f32::INFINITY);
        rays.push(ray);
        // Through the target along an axis, with zeros of both signs.
        let axis = Vec3::AXES[rng.below(3)] * [1.0, -1.0][rng.below(2)];
        let along = Ray::new(target - size * axis, axis);
        rays.push(along);
        rays.push(Ray {
            dir: axis.map(|x| if x == 0.0 { -0.0 } else { x }),
            ..along
        });
        // One zero component: in a plane that vertices of a grid share.
        let flat = (target - origin) * (Vec3::ONE - axis.abs());
        rays.push(aimed(target - flat, target, f32::INFINITY));
        // Ends at a hit, closed, and just before it.
        let reach = (target - origin).length();
        rays.push(Ray {
            t_max: reach,
            ..ray
        });
        rays.push(Ray {
            t_max: reach.next_down(),
            ..ray
        });
    }
    rays
}

/// Random rays of all kinds against a scene; asserts that at least a tenth hit.
pub fn check_scene(triangles: &[Triangle], n: usize, seed: u64) -> Vec<Walker> {
    let trees = build(triangles);
    let rays = rays_at(triangles, n, &mut Rng(seed));
    let hits = check(&trees, triangles, &rays);
    assert!(hits * 10 >= rays.len(), "{hits} hits of {n} rays");
    trees
}

/// A closed sphere with bumps, poles included.
pub fn bumpy_sphere(n: usize) -> Vec<Triangle> {
    let point = |i: usize, j: usize| {
        let theta = std::f32::consts::PI * j as f32 / n as f32;
        let phi = std::f32::consts::PI * (i % (2 * n)) as f32 / n as f32;
        let r = 1.0 + 0.2 * (5.0 * theta).sin() * (7.0 * phi).cos();
        match j {
            0 => Vec3::Z,
            _ if j == n => -Vec3::Z,
            _ => {
                r * Vec3::new(
                    theta.sin() * phi.cos(),
                    theta.sin() * phi.sin(),
                    theta.cos(),
                )
            }
        }
    };
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..2 * n {
            let [a, b] = [point(i, j), point(i + 1, j)];
            let [c, d] = [point(i + 1, j + 1), point(i, j + 1)];
            if j > 0 {
                triangles.push([a, b, c]);
            }
            if j + 1 < n {
                triangles.push([a, c, d]);
            }
        }
    }
    triangles
}
