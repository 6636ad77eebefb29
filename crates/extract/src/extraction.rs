//! From an integer-grid map to a quad mesh.
//!
//! In: a triangle mesh, its integer-grid map, its features. Out: [`Extraction`], or an [`ExtractError`] that says where.
//! Holds: a valid map yields exactly its grid; every decision is integer arithmetic; the result is pure quads,
//! oriented, manifold, with chi, components and boundary loops of the input. Local fold-overs are survived where
//! contracting them leaves quads or small even polygons.
//! Source: [Ebke2013] for the task and the port idea; contraction of a ribbon graph in place of their case analysis own.

use crate::grid_points::{Carrier, GridPoint, GridPoints};
use crate::lattice::{COORDINATE_LIMIT, DIRECTION, GridSegment, difference};
use crate::mend::{fill_polygons, open_bad_faces};
use crate::ports::{Ports, Site};
use crate::ribbon::{NONE, Orbit, Ribbon};
use crate::walk::{Arrival, Walker};
use quadloom_mesh::topology::Summary;
use quadloom_mesh::{
    Cancelled, ChainId, DVec3, EdgeId, EdgeMap, FaceId, FaceMap, FeatureGraph, HalfEdgeId, MeshError, Progress,
    QuadMesh, SurfacePoint, TriMesh, VertexId, VertexMap,
};
use quadloom_param::integer_grid_map::signed_area;
use quadloom_param::{GRID_UNIT, IntegerGridMap, MapDefect};
use serde::{Deserialize, Serialize};

/// What ties a quad vertex to the features of the mesh it was extracted from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Placement {
    /// At this feature corner.
    Corner(VertexId),
    /// On a feature chain.
    Chain {
        /// The chain.
        chain: ChainId,
        /// The mesh edge of the chain that carries the vertex.
        edge: EdgeId,
        /// Where on the edge, 0 at the origin of its canonical half-edge, 1 at the target.
        parameter: f64,
    },
    /// On the smooth surface.
    Free,
}

/// Corners of a quad on the grid, grid units, in the chart of the face that carries its first corner.
pub type GridSquare = [[i32; 2]; 4];

/// A quad mesh with the way back to the triangle mesh it came from.
#[derive(Clone, Debug)]
pub struct Extraction {
    /// The quads.
    pub mesh: QuadMesh,
    /// Where each vertex lies on the triangle mesh.
    pub origin: VertexMap<SurfacePoint>,
    /// What each vertex is tied to.
    pub placement: VertexMap<Placement>,
    /// The chain that each quad edge runs along from end to end, if it does.
    pub feature_edges: EdgeMap<Option<ChainId>>,
    /// Grid coordinates of each quad; `None` for quads that fill a fold.
    pub grid: FaceMap<Option<GridSquare>>,
    /// What happened.
    pub report: ExtractReport,
}

/// What happened during extraction.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExtractReport {
    /// Faces of the map with non-positive orientation.
    pub inverted_faces: usize,
    /// Vertices off the grid whose triangles wind around them more than once: folds without an inverted triangle.
    pub overwound: usize,
    /// Preimages of grid points that were contracted into another one, through folds.
    pub contracted: usize,
    /// Grid lines that led nowhere in degenerate parts of the map.
    pub lost: usize,
    /// Grid lines that left the surface: the map is not aligned to the boundary there, quads across it are missing.
    pub trimmed: usize,
    /// Edges and vertices taken away because they had fewer than three quads around them, or led nowhere.
    pub simplified: usize,
    /// Edges taken away because their faces could not become quads.
    pub mended: usize,
    /// Quads that fill polygons left by folds.
    pub filled: usize,
    /// Feature edges of the mesh that are not on integer iso-lines.
    pub unaligned_features: usize,
    /// Feature edges of the mesh.
    pub feature_edges: usize,
    /// Feature edges of the mesh that grid lines follow.
    pub followed_features: usize,
}

