//! PLY, ASCII and binary in both byte orders.
//!
//! In: bytes. Out: a soup, or the line or byte at fault. Holds: memory follows the bytes that are there, never a count
//! that is only promised; scalar properties of vertices other than place and colour are kept by name.
//! Source: Turk, The PLY Polygon File Format (1994).
//!
//! ```text
//!     element vertex      x y z, red green blue (also diffuse_red …, r g b), any other scalar is an attribute
//!     element face        list vertex_indices (or vertex_index), list texcoord (u v of each corner)
//!     element tristrips   list vertex_indices, strips separated by -1
//!     element edge        vertex1 vertex2
//! ```

use crate::error::{ContentDefect, Fault, Place};
use crate::fields::content;
use crate::obj::unit_colors;
use crate::surface::{Encoding, SurfaceOut};
use crate::text::{Lines, Shortest, number_at, parse_integer, shown, tokens};
use quadloom_mesh::{DVec3, FaceSoup};
use std::io::{self, Write};

/// Reads a PLY file.
pub(crate) fn parse(bytes: &[u8]) -> Result<FaceSoup, Fault> {
    // 1. The header tells what follows.
    let mut lines = Lines::new(bytes);
    let header = Header::parse(&mut lines)?;
    // 2. Elements, in the order of the header.
    let mut body = match header.encoding {
        Body::Ascii => Source::Ascii(lines),
        Body::Binary { big_endian } => Source::Binary { bytes, at: bytes.len() - lines.rest().len(), big_endian },
    };
    let mut reader = Reader::default();
    for element in &header.elements {
        reader.element(element, &mut body)?;
    }
    if let Source::Ascii(lines) = &mut body
        && let Some(line) = lines.next_content()
    {
        let text = "more lines than the header promises; is one of its counts wrong?";
        return Err(Fault::line(line.number, ContentDefect::Malformed(text.into())));
    }
    // 3. Vertices may come after the faces that use them.
    reader.finish()
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The value of `size` bytes.
    fn decode(self, bytes: &[u8], big_endian: bool) -> f64 {
        let mut little = [0u8; 8];
        little[..bytes.len()].copy_from_slice(bytes);
        if big_endian {
            little[..bytes.len()].reverse();
        }
        let low = u32::from_le_bytes([little[0], little[1], little[2], little[3]]);
        match self {
            Self::I8 => f64::from(low as u8 as i8),
            Self::U8 => f64::from(low as u8),
            Self::I16 => f64::from(low as u16 as i16),
            Self::U16 => f64::from(low as u16),
            Self::I32 => f64::from(low as i32),
            Self::U32 => f64::from(low),
            Self::F32 => f64::from(f32::from_bits(low)),
            Self::F64 => f64::from_le_bytes(little),
        }
    }

    /// What stands for full intensity in a colour of this type.
    fn white(self) -> f64 {
        match self {
            Self::U8 => 255.0,
            Self::U16 => 65535.0,
            _ => 1.0,
        }
    }
}

struct Property {
    name: String,
    /// Type of the number of items, for a list.
    count: Option<Number>,
    item: Number,
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

impl Element {
    fn scalar(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|p| p.count.is_none() && names.contains(&p.name.as_str()))
    }
    fn list(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|p| p.count.is_some() && names.contains(&p.name.as_str()))
    }
}

enum Body {
    Ascii,
    Binary { big_endian: bool },
}

struct Header {
    encoding: Body,
    elements: Vec<Element>,
}

