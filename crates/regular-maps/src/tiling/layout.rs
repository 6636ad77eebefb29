//! Places one triangle per flag, nearest first.
//!
//! In: a map and what lies at the origin. Out: [`FlatTiling`].
//! Holds: triangles are reached by reflections from those that lie already, so the domain is connected; single triangles
//! are placed together with their images under the centre's symmetries, so the domain has these symmetries.
//! Source: [Razafindrazaka2015] §9.3; the order of the search is ours.

use super::boundary::boundary_edges;
use super::element::{Element, ElementGroup};
use super::frame::Frame;
use super::{Centre, FlatPoint, FlatTiling, LayoutOptions, Pieces};
use crate::error::MapError;
use crate::ids::{FlagId, FlagMap};
use crate::map::{Reflection, RegularMap};
use crate::partition::Partition;
use crate::plane::Plane;
use glam::{DMat3, DVec3};
use quadloom_mesh::Id;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::FRAC_PI_2;

/// Distances are compared in steps of this: larger than rounding errors, smaller than differences that mean something.
const DISTANCE_STEP: f64 = 1e-6;

pub(super) fn layout(map: &RegularMap, options: &LayoutOptions) -> Result<FlatTiling, MapError> {
    if map.p() < 2 || map.q() < 2 {
        return Err(MapError::NotRegular(format!("no plane has triangles of type {{{},{}}}", map.p(), map.q())));
    }
    let plane = Plane::of_type(map.p(), map.q());
    let frame = Frame::new(&plane);
    let mut grower = Grower::new(map, &plane, &frame, options);
    grower.grow(upright(&plane, &frame, options.centre));
    let Grower { group, isometries, elements, even, order, .. } = grower;
    let (isometries, elements) = (FlagMap::from_vec(isometries), FlagMap::from_vec(elements));
    let adjacent = adjacency(map, &group, &elements);
    let (points, positions) = points(map, &plane, &frame, &isometries, &adjacent);
    let mut tiling = FlatTiling {
        map: map.clone(),
        plane,
        frame,
        options: *options,
        isometries,
        elements,
        even: FlagMap::from_vec(even),
        order,
        adjacent,
        points,
        positions,
        boundary: Vec::new(),
    };
    tiling.boundary = boundary_edges(&tiling);
    Ok(tiling)
}

/// Takes the centre to the origin and turns a corner next to it upwards, or to the right around an edge.
fn upright(plane: &Plane, frame: &Frame, centre: Centre) -> DMat3 {
    let to_origin = plane.to_origin(frame.corners[centre.corner()]);
    let (corner, wanted) = match centre {
        Centre::Face => (0, FRAC_PI_2),
        Centre::Vertex => (1, FRAC_PI_2),
        Centre::Edge => (0, 0.0),
    };
    let seen = to_origin * frame.corners[corner];
    DMat3::from_rotation_z(wanted - seen.y.atan2(seen.x)) * to_origin
}

/// Where a triangle lies.
#[derive(Clone, Copy)]
struct Placement {
    isometry: DMat3,
    element: Element,
    even: bool,
}

struct Grower<'a> {
    map: &'a RegularMap,
    plane: &'a Plane,
    frame: &'a Frame,
    group: ElementGroup,
    options: &'a LayoutOptions,
    /// The point of the frame's triangle whose distance decides.
    measured: DVec3,
    placed: Vec<bool>,
    isometries: Vec<DMat3>,
    elements: Vec<Element>,
    even: Vec<bool>,
    order: Vec<FlagId>,
    /// Distance in steps, place in the queue, index in `order` of the flag to go from, side to cross.
    queue: BinaryHeap<Reverse<(u64, usize, usize, Reflection)>>,
    queued: usize,
}

impl<'a> Grower<'a> {
    fn new(map: &'a RegularMap, plane: &'a Plane, frame: &'a Frame, options: &'a LayoutOptions) -> Self {
        let measured = match options.pieces {
            Pieces::Triangles => DVec3::Z,
            Pieces::Faces => frame.corners[2],
            Pieces::Vertices => frame.corners[0],
        };
        let n = map.order();
        Self {
            map,
            plane,
            frame,
            group: ElementGroup::of_type(map.p(), map.q()),
            options,
            measured,
            placed: vec![false; n],
            isometries: vec![DMat3::IDENTITY; n],
            elements: vec![Element::ONE; n],
            even: vec![true; n],
            order: Vec::with_capacity(n),
            queue: BinaryHeap::new(),
            queued: 0,
        }
    }

    fn grow(&mut self, start: DMat3) {
        let block = match self.options.pieces {
            Pieces::Triangles => self.options.centre.corner(),
            Pieces::Faces => Centre::Face.corner(),
            Pieces::Vertices => Centre::Vertex.corner(),
        };
        self.place_fan(FlagId(0), Placement { isometry: start, element: Element::ONE, even: true }, block);
        self.queue_sides(0);
        while let Some(Reverse((_, _, at, across))) = self.queue.pop() {
            let from = self.order[at];
            let flag = self.map.reflect(from, across);
            if self.placed[flag.index()] {
                continue;
            }
            let first = self.order.len();
            match self.options.pieces {
                Pieces::Triangles => self.place_images(at, across),
                Pieces::Faces | Pieces::Vertices => {
                    self.place_fan(flag, self.across(self.placement(from), across), block);
                }
            }
            self.queue_sides(first);
        }
    }

