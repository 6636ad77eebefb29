//! M-tilings: an m-cellular complex embedded in a triangle mesh.
//!
//! In: a refined mesh and the edges along which it is cut. Out: [`Tiling`]: nodes, arcs and tiles with their images.
//! Holds after an empty [`Tiling::check`]: [Favreau2009] Definitions 2 to 4, and with it every promise of the cutting:
//! cuts are simple and disjoint, tiles cover the surface once, and each has the genus and boundaries that it says.

use crate::cells::{Cell, CellComplex, ComplexDefect, Side};
use crate::error::TilingError;
use crate::ids::{ArcId, ArcMap, NodeId, NodeMap, TileId, TileMap};
use crate::word::{self, Letter, Word};
use quadloom_mesh::{EdgeId, EdgeMap, FaceId, FaceMap, HalfEdgeId, HalfEdgeMap, Id, SurfacePoint, TriMesh, VertexId};
use quadloom_mesh::{VertexMap, topology};
use std::sync::Arc;

/// A finer mesh of the same surface.
#[derive(Clone, Debug)]
pub struct RefinedSurface {
    /// The mesh; vertices of the parent come first, with their ids.
    pub mesh: TriMesh,
    /// Parent face of each face.
    pub parent_face: FaceMap<FaceId>,
    /// Where each vertex lies on the parent.
    pub place: VertexMap<SurfacePoint>,
}

/// An M-tiling (C, M, F) ([Favreau2009] Def. 4).
#[derive(Clone, Debug)]
pub struct Tiling {
    /// M, shared by all tilings that came before and after this one.
    pub surface: Arc<RefinedSurface>,
    /// C.
    pub complex: CellComplex,
    /// F(node): the multipoints.
    pub node_vertex: NodeMap<VertexId>,
    /// F(arc): vertices from the arc's first node to its last.
    pub arc_path: ArcMap<Vec<VertexId>>,
    /// F⁻¹ of faces.
    pub face_tile: FaceMap<TileId>,
}

/// What contradicts [Favreau2009] Definitions 2 to 4.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TilingDefect {
    /// The complex is none.
    #[error(transparent)]
    Complex(#[from] ComplexDefect),
    /// Two nodes have one image.
    #[error("nodes {0} and {1} are both vertex {2}")]
    NodesMeet(NodeId, NodeId, VertexId),
    /// F is not continuous along an arc: its ends are not its nodes, or two vertices are not joined by an edge.
    #[error("arc {arc} is broken at its vertex number {at}")]
    BrokenArc {
        /// The arc.
        arc: ArcId,
        /// Index in its path.
        at: usize,
    },
    /// F is not injective on the insides of arcs and on nodes.
    #[error("arcs {0} and {1} meet at vertex {2}, which is no end of both")]
    ArcsMeet(ArcId, ArcId, VertexId),
    /// Two arcs share an edge.
    #[error("arcs {0} and {1} share edge {2}")]
    ArcsOverlap(ArcId, ArcId, EdgeId),
    /// An edge of the mesh's boundary is on no arc.
    #[error("edge {0} of the boundary lies on no arc")]
    OpenBoundary(EdgeId),
    /// A face belongs to a tile that does not exist.
    #[error("face {0} belongs to no tile")]
    NoTile(FaceId),
    /// A tile has no face.
    #[error("tile {0} has no face")]
    EmptyTile(TileId),
    /// The faces of a tile are not connected without crossing arcs, or those of two tiles are.
    #[error("faces {0} and {1} meet across an edge on no arc and are in tiles {2} and {3}")]
    TilesOverlap(FaceId, FaceId, TileId, TileId),
    /// The faces of a tile form several pieces.
    #[error("the faces of tile {tile} form {pieces} pieces")]
    TileInPieces {
        /// The tile.
        tile: TileId,
        /// Number of pieces.
        pieces: usize,
    },
    /// The boundary of a tile's faces is not the image of the cell's boundary.
    #[error("boundary {boundary} of tile {tile} does not run around its faces")]
    Boundary {
        /// The tile.
        tile: TileId,
        /// Which of its boundaries.
        boundary: usize,
    },
    /// The faces have boundaries that the cell has not.
    #[error("tile {tile} has {found} half-edges on its border, and its sides have {stated}")]
    BoundaryLength {
        /// The tile.
        tile: TileId,
        /// Border half-edges of its faces.
        found: usize,
        /// Edges of the images of its sides.
        stated: usize,
    },
    /// The faces have another topology than the cell.
    #[error("the faces of tile {tile} have chi = {found}, and its cell has {stated}")]
    Topology {
        /// The tile.
        tile: TileId,
        /// Euler characteristic of the faces, cut open.
        found: i64,
        /// Euler characteristic of the cell.
        stated: i64,
    },
}

