//! Casting many rays in one call: the same hits as one by one, sooner.

use std::cell::Cell;

use super::Hit;
use super::cast::{Accel, Geometry};
use super::search::{Any, Face, Nearest, Search, reach};
use crate::accel::Bvh;
use crate::accel::bvh::{self, Along, Lists, OCTANTS, Octant, Stream};
use crate::math::Ray;
use crate::shape::{PairHits, Pairs, Place, ROOM, ShearedRay, ShearedRays, TriangleRuns};
use crate::simd::{Lanes, SET_BITS, Task};

/// So few rays are cast one by one (measured: docs/ray-casting.md).
const FEW: usize = 128;

/// Most rays of a stream.
const BATCH: usize = 4096;

/// So many pairs are tested together.
const WAIT: usize = 16;

/// Rays that are shown a leaf together.
const VISIT: usize = 64;

impl Geometry {
    /// [`Geometry::intersect`] for rays 0 to `count` − 1: `ray(i)` gives a ray, `found(i, hit)`
    /// receives what it hits, in their order.
    #[inline]
    pub fn intersect_many(
        &self,
        count: usize,
        ray: impl Fn(usize) -> Ray,
        is_emitter: impl Fn(u32) -> bool + Copy,
        mut found: impl FnMut(usize, Option<Hit>),
    ) {
        let rays: Vec<Ray> = (0..count).map(ray).collect();
        let nearest = |ray: &Ray| Nearest {
            is_emitter,
            t_max: reach(ray),
            face: Face::NONE,
            b: [0.0; 2],
        };
        let mut searches: Vec<_> = rays.iter().map(nearest).collect();
        self.search_many(&rays, &mut searches);
        for (i, nearest) in searches.iter().enumerate() {
            found(i, nearest.hit(&self.primitives));
        }
    }

    /// [`Geometry::occluded`] for rays 0 to `count` − 1: `ray(i)` gives a ray and the primitive
    /// that does not shade it, `found(i, occluded)` receives the answer, in their order.
    #[inline]
    pub fn occluded_many(
        &self,
        count: usize,
        ray: impl Fn(usize) -> (Ray, u32),
        mut found: impl FnMut(usize, bool),
    ) {
        let any = |(ray, except)| {
            let t_max = reach(&ray);
            (ray, Any { except, t_max })
        };
        let (rays, mut searches): (Vec<_>, Vec<_>) = (0..count).map(ray).map(any).unzip();
        self.search_many(&rays, &mut searches);
        for (i, any) in searches.iter().enumerate() {
            found(i, any.found());
        }
    }

    /// Of its own for each kind of search, but not for each caller: it is much code.
    fn search_many<S: Search>(&self, rays: &[Ray], searches: &mut [S]) {
        self.kernel.run(CastMany {
            geometry: self,
            rays,
            searches,
        });
    }
}

/// Many rays, for a kernel.
struct CastMany<'a, S> {
    geometry: &'a Geometry,
    rays: &'a [Ray],
    searches: &'a mut [S],
}

impl<S: Search> Task for CastMany<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self {
            geometry,
            rays,
            searches,
        } = self;
        match &geometry.accel {
            Accel::Bvh { tree, spheres } if L::MANY && rays.len() > FEW => {
                let runs = geometry.primitives.triangles.runs();
                let mut scratch = SCRATCH.take().unwrap_or_default();
                let batches = rays.chunks(BATCH).zip(searches.chunks_mut(BATCH));
                for (rays, searches) in batches {
                    cast_batch::<L, S>(runs, tree, rays, searches, &mut scratch);
                }
                SCRATCH.set(Some(scratch));
                for (ray, search) in rays.iter().zip(searches) {
                    geometry.search_spheres(spheres.as_ref(), ray, search);
                }
            }
            _ => {
                for (ray, search) in rays.iter().zip(searches) {
                    geometry.search_with::<L>(ray, search);
                }
            }
        }
    }
}

/// Casts up to [`BATCH`] rays through the tree over triangles, one octant after the other.
#[inline(always)]
fn cast_batch<L: Lanes, S: Search>(
    runs: &TriangleRuns,
    tree: &Bvh,
    rays: &[Ray],
    searches: &mut [S],
    scratch: &mut Scratch,
) {
    let Scratch {
        lists,
        waiting,
        pairs,
        hits,
    } = scratch;
    let mut flights = Vec::with_capacity(rays.len());
    // What misses the tree comes last, in a list of its own.
    let mut counts = [0usize; OCTANTS + 1];
    let (mut steps, mut last) = (0.0, rays[0].origin);
    for (ray, search) in rays.iter().zip(&mut *searches) {
        steps += (ray.origin - last).length();
        last = ray.origin;
        let (mut along, octant, is_met) = tree.along(ray);
        let mut sheared = ShearedRay::new(ray);
        along.set_t_max(search.t_max());
        sheared.set_t_max(search.t_max());
        let octant = if is_met { octant } else { OCTANTS };
        counts[octant] += 1;
        flights.push(Flight {
            along,
            sheared,
            search,
            octant: octant as u8,
        });
    }
    let mut begins = [0; OCTANTS + 1];
    for i in 1..=OCTANTS {
        begins[i] = begins[i - 1] + counts[i - 1];
    }
    let mut items = vec![0; rays.len()];
    for (i, flight) in flights.iter().enumerate() {
        let at = &mut begins[usize::from(flight.octant)];
        items[*at] = i as u16;
        *at += 1;
    }
    let mut batch = Batch {
        runs,
        flights,
        waiting,
        count: 0,
        pairs,
        hits,
    };
    let step = steps / rays.len() as f32;
    let mut begin = 0;
    for (octant, &end) in begins[..OCTANTS].iter().enumerate() {
        let items = &items[begin..end];
        tree.walk_stream::<L>((octant, step), items, lists, &mut batch);
        begin = end;
    }
    batch.settle();
}

