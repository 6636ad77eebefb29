//! A closed triangle surface that is changed edge by edge: the workbench of the generated shapes.
//!
//! In: a closed, connected mesh. Out: the changed mesh. Holds: after every change the faces are a closed simplicial
//! surface of the same topology; changes that would break this are refused. Not: any quality of the triangles.
//! Source: link condition of Dey, Edelsbrunner, Guha, Nekhayev, Topology preserving edge contraction (1999) §3;
//! bisection of longest edges of Rivara, Algorithms for refining triangular grids (1984).
//!
//! ```text
//!      c            Edge a → b with its wings: the left face (a, b, c) with apex c,
//!    ↙   ↖          the right face (b, a, d) with apex d.
//!   a ──→ b
//!    ↘   ↗
//!      d
//! ```

use super::{Dice, build};
use crate::mesh::TriMesh;
use glam::DVec3;
use std::collections::BinaryHeap;

/// Marks a removed face.
const GONE: [u32; 3] = [u32::MAX; 3];

/// A surface under change.
pub(super) struct Draft {
    positions: Vec<DVec3>,
    /// Removed faces are [`GONE`].
    faces: Vec<[u32; 3]>,
    /// The faces of each vertex, in no particular order; none for a removed vertex.
    star: Vec<Vec<u32>>,
    /// Number of vertices that are not removed.
    vertices: usize,
}

/// The two faces of an edge and their apexes.
struct Wings {
    left: u32,
    right: u32,
    c: u32,
    d: u32,
}

/// A face waiting for the bisection of its longest edge; the longest comes first, ties by the smaller face.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Longest {
    /// Squared length as bits: these are ordered like the non-negative numbers they stand for.
    length_sq: u64,
    face: std::cmp::Reverse<u32>,
}

