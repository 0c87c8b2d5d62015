//! Energy: the integral of the power that counts.
//!
//! Eq. 9 counts its positive part: a drive that burns braking power takes nothing back, and what is
//! below 0 there is noise. Where drives return braking power, energy is what the battery gives less
//! what it takes ([`energy_floor`](crate::coefficients::Coefficients::energy_floor)).

use crate::real::Real;

/// Running ∫ P dt in J, compensated so that single precision keeps counting after hours of
/// milliwatt-seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy<T> {
    sum: T,
    /// What the sum's last digit could not take (Kahan).
    owed: T,
}

impl<T: Real> Energy<T> {
    /// Adds `power` (W, of either sign) held for `duration` (s). What is not finite adds nothing,
    /// nor does time that runs backwards.
    #[inline]
    pub fn add(&mut self, power: T, duration: T) {
        let joules = power * duration;
        if !(joules.is_finite() && duration > T::ZERO) {
            return;
        }
        let term = joules - self.owed;
        let sum = self.sum + term;
        self.owed = (sum - self.sum) - term;
        self.sum = sum;
    }

    /// So far, J.
    pub fn joules(&self) -> T {
        self.sum
    }
}

#[cfg(test)]
mod tests {
    use super::Energy;

    /// 10 h of 1.5 W out and 0.5 W back: plain single-precision summing is off by percents.
    #[test]
    fn counts_for_hours_in_single_precision() {
        let mut energy = Energy::<f32>::default();
        for _ in 0..7_200_000 {
            energy.add(1.5, 0.005);
            energy.add(-0.5, 0.005);
            energy.add(f32::NAN, 0.005);
            energy.add(1.0, -0.005);
        }
        assert!((energy.joules() / 36_000.0 - 1.0).abs() < 1e-6, "{}", energy.joules());
    }
}
