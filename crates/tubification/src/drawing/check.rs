//! Is the drawn map the source map?
//!
//! In: a [`Drawing`] and the map it should be. Out: what was counted, or what is wrong.
//! Holds: it looks at the mesh and at the labels of its faces alone, never at how they were made. A drawing passes just
//! if each flag is one disk, meets its three neighbours across one line each and nothing else, and faces, edges and
//! vertices found on the mesh have the map's numbers.

use super::{Drawing, Drawn};
use quadloom_mesh::{FaceId, HalfEdgeId, Id, TriMesh, VertexId};
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::{Reflection, RegularMap};
use serde::Serialize;
use std::collections::BTreeMap;

/// What was counted on the mesh, for the map that is drawn (the dual where that is).
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DrawnCounts {
    /// Points where lines of the map meet.
    pub vertices: usize,
    /// Lines between them.
    pub edges: usize,
    /// Regions that the lines cut out, each of them a disk.
    pub faces: usize,
    /// Euler characteristic of the mesh.
    pub chi: i64,
}

/// What is wrong with a drawing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DrawingDefect {
    /// A flag of the map is nowhere.
    #[error("flag {0} is not drawn")]
    Missing(FlagId),
    /// Triangles of flags that are no neighbours share a side.
    #[error("triangles {0} and {1} lie side by side, but their flags are no neighbours in the map")]
    Neighbours(FaceId, FaceId),
    /// A flag's triangles are not one disk.
    #[error("flag {0} is drawn as {1} pieces with Euler characteristic {2}, not as one disk")]
    FlagNotDisk(FlagId, usize, i64),
    /// A flag does not meet each neighbour along one line.
    #[error("flag {0} meets its neighbours along {1} lines, not 3")]
    Lines(FlagId, usize),
    /// A region between the lines is no disk.
    #[error("a face is drawn with Euler characteristic {0}, not as a disk")]
    FaceNotDisk(i64),
    /// Counts do not agree with the map.
    #[error("the drawing has {found:?}, the map {wanted:?} vertices, edges and faces")]
    Counts {
        /// Counted on the mesh.
        found: [usize; 3],
        /// The map's.
        wanted: [usize; 3],
    },
    /// The surface has another Euler characteristic than the map.
    #[error("the surface has Euler characteristic {found}, the map {wanted}")]
    Chi {
        /// Of the mesh.
        found: i64,
        /// Of the map.
        wanted: i64,
    },
}

impl Drawing {
    /// Checks the drawing against the map's definition.
    ///
    /// # Input      the source map, not its dual
    /// # Cost       near linear
    pub fn check(&self, source: &RegularMap) -> Result<DrawnCounts, DrawingDefect> {
        let lines = self.lines(source)?;
        self.check_flags(source, &lines)?;
        let mesh = &self.mesh;
        let across = match self.drawn {
            Drawn::Map => Reflection::R2,
            Drawn::Dual => Reflection::R0,
        };
        let is_edge = |h: HalfEdgeId| lines[h.index()] == Some(across);
        let faces = regions(mesh, &is_edge)?;
        let (vertices, edges) = graph(mesh, &is_edge);
        let chi = quadloom_mesh::topology::euler_characteristic(mesh.connectivity());
        let mut wanted = [source.vertex_count(), source.edge_count(), source.face_count()];
        if self.drawn == Drawn::Dual {
            wanted.reverse();
        }
        // A vertex of two edges cannot be told from a point on a line.
        let [corners, degree] = [wanted[0], if self.drawn == Drawn::Map { source.q() } else { source.p() }];
        let found = [if degree == 2 { corners } else { vertices }, if degree == 2 { wanted[1] } else { edges }, faces];
        if found != wanted {
            return Err(DrawingDefect::Counts { found, wanted });
        }
        if chi != source.euler_characteristic() {
            return Err(DrawingDefect::Chi { found: chi, wanted: source.euler_characteristic() });
        }
        Ok(DrawnCounts { vertices: found[0], edges: found[1], faces, chi })
    }

    /// Across each half-edge, the reflection between the flags on its two sides.
    pub(super) fn lines(&self, source: &RegularMap) -> Result<Vec<Option<Reflection>>, DrawingDefect> {
        let mesh = &self.mesh;
        let mut lines = vec![None; mesh.half_edge_count()];
        for h in mesh.half_edges() {
            let Some(twin) = mesh.twin(h) else { continue };
            let [here, there] = [h, twin].map(|h| mesh.face(h));
            let [g, k] = [here, there].map(|f| self.flag[f]);
            if g != k {
                let by = Reflection::ALL.into_iter().find(|&by| source.reflect(g, by) == k);
                lines[h.index()] = Some(by.ok_or(DrawingDefect::Neighbours(here, there))?);
            }
        }
        Ok(lines)
    }

