//! The motor drive: what the supply has to give for what the motor takes.

/// Power stage between supply and motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Efficiency η_c of the stage; the supply gives P / η_c (paper Eq. 2, C_c = 1/η_c).
    pub efficiency: f64,
    /// Whether braking power returns to the supply. The paper's drives prohibit it (Section 6).
    pub regeneration: bool,
}

impl Default for Drive {
    /// No loss of its own, no regeneration: the paper's simulation.
    fn default() -> Self {
        Self { efficiency: 1.0, regeneration: false }
    }
}

impl Drive {
    /// Power drawn from the supply, W, for one motor at `voltage` and `current`.
    pub fn supply_power(&self, voltage: f64, current: f64) -> f64 {
        let motor = voltage * current;
        if motor >= 0.0 {
            motor / self.efficiency
        } else if self.regeneration {
            motor * self.efficiency
        } else {
            0.0
        }
    }
}
