//! What the builder of the wide tree makes of every kind of input.

use glam::Vec3;

use super::*;
use crate::accel::Progress;
use crate::accel::test::{Rng, bumpy_sphere, needles};
use crate::simd::Kernel;

fn build(boxes: &[Aabb]) -> Built {
    Bvh::build(boxes.len(), |id| boxes[id as usize])
}

/// Every node and leaf reached once, boxes inside their parents' as far as rounding goes, depths
/// within the stack, every primitive listed once and inside its leaf's box.
pub fn validate(built: &Built, bounds: &[Aabb]) {
    let Built { tree, order } = built;
    let (mut nodes, mut listed) = (0, vec![false; bounds.len()]);
    let error = 4.0 * f32::EPSILON * tree.bounds.min.abs().max(tree.bounds.max.abs());
    tree.for_each(|link, cell, depth| {
        let Some(index) = link.inner() else {
            let (first, count) = link.leaf();
            for (i, place) in order[first as usize..][..count as usize].iter().enumerate() {
                assert_eq!(place.begins(), i == 0);
                let id = place.id();
                assert!(!std::mem::replace(&mut listed[id as usize], true), "twice");
                let b = bounds[id as usize];
                // A corner is computed here with roundings that the tree does without.
                assert!(!(cell.min - error).cmpgt(b.min).any(), "{cell:?} {b:?}");
                assert!(!(cell.max + error).cmplt(b.max).any(), "{cell:?} {b:?}");
            }
            return;
        };
        nodes += 1;
        assert!(depth < MAX_DEPTH && (index as usize) < tree.nodes.len());
    });
    assert_eq!(nodes, tree.nodes.len());
    for (id, b) in bounds.iter().enumerate() {
        assert_eq!(listed[id], !b.is_empty(), "primitive {id}");
    }
}

impl Bvh {
    /// The box of every node and leaf, and how many primitives a leaf has.
    pub(crate) fn boxes(&self) -> Vec<(Aabb, Option<u32>)> {
        let mut boxes = Vec::new();
        self.for_each(|link, bounds, _| {
            let count = link.inner().is_none().then(|| link.leaf().1);
            boxes.push((*bounds, count));
        });
        boxes
    }
}

#[test]
fn k01_every_small_number_and_empty_boxes() {
    let mut rng = Rng(1);
    for n in 0..40 {
        let triangles = rng.soup(n, 0.5);
        let mut boxes: Vec<Aabb> = triangles.iter().map(|t| Aabb::of_points(*t)).collect();
        validate(&build(&boxes), &boxes);
        boxes.iter_mut().step_by(3).for_each(|b| *b = Aabb::EMPTY);
        validate(&build(&boxes), &boxes);
    }
}

#[test]
fn k05_boxes_of_random_bits_neither_hang_nor_panic() {
    let mut rng = Rng(16);
    for _ in 0..300 {
        let mut vertex = || Vec3::from_array([0; 3].map(|_| f32::from_bits(rng.bits())));
        let boxes: Vec<Aabb> = (0..50)
            .map(|_| Aabb::of_points([vertex(), vertex(), vertex()]))
            .collect();
        validate(&build(&boxes), &boxes);
    }
}

#[test]
fn v08_clusters_and_copies_stay_within_the_stack() {
    let mut boxes = Vec::new();
    for i in 0..300 {
        let corner = Vec3::splat(0.5f32.powi(i % 140));
        boxes.push(Aabb::of_points([corner, corner * 1.25]));
    }
    validate(&build(&boxes), &boxes);
    // Nested, so that each split takes one away.
    let nested: Vec<Aabb> = (1..3000)
        .map(|i| Aabb::of_points([Vec3::ZERO, Vec3::new(1.07f32.powi(i % 1200), 1.0, 1.0)]))
        .collect();
    validate(&build(&nested), &nested);
    let copies = vec![boxes[0]; 100_000];
    let built = build(&copies);
    validate(&built, &copies);
    assert!(built.tree.stats().max_depth <= 8);
}

#[test]
fn the_tree_is_the_same_at_any_number_of_threads_with_any_kernel() {
    let mut triangles = bumpy_sphere(110);
    triangles.extend(needles(5000, 2.0, &mut Rng(3)));
    let mut boxes: Vec<Aabb> = triangles.iter().map(|t| Aabb::of_points(*t)).collect();
    // All threads come upon some that are none, the last among them.
    let none = boxes.iter_mut().rev().step_by(3);
    none.for_each(|b| *b = Aabb::EMPTY);
    let build_with = |threads, kernel| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let bounds = |id: u32| boxes[id as usize];
        // Whatever is in it, wherever it begins.
        let mut memory = vec![f32::NAN; Bvh::memory(boxes.len()).len() + threads];
        let memory = &mut memory[threads..];
        let progress = &Progress::unwatched();
        let build = || Bvh::build_watched(boxes.len(), bounds, memory, kernel, progress);
        pool.unwrap().install(build)
    };
    let one = build_with(1, Kernel::Portable);
    for kernel in Kernel::available() {
        let four = build_with(4, kernel);
        assert!(one.tree.nodes == four.tree.nodes && one.order == four.order);
        validate(&four, &boxes);
    }
}
