//! Separation: integers under which no arc of the motorcycle graph is reversed and no two fixed places coincide.
//!
//! In: the arcs of a fold-free seamless map, what its integer vertices see, and the map's integers with their energy. Out: integers that admit a
//! fold-free map, or the number of conditions that could not be met. Holds on success: every arc is non-negative, no
//! path of zero arcs joins two integer vertices or features.
//! Source: the validity conditions of [Campen2015] §4, as rows of the problem of [Bommes2012] §8.4: lengths of arcs are
//! at least 0, and a path found to have collapsed is at least 1 long, which for arcs that are not negative is the same
//! as one of them being so.

use crate::sight::Sight;
use crate::tmesh::{Arc, Form, TMesh};
use quadloom_mesh::FaceId;
use quadloom_numeric::{IntegerProblem, IntegerSum, LowerBound, SolveError, SolveOptions};
use std::collections::BTreeMap;

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
        let value = |sum: &IntegerSum| sum.value(z).round();
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

/// Chooses the integers, each time keeping the paths apart that collapsed before.
///
/// # Output     the free integers, and the report; where its `violated` is not 0, a map at these integers has folds, if
/// only around the places that coincide
/// # Errors     cancellation
/// # Cost       k³ per round for k integers
pub fn separate(
    tmesh: &TMesh,
    sights: &[Sight],
    options: &SeparationOptions,
    problem: &IntegerProblem,
    solve: &SolveOptions,
) -> Result<(Vec<f64>, SeparationReport), SolveError> {
    let differences: Vec<Difference> = sights.iter().filter_map(|sight| Difference::new(sight, problem)).collect();
    let lengths = Lengths::new(tmesh, problem);
    // 1. No arc is reversed.
    let mut conditions = Conditions::of_arcs(tmesh, &lengths);
    let mut report = SeparationReport { arcs: tmesh.arcs.len(), ..Default::default() };
    let mut z = conditions.round(problem, solve)?;
    let mut improvements = options.improvements;
    while report.rounds < options.rounds {
        report.rounds += 1;
        report.prescribed = conditions.rows.len() - conditions.arcs;
        // 2. Missed rows: single integers jump; where that does not help, all are chosen again with a margin.
        let missed = conditions.missed(&z);
        report.violated = missed.len();
        if !missed.is_empty() {
            if !conditions.mend(&mut z, problem, solve)? && !conditions.widen(&mut z, problem, solve)? {
                break;
            }
            continue;
        }
        // 3. No path between places that must differ collapses.
        let collapsed = collapsed_paths(tmesh, &lengths.values(&z));
        let coincident: Vec<&Difference> = differences.iter().filter(|d| d.is_zero(&z)).collect();
        report.violated = collapsed.len() + coincident.len();
        if report.violated > 0 {
            let apart = coincident.iter().map(|d| d.apart());
            if !conditions.add(collapsed.iter().filter_map(|path| lengths.bound(path, 1.0)).chain(apart)) {
                break;
            }
            continue;
        }
        // 4. Under all of them, few integers at a time are chosen better; what that changes is looked at again.
        if improvements == 0 {
            break;
        }
        let before = problem.excess(&z);
        conditions.improve(&mut z, problem, solve)?;
        let gained = before - problem.excess(&z);
        improvements = if gained > WORTHWHILE * before { improvements - 1 } else { 0 };
    }
    Ok((z, report))
}

/// What one integer vertex sees, over the free integers.
struct Difference {
    /// Must not all be zero.
    sums: Vec<IntegerSum>,
    /// The largest of them in the seamless map, and its sign there.
    largest: usize,
    sign: f64,
}

impl Difference {
    /// `None` where it is not a matter of integers alone, or of none.
    fn new(sight: &Sight, problem: &IntegerProblem) -> Option<Self> {
        let over = |form: &Form| problem.over_integers(form.iter().map(|&(i, c)| (i as usize, f64::from(c))));
        let sums: Vec<IntegerSum> = sight.ways.iter().map(|w| over(&w.1)).collect::<Option<_>>()?;
        let ways = || sight.ways.iter().map(|w| w.0).enumerate();
        let (largest, way) = ways().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()).then(b.0.cmp(&a.0)))?;
        (!sums[largest].terms.is_empty()).then_some(Self { sums, largest, sign: way.signum() })
    }

    fn is_zero(&self, z: &[f64]) -> bool {
        self.sums.iter().all(|sum| sum.value(z).abs() < 0.5)
    }

    /// The row that keeps the two apart, in the direction in which they are.
    fn apart(&self) -> LowerBound {
        let sum = &self.sums[self.largest];
        let terms = sum.terms.iter().map(|&(i, c)| (i, self.sign * c)).collect();
        LowerBound { terms, least: 1.0 - self.sign * sum.constant }
    }
}

/// Rows that the integers are to meet.
struct Conditions {
    rows: Vec<LowerBound>,
    /// Per row how much longer it is asked to be, because rounding missed it.
    margin: Vec<f64>,
    /// The first rows are those of single arcs.
    arcs: usize,
}

impl Conditions {
    /// Equal lengths are one row.
    fn of_arcs(tmesh: &TMesh, lengths: &Lengths) -> Self {
        let mut rows: Vec<LowerBound> = (0..tmesh.arcs.len()).filter_map(|i| lengths.bound(&[i], 0.0)).collect();
        rows.sort_by_cached_key(|row| row.terms.iter().map(|t| (t.0, t.1.to_bits())).collect::<Vec<_>>());
        rows.dedup_by(|b, a| {
            a.terms == b.terms && {
                a.least = a.least.max(b.least);
                true
            }
        });
        Self { margin: vec![0.0; rows.len()], arcs: rows.len(), rows }
    }

