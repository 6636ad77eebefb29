//! Integer-grid map to quad mesh, finishing, quality.
//!
//! In: a triangle mesh with an integer-grid map. Out: [`Extraction`].
//! Holds: what is returned is pure quads, oriented, manifold, with the topology of the input.
//! Source: [Bommes2012] ch. 6; [Ebke2013].
#![warn(missing_docs)]

pub mod extraction;
mod fill;
mod grid_points;
mod lattice;
mod ports;
mod ribbon;
mod walk;

pub use extraction::{ExtractError, ExtractReport, Extraction, GridSquare, Placement, extract};
