//! M-tiles: cutting a surface into tiles, a polygon, pants, cylinders and quadrangles.
//!
//! In: a triangle mesh and what a cut along each edge costs ([`EdgeCosts`]). Out: [`Cutting`]: a surface cut so far, and
//! [`Tiling`]s: an m-cellular complex embedded in a refined mesh of the same surface, before and after every step.
//! Holds: cuts are simple and share neither an edge nor an inner vertex; [`Tiling::check`] tests the definitions of
//! [Favreau2009] against the mesh alone; costs are added up as integers and all is sequential or per tile, so equal input
//! gives equal bytes for any number of threads. Not: geodesics across faces; the shortest cut graph of all.
//! Source: [Favreau2009]. How it works: `docs/tiling.md`.
//!
//! | paper | here |
//! |---|---|
//! | 2-m-cell, m-cellular complex (Def. 2) | [`Cell`], [`CellComplex`] |
//! | M-tile, M-tiling (C, M, F) (Def. 3, 4) | [`Tiling`] |
//! | multipoint | image of a node |
//! | valid 1-path, 1-loop (Def. 5) | [`MeshPath`], [`LoopKind`]; [`Cutting::cut_path`] cuts along one |
//! | Algorithms 1, 2, 3 | [`cut_shortest`], [`cut_single_point`], [`cut_intermediate`] |
//! | Algorithms 4, 5 | [`Cutting::quadrangulate`] |
//! | Lemma 1, §4.1 | [`cut_given`], [`Tiling::merged`] |
//!
//! ```
//! use quadloom_mesh::{Progress, shapes};
//! use quadloom_tiling::{CutOptions, EdgeCosts, QuadOptions, cut_single_point};
//!
//! let mesh = shapes::genus_series(2, 0);
//! let costs = EdgeCosts::euclidean(&mesh);
//! let progress = Progress::none();
//! let mut cutting = cut_single_point(&mesh, &costs, &CutOptions::default(), &progress)?;
//! assert_eq!(cutting.tiling()?.complex.cells.values()[0].side_count(), 8);
//! cutting.quadrangulate(&QuadOptions::default())?;
//! let quads = cutting.tiling()?;
//! assert_eq!((quads.complex.cells.len(), quads.check().len()), (3, 0));
//! # Ok::<(), quadloom_tiling::TilingError>(())
//! ```
#![warn(missing_docs)]

pub mod cells;
mod classes;
mod cost;
mod cut_surface;
pub mod cutting;
mod error;
pub mod given;
pub mod ids;
pub mod maps;
pub mod pants;
pub mod paths;
pub mod quads;
mod search;
pub mod single;
pub mod tile_mesh;
pub mod tiling;
pub mod word;

pub use cells::{Cell, CellComplex, Side};
pub use cost::EdgeCosts;
pub use cutting::{Cut, CutKind, CutOptions, Cutting, Method, SearchMode};
pub use error::TilingError;
pub use given::cut_given;
pub use ids::{ArcId, ArcMap, NodeId, NodeMap, TileId, TileMap};
pub use pants::{cut_into_cylinders, cut_into_pants};
pub use paths::{LoopKind, MeshPath};
pub use quads::{DiagonalChoice, QuadOptions, QuadReport};
pub use single::{cut_intermediate, cut_shortest, cut_single_point, cut_to_disk};
pub use tile_mesh::{OnFailure, TileMaps, TileMesh, map_tiles};
pub use tiling::{RefinedSurface, Tiling};
pub use tiling::{TilingDefect, tile_from_cut};
