//! Wavefront OBJ: `v`, `vt`, `f` and `l`; everything else is passed over.
//!
//! In: bytes (names need not be UTF-8). Out: a soup whose indices are in range and coordinates finite, or the line
//! that is at fault. Holds: groups, objects, materials and normals are ignored; a face is mapped only if all its
//! corners name a texture coordinate that exists. Source: Wavefront Advanced Visualizer manual, appendix B1.

use crate::error::{ContentDefect, Fault};
use crate::surface::SurfaceOut;
use crate::text::{Line, Lines, Shortest, coordinate, number_at, parse_integer, point, shown, tokens};
use quadloom_mesh::{DVec3, FaceSoup};
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, Write};

/// Largest number of elements that 32-bit ids can name.
const MOST: usize = u32::MAX as usize - 1;
/// Stands for a corner whose texture coordinate is not known.
const UNMAPPED: u32 = u32::MAX;

/// Reads an OBJ file.
pub(crate) fn parse(bytes: &[u8]) -> Result<FaceSoup, Fault> {
    let mut reader = Reader::default();
    let mut lines = Lines::new(bytes);
    while let Some(line) = lines.next() {
        let (joined, terminated) = continued(line, &mut lines);
        reader.line(line.number, &joined, terminated).map_err(|fault| cut_off(fault, terminated))?;
    }
    reader.finish()
}

/// Joins a line with those that follow it after a trailing backslash; comments and names are left alone.
fn continued<'a>(line: Line<'a>, lines: &mut Lines<'a>) -> (Cow<'a, [u8]>, bool) {
    let goes_on = |bytes: &[u8]| bytes.last() == Some(&b'\\');
    if !goes_on(line.bytes) || !matches!(tokens(line.bytes).next(), Some(b"v" | b"vt" | b"f" | b"fo" | b"l")) {
        return (Cow::Borrowed(line.bytes), line.terminated);
    }
    let (mut joined, mut terminated) = (line.bytes.to_vec(), line.terminated);
    while goes_on(&joined) {
        joined.pop();
        let Some(next) = lines.next() else { break };
        joined.push(b' ');
        joined.extend_from_slice(next.bytes);
        terminated = next.terminated;
    }
    (Cow::Owned(joined), terminated)
}

/// A broken last line without an ending is a truncated file.
fn cut_off(fault: Fault, terminated: bool) -> Fault {
    use ContentDefect::{NotANumber, WrongCount};
    match fault.defect {
        NotANumber(_) | WrongCount { .. } if !terminated => {
            Fault { defect: ContentDefect::Truncated("its last line".into()), ..fault }
        }
        _ => fault,
    }
}

#[derive(Default)]
struct Reader {
    positions: Vec<DVec3>,
    /// Shorter than `positions`, or empty, while no later vertex has a colour.
    colors: Vec<[f32; 3]>,
    uv: Vec<[f64; 2]>,
    faces: Vec<Vec<u32>>,
    /// Texture coordinate of each corner; empty for an unmapped face.
    face_uv: Vec<Vec<u32>>,
    polylines: Vec<Vec<u32>>,
    /// Vertex numbers larger than all before them, with their lines and what uses them: the first one out of range is
    /// among them.
    records: Vec<(u32, u64, &'static str)>,
    /// What the line being read is, for messages.
    reading: &'static str,
    corners: Vec<u32>,
    corner_uv: Vec<u32>,
}

impl Reader {
    fn line(&mut self, number: u64, bytes: &[u8], terminated: bool) -> Result<(), Fault> {
        let mut tokens = tokens(bytes);
        match tokens.next() {
            Some(b"v") => self.vertex(&mut tokens, number),
            Some(b"f" | b"fo") => self.face(&mut tokens, number, terminated),
            Some(b"vt") => self.texture_vertex(&mut tokens, number),
            Some(b"l") => self.polyline(&mut tokens, number),
            Some(word) if !word.iter().all(u8::is_ascii_graphic) => {
                Err(Fault::line(number, ContentDefect::Binary("OBJ")))
            }
            _ => Ok(()),
        }
    }

