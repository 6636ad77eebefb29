//! Makes the sides of a quarter-tube's picture short enough to follow the lines of the tiling.
//!
//! In: a [`LocalPicture`], how many steps a quarter-tube is to have. Out: the same with long sides of pieces halved.
//! Holds: sides that are glued to each other are halved alike, so that all quarter-tubes still fit together.

use super::local::{LocalPicture, LocalPoint};
use glam::{DVec2, DVec3};
use quadloom_regular_maps::plane::Plane;
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
}
