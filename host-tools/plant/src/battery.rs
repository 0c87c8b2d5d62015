//! A battery: what its terminals show and what is truly in it. Shares no formula with
//! `model_core::charge`.
//!
//! Cells of a different make: their own open-circuit curve, with hysteresis; a drop over
//! electrolyte and electrodes that grows in the cold and towards empty; charge transfer whose
//! overvoltage follows the current's inverse hyperbolic sine (Butler and Volmer); diffusion as two
//! reservoirs, the surface's charge running ahead of the cell's; and a temperature that the losses
//! raise.

/// Open-circuit voltage of a cell Samsung INR21700-40T over charge, discharged and charged at C/20
/// and room temperature, the mean of both (S. Sunil, K. R. Pattipati, B. Balasingam, IEEE
/// Transactions on Instrumentation and Measurement, 2025).
pub const CURVE: [(f64, f64); 10] = [
    (0.0, 2.5000),
    (0.0050, 2.8080),
    (0.0352, 3.1179),
    (0.0854, 3.3182),
    (0.1357, 3.4193),
    (0.2915, 3.5826),
    (0.4523, 3.6941),
    (0.8392, 4.0664),
    (0.9548, 4.1121),
    (1.0, 4.2000),
];

/// What a pack is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Battery {
    /// True capacity, A·h.
    pub capacity_ah: f64,
    /// Cells in series.
    pub cells: f64,
    /// Ohmic resistance of a cell at 25 °C and half full, Ω.
    pub ohmic_ohm: f64,
    /// Resistance of the charge transfer at small currents, 25 °C, Ω.
    pub transfer_ohm: f64,
    /// Its time constant, s.
    pub transfer_s: f64,
    /// How long charge takes from the inside to the surface of the electrodes, s.
    pub diffusion_s: f64,
    /// Half the distance of the charging and the discharging curve, V.
    pub hysteresis_v: f64,
    /// Temperature around it, °C.
    pub ambient_c: f64,
    /// Of a cell's whole curve against the table, V.
    pub curve_offset_v: f64,
}

/// A pack at an instant.
#[derive(Debug, Clone, Copy)]
pub struct BatteryState {
    battery: Battery,
    /// Charge of inner and outer reservoir, shares of the capacity at which each would be in
    /// balance.
    inner: f64,
    outer: f64,
    transfer_v: f64,
    hysteresis: f64,
    temperature_c: f64,
}

/// The outer reservoir's part of the capacity.
const OUTER: f64 = 0.5;
/// A·h that a cell has to pass to change from one curve to the other, as a share of its capacity.
const HYSTERESIS_SHARE: f64 = 0.03;
/// Gas constant over Faraday's, V/K.
const R_OVER_F: f64 = 8.314 / 96_485.0;
/// Activation energy of a cell's resistances, J/mol: some 20 kJ/mol for such cells.
const ACTIVATION_J: f64 = 20_000.0;
/// Heat capacity of a cell of 45 g, J/K, and what it gives to the air, W/K.
const HEAT_J_K: f64 = 42.0;
const COOLING_W_K: f64 = 0.07;

impl Battery {
    /// At rest since long at this charge, 0 to 1.
    pub fn at(self, charge: f64) -> BatteryState {
        BatteryState {
            battery: self,
            inner: charge,
            outer: charge,
            transfer_v: 0.0,
            hysteresis: 0.0,
            temperature_c: self.ambient_c,
        }
    }
}

impl BatteryState {
    /// True charge, a share of the true capacity.
    pub fn charge(&self) -> f64 {
        (1.0 - OUTER) * self.inner + OUTER * self.outer
    }

    /// Of the cells, °C.
    pub fn temperature_c(&self) -> f64 {
        self.temperature_c
    }

