//! The integer iso-lines of an integer-grid map, as segments on the surface.
//!
//! In: a triangle mesh and its [`IntegerGridMap`]. Out: [`UvIsolines`], file units.
//! Holds: which triangles a line meets is decided in integers; a line along an edge is drawn once, by the face of
//! the edge's canonical half-edge. Not: that lines close, which needs a map without defects.
//! Source: [Bommes2012] §6 (a quad mesh is the image of the integer iso-lines).

use super::scene::Segment;
use quadloom_mesh::{DVec3, FaceId, HalfEdgeId, TriMesh};
use quadloom_param::{GRID_UNIT, IntegerGridMap};

/// Lines of one kind that one face may carry before it is left out. A face of a map to millions of quads carries
/// one or two; only a broken map reaches thousands, and drawing them would show nothing but their colour.
const MAX_LINES_PER_FACE: i64 = 4096;

/// Integer iso-lines of both coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UvIsolines {
    /// Pieces of the lines with integer u, file units.
    pub u: Vec<Segment>,
    /// Pieces of the lines with integer v, file units.
    pub v: Vec<Segment>,
    /// Faces that were left out because a broken map sends thousands of lines through them, ascending.
    pub skipped_faces: Vec<FaceId>,
}

/// Draws the integer iso-lines of a map onto its mesh.
///
/// # Input      mesh: the work mesh; map: lattice coordinates per corner, as long as the mesh has corners
/// # Output     one segment per line and triangle that it crosses, ascending by face; file units
/// # Cost       linear in faces and segments
/// # Source     [Bommes2012] §6
pub fn isolines(mesh: &TriMesh, map: &IntegerGridMap) -> UvIsolines {
    let mut lines = UvIsolines::default();
    for f in mesh.faces() {
        let u = face_isolines(mesh, map, f, 0, &mut lines.u);
        let v = face_isolines(mesh, map, f, 1, &mut lines.v);
        if u.is_none() || v.is_none() {
            lines.skipped_faces.push(f);
        }
    }
    lines
}

/// The lines of one coordinate in one face; `None` if they are too many.
fn face_isolines(
    mesh: &TriMesh,
    map: &IntegerGridMap,
    f: FaceId,
    coordinate: usize,
    out: &mut Vec<Segment>,
) -> Option<()> {
    let corners = mesh.face_half_edges(f);
    let level = corners.map(|h| map.uv[h][coordinate]);
    let (low, high) = (*level.iter().min()?, *level.iter().max()?);
    let first = low.div_euclid(GRID_UNIT) + i64::from(low.rem_euclid(GRID_UNIT) != 0);
    let last = high.div_euclid(GRID_UNIT);
    if last.checked_sub(first)? >= MAX_LINES_PER_FACE {
        return None;
    }
    for line in first..=last {
        draw_line(mesh, corners, level, line * GRID_UNIT, out);
    }
    Some(())
}

/// The piece of one line inside one face.
fn draw_line(mesh: &TriMesh, corners: [HalfEdgeId; 3], level: [i64; 3], line: i64, out: &mut Vec<Segment>) {
    let point = corners.map(|h| mesh.position(mesh.origin(h)));
    let on = level.map(|x| x == line);
    // 1. Sides on the line belong to one of their two faces.
    for k in (0..3).filter(|&k| on[k] && on[(k + 1) % 3]) {
        if mesh.half_edge(mesh.edge(corners[k])) == corners[k] {
            out.push([point[k], point[(k + 1) % 3]]);
        }
    }
    if on.iter().filter(|&&x| x).count() > 1 {
        return;
    }
    // 2. Otherwise the line enters and leaves through a corner on it or across a side.
    let mut ends = Vec::with_capacity(2);
    for k in 0..3 {
        let next = (k + 1) % 3;
        if on[k] {
            ends.push(point[k]);
        } else if !on[next] && (level[k] < line) != (level[next] < line) {
            ends.push(crossing(point[k], point[next], level[k], level[next], line));
        }
    }
    if let [a, b] = ends[..] {
        out.push([a, b]);
    }
}

