//! What is reported about a realised map.
//!
//! In: a [`Realization`]. Out: [`RealizeReport`], [`TubifyReport`]: JSON, and facts for people. Lengths in millimetres.

use super::NamedMap;
use super::colors::Shown;
use super::request::name_of;
use quadloom_mesh::{FaceShape, Mesh};
use quadloom_regular_maps::{Pole, RegularMap, TubeMatch};
use quadloom_tubification::realize::{Realization, SkeletonKind, Tubified};
use quadloom_tubification::{Drawn, DrawnCounts};
use serde::Serialize;

/// A map by its numbers.
#[derive(Clone, Debug, Serialize)]
pub struct MapReport {
    /// Its name, or its identifier where it has none that is certain.
    pub name: String,
    /// `{p,q}_r#genus`, with its number in the catalogue where it is there; ′ after it where its dual is.
    pub identifier: String,
    /// Corners of a face.
    pub p: usize,
    /// Faces at a vertex.
    pub q: usize,
    /// Length of Petrie polygons.
    pub petrie: usize,
    /// Order of the full group.
    pub order: usize,
    /// Genus: handles, or crosscaps where the surface is not orientable.
    pub genus: usize,
    /// Whether the surface is orientable.
    pub orientable: bool,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of faces.
    pub faces: usize,
    /// Edges between two vertices that are joined, and between two faces that are neighbours.
    pub multiplicities: [usize; 2],
    /// Whether the map is its own dual.
    pub self_dual: bool,
    /// The group, where the map was asked for or listed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub presentation: Option<String>,
}

impl MapReport {
    /// Numbers of a map.
    pub fn of(map: &RegularMap) -> Self {
        Self::named(map, name_of(map))
    }

    /// Numbers of a map whose name and identifier are known.
    pub(super) fn named(map: &RegularMap, [name, identifier]: [String; 2]) -> Self {
        Self {
            name,
            identifier,
            p: map.p(),
            q: map.q(),
            petrie: map.petrie(),
            order: map.order(),
            genus: map.genus(),
            orientable: map.is_orientable(),
            vertices: map.vertex_count(),
            edges: map.edge_count(),
            faces: map.face_count(),
            multiplicities: map.multiplicities(),
            self_dual: map.is_self_dual(),
            presentation: None,
        }
    }

    /// Name and identifier, once where they are the same.
    fn names(&self) -> String {
        if self.name == self.identifier { self.name.clone() } else { format!("{} {}", self.name, self.identifier) }
    }

    /// Facts for people: name and value.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let yes = |b: bool| String::from(if b { "yes" } else { "no" });
        let [of_vertices, of_faces] = self.multiplicities;
        let mut rows = vec![
            ("name", self.name.clone()),
            ("identifier", self.identifier.clone()),
            ("type", format!("{{{},{}}}", self.p, self.q)),
            ("Petrie polygons", format!("{} edges", self.petrie)),
            ("order of the group", self.order.to_string()),
            (if self.orientable { "genus" } else { "crosscaps" }, self.genus.to_string()),
            ("vertices, edges, faces", format!("{}, {}, {}", self.vertices, self.edges, self.faces)),
            ("multiplicities", format!("{of_vertices} of vertices, {of_faces} of faces")),
            ("orientable", yes(self.orientable)),
            ("self-dual", yes(self.self_dual)),
        ];
        rows.extend(self.presentation.iter().map(|text| ("group", text.clone())));
        rows
    }
}

/// A target that a source can be drawn on.
#[derive(Clone, Debug, Serialize)]
pub struct MatchReport {
    /// The target.
    pub target: MapReport,
    /// What of the source lies at the poles of junctions.
    pub pole: Pole,
    /// Index of the surface's group in the source's rotation group.
    pub index: usize,
    /// Number of junctions.
    pub junctions: usize,
    /// Tubes at a junction.
    pub valence: usize,
    /// Number of tubes.
    pub tubes: usize,
    /// Whether tubes are half twisted.
    pub twisted: bool,
}

impl MatchReport {
    /// Numbers of a match.
    pub fn of(found: &TubeMatch) -> Self {
        Self {
            target: MapReport::of(&found.target),
            pole: found.pole,
            index: found.index,
            junctions: found.junctions(),
            valence: found.target.q(),
            tubes: found.tubes(),
            twisted: !found.target.is_orientable(),
        }
    }
}

/// A rotation group.
#[derive(Clone, Debug, Serialize)]
pub struct SymmetryReport {
    /// Its name: C1 is no rotation but the identity.
    pub group: String,
    /// Number of rotations.
    pub order: usize,
    /// Largest error of a rotation, as a share of the surface's size.
    pub error: f64,
}

/// A tube surface.
#[derive(Clone, Debug, Serialize)]
pub struct TubeReport {
    /// The map whose edges are tubes.
    pub target: MapReport,
    /// Where the tubes' axes come from.
    pub skeleton: SkeletonKind,
    /// Number of junctions.
    pub junctions: usize,
    /// Number of tubes.
    pub tubes: usize,
    /// Radius of the tubes, millimetres.
    pub radius: f64,
    /// Vertices, edges and faces of the cage of one quadrangle for each quarter-tube.
    pub cage: [usize; 3],
    /// Rotations that the surface has in space.
    pub symmetry: SymmetryReport,
}

