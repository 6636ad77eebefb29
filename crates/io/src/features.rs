//! Feature edges: `.sharp` of QuadWild, vertex pairs as text, and OBJ polylines.
//!
//! In: a path. Out: edges as the file names them; [`FeatureFile::vertex_pairs`] turns each form into vertex pairs of a
//! given soup. Holds: vertex pairs are in range; not that each is an edge of a face, which only a mesh can tell.
//!
//! ```text
//!            c           sides of a face (a, b, c) as in `.sharp`:
//!          /   \         side 0 = (a, b), side 1 = (b, c), side 2 = (c, a)
//!      2 /       \ 1
//!       a ─────── b      .sharp: the number of edges, then a line `convex,face,side` each;
//!            0           convex is 1 for a convex and 0 for a concave edge, counts are from 0
//! ```

use crate::atomic::write_atomically;
use crate::error::{ContentDefect, Fault, IoError};
use crate::fields::{content, integers};
use crate::surface::read_bytes;
use crate::text::{Lines, integer, tokens};
use crate::{obj, text};
use quadloom_mesh::{DVec3, FaceSoup};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A feature edge as a side of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SharpSide {
    /// Number of the face, from 0.
    pub face: u32,
    /// Side of the face: `k` joins its corners `k` and `k + 1`.
    pub side: u8,
    /// Whether the edge is convex; concave otherwise.
    pub convex: bool,
}

/// Feature edges as a file names them.
#[derive(Clone, Debug, PartialEq)]
pub enum FeatureFile {
    /// Sides of faces, from a `.sharp` file.
    Sides {
        /// The file.
        path: PathBuf,
        /// The edges, in the order of the file, each with its line; an edge may come once per face.
        sides: Vec<(u64, SharpSide)>,
    },
    /// Pairs of vertex numbers, from a text file.
    Pairs {
        /// The file.
        path: PathBuf,
        /// The edges, in the order of the file, each with its line; vertices are counted from 0.
        pairs: Vec<(u64, [u32; 2])>,
    },
    /// Polylines with positions of their own, from an OBJ file.
    Curves {
        /// The file.
        path: PathBuf,
        /// Positions of the polylines' vertices.
        positions: Vec<DVec3>,
        /// Numbers in `positions` along each polyline.
        polylines: Vec<Vec<u32>>,
    },
}

/// Reads feature edges: `.sharp`, `.obj` (its `l` lines), anything else as a text of vertex pairs.
///
/// # Errors     every [`IoError`] of reading
pub fn read_features(path: impl AsRef<Path>) -> Result<FeatureFile, IoError> {
    let given = path.as_ref();
    let path = given.to_path_buf();
    let in_file = |fault: Fault| fault.in_file(given);
    let extension = given.extension().map(|e| e.to_ascii_lowercase());
    match extension.as_ref().and_then(|e| e.to_str()) {
        Some("sharp") => Ok(FeatureFile::Sides { sides: parse_sharp(&read_bytes(given)?).map_err(in_file)?, path }),
        Some("obj") => {
            let (positions, polylines) = read_polylines(given)?;
            Ok(FeatureFile::Curves { path, positions, polylines })
        }
        _ => Ok(FeatureFile::Pairs { pairs: parse_pairs(&read_bytes(given)?).map_err(in_file)?, path }),
    }
}

/// Positions and polylines of an OBJ file that has at least one `l` line.
pub(crate) fn read_polylines(path: &Path) -> Result<(Vec<DVec3>, Vec<Vec<u32>>), IoError> {
    let soup = obj::parse(&read_bytes(path)?).map_err(|fault| fault.in_file(path))?;
    if soup.polylines.is_empty() {
        return Err(IoError::NoPolylines { path: path.to_path_buf() });
    }
    Ok((soup.positions, soup.polylines))
}

/// Reads a `.sharp` file; values may be separated by commas or blanks.
///
/// # Errors     every [`IoError`] of reading; a side above 2 is one
pub fn read_sharp(path: impl AsRef<Path>) -> Result<Vec<SharpSide>, IoError> {
    let path = path.as_ref();
    let sides = parse_sharp(&read_bytes(path)?).map_err(|fault| fault.in_file(path))?;
    Ok(sides.into_iter().map(|(_, side)| side).collect())
}

