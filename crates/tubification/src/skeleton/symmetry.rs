//! Rotations of space that a skeleton can have: groups of automorphisms of its map that act as point groups.
//!
//! In: a map. Out: [`Imposed`]: automorphisms and their rotations.
//! Holds: the rotations are a faithful image of the automorphisms; what an automorphism does at a vertex or an edge that it
//! keeps, its rotation can do to a junction or a tube; vertices and edges that are different can lie in different places.
//! Not: that tubes with this symmetry are thick. Mirror images of a map are rotations as well: composed with an exchange of
//! front and back they keep the tube surface.
//! Source: [Razafindrazaka2015] §9.6 (symmetry of skeletons, there by hand).
//!
//! Automorphism h takes vertex v to hv and its junction's normal n to ρ(h)n where it takes upright flags to upright ones,
//! else to −ρ(h)n. So where h keeps v, ρ(h) is the rotation by 2πk/q about n for h = S^k, and a half-turn about a line of
//! the junction's plane for a reflection.

use super::{edge_flags, first_flags};
use glam::{DMat3, DVec3};
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::{Reflection, RegularMap};
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::fmt;
use std::str::FromStr;

/// A finite group of rotations of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PointGroup {
    /// Cₙ: n-fold rotations about one axis.
    Cyclic(usize),
    /// Dₙ: those and half-turns about n axes across, n at least 2.
    Dihedral(usize),
    /// T: the rotations of a tetrahedron.
    Tetrahedral,
    /// O: the rotations of an octahedron.
    Octahedral,
    /// I: the rotations of an icosahedron.
    Icosahedral,
}

impl PointGroup {
    /// Number of rotations.
    pub fn order(self) -> usize {
        match self {
            Self::Cyclic(n) => n,
            Self::Dihedral(n) => 2 * n,
            Self::Tetrahedral => 12,
            Self::Octahedral => 24,
            Self::Icosahedral => 60,
        }
    }

    /// Orders of two generators a and b and of ab; all relations follow from them.
    fn triple(self) -> [usize; 3] {
        match self {
            Self::Cyclic(n) => [n, 1, n],
            Self::Dihedral(n) => [2, 2, n],
            Self::Tetrahedral => [2, 3, 3],
            Self::Octahedral => [2, 3, 4],
            Self::Icosahedral => [2, 3, 5],
        }
    }

    /// Rotations that satisfy the relations of the triple.
    fn generators(self) -> [DMat3; 2] {
        let [a, b, ab] = self.triple();
        match self {
            Self::Cyclic(n) => [DMat3::from_rotation_z(TAU / n as f64), DMat3::IDENTITY],
            Self::Dihedral(n) => {
                let turn = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
                [turn, turn * DMat3::from_rotation_z(TAU / n as f64)]
            }
            _ => {
                debug_assert_eq!((a, b), (2, 3));
                // b turns about z; the trace of ab, 1 + 2cos(2π/k), is 3z² − 1 for a half-turn about (x, 0, z).
                let z = ((2.0 + 2.0 * (TAU / ab as f64).cos()) / 3.0).sqrt();
                let axis = DVec3::new((1.0 - z * z).sqrt(), 0.0, z);
                let turn = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z) * 2.0 - DMat3::IDENTITY;
                [turn, DMat3::from_rotation_z(TAU / 3.0)]
            }
        }
    }
}

impl fmt::Display for PointGroup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cyclic(n) => write!(f, "C{n}"),
            Self::Dihedral(n) => write!(f, "D{n}"),
            Self::Tetrahedral => f.write_str("T"),
            Self::Octahedral => f.write_str("O"),
            Self::Icosahedral => f.write_str("I"),
        }
    }
}

impl FromStr for PointGroup {
    type Err = String;

    /// Reads T, O, I, C followed by a number, D followed by a number of at least 2.
    fn from_str(text: &str) -> Result<Self, String> {
        let number = |digits: &str, least: usize| digits.parse().ok().filter(|&n: &usize| n >= least);
        let found = match text {
            "T" => Some(Self::Tetrahedral),
            "O" => Some(Self::Octahedral),
            "I" => Some(Self::Icosahedral),
            _ if text.starts_with('C') => number(&text[1..], 1).map(Self::Cyclic),
            _ if text.starts_with('D') => number(&text[1..], 2).map(Self::Dihedral),
            _ => None,
        };
        found.ok_or_else(|| format!("{text:?} is no group of rotations; those are T, O, I, C1, C2, … and D2, D3, …"))
    }
}

