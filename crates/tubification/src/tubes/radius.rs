//! How thick tubes can be.
//!
//! In: a map and its skeleton. Out: [`choose_radius`]; [`build_without_intersections`], tubes thinned until they keep clear.
//! Holds: what the exact test of the triangles says decides, not the estimate.

use super::{TubeError, TubeOptions, TubeSurface};
use crate::skeleton::{Skeleton, clearance, extent};
use quadloom_regular_maps::map::RegularMap;

/// Share of the clearance that tubes take. The rest is the gap between tubes, and what junctions swell.
const OF_CLEARANCE: f64 = 0.64;

/// Thickest tubes as a share of the shortest edge: beyond it junctions are all there is to see.
const OF_LENGTH: f64 = 0.09;

/// Tubes that meet are made thinner by this factor,
const SHRINK: f64 = 0.85;

/// and so often: to a seventh.
const SHRINKS: usize = 12;

/// Pairs of triangles looked for.
const PAIRS: usize = 16;

/// A radius for which tubes around a skeleton should keep clear of each other and be longer than thick; 0 where edges
/// cross. [`TubeSurface::build`] makes it smaller where junctions would not fit.
///
/// # Cost       that of [`clearance`]
pub fn choose_radius(map: &RegularMap, skeleton: &Skeleton) -> f64 {
    let length = |edge: &Vec<glam::DVec3>| edge.windows(2).map(|p| p[0].distance(p[1])).sum::<f64>();
    let shortest = skeleton.edges.iter().map(length).fold(f64::INFINITY, f64::min);
    let room = clearance(map, skeleton) * extent(skeleton).1;
    (OF_CLEARANCE * room).min(OF_LENGTH * shortest)
}

/// The surface with the first radius, from the asked or chosen one downwards, for which it does not meet itself.
///
/// # Errors     those of [`TubeSurface::build`]; [`TubeError::Intersects`] where the thinnest tubes tried still do
/// # Cost       a build and a test per radius tried, at most 13
pub fn build_without_intersections(
    map: &RegularMap,
    skeleton: &Skeleton,
    options: &TubeOptions,
) -> Result<TubeSurface, TubeError> {
    let mut surface = TubeSurface::build(map, skeleton, options)?;
    for _ in 0..SHRINKS {
        if surface.self_intersections(1)?.is_empty() {
            return Ok(surface);
        }
        let thinner = TubeOptions { radius: Some(SHRINK * surface.radius()), ..options.clone() };
        surface = TubeSurface::build(map, skeleton, &thinner)?;
    }
    match surface.self_intersections(PAIRS)?.len() {
        0 => Ok(surface),
        pairs => Err(TubeError::Intersects { radius: surface.radius(), pairs }),
    }
}
