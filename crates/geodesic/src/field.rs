//! What a wavefront knows: distances, nearest sources and directions anywhere on the surface.
//!
//! In: a [`Wavefront`] that has spread with [`Keep::Windows`] (vertices: with any [`Keep`]). Out: numbers in file
//! units, points of the surface. Holds: the distance at a point is the least over all windows that look into its
//! face, over its corners, and over sources inside the face; so it is continuous and agrees with those of vertices.
//! Source: [Bommes2012] §9.

use crate::error::GeodesicError;
use crate::sources::{Cell, Root, Source, cell_of, check_point, place};
use crate::surface::IntrinsicSurface;
use crate::wavefront::{Counts, Keep, Options, Wavefront, label_of};
use crate::window::Window;
use quadloom_mesh::{EdgeId, FaceId, Progress, SurfacePoint, VertexId, VertexMap};

/// Answers questions about the last wavefront.
#[derive(Clone, Copy)]
pub struct Field<'w> {
    pub(crate) wave: &'w Wavefront<'w>,
}

/// The nearest source of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Distance, file units; infinity where no source reaches.
    pub distance: f64,
    /// Label of the source.
    pub label: Option<u32>,
    /// Unit vector away from the source, in the face's frame (x along side 0, y to its left): the distance's
    /// gradient. Zero on the source; one of several where there are several shortest paths.
    pub gradient: [f64; 2],
}

/// A window as others see it: a piece of an edge on which the distance is one function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeWindow {
    /// Where it begins and ends, as fractions from the origin of the edge's canonical half-edge.
    pub interval: [f64; 2],
    /// Whether its front is straight; else it is a circle.
    pub is_linear: bool,
    /// Whether its rays enter the face of the canonical half-edge; else they leave it.
    pub to_canonical: bool,
    /// Distances at both ends, file units.
    pub distances: [f64; 2],
    /// Label of its source.
    pub label: u32,
}

/// How a shortest path comes to a point of a face.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Via {
    /// Through side `k`, at a distance from its origin, scaled.
    Side(usize, f64),
    /// From corner `k`.
    Corner(usize),
    /// From a source inside the face, at a place of its layout.
    Source([f64; 2]),
}

/// A path to a point of a face, scaled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Approach {
    pub distance: f64,
    pub label: u32,
    /// From where it comes, in the face's layout, up to a positive factor.
    pub towards_source: [f64; 2],
    pub via: Via,
}

impl<'w> Field<'w> {
    /// Distance of every vertex, file units; infinity where no source reaches.
    pub fn vertex_distances(&self) -> VertexMap<f64> {
        let scale = self.wave.surface.scale();
        self.wave.distance.map(|d| d / scale)
    }

    /// Label of the nearest source of every vertex.
    pub fn vertex_labels(&self) -> VertexMap<Option<u32>> {
        self.wave.label.map(|&l| (l != u32::MAX).then_some(l))
    }

    /// Distance of a vertex, file units.
    pub fn vertex_distance(&self, v: VertexId) -> f64 {
        self.wave.distance[v] / self.wave.surface.scale()
    }

    /// What was done.
    pub fn counts(&self) -> Counts {
        self.wave.counts
    }

    /// Number of windows on all edges.
    pub fn window_count(&self) -> usize {
        self.wave.surface.connectivity().edges().map(|e| self.wave.lists.of(e).len()).sum()
    }

