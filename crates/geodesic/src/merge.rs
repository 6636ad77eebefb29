//! Merging neighbouring windows within a relative error.
//!
//! In: the windows of an edge, ε. Out: fewer of them. Holds: a merged window is nowhere above the two that it replaces
//! and equal to them at its ends, its rays cover theirs, and it carries a bound on how far below any path it can be:
//! the errors of what was merged before it add up. That bound never exceeds ε times its least distance, so that
//! (1 − ε)·d ≤ d̃ ≤ d holds for every final distance, however many merges lie on a path.
//! Source: [Bommes2012] §9, approximation algorithm, after [Surazhsky2005] §5; the sum of errors is ours.
//!
//! Why it is never above: where the two meet, the distance has a concave kink or none. The merged function starts at
//! the left end no steeper than the left window and ends at the right no flatter than the right one; its difference to
//! each has one extremum at most, which leaves no room for a change of sign.

use crate::window::{NARROW_REL, TIE_REL, Window};

/// The share of the error allowed that is used; the rest is for rounding, also to single precision.
const SHARE: f64 = 1.0 - 1e-5;
/// Largest distance of a merged source relative to the distance it stands for: beyond it fronts are straight.
const FARTHEST_REL: f64 = 1e3;

/// Merges neighbours in a list where that is allowed; returns how many windows are left, at its start.
///
/// # Input      epsilon: 0 merges only what is equal up to rounding; same_source: whether two roots have one label
/// # Cost       linear
pub(crate) fn merge_pending(
    list: &mut [Window],
    length: f64,
    epsilon: f64,
    same_source: impl Fn(u32, u32) -> bool,
) -> usize {
    let mut last = 0;
    if list.is_empty() {
        return 0;
    }
    for next in 1..list.len() {
        let (l, r) = (list[last], list[next]);
        let fits = (epsilon > 0.0 || l.root() == r.root())
            && l.is_pending()
            && r.is_pending()
            && l.to_canonical() == r.to_canonical()
            && l.is_linear() == r.is_linear()
            && (r.b0 - l.b1).abs() <= 2.0 * NARROW_REL * length
            && same_source(l.root(), r.root());
        match fits.then(|| merged(&l, &r, epsilon)).flatten() {
            Some(window) => list[last] = window,
            None => {
                last += 1;
                if last < next {
                    list[last] = r;
                }
            }
        }
    }
    last + 1
}

/// Two neighbours of one kind as one window, if that is within ε.
fn merged(l: &Window, r: &Window, epsilon: f64) -> Option<Window> {
    if same_function(l, r) {
        return Some(l.over(l.b0, r.b1).with_error(l.error.max(r.error)));
    }
    if epsilon == 0.0 {
        return None;
    }
    // 1. Only over a concave kink, or none: behind a convex one there is a gap that others fill.
    let joint = r.b0;
    let ((_, slope_l), (_, slope_r)) = (l.at_with_slope(joint), r.at_with_slope(joint));
    if slope_r > slope_l + TIE_REL {
        return None;
    }
    // 2. Continuity fixes the distances at the ends; visibility the slopes there.
    let window = if l.is_linear() { straight(l, r)? } else { round(l, r)? };
    // 3. Error.
    let gap =
        |x: f64| if x > l.b0 && x < r.b1 { (if x < joint { l.at(x) } else { r.at(x) }) - window.at(x) } else { 0.0 };
    let worst = [joint, window.parallel_at(l), window.parallel_at(r)].map(gap).into_iter().fold(0.0, f64::max);
    let error = f64::from(l.error.max(r.error)) + worst;
    (error <= SHARE * epsilon * window.least()).then(|| window.with_error(round_up(error)))
}

/// Whether two windows have the same source up to rounding.
fn same_function(l: &Window, r: &Window) -> bool {
    if l.root() != r.root() {
        return false;
    }
    let (([ax, ay], a), ([bx, by], b)) = (l.source(), r.source());
    let near = |x: f64, y: f64, size: f64| (x - y).abs() <= TIE_REL * size;
    if l.is_linear() {
        near(ax, bx, 1.0) && near(ay, by, 1.0) && near(a, b, l.at(l.b0).abs())
    } else {
        let size = ax.abs() + ay;
        near(ax, bx, size) && near(ay, by, size) && near(a, b, a.abs())
    }
}

/// The linear window between the ends of two.
fn straight(l: &Window, r: &Window) -> Option<Window> {
    let (b0, b1) = (l.b0, r.b1);
    let (d0, d1) = (l.at(b0), r.at(b1));
    let slope = (d1 - d0) / (b1 - b0);
    let across = (1.0 - slope * slope).max(0.0).sqrt();
    slope.is_finite().then(|| l.replaced([b0, b1], [slope, across], d0 - slope * b0))
}

/// The circular window through the ends of two with the narrowest pencil of rays that covers theirs.
///
/// With w = b1 − b0, Δ = d0 − d1 and the radii r0, r1 = r0 − Δ at the ends, the slopes at the ends are
/// −Δ/w − (w² − Δ²)/(2·w·r0) and −Δ/w + (w² − Δ²)/(2·w·r1): both conditions bound the radius from above.
fn round(l: &Window, r: &Window) -> Option<Window> {
    let (b0, b1) = (l.b0, r.b1);
    let ((d0, m0), (d1, m1)) = (l.at_with_slope(b0), r.at_with_slope(b1));
    let (w, delta) = (b1 - b0, d0 - d1);
    let squares = (w - delta) * (w + delta);
    if squares.is_nan() || squares <= 0.0 {
        return None;
    }
    let (steep_l, steep_r) = (-(delta + w * m0), w * m1 + delta);
    let mut radius = FARTHEST_REL * d0.max(d1);
    if steep_l > 0.0 {
        radius = radius.min(0.5 * squares / steep_l);
    }
    if steep_r > 0.0 {
        radius = radius.min(0.5 * squares / steep_r + delta);
    }
    let along = 0.5 * (w + delta * (2.0 * radius - delta) / w);
    let height = (radius - along) * (radius + along);
    (radius > 0.0 && radius > delta && height >= 0.0)
        .then(|| l.replaced([b0, b1], [b0 + along, height.sqrt()], d0 - radius))
}

/// The least single that is not below.
fn round_up(x: f64) -> f32 {
    let single = x as f32;
    if f64::from(single) < x { single.next_up() } else { single }
}
