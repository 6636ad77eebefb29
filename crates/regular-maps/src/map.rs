//! A regular map as its flags and their reflections.
//!
//! In: the coset table of a group over the trivial subgroup. Out: [`RegularMap`]: vertices, edges, faces, Petrie polygons,
//! genus, dual, products of group elements.
//! Holds: the group acts simply transitively on flags; orders of R, S and r₀r₂ are p, q and 2 exactly; flags are numbered
//! in the order in which a breadth-first search from flag 0 along r₀, r₁, r₂ meets them, so equal maps have equal tables.
//! Source: [Razafindrazaka2015] §9.1.

use crate::coset::{CosetLimit, enumerate_cosets};
use crate::error::MapError;
use crate::ids::{FlagId, MapEdgeId, MapFaceId, MapVertexId};
use crate::presentation::Presentation;
use crate::word::{Letter, Word};
use std::fmt;

/// A reflection of the base flag: it changes the flag's vertex, edge or face alone.
///
/// ```text
///        F (face centre)           r₀: across the line F E, to the other vertex
///        │ ╲                       r₁: across the line F V, to the other edge
///        E ─ V                     r₂: across the line E V, to the other face
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Reflection {
    /// Changes the vertex.
    R0 = 0,
    /// Changes the edge.
    R1 = 1,
    /// Changes the face.
    R2 = 2,
}

impl Reflection {
    /// r₀, r₁, r₂.
    pub const ALL: [Self; 3] = [Self::R0, Self::R1, Self::R2];

    /// The reflection of that number.
    pub fn from_digit(digit: char) -> Option<Self> {
        match digit {
            '0' => Some(Self::R0),
            '1' => Some(Self::R1),
            '2' => Some(Self::R2),
            _ => None,
        }
    }

    /// The reflection that plays its part in the dual map.
    pub fn dual(self) -> Self {
        match self {
            Self::R0 => Self::R2,
            Self::R1 => Self::R1,
            Self::R2 => Self::R0,
        }
    }
}

/// A regular map: the regular representation of its group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RegularMap {
    p: usize,
    q: usize,
    petrie: usize,
    orientable: bool,
    /// Row g holds g·r₀, g·r₁, g·r₂.
    table: Vec<[u32; 3]>,
    /// Flag from which the search met this one, and by which reflection; unused for flag 0.
    tree: Vec<(u32, Reflection)>,
    cells: [Vec<u32>; 3],
    counts: [usize; 3],
}

impl RegularMap {
    /// The map of a presentation.
    ///
    /// # Errors     [`MapError::TooLarge`]; [`MapError::WrongOrder`] where the relators make R or S shorter
    /// # Cost       see [`enumerate_cosets`]
    pub fn from_presentation(presentation: &Presentation, limit: CosetLimit) -> Result<Self, MapError> {
        let table = enumerate_cosets(&presentation.relators(), &[], limit)?;
        let map = Self::from_table(&table)?;
        for (letter, said, found) in [("R", presentation.p, map.p), ("S", presentation.q, map.q)] {
            if said != found {
                return Err(MapError::WrongOrder { letter: letter.into(), said, found });
            }
        }
        Ok(map)
    }

    /// The map whose flag g is taken by reflection i to `table[g][i]`.
    ///
    /// # Errors     [`MapError::NotRegular`]: these are no involutions without fixed points, or flags are not all alike
    /// # Cost       linear in the number of flags
    pub fn from_table(table: &[[u32; 3]]) -> Result<Self, MapError> {
        let (table, tree) = breadth_first(table)?;
        check_regular(&table)?;
        let order = |a: usize, b: usize| {
            let (mut at, mut n) = (0usize, 0);
            loop {
                at = table[table[at][a] as usize][b] as usize;
                n += 1;
                if at == 0 {
                    return n;
                }
            }
        };
        let (p, q) = (order(0, 1), order(1, 2));
        if order(0, 2) != 2 {
            return Err(MapError::NotRegular("r0 and r2 do not make a half-turn".into()));
        }
        let cells = [[1, 2], [0, 2], [0, 1]].map(|pair| orbits(&table, &pair));
        let counts = [0, 1, 2].map(|k| cells[k].iter().max().map_or(0, |&m| m as usize + 1));
        let petrie = petrie_length(&table);
        let orientable = two_colours(&table);
        Ok(Self { p, q, petrie, orientable, table, tree, cells, counts })
    }

    /// Corners of a face.
    pub fn p(&self) -> usize {
        self.p
    }

