//! The change detector on synthetic surprises: no false alarms, short delays, the date of the
//! change.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{Ar1, Rng};
use model_core::payload::change::{Cusum, Threshold};
use proptest::prelude::*;

fn detector() -> Cusum<f64> {
    Cusum::new(Threshold::default())
}

/// With k = 1 and h = 10 one alarm in 10⁸ buckets is expected, one in a few 10⁵ where the fit took
/// the noise for 1/1.4 of what it is (k' = 0.71, h' = 7.1: e^(2·0.71·7.1)/(2·0.71²) = 24 000 by the
/// formula, which is low).
#[test]
fn no_false_alarm_on_noise() {
    for seed in 0..40 {
        let mut rng = Rng::new(seed);
        let mut detector = detector();
        assert_eq!((0..50_000).find_map(|_| detector.push(rng.normal())), None, "seed {seed}");
    }
}

/// Buckets that share some of their noise (correlation time of half a bucket) make none in hours
/// either.
#[test]
fn no_false_alarm_on_correlated_noise() {
    for seed in 0..40 {
        let mut rng = Rng::new(1000 + seed);
        let (mut noise, mut detector) = (Ar1::new(0.5, 1.0, &mut rng), detector());
        assert_eq!((0..20_000).find_map(|_| detector.push(noise.step(&mut rng))), None, "seed {seed}");
    }
}

/// A shift of δ gains δ − 1 a bucket, at most 7.5: 15 is passed after 15 / (δ − 1) buckets on
/// average, and the alarm dates the change to within the few buckets in which noise hides it.
#[test]
fn shifts_are_noticed_and_dated() {
    for shift in [3.0, -3.0, 5.0, -5.0, 50.0] {
        let (mut delays, mut errors, mut worst) = (0.0, 0.0, 0_usize);
        for seed in 0..200 {
            let mut rng = Rng::new(seed);
            let mut detector = detector();
            for _ in 0..100 {
                assert_eq!(detector.push(rng.normal()), None);
            }
            let (delay, ago) =
                (1..).find_map(|n| detector.push(shift + rng.normal()).map(|ago| (n as usize, ago))).unwrap();
            delays += delay as f64 / 200.0;
            errors += ago.abs_diff(delay) as f64 / 200.0;
            worst = worst.max(delay);
        }
        // The sum passes the level by part of a step.
        let expected = 15.0 / (f64::abs(shift) - 1.0).min(7.5) + 1.0;
        assert!(delays <= expected + 0.5 && worst as f64 <= 3.0 * expected, "{shift}: {delays} {worst}");
        assert!(errors < 0.5, "{shift}: dated {errors} buckets off");
    }
}

/// Nothing that is not a number disturbs for longer than itself.
#[test]
fn not_a_number_is_no_change() {
    let mut detector = detector();
    for _ in 0..100 {
        assert_eq!(detector.push(f64::NAN), None);
    }
    assert_eq!(detector.push(f64::INFINITY), None);
    assert_eq!(detector.push(f64::NEG_INFINITY), None);
    assert!((0..4).any(|_| detector.push(6.0).is_some()));
}

proptest! {
    /// Heavier and lighter are mirror images.
    #[test]
    fn both_sides_are_alike(surprises in proptest::collection::vec(-8.0..8.0_f64, 0..200)) {
        let (mut up, mut down) = (detector(), detector());
        for surprise in surprises {
            prop_assert_eq!(up.push(surprise), down.push(-surprise));
        }
    }

    /// The alarm comes where the textbook's two sums pass the level, and reset starts from nothing.
    #[test]
    fn is_the_textbook_cusum(surprises in proptest::collection::vec(-5.0..6.0_f64, 0..300)) {
        let mut detector = detector();
        let (mut high, mut low) = (0.0_f64, 0.0_f64);
        for (i, surprise) in surprises.into_iter().enumerate() {
            if i % 37 == 36 {
                detector.reset();
                (high, low) = (0.0, 0.0);
            }
            high = (high + surprise - 1.0).max(0.0);
            low = (low - surprise - 1.0).max(0.0);
            let alarm = high > 15.0 || low > 15.0;
            prop_assert_eq!(detector.push(surprise).is_some(), alarm);
            if alarm {
                (high, low) = (0.0, 0.0);
            }
        }
    }
}
