//! Building the tree: the best plane by the surface-area heuristic over all planes at which a
//! clipped box begins or ends, until no plane pays (Wald & Havran 2006). O(N log N).
//!
//! The tree is a function of the boxes alone: equal costs are decided by axis and position, and
//! threads share nothing.

use super::events::{Event, Events, Side, Splitter, from_order_key};
use super::node::{Node, list_index};
use super::{INTERSECTION_COST, KdTree, MAX_DEPTH, TRAVERSAL_COST, halves};
use crate::accel::progress::{Progress, Task};
use crate::math::Aabb;

/// Factor on the cost of a plane that cuts off empty space (Wald & Havran 2006, §4.1).
const EMPTY_BONUS: f64 = 0.8;

/// Most entries in leaves per primitive over the whole tree, whatever the primitives.
const MAX_REFERENCES: usize = 16;

/// Subtrees of at most so many primitives are built by one thread, without allocation per node.
const SERIAL: usize = 8192;

impl KdTree {
    /// Builds the tree over primitives 0, 1, … with boxes `bounds`; the same tree at any number
    /// of threads. Primitives with an empty box are left out.
    ///
    /// `clip(i, cell)` gives a box around the part of primitive `i` inside `cell`, correct to
    /// within an f32 rounding error of the cell; empty if there is none.
    ///
    /// # Panics
    /// With more than 2³⁰ primitives or nodes.
    pub fn build(bounds: &[Aabb], clip: impl Fn(u32, &Aabb) -> Aabb + Sync) -> Self {
        Self::build_watched(bounds, clip, &Progress::unwatched())
    }

    /// [`Self::build`] whose progress is watched; if it is ended before time, the tree means nothing.
    pub fn build_watched(
        bounds: &[Aabb],
        clip: impl Fn(u32, &Aabb) -> Aabb + Sync,
        progress: &Progress<'_>,
    ) -> Self {
        let events = Events::of_boxes(bounds);
        let root = bounds
            .iter()
            .filter(|b| !b.is_empty())
            .fold(Aabb::EMPTY, |a, b| a.union(*b));
        let count = events.prims.len();
        let levels = 8.0 + 1.3 * (count.max(1) as f64).log2();
        let builder = Builder {
            bounds,
            clip,
            max_depth: (levels as usize).min(MAX_DEPTH),
            progress,
            task: Task::new(count, SERIAL),
        };
        let job = Job {
            cell: root,
            depth: 0,
            budget: count.saturating_mul(MAX_REFERENCES),
        };
        let Subtree { nodes, ids } = builder.subtree(events, job);
        Self {
            bounds: root,
            nodes,
            ids,
        }
    }
}

/// What every part of the build needs to know.
struct Builder<'a, C> {
    bounds: &'a [Aabb],
    clip: C,
    max_depth: usize,
    progress: &'a Progress<'a>,
    task: Task,
}

/// A cell to build a subtree for.
#[derive(Clone, Copy)]
struct Job {
    cell: Aabb,
    depth: usize,
    /// Most entries that all leaves of the subtree may have together.
    budget: usize,
}

/// A plane that divides a cell.
#[derive(Clone, Copy, Debug)]
struct Split {
    axis: usize,
    position: f32,
    /// Where the primitives in the plane go.
    planar_side: Side,
    /// Primitives below and above.
    counts: [usize; 2],
    /// Σ area · primitives over the two sides, with the bonus for empty space.
    weight: f64,
}

/// Nodes with the root first, and the ids their leaves list; indices count from its own start.
struct Subtree {
    nodes: Vec<Node>,
    ids: Vec<u32>,
}

