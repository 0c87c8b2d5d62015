//! A multilayer perceptron on the body's motion and the mass: Section 7.2 of the paper, after Liu 2023.
//!
//! What the paper leaves open is scikit-learn's: Adam, mini-batches of 200, weights within Glorot's bound, the last
//! epoch's weights kept. Not scikit-learn's: no penalty on weights, and the tolerance is in variances of the power (the
//! paper does not say what unit its loss has). `tests/mlp_seeds.rs` trains at the published learning rate with ten seeds.

mod dense;
mod network;

use candle_core::{Device, Tensor};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;

use self::network::Network;
use super::{Baseline, Card, Point};
use crate::error::{Error, Result};

/// As published.
pub const HIDDEN_LAYERS: usize = 7;

/// The network that the paper compares itself with.
pub const PERCEPTRON: Card = Card {
    name: "mlp",
    source: "multilayer perceptron of Section 7.2, seven hidden ReLU layers on motion and mass, after Liu 2023 (Eq. 32)",
    assumes: "test drives resemble the training",
    takes_mass: true,
    network: true,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(Mlp::default()),
};

/// How it is built and trained.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Settings {
    /// Adam's step; published: 0.01.
    pub learning_rate: f64,
    /// Neurons in each hidden layer; not published.
    pub width: usize,
    /// Rows in a mini-batch; not published, 200 in scikit-learn.
    pub batch: usize,
    /// An epoch improves if it lowers the loss by this much, in variances of the power; published: 1e-4.
    pub tolerance: f64,
    /// Epochs in a row that need not improve; published: 50.
    pub patience: u32,
    /// Most epochs; published: 1000.
    pub most_epochs: u32,
    /// More training points than these are thinned evenly: time grows with them, and filtered neighbours repeat each other.
    pub most_points: usize,
    /// Same seed, same weights (on the same kind of processor: sums are vectorised differently on others).
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            learning_rate: 0.01,
            width: 32,
            batch: 200,
            tolerance: 1e-4,
            patience: 50,
            most_epochs: 1000,
            most_points: 20_000,
            seed: 1,
        }
    }
}

impl Settings {
    fn check(&self) -> Result<()> {
        let positive = |name: &str, value: f64| {
            if value > 0.0 && value.is_finite() {
                return Ok(());
            }
            Err(Error::failed(format!("mlp: {name} is {value}; expected a positive number")))
        };
        positive("the learning rate", self.learning_rate)?;
        positive("the width", self.width as f64)?;
        positive("the mini-batch", self.batch as f64)?;
        positive("the number of epochs", f64::from(self.most_epochs))
    }
}

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

/// Seven hidden layers.
#[derive(Debug, Clone, Default)]
pub struct Mlp {
    settings: Settings,
    training: Option<Training>,
    fitted: Option<(Scaling, Network)>,
}

impl Mlp {
    /// With these settings.
    pub fn new(settings: Settings) -> Self {
        Self { settings, ..Self::default() }
    }

    /// How the last training went, even where it failed.
    pub fn training(&self) -> Option<&Training> {
        self.training.as_ref()
    }
}