/// Where a node or an arc of a finer tiling lies in a coarser one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carrier {
    /// In a node.
    Node(NodeId),
    /// On an arc.
    Arc(ArcId),
    /// Inside a tile.
    Tile(TileId),
}

/// The surjection π from the cells of a finer tiling to those of a coarser one ([Favreau2009] §3.2.2).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Surjection {
    /// Image of each node.
    pub nodes: NodeMap<Carrier>,
    /// Image of each arc.
    pub arcs: ArcMap<Carrier>,
    /// Image of each tile.
    pub tiles: TileMap<TileId>,
}

/// Cut edges and borders of a mesh as arcs between nodes.
struct Tracer<'a> {
    mesh: &'a TriMesh,
    line: EdgeMap<bool>,
    arc_of: EdgeMap<Option<ArcId>>,
    node_of: VertexMap<Option<NodeId>>,
    node_vertex: Vec<VertexId>,
    paths: Vec<Vec<VertexId>>,
}

impl Tiling {
    /// The tiling whose tiles are what a cut leaves of a surface ([Favreau2009] Lemma 1, for any number of tiles).
    ///
    /// Nodes are the vertices where other than two cut or border edges meet, `extra` ones, and one on each cycle that
    /// has none (this is what is left after removing superfluous vertices, [Favreau2009] Figure 5).
    ///
    /// # Input      cut: true for edges of the cut; border edges count as cut already
    /// # Cost       linear
    pub fn from_cut(surface: Arc<RefinedSurface>, cut: &EdgeMap<bool>, extra: &[VertexId]) -> Self {
        let mesh = &surface.mesh;
        let line = EdgeMap::from_fn(mesh.edge_count(), |e| cut[e] || mesh.is_boundary_edge(e));
        let mut tracer = Tracer::new(mesh, line);
        tracer.trace(extra);
        let (face_tile, cells) = tracer.tiles();
        let Tracer { node_vertex, paths, node_of, .. } = tracer;
        let end = |v: Option<&VertexId>| v.and_then(|&v| node_of[v]).unwrap_or(NodeId(0));
        let arcs = ArcMap::from_vec(paths.iter().map(|p| [end(p.first()), end(p.last())]).collect());
        let complex = CellComplex { nodes: node_vertex.len(), arcs, cells };
        let node_vertex = NodeMap::from_vec(node_vertex);
        Self { surface: surface.clone(), complex, node_vertex, arc_path: ArcMap::from_vec(paths), face_tile }
    }

    /// The mesh M.
    pub fn mesh(&self) -> &TriMesh {
        &self.surface.mesh
    }

    /// A letter for each arc, in the order in which they occur on the tiles.
    pub fn letters(&self) -> ArcMap<Letter> {
        let mut letters = ArcMap::filled(self.complex.arcs.len(), None);
        let mut next = 0;
        for side in self.complex.cells.values().iter().flat_map(|c| c.boundaries.iter().flatten()) {
            letters[side.arc].get_or_insert_with(|| {
                next += 1;
                Letter(next - 1)
            });
        }
        ArcMap::from_vec(letters.values().iter().map(|l| l.unwrap_or(Letter(next))).collect())
    }

    /// The polygonal schema of a tile: the letters of its sides ([Favreau2009] §3.3.1); `None` if it is no polygon.
    pub fn word(&self, tile: TileId) -> Option<Word> {
        let letters = self.letters();
        let side = |s: &Side| word::Side { letter: letters[s.arc], inverse: s.reversed };
        Word::new(self.complex.cells[tile].polygon()?.iter().map(side).collect()).ok()
    }

