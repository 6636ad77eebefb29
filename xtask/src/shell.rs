//! Starting other programs.

use std::path::PathBuf;
use std::process::Command;

/// What went wrong, in words for the terminal.
pub type Outcome = Result<(), String>;

/// Top folder of the repository.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().map(PathBuf::from).unwrap_or_default()
}

/// Runs cargo at the top folder and passes its output on.
pub fn cargo(args: &[&str]) -> Outcome {
    let status = Command::new("cargo").args(args).current_dir(root()).status().map_err(|e| format!("cargo: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("cargo {} failed", args.join(" "))) }
}

/// Standard output of a program that must succeed.
pub fn output(program: &str, args: &[&str]) -> Result<String, String> {
    let output =
        Command::new(program).args(args).current_dir(root()).output().map_err(|e| format!("{program}: {e}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("{program} {}: {}", args.join(" "), String::from_utf8_lossy(&output.stderr)))
    }
}

/// Files of the repository that git tracks or would track, relative to the top folder.
pub fn tracked_files() -> Result<Vec<PathBuf>, String> {
    let list = output("git", &["ls-files", "--cached", "--others", "--exclude-standard"])?;
    Ok(list.lines().map(PathBuf::from).filter(|p| root().join(p).is_file()).collect())
}
