//! Elastic ropes between stars: the state that relaxation moves.
//!
//! In: a map, a symmetry, a start. Out: [`Ropes`] that pull, stiffen and push each other apart, one step at a time.
//! Holds after every step: the first points of the edges at a vertex are the tips of an even star in the map's order, so
//! a skeleton made of them passes its check; the symmetry to rounding, because only the first point of each orbit is moved
//! and the others follow. Not: that ropes do not pass through each other while contact is soft.
//! Source: [Razafindrazaka2015] §9.4: springs, repulsion, the plane constraint at junctions; differs: the constraint is a
//! fit of a rigid star (plane, turn, slope) to where its tips would go, not a force.
//!
//! | letter | meaning, unit: the ropes' diameter |
//! |---|---|
//! | x | points: the vertices, then the inner points of each edge |
//! | h | radius of stars: there, spokes in a plane are one diameter apart |
//! | s | distance from the nearer vertex along a rope |

use super::symmetry::{Imposed, Orbits};
use super::{Skeleton, edge_flags, first_flags, other_end, starts_here};
use glam::{DMat3, DVec3};
use quadloom_mesh::Id;
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::{Reflection, RegularMap};
use std::f64::consts::{PI, TAU};

/// Largest sine of the slope of a star's spokes against its plane: a little more than at the corners of the regular solids
/// with 3, 4 and 5 edges at a corner. Steeper spokes part late, and a plane of the junction can hardly be seen.
fn steepest(valence: usize) -> f64 {
    match valence {
        ..=3 => 0.82,
        4 => 0.71,
        5 => 0.6,
        _ => 0.5,
    }
}

/// How much stiffer ropes are at the tips of stars: spokes are long where many edges meet, and a rope that turns back at
/// one leaves no room for a tube.
const TIP: f64 = 3.0;

/// Reach of repulsion in diameters; the volume looked at grows with its third power.
const REACH: f64 = 2.0;

/// Largest step of a point, diameters: two ropes that meet head-on stop each other before they have passed.
const LONGEST_STEP: f64 = 0.12;

/// Strengths of the forces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forces {
    /// Springs between neighbours on a rope.
    pub tension: f64,
    /// Against bends.
    pub stiffness: f64,
    /// Push of ropes that overlap.
    pub contact: f64,
    /// Push of ropes within [`REACH`] diameters.
    pub near: f64,
    /// Inverse square push between vertices and midpoints of edges.
    pub far: f64,
    /// Step length.
    pub step: f64,
    /// Part of the velocity that is kept.
    pub momentum: f64,
}

/// Which point is what.
pub(super) struct Layout {
    pub vertices: usize,
    pub edges: usize,
    /// Inner points per edge.
    pub inner: usize,
    /// Vertices at the ends of each edge.
    pub ends: Vec<[u32; 2]>,
    /// First points of the edges at each vertex, counter-clockwise.
    pub tips: Vec<Vec<u32>>,
    /// For each edge, its smallest flag.
    flags: Vec<FlagId>,
    valence: usize,
}

impl Layout {
    pub fn new(map: &RegularMap, inner: usize) -> Self {
        let vertices = map.vertex_count();
        let tip = |flag: FlagId| {
            let start = vertices + map.edge(flag).index() * inner;
            (if starts_here(map, flag) { start } else { start + inner - 1 }) as u32
        };
        let around = |first: FlagId| {
            let mut flag = first;
            let mut tips = Vec::with_capacity(map.q());
            for _ in 0..map.q() {
                tips.push(tip(flag));
                flag = map.walk(flag, &[Reflection::R1, Reflection::R2]);
            }
            tips
        };
        let flags: Vec<_> = edge_flags(map).into_iter().map(|(_, flag)| flag).collect();
        Self {
            vertices,
            edges: map.edge_count(),
            inner,
            ends: flags.iter().map(|&f| [map.vertex(f).0, other_end(map, f).0]).collect(),
            tips: first_flags(map).into_iter().map(|(_, flag)| around(flag)).collect(),
            flags,
            valence: map.q(),
        }
    }

