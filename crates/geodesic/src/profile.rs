//! The distance along a segment within a face, as windows.
//!
//! In: a field, a segment of a face's layout. Out: windows over it, in its own frame, each with its source. Holds: they
//! cover the segment wherever a source reaches the face; nothing is recomputed, since what arrives in a face is known
//! from the windows on its sides, its corners and the sources in it.
//! Source: [Bommes2012] §9, adaptive refinement ("no re-computation of the geodesic field is necessary").

use crate::crossing::{Frame, Joint, Pencil};
use crate::field::Field;
use crate::insert::{Pieces, insert};
use crate::sources::Root;
use crate::window::{DRIFT_REL, OVERLAP_REL, Window};
use quadloom_mesh::FaceId;

impl Field<'_> {
    /// The windows along a segment `p..q` of a face's layout, scaled.
    ///
    /// # Cost       linear in the windows of the face
    pub(crate) fn along(&self, face: FaceId, p: [f64; 2], q: [f64; 2]) -> Vec<Window> {
        let wave = self.wave;
        let mesh = wave.surface.connectivity();
        let layout = wave.surface.layout(face);
        let segment = Frame::new(p, q, (q[0] - p[0]).hypot(q[1] - p[1]));
        let length = segment.length;
        let (mut list, mut pieces) = (Vec::new(), Pieces::default());
        let mut offer = |window: Window| {
            if window.b1 > window.b0 {
                insert(&mut list, &mut pieces, length, window);
            }
        };
        // 1. Corners, and sources in the face.
        for (k, v) in mesh.face_vertices(face).into_iter().enumerate() {
            if wave.distance[v].is_finite() {
                offer(Window::circular([0.0, length], segment.to(layout[k]), wave.distance[v], v.0));
            }
        }
        let vertices = mesh.vertex_count() as u32;
        for &k in wave.roots_of(face) {
            let (root, start, _) = wave.sources.roots[k as usize];
            match root {
                Root::Point(p) => {
                    if let Some(at) = wave.place_in(face, &p) {
                        offer(Window::circular([0.0, length], segment.to(at), start, vertices + k));
                    }
                }
                Root::Segment(p, q) => {
                    if let Some((p, q)) = wave.place_in(face, &p).zip(wave.place_in(face, &q)) {
                        fronts(&segment, p, q, start, vertices + k).into_iter().flatten().for_each(&mut offer);
                    }
                }
            }
        }
        // 2. What comes through its sides.
        for (k, h) in mesh.face_half_edges(face).into_iter().enumerate() {
            let e = mesh.edge(h);
            let (width, canonical) = (wave.surface.length(e), mesh.half_edge(e) == h);
            if width <= 0.0 {
                continue;
            }
            let side = Frame::new(layout[k], layout[(k + 1) % 3], width);
            let (from, to) = (side.to(p), side.to(q));
            let windows = wave.lists.of(e);
            for (i, w) in windows.iter().enumerate().filter(|(_, w)| w.to_canonical() == canonical) {
                let joint = i.checked_sub(1).and_then(|j| Joint::between(&windows[j], w, width));
                for pencil in joint.iter().map(Pencil::from_joint).chain([Pencil::of(*w)]) {
                    let pencil = if canonical { pencil } else { pencil.reversed(width) };
                    if let Some(window) = seen_on(&pencil, width, [from, to], length) {
                        offer(window);
                    }
                }
            }
        }
        list
    }
}

/// By how much what a window shows inside a face is extended, relative to the window's edge: between two windows that
/// enter the face there may be one that leaves it and is no wider than their overlap. What the extension adds is
/// too short by its square only.
const PROFILE_OVERLAP_REL: f64 = 10.0 * OVERLAP_REL;

