//! The pictures of docs/regular-maps.md.
//!
//! In: a built command. Out: `docs/pictures/regular-maps/*.png`: flat pictures as the command writes them, surfaces as its
//! pages show them in Chromium. Holds: without Node, Chromium or playwright-core nothing is written, and it says so.

use crate::shell::{Outcome, cargo, root};
use crate::viewer::{browse, built_folder, has_node};

/// Name of a picture, what comes after `regular-map tile`.
const FLAT: &[(&str, &str)] = &[
    ("r3.1-disc", "R3.1"),
    ("r5.8-disc", "R5.8"),
    ("r2.1-klein", "R2.1 --model klein --numbers"),
    ("r3.1-jemisphere", "R3.1 --model jemisphere"),
    ("r3.1-orbits", "R3.1' --colors orbit:R"),
    ("r3.1-petrie", "R3.1 --colors petrie"),
    ("r4.2-triangles", "R4.2 --colors triangle --centre vertex"),
    ("dodecahedron", "dodecahedron"),
    ("torus", "{6,3}_(3,3)"),
];

/// Name of a picture, what comes after `regular-map realize`, options of the page's address.
const SURFACES: &[(&str, &str, &str)] = &[
    ("page", "R3.1", "whole=1200x680&yaw=30&pitch=25&face=2"),
    ("r3.1", "R3.1", "yaw=30&pitch=25"),
    ("r3.1-dual", "R3.1 --dual", "yaw=30&pitch=25"),
    ("r5.4", "R5.4", "yaw=30&pitch=25"),
    ("r11.1", "R11.1", "yaw=30&pitch=25"),
    ("r13.2-dual", "R13.2' --edge-width 0.02", "yaw=45&pitch=35"),
    ("r9.3-dual", "R9.3' --edge-width 0.025", "yaw=8&pitch=-14"),
    ("r5.8", "R5.8 --edge-width 0.03", "yaw=6&pitch=12"),
    ("r21.3-dual", "R21.3'", "yaw=30&pitch=25"),
    ("r5.7-hosohedron", "R5.7 --on {2,6}", "yaw=30&pitch=40"),
    ("r6.2-twisted", "R6.2", "yaw=8&pitch=10"),
    ("r11.1-symmetry", "R11.1 --colors symmetry", "yaw=30&pitch=25"),
];

/// Width and height of flat pictures.
const SIZE: &str = "560";

/// Makes every picture, or those whose names are given.
pub fn make(only: &[String]) -> Outcome {
    if !has_node() {
        return Ok(());
    }
    let [pages, pictures] = [built_folder("gallery")?, root().join("docs/pictures/regular-maps")];
    std::fs::create_dir_all(&pictures).map_err(|e| format!("{}: {e}", pictures.display()))?;
    let wanted = |name: &str| only.is_empty() || only.iter().any(|o| o == name);
    let mut shots = Vec::new();
    let mut shoot = |file: String, name: &str, options: &str| {
        let picture = pictures.join(format!("{name}.png")).display().to_string();
        shots.extend([file, picture, options.to_owned()]);
    };
    // 1. Flat pictures.
    for (name, words) in FLAT.iter().filter(|(name, _)| wanted(name)) {
        let file = pages.join(format!("{name}.png")).display().to_string();
        command("tile", words, &["--size", SIZE, "-o", &file])?;
        shoot(file, name, "");
    }
    // 2. Surfaces.
    for (name, words, options) in SURFACES.iter().filter(|(name, ..)| wanted(name)) {
        let [surface, page] = ["obj", "html"].map(|kind| pages.join(format!("{name}.{kind}")).display().to_string());
        command("realize", words, &["-o", &surface, "--view", &page, "--quiet"])?;
        shoot(page, name, options);
    }
    browse(&root().join("tests/viewer/gallery.mjs"), &shots.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Runs a verb of `regular-map`.
fn command(verb: &str, words: &str, outputs: &[&str]) -> Outcome {
    let run = ["run", "--release", "--quiet", "--package", "quadloom-cli", "--", "regular-map", verb];
    let words: Vec<&str> = words.split(' ').collect();
    cargo(&[&run[..], &words, outputs].concat())
}
