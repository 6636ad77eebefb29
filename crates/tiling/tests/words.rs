//! Words of surfaces against triangulated surfaces, and canonical words against the free group.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use quadloom_tiling::word::{Corner, Invariants, Letter, Operation, Path, Side, Word, WordError, replay};
use std::collections::{BTreeMap, BTreeSet};

fn word(text: &str) -> Word {
    text.parse().unwrap()
}

/// Random tests that are the same every time.
fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(0x51d35), ..ProptestConfig::default() }
}

/// Any gluing: `pairs` letters twice, `borders` letters once, shuffled; `turns` says which way sides point.
fn gluing(pairs: usize, borders: usize, turn: f64) -> impl Strategy<Value = Word> {
    let letters: Vec<u32> =
        (0..pairs as u32).flat_map(|l| [l, l]).chain((0..borders as u32).map(|l| 1000 + l)).collect();
    let count = letters.len();
    let directions = proptest::collection::vec((any::<bool>(), prop::bool::weighted(turn)), count);
    (Just(letters).prop_shuffle(), directions).prop_map(|(letters, directions)| {
        let mut first: BTreeMap<u32, bool> = BTreeMap::new();
        let sides = letters.into_iter().zip(directions).map(|(letter, (any, turned))| {
            let inverse = *first.entry(letter).and_modify(|before| *before ^= !turned).or_insert(any);
            Side { letter: Letter(letter), inverse }
        });
        Word::new(sides.collect()).unwrap()
    })
}

/// Gluings of all kinds: closed and not, orientable, almost, and not.
fn any_gluing(most: usize) -> impl Strategy<Value = Word> {
    (0..=most, 0..5usize, prop::sample::select(vec![0.0, 0.0, 0.05, 0.2, 0.5, 1.0])).prop_flat_map(
        |(pairs, borders, turn)| {
            let borders = borders.saturating_sub(1);
            gluing(pairs.max(usize::from(borders == 0)), borders, turn)
        },
    )
}

// ---------------------------------------------------------------------------------------------------------------
// An independent computation: a triangulated polygon, glued.

/// Segments of a side: enough that no two edges of the glued surface have the same ends.
const SEGMENTS: usize = 3;

#[derive(Debug, PartialEq)]
struct Counted {
    chi: i64,
    borders: usize,
    is_orientable: bool,
    vertices_at_corners: usize,
}

fn find(parent: &[usize], mut a: usize) -> usize {
    while parent[a] != a {
        a = parent[a];
    }
    a
}

/// Triangulates the polygon (two rings and a centre), glues its border nodes, counts and walks triangles.
fn count(word: &Word) -> Counted {
    let ring = word.len() * SEGMENTS;
    let centre = 2 * ring;
    let mut parent: Vec<usize> = (0..=centre).collect();
    let sides = word.sides();
    let node = |side: usize, t: usize| {
        let t = if sides[side].inverse { SEGMENTS - t } else { t };
        (side * SEGMENTS + t) % ring
    };
    for i in 0..sides.len() {
        for j in (0..i).filter(|&j| sides[j].letter == sides[i].letter) {
            for t in 0..=SEGMENTS {
                let (a, b) = (find(&parent, node(i, t)), find(&parent, node(j, t)));
                parent[a] = b;
            }
        }
    }
    let mut triangles = Vec::new();
    for k in 0..ring {
        let l = (k + 1) % ring;
        triangles.extend([[k, l, ring + k], [l, ring + l, ring + k], [ring + k, ring + l, centre]]);
    }
    let triangles: Vec<[usize; 3]> = triangles.into_iter().map(|t| t.map(|v| find(&parent, v))).collect();
    let vertices: BTreeSet<usize> = triangles.iter().flatten().copied().collect();
    let mut edges: BTreeMap<[usize; 2], Vec<(usize, bool)>> = BTreeMap::new();
    for (k, t) in triangles.iter().enumerate() {
        for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            assert_ne!(a, b);
            edges.entry([a.min(b), a.max(b)]).or_default().push((k, a < b));
        }
    }
    assert!(edges.values().all(|of| of.len() <= 2), "an edge of more than two triangles");
    Counted {
        chi: vertices.len() as i64 - edges.len() as i64 + triangles.len() as i64,
        borders: rings(&edges),
        is_orientable: is_orientable(triangles.len(), &edges),
        vertices_at_corners: (0..sides.len()).map(|k| find(&parent, k * SEGMENTS)).collect::<BTreeSet<_>>().len(),
    }
}

