//! One map of the catalogue.
//!
//! In: the crate's data files, or a presentation. Out: [`Entry`]. Holds: numbers are those of the map of the presentation;
//! maps of a genus are numbered from 1 in the order of the file.

use super::COMPLETE;
use crate::coset::CosetLimit;
use crate::enumerate::{ToroidalType, platonic_name};
use crate::error::MapError;
use crate::map::RegularMap;
use crate::presentation::Presentation;
use crate::word::{Letter, Word};
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;

/// A regular map with its names and numbers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Entry {
    /// Conder's name (`R3.1`) where it is certain, or that of a solid; with a dash for a dual.
    pub name: Option<String>,
    /// `{p,q}_r#genus.k`: type, Petrie length, and a number among the maps of the genus in the catalogue; on the sphere
    /// `{p,q}`, on the torus `{p,q}_(b,c)`. [`super::find`] finds the map by it.
    pub identifier: String,
    /// Corners of a face.
    pub p: usize,
    /// Faces at a vertex.
    pub q: usize,
    /// Edges of a Petrie polygon.
    pub petrie: usize,
    /// Order of the full group: four per edge.
    pub order: usize,
    /// Genus of the surface.
    pub genus: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of faces.
    pub faces: usize,
    /// See [`RegularMap::multiplicities`].
    #[serde(skip)]
    pub multiplicities: [usize; 2],
    /// True where the map is its own dual.
    #[serde(skip)]
    pub self_dual: bool,
    /// True for the dual of the map that the name has without its dash.
    #[serde(skip)]
    pub dual: bool,
    /// The group; text in JSON.
    #[serde(serialize_with = "as_text")]
    pub presentation: Presentation,
}

fn as_text<S: Serializer>(presentation: &Presentation, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(presentation)
}

impl Entry {
    /// The map.
    ///
    /// # Errors     none for entries of the catalogue
    /// # Cost       a coset enumeration: milliseconds
    pub fn map(&self) -> Result<RegularMap, MapError> {
        RegularMap::from_presentation(&self.presentation, CosetLimit::default())
    }

    /// The dual of this map; of a dual, the map itself.
    pub fn dual(&self) -> Self {
        let dashed = |name: &String| name.strip_suffix('\'').map_or_else(|| format!("{name}'"), String::from);
        Self {
            name: self.name.as_ref().map(dashed),
            identifier: dashed(&self.identifier),
            p: self.q,
            q: self.p,
            vertices: self.faces,
            faces: self.vertices,
            multiplicities: [self.multiplicities[1], self.multiplicities[0]],
            dual: !self.dual,
            presentation: swapped(&self.presentation),
            ..self.clone()
        }
    }

    /// What to call the map: its name, or else its identifier.
    pub fn label(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.identifier)
    }

    /// The entry of a map on the sphere or the torus.
    pub(super) fn of(presentation: Presentation) -> Result<Self, MapError> {
        let map = RegularMap::from_presentation(&presentation, CosetLimit::default())?;
        let (p, q) = (map.p(), map.q());
        let identifier = match ToroidalType::of(p, q) {
            Some(kind) => {
                let (b, c) = kind.step_of(&map);
                format!("{{{p},{q}}}_({b},{c})")
            }
            None => format!("{{{p},{q}}}"),
        };
        Ok(Self {
            name: spherical_name(p, q).filter(|_| map.genus() == 0),
            identifier,
            p,
            q,
            petrie: map.petrie(),
            order: map.order(),
            genus: map.genus(),
            vertices: map.vertex_count(),
            edges: map.edge_count(),
            faces: map.face_count(),
            multiplicities: map.multiplicities(),
            self_dual: map.is_self_dual(),
            dual: false,
            presentation,
        })
    }

    pub(super) fn has_numbers_of(&self, map: &RegularMap) -> bool {
        (self.p, self.q, self.petrie, self.order) == (map.p(), map.q(), map.petrie(), map.order())
            && self.multiplicities == map.multiplicities()
    }
}

