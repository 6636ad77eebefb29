//! Guide curves: where quad edges are wanted, drawn by hand or by another program.
//!
//! In: a path to an OBJ with `l` lines or to JSON. Out: [`Guide`] values.
//! Holds: two or more finite points each; not that they lie on any surface.
//!
//! ```text
//!     [                                  a list of curves,
//!       [[0, 0, 1], [1, 0, 1]],          each a list of points in file units,
//!       [{"point": [0, 1, 0]}, …]        each [x, y, z] or an object with a "point"
//!     ]
//! ```

use crate::atomic::write_atomically;
use crate::error::{ContentDefect, Fault, IoError};
use crate::features::read_polylines;
use crate::surface::read_bytes;
use quadloom_mesh::DVec3;
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

/// A curve drawn near a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guide {
    /// Its points in order, file units; a closed curve repeats its first point at the end.
    pub points: Vec<DVec3>,
}

/// A point as it is written.
#[derive(Serialize)]
struct JsonPoint {
    point: [f64; 3],
}

/// Reads guide curves: JSON if the content starts with `[` or `{`, else the polylines of an OBJ.
///
/// # Errors     every [`IoError`] of reading
pub fn read_guides(path: impl AsRef<Path>) -> Result<Vec<Guide>, IoError> {
    let path = path.as_ref();
    let bytes = read_bytes(path)?;
    if matches!(bytes.trim_ascii_start().first(), Some(b'[' | b'{')) {
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
        guides.iter().map(|g| g.points.iter().map(|p| JsonPoint { point: p.to_array() }).collect()).collect();
    write_atomically(path, |out| {
        serde_json::to_writer(&mut *out, &curves)?;
        out.write_all(b"\n")
    })
}

/// What a file of guides looks like, for messages.
const LAYOUT: &str = "guides are a list of curves, each a list of points: [[[x, y, z], …], …]";

fn parse_json(bytes: &[u8]) -> Result<Vec<Guide>, Fault> {
    let malformed = |line: u64, text: String| Fault::line(line, ContentDefect::Malformed(format!("{text}; {LAYOUT}")));
    let curves: Value = serde_json::from_slice(bytes).map_err(|e| malformed(e.line() as u64, e.to_string()))?;
    let wrong = |at: &[usize], text: String| malformed(line_of(bytes, at), text);
    let curves = curves.as_array().ok_or_else(|| wrong(&[], "this is an object, not a list".into()))?;
    if curves.is_empty() {
        return Err(wrong(&[], "there is no curve in the list".into()));
    }
    let mut guides = Vec::with_capacity(curves.len());
    for (k, curve) in curves.iter().enumerate() {
        let points = curve.as_array().ok_or_else(|| wrong(&[k], format!("curve {} is not a list", k + 1)))?;
        if points.len() < 2 {
            return Err(wrong(&[k], format!("curve {} has {} points; two or more are needed", k + 1, points.len())));
        }
        let point = |(i, p): (usize, &Value)| {
            let text = || format!("curve {}, point {} is not three finite numbers", k + 1, i + 1);
            json_point(p).ok_or_else(|| wrong(&[k, i], text()))
        };
        guides.push(Guide { points: points.iter().enumerate().map(point).collect::<Result<_, _>>()? });
    }
    Ok(guides)
}

/// An object with a `point`, or the bare triple.
pub(crate) fn json_point(value: &Value) -> Option<DVec3> {
    let triple = value.get("point").unwrap_or(value).as_array()?;
    let numbers: Vec<f64> = triple.iter().map(|x| x.as_f64().filter(|x| x.is_finite())).collect::<Option<_>>()?;
    Some(DVec3::from(<[f64; 3]>::try_from(numbers).ok()?))
}

/// The line, from 1, on which an element of nested lists starts: `[2, 0]` is the first of the third.
///
/// # Input      bytes: valid JSON; at: numbers of elements, outermost first
pub(crate) fn line_of(bytes: &[u8], at: &[usize]) -> u64 {
    let (mut line, mut in_string, mut escaped) = (1, false, false);
    // Numbers of the elements that the place belongs to, as far as lists go; an object counts as one, too.
    let mut path: Vec<usize> = Vec::new();
    for &b in bytes {
        if !in_string && !b.is_ascii_whitespace() && !matches!(b, b']' | b'}' | b',') && path == at {
            return line;
        }
        match b {
            b'\n' => line += 1,
            _ if in_string => {
                in_string = escaped || b != b'"';
                escaped = b == b'\\' && !escaped;
            }
            b'"' => in_string = true,
            b'[' | b'{' => path.push(0),
            b']' | b'}' => _ = path.pop(),
            b',' => _ = path.last_mut().map(|k| *k += 1),
            _ => {}
        }
    }
    line
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
    fn bad_json_names_the_line_and_the_element() {
        for (text, line, part) in [
            ("[[\n{\"point\":[0,1]}]]", 1, "curve 1 has 1 points"),
            ("[[[0,0,0]]]", 1, "curve 1 has 1 points"),
            ("[[[0,0,0],[1,1,1]],\n [[0,0,0],\n\n  {\"x\":\"[,\\\"\",\"point\":[1,2]}]]", 4, "curve 2, point 2"),
            ("[[[0,0,0],\n[1,\"a\",1]]]", 2, "curve 1, point 2"),
            ("[[[0,0,0],[1,1,1]],\n3]", 2, "curve 2 is not a list"),
            ("\n{\"curves\":[]}", 2, "object"),
            ("\n[]\n", 2, "no curve"),
            ("[[[0,0,0],\n[0,0,1e999]]]", 2, "range"),
            ("[[[0,0,0],\n[0,0,]]]", 2, "column"),
        ] {
            let fault = parse_json(text.as_bytes()).unwrap_err();
            assert_eq!(fault.place, crate::Place::Line(line), "{text:?}: {}", fault.defect);
            assert!(fault.defect.to_string().contains(part), "{text:?}: {}", fault.defect);
        }
    }
}
