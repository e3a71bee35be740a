//! Building accelerators: what breaks the builders. Whatever they make of it, rays must find what
//! brute force finds, bit for bit.

use glam::Vec3;

use super::input::{
    Triangle, as_brute_force, bits, build, cast, differences, grid, icosphere, needles, rays_at,
    stairs, toward, trees,
};
use super::random::Rng;
use super::{Case, Check, Figure, naive, pictures, tree_size};
use crate::accel::KdTree;
use crate::math::{Aabb, Ray};
use crate::settings::AccelKind;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "K01",
        title: "no, one and few primitives",
        failure: "Nothing to split: index −1, or a root of NaN.",
        cure: "An empty tree is one empty leaf.",
        check: Check::Probe(few),
        scene: None,
        picture: None,
    },
    Case {
        id: "K02",
        title: "10⁵ identical triangles",
        failure: "No plane parts them: the recursion never ends, or ends in N·2^depth references.",
        cure: "A split has to pay by the surface-area heuristic (MacDonald & Booth 1990).",
        check: Check::Probe(tree_size::identical),
        scene: None,
        picture: Some(pictures::identical),
    },
    Case {
        id: "K03",
        title: "everything on a point, a line, a plane",
        failure: "The surface of the node is 0, and costs are 0/0: every comparison is false.",
        cure: "A node without surface is a leaf.",
        check: Check::Probe(flat),
        scene: None,
        picture: None,
    },
    Case {
        id: "K04",
        title: "stairs in the split planes",
        failure: "Treads and risers lie in the very planes at which nodes are split, and are put on \
                  neither side: holes.",
        cure: "Planar primitives are events of their own, and go to one side at least (Wald & Havran \
               2006).",
        check: Check::Probe(stairs_in_planes),
        scene: Some("builtin:lab/stairs.toml"),
        picture: Some(pictures::stairs_from_above),
    },
    Case {
        id: "K05",
        title: "vertices of random bits",
        failure: "NaN and ∞ among coordinates: hangs, reads out of bounds.",
        cure: "Files with such numbers are refused; the builders bear them all the same.",
        check: Check::Probe(garbage),
        scene: None,
        picture: None,
    },
    Case {
        id: "K06",
        title: "sorting what has no order",
        failure: "sort_by(partial_cmp().unwrap()) panics at the first NaN.",
        cure: "Events are integers in a total order.",
        check: Check::Probe(unordered),
        scene: None,
        picture: None,
    },
    Case {
        id: "K07",
        title: "every leaf lists what lies in it",
        failure: "Ends, planars and starts at one position, swept in the wrong order, let counts \
                  drift and leaves forget.",
        cure: "Events in the order end, planar, start; totals follow from them.",
        check: Check::Probe(listed),
        scene: None,
        picture: None,
    },
    Case {
        id: "K08",
        title: "slivers clipped to nothing",
        failure: "The clipped box of a sliver rounds to empty, and the sliver is dropped from a cell \
                  that it crosses.",
        cure: "Clipping in f64, rounded outward; what seems empty stays.",
        check: Check::Probe(clipped),
        scene: None,
        picture: None,
    },
    Case {
        id: "K09",
        title: "10⁴ needles",
        failure: "Long thin triangles at random angles cross every cell: references explode.",
        cure: "A budget of references.",
        check: Check::Probe(tree_size::needle_budget),
        scene: None,
        picture: None,
    },
    Case {
        id: "K10",
        title: "another order, other threads",
        failure: "Trees and hits that depend on the order of primitives or on who came first.",
        cure: "Ties are decided by axis, position and id; threads share nothing.",
        check: Check::Probe(order_and_threads),
        scene: None,
        picture: None,
    },
    Case {
        id: "K11",
        title: "four times the triangles",
        failure: "Builders of O(N²): minutes at 10⁶.",
        cure: "O(N log N) by merging sorted events (Wald & Havran 2006).",
        check: Check::Probe(tree_size::growth),
        scene: None,
        picture: None,
    },
    Case {
        id: "K12",
        title: "more than a node can count",
        failure: "Counts and indices are cut off to the bits that a packed node has for them.",
        cure: "Scenes with more primitives than a node can count are refused in a line.",
        check: Check::Test(PACKING),
        scene: None,
        picture: None,
    },
];

