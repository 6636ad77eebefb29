//! Branch and bound over the integers: the optimum, or a proven gap.
//!
//! In: the relaxed integers as a `Conditional`, an incumbent, limits. Out: `Proof`, the best integers
//! found and a bound that no integers undercut.
//! Holds: without limits and with gap 0 the result is a global optimum; deterministic unless a time limit
//! strikes.
//!
//! Source: [Bommes2012] §4.1 (algorithm, approximate solutions, selection and branching strategies).
//! Differs: a node fixes an integer at its nearest, second nearest, … value instead of bounding it from one
//! side. Without inequalities the relaxation and the cost of every branch are then known in closed form,
//! so that pseudo-costs are exact and no sub-problem is ever solved iteratively.

use std::collections::BinaryHeap;
use std::time::{Duration, Instant};

use crate::conditional::{Conditional, Saved};
use crate::error::SolveError;
use crate::rounding::nearest_integer;

/// Which open sub-problem is looked at next ([Bommes2012] §4.1).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Selection {
    /// The one of smallest lower bound: fewest nodes until the proof, but memory for all open ones.
    BestBound,
    /// The deepest: good solutions early, hardly any memory, cheaper nodes.
    #[default]
    DepthFirst,
}

/// Which integer is fixed next ([Bommes2012] §4.1).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Branching {
    /// The nearest to an integer.
    MinInfeasibility,
    /// The farthest from an integer.
    MaxInfeasibility,
    /// The one whose nearest and second nearest values cost most energy.
    #[default]
    PseudoCost,
}

/// Limits and strategies of branch and bound.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ExactOptions {
    /// Order of sub-problems. Default: depth first.
    pub selection: Selection,
    /// Choice of the next integer. Default: pseudo-costs.
    pub branching: Branching,
    /// Stop when (energy − bound) / |energy| is at most this. Default 0: prove the optimum.
    pub gap: f64,
    /// Stop after this long with the best found and its gap. Default: none.
    pub time_limit: Option<Duration>,
    /// Stop after so many nodes, likewise, and deterministically. Default: none.
    pub node_limit: Option<usize>,
}

/// What branch and bound found out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExactReport {
    /// Sub-problems looked at.
    pub nodes: usize,
    /// No admissible solution has less energy than this.
    pub lower_bound: f64,
    /// (energy − lower bound) / |energy|, the d_r of [Bommes2012] §4.1.
    pub gap: f64,
    /// Whether the search ended by itself: the gap asked for is proven.
    pub proven: bool,
    /// Energy of the greedy solution that the search started from.
    pub greedy_energy: f64,
}

/// Best integers found and their cost above the relaxed energy.
#[derive(Debug, Clone)]
pub(crate) struct Proof {
    pub values: Vec<f64>,
    pub cost: f64,
    pub lower_bound: f64,
    pub nodes: usize,
    pub proven: bool,
}

/// Bounds differ from their exact values by rounding; nodes this near the incumbent hold nothing better.
const BOUND_NOISE_REL: f64 = 1e-12;

/// Nodes between two looks at the clock.
const CLOCK_INTERVAL: usize = 256;

/// Searches for integers of least cost, starting from `incumbent`.
///
/// # Input   `relaxed_energy`: the energy that costs add to, for the relative gap
/// # Errors  [`SolveError::Cancelled`]
pub(crate) fn branch_and_bound(
    relaxation: Conditional,
    relaxed_energy: f64,
    incumbent: Vec<f64>,
    options: &ExactOptions,
    cancelled: &dyn Fn() -> bool,
) -> Result<Proof, SolveError> {
    let cost = cost_of(relaxation.clone(), &incumbent);
    let mut search = Search {
        relaxation,
        relaxed_energy,
        best: incumbent,
        best_cost: cost,
        pruned: f64::INFINITY,
        nodes: 0,
        options,
        started: Instant::now(),
        cancelled,
    };
    let open = match options.selection {
        Selection::DepthFirst => search.depth_first()?,
        Selection::BestBound => search.best_bound()?,
    };
    Ok(Proof {
        lower_bound: open.unwrap_or(f64::INFINITY).min(search.pruned).min(search.best_cost),
        values: search.best,
        cost: search.best_cost,
        nodes: search.nodes,
        proven: open.is_none(),
    })
}