impl Baseline for Mlp {
    /// Trains from new weights; the last epoch's are kept.
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        (self.training, self.fitted) = (None, None);
        self.settings.check()?;
        if training.len() < self.settings.batch {
            return Err(Error::failed(format!(
                "mlp: {} training points; expected at least one mini-batch of {}",
                training.len(),
                self.settings.batch
            )));
        }
        if let Some(index) = training.iter().position(|point| !is_finite(point)) {
            return Err(Error::failed(format!(
                "mlp: training point {index} is not finite ({:?}); expected finite motion, mass and power",
                training[index]
            )));
        }
        let points = thin(training, self.settings.most_points.max(self.settings.batch));
        let scaling = Scaling::new(&points)?;
        let mut rng = ChaCha8Rng::seed_from_u64(self.settings.seed);
        let mut network =
            Network::new(scaling.inputs.len(), self.settings.width, &mut rng).map_err(failed)?;
        let outputs: Vec<f32> = points.iter().map(|point| scaling.power.apply(point.power)).collect();
        let outputs = Tensor::from_vec(outputs, (points.len(), 1), &Device::Cpu).map_err(failed)?;
        let inputs = scaling.tensor(&points).map_err(failed)?;
        let course = network.train(&inputs, &outputs, &self.settings, &mut rng).map_err(failed)?;
        self.training = Some(course);
        if course.ending == Ending::Diverged {
            return Err(Error::failed(format!(
                "mlp: the training diverged in epoch {}; expected a learning rate below {}",
                course.epochs, self.settings.learning_rate
            )));
        }
        self.fitted = Some((scaling, network));
        Ok(())
    }

    /// NaN for points that are not finite.
    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let (scaling, network) = self.fitted.as_ref().ok_or_else(|| Error::failed("mlp: not fitted"))?;
        let mut powers = Vec::with_capacity(points.len());
        for chunk in points.chunks(PREDICTED_AT_ONCE) {
            let outputs = scaling.tensor(chunk).and_then(|inputs| network.forward(&inputs)?.flatten_all());
            let outputs = outputs.and_then(|outputs| outputs.to_vec1::<f32>()).map_err(failed)?;
            let known = chunk.iter().map(|point| quantities(point).iter().all(|value| value.is_finite()));
            let power = |(output, known)| if known { scaling.power.invert(output) } else { f64::NAN };
            powers.extend(outputs.into_iter().zip(known).map(power));
        }
        Ok(powers)
    }
}

/// Bounds the memory of a prediction.
const PREDICTED_AT_ONCE: usize = 8192;

fn failed(error: candle_core::Error) -> Error {
    Error::failed(format!("mlp: {error}"))
}

const QUANTITIES: usize = 7;

/// v, vy, ω, their derivatives, m.
fn quantities(point: &Point) -> [f64; QUANTITIES] {
    let Point { speed, acceleration, mass, .. } = point;
    [speed.vx, speed.vy, speed.omega, acceleration.vx, acceleration.vy, acceleration.omega, *mass]
}

fn is_finite(point: &Point) -> bool {
    point.power.is_finite() && quantities(point).iter().all(|value| value.is_finite())
}

/// At most so many points, evenly over the whole.
fn thin(points: &[Point], most: usize) -> Vec<Point> {
    let kept = most.min(points.len());
    (0..kept).map(|index| points[index * points.len() / kept]).collect()
}

/// To zero mean and unit variance.
#[derive(Debug, Clone, Copy)]
struct Standard {
    mean: f64,
    std: f64,
}

impl Standard {
    /// `None` where the values do not change: by less than a millionth of an SI unit.
    fn new(values: impl Iterator<Item = f64> + Clone) -> Option<Self> {
        let count = values.clone().count() as f64;
        let mean = values.clone().sum::<f64>() / count;
        let std = (values.map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
        (std > 1e-6).then_some(Self { mean, std })
    }

    fn apply(&self, value: f64) -> f32 {
        ((value - self.mean) / self.std) as f32
    }

    fn invert(&self, value: f32) -> f64 {
        self.mean + self.std * f64::from(value)
    }
}

/// What the network sees of a point.
#[derive(Debug, Clone)]
struct Scaling {
    /// Quantities that change in training, by their place in [`quantities`]: a differential drive has no vy.
    inputs: Vec<(usize, Standard)>,
    power: Standard,
}

impl Scaling {
    fn new(points: &[Point]) -> Result<Self> {
        let standard = |place: usize| {
            Standard::new(points.iter().map(|point| quantities(point)[place])).map(|found| (place, found))
        };
        let inputs: Vec<_> = (0..QUANTITIES).filter_map(standard).collect();
        match Standard::new(points.iter().map(|point| point.power)) {
            Some(power) if !inputs.is_empty() => Ok(Self { inputs, power }),
            _ => Err(Error::failed("mlp: motion or power never changes; expected a drive at several speeds")),
        }
    }

