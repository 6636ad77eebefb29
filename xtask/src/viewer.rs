//! The pages of `--view` in a real browser.
//!
//! In: a built command. Out: success, or what the browser saw. Holds: without Node, Chromium or playwright-core the
//! check is skipped, and says so.

use crate::shell::{Outcome, cargo, root};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The shape whose page is opened: it has features, bores, seams and irregular vertices.
const SHAPE: &str = "sample:bracket";

/// Makes a page with the command and has `tests/viewer/run.mjs` work with it.
pub fn test() -> Outcome {
    if !has_node() {
        return Ok(());
    }
    // 1. The page.
    let folder = built_folder("viewer")?;
    let [mesh, page] = ["bracket.obj", "bracket.html"].map(|name| folder.join(name).display().to_string());
    let words = ["run", "--release", "--quiet", "--package", "quadloom-cli", "--", "remesh", SHAPE];
    let options = ["--quads", "1500", "-o", &mesh, "--view", &page, "--quiet"];
    cargo(&[&words[..], &options[..]].concat())?;
    // 2. The browser.
    let script = root().join("tests/viewer/run.mjs");
    let pictures = folder.join("pictures").display().to_string();
    browse(&script, &[&page, &pictures])?;
    // 3. The same for distances.
    let [csv, page] = ["plate.csv", "plate.html"].map(|name| folder.join(name).display().to_string());
    let words = ["run", "--release", "--quiet", "--package", "quadloom-cli", "--", "distance", "sample:plate"];
    let sources = ["--from", "boundary", "--from", "vertices:7", "--isolines", "20", "--path-from", "vertices:200"];
    cargo(&[&words[..], &sources[..], &["-o", &csv, "--view", &page, "--quiet"]].concat())?;
    browse(&root().join("tests/viewer/distance.mjs"), &[&page])?;
    // 4. The same for tiles: a mapped square, and several with holes.
    let [obj, torus, holes] =
        ["tiles.obj", "torus.html", "holes.html"].map(|name| folder.join(name).display().to_string());
    let words = ["run", "--release", "--quiet", "--package", "quadloom-cli", "--", "tile"];
    let square = ["sample:torus", "--into", "quads", "--parametrize", "fixed", "-o", &obj, "--view", &torus, "--quiet"];
    cargo(&[&words[..], &square[..]].concat())?;
    let cylinders = ["sample:genus2", "--into", "cylinders", "-o", &obj, "--view", &holes, "--quiet"];
    cargo(&[&words[..], &cylinders[..]].concat())?;
    browse(&root().join("tests/viewer/tiles.mjs"), &[&torus, &holes])?;
    // 5. A map beside its flat picture.
    let page = folder.join("map.html").display().to_string();
    cargo(&["run", "--release", "--quiet", "--package", "quadloom", "--example", "06_map_page", "--", &page])?;
    browse(&root().join("tests/viewer/map.mjs"), &[&page, &pictures])?;
    // 6. A regular map, as the command writes it.
    let [surface, page] = ["klein.glb", "klein.html"].map(|name| folder.join(name).display().to_string());
    let words = ["run", "--release", "--quiet", "--package", "quadloom-cli", "--", "regular-map", "realize", "R3.1"];
    cargo(&[&words[..], &["-o", &surface, "--view", &page, "--quiet"]].concat())?;
    browse(&root().join("tests/viewer/map.mjs"), &[&page])
}

/// Whether there is a node to drive a browser with; says so if not.
pub fn has_node() -> bool {
    let node = Command::new("node").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    let found = node.is_ok_and(|status| status.success());
    if !found {
        println!("skipped: there is no node to drive a browser with");
    }
    found
}

/// A folder beside what was built; it is made.
pub fn built_folder(name: &str) -> Result<PathBuf, String> {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    let folder = target.join(name);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    Ok(folder)
}

/// Has a script work with pages.
pub fn browse(script: &Path, words: &[&str]) -> Outcome {
    let status = Command::new("node").arg(script).args(words).current_dir(root()).status();
    let status = status.map_err(|e| format!("node: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{} failed on {}", script.display(), words[0])) }
}
