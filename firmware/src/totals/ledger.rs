//! When the totals are written to the flash.

use super::{Totals, Trip};
use crate::control_table::Reason;
use crate::power_sensors::RAIL_COUNT;

/// They are written after this time, µs: as much is lost at most when the power goes. By this and
/// the size of a record the flash lasts 13 years of days and nights (docs/board.md).
const PERIOD_US: u64 = 60_000_000;
/// When the robot comes to stand after a drive, they are written after this time already, µs: who
/// switches it off then loses nothing.
const STANDING_PERIOD_US: u64 = 30_000_000;

/// How it is with the totals in flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Keeping {
    /// They are written when they are due.
    Ok = 0,
    /// They were not read: what is shown is since start, and nothing is written.
    Unread = 1,
    /// Both sectors are full: one is erased as soon as torque is off, or at the next start. Until
    /// then what is shown is right, and lost at a reset.
    Waiting = 2,
    /// The flash did not take them.
    Failed = 3,
}

/// The totals: those of before, and what has been added since.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ledger {
    before: Totals,
    trip: Trip,
    keeping: Keeping,
    /// When they were written last, or tried to be, µs since start.
    tried_us: u64,
    /// Time in motion that is in flash, s.
    written_driving_s: u32,
    writes: u32,
}

impl Default for Ledger {
    fn default() -> Self {
        Self::new()
    }
}

impl Ledger {
    /// Nothing read yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            before: Totals::NONE,
            trip: Trip::START,
            keeping: Keeping::Unread,
            tried_us: 0,
            written_driving_s: 0,
            writes: 0,
        }
    }

    /// What the flash held at start, `None` where it held nothing, or why that is not known.
    pub fn load(&mut self, before: Result<Option<Totals>, Reason>) {
        if let Ok(before) = before {
            self.before = before.unwrap_or_default();
            self.keeping = Keeping::Ok;
        }
    }

    /// What was driven.
    pub fn trip(&mut self) -> &mut Trip {
        &mut self.trip
    }

    /// All, with the energy that each rail has delivered since start, J: negative where it took
    /// back more.
    #[must_use]
    pub fn totals(&self, energies: [f32; RAIL_COUNT], time_us: u64) -> Totals {
        let mut totals = self.before.plus(&Totals {
            energy_mj: [0; RAIL_COUNT],
            distance_cm: self.trip.distance_cm(),
            driving_s: self.trip.driving_s(),
            on_s: u32::try_from(time_us / 1_000_000).unwrap_or(u32::MAX),
        });
        for (total, joules) in totals.energy_mj.iter_mut().zip(energies) {
            *total = total.saturating_add_signed((1000.0 * joules) as i64);
        }
        totals
    }

    /// Whether they are to be written now.
    #[must_use]
    pub fn is_due(&self, is_standing: bool, time_us: u64) -> bool {
        let has_driven = self.trip.driving_s() != self.written_driving_s;
        let period = if is_standing && has_driven { STANDING_PERIOD_US } else { PERIOD_US };
        self.keeping != Keeping::Unread && time_us.saturating_sub(self.tried_us) >= period
    }

    /// How writing them went.
    pub fn written(&mut self, result: Result<(), Reason>, time_us: u64) {
        self.tried_us = time_us;
        self.keeping = match result {
            Ok(()) => Keeping::Ok,
            Err(Reason::Erase) => Keeping::Waiting,
            Err(_) => Keeping::Failed,
        };
        if result.is_ok() {
            self.written_driving_s = self.trip.driving_s();
            self.writes = self.writes.saturating_add(1);
        }
    }

    /// How it is with them.
    #[must_use]
    pub const fn keeping(&self) -> Keeping {
        self.keeping
    }

    /// Times that they were written since start.
    #[must_use]
    pub const fn writes(&self) -> u32 {
        self.writes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000;
    const BEFORE: Totals = Totals { energy_mj: [5_000, 0, 0, 1], distance_cm: 10, driving_s: 3, on_s: 100 };

    #[test]
    fn go_on_from_what_the_flash_held() {
        let mut ledger = Ledger::new();
        assert!(!ledger.is_due(true, 1000 * S), "nothing is written over what was not read");
        ledger.load(Err(Reason::Flash));
        assert_eq!((ledger.keeping(), ledger.is_due(true, 1000 * S)), (Keeping::Unread, false));
        ledger.load(Ok(Some(BEFORE)));
        let totals = ledger.totals([1.5, 0.0, f32::NAN, 0.0625], 7 * S + 999_999);
        assert_eq!(totals.energy_mj, [6_500, 0, 0, 63]);
        // Downhill on drives that return what they brake: less than before, but never below 0.
        assert_eq!(ledger.totals([-1.5, -1.0, 0.0, 0.0], 0).energy_mj, [3_500, 0, 0, 1]);
        assert_eq!((totals.distance_cm, totals.driving_s, totals.on_s), (10, 3, 107));
    }

    /// Once a minute; after a drive at the first standstill that is half a minute from the last
    /// time.
    #[test]
    fn are_written_once_a_minute_and_after_a_drive() {
        let mut ledger = Ledger::new();
        ledger.load(Ok(None));
        assert!(!ledger.is_due(true, 59 * S) && ledger.is_due(false, 60 * S));
        ledger.written(Ok(()), 60 * S);
        assert!(!ledger.is_due(true, 100 * S));
        (0..400).for_each(|i| ledger.trip().update(None, true, 70 * S + 5_000 * i));
        assert!(
            !ledger.is_due(true, 89 * S) && ledger.is_due(true, 90 * S) && !ledger.is_due(false, 119 * S)
        );
        ledger.written(Ok(()), 90 * S);
        assert!(!ledger.is_due(true, 149 * S) && ledger.is_due(true, 150 * S));
        ledger.written(Err(Reason::Erase), 150 * S);
        assert_eq!((ledger.keeping(), ledger.writes()), (Keeping::Waiting, 2));
        ledger.written(Err(Reason::ReadBack), 210 * S);
        assert_eq!((ledger.keeping(), ledger.writes()), (Keeping::Failed, 2));
    }
}
