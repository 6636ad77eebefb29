//! Topology of a mesh: components, boundary loops, Euler characteristic, genus, dual forests, cut graphs.
//!
//! In: connectivity, and weights per edge where paths are sought; never a position.
//! Out: maps and edge sets. Holds: results depend on ids only through ties; every cost is near-linear.
//! Source: [Bommes2012] §8.2 (dual Dijkstra forest), §8.4 (cutting the mesh into a disk through the
//! singularities); tree-cotree decomposition [Eppstein2003], shortest systems of loops [Erickson2005].

use crate::connectivity::{Connectivity, FaceShape, TriConnectivity};
use crate::heap::MinHeap;
use crate::ids::{EdgeId, EdgeMap, FaceId, FaceMap, HalfEdgeId, VertexId, VertexMap};
use crate::union_find::UnionFind;
use serde::{Deserialize, Serialize};

/// The connected components of a mesh, by face.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Components {
    /// Component of each face; numbers follow the smallest face id.
    pub of_face: FaceMap<u32>,
    /// Number of components.
    pub count: usize,
}

/// Counts that describe a mesh's topology.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Summary {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of faces.
    pub faces: usize,
    /// Number of connected components.
    pub components: usize,
    /// Number of boundary loops.
    pub boundary_loops: usize,
    /// Euler characteristic V − E + F.
    pub chi: i64,
    /// Sum of the components' genera.
    pub genus: i64,
}

/// A forest of the dual graph: shortest paths from every face to the nearest root face.
#[derive(Clone, Debug, PartialEq)]
pub struct DualForest {
    /// The half-edge of each face across which its parent lies; `None` for roots and unreached faces.
    pub parent: FaceMap<Option<HalfEdgeId>>,
    /// The root of each face's tree; `None` for unreached faces.
    pub root: FaceMap<Option<FaceId>>,
    /// Length of the path to the root; infinite for unreached faces.
    pub distance: FaceMap<f64>,
    /// Reached faces by increasing distance: parents come before their children.
    pub order: Vec<FaceId>,
}

/// The connected components, by face.
///
/// # Cost       linear
pub fn components<S: FaceShape>(mesh: &Connectivity<S>) -> Components {
    const NONE: u32 = u32::MAX;
    let mut of_face = FaceMap::filled(mesh.face_count(), NONE);
    let (mut count, mut open) = (0, Vec::new());
    for seed in mesh.faces() {
        if of_face[seed] != NONE {
            continue;
        }
        of_face[seed] = count;
        open.push(seed);
        while let Some(f) = open.pop() {
            for g in mesh.sides(f).filter_map(|h| mesh.twin(h)).map(|t| mesh.face(t)) {
                if of_face[g] == NONE {
                    of_face[g] = count;
                    open.push(g);
                }
            }
        }
        count += 1;
    }
    Components { of_face, count: count as usize }
}

impl Components {
    /// Component of a vertex: that of its faces.
    pub fn of_vertex<S: FaceShape>(&self, mesh: &Connectivity<S>, v: VertexId) -> u32 {
        self.of_face[mesh.face(mesh.outgoing_half_edge(v))]
    }
}

/// The boundary half-edges, loop after loop, each in the direction of its faces (the surface lies to the left).
///
/// # Output     loops by their smallest half-edge, from which each starts
/// # Cost       linear
pub fn boundary_loops<S: FaceShape>(mesh: &Connectivity<S>) -> Vec<Vec<HalfEdgeId>> {
    let mut seen = vec![false; mesh.half_edge_count()];
    let mut loops = Vec::new();
    for start in mesh.half_edges() {
        if seen[start.index()] || mesh.twin(start).is_some() {
            continue;
        }
        let (mut boundary, mut h) = (Vec::new(), start);
        while !seen[h.index()] {
            seen[h.index()] = true;
            boundary.push(h);
            // The outgoing half-edge of a boundary vertex is its only one without a twin.
            h = mesh.outgoing_half_edge(mesh.target(h));
        }
        loops.push(boundary);
    }
    loops
}

