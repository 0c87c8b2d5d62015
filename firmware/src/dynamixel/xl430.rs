//! The registers of an XL430-W250 servo, and what their codes mean. Source: ROBOTIS e-manual,
//! XL430-W250.

use core::f32::consts::TAU;

/// Register 0, two bytes, and the answer to a ping.
pub const MODEL: u16 = 1060;

/// Hardware error status, one byte: bit 0 input voltage, 2 overheating, 3 encoder, 4 electrical
/// shock, 5 overload. While one is set every status carries the alert, and the servo may have
/// switched its torque off.
pub const HARDWARE_ERROR: u16 = 70;

/// Return delay, drive mode and operating mode, a byte each.
pub const MODES: u16 = 9;
/// Greatest goal velocity, four bytes.
pub const VELOCITY_LIMIT: u16 = 44;
/// Torque enable, one byte.
pub const TORQUE: u16 = 64;
/// From torque enable to the hardware error: 64 … 70.
pub const TORQUE_TO_ERROR_BYTES: usize = 7;
/// Bus watchdog, one byte, 20 ms each; 0 off, FFh tripped, which makes goals read-only.
pub const WATCHDOG: u16 = 98;
/// From the watchdog to the goal velocity: 98 … 107.
pub const WATCHDOG_TO_GOAL_BYTES: usize = 10;
/// What [`WATCHDOG`] shows when it has tripped.
pub const TRIPPED: u8 = 0xFF;
/// Goal velocity, four bytes.
pub const GOAL_VELOCITY: u16 = 104;
/// Profile acceleration, four bytes.
pub const PROFILE_ACCELERATION: u16 = 108;
/// Operating mode: velocity.
pub const VELOCITY_MODE: u8 = 1;
/// Status return level: every instruction is answered.
pub const ANSWERS_ALL: u8 = 2;

/// First register of [`Present`].
pub const PRESENT: u16 = 126;
/// Registers 126 … 146: one read gets all that is measured.
pub const PRESENT_BYTES: usize = 21;

/// Code of a load register: 0.1 % of the greatest torque, positive counter-clockwise. The servo has
/// no current sensor; it infers this from the voltage it applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Load(pub i16);

/// Code of a velocity register.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Velocity(pub i32);

impl Velocity {
    /// One count, rad/s: 0.229 rev/min.
    pub const COUNT: f32 = 0.229 * TAU / 60.0;

    /// rad/s
    #[must_use]
    pub fn rad_per_s(self) -> f32 {
        self.0 as f32 * Self::COUNT
    }
}

/// Code of a position register: counts turns as well, and wraps at the ends of its 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Position(pub i32);

impl Position {
    /// One count, rad: 4096 to the turn.
    pub const COUNT: f32 = TAU / 4096.0;

    /// Angle from `earlier` to here, rad.
    #[must_use]
    pub fn radians_since(self, earlier: Self) -> f32 {
        self.0.wrapping_sub(earlier.0) as f32 * Self::COUNT
    }
}

/// Code of the input voltage: 0.1 V.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct InputVoltage(pub u16);

impl InputVoltage {
    /// V
    #[must_use]
    pub fn volts(self) -> f32 {
        f32::from(self.0) * 0.1
    }
}

/// What a servo measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Present {
    /// Register 126.
    pub load: Load,
    /// Register 128.
    pub velocity: Velocity,
    /// Register 132.
    pub position: Position,
    /// Register 144.
    pub input_voltage: InputVoltage,
    /// Register 146, °C.
    pub temperature: u8,
}

impl Present {
    /// From registers 126 … 146. Between position and voltage are the two trajectories, which a
    /// free-running wheel has not.
    #[must_use]
    pub const fn decode(registers: &[u8; PRESENT_BYTES]) -> Self {
        let [
            load0,
            load1,
            velocity0,
            velocity1,
            velocity2,
            velocity3,
            position0,
            position1,
            position2,
            position3,
            _,
            _,
            _,
            _,
            _,
            _,
            _,
            _,
            voltage0,
            voltage1,
            temperature,
        ] = *registers;
        Self {
            load: Load(i16::from_le_bytes([load0, load1])),
            velocity: Velocity(i32::from_le_bytes([velocity0, velocity1, velocity2, velocity3])),
            position: Position(i32::from_le_bytes([position0, position1, position2, position3])),
            input_voltage: InputVoltage(u16::from_le_bytes([voltage0, voltage1])),
            temperature,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each field at its register's address.
    #[test]
    fn registers_stand_where_the_e_manual_says() {
        let mut registers = [0; PRESENT_BYTES];
        let mut set = |address: u16, bytes: &[u8]| {
            let at = usize::from(address - PRESENT);
            registers[at..at + bytes.len()].copy_from_slice(bytes);
        };
        set(126, &(-250_i16).to_le_bytes());
        set(128, &(-265_i32).to_le_bytes());
        set(132, &(-70_000_i32).to_le_bytes());
        set(136, &[0xEE; 8]);
        set(144, &121_u16.to_le_bytes());
        set(146, &[38]);
        let expected = Present {
            load: Load(-250),
            velocity: Velocity(-265),
            position: Position(-70_000),
            input_voltage: InputVoltage(121),
            temperature: 38,
        };
        assert_eq!(Present::decode(&registers), expected);
    }

    /// 0.229 rev/min = 0.023 980 8 rad/s; the default velocity limit, 265, is 60.7 rev/min.
    #[test]
    fn codes_in_si() {
        assert!((Velocity(1).rad_per_s() - 0.023_980_8).abs() < 1e-7);
        assert!((Velocity(-265).rad_per_s() / TAU * 60.0 + 60.685).abs() < 1e-3);
        assert!((Position(4096).radians_since(Position(0)) - TAU).abs() < 1e-6);
        assert!((InputVoltage(121).volts() - 12.1).abs() < 1e-6);
    }

    #[test]
    fn positions_wrap() {
        let (before, behind) = (Position(i32::MAX - 1), Position(i32::MIN + 2));
        assert_eq!(behind.radians_since(before), 4.0 * Position::COUNT);
        assert_eq!(before.radians_since(behind), -4.0 * Position::COUNT);
    }
}