/// Number of rings of edges that have one triangle.
fn rings(edges: &BTreeMap<[usize; 2], Vec<(usize, bool)>>) -> usize {
    let mut next: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (&[a, b], _) in edges.iter().filter(|(_, of)| of.len() == 1) {
        next.entry(a).or_default().push(b);
        next.entry(b).or_default().push(a);
    }
    assert!(next.values().all(|n| n.len() == 2), "a border that meets itself");
    let mut count = 0;
    while let Some(&start) = next.keys().next() {
        count += 1;
        let mut open = vec![start];
        while let Some(v) = open.pop() {
            open.extend(next.remove(&v).unwrap_or_default());
        }
    }
    count
}

/// Whether triangles can be turned so that both of an edge walk it in opposite directions.
fn is_orientable(count: usize, edges: &BTreeMap<[usize; 2], Vec<(usize, bool)>>) -> bool {
    let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); count];
    for of in edges.values().filter(|of| of.len() == 2) {
        let is_same = of[0].1 != of[1].1;
        neighbours[of[0].0].push((of[1].0, is_same));
        neighbours[of[1].0].push((of[0].0, is_same));
    }
    let mut turned: Vec<Option<bool>> = vec![None; count];
    let mut open = vec![0];
    turned[0] = Some(false);
    while let Some(t) = open.pop() {
        let own = turned[t].unwrap();
        for &(other, is_same) in &neighbours[t] {
            match turned[other] {
                None => {
                    turned[other] = Some(own == is_same);
                    open.push(other);
                }
                Some(found) if found != (own == is_same) => return false,
                Some(_) => {}
            }
        }
    }
    true
}

fn assert_counted(word: &Word) {
    let said = word.invariants();
    let said = Counted {
        chi: said.chi(),
        borders: said.borders,
        is_orientable: said.is_orientable,
        vertices_at_corners: said.vertices,
    };
    assert_eq!(said, count(word), "{word}");
}

// ---------------------------------------------------------------------------------------------------------------
// The free group, again and independently of the library's paths.

type Free = Vec<(u32, bool)>;

fn reduce(steps: impl IntoIterator<Item = (u32, bool)>) -> Free {
    let mut out = Free::new();
    for (letter, inverse) in steps {
        if out.last() == Some(&(letter, !inverse)) {
            out.pop();
        } else {
            out.push((letter, inverse));
        }
    }
    out
}

fn cyclically_reduce(word: Free) -> Free {
    let n = word.len();
    let k = (0..n / 2).take_while(|&k| word[k] == (word[n - 1 - k].0, !word[n - 1 - k].1)).count();
    word[k..n - k].to_vec()
}

/// Whether two elements of the free group are conjugate.
fn are_conjugate(a: Free, b: Free) -> bool {
    let (mut a, b) = (cyclically_reduce(a), cyclically_reduce(b));
    a.len() == b.len()
        && (0..a.len().max(1)).any(|_| {
            if !a.is_empty() {
                a.rotate_left(1);
            }
            a == b
        })
}

fn free(sides: &[Side]) -> Free {
    reduce(sides.iter().map(|s| (s.letter.0, s.inverse)))
}

