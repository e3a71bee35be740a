//! What a ray is cast for: the nearest hit or any, made of the hits of single primitives in
//! whatever order they come.

use super::{Hit, Primitives};
use crate::math::Ray;
use crate::shape::TriangleHit;

/// Relative distance within which an emitter wins against a surface in the same place, and the end of a segment is not
/// shaded by one.
pub(super) const NUDGE: f32 = 1.0 / (1 << 20) as f32;

/// A triangle, one of the two of a quad, or a sphere, in 32 bits: 2 · id, and 1 more for a
/// quad's second triangle. Faces are ordered as their ids are.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Face(pub u32);

impl Face {
    /// Later than any face.
    pub const NONE: Self = Self(u32::MAX);

    /// All of a primitive, or a quad's first triangle.
    #[inline(always)]
    pub fn of(id: u32) -> Self {
        Self(2 * id)
    }

    #[inline(always)]
    pub fn id(self) -> u32 {
        self.0 >> 1
    }
}

#[inline(always)]
pub(super) fn offer_triangle(hit: Option<TriangleHit>, face: Face, search: &mut impl Search) {
    if let Some(hit) = hit {
        search.offer(hit.t, face, [hit.b1, hit.b2]);
    }
}

/// What a ray is cast for.
pub(super) trait Search {
    /// What begins beyond this distance can be left out; −∞ when there is nothing left to find.
    fn t_max(&self) -> f32;
    /// Hits beyond `t_max` times this need not be offered.
    const LIMIT: f32;
    /// Hits beyond this distance need not be offered.
    #[inline(always)]
    fn limit(&self) -> f32 {
        self.t_max() * Self::LIMIT
    }
    /// The primitive whose hits do not count, if any.
    #[inline(always)]
    fn except(&self) -> u32 {
        u32::MAX
    }
    /// Takes note of a hit; `b` are a triangle's second and third barycentric.
    fn offer(&mut self, t: f32, face: Face, b: [f32; 2]);
    /// Told of each inner node of a tree that is visited; only those that count listen.
    #[inline(always)]
    fn node(&mut self) {}
    /// Told how many triangles and spheres are tested next; a quad is two triangles.
    #[inline(always)]
    fn tests(&mut self, _: u32) {}
}

/// How far a ray is followed at first: a finite distance, or NaN. Arithmetic beyond the range of f32
/// can give an infinite one, which is no hit; minus infinity is the sign of a finished search.
#[inline(always)]
pub(super) fn reach(ray: &Ray) -> f32 {
    ray.t_max.clamp(f32::MIN, f32::MAX)
}

/// The nearest hit.
pub(super) struct Nearest<E> {
    pub is_emitter: E,
    pub t_max: f32,
    pub face: Face,
    pub b: [f32; 2],
}

impl<E: Fn(u32) -> bool> Search for Nearest<E> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    /// Further, for emitters that are then counted as nearer.
    const LIMIT: f32 = 1.0 + 2.0 * NUDGE;

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
    pub fn hit(&self, primitives: &Primitives) -> Option<Hit> {
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
pub(super) struct Any {
    pub except: u32,
    /// −∞ once there is one.
    pub t_max: f32,
}

impl Any {
    #[inline(always)]
    pub fn found(&self) -> bool {
        self.t_max == f32::NEG_INFINITY
    }
}

impl Search for Any {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    const LIMIT: f32 = 1.0;

    #[inline(always)]
    fn except(&self) -> u32 {
        self.except
    }

    #[inline(always)]
    fn offer(&mut self, _: f32, face: Face, _: [f32; 2]) {
        if face.id() != self.except {
            self.t_max = f32::NEG_INFINITY;
        }
    }
}
