//! Writes a page about a generated shape: three soft arms on a flat foot, one arm open, with its map and its quads.
//!
//! Everything is known by construction: the surface of a few voxels, each side cut into a grid, is smoothed; the
//! grid is the map, every second grid line a quad edge. It needs no solver, so it shows the page and nothing else.
//!
//!     cargo run --release -p quadloom --example demo_view -- demo.html [cells per voxel side]

use quadloom::view::{self, QuadLayer, Scene, SurfaceLayer};
use quadloom_mesh::metric::FaceFrame;
use quadloom_mesh::{
    CornerMap, DVec3, FaceId, FaceMap, FeatureGraph, HalfEdgeId, HalfEdgeMap, QuadMesh, TriMesh, VertexId,
};
use quadloom_param::{GRID_UNIT, IntegerGridMap, LatticePoint, Transition};
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;

/// A corner joint with three arms; the one upwards is open at its end.
const VOXELS: [[i64; 3]; 6] = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 2]];
/// Height of the open end, voxels.
const OPEN_AT: i64 = 2;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().unwrap_or_else(|| "demo.html".into());
    let cells = arguments.next().map_or(Ok(16), |n| n.parse::<i64>())?.clamp(2, 256) / 2 * 2;
    std::fs::write(path, view::render_html(&demo_scene(cells)?))?;
    Ok(())
}

/// The whole scene with `cells` triangulated cells per voxel side, two per quad side.
fn demo_scene(cells: i64) -> Result<Scene, Box<dyn Error>> {
    let shape = Shape::new(cells);
    let mesh = TriMesh::new(shape.positions.clone(), &shape.triangles())?;
    let map = shape.map(&mesh)?;
    let (features, _) = FeatureGraph::detect(&mesh, &Default::default());
    if let Some(defect) = map.check(&mesh, &features).first() {
        return Err(format!("the generated map is wrong: {defect}").into());
    }
    let quads = shape.quads()?;
    let singularities = view::irregular_vertices(&quads);
    let target = 2.0 / cells as f64;
    Ok(Scene {
        title: "Three arms".into(),
        input: Some(SurfaceLayer::of(&mesh)),
        statistics: figures(&mesh, &quads, singularities.len()),
        singularities,
        features: view::feature_lines(&mesh, &features),
        boundary: view::boundary_lines(&mesh),
        seams: view::seams(&mesh, &map),
        crosses: view::crosses(&mesh, &field_of(&mesh, &map), 1500),
        uv_isolines: view::isolines(&mesh, &map),
        histograms: view::quad_histograms(&quads, Some(target)),
        quads: Some(QuadLayer::of(&quads)),
        ..Scene::default()
    })
}

