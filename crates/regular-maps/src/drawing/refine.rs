//! Makes the triangles of a quarter-tube's picture small enough to follow the surface.
//!
//! In: a [`LocalPicture`], how many steps a quarter-tube is to have. Out: the same with long sides halved, first those of
//! pieces, then those of the triangles inside them.
//! Holds: sides that are glued to each other are halved alike, so that all quarter-tubes still fit together.

use super::local::{LocalPicture, LocalPoint, LocalTriangle};
use crate::plane::Plane;
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, BTreeSet};

type Side = (u32, u32);

fn key(a: u32, b: u32) -> Side {
    (a.min(b), a.max(b))
}

fn sides_of(corners: &[u32]) -> impl Iterator<Item = Side> + '_ {
    corners.iter().enumerate().map(|(k, &i)| (i, corners[(k + 1) % corners.len()]))
}

impl LocalPicture {
    /// Halves sides of pieces that are longer than 1/`steps` in u or v until there are none; new vertices lie on the
    /// straight lines of the plane, which are curves in (u, v).
    pub fn halve_sides(&mut self, plane: &Plane, steps: [usize; 2]) {
        // Sides shrink by half each time; the bound is for sides that rounding keeps at the limit.
        for _ in 0..16 {
            let sides = self.outlines.iter().flat_map(|o| sides_of(&o.corners));
            let mut marked = self.long(sides, steps);
            self.mark_partners(&mut marked);
            if marked.is_empty() {
                break;
            }
            let middle = self.add_middles(&marked, |picture, a, b| {
                let place = plane.between(a.place, b.place, 0.5);
                (place, picture.quad.uv(place))
            });
            for outline in &mut self.outlines {
                let old = std::mem::take(&mut outline.corners);
                for (i, j) in sides_of(&old).collect::<Vec<_>>() {
                    outline.corners.push(i);
                    outline.corners.extend(middle.get(&key(i, j)));
                }
            }
        }
    }

    /// Halves sides of triangles inside pieces that are longer than 1/`steps` in u or v; new vertices lie midway in (u, v).
    pub fn halve_inside(&mut self, steps: [usize; 2]) {
        for _ in 0..16 {
            let sides = self.triangles.iter().flat_map(|t| sides_of(&t.corners));
            let mut marked = self.long(sides, steps);
            let borders = self.outlines.iter().flat_map(|o| sides_of(&o.corners));
            borders.for_each(|(i, j)| _ = marked.remove(&key(i, j)));
            if marked.is_empty() {
                break;
            }
            let middle = self.add_middles(&marked, |_, a, b| (a.place, 0.5 * (a.uv + b.uv)));
            for triangle in std::mem::take(&mut self.triangles) {
                let [a, b, c] = triangle.corners;
                self.divide(triangle, [(a, b), (b, c), (c, a)].map(|(i, j)| middle.get(&key(i, j)).copied()));
            }
        }
    }

    fn long(&self, sides: impl Iterator<Item = Side>, steps: [usize; 2]) -> BTreeSet<Side> {
        let longest = DVec2::from(steps.map(|n| (1.0 + 1e-9) / n as f64));
        let is_long = |&(i, j): &Side| {
            let [a, b] = [i, j].map(|v| self.points[v as usize].uv);
            (a - b).abs().cmpgt(longest).any()
        };
        sides.filter(is_long).map(|(i, j)| key(i, j)).collect()
    }

    fn add_middles(
        &mut self,
        marked: &BTreeSet<Side>,
        at: impl Fn(&Self, LocalPoint, LocalPoint) -> (DVec3, DVec2),
    ) -> BTreeMap<Side, u32> {
        let mut middle = BTreeMap::new();
        for &(i, j) in marked {
            let [a, b] = [i, j].map(|v| self.points[v as usize]);
            let (place, mut uv) = at(self, a, b);
            // What is on a side of the quarter-tube stays on it exactly.
            (0..2).filter(|&k| a.uv[k] == b.uv[k] && a.uv[k].fract() == 0.0).for_each(|k| uv[k] = a.uv[k]);
            middle.insert((i, j), self.points.len() as u32);
            self.points.push(LocalPoint { place, uv, height: 0.5 * (a.height + b.height) });
        }
        middle
    }

    /// A side on the border of the quarter-tube is halved where its partner on the neighbour is.
    fn mark_partners(&self, marked: &mut BTreeSet<Side>) {
        let [a, b, c, d] = self.sides();
        let reversed = |list: &[u32]| list.iter().rev().copied().collect::<Vec<_>>();
        for (one, other) in [(&a, &reversed(&a)), (&c, &reversed(&c)), (&b, &d), (&d, &b)] {
            for (x, y) in one.windows(2).zip(other.windows(2)) {
                if marked.contains(&key(x[0], x[1])) {
                    marked.insert(key(y[0], y[1]));
                }
            }
        }
    }

    /// Divides a triangle by the middles of one, two or three of its sides.
    fn divide(&mut self, t: LocalTriangle, halves: [Option<u32>; 3]) {
        let mut add = |corners| self.triangles.push(LocalTriangle { corners, ..t });
        let turned = |k: usize| [0, 1, 2].map(|i| t.corners[(k + i) % 3]);
        let middle = |k: usize| halves[k % 3];
        match halves.iter().flatten().count() {
            0 => add(t.corners),
            1 => {
                let k = (0..3).find(|&k| halves[k].is_some()).unwrap_or(0);
                let ([a, b, c], m) = (turned(k), middle(k).unwrap_or(0));
                add([a, m, c]);
                add([m, b, c]);
            }
            2 => {
                // The side that stays whole is c a; the quadrilateral beside the cut-off corner is divided by its shorter
                // diagonal.
                let k = ((0..3).find(|&k| halves[k].is_none()).unwrap_or(0) + 1) % 3;
                let ([a, b, c], [m, n]) = (turned(k), [middle(k), middle(k + 1)].map(|m| m.unwrap_or(0)));
                add([m, b, n]);
                let first = self.length(a, n) <= self.length(m, c);
                let rest = if first { [[a, m, n], [a, n, c]] } else { [[a, m, c], [m, n, c]] };
                self.triangles.extend(rest.map(|corners| LocalTriangle { corners, ..t }));
            }
            _ => {
                let [l, m, n] = halves.map(|m| m.unwrap_or(0));
                let [a, b, c] = t.corners;
                for corners in [[a, l, n], [l, b, m], [n, m, c], [l, m, n]] {
                    add(corners);
                }
            }
        }
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        self.points[a as usize].uv.distance(self.points[b as usize].uv)
    }
}
