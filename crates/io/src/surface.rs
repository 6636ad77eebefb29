//! Surfaces in files: one function to read any format, one to write any.
//!
//! In: a path, and for writing a [`SurfaceOut`]. Out: a [`FaceSoup`], or the file and what it could not hold.
//! Holds: coordinates written as text or double precision read back bit for bit; nothing that is not finite or
//! that names a missing vertex is ever written; files appear whole or not at all.

use crate::atomic::Batch;
use crate::error::IoError;
use crate::format::Format;
use crate::{glb, obj, off, ply, stl, vtu};
use quadloom_mesh::{DVec3, FaceShape, FaceSoup, Mesh};
use std::fmt;
use std::fs;
use std::path::Path;

/// Reads the faces of an OBJ, PLY, STL or OFF file.
///
/// # Input      a path; the extension tells the format unless the content plainly is of another one
/// # Output     what the file says, in its order and units; equal points of an STL file are welded
/// # Errors     every [`IoError`] of reading; those about content name the line or byte
/// # Guarantees finite coordinates, rounded correctly; indices in range; at least one face
/// # Cost       linear; memory a small multiple of the file's size, whatever its header claims
pub fn read_soup(path: impl AsRef<Path>) -> Result<FaceSoup, IoError> {
    let path = path.as_ref();
    let soup = parse_surface(path, &read_bytes(path)?)?;
    if soup.faces.is_empty() {
        return Err(IoError::NoFaces { path: path.to_path_buf(), vertices: soup.positions.len() });
    }
    Ok(soup)
}

/// Reads a whole file as text.
///
/// # Errors     every [`IoError`] of reading; a file that is no UTF-8 is one
pub fn read_text(path: impl AsRef<Path>) -> Result<String, IoError> {
    let path = path.as_ref();
    String::from_utf8(read_bytes(path)?)
        .map_err(|_| IoError::Mismatch { path: path.to_path_buf(), what: "the file is no text (UTF-8)".into() })
}

/// The bytes of a file that is not empty.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, IoError> {
    // Some systems let a folder be opened and fail later with a less telling error.
    if fs::metadata(path).map_err(|e| IoError::reading(path, e))?.is_dir() {
        return Err(IoError::IsDirectory { path: path.to_path_buf() });
    }
    let bytes = fs::read(path).map_err(|e| IoError::reading(path, e))?;
    if bytes.is_empty() { Err(IoError::Empty { path: path.to_path_buf() }) } else { Ok(bytes) }
}

/// The bytes of a file that may be empty.
pub(crate) fn read_any_bytes(path: &Path) -> Result<Vec<u8>, IoError> {
    match read_bytes(path) {
        Err(IoError::Empty { .. }) => Ok(Vec::new()),
        other => other,
    }
}

fn parse_surface(path: &Path, bytes: &[u8]) -> Result<FaceSoup, IoError> {
    let parsed = match Format::of_file(path, bytes) {
        Some(Format::Obj) => obj::parse(bytes),
        Some(Format::Ply) => ply::parse(bytes),
        Some(Format::Off) => off::parse(bytes),
        Some(Format::Stl) => stl::parse(bytes),
        Some(Format::Vtu | Format::Glb) | None => {
            return Err(IoError::UnknownFormat { path: path.to_path_buf(), expected: "OBJ, PLY, STL or OFF" });
        }
    };
    parsed.map_err(|fault| fault.in_file(path))
}

/// A surface to be written, with what goes with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceOut {
    /// Vertex positions, file units.
    pub positions: Vec<DVec3>,
    /// Vertex numbers of each face, three or more, in order around it.
    pub faces: Vec<Vec<u32>>,
    /// Red, green, blue of each vertex, each in 0..=1.
    pub vertex_colors: Option<Vec<[f32; 3]>>,
    /// Texture coordinates of each corner of each face; an unmapped face has an empty list.
    pub corner_uv: Option<Vec<Vec<[f64; 2]>>>,
    /// Named scalars per vertex; NaN stands for "none".
    pub vertex_attributes: Vec<(String, Vec<f64>)>,
    /// Named scalars per face; NaN stands for "none".
    pub face_attributes: Vec<(String, Vec<f64>)>,
    /// Vertex numbers of feature polylines; a closed one repeats its first vertex.
    pub polylines: Vec<Vec<u32>>,
}

impl SurfaceOut {
    /// Positions and faces alone.
    pub fn new(positions: Vec<DVec3>, faces: Vec<Vec<u32>>) -> Self {
        Self { positions, faces, ..Self::default() }
    }