    /// Each flag: one disk, whose border is three lines, one to each neighbour.
    fn check_flags(&self, source: &RegularMap, lines: &[Option<Reflection>]) -> Result<(), DrawingDefect> {
        let mesh = &self.mesh;
        let mut faces: Vec<Vec<FaceId>> = vec![Vec::new(); source.order()];
        mesh.faces().for_each(|f| faces[self.flag[f].index()].push(f));
        for (g, faces) in faces.iter().enumerate() {
            let flag = FlagId(g as u32);
            if faces.is_empty() {
                return Err(DrawingDefect::Missing(flag));
            }
            let inside = |h: HalfEdgeId| lines[h.index()].is_none();
            let (pieces, chi) = patch(mesh, faces, &inside);
            if (pieces, chi) != (1, 1) {
                return Err(DrawingDefect::FlagNotDisk(flag, pieces, chi));
            }
            let count = border_lines(mesh, faces, lines);
            if count != 3 {
                return Err(DrawingDefect::Lines(flag, count));
            }
        }
        Ok(())
    }
}

/// Pieces and Euler characteristic of a set of faces glued along some of their sides alone.
fn patch(mesh: &TriMesh, faces: &[FaceId], inside: &impl Fn(HalfEdgeId) -> bool) -> (usize, i64) {
    let number: BTreeMap<FaceId, usize> = faces.iter().enumerate().map(|(k, &f)| (f, k)).collect();
    let mut pieces = Sets::new(faces.len());
    // Corners of the faces, glued where a side is.
    let mut corners = Sets::new(3 * faces.len());
    let mut glued = 0;
    let place = |h: HalfEdgeId| 3 * number[&mesh.face(h)] + h.index() % 3;
    for (k, &f) in faces.iter().enumerate() {
        for h in mesh.sides(f).filter(|&h| inside(h)) {
            let Some(twin) = mesh.twin(h).filter(|t| number.contains_key(&mesh.face(*t))) else { continue };
            pieces.join(k, number[&mesh.face(twin)]);
            corners.join(place(h), place(mesh.next(twin)));
            corners.join(place(mesh.next(h)), place(twin));
            glued += 1;
        }
    }
    let sides = 3 * faces.len() as i64 - glued / 2;
    (pieces.count(), corners.count() as i64 - sides + faces.len() as i64)
}

/// Runs of equal neighbours along the border of a disk of faces.
fn border_lines(mesh: &TriMesh, faces: &[FaceId], lines: &[Option<Reflection>]) -> usize {
    let border: Vec<HalfEdgeId> =
        faces.iter().flat_map(|&f| mesh.sides(f)).filter(|h| lines[h.index()].is_some()).collect();
    let next = |h: HalfEdgeId| {
        let mut at = mesh.next(h);
        while lines[at.index()].is_none() {
            at = mesh.next(mesh.twin(at).unwrap_or(at));
        }
        at
    };
    border.iter().filter(|&&h| lines[h.index()] != lines[next(h).index()]).count()
}

/// Number of regions that lines cut out; each must be a disk.
fn regions(mesh: &TriMesh, is_edge: &impl Fn(HalfEdgeId) -> bool) -> Result<usize, DrawingDefect> {
    let mut sets = Sets::new(mesh.face_count());
    for h in mesh.half_edges().filter(|&h| !is_edge(h)) {
        if let Some(twin) = mesh.twin(h) {
            sets.join(mesh.face(h).index(), mesh.face(twin).index());
        }
    }
    let mut members: BTreeMap<usize, Vec<FaceId>> = BTreeMap::new();
    mesh.faces().for_each(|f| members.entry(sets.find(f.index())).or_default().push(f));
    for faces in members.values() {
        let (_, chi) = patch(mesh, faces, &|h| !is_edge(h));
        if chi != 1 {
            return Err(DrawingDefect::FaceNotDisk(chi));
        }
    }
    Ok(members.len())
}

/// Vertices where other than two lines end, and lines between them.
fn graph(mesh: &TriMesh, is_edge: &impl Fn(HalfEdgeId) -> bool) -> (usize, usize) {
    let degree = |v: VertexId| mesh.outgoing(v).filter(|&h| is_edge(h)).count();
    let degrees: Vec<usize> = mesh.vertices().map(degree).collect();
    let nodes = degrees.iter().filter(|&&d| d != 0 && d != 2).count();
    let ends: usize = degrees.iter().filter(|&&d| d != 2).sum();
    (nodes, ends / 2)
}

/// Disjoint sets of numbers.
struct Sets(Vec<usize>);

impl Sets {
    fn new(n: usize) -> Self {
        Self((0..n).collect())
    }

    fn find(&mut self, mut x: usize) -> usize {
        while self.0[x] != x {
            self.0[x] = self.0[self.0[x]];
            x = self.0[x];
        }
        x
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b)] = a.min(b);
    }

    fn count(&self) -> usize {
        self.0.iter().enumerate().filter(|&(k, &root)| k == root).count()
    }
}
