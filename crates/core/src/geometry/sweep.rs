//! No tree: every triangle is tested, in the order of ids.

use super::Primitives;
use super::sides::Sides;
use crate::accel::bvh::{Along, Ordered};
use crate::accel::{Beam, Tree};
use crate::math::{Aabb, Ray};
use crate::shape::TriangleRuns;

/// The faces but for the sides: so many, the first of the runs.
#[derive(Debug)]
pub(super) struct Sweep {
    count: u32,
    pub bounds: Aabb,
}

impl Tree for Sweep {
    #[inline(always)]
    fn along(&self, ray: &Ray) -> (Along, bool) {
        let beam = Beam::new(ray, &self.bounds);
        let [ix, iy, iz] = beam.inv_dir;
        let along = Along([ix, iy, iz, 0.0, 0.0, 0.0, 0.0, ray.t_max]);
        (along, beam.is_met)
    }
}

impl Sweep {
    /// Lays out all faces, those that are no sides first.
    pub fn of(primitives: &mut Primitives, sides: &Sides) -> Self {
        let faces = 0..primitives.faces() as u32;
        let is_other = |i: &u32| !sides.have(primitives.face(*i).1.id());
        let others: Vec<_> = faces.filter(is_other).collect();
        let boxes = others
            .iter()
            .map(|i| Aabb::of_points(primitives.face(*i).0));
        let bounds = boxes.filter(|b| !b.is_empty());
        let bounds = bounds.fold(Aabb::EMPTY, Aabb::union);
        let begins = |i: u32| i.is_multiple_of(TriangleRuns::MAX as u32);
        let order = (0..).zip(&others);
        let order = order.map(|(i, face)| Ordered::new(*face, begins(i)));
        let order = order.collect();
        let memory = TriangleRuns::memory(primitives.faces());
        primitives
            .triangles
            .lay_out(&primitives.quads, memory, order);
        let count = others.len() as u32;
        Self { count, bounds }
    }

    /// Where each run begins, and how many it has.
    pub fn runs(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (end, most) = (self.count, TriangleRuns::MAX as u32);
        (0..end)
            .step_by(TriangleRuns::MAX)
            .map(move |first| (first, most.min(end - first)))
    }
}
