//! What the builder of the kd-tree makes of every kind of input.

use glam::Vec3;

use super::*;
use crate::accel::test::{self, Rng, Triangle, Walker, bumpy_sphere, clip, grid, needles, rays_at};
use crate::math::Ray;

pub fn build(triangles: &[Triangle]) -> KdTree {
    let bounds: Vec<Aabb> = triangles.iter().map(|t| Aabb::of_points(*t)).collect();
    let tree = KdTree::build(&bounds, |id, cell| clip(&triangles[id as usize], cell));
    validate(&tree, &bounds);
    tree
}

fn leaf_ids(tree: &KdTree, word: u32, count: u32) -> Vec<u32> {
    match count {
        1 => vec![word],
        _ => tree.ids[word as usize..][..count as usize].to_vec(),
    }
}

impl KdTree {
    /// Every cell, and what is listed in a leaf.
    pub(crate) fn cells(&self) -> Vec<(Aabb, Option<Vec<u32>>)> {
        let mut cells = Vec::new();
        self.for_each_cell(|node, cell, _| {
            let listed = match node.kind() {
                Kind::Inner { .. } => None,
                Kind::Leaf { word, count } => Some(leaf_ids(self, word, count)),
            };
            cells.push((*cell, listed));
        });
        cells
    }
}

/// Hits of rays, as by brute force.
fn check(tree: KdTree, triangles: &[Triangle], rays: &[Ray]) -> usize {
    test::check(&[Walker::Kd(tree)], triangles, rays)
}

/// Every node reached once, planes inside their cells, leaves sorted and inside the list, depths
/// within the stack, every primitive listed.
fn validate(tree: &KdTree, bounds: &[Aabb]) {
    let (mut nodes, mut listed) = (0, vec![false; bounds.len()]);
    tree.for_each_cell(|node, cell, depth| {
        nodes += 1;
        match node.kind() {
            Kind::Inner { axis, split, .. } => {
                assert!(cell.min[axis] < split && split < cell.max[axis]);
            }
            Kind::Leaf { word, count } => {
                assert!(depth <= MAX_DEPTH);
                let ids = leaf_ids(tree, word, count);
                assert!(ids.is_sorted_by(|a, b| a < b), "{ids:?}");
                ids.iter().for_each(|&id| listed[id as usize] = true);
            }
        }
    });
    assert_eq!(nodes, tree.nodes.len());
    for (id, b) in bounds.iter().enumerate() {
        assert_eq!(listed[id], !b.is_empty(), "primitive {id}");
    }
}

#[test]
fn k09_needles_and_slivers_keep_to_the_budget() {
    let mut rng = Rng(4);
    for spread in [10.0, 500.0] {
        let triangles = needles(2000, spread, &mut rng);
        let trees = test::build(&triangles);
        assert!(test::check(&trees, &triangles, &rays_at(&triangles, 2000, &mut rng)) > 100);
    }
    // Without a budget this comes to 42 per needle.
    let many = needles(10_000, 500.0, &mut rng);
    let references = build(&many).stats().references;
    assert!(
        (4 * many.len()..=16 * many.len()).contains(&references),
        "{references}"
    );
}

#[test]
fn k02_identical_triangles_end_in_few_references() {
    let triangle = [
        Vec3::new(0.1, 0.2, 0.3),
        Vec3::new(1.0, -0.5, 0.7),
        Vec3::new(-0.3, 0.9, 2.0),
    ];
    for triangle in [triangle, triangle.map(|p| p.with_z(1.0))] {
        let triangles = vec![triangle; 100_000];
        let tree = build(&triangles);
        assert!(tree.stats().references <= 4 * triangles.len());
        let trees = test::build(&triangles);
        assert!(test::check(&trees, &triangles, &rays_at(&triangles, 12, &mut Rng(6))) > 2);
    }
}

#[test]
fn k01_every_small_number_of_primitives() {
    let mut rng = Rng(8);
    let empty = build(&[]);
    empty.walk(&Ray::new(Vec3::ZERO, Vec3::X), |_, _| {
        panic!("nothing to visit")
    });
    assert_eq!(empty.stats().leaves, 1);
    for n in 1..=18 {
        test::check_scene(&rng.soup(n, 1.0), 600, n as u64);
    }
    // Empty boxes are no primitives.
    let triangles = rng.soup(9, 1.0);
    let boxes: Vec<Aabb> = (0..9)
        .map(|i| match i % 3 {
            0 => Aabb::EMPTY,
            _ => Aabb::of_points(triangles[i]),
        })
        .collect();
    let tree = KdTree::build(&boxes, |id, cell| clip(&triangles[id as usize], cell));
    validate(&tree, &boxes);
}

