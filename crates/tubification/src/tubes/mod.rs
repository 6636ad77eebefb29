//! Tube surfaces: round tubes around the edges of a target map, softly joined.
//!
//! In: a target map and its [`Skeleton`]. Out: [`TubeSurface`]: a closed quad mesh, a point and a normal for every (u, v) of
//! every quarter-tube.
//! Holds: one quarter-tube per flag; neighbours meet along whole sides, so the quads are a closed oriented surface of genus
//! E − V + 1; rotations that the skeleton has, the surface has. Not: that it keeps clear of itself;
//! [`TubeSurface::self_intersections`] tests that and [`build_without_intersections`] ends with a surface that does.
//! Source: [Razafindrazaka2015] §9.2, §9.4, Fig. 9.11; differs: tubes are a level of a field around the edges
//! ([Bloomenthal1991]), so one rule makes junctions of any valence and in any directions.
//!
//! ```text
//!   P2 ── b ── M2   v = 1      u: from the junction to the middle of the tube. v: around the side on which the flag's face
//!   │          │               lies, from the pole P1 to the pole P2. P1 is on the side of the normal for an upright flag,
//!   a          c               on the other one for an overturned flag. So (u, v) is right-handed seen from outside.
//!   │          │
//!   P1 ── d ── M1   v = 0      a is glued to a of f·r₁, c to c of f·r₀, turned; d to b of f·r₂
//!  u = 0      u = 1
//! ```

mod curve;
mod field;
mod grid;
mod junction;
mod patch;
mod radius;
mod skin;

pub use radius::{build_without_intersections, choose_radius};

use crate::skeleton::{Skeleton, SkeletonDefect, edge_flags, upright_flags};
use curve::Curve;
use glam::DVec3;
use grid::Grid;
use junction::Rims;
use patch::{Neighbours, interpolate, neighbours};
use quadloom_mesh::{FaceId, FaceMap, Id, MeshError, QuadMesh, TriMesh, self_intersections};
use quadloom_regular_maps::ids::{FlagId, MapEdgeId};
use quadloom_regular_maps::map::{Reflection, RegularMap};
use rayon::prelude::*;
use skin::Skin;

/// How tubes are made.
#[derive(Clone, Debug, PartialEq)]
pub struct TubeOptions {
    /// Radius of the tubes, units of the skeleton. Default: [`choose_radius`], made smaller until junctions fit.
    pub radius: Option<f64>,
    /// How far from its edge a tube blends with others, in radii, more than 1. Default 1.5: junctions a little thicker than
    /// tubes. At 1.1 tubes meet in creases; at 2 they swell together far from the junction.
    pub softness: f64,
    /// How often the quads of the cage, two around a quarter-tube, are halved. Default 3: 32 quads around a tube; the
    /// number of quads grows fourfold with each.
    pub levels: usize,
    /// Quads of the cage along a quarter-tube. Default: about twice as long as they are wide.
    pub rings: Option<usize>,
}

impl Default for TubeOptions {
    fn default() -> Self {
        Self { radius: None, softness: 1.5, levels: 3, rings: None }
    }
}

