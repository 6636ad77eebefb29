//! A ribbon graph: vertices with a cyclic order of ports, ports joined in pairs; its faces are the future quads.
//!
//! In: ports, their order around each vertex, their mates. Out: [`Ribbon`], and the orbits of its faces.
//! Holds: contracting an edge between two vertices, and removing an edge that bounds a face of one or two sides, keep
//! the surface that the graph is drawn on. Source: ribbon graphs (rotation systems), textbook; use for folds own.
//!
//! ```text
//!          next(p) │                    the corner of port p lies between p and next(p), left of p;
//!                  │  corner of p       the face left of p goes on with prev(mate(p)), the left turn
//!     prev(p) ─────●═════ p ════▶ mate(p) ●
//! ```

pub(crate) const NONE: u32 = u32::MAX;

/// Rotation system with boundary: the order around a boundary vertex is open at both ends.
pub(crate) struct Ribbon {
    next: Vec<u32>,
    prev: Vec<u32>,
    pub mate: Vec<u32>,
    /// Whether the corner of a port has been cut by the surface's boundary.
    pub open: Vec<bool>,
    /// Whether the corner of a port was another one in the beginning.
    pub changed: Vec<bool>,
    /// Label of a port's edge, kept when parallel edges are joined.
    pub label: Vec<Option<u32>>,
    /// Label of a port's vertex.
    pub vertex: Vec<u32>,
    alive: Vec<bool>,
}

/// A closed walk around a face, as its ports, or the fact that the boundary cuts it.
pub(crate) enum Orbit {
    Closed(Vec<u32>),
    Open,
}

impl Ribbon {
    /// Vertices as consecutive ranges of ports; `surrounded` vertices have a cyclic order.
    pub fn new(first: &[u32], surrounded: &[bool]) -> Self {
        let n = first.last().copied().unwrap_or(0) as usize;
        let mut ribbon = Self {
            next: vec![NONE; n],
            prev: vec![NONE; n],
            mate: vec![NONE; n],
            open: vec![false; n],
            changed: vec![false; n],
            label: vec![None; n],
            vertex: vec![NONE; n],
            alive: vec![true; n],
        };
        for (v, (range, &cyclic)) in first.windows(2).zip(surrounded).enumerate() {
            ribbon.vertex[range[0] as usize..range[1] as usize].fill(v as u32);
            for p in range[0]..range[1] {
                if p + 1 < range[1] {
                    ribbon.link(p, p + 1);
                }
            }
            if cyclic && range[0] < range[1] {
                ribbon.link(range[1] - 1, range[0]);
            }
        }
        ribbon
    }

    /// Number of ports, removed ones included.
    pub fn len(&self) -> usize {
        self.next.len()
    }

    pub fn is_alive(&self, p: u32) -> bool {
        self.alive[p as usize]
    }

    /// Joins two ports to an edge.
    pub fn join(&mut self, p: u32, q: u32, label: Option<u32>) {
        for (a, b) in [(p, q), (q, p)] {
            self.mate[a as usize] = b;
            self.label[a as usize] = label;
        }
    }

    /// The next port clockwise around the same vertex.
    pub fn clockwise(&self, p: u32) -> Option<u32> {
        Some(self.prev[p as usize]).filter(|&q| q != NONE)
    }

    /// The next port counter-clockwise around the same vertex.
    pub fn counter_clockwise(&self, p: u32) -> Option<u32> {
        Some(self.next[p as usize]).filter(|&q| q != NONE)
    }

    /// The port that follows `p` around the face to its left.
    pub fn around_face(&self, p: u32) -> Option<u32> {
        let q = self.mate[p as usize];
        if q == NONE { None } else { self.clockwise(q) }
    }

    fn link(&mut self, p: u32, q: u32) {
        if p != NONE {
            self.next[p as usize] = q;
        }
        if q != NONE {
            self.prev[q as usize] = p;
        }
    }

    /// Takes a port away; the corners beside it become one. `opens`: the surface's boundary lies there.
    pub fn remove_port(&mut self, p: u32, opens: bool) {
        if !self.alive[p as usize] {
            return;
        }
        let (before, after) = (self.prev[p as usize], self.next[p as usize]);
        self.alive[p as usize] = false;
        if before != p {
            self.link(before, after);
            if before != NONE {
                self.open[before as usize] |= opens || self.open[p as usize];
                self.changed[before as usize] = true;
            }
        }
    }

    /// Takes an edge away.
    pub fn remove_edge(&mut self, p: u32, opens: bool) {
        self.remove_port(self.mate[p as usize], opens);
        self.remove_port(p, opens);
    }

