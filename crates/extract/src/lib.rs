//! Integer-grid map to quad mesh, finishing, quality.
//!
//! In: a triangle mesh with an integer-grid map. Out: [`Extraction`], then [`Finished`] quads on the input surface.
//! Holds: what is returned is pure quads, oriented, manifold, with the topology of the input.
//! Source: [Bommes2012] ch. 6; [Ebke2013].
#![warn(missing_docs)]

pub mod extraction;
mod fill;
pub mod finish;
mod grid_points;
mod lattice;
mod mend;
mod ports;
pub mod quality;
pub mod reference;
mod ribbon;
mod walk;

pub use extraction::{ExtractError, ExtractReport, Extraction, GridSquare, Placement, extract};
pub use finish::{FinishError, FinishOptions, FinishReport, Finished, finish};
pub use quality::{
    Deviation, Distances, Histogram, IrregularVertices, QuadQuality, QualitySummary, facing_against, scaled_jacobian,
    split_at_centres,
};
pub use reference::{Facing, Reference};
