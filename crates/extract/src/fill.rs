//! Cutting a small polygon of the surface into quads without new vertices.
//!
//! In: the corners of a polygon of an even number of sides. Out: quads as corner numbers.
//! Holds: n sides give n/2 - 1 quads; among all such cuts one of least shape cost is taken.
//! Source: the classical interval recursion for optimal polygon partitions, quads in place of triangles.

use quadloom_mesh::DVec3;

/// Largest number of sides that is cut; the cost of the recursion grows with its fourth power.
pub(crate) const MAX_SIDES: usize = 24;

/// Cuts a polygon into quads along diagonals that `allowed` permits; `None` where there is no such cut, for an odd
/// number of sides, fewer than four, or more than [`MAX_SIDES`].
///
/// # Cost       O(n⁴)
pub(crate) fn quadrangulate(corner: &[DVec3], allowed: impl Fn(usize, usize) -> bool) -> Option<Vec<[usize; 4]>> {
    let n = corner.len();
    if !n.is_multiple_of(2) || !(4..=MAX_SIDES).contains(&n) {
        return None;
    }
    // best[i][j]: cost and apex pair of the quad on the diagonal (i, j) of the sub-polygon i..=j.
    let mut best = vec![vec![(0.0, (0, 0)); n]; n];
    for span in (3..n).step_by(2) {
        for i in 0..n - span {
            let j = i + span;
            let mut choice = (f64::INFINITY, (i + 1, i + 2));
            if span < n - 1 && !allowed(i, j) {
                best[i][j] = choice;
                continue;
            }
            for a in (i + 1..j).step_by(2) {
                for b in (a + 1..j).step_by(2) {
                    let below = best[i][a].0 + best[a][b].0 + best[b][j].0;
                    let cost = below + shape_cost([corner[i], corner[a], corner[b], corner[j]]);
                    if cost < choice.0 {
                        choice = (cost, (a, b));
                    }
                }
            }
            best[i][j] = choice;
        }
    }
    if best[0][n - 1].0.is_infinite() {
        return None;
    }
    let (mut quads, mut open) = (Vec::new(), vec![(0, n - 1)]);
    while let Some((i, j)) = open.pop() {
        if j - i > 1 {
            let (a, b) = best[i][j].1;
            quads.push([i, a, b, j]);
            open.extend([(i, a), (a, b), (b, j)]);
        }
    }
    Some(quads)
}

/// Cost of a corner that is straight or reflex, in the unit of squared deviations: more than any number of poor ones.
const STRAIGHT_COST: f64 = 100.0;

/// Angle from which a corner counts as straight: two sides on one straight crease must not meet in a quad.
const STRAIGHT: f64 = 0.94 * std::f64::consts::PI;

/// Sum of squared deviations of the corner angles from right angles; straight and reflex corners cost extra.
fn shape_cost(p: [DVec3; 4]) -> f64 {
    let normal = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
    let corner = |k: usize| {
        let (a, b) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
        let angle = a.cross(b).dot(normal).atan2(a.dot(b));
        let angle = if angle < 0.0 { angle + std::f64::consts::TAU } else { angle };
        (angle - std::f64::consts::FRAC_PI_2).powi(2) + if angle > STRAIGHT { STRAIGHT_COST } else { 0.0 }
    };
    (0..4).map(corner).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_squares_are_found_in_their_outline() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let outline = [at(1.0, 0.0), at(2.0, 0.0), at(2.0, 1.0), at(1.0, 1.0), at(0.0, 1.0), at(0.0, 0.0)];
        let mut quads = quadrangulate(&outline, |_, _| true).unwrap();
        quads.iter_mut().for_each(|q| q.sort_unstable());
        quads.sort_unstable();
        assert_eq!(quads, [[0, 1, 2, 3], [0, 3, 4, 5]]);
        // Another cut where this diagonal is taken; none where all are.
        let other = quadrangulate(&outline, |i, j| (i, j) != (0, 3)).unwrap();
        assert!(other.iter().all(|q| !(q.contains(&0) && q.contains(&3) && q.contains(&1) && q.contains(&2))));
        assert_eq!(quadrangulate(&outline, |_, _| false), None);
    }

    #[test]
    fn every_even_polygon_is_cut() {
        for n in (4..=MAX_SIDES).step_by(2) {
            let circle: Vec<DVec3> = (0..n)
                .map(|k| std::f64::consts::TAU * k as f64 / n as f64)
                .map(|t| DVec3::new(t.cos(), t.sin(), 0.0))
                .collect();
            let quads = quadrangulate(&circle, |_, _| true).unwrap();
            assert_eq!(quads.len(), n / 2 - 1);
            // The oriented sides add up to the outline: every inner side appears once in each direction.
            let mut sides: Vec<(usize, usize)> =
                quads.iter().flat_map(|q| (0..4).map(|k| (q[k], q[(k + 1) % 4]))).collect();
            sides.retain({
                let all = sides.clone();
                move |&(a, b)| !all.contains(&(b, a))
            });
            sides.sort_unstable();
            let mut outline: Vec<(usize, usize)> = (0..n).map(|k| (k, (k + 1) % n)).collect();
            outline.sort_unstable();
            assert_eq!(sides, outline);
        }
        assert_eq!(quadrangulate(&[DVec3::ZERO; 5], |_, _| true), None);
        assert_eq!(quadrangulate(&[DVec3::ZERO; 2], |_, _| true), None);
    }
}