/// Euler characteristic V − E + F.
pub fn euler_characteristic<S: FaceShape>(mesh: &Connectivity<S>) -> i64 {
    mesh.vertex_count() as i64 - mesh.edge_count() as i64 + mesh.face_count() as i64
}

/// Topology of each component, in the order of [`components`].
///
/// # Cost       linear
pub fn component_summaries<S: FaceShape>(mesh: &Connectivity<S>) -> Vec<Summary> {
    let parts = components(mesh);
    let empty = Summary { vertices: 0, edges: 0, faces: 0, components: 1, boundary_loops: 0, chi: 0, genus: 0 };
    let mut summaries = vec![empty; parts.count];
    let part = |h: HalfEdgeId| parts.of_face[mesh.face(h)] as usize;
    for v in mesh.vertices() {
        summaries[part(mesh.outgoing_half_edge(v))].vertices += 1;
    }
    for e in mesh.edges() {
        summaries[part(mesh.half_edge(e))].edges += 1;
    }
    for f in mesh.faces() {
        summaries[parts.of_face[f] as usize].faces += 1;
    }
    for boundary in boundary_loops(mesh) {
        summaries[part(boundary[0])].boundary_loops += 1;
    }
    for s in &mut summaries {
        s.chi = s.vertices as i64 - s.edges as i64 + s.faces as i64;
        // chi = 2 − 2·genus − boundary loops for an orientable connected surface.
        s.genus = (2 - s.boundary_loops as i64 - s.chi) / 2;
    }
    summaries
}

impl Summary {
    /// Topology of a whole mesh.
    ///
    /// # Cost       linear
    pub fn of<S: FaceShape>(mesh: &Connectivity<S>) -> Self {
        let parts = component_summaries(mesh);
        Self {
            vertices: mesh.vertex_count(),
            edges: mesh.edge_count(),
            faces: mesh.face_count(),
            components: parts.len(),
            boundary_loops: parts.iter().map(|s| s.boundary_loops).sum(),
            chi: euler_characteristic(mesh),
            genus: parts.iter().map(|s| s.genus).sum(),
        }
    }

    /// Whether two meshes have the same components, boundary loops, Euler characteristic and genus.
    pub fn same_topology(&self, other: &Self) -> bool {
        let key = |s: &Self| (s.components, s.boundary_loops, s.chi, s.genus);
        key(self) == key(other)
    }
}

/// Shortest paths in the dual graph from every face to its nearest root.
///
/// # Input      length: cost of crossing each edge, ≥ 0; an infinite one is never crossed.
/// roots: sources of the search; a face named twice counts once
/// # Output     one tree per root ([Bommes2012] §8.2: no tree joins two roots)
/// # Cost       O(F log F)
/// # Guarantees ties go to the smaller face id
pub fn dual_forest<S: FaceShape>(mesh: &Connectivity<S>, length: &EdgeMap<f64>, roots: &[FaceId]) -> DualForest {
    let faces = mesh.face_count();
    let mut forest = DualForest {
        parent: FaceMap::filled(faces, None),
        root: FaceMap::filled(faces, None),
        distance: FaceMap::filled(faces, f64::INFINITY),
        order: Vec::with_capacity(faces),
    };
    let mut heap = MinHeap::default();
    for &f in roots {
        forest.distance[f] = 0.0;
        forest.root[f] = Some(f);
        heap.push(0.0, f.0);
    }
    let mut settled = FaceMap::filled(faces, false);
    while let Some((distance, f)) = heap.pop() {
        let f = FaceId(f);
        if std::mem::replace(&mut settled[f], true) {
            continue;
        }
        forest.order.push(f);
        for t in mesh.sides(f).filter_map(|h| mesh.twin(h)) {
            let (g, next) = (mesh.face(t), distance + length[mesh.edge(t)]);
            if next < forest.distance[g] {
                forest.distance[g] = next;
                forest.parent[g] = Some(t);
                forest.root[g] = forest.root[f];
                heap.push(next, g.0);
            }
        }
    }
    forest
}

