//! Joins triangles along edges, orients them, and makes every fan of corners a vertex.
//!
//! In: triangles of different positions, position classes. Out: faces that form an oriented manifold.
//! Holds: every side has at most one partner; fans are paths or cycles, so vertices are manifold; where two edges
//! would join the same two vertices, one gets a vertex in its middle.
//! Source: cutting and stitching [Gueziec2001]; orientation by disjoint sets with parity.

use super::polygons::Triangles;
use super::report::{FindingKind, RepairReport};
use super::{Draft, RepairError};
use crate::union_find::UnionFind;
use glam::DVec3;

const NONE: u32 = u32::MAX;
/// Faces at one edge up to which partners are sought; more are all left open. Each pair of them is compared.
const MAX_FACES_AT_EDGE: usize = 64;

/// Cosine between the ways of two faces from their edge below which one goes straight on in the other, within twenty
/// degrees.
const STRAIGHT: f64 = -0.94;

pub(super) fn glue(
    triangles: &Triangles,
    positions: &[DVec3],
    unit: &[DVec3],
    class: &[u32],
    max_fin_faces: usize,
    report: &mut RepairReport,
) -> Result<Draft, RepairError> {
    let mut joint = Joint::new(triangles, unit, class);
    // 1. Sides by position, then by vertices.
    let groups = joint.sides_by_edge();
    // 2. Partners beyond doubt, then the others.
    joint.join_manifold_edges(&groups)?;
    joint.join_other_edges(&groups, report);
    // 3. Scraps.
    joint.drop_fins(&groups, max_fin_faces, report);
    // 4. Orientation.
    let flipped = joint.orientation();
    for t in (0..flipped.len()).filter(|&t| flipped[t] && !joint.dropped[t]) {
        report.add(FindingKind::FlippedFace, triangles.input_face[t]);
    }
    // 5. Vertices.
    Ok(joint.number_vertices(&flipped, positions, report))
}

/// Sides are numbered like half-edges: side `k` of triangle `t` is `3t + k`, and so is the corner it leaves.
struct Joint<'a> {
    triangles: &'a Triangles,
    unit: &'a [DVec3],
    class: &'a [u32],
    partner: Vec<u32>,
    sides: ParitySets,
    dropped: Vec<bool>,
}

/// A side with its edge: by position, and by vertices.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    by_class: (u32, u32),
    by_vertex: (u32, u32),
    side: u32,
}

impl<'a> Joint<'a> {
    fn new(triangles: &'a Triangles, unit: &'a [DVec3], class: &'a [u32]) -> Self {
        let count = triangles.corners.len();
        Self {
            triangles,
            unit,
            class,
            partner: vec![NONE; 3 * count],
            sides: ParitySets::new(count),
            dropped: vec![false; count],
        }
    }

    fn ends(&self, side: u32) -> (u32, u32) {
        let (t, k) = (side as usize / 3, side as usize % 3);
        (self.triangles.corners[t][k], self.triangles.corners[t][(k + 1) % 3])
    }

    fn apex(&self, side: u32) -> u32 {
        self.triangles.corners[side as usize / 3][(side as usize + 2) % 3]
    }

    fn class_of(&self, v: u32) -> u32 {
        self.class[v as usize]
    }

    fn sides_by_edge(&self) -> Vec<Side> {
        let ordered = |a: u32, b: u32| (a.min(b), a.max(b));
        let mut sides: Vec<Side> = (0..self.partner.len() as u32)
            .map(|side| {
                let (a, b) = self.ends(side);
                let by_class = ordered(self.class_of(a), self.class_of(b));
                Side { by_class, by_vertex: ordered(a, b), side }
            })
            .collect();
        sides.sort_unstable();
        sides
    }

    /// Whether two sides of one edge run in the same direction, so that one of their triangles must be flipped.
    fn same_direction(&self, s: u32, r: u32) -> bool {
        self.class_of(self.ends(s).0) == self.class_of(self.ends(r).0)
    }

    /// Joins two free sides if the orientation of what hangs on them allows it.
    fn join(&mut self, s: u32, r: u32) -> bool {
        let odd = self.same_direction(s, r);
        let allowed = s / 3 != r / 3 && self.sides.join(s / 3, r / 3, odd);
        if allowed {
            self.partner[s as usize] = r;
            self.partner[r as usize] = s;
        }
        allowed
    }

