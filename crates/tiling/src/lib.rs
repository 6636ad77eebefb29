//! M-tiles: cutting a surface into tiles, a polygon, pants, cylinders and quadrangles.
#![warn(missing_docs)]

pub mod cells;
mod classes;
mod cost;
mod cut_surface;
mod error;
pub mod ids;
pub mod maps;
mod search;
pub mod tiling;
pub mod word;

pub use cost::EdgeCosts;
pub use error::TilingError;
pub use cells::{Cell, CellComplex, Side};
pub use ids::{ArcId, ArcMap, NodeId, NodeMap, TileId, TileMap};
pub use tiling::{RefinedSurface, Tiling};
