//! Time comes in as µs since start; physics wants s.

/// Of a difference of times: exact to single precision.
pub(crate) fn seconds(microseconds: u64) -> f32 {
    microseconds as f32 * 1e-6
}
