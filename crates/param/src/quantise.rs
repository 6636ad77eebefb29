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
use quadloom_numeric::{IntegerProblem, IntegerSum, LowerBound, SolveError, SolveOptions};
use std::collections::BTreeMap;

/// How long separation goes on.
#[derive(Clone, Debug)]
pub struct SeparationOptions {
    /// Most rounds: paths that are added, or integers that are chosen again. Default 150; few maps need more than ten.
    pub rounds: u32,
}

impl Default for SeparationOptions {
    fn default() -> Self {
        Self { rounds: 150 }
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
    /// Attempts at points for these integers up to the one that was kept.
    pub followings: u32,
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
    of_arc: Vec<Option<IntegerSum>>,
}

impl Lengths {
    fn new(tmesh: &TMesh, problem: &IntegerProblem) -> Self {
        let over = |form: &Form| problem.over_integers(form.iter().map(|&(i, c)| (i as usize, f64::from(c))));
        Self { of_arc: tmesh.arcs.iter().map(|arc| over(&arc.form)).collect() }
    }

    fn values(&self, z: &[f64]) -> Vec<f64> {
        let value =
            |sum: &IntegerSum| (sum.terms.iter().map(|&(i, c)| c * z[i as usize]).sum::<f64>() + sum.constant).round();
        self.of_arc.iter().map(|arc| arc.as_ref().map_or(f64::INFINITY, value)).collect()
    }

    /// The sum of some arcs is to be at least `least`; `None` where no choice of integers changes it.
    fn bound(&self, arcs: &[usize], least: f64) -> Option<LowerBound> {
        let (mut sum, mut constant) = (BTreeMap::<u32, f64>::new(), 0.0);
        for &i in arcs {
            let length = self.of_arc[i].as_ref()?;
            constant += length.constant;
            length.terms.iter().for_each(|&(k, c)| *sum.entry(k).or_insert(0.0) += c);
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
    let mut z = problem.round(&rows, &[], solve)?;
    let mut reach = 1;
    while report.rounds < options.rounds {
        report.rounds += 1;
        report.prescribed = rows.len() - first;
        let missed: Vec<usize> = (0..rows.len()).filter(|&r| rows[r].is_missed(&z)).collect();
        report.violated = missed.len();
        if missed.is_empty() {
            // 2. No path between places that must differ collapses.
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
            reach = 1;
            continue;
        }
        // 3. Missed rows: the integers around them are chosen again.
        let shortfall = |z: &[f64]| rows.iter().map(|r| r.shortfall(z).max(0.0)).sum::<f64>();
        if reach <= LARGEST_REACH {
            let kept = far_integers(&rows, &missed, &z, reach);
            let other = problem.round(&rows, &kept, solve)?;
            if shortfall(&other) < shortfall(&z) - 0.5 {
                z = other;
                reach = 1;
            } else {
                reach += 1;
            }
            continue;
        }
        // 4. Where that does not help, all of them, with a margin for the rows that rounding misses.
        if missed.iter().all(|&r| margin[r] >= LARGEST_MARGIN) {
            break;
        }
        missed.into_iter().for_each(|r| margin[r] += MARGIN_STEP);
        let wanted: Vec<LowerBound> =
            rows.iter().zip(&margin).map(|(r, m)| LowerBound { least: r.least + m, ..r.clone() }).collect();
        z = problem.round(&wanted, &[], solve)?;
        reach = 1;
    }
    Ok((None, report))
}

/// The integers, with their values, that are not within `reach` rows of the missed ones.
///
/// Only rows that a unit more or less would break tie integers to each other.
fn far_integers(rows: &[LowerBound], missed: &[usize], z: &[f64], reach: u32) -> Vec<(usize, f64)> {
    let mut near = vec![false; z.len()];
    missed.iter().flat_map(|&r| &rows[r].terms).for_each(|t| near[t.0 as usize] = true);
    for _ in 1..reach {
        let mut next = near.clone();
        for row in rows.iter().filter(|r| r.shortfall(z) > -TIGHT && r.terms.iter().any(|t| near[t.0 as usize])) {
            row.terms.iter().for_each(|t| next[t.0 as usize] = true);
        }
        near = next;
    }
    (0..z.len()).filter(|&i| !near[i]).map(|i| (i, z[i])).collect()
}

/// A row with no more than this to spare, in quads, ties its integers to each other.
const TIGHT: f64 = 1.5;

/// Rows from the missed ones within which integers are chosen again before all are.
const LARGEST_REACH: u32 = 3;

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
