//! Draws a map flat: `flat_map R3.1\' klein.svg centre=vertex numbers`.
//!
//! In: one of a few names, or a presentation as in "R^3, S^7, (R*S^-2)^4", with ' for the dual; a path that ends in .svg
//! or .png; words for options: centre=face|vertex|edge, pieces=triangles|faces|vertices,
//! model=poincare|klein|jemisphere, colours=face|vertex|edge|triangle|petrie|none, size=N, petrie=N, and numbers, dual,
//! triangles, noedges, noboundary. Out: the picture.

use quadloom_regular_maps::colouring::Colouring;
use quadloom_regular_maps::tiling::{Centre, FlatTiling, LayoutOptions, Model, Picture, PictureOptions, Pieces};
use quadloom_regular_maps::{CosetLimit, Presentation, RegularMap};
use std::error::Error;

const NAMES: [(&str, &str); 11] = [
    ("tetrahedron", "R^3, S^3"),
    ("cube", "R^4, S^3"),
    ("dodecahedron", "R^5, S^3"),
    ("half-icosahedron", "R^3, S^5, (R*T*S)^5"),
    ("torus", "R^4, S^4, (R*S^-1)^3"),
    ("hexagons", "R^6, S^3, (R*S^-1*R)^4"),
    ("R2.1", "R^3, S^8, R*S*R^2*S*R^2*S^2*R^2*S*R^2*S*R^-1"),
    ("R2.4", "R^5, S^10, R*S*R^2*S*R^-1"),
    ("R3.1", "R^3, S^7, (R*S^-2)^4"),
    ("R5.1", "R^3, S^8, R*S*R^2*S^2*R^2*S*R^2*S*R^2*S^2*R^2*S*R^-1"),
    ("R13.2", "R^3, S^12, R*S*R^2*S*R^2*S^3*R^2*S*R^2*S^2*R^-1"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, path, words @ ..] = arguments.as_slice() else {
        return Err("usage: flat_map NAME-or-presentation OUT.svg|OUT.png [option…]".into());
    };
    let (mut layout, mut picture) = (LayoutOptions::default(), PictureOptions::default());
    for word in words {
        set(&mut layout, &mut picture, word)?;
    }
    let tiling = FlatTiling::layout_with(&map(name)?, &layout)?;
    if let Some(defect) = tiling.check().into_iter().next() {
        return Err(defect.into());
    }
    let picture = Picture::new(&tiling, &picture);
    let bytes = if path.ends_with(".png") { picture.to_png() } else { picture.to_svg().into_bytes() };
    Ok(std::fs::write(path, bytes)?)
}

fn map(name: &str) -> Result<RegularMap, Box<dyn Error>> {
    let plain = name.trim_end_matches('\'');
    let text = NAMES.iter().find(|(known, _)| *known == plain).map_or(plain, |(_, text)| text);
    let map = RegularMap::from_presentation(&Presentation::parse(text)?, CosetLimit::default())?;
    Ok(if plain == name { map } else { map.dual() })
}

fn set(layout: &mut LayoutOptions, picture: &mut PictureOptions, word: &str) -> Result<(), Box<dyn Error>> {
    match word.split_once('=').unwrap_or((word, "")) {
        ("centre", "face") => layout.centre = Centre::Face,
        ("centre", "vertex") => layout.centre = Centre::Vertex,
        ("centre", "edge") => layout.centre = Centre::Edge,
        ("pieces", "triangles") => layout.pieces = Pieces::Triangles,
        ("pieces", "faces") => layout.pieces = Pieces::Faces,
        ("pieces", "vertices") => layout.pieces = Pieces::Vertices,
        ("model", "poincare") => picture.model = Model::Poincare,
        ("model", "klein") => picture.model = Model::Klein,
        ("model", "jemisphere") => picture.model = Model::Jemisphere,
        ("colours", "face") => picture.colouring = Some(Colouring::Face),
        ("colours", "vertex") => picture.colouring = Some(Colouring::Vertex),
        ("colours", "edge") => picture.colouring = Some(Colouring::Edge),
        ("colours", "triangle") => picture.colouring = Some(Colouring::Triangle),
        ("colours", "petrie") => picture.colouring = Some(Colouring::Petrie),
        ("colours", "none") => picture.colouring = None,
        ("size", size) => picture.size = size.parse()?,
        ("petrie", polygon) => picture.petrie = Some(polygon.parse()?),
        ("numbers", "") => picture.face_numbers = true,
        ("dual", "") => picture.dual_edges = true,
        ("triangles", "") => picture.triangles = true,
        ("noedges", "") => picture.edges = false,
        ("noboundary", "") => picture.boundary = false,
        _ => return Err(format!("{word:?} is no option").into()),
    }
    Ok(())
}
