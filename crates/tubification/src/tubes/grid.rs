//! Quarter-tubes glued: which grid points of which patches are one vertex.
//!
//! In: a map and how finely its patches are divided. Out: [`Grid`]: vertices, quads, corners of the cage.
//! Holds: every side of every patch is glued to exactly one other side, turned so that orientations agree: the quads are a
//! closed oriented surface. Not: positions.
//! Source: [Razafindrazaka2015] §9.4, §9.5 (Fig. 9.15).
//!
//! ```text
//!   P2 ── b ── M2   v = 1      a of f with a of f·r₁, v with 1 − v
//!   │          │               c of f with c of f·r₀, v with 1 − v
//!   a          c               d of f with b of f·r₂, the same u
//!   │          │
//!   P1 ── d ── M1   v = 0
//!  u = 0      u = 1
//! ```

use quadloom_mesh::Id;
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::{Reflection, RegularMap};

/// A grid point of a patch: column along the tube, row around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Node {
    pub(super) flag: FlagId,
    pub(super) i: usize,
    pub(super) j: usize,
}

/// The patches of all flags, divided alike, as one surface.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    along: usize,
    around: usize,
    vertex: Vec<u32>,
    nodes: Vec<Node>,
}

impl Grid {
    /// # Input      cells along a patch (u) and around it (v)
    /// # Cost       linear in the grid points
    pub(super) fn new(map: &RegularMap, along: usize, around: usize) -> Self {
        let mut grid = Self { along, around, vertex: Vec::new(), nodes: Vec::new() };
        let mut root: Vec<u32> = (0..(map.order() * grid.per_patch()) as u32).collect();
        for flag in map.flags() {
            for (here, there) in grid.glued(map, flag) {
                join(&mut root, grid.slot(here), grid.slot(there));
            }
        }
        for k in 0..root.len() {
            let to = find(&mut root, k as u32) as usize;
            let number = if to == k { grid.nodes.len() as u32 } else { grid.vertex[to] };
            if to == k {
                grid.nodes.push(grid.node(k));
            }
            grid.vertex.push(number);
        }
        grid
    }

    pub(super) fn along(&self) -> usize {
        self.along
    }

    pub(super) fn around(&self) -> usize {
        self.around
    }

    /// One grid point for each vertex: of those that are the same, the first.
    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The vertex of a grid point.
    pub(super) fn vertex(&self, flag: FlagId, i: usize, j: usize) -> usize {
        self.vertex[self.slot(Node { flag, i, j })] as usize
    }

    /// The quads: patch by patch, along the tube first; counter-clockwise from outside.
    pub(super) fn faces(&self, map: &RegularMap) -> Vec<[u32; 4]> {
        let cell = |k: usize| {
            let (flag, i, j) = self.cell(k);
            [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.vertex(flag, i, j) as u32)
        };
        (0..map.order() * self.along * self.around).map(cell).collect()
    }

    /// Patch and cell of a quad.
    pub(super) fn cell(&self, face: usize) -> (FlagId, usize, usize) {
        let per_patch = self.along * self.around;
        let rest = face % per_patch;
        (FlagId::new(face / per_patch), rest % self.along, rest / self.along)
    }

    /// Grid points of a patch's sides and those they are glued to.
    fn glued(&self, map: &RegularMap, flag: FlagId) -> Vec<(Node, Node)> {
        let [r0, r1, r2] = Reflection::ALL.map(|by| map.reflect(flag, by));
        let turned =
            |there: FlagId, i: usize, j: usize| (Node { flag, i, j }, Node { flag: there, i, j: self.around - j });
        let a = (0..=self.around).map(|j| turned(r1, 0, j));
        let c = (0..=self.around).map(|j| turned(r0, self.along, j));
        let d = (0..=self.along).map(|i| (Node { flag, i, j: 0 }, Node { flag: r2, i, j: self.around }));
        a.chain(c).chain(d).collect()
    }

    fn per_patch(&self) -> usize {
        (self.along + 1) * (self.around + 1)
    }

    fn slot(&self, node: Node) -> usize {
        node.flag.index() * self.per_patch() + node.j * (self.along + 1) + node.i
    }

    fn node(&self, slot: usize) -> Node {
        let rest = slot % self.per_patch();
        let flag = FlagId::new(slot / self.per_patch());
        Node { flag, i: rest % (self.along + 1), j: rest / (self.along + 1) }
    }
}

/// Vertices, edges and faces of the cage that has one quad per flag.
pub(super) fn cage_counts(map: &RegularMap) -> [usize; 3] {
    // No reflection leaves a flag where it is, so each of a quad's four sides is glued to another one.
    [Grid::new(map, 1, 1).nodes.len(), 2 * map.order(), map.order()]
}

fn find(root: &mut [u32], mut x: u32) -> u32 {
    while root[x as usize] != x {
        root[x as usize] = root[root[x as usize] as usize];
        x = root[x as usize];
    }
    x
}

fn join(root: &mut [u32], a: usize, b: usize) {
    let (a, b) = (find(root, a as u32), find(root, b as u32));
    root[a.max(b) as usize] = a.min(b);
}
