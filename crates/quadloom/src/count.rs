//! Reaching a number of quads by correcting the size.
//!
//! In: a count, a tolerance, a first size, and a function that solves for a size and counts. Out: the best solution.
//! Holds: the function is called at most a given number of times. Not: that the count is reached; integers make the
//! count jump.

/// How a count is to be reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CountGoal {
    /// Number of quads.
    pub quads: f64,
    /// Relative deviation at which no further correction is made.
    pub tolerance: f64,
    /// Largest number of solves.
    pub solves: usize,
}

/// One solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried<T> {
    /// The solution.
    pub solution: T,
    /// Its count.
    pub quads: f64,
    /// What is wrong with it; 0 is a sound solution.
    pub flaws: usize,
}

/// The best solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted<T> {
    /// What the function returned for it.
    pub solution: T,
    /// Its count.
    pub quads: f64,
    /// Its size.
    pub size: f64,
    /// Solves made.
    pub solves: usize,
}

/// Solutions with flaws after which no further size is tried: they cost most, and another count seldom cures them.
const MOST_FLAWED: usize = 2;

/// Solves at a size, then at corrected sizes until the count is near enough.
///
/// The count is inversely proportional to the squared size, so the first correction is that power law; the
/// following ones are secants of the logarithms, kept within a factor of two of the power law.
///
/// # Input      size: first edge length, any unit; solve: a size to a solution; `None` where it fails
/// # Output     of the solutions within the tolerance the one with the fewest flaws, if there is one; else the one
/// with the fewest flaws and then the nearest count; `None` if the first solve fails
/// # Errors     the first error of `solve`
pub fn fit_count<T, E>(
    goal: CountGoal,
    size: f64,
    mut solve: impl FnMut(f64) -> Result<Option<Tried<T>>, E>,
) -> Result<Option<Fitted<T>>, E> {
    let mut tried: Vec<(f64, f64)> = Vec::new();
    let mut best: Option<Fitted<T>> = None;
    let mut best_rank: Option<(bool, usize, f64)> = None;
    let mut size = size;
    let (mut solves, mut flawed) = (0, 0);
    while solves < goal.solves.max(1) {
        solves += 1;
        let Some(Tried { solution, quads, flaws }) = solve(size)? else { break };
        let near = (quads - goal.quads).abs() <= goal.tolerance * goal.quads;
        let rank = (!near, flaws, (quads.max(1.0) / goal.quads).ln().abs());
        if best_rank.is_none_or(|b| rank < b) {
            (best, best_rank) = (Some(Fitted { solution, quads, size, solves }), Some(rank));
        }
        flawed += usize::from(flaws > 0);
        if near || flawed >= MOST_FLAWED {
            break;
        }
        tried.push((size.ln(), (quads.max(1.0) / goal.quads).ln()));
        size = corrected(&tried);
    }
    if let Some(best) = &mut best {
        best.solves = solves;
    }
    Ok(best)
}

/// The next size, from pairs of logarithms of size and of relative count.
fn corrected(tried: &[(f64, f64)]) -> f64 {
    const POWER: f64 = -2.0;
    let &[.., (x, y)] = tried else { return 1.0 };
    let slope = match tried {
        &[.., (x0, y0), _] if (x - x0).abs() > 1e-9 => ((y - y0) / (x - x0)).clamp(2.0 * POWER, 0.5 * POWER),
        _ => POWER,
    };
    (x - y / slope).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn goal(quads: f64) -> CountGoal {
        CountGoal { quads, tolerance: 0.02, solves: 4 }
    }

    fn made(solution: f64, quads: f64) -> Result<Option<Tried<f64>>, ()> {
        Ok(Some(Tried { solution, quads, flaws: 0 }))
    }

    #[test]
    fn a_sound_solution_off_the_count_beats_a_flawed_one_off_the_count() {
        let law = |size: f64| Ok::<_, ()>(Some(Tried { solution: size, quads: 500.0, flaws: usize::from(size < 1.0) }));
        let fitted = fit_count(goal(1000.0), 1.0, law).expect("no error").expect("a solution");
        assert_eq!(fitted.size, 1.0);
    }

    #[test]
    fn a_power_law_is_met_by_one_correction() {
        let law = |size: f64| made(size, 730.0 / (size * size));
        let fitted = fit_count(goal(1000.0), 1.0, law).expect("no error").expect("a solution");
        assert_eq!(fitted.solves, 2);
        assert!((fitted.quads - 1000.0).abs() < 1e-6);
    }

    #[test]
    fn a_count_that_falls_short_of_the_law_is_met_by_secants() {
        let law = |size: f64| made(size, (700.0 / size.powf(1.4) - 40.0).floor());
        let fitted = fit_count(goal(1000.0), 1.0, law).expect("no error").expect("a solution");
        assert!((fitted.quads - 1000.0).abs() <= 20.0, "{fitted:?}");
    }

    #[test]
    fn the_nearest_solution_is_kept_where_no_size_gives_the_count() {
        let stuck = |size: f64| made(size, if size > 0.5 { 600.0 } else { 2400.0 });
        let fitted = fit_count(goal(1000.0), 1.0, stuck).expect("no error").expect("a solution");
        assert_eq!((fitted.quads, fitted.solves), (600.0, 4));
    }

    #[test]
    fn a_failing_correction_keeps_what_there_is() {
        let fragile = |size: f64| if size >= 1.0 { made(size, 700.0) } else { Ok(None) };
        let fitted = fit_count(goal(1000.0), 1.0, fragile).expect("no error").expect("a solution");
        assert_eq!((fitted.quads, fitted.size), (700.0, 1.0));
        assert_eq!(fit_count(goal(1.0), 0.1, fragile), Ok(None));
        assert_eq!(fit_count(goal(1.0), 0.1, |_| Err::<Option<Tried<()>>, _>("no")), Err("no"));
    }
}
