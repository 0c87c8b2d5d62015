//! What the flash holds, and what follows from it for estimating.

use model_core::coefficients::Coefficients;

use crate::control_table::{Item, Reason};
use crate::items::{
    self, Bytes, CALIBRATION_BYTES, Calibration, ItemBytes, ROBOT_BYTES, RobotIdentity, check_coefficients,
};
use crate::wheels::WHEELS;

/// Coefficients, calibration and robot in use: those stored, as far as they are valid.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    sample_rate_hz: u16,
    coefficients_bytes: ItemBytes,
    previous_bytes: ItemBytes,
    /// Why the previous coefficients would not be taken.
    previous: Reason,
    /// The flash could not be read: it is not known whether there are coefficients.
    unread: Option<Reason>,
    calibration_bytes: Bytes<CALIBRATION_BYTES>,
    robot_bytes: Bytes<ROBOT_BYTES>,
    coefficients: Result<Coefficients<f32, WHEELS>, Reason>,
    calibration: Calibration,
    robot: RobotIdentity,
    changes: u32,
}

impl Settings {
    /// Nothing stored: no coefficients, no calibration, and the robot is a TurtleBot3 Burger.
    #[must_use]
    pub const fn new(sample_rate_hz: u16) -> Self {
        Self {
            sample_rate_hz,
            coefficients_bytes: ItemBytes::EMPTY,
            previous_bytes: ItemBytes::EMPTY,
            previous: Reason::Empty,
            unread: None,
            calibration_bytes: Bytes::EMPTY,
            robot_bytes: Bytes::EMPTY,
            coefficients: Err(Reason::Empty),
            calibration: Calibration::NONE,
            robot: RobotIdentity::BURGER,
            changes: 0,
        }
    }

    /// The coefficients, or why there are none.
    pub const fn coefficients(&self) -> Result<&Coefficients<f32, WHEELS>, Reason> {
        match &self.coefficients {
            Ok(coefficients) => Ok(coefficients),
            Err(reason) => Err(*reason),
        }
    }

    /// The calibration.
    #[must_use]
    pub const fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// The robot that the board is set up for.
    #[must_use]
    pub const fn robot(&self) -> &RobotIdentity {
        &self.robot
    }

    /// Grows with every change: who computes with the settings takes them anew.
    #[must_use]
    pub const fn changes(&self) -> u32 {
        self.changes
    }

    /// Hz
    #[must_use]
    pub const fn sample_rate_hz(&self) -> u16 {
        self.sample_rate_hz
    }

    /// What the flash holds of an item, valid or not; nothing where that is longer than such an
    /// item.
    #[must_use]
    pub fn stored(&self, item: Item) -> &[u8] {
        match item {
            Item::Coefficients => self.coefficients_bytes.as_slice(),
            Item::Calibration => self.calibration_bytes.as_slice(),
            Item::Robot => self.robot_bytes.as_slice(),
        }
    }

    /// The coefficients before those stored; empty when there are none.
    #[must_use]
    pub const fn previous(&self) -> &ItemBytes {
        &self.previous_bytes
    }

    /// Why those would not be taken; [`Reason::None`] where they would.
    #[must_use]
    pub const fn previous_reason(&self) -> Reason {
        self.previous
    }

    /// Takes what the flash holds of coefficients before those stored.
    pub fn load_previous(&mut self, stored: ItemBytes) {
        self.previous_bytes = stored;
        self.judge_previous();
    }

    fn judge_previous(&mut self) {
        let result = self.check(Item::Coefficients, self.previous_bytes.as_slice());
        self.previous = result.err().unwrap_or(Reason::None);
    }

    /// An item has been stored in the place of what was there before.
    pub(super) fn replace(&mut self, item: Item, bytes: ItemBytes) {
        if item == Item::Coefficients {
            self.previous_bytes = self.coefficients_bytes;
        }
        self.load(item, Ok(bytes));
    }

    /// Whether the board would use these bytes.
    ///
    /// # Errors
    /// The first thing that is wrong with them.
    pub fn check(&self, item: Item, bytes: &[u8]) -> Result<(), Reason> {
        items::check(item, bytes, &self.robot, self.sample_rate_hz)
    }

    /// Takes what the flash holds of an item, or why that is not known.
    pub fn load(&mut self, item: Item, stored: Result<ItemBytes, Reason>) {
        let bytes = stored.unwrap_or(ItemBytes::EMPTY);
        match item {
            Item::Coefficients => {
                self.coefficients_bytes = bytes;
                self.unread = stored.err();
            }
            Item::Calibration => {
                self.calibration_bytes = Bytes::new(bytes.as_slice()).unwrap_or(Bytes::EMPTY);
                self.calibration = Calibration::decode(bytes.as_slice()).unwrap_or_default();
            }
            Item::Robot => {
                self.robot_bytes = Bytes::new(bytes.as_slice()).unwrap_or(Bytes::EMPTY);
                self.robot = RobotIdentity::decode(bytes.as_slice()).unwrap_or_default();
            }
        }
        // For another robot the same coefficients are others'.
        let bytes = self.coefficients_bytes.image();
        self.coefficients = match self.unread {
            Some(reason) => Err(reason),
            None => check_coefficients(bytes, &self.robot, self.sample_rate_hz),
        };
        self.judge_previous();
        self.changes = self.changes.wrapping_add(1);
    }
}
