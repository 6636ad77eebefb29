//! What a user can ask of the pipeline.
//!
//! In: nothing. Out: [`RemeshOptions`] and its parts, each with a default, a unit and a reason.
//! Holds: every default is good for any shape; [`RemeshOptions::check`] names what cannot be meant.

use crate::error::RemeshError;
use quadloom_mesh::{DVec3, FaceId, VertexId};
use serde::Serialize;

/// How large the quads are to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// About a quarter of the triangles, between 500 and 50,000: half the input's resolution along each direction.
    #[default]
    Auto,
    /// This many quads, reached within [`RemeshOptions::tolerance`].
    Quads(usize),
    /// This mean edge length, file units.
    EdgeLength(f64),
    /// This mean edge length, in mean edge lengths of the input.
    Scale(f64),
}

/// Fewest quads that [`Target::Auto`] asks for: below, shapes with many handles have no room for their singularities.
pub const AUTO_QUADS_MIN: usize = 500;
/// Most quads that [`Target::Auto`] asks for: above, a run takes minutes, which should be asked for.
pub const AUTO_QUADS_MAX: usize = 50_000;

/// How the integers of the map are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Round all at once: quickest, and more folds.
    Direct,
    /// Round the most certain ones first and solve again ([Bommes2012] §5.2).
    #[default]
    Greedy,
}

/// What sizes follow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AdaptTo {
    /// Curvature: quads are small where the surface bends, so that they stay near it ([Bommes2012] §8.3).
    #[default]
    Curvature,
    /// Local feature size: quads are small where the surface is thin or near to other parts of itself.
    FeatureSize,
}

/// What is done with a component on which no integer-grid map without folds is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fallback {
    /// Pairs of its triangles are split into quads, which is said in a warning: valid, with many irregular vertices.
    #[default]
    Split,
    /// The run ends without a result.
    Off,
}

/// A cross per face of the input.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenField {
    /// One direction of each cross; one vector per face of the input file, of any length.
    pub directions: Vec<DVec3>,
}

/// Everything that can be asked of [`crate::remesh()`].
#[derive(Clone, Debug)]
pub struct RemeshOptions {
    /// Size of the quads.
    pub target: Target,
    /// Largest relative deviation from the count asked for. Default 0.1. Smaller: up to three more map solves.
    pub tolerance: f64,
    /// Dihedral angle from which an edge is kept sharp, degrees; `None`: no edge is. Default 35, the custom of the
    /// field: smaller picks up coarse tessellation, larger loses chamfers.
    pub sharp_angle: Option<f64>,
    /// Edges to keep besides, as pairs of vertices of the input file.
    pub features: Vec<[u32; 2]>,
    /// Whether boundary curves are kept as they are. Default true; false lets the quads end near the boundary.
    pub keep_boundary: bool,
    /// How strongly sizes follow [`Self::adapt_to`]: 0 uniform, 1 fully. Default 0.
    pub adaptivity: f64,
    /// What sizes follow. Default: curvature.
    pub adapt_to: AdaptTo,
    /// How strongly quads are stretched along directions of low curvature: 0 squares, 1 fully. Default 0.
    pub anisotropy: f64,
    /// How far sizes may follow the cross field so that quads stay square, 0..=1 ([Bommes2012] §8.3, curl correction).
    /// Default 0.6: on 3holes at 3,000 quads the angles deviate by 4.1 degrees instead of 6.7, edges vary by up to half.
    pub curl_correction: f64,
    /// Name of a vertex attribute of the input whose values multiply the density of quads; `None`: none.
    pub density: Option<String>,
    /// A cross field to follow, on the faces of the input.
    pub field: Option<GivenField>,
    /// Prescribed singular vertices: numbers of the input file with their index in quarters; valence 3 is +1.
    /// None may be on a boundary; on a closed component that has some, they sum to four times its Euler characteristic.
    /// An empty list asks for none at all, as a torus can do; `None`: nothing is prescribed.
    pub singularities: Option<Vec<(u32, i32)>>,
    /// Whether other vertices may be singular besides the prescribed ones. Default false: the list is the whole one.
    pub other_singularities: bool,
    /// Pairs of vertices of the input file: a chain of quad edges is to join the irregular vertices nearest to them.
    pub ties: Vec<[u32; 2]>,
    /// Whether singular vertices are moved where that lowers the map's energy ([Bommes2012] §8.4, singularity
    /// relocation). Default false: it costs up to 150 solves of field and map for a few per cent of energy.
    pub relocate: bool,
    /// Curves to follow, as points near the surface.
    pub guides: Vec<Vec<DVec3>>,
    /// How integers are found.
    pub method: Method,
    /// What is done where no valid map is found.
    pub fallback: Fallback,
    /// Seed of everything that samples. Default 0. The result depends on it and on nothing random.
    pub seed: u64,
}

