//! Regular maps: groups, names, flat pictures, and what fits on what.
//!
//! In: a presentation ⟨R, S, T | …⟩, a name or a type. Out: [`RegularMap`]s, their flat pictures and [`TubeMatch`]es.
//! Holds: all that decides about groups and maps is integer arithmetic. Surfaces in space are another crate's.
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
pub mod enumerate;
mod error;
pub mod ids;
pub mod map;
pub mod matching;
mod partition;
pub mod plane;
pub mod presentation;
pub mod tiling;
pub mod word;

pub use coset::{CosetLimit, enumerate_cosets};
pub use error::MapError;
pub use ids::{FlagId, FlagMap, MapEdgeId, MapFaceId, MapVertexId};
pub use map::{Reflection, RegularMap};
pub use matching::{MatchOptions, Pole, TubeMatch, find_matches};
pub use plane::{Curvature, Plane};
pub use presentation::Presentation;
pub use word::{Letter, Word};
