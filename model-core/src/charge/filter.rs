//! The filter behind the gauge: six numbers of a cell and how well they are known.

use crate::real::Real;

/// Charge, error of the curve, three resistances, and what else the voltage does for a while.
pub(super) const STATES: usize = 6;

pub(super) const CHARGE: usize = 0;
/// What the cell's open-circuit voltage has beyond the curve's, V: another make, hysteresis, age.
pub(super) const OFFSET: usize = 1;
/// Resistance at once, and of the parts of the current that follow within seconds and minutes, Ω.
pub(super) const RESISTANCES: [usize; 3] = [2, 3, 4];
/// What neither curve nor resistances explain and lasts for minutes, V.
pub(super) const DRIFT: usize = 5;

/// A Kalman filter whose measurements are one number each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Filter<T> {
    pub(super) state: [T; STATES],
    covariance: [[T; STATES]; STATES],
}

impl<T: Real> Filter<T> {
    /// Independent numbers with these standard deviations.
    pub(super) fn new(state: [T; STATES], deviations: [T; STATES]) -> Self {
        let mut covariance = [[T::ZERO; STATES]; STATES];
        for (place, (row, deviation)) in covariance.iter_mut().zip(deviations).enumerate() {
            if let Some(variance) = row.get_mut(place) {
                *variance = deviation * deviation;
            }
        }
        Self { state, covariance }
    }

    /// Begins anew with a number that nothing has been learned of.
    pub(super) fn set(&mut self, place: usize, value: T, variance: T) {
        if let Some(number) = self.state.get_mut(place) {
            *number = value;
        }
        if let Some(entry) = self.covariance.get_mut(place).and_then(|row| row.get_mut(place)) {
            *entry = variance;
        }
    }

    /// Adds to the variance of a number.
    pub(super) fn loosen(&mut self, place: usize, variance: T) {
        if let Some(entry) = self.covariance.get_mut(place).and_then(|row| row.get_mut(place)) {
            *entry += variance;
        }
    }

    /// Forgets a share of a number, which returns to 0.
    pub(super) fn fade(&mut self, place: usize, keep: T) {
        if let Some(value) = self.state.get_mut(place) {
            *value = *value * keep;
        }
        for (index, row) in self.covariance.iter_mut().enumerate() {
            for (column, entry) in row.iter_mut().enumerate() {
                if index == place {
                    *entry = *entry * keep;
                }
                if column == place {
                    *entry = *entry * keep;
                }
            }
        }
    }

    /// Variance of a number.
    pub(super) fn variance(&self, place: usize) -> T {
        self.covariance.get(place).and_then(|row| row.get(place)).copied().unwrap_or(T::INFINITY)
    }

    /// Takes a measurement that is `surprise` beyond what the state makes expect, `slopes` being
    /// how it follows the state and `noise` its own variance. What is not finite changes nothing.
    pub(super) fn correct(&mut self, surprise: T, slopes: &[T; STATES], noise: T) {
        let mut spread = [T::ZERO; STATES];
        let mut variance = noise;
        for ((spread, row), slope) in spread.iter_mut().zip(&self.covariance).zip(slopes) {
            for (entry, slope) in row.iter().zip(slopes) {
                *spread += *entry * *slope;
            }
            variance += *slope * *spread;
        }
        let gain = T::ONE / variance;
        if !(surprise.is_finite() && gain.is_finite() && gain > T::ZERO) {
            return;
        }
        for (value, spread) in self.state.iter_mut().zip(&spread) {
            *value += gain * surprise * *spread;
        }
        for (place, (row, of_row)) in self.covariance.iter_mut().zip(&spread).enumerate() {
            for (column, (entry, of_column)) in row.iter_mut().zip(&spread).enumerate() {
                let less = *entry - gain * *of_row * *of_column;
                // Rounding leaves no variance below 0.
                *entry = if place == column { less.at_least(T::ZERO) } else { less };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One number known to ±2 and measured as 3 ± 1 from 0: the weighted mean 3 · 4 / 5, its
    /// variance 4 / 5.
    #[test]
    fn a_measurement_is_weighed_by_its_variance() {
        let mut filter = Filter::new([0.0; STATES], [2.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
        filter.correct(3.0, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0_f64);
        assert!((filter.state[0] - 2.4).abs() < 1e-12 && (filter.variance(0) - 0.8).abs() < 1e-12);
        assert_eq!(filter.variance(1), 1.0);
        let before = filter;
        filter.correct(f64::NAN, &[1.0; STATES], 1.0);
        filter.correct(1.0, &[f64::INFINITY; STATES], 1.0);
        assert_eq!(filter, before);
        filter.fade(0, 0.5);
        assert!((filter.variance(0) - 0.2).abs() < 1e-12 && (filter.state[0] - 1.2).abs() < 1e-12);
    }
}