/// Edges that open every component into a disk whose boundary contains all singular vertices.
///
/// 1. A primal shortest-path forest grows from the boundary, or from one vertex of a closed component.
/// 2. A dual spanning tree avoids it and prefers edges far from the roots; the edges that neither
///    uses close the shortest loops ([Erickson2005]); with the paths from their ends they cut a disk open.
/// 3. Dangling paths that end in an ordinary vertex are removed.
/// 4. Each singular vertex is joined by a shortest path, nearest first ([Bommes2012] §8.4).
///
/// # Input      cost: of cutting along each edge, ≥ 0 and finite; singular: vertices in any order
/// # Output     true for cut edges; boundary edges count as cut already and are false
/// # Cost       O(E log E)
/// # Guarantees cutting leaves one disk per component; exception: a closed component of genus 0 with at
/// most one singular vertex needs no cut and stays a sphere
pub fn cut_graph(mesh: &TriConnectivity, cost: &EdgeMap<f64>, singular: &[VertexId]) -> EdgeMap<bool> {
    let mut is_singular = VertexMap::filled(mesh.vertex_count(), false);
    for &v in singular {
        is_singular[v] = true;
    }
    let roots = cut_roots(mesh, singular);
    // 1. Primal forest.
    let mut paths = ShortestPaths::new(mesh, cost);
    paths.grow(&roots);
    // 2. Dual tree; loops through the edges left over.
    let mut cut = EdgeMap::filled(mesh.edge_count(), false);
    for e in edges_outside_tree_and_cotree(&paths) {
        cut[e] = true;
        for v in mesh.ends(e) {
            paths.trace(v, &mut cut, &mut Vec::new());
        }
    }
    // 3. Dangling paths.
    prune(mesh, &mut cut, &is_singular);
    // 4. Singular vertices.
    join_singular(mesh, cost, &roots, &is_singular, &mut cut);
    cut
}

/// Boundary vertices; in a closed component its first singular vertex, or else its first vertex.
fn cut_roots(mesh: &TriConnectivity, singular: &[VertexId]) -> Vec<VertexId> {
    let parts = components(mesh);
    let mut roots: Vec<VertexId> = mesh.vertices().filter(|&v| mesh.is_boundary_vertex(v)).collect();
    let mut rooted = vec![false; parts.count];
    for &v in &roots {
        rooted[parts.of_vertex(mesh, v) as usize] = true;
    }
    let mut sorted = singular.to_vec();
    sorted.sort_unstable();
    for v in sorted.into_iter().chain(mesh.vertices()) {
        if !std::mem::replace(&mut rooted[parts.of_vertex(mesh, v) as usize], true) {
            roots.push(v);
        }
    }
    roots
}

/// A Dijkstra search over vertices whose sources may be added while it runs.
struct ShortestPaths<'a> {
    mesh: &'a TriConnectivity,
    cost: &'a EdgeMap<f64>,
    distance: VertexMap<f64>,
    /// Half-edge or its twin over which the path to the nearest source begins; `None` for sources.
    parent: VertexMap<Option<EdgeId>>,
    heap: MinHeap,
}

impl<'a> ShortestPaths<'a> {
    fn new(mesh: &'a TriConnectivity, cost: &'a EdgeMap<f64>) -> Self {
        let vertices = mesh.vertex_count();
        Self {
            mesh,
            cost,
            distance: VertexMap::filled(vertices, f64::INFINITY),
            parent: VertexMap::filled(vertices, None),
            heap: MinHeap::default(),
        }
    }

    fn add_source(&mut self, v: VertexId) {
        self.distance[v] = 0.0;
        self.parent[v] = None;
        self.heap.push(0.0, v.0);
    }

