//! Small random surfaces: inputs of property tests.
//!
//! In: a seed. Out: triangle meshes of random topology and shape. Holds: valid simplicial surfaces of one component,
//! every face with an area, the same for the same seed. Not: good angles, freedom from self-intersections.
//! Source: own; solids whose surface is a manifold: Latecki, 3D well-composed pictures (1997).

use super::draft::Draft;
use super::genus::row_of_holes;
use super::{Dice, voxel_surface};
use crate::mesh::TriMesh;

/// Fewest and most vertices of [`random_genus`].
const VERTICES: [usize; 2] = [100, 1500];

/// Largest genus of [`random_genus`].
const MAX_GENUS: usize = 8;

/// Most faces of unit cells on a solid of [`random_genus`]: its surface has as many vertices, nearly.
const MAX_SQUARES: i64 = 1200;

/// Changes that are tried on a random solid. Fewer leave small solids of too low a genus; with 4000 a mesh takes 10 ms.
const MAX_TRIES: usize = 4000;

/// Random closed surface of genus 1 to 8 with 100 to 1500 vertices.
///
/// The surface of a random solid of unit cells, with random diagonals, on half of them smoothed, every vertex moved
/// a little at random, random edges split.
///
/// # Output     closed, one component; genus and count vary with the seed
/// # Guarantees faces with an area; angles below a tenth of a degree occur
/// # Source     own
pub fn random_genus(seed: u64) -> TriMesh {
    let mut dice = Dice::new(seed);
    let surface = random_solid(&mut dice).surface();
    let mut draft = Draft::new(&surface);
    turn_diagonals(&mut draft, &surface, &mut dice);
    for _ in 0..dice.below(4) / 2 {
        draft.smooth(0.4);
    }
    draft.jitter(0.12, &mut dice);
    let least = draft.vertices().max(VERTICES[0]);
    let vertices = least + (dice.number().powi(2) * (VERTICES[1] - least) as f64) as usize;
    split_at_random(&mut draft, vertices, &mut dice);
    draft.finish()
}

/// Flips the diagonals of the unit squares, faces 2i and 2i + 1, at random.
fn turn_diagonals(draft: &mut Draft, surface: &TriMesh, dice: &mut Dice) {
    let diagonals: Vec<[u32; 2]> = surface
        .edges()
        .filter(|&e| matches!(surface.edge_faces(e), (f, Some(g)) if f.0 / 2 == g.0 / 2))
        .map(|e| surface.ends(e).map(|v| v.0))
        .collect();
    for diagonal in diagonals {
        if dice.number() < 0.5 {
            // The other diagonal of a unit square is never an edge of another one.
            draft.flip(diagonal);
        }
    }
}

/// Splits edges of random faces until there are `vertices` vertices: mostly their longest edges, sometimes any.
fn split_at_random(draft: &mut Draft, vertices: usize, dice: &mut Dice) {
    while draft.vertices() < vertices {
        let any = draft.random_edge(dice);
        let longest = draft.longest_edge(draft.random_face(dice));
        draft.split(if dice.number() < 0.1 { any } else { longest }, dice.within(0.35, 0.65));
    }
}

/// A random solid whose surface is one closed manifold of genus 1 to [`MAX_GENUS`].
fn random_solid(dice: &mut Dice) -> Solid {
    loop {
        let genus = 1 + dice.below(MAX_GENUS) as i64;
        let mut solid = Solid::new(std::array::from_fn(|_| 3 + dice.below(5)));
        let share = dice.within(0.1, 0.6);
        let cells = (share * solid.filled.len() as f64) as usize;
        for _ in 0..MAX_TRIES {
            solid.try_change(genus, dice);
            if solid.genus() == genus && solid.count >= cells {
                break;
            }
        }
        if solid.genus() > 0 {
            return solid;
        }
    }
}

/// A set of unit cells in a box with a margin of empty cells; solid and complement are connected, and the surface
/// between them is a manifold.
struct Solid {
    /// Cells in each direction, with the margin.
    size: [usize; 3],
    filled: Vec<bool>,
    /// Number of filled cells.
    count: usize,
    /// Faces between filled and empty cells.
    squares: i64,
    /// Grid points with filled and empty cells around them.
    points: i64,
}

