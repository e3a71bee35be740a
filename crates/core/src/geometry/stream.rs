//! Casting many rays in one call: the same hits as one by one, sooner.

use std::array::from_fn;
use std::ops::Range;

use super::cast::{Accel, Geometry, Triangles};
use super::search::{Any, Face, Nearest, Search, offer_triangle, reach};
use super::{Hit, Primitives};
use crate::accel::Bvh;
use crate::accel::bvh::{Leaves, Packet, SLOTS, Stream};
use crate::math::Ray;
use crate::shape::{Apart, ShearedRay, ShearedRays};
use crate::simd::{Lanes, Task};

/// Rays in a packet.
const PACKET: usize = 16;

/// From so many triangles on, rays that do not run together are cast in turns rather than one
/// after the other: the tree no longer fits the nearest caches (measured: docs/ray-casting.md).
const STREAM_FROM: u32 = 50_000;

impl Geometry {
    /// [`Geometry::intersect`] for rays 0 to `count` − 1, in no particular order: `ray(i)` gives a
    /// ray, `found(i, hit)` receives what it hits.
    #[inline]
    pub fn intersect_many(
        &self,
        count: usize,
        ray: impl Fn(usize) -> Ray,
        is_emitter: impl Fn(u32) -> bool + Copy,
        mut found: impl FnMut(usize, Option<Hit>),
    ) {
        let start = |i: usize| {
            let ray = ray(i);
            let nearest = Nearest {
                is_emitter,
                t_max: reach(&ray),
                face: Face::NONE,
                b: [0.0; 2],
            };
            (ray, nearest)
        };
        self.search_many(count, start, |i, nearest: &Nearest<_>, primitives| {
            found(i, nearest.hit(primitives));
        });
    }

    /// [`Geometry::occluded`] for rays 0 to `count` − 1, in no particular order: `ray(i)` gives a
    /// ray and the primitive that does not shade it, `found(i, occluded)` receives the answer.
    #[inline]
    pub fn occluded_many(
        &self,
        count: usize,
        ray: impl Fn(usize) -> (Ray, u32),
        mut found: impl FnMut(usize, bool),
    ) {
        let start = |i: usize| {
            let (ray, except) = ray(i);
            let any = Any {
                except,
                t_max: reach(&ray),
            };
            (ray, any)
        };
        self.search_many(count, start, |i, any: &Any, _| found(i, any.found()));
    }

    #[inline(always)]
    fn search_many<S: Search>(
        &self,
        count: usize,
        start: impl Fn(usize) -> (Ray, S),
        done: impl FnMut(usize, &S, &Primitives),
    ) {
        self.kernel.run(CastMany {
            geometry: self,
            count,
            start,
            done,
        });
    }
}

/// Many rays, for a kernel.
struct CastMany<'a, F, D> {
    geometry: &'a Geometry,
    count: usize,
    start: F,
    done: D,
}

impl<S, F, D> Task for CastMany<'_, F, D>
where
    S: Search,
    F: Fn(usize) -> (Ray, S),
    D: FnMut(usize, &S, &Primitives),
{
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self {
            geometry,
            count,
            start,
            mut done,
        } = self;
        if let Accel::Bvh {
            triangles,
            tree,
            spheres,
        } = &geometry.accel
        {
            let mut many = Many {
                geometry,
                triangles,
                tree,
                spheres: spheres.as_ref(),
                start,
                done,
            };
            many.cast::<L>(count);
            return;
        }
        for i in 0..count {
            let (ray, mut search) = start(i);
            geometry.search_with::<L>(&ray, &mut search);
            done(i, &search, &geometry.primitives);
        }
    }
}

/// Rays to cast through the tree over triangles.
struct Many<'a, F, D> {
    geometry: &'a Geometry,
    triangles: &'a Triangles,
    tree: &'a Bvh,
    spheres: Option<&'a (Bvh, Vec<u32>)>,
    start: F,
    done: D,
}