    fn grow(&mut self, sources: &[VertexId]) {
        for &v in sources {
            self.add_source(v);
        }
        while self.next().is_some() {}
    }

    /// Settles the next vertex; a vertex settles again when a later source comes nearer.
    fn next(&mut self) -> Option<VertexId> {
        loop {
            let (distance, v) = self.heap.pop()?;
            let v = VertexId(v);
            if distance > self.distance[v] {
                continue;
            }
            for e in self.mesh.vertex_edges(v) {
                let [a, b] = self.mesh.ends(e);
                let (w, next) = (if a == v { b } else { a }, distance + self.cost[e]);
                if next < self.distance[w] {
                    self.distance[w] = next;
                    self.parent[w] = Some(e);
                    self.heap.push(next, w.0);
                }
            }
            return Some(v);
        }
    }

    /// Marks the path from `v` to its source, as far as it is not marked, and lists its vertices.
    fn trace(&self, mut v: VertexId, cut: &mut EdgeMap<bool>, path: &mut Vec<VertexId>) {
        path.push(v);
        while let Some(e) = self.parent[v].filter(|&e| !cut[e]) {
            cut[e] = true;
            let [a, b] = self.mesh.ends(e);
            v = if a == v { b } else { a };
            path.push(v);
        }
    }
}

/// Interior edges neither in the primal forest nor crossed by a maximal dual spanning tree that avoids it.
fn edges_outside_tree_and_cotree(paths: &ShortestPaths<'_>) -> Vec<EdgeId> {
    let mesh = paths.mesh;
    let mut in_tree = EdgeMap::filled(mesh.edge_count(), false);
    for &e in paths.parent.values().iter().flatten() {
        in_tree[e] = true;
    }
    // Length of the loop that an edge would close through the roots.
    let mut loops: Vec<(f64, EdgeId)> = mesh
        .edges()
        .filter(|&e| !in_tree[e] && !mesh.is_boundary_edge(e))
        .map(|e| (mesh.ends(e).iter().map(|&v| paths.distance[v]).sum::<f64>() + paths.cost[e], e))
        .collect();
    loops.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut tree = UnionFind::new(mesh.face_count());
    let mut outside: Vec<EdgeId> = loops
        .into_iter()
        .filter_map(|(_, e)| {
            let (f, g) = mesh.edge_faces(e);
            (!tree.join(f.index(), g.unwrap_or(f).index())).then_some(e)
        })
        .collect();
    outside.sort_unstable();
    outside
}

/// Removes cut edges that end in an ordinary interior vertex, again and again.
fn prune(mesh: &TriConnectivity, cut: &mut EdgeMap<bool>, keep: &VertexMap<bool>) {
    let mut degree = VertexMap::filled(mesh.vertex_count(), 0u32);
    for e in mesh.edges().filter(|&e| cut[e]) {
        for v in mesh.ends(e) {
            degree[v] += 1;
        }
    }
    for start in mesh.vertices() {
        let mut v = start;
        while degree[v] == 1 && !keep[v] && !mesh.is_boundary_vertex(v) {
            let Some(e) = mesh.vertex_edges(v).find(|&e| cut[e]) else { break };
            cut[e] = false;
            let [a, b] = mesh.ends(e);
            degree[a] -= 1;
            degree[b] -= 1;
            v = if a == v { b } else { a };
        }
    }
}

