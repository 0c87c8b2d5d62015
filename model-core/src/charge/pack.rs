//! What is known of a battery beforehand.

use super::Curve;
use crate::real::Real;

/// A pack of cells in series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pack<T> {
    /// What it gives from full to empty, A·s.
    pub capacity: T,
    /// Cells in series.
    pub cells: T,
    /// Of one cell.
    pub curve: Curve<T>,
    /// Voltage under load at which the robot stops, V; 0 where it does not look.
    pub cutoff: T,
}

/// What no pack can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InvalidPack {
    /// Which value.
    pub name: &'static str,
    /// What is allowed.
    pub expected: &'static str,
}

impl<T: Real> Pack<T> {
    /// Of a capacity in A·h, cells in series, the curve of one cell, and the voltage in V at which
    /// the robot stops.
    ///
    /// # Errors
    /// A value that no pack has.
    pub fn new(capacity_ah: T, cells: T, curve: Curve<T>, cutoff: T) -> Result<Self, InvalidPack> {
        let within = |value: T, from: f64, to: f64| value >= T::from_f64(from) && value <= T::from_f64(to);
        if !within(capacity_ah, 0.01, 1e5) {
            return Err(InvalidPack { name: "capacity_ah", expected: "0.01 to 100000 A·h" });
        }
        if !within(cells, 1.0, 400.0) {
            return Err(InvalidPack { name: "cells", expected: "1 to 400" });
        }
        if !within(cutoff, 0.0, 2000.0) {
            return Err(InvalidPack { name: "cutoff_v", expected: "0 to 2000 V" });
        }
        Ok(Self { capacity: T::from_f64(3600.0) * capacity_ah, cells, curve, cutoff })
    }

    /// ROBOTIS LB-012 of the TurtleBot3: three cells, 11.1 V, 1800 mAh, 19.98 Wh (its label). Below
    /// 11 V the stock firmware cuts the motors. Its cells' curve is not published: that of
    /// [`Curve::lithium_ion`].
    pub fn turtlebot3() -> Self {
        Self {
            capacity: T::from_f64(1.8 * 3600.0),
            cells: T::from_f64(3.0),
            curve: Curve::lithium_ion(),
            cutoff: T::from_f64(11.0),
        }
    }

    /// The charge below which nothing can be used: where the voltage of a cell that `drop` V of
    /// load pull down reaches the cutoff, or a reserve.
    fn floor(&self, reserve: T, drop: T) -> T {
        if self.cutoff > T::ZERO {
            self.curve.charge(self.cutoff / self.cells + drop).at_least(reserve)
        } else {
            T::ZERO.at_least(reserve)
        }
    }

    /// What it gives from a charge down to cutoff or reserve, J, while load pulls each cell down by
    /// `drop` V; not below 0.
    pub fn energy(&self, charge: T, reserve: T, drop: T) -> T {
        let from = self.floor(reserve, drop);
        let given = self.curve.energy(from, charge) - T::ZERO.at_least(charge - from) * drop;
        T::ZERO.at_least(given) * self.cells * self.capacity
    }

    /// The charge after so much energy, J, given under such a load; 0 where it holds less.
    pub fn after(&self, charge: T, energy: T, drop: T) -> T {
        let share = energy / (self.cells * self.capacity);
        let given = |low: T| self.curve.energy(low, charge) - (charge - low) * drop;
        if given(T::ZERO) <= share {
            return T::ZERO;
        }
        // Half the stretch each time: after thirty it is below single precision.
        let (mut low, mut high) = (T::ZERO, charge);
        for _ in 0..30 {
            let middle = T::HALF * (low + high);
            if given(middle) > share {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// In another precision.
    pub fn convert<U: Real>(&self) -> Option<Pack<U>> {
        let number = |value: T| U::from_f64(value.to_f64());
        let points = self.curve.points().iter();
        let points =
            points.map(|point| super::Point { charge: number(point.charge), voltage: number(point.voltage) });
        Some(Pack {
            capacity: number(self.capacity),
            cells: number(self.cells),
            curve: Curve::new(points)?,
            cutoff: number(self.cutoff),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Point;
    use super::*;

    fn pack(cutoff: f64) -> Pack<f64> {
        let points = [(0.0, 3.0), (1.0, 4.0)].map(|(charge, voltage)| Point { charge, voltage });
        Pack::new(1.0, 2.0, Curve::new(points).unwrap(), cutoff).unwrap()
    }

    /// By hand: two cells of 3600 A·s, straight from 3 to 4 V. Full to empty 2 · 3600 · 3.5 J; with
    /// 0.1 V less under load 3.4; down to 6.4 V that load ends at a charge of 0.3, from where on
    /// the cells have 3.65 − 0.1 V on average.
    #[test]
    fn energy_ends_at_the_cutoff_under_load() {
        let near = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-6, "{value} {expected}");
        near(pack(0.0).energy(1.0, 0.0, 0.0), 2.0 * 3600.0 * 3.5);
        near(pack(0.0).energy(1.0, 0.0, 0.1), 2.0 * 3600.0 * 3.4);
        near(pack(6.4).energy(1.0, 0.0, 0.1), 2.0 * 3600.0 * 0.7 * 3.55);
        near(pack(6.4).energy(1.0, 0.5, 0.1), 2.0 * 3600.0 * 0.5 * 3.65);
        assert_eq!(pack(6.4).energy(0.2, 0.0, 0.1), 0.0);
        near(pack(0.0).after(1.0, 2.0 * 3600.0 * 0.5 * 3.65, 0.1), 0.5);
        assert_eq!(pack(0.0).after(0.5, 1e9, 0.0), 0.0);
    }
}