    /// True for edges on arcs that are not the mesh's boundary.
    pub fn cut_edges(&self) -> EdgeMap<bool> {
        let mesh = self.mesh();
        let mut cut = EdgeMap::filled(mesh.edge_count(), false);
        for path in self.arc_path.values() {
            for e in edges_of(mesh, path).flatten() {
                cut[e] = !mesh.is_boundary_edge(e);
            }
        }
        cut
    }

    /// Whether an arc lies on the boundary of the mesh.
    pub fn is_border(&self, arc: ArcId) -> bool {
        edges_of(self.mesh(), &self.arc_path[arc]).flatten().next().is_some_and(|e| self.mesh().is_boundary_edge(e))
    }

    /// Length of an arc's image, file units.
    pub fn arc_length(&self, arc: ArcId) -> f64 {
        let mesh = self.mesh();
        self.arc_path[arc].windows(2).map(|p| mesh.position(p[0]).distance(mesh.position(p[1]))).sum()
    }

    /// Length of all cuts, without the mesh's boundary, file units.
    pub fn cut_length(&self) -> f64 {
        let arcs = (0..self.arc_path.len()).map(ArcId::new).filter(|&a| !self.is_border(a));
        arcs.map(|a| self.arc_length(a)).sum()
    }

    /// Faces of a tile, ascending.
    pub fn tile_faces(&self, tile: TileId) -> Vec<FaceId> {
        self.face_tile.iter().filter(|(_, t)| **t == tile).map(|(f, _)| f).collect()
    }

    /// Half-edges along a side, in its direction, inside the given tile (its faces lie to the left).
    pub fn side_half_edges(&self, side: Side) -> Vec<HalfEdgeId> {
        let mut path = self.arc_path[side.arc].clone();
        if side.reversed {
            path.reverse();
        }
        path.windows(2).filter_map(|p| self.mesh().find_half_edge(p[0], p[1])).collect()
    }

    /// Whether every tile is a disk.
    ///
    /// # Errors     [`TilingError::NotDisks`] names the first one that is none
    pub fn must_be_disks(&self) -> Result<(), TilingError> {
        match self.complex.cells.iter().find(|(_, cell)| cell.polygon().is_none()) {
            None => Ok(()),
            Some((tile, cell)) => Err(TilingError::NotDisks {
                tiles: self.complex.cells.len(),
                tile: tile.index(),
                genus: i64::from(cell.genus),
                boundaries: cell.boundaries.len(),
            }),
        }
    }

    /// One tile out of all, by taking away arcs between different tiles, longest first ([Favreau2009] §4.1).
    ///
    /// # Output     a tiling with one tile per component of the mesh; disks merge to a disk
    /// # Cost       O(arcs log arcs) and linear in the mesh
    pub fn merged(&self) -> Self {
        let mut arcs: Vec<(f64, ArcId)> = self
            .complex
            .arcs
            .iter()
            .map(|(a, _)| (self.arc_length(a), a))
            .filter(|&(_, a)| !self.is_border(a))
            .collect();
        arcs.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut beside: ArcMap<Vec<TileId>> = ArcMap::filled(self.complex.arcs.len(), Vec::new());
        for (tile, cell) in self.complex.cells.iter() {
            cell.boundaries.iter().flatten().for_each(|s| beside[s.arc].push(tile));
        }
        let mut group: Vec<usize> = (0..self.complex.cells.len()).collect();
        let mut cut = self.cut_edges();
        for (_, arc) in arcs {
            let roots: Vec<usize> = beside[arc].iter().map(|t| root(&mut group, t.index())).collect();
            if let [a, b] = roots[..]
                && a != b
            {
                group[a.max(b)] = a.min(b);
                edges_of(self.mesh(), &self.arc_path[arc]).flatten().for_each(|e| cut[e] = false);
            }
        }
        prune(self.mesh(), &mut cut);
        Self::from_cut(self.surface.clone(), &cut, &[])
    }