impl<C: Fn(u32, &Aabb) -> Aabb + Sync> Builder<'_, C> {
    /// Builds a large subtree, its halves in parallel.
    fn subtree(&self, events: Events, job: Job) -> Subtree {
        if !self.progress.pass(self.task, events.prims.len()) {
            let nodes = vec![Node::leaf(&[], &mut Vec::new())];
            return Subtree { nodes, ids: vec![] };
        }
        if events.prims.len() <= SERIAL {
            let mut tree = Subtree {
                nodes: vec![Node::leaf(&[], &mut Vec::new())],
                ids: Vec::new(),
            };
            let mut levels = Vec::new();
            levels.resize_with(self.max_depth - job.depth, <[Events; 2]>::default);
            self.fill(
                &mut tree,
                0,
                &events,
                job,
                &mut levels,
                &mut Splitter::default(),
            );
            return tree;
        }
        let Some(split) = self.split(&events, &job) else {
            let mut ids = Vec::new();
            return Subtree {
                nodes: vec![Node::leaf(&events.prims, &mut ids)],
                ids,
            };
        };
        let [mut below, mut above] = <[Events; 2]>::default();
        self.divide(
            &events,
            &job,
            &split,
            &mut Splitter::default(),
            [&mut below, &mut above],
        );
        drop(events);
        let [job_below, job_above] = job.children(&split);
        let (below, above) = rayon::join(
            || self.subtree(below, job_below),
            || self.subtree(above, job_above),
        );
        Subtree::join(&split, below, above)
    }

    /// Builds the subtree of `job` into `tree`, with its root at `slot`. Each level below has
    /// its buffers in `levels`.
    fn fill(
        &self,
        tree: &mut Subtree,
        slot: usize,
        events: &Events,
        job: Job,
        levels: &mut [[Events; 2]],
        splitter: &mut Splitter,
    ) {
        let (Some(split), Some(([below, above], levels))) =
            (self.split(events, &job), levels.split_first_mut())
        else {
            tree.nodes[slot] = Node::leaf(&events.prims, &mut tree.ids);
            return;
        };
        self.divide(events, &job, &split, splitter, [below, above]);
        let child = tree.nodes.len();
        tree.nodes[slot] = Node::inner(split.axis, split.position, list_index(child));
        tree.nodes.extend([tree.nodes[slot]; 2]);
        let [job_below, job_above] = job.children(&split);
        self.fill(tree, child, below, job_below, levels, splitter);
        self.fill(tree, child + 1, above, job_above, levels, splitter);
    }

    /// The plane to divide a cell at, unless it had better be a leaf.
    fn split(&self, events: &Events, job: &Job) -> Option<Split> {
        if job.depth == self.max_depth || events.prims.is_empty() {
            return None;
        }
        let split = best_split(events, &job.cell)?;
        (split.counts[0] + split.counts[1] <= job.budget).then_some(split)
    }

    /// Distributes a cell's events over its two children.
    fn divide(
        &self,
        events: &Events,
        job: &Job,
        split: &Split,
        splitter: &mut Splitter,
        children: [&mut Events; 2],
    ) {
        let cells = halves(&job.cell, split.axis, split.position);
        let clip = |id: u32| {
            let clipped = cells.map(|cell| {
                let part = (self.clip)(id, &cell);
                if part.is_empty() {
                    return Aabb::EMPTY;
                }
                // Clamped, not intersected: a box that rounding put outside stays, flat.
                Aabb {
                    min: part.min.clamp(cell.min, cell.max),
                    max: part.max.clamp(cell.min, cell.max),
                }
            });
            if clipped.iter().all(Aabb::is_empty) {
                // It is somewhere in the cell; rounding must not lose it on both sides.
                cells.map(|cell| self.bounds[id as usize].intersection(cell))
            } else {
                clipped
            }
        };
        splitter.split(
            events,
            split.axis,
            split.position,
            split.planar_side,
            clip,
            children,
        );
    }
}

impl Job {
    /// The two children's jobs; the budget is shared out in proportion to their primitives.
    fn children(&self, split: &Split) -> [Self; 2] {
        let [below, above] = split.counts;
        let spare = self.budget - (below + above);
        let share = below as f64 / (below + above) as f64;
        let spare_below = ((spare as f64 * share) as usize).min(spare);
        let budgets = [below + spare_below, above + (spare - spare_below)];
        let cells = halves(&self.cell, split.axis, split.position);
        [0, 1].map(|i| Self {
            cell: cells[i],
            depth: self.depth + 1,
            budget: budgets[i],
        })
    }
}

