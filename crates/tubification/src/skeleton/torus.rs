//! Skeletons of the maps on the torus: {4, 4}, {3, 6} and {6, 3}.
//!
//! In: an orientable map of genus 1. Out: its [`Skeleton`] on a torus of revolution.
//! Holds: which vertices are one is decided by integers, the coordinates of translations in the tiling's own lattice;
//! edges are straight lines of the flat torus. Not: the largest clearance there is; it is the largest among the bases,
//! proportions and offsets tried.
//! Source: [Razafindrazaka2015] §9.2, Fig. 9.6.
//!
//! ```text
//!   plane of the tiling ──(α, β) in a basis of identifications──▶ torus: α once around the axis, β around the tube
//! ```

use super::clearance::clearance_above;
use super::{Skeleton, edge_flags, first_flags};
use glam::{DVec2, DVec3, dvec2};
use quadloom_mesh::Id;
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::{Reflection, RegularMap};
use quadloom_regular_maps::plane::{Curvature, Plane};
use std::f64::consts::TAU;

/// Radii of the torus' tube tried, relative to the radius of its middle circle.
const PROPORTIONS: [f64; 7] = [0.3, 0.36, 0.42, 0.48, 0.54, 0.6, 0.66];

/// Turns about the tube tried; where an edge or vertex lies on the inner side is what it changes.
const OFFSETS: [f64; 5] = [0.0, 0.125, 0.25, 0.375, 0.5];

/// Bases of the identifications tried are those with entries up to this one in the shortest basis; all that are longer
/// wind edges around the torus so often that they come close to each other.
const BASIS_ENTRIES: i64 = 2;

/// Longest angle, in turns, between points of an edge.
const STEP: f64 = 1.0 / 48.0;

/// The skeleton of a map on the torus; none for other maps.
///
/// # Output     the torus' axis is z, its middle circle has radius 1; normals are those of the torus
/// # Cost       [`clearance`](super::clearance()) of some 500 candidates
pub fn torus(map: &RegularMap) -> Option<Skeleton> {
    let flat = Curvature::of_type(map.p().max(2), map.q().max(2)) == Curvature::Flat;
    if !flat || !map.is_orientable() || map.genus() != 1 {
        return None;
    }
    let layout = Layout::new(map);
    let candidates: Vec<_> = bases(layout.lattice)
        .into_iter()
        .flat_map(|basis| PROPORTIONS.map(|ratio| (basis, ratio)))
        .flat_map(|(basis, ratio)| OFFSETS.map(|offset| Shape { basis, ratio, offset }))
        .collect();
    let mut best = (0.0, layout.skeleton(candidates.first()?));
    for shape in &candidates {
        let skeleton = layout.skeleton(shape);
        // Among equals the first: short bases and slim tori.
        if let Some(found) = clearance_above(map, &skeleton, best.0 * (1.0 + 1e-9)) {
            best = (found, skeleton);
        }
    }
    Some(best.1)
}

struct Shape {
    basis: [DVec2; 2],
    ratio: f64,
    offset: f64,
}

/// A map on the torus, laid out in the plane along the search tree of its flags.
struct Layout {
    /// Per vertex: its place and whether upright flags turn counter-clockwise in the plane.
    vertices: Vec<(DVec2, bool)>,
    /// Per edge: the place of its start and its end.
    edges: Vec<[DVec2; 2]>,
    /// Start and end vertex of each edge.
    ends: Vec<[usize; 2]>,
    lattice: [DVec2; 2],
}

impl Layout {
    fn new(map: &RegularMap) -> Self {
        let plane = Plane::of_type(map.p(), map.q());
        let place = |flag: FlagId| plane.isometry(&map.reflections_of(flag));
        let vertices = first_flags(map).into_iter().map(|(_, flag)| {
            let isometry = place(flag);
            ((isometry * plane.corners[0]).truncate(), isometry.determinant() > 0.0)
        });
        let edge = |flag: FlagId| {
            let isometry = place(flag);
            let there = isometry * (plane.reflection(Reflection::R0) * plane.corners[0]);
            [(isometry * plane.corners[0]).truncate(), there.truncate()]
        };
        let flags = edge_flags(map);
        let ends = |flag: FlagId| [map.vertex(flag).index(), super::other_end(map, flag).index()];
        Self {
            vertices: vertices.collect(),
            edges: flags.iter().map(|&(_, flag)| edge(flag)).collect(),
            ends: flags.iter().map(|&(_, flag)| ends(flag)).collect(),
            lattice: identifications(map, &plane),
        }
    }

    fn skeleton(&self, shape: &Shape) -> Skeleton {
        let inverse = glam::DMat2::from_cols(shape.basis[0], shape.basis[1]).inverse();
        let turns = |at: DVec2| inverse * (at - self.vertices[0].0);
        let positions: Vec<_> = self.vertices.iter().map(|&(at, _)| on_torus(turns(at), shape).0).collect();
        let normal = |&(at, upright): &(DVec2, bool)| on_torus(turns(at), shape).1 * if upright { 1.0 } else { -1.0 };
        let edges = self.edges.iter().zip(&self.ends).map(|(line, ends)| {
            let [from, to] = line.map(turns);
            let steps = ((to - from).length() / STEP).ceil().max(12.0) as usize;
            let mut points: Vec<_> =
                (0..=steps).map(|i| on_torus(from.lerp(to, i as f64 / steps as f64), shape).0).collect();
            points[0] = positions[ends[0]];
            points[steps] = positions[ends[1]];
            points
        });
        let edges = edges.collect();
        Skeleton { normals: self.vertices.iter().map(normal).collect(), positions, edges }
    }
}

