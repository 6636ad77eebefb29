//! What a user should know about a result, in sentences.
//!
//! In: what repair found, the parts, what was measured. Out: [`Warning`]s. Holds: each says what, where and, if there is
//! one, the cure; what nobody asked for is not missed.

use crate::error::{Warning, WarningCode};
use crate::measure::kept_chains;
use crate::options::{Elements, RemeshOptions};
use crate::part::Part;
use crate::report::CountReport;
use quadloom_extract::Distances;
use quadloom_mesh::repair::{FindingKind, Repaired};
use quadloom_mesh::{FeatureKind, QuadMesh};

/// What repair found, a warning per kind of defect.
pub(crate) fn repair_warnings(repaired: &Repaired) -> Vec<Warning> {
    repaired
        .report
        .findings()
        .map(|finding| {
            let elements = match finding.kind {
                FindingKind::WeldedVertex
                | FindingKind::NonManifoldVertex
                | FindingKind::UnusedVertex
                | FindingKind::TJunction => Elements::Vertices(finding.first.clone()),
                _ => Elements::Faces(finding.first.clone()),
            };
            Warning::new(WarningCode::Repaired, finding.to_string()).at(elements)
        })
        .collect()
}

/// The same warning, said of one component.
pub(crate) fn of_component(warning: Warning, i: u32) -> Warning {
    let message = format!("component {}: {}", i + 1, warning.message);
    let elements = match warning.elements {
        Elements::None => Elements::Components(vec![i]),
        other => other,
    };
    Warning { message, elements, ..warning }
}

/// By how much the count was missed, and why.
pub(crate) fn count_warning(count: &CountReport, parts: &[Part]) -> Warning {
    let creased = parts.iter().any(|p| p.features.graph.edge_count() > 0);
    let why = if parts.iter().any(|p| p.solution.is_none()) {
        "split triangles cannot have any number; ask for more quads"
    } else if count.reached > count.asked && creased {
        "features and singular vertices need more; ask for more quads, or keep fewer edges (--sharp-angle)"
    } else if count.reached > count.asked {
        "singular vertices and handles need more; ask for more quads"
    } else {
        "no map without folds was found nearer to it; ask for another number"
    };
    let of = format!("({:+.1} %, tolerance {} %)", count.error_percent, count.tolerance_percent);
    if count.explicit {
        let message = format!("{} quads instead of {} {of}: {why}", count.reached, count.asked);
        return Warning::new(WarningCode::CountMissed, message);
    }
    let message = format!("{} quads were made where {} were aimed at {of}: {why}", count.reached, count.asked);
    Warning::new(WarningCode::DefaultCountMissed, message)
}

/// Sharp edges and curves that are not kept.
pub(crate) fn feature_warnings(parts: &[Part], options: &RemeshOptions) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let dropped = parts.iter().map(|p| p.features.dropped_edges).sum::<usize>();
    if dropped > 0 {
        let message = format!(
            "{dropped} sharp edges in pieces that are short, or no sharper than the surface around them, were not kept"
        );
        warnings.push(Warning::new(WarningCode::LooseFeaturesDropped, message));
    }
    // Boundaries that are to be free are not lost.
    let wanted = |kind: FeatureKind| options.keep_boundary || kind != FeatureKind::Boundary;
    let lost_of = |part: &Part| {
        let chains = part.features.graph.chains.iter().zip(kept_chains(part));
        chains.filter(|(chain, kept)| !kept && wanted(chain.kind)).count()
    };
    let lost = parts.iter().map(lost_of).sum::<usize>();
    if lost > 0 {
        let message = format!("{lost} feature curves have no quad edge along them");
        // What nobody asked for is not missed.
        let named = !options.features.is_empty() || !options.guides.is_empty();
        let code = if named { WarningCode::FeatureMissed } else { WarningCode::FeatureLost };
        warnings.push(Warning::new(code, message));
    }
    warnings
}

/// A warning about named edges that the mesh does not have, by the vertices of the file.
pub(crate) fn missing_edges_warning(missing: &[[u32; 2]]) -> Option<Warning> {
    let &[a, b] = missing.first()?;
    let message = format!(
        "{} feature edges are not edges of the mesh and are not kept (first: vertices {a} and {b}); an edge is named by its \
         two ends",
        missing.len()
    );
    let elements = Elements::Vertices(missing.as_flattened().to_vec());
    Some(Warning::new(WarningCode::FeatureMissed, message).at(elements))
}

/// Distance between surface and quads, relative to the mean edge of the quads, from which detail counts as lost.
///
/// Quads as long as the tip of a finger cannot have it; on the models measured that is rare below one edge.
const DETAIL_LOST_REL: f64 = 1.0;

/// Percent of the diagonal up to which no distance is worth a word.
const DETAIL_SEEN: f64 = 1.0;

/// A warning where quads are too large for the shape of the surface.
///
/// # Input      distances: percent of `diagonal`; diagonal: of the surface, file units
pub(crate) fn detail_warning(distances: &Distances, quads: &QuadMesh, diagonal: f64) -> Option<Warning> {
    let farthest = distances.to_reference.max.max(distances.from_reference.max);
    let edge = (quads.area() / quads.face_count().max(1) as f64).sqrt();
    let edges = farthest / 100.0 * diagonal / edge;
    let message = format!(
        "quads and surface are up to {farthest:.1} % of the diagonal apart, {edges:.1} quad edges: quads of this size lose \
         detail there; ask for more of them (--quads), or for smaller ones there (--adaptivity, --density)"
    );
    (farthest > DETAIL_SEEN && edges > DETAIL_LOST_REL).then(|| Warning::new(WarningCode::DetailLost, message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_extract::Reference;
    use quadloom_mesh::{DVec3, FeatureGraph, TriMesh, VertexId, shapes};

    #[test]
    fn detail_is_lost_where_a_spike_is_longer_than_a_quad() {
        let cube = shapes::cube(1.0, 4);
        let quads = crate::split::split_triangles(&cube).expect("quads");
        let corner = cube.vertices().find(|&v| cube.position(v) == DVec3::ONE).expect("the corner");
        let warning = |length: f64| {
            let out = |v: VertexId| cube.position(v) + if v == corner { DVec3::splat(length) } else { DVec3::ZERO };
            let spiked = TriMesh::new(cube.vertices().map(out).collect(), &cube.to_faces()).expect("a spike");
            let features = FeatureGraph::none(&spiked);
            let reference = Reference::new(&spiked, &features);
            let distances = Distances::measure(&quads, &reference).expect("distances");
            detail_warning(&distances, &quads, spiked.diagonal())
        };
        assert_eq!(warning(0.0), None);
        // A third of an edge, then several.
        assert_eq!(warning(0.03), None);
        assert_eq!(warning(0.8).map(|w| w.code), Some(WarningCode::DetailLost));
    }
}
