//! Closest points on triangle meshes and on feature curves.
//!
//! In: a triangle mesh, or polylines. Out: [`ClosestPoint`] and [`PolylineIndex`], which answer queries.
//! Holds: the result is the true nearest point up to rounding, degenerate triangles and segments included;
//! the same query gives the same answer; ties go to the smaller face or segment.
//! Source: bounding volume hierarchy of boxes; point-triangle distance by Voronoi regions [Ericson2005] §5.1.5.

use crate::features::{ChainId, FeatureGraph};
use crate::ids::FaceId;
use crate::mesh::TriMesh;
use crate::surface_point::SurfacePoint;
use glam::DVec3;

/// Primitives in a leaf at most: fewer cost memory and box tests, more cost primitive tests.
const LEAF_SIZE: usize = 4;
/// Square of the sine of a triangle's first angle from which its interior weights are trusted: their error is
/// about 1e-16 over this; larger values only cost time.
const THIN_REL: f64 = 1e-6;

/// The nearest point of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Where it lies on the mesh.
    pub point: SurfacePoint,
    /// Its position, file units.
    pub position: DVec3,
    /// Its distance from the query, file units; infinite for a mesh without faces and for queries that are not finite.
    pub distance: f64,
}

/// The nearest point of a polyline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainPoint {
    /// Number of the polyline.
    pub chain: ChainId,
    /// Number of the segment; segment `i` goes from vertex `i` to the next.
    pub segment: u32,
    /// Where it lies on the segment, 0..=1.
    pub parameter: f64,
    /// Length of the polyline from its start to the point, file units.
    pub arc: f64,
    /// Its position, file units.
    pub position: DVec3,
    /// Its distance from the query, file units; infinite where there is no segment.
    pub distance: f64,
}

/// Answers closest-point queries against a triangle mesh.
///
/// # Cost       O(F log F) to build, 125 bytes per triangle; a query near the surface takes one to four microseconds
#[derive(Clone, Debug)]
pub struct ClosestPoint {
    tree: BoxTree,
    /// Corners of the triangles, in the tree's order.
    corners: Vec<[DVec3; 3]>,
    /// Place of each face in the tree's order.
    slot_of: Vec<u32>,
}

impl ClosestPoint {
    /// Prepares a mesh for queries.
    pub fn new(mesh: &TriMesh) -> Self {
        let all: Vec<[DVec3; 3]> = mesh.faces().map(|f| mesh.face_vertices(f).map(|v| mesh.position(v))).collect();
        let boxes: Vec<Aabb> = all.iter().map(|c| Aabb::of(c)).collect();
        let tree = BoxTree::new(&boxes);
        let corners = tree.order.iter().map(|&f| all[f as usize]).collect();
        let mut slot_of = vec![0; all.len()];
        for (slot, &f) in tree.order.iter().enumerate() {
            slot_of[f as usize] = slot as u32;
        }
        Self { tree, corners, slot_of }
    }

    /// The nearest point of the mesh.
    pub fn query(&self, p: DVec3) -> Closest {
        self.search(p, Nearest::NONE)
    }

    /// The nearest point of the mesh, found faster where `hint` is a face near it; the hint changes no distance.
    pub fn query_near(&self, p: DVec3, hint: FaceId) -> Closest {
        let Some(&slot) = self.slot_of.get(hint.index()) else { return self.query(p) };
        let start = Nearest { slot, id: hint.0, squared: self.squared_distance(slot, p) };
        self.search(p, if start.squared.is_finite() { start } else { Nearest::NONE })
    }

    /// The nearest point of the mesh if it is not farther than `limit`, file units.
    pub fn query_within(&self, p: DVec3, limit: f64) -> Option<Closest> {
        let start = Nearest { squared: (limit * limit).next_up(), ..Nearest::NONE };
        let nearest = self.tree.nearest(p, start, |slot| self.squared_distance(slot, p));
        (nearest.id != u32::MAX).then(|| self.describe(p, nearest)).filter(|c| c.distance <= limit)
    }