    /// The surjection π onto a coarser tiling of the same refined mesh, with F ∘ π = F.
    ///
    /// # Errors     the first node or arc of `coarser` that this tiling has not got
    pub fn surjection(&self, coarser: &Tiling) -> Result<Surjection, TilingError> {
        let mesh = self.mesh();
        let fault = TilingError::Fault { what: "two tilings of different cuts were compared" };
        if coarser.mesh().face_count() != mesh.face_count() {
            return Err(fault);
        }
        let mut on_vertex: VertexMap<Option<Carrier>> = VertexMap::filled(mesh.vertex_count(), None);
        let mut on_edge: EdgeMap<Option<Carrier>> = EdgeMap::filled(mesh.edge_count(), None);
        for (arc, path) in coarser.arc_path.iter() {
            path.iter().for_each(|&v| on_vertex[v] = Some(Carrier::Arc(arc)));
            edges_of(mesh, path).flatten().for_each(|e| on_edge[e] = Some(Carrier::Arc(arc)));
        }
        for (node, &v) in coarser.node_vertex.iter() {
            on_vertex[v] = Some(Carrier::Node(node));
        }
        let inside = |f: FaceId| Carrier::Tile(coarser.face_tile[f]);
        let node = |v: VertexId| on_vertex[v].unwrap_or_else(|| inside(mesh.face(mesh.outgoing_half_edge(v))));
        let arc = |path: &Vec<VertexId>| {
            let e = edges_of(mesh, path).flatten().next();
            e.map(|e| on_edge[e].unwrap_or_else(|| inside(mesh.edge_faces(e).0)))
        };
        let arcs: Option<Vec<Carrier>> = self.arc_path.values().iter().map(arc).collect();
        let mut tiles: TileMap<TileId> = TileMap::filled(self.complex.cells.len(), TileId(0));
        self.face_tile.iter().for_each(|(f, &t)| tiles[t] = coarser.face_tile[f]);
        Ok(Surjection {
            nodes: NodeMap::from_vec(self.node_vertex.values().iter().map(|&v| node(v)).collect()),
            arcs: ArcMap::from_vec(arcs.ok_or(fault)?),
            tiles,
        })
    }

    /// Everything that contradicts [Favreau2009] Definitions 2 to 4, word for word.
    ///
    /// # Cost       linear
    pub fn check(&self) -> Vec<TilingDefect> {
        let mut defects: Vec<TilingDefect> = self.complex.check().into_iter().map(Into::into).collect();
        if !defects.is_empty() {
            return defects;
        }
        self.check_nodes(&mut defects);
        let arc_of = self.check_arcs(&mut defects);
        self.check_tiles(&arc_of, &mut defects);
        if defects.is_empty() {
            self.check_boundaries(&arc_of, &mut defects);
        }
        defects
    }

    /// F(v) is a 0-simplex, and nodes of the complex are apart.
    fn check_nodes(&self, defects: &mut Vec<TilingDefect>) {
        let mut node_of: VertexMap<Option<NodeId>> = VertexMap::filled(self.mesh().vertex_count(), None);
        for (node, &v) in self.node_vertex.iter() {
            if let Some(other) = node_of[v].replace(node) {
                defects.push(TilingDefect::NodesMeet(other, node, v));
            }
        }
    }

    /// F(e) is a set of 1-simplexes, continuous; arcs are simple, and equal or disjoint on their insides.
    fn check_arcs(&self, defects: &mut Vec<TilingDefect>) -> EdgeMap<Option<ArcId>> {
        let mesh = self.mesh();
        let mut arc_of: EdgeMap<Option<ArcId>> = EdgeMap::filled(mesh.edge_count(), None);
        let mut inside: VertexMap<Option<ArcId>> = VertexMap::filled(mesh.vertex_count(), None);
        let mut is_node = VertexMap::filled(mesh.vertex_count(), false);
        self.node_vertex.values().iter().for_each(|&v| is_node[v] = true);
        for (arc, path) in self.arc_path.iter() {
            let ends = self.complex.arcs[arc].map(|n| self.node_vertex[n]);
            if path.len() < 2 || path.first() != Some(&ends[0]) || path.last() != Some(&ends[1]) {
                defects.push(TilingDefect::BrokenArc { arc, at: 0 });
                continue;
            }
            for &v in &path[1..path.len() - 1] {
                if let Some(other) = inside[v].replace(arc) {
                    defects.push(TilingDefect::ArcsMeet(other, arc, v));
                }
                if is_node[v] {
                    defects.push(TilingDefect::ArcsMeet(arc, arc, v));
                }
            }
            for (at, edge) in edges_of(mesh, path).enumerate() {
                match edge {
                    None => defects.push(TilingDefect::BrokenArc { arc, at }),
                    Some(e) => {
                        if let Some(other) = arc_of[e].replace(arc) {
                            defects.push(TilingDefect::ArcsOverlap(other, arc, e));
                        }
                    }
                }
            }
        }
        let open = mesh.edges().filter(|&e| mesh.is_boundary_edge(e) && arc_of[e].is_none());
        defects.extend(open.map(TilingDefect::OpenBoundary));
        arc_of
    }

