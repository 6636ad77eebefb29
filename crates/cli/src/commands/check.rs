//! `quadloom check`

use super::read;
use crate::args::CheckArgs;
use crate::exit;
use quadloom::RemeshError;
use quadloom::inspect::{Inspection, as_quads, inspect};
use quadloom::mesh::repair::{RepairOptions, repair};
use quadloom::verify::verify_against;
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
    if let Some(reference) = &args.reference {
        let surface = repair(&read(reference)?, &RepairOptions::default())?.mesh;
        match as_quads(&soup) {
            Some(Ok(quads)) => {
                let verification = verify_against(&quads, &surface);
                complaints.extend(Some(verification.complaint()).filter(|c| !c.is_empty()));
            }
            // The defects are listed already.
            Some(Err(_)) => {}
            None => complaints.push("not all faces are quads; `quadloom remesh` makes quads".into()),
        }
    } else if inspection.quality.as_ref().is_some_and(|q| q.inverted > 0) {
        let inverted = inspection.quality.as_ref().map_or(0, |q| q.inverted);
        complaints.push(format!("{inverted} quads are inverted (scaled Jacobian of zero or less)"));
    }
    print(args, &inspection, &complaints);
    Ok(ExitCode::from(if complaints.is_empty() { exit::DONE } else { exit::REJECTED }))
}

fn print(args: &CheckArgs, inspection: &Inspection, complaints: &[String]) {
    if args.json {
        let valid = complaints.is_empty();
        println!(
            "{:#}",
            serde_json::json!({ "valid": valid, "complaints": complaints, "defects": inspection.defects })
        );
        return;
    }
    for complaint in complaints {
        println!("{complaint}");
    }
    if complaints.is_empty() {
        println!("{}: an oriented manifold{}", args.input, if inspection.quality.is_some() { " of quads" } else { "" });
    }
}
