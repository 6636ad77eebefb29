//! Distances, lines and paths as files.
//!
//! In: a [`DistanceResult`]. Out: files that are staged. Holds: rows and vertices are in the order of the input; what no
//! source reaches is `inf` with no source in text, NaN in formats with attributes.

use super::{Curve, DistanceResult, Fine};
use crate::error::RemeshError;
use quadloom_io::{Batch, Format, IoError, SurfaceOut, WriteOptions, stage_surface};
use quadloom_mesh::{DVec3, FaceSoup, VertexId};
use std::io::Write;
use std::path::Path;

/// Extensions of files of distances, for messages.
pub const EXPECTED: &str = ".ply, .vtu, .obj or .csv";
/// Bands of colour over the largest distance, so that equal steps of distance can be counted.
const BANDS: f64 = 20.0;

/// Adds distances to the files to be written.
///
/// # Input      soup: the input, whose vertices and faces are written; the extension says how:
/// `.csv` with header `vertex,distance,source`; `.ply` and `.vtu` with attributes `distance` and `source`; `.obj` with
/// colours of vertices
/// # Errors     every error of writing; another extension
pub fn stage_distances(
    files: &mut Batch,
    path: &Path,
    soup: FaceSoup,
    result: &DistanceResult,
) -> Result<(), RemeshError> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    if extension.as_deref() == Some("csv") {
        return Ok(files.stage(path, |out| write_csv(out, result))?);
    }
    let format = Format::from_path(path).filter(|f| matches!(f, Format::Ply | Format::Vtu | Format::Obj));
    let Some(format) = format else {
        return Err(IoError::UnknownOutput { path: path.to_path_buf(), expected: EXPECTED }.into());
    };
    if let Some(fine) = result.fine.as_ref().filter(|fine| fine.report.is_some()) {
        return stage_refined(files, path, format, soup, result, fine);
    }
    let value = |v: usize| result.vertex_of_input[v].map(|v| result.distance[v]).filter(|d| d.is_finite());
    let source = |v: usize| result.vertex_of_input[v].and_then(|v| result.source[v]).map_or(f64::NAN, f64::from);
    let all = 0..soup.positions.len();
    let mut surface = SurfaceOut::new(soup.positions, soup.faces);
    if format == Format::Obj {
        let largest = result.report.largest_distance;
        surface.vertex_colors = Some(all.map(|v| color(value(v), largest)).collect());
    } else {
        let distances = all.clone().map(|v| value(v).unwrap_or(f64::NAN)).collect();
        surface.vertex_attributes = vec![("distance".into(), distances), ("source".into(), all.map(source).collect())];
    }
    stage_surface(files, path, &surface, &WriteOptions::default())?;
    Ok(())
}

/// Adds a refined mesh: the vertices of the input in their order, then the new ones.
fn stage_refined(
    files: &mut Batch,
    path: &Path,
    format: Format,
    soup: FaceSoup,
    result: &DistanceResult,
    fine: &Fine,
) -> Result<(), RemeshError> {
    // 1. Numbers.
    let mut positions = soup.positions;
    let mut number = vec![u32::MAX; fine.mesh.vertex_count()];
    let mut vertex: Vec<Option<VertexId>> = result.vertex_of_input.clone();
    for (i, v) in result.vertex_of_input.iter().enumerate() {
        if let Some(v) = v.filter(|v| number[v.index()] == u32::MAX) {
            number[v.index()] = i as u32;
        }
    }
    for v in fine.mesh.vertices().filter(|v| number[v.index()] == u32::MAX).collect::<Vec<_>>() {
        number[v.index()] = positions.len() as u32;
        positions.push(fine.mesh.position(v));
        vertex.push(Some(v));
    }
    // 2. Values.
    let faces = fine.mesh.to_faces().iter().map(|f| f.map(|v| number[v as usize]).to_vec()).collect();
    let distance = |v: &Option<VertexId>| v.map(|v| fine.distance[v]).filter(|d| d.is_finite());
    let source = |v: &Option<VertexId>| v.and_then(|v| fine.source[v]).map_or(f64::NAN, f64::from);
    let mut surface = SurfaceOut::new(positions, faces);
    if format == Format::Obj {
        let largest = result.report.largest_distance;
        surface.vertex_colors = Some(vertex.iter().map(|v| color(distance(v), largest)).collect());
    } else {
        let distances = vertex.iter().map(|v| distance(v).unwrap_or(f64::NAN)).collect();
        let sources = vertex.iter().map(source).collect();
        surface.vertex_attributes = vec![("distance".into(), distances), ("source".into(), sources)];
    }
    stage_surface(files, path, &surface, &WriteOptions::default())?;
    Ok(())
}

