//! Columns of a log that effects ask for beside speeds and power.

/// Column with the pitch, nose up, rad.
pub const PITCH: &str = logs::PITCH;
/// Column with the processor's load, percent.
pub const PROCESSOR: &str = "cpu_percent";
/// What the columns of motor temperatures are called, for people.
pub const TEMPERATURES: &str = "motor1_temp_c, …";

/// Column with the temperature of the motor of a wheel, counted from 1, °C.
pub fn temperature(wheel: usize) -> String {
    format!("motor{wheel}_temp_c")
}
