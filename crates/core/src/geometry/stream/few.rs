//! Many rays at few triangles: all there are, or the sides of a room.

use super::{Batch, Scratch, prepare_batch};
use crate::accel::bvh::{OCTANTS, Stream};
use crate::geometry::search::Search;
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
