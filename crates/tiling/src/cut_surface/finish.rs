//! The refined mesh of a cut surface.
//!
//! In: the surface with its cuts. Out: [`Finished`]: triangles, where each vertex and face comes from.
//! Holds: vertices of the mesh come first, with their ids; points of an edge are evenly spaced on it in their order;
//! every triangle lies in one of the mesh's and has three corners that are not on one line; what was an edge is one.

use super::{CutSurface, NONE, Place};
use quadloom_mesh::{DVec3, FaceId, FaceMap, MeshError, SurfacePoint, TriMesh, VertexMap};

/// A refined mesh and its relation to the one it was made from.
pub(crate) struct Finished {
    pub mesh: TriMesh,
    pub parent: FaceMap<FaceId>,
    pub place: VertexMap<SurfacePoint>,
}

/// Positions and places of points, filled line by line.
struct Placing<'s, 'a> {
    surface: &'s CutSurface<'a>,
    position: Vec<DVec3>,
    place: Vec<SurfacePoint>,
}

impl CutSurface<'_> {
    /// Places all points and cuts the faces into triangles.
    ///
    /// # Errors     [`MeshError`] if there are more elements than ids
    pub fn finish(&self) -> Result<Finished, MeshError> {
        let Placing { position, place, .. } = Placing::all(self);
        let mut faces = Vec::with_capacity(self.side.len());
        let mut parent = Vec::with_capacity(self.side.len());
        for f in 0..self.side.len() as u32 {
            let polygon: Vec<(u32, u32)> = self
                .sides(f)
                .iter()
                .map(|&h| (self.point[self.origin[h as usize] as usize], self.line[h as usize]))
                .collect();
            let before = faces.len();
            clip_ears(polygon, &position, &mut faces);
            parent.resize(parent.len() + faces.len() - before, FaceId(self.parent[f as usize]));
        }
        Ok(Finished {
            mesh: TriMesh::new(position, &faces)?,
            parent: FaceMap::from_vec(parent),
            place: VertexMap::from_vec(place),
        })
    }
}

impl<'s, 'a> Placing<'s, 'a> {
    fn all(surface: &'s CutSurface<'a>) -> Self {
        let mesh = surface.mesh;
        let nowhere = SurfacePoint { face: FaceId(0), weights: [0.0; 3] };
        let mut placing =
            Self { surface, position: mesh.positions().values().to_vec(), place: vec![nowhere; surface.base.len()] };
        placing.position.resize(surface.base.len(), DVec3::ZERO);
        for v in mesh.vertices() {
            let h = mesh.outgoing_half_edge(v);
            let face = mesh.face(h);
            let mut weights = [0.0; 3];
            weights[(h.0 - mesh.first_half_edge(face).0) as usize] = 1.0;
            placing.place[v.index()] = SurfacePoint { face, weights };
        }
        // Lines and centres in the order in which they were made: each rests on earlier ones.
        let mut centres: Vec<(u32, &(Vec<u32>, usize))> = Vec::new();
        for (point, place) in surface.place.iter().enumerate() {
            if let Place::Centre(k) = *place {
                centres.push((point as u32, &surface.centres[k as usize]));
            }
        }
        let mut centres = centres.into_iter().peekable();
        for line in 0..surface.ends.len() {
            while let Some((point, (corners, _))) = centres.next_if(|(_, (_, lines))| *lines <= line) {
                placing.place_centre(point, corners, surface.chord_face[line - mesh.edge_count()]);
            }
            placing.place_line(line);
        }
        placing
    }

    /// Spaces the points of a line evenly.
    fn place_line(&mut self, line: usize) {
        let surface = self.surface;
        let mut points = Vec::new();
        let mut at = surface.first[line];
        while at != NONE {
            points.push(at);
            at = surface.after[at as usize];
        }
        if points.is_empty() {
            return;
        }
        let mesh = surface.mesh;
        let [a, b] = surface.ends[line];
        let face = match line.checked_sub(mesh.edge_count()) {
            Some(chord) => FaceId(surface.chord_face[chord]),
            None => mesh.edge_faces(quadloom_mesh::EdgeId(line as u32)).0,
        };
        let (from, to) = (self.weights_in(a, face), self.weights_in(b, face));
        let (p, q) = (self.position[a as usize], self.position[b as usize]);
        let pieces = points.len() as f64 + 1.0;
        for (k, &point) in points.iter().enumerate() {
            let t = (k as f64 + 1.0) / pieces;
            self.position[point as usize] = p + (q - p) * t;
            let weights = std::array::from_fn(|i| from[i] + (to[i] - from[i]) * t);
            self.place[point as usize] = SurfacePoint { face, weights };
        }
    }

    fn place_centre(&mut self, point: u32, corners: &[u32], face: u32) {
        let (mut position, mut weights) = (DVec3::ZERO, [0.0; 3]);
        let share = 1.0 / corners.len() as f64;
        for &corner in corners {
            position += self.position[corner as usize] * share;
            let at = self.weights_in(corner, FaceId(face));
            (0..3).for_each(|i| weights[i] += at[i] * share);
        }
        self.position[point as usize] = position;
        self.place[point as usize] = SurfacePoint { face: FaceId(face), weights };
    }

    /// Weights of a placed point in a face of the mesh on which it lies.
    fn weights_in(&self, point: u32, face: FaceId) -> [f64; 3] {
        let place = self.place[point as usize];
        if place.face == face {
            return place.weights;
        }
        let mesh = self.surface.mesh;
        let (own, other) = (mesh.face_vertices(place.face), mesh.face_vertices(face));
        other.map(|v| own.iter().position(|&w| w == v).map_or(0.0, |k| place.weights[k]))
    }
}

/// Cuts a convex polygon into triangles none of which has its corners on one line.
///
/// # Input      polygon: points, each with the line of the side that leaves it
fn clip_ears(mut polygon: Vec<(u32, u32)>, position: &[DVec3], faces: &mut Vec<[u32; 3]>) {
    while polygon.len() > 3 {
        let n = polygon.len();
        // The ear whose cut is shortest, among those that leave neither a flat triangle nor a flat rest.
        let cut = |i: usize| {
            let [a, b] = [polygon[(i + n - 1) % n].0, polygon[(i + 1) % n].0].map(|p| position[p as usize]);
            a.distance_squared(b)
        };
        let sharp = |i: usize| polygon[(i + n - 1) % n].1 != polygon[i].1;
        let rest_has_area = |i: usize| (i + 1..i + n - 2).any(|k| polygon[k % n].1 != polygon[(k + 1) % n].1);
        let ears = (0..n).filter(|&i| sharp(i) && rest_has_area(i));
        let ear = ears.min_by(|&i, &j| cut(i).total_cmp(&cut(j))).unwrap_or(0);
        let before = (ear + n - 1) % n;
        faces.push([polygon[before].0, polygon[ear].0, polygon[(ear + 1) % n].0]);
        // The new side is on a line of its own.
        polygon[before].1 = NONE - n as u32;
        polygon.remove(ear);
    }
    faces.push([polygon[0].0, polygon[1].0, polygon[2].0]);
}
