//! A source map drawn on the tube surface of a target.
//!
//! In: a source map, a [`TubeMatch`], where each point of each quarter-tube is in space. Out: [`Drawing`]: a closed triangle
//! mesh whose every triangle lies in one flag of the source.
//! Holds: the mesh is a closed manifold; [`Drawing::check`] tests the drawn map against the source by the mesh alone.
//! Not: self-intersection, which the surface decides.
//! Source: [Razafindrazaka2015] §9.5: the tiling is clipped against the fundamental quadrilateral once and placed on every
//! quarter-tube by its group element.

mod cells;
mod check;
mod local;
mod refine;
mod slivers;
mod strips;
mod triangulate;

pub use check::{DrawingDefect, DrawnCounts};
pub use strips::{Drawn, EdgeStyle};

use crate::error::MapError;
use crate::ids::FlagId;
use crate::map::{Reflection, RegularMap};
use crate::matching::TubeMatch;
use crate::plane::Plane;
use crate::skeleton::Skeleton;
use cells::Weights;
use glam::{DVec2, DVec3};
use local::LocalPicture;
use quadloom_mesh::{FaceMap, HalfEdgeId, Id, MeshError, TriMesh, VertexId, VertexMap};
use rayon::prelude::*;
use strips::Strips;

/// How a map is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawOptions {
    /// The map or its dual. Default: the map.
    pub drawn: Drawn,
    /// How edges look. Default: flat bands, 0.12 of the way to the face's centre.
    pub edges: EdgeStyle,
    /// Height of ridges and reliefs above the surface, units of the surface. Default 0.
    pub height: f64,
    /// Cells along and around a quarter-tube: corners of cells lie on the surface, the two triangles of a cell are flat.
    /// Default 8 and 8; triangles grow with their product.
    pub steps: [usize; 2],
}

impl DrawOptions {
    fn cells(&self) -> [usize; 2] {
        self.steps.map(|n| n.max(1))
    }
}

impl Default for DrawOptions {
    fn default() -> Self {
        Self { drawn: Drawn::Map, edges: EdgeStyle::Bands(0.12), height: 0.0, steps: [8, 8] }
    }
}

/// A map drawn on a surface.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// The surface: vertices lie on the smooth tubes.
    pub mesh: TriMesh,
    /// Where vertices would lie on the flat triangles of cells: there, triangles do not overlap, however thin they are.
    pub flat: VertexMap<DVec3>,
    /// The flag of the source that each triangle lies in.
    pub flag: FaceMap<FlagId>,
    /// The quarter-tube of the target that each triangle lies on.
    pub quarter: FaceMap<FlagId>,
    /// Whether each triangle belongs to an edge's band.
    pub is_edge: FaceMap<bool>,
    /// Map or dual.
    pub drawn: Drawn,
}