/// The word with its letters replaced by paths.
fn expanded(word: &Word, letters: &[(Letter, Path)]) -> Free {
    let letters: BTreeMap<Letter, &Path> = letters.iter().map(|(l, p)| (*l, p)).collect();
    reduce(word.sides().iter().flat_map(|s| {
        let mut steps: Free = letters[&s.letter].sides().iter().map(|s| (s.letter.0, s.inverse)).collect();
        if s.inverse {
            steps.reverse();
            steps.iter_mut().for_each(|s| s.1 ^= true);
        }
        steps
    }))
}

/// The determinant of the letters' exponents, modulo a prime.
fn determinant(old: &[Letter], letters: &[(Letter, Path)]) -> i64 {
    const PRIME: i64 = 1_000_003;
    let power = |mut a: i64, mut e: i64| {
        let mut out = 1;
        while e > 0 {
            out = if e % 2 == 1 { out * a % PRIME } else { out };
            a = a * a % PRIME;
            e /= 2;
        }
        out
    };
    let mut rows: Vec<Vec<i64>> = letters
        .iter()
        .map(|(_, path)| {
            let sum = |l: &Letter| {
                path.sides().iter().filter(|s| s.letter == *l).map(|s| if s.inverse { -1 } else { 1 }).sum::<i64>()
            };
            old.iter().map(|l| sum(l).rem_euclid(PRIME)).collect()
        })
        .collect();
    assert_eq!(rows.len(), old.len());
    let mut det = 1;
    for c in 0..rows.len() {
        let Some(pivot) = (c..rows.len()).find(|&r| rows[r][c] != 0) else { return 0 };
        if pivot != c {
            rows.swap(pivot, c);
            det = PRIME - det;
        }
        det = det * rows[c][c] % PRIME;
        let inverse = power(rows[c][c], PRIME - 2);
        for r in c + 1..rows.len() {
            let factor = rows[r][c] * inverse % PRIME;
            let pivot = rows[c].clone();
            for (entry, p) in rows[r].iter_mut().zip(pivot).skip(c) {
                *entry = (*entry - factor * p).rem_euclid(PRIME);
            }
        }
    }
    if det == PRIME - 1 { -1 } else { det }
}

// ---------------------------------------------------------------------------------------------------------------
// What holds for every word.

fn surface(word: &Word) -> (i64, usize, bool) {
    let i = word.invariants();
    (i.chi(), i.borders, i.is_orientable)
}

/// Every step keeps the surface and, with its letters replaced, the border of the polygon.
fn assert_steps(start: &Word, operations: &[Operation], end: &Word) {
    let mut now = start.clone();
    for operation in operations {
        let next = operation.apply(&now).unwrap();
        assert_eq!(surface(&next), surface(&now), "{operation:?} on {now}");
        let changed: BTreeMap<Letter, Path> = operation.new_letters(&now).unwrap().into_iter().collect();
        let letters: Vec<(Letter, Path)> = next
            .letters()
            .into_iter()
            .map(|l| (l, changed.get(&l).cloned().unwrap_or_else(|| Path::new([Side::forward(l)]))))
            .collect();
        assert!(are_conjugate(expanded(&next, &letters), free(now.sides())), "{operation:?} on {now}");
        now = next;
    }
    assert_eq!(&now, end);
    assert_eq!(&replay(start, operations).unwrap(), end);
}

