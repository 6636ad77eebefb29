//! The intrinsic surface on which distances are measured: connectivity and edge lengths.
//!
//! In: connectivity and a length per edge, file units. Out: [`IntrinsicSurface`], or the edge or face that is wrong.
//! Holds: lengths are finite, not negative, and obey the triangle inequality up to rounding; inside they are scaled by
//! a power of two so that the longest is in 1/2..1, which changes no digit and keeps squares in range.
//! No position is read. Source: [Bommes2012] §9, "only the mesh topology and scalar edge lengths are required".

use crate::error::GeodesicError;
use quadloom_mesh::{EdgeId, EdgeMap, FaceId, HalfEdgeId, TriConnectivity, VertexId, VertexMap};
use std::f64::consts::{PI, TAU};

/// By how much a side may exceed the sum of the others, relative to itself. Lengths rounded to seven digits stay below.
const TRIANGLE_REL: f64 = 1e-6;
/// Largest difference from a full turn (radians) of a vertex at which rays that part there still meet behind it,
/// because windows overlap by [`crate::window::OVERLAP_REL`], which is larger.
const FLAT: f64 = 1e-12;

/// Angle by which neighbouring rays may part though nothing is between them, on triangles of good shape (radians).
const PARTED_REL: f64 = 1e-9;
/// The same where triangles are needles, whose angles are known to fewer digits.
const MOST_PARTED_REL: f64 = 1e-8;

/// What a shortest path can do at a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// Paths end here: less than a full turn, or less than half a turn on the boundary.
    Convex,
    /// Paths pass straight: a full turn up to rounding (half of one on the boundary). Only the edge along which a path
    /// goes on needs to be told: rays on both sides of it never cross it.
    Flat,
    /// Paths bend around it: it is a pseudo-source once it is reached.
    Saddle,
}

/// Connectivity and scaled edge lengths, checked.
#[derive(Clone, Debug)]
pub struct IntrinsicSurface<'a> {
    mesh: &'a TriConnectivity,
    /// Lengths times `scale`.
    length: EdgeMap<f64>,
    scale: f64,
    turn: VertexMap<Turn>,
    parted: f64,
}

/// Where the apex of a face lies over one of its sides: origin at the side's origin, x along it, y into the face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Apex {
    /// Length of the side.
    pub base: f64,
    /// Length of the next side, from the side's target to the apex.
    pub right: f64,
    /// Length of the previous side, from the apex to the side's origin.
    pub left: f64,
    pub x: f64,
    pub y: f64,
}

impl<'a> IntrinsicSurface<'a> {
    /// Checks connectivity and edge lengths.
    ///
    /// # Input      one length per edge, file units; zero is allowed
    /// # Errors     the first length that is not finite or is negative; the first face whose side is longer than the
    /// other two together, beyond what rounding to seven digits leaves
    /// # Cost       linear
    pub fn new(mesh: &'a TriConnectivity, length: &EdgeMap<f64>) -> Result<Self, GeodesicError> {
        if length.len() != mesh.edge_count() {
            return Err(GeodesicError::LengthCount { found: length.len(), edges: mesh.edge_count() });
        }
        if let Some((edge, &length)) = length.iter().find(|(_, l)| !l.is_finite() || **l < 0.0) {
            return Err(GeodesicError::Length { edge, length });
        }
        let longest = length.values().iter().copied().fold(0.0, f64::max);
        let scale = if longest > 0.0 { power_of_two_below(1.0 / longest) } else { 1.0 };
        let length = length.map(|l| l * scale);
        for face in mesh.faces() {
            let [a, b, c] = mesh.face_half_edges(face).map(|h| length[mesh.edge(h)]);
            let most = a.max(b).max(c);
            if 2.0 * most > (a + b + c) + TRIANGLE_REL * most {
                return Err(GeodesicError::TriangleInequality { face, lengths: [a, b, c].map(|l| l / scale) });
            }
        }
        let mut doubt = 0.0f64;
        let turn = VertexMap::from_fn(mesh.vertex_count(), |v| {
            let (turn, of_vertex) = turn_of(mesh, &length, v);
            doubt = if of_vertex.is_finite() { doubt.max(of_vertex) } else { doubt };
            turn
        });
        let parted = (PARTED_REL + 10.0 * doubt).min(MOST_PARTED_REL);
        Ok(Self { mesh, length, scale, turn, parted })
    }

    /// The connectivity.
    pub fn connectivity(&self) -> &'a TriConnectivity {
        self.mesh
    }

    /// Length of an edge, file units.
    pub fn edge_length(&self, e: EdgeId) -> f64 {
        self.length[e] / self.scale
    }

    /// By what lengths in file units are multiplied inside: a power of two.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    pub(crate) fn length(&self, e: EdgeId) -> f64 {
        self.length[e]
    }

    pub(crate) fn turn(&self, v: VertexId) -> Turn {
        self.turn[v]
    }

    /// Rays that have parted by less than this, relative to their length, are neighbours still.
    pub(crate) fn parted(&self) -> f64 {
        self.parted
    }

    /// The face of a half-edge laid out over it.
    #[inline]
    pub(crate) fn apex(&self, h: HalfEdgeId) -> Apex {
        let mesh = self.mesh;
        let [base, right, left] = [h, mesh.next(h), mesh.prev(h)].map(|g| self.length[mesh.edge(g)]);
        apex(base, right, left)
    }

    /// The corners of a face: corner 0 at the origin, corner 1 on the x axis, corner 2 above it; scaled.
    pub(crate) fn layout(&self, face: FaceId) -> [[f64; 2]; 3] {
        let apex = self.apex(self.mesh.first_half_edge(face));
        [[0.0, 0.0], [apex.base, 0.0], [apex.x, apex.y]]
    }

    /// Interior angle at the origin of a half-edge in its face, radians, and a bound on its rounding error.
    pub(crate) fn corner_angle(&self, h: HalfEdgeId) -> (f64, f64) {
        corner_angle(self.mesh, &self.length, h)
    }
}

