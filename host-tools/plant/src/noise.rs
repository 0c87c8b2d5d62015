//! Noise with a seed: every use has its own stream, so that switching one on does not change the
//! others.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StudentT};

/// What a stream of random numbers is for.
#[derive(Debug, Clone, Copy)]
pub enum Stream {
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
    Field = 11,
    Imu = 12,
    Rounds = 13,
    Speed = 14,
    Errands = 15,
    InertialChip = 26,
}

/// The generator of a stream. ChaCha8 is specified, so the same seed gives the same bytes on every
/// machine.
pub fn stream(seed: u64, purpose: Stream) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(purpose as u64);
    rng
}

/// Gaussian of unit standard deviation clipped at ±3: the paper's bounded noise (Section 6).
pub(super) fn bounded(rng: &mut ChaCha8Rng) -> f64 {
    let x: f64 = StandardNormal.sample(rng);
    x.clamp(-3.0, 3.0)
}

/// First-order autoregressive noise of unit standard deviation.
#[derive(Debug, Clone)]
pub(super) struct Ar1 {
    rng: ChaCha8Rng,
    autocorrelation: f64,
    /// Student's distribution, and what brings it to unit standard deviation; none for Gaussian
    /// noise.
    tail: Option<(StudentT<f64>, f64)>,
    last: Option<f64>,
}

impl Ar1 {
    /// Noise whose neighbouring samples correlate by `autocorrelation` (within −1..1), driven by
    /// Student's t of `degrees` of freedom (more than 2, or its spread is infinite) where given.
    pub(super) fn new(rng: ChaCha8Rng, autocorrelation: f64, degrees: Option<f64>) -> Self {
        let tail = degrees.and_then(|nu| Some((StudentT::new(nu).ok()?, ((nu - 2.0) / nu).sqrt())));
        Self { rng, autocorrelation, tail, last: None }
    }

    /// The next sample; the first has the stationary spread.
    pub(super) fn next(&mut self) -> f64 {
        let white: f64 = match &self.tail {
            None => StandardNormal.sample(&mut self.rng),
            Some((student, scale)) => scale * student.sample(&mut self.rng),
        };
        let rho = self.autocorrelation;
        let unit = match self.last {
            None => white,
            Some(last) => rho * last + (1.0 - rho * rho).sqrt() * white,
        };
        self.last = Some(unit);
        unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 200 000 samples: standard error of the lag-1 autocorrelation √((1−ρ²)/n) ≤ 0.0023, of the
    /// standard deviation σ √((1+ρ²)/(1−ρ²)/2n) ≤ 0.0016 σ at ρ = 0.6; four of them are allowed.
    #[test]
    fn ar1_has_the_spread_and_autocorrelation_asked_for() {
        for rho in [-0.5, 0.0, 0.2, 0.6] {
            let mut noise = Ar1::new(stream(5, Stream::Power), rho, None);
            let x: Vec<f64> = (0..200_000).map(|_| noise.next()).collect();
            let square: f64 = x.iter().map(|v| v * v).sum();
            let lagged: f64 = x.windows(2).map(|v| v[0] * v[1]).sum();
            let std_dev = (square / x.len() as f64).sqrt();
            assert!((std_dev - 1.0).abs() < 0.0066, "ρ {rho}: σ {std_dev}");
            assert!((lagged / square - rho).abs() < 0.009, "ρ {rho}: {}", lagged / square);
        }
    }

    /// Student's t with ν = 10, scaled to unit variance, has the fourth moment 3 + 6/(ν − 4) = 4
    /// and the eighth 105 (ν−2)³/((ν−4)(ν−6)(ν−8)) = 1120, so that of 10⁶ samples the mean fourth
    /// power errs by √(1104/10⁶) = 0.033. Beyond 5 σ (t = 5.59) lie 2.3e-4 of them by the integral
    /// of its density, 6e-7 of Gaussian ones. Four standard errors.
    #[test]
    fn heavy_tails_keep_the_spread() {
        let mut noise = Ar1::new(stream(5, Stream::Power), 0.0, Some(10.0));
        let x: Vec<f64> = (0..1_000_000).map(|_| noise.next()).collect();
        let moment = |power: i32| x.iter().map(|v| v.powi(power)).sum::<f64>() / x.len() as f64;
        assert!((moment(2) - 1.0).abs() < 0.007, "{}", moment(2));
        assert!((moment(4) - 4.0).abs() < 0.14, "{}", moment(4));
        let far = x.iter().filter(|v| v.abs() > 5.0).count();
        assert!((170..290).contains(&far), "{far}");
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
