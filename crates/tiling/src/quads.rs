//! Quadrangles from polygons ([Favreau2009] §4).
//!
//! In: a [`Cutting`] whose tiles are polygons. Out: the same with diagonals cut until every tile has four sides.
//! Holds: m sides give m/2 − 1 quadrangles, hence 2g − 1 from a single-point cutting; diagonals are chosen by length,
//! one by one ([Favreau2009] Algorithm 5) or all together (the shortest total, by dynamic programming over intervals of
//! the polygon); the report tells how much shorter the latter is.
//!
//! Cutting a polygon does not change the distances of corners that stay together: two shortest paths in a disk whose
//! ends do not alternate need not cross. So all distances are found before the first diagonal is cut.

use crate::cost::FORBIDDEN;
use crate::cut_surface::{CutSurface, NONE, Walk};
use crate::cutting::{CutKind, Cutting, SearchMode};
use crate::error::TilingError;
use crate::search::Search;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashMap, HashSet};

/// How diagonals are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DiagonalChoice {
    /// The shortest possible one again and again ([Favreau2009] Algorithm 5).
    Greedy,
    /// The set of smallest total cost.
    #[default]
    Optimal,
}

/// Options of [`Cutting::quadrangulate`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct QuadOptions {
    /// Exact: a search from each corner. Fast: one from all corners at once; paths then follow its trees.
    pub search: SearchMode,
    /// How diagonals are chosen. Default: optimal.
    pub choice: DiagonalChoice,
}

/// What quadrangulation did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct QuadReport {
    /// Number of quadrangles.
    pub quadrangles: usize,
    /// Nodes added to the boundary of the mesh to make numbers of sides even and at least four.
    pub added_nodes: usize,
    /// Cost of all diagonals chosen one by one.
    pub greedy_cost: f64,
    /// Cost of all diagonals chosen together.
    pub optimal_cost: f64,
}

/// Distances between the corners of a polygon, units.
struct Distances {
    corners: usize,
    value: Vec<u64>,
}

/// A set of diagonals and the sum of their lengths.
#[derive(Clone, Debug, Default, PartialEq)]
struct Choice {
    diagonals: Vec<(usize, usize)>,
    total: u64,
}

