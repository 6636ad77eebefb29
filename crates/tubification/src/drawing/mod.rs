//! A source map drawn on the tube surface of a target.
//!
//! In: a source map, a [`TubeMatch`], where each point of each quarter-tube is in space. Out: [`Drawing`]: a closed triangle
//! mesh whose every triangle lies in one flag of the source.
//! Holds: the mesh is a closed manifold; [`Drawing::check`] tests the drawn map against the source by the mesh alone.
//! Not: self-intersection, which the surface decides.
//! Source: [Razafindrazaka2015] §9.5: the tiling is clipped against the fundamental quadrilateral once and placed on every
//! quarter-tube by its group element.

mod cells;
mod check;
mod glue;
mod lines;
mod local;
mod refine;
mod sheet;
mod slivers;
mod strips;
mod triangulate;

pub use check::{DrawingDefect, DrawnCounts};
pub use strips::{Drawn, EdgeStyle};

use glam::DVec3;
use glue::Glue;
use local::LocalPicture;
use quadloom_mesh::{FaceMap, MeshError, TriMesh, VertexMap};
use quadloom_regular_maps::MapError;
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::RegularMap;
use quadloom_regular_maps::matching::TubeMatch;
use quadloom_regular_maps::plane::Plane;
use sheet::Copies;
use strips::Strips;

/// How a map is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawOptions {
    /// The map or its dual. Default: the map.
    pub drawn: Drawn,
    /// How edges look. Default: flat bands, 0.12 of the way to the face's centre.
    pub edges: EdgeStyle,
    /// Height of ridges and reliefs above the surface, units of the surface. Default 0.
    pub height: f64,
    /// Cells along and around a quarter-tube: corners of cells lie on the surface, the two triangles of a cell are flat.
    /// Default 8 and 8; triangles grow with their product.
    pub steps: [usize; 2],
}

impl DrawOptions {
    fn cells(&self) -> [usize; 2] {
        self.steps.map(|n| n.max(1))
    }
}

impl Default for DrawOptions {
    fn default() -> Self {
        Self { drawn: Drawn::Map, edges: EdgeStyle::Bands(0.12), height: 0.0, steps: [8, 8] }
    }
}

/// A map drawn on a surface.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// The surface: vertices lie on the smooth tubes.
    pub mesh: TriMesh,
    /// Where vertices would lie on the flat triangles of cells: there, triangles do not overlap, however thin they are.
    pub flat: VertexMap<DVec3>,
    /// The flag of the source that each triangle lies in.
    pub flag: FaceMap<FlagId>,
    /// The quarter-tube of the target that each triangle lies on.
    pub quarter: FaceMap<FlagId>,
    /// Whether each triangle belongs to an edge's band.
    pub is_edge: FaceMap<bool>,
    /// Map or dual.
    pub drawn: Drawn,
}

/// Why a map could not be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DrawError {
    /// The picture on a quarter-tube does not close.
    #[error(transparent)]
    Map(#[from] MapError),
    /// Neighbouring quarter-tubes do not fit together.
    #[error("the pictures on neighbouring quarter-tubes do not fit together along side {0}")]
    Sides(char),
    /// The drawn triangles are no closed surface.
    #[error("the drawn triangles are no surface: {0}")]
    Mesh(#[from] MeshError),
    /// The drawn map is another one.
    #[error("the drawn map is not the source: {0}")]
    Defect(#[from] DrawingDefect),
}

/// Draws a map on a tube surface and checks what was drawn.
///
/// # Input      `place`: point and outward unit normal of the surface at (u, v) of a quarter-tube, named by its flag of the
///   target; it agrees along sides that are glued
/// # Output     the drawing and what was counted on it
/// # Errors     [`DrawError`]
/// # Cost       linear in the triangles, |H| times those of one quarter-tube
/// # Source     [Razafindrazaka2015] §9.5, Fig. 9.17
pub fn draw(
    source: &RegularMap,
    found: &TubeMatch,
    place: impl Fn(FlagId, f64, f64) -> (DVec3, DVec3) + Sync,
    options: &DrawOptions,
) -> Result<(Drawing, DrawnCounts), DrawError> {
    let plane = Plane::of_type(source.p(), source.q());
    let strips = Strips::new(options.drawn, options.edges);
    // 1. Clip once.
    let picture = LocalPicture::new(source, &plane, &found.quadrilateral, &strips, options.cells())?;
    // 2. Glue the copies.
    let glue = Glue::new(&picture, &found.target)?;
    // 3. Place them.
    let copies = Copies { source, found, picture: &picture, strips: &strips, glue: &glue };
    let drawing = copies.placed(place, options)?;
    let counts = drawing.check(source)?;
    Ok((drawing, counts))
}
