//! How a network is built and trained.

use serde::Serialize;

/// Layers, and how they learn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Settings {
    /// Hidden ReLU layers.
    pub hidden_layers: usize,
    /// Neurons in each of them.
    pub width: usize,
    /// The output has a ReLU, too: no power below 0 is ever predicted.
    pub rectified: bool,
    /// Adam's step; published for the perceptron: 0.01.
    pub learning_rate: f64,
    /// Rows in a mini-batch; not published, 200 in scikit-learn.
    pub batch: usize,
    /// An epoch improves if it lowers the loss by this much, in variances of the power; published:
    /// 1e-4.
    pub tolerance: f64,
    /// Epochs in a row that need not improve; published: 50.
    pub patience: u32,
    /// Most epochs; published: 1000.
    pub most_epochs: u32,
    /// More training points than these are thinned evenly: time grows with them, and filtered
    /// neighbours repeat each other.
    pub most_points: usize,
    /// Same seed, same weights (on the same kind of processor: sums are vectorised differently on
    /// others).
    pub seed: u64,
}

impl Settings {
    /// Section 7.2: seven hidden layers (it gives no width), the learning rate 0.01, the end of the
    /// training.
    pub const PERCEPTRON: Self = Self {
        hidden_layers: 7,
        width: 32,
        rectified: false,
        learning_rate: 0.01,
        batch: 200,
        tolerance: 1e-4,
        patience: 50,
        most_epochs: 1000,
        most_points: 20_000,
        seed: 1,
    };

    /// For sources that do not say how large their network is: two hidden layers of 16, trained
    /// alike.
    pub const SMALL: Self = Self { hidden_layers: 2, width: 16, ..Self::PERCEPTRON };

    /// As [`SMALL`](Self::SMALL), with a ReLU at the output.
    pub const RECTIFIED: Self = Self { rectified: true, ..Self::SMALL };

    /// # Errors
    /// The first that is not positive, as text.
    pub(super) fn check(&self) -> Result<(), String> {
        let all = [
            ("the learning rate", self.learning_rate),
            ("the number of hidden layers", self.hidden_layers as f64),
            ("the width", self.width as f64),
            ("the mini-batch", self.batch as f64),
            ("the number of epochs", f64::from(self.most_epochs)),
        ];
        match all.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
            Some((name, value)) => Err(format!("{name} is {value}; expected a positive number")),
            None => Ok(()),
        }
    }
}