    fn tensor(&self, points: &[Point]) -> candle_core::Result<Tensor> {
        let row = |point: &Point| {
            let values = quantities(point);
            self.inputs
                .iter()
                .map(move |(place, standard)| standard.apply(values[*place]))
                .collect::<Vec<_>>()
        };
        let values = points.iter().flat_map(row).collect();
        Tensor::from_vec(values, (points.len(), self.inputs.len()), &Device::Cpu)
    }
}

#[cfg(test)]
mod tests {
    use super::{Ending, Mlp, Settings, quantities, thin};
    use crate::baselines::{Baseline, Point};
    use crate::metrics::Metrics;
    use model_core::kinematics::Twist;

    /// Small enough for a test: 2000 points take 10 steps an epoch.
    const SMALL: Settings = Settings {
        learning_rate: 0.005,
        width: 16,
        batch: 200,
        tolerance: 1e-4,
        patience: 50,
        most_epochs: 150,
        most_points: 2000,
        seed: 1,
    };

    /// Smooth, curved in every input, without vy; incommensurable waves fill the space of inputs.
    fn points(first: usize, count: usize) -> Vec<Point> {
        let wave = |i: usize, k: f64| (i as f64 * k).sin();
        let point = |i: usize| {
            let speed = Twist { vx: 0.2 * wave(i, 0.911), vy: 0.0, omega: 2.0 * wave(i, 1.717) };
            let acceleration = Twist { vx: wave(i, 2.323), vy: 0.0, omega: 5.0 * wave(i, 0.531) };
            let mass = 3.0 + 2.0 * wave(i, 0.037);
            let power = 0.3
                + 20.0 * mass * speed.vx.powi(2)
                + 0.5 * speed.omega.powi(2)
                + 0.5 * mass * acceleration.vx * speed.vx
                + 0.05 * acceleration.omega * speed.omega;
            Point { speed, acceleration, mass, power, ..crate::baselines::testing::still() }
        };
        (first..first + count).map(point).collect()
    }

    fn r2(model: &Mlp, points: &[Point]) -> f64 {
        let mut metrics = Metrics::new(0.0);
        for (point, predicted) in points.iter().zip(model.predict(points).unwrap()) {
            metrics.add(point.power, predicted);
        }
        metrics.quality().unwrap().r2.unwrap()
    }

    /// The five changing inputs explain the power entirely; what a small network misses of it is under 2 %.
    #[test]
    fn learns_a_smooth_function() {
        let mut model = Mlp::new(SMALL);
        model.fit(&points(0, 2000)).unwrap();
        let held_out = r2(&model, &points(5000, 1000));
        assert!(held_out > 0.98, "{held_out} {:?}", model.training());
        assert_eq!(model.fitted.as_ref().unwrap().0.inputs.len(), 5, "vy never changes");
    }

    /// A planar robot's power depends on vy as well: the network sees it.
    #[test]
    fn sees_sideways_motion() {
        let sideways = |mut point: Point| {
            (point.speed.vy, point.speed.vx) = (point.speed.vx, 0.0);
            (point.acceleration.vy, point.acceleration.vx) = (point.acceleration.vx, 0.0);
            point
        };
        let moved = |first, count| points(first, count).into_iter().map(sideways).collect::<Vec<_>>();
        let mut model = Mlp::new(SMALL);
        model.fit(&moved(0, 2000)).unwrap();
        assert!(r2(&model, &moved(5000, 1000)) > 0.98);
    }

    #[test]
    fn same_seed_same_predictions() {
        let (training, test) = (points(0, 600), points(5000, 100));
        let predict = |seed| {
            let mut model = Mlp::new(Settings { most_epochs: 3, seed, ..SMALL });
            model.fit(&training).unwrap();
            model.predict(&test).unwrap()
        };
        assert_eq!(predict(1), predict(1));
        assert_ne!(predict(1), predict(2));
    }

