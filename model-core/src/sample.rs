//! What is measured at one time.

use crate::real::Real;

/// One measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<T, const N: usize> {
    /// rad/s
    pub wheel_speed: [T; N],
    /// rad/s², where it is measured; otherwise the derivative of the filtered speed is taken.
    pub wheel_acceleration: Option<[T; N]>,
    /// Actuation power, W: static power already taken off.
    pub power: T,
}

impl<T: Real, const N: usize> Sample<T, N> {
    /// Every value is a finite number.
    pub fn is_finite(&self) -> bool {
        self.nought() == T::ZERO
    }

    /// 0 where every value is finite; otherwise no number, as zero times what is not finite is.
    #[inline]
    pub(crate) fn nought(&self) -> T {
        let mut nought = self.nought_of_readings();
        if let Some(measured) = &self.wheel_acceleration {
            for acceleration in measured {
                nought += *acceleration * T::ZERO;
            }
        }
        nought
    }

    /// The same of a sample whose accelerations are not measured.
    #[inline]
    pub(crate) fn nought_of_readings(&self) -> T {
        let mut nought = self.power * T::ZERO;
        for speed in &self.wheel_speed {
            nought += *speed * T::ZERO;
        }
        nought
    }
}