    fn vertex<'a>(&mut self, tokens: &mut impl Iterator<Item = &'a [u8]>, line: u64) -> Result<(), Fault> {
        let p = point(tokens, line, "vertex")?;
        // A fourth value alone is a weight; three or four more are a colour, the last of four its opacity.
        let mut extra = [0.0; 4];
        let mut count = 0;
        for token in tokens {
            let slot = extra.get_mut(count).ok_or_else(|| {
                Fault::line(line, ContentDefect::WrongCount { what: "vertex", found: 8, wanted: "at most 7" })
            })?;
            *slot = coordinate(token, line)?;
            count += 1;
        }
        if count >= 3 {
            self.colors.resize(self.positions.len(), WHITE);
            self.colors.push([extra[0] as f32, extra[1] as f32, extra[2] as f32]);
        }
        self.positions.push(p);
        check_size(self.positions.len(), line)
    }

    fn texture_vertex<'a>(&mut self, tokens: &mut impl Iterator<Item = &'a [u8]>, line: u64) -> Result<(), Fault> {
        let missing =
            || Fault::line(line, ContentDefect::WrongCount { what: "texture vertex", found: 0, wanted: "1 to 3" });
        let u = number_at(tokens.next().ok_or_else(missing)?, line)?;
        let v = tokens.next().map_or(Ok(0.0), |t| number_at(t, line))?;
        self.uv.push([u, v]);
        Ok(())
    }

    fn face<'a>(
        &mut self,
        tokens: &mut impl Iterator<Item = &'a [u8]>,
        line: u64,
        terminated: bool,
    ) -> Result<(), Fault> {
        self.reading = "face";
        self.corners.clear();
        self.corner_uv.clear();
        for token in tokens {
            let (vertex, uv) = self.corner(token, line)?;
            self.corners.push(vertex);
            self.corner_uv.push(uv);
        }
        let found = self.corners.len();
        if found == 0 || found < 3 && !terminated {
            return Err(Fault::line(line, ContentDefect::WrongCount { what: "face", found, wanted: "3 or more" }));
        }
        let mapped = !self.corner_uv.contains(&UNMAPPED);
        self.face_uv.push(if mapped { self.corner_uv.clone() } else { Vec::new() });
        self.faces.push(self.corners.clone());
        check_size(self.faces.len(), line)
    }

    fn polyline<'a>(&mut self, tokens: &mut impl Iterator<Item = &'a [u8]>, line: u64) -> Result<(), Fault> {
        self.reading = "polyline";
        let polyline: Vec<u32> = tokens.map(|t| Ok(self.corner(t, line)?.0)).collect::<Result<_, Fault>>()?;
        if polyline.len() < 2 {
            let defect = ContentDefect::WrongCount { what: "polyline", found: polyline.len(), wanted: "2 or more" };
            return Err(Fault::line(line, defect));
        }
        self.polylines.push(polyline);
        Ok(())
    }

    /// Vertex and texture coordinate of `v`, `v/t`, `v//n` or `v/t/n`, counted from 0.
    fn corner(&mut self, token: &[u8], line: u64) -> Result<(u32, u32), Fault> {
        let malformed = || Fault::line(line, ContentDefect::NotANumber(shown(token)));
        let mut parts = token.split(|&b| b == b'/');
        let vertex = parts.next().and_then(parse_integer).ok_or_else(malformed)?;
        let uv = match parts.next() {
            None | Some(b"") => None,
            Some(t) => Some(parse_integer(t).ok_or_else(malformed)?),
        };
        match parts.next() {
            None | Some(b"") => {}
            Some(n) => _ = parse_integer(n).ok_or_else(malformed)?,
        }
        if parts.next().is_some() {
            return Err(malformed());
        }
        let v = self.vertex_number(vertex, line)?;
        Ok((v, uv.map_or(UNMAPPED, |t| resolve(t, self.uv.len()).unwrap_or(UNMAPPED))))
    }

    fn vertex_number(&mut self, index: i64, line: u64) -> Result<u32, Fault> {
        if index == 0 {
            return Err(Fault::line(line, ContentDefect::IndexZero));
        }
        let count = self.positions.len();
        let what = self.reading;
        let missing = || Fault::line(line, ContentDefect::IndexOutOfRange { what, index, count });
        let v = resolve(index, count).ok_or_else(missing)?;
        // A vertex may be defined after its face: whether it is, is known at the end.
        if v as usize >= count && self.records.last().is_none_or(|&(largest, ..)| v > largest) {
            self.records.push((v, line, what));
        }
        Ok(v)
    }

    fn finish(mut self) -> Result<FaceSoup, Fault> {
        let count = self.positions.len();
        if let Some(&(v, line, what)) = self.records.iter().find(|&&(v, ..)| v as usize >= count) {
            return Err(Fault::line(line, ContentDefect::IndexOutOfRange { what, index: i64::from(v) + 1, count }));
        }
        let vertex_colors = (!self.colors.is_empty()).then(|| {
            self.colors.resize(count, WHITE);
            unit_colors(self.colors)
        });
        let corner_uv = (!self.uv.is_empty()).then(|| map_corners(&self.face_uv, &self.uv));
        Ok(FaceSoup {
            positions: self.positions,
            faces: self.faces,
            vertex_colors,
            polylines: self.polylines,
            vertex_attributes: Vec::new(),
            corner_uv,
        })
    }
}

