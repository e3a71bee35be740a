//! Casting many rays in one call: the same hits as one by one, sooner.

use std::cell::Cell;

use glam::Vec3;

use super::Hit;
use super::cast::{Accel, Geometry};
use super::flights::{Flight, RayGroup};
use super::search::{Any, Face, Nearest, Search, reach};
use crate::accel::bvh::{self, Along, Lists, OCTANTS, Sorted, Stream};
use crate::accel::{Bvh, Tree};
use crate::math::{Floats, GROUP, Ray};
use crate::shape::{Pairs, Place, ShearedRays, TriangleRuns};
use crate::simd::{Lanes, SET_BITS, Task, prefetch_start};

mod eights;
mod few;

/// So few rays are cast one by one (measured: docs/ray-casting.md).
const FEW: usize = 16;

/// Memory is asked for so many items ahead (measured: docs/ray-casting.md).
const AHEAD: usize = 200;

/// Most rays of a stream.
const BATCH: usize = 4096;

impl Geometry {
    /// [`Geometry::intersect`] for the `ray` of each of some items; `found(i, hit)` receives what that of
    /// the i-th hits, in their order.
    #[inline]
    pub fn intersect_many<T>(
        &self,
        items: &[T],
        ray: impl Fn(&T) -> Ray,
        is_emitter: impl Fn(u32) -> bool + Copy,
        mut found: impl FnMut(usize, Option<Hit>),
    ) {
        let nearest = |item: &T| {
            let ray = ray(item);
            let t_max = reach(&ray);
            let (face, b) = (Face::NONE, [0.0; 2]);
            let nearest = Nearest {
                is_emitter,
                t_max,
                face,
                b,
            };
            (ray, nearest)
        };
        self.search_many(items, nearest, |i, nearest| {
            found(i, nearest.hit(&self.primitives));
        });
    }

    /// [`Geometry::occluded`] for the `ray` of each of some items, and the primitive that does not shade it;
    /// `found(i, occluded)` receives the answer for the i-th, in their order.
    #[inline]
    pub fn occluded_many<T>(
        &self,
        items: &[T],
        ray: impl Fn(&T) -> (Ray, u32),
        mut found: impl FnMut(usize, bool),
    ) {
        let any = |item: &T| {
            let (ray, except) = ray(item);
            let t_max = reach(&ray);
            (ray, Any { except, t_max })
        };
        self.search_many(items, any, |i, any| found(i, any.found()));
    }

    /// Casts rays by the batch.
    #[inline(always)]
    fn search_many<T, S: Search>(
        &self,
        items: &[T],
        search: impl Fn(&T) -> (Ray, S),
        mut found: impl FnMut(usize, &S),
    ) {
        let mut scratch = SCRATCH.take().unwrap_or_default();
        let mut searches = Vec::with_capacity(items.len().min(BATCH));
        for (k, batch) in items.chunks(BATCH).enumerate() {
            searches.clear();
            let groups = batch.chunks(GROUP).zip(&mut scratch.rays);
            for (begin, (group, rays)) in (k * BATCH..).step_by(GROUP).zip(groups) {
                searches.extend(group.iter().enumerate().map(|(i, item)| {
                    if let Some(item) = items.get(begin + i + AHEAD) {
                        prefetch_start(item);
                    }
                    let (ray, search) = search(item);
                    rays.set(i, &ray, search.t_max());
                    search
                }));
            }
            self.search_batch(&mut searches, &mut scratch);
            for (i, search) in searches.iter().enumerate() {
                found(k * BATCH + i, search);
            }
        }
        SCRATCH.set(Some(scratch));
    }

    /// Of its own for each kind of search, but not for each caller: it is much code.
    fn search_batch<S: Search>(&self, searches: &mut [S], scratch: &mut Scratch) {
        self.kernel.run(CastMany {
            geometry: self,
            searches,
            scratch,
        });
    }
}

/// Up to [`BATCH`] rays, for a kernel.
struct CastMany<'a, S> {
    geometry: &'a Geometry,
    searches: &'a mut [S],
    scratch: &'a mut Scratch,
}

