//! Skeletons of any map, by relaxation: targetless tubification.
//!
//! In: a map; options. Out: [`Relaxed`]: a [`Skeleton`], its symmetry, its clearance.
//! Holds: the skeleton passes its check and no two edges cross; it has the symmetry to 1e-12; equal options give equal bytes
//! for any number of threads. Not: the largest clearance there is: it is the best of the starts made.
//! Source: [Razafindrazaka2015] §9.2–9.4; symmetry imposed: §9.6 has it by hand.
//!
//! ```text
//!   map ─▶ groups of rotations that it can have ─▶ starts ─▶ soft ropes, shaken ─▶ hard ropes ─▶ the best
//! ```

use super::clearance::{clearance, extent};
use super::ropes::{Forces, Layout, Ropes};
use super::starts::{self, Random};
use super::symmetry::{Imposed, PointGroup, mean, symmetries};
use super::{Skeleton, SkeletonDefect};
use glam::DVec3;
use quadloom_mesh::{Cancelled, Progress};
use quadloom_regular_maps::map::RegularMap;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Which rotations a relaxed skeleton is made to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Symmetry {
    /// The largest group that leaves tubes thick enough.
    #[default]
    Auto,
    /// None is asked for.
    None,
    /// This one.
    Named(PointGroup),
}

/// How to relax a skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct RelaxOptions {
    /// Rotations to have. Default: the largest group that leaves tubes thick enough.
    pub symmetry: Symmetry,
    /// Starts per symmetry, fewer where many points move. Default: 6; large maps settle in many different ways, small ones
    /// in two or three.
    pub starts: usize,
    /// Symmetries tried at most. Default: 24, the largest groups first.
    pub symmetries: usize,
    /// Steps per descent. Default: 900; half of them are for untangling.
    pub steps: usize,
    /// Inner points per edge. Default: 14; with fewer, ropes slip through each other between points.
    pub points: usize,
    /// Clearance that a symmetric skeleton must have, as a fraction of the best of all. Default: 0.7. Smaller: more
    /// symmetry, thinner tubes.
    pub thick_enough: f64,
    /// How steeply edges may leave the plane of their junction, from 0 (they lie in it) to 1 (as at the corners of the
    /// regular solids). Default: 1. Where edges leave steeply, tubes part late.
    pub slope: f64,
    /// Seed of all starts. Default: 1.
    pub seed: u64,
}

impl Default for RelaxOptions {
    fn default() -> Self {
        Self {
            symmetry: Symmetry::Auto,
            starts: 6,
            symmetries: 24,
            steps: 900,
            points: 14,
            thick_enough: 0.7,
            slope: 1.0,
            seed: 1,
        }
    }
}

/// Why there is no skeleton.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SkeletonError {
    /// No group of automorphisms acts like this group of rotations.
    #[error("{map} has no automorphisms that junctions and tubes can follow as the rotations {group}")]
    NoSymmetry {
        /// Name of the map.
        map: String,
        /// The group asked for.
        group: PointGroup,
    },
    /// Junctions of fewer than three tubes.
    #[error("{0} has {1} edges at a vertex; a junction has at least 3")]
    Valence(String, usize),
    /// All starts ended with edges that cross or touch.
    #[error("no start for {map} ended without crossings; more starts or steps, or less symmetry, may help")]
    Crossing {
        /// Name of the map.
        map: String,
    },
    /// A skeleton that is not the map's: a fault of this library.
    #[error(transparent)]
    Defect(#[from] SkeletonDefect),
    /// Stopped from outside.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A relaxed skeleton and what is known about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Relaxed {
    /// Centre at the origin, radius 1.
    pub skeleton: Skeleton,
    /// The rotations that it was made to have.
    pub symmetry: Imposed,
    /// Its [`clearance`].
    pub clearance: f64,
}

