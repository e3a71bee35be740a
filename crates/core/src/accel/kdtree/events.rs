//! Where primitives begin and end along each axis, in order: what the surface-area heuristic is
//! swept over. Sorted once, then only filtered and merged (Wald & Havran 2006, On building fast
//! kd-trees for ray tracing, and on doing that in O(N log N), §4.3).

use rayon::prelude::*;

use crate::math::Aabb;

/// Bits of an event that hold the primitive.
const PRIM_BITS: u32 = 30;

/// Most primitives that events can tell apart.
pub(super) const MAX_PRIMS: usize = 1 << PRIM_BITS;

const PRIM_MASK: u64 = MAX_PRIMS as u64 - 1;

/// What happens to a primitive at an event, in the order of a sweep at one position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum EventKind {
    /// Its box ends.
    End,
    /// Its box, flat on this axis, begins and ends.
    Planar,
    /// Its box begins.
    Start,
}

/// An event in one integer whose order is that of (position, kind, primitive): total, so that
/// the sorted list depends on nothing else. The primitive is an index into [`Events::prims`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Event(u64);

impl Event {
    const ZERO: Self = Self(0);

    fn new(position: f32, kind: EventKind, prim: usize) -> Self {
        debug_assert!(prim < MAX_PRIMS);
        Self(u64::from(order_key(position)) << 32 | (kind as u64) << PRIM_BITS | prim as u64)
    }

    /// Order-preserving integer of the position.
    #[inline(always)]
    pub fn key(self) -> u32 {
        (self.0 >> 32) as u32
    }

    /// See [`EventKind`].
    #[inline(always)]
    pub fn kind(self) -> EventKind {
        match (self.0 >> PRIM_BITS) & 3 {
            0 => EventKind::End,
            1 => EventKind::Planar,
            _ => EventKind::Start,
        }
    }

    /// The primitive, as an index into [`Events::prims`].
    #[inline(always)]
    pub fn prim(self) -> usize {
        (self.0 & PRIM_MASK) as usize
    }

    #[inline(always)]
    fn with_prim(self, prim: u32) -> Self {
        Self(self.0 & !PRIM_MASK | u64::from(prim))
    }
}

/// Integer in the order of the floats, with −0 counted as +0.
pub(super) fn order_key(x: f32) -> u32 {
    let bits = (x + 0.0).to_bits();
    if bits >> 31 == 1 {
        !bits
    } else {
        bits | 1 << 31
    }
}

/// Inverse of [`order_key`].
#[inline(always)]
pub(super) fn from_order_key(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 {
        key & !(1 << 31)
    } else {
        !key
    })
}

/// Side of a split on which a primitive lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// Not above the plane.
    Below,
    /// Not below the plane.
    Above,
    /// On both sides: its events are made anew from its clipped boxes.
    Both,
}

/// The primitives of a cell and their events.
#[derive(Debug, Default)]
pub(super) struct Events {
    /// Ids, ascending.
    pub prims: Vec<u32>,
    /// Events by axis, ascending.
    pub axes: [Vec<Event>; 3],
}

impl Events {
    /// Sorted events of all boxes that are not empty.
    pub fn of_boxes(bounds: &[Aabb]) -> Self {
        assert!(bounds.len() <= MAX_PRIMS, "kd-tree: too many primitives");
        let prims: Vec<u32> = (0..bounds.len() as u32)
            .filter(|&id| !bounds[id as usize].is_empty())
            .collect();
        let axes = [0, 1, 2].map(|axis| {
            let mut events = Vec::with_capacity(2 * prims.len());
            for (prim, &id) in prims.iter().enumerate() {
                let Aabb { min, max } = bounds[id as usize];
                push_extent(&mut events, min[axis], max[axis], prim);
            }
            events.par_sort_unstable();
            events
        });
        Self { prims, axes }
    }

    fn clear(&mut self) {
        self.prims.clear();
        self.axes.iter_mut().for_each(Vec::clear);
    }
}

fn push_extent(events: &mut Vec<Event>, min: f32, max: f32, prim: usize) {
    if min == max {
        events.push(Event::new(min, EventKind::Planar, prim));
    } else {
        events.push(Event::new(min, EventKind::Start, prim));
        events.push(Event::new(max, EventKind::End, prim));
    }
}

/// Distributes the events of a cell over its two children. Holds buffers for reuse.
#[derive(Debug, Default)]
pub(super) struct Splitter {
    /// Side of each primitive.
    sides: Vec<Side>,
    /// For primitives on one side only, the index among that side's primitives and the side in
    /// the lowest bit; [`IN_BOTH`] for the others.
    moves: Vec<u32>,
    /// New events of the primitives on both sides, by side and axis.
    fresh: [[Vec<Event>; 3]; 2],
}

const IN_BOTH: u32 = u32::MAX;

