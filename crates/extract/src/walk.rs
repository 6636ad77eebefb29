//! Following a unit segment of the grid across the triangles.
//!
//! In: a port. Out: [`Arrival`], the port at which the grid line through it reaches the next grid point.
//! Holds: only signs of exact lattice expressions decide; a valid map always leads to the neighbouring grid point.
//! In a fold the line is followed as a level set: it runs back in triangles of opposite orientation, and reaches
//! either the next grid point or another preimage of the one it came from.
//! Source: [Ebke2013] §4.3 for the task; level-set formulation own.

use crate::grid_points::{Carrier, GridPoints};
use crate::lattice::{GridSegment, cross_direction, difference, opposite};
use crate::ports::{Ports, Site, SiteKey};
use quadloom_mesh::{ChainId, EdgeId, FaceMap, FeatureGraph, HalfEdgeId, TriMesh};
use quadloom_param::integer_grid_map::signed_area;
use quadloom_param::{IntegerGridMap, LatticePoint};

/// What a walk reads.
pub(crate) struct Walker<'a> {
    pub mesh: &'a TriMesh,
    pub map: &'a IntegerGridMap,
    pub sign: &'a FaceMap<i8>,
    pub points: &'a GridPoints,
    pub ports: &'a Ports,
    pub features: &'a FeatureGraph,
}

/// Where a walk ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Arrival {
    /// At this port of the next grid point; the feature chain that was followed all the way, if one was.
    Next(u32, Option<ChainId>),
    /// At this port of another preimage of the start, through a fold.
    Back(u32),
    /// Across the boundary of the surface.
    Outside,
    /// Nowhere: the map is degenerate here.
    Lost,
}

/// A step of the walk; the segment is kept in the chart of the half-edge's face.
#[derive(Clone, Copy, Debug)]
enum State {
    /// Starting strictly inside the face of this half-edge.
    Inside(HalfEdgeId),
    /// Entering the face of this half-edge through the interior of this side.
    Enter(HalfEdgeId),
    /// Leaving the origin of this half-edge into its sector.
    Sector(HalfEdgeId),
    /// Running along the edge of this half-edge, with it or against it.
    Along(HalfEdgeId, bool),
}

/// How the line leaves a triangle.
enum Exit {
    Side(HalfEdgeId),
    Corner(HalfEdgeId),
}

/// The part of a vertex's neighbourhood through which the line arrived.
#[derive(Clone, Copy)]
enum Came {
    FirstEdge,
    Sector,
    LastEdge,
}

/// Longer walks than any sensible map needs for one grid unit.
const STEP_LIMIT: usize = 1 << 20;

