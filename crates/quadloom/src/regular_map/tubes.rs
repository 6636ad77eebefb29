//! Tubes around a map's own edges, without a map on them.
//!
//! In: a map. Out: [`Tubed`]: a closed surface of genus E − V + 1, millimetres. Holds: it does not meet itself unless that
//! was allowed; the report says. Source: [Razafindrazaka2015] §9.2–9.4.

use super::NamedMap;
use super::report::{SurfaceReport, TubeReport, TubifyReport};
use crate::error::RemeshError;
use quadloom_mesh::{DVec3, Progress, self_intersections};
use quadloom_tubification::realize::{RealizeError, RealizeOptions, Tubified, sized, tubify};
use std::time::Instant;

/// A tube surface, scaled.
#[derive(Clone, Debug)]
pub struct Tubed {
    /// Skeleton and surface.
    pub tubes: Tubified,
    /// Vertices of the surface's mesh, millimetres, the middle of their bounding box at the origin.
    pub positions: Vec<DVec3>,
    /// What was done and measured.
    pub report: TubifyReport,
}

/// Pairs of intersecting triangles that are counted.
const MOST_PAIRS: usize = 1000;

/// Puts tubes around the edges of a map.
///
/// # Input      a map of valence 3 or more, orientable or not; `size`: largest extent, millimetres
/// # Errors     [`RemeshError::Realize`]
/// # Cost       relaxation, unless the map lies on the sphere or the torus
pub fn tubify_map(
    source: &NamedMap,
    options: &RealizeOptions,
    size: f64,
    progress: &Progress,
) -> Result<Tubed, RemeshError> {
    let start = Instant::now();
    let tubes = tubify(&source.map, options, progress)?;
    progress.check()?;
    progress.report("tubes", 0.5);
    let (mesh, scale) = sized(tubes.surface.mesh(), size).map_err(RealizeError::from)?;
    let (halves, _) =
        sized(&tubes.surface.triangles().map_err(RealizeError::Tubes)?, size).map_err(RealizeError::from)?;
    let pairs = self_intersections(&halves, MOST_PAIRS).len();
    if pairs > 0 && !options.allow_intersections {
        return Err(RealizeError::Intersections { target: source.name.clone(), pairs }.into());
    }
    let report = TubifyReport {
        tubes: TubeReport::of(&source.map, &tubes, scale),
        surface: SurfaceReport::of(&mesh, pairs),
        size,
        seconds: start.elapsed().as_secs_f64(),
    };
    Ok(Tubed { tubes, positions: mesh.positions().values().to_vec(), report })
}
