//! Self-intersection against a search in whole numbers that shares nothing with it.
//!
//! In: meshes of small integer coordinates, among them all degenerate positions. Holds: two faces meet just if a system of
//! linear equations has a solution without negative parts, decided by trying all bases in exact arithmetic.

use proptest::prelude::*;
use quadloom_mesh::{DVec3, FaceId, TriMesh, intersects_itself, self_intersections, shapes};
use std::f64::consts::TAU;

type Point = [i128; 3];

/// The faces of each kind of mesh, and how many vertices it has.
fn topologies() -> Vec<(usize, Vec<[u32; 3]>)> {
    let strip = (0..6).map(|k| if k % 2 == 0 { [k, k + 1, k + 2] } else { [k + 1, k, k + 2] }).collect();
    let torus = (0..7).flat_map(|k| [[k, (k + 1) % 7, (k + 3) % 7], [k, (k + 3) % 7, (k + 2) % 7]]).collect();
    vec![
        (6, vec![[0, 1, 2], [3, 4, 5]]),
        (9, vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]]),
        (6, (1..5).map(|k| [0, k, k + 1]).collect()),
        (8, strip),
        (4, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]),
        (7, torus),
    ]
}

/// Corners of the two faces, common ones first: how many are common, the first face, the second.
fn common_first(f: [u32; 3], g: [u32; 3]) -> (usize, [u32; 3], [u32; 3]) {
    let shared: Vec<u32> = f.into_iter().filter(|v| g.contains(v)).collect();
    let order = |t: [u32; 3]| {
        let rest = t.into_iter().filter(|v| !shared.contains(v));
        let all: Vec<u32> = shared.iter().copied().chain(rest).collect();
        [all[0], all[1], all[2]]
    };
    (shared.len(), order(f), order(g))
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn brute_force(points: &[Point], faces: &[[u32; 3]]) -> Vec<[FaceId; 2]> {
    let mut found = Vec::new();
    for f in 0..faces.len() {
        for g in f + 1..faces.len() {
            let (shared, a, b) = common_first(faces[f], faces[g]);
            let place = |t: [u32; 3]| t.map(|v| points[v as usize]);
            let (a, b) = (place(a), place(b));
            let meet = match shared {
                0 => hulls_meet(a, b),
                1 => cones_meet([minus(a[1], a[0]), minus(a[2], a[0])], [minus(b[1], a[0]), minus(b[2], a[0])]),
                2 => folded([a[0], a[1]], a[2], b[2]),
                _ => true,
            };
            if meet {
                found.push([FaceId::new(f), FaceId::new(g)]);
            }
        }
    }
    found
}

/// Σ sᵢaᵢ = Σ tⱼbⱼ, Σ s = Σ t = 1.
fn hulls_meet(a: [Point; 3], b: [Point; 3]) -> bool {
    let columns: Vec<Vec<i128>> = a
        .iter()
        .map(|p| vec![p[0], p[1], p[2], 1, 0])
        .chain(b.iter().map(|p| vec![-p[0], -p[1], -p[2], 0, 1]))
        .collect();
    has_solution(&columns, &[0, 0, 0, 1, 1])
}

/// Whether the cones of two corners at the origin share more than the origin: some coordinate of a common point is ±1.
fn cones_meet(a: [Point; 2], b: [Point; 2]) -> bool {
    (0..3).any(|k| {
        [1, -1].into_iter().any(|side| {
            let columns: Vec<Vec<i128>> = a
                .iter()
                .map(|p| vec![p[0], p[1], p[2], p[k]])
                .chain(b.iter().map(|p| vec![-p[0], -p[1], -p[2], 0]))
                .collect();
            has_solution(&columns, &[0, 0, 0, side])
        })
    })
}

/// Whether the triangles pqc and pqd share a point that is not on pq.
fn folded([p, q]: [Point; 2], c: Point, d: Point) -> bool {
    let cross = |a: Point, b: Point| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let dot = |a: Point, b: Point| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let is_zero = |a: Point| a == [0; 3];
    let same_way = |a: Point, b: Point| is_zero(cross(a, b)) && dot(a, b) > 0;
    let along = minus(q, p);
    if is_zero(along) {
        return same_way(minus(c, p), minus(d, p));
    }
    let [nc, nd] = [c, d].map(|x| cross(along, minus(x, p)));
    match (is_zero(nc), is_zero(nd)) {
        (false, false) => same_way(nc, nd),
        (true, true) => [(p, q), (q, p)]
            .into_iter()
            .any(|(from, to)| [c, d].into_iter().all(|x| dot(minus(x, to), minus(to, from)) > 0)),
        // One lies on the line, of which the other has the common side and no more.
        _ => false,
    }
}

/// Whether some z ≥ 0 has Σ z_k column_k = right: then one with independent columns does.
fn has_solution(columns: &[Vec<i128>], right: &[i128]) -> bool {
    (0..1u32 << columns.len()).any(|subset| {
        let chosen: Vec<&Vec<i128>> =
            (0..columns.len()).filter(|k| subset >> k & 1 == 1).map(|k| &columns[k]).collect();
        solve(&chosen, right)
    })
}

/// Whether independent columns have a solution, and one without negative parts.
fn solve(columns: &[&Vec<i128>], right: &[i128]) -> bool {
    let mut rows: Vec<Vec<i128>> =
        (0..right.len()).map(|i| columns.iter().map(|c| c[i]).chain([right[i]]).collect()).collect();
    for k in 0..columns.len() {
        let Some(at) = (k..rows.len()).find(|&i| rows[i][k] != 0) else { return false };
        rows.swap(k, at);
        let pivot = rows[k].clone();
        for (i, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row[k];
            row.iter_mut().zip(&pivot).for_each(|(x, y)| *x = *x * pivot[k] - y * factor);
            let divisor = row.iter().fold(0, |a, &b| greatest_divisor(a, b.abs())).max(1);
            row.iter_mut().for_each(|x| *x /= divisor);
            debug_assert!(i < right.len());
        }
    }
    let n = columns.len();
    (0..n).all(|k| rows[k][k].signum() * rows[k][n].signum() >= 0)
        && rows[n.min(rows.len())..].iter().all(|r| r[n] == 0)
}

fn greatest_divisor(a: i128, b: i128) -> i128 {
    if b == 0 { a } else { greatest_divisor(b, a % b) }
}

fn mesh_of(points: &[Point], faces: &[[u32; 3]], scale: f64) -> TriMesh {
    let place = |p: &Point| DVec3::from_array(p.map(|x| x as f64)) * scale;
    TriMesh::new(points.iter().map(place).collect(), faces).unwrap()
}

fn case() -> impl Strategy<Value = (Vec<Point>, Vec<[u32; 3]>)> {
    // The size of the box in each direction: flat boxes give overlaps in a plane, thin ones segments.
    (
        0..topologies().len(),
        [0..5i128, 0..5i128, 0..4i128],
        proptest::collection::vec([0..60i128, 0..60i128, 0..60i128], 9),
    )
        .prop_map(|(kind, size, points)| {
            let (vertices, faces) = topologies().swap_remove(kind);
            let into_box = |p: &Point| [0, 1, 2].map(|k| p[k] % (size[k] + 1));
            (points.iter().take(vertices).map(into_box).collect(), faces)
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn faces_meet_where_whole_numbers_say_so((points, faces) in case()) {
        let wanted = brute_force(&points, &faces);
        let found = self_intersections(&mesh_of(&points, &faces, 1.0), usize::MAX);
        prop_assert_eq!(&found, &wanted, "{:?} {:?}", points, faces);
    }

    #[test]
    fn skew_and_scale_change_nothing((points, faces) in case(), shear in [-9999..9999i128, -9999..9999i128, -9999..9999i128]) {
        // An affine map of determinant 1, so what meets still does; in doubles its images are exact, its products are not.
        let skew = |p: &Point| {
            let y = p[1] + shear[0] * p[0];
            [p[0] + shear[2] * (p[2] + shear[1] * y), y, p[2] + shear[1] * y]
        };
        let skewed: Vec<Point> = points.iter().map(skew).collect();
        let scale = (-70f64).exp2();
        let found = self_intersections(&mesh_of(&skewed, &faces, scale), usize::MAX);
        prop_assert_eq!(found, self_intersections(&mesh_of(&points, &faces, 1.0), usize::MAX));
    }
}

#[test]
fn the_first_pairs_are_those_of_the_whole_list() {
    let mesh = shapes::join(&[shapes::torus(2.0, 0.5, 40, 16), shapes::torus(2.2, 0.5, 40, 16)]);
    let all = self_intersections(&mesh, usize::MAX);
    assert!(all.is_sorted() && all.len() > 100, "{}", all.len());
    for limit in [0, 1, 7, all.len(), all.len() + 1] {
        assert_eq!(self_intersections(&mesh, limit), all[..limit.min(all.len())]);
    }
}

/// Two faces that share a vertex and otherwise cross, touch, or keep apart.
#[test]
fn faces_at_a_common_vertex() {
    let fan = |far: [[i128; 3]; 2], expected: bool| {
        // Faces 0 and 2 have only vertex 0 in common; face 1 is between them.
        let points = [[0, 0, 0], [4, 0, 0], [0, 4, 0], far[0], far[1]];
        let mesh = mesh_of(&points, &[[0, 1, 2], [0, 2, 3], [0, 3, 4]], 1.0);
        let found = self_intersections(&mesh, usize::MAX).contains(&[FaceId::new(0), FaceId::new(2)]);
        assert_eq!(found, expected, "{far:?}");
    };
    fan([[3, 3, 2], [3, 3, -2]], true);
    fan([[1, 1, 2], [1, 1, -2]], true);
    fan([[-3, 3, 2], [-3, 3, -2]], false);
    fan([[-3, 1, 2], [1, -1, -2]], false);
    fan([[-1, 1, 2], [3, -1, -2]], true);
    // In one plane: beside each other, overlapping, along the same line.
    fan([[-4, 0, 0], [0, -4, 0]], false);
    fan([[1, 1, 0], [5, -1, 0]], true);
    fan([[9, 0, 0], [9, -9, 0]], true);
    // A segment with the common vertex inside, or at its end, beside the other face or in it.
    fan([[-3, 0, 1], [3, 0, -1]], false);
    fan([[-3, -3, 0], [3, 3, 0]], true);
    fan([[-3, -3, 0], [-1, -1, 0]], false);
    fan([[0, 0, 0], [0, 0, 5]], false);
    fan([[0, 0, 0], [1, 1, 0]], true);
}

/// Two faces that share an edge and fold flat onto each other, or do not.
#[test]
fn faces_on_a_common_edge() {
    let hinge = |far: [i128; 3]| {
        let mesh = mesh_of(&[[0, 0, 0], [6, 0, 0], [2, 4, 0], far], &[[0, 1, 2], [1, 0, 3]], 1.0);
        intersects_itself(&mesh)
    };
    assert!(hinge([2, 4, 0]), "folded flat onto the same face");
    assert!(hinge([-9, 1, 0]), "folded flat, leaning outwards");
    assert!(!hinge([2, -4, 0]), "flat, side by side");
    assert!(!hinge([2, 4, 1]), "nearly closed");
    assert!(!hinge([3, 0, 0]) && !hinge([9, 0, 0]), "a face without area on the line of the edge");
}

/// A closed band of quads bent by `place`, as triangles.
fn wound(around: u32, across: u32, place: impl Fn(f64, f64) -> [f64; 3]) -> TriMesh {
    let at = |i: u32, j: u32| (i % around) * across + j % across;
    let angle = |k: u32, n: u32| f64::from(k) / f64::from(n) * TAU;
    let grid = || (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let points = grid().map(|(i, j)| place(angle(i, around), angle(j, across)).into()).collect();
    let faces: Vec<[u32; 3]> = grid()
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    TriMesh::new(points, &faces).unwrap()
}

#[test]
fn a_torus_immersed_along_a_figure_of_eight_meets_itself() {
    // The axis is flat and crosses itself; lifted, the same tube is embedded.
    let eight = |lift: f64| {
        wound(120, 12, move |t, s| {
            let centre = [3.0 * t.sin(), 3.0 * (2.0 * t).sin() / 2.0, lift * t.cos()];
            let along = DVec3::new(3.0 * t.cos(), 3.0 * (2.0 * t).cos(), -lift * t.sin()).normalize();
            let side = along.cross(DVec3::Z).normalize();
            (DVec3::from(centre) + 0.3 * (s.cos() * side + s.sin() * side.cross(along))).into()
        })
    };
    assert!(intersects_itself(&eight(0.0)));
    assert!(intersects_itself(&eight(0.25)));
    assert!(!intersects_itself(&eight(0.5)));
}

#[test]
fn a_tube_pushed_through_another_meets_it() {
    let ring =
        || wound(60, 16, |t, s| [(2.0 + 0.5 * s.cos()) * t.cos(), (2.0 + 0.5 * s.cos()) * t.sin(), 0.5 * s.sin()]);
    let other = |x: f64| {
        wound(60, 16, move |t, s| [x + (2.0 + 0.5 * s.cos()) * t.cos(), 0.5 * s.sin(), (2.0 + 0.5 * s.cos()) * t.sin()])
    };
    for (x, expected) in [(2.0, false), (1.1, false), (0.8, true), (3.5, true), (6.0, false)] {
        // At 1.1 the second ring still clears the first inside; linked rings do not meet.
        assert_eq!(intersects_itself(&shapes::join(&[ring(), other(x)])), expected, "moved by {x}");
    }
}

#[test]
fn fine_closed_solids_have_none() {
    for mesh in
        [shapes::sphere(1.0, 5), shapes::torus(2.0, 0.7, 160, 64), shapes::cube(1.0, 24), shapes::smooth_genus(2, 4)]
    {
        assert!(!intersects_itself(&mesh));
    }
}
