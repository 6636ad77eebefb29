//! A source map in space: target, skeleton, tubes, drawing, and what all of it turned out to be.
//!
//! In: a source map; [`RealizeOptions`]. Out: [`Realization`].
//! Holds: the drawn map passed its check; the surface is closed; the number of self-intersections of the final triangles is
//! stated and zero unless more were allowed; the rotation group is measured on the surface.
//! Source: [Razafindrazaka2015] §9.2–9.6, Fig. 9.17.

use crate::drawing::{DrawError, DrawOptions, Drawing, DrawnCounts, EdgeStyle, draw};
use crate::rotations::{Measured, measure};
use crate::skeleton::{self, RelaxOptions, Relaxed, Skeleton, SkeletonError, Symmetry};
use crate::tubes::{TubeError, TubeOptions, TubeSurface, build_without_intersections};
use glam::DVec3;
use quadloom_mesh::{Cancelled, FaceId, FaceShape, Mesh, MeshError, Progress, VertexId, VertexMap, self_intersections};
use quadloom_regular_maps::map::RegularMap;
use quadloom_regular_maps::matching::{MatchOptions, TubeMatch, find_matches};
use serde::Serialize;

/// How a skeleton is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SkeletonKind {
    /// Exact where the target lies on a sphere or torus and no group is asked for by name, else relaxed, else drawn.
    #[default]
    Auto,
    /// Straight edges or arcs of a map on the sphere.
    Sphere,
    /// Geodesics of a flat torus on a torus in space.
    Torus,
    /// The target drawn on a tube surface of its own target ([Razafindrazaka2015] §9.2, the sequence M_i).
    Drawn,
    /// Targetless: the edge graph, relaxed (§9.2–9.4).
    Relaxed,
}

/// How a map is realised.
#[derive(Clone, Debug)]
pub struct RealizeOptions {
    /// Where the skeleton comes from. Default: what is known to be best.
    pub skeleton: SkeletonKind,
    /// Relaxation.
    pub relax: RelaxOptions,
    /// Tubes.
    pub tubes: TubeOptions,
    /// Drawing; `height` counts in tube radii here, and `steps` are at least the cells of the tubes, or every other one of them.
    pub draw: DrawOptions,
    /// Radius of the tubes as a share of the largest that has room. Default 1.
    pub thickness: f64,
    /// Largest extent of the surface; its vertices are then rounded to single precision, so that files of any format hold
    /// the surface that was tested. Default 100, millimetres.
    pub size: f64,
    /// Whether a surface that intersects itself is still a result. Default: no.
    pub allow_intersections: bool,
}

impl Default for RealizeOptions {
    fn default() -> Self {
        Self {
            skeleton: SkeletonKind::Auto,
            relax: RelaxOptions::default(),
            tubes: TubeOptions::default(),
            draw: DrawOptions::default(),
            thickness: 1.0,
            size: 100.0,
            allow_intersections: false,
        }
    }
}

/// A map in space.
#[derive(Clone, Debug)]
pub struct Realization {
    /// The target and how quarter-tubes lie in the source's plane.
    pub matched: TubeMatch,
    /// The surface.
    pub tubes: Tubified,
    /// The map on it, of the asked size, the middle of its bounding box at the origin.
    pub drawing: Drawing,
    /// Size of the drawing relative to the skeleton.
    pub scale: f64,
    /// Height of ridges and reliefs, in the drawing's units: lower than asked for where there was no room.
    pub relief: f64,
    /// What was counted on the drawing.
    pub counts: DrawnCounts,
    /// Pairs of triangles of the drawing that meet where they should not.
    pub intersections: Vec<[FaceId; 2]>,
}

/// A target's edge graph as tubes.
#[derive(Clone, Debug)]
pub struct Tubified {
    /// The tubes' axes.
    pub skeleton: Skeleton,
    /// Where they come from.
    pub kind: SkeletonKind,
    /// The surface.
    pub surface: TubeSurface,
    /// The rotations that it has.
    pub rotations: Measured,
}

/// Why a map could not be realised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RealizeError {
    /// There is no target.
    #[error(
        "{0} matches no tube surface; its own edges can be tubified instead (`regular-map tubify`), or it can be drawn \
         flat (`regular-map tile`)"
    )]
    NoMatch(String),
    /// The target has no skeleton of this kind.
    #[error("the target {target} has no {kind} skeleton; choose another one, or auto")]
    NoSkeleton {
        /// The target.
        target: String,
        /// The kind asked for.
        kind: &'static str,
    },
    /// No skeleton at all.
    #[error(transparent)]
    Skeleton(#[from] SkeletonError),
    /// No tubes.
    #[error(transparent)]
    Tubes(TubeError),
    /// No drawing.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// A size that cannot be.
    #[error("the surface cannot have this size: {0}")]
    Size(#[from] MeshError),
    /// The surface intersects itself.
    #[error(
        "the tubes around {target} intersect themselves ({pairs} pairs of triangles or more) however thin they are made; \
         allow it to get the surface all the same, or choose another target, skeleton or symmetry"
    )]
    Intersections {
        /// The target.
        target: String,
        /// Pairs found.
        pairs: usize,
    },
    /// Stopped from outside.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Realises a source map on the best of its targets that works.
