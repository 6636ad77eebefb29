//! Maps of tiles: known shapes, symmetry, exact tests by integers, and tiles of real cuttings.

use quadloom_mesh::{
    DVec2, DVec3, EdgeId, FaceId, FeatureGraph, HalfEdgeId, Progress, TriMesh, VertexId, VertexMap, shapes,
};
use quadloom_tiling::maps::{
    Border, MapError, MapMethod, MapOptions, PackingKind, TileMap, border_overlaps, edges_on_one_side, folded_faces,
    map_tile, side_parameters, split_side_edges,
};
use quadloom_tiling::{CutOptions, EdgeCosts, Method, QuadOptions, TileId, Tiling, cut_to_disk};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

const ALL: [MapMethod; 4] = [MapMethod::MeanValue, MapMethod::Conformal, MapMethod::AngleBased, MapMethod::Circles];
const FIXED: [MapMethod; 2] = [MapMethod::MeanValue, MapMethod::Conformal];
const FREE: [MapMethod; 2] = [MapMethod::AngleBased, MapMethod::Circles];

/// A disk and its corners.
struct Disk {
    mesh: TriMesh,
    corners: Vec<VertexId>,
}

impl Disk {
    fn new(positions: Vec<DVec3>, faces: &[[u32; 3]], corners: &[u32]) -> Self {
        Self { mesh: TriMesh::new(positions, faces).unwrap(), corners: corners.iter().map(|&v| VertexId(v)).collect() }
    }

    /// The same disk without edges that a straight side would flatten.
    fn split(self) -> Self {
        let features = FeatureGraph::none(&self.mesh);
        let mesh = split_side_edges(&self.mesh, &features, &self.corners).unwrap().mesh;
        assert!(edges_on_one_side(&mesh, &self.corners).unwrap().is_empty());
        Self { mesh, corners: self.corners }
    }

    fn moved(&self, place: impl Fn(VertexId, DVec3) -> DVec3) -> Self {
        let positions = VertexMap::from_fn(self.mesh.vertex_count(), |v| place(v, self.mesh.position(v)));
        Self { mesh: self.mesh.with_positions(positions).unwrap(), corners: self.corners.clone() }
    }

    fn map_with(&self, method: MapMethod, options: &MapOptions) -> Result<TileMap, MapError> {
        map_tile(&self.mesh, &self.corners, method, options, &Progress::none())
    }

    fn map(&self, method: MapMethod) -> TileMap {
        self.map_with(method, &MapOptions::default()).unwrap_or_else(|e| panic!("{method}: {e}"))
    }

    fn border(&self) -> Vec<HalfEdgeId> {
        quadloom_mesh::topology::boundary_loops(self.mesh.connectivity()).remove(0)
    }
}

/// A grid of n × m squares, diagonals in turn, whose point at (x, y) of the unit square is given.
fn grid(n: u32, m: u32, point: impl Fn(f64, f64) -> DVec3) -> Disk {
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let mut positions = Vec::new();
    for j in 0..=m {
        positions.extend((0..=n).map(|i| point(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m))));
    }
    let mut faces = Vec::new();
    for (i, j) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        faces.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
    }
    Disk::new(positions, &faces, &[0, n, at(n, m), at(0, m)])
}

