//! Which format a file has: by its extension, unless its content plainly says otherwise.
//!
//! In: a path and the first bytes. Out: [`Format`]. Holds: reading and writing agree on extensions, in any case.

use std::ffi::OsStr;
use std::fmt;
use std::path::Path;

/// A format of surface files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Wavefront OBJ; read and written.
    Obj,
    /// Stanford PLY, ASCII or binary; read and written.
    Ply,
    /// Object File Format of Geomview; read and written.
    Off,
    /// Stereolithography, ASCII or binary, triangles only; read and written.
    Stl,
    /// VTK unstructured grid; written.
    Vtu,
    /// Binary glTF 2.0; written.
    Glb,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Off => "OFF",
            Self::Stl => "STL",
            Self::Vtu => "VTU",
            Self::Glb => "GLB",
        })
    }
}

impl Format {
    /// Extensions of the formats that surfaces are written in, for messages.
    pub const WRITTEN: &'static str = ".obj, .ply, .off, .vtu, .glb or .stl";

    /// The format an extension stands for, in upper or lower case.
    pub fn from_path(path: &Path) -> Option<Self> {
        match path.extension().and_then(OsStr::to_str)?.to_ascii_lowercase().as_str() {
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "off" => Some(Self::Off),
            "stl" => Some(Self::Stl),
            "vtu" => Some(Self::Vtu),
            "glb" => Some(Self::Glb),
            _ => None,
        }
    }

    /// Whether its faces may have four corners.
    pub fn holds_quads(self) -> bool {
        !matches!(self, Self::Stl | Self::Glb)
    }

    /// The format in which a file is to be read.
    ///
    /// The extension decides, unless the content has the mark of another format and not that of its own.
    pub(crate) fn of_file(path: &Path, bytes: &[u8]) -> Option<Self> {
        let named = Self::from_path(path);
        match named {
            Some(format @ (Self::Ply | Self::Off | Self::Stl)) if format.marks(bytes) => named,
            _ => [Self::Ply, Self::Off, Self::Stl]
                .into_iter()
                .find(|f| f.marks(bytes))
                .or(named)
                .or_else(|| looks_like_obj(bytes).then_some(Self::Obj)),
        }
    }

    /// Whether the content begins as this format does.
    fn marks(self, bytes: &[u8]) -> bool {
        match self {
            Self::Ply => bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r"),
            Self::Off => crate::off::header(bytes).is_some(),
            Self::Stl => crate::stl::is_ascii(bytes) || crate::stl::has_binary_length(bytes),
            Self::Obj | Self::Vtu | Self::Glb => false,
        }
    }
}

/// Whether one of the first lines is a vertex.
fn looks_like_obj(bytes: &[u8]) -> bool {
    const LINES: usize = 200;
    crate::text::Lines::new(bytes).take(LINES).any(|line| {
        let mut tokens = crate::text::tokens(line.bytes);
        tokens.next() == Some(b"v") && tokens.take(3).filter_map(crate::text::number).count() == 3
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_overrules_a_wrong_extension_only_with_a_mark() {
        let of = |name: &str, bytes: &[u8]| Format::of_file(Path::new(name), bytes);
        assert_eq!(of("a.OBJ", b"v 0 0 0\n"), Some(Format::Obj));
        assert_eq!(of("a.obj", b"ply\nformat ascii 1.0\n"), Some(Format::Ply));
        assert_eq!(of("a.ply", b"COFF\n3 1 0\n"), Some(Format::Off));
        assert_eq!(of("a", b"# x\nv 0 0 0\n"), Some(Format::Obj));
        assert_eq!(of("a.xyz", b"solid x\n facet normal 0 0 1\n"), Some(Format::Stl));
        assert_eq!(of("a.ply", b"\x89PNG"), Some(Format::Ply));
        assert_eq!(of("a.png", b"\x89PNG"), None);
    }
}
