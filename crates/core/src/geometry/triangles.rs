//! The triangles of a scene, kept once: listed until the accelerator is built, then in the runs that
//! rays are cast at.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::Vec3;
use rayon::prelude::*;

use super::search::Face;
use crate::accel::bvh::Ordered;
use crate::shape::{Quad, RunId, TriangleRuns};
use crate::simd::prefetch;

/// Triangles by id.
#[derive(Debug, Default)]
pub struct Triangles {
    /// As they were listed; empty once they are in runs.
    list: Vec<[Vec3; 3]>,
    /// These, and each quad as two; the tag of one is its [`Face`].
    runs: TriangleRuns,
    /// By id: its run, a [`RunId`].
    places: Vec<u32>,
}

impl Triangles {
    /// How many.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.list.len().max(self.places.len())
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A triangle's vertices, counter-clockwise on the front.
    #[inline(always)]
    pub(crate) fn get(&self, id: usize) -> Option<[Vec3; 3]> {
        match self.places.get(id) {
            Some(run) => {
                let run = RunId::from_bits(*run);
                let place = self.runs.find(run, Face::of(id as u32).0);
                Some(self.runs.triangle_at(place))
            }
            None => self.list.get(id).copied(),
        }
    }

    /// All of them, in the order of ids.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = [Vec3; 3]> {
        (0..self.len()).map(|id| self.get(id).unwrap_or_default())
    }

    /// Puts another behind those that are listed.
    pub fn push(&mut self, triangle: [Vec3; 3]) {
        self.list.push(triangle);
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.list) + self.runs.bytes() + size_of_val(&*self.places)
    }

    /// The runs; none before [`Self::lay_out`].
    #[inline(always)]
    pub(super) fn runs(&self) -> &TriangleRuns {
        &self.runs
    }

    /// The triangles as they were listed, by number, and behind them the two of each quad.
    #[inline(always)]
    pub(super) fn face(&self, quads: &[Quad], number: u32) -> ([Vec3; 3], Face) {
        let i = number as usize;
        if let Some(triangle) = self.list.get(i) {
            return (*triangle, Face::of(number));
        }
        let half = i - self.list.len();
        let first = Face::of((self.list.len() + half / 2) as u32);
        let triangle = quads[half / 2].triangles()[half % 2];
        (triangle, Face(first.0 + (half % 2) as u32))
    }

    /// Moves them, and the two of each quad, into runs in some memory; `order` counts them as [`Self::face`] does.
    /// What is not in it, as nothing hits it, comes behind.
    pub(super) fn lay_out(&mut self, quads: &[Quad], memory: Vec<f32>, mut order: Vec<Ordered>) {
        let count = self.list.len();
        if order.len() < count + 2 * quads.len() {
            let mut is_in = vec![false; count + 2 * quads.len()];
            order.iter().for_each(|i| is_in[i.id() as usize] = true);
            let others = (0..count as u32).filter(|i| !is_in[*i as usize]);
            order.extend(others.map(|i| Ordered::new(i, true)));
        }
        let none = |_| AtomicU32::new(0);
        let places: Vec<AtomicU32> = (0..count).into_par_iter().map(none).collect();
        self.runs = TriangleRuns::new(
            memory,
            &order,
            |i| i.begins(),
            |i| {
                let (triangle, face) = self.face(quads, i.id());
                (triangle, face.0)
            },
            |i| {
                if let Some(triangle) = self.list.get(i.id() as usize) {
                    prefetch(triangle);
                }
            },
            |i, run| {
                if let Some(place) = places.get(i.id() as usize) {
                    place.store(run.to_bits(), Ordering::Relaxed);
                }
            },
        );
        self.list = Vec::new();
        self.places = places.into_iter().map(AtomicU32::into_inner).collect();
    }
}

impl From<Vec<[Vec3; 3]>> for Triangles {
    fn from(list: Vec<[Vec3; 3]>) -> Self {
        Self {
            list,
            ..Self::default()
        }
    }
}

