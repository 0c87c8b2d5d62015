//! Law: a stated 95 % interval contains the true mass in about 95 % of windows.
//!
//! Power is exactly linear in the mass, so all that is tested is what the window makes of the
//! noise. The noise is AR(1) with correlation times from none to four buckets; the mass is anywhere
//! in the range.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{Ar1, Rng, range};
use model_core::model::Response;
use model_core::payload::window::{Sums, Window};
use model_core::payload::{MassEstimate, Method, Noise};
use model_core::polynomial::Polynomial;

const PERIOD: f64 = 0.02;
const PER_BUCKET: usize = 50;
const WINDOWS: usize = 1000;

/// dP/dm of a robot that drives trapezoids: rolling at constant speed, pulses when it speeds up,
/// and stops.
fn slope(time: f64) -> f64 {
    let phase = time % 7.3;
    if phase < 1.0 {
        0.15 * (0.3 + phase)
    } else if phase < 5.0 {
        0.08
    } else if phase < 5.6 {
        0.02
    } else {
        0.0
    }
}

struct Coverage {
    inside: f64,
    unknown: f64,
    /// Mean half-width over the estimate's true standard deviation.
    width: f64,
}

/// `beyond` standard deviations of a sample count linearly.
fn coverage(correlation: f64, seconds: usize, stated_over_true: f64, threshold: f64) -> Coverage {
    let range = range();
    let (mut inside, mut known) = (0, 0);
    let (mut squares, mut width) = (0.0, 0.0);
    for seed in 0..WINDOWS as u64 {
        let mut rng = Rng::new(seed.wrapping_mul(0x5851_f42d_4c95_7f2d) ^ (correlation * 1e6) as u64);
        let mut noise = Ar1::new(correlation, PERIOD, &mut rng);
        // The mass should come out to some 0.1 kg: σ²_m = S / Σ g² Δt.
        let sigma = 0.1 * (0.004 * seconds as f64 / noise.density(PERIOD)).sqrt();
        let window = Window {
            range,
            noise: Noise {
                density: sigma * sigma * noise.density(PERIOD) * stated_over_true,
                model_std: 0.0,
                tail: 1.0,
                residual_std: 0.0,
            },
            period: PERIOD,
            linear_beyond: threshold * sigma,
        };
        let mass = rng.uniform(1.0, 6.0);
        let start = rng.uniform(0.0, 7.3);
        let samples: Vec<(f64, Response<f64>)> = (0..seconds * PER_BUCKET)
            .map(|i| {
                let b = slope(start + i as f64 * PERIOD);
                let response = Response { polynomial: Polynomial { a: 0.0, b, c: 1.0 }, may_clamp: false };
                (1.0 + b * (mass - range.middle()) + sigma * noise.step(&mut rng), response)
            })
            .collect();
        let estimate_from = |known: f64| {
            let mut buckets = vec![Sums::default(); seconds];
            for (i, (power, response)) in samples.iter().enumerate() {
                window.add(&mut buckets[i / PER_BUCKET], *power, response, 1.0, known);
            }
            window.estimate(buckets.iter())
        };
        // All squared, then weighed by what that leaves.
        let mut estimate = estimate_from(f64::NAN);
        if let Some(first) = estimate.best().filter(|_| threshold.is_finite()) {
            estimate = estimate_from(first - range.middle());
        }
        if let MassEstimate::Known(estimate) = estimate {
            known += 1;
            inside += usize::from(estimate.low <= mass && mass <= estimate.high);
            squares += (estimate.mass - mass).powi(2);
            width += (estimate.high - estimate.low) / 2.0;
        }
    }
    let known_f = known as f64;
    Coverage {
        inside: inside as f64 / known_f,
        unknown: 1.0 - known_f / WINDOWS as f64,
        width: width / known_f / (squares / known_f).sqrt(),
    }
}

/// Runs every case and names those whose share of windows that contain the truth is not within
/// `bounds`.
fn check(stated_over_true: f64, bounds: impl Fn(usize, f64) -> (f64, f64)) {
    let mut wrong = String::new();
    for seconds in [5, 10, 25, 60, 300] {
        for correlation in [0.0, 0.05, 0.2, 0.5, 1.0, 2.0, 4.0] {
            let coverage = coverage(correlation, seconds, stated_over_true, f64::INFINITY);
            let (least, most) = bounds(seconds, correlation);
            let line = format!(
                "{seconds:3} s, correlation {correlation:4.2} s: {:.3} inside, {:.3} unknown, ±{:.2} σ\n",
                coverage.inside, coverage.unknown, coverage.width
            );
            print!("{line}");
            if coverage.inside < least || coverage.inside > most || coverage.unknown > 0.02 {
                wrong += &line;
            }
        }
    }
    assert!(wrong.is_empty(), "density stated {stated_over_true} of the truth:\n{wrong}");
}

/// 90 to 99 %, the test's own binomial scatter being 0.7 %. Two limits are known:
/// - five buckets say little of their own, and a prior worth six more makes them careful;
/// - an error that lasts four buckets outlasts the lags that are counted, and lasts most of a short
///   window.
#[test]
fn stated_density_is_right() {
    check(1.0, |seconds, correlation| match (seconds, correlation) {
        (5, _) => (0.93, 1.0),
        (10, 4.0) => (0.90, 1.0),
        (_, 4.0) => (0.84, 0.99),
        _ => (0.90, 0.99),
    });
}

/// The buckets' own scatter makes up for a fit that thought its noise half of what it is.
#[test]
fn stated_density_is_half_the_truth() {
    check(0.5, |_, correlation| if correlation < 4.0 { (0.85, 1.0) } else { (0.83, 1.0) });
}

/// Twice the truth widens.
#[test]
fn stated_density_is_twice_the_truth() {
    check(2.0, |_, correlation| if correlation < 4.0 { (0.92, 1.0) } else { (0.85, 1.0) });
}

/// Five times the noise of the fit: two samples of three lie beyond what it calls noise. By Huber
/// (1964) scores of such scatter are E ψ² = 0.17 σ² for E w = 0.71 of the information.
#[test]
fn far_more_noise_than_in_the_fit() {
    for seconds in [10, 25, 60, 300] {
        let Coverage { inside, unknown, width } = coverage(0.0, seconds, 0.17 / 0.71, 0.5);
        println!("{seconds} s: {inside:.3} inside, {unknown:.3} unknown, ±{width:.2} σ");
        assert!(inside > 0.9 && width < 2.6 && unknown < 0.02);
    }
}