    /// Joins sides where exactly two triangles share an edge by its vertices.
    fn join_manifold_edges(&mut self, sides: &[Side]) -> Result<(), RepairError> {
        for group in sides.chunk_by(|a, b| a.by_vertex == b.by_vertex) {
            let [s, r] = group else { continue };
            if !self.join(s.side, r.side) {
                let face = |side: u32| self.triangles.input_face[side as usize / 3];
                let (a, b) = s.by_vertex;
                return Err(RepairError::NotOrientable { a, b, first: face(s.side), second: face(r.side) });
            }
        }
        Ok(())
    }

    /// Joins the remaining sides of each edge: by vertices, then by position.
    ///
    /// Where the input is oriented, faces at an edge of more than two are joined as they face first, so that solids which
    /// touch along the edge stay solids; only what has no partner then is turned over for one.
    fn join_other_edges(&mut self, sides: &[Side], report: &mut RepairReport) {
        let mut pairs = sides.chunk_by(|a, b| a.by_class == b.by_class).filter(|edge| edge.len() == 2);
        let oriented = pairs.all(|edge| !self.same_direction(edge[0].side, edge[1].side));
        for edge in sides.chunk_by(|a, b| a.by_class == b.by_class) {
            let groups = || edge.chunk_by(|a, b| a.by_vertex == b.by_vertex).chain([edge]);
            if oriented && edge.len() > 2 {
                groups().for_each(|group| self.join_alike(group));
            }
            groups().for_each(|group| self.join_flattest(group));
            let open = edge.iter().filter(|s| self.partner[s.side as usize] == NONE);
            if edge.len() > 2 {
                for s in open {
                    report.add(FindingKind::NonManifoldEdge, self.triangles.input_face[s.side as usize / 3]);
                }
            }
        }
    }

    /// Joins free sides of a group, flattest pairs first.
    fn join_flattest(&mut self, group: &[Side]) {
        self.join_by(group, |joint, s, r| Some(joint.away_from_edge(s).dot(joint.away_from_edge(r))));
    }

    /// Joins free sides of a group that face alike: those that go straight on, then corners of solids, the sharpest
    /// first, then the others, the flattest first.
    fn join_alike(&mut self, group: &[Side]) {
        self.join_by(group, |joint, s, r| {
            if joint.same_direction(s, r) {
                return None;
            }
            let (to_s, to_r) = (joint.away_from_edge(s), joint.away_from_edge(r));
            let turn = to_s.dot(to_r);
            Some(match turn {
                ..STRAIGHT => turn,
                _ if to_r.dot(joint.normal(s)) < 0.0 => 2.0 - turn,
                _ => 5.0 + turn,
            })
        });
    }

    /// Joins free sides of a group, pairs of the smallest cost first; `None` is never joined.
    fn join_by(&mut self, group: &[Side], cost: impl Fn(&Self, u32, u32) -> Option<f64>) {
        let free: Vec<u32> = group.iter().map(|s| s.side).filter(|&s| self.partner[s as usize] == NONE).collect();
        if free.len() < 2 || free.len() > MAX_FACES_AT_EDGE {
            return;
        }
        let mut pairs = Vec::new();
        for (i, &s) in free.iter().enumerate() {
            for &r in &free[i + 1..] {
                // Never back to back: that would close a pocket without a volume.
                if self.class_of(self.apex(s)) != self.class_of(self.apex(r)) {
                    pairs.extend(cost(self, s, r).map(|cost| (cost, s, r)));
                }
            }
        }
        pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for (_, s, r) in pairs {
            if self.partner[s as usize] == NONE && self.partner[r as usize] == NONE {
                self.join(s, r);
            }
        }
    }

    /// Drops pieces of a few triangles that were cut off at edges with more than two faces.
    fn drop_fins(&mut self, sides: &[Side], max_faces: usize, report: &mut RepairReport) {
        let count = self.triangles.corners.len();
        let mut cut_off = vec![false; count];
        for edge in sides.chunk_by(|a, b| a.by_class == b.by_class).filter(|edge| edge.len() > 2) {
            for s in edge.iter().filter(|s| self.partner[s.side as usize] == NONE) {
                cut_off[self.sides.root(s.side / 3).0 as usize] = true;
            }
        }
        let roots: Vec<usize> = (0..count as u32).map(|t| self.sides.root(t).0 as usize).collect();
        let mut size = vec![0usize; count];
        roots.iter().for_each(|&r| size[r] += 1);
        // A model of scraps only is not to vanish.
        if size.iter().all(|&n| n <= max_faces) {
            return;
        }
        for (t, &root) in roots.iter().enumerate() {
            if cut_off[root] && size[root] <= max_faces {
                self.dropped[t] = true;
                report.add(FindingKind::DroppedFin, self.triangles.input_face[t]);
            }
        }
    }

