//! The state of a surface that is being cut into tiles.
//!
//! In: a connected mesh and edge costs. Out: [`Cutting`]: the cuts so far, and the M-tiling that they make after every
//! step. Holds: after each step the cuts are simple and share neither an edge nor an inner vertex.
//! Source: [Favreau2009] §3.2, Figure 9.

use crate::cost::{EdgeCosts, FORBIDDEN};
use crate::cut_surface::{CutSurface, Walk};
use crate::error::TilingError;
use crate::search::Search;
use crate::tiling::{RefinedSurface, Tiling};
use quadloom_mesh::{EdgeMap, Progress, TriMesh, VertexId, topology};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// How far shortest loops and paths are looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SearchMode {
    /// Over all base points and corners.
    Exact,
    /// From one base point, and from all corners at once: longer cuts, in a fraction of the time.
    #[default]
    Fast,
}

/// How a mesh is cut into one tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Shortest non-separating loops, then shortest connections ([Favreau2009] Algorithm 1).
    #[default]
    Shortest,
    /// All loops through one point: 4g sides ([Favreau2009] Algorithm 2).
    SinglePoint,
    /// Shortest loops, then connections between as few points as possible ([Favreau2009] Algorithm 3).
    Intermediate,
}

/// What a step of a cutting did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CutKind {
    /// Cut along a loop.
    Loop,
    /// Joined two boundaries.
    Connection,
    /// Slit a sphere.
    Slit,
    /// Cut a polygon in two.
    Diagonal,
    /// Cut pants into cylinders.
    Belt,
    /// Was given by the user.
    Given,
}

/// One cut.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cut {
    /// What it did.
    pub kind: CutKind,
    /// What its edges cost together, before it was pulled off others; units of the costs.
    pub cost: f64,
    /// Vertices of the refined mesh, from one end to the other; equal for a loop.
    pub(crate) points: Vec<u32>,
}

impl Cut {
    /// Vertices of the refined mesh, from one end of the cut to the other; equal for a loop.
    pub fn path(&self) -> Vec<VertexId> {
        self.points.iter().map(|&p| VertexId(p)).collect()
    }
}

/// Options of cutting.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CutOptions {
    /// How far to look. Default: fast.
    pub search: SearchMode,
    /// Base point of all loops of a single-point cutting, and of the fast search. Default: one on a short loop.
    pub base: Option<VertexId>,
}

/// A surface cut so far.
pub struct Cutting<'a> {
    pub(crate) surface: CutSurface<'a>,
    pub(crate) costs: &'a EdgeCosts,
    pub(crate) units: Vec<u64>,
    pub(crate) search: Search,
    pub(crate) cuts: Vec<Cut>,
    /// Points that are nodes though no cut ends there.
    pub(crate) extra: Vec<u32>,
    pub(crate) progress: &'a Progress,
}

impl<'a> Cutting<'a> {
    /// A mesh without any cut.
    ///
    /// # Errors     [`TilingError::CostCount`], [`TilingError::Components`]
    /// # Cost       linear
    pub fn new(mesh: &'a TriMesh, costs: &'a EdgeCosts, progress: &'a Progress) -> Result<Self, TilingError> {
        if costs.values().len() != mesh.edge_count() {
            return Err(TilingError::CostCount { found: costs.values().len(), edges: mesh.edge_count() });
        }
        let components = topology::components(mesh).count;
        if components != 1 {
            return Err(TilingError::Components { components });
        }
        Ok(Self {
            surface: CutSurface::new(mesh),
            costs,
            units: costs.units(),
            search: Search::default(),
            cuts: Vec::new(),
            extra: Vec::new(),
            progress,
        })
    }

