//! Files that are broken on purpose or by accident: never a panic, always a sound soup or a telling error.

#![allow(clippy::print_stderr, reason = "tables are said")]

mod common;

use common::{assert_sound, models};
use proptest::prelude::*;
use quadloom_io::{ContentDefect, Encoding, IoError, Place, SurfaceOut, WriteOptions};
use quadloom_io::{read_features, read_guides, read_rawfield, read_rosy, read_singularities, read_soup, write_surface};
use quadloom_mesh::DVec3;
use std::fs;
use std::path::Path;

const EXTENSIONS: [&str; 9] = ["obj", "ply", "stl", "off", "rosy", "rawfield", "sharp", "sing", "json"];

/// Reads the bytes as each kind of file.
fn survive(bytes: &[u8]) {
    let folder = tempfile::tempdir().unwrap();
    for extension in EXTENSIONS {
        let path = folder.path().join(format!("a.{extension}"));
        fs::write(&path, bytes).unwrap();
        if let Ok(soup) = read_soup(&path) {
            assert_sound(&soup);
        }
        let _ = read_rosy(&path);
        let _ = read_rawfield(&path);
        let _ = read_features(&path);
        let _ = read_singularities(&path);
        let _ = read_guides(&path);
    }
}

fn valid_files() -> Vec<Vec<u8>> {
    let surface = SurfaceOut {
        vertex_colors: Some(vec![[0.5, 0.25, 1.0]; 4]),
        corner_uv: Some(vec![vec![[0.25, 0.5]; 3], vec![]]),
        vertex_attributes: vec![("a".into(), vec![1.0, f64::NAN, 3.0, 4.0])],
        polylines: vec![vec![0, 1, 2]],
        ..SurfaceOut::new(
            vec![DVec3::ZERO, DVec3::new(1.5, 0.0, -2e-7), DVec3::Y, DVec3::Z],
            vec![vec![0, 1, 2], vec![0, 2, 3, 1]],
        )
    };
    let folder = tempfile::tempdir().unwrap();
    let file = |extension: &str, encoding: Encoding| {
        let path = folder.path().join(format!("a.{extension}"));
        write_surface(&path, &surface, &WriteOptions { encoding, ..WriteOptions::default() }).unwrap();
        fs::read(path).unwrap()
    };
    let mut files = vec![file("obj", Encoding::Ascii), file("off", Encoding::Ascii)];
    for encoding in [Encoding::Ascii, Encoding::Binary] {
        files.extend([file("ply", encoding), file("stl", encoding)]);
    }
    files.extend([
        b"2\n4\n1 0 0\n0 1 0\n".to_vec(),
        b"2 1\n1 0 0 -1 0 0\n".to_vec(),
        b"2\n1,0,0\n0,1,2\n".to_vec(),
        b"4 2\n0 1\n2 -1\n".to_vec(),
        b"[[{\"point\":[0,0,0]},[1,1,1]]]".to_vec(),
    ]);
    files
}

proptest! {
    #![proptest_config(common::config(300))]

    #[test]
    fn random_bytes(bytes in proptest::collection::vec(any::<u8>(), 1..300)) {
        survive(&bytes);
    }

    #[test]
    fn random_tokens(words in proptest::collection::vec(prop::sample::select(&[
        "v", "f", "l", "vt", "ply\n", "format ascii 1.0\n", "element vertex 3\n", "property float x\n",
        "property list uchar int vertex_indices\n", "end_header\n", "OFF", "solid", "facet", "vertex", "endfacet", "\n",
        "\r\n", "\\\n", "0", "1", "-1", "3", "4", "1/2/3", "-1//-1", "1e999", "nan", "18446744073709551616", "0.5", "#",
        "[[", "]]", "{\"point\":", ",", "\t", "-9223372036854775808",
    ]), 1..60)) {
        survive(words.join(" ").as_bytes());
    }

    #[test]
    fn damaged_files(
        file in prop::sample::select(valid_files()),
        cut in any::<prop::sample::Index>(),
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
        truncate in any::<bool>(),
    ) {
        let mut bytes = file;
        if truncate {
            bytes.truncate(1 + cut.index(bytes.len()));
        }
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        survive(&bytes);
    }
}