    /// Unit vector in the triangle, perpendicular to a side; two of them are opposite where the surface is flat.
    fn away_from_edge(&self, side: u32) -> DVec3 {
        let (a, b) = self.ends(side);
        let [a, b, c] = [a, b, self.apex(side)].map(|v| self.unit[v as usize]);
        let along = (b - a).normalize_or_zero();
        ((c - a) - along * along.dot(c - a)).normalize_or_zero()
    }

    /// Normal of a side's triangle as it came, not normalised.
    fn normal(&self, side: u32) -> DVec3 {
        let [a, b, c] = self.triangles.corners[side as usize / 3].map(|v| self.unit[v as usize]);
        (b - a).cross(c - a)
    }

    /// Which triangles are to be turned over.
    fn orientation(&mut self) -> Vec<bool> {
        let count = self.triangles.corners.len();
        let place: Vec<(u32, bool)> = (0..count as u32).map(|t| self.sides.root(t)).collect();
        // Of each set: triangles like its root, triangles unlike it, sixfold volume as the root has it, closed.
        let mut like = vec![0usize; count];
        let mut unlike = vec![0usize; count];
        let mut volume = vec![0.0f64; count];
        let mut closed = vec![true; count];
        for (t, &(root, odd)) in place.iter().enumerate() {
            let root = root as usize;
            *(if odd { &mut unlike[root] } else { &mut like[root] }) += 1;
            let [a, b, c] = self.triangles.corners[t].map(|v| self.unit[v as usize]);
            volume[root] += a.cross(b).dot(c) * if odd { -1.0 } else { 1.0 };
            closed[root] &= self.partner[3 * t..3 * t + 3].iter().all(|&p| p != NONE);
        }
        let turn_root = |root: usize| match (like[root], unlike[root]) {
            (_, 0) => false,
            (0, _) => true,
            (l, u) if closed[root] && volume[root] != 0.0 => volume[root] < 0.0 || (volume[root].is_nan() && u > l),
            (l, u) => u > l,
        };
        place.iter().map(|&(root, odd)| odd != turn_root(root as usize)).collect()
    }

    /// Fans of joined corners become vertices, numbered by the soup's vertices.
    fn number_vertices(&self, flipped: &[bool], positions: &[DVec3], report: &mut RepairReport) -> Draft {
        let mut fans = self.fans();
        // 1. Order: by the smallest vertex of the soup in the fan, then by the smallest corner.
        let corners = self.triangles.corners.as_flattened();
        let mut smallest = vec![NONE; corners.len()];
        for (c, &v) in corners.iter().enumerate().filter(|&(c, _)| !self.dropped[c / 3]) {
            let root = fans.root(c);
            smallest[root] = smallest[root].min(v);
        }
        let mut order: Vec<(u32, u32)> =
            (0..corners.len()).filter(|&c| smallest[c] != NONE).map(|c| (smallest[c], c as u32)).collect();
        order.sort_unstable();
        let mut id = vec![NONE; corners.len()];
        for (i, &(_, root)) in order.iter().enumerate() {
            id[root as usize] = i as u32;
        }
        for w in order.windows(2).filter(|w| w[0].0 == w[1].0) {
            report.add(FindingKind::NonManifoldVertex, w[1].0);
        }
        self.report_welds(&mut fans, &smallest, report);
        // 2. Faces, turned as they must be.
        let mut draft = Draft {
            positions: order.iter().map(|o| positions[o.0 as usize]).collect(),
            origin: order.iter().map(|o| Some(o.0)).collect(),
            faces: Vec::with_capacity(flipped.len()),
            input_face: Vec::with_capacity(flipped.len()),
            connectivity: None,
        };
        let vertex_of: Vec<u32> = (0..corners.len()).map(|c| id[fans.root(c)]).collect();
        // 3. A vertex in the middle of edges that others double.
        let middle = self.double_edges(&vertex_of, positions, &mut draft, report);
        for (t, &flip) in flipped.iter().enumerate().filter(|&(t, _)| !self.dropped[t]) {
            let mut polygon = Vec::with_capacity(6);
            let mut first_middle = 0;
            for s in 3 * t..3 * t + 3 {
                polygon.push(vertex_of[s]);
                if middle[s] != NONE {
                    first_middle = if first_middle == 0 { polygon.len() } else { first_middle };
                    polygon.push(middle[s]);
                }
            }
            if flip {
                polygon.reverse();
                first_middle = if first_middle == 0 { 0 } else { polygon.len() - 1 - first_middle };
            }
            // A fan about a middle never makes a triangle of three points of one side.
            polygon.rotate_left(first_middle);
            for w in polygon[1..].windows(2) {
                draft.faces.push([polygon[0], w[0], w[1]]);
                draft.input_face.push(self.triangles.input_face[t]);
            }
        }
        draft
    }

