//! One tile from any surface ([Favreau2009] §3).
//!
//! In: a connected mesh and edge costs. Out: a [`Cutting`] whose tiling has one tile, a disk.
//! Holds: Algorithm 1 and 3 for any surface, Algorithm 2 for closed ones; what "shortest" means is told by
//! [`SearchMode`]. Not: the shortest cut graph, which is NP-hard ([Erickson2004]).
//!
//! Loops of the exact search are looked for from every vertex of a cut graph: a loop that misses it runs in a disk and
//! separates. A search ends at half the length of the best loop so far; vertices whose loops were longer than the best
//! one of an earlier round wait until that length is reached again.

use crate::classes::{Borders, Classes, classes};
use crate::cost::EdgeCosts;
use crate::cut_surface::{CutSurface, NONE, Walk};
use crate::cutting::{Cut, CutKind, CutOptions, Cutting, Method, SearchMode};
use crate::error::TilingError;
use crate::search::{Found, Search};
use quadloom_mesh::{EdgeId, HalfEdgeId, Progress, Summary, TriMesh, VertexId};
use std::collections::{BTreeMap, HashMap};

/// Cuts a mesh into one disk by a method.
///
/// # Errors     as those of the method's own function
pub fn cut_to_disk<'a>(
    mesh: &'a TriMesh,
    costs: &'a EdgeCosts,
    method: Method,
    options: &CutOptions,
    progress: &'a Progress,
) -> Result<Cutting<'a>, TilingError> {
    match method {
        Method::Shortest => cut_shortest(mesh, costs, options, progress),
        Method::SinglePoint => cut_single_point(mesh, costs, options, progress),
        Method::Intermediate => cut_intermediate(mesh, costs, options, progress),
    }
}

/// Shortest non-separating loops until no handle is left, then shortest connections between boundaries until one is
/// left ([Favreau2009] Algorithm 1). A sphere is slit between two vertices that are far apart.
///
/// # Errors     [`TilingError::Components`], [`TilingError::CostCount`], [`TilingError::NoWay`], [`TilingError::NoVertex`]
/// # Cost       fast: O(g n log n); exact: O(g k m log m) for k vertices of a cut graph and balls of m vertices
pub fn cut_shortest<'a>(
    mesh: &'a TriMesh,
    costs: &'a EdgeCosts,
    options: &CutOptions,
    progress: &'a Progress,
) -> Result<Cutting<'a>, TilingError> {
    let mut cutting = Cutting::new(mesh, costs, progress)?;
    cutting.open_handles(options)?;
    cutting.slit_sphere(options)?;
    while let Some(found) = cutting.shortest_connection() {
        progress.check()?;
        progress.report("connections", 0.0);
        cutting.cut_along(&found.walk, CutKind::Connection)?;
    }
    cutting.must_be_disk()?;
    Ok(cutting)
}

/// Shortest loops as in Algorithm 1, then connections that create as few nodes as possible: one per loop and boundary
/// ([Favreau2009] Algorithm 3).
///
/// # Errors     as [`cut_shortest`]
/// # Cost       as [`cut_shortest`]
pub fn cut_intermediate<'a>(
    mesh: &'a TriMesh,
    costs: &'a EdgeCosts,
    options: &CutOptions,
    progress: &'a Progress,
) -> Result<Cutting<'a>, TilingError> {
    let mut cutting = Cutting::new(mesh, costs, progress)?;
    cutting.open_handles(options)?;
    cutting.slit_sphere(options)?;
    while let Some(walk) = cutting.frugal_connection(options.search)? {
        progress.check()?;
        cutting.cut_along(&walk, CutKind::Connection)?;
    }
    cutting.must_be_disk()?;
    Ok(cutting)
}

