//! Vertices of the surface of a word, and its invariants.
//!
//! In: a word. Out: which corners of the polygon become one vertex; numbers of vertices, edges and borders; whether
//! the surface is orientable. Holds: by definition, counted from the gluing of the word itself.

use super::{Corner, Letter, Side, Word};

/// A vertex of the surface: a class of corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VertexClass(pub u32);

/// The vertices of the surface of a word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Vertices {
    of_corner: Vec<VertexClass>,
    corner_count: Vec<u32>,
    is_border: Vec<bool>,
}

impl Vertices {
    /// Number of vertices.
    pub fn count(&self) -> usize {
        self.is_border.len()
    }

    /// The vertex of a corner; corners are counted around, and all of the empty word are its only vertex.
    pub fn at(&self, corner: Corner) -> VertexClass {
        match self.of_corner.len() {
            0 => VertexClass(0),
            n => self.of_corner[corner.index() % n],
        }
    }

    /// Whether a vertex lies on the border.
    pub fn is_border(&self, vertex: VertexClass) -> bool {
        self.is_border[vertex.0 as usize]
    }

    /// Number of corners at a vertex.
    pub fn corner_count(&self, vertex: VertexClass) -> usize {
        self.corner_count[vertex.0 as usize] as usize
    }

    /// All vertices.
    pub fn iter(&self) -> impl Iterator<Item = VertexClass> {
        (0..self.is_border.len() as u32).map(VertexClass)
    }

    /// Tail and head of the letter at a position.
    pub(crate) fn letter_ends(&self, word: &Word, position: usize) -> [VertexClass; 2] {
        let [a, b] = [self.at(Corner::at(position)), self.at(Corner::at(position + 1))];
        if word.sides()[position].inverse { [b, a] } else { [a, b] }
    }
}

/// What a word says of its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Invariants {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of edges: of letters.
    pub edges: usize,
    /// Number of border components.
    pub borders: usize,
    /// Whether no letter stands twice in the same direction.
    pub is_orientable: bool,
}

impl Invariants {
    /// Euler characteristic, V − E + F with the one face that the polygon is.
    pub fn chi(&self) -> i64 {
        self.vertices as i64 - self.edges as i64 + 1
    }

    /// Number of handles, or of cross-caps if the surface is not orientable.
    pub fn genus(&self) -> usize {
        let rest = usize::try_from(2 - self.chi()).unwrap_or(0) - self.borders;
        if self.is_orientable { rest / 2 } else { rest }
    }

    /// The canonical word of the surface: 4·genus sides, or 2·genus, and three per border.
    ///
    /// # Output     letters 0, 1, … in the order in which they are met; [`Invariants::name`] gives their names
    pub fn canonical_word(&self) -> Word {
        let mut sides: Vec<Side> = Vec::new();
        for k in 0..self.genus() as u32 {
            if self.is_orientable {
                let [a, b] = [Side::forward(Letter(2 * k)), Side::forward(Letter(2 * k + 1))];
                sides.extend([a, b, a.inverted(), b.inverted()]);
            } else {
                sides.extend([Side::forward(Letter(k)); 2]);
            }
        }
        for k in 0..self.borders as u32 {
            let first = self.loop_count() + 2 * k;
            let [stalk, border] = [Side::forward(Letter(first)), Side::forward(Letter(first + 1))];
            sides.extend([stalk, border, stalk.inverted()]);
        }
        Word::of(sides)
    }

    /// The name of a letter of the canonical word: a1 b1 a2 … for handles, a1 a2 … for cross-caps, c1 d1 c2 … for
    /// borders.
    pub fn name(&self, letter: Letter) -> String {
        let of_pair = |names: [char; 2], k: u32| format!("{}{}", names[(k % 2) as usize], k / 2 + 1);
        match letter.0.checked_sub(self.loop_count()) {
            Some(k) => of_pair(['c', 'd'], k),
            None if self.is_orientable => of_pair(['a', 'b'], letter.0),
            None => format!("a{}", letter.0 + 1),
        }
    }

    /// Number of canonical letters that stand for handles or cross-caps.
    fn loop_count(&self) -> u32 {
        (if self.is_orientable { 2 * self.genus() } else { self.genus() }) as u32
    }
}

impl Word {
    /// The vertices of its surface: corners that the gluing identifies.
    ///
    /// # Output     numbered in the order of their first corners; one for the empty word
    /// # Cost       O(n log n)
    pub fn vertices(&self) -> Vertices {
        let partners = self.partners();
        let corners = self.glued_corners(&partners);
        let mut of_corner: Vec<VertexClass> = Vec::with_capacity(self.len());
        let mut corner_count: Vec<u32> = Vec::new();
        for (k, &root) in corners.iter().enumerate() {
            let class = if root == k { VertexClass(corner_count.len() as u32) } else { of_corner[root] };
            if root == k {
                corner_count.push(0);
            }
            corner_count[class.0 as usize] += 1;
            of_corner.push(class);
        }
        if self.is_empty() {
            corner_count.push(0);
        }
        let mut is_border = vec![false; corner_count.len()];
        for k in (0..self.len()).filter(|&k| partners[k].is_none()) {
            is_border[of_corner[k].0 as usize] = true;
            is_border[of_corner[(k + 1) % self.len()].0 as usize] = true;
        }
        Vertices { of_corner, corner_count, is_border }
    }

    /// What it says of its surface.
    ///
    /// # Cost       O(n log n)
    pub fn invariants(&self) -> Invariants {
        let partners = self.partners();
        let glued = partners.iter().flatten().count();
        let is_turned =
            |(k, m): (usize, &Option<usize>)| m.is_some_and(|m| self.sides()[k].inverse == self.sides()[m].inverse);
        Invariants {
            vertices: self.vertices().count(),
            edges: glued / 2 + self.len() - glued,
            borders: self.border_count(&partners),
            is_orientable: !partners.iter().enumerate().any(is_turned),
        }
    }

    /// For every corner the first one that is glued to it.
    fn glued_corners(&self, partners: &[Option<usize>]) -> Vec<usize> {
        let n = self.len();
        let mut parents: Vec<usize> = (0..n).collect();
        for (k, m) in partners.iter().enumerate().filter_map(|(k, m)| m.map(|m| (k, m))).filter(|(k, m)| k < m) {
            let turned = self.sides()[k].inverse != self.sides()[m].inverse;
            let [from, to] = if turned { [(m + 1) % n, m] } else { [m, (m + 1) % n] };
            unite(&mut parents, k, from);
            unite(&mut parents, (k + 1) % n, to);
        }
        (0..n).map(|k| root(&mut parents, k)).collect()
    }

    /// Number of rings of border sides.
    fn border_count(&self, partners: &[Option<usize>]) -> usize {
        let mut parents = self.glued_corners(partners);
        let border: Vec<usize> = (0..self.len()).filter(|&k| partners[k].is_none()).collect();
        for &k in &border {
            unite(&mut parents, k, (k + 1) % self.len());
        }
        let mut rings: Vec<usize> = border.iter().map(|&k| root(&mut parents, k)).collect();
        rings.sort_unstable();
        rings.dedup();
        rings.len()
    }
}

/// Makes two sets one; the lesser element stays its root.
fn unite(parents: &mut [usize], a: usize, b: usize) {
    let [a, b] = [root(parents, a), root(parents, b)];
    parents[a.max(b)] = a.min(b);
}

/// The root of an element's set.
fn root(parents: &mut [usize], mut a: usize) -> usize {
    while parents[a] != a {
        parents[a] = parents[parents[a]];
        a = parents[a];
    }
    a
}
