//! Where a triangle mesh meets itself.
//!
//! In: a [`TriMesh`]. Out: pairs of faces that share more than their common vertex or edge.
//! Holds: every decision is the sign of an exact determinant, so what is reported meets and what is not does not, whatever
//! lies in one plane or touches; the answer is the same for any number of threads. Faces without area are what they are:
//! segments or points. Not: coordinates whose products leave the range of doubles.
//! Source: own; signs by [Shewchuk1997].

use crate::connectivity::TriConnectivity;
use crate::ids::FaceId;
use crate::mesh::TriMesh;
use glam::DVec3;
use rayon::prelude::*;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Pairs of faces that share a point which is not their common vertex or on their common edge.
///
/// # Output     at most `limit` pairs, the smaller face first, in order; the first ones there are
/// # Cost       near linear where few bounding boxes overlap
/// # Guarantees exact, see the module
pub fn self_intersections(mesh: &TriMesh, limit: usize) -> Vec<[FaceId; 2]> {
    let boxes: Vec<Bounds> = mesh.faces().map(|f| Bounds::of(&corners(mesh, f))).collect();
    let tree = Tree::new(&boxes);
    let faces: Vec<FaceId> = mesh.faces().collect();
    let mut found = Vec::new();
    // Blocks keep the work bounded where there are many pairs.
    for block in faces.chunks(1 << 16) {
        let pairs: Vec<Vec<[FaceId; 2]>> = block.par_iter().map(|&f| met_by(mesh, &boxes, &tree, f)).collect();
        found.extend(pairs.into_iter().flatten());
        if found.len() >= limit {
            found.truncate(limit);
            break;
        }
    }
    found
}

/// Whether a mesh meets itself.
pub fn intersects_itself(mesh: &TriMesh) -> bool {
    !self_intersections(mesh, 1).is_empty()
}

fn corners(mesh: &TriMesh, f: FaceId) -> [DVec3; 3] {
    mesh.face_vertices(f).map(|v| mesh.position(v))
}

fn met_by(mesh: &TriMesh, boxes: &[Bounds], tree: &Tree, f: FaceId) -> Vec<[FaceId; 2]> {
    let mut found = Vec::new();
    tree.overlapping(&boxes[f.index()], |other| {
        if other > f && meet(mesh, f, other) {
            found.push([f, other]);
        }
    });
    found.sort_unstable();
    found
}

/// Whether two faces share more than what they have in common as elements of the mesh.
fn meet(mesh: &TriMesh, f: FaceId, g: FaceId) -> bool {
    let connectivity: &TriConnectivity = mesh.connectivity();
    let (vf, vg) = (connectivity.face_vertices(f), connectivity.face_vertices(g));
    let (a, b) = (corners(mesh, f), corners(mesh, g));
    let shared: Vec<(usize, usize)> =
        (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).filter(|&(i, j)| vf[i] == vg[j]).collect();
    match *shared.as_slice() {
        [] => triangles_meet(&a, &b),
        [(i, j)] => corners_meet(from_corner(&a, i), from_corner(&b, j)),
        [(i, _), (k, _)] => {
            let third_of = |used: [usize; 2]| 3 - used[0] - used[1];
            let (c, d) = (a[third_of([i, k])], b[third_of([shared[0].1, shared[1].1])]);
            folded([a[i], a[k]], c, d)
        }
        _ => true,
    }
}

/// A triangle with one of its corners first.
fn from_corner(t: &[DVec3; 3], k: usize) -> [DVec3; 3] {
    [t[k], t[(k + 1) % 3], t[(k + 2) % 3]]
}

/// Whether two triangles share more than their first corner, which is the same point.
fn corners_meet(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    let (parts_a, parts_b) = (seen_from_first(a), seen_from_first(b));
    // Beyond the common corner, what they share ends on the side opposite it of one of them.
    let meet = |a: &[DVec3; 3], b: &[DVec3; 3]| {
        segment_meets_triangle([a[1], a[2]], b) || segment_meets_triangle([b[1], b[2]], a)
    };
    parts_a.iter().any(|a| parts_b.iter().any(|b| meet(a, b)))
}