impl Cutting<'_> {
    /// Cuts every polygon into quadrangles ([Favreau2009] Algorithms 4 and 5).
    ///
    /// # Output     costs of both choices of diagonals
    /// # Errors     [`TilingError::NotDisks`] if a tile is no polygon; [`TilingError::NoHandle`] for a sphere that was
    /// slit; [`TilingError::NoWay`] where forbidden edges part corners
    /// # Cost       fast: O(n log n + m³) for m sides; exact: O(m n log n + m³)
    /// # Guarantees quadrangles = Σ (m/2 − 1); no other node than corners is made
    pub fn quadrangulate(&mut self, options: &QuadOptions) -> Result<QuadReport, TilingError> {
        let mut report = QuadReport { added_nodes: self.even_sides()?, ..Default::default() };
        self.surface.settle();
        let polygons = self.polygons()?;
        let scale = self.unit_cost();
        for corners in polygons {
            self.progress.check()?;
            report.quadrangles += (corners.len() / 2).saturating_sub(1);
            let (distances, net) = match options.search {
                SearchMode::Exact => (self.exact_distances(&corners)?, None),
                SearchMode::Fast => {
                    let net = Net::grow(&self.surface, &self.units, &corners, &mut self.search);
                    (net.distances(corners.len()), Some(net))
                }
            };
            let (greedy, optimal) = (distances.greedy(), distances.optimal());
            report.greedy_cost += greedy.total as f64 * scale;
            report.optimal_cost += optimal.total as f64 * scale;
            let chosen = match options.choice {
                DiagonalChoice::Greedy => greedy,
                DiagonalChoice::Optimal => optimal,
            };
            self.cut_diagonals(&corners, chosen, net.as_ref())?;
        }
        Ok(report)
    }

    /// Cost of one unit.
    fn unit_cost(&self) -> f64 {
        let (mut cost, mut units) = (0.0, 0u64);
        for (e, &unit) in self.units.iter().enumerate().filter(|(_, u)| **u != FORBIDDEN) {
            cost += self.costs.values().values()[e];
            units += unit;
        }
        if units > 0 { cost / units as f64 } else { 0.0 }
    }

    /// Corners of every tile, counter-clockwise, as vertices of C.
    fn polygons(&self) -> Result<Vec<Vec<u32>>, TilingError> {
        let node = self.nodes();
        let s = &self.surface;
        let corners = |border: &Vec<u32>| -> Vec<u32> {
            border.iter().map(|&h| s.origin[h as usize]).filter(|&v| node[s.point[v as usize] as usize]).collect()
        };
        let borders = s.borders();
        let polygons: Vec<Vec<u32>> = borders.iter().map(corners).collect();
        match polygons.iter().position(|p| p.len() < 4 || p.len() % 2 == 1) {
            Some(tile) if polygons[tile].len() == 2 && self.cuts.first().is_some_and(|c| c.kind == CutKind::Slit) => {
                let instead = "a sphere that was slit has two sides; cut it into a disk, or mesh it with `remesh`";
                Err(TilingError::NoHandle { algorithm: "cutting into quadrangles", instead })
            }
            Some(tile) => Err(TilingError::Sides { tile, sides: polygons[tile].len() }),
            None => Ok(polygons),
        }
    }

    /// Adds nodes on the boundary of the mesh until every polygon that touches it has an even number of sides, at least
    /// four; returns how many.
    fn even_sides(&mut self) -> Result<usize, TilingError> {
        let mut added = 0;
        loop {
            let node = self.nodes();
            let s = &self.surface;
            let wanting = s.borders().into_iter().find(|border| {
                let corners = border.iter().filter(|&&h| node[s.point[s.origin[h as usize] as usize] as usize]).count();
                let touches = border.iter().any(|&h| s.mate[h as usize] == NONE);
                touches && (corners < 4 || corners % 2 == 1)
            });
            let Some(border) = wanting else { return Ok(added) };
            // A disk that was not cut has one node anyway, wherever that is.
            let has_node = border.iter().any(|&h| node[s.point[s.origin[h as usize] as usize] as usize]);
            self.add_node(&border, &node)?;
            added += usize::from(has_node);
        }
    }

    /// Makes the middle of the longest side on the mesh's boundary a node.
    fn add_node(&mut self, border: &[u32], node: &[bool]) -> Result<(), TilingError> {
        let s = &self.surface;
        let is_node = |h: u32| node[s.point[s.origin[h as usize] as usize] as usize];
        let start = border.iter().position(|&h| is_node(h)).unwrap_or(0);
        let around: Vec<u32> = (0..border.len()).map(|k| border[(start + k) % border.len()]).collect();
        // 1. Sides as runs between nodes.
        let mut sides: Vec<Vec<u32>> = Vec::new();
        for &h in &around {
            if is_node(h) || sides.is_empty() {
                sides.push(Vec::new());
            }
            if let Some(side) = sides.last_mut() {
                side.push(h);
            }
        }
        let longest = sides.into_iter().filter(|side| s.mate[side[0] as usize] == NONE).max_by_key(Vec::len);
        let side = longest.ok_or(TilingError::Fault { what: "a boundary was lost" })?;
        // 2. The vertex in its middle; an edge alone is split. A boundary without any node starts with its first.
        let vertex = if !is_node(side[0]) {
            s.origin[side[0] as usize]
        } else if side.len() > 1 {
            s.origin[side[side.len() / 2] as usize]
        } else {
            let (base, near) = (s.base_of(s.origin[side[0] as usize]), s.origin[side[0] as usize]);
            self.surface.split_edge(side[0], base, near)
        };
        self.extra.push(self.surface.point[vertex as usize]);
        Ok(())
    }

    /// Distances between corners by one search from each.
    fn exact_distances(&mut self, corners: &[u32]) -> Result<Distances, TilingError> {
        let m = corners.len();
        let mut distances = Distances { corners: m, value: vec![u64::MAX; m * m] };
        let is_corner: HashSet<u32> = corners.iter().copied().collect();
        for i in 0..m {
            self.progress.check()?;
            self.progress.report("distances", i as f64 / m as f64);
            let mut left = m;
            self.search.spread(&self.surface, &self.units, &[(corners[i], 0)], |v| {
                left -= usize::from(is_corner.contains(&v));
                left == 0
            });
            for (j, &corner) in corners.iter().enumerate() {
                distances.value[i * m + j] = self.search.distance(corner).unwrap_or(u64::MAX);
            }
        }
        Ok(distances)
    }

    /// Cuts along the chosen diagonals, shortest first.
    fn cut_diagonals(&mut self, corners: &[u32], choice: Choice, net: Option<&Net>) -> Result<(), TilingError> {
        let mut copies: HashMap<u32, Vec<u32>> = corners.iter().map(|&v| (v, vec![v])).collect();
        for (k, &(i, j)) in choice.diagonals.iter().enumerate() {
            self.progress.check()?;
            self.progress.report("diagonals", k as f64 / choice.diagonals.len() as f64);
            let [from, to] = [corners[i], corners[j]];
            let (sources, targets) = (copies[&from].clone(), copies[&to].clone());
            let before = self.surface.vertex_count();
            let walk = self.diagonal(&sources, &targets, net.map(|net| net.walk(i, j)));
            self.cut_along(&walk.ok_or(TilingError::NoWay { what: "a diagonal" })?, CutKind::Diagonal)?;
            for v in before as u32..self.surface.vertex_count() as u32 {
                let home = self.surface.home[v as usize];
                // Points beside a corner have its home too; a corner's copies are the same point.
                if let Some(all) = copies.get_mut(&home)
                    && self.surface.point[v as usize] == self.surface.point[home as usize]
                {
                    all.push(v);
                }
            }
        }
        Ok(())
    }

    /// A walk in one piece between copies of two corners: along a given path, or the shortest one.
    fn diagonal(&mut self, sources: &[u32], targets: &[u32], along: Option<Vec<u32>>) -> Option<Walk> {
        let s = &self.surface;
        if let Some(path) = along {
            let homes: HashSet<u32> = path.into_iter().collect();
            let allowed = |h: u32| s.span[h as usize] == NONE || self.units[s.span[h as usize] as usize] != FORBIDDEN;
            let may_step = |_: u32, h: u32, w: u32| homes.contains(&s.home[w as usize]) && allowed(h);
            let found = self.search.follow(s, sources, may_step, |v| targets.contains(&v));
            if found.is_some() {
                return found;
            }
        }
        self.search.path(s, &self.units, sources, u64::MAX, |v| targets.contains(&v)).map(|f| f.walk)
    }
}