    pub fn count(&self) -> usize {
        self.vertices + self.edges * self.inner
    }

    /// The points of an edge, ends included.
    pub fn rope(&self, edge: usize) -> impl DoubleEndedIterator<Item = usize> + use<> {
        let [a, b] = self.ends[edge];
        let start = self.vertices + edge * self.inner;
        std::iter::once(a as usize).chain(start..start + self.inner).chain(std::iter::once(b as usize))
    }

    /// Where an automorphism takes each point.
    fn images(&self, map: &RegularMap, h: FlagId) -> Vec<u32> {
        let image = map.automorphism(h);
        let mut to: Vec<u32> = first_flags(map).iter().map(|&(_, f)| map.vertex(image[f.index()]).0).collect();
        for &flag in &self.flags {
            let there = image[flag.index()];
            let start = self.vertices + map.edge(there).index() * self.inner;
            let forward = starts_here(map, there);
            to.extend((0..self.inner).map(|i| (start + if forward { i } else { self.inner - 1 - i }) as u32));
        }
        to
    }

    fn orbits(&self, map: &RegularMap, imposed: &Imposed) -> Orbits {
        let images: Vec<_> = imposed.elements.iter().map(|&(h, _)| self.images(map, h)).collect();
        // Tips follow those at the vertices that are moved, because stars are fitted there.
        let mut first = vec![true; self.vertices];
        let mut order: Vec<u32> = (0..self.vertices as u32).collect();
        for v in 0..self.vertices {
            if first[v] {
                images.iter().map(|image| image[v] as usize).filter(|&w| w != v).for_each(|w| first[w] = false);
                order.extend(&self.tips[v]);
            }
        }
        order.extend(self.vertices as u32..self.count() as u32);
        Orbits::new(imposed, &images, order.into_iter())
    }
}

/// What a point knows about its place on its rope.
#[derive(Clone, Copy)]
struct Site {
    edge: u32,
    /// Nearer end.
    vertex: u32,
    /// Distance from there and from the start.
    s: f64,
    arc: f64,
}

/// Points with velocities.
pub(super) struct Ropes<'a> {
    pub layout: &'a Layout,
    rotations: Vec<DMat3>,
    pub orbits: Orbits,
    pub x: Vec<DVec3>,
    velocity: Vec<DVec3>,
    normals: Vec<DVec3>,
    spoke: f64,
    /// Radius of stars.
    pub h: f64,
    /// Largest sine of the slope of their spokes.
    steepest: f64,
}

impl<'a> Ropes<'a> {
    /// Ropes at these places, brought into the symmetry.
    ///
    /// # Input      `slope`: of stars at most, as a share of the largest
    pub fn new(map: &RegularMap, layout: &'a Layout, imposed: &Imposed, slope: f64, x: Vec<DVec3>) -> Self {
        let spoke = (PI / layout.valence as f64).sin();
        let mut ropes = Self {
            layout,
            rotations: imposed.elements.iter().map(|(_, m)| *m).collect(),
            orbits: layout.orbits(map, imposed),
            velocity: vec![DVec3::ZERO; x.len()],
            normals: vec![DVec3::ZERO; layout.vertices],
            x,
            spoke,
            h: 0.55 / spoke,
            steepest: slope * steepest(layout.valence),
        };
        ropes.settle();
        ropes
    }

    /// One step of descent.
    pub fn advance(&mut self, forces: &Forces) {
        let force = self.forces(forces);
        for &(i, _) in &self.orbits.firsts {
            let i = i as usize;
            let step = forces.momentum * self.velocity[i] + forces.step * force[i];
            self.velocity[i] = step.clamp_length_max(LONGEST_STEP);
            self.x[i] += self.velocity[i];
        }
        self.settle();
    }

