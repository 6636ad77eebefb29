//! The mixed-integer problem of the map: orientation energy, seam and alignment constraints, integers.
//!
//! In: charts, face layouts, sizes. Out: a quadratic energy, linear rows and integer variables.
//! Holds: variables 2n and 2n+1 are u and v of node n; 2(N+s) and 2(N+s)+1 the translation of segment s.
//! Source: [Bommes2012] §8.4, Eq. (8.4), with the anisotropic norm and local stiffening.

use crate::charts::Charts;
use crate::ties::TiePath;
use quadloom_field::{CrossField, SizeField};
use quadloom_mesh::{DVec2, EdgeMap, FaceId, FaceMap, FeatureGraph, TriConnectivity, VertexId, metric};
use quadloom_numeric::{Constraints, Quadratic};

/// Per face: gradients of the three hat functions in the frame of its chart axes, scaled by the two sizes.
///
/// A map is perfect where the gradient of u is (1, 0) and that of v is (0, 1).
#[derive(Clone, Debug)]
pub struct FaceGradient {
    /// Gradient of each corner's hat function, per quad edge length.
    pub hat: [DVec2; 3],
    /// Area in quads: area / (h_u·h_v).
    pub area: f64,
}

/// Gradients of every face ([Bommes2012] §8.4: u_T and v_T are the cross directions θ and θ + π/2).
///
/// Degenerate faces get the gradients of a triangle of a thousandth of their longest edge's height.
pub fn face_gradients(
    mesh: &TriConnectivity,
    length: &EdgeMap<f64>,
    field: &CrossField,
    size: &SizeField,
    charts: &Charts,
) -> FaceMap<FaceGradient> {
    FaceMap::from_fn(mesh.face_count(), |f| {
        let corner = metric::face_layout(mesh, length, f);
        let axis = field.angle[f] + f64::from(charts.axis[f]) * std::f64::consts::FRAC_PI_2;
        let (h_u, h_v) = if charts.axis[f].is_multiple_of(2) { (size.u[f], size.v[f]) } else { (size.v[f], size.u[f]) };
        let (sin, cos) = axis.sin_cos();
        let mut p = corner.map(|c| DVec2::new((c.x * cos + c.y * sin) / h_u, (c.y * cos - c.x * sin) / h_v));
        let longest = (0..3).map(|k| p[k].distance(p[(k + 1) % 3])).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let mut twice = (p[1] - p[0]).perp_dot(p[2] - p[0]);
        let least = DEGENERATE_HEIGHT * longest * longest;
        if twice < least {
            p = fattened(p, least);
            twice = (p[1] - p[0]).perp_dot(p[2] - p[0]).max(least);
        }
        let hat = std::array::from_fn(|k| {
            let opposite = p[(k + 2) % 3] - p[(k + 1) % 3];
            opposite.perp() / twice
        });
        FaceGradient { hat, area: 0.5 * twice }
    })
}

/// Height of a triangle over its longest edge below which it is treated as if it had this height.
///
/// Larger: visible distortion near thin triangles. Smaller: the linear system loses digits (1e-6 fails at 1e-12 relative).
const DEGENERATE_HEIGHT: f64 = 1e-4;