    /// Faces at a vertex.
    pub fn q(&self) -> usize {
        self.q
    }

    /// Edges of a Petrie polygon (a closed zig-zag): the order of r₀r₁r₂.
    pub fn petrie(&self) -> usize {
        self.petrie
    }

    /// Order of the full group, and the number of flags: four per edge.
    pub fn order(&self) -> usize {
        self.table.len()
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.counts[0]
    }

    /// Number of edges.
    pub fn edge_count(&self) -> usize {
        self.counts[1]
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.counts[2]
    }

    /// Vertices − edges + faces.
    pub fn euler_characteristic(&self) -> i64 {
        self.counts[0] as i64 - self.counts[1] as i64 + self.counts[2] as i64
    }

    /// True where rotations alone do not reach all flags.
    pub fn is_orientable(&self) -> bool {
        self.orientable
    }

    /// Genus of the surface: handles where it is orientable, else crosscaps.
    pub fn genus(&self) -> usize {
        let missing = (2 - self.euler_characteristic()) as usize;
        if self.orientable { missing / 2 } else { missing }
    }

    /// All flags.
    pub fn flags(&self) -> impl DoubleEndedIterator<Item = FlagId> + ExactSizeIterator + Clone + use<> {
        (0..self.table.len() as u32).map(FlagId)
    }

    /// The neighbour of a flag: g·rᵢ.
    #[inline]
    pub fn reflect(&self, flag: FlagId, by: Reflection) -> FlagId {
        FlagId(self.table[flag.0 as usize][by as usize])
    }

    /// g·w for a word in reflections.
    pub fn walk(&self, flag: FlagId, word: &[Reflection]) -> FlagId {
        word.iter().fold(flag, |g, &by| self.reflect(g, by))
    }

    /// g·w for a word in R, S and T.
    pub fn walk_word(&self, flag: FlagId, word: &Word) -> FlagId {
        word.letters().iter().flat_map(|letter| letter.reflections()).fold(flag, |g, &by| self.reflect(g, by))
    }

    /// g·R: the next flag of the same face and orientation.
    pub fn rotate(&self, flag: FlagId, by: Letter) -> FlagId {
        self.walk(flag, by.reflections())
    }

    /// A shortest word in reflections of a group element.
    pub fn reflections_of(&self, flag: FlagId) -> Vec<Reflection> {
        let mut word = Vec::new();
        let mut at = flag.0;
        while at != 0 {
            let (before, by) = self.tree[at as usize];
            word.push(by);
            at = before;
        }
        word.reverse();
        word
    }

    /// The product g·h of two group elements.
    ///
    /// # Cost       the length of h's word
    pub fn product(&self, g: FlagId, h: FlagId) -> FlagId {
        self.walk(g, &self.reflections_of(h))
    }

    /// The inverse of a group element.
    pub fn inverse(&self, g: FlagId) -> FlagId {
        let mut word = self.reflections_of(g);
        word.reverse();
        self.walk(FlagId(0), &word)
    }

    /// The images h·g of all flags g under a group element h: an automorphism of the map.
    ///
    /// # Cost       linear
    pub fn automorphism(&self, h: FlagId) -> Vec<FlagId> {
        let mut image = vec![h; self.table.len()];
        for g in 1..self.table.len() {
            let (before, by) = self.tree[g];
            image[g] = self.reflect(image[before as usize], by);
        }
        image
    }

    /// Order of a group element.
    pub fn order_of(&self, g: FlagId) -> usize {
        let word = self.reflections_of(g);
        let mut at = g;
        let mut n = 1;
        while at.0 != 0 {
            at = self.walk(at, &word);
            n += 1;
        }
        n
    }

    /// The subgroup that these elements generate, its elements by number.
    ///
    /// # Cost       (elements) × (length of the generators' words)
    pub fn subgroup(&self, generators: &[FlagId]) -> Vec<FlagId> {
        let words: Vec<_> = generators.iter().map(|&g| self.reflections_of(g)).collect();
        let mut seen = vec![false; self.table.len()];
        let mut found = vec![FlagId(0)];
        seen[0] = true;
        let mut at = 0;
        while at < found.len() {
            for word in &words {
                let next = self.walk(found[at], word);
                if !std::mem::replace(&mut seen[next.0 as usize], true) {
                    found.push(next);
                }
            }
            at += 1;
        }
        found.sort_unstable();
        found
    }

