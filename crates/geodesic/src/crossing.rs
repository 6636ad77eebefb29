//! Windows across a face: what of a pencil of rays arrives on its other sides.
//!
//! In: a face laid out over the half-edge through which a window enters it. Out: windows on the two other sides, each
//! in the frame of its half-edge. Holds: rays are widened by more than rounding can move them (a part of the face,
//! [`OVERLAP_REL`], and what its lengths leave open), so that neighbours overlap. Source: [Bommes2012] §9, circular and linear window propagation.
//!
//! ```text
//!            c              base a → b = half-edge h, its face above it, the source s below
//!          ╱   ╲            a window b0..b1 on the base is seen from s through two rays:
//!   left ╱       ╲ right    c between them: a child on each side
//!      a ─[b0 b1]─ b        c left of both: one child, on the right side; and so on
//!            s
//! ```

use crate::surface::{Apex, IntrinsicSurface};
use crate::window::{DRIFT_REL, OVERLAP_REL, Window};
use quadloom_mesh::HalfEdgeId;

/// A window with the two rays that bound what it sees, in the frame of a half-edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pencil {
    pub window: Window,
    /// From the window's two ends, not normalised.
    pub rays: [[f64; 2]; 2],
}

/// Where two windows meet so that their rays part: what is between is seen from there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joint {
    /// Place on the edge.
    at: f64,
    /// Slopes of the distance on both sides, ascending.
    slopes: [f64; 2],
    distance: f64,
    root: u32,
    error: f32,
}

/// Difference of slopes from which rays part; less is covered by the overlap. Merged windows part more often and
/// farther from where they meet again.
const PARTED: f64 = OVERLAP_REL;
const PARTED_MERGED: f64 = 0.01 * OVERLAP_REL;
/// Widest gap between neighbours, relative to the edge.
const GAP_REL: f64 = 1e-6;

impl Joint {
    /// The joint of two neighbours in a list, if their rays part there.
    pub fn between(l: &Window, r: &Window, length: f64) -> Option<Self> {
        if r.b0 - l.b1 > GAP_REL * length || l.to_canonical() != r.to_canonical() {
            return None;
        }
        let ((dl, ml), (dr, mr)) = (l.at_with_slope(l.b1), r.at_with_slope(r.b0));
        let (at, distance, root) = if dl <= dr { (l.b1, dl, l.root()) } else { (r.b0, dr, r.root()) };
        let error = l.error.max(r.error);
        let parted = if error > 0.0 { PARTED_MERGED } else { PARTED };
        (mr - ml > parted).then_some(Self { at, slopes: [ml, mr], distance, root, error })
    }
}

impl Pencil {
    /// The rays of a window, in its own frame.
    pub fn of(window: Window) -> Self {
        let ([sx, sy], _) = window.source();
        let rays = [window.b0, window.b1].map(|b| if window.is_linear() { [sx, sy] } else { [b - sx, sy] });
        Self { window, rays }
    }

    /// The rays between two windows that part.
    pub fn from_joint(joint: &Joint) -> Self {
        let window = Window::circular([joint.at; 2], [joint.at, 0.0], joint.distance, joint.root);
        let rays = joint.slopes.map(|m| [m, (1.0 - m * m).max(0.0).sqrt()]);
        Self { window: window.with_error(joint.error), rays }
    }

    /// Seen from the other half-edge of an edge of the given length.
    pub fn reversed(self, length: f64) -> Self {
        let [[ax, ay], [bx, by]] = self.rays;
        Self { window: self.window.reversed(length), rays: [[-bx, by], [-ax, ay]] }
    }
}

/// A directed line of a layout as an x axis.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    origin: [f64; 2],
    pub direction: [f64; 2],
    pub length: f64,
}

impl Frame {
    pub fn new(from: [f64; 2], to: [f64; 2], length: f64) -> Self {
        let direction = if length > 0.0 { [0, 1].map(|k| (to[k] - from[k]) / length) } else { [1.0, 0.0] };
        Self { origin: from, direction, length }
    }

    /// A point of the layout in this frame.
    pub fn to(&self, p: [f64; 2]) -> [f64; 2] {
        let [dx, dy] = [p[0] - self.origin[0], p[1] - self.origin[1]];
        let [ux, uy] = self.direction;
        [dx * ux + dy * uy, dy * ux - dx * uy]
    }
}

/// A face laid out over the half-edge through which windows enter it.
pub(crate) struct Crossing {
    pub next: HalfEdgeId,
    pub prev: HalfEdgeId,
    pub apex: Apex,
    /// Direction from the base's target to the apex.
    to_right: [f64; 2],
    /// Direction from the base's origin to the apex.
    to_left: [f64; 2],
    /// How far rays may be from where they are computed, across their direction.
    slack: f64,
}

