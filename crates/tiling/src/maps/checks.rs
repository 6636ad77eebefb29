//! Exact tests of a map: folded faces, a border that crosses itself.
//!
//! In: a mesh and a place per vertex. Out: the faces of non-positive area; whether the border is a simple polygon.
//! Holds: both are decided by exact predicates on the doubles as they are. If no face is folded and the border is
//! simple, the map is one-to-one: every point is covered as often as the border winds about it.

use quadloom_mesh::topology::boundary_loops;
use quadloom_mesh::{DVec2, FaceId, TriMesh, VertexMap};
use robust::{Coord, orient2d};

/// Faces whose signed area in the plane is not positive.
///
/// # Output     ascending; also faces with a coordinate that is not finite
/// # Cost       linear
/// # Guarantees exact, by adaptive precision ([Shewchuk1997])
pub fn folded_faces(mesh: &TriMesh, uv: &VertexMap<DVec2>) -> Vec<FaceId> {
    let is_sound = |f: FaceId| {
        let [a, b, c] = mesh.face_vertices(f).map(|v| uv[v]);
        a.is_finite() && b.is_finite() && c.is_finite() && side(a, b, c) > 0.0
    };
    mesh.faces().filter(|&f| !is_sound(f)).collect()
}

/// Whether the border crosses or touches itself in the plane.
///
/// # Output     true also where two edges meet in a point that is not their common vertex, or where a coordinate is not
/// finite; all boundary loops are compared
/// # Cost       O(n log n) for n border edges, unless many of their boxes overlap
/// # Guarantees exact
pub fn border_overlaps(mesh: &TriMesh, uv: &VertexMap<DVec2>) -> bool {
    let segments: Vec<Segment> = boundary_loops(mesh.connectivity())
        .into_iter()
        .flatten()
        .map(|h| Segment { ends: [mesh.origin(h).0, mesh.target(h).0], at: [uv[mesh.origin(h)], uv[mesh.target(h)]] })
        .collect();
    if segments.iter().any(|s| !s.at.iter().all(|p| p.is_finite())) {
        return true;
    }
    !segments.is_empty() && Boxes::new(&segments).meets_itself(0, segments.len())
}

/// Sign of the turn from ab to c: positive to the left.
fn side(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let coord = |p: DVec2| Coord { x: p.x, y: p.y };
    orient2d(coord(a), coord(b), coord(c))
}

/// An edge of the border.
struct Segment {
    ends: [u32; 2],
    at: [DVec2; 2],
}

impl Segment {
    /// Whether two segments have a point in common other than a vertex of both.
    fn meets(&self, other: &Self) -> bool {
        let ([a, b], [c, d]) = (self.at, other.at);
        let shared = self.ends.iter().position(|v| other.ends.contains(v));
        if let Some(i) = shared {
            let j = usize::from(other.ends[1] == self.ends[i]);
            let (hub, p, q) = (self.at[i], self.at[1 - i], other.at[1 - j]);
            return side(p, hub, q) == 0.0 && (p - hub).dot(q - hub) >= 0.0;
        }
        let (sc, sd, sa, sb) = (side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b));
        if sc == 0.0 && sd == 0.0 {
            return boxes_touch(bounds([a, b]), bounds([c, d]));
        }
        let parts = |s: f64, t: f64| s.signum() * t.signum() > 0.0 && s != 0.0 && t != 0.0;
        !parts(sc, sd) && !parts(sa, sb)
    }
}

type Bounds = [DVec2; 2];

fn bounds([p, q]: [DVec2; 2]) -> Bounds {
    [p.min(q), p.max(q)]
}

fn boxes_touch(a: Bounds, b: Bounds) -> bool {
    a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all()
}

/// Boxes of runs of segments, halved again and again.
struct Boxes<'a> {
    segments: &'a [Segment],
    /// Boxes of runs, by the middle of the run; a run of one segment has its own box.
    of_middle: Vec<Bounds>,
}

impl<'a> Boxes<'a> {
    fn new(segments: &'a [Segment]) -> Self {
        let mut boxes = Self { segments, of_middle: vec![[DVec2::ZERO; 2]; segments.len()] };
        boxes.fill(0, segments.len());
        boxes
    }

    fn fill(&mut self, from: usize, to: usize) -> Bounds {
        if to - from <= 1 {
            return self.bounds(from, to);
        }
        let middle = from.midpoint(to);
        let (left, right) = (self.fill(from, middle), self.fill(middle, to));
        self.of_middle[middle] = [left[0].min(right[0]), left[1].max(right[1])];
        self.of_middle[middle]
    }

    fn bounds(&self, from: usize, to: usize) -> Bounds {
        if to - from == 1 { bounds(self.segments[from].at) } else { self.of_middle[from.midpoint(to)] }
    }

    /// Whether two segments of a run meet.
    fn meets_itself(&self, from: usize, to: usize) -> bool {
        if to - from <= 1 {
            return false;
        }
        let middle = from.midpoint(to);
        self.meets_itself(from, middle) || self.meets_itself(middle, to) || self.meet((from, middle), (middle, to))
    }

    /// Whether a segment of one run meets one of another.
    fn meet(&self, a: (usize, usize), b: (usize, usize)) -> bool {
        if !boxes_touch(self.bounds(a.0, a.1), self.bounds(b.0, b.1)) {
            return false;
        }
        let (long, short) = if a.1 - a.0 >= b.1 - b.0 { (a, b) } else { (b, a) };
        if long.1 - long.0 == 1 {
            return self.segments[long.0].meets(&self.segments[short.0]);
        }
        let middle = long.0.midpoint(long.1);
        self.meet((long.0, middle), short) || self.meet((middle, long.1), short)
    }
}
