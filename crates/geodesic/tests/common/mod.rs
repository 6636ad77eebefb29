//! An independent way to shortest distances: all straight unfoldings, then Dijkstra over vertices.
//!
//! In: connectivity and edge lengths. Out: distances between vertices and from segments. Holds: exact, by a method that
//! shares nothing with the crate: triangles are unfolded into one plane as points, what is seen is a cone between two
//! directions (or a strip between two parallels), a depth-first search follows it through every sequence of edges.
//! Paths may bend at any vertex, which never hurts. Cost: exponential in principle, pruned by a bound on lengths.
#![allow(dead_code, reason = "each test uses a part of it")]

use quadloom_mesh::shapes::random;
use quadloom_mesh::{DVec2, EdgeMap, HalfEdgeId, TriConnectivity, TriMesh, VertexId};

/// A pseudo-random number in 0..1.
pub fn dice(seed: u64, index: u64) -> f64 {
    random(seed, index)
}

pub fn cross(a: DVec2, b: DVec2) -> f64 {
    a.x * b.y - a.y * b.x
}

/// The apex of a triangle over `a` → `b`, on its left, from lengths alone.
fn apex(a: DVec2, b: DVec2, to_a: f64, to_b: f64) -> DVec2 {
    let d = b - a;
    let l = d.length();
    let u = d / l;
    let x = (to_a * to_a - to_b * to_b + l * l) / (2.0 * l);
    let y = (to_a * to_a - x * x).max(0.0).sqrt();
    a + u * x + DVec2::new(-u.y, u.x) * y
}

/// Distances by brute force.
pub struct Oracle<'a> {
    pub mesh: &'a TriConnectivity,
    pub length: &'a EdgeMap<f64>,
    /// No shortest distance is above this.
    pub bound: f64,
}

/// What a search sees: from a point between two directions, or along one direction between two parallels.
#[derive(Clone, Copy)]
enum Beam {
    Cone { source: DVec2, right: DVec2, left: DVec2 },
    Strip { direction: DVec2, right: DVec2, left: DVec2 },
}

impl Beam {
    /// Positive where a point is left of the right ray, and right of the left one.
    fn inside(&self, p: DVec2) -> [f64; 2] {
        match *self {
            Self::Cone { source, right, left } => [cross(right - source, p - source), cross(p - source, left - source)],
            Self::Strip { direction, right, left } => [cross(direction, p - right), cross(p - left, direction)],
        }
    }
    fn distance(&self, p: DVec2) -> f64 {
        match *self {
            Self::Cone { source, .. } => source.distance(p),
            Self::Strip { direction, right, .. } => direction.dot(p - right),
        }
    }
    fn with_right(self, p: DVec2) -> Self {
        match self {
            Self::Cone { source, left, .. } => Self::Cone { source, right: p, left },
            Self::Strip { direction, right, left } => {
                // The same front, from the parallel through p.
                let right = right + (p - right) - direction * direction.dot(p - right);
                Self::Strip { direction, right, left }
            }
        }
    }
    fn with_left(self, p: DVec2) -> Self {
        match self {
            Self::Cone { source, right, .. } => Self::Cone { source, right, left: p },
            Self::Strip { direction, right, .. } => Self::Strip { direction, right, left: p },
        }
    }
    /// Least distance to a segment: a lower bound for all that is seen through it.
    fn least(&self, a: DVec2, b: DVec2) -> f64 {
        match *self {
            Self::Cone { source, .. } => {
                let d = b - a;
                let t = ((source - a).dot(d) / d.length_squared().max(1e-300)).clamp(0.0, 1.0);
                source.distance(a + d * t)
            }
            Self::Strip { .. } => self.distance(a).min(self.distance(b)),
        }
    }
}

/// Rounding that must not hide a vertex.
const EPS: f64 = 1e-9;