impl<S: Search> Task for CastMany<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self {
            geometry,
            searches,
            scratch,
        } = self;
        if !L::MANY || searches.len() <= FEW {
            for (i, search) in searches.iter_mut().enumerate() {
                let ray = scratch.rays[i / GROUP].get(i % GROUP);
                geometry.search_with::<L>(&ray, search);
            }
            return;
        }
        let runs = geometry.primitives.triangles.runs();
        let spheres = match &geometry.accel {
            Accel::Brute(sweep) => {
                few::sweep::<L, S>(runs, sweep, searches, scratch);
                Some(None)
            }
            Accel::KdTree(tree) => {
                prepare_batch::<L>(tree, searches.len(), scratch);
                eights::cast::<L, S>(geometry, tree, searches, scratch);
                None
            }
            Accel::Bvh { tree, spheres } => {
                cast_batch::<L, S>(runs, tree, searches, scratch);
                Some(spheres.as_ref())
            }
        };
        match spheres {
            Some(Some((tree, ids))) => {
                for (i, search) in searches.iter_mut().enumerate() {
                    let ray = scratch.rays[i / GROUP].get(i % GROUP);
                    geometry.walk_spheres(tree, ids, &ray, search);
                }
            }
            Some(None) => few::cast_at_spheres(&geometry.primitives, searches, &scratch.rays),
            None => {}
        }
        if geometry.sides.count() > 0 {
            few::cast_at_sides::<L, S>(&geometry.sides, searches, scratch);
        }
    }
}

/// Makes rays ready for a tree, and returns how far the start of one is from that of the next.
#[inline(always)]
fn prepare_batch<L: Lanes>(tree: &impl Tree, count: usize, scratch: &mut Scratch) -> f32 {
    let Scratch {
        columns,
        rays,
        flights,
        sorted,
        ..
    } = scratch;
    let rays = &rays[..count.div_ceil(GROUP)];
    let mut steps = 0.0;
    sorted.clear();
    for (k, (rays, flights)) in rays.iter().zip(flights.iter_mut()).enumerate() {
        let count = GROUP.min(count - k * GROUP);
        rays.prepare::<L>(tree, (k * GROUP, count), columns, flights, sorted);
        steps += (rays.get(0).origin - rays.get(1 % count).origin).length();
    }
    steps / rays.len() as f32
}

/// Casts rays through the tree over triangles, one octant after the other.
#[inline(always)]
fn cast_batch<L: Lanes, S: Search>(
    runs: &TriangleRuns,
    tree: &Bvh,
    searches: &mut [S],
    scratch: &mut Scratch,
) {
    let step = prepare_batch::<L>(tree, searches.len(), scratch);
    let Scratch {
        flights,
        sorted,
        lists,
        pairs,
        ..
    } = scratch;
    let mut batch = Batch::new(runs, flights, searches, pairs);
    for octant in 0..OCTANTS {
        tree.walk_stream::<L>((octant, step), sorted.items(octant), lists, &mut batch);
    }
    batch.settle();
}

/// Triangles by what pairs call their place.
trait Faces {
    fn triangle(&self, place: Place) -> [Vec3; 3];
    fn face(&self, place: Place) -> Face;
}

impl Faces for TriangleRuns {
    #[inline(always)]
    fn triangle(&self, place: Place) -> [Vec3; 3] {
        self.triangle_at(place)
    }

    #[inline(always)]
    fn face(&self, place: Place) -> Face {
        Face(self.tag_at(place))
    }
}

/// Rays on their way through a tree.
struct Batch<'a, S, F> {
    faces: &'a F,
    flights: &'a mut [Flight],
    searches: &'a mut [S],
    /// Pairs that wait for the exact test.
    pairs: &'a mut Pairs,
}

/// What a pair is called: from the lowest bit, 32 of the triangle's place, 8 of its stride, 16 of the ray.
#[inline(always)]
fn name(item: u16, place: Place) -> u64 {
    u64::from(item) << 40 | u64::from(place.count) << 32 | u64::from(place.at)
}

/// The ray and the triangle that are called so.
#[inline(always)]
fn named(name: u64) -> (u16, Place) {
    let (at, count) = (name as u32, (name >> 32) as u32 & 0xff);
    ((name >> 40) as u16, Place { at, count })
}

/// What batches use one after the other: clearing it for each would take longer than a few rays do.
struct Scratch {
    columns: [[Floats; 8]; 2],
    rays: Vec<RayGroup>,
    flights: Vec<[Flight; GROUP]>,
    sorted: Sorted,
    lists: Lists,
    pairs: Pairs,
}