fn figures(mesh: &TriMesh, quads: &QuadMesh, irregular: usize) -> Vec<(String, String)> {
    let chi = quads.vertex_count() as i64 - quads.edge_count() as i64 + quads.face_count() as i64;
    let jacobians = view::scaled_jacobians(quads);
    let mean = jacobians.iter().sum::<f64>() / jacobians.len() as f64;
    let worst = jacobians.iter().copied().fold(f64::INFINITY, f64::min);
    [
        ("Input triangles", mesh.face_count().to_string()),
        ("Quads", quads.face_count().to_string()),
        ("Euler characteristic", chi.to_string()),
        ("Boundary loops", view::boundary_lines(mesh).len().to_string()),
        ("Irregular vertices", irregular.to_string()),
        ("Scaled Jacobian, mean", format!("{mean:.4}")),
        ("Scaled Jacobian, worst", format!("{worst:.4}")),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .to_vec()
}

/// The surface of the voxels as a grid of cells.
struct Shape {
    positions: Vec<DVec3>,
    sides: Vec<Side>,
    cells: i64,
}

/// One square side of a voxel: its grid of vertices, row by row.
struct Side {
    vertices: Vec<u32>,
}

impl Shape {
    fn new(cells: i64) -> Self {
        let mut ids = BTreeMap::new();
        let mut sides = Vec::new();
        for (origin, u, v) in voxel_sides() {
            let place = |i: i64, j: i64| [0, 1, 2].map(|k| origin[k] * cells + u[k] * i + v[k] * j);
            let grid = (0..=cells).flat_map(|j| (0..=cells).map(move |i| place(i, j)));
            let vertices = grid
                .map(|p| {
                    let next = ids.len() as u32;
                    *ids.entry(p).or_insert(next)
                })
                .collect();
            sides.push(Side { vertices });
        }
        let mut lattice: Vec<_> = ids.into_iter().map(|(p, id)| (id, p)).collect();
        lattice.sort_unstable();
        let lattice: Vec<[i64; 3]> = lattice.into_iter().map(|(_, p)| p).collect();
        let positions = lattice.iter().map(|p| DVec3::from_array(p.map(|x| x as f64 / cells as f64))).collect();
        let mut shape = Self { positions, sides, cells };
        shape.smooth(&lattice);
        shape
    }

    /// Vertex (i, j) of a side's grid.
    fn vertex(&self, side: &Side, i: i64, j: i64) -> u32 {
        side.vertices[(j * (self.cells + 1) + i) as usize]
    }

    /// Corners of all cells of `step` × `step`, side by side.
    fn cells(&self, step: i64) -> impl Iterator<Item = (&Side, [i64; 2], [u32; 4])> {
        let starts = move || (0..self.cells / step).map(move |i| i * step);
        self.sides.iter().flat_map(move |side| {
            starts().flat_map(move |j| {
                starts().map(move |i| {
                    let corner = [(i, j), (i + step, j), (i + step, j + step), (i, j + step)];
                    (side, [i, j], corner.map(|(i, j)| self.vertex(side, i, j)))
                })
            })
        })
    }

    /// Laplacian smoothing; the rims of foot and opening move within themselves, the foot stays flat.
    fn smooth(&mut self, lattice: &[[i64; 3]]) {
        let level = |v: u32| lattice[v as usize][1];
        let mut edges = BTreeSet::new();
        let mut sides_of = BTreeMap::<[u32; 2], usize>::new();
        let mut on_wall = vec![false; lattice.len()];
        for (_, _, q) in self.cells(1) {
            let flat = q.iter().all(|&v| level(v) == 0);
            for k in 0..4 {
                let (a, b) = (q[k].min(q[(k + 1) % 4]), q[k].max(q[(k + 1) % 4]));
                edges.insert([a, b]);
                *sides_of.entry([a, b]).or_default() += 1;
                on_wall[q[k] as usize] |= !flat;
            }
        }
        let rim: Vec<bool> = (0..lattice.len() as u32)
            .map(|v| on_wall[v as usize] && (level(v) == 0 || level(v) == OPEN_AT * self.cells))
            .collect();
        let mut neighbours = vec![Vec::new(); lattice.len()];
        for [a, b] in edges {
            let along = level(a) == level(b) && (level(a) == 0 || sides_of[&[a, b]] == 1);
            for (v, w) in [(a, b), (b, a)] {
                if !rim[v as usize] || (along && rim[w as usize]) {
                    neighbours[v as usize].push(w);
                }
            }
        }
        for _ in 0..self.cells * self.cells / 3 {
            let mean = |v: usize| {
                let around = neighbours[v].iter().map(|&w| self.positions[w as usize]);
                around.sum::<DVec3>() / neighbours[v].len() as f64
            };
            self.positions = (0..lattice.len()).map(|v| 0.4 * self.positions[v] + 0.6 * mean(v)).collect();
        }
    }

    fn triangles(&self) -> Vec<[u32; 3]> {
        self.cells(1).flat_map(|(_, _, [a, b, c, d])| [[a, b, c], [a, c, d]]).collect()
    }

    /// The quads, whose vertices are every second one of the grid.
    fn quads(&self) -> Result<QuadMesh, Box<dyn Error>> {
        let mut ids = BTreeMap::new();
        let mut positions = Vec::new();
        let mut faces = Vec::new();
        for (_, _, corners) in self.cells(2) {
            faces.push(corners.map(|v| {
                *ids.entry(v).or_insert_with(|| {
                    positions.push(self.positions[v as usize]);
                    positions.len() as u32 - 1
                })
            }));
        }
        Ok(QuadMesh::new(positions, &faces)?)
    }

    /// Every side of a voxel in its own chart, two cells per grid unit.
    fn map(&self, mesh: &TriMesh) -> Result<IntegerGridMap, Box<dyn Error>> {
        let at = |i: i64, j: i64| [i * GRID_UNIT / 2, j * GRID_UNIT / 2];
        let corners = self.cells(1).flat_map(|(_, [i, j], _)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [a, b, c, a, c, d]
        });
        let uv = CornerMap::from_vec(corners.collect());
        let mut transition = HalfEdgeMap::filled(mesh.half_edge_count(), Transition::IDENTITY);
        for h in mesh.half_edges() {
            transition[h] = transition_across(mesh, &uv, h).ok_or("the charts of two voxel sides do not fit")?;
        }
        Ok(IntegerGridMap { uv, transition })
    }
}