/// Colour of vertices without one in a file that has some.
const WHITE: [f32; 3] = [1.0; 3];

/// Counts from 0 what OBJ counts from 1 or backwards from `count`; `None` before the first or beyond 32 bits.
fn resolve(index: i64, count: usize) -> Option<u32> {
    let from_zero = if index > 0 { index - 1 } else { index.checked_add(count as i64)? };
    u32::try_from(from_zero).ok().filter(|&v| index != 0 && (v as usize) < MOST)
}

fn check_size(count: usize, line: u64) -> Result<(), Fault> {
    if count <= MOST { Ok(()) } else { Err(Fault::line(line, ContentDefect::TooLarge)) }
}

/// Brings colours to 0..=1; a file with any value above 1 is taken to count to 255.
pub(crate) fn unit_colors(mut colors: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    let bytes = colors.iter().flatten().any(|&c| c > 1.0);
    for c in colors.iter_mut().flatten() {
        *c = (if bytes { *c / 255.0 } else { *c }).clamp(0.0, 1.0);
    }
    colors
}

/// Texture coordinates of each corner; faces with an unknown or non-finite one stay unmapped.
fn map_corners(face_uv: &[Vec<u32>], uv: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
    let known = |&t: &u32| uv.get(t as usize).copied().filter(|c| c.iter().all(|x| x.is_finite()));
    face_uv.iter().map(|face| face.iter().map(known).collect::<Option<_>>().unwrap_or_default()).collect()
}

/// Texture vertices in the order of their first corner; corners of one vertex share those that are equal, so that
/// programs see a connected map.
#[derive(Default)]
struct TextureVertices {
    list: Vec<[f64; 2]>,
    /// Number in `list` for each corner of each mapped face.
    of_corner: Vec<u32>,
}

impl TextureVertices {
    fn of(surface: &SurfaceOut) -> Self {
        let mut textures = Self::default();
        let mut known = HashMap::new();
        let mapped = surface.corner_uv.iter().flatten().zip(&surface.faces).flat_map(|(uv, face)| uv.iter().zip(face));
        for (uv, &v) in mapped {
            let number = *known.entry((v, uv.map(f64::to_bits))).or_insert_with(|| {
                textures.list.push(*uv);
                (textures.list.len() - 1) as u32
            });
            textures.of_corner.push(number);
        }
        textures
    }
}