///
/// # Errors     [`RealizeError::NoMatch`]; the first target's error where none works
/// # Cost       relaxation, where it is needed, then linear in the triangles
pub fn realize(
    source: &RegularMap,
    options: &RealizeOptions,
    progress: &Progress,
) -> Result<Realization, RealizeError> {
    let mut matches = find_matches(source, &MatchOptions::default());
    matches.sort_by_key(|m| preference(&m.target));
    let mut first = None;
    for found in matches {
        match realize_on(source, found, options, progress) {
            Err(RealizeError::Cancelled(stop)) => return Err(stop.into()),
            Err(error) => _ = first.get_or_insert(error),
            done => return done,
        }
    }
    Err(first.unwrap_or_else(|| RealizeError::NoMatch(source.to_string())))
}

/// Which targets give the best surfaces: solids, then graphs with several junctions, then bunches and bouquets; twisted
/// tubes last.
fn preference(target: &RegularMap) -> (bool, bool, usize, std::cmp::Reverse<usize>) {
    let solid = target.genus() == 0 && target.vertex_count() > 2;
    let exact = if target.is_orientable() { target.genus().min(2) } else { 2 };
    (
        !target.is_orientable(),
        !solid,
        if target.vertex_count() > 2 { 0 } else { 1 + exact },
        std::cmp::Reverse(target.vertex_count()),
    )
}

/// Realises a source map on one of its targets.
///
/// # Errors     see [`RealizeError`]
pub fn realize_on(
    source: &RegularMap,
    matched: TubeMatch,
    options: &RealizeOptions,
    progress: &Progress,
) -> Result<Realization, RealizeError> {
    let mut tubes = tubify(&matched.target, options, progress)?;
    let mut relief = options.draw.height;
    for left in (0..=TRIES).rev() {
        progress.check()?;
        progress.report("draw", 1.0 - left as f64 / TRIES as f64);
        let (mut drawing, counts) = draw_on(source, &matched, &tubes.surface, relief, options)?;
        let (scale, intersections) = untangled(&mut drawing, options.size)?;
        if intersections.is_empty() || (left == 0 && options.allow_intersections) {
            tubes.rotations = rotations(&matched.target, &tubes.surface);
            let relief = relief * tubes.surface.radius() * scale;
            return Ok(Realization { matched, tubes, drawing, scale, relief, counts, intersections });
        }
        if left == 0 {
            let target = matched.target.to_string();
            return Err(RealizeError::Intersections { target, pairs: intersections.len() });
        }
        // Ridges need room: first they are made lower, then tubes thinner, until nothing meets.
        if relief > LEAST_RELIEF * options.draw.height {
            relief *= LOWER;
        } else {
            tubes.surface = thinner(&matched.target, &tubes, SHRINK, options)?;
        }
    }
    Err(RealizeError::NoMatch(source.to_string()))
}

/// How often vertices of triangles that meet are moved to their flat cells, before all are.
const FLATTENINGS: usize = 4;

/// Brings a drawing to its size. Where thin triangles meet each other on the bends of the smooth surface, vertices move to
/// the flat triangles of their cells, on which they do not.
fn untangled(drawing: &mut Drawing, size: f64) -> Result<(f64, Vec<[FaceId; 2]>), MeshError> {
    let smooth = drawing.mesh.clone();
    let mut is_flat: VertexMap<bool> = smooth.vertices().map(|_| false).collect();
    for round in 0..=FLATTENINGS {
        let place = |v: VertexId| if is_flat[v] { drawing.flat[v] } else { smooth.position(v) };
        let (mesh, scale) = sized(&smooth.with_positions(smooth.vertices().map(place).collect())?, size)?;
        let pairs = self_intersections(&mesh, MOST_PAIRS);
        drawing.mesh = mesh;
        if pairs.is_empty() || round == FLATTENINGS {
            return Ok((scale, pairs));
        }
        let all = round + 1 == FLATTENINGS || pairs.len() >= MOST_PAIRS;
        if all {
            is_flat = smooth.vertices().map(|_| true).collect();
        }
        for v in pairs.iter().flatten().flat_map(|&f| smooth.face_vertices(f)) {
            is_flat[v] = true;
            smooth.outgoing(v).for_each(|h| is_flat[smooth.target(h)] = true);
        }
    }
    Ok((1.0, Vec::new()))
}

