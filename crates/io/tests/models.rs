//! The field and feature files of other programs mean what our readers say they mean.

#![allow(clippy::print_stderr, reason = "tables are said")]

mod common;

use common::models;
use quadloom_io::{read_features, read_rawfield, read_rosy, read_sharp, read_soup};
use quadloom_mesh::{DVec3, FaceSoup};
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut list: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    list.retain(|p| p.extension().is_some_and(|e| e == extension));
    list.sort();
    list
}

fn normal(soup: &FaceSoup, face: usize) -> DVec3 {
    let [a, b, c] = [0, 1, 2].map(|k| soup.positions[soup.faces[face][k] as usize]);
    (b - a).cross(c - a).normalize_or_zero()
}

/// One direction per face of the mesh, tangent to it.
#[test]
fn rosy_fields_lie_in_their_faces() {
    let Some(folder) = models("field/loopycuts") else { return };
    for path in files(&folder, "rosy") {
        let (field, soup) = (read_rosy(&path).unwrap(), read_soup(path.with_extension("obj")).unwrap());
        assert_eq!(field.len(), soup.faces.len(), "{}", path.display());
        let tangent = (0..field.len()).filter(|&f| field[f].dot(normal(&soup, f)).abs() < 0.05).count();
        assert!(tangent * 100 >= field.len() * 98, "{}: {tangent} of {}", path.display(), field.len());
    }
}

/// Side k of a face is the edge of its corners k and k + 1: the marked edges are sharp, and bend as they say.
#[test]
fn sharp_files_mark_sharp_edges() {
    let Some(folder) = models("field/loopycuts") else { return };
    let (mut sides_total, mut sharp, mut bend) = (0, 0, 0);
    for path in files(&folder, "sharp") {
        let (sides, soup) = (read_sharp(&path).unwrap(), read_soup(path.with_extension("obj")).unwrap());
        let mut face_of = HashMap::new();
        for (f, face) in soup.faces.iter().enumerate() {
            (0..face.len()).for_each(|k| _ = face_of.insert((face[k], face[(k + 1) % face.len()]), f));
        }
        for s in &sides {
            let face = &soup.faces[s.face as usize];
            let (a, b) = (face[s.side as usize], face[(s.side as usize + 1) % 3]);
            let Some(&g) = face_of.get(&(b, a)) else { continue };
            let (m, n) = (normal(&soup, s.face as usize), normal(&soup, g));
            let along = soup.positions[b as usize] - soup.positions[a as usize];
            sides_total += 1;
            sharp += usize::from(m.dot(n) < 0.95);
            bend += usize::from((m.cross(n).dot(along) > 0.0) == s.convex);
        }
        let pairs = read_features(&path).unwrap().vertex_pairs(&soup).unwrap();
        assert!(pairs.len() <= sides.len() && pairs.len() * 2 >= sides.len(), "{}", path.display());
    }
    eprintln!("{sides_total} marked sides: {sharp} sharp, {bend} bent as marked");
    assert!(sides_total > 1000 && sharp * 100 >= sides_total * 95 && bend * 100 >= sides_total * 95);
}

#[test]
fn raw_fields_fit_their_meshes() {
    let Some(folder) = models("field/directional") else { return };
    for path in files(&folder, "rawfield") {
        let field = read_rawfield(&path).unwrap();
        assert!(matches!(field.degree, 2 | 4), "{}", path.display());
        let mesh = ["off", "obj"].map(|e| path.with_extension(e)).into_iter().find(|p| p.is_file());
        if let Some(mesh) = mesh {
            assert_eq!(field.faces().len(), read_soup(mesh).unwrap().faces.len(), "{}", path.display());
        }
    }
}
