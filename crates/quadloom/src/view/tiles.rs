//! A tiling packed for the page: colours of the tiles, cuts with their arcs, unfolded polygons.
//!
//! In: a [`TileLayer`] and the triangles that are shown. Out: what `viewer.js` reads.
//! Holds: as many tiles as there are colours all differ; with more, tiles with a common edge differ wherever one of
//! the colours is left when their turn comes. Not: different colours where tiles touch in a point.

use super::page::{Placement, pack};
use super::scene::{Polyline, TileLayer, UnfoldedSide, UnfoldedTile};
use glam::DVec2;
use serde::Serialize;
use std::collections::BTreeMap;

/// Colours of tiles in each palette of `viewer.js`.
const COLOURS: usize = 8;
/// Tile of a triangle that is in none, and arc of a cut that is not known.
const NONE: u32 = u32::MAX;
/// What an inverse letter may bring along; the page writes it by itself.
const INVERSE: &str = "⁻¹";

/// Arrays are base64 of little-endian 32-bit numbers.
#[derive(Serialize)]
pub(super) struct PackedTiles<'a> {
    /// Tile of every triangle.
    tile: String,
    /// Number of the colour of every tile.
    colours: String,
    /// Empty or two coordinates per corner of every triangle.
    uv: String,
    /// Six coordinates per segment.
    cuts: String,
    /// Arc of every segment.
    arcs: String,
    multipoints: String,
    unfolded: Vec<PackedTile<'a>>,
}

#[derive(Serialize)]
struct PackedTile<'a> {
    name: &'a str,
    rings: Vec<Vec<PackedSide<'a>>>,
}

/// Letter, arc, and 1 if it is reversed plus 2 if it is on the boundary.
#[derive(Serialize)]
struct PackedSide<'a>(&'a str, u32, u8);

impl<'a> PackedTiles<'a> {
    /// `shown`: numbers and corners of the triangles that are in the picture.
    pub(super) fn of(layer: &'a TileLayer, place: &Placement, shown: &[(usize, [u32; 3])]) -> Self {
        // More tiles than that cannot be: a greater number is an error of the scene.
        let most = layer.tile.len().max(layer.unfolded.len());
        let tile = |face: usize| layer.tile.get(face).copied().filter(|&t| (t as usize) < most).unwrap_or(NONE);
        let faces: Vec<_> = shown.iter().map(|&(face, corners)| (tile(face), corners)).collect();
        let arcs = arc_numbers(&layer.unfolded);
        let cuts_are_arcs = arcs.cuts == layer.cuts.len();
        let arc_of = |(k, cut): (usize, &Polyline)| {
            let arc = if cuts_are_arcs { k as u32 } else { NONE };
            cut.segments().map(move |_| arc.to_le_bytes()).collect::<Vec<_>>()
        };
        let colours = colours_of(&faces, layer.unfolded.len());
        let uv = shown.iter().flat_map(|&(face, _)| layer.uv.get(face).copied().unwrap_or_default());
        Self {
            tile: pack(faces.iter().map(|(t, _)| t.to_le_bytes())),
            colours: pack(colours.iter().map(|c| c.to_le_bytes())),
            uv: if layer.uv.is_empty() { String::new() } else { pack(uv.flat_map(coordinates)) },
            cuts: place.segments(layer.cuts.iter().flat_map(|l| l.segments())),
            arcs: pack(layer.cuts.iter().enumerate().flat_map(arc_of)),
            multipoints: place.points(layer.multipoints.iter().copied()),
            unfolded: layer.unfolded.iter().map(|t| PackedTile::of(t, &arcs)).collect(),
        }
    }
}

fn coordinates(p: DVec2) -> [[u8; 4]; 2] {
    p.to_array().map(|x| if x.is_finite() { x as f32 } else { 0.0 }.to_le_bytes())
}

impl<'a> PackedTile<'a> {
    fn of(tile: &'a UnfoldedTile, arcs: &ArcNumbers) -> Self {
        let ring = |r: &'a Vec<UnfoldedSide>| r.iter().map(|side| PackedSide::of(side, arcs)).collect();
        Self { name: &tile.name, rings: tile.rings.iter().map(ring).collect() }
    }
}

