//! Where caustics come from: which way to look, from a place on a diffuse surface, for light that
//! comes by way of mirror and glass (Jensen 1995, Importance Driven Path Tracing Using the Photon
//! Map).
//!
//! Light that was followed from the lamps has left marks where it fell, which know where on the last
//! mirror or glass it came from. A tree sorts them by place, some dozen to a leaf. From a place, a
//! direction is drawn towards where a mark of its leaf came from, or thereabouts: as wide as the leaf's
//! next few marks came from, in a spherical Cauchy distribution (Kato & McCullagh 2020), which is
//! nowhere 0.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3;

use crate::math::{Aabb, Frame};

/// Most marks of a leaf.
const LEAF: usize = 32;

/// How many of a leaf's marks came from within the width of one.
const NEAR: usize = 4;

/// Bounds on half a squared width, seen from a place: below, f32 does not tell directions apart; above,
/// a mark is as near as its neighbours and says little.
const WIDTH: (f32, f32) = (1e-8, 2.0);

/// Where light that came by way of mirror or glass has met a diffuse surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mark {
    /// The place.
    pub p: Vec3,
    /// Where on the mirror or glass it came from.
    pub from: Vec3,
    /// How much light, in any unit.
    pub weight: f32,
}

/// Marks side by side; lanes that are not in use have no weight.
#[derive(Clone, Debug)]
struct Leaf {
    from: [[f32; LEAF]; 3],
    /// Half the squared width.
    width: [f32; LEAF],
    /// Share of the leaf's light.
    weight: [f32; LEAF],
}

/// A node of the tree of leaves.
#[derive(Clone, Copy, Debug)]
enum Node {
    /// What lies below `at` on an axis is in the next node, the rest in node `above`.
    Split {
        axis: usize,
        at: f32,
        above: usize,
    },
    Leaf(usize),
}

/// A guide to caustics.
#[derive(Debug)]
pub(crate) struct Guide {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

impl Guide {
    /// Sorts marks into leaves; `None` if there are none.
    pub fn new(mut marks: Vec<Mark>) -> Option<Self> {
        marks.retain(|mark| mark.weight > 0.0 && mark.weight < f32::INFINITY);
        let mut guide = Self {
            nodes: Vec::new(),
            leaves: Vec::new(),
        };
        (!marks.is_empty()).then(|| {
            guide.divide(&mut marks);
            guide
        })
    }

    fn divide(&mut self, marks: &mut [Mark]) {
        let extent = Aabb::of_points(marks.iter().map(|mark| mark.p)).extent();
        let axis = extent.max_position();
        let node = self.nodes.len();
        self.nodes.push(Node::Leaf(self.leaves.len()));
        if marks.len() <= LEAF || !(extent[axis] > 0.0) {
            self.leaves.push(Leaf::of(&marks[..marks.len().min(LEAF)]));
            return;
        }
        marks.sort_unstable_by(|a, b| a.p[axis].total_cmp(&b.p[axis]));
        // Places on a plane across the axis stay together.
        let median = marks[marks.len() / 2].p[axis];
        let middle = match marks.partition_point(|mark| mark.p[axis] < median) {
            0 => marks.partition_point(|mark| mark.p[axis] <= median),
            middle => middle,
        };
        let at = 0.5 * (marks[middle - 1].p[axis] + marks[middle].p[axis]);
        let (below, above) = marks.split_at_mut(middle);
        self.divide(below);
        let next = self.nodes.len();
        self.divide(above);
        self.nodes[node] = Node::Split {
            axis,
            at,
            above: next,
        };
    }

    #[inline(always)]
    fn leaf(&self, p: Vec3) -> &Leaf {
        let mut node = 0;
        loop {
            match self.nodes[node] {
                Node::Split { axis, at, .. } if p[axis] < at => node += 1,
                Node::Split { above, .. } => node = above,
                Node::Leaf(leaf) => return &self.leaves[leaf],
            }
        }
    }

    /// A direction to look in from `p`, and its density per solid angle. `None` if rounding leaves none.
    #[inline(always)]
    pub fn sample(&self, p: Vec3, pick: f32, u: [f32; 2]) -> Option<(Vec3, f32)> {
        let leaf = self.leaf(p);
        let dir = leaf.sample(p, pick, u);
        dir.is_finite().then(|| (dir, leaf.pdf(p, dir)))
    }