/// Cost of an assignment above the relaxed energy.
pub(crate) fn cost_of(mut relaxation: Conditional, values: &[f64]) -> f64 {
    let mut cost = 0.0;
    for (i, &value) in values.iter().enumerate() {
        cost += relaxation.cost(i, value);
        relaxation.fix(i, value);
    }
    cost
}

/// The values of one integer under one parent, cheapest first.
#[derive(Debug, Clone, Copy)]
struct Branch {
    variable: usize,
    center: f64,
    curvature: f64,
    parent_cost: f64,
    /// How many of its values have been taken.
    taken: u32,
}

impl Branch {
    /// The nearest, second nearest, … integer: centre rounded, then alternately on either side.
    fn value(&self) -> f64 {
        let nearest = nearest_integer(self.center);
        let toward = if self.center >= nearest { 1.0 } else { -1.0 };
        let steps = f64::from(self.taken.div_ceil(2));
        nearest + if self.taken % 2 == 1 { toward * steps } else { -toward * steps }
    }

    fn cost(&self) -> f64 {
        self.parent_cost + self.curvature * (self.value() - self.center).powi(2)
    }
}

struct Search<'a> {
    relaxation: Conditional,
    relaxed_energy: f64,
    best: Vec<f64>,
    best_cost: f64,
    /// Smallest bound of a pruned sub-problem.
    pruned: f64,
    nodes: usize,
    options: &'a ExactOptions,
    started: Instant,
    cancelled: &'a dyn Fn() -> bool,
}

impl Search<'_> {
    /// Returns the smallest bound left open where a limit struck, None where the search ended by itself.
    fn depth_first(&mut self) -> Result<Option<f64>, SolveError> {
        let mut stack: Vec<(Branch, Option<Saved>)> = Vec::new();
        stack.extend(self.enter(0.0).map(|branch| (branch, None)));
        while let Some((branch, saved)) = stack.last_mut() {
            if let Some(saved) = saved.take() {
                self.relaxation.undo(branch.variable, saved);
            }
            if self.is_pruned(branch.cost()) {
                stack.pop();
                continue;
            }
            if self.should_stop()? {
                return Ok(stack.iter().map(|(branch, _)| branch.cost()).reduce(f64::min));
            }
            *saved = Some(self.relaxation.save());
            let (value, cost) = (branch.value(), branch.cost());
            self.relaxation.fix(branch.variable, value);
            branch.taken += 1;
            stack.extend(self.enter(cost).map(|branch| (branch, None)));
        }
        Ok(None)
    }

    /// Same return value. Open branches wait in a heap; the relaxation is moved along the tree to each.
    fn best_bound(&mut self) -> Result<Option<f64>, SolveError> {
        let mut tree = Tree::default();
        let mut heap = BinaryHeap::new();
        heap.extend(self.enter(0.0).map(|branch| Open { branch, parent: None, depth: 0, id: 0 }));
        let mut made = 1;
        while let Some(open) = heap.pop() {
            let cost = open.branch.cost();
            if self.is_pruned(cost) {
                return Ok(None);
            }
            if self.should_stop()? {
                return Ok(Some(cost));
            }
            let node = tree.add(open.parent, open.branch.variable, open.branch.value());
            tree.move_to(node, &mut self.relaxation);
            let child =
                self.enter(cost).map(|branch| Open { branch, parent: Some(node), depth: open.depth + 1, id: made });
            let mut sibling = open;
            sibling.branch.taken += 1;
            sibling.id = made + 1;
            made += 2;
            heap.push(sibling);
            heap.extend(child);
        }
        Ok(None)
    }

    /// Looks at the sub-problem the relaxation is in: fathoms it, or says how to branch.
    fn enter(&mut self, cost: f64) -> Option<Branch> {
        self.nodes += 1;
        let Some(variable) = self.branching_variable() else {
            if cost < self.best_cost {
                self.best_cost = cost;
                self.best = (0..self.relaxation.len()).map(|i| self.relaxation.z(i)).collect();
            }
            return None;
        };
        Some(Branch {
            variable,
            center: self.relaxation.z(variable),
            curvature: self.relaxation.curvature(variable),
            parent_cost: cost,
            taken: 0,
        })
    }

    fn branching_variable(&self) -> Option<usize> {
        let score = |i: usize| {
            let z = self.relaxation.z(i);
            let deviation = (z - nearest_integer(z)).abs();
            match self.options.branching {
                Branching::MinInfeasibility => -deviation,
                Branching::MaxInfeasibility => deviation,
                Branching::PseudoCost => pseudo_cost(self.relaxation.curvature(i), deviation),
            }
        };
        let mut best: Option<(usize, f64)> = None;
        for i in self.relaxation.free() {
            let s = score(i);
            if best.is_none_or(|(_, t)| s > t) {
                best = Some((i, s));
            }
        }
        best.map(|(i, _)| i)
    }

    /// Pruning: no solution below could improve the incumbent by more than the gap.
    fn is_pruned(&mut self, cost: f64) -> bool {
        let energy = self.relaxed_energy + self.best_cost;
        let slack = self.options.gap.max(0.0) * energy.abs() + BOUND_NOISE_REL * (energy.abs() + self.best_cost);
        let prune = cost >= self.best_cost - slack;
        if prune {
            self.pruned = self.pruned.min(cost);
        }
        prune
    }

    fn should_stop(&self) -> Result<bool, SolveError> {
        if self.options.node_limit.is_some_and(|limit| self.nodes >= limit) {
            return Ok(true);
        }
        if !self.nodes.is_multiple_of(CLOCK_INTERVAL) {
            return Ok(false);
        }
        if (self.cancelled)() {
            return Err(SolveError::Cancelled);
        }
        Ok(self.options.time_limit.is_some_and(|limit| self.started.elapsed() >= limit))
    }
}

