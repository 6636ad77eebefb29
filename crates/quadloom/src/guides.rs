//! Drawn curves become runs of mesh edges.
//!
//! In: a mesh and polylines near it. Out: edges, and warnings about curves that they cannot follow. Holds: consecutive
//! points of a curve are joined by a path of edges if their component joins them. Not: closeness beyond the resolution
//! of the mesh.
//! Source: shortest paths [Dijkstra1959] with edges weighted by their distance from the curve.

use crate::error::{Warning, WarningCode};
use quadloom_mesh::closest::closest_parameter;
use quadloom_mesh::features::other_end;
use quadloom_mesh::{ClosestPoint, DVec3, EdgeId, TriMesh, VertexId, VertexMap};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// How much longer an edge counts per its own length of distance from the curve.
///
/// 0 gives shortest paths that leave the curve; far more than 10 gives zigzags along it.
const DISTANCE_WEIGHT: f64 = 8.0;

/// Edges along the curves, ascending, without repetition.
pub fn trace_guides(mesh: &TriMesh, guides: &[Vec<DVec3>]) -> Vec<EdgeId> {
    let mut edges = Vec::new();
    for guide in guides {
        let stops: Vec<Option<VertexId>> = guide.iter().map(|&p| nearest_vertex(mesh, p)).collect();
        for (pair, ends) in stops.windows(2).zip(guide.windows(2)) {
            if let [Some(a), Some(b)] = *pair {
                edges.extend(path(mesh, a, b, [ends[0], ends[1]]));
            }
        }
    }
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// Whether all points of a curve are nearest to one vertex, so that no edge is along it.
pub fn is_at_one_vertex(mesh: &TriMesh, guide: &[DVec3]) -> bool {
    let mut stops = guide.iter().map(|&p| nearest_vertex(mesh, p));
    stops.next().is_none_or(|first| stops.all(|stop| stop == first))
}

/// Distance of a drawn curve from the surface, relative to the surface's diagonal, from which it counts as far.
///
/// Curves drawn with few points leave a surface by a hundredth; those in other units or places are nowhere near.
const FAR_GUIDE_REL: f64 = 0.05;

/// Drawn curves that are somewhere else, each with its farthest point and that one's distance.
pub(crate) fn far_guides(mesh: &TriMesh, surface: &ClosestPoint, guides: &[Vec<DVec3>]) -> Vec<(usize, (usize, f64))> {
    let limit = FAR_GUIDE_REL * mesh.diagonal();
    let farthest = |guide: &Vec<DVec3>| {
        let distances = guide.iter().map(|&p| surface.query(p).distance).enumerate();
        distances.fold((0, 0.0), |far: (usize, f64), near| if near.1 > far.1 { near } else { far })
    };
    let all = guides.iter().map(farthest).enumerate();
    all.filter(|(_, (_, distance))| *distance > limit).collect()
}

/// A warning about drawn curves that are somewhere else; they are traced all the same, along what is nearest.
pub(crate) fn far_guides_warning(mesh: &TriMesh, guides: usize, far: &[(usize, (usize, f64))]) -> Option<Warning> {
    let &(curve, (point, distance)) = far.first()?;
    let message = format!(
        "{} of {guides} drawn curves (--guides) are far from the surface, and at best the edges nearest to them are \
         followed (first: point {} of curve {} is {distance:.3e} away, the surface has a diagonal of {:.3e}); check \
         their units and place",
        far.len(),
        point + 1,
        curve + 1,
        mesh.diagonal()
    );
    Some(Warning::new(WarningCode::GuideFar, message))
}

/// Distance from a drawn curve, relative to the quads' edges, from which edges along it do not follow it.
const ASTRAY_REL: f64 = 1.0;

/// Samples of a drawn curve at most.
const MOST_SAMPLES: f64 = 2000.0;

/// How far the edges along a drawn curve lead away from it, if that is farther than a quad's edge, file units.
///
/// Curves are taken to the surface first: those drawn with few points cut through it.
///
/// # Input      surface: with the mesh among its components; quad_edge: file units
pub(crate) fn astray(mesh: &TriMesh, surface: &ClosestPoint, guide: &[DVec3], quad_edge: f64) -> Option<f64> {
    let edges = trace_guides(mesh, std::slice::from_ref(&guide.to_vec()));
    let edges: Vec<[DVec3; 2]> = edges.into_iter().map(|e| mesh.ends(e).map(|v| mesh.position(v))).collect();
    let length: f64 = guide.windows(2).map(|w| w[0].distance(w[1])).sum();
    let spacing = (0.5 * quad_edge).max(length / MOST_SAMPLES);
    let samples = guide.windows(2).flat_map(|w| {
        let pieces = (w[0].distance(w[1]) / spacing).ceil().max(1.0) as u32;
        (0..=pieces).map(move |k| w[0].lerp(w[1], f64::from(k) / f64::from(pieces)))
    });
    let off = samples.map(|p| {
        let p = surface.query(p).position;
        let from = |&[a, b]: &[DVec3; 2]| p.distance(a.lerp(b, closest_parameter(a, b, p)));
        edges.iter().map(from).fold(f64::INFINITY, f64::min)
    });
    let farthest = off.fold(0.0, f64::max);
    (farthest > ASTRAY_REL * quad_edge).then_some(farthest)
}

/// A warning about drawn curves that the surface's edges cannot follow, each with its number and how far they stray.
pub(crate) fn astray_guides_warning(guides: usize, astray: &[(usize, f64)]) -> Option<Warning> {
    let &(curve, distance) = astray.first()?;
    let message = format!(
        "{} of {guides} drawn curves (--guides) are not followed closely: the surface's edges along them lead away, by more \
         than a quad's edge (first: curve {}, {distance:.3e} away); refine the surface there",
        astray.len(),
        curve + 1
    );
    Some(Warning::new(WarningCode::FeatureMissed, message))
}

/// A warning about drawn curves without an edge along them.
pub(crate) fn short_guides_warning(guides: usize, short: &[usize]) -> Option<Warning> {
    let first = short.first()?;
    let message = format!(
        "{} of {guides} drawn curves (--guides) are shorter than the triangles under them, and nothing follows them (first: \
         curve {}); draw longer ones, or refine the surface there",
        short.len(),
        first + 1
    );
    Some(Warning::new(WarningCode::FeatureMissed, message))
}

fn nearest_vertex(mesh: &TriMesh, p: DVec3) -> Option<VertexId> {
    let distance = |v: &VertexId| mesh.position(*v).distance_squared(p);
    mesh.vertices().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// The cheapest path from `a` to `b`, edges far from the segment being dearer; empty if there is none.
fn path(mesh: &TriMesh, a: VertexId, b: VertexId, [p, q]: [DVec3; 2]) -> Vec<EdgeId> {
    let off = |v: VertexId| {
        let x = mesh.position(v);
        x.distance(p.lerp(q, closest_parameter(p, q, x)))
    };
    let mut cost = VertexMap::filled(mesh.vertex_count(), f64::INFINITY);
    let mut from: VertexMap<Option<EdgeId>> = VertexMap::filled(mesh.vertex_count(), None);
    let mut queue = BinaryHeap::new();
    cost[a] = 0.0;
    // Non-negative floats are ordered as their bits.
    queue.push(Reverse((0u64, a)));
    while let Some(Reverse((bits, v))) = queue.pop() {
        if v == b {
            break;
        }
        let here = f64::from_bits(bits);
        if here > cost[v] {
            continue;
        }
        for e in mesh.vertex_edges(v) {
            let w = other_end(mesh, e, v);
            let length = mesh.position(v).distance(mesh.position(w));
            let step = length + DISTANCE_WEIGHT * 0.5 * (off(v) + off(w));
            if here + step < cost[w] {
                cost[w] = here + step;
                from[w] = Some(e);
                queue.push(Reverse(((here + step).to_bits(), w)));
            }
        }
    }
    let mut edges = Vec::new();
    let mut v = b;
    while let Some(e) = from[v] {
        edges.push(e);
        v = other_end(mesh, e, v);
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: u32) -> TriMesh {
        let positions =
            (0..=n).flat_map(|j| (0..=n).map(move |i| DVec3::new(f64::from(i), f64::from(j), 0.0))).collect();
        let at = |i: u32, j: u32| j * (n + 1) + i;
        let faces: Vec<[u32; 3]> = (0..n)
            .flat_map(|j| {
                (0..n).flat_map(move |i| {
                    [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
                })
            })
            .collect();
        TriMesh::new(positions, &faces).expect("a grid")
    }

    #[test]
    fn a_straight_curve_becomes_the_row_of_edges_under_it() {
        let mesh = grid(6);
        let edges = trace_guides(&mesh, &[vec![DVec3::new(-0.2, 3.1, 0.4), DVec3::new(6.1, 2.9, 0.0)]]);
        assert_eq!(edges.len(), 6);
        for e in edges {
            assert!(mesh.ends(e).iter().all(|&v| mesh.position(v).y == 3.0));
        }
    }

    #[test]
    fn an_angled_curve_passes_its_points() {
        let mesh = grid(6);
        let corner = [DVec3::new(1.0, 1.0, 0.0), DVec3::new(5.0, 1.0, 0.0), DVec3::new(5.0, 5.0, 0.0)];
        let edges = trace_guides(&mesh, &[corner.to_vec()]);
        let length: f64 =
            edges.iter().map(|&e| mesh.ends(e).map(|v| mesh.position(v))).map(|[a, b]| a.distance(b)).sum();
        assert_eq!(length, 8.0);
    }
}
