//! Cross fields: `.rosy` of QuadWild and `.rawfield` of Directional.
//!
//! In: a path. Out: vectors per face, in face order, as the file has them. Holds: as many vectors as the header says,
//! all finite; nothing is normalised. Source: the files of vcglib and Directional.
//!
//! ```text
//!     .rosy      #faces          .rawfield      N #faces
//!                4                              x y z  x y z  …   (N vectors of a face, counter-clockwise)
//!                x y z
//! ```

use crate::atomic::Batch;
use crate::error::{ContentDefect, Fault, IoError};
use crate::surface::read_bytes;
use crate::text::{Line, Lines, Shortest, integer, point, shown, tokens};
use quadloom_mesh::DVec3;
use std::io::{self, Write};
use std::path::Path;

/// Vectors of a field with `degree` of them per face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawField {
    /// Number of vectors per face; 4 for a cross field.
    pub degree: usize,
    /// All vectors, face after face, counter-clockwise within a face.
    pub vectors: Vec<DVec3>,
}

impl RawField {
    /// The vectors of each face.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = &[DVec3]> {
        self.vectors.chunks_exact(self.degree.max(1))
    }

    /// The vectors as arrays, if there are `N` per face.
    pub fn as_arrays<const N: usize>(&self) -> Option<&[[DVec3; N]]> {
        (self.degree == N).then(|| self.vectors.as_chunks().0)
    }
}

/// Reads a `.rosy` cross field.
///
/// # Output     one vector per face: one of the four directions of its cross, of any length
/// # Errors     every [`IoError`] of reading; a symmetry other than 4 is one
pub fn read_rosy(path: impl AsRef<Path>) -> Result<Vec<DVec3>, IoError> {
    let path = path.as_ref();
    parse_rosy(&read_bytes(path)?).map_err(|fault| fault.in_file(path))
}

/// Writes a `.rosy` cross field: one vector per face, one of the four directions of its cross.
///
/// # Errors     those of [`crate::write_atomically`]; [`IoError::InvalidSurface`] if a vector is not finite
pub fn write_rosy(path: impl AsRef<Path>, directions: &[DVec3]) -> Result<(), IoError> {
    let mut files = Batch::new();
    stage_rosy(&mut files, path, directions)?;
    files.commit()
}

/// As [`write_rosy`], as one of several files that are put in place together.
pub fn stage_rosy(files: &mut Batch, path: impl AsRef<Path>, directions: &[DVec3]) -> Result<(), IoError> {
    let path = path.as_ref();
    check_finite(path, directions, 1)?;
    files.stage(path, |out| {
        writeln!(out, "{}\n4", directions.len())?;
        directions.iter().try_for_each(|d| write_row(out, std::slice::from_ref(d)))
    })
}

/// Reads a `.rawfield`.
///
/// # Errors     every [`IoError`] of reading
pub fn read_rawfield(path: impl AsRef<Path>) -> Result<RawField, IoError> {
    let path = path.as_ref();
    parse_rawfield(&read_bytes(path)?).map_err(|fault| fault.in_file(path))
}

/// Writes a `.rawfield`, `N` vectors per face.
///
/// # Errors     those of [`crate::write_atomically`]; [`IoError::InvalidSurface`] if a vector is not finite
pub fn write_rawfield<const N: usize>(path: impl AsRef<Path>, faces: &[[DVec3; N]]) -> Result<(), IoError> {
    let mut files = Batch::new();
    stage_rawfield(&mut files, path, faces)?;
    files.commit()
}

/// As [`write_rawfield`], as one of several files that are put in place together.
pub fn stage_rawfield<const N: usize>(
    files: &mut Batch,
    path: impl AsRef<Path>,
    faces: &[[DVec3; N]],
) -> Result<(), IoError> {
    let path = path.as_ref();
    check_finite(path, faces.as_flattened(), N)?;
    files.stage(path, |out| {
        writeln!(out, "{N} {}", faces.len())?;
        faces.iter().try_for_each(|vectors| write_row(out, vectors))
    })
}

fn parse_rosy(bytes: &[u8]) -> Result<Vec<DVec3>, Fault> {
    let mut lines = Lines::new(bytes);
    let [faces] = integers(&mut lines, "the number of faces")?;
    let [degree] = integers(&mut lines, "the field's symmetry")?;
    if degree != 4 {
        let text = format!("a field of symmetry {degree}, but a cross field (symmetry 4) is needed");
        return Err(Fault::line(lines.number(), ContentDefect::Unsupported(text)));
    }
    let faces = count(faces, &lines)?;
    rows(&mut lines, faces, 1)
}

fn parse_rawfield(bytes: &[u8]) -> Result<RawField, Fault> {
    let mut lines = Lines::new(bytes);
    let [degree, faces] = integers(&mut lines, "the header")?;
    // No field in use has more than six vectors; a count beyond any sense is a wrong file.
    const MOST_VECTORS: i64 = 64;
    if !(1..=MOST_VECTORS).contains(&degree) {
        let text = format!("{degree} vectors per face; the first line of a .rawfield is `vectors-per-face faces`");
        return Err(Fault::line(lines.number(), ContentDefect::Header(text)));
    }
    let (degree, faces) = (degree as usize, count(faces, &lines)?);
    Ok(RawField { degree, vectors: rows(&mut lines, faces, degree)? })
}