impl Extend<[Vec3; 3]> for Triangles {
    fn extend<T: IntoIterator<Item = [Vec3; 3]>>(&mut self, triangles: T) {
        self.list.extend(triangles);
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::accel::Progress;
    use crate::geometry::{Geometry, Primitive, Primitives};
    use crate::math::Ray;
    use crate::scene::boulder;
    use crate::settings::AccelKind;

    fn listed() -> Vec<[Vec3; 3]> {
        let (positions, triangles) = boulder(20_000);
        let corners = |t: &[u32; 3]| t.map(|v| positions[v as usize]);
        triangles.iter().map(corners).collect()
    }

    #[test]
    fn frozen_triangles_are_those_that_were_listed() {
        let mut list = listed();
        // Hit by nothing, and so in no tree.
        for hole in [0, 7, 4711, list.len() - 1] {
            list[hole] = [Vec3::NAN, Vec3::splat(hole as f32), Vec3::NAN];
        }
        list[8] = [Vec3::NAN; 3];
        let bits = |t: [Vec3; 3]| t.map(|v| v.to_array().map(f32::to_bits));
        for count in [0, 1, 9, 20, 300, list.len()] {
            for accel in AccelKind::ALL {
                let mut primitives = Primitives {
                    triangles: list[..count].to_vec().into(),
                    ..Primitives::default()
                };
                for [a, b, c] in &list[9..count.clamp(9, 30)] {
                    let quad = Quad::new([*a, *b, *b + (*c - *a), *c]);
                    primitives.quads.push(quad);
                }
                let quads = primitives.quads.clone();
                let geometry = Geometry::build(primitives, *accel);
                let frozen = geometry.primitives();
                assert_eq!(frozen.triangles.len(), count);
                assert_eq!(frozen.len(), count + quads.len());
                assert!(
                    frozen
                        .triangles
                        .iter()
                        .map(bits)
                        .eq(list[..count].iter().copied().map(bits))
                );
                for (i, quad) in quads.iter().enumerate() {
                    match frozen.get((count + i) as u32) {
                        Primitive::Quad(found) => assert_eq!(found.corners(), quad.corners()),
                        other => panic!("{other:?}"),
                    }
                }
            }
        }
    }

    #[test]
    fn builds_that_are_ended_are_harmless() {
        let list = listed();
        let ray = Ray::new(Vec3::new(0.0, 3.0, 0.0), Vec3::NEG_Y);
        for accel in [AccelKind::Bvh, AccelKind::KdTree] {
            for last in [0, 20, 60, 101] {
                let report = |percent| match percent < last {
                    true => ControlFlow::Continue(()),
                    false => ControlFlow::Break(()),
                };
                let primitives = Primitives {
                    triangles: list.clone().into(),
                    ..Primitives::default()
                };
                let geometry = Geometry::build_watched(primitives, accel, &Progress::new(&report));
                let rays = geometry.intersect(&ray, |_| false).is_some();
                let mut many = 0;
                let found = |_, hit: Option<_>| many += usize::from(hit.is_some());
                geometry.intersect_many(&[ray; 200], |ray| *ray, |_| false, found);
                if last > 100 {
                    assert!(rays && many == 200, "{accel}");
                }
                assert!(
                    geometry
                        .primitives()
                        .triangles
                        .iter()
                        .eq(list.iter().copied())
                );
            }
        }
    }

    #[test]
    fn a_triangle_takes_64_bytes_with_its_share_of_the_tree() {
        let primitives = Primitives {
            triangles: listed().into(),
            ..Primitives::default()
        };
        let geometry = Geometry::build(primitives, AccelKind::Bvh);
        let triangles = &geometry.primitives().triangles;
        let bytes = geometry.accel_bytes() + triangles.bytes();
        assert!(bytes <= 64 * triangles.len(), "{bytes} bytes");
    }
}
