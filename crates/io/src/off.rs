//! OFF, the object file format of Geomview, as text.
//!
//! In: bytes. Out: a soup, or the line at fault. Holds: normals and texture coordinates are passed over; colours of
//! vertices are kept, those of faces are not. Source: <http://www.geomview.org/docs/html/OFF.html>.
//!
//! ```text
//!     [ST][C][N]OFF         # blank lines and comments may be anywhere
//!     vertices faces edges
//!     x y z [nx ny nz] [r g b [a]] [s t]
//!     n v1 … vn [colour]
//! ```

use crate::error::{ContentDefect, Fault};
use crate::fields::content;
use crate::obj::unit_colors;
use crate::surface::SurfaceOut;
use crate::text::{Lines, Shortest, coordinate, integer, parse_integer, point, tokens};
use quadloom_mesh::FaceSoup;
use std::io::{self, Write};

/// What the first word promises of each vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Header {
    colors: bool,
    normals: bool,
    /// Four coordinates, or any number of them.
    other_dimension: bool,
    binary: bool,
    /// Length of the word.
    length: usize,
}

/// The header word at the beginning of a file, if there is one.
pub(crate) fn header(bytes: &[u8]) -> Option<Header> {
    let line = Lines::new(bytes).next_content()?;
    let mut words = tokens(line.bytes);
    let word = words.next()?;
    let mut header = Header::default();
    let mut rest = word.strip_prefix(b"ST").unwrap_or(word);
    let mut has = |letter: &[u8]| match rest.strip_prefix(letter) {
        Some(after) => {
            rest = after;
            true
        }
        None => false,
    };
    header.colors = has(b"C");
    header.normals = has(b"N");
    header.other_dimension = has(b"4") | has(b"n");
    // Some files lack the blank after the word: `OFF490 518 0`.
    let complete = has(b"OFF") && rest.iter().all(u8::is_ascii_digit);
    header.length = word.len() - rest.len();
    header.binary = words.next() == Some(b"BINARY");
    complete.then_some(header)
}

/// Reads an OFF file.
pub(crate) fn parse(bytes: &[u8]) -> Result<FaceSoup, Fault> {
    let mut lines = Lines::new(bytes);
    let header = header(bytes);
    let [vertices, faces] = counts(&mut lines, header)?;
    let header = header.unwrap_or_default();
    let mut soup = FaceSoup::default();
    let mut colors = Colors::default();
    for v in 0..vertices {
        let line = content(&mut lines, || format!("its vertices: {vertices} were promised, {v} are there"))?;
        let mut tokens = tokens(line.bytes);
        soup.positions.push(point(&mut tokens, line.number, "vertex")?);
        if header.colors {
            let after_normal = tokens.skip(if header.normals { 3 } else { 0 });
            colors.push(after_normal, line.number)?;
        }
    }
    for f in 0..faces {
        let line = content(&mut lines, || format!("its faces: {faces} were promised, {f} are there"))?;
        soup.faces.push(face(tokens(line.bytes), line.number, soup.positions.len())?);
    }
    if let Some(line) = lines.next_content() {
        let text = format!("more lines than the {vertices} vertices and {faces} faces the header promises");
        return Err(Fault::line(line.number, ContentDefect::Malformed(text)));
    }
    soup.vertex_colors = header.colors.then(|| colors.finish());
    Ok(soup)
}

/// Numbers of vertices and faces, on the line of the header word or the next one.
fn counts(lines: &mut Lines, header: Option<Header>) -> Result<[usize; 2], Fault> {
    let mut line = content(lines, || "its header".into())?;
    let mut rest = line.bytes.trim_ascii_start();
    if let Some(header) = header {
        if header.binary || header.other_dimension {
            let text = "binary OFF and OFF of other than three dimensions are not read; convert the file to plain OFF";
            return Err(Fault::line(line.number, ContentDefect::Unsupported(text.into())));
        }
        rest = &rest[header.length..];
        if tokens(rest).next().is_none() {
            line = content(lines, || "its header".into())?;
            rest = line.bytes;
        }
    }
    let mut values = tokens(rest).map(|t| parse_integer(t).and_then(|n| usize::try_from(n).ok()));
    match (values.next(), values.next()) {
        (Some(Some(vertices)), Some(Some(faces))) if vertices < u32::MAX as usize => Ok([vertices, faces]),
        _ => {
            let text = "the numbers of vertices and faces should be here, after the word OFF";
            Err(Fault::line(line.number, ContentDefect::Header(text.into())))
        }
    }
}

fn face<'a>(mut tokens: impl Iterator<Item = &'a [u8]>, line: u64, count: usize) -> Result<Vec<u32>, Fault> {
    let corners = tokens.next().map_or(Ok(0), |t| integer(t, line))?;
    let mut face = Vec::new();
    for found in 0..corners.max(0) {
        let token = tokens.next().ok_or_else(|| {
            let text = format!("face: {found} vertex numbers where {corners} are promised");
            Fault::line(line, ContentDefect::Malformed(text))
        })?;
        let index = integer(token, line)?;
        let v = usize::try_from(index).ok().filter(|&v| v < count);
        face.push(
            v.ok_or_else(|| Fault::line(line, ContentDefect::IndexOutOfRange { what: "face", index, count }))? as u32
        );
    }
    if face.is_empty() {
        let text = format!("a face of {corners} corners");
        return Err(Fault::line(line, ContentDefect::Malformed(text)));
    }
    Ok(face)
}

