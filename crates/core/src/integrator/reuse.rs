//! Paths that are reused by others (Bekaert, Sbert & Halton 2002, Accelerating Path Tracing by
//! Re-Using Paths): what the second of two diffuse surfaces of a path reflects is light for the first
//! surfaces of other pixels' paths too, at the price of a ray that tells whether they see it.
//!
//! The first surface of a path is the first diffuse one, seen directly or by way of mirror and
//! glass; the second is what it comes to next. Paths of a group share if their first surfaces are
//! equally many segments from the camera, so that depth means the same to all. Each first surface
//! could have sent its path to the second surface y of any other: there are as many densities for
//! it as first surfaces that see y, and each of them has been sampled once. The balance heuristic over
//! them all (Veach & Guibas 1995) leaves for the first surface i, of the path j that came to y,
//! throughput_i · g_i / Σ_k g_k · L_j, with g_k = cos θ_k cos θ'_k / |y − x_k|² where k sees y, else 0, L_j what
//! y reflects, and θ and θ' the angles at x_k and at y.
//!
//! What a path runs into at its second surface, light of the lamp, is its own, and so is all that
//! was found along the path where its second surface is not diffuse.

use glam::Vec3;

use super::Transport;
use crate::geometry::{SurfacePoint, segment};
use crate::math::{Ray, Vectors};
use crate::planted::{self, Bug};
use crate::simd::{Lanes, Task};

/// About so many rays are cast together.
const RAYS: usize = 4096;

/// Most paths of a group.
pub(crate) const MOST: usize = 16;

/// Largest share, in units of the own one: sums stay finite.
const MOST_SHARE: f32 = 1e30;

/// Cosines below are next to nothing but rounding.
const GRAZING: f32 = 4.0 * f32::EPSILON;

/// A surface of a path: the point, and the unit normal on the path's side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub point: SurfacePoint,
    pub n: Vec3,
}

/// The first two surfaces of a path that may be shared.
#[derive(Clone, Copy, Debug)]
struct Joint {
    /// The bounce at the first.
    bounce: u32,
    first: Surface,
    second: Surface,
    /// Primitive id of the second.
    prim: u32,
}

/// How far a path may be shared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bond {
    /// Not at all: it has come to no first surface.
    None,
    /// Its first surface may take light from others.
    Takes,
    /// Its second surface may also give.
    Gives,
}

/// What paths of a wave have to share. Empty if they do not.
#[derive(Debug, Default)]
pub(super) struct Reuse {
    /// Where each group ends.
    ends: Vec<u32>,
    bonds: Vec<Bond>,
    joints: Vec<Joint>,
    /// Of each path, the throughput up to its first surface, with which it does not go on; or 1.
    heads: Vec<Vec3>,
    /// Light found from the second surface on, but for the light of lamps run into there.
    pub later: Vec<Vec3>,
    connections: Vec<Connection>,
    shares: Vec<f32>,
}

/// A ray from a first surface to the second of another path.
#[derive(Clone, Copy, Debug)]
struct Connection {
    ray: Ray,
    prim: u32,
    /// Where its share is.
    share: u32,
}

impl Reuse {
    /// Whether paths are shared at all.
    #[inline(always)]
    pub fn is_on(&self) -> bool {
        !self.bonds.is_empty()
    }

    /// Whether any group was told.
    pub fn has_groups(&self) -> bool {
        !self.ends.is_empty()
    }

    pub fn clear(&mut self) {
        self.ends.clear();
        self.bonds.clear();
        self.heads.clear();
        self.later.clear();
    }

    /// Ends a group of paths, `count` in all up to now.
    pub fn end_group(&mut self, count: usize) {
        self.ends.push(count as u32);
    }

    /// Makes ready for so many paths in all; those after all groups take from none and give to none.
    pub fn extend(&mut self, count: usize) {
        const NOWHERE: Surface = Surface {
            point: SurfacePoint {
                p: Vec3::ZERO,
                n: Vec3::ZERO,
                surface: [0.0; 2],
            },
            n: Vec3::ZERO,
        };
        self.bonds.resize(count, Bond::None);
        self.heads.resize(count, Vec3::ONE);
        self.later.resize(count, Vec3::ZERO);
        // Those of the wave before stay where they are not overwritten: no bond leads to them.
        let nowhere = Joint {
            bounce: 0,
            first: NOWHERE,
            second: NOWHERE,
            prim: 0,
        };
        self.joints.resize(self.joints.len().max(count), nowhere);
    }

