//! Places of the parameter plane as linear forms in the map's variables, carried from chart to chart.
//!
//! In: charts. Out: [`Place`] and [`Seams`]. Holds: whatever values the variables of [`crate::problem`] take, a carried
//! place is the same point of the map seen from the other chart.
//! Source: the transition functions of [Bommes2012] §8.4, applied to symbols.

use crate::charts::Charts;
use quadloom_mesh::{HalfEdgeId, HalfEdgeMap, TriConnectivity};

/// Σ coefficient · variable with small integer coefficients, ascending by variable.
pub type Form = Vec<(u32, i32)>;

/// A place in the plane as a linear form per coordinate.
#[derive(Clone, Debug, Default)]
pub(crate) struct Place(pub [Form; 2]);

impl Place {
    /// The place of a parameter node.
    pub fn node(n: u32) -> Self {
        Self([vec![(2 * n, 1)], vec![(2 * n + 1, 1)]])
    }

    /// Turned counter-clockwise about the origin.
    pub fn turned(&self, quarter_turns: u8) -> Self {
        let [u, v] = &self.0;
        Self(match quarter_turns % 4 {
            0 => [u.clone(), v.clone()],
            1 => [negated(v), u.clone()],
            2 => [negated(u), negated(v)],
            _ => [v.clone(), negated(u)],
        })
    }

    /// Number of terms.
    pub fn terms(&self) -> usize {
        self.0[0].len() + self.0[1].len()
    }
}

/// −a.
pub(crate) fn negated(a: &Form) -> Form {
    a.iter().map(|&(i, c)| (i, -c)).collect()
}

/// a + s·b.
pub(crate) fn sum(a: &Form, s: i32, b: &Form) -> Form {
    let (mut out, mut i, mut j) = (Vec::with_capacity(a.len() + b.len()), 0, 0);
    while i < a.len() || j < b.len() {
        let key = a.get(i).map_or(u32::MAX, |t| t.0).min(b.get(j).map_or(u32::MAX, |t| t.0));
        let mut c = 0;
        if i < a.len() && a[i].0 == key {
            c += a[i].1;
            i += 1;
        }
        if j < b.len() && b[j].0 == key {
            c += s * b[j].1;
            j += 1;
        }
        if c != 0 {
            out.push((key, c));
        }
    }
    out
}

/// Which side of which segment each half-edge is.
#[derive(Clone, Debug)]
pub(crate) struct Seams<'a> {
    charts: &'a Charts,
    /// Segment, and whether the half-edge is one of its sides rather than a twin of one.
    side: HalfEdgeMap<Option<(u32, bool)>>,
}

impl<'a> Seams<'a> {
    /// Looks up the sides of all segments.
    pub fn new(mesh: &TriConnectivity, charts: &'a Charts) -> Self {
        let mut side = HalfEdgeMap::filled(mesh.half_edge_count(), None);
        for (s, segment) in charts.segments.iter().enumerate() {
            for &h in &segment.sides {
                side[h] = Some((s as u32, true));
                if let Some(t) = mesh.twin(h) {
                    side[t] = Some((s as u32, false));
                }
            }
        }
        Self { charts, side }
    }

    /// A place seen from the chart across a half-edge; `None` where that is the same chart.
    pub fn crossed(&self, h: HalfEdgeId, place: &Place) -> Option<Place> {
        let (s, forward) = self.side[h]?;
        let turns = self.charts.segments[s as usize].quarter_turns;
        let t = 2 * (self.charts.node_count as u32 + s);
        let moved = |p: &Place, sign: i32| Place([0, 1].map(|k| sum(&p.0[k], sign, &vec![(t + k as u32, 1)])));
        Some(match forward {
            true => moved(&place.turned(turns), 1),
            false => moved(place, -1).turned((4 - turns) % 4),
        })
    }
}