fn write_csv(out: &mut dyn Write, result: &DistanceResult) -> std::io::Result<()> {
    out.write_all(b"vertex,distance,source\n")?;
    for (i, v) in result.vertex_of_input.iter().enumerate() {
        let reached = v.filter(|&v| result.distance[v].is_finite());
        match reached.and_then(|v| result.source[v].map(|s| (result.distance[v], s))) {
            Some((distance, source)) => writeln!(out, "{i},{distance},{source}")?,
            None => writeln!(out, "{i},inf,")?,
        }
    }
    Ok(())
}

/// Colour of a distance: blue near to red far, in bands; grey where no source reaches.
pub(crate) fn color(distance: Option<f64>, largest: f64) -> [f32; 3] {
    let Some(d) = distance else { return [0.5; 3] };
    let t = if largest > 0.0 { (d / largest).clamp(0.0, 1.0) } else { 0.0 };
    let dim = if (t * BANDS) as u32 % 2 == 1 { 0.78 } else { 1.0 };
    // A smooth ramp through teal and yellow; each channel stays within 0..=1.
    let ramp = |centre: f64, width: f64| (1.0 - ((t - centre) / width).powi(2)).clamp(0.0, 1.0);
    let rgb = [ramp(1.0, 0.65), ramp(0.55, 0.6), ramp(0.1, 0.5)];
    rgb.map(|x| (dim * (0.1 + 0.9 * x)) as f32)
}

/// Adds polylines to the files to be written, as an OBJ with `l` lines.
///
/// # Errors     every error of writing; no line at all
pub fn stage_lines(files: &mut Batch, path: &Path, curves: &[Curve]) -> Result<(), RemeshError> {
    Ok(files.stage(path, |out| {
        let mut first = 1usize;
        for curve in curves {
            for p in &curve.points {
                writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
            }
            let closed = curve.points.len() > 2 && curve.points.first() == curve.points.last();
            let distinct = curve.points.len() - usize::from(closed);
            // A path that begins on its source is a point.
            write!(out, "# {}\n{}", curve.value, if curve.points.len() > 1 { "l" } else { "p" })?;
            (0..distinct).try_for_each(|k| write!(out, " {}", first + k))?;
            if closed {
                write!(out, " {first}")?;
            }
            writeln!(out)?;
            first += curve.points.len();
        }
        Ok(())
    })?)
}

/// Width of a drawing, pixels.
const SVG_WIDTH: f64 = 1000.0;

/// Adds a drawing of polylines to the files to be written, as seen along the shortest side of their bounding box; of
/// closed surfaces only what faces the viewer.
///
/// # Errors     every error of writing
pub fn stage_lines_svg(files: &mut Batch, path: &Path, curves: &[Curve]) -> Result<(), RemeshError> {
    let all = || curves.iter().flat_map(|c| c.points.iter());
    let (lo, hi) = all().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    let size = if lo.x <= hi.x { (hi - lo).to_array() } else { [1.0; 3] };
    let depth = (0..3).min_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(2);
    let (across, up) = ((depth + 1) % 3, (depth + 2) % 3);
    let scale = SVG_WIDTH / size[across].max(f64::MIN_POSITIVE);
    let height = (scale * size[up]).max(1.0);
    let largest = curves.iter().map(|c| c.value).fold(0.0, f64::max);
    Ok(files.stage(path, |out| {
        writeln!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-10 -10 {:.2} {:.2}\" fill=\"none\" stroke-width=\"1.2\">",
            SVG_WIDTH + 20.0,
            height + 20.0
        )?;
        for curve in curves {
            let [r, g, b] = color(Some(curve.value), largest).map(|x| (255.0 * x) as u8);
            let seen = |k: usize| curve.normals[k].to_array()[depth] >= 0.0;
            let mut runs: Vec<Vec<usize>> = vec![Vec::new()];
            for k in 0..curve.points.len() {
                if seen(k) {
                    runs.last_mut().expect("never empty").push(k);
                } else if !runs.last().expect("never empty").is_empty() {
                    runs.push(Vec::new());
                }
            }
            for run in runs.iter().filter(|run| run.len() > 1) {
                write!(out, "<polyline stroke=\"rgb({r},{g},{b})\" points=\"")?;
                for &k in run {
                    let p = (curve.points[k] - lo).to_array();
                    write!(out, "{:.2},{:.2} ", scale * p[across], height - scale * p[up])?;
                }
                writeln!(out, "\"><title>{}</title></polyline>", curve.value)?;
            }
        }
        writeln!(out, "</svg>")
    })?)
}
