//! Which loops separate: homology classes of edges with two coefficients.
//!
//! In: a connected cut surface. Out: [`Classes`]: a number per edge, such that the exclusive or of the numbers along a
//! loop tells its class in H₁(C; ℤ₂); and a system of shortest loops at a root.
//! Holds: a loop whose number is not 0 does not separate (capped) or is no boundary (bordered), for certain. The
//! converse is exact for up to 64 independent loops; beyond, classes are random projections to 64 bits, and one that is
//! not 0 is taken for 0 with probability 2⁻⁶⁴.
//! Source: tree and co-tree [Eppstein2003], the greedy system of loops [Erickson2005].
//!
//! The class of an edge says which closed curves of the dual graph it crosses. A simple loop separates C if and only if
//! it crosses every closed dual curve an even number of times; dual curves that may begin and end at borders tell
//! classes of borders too.

use crate::cut_surface::{CutSurface, NONE};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Whether dual curves may end at borders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Borders {
    /// Every border is closed by a cap: borders have class 0.
    Capped,
    /// Borders have classes of their own, with sum 0.
    Kept,
}

/// Classes of a component's edges.
pub(crate) struct Classes {
    /// By half-edge; both of an edge have the same.
    pub class: Vec<u64>,
    /// Half-edges that close the shortest independent loops at the root, shortest first.
    pub closing: Vec<u32>,
    /// By vertex: its parent in the shortest-path tree of the root, and the half-edge to it.
    pub parent: Vec<(u32, u32)>,
}

/// What an edge counts for trees if no cut may run there: as much as all others together.
const BARRIER: u64 = 1 << 62;
/// Longer distances count as this one; only paths across barriers are that long.
const FARTHEST: u64 = u64::MAX - 1;

/// Classes, trees and closing edges of the component of `root`.
///
/// # Input      forced: edges that have to be among the closing ones, where that is possible
/// # Cost       O(n log n)
pub(crate) fn classes(s: &CutSurface, units: &[u64], root: u32, borders: Borders, forced: &[u32]) -> Classes {
    let tree = Tree::grow(s, units, root);
    // 1. Nodes of the dual graph: faces, then caps of borders.
    let cap = caps(s, &tree.reached, borders);
    let nodes = s.side.len() + cap.count;
    let across = |h: u32| match s.twin[h as usize] {
        NONE => s.side.len() as u32 + cap.of[h as usize],
        t => s.face[t as usize],
    };
    // 2. A spanning tree of it that crosses edges which would close long loops ([Erickson2005]).
    let mut loops: Vec<(u64, u32)> = Vec::new();
    for h in 0..s.next.len() as u32 {
        let t = s.twin[h as usize];
        let (a, b) = (s.origin[h as usize], s.target(h));
        if (t != NONE && t < h) || tree.distance[a as usize] == u64::MAX || tree.uses(s, h) {
            continue;
        }
        let cost = cost_of(s, units, h).min(BARRIER);
        let length = tree.distance[a as usize].saturating_add(tree.distance[b as usize]).saturating_add(cost);
        loops.push((length, h));
    }
    loops.sort_unstable_by_key(|&(length, h)| (Reverse(length), h));
    let is_forced =
        |h: u32| forced.contains(&h) || (s.twin[h as usize] != NONE && forced.contains(&s.twin[h as usize]));
    let mut union = Union::new(nodes);
    let (mut dual, mut closing) = (Vec::new(), Vec::new());
    for &(length, h) in &loops {
        if is_forced(h) || !union.join(s.face[h as usize], across(h)) {
            closing.push((length, h));
        } else {
            dual.push(h);
        }
    }
    closing.sort_unstable();
    let closing: Vec<u32> = closing.into_iter().map(|(_, h)| h).collect();
    // 3. The closed dual curve of each closing edge, summed up the dual tree.
    let class = sum_up(s, nodes, &dual, &closing, across);
    Classes { class, closing, parent: tree.parent }
}

/// Cost of an edge of the cut surface, units.
#[inline]
pub(crate) fn cost_of(s: &CutSurface, units: &[u64], h: u32) -> u64 {
    match s.span[h as usize] {
        NONE => 0,
        e => units[e as usize],
    }
}

struct Tree {
    distance: Vec<u64>,
    parent: Vec<(u32, u32)>,
    reached: Vec<u32>,
}

