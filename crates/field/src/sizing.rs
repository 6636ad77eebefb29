//! Sizes: the wanted quad edge lengths along both directions of every cross.
//!
//! In: a triangle mesh, a cross field and a wish (uniform, curvature, local feature size, vertex attribute).
//! Out: [`SizeField`]. Holds: positive finite lengths; after [`SizeField::normalized`] the faces ask for the wanted
//! number of quads in total. Not: that a quad mesh of exactly these lengths exists ([Bommes2012] §8.3).
//! Source: [Bommes2012] §8.3.
//!
//! Sizes are made in this order: a wish ([`SizeField::uniform`], [`SizeField::by_curvature`], [`SizeField::from_lengths`]
//! of [`local_feature_size`], [`SizeField::by_density`]), then [`SizeField::curl_corrected`] if directions matter more
//! than sizes, then [`SizeField::graded`], then [`SizeField::normalized`].

use crate::cross_field::CrossField;
use crate::curvature::Curvature;
use crate::error::FieldError;
use crate::system::solve_error;
use crate::transport::Transport;
use quadloom_mesh::metric::opposite_cotangents;
use quadloom_mesh::{ClosestPoint, DVec3, EdgeMap, FaceId, FaceMap, Progress, TriConnectivity, TriMesh, VertexMap};
use quadloom_numeric::{SparseCholesky, SparseSymmetric, Triplet};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Wanted quad edge lengths per face, file units: `u` along directions 0 and 2 of the cross, `v` along 1 and 3.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SizeField {
    /// Length along direction 0.
    pub u: FaceMap<f64>,
    /// Length along direction 1.
    pub v: FaceMap<f64>,
}

/// How curvature asks for lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvatureSizing {
    /// Largest distance between a quad edge and the surface, file units: an arc of curvature κ under a chord h rises by
    /// h²·|κ|/8.
    pub tolerance: f64,
    /// Shortest length, file units.
    pub shortest: f64,
    /// Longest length, file units: where the surface is flat.
    pub longest: f64,
    /// 0: squares, the shorter of both lengths counts. 1: two independent lengths. Between: geometric interpolation.
    pub anisotropy: f64,
}

impl SizeField {
    /// The same length everywhere.
    pub fn uniform(faces: usize, length: f64) -> Self {
        Self { u: FaceMap::filled(faces, length), v: FaceMap::filled(faces, length) }
    }

    /// One length per face for both directions.
    pub fn from_lengths(length: FaceMap<f64>) -> Self {
        Self { u: length.clone(), v: length }
    }

    /// The mean of its corners' lengths for every face.
    pub fn from_vertex_lengths(mesh: &TriConnectivity, length: &VertexMap<f64>) -> Self {
        Self::from_lengths(FaceMap::from_fn(mesh.face_count(), |f| {
            mesh.face_vertices(f).into_iter().map(|v| length[v]).sum::<f64>() / 3.0
        }))
    }

    /// Lengths that keep the distance between quads and surface below a tolerance ([Bommes2012] §8.3).
    ///
    /// # Input      curvature: shape operators, for instance of disks of the target length; length: √(8·tolerance/|κ|)
    /// along each direction of the cross
    pub fn by_curvature(field: &CrossField, curvature: &FaceMap<Curvature>, sizing: &CurvatureSizing) -> Self {
        let length = |kappa: f64| {
            let wanted = (8.0 * sizing.tolerance / kappa.abs().max(f64::MIN_POSITIVE)).sqrt();
            wanted.clamp(sizing.shortest, sizing.longest.max(sizing.shortest))
        };
        let both = |f: FaceId| {
            let [a, b] = [0, 1].map(|d| length(curvature[f].normal(field.direction_angle(f, d))));
            // The shorter length is the one of the larger principal curvature where crosses are not aligned.
            let square = a.min(b).min(length(curvature[f].max));
            let own = |h: f64| square * (h / square).powf(sizing.anisotropy.clamp(0.0, 1.0));
            [own(a), own(b)]
        };
        let faces = curvature.len();
        Self { u: FaceMap::from_fn(faces, |f| both(f)[0]), v: FaceMap::from_fn(faces, |f| both(f)[1]) }
    }

    /// Lengths for a relative number of quads per area at every vertex: length = 1/√density.
    ///
    /// # Input      density: at least 0, any unit; below `least` times its largest value it counts as that much
    pub fn by_density(mesh: &TriConnectivity, density: &VertexMap<f64>, least: f64) -> Self {
        let finite = |d: f64| if d.is_finite() { d.max(0.0) } else { 0.0 };
        let largest = density.values().iter().map(|&d| finite(d)).fold(0.0, f64::max);
        if largest <= 0.0 {
            return Self::uniform(mesh.face_count(), 1.0);
        }
        let floor = least.clamp(1e-6, 1.0);
        let length = density.map(|&d| 1.0 / (finite(d) / largest).max(floor).sqrt());
        Self::from_vertex_lengths(mesh, &length)
    }

