//! Noise with a seed: every use has its own stream, so that switching one on does not move another.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// What a stream of random numbers is for.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Stream {
    Training = 1,
    Test = 2,
    SpeedLoop = 3,
    Power = 4,
    Jitter = 5,
    EncoderPhase = 6,
    Computer = 7,
    RailNoise = 8,
    Processor = 9,
    Onset = 10,
}

/// The generator of a stream. ChaCha8 is specified, so the same seed gives the same bytes on every machine.
pub(crate) fn stream(seed: u64, purpose: Stream) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(purpose as u64);
    rng
}

/// Gaussian of unit standard deviation clipped at ±3: the paper's bounded noise (Section 6).
pub(super) fn bounded(rng: &mut ChaCha8Rng) -> f64 {
    let x: f64 = StandardNormal.sample(rng);
    x.clamp(-3.0, 3.0)
}

/// First-order autoregressive Gaussian noise.
#[derive(Debug, Clone)]
pub(super) struct Ar1 {
    rng: ChaCha8Rng,
    std_dev: f64,
    autocorrelation: f64,
    last: Option<f64>,
}

impl Ar1 {
    /// Noise of `std_dev` whose neighbouring samples correlate by `autocorrelation` (within −1..1).
    pub(super) fn new(rng: ChaCha8Rng, std_dev: f64, autocorrelation: f64) -> Self {
        Self { rng, std_dev, autocorrelation, last: None }
    }

    /// The next sample; the first is drawn from the stationary distribution.
    pub(super) fn next(&mut self) -> f64 {
        if self.std_dev == 0.0 {
            return 0.0;
        }
        let white: f64 = StandardNormal.sample(&mut self.rng);
        let rho = self.autocorrelation;
        let unit = match self.last {
            None => white,
            Some(last) => rho * last + (1.0 - rho * rho).sqrt() * white,
        };
        self.last = Some(unit);
        self.std_dev * unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 200 000 samples: standard error of the lag-1 autocorrelation √((1−ρ²)/n) ≤ 0.0023, of the standard
    /// deviation σ √((1+ρ²)/(1−ρ²)/2n) ≤ 0.0016 σ at ρ = 0.6; four of them are allowed.
    #[test]
    fn ar1_has_the_spread_and_autocorrelation_asked_for() {
        for rho in [-0.5, 0.0, 0.2, 0.6] {
            let mut noise = Ar1::new(stream(5, Stream::Power), 0.1, rho);
            let x: Vec<f64> = (0..200_000).map(|_| noise.next()).collect();
            let square: f64 = x.iter().map(|v| v * v).sum();
            let lagged: f64 = x.windows(2).map(|v| v[0] * v[1]).sum();
            let std_dev = (square / x.len() as f64).sqrt();
            assert!((std_dev / 0.1 - 1.0).abs() < 0.0066, "ρ {rho}: σ {std_dev}");
            assert!((lagged / square - rho).abs() < 0.009, "ρ {rho}: {}", lagged / square);
        }
    }

    #[test]
    fn purposes_do_not_share_a_stream() {
        let first = |purpose| bounded(&mut stream(1, purpose));
        assert_ne!(first(Stream::Power), first(Stream::SpeedLoop));
        assert_ne!(first(Stream::Training), first(Stream::Test));
    }

    #[test]
    fn bounded_noise_stays_within_three_sigma() {
        let mut rng = stream(1, Stream::SpeedLoop);
        let extreme = (0..100_000).map(|_| bounded(&mut rng).abs()).fold(0.0, f64::max);
        assert_eq!(extreme, 3.0);
    }
}
