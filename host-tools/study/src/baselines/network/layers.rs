//! Fully connected layers and their derivatives (back-propagation: Rumelhart, Hinton and Williams
//! 1986).
//!
//! Every column of a matrix is a row of data, so that a layer is one product of matrices.

use nalgebra::{DMatrix, DVector, RowDVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::settings::Settings;

/// W x + b, or its derivative.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layer {
    /// Out × in.
    pub(super) weight: DMatrix<f32>,
    /// Out.
    pub(super) bias: DVector<f32>,
}

/// Hidden ReLU layers and one output.
#[derive(Debug, Clone)]
pub(super) struct Layers {
    layers: Vec<Layer>,
    /// The output has a ReLU, too.
    rectified: bool,
}

impl Layers {
    /// Weights and biases uniform within ±√(6 / (in + out)) (Glorot and Bengio 2010, Eq. 16), as in
    /// scikit-learn.
    pub(super) fn new(inputs: usize, settings: &Settings, rng: &mut ChaCha8Rng) -> Self {
        let mut sizes = vec![inputs];
        sizes.extend(vec![settings.width; settings.hidden_layers]);
        sizes.push(1);
        let layer = |pair: &[usize]| {
            let (fan_in, fan_out) = (pair[0], pair[1]);
            let bound = (6.0 / (fan_in + fan_out) as f32).sqrt();
            let mut uniform = |_, _| bound * (2.0 * rng.random::<f32>() - 1.0);
            let weight = DMatrix::from_fn(fan_out, fan_in, &mut uniform);
            Layer { weight, bias: DVector::from_fn(fan_out, uniform) }
        };
        Self { layers: sizes.windows(2).map(layer).collect(), rectified: settings.rectified }
    }

    /// Raises the output's bias: a rectified output that starts below 0 for every row would never
    /// learn.
    pub(super) fn lift(&mut self, by: f32) {
        if let Some(last) = self.layers.last_mut() {
            last.bias.add_scalar_mut(by);
        }
    }

    /// One output for every column.
    pub(super) fn output(&self, inputs: &DMatrix<f32>) -> RowDVector<f32> {
        let outputs = self.forward(inputs).pop();
        outputs.map_or_else(|| RowDVector::zeros(0), |last| last.row(0).into_owned())
    }

    /// What every layer gives, the output last.
    pub(super) fn forward(&self, inputs: &DMatrix<f32>) -> Vec<DMatrix<f32>> {
        let mut signals: Vec<DMatrix<f32>> = Vec::with_capacity(self.layers.len());
        for (index, Layer { weight, bias }) in self.layers.iter().enumerate() {
            let before = signals.last().unwrap_or(inputs);
            let mut after = DMatrix::from_fn(weight.nrows(), before.ncols(), |output, _| bias[output]);
            after.gemm(1.0, weight, before, 1.0);
            if self.is_rectified(index) {
                after.apply(|value| *value = value.max(0.0));
            }
            signals.push(after);
        }
        signals
    }

    /// The derivative by every weight and bias, given what [`Self::forward`] gave and the
    /// derivative by the output.
    pub(super) fn backward(
        &self,
        inputs: &DMatrix<f32>,
        signals: &[DMatrix<f32>],
        mut slopes: DMatrix<f32>,
    ) -> Vec<Layer> {
        let mut gradient = Vec::with_capacity(self.layers.len());
        for (index, layer) in self.layers.iter().enumerate().rev() {
            if self.is_rectified(index) {
                // The derivative at 0 itself is 0, as in scikit-learn.
                slopes.zip_apply(&signals[index], |slope, signal| {
                    *slope = if signal > 0.0 { *slope } else { 0.0 };
                });
            }
            // Explicit transposes: nalgebra's fast product needs matrices as they are stored.
            let before = if index == 0 { inputs } else { &signals[index - 1] };
            gradient.push(Layer { weight: &slopes * before.transpose(), bias: slopes.column_sum() });
            if index > 0 {
                slopes = layer.weight.transpose() * slopes;
            }
        }
        gradient.reverse();
        gradient
    }

    fn is_rectified(&self, index: usize) -> bool {
        self.rectified || index + 1 < self.layers.len()
    }

    /// Weights and biases, layer by layer.
    pub(super) fn layers_mut(&mut self) -> &mut [Layer] {
        &mut self.layers
    }