/// What a pencil shows of a segment `p..q` on the far side of its edge, all in the frame of the edge of length `width`.
fn seen_on(pencil: &Pencil, width: f64, [p, q]: [[f64; 2]; 2], length: f64) -> Option<Window> {
    let Pencil { window: w, rays } = pencil;
    let ([sx, sy], sigma) = w.source();
    let d = [0, 1].map(|k| (q[k] - p[k]) / length);
    // 1. Between the rays: right of the first, left of the second, and a little more.
    let slack = PROFILE_OVERLAP_REL * width + if w.is_linear() { 0.0 } else { DRIFT_REL * (sx.abs() + sy) };
    let [mut lo, mut hi] = [0.0, length];
    for (b, [rx, ry], sign) in [(w.b0, rays[0], -1.0), (w.b1, rays[1], 1.0)] {
        let size = rx.hypot(ry);
        if size <= 0.0 {
            // The source is the window's end itself: it sees everything.
            continue;
        }
        // Distance from the ray at x: start + x·growth, which must not be below -slack.
        let start = sign * (rx * p[1] - ry * (p[0] - b)) / size + slack;
        let growth = sign * (rx * d[1] - ry * d[0]) / size;
        if growth > 0.0 {
            lo = lo.max(-start / growth);
        } else if growth < 0.0 {
            hi = hi.min(-start / growth);
        } else if start < 0.0 {
            return None;
        }
    }
    if lo.is_nan() || hi <= lo {
        return None;
    }
    // 2. The same function in the segment's frame.
    Some(if w.is_linear() {
        let slope = (sx * d[0] + sy * d[1], sx * d[1] - sy * d[0]);
        Window::linear([lo, hi], [slope.0, slope.1], sigma + sx * p[0] + sy * p[1], w.root())
    } else {
        let s = [sx - p[0], -sy - p[1]];
        Window::circular([lo, hi], [s[0] * d[0] + s[1] * d[1], s[1] * d[0] - s[0] * d[1]], sigma, w.root())
    })
}

/// The two fronts of a segment `p..q` on a line of its face ([Bommes2012] §9, Figure 9.6 a), in the frame of that line.
///
/// They are widened by a share of their distance: beside an end of the segment that lies on the line itself, a longer
/// front would be too short by as much as it is longer.
pub(crate) fn fronts(frame: &Frame, p: [f64; 2], q: [f64; 2], start: f64, root: u32) -> [Option<Window>; 2] {
    let ([px, py], [qx, qy]) = (frame.to(p), frame.to(q));
    let length = (qx - px).hypot(qy - py);
    if length <= 0.0 || frame.length <= 0.0 {
        return [None; 2];
    }
    let (dx, dy) = ((qx - px) / length, (qy - py) / length);
    // 1. Where the foot of (x, 0) on the segment is between its ends: 0 ≤ (x − px)·dx − py·dy ≤ length.
    let [mut lo, mut hi] = [0.0, frame.length];
    if dx == 0.0 {
        if !(0.0..=length).contains(&(-py * dy)) {
            return [None; 2];
        }
    } else {
        let ends = [px + py * dy / dx, px + (length + py * dy) / dx];
        lo = ends[0].min(ends[1]).max(lo);
        hi = ends[0].max(ends[1]).min(hi);
    }
    if hi <= lo {
        return [None; 2];
    }
    // 2. On the left of the segment, and on its right: distance ±((y − py)·dx − (x − px)·dy), up to where it is zero.
    [1.0, -1.0].map(|sign| {
        let (slope, at_origin) = (-sign * dy, sign * (px * dy - py * dx));
        let (mut from, mut to) = (lo, hi);
        if slope > 0.0 {
            from = from.max(-at_origin / slope);
        } else if slope < 0.0 {
            to = to.min(-at_origin / slope);
        } else if at_origin < 0.0 {
            return None;
        }
        // Where the front ends at a foot, and not where its distance is zero.
        let widened = |x: f64| OVERLAP_REL * (at_origin + slope * x).clamp(0.0, frame.length);
        let interval = [(from - widened(from)).max(0.0), (to + widened(to)).min(frame.length)];
        (to > from).then(|| Window::linear(interval, [slope, dx], start + at_origin, root))
    })
}
