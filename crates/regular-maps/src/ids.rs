//! Ids of flags, vertices, edges and faces of a map.
//!
//! In: an element count. Out: ids that cannot be mixed up with each other or with a mesh's.

use quadloom_mesh::{Id, IdMap};
use serde::{Deserialize, Serialize};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident, $letter:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub u32);

        impl Id for $name {
            fn new(index: usize) -> Self {
                Self(index as u32)
            }
            fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl std::fmt::Debug for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, concat!($letter, "{}"), self.0)
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, "{}", self.0)
            }
        }
    };
}

id!(
    /// A flag of a map, and the element of its group that takes flag 0 there.
    FlagId, "g"
);
id!(
    /// A vertex of a map, numbered by its smallest flag.
    MapVertexId, "v"
);
id!(
    /// An edge of a map, numbered by its smallest flag.
    MapEdgeId, "e"
);
id!(
    /// A face of a map, numbered by its smallest flag.
    MapFaceId, "f"
);

/// One value per flag.
pub type FlagMap<T> = IdMap<FlagId, T>;
