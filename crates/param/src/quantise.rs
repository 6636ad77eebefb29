//! Separation: integers under which no arc of the motorcycle graph is reversed and no two fixed places coincide.
//!
//! In: the arcs of a fold-free seamless map and the map's integers with their energy. Out: integers that admit a
//! fold-free map, or the number of conditions that could not be met. Holds on success: every arc is non-negative, no
//! path of zero arcs joins two integer vertices or features.
//! Source: the validity conditions of [Campen2015] §4, as rows of the problem of [Bommes2012] §8.4: lengths of arcs are
//! at least 0, and a path found to have collapsed is at least 1 long, which for arcs that are not negative is the same
//! as one of them being so.

use crate::tmesh::{Arc, Form, TMesh};
use quadloom_mesh::FaceId;
use quadloom_numeric::{IntegerProblem, LowerBound, SolveError, SolveOptions};
use std::collections::BTreeMap;

/// How long separation goes on.
#[derive(Clone, Debug)]
pub struct SeparationOptions {
    /// Most roundings. Default 40; each adds the paths that collapsed so far, and few maps need more than ten.
    pub rounds: u32,
}

impl Default for SeparationOptions {
    fn default() -> Self {
        Self { rounds: 40 }
    }
}

/// What separation did.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct SeparationReport {
    /// Arcs of the motorcycle graph.
    pub arcs: usize,
    /// Roundings.
    pub rounds: u32,
    /// Paths that were kept from collapsing in the end.
    pub prescribed: usize,
    /// Conditions that the last rounding missed.
    pub violated: usize,
    /// Inverted faces of the map at the separated integers, before and after untangling.
    pub inverted: [usize; 2],
    /// Inverted faces of the seamless map; where there are any, nothing was traced.
    pub seamless_inverted: usize,
    /// The first of them.
    pub seamless_inverted_faces: Vec<FaceId>,
}

/// Quads by which a missed row is to be longer in the next round.
///
/// Smaller: more rounds. Larger: quads are stretched where half a quad would have been enough.
const MARGIN_STEP: f64 = 0.5;

/// A row that is missed with this margin, in quads, is not a matter of rounding.
const LARGEST_MARGIN: f64 = 3.0;

/// Lengths of arcs over the free integers.
struct Lengths {
    /// Per arc its sum and constant; `None` where its length is not a matter of integers alone.
    of_arc: Vec<Option<(Vec<(u32, f64)>, f64)>>,
}

impl Lengths {
    fn new(tmesh: &TMesh, problem: &IntegerProblem) -> Self {
        let over = |form: &Form| problem.over_integers(form.iter().map(|&(i, c)| (i as usize, f64::from(c))));
        Self { of_arc: tmesh.arcs.iter().map(|arc| over(&arc.form)).collect() }
    }

    fn values(&self, z: &[f64]) -> Vec<f64> {
        let value = |(terms, constant): &(Vec<(u32, f64)>, f64)| {
            (terms.iter().map(|&(i, c)| c * z[i as usize]).sum::<f64>() + constant).round()
        };
        self.of_arc.iter().map(|arc| arc.as_ref().map_or(f64::INFINITY, value)).collect()
    }

    /// The sum of some arcs is to be at least `least`; `None` where no choice of integers changes it.
    fn bound(&self, arcs: &[usize], least: f64) -> Option<LowerBound> {
        let (mut sum, mut constant) = (BTreeMap::<u32, f64>::new(), 0.0);
        for &i in arcs {
            let (terms, c) = self.of_arc[i].as_ref()?;
            constant += c;
            terms.iter().for_each(|&(k, c)| *sum.entry(k).or_insert(0.0) += c);
        }
        let terms: Vec<(u32, f64)> = sum.into_iter().filter(|t| t.1.abs() > 1e-9).collect();
        (!terms.is_empty()).then_some(LowerBound { terms, least: least - constant })
    }
}

