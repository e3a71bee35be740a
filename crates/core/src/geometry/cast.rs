//! Casting rays at primitives through an accelerator, on the instructions that the machine has.
//!
//! The nearest hit is a minimum over (distance, primitive), and so does not depend on the order
//! in which an accelerator comes by the primitives.

use std::ops::Range;

use rayon::prelude::*;

use super::search::{Any, Face, Nearest, Search, offer_triangle, reach};
use super::sides::Sides;
use super::sweep::Sweep;
use super::{Hit, Primitives};
use crate::accel::bvh::{Built, Leaves};
use crate::accel::{self, Bvh, KdTree, Progress, TreeStats};
use crate::math::{Aabb, Ray};
use crate::settings::AccelKind;
use crate::shape::{Place, ShearedRay, TriangleRuns};
use crate::simd::{Kernel, Lanes, Portable, Task};

/// Below this many triangles that are no sides, testing them all beats walking a tree (measured:
/// docs/ray-casting.md).
const TRIANGLES_BELOW: usize = 4;

/// Below this many spheres, testing them all takes no longer where many rays meet a sphere at a time (measured:
/// docs/ray-casting.md).
const SPHERES_BELOW: usize = 49;

/// Primitives with their accelerator: what rays are cast at. Frozen.
#[derive(Debug)]
pub struct Geometry {
    pub(super) primitives: Primitives,
    pub(super) accel: Accel,
    pub(super) kernel: Kernel,
    bounds: Aabb,
    pub(super) sides: Sides,
}

#[derive(Debug)]
pub(super) enum Accel {
    /// Everything, in the order of ids.
    Brute(Sweep),
    KdTree(KdTree),
    /// Its leaves are the runs of [`super::Triangles`].
    Bvh {
        tree: Bvh,
        /// The spheres' own tree, with their ids in its order; if there are few, they are all
        /// tested.
        spheres: Option<(Bvh, Vec<u32>)>,
    },
}

impl Primitives {
    /// Number of triangles, each quad counted as two.
    pub(super) fn faces(&self) -> usize {
        self.triangles.len() + 2 * self.quads.len()
    }

    /// One of these, by number, before they are laid out.
    pub(super) fn face(&self, number: u32) -> ([glam::Vec3; 3], Face) {
        self.triangles.face(&self.quads, number)
    }

    /// Id of the first sphere.
    pub(super) fn first_sphere(&self) -> u32 {
        (self.triangles.len() + self.quads.len()) as u32
    }
}

/// Box around primitives or faces whose own is not empty.
fn around(ids: Range<u32>, bounds: impl Fn(u32) -> Aabb + Send + Sync) -> Aabb {
    ids.into_par_iter()
        .map(bounds)
        // NaN would swallow what there was before.
        .filter(|bounds| !bounds.is_empty())
        .reduce(|| Aabb::EMPTY, Aabb::union)
}

impl Geometry {
    /// What is built if `accel` is asked for: never [`AccelKind::Auto`].
    fn choice(primitives: &Primitives, sides: &Sides, accel: AccelKind) -> AccelKind {
        let are_few = primitives.faces() - sides.count() < TRIANGLES_BELOW
            && primitives.spheres.len() < SPHERES_BELOW;
        match accel {
            AccelKind::Auto if are_few => AccelKind::Brute,
            AccelKind::Auto => AccelKind::Bvh,
            accel => accel,
        }
    }

    /// Freezes primitives and builds what `accel` asks for, for the best kernel of the machine.
    pub fn build(primitives: Primitives, accel: AccelKind) -> Self {
        Self::build_for(primitives, accel, Kernel::detect())
    }

    /// [`Self::build`] for a certain kernel, one of [`Kernel::available`].
    pub fn build_for(primitives: Primitives, accel: AccelKind, kernel: Kernel) -> Self {
        Self::build_with(primitives, accel, kernel, &Progress::unwatched())
    }

