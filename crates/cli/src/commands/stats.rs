//! `quadloom stats`

use super::{done, read, repaired};
use crate::args::StatsArgs;
use quadloom::RemeshError;
use quadloom::extract::Deviation;
use quadloom::inspect::{Inspection, distances_to, inspect};
use std::process::ExitCode;

/// Prints counts, topology and quality.
pub fn run(args: &StatsArgs) -> Result<ExitCode, RemeshError> {
    let soup = read(&args.input)?;
    let mut inspection = inspect(&soup);
    if let Some(reference) = &args.reference {
        let surface = repaired(&read(reference)?, reference)?.mesh;
        inspection.distance = Some(distances_to(&soup, &surface).map_err(|e| e.of_input(&args.input))?);
    }
    if args.json {
        println!("{:#}", serde_json::json!(inspection));
    } else {
        for (name, value) in rows(&inspection) {
            println!("{name:>24}  {value}");
        }
    }
    done()
}

fn rows(inspection: &Inspection) -> Vec<(&'static str, String)> {
    let mut rows = vec![("vertices", inspection.vertices.to_string())];
    for (degree, count) in &inspection.faces_by_degree {
        rows.push(("faces", format!("{count} with {degree} corners")));
    }
    for defect in &inspection.defects {
        rows.push(("defects", format!("{} (first: {}; {})", defect.count, defect.first, defect.cure)));
    }
    if let Some(surface) = &inspection.surface {
        let summary = &surface.summary;
        rows.push(("edges", summary.edges.to_string()));
        rows.push(("components", summary.components.to_string()));
        rows.push(("boundary loops", summary.boundary_loops.to_string()));
        rows.push(("Euler characteristic", summary.chi.to_string()));
        rows.push(("genus", summary.genus.to_string()));
        rows.push(("area", format!("{:.6}", surface.area)));
        rows.push(("diagonal", format!("{:.6}", surface.diagonal)));
    }
    if let Some(irregular) = &inspection.irregular {
        let by_valence: Vec<String> = irregular.by_valence.iter().map(|(v, n)| format!("{n} of valence {v}")).collect();
        rows.push(("irregular", format!("{} ({})", irregular.interior, by_valence.join(", "))));
        rows.push(("irregular on boundary", irregular.boundary.to_string()));
    }
    if let Some(quality) = &inspection.quality {
        rows.push((
            "scaled Jacobian",
            format!("mean {:.4}, worst {:.4}", quality.scaled_jacobian_mean, quality.scaled_jacobian_min),
        ));
        rows.push(("inverted", quality.inverted.to_string()));
        rows.push(("angle deviation", format!("mean {:.2}°, worst {:.2}°", quality.angle_mean, quality.angle_max)));
        rows.push(("edge length", format!("mean {:.6}, variation {:.3}", quality.edge_mean, quality.edge_variation)));
    }
    if let Some(distance) = &inspection.distance {
        let both = &distance.distances;
        let deviations = [
            ("to reference", Some(both.to_reference)),
            ("from reference", Some(both.from_reference)),
            ("between boundaries", both.boundary),
        ];
        let text = |d: Deviation| format!("mean {:.4} %, largest {:.4} % of the reference's diagonal", d.mean, d.max);
        rows.extend(deviations.into_iter().filter_map(|(name, d)| Some((name, text(d?)))));
    }
    rows
}