    /// Fitting again forgets the first fit.
    #[test]
    fn fits_again_from_new_weights() {
        let (training, test) = (points(0, 400), points(5000, 10));
        let mut model = Mlp::new(Settings { most_epochs: 2, ..SMALL });
        model.fit(&training).unwrap();
        let first = model.predict(&test).unwrap();
        model.fit(&training).unwrap();
        assert_eq!(model.predict(&test).unwrap(), first);
    }

    /// Every way in which a training ends, provoked; of seven single ReLUs in a row one is almost surely dead from the start.
    #[test]
    fn names_its_ending() {
        let end = |settings: Settings| {
            let mut model = Mlp::new(settings);
            let fitted = model.fit(&points(0, 600));
            (model.training().unwrap().ending, fitted)
        };
        let (ending, fitted) = end(Settings { most_epochs: 2, ..SMALL });
        assert!(ending == Ending::EpochLimit && fitted.is_ok());
        let (ending, fitted) = end(Settings { tolerance: 10.0, patience: 2, ..SMALL });
        assert!(ending == Ending::Converged && fitted.is_ok());
        let (ending, fitted) = end(Settings { learning_rate: 1e6, ..SMALL });
        assert!(ending == Ending::Diverged, "{ending:?}");
        assert!(fitted.unwrap_err().to_string().contains("diverged in epoch"));
        let (ending, fitted) = end(Settings { width: 1, most_epochs: 5, ..SMALL });
        assert!(ending == Ending::Dead && fitted.is_ok(), "{ending:?}");
    }

    #[test]
    fn refuses_what_it_cannot_learn_from() {
        let refusal = |settings: Settings, points: &[Point]| {
            let mut model = Mlp::new(settings);
            let message = model.fit(points).unwrap_err().to_string();
            assert!(model.predict(points).is_err(), "unfitted");
            message
        };
        let good = points(0, 600);
        assert_eq!(
            refusal(SMALL, &good[..199]),
            "mlp: 199 training points; expected at least one mini-batch of 200"
        );
        let mut broken = good.clone();
        broken[7].acceleration.omega = f64::NAN;
        assert!(refusal(SMALL, &broken).starts_with("mlp: training point 7 is not finite"));
        broken[7] = Point { power: f64::INFINITY, ..good[7] };
        assert!(refusal(SMALL, &broken).starts_with("mlp: training point 7 is not finite"));
        assert!(refusal(SMALL, &[good[0]; 300]).contains("never changes"));
        assert!(refusal(Settings { batch: 0, ..SMALL }, &good).contains("the mini-batch is 0"));
        assert!(
            refusal(Settings { learning_rate: -1.0, ..SMALL }, &good).contains("the learning rate is -1")
        );
    }

    /// ReLU would make a sound number of NaN.
    #[test]
    fn predicts_nothing_for_what_is_not_finite() {
        let mut model = Mlp::new(Settings { most_epochs: 1, ..SMALL });
        model.fit(&points(0, 400)).unwrap();
        let mut test = points(5000, 3);
        test[1].speed.vx = f64::NAN;
        let predicted = model.predict(&test).unwrap();
        assert_eq!(predicted.iter().map(|power| power.is_nan()).collect::<Vec<_>>(), [false, true, false]);
        assert!(model.predict(&[]).unwrap().is_empty());
    }

    /// Evenly: neighbours in the thinned rows are 3 or 4 apart in 10 of 35, and the first is kept.
    #[test]
    fn thins_evenly() {
        let all = points(0, 35);
        let kept: Vec<usize> = thin(&all, 10)
            .iter()
            .map(|point| all.iter().position(|other| quantities(other) == quantities(point)).unwrap())
            .collect();
        assert_eq!(kept, [0, 3, 7, 10, 14, 17, 21, 24, 28, 31]);
        assert_eq!(thin(&all, 100), all);
    }
}
