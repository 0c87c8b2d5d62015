//! Bristles of the LuGre friction model (Canudas de Wit, Olsson, Åström and Lischinsky 1995), along
//! each run.
//!
//! ```text
//! z' = v − σ0 |v| z / g(v)
//! F  = σ0 z + σ1 z' + σ2 v,   g(v) = Fc + (Fs − Fc) exp(−(v/vs)²)
//! ```
//!
//! The share ζ = σ0 z/g of the steady friction that the bristles carry obeys ζ' = (v − |v| ζ)/d
//! with the deflection d = g/σ0 at which they slip, as long as g changes more slowly than they
//! bend. Without viscous friction F = g(v) y, with y = ζ + T ζ' and T = σ1/σ0: linear in Fc and Fs,
//! and y is known before them.
//!
//! Neither d nor T shows at the period of a log: they are as published in 1995, σ0 = 10⁵ N/m and σ1
//! = √10⁵ N s/m beside Fc = 1 N. Chosen here: d is taken at Fc, and constant. A wheel that creeps
//! to and fro at 0.01 rad/s, with Fs of 1.5 Fc, is there 0.07 Fs on average and 0.3 Fs at most from
//! bristles whose d follows g (`tests/reference/baselines/friction.py`).

use super::term::{Bristles, rigid};
use crate::baselines::point::Point;

/// d = Fc/σ0, m.
pub(super) const SLIP_DEFLECTION_M: f64 = 1e-5;
/// T = σ1/σ0 = 1/√10⁵ s.
pub(super) const DAMPING_TIME_S: f64 = 3.162_277_660_168_38e-3;

/// y of each wheel at each point; NaN where a speed is.
///
/// With the speed constant from one point to the next, ζ is an exponential: exact and stable
/// however long the step is beside its time constant d/|v|, and ζ' is the mean of the step. A run
/// begins with bristles that are fully bent.
pub(super) fn shares(points: &[Point], wheel_radius_m: f64) -> Vec<Bristles> {
    let mut carried = Bristles::default();
    let mut last: Option<&Point> = None;
    let mut all = Vec::with_capacity(points.len());
    for point in points {
        let mut shares = rigid(&point.wheels);
        let elapsed = last.filter(|last| last.run == point.run).map(|last| point.time - last.time);
        if let Some(elapsed) = elapsed.filter(|elapsed| *elapsed > 0.0) {
            for ((share, state), wheel) in shares.iter_mut().zip(&mut carried).zip(point.wheels.iter()) {
                let before = if state.is_finite() { *state } else { wheel.direction };
                let slips = wheel.speed.abs() * wheel_radius_m * elapsed / SLIP_DEFLECTION_M;
                *state = wheel.direction + (before - wheel.direction) * (-slips).exp();
                *share = *state + DAMPING_TIME_S * (*state - before) / elapsed;
            }
        } else {
            carried = shares;
        }
        all.push(shares);
        last = Some(point);
    }
    all
}
