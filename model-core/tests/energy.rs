//! The integral of the power, of either sign.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use model_core::energy::Energy;
use proptest::prelude::*;

/// A sine of 2 W about 1 W over whole periods, by its half waves: what comes back is taken off.
#[test]
fn half_waves_of_a_sine() {
    let (period, seconds) = (0.001, 10);
    let sine = |i| 2.0 * (std::f64::consts::TAU * (f64::from(i) + 0.5) * period).sin();
    for (offset, least, expected) in [
        (1.0, f64::NEG_INFINITY, f64::from(seconds)),
        (0.0, 0.0, 2.0 * f64::from(seconds) / std::f64::consts::PI),
    ] {
        let mut energy = Energy::<f64>::default();
        for i in 0..seconds * 1000 {
            energy.add(least.max(offset + sine(i)), period);
        }
        // The midpoint rule errs by (2π dt)²/24.
        assert!((energy.joules() / expected - 1.0).abs() < 2e-6, "{} {expected}", energy.joules());
    }
}

proptest! {
    /// In single precision the sum is that of double precision to a few ε, however many terms:
    /// Kahan's bound is 2 ε + O(n ε²) of the terms' sizes, and each term is rounded once.
    #[test]
    fn single_precision_is_enough(terms in proptest::collection::vec((-50_000..500_000_i32, 1_000..20_000_i32), 1..3000)) {
        let mut energy = Energy::<f32>::default();
        let (mut expected, mut sizes) = (0.0, 0.0);
        // Of 0.1 mW and µs: proptest's own ranges of f32 fail an assertion of theirs now and then.
        for (power, duration) in terms {
            let (power, duration) = (power as f32 * 1e-4, duration as f32 * 1e-6);
            energy.add(power, duration);
            expected += f64::from(power) * f64::from(duration);
            sizes += f64::from(power.abs()) * f64::from(duration);
        }
        let joules = f64::from(energy.joules());
        prop_assert!((joules - expected).abs() <= 4.0 * f64::from(f32::EPSILON) * sizes, "{} {}", joules, expected);
    }

    /// It does not fall while power is drawn, and is never lost, whatever comes.
    #[test]
    fn never_falls(terms in proptest::collection::vec((any::<f32>(), any::<f32>()), 0..100)) {
        let mut energy = Energy::<f32>::default();
        for (power, duration) in terms {
            let before = energy.joules();
            energy.add(power.clamp(0.0, 1e15), duration.clamp(-1e15, 1e15));
            // What is owed may come back: the last digit, no more.
            prop_assert!(energy.joules() >= before * (1.0 - f32::EPSILON), "{} {}", before, energy.joules());
        }
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let before = energy.joules();
            energy.add(bad, 1.0);
            energy.add(1.0, bad);
            prop_assert_eq!(energy.joules(), before);
        }
    }
}
