//! Casting rays at primitives through an accelerator, on the instructions that the machine has.
//!
//! The nearest hit is a minimum over (distance, primitive), and so does not depend on the order
//! in which an accelerator comes by the primitives.

use super::{Hit, Primitives};
use crate::accel::bvh::{self, Leaves};
use crate::accel::{self, Bvh, KdTree, TreeStats};
use crate::math::{Aabb, Ray};
use crate::settings::AccelKind;
use crate::shape::{ShearedRay, TriangleHit, TriangleRuns};
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::simd::{Kernel, Lanes, Portable};

/// Below this many triangles, testing them all beats walking a tree (measured:
/// docs/ray-casting.md).
const SWEEP_BELOW: usize = 25;

/// Relative distance within which an emitter wins against a surface in the same place.
const NUDGE: f32 = 1.0 / (1 << 20) as f32;

/// Primitives with their accelerator: what rays are cast at. Frozen.
#[derive(Debug)]
pub struct Geometry {
    primitives: Primitives,
    accel: Accel,
    kernel: Kernel,
    bounds: Aabb,
}

#[derive(Debug)]
enum Accel {
    /// Everything, in the order of ids.
    Brute(Triangles),
    KdTree(KdTree),
    Bvh {
        triangles: Triangles,
        tree: Bvh,
        /// The spheres' own tree, with their ids in its order; if there are few, they are all
        /// tested.
        spheres: Option<(Bvh, Vec<u32>)>,
    },
}

/// The triangles, and each quad as two, for SIMD. The tag of a triangle is its [`Face`].
#[derive(Debug)]
struct Triangles {
    runs: TriangleRuns,
    count: u32,
}

/// A triangle, one of the two of a quad, or a sphere, in 32 bits: 2 · id, and 1 more for a
/// quad's second triangle. Faces are ordered as their ids are.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Face(u32);

impl Face {
    /// Later than any face.
    const NONE: Self = Self(u32::MAX);

    #[inline(always)]
    fn id(self) -> u32 {
        self.0 >> 1
    }
}

impl Primitives {
    /// Number of triangles, each quad counted as two.
    fn faces(&self) -> usize {
        self.triangles.len() + 2 * self.quads.len()
    }

    /// A triangle by number: the triangles, then both of each quad.
    fn face(&self, i: usize) -> ([glam::Vec3; 3], Face) {
        let count = self.triangles.len();
        if i < count {
            return (self.triangles[i], Face(2 * i as u32));
        }
        let half = i - count;
        let id = count + half / 2;
        let triangle = self.quads[half / 2].triangles()[half % 2];
        (triangle, Face((2 * id + half % 2) as u32))
    }

    /// Id of the first sphere.
    fn first_sphere(&self) -> u32 {
        (self.triangles.len() + self.quads.len()) as u32
    }
}

impl Triangles {
    fn new(primitives: &Primitives, runs: impl Iterator<Item = usize>, order: &[u32]) -> Self {
        let runs = TriangleRuns::new(runs, |i| {
            let (triangle, face) = primitives.face(order[i] as usize);
            (triangle, face.0)
        });
        Self {
            runs,
            count: order.len() as u32,
        }
    }

    /// In the order of ids, in runs of the greatest length.
    fn in_order(primitives: &Primitives) -> Self {
        let count = primitives.faces();
        let order: Vec<u32> = (0..count as u32).collect();
        let full = std::iter::repeat_n(TriangleRuns::MAX, count / TriangleRuns::MAX);
        let rest = count % TriangleRuns::MAX;
        Self::new(primitives, full.chain((rest > 0).then_some(rest)), &order)
    }
}

impl Geometry {
    /// Freezes primitives and builds what `accel` asks for, for the best kernel of the machine.
    pub fn build(primitives: Primitives, accel: AccelKind) -> Self {
        Self::build_for(primitives, accel, Kernel::detect())
    }