    /// Corners that meet across joined sides.
    fn fans(&self) -> UnionFind {
        let mut fans = UnionFind::new(self.partner.len());
        let after = |s: u32| (s / 3 * 3 + (s + 1) % 3) as usize;
        for s in 0..self.partner.len() as u32 {
            let r = self.partner[s as usize];
            if r == NONE || r < s {
                continue;
            }
            let (start, end) = if self.same_direction(s, r) { (r as usize, after(r)) } else { (after(r), r as usize) };
            fans.join(s as usize, start);
            fans.join(after(s), end);
        }
        fans
    }

    fn report_welds(&self, fans: &mut UnionFind, smallest: &[u32], report: &mut RepairReport) {
        let mut welded = vec![false; self.class.len()];
        let corners = self.triangles.corners.as_flattened();
        for (c, &v) in corners.iter().enumerate().filter(|&(c, _)| !self.dropped[c / 3]) {
            welded[v as usize] |= smallest[fans.root(c)] != v;
        }
        for v in (0..welded.len()).filter(|&v| welded[v]) {
            report.add(FindingKind::WeldedVertex, v as u32);
        }
    }

    /// The middle vertex of each side whose edge has the same vertices as an earlier edge.
    fn double_edges(
        &self,
        vertex_of: &[u32],
        positions: &[DVec3],
        draft: &mut Draft,
        report: &mut RepairReport,
    ) -> Vec<u32> {
        let mut middle = vec![NONE; self.partner.len()];
        let after = |s: u32| s / 3 * 3 + (s + 1) % 3;
        let mut edges: Vec<(u32, u32, u32)> = (0..self.partner.len() as u32)
            .filter(|&s| self.partner[s as usize] > s && !self.dropped[s as usize / 3])
            .map(|s| {
                let (a, b) = (vertex_of[s as usize], vertex_of[after(s) as usize]);
                (a.min(b), a.max(b), s)
            })
            .collect();
        edges.sort_unstable();
        for w in edges.windows(2).filter(|w| (w[0].0, w[0].1) == (w[1].0, w[1].1)) {
            let s = w[1].2;
            report.add(FindingKind::DoubleEdge, self.triangles.input_face[s as usize / 3]);
            let new = draft.origin.len() as u32;
            draft.origin.push(None);
            let (a, b) = self.ends(s);
            draft.positions.push(0.5 * positions[a as usize] + 0.5 * positions[b as usize]);
            for side in [s, self.partner[s as usize]] {
                if side != NONE {
                    middle[side as usize] = new;
                }
            }
        }
        middle
    }
}

/// Disjoint sets of triangles that know whether two of a set must have opposite directions.
struct ParitySets {
    parent: Vec<u32>,
    odd: Vec<bool>,
}

impl ParitySets {
    fn new(len: usize) -> Self {
        Self { parent: (0..len as u32).collect(), odd: vec![false; len] }
    }

    /// The set's name, and whether `t` is opposite to it.
    fn root(&mut self, t: u32) -> (u32, bool) {
        // Two passes: find the root and the parity of the whole path, then shorten the path.
        let (mut root, mut odd) = (t, false);
        while self.parent[root as usize] != root {
            odd ^= self.odd[root as usize];
            root = self.parent[root as usize];
        }
        let (mut i, mut rest) = (t, odd);
        while self.parent[i as usize] != root && i != root {
            let (next, step) = (self.parent[i as usize], self.odd[i as usize]);
            self.parent[i as usize] = root;
            self.odd[i as usize] = rest;
            rest ^= step;
            i = next;
        }
        (root, odd)
    }

    /// Records that two triangles have equal (or, if `odd`, opposite) directions; false if that contradicts.
    fn join(&mut self, a: u32, b: u32, odd: bool) -> bool {
        let ((ra, oa), (rb, ob)) = (self.root(a), self.root(b));
        if ra == rb {
            return oa ^ ob == odd;
        }
        let (low, high) = (ra.min(rb), ra.max(rb));
        self.parent[high as usize] = low;
        self.odd[high as usize] = oa ^ ob ^ odd;
        true
    }
}