    /// Whether a group element is a product of an even number of reflections; in an orientable map, a rotation.
    pub fn is_even(&self, g: FlagId) -> bool {
        self.reflections_of(g).len().is_multiple_of(2)
    }

    /// The vertex of a flag.
    #[inline]
    pub fn vertex(&self, flag: FlagId) -> MapVertexId {
        MapVertexId(self.cells[0][flag.0 as usize])
    }

    /// The edge of a flag.
    #[inline]
    pub fn edge(&self, flag: FlagId) -> MapEdgeId {
        MapEdgeId(self.cells[1][flag.0 as usize])
    }

    /// The face of a flag.
    #[inline]
    pub fn face(&self, flag: FlagId) -> MapFaceId {
        MapFaceId(self.cells[2][flag.0 as usize])
    }

    /// How many edges join two vertices that are joined at all, and how many edges two neighbouring faces share; a
    /// loop counts twice at its vertex, as does an edge with one face on both sides.
    pub fn multiplicities(&self) -> [usize; 2] {
        let count = |spin: [Reflection; 2], across: Reflection, cell: usize| {
            let far = |g: FlagId| self.cells[cell][self.reflect(g, across).0 as usize];
            let first = far(FlagId(0));
            let mut at = FlagId(0);
            let mut n = 0;
            loop {
                n += usize::from(far(at) == first);
                at = self.walk(at, &spin);
                if at.0 == 0 {
                    return n;
                }
            }
        };
        use Reflection::{R0, R1, R2};
        [count([R1, R2], R0, 0), count([R0, R1], R2, 2)]
    }

    /// The dual map: vertices become faces.
    pub fn dual(&self) -> Self {
        self.relabelled(|row| [row[2], row[1], row[0]])
    }

    /// The Petrie dual: the same vertices and edges, Petrie polygons for faces.
    pub fn petrie_dual(&self) -> Self {
        let rows: Vec<_> = self.table.iter().map(|row| [self.table[row[0] as usize][2], row[1], row[2]]).collect();
        Self::from_table(&rows).expect("a Petrie dual is regular")
    }

    /// True where the map is its own dual.
    pub fn is_self_dual(&self) -> bool {
        self.p == self.q && *self == self.dual()
    }

    /// Type and Petrie length, `{p,q}_r`.
    pub fn type_name(&self) -> String {
        format!("{{{},{}}}_{}", self.p, self.q, self.petrie)
    }

    fn relabelled(&self, row: impl Fn(&[u32; 3]) -> [u32; 3]) -> Self {
        let rows: Vec<_> = self.table.iter().map(row).collect();
        Self::from_table(&rows).expect("other names for reflections keep a map regular")
    }
}

impl fmt::Display for RegularMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.type_name())
    }
}

type Numbered = (Vec<[u32; 3]>, Vec<(u32, Reflection)>);

/// Numbers the flags as a breadth-first search meets them.
fn breadth_first(table: &[[u32; 3]]) -> Result<Numbered, MapError> {
    let fail = |what: &str| Err(MapError::NotRegular(what.into()));
    let n = table.len();
    for (g, row) in table.iter().enumerate() {
        for (by, &to) in row.iter().enumerate() {
            if to as usize >= n || table[to as usize][by] as usize != g {
                return fail("its reflections are no involutions");
            }
            if to as usize == g {
                return fail("a reflection leaves a flag where it is");
            }
        }
    }
    let mut number = vec![u32::MAX; n];
    let mut order = Vec::with_capacity(n);
    let mut tree = Vec::with_capacity(n);
    if n > 0 {
        number[0] = 0;
        order.push(0u32);
        tree.push((0, Reflection::R0));
    }
    let mut at = 0;
    while at < order.len() {
        for by in Reflection::ALL {
            let to = table[order[at] as usize][by as usize] as usize;
            if number[to] == u32::MAX {
                number[to] = order.len() as u32;
                order.push(to as u32);
                tree.push((at as u32, by));
            }
        }
        at += 1;
    }
    if order.len() != n || n == 0 {
        return fail("its flags are not connected");
    }
    Ok((order.iter().map(|&old| table[old as usize].map(|to| number[to as usize])).collect(), tree))
}

