//! Many rays side by side, and what a walk through the tree wants of each of them.

use glam::Vec3;

use crate::accel::Tree;
use crate::accel::bvh::{Along, Sorted};
use crate::math::{Floats, GROUP, Ray};
use crate::shape::ShearedRay;
use crate::simd::Lanes;

/// Rays, number by number: three of the origin, three of the direction, and how far they go.
#[derive(Clone, Copy)]
pub(super) struct RayGroup([Floats; 7]);

impl Default for RayGroup {
    fn default() -> Self {
        Self([[0.0; GROUP]; 7])
    }
}

impl RayGroup {
    /// A ray, as a loop over all of them reads it.
    #[inline(always)]
    pub fn get(&self, i: usize) -> Ray {
        let [ox, oy, oz, dx, dy, dz, t_max] = &self.0;
        Ray {
            origin: Vec3::new(ox[i], oy[i], oz[i]),
            dir: Vec3::new(dx[i], dy[i], dz[i]),
            t_max: t_max[i],
        }
    }

    /// Sets a ray but for how far it goes.
    #[inline(always)]
    pub fn set(&mut self, i: usize, ray: &Ray, t_max: f32) {
        for axis in 0..3 {
            self.0[axis][i] = ray.origin[axis];
            self.0[3 + axis][i] = ray.dir[axis];
        }
        self.0[6][i] = t_max;
    }
}

/// A ray under way.
#[derive(Clone, Copy, Default)]
#[repr(C, align(64))]
pub(super) struct Flight {
    pub along: Along,
    pub sheared: ShearedRay,
}

impl Flight {
    /// Both parts are asked how far the ray goes.
    #[inline(always)]
    pub fn set_t_max(&mut self, t_max: f32) {
        self.along.set_t_max(t_max);
        self.sheared.set_t_max(t_max);
    }
}

impl RayGroup {
    /// Prepares all rays, and lists the first `count` of them by octant, counted from `first`.
    #[inline(always)]
    pub fn prepare<L: Lanes>(
        &self,
        tree: &impl Tree,
        (first, count): (usize, usize),
        [along, sheared]: &mut [[Floats; 8]; 2],
        flights: &mut [Flight; GROUP],
        sorted: &mut Sorted,
    ) {
        let mut is_met = [0.0; GROUP];
        // Eight stores in a row, and two loops, or the compiler makes none of it wide.
        for i in 0..GROUP {
            let (ray, met) = tree.along(&self.get(i));
            is_met[i] = if met & (i < count) { 1.0 } else { 0.0 };
            let to = &mut *along;
            let [a, b, c, d, e, f, g, h] = ray.0;
            (to[0][i], to[1][i], to[2][i], to[3][i]) = (a, b, c, d);
            (to[4][i], to[5][i], to[6][i], to[7][i]) = (e, f, g, h);
        }
        for i in 0..GROUP {
            let to = &mut *sheared;
            let [a, b, c, d, e, f, g, h] = ShearedRay::new(&self.get(i)).0;
            (to[0][i], to[1][i], to[2][i], to[3][i]) = (a, b, c, d);
            (to[4][i], to[5][i], to[6][i], to[7][i]) = (e, f, g, h);
        }
        let (flights, _) = flights.as_chunks_mut::<8>();
        for (k, flights) in flights.iter_mut().enumerate() {
            sorted.by_octant::<L>(first + 8 * k, &eight(along, k), &is_met.as_chunks().0[k]);
            let (along, sheared) = (
                L::transpose(eight(along, k)),
                L::transpose(eight(sheared, k)),
            );
            for (i, flight) in flights.iter_mut().enumerate() {
                flight.along.0 = along[i].store();
                flight.sheared.0 = sheared[i].store();
            }
        }
    }
}

/// Eight numbers of each column.
#[inline(always)]
fn eight(columns: &[Floats; 8], k: usize) -> [&[f32; 8]; 8] {
    let [a, b, c, d, e, f, g, h] = columns;
    [
        &a.as_chunks().0[k],
        &b.as_chunks().0[k],
        &c.as_chunks().0[k],
        &d.as_chunks().0[k],
        &e.as_chunks().0[k],
        &f.as_chunks().0[k],
        &g.as_chunks().0[k],
        &h.as_chunks().0[k],
    ]
}
