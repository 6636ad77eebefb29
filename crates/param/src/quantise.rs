//! Separation: integers under which no arc of the motorcycle graph is reversed and no two fixed places coincide.
//!
//! In: the arcs of a fold-free seamless map, what its integer vertices see, its features' lengths, and the map's
//! integers with their energy. Out: integers that admit a fold-free map, or the number of conditions that could not be
//! met. Holds on success: every arc is non-negative, no path of zero arcs joins two integer vertices or features.
//! Source: the validity conditions of [Campen2015] §4, as rows of the problem of [Bommes2012] §8.4: lengths of arcs are
//! at least 0, and a path found to have collapsed is at least 1 long, which for arcs that are not negative is the same
//! as one of them being so.

use crate::conditions::{Conditions, Difference, Lengths};
use crate::curves::Curve;
use crate::sight::Sight;
use crate::tmesh::{Arc, TMesh};
use quadloom_mesh::FaceId;
use quadloom_numeric::{IntegerProblem, LowerBound, SolveError, SolveOptions};

/// How long separation goes on.
#[derive(Clone, Debug)]
pub struct SeparationOptions {
    /// Most rounds: paths that are added, or integers that are chosen again. Default 60; few maps need more than ten.
    pub rounds: u32,
    /// Most passes in which a few integers at a time are chosen again for less energy. Default 6; most maps gain
    /// little after the first.
    pub improvements: u32,
}

impl Default for SeparationOptions {
    fn default() -> Self {
        Self { rounds: 60, improvements: 6 }
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

/// Part of the energy above the relaxation's that a pass has to gain for another one.
const WORTHWHILE: f64 = 0.03;

/// Chooses the integers, each time keeping the paths apart that collapsed before.
///
/// Features that these integers would cut off are then given more quads, where all else stays met.
///
/// # Output     the free integers, and the report; where its `violated` is not 0, a map at these integers has folds, if
/// only around the places that coincide
/// # Errors     cancellation
/// # Cost       k³ per round for k integers
pub(crate) fn separate(
    tmesh: &TMesh,
    sights: &[Sight],
    curves: &[Curve],
    options: &SeparationOptions,
    problem: &IntegerProblem,
    solve: &SolveOptions,
) -> Result<(Vec<f64>, SeparationReport), SolveError> {
    let separation = Separation {
        tmesh,
        differences: sights.iter().filter_map(|sight| Difference::new(sight, problem)).collect(),
        lengths: Lengths::new(tmesh, problem),
        options,
        problem,
        solve,
    };
    // 1. No arc is reversed, no two places that must differ coincide.
    let mut conditions = Conditions::of_arcs(tmesh, &separation.lengths);
    let mut report = SeparationReport { arcs: tmesh.arcs.len(), ..Default::default() };
    let mut z = conditions.round(problem, solve)?;
    separation.settle(&mut conditions, &mut z, &mut report)?;
    // 2. Wishes: taken where the rows can all be met with them.
    for _ in 0..MOST_WISHES {
        let wishes: Vec<LowerBound> = curves.iter().filter_map(|curve| curve.wish(&z)).collect();
        let mut wished = conditions.clone();
        if report.violated > 0 || wishes.is_empty() || !wished.add(wishes.into_iter()) {
            break;
        }
        let (mut other, mut then) = (z.clone(), report.clone());
        separation.settle(&mut wished, &mut other, &mut then)?;
        if then.violated > 0 {
            break;
        }
        (conditions, z, report) = (wished, other, then);
    }
    Ok((z, report))
}

/// Rounds of wishes: what gives one curve more quads may take them from another.
const MOST_WISHES: u32 = 3;

/// What separation goes by.
struct Separation<'a> {
    tmesh: &'a TMesh,
    differences: Vec<Difference>,
    lengths: Lengths,
    options: &'a SeparationOptions,
    problem: &'a IntegerProblem<'a>,
    solve: &'a SolveOptions<'a>,
}

impl Separation<'_> {
    /// Changes integers and adds conditions until all are met, or none can be.
    fn settle(
        &self,
        conditions: &mut Conditions,
        z: &mut Vec<f64>,
        report: &mut SeparationReport,
    ) -> Result<(), SolveError> {
        let Self { tmesh, differences, lengths, options, problem, solve } = self;
        let mut improvements = options.improvements;
        let mut rounds = 0;
        while rounds < options.rounds {
            rounds += 1;
            report.rounds += 1;
            report.prescribed = conditions.prescribed();
            // 1. Missed rows: single integers jump; where that does not help, all are chosen again with a margin.
            let missed = conditions.missed(z);
            report.violated = missed.len();
            if !missed.is_empty() {
                if !conditions.mend(z, problem, solve)? && !conditions.widen(z, problem, solve)? {
                    break;
                }
                continue;
            }
            // 2. No path between places that must differ collapses.
            let collapsed = collapsed_paths(tmesh, &lengths.values(z));
            let coincident: Vec<&Difference> = differences.iter().filter(|d| d.is_zero(z)).collect();
            report.violated = collapsed.len() + coincident.len();
            if report.violated > 0 {
                let apart = coincident.iter().map(|d| d.apart());
                if !conditions.add(collapsed.iter().filter_map(|path| lengths.bound(path, 1.0)).chain(apart)) {
                    break;
                }
                continue;
            }
            // 3. Under all of them, few integers at a time are chosen better; what that changes is looked at again.
            if improvements == 0 {
                break;
            }
            let before = problem.excess(z);
            conditions.improve(z, problem, solve)?;
            let gained = before - problem.excess(z);
            improvements = if gained > WORTHWHILE * before { improvements - 1 } else { 0 };
        }
        Ok(())
    }
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