/// All loops through one point: a polygon with 4g sides and one multipoint ([Favreau2009] Algorithm 2).
///
/// Once the point and the first two loops are found, the others are the greedy system of loops there, which is the
/// shortest one with these two ([Erickson2005]).
///
/// # Errors     [`TilingError::Boundary`] for a mesh with boundary, [`TilingError::NoHandle`] for a sphere, and those of
/// [`cut_shortest`]
/// # Cost       fast: O(n log n + output); exact: as [`cut_shortest`] for the first loop, then O(k n log n) for the k
/// vertices of that loop
pub fn cut_single_point<'a>(
    mesh: &'a TriMesh,
    costs: &'a EdgeCosts,
    options: &CutOptions,
    progress: &'a Progress,
) -> Result<Cutting<'a>, TilingError> {
    let summary = Summary::of(mesh);
    if summary.boundary_loops > 0 {
        let algorithm = "the single-point cutting (Algorithm 2)";
        return Err(TilingError::Boundary { algorithm, boundaries: summary.boundary_loops });
    }
    let mut cutting = Cutting::new(mesh, costs, progress)?;
    if summary.genus == 0 {
        let instead = "use the shortest cutting (Algorithm 1), which slits a sphere";
        return Err(TilingError::NoHandle { algorithm: "the single-point cutting (Algorithm 2)", instead });
    }
    let (root, forced) = cutting.single_base(options)?;
    let found = classes(&cutting.surface, &cutting.units, root, Borders::Capped, &forced);
    let mut closing: Vec<u32> = found.closing.clone();
    closing.sort_by_key(|&h| !forced.contains(&h));
    for (k, &h) in closing.iter().enumerate() {
        progress.check()?;
        progress.report("loops", k as f64 / closing.len() as f64);
        cutting.cut_tree_loop(mesh.edge(HalfEdgeId(h)), root, &found)?;
    }
    cutting.must_be_disk()?;
    Ok(cutting)
}