/// Writes a `.sharp` file.
///
/// # Errors     those of [`write_atomically`]
pub fn write_sharp(path: impl AsRef<Path>, sides: &[SharpSide]) -> Result<(), IoError> {
    write_atomically(path.as_ref(), |out| {
        writeln!(out, "{}", sides.len())?;
        sides.iter().try_for_each(|s| writeln!(out, "{},{},{}", u8::from(s.convex), s.face, s.side))
    })
}

/// Reads a text of vertex pairs, one pair a line, counted from 0, between blanks or commas; `#` starts a comment.
///
/// # Errors     every [`IoError`] of reading; a pair of a vertex with itself is one
pub fn read_vertex_pairs(path: impl AsRef<Path>) -> Result<Vec<[u32; 2]>, IoError> {
    let path = path.as_ref();
    let pairs = parse_pairs(&read_bytes(path)?).map_err(|fault| fault.in_file(path))?;
    Ok(pairs.into_iter().map(|(_, pair)| pair).collect())
}

/// Writes a text of vertex pairs, one pair a line, counted from 0.
///
/// # Errors     those of [`write_atomically`]
pub fn write_vertex_pairs(path: impl AsRef<Path>, pairs: &[[u32; 2]]) -> Result<(), IoError> {
    write_atomically(path.as_ref(), |out| pairs.iter().try_for_each(|[a, b]| writeln!(out, "{a} {b}")))
}

fn parse_sharp(bytes: &[u8]) -> Result<Vec<(u64, SharpSide)>, Fault> {
    let mut lines = Lines::new(bytes);
    let [count] = integers(&mut lines, "the number of edges")?;
    if count < 0 {
        return Err(Fault::line(lines.number(), ContentDefect::Header(format!("{count} edges"))));
    }
    let mut sides = Vec::new();
    for k in 0..count {
        let line = content(&mut lines, || format!("its edges: {count} were promised, {k} are there"))?;
        let [convex, face, side] = row(line.bytes, line.number, "edge", "3 (convex, face, side)")?;
        let (Ok(face), Ok(side @ 0..=2)) = (u32::try_from(face), u8::try_from(side)) else {
            let text = format!("face {face}, side {side}: faces count from 0, sides are 0, 1 or 2");
            return Err(Fault::line(line.number, ContentDefect::Malformed(text)));
        };
        sides.push((line.number, SharpSide { face, side, convex: convex != 0 }));
    }
    match lines.next_content() {
        Some(line) => {
            let text = format!("more lines than the {count} edges the first line promises");
            Err(Fault::line(line.number, ContentDefect::Malformed(text)))
        }
        None => Ok(sides),
    }
}

fn parse_pairs(bytes: &[u8]) -> Result<Vec<(u64, [u32; 2])>, Fault> {
    let mut lines = Lines::new(bytes);
    let mut pairs = Vec::new();
    while let Some(line) = lines.next_content() {
        let [a, b] = row(line.bytes, line.number, "vertex pair", "2")?;
        let (Ok(a), Ok(b)) = (u32::try_from(a), u32::try_from(b)) else {
            let text = format!("vertices {a} and {b}: vertex numbers count from 0");
            return Err(Fault::line(line.number, ContentDefect::Malformed(text)));
        };
        if a == b {
            let text = format!("vertex {a} twice; a pair is of two different vertices");
            return Err(Fault::line(line.number, ContentDefect::Malformed(text)));
        }
        pairs.push((line.number, [a, b]));
    }
    Ok(pairs)
}

/// Exactly `N` integers between commas or blanks.
fn row<const N: usize>(bytes: &[u8], line: u64, what: &'static str, wanted: &'static str) -> Result<[i64; N], Fault> {
    let mut values = [0; N];
    let mut found = 0;
    for token in tokens(bytes).flat_map(|t| t.split(|&b| b == b',')).filter(|t| !t.is_empty()) {
        if let Some(value) = values.get_mut(found) {
            *value = integer(token, line)?;
        }
        found += 1;
    }
    if found == N { Ok(values) } else { Err(Fault::line(line, ContentDefect::WrongCount { what, found, wanted })) }
}

impl FeatureFile {
    /// The file the features come from.
    pub fn path(&self) -> &Path {
        match self {
            Self::Sides { path, .. } | Self::Pairs { path, .. } | Self::Curves { path, .. } => path,
        }
    }

