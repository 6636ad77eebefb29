//! Untangling at fixed integers: moves the free vertices of a map until no triangle is inverted.
//!
//! In: a [`PlacedMap`] with inverted triangles. Out: the same map with other points.
//! Holds: integers, transitions and feature lines are untouched. Not: success; a map whose integers exclude a
//! fold-free solution stays inverted somewhere, and says so.
//! Source: [Garanzha2021] §3: the energy tr(JᵀJ)/χ + λ(det²+1)/χ with a regularised denominator χ(det, ε),
//! ε lowered between minimisations; here by Newton steps with projected Hessians on growing neighbourhoods.

use crate::fans::{Saddle, is_wrong, unfolded};
use crate::placed::{PlacedMap, turn};
use crate::problem::{FaceGradient, jacobian};
use quadloom_mesh::{FaceId, FaceMap, Progress, TriConnectivity, VertexId};
use quadloom_numeric::{SparseCholesky, SparseSymmetric};
use rayon::prelude::*;

/// How hard the untangler tries.
#[derive(Clone, Debug)]
pub struct UntangleOptions {
    /// Rings of faces around the inverted ones that may move, one attempt each. Default 3, 8, 20: most folds
    /// sit at a singularity and need few; larger regions cost more and reach farther.
    pub rings: Vec<u32>,
    /// Newton steps per attempt. Default 60.
    pub steps: u32,
    /// λ, weight of area against angles. Default 1.
    pub area_weight: f64,
}

impl Default for UntangleOptions {
    fn default() -> Self {
        Self { rings: vec![3, 8, 20], steps: 60, area_weight: 1.0 }
    }
}

impl UntangleOptions {
    /// The first ring alone: removes what is easy, and shows quickly that the rest needs other integers.
    pub fn quick(&self) -> Self {
        Self { rings: self.rings.iter().copied().take(1).collect(), ..self.clone() }
    }
}

/// What untangling did.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct UntangleReport {
    /// Inverted faces before and after.
    pub inverted_before: usize,
    /// Inverted faces that are left.
    pub inverted_after: usize,
    /// Newton steps, over all regions.
    pub steps: u32,
    /// Regions that were optimised.
    pub regions: u32,
}

/// Removes inverted triangles where the integers allow it.
///
/// # Cost       a few sparse factorisations of the moved regions, which are done in parallel
/// # Guarantees never more inverted faces than before
pub fn untangle(
    mesh: &TriConnectivity,
    map: &mut PlacedMap,
    gradient: &FaceMap<FaceGradient>,
    options: &UntangleOptions,
    progress: &Progress,
) -> UntangleReport {
    let mut inverted = map.folded_faces(mesh);
    let mut report = UntangleReport { inverted_before: inverted.len(), ..Default::default() };
    for &rings in &options.rings {
        if inverted.is_empty() || progress.cancelled() {
            break;
        }
        // Regions share no vertex that moves, so that each can be moved on its own copy.
        let moved: Vec<(u32, PlacedMap, Vec<VertexId>)> = regions(mesh, &inverted, rings)
            .into_par_iter()
            .map(|region| {
                let mut own = map.clone();
                let (steps, vertices) = untangle_region(mesh, &mut own, gradient, &region, options, progress);
                (steps, own, vertices)
            })
            .collect();
        for (steps, own, vertices) in moved {
            report.regions += 1;
            report.steps += steps;
            vertices.into_iter().for_each(|v| map.point[v] = own.point[v]);
        }
        inverted = map.folded_faces(mesh);
    }
    report.inverted_after = inverted.len();
    report
}

