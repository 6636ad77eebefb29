//! The picture that all quarter-tubes share: the source's tiling, clipped against the fundamental quadrilateral.
//!
//! In: the source map, its plane, the quadrilateral. Out: [`LocalPicture`]: triangles in (u, v), each within one flag and
//! one strip along the edges of the map, and the vertices on each side of the quadrilateral in order.
//! Holds: triangles meet along whole sides and are counter-clockwise; they cover the quadrilateral; the sides a, c and the
//! pair b, d carry vertices at the same places under the isometries that glue them.
//! Source: [Razafindrazaka2015] §9.5.

use super::strips::Strips;
use glam::{DMat3, DVec2, DVec3};
use quadloom_regular_maps::MapError;
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::{Reflection, RegularMap};
use quadloom_regular_maps::plane::Plane;
use std::collections::BTreeMap;

/// A vertex of the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalPoint {
    /// Its place in the plane, the quadrilateral's centre at the origin.
    pub place: DVec3,
    /// Its place in the quarter-tube.
    pub uv: DVec2,
    /// Height of the relief, 0..=1.
    pub height: f64,
}

/// A triangle of the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalTriangle {
    pub corners: [u32; 3],
    /// The source's flag, where the quarter-tube is the base one.
    pub flag: FlagId,
    pub strip: u8,
}

/// The picture on one quarter-tube.
#[derive(Clone, Debug)]
pub(super) struct LocalPicture {
    pub quad: Quad,
    pub points: Vec<LocalPoint>,
    pub outlines: Vec<Outline>,
    pub triangles: Vec<LocalTriangle>,
}

/// A piece of a strip by its border, counter-clockwise.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub corners: Vec<u32>,
    pub flag: FlagId,
    pub strip: u8,
}

/// Sides of the quadrilateral: a at u = 0, b at v = 1, c at u = 1, d at v = 0.
pub(super) const SIDES: [char; 4] = ['a', 'b', 'c', 'd'];

/// Places closer than this are one, in the disk where straight lines are straight and which has radius 1.
const SNAP: f64 = 1e-8;
/// Sides of pieces are cut until none is longer than this part of a quarter-tube.
const LONGEST: usize = 8;
/// A point this close to a line is on it.
const ON_LINE: f64 = 1e-10;

/// The quadrilateral P1 M1 M2 P2 with its centre at the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quad {
    corners: [DVec3; 4],
}

impl Quad {
    /// Moves the quadrilateral's centre to the origin; also the flag there and the isometry that takes the base flag to it.
    ///
    /// Far from the origin numbers lose their digits, so the flag at the centre is placed anew, and the quadrilateral's
    /// corners, each of which is a corner of the tiling, are taken from the flags around it.
    fn centred(source: &RegularMap, plane: &Plane, corners: &[DVec3; 4]) -> (Self, DMat3, FlagId) {
        let (word, centre) = reduce(plane, plane.normalised(corners.iter().sum()));
        // The quadrilateral stays counter-clockwise.
        let mirror = DMat3::from_diagonal(DVec3::new(1.0, if word.len() % 2 == 0 { 1.0 } else { -1.0 }, 1.0));
        let frame = mirror * plane.to_origin(centre);
        let near = |corner: DVec3| {
            let moved = word.iter().fold(corner, |z, &by| plane.reflection(by) * z);
            let (steps, inside) = reduce(plane, plane.normalised(moved));
            let distance = |c: &DVec3| plane.distance(*c, inside);
            let nearest = plane.corners.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            plane.normalised(frame * plane.isometry(&steps) * nearest.unwrap_or(inside))
        };
        (Self { corners: corners.map(near) }, frame, source.walk(FlagId(0), &word))
    }