/// Every path can be walked, closed curves are closed, a border's letter is made of border.
fn assert_paths(start: &Word, end: &Word, letters: &[(Letter, Path)]) {
    assert_eq!(letters.iter().map(|(l, _)| *l).collect::<Vec<_>>(), end.letters());
    let vertices = end.vertices();
    let mut met: BTreeMap<_, _> = BTreeMap::new();
    for (letter, path) in letters.iter().filter(|(_, path)| !path.is_empty()) {
        let ends = path.ends(start).unwrap_or_else(|| panic!("{letter} = {path} of {start} cannot be walked"));
        let positions: Vec<usize> = (0..end.len()).filter(|&k| end.sides()[k].letter == *letter).collect();
        let k = positions[0];
        let mut corners = [k, k + 1].map(|c| vertices.at(Corner(c as u32)));
        if end.sides()[k].inverse {
            corners.reverse();
        }
        for (new, old) in corners.into_iter().zip(ends) {
            assert_eq!(*met.entry(new).or_insert(old), old, "{letter} = {path} of {start}: two places of one vertex");
        }
        if positions.len() == 1 {
            let once = |s: &Side| start.sides().iter().filter(|t| t.letter == s.letter).count() == 1;
            assert!(path.sides().iter().all(once), "{letter} = {path} of {start} leaves the border");
            let distinct: BTreeSet<Letter> = path.sides().iter().map(|s| s.letter).collect();
            assert_eq!(distinct.len(), path.len());
        }
    }
}

fn assert_reduced(start: &Word) {
    let found = start.reduced();
    assert_steps(start, &found.operations, &found.word);
    assert_paths(start, &found.word, &found.letters);
    assert!(are_conjugate(expanded(&found.word, &found.letters), free(start.sides())), "{start}");
    let said = start.invariants();
    let genus = said.genus() * if said.is_orientable { 4 } else { 2 };
    assert_eq!(found.word.len(), genus + (3 * said.borders).saturating_sub(2), "{start}");
    assert_eq!(found.word.invariants().vertices, said.borders.max(1), "{start}");
}

fn assert_canonical(start: &Word) {
    let found = start.canonical_form();
    assert_steps(start, &found.operations, &found.word);
    assert_paths(start, &found.word, &found.letters);
    assert!(are_conjugate(expanded(&found.word, &found.letters), free(start.sides())), "{start}");
    // What the word should be, from the triangulated surface.
    let truth = if start.is_empty() {
        surface(start)
    } else {
        (count(start).chi, count(start).borders, count(start).is_orientable)
    };
    let defect = (2 - truth.0) as usize - truth.1;
    let mut expected: Vec<String> = Vec::new();
    for k in 1..=if truth.2 { defect / 2 } else { defect } {
        expected.push(if truth.2 { format!("a{k} b{k} a{k}⁻¹ b{k}⁻¹") } else { format!("a{k} a{k}") });
    }
    expected.extend((1..=truth.1).map(|k| format!("c{k} d{k} c{k}⁻¹")));
    let expected = if expected.is_empty() { "1".to_owned() } else { expected.join(" ") };
    assert_eq!(found.text(), expected, "{start}");
    assert!(found.word.is_canonical());
    // The letters of a one-vertex word and their paths are two bases of one lattice.
    let said = start.invariants();
    if said.vertices == 1 && said.borders == 0 {
        assert_eq!(determinant(&start.letters(), &found.letters).abs(), 1, "{start}");
    }
}