/// Writes an OBJ file: vertices, texture vertices, faces, feature polylines.
pub(crate) fn write(surface: &SurfaceOut, out: &mut dyn Write) -> io::Result<()> {
    for (v, p) in surface.positions.iter().enumerate() {
        write!(out, "v {} {} {}", Shortest(p.x), Shortest(p.y), Shortest(p.z))?;
        match &surface.vertex_colors {
            Some(colors) => writeln!(out, " {} {} {}", colors[v][0], colors[v][1], colors[v][2])?,
            None => out.write_all(b"\n")?,
        }
    }
    let textures = TextureVertices::of(surface);
    for [u, v] in &textures.list {
        writeln!(out, "vt {} {}", Shortest(*u), Shortest(*v))?;
    }
    let mut of_corner = textures.of_corner.iter();
    for (f, face) in surface.faces.iter().enumerate() {
        let mapped = surface.corner_uv.as_ref().is_some_and(|uv| !uv[f].is_empty());
        out.write_all(b"f")?;
        for v in face {
            write!(out, " {}", u64::from(*v) + 1)?;
            if mapped && let Some(t) = of_corner.next() {
                write!(out, "/{}", u64::from(*t) + 1)?;
            }
        }
        out.write_all(b"\n")?;
    }
    for line in &surface.polylines {
        out.write_all(b"l")?;
        for v in line {
            write!(out, " {}", u64::from(*v) + 1)?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Place;

    fn fault(text: &str) -> (u64, ContentDefect) {
        let Fault { place: Place::Line(line), defect } = parse(text.as_bytes()).unwrap_err() else { panic!() };
        (line, defect)
    }

    const VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn every_index_form_means_the_same() {
        let head = format!("{VERTICES}vt 0 0\nvn 0 0 1\n");
        let plain = parse(format!("{head}f 1 2 3 4\n").as_bytes()).unwrap().faces;
        assert_eq!(plain, [[0, 1, 2, 3]]);
        for form in [
            "f 1/1 2/1 3/1 4/1",
            "f 1//1 2//1 3//1 4//1",
            "f 1/1/1 2/1/1 3/1/1 4/1/1",
            "f -4 -3 -2 -1",
            "f -4/-1/-1 2//-1 3/1 -1",
            "fo 1 2 3 4",
            "f 1/ 2/ 3// 4 # corners",
            "f 1 2 \\\n 3 \\\r\n4",
            "\tf\t1\t2 3   4  \r",
        ] {
            assert_eq!(parse(format!("{head}{form}\n").as_bytes()).unwrap().faces, plain, "{form}");
        }
    }

    #[test]
    fn negative_indices_count_from_the_line_they_are_on() {
        let soup = parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf -3 -2 -1").unwrap();
        assert_eq!(soup.faces, [[0, 1, 2], [3, 4, 5]]);
    }

    #[test]
    fn faces_may_come_before_their_vertices() {
        assert_eq!(parse(format!("f 1 2 3 4\n{VERTICES}").as_bytes()).unwrap().faces, [[0, 1, 2, 3]]);
        let late = fault(&format!("f 1 2 3\nf 1 2 6\nf 1 2 5\nf 1 2 9\n{VERTICES}"));
        assert_eq!(late, (2, ContentDefect::IndexOutOfRange { what: "face", index: 6, count: 4 }));
    }

    #[test]
    fn errors_name_the_line() {
        use ContentDefect::{Binary, IndexOutOfRange, IndexZero, NotANumber, NotFinite, Truncated, WrongCount};
        let cases: [(&str, u64, ContentDefect); 14] = [
            ("v 0 0 nan\n", 1, NotFinite("nan".into())),
            ("v 0 0 0\nv 0 -inf 0\n", 2, NotFinite("-inf".into())),
            ("v 0 0 1e999\n", 1, NotFinite("1e999".into())),
            ("v 0 0 1.2.3\n", 1, NotANumber("1.2.3".into())),
            ("v 0,5 0 0\n", 1, NotANumber("0,5".into())),
            ("v 0 0\n", 1, WrongCount { what: "vertex", found: 2, wanted: "3 coordinates" }),
            ("v 0 0", 1, Truncated("its last line".into())),
            ("v 0 0 0\nf 1 1 0\n", 2, IndexZero),
            ("v 0 0 0\nf 1 1 -2\n", 2, IndexOutOfRange { what: "face", index: -2, count: 1 }),
            ("v 0 0 0\nf 1 1 2\n", 2, IndexOutOfRange { what: "face", index: 2, count: 1 }),
            ("v 0 0 0\nf 1 1 1\nl 1 3\n", 3, IndexOutOfRange { what: "polyline", index: 3, count: 1 }),
            ("v 0 0 0\nf 1 1 1/x\n", 2, NotANumber("1/x".into())),
            ("v 0 0 0\nf 1 1", 2, Truncated("its last line".into())),
            ("# x\n\0\u{1}\u{2}\n", 2, Binary("OBJ")),
        ];
        for (text, line, defect) in cases {
            assert_eq!(fault(text), (line, defect), "{text:?}");
        }
    }

    #[test]
    fn line_numbers_count_continued_lines() {
        assert_eq!(fault("v 0 \\\n 0 \\\n 0\nv 1 1 x\n").0, 4);
    }

    #[test]
    fn a_backslash_in_a_comment_or_name_joins_nothing() {
        let soup = parse(b"# C:\\\nv 0 0 0\nusemtl D:\\\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        assert_eq!((soup.positions.len(), soup.faces.len()), (3, 1));
    }

    #[test]
    fn names_need_not_be_utf8() {
        let soup = parse(b"o caf\xe9\ng \xff\xfe\nusemtl \xb5\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        assert_eq!(soup.faces.len(), 1);
    }

    #[test]
    fn colours_follow_the_coordinates() {
        let soup = parse(b"v 0 0 0\nv 1 0 0 1 0.5 0\nv 2 0 0\n").unwrap();
        assert_eq!(soup.vertex_colors.unwrap(), [[1.0; 3], [1.0, 0.5, 0.0], [1.0; 3]]);
        let bytes = parse(b"v 0 0 0 255 0 51\n").unwrap();
        assert_eq!(bytes.vertex_colors.unwrap(), [[1.0, 0.0, 0.2]]);
        assert_eq!(parse(b"v 0 0 0 1\n").unwrap().vertex_colors, None);
    }

    #[test]
    fn a_face_is_mapped_if_all_its_corners_are() {
        let soup = parse(
            format!("{VERTICES}vt 0.25 0\nvt 1\nvt nan 0\nf 1/1 2/2 3/1\nf 1/1 2 3/1\nf 1/1 2/9 3/1\nf 1/1 2/3 3/1\n")
                .as_bytes(),
        )
        .unwrap();
        let none = Vec::new();
        assert_eq!(
            soup.corner_uv.unwrap(),
            [vec![[0.25, 0.0], [1.0, 0.0], [0.25, 0.0]], none.clone(), none.clone(), none]
        );
    }

    #[test]
    fn corners_of_a_vertex_share_equal_texture_vertices() {
        let uv = |x: f64| [x, 0.0];
        let surface = SurfaceOut {
            corner_uv: Some(vec![vec![uv(0.0), uv(0.0), uv(1.0)], vec![], vec![uv(0.0), uv(2.0), uv(0.0)]]),
            ..SurfaceOut::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![vec![0, 1, 2], vec![0, 1, 2], vec![0, 2, 1]])
        };
        let mut text = Vec::new();
        write(&surface, &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert_eq!(text.lines().filter(|l| l.starts_with("vt")).count(), 4);
        assert!(text.ends_with("f 1/1 2/2 3/3\nf 1 2 3\nf 1/1 3/4 2/2\n"), "{text}");
    }
}
