//! Checks that no other tool makes.

use crate::shell::{Outcome, root, tracked_files};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Every `[Key]` of sources and documents is an entry of `docs/bibliography.bib`.
pub fn citations() -> Outcome {
    let known = bibliography()?;
    let mut missing = Vec::new();
    let mut count = 0;
    for file in tracked_files()?.iter().filter(|f| has_extension(f, &["rs", "md", "wgsl", "glsl", "js"])) {
        for (line, text) in text_of(file).lines().enumerate() {
            for key in cited_keys(text) {
                count += 1;
                if !known.contains(key) {
                    missing.push(format!("{}:{}: [{key}] is not in docs/bibliography.bib", file.display(), line + 1));
                }
            }
        }
    }
    println!("{count} citations of {} sources", known.len());
    if missing.is_empty() { Ok(()) } else { Err(missing.join("\n")) }
}

/// No tracked text file names a folder of somebody's machine.
pub fn paths() -> Outcome {
    // In two pieces, so that this file does not find itself.
    let forbidden =
        [["/ho", "me/"], ["/Us", "ers/"], ["/ro", "ot/"], ["/wo", "rk/"], ["C:", "\\Users"]].map(|p| p.concat());
    let here = root().to_string_lossy().into_owned();
    let mut found = Vec::new();
    for file in tracked_files()?.iter().filter(|f| !f.ends_with("Cargo.lock")) {
        for (line, text) in text_of(file).lines().enumerate() {
            if text.contains(&here) || forbidden.iter().any(|p| text.contains(p.as_str())) {
                found.push(format!("{}:{}: an absolute path of a machine: {}", file.display(), line + 1, text.trim()));
            }
        }
    }
    if found.is_empty() { Ok(()) } else { Err(found.join("\n")) }
}

/// Documentation builds without a warning; citations in brackets are not links and are left to [`citations`].
pub fn docs() -> Outcome {
    let known = bibliography()?;
    let output = Command::new("cargo")
        .args(["doc", "--workspace", "--no-deps", "--document-private-items", "--message-format=json", "--quiet"])
        .current_dir(root())
        .output()
        .map_err(|e| format!("cargo: {e}"))?;
    let mut warnings = BTreeSet::new();
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        let Ok(entry) = serde_json::from_str::<serde_json::Value>(line) else { continue };
        let message = &entry["message"];
        let (Some(text), Some(rendered)) = (message["message"].as_str(), message["rendered"].as_str()) else {
            continue;
        };
        let cited = known.iter().any(|key| text == format!("unresolved link to `{key}`"));
        if !cited
            && matches!(message["level"].as_str(), Some("warning" | "error"))
            && !text.contains("warnings emitted")
        {
            warnings.insert(rendered.to_string());
        }
    }
    if !warnings.is_empty() {
        return Err(warnings.into_iter().collect::<Vec<_>>().join("\n"));
    }
    if output.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}

fn bibliography() -> Result<BTreeSet<String>, String> {
    let path = root().join("docs/bibliography.bib");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("docs/bibliography.bib: {e}"))?;
    let entries = text.lines().filter(|l| l.starts_with('@')).filter_map(|l| l.split_once('{'));
    Ok(entries.map(|(_, rest)| rest.trim_end_matches(',').trim().to_string()).collect())
}

/// Words in brackets of the form `Name1234` or `Name1234b`, and the former parts of lists like `[A2001, B2002]`.
fn cited_keys(text: &str) -> impl Iterator<Item = &str> {
    text.split('[')
        .skip(1)
        .filter_map(|rest| rest.split_once(']').map(|(inside, _)| inside))
        .flat_map(|inside| inside.split(", "))
        .filter(|word| is_key(word))
}

fn is_key(word: &str) -> bool {
    let name = word.trim_end_matches(|c: char| c.is_ascii_lowercase());
    let letters = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let year = &name[letters.len()..];
    year.len() == 4
        && (year.starts_with("19") || year.starts_with("20"))
        && word.len() - name.len() <= 1
        && letters.len() >= 2
        && letters.starts_with(|c: char| c.is_ascii_uppercase())
        && letters.chars().all(|c| c.is_ascii_alphabetic())
}

fn text_of(file: &Path) -> String {
    // Binary files have no lines to check.
    std::fs::read_to_string(root().join(file)).unwrap_or_default()
}

fn has_extension(file: &Path, extensions: &[&str]) -> bool {
    file.extension().and_then(|e| e.to_str()).is_some_and(|e| extensions.contains(&e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_told_from_other_brackets() {
        let text = "by [Bommes2012] §8.2, [A] [`Link`] [0..4] [Campen2015, Ebke2013] [Nope20123] values[Id2012";
        assert_eq!(cited_keys(text).collect::<Vec<_>>(), ["Bommes2012", "Campen2015", "Ebke2013"]);
    }

    #[test]
    fn every_citation_is_known() {
        assert_eq!(citations(), Ok(()));
    }

    #[test]
    fn no_machine_is_named() {
        assert_eq!(paths(), Ok(()));
    }
}