/// Rounds again and again, each time keeping the paths apart that collapsed before.
///
/// # Output     the free integers, if all conditions hold, and the report
/// # Errors     cancellation
/// # Cost       k³ per round for k integers
pub fn separate(
    tmesh: &TMesh,
    options: &SeparationOptions,
    problem: &IntegerProblem,
    solve: &SolveOptions,
) -> Result<(Option<Vec<f64>>, SeparationReport), SolveError> {
    let mut report = SeparationReport { arcs: tmesh.arcs.len(), ..Default::default() };
    // 1. No arc is reversed; equal lengths are one row.
    let lengths = Lengths::new(tmesh, problem);
    let mut rows: Vec<LowerBound> = (0..tmesh.arcs.len()).filter_map(|i| lengths.bound(&[i], 0.0)).collect();
    let key = |row: &LowerBound| row.terms.iter().map(|t| (t.0, t.1.to_bits())).collect::<Vec<_>>();
    rows.sort_by_cached_key(key);
    rows.dedup_by(|b, a| {
        a.terms == b.terms && {
            a.least = a.least.max(b.least);
            true
        }
    });
    let first = rows.len();
    let mut margin = vec![0.0; first];
    // 2. No path between places that must differ collapses.
    while report.rounds < options.rounds {
        report.rounds += 1;
        report.prescribed = rows.len() - first;
        let wanted: Vec<LowerBound> =
            rows.iter().zip(&margin).map(|(r, m)| LowerBound { least: r.least + m, ..r.clone() }).collect();
        let (z, _) = problem.round(&wanted, solve)?;
        // 3. Rows that rounding misses get a margin; without it the same integers would come again.
        let missed: Vec<usize> = (0..rows.len()).filter(|&r| rows[r].is_missed(&z)).collect();
        report.violated = missed.len();
        if !missed.is_empty() {
            if missed.iter().all(|&r| margin[r] >= LARGEST_MARGIN) {
                break;
            }
            missed.into_iter().for_each(|r| margin[r] += MARGIN_STEP);
            continue;
        }
        let collapsed = collapsed_paths(tmesh, &lengths.values(&z));
        report.violated = collapsed.len();
        if collapsed.is_empty() {
            return Ok((Some(z), report));
        }
        let before = rows.len();
        for row in collapsed.iter().filter_map(|path| lengths.bound(path, 1.0)) {
            if !rows[first..].contains(&row) {
                rows.push(row);
                margin.push(0.0);
            }
        }
        if rows.len() == before {
            break;
        }
    }
    Ok((None, report))
}

/// Paths of zero arcs that join two places which must differ.
///
/// Along features, junctions may coincide with each other but corners may not; elsewhere no two pinned nodes may.
fn collapsed_paths(tmesh: &TMesh, length: &[f64]) -> Vec<Vec<usize>> {
    let vertices = tmesh.vertex_nodes();
    let mut paths = Vec::new();
    collapsed(tmesh, length, |arc| !arc.on_feature, |n| tmesh.pinned[n], &mut paths);
    collapsed(tmesh, length, |_| true, |n| n < vertices, &mut paths);
    paths
}

/// Breadth-first over zero arcs from each pinned node; the paths to other ones.
fn collapsed(
    tmesh: &TMesh,
    length: &[f64],
    counts: impl Fn(&Arc) -> bool,
    pinned: impl Fn(usize) -> bool,
    paths: &mut Vec<Vec<usize>>,
) {
    let nodes = tmesh.pinned.len();
    let mut at: Vec<Vec<u32>> = vec![Vec::new(); nodes];
    for (i, arc) in tmesh.arcs.iter().enumerate() {
        if length[i].abs() < 0.5 && counts(arc) {
            at[arc.from as usize].push(i as u32);
            at[arc.to as usize].push(i as u32);
        }
    }
    let mut owner = vec![u32::MAX; nodes];
    let mut through = vec![u32::MAX; nodes];
    for root in (0..nodes).filter(|&n| pinned(n)) {
        if owner[root] != u32::MAX {
            continue;
        }
        owner[root] = root as u32;
        let mut queue = std::collections::VecDeque::from([root]);
        while let Some(n) = queue.pop_front() {
            for &i in &at[n] {
                let arc = &tmesh.arcs[i as usize];
                let m = if arc.from as usize == n { arc.to as usize } else { arc.from as usize };
                if owner[m] != u32::MAX {
                    continue;
                }
                owner[m] = root as u32;
                through[m] = i;
                if !pinned(m) {
                    queue.push_back(m);
                    continue;
                }
                // Walk back to the root.
                let (mut path, mut k) = (Vec::new(), m);
                while k != root && through[k] != u32::MAX {
                    let j = through[k] as usize;
                    path.push(j);
                    k = if tmesh.arcs[j].to as usize == k { tmesh.arcs[j].from } else { tmesh.arcs[j].to } as usize;
                }
                paths.push(path);
                // The other pinned node keeps its own search.
                owner[m] = u32::MAX;
                through[m] = u32::MAX;
            }
        }
    }
}