/// The largest power of two that is not above `x`.
fn power_of_two_below(x: f64) -> f64 {
    // The exponent alone; subnormal numbers have none and are far below any length of use.
    f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000).max(f64::MIN_POSITIVE)
}

/// The apex of a triangle over its base, by differences of lengths that lose no digits.
pub(crate) fn apex(base: f64, right: f64, left: f64) -> Apex {
    if base <= 0.0 {
        return Apex { base: 0.0, right, left, x: 0.0, y: left };
    }
    let x = 0.5 * (base + (left - right) * (left + right) / base);
    let y = twice_area(base, right, left) / base;
    Apex { base, right, left, x, y }
}

/// Twice the area of a triangle, correct to a few units in the last place however thin it is; 0 where its longest side
/// exceeds the others by rounding.
///
/// Heron's formula with the sides ordered: where a small number is left, the difference before it is exact. In any other
/// order the sum of two sides is rounded first, which moves the apex by as much as rounding of the lengths does.
/// Source: Kahan, Miscalculating Area and Angles of a Needle-like Triangle, 2014, §2.
fn twice_area(p: f64, q: f64, r: f64) -> f64 {
    let (high, low) = (p.max(q), p.min(q));
    let (a, b, c) = (high.max(r), low.max(high.min(r)), low.min(r));
    let s = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
    0.5 * s.max(0.0).sqrt()
}

/// Interior angle at the origin of `h` in its face and a bound on its rounding error, radians.
fn corner_angle(mesh: &TriConnectivity, length: &EdgeMap<f64>, h: HalfEdgeId) -> (f64, f64) {
    let (apex, error) = corner(mesh, length, h);
    (apex.y.atan2(apex.x), error)
}

/// The face of `h` over it, and a bound on the rounding error of the angle at its origin, radians.
fn corner(mesh: &TriConnectivity, length: &EdgeMap<f64>, h: HalfEdgeId) -> (Apex, f64) {
    let [base, right, left] = [h, mesh.next(h), mesh.prev(h)].map(|g| length[mesh.edge(g)]);
    let apex = apex(base, right, left);
    let twice_area = apex.base * apex.y;
    let squares = base * base + right * right + left * left;
    (apex, 4.0 * f64::EPSILON * squares / twice_area)
}

/// Whether shortest paths bend at a vertex. In doubt they do: a pseudo-source too many costs time and is never wrong.
///
/// # Output     with a bound on the rounding error of the sum of angles, radians
fn turn_of(mesh: &TriConnectivity, length: &EdgeMap<f64>, v: VertexId) -> (Turn, f64) {
    // The product of the corners' directions has the sum of their angles, up to whole turns, which are counted.
    let (mut re, mut im, mut half_turns, mut doubt) = (1.0f64, 0.0f64, 0, 0.0);
    for h in mesh.outgoing(v) {
        let (apex, error) = corner(mesh, length, h);
        let size = apex.left;
        let (x, y) = if size > 0.0 { (apex.x / size, apex.y / size) } else { (1.0, 0.0) };
        let before = im;
        (re, im) = (re * x - im * y, re * y + im * x);
        // A corner's angle is at most half a turn, so that each half turn is seen.
        if (before >= 0.0) != (im >= 0.0) {
            half_turns += 1;
        }
        doubt += error;
    }
    // Upper half plane: 0..π beyond whole turns; lower one: π..2π.
    let angle = im.atan2(re);
    let rest = if angle < 0.0 { angle + PI } else { angle };
    let total = PI * f64::from(half_turns) + rest;
    let excess = total - if mesh.is_boundary_vertex(v) { PI } else { TAU };
    // An area of zero makes the doubt infinite or NaN.
    if doubt.is_nan() || doubt >= FLAT {
        return (if excess < -doubt { Turn::Convex } else { Turn::Saddle }, doubt);
    }
    let turn = match excess {
        x if x > FLAT => Turn::Saddle,
        x if x < -FLAT => Turn::Convex,
        _ => Turn::Flat,
    };
    (turn, doubt)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::shapes::random;

    #[test]
    fn heights_of_needles_lose_no_digits() {
        for seed in 0..4000 {
            // The longest side is shorter than the others together by a share of down to 1e-14.
            let (b, c) = (0.5 + random(seed, 0), random(seed, 1));
            let a = (b + c) * (1.0 - 10f64.powf(-14.0 * random(seed, 2)));
            // All sides are multiples of 2^-64: whole numbers that are added without rounding.
            let [i, j, k] = [a, b, c].map(|side| (side * 2f64.powi(64)) as i128);
            let factors = [i + j + k, i + j - k, i - j + k, j + k - i].map(|x| x as f64 * 2f64.powi(-64));
            if factors.iter().any(|&x| x <= 0.0) {
                continue;
            }
            let exact = 0.5 * factors.iter().product::<f64>().sqrt();
            for [base, right, left] in [[a, b, c], [b, c, a], [c, a, b], [a, c, b], [b, a, c], [c, b, a]] {
                let error = apex(base, right, left).y * base / exact - 1.0;
                assert!(error.abs() <= 8.0 * f64::EPSILON, "{base} {right} {left}: {error:.2e}");
            }
        }
    }
}
