//! Removes triangles without area between different positions.
//!
//! In: a manifold draft. Out: the same surface without caps and needles, where the topology allows it.
//! Holds: a collapse obeys the link condition, a flip makes no edge twice, an ear is cut from the boundary only
//! where no vertex is pinched; whatever is left is reported. Source: edge collapse and flip, classical.
//!
//! ```text
//!  cap: apex on the longest side,          needle: one side is nearly a point,
//!  which is flipped                        and is collapsed
//!        d                d
//!      /   \            / | \                 a'──────────── c
//!     a ─m─ b    →     a  │  b                a ─────────────'
//!      (m on ab)        \ m /
//! ```

use super::report::{FindingKind, RepairReport};
use super::{Draft, unit_positions};
use crate::connectivity::TriConnectivity;
use crate::ids::HalfEdgeId;
use glam::DVec3;

const NONE: u32 = u32::MAX;
/// A side this short against the longest one is collapsed, which moves the surface by as little; longer ones make
/// the triangle a cap.
const NEEDLE_REL: f64 = 1e-6;
/// Passes over the triangles without area: a stack of n collinear caps needs up to n of them.
const MAX_ROUNDS: usize = 64;
/// Triangles around a vertex up to which its neighbourhood is edited; keeps hostile fans from costing a square.
const MAX_RING: usize = 4096;

pub(super) fn remove(mut draft: Draft, tolerance: f64, report: &mut RepairReport) -> Draft {
    let unit = unit_positions(&draft.positions);
    let is_flat = |corners: [u32; 3]| Shape::of(corners.map(|v| unit[v as usize])).height_rel <= tolerance;
    let mut flat: Vec<u32> = (0..draft.faces.len() as u32).filter(|&t| is_flat(draft.faces[t as usize])).collect();
    if flat.is_empty() {
        return draft;
    }
    // A draft that is no manifold is refused, with its defects, when the mesh is built.
    let known = draft.connectivity.take();
    let connectivity = known.map_or_else(|| TriConnectivity::from_faces(draft.positions.len(), &draft.faces), Ok);
    let Ok(connectivity) = connectivity else { return draft };
    let mut surface = Surface::new(&connectivity, &draft.faces, &unit);
    let found = flat.clone();
    for _ in 0..MAX_ROUNDS {
        let mut changed = false;
        for &t in &flat {
            changed |= surface.cure(t, tolerance);
        }
        // A flip may leave the neighbour without area instead.
        flat.append(&mut surface.touched);
        flat.sort_unstable();
        flat.dedup();
        flat.retain(|&t| surface.is_flat(t, tolerance));
        if flat.is_empty() || !changed {
            break;
        }
    }
    for &t in &flat {
        report.add(FindingKind::ZeroAreaKept, draft.input_face[t as usize]);
    }
    for &t in found.iter().filter(|t| flat.binary_search(t).is_err()) {
        report.add(FindingKind::ZeroAreaFace, draft.input_face[t as usize]);
    }
    let (faces, alive) = (surface.corners, surface.alive);
    let keep: Vec<usize> = (0..faces.len()).filter(|&t| alive[t]).collect();
    draft.faces = keep.iter().map(|&t| faces[t]).collect();
    draft.input_face = keep.iter().map(|&t| draft.input_face[t]).collect();
    draft
}

/// Extents of a triangle.
struct Shape {
    /// Height over the longest side, relative to that side.
    height_rel: f64,
    /// Length of the shortest side, relative to the longest.
    shortest_rel: f64,
    /// Side `k` runs from corner `k` to the next.
    shortest: usize,
    longest: usize,
}

impl Shape {
    fn of(corner: [DVec3; 3]) -> Self {
        let side = [0, 1, 2].map(|k| corner[k].distance(corner[(k + 1) % 3]));
        let by_length = |a: &usize, b: &usize| side[*a].total_cmp(&side[*b]).then(a.cmp(b));
        let shortest = [0, 1, 2].into_iter().min_by(by_length).unwrap_or(0);
        let longest = [0, 1, 2].into_iter().max_by(by_length).unwrap_or(0);
        let twice_area = (corner[1] - corner[0]).cross(corner[2] - corner[0]).length();
        let long = side[longest];
        Self {
            height_rel: if long > 0.0 { twice_area / (long * long) } else { 0.0 },
            shortest_rel: if long > 0.0 { side[shortest] / long } else { 0.0 },
            shortest,
            longest,
        }
    }
}

/// An editable triangle surface; half-edge `3t + k` is side `k` of triangle `t`.
struct Surface<'a> {
    corners: Vec<[u32; 3]>,
    twin: Vec<u32>,
    alive: Vec<bool>,
    unit: &'a [DVec3],
    /// Triangles that an edit changed.
    touched: Vec<u32>,
}

impl<'a> Surface<'a> {
    fn new(connectivity: &TriConnectivity, faces: &[[u32; 3]], unit: &'a [DVec3]) -> Self {
        let twin = (0..connectivity.half_edge_count()).map(|h| connectivity.twin(HalfEdgeId::new(h)));
        Self {
            corners: faces.to_vec(),
            twin: twin.map(|t| t.map_or(NONE, |t| t.0)).collect(),
            alive: vec![true; faces.len()],
            unit,
            touched: Vec::new(),
        }
    }

    fn shape(&self, t: u32) -> Shape {
        Shape::of(self.corners[t as usize].map(|v| self.unit[v as usize]))
    }

    fn is_flat(&self, t: u32, tolerance: f64) -> bool {
        self.alive[t as usize] && self.shape(t).height_rel <= tolerance
    }

