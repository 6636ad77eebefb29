//! Flat pictures of a map: its flags as triangles of a fundamental domain in the plane of {p, q}.
//!
//! In: a [`RegularMap`]. Out: [`FlatTiling`]: one triangle per flag, the sides that are glued, and pictures of it.
//! Holds: each flag has one triangle; labels and which sides lie side by side come from groups, never from
//! coordinates; [`FlatTiling::check`] glues the polygon again and counts. Not: a convex polygon, nor the one of least diameter.
//! Source: [Razafindrazaka2015] §9.3, Fig. 9.7, 9.8, 9.9.
//!
//! ```text
//!        V              A triangle's corners are 0 = V, 1 = E, 2 = F; side i is opposite corner i and leads to g·rᵢ:
//!      ╱ │              side 0 = E F (half a dual edge), side 1 = F V, side 2 = V E (half an edge).
//!   F ── E              Flags that are products of evenly many reflections have V, E, F counter-clockwise.
//! ```

mod boundary;
mod check;
mod element;
mod frame;
mod layout;
mod model;
pub mod picture;

pub use boundary::{BoundaryEdge, Side};
pub use check::{Glued, TilingDefect};
pub use model::Model;
pub use picture::{Picture, PictureOptions, png, svg};

use crate::error::MapError;
use crate::ids::{FlagId, FlagMap};
use crate::map::{Reflection, RegularMap};
use crate::plane::Plane;
use element::Element;
use frame::Frame;
use glam::{DMat3, DVec3};

/// What lies at the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Centre {
    /// The base flag's face.
    #[default]
    Face,
    /// Its vertex.
    Vertex,
    /// Its edge's midpoint.
    Edge,
}

impl Centre {
    /// The number of that corner of a triangle.
    pub fn corner(self) -> usize {
        match self {
            Self::Vertex => 0,
            Self::Edge => 1,
            Self::Face => 2,
        }
    }
}

/// What is placed as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pieces {
    /// Single triangles, with their images under all symmetries that fix the centre: the domain has these symmetries.
    #[default]
    Triangles,
    /// Whole faces: the boundary runs along edges of the map.
    Faces,
    /// All triangles of a vertex: the boundary runs along edges of the dual map.
    Vertices,
}

/// How a map is laid out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LayoutOptions {
    /// What lies at the origin. Default: a face.
    pub centre: Centre,
    /// What is placed as a whole. Default: triangles, which makes the roundest and most symmetric domain.
    pub pieces: Pieces,
}

/// A point of the domain: a corner that triangles side by side share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FlatPoint(pub u32);

/// A map laid out in the plane.
#[derive(Clone, Debug)]
pub struct FlatTiling {
    map: RegularMap,
    plane: Plane,
    frame: Frame,
    options: LayoutOptions,
    /// Takes the frame's triangle to that of the flag.
    isometries: FlagMap<DMat3>,
    /// The same as an element of the tiling's group, exactly.
    elements: FlagMap<Element>,
    /// Whether that isometry preserves orientation.
    even: FlagMap<bool>,
    /// Flags in the order in which they were placed.
    order: Vec<FlagId>,
    /// Whether the triangle across each side is its neighbour in the map.
    adjacent: FlagMap<[bool; 3]>,
    points: FlagMap<[FlatPoint; 3]>,
    positions: Vec<DVec3>,
    boundary: Vec<BoundaryEdge>,
}

impl FlatTiling {
    /// The map around a cell of its base flag, triangle by triangle.
    ///
    /// # Errors     [`MapError::NotRegular`] for maps with p or q of 1, which no plane has triangles for
    /// # Cost       n log n in flags
    /// # Source     [Razafindrazaka2015] §9.3
    pub fn layout(map: &RegularMap, centre: Centre) -> Result<Self, MapError> {
        Self::layout_with(map, &LayoutOptions { centre, ..LayoutOptions::default() })
    }

    /// The map with all choices.
    pub fn layout_with(map: &RegularMap, options: &LayoutOptions) -> Result<Self, MapError> {
        layout::layout(map, options)
    }

    /// The map.
    pub fn map(&self) -> &RegularMap {
        &self.map
    }

    /// The plane of {p, q}, where the base flag's face is at the origin; isometries lead from there.
    pub fn plane(&self) -> &Plane {
        &self.plane
    }

    /// How it was laid out.
    pub fn options(&self) -> &LayoutOptions {
        &self.options
    }

    /// Flags in the order in which they were placed: nearest to the centre first.
    pub fn order(&self) -> &[FlagId] {
        &self.order
    }

    /// Takes the base triangle of [`Self::plane`] to that of a flag.
    pub fn isometry(&self, flag: FlagId) -> DMat3 {
        self.isometries[flag] * self.frame.from_plane
    }

    /// Whether V, E, F of a flag's triangle run counter-clockwise.
    pub fn is_counter_clockwise(&self, flag: FlagId) -> bool {
        self.even[flag]
    }

    /// Whether the neighbour of a flag in the map lies beside it in the plane, too.
    pub fn is_adjacent(&self, flag: FlagId, across: Reflection) -> bool {
        self.adjacent[flag][across as usize]
    }

    /// Corner 0 = V, 1 = E or 2 = F of a flag's triangle: triangles side by side share it.
    pub fn point(&self, flag: FlagId, corner: usize) -> FlatPoint {
        self.points[flag][corner]
    }

    /// Where a point is; points that triangles side by side share are the same to the last bit.
    pub fn position(&self, point: FlatPoint) -> DVec3 {
        self.positions[point.0 as usize]
    }

    /// The corners V, E, F of a flag's triangle.
    pub fn corners(&self, flag: FlagId) -> [DVec3; 3] {
        self.points[flag].map(|point| self.position(point))
    }

    /// The middle of a flag's triangle: the centre of its inscribed circle.
    pub fn middle(&self, flag: FlagId) -> DVec3 {
        self.plane.normalised(self.isometries[flag] * DVec3::Z)
    }

    /// The segment from vertex to edge midpoint of each triangle, in a model: Line(N).
    ///
    /// # Source     [Razafindrazaka2015] §9.3, Fig. 9.7; in [`Model::Jemisphere`] where relaxation begins, Fig. 9.9
    pub fn lines(&self, model: Model) -> FlagMap<[DVec3; 2]> {
        FlagMap::from_fn(self.map.order(), |g| {
            let [vertex, edge, _] = self.corners(g);
            [model.project(vertex), model.project(edge)]
        })
    }

    /// The edges of the domain's boundary, counter-clockwise, each as long as its gluing allows.
    pub fn boundary(&self) -> &[BoundaryEdge] {
        &self.boundary
    }

    /// Glues the boundary by its labels and arrows alone, and counts.
    pub fn glued(&self) -> Glued {
        check::glued(self)
    }

    /// All that is wrong; nothing for a valid tiling.
    ///
    /// # Cost       linear in flags, and quadratic in edges of the boundary
    pub fn check(&self) -> Vec<TilingDefect> {
        check::check(self)
    }
}
