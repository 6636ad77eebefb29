//! Tube surfaces: round tubes around the edges of a target map, softly joined.
//!
//! In: a target map and its [`Skeleton`]. Out: [`TubeSurface`]: a point and a normal for every (u, v) of every quarter-tube,
//! and a closed quad mesh of them.
//! Holds: one quarter-tube per flag; neighbours meet along whole sides, so the quads are a closed oriented surface of genus
//! E − V + 1. Not: that the surface keeps clear of itself; that is tested on its triangles.
//! Source: [Razafindrazaka2015] §9.2, §9.4, Fig. 9.11.
//!
//! ```text
//!   P2 ── b ── M2   v = 1      u: from the junction to the middle of the tube. v: around the side on which the flag's face
//!   │          │               lies, from the pole P1 to the pole P2. P1 is the tip of the normal for an upright flag,
//!   a          c               the other one for an overturned flag. So (u, v) is right-handed seen from outside.
//!   │          │
//!   P1 ── d ── M1   v = 0
//!  u = 0      u = 1
//! ```

mod curve;
mod field;
mod grid;
mod skin;

use crate::ids::FlagId;
use crate::map::Reflection;
use crate::map::RegularMap;
use crate::skeleton::{Skeleton, SkeletonDefect, clearance, edge_flags, extent, upright_flags};
use curve::Curve;
use glam::DVec3;
use grid::Grid;
use quadloom_mesh::{Id, MeshError, QuadMesh};
use rayon::prelude::*;
use skin::Skin;

/// How tubes are made.
#[derive(Clone, Debug, PartialEq)]
pub struct TubeOptions {
    /// Radius of the tubes, units of the skeleton. Default: [`choose_radius`].
    pub radius: Option<f64>,
    /// How far junctions reach, in radii, above 1. Default 1.45. Larger: softer and thicker junctions.
    pub softness: f64,
    /// Quads along and around a quarter-tube of the mesh. Default: as many as its bends need.
    pub quads: Option<[usize; 2]>,
}

impl Default for TubeOptions {
    fn default() -> Self {
        Self { radius: None, softness: 1.45, quads: None }
    }
}

/// Why there are no tubes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TubeError {
    /// An edge without length.
    #[error("edge {0} of the skeleton has no length")]
    NoLength(usize),
    /// Tubes that are thicker than they are long.
    #[error("tubes of radius {0} are too thick for the junctions of this skeleton; make them thinner")]
    TooThick(f64),
    /// The skeleton is not the map's.
    #[error(transparent)]
    Skeleton(#[from] SkeletonDefect),
    /// Quads that are no surface.
    #[error("the tubes are no surface: {0}")]
    Mesh(#[from] MeshError),
}

/// A tube surface.
#[derive(Clone, Debug)]
pub struct TubeSurface {
    map: RegularMap,
    skin: Skin,
    cage: [usize; 3],
    quads: [usize; 2],
}

/// Tubes are at most this share of the clearance thick: drawn triangles and soft junctions need the rest.
const OF_CLEARANCE: f64 = 0.72;
/// Thinner by this factor until junctions fit.
const THINNER: f64 = 0.93;
/// The least radius tried, as a share of the first.
const LEAST: f64 = 0.02;

impl TubeSurface {
    /// The surface around a skeleton.
    ///
    /// # Errors     [`TubeError`]; where no radius is asked for, tubes are made thinner until junctions fit
    /// # Cost       linear in the skeleton's points
    pub fn build(map: &RegularMap, skeleton: &Skeleton, options: &TubeOptions) -> Result<Self, TubeError> {
        skeleton.check(map)?;
        let first = options.radius.unwrap_or_else(|| choose_radius(map, skeleton));
        let curves = curves(map, skeleton, first)?;
        let mut radius = first;
        let skin = loop {
            match Skin::new(map, skeleton, &curves, radius, options.softness) {
                Some(skin) => break skin,
                None if options.radius.is_some() || radius < LEAST * first => return Err(TubeError::TooThick(radius)),
                None => radius *= THINNER,
            }
        };
        let quads = options.quads.unwrap_or_else(|| skin.steps());
        Ok(Self { map: map.clone(), skin, cage: grid::cage_counts(map), quads })
    }

    /// Radius of the tubes, units of the skeleton.
    pub fn radius(&self) -> f64 {
        self.skin.radius()
    }

    /// Vertices, edges and faces of the cage that has one quad for each quarter-tube.
    pub fn cage_counts(&self) -> [usize; 3] {
        self.cage
    }

    /// Pieces along and around a quarter-tube that follow its bends.
    pub fn steps(&self) -> [usize; 2] {
        self.skin.steps()
    }

    /// The point at (u, v) of a flag's quarter-tube; neighbours agree along their common side up to rounding.
    pub fn point(&self, flag: FlagId, u: f64, v: f64) -> DVec3 {
        self.skin.point(flag, u, v)
    }

    /// The outward unit normal there.
    pub fn normal(&self, flag: FlagId, u: f64, v: f64) -> DVec3 {
        self.skin.normal(flag, u, v)
    }

    /// The surface as a closed mesh of quads, all quarter-tubes divided alike, and the flag of each quad.
    ///
    /// # Errors     [`TubeError::Mesh`], which would be a fault
    pub fn mesh(&self) -> Result<(QuadMesh, Vec<FlagId>), TubeError> {
        let grid = Grid::new(&self.map, self.quads[0], self.quads[1]);
        let share = |k: usize, n: usize| k as f64 / n as f64;
        let place =
            |node: &grid::Node| self.point(node.flag, share(node.i, grid.along()), share(node.j, grid.around()));
        let positions: Vec<DVec3> = grid.nodes().par_iter().map(place).collect();
        let faces = grid.faces(&self.map);
        let flags = (0..faces.len()).map(|k| grid.cell(k).0).collect();
        Ok((QuadMesh::new(positions, &faces)?, flags))
    }
}

/// The largest radius for which tubes around a skeleton should keep clear of each other.
///
/// # Cost       that of [`clearance`]
pub fn choose_radius(map: &RegularMap, skeleton: &Skeleton) -> f64 {
    OF_CLEARANCE * clearance(map, skeleton) * extent(skeleton).1
}

/// Share of the radius by which curves may be off.
const SAGITTA: f64 = 0.002;

/// The edges' curves with frames: the line v = 0 of an edge's first flag starts at that flag's pole P1 and ends at the
/// pole P2 of its r₀-neighbour; where that is upright too, the tube gets a half twist.
fn curves(map: &RegularMap, skeleton: &Skeleton, radius: f64) -> Result<Vec<Curve>, TubeError> {
    let upright = upright_flags(map);
    let pole = |flag: FlagId| {
        let normal = skeleton.normals[map.vertex(flag).index()];
        if upright[flag] { normal } else { -normal }
    };
    let curve = |(edge, first): (crate::ids::MapEdgeId, FlagId)| {
        let curve = Curve::through(&skeleton.edges[edge.index()], SAGITTA * radius);
        let curve = curve.ok_or(TubeError::NoLength(edge.index()))?;
        Ok(curve.framed(pole(first), -pole(map.reflect(first, Reflection::R0))))
    };
    edge_flags(map).into_iter().map(curve).collect()
}