    /// The windows of an edge, ascending.
    pub fn windows(&self, e: EdgeId) -> impl Iterator<Item = EdgeWindow> + '_ {
        let (length, scale) = (self.wave.surface.length(e), self.wave.surface.scale());
        self.wave.lists.of(e).iter().map(move |w| EdgeWindow {
            interval: [w.b0 / length, w.b1 / length],
            is_linear: w.is_linear(),
            to_canonical: w.to_canonical(),
            distances: [w.b0, w.b1].map(|b| w.at(b) / scale),
            label: label_of(&self.wave.label, &self.wave.sources, w.root()),
        })
    }

    /// Distance, nearest source and gradient at a point.
    ///
    /// # Errors     a point that is none; a wavefront that kept no windows
    /// # Cost       linear in the windows of its face
    pub fn at(&self, p: &SurfacePoint) -> Result<Nearest, GeodesicError> {
        self.needs_windows()?;
        let p = check_point(self.wave.surface.connectivity(), *p, 0)?;
        let at = place(self.wave.surface.layout(p.face), p.weights);
        let Some(approach) = self.approach(p.face, at, None) else {
            return Ok(Nearest { distance: f64::INFINITY, label: None, gradient: [0.0; 2] });
        };
        let [x, y] = approach.towards_source;
        let length = x.hypot(y);
        let gradient = if length > 0.0 { [-x / length, -y / length] } else { [0.0; 2] };
        let label = (approach.label != u32::MAX).then_some(approach.label);
        Ok(Nearest { distance: approach.distance / self.wave.surface.scale(), label, gradient })
    }

    /// # Errors     windows that were forgotten
    pub(crate) fn needs_windows(&self) -> Result<(), GeodesicError> {
        match self.wave.keep {
            Keep::Windows => Ok(()),
            Keep::Vertices => Err(GeodesicError::NoWindows),
        }
    }

    /// The shortest path to a place in a face's layout that does not come through one of its sides.
    pub(crate) fn approach(&self, face: FaceId, at: [f64; 2], except: Option<usize>) -> Option<Approach> {
        self.approach_from(face, at, |k| Some(k) != except, |_| true)
    }

    /// The shortest path to a place in a face's layout through some of its sides, from some of its corners, or from
    /// sources in it.
    pub(crate) fn approach_from(
        &self,
        face: FaceId,
        at: [f64; 2],
        side: impl Fn(usize) -> bool,
        corner: impl Fn(usize) -> bool,
    ) -> Option<Approach> {
        let wave = self.wave;
        let mesh = wave.surface.connectivity();
        let layout = wave.surface.layout(face);
        let mut best: Option<Approach> = None;
        let mut offer = |a: Approach| {
            if a.distance < best.map_or(f64::INFINITY, |b| b.distance) {
                best = Some(a);
            }
        };
        // 1. Sources in the face.
        for &k in wave.roots_of(face) {
            let (root, start, label) = wave.sources.roots[k as usize];
            let from = match root {
                Root::Point(p) => wave.place_in(face, &p),
                Root::Segment(p, q) => {
                    wave.place_in(face, &p).zip(wave.place_in(face, &q)).map(|(p, q)| foot(at, p, q))
                }
            };
            if let Some(from) = from {
                let towards_source = [from[0] - at[0], from[1] - at[1]];
                let distance = start + towards_source[0].hypot(towards_source[1]);
                offer(Approach { distance, label, towards_source, via: Via::Source(from) });
            }
        }
        // 2. Corners.
        for (k, v) in mesh.face_vertices(face).into_iter().enumerate().filter(|&(k, _)| corner(k)) {
            let towards_source = [layout[k][0] - at[0], layout[k][1] - at[1]];
            let distance = wave.distance[v] + towards_source[0].hypot(towards_source[1]);
            offer(Approach { distance, label: wave.label[v], towards_source, via: Via::Corner(k) });
        }
        // 3. Windows that look into the face.
        for (k, h) in mesh.face_half_edges(face).into_iter().enumerate().filter(|&(k, _)| side(k)) {
            let e = mesh.edge(h);
            let (length, canonical) = (wave.surface.length(e), mesh.half_edge(e) == h);
            if length <= 0.0 {
                continue;
            }
            let (o, t) = (layout[k], layout[(k + 1) % 3]);
            let u = [(t[0] - o[0]) / length, (t[1] - o[1]) / length];
            let (dx, dy) = (at[0] - o[0], at[1] - o[1]);
            let p = [dx * u[0] + dy * u[1], (dy * u[0] - dx * u[1]).max(0.0)];
            for w in wave.lists.of(e).iter().filter(|w| w.to_canonical() == canonical) {
                let seen = if canonical { *w } else { w.reversed(length) };
                let (distance, x, [tx, ty]) = look(&seen, p);
                let label = label_of(&wave.label, &wave.sources, w.root());
                let towards_source = [tx * u[0] - ty * u[1], tx * u[1] + ty * u[0]];
                offer(Approach { distance, label, towards_source, via: Via::Side(k, x) });
            }
        }
        best.filter(|a| a.distance < f64::INFINITY)
    }
}