    fn squared_distance(&self, slot: u32, p: DVec3) -> f64 {
        let triangle = &self.corners[slot as usize];
        combine(triangle, closest_weights(triangle, p)).distance_squared(p)
    }

    fn search(&self, p: DVec3, start: Nearest) -> Closest {
        self.describe(p, self.tree.nearest(p, start, |slot| self.squared_distance(slot, p)))
    }

    fn describe(&self, p: DVec3, nearest: Nearest) -> Closest {
        let Some(triangle) = self.corners.get(nearest.slot as usize).filter(|_| nearest.id != u32::MAX) else {
            let point = SurfacePoint { face: FaceId(0), weights: [1.0, 0.0, 0.0] };
            return Closest { point, position: p, distance: f64::INFINITY };
        };
        let weights = closest_weights(triangle, p);
        let position = combine(triangle, weights);
        Closest { point: SurfacePoint { face: FaceId(nearest.id), weights }, position, distance: position.distance(p) }
    }
}

fn combine(triangle: &[DVec3; 3], weights: [f64; 3]) -> DVec3 {
    triangle[0] * weights[0] + triangle[1] * weights[1] + triangle[2] * weights[2]
}

/// Barycentric weights of the point of a triangle nearest to `p` ([Ericson2005] §5.1.5).
///
/// # Guarantees weights in 0..=1 that sum to 1 up to rounding, for degenerate triangles too
pub fn closest_weights(&[a, b, c]: &[DVec3; 3], p: DVec3) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    // Vertex and edge regions; d1..d6 are projections onto the sides at a from each corner.
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let (db, dc) = (d4 - d3, d5 - d6);
    if va <= 0.0 && db >= 0.0 && dc >= 0.0 && db + dc > 0.0 {
        let t = db / (db + dc);
        return [0.0, 1.0 - t, t];
    }
    // Interior. va, vb, vc are differences of nearly equal numbers where the triangle is thin, so that rounding may
    // say "interior" of a point far outside: then the nearest side may be nearer.
    let sum = va + vb + vc;
    let inside = [va / sum, vb / sum, vc / sum];
    let corners = [a, b, c];
    let is_thin = sum <= THIN_REL * ab.length_squared() * ac.length_squared();
    let is_valid = inside.iter().all(|w| (0.0..=1.0).contains(w));
    if is_valid && !is_thin {
        return inside;
    }
    let side = nearest_side(&corners, p);
    let distance = |weights| combine(&corners, weights).distance_squared(p);
    if is_valid && distance(inside) < distance(side) { inside } else { side }
}

fn nearest_side(corners: &[DVec3; 3], p: DVec3) -> [f64; 3] {
    let mut best = (f64::INFINITY, [1.0, 0.0, 0.0]);
    for k in 0..3 {
        let t = closest_parameter(corners[k], corners[(k + 1) % 3], p);
        let mut weights = [0.0; 3];
        (weights[k], weights[(k + 1) % 3]) = (1.0 - t, t);
        let squared = combine(corners, weights).distance_squared(p);
        if squared < best.0 {
            best = (squared, weights);
        }
    }
    best.1
}

/// Parameter in 0..=1 of the point of segment ab nearest to `p`; 0 where the segment is a point.
pub fn closest_parameter(a: DVec3, b: DVec3, p: DVec3) -> f64 {
    let side = b - a;
    let squared = side.length_squared();
    if squared > 0.0 { (side.dot(p - a) / squared).clamp(0.0, 1.0) } else { 0.0 }
}

/// Answers closest-point queries against polylines, one by one or all together.
///
/// # Cost       O(n log n) to build; a query is logarithmic for curves near it
#[derive(Clone, Debug)]
pub struct PolylineIndex {
    lines: Vec<Line>,
    /// First segment of each line in the numbering over all lines.
    first: Vec<u32>,
    all: SegmentTree,
}

#[derive(Clone, Debug)]
struct Line {
    /// A closed line repeats its first point at the end.
    points: Vec<DVec3>,
    /// Length from the start to each point.
    arc: Vec<f64>,
    closed: bool,
    segments: SegmentTree,
}

#[derive(Clone, Debug)]
struct SegmentTree {
    tree: BoxTree,
    /// Ends of the segments, in the tree's order.
    ends: Vec<[DVec3; 2]>,
}

