//! Regular maps on the sphere and the torus.
//!
//! In: a solid, a number or a step on the torus. Out: [`Presentation`]s. Holds: each is finite and of the stated type.
//! Source: [CoxeterMoser1980] §§4.2, 8.3, 8.4.

use crate::error::MapError;
use crate::map::RegularMap;
use crate::presentation::Presentation;
use crate::word::{Letter, Word};

/// The Platonic solids by name.
const SOLIDS: [(&str, usize, usize); 5] =
    [("tetrahedron", 3, 3), ("cube", 4, 3), ("octahedron", 3, 4), ("dodecahedron", 5, 3), ("icosahedron", 3, 5)];

/// A Platonic solid.
///
/// # Input      tetrahedron, cube, octahedron, dodecahedron or icosahedron, in any case
pub fn platonic(name: &str) -> Option<Presentation> {
    let name = name.trim().to_lowercase();
    SOLIDS.iter().find(|solid| solid.0 == name).map(|&(_, p, q)| Presentation::new(p, q, Vec::new()))
}

/// The name of the solid of type {p, q}.
pub fn platonic_name(p: usize, q: usize) -> Option<&'static str> {
    SOLIDS.iter().find(|solid| (solid.1, solid.2) == (p, q)).map(|solid| solid.0)
}

/// The sphere cut into n digons {2, n} that meet at two poles. Its dual {n, 2} is a polygon with two sides.
///
/// # Errors     [`MapError::NoType`] for n below 2; [`MapError::NotRegular`] for n beyond 1000
pub fn hosohedron(n: usize) -> Result<Presentation, MapError> {
    match n {
        0 | 1 => Err(MapError::NoType('S')),
        2..=MOST_DIGONS => Ok(Presentation::new(2, n, Vec::new())),
        _ => Err(MapError::NotRegular(format!("{{2,{n}}} has more than {MOST_DIGONS} faces"))),
    }
}

/// Most digons of a hosohedron: the time of its coset enumeration grows with the square.
const MOST_DIGONS: usize = 1000;

/// The tilings of the plane by one regular polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ToroidalType {
    /// {4,4}
    Squares,
    /// {3,6}
    Triangles,
    /// {6,3}
    Hexagons,
}

/// The map {4,4}, {3,6} or {6,3} on the torus with translation (b, c): b edges straight on, then c after a turn by
/// 90° or 60°; for hexagons the steps go from face to face.
///
/// # Errors     [`MapError::NotRegular`] unless c = 0 or b = c: all others are not their own mirror images; and for b = 0
pub fn toroidal(kind: ToroidalType, b: usize, c: usize) -> Result<Presentation, MapError> {
    let (p, q) = kind.p_q();
    let refuse = |what: String| Err(MapError::NotRegular(what));
    if b.max(c) > LARGEST {
        return refuse(format!("{{{p},{q}}}_({b},{c}) has steps of more than {LARGEST}"));
    }
    let (b, c) = if b == 0 { (c, 0) } else { (b, c) };
    let step = match (b, c) {
        (0, _) => return refuse(format!("{{{p},{q}}}_(0,0) has no size")),
        (_, 0) => kind.straight(),
        _ if b == c => kind.skew(),
        _ => return refuse(format!("{{{p},{q}}}_({b},{c}) is chiral; (b,0) and (b,b) are their own mirror images")),
    };
    Ok(Presentation::new(p, q, vec![step.power(b as i64)]))
}

/// Most steps: a map has up to 36·b² flags, and the time of its coset enumeration grows with b³.
const LARGEST: usize = 60;

impl ToroidalType {
    /// The type {p, q}, if it is one of the torus.
    pub fn of(p: usize, q: usize) -> Option<Self> {
        match (p, q) {
            (4, 4) => Some(Self::Squares),
            (3, 6) => Some(Self::Triangles),
            (6, 3) => Some(Self::Hexagons),
            _ => None,
        }
    }