    /// (u, v) of a place: z is a multiple of (1−u)(1−v) P1 + u(1−v) M1 + uv M2 + (1−u)v P2.
    ///
    /// On the line through A = (1−u)P1 + uM1 and B = (1−u)P2 + uM2 the determinant |z A B| is zero: a quadratic for u.
    pub fn uv(&self, z: DVec3) -> DVec2 {
        let [p1, m1, m2, p2] = self.corners;
        let near = |side: usize| self.distance(side, flat(z)).abs() < SNAP;
        // On a side the other parameter follows from the side alone, where the quadratic may have a double root.
        let on_side = |fixed: [usize; 2], ends: [[DVec3; 2]; 2]| {
            let side = (0..2).find(|&k| near(fixed[k]))?;
            Some((side as f64, share(z, ends[side])))
        };
        let [a, b, c, d] = [0, 1, 2, 3];
        match (on_side([a, c], [[p1, p2], [m1, m2]]), on_side([d, b], [[p1, m1], [p2, m2]])) {
            (Some((u, _)), Some((v, _))) => DVec2::new(u, v),
            (Some((u, v)), None) => DVec2::new(u, v),
            (None, Some((v, u))) => DVec2::new(u, v),
            (None, None) => DVec2::new(bilinear_root(z, [p1, m1], [p2, m2]), bilinear_root(z, [p1, p2], [m1, m2])),
        }
    }

    /// Signed distance from a side, positive inside.
    fn distance(&self, side: usize, z: DVec2) -> f64 {
        let [from, to] = self.side(side);
        (to - from).normalize().perp_dot(z - from)
    }

    /// A side's ends, counter-clockwise.
    fn side(&self, side: usize) -> [DVec2; 2] {
        let [p1, m1, m2, p2] = self.corners.map(flat);
        match SIDES[side] {
            'a' => [p2, p1],
            'b' => [m2, p2],
            'c' => [m1, m2],
            _ => [p1, m1],
        }
    }
}

fn flat(z: DVec3) -> DVec2 {
    z.truncate() / z.z
}

/// The t for which a point of a line is a multiple of (1−t)A + tB.
fn share(z: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let [from, to] = [a.cross(z).length(), z.cross(b).length()];
    from / (from + to)
}

/// The t in 0..=1 with |z A B| = 0, A = lerp of `first`, B = lerp of `second`.
fn bilinear_root(z: DVec3, first: [DVec3; 2], second: [DVec3; 2]) -> f64 {
    let det = |a: DVec3, b: DVec3| z.dot(a.cross(b));
    let (d00, d11) = (det(first[0], second[0]), det(first[1], second[1]));
    let mixed = det(first[0], second[1]) + det(first[1], second[0]);
    // d00 (1−t)² + mixed t(1−t) + d11 t² = 0.
    let (a, b, c) = (d00 - mixed + d11, mixed - 2.0 * d00, d00);
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    let q = -0.5 * (b + if b < 0.0 { -root } else { root });
    let candidates = [q / a, c / q];
    let outside = |t: f64| if t.is_finite() { (t - 0.5).abs() } else { f64::INFINITY };
    if outside(candidates[0]) < outside(candidates[1]) { candidates[0] } else { candidates[1] }
}

/// A convex piece of one flag's strip.
struct Piece {
    polygon: Vec<DVec2>,
    flag: FlagId,
    strip: u8,
    to_flag: DMat3,
}

impl LocalPicture {
    /// Clips the tiling against the quadrilateral and cuts it into triangles, each in one half of one of n × m cells.
    ///
    /// # Errors     [`MapError::NotRegular`] where pieces do not fit together, which would be a wrong match
    /// # Cost       (flags that meet the quadrilateral) × (pieces of each), and the triangles that come out
    pub fn new(
        source: &RegularMap,
        plane: &Plane,
        quad: &[DVec3; 4],
        strips: &Strips,
        steps: [usize; 2],
    ) -> Result<Self, MapError> {
        // Lines of the tiling are curved in (u, v). Pieces whose sides are too long to follow them are cut smaller.
        let attempt = |factor: usize| {
            let mut picture = Self::outlined(source, plane, quad, strips);
            picture.halve_sides(plane, steps.map(|n| factor * n.min(LONGEST)));
            picture.cut_into_cells(steps);
            picture.check_area().map(|()| picture)
        };
        [1, 2, 4, 8].into_iter().map(attempt).find(Result::is_ok).unwrap_or_else(|| attempt(16))
    }

    fn outlined(source: &RegularMap, plane: &Plane, quad: &[DVec3; 4], strips: &Strips) -> Self {
        let (quad, frame, flag) = Quad::centred(source, plane, quad);
        let mut pieces = Vec::new();
        for (isometry, flag) in flags_in(source, plane, &quad, (frame, flag)) {
            for (strip, polygon) in strips.polygons(plane).into_iter().enumerate() {
                let mut corners: Vec<DVec2> = polygon.iter().map(|&c| flat(isometry * c)).collect();
                if signed_area(&corners) < 0.0 {
                    corners.reverse();
                }
                let polygon = clip(&quad, corners);
                if polygon.len() > 2 && signed_area(&polygon) > ON_LINE * ON_LINE {
                    pieces.push(Piece { polygon, flag, strip: strip as u8, to_flag: isometry.inverse() });
                }
            }
        }
        assemble(quad, plane, pieces, strips)
    }