impl Tree {
    fn grow(s: &CutSurface, units: &[u64], root: u32) -> Self {
        let n = s.vertex_count();
        let mut tree =
            Self { distance: vec![u64::MAX; n], parent: vec![(NONE, NONE); n], reached: Vec::with_capacity(n) };
        tree.distance[root as usize] = 0;
        let mut heap = BinaryHeap::from([Reverse((0u64, root))]);
        while let Some(Reverse((d, v))) = heap.pop() {
            if d > tree.distance[v as usize] {
                continue;
            }
            tree.reached.push(v);
            s.for_edges(v, |h, w| {
                let through = d.saturating_add(cost_of(s, units, h).min(BARRIER)).min(FARTHEST);
                if through < tree.distance[w as usize] {
                    tree.distance[w as usize] = through;
                    tree.parent[w as usize] = (v, h);
                    heap.push(Reverse((through, w)));
                }
            });
        }
        tree
    }

    /// Whether the tree runs along an edge.
    fn uses(&self, s: &CutSurface, h: u32) -> bool {
        let t = s.twin[h as usize];
        let along = |v: u32| {
            let via = self.parent[v as usize].1;
            via != NONE && (via == h || via == t)
        };
        along(s.origin[h as usize]) || along(s.target(h))
    }
}

struct Caps {
    of: Vec<u32>,
    count: usize,
}

/// A number per border, or one for all.
fn caps(s: &CutSurface, reached: &[u32], borders: Borders) -> Caps {
    let mut of = vec![NONE; s.next.len()];
    let mut count = 0;
    for &v in reached {
        let start = s.out[v as usize];
        if !s.is_border(start) || of[start as usize] != NONE {
            continue;
        }
        let mut h = start;
        while of[h as usize] == NONE {
            of[h as usize] = count;
            h = s.next_border(h);
        }
        if borders == Borders::Capped {
            count += 1;
        }
    }
    let any = borders == Borders::Kept && of.iter().any(|&c| c != NONE);
    Caps { of, count: count as usize + usize::from(any) }
}

struct Union {
    up: Vec<u32>,
}

impl Union {
    fn new(n: usize) -> Self {
        Self { up: (0..n as u32).collect() }
    }
    fn root(&mut self, mut i: u32) -> u32 {
        while self.up[i as usize] != i {
            self.up[i as usize] = self.up[self.up[i as usize] as usize];
            i = self.up[i as usize];
        }
        i
    }
    /// Joins two sets; false if they were one.
    fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.up[a.max(b) as usize] = a.min(b);
        a != b
    }
}

/// The number of the `k`-th of `count` independent dual curves: a bit of its own, or a random word.
fn word(k: usize, count: usize) -> u64 {
    if count <= 64 {
        return 1 << k;
    }
    let mut x = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// For every edge the sum of the numbers of the dual curves that cross it.
fn sum_up(s: &CutSurface, nodes: usize, dual: &[u32], closing: &[u32], across: impl Fn(u32) -> u32) -> Vec<u64> {
    let mut class = vec![0u64; s.next.len()];
    let mut sum = vec![0u64; nodes];
    let both = |class: &mut Vec<u64>, h: u32, value: u64| {
        class[h as usize] = value;
        if let Some(c) = class.get_mut(s.twin[h as usize] as usize) {
            *c = value;
        }
    };
    for (k, &h) in closing.iter().enumerate() {
        let value = word(k, closing.len());
        both(&mut class, h, value);
        sum[s.face[h as usize] as usize] ^= value;
        sum[across(h) as usize] ^= value;
    }
    // Leaves of the dual tree first: what is left of a subtree leaves it through its last edge.
    let mut degree = vec![0u32; nodes];
    // The exclusive or of a node's edges is its last one when all others are done.
    let mut edges = vec![0u64; nodes];
    for &h in dual {
        for node in [s.face[h as usize], across(h)] {
            degree[node as usize] += 1;
            edges[node as usize] ^= u64::from(h);
        }
    }
    let mut leaves: Vec<u32> = (0..nodes as u32).filter(|&n| degree[n as usize] == 1).collect();
    while let Some(node) = leaves.pop() {
        if degree[node as usize] != 1 {
            continue;
        }
        let h = edges[node as usize] as u32;
        let value = sum[node as usize];
        both(&mut class, h, value);
        let (a, b) = (s.face[h as usize], across(h));
        let other = if a == node { b } else { a };
        degree[node as usize] = 0;
        sum[other as usize] ^= value;
        edges[other as usize] ^= u64::from(h);
        degree[other as usize] -= 1;
        if degree[other as usize] == 1 {
            leaves.push(other);
        }
    }
    class
}