    /// The translation of a map of this type, as `(b,c)`.
    pub(crate) fn step_of(self, map: &RegularMap) -> (usize, usize) {
        let root = |n: usize| (1..=n).find(|b| b * b >= n).unwrap_or(n);
        // Cells of the lattice: b² for (b, 0), and two or three times as many for (b, b).
        let (cells, skew) = match self {
            Self::Squares => (map.face_count(), 2),
            Self::Triangles => (map.vertex_count(), 3),
            Self::Hexagons => (map.face_count(), 3),
        };
        let b = root(cells);
        if b * b == cells { (b, 0) } else { (root(cells / skew), root(cells / skew)) }
    }

    fn p_q(self) -> (usize, usize) {
        match self {
            Self::Squares => (4, 4),
            Self::Triangles => (3, 6),
            Self::Hexagons => (6, 3),
        }
    }

    /// The translation by one edge (for hexagons, from a face to the next).
    fn straight(self) -> Word {
        use Letter::{R, RInverse, S, SInverse};
        match self {
            // A quarter turn about a face and one back about its corner.
            Self::Squares => Word::new([R, SInverse]),
            // A third of a turn about a face, and back about its corner by two sixths.
            Self::Triangles => Word::new([RInverse, S, S]),
            // The dual's, R and S exchanged.
            Self::Hexagons => Word::new([SInverse, R, R]),
        }
    }

    /// The translation that is the sum of one by an edge and of the same turned.
    fn skew(self) -> Word {
        let step = self.straight();
        let turn = match self {
            Self::Hexagons | Self::Squares => Word::new([Letter::R]),
            Self::Triangles => Word::new([Letter::S]),
        };
        step.then(&turn).then(&step).then(&turn.inverse())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coset::CosetLimit;

    fn map(presentation: &Presentation) -> RegularMap {
        RegularMap::from_presentation(presentation, CosetLimit::default()).unwrap()
    }

    #[test]
    fn solids_have_their_faces() {
        let counts = SOLIDS.map(|(name, ..)| map(&platonic(name).unwrap()).face_count());
        assert_eq!(counts, [4, 6, 8, 12, 20]);
        assert!(platonic("Icosahedron ").is_some() && platonic("sphere").is_none());
        assert_eq!(map(&hosohedron(7).unwrap()).face_count(), 7);
        assert_eq!(hosohedron(1), Err(MapError::NoType('S')));
    }

    #[test]
    fn tori_have_the_area_of_their_lattice() {
        use ToroidalType::{Hexagons, Squares, Triangles};
        for b in 1..=5 {
            let faces = |kind, c| {
                let found = map(&toroidal(kind, b, c).unwrap());
                assert_eq!((found.genus(), found.is_orientable()), (1, true));
                found.face_count()
            };
            assert_eq!([faces(Squares, 0), faces(Squares, b)], [b * b, 2 * b * b]);
            assert_eq!([faces(Triangles, 0), faces(Triangles, b)], [2 * b * b, 6 * b * b]);
            assert_eq!([faces(Hexagons, 0), faces(Hexagons, b)], [b * b, 3 * b * b]);
        }
    }

    #[test]
    fn a_torus_may_have_many_faces() {
        let orders = [ToroidalType::Squares, ToroidalType::Triangles, ToroidalType::Hexagons]
            .map(|kind| map(&toroidal(kind, 24, 24).unwrap()).order());
        assert_eq!(orders, [16 * 576, 36 * 576, 36 * 576]);
        assert!(toroidal(ToroidalType::Squares, 61, 0).is_err());
    }

    #[test]
    fn chiral_tori_are_refused() {
        assert!(toroidal(ToroidalType::Squares, 2, 1).unwrap_err().to_string().contains("chiral"));
        assert!(toroidal(ToroidalType::Squares, 0, 0).is_err());
        assert_eq!(toroidal(ToroidalType::Squares, 0, 3), toroidal(ToroidalType::Squares, 3, 0));
    }
}