    fn missed(&self, z: &[f64]) -> Vec<usize> {
        (0..self.rows.len()).filter(|&r| self.rows[r].is_missed(z)).collect()
    }

    /// What is missing in all.
    fn shortfall(&self, z: &[f64]) -> f64 {
        self.rows.iter().map(|r| r.shortfall(z).max(0.0)).sum()
    }

    /// Adds rows; whether there was a new one.
    fn add(&mut self, rows: impl Iterator<Item = LowerBound>) -> bool {
        let before = self.rows.len();
        for row in rows {
            if !self.rows[self.arcs..].contains(&row) {
                self.rows.push(row);
                self.margin.push(0.0);
            }
        }
        self.rows.len() > before
    }

    /// All integers, under the rows where that does not take too long.
    fn round(&self, problem: &IntegerProblem, solve: &SolveOptions) -> Result<Vec<f64>, SolveError> {
        let rows = if problem.len() <= MOST_UNDER_ROWS { &self.rows[..] } else { &[] };
        problem.round(rows, &[], solve)
    }

    /// Lets integers jump from where they are and from a new rounding; the better one is taken, if it misses less.
    fn mend(&self, z: &mut Vec<f64>, problem: &IntegerProblem, solve: &SolveOptions) -> Result<bool, SolveError> {
        let mut better = problem.mend(&self.rows, z);
        if problem.len() <= MOST_UNDER_ROWS && self.shortfall(&better) > 0.5 {
            let anew = problem.mend(&self.rows, &problem.round(&self.rows, &[], solve)?);
            let cost = |z: &[f64]| (self.shortfall(z).round(), problem.excess(z));
            if cost(&anew) < cost(&better) {
                better = anew;
            }
        }
        let helps = self.shortfall(&better) < self.shortfall(z) - 0.5;
        if helps {
            *z = better;
        }
        Ok(helps)
    }

    /// Rounds again with more room for the rows that are missed; `false` where there has been enough of that.
    fn widen(&mut self, z: &mut Vec<f64>, problem: &IntegerProblem, solve: &SolveOptions) -> Result<bool, SolveError> {
        let missed = self.missed(z);
        if problem.len() > MOST_UNDER_ROWS || missed.iter().all(|&r| self.margin[r] >= LARGEST_MARGIN) {
            return Ok(false);
        }
        missed.into_iter().for_each(|r| self.margin[r] += MARGIN_STEP);
        let wider = |(r, m): (&LowerBound, &f64)| LowerBound { least: r.least + m, ..r.clone() };
        let wanted: Vec<LowerBound> = self.rows.iter().zip(&self.margin).map(wider).collect();
        *z = problem.mend(&self.rows, &problem.round(&wanted, &[], solve)?);
        Ok(true)
    }

    /// Chooses integers again, one neighbourhood after the other, where all rows stay met.
    fn improve(&self, z: &mut Vec<f64>, problem: &IntegerProblem, solve: &SolveOptions) -> Result<(), SolveError> {
        let mut rows_of = vec![Vec::new(); z.len()];
        for (row, r) in self.rows.iter().zip(0u32..) {
            row.terms.iter().for_each(|t| rows_of[t.0 as usize].push(r));
        }
        let before = problem.excess(z);
        let mut least = before;
        let mut settled = vec![false; z.len()];
        for root in 0..z.len() {
            if settled[root] {
                continue;
            }
            let near = self.neighbourhood(root, &rows_of, z);
            near.iter().take(NEIGHBOURHOOD / 2).for_each(|&i| settled[i] = true);
            let mut free = vec![false; z.len()];
            near.iter().for_each(|&i| free[i] = true);
            let kept: Vec<(usize, f64)> = (0..z.len()).filter(|&i| !free[i]).map(|i| (i, z[i])).collect();
            let mut other = problem.round(&self.rows, &kept, solve)?;
            if !self.missed(&other).is_empty() {
                other = problem.mend(&self.rows, &other);
            }
            let excess = problem.excess(&other);
            if excess < least - 1e-9 * before && self.missed(&other).is_empty() {
                (least, *z) = (excess, other);
            }
        }
        Ok(())
    }

    /// Integers around one, nearest first, that rows without room to spare tie to each other.
    fn neighbourhood(&self, root: usize, rows_of: &[Vec<u32>], z: &[f64]) -> Vec<usize> {
        let mut near = vec![root];
        let mut known = vec![false; z.len()];
        known[root] = true;
        let mut next = 0;
        while next < near.len() && near.len() < NEIGHBOURHOOD {
            let tight = rows_of[near[next]].iter().map(|&r| &self.rows[r as usize]).filter(|r| r.shortfall(z) > -TIGHT);
            for &(i, _) in tight.flat_map(|row| &row.terms) {
                if !std::mem::replace(&mut known[i as usize], true) && near.len() < NEIGHBOURHOOD {
                    near.push(i as usize);
                }
            }
            next += 1;
        }
        near
    }
}

/// More integers than this are rounded without rows, and what they miss is left to jumps: multipliers of a thousand
/// rows take longer than all else.
const MOST_UNDER_ROWS: usize = 400;

/// A row with no more than this to spare, in quads, ties its integers to each other.
const TIGHT: f64 = 1.5;

/// Part of the energy above the relaxation's that a pass has to gain for another one.
const WORTHWHILE: f64 = 0.03;

/// Integers that are chosen again together.
///
/// Fewer: less is gained; more: a rounding costs their third power.
const NEIGHBOURHOOD: usize = 40;

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