/// A mesh of some largest extent, the middle of its bounding box at the origin, rounded to single precision; and the factor.
///
/// # Errors     a size that is not finite
pub fn sized<S: FaceShape>(mesh: &Mesh<S>, size: f64) -> Result<(Mesh<S>, f64), MeshError> {
    let (low, high) = mesh.bounding_box();
    let scale = size / (high - low).max_element().max(f64::MIN_POSITIVE);
    let middle = 0.5 * (low + high);
    let place = |&p: &DVec3| ((p - middle) * scale).as_vec3().as_dvec3();
    Ok((mesh.with_positions(mesh.positions().values().iter().map(place).collect())?, scale))
}

/// Pairs of intersecting triangles that are counted.
const MOST_PAIRS: usize = 1000;
/// How often ridges are made lower or tubes thinner.
const TRIES: usize = 7;
/// How much tubes are made thinner.
const SHRINK: f64 = 0.85;
/// How much ridges are made lower, and down to which part of their height.
const LOWER: f64 = 0.4;
const LEAST_RELIEF: f64 = 0.05;

/// Cells of the surface that drawings follow, all of them up to this number, then every other one.
const MOST_CELLS: usize = 100_000;

/// Cells along and around a quarter-tube.
fn cells(target: &RegularMap, surface: &TubeSurface, options: &RealizeOptions) -> [usize; 2] {
    let [along, around] = surface.cells();
    let halve = if along * around * target.order() > MOST_CELLS { 2 } else { 1 };
    [(along / halve).max(options.draw.steps[0]), (around / halve).max(options.draw.steps[1])]
}

fn draw_on(
    source: &RegularMap,
    matched: &TubeMatch,
    surface: &TubeSurface,
    relief: f64,
    options: &RealizeOptions,
) -> Result<(Drawing, DrawnCounts), RealizeError> {
    let place = |flag, u, v| (surface.point(flag, u, v), surface.normal(flag, u, v));
    let steps = cells(&matched.target, surface, options);
    let draw_options = DrawOptions { height: relief * surface.radius(), steps, ..options.draw };
    Ok(draw(source, matched, place, &draw_options)?)
}

/// The tube surface of a map's edge graph.
///
/// # Errors     see [`RealizeError`]
/// # Source     [Razafindrazaka2015] §9.2–9.4
pub fn tubify(target: &RegularMap, options: &RealizeOptions, progress: &Progress) -> Result<Tubified, RealizeError> {
    // Exact skeletons have the symmetry that they have; another one has to be relaxed.
    let named = matches!(options.relax.symmetry, Symmetry::Named(_));
    let kind = if named && options.skeleton == SkeletonKind::Auto { SkeletonKind::Relaxed } else { options.skeleton };
    let torus = || skeleton::torus(target).filter(|_| kind == SkeletonKind::Auto);
    // A flat torus loses some symmetry in space: a relaxed skeleton may have more of it.
    if let Some(bent) = torus().filter(|_| target.edge_count() <= MOST_COMPARED) {
        let bent = tubified(target, bent, SkeletonKind::Torus, options);
        let relaxed = tubify_as(target, SkeletonKind::Relaxed, options, progress);
        return match (bent, relaxed) {
            (_, Err(RealizeError::Cancelled(stop))) => Err(stop.into()),
            (Ok(bent), Ok(relaxed)) if bent.rotations.elements.len() >= relaxed.rotations.elements.len() => Ok(bent),
            (_, Ok(relaxed)) => Ok(relaxed),
            (bent, _) => bent,
        };
    }
    tubify_as(target, kind, options, progress)
}

/// Edges of a torus at most for which both skeletons are made.
const MOST_COMPARED: usize = 40;

/// With a skeleton of this kind; where it is relaxed, with another one too if tubes meet.
fn tubify_as(
    target: &RegularMap,
    kind: SkeletonKind,
    options: &RealizeOptions,
    progress: &Progress,
) -> Result<Tubified, RealizeError> {
    let mut first = None;
    for slope in [1.0, FLATTER] {
        let relax = RelaxOptions { slope: slope * options.relax.slope, ..options.relax.clone() };
        let options = RealizeOptions { skeleton: kind, relax, ..options.clone() };
        let (skeleton, kind) = skeleton_of(target, &options, progress)?;
        progress.report("tubes", 0.0);
        match tubified(target, skeleton, kind, &options) {
            // Another skeleton is found where edges are to leave their junctions less steeply.
            Err(error @ RealizeError::Tubes(TubeError::Intersects { .. })) if kind == SkeletonKind::Relaxed => {
                first = first.or(Some(error));
            }
            done => return done,
        }
    }
    Err(first.unwrap_or_else(|| RealizeError::NoMatch(target.to_string())))
}

