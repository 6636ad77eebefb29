//! Surfaces and curves for the evaluation of `quadloom distance`.
//!
//! In: names, OBJ files of triangles. Out: generated surfaces, curves on a model, points and corners of a file.
//! Holds: the same bytes each time.

use serde_json::{Value, json};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Vertices and triangles of an OBJ file; vertices count from 0.
pub struct Triangles {
    points: Vec<[f64; 3]>,
    faces: Vec<[usize; 3]>,
}

impl Triangles {
    /// Reads `v` and `f` lines.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let point = |line: &str| {
            let mut x = line.strip_prefix("v ")?.split_whitespace().map(|x| x.parse().unwrap_or(f64::NAN));
            Some([x.next()?, x.next()?, x.next()?])
        };
        let face = |line: &str| {
            let corners = line.strip_prefix("f ")?.split_whitespace();
            let mut numbers = corners.map(|c| c.split('/').next()?.parse::<usize>().ok()?.checked_sub(1));
            Some([numbers.next()??, numbers.next()??, numbers.next()??])
        };
        let points: Vec<[f64; 3]> = text.lines().filter_map(point).collect();
        let faces: Vec<[usize; 3]> = text.lines().filter_map(face).collect();
        let most = faces.iter().flatten().max().ok_or_else(|| format!("{}: no face", path.display()))?;
        if *most >= points.len() {
            return Err(format!("{}: a face names vertex {}, there are {}", path.display(), most + 1, points.len()));
        }
        Ok(Self { points, faces })
    }

    /// The vertex with the smallest number that a face uses.
    pub fn first_used(&self) -> usize {
        self.faces.iter().flatten().copied().min().unwrap_or(0)
    }

    /// For each vertex whether a face uses it.
    pub fn used(&self) -> Vec<bool> {
        let mut used = vec![false; self.points.len()];
        self.faces.iter().flatten().for_each(|&v| used[v] = true);
        used
    }

    fn centre(&self, face: &[usize; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| face.iter().map(|&v| self.points[v][k]).sum::<f64>() / 3.0)
    }

    /// Lowest and highest coordinates.
    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let used = self.faces.iter().flatten().map(|&v| self.points[v]);
        used.fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), p| {
            ([0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k])))
        })
    }

    /// Points on the surface around a model's middle, each the centre of the face nearest to a direction on the
    /// bounding box's ellipsoid, as a file of curves has them; a closed curve repeats its first.
    pub fn curve_around(&self, corners: usize, is_closed: bool) -> Value {
        let (low, high) = self.bounds();
        let nearest = |k: usize| {
            let angle = k as f64 * std::f64::consts::TAU / corners as f64;
            let direction = [angle.cos(), angle.sin(), 0.3 * (2.0 * angle).sin()];
            let apart = |face: &[usize; 3]| {
                let p = self.centre(face);
                let offset = |k: usize| {
                    let half = (0.5 * (high[k] - low[k])).max(f64::MIN_POSITIVE);
                    (p[k] - 0.5 * (low[k] + high[k])) / half - direction[k]
                };
                (0..3).map(|k| offset(k).powi(2)).sum::<f64>()
            };
            let distances = self.faces.iter().map(apart).enumerate();
            distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(face, _)| face)
        };
        let last = if is_closed { corners } else { corners / 2 };
        let mut faces: Vec<usize> = (0..=last).map(|k| nearest(k % corners)).collect();
        faces.dedup();
        let third = 1.0 / 3.0;
        let curve = faces.iter().map(|f| json!({ "face": f, "weights": [third, third, third] }));
        json!([curve.collect::<Vec<_>>()])
    }
}

/// A torus with bumps of several lengths, `2·side²` triangles, as a binary PLY.
pub fn write_torus(path: &Path, side: u32) -> std::io::Result<()> {
    let mut out = BufWriter::new(std::fs::File::create(path)?);
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\n\
         property double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        side * side,
        2 * side * side
    )?;
    let angle = |k: u32| f64::from(k) * std::f64::consts::TAU / f64::from(side);
    for j in 0..side {
        for i in 0..side {
            let position = on_torus(angle(i), angle(j));
            position.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
        }
    }
    let id = |i: u32, j: u32| (j % side) * side + i % side;
    for j in 0..side {
        for i in 0..side {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            for triangle in [[a, b, c], [a, c, d]] {
                out.write_all(&[3])?;
                triangle.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
            }
        }
    }
    out.flush()
}

/// Radii 1 and 0.4, and bumps without a common symmetry.
fn on_torus(u: f64, v: f64) -> [f64; 3] {
    let bumps = 0.03 * (7.0 * u).sin() * (5.0 * v).cos() + 0.01 * (23.0 * u + 3.0 * v).sin()
        - 0.004 * (61.0 * v).cos() * (47.0 * u).sin();
    let r = 0.4 + bumps;
    let around = 1.0 + r * v.cos();
    [around * u.cos(), around * u.sin(), r * v.sin()]
}

/// A square of irregular triangles, `2·n²` of them, as an OBJ.
pub fn write_plane(path: &Path, n: u32) -> std::io::Result<()> {
    let mut out = BufWriter::new(std::fs::File::create(path)?);
    for j in 0..=n {
        for i in 0..=n {
            let inner = i > 0 && i < n && j > 0 && j < n;
            let shift = |a: u32, b: u32| {
                if inner { 0.3 * (f64::from(a) * 7919.0 + f64::from(b) * 104_729.0).sin() } else { 0.0 }
            };
            let (x, y) = (f64::from(i) + shift(i, j), f64::from(j) + shift(j + 50, i));
            writeln!(out, "v {} {} 0", x / f64::from(n), y / f64::from(n))?;
        }
    }
    let id = |i: u32, j: u32| j * (n + 1) + i + 1;
    for (i, j) in (0..n * n).map(|k| (k % n, k / n)) {
        let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
        let pair = if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
        for [a, b, c] in pair {
            writeln!(out, "f {a} {b} {c}")?;
        }
    }
    out.flush()
}
