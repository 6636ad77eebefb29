//! Tubification: regular maps drawn on tube surfaces in space.
//!
//! In: a [`RegularMap`](quadloom_regular_maps::RegularMap) and where it fits, a
//! [`TubeMatch`](quadloom_regular_maps::TubeMatch). Out: a [`Realization`]: triangles with the map on them, and the
//! rotations that the surface has. Holds: the drawn map was compared with its group on the mesh alone; a surface that
//! meets itself is an error unless it was asked for. Source: [Razafindrazaka2015] §9.2–9.6. How it works:
//! `docs/regular-maps.md`.
//!
//! | thesis | here |
//! |---|---|
//! | Line(G), §9.3 | [`Skeleton`]: a curve for every edge of the target |
//! | tubification, §9.2 | [`TubeSurface`]: four quarter-tubes around every edge |
//! | §9.5 | [`draw`]: the source's tiling, cut once and laid on every quarter-tube |
#![warn(missing_docs)]

pub mod drawing;
pub mod realize;
pub mod rotations;
pub mod skeleton;
pub mod tubes;

pub use drawing::{DrawError, DrawOptions, Drawing, DrawingDefect, Drawn, DrawnCounts, EdgeStyle, draw};
pub use realize::{Realization, RealizeError, RealizeOptions, SkeletonKind, Tubified};
pub use rotations::{Measured, measure};
pub use skeleton::{Skeleton, SkeletonDefect};
pub use tubes::{TubeError, TubeOptions, TubeSurface};