impl Splitter {
    /// Splits `events` at `split` on `axis`, with primitives in the plane on `planar_side`, into
    /// `children` (below, above). `clip(id)` gives the boxes of a primitive's part on either
    /// side; an empty box leaves it out there.
    pub fn split(
        &mut self,
        events: &Events,
        axis: usize,
        split: f32,
        planar_side: Side,
        clip: impl Fn(u32) -> [Aabb; 2],
        [below, above]: [&mut Events; 2],
    ) {
        below.clear();
        above.clear();
        self.classify(events, axis, split, planar_side);
        self.assign(events, clip, [below, above]);
        for axis in 0..3 {
            distribute(
                &events.axes[axis],
                &self.moves,
                [&mut below.axes[axis], &mut above.axes[axis]],
            );
            for (side, child) in [&mut *below, &mut *above].into_iter().enumerate() {
                let fresh = &mut self.fresh[side][axis];
                fresh.sort_unstable();
                merge(&mut child.axes[axis], fresh);
                fresh.clear();
            }
        }
    }

    /// Finds the side of every primitive.
    fn classify(&mut self, events: &Events, axis: usize, split: f32, planar_side: Side) {
        self.sides.clear();
        self.sides.resize(events.prims.len(), Side::Both);
        let key = order_key(split);
        for event in &events.axes[axis] {
            let side = &mut self.sides[event.prim()];
            match event.kind() {
                EventKind::End if event.key() <= key => *side = Side::Below,
                EventKind::Start if event.key() >= key => *side = Side::Above,
                EventKind::Planar => {
                    *side = match event.key().cmp(&key) {
                        std::cmp::Ordering::Less => Side::Below,
                        std::cmp::Ordering::Equal => planar_side,
                        std::cmp::Ordering::Greater => Side::Above,
                    }
                }
                EventKind::End | EventKind::Start => {}
            }
        }
    }

    /// Gives every primitive its index among each child's primitives, and those on both sides
    /// their new events.
    fn assign(
        &mut self,
        events: &Events,
        clip: impl Fn(u32) -> [Aabb; 2],
        children: [&mut Events; 2],
    ) {
        self.moves.clear();
        for (&id, &side) in events.prims.iter().zip(&self.sides) {
            let target = match side {
                Side::Below => 0,
                Side::Above => 1,
                Side::Both => {
                    for (side, clipped) in clip(id).into_iter().enumerate() {
                        if !clipped.is_empty() {
                            let prims = &mut children[side].prims;
                            for axis in 0..3 {
                                push_extent(
                                    &mut self.fresh[side][axis],
                                    clipped.min[axis],
                                    clipped.max[axis],
                                    prims.len(),
                                );
                            }
                            prims.push(id);
                        }
                    }
                    self.moves.push(IN_BOTH);
                    continue;
                }
            };
            let prims = &mut children[target].prims;
            self.moves.push((prims.len() as u32) << 1 | target as u32);
            prims.push(id);
        }
    }
}

/// Copies each event to the list of its primitive's side. Without branches: every event is
/// written to both lists, and only the right one's end moves on.
fn distribute(events: &[Event], moves: &[u32], children: [&mut Vec<Event>; 2]) {
    let [below, above] = children;
    below.resize(events.len(), Event::ZERO);
    above.resize(events.len(), Event::ZERO);
    let (mut n_below, mut n_above) = (0, 0);
    for event in events {
        let to = moves[event.prim()];
        let moved = event.with_prim(to >> 1);
        below[n_below] = moved;
        above[n_above] = moved;
        n_below += usize::from(to & 1 == 0);
        n_above += usize::from(to & 1 == 1 && to != IN_BOTH);
    }
    below.truncate(n_below);
    above.truncate(n_above);
}

/// Merges sorted `fresh` into sorted `events`, from the back.
fn merge(events: &mut Vec<Event>, fresh: &[Event]) {
    let mut old = events.len();
    let mut end = old + fresh.len();
    events.resize(end, Event::ZERO);
    for &event in fresh.iter().rev() {
        while old > 0 && events[old - 1] > event {
            old -= 1;
            end -= 1;
            events[end] = events[old];
        }
        end -= 1;
        events[end] = event;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_keep_the_order_of_floats_and_come_back() {
        let floats = [
            f32::NEG_INFINITY,
            f32::MIN,
            -1.5,
            -1e-45,
            0.0,
            1e-45,
            1.0,
            f32::MAX,
            f32::INFINITY,
        ];
        for pair in floats.windows(2) {
            assert!(order_key(pair[0]) < order_key(pair[1]), "{pair:?}");
        }
        for x in floats {
            assert_eq!(from_order_key(order_key(x)).to_bits(), x.to_bits());
        }
        assert_eq!(order_key(-0.0), order_key(0.0));
    }

    #[test]
    fn events_at_one_position_sort_as_end_planar_start() {
        let mut events = [EventKind::Start, EventKind::Planar, EventKind::End]
            .map(|kind| Event::new(-2.5, kind, 7));
        events.sort_unstable();
        let kinds = events.map(Event::kind);
        assert_eq!(kinds, [EventKind::End, EventKind::Planar, EventKind::Start]);
        assert!(
            events
                .iter()
                .all(|e| e.prim() == 7 && from_order_key(e.key()) == -2.5)
        );
    }
}