    /// All lengths multiplied by `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { u: self.u.map(|h| h * factor), v: self.v.map(|h| h * factor) }
    }

    /// Number of quads the lengths ask for: Σ area / (u·v).
    pub fn quads(&self, area: &FaceMap<f64>) -> f64 {
        area.iter().map(|(f, a)| a / (self.u[f] * self.v[f])).sum()
    }

    /// All lengths multiplied by one factor, such that they ask for `quads` quads in total.
    pub fn normalized(&self, area: &FaceMap<f64>, quads: f64) -> Self {
        let asked = self.quads(area);
        if asked > 0.0 && asked.is_finite() && quads > 0.0 { self.scaled((asked / quads).sqrt()) } else { self.clone() }
    }

    /// Lengths drawn towards their geometric mean: 0 gives squares of one size, 1 leaves them as they are.
    pub fn blended(&self, area: &FaceMap<f64>, adaptivity: f64) -> Self {
        let total: f64 = area.values().iter().sum();
        let log_mean: f64 = area.iter().map(|(f, a)| 0.5 * a * (self.u[f] * self.v[f]).ln()).sum::<f64>()
            / total.max(f64::MIN_POSITIVE);
        let own = |h: &f64| (log_mean + adaptivity * (h.ln() - log_mean)).exp();
        Self { u: self.u.map(own), v: self.v.map(own) }
    }

    /// Lengths that grow by at most `growth` per unit of distance: h(x) ≤ h(y) + growth·|x - y|, along each direction.
    ///
    /// Lengths only shrink; directions are followed by the field's matching, so that the two lengths stay independent
    /// until a singularity mixes them.
    ///
    /// # Input      growth: 0.3 doubles a length over about three quads
    /// # Cost       O(F log F)
    pub fn graded(&self, mesh: &TriMesh, field: &CrossField, growth: f64) -> Self {
        let centre = FaceMap::from_fn(mesh.face_count(), |f| {
            mesh.face_vertices(f).into_iter().map(|v| mesh.position(v)).sum::<DVec3>() / 3.0
        });
        let mut length = [self.u.clone(), self.v.clone()];
        let mut heap: BinaryHeap<Reverse<(u64, u32, u8)>> = BinaryHeap::new();
        // Positive floats order like their bits.
        for f in mesh.faces() {
            (0..2).for_each(|k| heap.push(Reverse((length[k][f].to_bits(), f.0, k as u8))));
        }
        while let Some(Reverse((bits, f, k))) = heap.pop() {
            let f = FaceId(f);
            if length[k as usize][f].to_bits() != bits {
                continue;
            }
            for h in mesh.face_half_edges(f) {
                let Some(t) = mesh.twin(h) else { continue };
                let (g, other) = (mesh.face(t), (k + field.matching(mesh, h)) % 2);
                let limit = f64::from_bits(bits) + growth * centre[f].distance(centre[g]);
                if limit < length[other as usize][g] {
                    length[other as usize][g] = limit;
                    heap.push(Reverse((limit.to_bits(), g.0, other)));
                }
            }
        }
        let [u, v] = length;
        Self { u, v }
    }

    /// Lengths changed so that crosses and lengths fit together best: the curl of the scaled crosses is least.
    ///
    /// A cross field of angle θ is the gradient of a map with lengths h·e^{-ψ} if ∇ψ = J∇θ, J the quarter turn. ψ
    /// solves this in the least-squares sense: a cotangent Poisson equation at the vertices whose right-hand side is the
    /// sum of turns around each.
    ///
    /// # Input      strength: 0 leaves the lengths, 1 corrects fully; range: largest factor by which lengths change
    /// # Errors     the solver's
    /// # Cost       one factorisation, a row per vertex
    /// # Source     [Bommes2012] §8.3, after the curl correction of [Ray2006]; one factor for both lengths, so that only
    /// the common part of the curl goes
    pub fn curl_corrected(
        &self,
        mesh: &TriConnectivity,
        transport: &Transport,
        length: &EdgeMap<f64>,
        field: &CrossField,
        strength: f64,
        range: f64,
    ) -> Result<Self, FieldError> {
        let psi = curl_potential(mesh, transport, length, field)?;
        let limit = range.max(1.0).ln();
        let factor = FaceMap::from_fn(mesh.face_count(), |f| {
            let mean = mesh.face_vertices(f).into_iter().map(|v| psi[v]).sum::<f64>() / 3.0;
            (-strength * mean).clamp(-limit, limit).exp()
        });
        let own = |map: &FaceMap<f64>| FaceMap::from_fn(map.len(), |f| map[f] * factor[f]);
        Ok(Self { u: own(&self.u), v: own(&self.v) })
    }

    /// The first face whose lengths are not positive and finite.
    pub fn first_defect(&self) -> Option<FaceId> {
        let sound = |h: f64| h.is_finite() && h > 0.0;
        self.u.ids().find(|&f| !sound(self.u[f]) || !sound(self.v[f]))
    }
}