    /// F(body) is a set of 2-simplexes; bodies are connected, disjoint, and cover M.
    fn check_tiles(&self, arc_of: &EdgeMap<Option<ArcId>>, defects: &mut Vec<TilingDefect>) {
        let mesh = self.mesh();
        let tiles = self.complex.cells.len();
        let missing = self.face_tile.iter().filter(|(_, t)| t.index() >= tiles).map(|(f, _)| f);
        defects.extend(missing.map(TilingDefect::NoTile));
        if !defects.is_empty() {
            return;
        }
        for e in mesh.edges().filter(|&e| arc_of[e].is_none()) {
            if let (a, Some(b)) = mesh.edge_faces(e)
                && self.face_tile[a] != self.face_tile[b]
            {
                defects.push(TilingDefect::TilesOverlap(a, b, self.face_tile[a], self.face_tile[b]));
            }
        }
        let mut pieces = TileMap::filled(tiles, 0);
        pieces_of(mesh, |e| arc_of[e].is_none()).1.iter().for_each(|&f| pieces[self.face_tile[f]] += 1);
        for (tile, &pieces) in pieces.iter() {
            match pieces {
                0 => defects.push(TilingDefect::EmptyTile(tile)),
                1 => {}
                _ => defects.push(TilingDefect::TileInPieces { tile, pieces }),
            }
        }
    }

    /// F maps the boundary of each cell onto the border of its faces, and the cell is as its faces are.
    fn check_boundaries(&self, arc_of: &EdgeMap<Option<ArcId>>, defects: &mut Vec<TilingDefect>) {
        let mesh = self.mesh();
        // V − E + F of each tile cut open: a border half-edge stands for one border edge and one border vertex.
        let (mut chi, mut border) =
            (TileMap::filled(self.complex.cells.len(), 0i64), TileMap::filled(self.complex.cells.len(), 0));
        self.face_tile.values().iter().for_each(|&t| chi[t] += 1);
        for e in mesh.edges().filter(|&e| arc_of[e].is_none()) {
            chi[self.face_tile[mesh.edge_faces(e).0]] -= 1;
        }
        for v in mesh.vertices().filter(|&v| mesh.vertex_edges(v).all(|e| arc_of[e].is_none())) {
            chi[self.face_tile[mesh.face(mesh.outgoing_half_edge(v))]] += 1;
        }
        for h in mesh.half_edges().filter(|&h| arc_of[mesh.edge(h)].is_some()) {
            border[self.face_tile[mesh.face(h)]] += 1;
        }
        for (tile, cell) in self.complex.cells.iter() {
            let mut stated = 0;
            for (boundary, cycle) in cell.boundaries.iter().enumerate() {
                let half_edges: Vec<HalfEdgeId> = cycle.iter().flat_map(|&s| self.side_half_edges(s)).collect();
                stated += half_edges.len();
                let n = half_edges.len();
                let follows = |i: usize| next_on_border(mesh, arc_of, half_edges[i]) == half_edges[(i + 1) % n];
                let mut sorted = half_edges.clone();
                sorted.sort_unstable();
                sorted.dedup();
                let around = sorted.len() == n && half_edges.iter().all(|&h| self.face_tile[mesh.face(h)] == tile);
                if !around || !(0..n).all(follows) {
                    defects.push(TilingDefect::Boundary { tile, boundary });
                }
            }
            if stated != border[tile] {
                defects.push(TilingDefect::BoundaryLength { tile, found: border[tile], stated });
            }
            if chi[tile] != cell.chi() {
                defects.push(TilingDefect::Topology { tile, found: chi[tile], stated: cell.chi() });
            }
        }
    }
}

