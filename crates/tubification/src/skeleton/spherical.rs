//! Skeletons of the maps on the sphere: Platonic solids, hosohedra, dihedra.
//!
//! In: a map of genus 0. Out: its [`Skeleton`] on the unit sphere: straight edges for the solids, half circles for
//! hosohedra {2, n}, a circle for dihedra {n, 2}. Holds: the whole rotation group of the map acts on it.
//! Source: [Razafindrazaka2015] §9.2, Fig. 9.5.

use super::{Skeleton, edge_flags, first_flags, other_end};
use glam::DVec3;
use quadloom_mesh::Id;
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::RegularMap;
use quadloom_regular_maps::plane::Plane;

/// Points per edge, ends included; straight edges need fewer, but tubes around them bend with their normals.
const POINTS: usize = 17;

/// The skeleton of a map on the sphere; none for other maps.
///
/// # Output     vertices on the unit sphere about the origin, normals radial
/// # Cost       linear
pub fn spherical(map: &RegularMap) -> Option<Skeleton> {
    if !map.is_orientable() || map.genus() != 0 || map.p() < 2 || map.q() < 2 {
        return None;
    }
    let plane = Plane::of_type(map.p(), map.q());
    let place = |flag: FlagId| plane.isometry(&map.reflections_of(flag));
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for (_, flag) in first_flags(map) {
        let isometry = place(flag);
        let position = isometry * plane.corners[0];
        positions.push(position);
        // Seen from outside, the order of the flag and its rotations is clockwise where the isometry reflects.
        normals.push(position * isometry.determinant().signum());
    }
    let bent = map.p() == 2 || map.q() == 2;
    let edges = edge_flags(map).into_iter().map(|(_, flag)| {
        let isometry = place(flag);
        let ends = [map.vertex(flag), other_end(map, flag)].map(|v| positions[v.index()]);
        if bent { arc(isometry * plane.corners[1], ends) } else { straight(ends) }
    });
    let edges = edges.collect();
    Some(Skeleton { positions, normals, edges })
}

fn straight(ends: [DVec3; 2]) -> Vec<DVec3> {
    sampled(ends, |t| ends[0].lerp(ends[1], t))
}

/// The arc of a great circle over a midpoint on the unit sphere.
fn arc(middle: DVec3, ends: [DVec3; 2]) -> Vec<DVec3> {
    let side = (ends[1] - ends[0]).normalize();
    let half = ends[0].dot(middle).clamp(-1.0, 1.0).acos();
    sampled(ends, |t| {
        let (sin, cos) = ((2.0 * t - 1.0) * half).sin_cos();
        middle * cos + side * sin
    })
}

/// Points at even parameters, the ends exactly.
pub(super) fn sampled(ends: [DVec3; 2], at: impl Fn(f64) -> DVec3) -> Vec<DVec3> {
    let last = POINTS - 1;
    let inner = (1..last).map(|i| at(i as f64 / last as f64));
    std::iter::once(ends[0]).chain(inner).chain(std::iter::once(ends[1])).collect()
}