impl SegmentTree {
    fn new(segments: &[[DVec3; 2]]) -> Self {
        let tree = BoxTree::new(&segments.iter().map(|s| Aabb::of(s)).collect::<Vec<_>>());
        let ends = tree.order.iter().map(|&s| segments[s as usize]).collect();
        Self { tree, ends }
    }

    fn nearest(&self, p: DVec3) -> Nearest {
        self.tree.nearest(p, Nearest::NONE, |slot| {
            let [a, b] = self.ends[slot as usize];
            a.lerp(b, closest_parameter(a, b, p)).distance_squared(p)
        })
    }
}

impl PolylineIndex {
    /// Prepares polylines for queries: their points and whether they are closed (without repeating the first point).
    pub fn new<L: AsRef<[DVec3]>>(polylines: &[(L, bool)]) -> Self {
        let lines: Vec<Line> = polylines.iter().map(|(points, closed)| Line::new(points.as_ref(), *closed)).collect();
        let mut first = vec![0u32];
        let mut segments = Vec::new();
        for line in &lines {
            segments.extend(line.points.windows(2).map(|w| [w[0], w[1]]));
            first.push(segments.len() as u32);
        }
        Self { lines, first, all: SegmentTree::new(&segments) }
    }

    /// Prepares the chains of a feature graph; polyline `i` is chain `i`.
    pub fn from_features(mesh: &TriMesh, features: &FeatureGraph) -> Self {
        let lines: Vec<(Vec<DVec3>, bool)> = features
            .chains
            .iter()
            .map(|chain| (chain.vertices.iter().map(|&v| mesh.position(v)).collect(), chain.closed))
            .collect();
        Self::new(&lines)
    }

    /// Number of polylines.
    pub fn len(&self) -> usize {
        self.lines.len()
    }
    /// Whether there is no polyline.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }
    /// Length of a polyline, file units.
    pub fn length(&self, chain: ChainId) -> f64 {
        self.lines[chain as usize].arc.last().copied().unwrap_or(0.0)
    }
    /// Whether a polyline is closed.
    pub fn is_closed(&self, chain: ChainId) -> bool {
        self.lines[chain as usize].closed
    }

    /// The points between the segments of a polyline, with their lengths from its start, file units, ascending; ends of
    /// open polylines are not among them, the start of a closed one is.
    pub fn joints(&self, chain: ChainId) -> impl Iterator<Item = (f64, DVec3)> + '_ {
        let line = &self.lines[chain as usize];
        let first = usize::from(!line.closed);
        let last = line.points.len().saturating_sub(1);
        (first..last).map(|i| (line.arc[i], line.points[i]))
    }

    /// The nearest point of one polyline.
    pub fn query(&self, chain: ChainId, p: DVec3) -> ChainPoint {
        let nearest = self.lines[chain as usize].segments.nearest(p);
        self.describe(chain, nearest.id, p)
    }

    /// The nearest point of all polylines; `None` where there is no segment.
    pub fn query_any(&self, p: DVec3) -> Option<ChainPoint> {
        let nearest = self.all.nearest(p);
        if nearest.id == u32::MAX {
            return None;
        }
        let chain = self.first.partition_point(|&s| s <= nearest.id) - 1;
        Some(self.describe(chain as ChainId, nearest.id - self.first[chain], p))
    }

    /// The point of a polyline at a length from its start, file units; clamped to the ends, or wrapped if closed.
    pub fn at(&self, chain: ChainId, arc: f64) -> ChainPoint {
        let line = &self.lines[chain as usize];
        let total = self.length(chain);
        let arc = if line.closed && total > 0.0 { arc.rem_euclid(total) } else { arc.clamp(0.0, total) };
        let last = line.points.len().saturating_sub(2);
        let segment = line.arc.partition_point(|&s| s <= arc).saturating_sub(1).min(last);
        let Some([a, b]) = line.ends(segment) else {
            let position = line.points.first().copied().unwrap_or(DVec3::ZERO);
            return ChainPoint { chain, segment: 0, parameter: 0.0, arc: 0.0, position, distance: 0.0 };
        };
        let length = line.arc[segment + 1] - line.arc[segment];
        let t = if length > 0.0 { ((arc - line.arc[segment]) / length).clamp(0.0, 1.0) } else { 0.0 };
        ChainPoint { chain, segment: segment as u32, parameter: t, arc, position: a.lerp(b, t), distance: 0.0 }
    }

    fn describe(&self, chain: ChainId, segment: u32, p: DVec3) -> ChainPoint {
        let line = &self.lines[chain as usize];
        let Some([a, b]) = line.ends(segment as usize) else {
            return ChainPoint { chain, segment: 0, parameter: 0.0, arc: 0.0, position: p, distance: f64::INFINITY };
        };
        let parameter = closest_parameter(a, b, p);
        let position = a.lerp(b, parameter);
        let arc = line.arc[segment as usize];
        let arc = arc + parameter * (line.arc[segment as usize + 1] - arc);
        ChainPoint { chain, segment, parameter, arc, position, distance: position.distance(p) }
    }
}