    /// The triangles' areas in (u, v) must be positive and add up to that of the quarter-tube.
    fn check_area(&self) -> Result<(), MapError> {
        let area = |t: &LocalTriangle| signed_area(&t.corners.map(|i| self.points[i as usize].uv));
        let sum: f64 = self.triangles.iter().map(area).sum();
        let least = self.triangles.iter().map(area).fold(1.0, f64::min);
        if (sum - 1.0).abs() > 1e-9 || least.is_nan() || least <= 0.0 {
            let what = format!("the picture covers {sum} of a quarter-tube, its smallest triangle {least:e}");
            return Err(MapError::NotRegular(what));
        }
        Ok(())
    }

    /// The vertices on each side (a, b, c, d), those on a and c by v, those on b and d by u.
    pub fn sides(&self) -> [Vec<u32>; 4] {
        let on = |fixed: usize, value: f64| {
            let free = 1 - fixed;
            let is_on = |&i: &u32| self.points[i as usize].uv[fixed] == value;
            let mut list: Vec<u32> = (0..self.points.len() as u32).filter(is_on).collect();
            list.sort_by(|&i, &j| self.points[i as usize].uv[free].total_cmp(&self.points[j as usize].uv[free]));
            list
        };
        [on(0, 0.0), on(1, 1.0), on(0, 1.0), on(1, 0.0)]
    }
}

/// The flags whose triangles meet the inside of the quadrilateral, found from the one at its centre across sides: an open
/// convex set stays connected when the corners of the tiling are taken out of it.
fn flags_in(source: &RegularMap, plane: &Plane, quad: &Quad, start: (DMat3, FlagId)) -> Vec<(DMat3, FlagId)> {
    let centre = plane.corners.iter().sum::<DVec3>();
    let mut seen = Welder::default();
    seen.vertex(flat(start.0 * centre));
    let mut found = vec![start];
    let mut at = 0;
    while at < found.len() {
        let (isometry, flag) = found[at];
        at += 1;
        for by in Reflection::ALL {
            let next = isometry * plane.reflection(by);
            let mut corners: Vec<DVec2> = plane.corners.iter().map(|&c| flat(next * c)).collect();
            if signed_area(&corners) < 0.0 {
                corners.reverse();
            }
            let clipped = clip(quad, corners);
            let inside = clipped.len() > 2 && signed_area(&clipped) > ON_LINE * ON_LINE;
            let known = seen.places.len();
            if inside && seen.vertex(flat(next * centre)) as usize == known {
                found.push((next, source.reflect(flag, by)));
            }
        }
    }
    found
}

/// Reflects a point into the base triangle: the word of the flag that holds it, and where it comes to lie.
fn reduce(plane: &Plane, mut point: DVec3) -> (Vec<Reflection>, DVec3) {
    let inside = plane.corners.iter().sum::<DVec3>();
    let mut word = Vec::new();
    // Each reflection brings the point nearer to the base triangle's inside.
    while word.len() < 10_000 {
        let wrong = Reflection::ALL.into_iter().find(|&by| {
            let [a, b] = [1, 2].map(|k| plane.corners[(by as usize + k) % 3]);
            let normal = a.cross(b);
            normal.dot(point) * normal.dot(inside) < -1e-9 * point.z
        });
        let Some(by) = wrong else { break };
        point = plane.normalised(plane.reflection(by) * point);
        word.push(by);
    }
    (word, point)
}

/// Clips a convex polygon against the quadrilateral; what is within [`ON_LINE`] of a side counts as on it.
fn clip(quad: &Quad, mut polygon: Vec<DVec2>) -> Vec<DVec2> {
    for side in 0..4 {
        let distance: Vec<f64> = polygon.iter().map(|&z| snapped(quad.distance(side, z))).collect();
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, (&z, &d)) in polygon.iter().zip(&distance).enumerate() {
            let j = (i + 1) % polygon.len();
            if d >= 0.0 {
                kept.push(z);
            }
            if d * distance[j] < 0.0 {
                kept.push(z.lerp(polygon[j], d / (d - distance[j])));
            }
        }
        polygon = kept;
        if polygon.len() < 3 {
            return Vec::new();
        }
    }
    polygon
}