/// Why there is no quad mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExtractError {
    /// The map is not even seamless: extraction would be meaningless.
    #[error("the map is not an integer-grid map: {} ({} such defects)", .0[0], .0.len())]
    Map(Vec<MapDefect>),
    /// A coordinate is too large for exact arithmetic.
    #[error(
        "corner {corner} of the map is {grid_units} grid units from the origin; at most 67 million can be decided exactly"
    )]
    Range {
        /// The corner.
        corner: HalfEdgeId,
        /// Its larger coordinate.
        grid_units: i64,
    },
    /// The map asks for more quads than the limit.
    #[error("the map has about {quads} quads, more than the limit of {limit}; use a larger edge length")]
    TooMany {
        /// Area of the map.
        quads: u64,
        /// The limit.
        limit: u64,
    },
    /// Grid lines do not close to quads, and the hole is too large or odd.
    #[error("the grid does not close to quads at {count} places, the first near face {first} of the mesh (polygon of {sides} sides)", first = .faces.first().map_or(0, |f| f.0))]
    NotQuads {
        /// Number of polygons that could not be cut into quads.
        count: usize,
        /// Sides of the first one.
        sides: usize,
        /// Mesh faces that carry the vertices of these polygons, ascending, at most 1000.
        faces: Vec<FaceId>,
    },
    /// The quads are not a manifold.
    #[error("the extracted quads are not a mesh: {0}")]
    Mesh(#[from] MeshError),
    /// The quads have another topology than the mesh.
    #[error("the quads have chi {}, {} components, {} boundary loops; the mesh has {}, {}, {}", .found.chi, .found.components, .found.boundary_loops, .expected.chi, .expected.components, .expected.boundary_loops)]
    Topology {
        /// Topology of the triangle mesh.
        expected: Summary,
        /// Topology of the quads.
        found: Summary,
    },
    /// The caller or the time limit stopped the run.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// More quads than this are refused: their half-edges would not fit 32-bit ids with room to spare.
const QUAD_LIMIT: u64 = 100_000_000;

/// Rounds of opening bad faces: each adds a ring of quads to the holes.
const MEND_ROUNDS: usize = 3;

/// Ports between two looks at the cancellation flag.
const CHECK_INTERVAL: usize = 4096;

/// Extracts the quad mesh of an integer-grid map.
///
/// # Input      map: lattice coordinates per corner of `mesh`; features: those the map was aligned to
/// # Output     the quads, each vertex with its origin and placement; the report counts what was not perfect
/// # Errors     maps that are not seamless, grids that do not close to quads, wrong topology, cancellation
/// # Cost       linear in triangles, quads, and crossings of grid edges with triangles
/// # Guarantees exact for valid maps; a mesh that is returned has the topology of the input
/// # Source     [Ebke2013] §4; [Bommes2012] §6
pub fn extract(
    mesh: &TriMesh,
    map: &IntegerGridMap,
    features: &FeatureGraph,
    progress: &Progress,
) -> Result<Extraction, ExtractError> {
    progress.check()?;
    // 1. The map must be seamless; inverted faces and unaligned features are survivable.
    check_range(mesh, map)?;
    let mut report = check_map(mesh, map, features)?;
    let sign = FaceMap::from_fn(mesh.face_count(), |f| map.face_area(mesh, f).signum() as i8);
    // 2. Grid points, their ports, and the grid edges between them.
    let points = GridPoints::find(mesh, map);
    let ports = Ports::find(mesh, map, &sign, &points);
    let walker = Walker { mesh, map, sign: &sign, points: &points, ports: &ports, features };
    let mut ribbon = Ribbon::new(&ports.first, &ports.surrounded);
    let folds = connect(&walker, &mut ribbon, &mut report, progress)?;
    // 3. Folds are contracted, loose ends removed.
    let leader = contract_folds(&ports, &mut ribbon, folds, &mut report);
    progress.check()?;
    // 4. Polygons become quads.
    let places = Places::new(&walker, &leader);
    ribbon.vertex.iter_mut().for_each(|q| *q = places.of_point[*q as usize]);
    let mut extraction = close_to_quads(&walker, &mut ribbon, &places, &mut report)?;
    extraction.report = report;
    // 5. The topology must be that of the mesh.
    let (expected, found) = (Summary::of(mesh), Summary::of(&extraction.mesh));
    if (expected.chi, expected.components, expected.boundary_loops)
        != (found.chi, found.components, found.boundary_loops)
    {
        return Err(ExtractError::Topology { expected, found });
    }
    progress.report("extract", 1.0);
    Ok(extraction)
}

/// Removes what no quad mesh has, cuts polygons, and opens what still is no mesh, in a few rounds.
///
/// The sharpest cones of a map make vertices of one or two quads, which a plane quad mesh cannot have: they go too.
fn close_to_quads(
    walker: &Walker,
    ribbon: &mut Ribbon,
    places: &Places,
    report: &mut ExtractReport,
) -> Result<Extraction, ExtractError> {
    let is_tip = |v: u32| match placement(walker, &walker.points.points[v as usize]) {
        Placement::Corner(v) => angle_sum(walker.mesh, v) < TIP_ANGLE,
        _ => false,
    };
    let mut rounds = 0;
    loop {
        report.simplified += ribbon.simplify(is_tip);
        let filled = fill_polygons(ribbon, |v| places.position[v as usize]);
        if filled > 0 {
            report.filled += filled;
            report.simplified += ribbon.simplify(is_tip);
        }
        let made = assemble(walker, ribbon, places);
        if rounds == MEND_ROUNDS || !matches!(made, Err(ExtractError::NotQuads { .. } | ExtractError::Mesh(_))) {
            return made;
        }
        report.mended += open_bad_faces(ribbon);
        rounds += 1;
    }
}

/// Angle around a vertex below which two quads can meet there without either being inverted, radians.
const TIP_ANGLE: f64 = 1.6 * std::f64::consts::PI;

/// Sum of the angles of the faces at a vertex, radians.
fn angle_sum(mesh: &TriMesh, v: VertexId) -> f64 {
    let angle = |h: HalfEdgeId| {
        let [o, a, b] = [h, mesh.next(h), mesh.prev(h)].map(|c| mesh.position(mesh.origin(c)));
        (a - o).cross(b - o).length().atan2((a - o).dot(b - o))
    };
    mesh.outgoing(v).map(angle).sum()
}

/// Refuses maps whose coordinates or size defeat exact arithmetic or 32-bit ids.
fn check_range(mesh: &TriMesh, map: &IntegerGridMap) -> Result<(), ExtractError> {
    for (corner, p) in map.uv.iter() {
        let largest = p[0].unsigned_abs().max(p[1].unsigned_abs());
        if largest >= COORDINATE_LIMIT as u64 {
            return Err(ExtractError::Range { corner, grid_units: (largest / GRID_UNIT as u64) as i64 });
        }
    }
    let twice_area: u128 = mesh.faces().map(|f| map.face_area(mesh, f).unsigned_abs()).sum();
    let rows: u128 = mesh
        .faces()
        .map(|f| {
            let v = map.face_uv(mesh, f).map(|p| p[1]);
            v.into_iter().max().unwrap_or(0).abs_diff(v.into_iter().min().unwrap_or(0)) as u128
        })
        .sum();
    let unit = GRID_UNIT as u128;
    let quads = u64::try_from((twice_area / (2 * unit * unit)).max(rows / unit)).unwrap_or(u64::MAX);
    if quads > QUAD_LIMIT { Err(ExtractError::TooMany { quads, limit: QUAD_LIMIT }) } else { Ok(()) }
}

/// Counts the survivable defects of a map; the others are errors.
fn check_map(mesh: &TriMesh, map: &IntegerGridMap, features: &FeatureGraph) -> Result<ExtractReport, ExtractError> {
    let mut report = ExtractReport { feature_edges: features.edge_count(), ..Default::default() };
    let mut fatal = Vec::new();
    for defect in map.check(mesh, features) {
        match defect {
            MapDefect::Inverted(_) => report.inverted_faces += 1,
            MapDefect::Feature(_) => report.unaligned_features += 1,
            // Its transitions are those of a regular vertex, but its triangles wind around it more than once or not.
            MapDefect::FractionalSingularity(v) if map.cone(mesh, v) == 0 => report.overwound += 1,
            other => fatal.push(other),
        }
    }
    if fatal.is_empty() { Ok(report) } else { Err(ExtractError::Map(fatal)) }
}

/// Walks from every port that has no mate yet; returns the ports of edges that lead back through a fold.
fn connect(
    walker: &Walker,
    ribbon: &mut Ribbon,
    report: &mut ExtractReport,
    progress: &Progress,
) -> Result<Vec<u32>, ExtractError> {
    let mut folds = Vec::new();
    let (mut lost, mut outside) = (Vec::new(), Vec::new());
    let (mut followed, mut on_way) = (EdgeMap::filled(walker.mesh.edge_count(), false), Vec::new());
    for p in 0..ribbon.len() as u32 {
        if (p as usize).is_multiple_of(CHECK_INTERVAL) {
            progress.check()?;
        }
        if ribbon.mate[p as usize] != NONE {
            continue;
        }
        on_way.clear();
        let arrival = walker.walk(p, &mut on_way);
        on_way.iter().for_each(|&e| followed[e] = true);
        match arrival {
            Arrival::Next(q, chain) if q != p && ribbon.mate[q as usize] == NONE => ribbon.join(p, q, chain),
            Arrival::Back(q) if q != p && ribbon.mate[q as usize] == NONE => {
                ribbon.join(p, q, None);
                folds.push(p);
            }
            Arrival::Outside => outside.push(p),
            _ => lost.push(p),
        }
    }
    // Later walks may have arrived at a port that led nowhere itself.
    for (list, opens) in [(&mut lost, false), (&mut outside, true)] {
        list.retain(|&p| ribbon.mate[p as usize] == NONE);
        list.iter().for_each(|&p| ribbon.remove_port(p, opens));
    }
    (report.lost, report.trimmed) = (lost.len(), outside.len());
    report.followed_features = followed.values().iter().filter(|&&on| on).count();
    Ok(folds)
}

/// Contracts edges of length zero; returns the leading grid point of each grid point.
fn contract_folds(ports: &Ports, ribbon: &mut Ribbon, folds: Vec<u32>, report: &mut ExtractReport) -> Vec<u32> {
    let mut leader: Vec<u32> = (0..ports.surrounded.len() as u32).collect();
    fn root(leader: &mut [u32], mut q: u32) -> u32 {
        while leader[q as usize] != q {
            leader[q as usize] = leader[leader[q as usize] as usize];
            q = leader[q as usize];
        }
        q
    }
    let mut loops = Vec::new();
    for p in folds {
        let mate = ribbon.mate[p as usize];
        let [a, b] = [p, mate].map(|x| root(&mut leader, ports.list[x as usize].point));
        if a != b && ribbon.contract(p) {
            leader[a.max(b) as usize] = a.min(b);
            report.contracted += 1;
        } else {
            loops.push(p);
        }
    }
    ribbon.remove_monogons(loops.clone());
    // A loop that encloses something is not a fold that can be flattened.
    for p in loops {
        if ribbon.is_alive(p) {
            ribbon.remove_edge(p, false);
            report.lost += 1;
        }
    }
    (0..leader.len() as u32).map(|q| root(&mut leader, q)).collect()
}

/// The grid point that stands for each group of contracted ones, and where it lies.
struct Places {
    /// Representative of each grid point.
    of_point: Vec<u32>,
    origin: Vec<SurfacePoint>,
    position: Vec<DVec3>,
}

impl Places {
    /// In a group the point most strongly tied to features stands for all; among equals one of positive orientation,
    /// then the one with the smallest number.
    fn new(walker: &Walker, leader: &[u32]) -> Self {
        let points = &walker.points.points;
        let mut best = vec![NONE; points.len()];
        let rank = |q: u32| {
            let point = &points[q as usize];
            let tie = match placement(walker, point) {
                Placement::Corner(_) => 0,
                Placement::Chain { .. } => 1,
                Placement::Free => 2,
            };
            (tie, -walker.sign[point.face], q)
        };
        for (q, &l) in leader.iter().enumerate() {
            let slot = &mut best[l as usize];
            if *slot == NONE || (l as usize != q && rank(q as u32) < rank(*slot)) {
                *slot = q as u32;
            }
        }
        let origin: Vec<SurfacePoint> = points.iter().map(|p| surface_point(walker, p)).collect();
        let position = points.iter().zip(&origin).map(|(p, o)| position(walker, p, o)).collect();
        Self { of_point: leader.iter().map(|&l| best[l as usize]).collect(), origin, position }
    }
}

fn placement(walker: &Walker, point: &GridPoint) -> Placement {
    let (mesh, features) = (walker.mesh, walker.features);
    match point.carrier {
        Carrier::Vertex(v) if features.is_corner[v] => Placement::Corner(v),
        Carrier::Vertex(v) => {
            let on = mesh.vertex_edges(v).find_map(|e| features.chain_of[e].map(|chain| (chain, e)));
            on.map_or(Placement::Free, |(chain, edge)| {
                let parameter = if mesh.ends(edge)[0] == v { 0.0 } else { 1.0 };
                Placement::Chain { chain, edge, parameter }
            })
        }
        Carrier::Edge(edge) => features.chain_of[edge].map_or(Placement::Free, |chain| Placement::Chain {
            chain,
            edge,
            parameter: edge_parameter(walker, edge, point),
        }),
        Carrier::Face(_) => Placement::Free,
    }
}

/// Where on an edge a grid point lies, in 0..=1.
fn edge_parameter(walker: &Walker, e: EdgeId, point: &GridPoint) -> f64 {
    let h = walker.mesh.half_edge(e);
    let (a, b) = (walker.map.uv[h], walker.map.uv[walker.mesh.next(h)]);
    let (d, t) = (difference(a, b), difference(a, point.at));
    let k = usize::from(d[1].abs() > d[0].abs());
    t[k] as f64 / d[k] as f64
}

fn surface_point(walker: &Walker, point: &GridPoint) -> SurfacePoint {
    let (mesh, face) = (walker.mesh, point.face);
    let corner = mesh.face_half_edges(face);
    let mut weights = [0.0; 3];
    match point.carrier {
        Carrier::Vertex(v) => {
            let k = corner.iter().position(|&h| mesh.origin(h) == v).unwrap_or(0);
            weights[k] = 1.0;
        }
        Carrier::Edge(e) => {
            let k = corner.iter().position(|&h| h == mesh.half_edge(e)).unwrap_or(0);
            let t = edge_parameter(walker, e, point);
            (weights[k], weights[(k + 1) % 3]) = (1.0 - t, t);
        }
        Carrier::Face(f) => {
            let [a, b, c] = walker.map.face_uv(mesh, f);
            let whole = signed_area(a, b, c) as f64;
            let [x, y] = [signed_area(point.at, b, c) as f64 / whole, signed_area(a, point.at, c) as f64 / whole];
            weights = [x, y, (1.0 - x - y).max(0.0)];
        }
    }
    SurfacePoint { face, weights }
}

/// Position of a grid point; exactly the mesh vertex's where it lies on one.
fn position(walker: &Walker, point: &GridPoint, origin: &SurfacePoint) -> DVec3 {
    let (mesh, positions) = (walker.mesh, walker.mesh.positions());
    let [a, b, c] = mesh.face_vertices(origin.face).map(|v| positions[v]);
    match point.carrier {
        Carrier::Vertex(v) => positions[v],
        _ => a * origin.weights[0] + b * origin.weights[1] + c * origin.weights[2],
    }
}

/// Closed faces as ports.
///
/// # Errors     faces that do not have four sides
fn collect_quads(ribbon: &Ribbon, places: &Places) -> Result<Vec<[u32; 4]>, ExtractError> {
    let mut quads = Vec::new();
    let (mut count, mut sides, mut faces) = (0, 0, Vec::new());
    for orbit in ribbon.orbits() {
        let Orbit::Closed(ports) = orbit else { continue };
        if let Ok(quad) = <[u32; 4]>::try_from(ports.as_slice()) {
            quads.push(quad);
            continue;
        }
        if count == 0 {
            sides = ports.len();
        }
        count += 1;
        faces.extend(ports.iter().map(|&p| places.origin[ribbon.vertex[p as usize] as usize].face));
    }
    if count == 0 {
        return Ok(quads);
    }
    faces.sort_unstable();
    faces.dedup();
    faces.truncate(1000);
    Err(ExtractError::NotQuads { count, sides, faces })
}

/// Numbers the vertices and builds the quad mesh with its maps; the report stays empty.
fn assemble(walker: &Walker, ribbon: &Ribbon, places: &Places) -> Result<Extraction, ExtractError> {
    let quads = collect_quads(ribbon, places)?;
    // 1. A vertex per grid point and fan of faces around it: trimming may leave several fans.
    let (vertex_of_corner, point_of_vertex) = number_vertices(ribbon, &quads);
    let faces: Vec<[u32; 4]> = quads.iter().map(|q| q.map(|p| vertex_of_corner[p as usize])).collect();
    let positions = point_of_vertex.iter().map(|&q| places.position[q as usize]).collect();
    let mesh = QuadMesh::new(positions, &faces)?;
    // 2. What goes with the vertices, edges and faces.
    let mut feature_edges = EdgeMap::filled(mesh.edge_count(), None);
    for h in mesh.half_edges() {
        let side = ribbon.label[quads[h.index() / 4][h.index() % 4] as usize];
        feature_edges[mesh.edge(h)] = feature_edges[mesh.edge(h)].or(side);
    }
    let points = &walker.points.points;
    let is_square = |q: &[u32; 4]| !q.iter().any(|&p| ribbon.changed[p as usize]);
    Ok(Extraction {
        mesh,
        origin: point_of_vertex.iter().map(|&q| places.origin[q as usize]).collect(),
        placement: point_of_vertex.iter().map(|&q| placement(walker, &points[q as usize])).collect(),
        feature_edges,
        grid: quads.iter().map(|q| is_square(q).then(|| grid_square(walker, q[0]))).collect(),
        report: ExtractReport::default(),
    })
}

/// A number for each fan of quad corners around a grid point, in the order of the ports; [`NONE`] elsewhere. With it
/// the grid point of each number.
fn number_vertices(ribbon: &Ribbon, quads: &[[u32; 4]]) -> (Vec<u32>, Vec<u32>) {
    let mut used = vec![false; ribbon.len()];
    for &p in quads.as_flattened() {
        used[p as usize] = true;
    }
    let (mut number, mut point_of_vertex) = (vec![NONE; ribbon.len()], Vec::new());
    for start in 0..ribbon.len() as u32 {
        if !used[start as usize] || number[start as usize] != NONE {
            continue;
        }
        let vertex = point_of_vertex.len() as u32;
        point_of_vertex.push(ribbon.vertex[start as usize]);
        for step in [Ribbon::clockwise, Ribbon::counter_clockwise] {
            number[start as usize] = vertex;
            let mut p = start;
            while let Some(q) = step(ribbon, p).filter(|&q| used[q as usize] && number[q as usize] == NONE) {
                number[q as usize] = vertex;
                p = q;
            }
        }
    }
    (number, point_of_vertex)
}

/// Grid coordinates of the quad left of a port, in the chart where the port starts.
fn grid_square(walker: &Walker, port: u32) -> GridSquare {
    let (mesh, map) = (walker.mesh, walker.map);
    let start = walker.ports.start(mesh, map, walker.points, port);
    let (Site::Face { half_edge, .. } | Site::Edge { half_edge, .. }) = walker.ports.list[port as usize].site;
    let direction = walker.direction(port);
    let turn = if walker.sign[mesh.face(half_edge)] < 0 { 3 } else { 1 };
    let first = GridSegment::from(start, direction);
    let (d, e) = (DIRECTION[direction as usize], DIRECTION[((direction + turn) % 4) as usize]);
    let unit = |p: [i64; 2], i: i64, j: i64| [0, 1].map(|k| (p[k] / GRID_UNIT + i * d[k] + j * e[k]) as i32);
    let at = first.start();
    [unit(at, 0, 0), unit(at, 1, 0), unit(at, 1, 1), unit(at, 0, 1)]
}