impl Solid {
    /// The middle cell of a box.
    fn new(inner: [usize; 3]) -> Self {
        let size = inner.map(|n| n + 2);
        let mut filled = vec![false; size.iter().product()];
        let [x, y, z] = size.map(|n| n / 2);
        filled[(z * size[1] + y) * size[0] + x] = true;
        Self { size, filled, count: 1, squares: 6, points: 8 }
    }

    /// Genus of the surface: its Euler characteristic is points − squares, for it has two edges a square.
    fn genus(&self) -> i64 {
        (2 - self.points + self.squares) / 2
    }

    /// Fills or empties a random cell if that keeps what a [`Solid`] promises, and does not lower the genus or raise it
    /// above `genus`.
    fn try_change(&mut self, genus: i64, dice: &mut Dice) {
        let [x, y, z] = self.size.map(|n| 1 + dice.below(n - 2));
        let cell = (z * self.size[1] + y) * self.size[0] + x;
        let fill = !self.filled[cell];
        // Emptying is rare, so that solids grow; a cell alone in its surroundings is never right.
        let touches = self.neighbours(cell).filter(|&c| self.filled[c] == fill).count();
        if touches == 0 || (!fill && dice.number() < 0.6) || (fill && self.squares > MAX_SQUARES) {
            return;
        }
        let before = self.genus();
        self.change(cell);
        let kept = self.is_manifold_at(cell)
            && (before..=genus).contains(&self.genus())
            && self.is_connected(true)
            && self.is_connected(false);
        if !kept {
            self.change(cell);
        }
    }

    /// Fills an empty cell or empties a filled one.
    fn change(&mut self, cell: usize) {
        let mixed = |s: &Self| s.blocks(cell).filter(|b| b.contains(&true) && b.contains(&false)).count() as i64;
        let exposed = |s: &Self| s.neighbours(cell).filter(|&c| s.filled[c] != s.filled[cell]).count() as i64;
        self.points -= mixed(self);
        self.squares -= exposed(self);
        self.filled[cell] ^= true;
        self.count = if self.filled[cell] { self.count + 1 } else { self.count - 1 };
        self.points += mixed(self);
        self.squares += exposed(self);
    }

    /// Steps from a cell to its neighbours along x, y and z.
    fn strides(&self) -> [usize; 3] {
        [1, self.size[0], self.size[0] * self.size[1]]
    }

    /// The six neighbours of a cell; of a cell of the margin those that exist.
    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> {
        let (strides, size, len) = (self.strides(), self.size, self.filled.len());
        (0..3).flat_map(move |k| {
            let at = cell % len / strides[k] % size[k];
            [(at > 0).then(|| cell - strides[k]), (at + 1 < size[k]).then(|| cell + strides[k])].into_iter().flatten()
        })
    }

    /// The eight blocks of 2 × 2 × 2 cells around the corners of an inner cell; bit k of an index is a step on axis k.
    fn blocks(&self, cell: usize) -> impl Iterator<Item = [bool; 8]> {
        let s = self.strides();
        let offset = move |bits: usize| (0..3).map(|k| (bits >> k & 1) * s[k]).sum::<usize>();
        (0..8).map(move |corner| std::array::from_fn(|i| self.filled[cell + offset(i) - offset(corner)]))
    }

