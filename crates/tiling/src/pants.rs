//! Pants and cylinders ([Favreau2009] §2.4).
//!
//! In: a connected mesh of negative Euler characteristic. Out: a [`Cutting`] into −χ pairs of pants (genus 0, three
//! boundaries), or into three cylinders each as in [Favreau2009] Figure 4.
//! Holds: every cut is a shortest one of its kind where it is made; not: the shortest decomposition of all, whose
//! complexity is unknown ([ColinDeVerdiere2007]).
//!
//! Which loops are looked at: all whose homology class is neither zero nor that of one boundary. Where two boundaries
//! lie close together the shortest loop around both is not among those that a search from a point can close; on
//! surfaces without handles it is found between them and all others, joined by shortest paths, and the shorter of the
//! two candidates is cut.

use crate::classes::{Borders, Classes, classes};
use crate::cost::EdgeCosts;
use crate::cut_surface::{NONE, Walk};
use crate::cutting::{Cut, CutKind, CutOptions, Cutting, SearchMode};
use crate::error::TilingError;
use crate::search::Found;
use quadloom_mesh::{Progress, Summary, TriMesh};
use std::collections::{BTreeMap, BTreeSet};

/// A connected piece of C.
struct Piece {
    vertices: Vec<u32>,
    /// Half-edges of each border.
    borders: Vec<Vec<u32>>,
    genus: i64,
}

/// A pants decomposition by short loops.
///
/// # Output     a cutting into −χ tiles of genus 0 with three boundaries
/// # Errors     [`TilingError::NoPants`] for χ ≥ 0, [`TilingError::NoWay`], [`TilingError::Components`]
/// # Cost       fast: O(n log n) per cut; exact: a search from every vertex of a cut graph per cut
pub fn cut_into_pants<'a>(
    mesh: &'a TriMesh,
    costs: &'a EdgeCosts,
    options: &CutOptions,
    progress: &'a Progress,
) -> Result<Cutting<'a>, TilingError> {
    let mut cutting = Cutting::new(mesh, costs, progress)?;
    let summary = Summary::of(mesh);
    if summary.chi >= 0 {
        let Summary { chi, genus, boundary_loops: boundaries, .. } = summary;
        return Err(TilingError::NoPants { chi, genus, boundaries });
    }
    let mut roots = vec![0];
    let mut done = 0;
    while let Some(root) = roots.pop() {
        let piece = cutting.piece(root);
        if piece.genus == 0 && piece.borders.len() == 3 {
            done += 1;
            continue;
        }
        progress.check()?;
        progress.report("pants", f64::from(done) / -summary.chi as f64);
        cutting.cut_piece(&piece, options.search)?;
        // Both sides of the new cut; they may be one piece.
        let last = cutting.cuts.last().map_or(&[][..], |c| &c.points);
        let touched: BTreeSet<u32> = last.iter().copied().collect();
        let sides = cutting.surface.borders().into_iter().map(|border| border[0]);
        let new: Vec<u32> = sides
            .map(|h| cutting.surface.origin[h as usize])
            .filter(|&v| touched.contains(&cutting.surface.point[v as usize]))
            .collect();
        let mut seen: BTreeSet<u32> = BTreeSet::new();
        for v in new {
            if !seen.contains(&v) {
                seen.extend(cutting.piece(v).vertices);
                roots.push(v);
            }
        }
    }
    Ok(cutting)
}

/// Three cylinders from each pair of pants of a decomposition ([Favreau2009] Figure 4): two new nodes and three arcs
/// between them, so that every cylinder has one boundary of the pants and two of the arcs.
///
/// # Output     a cutting into −3χ tiles of genus 0 with two boundaries
/// # Errors     as [`cut_into_pants`]
/// # Cost       as [`cut_into_pants`], and O(n log n) per pair of pants
pub fn cut_into_cylinders<'a>(
    mesh: &'a TriMesh,
    costs: &'a EdgeCosts,
    options: &CutOptions,
    progress: &'a Progress,
) -> Result<Cutting<'a>, TilingError> {
    let mut cutting = cut_into_pants(mesh, costs, options, progress)?;
    let mut seen: BTreeSet<u32> = BTreeSet::new();
    let starts: Vec<u32> = cutting.surface.borders().iter().map(|b| cutting.surface.origin[b[0] as usize]).collect();
    let mut pieces = Vec::new();
    for v in starts {
        if !seen.contains(&v) {
            let piece = cutting.piece(v);
            seen.extend(&piece.vertices);
            pieces.push(piece);
        }
    }
    for piece in pieces {
        progress.check()?;
        cutting.cut_belts(&piece)?;
    }
    Ok(cutting)
}