    /// [`Self::build`] for a certain kernel, one of [`Kernel::available`].
    pub fn build_for(primitives: Primitives, accel: AccelKind, kernel: Kernel) -> Self {
        let boxes = || -> Vec<Aabb> {
            (0..primitives.len() as u32)
                .map(|id| primitives.bounds(id))
                .collect()
        };
        let bounds = (0..primitives.len() as u32)
            .map(|id| primitives.bounds(id))
            .fold(Aabb::EMPTY, Aabb::union);
        let accel = match accel {
            AccelKind::Auto if primitives.faces() + primitives.spheres.len() < SWEEP_BELOW => {
                Accel::Brute(Triangles::in_order(&primitives))
            }
            AccelKind::Brute => Accel::Brute(Triangles::in_order(&primitives)),
            AccelKind::KdTree => Accel::KdTree(KdTree::build(&boxes(), |id, cell| {
                primitives.clipped_bounds(id, cell)
            })),
            AccelKind::Auto | AccelKind::Bvh => {
                let boxes: Vec<Aabb> = (0..primitives.faces())
                    .map(|i| Aabb::of_points(primitives.face(i).0))
                    .collect();
                let bvh::Built { tree, order, runs } = Bvh::build(&boxes);
                let lengths = runs.iter().map(|&n| usize::from(n));
                let triangles = Triangles::new(&primitives, lengths, &order);
                let first = primitives.first_sphere();
                let spheres = (primitives.spheres.len() >= SWEEP_BELOW).then(|| {
                    let boxes: Vec<Aabb> = (first..primitives.len() as u32)
                        .map(|id| primitives.bounds(id))
                        .collect();
                    let built = Bvh::build(&boxes);
                    let ids = built.order.iter().map(|i| first + i).collect();
                    (built.tree, ids)
                });
                Accel::Bvh {
                    triangles,
                    tree,
                    spheres,
                }
            }
        };
        Self {
            primitives,
            accel,
            kernel,
            bounds,
        }
    }