/// Rounding of three lengths moves the apex by their square over the height, times this.
const APEX_ERROR: f64 = 4.0 * f64::EPSILON;
/// Rays are never widened by more than this, relative to the longest side; what that adds is too short by its square.
const MOST_SLACK_REL: f64 = 1e-7;

impl Crossing {
    pub fn new(surface: &IntrinsicSurface, h: HalfEdgeId) -> Self {
        let (mesh, apex) = (surface.connectivity(), surface.apex(h));
        let unit = |x: f64, y: f64, length: f64| if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] };
        let to_right = unit(apex.x - apex.base, apex.y, apex.right);
        let to_left = unit(apex.x, apex.y, apex.left);
        let longest = apex.base.max(apex.right).max(apex.left);
        let by_rounding = if apex.y > 0.0 { APEX_ERROR * longest * longest / apex.y } else { longest };
        let slack = OVERLAP_REL * longest + by_rounding.min(MOST_SLACK_REL * longest);
        Self { next: mesh.next(h), prev: mesh.prev(h), apex, to_right, to_left, slack }
    }

    /// Propagates a pencil, given in the frame of the base: what arrives on the next and on the previous side.
    ///
    /// Nothing arrives on a side without length. Its ends are saddles, since a face without area leaves the sum of their
    /// angles open, and tell each other their distances when they are reached.
    pub fn cross(&self, pencil: &Pencil, next: &mut Vec<Window>, prev: &mut Vec<Window>) {
        let Apex { base, right, left, x: cx, y: cy } = self.apex;
        let Pencil { window: w, rays: [r0, r1] } = pencil;
        let ([sx, sy], sigma) = w.source();
        let linear = w.is_linear();
        // By how much rays are widened, with what rounding of the source's place can do to them.
        let slack = self.slack + if linear { 0.0 } else { DRIFT_REL * (sx.abs() + sy) };
        let widened = |[rx, ry]: &[f64; 2]| slack * (rx.abs() + ry);
        // 1. On which side of the rays the apex is: positive on the left.
        let side = |b: f64, [rx, ry]: &[f64; 2]| rx * cy - ry * (cx - b);
        let (c_left_of_0, c_left_of_1) = (side(w.b0, r0), side(w.b1, r1));
        // 2. The right side, counted from b.
        if right > 0.0 && c_left_of_1 >= 0.0 {
            let [ux, uy] = self.to_right;
            let meet = |b: f64, [rx, ry]: &[f64; 2], by: f64| ratio(ry * (base - b) + by, rx * uy - ry * ux, right);
            let t0 = meet(w.b1, r1, -widened(r1));
            let t1 = if c_left_of_0 > 0.0 { meet(w.b0, r0, widened(r0)).min(right) } else { right };
            if t1 > t0 {
                let child = if linear {
                    Window::linear([t0, t1], [sx * ux + sy * uy, sx * uy - sy * ux], sigma + sx * base, w.root())
                } else {
                    let (x, y) = ((sx - base) * ux - sy * uy, -sy * ux - (sx - base) * uy);
                    Window::circular([t0, t1], [x, y.max(0.0)], sigma, w.root())
                };
                next.push(child.with_error(w.error));
            }
        }
        // 3. The left side, counted from a, then turned round.
        if left > 0.0 && c_left_of_0 <= 0.0 {
            let [vx, vy] = self.to_left;
            let meet = |b: f64, [rx, ry]: &[f64; 2], by: f64| ratio(ry * b + by, ry * vx - rx * vy, left);
            let t0 = meet(w.b0, r0, -widened(r0));
            let t1 = if c_left_of_1 < 0.0 { meet(w.b1, r1, widened(r1)).min(left) } else { left };
            if t1 > t0 {
                let child = if linear {
                    Window::linear([t0, t1], [sx * vx + sy * vy, sy * vx - sx * vy], sigma, w.root())
                } else {
                    let (x, y) = (sx * vx - sy * vy, sy * vx + sx * vy);
                    Window::circular([t0, t1], [x, y.max(0.0)], sigma, w.root())
                };
                prev.push(child.reversed(left).with_error(w.error));
            }
        }
    }
}

/// A place along a side: `over / under`, its start where `over` is nothing, its end where the ray does not meet it.
fn ratio(over: f64, under: f64, end: f64) -> f64 {
    if over <= 0.0 {
        0.0
    } else if under > 0.0 {
        over / under
    } else {
        end
    }
}