impl Header {
    fn parse(lines: &mut Lines) -> Result<Self, Fault> {
        let bad = |line: u64, text: String| Fault::line(line, ContentDefect::Header(text));
        let first = content(lines, || "its header".into())?;
        if first.bytes.trim_ascii_end() != b"ply" {
            return Err(bad(first.number, "a PLY file begins with a line `ply`".into()));
        }
        let (mut encoding, mut elements) = (None, Vec::<Element>::new());
        loop {
            let line = content(lines, || "its header".into())?;
            let words: Vec<&[u8]> = line.bytes.split(u8::is_ascii_whitespace).filter(|t| !t.is_empty()).collect();
            let unknown = || bad(line.number, format!("`{}` is not understood", shown(line.bytes.trim_ascii())));
            match words.as_slice() {
                [b"comment" | b"obj_info", ..] => {}
                [b"format", name, _version] => encoding = Some(body_named(name).ok_or_else(unknown)?),
                [b"element", name, count] => {
                    let count = parse_integer(count).and_then(|n| u64::try_from(n).ok()).ok_or_else(unknown)?;
                    elements.push(Element { name: text_of(name), count, properties: Vec::new() });
                }
                [b"property", rest @ ..] => {
                    let element = elements.last_mut().ok_or_else(unknown)?;
                    element.properties.push(property(rest).ok_or_else(unknown)?);
                }
                [b"end_header"] if line.terminated => break,
                [b"end_header"] => return Err(Fault::line(line.number, ContentDefect::Truncated("its header".into()))),
                _ => return Err(unknown()),
            }
        }
        let line = lines.number();
        let encoding = encoding.ok_or_else(|| bad(line, "there is no `format` line".into()))?;
        for (k, element) in elements.iter().enumerate() {
            if elements[..k].iter().any(|e| e.name == element.name) {
                return Err(bad(line, format!("two elements are called {}", element.name)));
            }
        }
        Ok(Self { encoding, elements })
    }
}

fn text_of(name: &[u8]) -> String {
    String::from_utf8_lossy(name).into_owned()
}

fn body_named(name: &[u8]) -> Option<Body> {
    match name {
        b"ascii" => Some(Body::Ascii),
        b"binary_little_endian" => Some(Body::Binary { big_endian: false }),
        b"binary_big_endian" => Some(Body::Binary { big_endian: true }),
        _ => None,
    }
}

fn property(words: &[&[u8]]) -> Option<Property> {
    match words {
        [b"list", count, item, name] => {
            let count = Number::from_name(count)?;
            Some(Property { name: text_of(name), count: Some(count), item: Number::from_name(item)? })
        }
        [item, name] => Some(Property { name: text_of(name), count: None, item: Number::from_name(item)? }),
        _ => None,
    }
}

/// The values of one element: those of property `k` are `values[start[k]..start[k + 1]]`.
#[derive(Default)]
struct Row {
    values: Vec<f64>,
    start: Vec<usize>,
    place: Option<Place>,
}

impl Row {
    fn list(&self, property: usize) -> &[f64] {
        &self.values[self.start[property]..self.start[property + 1]]
    }
    fn scalar(&self, property: usize) -> f64 {
        self.values[self.start[property]]
    }
    fn fault(&self, defect: ContentDefect) -> Fault {
        Fault { place: self.place.unwrap_or(Place::Byte(0)), defect }
    }
}

enum Source<'a> {
    Ascii(Lines<'a>),
    Binary { bytes: &'a [u8], at: usize, big_endian: bool },
}

impl Source<'_> {
    /// Reads one element into `row`; `number` is its own number, for messages.
    fn row(&mut self, element: &Element, number: u64, row: &mut Row) -> Result<(), Fault> {
        row.values.clear();
        row.start.clear();
        let cut = || format!("element {}: {} were promised, {number} are there", element.name, element.count);
        match self {
            Self::Ascii(lines) => {
                let line = content(lines, cut)?;
                row.place = Some(Place::Line(line.number));
                let mut words = tokens(line.bytes);
                let next = |_: Number| match words.next() {
                    Some(word) => number_at(word, line.number),
                    None if !line.terminated => Err(Fault::line(line.number, ContentDefect::Truncated(cut()))),
                    None => {
                        let text = format!("too few values for an element {}", element.name);
                        Err(Fault::line(line.number, ContentDefect::Malformed(text)))
                    }
                };
                fill(element, row, next, |_| true)?;
                match words.next() {
                    Some(word) => {
                        let text = format!("`{}` is one value too many for an element {}", shown(word), element.name);
                        Err(Fault::line(line.number, ContentDefect::Malformed(text)))
                    }
                    None => Ok(()),
                }
            }
            Self::Binary { bytes, at, big_endian } => {
                row.place = Some(Place::Byte(*at as u64));
                let position = std::cell::Cell::new(*at);
                let next = |kind: Number| {
                    let from = position.get();
                    let value = bytes.get(from..from + kind.size());
                    let value = value.ok_or_else(|| Fault::byte(from, ContentDefect::Truncated(cut())))?;
                    position.set(from + kind.size());
                    Ok(kind.decode(value, *big_endian))
                };
                fill(element, row, next, |needed| needed <= (bytes.len() - position.get()) as f64)?;
                *at = position.get();
                Ok(())
            }
        }
    }
}

