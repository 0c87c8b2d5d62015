//! Law: a robot that brakes hard, its wheels clamped, has the mass that it has.
//!
//! Its power is made of the speeds as they are; the estimator sees both after its filter, where
//! the clamp is smeared.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

mod common;

use common::{burger, coefficients};
use model_core::coefficients::{Coefficients, Robot};
use model_core::estimator::{Estimator, Sample, Timing};
use model_core::motion::Motion;
use model_core::payload::schedule::Schedule;
use model_core::payload::window::Window;

const PERIOD: f64 = 0.005;
const SECONDS: usize = 60;

fn robot() -> Coefficients<f64, 2> {
    let base = coefficients();
    Coefficients { robot: Robot { cutoff_hz: 4.0, ..base.robot }, ..base }
}

/// Forward and back by turns, at other speeds each time: ramps of 0.3 s, then 0.4 to 0.9 s as fast
/// as that. Speed (rad/s) and acceleration (rad/s²) of both wheels.
fn jerky(time: f64) -> (f64, f64) {
    const RAMP_S: f64 = 0.3;
    let top = |leg: usize| (if leg.is_multiple_of(2) { 1.0 } else { -1.0 }) * (2.0 + (leg * 7 % 5) as f64);
    let (mut leg, mut start, mut from) = (0, 0.0, 0.0);
    loop {
        let hold_s = 0.4 + 0.1 * (leg * 3 % 6) as f64;
        if time < start + RAMP_S + hold_s {
            let share = ((time - start) / RAMP_S).min(1.0);
            let acceleration = if share < 1.0 { (top(leg) - from) / RAMP_S } else { 0.0 };
            return (from + share * (top(leg) - from), acceleration);
        }
        (start, from, leg) = (start + RAMP_S + hold_s, top(leg), leg + 1);
    }
}

/// Mean error of the mass in kg over the second half of the drive.
fn error(mass: f64, mut estimator: Estimator<f64, Window<f64>, 2, 32>) -> f64 {
    let (_, matrix) = burger();
    let (mut sum, mut count) = (0.0, 0.0);
    for row in 0..SECONDS * 200 {
        let time = row as f64 * PERIOD;
        let (speed, acceleration) = jerky(time);
        let motion = Motion::new(&[speed; 2], &[acceleration; 2], &matrix, 0.02);
        let power = robot().model.power(&motion, mass).unwrap();
        let sample = Sample { wheel_speed: [speed; 2], wheel_acceleration: None, power };
        let out = estimator.push(&sample, PERIOD);
        if time > SECONDS as f64 / 2.0 {
            sum += out.mass.known().map_or(f64::NAN, |known| known.mass) - mass;
            count += 1.0;
        }
    }
    sum / count
}

/// Within 2.5 %; where samples after a clamp count, 4 to 9 % are missing.
#[test]
fn hard_braking_costs_no_mass() {
    let timing = Timing {
        period_s: PERIOD,
        bucket_s: 1.0,
        schedule: Schedule::Moving { window: 25 },
        detect_changes: false,
    };
    let method = robot().window(PERIOD);
    for mass in [1.5, 3.0, 5.0] {
        let estimator = Estimator::<f64, _, 2, 32>::new(&robot(), method, &timing).unwrap();
        let error = error(mass, estimator);
        assert!(error.abs() < 0.025 * mass, "{mass} {error}");
    }
}
