//! A surface that is being cut open and refined.
//!
//! In: a triangle mesh. Out: the mesh refined and cut ([`finish`]). Holds at any time:
//! - faces are convex pieces of the mesh's triangles, met along straight sides; the surface is the same point set;
//! - a *point* is a vertex of the refined mesh M, a *vertex* one of the cell C: points on cuts have several vertices
//!   (F(vertex) = point, [Favreau2009] Def. 3); sides of a cut know their `mate` on the other side;
//! - cuts are simple and share neither an edge nor an inner point ([Favreau2009] §4.2);
//! - what a search pays along an edge is what it would have paid on the mesh, however finely the edge's surroundings
//!   were split: every point has a `base`, the mesh's vertex that it stands for; edges between points of one base are
//!   free, others cost what the edge between their bases costs. So distances in C are those of the mesh cut open.
//!
//! Where points lie on an edge is decided at the end, evenly spaced in their order; until then only the order counts.
//!
//! ```text
//!   half-edges of a face run counter-clockwise; the edges of a border vertex, counter-clockwise:
//!
//!          e2  e1
//!            \ |          e0 = out[v], the border half-edge that leaves v
//!       e3 ── v ── e0     e3 is the border half-edge that arrives at v
//!    ═════════════════    (no surface below)
//! ```

mod cut;
mod edit;
mod finish;
mod push;

use quadloom_mesh::TriMesh;

/// No half-edge, line or vertex.
pub(crate) const NONE: u32 = u32::MAX;

/// A mesh cut open and refined so far; see the module.
#[derive(Clone)]
pub(crate) struct CutSurface<'a> {
    pub mesh: &'a TriMesh,
    // By half-edge.
    pub next: Vec<u32>,
    pub prev: Vec<u32>,
    /// Across an uncut edge.
    pub twin: Vec<u32>,
    /// Across a cut.
    pub mate: Vec<u32>,
    /// Vertex of C.
    pub origin: Vec<u32>,
    pub face: Vec<u32>,
    /// Straight line on which it lies: an edge of the mesh, or a chord.
    line: Vec<u32>,
    /// Whether it runs as its line does.
    forward: Vec<bool>,
    /// The mesh's edge whose cost it has; `NONE` if it is free.
    pub span: Vec<u32>,
    // By face.
    pub parent: Vec<u32>,
    pub side: Vec<u32>,
    // By vertex of C.
    /// An outgoing half-edge; on the border the clockwise-most.
    pub out: Vec<u32>,
    pub point: Vec<u32>,
    /// Vertex of C at the last call of [`Self::settle`] from which it was split off.
    pub home: Vec<u32>,
    // By point.
    /// Vertex of the mesh for which it stands.
    pub base: Vec<u32>,
    place: Vec<Place>,
    /// Next point on its line, towards the line's end.
    after: Vec<u32>,
    // By line.
    ends: Vec<[u32; 2]>,
    first: Vec<u32>,
    /// By edge of the mesh: the half-edge between the points of its two ends, in the edge's direction.
    middle: Vec<u32>,
    /// Chords, in the order in which they were drawn: face of the mesh of each.
    chord_face: Vec<u32>,
    /// Centres of faces: corners at the time, and number of lines then.
    centres: Vec<(Vec<u32>, usize)>,
}

/// What fixes a point.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// A vertex of the mesh.
    Vertex,
    /// On a line.
    Line(u32),
    /// The centre of a face, by number.
    Centre(u32),
}

/// A walk along edges of C: `edges[i]` joins `vertices[i]` and `vertices[i + 1]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Walk {
    pub vertices: Vec<u32>,
    /// A half-edge of each edge, in either direction.
    pub edges: Vec<u32>,
}

impl Walk {
    pub fn reversed(mut self) -> Self {
        self.vertices.reverse();
        self.edges.reverse();
        self
    }
    /// Goes on by an edge.
    pub fn push(&mut self, edge: u32, vertex: u32) {
        self.edges.push(edge);
        self.vertices.push(vertex);
    }
    pub fn start(vertex: u32) -> Self {
        Self { vertices: vec![vertex], edges: Vec::new() }
    }
    pub fn last(&self) -> u32 {
        self.vertices[self.vertices.len() - 1]
    }
}

/// Something that cannot happen in a consistent surface; kept as an error so that no user meets a panic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lost(pub &'static str);

