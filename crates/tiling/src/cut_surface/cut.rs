//! Cutting along a walk ([Favreau2009] §3.2.2, Figure 8), and healing cuts.
//!
//! In: half-edges inside C, one after the other. Out: C cut there; the surjection π from the new cell to the old is the
//! identity on faces, and both vertices of an inner point of the walk go to the vertex that it had.
//! Holds: faces and half-edges keep their ids; a walk's inner point gets two vertices, an end on the border one more.

use super::{CutSurface, Lost, NONE, Walk};
use std::collections::BTreeSet;

impl CutSurface<'_> {
    /// Pulls a walk off the border and cuts along it.
    ///
    /// # Output     points of the cut, from its start to its end
    pub fn cut_walk(&mut self, walk: &Walk) -> Result<Vec<u32>, Lost> {
        let path = self.pull_off(walk)?;
        let mut points: Vec<u32> = path.iter().map(|&h| self.point[self.origin[h as usize] as usize]).collect();
        if let Some(&h) = path.last() {
            points.push(self.point[self.target(h) as usize]);
        }
        self.cut(&path)?;
        Ok(points)
    }

    /// Cuts along half-edges inside C.
    pub fn cut(&mut self, path: &[u32]) -> Result<(), Lost> {
        let vertices: BTreeSet<u32> = path.iter().flat_map(|&h| [self.origin[h as usize], self.target(h)]).collect();
        let fans: Vec<(u32, Vec<u32>)> = vertices.into_iter().map(|v| (v, self.fan(v))).collect();
        for &h in path {
            let t = self.twin[h as usize];
            if t == NONE {
                return Err(Lost("a cut runs along the border"));
            }
            for (a, b) in [(h, t), (t, h)] {
                self.mate[a as usize] = b;
                self.twin[a as usize] = NONE;
            }
        }
        for (v, fan) in fans {
            self.part(&[v], &fan);
        }
        Ok(())
    }

    /// Closes cuts again along half-edges of the border.
    pub fn heal(&mut self, cut: &[u32]) {
        // All vertices of the points, with all half-edges that leave them.
        let mut at: std::collections::BTreeMap<u32, (BTreeSet<u32>, Vec<u32>)> = Default::default();
        let both = cut.iter().flat_map(|&h| [h, self.mate[h as usize]]);
        for v in both.flat_map(|h| [self.origin[h as usize], self.target(h)]) {
            let (vertices, fan) = at.entry(self.point[v as usize]).or_default();
            if vertices.insert(v) {
                fan.extend(self.fan(v));
            }
        }
        for &h in cut {
            let t = self.mate[h as usize];
            for (a, b) in [(h, t), (t, h)] {
                self.twin[a as usize] = b;
                self.mate[a as usize] = NONE;
            }
        }
        for (vertices, fan) in at.into_values() {
            let vertices: Vec<u32> = vertices.into_iter().collect();
            self.part(&vertices, &fan);
        }
    }

    /// Gives every sector of the half-edges that leave a point one vertex: the given ones first, then new ones.
    fn part(&mut self, vertices: &[u32], fan: &[u32]) {
        let mut starts: Vec<u32> = fan.iter().copied().filter(|&h| self.twin[h as usize] == NONE).collect();
        if starts.is_empty() {
            starts.push(fan[0]);
        }
        for (k, &start) in starts.iter().enumerate() {
            let first = vertices[0];
            let vertex = match vertices.get(k) {
                Some(&v) => v,
                None => self.new_vertex(self.point[first as usize], self.home[first as usize], start),
            };
            self.out[vertex as usize] = start;
            for h in self.fan(vertex) {
                self.origin[h as usize] = vertex;
            }
        }
        // What healing leaves over has no half-edge.
        for &v in vertices.iter().skip(starts.len()) {
            self.out[v as usize] = NONE;
        }
    }
}