/// The group generated by the reflections is as large as the number of flags just if for each i there is an automorphism
/// that takes flag 0 to flag 0·rᵢ: these generate a group that is transitive and commutes with the reflections.
fn check_regular(table: &[[u32; 3]]) -> Result<(), MapError> {
    for start in table[0] {
        let mut image = vec![u32::MAX; table.len()];
        image[0] = start;
        let mut queue = vec![0u32];
        while let Some(g) = queue.pop() {
            let there = table[image[g as usize] as usize];
            for (&to, want) in table[g as usize].iter().zip(there) {
                let to = to as usize;
                if image[to] == u32::MAX {
                    image[to] = want;
                    queue.push(to as u32);
                } else if image[to] != want {
                    return Err(MapError::NotRegular("not all flags are alike".into()));
                }
            }
        }
    }
    Ok(())
}

fn orbits(table: &[[u32; 3]], by: &[usize]) -> Vec<u32> {
    let mut of = vec![u32::MAX; table.len()];
    let mut count = 0;
    for start in 0..table.len() {
        if of[start] != u32::MAX {
            continue;
        }
        let mut stack = vec![start];
        of[start] = count;
        while let Some(g) = stack.pop() {
            for &i in by {
                let to = table[g][i] as usize;
                if of[to] == u32::MAX {
                    of[to] = count;
                    stack.push(to);
                }
            }
        }
        count += 1;
    }
    of
}

fn petrie_length(table: &[[u32; 3]]) -> usize {
    let (mut at, mut n) = (0usize, 0);
    loop {
        at = (0..3).fold(at, |g, by| table[g][by] as usize);
        n += 1;
        if at == 0 {
            return n;
        }
    }
}

fn two_colours(table: &[[u32; 3]]) -> bool {
    let mut colour = vec![2u8; table.len()];
    colour[0] = 0;
    let mut stack = vec![0usize];
    while let Some(g) = stack.pop() {
        for &to in &table[g] {
            if colour[to as usize] == 2 {
                colour[to as usize] = 1 - colour[g];
                stack.push(to as usize);
            } else if colour[to as usize] == colour[g] {
                return false;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(text: &str) -> RegularMap {
        RegularMap::from_presentation(&Presentation::parse(text).unwrap(), CosetLimit::default()).unwrap()
    }

    #[test]
    fn the_cube_has_its_numbers() {
        let cube = map("R^4, S^3");
        assert_eq!([cube.vertex_count(), cube.edge_count(), cube.face_count(), cube.order()], [8, 12, 6, 48]);
        assert_eq!((cube.genus(), cube.is_orientable(), cube.petrie(), cube.multiplicities()), (0, true, 6, [1, 1]));
        let octahedron = cube.dual();
        assert_eq!((octahedron.p(), octahedron.q(), octahedron.vertex_count()), (3, 4, 6));
        assert!(map("R^3, S^3").is_self_dual() && !cube.is_self_dual());
        assert_eq!(octahedron.dual(), cube);
    }

    #[test]
    fn half_of_the_icosahedron_is_not_orientable() {
        let half = map("R^3, S^5, (R*T*S)^5");
        assert_eq!((half.order(), half.is_orientable(), half.genus(), half.petrie()), (60, false, 1, 5));
    }

    #[test]
    fn kleins_quartic() {
        let klein = map("R^3, S^7, (R*S^-2)^4");
        assert_eq!((klein.order(), klein.genus(), klein.petrie(), klein.face_count()), (336, 3, 8, 56));
        assert_eq!(klein.petrie_dual().p(), 8);
    }

    #[test]
    fn products_are_those_of_the_group() {
        let cube = map("R^4, S^3");
        for g in cube.flags() {
            assert_eq!(cube.product(g, cube.inverse(g)), FlagId(0));
            assert_eq!(cube.product(FlagId(0), g), g);
            let image = cube.automorphism(g);
            for h in cube.flags() {
                assert_eq!(image[h.0 as usize], cube.product(g, h));
            }
        }
        let r = cube.walk_word(FlagId(0), &Word::parse("R").unwrap());
        assert_eq!((cube.order_of(r), cube.subgroup(&[r]).len()), (4, 4));
    }

    #[test]
    fn a_type_that_the_relators_forbid_is_refused() {
        let wrong = Presentation::parse("R^6, S^3, R^3*S^3*R^3*T*T").unwrap();
        assert!(RegularMap::from_presentation(&wrong, CosetLimit { cosets: 1000 }).is_err());
        let short = Presentation::parse("R^4, S^6, R^2*S*R^2*S^-1, R^2*S^3").unwrap();
        let found = RegularMap::from_presentation(&short, CosetLimit::default());
        assert!(found.is_err(), "{found:?}");
    }
}