/// A ray under way.
#[repr(C, align(64))]
struct Flight<'a, S> {
    along: Along,
    sheared: ShearedRay,
    search: &'a mut S,
    octant: u8,
}

/// Rays on their way through the tree over triangles.
struct Batch<'a, S> {
    runs: &'a TriangleRuns,
    flights: Vec<Flight<'a, S>>,
    /// Pairs that wait for the exact test: from the lowest bit, 32 of the triangle's place, 8 of
    /// its stride, 16 of the ray.
    waiting: &'a mut Waiting,
    count: usize,
    pairs: &'a mut Pairs,
    hits: &'a mut PairHits,
}

type Waiting = [u64; WAIT + 8 * (VISIT + 2)];

/// What batches use one after the other: clearing it for each would take longer than a few rays do.
struct Scratch {
    lists: Lists,
    waiting: Waiting,
    pairs: Pairs,
    hits: PairHits,
}

thread_local! {
    static SCRATCH: Cell<Option<Box<Scratch>>> = const { Cell::new(None) };
}

impl Default for Scratch {
    fn default() -> Self {
        Self {
            lists: Lists::default(),
            waiting: [0; _],
            pairs: Pairs::new(),
            hits: PairHits::new(),
        }
    }
}

impl<S: Search> Batch<'_, S> {
    /// Meets the triangles of a leaf with eight rays at a time.
    #[inline(always)]
    fn visit_group<L: Lanes>(&mut self, items: &[u16; 8], first: u32, count: u32) {
        let ray = |i: usize| &self.flights[usize::from(items[i])].sheared;
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
        let eight = bvh::in_a_row(items);
        for lane in 0..count {
            let place = Place::new(first, count).after(lane);
            let found = self.runs.candidate_rays(&rays, place);
            let mask = found.mask;
            let mut hit = [0; 8];
            L::compress(eight, mask as usize, &mut hit);
            let pair = u64::from(count) << 32 | u64::from(place.at);
            if let Some(to) = self.waiting[self.count..].first_chunk_mut::<8>() {
                *to = hit.map(|item| u64::from(item) << 40 | pair);
            }
            self.count += mask.count_ones() as usize;
        }
    }

    /// Meets the triangles of a leaf at once with one ray at a time.
    #[inline(always)]
    fn visit_each<L: Lanes>(&mut self, items: &[u16], first: u32, count: u32) {
        if items.is_empty() {
            return;
        }
        let place = Place::new(first, count);
        let run = self.runs.run::<L>(first, count);
        for &item in items {
            let flight = &self.flights[usize::from(item)];
            let mask = run
                .candidates(&flight.sheared, flight.along.t_max() * S::LIMIT)
                .mask;
            let pair = u64::from(item) << 40 | u64::from(count) << 32 | u64::from(place.at);
            if let Some(to) = self.waiting[self.count..].first_chunk_mut::<8>() {
                *to = SET_BITS[mask as usize & 0xff].map(|lane| pair + u64::from(lane));
            }
            self.count += mask.count_ones() as usize;
        }
    }

    /// Tests all pairs that wait.
    #[inline(always)]
    fn settle(&mut self) {
        let runs = self.runs;
        for begin in (0..self.count).step_by(ROOM) {
            let pairs = &self.waiting[begin..self.count.min(begin + ROOM)];
            let parts = |pair: u64| {
                let count = (pair >> 32) as u32 & 0xff;
                (
                    (pair >> 40) as usize,
                    Place {
                        at: pair as u32,
                        count,
                    },
                )
            };
            for (k, &pair) in pairs.iter().enumerate() {
                let (i, place) = parts(pair);
                let flight = &self.flights[i];
                self.pairs.set(
                    k,
                    &flight.sheared,
                    runs,
                    place,
                    flight.along.t_max() * S::LIMIT,
                );
            }
            self.pairs.test(pairs.len(), self.hits);
            for (k, &pair) in pairs.iter().enumerate() {
                let (i, place) = parts(pair);
                let flight = &mut self.flights[i];
                if let Some(hit) = self
                    .hits
                    .get(k, &flight.sheared, || runs.triangle_at(place))
                {
                    let face = Face(runs.tag_at(place));
                    flight.search.offer(hit.t, face, [hit.b1, hit.b2]);
                    flight.along.set_t_max(flight.search.t_max());
                    flight.sheared.set_t_max(flight.search.t_max());
                }
            }
        }
        self.count = 0;
    }
}

impl<S: Search> Stream for Batch<'_, S> {
    #[inline(always)]
    fn along(&self, item: u16) -> &Along {
        &self.flights[usize::from(item)].along
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, items: &[u16], first: u32, count: u32) {
        for items in items.chunks(VISIT) {
            let (groups, rest) = items.as_chunks::<8>();
            for items in groups {
                self.visit_group::<L>(items, first, count);
            }
            self.visit_each::<L>(rest, first, count);
            if self.count >= WAIT {
                self.settle();
            }
        }
    }

    #[inline(always)]
    fn octant(&self, item: u16) -> Octant {
        usize::from(self.flights[usize::from(item)].octant) % OCTANTS
    }

    #[inline(always)]
    fn prefetch<L: Lanes>(&self, first: u32, count: u32) {
        self.runs.prefetch::<L>(first, count);
    }
}
