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
        self.zero_if_finite() == T::ZERO
    }

    /// 0 where every value is finite, else NaN: zero times what is not finite is NaN.
    #[inline]
    pub(crate) fn zero_if_finite(&self) -> T {
        let mut zero = self.zero_if_readings_finite();
        if let Some(measured) = &self.wheel_acceleration {
            for acceleration in measured {
                zero += *acceleration * T::ZERO;
            }
        }
        zero
    }

    /// The same without the accelerations.
    #[inline]
    pub(crate) fn zero_if_readings_finite(&self) -> T {
        let mut zero = self.power * T::ZERO;
        for speed in &self.wheel_speed {
            zero += *speed * T::ZERO;
        }
        zero
    }
}
