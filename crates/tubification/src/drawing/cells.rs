//! Cuts the pieces of a picture at the lines of a grid, so that each lies in one flat triangle of the surface.
//!
//! In: a [`LocalPicture`]; cells along and around. Out: its triangles, cut along u = i/n, v = j/m and the diagonals of the
//! cells, and [`Weights`]: how a point lies between the nodes of the grid.
//! Holds: triangles that do not overlap in (u, v) do not overlap in space either, however thin they are, unless the
//! surface through the nodes meets itself.

use super::local::{LocalPicture, LocalPoint, LocalTriangle, Outline};
use glam::DVec2;
use std::collections::{BTreeMap, BTreeSet};

/// Points this close to a line of the grid, in cells, are on it.
const ON_LINE: f64 = 1e-9;

/// A line of the grid: where `normal` · (u n, v m) is `offset`.
#[derive(Clone, Copy)]
struct Line {
    normal: DVec2,
    offset: f64,
}

/// A convex part of an outline.
struct Part {
    corners: Vec<u32>,
    /// Number of the outline.
    of: usize,
}

type Side = (u32, u32);

fn key(a: u32, b: u32) -> Side {
    (a.min(b), a.max(b))
}

impl LocalPicture {
    /// Cuts all pieces into triangles.
    ///
    /// # Cost       (parts) × (lines of the grid)
    pub fn cut_into_cells(&mut self, cells: [usize; 2]) {
        // 1. Convex parts, and the sides that only these have.
        self.snap(cells);
        let mut parts = Vec::new();
        let mut help = Help::default();
        for (of, outline) in self.outlines.iter().enumerate() {
            let ears = self.ears(outline);
            help.sides.extend(diagonals(&ears));
            parts.extend(ears.into_iter().map(|t| Part { corners: t.corners.to_vec(), of }));
        }
        // 2. Cut them.
        for line in lines(cells) {
            parts = self.cut(parts, line, cells, &mut help);
        }
        // 3. What lies in one half of a cell is made one again.
        let mut groups: BTreeMap<(usize, [usize; 3]), Vec<Part>> = BTreeMap::new();
        for part in parts {
            groups.entry((part.of, self.half_cell(&part, cells))).or_default().push(part);
        }
        // 4. Triangles.
        let mut triangles = Vec::new();
        for ((of, _), parts) in groups {
            let Outline { flag, strip, .. } = self.outlines[of];
            for corners in outlines_of(&parts, &help) {
                triangles.extend(self.ears(&Outline { corners, flag, strip }));
            }
        }
        self.triangles = triangles;
        self.forget(&help.points);
    }

    /// Takes points out that no triangle has.
    fn forget(&mut self, unused: &BTreeSet<u32>) {
        let kept: Vec<u32> = (0..self.points.len() as u32).filter(|i| !unused.contains(i)).collect();
        let mut number = vec![0; self.points.len()];
        kept.iter().enumerate().for_each(|(new, &old)| number[old as usize] = new as u32);
        self.points = kept.iter().map(|&i| self.points[i as usize]).collect();
        let corners = self.triangles.iter_mut().flat_map(|t| &mut t.corners);
        corners.chain(self.outlines.iter_mut().flat_map(|o| &mut o.corners)).for_each(|i| *i = number[*i as usize]);
    }

    /// Column, row and half of the cell in which a part lies.
    fn half_cell(&self, part: &Part, cells: [usize; 2]) -> [usize; 3] {
        let sum: DVec2 = part.corners.iter().map(|&i| self.points[i as usize].uv).sum();
        let at = sum / part.corners.len() as f64 * DVec2::new(cells[0] as f64, cells[1] as f64);
        let [i, j] = [at.x as usize, at.y as usize];
        [i, j, usize::from(at.x - i as f64 >= at.y - j as f64)]
    }

    /// Points next to lines come to lie on them, points that are glued together at the same places.
    fn snap(&mut self, cells: [usize; 2]) {
        let [a, b, c, d] = self.sides();
        for side in [a, c] {
            let (first, last) = side.split_at(side.len() / 2);
            for (&one, &other) in first.iter().zip(last.iter().rev()) {
                self.points[other as usize].uv.y = 1.0 - self.points[one as usize].uv.y;
            }
        }
        for (&here, &there) in d.iter().zip(&b) {
            self.points[there as usize].uv.x = self.points[here as usize].uv.x;
        }
        for point in &mut self.points {
            for (k, n) in cells.into_iter().enumerate() {
                let at = point.uv[k] * n as f64;
                if (at - at.round()).abs() < ON_LINE {
                    point.uv[k] = at.round() / n as f64;
                }
            }
        }
    }