impl Draft {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let star = mesh.vertices().map(|v| mesh.outgoing(v).map(|h| mesh.face(h).0).collect()).collect();
        let positions = mesh.positions().values().to_vec();
        Self { positions, faces: mesh.to_faces(), star, vertices: mesh.vertex_count() }
    }

    /// Number of vertices.
    pub(super) fn vertices(&self) -> usize {
        self.vertices
    }

    /// The mesh, without the removed elements, in the order of their ids.
    pub(super) fn finish(&self) -> TriMesh {
        self.finish_without(&[])
    }

    /// The mesh without some faces, and without vertices that have no face left.
    pub(super) fn finish_without(&self, holes: &[u32]) -> TriMesh {
        let kept: Vec<[u32; 3]> = (0..self.faces.len() as u32)
            .filter(|f| !holes.contains(f))
            .map(|f| self.faces[f as usize])
            .filter(|&f| f != GONE)
            .collect();
        let mut new_id = vec![u32::MAX; self.positions.len()];
        kept.as_flattened().iter().for_each(|&v| new_id[v as usize] = 0);
        let mut positions = Vec::new();
        for (id, &p) in new_id.iter_mut().zip(&self.positions).filter(|(id, _)| **id == 0) {
            *id = positions.len() as u32;
            positions.push(p);
        }
        build(positions, kept.iter().map(|f| f.map(|v| new_id[v as usize])).collect())
    }

    /// An edge (a, b), drawn by a random face and one of its sides.
    pub(super) fn random_edge(&self, dice: &mut Dice) -> [u32; 2] {
        let face = self.faces[self.random_face(dice) as usize];
        let k = dice.below(3);
        [face[k], face[(k + 1) % 3]]
    }

    /// A face drawn at random.
    pub(super) fn random_face(&self, dice: &mut Dice) -> u32 {
        loop {
            let f = dice.below(self.faces.len());
            if self.faces[f] != GONE {
                return f as u32;
            }
        }
    }

    /// The vertices of a face.
    pub(super) fn face(&self, f: u32) -> [u32; 3] {
        self.faces[f as usize]
    }

    /// The faces of a vertex, in no particular order.
    pub(super) fn star(&self, v: u32) -> &[u32] {
        &self.star[v as usize]
    }

    /// The longest edge of a face; of equal ones the first.
    pub(super) fn longest_edge(&self, f: u32) -> [u32; 2] {
        let [a, b, c] = self.face(f);
        let sides = [[a, b], [b, c], [c, a]];
        sides.into_iter().rev().max_by(|s, t| self.length_sq(*s).total_cmp(&self.length_sq(*t))).unwrap_or([a, b])
    }

    fn length_sq(&self, [a, b]: [u32; 2]) -> f64 {
        self.positions[a as usize].distance_squared(self.positions[b as usize])
    }

    /// Splits the edge (a, b) at parameter `t` from a, and its two faces with it.
    pub(super) fn split(&mut self, [a, b]: [u32; 2], t: f64) {
        let Wings { left, right, c, d } = self.wings(a, b);
        let m = self.positions.len() as u32;
        self.positions.push(self.positions[a as usize].lerp(self.positions[b as usize], t));
        let (new_left, new_right) = (self.faces.len() as u32, self.faces.len() as u32 + 1);
        self.faces[left as usize] = [a, m, c];
        self.faces[right as usize] = [m, a, d];
        self.faces.extend([[m, b, c], [b, m, d]]);
        self.replace_in_star(b, left, new_left);
        self.replace_in_star(b, right, new_right);
        self.star[c as usize].push(new_left);
        self.star[d as usize].push(new_right);
        self.star.push(vec![left, new_left, right, new_right]);
        self.vertices += 1;
    }

    /// Splits longest edges, the longest of all first, until there are `vertices` vertices.
    ///
    /// # Guarantees a bisected edge is the longest of both its faces: no angle falls below half the smallest one
    pub(super) fn bisect_to(&mut self, vertices: usize) {
        let mut heap: BinaryHeap<Longest> = (0..self.faces.len() as u32).map(|f| self.longest(f)).collect();
        while self.vertices < vertices
            && let Some(top) = heap.pop()
        {
            let f = top.face.0;
            if self.longest(f) != top {
                continue;
            }
            let [a, b] = self.longest_edge(f);
            self.split([a, b], 0.5);
            let changed = self.star[self.positions.len() - 1].iter().map(|&g| self.longest(g));
            heap.extend(changed);
        }
    }

    fn longest(&self, f: u32) -> Longest {
        Longest { length_sq: self.length_sq(self.longest_edge(f)).to_bits(), face: std::cmp::Reverse(f) }
    }

    /// Turns the edge (a, b) into the other diagonal of its two faces; false if that is an edge already.
    pub(super) fn flip(&mut self, [a, b]: [u32; 2]) -> bool {
        let Wings { left, right, c, d } = self.wings(a, b);
        if self.ring(c).any(|v| v == d) {
            return false;
        }
        self.faces[left as usize] = [c, a, d];
        self.faces[right as usize] = [d, b, c];
        self.star[a as usize].retain(|&f| f != right);
        self.star[b as usize].retain(|&f| f != left);
        self.star[c as usize].push(right);
        self.star[d as usize].push(left);
        true
    }

    /// Contracts the edge (a, b) to its midpoint, which becomes a; false if the link condition forbids it.
    pub(super) fn collapse(&mut self, [a, b]: [u32; 2]) -> bool {
        let Wings { left, right, c, d } = self.wings(a, b);
        // On a connected surface other than the tetrahedron: the apexes are the only common neighbours.
        let common = self.ring(a).filter(|&v| self.ring(b).any(|w| w == v)).count();
        if self.vertices <= 4 || common > 2 {
            return false;
        }
        for v in [a, c, d] {
            self.star[v as usize].retain(|&f| f != left && f != right);
        }
        for f in std::mem::take(&mut self.star[b as usize]) {
            if f == left || f == right {
                self.faces[f as usize] = GONE;
            } else {
                self.faces[f as usize] = self.faces[f as usize].map(|v| if v == b { a } else { v });
                self.star[a as usize].push(f);
            }
        }
        self.positions[a as usize] = self.positions[a as usize].midpoint(self.positions[b as usize]);
        self.vertices -= 1;
        true
    }

    /// Moves every vertex by a share of the way to the mean of its neighbours, all at once.
    pub(super) fn smooth(&mut self, share: f64) {
        let moved = (0..self.star.len() as u32).map(|v| {
            let (sum, valence) =
                self.ring(v).fold((DVec3::ZERO, 0.0), |(s, n), w| (s + self.positions[w as usize], n + 1.0));
            let here = self.positions[v as usize];
            if valence > 0.0 { here.lerp(sum / valence, share) } else { here }
        });
        self.positions = moved.collect();
    }

    /// Moves every vertex at random, by at most `amount` in each coordinate.
    pub(super) fn jitter(&mut self, amount: f64, dice: &mut Dice) {
        for p in &mut self.positions {
            let shift = DVec3::from_array(std::array::from_fn(|_| dice.within(-1.0, 1.0)));
            *p += shift * amount;
        }
    }

    /// The neighbours of a vertex, each once, in no particular order.
    fn ring(&self, v: u32) -> impl Iterator<Item = u32> {
        self.star[v as usize].iter().map(move |&f| {
            let face = self.face(f);
            face[(corner(face, v) + 1) % 3]
        })
    }

    fn wings(&self, a: u32, b: u32) -> Wings {
        let mut wings = Wings { left: 0, right: 0, c: 0, d: 0 };
        for &f in self.star(a) {
            let face = self.face(f);
            let k = corner(face, a);
            let (next, last) = (face[(k + 1) % 3], face[(k + 2) % 3]);
            if next == b {
                (wings.left, wings.c) = (f, last);
            } else if last == b {
                (wings.right, wings.d) = (f, next);
            }
        }
        wings
    }

    fn replace_in_star(&mut self, v: u32, old: u32, new: u32) {
        self.star[v as usize].iter_mut().filter(|f| **f == old).for_each(|f| *f = new);
    }
}

/// The corner of a face at one of its vertices.
fn corner(face: [u32; 3], v: u32) -> usize {
    usize::from(face[1] == v) + 2 * usize::from(face[2] == v)
}
