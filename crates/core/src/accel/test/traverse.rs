//! What rays find.

use super::*;

#[test]
fn soups_of_all_sizes_are_hit_as_by_brute_force() {
    let mut rng = Rng(1);
    for (n, size) in [
        (20, 1.0),
        (200, 0.5),
        (2000, 0.1),
        (2000, 1.0),
        (5000, 0.02),
    ] {
        let triangles = rng.soup(n, size);
        check_scene(&triangles, 3000, n as u64);
    }
}

#[test]
fn a_closed_mesh_is_hit_as_by_brute_force_and_has_no_holes() {
    let triangles = bumpy_sphere(24);
    let trees = check_scene(&triangles, 12_000, 2);
    let mut rng = Rng(3);
    for _ in 0..5000 {
        let target = triangles[rng.below(triangles.len())][rng.below(3)];
        let origin = 0.1 * rng.cube();
        let ray = Ray::new(origin, (target - origin).normalize());
        assert!(
            closest_in_trees(&trees, &triangles, &ray).is_some(),
            "{ray:?}"
        );
    }
}

#[test]
fn k04_stairs_in_split_planes_have_no_holes() {
    let mut triangles = Vec::new();
    let mut quad = |a: Vec3, u: Vec3, v: Vec3| {
        triangles.push([a, a + u, a + u + v]);
        triangles.push([a, a + u + v, a + v]);
    };
    for step in 0..20 {
        let (x, z) = (step as f32 / 20.0, (step + 1) as f32 / 20.0);
        let x_next = (step + 1) as f32 / 20.0;
        quad(Vec3::new(x, 0.0, z), Vec3::X * (x_next - x), Vec3::Y);
        quad(
            Vec3::new(x, 0.0, step as f32 / 20.0),
            Vec3::Y,
            Vec3::Z * 0.05,
        );
    }
    let trees = build(&triangles);
    let mut rays = Vec::new();
    for i in 0..128 * 128 {
        let origin = Vec3::new((i % 128) as f32 / 127.0, (i / 128) as f32 / 127.0, 2.0);
        for zero in [0.0, -0.0] {
            rays.push(Ray::new(origin, Vec3::new(zero, zero, -1.0)));
        }
    }
    assert_eq!(check(&trees, &triangles, &rays), rays.len());
    check_scene(&triangles, 6000, 7);
}

#[test]
fn v02_v04_rays_in_split_planes_of_a_grid() {
    let triangles = grid(8);
    let trees = check_scene(&triangles, 6000, 11);
    let mut rays = Vec::new();
    for axis in 0..3 {
        for i in 0..81 {
            let at = Vec3::from_array([(i % 9) as f32, (i / 9) as f32, 9.0]);
            let origin = Vec3::from_array([0, 1, 2].map(|k| at[(axis + k) % 3]));
            for zero in [0.0, -0.0] {
                let towards =
                    Vec3::from_array([0, 1, 2].map(|k| [zero, zero, -1.0][(axis + k) % 3]));
                rays.push(Ray::new(origin, towards));
            }
        }
    }
    assert!(check(&trees, &triangles, &rays) >= 400);
}

#[test]
fn v11_rays_along_an_axis_visit_no_more_than_others() {
    let triangles = bumpy_sphere(60);
    let trees = build(&triangles);
    for tree in &trees {
        let visits = |dir: Vec3| {
            let mut rng = Rng(21);
            let mut count = 0;
            for _ in 0..2000 {
                let ray = Ray::new(rng.cube() - 4.0 * dir, dir.normalize());
                tree.walk(&ray, &mut |_, t_max| {
                    count += 1;
                    t_max
                });
            }
            count
        };
        let (along, askew) = (visits(Vec3::X), visits(Vec3::new(1.0, 0.1, 0.1)));
        assert!(along < 2 * askew, "{along} {askew}");
    }
}

#[test]
fn v01_zeros_of_either_sign_give_the_same_hit() {
    let triangle = |z: f32| {
        [
            Vec3::new(0.0, 0.0, z),
            Vec3::new(1.0, 0.0, z),
            Vec3::new(0.0, 1.0, z),
        ]
    };
    let mut triangles = vec![triangle(1.0), triangle(2.1)];
    triangles.extend(grid(6));
    let trees = build(&triangles);
    let mut rng = Rng(12);
    for _ in 0..2000 {
        let origin = (rng.cube() * 8.0).round() * 0.5;
        let (a, b) = (Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.0, -0.0, 1.0));
        let hits =
            [a, b, b.yxz()].map(|dir| closest_in_trees(&trees, &triangles, &Ray::new(origin, dir)));
        assert!(
            hits[0] == hits[1] && hits[0] == hits[2],
            "{origin} {hits:?}"
        );
    }
}

