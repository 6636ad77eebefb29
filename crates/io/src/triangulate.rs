//! Polygons as fans of triangles, for formats that have nothing else.
//!
//! In: faces and positions. Out: triangles, face after face; those of one face share their first vertex.
//! Holds: two consecutive faces never share that first vertex if it can be avoided, which is what the glTF extension
//! FB_ngon_encoding asks for, so that a reader can put the polygons together again.
//! Source: <https://github.com/KhronosGroup/glTF/pull/1620>, draft text of the extension.

use quadloom_mesh::DVec3;

/// Polygons with more corners are cut from their first free corner instead of the best one: the search is quadratic.
const LARGEST_SEARCHED: usize = 32;

/// Splits faces into triangles in the order of FB_ngon_encoding.
pub(crate) fn fans(faces: &[Vec<u32>], positions: &[DVec3]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(faces.len() * 2);
    let mut last = None;
    for face in faces {
        let start = fan_start(face, positions, last);
        let n = face.len();
        let at = |k: usize| face[(start + k) % n];
        triangles.extend((1..n.saturating_sub(1)).map(|k| [at(0), at(k), at(k + 1)]));
        last = face.get(start).copied();
    }
    triangles
}

/// The corner, other than vertex `avoid`, whose fan has the largest smallest triangle.
fn fan_start(face: &[u32], positions: &[DVec3], avoid: Option<u32>) -> usize {
    let mut allowed = (0..face.len()).filter(|&k| Some(face[k]) != avoid);
    let first = allowed.next().unwrap_or(0);
    if face.len() == 3 || face.len() > LARGEST_SEARCHED {
        return first;
    }
    let corner = |k: usize| positions[face[k % face.len()] as usize];
    let triangle = |a: usize, b: usize, c: usize| (corner(b) - corner(a)).cross(corner(c) - corner(a));
    let normal = (1..face.len() - 1).map(|k| triangle(0, k, k + 1)).sum::<DVec3>().normalize_or_zero();
    let smallest = |start: usize| {
        let areas = (1..face.len() - 1).map(|k| triangle(start, start + k, start + k + 1).dot(normal));
        areas.fold(f64::INFINITY, f64::min)
    };
    let better = |best: (usize, f64), k: usize| {
        let score = smallest(k);
        if score > best.1 { (k, score) } else { best }
    };
    allowed.fold((first, smallest(first)), better).0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Puts polygons together as a reader of FB_ngon_encoding does.
    pub(crate) fn joined(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
        let mut polygons: Vec<Vec<u32>> = Vec::new();
        for t in triangles {
            match polygons.last_mut() {
                Some(p) if p[0] == t[0] => p.push(t[2]),
                _ => polygons.push(t.to_vec()),
            }
        }
        polygons
    }

    fn same_cycle(a: &[u32], b: &[u32]) -> bool {
        a.len() == b.len() && (0..a.len()).any(|s| (0..a.len()).all(|k| a[(s + k) % a.len()] == b[k]))
    }

    #[test]
    fn a_quad_with_a_dent_is_cut_at_the_dent() {
        let positions = [DVec3::ZERO, DVec3::new(0.2, 0.2, 0.0), DVec3::X, DVec3::new(1.0, 1.0, 0.0)];
        let triangles = fans(&[vec![0, 1, 2, 3]], &positions);
        assert_eq!(triangles, [[1, 2, 3], [1, 3, 0]]);
    }

    proptest::proptest! {
        #[test]
        fn polygons_can_be_put_together_again(faces in proptest::collection::vec(
            proptest::sample::subsequence((0u32..9).collect::<Vec<_>>(), 3..=9), 1..40,
        )) {
            let positions: Vec<_> = (0..9).map(|k| DVec3::new((k * k % 7) as f64, (k * 5 % 9) as f64, k as f64)).collect();
            let back = joined(&fans(&faces, &positions));
            proptest::prop_assert_eq!(back.len(), faces.len());
            for (a, b) in back.iter().zip(&faces) {
                proptest::prop_assert!(same_cycle(a, b), "{:?} {:?}", a, b);
            }
        }
    }
}
