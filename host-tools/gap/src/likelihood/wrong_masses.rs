//! Masses that were noted wrongly in some runs, each by as much as it may be.

use nalgebra::{DMatrix, DVector};

use super::evidence::gain_of_several;
use super::normal::log_mean;
use super::priors::WRONG_MASS;
use super::step_times::SingleRuns;

/// Runs whose masses were noted wrongly.
#[derive(Debug, Clone, PartialEq)]
pub struct Masses {
    /// ln evidence over none, which runs being summed over.
    pub evidence: f64,
    /// What the best runs alone gain, without their prior.
    pub gain: f64,
    /// The runs, by their places.
    pub runs: Vec<usize>,
}

/// ln evidence of wrong masses; one column a run.
pub fn masses(of: &SingleRuns, sizes: &[f64]) -> Option<Masses> {
    let each: Vec<(f64, Vec<usize>)> = sizes.iter().map(|size| of_size(of, *size)).collect();
    let evidence = log_mean(each.iter().map(|(evidence, _)| *evidence));
    let (_, runs) = each.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    if runs.is_empty() {
        return None;
    }
    let gain = log_mean(sizes.iter().map(|size| gain(of, &runs, *size)));
    Some(Masses { evidence, gain, runs })
}

fn gain(of: &SingleRuns, runs: &[usize], size: f64) -> f64 {
    let along = DVector::from_fn(runs.len(), |i, _| of.along[runs[i]]);
    let gram = DMatrix::from_fn(runs.len(), runs.len(), |i, j| of.gram[(runs[i], runs[j])]);
    gain_of_several(&along, &gram, &vec![size; runs.len()])
}

/// Runs are added as long as that helps; what each alone would change is summed over.
fn of_size(of: &SingleRuns, size: f64) -> (f64, Vec<usize>) {
    let count = of.along.len();
    let value = |runs: &[usize]| {
        let prior =
            runs.len() as f64 * WRONG_MASS.ln() + (count - runs.len()) as f64 * (1.0 - WRONG_MASS).ln();
        prior + if runs.is_empty() { 0.0 } else { gain(of, runs, size) }
    };
    let mut on: Vec<usize> = Vec::new();
    let mut now = value(&on);
    loop {
        let tries = (0..count).filter(|run| !on.contains(run)).map(|run| {
            let with: Vec<usize> = on.iter().copied().chain([run]).collect();
            (value(&with), with)
        });
        match tries.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((better, with)) if better > now => (now, on) = (better, with),
            _ => break,
        }
    }
    let flipped = |run: usize| -> f64 {
        let other: Vec<usize> = match on.contains(&run) {
            true => on.iter().copied().filter(|place| *place != run).collect(),
            false => on.iter().copied().chain([run]).collect(),
        };
        (value(&other) - now).min(0.0).exp().ln_1p()
    };
    let spare: f64 = (0..count).map(flipped).sum();
    (now + spare, on)
}
