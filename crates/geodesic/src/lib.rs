//! Exact geodesic distance on triangle meshes from points and polygonal curves.
//!
//! In: connectivity and edge lengths ([`IntrinsicSurface`]), sources with labels and start values ([`Source`]).
//! Out: distances, nearest sources, directions, shortest paths, isolines, cut locus, refined meshes ([`Field`]).
//! Holds: with ε = 0 exact up to rounding, with ε > 0 never above the truth and at most ε below, relative to the final
//! distance; the same bytes each time. No position is read: every answer is a number or a point of a face.
//! Source: [Bommes2012] §9. How it works and what is safe why: `docs/geodesic.md`.
//!
//! ```
//! use quadloom_geodesic::{IntrinsicSurface, Options, Source, Wavefront, vertex_distances};
//! use quadloom_mesh::{Progress, VertexId, metric::edge_lengths, shapes::sphere};
//!
//! let mesh = sphere(1.0, 3);
//! let lengths = edge_lengths(&mesh);
//! let surface = IntrinsicSurface::new(&mesh, &lengths)?;
//! // One call, if distances of vertices are all that is needed.
//! let distance = vertex_distances(&surface, &[Source::vertex(VertexId(0))])?;
//! // A wavefront, to ask more and to spread again.
//! let mut wave = Wavefront::new(&surface);
//! wave.spread(&[Source::vertex(VertexId(0))], &Options::default(), &Progress::none())?;
//! assert_eq!(wave.field().vertex_distance(VertexId(7)), distance[VertexId(7)]);
//! # Ok::<(), quadloom_geodesic::GeodesicError>(())
//! ```

mod crossing;
mod curves;
mod cut_locus;
mod error;
mod field;
mod insert;
mod isolines;
mod lists;
mod merge;
mod path;
mod profile;
mod refine;
mod sources;
mod surface;
mod trim;
mod wavefront;
mod window;

pub use curves::{CurveTracer, boundary_sources, edge_sources};
pub use cut_locus::{CutLocus, CutPoint};
pub use error::GeodesicError;
pub use field::{EdgeWindow, Field, Nearest, vertex_distances};
pub use isolines::{Isoline, MOST_VALUES, isolines, spaced};
pub use path::GeodesicPath;
pub use refine::{RefineOptions, Refinement};
pub use sources::{Source, SourceShape};
pub use surface::IntrinsicSurface;
pub use wavefront::{Counts, Keep, Options, Wavefront};