/// The skeleton of a map, by relaxation.
///
/// # Errors     see [`relax`]
pub fn relaxed(map: &RegularMap, options: &RelaxOptions, progress: &Progress) -> Result<Skeleton, SkeletonError> {
    relax(map, options, progress).map(|found| found.skeleton)
}

/// The skeleton of a map, by relaxation, with its symmetry.
///
/// # Output     centre at the origin, radius 1
/// # Errors     [`SkeletonError::NoSymmetry`] for a group asked for by name; [`SkeletonError::Crossing`];
///   [`SkeletonError::Cancelled`]
/// # Cost       (starts) × (symmetries) × (steps) × (points of a fundamental domain)
/// # Source     [Razafindrazaka2015] §9.4
pub fn relax(map: &RegularMap, options: &RelaxOptions, progress: &Progress) -> Result<Relaxed, SkeletonError> {
    if map.q() < 3 {
        return Err(SkeletonError::Valence(map.type_name(), map.q()));
    }
    let layout = Layout::new(map, options.points.max(4));
    let candidates = candidates(map, options)?;
    let search = Search { map, layout: &layout, candidates: &candidates, options, progress };
    let settled = search.first_descents()?;
    let mut found = search.second_descents(&settled)?;
    found.extend(settled);
    let best =
        choose(found, &candidates, options.thick_enough).ok_or(SkeletonError::Crossing { map: map.type_name() })?;
    best.skeleton.check(map)?;
    Ok(Relaxed { skeleton: best.skeleton, symmetry: candidates[best.symmetry].clone(), clearance: best.clearance })
}

fn candidates(map: &RegularMap, options: &RelaxOptions) -> Result<Vec<Imposed>, SkeletonError> {
    let mut found = match options.symmetry {
        Symmetry::None => vec![],
        Symmetry::Auto => symmetries(map, None, options.symmetries),
        Symmetry::Named(group) if group.order() == 1 => vec![],
        Symmetry::Named(group) => {
            let found = symmetries(map, Some(group), options.symmetries);
            if found.is_empty() {
                return Err(SkeletonError::NoSymmetry { map: map.type_name(), group });
            }
            found
        }
    };
    found.truncate(options.symmetries);
    if !matches!(options.symmetry, Symmetry::Named(group) if group.order() > 1) {
        found.push(Imposed::trivial());
    }
    Ok(found)
}

/// The end of one descent.
struct Settled {
    /// Points, in diameters.
    x: Vec<DVec3>,
    /// Number of the symmetry.
    symmetry: usize,
    skeleton: Skeleton,
    clearance: f64,
}

/// Ends of first descents that are worth a second one: the thickest of the largest groups, and the thickest of all.
fn finalists(settled: &[Settled], layout: &Layout, candidates: &[Imposed], thick_enough: f64) -> Vec<usize> {
    let best = settled.iter().map(|r| r.clearance).fold(0.0, f64::max);
    let order = |k: &usize| candidates[settled[*k].symmetry].elements.len();
    let thickest_first = |a: &usize, b: &usize| settled[*b].clearance.total_cmp(&settled[*a].clearance);
    let mut all: Vec<usize> = (0..settled.len()).collect();
    all.sort_by(thickest_first);
    // What is a little too thin now may be thick enough after it.
    let mut thick: Vec<usize> =
        all.iter().copied().filter(|&k| settled[k].clearance >= 0.7 * thick_enough * best).collect();
    thick.sort_by(|a, b| order(b).cmp(&order(a)).then(thickest_first(a, b)));
    let mut found = Vec::new();
    let mut points = 0;
    for k in thick.into_iter().take(FINALISTS).chain(all.into_iter().take(FINALISTS)) {
        points += domain(layout, &candidates[settled[k].symmetry]);
        if !found.contains(&k) && (found.is_empty() || points <= 2 * AFFORDABLE) {
            found.push(k);
        }
    }
    found
}

