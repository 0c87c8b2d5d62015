//! Brushed DC motor: winding and rotor.

/// One motor, seen from its own shaft (before the gear).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motor {
    /// Winding resistance, Ω.
    pub resistance_ohm: f64,
    /// Winding inductance, H.
    pub inductance_h: f64,
    /// Torque per current, N·m/A.
    pub torque_constant: f64,
    /// Voltage per shaft speed, V/(rad/s). Equal to the torque constant in a motor that conserves
    /// energy.
    pub electrical_constant: f64,
    /// Rotor inertia, kg·m².
    pub rotor_inertia: f64,
    /// Viscous friction of rotor and first gear stages, N·m/(rad/s).
    pub viscous: f64,
    /// Drag of the air that rotor or fan stir, N·m/(rad/s)².
    pub windage: f64,
    /// Coulomb friction of brushes, bearings and first gear stages, N·m.
    pub coulomb: f64,
}

/// What flowed through a winding during one step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Current {
    /// Current at the end of the step, A.
    pub end: f64,
    /// Mean over the step, A.
    pub mean: f64,
    /// Mean of the square over the step, A²: what heats the copper.
    pub mean_square: f64,
}

impl Motor {
    /// Torque, N·m, that grease and air take from a shaft of this speed, rad/s.
    pub fn drag(&self, shaft_speed: f64) -> f64 {
        self.viscous * shaft_speed + self.windage * shaft_speed * shaft_speed.abs()
    }

    /// Solves L di/dt + R i = V − Ke w over one step of `h` seconds with voltage and shaft speed
    /// held.
    ///
    /// The solution is exact, so that L/R may be shorter than the step (it is for small coreless
    /// motors).
    pub fn conduct(&self, start: f64, voltage: f64, shaft_speed: f64, h: f64) -> Current {
        let settled = (voltage - self.electrical_constant * shaft_speed) / self.resistance_ohm;
        let time_constant = self.inductance_h / self.resistance_ohm;
        let decay = (-h / time_constant).exp();
        let excess = start - settled;
        // Integrals of exp(−t/T) and exp(−2t/T) over the step, divided by the step.
        let first = (1.0 - decay) * time_constant / h;
        let second = (1.0 - decay * decay) * time_constant / (2.0 * h);
        Current {
            end: settled + excess * decay,
            mean: settled + excess * first,
            mean_square: settled * settled + 2.0 * settled * excess * first + excess * excess * second,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against forward Euler with ten thousand steps within one: its error is about T_step/2τ of
    /// the change, where T_step = 1e-7 s, τ = 0.96 ms (Table 3): 5e-5.
    #[test]
    fn the_winding_follows_its_differential_equation() {
        let motor = Motor {
            resistance_ohm: 0.75,
            inductance_h: 0.72e-3,
            torque_constant: 0.037,
            electrical_constant: 0.0072,
            rotor_inertia: 0.0,
            viscous: 0.0,
            windage: 0.0,
            coulomb: 0.0,
        };
        let (mut current, mut sum, mut sum_square) = (-0.5, 0.0, 0.0);
        for _ in 0..10_000 {
            sum += current;
            sum_square += current * current;
            current += 1e-7 * (12.0 - 0.75 * current - 0.0072 * 1500.0) / 0.72e-3;
        }
        let step = motor.conduct(-0.5, 12.0, 1500.0, 1e-3);
        assert!((step.end - current).abs() < 1e-4, "{step:?} {current}");
        assert!((step.mean - sum / 1e4).abs() < 2e-4, "{step:?} {}", sum / 1e4);
        assert!((step.mean_square - sum_square / 1e4).abs() < 2e-4, "{step:?} {}", sum_square / 1e4);
    }
}