impl<S, F, D> Many<'_, F, D>
where
    S: Search,
    F: Fn(usize) -> (Ray, S),
    D: FnMut(usize, &S, &Primitives),
{
    /// Casts rays that run close together as packets, all others in turn.
    #[inline(always)]
    fn cast<L: Lanes>(&mut self, count: usize) {
        let (mut first, mut begin) = (0, 0);
        while first < count {
            let is_last = begin + PACKET > count;
            let is_packet = !is_last && self.cast_packet::<L>(begin);
            if is_packet || is_last {
                self.cast_others::<L>(first..if is_packet { begin } else { count });
                first = if is_packet { begin + PACKET } else { count };
            }
            begin += PACKET;
        }
    }

    #[inline(always)]
    fn cast_others<L: Lanes>(&mut self, rays: Range<usize>) {
        if self.triangles.count < STREAM_FROM {
            for i in rays {
                let (ray, mut search) = (self.start)(i);
                let sheared = ShearedRay::new(&ray);
                self.triangles
                    .search::<L>(self.tree, &ray, &sheared, &mut search);
                self.geometry
                    .search_spheres(self.spheres, &ray, &mut search);
                (self.done)(i, &search, &self.geometry.primitives);
            }
        } else if !rays.is_empty() {
            self.tree.walk_many::<L>(&mut Batch {
                geometry: self.geometry,
                triangles: self.triangles,
                spheres: self.spheres,
                rays,
                start: &self.start,
                done: &mut self.done,
                slots: [const { None }; SLOTS],
                candidates: [Waiting::default(); SLOTS],
                waiting: 0,
            });
        }
    }

    /// Casts rays from `begin` on as one packet, if they run close together.
    #[inline(always)]
    fn cast_packet<L: Lanes>(&mut self, begin: usize) -> bool {
        let rays: [Ray; PACKET] = from_fn(|i| (self.start)(begin + i).0);
        let Some(packet) = Packet::new(self.tree, &rays) else {
            return false;
        };
        let sheared: [ShearedRay; PACKET] = from_fn(|i| ShearedRay::new(&rays[i]));
        let (groups, _) = sheared.as_chunks();
        let mut leaves = PacketLeaves {
            triangles: self.triangles,
            rays: [ShearedRays::default(); PACKET / 8],
            searches: from_fn(|i| (self.start)(begin + i).1),
            limits: [[0.0; 8]; PACKET / 8],
        };
        for (to, group) in leaves.rays.iter_mut().zip(groups) {
            match ShearedRays::new(group) {
                Some(rays) => *to = rays,
                None => return false,
            }
        }
        for (i, search) in leaves.searches.iter().enumerate() {
            leaves.limits[i / 8][i % 8] = search.limit();
        }
        self.tree.walk_packet::<L>(&packet, &mut leaves);
        for (i, (ray, mut search)) in rays.iter().zip(leaves.searches).enumerate() {
            self.geometry.search_spheres(self.spheres, ray, &mut search);
            (self.done)(begin + i, &search, &self.geometry.primitives);
        }
        true
    }
}

/// The leaves before a packet.
struct PacketLeaves<'a, S> {
    triangles: &'a Triangles,
    rays: [ShearedRays; PACKET / 8],
    searches: [S; PACKET],
    /// Each search's limit.
    limits: [[f32; 8]; PACKET / 8],
}

impl<S: Search> Leaves for PacketLeaves<'_, S> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, first: u32, count: u32, mut t_max: f32) -> f32 {
        let runs = &self.triangles.runs;
        let mut hit_any = false;
        for lane in 0..count {
            for (group, rays) in self.rays.iter().enumerate() {
                let limits = &mut self.limits[group];
                let found = runs.candidate_rays::<L>(rays, first, count, lane, limits);
                let mut mask = found.mask;
                if mask == 0 {
                    continue;
                }
                let pairs = found.apart();
                let face = Face(runs.tag(first, count, lane));
                while mask != 0 {
                    let i = mask.trailing_zeros();
                    mask &= mask - 1;
                    let search = &mut self.searches[8 * group + i as usize % 8];
                    let at = (first, count, lane);
                    let hit = runs.hit((&pairs, i), || rays.get(i), at, search.limit());
                    offer_triangle(hit, face, search);
                    limits[i as usize % 8] = search.limit();
                }
                hit_any = true;
            }
        }
        if hit_any {
            t_max = f32::NEG_INFINITY;
            for search in &self.searches {
                t_max = t_max.max(search.t_max());
            }
        }
        t_max
    }
}

