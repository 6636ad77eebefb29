//! Ids of nodes, arcs and tiles.
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
    /// A 0-m-cell: where arcs end. Its image is a multipoint.
    NodeId, "n"
);
id!(
    /// A 1-m-cell: a curve between two nodes.
    ArcId, "a"
);
id!(
    /// A 2-m-cell: a tile.
    TileId, "t"
);

/// One value per node.
pub type NodeMap<T> = IdMap<NodeId, T>;
/// One value per arc.
pub type ArcMap<T> = IdMap<ArcId, T>;
/// One value per tile.
pub type TileMap<T> = IdMap<TileId, T>;
