//! Turns any surface into quadrilaterals by mixed-integer quadrangulation.
//!
//! In: a file or a mesh. Out: [`RemeshResult`]: a pure-quad mesh and a [`Report`].
//! Holds: what [`remesh()`] returns is verified: manifold, oriented, the topology of the (repaired) input, no quad
//! inverted, none facing against the input. The stages are public, one function per arrow, in [`stages`].
//! Beside it: exact distances ([`distance`]), tiles ([`tile`]), regular maps ([`regular_map`]).
//! Source: [Bommes2012].
//!
//! ```
//! use quadloom::{Progress, RemeshOptions, Target, remesh_mesh, sample};
//!
//! let torus = sample("torus").expect("a generated shape");
//! let options = RemeshOptions { target: Target::Quads(400), ..RemeshOptions::default() };
//! let result = remesh_mesh(&torus, &options, &Progress::none())?;
//! assert_eq!(result.report.output.summary.chi, 0);
//! # Ok::<(), quadloom::RemeshError>(())
//! ```
#![warn(missing_docs)]

pub mod calm;
pub mod components;
pub mod count;
pub mod distance;
pub mod error;
pub mod features;
pub mod field;
pub mod guides;
pub mod input;
pub mod inspect;
mod ladder;
pub mod measure;
pub mod memory;
pub mod options;
pub mod output;
mod pairing;
pub mod part;
pub mod regular_map;
pub mod remesh;
pub mod report;
mod requests;
pub mod scene;
pub mod singularities;
pub mod sizes;
pub mod split;
pub mod stages;
pub mod ties;
pub mod tile;
pub mod verify;
pub mod view;
mod warnings;

pub use error::{FailureKind, RemeshError, Warning, WarningCode};
pub use input::{Source, load};
pub use options::{AdaptTo, Elements, Fallback, GivenField, Method, RemeshOptions, Target};
pub use quadloom_extract as extract;
pub use quadloom_geodesic as geodesic;
pub use quadloom_io as io;
pub use quadloom_mesh as mesh;
pub use quadloom_mesh::shapes::{sample, sample_names};
pub use quadloom_mesh::{FaceSoup, Progress, QuadMesh, TriMesh};
pub use quadloom_regular_maps as regular_maps;
pub use quadloom_tiling as tiling;
pub use quadloom_tubification as tubification;
pub use remesh::{RemeshResult, remesh, remesh_mesh};
pub use report::Report;
