//! Static states found in synthetic power: how many, where, and none in noise alone.

use answers::inspect::{Blocks, Moving, StaticPower};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal, StudentT};

/// Noise with lag-1 autocorrelation `rho` and standard deviation `std`.
struct Noise {
    rng: ChaCha8Rng,
    rho: f64,
    std: f64,
    value: f64,
    heavy: bool,
}

impl Noise {
    fn new(seed: u64, rho: f64, std: f64) -> Self {
        Self { rng: ChaCha8Rng::seed_from_u64(seed), rho, std, value: 0.0, heavy: false }
    }

    fn next(&mut self) -> f64 {
        let fresh = if self.heavy {
            // Three degrees of freedom: variance 3.
            StudentT::new(3.0).unwrap().sample(&mut self.rng) / 3.0_f64.sqrt()
        } else {
            Normal::new(0.0, 1.0).unwrap().sample(&mut self.rng)
        };
        self.value = self.rho * self.value + (1.0 - self.rho * self.rho).sqrt() * fresh;
        self.std * self.value
    }
}

/// States of `seconds` of power at `rate_hz`, with wheels that stand.
fn states(rate_hz: f64, seconds: f64, mut power: impl FnMut(f64) -> f64) -> StaticPower {
    let mut blocks = Blocks::new();
    for row in 0..(seconds * rate_hz) as u64 {
        let time = row as f64 / rate_hz;
        blocks.add(time, power(time), true);
    }
    StaticPower::of(&blocks.finish(), true)
}

fn means(power: &StaticPower) -> Vec<f64> {
    power.standing.iter().map(|state| state.mean_w).collect()
}

#[test]
fn noise_alone_is_one_state() {
    // Lag-1 correlations from white to a time constant of 1 s: twice the length of a block.
    let mut worst = 0;
    for (rate_hz, rho) in
        [(200.0, 0.0), (200.0, 0.21), (200.0, 0.9), (200.0, 0.98), (200.0, 0.995), (20.0, 0.0), (20.0, 0.8)]
    {
        for heavy in [false, true] {
            let mut wrong = 0;
            for seed in 0..100 {
                let mut noise = Noise::new(seed, rho, 0.5);
                noise.heavy = heavy;
                let power = states(rate_hz, 140.0, |_| 9.0 + noise.next());
                wrong += u32::from(power.standing.len() != 1);
            }
            println!(
                "{rate_hz} Hz, correlation {rho}, heavy tails {heavy}: {wrong} of 100 with false states"
            );
            worst = worst.max(wrong);
        }
    }
    assert!(worst <= 1, "{worst} % of pure noise has false states");
}

#[test]
fn levels_are_counted_and_placed() {
    let cases: [&[f64]; 4] = [&[9.0], &[8.6, 9.7], &[8.6, 9.7, 7.8], &[5.0, 6.2, 8.0, 7.1]];
    for levels in cases {
        let mut sorted = levels.to_vec();
        sorted.sort_by(f64::total_cmp);
        for heavy in [false, true] {
            for seed in 0..20 {
                let mut noise = Noise::new(seed, 0.21, 0.52);
                noise.heavy = heavy;
                let seconds = 30.0 * levels.len() as f64;
                let power = states(200.0, seconds, |time| levels[(time / 30.0) as usize] + noise.next());
                let means = means(&power);
                assert_eq!(
                    means.len(),
                    levels.len(),
                    "{levels:?}, seed {seed}, heavy {heavy}: found {means:?}"
                );
                for (mean, level) in means.iter().zip(&sorted) {
                    // 30 s of noise of 0.52 W: standard error 0.01 W.
                    assert!((mean - level).abs() < 0.05, "{levels:?}, seed {seed}: found {means:?}");
                }
                let share: f64 = power.standing.iter().map(|state| state.share).sum();
                assert!((share - 1.0).abs() < 0.05, "{share}");
            }
        }
    }
}

#[test]
fn the_gaussian_has_the_spread_of_the_samples() {
    let mut noise = Noise::new(3, 0.21, 0.52);
    let power = states(200.0, 100.0, |_| 9.0 + noise.next());
    // 20,000 samples: standard error of the deviation 0.5 %.
    assert!((power.standing[0].std_w / 0.52 - 1.0).abs() < 0.03, "{}", power.standing[0].std_w);
}

