//! What has one colour.
//!
//! In: a colouring as a user types it, a realised map. Out: a class per triangle and a colour per class. Holds: colours of
//! the drawn map are those of its flat picture. Source: [Razafindrazaka2015] §9.5, Fig. 9.14.

use quadloom_mesh::Id;
use quadloom_regular_maps::colouring::{Colouring, palette};
use quadloom_regular_maps::{FlagId, FlagMap, MapFaceId, Reflection, RegularMap, Word};
use quadloom_tubification::Drawn;
use quadloom_tubification::realize::Realization;

/// What to colour by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ColorBy {
    /// Flags of the drawn map.
    Flags(Colouring),
    /// What tube element the surface is there ([Razafindrazaka2015] Fig. 9.14).
    Tubes(TubeElement),
    /// Orbits of the drawn map's faces under the rotations in space.
    Symmetry,
}

impl Default for ColorBy {
    fn default() -> Self {
        Self::Flags(Colouring::Face)
    }
}

/// Parts of a tube surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TubeElement {
    /// A quarter-tube.
    Quarter,
    /// Half the length of a tube.
    Half,
    /// All halves at a junction.
    Junction,
    /// A tube.
    Tube,
}

impl std::str::FromStr for ColorBy {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let words = |list: &str| -> Result<Vec<Word>, String> {
            list.split(',').map(|word| Word::parse(word).map_err(|e| e.to_string())).collect()
        };
        Ok(match text {
            "face" => Self::Flags(Colouring::Face),
            "vertex" => Self::Flags(Colouring::Vertex),
            "edge" => Self::Flags(Colouring::Edge),
            "triangle" => Self::Flags(Colouring::Triangle),
            "petrie" => Self::Flags(Colouring::Petrie),
            "quarter-tube" => Self::Tubes(TubeElement::Quarter),
            "half-tube" => Self::Tubes(TubeElement::Half),
            "junction" => Self::Tubes(TubeElement::Junction),
            "tube" => Self::Tubes(TubeElement::Tube),
            "symmetry" => Self::Symmetry,
            _ => match text.split_once(':') {
                Some(("orbit", list)) => Self::Flags(Colouring::FaceOrbit(words(list)?)),
                Some(("block", list)) => Self::Flags(Colouring::Block(words(list)?)),
                _ => return Err(KNOWN.into()),
            },
        })
    }
}

const KNOWN: &str = "colours go by face, vertex, edge, petrie, triangle, tube, half-tube, quarter-tube, junction, symmetry, \
                     orbit:WORDS or block:WORDS (words in R, S, T with commas between, as in orbit:R,S*T)";

/// The map that is drawn: the source, or its dual.
pub(super) struct Shown {
    /// The map.
    pub map: RegularMap,
    /// The dual numbers flags, and so faces, in its own order: its flag for each of the source.
    flag: FlagMap<FlagId>,
}

impl Shown {
    /// The map that is drawn of a source.
    pub fn new(source: &RegularMap, drawn: Drawn) -> Self {
        if drawn == Drawn::Map {
            return Self { map: source.clone(), flag: FlagMap::from_vec(source.flags().collect()) };
        }
        let map = source.dual();
        let same = |g: FlagId| {
            let word: Vec<Reflection> = source.reflections_of(g).into_iter().map(Reflection::dual).collect();
            map.walk(FlagId(0), &word)
        };
        let flag = FlagMap::from_vec(source.flags().map(same).collect());
        Self { map, flag }
    }

    /// The drawn face at a flag of the source.
    pub fn face(&self, of_source: FlagId) -> MapFaceId {
        self.map.face(self.flag[of_source])
    }

    /// The rotations that a surface has in space, as automorphisms of the drawn map.
    fn rotations(&self, realization: &Realization) -> Vec<Word> {
        let element = |h: FlagId| self.flag[realization.matched.element[h]];
        let word = |h: FlagId| Word::of_reflections(&self.map.reflections_of(element(h)));
        realization.tubes.rotations.elements.iter().map(|&(h, _)| word(h)).collect()
    }

