//! The sides of a room: faces that lie in the box around all triangles and quads.
//!
//! They stand between no two points of the box, and a ray from inside comes to no face after the one by
//! which it leaves the box. So they are in no tree: segments within the box ask for none but the one in
//! which they end, and other rays after all else, and only for those where they cross the box. Spheres do
//! not count: where one stands on the floor, its box goes a rounding below.

use glam::Vec3;
use rayon::prelude::*;

use super::{Primitive, Primitives};
use crate::accel::bvh::Ordered;
use crate::math::{Aabb, Ray};
use crate::shape::TriangleRuns;

#[cfg(test)]
mod test;

/// Number of sides that a box has: two to an axis, the lower first.
pub(super) const SIDES: usize = 6;

/// Names no primitive.
const NO_ONE: u32 = 1 << 31;

/// How far a ray passes by a side, or ends before it, if no test accepts that, in units of the largest
/// distance along an axis from its origin to a corner of the box: twice what tests round and emitters
/// are ahead (`accel::beam`).
const CLEAR: f32 = 144.0 / (1 << 24) as f32;

/// The faces in the sides of a box.
#[derive(Debug)]
pub(super) struct Sides {
    pub runs: TriangleRuns,
    /// Where the faces of each side begin and how many there are: no more than make a run.
    pub parts: [(u32, u32); SIDES],
    /// The primitives that they are of, in order.
    ids: Vec<u32>,
    /// The primitive that a side is, if it is one, as a wall that is a quad.
    only: [u32; SIDES],
    bounds: Aabb,
}

/// In which side of a box a primitive lies.
fn side_of(bounds: &Aabb, primitive: &Primitive) -> Option<usize> {
    let side = |corners: &[Vec3]| {
        (0..SIDES).find(|side| {
            let (axis, bound) = (side / 2, [bounds.min, bounds.max][side % 2]);
            corners.iter().all(|v| v[axis] == bound[axis])
        })
    };
    match primitive {
        Primitive::Triangle(triangle) => side(triangle),
        Primitive::Quad(quad) => side(&quad.corners()),
        Primitive::Sphere(_) => None,
    }
}

impl Sides {
    /// The faces in the sides of `bounds`, which is around all of them; where a side has more than make a run,
    /// those that are an eighth of it or more.
    pub fn of(primitives: &Primitives, bounds: Aabb) -> Self {
        let faces = (0..primitives.faces() as u32).into_par_iter();
        let side = |i| {
            let ([corner, ..], face) = primitives.face(i);
            // Hardly any goes on.
            let is_on_one = corner.cmpeq(bounds.min) | corner.cmpeq(bounds.max);
            if !is_on_one.any() {
                return None;
            }
            Some((side_of(&bounds, &primitives.get(face.id()))?, i))
        };
        let faces: Vec<(usize, u32)> = faces.filter_map(side).collect();
        let (mut parts, mut only) = ([(0, 0); SIDES], [NO_ONE; SIDES]);
        let (mut order, mut ids) = (vec![], vec![]);
        for side in 0..SIDES {
            let id = |face: &u32| primitives.face(*face).1.id();
            let faces = faces.iter().filter(|(s, _)| *s == side);
            let mut faces: Vec<u32> = faces.map(|(_, face)| *face).collect();
            if faces.len() > TriangleRuns::MAX {
                let size = bounds.extent();
                let area = size[(side / 2 + 1) % 3] * size[(side / 2 + 2) % 3];
                faces.retain(|face| primitives.area(id(face)) >= area / TriangleRuns::MAX as f32);
            }
            if faces.is_empty() || faces.len() > TriangleRuns::MAX {
                continue;
            }
            parts[side] = (order.len() as u32, faces.len() as u32);
            let first = id(&faces[0]);
            if faces.iter().all(|face| id(face) == first) {
                only[side] = first;
            }
            ids.extend(faces.iter().map(id));
            let runs = (0..).zip(&faces);
            order.extend(runs.map(|(i, face)| Ordered::new(*face, i == 0)));
        }
        ids.sort_unstable();
        let runs = TriangleRuns::new(
            TriangleRuns::memory(order.len()),
            &order,
            |i| i.begins(),
            |i| {
                let (triangle, face) = primitives.face(i.id());
                (triangle, face.0)
            },
            |_| {},
            |_, _| {},
        );
        Self {
            runs,
            parts,
            ids,
            only,
            bounds,
        }
    }

    /// Number of faces.
    pub fn count(&self) -> usize {
        self.runs.count()
    }

    /// Whether a primitive is one of them.
    pub fn have(&self, id: u32) -> bool {
        self.ids.binary_search(&id).is_ok()
    }

    /// Whether a ray that goes up to `t_max` plainly stays between all sides, so that none matters to it. Without a
    /// branch, as [`Sides::matter`].
    #[inline(always)]
    pub fn hold(&self, ray: &Ray, t_max: f32) -> bool {
        let (origin, dir) = (ray.origin.to_array(), ray.dir.to_array());
        let (min, max) = (self.bounds.min.to_array(), self.bounds.max.to_array());
        // No corner is farther from a start within than the extent.
        let clear = CLEAR * self.bounds.extent().max_element();
        let mut stays = true;
        for axis in 0..3 {
            let (o, end) = (origin[axis], origin[axis] + t_max * dir[axis]);
            stays &= (min[axis] <= o) & (o <= max[axis]);
            stays &= (min[axis] + clear < end) & (end < max[axis] - clear);
        }
        stays | (t_max == f32::NEG_INFINITY)
    }

    /// In which sides a ray that goes up to `t_max` may find something but the primitive `except`. Without a
    /// branch, so that a loop over many rays is SIMD code.
    #[inline(always)]
    pub fn matter(&self, ray: &Ray, t_max: f32, except: u32) -> [bool; SIDES] {
        let (origin, dir) = (ray.origin.to_array(), ray.dir.to_array());
        let (min, max) = (self.bounds.min.to_array(), self.bounds.max.to_array());
        let mut reach = 0.0;
        for axis in 0..3 {
            for to in [
                (min[axis] - origin[axis]).abs(),
                (max[axis] - origin[axis]).abs(),
            ] {
                reach = if to > reach { to } else { reach };
            }
        }
        let clear = CLEAR * reach;
        let mut matter = [false; SIDES];
        for (side, matters) in matter.iter_mut().enumerate() {
            let axis = side / 2;
            let at = if side % 2 == 0 { min[axis] } else { max[axis] };
            let (o, d) = (origin[axis], dir[axis]);
            let t = (at - o) / d;
            let beyond = (o + t_max * d - at) * if d < 0.0 { -1.0 } else { 1.0 };
            let mut is_met = (t > 0.0) & (beyond >= -clear) & (self.only[side] != except);
            for other in [(axis + 1) % 3, (axis + 2) % 3] {
                let p = origin[other] + t * dir[other];
                is_met &= (min[other] - clear <= p) & (p <= max[other] + clear);
            }
            *matters = is_met;
        }
        matter
    }
}
