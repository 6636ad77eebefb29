//! Names of maps as they are typed.
//!
//! In: text. Out: [`Query`], and whether the dual is meant. Not: whether there is such a map.

use super::{CatalogueError, Entry};
use crate::enumerate::{hosohedron, platonic};
use crate::presentation::Presentation;

/// What a name says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Query {
    /// `R3.1`
    Conder { genus: usize, index: usize },
    /// `cube`, `hosohedron 6`
    Solid(Presentation),
    /// `{3,7}_8#3.1`
    Type(TypeQuery),
}

/// A type and what else was said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct TypeQuery {
    pub(super) p: usize,
    pub(super) q: usize,
    pub(super) petrie: Option<usize>,
    /// `_(b,c)`
    pub(super) torus: Option<(usize, usize)>,
    pub(super) genus: Option<usize>,
    /// Number among the maps of the genus.
    pub(super) number: Option<usize>,
}

impl TypeQuery {
    /// Whether nothing that was said is wrong for this map.
    pub(super) fn fits(&self, entry: &Entry) -> bool {
        let number = entry.identifier.rsplit_once('.').and_then(|(_, k)| k.parse().ok());
        (self.p, self.q) == (entry.p, entry.q)
            && self.petrie.is_none_or(|r| r == entry.petrie)
            && self.genus.is_none_or(|g| g == entry.genus)
            && self.number.is_none_or(|k| Some(k) == number)
    }
}

/// Reads a name; true where it ends in an odd number of dashes.
pub(super) fn read(name: &str) -> Result<(Query, bool), CatalogueError> {
    let trimmed = name.trim();
    let bare = trimmed.trim_end_matches(['\'', '′', '’', '`']);
    let dashes = trimmed[bare.len()..].chars().count();
    let bare = bare.trim_end();
    let query = conder(bare).or_else(|| named(bare)).or_else(|| typed(bare).map(Query::Type));
    query.map(|query| (query, dashes % 2 == 1)).ok_or_else(|| CatalogueError::Unreadable(trimmed.into()))
}

fn conder(text: &str) -> Option<Query> {
    let (genus, index) = text.strip_prefix(['R', 'r'])?.split_once('.')?;
    Some(Query::Conder { genus: number(genus)?, index: number(index)? })
}

fn named(text: &str) -> Option<Query> {
    if let Some(solid) = platonic(text) {
        return Some(Query::Solid(solid));
    }
    let (kind, n) = text.split_once(char::is_whitespace)?;
    let found = hosohedron(number(n.trim())?).ok()?;
    match kind.to_lowercase().as_str() {
        "hosohedron" => Some(Query::Solid(found)),
        "dihedron" => Some(Query::Solid(found.dual())),
        _ => None,
    }
}

fn typed(text: &str) -> Option<TypeQuery> {
    let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let (kind, rest) = text.strip_prefix('{')?.split_once('}')?;
    let (p, q) = pair(kind)?;
    if p < 2 || q < 2 || p.max(q) > LARGEST {
        return None;
    }
    let (size, place) = match rest.split_once('#') {
        Some((size, place)) => (size, Some(place)),
        None => (rest, None),
    };
    let mut query = TypeQuery { p, q, ..TypeQuery::default() };
    match size.strip_prefix('_') {
        Some(size) => match size.strip_prefix(['(', '{']) {
            Some(step) => query.torus = Some(pair(step.strip_suffix([')', '}'])?)?),
            None => query.petrie = Some(number(size)?),
        },
        None if size.is_empty() => {}
        None => return None,
    }
    if let Some(place) = place {
        let (genus, k) = match place.split_once('.') {
            Some((genus, k)) => (genus, Some(number(k)?)),
            None => (place, None),
        };
        (query.genus, query.number) = (Some(number(genus)?), k);
    }
    Some(query)
}

/// Largest p or q that is read.
const LARGEST: usize = 1_000_000;

fn pair(text: &str) -> Option<(usize, usize)> {
    let (a, b) = text.split_once(',')?;
    Some((number(a)?, number(b)?))
}

/// Digits alone: no sign.
fn number(text: &str) -> Option<usize> {
    (!text.is_empty() && text.chars().all(|c| c.is_ascii_digit())).then(|| text.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_an_identifier_are_read() {
        let kind = TypeQuery { p: 3, q: 7, ..TypeQuery::default() };

        assert_eq!(read("{3,7}"), Ok((Query::Type(kind), false)));
        assert_eq!(read("{3,7}_8'"), Ok((Query::Type(TypeQuery { petrie: Some(8), ..kind }), true)));
        let whole = TypeQuery { petrie: Some(8), genus: Some(3), number: Some(1), ..kind };
        assert_eq!(read(" {3, 7}_8#3.1 ′"), Ok((Query::Type(whole), true)));
        assert_eq!(read("{3,7}#3"), Ok((Query::Type(TypeQuery { genus: Some(3), ..kind }), false)));
        let torus = TypeQuery { p: 4, q: 4, torus: Some((2, 0)), ..TypeQuery::default() };
        assert_eq!(read("{4,4}_(2,0)"), Ok((Query::Type(torus), false)));
        assert_eq!(read("{4,4}_{2,0}"), Ok((Query::Type(torus), false)));
        assert_eq!(read("R12.3''"), Ok((Query::Conder { genus: 12, index: 3 }, false)));
    }

    #[test]
    fn what_is_no_name_is_refused() {
        for text in
            ["", "'", "R3", "R3.", "R.1", "R-3.1", "{3,7", "{3}", "{3,7}_", "{3,7}8", "{1,7}", "sphere", "hosohedron x"]
        {
            assert_eq!(read(text), Err(CatalogueError::Unreadable(text.into())), "{text}");
        }
        assert!(read("{3,99999999999999999999999}").is_err() && read("{4,4}_(2,0").is_err());
    }
}
