//! Splitting edges and faces of a cut surface.
//!
//! In: half-edges. Out: new points, chords and centres. Holds: the surface stays the same point set, faces stay convex;
//! half-edges that leave a vertex keep leaving it.

use super::{CutSurface, Lost, NONE, Place};

impl CutSurface<'_> {
    fn new_point(&mut self, base: u32, place: Place) -> u32 {
        self.base.push(base);
        self.place.push(place);
        self.after.push(NONE);
        self.base.len() as u32 - 1
    }

    pub(super) fn new_vertex(&mut self, point: u32, home: u32, out: u32) -> u32 {
        self.point.push(point);
        self.home.push(home);
        self.out.push(out);
        self.out.len() as u32 - 1
    }

    fn new_half_edge(&mut self, origin: u32, face: u32, line: u32, forward: bool) -> u32 {
        self.next.push(NONE);
        self.prev.push(NONE);
        self.twin.push(NONE);
        self.mate.push(NONE);
        self.origin.push(origin);
        self.face.push(face);
        self.line.push(line);
        self.forward.push(forward);
        self.span.push(NONE);
        self.next.len() as u32 - 1
    }

    fn link(&mut self, a: u32, b: u32) {
        self.next[a as usize] = b;
        self.prev[b as usize] = a;
    }

    /// Splits an edge; the new point stands for `base`, its vertex has the home of `near`.
    ///
    /// `h` then ends at the new vertex, as does its twin; both keep their origins.
    pub fn split_edge(&mut self, h: u32, base: u32, near: u32) -> u32 {
        // 1. The point, after the one that comes before it on the line.
        let ends = [self.origin[h as usize], self.target(h)].map(|v| self.point[v as usize]);
        let line = self.line[h as usize];
        let point = self.new_point(base, Place::Line(line));
        let before = if self.forward[h as usize] { ends[0] } else { ends[1] };
        if before == self.ends[line as usize][0] {
            self.after[point as usize] = self.first[line as usize];
            self.first[line as usize] = point;
        } else {
            self.after[point as usize] = self.after[before as usize];
            self.after[before as usize] = point;
        }
        // 2. Both sides of the edge.
        let other = if self.twin[h as usize] != NONE { self.twin[h as usize] } else { self.mate[h as usize] };
        let cut = self.twin[h as usize] == NONE;
        let home = self.home[near as usize];
        let vertex = self.new_vertex(point, home, NONE);
        let ahead = self.split_side(h, vertex, base);
        self.out[vertex as usize] = ahead;
        if other != NONE {
            let across = if cut { self.new_vertex(point, home, NONE) } else { vertex };
            let back = self.split_side(other, across, base);
            if cut {
                self.out[across as usize] = back;
            }
            let pairs = if cut { &mut self.mate } else { &mut self.twin };
            for (a, b) in [(h, back), (other, ahead)] {
                (pairs[a as usize], pairs[b as usize]) = (b, a);
            }
        }
        // 3. The piece between points of both ends of an edge of the mesh.
        if let Some(&middle) = self.middle.get(line as usize)
            && [h, other].contains(&middle)
            && self.span[middle as usize] == NONE
        {
            self.middle[line as usize] = self.next[middle as usize];
        }
        vertex
    }

    /// Splits one side of an edge; the side keeps its first part, the rest is returned.
    fn split_side(&mut self, h: u32, vertex: u32, base: u32) -> u32 {
        let (next, span) = (self.next[h as usize], self.span[h as usize]);
        let far = self.target(h);
        let rest = self.new_half_edge(vertex, self.face[h as usize], self.line[h as usize], self.forward[h as usize]);
        self.link(rest, next);
        self.link(h, rest);
        let near = self.origin[h as usize];
        self.span[h as usize] = if self.base_of(near) == base { NONE } else { span };
        self.span[rest as usize] = if self.base_of(far) == base { NONE } else { span };
        rest
    }

    /// Draws the chord between the origins of two half-edges of one face; returns the half-edge from the first.
    pub fn split_face(&mut self, a: u32, b: u32) -> u32 {
        let face = self.face[a as usize];
        let [p, q] = [a, b].map(|h| self.origin[h as usize]);
        let line = self.ends.len() as u32;
        self.ends.push([p, q].map(|v| self.point[v as usize]));
        self.first.push(NONE);
        self.chord_face.push(self.parent[face as usize]);
        // 1. p → q with what comes after b, q → p with what comes after a.
        let new_face = self.parent.len() as u32;
        let (there, back) = (self.new_half_edge(p, face, line, true), self.new_half_edge(q, new_face, line, false));
        let span = self.span_between(self.parent[face as usize], self.base_of(p), self.base_of(q));
        let (before_a, before_b) = (self.prev[a as usize], self.prev[b as usize]);
        self.link(before_a, there);
        self.link(there, b);
        self.link(before_b, back);
        self.link(back, a);
        for (h, twin) in [(there, back), (back, there)] {
            self.twin[h as usize] = twin;
            self.span[h as usize] = span;
        }
        // 2. The new face.
        self.parent.push(self.parent[face as usize]);
        self.side[face as usize] = there;
        self.side.push(back);
        let mut h = a;
        while h != back {
            self.face[h as usize] = new_face;
            h = self.next[h as usize];
        }
        there
    }

    /// Joins a new centre of a face to all its corners; returns its vertex.
    pub fn star_face(&mut self, face: u32, base: u32, near: u32) -> u32 {
        let sides = self.sides(face);
        let parent = self.parent[face as usize];
        let corners: Vec<u32> = sides.iter().map(|&h| self.point[self.origin[h as usize] as usize]).collect();
        let centre = self.new_point(base, Place::Centre(self.centres.len() as u32));
        self.centres.push((corners, self.ends.len()));
        let home = self.home[near as usize];
        let vertex = self.new_vertex(centre, home, NONE);
        // One triangle per side: corner → next corner → centre.
        let mut spokes = Vec::with_capacity(sides.len());
        for (k, &h) in sides.iter().enumerate() {
            let triangle = if k == 0 { face } else { self.parent.len() as u32 };
            if k > 0 {
                self.parent.push(parent);
                self.side.push(h);
            }
            let line = self.ends.len() as u32;
            let corner = self.origin[h as usize];
            self.ends.push([self.point[corner as usize], centre]);
            self.first.push(NONE);
            self.chord_face.push(parent);
            let span = self.span_between(parent, self.base_of(corner), base);
            // The spoke at the corner: inwards it belongs to the triangle before, outwards to this one.
            let (inwards, outwards) =
                (self.new_half_edge(corner, NONE, line, true), self.new_half_edge(vertex, triangle, line, false));
            for (a, b) in [(inwards, outwards), (outwards, inwards)] {
                self.twin[a as usize] = b;
                self.span[a as usize] = span;
            }
            self.face[h as usize] = triangle;
            spokes.push((inwards, outwards));
        }
        for (k, &h) in sides.iter().enumerate() {
            let (inwards, outwards) = (spokes[(k + 1) % sides.len()].0, spokes[k].1);
            self.face[inwards as usize] = self.face[h as usize];
            self.link(outwards, h);
            self.link(h, inwards);
            self.link(inwards, outwards);
        }
        self.side[face as usize] = sides[0];
        self.out[vertex as usize] = spokes[0].1;
        vertex
    }

    /// Half-edges of a face, in order.
    pub fn sides(&self, face: u32) -> Vec<u32> {
        let start = self.side[face as usize];
        let mut sides = vec![start];
        let mut h = self.next[start as usize];
        while h != start {
            sides.push(h);
            h = self.next[h as usize];
        }
        sides
    }

    /// A walk of inner edges between two corners of a face, through its inside or along an uncut side.
    pub(super) fn cross_face(&mut self, face: u32, from: u32, to: u32) -> Result<Vec<u32>, Lost> {
        let sides = self.sides(face);
        let corner = |v: u32| sides.iter().position(|&h| self.origin[h as usize] == v);
        let (Some(i), Some(j)) = (corner(from), corner(to)) else { return Err(Lost("a chord's ends share no face")) };
        if i == j {
            return Err(Lost("a chord's ends are one"));
        }
        let n = sides.len();
        let run = |from: usize, to: usize| (0..(to + n - from) % n).map(move |k| (from + k) % n);
        // 1. A side of the face, if it is not a border already.
        for (from, to, forwards) in [(i, j, true), (j, i, false)] {
            let h = sides[from];
            if (from + 1) % n == to && self.twin[h as usize] != NONE {
                return Ok(vec![if forwards { h } else { self.twin[h as usize] }]);
            }
        }
        // 2. A chord, if its ends are not on one line.
        let straight = |from: usize, to: usize| {
            let line = self.line[sides[from] as usize];
            run(from, to).all(|k| self.line[sides[k] as usize] == line)
        };
        if !straight(i, j) && !straight(j, i) {
            return Ok(vec![self.split_face(sides[i], sides[j])]);
        }
        // 3. Through the centre.
        let centre = self.star_face(face, self.base_of(from), from);
        let spoke = |v: u32| self.fan(centre).into_iter().find(|&h| self.target(h) == v);
        match (spoke(from), spoke(to)) {
            (Some(first), Some(second)) => Ok(vec![self.twin[first as usize], second]),
            _ => Err(Lost("a centre misses a corner")),
        }
    }
}
