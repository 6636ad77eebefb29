//! Faces of any kind become triangles.
//!
//! In: the soup's faces, positions in the unit cube, position classes. Out: triangles of different positions, each
//! once. Holds: triangles of a face use its corners only and keep its direction. Source: ear clipping.

use super::report::{FindingKind, RepairReport};
use crate::soup::FaceSoup;
use glam::{DVec2, DVec3};

/// Corners up to which ears are chosen by quality, which costs a pass over the polygon for each.
const BEST_EAR_CORNERS: usize = 16;
/// Corners from which a polygon is cut into a plain fan: ear clipping is quadratic, and a face of this size is
/// no sensible input.
const FAN_CORNERS: usize = 4000;

/// Triangles of the soup.
pub(super) struct Triangles {
    /// Vertices of the soup.
    pub corners: Vec<[u32; 3]>,
    /// Face of the soup of each triangle.
    pub input_face: Vec<u32>,
}

pub(super) fn triangles(soup: &FaceSoup, unit: &[DVec3], class: &[u32], report: &mut RepairReport) -> Triangles {
    let mut all = Triangles { corners: Vec::with_capacity(soup.faces.len()), input_face: Vec::new() };
    let mut clipper = EarClipper::default();
    for (f, face) in soup.faces.iter().enumerate() {
        let before = all.corners.len();
        if let [a, b, c] = face[..] {
            all.corners.push([a, b, c]);
        } else {
            clipper.clip(face, unit, class, &mut all.corners);
        }
        // Corners at one position: the face or a part of it has no area; its neighbours meet there.
        let mut kept = before;
        for i in before..all.corners.len() {
            let triangle = all.corners[i];
            let [a, b, c] = triangle.map(|v| class[v as usize]);
            if a != b && b != c && c != a {
                all.corners[kept] = triangle;
                kept += 1;
            }
        }
        all.corners.truncate(kept);
        all.input_face.resize(kept, f as u32);
        if kept == before {
            report.add(FindingKind::DegenerateFace, f as u32);
        } else if face.len() > 3 {
            report.add(FindingKind::Polygon, f as u32);
        }
    }
    drop_copies(&mut all, class, report);
    all
}

/// Keeps the first of triangles with the same vertices, or with the same positions if they hang on nothing.
fn drop_copies(all: &mut Triangles, class: &[u32], report: &mut RepairReport) {
    let sorted = |triangle: [u32; 3]| {
        let mut t = triangle;
        t.sort_unstable();
        t
    };
    let mut order: Vec<([u32; 3], [u32; 3], u32)> = (0..all.corners.len())
        .map(|t| (sorted(all.corners[t].map(|v| class[v as usize])), sorted(all.corners[t]), t as u32))
        .collect();
    order.sort_unstable();
    let mut uses = vec![0u32; class.len()];
    for &v in all.corners.as_flattened() {
        uses[v as usize] += 1;
    }
    let mut drop = vec![false; all.corners.len()];
    for w in order.windows(2) {
        let ((class_a, corners_a, _), (class_b, corners_b, t)) = (w[0], w[1]);
        let alone = |corners: [u32; 3]| corners.iter().all(|&v| uses[v as usize] == 1);
        drop[t as usize] = corners_a == corners_b || (class_a == class_b && alone(corners_b));
    }
    if !drop.contains(&true) {
        return;
    }
    for t in (0..drop.len()).filter(|&t| drop[t]) {
        report.add(FindingKind::DuplicateFace, all.input_face[t]);
    }
    let mut keep = drop.iter().map(|d| !d);
    all.corners.retain(|_| keep.next().unwrap_or(true));
    let mut keep = drop.iter().map(|d| !d);
    all.input_face.retain(|_| keep.next().unwrap_or(true));
}

/// Buffers of the ear clipping, kept from face to face.
#[derive(Default)]
struct EarClipper {
    corners: Vec<u32>,
    flat: Vec<DVec2>,
}

impl EarClipper {
    fn clip(&mut self, face: &[u32], unit: &[DVec3], class: &[u32], out: &mut Vec<[u32; 3]>) {
        // 1. Without repeated neighbours.
        self.corners.clear();
        for &v in face {
            if self.corners.last().is_none_or(|&last| class[last as usize] != class[v as usize]) {
                self.corners.push(v);
            }
        }
        while self.corners.len() > 1
            && class[self.corners[0] as usize] == class[self.corners[self.corners.len() - 1] as usize]
        {
            self.corners.pop();
        }
        let n = self.corners.len();
        if n < 3 {
            return;
        }
        if n >= FAN_CORNERS {
            out.extend((1..n - 1).map(|i| [self.corners[0], self.corners[i], self.corners[i + 1]]));
            return;
        }
        // 2. In the plane of the vector area.
        let at = |i: usize| unit[self.corners[i] as usize];
        let normal: DVec3 = (0..n).map(|i| (at(i) - at(0)).cross(at((i + 1) % n) - at(0))).sum();
        let normal = normal.try_normalize().unwrap_or(DVec3::Z);
        let (x, y) = normal.any_orthonormal_pair();
        self.flat.clear();
        self.flat.extend((0..n).map(|i| DVec2::new((at(i) - at(0)).dot(x), (at(i) - at(0)).dot(y))));
        // 3. Ears.
        let mut start = 0;
        while self.corners.len() > 3 {
            let n = self.corners.len();
            let ear = if n <= BEST_EAR_CORNERS { self.best_ear() } else { self.next_ear(start) };
            out.push([self.corners[(ear + n - 1) % n], self.corners[ear], self.corners[(ear + 1) % n]]);
            self.corners.remove(ear);
            self.flat.remove(ear);
            // One step on, so that the triangles do not all share one corner.
            start = (ear + 1) % (n - 1);
        }
        out.push([self.corners[0], self.corners[1], self.corners[2]]);
    }

    fn triangle(&self, i: usize) -> [DVec2; 3] {
        let n = self.flat.len();
        [self.flat[(i + n - 1) % n], self.flat[i], self.flat[(i + 1) % n]]
    }

    fn is_ear(&self, i: usize) -> bool {
        let n = self.flat.len();
        let [a, b, c] = self.triangle(i);
        if turn(a, b, c) <= 0.0 {
            return false;
        }
        (0..n).filter(|&j| j != i && j != (i + 1) % n && j != (i + n - 1) % n).all(|j| {
            let p = self.flat[j];
            let inside = turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
            !inside || p == a || p == b || p == c
        })
    }

    /// The ear whose triangle is nearest to equilateral; without any ear the corner that turns most.
    fn best_ear(&self) -> usize {
        let quality = |i: usize| {
            let [a, b, c] = self.triangle(i);
            turn(a, b, c) / (a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a))
        };
        let n = self.flat.len();
        let best = |candidates: &mut dyn Iterator<Item = usize>| {
            candidates.map(|i| (quality(i), i)).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))).map(|b| b.1)
        };
        best(&mut (0..n).filter(|&i| self.is_ear(i))).or_else(|| best(&mut (0..n))).unwrap_or(0)
    }

    fn next_ear(&self, start: usize) -> usize {
        let n = self.flat.len();
        (0..n).map(|k| (start + k) % n).find(|&i| self.is_ear(i)).unwrap_or(start)
    }
}

/// Twice the signed area of a triangle.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}
