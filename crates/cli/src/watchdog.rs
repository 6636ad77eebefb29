//! Ends the process in time: Ctrl-C and the time limit, even while a stage is busy.
//!
//! In: the time limit. Out: a flag that stages look at through [`Progress`]; if they do not look in time, the process ends.
//! Holds: the process ends within a second of either; never while an output file is being put in place.

use crate::exit;
use quadloom::Progress;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

/// What stages get to notice that they should stop.
const GRACE: Duration = Duration::from_millis(700);

/// Time limits beyond this are this, seconds: thirty years; clocks do not tell much longer ones.
const LONGEST_LIMIT: f64 = 1e9;

/// Held while files are written: renaming takes no time, but must not be cut in two.
static WRITING: Mutex<()> = Mutex::new(());

/// Keeps the process alive until the guard is dropped; outputs are written under it.
pub fn while_writing() -> MutexGuard<'static, ()> {
    WRITING.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Starts watching; the value tells stages when to stop.
pub fn start(time_limit: Option<f64>) -> Progress {
    let flag = Arc::new(AtomicBool::new(false));
    let progress = Progress::none().with_flag(flag.clone());
    // Without a handler Ctrl-C still ends the process, only less politely.
    let _ = ctrlc::set_handler(move || interrupted(&flag));
    let Some(seconds) = time_limit else { return progress };
    // What is no number of seconds has been refused as wrong usage.
    let limit = Duration::try_from_secs_f64(seconds.min(LONGEST_LIMIT)).unwrap_or_default();
    std::thread::spawn(move || {
        std::thread::sleep(limit.saturating_add(GRACE));
        end(exit::LIMIT, &format!("the time limit of {seconds} s was reached; nothing was written"));
    });
    progress.with_time_limit(limit)
}

fn interrupted(flag: &AtomicBool) {
    if flag.swap(true, Ordering::SeqCst) {
        // Asked twice.
        end(exit::CANCELLED, "cancelled; nothing was written");
    }
    std::thread::spawn(|| {
        std::thread::sleep(GRACE);
        end(exit::CANCELLED, "cancelled; nothing was written");
    });
}

fn end(code: u8, message: &str) {
    let _writing = while_writing();
    eprintln!("error: {message}");
    std::process::exit(i32::from(code));
}
