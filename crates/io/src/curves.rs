//! Curves on a surface, as sources of distances.
//!
//! In: a path to an OBJ with `l` lines, or to JSON. Out: [`CurveFile`]: points in space or on faces.
//! Holds: one or more points each; numbers are finite. Not that they lie on any surface.
//!
//! ```text
//!     [                                                a list of curves, each a list of points:
//!       [{"face": 12, "weights": [0.2, 0.3, 0.5]}, …],   on a face of the input, from 0, by barycentric weights,
//!       [[0, 0, 1], {"point": [1, 0, 1]}, …]             or in space, file units
//!     ]
//! ```

use crate::error::{ContentDefect, Fault, IoError};
use crate::features::read_polylines;
use crate::guides::{json_point, line_of};
use crate::surface::read_bytes;
use quadloom_mesh::DVec3;
use serde_json::Value;
use std::path::Path;

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CurvePoint {
    /// In space, file units.
    Space(DVec3),
    /// On a face of the surface's file, from 0, by weights of its corners.
    OnFace {
        /// The face.
        face: u32,
        /// Weights of its three corners.
        weights: [f64; 3],
    },
}

/// Curves of a file, in its order; a closed curve repeats its first point at the end.
pub type CurveFile = Vec<Vec<CurvePoint>>;

/// Reads curves: JSON if the content starts with `[` or `{`, else the polylines of an OBJ.
///
/// # Errors     every [`IoError`] of reading
pub fn read_curves(path: impl AsRef<Path>) -> Result<CurveFile, IoError> {
    let path = path.as_ref();
    let bytes = read_bytes(path)?;
    if matches!(bytes.trim_ascii_start().first(), Some(b'[' | b'{')) {
        return parse_json(&bytes).map_err(|fault| fault.in_file(path));
    }
    let (positions, polylines) = read_polylines(path)?;
    let curve = |line: Vec<u32>| line.iter().map(|&v| CurvePoint::Space(positions[v as usize])).collect();
    Ok(polylines.into_iter().map(curve).collect())
}

/// What a file of curves looks like, for messages.
const LAYOUT: &str =
    "curves are a list of lists of points: [[[x, y, z], …], [{\"face\": 0, \"weights\": [a, b, c]}, …]]";

fn parse_json(bytes: &[u8]) -> Result<CurveFile, Fault> {
    let malformed = |line: u64, text: String| Fault::line(line, ContentDefect::Malformed(format!("{text}; {LAYOUT}")));
    let curves: Value = serde_json::from_slice(bytes).map_err(|e| malformed(e.line() as u64, e.to_string()))?;
    let wrong = |at: &[usize], text: String| malformed(line_of(bytes, at), text);
    let curves = curves.as_array().ok_or_else(|| wrong(&[], "this is an object, not a list".into()))?;
    if curves.is_empty() {
        return Err(wrong(&[], "there is no curve in the list".into()));
    }
    let mut read = Vec::with_capacity(curves.len());
    for (k, curve) in curves.iter().enumerate() {
        let points = curve.as_array().ok_or_else(|| wrong(&[k], format!("curve {} is not a list", k + 1)))?;
        if points.is_empty() {
            return Err(wrong(&[k], format!("curve {} has no point", k + 1)));
        }
        let point = |(i, p): (usize, &Value)| {
            let text = || format!("curve {}, point {} is neither [x, y, z] nor a face with weights", k + 1, i + 1);
            curve_point(p).ok_or_else(|| wrong(&[k, i], text()))
        };
        read.push(points.iter().enumerate().map(point).collect::<Result<_, _>>()?);
    }
    Ok(read)
}

fn curve_point(value: &Value) -> Option<CurvePoint> {
    let Some(face) = value.get("face") else { return json_point(value).map(CurvePoint::Space) };
    let face = u32::try_from(face.as_u64()?).ok()?;
    let weights: Vec<f64> = value
        .get("weights")?
        .as_array()?
        .iter()
        .map(|x| x.as_f64().filter(|x| x.is_finite()))
        .collect::<Option<_>>()?;
    Some(CurvePoint::OnFace { face, weights: weights.try_into().ok()? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_in_space_and_on_faces() {
        let text = br#"[[{"face":3,"weights":[0.5,0.5,0]},[0,1,2]],[{"point":[1,1,1]}]]"#;
        let curves = parse_json(text).unwrap();
        assert_eq!(curves[0][0], CurvePoint::OnFace { face: 3, weights: [0.5, 0.5, 0.0] });
        assert_eq!(curves[0][1], CurvePoint::Space(DVec3::new(0.0, 1.0, 2.0)));
        assert_eq!(curves[1], [CurvePoint::Space(DVec3::ONE)]);
    }

    #[test]
    fn what_is_no_point_is_named_with_its_line() {
        for (text, line, part) in [
            ("[[{\"face\":-1,\"weights\":[1,0,0]}]]", 1, "curve 1, point 1"),
            ("[[[0,0,0],\n{\"face\":1,\"weights\":[1,0]}]]", 2, "curve 1, point 2"),
            ("[[[0,0,0]],\n[]]", 2, "curve 2 has no point"),
            ("{}", 1, "object"),
        ] {
            let error = parse_json(text.as_bytes()).unwrap_err().in_file(Path::new("c.json")).to_string();
            assert!(error.contains(part) && error.contains(&format!("line {line}")), "{error}");
        }
    }
}