/// A group of automorphisms of a map and how they rotate space.
#[derive(Clone, Debug, PartialEq)]
pub struct Imposed {
    /// Which group it is.
    pub group: PointGroup,
    /// Each automorphism, as the flag that it takes flag 0 to, and its rotation about the origin; the identity first.
    pub elements: Vec<(FlagId, DMat3)>,
}

impl Imposed {
    /// The identity alone.
    pub fn trivial() -> Self {
        Self { group: PointGroup::Cyclic(1), elements: vec![(FlagId(0), DMat3::IDENTITY)] }
    }
}

/// The symmetries that a skeleton of this map can have, up to conjugation, largest groups first.
///
/// # Input      wanted: this group alone; at_most: a bound on the number of groups of one kind
/// # Output     without the trivial group
/// # Cost       (conjugacy classes) × (flags) products for each kind of group
pub fn symmetries(map: &RegularMap, wanted: Option<PointGroup>, at_most: usize) -> Vec<Imposed> {
    let group = Elements::new(map);
    let kinds = match wanted {
        Some(kind) => vec![kind],
        None => group.kinds(),
    };
    let cells = Cells::new(map);
    let mut found = Vec::new();
    for kind in kinds.into_iter().filter(|kind| kind.order() > 1) {
        found.extend(group.representations(map, &cells, kind, at_most));
    }
    found.sort_by_key(|imposed| std::cmp::Reverse(imposed.group.order()));
    found
}

/// Vertices and edges of a map by one flag each.
struct Cells {
    vertices: Vec<FlagId>,
    edges: Vec<FlagId>,
}

impl Cells {
    fn new(map: &RegularMap) -> Self {
        let vertices = first_flags(map).into_iter().map(|(_, flag)| flag).collect();
        Self { vertices, edges: edge_flags(map).into_iter().map(|(_, flag)| flag).collect() }
    }
}

/// The group of a map with what is asked of its elements again and again.
struct Elements {
    orders: Vec<usize>,
    words: Vec<Vec<Reflection>>,
    inverses: Vec<FlagId>,
    /// One element of each conjugacy class.
    classes: Vec<FlagId>,
}

impl Elements {
    fn new(map: &RegularMap) -> Self {
        let words: Vec<_> = map.flags().map(|g| map.reflections_of(g)).collect();
        let orders = map.flags().map(|g| map.order_of(g)).collect();
        let inverses = map.flags().map(|g| map.inverse(g)).collect();
        let mut group = Self { orders, words, inverses, classes: Vec::new() };
        group.classes = group.class_representatives(map);
        group
    }

    fn product(&self, map: &RegularMap, g: FlagId, h: FlagId) -> FlagId {
        map.walk(g, &self.words[h.0 as usize])
    }

    fn order(&self, g: FlagId) -> usize {
        self.orders[g.0 as usize]
    }

    fn class_representatives(&self, map: &RegularMap) -> Vec<FlagId> {
        let mut seen = vec![false; map.order()];
        let mut found = Vec::new();
        for start in map.flags() {
            if std::mem::replace(&mut seen[start.0 as usize], true) {
                continue;
            }
            found.push(start);
            let mut stack = vec![start];
            while let Some(g) = stack.pop() {
                for by in Reflection::ALL {
                    let conjugate = map.reflect(self.product(map, map.reflect(FlagId(0), by), g), by);
                    if !std::mem::replace(&mut seen[conjugate.0 as usize], true) {
                        stack.push(conjugate);
                    }
                }
            }
        }
        found
    }

    /// Kinds of groups whose generators' orders occur.
    fn kinds(&self) -> Vec<PointGroup> {
        let orders: BTreeSet<_> = self.orders.iter().copied().filter(|&n| n > 1).collect();
        let polyhedral = [PointGroup::Icosahedral, PointGroup::Octahedral, PointGroup::Tetrahedral];
        let mut kinds: Vec<_> =
            polyhedral.into_iter().filter(|kind| kind.triple().iter().all(|n| orders.contains(n))).collect();
        kinds.extend(orders.iter().map(|&n| PointGroup::Dihedral(n)));
        kinds.extend(orders.iter().map(|&n| PointGroup::Cyclic(n)));
        kinds
    }