impl<'a> Oracle<'a> {
    pub fn new(mesh: &'a TriConnectivity, length: &'a EdgeMap<f64>) -> Self {
        let mut oracle = Self { mesh, length, bound: f64::INFINITY };
        let from_first = oracle.dijkstra(&[(VertexId(0), 0.0)], &|_, _| None);
        // Any two are joined through the first, and by no more than twice that.
        oracle.bound = 2.0 * from_first.iter().copied().filter(|d| d.is_finite()).fold(0.0, f64::max);
        oracle
    }

    fn l(&self, h: HalfEdgeId) -> f64 {
        self.length[self.mesh.edge(h)]
    }

    /// Follows a beam across the edge `a` → `b` of half-edge `h`, whose face lies beyond, on the left of b → a.
    fn follow(&self, h: HalfEdgeId, a: DVec2, b: DVec2, beam: Beam, limit: f64, see: &mut dyn FnMut(VertexId, f64)) {
        let mesh = self.mesh;
        if beam.least(a, b) > limit {
            return;
        }
        let c = apex(a, b, self.l(mesh.prev(h)), self.l(mesh.next(h)));
        let v = mesh.origin(mesh.prev(h));
        let [right, left] = beam.inside(c);
        let scale = EPS * (1.0 + c.length_squared());
        if right >= -scale && left >= -scale {
            see(v, beam.distance(c));
        }
        // b → c is on the right side of the beam, c → a on its left one.
        if right > 0.0
            && let Some(t) = mesh.twin(mesh.next(h))
        {
            let narrowed = if left > 0.0 { beam.with_left(c) } else { beam };
            self.follow(t, c, b, narrowed, limit, see);
        }
        if left > 0.0
            && let Some(t) = mesh.twin(mesh.prev(h))
        {
            let narrowed = if right > 0.0 { beam.with_right(c) } else { beam };
            self.follow(t, a, c, narrowed, limit, see);
        }
    }

    /// Straight distances from a vertex to all that it sees.
    pub fn seen_from_vertex(&self, v: VertexId, limit: f64) -> Vec<(VertexId, f64)> {
        let mesh = self.mesh;
        let mut found: Vec<(VertexId, f64)> = Vec::new();
        for h in mesh.outgoing(v) {
            found.push((mesh.target(h), self.l(h)));
            found.push((mesh.origin(mesh.prev(h)), self.l(mesh.prev(h))));
            let (s, p) = (DVec2::ZERO, DVec2::new(self.l(h), 0.0));
            let q = apex(s, p, self.l(mesh.prev(h)), self.l(mesh.next(h)));
            if let Some(t) = mesh.twin(mesh.next(h)) {
                // Seen from v, p is on the right and q on the left; the face beyond has its side q → p.
                let beam = Beam::Cone { source: s, right: p, left: q };
                self.follow(t, q, p, beam, limit, &mut |v, d| found.push((v, d)));
            }
        }
        found
    }

    /// Straight distances from a point of a face's layout (corner 0 at the origin, corner 1 on the x axis).
    pub fn seen_from_face(&self, sides: [HalfEdgeId; 3], at: DVec2, limit: f64) -> Vec<(VertexId, f64)> {
        let corners = self.layout(sides);
        let mut found: Vec<(VertexId, f64)> = Vec::new();
        for k in 0..3 {
            let (p, q) = (corners[k], corners[(k + 1) % 3]);
            found.push((self.mesh.origin(sides[k]), at.distance(p)));
            if cross(q - p, at - p) <= 0.0 {
                continue;
            }
            if let Some(t) = self.mesh.twin(sides[k]) {
                let beam = Beam::Cone { source: at, right: p, left: q };
                self.follow(t, q, p, beam, limit, &mut |v, d| found.push((v, d)));
            }
        }
        found
    }

