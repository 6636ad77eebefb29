//! VTU, the unstructured grid of VTK in XML.
//!
//! In: a surface. Out: one piece with polygons, quads and triangles as cells and attributes as point and cell data.
//! Holds: coordinates are double; in the binary encoding, and wherever a value is not finite (which the text form
//! cannot hold), arrays are base64. Source: VTK file formats, <https://docs.vtk.org/en/latest/vtk_file_formats>.

use crate::surface::{Encoding, SurfaceOut};
use crate::text::Shortest;
use base64::Engine;
use std::fmt::Display;
use std::io::{self, Write};

/// VTK's numbers of cell types.
const TRIANGLE: u8 = 5;
const POLYGON: u8 = 7;
const QUAD: u8 = 9;

/// Writes a VTU file.
pub(crate) fn write(surface: &SurfaceOut, encoding: Encoding, out: &mut dyn Write) -> io::Result<()> {
    let (points, cells) = (surface.positions.len(), surface.faces.len());
    writeln!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <UnstructuredGrid>\n<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"
    )?;
    let mut sink = Sink { out, encoding };
    // 1. Attributes.
    sink.attributes("PointData", &surface.vertex_attributes)?;
    sink.attributes("CellData", &surface.face_attributes)?;
    // 2. Points.
    let coordinates: Vec<f64> = surface.positions.iter().flat_map(|p| p.to_array()).collect();
    sink.line("<Points>")?;
    sink.doubles("Points", 3, &coordinates)?;
    sink.line("</Points>\n<Cells>")?;
    // 3. Cells: corners, where each cell ends in that list, and its type.
    let corners: Vec<i64> = surface.faces.iter().flatten().map(|&v| i64::from(v)).collect();
    let ends = surface.faces.iter().scan(0, |end, face| {
        *end += face.len() as i64;
        Some(*end)
    });
    let types: Vec<u8> = surface.faces.iter().map(|face| cell_type(face.len())).collect();
    sink.array("Int64", "connectivity", 1, &corners, |v| v.to_le_bytes())?;
    sink.array("Int64", "offsets", 1, &ends.collect::<Vec<i64>>(), |v| v.to_le_bytes())?;
    sink.array("UInt8", "types", 1, &types, |t| [t])?;
    sink.line("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
}

fn cell_type(corners: usize) -> u8 {
    match corners {
        3 => TRIANGLE,
        4 => QUAD,
        _ => POLYGON,
    }
}

struct Sink<'a> {
    out: &'a mut dyn Write,
    encoding: Encoding,
}

impl Sink<'_> {
    fn line(&mut self, text: &str) -> io::Result<()> {
        writeln!(self.out, "{text}")
    }

    fn attributes(&mut self, section: &str, attributes: &[(String, Vec<f64>)]) -> io::Result<()> {
        self.line(&format!("<{section}>"))?;
        attributes.iter().try_for_each(|(name, values)| self.doubles(name, 1, values))?;
        self.line(&format!("</{section}>"))
    }

    fn doubles(&mut self, name: &str, components: usize, values: &[f64]) -> io::Result<()> {
        let encoding = self.encoding;
        if !values.iter().all(|x| x.is_finite()) {
            self.encoding = Encoding::Binary;
        }
        // The text is only used in the text encoding, where it reads back bit for bit.
        let spelled: Vec<Spelled> = values.iter().map(|&x| Spelled(x)).collect();
        let written = self.array("Float64", name, components, &spelled, |x| x.0.to_le_bytes());
        self.encoding = encoding;
        written
    }

    fn array<T: Copy + Display, const N: usize>(
        &mut self,
        kind: &str,
        name: &str,
        components: usize,
        values: &[T],
        bytes: impl Fn(T) -> [u8; N],
    ) -> io::Result<()> {
        let format = if self.encoding == Encoding::Ascii { "ascii" } else { "binary" };
        let name = escaped(name);
        writeln!(
            self.out,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"{format}\">"
        )?;
        match self.encoding {
            Encoding::Ascii => {
                for row in values.chunks(components) {
                    for (k, value) in row.iter().enumerate() {
                        write!(self.out, "{}{value}", if k == 0 { "" } else { " " })?;
                    }
                    self.out.write_all(b"\n")?;
                }
            }
            Encoding::Binary => {
                // The number of bytes, then the bytes, in one base64 stream.
                let mut raw = ((values.len() * N) as u64).to_le_bytes().to_vec();
                raw.extend(values.iter().flat_map(|&v| bytes(v)));
                writeln!(self.out, "{}", base64::engine::general_purpose::STANDARD.encode(raw))?;
            }
        }
        self.line("</DataArray>")
    }
}

#[derive(Clone, Copy)]
struct Spelled(f64);

impl Display for Spelled {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Shortest(self.0).fmt(f)
    }
}

fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