/// ψ at every vertex with ∇ψ nearest to J∇θ, mean zero in each component.
///
/// Along edge a → b with face i to the left and j to the right, the turn t = θ_j - θ_i - … is ∇θ times the dual edge
/// from i to j, so that ψ_b - ψ_a should be t·|e|/|e*|; weighted with |e*|/|e| = (cot α + cot β)/2 the
/// right-hand side is the plain sum of turns.
pub fn curl_potential(
    mesh: &TriConnectivity,
    transport: &Transport,
    length: &EdgeMap<f64>,
    field: &CrossField,
) -> Result<VertexMap<f64>, FieldError> {
    /// Least weight of an edge: obtuse pairs of triangles would make it negative. The share of a flat pair.
    const LEAST_WEIGHT: f64 = 1e-3;
    /// Ties every vertex to zero so weakly that only the mean is decided.
    const GAUGE: f64 = 1e-8;
    let n = mesh.vertex_count();
    let cotangent = opposite_cotangents(mesh, length);
    let mut triplets: Vec<Triplet> = mesh.vertices().map(|v| (v.0, v.0, GAUGE)).collect();
    let mut psi = vec![0.0; n];
    for e in mesh.edges() {
        let h = mesh.half_edge(e);
        let Some(t) = mesh.twin(h) else { continue };
        let weight = (0.5 * (cotangent[h] + cotangent[t])).clamp(LEAST_WEIGHT, 1e3);
        let [a, b] = mesh.ends(e);
        triplets.extend([(a.0, a.0, weight), (b.0, b.0, weight), (a.0, b.0, -weight)]);
        let turn = field.turn(mesh, transport, h);
        psi[b.index()] += turn;
        psi[a.index()] -= turn;
    }
    let matrix = SparseSymmetric::from_triplets(n, &triplets);
    let mut factor = SparseCholesky::analyse(&matrix, &[]).map_err(solve_error)?;
    factor.factorize(&matrix).map_err(solve_error)?;
    factor.solve(&mut psi);
    Ok(VertexMap::from_vec(psi))
}

/// Radius of the largest ball that touches the surface at each vertex and contains no other part of it, the smaller of
/// both sides, file units; at most `largest`.
///
/// An upper bound of the local feature size (the distance to the medial axis): near a crease the ball shrinks to
/// nothing, and is given as `smallest`.
///
/// # Cost       about ten closest-point queries per vertex, in parallel
/// # Source     [Bommes2012] §8.3 (local feature size); [Ma2012] (shrinking balls)
pub fn local_feature_size(
    mesh: &TriMesh,
    smallest: f64,
    largest: f64,
    progress: &Progress,
) -> Result<VertexMap<f64>, quadloom_mesh::Cancelled> {
    let nearest = ClosestPoint::new(mesh);
    let radius: Result<Vec<f64>, _> = (0..mesh.vertex_count())
        .into_par_iter()
        .with_min_len(128)
        .map(|k| {
            if k % 128 == 0 {
                progress.check()?;
            }
            let v = quadloom_mesh::VertexId::new(k);
            let normal = mesh.outgoing(v).map(|h| mesh.vector_area(mesh.face(h))).sum::<DVec3>().normalize_or_zero();
            let p = mesh.position(v);
            let ring = mesh.neighbours(v).map(|w| mesh.position(w).distance(p)).fold(0.0, f64::max);
            let sides = [normal, -normal].map(|n| touching_ball(&nearest, p, n, ring, largest));
            Ok(sides[0].min(sides[1]).clamp(smallest.min(largest), largest))
        })
        .collect();
    radius.map(VertexMap::from_vec)
}

/// Radius of the empty ball that touches the surface at `p` and has its centre in the direction of the unit `normal`.
///
/// Points within the ring of triangles around `p` do not shrink it: a flat triangle through `p` admits no ball at all.
fn touching_ball(nearest: &ClosestPoint, p: DVec3, normal: DVec3, ring: f64, largest: f64) -> f64 {
    let mut radius = largest;
    for _ in 0..12 {
        let centre = p + normal * radius;
        let closest = nearest.query(centre);
        if closest.distance >= radius * (1.0 - 1e-3) {
            break;
        }
        let to = closest.position - p;
        let depth = to.dot(normal);
        if depth <= 1e-9 * to.length() || to.length() <= ring {
            break;
        }
        // The ball through p and the point found, tangent at p.
        radius = to.length_squared() / (2.0 * depth);
    }
    radius
}
