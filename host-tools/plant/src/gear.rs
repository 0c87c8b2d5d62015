//! Reduction gear with a loss proportional to the power that passes.

/// The gear between motor shaft and wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gear {
    /// Motor turns per wheel turn.
    pub ratio: f64,
    /// Share of the power that arrives on the other side, in either direction.
    pub efficiency: f64,
}

/// The direction in which power passes the gear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Flow {
    /// Motor to wheel: the wheel gets `efficiency` of it.
    #[default]
    Driving,
    /// Wheel to motor: the motor gets `efficiency` of it.
    BackDriven,
}

impl Gear {
    /// Wheel torque per motor torque: n η when driving, n / η when back-driven.
    ///
    /// Back-driven, the gear's loss helps a braking motor, hence the division.
    pub fn torque_gain(&self, flow: Flow) -> f64 {
        match flow {
            Flow::Driving => self.ratio * self.efficiency,
            Flow::BackDriven => self.ratio / self.efficiency,
        }
    }

    /// The direction that fits a torque at the motor's side of the gear and a wheel speed.
    ///
    /// A wheel at rest (to rounding) counts as driven: that is how the motor would set it off.
    pub fn flow(shaft_torque: f64, wheel_speed: f64) -> Flow {
        if wheel_speed.abs() > 1e-9 && shaft_torque * wheel_speed < 0.0 {
            Flow::BackDriven
        } else {
            Flow::Driving
        }
    }
}