fn join_singular(
    mesh: &TriConnectivity,
    cost: &EdgeMap<f64>,
    roots: &[VertexId],
    is_singular: &VertexMap<bool>,
    cut: &mut EdgeMap<bool>,
) {
    let mut joined = VertexMap::filled(mesh.vertex_count(), false);
    for e in mesh.edges().filter(|&e| cut[e] || mesh.is_boundary_edge(e)) {
        for v in mesh.ends(e) {
            joined[v] = true;
        }
    }
    // A closed sphere has no cut yet: its root, a singular vertex if there is one, starts it.
    let parts = components(mesh);
    let mut has_cut = vec![false; parts.count];
    for v in mesh.vertices().filter(|&v| joined[v]) {
        has_cut[parts.of_vertex(mesh, v) as usize] = true;
    }
    for &v in roots {
        joined[v] |= !has_cut[parts.of_vertex(mesh, v) as usize];
    }
    let mut search = ShortestPaths::new(mesh, cost);
    for v in mesh.vertices().filter(|&v| joined[v]) {
        search.add_source(v);
    }
    let mut path = Vec::new();
    while let Some(v) = search.next() {
        if !is_singular[v] || joined[v] {
            continue;
        }
        path.clear();
        search.trace(v, cut, &mut path);
        for &w in &path {
            joined[w] = true;
            search.add_source(w);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;
    use crate::shapes;
    use proptest::prelude::*;

    /// Topology after cutting, by gluing face corners across uncut edges only.
    fn cut_open(mesh: &TriMesh, cut: &EdgeMap<bool>) -> Summary {
        let mut corners = UnionFind::new(mesh.half_edge_count());
        for h in mesh.half_edges().filter(|&h| !cut[mesh.edge(h)]) {
            if let Some(t) = mesh.twin(h) {
                corners.join(h.index(), mesh.next(t).index());
                corners.join(mesh.next(h).index(), t.index());
            }
        }
        let mut id = vec![u32::MAX; mesh.half_edge_count()];
        let mut vertices = 0;
        let mut vertex = |h: HalfEdgeId| {
            let r = corners.root(h.index());
            if id[r] == u32::MAX {
                id[r] = vertices;
                vertices += 1;
            }
            id[r]
        };
        let faces: Vec<[u32; 3]> = mesh.faces().map(|f| mesh.face_half_edges(f).map(&mut vertex)).collect();
        Summary::of(&TriConnectivity::from_faces(vertices as usize, &faces).expect("cutting keeps a manifold"))
    }

    fn check_cut(mesh: &TriMesh, cost: &EdgeMap<f64>, singular: &[VertexId]) {
        let cut = cut_graph(mesh, cost, singular);
        let opened = cut_open(mesh, &cut);
        let whole = Summary::of(mesh.connectivity());
        assert_eq!((opened.components, opened.genus), (whole.components, 0));
        // Every component is a disk, or a sphere without a cut.
        let spheres = opened.components - opened.boundary_loops;
        assert_eq!(opened.chi, (opened.components + spheres) as i64);
        for e in mesh.edges() {
            assert!(!cut[e] || !mesh.is_boundary_edge(e));
        }
        let (parts, summaries) = (components(mesh.connectivity()), component_summaries(mesh.connectivity()));
        // Singular vertices lie on the cut; ordinary ones do not end it.
        let degree = |v: VertexId| mesh.vertex_edges(v).filter(|&e| cut[e]).count();
        for v in mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v)) {
            if singular.contains(&v) {
                let part = parts.of_vertex(mesh, v);
                let others = singular.iter().any(|&w| w != v && parts.of_vertex(mesh, w) == part);
                let s = summaries[part as usize];
                assert!(degree(v) > 0 || (!others && s.genus == 0 && s.boundary_loops == 0), "{v} is not reached");
            } else {
                assert_ne!(degree(v), 1, "the cut dangles at {v}");
            }
        }
    }

    fn test_shapes() -> Vec<TriMesh> {
        let mut list = vec![
            shapes::sphere(1.0, 2),
            shapes::torus(1.0, 0.4, 12, 9),
            shapes::smooth_genus(3, 1),
            shapes::cylinder(1.0, 2.0, 8, 5),
            shapes::plate_with_holes(0.5),
            shapes::bracket(0.7),
        ];
        list.push(shapes::join(&list));
        list
    }

    #[test]
    fn summaries_add_up() {
        let shapes = test_shapes();
        let s = Summary::of(shapes[6].connectivity());
        assert_eq!((s.components, s.boundary_loops, s.genus), (6, 2 + 6, 1 + 3 + 3));
        assert_eq!(s.chi, 2 * 6 - 2 * s.genus - s.boundary_loops as i64);
        let parts = component_summaries(shapes[6].connectivity());
        for (part, shape) in parts.iter().zip(&shapes) {
            assert_eq!(*part, Summary::of(shape.connectivity()));
        }
    }

    #[test]
    fn boundary_loops_are_closed_and_complete() {
        for mesh in test_shapes() {
            let loops = boundary_loops(mesh.connectivity());
            for boundary in &loops {
                for (i, &h) in boundary.iter().enumerate() {
                    assert_eq!(mesh.target(h), mesh.origin(boundary[(i + 1) % boundary.len()]));
                }
            }
            let count = mesh.edges().filter(|&e| mesh.is_boundary_edge(e)).count();
            assert_eq!(loops.iter().map(Vec::len).sum::<usize>(), count);
        }
    }

    #[test]
    fn dual_forests_are_shortest_paths() {
        for mesh in test_shapes() {
            let length = EdgeMap::from_fn(mesh.edge_count(), |e: EdgeId| 0.5 + shapes::random(3, e.index() as u64));
            let roots = [FaceId(0), FaceId::new(mesh.face_count() - 1)];
            let forest = dual_forest(mesh.connectivity(), &length, &roots);
            // Bellman-Ford: no edge shortens a path, and every path has the length of its steps.
            for f in mesh.faces() {
                for h in mesh.sides(f) {
                    if let Some(t) = mesh.twin(h) {
                        assert!(forest.distance[mesh.face(t)] <= forest.distance[f] + length[mesh.edge(h)]);
                    }
                }
                if let Some(h) = forest.parent[f] {
                    let parent = mesh.face(mesh.twin(h).unwrap());
                    assert_eq!(mesh.face(h), f);
                    assert_eq!(forest.distance[f], forest.distance[parent] + length[mesh.edge(h)]);
                    assert_eq!(forest.root[f], forest.root[parent]);
                } else {
                    assert_eq!(forest.root[f].is_some(), roots.contains(&f));
                }
            }
            let mut seen = FaceMap::filled(mesh.face_count(), false);
            for &f in &forest.order {
                assert!(forest.parent[f].is_none_or(|h| seen[mesh.face(mesh.twin(h).unwrap())]));
                seen[f] = true;
            }
        }
    }

    #[test]
    fn cut_along_cheap_edges() {
        // A torus with a cheap meridian: the cut runs along it.
        let mesh = shapes::torus(1.0, 0.4, 24, 12);
        let on_circle = |v: VertexId| mesh.position(v).y.abs() < 1e-9 && mesh.position(v).x > 0.0;
        let cheap = |e: EdgeId| mesh.ends(e).iter().all(|&v| on_circle(v));
        let cost = EdgeMap::from_fn(mesh.edge_count(), |e| if cheap(e) { 0.01 } else { 1.0 });
        let cut = cut_graph(&mesh, &cost, &[]);
        assert_eq!(mesh.edges().filter(|&e| cut[e] && cheap(e)).count(), 12);
        assert_eq!(mesh.edges().filter(|&e| cut[e]).count(), 12 + 24);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn cut_graphs_open_disks(shape in 0usize..7, picks in proptest::collection::vec(0.0..1.0f64, 0..9), seed: u64) {
            let mesh = &test_shapes()[shape];
            let singular: Vec<VertexId> =
                picks.iter().map(|t| VertexId::new((t * mesh.vertex_count() as f64) as usize)).collect();
            let cost = EdgeMap::from_fn(mesh.edge_count(), |e: EdgeId| shapes::random(seed, e.index() as u64).powi(4));
            check_cut(mesh, &cost, &singular);
            check_cut(mesh, &EdgeMap::filled(mesh.edge_count(), 1.0), &singular);
        }
    }
}