    /// [`Self::build`] whose progress is watched. If it is ended before time, nothing certain is
    /// hit.
    pub(crate) fn build_watched(
        primitives: Primitives,
        accel: AccelKind,
        progress: &Progress<'_>,
    ) -> Self {
        Self::build_with(primitives, accel, Kernel::detect(), progress)
    }

    fn build_with(
        mut primitives: Primitives,
        accel: AccelKind,
        kernel: Kernel,
        progress: &Progress<'_>,
    ) -> Self {
        let face = |i| Aabb::of_points(primitives.face(i).0);
        let faces = around(0..primitives.faces() as u32, face);
        let spheres = primitives.first_sphere()..primitives.len() as u32;
        let bounds = faces.union(around(spheres, |id| primitives.bounds(id)));
        let sides = Sides::of(&primitives, faces);
        let accel = match Self::choice(&primitives, &sides, accel) {
            AccelKind::Brute => Accel::Brute(Sweep::of(&mut primitives, &sides)),
            AccelKind::KdTree => {
                let bounds = |id| match sides.have(id) {
                    true => Aabb::EMPTY,
                    false => primitives.bounds(id),
                };
                let boxes: Vec<_> = (0..primitives.len() as u32).map(bounds).collect();
                let clip = |id, cell: &Aabb| primitives.clipped_bounds(id, cell);
                Accel::KdTree(KdTree::build_watched(&boxes, clip, progress))
            }
            AccelKind::Auto | AccelKind::Bvh => {
                let bounds = |i| match primitives.face(i) {
                    (_, face) if sides.have(face.id()) => Aabb::EMPTY,
                    (triangle, _) => Aabb::of_points(triangle),
                };
                let count = primitives.faces();
                // The triangles come to lie where their boxes are, which are less.
                let mut memory = TriangleRuns::memory(count);
                let Built { tree, order } =
                    Bvh::build_watched(count, bounds, &mut memory, kernel, progress);
                if !progress.is_stopped() {
                    let quads = &primitives.quads;
                    primitives.triangles.lay_out(quads, memory, order);
                }
                let first = primitives.first_sphere();
                let spheres = (primitives.spheres.len() >= SPHERES_BELOW).then(|| {
                    let bounds = |i| primitives.bounds(first + i);
                    let count = primitives.spheres.len();
                    let memory = &mut Bvh::memory(count);
                    let built = Bvh::build_watched(count, bounds, memory, kernel, progress);
                    let ids = built.order.iter().map(|i| first + i.id()).collect();
                    (built.tree, ids)
                });
                Accel::Bvh { tree, spheres }
            }
        };
        Self {
            primitives,
            accel,
            kernel,
            bounds,
            sides,
        }
    }

    /// The primitives.
    #[inline(always)]
    pub fn primitives(&self) -> &Primitives {
        &self.primitives
    }

    /// The instructions for which it was built.
    pub(crate) fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// What was built: never [`AccelKind::Auto`].
    pub fn accel(&self) -> AccelKind {
        match self.accel {
            Accel::Brute(_) => AccelKind::Brute,
            Accel::KdTree(_) => AccelKind::KdTree,
            Accel::Bvh { .. } => AccelKind::Bvh,
        }
    }

    /// Measures the tree over triangles and quads, and in the kd-tree spheres, if there is one.
    pub fn tree_stats(&self) -> Option<TreeStats> {
        match &self.accel {
            Accel::Brute(_) => None,
            Accel::KdTree(tree) => Some(tree.stats()),
            Accel::Bvh { tree, .. } => Some(tree.stats()),
        }
    }

    /// Memory of the accelerator beside the primitives, bytes.
    pub fn accel_bytes(&self) -> usize {
        match &self.accel {
            Accel::Brute(_) => 0,
            Accel::KdTree(tree) => tree.bytes(),
            Accel::Bvh { tree, spheres } => {
                let spheres = spheres.as_ref();
                let spheres = spheres.map_or(0, |(t, ids)| t.bytes() + size_of_val(&**ids));
                tree.bytes() + spheres
            }
        }
    }