impl Line {
    fn new(points: &[DVec3], closed: bool) -> Self {
        let mut points = points.to_vec();
        if closed && let Some(&first) = points.first() {
            points.push(first);
        }
        let mut arc = vec![0.0];
        for w in points.windows(2) {
            arc.push(arc[arc.len() - 1] + w[0].distance(w[1]));
        }
        let segments: Vec<[DVec3; 2]> = points.windows(2).map(|w| [w[0], w[1]]).collect();
        Self { segments: SegmentTree::new(&segments), points, arc, closed }
    }

    fn ends(&self, segment: usize) -> Option<[DVec3; 2]> {
        Some([*self.points.get(segment)?, *self.points.get(segment + 1)?])
    }
}

/// Numbers of the points that lie on the inside of a segment, up to `tolerance`, and not at its ends.
pub(crate) fn segments_through(points: &[DVec3], segments: &[[DVec3; 2]], tolerance: f64) -> Vec<usize> {
    let index = SegmentTree::new(segments);
    let limit = Nearest { squared: tolerance * tolerance, ..Nearest::NONE };
    let inside = |p: DVec3| {
        index.tree.nearest(p, limit, |slot| {
            let [a, b] = index.ends[slot as usize];
            let at_end = a.distance(p).min(b.distance(p)) <= 2.0 * tolerance;
            if at_end { f64::INFINITY } else { a.lerp(b, closest_parameter(a, b, p)).distance_squared(p) }
        })
    };
    (0..points.len()).filter(|&i| inside(points[i]).id != u32::MAX).collect()
}

/// An axis-parallel box.
#[derive(Clone, Copy, Debug)]
struct Aabb {
    lo: DVec3,
    hi: DVec3,
}

impl Aabb {
    const EMPTY: Self = Self { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY };

    fn of(points: &[DVec3]) -> Self {
        points.iter().fold(Self::EMPTY, |b, &p| Self { lo: b.lo.min(p), hi: b.hi.max(p) })
    }

    fn join(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    #[inline]
    fn squared_distance(&self, p: DVec3) -> f64 {
        (self.lo - p).max(p - self.hi).max(DVec3::ZERO).length_squared()
    }
}

/// The best primitive found so far.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    slot: u32,
    id: u32,
    squared: f64,
}

impl Nearest {
    const NONE: Self = Self { slot: 0, id: u32::MAX, squared: f64::INFINITY };
}

/// A binary tree of boxes over numbered primitives.
#[derive(Clone, Debug)]
struct BoxTree {
    nodes: Vec<Node>,
    /// Primitive at each place of the tree's order.
    order: Vec<u32>,
}

/// A node with its range of the order; an inner node's children follow it and stand at `right`.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    first: u32,
    /// Number of primitives of a leaf; 0 for inner nodes.
    count: u32,
    right: u32,
}

