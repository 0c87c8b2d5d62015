//! Scales inputs and power to about unit size, with which networks learn best.

use nalgebra::DMatrix;

/// To zero mean and unit variance.
#[derive(Debug, Clone, Copy, PartialEq)]
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
}

/// Scales a network's values of a point to its inputs, and its output to a power.
#[derive(Debug, Clone)]
pub(super) struct Scaling {
    /// Quantities that change in training, by their place: a differential drive has no vy.
    changing: Vec<(usize, Standard)>,
    power: Standard,
}

impl Scaling {
    /// From the training; `None` without an input that changes. A rectified output keeps its zero.
    pub(super) fn new(seen: &[Vec<f64>], powers: &[f64], rectified: bool) -> Option<Self> {
        let places = 0..seen.first()?.len();
        let standard = |place: usize| Some((place, Standard::new(seen.iter().map(|row| row[place]))?));
        let changing: Vec<_> = places.filter_map(standard).collect();
        let mut power = Standard::new(powers.iter().copied())?;
        if rectified {
            power.mean = 0.0;
        }
        (!changing.is_empty()).then_some(Self { changing, power })
    }

    /// One column a point.
    pub(super) fn inputs(&self, seen: &[Vec<f64>]) -> DMatrix<f32> {
        DMatrix::from_fn(self.changing.len(), seen.len(), |input, point| {
            let (place, standard) = self.changing[input];
            standard.apply(seen[point][place])
        })
    }

    /// One row.
    pub(super) fn outputs(&self, powers: &[f64]) -> DMatrix<f32> {
        DMatrix::from_fn(1, powers.len(), |_, point| self.power.apply(powers[point]))
    }

    /// W
    pub(super) fn power(&self, output: f32) -> f64 {
        self.power.mean + self.power.std * f64::from(output)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 and 3 have mean 2 and standard deviation 1; the second quantity stays and is not an input;
    /// powers 10 and 30 W.
    #[test]
    fn scales_what_changes() {
        let (seen, powers) = ([vec![1.0, 7.0], vec![3.0, 7.0]], [10.0, 30.0]);
        let scaling = Scaling::new(&seen, &powers, false).unwrap();
        assert_eq!(scaling.inputs(&seen), DMatrix::from_row_slice(1, 2, &[-1.0, 1.0]));
        assert_eq!(scaling.outputs(&powers), DMatrix::from_row_slice(1, 2, &[-1.0, 1.0]));
        assert_eq!(scaling.power(1.0), 30.0);
        let rectified = Scaling::new(&seen, &powers, true).unwrap();
        assert_eq!((rectified.power(0.0), rectified.power(3.0)), (0.0, 30.0));
        assert!(Scaling::new(&seen, &[5.0, 5.0], false).is_none());
        assert!(Scaling::new(&[vec![7.0], vec![7.0]], &powers, false).is_none());
        assert!(Scaling::new(&[], &[], false).is_none());
    }
}