fn flat(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

/// A planar grid whose inner vertices are off their places, none so far that a face turns over.
fn shaken(n: u32, seed: u64) -> Disk {
    let disk = grid(n, n, flat).split();
    let shift = |v: VertexId, k: u64| 0.4 * (shapes::random(seed, 2 * u64::from(v.0) + k) - 0.5) / f64::from(n);
    let inside = |p: DVec3| p.x > 0.0 && p.x < 1.0 && p.y > 0.0 && p.y < 1.0;
    disk.moved(|v, p| if inside(p) { p + flat(shift(v, 0), shift(v, 1)) } else { p })
}

/// Rings about the z axis from the border inwards, each (radius, height), and a tip.
fn revolved(around: u32, rings: &[(f64, f64)], tip: f64) -> Disk {
    let mut positions = Vec::new();
    for (k, &(radius, z)) in rings.iter().enumerate() {
        let turn = |i: u32| TAU * (f64::from(i) + 0.5 * (k % 2) as f64) / f64::from(around);
        positions.extend((0..around).map(|i| DVec3::new(radius * turn(i).cos(), radius * turn(i).sin(), z)));
    }
    let top = positions.len() as u32;
    positions.push(DVec3::new(0.0, 0.0, tip));
    let at = |k: u32, i: u32| k * around + i % around;
    let mut faces: Vec<[u32; 3]> = Vec::new();
    let last = rings.len() as u32 - 1;
    for (k, i) in (0..last).flat_map(|k| (0..around).map(move |i| (k, i))) {
        let [a, b] = [at(k, i), at(k, i + 1)];
        let [c, d] = [at(k + 1, i), at(k + 1, i + 1)];
        faces.extend(if k % 2 == 0 { [[a, b, c], [b, d, c]] } else { [[a, d, c], [a, b, d]] });
    }
    faces.extend((0..around).map(|i| [at(last, i), at(last, i + 1), top]));
    Disk::new(positions, &faces, &[0, around / 4, around / 2, 3 * around / 4])
}

/// A flat ring whose inner border is closed by a tube of a length in girths.
fn finger(around: u32, girths: f64) -> Disk {
    let step = TAU / f64::from(around);
    let rings = (girths * f64::from(around)) as usize;
    let mut profile: Vec<(f64, f64)> = (0..8).map(|k| (3.0 - 0.25 * f64::from(k), 0.0)).collect();
    profile.extend((0..rings).map(|k| (1.0, k as f64 * step)));
    profile.extend((1..5).map(|k| (1.0 - 0.2 * f64::from(k), rings as f64 * step)));
    revolved(around, &profile, rings as f64 * step)
}

/// A part of the unit sphere, up to an angle from its pole.
fn cap(around: u32, rings: u32, angle: f64) -> Disk {
    let at = |k: u32| angle * (1.0 - f64::from(k) / f64::from(rings));
    let profile: Vec<(f64, f64)> = (0..rings).map(|k| (at(k).sin(), at(k).cos())).collect();
    revolved(around, &profile, 1.0)
}

/// A grid whose vertices are anywhere in a cube.
fn crumpled(n: u32, seed: u64) -> Disk {
    let number = |v: VertexId, k: u64| shapes::random(seed, 3 * u64::from(v.0) + k);
    grid(n, n, flat).split().moved(|v, _| DVec3::new(number(v, 0), number(v, 1), number(v, 2)))
}

/// The tile of a tiling as a surface of its own, with the vertex of the tiling's mesh of each of its vertices.
fn tile(tiling: &Tiling, id: TileId) -> (Disk, Vec<VertexId>) {
    let (mesh, cut) = (tiling.mesh(), tiling.cut_edges());
    let mut number: BTreeMap<HalfEdgeId, u32> = BTreeMap::new();
    let (mut positions, mut origin) = (Vec::new(), Vec::new());
    let faces: Vec<FaceId> = tiling.tile_faces(id);
    for h in faces.iter().flat_map(|&f| mesh.sides(f)).collect::<Vec<_>>() {
        if number.contains_key(&h) {
            continue;
        }
        // All corners about the vertex that no cut parts from this one.
        let mut fan = vec![h];
        let mut at = h;
        while let Some(next) = mesh.rotate_ccw(at).filter(|&n| !cut[mesh.edge(n)] && n != h) {
            fan.push(next);
            at = next;
        }
        at = h;
        while !cut[mesh.edge(at)]
            && let Some(next) = mesh.rotate_cw(at).filter(|n| !fan.contains(n))
        {
            fan.push(next);
            at = next;
        }
        number.extend(fan.into_iter().map(|h| (h, positions.len() as u32)));
        positions.push(mesh.position(mesh.origin(h)));
        origin.push(mesh.origin(h));
    }
    let triangles: Vec<[u32; 3]> = faces.iter().map(|&f| mesh.face_half_edges(f).map(|h| number[&h])).collect();
    let sides = tiling.complex.cells[id].polygon().expect("a disk");
    let corners: Vec<u32> = sides.iter().map(|&s| number[&tiling.side_half_edges(s)[0]]).collect();
    (Disk::new(positions, &triangles, &corners), origin)
}

fn tilings() -> Vec<Tiling> {
    let surfaces = [
        shapes::torus(2.0, 0.7, 30, 14),
        shapes::smooth_genus(2, 1),
        shapes::smooth_genus(3, 1),
        shapes::with_noise(&shapes::smooth_genus(2, 2), 0.004, 7),
    ];
    let mut all = Vec::new();
    for mesh in &surfaces {
        let (costs, progress) = (EdgeCosts::euclidean(mesh), Progress::none());
        for method in [Method::Shortest, Method::SinglePoint] {
            let mut cutting = cut_to_disk(mesh, &costs, method, &CutOptions::default(), &progress).unwrap();
            all.push(cutting.tiling().unwrap());
            cutting.quadrangulate(&QuadOptions::default()).unwrap();
            all.push(cutting.tiling().unwrap());
        }
    }
    all
}

fn length(mesh: &TriMesh, e: EdgeId) -> f64 {
    let [a, b] = mesh.ends(e);
    mesh.position(a).distance(mesh.position(b))
}

fn flat_length(mesh: &TriMesh, uv: &VertexMap<DVec2>, e: EdgeId) -> f64 {
    let [a, b] = mesh.ends(e);
    uv[a].distance(uv[b])
}

fn flat_area(mesh: &TriMesh, uv: &VertexMap<DVec2>) -> f64 {
    let doubled = |f: FaceId| {
        let [a, b, c] = mesh.face_vertices(f).map(|v| uv[v]);
        (b - a).perp_dot(c - a)
    };
    0.5 * mesh.faces().map(doubled).sum::<f64>()
}

/// No fold, no overlap, all of the unit square: corners in the corners and border vertices exactly on their sides.
fn check_square(what: &str, disk: &Disk, map: &TileMap) {
    assert!(map.report.folded.is_empty() && folded_faces(&disk.mesh, &map.uv).is_empty(), "{what}: folds");
    assert!(!map.report.overlaps, "{what}: overlaps");
    let corner = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    disk.corners.iter().zip(corner).for_each(|(&v, p)| assert_eq!(map.uv[v], p, "{what}"));
    let mut border: Vec<VertexId> = disk.border().into_iter().map(|h| disk.mesh.origin(h)).collect();
    let first = border.iter().position(|&v| v == disk.corners[0]).unwrap();
    border.rotate_left(first);
    // Once around, never back: x + y rises along sides 0 and 1 and falls along 2 and 3.
    let (mut side, mut last) = (0, DVec2::ZERO);
    for &v in border[1..].iter().chain(&border[..1]) {
        let p = map.uv[v];
        let (on, ahead) = match side {
            0 => (p.y == 0.0, p.x > last.x),
            1 => (p.x == 1.0, p.y > last.y),
            2 => (p.y == 1.0, p.x < last.x),
            _ => (p.x == 0.0, p.y < last.y),
        };
        assert!(on && ahead, "{what}: {p} after {last} on side {side}");
        side += usize::from(disk.corners[(side + 1) % 4] == v);
        last = p;
    }
    assert_eq!(side, 4, "{what}");
    assert!((flat_area(&disk.mesh, &map.uv) - 1.0).abs() < 1e-12, "{what}");
}

#[test]
fn fixed_borders_keep_linear_maps() {
    for seed in 0..5 {
        let disk = shaken(12, seed);
        for sheared in [disk.moved(|_, p| p), disk.moved(|_, p| flat(3.0 * p.x + 0.7 * p.y, 2.0 * p.y - 0.1 * p.x))] {
            for method in FIXED {
                let map = sheared.map(method);
                check_square("shaken", &sheared, &map);
                let worst = disk
                    .mesh
                    .vertices()
                    .map(|v| map.uv[v].distance(disk.mesh.position(v).truncate()))
                    .fold(0.0, f64::max);
                assert!(worst < 1e-12, "{method}: {worst:e}");
                assert_eq!(map.report.rounds, 0);
            }
        }
    }
}

#[test]
fn flat_tiles_with_free_borders_are_reproduced() {
    let square = shaken(15, 3);
    // Half a ring: not convex; and out of the plane by a rigid motion.
    let half_ring = square.moved(|_, p| {
        let q = DVec2::from_angle(PI * p.x) * (2.0 - p.y);
        DVec3::new(0.6 * -q.x, q.y, 0.8 * -q.x) * 7.0
    });
    for disk in [square, half_ring] {
        for method in FREE {
            let map = disk.map(method);
            assert!(map.report.distortion.angle_largest < 1e-8, "{method}: {:?}", map.report);
            assert!(map.report.folded.is_empty() && !map.report.overlaps);
            for e in disk.mesh.edges() {
                let (l, flat) = (length(&disk.mesh, e), flat_length(&disk.mesh, &map.uv, e));
                assert!((l - flat).abs() < 1e-9 * l, "{method}: {l} became {flat}");
            }
            assert_eq!((map.report.rounds, map.uv[disk.corners[0]]), (0, DVec2::ZERO));
            assert!(map.uv[disk.corners[1]].y.abs() < 1e-12 && map.uv[disk.corners[1]].x > 0.0);
        }
    }
}

#[test]
fn a_cone_cut_open_is_unrolled_and_a_whole_one_is_spread_evenly() {
    // Cut open: a sector of 2π sin(a) on the plane.
    let slope: f64 = 0.6;
    let open = grid(40, 10, |x, y| {
        let (radius, turn) = (1.0 + y, TAU * x * 0.98);
        DVec3::new(radius * slope.sin() * turn.cos(), radius * slope.sin() * turn.sin(), radius * slope.cos())
    });
    let unrolled = open.moved(|v, p| {
        let turn = TAU * 0.98 * f64::from(v.0 % 41) / 40.0 * slope.sin();
        let radius = p.length();
        flat(radius * turn.cos(), radius * turn.sin())
    });
    for method in FREE {
        // A cone of triangles is no cone: angles about its vertices are those of the unrolled one to second order.
        let error = open.map(method).report.distortion.angle_largest;
        assert!(error < 0.5, "{method}: {error}");
        assert!(unrolled.map(method).report.distortion.angle_largest < 1e-8);
    }
    // Whole: n equal triangles about the tip. By symmetry each flat one has 2π/n there, and the rest at its
    // two other corners.
    for n in [5u32, 12, 31] {
        let whole = revolved(n, &[(1.0, 0.0)], 1.5);
        let side = (1.0f64 + 1.5 * 1.5).sqrt();
        let at_tip = 2.0 * ((PI / f64::from(n)).sin() / side).asin();
        let error = (TAU / f64::from(n) - at_tip).to_degrees();
        for method in FREE {
            let found = whole.map(method).report.distortion;
            assert!((found.angle_largest - error).abs() < 1e-8, "{method}: {} for {error}", found.angle_largest);
            assert!((found.angle_mean - (error + 2.0 * 0.5 * error) / 3.0).abs() < 1e-8);
        }
    }
}

#[test]
fn a_cap_tends_to_its_stereographic_projection() {
    for method in FREE {
        let mut last = f64::INFINITY;
        for n in [6, 12, 24, 48] {
            let (disk, angle) = (cap(4 * n, n, 1.2), 1.2);
            let map = disk.map(method);
            let error = map.report.distortion.angle_mean;
            assert!(error < 0.6 * last, "{method}: {error} after {last}");
            last = error;
            // The conformal map of a cap is the stereographic projection, r = c · tan(θ/2), about the tip.
            if n == 48 {
                let tip = map.uv[VertexId::new(disk.mesh.vertex_count() - 1)];
                let radius = |k: u32| map.uv[VertexId(k * 4 * n)].distance(tip);
                for k in 1..n {
                    let wanted = f64::tan(0.5 * angle * (1.0 - f64::from(k) / f64::from(n))) / f64::tan(0.5 * angle);
                    let found = radius(k) / radius(0);
                    assert!((found / wanted - 1.0).abs() < 0.02, "{method}: ring {k} at {found} for {wanted}");
                }
            }
        }
    }
    // Harmonic maps to the square are not conformal, but those of refined meshes agree.
    let places = [12, 24, 48].map(|n| {
        let (disk, ring) = (cap(4 * n, n, 1.2), n / 2);
        let map = disk.map(MapMethod::Conformal);
        map.uv[VertexId(ring * 4 * n + n / 2)]
    });
    assert!(places[2].distance(places[1]) < 0.4 * places[1].distance(places[0]), "{places:?}");
}

#[test]
fn touching_circles_touch_and_keep_those_of_the_border() {
    let options = MapOptions { packing: PackingKind::Tangent, ..MapOptions::default() };
    for disk in [cap(24, 6, 1.4), shaken(9, 1), crumpled(8, 5)] {
        let map = disk.map_with(MapMethod::Circles, &options).unwrap();
        assert_eq!(map.report.packing, Some(PackingKind::Tangent));
        let side = |h: HalfEdgeId| flat_length(&disk.mesh, &map.uv, disk.mesh.edge(h));
        let surface = |h: HalfEdgeId| length(&disk.mesh, disk.mesh.edge(h));
        let mut scale = None;
        for v in disk.mesh.vertices() {
            // Circles about the corners of a triangle touch: (b + c − a)/2, the same in all triangles of a vertex.
            let radius = |h: HalfEdgeId, l: &dyn Fn(HalfEdgeId) -> f64| {
                0.5 * (l(h) + l(disk.mesh.prev(h)) - l(disk.mesh.next(h)))
            };
            let found: Vec<f64> = disk.mesh.outgoing(v).map(|h| radius(h, &side)).collect();
            let spread = found.iter().fold(0.0f64, |m, r| m.max((r - found[0]).abs()));
            assert!(spread < 1e-8 * found[0], "{v}: {found:?}");
            if disk.mesh.is_boundary_vertex(v) {
                let wanted: f64 = disk.mesh.outgoing(v).map(|h| radius(h, &surface)).sum::<f64>() / found.len() as f64;
                let scale = *scale.get_or_insert(found[0] / wanted);
                assert!((found[0] / wanted / scale - 1.0).abs() < 1e-8, "{v}");
            }
        }
    }
}

#[test]
fn inversive_circles_keep_the_edges_of_the_border() {
    for disk in [cap(24, 6, 1.0), cap(40, 12, 1.9)] {
        let map = disk.map(MapMethod::Circles);
        assert_eq!(map.report.packing, Some(PackingKind::InversiveDistance));
        assert!(map.report.rounds > 0);
        let edges = disk.border().into_iter().map(|h| disk.mesh.edge(h));
        let ratios: Vec<f64> = edges.map(|e| flat_length(&disk.mesh, &map.uv, e) / length(&disk.mesh, e)).collect();
        assert!(ratios.iter().all(|r| (r / ratios[0] - 1.0).abs() < 1e-9), "{ratios:?}");
    }
}

#[test]
fn flat_angles_sum_to_full_turns_and_areas_are_kept() {
    for (name, disk) in [("cap", cap(30, 9, 2.0)), ("crumpled", crumpled(9, 2)), ("finger", finger(16, 1.0))] {
        for method in FREE {
            let map = disk.map(method);
            let (area, wanted) = (flat_area(&disk.mesh, &map.uv), disk.mesh.area());
            assert!((area - wanted).abs() < 1e-9 * wanted, "{name}, {method}: area {area} for {wanted}");
            assert!(map.report.folded.is_empty() && map.report.residual < 1e-8);
            for v in disk.mesh.vertices().filter(|&v| !disk.mesh.is_boundary_vertex(v)) {
                let angle = |h: HalfEdgeId| {
                    let right = map.uv[disk.mesh.target(h)] - map.uv[v];
                    right.angle_to(map.uv[disk.mesh.origin(disk.mesh.prev(h))] - map.uv[v])
                };
                let sum: f64 = disk.mesh.outgoing(v).map(angle).sum();
                assert!((sum - TAU).abs() < 1e-5, "{name}, {method}: {sum} about {v}");
            }
        }
    }
}

#[test]
fn angle_based_maps_are_nearest_to_the_angles_of_the_surface() {
    for disk in [cap(30, 9, 1.0), cap(30, 9, 1.7), crumpled(8, 6)] {
        let (slope_of, cost_of) = (|m| slope(&disk, &disk.map(m).uv), |m| cost(&disk, &disk.map(m).uv, None));
        let report = disk.map(MapMethod::AngleBased).report;
        assert!(report.rounds <= 12 && report.packing.is_none(), "{report:?}");
        // Any places in the plane have flat angles, so that moving a vertex tries them all.
        let (slope, cost) = (slope_of(MapMethod::AngleBased), cost_of(MapMethod::AngleBased));
        assert!(slope < 0.02 * slope_of(MapMethod::Circles), "{slope} against {}", slope_of(MapMethod::Circles));
        for other in [MapMethod::MeanValue, MapMethod::Circles] {
            assert!(cost < cost_of(other), "{other}: {} against {cost}", cost_of(other));
        }
    }
}

/// Σ (flat angle / wanted angle − 1)² over the faces of one vertex or of all; about inner vertices the wanted angles
/// are those of the surface scaled to 2π.
fn cost(disk: &Disk, uv: &VertexMap<DVec2>, about: Option<VertexId>) -> f64 {
    let mesh = &disk.mesh;
    let squares = |h: HalfEdgeId| {
        let at = uv[mesh.origin(h)];
        let flat = (uv[mesh.target(h)] - at).angle_to(uv[mesh.origin(mesh.prev(h))] - at);
        let total: f64 = mesh.outgoing(mesh.origin(h)).map(|h| shape_angle(mesh, h)).sum();
        let scale = if mesh.is_boundary_vertex(mesh.origin(h)) { 1.0 } else { TAU / total };
        (flat / (scale * shape_angle(mesh, h)) - 1.0).powi(2)
    };
    match about {
        None => mesh.half_edges().map(squares).sum(),
        Some(v) => mesh.outgoing(v).flat_map(|h| mesh.sides(mesh.face(h))).map(squares).sum(),
    }
}

/// Length of the gradient of the cost by the places of vertices, each in units of an edge there.
fn slope(disk: &Disk, uv: &VertexMap<DVec2>) -> f64 {
    let mut moved = uv.clone();
    let mut sum = 0.0;
    for v in disk.mesh.vertices() {
        let unit = disk.mesh.neighbours(v).map(|w| uv[v].distance(uv[w])).fold(f64::INFINITY, f64::min);
        for direction in [DVec2::X, DVec2::Y] {
            let at = [1e-5, -1e-5].map(|step| {
                moved[v] = uv[v] + direction * (step * unit);
                cost(disk, &moved, Some(v))
            });
            moved[v] = uv[v];
            sum += ((at[0] - at[1]) / 2e-5).powi(2);
        }
    }
    sum.sqrt()
}

fn shape_angle(mesh: &TriMesh, h: HalfEdgeId) -> f64 {
    let at = mesh.position(mesh.origin(h));
    (mesh.position(mesh.target(h)) - at).angle_between(mesh.position(mesh.origin(mesh.prev(h))) - at)
}

#[test]
fn mean_value_maps_never_fold() {
    let mut disks: Vec<(String, Disk)> =
        (0..30).map(|k| (format!("crumpled {k}"), crumpled(5 + k, u64::from(k)))).collect();
    disks.push(("cap".into(), cap(40, 20, 3.0)));
    disks.push(("finger".into(), finger(12, 4.0)));
    let bumpy = grid(30, 20, |x, y| DVec3::new(x, y, 0.2 * (9.0 * x).sin() * (7.0 * y).cos())).split();
    disks.push(("bumpy".into(), Disk { mesh: shapes::with_noise(&bumpy.mesh, 0.01, 4), corners: bumpy.corners }));
    for (name, disk) in &disks {
        check_square(name, disk, &disk.map(MapMethod::MeanValue));
    }
    // The test can tell: conformal maps of the crumpled ones do fold, and are refused unless that is allowed.
    let mut folded = 0;
    for (name, disk) in &disks[..30] {
        if let Err(MapError::Folded { face, count, .. }) = disk.map_with(MapMethod::Conformal, &MapOptions::default()) {
            let options = MapOptions { allow_folds: true, ..MapOptions::default() };
            let report = disk.map_with(MapMethod::Conformal, &options).expect(name).report;
            assert_eq!((report.folded.first(), report.folded.len()), (Some(&face), count), "{name}");
            folded += 1;
        }
    }
    assert!(folded > 20, "{folded}");
}

#[test]
fn long_fingers_are_drawn_outwards() {
    let short = finger(16, 3.0).map(MapMethod::MeanValue);
    assert_eq!(short.report.rounds, 0);
    for girths in [10.0, 30.0] {
        let disk = finger(16, girths);
        let first = MapOptions { max_rounds: 0, allow_folds: true, ..MapOptions::default() };
        let plain = disk.map_with(MapMethod::MeanValue, &first);
        assert!(matches!(plain, Err(MapError::Folded { rounds: 0, count, .. }) if count > 1000), "{plain:?}");
        let map = disk.map(MapMethod::MeanValue);
        check_square("finger", &disk, &map);
        assert!((1..10).contains(&map.report.rounds), "{} rounds", map.report.rounds);
    }
}

#[test]
fn tiles_agree_along_a_common_side() {
    // Two tiles beside a crooked line of uneven steps; the line is side 1 of the left one and side 3 of the right one.
    let line = |y: f64| DVec3::new((5.0 * y).sin(), y * y + 0.1 * y, (3.0 * y).cos() / 3.0);
    for steps in [3, 10, 57] {
        let left = grid(4, steps, |x, y| line(y) - DVec3::new(1.0 - x, 0.1 * (1.0 - x), 0.0)).split();
        let right = grid(6, steps, |x, y| line(y) + DVec3::new(2.0 * x, 0.0, x)).split();
        for method in FIXED {
            // The border is the same whether conformal maps fold inside or not.
            let options = MapOptions { allow_folds: true, ..MapOptions::default() };
            let [a, b] = [&left, &right].map(|disk| disk.map_with(method, &options).unwrap());
            for j in 0..=steps {
                let (u, v) = (VertexId(j * 5 + 4), VertexId(j * 7));
                assert_eq!(left.mesh.position(u), right.mesh.position(v));
                assert_eq!((a.uv[u].x, b.uv[v].x), (1.0, 0.0));
                assert_eq!(a.uv[u].y.to_bits(), b.uv[v].y.to_bits(), "{method}: {j} of {steps}");
            }
        }
        let (s, t) = (side_parameters(&left.mesh, &left.corners), side_parameters(&right.mesh, &right.corners));
        let (s, t) = (s.unwrap(), t.unwrap());
        for j in 1..steps {
            let (s, t) = (s[VertexId(j * 5 + 4)], t[VertexId(j * 7)]);
            assert_eq!(s.to_bits(), (1.0 - t).to_bits());
            assert_eq!(t.to_bits(), (1.0 - s).to_bits());
            assert!(s > 0.0 && s < 1.0);
        }
        // Arc length: of the straight bottom of the left tile.
        let wanted = [0.25, 0.5, 0.75];
        (1..4).for_each(|i| assert!((s[VertexId(i)] - wanted[i as usize - 1]).abs() < 1e-12));
    }
}

#[test]
fn quadrangles_of_a_cutting_agree_along_their_sides() {
    let (mut shared, mut tiles) = (0, 0);
    for tiling in tilings().iter().filter(|t| t.complex.cells.values().iter().all(|c| c.side_count() == 4)) {
        // By arc: parameters along it, as each of its two sides has them.
        let mut along: BTreeMap<u32, Vec<Vec<u64>>> = BTreeMap::new();
        for (id, cell) in tiling.complex.cells.iter() {
            let (disk, origin) = tile(tiling, id);
            let disk = disk.split();
            let map = disk.map(MapMethod::MeanValue);
            check_square("quadrangle", &disk, &map);
            tiles += 1;
            for (k, &side) in cell.polygon().unwrap().iter().enumerate() {
                let direction = [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y][k];
                let at = |t: DVec2| (t.dot(direction) + if k >= 2 { 1.0 } else { 0.0 }).to_bits();
                let path = side_vertices(&disk, k);
                let ends = tiling.side_half_edges(side);
                assert_eq!(path.len(), ends.len() + 1);
                assert_eq!(origin[path[0].index()], tiling.mesh().origin(ends[0]));
                let mut places: Vec<u64> = path.iter().map(|&v| at(map.uv[v])).collect();
                if side.reversed {
                    places.reverse();
                    places.iter_mut().for_each(|t| *t = (1.0 - f64::from_bits(*t)).to_bits());
                }
                along.entry(side.arc.0).or_default().push(places);
            }
        }
        for sides in along.values() {
            assert_eq!(sides.len(), 2);
            assert_eq!(sides[0], sides[1]);
            shared += sides[0].len();
        }
    }
    assert!(tiles > 10 && shared > 100, "{tiles} tiles, {shared} vertices");
}

/// Vertices of side k, both corners included.
fn side_vertices(disk: &Disk, k: usize) -> Vec<VertexId> {
    let next: BTreeMap<VertexId, VertexId> =
        disk.border().into_iter().map(|h| (disk.mesh.origin(h), disk.mesh.target(h))).collect();
    let (mut path, end) = (vec![disk.corners[k]], disk.corners[(k + 1) % disk.corners.len()]);
    while path.len() == 1 || path[path.len() - 1] != end {
        path.push(next[&path[path.len() - 1]]);
    }
    path
}

#[test]
fn tiles_of_cuttings_are_mapped_by_every_method() {
    for tiling in tilings() {
        for (id, cell) in tiling.complex.cells.iter() {
            let disk = tile(&tiling, id).0.split();
            let what = format!("{} sides, {} vertices", cell.side_count(), disk.mesh.vertex_count());
            let map = disk.map(MapMethod::MeanValue);
            assert!(map.report.folded.is_empty() && !map.report.overlaps, "{what}");
            for (k, &v) in disk.corners.iter().enumerate() {
                let n = disk.corners.len();
                let middle = map.uv[v].distance(DVec2::splat(0.5));
                let radius = if n == 4 { 0.5f64.sqrt() } else { 0.5 };
                assert!((middle - radius).abs() < 1e-15, "{what}: corner {k} at {}", map.uv[v]);
            }
            for method in FREE {
                let map = disk.map(method);
                assert!(map.report.folded.is_empty(), "{what}, {method}");
                assert!(map.report.residual < 1e-8, "{what}, {method}");
            }
        }
    }
}

#[test]
fn given_parameters_are_used_or_refused() {
    let disk = grid(4, 3, flat).split();
    let mut given = VertexMap::filled(disk.mesh.vertex_count(), 0.0);
    for k in 0..4 {
        let path = side_vertices(&disk, k);
        let last = path.len() as f64 - 1.0;
        path[1..path.len() - 1].iter().enumerate().for_each(|(i, &v)| given[v] = ((i as f64 + 1.0) / last).powi(2));
    }
    let options = |given: &VertexMap<f64>| MapOptions { side_parameters: Some(given.clone()), ..MapOptions::default() };
    let map = disk.map_with(MapMethod::MeanValue, &options(&given)).unwrap();
    check_square("given", &disk, &map);
    assert_eq!(map.uv[VertexId(1)], DVec2::new(0.0625, 0.0));
    assert!((map.uv[VertexId(9)] - DVec2::new(1.0, 1.0 / 9.0)).length() < 1e-15);
    for (vertex, value) in [(1, 0.0), (1, f64::NAN), (2, 0.0625), (3, 1.0), (3, -0.5), (2, 7.0)] {
        let mut bad = given.clone();
        bad[VertexId(vertex)] = value;
        let error = disk.map_with(MapMethod::Conformal, &options(&bad)).unwrap_err();
        assert!(matches!(error, MapError::SideParameter { .. }), "{error}");
    }
    let short = VertexMap::filled(3, 0.5);
    let error = disk.map_with(MapMethod::MeanValue, &options(&short)).unwrap_err();
    assert!(matches!(error, MapError::SideParameterCount { found: 3, .. }));
}

#[test]
fn polygons_and_circles_take_any_number_of_corners() {
    let disk = cap(24, 5, 1.0);
    for n in 1..=12 {
        let corners: Vec<VertexId> = (0..n).map(|k| VertexId(2 * k)).collect();
        let disk = Disk { mesh: disk.mesh.clone(), corners }.split();
        for border in [Border::Polygon, Border::Circle] {
            let options = MapOptions { border, ..MapOptions::default() };
            for method in FIXED {
                let map = disk.map_with(method, &options).unwrap();
                assert!(map.report.folded.is_empty() && !map.report.overlaps, "{method}, {n}");
                let round = border == Border::Circle || n < 3;
                for h in disk.border() {
                    let at = map.uv[disk.mesh.origin(h)].distance(DVec2::splat(0.5));
                    assert!(if round { (at - 0.5).abs() < 1e-15 } else { at < 0.5f64.sqrt() + 1e-15 });
                }
                let area = flat_area(&disk.mesh, &map.uv);
                let wanted = match n {
                    4 if !round => 1.0,
                    _ if !round => f64::from(n) / 8.0 * (TAU / f64::from(n)).sin(),
                    _ => PI / 4.0,
                };
                assert!((area - wanted).abs() < if round { 0.03 } else { 1e-12 }, "{n}: {area} for {wanted}");
            }
        }
    }
}

#[test]
fn edges_that_a_side_would_flatten_are_named_and_split() {
    // With four corners, the edges that cut off the ears of the grid have their ends on different sides.
    let disk = grid(3, 3, flat);
    assert!(edges_on_one_side(&disk.mesh, &disk.corners).unwrap().is_empty());
    // With three corners, the ear at the one left out lies on one side.
    let three = Disk { mesh: disk.mesh.clone(), corners: disk.corners[..3].to_vec() };
    let mut chords = Vec::new();
    let side: Vec<Vec<VertexId>> = (0..3).map(|k| side_vertices(&three, k)).collect();
    for e in three.mesh.edges().filter(|&e| !three.mesh.is_boundary_edge(e)) {
        let ends = three.mesh.ends(e);
        if side.iter().any(|s| ends.iter().all(|v| s.contains(v))) {
            chords.push(e);
        }
    }
    assert_eq!(edges_on_one_side(&three.mesh, &three.corners).unwrap(), chords);
    for method in FIXED {
        let error = three.map_with(method, &MapOptions::default()).unwrap_err();
        assert_eq!(error, MapError::EdgeOnSide { edge: chords[0], count: chords.len() });
    }
    let before = three.mesh.vertex_count();
    let split = three.split();
    assert_eq!(split.mesh.vertex_count(), before + chords.len());
    assert!(!chords.is_empty() && split.map(MapMethod::MeanValue).report.folded.is_empty());
    // The diagonal of one square runs between corners that are on no common side.
    assert!(edges_on_one_side(&grid(1, 1, flat).mesh, &grid(1, 1, flat).corners).unwrap().is_empty());
}

#[test]
fn ramps_overlap_and_sectors_do_not() {
    for (turns, overlaps) in [(0.8, false), (0.97, false), (1.03, true), (1.6, true)] {
        // A ring seen from above, hardly rising.
        let ramp = grid(120, 3, |x, y| {
            let turn = TAU * turns * x;
            DVec3::new((2.0 - y) * turn.cos(), (2.0 - y) * turn.sin(), 1e-3 * x)
        });
        for method in FREE {
            let map = ramp.map(method);
            assert!(map.report.folded.is_empty());
            assert_eq!(map.report.overlaps, overlaps, "{method}: {turns} turns");
        }
    }
}

/// A polygon as a fan mesh with its places; the exact tests look at places alone.
fn polygon_mesh(n: usize) -> TriMesh {
    let positions = (0..=n).map(|i| DVec3::new(i as f64, 0.0, 0.0)).collect();
    let faces: Vec<[u32; 3]> = (0..n as u32).map(|i| [i, (i + 1) % n as u32, n as u32]).collect();
    TriMesh::new(positions, &faces).unwrap()
}

#[test]
fn exact_tests_agree_with_integers() {
    type Point = [i128; 2];
    let turn = |a: Point, b: Point, c: Point| ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).signum();
    let between = |a: Point, b: Point, p: Point| (0..2).all(|k| a[k].min(b[k]) <= p[k] && p[k] <= a[k].max(b[k]));
    let meet = |a: Point, b: Point, c: Point, d: Point| {
        let [r, s, t, u] = [turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)];
        (r * s < 0 && t * u < 0)
            || (r == 0 && between(a, b, c))
            || (s == 0 && between(a, b, d))
            || (t == 0 && between(c, d, a))
            || (u == 0 && between(c, d, b))
    };
    let mut outcomes = [0; 2];
    let mut flat_faces = 0;
    for seed in 0..400u64 {
        // Small numbers: many touches. Large ones: nearly straight, beyond what doubles multiply exactly.
        let n = 3 + (seed % 9) as usize;
        let number = |i: usize, k: u64| (shapes::random(seed, 2 * i as u64 + k) * 9.0).floor() as i128;
        let place = |i: usize| -> Point {
            match seed % 4 {
                0 => [number(i, 0), number(i, 1)],
                1 => {
                    let t = (1i128 << 50) + number(i, 0);
                    [t, t + i128::from(number(i, 1) == 0)]
                }
                _ => {
                    let angle = TAU * (i as f64 + 0.4 * shapes::random(seed, i as u64)) / n as f64;
                    let radius = 1000.0 * if seed % 4 == 2 { 1.0 } else { shapes::random(seed, 50 + i as u64) };
                    [(radius * angle.cos()) as i128, (radius * angle.sin()) as i128]
                }
            }
        };
        let at: Vec<Point> = (0..=n).map(place).collect();
        let mesh = polygon_mesh(n);
        let uv: VertexMap<DVec2> = at.iter().map(|p| DVec2::new(p[0] as f64, p[1] as f64)).collect();
        let wanted: Vec<FaceId> =
            (0..n).filter(|&i| turn(at[i], at[(i + 1) % n], at[n]) <= 0).map(FaceId::new).collect();
        flat_faces += (0..n).filter(|&i| turn(at[i], at[(i + 1) % n], at[n]) == 0).count();
        assert_eq!(folded_faces(&mesh, &uv), wanted, "seed {seed}");
        let mut overlaps = false;
        for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (j, i))) {
            let (a, b, c, d) = (at[i], at[(i + 1) % n], at[j], at[(j + 1) % n]);
            // Neighbours share a point; they must not share more.
            overlaps |= match (i + 1) % n == j || (j + 1) % n == i {
                false => meet(a, b, c, d),
                true => {
                    let (p, hub, q) = if (i + 1) % n == j { (a, b, d) } else { (c, d, b) };
                    let dot: i128 = (0..2).map(|k| (p[k] - hub[k]) * (q[k] - hub[k])).sum();
                    turn(p, hub, q) == 0 && dot >= 0
                }
            };
        }
        assert_eq!(border_overlaps(&mesh, &uv), overlaps, "seed {seed}: {at:?}");
        outcomes[usize::from(overlaps)] += 1;
    }
    assert!(outcomes.iter().all(|&c| c > 50) && flat_faces > 50, "{outcomes:?}, {flat_faces} flat faces");
}