/// A triangle as triangles whose first corner is not on the side opposite it: itself, but for a segment with that corner
/// inside or at both ends.
fn seen_from_first([p, a, b]: [DVec3; 3]) -> Vec<[DVec3; 3]> {
    if is_on_segment(p, [a, b]) {
        [a, b].into_iter().filter(|&end| end != p).map(|end| [p, end, end]).collect()
    } else {
        vec![[p, a, b]]
    }
}

fn is_on_segment(p: DVec3, [a, b]: [DVec3; 2]) -> bool {
    AXES.iter().all(|&axis| sign2(axis, a, b, p) == 0 && ranges_meet(axis, [a, b], [p, p]))
}

/// Whether two triangles on a common side share a point beside it.
fn folded([p, q]: [DVec3; 2], c: DVec3, d: DVec3) -> bool {
    if p == q {
        return corners_meet([p, c, c], [p, d, d]);
    }
    if sign3(p, q, c, d) != 0 {
        return false;
    }
    let sides = AXES.map(|axis| (sign2(axis, p, q, c), sign2(axis, p, q, d)));
    let is_segment = |which: fn(&(i8, i8)) -> i8| sides.iter().all(|s| which(s) == 0);
    match (is_segment(|s| s.0), is_segment(|s| s.1)) {
        (false, false) => sides.iter().any(|s| s.0 * s.1 > 0),
        // All on one line: both beyond the same end.
        (true, true) => [[p, q], [q, p]].into_iter().any(|side| is_beyond(c, side) && is_beyond(d, side)),
        _ => false,
    }
}

/// Whether a point on the line of a segment lies beyond its second end.
fn is_beyond(x: DVec3, [from, to]: [DVec3; 2]) -> bool {
    AXES.iter().any(|&k| (from[k] < to[k] && to[k] < x[k]) || (from[k] > to[k] && to[k] > x[k]))
}

