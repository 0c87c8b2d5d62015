//! What is true of the fleet.

/// Robots that change: which, from which day (from 1), by which effect, and the coefficients that
/// are a right name for it.
pub(super) const CHANGED: [(usize, usize, &str, &[&str]); 3] = [
    (17, 3, "wheel-drag=0.02", &["coulomb of the left wheels"]),
    (101, 4, "viscous-change=0.5", &["viscous"]),
    (160, 2, "rolling-resistance-change=0.01", &["rolling"]),
];
