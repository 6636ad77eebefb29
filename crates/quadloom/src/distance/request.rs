//! What distances are asked for.
//!
//! In: what a user names, in the numbers of the input. Out: [`DistanceRequest`]. Holds: nothing; names are looked up
//! in the surface by `sources`.

use quadloom_io::{CurvePoint, IoError, read_curves};
use quadloom_mesh::DVec3;
use std::path::PathBuf;
use std::str::FromStr;

/// Sharp edges as sources: least dihedral angle, degrees, where none is named. That of `remesh`.
pub const FEATURE_ANGLE: f64 = 35.0;

/// One `--from`.
#[derive(Clone, Debug, PartialEq)]
pub enum From {
    /// Vertices of the input, from 0.
    Vertices(Vec<u32>),
    /// The point of the surface nearest to a point, file units.
    Point(DVec3),
    /// All boundary curves.
    Boundary,
    /// Edges that bend by more than an angle, degrees.
    Features(f64),
    /// Curves of a file.
    Curve(PathBuf),
}

impl FromStr for From {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, rest) = text.split_once(':').map_or((text, None), |(kind, rest)| (kind, Some(rest)));
        match (kind, rest) {
            ("vertices" | "vertex", Some(list)) => {
                let ids: Option<Vec<u32>> = list.split(',').map(|v| v.trim().parse().ok()).collect();
                ids.map(Self::Vertices)
                    .ok_or_else(|| format!("`{list}`: vertex numbers from 0 are needed, as in vertices:3,17"))
            }
            ("point", Some(list)) => {
                let xyz: Option<Vec<f64>> =
                    list.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
                let xyz: Option<[f64; 3]> = xyz.and_then(|xyz| xyz.try_into().ok());
                let point = xyz.map(|xyz| Self::Point(DVec3::from(xyz)));
                point.ok_or_else(|| format!("`{list}`: three numbers are needed, as in point:0,0.5,-1"))
            }
            ("boundary", None) => Ok(Self::Boundary),
            ("features", None) => Ok(Self::Features(FEATURE_ANGLE)),
            ("features", Some(degrees)) => {
                let degrees = degrees.parse().ok().filter(|d: &f64| *d > 0.0 && *d <= 180.0).map(Self::Features);
                degrees.ok_or_else(|| "degrees above 0 and up to 180 are needed, as in features:40".into())
            }
            ("curve", Some(path)) if !path.is_empty() => Ok(Self::Curve(path.into())),
            _ => Err("vertices:I,J,… | point:X,Y,Z | boundary | features[:DEG] | curve:FILE is needed".into()),
        }
    }
}

impl std::fmt::Display for From {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Vertices(list) => {
                let list: Vec<String> = list.iter().map(u32::to_string).collect();
                write!(f, "vertices:{}", list.join(","))
            }
            Self::Point(p) => write!(f, "point:{},{},{}", p.x, p.y, p.z),
            Self::Boundary => f.write_str("boundary"),
            Self::Features(degrees) => write!(f, "features:{degrees}"),
            Self::Curve(path) => write!(f, "curve:{}", path.display()),
        }
    }
}

/// Lines of equal distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lines {
    /// So many, evenly spaced up to the largest distance.
    Count(usize),
    /// Every so often, file units.
    Spacing(f64),
}

impl FromStr for Lines {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let count =
            || text.parse().ok().filter(|&n: &usize| n > 0 && n <= quadloom_geodesic::MOST_VALUES).map(Self::Count);
        let spacing = || text.parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite()).map(Self::Spacing);
        let whole = text.bytes().all(|b| b.is_ascii_digit());
        let lines = if whole { count() } else { spacing() };
        lines.ok_or_else(|| "a whole number of lines, or a spacing with a decimal point, is needed: 20 or 0.5".into())
    }
}

/// What distances are asked for.
#[derive(Clone, Debug)]
pub struct DistanceRequest {
    /// What distances are measured from; source `i` of the results is number `i`.
    pub from: Vec<From>,
    /// Distance with which each starts, file units; missing ones start at 0.
    pub start: Vec<f64>,
    /// Relative error that final distances may have, 0 ≤ ε < 1. Default 0: exact.
    pub epsilon: f64,
    /// How far a source may be from the surface, relative to the surface's diagonal. Default 0.05: points read off a
    /// picture are nearer, those in other units are nowhere near.
    pub snap_rel: f64,
    /// Refine the mesh until distances along its edges are linear up to this, file units.
    pub refine: Option<f64>,
    /// Lines of equal distance.
    pub isolines: Option<Lines>,
    /// Points from which the shortest paths are traced: vertices and points only.
    pub path_from: Vec<From>,
    /// Whether what a picture shows besides (a fine mesh, cut locus, sources as curves) is computed.
    pub picture: bool,
}

impl Default for DistanceRequest {
    fn default() -> Self {
        Self {
            from: Vec::new(),
            start: Vec::new(),
            epsilon: 0.0,
            snap_rel: 0.05,
            refine: None,
            isolines: None,
            path_from: Vec::new(),
            picture: false,
        }
    }
}

/// A source whose files have been read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Named {
    Vertices(Vec<u32>),
    Points(Vec<CurvePoint>),
    Boundary,
    Features(f64),
    Curves(Vec<Vec<CurvePoint>>),
}

impl Named {
    /// # Errors     every error of reading
    pub fn read(from: &From) -> Result<Self, IoError> {
        Ok(match from {
            From::Vertices(list) => Self::Vertices(list.clone()),
            From::Point(p) => Self::Points(vec![CurvePoint::Space(*p)]),
            From::Boundary => Self::Boundary,
            From::Features(degrees) => Self::Features(*degrees),
            From::Curve(path) => Self::Curves(read_curves(path)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_printed_reads_back() {
        for text in ["vertices:1,20", "point:0.5,-1,1e-7", "boundary", "features:40", "curve:a:b.json"] {
            let from: From = text.parse().unwrap();
            assert_eq!(from.to_string().parse::<From>().unwrap(), from);
        }
        assert_eq!("features".parse::<From>(), Ok(From::Features(FEATURE_ANGLE)));
    }

    #[test]
    fn what_names_no_source_is_refused() {
        for text in [
            "vertices:",
            "vertices:-1",
            "vertices:1;2",
            "point:1,2",
            "point:1,2,nan",
            "edges",
            "boundary:3",
            "features:0",
            "features:x",
            "curve:",
            "",
        ] {
            assert!(text.parse::<From>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_whole_number_is_a_count_of_lines() {
        assert_eq!("20".parse(), Ok(Lines::Count(20)));
        assert_eq!("20.0".parse(), Ok(Lines::Spacing(20.0)));
        assert_eq!("1e-3".parse(), Ok(Lines::Spacing(1e-3)));
        for text in ["0", "-1", "0.0", "nan", "inf", "x", ""] {
            assert!(text.parse::<Lines>().is_err(), "{text}");
        }
    }
}