thread_local! {
    static SCRATCH: Cell<Option<Box<Scratch>>> = const { Cell::new(None) };
}

impl Default for Scratch {
    fn default() -> Self {
        Self {
            columns: [[[0.0; GROUP]; 8]; 2],
            rays: vec![RayGroup::default(); BATCH / GROUP],
            flights: vec![[Flight::default(); GROUP]; BATCH / GROUP],
            sorted: Sorted::default(),
            lists: Lists::default(),
            pairs: Pairs::default(),
        }
    }
}

impl<'a, S: Search, F: Faces> Batch<'a, S, F> {
    #[inline(always)]
    fn new(
        faces: &'a F,
        flights: &'a mut [[Flight; GROUP]],
        searches: &'a mut [S],
        pairs: &'a mut Pairs,
    ) -> Self {
        let flights = flights.as_flattened_mut();
        Self {
            faces,
            flights,
            searches,
            pairs,
        }
    }

    /// Tests all pairs that wait.
    #[inline(always)]
    fn settle(&mut self) {
        self.pairs.test();
        for k in 0..self.pairs.count() {
            let (name, hit, is_clear) = self.pairs.found(k);
            let (item, place) = named(name);
            let flight = &mut self.flights[usize::from(item)];
            let search = &mut self.searches[usize::from(item)];
            if hit.t > 0.0
                && hit.t <= search.limit()
                && (is_clear || flight.sheared.meets_plane(self.faces.triangle(place)))
            {
                search.offer(hit.t, self.faces.face(place), [hit.b1, hit.b2]);
                flight.set_t_max(search.t_max());
            }
        }
        self.pairs.clear();
    }
}

impl<S: Search> Batch<'_, S, TriangleRuns> {
    /// Meets the triangles of a leaf at once with one ray at a time.
    #[inline(always)]
    fn visit_each<L: Lanes>(&mut self, items: &[u16], first: u32, count: u32) {
        if items.is_empty() {
            return;
        }
        let place = Place::new(first, count);
        let run = self.faces.run::<L>(first, count);
        for &item in items {
            let flight = &self.flights[usize::from(item)];
            let limit = flight.along.t_max() * S::LIMIT;
            let found = run.candidates(&flight.sheared, limit);
            let name = name(item, place);
            let lanes = SET_BITS[found.mask as usize & 0xff];
            self.pairs
                .add(&found, lanes.map(|lane| name + u64::from(lane)));
        }
    }
}

impl<S: Search> Stream for Batch<'_, S, TriangleRuns> {
    #[inline(always)]
    fn along(&self, item: u16) -> &Along {
        &self.flights[usize::from(item)].along
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, items: &[u16], first: u32, count: u32) {
        for items in items.chunks(8) {
            self.visit_each::<L>(items, first, count);
            if self.pairs.are_enough() {
                self.settle();
            }
        }
    }

    #[inline(always)]
    fn boxes(&self, first: u32, count: u32, center: Vec3) -> [[[f32; 8]; 2]; 3] {
        self.faces.boxes(first, count, center)
    }

    #[inline(always)]
    fn visit_one<L: Lanes>(&mut self, items: &[u16], first: u32, count: u32, place: u32) {
        let place = Place::new(first, count).after(place);
        let triangle = self.faces.triangle_at(place);
        for items in items.chunks(8) {
            let mut eight = [items[0]; 8];
            match items.first_chunk() {
                Some(items) => eight = *items,
                None => eight[..items.len()].copy_from_slice(items),
            }
            let ray = |i: usize| &self.flights[usize::from(eight[i])].sheared;
            let rays = [
                ray(0),
                ray(1),
                ray(2),
                ray(3),
                ray(4),
                ray(5),
                ray(6),
                ray(7),
            ];
            let rays = ShearedRays::<L>::new(rays, S::LIMIT);
            if let Some(found) = rays.candidates(triangle, (1 << items.len()) - 1) {
                let mut hit = [0; 8];
                L::compress(bvh::in_a_row(&eight), found.mask as usize, &mut hit);
                self.pairs.add(&found, hit.map(|item| name(item, place)));
            }
            if self.pairs.are_enough() {
                self.settle();
            }
        }
    }

    #[inline(always)]
    fn prefetch(&self, first: u32, count: u32) {
        self.faces.prefetch(first, count);
    }
}
