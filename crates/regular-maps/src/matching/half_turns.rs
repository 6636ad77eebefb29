//! The half-turns of a tiling near a point.
//!
//! In: a map, its plane, a point. Out: for each centre of a half-turn near the point the isometry and the element of the
//! map's group, nearest first. Holds: every half-turn that preserves the tiling has its centre at an edge's midpoint, a
//! face of even p or a vertex of even q.

use crate::ids::FlagId;
use crate::map::{Reflection, RegularMap};
use crate::plane::Plane;
use glam::{DMat3, DVec3};
use std::collections::{BTreeMap, VecDeque};

/// A half-turn of the tiling.
#[derive(Clone, Debug)]
pub(super) struct HalfTurn {
    pub centre: DVec3,
    pub isometry: DMat3,
    pub element: FlagId,
}

/// The `count` half-turns nearest to a point.
///
/// # Cost       a breadth-first search over about three times as many flags as are in the disk that holds them
pub(super) fn half_turns_near(map: &RegularMap, plane: &Plane, point: DVec3, count: usize) -> Vec<HalfTurn> {
    let seeds = seeds(map, plane);
    let mut by_centre: BTreeMap<(i64, i64), HalfTurn> = BTreeMap::new();
    for (isometry, element) in flags_near(map, plane, point, 4 * count) {
        for &(corner, seed) in &seeds {
            let centre = plane.normalised(isometry * corner);
            by_centre.entry(rounded(centre)).or_insert_with(|| HalfTurn {
                centre,
                isometry: half_turn(centre),
                element: map.product(map.product(element, seed), map.inverse(element)),
            });
        }
    }
    let mut all: Vec<_> = by_centre.into_values().collect();
    let key = |turn: &HalfTurn| ((plane.distance(point, turn.centre) * 1e7).round() as i64, rounded(turn.centre));
    all.sort_by_cached_key(key);
    all.truncate(count);
    all
}

/// Centres and elements of the half-turns about the corners of the base flag.
fn seeds(map: &RegularMap, plane: &Plane) -> Vec<(DVec3, FlagId)> {
    use Reflection::{R0, R1, R2};
    let mut words = vec![(1, vec![R0, R2])];
    if map.p().is_multiple_of(2) {
        words.push((2, [R0, R1].repeat(map.p() / 2)));
    }
    if map.q().is_multiple_of(2) {
        words.push((0, [R1, R2].repeat(map.q() / 2)));
    }
    words.into_iter().map(|(corner, word)| (plane.corners[corner], map.walk(FlagId(0), &word))).collect()
}

/// z ↦ 2⟨c, z⟩c − z with ⟨c, z⟩ = c_w z_w − c_x z_x − c_y z_y: no digits are lost, as they are in a product of matrices.
fn half_turn(centre: DVec3) -> DMat3 {
    let dual = DVec3::new(-centre.x, -centre.y, centre.z);
    let column = |k: usize| 2.0 * dual[k] * centre - DVec3::AXES[k];
    DMat3::from_cols(column(0), column(1), column(2))
}

/// Flags of the whole tiling around a point, by breadth-first search from the base flag, which is nearest to it.
fn flags_near(map: &RegularMap, plane: &Plane, point: DVec3, count: usize) -> Vec<(DMat3, FlagId)> {
    let inside = plane.normalised(plane.corners.iter().sum());
    let mut seen = BTreeMap::new();
    let mut queue = VecDeque::from([(DMat3::IDENTITY, FlagId(0))]);
    seen.insert(rounded(inside), ());
    let mut found = Vec::new();
    let limit = 6 * count;
    while let Some((isometry, element)) = queue.pop_front() {
        found.push((isometry, element));
        if found.len() >= limit {
            break;
        }
        for by in Reflection::ALL {
            let next = isometry * plane.reflection(by);
            if seen.insert(rounded(next * inside), ()).is_none() {
                queue.push_back((next, map.reflect(element, by)));
            }
        }
    }
    let key = |(isometry, _): &(DMat3, FlagId)| (plane.distance(point, *isometry * inside) * 1e7).round() as i64;
    found.sort_by_cached_key(key);
    found
}

/// Centres are told apart by their place in the disk where straight lines are straight.
fn rounded(point: DVec3) -> (i64, i64) {
    // Places near the rim lie close together there, so the hyperboloid's own coordinates are taken.
    ((point.x * 1e4).round() as i64, (point.y * 1e4).round() as i64)
}
