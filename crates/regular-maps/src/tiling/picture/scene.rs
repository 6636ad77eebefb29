//! What is drawn, layer by layer.
//!
//! In: a tiling and options. Out: [`Picture`].
//! Holds: a piece of a face is one area: triangles of one colour side by side are drawn as one.

use super::lens::Lens;
use super::lines::{Pen, boundary_layer, line_layer, surroundings_layer};
use super::path::{Group, Label, Layer, Shape};
use super::{Picture, PictureOptions};
use crate::colouring::{Colouring, petrie_polygons};
use crate::ids::{FlagId, FlagMap, MapFaceId};
use crate::map::Reflection;
use crate::tiling::{FlatTiling, Model, Side};
use glam::DVec2;
use quadloom_mesh::Id;
use std::collections::{BTreeSet, HashSet};

pub(super) const PAPER: [u8; 3] = [0xfb, 0xfa, 0xf7];
const WHITE: [u8; 3] = [255; 3];
const INK: [u8; 3] = [0x26, 0x2b, 0x33];
const HORIZON: [u8; 3] = [0xb9, 0xb4, 0xa9];
/// Dual edges on white; on colours they are white.
const DUAL: [u8; 3] = [0x2f, 0x6f, 0xb5];
const TRIANGLE: [u8; 3] = [0x6b, 0x71, 0x7c];
const PETRIE: [u8; 3] = [0xc2, 0x18, 0x5b];

/// Width of the line in its own colour around areas, for a picture of 1000 pixels.
const SEAM: f64 = 0.6;

/// Size of a face's number relative to the square root of its piece's area.
const NUMBER_SIZE: f64 = 0.36;

/// Largest and smallest size of a face's number, for a picture of 1000 pixels.
const NUMBER_SIZES: [f64; 2] = [4.5, 34.0];

pub(super) fn picture(tiling: &FlatTiling, options: &PictureOptions) -> Picture {
    let size = options.size.clamp(16, 16384);
    let scene = Scene::new(tiling, options, f64::from(size));
    Picture {
        title: format!("Regular map {} with {} faces", tiling.map(), tiling.map().face_count()),
        size,
        background: options.background,
        layers: scene.layers().into_iter().filter(|layer| layer.groups.iter().any(|g| !g.shapes.is_empty())).collect(),
    }
}

/// Triangles of one face side by side.
struct Piece {
    face: MapFaceId,
    class: u32,
    flags: Vec<FlagId>,
    visible: bool,
}

struct Scene<'a> {
    tiling: &'a FlatTiling,
    options: &'a PictureOptions,
    lens: Lens<'a>,
    /// A thousandth of the picture's width.
    unit: f64,
    visible: FlagMap<bool>,
    classes: FlagMap<u32>,
    colours: Vec<[u8; 3]>,
}

impl<'a> Scene<'a> {
    fn new(tiling: &'a FlatTiling, options: &'a PictureOptions, size: f64) -> Self {
        let lens = Lens::new(tiling, options.model, size);
        let (classes, colours) = match &options.colouring {
            Some(colouring) => {
                let classes = colouring.classes(tiling.map());
                (classes.of, colouring.colours(classes.count))
            }
            None => (FlagMap::filled(tiling.map().order(), 0), vec![WHITE]),
        };
        let visible = FlagMap::from_fn(tiling.map().order(), |g| lens.is_visible(tiling.middle(g)));
        Self { tiling, options, lens, unit: size / 1000.0, visible, classes, colours }
    }

    fn layers(&self) -> Vec<Layer> {
        let options = self.options;
        let mut layers = vec![self.horizon()];
        if options.surroundings && self.lens.model != Model::Jemisphere {
            layers.extend(surroundings_layer(&self.lens, self.unit));
        }
        if self.lens.shows_hidden() {
            layers.push(self.hidden());
        }
        layers.push(self.faces());
        if options.triangles {
            layers.push(self.lines("triangles", &Reflection::ALL, TRIANGLE, 0.7));
        }
        if options.dual_edges {
            let colour = if options.colouring.is_some() { WHITE } else { DUAL };
            layers.push(self.lines("dual-edges", &[Reflection::R0], colour, 2.0));
        }
        if options.edges {
            layers.push(self.lines("edges", &[Reflection::R2], INK, 2.2));
        }
        layers.extend(self.petrie());
        if options.boundary {
            layers.extend(boundary_layer(&self.lens, &self.visible, self.unit, options.labels));
        }
        if options.face_numbers {
            layers.push(self.numbers());
        }
        layers
    }

