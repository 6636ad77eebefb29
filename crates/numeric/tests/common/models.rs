//! Synthetic problems of the two kinds met in quadrangulation, at any size.
#![allow(dead_code)] // Each program uses its own part of it.

use quadloom_numeric::{Constraints, MixedIntegerProblem, Quadratic};

/// A number in −1..1 that depends on the arguments only.
pub fn noise(a: usize, b: usize) -> f64 {
    let mut h = (a as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (b as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
    h ^= h >> 29;
    h = h.wrapping_mul(0xBF58_476D_1CE4_E5B9);
    h ^= h >> 32;
    (h % 2_000_001) as f64 / 1e6 - 1.0
}

/// Cross field on a torus of 2m² triangles: one angle for each triangle, one period jump for each edge,
/// E = Σ (θ_i − θ_j + κ + π/2·p)² ([Bommes2012] §8.2). One triangle in 40 is constrained; jumps are zero
/// along a forest grown from these. Many integers of local influence.
pub fn field_problem(m: usize, roughness: f64) -> MixedIntegerProblem {
    let triangles = 2 * m * m;
    let edges = torus_edges(m);
    let fixed: Vec<bool> = (0..triangles).map(|t| t == 0 || noise(t, 77) > 0.95).collect();
    let tree = forest(triangles, &edges, &fixed);
    let mut problem = MixedIntegerProblem { quadratic: Quadratic::new(triangles + edges.len()), ..Default::default() };
    for (e, &(i, j)) in edges.iter().enumerate() {
        let jump = triangles + e;
        let kappa = roughness * (noise(e, 5) + 0.5 * (i as f64 * 0.013).sin());
        problem.quadratic.add_square(&[(i, 1.0), (j, -1.0), (jump, std::f64::consts::FRAC_PI_2)], -kappa, 1.0);
        problem.integers.push(jump);
        if tree[e] {
            problem.constraints.fix(jump, 0.0, e);
        }
    }
    for t in (0..triangles).filter(|&t| fixed[t]) {
        problem.constraints.fix(t, 0.7 * noise(t, 3), edges.len() + t);
    }
    problem
}

fn torus_edges(m: usize) -> Vec<(usize, usize)> {
    let lower = |i: usize, j: usize| 2 * ((i % m) * m + j % m);
    let cells = (0..m).flat_map(|i| (0..m).map(move |j| (i, j)));
    cells
        .flat_map(|(i, j)| {
            let upper = lower(i, j) + 1;
            [(lower(i, j), upper), (upper, lower(i + 1, j)), (upper, lower(i, j + 1))]
        })
        .collect()
}

/// Breadth-first forest from the fixed triangles: which edges it uses.
fn forest(triangles: usize, edges: &[(usize, usize)], fixed: &[bool]) -> Vec<bool> {
    let mut around = vec![Vec::new(); triangles];
    for (e, &(i, j)) in edges.iter().enumerate() {
        around[i].push((e, j));
        around[j].push((e, i));
    }
    let mut reached = fixed.to_vec();
    let mut queue: std::collections::VecDeque<usize> = (0..triangles).filter(|&t| fixed[t]).collect();
    let mut used = vec![false; edges.len()];
    while let Some(t) = queue.pop_front() {
        for &(e, other) in &around[t] {
            if !reached[other] {
                reached[other] = true;
                used[e] = true;
                queue.push_back(other);
            }
        }
    }
    used
}

/// Parametrisation of a plate of about m² vertices, cut into strips that are glued by transitions with
/// integer translations, in two places each, with straight features on integer lines
/// ([Bommes2012] §8.4). Few integers of global influence.
pub fn map_problem(m: usize, strips: usize, features: usize, edge_length: f64) -> MixedIntegerProblem {
    let plate = Plate { m, width: m / strips, strips };
    let vertices = plate.strips * plate.width * m;
    let translations = 4 * (strips - 1);
    let n = 2 * vertices + translations + features;
    let mut problem = MixedIntegerProblem { quadratic: Quadratic::new(n), ..Default::default() };
    problem.integers.extend(2 * vertices..n);
    for strip in 0..strips {
        add_strip_energy(&mut problem.quadratic, &plate, strip, edge_length);
    }
    for seam in 0..strips - 1 {
        add_seam(&mut problem.constraints, &plate, seam, 2 * vertices + 4 * seam);
    }
    for feature in 0..features {
        add_feature(&mut problem.constraints, &plate, (feature, features), 2 * vertices + translations + feature);
    }
    problem.constraints.fix(0, 0.0, 0);
    problem.constraints.fix(1, 0.0, 0);
    problem
}

struct Plate {
    m: usize,
    width: usize,
    strips: usize,
}

impl Plate {
    /// u of the vertex in column i, row j of a strip; v is the next variable.
    fn u(&self, strip: usize, i: usize, j: usize) -> usize {
        2 * ((strip * self.width + i) * self.m + j)
    }

    /// Quarter turns of the parametrisation of a strip against the plate.
    fn turns(&self, strip: usize) -> usize {
        (strip * 7) % 4
    }
}

fn add_strip_energy(quadratic: &mut Quadratic, plate: &Plate, strip: usize, edge_length: f64) {
    for i in 0..plate.width - 1 {
        for j in 0..plate.m - 1 {
            let at = |di, dj| plate.u(strip, i + di, j + dj);
            let x = (strip * plate.width + i) as f64 / plate.m as f64;
            let bend = 0.3 * (5.0 * x).sin() * (4.0 * j as f64 / plate.m as f64).cos();
            let angle = bend + plate.turns(strip) as f64 * std::f64::consts::FRAC_PI_2;
            let (s, c) = angle.sin_cos();
            let weight = 0.5 * (1.0 + 0.1 * noise(strip * plate.m + i, j));
            for (corner, along_x, along_y) in [(at(0, 0), at(1, 0), at(0, 1)), (at(1, 1), at(0, 1), at(1, 0))] {
                let sign = if corner == at(0, 0) { 1.0 } else { -1.0 } / edge_length;
                for (component, (gx, gy)) in [(0, (c, s)), (1, (-s, c))] {
                    let step = |to: usize| [(to + component, 1.0), (corner + component, -1.0)];
                    quadratic.add_square(&step(along_x), sign * gx, weight);
                    quadratic.add_square(&step(along_y), sign * gy, weight);
                }
            }
        }
    }
}

/// Right border of a strip = left border of the next, turned and moved; the middle third is left open.
fn add_seam(constraints: &mut Constraints, plate: &Plate, seam: usize, translation: usize) {
    let turns = (plate.turns(seam + 1) + 4 - plate.turns(seam)) % 4;
    let (c, s) = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][turns];
    for j in (0..plate.m).filter(|j| !(plate.m / 3..2 * plate.m / 3).contains(j)) {
        let t = translation + if j < plate.m / 3 { 0 } else { 2 };
        let (a, b) = (plate.u(seam, plate.width - 1, j), plate.u(seam + 1, 0, j));
        constraints.add(&[(b, 1.0), (a, -c), (a + 1, -s), (t, -1.0)], 0.0, 2 * j);
        constraints.add(&[(b + 1, 1.0), (a, s), (a + 1, -c), (t + 1, -1.0)], 0.0, 2 * j + 1);
    }
    // The first place is an edge of the spanning tree: its translation can be taken for zero.
    constraints.fix(translation, 0.0, 0);
    constraints.fix(translation + 1, 0.0, 0);
}

/// A run of vertices along a column lies on one integer line of u or v.
fn add_feature(constraints: &mut Constraints, plate: &Plate, (feature, features): (usize, usize), line: usize) {
    let pick = |salt, n: usize| ((noise(feature, salt) + 1.0) * 0.499_999 * n as f64) as usize;
    let (strip, i, j) = (pick(1, plate.strips), pick(2, plate.width), pick(3, plate.m));
    let component = plate.turns(strip) % 2;
    let length = (12 * plate.m / features).max(3);
    for row in j..(j + length).min(plate.m) {
        constraints.add(&[(plate.u(strip, i, row) + component, 1.0), (line, -1.0)], 0.0, 1000 + feature);
    }
}