    /// Whether the surface is a manifold around a cell: nowhere do cells of the same kind meet at an edge or a point
    /// only (Latecki's critical configurations).
    fn is_manifold_at(&self, cell: usize) -> bool {
        self.blocks(cell).all(|block| {
            let at_edge = (0..3).flat_map(|axis| {
                let [j, k] = [1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3)];
                [0, 1 << axis].map(|low| {
                    let [p, q, r, s] = [low, low | j, low | k, low | j | k].map(|i| block[i]);
                    p == s && q == r && p != q
                })
            });
            let filled = block.iter().filter(|&&b| b).count();
            let opposite = (0..4).any(|i| block[i] == block[7 - i] && block[i] == (filled == 2));
            let at_point = (filled == 2 || filled == 6) && opposite;
            !at_point && !at_edge.into_iter().any(|critical| critical)
        })
    }

    /// Whether there are filled cells and all of them are one piece, or the same of empty ones.
    fn is_connected(&self, filled: bool) -> bool {
        let mut seen: Vec<bool> = self.filled.iter().map(|&f| f != filled).collect();
        let Some(first) = seen.iter().position(|&s| !s) else { return false };
        let mut open = vec![first];
        seen[first] = true;
        while let Some(cell) = open.pop() {
            for next in self.neighbours(cell) {
                if !std::mem::replace(&mut seen[next], true) {
                    open.push(next);
                }
            }
        }
        seen.iter().all(|&s| s)
    }

    fn surface(&self) -> TriMesh {
        let strides = self.strides();
        voxel_surface(self.size, |c| self.filled[(0..3).map(|k| c[k] * strides[k]).sum::<usize>()])
    }
}

/// Fewest vertices of a closed simplicial surface of genus 0, 1, 2, 3.
const FEWEST: [usize; 4] = [4, 7, 10, 10];

/// Changes that are tried for every vertex of a small surface: enough to come close to [`FEWEST`] now and then.
const SHRINK_TRIES: usize = 200;

/// Disks that are tried as holes of a small surface: with 60 vertices three nearly always find room.
const HOLE_TRIES: usize = 12;

/// Random surface of genus 0 to 3, closed or with one to three boundary loops, with at most `max_vertices` vertices.
///
/// Random flips, splits and collapses of a plate with holes, then triangles and vertex stars removed. Frequent are the
/// traps of coarse meshes: vertices of valence 3, cycles of three edges that bound nothing, boundary loops of length 3,
/// inner edges between boundary vertices.
///
/// # Input      max_vertices: meant for at most 60; raised to 4, the tetrahedron; few of them exclude higher genera
/// # Output     one component; positions have no meaning beyond faces with an area
/// # Guarantees a simplicial complex: no two edges with the same ends
/// # Source     own
pub fn small_random(seed: u64, max_vertices: usize) -> TriMesh {
    let mut dice = Dice::new(seed);
    let max_vertices = max_vertices.max(FEWEST[0]);
    let mut genus = dice.below(FEWEST.len());
    loop {
        if FEWEST[genus] <= max_vertices {
            let vertices = FEWEST[genus] + dice.below(max_vertices - FEWEST[genus] + 1);
            let mut draft = shuffled(genus as u32, vertices, &mut dice);
            if draft.vertices() <= max_vertices {
                draft.jitter(0.2, &mut dice);
                let holes = random_holes(&draft, &mut dice);
                return draft.finish_without(&holes);
            }
        }
        // Too few vertices for this genus, or for this search. Spheres always come down to the tetrahedron.
        genus = genus.saturating_sub(1);
    }
}

/// A random triangulation of a closed surface with `vertices` vertices, or more where collapses got stuck.
fn shuffled(genus: u32, vertices: usize, dice: &mut Dice) -> Draft {
    let mut draft = Draft::new(&row_of_holes(genus, 1));
    while draft.vertices() < vertices {
        draft.split(draft.random_edge(dice), 0.5);
    }
    for _ in 0..dice.below(4) * draft.vertices() {
        draft.flip(draft.random_edge(dice));
    }
    for _ in 0..SHRINK_TRIES * draft.vertices() {
        if draft.vertices() == vertices {
            break;
        }
        if !draft.collapse(draft.random_edge(dice)) {
            // A flip now and then loosens what got stuck.
            if dice.number() < 0.3 {
                draft.flip(draft.random_edge(dice));
            }
        }
    }
    draft
}