    /// Draws edges inside a face; `diagonals` are pairs of places in the list of the face's ports, none crossing another.
    pub fn add_diagonals(&mut self, face: &[u32], diagonals: &[[usize; 2]]) {
        let n = face.len();
        let first = self.len() as u32;
        // Both ends of every diagonal: where, and how far around the face the other end is.
        let mut ends: Vec<(usize, usize, u32)> = Vec::new();
        for (k, &[i, j]) in diagonals.iter().enumerate() {
            let p = first + 2 * k as u32;
            for (at, to, port) in [(i, j, p), (j, i, p + 1)] {
                ends.push((at, (to + n - at) % n, port));
                self.vertex.push(self.vertex[face[at] as usize]);
                self.mate.push(NONE);
            }
        }
        for _ in 0..2 * diagonals.len() {
            self.next.push(NONE);
            self.prev.push(NONE);
            self.open.push(false);
            self.changed.push(true);
            self.label.push(None);
            self.alive.push(true);
        }
        for k in 0..diagonals.len() as u32 {
            self.join(first + 2 * k, first + 2 * k + 1, None);
        }
        // From a corner's port counter-clockwise, nearer ends come first.
        ends.sort_unstable();
        for group in ends.chunk_by(|a, b| a.0 == b.0) {
            let mut last = face[group[0].0];
            let after = self.next[last as usize];
            self.changed[last as usize] = true;
            for &(_, _, port) in group {
                self.link(last, port);
                last = port;
            }
            self.link(last, after);
        }
    }

    /// Contracts an edge between two different vertices: their orders are spliced where the edge was.
    ///
    /// Returns false, and changes nothing, where both vertices lie on the boundary and the result would pinch it.
    pub fn contract(&mut self, p: u32) -> bool {
        let q = self.mate[p as usize];
        let ends = |p: u32| (self.prev[p as usize], self.next[p as usize]);
        let ((before_p, after_p), (before_q, after_q)) = (ends(p), ends(q));
        if self.is_boundary(p) && self.is_boundary(q) {
            let aligned = (after_p == NONE && before_q == NONE) || (before_p == NONE && after_q == NONE);
            if !aligned {
                return false;
            }
        }
        match (before_p == p, before_q == q) {
            (true, true) => {}
            (true, false) => self.link(before_q, after_q),
            (false, true) => self.link(before_p, after_p),
            (false, false) => {
                self.link(before_p, after_q);
                self.link(before_q, after_p);
            }
        }
        for (before, corner) in [(before_p, q), (before_q, p)] {
            if before != NONE {
                self.open[before as usize] |= self.open[corner as usize];
            }
        }
        self.alive[p as usize] = false;
        self.alive[q as usize] = false;
        true
    }

    fn is_boundary(&self, p: u32) -> bool {
        let mut q = p;
        loop {
            q = self.next[q as usize];
            if q == NONE {
                return true;
            }
            if q == p {
                return false;
            }
        }
    }

    /// Removes edges that bound a face of one side, among the given ports and what they uncover.
    pub fn remove_monogons(&mut self, mut candidates: Vec<u32>) {
        while let Some(p) = candidates.pop() {
            if !self.alive[p as usize] || self.mate[p as usize] == NONE {
                continue;
            }
            let q = self.mate[p as usize];
            let around = [self.prev[p as usize], self.next[p as usize], self.prev[q as usize], self.next[q as usize]];
            if self.next[p as usize] == q || self.next[q as usize] == p {
                self.remove_edge(p, false);
                candidates.extend(around.into_iter().filter(|&r| r != NONE && r != p && r != q));
            }
        }
    }

    /// Joins parallel edges that bound a face of two sides; returns how many.
    fn remove_digons(&mut self) -> usize {
        let mut removed = 0;
        for p in 0..self.len() as u32 {
            while self.alive[p as usize] {
                let Some(q) = self.around_face(p) else { break };
                if q == p || q == self.mate[p as usize] || self.around_face(q) != Some(p) {
                    break;
                }
                if self.open[p as usize] || self.open[q as usize] {
                    break;
                }
                let kept = self.mate[p as usize];
                let label = self.label[p as usize].or(self.label[q as usize]);
                self.remove_edge(q, false);
                self.label[p as usize] = label;
                self.label[kept as usize] = label;
                removed += 1;
            }
        }
        removed
    }

