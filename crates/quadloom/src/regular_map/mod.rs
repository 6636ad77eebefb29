//! Regular maps, from what a user names to files.
//!
//! In: a [`MapSpec`], options. Out: lists, matches, flat pictures, and [`Realized`]: a surface in millimetres with a map on
//! it, its colours and a report. Holds: what [`quadloom_regular_maps`] holds: the drawn map was checked on the mesh, and
//! self-intersections were looked for on the final triangles. Source: [Razafindrazaka2015] ch. 9.
//!
//! ```
//! use quadloom::Progress;
//! use quadloom::regular_map::{MapSpec, RealizeRequest, find_map, realize_map};
//!
//! let klein = find_map(&MapSpec::Name("R3.1".into()))?;
//! let result = realize_map(&klein, &RealizeRequest::default(), &Progress::none())?;
//! assert_eq!((result.report.map.faces, result.report.surface.genus), (56, 3));
//! assert_eq!(result.report.surface_of.symmetry.group, "T");
//! # Ok::<(), quadloom::RemeshError>(())
//! ```

mod colors;
mod flat;
mod lists;
mod output;
mod picture;
mod report;
mod request;
mod tubes;

pub use colors::{ColorBy, TubeElement};
pub use flat::{FlatRequest, stage_flat};
pub use lists::{ChiralReport, info, list, matches, search, search_chiral};
pub use output::{stage_realized, stage_tubes};
pub use picture::map_scene;
pub use report::{
    MapReport, MatchReport, RealizeReport, SurfaceReport, SymmetryReport, TubeReport, TubifyReport, target_name,
};
pub use request::{MapSpec, NamedMap, find_map};
pub use tubes::{Tubed, tubify_map};

use crate::error::RemeshError;
use colors::Shown;
use quadloom_mesh::{DVec3, FaceId, Progress};
use quadloom_regular_maps::colouring::Colouring;
use quadloom_regular_maps::{MapError, MatchOptions, RegularMap, TubeMatch, find_matches};
use quadloom_tubification::realize::{Realization, RealizeError, RealizeOptions, realize, realize_on};
use std::time::Instant;

/// How a map is realised.
#[derive(Clone, Debug)]
pub struct RealizeRequest {
    /// The target: a name, an identifier, or a type with or without Petrie length. Default: the one with the best surface.
    pub on: Option<String>,
    /// Geometry and drawing.
    pub options: RealizeOptions,
    /// What has one colour. Default: each face.
    pub colors: ColorBy,
    /// Largest extent of the surface, millimetres. Default 100.
    pub size: f64,
}

impl Default for RealizeRequest {
    fn default() -> Self {
        Self { on: None, options: RealizeOptions::default(), colors: ColorBy::default(), size: 100.0 }
    }
}

/// A map in space, scaled and coloured.
#[derive(Clone, Debug)]
pub struct Realized {
    /// Source, target, surface, drawing.
    pub realization: Realization,
    /// The map that is drawn: the source, or its dual. Faces have its numbers.
    pub shown: RegularMap,
    /// Face of the drawn map of each triangle.
    pub face: Vec<u32>,
    /// Colour class of each triangle.
    pub class: Vec<u32>,
    /// Colour of each class.
    pub palette: Vec<[u8; 3]>,
    /// How the drawn map's flags have these colours; none where tubes have.
    pub colouring: Option<Colouring>,
    /// What was done and measured.
    pub report: RealizeReport,
}

/// Colour of the map's edges.
pub const EDGE_COLOR: [u8; 3] = [0x22, 0x26, 0x2e];

impl Realized {
    /// Vertices, millimetres, the middle of their bounding box at the origin.
    pub fn positions(&self) -> &[DVec3] {
        self.realization.drawing.mesh.positions().values()
    }

    /// The colour of a triangle.
    pub fn color(&self, f: FaceId) -> [u8; 3] {
        if self.realization.drawing.is_edge[f] {
            return EDGE_COLOR;
        }
        self.palette.get(self.class[f.index()] as usize).copied().unwrap_or(EDGE_COLOR)
    }
}

