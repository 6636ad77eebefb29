//! Histograms of quad meshes: corner angles, edge lengths, scaled Jacobians.
//!
//! In: values, or a quad mesh and its target edge length. Out: [`Histogram`].
//! Holds: every finite value is counted exactly once, values beyond the range in its outermost bins.
//! Source: scaled Jacobian after [Knupp2000], the worst of a quad's four corners.

use glam::DVec3;
use quadloom_mesh::{EdgeId, FaceId, QuadMesh};

/// The range of a histogram and how finely it is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bins {
    /// Where the first bin begins.
    pub low: f64,
    /// Where the last bin ends.
    pub high: f64,
    /// Number of bins of equal width, at least 1.
    pub count: usize,
}

/// Counts of values in bins of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// What is counted; plain text.
    pub title: String,
    /// Written behind numbers, as `°`; may be empty.
    pub unit: String,
    /// Where the first bin begins.
    pub low: f64,
    /// Where the last bin ends.
    pub high: f64,
    /// Number of values per bin, ascending; the outermost bins also hold what lies beyond them.
    pub counts: Vec<u64>,
    /// The ideal value, marked in the diagram.
    pub mark: Option<f64>,
    /// Smallest, mean and largest value before clamping; `None` if there is no finite value.
    pub summary: Option<[f64; 3]>,
}

impl Histogram {
    /// Counts values; those that are not finite are left out.
    ///
    /// # Cost       linear
    pub fn new(title: &str, unit: &str, bins: Bins, values: impl IntoIterator<Item = f64>) -> Self {
        let mut counts = vec![0; bins.count.max(1)];
        let (mut low, mut high, mut sum) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        for x in values.into_iter().filter(|x| x.is_finite()) {
            counts[bins.bin(x)] += 1;
            (low, high, sum) = (low.min(x), high.max(x), sum + x);
        }
        let total = counts.iter().sum::<u64>();
        let summary = (total > 0).then(|| [low, sum / total as f64, high]);
        Self { title: title.into(), unit: unit.into(), low: bins.low, high: bins.high, counts, mark: None, summary }
    }

    /// The same with the ideal value marked.
    pub fn with_mark(self, mark: f64) -> Self {
        Self { mark: Some(mark), ..self }
    }
}

impl Bins {
    /// The bin of a finite value; values beyond the range belong to the outermost bins.
    fn bin(&self, x: f64) -> usize {
        let count = self.count.max(1);
        let place = (x - self.low) / (self.high - self.low) * count as f64;
        // A cast of a float saturates, and sends NaN (an empty range) to 0.
        (place as usize).min(count - 1)
    }
}

/// The three histograms of a quad mesh: corner angles (90° marked), edge lengths relative to `target_length` (1
/// marked), scaled Jacobians (1 marked).
///
/// # Input      target_length: what was aimed at, file units; without one the mean edge length takes its place
/// # Cost       linear
pub fn quad_histograms(mesh: &QuadMesh, target_length: Option<f64>) -> Vec<Histogram> {
    let length: Vec<f64> = mesh.edges().map(|e| edge_length(mesh, e)).collect();
    let mean = length.iter().sum::<f64>() / length.len().max(1) as f64;
    let (unit, name) = target_length.filter(|&l| l > 0.0).map_or((mean, "mean"), |l| (l, "target"));
    let angles = mesh.faces().flat_map(|f| corner_angles(mesh, f));
    vec![
        Histogram::new("Corner angles", "°", Bins { low: 0.0, high: 180.0, count: 60 }, angles).with_mark(90.0),
        Histogram::new(
            &format!("Edge lengths / {name}"),
            "",
            Bins { low: 0.0, high: 2.0, count: 50 },
            length.iter().map(|l| l / unit),
        )
        .with_mark(1.0),
        Histogram::new("Scaled Jacobians", "", Bins { low: 0.0, high: 1.0, count: 50 }, scaled_jacobians(mesh))
            .with_mark(1.0),
    ]
}

/// Scaled Jacobian of every quad, by face id (see [`scaled_jacobian`]).
pub fn scaled_jacobians(mesh: &QuadMesh) -> Vec<f64> {
    mesh.faces().map(|f| scaled_jacobian(corners(mesh, f))).collect()
}

