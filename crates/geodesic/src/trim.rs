//! Which of two windows is nearer, and where.
//!
//! In: two windows and the interval that both cover. Out: [`Outcome`], the parts of it that the new one wins.
//! Holds: the difference of two window functions has at most one extremum, found in closed form, so that the signs at
//! the two ends and there tell how many times they cross, at most twice; each crossing is then found in a bracket.
//! Nothing depends on which root of a quadratic equation is meant.
//! Source: [Bommes2012] §9, circular and linear window intersection.

use crate::window::{TIE_REL, Window};

/// Who has the shorter distance over an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outcome {
    /// The old one.
    Old,
    /// Neither, beyond rounding.
    Equal,
    /// The new one.
    New,
    /// The new one before the place, the old one after it.
    NewThenOld(f64),
    /// The old one before the place, the new one after it.
    OldThenNew(f64),
    /// The new one between the places.
    NewInside(f64, f64),
    /// The old one between the places.
    OldInside(f64, f64),
}

/// Compares two windows over `lo..=hi`, which both cover.
#[inline]
pub(crate) fn compare(new: &Window, old: &Window, lo: f64, hi: f64, narrow: f64) -> Outcome {
    let difference = |x: f64| {
        let (n, o) = (new.at(x), old.at(x));
        (n - o, TIE_REL * (n + o))
    };
    // -1: the new one is shorter; 0: equal.
    let sign = |(f, tie): (f64, f64)| if f < -tie { -1 } else { i32::from(f > tie) };
    let (at_lo, at_hi) = (difference(lo), difference(hi));
    let (s_lo, s_hi) = (sign(at_lo), sign(at_hi));
    let x = new.parallel_at(old);
    let middle = (x > lo + narrow && x < hi - narrow).then(|| (x, difference(x)));
    let s_mid = middle.map_or(0, |(_, f)| sign(f));
    let cross = |a: (f64, f64), b: (f64, f64)| crossing(new, old, a, b);
    let (l, m, h) = ((lo, at_lo.0), middle.map_or((x, 0.0), |(x, f)| (x, f.0)), (hi, at_hi.0));
    match (s_lo, s_mid, s_hi) {
        (0, 0, 0) => Outcome::Equal,
        (0 | 1, 0 | 1, 0 | 1) => Outcome::Old,
        (-1 | 0, -1 | 0, -1 | 0) => Outcome::New,
        (-1, 1, 1..) | (-1, 1, 0) if s_hi >= 0 => Outcome::NewThenOld(cross(l, m)),
        (0.., 1, -1) => Outcome::OldThenNew(cross(m, h)),
        (-1, 1, -1) => Outcome::OldInside(cross(l, m), cross(m, h)),
        (-1, -1, 1) => Outcome::NewThenOld(cross(m, h)),
        (1, -1, -1) => Outcome::OldThenNew(cross(l, m)),
        (1, -1, 1) => Outcome::NewInside(cross(l, m), cross(m, h)),
        (1, -1, 0) => Outcome::OldThenNew(cross(l, m)),
        (0, -1, 1) => Outcome::NewThenOld(cross(m, h)),
        (-1, 0, 1) => Outcome::NewThenOld(cross(l, h)),
        (1, 0, -1) => Outcome::OldThenNew(cross(l, h)),
        // All signs are in -1..=1 and were met above.
        _ => Outcome::Old,
    }
}

/// Steps of Newton's method, guarded by bisection; four are usual.
const MAX_STEPS: usize = 80;
/// A step shorter than this, relative to the bracket, is the last: the next one would be as short as its square.
const LAST_STEP: f64 = 1e-9;

/// The place between two places with known differences where the two distances are equal; the difference changes its
/// sign once between them.
fn crossing(new: &Window, old: &Window, (mut lo, f_lo): (f64, f64), (mut hi, f_hi): (f64, f64)) -> f64 {
    let rising = f_hi > f_lo;
    let mut x = (lo * f_hi - hi * f_lo) / (f_hi - f_lo);
    let width = hi - lo;
    for _ in 0..MAX_STEPS {
        if !(x > lo && x < hi) {
            x = 0.5 * (lo + hi);
        }
        let ((n, dn), (o, d_o)) = (new.at_with_slope(x), old.at_with_slope(x));
        let (f, slope) = (n - o, dn - d_o);
        if f == 0.0 {
            return x;
        }
        if (f > 0.0) == rising {
            hi = x
        } else {
            lo = x
        }
        let next = x - f / slope;
        if (next - x).abs() <= LAST_STEP * width || hi - lo <= 1e-15 * width {
            return next.clamp(lo, hi);
        }
        x = next;
    }
    x.clamp(lo, hi)
}
