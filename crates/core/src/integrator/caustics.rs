//! What camera paths keep for the sake of caustics.

use glam::Vec3;

use super::{Kind, Path};
use crate::geometry::SurfacePoint;
use crate::math::Ray;

/// No anchor.
const NONE: u32 = u32::MAX;

/// A diffuse surface that a camera path has come to by way of mirror and glass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    pub point: SurfacePoint,
    /// The primitive that does not hide it.
    pub prim: u32,
    /// Unit normal on the path's side.
    pub n: Vec3,
    /// Throughput of the path, times f.
    pub f: Vec3,
    pub diffuse_share: f32,
    pub bounce: u32,
}

/// Which probes a path or branch sends. A probe sends one more and that one none, or in a room of varnish,
/// where each surface is an anchor and shows others, their number would double at each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sends {
    /// One from each anchor.
    FromEach,
    /// One, from the next anchor.
    One,
    Nothing,
}

/// What the paths of a wave keep, if caustics are traced; empty if they are not. Their branches
/// (`vertices::branches`, and the probes of `vertices::anchors`) are numbered after all paths.
#[derive(Debug, Default)]
pub(super) struct Caustics {
    /// Of each path and branch: [`Transport::light_share`](super::Transport::light_share) of its first
    /// surface, 0 if it did not go on from there diffusely; but see `vertices::anchors`.
    pub light_shares: Vec<f32>,
    /// Of each: the bounce at its own last anchor, or [`NONE`], and, if it sends probes from there, how many for
    /// each time that it goes on itself.
    anchored: Vec<(u32, Option<f32>)>,
    /// Of each: which probes it sends.
    sends: Vec<Sends>,
    /// Of each branch, the path.
    owners: Vec<u32>,
    /// All anchors, and for each the one of the same path before, or [`NONE`].
    anchors: Vec<(Anchor, u32)>,
    /// Of each path, the last anchor, its branches' included, or [`NONE`].
    last: Vec<u32>,
    /// Probes and branches that are not on their way yet, by the numbers of those that have sent them.
    pub probes: Vec<(Path, Ray)>,
    pub branches: Vec<(Path, Ray)>,
}

impl Caustics {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.light_shares.clear();
        self.anchored.clear();
        self.sends.clear();
        self.owners.clear();
        self.anchors.clear();
        self.last.clear();
        self.probes.clear();
        self.branches.clear();
    }

    /// Makes ready for a number of paths.
    pub fn begin(&mut self, paths: usize) {
        self.clear();
        self.last.resize(paths, NONE);
        self.resize(paths);
    }

    fn resize(&mut self, count: usize) {
        self.light_shares.resize(count, 0.0);
        self.anchored.resize(count, (NONE, None));
        self.sends.resize(count, Sends::FromEach);
    }

    /// Whether caustics are traced.
    #[inline(always)]
    pub fn are_traced(&self) -> bool {
        !self.light_shares.is_empty()
    }

    /// Number of paths and branches.
    pub fn count(&self) -> usize {
        self.light_shares.len()
    }

    /// Sends probes and branches on their way, with numbers of their own. All probes come first, so that
    /// the order of those of one path does not depend on the other paths of the wave.
    pub fn send(&mut self, paths: &mut Vec<Path>, rays: &mut Vec<Ray>) {
        let mut probes = std::mem::take(&mut self.probes);
        let mut branches = std::mem::take(&mut self.branches);
        for (path, ray) in probes.drain(..).chain(branches.drain(..)) {
            let (sender, index) = (path.index as usize, self.count());
            self.owners.push(self.owner(path.index));
            self.resize(index + 1);
            if path.kind == Kind::Probe {
                self.anchored[index] = self.anchored[sender];
                self.sends[index] = match self.sends[sender] {
                    Sends::FromEach => Sends::One,
                    Sends::One | Sends::Nothing => Sends::Nothing,
                };
            }
            let index = index as u32;
            paths.push(Path { index, ..path });
            rays.push(ray);
        }
        (self.probes, self.branches) = (probes, branches);
    }

    /// The path of a path or branch.
    #[inline(always)]
    pub fn owner(&self, index: u32) -> u32 {
        let branch = (index as usize).checked_sub(self.last.len());
        let owner = branch.and_then(|branch| self.owners.get(branch));
        owner.copied().unwrap_or(index)
    }

    /// Adds what branches have found to their paths; `radiance` keeps those only.
    pub fn join_branches(&self, radiance: &mut Vec<Vec3>) {
        if self.owners.is_empty() {
            return;
        }
        let branches = radiance.split_off(self.last.len());
        for (owner, found) in self.owners.iter().zip(branches) {
            radiance[*owner as usize] += found;
        }
    }

    /// Adds an anchor of a path or branch. Whether it sends probes from there, so many for each time that it goes on
    /// itself.
    pub fn anchor(&mut self, index: u32, anchor: Anchor, probes: f32) -> bool {
        let i = index as usize;
        let sends = self.sends[i] != Sends::Nothing;
        self.anchored[i] = (anchor.bounce, sends.then_some(probes));
        if self.sends[i] == Sends::One {
            self.sends[i] = Sends::Nothing;
        }
        let owner = self.owner(index) as usize;
        let before = std::mem::replace(&mut self.last[owner], self.anchors.len() as u32);
        self.anchors.push((anchor, before));
        sends
    }

    /// The anchors of a path and its branches, the last first.
    #[inline(always)]
    pub fn anchors_of(&self, path: u32) -> impl Iterator<Item = &Anchor> {
        let at = |i: &u32| self.anchors.get(*i as usize);
        let last = self.last.get(path as usize).and_then(at);
        std::iter::successors(last, move |(_, before)| at(before)).map(|(anchor, _)| anchor)
    }

    /// Whether a path or branch has dropped an anchor at a bounce or later.
    #[inline(always)]
    pub fn is_anchored_since(&self, index: u32, bounce: u32) -> bool {
        let (last, _) = self.anchored[index as usize];
        last != NONE && last >= bounce
    }

    /// How many probes a path or branch has sent from an anchor at a bounce or later, for each time that it went on
    /// itself.
    #[inline(always)]
    pub fn probes_since(&self, index: u32, bounce: u32) -> Option<f32> {
        let (_, probes) = self.anchored[index as usize];
        probes.filter(|_| self.is_anchored_since(index, bounce))
    }

    /// Whether a path or branch has met nothing diffuse from which it may find a caustic.
    #[inline(always)]
    pub fn is_untouched(&self, index: u32) -> bool {
        let i = index as usize;
        self.anchored[i].0 == NONE && self.light_shares[i] == 0.0
    }
}
