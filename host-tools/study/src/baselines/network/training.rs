//! How layers learn: Adam on shuffled mini-batches, as scikit-learn's `MLPRegressor` does it.

use nalgebra::DMatrix;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::adam::Adam;
use super::layers::Layers;
use super::settings::Settings;

/// How the training ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// The loss stopped improving by the tolerance.
    Converged,
    /// The loss was still improving after the last epoch.
    EpochLimit,
    /// Loss or weights left the range of numbers, or the end is worse than guessing the mean.
    Diverged,
    /// Every input gives the same output: the ReLUs of a layer have all died.
    Dead,
}

/// The course of a training.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Training {
    /// How it ended.
    pub ending: Ending,
    /// Passes over the training points.
    pub epochs: u32,
    /// Eq. 32 in the last epoch, in variances of the power: about 1 − R².
    pub loss: f64,
}

/// In variances of the power: guessing the mean is worth 1.
const WORTHLESS: f64 = 2.0;

/// Minimises Eq. 32 until it improves no more. Columns of inputs and outputs are points, both about
/// unit size.
pub(super) fn train(
    layers: &mut Layers,
    inputs: &DMatrix<f32>,
    outputs: &DMatrix<f32>,
    settings: &Settings,
    rng: &mut ChaCha8Rng,
) -> Training {
    let mut adam = Adam::default();
    let mut order: Vec<usize> = (0..inputs.ncols()).collect();
    let mut patience = Patience::new(settings.tolerance, settings.patience);
    let mut training = Training { ending: Ending::EpochLimit, epochs: 0, loss: f64::NAN };
    while training.epochs < settings.most_epochs {
        order.shuffle(rng);
        // The mean of the loss as it was before each step.
        let mut sum = 0.0;
        for rows in order.chunks(settings.batch) {
            let (inputs, outputs) = (inputs.select_columns(rows), outputs.select_columns(rows));
            let signals = layers.forward(&inputs);
            let Some(predicted) = signals.last() else { continue };
            let residual = predicted - outputs;
            sum += f64::from(residual.norm_squared());
            let slopes = residual * (2.0 / rows.len() as f32);
            let gradient = layers.backward(&inputs, &signals, slopes);
            adam.step(layers.layers_mut(), &gradient, settings.learning_rate as f32);
        }
        training.loss = sum / order.len() as f64;
        training.epochs += 1;
        if !(training.loss.is_finite() && layers.is_finite()) {
            training.ending = Ending::Diverged;
            return training;
        }
        if patience.is_used_up(training.loss) {
            training.ending = Ending::Converged;
            break;
        }
    }
    let predicted = layers.output(inputs);
    if predicted.max() - predicted.min() < 1e-4 {
        training.ending = Ending::Dead;
    } else if training.loss > WORTHLESS {
        training.ending = Ending::Diverged;
    }
    training
}

/// Stops when the loss has not improved by the tolerance for more than so many epochs in a row.
struct Patience {
    tolerance: f64,
    most: u32,
    used: u32,
    best: f64,
}

impl Patience {
    fn new(tolerance: f64, most: u32) -> Self {
        Self { tolerance, most, used: 0, best: f64::INFINITY }
    }

    fn is_used_up(&mut self, loss: f64) -> bool {
        self.used = if loss > self.best - self.tolerance { self.used + 1 } else { 0 };
        self.best = self.best.min(loss);
        self.used > self.most
    }
}
