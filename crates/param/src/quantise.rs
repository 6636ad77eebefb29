//! Separation: integers under which no arc of the motorcycle graph is reversed and no two fixed places coincide.
//!
//! In: the arcs of a fold-free seamless map and a solver for the map's integers with extra rows. Out: integers
//! that admit a fold-free map, or the reason why none was found. Holds on success: every arc is non-negative, no
//! path of zero arcs joins two integer vertices or features.
//! Source: the validity conditions of [Campen2015] §4, imposed lazily as rows of the problem of [Bommes2012] §8.4.

use crate::tmesh::{Arc, Form, TMesh, evaluate};
use quadloom_mesh::FaceId;

/// One row that was added: a length that is prescribed.
#[derive(Clone, Debug, PartialEq)]
pub struct Separation {
    /// The length's linear form.
    pub form: Form,
    /// Its prescribed value, grid units.
    pub value: f64,
}

/// How long separation goes on.
#[derive(Clone, Debug)]
pub struct SeparationOptions {
    /// Most solves. Default 40; each adds every arc found wrong so far, and few maps need more than ten.
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
    /// Solves.
    pub rounds: u32,
    /// Lengths that were prescribed in the end.
    pub prescribed: usize,
    /// Arcs still wrong after the last solve.
    pub violated: usize,
    /// Inverted faces of the map at the separated integers, before and after untangling.
    pub inverted: [usize; 2],
    /// Inverted faces of the seamless map; where there are any, nothing was traced.
    pub seamless_inverted: usize,
    /// The first of them.
    pub seamless_inverted_faces: Vec<FaceId>,
}

/// Coefficients of all prescribed rows beyond which elimination would fill the system.
const MOST_ROW_TERMS: usize = 6_000;

/// Solves again and again, each time prescribing the lengths that came out wrong.
///
/// # Input      `solve`: integers of the map under extra rows; `Err` lists rows (by number) that exclude each other
/// # Output     the solution, if all conditions hold, and the report
pub fn separate(
    tmesh: &TMesh,
    options: &SeparationOptions,
    mut solve: impl FnMut(&[Separation]) -> Result<Vec<f64>, Vec<usize>>,
) -> (Option<Vec<f64>>, SeparationReport) {
    let mut rows: Vec<Separation> = Vec::new();
    let mut report = SeparationReport { arcs: tmesh.arcs.len(), ..Default::default() };
    while report.rounds < options.rounds {
        if rows.iter().map(|r| r.form.len()).sum::<usize>() > MOST_ROW_TERMS {
            break;
        }
        report.rounds += 1;
        report.prescribed = rows.len();
        let x = match solve(&rows) {
            Ok(x) => x,
            Err(mut excluded) => {
                // Give up the latest row of the contradiction; the others stay.
                excluded.sort_unstable();
                match excluded.pop().filter(|&r| r < rows.len()) {
                    Some(last) => {
                        rows.remove(last);
                        continue;
                    }
                    None => return (None, report),
                }
            }
        };
        let wrong = violations(tmesh, &x);
        report.violated = wrong.len();
        if wrong.is_empty() {
            return (Some(x), report);
        }
        let before = rows.len();
        for row in wrong {
            match rows.iter_mut().find(|r| r.form == row.form) {
                Some(known) if known.value < row.value => known.value = row.value,
                Some(_) => {}
                None => rows.push(row),
            }
        }
        if rows.len() == before && report.rounds > 2 {
            break;
        }
    }
    (None, report)
}

/// Lengths that have to be prescribed: reversed arcs first, then one arc of each path that collapsed.
pub fn violations(tmesh: &TMesh, x: &[f64]) -> Vec<Separation> {
    let length: Vec<f64> = tmesh.arcs.iter().map(|a| evaluate(&a.form, x)).collect();
    let mut wrong: Vec<Separation> = Vec::new();
    for (arc, &now) in tmesh.arcs.iter().zip(&length) {
        if now < -0.5 {
            wrong.push(Separation { form: arc.form.clone(), value: arc.length.round().max(0.0) });
        }
    }
    if !wrong.is_empty() {
        return wrong;
    }
    // Along features, junctions may coincide with each other but corners may not; elsewhere no two pinned nodes may.
    let vertices = tmesh.vertex_nodes();
    collapsed(tmesh, &length, |arc| !arc.on_feature, |n| tmesh.pinned[n], &mut wrong);
    collapsed(tmesh, &length, |_| true, |n| n < vertices, &mut wrong);
    wrong
}

/// Breadth-first over zero arcs from each pinned node; a path to another one yields its longest arc, to become 1.
fn collapsed(
    tmesh: &TMesh,
    length: &[f64],
    counts: impl Fn(&Arc) -> bool,
    pinned: impl Fn(usize) -> bool,
    wrong: &mut Vec<Separation>,
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
                // Walk back to the root and prescribe the longest arc of the path.
                let (mut longest, mut k) = (i as usize, m);
                while through[k] != u32::MAX {
                    let j = through[k] as usize;
                    if tmesh.arcs[j].length > tmesh.arcs[longest].length {
                        longest = j;
                    }
                    k = if tmesh.arcs[j].to as usize == k { tmesh.arcs[j].from } else { tmesh.arcs[j].to } as usize;
                    if k == root {
                        break;
                    }
                }
                wrong.push(Separation { form: tmesh.arcs[longest].form.clone(), value: 1.0 });
                // The other pinned node keeps its own search.
                owner[m] = u32::MAX;
                through[m] = u32::MAX;
            }
        }
    }
    wrong.dedup();
}