    /// Why this cannot be written, if it cannot.
    fn defect(&self) -> Option<String> {
        let n = self.positions.len();
        if self.faces.is_empty() && self.polylines.is_empty() {
            return Some("there is no face".into());
        }
        if let Some(v) = self.positions.iter().position(|p| !p.is_finite()) {
            return Some(format!("vertex {v} has a coordinate that is not finite"));
        }
        for (what, lists, fewest) in [("face", &self.faces, 3), ("polyline", &self.polylines, 2)] {
            for (k, list) in lists.iter().enumerate() {
                if list.len() < fewest {
                    return Some(format!("{what} {k} has fewer than {fewest} vertices"));
                }
                if let Some(v) = list.iter().find(|&&v| v as usize >= n) {
                    return Some(format!("{what} {k} uses vertex {v}, but there are only {n} vertices"));
                }
            }
        }
        if self
            .vertex_colors
            .as_ref()
            .is_some_and(|c| c.len() != n || !c.iter().flatten().all(|x| (0.0..=1.0).contains(x)))
        {
            return Some("vertex colours are missing or not in 0..=1".into());
        }
        self.corner_uv.as_ref().and_then(|uv| self.uv_defect(uv)).or_else(|| self.attribute_defect())
    }

    fn uv_defect(&self, uv: &[Vec<[f64; 2]>]) -> Option<String> {
        if uv.len() != self.faces.len() {
            return Some(format!("{} faces, but texture coordinates for {}", self.faces.len(), uv.len()));
        }
        let wrong = |(face, uv): (&Vec<u32>, &Vec<[f64; 2]>)| {
            !uv.is_empty() && uv.len() != face.len() || uv.iter().flatten().any(|x| !x.is_finite())
        };
        let f = self.faces.iter().zip(uv).position(wrong)?;
        Some(format!("face {f} has texture coordinates that are missing or not finite"))
    }

    fn attribute_defect(&self) -> Option<String> {
        [(&self.vertex_attributes, self.positions.len()), (&self.face_attributes, self.faces.len())]
            .into_iter()
            .find_map(|(attributes, elements)| list_defect(attributes, elements))
    }
}

/// Names that mean something else in one of the formats.
const RESERVED_NAMES: [&str; 8] = ["x", "y", "z", "red", "green", "blue", "vertex_indices", "texcoord"];

fn list_defect(attributes: &[(String, Vec<f64>)], elements: usize) -> Option<String> {
    attributes.iter().enumerate().find_map(|(k, (name, values))| {
        if name.is_empty() || name.chars().any(|c| c.is_whitespace() || c.is_control()) {
            return Some(format!("attribute name `{name}` is empty or has blanks"));
        }
        if RESERVED_NAMES.contains(&name.as_str()) || attributes[..k].iter().any(|(other, _)| other == name) {
            return Some(format!("attribute name `{name}` is taken"));
        }
        let found = values.len();
        (found != elements).then(|| format!("attribute {name} has {found} values for {elements} elements"))
    })
}

impl<S: FaceShape> From<&Mesh<S>> for SurfaceOut {
    fn from(mesh: &Mesh<S>) -> Self {
        let faces = mesh.faces().map(|f| mesh.sides(f).map(|h| mesh.origin(h).0).collect()).collect();
        Self::new(mesh.positions().values().to_vec(), faces)
    }
}

impl From<FaceSoup> for SurfaceOut {
    fn from(soup: FaceSoup) -> Self {
        Self {
            positions: soup.positions,
            faces: soup.faces,
            vertex_colors: soup.vertex_colors,
            corner_uv: soup.corner_uv,
            vertex_attributes: soup.vertex_attributes,
            face_attributes: Vec::new(),
            polylines: soup.polylines,
        }
    }
}

/// How numbers are stored where a format leaves the choice (PLY, VTU, STL).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// Little-endian binary (base64 in VTU).
    #[default]
    Binary,
    /// Decimal text.
    Ascii,
}

/// How a surface is written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// Default: the one of the path's extension.
    pub format: Option<Format>,
    /// Default: binary, which is smaller and quicker; text is easier to look into. OBJ and OFF are always text.
    pub encoding: Encoding,
}

/// Something of the surface that the format could not hold; the file is valid without it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WriteWarning {
    /// Faces were split into triangles.
    Triangulated {
        /// The format that has triangles only.
        format: Format,
        /// Number of faces that were split.
        faces: usize,
    },
    /// Coordinates were rounded to single precision.
    SinglePrecision {
        /// The format.
        format: Format,
        /// Number of vertices that moved by it.
        vertices: usize,
    },
    /// A kind of data was left out.
    Dropped {
        /// The format.
        format: Format,
        /// What it does not hold.
        what: &'static str,
    },
}