impl<'a> CutSurface<'a> {
    /// The mesh, uncut.
    pub fn new(mesh: &'a TriMesh) -> Self {
        let half_edges = mesh.half_edge_count() as u32;
        let to_u32 = |id: Option<quadloom_mesh::HalfEdgeId>| id.map_or(NONE, |h| h.0);
        let edge_of: Vec<u32> = mesh.half_edges().map(|h| mesh.edge(h).0).collect();
        Self {
            mesh,
            next: mesh.half_edges().map(|h| mesh.next(h).0).collect(),
            prev: mesh.half_edges().map(|h| mesh.prev(h).0).collect(),
            twin: mesh.half_edges().map(|h| to_u32(mesh.twin(h))).collect(),
            mate: vec![NONE; half_edges as usize],
            origin: mesh.half_edges().map(|h| mesh.origin(h).0).collect(),
            face: mesh.half_edges().map(|h| mesh.face(h).0).collect(),
            forward: mesh.half_edges().map(|h| mesh.half_edge(mesh.edge(h)) == h).collect(),
            span: edge_of.clone(),
            line: edge_of,
            parent: (0..mesh.face_count() as u32).collect(),
            side: mesh.faces().map(|f| mesh.first_half_edge(f).0).collect(),
            out: mesh.vertices().map(|v| mesh.outgoing_half_edge(v).0).collect(),
            point: (0..mesh.vertex_count() as u32).collect(),
            home: (0..mesh.vertex_count() as u32).collect(),
            base: (0..mesh.vertex_count() as u32).collect(),
            place: vec![Place::Vertex; mesh.vertex_count()],
            after: vec![NONE; mesh.vertex_count()],
            ends: mesh.edges().map(|e| mesh.ends(e).map(|v| v.0)).collect(),
            first: vec![NONE; mesh.edge_count()],
            middle: mesh.edges().map(|e| mesh.half_edge(e).0).collect(),
            chord_face: Vec::new(),
            centres: Vec::new(),
        }
    }

    #[inline]
    pub fn target(&self, h: u32) -> u32 {
        self.origin[self.next[h as usize] as usize]
    }

    /// Number of vertices of C.
    pub fn vertex_count(&self) -> usize {
        self.out.len()
    }

    /// Vertex of the mesh for which a vertex of C stands.
    #[inline]
    pub fn base_of(&self, v: u32) -> u32 {
        self.base[self.point[v as usize] as usize]
    }

    /// Whether a vertex lies on the border of C.
    #[inline]
    pub fn on_border(&self, v: u32) -> bool {
        self.twin[self.out[v as usize] as usize] == NONE
    }

    /// Whether an edge lies on the border of C.
    pub fn is_border(&self, h: u32) -> bool {
        self.twin[h as usize] == NONE
    }

    /// The half-edge of an edge that leaves `v`; `None` if the edge lies on the border and only arrives there.
    pub fn leaving(&self, h: u32, v: u32) -> Option<u32> {
        if self.origin[h as usize] == v { Some(h) } else { Some(self.twin[h as usize]).filter(|&t| t != NONE) }
    }

    /// Calls `f` with a half-edge and the other end of each edge at `v`, counter-clockwise.
    #[inline]
    pub fn for_edges(&self, v: u32, mut f: impl FnMut(u32, u32)) {
        let start = self.out[v as usize];
        let mut h = start;
        loop {
            f(h, self.target(h));
            let arriving = self.prev[h as usize];
            h = self.twin[arriving as usize];
            if h == NONE {
                return f(arriving, self.origin[arriving as usize]);
            }
            if h == start {
                return;
            }
        }
    }

    /// The half-edges that leave `v`, counter-clockwise.
    pub fn fan(&self, v: u32) -> Vec<u32> {
        let start = self.out[v as usize];
        let mut fan = vec![start];
        loop {
            let h = self.twin[self.prev[fan[fan.len() - 1] as usize] as usize];
            if h == NONE || h == start {
                return fan;
            }
            fan.push(h);
        }
    }

    /// The border half-edge after `h`.
    pub fn next_border(&self, h: u32) -> u32 {
        self.out[self.target(h) as usize]
    }

    /// The borders of C, each from its smallest half-edge.
    pub fn borders(&self) -> Vec<Vec<u32>> {
        let mut seen = vec![false; self.next.len()];
        let mut borders = Vec::new();
        for h in 0..self.next.len() as u32 {
            if self.twin[h as usize] != NONE || seen[h as usize] {
                continue;
            }
            let mut border = vec![h];
            seen[h as usize] = true;
            let mut at = self.next_border(h);
            while at != h {
                seen[at as usize] = true;
                border.push(at);
                at = self.next_border(at);
            }
            borders.push(border);
        }
        borders
    }

    /// Makes every vertex its own home.
    pub fn settle(&mut self) {
        self.home = (0..self.vertex_count() as u32).collect();
    }

    /// The piece of an edge of the mesh that joins the points of its two ends, in the edge's direction.
    pub fn middle(&self, edge: u32) -> u32 {
        self.middle[edge as usize]
    }

    /// The edge of the mesh in a face that joins two of its vertices; `NONE` where they are one.
    fn span_between(&self, parent: u32, a: u32, b: u32) -> u32 {
        if a == b {
            return NONE;
        }
        let sides = self.mesh.face_half_edges(quadloom_mesh::FaceId(parent));
        let joins = |h: &&quadloom_mesh::HalfEdgeId| {
            let (from, to) = (self.mesh.origin(**h).0, self.mesh.target(**h).0);
            (from, to) == (a, b) || (from, to) == (b, a)
        };
        sides.iter().find(joins).map_or(NONE, |&h| self.mesh.edge(h).0)
    }

    /// Points of a closed or open walk's vertices.
    pub fn points(&self, vertices: &[u32]) -> Vec<u32> {
        vertices.iter().map(|&v| self.point[v as usize]).collect()
    }
}
