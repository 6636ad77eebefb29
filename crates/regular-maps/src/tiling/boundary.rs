//! The boundary of the domain: its sides in order, and which are glued.
//!
//! In: which sides have their neighbour beside them. Out: [`BoundaryEdge`]s.
//! Holds: partners have the same label and as many sides; arrows lie on each other when they are glued.
//! Source: [Razafindrazaka2015] §9.3, Fig. 9.8.

use super::FlatTiling;
use crate::ids::FlagId;
use crate::map::Reflection;
use std::collections::HashMap;

/// A side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Side {
    /// The flag of the triangle.
    pub flag: FlagId,
    /// The reflection that leads across: the number of the opposite corner.
    pub across: Reflection,
}

/// Consecutive boundary sides that are glued to consecutive boundary sides.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoundaryEdge {
    /// The number that this edge and its partner have in common, from 1 on.
    pub label: u32,
    /// Its sides, the domain to the left of each.
    pub sides: Vec<Side>,
    /// Whether the arrow points along the sides, or against them.
    pub forward: bool,
    /// The edge that it is glued to, tail to tail and head to head, as an index into [`FlatTiling::boundary`].
    pub partner: usize,
    /// Number of the closed curve that it is part of: 0 always where the domain is a disc.
    pub curve: usize,
}

impl FlatTiling {
    /// The corners where a side starts and ends, its triangle to the left.
    pub fn ends(&self, side: Side) -> [usize; 2] {
        let i = side.across as usize;
        let (next, last) = ((i + 1) % 3, (i + 2) % 3);
        if self.is_counter_clockwise(side.flag) { [next, last] } else { [last, next] }
    }

    /// The side that a side is glued to: where they are one in the map.
    pub fn partner(&self, side: Side) -> Side {
        Side { flag: self.map().reflect(side.flag, side.across), across: side.across }
    }

    /// Whether a side and its partner run against each other, as in orientable surfaces all do.
    pub fn is_reversed(&self, side: Side) -> bool {
        self.is_counter_clockwise(side.flag) != self.is_counter_clockwise(self.partner(side).flag)
    }

    /// The closed curves that bound a set of triangles, the triangles to the left.
    ///
    /// # Input      flags: the triangles; joined: whether one goes on across a side of one of them, in both directions
    pub fn outlines(&self, flags: &[FlagId], joined: impl Fn(Side) -> bool) -> Vec<Vec<Side>> {
        let mut met = std::collections::HashSet::new();
        let mut outlines = Vec::new();
        for &flag in flags {
            for across in Reflection::ALL {
                let start = Side { flag, across };
                if joined(start) || met.contains(&start) {
                    continue;
                }
                let mut outline = Vec::new();
                let mut at = start;
                while met.insert(at) {
                    outline.push(at);
                    at = self.following(at, &joined);
                }
                outlines.push(outline);
            }
        }
        outlines
    }

    /// The next side of an outline: around the corner where this one ends, through the triangles that are joined.
    fn following(&self, side: Side, joined: impl Fn(Side) -> bool) -> Side {
        let corner = self.ends(side)[1];
        let mut at = side;
        loop {
            // The triangle's other side at that corner.
            at.across = Reflection::ALL[3 - corner - at.across as usize];
            if !joined(at) {
                return at;
            }
            at = self.partner(at);
        }
    }
}

/// The boundary cut into edges as long as possible.
pub(super) fn boundary_edges(tiling: &FlatTiling) -> Vec<BoundaryEdge> {
    let flags: Vec<_> = tiling.map().flags().collect();
    let curves = tiling.outlines(&flags, |side| tiling.is_adjacent(side.flag, side.across));
    let mut place = HashMap::new();
    for (curve, sides) in curves.iter().enumerate() {
        for (k, &side) in sides.iter().enumerate() {
            place.insert(side, (curve, k));
        }
    }
    let next = |side: Side| {
        let (curve, k) = place[&side];
        curves[curve][(k + 1) % curves[curve].len()]
    };
    // Two sides in a row are one edge just if their partners are in a row, too: the corner between them is then glued
    // to that one corner alone, by the same identification.
    let goes_on = |side: Side| {
        let [a, b] = [side, next(side)].map(|s| tiling.partner(s));
        match (tiling.is_reversed(side), tiling.is_reversed(next(side))) {
            (true, true) => next(b) == a,
            (false, false) => next(a) == b,
            _ => false,
        }
    };
    let mut edges = Vec::new();
    for (curve, sides) in curves.iter().enumerate() {
        let last = sides.len() - 1;
        let first = (0..sides.len()).find(|&k| !goes_on(sides[(k + last) % sides.len()])).unwrap_or(0);
        let sides: Vec<_> = sides[first..].iter().chain(&sides[..first]).copied().collect();
        edges.extend(runs(tiling, &sides, goes_on).into_iter().map(|sides| (curve, sides)));
    }
    labelled(tiling, edges)
}

/// Cuts a closed curve where it does not go on, and before an edge would contain a partner of itself: the boundary of a
/// projective plane is one edge, glued to itself half a turn away.
fn runs(tiling: &FlatTiling, sides: &[Side], goes_on: impl Fn(Side) -> bool) -> Vec<Vec<Side>> {
    let mut runs: Vec<Vec<Side>> = Vec::new();
    for &side in sides {
        match runs.last_mut() {
            Some(run) if goes_on(run[run.len() - 1]) && run[0] != tiling.partner(side) => run.push(side),
            _ => runs.push(vec![side]),
        }
    }
    runs
}

fn labelled(tiling: &FlatTiling, edges: Vec<(usize, Vec<Side>)>) -> Vec<BoundaryEdge> {
    let of: HashMap<Side, usize> =
        edges.iter().enumerate().flat_map(|(i, (_, sides))| sides.iter().map(move |&side| (side, i))).collect();
    let mut labelled: Vec<BoundaryEdge> = Vec::new();
    let mut labels = 0;
    for (i, (curve, sides)) in edges.into_iter().enumerate() {
        let partner = of[&tiling.partner(sides[0])];
        let (label, forward) = match labelled.get(partner) {
            Some(first) => (first.label, !tiling.is_reversed(sides[0])),
            None => {
                labels += 1;
                (labels, true)
            }
        };
        debug_assert!(partner != i);
        labelled.push(BoundaryEdge { label, sides, forward, partner, curve });
    }
    labelled
}
