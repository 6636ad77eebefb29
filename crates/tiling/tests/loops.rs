//! Shortest loops and connections against brute force that shares nothing with the crate.
//!
//! Cocycles of the surface are solved for over ℤ₂ by elimination; a closed walk separates nothing if some cocycle is odd
//! on it. The shortest such walk is a shortest path in the graph of all pairs of a vertex and a class.

use quadloom_mesh::{EdgeMap, Progress, Summary, TriMesh, shapes};
use quadloom_tiling::{CutKind, CutOptions, EdgeCosts, SearchMode, cut_intermediate, cut_shortest};
use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

/// A graph with triangles and border cycles, by edges.
struct Plain {
    vertices: usize,
    edges: Vec<(usize, usize, f64)>,
    /// Sets of edges on which every cocycle is even.
    relations: Vec<Vec<usize>>,
}

impl Plain {
    fn of(vertices: usize, faces: &[[u32; 3]], cost: impl Fn(u32, u32) -> f64) -> Self {
        let mut number: BTreeMap<(u32, u32), usize> = BTreeMap::new();
        let mut edges = Vec::new();
        let mut uses: Vec<Vec<(u32, u32)>> = Vec::new();
        let mut relations = Vec::new();
        for f in faces {
            let mut triangle = Vec::new();
            for k in 0..3 {
                let (a, b) = (f[k], f[(k + 1) % 3]);
                let key = (a.min(b), a.max(b));
                let e = *number.entry(key).or_insert_with(|| {
                    edges.push((a as usize, b as usize, cost(a, b)));
                    uses.push(Vec::new());
                    edges.len() - 1
                });
                uses[e].push((a, b));
                triangle.push(e);
            }
            relations.push(triangle);
        }
        // Border cycles, closed by caps.
        let mut next: BTreeMap<u32, (u32, usize)> = BTreeMap::new();
        for (e, sides) in uses.iter().enumerate() {
            if let [(a, b)] = sides[..] {
                next.insert(a, (b, e));
            }
        }
        while let Some((&start, _)) = next.first_key_value() {
            let (mut at, mut cycle) = (start, Vec::new());
            while let Some((b, e)) = next.remove(&at) {
                cycle.push(e);
                at = b;
            }
            relations.push(cycle);
        }
        Self { vertices, edges, relations }
    }

    /// For each edge the values of independent cocycles that are no coboundaries, as bits.
    fn cocycles(&self) -> Vec<u32> {
        // 1. Coboundaries are removed by setting the edges of a spanning tree to zero.
        let mut up: Vec<usize> = (0..self.vertices).collect();
        fn root(up: &[usize], mut i: usize) -> usize {
            while up[i] != i {
                i = up[i];
            }
            i
        }
        let mut free = Vec::new();
        for (e, &(a, b, _)) in self.edges.iter().enumerate() {
            let (a, b) = (root(&up, a), root(&up, b));
            if a == b { free.push(e) } else { up[a] = b }
        }
        let column: BTreeMap<usize, usize> = free.iter().enumerate().map(|(k, &e)| (e, k)).collect();
        // 2. Elimination over ℤ₂.
        let mut rows: Vec<Vec<bool>> = Vec::new();
        for relation in &self.relations {
            let mut row = vec![false; free.len()];
            relation.iter().filter_map(|e| column.get(e)).for_each(|&k| row[k] = !row[k]);
            rows.push(row);
        }
        let mut pivots: Vec<usize> = Vec::new();
        let mut done = 0;
        for k in 0..free.len() {
            let Some(found) = (done..rows.len()).find(|&r| rows[r][k]) else { continue };
            rows.swap(done, found);
            let pivot = rows[done].clone();
            for (r, row) in rows.iter_mut().enumerate() {
                if r != done && row[k] {
                    row.iter_mut().zip(&pivot).for_each(|(x, p)| *x ^= p);
                }
            }
            pivots.push(k);
            done += 1;
        }
        // 3. One solution per column without a pivot.
        let mut bits = vec![0u32; self.edges.len()];
        let others: Vec<usize> = (0..free.len()).filter(|k| !pivots.contains(k)).collect();
        for (bit, &k) in others.iter().enumerate() {
            bits[free[k]] |= 1 << bit;
            for (r, &pivot) in pivots.iter().enumerate() {
                if rows[r][k] {
                    bits[free[pivot]] |= 1 << bit;
                }
            }
        }
        bits
    }

    /// Length of the shortest closed walk that some cocycle is odd on.
    fn shortest_loop(&self) -> f64 {
        let bits = self.cocycles();
        let classes = bits.iter().fold(0, |all, b| all | b) as usize + 1;
        let mut around: Vec<Vec<(usize, f64, u32)>> = vec![Vec::new(); self.vertices];
        for (e, &(a, b, cost)) in self.edges.iter().enumerate() {
            around[a].push((b, cost, bits[e]));
            around[b].push((a, cost, bits[e]));
        }
        let mut best = f64::INFINITY;
        for start in 0..self.vertices {
            let mut distance = vec![f64::INFINITY; self.vertices * classes];
            let mut heap = BinaryHeap::from([Item(0.0, start, 0)]);
            distance[start * classes] = 0.0;
            while let Some(Item(d, v, class)) = heap.pop() {
                if d > distance[v * classes + class as usize] || d >= best {
                    continue;
                }
                for &(w, cost, bit) in &around[v] {
                    let there = w * classes + (class ^ bit) as usize;
                    if d + cost < distance[there] {
                        distance[there] = d + cost;
                        heap.push(Item(d + cost, w, class ^ bit));
                    }
                }
            }
            let closed = distance[start * classes + 1..(start + 1) * classes].iter();
            best = best.min(closed.fold(f64::INFINITY, |a, &b| a.min(b)));
        }
        best
    }
}