fn fattened(p: [DVec2; 3], twice: f64) -> [DVec2; 3] {
    let k = (0..3)
        .max_by(|&a, &b| p[a].distance_squared(p[(a + 1) % 3]).total_cmp(&p[b].distance_squared(p[(b + 1) % 3])))
        .unwrap_or(0);
    let (a, b, c) = (p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
    let side = (b - a).normalize_or(DVec2::X);
    let length = a.distance(b).max(f64::MIN_POSITIVE);
    let mut q = p;
    q[(k + 2) % 3] = a + side * (c - a).dot(side) + side.perp() * (twice / length);
    q
}

/// Weights and norms of the energy.
#[derive(Clone, Copy, Debug)]
pub struct EnergyOptions {
    /// γ of the anisotropic norm, in (0, 1]: weight of stretch along the cross relative to turning away from it.
    /// Default 1 (isotropic): least length distortion; smaller values trade it for orientation.
    pub anisotropy: f64,
}

impl Default for EnergyOptions {
    fn default() -> Self {
        Self { anisotropy: 1.0 }
    }
}

/// Σ_T w(T)·area(T)·E_T over all faces ([Bommes2012] §8.4, Eq. (8.4)), without its constant.
///
/// `scale` multiplies the wanted gradients: 1 for grid units, larger for a finer unit.
pub fn orientation_energy(
    mesh: &TriConnectivity,
    charts: &Charts,
    gradient: &FaceMap<FaceGradient>,
    weight: &FaceMap<f64>,
    options: &EnergyOptions,
    scale: f64,
) -> Quadratic {
    let mut energy = Quadratic::new(variable_count(charts));
    let along = options.anisotropy.clamp(1e-3, 1.0);
    for f in mesh.faces() {
        let node = mesh.face_half_edges(f).map(|h| charts.node[h] as usize);
        let FaceGradient { hat, area } = &gradient[f];
        let w = weight[f] * area;
        // u: weight γ along x (target 1), 1 along y (target 0); v the other way round.
        for (component, norm, target) in [(0, DVec2::new(along, 1.0), DVec2::X), (1, DVec2::new(1.0, along), DVec2::Y)]
        {
            for i in 0..3 {
                let row = 2 * node[i] + component;
                energy.add_rhs(row, 2.0 * w * scale * (hat[i] * norm).dot(target));
                for j in i..3 {
                    energy.add(row, 2 * node[j] + component, 2.0 * w * (hat[i] * norm).dot(hat[j]));
                }
            }
        }
    }
    energy
}

/// Σ_T area(T)·E_T of a map, with its constant and without weights ([Bommes2012] §8.4, Eq. (8.4)), in quads.
pub fn orientation_energy_of(
    mesh: &TriConnectivity,
    gradient: &FaceMap<FaceGradient>,
    options: &EnergyOptions,
    uv: impl Fn(FaceId) -> [[f64; 2]; 3],
) -> f64 {
    let along = options.anisotropy.clamp(1e-3, 1.0);
    let of_face = |f: FaceId| {
        let j = jacobian(&gradient[f], uv(f));
        let stretch = (j[0][0] - 1.0).powi(2) + (j[1][1] - 1.0).powi(2);
        gradient[f].area * (along * stretch + j[0][1].powi(2) + j[1][0].powi(2))
    };
    mesh.faces().map(of_face).sum()
}

/// Number of variables: two per node and two per seam segment.
pub fn variable_count(charts: &Charts) -> usize {
    2 * (charts.node_count + charts.segments.len())
}

/// Value of E_T without weights at given gradients, for reports and stiffening.
pub fn jacobian(gradient: &FaceGradient, uv: [[f64; 2]; 3]) -> [[f64; 2]; 2] {
    let mut j = [[0.0; 2]; 2];
    for (corner, hat) in uv.iter().zip(&gradient.hat) {
        for c in 0..2 {
            j[c][0] += hat.x * corner[c];
            j[c][1] += hat.y * corner[c];
        }
    }
    j
}

/// What a row of the constraints says, for messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowOrigin {
    /// Both images of a vertex agree across a seam segment.
    Seam(u32),
    /// A feature edge lies on an iso-line.
    Feature(quadloom_mesh::EdgeId),
    /// The map is pinned at a vertex.
    Anchor(VertexId),
    /// An iso-line runs from one singular vertex to another.
    Tie(VertexId, VertexId),
}

/// Rows Cx = d, integer variables, and where each row comes from.
pub struct MapConstraints {
    /// The rows; labels index `origin`.
    pub rows: Constraints,
    /// Variables that must be integers, ascending.
    pub integers: Vec<usize>,
    /// What each row says.
    pub origin: Vec<RowOrigin>,
}