    /// Faithful images in the rotations of space that a skeleton can have, up to conjugation.
    fn representations(&self, map: &RegularMap, cells: &Cells, kind: PointGroup, at_most: usize) -> Vec<Imposed> {
        let [of_a, of_b, of_ab] = kind.triple();
        let mut found = Vec::new();
        let mut keys = BTreeSet::new();
        for &a in self.classes.iter().filter(|&&a| self.order(a) == of_a) {
            let centraliser: Vec<_> =
                map.flags().filter(|&c| self.product(map, a, c) == self.product(map, c, a)).collect();
            let mut seen = vec![false; map.order()];
            for b in map.flags().filter(|&b| self.order(b) == of_b) {
                if seen[b.0 as usize] || self.order(self.product(map, a, b)) != of_ab || (of_b == 2 && a == b) {
                    continue;
                }
                for &c in &centraliser {
                    let conjugate = self.product(map, self.product(map, c, b), self.inverses[c.0 as usize]);
                    seen[conjugate.0 as usize] = true;
                }
                let imposed = self.generate(map, kind, [a, b]);
                if imposed.elements.len() == kind.order() && is_possible(map, cells, &imposed) {
                    if keys.insert(key(&imposed)) {
                        found.push(imposed);
                    }
                    if found.len() == at_most {
                        return found;
                    }
                }
            }
        }
        found
    }

    fn generate(&self, map: &RegularMap, kind: PointGroup, generators: [FlagId; 2]) -> Imposed {
        let rotations = kind.generators();
        let mut elements = vec![(FlagId(0), DMat3::IDENTITY)];
        let mut seen = BTreeSet::from([FlagId(0)]);
        let mut at = 0;
        while at < elements.len() && elements.len() <= kind.order() {
            let (g, rotation) = elements[at];
            for (&by, turn) in generators.iter().zip(rotations) {
                let next = self.product(map, g, by);
                if seen.insert(next) {
                    elements.push((next, rotation * turn));
                }
            }
            at += 1;
        }
        Imposed { group: kind, elements }
    }
}

/// Which automorphisms there are and by how much they turn: the same for other generators of the same image.
fn key(imposed: &Imposed) -> Vec<(FlagId, i64)> {
    let mut key: Vec<_> = imposed.elements.iter().map(|(g, m)| (*g, (trace(m) * 1e6).round() as i64)).collect();
    key.sort_unstable();
    key
}

fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// Whether junctions and tubes can be turned like that without meeting others.
fn is_possible(map: &RegularMap, cells: &Cells, imposed: &Imposed) -> bool {
    // What must lie at the origin: there is room for one.
    let mut central = 0;
    let mut possible = |stabiliser: &[usize]| match place(imposed, stabiliser) {
        Place::Free => true,
        Place::Shared => false,
        Place::Centre => {
            central += 1;
            stabiliser.len() == imposed.elements.len() && central == 1
        }
    };
    let images = Images::new(map, cells, imposed);
    cells.vertices.iter().enumerate().all(|(v, &flag)| {
        let stabiliser = &images.vertices[v];
        stabiliser.iter().all(|&h| turns_like(map, flag, imposed.elements[h])) && possible(stabiliser)
    }) && cells.edges.iter().enumerate().all(|(e, &flag)| {
        let stabiliser = &images.edges[e];
        // The half-turn about the edge keeps all its points.
        let along = stabiliser.iter().filter(|&&h| h > 0 && images.keeps_start(map, flag, imposed.elements[h].0));
        along.into_iter().all(|&h| place(imposed, &[0, h]) == Place::Free) && possible(stabiliser)
    })
}

/// Stabilisers of cells, as numbers of elements.
struct Images {
    vertices: Vec<Vec<usize>>,
    edges: Vec<Vec<usize>>,
}