fn tubified(
    target: &RegularMap,
    skeleton: Skeleton,
    kind: SkeletonKind,
    options: &RealizeOptions,
) -> Result<Tubified, RealizeError> {
    let surface = surface_on(target, &skeleton, options).map_err(RealizeError::Tubes)?;
    let rotations = rotations(target, &surface);
    Ok(Tubified { skeleton, kind, surface, rotations })
}

/// Slope of stars where steeper ones have no tubes.
const FLATTER: f64 = 0.3;

fn surface_on(target: &RegularMap, skeleton: &Skeleton, options: &RealizeOptions) -> Result<TubeSurface, TubeError> {
    let surface = match build_without_intersections(target, skeleton, &options.tubes) {
        Err(TubeError::Intersects { .. }) if options.allow_intersections => {
            TubeSurface::build(target, skeleton, &options.tubes)?
        }
        done => done?,
    };
    if options.thickness >= 1.0 {
        return Ok(surface);
    }
    let radius = Some(options.thickness * surface.radius());
    TubeSurface::build(target, skeleton, &TubeOptions { radius, ..options.tubes.clone() })
}

fn thinner(
    target: &RegularMap,
    tubes: &Tubified,
    by: f64,
    options: &RealizeOptions,
) -> Result<TubeSurface, RealizeError> {
    let radius = Some(by * tubes.surface.radius());
    let options = TubeOptions { radius, ..options.tubes.clone() };
    TubeSurface::build(target, &tubes.skeleton, &options).map_err(RealizeError::Tubes)
}

fn rotations(target: &RegularMap, surface: &TubeSurface) -> Measured {
    measure(target, |flag| SAMPLES.map(|[u, v]| surface.point(flag, u, v)).to_vec())
}

/// Points of a quarter-tube that decide about symmetry: its corners do not tell all twists apart, so others are with them.
const SAMPLES: [[f64; 2]; 4] = [[0.0, 0.0], [0.25, 0.5], [0.625, 0.25], [1.0, 0.5]];

fn skeleton_of(
    target: &RegularMap,
    options: &RealizeOptions,
    progress: &Progress,
) -> Result<(Skeleton, SkeletonKind), RealizeError> {
    let missing = |kind| RealizeError::NoSkeleton { target: target.to_string(), kind };
    let exact = |kind| match kind {
        SkeletonKind::Sphere => skeleton::spherical(target).ok_or_else(|| missing("spherical")),
        _ => skeleton::torus(target).ok_or_else(|| missing("toroidal")),
    };
    let kind = options.skeleton;
    match kind {
        SkeletonKind::Sphere | SkeletonKind::Torus => Ok((exact(kind)?, kind)),
        SkeletonKind::Drawn => drawn(target, options, progress)?.map(|s| (s, kind)).ok_or_else(|| missing("drawn")),
        SkeletonKind::Relaxed => Ok((relax(target, options, progress)?.skeleton, kind)),
        SkeletonKind::Auto => {
            for kind in [SkeletonKind::Sphere, SkeletonKind::Torus] {
                if let Ok(skeleton) = exact(kind) {
                    return Ok((skeleton, kind));
                }
            }
            match relax(target, options, progress) {
                Ok(found) => Ok((found.skeleton, SkeletonKind::Relaxed)),
                Err(SkeletonError::Cancelled(stop)) => Err(stop.into()),
                Err(error) => match drawn(target, options, progress)? {
                    Some(skeleton) => Ok((skeleton, SkeletonKind::Drawn)),
                    None => Err(error.into()),
                },
            }
        }
    }
}

fn relax(target: &RegularMap, options: &RealizeOptions, progress: &Progress) -> Result<Relaxed, SkeletonError> {
    progress.report("relax", 0.0);
    skeleton::relax(target, &options.relax, progress)
}

/// The target drawn on the tubes of one of its own targets, if there is one ([Razafindrazaka2015] §9.2).
fn drawn(target: &RegularMap, options: &RealizeOptions, progress: &Progress) -> Result<Option<Skeleton>, RealizeError> {
    let inner = RealizeOptions {
        skeleton: SkeletonKind::Auto,
        draw: DrawOptions { edges: EdgeStyle::None, ..DrawOptions::default() },
        tubes: TubeOptions::default(),
        ..options.clone()
    };
    match realize(target, &inner, progress) {
        Ok(found) => Ok(Some(found.drawing.skeleton(target)?)),
        Err(RealizeError::Cancelled(stop)) => Err(stop.into()),
        Err(_) => Ok(None),
    }
}