proptest! {
    #![proptest_config(config(1500))]

    #[test]
    fn invariants_are_those_of_the_triangulated_surface(word in any_gluing(12)) {
        assert_counted(&word);
    }

    #[test]
    fn words_reduce(word in any_gluing(12)) {
        assert_reduced(&word);
    }

    #[test]
    fn words_become_canonical(word in any_gluing(12)) {
        assert_canonical(&word);
    }

    #[test]
    fn operations_are_refused_or_keep_the_surface(
        word in any_gluing(6),
        kind in 0..5,
        corners in [0u32..16, 0u32..16],
        letters in [0u32..8, 0u32..8],
        inverse: bool,
    ) {
        let [from, to] = corners.map(Corner);
        let [one, other] = letters.map(Letter);
        let operation = match kind {
            0 => Operation::Rotate { first: from },
            1 => Operation::Cancel { corner: from },
            2 => Operation::Contract { side: Side { letter: one, inverse } },
            3 => Operation::Expand { letter: Letter(letters[0] + 4), from, to },
            _ => Operation::CutAndGlue { from, to, cut: Letter(letters[0] + 4), along: other },
        };
        if let Ok(next) = operation.apply(&word) {
            assert_steps(&word, std::slice::from_ref(&operation), &next);
            // By the independent count as well.
            if !next.is_empty() {
                let (a, b) = (count(&word), count(&next));
                prop_assert_eq!((a.chi, a.borders, a.is_orientable), (b.chi, b.borders, b.is_orientable));
            }
        }
    }

    #[test]
    fn texts_are_read_as_they_are_written(word in any_gluing(60)) {
        prop_assert_eq!(&word.to_string().parse::<Word>().unwrap(), &word);
        let ascii = word.to_string().replace("⁻¹", "^-1");
        prop_assert_eq!(&ascii.parse::<Word>().unwrap(), &word);
        prop_assert_eq!(&ascii.replace("^-1", "'").replace(' ', "").parse::<Word>().unwrap(), &word);
    }

    #[test]
    fn the_representative_knows_no_rotation_inversion_or_name(
        word in any_gluing(9),
        first: prop::sample::Index,
        turns in proptest::collection::vec(any::<bool>(), 16),
        inverts: bool,
    ) {
        let letters = word.letters();
        let names = letters.iter().zip(&turns).enumerate();
        let names = names.map(|(k, (&l, &inverse))| (Letter(90 - 7 * k as u32), Side { letter: l, inverse })).collect();
        let other = Operation::Reletter { letters: names }.apply(&word).unwrap();
        let other = if inverts { other.inverted() } else { other };
        let first = Corner(first.index(word.len() + 1) as u32);
        let other = other.rotated(first).unwrap();
        prop_assert!(word.is_same_schema(&other));
        prop_assert_eq!(word.representative(), other.representative());
        // The least of all rotations, one after the other.
        let all: BTreeSet<Word> = [word.clone(), word.inverted()]
            .iter()
            .flat_map(|w| (0..w.len() as u32).map(|k| w.rotated(Corner(k)).unwrap().relettered()))
            .collect();
        prop_assert!(word.is_empty() || all.contains(&word.representative()));
    }

    #[test]
    fn different_schemas_have_different_representatives(a in any_gluing(3), b in any_gluing(3)) {
        let all = |w: &Word| -> BTreeSet<Word> {
            [w.clone(), w.inverted()]
                .iter()
                .flat_map(|w| (0..w.len().max(1) as u32).map(|k| w.rotated(Corner(k)).unwrap().relettered()))
                .collect()
        };
        prop_assert_eq!(a.is_same_schema(&b), all(&a) == all(&b));
    }
}

// ---------------------------------------------------------------------------------------------------------------
// Known surfaces.

fn says(text: &str) -> (i64, usize, usize, bool, usize) {
    let i = word(text).invariants();
    (i.chi(), i.genus(), i.borders, i.is_orientable, i.vertices)
}

