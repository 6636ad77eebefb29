//! Lines of equal distance.
//!
//! In: a distance per vertex (of a mesh as fine as the lines are wanted, see [`crate::refine`]), values. Out:
//! polylines whose points lie on edges. Holds: a line is closed, or ends at the boundary or where distances are
//! infinite; distances rise to its left. Not: exact between vertices; it is that of the linear interpolant.

use crate::error::GeodesicError;
use quadloom_mesh::{EdgeId, HalfEdgeId, TriConnectivity, VertexMap};
use std::collections::BTreeMap;

/// Most lines that are made of one field: more cannot be told apart in any picture.
pub const MOST_VALUES: usize = 100_000;

/// A line of equal distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Isoline {
    /// Its distance, file units.
    pub value: f64,
    /// Where it crosses edges: the edge, and the fraction from the origin of its canonical half-edge.
    pub points: Vec<(EdgeId, f64)>,
    /// Whether it closes; the first point is not repeated.
    pub is_closed: bool,
}

/// The values `spacing`, 2·`spacing`, … below the largest finite distance.
///
/// # Errors     a spacing that is not above 0, or so small that there are more than [`MOST_VALUES`]
pub fn spaced(distance: &VertexMap<f64>, spacing: f64) -> Result<Vec<f64>, GeodesicError> {
    let most = distance.values().iter().copied().filter(|d| d.is_finite()).fold(0.0, f64::max);
    if !(spacing > 0.0 && most / spacing <= MOST_VALUES as f64) {
        let range = "above 0 and at least a hundred-thousandth of the largest distance";
        return Err(GeodesicError::Option { what: "the spacing of isolines", range, value: spacing });
    }
    Ok((1..).map(|k| f64::from(k) * spacing).take_while(|&v| v < most).collect())
}

/// Lines of equal distance of the linear interpolant of vertex distances.
///
/// # Input      distance per vertex; values, file units, any order
/// # Output     value by value; lines in the order of their first edges, open ones first
/// # Cost       linear per value
pub fn isolines(mesh: &TriConnectivity, distance: &VertexMap<f64>, values: &[f64]) -> Vec<Isoline> {
    let mut sorted: Vec<f64> = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    // 1. The faces that each value crosses, each by the half-edge through which the line leaves it.
    let mut exits: Vec<BTreeMap<EdgeId, (HalfEdgeId, HalfEdgeId)>> = vec![BTreeMap::new(); sorted.len()];
    for face in mesh.faces() {
        let d = mesh.face_vertices(face).map(|v| distance[v]);
        if d.iter().any(|d| !d.is_finite()) {
            continue;
        }
        let (least, most) = (d[0].min(d[1]).min(d[2]), d[0].max(d[1]).max(d[2]));
        let from = sorted.partition_point(|&v| v <= least);
        let to = sorted.partition_point(|&v| v <= most);
        for k in from..to {
            // Above to the left: enters where the side falls, leaves where it rises.
            let above = d.map(|d| d >= sorted[k]);
            let sides = mesh.face_half_edges(face);
            let enters = (0..3).find(|&i| above[i] && !above[(i + 1) % 3]);
            let leaves = (0..3).find(|&i| !above[i] && above[(i + 1) % 3]);
            if let (Some(i), Some(j)) = (enters, leaves) {
                exits[k].insert(mesh.edge(sides[i]), (sides[i], sides[j]));
            }
        }
    }
    // 2. Chains.
    sorted.iter().zip(exits).flat_map(|(&value, steps)| chains(mesh, distance, value, steps)).collect()
}

/// Joins the steps of one value to lines.
fn chains(
    mesh: &TriConnectivity,
    distance: &VertexMap<f64>,
    value: f64,
    mut steps: BTreeMap<EdgeId, (HalfEdgeId, HalfEdgeId)>,
) -> Vec<Isoline> {
    let point = |e: EdgeId| {
        let [a, b] = mesh.ends(e).map(|v| distance[v]);
        (e, if a == b { 0.5 } else { ((value - a) / (b - a)).clamp(0.0, 1.0) })
    };
    let arrivals: std::collections::BTreeSet<EdgeId> = steps.values().map(|&(_, out)| mesh.edge(out)).collect();
    let starts: Vec<EdgeId> = steps.keys().copied().filter(|e| !arrivals.contains(e)).collect();
    let mut lines = Vec::new();
    let mut follow = |first: EdgeId, steps: &mut BTreeMap<EdgeId, (HalfEdgeId, HalfEdgeId)>| {
        let mut points = vec![point(first)];
        let mut at = first;
        while let Some((_, out)) = steps.remove(&at) {
            at = mesh.edge(out);
            if at == first {
                lines.push(Isoline { value, points, is_closed: true });
                return;
            }
            points.push(point(at));
        }
        lines.push(Isoline { value, points, is_closed: false });
    };
    for first in starts {
        follow(first, &mut steps);
    }
    while let Some(&first) = steps.keys().next() {
        follow(first, &mut steps);
    }
    lines
}
