//! `quadloom check`

use super::{read, repaired};
use crate::args::CheckArgs;
use crate::exit;
use quadloom::inspect::{Inspection, as_quads, as_read, inspect, topology_warning};
use quadloom::mesh::repair::Repaired;
use quadloom::tile::check_layout;
use quadloom::verify::verify_against;
use quadloom::{FaceSoup, RemeshError};
use std::process::ExitCode;

/// Says what is wrong with a mesh; exit code 4 if something is.
pub fn run(args: &CheckArgs) -> Result<ExitCode, RemeshError> {
    let soup = read(&args.input)?;
    let inspection = inspect(&soup);
    let mut complaints: Vec<String> = inspection
        .defects
        .iter()
        .map(|d| format!("{} defects of this kind, first: {}; cure: {}", d.count, d.first, d.cure))
        .collect();
    let mut notes = Vec::new();
    if let Some(layout) = &args.layout {
        complaints.extend(check_layout(&soup, layout)?);
    } else if let Some(reference) = &args.reference {
        let as_given = read(reference)?;
        let repaired = repaired(&as_given, reference)?;
        notes = repairs(&as_given, &repaired);
        let surface = repaired.mesh;
        match as_quads(&soup) {
            Some(Ok(quads)) => {
                let verification = verify_against(&quads, &surface, args.sharp_angle.0);
                let complaint = Some(verification.complaint()).filter(|c| !c.is_empty());
                complaints.extend(complaint.map(|c| format!("{} is no result for {reference}: {c}", args.input)));
            }
            // The defects are listed already.
            Some(Err(_)) => {}
            None => complaints.push("not all faces are quads; `quadloom remesh` makes quads".into()),
        }
    } else if inspection.quality.as_ref().is_some_and(|q| q.inverted > 0) {
        let inverted = inspection.quality.as_ref().map_or(0, |q| q.inverted);
        complaints.push(format!("{inverted} quads are inverted (scaled Jacobian of zero or less)"));
    }
    print(args, &inspection, &complaints, &notes);
    Ok(ExitCode::from(if complaints.is_empty() { exit::DONE } else { exit::REJECTED }))
}

/// What was done to the reference before the quads were compared with it.
fn repairs(soup: &FaceSoup, repaired: &Repaired) -> Vec<String> {
    let change = topology_warning(&as_read(soup, repaired), repaired).map(|w| w.message);
    change.into_iter().chain(repaired.report.findings().map(ToString::to_string)).collect()
}

fn print(args: &CheckArgs, inspection: &Inspection, complaints: &[String], notes: &[String]) {
    if args.json {
        let valid = complaints.is_empty();
        println!(
            "{:#}",
            serde_json::json!({
                "valid": valid,
                "complaints": complaints,
                "defects": inspection.defects,
                "reference_repairs": notes,
            })
        );
        return;
    }
    for note in notes {
        println!("note: compared with the repaired reference: {note}");
    }
    for complaint in complaints {
        println!("{complaint}");
    }
    if complaints.is_empty() {
        let of_quads = if inspection.quality.is_some() { " of quads" } else { "" };
        let result_for = args.reference.as_ref().map(|r| format!(", a valid result for {r}")).unwrap_or_default();
        let tiling = args.layout.as_ref().map(|l| format!(", tiled as {} says", l.display())).unwrap_or_default();
        println!("{}: an oriented manifold{of_quads}{result_for}{tiling}", args.input);
    }
}