/// A ray under way.
struct Slot<S> {
    index: usize,
    ray: Ray,
    sheared: ShearedRay,
    search: S,
}

/// Triangles that a ray may hit, waiting for the exact test.
#[derive(Clone, Copy, Default)]
struct Waiting {
    slot: u8,
    mask: u32,
    first: u32,
    count: u32,
    triangles: Apart,
}

/// Rays on their way through the tree over triangles.
struct Batch<'a, S, F, D> {
    geometry: &'a Geometry,
    triangles: &'a Triangles,
    spheres: Option<&'a (Bvh, Vec<u32>)>,
    /// Those that have not started.
    rays: Range<usize>,
    start: &'a F,
    done: &'a mut D,
    slots: [Option<Slot<S>>; SLOTS],
    candidates: [Waiting; SLOTS],
    waiting: usize,
}

impl<S, F, D> Stream for Batch<'_, S, F, D>
where
    S: Search,
    F: Fn(usize) -> (Ray, S),
    D: FnMut(usize, &S, &Primitives),
{
    #[inline(always)]
    fn start(&mut self, slot: usize) -> Option<Ray> {
        let index = self.rays.next()?;
        let (ray, search) = (self.start)(index);
        self.slots[slot % SLOTS] = Some(Slot {
            index,
            ray,
            sheared: ShearedRay::new(&ray),
            search,
        });
        Some(ray)
    }

    #[inline(always)]
    fn test<L: Lanes>(&mut self, slot: usize, first: u32, count: u32) {
        let Some(Slot {
            sheared, search, ..
        }) = &self.slots[slot % SLOTS]
        else {
            return;
        };
        let runs = &self.triangles.runs;
        let found = runs.candidates::<L>(sheared, first, count, search.limit());
        // Kept only if the number goes up.
        let waiting = &mut self.candidates[self.waiting % SLOTS];
        (waiting.slot, waiting.mask) = (slot as u8, found.mask);
        (waiting.first, waiting.count) = (first, count);
        waiting.triangles = found.apart();
        self.waiting += usize::from(found.mask != 0);
    }

    #[inline(always)]
    fn prefetch<L: Lanes>(&self, first: u32, count: u32) {
        self.triangles.runs.prefetch::<L>(first, count);
    }

    #[inline(always)]
    fn settle(&mut self) {
        for waiting in &self.candidates[..self.waiting] {
            let Some(Slot {
                sheared, search, ..
            }) = &mut self.slots[usize::from(waiting.slot) % SLOTS]
            else {
                continue;
            };
            let mut mask = waiting.mask;
            while mask != 0 {
                let lane = mask.trailing_zeros();
                mask &= mask - 1;
                let runs = &self.triangles.runs;
                let at = (waiting.first, waiting.count, lane);
                let hit = runs.hit((&waiting.triangles, lane), || *sheared, at, search.limit());
                let tag = runs.tag(waiting.first, waiting.count, lane);
                offer_triangle(hit, Face(tag), search);
            }
        }
        self.waiting = 0;
    }

    #[inline(always)]
    fn t_max(&self, slot: usize) -> f32 {
        match &self.slots[slot % SLOTS] {
            Some(slot) => slot.search.t_max(),
            None => f32::NEG_INFINITY,
        }
    }

    #[inline(always)]
    fn finish(&mut self, slot: usize) {
        let Some(slot) = &mut self.slots[slot % SLOTS] else {
            return;
        };
        self.geometry
            .search_spheres(self.spheres, &slot.ray, &mut slot.search);
        (self.done)(slot.index, &slot.search, &self.geometry.primitives);
    }
}
