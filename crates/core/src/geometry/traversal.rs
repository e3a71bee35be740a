//! What it takes to find the nearest hit of a ray, counted by a query of its own: those that cast the
//! rays of pictures count nothing.

use super::cast::Geometry;
use super::search::{Face, Nearest, Search, reach};
use crate::math::Ray;

/// What it took to find the nearest hit of a ray that is cast by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Traversal {
    /// Inner nodes of trees that it visited.
    pub nodes: u32,
    /// Triangles and spheres that were tested, each as often as it was; a quad is two triangles.
    pub tests: u32,
}

impl Traversal {
    /// Steps in all.
    pub fn steps(self) -> u32 {
        self.nodes.saturating_add(self.tests)
    }
}

/// A search that counts.
struct Counted<S> {
    search: S,
    count: Traversal,
}

impl<S: Search> Search for Counted<S> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.search.t_max()
    }

    const LIMIT: f32 = S::LIMIT;

    #[inline(always)]
    fn offer(&mut self, t: f32, face: Face, b: [f32; 2]) {
        self.search.offer(t, face, b);
    }

    #[inline(always)]
    fn node(&mut self) {
        self.count.nodes += 1;
    }

    #[inline(always)]
    fn tests(&mut self, count: u32) {
        self.count.tests += count;
    }
}

