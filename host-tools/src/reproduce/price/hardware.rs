//! What the board's parts draw, from their data sheets.
//!
//! I²C traffic is left out: a sample reads two registers of a sensor, 90 bits or 0.23 ms at 400 kHz, during half of which a line is
//! low and its pull-up of 4.7 kΩ draws 2.3 mW. At 200 Hz and for two lines that is 0.1 mW, a thirtieth of what
//! the sensor draws, and at 20 Hz a tenth of that.

use crate::plant::experiment;

/// Supply of sensors and core, V.
pub const SUPPLY_V: f64 = 3.3;

/// Supply current of an INA219 that converts continuously, A (TI SBOS448G, Section 7.5: typically 0.7 mA, at most 1 mA).
pub const SENSOR_SUPPLY_A: f64 = 0.7e-3;

/// Rail that the sensor's inputs hang on, V: the motors'.
pub const RAIL_V: f64 = experiment::SUPPLY_V;

/// Current into the inputs of an INA219 that converts, A (SBOS448G, Section 7.5): 20 µA into IN+, and 20 µA beside 320 kΩ into IN−.
pub const SENSOR_INPUT_A: f64 = 20e-6 + 20e-6 + RAIL_V / 320e3;

/// Sensors that estimating the mass needs: one, in the motors' rail. The paper's robot has four (Fig. 8); battery, computer and lidar
/// say nothing about the payload.
pub const SENSORS: f64 = 1.0;

/// Shunt of the usual INA219 module, Ω.
pub const SHUNT_OHM: f64 = 0.1;

/// Supply current of the core, A: STM32F746 (ST DS10916), run mode from ITCM RAM, regulator on, 216 MHz, peripherals off, typical at
/// 25 °C.
pub const CORE_A: f64 = 0.102;

/// The core's clock, Hz.
pub const CORE_HZ: f64 = 216e6;

/// Instructions a cycle: an assumption. The Cortex-M7 issues up to two; waiting for memory and for the divider takes some of that back.
pub const INSTRUCTIONS_PER_CYCLE: f64 = 1.0;

/// Energy of an instruction, J: its share of all that the running core draws.
pub const INSTRUCTION_J: f64 = SUPPLY_V * CORE_A / CORE_HZ / INSTRUCTIONS_PER_CYCLE;

/// What the sensors draw while they run, W.
pub fn sensors_w() -> f64 {
    SENSORS * (SUPPLY_V * SENSOR_SUPPLY_A + RAIL_V * SENSOR_INPUT_A)
}
