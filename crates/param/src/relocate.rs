//! Relocation: singular vertices move to neighbours where the map they allow has less energy.
//!
//! In: a mesh, its features, a cross field with its constraints, sizes. Out: a field of the same indices elsewhere.
//! Holds: the map's energy never rises and its folds never get more; index sums are kept; hard directions too.
//! Not: a global optimum, nor cheapness: every trial is a solve of field and map.
//! Source: [Bommes2012] §8.4, singularity relocation, with the search restricted to the neighbours that are nearest in
//! the parametrization; the order, worst first, is ours.

use crate::parametrize::{ParamError, ParamOptions, ParamReport, Parametrizer};
use crate::placed::PlacedMap;
use crate::problem::{FaceGradient, face_gradients, jacobian, orientation_energy_of};
use quadloom_field::{CrossField, FieldConstraints, FieldError, FieldMoves, SizeField, Transport};
use quadloom_mesh::{EdgeMap, FaceMap, FeatureGraph, Progress, TriMesh, VertexId, metric};

/// How far relocation goes.
#[derive(Clone, Debug, PartialEq)]
pub struct RelocationOptions {
    /// Rounds over all singular vertices. Default 3; each singularity moves by at most one edge per round.
    pub rounds: u32,
    /// Neighbours tried for each singular vertex, nearest in the map first. Default 3. More: slower, little gain, since
    /// the neighbours that the map brings near are those it would like to have in the singularity's place.
    pub neighbours: usize,
    /// Trials in all. Default 150: each costs as much as solving field and map once more.
    pub trials: usize,
    /// Relative fall of the energy from which a move is kept. Default 1e-4: smaller ones are not worth another round.
    pub least_gain: f64,
}

impl Default for RelocationOptions {
    fn default() -> Self {
        Self { rounds: 3, neighbours: 3, trials: 150, least_gain: 1e-4 }
    }
}

/// What relocation did.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct RelocationReport {
    /// Moves tried.
    pub tried: usize,
    /// Moves kept.
    pub kept: usize,
    /// Orientation energy ([Bommes2012] Eq. (8.4)) of the finished map before and after, in quads.
    pub energy: [f64; 2],
    /// Inverted triangles of the finished map before and after.
    pub inverted: [usize; 2],
}

/// Why there was nothing to compare.
#[derive(Debug, thiserror::Error)]
pub enum RelocationError {
    /// The field's constraints do not fit the mesh.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The field that was given has no map.
    #[error(transparent)]
    Map(#[from] ParamError),
}

/// Moves singular vertices of a field while the map's energy falls.
///
/// # Input      constraints: those that the field was solved under; size: that of the map
/// # Output     the field, and what was done; the same field where no move helps the finished map
/// # Errors     constraints that do not fit, a field without a map, cancellation
/// # Cost       one solve of the field and one mixed-integer solve of the map per trial
pub fn relocate(
    mesh: &TriMesh,
    features: &FeatureGraph,
    constraints: &FieldConstraints,
    field: &CrossField,
    size: &SizeField,
    options: &RelocationOptions,
    progress: &Progress,
) -> Result<(CrossField, RelocationReport), RelocationError> {
    let length = metric::edge_lengths(mesh);
    let transport = Transport::new(mesh, &length);
    let place = Site { mesh, features, length: &length, size, param: ParamOptions::default() };
    let on_feature = features.feature_vertices(mesh);
    let moves = FieldMoves::new(mesh, &transport, constraints, field)?;
    let mut report = RelocationReport::default();
    let mut best = place.state(field.clone(), progress)?;
    // 1. Local search on the rounded map.
    for _ in 0..options.rounds {
        let before = report.kept;
        for v in best.singular_worst_first(mesh, &transport) {
            if on_feature[v] {
                continue;
            }
            for w in best.nearest_neighbours(mesh, v, options.neighbours) {
                if on_feature[w] || report.tried >= options.trials {
                    continue;
                }
                progress.check().map_err(ParamError::from)?;
                let Some(other) = moves.moved(&best.field, v, w) else { continue };
                report.tried += 1;
                // A field whose map does not close is no candidate.
                let other = match place.state(other, progress) {
                    Ok(other) => other,
                    Err(ParamError::Cancelled(c)) => return Err(ParamError::Cancelled(c).into()),
                    Err(_) => continue,
                };
                if other.is_better_than(&best, options.least_gain) {
                    report.kept += 1;
                    best = other;
                    break;
                }
            }
        }
        if report.kept == before {
            break;
        }
    }
    // 2. Only the finished map counts.
    let old = place.finished(field, progress)?;
    let new = if report.kept > 0 { place.finished(&best.field, progress)? } else { old };
    report.energy = [old.0, new.0];
    report.inverted = [old.1, new.1];
    if new.0 > old.0 || new.1 > old.1 {
        report.kept = 0;
        report.energy[1] = old.0;
        report.inverted[1] = old.1;
    }
    Ok((if report.kept > 0 { best.field } else { field.clone() }, report))
}

/// Where maps are made.
struct Site<'a> {
    mesh: &'a TriMesh,
    features: &'a FeatureGraph,
    length: &'a EdgeMap<f64>,
    size: &'a SizeField,
    param: ParamOptions,
}

