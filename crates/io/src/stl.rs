//! STL, ASCII and binary, welded.
//!
//! In: bytes. Out: a soup whose equal points are one vertex, numbered as they appear; or the line or byte at fault.
//! Holds: only equal coordinates are welded (0 and -0 are equal); normals in the file are passed over, the order of the
//! corners counts. Source: <https://www.fabbers.com/tech/STL_Format>.

use crate::error::{ContentDefect, Fault};
use crate::surface::{Encoding, SurfaceOut};
use crate::text::{Lines, Shortest, point, shown, tokens};
use crate::triangulate::fans;
use quadloom_mesh::{DVec3, FaceSoup};
use std::collections::HashMap;
use std::io::{self, Write};

/// Bytes before the first facet of a binary file: a free text and the number of facets.
const HEADER: usize = 84;
/// Bytes of a binary facet: normal, three corners, two spare bytes.
const FACET: usize = 50;

/// Whether this is a text file: `solid`, then `facet` or `endsolid` soon after. Binary files may begin with `solid` too.
pub(crate) fn is_ascii(bytes: &[u8]) -> bool {
    const SOON: usize = 4096;
    let head = bytes[..bytes.len().min(SOON)].to_ascii_lowercase();
    let has = |word: &[u8]| head.windows(word.len()).any(|w| w == word);
    head.trim_ascii_start().starts_with(b"solid") && (has(b"facet") || has(b"endsolid")) && !has_binary_length(bytes)
}

/// Whether the file is exactly as long as its number of binary facets asks for.
pub(crate) fn has_binary_length(bytes: &[u8]) -> bool {
    facet_count(bytes).is_some_and(|n| n.checked_mul(FACET).and_then(|b| b.checked_add(HEADER)) == Some(bytes.len()))
}

fn facet_count(bytes: &[u8]) -> Option<usize> {
    Some(u32::from_le_bytes(bytes.get(HEADER - 4..HEADER)?.try_into().ok()?) as usize)
}

/// Reads an STL file.
pub(crate) fn parse(bytes: &[u8]) -> Result<FaceSoup, Fault> {
    if is_ascii(bytes) { parse_ascii(bytes) } else { parse_binary(bytes) }
}

fn parse_binary(bytes: &[u8]) -> Result<FaceSoup, Fault> {
    let Some(count) = facet_count(bytes) else {
        return Err(Fault::byte(bytes.len(), ContentDefect::Truncated("its header".into())));
    };
    let body = &bytes[HEADER..];
    if body.len() / FACET < count {
        let text = format!("its facets: {count} were promised, {} are there", body.len() / FACET);
        return Err(Fault::byte(bytes.len(), ContentDefect::Truncated(text)));
    }
    let mut weld = Weld::default();
    for (f, facet) in body.as_chunks::<FACET>().0[..count].iter().enumerate() {
        let value = |k: usize| f64::from(f32::from_le_bytes([0, 1, 2, 3].map(|b| facet[4 * k + b])));
        let corners = [3, 6, 9].map(|k| DVec3::new(value(k), value(k + 1), value(k + 2)));
        if corners.iter().any(|p| !p.is_finite()) {
            let bad = format!("facet {f}: {corners:?}");
            return Err(Fault::byte(HEADER + f * FACET, ContentDefect::NotFinite(bad)));
        }
        weld.face(&corners);
    }
    weld.soup().map_err(|defect| Fault::byte(bytes.len(), defect))
}

fn parse_ascii(bytes: &[u8]) -> Result<FaceSoup, Fault> {
    let mut lines = Lines::new(bytes);
    let mut weld = Weld::default();
    // Corners since the last `facet`; `None` between facets.
    let mut facet: Option<Vec<DVec3>> = None;
    for line in lines.by_ref() {
        let mut words = tokens(line.bytes);
        let Some(word) = words.next() else { continue };
        match (word.to_ascii_lowercase().as_slice(), &mut facet) {
            (b"facet", None) => facet = Some(Vec::new()),
            (b"vertex", Some(corners)) => corners.push(point(&mut words, line.number, "vertex")?),
            (b"endfacet", Some(corners)) => {
                let found = corners.len();
                if found != 3 {
                    let defect = ContentDefect::WrongCount { what: "corners of a facet", found, wanted: "3" };
                    return Err(Fault::line(line.number, defect));
                }
                weld.face(corners);
                facet = None;
            }
            (b"outer" | b"endloop", Some(_)) | (b"solid" | b"endsolid", None) => {}
            _ => {
                let text = format!("`{}` is out of place here", shown(word));
                return Err(Fault::line(line.number, ContentDefect::Malformed(text)));
            }
        }
    }
    if facet.is_some() {
        return Err(Fault::line(lines.number(), ContentDefect::Truncated("a facet".into())));
    }
    weld.soup().map_err(|defect| Fault::line(lines.number(), defect))
}

#[derive(Default)]
struct Weld {
    vertex_at: HashMap<[u64; 3], u32>,
    positions: Vec<DVec3>,
    faces: Vec<Vec<u32>>,
}