    fn cut(&mut self, parts: Vec<Part>, line: Line, cells: [usize; 2], help: &mut Help) -> Vec<Part> {
        let scale = DVec2::new(cells[0] as f64, cells[1] as f64);
        let mut found = BTreeMap::new();
        let mut cut = Vec::with_capacity(parts.len());
        for part in parts {
            let side = |&i: &u32| {
                let distance = line.normal.dot(self.points[i as usize].uv * scale) - line.offset;
                if distance.abs() < ON_LINE { 0.0 } else { distance }
            };
            let distance: Vec<f64> = part.corners.iter().map(side).collect();
            if !(distance.iter().any(|&d| d > 0.0) && distance.iter().any(|&d| d < 0.0)) {
                cut.push(part);
                continue;
            }
            let mut halves = [Vec::new(), Vec::new()];
            for (k, (&i, &d)) in part.corners.iter().zip(&distance).enumerate() {
                let next = (k + 1) % distance.len();
                (0..2).filter(|&half| [d >= 0.0, d <= 0.0][half]).for_each(|half| halves[half].push(i));
                if d * distance[next] < 0.0 {
                    let j = part.corners[next];
                    let ends = if i < j { [(i, d), (j, distance[next])] } else { [(j, distance[next]), (i, d)] };
                    let middle = *found.entry(key(i, j)).or_insert_with(|| {
                        let middle = self.crossing(ends, line, scale);
                        help.halve(key(i, j), middle);
                        middle
                    });
                    halves.iter_mut().for_each(|half| half.push(middle));
                }
            }
            cut.extend(halves.map(|corners| Part { corners, of: part.of }));
        }
        cut
    }

    /// The point in which a side crosses a line.
    fn crossing(&mut self, ends: [(u32, f64); 2], line: Line, scale: DVec2) -> u32 {
        let [a, b] = ends.map(|(i, _)| self.points[i as usize]);
        let t = ends[0].1 / (ends[0].1 - ends[1].1);
        let mut uv = a.uv.lerp(b.uv, t);
        for k in 0..2 {
            if line.normal[1 - k] == 0.0 {
                uv[k] = line.offset / scale[k];
            }
            // What is on a side of the quarter-tube stays on it exactly.
            if a.uv[k] == b.uv[k] {
                uv[k] = a.uv[k];
            }
        }
        let height = a.height + t * (b.height - a.height);
        self.points.push(LocalPoint { place: a.place.lerp(b.place, t), uv, height });
        self.points.len() as u32 - 1
    }
}

fn lines([n, m]: [usize; 2]) -> impl Iterator<Item = Line> {
    let of = |normal: DVec2| move |k: i64| Line { normal, offset: k as f64 };
    let (n, m) = (n as i64, m as i64);
    (1..n).map(of(DVec2::X)).chain((1..m).map(of(DVec2::Y))).chain((1 - m..n).map(of(DVec2::new(1.0, -1.0))))
}

/// What is there only because outlines were divided into convex parts.
#[derive(Default)]
struct Help {
    sides: BTreeSet<Side>,
    points: BTreeSet<u32>,
}

impl Help {
    fn halve(&mut self, side: Side, middle: u32) {
        if self.sides.contains(&side) {
            self.points.insert(middle);
            self.sides.extend([key(side.0, middle), key(side.1, middle)]);
        }
    }
}

/// Sides that two triangles share.
fn diagonals(triangles: &[LocalTriangle]) -> Vec<Side> {
    let sides = triangles.iter().flat_map(|t| (0..3).map(|k| key(t.corners[k], t.corners[(k + 1) % 3])));
    let mut seen = BTreeSet::new();
    sides.filter(|&side| !seen.insert(side)).collect()
}

/// The outlines of parts that lie side by side, without points that only parts have.
fn outlines_of(parts: &[Part], help: &Help) -> Vec<Vec<u32>> {
    let sides = |part: &Part| {
        let corners = part.corners.clone();
        (0..corners.len()).map(move |k| (corners[k], corners[(k + 1) % corners.len()]))
    };
    let all: BTreeSet<Side> = parts.iter().flat_map(sides).collect();
    // A point may be passed twice, where outlines touch: the last side that arrives there goes on along the first one left.
    let mut onward: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &(a, b) in all.iter().filter(|&&(a, b)| !all.contains(&(b, a))) {
        onward.entry(a).or_default().push(b);
    }
    let mut outlines = Vec::new();
    while let Some((&start, _)) = onward.iter().find(|(_, next)| !next.is_empty()) {
        let mut outline = vec![start];
        let mut at = start;
        while let Some(next) = onward.get_mut(&at).and_then(Vec::pop) {
            if next == start {
                break;
            }
            outline.push(next);
            at = next;
        }
        outline.retain(|i| !help.points.contains(i));
        outlines.push(outline);
    }
    outlines
}

/// The three nodes around a point, as columns and rows of the grid, and their shares.
pub(super) struct Weights {
    pub nodes: [[usize; 2]; 3],
    pub shares: [f64; 3],
}

impl Weights {
    pub fn of(uv: DVec2, cells: [usize; 2]) -> Self {
        let place = |k: usize| {
            let x = uv[k] * cells[k] as f64;
            let i = (x as usize).min(cells[k] - 1);
            (i, x - i as f64)
        };
        let ((i, s), (j, t)) = (place(0), place(1));
        if s >= t {
            Self { nodes: [[i, j], [i + 1, j], [i + 1, j + 1]], shares: [1.0 - s, s - t, t] }
        } else {
            Self { nodes: [[i, j], [i, j + 1], [i + 1, j + 1]], shares: [1.0 - t, t - s, s] }
        }
    }
}