    /// Density per solid angle with which [`Self::sample`] draws `dir` at `p`.
    #[inline(always)]
    pub fn pdf(&self, p: Vec3, dir: Vec3) -> f32 {
        self.leaf(p).pdf(p, dir)
    }
}

impl Leaf {
    fn of(marks: &[Mark]) -> Self {
        let mut leaf = Self {
            from: [[0.0; LEAF]; 3],
            width: [1.0; LEAF],
            weight: [0.0; LEAF],
        };
        let all: f32 = marks.iter().map(|mark| mark.weight).sum();
        for (i, mark) in marks.iter().enumerate() {
            for axis in 0..3 {
                leaf.from[axis][i] = mark.from[axis];
            }
            leaf.weight[i] = mark.weight / all;
            let square = |other: &Mark| other.from.distance_squared(mark.from);
            let mut squares: Vec<f32> = marks.iter().map(square).collect();
            squares.sort_by(f32::total_cmp);
            leaf.width[i] = 0.5 * squares[NEAR.min(squares.len() - 1)];
        }
        leaf
    }

    /// The direction from `p` to where a mark came from, and half its squared width.
    #[inline(always)]
    fn lobe(&self, mark: usize, p: Vec3) -> (Vec3, f32) {
        let [x, y, z] = &self.from;
        let way = Vec3::new(x[mark], y[mark], z[mark]) - p;
        let square = way.length_squared().max(f32::MIN_POSITIVE);
        let width = (self.width[mark] / square).clamp(WIDTH.0, WIDTH.1);
        (way / square.sqrt(), width)
    }