    /// Box around everything.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The nearest hit with `0 < t ≤ t_max`; the lowest id among equals. Primitives that
    /// `is_emitter` count as nearer by a rounding error, so that a lamp in the plane of a ceiling
    /// is seen, whatever the order of the primitives. A ray with NaN or infinite origin or
    /// direction, no direction, or without `t_max > 0` hits nothing.
    #[inline]
    pub fn intersect(&self, ray: &Ray, is_emitter: impl Fn(u32) -> bool) -> Option<Hit> {
        let mut nearest = Nearest {
            is_emitter,
            t_max: reach(ray),
            face: Face::NONE,
            b: [0.0; 2],
        };
        self.search(ray, &mut nearest);
        nearest.hit(&self.primitives)
    }

    /// Whether anything but primitive `except` is hit with `0 < t ≤ t_max`.
    #[inline]
    pub fn occluded(&self, ray: &Ray, except: u32) -> bool {
        let mut any = Any {
            except,
            t_max: reach(ray),
        };
        self.search(ray, &mut any);
        any.found()
    }

    #[inline(always)]
    pub(super) fn search(&self, ray: &Ray, search: &mut impl Search) {
        self.kernel.run(Cast {
            geometry: self,
            ray,
            search,
        });
    }

    #[inline(always)]
    pub(super) fn search_with<L: Lanes>(&self, ray: &Ray, search: &mut impl Search) {
        let sheared = ShearedRay::new(ray);
        match &self.accel {
            Accel::Brute(sweep) => {
                if accel::may_hit(&sweep.bounds, ray) {
                    let runs = self.primitives.triangles.runs();
                    for (first, count) in sweep.runs() {
                        test_run::<L>(runs, &sheared, first, count, search);
                    }
                }
                self.search_spheres(None, ray, search);
            }
            Accel::KdTree(tree) => tree.walk_with(ray, search, Search::node, |search, id, _| {
                self.test_primitive(id, ray, &sheared, search);
                search.t_max()
            }),
            Accel::Bvh { tree, spheres } => {
                let leaves = &mut TriangleLeaves {
                    runs: self.primitives.triangles.runs(),
                    ray: &sheared,
                    search,
                };
                tree.walk::<L>(ray, leaves);
                self.search_spheres(spheres.as_ref(), ray, search);
            }
        }
        if self.sides.count() > 0 {
            self.test_sides::<L, _>(ray, &sheared, search);
        }
    }

    /// The sides, after all else.
    #[inline(always)]
    fn test_sides<L: Lanes, S: Search>(&self, ray: &Ray, sheared: &ShearedRay, search: &mut S) {
        let Sides { runs, parts, .. } = &self.sides;
        let matter = self.sides.matter(ray, search.t_max(), search.except());
        for (&(first, count), matters) in parts.iter().zip(matter) {
            if matters && count > 0 {
                test_run::<L>(runs, sheared, first, count, search);
            }
        }
    }

    /// The spheres beside the tree over triangles.
    #[inline(always)]
    pub(super) fn search_spheres(
        &self,
        tree: Option<&(Bvh, Vec<u32>)>,
        ray: &Ray,
        search: &mut impl Search,
    ) {
        if self.primitives.spheres.is_empty() {
            return;
        }
        match tree {
            None if !accel::may_hit(&self.bounds, ray) => {}
            None => self.test_spheres(ray, search),
            Some((tree, ids)) => self.walk_spheres(tree, ids, ray, search),
        }
    }