/// Colours of vertices: integers count to 255, numbers with a point to 1.
#[derive(Default)]
struct Colors {
    values: Vec<[f32; 3]>,
    fractions: bool,
}

impl Colors {
    fn push<'a>(&mut self, mut tokens: impl Iterator<Item = &'a [u8]>, line: u64) -> Result<(), Fault> {
        let mut color = [0.0; 3];
        for (found, c) in color.iter_mut().enumerate() {
            let wanted = "3 or 4 (the header promises colours)";
            let missing = || Fault::line(line, ContentDefect::WrongCount { what: "colour", found, wanted });
            let token = tokens.next().ok_or_else(missing)?;
            self.fractions |= token.iter().any(|b| b".eE".contains(b));
            *c = coordinate(token, line)? as f32;
        }
        self.values.push(color);
        Ok(())
    }

    fn finish(mut self) -> Vec<[f32; 3]> {
        if !self.fractions {
            self.values.iter_mut().flatten().for_each(|c| *c /= 255.0);
        }
        unit_colors(self.values)
    }
}

/// Writes an OFF file, COFF where there are colours.
pub(crate) fn write(surface: &SurfaceOut, out: &mut dyn Write) -> io::Result<()> {
    let word = if surface.vertex_colors.is_some() { "COFF" } else { "OFF" };
    writeln!(out, "{word}\n{} {} 0", surface.positions.len(), surface.faces.len())?;
    for (v, p) in surface.positions.iter().enumerate() {
        write!(out, "{} {} {}", Shortest(p.x), Shortest(p.y), Shortest(p.z))?;
        match &surface.vertex_colors {
            // The debug form always has a point, which tells fractions from bytes.
            Some(colors) => writeln!(out, " {:?} {:?} {:?} 1.0", colors[v][0], colors[v][1], colors[v][2])?,
            None => out.write_all(b"\n")?,
        }
    }
    for face in &surface.faces {
        write!(out, "{}", face.len())?;
        for v in face {
            write!(out, " {v}")?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: &str = "0 0 0\n1 0 0\n\n0 1 0 # c\n3 0 1 2\n";

    #[test]
    fn header_words() {
        for head in
            ["OFF\n3 1 0\n", "OFF 3 1\n", "# c\nOFF # x\n# y\n3 1 0\n", "3 1 0\n", "OFF3 1 0\n", "STOFF\n3 1 0\n"]
        {
            let soup = parse(format!("{head}{BODY}").as_bytes()).unwrap_or_else(|e| panic!("{head:?}: {e:?}"));
            assert_eq!((soup.positions.len(), soup.faces), (3, vec![vec![0, 1, 2]]), "{head:?}");
        }
        let soup = parse(b"CNOFF\r\n3 1 0\r\n0 0 0 0 0 1 255 0 51 255\r\n1 0 0 0 0 1 0 0 0\r\n0 1 0 0 0 1 0 0 0 9\r\n3 0 1 2 255 0 0\r\n");
        assert_eq!(soup.unwrap().vertex_colors.unwrap()[0], [1.0, 0.0, 0.2]);
        let soup = parse(b"COFF\n1 0 0\n0 0 0 1.0 0 1\n").unwrap();
        assert_eq!(soup.vertex_colors.unwrap(), [[1.0, 0.0, 1.0]]);
        assert!(parse(b"NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n").is_ok());
    }

    #[test]
    fn faults_name_the_line() {
        for (text, line, part) in [
            ("OFF\n3 1 0\n0 0 0\n1 0 0\n", 4, "3 were promised, 2 are there"),
            ("OFF\n9 9\n", 2, "promised"),
            ("OFF\n", 1, "truncated"),
            ("OFF\nx\n", 2, "numbers of vertices"),
            ("OFF\n-3 1 0\n", 2, "numbers of vertices"),
            ("OFF\n99999999999 1 0\n", 2, "numbers of vertices"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0 1\n", 4, "vertex 1"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0 -1\n", 4, "vertex -1"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0\n", 4, "2 vertex numbers where 3"),
            ("OFF\n1 1 0\n0 0 0\n9223372036854775807 0 0\n", 4, "promised"),
            ("OFF\n1 1 0\n0 0 0\n-3 0 0\n", 4, "-3 corners"),
            ("OFF\n1 0 0\n0 nan 0\n", 3, "not a finite"),
            ("OFF\n1 0 0\n0 0 0\n0 0 0\n", 4, "more lines"),
            ("4OFF\n1 0 0\n0 0 0 1\n", 1, "three dimensions"),
            ("OFF BINARY\n\0\0", 1, "binary OFF"),
            ("COFF\n1 0 0\n0 0 0 1\n", 3, "colour"),
        ] {
            let fault = parse(text.as_bytes()).unwrap_err();
            assert_eq!(fault.place, crate::Place::Line(line), "{text:?}");
            assert!(fault.defect.to_string().contains(part), "{text:?}: {}", fault.defect);
        }
    }
}