    /// Distances from a segment's two fronts.
    pub fn seen_from_segment(&self, sides: [HalfEdgeId; 3], p: DVec2, q: DVec2, limit: f64) -> Vec<(VertexId, f64)> {
        let corners = self.layout(sides);
        let mut found: Vec<(VertexId, f64)> = Vec::new();
        for (from, to) in [(p, q), (q, p)] {
            let along = (to - from).normalize();
            // To the right of from → to.
            let direction = DVec2::new(along.y, -along.x);
            let beam = Beam::Strip { direction, right: from, left: to };
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let [right, left] = beam.inside(a);
                if right >= -EPS && left >= -EPS && beam.distance(a) >= -EPS {
                    found.push((self.mesh.origin(sides[k]), beam.distance(a).max(0.0)));
                }
                // The front leaves through this side where that is in front of the segment.
                if cross(b - a, direction) >= 0.0 {
                    continue;
                }
                if let Some(t) = self.mesh.twin(sides[k]) {
                    let mut narrowed = beam;
                    let ([ar, _], [_, bl]) = (beam.inside(a), beam.inside(b));
                    if ar > 0.0 {
                        narrowed = narrowed.with_right(a);
                    }
                    if bl > 0.0 {
                        narrowed = narrowed.with_left(b);
                    }
                    let [_, still] = narrowed.inside(match narrowed {
                        Beam::Strip { right, .. } | Beam::Cone { right, .. } => right,
                    });
                    if still > 0.0 {
                        self.follow(t, b, a, narrowed, limit, &mut |v, d| found.push((v, d)));
                    }
                }
            }
        }
        found
    }

    pub fn layout(&self, sides: [HalfEdgeId; 3]) -> [DVec2; 3] {
        let (a, b) = (DVec2::ZERO, DVec2::new(self.l(sides[0]), 0.0));
        [a, b, apex(a, b, self.l(sides[2]), self.l(sides[1]))]
    }

    /// Dijkstra over vertices from seeds, with straight distances between them (edges alone if `straight` is `None`).
    fn dijkstra(
        &self,
        seeds: &[(VertexId, f64)],
        straight: &dyn Fn(VertexId, f64) -> Option<Vec<(VertexId, f64)>>,
    ) -> Vec<f64> {
        let n = self.mesh.vertex_count();
        let (mut distance, mut done) = (vec![f64::INFINITY; n], vec![false; n]);
        for &(v, d) in seeds {
            distance[v.index()] = distance[v.index()].min(d);
        }
        loop {
            let next = (0..n).filter(|&v| !done[v] && distance[v].is_finite());
            let Some(v) = next.min_by(|&a, &b| distance[a].total_cmp(&distance[b])) else { return distance };
            done[v] = true;
            let v = VertexId::new(v);
            let edges = || {
                self.mesh
                    .vertex_edges(v)
                    .map(|e| {
                        let [a, b] = self.mesh.ends(e);
                        (if a == v { b } else { a }, self.length[e])
                    })
                    .collect()
            };
            for (u, d) in straight(v, self.bound).unwrap_or_else(edges) {
                let through = distance[v.index()] + d;
                if through < distance[u.index()] {
                    distance[u.index()] = through;
                }
            }
        }
    }

    /// Distances of all vertices from seeds: straight pieces between vertices.
    pub fn distances(&self, seeds: &[(VertexId, f64)]) -> Vec<f64> {
        self.dijkstra(seeds, &|v, limit| Some(self.seen_from_vertex(v, limit)))
    }
}

/// Removes faces so that the rest stays a manifold with one fan per vertex.
pub fn with_holes(mesh: &TriMesh, keep: impl Fn(u32) -> bool) -> Option<TriMesh> {
    let mut number = vec![u32::MAX; mesh.vertex_count()];
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for (f, face) in mesh.to_faces().iter().enumerate().filter(|(f, _)| keep(*f as u32)) {
        let _ = f;
        faces.push(face.map(|v| {
            if number[v as usize] == u32::MAX {
                number[v as usize] = positions.len() as u32;
                positions.push(mesh.positions().values()[v as usize]);
            }
            number[v as usize]
        }));
    }
    TriMesh::new(positions, &faces).ok()
}