#[test]
fn valid_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    for (k, bytes) in valid_files().into_iter().take(6).enumerate() {
        // Without a telling extension, by content alone.
        let path = folder.path().join(format!("a{k}"));
        fs::write(&path, bytes).unwrap();
        assert_sound(&read_soup(&path).unwrap_or_else(|e| panic!("file {k}: {e}")));
    }
}

#[test]
fn troubles_before_the_first_byte_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("empty.obj"), "").unwrap();
    fs::write(at("points.obj"), "v 0 0 0\nv 1 0 0\n").unwrap();
    fs::write(at("picture.png"), b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR").unwrap();
    fs::write(at("junk.obj"), [0u8, 1, 2, 3, 200, 255]).unwrap();
    fs::write(at("text.obj"), "this is\nno mesh\n").unwrap();
    let error = |name: &str| read_soup(at(name)).unwrap_err();
    assert!(matches!(error("missing.obj"), IoError::NotFound { .. }));
    assert!(matches!(error("empty.obj/below.obj"), IoError::NotFound { .. }));
    assert!(matches!(error(""), IoError::IsDirectory { .. }));
    assert!(matches!(error("empty.obj"), IoError::Empty { .. }));
    assert!(matches!(error("points.obj"), IoError::NoFaces { vertices: 2, .. }));
    assert!(matches!(error("text.obj"), IoError::NoFaces { vertices: 0, .. }));
    assert!(matches!(error("picture.png"), IoError::UnknownFormat { .. }));
    let junk = error("junk.obj");
    assert!(matches!(junk, IoError::Content { place: Place::Line(1), defect: ContentDefect::Binary(_), .. }), "{junk}");
    for name in ["missing.obj", "empty.obj", "points.obj", "picture.png", "junk.obj"] {
        assert!(error(name).to_string().contains(name), "{}", error(name));
        assert_eq!(error(name).path(), at(name));
    }
}

#[cfg(unix)]
#[test]
fn an_unreadable_file_is_told_apart() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(&path, "v 0 0 0\n").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o000)).unwrap();
    if fs::read(&path).is_ok() {
        common::say_skipped("this user may read everything");
        return;
    }
    assert!(matches!(read_soup(&path), Err(IoError::PermissionDenied { .. })));
}

/// Every bad file of the shared collection gives a soup, or an error that names the file and, if it has content, a line.
#[test]
fn the_nasty_collection() {
    let Some(folder) = models("nasty") else { return };
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    let mut read = 0;
    for path in &paths {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let outcome = match read_soup(path) {
            Ok(soup) => {
                assert_sound(&soup);
                read += 1;
                format!("{} vertices, {} faces", soup.positions.len(), soup.faces.len())
            }
            Err(error) => {
                assert!(error.to_string().contains(&name));
                assert!(
                    matches!(error, IoError::Empty { .. } | IoError::NoFaces { .. })
                        || matches!(error, IoError::Content { place: Place::Line(_), .. }),
                    "{error:?}"
                );
                error.to_string().rsplit('/').next().unwrap_or_default().to_string()
            }
        };
        eprintln!("{name:32} {outcome}");
    }
    assert!(read + 6 >= paths.len(), "{read} of {} files were read", paths.len());
    let line_of = |name: &str| match read_soup(Path::new(&paths[0]).with_file_name(name)) {
        Err(IoError::Content { place: Place::Line(line), .. }) => line,
        other => panic!("{name}: {other:?}"),
    };
    assert_eq!(line_of("gen_rod_nan.obj"), 1110);
    assert_eq!(line_of("gen_binary.obj"), 1);
    assert_eq!(line_of("gen_rod_badindex.obj"), 6642);
}
