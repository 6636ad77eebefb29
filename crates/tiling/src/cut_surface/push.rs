//! Unsticking: a walk that touches the border of C is pulled off it ([Favreau2009] §4.2, Figures 13 and 14).
//!
//! In: a walk in C whose inner vertices are distinct. Out: a walk beside it whose inner vertices lie inside C.
//! Holds: it is homotopic to the given one and costs the same; only edges at touched vertices are split.
//!
//! ```text
//!        z1   z2              around a touched vertex v the walk crosses the edges on its free side:
//!         \  /
//!   x ──── v ──── y           x ─ p1 ─ p2 ─ y,   p on the edges v–z
//!    ══════╧══════
//! ```

use super::{CutSurface, Lost, Walk};

/// Where the pulled walk runs, seen along the given one.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lane {
    /// Through the vertex.
    On,
    Left,
    Right,
}

/// How one point of the pulled walk is reached from the last.
#[derive(Clone, Copy)]
enum Link {
    /// Along this edge.
    Edge(u32),
    /// Through the face of this half-edge.
    Face(u32),
}

/// A touched vertex: the side of the walk, and the half-edges to be crossed, in the walk's order.
struct Touch {
    lane: Lane,
    crossed: Vec<u32>,
}

impl CutSurface<'_> {
    /// Pulls a walk off the border; its ends stay, but for a loop that begins on the border: it is pulled off there too.
    ///
    /// # Output     half-edges inside C from its start to its end
    pub fn pull_off(&mut self, walk: &Walk) -> Result<Vec<u32>, Lost> {
        let last = walk.edges.len();
        // 1. On which side the surface is, wherever the walk touches the border.
        let is_loop = walk.vertices[0] == walk.vertices[last] && self.on_border(walk.vertices[0]);
        let mut touches: Vec<Touch> = (0..last)
            .map(|i| {
                let touched = (i > 0 || is_loop) && self.on_border(walk.vertices[i]);
                if touched { self.touch(walk, i) } else { Ok(Touch { lane: Lane::On, crossed: Vec::new() }) }
            })
            .collect::<Result<_, _>>()?;
        touches.push(Touch { lane: if is_loop { touches[0].lane } else { Lane::On }, crossed: Vec::new() });
        // 2. Points on the edges to be crossed, and how they are reached.
        let mut steps: Vec<(Link, u32)> = Vec::new();
        let mut link = Link::Edge(u32::MAX);
        for (i, touch) in touches.iter().enumerate() {
            let v = walk.vertices[i];
            if touch.lane == Lane::On {
                steps.push((link, v));
            }
            for (k, &h) in touch.crossed.iter().enumerate() {
                if k > 0 {
                    // The face between two crossed edges is left of the clockwise one.
                    link = Link::Face(if touch.lane == Lane::Left { h } else { touch.crossed[k - 1] });
                }
                let base = self.base_of(v);
                steps.push((link, self.split_edge(h, base, v)));
            }
            if i == last {
                break;
            }
            let (a, b) = (touch.lane, touches[i + 1].lane);
            let edge = walk.edges[i];
            let side = |lane: Lane| {
                let from = if lane == Lane::Left { v } else { walk.vertices[i + 1] };
                self.leaving(edge, from).map(Link::Face).ok_or(Lost("a walk beside a border leaves the surface"))
            };
            link = match (a, b) {
                (Lane::On, Lane::On) => Link::Edge(edge),
                (Lane::On, lane) | (lane, Lane::On) => side(lane)?,
                (a, b) if a == b => side(a)?,
                (a, b) => {
                    let (first, second) = (side(a)?, side(b)?);
                    let h = self.leaving(edge, v).ok_or(Lost("a walk crosses a border"))?;
                    let base = self.base_of(v);
                    steps.push((first, self.split_edge(h, base, v)));
                    second
                }
            };
        }
        if is_loop {
            let first = steps.first().ok_or(Lost("a loop has no room beside the border"))?.1;
            steps.push((link, first));
        }
        // 3. Chords between them.
        let mut pulled = Vec::with_capacity(steps.len());
        for pair in steps.windows(2) {
            let (from, (link, to)) = (pair[0].1, pair[1]);
            match link {
                Link::Edge(h) if !self.is_border(h) => {
                    pulled.push(self.leaving(h, from).ok_or(Lost("a walk's edge is not at its vertex"))?);
                }
                Link::Edge(h) | Link::Face(h) => {
                    let face = self.face[h as usize];
                    pulled.extend(self.cross_face(face, from, to)?);
                }
            }
        }
        Ok(pulled)
    }

    /// How the walk passes its touched vertex `i`.
    fn touch(&self, walk: &Walk, i: usize) -> Result<Touch, Lost> {
        let v = walk.vertices[i];
        let fan = self.fan(v);
        // Index counter-clockwise from the border; the edge that arrives along the border comes last.
        let index = |edge: u32| {
            let found = fan.iter().position(|&h| h == edge || self.twin[h as usize] == edge);
            let arriving = self.prev[fan[fan.len() - 1] as usize];
            found.or((edge == arriving).then_some(fan.len())).ok_or(Lost("a walk's edge is not at its vertex"))
        };
        let before = if i == 0 { walk.edges.len() - 1 } else { i - 1 };
        let (from, to) = (index(walk.edges[before])?, index(walk.edges[i])?);
        Ok(if to < from {
            Touch { lane: Lane::Left, crossed: fan[to + 1..from].iter().rev().copied().collect() }
        } else {
            Touch { lane: Lane::Right, crossed: fan[from + 1..to].to_vec() }
        })
    }
}
