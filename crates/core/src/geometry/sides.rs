//! The sides of a room: faces that lie in the box around everything.
//!
//! Nothing is beyond them, so that they stand between no two points of the box, and a ray from inside
//! comes to them last, to those where it leaves the box. So they are in no tree: segments within the box
//! never ask for them, and other rays only if they have found nothing that is clearly before.

use glam::Vec3;
use rayon::prelude::*;

use super::search::Search;
use super::{Primitive, Primitives};
use crate::accel::bvh::Ordered;
use crate::math::{Aabb, Ray};
use crate::shape::TriangleRuns;

/// Number of sides that a box has: two to an axis, the lower first.
pub(super) const SIDES: usize = 6;

/// Stands for all sides, where it is not clear which it can be.
pub(super) const ANY: u32 = SIDES as u32;

/// Stands for no side.
pub(super) const NONE: u32 = ANY + 1;

/// Rounding of the end of a segment, o + t·d, in units of the largest coordinate.
const END: f32 = 4.0 * f32::EPSILON;

/// How far from a side a ray is clear of it, whatever tests round, in units of the longest edge of the
/// box: twice the rounding of a test and the start that emitters have (`accel::beam`).
const CLEAR: f32 = 144.0 / (1 << 24) as f32;

/// The faces in the sides of a box, and where they matter.
#[derive(Debug)]
pub(super) struct Sides {
    pub runs: TriangleRuns,
    /// Where the faces of each side begin and how many there are: no more than make a run.
    pub parts: [(u32, u32); SIDES],
    bounds: Aabb,
    /// A segment from inside that ends here stays inside.
    pub within: Aabb,
    /// What a ray from inside hits here it hits before any side.
    pub before: Aabb,
    /// How far from a side a ray is clear of it.
    clear: f32,
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
    /// The sides of what lies in `bounds`; none if one has too many faces.
    pub fn of(primitives: &Primitives, bounds: Aabb) -> Self {
        let faces = (0..primitives.faces() as u32).into_par_iter();
        let side = |i| {
            let primitive = primitives.get(primitives.face(i).1.id());
            Some((side_of(&bounds, &primitive)?, i))
        };
        let mut faces: Vec<_> = faces.filter_map(side).collect();
        faces.sort_unstable();
        if faces
            .chunk_by(|a, b| a.0 == b.0)
            .any(|side| side.len() > TriangleRuns::MAX)
        {
            faces.clear();
        }
        let mut parts = [(0, 0); SIDES];
        let mut order = vec![];
        for side in faces.chunk_by(|a, b| a.0 == b.0) {
            parts[side[0].0] = (order.len() as u32, side.len() as u32);
            order.extend(
                (0..)
                    .zip(side)
                    .map(|(i, (_, face))| Ordered::new(*face, i == 0)),
            );
        }
        let runs = TriangleRuns::new(
            &order,
            |i| i.begins(),
            |i| {
                let (triangle, face) = primitives.face(i.id());
                (triangle, face.0)
            },
        );
        let grown = |by: Vec3| Aabb {
            min: bounds.min - by,
            max: bounds.max + by,
        };
        let clear = CLEAR * bounds.extent().max_element();
        Self {
            runs,
            parts,
            bounds,
            within: grown(END * bounds.min.abs().max(bounds.max.abs())),
            before: grown(Vec3::splat(-clear)),
            clear,
        }
    }

    /// Number of faces.
    pub fn count(&self) -> usize {
        self.runs.count()
    }

    /// Whether a primitive is one of them.
    pub fn have(&self, primitive: &Primitive) -> bool {
        self.count() > 0 && side_of(&self.bounds, primitive).is_some()
    }

    /// In which side something may be found by a search that has been to all else and got to `t_max`: a
    /// side's number, [`ANY`] or [`NONE`]. Without a branch, so that a loop over many rays is SIMD code.
    #[inline(always)]
    pub fn matter<S: Search>(&self, ray: &Ray, t_max: f32) -> u32 {
        let Aabb { min, max } = self.bounds;
        let within = S::clear_of(self);
        let (mut is_inside, mut is_done) = (true, true);
        // Where the ray comes to the side that it leaves by, if it leaves there, on each axis.
        let (mut far, mut t) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            let (o, d) = (ray.origin[axis], ray.dir[axis]);
            let end = o + t_max * d;
            is_inside &= (min[axis] <= o) & (o <= max[axis]);
            is_done &= (within.min[axis] <= end) & (end <= within.max[axis]);
            far[axis] = if d > 0.0 { max[axis] } else { min[axis] };
            t[axis] = if d == 0.0 {
                f32::INFINITY
            } else {
                (far[axis] - o) / d
            };
        }
        let axis = match () {
            () if (t[0] <= t[1]) & (t[0] <= t[2]) => 0,
            () if t[1] <= t[2] => 1,
            () => 2,
        };
        let pick = |v: [f32; 3]| match axis {
            0 => v[0],
            1 => v[1],
            _ => v[2],
        };
        let (o, d, far) = (
            pick(ray.origin.to_array()),
            pick(ray.dir.to_array()),
            pick(far),
        );
        // When it comes to the others it is far outside.
        let mut is_clear = true;
        for (other, t) in t.into_iter().enumerate() {
            is_clear &= (other == axis) | ((o + t * d - far).abs() > self.clear);
        }
        let side = 2 * axis as u32 + u32::from(d > 0.0);
        let some = if is_inside & is_clear { side } else { ANY };
        if (t_max > 0.0) & !(is_inside & is_done) {
            some
        } else {
            NONE
        }
    }
}