/// A line of exactly `N` integers.
pub(crate) fn integers<const N: usize>(lines: &mut Lines, what: &str) -> Result<[i64; N], Fault> {
    let line = content(lines, || what.to_string())?;
    let mut values = [0; N];
    let mut tokens = tokens(line.bytes);
    for value in &mut values {
        let token = tokens.next().ok_or_else(|| {
            let text = format!("line too short for {what}: {N} integers are needed");
            Fault::line(line.number, ContentDefect::Header(text))
        })?;
        *value = integer(token, line.number)?;
    }
    nothing_more(&mut tokens, line.number)?;
    Ok(values)
}

/// The next line, or that the file ended in the middle of something.
pub(crate) fn content<'a>(lines: &mut Lines<'a>, what: impl Fn() -> String) -> Result<Line<'a>, Fault> {
    lines.next_content().ok_or_else(|| Fault::line(lines.number(), ContentDefect::Truncated(what())))
}

fn nothing_more<'a>(tokens: &mut impl Iterator<Item = &'a [u8]>, line: u64) -> Result<(), Fault> {
    match tokens.next() {
        Some(token) => Err(Fault::line(line, ContentDefect::Malformed(format!("`{}` is one too many", shown(token))))),
        None => Ok(()),
    }
}

fn count(value: i64, lines: &Lines) -> Result<usize, Fault> {
    let bad = || ContentDefect::Header(format!("a count of {value}"));
    usize::try_from(value).map_err(|_| Fault::line(lines.number(), bad()))
}

/// `rows` lines of `width` vectors, and nothing after them.
fn rows(lines: &mut Lines, rows: usize, width: usize) -> Result<Vec<DVec3>, Fault> {
    let mut vectors = Vec::new();
    for row in 0..rows {
        let line = content(lines, || format!("its vectors: {rows} faces were promised, {row} are there"))?;
        let mut tokens = tokens(line.bytes);
        for _ in 0..width {
            vectors.push(point(&mut tokens, line.number, "vector of the field")?);
        }
        nothing_more(&mut tokens, line.number)?;
    }
    match lines.next_content() {
        Some(line) => {
            let text = format!("more lines than the {rows} faces the header promises");
            Err(Fault::line(line.number, ContentDefect::Malformed(text)))
        }
        None => Ok(vectors),
    }
}

fn check_finite(path: &Path, vectors: &[DVec3], per_face: usize) -> Result<(), IoError> {
    let bad = vectors.iter().position(|d| !d.is_finite());
    bad.map_or(Ok(()), |k| {
        let what = format!("the field has a vector that is not finite at face {}", k / per_face);
        Err(IoError::InvalidSurface { path: path.to_path_buf(), what })
    })
}

fn write_row(out: &mut dyn Write, vectors: &[DVec3]) -> io::Result<()> {
    for (k, d) in vectors.iter().enumerate() {
        let blank = if k == 0 { "" } else { " " };
        write!(out, "{blank}{} {} {}", Shortest(d.x), Shortest(d.y), Shortest(d.z))?;
    }
    out.write_all(b"\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Place;

    fn fault_of<T: std::fmt::Debug>(result: Result<T, Fault>) -> (Place, String) {
        let fault = result.unwrap_err();
        (fault.place, fault.defect.to_string())
    }

    #[test]
    fn faults_name_the_line() {
        for (text, line, part) in [
            ("2\n4\n1 0 0\n", 3, "2 faces were promised, 1 are there"),
            ("1\n4\n1 0 0\n1 0 0\n", 4, "more lines"),
            ("1\n4\n1 0\n", 3, "2 values"),
            ("1\n4\n1 0 0 0\n", 3, "one too many"),
            ("1\n4\n1 nan 0\n", 3, "not a finite"),
            ("1\n2\n1 0 0\n", 2, "symmetry 2"),
            ("-1\n4\n", 2, "count of -1"),
            ("x\n", 1, "not a number"),
            ("99999999999999999999999\n4\n", 1, "not a number"),
            ("9223372036854775807\n4\n1 0 0\n", 3, "promised"),
        ] {
            let (place, message) = fault_of(parse_rosy(text.as_bytes()));
            assert_eq!(place, Place::Line(line), "{text:?}");
            assert!(message.contains(part), "{text:?}: {message}");
        }
        assert!(fault_of(parse_rawfield(b"0 5\n")).1.contains("0 vectors"));
        assert_eq!(fault_of(parse_rawfield(b"4 1\n1 0 0 0 1 0 -1 0 0 0 -1\n")).0, Place::Line(2));
    }

    #[test]
    fn rawfield_of_any_degree() {
        let field = parse_rawfield(b"2 2\n1 0 0 -1 0 0 \n0 1 0 0 -1 0\n").unwrap();
        assert_eq!(field.faces().len(), 2);
        assert_eq!(field.as_arrays::<2>().unwrap()[1], [DVec3::Y, -DVec3::Y]);
        assert_eq!(field.as_arrays::<4>(), None);
    }
}