    fn horizon(&self) -> Layer {
        let path = self.lens.horizon();
        if path.is_empty() {
            return Layer::of("horizon", Vec::new());
        }
        let area = Shape::Area { path: path.clone(), colour: PAPER, seam: 0.0 };
        Layer::of("horizon", vec![area, Shape::Line { path, colour: HORIZON, width: 1.5 * self.unit }])
    }

    /// One group per face, with all its pieces.
    fn faces(&self) -> Layer {
        let mut groups: Vec<Group> = (0..self.tiling.map().face_count())
            .map(|face| Group { face: Some(MapFaceId::new(face)), shapes: Vec::new() })
            .collect();
        for piece in self.pieces(true).iter().filter(|piece| piece.visible) {
            groups[piece.face.index()].shapes.push(self.area(piece, self.colour(piece.class)));
        }
        groups.retain(|group| !group.shapes.is_empty());
        Layer { name: "faces", groups }
    }

    /// The inside of a dome, paler.
    fn hidden(&self) -> Layer {
        let pieces = self.pieces(true);
        let hidden = pieces.iter().filter(|piece| !piece.visible);
        let mut shapes: Vec<_> = hidden.map(|p| self.area(p, mixed(self.colour(p.class), PAPER, 0.6))).collect();
        if self.options.edges && !shapes.is_empty() {
            let sides = self.sides(&[Reflection::R2], false);
            let pen = Pen { colour: mixed(INK, PAPER, 0.6), width: 1.6 * self.unit };
            shapes.extend(line_layer("hidden", &self.lens, &sides, &pen).groups.into_iter().flat_map(|g| g.shapes));
        }
        Layer::of("hidden", shapes)
    }

    fn colour(&self, class: u32) -> [u8; 3] {
        self.colours.get(class as usize).copied().unwrap_or(WHITE)
    }

    fn area(&self, piece: &Piece, colour: [u8; 3]) -> Shape {
        let within: HashSet<_> = piece.flags.iter().copied().collect();
        let joined = |side: Side| {
            self.tiling.is_adjacent(side.flag, side.across) && within.contains(&self.tiling.partner(side).flag)
        };
        let outlines = self.tiling.outlines(&piece.flags, joined);
        let path = self.lens.area(&outlines, self.surrounds_infinity(piece));
        Shape::Area { path, colour, seam: SEAM * self.unit }
    }

    /// Whether a piece has all triangles around the point at infinity.
    fn surrounds_infinity(&self, piece: &Piece) -> bool {
        let map = self.tiling.map();
        let full = [2 * map.q(), 4, 2 * map.p()];
        (0..3).any(|k| {
            let far = |&&g: &&FlagId| self.lens.is_at_rim(self.tiling.corners(g)[k]);
            piece.flags.iter().filter(far).count() == full[k]
        })
    }

    /// Connected triangles of the same face and visibility; coloured: of the same colour, too.
    fn pieces(&self, coloured: bool) -> Vec<Piece> {
        let tiling = self.tiling;
        let key = |g: FlagId| (tiling.map().face(g), self.visible[g], if coloured { self.classes[g] } else { 0 });
        let mut met = FlagMap::filled(tiling.map().order(), false);
        let mut pieces = Vec::new();
        for start in tiling.map().flags() {
            if met[start] {
                continue;
            }
            met[start] = true;
            let mut flags = vec![start];
            let mut at = 0;
            while at < flags.len() {
                let from = flags[at];
                for by in Reflection::ALL.into_iter().filter(|&by| tiling.is_adjacent(from, by)) {
                    let next = tiling.map().reflect(from, by);
                    if !met[next] && key(next) == key(start) {
                        met[next] = true;
                        flags.push(next);
                    }
                }
                at += 1;
            }
            pieces.push(Piece { face: key(start).0, class: key(start).2, flags, visible: key(start).1 });
        }
        pieces
    }

