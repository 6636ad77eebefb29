//! Pictures of flat tilings, as SVG text and PNG bytes.
//!
//! In: a [`FlatTiling`] and [`PictureOptions`]. Out: a [`Picture`], which both formats only write down.
//! Holds: the same input gives the same bytes; pieces of one face are in one group; nothing depends on installed fonts.
//! Not: numbers and labels where they would be too small to read are left out.
//! Source: [Razafindrazaka2015] Fig. 9.4, 9.7, 9.8, 9.9.

mod lens;
mod lines;
mod path;
mod png;
mod scene;
mod strokes;
mod svg;

pub use path::{Contour, Group, Label, Layer, Path, Segment, Shape};

use super::{FlatTiling, Model};
use crate::colouring::Colouring;

/// What a picture shows.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureOptions {
    /// Width and height, pixels, from 16 to 16384. Default 1000.
    pub size: u32,
    /// How the plane is shown. Default: the Poincaré disc, which is stereographic projection for the sphere.
    pub model: Model,
    /// Colours of the triangles; none: white. Default: by face.
    pub colouring: Option<Colouring>,
    /// Draw edges of the map. Default true.
    pub edges: bool,
    /// Draw edges of the dual map. Default false.
    pub dual_edges: bool,
    /// Draw the sides of all triangles. Default false.
    pub triangles: bool,
    /// Draw the domain's boundary with an arrow for each edge; partners have one colour. Default true.
    pub boundary: bool,
    /// Write the boundary's labels. Default true.
    pub labels: bool,
    /// Write the faces' numbers. Default false.
    pub face_numbers: bool,
    /// Draw one Petrie polygon, by its number in [`petrie_polygons`](crate::colouring::petrie_polygons). Default none.
    pub petrie: Option<usize>,
    /// Continue the edges of the map beyond the domain in pale lines, hyperbolic and flat plane. Default true.
    pub surroundings: bool,
    /// Colour behind everything; none: transparent. Default white.
    pub background: Option<[u8; 3]>,
}

impl Default for PictureOptions {
    fn default() -> Self {
        Self {
            size: 1000,
            model: Model::default(),
            colouring: Some(Colouring::Face),
            edges: true,
            dual_edges: false,
            triangles: false,
            boundary: true,
            labels: true,
            face_numbers: false,
            petrie: None,
            surroundings: true,
            background: Some([255; 3]),
        }
    }
}

/// Layers of shapes, from back to front.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// What it shows, in words.
    pub title: String,
    /// Width and height, pixels.
    pub size: u32,
    /// Colour behind everything.
    pub background: Option<[u8; 3]>,
    /// From back to front.
    pub layers: Vec<Layer>,
}

impl Picture {
    /// The picture of a tiling.
    ///
    /// # Cost       linear in flags, and in the triangles around the domain that are large enough to be seen
    pub fn new(tiling: &FlatTiling, options: &PictureOptions) -> Self {
        scene::picture(tiling, options)
    }

    /// The picture as SVG: coordinates with two decimals, presentation attributes alone, a group
    /// `<g class="face" data-face="12">` per face.
    pub fn to_svg(&self) -> String {
        svg::write(self)
    }

    /// The picture as PNG. Only digits are written, as strokes.
    pub fn to_png(&self) -> Vec<u8> {
        png::write(self)
    }
}

/// The picture of a tiling as SVG.
pub fn svg(tiling: &FlatTiling, options: &PictureOptions) -> String {
    Picture::new(tiling, options).to_svg()
}

/// The picture of a tiling as PNG.
pub fn png(tiling: &FlatTiling, options: &PictureOptions) -> Vec<u8> {
    Picture::new(tiling, options).to_png()
}
