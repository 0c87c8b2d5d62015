//! When the motors may have their supply.

use crate::drive::BatteryGuard;
use crate::link::State;
use crate::wheels::WheelHealth;

/// Servos that have not answered for so long are not there, µs.
const ABSENT_US: u64 = 1_000_000;

/// Decides over the motors' supply.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Supply {
    battery: BatteryGuard,
    /// Since when no servo answers, µs since start.
    absent_us: Option<u64>,
    is_resting: bool,
}

impl Supply {
    /// Whether the supply is to be on.
    ///
    /// Off with a low battery, and while something waits to be written to the flash on a board
    /// whose servos do not answer: without a supply they stand, which nobody could know otherwise.
    /// A board on USB alone takes its coefficients that way.
    pub(super) fn is_wanted(&mut self, state: &State<'_>, now_us: u64) -> bool {
        let is_low = self.battery.look(state.battery_voltage(), now_us);
        let are_absent = state.snapshot.wheels.iter().all(|wheel| wheel.health == WheelHealth::Absent);
        if are_absent {
            let since = *self.absent_us.get_or_insert(now_us);
            self.is_resting =
                state.upload().is_open() && (self.is_resting || now_us.saturating_sub(since) >= ABSENT_US);
        } else {
            (self.absent_us, self.is_resting) = (None, false);
        }
        !is_low && !self.is_resting
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control_table::{UPLOAD_COMMAND, UPLOAD_ITEM, UPLOAD_LENGTH, UPLOAD_WINDOW};
    use crate::items::Calibration;
    use crate::link::write;

    fn waiting() -> State<'static> {
        let mut state = State::new(200, 25, &mut []);
        let image = Calibration { power_factors: [1.0, 1.1, 1.0, 1.0] }.encode();
        write(&mut state, UPLOAD_WINDOW.address, &image).unwrap();
        write(&mut state, UPLOAD_LENGTH.address, &(image.len() as u16).to_le_bytes()).unwrap();
        write(&mut state, UPLOAD_ITEM.address, &[2]).unwrap();
        write(&mut state, UPLOAD_COMMAND.address, &[1]).unwrap();
        state
    }

    #[test]
    fn a_board_without_servos_rests_while_an_upload_waits() {
        let (idle, waiting) = (State::new(200, 25, &mut []), waiting());
        let mut supply = Supply::default();
        assert!(supply.is_wanted(&idle, 0) && supply.is_wanted(&waiting, 999_999));
        assert!(!supply.is_wanted(&waiting, 1_000_000));
        assert!(supply.is_wanted(&idle, 1_005_000));
        // With servos that answer it waits for them to stand.
        let mut driving = waiting.without_samples();
        driving.snapshot.wheels[0].health = WheelHealth::Ok;
        assert!(!supply.is_wanted(&waiting, 3_000_000));
        assert!(supply.is_wanted(&driving, 3_005_000) && supply.is_wanted(&driving, 9_000_000));
    }
}
