//! Which map is meant, as text.
//!
//! In: names and presentations as a user types them. Out: [`NamedMap`]s. Holds: what cannot be meant is an error that says
//! what can be. Not: names in Conder's list where that is not certain.

use crate::error::RemeshError;
use quadloom_regular_maps::catalogue::{self, Entry};
use quadloom_regular_maps::{CosetLimit, MapError, Presentation, RegularMap};

/// Which map is meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MapSpec {
    /// A name, an identifier, a type; ' or ′ after it means the dual. See [`catalogue::find`].
    Name(String),
    /// Relators. See [`Presentation::parse`].
    Presentation(String),
}

/// A map and how it is called.
#[derive(Clone, Debug)]
pub struct NamedMap {
    /// Conder's name where it is certain, else the identifier; ′ after it where it is the dual.
    pub name: String,
    /// `{p,q}_r#genus.k` where the map is in the catalogue, else `{p,q}_r#genus`, `#N` with the number of crosscaps where
    /// the surface is not orientable; ′ after it where it is the dual of the map in the catalogue.
    pub identifier: String,
    /// The map.
    pub map: RegularMap,
    /// Its group.
    pub presentation: Presentation,
}

/// Looks a map up, or enumerates the group of a presentation.
///
/// # Errors     [`RemeshError::Catalogue`]: unknown and ambiguous names; [`RemeshError::Map`]: syntax, groups that are too
///   large or have another type
/// # Cost       a coset enumeration
pub fn find_map(spec: &MapSpec) -> Result<NamedMap, RemeshError> {
    match spec {
        MapSpec::Name(text) => {
            let entry = catalogue::find(text)?;
            let map = entry.map()?;
            // A solid's dual has a name of its own.
            let [name, identifier] = if map.genus() < 2 { name_of(&map) } else { labels(&entry) };
            Ok(NamedMap { name, identifier, map, presentation: entry.presentation })
        }
        MapSpec::Presentation(text) => {
            let presentation = Presentation::parse(text)?;
            let map = RegularMap::from_presentation(&presentation, CosetLimit::default()).map_err(too_small)?;
            let [name, identifier] = name_of(&map);
            Ok(NamedMap { name, identifier, map, presentation })
        }
    }
}

/// What is no regular map has lost elements that a map needs.
fn too_small(error: MapError) -> RemeshError {
    match error {
        MapError::NotRegular(_) => {
            let why = format!("{error}; the relators leave too small a group: check their exponents");
            RemeshError::Argument { option: "presentation", why }
        }
        other => other.into(),
    }
}

/// Name and identifier of any map.
pub(super) fn name_of(map: &RegularMap) -> [String; 2] {
    match catalogue::identify(map) {
        Some(entry) => labels(&entry),
        None => {
            let crosscaps = if map.is_orientable() { "" } else { "N" };
            let identifier = format!("{}#{crosscaps}{}", map.type_name(), map.genus());
            [identifier.clone(), identifier]
        }
    }
}

/// Name and identifier of a map of the catalogue.
pub(super) fn labels(entry: &Entry) -> [String; 2] {
    [entry.label(), &entry.identifier].map(|text| text.replace('\'', "′"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels_of(spec: &MapSpec) -> [String; 2] {
        let found = find_map(spec).unwrap();
        [found.name, found.identifier]
    }

    #[test]
    fn names_do_not_depend_on_how_a_map_was_found() {
        let klein = ["R3.1".to_string(), "{3,7}_8#3.1".into()];
        assert_eq!(labels_of(&MapSpec::Name("{3,7}_8".into())), klein);
        assert_eq!(labels_of(&MapSpec::Presentation("R^3, S^7, (R*S^-2)^4".into())), klein);
        let dual = klein.map(|text| text + "′");
        assert_eq!(labels_of(&MapSpec::Name("R3.1'".into())), dual);
        assert_eq!(labels_of(&MapSpec::Presentation("R^7, S^3, (S*R^-2)^4".into())), dual);
        assert_eq!(labels_of(&MapSpec::Name("cube′".into()))[0], "octahedron");
    }

    #[test]
    fn maps_outside_the_catalogue_are_named_by_their_numbers() {
        let half_a_cube = MapSpec::Presentation("R^4, S^3, (R*S*T)^3".into());
        assert_eq!(labels_of(&half_a_cube)[0], "{4,3}_3#N1");
    }
}
