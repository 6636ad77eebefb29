//! `quadloom samples`

use super::done;
use quadloom::{RemeshError, sample_names};
use std::process::ExitCode;

/// Lists the generated shapes.
pub fn run() -> Result<ExitCode, RemeshError> {
    for (name, description) in sample_names() {
        println!("sample:{name:<18} {description}");
    }
    done()
}
