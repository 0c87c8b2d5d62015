//! Probabilities of causes that do not hang on single runs: the Bayesian bootstrap over field runs.
//!
//! Evidences add up over runs as if the model were right. It never is, and by how much it is wrong
//! differs from run to run, so sums of evidences are too sure. Where each run counts by a random
//! weight of mean one (Rubin 1981), a cause that leads by luck of a few runs loses in many draws;
//! the mean over draws is reproducible where a single posterior is not (Huggins and Miller 2023).

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Exp1};

use super::normal::log_sum;

/// Draws. Derived: a probability of 0.95 is then known to half a percent.
const DRAWS: usize = 2000;

/// Mean share of each cause over weights of the runs. Causes have ln of prior times evidence, and
/// what each run has of that, nats.
pub fn shares(causes: &[(f64, &[f64])]) -> Vec<f64> {
    let runs = causes.iter().map(|(_, runs)| runs.len()).max().unwrap_or(0);
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let mut shares = vec![0.0; causes.len()];
    for _ in 0..DRAWS {
        let mut weights: Vec<f64> = (0..runs).map(|_| Exp1.sample(&mut random)).collect();
        let mean = weights.iter().sum::<f64>() / runs as f64;
        weights.iter_mut().for_each(|weight| *weight = *weight / mean - 1.0);
        let value = |(all, runs): &(f64, &[f64])| {
            all + runs.iter().zip(&weights).map(|(run, weight)| run * weight).sum::<f64>()
        };
        let values: Vec<f64> = causes.iter().map(value).collect();
        let total = log_sum(values.iter().copied());
        shares.iter_mut().zip(&values).for_each(|(share, value)| *share += (value - total).exp());
    }
    let total: f64 = shares.iter().sum();
    shares.iter().map(|share| if total > 0.0 { share / total } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten nats of one run are no certainty; of twelve runs alike they are.
    #[test]
    fn one_run_is_not_sure() {
        let alike = vec![10.0 / 12.0; 12];
        let mut single = vec![0.0; 12];
        single[3] = 10.0;
        let none = vec![0.0; 12];
        let of = |runs: &[f64]| shares(&[(10.0, runs), (0.0, &none)])[0];
        assert!(of(&alike) > 0.9999, "{}", of(&alike));
        // Exponential weights are below 0.3 in a quarter of the draws: mean of 1 / (1 + exp -10 w).
        assert!((0.85..0.95).contains(&of(&single)), "{}", of(&single));
    }

    /// What all causes have of a run alike says nothing.
    #[test]
    fn what_is_common_cancels() {
        let (a, b) = ([3.0, 500.0], [3.0, 500.0]);
        let shares = shares(&[(1.0, &a), (0.0, &b)]);
        assert!((shares[0] - 1.0 / (1.0 + (-1.0_f64).exp())).abs() < 1e-9);
    }
}