/// Seam compatibility, feature alignment, anchors and integers ([Bommes2012] §8.4), ties of singular vertices (§8.6).
pub fn map_constraints(
    mesh: &TriConnectivity,
    features: &FeatureGraph,
    charts: &Charts,
    ties: &[TiePath],
) -> MapConstraints {
    let mut rows = Constraints::new();
    let mut origin = Vec::new();
    let mut is_integer = vec![false; variable_count(charts)];
    let mut push = |terms: &[(usize, f64)], d: f64, from: RowOrigin| {
        let mut sum: Vec<(usize, f64)> = Vec::with_capacity(terms.len());
        for &(i, c) in terms {
            match sum.iter_mut().find(|t| t.0 == i) {
                Some(t) => t.1 += c,
                None => sum.push((i, c)),
            }
        }
        sum.retain(|t| t.1 != 0.0);
        rows.add(&sum, d, origin.len());
        origin.push(from);
    };
    // 1. (u', v') = Rot90^i (u, v) + (j, k) at every vertex of a segment.
    for (s, segment) in charts.segments.iter().enumerate() {
        let t = 2 * (charts.node_count + s);
        is_integer[t] = true;
        is_integer[t + 1] = true;
        let last = segment.sides[segment.sides.len() - 1];
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for &h in &segment.sides {
            let Some(twin) = mesh.twin(h) else { continue };
            pairs.push((charts.node[h], charts.node[mesh.next(twin)]));
            if h == last {
                pairs.push((charts.node[mesh.next(h)], charts.node[twin]));
            }
        }
        for (left, right) in pairs {
            let (l, r) = (2 * left as usize, 2 * right as usize);
            // Rot90^k (u, v): the source component and sign of each image component.
            let [(cu, su), (cv, sv)] = match segment.quarter_turns {
                0 => [(0, 1.0), (1, 1.0)],
                1 => [(1, -1.0), (0, 1.0)],
                2 => [(0, -1.0), (1, -1.0)],
                _ => [(1, 1.0), (0, -1.0)],
            };
            push(&[(r, 1.0), (l + cu, -su), (t, -1.0)], 0.0, RowOrigin::Seam(s as u32));
            push(&[(r + 1, 1.0), (l + cv, -sv), (t + 1, -1.0)], 0.0, RowOrigin::Seam(s as u32));
        }
    }
    // 2. v_p = v_q ∈ Z along features (u where the edge follows the v axis).
    for e in mesh.edges() {
        let Some(axis) = charts.feature_axis[e] else { continue };
        let h = mesh.half_edge(e);
        let constant = usize::from(axis % 2 == 0);
        let (p, q) = (2 * charts.node[h] as usize + constant, 2 * charts.node[mesh.next(h)] as usize + constant);
        push(&[(p, 1.0), (q, -1.0)], 0.0, RowOrigin::Feature(e));
        is_integer[p] = true;
        is_integer[q] = true;
    }
    // 3. Singular vertices, corners and irregular feature vertices.
    for v in mesh.vertices().filter(|&v| charts.is_integer[v]) {
        for h in mesh.outgoing(v) {
            is_integer[2 * charts.node[h] as usize] = true;
            is_integer[2 * charts.node[h] as usize + 1] = true;
        }
    }
    // 4. One anchor per component removes the free translation.
    let on_feature = features.feature_vertices(mesh);
    for anchor in anchors(mesh, charts, &on_feature) {
        let n = 2 * charts.node[mesh.outgoing_half_edge(anchor)] as usize;
        push(&[(n, 1.0)], 0.0, RowOrigin::Anchor(anchor));
        push(&[(n + 1, 1.0)], 0.0, RowOrigin::Anchor(anchor));
    }
    // 5. One coordinate is the same at both ends of a tie.
    for tie in ties {
        let terms: Vec<(usize, f64)> =
            tie.constant_difference().iter().map(|&(i, c)| (i as usize, f64::from(c))).collect();
        push(&terms, 0.0, RowOrigin::Tie(tie.ends[0], tie.ends[1]));
    }
    let integers = (0..is_integer.len()).filter(|&i| is_integer[i]).collect();
    MapConstraints { rows, integers, origin }
}

/// Per component the first integer vertex whose position is free to choose, else a feature vertex, else any.
fn anchors(mesh: &TriConnectivity, charts: &Charts, on_feature: &quadloom_mesh::VertexMap<bool>) -> Vec<VertexId> {
    let mut seen = FaceMap::filled(mesh.face_count(), false);
    let mut chosen = Vec::new();
    for &root in &charts.roots {
        let mut best: Option<(u8, VertexId)> = None;
        let mut stack: Vec<FaceId> = vec![root];
        seen[root] = true;
        while let Some(f) = stack.pop() {
            for h in mesh.face_half_edges(f) {
                let v = mesh.origin(h);
                // A leaf of the seams is a fixed point of its own transition; it cannot be pinned to zero freely,
                // but pinning it moves the translation along, so it is as good as any.
                let rank = if charts.is_integer[v] {
                    0
                } else if on_feature[v] {
                    1
                } else {
                    2
                };
                if best.is_none_or(|b| (rank, v) < b) {
                    best = Some((rank, v));
                }
                if let Some(t) = mesh.twin(h)
                    && !seen[mesh.face(t)]
                {
                    seen[mesh.face(t)] = true;
                    stack.push(mesh.face(t));
                }
            }
        }
        chosen.extend(best.map(|b| b.1));
    }
    chosen
}