#[test]
fn known_surfaces() {
    // χ, genus, borders, orientable, vertices.
    for (text, known, canonical) in [
        ("1", (2, 0, 0, true, 1), "1"),
        ("aA", (2, 0, 0, true, 2), "1"),
        ("abcCBA", (2, 0, 0, true, 4), "1"),
        ("aa", (1, 1, 0, false, 1), "a1 a1"),
        ("abab", (1, 1, 0, false, 2), "a1 a1"),
        ("abAB", (0, 1, 0, true, 1), "a1 b1 a1⁻¹ b1⁻¹"),
        ("abcABC", (0, 1, 0, true, 2), "a1 b1 a1⁻¹ b1⁻¹"),
        ("abAb", (0, 2, 0, false, 1), "a1 a1 a2 a2"),
        ("aabcBC", (-1, 3, 0, false, 1), "a1 a1 a2 a2 a3 a3"),
        ("abcdABCD", (-2, 2, 0, true, 1), "a1 b1 a1⁻¹ b1⁻¹ a2 b2 a2⁻¹ b2⁻¹"),
        ("abABcdCD", (-2, 2, 0, true, 1), "a1 b1 a1⁻¹ b1⁻¹ a2 b2 a2⁻¹ b2⁻¹"),
        ("d", (1, 0, 1, true, 1), "c1 d1 c1⁻¹"),
        ("defg", (1, 0, 1, true, 4), "c1 d1 c1⁻¹"),
        ("cdC", (1, 0, 1, true, 2), "c1 d1 c1⁻¹"),
        ("adAe", (0, 0, 2, true, 2), "c1 d1 c1⁻¹ c2 d2 c2⁻¹"),
        ("adae", (0, 1, 1, false, 2), "a1 a1 c1 d1 c1⁻¹"),
        ("abABd", (-1, 1, 1, true, 1), "a1 b1 a1⁻¹ b1⁻¹ c1 d1 c1⁻¹"),
        ("adAbeBf", (-1, 0, 3, true, 3), "c1 d1 c1⁻¹ c2 d2 c2⁻¹ c3 d3 c3⁻¹"),
    ] {
        assert_eq!(says(text), known, "{text}");
        assert_eq!(word(text).canonical_form().text(), canonical, "{text}");
        assert_canonical(&word(text));
        assert_reduced(&word(text));
        if text != "1" {
            assert_counted(&word(text));
        }
    }
}

#[test]
fn a_canonical_word_is_its_own_canonical_form() {
    for is_orientable in [true, false] {
        for genus in 0..4 {
            for borders in 0..4 {
                let loops = if is_orientable { 2 * genus } else { genus };
                let edges = loops + 2 * borders;
                let is_orientable = is_orientable || genus == 0;
                let wanted = Invariants { vertices: 1 + borders, edges, borders, is_orientable };
                let word = wanted.canonical_word();
                assert_eq!(word.invariants(), wanted, "{word}");
                assert!(word.is_canonical());
                let found = word.canonical_form();
                assert_eq!((&found.word, found.operations.len()), (&word, 0), "{word}");
                assert!(found.letters.iter().all(|(l, path)| path == &Path::new([Side::forward(*l)])));
            }
        }
    }
}

#[test]
fn opposite_sides_of_the_octagon() {
    let found = word("abcdABCD").canonical_form();
    let letters: Vec<String> =
        found.letters.iter().map(|(l, path)| format!("{} = {path}", found.invariants.name(*l))).collect();
    assert_eq!(letters, ["a1 = a d⁻¹ c⁻¹", "b1 = c d b", "a2 = c", "b2 = d"]);
}

#[test]
fn a_sphere_cancels_to_nothing_through_two_sides() {
    let found = word("abBcCA").reduced();
    assert!(found.word.is_empty());
    let last = found.operations.len() - 1;
    assert!(replay(&word("abBcCA"), &found.operations[..last]).unwrap().is_same_schema(&word("aA")));
}

#[test]
fn a_stalk_without_inner_vertex_is_empty() {
    let found = word("abABd").canonical_form();
    let lengths: Vec<usize> = found.letters.iter().map(|(_, path)| path.len()).collect();
    assert_eq!(lengths, [1, 1, 0, 1]);
    assert!(matches!(found.operations[0], Operation::Expand { .. }));
}

#[test]
fn equality_of_schemas() {
    assert!(word("abAB").is_same_schema(&word("xyXY")));
    assert!(word("abAB").is_same_schema(&word("BabA")));
    assert!(word("aab").is_same_schema(&word("BAA")));
    assert!(!word("abAB").is_same_schema(&word("abAb")));
    assert!(!word("abABcdCD").is_same_schema(&word("abcdABCD")));
    assert!(!word("aabb").is_same_schema(&word("abAb")));
    assert!(!word("adAe").is_same_schema(&word("aAde")));
    assert!(word("cdCabAB").invariants() == word("abABcdC").invariants() && !word("cdCabAB").is_canonical());
    assert!(word("xYXyzWZ").is_canonical());
}