const PACKING: &str =
    "crates/core/src/scene/check.rs::more_primitives_than_nodes_can_count_are_refused";

fn few() -> Vec<Figure> {
    let mut rng = Rng(8);
    let mut found = 0;
    let rays = rays_at(&grid(1), 100, &mut rng);
    for n in 0..=18 {
        let triangles = rng.soup(n, 1.0);
        found += differences(&triangles, &rays);
        if n > 0 {
            found += differences(&triangles, &rays_at(&triangles, 600, &mut rng));
        }
    }
    vec![as_brute_force(found)]
}

fn flat() -> Vec<Figure> {
    let mut rng = Rng(9);
    let dir = Vec3::new(1.0, 2.0, 4.0);
    let mut on = |f: &dyn Fn(f32) -> Vec3| -> Vec<Triangle> {
        (0..40).map(|_| [0; 3].map(|_| f(rng.unit()))).collect()
    };
    let sets = [
        on(&|_| Vec3::splat(0.5)),
        on(&|t| dir * t),
        on(&|t| Vec3::X * t),
        rng.soup(300, 0.2)
            .iter()
            .map(|t| t.map(|p| p.with_y(0.25)))
            .collect(),
    ];
    let mut found = 0;
    let mut infinite = 0;
    for triangles in sets {
        found += differences(&triangles, &rays_at(&triangles, 1500, &mut rng));
        infinite += usize::from(!tree_size::kd_tree(&triangles).stats().sah_cost.is_finite());
    }
    vec![
        as_brute_force(found),
        Figure::none("trees of 4 without a finite cost", None, infinite),
    ]
}

fn stairs_in_planes() -> Vec<Figure> {
    const STEPS: usize = 20;
    let triangles = stairs(STEPS);
    let rays: Vec<Ray> = (0..128 * 128)
        .flat_map(|i| {
            let origin = Vec3::new((i % 128) as f32 / 127.0, (i / 128) as f32 / 127.0, 2.0);
            [0.0, -0.0].map(|zero| Ray::new(origin, Vec3::new(zero, zero, -1.0)))
        })
        .collect();
    // The highest tread over a point; over a riser that is the upper one's.
    let truth = |ray: &Ray| {
        let x = ray.origin.x;
        let step = (1..STEPS).rev().find(|i| *i as f32 / STEPS as f32 <= x);
        let z = (step.unwrap_or(0) + 1) as f32 / STEPS as f32;
        2.0 - z
    };
    let wrong = |t: Option<f32>, ray: &Ray| usize::from(t != Some(truth(ray)));
    let tree = naive::Tree::of(&triangles, 10);
    let naive = rays
        .iter()
        .map(|ray| wrong(tree.cast(&triangles, ray).map(|hit| hit.0), ray));
    let found: usize = trees(&triangles)
        .iter()
        .map(|tree| {
            let heights = rays
                .iter()
                .map(|ray| wrong(cast(tree, ray).map(|h| h.t), ray));
            heights.sum::<usize>()
        })
        .sum();
    let mut others = rays_at(&triangles, 6000, &mut Rng(7));
    let naive = naive.sum();
    others.extend(rays);
    vec![
        Figure::none(
            "rays of 32768, straight down, at another height than the tread's",
            Some(naive),
            found,
        ),
        as_brute_force(differences(&triangles, &others)),
    ]
}

