//! A picture as SVG text.

use super::path::{Contour, Label, Path, Segment, Shape};
use super::{Layer, Picture};
use std::fmt::Write;

pub(super) fn write(picture: &Picture) -> String {
    let size = picture.size;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {size} {size}\" width=\"{size}\" height=\"{size}\">\n\
         <title>{}</title>\n",
        escaped(&picture.title)
    );
    if let Some(colour) = picture.background {
        let _ =
            writeln!(out, "<rect class=\"background\" width=\"{size}\" height=\"{size}\" fill=\"{}\"/>", hex(colour));
    }
    picture.layers.iter().for_each(|layer| write_layer(&mut out, layer));
    out.push_str("</svg>\n");
    out
}

fn write_layer(out: &mut String, layer: &Layer) {
    let faces = layer.groups.iter().any(|group| group.face.is_some());
    // What lies over the faces must not take the pointer from them.
    let pointer = if faces { "" } else { " pointer-events=\"none\"" };
    let _ = writeln!(
        out,
        "<g class=\"{}\" fill-rule=\"evenodd\" stroke-linecap=\"round\" stroke-linejoin=\"round\"{pointer}>",
        layer.name
    );
    for group in &layer.groups {
        if let Some(face) = group.face {
            let _ = writeln!(out, "<g class=\"face\" data-face=\"{face}\">");
        }
        group.shapes.iter().for_each(|shape| write_shape(out, shape));
        if group.face.is_some() {
            out.push_str("</g>\n");
        }
    }
    out.push_str("</g>\n");
}

fn write_shape(out: &mut String, shape: &Shape) {
    match shape {
        Shape::Area { path, colour, seam } => {
            let (colour, seam) = (hex(*colour), number(*seam));
            let path = data(path);
            let _ = writeln!(out, "<path fill=\"{colour}\" stroke=\"{colour}\" stroke-width=\"{seam}\" d=\"{path}\"/>");
        }
        Shape::Line { path, colour, width } => {
            let (colour, width, path) = (hex(*colour), number(*width), data(path));
            let _ = writeln!(out, "<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" d=\"{path}\"/>");
        }
        Shape::Label(label) => write_label(out, label),
    }
}

fn write_label(out: &mut String, label: &Label) {
    let (x, y, size) = (number(label.at.x), number(label.at.y), number(label.size));
    let halo = label.halo.map_or(String::new(), |colour| {
        let width = number(label.size * super::strokes::HALO);
        format!(" stroke=\"{}\" stroke-width=\"{width}\" paint-order=\"stroke\"", hex(colour))
    });
    let _ = writeln!(
        out,
        "<text x=\"{x}\" y=\"{y}\" dy=\".36em\" font-size=\"{size}\" font-family=\"Helvetica, Arial, sans-serif\" \
         text-anchor=\"middle\" fill=\"{}\"{halo}>{}</text>",
        hex(label.colour),
        escaped(&label.text)
    );
}

fn data(path: &Path) -> String {
    path.iter().map(contour).collect()
}

fn contour(contour: &Contour) -> String {
    let mut out = format!("M{} {}", number(contour.start.x), number(contour.start.y));
    for segment in &contour.segments {
        match *segment {
            Segment::Line(to) => {
                let _ = write!(out, "L{} {}", number(to.x), number(to.y));
            }
            Segment::Arc { to, radius, large, clockwise } => {
                let (radius, large, sweep) = (number(radius), u8::from(large), u8::from(clockwise));
                let _ = write!(out, "A{radius} {radius} 0 {large} {sweep} {} {}", number(to.x), number(to.y));
            }
            Segment::Cubic(a, b, to) => {
                let numbers = [a.x, a.y, b.x, b.y, to.x, to.y].map(number);
                let _ = write!(out, "C{}", numbers.join(" "));
            }
        }
    }
    if contour.closed {
        out.push('Z');
    }
    out
}

/// Two decimals, without zeros at the end.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".into() } else { short.into() }
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!([1.0, -0.001, 12.345, 0.1, 100.0].map(number), ["1", "0", "12.35", "0.1", "100"]);
        assert_eq!((hex([0, 18, 255]), escaped("<a&b>")), ("#0012ff".into(), "&lt;a&amp;b&gt;".into()));
    }
}
