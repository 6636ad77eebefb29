//! A picture as PNG bytes.

use super::Picture;
use super::path::{Label, Path, Segment, Shape};
use super::strokes::{HALO, WEIGHT, strokes};
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke, Transform};

pub(super) fn write(picture: &Picture) -> Vec<u8> {
    let Some(mut pixels) = Pixmap::new(picture.size, picture.size) else { return Vec::new() };
    if let Some([r, g, b]) = picture.background {
        pixels.fill(Color::from_rgba8(r, g, b, 255));
    }
    for shape in picture.layers.iter().flat_map(|layer| &layer.groups).flat_map(|group| &group.shapes) {
        draw(&mut pixels, shape);
    }
    pixels.encode_png().unwrap_or_default()
}

fn draw(pixels: &mut Pixmap, shape: &Shape) {
    match shape {
        Shape::Area { path, colour, seam } => {
            if let Some(built) = built(path) {
                pixels.fill_path(&built, &paint(*colour), FillRule::EvenOdd, Transform::identity(), None);
            }
            stroke(pixels, path, *colour, *seam);
        }
        Shape::Line { path, colour, width } => stroke(pixels, path, *colour, *width),
        Shape::Label(label) => write_label(pixels, label),
    }
}

fn write_label(pixels: &mut Pixmap, label: &Label) {
    let path = strokes(label);
    if let Some(halo) = label.halo {
        stroke(pixels, &path, halo, label.size * (WEIGHT + HALO));
    }
    stroke(pixels, &path, label.colour, label.size * WEIGHT);
}

fn stroke(pixels: &mut Pixmap, path: &Path, colour: [u8; 3], width: f64) {
    let style =
        Stroke { width: width as f32, line_cap: LineCap::Round, line_join: LineJoin::Round, ..Stroke::default() };
    if let Some(built) = built(path).filter(|_| width > 0.0) {
        pixels.stroke_path(&built, &paint(colour), &style, Transform::identity(), None);
    }
}

fn paint([r, g, b]: [u8; 3]) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, 255);
    paint.anti_alias = true;
    paint
}

fn built(path: &Path) -> Option<tiny_skia::Path> {
    let mut builder = PathBuilder::new();
    for contour in path {
        builder.move_to(contour.start.x as f32, contour.start.y as f32);
        let mut at = contour.start;
        for segment in &contour.segments {
            segment.cubics(at).iter().for_each(|part| add(&mut builder, part));
            at = segment.end();
        }
        if contour.closed {
            builder.close();
        }
    }
    builder.finish()
}

fn add(builder: &mut PathBuilder, segment: &Segment) {
    let [to, a, b] = match *segment {
        Segment::Line(to) | Segment::Arc { to, .. } => return builder.line_to(to.x as f32, to.y as f32),
        Segment::Cubic(a, b, to) => [to, a, b].map(|p| p.as_vec2()),
    };
    builder.cubic_to(a.x, a.y, b.x, b.y, to.x, to.y);
}
