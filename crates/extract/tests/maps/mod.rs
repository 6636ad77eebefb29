//! Integer-grid maps known in closed form, on generated meshes.
#![allow(dead_code)]

use quadloom_mesh::{
    CornerMap, DVec3, EdgeMap, FaceMap, FeatureGraph, HalfEdgeMap, TriMesh,
    features::{FeatureKind, FeatureOptions},
};
use quadloom_param::integer_grid_map::{rotate, signed_area};
use quadloom_param::{GRID_UNIT, IntegerGridMap, LatticePoint, Transition};

/// A small deterministic generator (xorshift64*).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11
    }
    /// In 0..n.
    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }
    /// In -1..1.
    pub fn signed(&mut self) -> f64 {
        self.next() as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A mesh, a map of it, and its features.
pub struct Model {
    pub mesh: TriMesh,
    pub map: IntegerGridMap,
    pub features: FeatureGraph,
}

pub fn lattice(p: [f64; 2]) -> LatticePoint {
    p.map(|x| (x * GRID_UNIT as f64).round() as i64)
}

/// The transition that carries the segment `from` onto `to`.
pub fn carry(from: [LatticePoint; 2], to: [LatticePoint; 2]) -> Transition {
    let vector = |s: [LatticePoint; 2]| [s[1][0] - s[0][0], s[1][1] - s[0][1]];
    let quarter_turns = (0..4).find(|&k| rotate(vector(from), k) == vector(to)).expect("charts agree up to a turn");
    let r = rotate(from[0], quarter_turns);
    Transition { quarter_turns, translation: [to[0][0] - r[0], to[0][1] - r[1]] }
}

/// The map with given corner images; transitions follow from them.
pub fn map_of(mesh: &TriMesh, uv: CornerMap<LatticePoint>) -> IntegerGridMap {
    let transition = HalfEdgeMap::from_fn(mesh.half_edge_count(), |i| {
        mesh.twin(i).map_or(Transition::IDENTITY, |t| carry([uv[i], uv[mesh.next(i)]], [uv[mesh.next(t)], uv[t]]))
    });
    IntegerGridMap { uv, transition }
}

/// Gives every face another chart: a random quarter turn and integer shift.
pub fn scramble(model: &mut Model, seed: u64) {
    let mut random = Random(seed | 1);
    let shift = FaceMap::from_fn(model.mesh.face_count(), |_| Transition {
        quarter_turns: random.below(4) as u8,
        translation: [0, 1].map(|_| (random.below(9) as i64 - 4) * GRID_UNIT),
    });
    let mesh = &model.mesh;
    let uv = CornerMap::from_fn(mesh.half_edge_count(), |h| shift[mesh.face(h)].apply(model.map.uv[h]));
    let transition = HalfEdgeMap::from_fn(mesh.half_edge_count(), |h| {
        mesh.twin(h).map_or(Transition::IDENTITY, |t| {
            shift[mesh.face(h)].inverse().followed_by(model.map.transition[h]).followed_by(shift[mesh.face(t)])
        })
    });
    model.map = IntegerGridMap { uv, transition };
}

/// A rectangle of `size` grid units, as `cells` cells of two triangles each, with random diagonals and inner vertices
/// moved by up to `jitter` cells; the map is the identity.
pub fn rectangle(size: [usize; 2], cells: [usize; 2], jitter: f64, seed: u64) -> Model {
    rectangle_with_line(size, cells, jitter, None, seed)
}

/// The same where the vertices of one column of cells stay on its line.
pub fn rectangle_with_line(
    size: [usize; 2],
    cells: [usize; 2],
    jitter: f64,
    straight: Option<usize>,
    seed: u64,
) -> Model {
    let mut random = Random(seed | 1);
    let [m, n] = cells;
    let mut plane = Vec::new();
    for j in 0..=n {
        for i in 0..=m {
            let mut p = [i as f64, j as f64];
            for (k, inner) in [(0, i > 0 && i < m && Some(i) != straight), (1, j > 0 && j < n)] {
                if inner {
                    p[k] += jitter * random.signed();
                }
            }
            plane.push(lattice([0, 1].map(|k| p[k] * size[k] as f64 / cells[k] as f64)));
        }
    }
    let at = |i: usize, j: usize| (j * (m + 1) + i) as u32;
    let mut faces = Vec::new();
    for j in 0..n {
        for i in 0..m {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if random.below(2) == 0 {
                faces.extend([[a, b, c], [a, c, d]]);
            } else {
                faces.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    planar(plane, &faces)
}

/// A planar mesh whose map is its own position; boundary edges and sharp turns are features.
pub fn planar(plane: Vec<LatticePoint>, faces: &[[u32; 3]]) -> Model {
    let space = plane.iter().map(|p| DVec3::new(p[0] as f64, p[1] as f64, 0.0) / GRID_UNIT as f64).collect();
    let mesh = TriMesh::new(space, faces).expect("manifold");
    let uv = CornerMap::from_fn(mesh.half_edge_count(), |h| plane[mesh.origin(h).index()]);
    let map = map_of(&mesh, uv);
    let (features, _) = FeatureGraph::detect(&mesh, &FeatureOptions::default());
    Model { mesh, map, features }
}

/// Whether every triangle is positive.
pub fn is_positive(model: &Model) -> bool {
    model.map.inverted_faces(&model.mesh).is_empty()
}

/// The surface of a box of `size` grid units; every side has its own chart and `cells` cells per unit of length.
pub fn cuboid(size: [usize; 3], cells: usize) -> Model {
    let mut number = std::collections::BTreeMap::new();
    let mut space = Vec::new();
    let mut faces = Vec::new();
    let mut charts = Vec::new();
    for axis in 0..3 {
        for top in [false, true] {
            let (u, v) = if top { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
            let mut at = |i: usize, j: usize| {
                let mut p = [0; 3];
                (p[axis], p[u], p[v]) = (if top { size[axis] * cells } else { 0 }, i, j);
                *number.entry(p).or_insert_with(|| {
                    space.push(DVec3::new(p[0] as f64, p[1] as f64, p[2] as f64) / cells as f64);
                    space.len() as u32 - 1
                })
            };
            for j in 0..size[v] * cells {
                for i in 0..size[u] * cells {
                    let c = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
                    for t in [[0, 1, 2], [0, 2, 3]] {
                        faces.push(t.map(|k| at(c[k][0], c[k][1])));
                        charts.extend(t.map(|k| lattice(c[k].map(|x| x as f64 / cells as f64))));
                    }
                }
            }
        }
    }
    let mesh = TriMesh::new(space, &faces).expect("manifold");
    let map = map_of(&mesh, CornerMap::from_vec(charts));
    let (features, _) = FeatureGraph::detect(&mesh, &FeatureOptions::default());
    Model { mesh, map, features }
}

/// A torus of `size` grid units around; inner vertices are moved by up to `jitter` cells, the grid by `shift` units.
pub fn torus(size: [usize; 2], cells: [usize; 2], jitter: f64, shift: [f64; 2], seed: u64) -> Model {
    let mut random = Random(seed | 1);
    let [m, n] = cells;
    let offset: Vec<[f64; 2]> = (0..m * n).map(|_| [jitter * random.signed(), jitter * random.signed()]).collect();
    let plane = |i: usize, j: usize| {
        let o = offset[(j % n) * m + i % m];
        // The period is added after rounding, so that copies of a vertex differ by whole units.
        let p = lattice([0, 1].map(|k| {
            let x = [i % m, j % n][k] as f64 + o[k];
            x * size[k] as f64 / cells[k] as f64 + shift[k]
        }));
        [p[0] + (i / m * size[0]) as i64 * GRID_UNIT, p[1] + (j / n * size[1]) as i64 * GRID_UNIT]
    };
    let space = (0..m * n)
        .map(|k| {
            let [s, t] = [0, 1].map(|a| std::f64::consts::TAU * [k % m, k / m][a] as f64 / cells[a] as f64);
            DVec3::new((3.0 + t.cos()) * s.cos(), (3.0 + t.cos()) * s.sin(), t.sin())
        })
        .collect();
    let (mut faces, mut charts) = (Vec::new(), Vec::new());
    for j in 0..n {
        for i in 0..m {
            let c = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            let cut = if random.below(2) == 0 { [[0, 1, 2], [0, 2, 3]] } else { [[0, 1, 3], [1, 2, 3]] };
            for t in cut {
                faces.push(t.map(|k| ((c[k][1] % n) * m + c[k][0] % m) as u32));
                charts.extend(t.map(|k| plane(c[k][0], c[k][1])));
            }
        }
    }
    let mesh = TriMesh::new(space, &faces).expect("manifold");
    let map = map_of(&mesh, CornerMap::from_vec(charts));
    let features = FeatureGraph::none(&mesh);
    Model { mesh, map, features }
}

/// Marks the mesh edges that lie on the given integer iso-line of a planar model as sharp, keeping the boundary.
pub fn mark_line(model: &mut Model, axis: usize, line: i64) {
    let mesh = &model.mesh;
    let kind = EdgeMap::from_fn(mesh.edge_count(), |e| {
        let h = mesh.half_edge(e);
        let on = [h, mesh.next(h)].iter().all(|&c| model.map.uv[c][axis] == line * GRID_UNIT);
        if mesh.is_boundary_edge(e) { Some(FeatureKind::Boundary) } else { on.then_some(FeatureKind::Sharp) }
    });
    model.features = FeatureGraph::from_kinds(mesh, kind, &FeatureOptions::default()).0;
}

/// Number of quads that a map without inverted triangles has: its area in grid units.
pub fn grid_area(model: &Model) -> f64 {
    let twice: i128 = model
        .mesh
        .faces()
        .map(|f| {
            let [a, b, c] = model.map.face_uv(&model.mesh, f);
            signed_area(a, b, c)
        })
        .sum();
    twice as f64 / 2.0 / (GRID_UNIT as f64).powi(2)
}
