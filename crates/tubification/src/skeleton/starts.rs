//! Where relaxation starts.
//!
//! In: a map, the layout of its ropes, a seed. Out: a place for every point.
//! Holds: equal seeds give equal bytes. Source: [Razafindrazaka2015] §9.3, Fig. 9.9: the Jemisphere.

use super::ropes::Layout;
use super::{edge_flags, first_flags};
use glam::DVec3;
use quadloom_mesh::Id;
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::RegularMap;
use quadloom_regular_maps::plane::{Curvature, Plane};

/// A generator of random numbers (SplitMix64): short, and the same everywhere.
#[derive(Clone, Debug)]
pub(super) struct Random(u64);

impl Random {
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut random = Self(seed ^ stream.wrapping_mul(0xD1B5_4A32_D192_ED03));
        random.next();
        random
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Evenly in −1..1.
    pub fn signed(&mut self) -> f64 {
        (self.next() >> 11) as f64 * (2.0 / (1u64 << 53) as f64) - 1.0
    }

    /// Evenly in the unit ball.
    pub fn in_ball(&mut self) -> DVec3 {
        loop {
            let p = DVec3::new(self.signed(), self.signed(), self.signed());
            if p.length_squared() <= 1.0 {
                return p;
            }
        }
    }
}

/// Radius, in diameters, of a ball in which so many ropes have room.
pub(super) fn room(layout: &Layout) -> f64 {
    1.6 * (layout.edges as f64).cbrt() + 1.0
}

/// Vertices and middles of edges anywhere in a ball.
pub(super) fn random(layout: &Layout, random: &mut Random) -> Vec<DVec3> {
    let radius = room(layout);
    let vertices: Vec<_> = (0..layout.vertices).map(|_| random.in_ball() * radius).collect();
    let middles: Vec<_> = (0..layout.edges).map(|_| random.in_ball() * radius).collect();
    bows(layout, vertices, &middles, random)
}

/// Vertices and middles of edges on a hemisphere: each at the place nearest the pole at which the plane's tiling, laid out
/// around the pole, shows it. That is what gluing the boundary leads to, in whatever order.
pub(super) fn jemisphere(map: &RegularMap, layout: &Layout, random: &mut Random) -> Vec<DVec3> {
    let plane = Plane::of_type(map.p(), map.q());
    let radius = 1.5 * room(layout);
    let lift = |p: DVec3| match plane.curvature {
        Curvature::Hyperbolic => DVec3::new(p.x / p.z, p.y / p.z, 1.0 / p.z),
        Curvature::Flat => DVec3::new(p.x, p.y, 1.0) / (1.0 + p.x * p.x + p.y * p.y).sqrt(),
        Curvature::Spherical => p,
    };
    let places: Vec<_> = map.flags().map(|flag| plane.isometry(&map.reflections_of(flag))).collect();
    let nearest = |cell: &dyn Fn(FlagId) -> bool, corner: usize| {
        let points =
            map.flags().filter(|&flag| cell(flag)).map(|flag| lift(places[flag.index()] * plane.corners[corner]));
        let highest = points.fold(DVec3::NEG_Z * 2.0, |best, p| if p.z > best.z + 1e-9 { p } else { best });
        highest * radius
    };
    let vertices = first_flags(map).into_iter().map(|(v, _)| nearest(&|flag| map.vertex(flag) == v, 0)).collect();
    let middles: Vec<_> = edge_flags(map).into_iter().map(|(e, _)| nearest(&|flag| map.edge(flag) == e, 1)).collect();
    bows(layout, vertices, &middles, random)
}

/// Ropes from vertex to vertex over the middle, a little out of order so that no two are at the same place.
fn bows(layout: &Layout, vertices: Vec<DVec3>, middles: &[DVec3], random: &mut Random) -> Vec<DVec3> {
    let mut x = vertices;
    for (edge, &middle) in middles.iter().enumerate() {
        let [a, b] = layout.ends[edge].map(|v| x[v as usize]);
        for i in 1..=layout.inner {
            let t = i as f64 / (layout.inner + 1) as f64;
            let (low, high) = (1.0 - t, t);
            let bow = a * (low * (low - high)) + middle * (4.0 * low * high) + b * (high * (high - low));
            x.push(bow + 0.1 * random.in_ball());
        }
    }
    x
}