/// Point and outward normal; turning α then β is counter-clockwise seen from outside.
fn on_torus(turns: DVec2, shape: &Shape) -> (DVec3, DVec3) {
    let (sin, cos) = (TAU * turns.x).sin_cos();
    let (up, out) = (TAU * (turns.y + shape.offset)).sin_cos();
    let normal = DVec3::new(cos * out, sin * out, up);
    (DVec3::new(cos, sin, 0.0) + shape.ratio * normal, normal)
}

/// A reduced basis of the translations that identify points of the plane: those that a step to a neighbour leaves over
/// where the neighbour was laid out elsewhere. Positively oriented.
fn identifications(map: &RegularMap, plane: &Plane) -> [DVec2; 2] {
    let units = unit_translations(plane, map.p());
    let inverse = glam::DMat2::from_cols(units[0], units[1]).inverse();
    let mut basis = [[0i64; 2]; 2];
    for flag in map.flags() {
        let here = plane.isometry(&map.reflections_of(flag));
        for by in Reflection::ALL {
            let there = plane.isometry(&map.reflections_of(map.reflect(flag, by)));
            let shift = (here * plane.reflection(by) * there.inverse() * DVec3::Z).truncate();
            let coordinates = (inverse * shift).round();
            extend(&mut basis, [coordinates.x as i64, coordinates.y as i64]);
        }
    }
    let [mut a, mut b] = basis.map(|[x, y]| units[0] * x as f64 + units[1] * y as f64);
    // Gauss' reduction; lengths are those of lattice vectors, so the margin decides nothing but ties.
    loop {
        b -= (a.dot(b) / a.length_squared()).round() * a;
        if b.length_squared() > a.length_squared() * (1.0 - 1e-9) {
            break;
        }
        std::mem::swap(&mut a, &mut b);
    }
    if a.perp_dot(b) < 0.0 { [a, -b] } else { [a, b] }
}

/// Shortest translations of the tiling: from the face at the origin to two neighbours of its kind.
fn unit_translations(plane: &Plane, p: usize) -> [DVec2; 2] {
    let apothem = plane.corners[1].truncate().length();
    let (length, angle) = match p {
        4 => (2.0 * apothem, TAU / 4.0),
        6 => (2.0 * apothem, TAU / 6.0),
        // Triangles point both ways; vertices are as far apart as faces that point alike, and in these directions.
        _ => {
            return [plane.corners[0] - plane.reflection(Reflection::R0) * plane.corners[0], {
                let third = plane.isometry(&[Reflection::R1, Reflection::R0]) * plane.corners[0];
                plane.corners[0] - third
            }]
            .map(DVec3::truncate);
        }
    };
    [dvec2(length, 0.0), dvec2(length * angle.cos(), length * angle.sin())]
}

/// Adds a vector to the lattice of integer vectors with this basis, in Hermite form [a, b], [0, d].
fn extend(basis: &mut [[i64; 2]; 2], mut v: [i64; 2]) {
    while v[0] != 0 {
        let k = basis[0][0].div_euclid(v[0]);
        let rest = [basis[0][0] - k * v[0], basis[0][1] - k * v[1]];
        basis[0] = v;
        v = rest;
    }
    while v[1] != 0 {
        let k = basis[1][1].div_euclid(v[1]);
        (basis[1][1], v[1]) = (v[1], basis[1][1] - k * v[1]);
    }
    if basis[1][1] != 0 {
        basis[0][1] = basis[0][1].rem_euclid(basis[1][1]);
    }
}

/// Positively oriented bases of the same lattice, short ones first.
fn bases([a, b]: [DVec2; 2]) -> Vec<[DVec2; 2]> {
    let range = -BASIS_ENTRIES..=BASIS_ENTRIES;
    let entries = range.clone().flat_map(|x| range.clone().map(move |y| [x, y]));
    // A basis and its negative are the same torus, turned over.
    let half: Vec<_> = entries.clone().filter(|&[x, y]| x > 0 || (x == 0 && y > 0)).collect();
    let vector = |[x, y]: [i64; 2]| a * x as f64 + b * y as f64;
    let mut found: Vec<_> = half
        .iter()
        .flat_map(|&s| entries.clone().map(move |t| [s, t]))
        .filter(|[s, t]| s[0] * t[1] - s[1] * t[0] == 1)
        .map(|pair| pair.map(vector))
        .collect();
    let length = |v: &[DVec2; 2]| v[0].length_squared() + v[1].length_squared();
    found.sort_by(|s, t| length(s).total_cmp(&(length(t))));
    found.truncate(MOST_BASES);
    found
}

/// Bases tried at most.
const MOST_BASES: usize = 16;
