//! Many rays through the kd-tree: eight of an octant at a time, in their order.

use glam::Vec3;

use super::{Batch, Faces, Scratch, name};
use crate::accel::KdTree;
use crate::accel::bvh::{self, OCTANTS};
use crate::accel::kdtree::{Eight, Stack};
use crate::geometry::cast::Geometry;
use crate::geometry::flights::RayGroup;
use crate::geometry::search::{Face, Search};
use crate::geometry::{Primitive, Primitives};
use crate::math::GROUP;
use crate::shape::{Place, ShearedRays};
use crate::simd::Lanes;

/// A place is the number of the face.
impl Faces for Primitives {
    #[inline(always)]
    fn triangle(&self, place: Place) -> [Vec3; 3] {
        match self.get(place.at >> 1) {
            Primitive::Quad(quad) => quad.triangles()[place.at as usize & 1],
            Primitive::Triangle(triangle) => triangle,
            Primitive::Sphere(_) => [Vec3::NAN; 3],
        }
    }

    #[inline(always)]
    fn face(&self, place: Place) -> Face {
        Face(place.at)
    }
}

/// Casts rays that have been made ready, one octant after the other.
#[inline(always)]
pub(super) fn cast<L: Lanes, S: Search>(
    geometry: &Geometry,
    tree: &KdTree,
    searches: &mut [S],
    scratch: &mut Scratch,
) {
    let Scratch {
        rays,
        flights,
        sorted,
        pairs,
        ..
    } = scratch;
    let mut batch = Batch::new(geometry.primitives(), flights, searches, pairs);
    let mut stack = Stack::new();
    for octant in 0..OCTANTS {
        for chunk in sorted.items(octant).chunks(8) {
            // What is lacking is the first once more: to meet a thing twice changes nothing.
            let mut items = [chunk[0]; 8];
            items[..chunk.len()].copy_from_slice(chunk);
            // Written out: what `array::map` is given is not compiled for the kernel.
            let flight = |i: usize| &batch.flights[usize::from(items[i])];
            let (a, b, c, d) = (flight(0), flight(1), flight(2), flight(3));
            let (e, f, g, h) = (flight(4), flight(5), flight(6), flight(7));
            let along = L::transpose([
                &a.along.0, &b.along.0, &c.along.0, &d.along.0, &e.along.0, &f.along.0, &g.along.0,
                &h.along.0,
            ]);
            let sheared = [
                &a.sheared, &b.sheared, &c.sheared, &d.sheared, &e.sheared, &f.sheared, &g.sheared,
                &h.sheared,
            ];
            let mut rays = Rays {
                geometry,
                rays,
                sheared: ShearedRays::<L>::new(sheared, S::LIMIT),
                t_max: along[7],
                batch: &mut batch,
                items,
                is_settled: true,
            };
            tree.walk_eight(along, octant, &mut stack, &mut rays);
        }
    }
}

/// Eight rays.
struct Rays<'a, 'b, L, S> {
    geometry: &'a Geometry,
    rays: &'a [RayGroup],
    batch: &'a mut Batch<'b, S, Primitives>,
    items: [u16; 8],
    sheared: ShearedRays<L>,
    t_max: L,
    /// Whether nothing has been met since `t_max` was read.
    is_settled: bool,
}

impl<L: Lanes, S: Search> Rays<'_, '_, L, S> {
    #[inline(always)]
    fn test(&mut self, triangle: [Vec3; 3], face: Face, rays: u32) {
        let Some(found) = self.sheared.candidates(triangle, rays) else {
            return;
        };
        let mut items = [0; 8];
        L::compress(bvh::in_a_row(&self.items), found.mask as usize, &mut items);
        let place = Place {
            at: face.0,
            count: 0,
        };
        let pairs = &mut *self.batch.pairs;
        let mut names = [0; 8];
        for (to, item) in names.iter_mut().zip(items) {
            *to = name(item, place);
        }
        pairs.add(&found, names);
        self.is_settled = false;
        if self.batch.pairs.are_enough() {
            self.batch.settle();
        }
    }

    #[inline(never)]
    fn test_sphere(&mut self, id: u32, mut rays: u32) {
        while rays != 0 {
            let item = usize::from(self.items[rays.trailing_zeros() as usize % 8]);
            rays &= rays - 1;
            let ray = self.rays[item / GROUP].get(item % GROUP);
            let search = &mut self.batch.searches[item];
            self.geometry.test_sphere(id, &ray, search);
            self.batch.flights[item].set_t_max(search.t_max());
        }
        self.is_settled = false;
    }
}

impl<L: Lanes, S: Search> Eight<L> for Rays<'_, '_, L, S> {
    #[inline(always)]
    fn visit(&mut self, id: u32, rays: u32) {
        let face = Face::of(id);
        match self.geometry.primitives().get(id) {
            Primitive::Triangle(triangle) => self.test(triangle, face, rays),
            Primitive::Quad(quad) => {
                let [first, second] = quad.triangles();
                self.test(first, face, rays);
                self.test(second, Face(face.0 + 1), rays);
            }
            Primitive::Sphere(_) => self.test_sphere(id, rays),
        }
    }

    #[inline(always)]
    fn t_max(&mut self) -> L {
        if !self.is_settled {
            self.batch.settle();
            let mut t_max = [0.0; 8];
            for (t_max, item) in t_max.iter_mut().zip(self.items) {
                *t_max = self.batch.flights[usize::from(item)].along.t_max();
            }
            self.t_max = L::load(&t_max);
            self.sheared.set_t_max(self.t_max.mul(L::splat(S::LIMIT)));
            self.is_settled = true;
        }
        self.t_max
    }
}
