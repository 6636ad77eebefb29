//! Prescribed indices and index sums: carried to where they are wanted before the search, kept by it.
//!
//! In: sets of vertices with the sum of index wanted in each. Out: period jumps that have it; groups of vertices that
//! may exchange index without changing any sum.
//! Holds: each sum that is reached stays. Not: the least energy; the search follows.
//! Source: [Bommes2012] §8.6, irregular vertices; carrying index over edges instead of solving rows is ours.

use super::Search;
use crate::error::FieldError;
use quadloom_mesh::{EdgeId, Progress, TriConnectivity, VertexId, VertexMap};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Groups of vertices that may exchange index: vertices with the same prescriptions.
pub(crate) fn index_groups<'b>(
    mesh: &TriConnectivity,
    sums: impl Iterator<Item = (&'b [VertexId], i32)>,
) -> VertexMap<u32> {
    let mut prescriptions: VertexMap<Vec<u32>> = VertexMap::filled(mesh.vertex_count(), Vec::new());
    for (number, (list, _)) in sums.enumerate() {
        for &v in list {
            prescriptions[v].push(number as u32);
        }
    }
    let mut known = BTreeMap::from([(Vec::new(), 0u32)]);
    VertexMap::from_fn(mesh.vertex_count(), |v| {
        let next = known.len() as u32;
        *known.entry(std::mem::take(&mut prescriptions[v])).or_insert(next)
    })
}

impl Search<'_> {
    /// Carries index over the border of each prescribed set until its sum is the prescribed one, where that is
    /// cheapest; false where a set has no border to unprescribed vertices.
    pub fn enforce(&mut self, sums: &[(&[VertexId], i32)], progress: &Progress) -> Result<bool, FieldError> {
        for &(list, wanted) in sums {
            loop {
                progress.check()?;
                let excess = list.iter().map(|&v| self.index[v]).sum::<i32>() - wanted;
                if excess == 0 {
                    break;
                }
                let Some(change) = self.cheapest_exit(list, excess.signum()) else { return Ok(false) };
                self.apply(&[change]);
                self.solve();
            }
        }
        Ok(true)
    }

    /// The change of one jump that carries a quarter of the given sign out of a set at the least energy.
    fn cheapest_exit(&mut self, list: &[VertexId], sign: i32) -> Option<(EdgeId, i32)> {
        let mut best: Option<(f64, EdgeId, i32)> = None;
        for &v in list {
            let edges: Vec<EdgeId> = self.mesh.vertex_edges(v).collect();
            for e in edges {
                let [a, b] = self.mesh.ends(e);
                let other = if a == v { b } else { a };
                if self.group[other] != 0 || !self.is_crossable(e) {
                    continue;
                }
                let amount = if a == v { -sign } else { sign };
                let change = self.unit_cost(e) - PI * f64::from(amount) * self.turn[e];
                if best.is_none_or(|(least, known, _)| (change, e) < (least, known)) {
                    best = Some((change, e, amount));
                }
            }
        }
        best.map(|(_, e, amount)| (e, amount))
    }
}