/// The point of side `ab` where its level is `line`.
fn crossing(a: DVec3, b: DVec3, level_a: i64, level_b: i64, line: i64) -> DVec3 {
    let part = (i128::from(line) - i128::from(level_a)) as f64;
    let whole = (i128::from(level_b) - i128::from(level_a)) as f64;
    a.lerp(b, part / whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use quadloom_mesh::{CornerMap, HalfEdgeMap};
    use quadloom_param::Transition;
    use quadloom_param::integer_grid_map::rotate;

    /// Units of the test lattice: a grid unit in 16 parts.
    const PART: i64 = GRID_UNIT / 16;

    /// A rectangle of `nx × ny` cells of `dx × dy` sixteenths, its diagonals chosen by `flips`, with its own
    /// coordinates, offset by `shift`, as map; every chart turned by `turns`.
    fn rectangle(n: [i64; 2], d: [i64; 2], shift: [i64; 2], flips: &[bool], turns: &[u8]) -> (TriMesh, IntegerGridMap) {
        let at = |i: i64, j: i64| (j * (n[0] + 1) + i) as u32;
        let lattice = |id: u32| {
            let (i, j) = (i64::from(id) % (n[0] + 1), i64::from(id) / (n[0] + 1));
            [shift[0] + i * d[0], shift[1] + j * d[1]]
        };
        let positions = (0..((n[0] + 1) * (n[1] + 1)) as u32)
            .map(|id| DVec3::new(lattice(id)[0] as f64 / 16.0, lattice(id)[1] as f64 / 16.0, 0.0))
            .collect();
        let mut faces = Vec::new();
        for (cell, (j, i)) in (0..n[1]).flat_map(|j| (0..n[0]).map(move |i| (j, i))).enumerate() {
            let [a, b, c, e] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            faces.extend(if flips[cell % flips.len()] { [[a, b, c], [a, c, e]] } else { [[a, b, e], [b, c, e]] });
        }
        let mesh = TriMesh::new(positions, &faces).unwrap();
        let uv = CornerMap::from_fn(mesh.half_edge_count(), |h| {
            let p = lattice(mesh.origin(h).0);
            rotate([p[0] * PART, p[1] * PART], turns[mesh.face(h).index() % turns.len()])
        });
        let transition = HalfEdgeMap::filled(mesh.half_edge_count(), Transition::IDENTITY);
        (mesh, IntegerGridMap { uv, transition })
    }

    fn total_length(lines: &[Segment]) -> f64 {
        lines.iter().map(|[a, b]| a.distance(*b)).sum()
    }

    /// Integers in `from..=to` sixteenths.
    fn integers_between(from: i64, to: i64) -> f64 {
        (from..=to).filter(|x| x % 16 == 0).count() as f64
    }

    proptest! {
        #[test]
        fn a_rectangle_carries_its_lines_whatever_its_triangles_and_charts(
            n in [1..5i64, 1..5i64],
            d in [1..40i64, 1..40i64],
            shift in [-40..40i64, -40..40i64],
            flips in prop::collection::vec(any::<bool>(), 1..8),
            turns in prop::collection::vec(0..4u8, 1..8),
        ) {
            let (mesh, map) = rectangle(n, d, shift, &flips, &turns);
            let lines = isolines(&mesh, &map);
            let high = [shift[0] + n[0] * d[0], shift[1] + n[1] * d[1]];
            let of_x = integers_between(shift[0], high[0]) * (n[1] * d[1]) as f64 / 16.0;
            let of_y = integers_between(shift[1], high[1]) * (n[0] * d[0]) as f64 / 16.0;
            let (u, v) = (total_length(&lines.u), total_length(&lines.v));
            prop_assert!((u + v - of_x - of_y).abs() < 1e-9 * (1.0 + of_x + of_y), "{u} + {v}, {of_x} + {of_y}");
            if turns.iter().all(|&t| t == 0) {
                prop_assert!((u - of_x).abs() < 1e-9 * (1.0 + of_x));
            }
            prop_assert!(lines.skipped_faces.is_empty());
        }

        #[test]
        fn every_point_of_a_line_has_an_integer_coordinate(
            d in [1..40i64, 1..40i64],
            shift in [-40..40i64, -40..40i64],
        ) {
            let (mesh, map) = rectangle([3, 3], d, shift, &[true, false], &[0]);
            let lines = isolines(&mesh, &map);
            let off = |x: f64| (x - x.round()).abs();
            prop_assert!(lines.u.iter().flatten().all(|p| off(p.x) < 1e-12));
            prop_assert!(lines.v.iter().flatten().all(|p| off(p.y) < 1e-12));
        }
    }

    #[test]
    fn a_broken_map_is_skipped_and_named() {
        let (mesh, mut map) = rectangle([1, 1], [16, 16], [0, 0], &[true], &[0]);
        map.uv[mesh.face_half_edges(FaceId(1))[2]] = [i64::MAX, i64::MIN];
        let lines = isolines(&mesh, &map);
        assert_eq!(lines.skipped_faces, vec![FaceId(1)]);
        assert!(total_length(&lines.u) > 0.0);
    }
}