impl Cutting<'_> {
    /// Cuts along shortest non-separating loops until no handle is left ([Favreau2009] §3.2.1).
    fn open_handles(&mut self, options: &CutOptions) -> Result<(), TilingError> {
        let genus = Summary::of(self.mesh()).genus;
        let base = self.checked_base(options.base)?;
        let mut bases = None;
        for handle in 0..genus {
            self.progress.check()?;
            self.progress.report("loops", handle as f64 / genus as f64);
            let root = self.vertex_at(base.unwrap_or(0))?;
            let known = classes(&self.surface, &self.units, root, Borders::Capped, &[]);
            let found = self.loop_of(&known, base.map(|_| root), options.search, &mut bases)?;
            self.cut_loop(&found.walk)?;
        }
        Ok(())
    }

    /// A short non-separating loop, or the shortest one of all.
    ///
    /// # Input      bases: of earlier exact searches in the same mesh; filled by the first
    pub(crate) fn loop_of(
        &mut self,
        known: &Classes,
        base: Option<u32>,
        search: SearchMode,
        bases: &mut Option<Bases>,
    ) -> Result<Found, TilingError> {
        let fast = self.fast_loop(known, base)?;
        if search == SearchMode::Fast {
            return Ok(fast);
        }
        let bases = bases.get_or_insert_with(|| Bases::on_cut_graph(&self.surface, known));
        bases.shortest_loop(&self.surface, &self.units, &known.class, &mut self.search, fast, self.progress)
    }

    /// A vertex of C at a vertex of the mesh.
    fn vertex_at(&self, v: u32) -> Result<u32, TilingError> {
        // Vertices of the mesh keep their number as one of their vertices in C.
        if self.surface.out[v as usize] == NONE { Err(TilingError::Fault { what: "a vertex was lost" }) } else { Ok(v) }
    }

    /// A short non-separating loop: the shortest one through one vertex. Without a given vertex that is an end of the
    /// edge that closes the shortest loop at the root of the classes.
    fn fast_loop(&mut self, known: &Classes, base: Option<u32>) -> Result<Found, TilingError> {
        let first = known.closing.first().map(|&h| self.surface.origin[h as usize]);
        let base = base.or(first).ok_or(TilingError::Fault { what: "a handle has no loop" })?;
        let no_way = TilingError::NoWay { what: "a loop around a handle" };
        let (s, units) = (&self.surface, &self.units);
        self.search.shortest_loop(s, units, &known.class, base, u64::MAX, |c| c == 0).ok_or(no_way)
    }

    /// Slits a sphere between two vertices that are far apart.
    fn slit_sphere(&mut self, options: &CutOptions) -> Result<(), TilingError> {
        let s = &self.surface;
        if s.out.iter().any(|&h| h != NONE && s.is_border(h)) {
            return Ok(());
        }
        let start = self.checked_base(options.base)?.unwrap_or(0);
        let farthest = |search: &mut Search, from: u32| {
            search.spread(s, &self.units, &[(from, 0)], |_| false);
            search.settled.last().copied().unwrap_or(from)
        };
        let first = if options.base.is_some() { start } else { farthest(&mut self.search, start) };
        let last = farthest(&mut self.search, first);
        let walk = self.search.path_back(last);
        if walk.edges.is_empty() {
            return Err(TilingError::NoWay { what: "a slit in a sphere" });
        }
        self.cut_along(&walk, CutKind::Slit)
    }

    /// The shortest walk between two boundaries of C; `None` if there is one boundary.
    pub(crate) fn shortest_connection(&mut self) -> Option<Found> {
        let borders = self.surface.borders();
        if borders.len() < 2 {
            return None;
        }
        let s = &self.surface;
        let sources: Vec<(u32, u64)> = borders
            .iter()
            .enumerate()
            .flat_map(|(k, border)| border.iter().map(move |&h| (s.origin[h as usize], k as u64)))
            .collect();
        self.search.connect(s, &self.units, &sources, u64::MAX)
    }

    /// A connection between two boundaries that creates as few nodes as possible ([Favreau2009] §3.3.2).
    fn frugal_connection(&mut self, mode: SearchMode) -> Result<Option<Walk>, TilingError> {
        let borders = self.surface.borders();
        if borders.len() < 2 {
            return Ok(None);
        }
        // 1. Where connections may end: at nodes of a boundary that has some, else anywhere on it.
        let node = self.nodes();
        let s = &self.surface;
        let mut sources: Vec<(u32, u64)> = Vec::new();
        let mut has_node = Vec::new();
        for (k, border) in borders.iter().enumerate() {
            let vertices = border.iter().map(|&h| s.origin[h as usize]);
            let nodes: Vec<u32> = vertices.clone().filter(|&v| node[s.point[v as usize] as usize]).collect();
            has_node.push(!nodes.is_empty());
            let ends: Vec<u32> = if nodes.is_empty() { vertices.collect() } else { nodes };
            sources.extend(ends.into_iter().map(|v| (v, k as u64)));
        }
        let Some(found) = self.search.connect(s, &self.units, &sources, u64::MAX) else { return Ok(None) };
        // 2. The two sides of one loop get one node: both ends have the same image.
        let labels: HashMap<u32, usize> = sources.iter().map(|&(v, k)| (v, k as usize)).collect();
        let ends = [found.walk.vertices[0], found.walk.last()];
        let [a, b] = ends.map(|v| labels.get(&v).copied().unwrap_or(0));
        let image = |k: usize| {
            let mut points: Vec<u32> = borders[k].iter().map(|&h| s.point[s.origin[h as usize] as usize]).collect();
            points.sort_unstable();
            points
        };
        if has_node[a] || has_node[b] || image(a) != image(b) {
            return Ok(Some(found.walk));
        }
        let other: HashMap<u32, u32> =
            borders[b].iter().map(|&h| s.origin[h as usize]).map(|v| (s.point[v as usize], v)).collect();
        let starts: Vec<u32> = match mode {
            SearchMode::Exact => borders[a].iter().map(|&h| s.origin[h as usize]).collect(),
            SearchMode::Fast => {
                let here: HashMap<u32, u32> =
                    borders[a].iter().map(|&h| s.origin[h as usize]).map(|v| (s.point[v as usize], v)).collect();
                ends.iter().filter_map(|&v| here.get(&s.point[v as usize]).copied()).collect()
            }
        };
        let pairs: Vec<(u32, u32)> =
            starts.iter().filter_map(|&v| other.get(&s.point[v as usize]).map(|&w| (v, w))).collect();
        let best = shortest_pair(s, &self.units, &pairs, &mut self.search, self.progress)?;
        Ok(Some(best.ok_or(TilingError::NoWay { what: "a path between the sides of a loop" })?.walk))
    }

    /// All of C must be one disk; it is not where forbidden edges left no way.
    fn must_be_disk(&self) -> Result<(), TilingError> {
        if self.surface.borders().len() == 1 {
            Ok(())
        } else {
            Err(TilingError::NoWay { what: "a path between boundaries" })
        }
    }

    /// The base point of a single-point cutting, and the closing edges of its first two loops where they are known.
    fn single_base(&mut self, options: &CutOptions) -> Result<(u32, Vec<u32>), TilingError> {
        let mesh = self.mesh();
        if let Some(base) = self.checked_base(options.base)? {
            return Ok((base, Vec::new()));
        }
        // 1. The first loop.
        let known = classes(&self.surface, &self.units, 0, Borders::Capped, &[]);
        let mut first = self.fast_loop(&known, None)?;
        if options.search == SearchMode::Exact {
            let mut bases = Bases::on_cut_graph(&self.surface, &known);
            first = bases.shortest_loop(
                &self.surface,
                &self.units,
                &known.class,
                &mut self.search,
                first,
                self.progress,
            )?;
        }
        // 2. A path from one side of it to the other that ends where it begins: the shortest one over all its points,
        //    or over the two where the shortest path of all ends.
        let mut open = Cutting::new(mesh, self.costs, self.progress)?;
        let loop_points: Vec<u32> = first.walk.vertices.clone();
        open.cut_raw_loop(&first.walk)?;
        let mut sides: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for border in open.surface.borders() {
            for h in border {
                let v = open.surface.origin[h as usize];
                sides.entry(open.surface.point[v as usize]).or_default().push(v);
            }
        }
        let no_way = TilingError::NoWay { what: "a path between the sides of the first loop" };
        let candidates = match options.search {
            SearchMode::Exact => loop_points[1..].to_vec(),
            SearchMode::Fast => {
                let walk = open.shortest_connection().ok_or(no_way.clone())?.walk;
                open.surface.points(&[walk.vertices[0], walk.last()])
            }
        };
        let pairs: Vec<(u32, u32)> = candidates
            .iter()
            .filter_map(|p| match sides.get(p).map(Vec::as_slice) {
                Some(&[a, b]) => Some((a, b)),
                _ => None,
            })
            .collect();
        let second = shortest_pair(&open.surface, &self.units, &pairs, &mut self.search, self.progress)?;
        let second = second.ok_or(no_way)?;
        let root = open.surface.point[second.walk.vertices[0] as usize];
        // 3. Each is a path of the shortest-path tree there, an edge, and another path.
        let tree = classes(&self.surface, &self.units, root, Borders::Capped, &[]);
        let second_points: Vec<u32> = second.walk.vertices.iter().map(|&v| open.surface.base_of(v)).collect();
        let closing = [&loop_points, &second_points].map(|points| {
            let in_tree = |a: u32, b: u32| tree.parent[a as usize].0 == b || tree.parent[b as usize].0 == a;
            let off: Vec<&[u32]> = points.windows(2).filter(|p| !in_tree(p[0], p[1])).collect();
            match off[..] {
                [pair] => mesh.find_edge(VertexId(pair[0]), VertexId(pair[1])).map(|e| mesh.half_edge(e).0),
                _ => None,
            }
        });
        Ok((root, closing.into_iter().flatten().collect()))
    }

    /// Cuts an uncut surface along a simple loop of the mesh's edges, without moving off it.
    fn cut_raw_loop(&mut self, walk: &Walk) -> Result<(), TilingError> {
        let path: Option<Vec<u32>> =
            walk.edges.iter().zip(&walk.vertices).map(|(&h, &v)| self.surface.leaving(h, v)).collect();
        self.surface.cut(&path.ok_or(TilingError::Fault { what: "a loop leaves the surface" })?)?;
        Ok(())
    }

    /// Cuts along the loop of a tree's two paths to the ends of an edge.
    ///
    /// Loops of one tree run side by side along its edges. Around each of its vertices the cuts so far leave sectors,
    /// each with one way back to the root: the walk of fewest steps that stays at vertices of the path finds it.
    fn cut_tree_loop(&mut self, edge: EdgeId, root: u32, tree: &Classes) -> Result<(), TilingError> {
        // 1. A point on the edge, where the loop begins and ends.
        let ends = self.mesh().ends(edge).map(|v| v.0);
        let s = &mut self.surface;
        let h = s.middle(edge.0);
        s.split_edge(h, ends[0], s.origin[h as usize]);
        let ahead = s.next[h as usize];
        let mut points: Vec<u32> = Vec::new();
        let mut cost = self.costs.values()[edge];
        // 2. Back to the root from both ends; the second way sees the first one as a border.
        for (end, first) in [(ends[0], h), (ends[1], ahead)] {
            let s = &self.surface;
            let [a, b] = [s.origin[first as usize], s.target(first)];
            let (middle, start) = if end == ends[0] { (b, a) } else { (a, b) };
            let path = path_to_root(self.mesh(), tree, end);
            let blocked = |&(_, e): &(u32, u32)| e != NONE && !self.allowed(e as usize);
            if path.iter().any(blocked) || !self.allowed(edge.0 as usize) {
                return Err(TilingError::NoWay { what: "a loop through the base point" });
            }
            let back = self.follow_tree(start, middle, &path, root)?;
            cost += self.cost_of_walk(&back);
            let mut walk = Walk::start(middle);
            walk.push(first, start);
            back.edges.iter().zip(&back.vertices[1..]).for_each(|(&e, &v)| walk.push(e, v));
            let cut = self.surface.cut_walk(&walk)?;
            if points.is_empty() {
                points = cut;
                points.reverse();
            } else {
                points.extend(&cut[1..]);
            }
        }
        self.cuts.push(Cut { kind: CutKind::Loop, cost, points });
        Ok(())
    }

    /// The way from a vertex of C to the root, along copies of a path of the tree.
    fn follow_tree(&mut self, start: u32, not: u32, path: &[(u32, u32)], root: u32) -> Result<Walk, TilingError> {
        let s = &self.surface;
        let index: HashMap<u32, usize> = path.iter().enumerate().map(|(i, &(v, _))| (v, i)).collect();
        let may_step = |v: u32, h: u32, w: u32| {
            if w == not {
                return false;
            }
            let (Some(&i), Some(&j)) = (index.get(&s.home[v as usize]), index.get(&s.home[w as usize])) else {
                return false;
            };
            j == i || (j == i + 1 && s.span[h as usize] == path[i].1)
        };
        let is_root = |v: u32| s.point[v as usize] == root;
        self.search
            .follow(s, &[start], may_step, is_root)
            .ok_or(TilingError::Fault { what: "a loop lost its way back" })
    }
}

