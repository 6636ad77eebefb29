//! Where tubes meet: the side a of every quarter-tube, an arc on the skin from pole to pole between two edges.
//!
//! In: curves, the blending field. Out: [`Rims`]: per flag the arc, as vectors from the junction's vertex.
//! Holds: the arcs at a junction lie in half-planes bounded by its normal, in the cyclic order of the map, each between the
//! two edges that it parts; a flag and its neighbour r₁ share one. Source: [Razafindrazaka2015] §9.4, Fig. 9.11.
//!
//! ```text
//!   seen from the tip of the normal          a half-plane
//!            f·r₁'s edge                        P1 ──╮       pole on the side of the normal
//!              ╱                                │     ╲
//!             ╱  ω/2                            x      K     v = 1/2: half of the arc's length
//!            x ─ ─ ─ ─ K                        │     ╱
//!             ╲  ω/2                            P2 ──╯
//!              ╲ edge of an upright flag f
//! ```

use super::curve::Curve;
use super::skin::Skin;
use crate::skeleton::{Skeleton, first_flags, starts_here};
use glam::{DQuat, DVec3};
use quadloom_mesh::Id;
use quadloom_regular_maps::ids::{FlagId, MapVertexId};
use quadloom_regular_maps::map::{Reflection, RegularMap};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// How far from a junction the directions of its edges are read, in tube radii, the first that keeps the map's order of
/// edges. Curves that leave side by side and part later are parted where the tubes are.
const SPOKE_LENGTHS: [f64; 4] = [2.0, 1.0, 0.5, 0.1];

/// Directions tried between the poles for each cell around; the arc is measured along them.
const SAMPLES_PER_CELL: usize = 4;

/// Directions of the edges at every junction, by flag.
pub(super) struct Spokes {
    spoke: Vec<DVec3>,
}

impl Spokes {
    pub(super) fn new(map: &RegularMap, skeleton: &Skeleton, curves: &[Curve], radius: f64) -> Self {
        let mut spoke = vec![DVec3::ZERO; map.order()];
        for (vertex, first) in first_flags(map) {
            let flags = around(map, first);
            let spokes = spokes_at(map, skeleton, curves, radius, (vertex, &flags));
            for (&flag, direction) in flags.iter().zip(spokes) {
                spoke[flag.index()] = direction;
                spoke[map.reflect(flag, Reflection::R2).index()] = direction;
            }
        }
        Self { spoke }
    }

    /// The unit direction in which a flag's edge leaves its vertex.
    pub(super) fn of(&self, flag: FlagId) -> DVec3 {
        self.spoke[flag.index()]
    }
}

/// The upright flags of a vertex in counter-clockwise order.
fn around(map: &RegularMap, first: FlagId) -> Vec<FlagId> {
    let turn = |&flag: &FlagId| Some(map.walk(flag, &[Reflection::R1, Reflection::R2]));
    std::iter::successors(Some(first), turn).take(map.q()).collect()
}

fn spokes_at(
    map: &RegularMap,
    skeleton: &Skeleton,
    curves: &[Curve],
    radius: f64,
    (vertex, flags): (MapVertexId, &[FlagId]),
) -> Vec<DVec3> {
    let normal = skeleton.normals[vertex.index()];
    let read =
        |length: f64| -> Vec<DVec3> { flags.iter().map(|&flag| chord(map, curves, flag, length * radius)).collect() };
    let in_order = |spokes: &Vec<DVec3>| {
        let next = spokes.iter().cycle().skip(1);
        let turn: f64 = spokes.iter().zip(next).map(|(&a, &b)| wedge(normal, a, b)).sum();
        (turn - TAU).abs() < 1e-6
    };
    let tangents = || flags.iter().map(|&f| curves[map.edge(f).index()].leaving()[usize::from(!starts_here(map, f))]);
    SPOKE_LENGTHS.into_iter().map(read).find(in_order).unwrap_or_else(|| tangents().collect())
}

/// The direction to the point of a flag's edge at some length, at most a quarter of it.
fn chord(map: &RegularMap, curves: &[Curve], flag: FlagId, length: f64) -> DVec3 {
    let curve = &curves[map.edge(flag).index()];
    let length = length.min(0.25 * curve.length());
    let [from, to] = if starts_here(map, flag) { [0.0, length] } else { [curve.length(), curve.length() - length] };
    (curve.at(to).point - curve.at(from).point).normalize_or(DVec3::X)
}

/// The counter-clockwise angle about a normal from one direction to another, in (0, 2π]; from a direction to itself 2π.
pub(super) fn wedge(normal: DVec3, from: DVec3, to: DVec3) -> f64 {
    let angle = normal.dot(from.cross(to)).atan2(from.dot(to) - from.dot(normal) * to.dot(normal));
    if angle > 1e-9 { angle } else { angle + TAU }
}

/// The sides a of all quarter-tubes.
pub(super) struct Rims {
    arcs: Vec<Vec<DVec3>>,
}

impl Rims {
    /// # Input      `cells`: parts of equal length each arc is divided into
    pub(super) fn new(skin: &Skin, cells: usize) -> Self {
        let map = skin.map();
        let arcs: Vec<Vec<DVec3>> = (0..map.order())
            .into_par_iter()
            .map(|k| if skin.is_upright(FlagId::new(k)) { arc(skin, FlagId::new(k), cells) } else { Vec::new() })
            .collect();
        let shared = |flag: FlagId| match &arcs[flag.index()] {
            arc if !arc.is_empty() => arc.clone(),
            _ => arcs[map.reflect(flag, Reflection::R1).index()].iter().rev().copied().collect(),
        };
        Self { arcs: map.flags().map(shared).collect() }
    }

    /// Points of a flag's side a from P1 to P2, as vectors from its vertex.
    pub(super) fn arc(&self, flag: FlagId) -> &[DVec3] {
        &self.arcs[flag.index()]
    }
}

/// The arc of an upright flag: between its edge and the next one counter-clockwise.
fn arc(skin: &Skin, flag: FlagId, cells: usize) -> Vec<DVec3> {
    let normal = skin.normal(flag);
    let [here, next] = [flag, skin.map().reflect(flag, Reflection::R1)].map(|f| skin.spokes().of(f));
    let flat = (here - normal * here.dot(normal)).normalize_or(normal.any_orthonormal_vector());
    let bisector = DQuat::from_axis_angle(normal, 0.5 * wedge(normal, here, next)) * flat;
    let samples = SAMPLES_PER_CELL * cells;
    let ray = |k: usize| {
        let (sin, cos) = (PI * k as f64 / samples as f64).sin_cos();
        let direction = cos * normal + sin * bisector;
        direction * skin.reach_at_junction(flag, direction)
    };
    divided(&(0..=samples).map(ray).collect::<Vec<_>>(), cells)
}

/// Points that divide a polyline into parts of equal length.
fn divided(line: &[DVec3], parts: usize) -> Vec<DVec3> {
    let mut arc = vec![0.0];
    for pair in line.windows(2) {
        arc.push(arc[arc.len() - 1] + pair[0].distance(pair[1]));
    }
    let last = line.len() - 1;
    let place = |k: usize| {
        let at = arc[last] * k as f64 / parts as f64;
        let i = arc.partition_point(|&a| a < at).clamp(1, last);
        line[i - 1].lerp(line[i], (at - arc[i - 1]) / (arc[i] - arc[i - 1]).max(f64::MIN_POSITIVE))
    };
    let inner = (1..parts).map(place);
    std::iter::once(line[0]).chain(inner).chain(std::iter::once(line[last])).collect()
}
