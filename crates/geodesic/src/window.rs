//! Windows: pieces of edges over which the distance is that to one point or to one straight front.
//!
//! In: numbers in the frame of an edge: origin at the origin of its canonical half-edge, x along it. Out: distances.
//! Holds: a window is an interval `b0..=b1` of its edge and a function over it, circular
//! `σ + √((x − s_x)² + s_y²)` [Bommes2012] §9, Eq. (9.1), or linear `σ + m·x`.
//! All lengths are scaled ([`crate::surface`]).

/// By how much a window is extended beyond where its rays end, relative to the edge.
///
/// Neighbouring windows then overlap by more than rounding can part them. What the extension adds is measured along a
/// line that cuts a corner by this much, so that the distance there is too short by its square only, 1e-20.
pub(crate) const OVERLAP_REL: f64 = 1e-10;
/// The same relative to the distance of the source, whose place is rounded at every step.
pub(crate) const DRIFT_REL: f64 = 1e-13;
/// Pieces of edges shorter than this, relative to the edge, go to their neighbours.
pub(crate) const NARROW_REL: f64 = 1e-12;
/// Distances that differ by less, relative to themselves, are equal: the one that came first stays.
pub(crate) const TIE_REL: f64 = 1e-14;

const LINEAR: u32 = 1 << 31;
const TO_CANONICAL: u32 = 1 << 30;
const PENDING: u32 = 1 << 29;
/// Largest number of roots (vertices and sources).
pub(crate) const MAX_ROOTS: usize = (PENDING - 1) as usize;

/// A window on an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    pub b0: f64,
    pub b1: f64,
    /// Circular: x of the unfolded source. Linear: the slope m.
    sx: f64,
    /// Circular: distance of the source from the edge's line. Linear: √(1 − m²), the share of the front's speed that
    /// crosses the edge.
    sy: f64,
    /// Circular: distance of the source from where its path began. Linear: distance at the edge's origin.
    sigma: f64,
    /// Root id and three flags.
    tag: u32,
    /// Bound on how far the distance is from that of the paths it stands for; zero unless windows were merged.
    pub error: f32,
}

impl Window {
    /// A window from a point at `(sx, ±sy)` whose own distance is `sigma`.
    pub fn circular(interval: [f64; 2], [sx, sy]: [f64; 2], sigma: f64, root: u32) -> Self {
        Self { b0: interval[0], b1: interval[1], sx, sy: sy.abs(), sigma, tag: root, error: 0.0 }
    }

    /// A window of a straight front: distance `sigma` at x = 0, growing by `slope` per length along the edge and by
    /// `across` per length perpendicular to it.
    pub fn linear(interval: [f64; 2], [slope, across]: [f64; 2], sigma: f64, root: u32) -> Self {
        Self { b0: interval[0], b1: interval[1], sx: slope, sy: across.abs(), sigma, tag: root | LINEAR, error: 0.0 }
    }

    pub fn is_linear(&self) -> bool {
        self.tag & LINEAR != 0
    }
    /// Whether the front moves into the face of the canonical half-edge.
    pub fn to_canonical(self) -> bool {
        self.tag & TO_CANONICAL != 0
    }
    /// Whether it has yet to be propagated.
    pub fn is_pending(&self) -> bool {
        self.tag & PENDING != 0
    }
    /// The vertex or source from which it comes.
    pub fn root(&self) -> u32 {
        self.tag & MAX_ROOTS as u32
    }
    pub fn set_pending(&mut self, pending: bool) {
        self.tag = if pending { self.tag | PENDING } else { self.tag & !PENDING };
    }
    /// Circular: the source's place and own distance. Linear: slope, share across, distance at x = 0.
    pub fn source(&self) -> ([f64; 2], f64) {
        ([self.sx, self.sy], self.sigma)
    }
    pub fn with_direction(mut self, to_canonical: bool) -> Self {
        self.tag = if to_canonical { self.tag | TO_CANONICAL } else { self.tag & !TO_CANONICAL };
        self
    }
    pub fn pending(mut self) -> Self {
        self.tag |= PENDING;
        self
    }
    pub fn with_error(mut self, error: f32) -> Self {
        self.error = error;
        self
    }
    /// Same root, kind and direction with another function.
    pub fn replaced(mut self, [b0, b1]: [f64; 2], [sx, sy]: [f64; 2], sigma: f64) -> Self {
        (self.b0, self.b1, self.sx, self.sy, self.sigma) = (b0, b1, sx, sy, sigma);
        self
    }
    /// Same source and direction over another interval.
    pub fn over(mut self, b0: f64, b1: f64) -> Self {
        (self.b0, self.b1) = (b0, b1);
        self
    }

    /// Distance at `x`.
    #[inline]
    pub fn at(&self, x: f64) -> f64 {
        if self.is_linear() {
            self.sigma + self.sx * x
        } else {
            let dx = x - self.sx;
            self.sigma + (dx * dx + self.sy * self.sy).sqrt()
        }
    }

    /// Distance and its derivative along the edge at `x`.
    #[inline]
    pub fn at_with_slope(&self, x: f64) -> (f64, f64) {
        if self.is_linear() {
            return (self.sigma + self.sx * x, self.sx);
        }
        let dx = x - self.sx;
        let r = (dx * dx + self.sy * self.sy).sqrt();
        (self.sigma + r, if r > 0.0 { dx / r } else { 0.0 })
    }

    /// Least distance over the interval.
    #[inline]
    pub fn least(&self) -> f64 {
        if self.is_linear() { self.at(self.b0).min(self.at(self.b1)) } else { self.at(self.sx.clamp(self.b0, self.b1)) }
    }

    /// The same window with x counted from a place.
    pub fn shifted(mut self, from: f64) -> Self {
        (self.b0, self.b1) = (self.b0 - from, self.b1 - from);
        if self.is_linear() {
            self.sigma += self.sx * from;
        } else {
            self.sx -= from;
        }
        self
    }

    /// The same window seen from the other half-edge of an edge of the given length.
    #[inline]
    pub fn reversed(mut self, length: f64) -> Self {
        (self.b0, self.b1) = (length - self.b1, length - self.b0);
        if self.is_linear() {
            self.sigma += self.sx * length;
            self.sx = -self.sx;
        } else {
            self.sx = length - self.sx;
        }
        self
    }

    /// Where the distance grows with a slope below 1 along the edge: `q = s_x + a·|s_y|/√(1 − a²)`, where the
    /// difference to a straight line of that slope has its extremum ([Bommes2012] §9 prints another sign).
    ///
    /// Not finite where there is none.
    pub fn has_slope_at(&self, slope: f64) -> f64 {
        if self.is_linear() { f64::NAN } else { self.sx + slope * self.sy / (1.0 - slope * slope).sqrt() }
    }

    /// Where the slopes of two windows are equal: the only place where their difference has an extremum.
    ///
    /// Not finite where there is none.
    #[inline]
    pub fn parallel_at(&self, other: &Self) -> f64 {
        match (self.is_linear(), other.is_linear()) {
            // Equal cotangents of the directions.
            (false, false) => (self.sx * other.sy - other.sx * self.sy) / (other.sy - self.sy),
            (false, true) => self.sx + self.sy * other.sx / other.sy,
            (true, false) => other.sx + other.sy * self.sx / self.sy,
            (true, true) => f64::NAN,
        }
    }
}
