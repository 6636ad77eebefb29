//! How a long computation reports where it is and learns that it should stop.
//!
//! In: a callback of the caller. Out: [`Progress`], a small value passed by reference to every stage.
//! Holds: a stage that sees [`Progress::cancelled`] returns early with its own `Cancelled` error and
//! leaves nothing half-made. Asking is cheap: an atomic load and a clock read. Effort is counted, not timed, so that
//! decisions by it are the same on any machine and for any number of threads.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Receives a stage's name and the finished fraction of it, in 0..=1.
pub type ProgressSink = Box<dyn FnMut(&str, f64) + Send>;

/// Cancellation flag, time limit, progress callback and effort of one run; clones share all four.
#[derive(Clone, Default)]
pub struct Progress {
    flag: Arc<AtomicBool>,
    deadline: Option<Instant>,
    sink: Option<Arc<Mutex<ProgressSink>>>,
    effort: Arc<AtomicU64>,
}

/// The run was asked to stop, by its caller or by its time limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{}", if *.time_limit { "the time limit was reached" } else { "cancelled" })]
pub struct Cancelled {
    /// True where the time limit, and not the caller, stopped the run.
    pub time_limit: bool,
}

impl Progress {
    /// Never stops and reports to nobody.
    pub fn none() -> Self {
        Self::default()
    }

    /// Stops when `flag` becomes true.
    pub fn with_flag(mut self, flag: Arc<AtomicBool>) -> Self {
        self.flag = flag;
        self
    }

    /// Stops `limit` from now.
    pub fn with_time_limit(mut self, limit: Duration) -> Self {
        // A limit beyond what the clock can tell is none.
        self.deadline = Instant::now().checked_add(limit);
        self
    }

    /// Reports stages to `sink`.
    pub fn with_sink(mut self, sink: ProgressSink) -> Self {
        self.sink = Some(Arc::new(Mutex::new(sink)));
        self
    }

    /// The same run, with an effort of its own that starts at 0.
    pub fn counting_anew(&self) -> Self {
        Self { effort: Arc::default(), ..self.clone() }
    }

    /// Adds to the effort: operations in whose number a stage's cost is linear, in units of about a microsecond.
    pub fn spend(&self, effort: usize) {
        self.effort.fetch_add(effort as u64, Ordering::Relaxed);
    }

    /// The effort so far. Deterministic where no other thread is at work on the same run.
    pub fn spent(&self) -> u64 {
        self.effort.load(Ordering::Relaxed)
    }

    /// Whether the run should stop now.
    pub fn cancelled(&self) -> bool {
        self.flag.load(Ordering::Relaxed) || self.deadline.is_some_and(|d| Instant::now() >= d)
    }

    /// `Err` if the run should stop now.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.flag.load(Ordering::Relaxed) {
            return Err(Cancelled { time_limit: false });
        }
        if self.deadline.is_some_and(|d| Instant::now() >= d) {
            return Err(Cancelled { time_limit: true });
        }
        Ok(())
    }

    /// Seconds left until the time limit; infinity without one.
    pub fn seconds_left(&self) -> f64 {
        self.deadline.map_or(f64::INFINITY, |d| d.saturating_duration_since(Instant::now()).as_secs_f64())
    }

    /// Says that `stage` is done to `fraction`, in 0..=1.
    pub fn report(&self, stage: &str, fraction: f64) {
        if let Some(sink) = &self.sink
            && let Ok(mut sink) = sink.lock()
        {
            sink(stage, fraction);
        }
    }
}

impl std::fmt::Debug for Progress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Progress").field("deadline", &self.deadline).finish_non_exhaustive()
    }
}
