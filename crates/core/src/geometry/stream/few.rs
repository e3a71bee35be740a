//! Many rays at few triangles, all there are or the sides of a room, and at few spheres.

use super::{Batch, Scratch, prepare_batch};
use crate::accel::bvh::{OCTANTS, Stream};
use crate::geometry::Primitives;
use crate::geometry::flights::RayGroup;
use crate::geometry::search::{Face, Search};
use crate::geometry::sides::{SIDES, Sides};
use crate::geometry::sweep::Sweep;
use crate::math::GROUP;
use crate::shape::TriangleRuns;
use crate::simd::Lanes;

/// Casts rays at all triangles but the sides.
#[inline(always)]
pub(super) fn sweep<L: Lanes, S: Search>(
    runs: &TriangleRuns,
    sweep: &Sweep,
    searches: &mut [S],
    scratch: &mut Scratch,
) {
    prepare_batch::<L>(sweep, searches.len(), scratch);
    let Scratch {
        flights,
        sorted,
        pairs,
        ..
    } = scratch;
    let mut batch = Batch::new(runs, flights, searches, pairs);
    for octant in 0..OCTANTS {
        for (first, count) in sweep.runs() {
            for place in 0..count {
                batch.visit_one::<L>(sorted.items(octant), first, count, place);
            }
        }
    }
    batch.settle();
}

/// Casts rays at all spheres.
#[inline(always)]
pub(super) fn cast_at_spheres<S: Search>(
    primitives: &Primitives,
    searches: &mut [S],
    rays: &[RayGroup],
) {
    for (id, sphere) in (primitives.first_sphere()..).zip(&primitives.spheres) {
        for (searches, rays) in searches.chunks_mut(GROUP).zip(rays) {
            let mut distances = [0.0; GROUP];
            for (i, distance) in distances.iter_mut().enumerate() {
                *distance = sphere.distance(&rays.get(i));
            }
            for (search, t) in searches.iter_mut().zip(distances) {
                search.tests(1);
                if t > 0.0 && t <= search.limit() {
                    search.offer(t, Face::of(id), [0.0; 2]);
                }
            }
        }
    }
}

/// Casts rays that have been through a tree at the sides, if these matter to them.
#[inline(always)]
pub(super) fn cast_at_sides<L: Lanes, S: Search>(
    sides: &Sides,
    searches: &mut [S],
    scratch: &mut Scratch,
) {
    // Six columns, one for each side: not 0 where it matters to a ray.
    let Scratch {
        columns: [matter, _],
        rays,
        flights,
        sorted,
        pairs,
        ..
    } = scratch;
    sorted.clear();
    let some = || (0..SIDES).filter(|side| sides.parts[*side].1 > 0);
    for (k, (searches, rays)) in searches.chunks(GROUP).zip(rays.iter()).enumerate() {
        // Nothing matters to those that there are not, or that have found what they were cast for.
        let (mut t_max, mut except) = ([f32::NEG_INFINITY; GROUP], [0; GROUP]);
        for (i, search) in searches.iter().enumerate() {
            (t_max[i], except[i]) = (search.t_max(), search.except());
        }
        let mut stay = true;
        for (i, t_max) in t_max.iter().enumerate() {
            stay &= sides.hold(&rays.get(i), *t_max);
        }
        if stay {
            continue;
        }
        for i in 0..GROUP {
            let [a, b, c, d, e, f] = sides.matter(&rays.get(i), t_max[i], except[i]);
            let number = |matters| if matters { t_max[i] } else { 0.0 };
            (matter[0][i], matter[1][i], matter[2][i]) = (number(a), number(b), number(c));
            (matter[3][i], matter[4][i], matter[5][i]) = (number(d), number(e), number(f));
        }
        for side in some() {
            for (j, eight) in matter[side].as_chunks().0.iter().enumerate() {
                let mask = L::splat(0.0).lt(L::load(eight));
                sorted.put::<L>(side, k * GROUP + 8 * j, mask);
            }
        }
    }
    let mut batch = Batch::new(&sides.runs, flights, searches, pairs);
    for side in some() {
        let (first, count) = sides.parts[side];
        for place in 0..count {
            batch.visit_one::<L>(sorted.items(side), first, count, place);
        }
    }
    batch.settle();
}
