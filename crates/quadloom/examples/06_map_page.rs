//! 6. A page of a regular map: the cube's map on a round sphere beside the cube's net.
//!
//! `cargo run --release -p quadloom --example 06_map_page -- cube.html`

use quadloom::view::{MapScene, render_map_html};
use quadloom_mesh::{DVec3, TriMesh, shapes};
use std::f64::consts::FRAC_PI_4;
use std::fmt::Write as _;

/// Cells along an edge of the cube.
const STEPS: u32 = 96;
/// Cells on each side of an edge that belong to its band.
const BAND: f64 = 3.0;

fn main() -> std::io::Result<()> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "cube.html".into());
    std::fs::write(path, render_map_html(&cube_map()))
}

/// Colours of the three pairs of opposite faces.
const PALETTE: [[u8; 3]; 3] = [[233, 162, 76], [84, 140, 198], [214, 96, 99]];
const EDGE_COLOR: [u8; 3] = [246, 243, 235];

/// The map {4,3}: opposite faces share a colour.
fn cube_map() -> MapScene {
    let cube = shapes::cube(2.0, STEPS);
    let triangles = cube.to_faces();
    let middles: Vec<_> = triangles.iter().map(|&t| middle(&cube, t) - DVec3::ONE).collect();
    let face: Vec<_> = middles.iter().map(|&m| face_at(m)).collect();
    MapScene {
        title: "Cube {4,3} on the sphere".into(),
        facts: facts(),
        positions: cube.positions().values().iter().map(|&p| on_sphere(p - DVec3::ONE)).collect(),
        triangles,
        is_edge: middles.iter().map(|&m| is_edge(m)).collect(),
        class: face.iter().map(|f| f / 2).collect(),
        face,
        palette: PALETTE.to_vec(),
        edge_color: EDGE_COLOR,
        flat: net(),
    }
}

fn facts() -> Vec<(String, String)> {
    let rows = [
        ("name", "cube"),
        ("type", "{4,3}"),
        ("genus", "0"),
        ("faces", "6"),
        ("edges", "12"),
        ("vertices", "8"),
        ("symmetry", "24 rotations, 48 with mirrors"),
        ("target", "sphere"),
    ];
    rows.map(|(name, value)| (name.into(), value.into())).to_vec()
}

fn middle(mesh: &TriMesh, triangle: [u32; 3]) -> DVec3 {
    triangle.map(|v| mesh.positions().values()[v as usize]).iter().sum::<DVec3>() / 3.0
}

/// Faces by the largest coordinate: 0 and 1 look along x, 2 and 3 along y, 4 and 5 along z.
fn face_at(p: DVec3) -> u32 {
    let axis = if p.x.abs() >= p.abs().max_element() {
        0
    } else if p.y.abs() >= p.z.abs() {
        1
    } else {
        2
    };
    2 * axis + u32::from(p[axis as usize] < 0.0)
}

/// Whether a point of the cube's surface is near an edge.
fn is_edge(p: DVec3) -> bool {
    let mut sizes = p.abs().to_array();
    sizes.sort_by(f64::total_cmp);
    sizes[1] > 1.0 - 2.0 * BAND / f64::from(STEPS)
}

/// Cells of equal angle, so that they stay of similar size.
fn on_sphere(p: DVec3) -> DVec3 {
    DVec3::from_array(p.to_array().map(|x| (x * FRAC_PI_4).tan())).normalize()
}

/// The cube unfolded, in units of its faces: a row of four, one above and one below its second square.
fn net() -> String {
    let places = [(4, 0, 1), (0, 1, 1), (5, 2, 1), (1, 3, 1), (2, 1, 0), (3, 1, 2)];
    let [r, g, b] = EDGE_COLOR;
    let mut svg = String::from(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="-0.1 -0.1 4.2 3.2">"#);
    for (face, x, y) in places {
        let [p, q, s] = PALETTE[face / 2];
        let square = format!(r#"<rect x="{x}" y="{y}" width="1" height="1" fill="rgb({p},{q},{s})"/>"#);
        let band = format!(r#"stroke="rgb({r},{g},{b})" stroke-width="0.06" stroke-linejoin="round""#);
        let _ = write!(svg, r#"<g data-face="{face}" {band}>{square}</g>"#);
    }
    svg + "</svg>"
}