    /// Moves points at random.
    pub fn shake(&mut self, mut by: impl FnMut() -> DVec3) {
        for &(i, _) in &self.orbits.firsts {
            self.x[i as usize] += by();
        }
        self.settle();
    }

    /// Symmetry, then stars, then symmetry: stars are made of symmetric points.
    fn settle(&mut self) {
        self.follow();
        for k in 0..self.orbits.firsts.len() {
            let vertex = self.orbits.firsts[k].0 as usize;
            if vertex < self.layout.vertices {
                self.fit_star(vertex);
            }
        }
        self.follow();
    }

    fn follow(&mut self) {
        for &(i, projector) in &self.orbits.firsts {
            if let Some(projector) = projector {
                self.x[i as usize] = projector * self.x[i as usize];
            }
        }
        for i in 0..self.x.len() {
            let (first, h) = self.orbits.from[i];
            if first as usize != i {
                self.x[i] = self.rotations[h as usize] * self.x[first as usize];
            }
        }
    }

    /// Puts the tips at a vertex on the even star that is closest to them ([Razafindrazaka2015] §9.4, plane constraint).
    fn fit_star(&mut self, vertex: usize) {
        let tips = &self.layout.tips[vertex];
        let q = tips.len() as f64;
        let angle = |k: usize| (TAU * k as f64 / q).sin_cos();
        let (mut a, mut b, mut sum) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for (k, &tip) in tips.iter().enumerate() {
            let d = self.x[tip as usize] - self.x[vertex];
            let (sin, cos) = angle(k);
            a += cos * d;
            b += sin * d;
            sum += d;
        }
        let [u, w] = nearest_frame(a, b, self.normals[vertex]);
        let normal = u.cross(w);
        let slope = (-sum.dot(normal) / (q * self.h)).clamp(-self.steepest, self.steepest);
        let flat = (1.0 - slope * slope).sqrt();
        let centre = self.x[vertex] + (sum + q * self.h * slope * normal) / (q + 1.0);
        for (k, &tip) in tips.iter().enumerate() {
            let (sin, cos) = angle(k);
            self.x[tip as usize] = centre + self.h * (flat * (cos * u + sin * w) - slope * normal);
        }
        self.x[vertex] = centre;
        self.normals[vertex] = normal;
    }

    fn forces(&self, forces: &Forces) -> Vec<DVec3> {
        let mut f = vec![DVec3::ZERO; self.x.len()];
        for edge in 0..self.layout.edges {
            self.pull(edge, forces, &mut f);
        }
        self.push_near(forces, &mut f);
        self.push_far(forces, &mut f);
        f
    }

    /// Springs and stiffness of one rope.
    fn pull(&self, edge: usize, forces: &Forces, f: &mut [DVec3]) {
        let start = self.layout.vertices + edge * self.layout.inner;
        let end = start + self.layout.inner - 1;
        for i in start..end {
            let d = forces.tension * (self.x[i + 1] - self.x[i]);
            f[i] += d;
            f[i + 1] -= d;
        }
        for i in start + 1..end {
            let bend = forces.stiffness * (self.x[i - 1] + self.x[i + 1] - 2.0 * self.x[i]);
            f[i] += 2.0 * bend;
            f[i - 1] -= bend;
            f[i + 1] -= bend;
        }
        let [v, w] = self.layout.ends[edge];
        for (vertex, tip, next) in [(v, start, start + 1), (w, end, end - 1)] {
            let spoke = self.x[tip] - self.x[vertex as usize];
            let out = self.x[next] - self.x[tip];
            let bend = TIP * forces.stiffness * (out - spoke * (out.length() / self.h));
            f[next] -= bend;
            f[tip] += 2.0 * bend;
        }
    }

