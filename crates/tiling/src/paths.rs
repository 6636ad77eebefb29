//! 1-paths and 1-loops of the cell that is being cut ([Favreau2009] Def. 5), shortest ones, and cuts along given ones.
//!
//! In: a [`Cutting`], vertices of its mesh. Out: [`MeshPath`]s, the [`LoopKind`] of a loop, a surface cut further.
//! Holds: a path is valid if it is the image of one in C: edge after edge it exists there, so it crosses no earlier cut;
//! it may touch cuts and run along them, and is pulled off when it is cut. Where several paths in C have the image, one
//! is taken: the same for the same input.

use crate::classes::{Borders, classes};
use crate::cut_surface::{NONE, Walk};
use crate::cutting::{CutKind, Cutting, SearchMode};
use crate::error::TilingError;
use crate::search::Found;
use quadloom_mesh::VertexId;
use std::collections::{BTreeMap, BTreeSet};

/// What a loop does to the cell in which it runs ([Favreau2009] Def. 5, Figure 6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopKind {
    /// Homotopic to a point: it bounds a disk.
    Trivial,
    /// Splits the cell in two, neither of them a disk.
    Separating,
    /// Does not split the cell.
    NonSeparating,
}

/// A path along edges of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshPath {
    /// Vertices of the mesh, from one end to the other; equal for a loop.
    pub vertices: Vec<VertexId>,
    /// What its edges cost.
    pub cost: f64,
}