/// The dual's presentation: R and S change places. (In reflections R becomes S⁻¹ and S becomes R⁻¹; T then inverts both.)
fn swapped(presentation: &Presentation) -> Presentation {
    let swap = |letter: &Letter| match letter {
        Letter::R => Letter::S,
        Letter::S => Letter::R,
        Letter::RInverse => Letter::SInverse,
        Letter::SInverse => Letter::RInverse,
        Letter::T => Letter::T,
    };
    let words = presentation.extra.iter().map(|word| Word::new(word.letters().iter().map(swap)));
    Presentation::new(presentation.q, presentation.p, words.collect())
}

fn spherical_name(p: usize, q: usize) -> Option<String> {
    match (p, q) {
        (2, n) => Some(format!("hosohedron {n}")),
        (n, 2) => Some(format!("dihedron {n}")),
        _ => platonic_name(p, q).map(String::from),
    }
}

/// Reads the data files; they are part of the program, so a line that cannot be read is a mistake in it.
pub(super) fn read(maps: &str, names: &str) -> Vec<Entry> {
    let mut of_genus = BTreeMap::new();
    let mut entries = Vec::new();
    for line in rows(maps) {
        let entry = entry(&line).expect("the catalogue's own data can be read");
        let k = of_genus.entry(entry.genus).or_insert(0usize);
        *k += 1;
        entries.push(Entry { identifier: format!("{}#{}.{k}", entry.identifier, entry.genus), ..entry });
    }
    let certain = names_by_type(&entries);
    for (entry, name) in entries.iter_mut().zip(certain) {
        entry.name = name;
    }
    for line in rows(names) {
        let named = entries.iter_mut().find(|entry| line.get(1) == Some(&entry.identifier.as_str()));
        named.expect("names are those of maps in the catalogue").name = line.first().map(|name| String::from(*name));
    }
    entries
}

/// Lines of tab-separated fields, without comments.
fn rows(text: &str) -> impl Iterator<Item = Vec<&str>> {
    text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).map(|line| line.split('\t').collect())
}

fn entry(fields: &[&str]) -> Option<Entry> {
    let &[genus, p, q, petrie, order, of_vertex, of_face, self_dual, relators] = fields else { return None };
    let [genus, p, q] = numbers([genus, p, q])?;
    let [petrie, order, of_vertex, of_face] = numbers([petrie, order, of_vertex, of_face])?;
    let words = relators.split(", ").map(Word::parse).collect::<Result<_, _>>().ok()?;
    let edges = order / 4;
    Some(Entry {
        name: None,
        identifier: format!("{{{p},{q}}}_{petrie}"),
        p,
        q,
        petrie,
        order,
        genus,
        vertices: 2 * edges / q,
        edges,
        faces: 2 * edges / p,
        multiplicities: [of_vertex, of_face],
        self_dual: self_dual == "self-dual",
        dual: false,
        presentation: Presentation::new(p, q, words),
    })
}

fn numbers<const N: usize>(texts: [&str; N]) -> Option<[usize; N]> {
    let mut numbers = [0; N];
    for (number, text) in numbers.iter_mut().zip(texts) {
        *number = text.parse().ok()?;
    }
    Some(numbers)
}

/// In Conder's list maps of a genus go by p, then q: a type that occurs once has a certain name.
fn names_by_type(entries: &[Entry]) -> Vec<Option<String>> {
    let mut names = Vec::new();
    for genus in entries.chunk_by(|a, b| a.genus == b.genus) {
        for kind in genus.chunk_by(|a, b| (a.p, a.q) == (b.p, b.q)) {
            let index = 1 + genus.iter().filter(|e| (e.p, e.q) < (kind[0].p, kind[0].q)).count();
            let certain = kind.len() == 1 && COMPLETE.contains(&kind[0].genus);
            names.extend(kind.iter().map(|entry| certain.then(|| format!("R{}.{index}", entry.genus))));
        }
    }
    names
}