    /// Tries to remove a triangle without area.
    fn cure(&mut self, t: u32, tolerance: f64) -> bool {
        if !self.is_flat(t, tolerance) {
            return false;
        }
        let shape = self.shape(t);
        if shape.shortest_rel <= NEEDLE_REL {
            return self.collapse(3 * t + shape.shortest as u32);
        }
        let longest = 3 * t + shape.longest as u32;
        if self.twin[longest as usize] == NONE { self.cut_ear(t, longest) } else { self.flip(longest) }
    }

    fn origin(&self, h: u32) -> u32 {
        self.corners[h as usize / 3][h as usize % 3]
    }

    fn link(&mut self, g: u32, h: u32) {
        for (a, b) in [(g, h), (h, g)] {
            if a != NONE {
                self.twin[a as usize] = b;
            }
        }
    }

    /// Outgoing half-edges of the origin of `h`, from the boundary if there is one; `None` if they are too many.
    fn ring(&self, h: u32) -> Option<Ring> {
        let mut ring = Ring { outgoing: Vec::new(), closed: true };
        // Clockwise to the boundary, or once around.
        let mut start = h;
        for steps in 0.. {
            let t = self.twin[start as usize];
            if t == NONE {
                ring.closed = false;
                break;
            }
            start = next(t);
            if start == h {
                break;
            }
            if steps > MAX_RING {
                return None;
            }
        }
        let mut current = start;
        loop {
            ring.outgoing.push(current);
            let t = self.twin[prev(current) as usize];
            if t == NONE || t == start {
                return Some(ring);
            }
            current = t;
            if ring.outgoing.len() > MAX_RING {
                return None;
            }
        }
    }

    fn neighbours(&self, ring: &Ring) -> Vec<u32> {
        let mut list: Vec<u32> = ring.outgoing.iter().map(|&h| self.origin(next(h))).collect();
        if !ring.closed {
            list.extend(ring.outgoing.last().map(|&h| self.origin(prev(h))));
        }
        list.sort_unstable();
        list
    }

    /// Moves the origin of `h` into its target, or the other way round if only the origin is on the boundary.
    fn collapse(&mut self, h: u32) -> bool {
        let t = self.twin[h as usize];
        let (Some(from), Some(to)) = (self.ring(h), self.ring(next(h))) else { return false };
        if t != NONE && !from.closed && to.closed {
            return self.collapse(t);
        }
        let both = [Some(h), (t != NONE).then_some(t)];
        let apexes: Vec<u32> = both.iter().flatten().map(|&s| self.origin(prev(s))).collect();
        // An inner edge between boundary vertices would pinch the surface.
        if t != NONE && !from.closed {
            return false;
        }
        let (near, far) = (self.neighbours(&from), self.neighbours(&to));
        let common = near.iter().filter(|v| far.binary_search(v).is_ok()).count();
        if common != apexes.len() {
            return false;
        }
        for &s in both.iter().flatten() {
            // The apex must keep a triangle besides the two that are glued together, and an edge of its own.
            let Some(apex) = self.ring(prev(s)) else { return false };
            if apex.closed && apex.outgoing.len() <= 3 || !apex.closed && apex.outgoing.len() == 1 {
                return false;
            }
        }
        let target = self.origin(next(h));
        for &g in &from.outgoing {
            self.corners[g as usize / 3][g as usize % 3] = target;
            self.touched.push(g / 3);
        }
        for &s in both.iter().flatten() {
            self.link(self.twin[next(s) as usize], self.twin[prev(s) as usize]);
            self.alive[s as usize / 3] = false;
        }
        true
    }

    /// Replaces edge ab by the edge between the apexes of its triangles.
    fn flip(&mut self, h: u32) -> bool {
        let t = self.twin[h as usize];
        let (m, d) = (self.origin(prev(h)), self.origin(prev(t)));
        let Some(ring) = self.ring(prev(h)) else { return false };
        if m == d || self.neighbours(&ring).binary_search(&d).is_ok() {
            return false;
        }
        let (a, b) = (self.origin(h), self.origin(t));
        // a, b, m and b, a, d become a, d, m and d, b, m.
        let [bm, ma, ad, db] = [next(h), prev(h), next(t), prev(t)].map(|s| self.twin[s as usize]);
        let (f, g) = (h / 3, t / 3);
        self.corners[f as usize] = [a, d, m];
        self.corners[g as usize] = [d, b, m];
        self.link(3 * f, ad);
        self.link(3 * f + 1, 3 * g + 2);
        self.link(3 * f + 2, ma);
        self.link(3 * g, db);
        self.link(3 * g + 1, bm);
        for (side, outside) in [(3 * f, ad), (3 * f + 2, ma), (3 * g, db), (3 * g + 1, bm)] {
            self.twin[side as usize] = outside;
        }
        self.touched.extend([f, g]);
        true
    }

    /// Drops a triangle whose longest side is boundary; its apex takes the place of that side.
    fn cut_ear(&mut self, t: u32, longest: u32) -> bool {
        let sides = [next(longest), prev(longest)].map(|s| self.twin[s as usize]);
        let Some(apex) = self.ring(prev(longest)) else { return false };
        if sides.contains(&NONE) || !apex.closed {
            return false;
        }
        for s in sides {
            self.twin[s as usize] = NONE;
        }
        self.alive[t as usize] = false;
        true
    }
}

/// The half-edges that leave a vertex, counter-clockwise.
struct Ring {
    outgoing: Vec<u32>,
    closed: bool,
}

fn next(h: u32) -> u32 {
    h / 3 * 3 + (h + 1) % 3
}

fn prev(h: u32) -> u32 {
    h / 3 * 3 + (h + 2) % 3
}
