//! Cuts the pieces of a picture into triangles.
//!
//! In: outlines, simple polygons in (u, v). Out: triangles. Holds: every side of an outline is a side of one triangle.
//! Method: ears are cut off, that with the largest smallest angle first; then diagonals are flipped while that makes the
//! smallest angle larger.

use super::local::{LocalPicture, LocalTriangle, Outline};
use glam::DVec2;

impl LocalPicture {
    fn uv(&self, i: u32) -> DVec2 {
        self.points[i as usize].uv
    }

    /// The triangles of an outline.
    ///
    /// # Cost       cubic in its corners, of which there are some dozen
    pub fn ears(&self, outline: &Outline) -> Vec<LocalTriangle> {
        let mut left = outline.corners.clone();
        let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(left.len());
        while left.len() > 3 {
            let n = left.len();
            let ear = |k: usize| [left[(k + n - 1) % n], left[k], left[(k + 1) % n]];
            let best = (0..n).max_by(|&i, &j| self.quality(ear(i), &left).total_cmp(&self.quality(ear(j), &left)));
            let Some(k) = best else { break };
            triangles.push(ear(k));
            left.remove(k);
        }
        triangles.extend(<[u32; 3]>::try_from(left).ok());
        self.flip(&mut triangles);
        let (flag, strip) = (outline.flag, outline.strip);
        triangles.into_iter().map(|corners| LocalTriangle { corners, flag, strip }).collect()
    }

    /// Sine of the smallest angle; worse than any where another corner lies in the triangle.
    fn quality(&self, corners: [u32; 3], others: &[u32]) -> f64 {
        let t = corners.map(|i| self.uv(i));
        let holds = |z: DVec2| (0..3).all(|k| (t[(k + 1) % 3] - t[k]).perp_dot(z - t[k]) >= 0.0);
        if others.iter().any(|i| !corners.contains(i) && holds(self.uv(*i))) {
            return -2.0;
        }
        smallest_sine(t)
    }

    fn flip(&self, triangles: &mut [[u32; 3]]) {
        // Each flip makes a smallest angle larger; the bound is for ties by rounding.
        for _ in 0..10 * triangles.len() {
            let Some((i, j, pair)) = self.better_diagonal(triangles) else { return };
            [triangles[i], triangles[j]] = pair;
        }
    }

    fn better_diagonal(&self, triangles: &[[u32; 3]]) -> Option<(usize, usize, [[u32; 3]; 2])> {
        let worst =
            |pair: [[u32; 3]; 2]| pair.map(|t| smallest_sine(t.map(|i| self.uv(i)))).into_iter().fold(1.0, f64::min);
        for i in 0..triangles.len() {
            for j in i + 1..triangles.len() {
                for k in 0..3 {
                    let [a, b, c] = [0, 1, 2].map(|s| triangles[i][(k + s) % 3]);
                    let there = (0..3).find(|&s| triangles[j][s] == b && triangles[j][(s + 1) % 3] == a);
                    let Some(s) = there else { continue };
                    let d = triangles[j][(s + 2) % 3];
                    let flipped = [[a, d, c], [d, b, c]];
                    if worst(flipped) > worst([triangles[i], triangles[j]]) + 1e-12 {
                        return Some((i, j, flipped));
                    }
                }
            }
        }
        None
    }
}

/// Sine of the smallest angle, negative where the triangle is clockwise.
fn smallest_sine(t: [DVec2; 3]) -> f64 {
    let sine = |k: usize| {
        let (u, v) = (t[(k + 1) % 3] - t[k], t[(k + 2) % 3] - t[k]);
        u.perp_dot(v) / (u.length() * v.length()).max(f64::MIN_POSITIVE)
    };
    sine(0).min(sine(1)).min(sine(2))
}
