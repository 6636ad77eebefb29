//! A face soup: what a mesh file says, before anything about it has been checked.
//!
//! In: a file, through the reader of its format. Out: [`FaceSoup`], which repair turns into a mesh.
//! Holds for a soup that was read: coordinates are finite and indices in range. Not: manifold, oriented, free of
//! duplicates; a face may have any number of corners (also fewer than three) and repeat a vertex.

use glam::DVec3;

/// Positions and faces as a file lists them; orders and numbers are those of the file, counted from 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceSoup {
    /// Vertex positions, file units.
    pub positions: Vec<DVec3>,
    /// Vertex numbers of each face, in order around it.
    pub faces: Vec<Vec<u32>>,
    /// Red, green, blue of each vertex, each in 0..=1; `None` where the file has no colours.
    pub vertex_colors: Option<Vec<[f32; 3]>>,
    /// Vertex numbers of each polyline; a closed one repeats its first vertex at the end.
    pub polylines: Vec<Vec<u32>>,
    /// Named scalars per vertex, in the order of the file; values may be NaN.
    pub vertex_attributes: Vec<(String, Vec<f64>)>,
    /// Texture coordinates of each corner of each face, parallel to `faces`; an unmapped face has an empty list.
    pub corner_uv: Option<Vec<Vec<[f64; 2]>>>,
}