impl Distances {
    fn of(&self, i: usize, j: usize) -> u64 {
        self.value[i * self.corners + j]
    }

    /// Pairs of corners whose diagonal leaves even polygons of at least four sides on both sides ([Favreau2009] Def. 7).
    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        let m = self.corners;
        (0..m).flat_map(move |i| (i + 3..m).step_by(2).map(move |j| (i, j))).filter(move |&(i, j)| m - (j - i) >= 3)
    }

    /// The shortest diagonal that crosses no earlier one, again and again ([Favreau2009] Algorithm 5).
    fn greedy(&self) -> Choice {
        let mut pairs: Vec<(u64, usize, usize)> = self.pairs().map(|(i, j)| (self.of(i, j), i, j)).collect();
        pairs.sort_unstable();
        let mut choice = Choice::default();
        for (length, i, j) in pairs {
            let between = |k: usize| i < k && k < j;
            let crosses = |&(a, b): &(usize, usize)| {
                let outside = |k: usize| k < i || k > j;
                (between(a) && outside(b)) || (between(b) && outside(a))
            };
            if length < u64::MAX && !choice.diagonals.iter().any(crosses) {
                choice.diagonals.push((i, j));
                choice.total = choice.total.saturating_add(length);
            }
        }
        choice
    }

    /// The diagonals of smallest total length.
    ///
    /// For corners i < j an odd number apart let `even[i][j]` be the least total of quadrangles that fill i, …, j under
    /// the chord i–j, with that chord; two such polygons side by side fill an interval an even number apart.
    fn optimal(&self) -> Choice {
        let m = self.corners;
        if m <= 4 {
            return Choice::default();
        }
        let at = |i: usize, j: usize| i * m + j;
        let (mut one, mut two) = (vec![0u64; m * m], vec![u64::MAX; m * m]);
        let (mut split_one, mut split_two) = (vec![0u32; m * m], vec![0u32; m * m]);
        for width in 2..m {
            for i in 0..m - width {
                let j = i + width;
                if width % 2 == 0 {
                    // i … k and k … j, each one polygon (or a side).
                    let sum = |k: usize| one[at(i, k)].saturating_add(one[at(k, j)]);
                    let best = (i + 1..j).step_by(2).min_by_key(|&k| sum(k)).unwrap_or(i + 1);
                    (two[at(i, j)], split_two[at(i, j)]) = (sum(best), best as u32);
                } else {
                    // The quadrangle at the chord has corners i, k, l, j: one polygon i … k, and two over k … j.
                    let sum = |k: usize| one[at(i, k)].saturating_add(two[at(k, j)]);
                    let best = (i + 1..j - 1).step_by(2).min_by_key(|&k| sum(k)).unwrap_or(i + 1);
                    let chord = if width == m - 1 { 0 } else { self.of(i, j) };
                    (one[at(i, j)], split_one[at(i, j)]) = (sum(best).saturating_add(chord), best as u32);
                }
            }
        }
        let mut choice = Choice { diagonals: Vec::new(), total: one[at(0, m - 1)] };
        let mut stack = vec![(0, m - 1)];
        while let Some((i, j)) = stack.pop() {
            if j - i < 3 {
                continue;
            }
            if j - i < m - 1 {
                choice.diagonals.push((i, j));
            }
            let k = split_one[at(i, j)] as usize;
            let l = split_two[at(k, j)] as usize;
            stack.extend([(i, k), (k, l), (l, j)]);
        }
        choice.diagonals.sort_by_key(|&(i, j)| (self.of(i, j), i, j));
        choice
    }
}

