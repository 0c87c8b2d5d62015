//! Adam: steps by running means of the derivative and of its square (Kingma and Ba 2015, Algorithm
//! 1).

use super::layers::Layer;

/// Decay of the mean, and of the mean square: the source's usual ones.
const DECAY: (f32, f32) = (0.9, 0.999);

/// Keeps the division finite.
const EPSILON: f32 = 1e-8;

/// Running means, in the order of the parameters.
#[derive(Debug, Clone, Default)]
pub(super) struct Adam {
    steps: i32,
    /// Mean and mean square of the derivative by each parameter.
    moments: Vec<(f32, f32)>,
}

impl Adam {
    /// One step of about the size `rate` against the gradient.
    pub(super) fn step(&mut self, layers: &mut [Layer], gradient: &[Layer], rate: f32) {
        self.steps += 1;
        // Means that began at 0 are too small at first.
        let (grown, square_grown) = (1.0 - DECAY.0.powi(self.steps), 1.0 - DECAY.1.powi(self.steps));
        let count: usize = layers.iter().map(|layer| layer.weight.len() + layer.bias.len()).sum();
        self.moments.resize(count, (0.0, 0.0));
        let values = layers
            .iter_mut()
            .flat_map(|layer| [layer.weight.as_mut_slice(), layer.bias.as_mut_slice()].into_iter().flatten());
        let slopes = gradient
            .iter()
            .flat_map(|layer| [layer.weight.as_slice(), layer.bias.as_slice()].into_iter().flatten());
        for ((value, slope), (mean, square)) in values.zip(slopes).zip(&mut self.moments) {
            *mean += (1.0 - DECAY.0) * (slope - *mean);
            *square += (1.0 - DECAY.1) * (slope * slope - *square);
            *value -= rate * (*mean / grown) / ((*square / square_grown).sqrt() + EPSILON);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    fn layer(weight: f32, bias: f32) -> Layer {
        Layer { weight: DMatrix::from_element(1, 1, weight), bias: DVector::from_element(1, bias) }
    }

    /// The first step is `rate` against the sign, whatever the size of the derivative. The second,
    /// by the algorithm: derivatives 4 then −1 have the corrected mean (0.9·0.1·4 − 0.1)/(1 − 0.81)
    /// = 0.26/0.19 and the corrected square (0.999·0.001·16 + 0.001)/(1 − 0.998001) =
    /// 0.016984/0.001999. f32 keeps 1e-4 of the small square's correction.
    #[test]
    fn steps_as_its_source_says() {
        let (mut adam, mut layers) = (Adam::default(), [layer(1.0, 2.0)]);
        adam.step(&mut layers, &[layer(4.0, -1e-3)], 0.1);
        assert!((layers[0].weight[0] - 0.9).abs() < 1e-6 && (layers[0].bias[0] - 2.1).abs() < 1e-5);
        adam.step(&mut layers, &[layer(-1.0, -1e-3)], 0.1);
        let expected = 0.9 - 0.1 * (0.26_f32 / 0.19) / (0.016_984_f32 / 0.001_999).sqrt();
        assert!((layers[0].weight[0] - expected).abs() < 1e-5, "{} {expected}", layers[0].weight[0]);
        assert!((layers[0].bias[0] - 2.2).abs() < 2e-5, "{}", layers[0].bias[0]);
    }
}
