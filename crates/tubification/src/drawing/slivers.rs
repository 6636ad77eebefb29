//! Takes thin triangles out of a drawing, so that rounding cannot turn them over.
//!
//! In: triangles, a region for each, where vertices lie and which way the surface faces there. Out: fewer triangles.
//! Holds: the surface stays a closed manifold; each region stays one disk with the same neighbours, and its border moves by
//! less than [`THIN`] of the length of triangles beside it. Not: that all slivers go; those between corners of regions stay.
//! Method: short sides are collapsed, along borders of regions or from inside them; the long side of a flat triangle is
//! flipped, and its two halves belong to the region across.

use glam::DVec3;

/// Triangles with a height below this part of the longest side around are slivers: a hundredth of a cell is too small to be
/// seen and thousands of times the rounding of single precision.
const THIN: f64 = 0.01;

/// Rounds at most: what one round leaves, others may free.
const ROUNDS: usize = 8;

/// Least cosine of the angle between a triangle's normal and the surface's after a change.
const FACING: f64 = 0.3;

/// A closed surface that is being changed.
pub(super) struct Sheet<'a> {
    positions: &'a [DVec3],
    normals: &'a [DVec3],
    /// Corners of each triangle and the triangle at first that it is a part of; none where it is gone.
    faces: Vec<Option<([u32; 3], u32)>>,
    /// Region of each triangle at first.
    regions: &'a [u32],
    /// Triangles around each vertex.
    around: Vec<Vec<u32>>,
}

impl<'a> Sheet<'a> {
    pub fn new(positions: &'a [DVec3], normals: &'a [DVec3], faces: &[[u32; 3]], regions: &'a [u32]) -> Self {
        let mut around = vec![Vec::with_capacity(6); positions.len()];
        for (k, corners) in faces.iter().enumerate() {
            corners.iter().for_each(|&v| around[v as usize].push(k as u32));
        }
        let faces = faces.iter().zip(0..).map(|(&corners, k)| Some((corners, k))).collect();
        Self { positions, normals, faces, regions, around }
    }

    /// Takes slivers out.
    ///
    /// # Output     corners of each triangle that is left, and the triangle at first whose region it belongs to
    /// # Cost       linear in the triangles
    pub fn without_slivers(mut self) -> Vec<([u32; 3], u32)> {
        for _ in 0..ROUNDS {
            let mut changed = false;
            for face in 0..self.faces.len() {
                changed |= self.cure(face as u32);
            }
            if !changed {
                break;
            }
        }
        self.faces.into_iter().flatten().collect()
    }