/// Realises a map on the tubes of its target.
///
/// # Output     the surface of the first target that works; a surface that intersects itself only where that is allowed
/// # Errors     [`MapError::NotOrientable`]; [`RealizeError::NoMatch`]; [`RemeshError::NoTarget`] where the source does not
///   match what was asked for; those of [`quadloom_tubification::realize`]
/// # Cost       relaxation, where it is needed, then linear in the triangles
/// # Source     [Razafindrazaka2015] §9.2–9.6
pub fn realize_map(source: &NamedMap, request: &RealizeRequest, progress: &Progress) -> Result<Realized, RemeshError> {
    let start = Instant::now();
    if !source.map.is_orientable() {
        return Err(MapError::NotOrientable(source.name.clone()).into());
    }
    progress.report("match", 0.0);
    let options = RealizeOptions { size: request.size, ..request.options.clone() };
    let realization = match &request.on {
        None => realize(&source.map, &options, progress).map_err(|e| named(e, source))?,
        Some(target) => realize_on_named(source, target, &options, progress)?,
    };
    let drawing = &realization.drawing;
    let shown = Shown::new(&source.map, drawing.drawn);
    let (class, palette, colouring) = colors::of_triangles(&shown, &realization, &request.colors);
    let mut report = report::realized(source, &shown, &realization, realization.scale);
    report.colors = palette.len();
    report.size = request.size;
    report.seconds = start.elapsed().as_secs_f64();
    let face = drawing.flag.values().iter().map(|&g| shown.face(g).0).collect();
    Ok(Realized { face, class, palette, colouring, report, shown: shown.map, realization })
}

/// The same error about a map that has a name.
fn named(error: RealizeError, source: &NamedMap) -> RealizeError {
    match error {
        RealizeError::NoMatch(_) => RealizeError::NoMatch(source.name.clone()),
        other => other,
    }
}

/// Tries the matches with a target that is named; there are several where faces and vertices can lie at its poles.
fn realize_on_named(
    source: &NamedMap,
    target: &str,
    options: &RealizeOptions,
    progress: &Progress,
) -> Result<Realization, RemeshError> {
    let mut first = None;
    for matched in matches_on(source, target)? {
        match realize_on(&source.map, matched, options, progress) {
            Err(RealizeError::Cancelled(stop)) => return Err(stop.into()),
            Err(error) => _ = first.get_or_insert(error),
            Ok(found) => return Ok(found),
        }
    }
    Err(first.unwrap_or_else(|| RealizeError::NoMatch(source.name.clone())).into())
}

/// The matches of a source with a target that is named: at least one.
fn matches_on(source: &NamedMap, target: &str) -> Result<Vec<TubeMatch>, RemeshError> {
    let matches = find_matches(&source.map, &MatchOptions::default());
    if matches.is_empty() {
        return Err(RealizeError::NoMatch(source.name.clone()).into());
    }
    let wanted = find_map(&MapSpec::Name(target.into())).ok();
    let plain: String = target.chars().filter(|c| !c.is_whitespace()).collect();
    let fits = |m: &TubeMatch| {
        let name = m.target.type_name();
        name == plain
            || name.split('_').next() == Some(plain.as_str())
            || wanted.as_ref().is_some_and(|w| w.map == m.target)
            || request::name_of(&m.target).contains(&plain)
    };
    let mut known: Vec<String> = matches.iter().map(|m| target_name(&m.target)).collect();
    known.dedup();
    let fitting: Vec<TubeMatch> = matches.into_iter().filter(fits).collect();
    if fitting.is_empty() {
        let (map, target) = (source.name.clone(), target.into());
        return Err(RemeshError::NoTarget { map, target, known: known.join("; ") });
    }
    Ok(fitting)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_tubification::{DrawOptions, EdgeStyle};

    #[test]
    fn a_surface_that_meets_itself_is_a_result_only_where_that_is_allowed() {
        let klein = find_map(&MapSpec::Name("R3.1".into())).unwrap();
        let mut request = RealizeRequest { on: Some("tetrahedron".into()), ..RealizeRequest::default() };
        // Ridges so high that those of neighbouring tubes meet.
        request.options.draw = DrawOptions { edges: EdgeStyle::Relief(0.3), height: 9.0, ..DrawOptions::default() };
        request.options.tubes.levels = 1;
        let on = |request: &RealizeRequest| realize_map(&klein, request, &Progress::none());
        let error = on(&request).unwrap_err();
        assert_eq!(error.kind(), crate::FailureKind::NoResult);
        assert!(error.to_string().contains("--allow-intersections"), "{error}");
        request.options.allow_intersections = true;
        assert!(on(&request).unwrap().report.surface.self_intersections > 0);
    }
}