/// Scaled Jacobian of a quad: the smallest sine at its corners, signed by the quad's own normal.
///
/// 1 for rectangles, 0 where a corner is flat or two corners coincide, negative where a corner is reflex.
///
/// # Input      the corners in order, file units
/// # Source     [Knupp2000]; the normal is that of the quad's diagonals
pub fn scaled_jacobian(corner: [DVec3; 4]) -> f64 {
    let normal = (corner[2] - corner[0]).cross(corner[3] - corner[1]).normalize_or_zero();
    let sine = |k: usize| {
        let (next, previous) = sides(&corner, k);
        next.cross(previous).dot(normal)
    };
    (0..4).map(sine).fold(f64::INFINITY, f64::min)
}

fn corners(mesh: &QuadMesh, f: FaceId) -> [DVec3; 4] {
    mesh.face_vertices(f).map(|v| mesh.position(v))
}

/// Unit vectors from a corner to the next one and to the previous one; zero where they coincide.
fn sides(corner: &[DVec3; 4], k: usize) -> (DVec3, DVec3) {
    let to = |j: usize| (corner[j % 4] - corner[k]).normalize_or_zero();
    (to(k + 1), to(k + 3))
}

/// Angles between the sides at each corner, degrees in 0..=180.
fn corner_angles(mesh: &QuadMesh, f: FaceId) -> [f64; 4] {
    let corner = corners(mesh, f);
    [0, 1, 2, 3].map(|k| {
        let (next, previous) = sides(&corner, k);
        next.cross(previous).length().atan2(next.dot(previous)).to_degrees()
    })
}

fn edge_length(mesh: &QuadMesh, e: EdgeId) -> f64 {
    let [a, b] = mesh.ends(e);
    mesh.position(a).distance(mesh.position(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn bins_count_what_their_borders_say(values in prop::collection::vec(-2.0..3.0f64, 0..50)) {
            let bins = Bins { low: 0.0, high: 1.0, count: 4 };
            let h = Histogram::new("", "", bins, values.iter().copied());
            let border = [f64::NEG_INFINITY, 0.25, 0.5, 0.75, f64::INFINITY];
            for k in 0..4 {
                let inside = values.iter().filter(|&&x| border[k] <= x && x < border[k + 1]).count() as u64;
                prop_assert_eq!(h.counts[k], inside);
            }
        }

        #[test]
        fn a_parallelogram_has_the_sine_of_its_angle(degrees in 1.0..179.0f64, a in 0.1..9.0f64, b in 0.1..9.0f64) {
            let (u, angle) = (DVec3::new(a, 0.0, 0.0), degrees.to_radians());
            let v = DVec3::new(b * angle.cos(), 0.0, b * angle.sin());
            let sj = scaled_jacobian([DVec3::ZERO, u, u + v, v]);
            prop_assert!((sj - angle.sin()).abs() < 1e-12);
        }
    }

    #[test]
    fn values_that_are_not_finite_are_left_out() {
        let h = Histogram::new("", "", Bins { low: 0.0, high: 1.0, count: 2 }, [f64::NAN, f64::INFINITY, 0.6]);
        assert_eq!(h.counts, [0, 1]);
        assert_eq!(h.summary, Some([0.6, 0.6, 0.6]));
        assert_eq!(Histogram::new("", "", Bins { low: 0.0, high: 0.0, count: 0 }, [0.0]).counts, [1]);
    }

    #[test]
    fn a_reflex_corner_is_negative_and_a_collapsed_one_zero() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        assert!(scaled_jacobian([p(0.0, 0.0), p(4.0, 0.0), p(1.0, 1.0), p(0.0, 4.0)]) < 0.0);
        assert_eq!(scaled_jacobian([p(0.0, 0.0), p(0.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)]), 0.0);
    }

    #[test]
    fn a_unit_cube_is_perfect() {
        let positions =
            (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))).collect();
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let cube = QuadMesh::new(positions, &faces).unwrap();
        let all = quad_histograms(&cube, Some(2.0));
        assert_eq!(all[0].summary, Some([90.0; 3]));
        assert_eq!(all[1].summary, Some([0.5; 3]));
        assert_eq!(all[2].summary, Some([1.0; 3]));
        assert_eq!(all.iter().map(|h| h.counts.iter().sum::<u64>()).collect::<Vec<_>>(), [24, 12, 6]);
        assert_eq!(quad_histograms(&cube, None)[1].summary, Some([1.0; 3]));
    }
}