/// The trees of one search from all corners, joined where neighbouring ones meet.
struct Net {
    /// Vertices of C at branches, ends and corners; corners first.
    vertex: Vec<u32>,
    /// Neighbours of each, with the length and the number of the way there.
    ways: Vec<Vec<(usize, u64, usize)>>,
    /// Vertices along each way.
    inner: Vec<Vec<u32>>,
    /// By pair of corners: distance, and the vertex before the last on the way from the first.
    distance: Vec<u64>,
    before: Vec<Vec<(usize, usize)>>,
}

impl Net {
    fn grow(s: &CutSurface, units: &[u64], corners: &[u32], search: &mut Search) -> Self {
        let sources: Vec<(u32, u64)> = corners.iter().enumerate().map(|(k, &v)| (v, k as u64)).collect();
        search.spread(s, units, &sources, |_| false);
        // 1. The shortest bridge between each two trees.
        let mut bridges: BTreeMap<(u64, u64), (u64, u32, u32)> = BTreeMap::new();
        for &v in &search.settled {
            let (Some(d), Some(own)) = (search.distance(v), search.label(v)) else { continue };
            s.for_edges(v, |h, w| {
                let cost = crate::classes::cost_of(s, units, h);
                if let (Some(e), Some(other)) = (search.distance(w), search.label(w))
                    && own < other
                    && cost != FORBIDDEN
                {
                    let bridge = (d + cost + e, v, w);
                    let known = bridges.entry((own, other)).or_insert(bridge);
                    *known = bridge.min(*known);
                }
            });
        }
        // 2. Tree paths to their ends; branches are where several of them meet.
        let mut below: BTreeMap<u32, u32> = corners.iter().map(|&v| (v, 2)).collect();
        for &(_, a, b) in bridges.values() {
            for end in [a, b] {
                let mut v = end;
                while below.insert(v, below.get(&v).map_or(1, |n| n + 1)).is_none() {
                    match search.before(v) {
                        Some((up, _)) => v = up,
                        None => break,
                    }
                }
                *below.entry(end).or_default() += 1;
            }
        }
        // 3. Ways between branches.
        let mut vertex: Vec<u32> = corners.to_vec();
        vertex.extend(below.iter().filter(|(v, n)| **n > 1 && !corners.contains(v)).map(|(&v, _)| v));
        let number: HashMap<u32, usize> = vertex.iter().enumerate().map(|(k, &v)| (v, k)).collect();
        let mut net = Self {
            ways: vec![Vec::new(); vertex.len()],
            inner: Vec::new(),
            distance: Vec::new(),
            before: Vec::new(),
            vertex,
        };
        for k in corners.len()..net.vertex.len() {
            let from = net.vertex[k];
            let mut inner = Vec::new();
            let mut v = from;
            while let Some((up, _)) = search.before(v) {
                v = up;
                if number.contains_key(&v) {
                    break;
                }
                inner.push(v);
            }
            let length = search.distance(from).unwrap_or(0) - search.distance(v).unwrap_or(0);
            net.add_way(k, number[&v], length, inner);
        }
        for &(length, a, b) in bridges.values() {
            let ends = search.distance(a).unwrap_or(0) + search.distance(b).unwrap_or(0);
            net.add_way(number[&a], number[&b], length - ends, Vec::new());
        }
        (0..corners.len()).for_each(|k| net.search_from(k));
        net
    }

