//! Pictures: one self-contained HTML page that shows an input surface, its quads and everything in between, and one
//! that shows a map on a surface beside its flat picture.
//!
//! In: a [`Scene`], built by hand or from meshes, fields and maps with [`layers`], [`isolines`](isolines()) and
//! [`histogram`]; a [`MapScene`]. Out: the text of one page ([`render_html`], [`render_map_html`]), which works without a
//! network.
//! Holds: the page asks for nothing outside itself (its content policy forbids it); texts of the scene are
//! escaped; the same scene gives the same bytes. Not: any statement about the mesh that the scene does not make.
//! Source: own; edges without triangle diagonals after the screen-space distances of [Baerentzen2006].

pub mod histogram;
pub mod isolines;
pub mod layers;
mod map_page;
mod page;
mod scene;
mod tiles;

pub use histogram::{Bins, Histogram, quad_histograms, scaled_jacobian, scaled_jacobians};
pub use isolines::{UvIsolines, isolines};
pub use layers::{boundary_lines, crosses, feature_lines, irregular_vertices, seams};
pub use map_page::{MapScene, render_map_html};
pub use page::render_html;
pub use scene::{
    Cross, DistanceLayer, Polyline, QuadLayer, Scene, Segment, Singularity, SurfaceLayer, TileLayer, UnfoldedSide,
    UnfoldedTile,
};