/// Product of the costs of the two nearest values; the first is kept off zero so that the second counts.
fn pseudo_cost(curvature: f64, deviation: f64) -> f64 {
    const LEAST: f64 = 1e-6;
    (curvature * deviation * deviation).max(LEAST * curvature) * curvature * (1.0 - deviation).powi(2)
}

/// An open branch in the heap: smallest cost first, then deepest, then oldest.
#[derive(Debug)]
struct Open {
    branch: Branch,
    parent: Option<usize>,
    depth: usize,
    id: usize,
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let by_cost = other.branch.cost().total_cmp(&self.branch.cost());
        by_cost.then(self.depth.cmp(&other.depth)).then(other.id.cmp(&self.id))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Open {}

/// Nodes made so far, and the path to the one that the relaxation is in.
#[derive(Default)]
struct Tree {
    /// (parent, variable, value).
    nodes: Vec<(Option<usize>, usize, f64)>,
    path: Vec<(usize, Saved)>,
}

impl Tree {
    fn add(&mut self, parent: Option<usize>, variable: usize, value: f64) -> usize {
        self.nodes.push((parent, variable, value));
        self.nodes.len() - 1
    }

    fn move_to(&mut self, node: usize, relaxation: &mut Conditional) {
        let mut target: Vec<usize> = std::iter::successors(Some(node), |&at| self.nodes[at].0).collect();
        target.reverse();
        let common = self.path.iter().zip(&target).take_while(|((at, _), goal)| at == *goal).count();
        for (at, saved) in self.path.drain(common..).rev() {
            relaxation.undo(self.nodes[at].1, saved);
        }
        for &at in &target[common..] {
            let saved = relaxation.save();
            relaxation.fix(self.nodes[at].1, self.nodes[at].2);
            self.path.push((at, saved));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_nearest_first() {
        for center in [0.3, -2.7, 5.0, 1.5, -0.5] {
            let branch = |taken| Branch { variable: 0, center, curvature: 1.0, parent_cost: 0.0, taken };
            let costs: Vec<f64> = (0..9).map(|taken| branch(taken).cost()).collect();
            assert!(costs.windows(2).all(|pair| pair[0] <= pair[1] + 1e-12), "{center}: {costs:?}");
            let mut values: Vec<i64> = (0..9).map(|taken| branch(taken).value() as i64).collect();
            values.sort_unstable();
            assert!(values.windows(2).all(|pair| pair[1] == pair[0] + 1));
        }
    }
}
