//! Guide curves: where quad edges are wanted, drawn by hand or by another program.
//!
//! In: a path to an OBJ with `l` lines or to JSON `[[{"point": [x, y, z]}, …], …]`. Out: [`Guide`] values.
//! Holds: two or more finite points each; not that they lie on any surface.

use crate::atomic::write_atomically;
use crate::error::{ContentDefect, Fault, IoError};
use crate::features::read_polylines;
use crate::surface::read_bytes;
use quadloom_mesh::DVec3;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A curve drawn near a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guide {
    /// Its points in order, file units; a closed curve repeats its first point at the end.
    pub points: Vec<DVec3>,
}

/// A point as JSON has it: an object with a `point`, or the bare triple.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum JsonPoint {
    Object { point: [f64; 3] },
    Bare([f64; 3]),
}

/// Reads guide curves: JSON if the content starts with `[`, else the polylines of an OBJ.
///
/// # Errors     every [`IoError`] of reading
pub fn read_guides(path: impl AsRef<Path>) -> Result<Vec<Guide>, IoError> {
    let path = path.as_ref();
    let bytes = read_bytes(path)?;
    if bytes.trim_ascii_start().starts_with(b"[") {
        return parse_json(&bytes).map_err(|fault| fault.in_file(path));
    }
    let (positions, polylines) = read_polylines(path)?;
    let guide = |line: Vec<u32>| Guide { points: line.iter().map(|&v| positions[v as usize]).collect() };
    Ok(polylines.into_iter().map(guide).collect())
}

/// Writes guide curves as JSON.
///
/// # Errors     those of [`write_atomically`]; [`IoError::InvalidSurface`] if a point is not finite
pub fn write_guides(path: impl AsRef<Path>, guides: &[Guide]) -> Result<(), IoError> {
    let path = path.as_ref();
    if let Some(k) = guides.iter().position(|g| g.points.iter().any(|p| !p.is_finite())) {
        let what = format!("guide {k} has a point that is not finite");
        return Err(IoError::InvalidSurface { path: path.to_path_buf(), what });
    }
    let curves: Vec<Vec<JsonPoint>> =
        guides.iter().map(|g| g.points.iter().map(|p| JsonPoint::Object { point: p.to_array() }).collect()).collect();
    write_atomically(path, |out| {
        serde_json::to_writer(&mut *out, &curves)?;
        out.write_all(b"\n")
    })
}

fn parse_json(bytes: &[u8]) -> Result<Vec<Guide>, Fault> {
    let curves: Vec<Vec<JsonPoint>> = serde_json::from_slice(bytes).map_err(|e| {
        let text = format!("{e}; guides are written [[{{\"point\": [x, y, z]}}, …], …]");
        Fault::line(e.line() as u64, ContentDefect::Malformed(text))
    })?;
    curves.into_iter().enumerate().map(|(k, curve)| guide(k, curve)).collect()
}

fn guide(k: usize, curve: Vec<JsonPoint>) -> Result<Guide, Fault> {
    let point = |p| match p {
        JsonPoint::Object { point } | JsonPoint::Bare(point) => DVec3::from(point),
    };
    let points: Vec<DVec3> = curve.into_iter().map(point).collect();
    if points.len() < 2 {
        let text = format!("guide {k} has {} points; two or more are needed", points.len());
        return Err(Fault::line(1, ContentDefect::Malformed(text)));
    }
    Ok(Guide { points })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_in_both_spellings() {
        let guides = parse_json(br#"[[{"point":[0,1,2]},{"point":[0.1,0,1e-3],"note":1}],[[0,0,0],[1,1,1]]]"#).unwrap();
        assert_eq!(guides[0].points, [DVec3::new(0.0, 1.0, 2.0), DVec3::new(0.1, 0.0, 1e-3)]);
        assert_eq!(guides[1].points, [DVec3::ZERO, DVec3::ONE]);
    }

    #[test]
    fn bad_json_names_the_line() {
        let fault = parse_json(b"[[\n{\"point\":[0,1]}]]").unwrap_err();
        assert!(fault.defect.to_string().contains("point"), "{}", fault.defect);
        assert!(parse_json(b"[[[0,0,0]]]").unwrap_err().defect.to_string().contains("guide 0 has 1"));
        assert!(parse_json(b"[[[0,0,1e999],[0,0,0]]]").is_err());
    }
}