/// Connected groups of faces within `rings` rings of the given ones.
fn regions(mesh: &TriConnectivity, seeds: &[FaceId], rings: u32) -> Vec<Vec<FaceId>> {
    let mut level: FaceMap<u32> = FaceMap::filled(mesh.face_count(), u32::MAX);
    let mut front: Vec<FaceId> = seeds.to_vec();
    for &f in seeds {
        level[f] = 0;
    }
    for ring in 1..=rings {
        let mut next = Vec::new();
        for &f in &front {
            for v in mesh.face_vertices(f) {
                for h in mesh.outgoing(v) {
                    let g = mesh.face(h);
                    if level[g] == u32::MAX {
                        level[g] = ring;
                        next.push(g);
                    }
                }
            }
        }
        front = next;
    }
    let mut groups = Vec::new();
    let mut done = FaceMap::filled(mesh.face_count(), false);
    for &seed in seeds {
        if done[seed] {
            continue;
        }
        done[seed] = true;
        let (mut group, mut at) = (vec![seed], 0);
        while at < group.len() {
            let f = group[at];
            at += 1;
            for h in mesh.face_half_edges(f) {
                if let Some(t) = mesh.twin(h) {
                    let g = mesh.face(t);
                    if !done[g] && level[g] != u32::MAX {
                        done[g] = true;
                        group.push(g);
                    }
                }
            }
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

/// Minimises the regularised energy of a region with its rim held; keeps the result only if it has no more folds.
///
/// # Output     steps, and the vertices that may have moved
fn untangle_region(
    mesh: &TriConnectivity,
    map: &mut PlacedMap,
    gradient: &FaceMap<FaceGradient>,
    region: &[FaceId],
    options: &UntangleOptions,
    progress: &Progress,
) -> (u32, Vec<VertexId>) {
    let mut whole = Region::new(mesh, map, gradient, region, &[]);
    if whole.unknowns == 0 || progress.cancelled() {
        return (0, Vec::new());
    }
    let before: Vec<[f64; 2]> = whole.vertices.iter().map(|&v| map.point[v]).collect();
    let folds_before = whole.folds(mesh, map);
    let mut steps = 0;
    // 1. Fans that are folded or wound wrongly are laid out and held while the rest gives way.
    let (centres, held) = lay_out_fans(mesh, map, gradient, &whole);
    if !centres.is_empty() {
        let is_rest = |f: &FaceId| !mesh.face_vertices(*f).iter().any(|v| centres.contains(v));
        let rest: Vec<FaceId> = region.iter().copied().filter(is_rest).collect();
        steps += descend(&mut Region::new(mesh, map, gradient, &rest, &held), map, options, progress);
    }
    // 2. Everything.
    steps += descend(&mut whole, map, options, progress);
    progress.spend(EFFORT * steps as usize * region.len());
    if whole.folds(mesh, map) > folds_before {
        for (&v, p) in whole.vertices.iter().zip(before) {
            map.point[v] = p;
        }
    }
    (steps, whole.vertices)
}

/// Places the neighbours of the vertices whose fans need it; returns these vertices and their neighbours.
fn lay_out_fans(
    mesh: &TriConnectivity,
    map: &mut PlacedMap,
    gradient: &FaceMap<FaceGradient>,
    region: &Region,
) -> (Vec<VertexId>, Vec<VertexId>) {
    let moves = |v: VertexId| region.vertices.binary_search(&v).is_ok();
    let (mut centres, mut held) = (Vec::new(), Vec::new());
    for (saddle, is_cone) in map.fans_at(&region.vertices).collect::<Vec<_>>() {
        // Vertices that may move have all their faces in the region.
        if !mesh.neighbours(saddle.vertex).all(|w| moves(w) && !held.contains(&w) && !centres.contains(&w)) {
            continue;
        }
        // Wide corners open by themselves unless a feature runs backwards.
        let is_folded = |f: FaceId| determinant(jacobian(&gradient[f], map.face(mesh, f))) <= 0.0;
        let folded = is_wrong(mesh, map, saddle) || is_cone && saddle.fan(mesh).any(|h| is_folded(mesh.face(h)));
        if let Some(places) = folded.then(|| unfolded(mesh, map, gradient, saddle)).flatten() {
            centres.push(saddle.vertex);
            for (w, p) in places {
                map.point[w] = p;
                held.push(w);
            }
        }
    }
    held.sort_unstable();
    (centres, held)
}

/// Newton steps with ε lowered in between, until nothing is inverted or nothing improves.
fn descend(problem: &mut Region, map: &mut PlacedMap, options: &UntangleOptions, progress: &Progress) -> u32 {
    if problem.unknowns == 0 {
        return 0;
    }
    let mut steps = 0;
    let mut settled = 0;
    let mut epsilon = problem.first_epsilon(map);
    let mut worst = problem.least_determinant(map);
    let mut stagnant = 0;
    while steps < options.steps && !progress.cancelled() {
        steps += 1;
        let old = problem.energy(map, options.area_weight, epsilon);
        let Some(direction) = problem.newton_direction(map, options.area_weight, epsilon) else { break };
        let new = problem.line_search(map, &direction, old, options.area_weight, epsilon);
        let least = problem.least_determinant(map);
        if least > worst + 0.02 * worst.abs() || new < 0.98 * old {
            (worst, stagnant) = (least.max(worst), 0);
        } else {
            stagnant += 1;
        }
        if least <= 0.0 && stagnant >= STAGNANT_STEPS {
            break;
        }
        if least > MIN_DETERMINANT {
            settled += 1;
            if settled >= SETTLING_STEPS || old - new < 1e-3 * old {
                break;
            }
        } else if old - new < 1e-9 * old && epsilon < 1e-9 {
            break;
        }
        epsilon = problem.next_epsilon(map, epsilon, old, new);
    }
    steps
}

/// Area of a triangle over its wanted area above which it counts as safely positive.
///
/// Larger: more Newton steps. Smaller: slivers that lattice rounding could invert (it moves corners by 2^-25).
const MIN_DETERMINANT: f64 = 1e-3;

/// Effort of a Newton step per face of the region.
const EFFORT: usize = 2;

/// Newton steps spent on evening out a region once it is fold-free.
const SETTLING_STEPS: u32 = 4;

/// Steps without a better worst triangle after which a region is given up: its integers exclude a solution.
///
/// Fewer lose folds that open late (seen up to 9 steps on thin fins); more waste time on hopeless ones.
const STAGNANT_STEPS: u32 = 12;

struct Region<'a> {
    gradient: &'a FaceMap<FaceGradient>,
    faces: Vec<FaceId>,
    /// Corner data of each face: vertex, transform, unknown number of each coordinate of the vertex.
    corners: Vec<[Corner; 3]>,
    /// Vertices that may move, ascending.
    vertices: Vec<VertexId>,
    /// Vertices of the faces, ascending.
    touched: Vec<VertexId>,
    /// First unknown of each free coordinate, by listed vertex.
    unknown_of: Vec<[Option<u32>; 2]>,
    unknowns: usize,
    solver: Option<SparseCholesky>,
}

#[derive(Clone, Copy)]
struct Corner {
    vertex: VertexId,
    quarter_turns: u8,
    translation: [f64; 2],
    unknown: [Option<u32>; 2],
}

impl<'a> Region<'a> {
    /// # Input      region: ascending; held: vertices that stay besides those of the rim, ascending
    fn new(
        mesh: &TriConnectivity,
        map: &PlacedMap,
        gradient: &'a FaceMap<FaceGradient>,
        region: &[FaceId],
        held: &[VertexId],
    ) -> Self {
        let mut inside: Vec<VertexId> = region.iter().flat_map(|&f| mesh.face_vertices(f)).collect();
        inside.sort_unstable();
        inside.dedup();
        let touched = inside.clone();
        // A vertex may move if all its faces are in the region.
        let holds = |f: FaceId| region.binary_search(&f).is_ok();
        inside.retain(|&v| held.binary_search(&v).is_err() && mesh.outgoing(v).all(|h| holds(mesh.face(h))));
        let mut unknowns = 0;
        let unknown_of: Vec<[Option<u32>; 2]> = inside
            .iter()
            .map(|&v| {
                map.fixed[v].map(|fixed| {
                    (!fixed).then(|| {
                        unknowns += 1;
                        unknowns as u32 - 1
                    })
                })
            })
            .collect();
        let corners = region
            .iter()
            .map(|&f| {
                mesh.face_half_edges(f).map(|h| {
                    let vertex = mesh.origin(h);
                    let t = map.to_corner[h];
                    let translation = t.translation.map(|x| x as f64 / crate::integer_grid_map::GRID_UNIT as f64);
                    let unknown = inside.binary_search(&vertex).map_or([None; 2], |i| unknown_of[i]);
                    Corner { vertex, quarter_turns: t.quarter_turns, translation, unknown }
                })
            })
            .collect();
        Self {
            gradient,
            faces: region.to_vec(),
            corners,
            vertices: inside,
            touched,
            unknown_of,
            unknowns,
            solver: None,
        }
    }

    /// Inverted faces of the exact map, and wrongly wound fans.
    fn folds(&self, mesh: &TriConnectivity, map: &PlacedMap) -> usize {
        let unit = crate::integer_grid_map::GRID_UNIT as f64;
        let is_inverted = |f: &&FaceId| {
            let [a, b, c] = mesh
                .face_half_edges(**f)
                .map(|h| map.to_corner[h].apply(map.point[mesh.origin(h)].map(|x| (x * unit).round() as i64)));
            crate::integer_grid_map::signed_area(a, b, c) <= 0
        };
        let is_wound_wrongly = |(s, _): &(Saddle, bool)| is_wrong(mesh, map, *s);
        self.faces.iter().filter(is_inverted).count() + map.fans_at(&self.touched).filter(is_wound_wrongly).count()
    }

    fn jacobian(&self, map: &PlacedMap, i: usize) -> [[f64; 2]; 2] {
        let uv = self.corners[i].map(|c| {
            let p = turn(map.point[c.vertex], c.quarter_turns);
            [p[0] + c.translation[0], p[1] + c.translation[1]]
        });
        jacobian(&self.gradient[self.faces[i]], uv)
    }

    fn determinants<'b>(&'b self, map: &'b PlacedMap) -> impl Iterator<Item = f64> + 'b {
        (0..self.faces.len()).map(|i| determinant(self.jacobian(map, i)))
    }

    fn least_determinant(&self, map: &PlacedMap) -> f64 {
        self.determinants(map).fold(f64::INFINITY, f64::min)
    }

    fn first_epsilon(&self, map: &PlacedMap) -> f64 {
        let least = self.least_determinant(map);
        (1e-6 + 0.04 * least.min(0.0).powi(2)).sqrt().max(0.5 * (-least).max(0.0)).max(1e-4)
    }

    /// [Garanzha2021] §3.2: ε falls with the energy's decrease, faster once nothing is inverted.
    fn next_epsilon(&self, map: &PlacedMap, epsilon: f64, old: f64, new: f64) -> f64 {
        let sigma = (1.0 - new / old.max(f64::MIN_POSITIVE)).max(0.1);
        let mu = (1.0 - sigma) * chi(self.least_determinant(map), epsilon).0;
        let least = self.least_determinant(map);
        if least < mu { 2.0 * (mu * (mu - least)).max(0.0).sqrt() } else { 1e-10 }
    }

    fn energy(&self, map: &PlacedMap, lambda: f64, epsilon: f64) -> f64 {
        (0..self.faces.len())
            .map(|i| {
                let j = self.jacobian(map, i);
                let d = determinant(j);
                let (chi, _, _) = chi(d, epsilon);
                let norm: f64 = j.as_flattened().iter().map(|x| x * x).sum();
                self.gradient[self.faces[i]].area * (norm + lambda * (d * d + 1.0)) / chi
            })
            .sum()
    }

    /// Solves H d = −g with the Hessian of each triangle projected to its positive part.
    fn newton_direction(&mut self, map: &PlacedMap, lambda: f64, epsilon: f64) -> Option<Vec<f64>> {
        let mut triplets = Vec::with_capacity(self.faces.len() * 21 + self.unknowns);
        let mut rhs = vec![0.0; self.unknowns];
        for i in 0..self.faces.len() {
            let face = &self.gradient[self.faces[i]];
            let (g, h) = local_model(self.jacobian(map, i), lambda, epsilon);
            let h = positive_part(h);
            // Derivative of the four entries of J by each unknown of the face.
            let mut column: Vec<(u32, [f64; 4])> = Vec::with_capacity(6);
            for (k, c) in self.corners[i].iter().enumerate() {
                for component in 0..2 {
                    let Some(unknown) = c.unknown[component] else { continue };
                    let e = turn(if component == 0 { [1.0, 0.0] } else { [0.0, 1.0] }, c.quarter_turns);
                    let hat = face.hat[k];
                    column.push((unknown, [e[0] * hat.x, e[0] * hat.y, e[1] * hat.x, e[1] * hat.y]));
                }
            }
            for (n, (row, a)) in column.iter().enumerate() {
                rhs[*row as usize] -= face.area * (0..4).map(|k| g[k] * a[k]).sum::<f64>();
                let ha: [f64; 4] = std::array::from_fn(|k| (0..4).map(|l| h[k][l] * a[l]).sum());
                for (col, b) in &column[n..] {
                    let value = face.area * (0..4).map(|k| ha[k] * b[k]).sum::<f64>();
                    // The same unknown can appear twice (a vertex with two corners in one face cannot, but seams
                    // identify none within a face), so (row, col) pairs are distinct.
                    triplets.push((*row, *col, value));
                }
            }
        }
        let scale = triplets.iter().filter(|t| t.0 == t.1).map(|t| t.2).fold(0.0, f64::max);
        for i in 0..self.unknowns as u32 {
            triplets.push((i, i, 1e-10 * scale + 1e-12));
        }
        let matrix = SparseSymmetric::from_triplets(self.unknowns, &triplets);
        // The pattern is that of the region, the same in every step.
        if self.solver.is_none() {
            self.solver = SparseCholesky::analyse(&matrix, &[]).ok();
        }
        let solver = self.solver.as_mut()?;
        solver.factorize(&matrix).ok()?;
        solver.solve(&mut rhs);
        rhs.iter().all(|x| x.is_finite()).then_some(rhs)
    }

    /// Halves the step until the energy falls; returns the new energy and leaves the points there.
    fn line_search(&self, map: &mut PlacedMap, direction: &[f64], old: f64, lambda: f64, epsilon: f64) -> f64 {
        let start: Vec<[f64; 2]> = self.vertices.iter().map(|&v| map.point[v]).collect();
        let mut step = 1.0;
        for _ in 0..30 {
            self.place(map, &start, direction, step);
            let new = self.energy(map, lambda, epsilon);
            if new < old {
                return new;
            }
            step *= 0.5;
        }
        self.place(map, &start, direction, 0.0);
        old
    }

    fn place(&self, map: &mut PlacedMap, start: &[[f64; 2]], direction: &[f64], step: f64) {
        for (i, &v) in self.vertices.iter().enumerate() {
            for (k, unknown) in self.unknown_of[i].iter().enumerate() {
                if let Some(u) = unknown {
                    map.point[v][k] = start[i][k] + step * direction[*u as usize];
                }
            }
        }
    }
}

fn determinant(j: [[f64; 2]; 2]) -> f64 {
    j[0][0] * j[1][1] - j[0][1] * j[1][0]
}

/// χ(D, ε) = (D + √(ε² + D²))/2 with its first two derivatives by D; stable for very negative D.
fn chi(d: f64, epsilon: f64) -> (f64, f64, f64) {
    let root = (epsilon * epsilon + d * d).sqrt().max(f64::MIN_POSITIVE);
    let value = if d >= 0.0 { 0.5 * (d + root) } else { 0.5 * epsilon * epsilon / (root - d) };
    let value = value.max(1e-150);
    (value, value / root, 0.5 * epsilon * epsilon / (root * root * root))
}

/// Gradient and Hessian of (|J|² + λ(D² + 1))/χ(D) by the entries of J = (a, b; c, d), row by row.
fn local_model(j: [[f64; 2]; 2], lambda: f64, epsilon: f64) -> ([f64; 4], [[f64; 4]; 4]) {
    let x = [j[0][0], j[0][1], j[1][0], j[1][1]];
    let d = determinant(j);
    let (c, c1, c2) = chi(d, epsilon);
    let g = [x[3], -x[2], -x[1], x[0]];
    let mut second = [[0.0; 4]; 4];
    (second[0][3], second[3][0], second[1][2], second[2][1]) = (1.0, 1.0, -1.0, -1.0);
    let n = x.iter().map(|v| v * v).sum::<f64>() + lambda * (d * d + 1.0);
    let dn: [f64; 4] = std::array::from_fn(|k| 2.0 * x[k] + 2.0 * lambda * d * g[k]);
    let gradient = std::array::from_fn(|k| dn[k] / c - n * c1 * g[k] / (c * c));
    let hessian = std::array::from_fn(|k| {
        std::array::from_fn(|l| {
            let identity = if k == l { 2.0 } else { 0.0 };
            (identity + 2.0 * lambda * (g[k] * g[l] + d * second[k][l])) / c
                - c1 / (c * c) * (dn[k] * g[l] + g[k] * dn[l])
                - n * ((c2 / (c * c) - 2.0 * c1 * c1 / (c * c * c)) * g[k] * g[l] + c1 / (c * c) * second[k][l])
        })
    });
    (gradient, hessian)
}

/// The matrix with its negative eigenvalues replaced by zero, by Jacobi rotations.
fn positive_part(a: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    let (mut m, mut q) = (a, [[0.0; 4]; 4]);
    for (k, row) in q.iter_mut().enumerate() {
        row[k] = 1.0;
    }
    for _ in 0..12 {
        let off: f64 = (0..4).flat_map(|i| (i + 1..4).map(move |j| (i, j))).map(|(i, j)| m[i][j] * m[i][j]).sum();
        let all: f64 = m.as_flattened().iter().map(|x| x * x).sum();
        if off <= 1e-24 * all {
            break;
        }
        for i in 0..4 {
            for j in i + 1..4 {
                if m[i][j] == 0.0 {
                    continue;
                }
                let theta = (m[j][j] - m[i][i]) / (2.0 * m[i][j]);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let t = if theta == 0.0 { 1.0 } else { t };
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for row in &mut m {
                    (row[i], row[j]) = (c * row[i] - s * row[j], s * row[i] + c * row[j]);
                }
                let (upper, lower) = (m[i], m[j]);
                m[i] = std::array::from_fn(|k| c * upper[k] - s * lower[k]);
                m[j] = std::array::from_fn(|k| s * upper[k] + c * lower[k]);
                for row in &mut q {
                    (row[i], row[j]) = (c * row[i] - s * row[j], s * row[i] + c * row[j]);
                }
            }
        }
    }
    std::array::from_fn(|k| std::array::from_fn(|l| (0..4).map(|e| q[k][e] * m[e][e].max(0.0) * q[l][e]).sum()))
}