    /// The primitives.
    #[inline(always)]
    pub fn primitives(&self) -> &Primitives {
        &self.primitives
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

    /// Memory of the accelerator, its own copy of the triangles included, bytes.
    pub fn accel_bytes(&self) -> usize {
        match &self.accel {
            Accel::Brute(triangles) => triangles.runs.bytes(),
            Accel::KdTree(tree) => tree.bytes(),
            Accel::Bvh {
                triangles,
                tree,
                spheres,
            } => {
                let spheres = spheres.as_ref();
                let spheres = spheres.map_or(0, |(t, ids)| t.bytes() + size_of_val(&**ids));
                tree.bytes() + triangles.runs.bytes() + spheres
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
            t_max: ray.t_max,
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
            t_max: ray.t_max,
        };
        self.search(ray, &mut any);
        any.t_max == f32::NEG_INFINITY
    }

    #[inline(always)]
    fn search(&self, ray: &Ray, search: &mut impl Search) {
        match self.kernel {
            Kernel::Portable => self.search_with::<Portable>(ray, search),
            #[cfg(target_arch = "x86_64")]
            Kernel::Avx2 => {
                #[expect(unsafe_code, reason = "enters a SIMD kernel")]
                // SAFETY: the kernel is AVX2 only on machines that have it; see `Kernel`.
                unsafe {
                    self.search_avx2(ray, search);
                }
            }
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn search_avx2(&self, ray: &Ray, search: &mut impl Search) {
        self.search_with::<Avx2>(ray, search);
    }

    #[inline(always)]
    fn search_with<L: Lanes>(&self, ray: &Ray, search: &mut impl Search) {
        let sheared = ShearedRay::new(ray);
        match &self.accel {
            Accel::Brute(triangles) => {
                if !accel::may_hit(&self.bounds, ray) {
                    return;
                }
                let mut first = 0;
                while first < triangles.count {
                    let count = (triangles.count - first).min(TriangleRuns::MAX as u32);
                    test_run::<L>(&triangles.runs, &sheared, first, count, search);
                    first += count;
                }
                self.test_spheres(ray, search);
            }
            Accel::KdTree(tree) => tree.walk(ray, |id, _| {
                self.test_primitive(id, ray, &sheared, search);
                search.t_max()
            }),
            Accel::Bvh {
                triangles,
                tree,
                spheres,
            } => {
                tree.walk::<L>(
                    ray,
                    &mut TriangleLeaves {
                        runs: &triangles.runs,
                        ray: &sheared,
                        search,
                    },
                );
                if self.primitives.spheres.is_empty() {
                    return;
                }
                match spheres {
                    None => {
                        if accel::may_hit(&self.bounds, ray) {
                            self.test_spheres(ray, search);
                        }
                    }
                    Some((tree, ids)) => tree.walk::<L>(
                        ray,
                        &mut SphereLeaves {
                            geometry: self,
                            ids,
                            ray,
                            search,
                        },
                    ),
                }
            }
        }
    }

    #[inline(always)]
    fn test_spheres(&self, ray: &Ray, search: &mut impl Search) {
        for id in self.primitives.first_sphere()..self.primitives.len() as u32 {
            self.test_sphere(id, ray, search);
        }
    }

    #[inline(always)]
    fn test_sphere(&self, id: u32, ray: &Ray, search: &mut impl Search) {
        let sphere = &self.primitives.spheres[(id - self.primitives.first_sphere()) as usize];
        if let Some(t) = sphere.intersect(ray, search.limit()) {
            search.offer(t, Face(2 * id), [0.0; 2]);
        }
    }

    #[inline(always)]
    fn test_primitive(&self, id: u32, ray: &Ray, sheared: &ShearedRay, search: &mut impl Search) {
        use super::Primitive;
        let face = Face(2 * id);
        match self.primitives.get(id) {
            Primitive::Triangle(triangle) => {
                offer_triangle(sheared.triangle(triangle, search.limit()), face, search);
            }
            Primitive::Quad(quad) => {
                let [first, second] = quad.triangles();
                offer_triangle(sheared.triangle(first, search.limit()), face, search);
                let face = Face(face.0 + 1);
                offer_triangle(sheared.triangle(second, search.limit()), face, search);
            }
            Primitive::Sphere(_) => self.test_sphere(id, ray, search),
        }
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
    let candidates = runs.candidates::<L>(ray, first, count, search.limit());
    let mut mask = candidates.mask;
    if mask == 0 {
        return;
    }
    let triangles = candidates.apart();
    while mask != 0 {
        let lane = mask.trailing_zeros();
        mask &= mask - 1;
        let hit = triangles.hit(lane, search.limit());
        offer_triangle(hit, Face(runs.tag(first, count, lane)), search);
    }
}

#[inline(always)]
fn offer_triangle(hit: Option<TriangleHit>, face: Face, search: &mut impl Search) {
    if let Some(hit) = hit {
        search.offer(hit.t, face, [hit.b1, hit.b2]);
    }
}

/// What a ray is cast for.
trait Search {
    /// What begins beyond this distance can be left out; −∞ when there is nothing left to find.
    fn t_max(&self) -> f32;
    /// Hits beyond this distance need not be offered.
    fn limit(&self) -> f32;
    /// Takes note of a hit; `b` are a triangle's second and third barycentric.
    fn offer(&mut self, t: f32, face: Face, b: [f32; 2]);
}

/// The nearest hit.
struct Nearest<E> {
    is_emitter: E,
    t_max: f32,
    face: Face,
    b: [f32; 2],
}

impl<E: Fn(u32) -> bool> Search for Nearest<E> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    /// Further than `t_max`, for emitters that are then counted as nearer.
    #[inline(always)]
    fn limit(&self) -> f32 {
        self.t_max * (1.0 + 2.0 * NUDGE)
    }

    #[inline(always)]
    fn offer(&mut self, mut t: f32, face: Face, b: [f32; 2]) {
        if (self.is_emitter)(face.id()) {
            t *= 1.0 - NUDGE;
        }
        if t < self.t_max || t == self.t_max && face < self.face {
            (self.t_max, self.face, self.b) = (t, face, b);
        }
    }
}

impl<E> Nearest<E> {
    #[inline(always)]
    fn hit(&self, primitives: &Primitives) -> Option<Hit> {
        if self.face == Face::NONE {
            return None;
        }
        let (prim, [b1, b2]) = (self.face.id(), self.b);
        // On a quad, from barycentrics of (a, b, c) or of (a, c, d) to those along its edges.
        let quad = prim.wrapping_sub(primitives.triangles.len() as u32);
        let (u, v) = if (quad as usize) < primitives.quads.len() {
            match self.face.0 & 1 {
                0 => (b1 + b2, b2),
                _ => (b1, b1 + b2),
            }
        } else {
            (b1, b2)
        };
        Some(Hit {
            t: self.t_max,
            prim,
            u,
            v,
        })
    }
}

/// Any hit but of one primitive.
struct Any {
    except: u32,
    /// −∞ once there is one.
    t_max: f32,
}

impl Search for Any {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn offer(&mut self, _: f32, face: Face, _: [f32; 2]) {
        if face.id() != self.except {
            self.t_max = f32::NEG_INFINITY;
        }
    }
}