    #[inline(always)]
    fn sample(&self, p: Vec3, pick: f32, [u, v]: [f32; 2]) -> Vec3 {
        let (mut mark, mut below) = (0, self.weight[0]);
        while pick >= below && mark + 1 < LEAF && self.weight[mark + 1] > 0.0 {
            mark += 1;
            below += self.weight[mark];
        }
        let (axis, s) = self.lobe(mark, p);
        // 1 − cos of the angle to the axis: all but u of the distribution lies beyond.
        let t = 2.0 * u * s / (s + 2.0 - 2.0 * u);
        let sin = (t * (2.0 - t)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = libm::sincosf(TAU * v);
        let local = Vec3::new(sin * cos_phi, sin * sin_phi, 1.0 - t);
        Frame::around(axis).world_from_local(local).normalize()
    }

    #[inline(always)]
    fn pdf(&self, p: Vec3, dir: Vec3) -> f32 {
        // Eight sums side by side, then always in this order: the same bits on any machine.
        let mut sums = [0.0; 8];
        for first in (0..LEAF).step_by(sums.len()) {
            for (i, sum) in sums.iter_mut().enumerate() {
                let (axis, s) = self.lobe(first + i, p);
                // 1 − cos of the angle between them, without cancellation.
                let t = 0.5 * (dir - axis).length_squared();
                *sum += self.weight[first + i] * (s * (s + 2.0)) / ((s + t) * (s + t));
            }
        }
        let [a, b, c, d, e, f, g, h] = sums;
        (((a + b) + (c + d)) + ((e + f) + (g + h))) * (0.25 * FRAC_1_PI)
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::sampler::{Dim, Sampler};
    use crate::settings::SamplerKind;

    /// Marks on a floor and a wall, with light from around one place or two.
    fn marks(count: u64) -> Vec<Mark> {
        let mark = |i: u64| {
            let sampler = Sampler::new(SamplerKind::Sobol, 1, [0; 2], 2 * i);
            let [x, y] = sampler.get_2d(Dim::Pixel);
            let [a, b] = sampler.get_2d(Dim::BsdfDirection(0));
            let from = Vec3::new(0.5 + 0.1 * a, 0.6 + 0.1 * b, 0.4);
            Mark {
                p: match i % 3 {
                    0 => Vec3::new(x, 0.0, y),
                    1 => Vec3::new(0.1 * x, 0.0, y),
                    _ => Vec3::new(0.0, x, y),
                },
                from: if i.is_multiple_of(2) {
                    from
                } else {
                    from + Vec3::X
                },
                weight: 0.5 + a,
            }
        };
        (0..count).map(mark).collect()
    }

    /// Densities add up to one over the sphere, and what is drawn has the mean direction that
    /// its density says, with few marks and many, near the mirror and far.
    #[test]
    fn densities_are_those_of_the_directions_drawn() {
        for count in [1, 3, 40, 1000] {
            let guide = Guide::new(marks(count)).expect("marks");
            for p in [
                Vec3::ZERO,
                Vec3::new(0.3, 0.0, 0.7),
                Vec3::new(0.5, 0.5, 0.38),
            ] {
                let (mut integral, mut expected, mut drawn) = (0.0, Vec3::ZERO, Vec3::ZERO);
                let n = 1 << 17;
                for i in 0..n {
                    let sampler = Sampler::new(SamplerKind::Sobol, 7, [0; 2], 2 * i);
                    let pick = sampler.get_1d(Dim::Lobe(0));
                    let u = sampler.get_2d(Dim::LightPoint(0));
                    let (dir, pdf) = guide.sample(p, pick, u).expect("a direction");
                    assert!((dir.length() - 1.0).abs() < 1e-6);
                    assert!((pdf - guide.pdf(p, dir)).abs() <= 1e-6 * pdf);
                    drawn += dir / n as f32;
                    // Half of the directions told by the guide itself, or narrow lobes were missed.
                    let [x, y] = sampler.get_2d(Dim::Pixel);
                    let z = 2.0 * x - 1.0;
                    let (sin, cos) = libm::sincosf(TAU * y);
                    let r = (1.0 - z * z).max(0.0).sqrt();
                    let uniform = Vec3::new(r * cos, r * sin, z);
                    for dir in [dir, uniform] {
                        let pdf = guide.pdf(p, dir);
                        let by = pdf + 0.5 / TAU;
                        integral += f64::from(pdf / by) / n as f64;
                        expected += dir * (pdf / by) / n as f32;
                    }
                }
                assert!((integral - 1.0).abs() < 0.01, "{count} {p}: {integral}");
                let off = expected.distance(drawn);
                assert!(off < 0.01, "{count} {p}: {expected} {drawn}");
            }
        }
    }

    /// Most directions lead near to where marks of the place came from, and marks of a plane are not
    /// torn apart from places on it.
    #[test]
    fn directions_lead_where_light_came_from() {
        let floor = |i: u64| {
            let sampler = Sampler::new(SamplerKind::Sobol, 1, [0; 2], 2 * i);
            let [x, y] = sampler.get_2d(Dim::Pixel);
            // A fifth floats above the floor, and is lit from the side.
            let is_floating = i.is_multiple_of(5);
            let height = if is_floating {
                0.4 * sampler.get_1d(Dim::Lobe(0))
            } else {
                0.0
            };
            let from = if is_floating {
                [x + 1.0, 0.0, y]
            } else {
                [x, 0.5, y]
            };
            Mark {
                p: Vec3::new(x, height, y),
                from: from.into(),
                weight: 1.0,
            }
        };
        let guide = Guide::new((0..4000).map(floor).collect()).expect("marks");
        let mut near = 0;
        for i in 0..1000 {
            let sampler = Sampler::new(SamplerKind::Sobol, 2, [0; 2], 2 * i);
            let [x, z] = sampler.get_2d(Dim::Pixel);
            let u = sampler.get_2d(Dim::LightPoint(0));
            let (dir, _) = guide
                .sample(Vec3::new(x, 0.0, z), sampler.get_1d(Dim::Lobe(0)), u)
                .expect("a direction");
            near += u32::from(dir.y > 0.9);
        }
        assert!(near > 850, "{near}");
    }

    #[test]
    fn marks_at_one_place_or_none() {
        assert!(Guide::new(Vec::new()).is_none());
        let same = vec![marks(1)[0]; 100];
        let guide = Guide::new(same).expect("marks");
        let (dir, pdf) = guide
            .sample(Vec3::ZERO, 0.999, [0.5; 2])
            .expect("a direction");
        assert!(dir.is_finite() && pdf > 0.0);
    }
}
