//! The report of a run: everything that was measured, as plain data.
//!
//! In: what the stages hand back. Out: [`Report`], which serialises to JSON.
//! Holds: `version` is raised whenever a field changes its meaning or goes away; numbers that do not exist are
//! `null`, never invented. Units: file units, seconds, degrees, bytes; percent where the name says so.

use crate::error::Warning;
use crate::singularities::SingularitySummary;
use crate::ties::TieReport;
use quadloom_extract::{Distances, IrregularVertices, QualitySummary};
use quadloom_mesh::Summary;
use quadloom_param::RelocationReport;
use serde::ser::{Serialize, SerializeMap, Serializer};
use std::collections::BTreeMap;
use std::time::Instant;

/// Version of the layout of [`Report`].
pub const REPORT_VERSION: u32 = 1;

/// Everything measured in a run.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Report {
    /// Version of this layout.
    pub report_version: u32,
    /// Version of the program.
    pub quadloom: &'static str,
    /// Units of the numbers below.
    pub units: Units,
    /// The input as it was read, equal positions taken for one vertex.
    pub input_as_read: AsRead,
    /// The repaired input, which the result stands for.
    pub input: SurfaceReport,
    /// Quads that face against the input; more than zero is never handed out.
    pub facing_against: usize,
    /// Quads that may face against the input, see the warning of that name.
    pub facing_unclear: usize,
    /// What repair changed, one line per kind of defect.
    pub repairs: Vec<String>,
    /// The result.
    pub output: SurfaceReport,
    /// Irregular vertices of the result.
    pub irregular: IrregularVertices,
    /// Asked and reached number of quads.
    pub count: CountReport,
    /// Feature curves.
    pub features: FeatureReport,
    /// The cross field, over all components.
    pub field: FieldSummary,
    /// The integer-grid map, over all components.
    pub map: MapSummary,
    /// The singular vertices that were given; `None` if none were.
    pub singularities: Option<SingularitySummary>,
    /// The ties that were asked for, component by component.
    pub ties: Vec<TieReport>,
    /// Relocation of singular vertices, over all components; `None` if it was not asked for.
    pub relocation: Option<RelocationReport>,
    /// Shapes of the quads.
    pub quality: QualitySummary,
    /// Distances between result and input, percent of the input's diagonal.
    pub distance: Distances,
    /// How each component was made.
    pub components: Vec<ComponentReport>,
    /// Wall-clock seconds of the run, reading and writing files not included.
    pub total_seconds: f64,
    /// Seconds of each stage, summed over components, some of which ran at the same time: their sum may be more than the
    /// total.
    pub seconds: Seconds,
    /// Largest resident memory, bytes.
    pub peak_memory_bytes: Option<u64>,
    /// What a user should know.
    pub warnings: Vec<Warning>,
}

/// Units of what is in a [`Report`], so that its reader need not look elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Units {
    /// Of lengths, diagonals and positions; areas are in their square.
    pub length: &'static str,
    /// Of everything under `distance`.
    pub distance: &'static str,
    /// Of angles.
    pub angle: &'static str,
    /// Of indices.
    pub index: &'static str,
    /// Of times.
    pub seconds: &'static str,
}

impl Units {
    /// The units of this version.
    pub const OF_REPORT: Self = Self {
        length: "units of the input file",
        distance: "percent of the diagonal of the input's bounding box",
        angle: "degrees",
        index: "quarters: 4 minus valence",
        seconds: "seconds; those of stages are summed over components, which run at the same time",
    };
}

/// Counts of a surface as it was read, before anything was cured.
///
/// Equal positions are one vertex; copies of faces and faces with fewer than three vertices do not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct AsRead {
    /// Faces, as many as the file has.
    pub faces: usize,
    /// Pieces whose faces hang together by edges.
    pub components: usize,
    /// Pieces of the boundary that hang together by vertices: loops, wherever no two of them touch.
    pub boundary_loops: usize,
    /// Edges with more than two faces.
    pub non_manifold_edges: usize,
}

/// Counts and size of a surface.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SurfaceReport {
    /// Counts and topology.
    #[serde(flatten)]
    pub summary: Summary,
    /// Area, file units squared.
    pub area: f64,
    /// Diagonal of the bounding box, file units.
    pub diagonal: f64,
}

/// Asked and reached count.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct CountReport {
    /// Quads asked for, or chosen where nothing was asked.
    pub asked: usize,
    /// Whether the user named the size.
    pub explicit: bool,
    /// Quads of the result.
    pub reached: usize,
    /// Deviation, percent of the count asked for.
    pub error_percent: f64,
    /// Deviation that is accepted, percent.
    pub tolerance_percent: f64,
}

/// Feature curves.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct FeatureReport {
    /// Curves between corners, boundaries included.
    pub chains: usize,
    /// Edges of the input on them.
    pub edges: usize,
    /// Fixed corners.
    pub corners: usize,
    /// Curves that the result has as runs of quad edges.
    pub chains_kept: usize,
    /// Sharp edges dropped because their chains are short and loose.
    pub dropped_edges: usize,
}

/// The cross field.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct FieldSummary {
    /// Interior singular vertices by index in quarters (valence 3 is 1).
    pub by_index: BTreeMap<i32, usize>,
    /// Smoothness energy ([Bommes2012] §8.2, Eq. (8.1)), radians squared.
    pub energy: f64,
    /// Singular vertices of the field that was given.
    pub given_singularities: Option<usize>,
    /// Whether the result's irregular vertices are those of the given field.
    pub singularities_kept: Option<bool>,
}

/// The integer-grid map.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct MapSummary {
    /// Triangles of the work meshes.
    pub triangles: usize,
    /// Map solves, re-scalings and attempts included.
    pub solves: usize,
    /// Inverted triangles of the maps that were used.
    pub flips: usize,
}

/// How one component was made.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ComponentReport {
    /// Triangles of the repaired input.
    pub triangles: usize,
    /// Its share of the count.
    pub asked: usize,
    /// Quads of the result.
    pub reached: usize,
    /// The attempt that gave the result, from 0.
    pub attempt: usize,
    /// How it was made.
    pub made_by: &'static str,
}

/// Seconds by stage, in the order in which stages were first entered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seconds(Vec<(&'static str, f64)>);

impl Seconds {
    /// Adds time to a stage.
    pub fn add(&mut self, stage: &'static str, seconds: f64) {
        match self.0.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, sum)) => *sum += seconds,
            None => self.0.push((stage, seconds)),
        }
    }

    /// Runs `work` and adds its time to a stage.
    pub fn time<T>(&mut self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let result = work();
        self.add(stage, begin.elapsed().as_secs_f64());
        result
    }

    /// Adds the times of another run, stage by stage.
    pub fn absorb(&mut self, other: &Self) {
        for &(stage, seconds) in &other.0 {
            self.add(stage, seconds);
        }
    }

    /// Stages and their times.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.0.iter().copied()
    }
}

impl Serialize for Seconds {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (stage, seconds) in &self.0 {
            // Milliseconds: what is below changes from run to run.
            map.serialize_entry(stage, &((seconds * 1e3).round() / 1e3))?;
        }
        map.end()
    }
}
