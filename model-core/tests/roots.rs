//! The paper's estimator against Eq. 24 to 26 written out over a `Vec` of samples.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{Rng, burger, range, servo};
use model_core::eq18::{self, Gate};
use model_core::model::Model;
use model_core::motion::Motion;
use model_core::payload::roots::{RootMean, Sums};
use model_core::payload::{MassEstimate, Method, Unknown};

struct Seen {
    power: f64,
    motion: Motion<f64, 2>,
}

fn drive(gate: Gate, mass: f64, sigma: f64, seed: u64) -> Vec<Seen> {
    let model = Model::Eq18 { gate, beta: servo().expand() };
    let mut rng = Rng::new(seed);
    let (_, matrix) = burger();
    (0..400)
        .map(|_| {
            let speed = [rng.uniform(-6.0, 6.0), rng.uniform(-6.0, 6.0)];
            let motion =
                Motion::new(&speed, &[rng.uniform(-9.0, 9.0), rng.uniform(-9.0, 9.0)], &matrix, 0.02);
            Seen { power: model.power(&motion, mass).unwrap() + sigma * rng.normal(), motion }
        })
        .collect()
}

/// Eq. 24's schoolbook root where Eq. 25 accepts it, weighted by Eq. 26.
fn naive(gate: Gate, samples: &[Seen]) -> (f64, usize) {
    let (mut weights, mut weighted, mut count) = (0.0, 0.0, 0);
    for seen in samples {
        let p = eq18::polynomial(gate, &eq18::products(gate, &seen.motion), &servo().expand());
        let (a, b, c) = (p.a, p.b, p.c - seen.power);
        let root = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
        if (1.0..=6.0).contains(&root) {
            let weight = seen.motion.wheels.iter().map(|wheel| wheel.speed.abs()).sum::<f64>() / 2.0;
            weights += weight;
            weighted += weight * root;
            count += 1;
        }
    }
    (weighted / weights, count)
}

fn sums(gate: Gate, samples: &[Seen]) -> Vec<Sums<f64>> {
    let model = Model::Eq18 { gate, beta: servo().expand() };
    let method = RootMean { range: range() };
    let buckets = samples.chunks(20).map(|bucket| {
        let mut sums = Sums::default();
        for seen in bucket {
            let response = model.response(&seen.motion, &range());
            method.add(&mut sums, seen.power, &response, seen.motion.mean_speed(), f64::NAN);
        }
        sums
    });
    buckets.collect()
}

#[test]
fn weighted_mean_of_accepted_roots() {
    let mut rejected = 0;
    for gate in [Gate::Published, Gate::Corrected] {
        for (mass, sigma) in [(1.2, 0.05), (3.0, 0.02), (3.0, 0.2), (5.7, 0.1)] {
            for seed in 0..10 {
                let samples = drive(gate, mass, sigma, seed);
                let (expected, count) = naive(gate, &samples);
                assert!(count > 50, "{count}");
                rejected += 400 - count;
                let estimate = RootMean { range: range() }.estimate(sums(gate, &samples).iter());
                let estimate = estimate.known().unwrap();
                // The schoolbook formula loses some digits where 4 a c is small beside b².
                assert!((estimate.mass - expected).abs() < 1e-8, "{estimate:?} {expected}");
                assert!(estimate.low <= estimate.mass && estimate.mass <= estimate.high);
            }
        }
    }
    assert!(rejected > 100, "Eq. 25 had something to do: {rejected}");
}

/// Without noise every root is the mass, and there is no scatter.
#[test]
fn exact_samples_give_the_mass() {
    let samples = drive(Gate::Corrected, 4.2, 0.0, 1);
    let estimate =
        RootMean { range: range() }.estimate(sums(Gate::Corrected, &samples).iter()).known().unwrap();
    assert!((estimate.mass - 4.2).abs() < 1e-9 && estimate.high - estimate.low < 1e-6, "{estimate:?}");
}

/// Too few buckets to see their scatter; none with a root; none at all.
#[test]
fn too_little_is_unknown() {
    let method = RootMean { range: range() };
    let samples = drive(Gate::Corrected, 3.0, 0.05, 1);
    let buckets = sums(Gate::Corrected, &samples);
    assert_eq!(method.estimate(buckets[..2].iter()), MassEstimate::Unknown(Unknown::TooWide));
    let hopeless: Vec<_> = samples.into_iter().map(|seen| Seen { power: -1.0, ..seen }).collect();
    let rootless = sums(Gate::Corrected, &hopeless);
    assert_eq!(method.estimate(rootless.iter()), MassEstimate::Unknown(Unknown::NoMotion));
    assert_eq!(method.estimate([].iter()), MassEstimate::Unknown(Unknown::NoMotion));
    assert_eq!(method.surprise(&buckets[0], 3.0), None);
}