/// Why there are no tubes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TubeError {
    /// The skeleton is not the map's.
    #[error(transparent)]
    Skeleton(#[from] SkeletonDefect),
    /// An option out of its range.
    #[error("{0} is {1}, not {2}")]
    Option(&'static str, f64, &'static str),
    /// An edge without length.
    #[error("edge {0} of the skeleton has no length")]
    NoLength(MapEdgeId),
    /// Junctions that reach to the middle of their tubes.
    #[error("tubes of radius {0} are too thick: junctions reach to the middle of tubes; make them thinner")]
    TooThick(f64),
    /// Edges so close to each other that no tubes fit around them.
    #[error("edges of the skeleton cross or touch, or leave a junction in one direction; no tubes fit around them")]
    NoRoom,
    /// A surface that meets itself.
    #[error("tubes of radius {radius} still meet themselves: {pairs} pairs of triangles or more")]
    Intersects {
        /// The smallest radius tried.
        radius: f64,
        /// Pairs found.
        pairs: usize,
    },
    /// Quads that are no surface: a fault of this library.
    #[error("the tubes are no surface: {0}")]
    Mesh(#[from] MeshError),
}

/// The tube surface of a map's edge graph.
#[derive(Clone, Debug)]
pub struct TubeSurface {
    radius: f64,
    cage: [usize; 3],
    grid: Grid,
    beside: Neighbours,
    mesh: QuadMesh,
    normals: Vec<DVec3>,
    flags: FaceMap<FlagId>,
}

/// Without an asked radius, tubes are made thinner by this factor until junctions fit.
const THINNER: f64 = 0.93;

/// How often: down to about a hundredth of the first radius.
const THINNINGS: usize = 64;

/// Quads of the cage along a quarter-tube at most.
const MOST_RINGS: usize = 24;

impl TubeSurface {
    /// The surface around a skeleton.
    ///
    /// # Input      a skeleton that passes its check
    /// # Errors     [`TubeError`]; [`TubeError::TooThick`] only for a radius that was asked for
    /// # Cost       linear in the quads, each times the points of the edges at its junction
    pub fn build(map: &RegularMap, skeleton: &Skeleton, options: &TubeOptions) -> Result<Self, TubeError> {
        skeleton.check(map)?;
        check(options)?;
        let mut radius = options.radius.unwrap_or_else(|| choose_radius(map, skeleton));
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(TubeError::NoRoom);
        }
        for _ in 0..THINNINGS {
            match Self::of_radius(map, skeleton, options, radius) {
                Err(TubeError::TooThick(_)) if options.radius.is_none() => radius *= THINNER,
                done => return done,
            }
        }
        Err(TubeError::NoRoom)
    }

    fn of_radius(map: &RegularMap, skeleton: &Skeleton, options: &TubeOptions, radius: f64) -> Result<Self, TubeError> {
        let curves = curves(map, skeleton, radius)?;
        let around = 2 << options.levels;
        let along = options.rings.unwrap_or_else(|| rings(&curves, radius)).max(1) << options.levels;
        let skin = Skin::new(map, skeleton, &curves, radius, options.softness);
        let rims = Rims::new(&skin, around);
        let junctions: Option<Vec<f64>> = map.flags().map(|flag| skin.junction_length(flag, &rims)).collect();
        let junctions = junctions.ok_or(TubeError::TooThick(radius))?;
        let grid = Grid::new(map, along, around);
        let place = |node: &grid::Node| {
            let u = node.i as f64 / along as f64;
            skin.point(node.flag, u, node.j, &rims, junctions[node.flag.index()])
        };
        let positions: Vec<DVec3> = grid.nodes().par_iter().map(place).collect();
        let faces = grid.faces(map);
        let flags = (0..faces.len()).map(|face| grid.cell(face).0).collect();
        let normals = normals(&positions, &faces);
        let mesh = QuadMesh::new(positions, &faces)?;
        let cage = grid::cage_counts(map);
        Ok(Self { radius, cage, grid, beside: neighbours(map), mesh, normals, flags })
    }

    /// Radius of the tubes, units of the skeleton.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Vertices, edges and faces of the cage that has one quad per flag: 2V + 2E, 8E and 4E for a map of V vertices and E
    /// edges.
    pub fn cage_counts(&self) -> [usize; 3] {
        self.cage
    }

    /// The surface as quads: closed, oriented outwards. Quads of a flag follow each other, along the tube first.
    pub fn mesh(&self) -> &QuadMesh {
        &self.mesh
    }

    /// The flag on whose quarter-tube each quad lies.
    pub fn flag_of_face(&self) -> &FaceMap<FlagId> {
        &self.flags
    }

    /// Column (along the tube) and row (around it) of a quad on its quarter-tube.
    pub fn cell_of_face(&self, face: FaceId) -> [usize; 2] {
        let (_, i, j) = self.grid.cell(face.index());
        [i, j]
    }

    /// Quads along and around each quarter-tube.
    pub fn cells(&self) -> [usize; 2] {
        [self.grid.along(), self.grid.around()]
    }

    /// The point at (u, v) of a flag's quarter-tube: through the mesh's vertices, smooth between them.
    ///
    /// # Guarantees where quarter-tubes meet, both give the same bits
    pub fn point(&self, flag: FlagId, u: f64, v: f64) -> DVec3 {
        interpolate(&self.grid, &self.beside, self.mesh.positions().values(), (flag, u, v))
    }

    /// The outward unit normal at (u, v) of a flag's quarter-tube.
    ///
    /// # Guarantees where quarter-tubes meet, both give the same bits
    pub fn normal(&self, flag: FlagId, u: f64, v: f64) -> DVec3 {
        interpolate(&self.grid, &self.beside, &self.normals, (flag, u, v)).normalize_or(DVec3::Z)
    }

    /// The surface as triangles: each quad halved along its shorter diagonal, two triangles in the place of each quad.
    pub fn triangles(&self) -> Result<TriMesh, TubeError> {
        let halves = |face: FaceId| {
            let corners = self.mesh.face_vertices(face);
            let [a, b, c, d] = corners.map(|v| v.0);
            let [p, q, r, s] = corners.map(|v| self.mesh.position(v));
            let first = p.distance_squared(r) <= q.distance_squared(s);
            if first { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        };
        let faces: Vec<[u32; 3]> = self.mesh.faces().flat_map(halves).collect();
        Ok(TriMesh::new(self.mesh.positions().values().to_vec(), &faces)?)
    }

    /// Pairs of quads that meet other than in what they share, by the exact test of their triangles.
    ///
    /// # Output     at most `limit` pairs of triangles of [`Self::triangles`]
    pub fn self_intersections(&self, limit: usize) -> Result<Vec<[FaceId; 2]>, TubeError> {
        Ok(self_intersections(&self.triangles()?, limit))
    }
}

fn check(options: &TubeOptions) -> Result<(), TubeError> {
    let radius = options.radius.unwrap_or(1.0);
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(TubeError::Option("the radius of tubes", radius, "positive"));
    }
    if !(1.01..=4.0).contains(&options.softness) {
        return Err(TubeError::Option("the softness of tubes", options.softness, "between 1.01 and 4"));
    }
    if options.levels > 8 {
        return Err(TubeError::Option("the number of levels", options.levels as f64, "at most 8"));
    }
    Ok(())
}