impl Weld {
    fn face(&mut self, corners: &[DVec3]) {
        let face = corners.iter().map(|&p| self.vertex(p)).collect();
        self.faces.push(face);
    }

    fn vertex(&mut self, p: DVec3) -> u32 {
        // Adding zero turns -0 into 0, which is the same place.
        let key = (p + DVec3::ZERO).to_array().map(f64::to_bits);
        *self.vertex_at.entry(key).or_insert_with(|| {
            self.positions.push(p);
            (self.positions.len() - 1) as u32
        })
    }

    fn soup(self) -> Result<FaceSoup, ContentDefect> {
        if self.positions.len() >= u32::MAX as usize {
            return Err(ContentDefect::TooLarge);
        }
        Ok(FaceSoup { positions: self.positions, faces: self.faces, ..FaceSoup::default() })
    }
}

/// Writes an STL file; larger faces as fans.
pub(crate) fn write(surface: &SurfaceOut, encoding: Encoding, out: &mut dyn Write) -> io::Result<()> {
    let triangles = fans(&surface.faces, &surface.positions);
    let corners = |t: &[u32; 3]| t.map(|v| surface.positions[v as usize]);
    let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
    match encoding {
        Encoding::Ascii => {
            out.write_all(b"solid quadloom\n")?;
            for t in triangles.iter().map(corners) {
                let spelled = |p: DVec3| p.to_array().map(|x| Shortest(x).to_string()).join(" ");
                writeln!(out, "facet normal {}\n outer loop", spelled(normal(t)))?;
                t.iter().try_for_each(|&p| writeln!(out, "  vertex {}", spelled(p)))?;
                out.write_all(b" endloop\nendfacet\n")?;
            }
            out.write_all(b"endsolid quadloom\n")
        }
        Encoding::Binary => {
            let count = u32::try_from(triangles.len()).map_err(io::Error::other)?;
            // The text must not begin with `solid`, which some readers take for the mark of the other encoding.
            let mut head = [b' '; HEADER - 4];
            head[..8].copy_from_slice(b"quadloom");
            out.write_all(&head)?;
            out.write_all(&count.to_le_bytes())?;
            for t in triangles.iter().map(corners) {
                for p in std::iter::once(normal(t)).chain(t) {
                    p.as_vec3().to_array().iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
                }
                out.write_all(&[0, 0])?;
            }
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Place;

    const TWO: &str = "solid a b\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\n\
        endfacet\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 1 0 -0\nVERTEX 1 1 0\nVERTEX 0 1 0\nENDLOOP\nENDFACET\nendsolid a b\n";

    #[test]
    fn equal_points_are_welded() {
        let soup = parse(TWO.as_bytes()).unwrap();
        assert_eq!(soup.faces, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(soup.positions.len(), 4);
    }

    #[test]
    fn ascii_faults_name_the_line() {
        for (from, to, line, part) in [
            ("  vertex 1 0 0\n", "", 7, "2 values"),
            ("vertex 1 0 0", "vertex 1 0", 5, "2 values"),
            ("vertex 1 0 0", "vertex 1 0 inf", 5, "finite"),
            ("vertex 1 0 0", "vortex 1 0 0", 5, "`vortex`"),
            ("ENDFACET\nendsolid a b\n", "", 14, "truncated"),
            ("endfacet\n", "", 8, "out of place"),
        ] {
            let fault = parse(TWO.replacen(from, to, 1).as_bytes()).unwrap_err();
            assert_eq!(fault.place, Place::Line(line), "{from:?}");
            assert!(fault.defect.to_string().contains(part), "{from:?}: {}", fault.defect);
        }
    }

    fn binary(head: &[u8], count: u32, facets: usize) -> Vec<u8> {
        let mut bytes = head.to_vec();
        bytes.resize(80, 0);
        bytes.extend(count.to_le_bytes());
        let values = [0.0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        for _ in 0..facets {
            bytes.extend(values.iter().flat_map(|x| x.to_le_bytes()).chain([0, 0]));
        }
        bytes
    }

    #[test]
    fn a_binary_file_may_begin_with_solid() {
        let soup = parse(&binary(b"solid facet", 2, 2)).unwrap();
        assert_eq!((soup.positions.len(), soup.faces.len()), (3, 2));
    }

    #[test]
    fn lying_counts_and_bad_floats_are_found() {
        for (bytes, part) in [
            (binary(b"", u32::MAX, 1), "4294967295 were promised, 1 are there"),
            (binary(b"", 1, 1)[..100].to_vec(), "promised"),
            (binary(b"", 1, 1)[..60].to_vec(), "header"),
        ] {
            let fault = parse(&bytes).unwrap_err();
            assert!(fault.defect.to_string().contains(part), "{}", fault.defect);
        }
        let mut bytes = binary(b"", 1, 1);
        bytes[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(matches!(parse(&bytes).unwrap_err().defect, ContentDefect::NotFinite(_)));
    }
}
