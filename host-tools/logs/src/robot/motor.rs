//! What a data sheet says of a motor, and what it draws to give a torque.

/// What a data sheet says of the motor that drives the wheels of one log column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motor {
    /// Terminal resistance, Ω.
    pub resistance_ohm: f64,
    /// Torque constant, N·m/A.
    pub torque_constant_nm_a: f64,
    /// Turns of the motor per turn of the wheel.
    pub gear_ratio: f64,
    /// Efficiency of the gear, 0 to 1, where it is known.
    pub gear_efficiency: Option<f64>,
}

impl Motor {
    /// What it draws to give the wheel a torque (N·m) at a speed (rad/s), W: the gear keeps its
    /// share in the direction in which power flows, the winding heats by the current squared. Below
    /// 0 where it brakes.
    pub fn power_w(&self, torque: f64, speed: f64) -> f64 {
        let efficiency = self.gear_efficiency.unwrap_or(1.0);
        let drives = torque * speed >= 0.0;
        let ahead_of_gear = if drives { torque / efficiency } else { torque * efficiency };
        let current = ahead_of_gear / (self.torque_constant_nm_a * self.gear_ratio);
        ahead_of_gear * speed + self.resistance_ohm * current * current
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1 Ω, 0.1 N·m/A, 1:10: one newton metre at the wheel is 1 A and 1 W of heat; a gear of 0.8
    /// asks for 1.25 of them.
    #[test]
    fn a_torque_costs_its_work_and_the_heat_of_its_current() {
        let ideal =
            Motor { resistance_ohm: 1.0, torque_constant_nm_a: 0.1, gear_ratio: 10.0, gear_efficiency: None };
        assert_eq!(ideal.power_w(1.0, 2.0), 3.0);
        assert_eq!(ideal.power_w(1.0, -2.0), -1.0);
        let real = Motor { gear_efficiency: Some(0.8), ..ideal };
        assert!((real.power_w(1.0, 2.0) - (2.5 + 1.5625)).abs() < 1e-12);
        assert!((real.power_w(1.0, -2.0) - (-1.6 + 0.64)).abs() < 1e-12);
    }
}
