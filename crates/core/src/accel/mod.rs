//! Accelerators. In: boxes, and for the kd-tree a function that clips primitives by id. Out: the
//! primitives that a ray may hit, roughly nearest first. They never see a shape.

mod beam;
pub mod bvh;
pub mod kdtree;
mod progress;

#[cfg(test)]
pub(crate) mod test;

pub(crate) use beam::Beam;
use bvh::Along;
pub use bvh::Bvh;
pub use kdtree::KdTree;
pub use progress::Progress;

use crate::math::{Aabb, Ray};

/// A tree that many rays go through in one call.
pub(crate) trait Tree {
    /// What the walk needs of a ray, the slopes 1/direction first and the reach last, and whether the ray
    /// meets the tree.
    fn along(&self, ray: &Ray) -> (Along, bool);
}

/// Size and expected cost of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct TreeStats {
    /// Nodes: of the kd-tree with its leaves, of the wide tree without.
    pub nodes: usize,
    /// Leaves, empty ones included.
    pub leaves: usize,
    /// Primitives over all leaves, each counted wherever it is listed.
    pub references: usize,
    /// Greatest number of inner nodes above a leaf.
    pub max_depth: usize,
    /// Memory of nodes and lists.
    pub bytes: usize,
    /// Expected cost of a ray that crosses the bounds and hits nothing: of the kd-tree in visits
    /// of inner nodes, of the wide tree in visits of nodes and leaves.
    pub sah_cost: f64,
}

/// Whether a ray has meaning and meets the box, to within the rounding errors of an f32 test.
#[inline(always)]
pub fn may_hit(bounds: &Aabb, ray: &Ray) -> bool {
    Beam::new(ray, bounds).is_met
}

/// Half the surface of a box, in f64, in which the squares of all f32 have room; 0 if empty.
fn half_area(b: &Aabb) -> f64 {
    if b.is_empty() {
        return 0.0;
    }
    let e = b.max.as_dvec3() - b.min.as_dvec3();
    e.x * e.y + e.y * e.z + e.z * e.x
}