#[test]
fn text_conventions() {
    assert_eq!(word("a b a⁻¹ b⁻¹"), word("a b a^-1 b'"));
    assert_eq!(word("abAB"), word(" a\tb A\nB "));
    assert_eq!(
        word("a1B2"),
        Word::new(vec![Side::forward(Letter(26)), Side { letter: Letter(53), inverse: true }]).unwrap()
    );
    assert_eq!(word("A'"), word("a"));
    assert_eq!(word("a1 B2").to_string(), "a1 b2⁻¹");
    assert_eq!(word(" 1 "), Word::default());
    assert_eq!(word(""), Word::default());
    assert_eq!(Word::default().to_string(), "1");
    let of_largest = Word::new(vec![Side::forward(Letter(u32::MAX))]).unwrap();
    assert_eq!(word(&of_largest.to_string()), of_largest);
    for (text, at, found) in [
        ("a^", 2, None),
        ("a^-2", 3, Some('2')),
        ("a01", 1, Some('0')),
        ("a ?", 2, Some('?')),
        ("ä", 0, Some('ä')),
        ("a99999999999", 10, Some('9')),
        ("z165191049", 10, None),
        ("1 a", 0, Some('1')),
    ] {
        assert_eq!(text.parse::<Word>(), Err(WordError::Text { at, found }), "{text}");
    }
    let sides = [0, 2, 3].map(Corner);
    assert_eq!("abaA".parse::<Word>(), Err(WordError::Thrice { letter: Letter(0), sides }));
}

#[test]
fn wrong_operations_are_refused() {
    let torus = word("abAB");
    let [a, b, e] = [0, 1, 4].map(Letter);
    let refused = |word: &Word, operation: Operation| operation.apply(word).unwrap_err();
    assert_eq!(refused(&torus, Operation::Cancel { corner: Corner(1) }), WordError::NotInverse { corner: Corner(1) });
    assert_eq!(
        refused(&torus, Operation::Cancel { corner: Corner(4) }),
        WordError::Corner { corner: Corner(4), sides: 4 }
    );
    let contract = |l| Operation::Contract { side: Side::forward(l) };
    assert_eq!(refused(&torus, contract(a)), WordError::NotContractible { letter: a });
    assert_eq!(refused(&torus, contract(e)), WordError::Missing { letter: e });
    // An annulus: its two borders may not meet.
    assert_eq!(refused(&word("adAe"), contract(a)), WordError::NotContractible { letter: a });
    // A stalk is drawn to its border, not the border's vertex to the stalk's.
    assert_eq!(refused(&word("adA"), contract(a)), WordError::NotContractible { letter: a });
    assert_eq!(Operation::Contract { side: Side { letter: a, inverse: true } }.apply(&word("adA")), Ok(word("d")));
    let cut = |from, to, cut, along| Operation::CutAndGlue { from: Corner(from), to: Corner(to), cut, along };
    assert_eq!(refused(&torus, cut(0, 2, b, a)), WordError::NotNew { letter: b });
    assert_eq!(refused(&torus, cut(0, 3, e, a)), WordError::NotShared { letter: a });
    assert_eq!(refused(&torus, cut(1, 2, e, a)), WordError::NotShared { letter: a });
    assert_eq!(refused(&torus, cut(2, 2, e, a)), WordError::Corner { corner: Corner(2), sides: 4 });
    assert_eq!(refused(&torus, cut(2, 5, e, a)), WordError::Corner { corner: Corner(5), sides: 4 });
    assert_eq!(cut(0, 2, e, a).apply(&torus), Ok(word("ebEB")));
    let expand = |from, to| Operation::Expand { letter: e, from: Corner(from), to: Corner(to) };
    // Corners of different vertices: the new letter would have equal ends.
    assert!(matches!(refused(&word("bB"), expand(0, 1)), WordError::NotContractible { .. }));
    assert!(matches!(refused(&torus, expand(3, 2)), WordError::Corner { .. }));
    assert_eq!(expand(1, 1).apply(&torus), Ok(word("aeEbAB")));
    let names = |letters: &[(Letter, Letter)]| Operation::Reletter {
        letters: letters.iter().map(|&(new, old)| (new, Side::forward(old))).collect(),
    };
    assert_eq!(refused(&torus, names(&[(a, b)])), WordError::NotOneToOne { letter: a });
    assert_eq!(refused(&torus, names(&[(e, b), (e, a)])), WordError::NotOneToOne { letter: e });
    assert_eq!(refused(&torus, names(&[(a, b), (b, a), (e, e)])), WordError::Missing { letter: e });
    assert_eq!(names(&[(a, b), (b, a)]).apply(&torus), Ok(word("baBA")));
}

