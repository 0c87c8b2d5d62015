//! Time comes in as µs since start; physics wants s.

/// Of a difference of times: exact to single precision.
pub(crate) fn seconds(microseconds: u64) -> f32 {
    // The core has an instruction for 32 bits; for 64 it takes a routine, with the same result.
    u32::try_from(microseconds).map_or(microseconds as f32, |short| short as f32) * 1e-6
}