    /// Orbits of the drawn faces under the rotations in space, each by number, the largest first.
    pub fn face_orbits(&self, realization: &Realization) -> Vec<Vec<usize>> {
        let classes = Colouring::FaceOrbit(self.rotations(realization)).classes(&self.map);
        let mut orbits = vec![Vec::new(); classes.count];
        let mut seen = vec![false; self.map.face_count()];
        for g in self.map.flags() {
            let face = self.map.face(g).index();
            if !std::mem::replace(&mut seen[face], true) {
                orbits[classes.of[g] as usize].push(face);
            }
        }
        orbits.iter_mut().for_each(|orbit| orbit.sort_unstable());
        orbits.sort_by_key(|orbit| (std::cmp::Reverse(orbit.len()), orbit[0]));
        orbits
    }
}

/// Class of each triangle, colour of each class, and the colouring of the drawn map's flags, if it is one.
pub(super) fn of_triangles(
    shown: &Shown,
    realization: &Realization,
    by: &ColorBy,
) -> (Vec<u32>, Vec<[u8; 3]>, Option<Colouring>) {
    let drawing = &realization.drawing;
    let colouring = match by {
        ColorBy::Flags(colouring) => colouring.clone(),
        ColorBy::Symmetry => Colouring::FaceOrbit(shown.rotations(realization)),
        ColorBy::Tubes(element) => {
            let (of, count) = tube_classes(&realization.matched.target, *element);
            let class = drawing.quarter.values().iter().map(|q| of[q.index()]).collect();
            return (class, palette(count), None);
        }
    };
    let classes = colouring.classes(&shown.map);
    let class = drawing.flag.values().iter().map(|&g| classes.of[shown.flag[g]]).collect();
    (class, colouring.colours(classes.count), Some(colouring))
}

/// Class of each quarter-tube ([Razafindrazaka2015] Fig. 9.14).
fn tube_classes(target: &RegularMap, element: TubeElement) -> (Vec<u32>, usize) {
    let of: Vec<u32> = match element {
        TubeElement::Quarter => target.flags().map(|f| f.0).collect(),
        TubeElement::Half => target.flags().map(|f| f.min(target.reflect(f, Reflection::R2)).0).collect(),
        TubeElement::Junction => target.flags().map(|f| target.vertex(f).0).collect(),
        TubeElement::Tube => target.flags().map(|f| target.edge(f).0).collect(),
    };
    let mut used = of.clone();
    used.sort_unstable();
    used.dedup();
    let number = |x: &u32| used.binary_search(x).unwrap_or(0) as u32;
    (of.iter().map(number).collect(), used.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regular_map::{MapSpec, find_map};

    #[test]
    fn colours_are_read_or_explained() {
        assert_eq!("face".parse(), Ok(ColorBy::default()));
        let words = ["R", "S*T"].map(|w| Word::parse(w).unwrap()).to_vec();
        assert_eq!("orbit:R,S*T".parse(), Ok(ColorBy::Flags(Colouring::FaceOrbit(words))));
        assert!("mauve".parse::<ColorBy>().unwrap_err().contains("quarter-tube"));
        assert!("orbit:R*Q".parse::<ColorBy>().unwrap_err().contains("character 3"));
    }

    #[test]
    fn faces_of_the_dual_are_vertices_of_the_source() {
        let cube = find_map(&MapSpec::Name("cube".into())).unwrap().map;
        let shown = Shown::new(&cube, Drawn::Dual);
        for (g, h) in cube.flags().flat_map(|g| cube.flags().map(move |h| (g, h))) {
            assert_eq!(shown.face(g) == shown.face(h), cube.vertex(g) == cube.vertex(h));
        }
    }

    #[test]
    fn a_cubes_tubes_have_four_quarters_and_two_halves() {
        let cube = find_map(&MapSpec::Name("cube".into())).unwrap().map;
        let counts = [TubeElement::Quarter, TubeElement::Half, TubeElement::Junction, TubeElement::Tube];
        assert_eq!(counts.map(|element| tube_classes(&cube, element).1), [48, 24, 8, 12]);
    }
}