    /// ReLU turns NaN into 0, so that a loss can look sound while weights are not.
    pub(super) fn is_finite(&self) -> bool {
        let values = |layer: &Layer| layer.weight.iter().chain(&layer.bias).all(|value| value.is_finite());
        self.layers.iter().all(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    fn wave(rows: usize, columns: usize, k: f32) -> DMatrix<f32> {
        DMatrix::from_fn(rows, columns, |i, j| ((i * columns + j + 1) as f32 * k).sin())
    }

    /// Derivatives against central differences of Σ slope · output. The outputs are linear in one
    /// parameter between two kinks of ReLUs, so that a difference over 2h errs by rounding only:
    /// sums of about 10 in f32 err by 1e-6, over 2h = 0.02 that is 5e-5 (times 4); a kink inside
    /// the step is seen by one-sided slopes that differ, and passed over.
    #[test]
    fn derivatives_agree_with_differences() {
        for rectified in [false, true] {
            let settings = Settings { hidden_layers: 3, width: 6, rectified, ..Settings::SMALL };
            let mut layers = Layers::new(4, &settings, &mut ChaCha8Rng::seed_from_u64(1));
            let (inputs, slopes) = (wave(4, 9, 0.7), wave(1, 9, 0.3));
            let gradient = layers.backward(&inputs, &layers.forward(&inputs), slopes.clone());
            let (mut compared, mut passed_over) = (0, 0);
            for (index, expected) in gradient.iter().enumerate() {
                let weights = expected.weight.len();
                for place in 0..weights + expected.bias.len() {
                    let mut at = |change: f32| {
                        let layer = &mut layers.layers_mut()[index];
                        let value = if place < weights {
                            &mut layer.weight[place]
                        } else {
                            &mut layer.bias[place - weights]
                        };
                        let before = *value;
                        *value += change;
                        let sum = layers.output(&inputs).dot(&slopes.row(0));
                        let layer = &mut layers.layers_mut()[index];
                        if place < weights {
                            layer.weight[place] = before;
                        } else {
                            layer.bias[place - weights] = before;
                        }
                        sum
                    };
                    let (below, here, above) = (at(-0.01), at(0.0), at(0.01));
                    if ((above - here) - (here - below)).abs() > 4e-6 {
                        passed_over += 1;
                        continue;
                    }
                    let by =
                        if place < weights { expected.weight[place] } else { expected.bias[place - weights] };
                    assert!(((above - below) / 0.02 - by).abs() < 2e-4, "{index} {place}: {by}");
                    compared += 1;
                }
            }
            assert!(compared > 3 * passed_over, "{compared} {passed_over}");
        }
    }

    /// One neuron by hand: 2·3 − 1 = 5 passes, 2·0 − 1 does not, and the output weighs it with −0.5
    /// and adds 1.
    #[test]
    fn two_layers_by_hand() {
        let layer = |weight: f32, bias: f32| Layer {
            weight: DMatrix::from_element(1, 1, weight),
            bias: DVector::from_element(1, bias),
        };
        let layers = |rectified| Layers { layers: vec![layer(2.0, -1.0), layer(-0.5, 1.0)], rectified };
        let inputs = DMatrix::from_row_slice(1, 2, &[3.0, 0.0]);
        assert_eq!(layers(false).output(&inputs).as_slice(), [-1.5, 1.0]);
        assert_eq!(layers(true).output(&inputs).as_slice(), [0.0, 1.0]);
    }

    /// Outputs and derivatives of a small network against NumPy's in double precision: each is a
    /// sum of at most 32 products of single precision, 6e-8 a rounding, through three layers; the
    /// largest intermediate is below 10.
    #[test]
    fn outputs_and_derivatives_are_numpys() {
        let reference = crate::baselines::testing::reference("network");
        let numbers =
            |value: &serde_json::Value| -> Vec<f32> { serde_json::from_value(value.clone()).unwrap() };
        let matrix = |value: &serde_json::Value| {
            let rows: Vec<Vec<f32>> = serde_json::from_value(value.clone()).unwrap();
            DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
        };
        let read = |value: &serde_json::Value| Layer {
            weight: matrix(&value["weight"]),
            bias: DVector::from_vec(numbers(&value["bias"])),
        };
        let all = |name: &str| reference[name].as_array().unwrap().iter().map(read).collect::<Vec<Layer>>();
        let layers = Layers { layers: all("layers"), rectified: false };
        let (inputs, slopes) = (matrix(&reference["inputs"]), numbers(&reference["slopes"]));
        let within = 3.0 * 32.0 * 6e-8 * 10.0;
        for (value, expected) in layers.output(&inputs).iter().zip(numbers(&reference["outputs"])) {
            assert!((value - expected).abs() < within, "{value} {expected}");
        }
        let slopes = DMatrix::from_row_slice(1, slopes.len(), &slopes);
        let gradient = layers.backward(&inputs, &layers.forward(&inputs), slopes);
        assert_eq!(gradient.len(), 3);
        for (layer, expected) in gradient.iter().zip(all("gradient")) {
            assert!((&layer.weight - &expected.weight).amax() < within, "{layer:?} {expected:?}");
            assert!((&layer.bias - &expected.bias).amax() < within, "{layer:?} {expected:?}");
        }
    }
}
