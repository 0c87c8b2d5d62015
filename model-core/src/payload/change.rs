//! Detects that the payload has changed: two-sided CUSUM on the buckets' surprise.

use crate::real::Real;

/// Settings, in standard deviations of one bucket's surprise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Threshold<T> {
    /// Drift k taken off each bucket: shifts below 2 k are ignored in the long run.
    pub drift: T,
    /// Alarm level h. Independent normal surprises reach it once in about e^(2 k h) / (2 k²)
    /// buckets.
    pub level: T,
}

impl<T: Real> Default for Threshold<T> {
    /// k = 1, h = 15: no false alarm to speak of if the fit's noise holds, and room for it to be
    /// half of the truth.
    fn default() -> Self {
        Self { drift: T::ONE, level: T::from_f64(15.0) }
    }
}

/// One side of the test.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Side<T> {
    sum: T,
    buckets: usize,
}

impl<T: Real> Side<T> {
    fn push(&mut self, surprise: T, threshold: &Threshold<T>) -> Option<usize> {
        self.sum = self.sum + surprise - threshold.drift;
        if self.sum > T::ZERO {
            self.buckets = self.buckets.saturating_add(1);
        } else {
            *self = Self::default();
        }
        (self.sum > threshold.level).then_some(self.buckets)
    }
}

/// The detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cusum<T> {
    threshold: Threshold<T>,
    heavier: Side<T>,
    lighter: Side<T>,
}

impl<T: Real> Cusum<T> {
    /// Nothing seen yet.
    pub fn new(threshold: Threshold<T>) -> Self {
        Self { threshold, heavier: Side::default(), lighter: Side::default() }
    }

    /// Takes the surprise of one bucket. `Some(n)`: the payload changed before the latest `n`
    /// buckets.
    ///
    /// One bucket's surprise counts for at most half the alarm level: a single outlier is no
    /// payload.
    pub fn push(&mut self, surprise: T) -> Option<usize> {
        let most = self.threshold.level * T::HALF + self.threshold.drift;
        let surprise = surprise.at_least(-most).at_most(most);
        let heavier = self.heavier.push(surprise, &self.threshold);
        let lighter = self.lighter.push(-surprise, &self.threshold);
        let change = heavier.or(lighter);
        if change.is_some() {
            *self = Self::new(self.threshold);
        }
        change
    }

    /// Forgets what it has seen.
    pub fn reset(&mut self) {
        *self = Self::new(self.threshold);
    }
}

#[cfg(test)]
mod tests {
    use super::{Cusum, Threshold};

    #[test]
    fn dates_the_change() {
        let mut detector = Cusum::<f64>::new(Threshold::default());
        for i in 0..1000 {
            assert_eq!(detector.push(if i % 2 == 0 { 1.5 } else { -1.5 }), None);
        }
        assert_eq!(detector.push(0.0), None);
        // Shift of 4: the sum passes 15 with the sixth bucket.
        let alarms: std::vec::Vec<_> = (0..6).map(|_| detector.push(-4.0)).collect();
        assert_eq!(alarms.iter().flatten().next(), Some(&6));
    }

    #[test]
    fn one_outlier_is_no_change() {
        let mut detector = Cusum::<f64>::new(Threshold::default());
        assert_eq!(detector.push(1e9), None);
        for _ in 0..20 {
            assert_eq!(detector.push(0.0), None);
        }
    }
}
