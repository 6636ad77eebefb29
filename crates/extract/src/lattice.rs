//! Exact arithmetic on the parameter lattice: directions, lines, rounding.
//!
//! In: lattice points. Out: signs and integers. Holds: every decision is exact while coordinates stay below
//! [`COORDINATE_LIMIT`]. Source: own; the need for it is [Ebke2013] §4.

use quadloom_param::{GRID_UNIT, LatticePoint, Transition};

/// Largest coordinate, lattice units, for which the products of four differences stay inside 128 bits.
///
/// 2^50 lattice units are 2^26 grid units: far more quads in a row than a mesh with 32-bit ids can have.
pub(crate) const COORDINATE_LIMIT: i64 = 1 << 50;

/// The unit vectors of the four directions, counter-clockwise from +u.
pub(crate) const DIRECTION: [[i64; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// The opposite direction.
#[inline]
pub(crate) fn opposite(direction: u8) -> u8 {
    (direction + 2) % 4
}

/// Sign of the cross product of `a` with a direction.
#[inline]
pub(crate) fn cross_direction(a: LatticePoint, direction: u8) -> i64 {
    let d = DIRECTION[direction as usize];
    (a[0] * d[1] - a[1] * d[0]).signum()
}

/// `b - a`.
#[inline]
pub(crate) fn difference(a: LatticePoint, b: LatticePoint) -> LatticePoint {
    [b[0] - a[0], b[1] - a[1]]
}

/// Whether both coordinates are whole grid units.
#[inline]
pub(crate) fn is_grid_point(p: LatticePoint) -> bool {
    p[0] % GRID_UNIT == 0 && p[1] % GRID_UNIT == 0
}

/// A unit segment of the grid, from a grid point to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GridSegment {
    /// Its end.
    pub target: LatticePoint,
    /// Direction from its start to its end.
    pub direction: u8,
}

impl GridSegment {
    /// The segment that leaves `start`.
    pub fn from(start: LatticePoint, direction: u8) -> Self {
        let d = DIRECTION[direction as usize];
        Self { target: [start[0] + d[0] * GRID_UNIT, start[1] + d[1] * GRID_UNIT], direction }
    }

    /// Its start.
    #[inline]
    pub fn start(self) -> LatticePoint {
        let d = DIRECTION[self.direction as usize];
        [self.target[0] - d[0] * GRID_UNIT, self.target[1] - d[1] * GRID_UNIT]
    }

    /// The same segment in another chart.
    #[inline]
    pub fn in_chart(self, t: Transition) -> Self {
        Self { target: t.apply(self.target), direction: (self.direction + t.quarter_turns) % 4 }
    }

    /// 1 for points left of the segment's line, -1 right of it, 0 on it.
    #[inline]
    pub fn side(self, p: LatticePoint) -> i64 {
        let [x, y] = difference(self.target, p);
        match self.direction {
            0 => y.signum(),
            1 => -x.signum(),
            2 => -y.signum(),
            _ => x.signum(),
        }
    }

    /// Position along the line, lattice units, 0 at the target.
    #[inline]
    pub fn along(self, p: LatticePoint) -> i64 {
        let d = DIRECTION[self.direction as usize];
        let q = difference(self.target, p);
        d[0] * q[0] + d[1] * q[1]
    }
}

/// Whole grid units strictly inside the open interval between `low` and `high` (in either order), as a range.
pub(crate) fn grid_units_between(low: i64, high: i64) -> std::ops::Range<i64> {
    let (low, high) = (low.min(high), low.max(high));
    low.div_euclid(GRID_UNIT) + 1..-(-high).div_euclid(GRID_UNIT)
}

/// The largest integer below and the smallest integer above the fraction `numerator / denominator`, both strictly.
pub(crate) fn strict_neighbours(numerator: i128, denominator: i128) -> (i128, i128) {
    let (n, d) = if denominator < 0 { (-numerator, -denominator) } else { (numerator, denominator) };
    (-(-n).div_euclid(d) - 1, n.div_euclid(d) + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_strict() {
        assert_eq!(strict_neighbours(6, 3), (1, 3));
        assert_eq!(strict_neighbours(7, 3), (2, 3));
        assert_eq!(strict_neighbours(-7, 3), (-3, -2));
        assert_eq!(strict_neighbours(7, -3), (-3, -2));
    }

    #[test]
    fn units_between_are_strict() {
        assert_eq!(grid_units_between(0, 3 * GRID_UNIT), 1..3);
        assert_eq!(grid_units_between(3 * GRID_UNIT + 1, -1), 0..4);
        assert!(grid_units_between(1, GRID_UNIT).is_empty());
    }

    #[test]
    fn sides_turn_with_the_chart() {
        let s = GridSegment::from([0, 0], 0);
        assert_eq!((s.side([5, 3]), s.side([5, -3]), s.side([7, 0])), (1, -1, 0));
        for quarter_turns in 0..4 {
            let t = Transition { quarter_turns, translation: [3 * GRID_UNIT, -GRID_UNIT] };
            let r = s.in_chart(t);
            for p in [[5, 3], [5, -3], [-9, 0]] {
                assert_eq!((s.side(p), s.along(p)), (r.side(t.apply(p)), r.along(t.apply(p))));
            }
            assert_eq!(r.start(), t.apply(s.start()));
        }
    }
}