/// Reads the properties of one element; `fits` tells whether that many bytes can be there at all.
fn fill(
    element: &Element,
    row: &mut Row,
    mut next: impl FnMut(Number) -> Result<f64, Fault>,
    fits: impl Fn(f64) -> bool,
) -> Result<(), Fault> {
    for property in &element.properties {
        row.start.push(row.values.len());
        let Some(count_type) = property.count else {
            row.values.push(next(property.item)?);
            continue;
        };
        let count = next(count_type)?;
        if !(count >= 0.0 && count.fract() == 0.0) {
            let text = format!("list {} has a length of {count}", property.name);
            return Err(row.fault(ContentDefect::Malformed(text)));
        }
        if !fits(count * property.item.size() as f64) {
            let text = format!("list {} of {count} items", property.name);
            return Err(row.fault(ContentDefect::Truncated(text)));
        }
        let mut k = 0.0;
        while k < count {
            row.values.push(next(property.item)?);
            k += 1.0;
        }
    }
    row.start.push(row.values.len());
    Ok(())
}

#[derive(Default)]
struct Reader {
    soup: FaceSoup,
    /// Vertex numbers larger than all before them, with their places: the first one out of range is among them.
    records: Vec<(u32, Place)>,
}

impl Reader {
    fn element(&mut self, element: &Element, source: &mut Source) -> Result<(), Fault> {
        // Nothing is stored of an element without properties, however many there are.
        if element.properties.is_empty() {
            return Ok(());
        }
        match element.name.as_str() {
            "vertex" => self.vertices(element, source),
            "face" => self.faces(element, source),
            "tristrips" => self.strips(element, source),
            "edge" => self.edges(element, source),
            _ => rows(element, source, |_| Ok(())),
        }
    }

    fn vertices(&mut self, element: &Element, source: &mut Source) -> Result<(), Fault> {
        let place = [["x"], ["y"], ["z"]].map(|names| element.scalar(&names));
        let [Some(x), Some(y), Some(z)] = place else {
            return Err(source_fault(source, ContentDefect::Header("the vertices have no x, y, z".into())));
        };
        let color = color_properties(element);
        let taken = |k: &usize| [x, y, z].contains(k) || color.is_some_and(|c| c.contains(k));
        let attributes: Vec<usize> =
            (0..element.properties.len()).filter(|k| element.properties[*k].count.is_none() && !taken(k)).collect();
        let mut kept: Vec<Vec<f64>> = vec![Vec::new(); attributes.len()];
        let mut colors = Vec::new();
        let positions = &mut self.soup.positions;
        rows(element, source, |row| {
            let p = DVec3::new(row.scalar(x), row.scalar(y), row.scalar(z));
            if !p.is_finite() {
                return Err(row.fault(ContentDefect::NotFinite(format!("vertex {}: {p}", positions.len()))));
            }
            if positions.len() + 1 >= u32::MAX as usize {
                return Err(row.fault(ContentDefect::TooLarge));
            }
            positions.push(p);
            if let Some(channels) = color {
                colors.push(channels.map(|k| (row.scalar(k) / element.properties[k].item.white()) as f32));
            }
            kept.iter_mut().zip(&attributes).for_each(|(values, &k)| values.push(row.scalar(k)));
            Ok(())
        })?;
        self.soup.vertex_colors = color.map(|_| unit_colors(colors));
        let name = |k: usize| element.properties[k].name.clone();
        self.soup.vertex_attributes = attributes.iter().map(|&k| name(k)).zip(kept).collect();
        Ok(())
    }