// ---------------------------------------------------------------------------------------------------------------
// Large words.

/// A word of a large surface, by a fixed generator.
fn large(pairs: usize, borders: usize, turned_of_100: u64) -> Word {
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = |below: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    let mut letters: Vec<u32> =
        (0..pairs as u32).flat_map(|l| [l, l]).chain((0..borders as u32).map(|l| pairs as u32 + l)).collect();
    for k in (1..letters.len()).rev() {
        letters.swap(k, random(k as u64 + 1) as usize);
    }
    let mut first: BTreeMap<u32, bool> = BTreeMap::new();
    let sides = letters.into_iter().map(|letter| {
        let turned = random(100) < turned_of_100;
        let inverse = *first.entry(letter).and_modify(|before| *before ^= !turned).or_insert(turned);
        Side { letter: Letter(letter), inverse }
    });
    Word::new(sides.collect()).unwrap()
}

/// A tree drawn around: a sphere of many vertices.
fn comb(teeth: u32) -> Word {
    let mut sides = Vec::new();
    for k in 0..teeth {
        let [spine, tooth] = [2 * k, 2 * k + 1].map(|l| Side::forward(Letter(l)));
        sides.extend([spine, tooth, tooth.inverted()]);
    }
    sides.extend((0..teeth).rev().map(|k| Side { letter: Letter(2 * k), inverse: true }));
    Word::new(sides).unwrap()
}

/// A strip along a row of borders, each joined to the next, with handles at its end.
fn row(borders: u32, handles: u32) -> Word {
    let letter = |kind: u32, k: u32| Side::forward(Letter(4 * k + kind));
    let mut sides = Vec::new();
    for k in 0..borders {
        sides.extend([letter(0, k), letter(1, k)]);
    }
    for k in borders..borders + handles {
        let [a, b] = [letter(0, k), letter(1, k)];
        sides.extend([a, b, a.inverted(), b.inverted()]);
    }
    for k in (0..borders).rev() {
        sides.extend([letter(2, k), letter(0, k).inverted()]);
    }
    Word::new(sides).unwrap()
}

/// Steps and lengths stay linear in the number of sides; so does the time, times that number.
#[test]
fn large_words() {
    let polygon: Vec<Side> = [false, true]
        .into_iter()
        .flat_map(|inverse| (0..300).map(move |l| Side { letter: Letter(l), inverse }))
        .collect();
    let words = [
        Word::new(polygon).unwrap(),
        large(300, 0, 0),
        large(900, 0, 0),
        large(900, 0, 1),
        large(900, 0, 50),
        large(850, 100, 0),
        large(700, 400, 10),
        comb(450),
        row(150, 0),
        row(200, 150),
    ];
    for word in words {
        let found = word.canonical_form();
        let longest = found.letters.iter().map(|(_, path)| path.len()).max().unwrap_or(0);
        assert!(found.word.is_canonical());
        assert!(found.operations.len() <= 3 * word.len());
        assert!(longest <= 4 * word.len(), "{longest}");
        assert!(are_conjugate(expanded(&found.word, &found.letters), free(word.sides())));
    }
}