impl<'a> PackedSide<'a> {
    fn of(side: &'a UnfoldedSide, arcs: &ArcNumbers) -> Self {
        let letter = side.label.strip_suffix(INVERSE).filter(|_| side.reversed).unwrap_or(&side.label);
        Self(letter, arcs.number[&side.arc], u8::from(side.reversed) + 2 * u8::from(side.border))
    }
}

/// Arcs numbered anew: cuts from 0 in their order, after them the boundary.
struct ArcNumbers {
    number: BTreeMap<u32, u32>,
    cuts: usize,
}

fn arc_numbers(tiles: &[UnfoldedTile]) -> ArcNumbers {
    let sides = || tiles.iter().flat_map(|t| &t.rings).flatten();
    let borders: BTreeMap<u32, bool> = sides().map(|s| (s.arc, s.border)).collect();
    let of = |border: bool| borders.iter().filter(move |(_, b)| **b == border).map(|(arc, _)| *arc);
    let number = of(false).chain(of(true)).zip(0..).collect();
    ArcNumbers { number, cuts: of(false).count() }
}

/// A colour for every tile, tile by tile: of the colours that no neighbour has, one that the fewest tiles have.
fn colours_of(faces: &[(u32, [u32; 3])], unfolded: usize) -> Vec<u32> {
    let named = faces.iter().filter(|(t, _)| *t != NONE).map(|(t, _)| *t as usize + 1);
    let count = named.max().unwrap_or(0).max(unfolded);
    let neighbours = neighbours(faces, count);
    let (mut colours, mut used) = (vec![NONE; count], [0_usize; COLOURS]);
    for tile in 0..count {
        let mut beside = [0_usize; COLOURS];
        let coloured = neighbours[tile].iter().map(|&t| colours[t as usize]).filter(|&c| c != NONE);
        coloured.for_each(|c| beside[c as usize] += 1);
        let colour = (0..COLOURS).min_by_key(|&c| (beside[c], used[c])).unwrap_or(0);
        used[colour] += 1;
        colours[tile] = colour as u32;
    }
    colours
}

/// The tiles with which every tile has an edge in common.
fn neighbours(faces: &[(u32, [u32; 3])], count: usize) -> Vec<Vec<u32>> {
    let sides = |&(tile, [a, b, c]): &(u32, [u32; 3])| {
        [[a, b], [b, c], [c, a]].map(|[p, q]| ([p.min(q), p.max(q)], tile)).into_iter()
    };
    let mut edges: Vec<_> = faces.iter().filter(|(t, _)| *t != NONE).flat_map(sides).collect();
    edges.sort_unstable();
    let mut pairs: Vec<_> = edges.windows(2).filter(|w| w[0].0 == w[1].0).map(|w| [w[0].1, w[1].1]).collect();
    pairs.retain(|[s, t]| s != t);
    pairs.sort_unstable();
    pairs.dedup();
    let mut neighbours = vec![Vec::new(); count];
    for [s, t] in pairs {
        neighbours[s as usize].push(t);
        neighbours[t as usize].push(s);
    }
    neighbours
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of squares of two triangles, a tile each, closed to a ring.
    fn ring(n: u32) -> Vec<(u32, [u32; 3])> {
        let at = |i: u32, j: u32| 2 * (i % n) + j;
        (0..n)
            .flat_map(|i| {
                let [a, b, c, d] = [at(i, 0), at(i + 1, 0), at(i + 1, 1), at(i, 1)];
                [(i, [a, b, c]), (i, [a, c, d])]
            })
            .collect()
    }

    #[test]
    fn neighbours_differ_and_few_tiles_all_differ() {
        for n in [3, 8, 9, 100, 101] {
            let colours = colours_of(&ring(n), 0);
            for i in 0..n as usize {
                assert_ne!(colours[i], colours[(i + 1) % n as usize]);
            }
            let mut sorted = colours.clone();
            sorted.sort_unstable();
            sorted.dedup();
            assert_eq!(sorted.len(), COLOURS.min(n as usize));
        }
    }

    #[test]
    fn arcs_are_cuts_first() {
        let side = |arc, border| UnfoldedSide { arc, border, ..UnfoldedSide::default() };
        let ring = vec![side(7, false), side(2, true), side(4, false), side(7, false)];
        let arcs = arc_numbers(&[UnfoldedTile { name: String::new(), rings: vec![ring] }]);
        assert_eq!(arcs.cuts, 2);
        assert_eq!([4, 7, 2].map(|arc| arcs.number[&arc]), [0, 1, 2]);
    }
}
