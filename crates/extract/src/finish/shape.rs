//! The rectangle nearest to a quad.
//!
//! In: four corners. Out: the corners of the best-fitting rectangle, possibly drawn towards a square.
//! Holds: the centre stays. Source: discrete Fourier transform of a polygon; use as a local step as in
//! [Bouaziz2012] (shape constraints and projections).
//!
//! ```text
//! In the quad's plane corners are complex numbers z_0..z_3 around the centre. They split into
//!   s·i^k    a square,
//!   r·i^-k   a square of the other orientation: its part along -i·s stretches the square to a rectangle,
//!            its part along s shears it,
//!   d·(-1)^k which moves the diagonals apart.
//! A rectangle keeps s and the stretching part of r.
//! ```

use quadloom_mesh::{DVec2, DVec3};

/// Largest stretch relative to the square: 0.6 is a rectangle of sides 4 to 1.
const MAX_STRETCH_REL: f64 = 0.6;

/// Corners of the rectangle nearest to a quad, its stretch multiplied by `stretch_kept`; `None` if the quad has no
/// positive square part, seen along `normal`.
pub(crate) fn nearest_rectangle(corner: [DVec3; 4], normal: DVec3, stretch_kept: f64) -> Option<[DVec3; 4]> {
    let centre = (corner[0] + corner[1] + corner[2] + corner[3]) / 4.0;
    let side = corner[1] + corner[2] - corner[0] - corner[3];
    let x = (side - normal * side.dot(normal)).try_normalize()?;
    let y = normal.cross(x);
    let z = corner.map(|p| DVec2::new((p - centre).dot(x), (p - centre).dot(y)));
    // s = Σ z_k·i^-k / 4, r = Σ z_k·i^k / 4
    let s = (z[0] - z[2] - (z[1] - z[3]).perp()) / 4.0;
    let r = (z[0] - z[2] + (z[1] - z[3]).perp()) / 4.0;
    let size = s.length();
    if size <= 1e-3 * (size + r.length()) {
        return None;
    }
    let stretching = -s.perp() / size;
    let limit = MAX_STRETCH_REL * size;
    let t = stretching * (stretch_kept * stretching.dot(r).clamp(-limit, limit));
    let at = |w: DVec2| centre + x * w.x + y * w.y;
    Some([at(s + t), at(s.perp() - t.perp()), at(-s - t), at(t.perp() - s.perp())])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quality::scaled_jacobian;

    #[test]
    fn rectangles_are_their_own() {
        let (x, y) = (DVec3::new(0.6, 0.0, 0.8), DVec3::Y);
        let rectangle = [DVec3::ZERO, x * 3.0, x * 3.0 + y, y].map(|p| p + DVec3::splat(2.0));
        let normal = x.cross(y);
        let same = nearest_rectangle(rectangle, normal, 1.0).unwrap();
        let square = nearest_rectangle(rectangle, normal, 0.0).unwrap();
        for k in 0..4 {
            assert!(same[k].distance(rectangle[k]) < 1e-12);
            assert!((square[k].distance(square[(k + 1) % 4]) - 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn any_convex_quad_gets_right_angles() {
        let quad = [[0.0, 0.0], [2.0, 0.3], [2.6, 1.9], [-0.4, 1.1]].map(|[a, b]| DVec3::new(a, b, 0.0));
        for kept in [0.0, 0.5, 1.0] {
            let r = nearest_rectangle(quad, DVec3::Z, kept).unwrap();
            assert!((scaled_jacobian(r) - 1.0).abs() < 1e-12);
            let centre = |c: [DVec3; 4]| c.iter().sum::<DVec3>();
            assert!(centre(r).distance(centre(quad)) < 1e-12);
        }
        assert!(nearest_rectangle(quad, -DVec3::Z, 1.0).is_none_or(|r| scaled_jacobian(r) > 0.99));
    }
}