fn snapped(distance: f64) -> f64 {
    if distance.abs() < ON_LINE { 0.0 } else { distance }
}

pub(super) fn signed_area(polygon: &[DVec2]) -> f64 {
    let n = polygon.len();
    0.5 * (0..n).map(|i| (polygon[i] - polygon[0]).perp_dot(polygon[(i + 1) % n] - polygon[0])).sum::<f64>()
}

/// Makes equal places one and puts vertices that lie on another piece's side into it.
fn assemble(quad: Quad, plane: &Plane, pieces: Vec<Piece>, strips: &Strips) -> LocalPicture {
    let mut welder = Welder::default();
    let outlines: Vec<Vec<u32>> = pieces.iter().map(|piece| welder.outline(&piece.polygon)).collect();
    let mut height = vec![None; welder.places.len()];
    for (piece, outline) in pieces.iter().zip(&outlines) {
        for &i in outline {
            height[i as usize].get_or_insert_with(|| piece.height(plane, welder.places[i as usize], strips));
        }
    }
    let point = |(&z, height): (&DVec2, &Option<f64>)| {
        let place = plane.normalised(z.extend(1.0));
        LocalPoint { place, uv: quad.uv(place), height: height.unwrap_or(0.0) }
    };
    let points = welder.places.iter().zip(&height).map(point).collect();
    let outline = |(piece, outline): (&Piece, Vec<u32>)| Outline {
        corners: welder.with_points_on_sides(&outline),
        flag: piece.flag,
        strip: piece.strip,
    };
    let outlines = pieces.iter().zip(outlines).filter(|(_, outline)| outline.len() > 2).map(outline).collect();
    LocalPicture { quad, points, outlines, triangles: Vec::new() }
}

impl Piece {
    fn height(&self, plane: &Plane, z: DVec2, strips: &Strips) -> f64 {
        strips.height(plane, self.to_flag * z.extend(1.0))
    }
}

/// Finds vertices again by their place.
#[derive(Default)]
struct Welder {
    places: Vec<DVec2>,
    cells: BTreeMap<[i64; 2], Vec<u32>>,
}

impl Welder {
    fn outline(&mut self, polygon: &[DVec2]) -> Vec<u32> {
        let mut outline: Vec<u32> = polygon.iter().map(|&z| self.vertex(z)).collect();
        outline.dedup();
        if outline.len() > 1 && outline.first() == outline.last() {
            outline.pop();
        }
        outline
    }

    fn vertex(&mut self, z: DVec2) -> u32 {
        let cell = [z.x, z.y].map(|x| (x / SNAP).floor() as i64);
        for dx in -1..=1 {
            for dy in -1..=1 {
                let near = self.cells.get(&[cell[0] + dx, cell[1] + dy]);
                let same = near.into_iter().flatten().find(|&&i| self.places[i as usize].distance(z) < SNAP);
                if let Some(&i) = same {
                    return i;
                }
            }
        }
        let new = self.places.len() as u32;
        self.places.push(z);
        self.cells.entry(cell).or_default().push(new);
        new
    }

    fn with_points_on_sides(&self, outline: &[u32]) -> Vec<u32> {
        let mut full = Vec::with_capacity(outline.len());
        for (k, &i) in outline.iter().enumerate() {
            let j = outline[(k + 1) % outline.len()];
            let [from, to] = [i, j].map(|v| self.places[v as usize]);
            let along = (to - from) / from.distance(to);
            let mut between: Vec<(f64, u32)> = Vec::new();
            for (n, &z) in self.places.iter().enumerate() {
                let n = n as u32;
                let t = along.dot(z - from);
                let beside = along.perp_dot(z - from).abs() < SNAP;
                if beside && t > SNAP && t < from.distance(to) - SNAP && n != i && n != j {
                    between.push((t, n));
                }
            }
            between.sort_by(|a, b| a.0.total_cmp(&b.0));
            full.push(i);
            full.extend(between.into_iter().map(|(_, n)| n));
        }
        full
    }
}