/// The edges' curves with frames. The front line leaves an edge's start on the side of the normal. The line v = 0 of a flag
/// goes on as v = 1 of its r₀-neighbour, so the front line meets the normal's side again where just one of both flags is
/// upright, and the other side, after a half twist, where both are or none is.
fn curves(map: &RegularMap, skeleton: &Skeleton, radius: f64) -> Result<Vec<Curve>, TubeError> {
    let upright = upright_flags(map);
    let bare = curve::along(&skeleton.edges, radius).map_err(|edge| TubeError::NoLength(MapEdgeId::new(edge)))?;
    let framed = |((_, first), curve): ((MapEdgeId, FlagId), Curve)| {
        let there = map.reflect(first, Reflection::R0);
        let [start, end] = [first, there].map(|flag| skeleton.normals[map.vertex(flag).index()]);
        curve.framed(start, if upright[first] != upright[there] { end } else { -end })
    };
    Ok(edge_flags(map).into_iter().zip(bare).map(framed).collect())
}

/// Quads of the cage along a quarter-tube, for the longest tube.
fn rings(curves: &[Curve], radius: f64) -> usize {
    let longest = curves.iter().map(Curve::length).fold(0.0, f64::max);
    let rings = longest / (2.0 * std::f64::consts::PI * radius);
    (rings.ceil() as usize).clamp(2, MOST_RINGS)
}

/// Unit normals at vertices, weighted as on a sphere through the neighbours ([Max1999]).
fn normals(positions: &[DVec3], faces: &[[u32; 4]]) -> Vec<DVec3> {
    let mut sum = vec![DVec3::ZERO; positions.len()];
    for face in faces {
        for k in 0..4 {
            let [before, here, after] = [face[(k + 3) % 4], face[k], face[(k + 1) % 4]].map(|v| v as usize);
            let (a, b) = (positions[after] - positions[here], positions[before] - positions[here]);
            let weight = a.length_squared() * b.length_squared();
            sum[here] += a.cross(b) / weight.max(f64::MIN_POSITIVE);
        }
    }
    sum.into_iter().map(|normal| normal.normalize_or(DVec3::Z)).collect()
}