impl TubeReport {
    /// Numbers of a surface.
    pub fn of(target: &RegularMap, tubes: &Tubified, scale: f64) -> Self {
        Self {
            target: MapReport::of(target),
            skeleton: tubes.kind,
            junctions: target.vertex_count(),
            tubes: target.edge_count(),
            radius: tubes.surface.radius() * scale,
            cage: tubes.surface.cage_counts(),
            symmetry: SymmetryReport {
                group: tubes.rotations.group.to_string(),
                order: tubes.rotations.elements.len(),
                error: tubes.rotations.error,
            },
        }
    }
}

/// A mesh by its numbers.
#[derive(Clone, Debug, Serialize)]
pub struct SurfaceReport {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Euler characteristic.
    pub chi: i64,
    /// Genus.
    pub genus: i64,
    /// Closed: every edge has two faces.
    pub closed: bool,
    /// Pairs of triangles that meet where they should not.
    pub self_intersections: usize,
}

impl SurfaceReport {
    /// Numbers of a mesh whose self-intersections were counted.
    pub(super) fn of<S: FaceShape>(mesh: &Mesh<S>, self_intersections: usize) -> Self {
        let chi = quadloom_mesh::topology::euler_characteristic(mesh.connectivity());
        Self {
            vertices: mesh.vertex_count(),
            faces: mesh.face_count(),
            chi,
            genus: (2 - chi) / 2,
            closed: mesh.edges().all(|e| !mesh.is_boundary_edge(e)),
            self_intersections,
        }
    }
}

/// Tubes around a map's own edges.
#[derive(Clone, Debug, Serialize)]
pub struct TubifyReport {
    /// The map and its tube surface.
    pub tubes: TubeReport,
    /// The quads.
    pub surface: SurfaceReport,
    /// Largest extent, millimetres.
    pub size: f64,
    /// Seconds for all of it.
    pub seconds: f64,
}

/// A map in space.
#[derive(Clone, Debug, Serialize)]
pub struct RealizeReport {
    /// The source.
    pub source: MapReport,
    /// Whether its dual is drawn.
    pub dual: bool,
    /// The target and its tube surface.
    pub surface_of: TubeReport,
    /// What of the source lies at the poles of junctions.
    pub pole: Pole,
    /// Index of the surface's group in the source's rotation group.
    pub index: usize,
    /// The triangles.
    pub surface: SurfaceReport,
    /// Counted on the triangles: the map that is drawn.
    pub map: DrawnCounts,
    /// Faces of the drawn map, by orbits under the rotations in space: numbers of faces that rotations take to each other.
    pub face_orbits: Vec<Vec<usize>>,
    /// Height of ridges and reliefs, millimetres: lower than asked for where there was no room.
    pub relief: f64,
    /// Number of colours.
    pub colors: usize,
    /// Largest extent, millimetres.
    pub size: f64,
    /// Seconds for all of it.
    pub seconds: f64,
}

/// The report without what [`super::realize_map`] alone knows: colours, size, time.
pub(super) fn realized(source: &NamedMap, shown: &Shown, found: &Realization, scale: f64) -> RealizeReport {
    RealizeReport {
        source: super::info(source),
        dual: found.drawing.drawn == Drawn::Dual,
        surface_of: TubeReport::of(&found.matched.target, &found.tubes, scale),
        pole: found.matched.pole,
        index: found.matched.index,
        surface: SurfaceReport::of(&found.drawing.mesh, found.intersections.len()),
        map: found.counts.clone(),
        face_orbits: shown.face_orbits(found),
        relief: found.relief,
        colors: 0,
        size: 0.0,
        seconds: 0.0,
    }
}

/// A target's name with its type.
pub fn target_name(target: &RegularMap) -> String {
    let [name, identifier] = name_of(target);
    if name == identifier { name } else { format!("{name} {}", target.type_name()) }
}

impl RealizeReport {
    /// One line about the whole.
    pub fn title(&self) -> String {
        let dual = if self.dual { "The dual of " } else { "" };
        let target = &self.surface_of.target.name;
        let article = if target.starts_with(char::is_lowercase) { "the " } else { "" };
        format!("{dual}{} on tubes around {article}{target}", self.source.name)
    }

    /// Facts for people: name and value.
    pub fn facts(&self) -> Vec<(String, String)> {
        let source = &self.source;
        let target = &self.surface_of.target;
        let orbits: Vec<String> = self.face_orbits.iter().map(|orbit| orbit.len().to_string()).collect();
        let facts = [
            ("map", source.names()),
            ("genus", source.genus.to_string()),
            ("drawn", format!("{} faces, {} edges, {} vertices", self.map.faces, self.map.edges, self.map.vertices)),
            ("symmetries of the map", source.order.to_string()),
            ("tubes around the edges of", target.names()),
            ("junctions, tubes", format!("{}, {}", self.surface_of.junctions, self.surface_of.tubes)),
            ("rotations in space", format!("{} ({})", self.surface_of.symmetry.group, self.surface_of.symmetry.order)),
            ("orbits of faces", orbits.join(" + ")),
        ];
        facts.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
    }
}
