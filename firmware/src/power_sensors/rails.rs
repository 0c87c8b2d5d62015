//! The rails of the robot's power tree, and the sensor in each.

use ina219::address::Address;
use ina219::configuration::Configuration;

use super::Shunt;

/// How many rails there are.
pub const RAIL_COUNT: usize = 4;

/// The rails, numbered as in the control table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RailName {
    /// Everything the battery delivers.
    Battery = 0,
    /// The wheel servos.
    Motors = 1,
    /// The single-board computer.
    Computer = 2,
    /// The laser scanner.
    Lidar = 3,
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
    /// Ranges and rates of its INA219.
    pub set_up: Configuration,
}

#[cfg(test)]
mod tests {
    use crate::parameters::RAILS;

    #[test]
    fn each_rail_stands_at_its_number() {
        for (index, rail) in RAILS.iter().enumerate() {
            assert_eq!(rail.name as usize, index);
        }
    }
}