    /// A current, A, positive while discharging, for a short time, s. Gives the voltage at the
    /// terminals, V.
    pub fn draw(&mut self, current: f64, elapsed: f64) -> f64 {
        let battery = self.battery;
        let capacity = 3600.0 * battery.capacity_ah;
        let between = (self.inner - self.outer) * elapsed / battery.diffusion_s;
        self.inner -= between * OUTER / (1.0 - OUTER);
        self.outer += between - current * elapsed / (capacity * OUTER);

        let kelvin = self.temperature_c + 273.15;
        let cold = (ACTIVATION_J / 8.314 * (1.0 / kelvin - 1.0 / 298.15)).exp();
        // 2 R T / F · asinh(I / (2 I0)): at small currents a resistance of R T / (F I0).
        let thermal_v = R_OVER_F * kelvin;
        let exchange_a = thermal_v / (battery.transfer_ohm * cold);
        let settled = 2.0 * thermal_v * (current / (2.0 * exchange_a)).asinh();
        self.transfer_v += (settled - self.transfer_v) * (1.0 - (-elapsed / battery.transfer_s).exp());

        let moved = current.abs() * elapsed / (capacity * HYSTERESIS_SHARE);
        let end = -current.signum() * f64::from(u8::from(current != 0.0));
        self.hysteresis += (end - self.hysteresis) * (1.0 - (-moved).exp());

        let emptying = 1.0 + 0.6 * (-self.outer.max(0.0) / 0.08).exp();
        let ohmic = battery.ohmic_ohm * cold * emptying;
        let losses = current * (ohmic * current + self.transfer_v);
        self.temperature_c +=
            (losses - COOLING_W_K * (self.temperature_c - battery.ambient_c)) * elapsed / HEAT_J_K;
        let open =
            open_circuit_v(self.outer) + battery.curve_offset_v + battery.hysteresis_v * self.hysteresis;
        battery.cells * (open - ohmic * current - self.transfer_v)
    }
}

fn open_circuit_v(charge: f64) -> f64 {
    let after = CURVE.iter().position(|(at, _)| *at >= charge).unwrap_or(CURVE.len() - 1).max(1);
    let ((q0, u0), (q1, u1)) = (CURVE[after - 1], CURVE[after]);
    u0 + (u1 - u0) * (charge - q0) / (q1 - q0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pack() -> Battery {
        Battery {
            capacity_ah: 1.8,
            cells: 3.0,
            ohmic_ohm: 0.04,
            transfer_ohm: 0.02,
            transfer_s: 25.0,
            diffusion_s: 100.0,
            hysteresis_v: 0.008,
            ambient_c: 25.0,
            curve_offset_v: 0.0,
        }
    }

    /// Counted: an hour of 0.9 A is half of 1.8 A·h; at rest the curve is back, less the
    /// hysteresis.
    #[test]
    fn what_is_drawn_is_gone() {
        let mut state = pack().at(0.9523);
        for _ in 0..3600 {
            state.draw(0.9, 1.0);
        }
        assert!((state.charge() - 0.4523).abs() < 1e-9, "{}", state.charge());
        assert!(state.temperature_c() > 25.1 && state.temperature_c() < 27.0, "{}", state.temperature_c());
        let mut voltage = 0.0;
        for _ in 0..3600 {
            voltage = state.draw(0.0, 1.0);
        }
        assert!((voltage - 3.0 * (3.6941 - 0.008)).abs() < 1e-3, "{voltage}");
    }

    /// A step of 1 A at 25 °C: 3 · 40 mΩ at once; the charge transfer's 2 R T / F asinh(I / 2 I0)
    /// comes later, and the cold makes more.
    #[test]
    fn a_load_step_drops_at_once_and_then_creeps() {
        let mut state = pack().at(0.6);
        let rest = state.draw(0.0, 1.0);
        let at_once = rest - state.draw(1.0, 0.001);
        assert!((at_once - 0.12).abs() < 1e-3, "{at_once}");
        for _ in 0..120 {
            state.draw(1.0, 1.0);
        }
        let later = rest - state.draw(1.0, 0.001);
        assert!(later > 0.17 && later < 0.35, "{later}");
        let mut cold = Battery { ambient_c: 5.0, ..pack() }.at(0.6);
        let rest = cold.draw(0.0, 1.0);
        assert!(rest - cold.draw(1.0, 0.001) > 1.7 * 0.12 * 0.9);
    }
}