    /// Removes edges with a dead end, and what they leave as dead ends; returns how many.
    fn remove_dead_ends(&mut self) -> usize {
        let mut removed = 0;
        for start in 0..self.len() as u32 {
            let mut p = start;
            while self.alive[p as usize] && self.mate[p as usize] != NONE {
                let (before, after) = (self.prev[p as usize], self.next[p as usize]);
                let alone = (before == p || before == NONE) && (after == p || after == NONE);
                if !alone {
                    break;
                }
                let q = self.mate[p as usize];
                let opens = self.open[p as usize] || before == NONE;
                let follow = if self.next[q as usize] != NONE { self.next[q as usize] } else { self.prev[q as usize] };
                self.remove_edge(p, opens);
                removed += 1;
                if follow == NONE || follow == q {
                    break;
                }
                p = follow;
            }
        }
        removed
    }

    /// Removes dead ends, digons and doublets until there are none; returns how many edges and vertices went.
    ///
    /// `is_tip`: whether a vertex stays if labelled edges meet there.
    pub fn simplify(&mut self, is_tip: impl Fn(u32) -> bool) -> usize {
        let mut removed = 0;
        loop {
            let more = self.remove_dead_ends() + self.remove_digons() + self.remove_doublets(&is_tip);
            if more == 0 {
                return removed;
            }
            removed += more;
        }
    }

    /// Removes vertices of two quads, except tips of labelled edges: the two quads become one; returns how many.
    ///
    /// Flattened out, one of the two quads has an angle of at least 180 degrees.
    fn remove_doublets(&mut self, is_tip: impl Fn(u32) -> bool) -> usize {
        let mut removed = 0;
        let mut candidates: Vec<u32> = (0..self.len() as u32).collect();
        while let Some(p) = candidates.pop() {
            if !self.alive[p as usize] || self.mate[p as usize] == NONE {
                continue;
            }
            let q = self.next[p as usize];
            if q == NONE || q == p || self.next[q as usize] != p || self.mate[q as usize] == NONE {
                continue;
            }
            let labelled = self.label[p as usize].or(self.label[q as usize]).is_some();
            let between_quads = [p, q].iter().all(|&r| self.sides_left_of(r) == Some(4));
            if !between_quads || self.mate[p as usize] == q || (labelled && is_tip(self.vertex[p as usize])) {
                continue;
            }
            let beyond = [p, q].map(|r| self.next[self.mate[r as usize] as usize]);
            self.remove_edge(p, false);
            self.remove_edge(q, false);
            candidates.extend(beyond.into_iter().filter(|&r| r != NONE));
            removed += 1;
        }
        removed
    }

    /// Number of sides of the face left of a port if it is closed and has at most four.
    fn sides_left_of(&self, p: u32) -> Option<usize> {
        let mut q = p;
        for n in 1..=4 {
            if self.open[q as usize] {
                return None;
            }
            q = self.around_face(q)?;
            if q == p {
                return Some(n);
            }
        }
        None
    }