impl Default for RemeshOptions {
    fn default() -> Self {
        Self {
            target: Target::Auto,
            tolerance: 0.1,
            sharp_angle: Some(35.0),
            features: Vec::new(),
            keep_boundary: true,
            adaptivity: 0.0,
            adapt_to: AdaptTo::Curvature,
            anisotropy: 0.0,
            curl_correction: 0.6,
            density: None,
            field: None,
            singularities: None,
            other_singularities: false,
            ties: Vec::new(),
            relocate: false,
            guides: Vec::new(),
            method: Method::Greedy,
            fallback: Fallback::Split,
            seed: 0,
        }
    }
}

impl RemeshOptions {
    /// Names the first option whose value cannot be meant.
    pub fn check(&self) -> Result<(), RemeshError> {
        let in_range = |fits: bool, name, value, allowed| if fits { Ok(()) } else { Err((name, value, allowed)) };
        let above = |name, value: f64, allowed| in_range(value > 0.0 && value.is_finite(), name, value, allowed);
        let part = |name, value: f64| in_range((0.0..=1.0).contains(&value), name, value, "a number from 0 to 1");
        let checked = match self.target {
            Target::Auto => Ok(()),
            Target::Quads(n) => above("quads", n as f64, "a whole number from 1"),
            Target::EdgeLength(l) => above("edge-length", l, "a finite length above 0, in units of the file,"),
            Target::Scale(s) => above("scale", s, "a finite number above 0, in mean edge lengths of the input,"),
        };
        let percent = 100.0 * self.tolerance;
        checked
            .and(above("tolerance", percent, "a finite number of percent above 0"))
            .and(part("adaptivity", self.adaptivity))
            .and(part("anisotropy", self.anisotropy))
            .and(part("curl-correction", self.curl_correction))
            .and(self.sharp_angle.map_or(Ok(()), |a| {
                in_range(a > 0.0 && a <= 180.0, "sharp-angle", a, "a number of degrees above 0 and up to 180")
            }))
            .map_err(|(option, value, allowed)| RemeshError::Option { option, value, allowed })?;
        match self.ties.iter().find(|[a, b]| a == b) {
            Some(&[vertex, _]) => Err(RemeshError::TiedToItself(vertex)),
            None => Ok(()),
        }
    }
}

/// Most quads that can be asked for: more do not fit into the memory of ordinary machines.
pub(crate) const MOST_QUADS: usize = 20_000_000;

/// Ids that a message is about, for a viewer to highlight.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Elements {
    /// Nothing in particular.
    #[default]
    None,
    /// Vertices of the input file.
    Vertices(Vec<u32>),
    /// Faces of the input file.
    Faces(Vec<u32>),
    /// Components of the repaired input.
    Components(Vec<u32>),
}

impl Elements {
    /// Vertices by id.
    pub fn vertices(ids: impl IntoIterator<Item = VertexId>) -> Self {
        Self::Vertices(ids.into_iter().map(|v| v.0).collect())
    }

    /// Faces by id.
    pub fn faces(ids: impl IntoIterator<Item = FaceId>) -> Self {
        Self::Faces(ids.into_iter().map(|f| f.0).collect())
    }
}