    fn add_way(&mut self, a: usize, b: usize, length: u64, inner: Vec<u32>) {
        let way = self.inner.len();
        self.inner.push(inner);
        self.ways[a].push((b, length, way));
        self.ways[b].push((a, length, way));
    }

    fn search_from(&mut self, start: usize) {
        let n = self.vertex.len();
        let mut distance = vec![u64::MAX; n];
        let mut before = vec![(usize::MAX, usize::MAX); n];
        distance[start] = 0;
        let mut heap = BinaryHeap::from([Reverse((0, start))]);
        while let Some(Reverse((d, v))) = heap.pop() {
            if d > distance[v] {
                continue;
            }
            for &(w, length, way) in &self.ways[v] {
                if d + length < distance[w] {
                    distance[w] = d + length;
                    before[w] = (v, way);
                    heap.push(Reverse((d + length, w)));
                }
            }
        }
        self.distance.extend(distance);
        self.before.push(before);
    }

    fn distances(&self, corners: usize) -> Distances {
        let n = self.vertex.len();
        let value = (0..corners).flat_map(|i| self.distance[i * n..i * n + corners].iter().copied()).collect();
        Distances { corners, value }
    }

    /// Vertices of the shortest way between two corners.
    fn walk(&self, from: usize, to: usize) -> Vec<u32> {
        let mut path = vec![self.vertex[to]];
        let mut at = to;
        while at != from {
            let (before, way) = self.before[from][at];
            if before == usize::MAX {
                break;
            }
            path.extend(&self.inner[way]);
            path.push(self.vertex[before]);
            at = before;
        }
        path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All quadrangulations of a polygon, by brute force.
    fn least(d: &Distances, polygon: &[usize]) -> u64 {
        let n = polygon.len();
        if n == 4 {
            return 0;
        }
        // The quadrangle at the polygon's first side.
        let mut best = u64::MAX;
        for k in (2..n).step_by(2) {
            for l in (k + 1..n).step_by(2) {
                let parts = [(1, k), (k, l), (l, n)];
                let total = parts.iter().map(|&(a, b)| {
                    let part: Vec<usize> = (a..=b).map(|i| polygon[i % n]).collect();
                    if part.len() == 2 { 0 } else { d.of(part[0], part[part.len() - 1]) + least(d, &part) }
                });
                best = best.min(total.sum());
            }
        }
        best
    }

    fn random_distances(corners: usize, seed: u64) -> Distances {
        let mut d = Distances { corners, value: vec![0; corners * corners] };
        for i in 0..corners {
            for j in i + 1..corners {
                let value = (1000.0 * quadloom_mesh::shapes::random(seed, (i * corners + j) as u64)) as u64;
                (d.value[i * corners + j], d.value[j * corners + i]) = (value, value);
            }
        }
        d
    }

    #[test]
    fn optimal_diagonals_are_those_of_brute_force() {
        for seed in 0..60 {
            let m = 4 + 2 * (seed as usize % 5);
            let d = random_distances(m, seed);
            let polygon: Vec<usize> = (0..m).collect();
            let choice = d.optimal();
            assert_eq!(choice.total, least(&d, &polygon), "seed {seed}, {m} corners");
            assert_eq!(choice.total, choice.diagonals.iter().map(|&(i, j)| d.of(i, j)).sum::<u64>());
            for choice in [choice, d.greedy()] {
                assert_eq!(choice.diagonals.len(), m / 2 - 2);
            }
            assert!(d.greedy().total >= d.optimal().total);
        }
    }
}