    /// Orbits of all faces, by their smallest port, from which each starts.
    pub fn orbits(&self) -> Vec<Orbit> {
        let mut seen = vec![false; self.len()];
        let mut orbits = Vec::new();
        for start in 0..self.len() as u32 {
            if seen[start as usize] || !self.alive[start as usize] {
                continue;
            }
            let (mut ports, mut open, mut p) = (Vec::with_capacity(4), false, start);
            loop {
                seen[p as usize] = true;
                ports.push(p);
                open |= self.open[p as usize];
                match self.around_face(p) {
                    Some(q) if q == start => break,
                    Some(q) if !seen[q as usize] => p = q,
                    // The walk left the surface, or ran into one that did.
                    _ => {
                        open = true;
                        break;
                    }
                }
            }
            orbits.push(if open { Orbit::Open } else { Orbit::Closed(ports) });
        }
        orbits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sides(ribbon: &Ribbon) -> Vec<usize> {
        let closed = ribbon.orbits().into_iter().map(|o| match o {
            Orbit::Closed(p) => p.len(),
            Orbit::Open => 0,
        });
        let mut list: Vec<usize> = closed.collect();
        list.sort_unstable();
        list
    }

    /// A pleat: one grid point with three preimages, the middle one mirrored, is one point with four ports.
    #[test]
    fn pleat_contracts_to_a_regular_point() {
        // Ports 0..4 of the first, 4..8 of the mirrored one (order 0, 3, 2, 1), 8..12 of the third.
        let mut ribbon = Ribbon::new(&[0, 4, 8, 12], &[true; 3]);
        let mirrored = |d: u32| 4 + (4 - d) % 4;
        for (p, q) in [(0, mirrored(0)), (1, mirrored(1)), (mirrored(2), 8 + 2), (mirrored(3), 8 + 3)] {
            ribbon.join(p, q, None);
        }
        assert!(ribbon.contract(0) && ribbon.contract(mirrored(2)));
        ribbon.remove_monogons(vec![1, mirrored(3)]);
        let alive: Vec<u32> = (0..12).filter(|&p| ribbon.is_alive(p)).collect();
        assert_eq!(alive, [2, 3, 8, 9]);
        let mut around = vec![2];
        while let Some(q) = ribbon.counter_clockwise(*around.last().unwrap()).filter(|&q| q != 2) {
            around.push(q);
        }
        assert_eq!(around, [2, 3, 8, 9], "directions 2, 3 of the first, then 0, 1 of the third");
    }

    /// The theta graph on a sphere has three digons; joining them leaves one edge.
    #[test]
    fn digons_join() {
        let mut ribbon = Ribbon::new(&[0, 3, 6], &[true; 2]);
        for k in 0..3 {
            ribbon.join(k, 3 + (3 - k) % 3, Some(k).filter(|&k| k == 1));
        }
        assert_eq!(sides(&ribbon), [2, 2, 2]);
        assert_eq!(ribbon.remove_digons(), 2);
        assert_eq!(sides(&ribbon), [2]);
        let p = (0..6).find(|&p| ribbon.is_alive(p)).unwrap();
        assert_eq!(ribbon.label[p as usize], Some(1), "the label survives");
    }

    /// Two quads 0-1-2-3 and 0-3-2-4 that share the vertex 3 of valence two are the quad 0-1-2-4.
    #[test]
    fn doublet_becomes_one_quad() {
        // Vertex 0: to 1, 3, 4; vertex 1: to 2, 0; vertex 2: to 4, 3, 1; vertex 3: to 0, 2; vertex 4: to 0, 2.
        let build = || {
            let mut ribbon = Ribbon::new(&[0, 3, 5, 8, 10, 12], &[true; 5]);
            // The outline is labelled, so that its vertices of valence two can be kept.
            for (p, q, label) in [(0, 4, Some(1)), (1, 8, None), (2, 10, Some(1))] {
                ribbon.join(p, q, label);
            }
            for (p, q, label) in [(3, 7, Some(1)), (6, 9, None), (5, 11, Some(1))] {
                ribbon.join(p, q, label);
            }
            ribbon
        };
        let mut ribbon = build();
        assert_eq!(sides(&ribbon), [4, 4, 4], "two quads and the outside");
        assert_eq!(ribbon.remove_doublets(|_| true), 1);
        assert_eq!(sides(&ribbon), [4, 4]);
        let mut ribbon = build();
        ribbon.label[8] = Some(0);
        assert_eq!(ribbon.remove_doublets(|_| true), 0, "tips of features stay");
        assert_eq!(ribbon.remove_doublets(|v| v != 3), 1);
    }

    /// Polygons on a sphere, cut on one side.
    #[test]
    fn diagonals_cut_a_face() {
        // Vertex k has the ports 2k (ahead) and 2k + 1 (back).
        let mut ribbon = Ribbon::new(&[0, 2, 4, 6, 8, 10, 12], &[true; 6]);
        for k in 0..6 {
            ribbon.join(2 * k, (2 * k + 3) % 12, None);
        }
        assert_eq!(sides(&ribbon), [6, 6]);
        ribbon.add_diagonals(&[0, 2, 4, 6, 8, 10], &[[0, 3]]);
        assert_eq!(sides(&ribbon), [4, 4, 6]);
        assert_eq!((ribbon.vertex[12], ribbon.vertex[13]), (0, 3));
        // A fan of diagonals from one corner keeps their order.
        let mut ribbon = Ribbon::new(&[0, 2, 4, 6, 8, 10, 12, 14, 16], &[true; 8]);
        for k in 0..8 {
            ribbon.join(2 * k, (2 * k + 3) % 16, None);
        }
        ribbon.add_diagonals(&[0, 2, 4, 6, 8, 10, 12, 14], &[[5, 0], [0, 3]]);
        assert_eq!(sides(&ribbon), [4, 4, 4, 8]);
    }

    #[test]
    fn dead_ends_go() {
        // A square 0-1-2-3 with a path 0-4-5 inside.
        let mut ribbon = Ribbon::new(&[0, 3, 5, 7, 9, 11, 12], &[true; 6]);
        for (p, q) in [(0, 4), (3, 6), (5, 8), (7, 2), (1, 9), (10, 11)] {
            ribbon.join(p, q, None);
        }
        assert_eq!(sides(&ribbon), [4, 8]);
        assert_eq!(ribbon.remove_dead_ends(), 2);
        assert_eq!(sides(&ribbon), [4, 4]);
    }
}
