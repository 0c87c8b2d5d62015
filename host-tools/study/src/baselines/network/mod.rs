//! Feed-forward neural networks: the paper's own perceptron (Section 7.2) and those of its Table 1.
//!
//! What the sources leave open follows scikit-learn's `MLPRegressor`: Adam, mini-batches of 200,
//! weights within Glorot's bound, the last epoch's weights kept. Two things differ: there is no
//! penalty on weights, and the tolerance is in variances of the power (the paper gives no unit for
//! its loss). `tests/network_seeds.rs` trains the perceptron at the published learning rate with
//! ten seeds.

mod adam;
mod inputs;
mod layers;
mod scaling;
mod settings;
#[cfg(test)]
mod tests;
mod training;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use support::error::{Error, Result};

pub use self::inputs::Input;
use self::layers::Layers;
use self::scaling::Scaling;
pub use self::settings::Settings;
pub use self::training::{Ending, Training};
use super::baseline::Baseline;
use super::point::Point;
use super::training::evenly;

/// What a network sees of a point.
pub type Inputs = &'static [Input];

/// What the perceptron of Section 7.2 sees.
pub const MOTION_AND_MASS: Inputs = &[Input::Speed, Input::Acceleration, Input::Mass];

/// The network of Section 7.2 with settings of one's own.
pub fn perceptron(settings: Settings) -> Network {
    Network::new("mlp", MOTION_AND_MASS, settings)
}

/// A network that learns the power from some values of a point.
#[derive(Debug, Clone)]
pub struct Network {
    /// In refusals.
    name: &'static str,
    inputs: Inputs,
    settings: Settings,
    training: Option<Training>,
    fitted: Option<(Scaling, Layers)>,
}

impl Network {
    /// Not trained.
    pub fn new(name: &'static str, inputs: Inputs, settings: Settings) -> Self {
        Self { name, inputs, settings, training: None, fitted: None }
    }

    /// How the last training went, even where it failed.
    pub fn training(&self) -> Option<&Training> {
        self.training.as_ref()
    }

    fn seen(&self, point: &Point) -> Vec<f64> {
        let mut seen = Vec::new();
        self.inputs.iter().for_each(|input| input.see(point, &mut seen));
        seen
    }

    fn failed(&self, what: impl std::fmt::Display) -> Error {
        Error::failed(format!("{}: {what}", self.name))
    }

    /// What it sees of every point.
    ///
    /// # Errors
    /// Too few points, or one that is not finite.
    fn see(&self, points: &[Point]) -> Result<Vec<Vec<f64>>> {
        let (count, batch) = (points.len(), self.settings.batch);
        if count < batch {
            let message = format!("{count} training points; expected at least one mini-batch of {batch}");
            return Err(self.failed(message));
        }
        let see = |(index, point): (usize, &Point)| {
            let inputs = self.seen(point);
            if point.power.is_finite() && is_finite(&inputs) {
                return Ok(inputs);
            }
            Err(self.failed(format!(
                "training point {index} is not finite: inputs {inputs:?}, power {} W; expected finite numbers",
                point.power
            )))
        };
        points.iter().enumerate().map(see).collect()
    }
}

impl Baseline for Network {
    /// Trains from new weights; the last epoch's are kept.
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        (self.training, self.fitted) = (None, None);
        let settings = &self.settings;
        settings.check().map_err(|error| self.failed(error))?;
        let all = self.see(training)?;
        let kept = || evenly(all.len(), settings.most_points.max(settings.batch));
        let seen: Vec<_> = kept().map(|index| all[index].clone()).collect();
        let powers: Vec<f64> = kept().map(|index| training[index].power).collect();
        let scaling = Scaling::new(&seen, &powers, settings.rectified).ok_or_else(|| {
            self.failed("the inputs or the power never change; expected a drive at several speeds")
        })?;
        let (inputs, outputs) = (scaling.inputs(&seen), scaling.outputs(&powers));
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        let mut layers = Layers::new(inputs.nrows(), settings, &mut rng);
        if settings.rectified {
            layers.lift(outputs.mean());
        }
        let course = training::train(&mut layers, &inputs, &outputs, settings, &mut rng);
        self.training = Some(course);
        if course.ending == Ending::Diverged {
            return Err(self.failed(format!(
                "the training diverged in epoch {}; expected a learning rate below {}",
                course.epochs, settings.learning_rate
            )));
        }
        self.fitted = Some((scaling, layers));
        Ok(())
    }

    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let (scaling, layers) = self.fitted.as_ref().ok_or_else(|| self.failed("not fitted"))?;
        let mut powers = Vec::with_capacity(points.len());
        for chunk in points.chunks(PREDICTED_AT_ONCE) {
            let seen: Vec<Vec<f64>> = chunk.iter().map(|point| self.seen(point)).collect();
            let outputs = layers.output(&scaling.inputs(&seen));
            let power = |(inputs, output): (&Vec<f64>, &f32)| {
                // ReLU would make a sound number of NaN.
                if is_finite(inputs) { scaling.power(*output) } else { f64::NAN }
            };
            powers.extend(seen.iter().zip(&outputs).map(power));
        }
        Ok(powers)
    }
}

/// Bounds the memory of a prediction.
const PREDICTED_AT_ONCE: usize = 8192;

fn is_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}
