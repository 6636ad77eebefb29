//! Regular maps: from a group to a surface one can hold.
//!
//! In: a presentation ⟨R, S, T | …⟩, a name or a type. Out: [`RegularMap`]s.
//! Holds: all that decides about groups and maps is integer arithmetic; geometry comes after it.
//! Source: [Razafindrazaka2015] ch. 9. How it works: `docs/regular-maps.md`.
//!
//! | thesis | here |
//! |---|---|
//! | Sym(G_pq), Eq. (9.1) | [`Presentation`], and once enumerated [`RegularMap`] |
//! | R, S, T | r₀r₁, r₁r₂, r₁ in flag reflections ([`Reflection`]) |
//! | an element of Sym(G_pq) | a flag ([`FlagId`]): the one that the element takes flag 0 to |
#![warn(missing_docs)]

pub mod catalogue;
pub mod colouring;
pub mod coset;
pub mod drawing;
pub mod enumerate;
mod error;
pub mod ids;
pub mod map;
pub mod matching;
mod partition;
pub mod plane;
pub mod presentation;
pub mod realize;
pub mod rotations;
pub mod skeleton;
pub mod tiling;
pub mod tubes;
pub mod word;

pub use coset::{CosetLimit, enumerate_cosets};
pub use drawing::{DrawError, DrawOptions, Drawing, DrawingDefect, Drawn, DrawnCounts, EdgeStyle, draw};
pub use error::MapError;
pub use ids::{FlagId, FlagMap, MapEdgeId, MapFaceId, MapVertexId};
pub use map::{Reflection, RegularMap};
pub use matching::{MatchOptions, Pole, TubeMatch, find_matches};
pub use plane::{Curvature, Plane};
pub use presentation::Presentation;
pub use realize::{Realization, RealizeError, RealizeOptions, SkeletonKind, Tubified};
pub use rotations::{Measured, measure};
pub use skeleton::{Skeleton, SkeletonDefect};
pub use tubes::{TubeError, TubeOptions, TubeSurface};
pub use word::{Letter, Word};