/// Faces of up to three disks, triangles or vertex stars, no two of which share a vertex; none for half of the surfaces.
fn random_holes(draft: &Draft, dice: &mut Dice) -> Vec<u32> {
    let (mut holes, mut used) = (Vec::new(), Vec::new());
    if dice.number() < 0.5 {
        return holes;
    }
    let mut wanted = 1 + dice.below(3);
    for _ in 0..HOLE_TRIES {
        let face = draft.random_face(dice);
        let disk = if dice.number() < 0.5 { vec![face] } else { draft.star(draft.face(face)[0]).to_vec() };
        let vertices: Vec<u32> = disk.iter().flat_map(|&f| draft.face(f)).collect();
        if wanted > 0 && vertices.iter().all(|v| !used.contains(v)) {
            used.extend(vertices);
            holes.extend(disk);
            wanted -= 1;
        }
    }
    holes
}

#[cfg(test)]
mod tests {
    use super::super::tests::{check_closed, smallest_angle};
    use super::*;
    use crate::topology::{Summary, euler_characteristic};
    use std::collections::BTreeSet;

    #[test]
    fn random_genus_keeps_its_promises() {
        let (mut genera, mut counts) = (BTreeSet::new(), BTreeSet::new());
        for seed in 0..150 {
            let mesh = random_genus(seed);
            let genus = (2 - euler_characteristic(mesh.connectivity())) / 2;
            check_closed(&mesh, genus as u32);
            assert!((VERTICES[0]..=VERTICES[1]).contains(&mesh.vertex_count()), "seed {seed}: {}", mesh.vertex_count());
            assert!(smallest_angle(&mesh) > 0.01, "seed {seed}: smallest angle {}°", smallest_angle(&mesh));
            genera.insert(genus);
            counts.insert(mesh.vertex_count() / 100);
        }
        assert_eq!(genera, (1..=MAX_GENUS as i64).collect(), "every genus occurs");
        assert!(counts.len() > 10, "vertex counts vary: {counts:?}");
        assert_eq!(random_genus(5), random_genus(5));
        assert_ne!(random_genus(5), random_genus(6));
    }

    #[test]
    fn solids_count_their_surfaces() {
        for seed in 0..30 {
            let solid = random_solid(&mut Dice::new(seed));
            let surface = solid.surface();
            assert_eq!(surface.vertex_count() as i64, solid.points);
            assert_eq!(surface.face_count() as i64, 2 * solid.squares);
            assert_eq!(Summary::of(surface.connectivity()).genus, solid.genus());
            assert_eq!(solid.filled.iter().filter(|&&f| f).count(), solid.count);
        }
    }

    #[test]
    fn small_random_keeps_its_promises() {
        let mut kinds = BTreeSet::new();
        for max_vertices in [0, 4, 5, 7, 8, 10, 12, 15, 20, 30, 45, 60] {
            for seed in 0..300 {
                let mesh = small_random(seed, max_vertices);
                let s = Summary::of(mesh.connectivity());
                let name = format!("seed {seed}, at most {max_vertices} vertices: {s:?}");
                assert!(s.vertices <= max_vertices.max(4), "{name}");
                assert_eq!(s.components, 1, "{name}");
                assert!((0..=3).contains(&s.genus) && s.boundary_loops <= 3, "{name}");
                let ends: BTreeSet<_> = mesh.edges().map(|e| mesh.ends(e)).map(|[a, b]| (a.min(b), a.max(b))).collect();
                assert_eq!(ends.len(), s.edges, "{name}");
                assert!(smallest_angle(&mesh) > 0.0, "{name}");
                kinds.insert((s.genus, s.boundary_loops));
            }
        }
        assert_eq!(kinds.len(), 16, "every genus with every number of boundary loops: {kinds:?}");
        assert_eq!(small_random(3, 40), small_random(3, 40));
    }

    #[test]
    fn small_random_finds_the_smallest_surfaces() {
        let smallest = |genus: i64| {
            let found = (0..400).map(|seed| small_random(seed, FEWEST[genus as usize] + 3));
            let summaries = found.map(|mesh| Summary::of(mesh.connectivity()));
            summaries.filter(|s| s.genus == genus && s.boundary_loops == 0).map(|s| s.vertices).min()
        };
        assert_eq!([0, 1, 2, 3].map(smallest), [Some(4), Some(7), Some(10), Some(10)]);
    }
}
