//! Values at the grid points of all patches, in between.
//!
//! In: a value per vertex of a [`Grid`]. Out: the value at (u, v) of a flag's patch.
//! Holds: continuous; along glued sides both patches give the same bits; within and across the sides b, c, d, but for the
//! cells at poles, continuously differentiable. Source: Catmull-Rom interpolation.

use super::grid::Grid;
use glam::DVec3;
use quadloom_regular_maps::ids::{FlagId, FlagMap};
use quadloom_regular_maps::map::Reflection;
use quadloom_regular_maps::map::RegularMap;
use std::cmp::Ordering;

/// The neighbours of each flag under r₀, r₁ and r₂.
pub(super) type Neighbours = FlagMap<[FlagId; 3]>;

pub(super) fn neighbours(map: &RegularMap) -> Neighbours {
    map.flags().map(|flag| Reflection::ALL.map(|by| map.reflect(flag, by))).collect()
}

/// The value at a point of a patch.
pub(super) fn interpolate(grid: &Grid, beside: &Neighbours, values: &[DVec3], at: (FlagId, f64, f64)) -> DVec3 {
    let (flag, u, v) = canonical(beside, at);
    let (i, s) = cell(u, grid.along());
    let (j, t) = cell(v, grid.around());
    let [first, second] = [weights(s), weights(t)];
    (0..4).map(|k| second[k] * row(grid, beside, values, flag, i, j + k as isize - 1, first)).sum()
}

/// Sides a and c belong to two patches, turned: the half with v ≥ 1/2 speaks for both, of two middles the smaller flag's.
fn canonical(beside: &Neighbours, (flag, u, v): (FlagId, f64, f64)) -> (FlagId, f64, f64) {
    let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
    let other = match u {
        0.0 => beside[flag][Reflection::R1 as usize],
        1.0 => beside[flag][Reflection::R0 as usize],
        _ => return (flag, u, v),
    };
    match v.total_cmp(&0.5) {
        Ordering::Greater => (flag, u, v),
        Ordering::Less => (other, u, 1.0 - v),
        Ordering::Equal => (flag.min(other), u, v),
    }
}

fn cell(x: f64, cells: usize) -> (isize, f64) {
    let x = x * cells as f64;
    let i = (x as usize).min(cells - 1);
    (i as isize, x - i as f64)
}

/// Exactly 0, 1, 0, 0 at 0 and 0, 0, 1, 0 at 1.
fn weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [t2 - 0.5 * (t + t3), 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, 0.5 * (t3 - t2)]
}

/// Along a row of grid points, around which there are others: across the side d or b lies the flag's r₂-neighbour.
fn row(
    grid: &Grid,
    beside: &Neighbours,
    values: &[DVec3],
    flag: FlagId,
    i: isize,
    j: isize,
    weights: [f64; 4],
) -> DVec3 {
    let (around, along) = (grid.around() as isize, grid.along() as isize);
    let (there, row) = match j {
        j if j < 0 => (beside[flag][Reflection::R2 as usize], j + around),
        j if j > around => (beside[flag][Reflection::R2 as usize], j - around),
        j => (flag, j),
    };
    let own = |j: isize| values[grid.vertex(flag, 0, j as usize)];
    let value = |i: isize| match (i, j) {
        // A junction's corner lines end at its poles: beyond them they are continued, since the neighbour's is another.
        (0, j) if j < 0 => ahead([own(0), own(1), own(2)]),
        (0, j) if j > around => ahead([own(around), own(around - 1), own(around - 2)]),
        _ => values[grid.vertex(there, i as usize, row as usize)],
    };
    let at = |i: isize| match i {
        // Across a junction's corner lines have no straight continuation.
        -1 => ahead([value(0), value(1), value(2)]),
        i if i > along => {
            let there = beside[there][Reflection::R0 as usize];
            values[grid.vertex(there, (2 * along - i) as usize, (around - row) as usize)]
        }
        i => value(i),
    };
    (0..4).map(|k| weights[k] * at(i + k as isize - 1)).sum()
}

/// The value before three others, on their parabola.
fn ahead([a, b, c]: [DVec3; 3]) -> DVec3 {
    3.0 * (a - b) + c
}