impl Images {
    fn new(map: &RegularMap, cells: &Cells, imposed: &Imposed) -> Self {
        let words = |flags: &[FlagId]| flags.iter().map(|&f| map.reflections_of(f)).collect::<Vec<_>>();
        let (at_vertices, at_edges) = (words(&cells.vertices), words(&cells.edges));
        let stabiliser = |word: &[Reflection], keeps: &dyn Fn(FlagId) -> bool| {
            let elements = imposed.elements.iter().enumerate();
            elements.filter(|(_, (h, _))| keeps(map.walk(*h, word))).map(|(k, _)| k).collect()
        };
        let vertices = cells.vertices.iter().zip(&at_vertices);
        let edges = cells.edges.iter().zip(&at_edges);
        Self {
            vertices: vertices.map(|(&f, w)| stabiliser(w, &|g| map.vertex(g) == map.vertex(f))).collect(),
            edges: edges.map(|(&f, w)| stabiliser(w, &|g| map.edge(g) == map.edge(f))).collect(),
        }
    }

    fn keeps_start(&self, map: &RegularMap, flag: FlagId, h: FlagId) -> bool {
        map.product(h, flag) == map.reflect(flag, Reflection::R2)
    }
}

#[derive(PartialEq)]
enum Place {
    /// Points that just these elements keep.
    Free,
    /// Only points that others keep as well, but not all.
    Shared,
    /// The origin.
    Centre,
}

/// Where a cell with this stabiliser can lie.
fn place(imposed: &Imposed, stabiliser: &[usize]) -> Place {
    if stabiliser.len() == 1 {
        return Place::Free;
    }
    let projector = mean(stabiliser.iter().map(|&h| imposed.elements[h].1));
    if trace(&projector) < 0.5 {
        return Place::Centre;
    }
    let columns = [projector.x_axis, projector.y_axis, projector.z_axis];
    let axis = columns.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let axis = axis.unwrap_or(DVec3::Z).normalize();
    let keep = imposed.elements.iter().filter(|(_, m)| (*m * axis - axis).length() < 1e-6).count();
    if keep == stabiliser.len() { Place::Free } else { Place::Shared }
}

/// The mean of rotations: for a group, the projection to what it keeps.
pub(super) fn mean(rotations: impl Iterator<Item = DMat3>) -> DMat3 {
    let (sum, n) = rotations.fold((DMat3::ZERO, 0.0), |(sum, n), m| (sum + m, n + 1.0));
    sum * (1.0 / n)
}

/// Whether the rotation of an element that keeps a flag's vertex has the angle of what it does there.
fn turns_like(map: &RegularMap, flag: FlagId, (h, rotation): (FlagId, DMat3)) -> bool {
    let image = map.product(h, flag);
    let mut at = flag;
    let mut angle = PI;
    for k in 0..map.q() {
        if at == image {
            angle = TAU * k as f64 / map.q() as f64;
        }
        at = map.walk(at, &[Reflection::R1, Reflection::R2]);
    }
    (trace(&rotation) - (1.0 + 2.0 * angle.cos())).abs() < 1e-6
}

/// How the elements of a symmetry move numbered things.
pub(super) struct Orbits {
    /// For each thing: the first of its orbit in the given order, and the number of an element that takes that one here.
    pub from: Vec<(u32, u32)>,
    /// The firsts, and the projection to the places that they can have, if not all are possible.
    pub firsts: Vec<(u32, Option<DMat3>)>,
}

impl Orbits {
    /// Orbits of things `0..count`, where `images[h][i]` is where element h takes thing i.
    pub fn new(imposed: &Imposed, images: &[Vec<u32>], order: impl Iterator<Item = u32>) -> Self {
        let count = images[0].len();
        let mut from = vec![(u32::MAX, 0); count];
        let mut firsts = Vec::new();
        for first in order {
            if from[first as usize].0 != u32::MAX {
                continue;
            }
            let mut stabiliser = Vec::new();
            for (h, image) in images.iter().enumerate() {
                let to = image[first as usize];
                if to == first {
                    stabiliser.push(imposed.elements[h].1);
                }
                if from[to as usize].0 == u32::MAX {
                    from[to as usize] = (first, h as u32);
                }
            }
            let projector = (stabiliser.len() > 1).then(|| mean(stabiliser.into_iter()));
            firsts.push((first, projector));
        }
        Self { from, firsts }
    }
}
