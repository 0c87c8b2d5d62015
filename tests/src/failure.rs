//! Expectations. A broken one is reported at once, with its place in the source, and ends its test.

use core::fmt::Arguments;
use core::panic::Location;

use crate::say;

/// What a test returns.
pub type Outcome = Result<(), Failed>;

/// An expectation did not hold; the report is already written.
#[derive(Debug)]
pub struct Failed;

/// Fails with `message` unless `condition` holds.
///
/// # Errors
/// [`Failed`], reported with the caller's place.
#[track_caller]
pub fn ensure(condition: bool, message: Arguments<'_>) -> Outcome {
    if condition {
        return Ok(());
    }
    say!("FAILED\n    {}: {message}\n", Location::caller());
    Err(Failed)
}

/// Fails unless `found` is [`within`] `tolerance` of the f64 reference.
///
/// # Errors
/// [`Failed`], reported with the caller's place.
#[track_caller]
pub fn close(what: Arguments<'_>, found: impl Into<f64>, reference: f64, tolerance: f64) -> Outcome {
    let found = found.into();
    ensure(
        within(found, reference, tolerance),
        format_args!("{what}: found {found:e}, reference {reference:e}, allowed difference {tolerance:e}"),
    )
}

/// Whether two numbers differ by at most `tolerance` (absolute, same unit). NaN is near nothing.
#[must_use]
pub fn within(found: f64, reference: f64, tolerance: f64) -> bool {
    (found - reference).abs() <= tolerance
}