    /// Whether a path has come to no first surface.
    #[inline(always)]
    pub fn is_unbound(&self, index: u32) -> bool {
        self.bonds[index as usize] == Bond::None
    }

    /// A path goes on diffusely from its first surface, at some bounce, where it leaves its throughput.
    #[inline(always)]
    pub fn leaves(&mut self, index: u32, bounce: u32, first: Surface, throughput: Vec3) {
        let i = index as usize;
        self.bonds[i] = Bond::Takes;
        self.heads[i] = throughput;
        (self.joints[i].bounce, self.joints[i].first) = (bounce, first);
    }

    /// A path goes on from a diffuse surface at some bounce, which it shares with nobody, with its throughput.
    #[inline(always)]
    pub fn stays(&mut self, index: u32, bounce: u32) {
        self.bonds[index as usize] = Bond::Takes;
        self.joints[index as usize].bounce = bounce;
    }

    /// A path has come to a diffuse surface at some bounce.
    #[inline(always)]
    pub fn arrives(&mut self, index: u32, bounce: u32, second: Surface, prim: u32) {
        let i = index as usize;
        if self.bonds[i] == Bond::Takes && bounce == self.joints[i].bounce + 1 {
            self.bonds[i] = Bond::Gives;
            (self.joints[i].second, self.joints[i].prim) = (second, prim);
        }
    }

    /// Segments from the first surface of a path to the one at a bounce; 0 up to the first.
    #[inline(always)]
    fn since(&self, i: usize, bounce: u32) -> u32 {
        if self.bonds[i] == Bond::None {
            0
        } else {
            bounce - self.joints[i].bounce
        }
    }

    /// A path has run into light at a bounce, dimmed by its throughput, which is its `own` or not.
    #[inline(always)]
    pub fn meets(
        &mut self,
        radiance: &mut [Vec3],
        index: u32,
        bounce: u32,
        light: Vec3,
        is_own: bool,
    ) {
        let i = index as usize;
        if !self.is_on() {
            radiance[i] += light;
        } else if is_own || self.since(i, bounce) < 2 {
            radiance[i] += self.heads[i] * light;
        } else {
            self.later[i] += light;
        }
    }

    /// Where light counts at which a path has aimed at a bounce.
    #[inline(always)]
    pub fn aimed<'a>(
        &'a mut self,
        radiance: &'a mut [Vec3],
        index: u32,
        bounce: u32,
    ) -> &'a mut Vec3 {
        let i = index as usize;
        if self.is_on() && self.since(i, bounce) > 0 {
            &mut self.later[i]
        } else {
            &mut radiance[i]
        }
    }

    /// What the throughput of a path lacks.
    #[inline(always)]
    pub fn head(&self, index: u32) -> Vec3 {
        self.heads.get(index as usize).copied().unwrap_or(Vec3::ONE)
    }

    /// Light of all paths, channels summed, as if nothing were shared.
    pub fn light(&self) -> f64 {
        let later = self.heads.iter().zip(&self.later);
        later.map(|(a, l)| f64::from((a * l).element_sum())).sum()
    }

    /// Adds the later light to the `radiance` of the paths and of those that share it. Returns the
    /// number of rays cast.
    pub fn share(&mut self, transport: &Transport<'_>, radiance: &mut [Vec3]) -> u64 {
        let (mut begin, mut from, mut rays) = (0, 0, 0);
        self.connections.clear();
        self.shares.clear();
        let ends = std::mem::take(&mut self.ends);
        for (g, &end) in ends.iter().enumerate() {
            let group = begin..end as usize;
            transport.scene.geometry().kernel().run(Connect {
                reuse: self,
                group: group.clone(),
            });
            begin = group.end;
            if self.connections.len() > RAYS - MOST * MOST || g + 1 == ends.len() {
                rays += self.connections.len() as u64;
                self.cast(transport);
                let mut shares = 0;
                for group in groups(&ends, from, g + 1) {
                    shares = self.settle(group, shares, radiance);
                }
                from = g + 1;
                self.connections.clear();
                self.shares.clear();
            }
        }
        for (i, later) in self.later.iter().enumerate().skip(begin) {
            radiance[i] += self.heads[i] * *later;
        }
        self.ends = ends;
        rays
    }

    /// Takes the shares of those who do not see what they would share.
    fn cast(&mut self, transport: &Transport<'_>) {
        let (connections, shares) = (&self.connections, &mut self.shares);
        transport.scene.geometry().occluded_many(
            connections,
            |connection| (connection.ray, connection.prim),
            |i, shaded| {
                if shaded && !planted::has(Bug::ReusedUnseen) {
                    shares[connections[i].share as usize] = 0.0;
                }
            },
        );
    }

    /// Paths of a group that have come to a first surface, in order.
    #[inline(always)]
    fn members(&self, group: std::ops::Range<usize>) -> impl Iterator<Item = usize> + Clone {
        group.filter(|i| self.bonds[*i] != Bond::None)
    }

    #[inline(always)]
    fn gives(&self, i: usize) -> bool {
        self.bonds[i] == Bond::Gives && self.later[i] != Vec3::ZERO
    }

    /// Adds the light of a group to the radiance of its paths; the shares of the group begin at
    /// `shares`. Returns where they end.
    fn settle(
        &self,
        group: std::ops::Range<usize>,
        mut shares: usize,
        radiance: &mut [Vec3],
    ) -> usize {
        let takers = self.members(group.clone());
        let count = takers.clone().count();
        for j in group {
            let later = self.later[j];
            if !self.gives(j) {
                radiance[j] += self.heads[j] * later;
                continue;
            }
            let row = &self.shares[shares..shares + count];
            shares += count;
            let all = row.iter().sum::<f32>();
            for (i, share) in takers.clone().zip(row) {
                // The quotient first: it is 1 at most, whatever the light and however small the share.
                radiance[i] += self.heads[i] * (later * (share / all));
            }
        }
        shares
    }
}