/// The path through a window to a point above its edge: distance, where it crosses the edge, direction to its source.
fn look(w: &Window, [px, py]: [f64; 2]) -> (f64, f64, [f64; 2]) {
    let ([sx, sy], sigma) = w.source();
    // 1. Straight.
    let x = if w.is_linear() {
        if sy > 0.0 { px - py * sx / sy } else { px }
    } else if sy + py > 0.0 {
        sx + (px - sx) * sy / (sy + py)
    } else {
        px
    };
    if x >= w.b0 && x <= w.b1 {
        return if w.is_linear() {
            (sigma + sx * px + sy * py, x, [-sx, -sy])
        } else {
            (sigma + (px - sx).hypot(py + sy), x, [sx - px, -sy - py])
        };
    }
    // 2. Around an end of the window, which is never shorter than through its neighbour.
    let x = x.clamp(w.b0, w.b1);
    (w.at(x) + (px - x).hypot(py), x, [x - px, -py])
}

/// The nearest point of a segment.
fn foot(at: [f64; 2], p: [f64; 2], q: [f64; 2]) -> [f64; 2] {
    let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
    let squared = dx * dx + dy * dy;
    let t = if squared > 0.0 { ((at[0] - p[0]) * dx + (at[1] - p[1]) * dy) / squared } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    [p[0] + t * dx, p[1] + t * dy]
}

impl<'a> Wavefront<'a> {
    /// Answers questions about the last wavefront.
    pub fn field(&self) -> Field<'_> {
        Field { wave: self }
    }

    /// Sources that are no vertices and lie in a face or on its sides.
    pub(crate) fn roots_of(&self, face: FaceId) -> &[u32] {
        let from = self.face_roots.partition_point(|&(f, _)| f < face);
        let to = self.face_roots.partition_point(|&(f, _)| f <= face);
        &self.root_list[from..to]
    }

    /// Where a point lies in the layout of a face, if it lies in it.
    pub(crate) fn place_in(&self, face: FaceId, p: &SurfacePoint) -> Option<[f64; 2]> {
        let mesh = self.surface.connectivity();
        let layout = self.surface.layout(face);
        if p.face == face {
            return Some(place(layout, p.weights));
        }
        let corner = |v: VertexId| mesh.face_vertices(face).into_iter().position(|u| u == v);
        match cell_of(mesh, p) {
            Cell::Inside(_) => None,
            Cell::Vertex(v) => corner(v).map(|k| layout[k]),
            Cell::Side(h) => {
                let (a, b) = (corner(mesh.origin(h))?, corner(mesh.target(h))?);
                let t = p.weights[(mesh.next(h).0 % 3) as usize];
                Some([0, 1].map(|k| (1.0 - t) * layout[a][k] + t * layout[b][k]))
            }
        }
    }
}

/// Exact distance of every vertex from sources: one call for those who need no more.
///
/// # Input      surface: connectivity and edge lengths; sources, file units
/// # Output     distance per vertex, file units; infinity where no source reaches
/// # Errors     [`GeodesicError`]
/// # Cost       as [`Wavefront::spread`]; memory of one wavefront
/// # Source     [Bommes2012] §9
pub fn vertex_distances(surface: &IntrinsicSurface, sources: &[Source]) -> Result<VertexMap<f64>, GeodesicError> {
    let mut wave = Wavefront::new(surface);
    wave.spread(sources, &Options { keep: Keep::Vertices, ..Options::default() }, &Progress::none())?;
    Ok(wave.field().vertex_distances())
}
