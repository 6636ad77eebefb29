//! Tubes around a map's own edges, without a map on them.
//!
//! In: a map. Out: [`Tubed`]: a closed surface of genus E − V + 1, millimetres. Holds: it does not meet itself unless that
//! was allowed; the report says. Source: [Razafindrazaka2015] §9.2–9.4.

use super::report::{SurfaceReport, TubeReport, TubifyReport};
use super::{NamedMap, scaled};
use crate::error::RemeshError;
use quadloom_mesh::{DVec3, Progress};
use quadloom_regular_maps::realize::{RealizeError, RealizeOptions, Tubified, tubify};
use quadloom_regular_maps::tubes::build_without_intersections;
use quadloom_regular_maps::{RegularMap, TubeError, TubeOptions};
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
    let mut tubes = tubify(&source.map, options, progress)?;
    progress.check()?;
    progress.report("tubes", 0.5);
    let pairs = thin_out(&source.map, &mut tubes, options)?;
    if pairs > 0 && !options.allow_intersections {
        return Err(RealizeError::Intersections { target: source.name.clone(), pairs }.into());
    }
    let mesh = tubes.surface.mesh();
    let (positions, scale) = scaled(mesh.positions().values(), size);
    let report = TubifyReport {
        tubes: TubeReport::of(&source.map, &tubes, scale),
        surface: SurfaceReport::of(mesh, pairs),
        size,
        seconds: start.elapsed().as_secs_f64(),
    };
    Ok(Tubed { tubes, positions, report })
}

/// Makes the tubes thinner until they keep clear of each other; where they never do, leaves them and says in how many
/// pairs of triangles they meet.
fn thin_out(map: &RegularMap, tubes: &mut Tubified, options: &RealizeOptions) -> Result<usize, RemeshError> {
    let radius = Some(tubes.surface.radius());
    match build_without_intersections(map, &tubes.skeleton, &TubeOptions { radius, ..options.tubes.clone() }) {
        Ok(surface) => {
            tubes.surface = surface;
            Ok(0)
        }
        Err(TubeError::Intersects { .. }) => {
            Ok(tubes.surface.self_intersections(MOST_PAIRS).map_err(RealizeError::Tubes)?.len())
        }
        Err(error) => Err(RealizeError::Tubes(error).into()),
    }
}
