//! Every accelerator against brute force, to the bit, on meshes real and degenerate.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use glam::Vec3;
use lightbox_core::AccelKind;
use lightbox_core::geometry::{Geometry, Hit, Primitives};
use lightbox_core::lab::random::Rng;
use lightbox_core::math::{Aabb, Ray};
use lightbox_core::scene::{boulder, load};
use lightbox_tests::scenes_folder;

use crate::meshes::{Triangle, closed, lattice, needles, sizes, stairs, star};

pub fn run(count: u64, is_planted: bool) -> bool {
    let mut rng = Rng::new(3);
    let teddy = load(&scenes_folder().join("meshes/teddy.obj"))
        .and_then(|source| source.build(&lightbox_core::scene::unwatched))
        .unwrap_or_else(|e| panic!("{e}"));
    let (positions, indices) = boulder(1000);
    let boulder = indices
        .iter()
        .map(|t| t.map(|v| positions[v as usize]))
        .collect();
    let far = Vec3::new(148_376.0, 1234.0, -223_423.0);
    let meshes: [(&str, Vec<Triangle>); 9] = [
        (
            "teddy in its box",
            teddy.primitives().triangles.iter().collect(),
        ),
        ("boulder", boulder),
        ("star", star(12, &mut rng)),
        ("sphere far out", closed(12, far, || 2.0)),
        ("stairs on split planes", stairs(100)),
        ("needles", needles(500, &mut rng)),
        ("lattice, many without area", lattice(500, &mut rng)),
        ("sizes from 1e-6 to 1e3", sizes(500, &mut rng)),
        (
            "one triangle 500 times",
            vec![[Vec3::X, Vec3::Y, Vec3::Z]; 500],
        ),
    ];
    let kinds: Vec<AccelKind> = AccelKind::ALL
        .iter()
        .copied()
        .filter(|kind| !matches!(kind, AccelKind::Auto | AccelKind::Brute))
        .collect();
    print!(
        "{:<28}{:>10}{:>10}{:>10}{:>18}",
        "mesh", "triangles", "rays", "hits", "hash of hits"
    );
    kinds
        .iter()
        .for_each(|kind| print!("{:>16}", format!("{kind} differs")));
    println!();
    let share = count.div_ceil(meshes.len() as u64);
    let mut all = 0;
    for (name, triangles) in meshes {
        let build = |kind: AccelKind| {
            let mut triangles = triangles.clone();
            if is_planted && kind != AccelKind::Brute {
                // A vertex moved by the least that f32 can.
                triangles[0][0].x = triangles[0][0].x.next_up();
            }
            Geometry::build(
                Primitives {
                    triangles: triangles.into(),
                    ..Primitives::default()
                },
                kind,
            )
        };
        let brute = build(AccelKind::Brute);
        let others: Vec<Geometry> = kinds.iter().map(|kind| build(*kind)).collect();
        let counts = crate::sum::<8>(share, |rng, n| {
            let mut counts = [0; 8];
            let rays: Vec<Ray> = (0..n)
                .map(|_| ray(&triangles, brute.bounds(), rng))
                .collect();
            let hits: Vec<Option<Hit>> = rays
                .iter()
                .map(|ray| brute.intersect(ray, |_| false))
                .collect();
            for hit in &hits {
                counts[0] += u64::from(hit.is_some());
                // The same on every machine and with every kernel.
                counts[1] = counts[1].wrapping_add(hash(bits(*hit)));
            }
            // One by one and all in one call.
            for (i, other) in others.iter().enumerate() {
                let mut same: Vec<bool> = rays
                    .iter()
                    .zip(&hits)
                    .map(|(ray, hit)| {
                        bits(other.intersect(ray, |_| false)) == bits(*hit)
                            && other.occluded(ray, u32::MAX) == hit.is_some()
                    })
                    .collect();
                let found = |k: usize, hit| same[k] &= bits(hit) == bits(hits[k]);
                other.intersect_many(&rays, |ray| *ray, |_| false, found);
                let found = |k: usize, occluded| same[k] &= occluded == hits[k].is_some();
                other.occluded_many(&rays, |ray| (*ray, u32::MAX), found);
                counts[i + 2] += same.iter().filter(|same| !**same).count() as u64;
            }
            counts
        });
        print!(
            "{name:<28}{:>10}{share:>10}{:>10}{:>18x}",
            triangles.len(),
            counts[0],
            counts[1]
        );
        for difference in &counts[2..kinds.len() + 2] {
            all += difference;
            print!("{difference:>16}");
        }
        println!();
    }
    all == 0
}

fn bits(hit: Option<Hit>) -> Option<(u32, [u32; 3])> {
    hit.map(|h| (h.prim, [h.t, h.u, h.v].map(f32::to_bits)))
}

fn hash(hit: Option<(u32, [u32; 3])>) -> u64 {
    let mut hasher = DefaultHasher::new();
    hit.hash(&mut hasher);
    hasher.finish()
}

/// Rays at vertices, edges and insides, from outside, inside and vertices; along axes; with ends.
fn ray(triangles: &[Triangle], bounds: Aabb, rng: &mut Rng) -> Ray {
    let (center, size) = (bounds.center(), bounds.diagonal());
    let triangle = triangles[rng.below(triangles.len())];
    let target = match rng.below(3) {
        0 => triangle[rng.below(3)],
        1 => triangle[0].lerp(triangle[1], rng.unit()),
        _ => (triangle[0] + triangle[1] + triangle[2]) / 3.0,
    };
    let other = triangles[rng.below(triangles.len())];
    let origin = match rng.below(4) {
        0 => other[rng.below(3)],
        1 => center + 3.0 * size * rng.cube(),
        _ => center + 0.5 * size * rng.cube(),
    };
    let mut ray = Ray::new(origin, (target - origin).normalize_or(Vec3::X));
    match rng.below(8) {
        0 => {
            let (axis, zero) = (rng.below(3), [0.0, -0.0][rng.below(2)]);
            ray.dir = Vec3::splat(zero);
            ray.dir[axis] = [1.0, -1.0][rng.below(2)];
            ray.origin = target - size * ray.dir;
        }
        1 => ray.t_max = (target - origin).length(),
        2 => ray.t_max = (target - origin).length().next_down(),
        _ => {}
    }
    ray
}
