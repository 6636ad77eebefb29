//! The priority queue of every Dijkstra search of this crate.
//!
//! In: keys with element numbers. Out: the smallest key first. Holds: equal keys leave by element number.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A queue that returns the smallest key first, ties by the smaller number.
#[derive(Debug, Default)]
pub(crate) struct MinHeap {
    heap: BinaryHeap<Item>,
}

#[derive(Clone, Copy, Debug)]
struct Item {
    key: f64,
    id: u32,
}

impl MinHeap {
    pub(crate) fn push(&mut self, key: f64, id: u32) {
        self.heap.push(Item { key, id });
    }

    pub(crate) fn pop(&mut self) -> Option<(f64, u32)> {
        self.heap.pop().map(|item| (item.key, item.id))
    }
}

impl Ord for Item {
    fn cmp(&self, other: &Self) -> Ordering {
        other.key.total_cmp(&self.key).then(other.id.cmp(&self.id))
    }
}
impl PartialOrd for Item {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Item {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Item {}