impl Subtree {
    /// A tree of one inner node over two subtrees.
    fn join(split: &Split, below: Self, above: Self) -> Self {
        let mut nodes = Vec::with_capacity(1 + below.nodes.len() + above.nodes.len());
        nodes.push(Node::inner(split.axis, split.position, 1));
        // The two roots, then the rest of each: what was at index i > 0 moves on by this much.
        let offsets = [(2, 0), (1 + below.nodes.len(), below.ids.len())];
        nodes.push(below.nodes[0].moved(offsets[0].0, offsets[0].1));
        nodes.push(above.nodes[0].moved(offsets[1].0, offsets[1].1));
        for (tree, (n, i)) in [&below, &above].into_iter().zip(offsets) {
            nodes.extend(tree.nodes[1..].iter().map(|node| node.moved(n, i)));
        }
        let mut ids = below.ids;
        ids.extend_from_slice(&above.ids);
        Self { nodes, ids }
    }
}

/// The plane of least cost; none if a leaf costs no more.
fn best_split(events: &Events, cell: &Aabb) -> Option<Split> {
    let n = events.prims.len();
    let extent = (cell.max.as_dvec3() - cell.min.as_dvec3()).to_array();
    let mut best: Option<Split> = None;
    let mut area = 0.0;
    for axis in 0..3 {
        let [u, v] = [extent[(axis + 1) % 3], extent[(axis + 2) % 3]];
        let slab = Slab {
            min: cell.min[axis],
            max: cell.max[axis],
            face: u * v,
            rim: u + v,
        };
        area = slab.area(slab.min, slab.max);
        if let Some(split) = slab.sweep(axis, &events.axes[axis], n)
            && best.is_none_or(|b| split.weight < b.weight)
        {
            best = Some(split);
        }
    }
    // Multiplied by the area, which may be 0; a NaN or an infinite cost compares as false.
    let leaf_cost = INTERSECTION_COST * n as f64 * area;
    best.filter(|b| TRAVERSAL_COST * area + INTERSECTION_COST * b.weight < leaf_cost)
}

/// A cell along one axis, with half its area as a linear function of its length.
struct Slab {
    min: f32,
    max: f32,
    face: f64,
    rim: f64,
}

impl Slab {
    fn area(&self, min: f32, max: f32) -> f64 {
        self.face + self.rim * (f64::from(max) - f64::from(min))
    }

    /// The best plane strictly inside the slab for the events of `n` primitives.
    fn sweep(&self, axis: usize, events: &[Event], n: usize) -> Option<Split> {
        let (mut best, mut least) = (None, f64::INFINITY);
        let (mut below, mut above) = (0, n);
        let mut rest = events;
        while let [first, ..] = rest {
            let key = first.key();
            let mut count = [0; 3];
            while let [event, tail @ ..] = rest
                && event.key() == key
            {
                count[event.kind() as usize] += 1;
                rest = tail;
            }
            let [ends, planar, starts] = count;
            above -= ends + planar;
            let position = from_order_key(key);
            if self.min < position && position < self.max {
                let areas = [self.area(self.min, position), self.area(position, self.max)];
                let mut consider = |counts: [usize; 2], planar_side| {
                    let bonus = if counts.contains(&0) {
                        EMPTY_BONUS
                    } else {
                        1.0
                    };
                    let sum = areas[0] * counts[0] as f64 + areas[1] * counts[1] as f64;
                    let weight = bonus * sum;
                    if weight < least {
                        least = weight;
                        best = Some(Split {
                            axis,
                            position,
                            planar_side,
                            counts,
                            weight,
                        });
                    }
                };
                consider([below + planar, above], Side::Below);
                if planar > 0 {
                    consider([below, above + planar], Side::Above);
                }
            }
            below += planar + starts;
        }
        debug_assert_eq!((below, above), (n, 0));
        best
    }
}
