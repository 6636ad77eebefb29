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
use crate::map::RegularMap;
use glam::DVec3;
use quadloom_mesh::{Cancelled, Progress};
use rayon::prelude::*;

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
    /// Starts per symmetry. Default: 6; large maps settle in many different ways, small ones in two or three.
    pub starts: usize,
    /// Symmetries tried at most. Default: 24, the largest groups first.
    pub symmetries: usize,
    /// Steps per start. Default: 900; half of them are for untangling.
    pub steps: usize,
    /// Inner points per edge. Default: 14; with fewer, ropes slip through each other between points.
    pub points: usize,
    /// Clearance that a symmetric skeleton must have, as a fraction of the best of all. Default: 0.7. Smaller: more
    /// symmetry, thinner tubes.
    pub thick_enough: f64,
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
///              [`SkeletonError::Cancelled`]
/// # Cost       (starts) × (symmetries) × (steps) × (points of a fundamental domain)
/// # Source     [Razafindrazaka2015] §9.4
pub fn relax(map: &RegularMap, options: &RelaxOptions, progress: &Progress) -> Result<Relaxed, SkeletonError> {
    if map.q() < 3 {
        return Err(SkeletonError::Valence(map.type_name(), map.q()));
    }
    let layout = Layout::new(map, options.points.max(4));
    let candidates = candidates(map, options)?;
    let jobs: Vec<_> =
        candidates.iter().flat_map(|imposed| (0..options.starts.max(1)).map(move |start| (imposed, start))).collect();
    let run = |(k, (imposed, start)): (usize, &(&Imposed, usize))| {
        relax_from(map, &layout, imposed, *start, &mut Random::new(options.seed, k as u64), options, progress)
    };
    let found: Vec<Relaxed> = jobs.par_iter().enumerate().map(run).collect::<Result<_, Cancelled>>()?;
    let best = choose(found, options.thick_enough).ok_or(SkeletonError::Crossing { map: map.type_name() })?;
    best.skeleton.check(map)?;
    Ok(best)
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

/// Among those that are thick enough the largest group, and there the thickest tubes.
fn choose(found: Vec<Relaxed>, thick_enough: f64) -> Option<Relaxed> {
    let best = found.iter().map(|r| r.clearance).fold(0.0, f64::max);
    let rank = |r: &Relaxed| (r.symmetry.elements.len(), r.clearance);
    let thick = found.into_iter().filter(|r| r.clearance > 0.0 && r.clearance >= thick_enough * best);
    thick.reduce(|a, b| if rank(&b) > rank(&a) { b } else { a })
}

fn relax_from(
    map: &RegularMap,
    layout: &Layout,
    imposed: &Imposed,
    start: usize,
    random: &mut Random,
    options: &RelaxOptions,
    progress: &Progress,
) -> Result<Relaxed, Cancelled> {
    let x = match start {
        0 if imposed.elements.len() == 1 => starts::jemisphere(map, layout, random),
        _ => starts::random(layout, random),
    };
    let mut ropes = Ropes::new(map, layout, imposed, x);
    for step in 0..options.steps {
        let time = step as f64 / options.steps as f64;
        ropes.advance(&schedule(time));
        if step % 16 == 0 {
            progress.check()?;
            if time < SHAKEN {
                let noise = 0.3 * (1.0 - time / SHAKEN);
                ropes.shake(|| noise * random.in_ball());
            }
        }
    }
    let skeleton = normalised(ropes.skeleton(), imposed);
    let clearance = clearance(map, &skeleton);
    Ok(Relaxed { skeleton, symmetry: imposed.clone(), clearance })
}

/// Part of the time in which ropes are shaken.
const SHAKEN: f64 = 0.3;

/// Soft ropes first, which may pass through each other; hard ones in the end.
fn schedule(time: f64) -> Forces {
    let hard = ((time - 0.2) / 0.5).clamp(0.0, 1.0);
    Forces {
        tension: 0.3,
        stiffness: 0.15,
        contact: 0.2 + 1.3 * hard,
        near: 0.05,
        far: 0.1,
        step: 0.12,
        momentum: if time < 0.9 { 0.85 } else { 0.6 },
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
