//! Lengths and noise at which samples are most likely: coordinate search in their logarithms.

use super::kernel::{Hyper, INPUTS, Sample, log_likelihood};

/// Bounds of a length, in standard deviations of its input: a tenth of it is finer than thinned
/// samples resolve, and from a hundred on the input has no influence.
const LENGTHS: (f64, f64) = (0.1, 100.0);

/// Bounds of the noise ratio: the lower keeps the covariance of repeated samples positive definite.
const NOISE: (f64, f64) = (1e-6, 1e2);

/// First and last step, as factors; a step is the square root of that before.
const FIRST_STEP: f64 = 8.0;
const LAST_STEP: f64 = 1.1;

/// Sweeps over all coordinates with one step: a ridge may take many small ones.
const MOST_SWEEPS: usize = 4;

/// The most likely parameters of the kernel; inputs that do not change have no influence.
pub(super) fn most_likely(samples: &[Sample], changing: [bool; INPUTS]) -> Hyper {
    let start =
        Hyper { lengths: changing.map(|changes| if changes { 2.0 } else { f64::INFINITY }), noise: 0.1 };
    let mut best = (likelihood(samples, &start), start);
    let mut step = FIRST_STEP;
    while step > LAST_STEP {
        for _ in 0..MOST_SWEEPS {
            let before = best.0;
            for coordinate in 0..=INPUTS {
                // Down only where up is no better.
                for factor in [step, 1.0 / step] {
                    let trial = moved(&best.1, coordinate, factor);
                    if trial == best.1 {
                        continue;
                    }
                    let likely = likelihood(samples, &trial);
                    if likely > best.0 {
                        best = (likely, trial);
                        break;
                    }
                }
            }
            if best.0 == before {
                break;
            }
        }
        step = step.sqrt();
    }
    best.1
}

fn likelihood(samples: &[Sample], hyper: &Hyper) -> f64 {
    log_likelihood(samples, hyper).unwrap_or(f64::NEG_INFINITY)
}

/// One coordinate multiplied by a factor, within its bounds: a length, or the noise as the last.
/// Infinite lengths stay.
fn moved(hyper: &Hyper, coordinate: usize, factor: f64) -> Hyper {
    let mut moved = *hyper;
    match moved.lengths.get_mut(coordinate) {
        Some(length) if length.is_infinite() => {}
        Some(length) => *length = (*length * factor).clamp(LENGTHS.0, LENGTHS.1),
        // Noise varies over decades: twice the step.
        None => moved.noise = (moved.noise * factor * factor).clamp(NOISE.0, NOISE.1),
    }
    moved
}
