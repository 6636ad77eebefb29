//! What tiles are asked for.
//!
//! In: what a user types. Out: [`TileRequest`]. Holds: nothing; names and numbers are looked up in the input later.

use quadloom_tiling::maps::MapMethod;
use quadloom_tiling::{DiagonalChoice, Method, SearchMode};
use serde::Serialize;
use std::path::PathBuf;
use std::str::FromStr;

/// Into what a surface is cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Into {
    /// One disk.
    #[default]
    Disk,
    /// One polygon with as few sides as the topology allows: 4g for a closed surface.
    Schema,
    /// Quadrangles: 2g − 1 for a closed surface.
    Quads,
    /// Pairs of pants.
    Pants,
    /// Cylinders, three from each pair of pants.
    Cylinders,
}

/// What a cut costs.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Cost {
    /// Its length.
    #[default]
    Euclidean,
    /// Less where the surface bends, by this weight in 0..=1.
    Curvature(f64),
    /// Its length times the mean of a vertex attribute at the ends of each edge.
    Attribute(String),
}

impl FromStr for Cost {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "euclidean" => Ok(Self::Euclidean),
            Some(("curvature", weight)) => {
                let weight = weight.parse().ok().filter(|c: &f64| (0.0..=1.0).contains(c)).map(Self::Curvature);
                weight.ok_or_else(|| "a weight from 0 to 1 is needed, as in curvature:0.8".into())
            }
            Some(("attribute", name)) if !name.is_empty() => Ok(Self::Attribute(name.into())),
            _ => Err("euclidean | curvature:C | attribute:NAME is needed".into()),
        }
    }
}

impl std::fmt::Display for Cost {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Euclidean => write!(f, "euclidean"),
            Self::Curvature(c) => write!(f, "curvature:{c}"),
            Self::Attribute(name) => write!(f, "attribute:{name}"),
        }
    }
}

/// What is asked for.
#[derive(Clone, Debug, Default)]
pub struct TileRequest {
    /// Into what. Default: one disk.
    pub into: Into,
    /// How one tile is made. Default: single-point for schemas and quadrangles of closed surfaces, intermediate for
    /// those of others, else shortest.
    pub method: Option<Method>,
    /// How far shortest loops are looked for. Default: fast.
    pub search: SearchMode,
    /// What a cut costs. Default: its length.
    pub cost: Cost,
    /// How quadrangles' diagonals are chosen. Default: optimal.
    pub diagonals: DiagonalChoice,
    /// Base point: a vertex of the input, from 0; in its component.
    pub base: Option<u32>,
    /// A vertex attribute: no cut runs through vertices where it is not 0.
    pub forbid: Option<String>,
    /// A file of edges: the surface is cut along these instead of along edges that are looked for.
    pub cut: Option<PathBuf>,
    /// How tiles are mapped to the plane. Default: not at all.
    pub parametrize: Option<MapMethod>,
    /// Whether the tilings between are kept.
    pub steps: bool,
}
