//! The methods that fail: textbook formulas, and those of the report that lightbox grew out of.

use glam::Vec3;

use crate::math::{Aabb, Ray};
use crate::shape::Sphere;

/// The textbook quadratic, b² − 4ac in f32; then the report's rule for the root:
/// `t0·t1 ≥ 0 ? min : max`.
pub fn sphere(sphere: &Sphere, ray: &Ray) -> Option<f32> {
    let (t0, t1) = sphere_roots(sphere, ray)?;
    Some(if t0 * t1 >= 0.0 {
        t0.min(t1)
    } else {
        t0.max(t1)
    })
}

/// Both roots of the textbook quadratic.
pub fn sphere_roots(sphere: &Sphere, ray: &Ray) -> Option<(f32, f32)> {
    let f = ray.origin - sphere.center;
    let a = ray.dir.dot(ray.dir);
    let b = 2.0 * ray.dir.dot(f);
    let c = f.dot(f) - sphere.radius * sphere.radius;
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    Some(((-b - root) / (2.0 * a), (-b + root) / (2.0 * a)))
}

/// Which points of a triangle's edge belong to it.
#[derive(Clone, Copy, PartialEq)]
pub enum Edges {
    /// None: barycentric coordinates `> 0`.
    Strict,
    /// All: `≥ 0`.
    Closed,
}

/// Möller & Trumbore 1997 in f32, with no test of t and none for degenerate triangles. The tests
/// are written the wrong way round, so that NaN passes them.
pub fn triangle([a, b, c]: [Vec3; 3], ray: &Ray, edges: Edges) -> Option<f32> {
    let (e1, e2) = (b - a, c - a);
    let p = ray.dir.cross(e2);
    let inv = 1.0 / e1.dot(p);
    let s = ray.origin - a;
    let u = s.dot(p) * inv;
    let q = s.cross(e1);
    let v = ray.dir.dot(q) * inv;
    let outside = match edges {
        Edges::Strict => u <= 0.0 || v <= 0.0 || u + v >= 1.0,
        Edges::Closed => u < 0.0 || v < 0.0 || u + v > 1.0,
    };
    (!outside).then(|| e2.dot(q) * inv)
}

/// The nearest triangle in front of the ray.
pub fn nearest(triangles: &[[Vec3; 3]], ray: &Ray, edges: Edges) -> Option<(f32, usize)> {
    let mut best: Option<(f32, usize)> = None;
    for (i, t) in triangles.iter().enumerate() {
        if let Some(t) = triangle(*t, ray, edges)
            && t > 0.0
            && best.is_none_or(|b| t < b.0)
        {
            best = Some((t, i));
        }
    }
    best
}

/// The slab test of a box by reciprocals, with minima as SSE has them: NaN, from 0 · ∞ for a ray
/// in the plane of a face, comes out of the second operand.
pub fn slabs(bounds: &Aabb, ray: &Ray) -> bool {
    let min = |a: f32, b: f32| if a < b { a } else { b };
    let max = |a: f32, b: f32| if a > b { a } else { b };
    let (mut enter, mut exit) = (0.0, ray.t_max);
    for axis in 0..3 {
        let inv = 1.0 / ray.dir[axis];
        let t0 = (bounds.min[axis] - ray.origin[axis]) * inv;
        let t1 = (bounds.max[axis] - ray.origin[axis]) * inv;
        enter = max(enter, min(t0, t1));
        exit = min(exit, max(t0, t1));
    }
    enter <= exit
}

/// Where rays start in most first renderers: a fixed distance off the surface.
pub fn leave(p: Vec3, n: Vec3, w: Vec3, epsilon: f32) -> Vec3 {
    p + if w.dot(n) < 0.0 { -epsilon } else { epsilon } * n
}

/// A kd-tree as first written: split in the middle of the longest axis, with three mistakes. What
/// lies in a split plane is on neither side of it, the order of the children follows `dir ≥ 0`,
/// which −0 passes, and the first leaf with a hit ends the walk wherever the hit is.
pub enum Tree {
    Leaf(Vec<u32>),
    Inner {
        axis: usize,
        split: f32,
        children: Box<[Tree; 2]>,
    },
}

impl Tree {
    /// A tree over boxes, `depth` levels deep at most.
    pub fn build(boxes: &[Aabb], depth: u32) -> Self {
        let bounds = boxes.iter().fold(Aabb::EMPTY, |a, b| a.union(*b));
        let ids = (0..boxes.len() as u32).collect();
        Self::split(boxes, ids, bounds, depth)
    }

    fn split(boxes: &[Aabb], ids: Vec<u32>, cell: Aabb, depth: u32) -> Self {
        if depth == 0 || ids.len() <= 2 {
            return Self::Leaf(ids);
        }
        let axis = cell.extent().max_position();
        let split = cell.center()[axis];
        let (mut below, mut above) = (cell, cell);
        below.max[axis] = split;
        above.min[axis] = split;
        let keep = |keeps: &dyn Fn(&Aabb) -> bool| -> Vec<u32> {
            let kept = ids.iter().filter(|id| keeps(&boxes[**id as usize]));
            kept.copied().collect()
        };
        let (low, high) = (
            keep(&|b| b.min[axis] < split),
            keep(&|b| b.max[axis] > split),
        );
        Self::Inner {
            axis,
            split,
            children: Box::new([
                Self::split(boxes, low, below, depth - 1),
                Self::split(boxes, high, above, depth - 1),
            ]),
        }
    }

    /// The first hit that a walk comes by; `test` gives a primitive's.
    pub fn walk(
        &self,
        ray: &Ray,
        (enter, exit): (f32, f32),
        test: &dyn Fn(u32) -> Option<f32>,
    ) -> Option<(f32, u32)> {
        match self {
            Self::Leaf(ids) => ids
                .iter()
                .filter_map(|id| test(*id).map(|t| (t, *id)))
                .min_by(|a, b| a.0.total_cmp(&b.0)),
            Self::Inner {
                axis,
                split,
                children,
            } => {
                let dir = ray.dir[*axis];
                let t = (split - ray.origin[*axis]) / dir;
                let [below, above] = &**children;
                let (near, far) = if dir >= 0.0 {
                    (below, above)
                } else {
                    (above, below)
                };
                if t > exit {
                    near.walk(ray, (enter, exit), test)
                } else if t < enter {
                    far.walk(ray, (enter, exit), test)
                } else {
                    near.walk(ray, (enter, t), test)
                        .or_else(|| far.walk(ray, (t, exit), test))
                }
            }
        }
    }

    /// The first hit among triangles.
    pub fn cast(&self, triangles: &[[Vec3; 3]], ray: &Ray) -> Option<(f32, u32)> {
        let sheared = crate::shape::ShearedRay::new(ray);
        self.walk(ray, (0.0, ray.t_max), &|id| {
            sheared
                .triangle(triangles[id as usize], ray.t_max)
                .map(|hit| hit.t)
        })
    }

    /// The tree of triangles.
    pub fn of(triangles: &[[Vec3; 3]], depth: u32) -> Self {
        let boxes: Vec<Aabb> = triangles.iter().map(|t| Aabb::of_points(*t)).collect();
        Self::build(&boxes, depth)
    }

    /// Primitives over all leaves.
    pub fn references(&self) -> usize {
        match self {
            Self::Leaf(ids) => ids.len(),
            Self::Inner { children, .. } => children.iter().map(Self::references).sum(),
        }
    }
}
