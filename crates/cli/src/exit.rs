//! Exit codes.
//!
//! ```text
//! 0 done   2 wrong usage   3 file unreadable, unwritable or empty   4 input rejected   5 no valid result
//! 6 valid, but a request was missed (the result is kept)   7 time limit   130 cancelled
//! ```

use quadloom::FailureKind;
use std::process::ExitCode;

/// Everything that was asked for.
pub const DONE: u8 = 0;
/// Wrong usage.
pub const USAGE: u8 = 2;
/// A file cannot be read or written, or holds nothing.
pub const FILE: u8 = 3;
/// The input is not a surface, or a mesh did not pass its check.
pub const REJECTED: u8 = 4;
/// No valid result.
pub const NO_RESULT: u8 = 5;
/// A valid result that misses a request.
pub const MISSED: u8 = 6;
/// Time limit.
pub const LIMIT: u8 = 7;
/// Interrupted.
pub const CANCELLED: u8 = 130;

/// The code of a failure.
pub fn of_failure(kind: FailureKind) -> ExitCode {
    ExitCode::from(match kind {
        FailureKind::Usage => USAGE,
        FailureKind::Unreadable => FILE,
        FailureKind::Rejected => REJECTED,
        FailureKind::NoResult => NO_RESULT,
        FailureKind::Limit => LIMIT,
        FailureKind::Cancelled => CANCELLED,
    })
}