/// Sides of voxels that no other voxel covers, as origin and two axes with the normal outwards; the open end left out.
fn voxel_sides() -> Vec<([i64; 3], [i64; 3], [i64; 3])> {
    let unit = |k: usize| [0, 1, 2].map(|i| i64::from(i == k));
    let mut sides = Vec::new();
    for voxel in VOXELS {
        for axis in 0..3 {
            for outward in [-1, 1] {
                let across = [0, 1, 2].map(|k| voxel[k] + outward * unit(axis)[k]);
                let shift = i64::from(outward == 1);
                let origin = [0, 1, 2].map(|k| voxel[k] + shift * unit(axis)[k]);
                let open = axis == 1 && outward == 1 && origin[1] == OPEN_AT;
                if !VOXELS.contains(&across) && !open {
                    let (u, v) = (unit((axis + 1) % 3), unit((axis + 2) % 3));
                    sides.push(if outward == 1 { (origin, u, v) } else { (origin, v, u) });
                }
            }
        }
    }
    sides
}

/// The grid automorphism that carries one image of an edge onto the other.
fn transition_across(mesh: &TriMesh, uv: &CornerMap<LatticePoint>, h: HalfEdgeId) -> Option<Transition> {
    let Some(twin) = mesh.twin(h) else { return Some(Transition::IDENTITY) };
    let (from, to) = ([uv[h], uv[mesh.next(h)]], [uv[mesh.next(twin)], uv[twin]]);
    (0..4u8).find_map(|quarter_turns| {
        let turned = Transition { quarter_turns, translation: [0, 0] }.apply(from[0]);
        let t = Transition { quarter_turns, translation: [to[0][0] - turned[0], to[0][1] - turned[1]] };
        (t.apply(from[1]) == to[1]).then_some(t)
    })
}

/// Direction of growing u in the frame of every face, radians.
fn field_of(mesh: &TriMesh, map: &IntegerGridMap) -> FaceMap<f64> {
    let direction = |f: FaceId| {
        let uv = map.face_uv(mesh, f).map(|p| p.map(|x| x as f64 / GRID_UNIT as f64));
        let p = mesh.face_vertices(f).map(|v: VertexId| mesh.position(v));
        // ∂p/∂u of the linear map from parameters to space, up to a positive factor.
        (p[1] - p[0]) * (uv[2][1] - uv[0][1]) - (p[2] - p[0]) * (uv[1][1] - uv[0][1])
    };
    FaceMap::from_fn(mesh.face_count(), |f| FaceFrame::of(mesh, f).angle_of(direction(f)))
}