/// How far a point may be off its surface.
#[inline(always)]
fn error(point: &SurfacePoint) -> f32 {
    let [low, high] = point.surface;
    high.abs().max(low.abs())
}

/// The groups from one on, up to another, by where each ends.
fn groups(ends: &[u32], from: usize, to: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
    (from..to).map(|g| {
        let begin = g.checked_sub(1).map_or(0, |before| ends[before]);
        begin as usize..ends[g] as usize
    })
}

/// Finds the shares of a group as if nothing stood between, and the rays that will tell.
struct Connect<'a> {
    reuse: &'a mut Reuse,
    group: std::ops::Range<usize>,
}

impl Task for Connect<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { reuse, group } = self;
        let (mut points, mut normals) = (Vectors::default(), Vectors::default());
        let (mut origins, mut errors) = (Vectors::default(), [0.0; MOST]);
        let (mut dirs, mut distances) = (Vectors::default(), [0.0; MOST]);
        let mut shares = [0.0; MOST];
        let (mut own, mut bounces) = ([usize::MAX; MOST], [u32::MAX; MOST]);
        let mut count = 0;
        for i in reuse.members(group.clone()) {
            let Surface { point, n } = reuse.joints[i].first;
            points.set(count, point.p);
            normals.set(count, n);
            origins.set(count, point.leave(n));
            errors[count] = error(&point);
            (own[count], bounces[count]) = (i, reuse.joints[i].bounce);
            count += 1;
        }
        for j in group {
            if !reuse.gives(j) {
                continue;
            }
            let Joint {
                bounce,
                first,
                second,
                prim,
            } = reuse.joints[j];
            let unit = (second.point.p - first.point.p).length_squared();
            // Whoever sees it sees it from there, and it him.
            let end = second.point.leave(second.n);
            for lane in 0..MOST {
                let n = normals.get(lane);
                let d = second.point.p - points.get(lane);
                let square = d.length_squared();
                let toward = d / square.sqrt();
                // Rounding must not have what lies in one plane see itself.
                let least = GRAZING * square.sqrt() + errors[lane] + error(&second.point);
                let heights = n.dot(d).min(-second.n.dot(d));
                let at_second = if planted::has(Bug::ReusedCosineDropped) {
                    1.0
                } else {
                    -second.n.dot(toward)
                };
                let share = n.dot(toward) * at_second * (unit / square);
                let sees = (heights > least) & (share > 0.0) & (bounces[lane] == bounce);
                shares[lane] = if sees { share.min(MOST_SHARE) } else { 0.0 };
                let ray = segment(origins.get(lane), end);
                dirs.set(lane, ray.dir);
                distances[lane] = ray.t_max;
            }
            for lane in 0..count {
                let share = reuse.shares.len() as u32;
                let is_own = own[lane] == j;
                // Its own path has come there, whatever rounding says.
                let least = if is_own { f32::MIN_POSITIVE } else { 0.0 };
                reuse.shares.push(shares[lane].max(least));
                if shares[lane] > 0.0 && !is_own {
                    let ray = Ray {
                        origin: origins.get(lane),
                        dir: dirs.get(lane),
                        t_max: distances[lane],
                    };
                    reuse.connections.push(Connection { ray, prim, share });
                }
            }
        }
    }
}
