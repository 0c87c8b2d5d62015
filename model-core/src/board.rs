//! The board's estimator, compiled with this crate: what is generic is compiled where it is used,
//! and the board's image is built for size, all but this crate, which is built for speed.

use crate::estimator::{Estimate, Estimator, Sample};
use crate::payload::window::Window;

/// Wheels of the board's robots.
pub const WHEELS: usize = 2;
/// Room for buckets. A gap that outlasts them forgets more than the window holds.
pub const BUCKETS: usize = 32;

/// Least squares over a window, in single precision.
pub type BoardEstimator = Estimator<f32, Window<f32>, WHEELS, BUCKETS>;

/// [`Estimator::push`].
// Inlined, it would be built as its caller is.
#[inline(never)]
pub fn push(
    estimator: &mut BoardEstimator,
    sample: &Sample<f32, WHEELS>,
    elapsed: f32,
) -> Estimate<f32, WHEELS> {
    estimator.push(sample, elapsed)
}