    /// The feature edges as pairs of vertex numbers of `soup`, smaller first, ascending, each once.
    ///
    /// Curves are matched by position: each of their points is a vertex of the soup up to [`SAME_POINT_REL`] of the
    /// bounding box's diagonal, the closest one (the smallest number among equals).
    ///
    /// # Errors     [`IoError::Mismatch`] names the first face, vertex or point the soup does not have, and its line
    /// # Cost       linear, and sorting
    pub fn vertex_pairs(&self, soup: &FaceSoup) -> Result<Vec<[u32; 2]>, IoError> {
        let found = match self {
            Self::Sides { sides, .. } => sides.iter().map(|(line, s)| side_ends(*line, s, soup)).collect(),
            Self::Pairs { pairs, .. } => pairs.iter().map(|(line, p)| pair_in_range(*line, p, soup)).collect(),
            Self::Curves { positions, polylines, .. } => {
                let vertices = VertexFinder::new(&soup.positions);
                let edges = polylines.iter().map(|polyline| curve_edges(positions, polyline, &vertices));
                edges.collect::<Result<Vec<_>, _>>().map(|edges| edges.concat())
            }
        };
        let mismatch = |what| IoError::Mismatch { path: self.path().to_path_buf(), what };
        let mut pairs: Vec<[u32; 2]> = found.map_err(mismatch)?;
        for pair in &mut pairs {
            pair.sort_unstable();
        }
        pairs.retain(|[a, b]| a != b);
        pairs.sort_unstable();
        pairs.dedup();
        Ok(pairs)
    }

    /// Where the file names an edge of `soup` first: a line, or a polyline, whose lines are not known.
    ///
    /// # Output     `None` if it does not
    /// # Cost       linear
    pub fn place_of(&self, pair: [u32; 2], soup: &FaceSoup) -> Option<String> {
        let same = |&[a, b]: &[u32; 2]| pair == [a, b] || pair == [b, a];
        let of_line = |line: u64| format!("line {line}");
        match self {
            Self::Sides { sides, .. } => {
                let named = |s: &(u64, SharpSide)| side_ends(s.0, &s.1, soup).is_ok_and(|ends| same(&ends));
                sides.iter().find(|s| named(s)).map(|s| of_line(s.0))
            }
            Self::Pairs { pairs, .. } => pairs.iter().find(|(_, p)| same(p)).map(|p| of_line(p.0)),
            Self::Curves { positions, polylines, .. } => {
                let vertices = VertexFinder::new(&soup.positions);
                let named = |polyline: &Vec<u32>| {
                    curve_edges(positions, polyline, &vertices).is_ok_and(|edges| edges.iter().any(same))
                };
                polylines.iter().position(named).map(|k| format!("polyline {}", k + 1))
            }
        }
    }
}

fn side_ends(line: u64, s: &SharpSide, soup: &FaceSoup) -> Result<[u32; 2], String> {
    let face = soup.faces.get(s.face as usize);
    let face = face.ok_or_else(|| {
        format!("line {line} names face {}, but the mesh has {} faces, counted from 0", s.face, soup.faces.len())
    })?;
    let side = s.side as usize;
    match face.get(side) {
        Some(&a) => Ok([a, face[(side + 1) % face.len()]]),
        None => Err(format!("line {line} names side {side} of face {}, which has {} sides", s.face, face.len())),
    }
}

fn pair_in_range(line: u64, pair: &[u32; 2], soup: &FaceSoup) -> Result<[u32; 2], String> {
    let count = soup.positions.len();
    match pair.iter().find(|&&v| v as usize >= count) {
        Some(v) => Err(format!("line {line} names vertex {v}, but the mesh has {count} vertices, counted from 0")),
        None => Ok(*pair),
    }
}

fn curve_edges(positions: &[DVec3], polyline: &[u32], vertices: &VertexFinder) -> Result<Vec<[u32; 2]>, String> {
    let found: Vec<u32> = polyline
        .iter()
        .map(|&k| {
            let p = positions[k as usize];
            vertices.at(p).ok_or_else(|| {
                let [x, y, z] = p.to_array().map(text::Shortest);
                format!("its point ({x}, {y}, {z}) is no vertex of the mesh")
            })
        })
        .collect::<Result<_, _>>()?;
    Ok(found.windows(2).map(|w| [w[0], w[1]]).collect())
}

/// Points this close, relative to the bounding box's diagonal, are the same. Files with six significant digits move
/// a point by up to 1e-6 of its distance from the origin; vertices of the finest scans in use are 1e-4 apart.
pub const SAME_POINT_REL: f64 = 1e-5;