    /// The spheres' own tree; spheres are tested one by one, so the portable kernel will do.
    #[inline(never)]
    pub(super) fn walk_spheres(
        &self,
        tree: &Bvh,
        ids: &[u32],
        ray: &Ray,
        search: &mut impl Search,
    ) {
        tree.walk::<Portable>(
            ray,
            &mut SphereLeaves {
                geometry: self,
                ids,
                ray,
                search,
            },
        );
    }

    #[inline(always)]
    pub(super) fn test_spheres(&self, ray: &Ray, search: &mut impl Search) {
        for id in self.primitives.first_sphere()..self.primitives.len() as u32 {
            self.test_sphere(id, ray, search);
        }
    }

    #[inline(always)]
    pub(super) fn test_sphere(&self, id: u32, ray: &Ray, search: &mut impl Search) {
        search.tests(1);
        let sphere = &self.primitives.spheres[(id - self.primitives.first_sphere()) as usize];
        if let Some(t) = sphere.intersect(ray, search.limit()) {
            search.offer(t, Face::of(id), [0.0; 2]);
        }
    }

    #[inline(always)]
    fn test_primitive(&self, id: u32, ray: &Ray, sheared: &ShearedRay, search: &mut impl Search) {
        use super::Primitive;
        let face = Face::of(id);
        match self.primitives.get(id) {
            Primitive::Triangle(triangle) => {
                search.tests(1);
                offer_triangle(sheared.triangle(triangle, search.limit()), face, search);
            }
            Primitive::Quad(quad) => {
                search.tests(2);
                let [first, second] = quad.triangles();
                offer_triangle(sheared.triangle(first, search.limit()), face, search);
                let face = Face(face.0 + 1);
                offer_triangle(sheared.triangle(second, search.limit()), face, search);
            }
            Primitive::Sphere(_) => self.test_sphere(id, ray, search),
        }
    }
}

/// One ray, for a kernel.
struct Cast<'a, S> {
    geometry: &'a Geometry,
    ray: &'a Ray,
    search: &'a mut S,
}

impl<S: Search> Task for Cast<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.geometry.search_with::<L>(self.ray, self.search);
    }
}

/// Leaves of the tree over triangles.
struct TriangleLeaves<'a, S> {
    runs: &'a TriangleRuns,
    ray: &'a ShearedRay,
    search: &'a mut S,
}

impl<S: Search> Leaves for TriangleLeaves<'_, S> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, first: u32, count: u32, _: f32) -> f32 {
        test_run::<L>(self.runs, self.ray, first, count, self.search);
        self.search.t_max()
    }

    #[inline(always)]
    fn node(&mut self) {
        self.search.node();
    }
}

/// Leaves of the tree over spheres.
struct SphereLeaves<'a, S> {
    geometry: &'a Geometry,
    ids: &'a [u32],
    ray: &'a Ray,
    search: &'a mut S,
}

impl<S: Search> Leaves for SphereLeaves<'_, S> {
    fn visit<L: Lanes>(&mut self, first: u32, count: u32, _: f32) -> f32 {
        for &id in &self.ids[first as usize..][..count as usize] {
            self.geometry.test_sphere(id, self.ray, self.search);
        }
        self.search.t_max()
    }

    #[inline(always)]
    fn node(&mut self) {
        self.search.node();
    }
}

/// Tests up to eight triangles.
#[inline(always)]
fn test_run<L: Lanes>(
    runs: &TriangleRuns,
    ray: &ShearedRay,
    first: u32,
    count: u32,
    search: &mut impl Search,
) {
    search.tests(count);
    let candidates = runs.candidates::<L>(ray, first, count, search.limit());
    let mut mask = candidates.mask;
    if mask == 0 {
        return;
    }
    let triangles = candidates.apart();
    while mask != 0 {
        let lane = mask.trailing_zeros();
        mask &= mask - 1;
        let place = Place::new(first, count).after(lane);
        let hit = runs.hit((&triangles, lane), || *ray, place, search.limit());
        offer_triangle(hit, Face(runs.tag_at(place)), search);
    }
}
