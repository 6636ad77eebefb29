//! What a name can be instead of the name of one map.
//!
//! In: a name that was not found. Out: [`CatalogueError`], with what there is instead.

use super::query::TypeQuery;
use super::{COMPLETE, Entry, entries};
use crate::error::MapError;

/// Why there is no map of this name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CatalogueError {
    /// Not written as names are.
    #[error(
        "{0:?} is no name of a map; names are like R3.1, {{3,7}}_8#3.1, {{3,7}}_8, cube, hosohedron 6, {{4,4}}_(3,0), \
         each with ' after it for the dual"
    )]
    Unreadable(String),
    /// There is no such map, or it is not in the catalogue.
    #[error("there is no map {name} in the catalogue: {help}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// What there is instead.
        help: String,
    },
    /// A name of Conder's list that could be that of several maps.
    #[error(
        "{name} is one of {}, and which is not known: they have the same genus and type, and the list's order among \
         them is not published with their numbers; use one of these identifiers", .candidates.join(", ")
    )]
    Ambiguous {
        /// The name.
        name: String,
        /// Identifiers of the maps that it can be.
        candidates: Vec<String>,
    },
    /// A type with several maps.
    #[error("{name} fits {} maps; use one of their identifiers: {}", .candidates.len(), some(.candidates))]
    Several {
        /// What was asked for.
        name: String,
        /// Identifiers of the maps that fit.
        candidates: Vec<String>,
    },
    /// There is such a map, but it cannot be made.
    #[error(transparent)]
    Map(#[from] MapError),
}

/// Most names in a message.
const MOST: usize = 12;

fn some(names: &[String]) -> String {
    let rest = if names.len() > MOST { format!(" and {} more", names.len() - MOST) } else { String::new() };
    names[..names.len().min(MOST)].join(", ") + &rest
}

/// What the catalogue has of a genus.
pub(super) fn maps_of_genus(genus: usize, maps: &[&Entry]) -> String {
    match (genus, maps) {
        (0, _) => "on the sphere there are the five solids by name, {2,n} and {n,2}".into(),
        (1, _) => "on the torus say {4,4}_(b,c), {3,6}_(b,c) or {6,3}_(b,c), with c = 0 or c = b".into(),
        (_, []) => format!("it has {}; others can be searched", contents()),
        _ if COMPLETE.contains(&genus) => {
            format!("genus {genus} has {} maps up to duality, R{genus}.1 to R{genus}.{}", maps.len(), maps.len())
        }
        _ => {
            let labels: Vec<String> = maps.iter().map(|entry| entry.label().into()).collect();
            format!("of genus {genus} it has only {}", some(&labels))
        }
    }
}

/// What the catalogue has that is close to a type with p ≤ q.
pub(super) fn maps_of_type(kind: TypeQuery) -> String {
    let TypeQuery { p, q, genus, .. } = kind;
    let fitting = |keep: &dyn Fn(&Entry) -> bool| -> Vec<String> {
        entries().iter().filter(|e| keep(e)).map(|e| e.identifier.clone()).collect()
    };
    let of_both = fitting(&|e| (e.p, e.q) == (p, q) && genus.is_none_or(|g| g == e.genus));
    let of_type = fitting(&|e| (e.p, e.q) == (p, q));
    if !of_both.is_empty() {
        format!("of that type it has {}", some(&of_both))
    } else if !of_type.is_empty() {
        format!("of type {{{p},{q}}} it has {}", some(&of_type))
    } else {
        format!("it has {}, none of them of type {{{p},{q}}}", contents())
    }
}

fn contents() -> String {
    let larger: Vec<&str> =
        entries().iter().filter(|e| !COMPLETE.contains(&e.genus)).map(|e| e.identifier.as_str()).collect();
    format!("all maps of genus {} to {}, and {}", COMPLETE.start(), COMPLETE.end(), larger.join(", "))
}
