//! Pairs of a ray and a triangle that may be a hit, gathered until they are tested side by side.

use super::candidates::Candidates;
use super::triangle::{Exact, TriangleHit};
use crate::simd::Lanes;

/// So many pairs are worth a test.
const ENOUGH: usize = 16;

/// Most pairs that are added before [`Pairs::are_enough`] is asked again: eight rays and eight triangles.
const MORE: usize = 64;

/// The last may be written with seven that mean nothing behind it.
const ROOM: usize = ENOUGH + MORE + 16;

/// Pairs, each with a name of the caller's.
pub(crate) struct Pairs {
    names: [u64; ROOM],
    /// In the rays' coordinates, by vertex and axis.
    vertices: [[[f32; ROOM]; 3]; 3],
    count: usize,
    /// What the test found.
    t: [f32; ROOM],
    b1: [f32; ROOM],
    b2: [f32; ROOM],
    is_clear: [u32; ROOM],
}

impl Default for Pairs {
    fn default() -> Self {
        Self {
            names: [0; ROOM],
            vertices: [[[0.0; ROOM]; 3]; 3],
            count: 0,
            t: [0.0; ROOM],
            b1: [0.0; ROOM],
            b2: [0.0; ROOM],
            is_clear: [0; ROOM],
        }
    }
}

impl Pairs {
    /// How many.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count.min(ROOM)
    }

    /// Whether they should be tested.
    #[inline(always)]
    pub fn are_enough(&self) -> bool {
        self.count >= ENOUGH
    }

    /// Takes all out.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds candidates, named in their order.
    #[inline(always)]
    pub fn add<L: Lanes>(&mut self, candidates: &Candidates<L>, names: [u64; 8]) {
        let at = self.count;
        let [a, b, c] = candidates.front();
        for (vertex, to) in [a, b, c].iter().zip(&mut self.vertices) {
            for axis in 0..3 {
                if let Some(to) = to[axis][at..].first_chunk_mut() {
                    *to = vertex[axis].store();
                }
            }
        }
        if let Some(to) = self.names[at..].first_chunk_mut() {
            *to = names;
        }
        self.count += candidates.mask.count_ones() as usize;
    }

    /// Tests them all, as [`super::ShearedRay::triangle`] does one.
    #[inline(always)]
    pub fn test(&mut self) {
        let count = self.count.next_multiple_of(8).min(ROOM);
        for i in 0..count {
            let [a, b, c] = &self.vertices;
            let exact = Exact::new(
                [a[0][i], a[1][i], a[2][i]],
                [b[0][i], b[1][i], b[2][i]],
                [c[0][i], c[1][i], c[2][i]],
                f32::INFINITY,
            );
            (self.t[i], self.b1[i], self.b2[i]) = (exact.hit.t, exact.hit.b1, exact.hit.b2);
            self.is_clear[i] = u32::from(exact.is_clear);
        }
    }

    /// A pair's name, what the test found, and whether that is clear without asking
    /// [`super::ShearedRay::meets_plane`].
    #[inline(always)]
    pub fn found(&self, i: usize) -> (u64, TriangleHit, bool) {
        let hit = TriangleHit {
            t: self.t[i],
            b1: self.b1[i],
            b2: self.b2[i],
        };
        (self.names[i], hit, self.is_clear[i] != 0)
    }
}