/// The border half-edge of a tile after `h`: around its target, without crossing an arc.
fn next_on_border(mesh: &TriMesh, arc_of: &EdgeMap<Option<ArcId>>, h: HalfEdgeId) -> HalfEdgeId {
    let mut at = mesh.next(h);
    while arc_of[mesh.edge(at)].is_none() {
        match mesh.twin(at) {
            Some(t) => at = mesh.next(t),
            None => return at,
        }
    }
    at
}

/// Edges between consecutive vertices; `None` where there is none.
fn edges_of<'a>(mesh: &'a TriMesh, path: &'a [VertexId]) -> impl Iterator<Item = Option<EdgeId>> + 'a {
    path.windows(2).map(|p| mesh.find_edge(p[0], p[1]))
}

fn root(group: &mut [usize], mut i: usize) -> usize {
    while group[i] != i {
        group[i] = group[group[i]];
        i = group[i];
    }
    i
}

/// The piece of each face, and the first face of each piece, where `open` edges may be crossed.
fn pieces_of(mesh: &TriMesh, open: impl Fn(EdgeId) -> bool) -> (FaceMap<u32>, Vec<FaceId>) {
    let mut piece = FaceMap::filled(mesh.face_count(), u32::MAX);
    let mut firsts = Vec::new();
    for first in mesh.faces() {
        if piece[first] != u32::MAX {
            continue;
        }
        let number = firsts.len() as u32;
        firsts.push(first);
        piece[first] = number;
        let mut stack = vec![first];
        while let Some(f) = stack.pop() {
            for h in mesh.face_half_edges(f) {
                if open(mesh.edge(h))
                    && let Some(t) = mesh.twin(h)
                    && piece[mesh.face(t)] == u32::MAX
                {
                    piece[mesh.face(t)] = number;
                    stack.push(mesh.face(t));
                }
            }
        }
    }
    (piece, firsts)
}

/// Takes away cut edges that end freely, as long as some cut is left.
fn prune(mesh: &TriMesh, cut: &mut EdgeMap<bool>) {
    let is_line = |cut: &EdgeMap<bool>, e: EdgeId| cut[e] || mesh.is_boundary_edge(e);
    let mut left = mesh.edges().filter(|&e| cut[e]).count();
    let mut stack: Vec<VertexId> = mesh.vertices().rev().collect();
    while let Some(v) = stack.pop() {
        let lines: Vec<EdgeId> = mesh.vertex_edges(v).filter(|&e| is_line(cut, e)).collect();
        if let [e] = lines[..]
            && cut[e]
            && left > 1
        {
            cut[e] = false;
            left -= 1;
            stack.extend(mesh.ends(e).into_iter().filter(|&w| w != v));
        }
    }
}

impl<'a> Tracer<'a> {
    fn new(mesh: &'a TriMesh, line: EdgeMap<bool>) -> Self {
        Self {
            arc_of: EdgeMap::filled(mesh.edge_count(), None),
            node_of: VertexMap::filled(mesh.vertex_count(), None),
            node_vertex: Vec::new(),
            paths: Vec::new(),
            mesh,
            line,
        }
    }

    fn add_node(&mut self, v: VertexId) {
        if self.node_of[v].is_none() {
            self.node_of[v] = Some(NodeId::new(self.node_vertex.len()));
            self.node_vertex.push(v);
        }
    }

    /// Nodes, then arcs from each node, then cycles without one.
    fn trace(&mut self, extra: &[VertexId]) {
        let mut wanted = VertexMap::filled(self.mesh.vertex_count(), false);
        extra.iter().for_each(|&v| wanted[v] = true);
        for v in self.mesh.vertices() {
            let lines = self.mesh.vertex_edges(v).filter(|&e| self.line[e]).count();
            if lines != 0 && (lines != 2 || wanted[v]) {
                self.add_node(v);
            }
        }
        for n in 0..self.node_vertex.len() {
            self.trace_from(self.node_vertex[n]);
        }
        for v in self.mesh.vertices() {
            let free = |e: EdgeId| self.line[e] && self.arc_of[e].is_none();
            if self.mesh.vertex_edges(v).any(free) {
                self.add_node(v);
                self.trace_from(v);
            }
        }
    }

