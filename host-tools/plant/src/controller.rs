//! Wheel speed loop: proportional-integral with feed-forward of the back EMF and a voltage limit.

/// Gains of the loop, per wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// Volts per wheel speed asked for, V/(rad/s): normally the back EMF seen at the wheel.
    pub feed_forward: f64,
    /// Volts per speed error, V/(rad/s).
    pub proportional: f64,
    /// Volts per speed error and second, V/rad.
    pub integral: f64,
    /// Below this speed, rad/s, a wheel with command 0 is switched off instead of held: a
    /// servo that integrates against stiction would heat its winding at rest.
    pub rest_band: f64,
}

/// State of one wheel's loop.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Controller {
    integral: f64,
}

impl Controller {
    /// Voltage for the next period of `dt` seconds, within ±`limit`.
    pub fn update(&mut self, gains: &Gains, target: f64, measured: f64, limit: f64, dt: f64) -> f64 {
        if target == 0.0 && measured.abs() < gains.rest_band {
            self.integral = 0.0;
            return 0.0;
        }
        let error = target - measured;
        let integral = self.integral + gains.integral * error * dt;
        let wanted = gains.feed_forward * target + gains.proportional * error + integral;
        let voltage = wanted.clamp(-limit, limit);
        // Integrate only while the output follows, or when the error leads out of saturation.
        if voltage == wanted || (wanted - voltage) * error < 0.0 {
            self.integral = integral;
        }
        voltage
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAINS: Gains = Gains { feed_forward: 1.0, proportional: 2.0, integral: 10.0, rest_band: 0.05 };

    #[test]
    fn saturation_does_not_wind_up() {
        let mut controller = Controller::default();
        for _ in 0..10_000 {
            assert_eq!(controller.update(&GAINS, 20.0, 0.0, 12.0, 1e-3), 12.0);
        }
        // Without anti-windup 10 s · 10 · 20 = 2000 V would have gathered.
        let voltage = controller.update(&GAINS, 1.0, 1.0, 12.0, 1e-3);
        assert!((voltage - 1.0).abs() < 1e-9, "{voltage}");
    }

    #[test]
    fn a_wheel_told_to_stand_is_switched_off_at_rest_and_braked_before() {
        let mut controller = Controller::default();
        assert!(controller.update(&GAINS, 0.0, 1.0, 12.0, 1e-3) < 0.0);
        assert_eq!(controller.update(&GAINS, 0.0, 0.04, 12.0, 1e-3), 0.0);
    }
}