    fn faces(&mut self, element: &Element, source: &mut Source) -> Result<(), Fault> {
        let only_list = || {
            let mut lists = (0..element.properties.len()).filter(|&k| element.properties[k].count.is_some());
            lists.next().filter(|_| lists.next().is_none())
        };
        let Some(corners) = element.list(&["vertex_indices", "vertex_index"]).or_else(only_list) else {
            return Err(source_fault(source, ContentDefect::Header("the faces have no list vertex_indices".into())));
        };
        let texture = element.list(&["texcoord"]).filter(|&t| t != corners);
        let mut uv = Vec::new();
        rows(element, source, |row| {
            let face = row.list(corners).iter().map(|&index| self.vertex(index, row)).collect::<Result<Vec<_>, _>>()?;
            if let Some(t) = texture {
                uv.push(texture_coordinates(row.list(t), face.len()));
            }
            self.soup.faces.push(face);
            Ok(())
        })?;
        self.soup.corner_uv = texture.map(|_| uv);
        Ok(())
    }

    /// Every second triangle of a strip is turned round.
    fn strips(&mut self, element: &Element, source: &mut Source) -> Result<(), Fault> {
        let Some(list) = element.list(&["vertex_indices", "vertex_index"]) else {
            return Err(source_fault(source, ContentDefect::Header("the strips have no list vertex_indices".into())));
        };
        rows(element, source, |row| {
            for strip in row.list(list).split(|&index| index == -1.0) {
                let strip = strip.iter().map(|&index| self.vertex(index, row)).collect::<Result<Vec<_>, _>>()?;
                let turned = |(k, w): (usize, &[u32])| if k % 2 == 0 { w.to_vec() } else { vec![w[1], w[0], w[2]] };
                self.soup.faces.extend(strip.windows(3).enumerate().map(turned));
            }
            Ok(())
        })
    }

    fn edges(&mut self, element: &Element, source: &mut Source) -> Result<(), Fault> {
        let ends = (element.scalar(&["vertex1"]), element.scalar(&["vertex2"]));
        rows(element, source, |row| {
            if let (Some(a), Some(b)) = ends {
                let edge = vec![self.vertex(row.scalar(a), row)?, self.vertex(row.scalar(b), row)?];
                self.soup.polylines.push(edge);
            }
            Ok(())
        })
    }

    fn vertex(&mut self, index: f64, row: &Row) -> Result<u32, Fault> {
        if !(0.0..f64::from(u32::MAX)).contains(&index) || index.fract() != 0.0 {
            let text = format!("`{index}` is no vertex number; they count from 0");
            return Err(row.fault(ContentDefect::Malformed(text)));
        }
        let v = index as u32;
        if v as usize >= self.soup.positions.len() && self.records.last().is_none_or(|&(largest, _)| v > largest) {
            self.records.push((v, row.place.unwrap_or(Place::Byte(0))));
        }
        Ok(v)
    }

    fn finish(self) -> Result<FaceSoup, Fault> {
        let count = self.soup.positions.len();
        match self.records.iter().find(|&&(v, _)| v as usize >= count) {
            Some(&(v, place)) => Err(Fault {
                place,
                defect: ContentDefect::IndexOutOfRange { what: "face", index: i64::from(v), count },
            }),
            None => Ok(self.soup),
        }
    }
}

/// Reads every row of an element.
fn rows(element: &Element, source: &mut Source, mut take: impl FnMut(&Row) -> Result<(), Fault>) -> Result<(), Fault> {
    let mut row = Row::default();
    for number in 0..element.count {
        source.row(element, number, &mut row)?;
        take(&row)?;
    }
    Ok(())
}

fn source_fault(source: &Source, defect: ContentDefect) -> Fault {
    match source {
        Source::Ascii(lines) => Fault::line(lines.number(), defect),
        Source::Binary { at, .. } => Fault::byte(*at, defect),
    }
}

