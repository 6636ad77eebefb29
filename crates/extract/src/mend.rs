//! Opening what folds have left unusable, so that it can be cut into quads anew.
//!
//! In: a ribbon graph, and which vertex each port belongs to. Out: the graph without the edges that no quad mesh can
//! have. Holds: feature edges stay. Not: the topology, which is compared afterwards. Source: own.

use crate::fill::MAX_SIDES;
use crate::ribbon::{NONE, Orbit, Ribbon};

/// Removes the sides of faces that cannot become quads, loops, and all but one of parallel edges.
///
/// # Output     number of removed edges
/// # Cost       O(n log n)
pub(crate) fn open_bad_faces(ribbon: &mut Ribbon, vertex_of: impl Fn(u32) -> u32) -> usize {
    let mut doomed = sides_of_bad_faces(ribbon, &vertex_of);
    doomed.extend(parallel_edges(ribbon, &vertex_of));
    let mut removed = 0;
    for p in doomed {
        if ribbon.is_alive(p) && ribbon.label[p as usize].is_none() {
            ribbon.remove_edge(p, false);
            removed += 1;
        }
    }
    removed
}

fn sides_of_bad_faces(ribbon: &Ribbon, vertex_of: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut doomed = Vec::new();
    for orbit in ribbon.orbits() {
        let Orbit::Closed(ports) = orbit else { continue };
        let mut vertices: Vec<u32> = ports.iter().map(|&p| vertex_of(p)).collect();
        vertices.sort_unstable();
        let repeated = vertices.windows(2).any(|w| w[0] == w[1]);
        if repeated || ports.len() % 2 != 0 || ports.len() > MAX_SIDES {
            doomed.extend(ports);
        }
    }
    doomed
}

/// Edges that join the same vertices as another one, which is kept: preferably a feature edge, else the first.
fn parallel_edges(ribbon: &Ribbon, vertex_of: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut edges: Vec<(u32, u32, bool, u32)> = (0..ribbon.len() as u32)
        .filter(|&p| ribbon.is_alive(p) && ribbon.mate[p as usize] != NONE && p < ribbon.mate[p as usize])
        .map(|p| {
            let (a, b) = (vertex_of(p), vertex_of(ribbon.mate[p as usize]));
            (a.min(b), a.max(b), ribbon.label[p as usize].is_none(), p)
        })
        .collect();
    edges.sort_unstable();
    let mut doomed: Vec<u32> = edges.iter().filter(|e| e.0 == e.1).map(|e| e.3).collect();
    doomed.extend(edges.windows(2).filter(|w| (w[0].0, w[0].1) == (w[1].0, w[1].1)).map(|w| w[1].3));
    doomed
}
