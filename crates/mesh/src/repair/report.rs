//! What a repair cured or found.
//!
//! In: events with ids of the soup. Out: [`RepairReport`]. Holds: one entry per kind, in the order of the kinds.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// Ids listed per kind.
const LISTED: usize = 5;

/// A kind of dirt; ids are those of the soup, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FindingKind {
    /// A face with more than three corners was cut into triangles.
    Polygon,
    /// A face with fewer than three different corners was dropped.
    DegenerateFace,
    /// A copy of another face was dropped.
    DuplicateFace,
    /// A vertex was merged with one at the same position.
    WeldedVertex,
    /// A face was turned over.
    FlippedFace,
    /// A face was left open at an edge that more than two faces share.
    NonManifoldEdge,
    /// A face of a small piece that hung on such an edge was dropped.
    DroppedFin,
    /// A vertex was duplicated, because its faces form more than one fan.
    NonManifoldVertex,
    /// An edge was split, because another edge joins the same vertices.
    DoubleEdge,
    /// A triangle without area was flipped or collapsed away.
    ZeroAreaFace,
    /// A triangle without area was kept, because removing it would change the topology.
    ZeroAreaKept,
    /// A vertex that no face uses was dropped.
    UnusedVertex,
    /// A boundary vertex lies inside a boundary edge; both stay open.
    TJunction,
}

/// How often a kind of dirt was met.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// What it is.
    pub kind: FindingKind,
    /// How often.
    pub count: usize,
    /// The first few: faces where the kind speaks of a face or of an edge (one of its faces), else vertices.
    pub first: Vec<u32>,
}

/// All findings of a repair.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RepairReport {
    findings: BTreeMap<FindingKind, Finding>,
}

impl RepairReport {
    pub(super) fn add(&mut self, kind: FindingKind, id: u32) {
        let finding = self.findings.entry(kind).or_insert(Finding { kind, count: 0, first: Vec::new() });
        finding.count += 1;
        if finding.first.len() < LISTED && !finding.first.contains(&id) {
            finding.first.push(id);
        }
    }

    /// All findings, in the order of [`FindingKind`].
    pub fn findings(&self) -> impl Iterator<Item = &Finding> {
        self.findings.values()
    }

    /// How often a kind was met.
    pub fn count(&self, kind: FindingKind) -> usize {
        self.findings.get(&kind).map_or(0, |f| f.count)
    }

    /// Whether there was nothing to report.
    pub fn is_clean(&self) -> bool {
        self.findings.is_empty()
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.kind {
            FindingKind::Polygon => "polygons cut into triangles",
            FindingKind::DegenerateFace => "degenerate faces dropped",
            FindingKind::DuplicateFace => "duplicate faces dropped",
            FindingKind::WeldedVertex => "vertices merged with one at the same position",
            FindingKind::FlippedFace => "faces turned over",
            FindingKind::NonManifoldEdge => "faces cut off at edges with more than two faces",
            FindingKind::DroppedFin => "faces of fins dropped",
            FindingKind::NonManifoldVertex => "vertices with several fans duplicated",
            FindingKind::DoubleEdge => "double edges split",
            FindingKind::ZeroAreaFace => "triangles without area removed",
            FindingKind::ZeroAreaKept => "triangles without area kept for the topology",
            FindingKind::UnusedVertex => "unused vertices dropped",
            FindingKind::TJunction => "T-junctions left open",
        };
        write!(f, "{} {what} (first: {:?})", self.count, self.first)
    }
}