    fn sites(&self) -> Vec<Site> {
        let layout = self.layout;
        let own = |v: u32| Site { edge: u32::MAX, vertex: v, s: 0.0, arc: 0.0 };
        let mut sites: Vec<_> = (0..layout.vertices as u32).map(own).collect();
        for edge in 0..layout.edges {
            let mut arcs = Vec::with_capacity(layout.inner + 2);
            let mut arc = 0.0;
            let mut before: Option<DVec3> = None;
            for i in layout.rope(edge) {
                arc += before.map_or(0.0, |p| p.distance(self.x[i]));
                before = Some(self.x[i]);
                arcs.push(arc);
            }
            for &at in &arcs[1..=layout.inner] {
                let side = usize::from(at > arc - at);
                let vertex = layout.ends[edge][side];
                sites.push(Site { edge: edge as u32, vertex, s: at.min(arc - at), arc: at });
            }
        }
        sites
    }

    /// The distance that two points should keep, of at most one diameter.
    fn wanted(&self, a: &Site, b: &Site) -> f64 {
        let mut wanted = 1.0f64;
        if a.vertex == b.vertex {
            // Slanted spokes are closer than flat ones.
            wanted = wanted.min(1.5 * self.spoke * a.s.min(b.s));
        }
        if a.edge == b.edge {
            wanted = wanted.min(0.55 * (a.arc - b.arc).abs());
        }
        wanted
    }

    /// Repulsion of points that are no neighbours.
    fn push_near(&self, forces: &Forces, f: &mut [DVec3]) {
        let sites = self.sites();
        let grid = Grid::new(&self.x, REACH);
        for &(i, _) in &self.orbits.firsts {
            let i = i as usize;
            let mut sum = DVec3::ZERO;
            grid.around(self.x[i], |j| {
                let d = self.x[i] - self.x[j];
                let square = d.length_squared();
                if i == j || square > REACH * REACH {
                    return;
                }
                let wanted = self.wanted(&sites[i], &sites[j]);
                let distance = square.sqrt().max(1e-9);
                if distance < REACH * wanted {
                    let tail = 1.0 - distance / (REACH * wanted);
                    let overlap = (1.0 - distance / wanted).max(0.0);
                    sum += d / distance * (forces.near * tail * tail + forces.contact * overlap) * wanted;
                }
            });
            f[i] += sum;
        }
    }

    /// Repulsion between vertices and midpoints; a vertex takes its star along.
    fn push_far(&self, forces: &Forces, f: &mut [DVec3]) {
        let layout = self.layout;
        let middle = |edge: usize| layout.vertices + edge * layout.inner + layout.inner / 2;
        let coarse: Vec<usize> = (0..layout.vertices).chain((0..layout.edges).map(middle)).collect();
        for &(i, _) in &self.orbits.firsts {
            let i = i as usize;
            let inner = (i.max(layout.vertices) - layout.vertices) % layout.inner;
            if i >= layout.vertices && inner != layout.inner / 2 {
                continue;
            }
            let push = |&j: &usize| {
                let d = self.x[i] - self.x[j];
                d / (d.length_squared() + 0.25).powf(1.5)
            };
            let sum = forces.far * coarse.iter().map(push).sum::<DVec3>();
            f[i] += sum;
            if i < layout.vertices {
                layout.tips[i].iter().for_each(|&tip| f[tip as usize] += sum);
            }
        }
    }

    /// The skeleton of these ropes.
    pub fn skeleton(&self) -> Skeleton {
        let layout = self.layout;
        let mut normals = vec![DVec3::ZERO; layout.vertices];
        for (vertex, normal) in normals.iter_mut().enumerate() {
            *normal = self.normal(vertex);
        }
        let edge = |e: usize| layout.rope(e).map(|i| self.x[i]).collect();
        let edges = (0..layout.edges).map(edge).collect();
        Skeleton { positions: self.x[..layout.vertices].to_vec(), normals, edges }
    }

