//! What a page shows: plain data, in file units.
//!
//! In: nothing. Out: [`Scene`] and its parts, every part optional or possibly empty.
//! Holds: nothing is checked here; a face that names a missing vertex is left out of the picture.

use super::histogram::Histogram;
use super::isolines::UvIsolines;
use glam::{DVec2, DVec3};

/// A straight piece of a line layer, file units.
pub type Segment = [DVec3; 2];

/// Everything that one page shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Heading of the page and name of its window; plain text.
    pub title: String,
    /// The surface that was remeshed.
    pub input: Option<SurfaceLayer>,
    /// The quads.
    pub quads: Option<QuadLayer>,
    /// A distance on the input's vertices.
    pub distance: Option<DistanceLayer>,
    /// A tiling of the input.
    pub tiles: Option<TileLayer>,
    /// Irregular vertices of the quads, or singular vertices of the field where there are no quads.
    pub singularities: Vec<Singularity>,
    /// Feature curves.
    pub features: Vec<Polyline>,
    /// Boundary loops.
    pub boundary: Vec<Polyline>,
    /// Edges across which the map changes its chart.
    pub seams: Vec<Segment>,
    /// The cross field, thinned out to what an eye can read (see [`super::crosses`]).
    pub crosses: Vec<Cross>,
    /// Integer iso-lines of the map.
    pub uv_isolines: UvIsolines,
    /// Rows of the table: name and value, plain text.
    pub statistics: Vec<(String, String)>,
    /// Diagrams below the table.
    pub histograms: Vec<Histogram>,
}

/// A triangulated surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceLayer {
    /// Vertices, file units.
    pub positions: Vec<DVec3>,
    /// Corners of the triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Distances on the vertices of a surface, with what they were measured from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DistanceLayer {
    /// One per vertex of the surface, file units; infinite where nothing is known.
    pub values: Vec<f64>,
    /// Width of a band of colour, file units.
    pub band: f64,
    /// Lines of equal distance.
    pub isolines: Vec<Polyline>,
    /// Shortest paths.
    pub paths: Vec<Polyline>,
    /// Points (of one point) and segments that distances are measured from.
    pub sources: Vec<Polyline>,
    /// Where shortest paths meet.
    pub cut_locus: Vec<Polyline>,
}

/// A tiling of the input surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileLayer {
    /// Tile of every triangle of the input.
    pub tile: Vec<u32>,
    /// Texture coordinates of the corners of every triangle; empty where tiles were not mapped.
    pub uv: Vec<[DVec2; 3]>,
    /// Cuts: the arcs that are not the surface's boundary, by their numbers; if each is a side of an unfolded tile, it
    /// has the colour of that side.
    pub cuts: Vec<Polyline>,
    /// Where cuts meet.
    pub multipoints: Vec<DVec3>,
    /// Tiles unfolded to the plane, in their order.
    pub unfolded: Vec<UnfoldedTile>,
}

/// A tile as a polygon (or an annulus and so on: one ring per boundary) in the plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UnfoldedTile {
    /// Name of the tile and, for one tile, its word.
    pub name: String,
    /// One per boundary.
    pub rings: Vec<Vec<UnfoldedSide>>,
}

/// A side of an unfolded tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UnfoldedSide {
    /// Letter of its arc.
    pub label: String,
    /// Number of its arc: sides of one arc have one colour.
    pub arc: u32,
    /// Whether it runs against its arc.
    pub reversed: bool,
    /// Whether it lies on the surface's boundary.
    pub border: bool,
}

/// A quad mesh with one quality per quad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadLayer {
    /// Vertices, file units.
    pub positions: Vec<DVec3>,
    /// Corners of the quads, counter-clockwise seen from outside.
    pub quads: Vec<[u32; 4]>,
    /// Scaled Jacobian of every quad in -1..=1; missing entries are shown without a colour.
    pub quality: Vec<f64>,
}

/// A vertex where other than four quads meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Singularity {
    /// Where it is, file units.
    pub position: DVec3,
    /// How many quads meet there.
    pub valence: u32,
}

/// A line through points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polyline {
    /// Its points in order, file units.
    pub points: Vec<DVec3>,
    /// Whether the last point is joined to the first one.
    pub closed: bool,
}

impl Polyline {
    /// Its straight pieces in order.
    pub fn segments(&self) -> impl Iterator<Item = Segment> + '_ {
        let closing = match self.points.as_slice() {
            [first, .., last] if self.closed => Some([*last, *first]),
            _ => None,
        };
        self.points.windows(2).map(|w| [w[0], w[1]]).chain(closing)
    }
}

/// One cross of a cross field: two lines of equal length through a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cross {
    /// Where the lines meet, file units.
    pub point: DVec3,
    /// Unit direction of one line.
    pub u: DVec3,
    /// Unit direction of the other one.
    pub v: DVec3,
    /// Length of each line, file units.
    pub length: f64,
}

impl Cross {
    /// Its two lines.
    pub fn segments(&self) -> [Segment; 2] {
        [self.u, self.v].map(|d| [self.point - 0.5 * self.length * d, self.point + 0.5 * self.length * d])
    }
}