    fn placement(&self, flag: FlagId) -> Placement {
        let k = flag.index();
        Placement { isometry: self.isometries[k], element: self.elements[k], even: self.even[k] }
    }

    fn across(&self, from: Placement, by: Reflection) -> Placement {
        Placement {
            isometry: from.isometry * self.frame.reflection(by),
            element: self.group.times(from.element, by),
            even: !from.even,
        }
    }

    fn place(&mut self, flag: FlagId, at: Placement) {
        let k = flag.index();
        self.placed[k] = true;
        (self.isometries[k], self.elements[k], self.even[k]) = (at.isometry, at.element, at.even);
        self.order.push(flag);
    }

    /// All triangles around a corner of one, both ways in turn: all the way around a corner far away would carry the
    /// rounding errors of its far side back.
    fn place_fan(&mut self, first: FlagId, placement: Placement, corner: usize) {
        self.place(first, placement);
        let sides = around(corner);
        let mut ways = [(first, placement, 0), (first, placement, 1)];
        for k in 0.. {
            let (flag, at, side) = ways[k % 2];
            let next = self.map.reflect(flag, sides[side]);
            if self.placed[next.index()] {
                break;
            }
            let there = self.across(at, sides[side]);
            self.place(next, there);
            ways[k % 2] = (next, there, 1 - side);
        }
    }

    /// The triangle across a side of the first flag of a block, and its images under the symmetries that fix the centre,
    /// which are across the same side of the block's other flags. They move all flags, so where one is free, all are.
    fn place_images(&mut self, block: usize, by: Reflection) {
        for at in block..block + self.symmetries() {
            let from = self.order[at];
            self.place(self.map.reflect(from, by), self.across(self.placement(from), by));
        }
    }

    fn symmetries(&self) -> usize {
        match self.options.centre {
            Centre::Face => 2 * self.map.p(),
            Centre::Vertex => 2 * self.map.q(),
            Centre::Edge => 4,
        }
    }

    /// Queues what lies across the sides of the flags placed last.
    fn queue_sides(&mut self, first: usize) {
        let sides: &[Reflection] = match self.options.pieces {
            Pieces::Triangles => &Reflection::ALL,
            Pieces::Faces => &[Reflection::R2],
            Pieces::Vertices => &[Reflection::R0],
        };
        let end = if self.options.pieces == Pieces::Triangles { first + 1 } else { self.order.len() };
        for at in first..end {
            let from = self.order[at];
            for &across in sides.iter().filter(|&&across| !self.placed[self.map.reflect(from, across).index()]) {
                let isometry = self.isometries[from.index()] * self.frame.reflection(across);
                let distance = self.plane.distance(DVec3::Z, isometry * self.measured);
                let steps = (distance / DISTANCE_STEP).round() as u64;
                self.queue.push(Reverse((steps, self.queued, at, across)));
                self.queued += 1;
            }
        }
    }
}

/// The two sides that meet in a corner.
pub(super) fn around(corner: usize) -> [Reflection; 2] {
    use Reflection::{R0, R1, R2};
    [[R1, R2], [R0, R2], [R0, R1]][corner]
}

/// Which sides have their neighbour beside them: where the products along both ways are one element of the tiling's group.
///
/// Coordinates would not do everywhere: rounding errors of distances grow with e^(2d), and where whole vertices of {84, 84}
/// are placed around a face, some triangles are at d = 14.
fn adjacency(map: &RegularMap, group: &ElementGroup, elements: &FlagMap<Element>) -> FlagMap<[bool; 3]> {
    FlagMap::from_fn(map.order(), |g: FlagId| {
        Reflection::ALL.map(|by| group.times(elements[g], by) == elements[map.reflect(g, by)])
    })
}

/// Corners that triangles side by side share, each where its first triangle has it.
fn points(
    map: &RegularMap,
    plane: &Plane,
    frame: &Frame,
    isometries: &FlagMap<DMat3>,
    adjacent: &FlagMap<[bool; 3]>,
) -> (FlagMap<[FlatPoint; 3]>, Vec<DVec3>) {
    let mut sets = Partition::new(3 * map.order());
    for g in map.flags() {
        for by in Reflection::ALL.into_iter().filter(|&by| adjacent[g][by as usize]) {
            let other = map.reflect(g, by);
            for corner in (0..3).filter(|&k| k != by as usize) {
                sets.join(3 * g.index() + corner, 3 * other.index() + corner);
            }
        }
    }
    let (number, count) = sets.numbered();
    let mut positions = vec![None; count];
    for (i, &point) in number.iter().enumerate() {
        let place = || plane.normalised(isometries[FlagId(i as u32 / 3)] * frame.corners[i % 3]);
        positions[point as usize].get_or_insert_with(place);
    }
    let points = FlagMap::from_fn(map.order(), |g: FlagId| [0, 1, 2].map(|k| FlatPoint(number[3 * g.index() + k])));
    (points, positions.into_iter().flatten().collect())
}