/// Points that descent moves: one of each orbit.
fn domain(layout: &Layout, imposed: &Imposed) -> usize {
    layout.count().div_ceil(imposed.elements.len())
}

/// Points moved at most in all starts with one symmetry, but for the first start. Larger: slower for maps with more than
/// a hundred edges, which then end with a little thicker tubes.
const AFFORDABLE: usize = 2500;

/// Second descents by size of group, and as many by thickness.
const FINALISTS: usize = 4;

/// Among those that are thick enough the largest group, and there the thickest tubes.
fn choose(found: Vec<Settled>, candidates: &[Imposed], thick_enough: f64) -> Option<Settled> {
    let best = found.iter().map(|r| r.clearance).fold(0.0, f64::max);
    let rank = |r: &Settled| (candidates[r.symmetry].elements.len(), r.clearance);
    let thick = found.into_iter().filter(|r| r.clearance > 0.0 && r.clearance >= thick_enough * best);
    thick.reduce(|a, b| if rank(&b) > rank(&a) { b } else { a })
}

/// What all descents share.
struct Search<'a> {
    map: &'a RegularMap,
    layout: &'a Layout,
    candidates: &'a [Imposed],
    options: &'a RelaxOptions,
    progress: &'a Progress,
}

impl Search<'_> {
    /// From all starts with all symmetries.
    fn first_descents(&self) -> Result<Vec<Settled>, Cancelled> {
        let starts = |symmetry: usize| {
            let affordable = AFFORDABLE / domain(self.layout, &self.candidates[symmetry]);
            (0..affordable.clamp(1, self.options.starts.max(1))).map(move |start| (symmetry, start))
        };
        let jobs: Vec<_> = (0..self.candidates.len()).flat_map(starts).collect();
        self.each("relaxing skeletons", &jobs, |k, &(symmetry, start)| {
            self.descend(symmetry, start, Random::new(self.options.seed, k as u64))
        })
    }

    /// From the ends of the best first descents.
    fn second_descents(&self, settled: &[Settled]) -> Result<Vec<Settled>, Cancelled> {
        let finalists = finalists(settled, self.layout, self.candidates, self.options.thick_enough);
        let jobs: Vec<_> = finalists.iter().flat_map(|&k| FINISHES.map(|finish| (&settled[k], finish))).collect();
        self.each("tightening skeletons", &jobs, |_, (settled, finish)| {
            self.finish(settled.symmetry, settled.x.clone(), finish)
        })
    }

    /// Jobs on all threads; their results in order, whichever ends first.
    fn each<T: Sync>(
        &self,
        stage: &str,
        jobs: &[T],
        run: impl Fn(usize, &T) -> Result<Settled, Cancelled> + Sync,
    ) -> Result<Vec<Settled>, Cancelled> {
        let done = AtomicUsize::new(0);
        let run = |(k, job): (usize, &T)| {
            let settled = run(k, job)?;
            let finished = done.fetch_add(1, Ordering::Relaxed) + 1;
            self.progress.report(stage, finished as f64 / jobs.len() as f64);
            Ok(settled)
        };
        jobs.par_iter().enumerate().map(run).collect()
    }

    fn descend(&self, symmetry: usize, start: usize, mut random: Random) -> Result<Settled, Cancelled> {
        let imposed = &self.candidates[symmetry];
        let x = match start {
            0 if imposed.elements.len() == 1 => starts::jemisphere(self.map, self.layout, &mut random),
            _ => starts::random(self.layout, &mut random),
        };
        let mut ropes = Ropes::new(self.map, self.layout, imposed, self.options.slope, x);
        let mix = BEGINNINGS[start % BEGINNINGS.len()];
        for step in 0..self.options.steps {
            let time = step as f64 / self.options.steps as f64;
            ropes.advance(&schedule(&mix, time));
            if step % SHAKEN_EVERY == 0 {
                self.progress.check()?;
                if time < SHAKEN {
                    let noise = SHAKE * (1.0 - time / SHAKEN);
                    ropes.shake(|| noise * random.in_ball());
                }
            }
        }
        Ok(self.settled(symmetry, ropes))
    }

    fn finish(&self, symmetry: usize, x: Vec<DVec3>, mix: &Mix) -> Result<Settled, Cancelled> {
        let mut ropes = Ropes::new(self.map, self.layout, &self.candidates[symmetry], self.options.slope, x);
        for step in 0..self.options.steps {
            let time = 0.7 + 0.3 * step as f64 / self.options.steps as f64;
            ropes.advance(&schedule(mix, time));
            if step % SHAKEN_EVERY == 0 {
                self.progress.check()?;
            }
        }
        Ok(self.settled(symmetry, ropes))
    }

    fn settled(&self, symmetry: usize, ropes: Ropes) -> Settled {
        let skeleton = normalised(ropes.skeleton(), &self.candidates[symmetry]);
        let clearance = clearance(self.map, &skeleton);
        Settled { x: ropes.x, symmetry, skeleton, clearance }
    }
}