/// Vertices from one of the mesh to the root of a tree of the uncut mesh, each with the edge to the next.
fn path_to_root(mesh: &TriMesh, tree: &Classes, mut v: u32) -> Vec<(u32, u32)> {
    let mut path = Vec::new();
    loop {
        let (parent, h) = tree.parent[v as usize];
        if parent == NONE {
            path.push((v, NONE));
            return path;
        }
        path.push((v, mesh.edge(HalfEdgeId(h)).0));
        v = parent;
    }
}

/// The shortest walk between the two vertices of one of several pairs.
fn shortest_pair(
    s: &CutSurface,
    units: &[u64],
    pairs: &[(u32, u32)],
    search: &mut Search,
    progress: &Progress,
) -> Result<Option<Found>, TilingError> {
    let mut best: Option<Found> = None;
    for &(a, b) in pairs {
        progress.check()?;
        let bound = best.as_ref().map_or(u64::MAX, |f| f.length);
        if let Some(found) = search.path(s, units, &[a], bound, |v| v == b) {
            best = Some(found);
        }
    }
    Ok(best)
}

/// Vertices that every non-separating loop passes, with what is known of the loops there.
pub(crate) struct Bases {
    /// By vertex of the mesh: no non-separating loop at it is shorter; `None` for others.
    least: BTreeMap<u32, u64>,
}