impl BoxTree {
    fn new(boxes: &[Aabb]) -> Self {
        let mut items: Vec<(DVec3, u32)> =
            boxes.iter().enumerate().map(|(i, b)| (0.5 * b.lo + 0.5 * b.hi, i as u32)).collect();
        let mut nodes = Vec::with_capacity(2 * items.len().div_ceil(LEAF_SIZE));
        if !items.is_empty() {
            build(boxes, &mut items, 0, &mut nodes);
        }
        Self { nodes, order: items.into_iter().map(|(_, i)| i).collect() }
    }

    /// The primitive of smallest squared distance, ties by its number, that is better than `best`.
    fn nearest(&self, p: DVec3, mut best: Nearest, squared_distance: impl Fn(u32) -> f64) -> Nearest {
        // Depth is at most 32 halvings, each of which leaves one node waiting.
        let mut waiting = [(0u32, 0.0f64); 40];
        let mut depth = 0;
        let Some(root) = self.nodes.first() else { return best };
        let mut next = Some((0u32, root.bounds.squared_distance(p)));
        while let Some((node, bound)) = next {
            next = None;
            let n = &self.nodes[node as usize];
            if bound > best.squared {
            } else if n.count > 0 {
                for slot in n.first..n.first + n.count {
                    let (squared, id) = (squared_distance(slot), self.order[slot as usize]);
                    if squared < best.squared || (squared == best.squared && id < best.id) {
                        best = Nearest { slot, id, squared };
                    }
                }
            } else {
                let children = [node + 1, n.right].map(|c| (c, self.nodes[c as usize].bounds.squared_distance(p)));
                let [near, far] = if children[1].1 < children[0].1 { [children[1], children[0]] } else { children };
                waiting[depth] = far;
                depth += 1;
                next = Some(near);
            }
            if next.is_none() && depth > 0 {
                depth -= 1;
                next = Some(waiting[depth]);
            }
        }
        best
    }
}

