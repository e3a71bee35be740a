//! Tree nodes of 8 bytes.

/// Tag of a leaf, where an inner node has its axis.
const LEAF: u32 = 3;

/// Largest number that fits beside the 2-bit tag.
const PACKED_MAX: u32 = u32::MAX >> 2;

/// An inner node or a leaf.
///
/// | | `word` | `tagged >> 2` | `tagged & 3` |
/// |---|---|---|---|
/// | inner | split plane, bits of an f32 | index of the child below; the one above is next to it | axis |
/// | leaf with 1 primitive | its id | 1 | 3 |
/// | leaf with n ≠ 1 primitives | index of the first in the tree's id list | n | 3 |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Node {
    word: u32,
    tagged: u32,
}

/// A node taken apart.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// Children `below` and `below + 1`, on either side of the plane.
    Inner { axis: usize, split: f32, below: u32 },
    /// `count` primitives; `word` as in [`Node`].
    Leaf { word: u32, count: u32 },
}

/// Panics rather than losing bits.
fn packed(value: u32, tag: u32) -> u32 {
    assert!(
        value <= PACKED_MAX,
        "kd-tree: {value} does not fit into a node"
    );
    value << 2 | tag
}

impl Node {
    /// An inner node.
    pub fn inner(axis: usize, split: f32, below: u32) -> Self {
        debug_assert!(axis < 3);
        Self {
            word: split.to_bits(),
            tagged: packed(below, axis as u32),
        }
    }

    /// A leaf of `ids`, which are appended to the tree's list unless the node can hold them.
    pub fn leaf(ids: &[u32], list: &mut Vec<u32>) -> Self {
        let word = match *ids {
            [id] => id,
            _ => {
                let first = list_index(list.len());
                list.extend_from_slice(ids);
                first
            }
        };
        Self {
            word,
            tagged: packed(list_index(ids.len()), LEAF),
        }
    }

    /// The same node after its subtree was appended behind `nodes` nodes and `ids` ids.
    pub fn moved(self, nodes: usize, ids: usize) -> Self {
        match self.kind() {
            Kind::Inner { axis, split, below } => {
                Self::inner(axis, split, list_index(below as usize + nodes))
            }
            Kind::Leaf { count: 1, .. } => self,
            Kind::Leaf { word, .. } => Self {
                word: list_index(word as usize + ids),
                ..self
            },
        }
    }

    /// Takes the node apart.
    #[inline(always)]
    pub fn kind(self) -> Kind {
        let Self { word, tagged } = self;
        match tagged & 3 {
            LEAF => Kind::Leaf {
                word,
                count: tagged >> 2,
            },
            axis => Kind::Inner {
                axis: axis as usize,
                split: f32::from_bits(word),
                below: tagged >> 2,
            },
        }
    }
}

/// An index as the nodes store it; panics rather than losing bits.
pub(super) fn list_index(index: usize) -> u32 {
    match u32::try_from(index) {
        Ok(index) => index,
        Err(_) => panic!("kd-tree: index {index} does not fit into 32 bits"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_come_back_from_their_packing() {
        assert_eq!(size_of::<Node>(), 8);
        for axis in 0..3 {
            for below in [1, 2, 12345, PACKED_MAX] {
                for split in [0.0, -0.0, 1.5, f32::MIN, f32::MIN_POSITIVE] {
                    let Kind::Inner {
                        axis: a,
                        split: s,
                        below: b,
                    } = Node::inner(axis, split, below).kind()
                    else {
                        panic!("not an inner node");
                    };
                    assert_eq!(
                        (a, s.to_bits(), b),
                        (axis, split.to_bits(), below),
                        "{axis} {split} {below}"
                    );
                }
            }
        }
        let mut list = vec![9];
        for (ids, expected) in [
            (&[][..], (1, 0)),
            (&[7], (7, 1)),
            (&[4, 5], (1, 2)),
            (&[6, 7, 8], (3, 3)),
        ] {
            let Kind::Leaf { word, count } = Node::leaf(ids, &mut list).kind() else {
                panic!("not a leaf");
            };
            assert_eq!((word, count), expected);
        }
        assert_eq!(list, [9, 4, 5, 6, 7, 8]);
    }

    #[test]
    #[should_panic(expected = "does not fit")]
    fn packing_never_loses_bits() {
        Node::inner(0, 0.0, PACKED_MAX + 1);
    }
}