impl Bases {
    /// The vertices of a cut graph: paths of the tree to the ends of closing edges, without loose ends.
    fn on_cut_graph(s: &CutSurface, known: &Classes) -> Self {
        let mut children: BTreeMap<u32, u32> = BTreeMap::new();
        let mut ends: Vec<u32> = Vec::new();
        for &h in &known.closing {
            for mut v in [s.origin[h as usize], s.target(h)] {
                ends.push(v);
                while children.insert(v, 0).is_none() && known.parent[v as usize].0 != NONE {
                    v = known.parent[v as usize].0;
                }
            }
        }
        let all: Vec<u32> = children.keys().copied().collect();
        let mut root = None;
        for &v in &all {
            match known.parent[v as usize].0 {
                NONE => root = Some(v),
                parent => *children.entry(parent).or_default() += 1,
            }
        }
        // From the root to where paths part there is no loop.
        while let Some(v) = root {
            if children.get(&v) != Some(&1) || ends.contains(&v) {
                break;
            }
            children.remove(&v);
            root = all.iter().copied().find(|&w| known.parent[w as usize].0 == v && children.contains_key(&w));
        }
        Self { least: children.keys().map(|&v| (s.base_of(v), 0)).collect() }
    }

    /// The shortest non-separating loop of C, if it is shorter than the given one.
    fn shortest_loop(
        &mut self,
        s: &CutSurface,
        units: &[u64],
        class: &[u64],
        search: &mut Search,
        given: Found,
        progress: &Progress,
    ) -> Result<Found, TilingError> {
        // 1. Copies of each base in C; one stands for all that free edges join.
        let mut copies: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut done = vec![false; s.vertex_count()];
        for v in (0..s.vertex_count() as u32).filter(|&v| s.out[v as usize] != NONE) {
            let base = s.base_of(v);
            if done[v as usize] || !self.least.contains_key(&base) {
                continue;
            }
            copies.entry(base).or_default().push(v);
            let mut stack = vec![v];
            while let Some(v) = stack.pop() {
                if !std::mem::replace(&mut done[v as usize], true) {
                    s.for_edges(v, |h, w| {
                        if s.span[h as usize] == NONE {
                            stack.push(w)
                        }
                    });
                }
            }
        }
        // 2. Bases whose loops may be short first; what is known stays true, for C only gets smaller.
        let mut order: Vec<(u64, u32)> = self.least.iter().map(|(&v, &least)| (least, v)).collect();
        order.sort_unstable();
        let mut best = given;
        for (k, &(least, base)) in order.iter().enumerate() {
            if least >= best.length {
                break;
            }
            if k % 64 == 0 {
                progress.check()?;
            }
            let mut shortest = u64::MAX;
            for &v in copies.get(&base).map_or(&[][..], Vec::as_slice) {
                match search.shortest_loop(s, units, class, v, best.length, |c| c == 0) {
                    Some(found) => {
                        shortest = shortest.min(found.length);
                        best = found;
                    }
                    None => shortest = shortest.min(best.length),
                }
            }
            self.least.insert(base, shortest);
        }
        Ok(best)
    }
}