#[test]
fn degenerate_tiles_have_maps_or_honest_errors() {
    let disk = grid(6, 6, flat).split();
    let middle = disk.mesh.position(VertexId(24));
    let disks = [
        ("a point", disk.moved(|_, _| DVec3::ONE)),
        ("two points", disk.moved(|_, p| if p.x > 0.4 { DVec3::X } else { DVec3::ZERO })),
        ("a line", disk.moved(|_, p| flat(p.x, 0.0))),
        ("two coincide", disk.moved(|v, p| if v == VertexId(25) { middle } else { p })),
        ("half is flat", disk.moved(|_, p| flat(p.x.min(0.5), p.y))),
        ("a needle", disk.moved(|_, p| flat(1e7 * p.x, p.y))),
        ("a side is a point", disk.moved(|_, p| flat(p.x * p.y, p.y))),
        ("tiny", disk.moved(|_, p| p * 1e-170)),
        ("large", disk.moved(|_, p| p * 1e140)),
    ];
    for (name, disk) in &disks {
        for method in ALL {
            match disk.map_with(method, &MapOptions::default()) {
                Ok(map) => {
                    assert!(map.uv.values().iter().all(|p| p.is_finite()), "{name}, {method}");
                    assert!(folded_faces(&disk.mesh, &map.uv).is_empty(), "{name}, {method}");
                    let d = map.report.distortion;
                    assert!([d.angle_mean, d.angle_largest, d.area_mean, d.area_largest].iter().all(|x| x.is_finite()));
                    assert!((0.0..=180.0).contains(&d.angle_mean) && d.area_mean >= 1.0 - 1e-12);
                    let sound = matches!(*name, "large" | "a needle");
                    assert_eq!(map.report.degenerate_faces == 0, sound, "{name}");
                    assert_eq!(map.report.added_length == 0.0, sound, "{name}");
                }
                Err(MapError::Folded { .. } | MapError::NotConverged { .. } | MapError::Solve { .. }) => {
                    assert!(method != MapMethod::MeanValue, "{name}: mean value");
                }
                Err(other) => panic!("{name}, {method}: {other}"),
            }
        }
        check_square(name, disk, &disk.map(MapMethod::MeanValue));
    }
    let error = disk.moved(|_, p| p * 1e170).map_with(MapMethod::MeanValue, &MapOptions::default()).unwrap_err();
    assert_eq!(error, MapError::TooLong { edge: EdgeId(0) });
}

