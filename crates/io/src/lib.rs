//! Files of surfaces, cross fields, features, singularities and guides.
//!
//! In: paths. Out: plain values, in the file's own order and numbers; or an [`IoError`] with path, place and cure.
//! Holds: hostile files end in an error, never in a panic or in memory beyond a small multiple of their size.
#![warn(missing_docs)]

mod atomic;
mod curves;
mod error;
mod features;
mod fields;
mod format;
mod glb;
mod guides;
mod obj;
mod off;
mod ply;
mod singularities;
mod stl;
mod surface;
mod text;
mod triangulate;
mod vtu;

pub use atomic::{Batch, check_writable, ensure_folder, write_atomically};
pub use curves::{CurveFile, CurvePoint, read_curves};
pub use error::{ContentDefect, IoError, Place};
pub use features::{
    FeatureFile, SAME_POINT_REL, SharpSide, read_features, read_sharp, read_vertex_pairs, write_sharp,
    write_vertex_pairs,
};
pub use fields::{RawField, read_rawfield, read_rosy, stage_rawfield, stage_rosy, write_rawfield, write_rosy};
pub use format::Format;
pub use guides::{Guide, read_guides, write_guides};
pub use singularities::{Singularity, read_singularities, stage_singularities, write_singularities};
pub use surface::{
    Encoding, SurfaceOut, WriteOptions, WriteWarning, read_soup, read_text, stage_surface, write_surface,
};