    fn lines(&self, name: &'static str, across: &[Reflection], colour: [u8; 3], width: f64) -> Layer {
        line_layer(name, &self.lens, &self.sides(across, true), &Pen { colour, width: width * self.unit })
    }

    /// The sides of these kinds, those of triangles side by side once.
    fn sides(&self, kinds: &[Reflection], visible: bool) -> Vec<Side> {
        let all = self.tiling.map().flags().flat_map(|flag| kinds.iter().map(move |&across| Side { flag, across }));
        let all = all.filter(|side| self.visible[side.flag] == visible);
        all.filter(|&side| {
            let other = self.tiling.partner(side).flag;
            !self.tiling.is_adjacent(side.flag, side.across) || side.flag < other || self.visible[other] != visible
        })
        .collect()
    }

    fn petrie(&self) -> Option<Layer> {
        let polygons = petrie_polygons(self.tiling.map());
        let edges: BTreeSet<_> = polygons.get(self.options.petrie?)?.iter().copied().collect();
        let mut sides = self.sides(&[Reflection::R2], true);
        sides.retain(|side| edges.contains(&self.tiling.map().edge(side.flag)));
        let mut shapes = Vec::new();
        for (colour, width) in [(WHITE, 9.0), (PETRIE, 5.5)] {
            let pen = Pen { colour, width: width * self.unit };
            shapes.extend(line_layer("petrie", &self.lens, &sides, &pen).groups.into_iter().flat_map(|g| g.shapes));
        }
        Some(Layer::of("petrie", shapes))
    }

    /// Numbers of faces, in the middle of each piece.
    fn numbers(&self) -> Layer {
        let pieces = self.pieces(false);
        let labels = pieces.iter().filter(|piece| piece.visible).filter_map(|piece| self.number(piece));
        Layer::of("numbers", labels.map(Shape::Label).collect())
    }

    fn number(&self, piece: &Piece) -> Option<Label> {
        let [smallest, largest] = NUMBER_SIZES.map(|size| size * self.unit);
        let (at, area) = self.middle(piece);
        let size = (NUMBER_SIZE * area.sqrt()).min(largest);
        let text = piece.face.to_string();
        // Three digits are wider than a line is high.
        let size = size * (1.9 / text.len() as f64).min(1.0);
        let halo = (self.options.colouring == Some(Colouring::Triangle)).then_some(PAPER);
        (size >= smallest).then_some(Label { at, text, size, colour: INK, halo })
    }

    /// Where a piece's number goes, and about how large the piece is.
    fn middle(&self, piece: &Piece) -> (DVec2, f64) {
        let is_far = |&&g: &&FlagId| self.tiling.corners(g).iter().any(|&p| self.lens.is_at_rim(p));
        if let Some(&far) = piece.flags.iter().find(is_far) {
            let at = self.lens.pixel(self.tiling.middle(far));
            return (at, (0.2 * self.lens.scale * self.lens.rim.unwrap_or(1.0)).powi(2));
        }
        let mut total = 0.0;
        let mut weighted = DVec2::ZERO;
        for &g in &piece.flags {
            let [a, b, c] = self.tiling.corners(g).map(|p| self.lens.pixel(p));
            let area = 0.5 * (b - a).perp_dot(c - a).abs();
            total += area;
            weighted += area * (a + b + c) / 3.0;
        }
        (weighted / total.max(f64::MIN_POSITIVE), total)
    }
}

/// A colour with a part of another.
pub(super) fn mixed(a: [u8; 3], b: [u8; 3], part: f64) -> [u8; 3] {
    let mix = |k: usize| (f64::from(a[k]) * (1.0 - part) + f64::from(b[k]) * part).round() as u8;
    [mix(0), mix(1), mix(2)]
}