/// Properties of red, green and blue.
fn color_properties(element: &Element) -> Option<[usize; 3]> {
    let red = element.scalar(&["red", "diffuse_red", "r"])?;
    let green = element.scalar(&["green", "diffuse_green", "g"])?;
    Some([red, green, element.scalar(&["blue", "diffuse_blue", "b"])?])
}

/// Pairs of a list with two finite values per corner; unmapped otherwise.
fn texture_coordinates(values: &[f64], corners: usize) -> Vec<[f64; 2]> {
    let (pairs, _) = values.as_chunks::<2>();
    if values.len() == 2 * corners && values.iter().all(|x| x.is_finite()) { pairs.to_vec() } else { Vec::new() }
}

/// Writes a PLY file with double coordinates.
pub(crate) fn write(surface: &SurfaceOut, encoding: Encoding, out: &mut dyn Write) -> io::Result<()> {
    let bytes = surface.vertex_colors.as_ref().map(|colors| bytes_of_colors(colors));
    write_header(surface, encoding, &bytes, out)?;
    let mut sink = Sink { out, encoding, at_start: true };
    for (v, p) in surface.positions.iter().enumerate() {
        p.to_array().iter().try_for_each(|&x| sink.double(x))?;
        match (&bytes, &surface.vertex_colors) {
            (Some(Some(bytes)), _) => bytes[v].iter().try_for_each(|&c| sink.byte(c))?,
            (_, Some(colors)) => colors[v].iter().try_for_each(|&c| sink.float(c))?,
            _ => {}
        }
        surface.vertex_attributes.iter().try_for_each(|(_, values)| sink.double(values[v]))?;
        sink.end()?;
    }
    let wide = wide_lists(surface);
    for (f, face) in surface.faces.iter().enumerate() {
        sink.length(face.len(), wide)?;
        face.iter().try_for_each(|&v| sink.integer(v))?;
        if let Some(uv) = &surface.corner_uv {
            sink.length(2 * uv[f].len(), wide)?;
            uv[f].iter().flatten().try_for_each(|&x| sink.double(x))?;
        }
        surface.face_attributes.iter().try_for_each(|(_, values)| sink.double(values[f]))?;
        sink.end()?;
    }
    for edge in surface.polylines.iter().flat_map(|line| line.windows(2)) {
        edge.iter().try_for_each(|&v| sink.integer(v))?;
        sink.end()?;
    }
    Ok(())
}

fn write_header(
    surface: &SurfaceOut,
    encoding: Encoding,
    bytes: &Option<Option<Vec<[u8; 3]>>>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let format = if encoding == Encoding::Ascii { "ascii" } else { "binary_little_endian" };
    writeln!(out, "ply\nformat {format} 1.0\nelement vertex {}", surface.positions.len())?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    if let Some(bytes) = bytes {
        let kind = if bytes.is_some() { "uchar" } else { "float" };
        writeln!(out, "property {kind} red\nproperty {kind} green\nproperty {kind} blue")?;
    }
    surface.vertex_attributes.iter().try_for_each(|(name, _)| writeln!(out, "property double {name}"))?;
    let length = if wide_lists(surface) { "uint" } else { "uchar" };
    let index = if surface.positions.len() <= i32::MAX as usize { "int" } else { "uint" };
    writeln!(out, "element face {}\nproperty list {length} {index} vertex_indices", surface.faces.len())?;
    if surface.corner_uv.is_some() {
        writeln!(out, "property list {length} double texcoord")?;
    }
    surface.face_attributes.iter().try_for_each(|(name, _)| writeln!(out, "property double {name}"))?;
    let edges: usize = surface.polylines.iter().map(|line| line.len().saturating_sub(1)).sum();
    if edges > 0 {
        writeln!(out, "element edge {edges}\nproperty {index} vertex1\nproperty {index} vertex2")?;
    }
    out.write_all(b"end_header\n")
}

