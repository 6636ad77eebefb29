//! What a cross field must respect: directions of faces, indices of vertices and of regions.
//!
//! In: features, strokes, prescribed indices. Out: [`FieldConstraints`].
//! Holds: at most one hard direction per face; where features disagree in a face, its longest feature edge wins.
//! Source: [Bommes2012] §8.2 (constrained faces), §8.4 (features), §8.6 (prescribed indices and index sums).

use crate::cross_field::CrossField;
use crate::curvature::SalientDirection;
use crate::error::FieldError;
use crate::transport::Transport;
use quadloom_mesh::metric::FaceFrame;
use quadloom_mesh::{DVec3, EdgeMap, FaceId, FaceMap, FeatureGraph, TriConnectivity, TriMesh, VertexId};
use std::f64::consts::FRAC_PI_2;

/// A direction that a cross should follow if that is cheap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftDirection {
    /// Angle in the face's frame, radians; any of the four directions will do.
    pub angle: f64,
    /// Weight against the squared turn across one edge, without unit. 1 bends the field as much as a neighbour does.
    pub weight: f64,
}

/// Constraints of a cross field.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldConstraints {
    /// Angle of a direction that the face's cross contains exactly, radians in the face's frame.
    pub angle: FaceMap<Option<f64>>,
    /// Directions followed in the least-squares sense; not looked at where [`FieldConstraints::angle`] is given.
    pub soft: FaceMap<Option<SoftDirection>>,
    /// Directions that cost nothing to follow: a component without any hard or soft direction is turned as a whole so
    /// that it agrees with them best, weight by weight.
    pub preferred: FaceMap<Option<SoftDirection>>,
    /// Prescribed indices of interior vertices, quarters; 0 asks for a regular vertex.
    pub indices: Vec<(VertexId, i32)>,
    /// Prescribed sums of the indices of several interior vertices, quarters.
    pub regions: Vec<(Vec<VertexId>, i32)>,
}

impl FieldConstraints {
    /// No constraint.
    pub fn none(mesh: &TriConnectivity) -> Self {
        let faces = mesh.face_count();
        Self {
            angle: FaceMap::filled(faces, None),
            soft: FaceMap::filled(faces, None),
            preferred: FaceMap::filled(faces, None),
            indices: Vec::new(),
            regions: Vec::new(),
        }
    }

    /// Both faces of every feature edge get the direction of that edge.
    ///
    /// # Output     the constraints, and the faces where feature edges disagree (the longest edge won), ascending
    pub fn from_features(
        mesh: &TriConnectivity,
        transport: &Transport,
        length: &EdgeMap<f64>,
        features: &FeatureGraph,
    ) -> (Self, Vec<FaceId>) {
        let mut constraints = Self::none(mesh);
        let mut disagreeing = Vec::new();
        for f in mesh.faces() {
            let sides = mesh.face_half_edges(f).into_iter().filter(|&h| features.is_feature(mesh.edge(h)));
            let mut longest: Option<(f64, f64)> = None;
            let mut agrees = true;
            for h in sides {
                let (long, angle) = (length[mesh.edge(h)], transport.direction(h));
                agrees &= longest.is_none_or(|(_, other)| cross_distance(angle, other) < 1e-6);
                if longest.is_none_or(|(best, _)| long > best) {
                    longest = Some((long, angle));
                }
            }
            constraints.angle[f] = longest.map(|(_, angle)| angle);
            if !agrees {
                disagreeing.push(f);
            }
        }
        (constraints, disagreeing)
    }

    /// A face's cross shall contain the projection of `direction`, as where a user's stroke crosses the face.
    ///
    /// # Errors     [`FieldError::NoDirection`] where the vector has no direction in the face
    pub fn add_direction(&mut self, mesh: &TriMesh, f: FaceId, direction: DVec3) -> Result<(), FieldError> {
        let frame = FaceFrame::of(mesh, f);
        let in_face = direction - frame.normal * direction.dot(frame.normal);
        if !direction.is_finite() || in_face.length() <= 1e-9 * direction.length() {
            return Err(FieldError::NoDirection { face: f });
        }
        self.angle[f] = Some(frame.angle_of(direction));
        Ok(())
    }

    /// Salient directions become hard (`weight` is `None`) or soft directions of the faces that have no hard one.
    ///
    /// # Source     [Bommes2012] §8.1 (hard)
    pub fn add_salient(&mut self, salient: &FaceMap<Option<SalientDirection>>, weight: Option<f64>) {
        for (f, direction) in salient.iter() {
            let Some(direction) = direction.filter(|_| self.angle[f].is_none()) else { continue };
            match weight {
                None => self.angle[f] = Some(direction.angle),
                Some(weight) => self.soft[f] = Some(SoftDirection { angle: direction.angle, weight }),
            }
        }
    }

    /// Faces with a hard direction.
    pub fn fixed_faces(&self) -> impl Iterator<Item = FaceId> + '_ {
        self.angle.iter().filter(|(_, angle)| angle.is_some()).map(|(f, _)| f)
    }

    /// Whether any index or index sum is prescribed.
    pub fn prescribes_indices(&self) -> bool {
        !self.indices.is_empty() || !self.regions.is_empty()
    }

    /// All index prescriptions as (vertices, sum in quarters): single vertices first, then regions.
    pub fn index_sums(&self) -> impl Iterator<Item = (&[VertexId], i32)> {
        let singles = self.indices.iter().map(|(v, q)| (std::slice::from_ref(v), *q));
        singles.chain(self.regions.iter().map(|(list, q)| (list.as_slice(), *q)))
    }

    /// Hard directions that the field misses, by more than `tolerance` radians, ascending.
    pub fn missed_directions(&self, field: &CrossField, tolerance: f64) -> Vec<FaceId> {
        let misses = |(f, angle): (FaceId, &Option<f64>)| {
            angle.is_some_and(|a| cross_distance(a, field.angle[f]) > tolerance).then_some(f)
        };
        self.angle.iter().filter_map(misses).collect()
    }

    /// Refuses wrong sizes, numbers that are not finite, and prescriptions where no index is defined.
    pub(crate) fn validate(&self, mesh: &TriConnectivity) -> Result<(), FieldError> {
        let expected = mesh.face_count();
        for found in [self.angle.len(), self.soft.len(), self.preferred.len()] {
            if found != expected {
                return Err(FieldError::WrongLength { expected, found });
            }
        }
        for f in mesh.faces() {
            let hard = self.angle[f].is_none_or(f64::is_finite);
            let sound = |s: SoftDirection| s.angle.is_finite() && s.weight.is_finite() && s.weight >= 0.0;
            let soft = [self.soft[f], self.preferred[f]].into_iter().all(|s| s.is_none_or(sound));
            if !hard || !soft {
                return Err(FieldError::NotFinite { face: f });
            }
        }
        for (list, _) in self.index_sums() {
            for &vertex in list {
                if vertex.index() >= mesh.vertex_count() || mesh.is_boundary_vertex(vertex) {
                    return Err(FieldError::NoInteriorVertex { vertex });
                }
            }
        }
        Ok(())
    }
}

/// Smallest angle between the lines of two crosses, radians in 0..=π/4.
pub fn cross_distance(a: f64, b: f64) -> f64 {
    let d = (a - b) / FRAC_PI_2;
    FRAC_PI_2 * (d - d.round()).abs()
}
