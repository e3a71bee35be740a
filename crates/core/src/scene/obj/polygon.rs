//! Cutting polygons into triangles by ear clipping (Meisters 1975).
//!
//! A corner is tested again only when a neighbour has gone, and only against reflex and straight
//! corners, which a k-d tree finds: n corners take about n log n steps, n√n in the worst comb.
//! Straight corners stay vertices: a neighbouring face may have them too, and a triangle edge that
//! passed over them would leave a crack. Signs are computed in f64 from f32 coordinates.

use std::collections::VecDeque;

use glam::{DVec2, DVec3, Vec3};

/// What became of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Its triangles cover it once and face its way.
    Covered,
    /// It crosses or touches itself in a way that leaves no inside; its triangles are a guess.
    Crossing,
    /// It has no area, and no triangles.
    NoArea,
}

/// Triangulates polygons, one after the other, in the same buffers.
#[derive(Default)]
pub(super) struct Triangulator {
    /// Of the last polygon; indices into its corners.
    pub triangles: Vec<[usize; 3]>,
    /// By corner: its place in the plane, where the polygon runs counter-clockwise.
    points: Vec<DVec2>,
    /// By corner.
    ring: Vec<Link>,
    /// Corners that were reflex or straight at first (once cut off, they lie outside and are in
    /// nobody's way), as a k-d tree: the median in the middle, the halves to both sides, split by
    /// x and y in turn.
    blockers: Vec<usize>,
    /// Corners to test, with their age at the time: older entries of a corner are void.
    queue: VecDeque<(usize, u32)>,
}

/// A corner in the ring of those left.
#[derive(Clone, Copy)]
struct Link {
    previous: usize,
    next: usize,
    /// How many neighbours were cut off.
    age: u32,
}

impl Triangulator {
    /// Cuts a polygon, planar or nearly so, into `self.triangles`, which wind as it does.
    pub(super) fn triangulate(&mut self, corners: &[Vec3]) -> Outcome {
        self.triangles.clear();
        let outcome = if corners.len() == 3 {
            self.push_with_area(corners, [0, 1, 2]);
            Outcome::Covered
        } else {
            self.link(corners);
            self.clip(corners)
        };
        if self.triangles.is_empty() {
            Outcome::NoArea
        } else {
            outcome
        }
    }

    /// Prepares ring, plane, blockers and queue.
    fn link(&mut self, corners: &[Vec3]) {
        let n = corners.len();
        let project = projection(area_normal(corners.iter().copied()));
        self.points.clear();
        self.points
            .extend(corners.iter().map(|p| project(p.as_dvec3())));
        self.ring.clear();
        self.ring.extend((0..n).map(|i| Link {
            previous: (i + n - 1) % n,
            next: (i + 1) % n,
            age: 0,
        }));
        // From the second corner on: a convex quadrilateral is then split between its first and
        // third one, as everywhere.
        self.queue.clear();
        self.queue
            .extend((1..n).chain([0]).map(|corner| (corner, 0)));

        let mut blockers = std::mem::take(&mut self.blockers);
        blockers.clear();
        blockers.extend((0..n).filter(|corner| {
            let [a, b, c] = self.triangle_at(*corner);
            turn(a, b, c) <= 0.0
        }));
        sort_into_tree(&mut blockers, &self.points, 0);
        self.blockers = blockers;
    }

