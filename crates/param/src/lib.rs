//! Seams and transitions, integer-grid maps, stiffening, untangling, validity.
//!
//! In: a triangle mesh, its features, a cross field and a size. Out: [`IntegerGridMap`] with a report.
//! Source: [Bommes2012] ch. 6 and §8.4.
#![warn(missing_docs)]

pub mod charts;
mod conditions;
mod curves;
pub mod fans;
mod follow;
pub mod integer_grid_map;
pub mod parametrize;
mod place;
pub mod placed;
pub mod problem;
pub mod quantise;
pub mod relocate;
mod room;
pub mod sectors;
pub mod sight;
pub mod stiffen;
pub mod ties;
pub mod tmesh;
pub mod untangle;

pub use charts::Charts;
pub use integer_grid_map::{GRID_UNIT, IntegerGridMap, LATTICE_BITS, LatticePoint, MapDefect, Transition};
pub use parametrize::{
    Method, ParamError, ParamOptions, ParamReport, Parametrization, Parametrizer, Rounded, Rung, area_of,
};
pub use placed::{PlacedMap, PlacementError};
pub use relocate::{RelocationError, RelocationOptions, RelocationReport, relocate};
pub use room::make_room;
pub use sectors::solve_open_field;
pub use ties::{Tie, TieError};