impl Geometry {
    /// What it takes to find what [`Geometry::intersect`] finds.
    pub fn traversal(&self, ray: &Ray, is_emitter: impl Fn(u32) -> bool) -> Traversal {
        let search = Nearest {
            is_emitter,
            t_max: reach(ray),
            face: Face::NONE,
            b: [0.0; 2],
        };
        let count = Traversal::default();
        let mut counted = Counted { search, count };
        self.search(ray, &mut counted);
        counted.count
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::cast::Accel;
    use super::super::test::mixed;
    use super::super::{Primitive, Primitives};
    use super::*;
    use crate::accel::test::{Rng, bumpy_sphere, rays_at};
    use crate::math::Aabb;
    use crate::settings::AccelKind;
    use crate::shape::Sphere;

    const KINDS: [AccelKind; 3] = [AccelKind::Brute, AccelKind::KdTree, AccelKind::Bvh];

    fn count(geometry: &Geometry, ray: &Ray) -> [u32; 2] {
        let Traversal { nodes, tests } = geometry.traversal(ray, |_| false);
        [nodes, tests]
    }

    /// Whether a ray is in a box, grown by `pad`, before `t_max`.
    fn meets(ray: &Ray, bounds: &Aabb, pad: f64, t_max: f32) -> bool {
        let (mut enter, mut exit) = (0.0f64, f64::from(t_max));
        for axis in 0..3 {
            let (o, d) = (f64::from(ray.origin[axis]), f64::from(ray.dir[axis]));
            let [lo, hi] = [
                f64::from(bounds.min[axis]) - pad - o,
                f64::from(bounds.max[axis]) + pad - o,
            ];
            if d == 0.0 {
                if lo > 0.0 || hi < 0.0 {
                    return false;
                }
                continue;
            }
            enter = enter.max((lo / d).min(hi / d));
            exit = exit.min((lo / d).max(hi / d));
        }
        enter <= exit
    }

    /// What is counted box by box, without a walk: all those that the ray meets before `t_max`.
    fn by_boxes(geometry: &Geometry, ray: &Ray, pad: f64, t_max: f32) -> [u32; 2] {
        let primitives = &geometry.primitives;
        let tests = |id: u32| match primitives.get(id) {
            Primitive::Quad(_) => 2,
            Primitive::Triangle(_) | Primitive::Sphere(_) => 1,
        };
        let mut found = [0, 0];
        let mut add = |bounds: &Aabb, leaf: Option<u32>| {
            if meets(ray, bounds, pad, t_max) {
                match leaf {
                    None => found[0] += 1,
                    Some(count) => found[1] += count,
                }
            }
        };
        let all = geometry.bounds();
        let spheres = primitives.spheres.len() as u32;
        match &geometry.accel {
            Accel::Brute(sweep) => {
                add(
                    &sweep.bounds,
                    Some(sweep.runs().map(|(_, count)| count).sum()),
                );
                add(&all, Some(spheres));
            }
            Accel::KdTree(tree) => {
                for (cell, ids) in tree.cells() {
                    add(&cell, ids.map(|ids| ids.into_iter().map(tests).sum()));
                }
            }
            Accel::Bvh {
                tree,
                spheres: sphere_tree,
                ..
            } => {
                tree.boxes().iter().for_each(|(b, count)| add(b, *count));
                match sphere_tree {
                    None => add(&all, Some(spheres)),
                    Some((tree, _)) => tree.boxes().iter().for_each(|(b, count)| add(b, *count)),
                }
            }
        }
        found
    }

    #[test]
    fn visits_are_those_of_boxes_on_the_way() {
        let mut rng = Rng(77);
        let triangles = bumpy_sphere(12);
        for (spheres, accel) in KINDS.into_iter().flat_map(|kind| [(3, kind), (60, kind)]) {
            let geometry = Geometry::build(mixed(&triangles, spheres), accel);
            let far = geometry.bounds().diagonal();
            let (mut misses, mut exact) = (0, 0);
            let mut rays = rays_at(&triangles, 500, &mut rng);
            rays.extend((0..500).map(|_| Ray::new(2.0 * rng.cube(), rng.direction())));
            for mut ray in rays {
                ray.t_max = f32::INFINITY;
                let counted = count(&geometry, &ray);
                let reach = f64::from(far + ray.origin.length());
                let most = by_boxes(&geometry, &ray, 2e-5 * reach, f32::INFINITY);
                // What begins behind the hit may have been visited before that was found.
                let hit = geometry.intersect(&ray, |_| false);
                let t_max = hit.map_or(f32::INFINITY, |hit| hit.t);
                let least = by_boxes(&geometry, &ray, 0.0, t_max);
                for i in 0..2 {
                    assert!(
                        least[i] <= counted[i] && counted[i] <= most[i],
                        "{accel:?} {ray:?}: {least:?} {counted:?} {most:?}"
                    );
                }
                misses += usize::from(hit.is_none());
                exact += usize::from(hit.is_none() && least == most);
            }
            assert!(
                misses > 50 && 10 * exact > 8 * misses,
                "{exact} of {misses}"
            );
        }
    }

    /// Eight clusters of eight small triangles along x, each in a leaf of its own.
    fn clusters() -> Primitives {
        let mut primitives = Primitives::default();
        for i in 0..64 {
            let corner = Vec3::new((i / 8) as f32 * 100.0, (i % 8) as f32 * 0.01, 0.0);
            // No side of their box.
            let triangle = [corner, corner + Vec3::Y, corner + Vec3::new(0.01, 0.0, 1.0)];
            primitives.triangles.push(triangle);
        }
        primitives
    }

    #[test]
    fn a_small_tree_is_counted_by_hand() {
        let geometry = Geometry::build(clusters(), AccelKind::Bvh);
        let stats = geometry.tree_stats().expect("a tree");
        assert_eq!((stats.nodes, stats.leaves, stats.references), (1, 8, 64));
        let from_left = |y: f32, z: f32| Ray::new(Vec3::new(-1.0, y, z), Vec3::X);
        // Into the nearest cluster; past the triangles but through all of their boxes; past the tree.
        assert_eq!(count(&geometry, &from_left(0.3, 0.3)), [1, 8]);
        assert_eq!(count(&geometry, &from_left(0.99, 0.99)), [1, 64]);
        assert_eq!(count(&geometry, &from_left(0.3, 1.5)), [0, 0]);
        // From above onto the fourth.
        let down = Ray::new(Vec3::new(300.0, 0.3, 5.0), -Vec3::Z);
        assert_eq!(count(&geometry, &down), [1, 8]);
        // All of them without a tree, wherever the ray leads within their box.
        let geometry = Geometry::build(clusters(), AccelKind::Brute);
        assert_eq!(count(&geometry, &from_left(0.3, 0.3)), [0, 64]);
        assert_eq!(count(&geometry, &from_left(0.3, 1.5)), [0, 0]);
    }

    #[test]
    fn quads_are_two_and_few_spheres_are_all_tested() {
        let mut primitives = mixed(&[[Vec3::ZERO, Vec3::X, Vec3::Y]; 3], 0);
        let (quads, triangles) = (primitives.quads.len(), primitives.triangles.len());
        assert_eq!((quads, triangles), (1, 4));
        let center = Vec3::new(0.2, 0.2, 1.0);
        primitives.spheres.extend(
            [Sphere {
                center,
                radius: 0.1,
            }; 5],
        );
        let geometry = Geometry::build(primitives, AccelKind::Brute);
        let down = |x: f32| Ray::new(Vec3::new(x, x, 9.0), -Vec3::Z);
        assert_eq!(count(&geometry, &down(0.4)), [0, 4 + 2 + 5]);
        // The others are a side, and behind.
        assert_eq!(count(&geometry, &down(0.2)), [0, 5]);
    }
}