fn triangles_meet(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let side = |t: &[DVec3; 3], u: &[DVec3; 3]| u.map(|p| sign3(t[0], t[1], t[2], p));
    let apart = |s: [i8; 3]| s[0] != 0 && s[0] == s[1] && s[1] == s[2];
    if apart(side(a, b)) || apart(side(b, a)) {
        return false;
    }
    let edges = |t: &[DVec3; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    edges(a).into_iter().any(|e| segment_meets_triangle(e, b))
        || edges(b).into_iter().any(|e| segment_meets_triangle(e, a))
}

fn segment_meets_triangle([p, q]: [DVec3; 2], t: &[DVec3; 3]) -> bool {
    let [a, b, c] = *t;
    let (sp, sq) = (sign3(a, b, c, p), sign3(a, b, c, q));
    if sp * sq > 0 {
        return false;
    }
    if sp == 0 && sq == 0 {
        return [[a, b], [b, c], [c, a]].into_iter().any(|side| coplanar_segments_meet([p, q], side))
            || point_in_triangle(p, t)
            || point_in_triangle(q, t);
    }
    let around = [sign3(p, q, a, b), sign3(p, q, b, c), sign3(p, q, c, a)];
    around.iter().all(|&s| s >= 0) || around.iter().all(|&s| s <= 0)
}

/// A segment and a side of a triangle in whose plane it lies, or two segments of a triangle without area.
fn coplanar_segments_meet(first: [DVec3; 2], second: [DVec3; 2]) -> bool {
    sign3(first[0], first[1], second[0], second[1]) == 0 && segments_meet(first, second)
}

/// Two segments in one plane meet just if they do seen along each axis: along one of them at least nothing falls together.
fn segments_meet([p, q]: [DVec3; 2], [a, b]: [DVec3; 2]) -> bool {
    AXES.into_iter().all(|axis| {
        let (sa, sb) = (sign2(axis, p, q, a), sign2(axis, p, q, b));
        let (sp, sq) = (sign2(axis, a, b, p), sign2(axis, a, b, q));
        if sa == 0 && sb == 0 && sp == 0 && sq == 0 {
            return ranges_meet(axis, [p, q], [a, b]);
        }
        sa * sb <= 0 && sp * sq <= 0
    })
}

/// Whether the boxes of two segments meet, seen along an axis.
fn ranges_meet(axis: usize, [p, q]: [DVec3; 2], [a, b]: [DVec3; 2]) -> bool {
    [(axis + 1) % 3, (axis + 2) % 3].into_iter().all(|k| {
        let (low, high) = (p[k].min(q[k]), p[k].max(q[k]));
        a[k].min(b[k]) <= high && low <= a[k].max(b[k])
    })
}

/// Whether a point of a triangle's plane lies in the triangle.
fn point_in_triangle(p: DVec3, [a, b, c]: &[DVec3; 3]) -> bool {
    let inside = |axis: usize| {
        let s = [sign2(axis, *a, *b, p), sign2(axis, *b, *c, p), sign2(axis, *c, *a, p)];
        if s == [0; 3] {
            // Seen edge-on, or a triangle without area.
            let on = |from: DVec3, to: DVec3| ranges_meet(axis, [from, to], [p, p]);
            return on(*a, *b) || on(*b, *c) || on(*c, *a);
        }
        s.iter().all(|&x| x >= 0) || s.iter().all(|&x| x <= 0)
    };
    AXES.into_iter().all(inside)
}

const AXES: [usize; 3] = [0, 1, 2];

fn sign3(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> i8 {
    let point = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
    sign(orient3d(point(a), point(b), point(c), point(d)))
}

/// Turn of three points seen along an axis.
fn sign2(axis: usize, a: DVec3, b: DVec3, c: DVec3) -> i8 {
    let point = |p: DVec3| Coord { x: p[(axis + 1) % 3], y: p[(axis + 2) % 3] };
    sign(orient2d(point(a), point(b), point(c)))
}

fn sign(x: f64) -> i8 {
    if x > 0.0 {
        1
    } else if x < 0.0 {
        -1
    } else {
        0
    }
}

#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    fn of(points: &[DVec3; 3]) -> Self {
        let [a, b, c] = *points;
        Self { low: a.min(b).min(c), high: a.max(b).max(c) }
    }

    fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// A balanced tree of boxes: node k has children 2k + 1 and 2k + 2, leaves hold a few faces.
struct Tree {
    faces: Vec<FaceId>,
    nodes: Vec<(Bounds, [u32; 2])>,
    first_child: Vec<u32>,
}

/// Faces in a leaf; fewer make the tree deeper, more make leaves slower.
const LEAF: usize = 4;

impl Tree {
    fn new(boxes: &[Bounds]) -> Self {
        let mut tree =
            Self { faces: (0..boxes.len()).map(FaceId::new).collect(), nodes: Vec::new(), first_child: Vec::new() };
        if !boxes.is_empty() {
            tree.nodes.push((boxes[0], [0, boxes.len() as u32]));
            tree.first_child.push(0);
            tree.grow(boxes);
        }
        tree
    }

    fn grow(&mut self, boxes: &[Bounds]) {
        let mut at = 0;
        while at < self.nodes.len() {
            let [from, to] = self.nodes[at].1.map(|x| x as usize);
            let own = &mut self.faces[from..to];
            let bounds = own.iter().map(|f| boxes[f.index()]).reduce(Bounds::with).unwrap_or(boxes[0]);
            self.nodes[at].0 = bounds;
            if to - from > LEAF {
                let size = bounds.high - bounds.low;
                let axis = (0..3).max_by(|&i, &j| size[i].total_cmp(&size[j])).unwrap_or(0);
                let place = |f: &FaceId| boxes[f.index()].low[axis] + boxes[f.index()].high[axis];
                let middle = (to - from) / 2;
                own.select_nth_unstable_by(middle, |f, g| place(f).total_cmp(&place(g)).then(f.cmp(g)));
                self.first_child[at] = self.nodes.len() as u32;
                for range in [[from, from + middle], [from + middle, to]] {
                    self.nodes.push((bounds, range.map(|x| x as u32)));
                    self.first_child.push(0);
                }
            }
            at += 1;
        }
    }

    fn overlapping(&self, bounds: &Bounds, mut visit: impl FnMut(FaceId)) {
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            let Some((own, [from, to])) = self.nodes.get(at) else { return };
            if !own.overlaps(bounds) {
                continue;
            }
            match self.first_child[at] {
                0 => self.faces[*from as usize..*to as usize].iter().for_each(|&f| visit(f)),
                child => stack.extend([child as usize, child as usize + 1]),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    fn mesh(points: &[[f64; 3]], faces: &[[u32; 3]]) -> TriMesh {
        TriMesh::new(points.iter().map(|&p| DVec3::from(p)).collect(), faces).unwrap()
    }

    #[test]
    fn generated_shapes_do_not_meet_themselves() {
        for name in ["sphere", "torus", "genus2", "bracket"] {
            assert!(!intersects_itself(&shapes::sample(name).unwrap()), "{name}");
        }
    }

    #[test]
    fn two_triangles_meet_as_they_should() {
        let flat = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let cases: [([[f64; 3]; 3], bool); 9] = [
            ([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [5.0, 5.0, 0.0]], true),
            ([[3.0, 3.0, -1.0], [3.0, 3.0, 1.0], [5.0, 5.0, 0.0]], false),
            ([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], true),
            ([[1.0, 1.0, 0.1], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], false),
            ([[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0]], true),
            ([[5.0, 5.0, 0.0], [6.0, 5.0, 0.0], [5.0, 6.0, 0.0]], false),
            ([[4.0, 0.0, 0.0], [6.0, 0.0, 0.0], [6.0, 0.0, 3.0]], true),
            ([[-1.0, -1.0, 0.0], [9.0, -1.0, 0.0], [-1.0, 9.0, 0.0]], true),
            ([[2.0, 2.0, 0.0], [5.0, 5.0, 0.0], [5.0, 5.0, 0.0]], true),
        ];
        for (other, wanted) in cases {
            let points: Vec<_> = flat.iter().chain(&other).copied().collect();
            assert_eq!(intersects_itself(&mesh(&points, &[[0, 1, 2], [3, 4, 5]])), wanted, "{other:?}");
        }
    }

    #[test]
    fn neighbours_meet_where_they_are_folded_onto_each_other() {
        let hinge = |d: [f64; 3]| mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], d], &[[0, 1, 2], [1, 0, 3]]);
        assert!(!intersects_itself(&hinge([0.0, -1.0, 0.0])));
        assert!(!intersects_itself(&hinge([0.2, 1.0, 0.1])));
        assert!(intersects_itself(&hinge([0.2, 1.0, 0.0])));
    }

    #[test]
    fn a_thick_tube_bent_too_much_meets_itself() {
        let torus = |minor: f64| {
            let (n, m) = (40u32, 16u32);
            let point = |i: u32, j: u32| {
                let (a, b) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(m));
                let [(s, c), (t, d)] = [a, b].map(|x| (x * std::f64::consts::TAU).sin_cos());
                [(1.0 + minor * d) * c, (1.0 + minor * d) * s, minor * t]
            };
            let points: Vec<_> = (0..n).flat_map(|i| (0..m).map(move |j| (i, j))).map(|(i, j)| point(i, j)).collect();
            let at = |i: u32, j: u32| (i % n) * m + j % m;
            let faces: Vec<_> = (0..n)
                .flat_map(|i| (0..m).map(move |j| (i, j)))
                .flat_map(|(i, j)| {
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    [[a, b, c], [a, c, d]]
                })
                .collect();
            mesh(&points, &faces)
        };
        assert!(!intersects_itself(&torus(0.8)));
        assert!(intersects_itself(&torus(1.3)));
    }
}
