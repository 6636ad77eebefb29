//! Repair on real files: clean models stay as they are, dirty ones become meshes or say why not.
//! Skips, visibly, where the models are not there.
#![allow(clippy::print_stderr)]

use quadloom_mesh::repair::{RepairError, RepairOptions, Repaired, repair};
use quadloom_mesh::{DVec3, FaceSoup, Summary, TriMesh};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The least of an OBJ reader: positions and faces; anything odd becomes NaN or an index out of range.
fn read_obj(path: &Path) -> FaceSoup {
    let bytes = std::fs::read(path).unwrap();
    let mut soup = FaceSoup::default();
    for line in String::from_utf8_lossy(&bytes).lines() {
        let mut words = line.split('#').next().unwrap_or("").split_whitespace();
        match words.next() {
            Some("v") => {
                let mut next = || words.next().and_then(|w| w.parse().ok()).unwrap_or(f64::NAN);
                soup.positions.push(DVec3::new(next(), next(), next()));
            }
            Some("f") => {
                let index = |w: &str| match w.split('/').next().and_then(|i| i.parse::<i64>().ok()) {
                    Some(i) if i > 0 => (i - 1) as u32,
                    Some(i) if i < 0 => (soup.positions.len() as i64 + i) as u32,
                    _ => u32::MAX - 1,
                };
                soup.faces.push(words.map(index).collect());
            }
            _ => {}
        }
    }
    soup
}

fn models(folder: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models").join(folder);
    let Ok(entries) = std::fs::read_dir(&root) else {
        say_skipped(&format!("no models in {}", root.display()));
        return Vec::new();
    };
    let mut files: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    files.sort();
    files
}

fn describe(name: &str, result: &Result<Repaired, RepairError>) -> String {
    match result {
        Ok(r) => {
            let s = Summary::of(r.mesh.connectivity());
            let notes: Vec<String> = r.report.findings().map(ToString::to_string).collect();
            format!(
                "{name}: V {} F {} components {} loops {} genus {} | {}",
                s.vertices,
                s.faces,
                s.components,
                s.boundary_loops,
                s.genus,
                notes.join("; ")
            )
        }
        Err(e) => format!("{name}: error: {e}"),
    }
}

fn name(path: &Path) -> String {
    path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
}

#[test]
fn clean_models_stay_as_they_are() {
    for path in models("tri") {
        let soup = read_obj(&path);
        let result = repair(&soup, &RepairOptions::default());
        eprintln!("{}", describe(&name(&path), &result));
        let repaired = result.unwrap();
        let mut used = vec![false; soup.positions.len()];
        soup.faces.iter().flatten().for_each(|&v| used[v as usize] = true);
        let kept: Vec<DVec3> = (0..used.len()).filter(|&v| used[v]).map(|v| soup.positions[v]).collect();
        assert_eq!(repaired.mesh.positions().values(), kept, "{}", path.display());
        let faces: Vec<Vec<u32>> = repaired.mesh.to_faces().iter().map(|f| f.to_vec()).collect();
        let expected: Vec<Vec<u32>> = soup
            .faces
            .iter()
            .map(|f| f.iter().map(|&v| repaired.vertex_of_input[v as usize].unwrap().0).collect())
            .collect();
        assert_eq!(faces, expected, "{}", path.display());
    }
}

#[test]
fn dirty_models_become_meshes_or_say_why_not() {
    let closed_rods = ["crlf_tabs", "slashes", "negidx", "vcolor", "isolated", "dupfaces", "degenerate", "flipped"]
        .into_iter()
        .chain(["soup", "farorigin", "huge", "tiny", "flat", "fin", "bowtie"]);
    let must: Vec<String> = closed_rods.map(|n| format!("gen_rod_{n}")).collect();
    let mut meshed = 0;
    let files = models("nasty");
    for path in &files {
        let soup = read_obj(path);
        let result = repair(&soup, &RepairOptions::default());
        eprintln!("{}", describe(&name(path), &result));
        if let Ok(r) = &result {
            meshed += 1;
            check(&soup, r);
            if must.contains(&name(path)) {
                let s = Summary::of(r.mesh.connectivity());
                let main = quadloom_mesh::topology::component_summaries(r.mesh.connectivity());
                assert!(
                    main.iter().any(|c| (c.genus, c.boundary_loops) == (2, 0) && c.faces >= 4400),
                    "{path:?} {s:?}"
                );
            }
        } else {
            assert!(!must.contains(&name(path)), "{}", describe(&name(path), &result));
        }
    }
    assert!(files.is_empty() || meshed >= 40, "{meshed} of {} meshed", files.len());
}

/// What repair promises, checked against the soup.
fn check(soup: &FaceSoup, repaired: &Repaired) {
    let mesh: &TriMesh = &repaired.mesh;
    for (input, v) in repaired.vertex_of_input.iter().enumerate() {
        if let Some(v) = v {
            assert_eq!(mesh.position(*v), soup.positions[input]);
        }
    }
    // Each vertex of a face belongs to the face of the soup that it comes from, or to an edge flip nearby.
    assert_eq!(repaired.input_face.len(), mesh.face_count());
    assert!(repaired.input_face.values().iter().all(|&f| (f as usize) < soup.faces.len()));
    // Repairing twice changes nothing more than what is left open on purpose.
    let again = FaceSoup {
        positions: mesh.positions().values().to_vec(),
        faces: mesh.to_faces().iter().map(|f| f.to_vec()).collect(),
        ..FaceSoup::default()
    };
    let again = repair(&again, &RepairOptions::default()).unwrap();
    assert!(Summary::of(again.mesh.connectivity()).faces <= mesh.face_count());
}

/// Says what is skipped so that it is seen: the test harness hides what goes through `eprintln` where a test passes.
fn say_skipped(what: &str) {
    let _ = writeln!(std::io::stderr(), "SKIPPED: {what}");
}
