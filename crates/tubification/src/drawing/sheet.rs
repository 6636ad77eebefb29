//! The copies of a picture in space.
//!
//! In: a picture, how its copies are glued, where points of quarter-tubes lie. Out: [`Drawing`].
//! Holds: each vertex has a place on the smooth surface and one in the flat triangles of a grid of cells, in which triangles
//! do not overlap. Source: [Razafindrazaka2015] §9.5, Fig. 9.17.

use super::cells::Weights;
use super::glue::Glue;
use super::local::LocalPicture;
use super::slivers::Sheet;
use super::strips::Strips;
use super::{DrawError, DrawOptions, Drawing};
use glam::{DVec2, DVec3};
use quadloom_mesh::{FaceMap, Id, TriMesh, VertexMap};
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::RegularMap;
use quadloom_regular_maps::matching::TubeMatch;
use rayon::prelude::*;

/// Point and outward normal.
type Place = (DVec3, DVec3);

/// What is to be placed.
pub(super) struct Copies<'a> {
    pub source: &'a RegularMap,
    pub found: &'a TubeMatch,
    pub picture: &'a LocalPicture,
    pub strips: &'a Strips,
    pub glue: &'a Glue,
}

/// The source's flag, the quarter-tube and the strip along an edge in which a triangle lies.
type Label = (FlagId, FlagId, u8);

impl Copies<'_> {
    /// The drawing on a surface.
    pub fn placed(
        &self,
        place: impl Fn(FlagId, f64, f64) -> Place + Sync,
        options: &DrawOptions,
    ) -> Result<Drawing, DrawError> {
        // 1. Where vertices lie: in flat cells, and on the smooth surface.
        let cells = Flat::new(&self.found.target, options.cells(), &place);
        let uv = |i: u32| self.picture.points[i as usize].uv;
        let flat = |&(flag, i): &(FlagId, u32)| cells.at(flag, uv(i));
        let flat: Vec<Place> = self.glue.origin.par_iter().map(flat).collect();
        let smooth = |&(flag, i): &(FlagId, u32)| place(flag, uv(i).x, uv(i).y);
        let smooth: Vec<Place> = self.glue.origin.par_iter().map(smooth).collect();
        // 2. Triangles, without slivers.
        let (labels, faces) = self.triangles();
        let (positions, normals): (Vec<DVec3>, Vec<DVec3>) = flat.iter().copied().unzip();
        let region = |&(flag, _, strip): &Label| flag.0 * u32::from(u8::MAX) + u32::from(strip);
        let regions: Vec<u32> = labels.iter().map(region).collect();
        let left = Sheet::new(&positions, &normals, &faces, &regions).without_slivers();
        let (kept, faces) = used(positions.len(), left.iter().map(|(corners, _)| *corners));
        // 3. The relief.
        let height = |k: usize| options.height * self.picture.points[self.glue.origin[k].1 as usize].height;
        let raised =
            |places: &[Place]| -> Vec<DVec3> { kept.iter().map(|&k| places[k].0 + height(k) * places[k].1).collect() };
        let label = left.iter().map(|(_, first)| labels[*first as usize]);
        Ok(Drawing {
            mesh: TriMesh::new(raised(&smooth), &faces)?,
            flat: VertexMap::from_vec(raised(&flat)),
            flag: FaceMap::from_vec(label.clone().map(|(flag, ..)| flag).collect()),
            quarter: FaceMap::from_vec(label.clone().map(|(_, quarter, _)| quarter).collect()),
            is_edge: FaceMap::from_vec(label.map(|(.., strip)| self.strips.is_edge(strip)).collect()),
            drawn: options.drawn,
        })
    }

    /// The triangles of all copies.
    fn triangles(&self) -> (Vec<Label>, Vec<[u32; 3]>) {
        let count = self.picture.triangles.len() * self.found.target.order();
        let (mut labels, mut faces) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for quarter in self.found.target.flags() {
            let image = self.source.automorphism(self.found.element[quarter]);
            for t in &self.picture.triangles {
                labels.push((image[t.flag.index()], quarter, t.strip));
                faces.push(t.corners.map(|i| self.glue.vertex(quarter, i)));
            }
        }
        (labels, faces)
    }
}

/// Vertices that triangles have, and triangles in their numbers.
fn used(count: usize, faces: impl Iterator<Item = [u32; 3]> + Clone) -> (Vec<usize>, Vec<[u32; 3]>) {
    let mut number = vec![None; count];
    faces.clone().flatten().for_each(|v| number[v as usize] = Some(0));
    let mut kept = Vec::with_capacity(count);
    for (v, new) in number.iter_mut().enumerate().filter(|(_, new)| new.is_some()) {
        *new = Some(kept.len() as u32);
        kept.push(v);
    }
    let renamed = faces.map(|t| t.map(|v| number[v as usize].unwrap_or(0))).collect();
    (kept, renamed)
}

/// The surface as flat triangles between the nodes of a grid.
struct Flat {
    cells: [usize; 2],
    nodes: Vec<(DVec3, DVec3)>,
}

impl Flat {
    fn new(
        target: &RegularMap,
        cells: [usize; 2],
        place: &(impl Fn(FlagId, f64, f64) -> (DVec3, DVec3) + Sync),
    ) -> Self {
        let [n, m] = cells;
        let node = |k: usize| {
            let (flag, at) = (FlagId::new(k / ((n + 1) * (m + 1))), k % ((n + 1) * (m + 1)));
            place(flag, (at % (n + 1)) as f64 / n as f64, (at / (n + 1)) as f64 / m as f64)
        };
        Self { cells, nodes: (0..target.order() * (n + 1) * (m + 1)).into_par_iter().map(node).collect() }
    }

    /// Point and normal.
    fn at(&self, flag: FlagId, uv: DVec2) -> (DVec3, DVec3) {
        let [n, m] = self.cells;
        let Weights { nodes, shares } = Weights::of(uv, self.cells);
        let node = |[i, j]: [usize; 2]| self.nodes[(flag.index() * (m + 1) + j) * (n + 1) + i];
        let mean = |of: fn((DVec3, DVec3)) -> DVec3| (0..3).map(|k| shares[k] * of(node(nodes[k]))).sum::<DVec3>();
        (mean(|node| node.0), mean(|node| node.1).normalize_or(DVec3::Z))
    }
}