/// Splits at the median centre along the longest extent of the centres; returns the box.
fn build(boxes: &[Aabb], items: &mut [(DVec3, u32)], first: u32, nodes: &mut Vec<Node>) -> Aabb {
    let place = nodes.len();
    nodes.push(Node { bounds: Aabb::EMPTY, first, count: items.len() as u32, right: 0 });
    let bounds = if items.len() <= LEAF_SIZE {
        items.iter().fold(Aabb::EMPTY, |b, &(_, i)| b.join(boxes[i as usize]))
    } else {
        let centres = items.iter().fold(Aabb::EMPTY, |b, &(c, _)| b.join(Aabb { lo: c, hi: c }));
        let axis = (centres.hi - centres.lo).max_position();
        let half = items.len() / 2;
        items.select_nth_unstable_by(half, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
        let (low, high) = items.split_at_mut(half);
        let low_box = build(boxes, low, first, nodes);
        nodes[place].right = nodes.len() as u32;
        nodes[place].count = 0;
        low_box.join(build(boxes, high, first + half as u32, nodes))
    };
    nodes[place].bounds = bounds;
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::FeatureOptions;
    use crate::shapes;
    use proptest::prelude::*;

    /// Distance to a triangle by a dense search over its barycentric weights: independent, and never too small.
    fn sampled_distance(corners: &[DVec3; 3], p: DVec3) -> f64 {
        let n = 60;
        let mut best = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n - i {
                let (a, b) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                best = best.min(combine(corners, [1.0 - a - b, a, b]).distance(p));
            }
        }
        best
    }

    fn point() -> impl Strategy<Value = DVec3> {
        [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64].prop_map(DVec3::from_array)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn triangle_distance_is_the_smallest(a in point(), b in point(), c in point(), p in point(), kind in 0..5) {
            let c = match kind { 0 => a, 1 => a.lerp(b, 0.3), 2 => a.lerp(b, 0.3) + c * 1e-12, _ => c };
            let corners = [a, b, c];
            let weights = closest_weights(&corners, p);
            prop_assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)));
            prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let (found, sampled) = (combine(&corners, weights).distance(p), sampled_distance(&corners, p));
            prop_assert!(found <= sampled + 1e-9, "{found} against {sampled}");
        }

        #[test]
        fn queries_agree_with_all_faces(p in point(), scale in 0.1..3.0f64, hint in 0u32..320) {
            let mesh = shapes::with_noise(&shapes::sphere(1.0, 2), 0.1, 5);
            let index = ClosestPoint::new(&mesh);
            let p = p * scale;
            let brute = mesh
                .faces()
                .map(|f| {
                    let corners = mesh.face_vertices(f).map(|v| mesh.position(v));
                    combine(&corners, closest_weights(&corners, p)).distance(p)
                })
                .fold(f64::INFINITY, f64::min);
            let found = index.query(p);
            prop_assert_eq!(found.distance, brute);
            prop_assert_eq!(found.point.position(&mesh), found.position);
            prop_assert_eq!(index.query_near(p, FaceId(hint)).distance, brute);
            prop_assert_eq!(index.query_within(p, brute * 1.001).map(|c| c.distance), Some(brute));
            prop_assert!(index.query_within(p, brute * 0.999).is_none());
        }

        #[test]
        fn chain_queries_agree_with_all_segments(p in point(), scale in 0.1..8.0f64) {
            let mesh = shapes::bracket(0.5);
            let (features, _) = FeatureGraph::detect(&mesh, &FeatureOptions::default());
            let index = PolylineIndex::from_features(&mesh, &features);
            let p = p * scale;
            let mut best_of_all = f64::INFINITY;
            for (id, chain) in features.chains.iter().enumerate() {
                let mut vertices = chain.vertices.clone();
                if chain.closed {
                    vertices.push(vertices[0]);
                }
                let ends = |w: &[crate::ids::VertexId]| (mesh.position(w[0]), mesh.position(w[1]));
                let brute = vertices
                    .windows(2)
                    .map(|w| {
                        let (a, b) = ends(w);
                        a.lerp(b, closest_parameter(a, b, p)).distance(p)
                    })
                    .fold(f64::INFINITY, f64::min);
                let found = index.query(id as ChainId, p);
                prop_assert_eq!(found.distance, brute);
                let (a, b) = ends(&vertices[found.segment as usize..]);
                prop_assert_eq!(a.lerp(b, found.parameter), found.position);
                prop_assert!(index.at(id as ChainId, found.arc).position.distance(found.position) < 1e-9);
                best_of_all = best_of_all.min(brute);
            }
            prop_assert_eq!(index.query_any(p).map(|c| c.distance), Some(best_of_all));
        }
    }

    #[test]
    fn a_point_is_not_inside_a_collapsed_triangle() {
        // Found by triangle_distance_is_the_smallest: rounding put it inside, far from its nearest point.
        let a = DVec3::new(0.685_803_360_200_084_5, 0.073_618_216_484_591_12, 0.0);
        let b = DVec3::new(-0.773_792_487_740_461_3, 0.0, 0.0);
        let p = DVec3::new(-0.396_400_508_626_571_8, 0.221_955_859_227_309_48, 0.0);
        let corners = [a, b, a.lerp(b, 0.3)];
        let on_side = a.lerp(b, closest_parameter(a, b, p)).distance(p);
        assert!((combine(&corners, closest_weights(&corners, p)).distance(p) - on_side).abs() < 1e-12);
    }

    #[test]
    fn hostile_queries_have_an_answer() {
        let mesh = shapes::sphere(1.0, 1);
        let index = ClosestPoint::new(&mesh);
        assert_eq!(index.query(DVec3::NAN).distance, f64::INFINITY);
        assert_eq!(index.query_near(DVec3::NAN, FaceId(7)).distance, f64::INFINITY);
        assert!(index.query_near(DVec3::X, FaceId(99999)).distance < 0.1);
        let empty = ClosestPoint::new(&TriMesh::new(Vec::new(), &[]).unwrap());
        assert_eq!(empty.query(DVec3::ZERO).distance, f64::INFINITY);
        let lines = PolylineIndex::new(&[(vec![DVec3::X], true), (vec![], false)]);
        assert!(lines.query_any(DVec3::ZERO).is_some_and(|c| c.distance == 1.0));
        assert_eq!(lines.query(1, DVec3::ZERO).distance, f64::INFINITY);
        assert_eq!(lines.at(1, 3.0).arc, 0.0);
    }
}