#[test]
fn a_drift_is_one_state() {
    for total in [0.3, 0.8, 2.0] {
        for seed in 0..20 {
            let mut noise = Noise::new(seed, 0.21, 0.52);
            let power = states(200.0, 300.0, |time| 9.0 + total * time / 300.0 + noise.next());
            assert_eq!(power.standing.len(), 1, "{total} W, seed {seed}: {:?}", means(&power));
        }
    }
}

#[test]
fn noiseless_levels_are_found_too() {
    let power = states(50.0, 60.0, |time| if time < 20.0 { 0.0 } else { 1.25 });
    let means = means(&power);
    assert_eq!(means.len(), 2, "{means:?}");
    assert!(means[0].abs() < 1e-9 && (means[1] - 1.25).abs() < 1e-9, "{means:?}");
    assert_eq!(states(50.0, 60.0, |_| 6.393).standing.len(), 1);
}

#[test]
fn glitches_are_no_state_and_do_not_move_the_mean() {
    let mut noise = Noise::new(5, 0.21, 0.52);
    let power = states(200.0, 60.0, |time| {
        if ((time * 200.0) as u64).is_multiple_of(997) { 400.0 } else { 9.0 + noise.next() }
    });
    assert_eq!(power.standing.len(), 1, "{:?}", means(&power));
    assert!((power.standing[0].mean_w - 9.0).abs() < 0.05);
}

#[test]
fn without_wheels_recurring_excursions_are_motion() {
    // Standby, then every 20 s a spin of 8 s, standing a watt above standby in between.
    let mut noise = Noise::new(7, 0.21, 0.52);
    let mut blocks = Blocks::new();
    for row in 0..28_000 {
        let time = f64::from(row) / 200.0;
        let level = if time < 25.0 {
            8.6
        } else if (time - 25.0) % 28.0 < 8.0 {
            10.7
        } else {
            9.7
        };
        blocks.add(time, level + noise.next(), true);
    }
    let power = StaticPower::of(&blocks.finish(), false);
    let standing: Vec<_> = power.standing.iter().map(|state| (state.mean_w, state.moving)).collect();
    assert_eq!(standing.len(), 2, "{standing:?}");
    assert!((standing[0].0 - 8.6).abs() < 0.1 && standing[0].1 == Moving::No, "{standing:?}");
    assert!((standing[1].0 - 9.7).abs() < 0.1 && standing[1].1 == Moving::Unknown, "{standing:?}");
    assert_eq!(power.moving.len(), 1);
    assert!((power.moving[0].mean_w - 10.7).abs() < 0.1 && power.moving[0].moving == Moving::Yes);
}

#[test]
fn the_stated_error_of_the_mean_is_honest() {
    // 95 % of means within two standard errors; 200 trials, so between 90 and 99 %.
    for rho in [0.0, 0.21, 0.9, 0.98, 0.995] {
        let inside = (0..200)
            .filter(|&seed| {
                let mut noise = Noise::new(1000 + seed, rho, 0.5);
                let power = states(200.0, 60.0, |_| 9.0 + noise.next());
                let state = &power.standing[0];
                (state.mean_w - 9.0).abs() < 2.0 * state.std_err_w
            })
            .count();
        println!("correlation {rho}: {} % within two standard errors", inside as f64 / 2.0);
        assert!(inside >= 176, "correlation {rho}: {inside} of 200");
    }
}

#[test]
fn memory_does_not_grow_with_the_log() {
    let mut noise = Noise::new(9, 0.0, 0.5);
    let mut blocks = Blocks::new();
    let rows = 4_000_000_u32;
    for row in 0..rows {
        let time = f64::from(row) / 20.0;
        blocks.add(time, if row < rows / 2 { 8.0 } else { 9.5 } + noise.next(), true);
    }
    let blocks = blocks.finish();
    assert!(blocks.len() <= 8193, "{}", blocks.len());
    let power = StaticPower::of(&blocks, true);
    assert_eq!(means(&power).len(), 2, "{:?}", means(&power));
    assert!((power.standing[0].std_w - 0.5).abs() < 0.02 && (power.standing[0].mean_w - 8.0).abs() < 0.01);
}