impl Walker<'_> {
    /// Follows the grid line of a port to the next grid point; adds feature edges on the way to `followed`.
    ///
    /// # Cost       the triangles and fans crossed
    pub fn walk(&self, port: u32, followed: &mut Vec<EdgeId>) -> Arrival {
        let site = self.ports.list[port as usize].site;
        let start = self.ports.start(self.mesh, self.map, self.points, port);
        let (mut segment, mut state) = self.depart(site, start, port);
        let mut chain: Option<Option<ChainId>> = None;
        for _ in 0..STEP_LIMIT {
            if let State::Along(h, _) = state {
                let e = self.mesh.edge(h);
                let here = self.features.chain_of[e];
                followed.extend(here.map(|_| e));
                chain = Some(if chain.is_none_or(|c| c == here) { here } else { None });
            } else {
                chain = Some(None);
            }
            match self.step(segment, state) {
                Ok((s, next)) => (segment, state) = (s, next),
                Err(Arrival::Next(p, _)) => return Arrival::Next(p, chain.flatten()),
                Err(end) => return end,
            }
        }
        Arrival::Lost
    }

    /// Direction in which a port leaves, in the chart of its site's half-edge.
    pub fn direction(&self, port: u32) -> u8 {
        match self.ports.list[port as usize].site {
            Site::Face { direction, .. } => direction,
            Site::Edge { half_edge, forward } => {
                let (a, b) = (self.map.uv[half_edge], self.map.uv[self.mesh.next(half_edge)]);
                let d = if forward { difference(a, b) } else { difference(b, a) };
                (0..4u8).find(|&k| cross_direction(d, k) == 0 && cross_direction(d, (k + 1) % 4) > 0).unwrap_or(0)
            }
        }
    }

    fn depart(&self, site: Site, start: LatticePoint, port: u32) -> (GridSegment, State) {
        let state = match (site, self.points.points[self.ports.list[port as usize].point as usize].carrier) {
            (Site::Edge { half_edge, forward }, _) => State::Along(half_edge, forward),
            (Site::Face { half_edge, .. }, Carrier::Vertex(_)) => State::Sector(half_edge),
            (Site::Face { half_edge, .. }, Carrier::Edge(_)) => State::Enter(half_edge),
            (Site::Face { half_edge, .. }, Carrier::Face(_)) => State::Inside(half_edge),
        };
        (GridSegment::from(start, self.direction(port)), state)
    }

    /// One triangle or edge further; `Err` holds the end of the walk.
    fn step(&self, segment: GridSegment, state: State) -> Result<(GridSegment, State), Arrival> {
        if let State::Along(h, forward) = state {
            return self.follow_edge(segment, h, forward);
        }
        let (exit, heading) = self.cross(segment, state).ok_or(Arrival::Lost)?;
        self.look_for_target(segment, &exit, heading)?;
        match exit {
            Exit::Side(h) => {
                let t = self.mesh.twin(h).ok_or(Arrival::Outside)?;
                Ok((segment.in_chart(self.map.transition[h]), State::Enter(t)))
            }
            Exit::Corner(c) => self.pass_vertex(segment, c, Came::Sector),
        }
    }

    /// Where the line leaves the triangle it is in, and whether it runs in the segment's direction (1) or back (-1).
    fn cross(&self, segment: GridSegment, state: State) -> Option<(Exit, i64)> {
        let side = |h: HalfEdgeId| segment.side(self.map.uv[h]);
        match state {
            State::Enter(t) => {
                let (a, b, apex) = (t, self.mesh.next(t), self.mesh.prev(t));
                let sign = i64::from(self.sign[self.mesh.face(t)]);
                let heading = if (side(a) > 0) == (sign >= 0) { 1 } else { -1 };
                Some(match side(apex) {
                    0 => (Exit::Corner(apex), heading),
                    s if s == side(a) => (Exit::Side(b), heading),
                    _ => (Exit::Side(apex), heading),
                })
            }
            State::Sector(c) => {
                let h = self.mesh.next(c);
                let sign = i64::from(self.sign[self.mesh.face(c)]);
                let heading = if (side(h) < 0) == (sign >= 0) { 1 } else { -1 };
                Some((Exit::Side(h), heading))
            }
            State::Inside(h) => {
                let f = self.mesh.face(h);
                let sign = i64::from(self.sign[f]);
                let sides = self.mesh.face_half_edges(f);
                let crossed = |k: &HalfEdgeId| side(*k) * sign < 0 && side(self.mesh.next(*k)) * sign > 0;
                let ahead =
                    |k: &HalfEdgeId| side(*k) == 0 && segment.along(self.map.uv[*k]) > segment.along(segment.start());
                let exit = sides.into_iter().find(crossed).map(Exit::Side);
                exit.or_else(|| sides.into_iter().find(ahead).map(Exit::Corner)).map(|e| (e, 1))
            }
            State::Along(..) => None,
        }
    }

    /// `Err` with the arrival if the grid point that the line heads for lies before or on the exit.
    fn look_for_target(&self, segment: GridSegment, exit: &Exit, heading: i64) -> Result<(), Arrival> {
        let (Exit::Side(h) | Exit::Corner(h)) = *exit;
        let f = self.mesh.face(h);
        let sign = i128::from(self.sign[f]);
        if sign == 0 {
            // The image of the line in a collapsed triangle is a point, which the previous exit has looked at.
            return Ok(());
        }
        let target = if heading > 0 { segment.target } else { segment.start() };
        // Positive: strictly before the exit; zero: at it.
        let before = match *exit {
            Exit::Side(h) => {
                (signed_area(self.map.uv[h], self.map.uv[self.mesh.next(h)], target).signum() * sign) as i64
            }
            Exit::Corner(c) => heading * (segment.along(self.map.uv[c]) - segment.along(target)),
        };
        let point = match (before, exit) {
            (b, _) if b > 0 => self.points.in_face(f, target),
            (0, Exit::Side(h)) => self.point_in_edge(*h, target),
            (0, Exit::Corner(c)) => self.points.at_vertex(self.mesh.origin(*c)),
            _ => return Ok(()),
        };
        let backwards = if heading > 0 { opposite(segment.direction) } else { segment.direction };
        Err(self.arrive(point, SiteKey::Face(f, backwards), heading))
    }

    fn point_in_edge(&self, h: HalfEdgeId, at: LatticePoint) -> Option<u32> {
        let e = self.mesh.edge(h);
        let canonical = if self.mesh.half_edge(e) == h { at } else { self.map.transition[h].apply(at) };
        self.points.in_edge(e, canonical)
    }

    fn arrive(&self, point: Option<u32>, site: SiteKey, heading: i64) -> Arrival {
        match point.and_then(|q| self.ports.at(self.mesh, q, site)) {
            Some(p) if heading > 0 => Arrival::Next(p, None),
            Some(p) => Arrival::Back(p),
            None => Arrival::Lost,
        }
    }

    /// Runs along an edge to its end, or to the grid point on the way.
    fn follow_edge(&self, segment: GridSegment, h: HalfEdgeId, forward: bool) -> Result<(GridSegment, State), Arrival> {
        let (a, b) = (h, self.mesh.next(h));
        let (from, to) = if forward { (a, b) } else { (b, a) };
        let end = segment.along(self.map.uv[to]);
        let heading = (end - segment.along(self.map.uv[from])).signum();
        let target = if heading >= 0 { segment.target } else { segment.start() };
        let point = match heading * (end - segment.along(target)) {
            d if d > 0 => self.point_in_edge(h, target),
            0 if heading != 0 => self.points.at_vertex(self.mesh.origin(to)),
            _ => {
                let came = if forward { Came::LastEdge } else { Came::FirstEdge };
                return self.pass_vertex(segment, to, came);
            }
        };
        let back = Site::Edge { half_edge: h, forward: !forward };
        Err(self.arrive(point, back.key(self.mesh), heading))
    }

    /// Continues the line through a mesh vertex: the first branch of the level set counter-clockwise of the one it
    /// came through, or, if the boundary is in the way, clockwise.
    fn pass_vertex(
        &self,
        segment: GridSegment,
        corner: HalfEdgeId,
        came: Came,
    ) -> Result<(GridSegment, State), Arrival> {
        self.turn(segment, corner, came, true)
            .or_else(|| self.turn(segment, corner, came, false))
            .ok_or(Arrival::Outside)
    }

    fn turn(&self, segment: GridSegment, corner: HalfEdgeId, came: Came, ccw: bool) -> Option<(GridSegment, State)> {
        let (mut segment, mut c) = (segment, corner);
        // Which parts of the first sector are still ahead.
        let (mut try_sector, mut try_edge) = match (came, ccw) {
            (Came::FirstEdge, true) | (Came::LastEdge, false) => (true, true),
            (Came::Sector, _) => (false, true),
            (Came::FirstEdge, false) | (Came::LastEdge, true) => (false, false),
        };
        loop {
            let (first, last) = (self.mesh.next(c), self.mesh.prev(c));
            let side = |h: HalfEdgeId| segment.side(self.map.uv[h]);
            if try_sector && side(first) * side(last) < 0 {
                return Some((segment, State::Sector(c)));
            }
            let far = if ccw { last } else { first };
            if try_edge && side(far) == 0 {
                return Some((segment, if ccw { State::Along(last, false) } else { State::Along(c, true) }));
            }
            let across = if ccw { last } else { c };
            let t = self.mesh.twin(across)?;
            segment = segment.in_chart(self.map.transition[across]);
            c = if ccw { t } else { self.mesh.next(t) };
            (try_sector, try_edge) = (true, true);
            if c == corner {
                return None;
            }
        }
    }
}