impl Cutting<'_> {
    /// The shortest valid loop that does not separate the cell; `None` where there is none.
    ///
    /// # Errors     [`TilingError::NoWay`] where forbidden edges leave none; [`TilingError::Cancelled`]
    /// # Cost       as one loop of [`crate::cut_shortest`]
    pub fn shortest_loop(&mut self, search: SearchMode) -> Result<Option<MeshPath>, TilingError> {
        let known = classes(&self.surface, &self.units, self.any_vertex(), Borders::Capped, &[]);
        if known.closing.is_empty() {
            return Ok(None);
        }
        let found = self.loop_of(&known, None, search, &mut None)?;
        Ok(Some(self.image(&found.walk)))
    }

    /// The shortest valid loop through a vertex that does not separate the cell; `None` where there is none. What it runs
    /// to and fro is left out.
    ///
    /// # Errors     [`TilingError::NoVertex`]
    /// # Cost       O(n log n)
    pub fn shortest_loop_at(&mut self, base: VertexId) -> Result<Option<MeshPath>, TilingError> {
        self.checked_base(Some(base))?;
        let known = classes(&self.surface, &self.units, self.any_vertex(), Borders::Capped, &[]);
        let mut best: Option<Found> = None;
        for v in self.copies(base) {
            let (s, bound) = (&self.surface, best.as_ref().map_or(u64::MAX, |f| f.length));
            best = self.search.shortest_loop(s, &self.units, &known.class, v, bound, |c| c == 0).or(best);
        }
        Ok(best.map(|found| self.image(&found.walk)))
    }

    /// The shortest valid path between two vertices; `None` where there is none.
    ///
    /// # Errors     [`TilingError::NoVertex`]
    /// # Cost       O(n log n)
    pub fn shortest_path(&mut self, from: VertexId, to: VertexId) -> Result<Option<MeshPath>, TilingError> {
        self.checked_base(Some(from))?;
        self.checked_base(Some(to))?;
        let (starts, ends) = (self.copies(from), self.copies(to));
        let found = self.search.path(&self.surface, &self.units, &starts, u64::MAX, |v| ends.contains(&v));
        Ok(found.map(|found| self.image(&found.walk)))
    }

    /// The shortest valid path between two different boundaries of the cell; `None` if it has only one.
    ///
    /// # Cost       O(n log n)
    pub fn shortest_boundary_path(&mut self) -> Option<MeshPath> {
        self.shortest_connection().map(|found| self.image(&found.walk))
    }

    /// What a closed path does to the cell.
    ///
    /// # Input      vertices along edges of the mesh, the last equal to the first
    /// # Errors     [`TilingError::Path`] names the first place where it is not valid, or meets itself
    /// # Cost       linear
    pub fn kind_of_loop(&self, path: &[VertexId]) -> Result<LoopKind, TilingError> {
        let walk = self.valid_walk(path)?;
        if walk.vertices[0] != walk.last() {
            return Err(TilingError::Path { at: path.len() - 1, why: "the path is not closed in the cell" });
        }
        self.must_be_simple(&walk)?;
        let s = &self.surface;
        let on_walk: BTreeSet<u32> = walk.edges.iter().flat_map(|&h| [h, s.twin[h as usize]]).collect();
        // The faces on either side of the first edge, without crossing the loop.
        let h = walk.edges[0];
        let t = s.twin[h as usize];
        let left = self.side_of(h, &on_walk);
        if t == NONE || !left.contains(&s.face[t as usize]) {
            let right = if t == NONE { BTreeSet::new() } else { self.side_of(t, &on_walk) };
            let is_disk =
                [&left, &right].into_iter().any(|faces| !faces.is_empty() && self.chi_cut_open(faces, &on_walk) == 1);
            return Ok(if is_disk { LoopKind::Trivial } else { LoopKind::Separating });
        }
        Ok(LoopKind::NonSeparating)
    }

    /// Cuts along a path or loop of one's own ([Favreau2009] §3.2.2).
    ///
    /// # Input      vertices along edges of the mesh; the last equal to the first for a loop
    /// # Errors     [`TilingError::Path`] names the first place where it is not valid, or meets itself
    /// # Cost       linear in the path's surroundings
    pub fn cut_path(&mut self, path: &[VertexId]) -> Result<(), TilingError> {
        let walk = self.valid_walk(path)?;
        self.must_be_simple(&walk)?;
        if walk.vertices[0] == walk.last() { self.cut_loop(&walk) } else { self.cut_along(&walk, CutKind::Given) }
    }

    /// A vertex of C.
    fn any_vertex(&self) -> u32 {
        self.surface.out.iter().position(|&h| h != NONE).unwrap_or(0) as u32
    }

    /// Vertices of C that stand for a vertex of the mesh.
    fn copies(&self, v: VertexId) -> Vec<u32> {
        let s = &self.surface;
        (0..s.vertex_count() as u32).filter(|&c| s.out[c as usize] != NONE && s.base_of(c) == v.0).collect()
    }

    /// F of a walk, in vertices of the mesh: points that stand for one vertex count once.
    fn image(&self, walk: &Walk) -> MeshPath {
        let mut vertices: Vec<VertexId> = walk.vertices.iter().map(|&v| VertexId(self.surface.base_of(v))).collect();
        vertices.dedup();
        MeshPath { vertices, cost: self.cost_of_walk(walk) }
    }

    /// A walk in C whose image is a path of the mesh; a closed one, if there is one.
    fn valid_walk(&self, path: &[VertexId]) -> Result<Walk, TilingError> {
        if path.len() < 2 {
            return Err(TilingError::Path { at: 0, why: "a path has at least one edge" });
        }
        path.iter().try_for_each(|&v| self.checked_base(Some(v)).map(|_| ()))?;
        let closed = path[0] == path[path.len() - 1];
        let mut open = None;
        let mut farthest = TilingError::Path { at: 0, why: "it crosses an earlier cut" };
        for start in self.copies(path[0]) {
            match self.walk_from(start, path) {
                Ok(walk) if !closed || walk.last() == start => return Ok(walk),
                Ok(walk) => open = open.or(Some(walk)),
                Err(TilingError::Path { at, why }) => {
                    if matches!(farthest, TilingError::Path { at: before, .. } if at >= before) {
                        farthest = TilingError::Path { at, why };
                    }
                }
                Err(other) => return Err(other),
            }
        }
        open.ok_or(farthest)
    }

    /// A walk from a vertex of C whose image is a path; where it can, it ends where it begins.
    fn walk_from(&self, start: u32, path: &[VertexId]) -> Result<Walk, TilingError> {
        let s = &self.surface;
        // 1. Vertices of C that can be reached, one vertex of the path after the other.
        let mut layers: Vec<BTreeMap<u32, (u32, u32)>> = vec![BTreeMap::from([(start, (NONE, NONE))])];
        for (at, pair) in path.windows(2).enumerate() {
            let edge = self.mesh().find_edge(pair[0], pair[1]);
            let edge = edge.ok_or(TilingError::Path { at, why: "two of its vertices are not joined by an edge" })?;
            let mut next = BTreeMap::new();
            for &v in layers[at].keys() {
                s.for_edges(v, |h, w| {
                    if s.span[h as usize] == edge.0 && s.base_of(w) == pair[1].0 {
                        next.entry(w).or_insert((v, h));
                    }
                });
            }
            if next.is_empty() {
                return Err(TilingError::Path { at, why: "it crosses an earlier cut" });
            }
            layers.push(next);
        }
        // 2. Back from an end.
        let end = &layers[layers.len() - 1];
        let last = if end.contains_key(&start) { start } else { end.keys().next().copied().unwrap_or(start) };
        let mut back = Walk::start(last);
        for layer in layers.iter().skip(1).rev() {
            if let Some(&(before, h)) = layer.get(&back.last()) {
                back.push(h, before);
            }
        }
        Ok(back.reversed())
    }

    fn must_be_simple(&self, walk: &Walk) -> Result<(), TilingError> {
        let mut seen = BTreeSet::new();
        let meets = walk.vertices[1..].iter().position(|&v| !seen.insert(v));
        match meets {
            Some(at) => Err(TilingError::Path { at: at + 1, why: "it meets itself" }),
            None if walk.vertices[0] != walk.last() && seen.contains(&walk.vertices[0]) => {
                Err(TilingError::Path { at: 0, why: "it meets itself" })
            }
            None => Ok(()),
        }
    }

    /// Faces that can be reached from a half-edge's without crossing certain edges.
    fn side_of(&self, h: u32, walls: &BTreeSet<u32>) -> BTreeSet<u32> {
        let s = &self.surface;
        let mut faces = BTreeSet::from([s.face[h as usize]]);
        let mut stack = vec![s.face[h as usize]];
        while let Some(f) = stack.pop() {
            for side in s.sides(f) {
                let t = s.twin[side as usize];
                if t != NONE && !walls.contains(&side) && faces.insert(s.face[t as usize]) {
                    stack.push(s.face[t as usize]);
                }
            }
        }
        faces
    }

    /// V − E + F of some faces, cut open along certain edges and along all edges where they end.
    fn chi_cut_open(&self, faces: &BTreeSet<u32>, walls: &BTreeSet<u32>) -> i64 {
        let s = &self.surface;
        let is_wall = |h: u32| s.twin[h as usize] == NONE || walls.contains(&h);
        let sides: Vec<u32> = faces.iter().flat_map(|&f| s.sides(f)).collect();
        let walled = sides.iter().filter(|&&h| is_wall(h)).count() as i64;
        // Every border half-edge begins one border vertex; other vertices are inside.
        let mut inner: BTreeSet<u32> = sides.iter().map(|&h| s.origin[h as usize]).collect();
        for &h in sides.iter().filter(|&&h| is_wall(h)) {
            inner.remove(&s.origin[h as usize]);
            inner.remove(&s.target(h));
        }
        let edges = (sides.len() as i64 - walled) / 2 + walled;
        inner.len() as i64 + walled - edges + faces.len() as i64
    }
}