/// Why a map could not be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DrawError {
    /// The picture on a quarter-tube does not close.
    #[error(transparent)]
    Map(#[from] MapError),
    /// Neighbouring quarter-tubes do not fit together.
    #[error("the pictures on neighbouring quarter-tubes do not fit together along side {0}")]
    Sides(char),
    /// The drawn triangles are no closed surface.
    #[error("the drawn triangles are no surface: {0}")]
    Mesh(#[from] MeshError),
    /// The drawn map is another one.
    #[error("the drawn map is not the source: {0}")]
    Defect(#[from] DrawingDefect),
}

/// Draws a map on a tube surface and checks what was drawn.
///
/// # Input      `place`: point and outward unit normal of the surface at (u, v) of a quarter-tube, named by its flag of the
///   target; it agrees along sides that are glued
/// # Output     the drawing and what was counted on it
/// # Errors     [`DrawError`]
/// # Cost       linear in the triangles, |H| times those of one quarter-tube
/// # Source     [Razafindrazaka2015] §9.5, Fig. 9.17
pub fn draw(
    source: &RegularMap,
    found: &TubeMatch,
    place: impl Fn(FlagId, f64, f64) -> (DVec3, DVec3) + Sync,
    options: &DrawOptions,
) -> Result<(Drawing, DrawnCounts), DrawError> {
    let plane = Plane::of_type(source.p(), source.q());
    let strips = Strips::new(options.drawn, options.edges);
    // 1. Clip once.
    let picture = LocalPicture::new(source, &plane, &found.quadrilateral, &strips, options.cells())?;
    // 2. Glue the copies.
    let glue = Glue::new(&picture, &found.target)?;
    // 3. Place them.
    let drawing = glue.drawing(source, found, &picture, &strips, place, options)?;
    let counts = drawing.check(source)?;
    Ok((drawing, counts))
}

/// Which vertices of the copies are the same.
struct Glue {
    /// For each copy (flag of the target) and point of the picture, the vertex of the drawing.
    vertex: Vec<u32>,
    /// Copy and point that a vertex takes its place from.
    origin: Vec<(FlagId, u32)>,
    points: usize,
}

impl Glue {
    fn new(picture: &LocalPicture, target: &RegularMap) -> Result<Self, DrawError> {
        let points = picture.points.len();
        let pairs = glued_sides(picture)?;
        let mut root: Vec<u32> = (0..(points * target.order()) as u32).collect();
        for flag in target.flags() {
            for (by, list) in &pairs {
                let there = target.reflect(flag, *by);
                for &(here, other) in list {
                    let [a, b] = [(flag, here), (there, other)].map(|(f, i)| (f.index() * points) as u32 + i);
                    join(&mut root, a, b);
                }
            }
        }
        let mut origin = Vec::new();
        let mut vertex = vec![0; root.len()];
        for k in 0..root.len() as u32 {
            let to = find(&mut root, k);
            if to == k {
                vertex[k as usize] = origin.len() as u32;
                origin.push((FlagId(k / points as u32), k % points as u32));
            } else {
                vertex[k as usize] = vertex[to as usize];
            }
        }
        Ok(Self { vertex, origin, points })
    }

    fn drawing(
        &self,
        source: &RegularMap,
        found: &TubeMatch,
        picture: &LocalPicture,
        strips: &Strips,
        place: impl Fn(FlagId, f64, f64) -> (DVec3, DVec3) + Sync,
        options: &DrawOptions,
    ) -> Result<Drawing, DrawError> {
        // 1. Where vertices lie: in flat cells, and on the smooth surface.
        let sheet = Flat::new(&found.target, options.cells(), &place);
        let uv = |i: u32| picture.points[i as usize].uv;
        let flat: Vec<(DVec3, DVec3)> = self.origin.par_iter().map(|&(flag, i)| sheet.at(flag, uv(i))).collect();
        let smooth = |&(flag, i): &(FlagId, u32)| place(flag, uv(i).x, uv(i).y);
        let smooth: Vec<(DVec3, DVec3)> = self.origin.par_iter().map(smooth).collect();
        let (positions, normals): (Vec<DVec3>, Vec<DVec3>) = flat.iter().copied().unzip();
        // 2. Triangles: which flag, quarter-tube and strip each lies in.
        let labels = |&quarter: &FlagId| {
            let image = source.automorphism(found.element[quarter]);
            picture.triangles.iter().map(move |t| (image[t.flag.index()], quarter, t.strip)).collect::<Vec<_>>()
        };
        let quarters: Vec<FlagId> = found.target.flags().collect();
        let labels: Vec<_> = quarters.iter().flat_map(labels).collect();
        let corners = |quarter: FlagId| {
            let first = quarter.index() * self.points;
            picture.triangles.iter().map(move |t| t.corners.map(|i| self.vertex[first + i as usize]))
        };
        let faces: Vec<[u32; 3]> = quarters.iter().flat_map(|&quarter| corners(quarter)).collect();
        // 3. Without slivers.
        let regions: Vec<u32> =
            labels.iter().map(|&(flag, _, strip)| flag.0 * u32::from(u8::MAX) + u32::from(strip)).collect();
        let left = slivers::Sheet::new(&positions, &normals, &faces, &regions).without_slivers();
        // 4. The relief.
        let height = |k: usize| options.height * picture.points[self.origin[k].1 as usize].height;
        let raised = |places: &[(DVec3, DVec3)]| -> Vec<DVec3> {
            places.iter().enumerate().map(|(k, (position, normal))| *position + height(k) * *normal).collect()
        };
        let (kept, faces) = used(positions.len(), left.iter().map(|(corners, _)| *corners));
        let of = |all: Vec<DVec3>| -> Vec<DVec3> { kept.iter().map(|&v| all[v]).collect() };
        let label = left.iter().map(|(_, first)| labels[*first as usize]);
        Ok(Drawing {
            mesh: TriMesh::new(of(raised(&smooth)), &faces)?,
            flat: VertexMap::from_vec(of(raised(&flat))),
            flag: FaceMap::from_vec(label.clone().map(|(flag, ..)| flag).collect()),
            quarter: FaceMap::from_vec(label.clone().map(|(_, quarter, _)| quarter).collect()),
            is_edge: FaceMap::from_vec(label.map(|(.., strip)| strips.is_edge(strip)).collect()),
            drawn: options.drawn,
        })
    }
}

/// Vertices that triangles have, and triangles in their numbers.
fn used(count: usize, faces: impl Iterator<Item = [u32; 3]> + Clone) -> (Vec<usize>, Vec<[u32; 3]>) {
    let mut number = vec![None; count];
    faces.clone().flatten().for_each(|v| number[v as usize] = Some(0));
    let mut kept = Vec::with_capacity(count);
    for (v, new) in number.iter_mut().enumerate().filter(|(_, new)| new.is_some()) {
        *new = Some(kept.len() as u32);
        kept.push(v);
    }
    let renamed = faces.map(|t| t.map(|v| number[v as usize].unwrap_or(0))).collect();
    (kept, renamed)
}

/// The surface as flat triangles between the nodes of a grid.
struct Flat {
    cells: [usize; 2],
    nodes: Vec<(DVec3, DVec3)>,
}

impl Flat {
    fn new(
        target: &RegularMap,
        cells: [usize; 2],
        place: &(impl Fn(FlagId, f64, f64) -> (DVec3, DVec3) + Sync),
    ) -> Self {
        let [n, m] = cells;
        let node = |k: usize| {
            let (flag, at) = (FlagId::new(k / ((n + 1) * (m + 1))), k % ((n + 1) * (m + 1)));
            place(flag, (at % (n + 1)) as f64 / n as f64, (at / (n + 1)) as f64 / m as f64)
        };
        Self { cells, nodes: (0..target.order() * (n + 1) * (m + 1)).into_par_iter().map(node).collect() }
    }

    /// Point and normal.
    fn at(&self, flag: FlagId, uv: DVec2) -> (DVec3, DVec3) {
        let [n, m] = self.cells;
        let Weights { nodes, shares } = Weights::of(uv, self.cells);
        let node = |[i, j]: [usize; 2]| self.nodes[(flag.index() * (m + 1) + j) * (n + 1) + i];
        let mean = |of: fn((DVec3, DVec3)) -> DVec3| (0..3).map(|k| shares[k] * of(node(nodes[k]))).sum::<DVec3>();
        (mean(|node| node.0), mean(|node| node.1).normalize_or(DVec3::Z))
    }
}

type Pairs = Vec<(u32, u32)>;

/// Points that are the same on a quarter-tube and on its neighbour: a and c to themselves, turned round; d to b.
fn glued_sides(picture: &LocalPicture) -> Result<[(Reflection, Pairs); 3], DrawError> {
    let [a, b, c, d] = picture.sides();
    let along =
        |list: &[u32], k: usize| -> Vec<f64> { list.iter().map(|&i| picture.points[i as usize].uv[k]).collect() };
    let turned = |list: &[u32]| list.iter().rev().copied().collect::<Vec<_>>();
    let alike = |one: Vec<f64>, other: Vec<f64>| {
        one.len() == other.len() && one.iter().zip(&other).all(|(x, y)| (x - y).abs() < 1e-5)
    };
    let mirrored = |list: &[u32]| along(&turned(list), 1).into_iter().map(|v| 1.0 - v).collect::<Vec<_>>();
    for (side, fits) in [
        ('a', alike(along(&a, 1), mirrored(&a))),
        ('c', alike(along(&c, 1), mirrored(&c))),
        ('d', alike(along(&d, 0), along(&b, 0))),
    ] {
        if !fits {
            return Err(DrawError::Sides(side));
        }
    }
    let zip = |one: &[u32], other: &[u32]| one.iter().copied().zip(other.iter().copied()).collect::<Vec<_>>();
    Ok([(Reflection::R1, zip(&a, &turned(&a))), (Reflection::R0, zip(&c, &turned(&c))), (Reflection::R2, zip(&d, &b))])
}

fn find(root: &mut [u32], mut x: u32) -> u32 {
    while root[x as usize] != x {
        root[x as usize] = root[root[x as usize] as usize];
        x = root[x as usize];
    }
    x
}

fn join(root: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(root, a), find(root, b));
    root[a.max(b) as usize] = a.min(b);
}

impl Drawing {
    /// The drawn map's edge graph in space, with the surface's normals: what the next tubes can be put around.
    ///
    /// # Input      the source map; it gives the skeleton of the source, or of its dual where that is drawn
    /// # Source     [Razafindrazaka2015] §9.2, the sequence of maps M_i
    pub fn skeleton(&self, source: &RegularMap) -> Result<Skeleton, DrawError> {
        skeleton_of(self, source)
    }
}

/// A way along the drawn edges.
fn skeleton_of(drawing: &Drawing, source: &RegularMap) -> Result<Skeleton, DrawError> {
    let lines = drawing.lines(source)?;
    let mesh = &drawing.mesh;
    let (map, across) = match drawing.drawn {
        Drawn::Map => (source.clone(), Reflection::R2),
        Drawn::Dual => (source.dual(), Reflection::R0),
    };
    // Flags of the dual have other numbers; both are numbered from flag 0 by the same words.
    let renumbered = |g: FlagId| match drawing.drawn {
        Drawn::Map => g,
        Drawn::Dual => {
            let word: Vec<_> = source.reflections_of(g).into_iter().map(Reflection::dual).collect();
            map.walk(FlagId(0), &word)
        }
    };
    let number: Vec<FlagId> = source.flags().map(renumbered).collect();
    let is_edge = |h: HalfEdgeId| lines[h.index()] == Some(across);
    let mut positions = vec![None; map.vertex_count()];
    let mut normals = vec![DVec3::Z; map.vertex_count()];
    let mut edges = vec![Vec::new(); map.edge_count()];
    let firsts = crate::skeleton::upright_flags(&map);
    for h in mesh.half_edges().filter(|&h| is_edge(h)) {
        // A line starts where the flag left of it changes its vertex: the flags before and after it differ by r₁.
        let flag = number[drawing.flag[mesh.face(h)].index()];
        if !starts_at_vertex(mesh, &lines, h) {
            continue;
        }
        let v = mesh.origin(h);
        let vertex = map.vertex(flag);
        positions[vertex.index()] = Some(v);
        // The face left of a line that goes out is that of an upright flag where orientation and numbering agree.
        let outward = vertex_normal(mesh, v);
        normals[vertex.index()] = if firsts[flag] { outward } else { -outward };
        if crate::skeleton::starts_here(&map, flag) {
            edges[map.edge(flag).index()] = follow(mesh, &lines, h);
        }
    }
    let at = |v: &Option<VertexId>| v.map_or(DVec3::ZERO, |v| mesh.position(v));
    let positions = positions.iter().map(at).collect();
    let edges = edges.iter().map(|line: &Vec<VertexId>| line.iter().map(|&v| mesh.position(v)).collect()).collect();
    Ok(Skeleton { positions, normals, edges })
}

/// Whether a half-edge along an edge of the map starts at a vertex of the map: the line behind it is not its mirror image.
fn starts_at_vertex(mesh: &TriMesh, lines: &[Option<Reflection>], h: HalfEdgeId) -> bool {
    // Around the origin, a vertex of the map has r₁-lines; an edge's midpoint has r₀-lines (or r₂ in the dual) alone.
    mesh.outgoing(mesh.origin(h)).any(|k| lines[k.index()] == Some(Reflection::R1))
}

/// The vertices along a line of the map from a vertex to the next.
fn follow(mesh: &TriMesh, lines: &[Option<Reflection>], start: HalfEdgeId) -> Vec<VertexId> {
    let across = lines[start.index()];
    let mut path = vec![mesh.origin(start)];
    let mut at = start;
    loop {
        let v = mesh.target(at);
        path.push(v);
        let back = mesh.twin(at);
        let onward = mesh.outgoing(v).find(|&h| lines[h.index()] == across && Some(h) != back);
        let ends = mesh.outgoing(v).any(|k| lines[k.index()] == Some(Reflection::R1));
        match onward {
            Some(next) if !ends && path.len() <= mesh.vertex_count() => at = next,
            _ => return path,
        }
    }
}

fn vertex_normal(mesh: &TriMesh, v: VertexId) -> DVec3 {
    mesh.outgoing(v).map(|h| mesh.vector_area(mesh.face(h))).sum::<DVec3>().normalize_or(DVec3::Z)
}
