//! The library behind `gmr`: logs, the simulated plant, fits, baselines and reports.
//!
//! What the board computes as well (filters, models, payload estimators) is not here but in
//! `model-core`.

/// As std's, but without a panic where standard output is closed: `cli::run` ends with what went
/// wrong.
macro_rules! println {
    ($($text:tt)*) => { support::output::print(format_args!("{}\n", format_args!($($text)*))) };
}

/// As std's, but without a panic where standard error is closed: there is nobody left to tell.
macro_rules! eprintln {
    ($($text:tt)*) => { support::output::say(format_args!($($text)*)) };
}

pub mod cli;