/// Finds vertices by position: a grid whose cells are as wide as the tolerance.
struct VertexFinder<'a> {
    positions: &'a [DVec3],
    cell: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl<'a> VertexFinder<'a> {
    fn new(positions: &'a [DVec3]) -> Self {
        let bounds = |(lo, hi): (DVec3, DVec3), p: &DVec3| (lo.min(*p), hi.max(*p));
        let (lo, hi) = positions.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), bounds);
        let cell = (SAME_POINT_REL * (hi - lo).length()).max(f64::MIN_POSITIVE);
        let mut finder = Self { positions, cell, cells: HashMap::new() };
        for (v, &p) in positions.iter().enumerate() {
            finder.cells.entry(finder.key(p)).or_default().push(v as u32);
        }
        finder
    }

    fn key(&self, p: DVec3) -> [i64; 3] {
        (p / self.cell).floor().to_array().map(|x| x as i64)
    }

    fn at(&self, p: DVec3) -> Option<u32> {
        let [i, j, k] = self.key(p);
        let offsets =
            (0..27).map(|n| [(i, n / 9), (j, n / 3 % 3), (k, n % 3)].map(|(at, step)| at.saturating_add(step - 1)));
        let candidates = offsets.filter_map(|key| self.cells.get(&key)).flatten();
        candidates
            .map(|&v| (self.positions[v as usize].distance(p), v))
            .filter(|&(distance, _)| distance <= self.cell)
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|(_, v)| v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> FaceSoup {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        FaceSoup { positions, faces: vec![vec![0, 1, 2], vec![0, 2, 3]], ..FaceSoup::default() }
    }

    #[test]
    fn every_form_names_the_same_edges() {
        let path = PathBuf::from("f");
        let sides = parse_sharp(b"3\n1,0,2\n0 1 1\r\n1, 1, 0\n").unwrap();
        assert_eq!(sides[1], (3, SharpSide { face: 1, side: 1, convex: false }));
        let pairs = parse_pairs(b"# feature\n2 0\n\n2,3\n").unwrap();
        let positions = vec![DVec3::ZERO, DVec3::new(1.0, 1.0 + 1e-6, 0.0), DVec3::Y];
        for file in [
            FeatureFile::Sides { path: path.clone(), sides },
            FeatureFile::Pairs { path: path.clone(), pairs },
            FeatureFile::Curves { path, positions, polylines: vec![vec![0, 1, 2]] },
        ] {
            assert_eq!(file.vertex_pairs(&square()).unwrap(), [[0, 2], [2, 3]], "{file:?}");
            let place = file.place_of([2, 3], &square()).expect("named");
            assert!(["line 3", "line 4", "polyline 1"].contains(&place.as_str()), "{file:?}: {place}");
            assert_eq!(file.place_of([1, 3], &square()), None);
        }
    }

    #[test]
    fn features_of_another_mesh_are_an_error() {
        let path = PathBuf::from("f");
        for (file, part) in [
            (
                FeatureFile::Sides {
                    path: path.clone(),
                    sides: vec![(7, SharpSide { face: 2, side: 0, convex: true })],
                },
                "line 7 names face 2, but the mesh has 2 faces",
            ),
            (
                FeatureFile::Pairs { path: path.clone(), pairs: vec![(3, [0, 1]), (9, [0, 4])] },
                "line 9 names vertex 4, but the mesh has 4 vertices",
            ),
            (
                FeatureFile::Curves { path, positions: vec![DVec3::ZERO, DVec3::Z], polylines: vec![vec![0, 1]] },
                "(0, 0, 1)",
            ),
        ] {
            let message = file.vertex_pairs(&square()).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn bad_lines_are_named() {
        for (text, line, part) in [
            ("2\n1,0,0\n", 2, "2 were promised, 1 are there"),
            ("1\n1,0,3\n", 2, "side 3"),
            ("1\n1,-1,0\n", 2, "face -1"),
            ("1\n1,0\n", 2, "2 values"),
            ("1\n1,0,0\n1,0,1\n", 3, "more lines"),
            ("-3\n", 1, "-3 edges"),
            ("1\n1,a,0\n", 2, "`a`"),
        ] {
            let fault = parse_sharp(text.as_bytes()).unwrap_err();
            assert_eq!(fault.place, crate::Place::Line(line), "{text:?}");
            assert!(fault.defect.to_string().contains(part), "{text:?}: {}", fault.defect);
        }
        assert!(parse_pairs(b"1 2 3\n").is_err());
        assert!(parse_pairs(b"1 2\n5 5\n").unwrap_err().defect.to_string().contains("vertex 5 twice"));
        assert!(parse_pairs(b"1 -2\n").is_err());
    }
}
