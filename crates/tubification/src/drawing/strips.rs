//! How a flag is divided into its face and strips along its edge, and how high each strip's relief is.
//!
//! In: an edge style. Out: [`Strips`]. Holds: strips are bounded by lines that are straight across neighbouring flags of
//! the same face, so that what is left of a face is again a polygon with p straight sides.

use glam::DVec3;
use quadloom_regular_maps::plane::Plane;

/// Whether a map or its dual is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Drawn {
    /// Faces are the map's faces.
    #[default]
    Map,
    /// Faces are the map's vertices.
    Dual,
}

/// How edges are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EdgeStyle {
    /// Not at all: faces meet.
    None,
    /// Flat bands of another colour. Width: share of the distance from an edge to the face's centre, below 1.
    Bands(f64),
    /// Round ridges of that width.
    Tubes(f64),
    /// Bands that stand out with steep sides: a map to be felt on a print of one colour.
    Relief(f64),
}

/// The strips of a flag, from the face's centre to its edge.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Strips {
    drawn: Drawn,
    /// Where strips end, as shares of the way from the centre to the edge, growing, the last one 1.
    ends: Vec<f64>,
    /// Height at the start of the first strip and at each end.
    heights: Vec<f64>,
}

/// Steps of a round ridge on each side.
const RIDGE_STEPS: usize = 4;
/// The steep side of a relief is this share of its band.
const STEEP: f64 = 0.25;

impl Strips {
    pub fn new(drawn: Drawn, edges: EdgeStyle) -> Self {
        let (ends, heights) = match edges {
            EdgeStyle::None => (vec![1.0], vec![0.0, 0.0]),
            EdgeStyle::Bands(width) => (vec![1.0 - width, 1.0], vec![0.0; 3]),
            EdgeStyle::Relief(width) => (vec![1.0 - width, 1.0 - (1.0 - STEEP) * width, 1.0], vec![0.0, 0.0, 1.0, 1.0]),
            EdgeStyle::Tubes(width) => {
                let angle = |k: usize| std::f64::consts::FRAC_PI_2 * k as f64 / RIDGE_STEPS as f64;
                let ends = (0..=RIDGE_STEPS).map(|k| 1.0 - width * angle(k).cos());
                let ends = ends.map(|end| if end > 1.0 - 1e-12 { 1.0 } else { end });
                (ends.collect(), std::iter::once(0.0).chain((0..=RIDGE_STEPS).map(|k| angle(k).sin())).collect())
            }
        };
        Self { drawn, ends, heights }
    }

    /// The corner of the flag about which strips are laid: the centre of a drawn face.
    fn centre(&self) -> usize {
        match self.drawn {
            Drawn::Map => 2,
            Drawn::Dual => 0,
        }
    }

    /// The polygon of each strip in the base flag.
    pub fn polygons(&self, plane: &Plane) -> Vec<Vec<DVec3>> {
        let start = self.centre();
        let to_centre = plane.to_origin(plane.corners[start]);
        let back = to_centre.inverse();
        let others = [1, 2].map(|k| to_centre * plane.corners[(start + k) % 3]);
        let scaled = |c: DVec3, s: f64| plane.normalised(back * DVec3::new(s * c.x, s * c.y, c.z));
        let mut inner = 0.0;
        let mut polygons = Vec::new();
        for &outer in &self.ends {
            let [a, b] = others;
            polygons.push(if inner == 0.0 {
                vec![plane.corners[start], scaled(a, outer), scaled(b, outer)]
            } else {
                vec![scaled(a, inner), scaled(a, outer), scaled(b, outer), scaled(b, inner)]
            });
            inner = outer;
        }
        polygons
    }

    /// Height of the relief at a point of the base flag.
    pub fn height(&self, plane: &Plane, point: DVec3) -> f64 {
        let to_centre = plane.to_origin(plane.corners[self.centre()]);
        // The edge is a straight line perpendicular to the way from the centre to the edge's midpoint.
        let [edge, at] = [plane.corners[1], point].map(|c| (to_centre * c).truncate() / (to_centre * c).z);
        let share = edge.dot(at) / edge.length_squared();
        let mut before = (0.0, self.heights[0]);
        for (&end, &height) in self.ends.iter().zip(&self.heights[1..]) {
            if share <= end {
                let t = (share - before.0) / (end - before.0);
                return before.1 + t * (height - before.1);
            }
            before = (end, height);
        }
        before.1
    }

    /// Whether a strip belongs to the edges.
    pub fn is_edge(&self, strip: u8) -> bool {
        strip > 0
    }
}
