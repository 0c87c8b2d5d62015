//! Laws of the filter and of the conditioning of samples.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{Rng, coefficients};
use model_core::coefficients::Robot;
use model_core::conditioning::Conditioning;
use model_core::estimator::{Conditioned, Conditioner, Sample};
use model_core::filter::{Channel, LowPass};
use proptest::prelude::*;

const PERIOD: f64 = 0.005;

fn conditioner() -> Conditioner<f64, 2> {
    Conditioner::new(&coefficients().robot, PERIOD).unwrap()
}

fn sample(i: usize) -> Sample<f64, 2> {
    let time = i as f64 * PERIOD;
    Sample {
        wheel_speed: [3.0 * (1.3 * time).sin(), 2.0 + (0.7 * time).cos()],
        wheel_acceleration: None,
        power: 1.0 + (2.1 * time).sin(),
    }
}

fn bad_samples() -> Vec<Sample<f64, 2>> {
    let mut all = vec![];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        all.push(Sample { power: bad, ..sample(3) });
        all.push(Sample { wheel_speed: [1.0, bad], ..sample(3) });
        all.push(Sample { wheel_acceleration: Some([bad, 1.0]), ..sample(3) });
    }
    all
}

/// Samples that are not finite leave no trace: the others come out as if they had not been there.
#[test]
fn not_finite_leaves_the_state() {
    let (mut with, mut without) = (conditioner(), conditioner());
    for i in 0..500 {
        if i % 7 == 3 {
            for bad in bad_samples() {
                assert_eq!(with.push(&bad, PERIOD / 20.0), None);
            }
        }
        assert_eq!(with.push(&sample(i), PERIOD), without.push(&sample(i), PERIOD), "{i}");
    }
    let mut first = conditioner();
    assert_eq!(first.push(&bad_samples()[0], PERIOD), None);
    assert_eq!(first.push(&sample(0), PERIOD), conditioner().push(&sample(0), PERIOD));
}

fn outputs(conditioner: &mut Conditioner<f64, 2>) -> Vec<Option<Conditioned<f64, 2>>> {
    (900..1500).map(|i| conditioner.push(&sample(i), PERIOD)).collect()
}

/// Behind a gap, whatever tells of it, everything is as if the samples began there.
#[test]
fn gaps_start_anew() {
    let fresh = outputs(&mut conditioner());
    for elapsed in [1.0, 6.0 * PERIOD, 1e300, f64::INFINITY, f64::NAN, -PERIOD, -1e9] {
        let mut used = conditioner();
        for i in 0..400 {
            used.push(&sample(i), PERIOD);
        }
        let first = used.push(&sample(900), elapsed);
        assert_eq!(first, fresh[0], "{elapsed}");
        for i in 901..1500 {
            assert_eq!(used.push(&sample(i), PERIOD), fresh[i - 900], "{elapsed} {i}");
        }
    }
    // Seconds of nothing but NaN are a gap as well.
    let mut used = conditioner();
    for i in 0..400 {
        used.push(&sample(i), PERIOD);
    }
    for _ in 0..6 {
        used.push(&bad_samples()[0], PERIOD);
    }
    assert_eq!(outputs(&mut used), fresh);
    // Four late samples are none.
    let mut used = conditioner();
    for i in 0..400 {
        used.push(&sample(i), PERIOD);
    }
    assert!(used.push(&sample(400), 4.5 * PERIOD).unwrap().settled);
}

/// Settled is said after two periods of the cutoff: not sooner, not later.
#[test]
fn settles_after_two_periods_of_the_cutoff() {
    let out = outputs(&mut conditioner());
    let settled = out.iter().position(|out| out.unwrap().settled).unwrap();
    assert_eq!(settled, (2.0 / (2.0 * PERIOD)) as usize);
    assert!(out[settled..].iter().all(|out| out.unwrap().settled));
    let filter = LowPass::new(2.0, PERIOD).unwrap();
    let mut channel = Channel::default();
    filter.settle(&mut channel, 0.0);
    let step: Vec<f64> = (0..2000).map(|_| filter.step(&mut channel, 1.0).value).collect();
    let late = &step[filter.settling_samples() as usize..];
    assert!(late.iter().all(|value| (value - 1.0).abs() < 0.02));
}