impl Cutting<'_> {
    /// The piece of C to which a vertex belongs.
    fn piece(&self, root: u32) -> Piece {
        let s = &self.surface;
        let (mut seen, mut face_seen) = (vec![false; s.vertex_count()], vec![false; s.side.len()]);
        seen[root as usize] = true;
        let mut vertices = vec![root];
        let mut border_edges: BTreeSet<u32> = BTreeSet::new();
        let (mut faces, mut sides) = (0i64, 0i64);
        let mut at = 0;
        while at < vertices.len() {
            for h in s.fan(vertices[at]) {
                let face = s.face[h as usize];
                if !std::mem::replace(&mut face_seen[face as usize], true) {
                    faces += 1;
                    sides += s.sides(face).len() as i64;
                }
                if s.is_border(h) {
                    border_edges.insert(h);
                }
            }
            s.for_edges(vertices[at], |_, w| {
                if !std::mem::replace(&mut seen[w as usize], true) {
                    vertices.push(w);
                }
            });
            at += 1;
        }
        let mut borders = Vec::new();
        while let Some(first) = border_edges.pop_first() {
            let mut border = vec![first];
            let mut h = s.next_border(first);
            while h != first {
                border_edges.remove(&h);
                border.push(h);
                h = s.next_border(h);
            }
            borders.push(border);
        }
        let length: usize = borders.iter().map(Vec::len).sum();
        let edges = (sides + length as i64) / 2;
        let chi = vertices.len() as i64 - edges + faces;
        Piece { genus: (2 - chi - borders.len() as i64) / 2, vertices, borders }
    }

    /// Cuts a piece that is no pair of pants along a short loop.
    fn cut_piece(&mut self, piece: &Piece, mode: SearchMode) -> Result<(), TilingError> {
        let root = piece.vertices[0];
        let known = classes(&self.surface, &self.units, root, Borders::Kept, &[]);
        let loose = self.shortest_essential(piece, &known, mode);
        if piece.genus == 0 {
            let bound = loose.as_ref().map_or(u64::MAX, |f| f.length);
            if self.cut_around_two(piece, bound, mode)? {
                return Ok(());
            }
        }
        let found = loose.ok_or(TilingError::NoWay { what: "a loop between pants" })?;
        self.cut_loop(&found.walk)
    }

    /// The shortest loop whose class is neither zero nor that of one border, among those that searches can close.
    fn shortest_essential(&mut self, piece: &Piece, known: &Classes, mode: SearchMode) -> Option<Found> {
        let s = &self.surface;
        let class = &known.class;
        let trivial: BTreeSet<u64> = piece
            .borders
            .iter()
            .map(|border| border.iter().fold(0, |sum, &h| sum ^ class[h as usize]))
            .chain([0])
            .collect();
        // Bases: ends of edges that close loops at the root, then all vertices on the way to them.
        let mut bases: Vec<u32> = known.closing.iter().map(|&h| s.origin[h as usize]).collect();
        let mut on_way: BTreeSet<u32> = BTreeSet::new();
        for &h in &known.closing {
            for mut v in [s.origin[h as usize], s.target(h)] {
                while on_way.insert(v) && known.parent[v as usize].0 != NONE {
                    v = known.parent[v as usize].0;
                }
            }
        }
        bases.extend(on_way);
        let mut best: Option<Found> = None;
        for base in bases {
            let bound = best.as_ref().map_or(u64::MAX, |f| f.length);
            let is_trivial = |c: u64| trivial.contains(&c);
            if let Some(found) = self.search.shortest_loop(s, &self.units, class, base, bound, is_trivial) {
                best = Some(found);
                if mode == SearchMode::Fast {
                    break;
                }
            }
        }
        best
    }

    /// Cuts along the shortest loop around the two borders that are nearest to each other, if it is below a bound.
    ///
    /// These two are joined by a shortest path, and so are all others with each other; between the two borders that
    /// are left the shortest loop is one that a search can close. Then the paths are healed.
    fn cut_around_two(&mut self, piece: &Piece, bound: u64, mode: SearchMode) -> Result<bool, TilingError> {
        let before = self.surface.clone();
        let joined = self.join_all_but_two(piece)?;
        let Some(seams) = joined else {
            self.surface = before;
            return Ok(false);
        };
        let root = self.surface.origin[seams[0][0] as usize];
        let known = classes(&self.surface, &self.units, root, Borders::Kept, &[]);
        // Every loop that counts crosses a shortest path between the two borders.
        let annulus = self.piece(root);
        let labels: Vec<(u32, u64)> = self.border_sources(&annulus.borders);
        let across = self.search.connect(&self.surface, &self.units, &labels, u64::MAX);
        let across = across.map(|f| f.walk.vertices).unwrap_or_default();
        let bases = match mode {
            SearchMode::Exact => across,
            SearchMode::Fast => across.get(across.len() / 2).copied().into_iter().collect(),
        };
        let mut best: Option<Found> = None;
        for base in bases {
            let limit = best.as_ref().map_or(bound, |f| f.length);
            let (s, units) = (&self.surface, &self.units);
            if let Some(found) = self.search.shortest_loop(s, units, &known.class, base, limit, |c| c == 0) {
                best = Some(found);
            }
        }
        match best {
            Some(found) => {
                self.cut_loop(&found.walk)?;
                seams.iter().for_each(|seam| self.surface.heal(seam));
                Ok(true)
            }
            None => {
                self.surface = before;
                Ok(false)
            }
        }
    }

    /// Vertices of borders, labelled by border.
    fn border_sources(&self, borders: &[Vec<u32>]) -> Vec<(u32, u64)> {
        let s = &self.surface;
        let vertices = |(k, border): (usize, &Vec<u32>)| -> Vec<(u32, u64)> {
            border.iter().map(|&h| (s.origin[h as usize], k as u64)).collect()
        };
        borders.iter().enumerate().flat_map(vertices).collect()
    }

    /// Joins the two nearest borders of a piece, and all others with each other.
    ///
    /// # Output     half-edges of each path; `None` where there is no way
    fn join_all_but_two(&mut self, piece: &Piece) -> Result<Option<Vec<Vec<u32>>>, TilingError> {
        let sources = self.border_sources(&piece.borders);
        let Some(nearest) = self.search.connect(&self.surface, &self.units, &sources, u64::MAX) else {
            return Ok(None);
        };
        let label: BTreeMap<u32, u64> = sources.iter().copied().collect();
        let pair = [nearest.walk.vertices[0], nearest.walk.last()].map(|v| label.get(&v).copied());
        let mut seams = vec![self.seam(&nearest.walk)?];
        // The others, by their half-edges: borders change as they are joined, and two sides of a cut share points.
        let others: Vec<usize> = (0..piece.borders.len()).filter(|&k| !pair.contains(&Some(k as u64))).collect();
        let group: BTreeSet<u32> = others.iter().flat_map(|&k| piece.borders[k].iter().copied()).collect();
        for _ in 1..others.len() {
            let borders = self.piece(piece.vertices[0]).borders;
            let is_other = |border: &&Vec<u32>| border.iter().any(|h| group.contains(h));
            let chosen: Vec<Vec<u32>> = borders.iter().filter(is_other).cloned().collect();
            let sources = self.border_sources(&chosen);
            match self.search.connect(&self.surface, &self.units, &sources, u64::MAX) {
                Some(found) => seams.push(self.seam(&found.walk)?),
                None => return Ok(None),
            }
        }
        Ok(Some(seams))
    }

    /// Cuts along a walk for the time being; its half-edges, at least two.
    fn seam(&mut self, walk: &Walk) -> Result<Vec<u32>, TilingError> {
        let mut path = self.surface.pull_off(walk)?;
        if let [h] = path[..] {
            let from = self.surface.origin[h as usize];
            let base = self.surface.base_of(from);
            self.surface.split_edge(h, base, from);
            path.push(self.surface.next[h as usize]);
        }
        self.surface.cut(&path)?;
        Ok(path)
    }

    /// Cuts a pair of pants into three cylinders.
    fn cut_belts(&mut self, pants: &Piece) -> Result<(), TilingError> {
        // 1. Three seams between the borders leave two hexagons.
        let border_of: BTreeMap<u32, usize> =
            pants.borders.iter().enumerate().flat_map(|(k, border)| border.iter().map(move |&h| (h, k))).collect();
        let mut seams = Vec::new();
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let piece = self.piece(self.surface.origin[pants.borders[0][0] as usize]);
            let s = &self.surface;
            let end = |&h: &u32| {
                let border = border_of.get(&h).copied().filter(|k| [a, b].contains(k));
                border.map(|k| (s.origin[h as usize], k as u64))
            };
            let sources: Vec<(u32, u64)> = piece.borders.iter().flatten().filter_map(end).collect();
            let found = self.search.connect(s, &self.units, &sources, u64::MAX);
            let found = found.ok_or(TilingError::NoWay { what: "a seam between two boundaries of pants" })?;
            seams.push(self.seam(&found.walk)?);
        }
        // 2. From the middle of each seam an arc to the centre of either hexagon.
        let middles: Vec<u32> = seams.iter().map(|p| self.surface.origin[p[p.len() / 2] as usize]).collect();
        let middle_points = self.surface.points(&middles);
        let mut halves: Vec<Vec<(Vec<u32>, f64)>> = Vec::new();
        for side in [false, true] {
            let h = seams[0][seams[0].len() / 2];
            let h = if side { self.surface.mate[h as usize] } else { h };
            halves.push(self.cut_spokes(h, &middle_points)?);
        }
        // 3. Arcs between the centres, and the seams closed.
        for (first, second) in halves[0].iter().zip(&halves[1]) {
            let mut points: Vec<u32> = first.0.iter().rev().copied().collect();
            points.extend(&second.0[1..]);
            self.cuts.push(Cut { kind: CutKind::Belt, cost: first.1 + second.1, points });
        }
        seams.iter().for_each(|seam| self.surface.heal(seam));
        Ok(())
    }

    /// Joins points on the border of a disk with its centre; for each the points of the cut, and its cost.
    fn cut_spokes(&mut self, inside: u32, ends: &[u32]) -> Result<Vec<(Vec<u32>, f64)>, TilingError> {
        // 1. The vertex farthest from the border, or a new one.
        let disk = self.piece(self.surface.origin[inside as usize]);
        let sources: Vec<(u32, u64)> = self.border_sources(&disk.borders);
        self.search.spread(&self.surface, &self.units, &sources, |_| false);
        let inner = self.search.settled.iter().rev().copied().find(|&v| !self.surface.on_border(v));
        let centre = match inner {
            Some(v) => v,
            None => {
                let from = self.surface.origin[inside as usize];
                let (face, base) = (self.surface.face[inside as usize], self.surface.base_of(from));
                self.surface.star_face(face, base, from)
            }
        };
        let centre_point = self.surface.point[centre as usize];
        // 2. Paths to it; after the first it has several vertices.
        let mut members: BTreeSet<u32> = disk.vertices.into_iter().collect();
        let mut spokes = Vec::new();
        for &end in ends {
            let s = &self.surface;
            let start: Vec<u32> =
                members.iter().copied().filter(|&v| s.out[v as usize] != NONE && s.point[v as usize] == end).collect();
            let is_centre = |v: u32| s.point[v as usize] == centre_point;
            let found = self.search.path(s, &self.units, &start, u64::MAX, is_centre);
            let walk = found.ok_or(TilingError::NoWay { what: "an arc around pants" })?.walk;
            let cost = self.cost_of_walk(&walk);
            let before = self.surface.vertex_count() as u32;
            spokes.push((self.surface.cut_walk(&walk)?, cost));
            members.extend(before..self.surface.vertex_count() as u32);
        }
        Ok(spokes)
    }
}