    /// Cuts off ears until a triangle is left.
    fn clip(&mut self, corners: &[Vec3]) -> Outcome {
        let mut left = corners.len();
        let mut start = 0;
        while left > 3 {
            let Some((corner, age)) = self.queue.pop_front() else {
                break;
            };
            if self.ring[corner].age != age || !self.is_ear(corner) {
                continue;
            }
            let Link { previous, next, .. } = self.ring[corner];
            self.triangles.push([previous, corner, next]);
            self.ring[previous].next = next;
            self.ring[next].previous = previous;
            for neighbour in [previous, next] {
                self.ring[neighbour].age += 1;
                self.queue.push_back((neighbour, self.ring[neighbour].age));
            }
            left -= 1;
            start = next;
        }
        // The rest: the last triangle, or the fan of a polygon without a further ear.
        let mut outcome = Outcome::Covered;
        let mut corner = self.ring[start].next;
        for _ in 2..left {
            let next = self.ring[corner].next;
            let inverted = turn(self.points[start], self.points[corner], self.points[next]) < 0.0;
            if self.push_with_area(corners, [start, corner, next]) && (left > 3 || inverted) {
                outcome = Outcome::Crossing;
            }
            corner = next;
        }
        outcome
    }

    fn triangle_at(&self, corner: usize) -> [DVec2; 3] {
        let Link { previous, next, .. } = self.ring[corner];
        [previous, corner, next].map(|i| self.points[i])
    }

    /// Whether the triangle of a corner and its neighbours lies inside, free of other corners.
    fn is_ear(&self, corner: usize) -> bool {
        let triangle = self.triangle_at(corner);
        let [a, b, c] = triangle;
        turn(a, b, c) > 0.0
            && !self.is_blocked(
                triangle,
                &self.blockers,
                a.min(b).min(c),
                a.max(b).max(c),
                0,
            )
    }

    /// Whether a blocker lies in the triangle or on its edge. Those of `tree` that matter lie
    /// between `low` and `high`.
    fn is_blocked(
        &self,
        triangle: [DVec2; 3],
        tree: &[usize],
        low: DVec2,
        high: DVec2,
        axis: usize,
    ) -> bool {
        let [a, b, c] = triangle;
        let edges = [(a, b), (b, c), (c, a)];
        if tree.is_empty()
            || low.cmpgt(high).any()
            || edges.iter().any(|(p, q)| right_of(*p, *q, low, high))
        {
            return false;
        }
        let median = tree.len() / 2;
        let point = self.points[tree[median]];
        // A corner in the same place as one of the three is not in the way: polygons with holes
        // are written as one outline that runs to the hole and back along the same edge.
        let blocks =
            !triangle.contains(&point) && edges.iter().all(|(p, q)| turn(*p, *q, point) >= 0.0);
        let (mut left_high, mut right_low) = (high, low);
        left_high[axis] = high[axis].min(point[axis]);
        right_low[axis] = low[axis].max(point[axis]);
        blocks
            || self.is_blocked(triangle, &tree[..median], low, left_high, 1 - axis)
            || self.is_blocked(triangle, &tree[median + 1..], right_low, high, 1 - axis)
    }

    fn push_with_area(&mut self, corners: &[Vec3], triangle: [usize; 3]) -> bool {
        let has_area = area_normal(triangle.iter().map(|i| corners[*i])) != DVec3::ZERO;
        if has_area {
            self.triangles.push(triangle);
        }
        has_area
    }
}

/// Twice the signed area of a triangle: positive if it turns left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Whether the whole box from `low` to `high` lies to the right of a line.
fn right_of(from: DVec2, to: DVec2, low: DVec2, high: DVec2) -> bool {
    let left = (to - from).perp();
    let leftmost = DVec2::select(left.cmpgt(DVec2::ZERO), high, low);
    turn(from, to, leftmost) < 0.0
}

fn sort_into_tree(corners: &mut [usize], points: &[DVec2], axis: usize) {
    if corners.len() > 1 {
        let by_axis = |a: &usize, b: &usize| points[*a][axis].total_cmp(&points[*b][axis]);
        let (left, _, right) = corners.select_nth_unstable_by(corners.len() / 2, by_axis);
        sort_into_tree(left, points, 1 - axis);
        sort_into_tree(right, points, 1 - axis);
    }
}

/// Normal of a polygon, twice its area long (Newell's method, about the first corner).
fn area_normal(corners: impl Iterator<Item = Vec3>) -> DVec3 {
    let mut corners = corners.map(|p| p.as_dvec3());
    let first = corners.next().unwrap_or_default();
    let edges = corners.map(|p| p - first);
    edges
        .fold((DVec3::ZERO, DVec3::ZERO), |(sum, previous), edge| {
            (sum + previous.cross(edge), edge)
        })
        .0
}

