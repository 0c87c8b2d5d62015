//! The delay of the power after the speeds, chosen from the training logs by a rule that belongs to
//! no model.
//!
//! For every delay on a grid, the power is regressed on all products of up to two of speed, turn
//! rate, their derivatives along the path and the mass. The shortest delay whose error is at most a
//! hundredth above the least is taken for every model.

use crate::baselines::Point;
use crate::baselines::regression::{least_squares, weigh};

/// The longest delay that is tried, s: no sensor or drive has a longer one.
const LONGEST_S: f64 = 0.5;

/// Steps are no shorter than this, s.
const STEP_S: f64 = 0.05;

/// An error within this share of the least is as good.
const AS_GOOD: f64 = 0.01;

/// Points that take part, evenly over the whole.
const MOST_POINTS: usize = 20_000;

/// The delay of the power after the motion, s.
pub(super) fn choose(points: &[Point]) -> f64 {
    let periods = points.windows(2).filter(|pair| pair[0].run == pair[1].run);
    let period_s = periods.map(|pair| pair[1].time - pair[0].time).find(|period| *period > 0.0);
    let Some(period_s) = period_s else { return 0.0 };
    let stride = (STEP_S / period_s).round().max(1.0) as usize;
    let most = (LONGEST_S / period_s).round() as usize;
    let shifts: Vec<usize> = (0..=most).step_by(stride).collect();
    let errors: Vec<f64> = shifts.iter().map(|shift| error(points, *shift, most)).collect();
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    let place = errors.iter().position(|error| *error <= (1.0 + AS_GOOD) * least).unwrap_or(0);
    shifts[place] as f64 * period_s
}

/// RMS residual of the regression with the power of `shift` points later, over the points that have
/// one `most` later.
fn error(points: &[Point], shift: usize, most: usize) -> f64 {
    let thinned = points.len().div_ceil(MOST_POINTS).max(1);
    let within = |&index: &usize| points[index].run == points[index + most].run;
    let rows: Vec<_> = (0..points.len().saturating_sub(most))
        .step_by(thinned)
        .filter(within)
        .map(|index| (terms(&points[index]), points[index + shift].power))
        .filter(|(terms, power)| power.is_finite() && terms.iter().all(|term| term.is_finite()))
        .collect();
    let Some(coefficients) = least_squares(&rows) else { return f64::INFINITY };
    let squares: f64 = rows.iter().map(|(terms, power)| (power - weigh(terms, &coefficients)).powi(2)).sum();
    (squares / rows.len() as f64).sqrt()
}

/// Quantities of a point that its power may depend on.
const QUANTITIES: usize = 5;

/// 1, each quantity, and each product of two.
const TERMS: usize = 1 + QUANTITIES + QUANTITIES * (QUANTITIES + 1) / 2;

fn terms(point: &Point) -> [f64; TERMS] {
    let (speed, rate) = (point.speed, point.acceleration);
    let along = |speed: f64, rate: f64| if speed == 0.0 { 0.0 } else { rate * speed.signum() };
    let quantities = [
        point.path_speed(),
        speed.omega.abs(),
        along(speed.vx, rate.vx) + along(speed.vy, rate.vy),
        along(speed.omega, rate.omega),
        point.mass,
    ];
    let mut terms = [1.0; TERMS];
    terms[1..=QUANTITIES].copy_from_slice(&quantities);
    let products = (0..QUANTITIES).flat_map(|i| (i..QUANTITIES).map(move |j| (i, j)));
    for (term, (i, j)) in terms[QUANTITIES + 1..].iter_mut().zip(products) {
        *term = quantities[i] * quantities[j];
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::choose;
    use crate::baselines::Point;
    use crate::baselines::testing::{PERIOD_S, drive};

    /// Power delayed by so many points, with a sensor's scatter.
    fn late(points: usize) -> Vec<Point> {
        let now =
            |point: &Point| 1.0 + 4.0 * point.speed.vx.abs() * point.mass + 0.3 * point.speed.omega.abs();
        let mut drive = drive(4000, now);
        let powers: Vec<f64> = drive.iter().map(|point| point.power).collect();
        for (index, point) in drive.iter_mut().enumerate() {
            point.power = powers[index.saturating_sub(points)] + 0.02 * (7919.0 * point.time).sin();
        }
        drive
    }

    #[test]
    fn finds_the_delay_and_none_where_there_is_none() {
        assert_eq!(choose(&late(0)), 0.0);
        assert!((choose(&late(5)) - 5.0 * PERIOD_S).abs() < 1e-9);
        assert_eq!(choose(&[]), 0.0);
    }
}
