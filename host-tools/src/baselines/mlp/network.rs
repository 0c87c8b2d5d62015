//! Seven hidden layers and how they learn: Adam on shuffled mini-batches, as scikit-learn's `MLPRegressor` does it.

use candle_core::{Device, Result, Tensor, Var};
use candle_nn::{AdamW, Optimizer, ParamsAdamW};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::dense::Dense;
use super::{Ending, HIDDEN_LAYERS, Settings, Training};
use crate::progress::EpochProgress;

/// Inputs, seven hidden ReLU layers of one width, one linear output.
#[derive(Debug, Clone)]
pub(super) struct Network {
    layers: Vec<Layer>,
}

#[derive(Debug, Clone)]
struct Layer {
    /// In × out.
    weight: Var,
    /// 1 × out.
    bias: Var,
}

impl Network {
    /// Weights and biases uniform within ±√(6 / (in + out)), Glorot's bound, as in scikit-learn.
    ///
    /// candle's own generator has no seed on the CPU, hence one of ours.
    pub(super) fn new(inputs: usize, width: usize, rng: &mut ChaCha8Rng) -> Result<Self> {
        let mut sizes = vec![inputs];
        sizes.extend([width; HIDDEN_LAYERS]);
        sizes.push(1);
        let mut layers = Vec::new();
        for (fan_in, fan_out) in sizes.iter().copied().zip(sizes.iter().copied().skip(1)) {
            let bound = (6.0 / (fan_in + fan_out) as f32).sqrt();
            let mut uniform = |count: usize| -> Vec<f32> {
                (0..count).map(|_| bound * (2.0 * rng.random::<f32>() - 1.0)).collect()
            };
            let weight = Var::from_vec(uniform(fan_in * fan_out), (fan_in, fan_out), &Device::Cpu)?;
            let bias = Var::from_vec(uniform(fan_out), (1, fan_out), &Device::Cpu)?;
            layers.push(Layer { weight, bias });
        }
        Ok(Self { layers })
    }

    /// One column of standardised outputs for rows of standardised inputs.
    pub(super) fn forward(&self, inputs: &Tensor) -> Result<Tensor> {
        let mut signal = inputs.clone();
        for (index, layer) in self.layers.iter().enumerate() {
            let dense = Dense { relu: index < HIDDEN_LAYERS };
            signal = signal.apply_op3(&layer.weight, &layer.bias, dense)?;
        }
        Ok(signal)
    }

    /// Minimises Eq. 32 until it improves no more.
    pub(super) fn train(
        &mut self,
        inputs: &Tensor,
        outputs: &Tensor,
        settings: &Settings,
        rng: &mut ChaCha8Rng,
    ) -> Result<Training> {
        let mut adam = self.adam(settings.learning_rate)?;
        let mut progress = EpochProgress::new("training mlp", settings.most_epochs);
        let mut order: Vec<u32> = (0..inputs.dim(0)? as u32).collect();
        let mut patience = Patience::new(settings.tolerance, settings.patience);
        let mut training = Training { ending: Ending::EpochLimit, epochs: 0, loss: f64::NAN };
        while training.epochs < settings.most_epochs {
            order.shuffle(rng);
            let order = Tensor::new(order.as_slice(), &Device::Cpu)?;
            let shuffled = (inputs.index_select(&order, 0)?, outputs.index_select(&order, 0)?);
            training.loss = self.epoch(&mut adam, &shuffled, settings.batch)?;
            training.epochs += 1;
            progress.at(training.epochs, training.loss);
            if !(training.loss.is_finite() && self.is_finite()?) {
                training.ending = Ending::Diverged;
                return Ok(training);
            }
            if patience.is_used_up(training.loss) {
                training.ending = Ending::Converged;
                break;
            }
        }
        if self.is_dead(inputs)? {
            training.ending = Ending::Dead;
        } else if training.loss > WORTHLESS {
            training.ending = Ending::Diverged;
        }
        Ok(training)
    }

    fn adam(&self, learning_rate: f64) -> Result<AdamW> {
        let settings = ParamsAdamW { lr: learning_rate, weight_decay: 0.0, ..ParamsAdamW::default() };
        AdamW::new(self.parameters().cloned().collect(), settings)
    }

    fn parameters(&self) -> impl Iterator<Item = &Var> {
        self.layers.iter().flat_map(|layer| [&layer.weight, &layer.bias])
    }

    /// One pass over the rows: the mean of the loss as it was before each step.
    fn epoch(&self, adam: &mut AdamW, (inputs, outputs): &(Tensor, Tensor), most_rows: usize) -> Result<f64> {
        let all = inputs.dim(0)?;
        let mut sum = 0.0;
        for start in (0..all).step_by(most_rows) {
            let rows = most_rows.min(all - start);
            let predicted = self.forward(&inputs.narrow(0, start, rows)?)?;
            let loss = (predicted - outputs.narrow(0, start, rows)?)?.sqr()?.mean_all()?;
            adam.backward_step(&loss)?;
            sum += f64::from(loss.to_scalar::<f32>()?) * rows as f64;
        }
        Ok(sum / all as f64)
    }

    /// ReLU turns NaN into 0, so that a loss can look sound while weights are not.
    fn is_finite(&self) -> Result<bool> {
        for parameter in self.parameters() {
            if !parameter.abs()?.sum_all()?.to_scalar::<f32>()?.is_finite() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The same output whatever the input: in some layer no ReLU lets anything pass.
    fn is_dead(&self, inputs: &Tensor) -> Result<bool> {
        let outputs = self.forward(inputs)?.flatten_all()?;
        let spread = outputs.max(0)?.to_scalar::<f32>()? - outputs.min(0)?.to_scalar::<f32>()?;
        Ok(spread < 1e-4)
    }
}

/// In variances of the power: guessing the mean is worth 1.
const WORTHLESS: f64 = 2.0;

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
