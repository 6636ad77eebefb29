//! m-cells and m-cellular complexes, free of any mesh.
//!
//! In: nodes, arcs with their ends, cells with genus and boundaries. Out: [`CellComplex`] and what violates its
//! definition. Holds after an empty [`CellComplex::check`]: [Favreau2009] Definition 2.
//!
//! | paper | here |
//! |---|---|
//! | 0-m-cell, vertex, 0-face | node |
//! | 1-m-cell, edge, 1-face | arc; a [`Side`] is an arc as it occurs on a cell |
//! | 2-m-cell C | [`Cell`] |
//! | m-cellular complex | [`CellComplex`] |

use crate::ids::{ArcId, ArcMap, NodeId, TileId, TileMap};
use quadloom_mesh::Id;
use serde::{Deserialize, Serialize};

/// An arc as it occurs on the boundary of a cell, the cell to the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Side {
    /// The arc.
    pub arc: ArcId,
    /// Whether it is run from its end to its start.
    pub reversed: bool,
}

/// A 2-m-cell: a compact connected orientable surface whose boundaries are cycles of arcs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cell {
    /// Number of handles.
    pub genus: u32,
    /// Its boundaries; each a cycle of sides with the cell to the left.
    pub boundaries: Vec<Vec<Side>>,
}

/// Cells with their arcs and nodes ([Favreau2009] Def. 2).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CellComplex {
    /// Number of nodes.
    pub nodes: usize,
    /// First and last node of each arc.
    pub arcs: ArcMap<[NodeId; 2]>,
    /// The cells.
    pub cells: TileMap<Cell>,
}

/// What contradicts [Favreau2009] Definition 2.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ComplexDefect {
    /// An arc ends in a node that does not exist.
    #[error("arc {arc} ends in node {node}, which does not exist")]
    NoNode {
        /// The arc.
        arc: ArcId,
        /// The node.
        node: NodeId,
    },
    /// A side names an arc that does not exist.
    #[error("a side of tile {tile} is arc {arc}, which does not exist")]
    NoArc {
        /// The tile.
        tile: TileId,
        /// The arc.
        arc: ArcId,
    },
    /// A boundary without sides is no 1-complex.
    #[error("boundary {boundary} of tile {tile} has no side")]
    EmptyBoundary {
        /// The tile.
        tile: TileId,
        /// Which of its boundaries.
        boundary: usize,
    },
    /// Two sides of a boundary do not meet.
    #[error("sides {side} and the next of boundary {boundary} of tile {tile} do not meet in a node")]
    Gap {
        /// The tile.
        tile: TileId,
        /// Which of its boundaries.
        boundary: usize,
        /// Which of its sides.
        side: usize,
    },
    /// An arc is a side of no cell, or of more than two.
    #[error("arc {arc} is {sides} sides of tiles; one or two are possible")]
    Sides {
        /// The arc.
        arc: ArcId,
        /// How many sides.
        sides: usize,
    },
    /// Two sides run along an arc in the same direction: the cells are not oriented alike.
    #[error("both sides of arc {arc} run in the same direction")]
    Direction {
        /// The arc.
        arc: ArcId,
    },
}

impl Cell {
    /// Euler characteristic, 2 − 2·genus − boundaries.
    pub fn chi(&self) -> i64 {
        2 - 2 * i64::from(self.genus) - self.boundaries.len() as i64
    }
    /// The sides of an n-polygon; `None` for other cells.
    pub fn polygon(&self) -> Option<&[Side]> {
        match &self.boundaries[..] {
            [sides] if self.genus == 0 => Some(sides),
            _ => None,
        }
    }
    /// Number of sides on all boundaries.
    pub fn side_count(&self) -> usize {
        self.boundaries.iter().map(Vec::len).sum()
    }
}

impl CellComplex {
    /// Node at which a side starts.
    pub fn start(&self, side: Side) -> NodeId {
        self.arcs[side.arc][usize::from(side.reversed)]
    }
    /// Node at which a side ends.
    pub fn end(&self, side: Side) -> NodeId {
        self.arcs[side.arc][usize::from(!side.reversed)]
    }

    /// Whether every cell is a polygon with an even number of sides, at least four ([Favreau2009] Def. 7).
    pub fn verifies_q_criterion(&self) -> bool {
        self.cells.values().iter().all(|c| c.polygon().is_some_and(|sides| sides.len() >= 4 && sides.len() % 2 == 0))
    }

    /// Everything that contradicts the definition.
    ///
    /// # Cost       linear
    pub fn check(&self) -> Vec<ComplexDefect> {
        let mut defects = Vec::new();
        for (arc, ends) in self.arcs.iter() {
            let missing = ends.iter().filter(|n| n.index() >= self.nodes);
            defects.extend(missing.map(|&node| ComplexDefect::NoNode { arc, node }));
        }
        let mut sides: ArcMap<[usize; 2]> = ArcMap::filled(self.arcs.len(), [0; 2]);
        for (tile, cell) in self.cells.iter() {
            for (boundary, cycle) in cell.boundaries.iter().enumerate() {
                let missing = cycle.iter().filter(|s| s.arc.index() >= self.arcs.len());
                let before = defects.len();
                defects.extend(missing.map(|s| ComplexDefect::NoArc { tile, arc: s.arc }));
                if cycle.is_empty() {
                    defects.push(ComplexDefect::EmptyBoundary { tile, boundary });
                }
                if defects.len() > before {
                    continue;
                }
                for (side, &s) in cycle.iter().enumerate() {
                    sides[s.arc][usize::from(s.reversed)] += 1;
                    if self.end(s) != self.start(cycle[(side + 1) % cycle.len()]) {
                        defects.push(ComplexDefect::Gap { tile, boundary, side });
                    }
                }
            }
        }
        for (arc, &[along, against]) in sides.iter() {
            if !(1..=2).contains(&(along + against)) {
                defects.push(ComplexDefect::Sides { arc, sides: along + against });
            } else if along == 2 || against == 2 {
                defects.push(ComplexDefect::Direction { arc });
            }
        }
        defects
    }
}