/// Whether some list is longer than a byte can count.
fn wide_lists(surface: &SurfaceOut) -> bool {
    let per_corner = if surface.corner_uv.is_some() { 2 } else { 1 };
    surface.faces.iter().any(|face| face.len() * per_corner > 255)
}

/// Colours as bytes, the common form, if that loses nothing.
fn bytes_of_colors(colors: &[[f32; 3]]) -> Option<Vec<[u8; 3]>> {
    let byte = |c: f32| (c * 255.0).round() as u8;
    let exact = |c: f32| (f64::from(byte(c)) / 255.0) as f32 == c;
    let all = colors.iter().flatten().all(|&c| exact(c));
    all.then(|| colors.iter().map(|color| color.map(byte)).collect())
}

/// Writes values in either encoding.
struct Sink<'a> {
    out: &'a mut dyn Write,
    encoding: Encoding,
    at_start: bool,
}

impl Sink<'_> {
    fn put(&mut self, text: impl std::fmt::Display, bytes: &[u8]) -> io::Result<()> {
        match self.encoding {
            Encoding::Binary => self.out.write_all(bytes),
            Encoding::Ascii if std::mem::take(&mut self.at_start) => write!(self.out, "{text}"),
            Encoding::Ascii => write!(self.out, " {text}"),
        }
    }
    fn double(&mut self, x: f64) -> io::Result<()> {
        self.put(Shortest(x), &x.to_le_bytes())
    }
    fn float(&mut self, x: f32) -> io::Result<()> {
        self.put(x, &x.to_le_bytes())
    }
    fn byte(&mut self, x: u8) -> io::Result<()> {
        self.put(x, &[x])
    }
    fn integer(&mut self, v: u32) -> io::Result<()> {
        self.put(v, &v.to_le_bytes())
    }
    fn length(&mut self, n: usize, wide: bool) -> io::Result<()> {
        if wide { self.integer(n as u32) } else { self.byte(n as u8) }
    }
    fn end(&mut self) -> io::Result<()> {
        self.at_start = true;
        if self.encoding == Encoding::Ascii { self.out.write_all(b"\n") } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "comment c\nelement vertex 3\nproperty float x\nproperty float y\nproperty double z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nproperty short density\nelement face 1\n\
        property list uchar int vertex_index\nend_header\n";

    fn expected() -> FaceSoup {
        FaceSoup {
            positions: vec![DVec3::ZERO, DVec3::new(1.0, 0.0, 0.1), DVec3::Y],
            faces: vec![vec![0, 1, 2]],
            vertex_colors: Some(vec![[1.0, 0.0, 0.2], [0.0; 3], [0.0; 3]]),
            vertex_attributes: vec![("density".into(), vec![-7.0, 0.0, 300.0])],
            ..FaceSoup::default()
        }
    }

    fn body(big_endian: bool) -> Vec<u8> {
        let mut out = Vec::new();
        let mut put = |mut bytes: Vec<u8>| {
            if big_endian {
                bytes.reverse();
            }
            out.extend(bytes);
        };
        for (p, c, d) in [
            ([0.0f32, 0.0], (0.0f64, [255u8, 0, 51]), -7i16),
            ([1.0, 0.0], (0.1, [0; 3]), 0),
            ([0.0, 1.0], (0.0, [0; 3]), 300),
        ] {
            p.iter().for_each(|x| put(x.to_le_bytes().to_vec()));
            put(c.0.to_le_bytes().to_vec());
            c.1.iter().for_each(|&x| put(vec![x]));
            put(d.to_le_bytes().to_vec());
        }
        put(vec![3]);
        [0i32, 1, 2].iter().for_each(|v| put(v.to_le_bytes().to_vec()));
        out
    }

    fn binary(big_endian: bool) -> Vec<u8> {
        let name = if big_endian { "big" } else { "little" };
        let mut file = format!("ply\r\nformat binary_{name}_endian 1.0\n{HEAD}").into_bytes();
        file.extend(body(big_endian));
        file
    }

    #[test]
    fn every_encoding_says_the_same() {
        let text =
            format!("ply\nformat ascii 1.0\n{HEAD}0 0 0 255 0 51 -7\n1 0 0.1 0 0 0 0\n\n0 1 0 0 0 0 300\n3 0 1 2\n");
        assert_eq!(parse(text.as_bytes()).unwrap(), expected());
        assert_eq!(parse(text.replace('\n', "\r\n").as_bytes()).unwrap(), expected());
        assert_eq!(parse(&binary(false)).unwrap(), expected());
        assert_eq!(parse(&binary(true)).unwrap(), expected());
    }

    #[test]
    fn every_truncation_is_an_error() {
        let file = binary(false);
        for length in 0..file.len() {
            assert!(parse(&file[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn strips_edges_and_faces_before_vertices() {
        let text = "ply\nformat ascii 1.0\nelement tristrips 1\nproperty list int int vertex_indices\nelement edge 1\n\
            property int vertex1\nproperty int vertex2\nelement vertex 4\nproperty int x\nproperty int y\nproperty int z\n\
            element nothing 999999999999\nend_header\n8 0 1 2 3 -1 0 1 2\n0 3\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
        let soup = parse(text.as_bytes()).unwrap();
        assert_eq!(soup.faces, [[0, 1, 2], [2, 1, 3], [0, 1, 2]]);
        assert_eq!(soup.polylines, [[0, 3]]);
    }

    #[test]
    fn faults_name_the_place() {
        let head = |n: u64, m: u64, count: &str| {
            format!(
                "ply\nformat ascii 1.0\nelement vertex {n}\nproperty double x\nproperty double y\nproperty double z\n\
                 element face {m}\nproperty list {count} int vertex_indices\nend_header\n"
            )
        };
        for (text, line, part) in [
            (head(2, 0, "int") + "0 0 0\n", 10, "2 were promised, 1 are there"),
            (head(u64::MAX / 2, 0, "int") + "0 0 0\n", 10, "promised"),
            (head(1, 1, "int") + "0 0 0\n3 0 0 1\n", 11, "vertex 1"),
            (head(1, 1, "int") + "0 0 0\n3 0 0 -1\n", 11, "`-1`"),
            (head(1, 1, "int") + "0 0 0\n3 0 0\n", 11, "too few"),
            (head(1, 1, "int") + "0 0 0\n3 0 0", 11, "truncated"),
            (head(1, 1, "int") + "0 0 0\n-3 0 0\n", 11, "length of -3"),
            (head(1, 1, "double") + "0 0 0\n1e300 0 0\n", 11, "too few"),
            (head(1, 0, "int") + "0 inf 0\n", 10, "not a finite"),
            (head(1, 0, "int") + "0 0 0 0\n", 10, "too many"),
            (head(1, 0, "int") + "0 0 0\n0 0 0\n", 11, "more lines"),
            ("ply\nformat ascii 2\nelement vertex -1\n".into(), 3, "element vertex -1"),
            ("ply\nformat ascii 1\nproperty int x\n".into(), 3, "property int x"),
            ("ply\nelement vertex 0\nend_header\n".into(), 3, "format"),
            ("ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nend_header\n1\n".into(), 5, "no x, y, z"),
            ("ply\nformat ascii 1.0\n".into(), 2, "header"),
            ("plx\n".into(), 1, "begins"),
        ] {
            let fault = parse(text.as_bytes()).unwrap_err();
            assert_eq!(fault.place, Place::Line(line), "{text:?} {}", fault.defect);
            assert!(fault.defect.to_string().contains(part), "{text:?}: {}", fault.defect);
        }
    }

    #[test]
    fn a_lying_list_length_allocates_nothing() {
        let mut file = b"ply\nformat binary_little_endian 1.0\nelement face 4000000000\n\
            property list uint double vertex_indices\nend_header\n"
            .to_vec();
        file.extend(u32::MAX.to_le_bytes());
        file.extend([0; 64]);
        let fault = parse(&file).unwrap_err();
        assert!(fault.defect.to_string().contains("4294967295 items"), "{}", fault.defect);
    }
}