    /// The mesh as it was given.
    pub fn mesh(&self) -> &'a TriMesh {
        self.surface.mesh
    }

    /// The cuts, in the order in which they were made.
    pub fn cuts(&self) -> &[Cut] {
        &self.cuts
    }

    /// Sum of the costs of all cuts.
    pub fn cost(&self) -> f64 {
        self.cuts.iter().map(|c| c.cost).sum()
    }

    /// The tiling made by all cuts.
    ///
    /// # Errors     [`TilingError::Mesh`] if the refined mesh has more elements than ids
    pub fn tiling(&self) -> Result<Tiling, TilingError> {
        let surface = Arc::new(self.refined()?);
        Ok(self.tiling_after(&surface, self.cuts.len()))
    }

    /// The tilings before the first cut and after each one, all on the same refined mesh.
    ///
    /// # Errors     [`TilingError::Mesh`] if the refined mesh has more elements than ids
    /// # Cost       linear per cut
    pub fn steps(&self) -> Result<Vec<Tiling>, TilingError> {
        let surface = Arc::new(self.refined()?);
        Ok((0..=self.cuts.len()).map(|count| self.tiling_after(&surface, count)).collect())
    }

    fn refined(&self) -> Result<RefinedSurface, TilingError> {
        let finished = self.surface.finish()?;
        Ok(RefinedSurface { mesh: finished.mesh, parent_face: finished.parent, place: finished.place })
    }

    fn tiling_after(&self, surface: &Arc<RefinedSurface>, count: usize) -> Tiling {
        let mesh = &surface.mesh;
        let mut cut = EdgeMap::filled(mesh.edge_count(), false);
        for points in self.cuts[..count].iter().map(|c| &c.points) {
            for pair in points.windows(2) {
                if let Some(e) = mesh.find_edge(VertexId(pair[0]), VertexId(pair[1])) {
                    cut[e] = true;
                }
            }
        }
        let extra: Vec<VertexId> = self.extra.iter().map(|&p| VertexId(p)).collect();
        Tiling::from_cut(surface.clone(), &cut, &extra)
    }

    /// Cuts along a walk in C.
    pub(crate) fn cut_along(&mut self, walk: &Walk, kind: CutKind) -> Result<(), TilingError> {
        let cost = self.cost_of_walk(walk);
        let points = self.surface.cut_walk(walk)?;
        self.cuts.push(Cut { kind, cost, points });
        Ok(())
    }

    /// Cuts along a loop in C.
    pub(crate) fn cut_loop(&mut self, walk: &Walk) -> Result<(), TilingError> {
        let cost = self.cost_of_walk(walk);
        // It begins on an edge inside C, at a new vertex that is surely free; a border is pulled off as a whole.
        let s = &mut self.surface;
        let n = walk.edges.len();
        let opened = match (0..n).find(|&i| !s.is_border(walk.edges[i])) {
            None => walk.clone(),
            Some(free) => {
                let (from, to) = (walk.vertices[free], walk.vertices[free + 1]);
                let leaves = TilingError::Fault { what: "a loop leaves the surface" };
                let edge = s.leaving(walk.edges[free], from).ok_or(leaves)?;
                let base = s.base_of(from);
                let middle = s.split_edge(edge, base, from);
                let mut opened = Walk::start(middle);
                // edge: from → middle; the rest of it leaves the middle.
                opened.push(s.next[edge as usize], to);
                for k in 1..n {
                    let i = (free + k) % n;
                    opened.push(walk.edges[i], walk.vertices[i + 1]);
                }
                opened.push(edge, middle);
                opened
            }
        };
        let points = s.cut_walk(&opened)?;
        self.cuts.push(Cut { kind: CutKind::Loop, cost, points });
        Ok(())
    }

    /// What the edges of a walk cost.
    pub(crate) fn cost_of_walk(&self, walk: &Walk) -> f64 {
        let spans = walk.edges.iter().map(|&h| self.surface.span[h as usize]);
        spans.filter_map(|e| self.costs.values().values().get(e as usize)).sum()
    }

    /// Whether a cut may run along an edge of the mesh.
    pub(crate) fn allowed(&self, edge: usize) -> bool {
        self.units[edge] != FORBIDDEN
    }

    /// How many edges of cuts and of the border of the mesh meet in each point.
    pub(crate) fn degrees(&self) -> Vec<u32> {
        let s = &self.surface;
        let mut degree = vec![0; s.base.len()];
        for pair in self.cuts.iter().flat_map(|c| c.points.windows(2)) {
            pair.iter().for_each(|&p| degree[p as usize] += 1);
        }
        for h in (0..s.next.len() as u32).filter(|&h| s.is_border(h) && s.mate[h as usize] == crate::cut_surface::NONE)
        {
            degree[s.point[s.origin[h as usize] as usize] as usize] += 1;
            degree[s.point[s.target(h) as usize] as usize] += 1;
        }
        degree
    }

    /// Whether each point is a node.
    pub(crate) fn nodes(&self) -> Vec<bool> {
        let mut node: Vec<bool> = self.degrees().into_iter().map(|d| d != 0 && d != 2).collect();
        self.extra.iter().for_each(|&p| node[p as usize] = true);
        node
    }

    /// A base point, if it exists.
    pub(crate) fn checked_base(&self, base: Option<VertexId>) -> Result<Option<u32>, TilingError> {
        match base {
            Some(vertex) if vertex.index() >= self.mesh().vertex_count() => {
                Err(TilingError::NoVertex { vertex, last: self.mesh().vertex_count() - 1 })
            }
            other => Ok(other.map(|v| v.0)),
        }
    }
}