struct Item(f64, usize, u32);
impl Ord for Item {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.total_cmp(&self.0).then(other.1.cmp(&self.1)).then(other.2.cmp(&self.2))
    }
}
impl PartialOrd for Item {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Item {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Item {}

/// The faces of a mesh cut along a loop of its edges: corners left of it get vertices of their own.
fn cut_open(mesh: &TriMesh, path: &[u32]) -> (usize, Vec<[u32; 3]>, Vec<u32>) {
    let cut = |a: u32, b: u32| path.windows(2).any(|p| (p[0], p[1]) == (a, b) || (p[1], p[0]) == (a, b));
    let faces = mesh.to_faces();
    let mut up: Vec<usize> = (0..3 * faces.len()).collect();
    fn root(up: &[usize], mut i: usize) -> usize {
        while up[i] != i {
            i = up[i];
        }
        i
    }
    let mut side: BTreeMap<(u32, u32), (usize, usize)> = BTreeMap::new();
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            side.insert((face[k], face[(k + 1) % 3]), (3 * f + k, 3 * f + (k + 1) % 3));
        }
    }
    for (&(a, b), &(s, t)) in &side {
        if a < b
            && !cut(a, b)
            && let Some(&(u, v)) = side.get(&(b, a))
        {
            let pairs = [(s, v), (t, u)];
            pairs.iter().for_each(|&(x, y)| {
                let (x, y) = (root(&up, x), root(&up, y));
                up[x] = y;
            });
        }
    }
    let mut number: BTreeMap<usize, u32> = BTreeMap::new();
    let mut image = Vec::new();
    let mut open = Vec::new();
    for (f, face) in faces.iter().enumerate() {
        open.push([0, 1, 2].map(|k| {
            *number.entry(root(&up, 3 * f + k)).or_insert_with(|| {
                image.push(face[k]);
                image.len() as u32 - 1
            })
        }));
    }
    (image.len(), open, image)
}

#[test]
fn loops_are_as_short_as_those_of_brute_force() {
    let (mut tested, mut second) = (0, 0);
    let mut seed = 0;
    while tested < 300 {
        seed += 1;
        let mesh = shapes::small_random(seed, 60);
        let summary = Summary::of(&mesh);
        if summary.genus == 0 {
            continue;
        }
        tested += 1;
        let weight = EdgeMap::from_fn(mesh.edge_count(), |e| 0.05 + shapes::random(seed, u64::from(e.0)));
        let costs = EdgeCosts::new(weight.clone()).unwrap();
        let of =
            |a: u32, b: u32| weight[mesh.find_edge(quadloom_mesh::VertexId(a), quadloom_mesh::VertexId(b)).unwrap()];
        let progress = Progress::none();
        let options = CutOptions { search: SearchMode::Exact, base: None };
        let cutting = cut_shortest(&mesh, &costs, &options, &progress).unwrap();
        let fast = cut_shortest(&mesh, &costs, &CutOptions::default(), &progress).unwrap();
        let truth = Plain::of(mesh.vertex_count(), &mesh.to_faces(), of).shortest_loop();
        let found = cutting.cuts()[0].cost;
        assert!((found - truth).abs() <= 1e-9 * truth, "seed {seed}: {found} instead of {truth}");
        assert!(fast.cuts()[0].cost >= found * (1.0 - 1e-9), "seed {seed}: the fast loop is shorter");
        // The second loop, on the surface cut open along the first one where that runs along edges.
        let first: Vec<u32> = cutting.cuts()[0].path().iter().map(|v| v.0).collect();
        let old: Vec<u32> = first.iter().copied().filter(|&v| (v as usize) < mesh.vertex_count()).collect();
        let closed: Vec<u32> = old.iter().chain(old.first()).copied().collect();
        let on_edges = old.len() + 2 == first.len()
            && closed
                .windows(2)
                .all(|p| mesh.find_edge(quadloom_mesh::VertexId(p[0]), quadloom_mesh::VertexId(p[1])).is_some());
        if summary.genus > 1 && on_edges {
            second += 1;
            let (vertices, faces, image) = cut_open(&mesh, &closed);
            let truth = Plain::of(vertices, &faces, |a, b| of(image[a as usize], image[b as usize])).shortest_loop();
            let cut = &cutting.cuts()[1];
            assert_eq!(cut.kind, CutKind::Loop);
            assert!((cut.cost - truth).abs() <= 1e-9 * truth, "seed {seed}: second {} instead of {truth}", cut.cost);
        }
        // The others are at least valid.
        for cutting in [cutting, fast, cut_intermediate(&mesh, &costs, &options, &progress).unwrap()] {
            assert_eq!(cutting.tiling().unwrap().check(), [], "seed {seed}");
        }
    }
    assert!(second > 50, "only {second} second loops were compared");
}