/// A field with its rounded map.
struct State {
    field: CrossField,
    map: PlacedMap,
    gradient: FaceMap<FaceGradient>,
    energy: f64,
    folds: usize,
}

impl Site<'_> {
    /// The map that the mixed-integer solver gives a field.
    fn state(&self, field: CrossField, progress: &Progress) -> Result<State, ParamError> {
        let mesh = self.mesh;
        let mut parametrizer = Parametrizer::new(mesh, self.features, &field)?;
        let gradient = face_gradients(mesh, self.length, &field, self.size, parametrizer.charts());
        let map = parametrizer.solve(&gradient, &self.param, &mut ParamReport::default(), progress)?;
        let energy = orientation_energy_of(mesh, &gradient, &self.param.energy, |f| map.face(mesh, f));
        let folds = map.folded_faces(mesh).len();
        Ok(State { field, map, gradient, energy, folds })
    }

    /// Energy and folds of the map after all rungs.
    fn finished(&self, field: &CrossField, progress: &Progress) -> Result<(f64, usize), ParamError> {
        let mesh = self.mesh;
        let mut parametrizer = Parametrizer::new(mesh, self.features, field)?;
        let result = parametrizer.map(self.size, &self.param, progress)?;
        let gradient = face_gradients(mesh, self.length, field, self.size, parametrizer.charts());
        let energy = orientation_energy_of(mesh, &gradient, &self.param.energy, |f| result.map.face_in_units(mesh, f));
        Ok((energy, result.inverted.len()))
    }
}

impl State {
    fn is_better_than(&self, other: &Self, least_gain: f64) -> bool {
        self.folds <= other.folds && self.energy < (1.0 - least_gain) * other.energy
    }

    /// The interior singular vertices, those with most energy around them first.
    fn singular_worst_first(&self, mesh: &TriMesh, transport: &Transport) -> Vec<VertexId> {
        let around = |v: VertexId| -> f64 {
            let of_face = |f| {
                let j = jacobian(&self.gradient[f], self.map.face(mesh, f));
                let off = [j[0][0] - 1.0, j[0][1], j[1][0], j[1][1] - 1.0];
                self.gradient[f].area * off.iter().map(|x| x * x).sum::<f64>()
            };
            mesh.outgoing(v).map(|h| of_face(mesh.face(h))).sum()
        };
        let mut all: Vec<(f64, VertexId)> =
            self.field.singularities(mesh, transport).iter().map(|&(v, _)| (around(v), v)).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        all.into_iter().map(|a| a.1).collect()
    }

    /// The neighbours of a vertex that are nearest to it in the map.
    fn nearest_neighbours(&self, mesh: &TriMesh, v: VertexId, most: usize) -> Vec<VertexId> {
        let mut all: Vec<(f64, VertexId)> = mesh
            .outgoing(v)
            .map(|h| {
                let [p, q] = [h, mesh.next(h)].map(|c| self.map.corner(mesh, c));
                let distance = (p[0] - q[0]).hypot(p[1] - q[1]);
                (distance, mesh.target(h))
            })
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        all.into_iter().take(most).map(|a| a.1).collect()
    }
}