/// Part of the time in which ropes are shaken.
const SHAKEN: f64 = 0.3;

/// How far points are shaken at first, diameters. More than half a diameter would undo what descent has done.
const SHAKE: f64 = 0.3;

/// Steps from one shake, and one look whether to stop, to the next.
const SHAKEN_EVERY: usize = 16;

/// Strengths that decide whether a skeleton is wide or tight, spread evenly or taut: at first, and in the end.
#[derive(Clone, Copy)]
struct Mix {
    tension: [f64; 2],
    contact: [f64; 2],
    near: [f64; 2],
    far: [f64; 2],
}

/// No one mix is best for all maps: with more push from afar, solids open; with more from near, bouquets do.
const BEGINNINGS: [Mix; 3] = [
    Mix { tension: [0.3, 0.3], contact: [0.2, 1.5], near: [0.05, 0.2], far: [0.1, 0.01] },
    Mix { tension: [0.3, 0.6], contact: [0.2, 1.5], near: [0.05, 0.1], far: [0.3, 0.01] },
    Mix { tension: [0.3, 0.6], contact: [0.2, 1.5], near: [0.2, 0.1], far: [0.1, 0.01] },
];

/// For second descents, which start where first ones ended.
const FINISHES: [Mix; 3] = [
    Mix { tension: [0.3, 0.3], contact: [1.5, 1.5], near: [0.2, 0.2], far: [0.01, 0.01] },
    Mix { tension: [0.6, 0.6], contact: [3.0, 3.0], near: [0.1, 0.1], far: [0.01, 0.01] },
    Mix { tension: [0.3, 0.3], contact: [3.0, 3.0], near: [0.05, 0.05], far: [0.0, 0.0] },
];

/// Soft ropes first, which may pass through each other; hard ones in the end.
fn schedule(mix: &Mix, time: f64) -> Forces {
    let hard = ((time - 0.2) / 0.5).clamp(0.0, 1.0);
    let now = |[from, to]: [f64; 2]| from + (to - from) * hard;
    Forces {
        tension: now(mix.tension),
        stiffness: 0.15,
        contact: now(mix.contact),
        near: now(mix.near),
        far: now(mix.far),
        step: 0.12,
        momentum: if time < 0.95 { 0.85 } else { 0.6 },
    }
}

/// Centre at the origin, as far as the symmetry leaves that open, and radius 1.
fn normalised(mut skeleton: Skeleton, imposed: &Imposed) -> Skeleton {
    let (centre, radius) = extent(&skeleton);
    let shift = mean(imposed.elements.iter().map(|(_, m)| *m)) * centre;
    let place = |p: &mut DVec3| *p = (*p - shift) / radius;
    skeleton.positions.iter_mut().for_each(place);
    skeleton.edges.iter_mut().flatten().for_each(place);
    skeleton
}
