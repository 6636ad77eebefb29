//! What goes to stderr while a command runs: notes, warnings, progress.
//!
//! In: the run's arguments. Out: [`Console`]. Holds: errors are printed by `main` whatever is asked for here.

use crate::args::{ProgressArg, RunArgs};
use indicatif::{ProgressBar, ProgressStyle};
use quadloom::{Progress, Warning};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Warnings of one kind that are printed one by one; the rest are counted.
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

    /// Prints warnings.
    pub fn warnings(&self, warnings: &[Warning]) {
        for warning in warnings.iter().take(WARNINGS_SHOWN) {
            self.note(&format!("warning: {}", warning.message));
        }
        if warnings.len() > WARNINGS_SHOWN {
            self.note(&format!("warning: and {} more; --report has them all", warnings.len() - WARNINGS_SHOWN));
        }
    }

    fn line(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| eprintln!("{text}")),
            None => eprintln!("{text}"),
        }
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
