//! Seams and transitions, integer-grid maps, stiffening, untangling, validity.
//!
//! In: a triangle mesh, its features, a cross field and a size. Out: [`IntegerGridMap`] with a report.
//! Source: [Bommes2012] ch. 6 and §8.4.
#![warn(missing_docs)]

pub mod integer_grid_map;

pub use integer_grid_map::{GRID_UNIT, IntegerGridMap, LATTICE_BITS, LatticePoint, MapDefect, Transition};
