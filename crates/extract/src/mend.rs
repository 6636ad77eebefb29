//! Opening what folds have left unusable, and cutting polygons into quads.
//!
//! In: a ribbon graph. Out: the graph without the edges that no quad mesh can
//! have. Holds: feature edges stay. Not: the topology, which is compared afterwards. Source: own.

use crate::fill::{MAX_SIDES, quadrangulate};
use crate::ribbon::{NONE, Orbit, Ribbon};
use quadloom_mesh::DVec3;

/// Removes the sides of faces that cannot become quads, loops, and all but one of parallel edges.
///
/// # Output     number of removed edges
/// # Cost       O(n log n)
pub(crate) fn open_bad_faces(ribbon: &mut Ribbon) -> usize {
    let mut doomed = sides_of_bad_faces(ribbon);
    doomed.extend(parallel_edges(ribbon));
    let mut removed = 0;
    for p in doomed {
        if ribbon.is_alive(p) && ribbon.label[p as usize].is_none() {
            ribbon.remove_edge(p, false);
            removed += 1;
        }
    }
    removed
}

fn sides_of_bad_faces(ribbon: &Ribbon) -> Vec<u32> {
    let mut doomed = Vec::new();
    for orbit in ribbon.orbits() {
        let Orbit::Closed(ports) = orbit else { continue };
        let mut vertices: Vec<u32> = ports.iter().map(|&p| ribbon.vertex[p as usize]).collect();
        vertices.sort_unstable();
        let repeated = vertices.windows(2).any(|w| w[0] == w[1]);
        if repeated || ports.len() % 2 != 0 || ports.len() > MAX_SIDES {
            doomed.extend(ports);
        }
    }
    doomed
}

/// Edges that join the same vertices as another one, which is kept: preferably a feature edge, else the first.
fn parallel_edges(ribbon: &Ribbon) -> Vec<u32> {
    let mut edges: Vec<(u32, u32, bool, u32)> = (0..ribbon.len() as u32)
        .filter(|&p| ribbon.is_alive(p) && ribbon.mate[p as usize] != NONE && p < ribbon.mate[p as usize])
        .map(|p| {
            let (a, b) = (ribbon.vertex[p as usize], ribbon.vertex[ribbon.mate[p as usize] as usize]);
            (a.min(b), a.max(b), ribbon.label[p as usize].is_none(), p)
        })
        .collect();
    edges.sort_unstable();
    let mut doomed: Vec<u32> = edges.iter().filter(|e| e.0 == e.1).map(|e| e.3).collect();
    doomed.extend(edges.windows(2).filter(|w| (w[0].0, w[0].1) == (w[1].0, w[1].1)).map(|w| w[1].3));
    doomed
}

/// Cuts closed faces of an even number of sides, more than four, into quads where a cut without double edges exists.
///
/// # Input      position: of each vertex, for the shape of the quads
/// # Output     number of quads made
pub(crate) fn fill_polygons(ribbon: &mut Ribbon, position: impl Fn(u32) -> DVec3) -> usize {
    let mut made = 0;
    for orbit in ribbon.orbits() {
        let Orbit::Closed(ports) = orbit else { continue };
        if ports.len() == 4 {
            continue;
        }
        let vertex: Vec<u32> = ports.iter().map(|&p| ribbon.vertex[p as usize]).collect();
        let corner: Vec<DVec3> = vertex.iter().map(|&v| position(v)).collect();
        let allowed = |i: usize, j: usize| vertex[i] != vertex[j] && !joined(ribbon, ports[i], vertex[j]);
        if let Some(quads) = quadrangulate(&corner, allowed) {
            let n = ports.len();
            let mut diagonals: Vec<[usize; 2]> =
                quads.iter().flat_map(|q| (0..4).map(|k| [q[k], q[(k + 1) % 4]])).collect();
            // Inner sides appear once in each direction; sides of the polygon go one place ahead.
            diagonals.retain(|&[i, j]| i < j && (i + 1) % n != j && (j + 1) % n != i);
            ribbon.add_diagonals(&ports, &diagonals);
            made += quads.len();
        }
    }
    made
}

/// Whether an edge joins the vertex of a port to another vertex.
fn joined(ribbon: &Ribbon, port: u32, other: u32) -> bool {
    let reaches = |p: u32| {
        let mate = ribbon.mate[p as usize];
        mate != NONE && ribbon.vertex[mate as usize] == other
    };
    [Ribbon::clockwise, Ribbon::counter_clockwise].iter().any(|step| {
        let mut around = std::iter::successors(Some(port), |&p| step(ribbon, p).filter(|&q| q != port));
        around.any(reaches)
    })
}