    /// From the tips themselves: at vertices that follow others, too.
    fn normal(&self, vertex: usize) -> DVec3 {
        let tips = &self.layout.tips[vertex];
        let spokes: Vec<_> = tips.iter().map(|&tip| self.x[tip as usize] - self.x[vertex]).collect();
        let n = spokes.len();
        (0..n).map(|k| spokes[k].cross(spokes[(k + 1) % n])).sum::<DVec3>().normalize_or(DVec3::Z)
    }
}

/// The orthonormal pair closest to two vectors; where they are parallel, one in the plane across the old normal.
fn nearest_frame(a: DVec3, b: DVec3, old: DVec3) -> [DVec3; 2] {
    let (aa, ab, bb) = (a.length_squared(), a.dot(b), b.length_squared());
    let root = (aa * bb - ab * ab).max(0.0).sqrt();
    if root <= 1e-9 * (aa + bb) || !root.is_finite() {
        let u = if aa >= bb { a } else { b }.normalize_or(perpendicular(old));
        let w = old.cross(u).normalize_or(u.any_orthonormal_vector());
        return if aa >= bb { [u, w] } else { [-w, u] };
    }
    // Inverse of the root of the Gram matrix, up to a factor.
    let u = (a * (bb + root) - b * ab).normalize();
    let w = (b * (aa + root) - a * ab).normalize();
    [u, w]
}

fn perpendicular(normal: DVec3) -> DVec3 {
    if normal.length_squared() > 0.5 { normal.any_orthonormal_vector() } else { DVec3::X }
}

/// Points by cubes of space.
struct Grid {
    low: DVec3,
    size: f64,
    cells: [usize; 3],
    /// Points of cell k: `points[starts[k]..starts[k + 1]]`.
    starts: Vec<u32>,
    points: Vec<u32>,
}

/// Cubes per direction at most; farther points share the last ones.
const MOST_CELLS: f64 = 40.0;

impl Grid {
    fn new(x: &[DVec3], size: f64) -> Self {
        let low = x.iter().copied().fold(DVec3::splat(f64::INFINITY), DVec3::min);
        let high = x.iter().copied().fold(DVec3::splat(f64::NEG_INFINITY), DVec3::max);
        let size = size.max((high - low).max_element() / MOST_CELLS);
        let cells = ((high - low) / size).to_array().map(|c| c as usize + 1);
        let mut grid = Self { low, size, cells, starts: vec![0; cells.iter().product::<usize>() + 1], points: vec![] };
        let of: Vec<_> = x.iter().map(|&p| grid.cell(grid.coordinates(p))).collect();
        of.iter().for_each(|&c| grid.starts[c + 1] += 1);
        for k in 1..grid.starts.len() {
            grid.starts[k] += grid.starts[k - 1];
        }
        let mut next = grid.starts.clone();
        grid.points = vec![0; x.len()];
        for (i, &c) in of.iter().enumerate() {
            grid.points[next[c] as usize] = i as u32;
            next[c] += 1;
        }
        grid
    }

    fn coordinates(&self, p: DVec3) -> [usize; 3] {
        let c = ((p - self.low) / self.size).to_array();
        [0, 1, 2].map(|k| (c[k].max(0.0) as usize).min(self.cells[k] - 1))
    }

    fn cell(&self, [a, b, c]: [usize; 3]) -> usize {
        (a * self.cells[1] + b) * self.cells[2] + c
    }

    /// All points within one cube's size, and more, in a fixed order.
    fn around(&self, p: DVec3, mut visit: impl FnMut(usize)) {
        let at = self.coordinates(p);
        let range = |k: usize| at[k].saturating_sub(1)..=(at[k] + 1).min(self.cells[k] - 1);
        for a in range(0) {
            for b in range(1) {
                let first = self.cell([a, b, *range(2).start()]);
                let last = self.cell([a, b, *range(2).end()]);
                let points = &self.points[self.starts[first] as usize..self.starts[last + 1] as usize];
                points.iter().for_each(|&j| visit(j as usize));
            }
        }
    }
}
