//! What goes to stderr while a command runs: notes, warnings, progress.
//!
//! In: the run's arguments. Out: [`Console`]. Holds: errors are printed by `main` whatever is asked for here.

use crate::args::{ProgressArg, RunArgs};
use indicatif::{ProgressBar, ProgressStyle};
use quadloom::{Progress, Warning};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Warnings that are printed one by one, and as many more as miss a request; the rest are counted.
const WARNINGS_SHOWN: usize = 8;

/// Notes and progress of one run.
pub struct Console {
    quiet: bool,
    bar: Option<ProgressBar>,
}

impl Console {
    /// Sets up what the arguments ask for, and lets `progress` report there.
    pub fn new(run: &RunArgs, progress: Progress) -> (Self, Progress) {
        let default = if std::io::stderr().is_terminal() { ProgressArg::Bar } else { ProgressArg::None };
        let kind = run.progress.unwrap_or(default);
        match kind {
            ProgressArg::Bar if !run.quiet => {
                let bar = ProgressBar::new(100);
                let style = ProgressStyle::with_template("{msg:<18} {bar:30} {elapsed}");
                bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
                bar.enable_steady_tick(Duration::from_millis(100));
                let shown = bar.clone();
                let progress = progress.with_sink(Box::new(move |stage, fraction| {
                    shown.set_message(stage.to_string());
                    shown.set_position((100.0 * fraction) as u64);
                }));
                (Self { quiet: false, bar: Some(bar) }, progress)
            }
            ProgressArg::Json => {
                let begin = Instant::now();
                let progress = progress.with_sink(Box::new(move |stage, fraction| {
                    let seconds = begin.elapsed().as_secs_f64();
                    let line = serde_json::json!({ "stage": stage, "fraction": fraction, "seconds": seconds });
                    eprintln!("{line}");
                }));
                (Self { quiet: run.quiet, bar: None }, progress)
            }
            _ => (Self { quiet: run.quiet, bar: None }, progress),
        }
    }

    /// Prints a line that is not an error.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            self.line(text);
        }
    }

    /// Prints warnings, those first that matter most; those that miss a request, which the exit code tells of, all.
    pub fn warnings(&self, warnings: &[Warning]) {
        let (shown, hidden) = most_important(warnings);
        for warning in shown {
            self.note(&format!("warning: {}", warning.message));
        }
        if hidden > 0 {
            self.note(&format!("warning: and {hidden} more; --report has them all"));
        }
    }

    fn line(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| eprintln!("{text}")),
            None => eprintln!("{text}"),
        }
    }
}

/// The warnings to be printed, in order, and the number of the others.
fn most_important(warnings: &[Warning]) -> (Vec<&Warning>, usize) {
    let mut sorted: Vec<&Warning> = warnings.iter().collect();
    // The order of the run stays among equals.
    sorted.sort_by_key(|w| w.code.rank());
    let missing = sorted.iter().filter(|w| w.misses_request()).count();
    sorted.truncate(missing.max(WARNINGS_SHOWN));
    let hidden = warnings.len() - sorted.len();
    (sorted, hidden)
}

impl Drop for Console {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom::WarningCode::{self, CountMissed, Repaired, Retried, SharpEdgesDropped, TrianglesSplit};

    fn shown(codes: &[WarningCode]) -> (Vec<WarningCode>, usize) {
        let warnings: Vec<Warning> = codes.iter().map(|&code| Warning::new(code, "")).collect();
        let (shown, hidden) = most_important(&warnings);
        (shown.iter().map(|w| w.code).collect(), hidden)
    }

    #[test]
    fn a_cause_of_the_exit_code_is_never_hidden() {
        // Behind many of little weight.
        let behind = [[Retried; 9].as_slice(), &[Repaired, SharpEdgesDropped, CountMissed]].concat();
        let (codes, hidden) = shown(&behind);
        assert_eq!(codes[..4], [CountMissed, SharpEdgesDropped, Repaired, Retried]);
        assert_eq!((codes.len(), hidden), (WARNINGS_SHOWN, 4));
        // Many of them.
        let (codes, hidden) = shown(&[[Retried; 5].as_slice(), &[TrianglesSplit; 20]].concat());
        assert_eq!((codes.len(), hidden), (20, 5));
        assert!(codes.iter().all(|c| *c == TrianglesSplit));
        assert_eq!(shown(&[Retried; 3]), (vec![Retried; 3], 0));
    }
}
