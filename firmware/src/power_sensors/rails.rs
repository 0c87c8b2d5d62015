//! The parameters file of the power measurement: which rail has which sensor.

use ina219::address::{Address, Pin};

use super::Shunt;

/// The rails of the robot's power tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RailName {
    /// Everything the battery delivers.
    Battery,
    /// The wheel servos.
    Motors,
    /// The single-board computer.
    Computer,
    /// The laser scanner.
    Lidar,
}

/// A rail and the sensor in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rail {
    /// Which one.
    pub name: RailName,
    /// Of its INA219, as soldered on the module's pads A0 and A1.
    pub address: Address,
    /// Its resistor, before any calibration from the store.
    pub shunt: Shunt,
}

/// As fitted to common INA219 modules: 0.1 Ω, so the sensor saturates at 3.2 A. Two stalled wheel servos draw 2.6 A.
const MODULE_SHUNT: Shunt = Shunt { ohm: 0.1, power_factor: 1.0 };

/// How many rails there are.
pub const RAIL_COUNT: usize = 4;

/// The four sensors of the robot, in the order of the control table. All differ in the module's two solder pads.
pub const RAILS: [Rail; RAIL_COUNT] = [
    Rail { name: RailName::Battery, address: Address::from_pins(Pin::Gnd, Pin::Gnd), shunt: MODULE_SHUNT },
    Rail { name: RailName::Motors, address: Address::from_pins(Pin::Vcc, Pin::Gnd), shunt: MODULE_SHUNT },
    Rail { name: RailName::Computer, address: Address::from_pins(Pin::Gnd, Pin::Vcc), shunt: MODULE_SHUNT },
    Rail { name: RailName::Lidar, address: Address::from_pins(Pin::Vcc, Pin::Vcc), shunt: MODULE_SHUNT },
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Section 8.5.5.1, and two sensors at one address would answer both.
    #[test]
    fn addresses_are_the_four_pad_combinations() {
        assert_eq!(RAILS.map(|rail| rail.address.as_byte()), [0x40, 0x41, 0x44, 0x45]);
    }
}