#[test]
fn the_smallest_disks_are_mapped() {
    let triangle = Disk::new(vec![DVec3::ZERO, DVec3::X, DVec3::new(0.2, 0.7, 0.3)], &[[0, 1, 2]], &[0, 1, 2]);
    let square = grid(1, 1, |x, y| DVec3::new(x, 2.0 * y, x * y));
    for method in ALL {
        for disk in [&triangle, &square] {
            let map = disk.map(method);
            assert!(map.report.folded.is_empty() && !map.report.overlaps && map.report.rounds == 0);
            if FREE.contains(&method) {
                assert!(map.report.distortion.angle_largest < 1e-10);
            }
        }
    }
    check_square("two triangles", &square, &square.map(MapMethod::Conformal));
}

#[test]
fn wrong_input_is_named() {
    let disk = grid(4, 4, flat).split();
    let ids = |list: &[u32]| list.iter().map(|&v| VertexId(v)).collect::<Vec<_>>();
    let error = |mesh: &TriMesh, corners: &[u32], method| {
        map_tile(mesh, &ids(corners), method, &MapOptions::default(), &Progress::none()).unwrap_err()
    };
    let mesh = &disk.mesh;
    for method in ALL {
        let vertex = VertexId(12);
        assert_eq!(error(mesh, &[0, 4, 12, 20], method), MapError::CornerNotOnBorder { vertex });
        let vertex = VertexId(99_999);
        assert_eq!(error(mesh, &[99_999], method), MapError::CornerNotOnBorder { vertex });
        assert_eq!(error(mesh, &[0, 20, 24, 4], method), MapError::CornerOrder { vertex: VertexId(24) });
        assert_eq!(error(mesh, &[0, 4, 4, 20], method), MapError::CornerOrder { vertex: VertexId(4) });
        assert_eq!(error(mesh, &[0, 4, 24, 0], method), MapError::CornerOrder { vertex: VertexId(0) });
        let closed = MapError::NotDisk { components: 1, genus: 0, boundaries: 0 };
        assert_eq!(error(&shapes::sphere(1.0, 1), &[0], method), closed);
        let tube = MapError::NotDisk { components: 1, genus: 0, boundaries: 2 };
        assert_eq!(error(&shapes::cylinder(1.0, 1.0, 5, 2), &[0], method), tube);
        let two = MapError::NotDisk { components: 2, genus: 0, boundaries: 2 };
        assert_eq!(error(&shapes::join(&[mesh.clone(), mesh.clone()]), &[0], method), two);
        let flag = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(true));
        let stopped = map_tile(mesh, &disk.corners, method, &MapOptions::default(), &Progress::none().with_flag(flag));
        assert!(matches!(stopped, Err(MapError::Cancelled(_))));
    }
    FIXED.iter().for_each(|&method| assert_eq!(error(mesh, &[], method), MapError::NoCorner));
    FREE.iter().for_each(|&method| {
        let map = map_tile(mesh, &[], method, &MapOptions::default(), &Progress::none()).unwrap();
        assert!(map.report.distortion.angle_largest < 1e-8);
    });
}

#[test]
fn maps_are_the_same_every_time() {
    for disk in [cap(30, 10, 1.5), crumpled(12, 3), finger(12, 8.0)] {
        for method in ALL {
            let options = MapOptions { allow_folds: true, ..MapOptions::default() };
            let [a, b] = [(); 2].map(|()| disk.map_with(method, &options).unwrap());
            assert!(
                a.uv.values()
                    .iter()
                    .zip(b.uv.values())
                    .all(|(p, q)| p.x.to_bits() == q.x.to_bits() && p.y.to_bits() == q.y.to_bits())
            );
            assert_eq!(serde_json::to_string(&a.report).unwrap(), serde_json::to_string(&b.report).unwrap());
        }
    }
}