impl fmt::Display for WriteWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Triangulated { format: Format::Glb, faces } => {
                write!(f, "GLB has triangles only: {faces} faces were split, in the order of FB_ngon_encoding")
            }
            Self::Triangulated { format, faces } => {
                write!(
                    f,
                    "{format} has triangles only: {faces} faces were split; use OBJ, PLY, OFF or VTU to keep them"
                )
            }
            Self::SinglePrecision { format, vertices } => {
                write!(f, "{format} has single precision only: {vertices} vertices were rounded")
            }
            Self::Dropped { format, what } => write!(f, "{format} does not hold {what}: left out"),
        }
    }
}

/// Writes a surface in the format of the path's extension: OBJ, PLY, OFF, VTU, GLB or STL.
///
/// # Output     the file, and a warning for each kind of data that the format could not hold
/// # Errors     `UnknownOutput` and `InvalidSurface` before anything is touched; those of [`crate::write_atomically`]
/// # Guarantees OBJ, PLY, OFF and VTU read back bit for bit; see [`crate::write_atomically`]
pub fn write_surface(
    path: impl AsRef<Path>,
    surface: &SurfaceOut,
    options: &WriteOptions,
) -> Result<Vec<WriteWarning>, IoError> {
    let mut files = Batch::new();
    let warnings = stage_surface(&mut files, path, surface, options)?;
    files.commit()?;
    Ok(warnings)
}

/// As [`write_surface`], as one of several files that are put in place together.
pub fn stage_surface(
    files: &mut Batch,
    path: impl AsRef<Path>,
    surface: &SurfaceOut,
    options: &WriteOptions,
) -> Result<Vec<WriteWarning>, IoError> {
    let path = path.as_ref();
    let format = options
        .format
        .or_else(|| Format::from_path(path))
        .ok_or_else(|| IoError::UnknownOutput { path: path.to_path_buf(), expected: Format::WRITTEN })?;
    let refused = |what| IoError::InvalidSurface { path: path.to_path_buf(), what };
    if let Some(what) = surface.defect() {
        return Err(refused(what));
    }
    if !format.holds_quads() {
        fits_single_precision(surface).map_err(refused)?;
    }
    files.stage(path, |out| match format {
        Format::Obj => obj::write(surface, out),
        Format::Ply => ply::write(surface, options.encoding, out),
        Format::Off => off::write(surface, out),
        Format::Vtu => vtu::write(surface, options.encoding, out),
        Format::Glb => glb::write(surface, out),
        Format::Stl => stl::write(surface, options.encoding, out),
    })?;
    Ok(warnings(surface, format, options.encoding))
}

/// Formats of single precision would turn larger numbers into infinities.
fn fits_single_precision(surface: &SurfaceOut) -> Result<(), String> {
    match surface.positions.iter().position(|p| p.abs().max_element() > f64::from(f32::MAX)) {
        Some(v) => Err(format!("vertex {v} is too large for single precision; write OBJ, PLY, OFF or VTU")),
        None => Ok(()),
    }
}

fn warnings(surface: &SurfaceOut, format: Format, encoding: Encoding) -> Vec<WriteWarning> {
    let mut list = Vec::new();
    let split = surface.faces.iter().filter(|face| face.len() > 3).count();
    if !format.holds_quads() && split > 0 {
        list.push(WriteWarning::Triangulated { format, faces: split });
    }
    let vertices = match (format, encoding) {
        (Format::Glb, _) => glb::rounded_vertices(surface),
        (Format::Stl, Encoding::Binary) => surface.positions.iter().filter(|p| p.as_vec3().as_dvec3() != **p).count(),
        _ => 0,
    };
    if vertices > 0 {
        list.push(WriteWarning::SinglePrecision { format, vertices });
    }
    let mut left_out = |there: bool, held_by: &[Format], what| {
        if there && !held_by.contains(&format) {
            list.push(WriteWarning::Dropped { format, what });
        }
    };
    use Format::{Glb, Obj, Off, Ply, Vtu};
    left_out(surface.vertex_colors.is_some(), &[Obj, Ply, Off, Glb], "vertex colours");
    left_out(surface.corner_uv.is_some(), &[Obj, Ply], "texture coordinates");
    left_out(!surface.vertex_attributes.is_empty(), &[Ply, Vtu], "vertex attributes");
    left_out(!surface.face_attributes.is_empty(), &[Ply, Vtu], "face attributes");
    left_out(!surface.polylines.is_empty(), &[Obj, Ply, Glb], "feature polylines");
    list
}
