//! Pairs of a ray and a triangle that may be a hit, tested eight at a time.

use glam::Vec3;

use super::runs::{Place, TriangleRuns};
use super::triangle::{Exact, ShearedRay, TriangleHit, is_surely_ahead};

/// Most pairs.
pub(crate) const ROOM: usize = 128;

/// Pairs: the triangles' vertices and the rays, axes in the order of each ray.
pub(crate) struct Pairs {
    /// By vertex and axis.
    vertices: [[[f32; ROOM]; 3]; 3],
    origin: [[f32; ROOM]; 3],
    shear: [[f32; ROOM]; 3],
    t_max: [f32; ROOM],
}

/// What was found.
pub(crate) struct PairHits {
    t: [f32; ROOM],
    b1: [f32; ROOM],
    b2: [f32; ROOM],
    is_clear: [u32; ROOM],
}

impl Pairs {
    pub fn new() -> Self {
        Self {
            vertices: [[[0.0; ROOM]; 3]; 3],
            origin: [[0.0; ROOM]; 3],
            shear: [[0.0; ROOM]; 3],
            t_max: [0.0; ROOM],
        }
    }

    /// Puts a pair in its place.
    #[inline(always)]
    pub fn set(
        &mut self,
        i: usize,
        ray: &ShearedRay,
        runs: &TriangleRuns,
        place: Place,
        t_max: f32,
    ) {
        let i = i % ROOM;
        let (axes, origin, shear) = (ray.axes(), ray.origin(), ray.shears());
        for k in 0..3 {
            for v in 0..3 {
                self.vertices[v][k][i] = runs.coordinate(place, 3 * v + axes[k]);
            }
            self.origin[k][i] = origin[k];
            self.shear[k][i] = shear[k];
        }
        self.t_max[i] = t_max;
    }

    /// Tests them all, as [`ShearedRay::triangle`] does one.
    #[inline(always)]
    pub fn test(&self, count: usize, hits: &mut PairHits) {
        let count = count.next_multiple_of(8).min(ROOM);
        for i in 0..count {
            let vertex = |v: usize| {
                let from = |k: usize| self.vertices[v][k][i] - self.origin[k][i];
                let (x, y, z) = (from(0), from(1), from(2));
                [
                    x - self.shear[0][i] * z,
                    y - self.shear[1][i] * z,
                    self.shear[2][i] * z,
                ]
            };
            let exact = Exact::new(vertex(0), vertex(1), vertex(2), self.t_max[i]);
            (hits.t[i], hits.b1[i], hits.b2[i]) = (exact.hit.t, exact.hit.b1, exact.hit.b2);
            hits.is_clear[i] = u32::from(exact.is_clear);
        }
        // In a loop of its own, or the compiler makes neither wide.
        for i in 0..count {
            let wide = |v: &[[f32; ROOM]; 3]| [v[0][i].into(), v[1][i].into(), v[2][i].into()];
            let [a, b, c] = &self.vertices;
            let shear = [self.shear[0][i], self.shear[1][i], self.shear[2][i]];
            let is_ahead = is_surely_ahead([wide(a), wide(b), wide(c)], wide(&self.origin), shear);
            hits.is_clear[i] |= u32::from(is_ahead);
        }
    }
}

impl PairHits {
    pub fn new() -> Self {
        Self {
            t: [0.0; ROOM],
            b1: [0.0; ROOM],
            b2: [0.0; ROOM],
            is_clear: [0; ROOM],
        }
    }

    /// The hit of a pair; `triangle` is asked for where it is not clear.
    #[inline(always)]
    pub fn get(
        &self,
        i: usize,
        ray: &ShearedRay,
        triangle: impl FnOnce() -> [Vec3; 3],
    ) -> Option<TriangleHit> {
        let i = i % ROOM;
        let hit = TriangleHit {
            t: self.t[i],
            b1: self.b1[i],
            b2: self.b2[i],
        };
        (hit.t > 0.0 && (self.is_clear[i] != 0 || ray.meets_plane(triangle()))).then_some(hit)
    }
}