    fn cure(&mut self, face: u32) -> bool {
        let Some((corners, _)) = self.faces[face as usize] else { return false };
        let p = corners.map(|v| self.positions[v as usize]);
        let length = |k: usize| p[k].distance(p[(k + 1) % 3]);
        let longest = (0..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
        let shortest = (0..3).fold(0, |best, k| if length(k) < length(best) { k } else { best });
        let thin = THIN * self.scale(corners);
        let height = (p[1] - p[0]).cross(p[2] - p[0]).length() / length(longest).max(f64::MIN_POSITIVE);
        if height >= thin {
            return false;
        }
        let [a, b] = [corners[shortest], corners[(shortest + 1) % 3]];
        if length(shortest) < thin && (self.collapse(a, b) || self.collapse(b, a)) {
            return true;
        }
        self.flip(face, longest)
    }

    /// The longest side around a triangle.
    fn scale(&self, corners: [u32; 3]) -> f64 {
        let side = |&f: &u32| {
            let (t, _) = self.faces[f as usize]?;
            let p = t.map(|v| self.positions[v as usize]);
            Some(p[0].distance(p[1]).max(p[1].distance(p[2])).max(p[2].distance(p[0])))
        };
        corners.iter().flat_map(|&v| &self.around[v as usize]).filter_map(side).fold(0.0, f64::max)
    }

    fn region(&self, face: u32) -> Option<u32> {
        self.faces[face as usize].map(|(_, first)| self.regions[first as usize])
    }

    /// The triangle on the left of a side.
    fn left_of(&self, a: u32, b: u32) -> Option<u32> {
        let has =
            |f: &&u32| self.faces[**f as usize].is_some_and(|(t, _)| (0..3).any(|k| t[k] == a && t[(k + 1) % 3] == b));
        self.around[a as usize].iter().find(has).copied()
    }

    fn is_border(&self, a: u32, b: u32) -> bool {
        let side = |a, b| self.left_of(a, b).and_then(|f| self.region(f));
        side(a, b) != side(b, a)
    }

    fn neighbours(&self, v: u32) -> Vec<u32> {
        let corners = self.around[v as usize].iter().filter_map(|&f| self.faces[f as usize]);
        let mut found: Vec<u32> = corners.flat_map(|(t, _)| t).filter(|&w| w != v).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Sides between two regions that leave a vertex.
    fn borders(&self, v: u32) -> usize {
        self.neighbours(v).into_iter().filter(|&w| self.is_border(v, w)).count()
    }

    /// Moves a vertex to its neighbour, if the regions allow that and all triangles still face like the surface.
    fn collapse(&mut self, from: u32, to: u32) -> bool {
        let allowed = match self.borders(from) {
            0 => true,
            2 => self.is_border(from, to),
            _ => false,
        };
        let (one, two) = (self.neighbours(from), self.neighbours(to));
        let common = one.iter().filter(|w| two.binary_search(w).is_ok()).count();
        if !allowed || common != 2 || one.len() < 4 {
            return false;
        }
        let star = self.around[from as usize].clone();
        let moved = |f: u32| {
            let (corners, _) = self.faces[f as usize]?;
            Some(corners.map(|v| if v == from { to } else { v }))
        };
        let keeps = |&f: &u32| {
            let gone = self.faces[f as usize].is_some_and(|(t, _)| t.contains(&to));
            gone || moved(f).is_some_and(|t| self.facing(t) > FACING)
        };
        if !star.iter().all(keeps) {
            return false;
        }
        for f in star {
            let Some((corners, first)) = self.faces[f as usize] else { continue };
            if corners.contains(&to) {
                corners.iter().for_each(|&v| self.around[v as usize].retain(|&g| g != f));
                self.faces[f as usize] = None;
            } else {
                self.faces[f as usize] = Some((corners.map(|v| if v == from { to } else { v }), first));
                self.around[to as usize].push(f);
            }
        }
        self.around[from as usize].clear();
        true
    }

    /// Flips the k-th side of a flat triangle a b c; both halves belong to the region across.
    fn flip(&mut self, face: u32, k: usize) -> bool {
        let Some((t, _)) = self.faces[face as usize] else { return false };
        let [a, b, c] = [0, 1, 2].map(|i| t[(k + i) % 3]);
        let Some(other) = self.left_of(b, a) else { return false };
        let Some((s, across)) = self.faces[other as usize] else { return false };
        let Some(d) = s.into_iter().find(|&v| v != a && v != b) else { return false };
        if self.neighbours(c).binary_search(&d).is_ok() || !self.may_leave(c, face, other) {
            return false;
        }
        let new = [[a, d, c], [d, b, c]];
        let least = new.map(|t| self.height(t)).into_iter().fold(f64::INFINITY, f64::min);
        if new.iter().any(|&t| self.facing(t) < FACING) || self.height([a, b, c]) >= least {
            return false;
        }
        self.faces[face as usize] = Some((new[0], across));
        self.faces[other as usize] = Some((new[1], across));
        self.around[b as usize].retain(|&f| f != face);
        self.around[a as usize].retain(|&f| f != other);
        self.around[d as usize].push(face);
        self.around[c as usize].push(other);
        true
    }

    /// Whether a region stays in one piece, and beside the same regions, without a triangle with the corner c: that must be
    /// inside it.
    fn may_leave(&self, c: u32, face: u32, other: u32) -> bool {
        self.region(face) == self.region(other) || self.borders(c) == 0
    }

    fn height(&self, t: [u32; 3]) -> f64 {
        let p = t.map(|v| self.positions[v as usize]);
        let longest = p[0].distance(p[1]).max(p[1].distance(p[2])).max(p[2].distance(p[0]));
        (p[1] - p[0]).cross(p[2] - p[0]).length() / longest.max(f64::MIN_POSITIVE)
    }

    /// Cosine of the angle between a triangle's normal and the surface's.
    fn facing(&self, t: [u32; 3]) -> f64 {
        let [a, b, c] = t.map(|v| self.positions[v as usize]);
        let normal: DVec3 = t.iter().map(|&v| self.normals[v as usize]).sum();
        (b - a).cross(c - a).normalize_or_zero().dot(normal.normalize_or_zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of squares, closed by nothing: borders of the whole are borders of regions, too.
    fn fan(tip: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let ring = (0..6).map(|k| (f64::from(k) * 60f64.to_radians()).sin_cos()).map(|(y, x)| DVec3::new(x, y, 0.0));
        let positions: Vec<DVec3> = std::iter::once(DVec3::ZERO).chain(std::iter::once(tip)).chain(ring).collect();
        // 0 and the tip share the hexagon: the tip has the two triangles to the first and second corner.
        (positions, vec![[0, 2, 1], [1, 2, 3], [0, 1, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6], [0, 6, 7], [0, 7, 2]])
    }

    #[test]
    fn short_sides_collapse_inside_a_region() {
        let (positions, faces) = fan(DVec3::new(1e-5, 5e-6, 0.0));
        let normals = vec![DVec3::Z; positions.len()];
        let sheet = Sheet::new(&positions, &normals, &faces, &[0; 8]);
        let left = sheet.without_slivers();
        assert_eq!(left.len(), 6, "{left:?}");
        assert!(left.iter().all(|(t, _)| !(t.contains(&0) && t.contains(&1))));
    }

    #[test]
    fn corners_of_regions_stay() {
        let (positions, faces) = fan(DVec3::new(1e-5, 5e-6, 0.0));
        let normals = vec![DVec3::Z; positions.len()];
        // Both ends of the short side are corners where three regions meet.
        let left = Sheet::new(&positions, &normals, &faces, &[0, 1, 2, 2, 3, 3, 4, 4]).without_slivers();
        assert_eq!(left.len(), 8, "{left:?}");
    }
}