fn garbage() -> Vec<Figure> {
    let mut rng = Rng(16);
    let mut panics = 0;
    for i in 0..1000 {
        let mut triangles: Vec<Triangle> = (0..40).map(|_| [0; 3].map(|_| rng.cube())).collect();
        // All coordinates of every other scene, some of the rest.
        for triangle in &mut triangles {
            for p in triangle {
                for x in p.as_mut() {
                    if i % 2 == 0 || rng.below(32) == 0 {
                        *x = f32::from_bits(rng.bits());
                    }
                }
            }
        }
        let rays: Vec<Ray> = (0..10)
            .map(|_| Ray::new(2.0 * rng.cube(), rng.direction()))
            .collect();
        let survived = std::panic::catch_unwind(|| {
            let mut hits = 0;
            for tree in trees(&triangles) {
                hits += rays.iter().filter(|ray| cast(&tree, ray).is_some()).count();
            }
            hits
        });
        panics += usize::from(survived.is_err());
    }
    vec![Figure::none("scenes of 1000 that panic", None, panics)]
}

fn unordered() -> Vec<Figure> {
    let nan = Aabb {
        min: Vec3::NAN,
        max: Vec3::NAN,
    };
    let mut rng = Rng(6);
    let mut panics = [0; 2];
    for _ in 0..200 {
        let triangles = rng.soup(50, 0.2);
        let boxes: Vec<Aabb> = triangles
            .iter()
            .enumerate()
            .map(|(i, t)| if i % 7 == 3 { nan } else { Aabb::of_points(*t) })
            .collect();
        // What the unwrap would meet.
        let incomparable = boxes
            .windows(2)
            .any(|b| b[0].min.x.partial_cmp(&b[1].min.x).is_none());
        panics[0] += usize::from(incomparable);
        let built = std::panic::catch_unwind(|| {
            KdTree::build(&boxes, |id, cell| boxes[id as usize].intersection(*cell))
        });
        panics[1] += usize::from(built.is_err());
    }
    vec![Figure::none(
        "builds of 200 with NaN among the boxes that panic",
        Some(panics[0]),
        panics[1],
    )]
}

fn listed() -> Vec<Figure> {
    let mut rng = Rng(17);
    let mut found = 0;
    let sets = [
        rng.soup(150, 0.4),
        grid(4),
        icosphere(2),
        needles(60, 10.0, &mut rng),
    ];
    for triangles in &sets {
        // At 64 points of every triangle, from nearby and from afar.
        let rays: Vec<Ray> = (0..triangles.len() * 64)
            .map(|i| {
                let p = rng.point_of(triangles[i / 64]);
                let origin = p + rng.direction() * if i % 2 == 0 { 0.01 } else { 3.0 };
                Ray::new(origin, toward(origin, p))
            })
            .collect();
        found += differences(triangles, &rays);
    }
    vec![as_brute_force(found)]
}

fn clipped() -> Vec<Figure> {
    let mut rng = Rng(22);
    let slivers: Vec<Triangle> = (0..500)
        .map(|_| {
            let (a, along) = (rng.cube(), rng.direction());
            [a, a + along, a + 0.5 * along + 1e-6 * rng.cube()]
        })
        .collect();
    let rays = rays_at(&slivers, 12_000, &mut rng);
    vec![as_brute_force(differences(&slivers, &rays))]
}

fn order_and_threads() -> Vec<Figure> {
    let mut rng = Rng(18);
    let mut triangles = rng.soup(1000, 0.2);
    let rays = rays_at(&triangles, 2000, &mut rng);
    let distances = |triangles: &[Triangle], accel| -> Vec<_> {
        let geometry = build(triangles, accel);
        let t = |ray| bits(cast(&geometry, ray)).map(|b| b.0);
        rays.iter().map(t).collect()
    };
    let expected = distances(&triangles, AccelKind::Brute);
    let count = |found: &[Option<u32>]| found.iter().zip(&expected).filter(|(a, b)| a != b).count();
    let mut by_threads = 0;
    for threads in [1, 2, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let Ok(pool) = pool else { continue };
        for accel in AccelKind::ALL {
            by_threads += count(&pool.install(|| distances(&triangles, *accel)));
        }
    }
    let mut by_order = 0;
    for _ in 0..10 {
        rng.shuffle(&mut triangles);
        for accel in AccelKind::ALL {
            by_order += count(&distances(&triangles, *accel));
        }
    }
    vec![
        Figure::none("distances that change in 10 other orders", None, by_order),
        Figure::none("distances that change at 1, 2, 8 threads", None, by_threads),
    ]
}
