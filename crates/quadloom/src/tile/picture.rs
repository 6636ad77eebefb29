//! Tiles as a picture.
//!
//! In: a [`TileResult`]. Out: a [`Scene`] for [`crate::view::render_html`]: tiles, cuts, multipoints, unfolded polygons.

use super::TileResult;
use super::output::cuts_of;
use crate::view::{Polyline, Scene, SurfaceLayer, TileLayer, UnfoldedSide, UnfoldedTile, boundary_lines};
use quadloom_tiling::{Tiling, word};

/// Everything that was cut.
pub fn scene(result: &TileResult, title: &str) -> Scene {
    let report = &result.report;
    let mut surface = SurfaceLayer::default();
    let mut layer = TileLayer::default();
    let mut boundary = Vec::new();
    let mut arcs = 0;
    for part in &result.parts {
        let tiling = &part.tiling;
        let (mesh, first) = (tiling.mesh(), surface.positions.len() as u32);
        let first_tile = layer.unfolded.len() as u32;
        surface.positions.extend(mesh.positions().values());
        surface.triangles.extend(mesh.to_faces().into_iter().map(|f| f.map(|v| v + first)));
        boundary.extend(boundary_lines(mesh));
        if let Some(uv) = &part.uv {
            layer.uv.extend(mesh.faces().map(|f| mesh.face_half_edges(f).map(|h| uv[h])));
        }
        layer.tile.extend(tiling.face_tile.values().iter().map(|t| t.0 + first_tile));
        for arc in cuts_of(tiling) {
            let points = tiling.arc_path[arc].iter().map(|&v| mesh.position(v)).collect();
            layer.cuts.push(Polyline { points, closed: false });
        }
        layer.multipoints.extend(tiling.node_vertex.values().iter().map(|&v| mesh.position(v)));
        layer.unfolded.extend(unfolded(tiling, first_tile, arcs));
        arcs += tiling.complex.arcs.len() as u32;
    }
    Scene {
        title: title.into(),
        input: Some(surface),
        boundary,
        tiles: Some(layer),
        statistics: statistics(report),
        ..Scene::default()
    }
}

fn unfolded(tiling: &Tiling, first_tile: u32, first_arc: u32) -> Vec<UnfoldedTile> {
    let letters = tiling.letters();
    let side = |s: &quadloom_tiling::Side| UnfoldedSide {
        label: word::Side { letter: letters[s.arc], inverse: s.reversed }.to_string(),
        arc: s.arc.0 + first_arc,
        reversed: s.reversed,
        border: tiling.is_border(s.arc),
    };
    let tiles = tiling.complex.cells.iter().map(|(tile, cell)| UnfoldedTile {
        name: match tiling.word(tile) {
            Some(word) => format!("tile {}: {word}", tile.0 + first_tile),
            None => format!("tile {}", tile.0 + first_tile),
        },
        rings: cell.boundaries.iter().map(|ring| ring.iter().map(side).collect()).collect(),
    });
    tiles.collect()
}

fn statistics(report: &super::TileReport) -> Vec<(String, String)> {
    let mut rows = vec![
        ("tiles".to_string(), report.tiles.to_string()),
        ("multipoints".into(), report.multipoints.to_string()),
        ("length of cuts".into(), format!("{:.6}", report.length)),
        ("Euler characteristic".into(), report.chi.to_string()),
        ("genus".into(), report.genus.to_string()),
        ("boundary loops".into(), report.boundary_loops.to_string()),
    ];
    // Words of many sides would fill the page.
    let short = |word: &&String| word.len() <= 120;
    if let Some(word) = report.word.as_ref().filter(short) {
        rows.push(("word".into(), word.clone()));
    }
    if let Some(word) = report.canonical_word.as_ref().filter(short) {
        rows.push(("canonical word".into(), word.clone()));
    }
    rows.push(("vertices added".into(), (report.vertices[1] - report.vertices[0]).to_string()));
    rows.push(("cutting".into(), format!("{:.3} s", report.seconds.cutting)));
    rows
}