/// Speed and power pass the same filter: equal inputs, equal outputs.
#[test]
fn power_and_speed_pass_alike() {
    let mut conditioner = conditioner();
    let mut rng = Rng::new(1);
    for _ in 0..1000 {
        let input = 5.0 + rng.normal();
        let sample = Sample { wheel_speed: [input; 2], wheel_acceleration: Some([input; 2]), power: input };
        let out = conditioner.push(&sample, PERIOD).unwrap();
        for wheel in out.motion.wheels {
            assert_eq!(wheel.speed, out.power);
            assert_eq!(wheel.acceleration, out.power);
        }
    }
}

#[test]
fn dead_band_puts_a_wheel_to_rest() {
    let mut conditioner = conditioner();
    let out =
        conditioner.push(&Sample { wheel_speed: [0.019, -0.021], wheel_acceleration: None, power: 0.0 }, 0.0);
    let [still, turning] = out.unwrap().motion.wheels;
    assert_eq!(still, Default::default());
    assert!(turning.direction == -1.0 && (turning.speed + 0.021).abs() < 1e-15);
}

proptest! {
    /// The filter is linear and does not care when it is used.
    #[test]
    fn filter_is_linear(
        inputs in proptest::collection::vec((-10.0..10.0_f64, -10.0..10.0_f64), 1..200), c in -3.0..3.0_f64,
    ) {
        let filter = LowPass::new(2.0, PERIOD).unwrap();
        let (mut x, mut y, mut sum) = (Channel::default(), Channel::default(), Channel::default());
        for (a, b) in inputs {
            let (x, y) = (filter.step(&mut x, a), filter.step(&mut y, b));
            let both = filter.step(&mut sum, a + c * b);
            // States are near the inputs; poles at 1 − k let some 1/k² = 1000 roundings live on.
            prop_assert!((both.value - (x.value + c * y.value)).abs() < 1e-12);
            // And the derivative multiplies by 2 k / T = 13/s.
            prop_assert!((both.derivative - (x.derivative + c * y.derivative)).abs() < 2e-11);
        }
    }

    /// A settled channel stays at its level.
    #[test]
    fn settled_is_steady(level in -1e3..1e3_f64, cutoff in 0.2..80.0_f64) {
        let filter = LowPass::new(cutoff, PERIOD).unwrap();
        let mut channel = Channel::default();
        filter.settle(&mut channel, level);
        for _ in 0..300 {
            let out = filter.step(&mut channel, level);
            // One rounding a step of a state near the level, amplified by 1/k² ≤ 1e5 at 0.2 Hz.
            prop_assert!((out.value - level).abs() <= 1e-10 * level.abs(), "{:?}", out);
            prop_assert!(out.derivative.abs() <= 1e-7 * level.abs(), "{:?}", out);
        }
    }
}

/// A delay of the power is taken out before the filter: a robot whose power comes later, or
/// earlier, is conditioned as one whose power comes at once, but for what the cubic through four
/// samples leaves (4 × 10⁻⁹ of these waves). Gaps start it anew.
#[test]
fn late_power_is_set_beside_its_speeds() {
    let at = |time: f64| [3.0 * (1.3 * time).sin(), 2.0 + (0.7 * time).cos(), 1.0 + (2.1 * time).sin()];
    for delay in [0.2345, -0.1017] {
        let conditioning = Conditioning { delay, ..Conditioning::PLAIN };
        let robot = Robot { conditioning, ..coefficients().robot };
        let (mut late, mut plain) = (Conditioner::new(&robot, PERIOD).unwrap(), conditioner());
        for i in 0..2600 {
            let time = f64::from(i) * PERIOD;
            let of = |speed, power| {
                let [left, right, _] = at(speed);
                let [_, _, power] = at(power);
                Sample { wheel_speed: [left, right], wheel_acceleration: None, power }
            };
            let elapsed = if i == 1200 { 9.0 } else { PERIOD };
            let aligned = late.push(&of(time, time - delay), elapsed).unwrap();
            let then = time - delay.max(0.0);
            let expected = plain.push(&of(then, then.min(time - delay)), elapsed).unwrap();
            // What was before the first sample and before the gap is not known to the one that has
            // to wait.
            let is_known = |from: i32| i > from + 1000 && (from > 0 || i < 1200);
            if is_known(0) || is_known(1200) {
                let error = (aligned.power - expected.power).abs();
                assert!(error < 1e-6, "{delay} {i}: {error}");
                for (one, other) in aligned.motion.wheels.iter().zip(&expected.motion.wheels) {
                    assert!((one.speed - other.speed).abs() < 1e-6, "{delay} {i}");
                    assert!((one.acceleration - other.acceleration).abs() < 1e-4, "{delay} {i}");
                }
            }
        }
    }
}