/// Into the coordinate plane most nearly parallel to a polygon, so that it runs counter-clockwise.
/// Leaves coordinates as they are, so that signs stay exact.
fn projection(normal: DVec3) -> impl Fn(DVec3) -> DVec2 {
    let axis = normal.abs().max_position();
    let flip = normal[axis] < 0.0;
    let (x, y) = ((axis + 1) % 3, (axis + 2) % 3);
    let (x, y) = if flip { (y, x) } else { (x, y) };
    move |p| DVec2::new(p[x], p[y])
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use glam::{Mat3, Vec2};

    use super::*;

    /// Asserts that the triangles cover a polygon that runs counter-clockwise about `normal`.
    ///
    /// Cutting off corners keeps the sum of winding numbers, 1 inside and 0 outside, whatever is
    /// cut. So if no triangle is upside down, every point inside lies in exactly one.
    fn assert_covered(corners: &[Vec3], normal: Vec3, expected_triangles: usize) {
        let mut triangulator = Triangulator::default();
        assert_eq!(triangulator.triangulate(corners), Outcome::Covered);
        assert_eq!(triangulator.triangles.len(), expected_triangles);
        // In the plane in which the signs are right; across it, rounding decides about slivers.
        let axis = normal.abs().max_position();
        let area_of = |i: &mut dyn Iterator<Item = Vec3>| {
            area_normal(i)[axis] * f64::from(normal[axis].signum())
        };
        let mut area = 0.0;
        for triangle in &triangulator.triangles {
            let part = area_of(&mut triangle.iter().map(|i| corners[*i]));
            assert!(part > 0.0, "{triangle:?} {part}");
            area += part;
        }
        let whole = area_of(&mut corners.iter().copied());
        assert!((area - whole).abs() <= 1e-9 * whole, "{area} {whole}");
    }

    /// Puts a polygon, counter-clockwise, into the six axis-parallel planes and a slanted one,
    /// each from several corners on.
    fn assert_covered_anywhere(outline: &[Vec2], expected_triangles: usize) {
        let slanted = Mat3::from_rotation_x(0.7) * Mat3::from_rotation_y(0.4);
        for axes in [
            Mat3::IDENTITY,
            Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X),
            Mat3::from_cols(Vec3::Z, Vec3::X, Vec3::Y),
            Mat3::from_cols(Vec3::Y, Vec3::X, Vec3::NEG_Z),
            Mat3::from_cols(Vec3::Z, Vec3::Y, Vec3::NEG_X),
            Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y),
            slanted,
        ] {
            // Rounding makes straight corners slightly convex or reflex, which is as well.
            let mut corners: Vec<Vec3> = outline.iter().map(|p| axes * p.extend(0.25)).collect();
            let step = 1 + corners.len() / 12;
            for _ in (0..outline.len()).step_by(step) {
                assert_covered(&corners, axes.z_axis, expected_triangles);
                corners.rotate_left(step);
            }
        }
    }

    /// Radius 1 at every `period`-th corner, else `inner`.
    fn star(n: usize, period: usize, inner: f32) -> Vec<Vec2> {
        let radius = |i: usize| if i.is_multiple_of(period) { 1.0 } else { inner };
        (0..n)
            .map(|i| Vec2::from_angle(TAU * i as f32 / n as f32) * radius(i))
            .collect()
    }

    /// A square of `k` corners a side: all but four are straight.
    fn square(k: usize) -> Vec<Vec2> {
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(|p| p * k as f32);
        let sides = (0..4).map(|i| (corners[i], corners[(i + 1) % 4]));
        let side = |(from, to): (Vec2, Vec2)| {
            (0..k).map(move |i| from + (to - from) / k as f32 * i as f32)
        };
        sides.flat_map(side).collect()
    }

    /// A triangle with `n - 3` straight corners on one side.
    fn divided(n: usize) -> Vec<Vec2> {
        let side = (1..n).map(|x| Vec2::new(x as f32, 0.0));
        side.chain([Vec2::new(1.0, 7.0)]).collect()
    }

    /// A base of width `n` with teeth on it: the valleys lie on a line.
    fn comb(n: usize) -> Vec<Vec2> {
        let teeth = (0..=n)
            .rev()
            .map(|x| Vec2::new(x as f32, if x % 2 == 0 { 1.0 } else { 4.0 }));
        [Vec2::ZERO, Vec2::new(n as f32, 0.0)]
            .into_iter()
            .chain(teeth)
            .collect()
    }

    /// A band that winds inwards.
    fn spiral(n: usize) -> Vec<Vec2> {
        let arm = |shift: f32| {
            (0..n).map(move |i| Vec2::from_angle(i as f32 * 0.2) * (40.0 - i as f32 * 0.05 + shift))
        };
        arm(0.0)
            .chain(arm(-0.5).collect::<Vec<_>>().into_iter().rev())
            .collect()
    }

    #[test]
    fn polygons_are_covered_once() {
        for (outline, name) in [
            (star(3, 1, 1.0), "triangle"),
            (star(5, 1, 1.0), "pentagon"),
            (star(1000, 1, 1.0), "circle"),
            (star(10, 2, 0.4), "star"),
            (star(1000, 2, 0.3), "star of 1000"),
            (star(999, 3, 0.1), "star of 999"),
            (square(2), "square with midpoints"),
            (square(250), "square of 1000"),
            (divided(5), "triangle with a divided side"),
            (divided(1000), "triangle of 1000"),
            (comb(7), "comb"),
            (comb(997), "comb of 1000"),
            (spiral(500), "spiral"),
        ] {
            println!("{name}");
            assert_covered_anywhere(&outline, outline.len() - 2);
        }
    }

    /// A square with a square hole, written as one outline through a double edge.
    #[test]
    fn an_outline_with_a_hole_is_covered_once() {
        let outer = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (0.0, 0.0)];
        let hole = [(1.0, 1.0), (1.0, 3.0), (3.0, 3.0), (3.0, 1.0), (1.0, 1.0)];
        let outline: Vec<Vec2> = outer.into_iter().chain(hole).map(Vec2::from).collect();
        assert_covered_anywhere(&outline, outline.len() - 2);
    }

    #[test]
    fn repeated_corners_are_passed_over() {
        for repeat in 0..10 {
            let mut outline = star(10, 2, 0.4);
            outline.insert(repeat, outline[repeat]);
            outline.insert(repeat, outline[repeat]);
            assert_covered_anywhere(&outline, 8);
        }
        assert_covered_anywhere(&[Vec2::ZERO, Vec2::ZERO, Vec2::X, Vec2::Y], 1);
    }

    #[test]
    fn polygons_without_inside_are_told_apart() {
        let mut triangulator = Triangulator::default();
        let mut outcome = |outline: &[[f32; 2]]| {
            let corners: Vec<Vec3> = outline
                .iter()
                .map(|[x, y]| Vec3::new(*x, *y, 1.0))
                .collect();
            (
                triangulator.triangulate(&corners),
                triangulator.triangles.len(),
            )
        };
        assert_eq!(outcome(&[[0.0, 0.0]; 5]), (Outcome::NoArea, 0));
        assert_eq!(
            outcome(&[[0.0, 0.0], [1.0, 1.0], [3.0, 3.0], [2.0, 2.0]]),
            (Outcome::NoArea, 0)
        );
        assert_eq!(
            outcome(&[[0.0, 0.0], [1.0, 1.0], [0.0, 0.0], [1.0, 1.0]]),
            (Outcome::NoArea, 0)
        );
        let bow_tie = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(outcome(&bow_tie), (Outcome::Crossing, 2));
    }
}
