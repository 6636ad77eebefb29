//! Prescribed singularities: vertex numbers with indices in quarter turns.
//!
//! In: a path. Out: [`Singularity`] values in the order of the file, vertices counted from 0.
//! Holds: indices are integers of quarters; not that they satisfy the Poincaré-Hopf formula, which only a mesh can tell.
//!
//! ```text
//!     plain text   vertex index   index: a whole number of quarters
//!     .sing        N count        as in Directional: indices are multiples of 1/N turn
//!                  vertex index
//! ```

use crate::atomic::Batch;
use crate::error::{ContentDefect, Fault, IoError};
use crate::fields::{content, integers};
use crate::surface::read_any_bytes;
use crate::text::{Lines, integer, parse_integer, shown, tokens};
use std::path::Path;

/// A vertex with a prescribed index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Singularity {
    /// Number of the vertex, from 0.
    pub vertex: u32,
    /// Index in quarter turns: 1 for a vertex of valence 3, -1 for valence 5.
    pub quarters: i32,
}

/// Reads prescribed singularities: `.sing` of Directional, or a text of `vertex index` lines.
///
/// # Output     the list in the order of the file; a text may list none
/// # Errors     every [`IoError`] of reading; an index that is no whole number of quarters is one
pub fn read_singularities(path: impl AsRef<Path>) -> Result<Vec<Singularity>, IoError> {
    let path = path.as_ref();
    let bytes = read_any_bytes(path)?;
    let parsed = if has_header(path) { parse_sing(&bytes) } else { parse_plain(&bytes) };
    parsed.map_err(|fault| fault.in_file(path))
}

/// Writes singularities: `.sing` with its header, any other extension as `vertex quarters` lines.
///
/// # Errors     those of [`crate::write_atomically`]
pub fn write_singularities(path: impl AsRef<Path>, singularities: &[Singularity]) -> Result<(), IoError> {
    let mut files = Batch::new();
    stage_singularities(&mut files, path, singularities)?;
    files.commit()
}

/// As [`write_singularities`], as one of several files that are put in place together.
pub fn stage_singularities(
    files: &mut Batch,
    path: impl AsRef<Path>,
    singularities: &[Singularity],
) -> Result<(), IoError> {
    let path = path.as_ref();
    files.stage(path, |out| {
        if has_header(path) {
            writeln!(out, "4 {}", singularities.len())?;
        }
        singularities.iter().try_for_each(|s| writeln!(out, "{} {}", s.vertex, s.quarters))
    })
}

fn has_header(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("sing"))
}

fn parse_plain(bytes: &[u8]) -> Result<Vec<Singularity>, Fault> {
    let mut lines = Lines::new(bytes);
    let mut list = Vec::new();
    while let Some(line) = lines.next_content() {
        list.push(entry(line.bytes, line.number, |token| plain_quarters(token, line.number))?);
    }
    Ok(list)
}

fn parse_sing(bytes: &[u8]) -> Result<Vec<Singularity>, Fault> {
    let mut lines = Lines::new(bytes);
    let [degree, count] = integers(&mut lines, "the header")?;
    if degree < 1 || count < 0 {
        let text = format!("`{degree} {count}`, where the symmetry and the number of singularities should be");
        return Err(Fault::line(lines.number(), ContentDefect::Header(text)));
    }
    let mut list = Vec::new();
    for k in 0..count {
        let line = content(&mut lines, || format!("its singularities: {count} were promised, {k} are there"))?;
        let quarters =
            |token: &[u8]| quarters_of(integer(token, line.number)? as f64, degree as f64, token, line.number);
        list.push(entry(line.bytes, line.number, quarters)?);
    }
    match lines.next_content() {
        Some(line) => {
            let text = format!("more lines than the {count} singularities the header promises");
            Err(Fault::line(line.number, ContentDefect::Malformed(text)))
        }
        None => Ok(list),
    }
}

fn entry(bytes: &[u8], line: u64, quarters: impl Fn(&[u8]) -> Result<i32, Fault>) -> Result<Singularity, Fault> {
    let mut values = tokens(bytes);
    match (values.next(), values.next(), values.next()) {
        (Some(vertex), Some(index), None) => {
            let number = integer(vertex, line)?;
            let vertex = u32::try_from(number).map_err(|_| {
                Fault::line(line, ContentDefect::Malformed(format!("vertex {number}: vertex numbers count from 0")))
            })?;
            Ok(Singularity { vertex, quarters: quarters(index)? })
        }
        _ => {
            let found = tokens(bytes).count();
            let wanted = "2 (vertex, index)";
            Err(Fault::line(line, ContentDefect::WrongCount { what: "singularity", found, wanted }))
        }
    }
}

/// A whole number of quarters. Fractions and decimals are refused: `1.0` could be a turn or a quarter.
fn plain_quarters(token: &[u8], line: u64) -> Result<i32, Fault> {
    match parse_integer(token) {
        Some(quarters) => quarters_of(quarters as f64, 4.0, token, line),
        None => {
            let text = format!(
                "index `{}`: write a whole number of quarters, 1 for valence 3 and -1 for valence 5",
                shown(token)
            );
            Err(Fault::line(line, ContentDefect::Malformed(text)))
        }
    }
}

fn quarters_of(numerator: f64, denominator: f64, token: &[u8], line: u64) -> Result<i32, Fault> {
    let quarters = 4.0 * numerator / denominator;
    // Far beyond any index there can be; it also keeps the conversion below exact.
    const LARGEST: f64 = 1e9;
    if quarters.abs() <= LARGEST && quarters.fract() == 0.0 {
        return Ok(quarters as i32);
    }
    let text = format!("index `{}` is not a multiple of a quarter; write quarters as integers", shown(token));
    Err(Fault::line(line, ContentDefect::Malformed(text)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_whole_quarters() {
        let list = parse_plain(b"# x\n3 1\n\n6 -1\n7 -2 # y\n8 +1\n").unwrap();
        let quarters: Vec<_> = list.iter().map(|s| (s.vertex, s.quarters)).collect();
        assert_eq!(quarters, [(3, 1), (6, -1), (7, -2), (8, 1)]);
        assert_eq!(parse_plain(b"# none\n").unwrap(), []);
        for text in ["1 1.0\n", "1 0.25\n", "1 1/4\n"] {
            let message = parse_plain(text.as_bytes()).unwrap_err().defect.to_string();
            assert!(message.contains("whole number of quarters"), "{message}");
        }
    }

    #[test]
    fn directional_counts_in_its_own_symmetry() {
        assert_eq!(parse_sing(b"4 2\n1 1\n2 -1\n").unwrap()[1], Singularity { vertex: 2, quarters: -1 });
        assert_eq!(parse_sing(b"2 1\n1 1\n").unwrap()[0].quarters, 2);
        assert!(parse_sing(b"3 1\n1 1\n").is_err());
        assert!(parse_sing(b"4 2\n1 1\n").unwrap_err().defect.to_string().contains("2 were promised"));
        assert!(parse_sing(b"4 1\n1 1\n2 1\n").is_err());
    }

    #[test]
    fn nonsense_is_refused() {
        for text in ["1 0.3\n", "1\n", "1 1 1\n", "-1 1\n", "1 1/0\n", "1 nan\n", "a 1\n"] {
            assert!(parse_plain(text.as_bytes()).is_err(), "{text:?}");
        }
    }
}