#[test]
fn far_from_zero_and_at_every_scale_the_hits_are_brute_force_hits() {
    let offset = Vec3::new(1e5, -1e5, 3e5);
    let sphere = bumpy_sphere(16);
    let moved: Vec<Triangle> = sphere.iter().map(|t| t.map(|p| p + offset)).collect();
    check_scene(&moved, 6000, 13);

    let trees = build(&sphere);
    let rays = rays_at(&sphere, 1200, &mut Rng(14));
    for k in [-50, -7, 1, 20, 50] {
        let scale = 2f32.powi(k);
        let scaled: Vec<Triangle> = sphere.iter().map(|t| t.map(|p| p * scale)).collect();
        let scaled_trees = build(&scaled);
        for ray in &rays {
            let scaled_ray = Ray {
                origin: ray.origin * scale,
                t_max: ray.t_max * scale,
                ..*ray
            };
            let hit = closest_in_trees(&trees, &sphere, ray);
            let expected = hit.map(|(t, id)| ((f32::from_bits(t) * scale).to_bits(), id));
            assert_eq!(
                closest_in_trees(&scaled_trees, &scaled, &scaled_ray),
                expected
            );
        }
    }
    // A scene seen from so far that the beam is wider than a triangle.
    let far: Vec<Ray> = rays
        .iter()
        .map(|r| Ray::new(r.origin - 1e5 * r.dir, r.dir))
        .collect();
    check(&trees, &sphere, &far);
}

#[test]
fn v06_v07_rays_without_meaning_visit_nothing() {
    let triangles = bumpy_sphere(8);
    let trees = build(&triangles);
    let ray = Ray::new(Vec3::new(0.0, 0.1, 3.0), -Vec3::Z);
    assert!(closest_in_trees(&trees, &triangles, &ray).is_some());
    let inside = Ray {
        origin: triangles[40][0],
        ..ray
    };
    let bad = [meaningless(ray), meaningless(inside)].concat();
    for ray in bad {
        for tree in &trees {
            tree.walk(&ray, &mut |_, _| panic!("visited by {ray:?}"));
        }
    }
    // Extreme but finite: anything may be visited, nothing may hang.
    for x in [f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-45, 1e30] {
        for axis in 0..3 {
            let (mut origin, mut dir) = (ray.origin, ray.dir);
            origin[axis] = x;
            dir[axis] = x;
            for ray in [
                Ray { origin, ..ray },
                Ray { dir, ..ray },
                Ray { origin, dir, ..ray },
            ] {
                for tree in &trees {
                    tree.walk(&ray, &mut |_, t_max| t_max);
                }
            }
        }
    }
}

#[test]
fn v08_a_geometric_cluster_stays_within_the_stack() {
    let mut triangles = Vec::new();
    for i in 0..120 {
        let corner = Vec3::splat(0.5f32.powi(i));
        triangles.extend([[corner, corner * 1.25, corner * Vec3::new(1.25, 1.0, 1.5)]; 4]);
    }
    let trees = build(&triangles);
    check(&trees, &triangles, &rays_at(&triangles, 3000, &mut Rng(15)));
}

#[test]
fn a_visitor_may_prefer_what_is_a_rounding_error_behind() {
    // Pairs of triangles 2⁻²⁰ of their distance apart, flat, so that planes of the tree lie
    // between them; ids that are odd count as nearer.
    const NUDGE: f32 = 1.0 / (1 << 20) as f32;
    let mut rng = Rng(20);
    let mut triangles = Vec::new();
    for _ in 0..2000 {
        let center = rng.cube() + 2.0 * Vec3::Z;
        let front = [0; 3].map(|_| (center + 0.5 * rng.cube()).with_z(center.z));
        let back = front.map(|p| p.with_z(p.z * (1.0 + NUDGE * rng.unit())));
        triangles.extend([front, back]);
    }
    let trees = build(&triangles);
    for _ in 0..4000 {
        let target = rng.cube() + 2.0 * Vec3::Z;
        let ray = Ray::new(Vec3::ZERO, target.normalize());
        let nearest = |walk: &dyn Fn(Visit)| {
            let mut best: Option<(f32, u32)> = None;
            walk(&mut |id, t_max| {
                let bias = if id % 2 == 1 { 1.0 - NUDGE } else { 1.0 };
                match intersect(triangles[id as usize], &ray, t_max * (1.0 + NUDGE)) {
                    Some(t) if best.is_none_or(|b| (t * bias, id) < b) => {
                        best = Some((t * bias, id));
                        t * bias
                    }
                    _ => t_max,
                }
            });
            best
        };
        let expected = nearest(&|visit| {
            (0..triangles.len() as u32).fold(ray.t_max, |t_max, id| visit(id, t_max));
        });
        for tree in &trees {
            assert_eq!(
                nearest(&|visit| tree.walk(&ray, visit)),
                expected,
                "{ray:?}"
            );
        }
    }
}

#[test]
fn k10_order_of_primitives_changes_no_distance() {
    let mut rng = Rng(18);
    let mut triangles = rng.soup(1000, 0.2);
    let rays = rays_at(&triangles, 600, &mut rng);
    let distances = |triangles: &[Triangle]| -> Vec<Option<u32>> {
        let trees = build(triangles);
        let hit = |ray| closest_in_trees(&trees, triangles, ray).map(|(t, _)| t);
        rays.iter().map(hit).collect()
    };
    let expected = distances(&triangles);
    for _ in 0..5 {
        for i in (1..triangles.len()).rev() {
            triangles.swap(i, rng.below(i + 1));
        }
        assert_eq!(distances(&triangles), expected);
    }
}