#[test]
fn k03_points_lines_and_planes_never_divide_by_their_area() {
    let mut rng = Rng(9);
    let point = vec![[Vec3::splat(0.5); 3]; 40];
    let dir = Vec3::new(1.0, 2.0, 4.0);
    let line: Vec<Triangle> = (0..40).map(|_| [0; 3].map(|_| dir * rng.unit())).collect();
    let axis: Vec<Triangle> = (0..40)
        .map(|_| [0; 3].map(|_| Vec3::X * rng.unit()))
        .collect();
    for (triangles, has_area) in [(point, false), (line, true), (axis, false)] {
        let tree = build(&triangles);
        assert_eq!(tree.stats().leaves > 1, has_area);
        assert!(tree.stats().sah_cost.is_finite());
        let trees = test::build(&triangles);
        test::check(&trees, &triangles, &rays_at(&triangles, 600, &mut rng));
    }
    let flat: Vec<Triangle> = rng
        .soup(300, 0.2)
        .iter()
        .map(|t| t.map(|p| p.with_y(0.25)))
        .collect();
    test::check_scene(&flat, 3000, 10);
}

#[test]
fn k08_nothing_is_lost_to_a_clip_that_finds_nothing() {
    let triangles = Rng(22).soup(500, 0.5);
    let boxes: Vec<Aabb> = triangles.iter().map(|t| Aabb::of_points(*t)).collect();
    let outside = |cell: &Aabb| Aabb {
        min: cell.max.map(f32::next_up),
        max: cell.max.map(f32::next_up),
    };
    let nan = Aabb {
        min: Vec3::NAN,
        max: Vec3::NAN,
    };
    for clip in
        [&|_: &Aabb| Aabb::EMPTY, &|_: &Aabb| nan, &outside] as [&(dyn Fn(&Aabb) -> Aabb + Sync); 3]
    {
        let tree = KdTree::build(&boxes, |_, cell| clip(cell));
        assert!(tree.stats().leaves > 1);
        validate(&tree, &boxes);
    }
    let tree = KdTree::build(&boxes, |_, _| Aabb::EMPTY);
    check(tree, &triangles, &rays_at(&triangles, 1200, &mut Rng(23)));
}

#[test]
fn k05_boxes_of_random_bits_neither_hang_nor_panic() {
    let mut rng = Rng(16);
    for _ in 0..300 {
        let mut vertex = || Vec3::from_array([0; 3].map(|_| f32::from_bits(rng.bits())));
        let boxes: Vec<Aabb> = (0..50)
            .map(|_| Aabb::of_points([vertex(), vertex(), vertex()]))
            .collect();
        let tree = KdTree::build(&boxes, |id, cell| boxes[id as usize].intersection(*cell));
        validate(&tree, &boxes);
        for _ in 0..20 {
            tree.walk(&Ray::new(rng.cube(), rng.cube().normalize()), |_, t_max| {
                t_max
            });
        }
    }
}

#[test]
fn k07_every_leaf_lists_what_lies_in_it() {
    let mut rng = Rng(17);
    for triangles in [
        rng.soup(150, 0.4),
        grid(4),
        bumpy_sphere(7),
        needles(60, 10.0, &mut rng),
    ] {
        let tree = build(&triangles);
        let points: Vec<(u32, Vec3)> = (0..triangles.len() * 64)
            .map(|i| ((i / 64) as u32, rng.point_of(triangles[i / 64])))
            .collect();
        let mut found = vec![false; points.len()];
        tree.for_each_cell(|node, cell, _| {
            let Kind::Leaf { word, count } = node.kind() else {
                return;
            };
            let ids = leaf_ids(&tree, word, count);
            // Points carry rounding errors of their own.
            let error = 8.0 * f32::EPSILON * cell.max.abs().max(cell.min.abs());
            for (&(id, p), found) in points.iter().zip(&mut found) {
                let listed = ids.binary_search(&id).is_ok();
                let deep = (p - error).cmpgt(cell.min).all() && (p + error).cmplt(cell.max).all();
                assert!(listed || !deep, "{id} at {p} is not in the leaf {cell:?}");
                *found |= listed
                    && (p + error).cmpge(cell.min).all()
                    && (p - error).cmple(cell.max).all();
            }
        });
        assert!(
            found.iter().all(|&f| f),
            "a point is in no leaf that lists its triangle"
        );
    }
}

#[test]
fn the_tree_is_the_same_at_any_number_of_threads() {
    let triangles = bumpy_sphere(110);
    let build_with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| build(&triangles))
    };
    let (one, four) = (build_with(1), build_with(4));
    assert!(one.nodes == four.nodes && one.ids == four.ids);
    check(one, &triangles, &rays_at(&triangles, 60, &mut Rng(19)));
}

#[test]
fn statistics_of_a_tree_known_by_hand() {
    let triangles = grid(1);
    let stats = build(&triangles[..2]).stats();
    assert_eq!(
        (stats.nodes, stats.leaves, stats.references, stats.max_depth),
        (1, 1, 2, 0)
    );
    assert_eq!(stats.bytes, 8 + 2 * 4);
    assert_eq!(stats.sah_cost, 2.0 * INTERSECTION_COST);
}