    fn trace_from(&mut self, start: VertexId) {
        let edges: Vec<EdgeId> = self.mesh.vertex_edges(start).filter(|&e| self.line[e]).collect();
        for first in edges {
            if self.arc_of[first].is_some() {
                continue;
            }
            let arc = ArcId::new(self.paths.len());
            let (mut path, mut at, mut edge) = (vec![start], start, first);
            loop {
                self.arc_of[edge] = Some(arc);
                let [a, b] = self.mesh.ends(edge);
                at = if a == at { b } else { a };
                path.push(at);
                if self.node_of[at].is_some() {
                    break;
                }
                match self.mesh.vertex_edges(at).find(|&e| self.line[e] && self.arc_of[e].is_none()) {
                    Some(next) => edge = next,
                    None => break,
                }
            }
            self.paths.push(path);
        }
    }

    /// Tiles by their smallest face, each with its topology and boundaries.
    fn tiles(&self) -> (FaceMap<TileId>, TileMap<Cell>) {
        let mesh = self.mesh;
        let (piece, firsts) = pieces_of(mesh, |e| !self.line[e]);
        let tile = |f: FaceId| piece[f] as usize;
        let mut chi = vec![0i64; firsts.len()];
        mesh.faces().for_each(|f| chi[tile(f)] += 1);
        mesh.edges().filter(|&e| !self.line[e]).for_each(|e| chi[tile(mesh.edge_faces(e).0)] -= 1);
        for v in mesh.vertices().filter(|&v| !mesh.vertex_edges(v).any(|e| self.line[e])) {
            chi[tile(mesh.face(mesh.outgoing_half_edge(v)))] += 1;
        }
        let mut boundaries: Vec<Vec<Vec<Side>>> = vec![Vec::new(); firsts.len()];
        let mut seen = HalfEdgeMap::filled(mesh.half_edge_count(), false);
        for h in mesh.half_edges() {
            // A boundary is told from the half-edge that leaves its first node.
            if self.line[mesh.edge(h)] && self.node_of[mesh.origin(h)].is_some() && !seen[h] {
                boundaries[tile(mesh.face(h))].push(self.boundary(h, &mut seen));
            }
        }
        let cells = chi.iter().zip(boundaries).map(|(&chi, boundaries)| {
            let genus = (2 - chi - boundaries.len() as i64) / 2;
            Cell { genus: u32::try_from(genus).unwrap_or(0), boundaries }
        });
        (FaceMap::from_fn(mesh.face_count(), |f| TileId(piece[f])), TileMap::from_vec(cells.collect()))
    }

    fn boundary(&self, start: HalfEdgeId, seen: &mut HalfEdgeMap<bool>) -> Vec<Side> {
        let mesh = self.mesh;
        let mut sides = Vec::new();
        let mut h = start;
        loop {
            seen[h] = true;
            if self.node_of[mesh.origin(h)].is_some()
                && let Some(arc) = self.arc_of[mesh.edge(h)]
            {
                let path = &self.paths[arc.index()];
                sides.push(Side { arc, reversed: path[0] != mesh.origin(h) || path[1] != mesh.target(h) });
            }
            h = next_on_border(mesh, &self.arc_of, h);
            if h == start {
                return sides;
            }
        }
    }
}

/// The surface of a mesh, not refined.
///
/// # Cost       linear
pub fn unrefined(mesh: &TriMesh) -> RefinedSurface {
    let place = VertexMap::from_fn(mesh.vertex_count(), |v| {
        let h = mesh.outgoing_half_edge(v);
        let face = mesh.face(h);
        let mut weights = [0.0; 3];
        weights[(h.0 - mesh.first_half_edge(face).0) as usize] = 1.0;
        SurfacePoint { face, weights }
    });
    RefinedSurface { mesh: mesh.clone(), parent_face: FaceMap::from_fn(mesh.face_count(), |f| f), place }
}

/// One tile from a user's own cut edges ([Favreau2009] Lemma 1).
///
/// # Errors     [`TilingError::NotDisks`] and [`TilingError::SeveralTiles`] if what is left is not one disk per component
pub fn tile_from_cut(mesh: &TriMesh, cut: &EdgeMap<bool>) -> Result<Tiling, TilingError> {
    let tiling = Tiling::from_cut(Arc::new(unrefined(mesh)), cut, &[]);
    tiling.must_be_disks()?;
    let tiles = tiling.complex.cells.len();
    if tiles > topology::components(mesh).count { Err(TilingError::SeveralTiles { tiles }) } else { Ok(tiling) }
}
