//! Whether a servo can be believed.

use crate::dynamixel::bus::BusError;

/// Answers missing in a row after which a servo counts as [`WheelHealth::Absent`]: a single one may
/// be a disturbed bus.
const ABSENT_AFTER: u8 = 3;

/// The verdict on a wheel's servo. Codes as the power sensors' where they mean the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum WheelHealth {
    /// Its readings count.
    Ok = 0,
    /// They count, but the servo has a hardware error, and may have switched its torque off.
    Alert = 1,
    /// It does not answer.
    #[default]
    Absent = 3,
}

impl WheelHealth {
    /// As the control table shows it.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// `None` for a code that this version does not know.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::Ok,
            1 => Self::Alert,
            3 => Self::Absent,
            _ => return None,
        })
    }
}

/// What went wrong on the servo bus since start, over both wheels. Stops at its maximum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ServoCounters {
    /// Sync reads that a servo did not answer in time.
    pub timeouts: u32,
    /// Answers with a wrong checksum or length, or from nobody who was asked; errors of the port.
    pub broken: u32,
    /// Answers that refuse.
    pub refused: u32,
    /// Pings of a servo that is sought which it did not answer.
    pub unanswered_pings: u32,
    /// Goals that a servo had not taken, found when they were read back.
    pub unverified: u32,
    /// Times that a servo's own watchdog had stopped it.
    pub tripped: u32,
    /// Times that a servo had started anew.
    pub restarts: u32,
}

impl ServoCounters {
    /// Before the first poll.
    pub const NONE: Self = Self {
        timeouts: 0,
        broken: 0,
        refused: 0,
        unanswered_pings: 0,
        unverified: 0,
        tripped: 0,
        restarts: 0,
    };

    /// Counts an error.
    pub fn add(&mut self, error: BusError) {
        let counter = match error {
            BusError::Timeout => &mut self.timeouts,
            BusError::Refused(_) => &mut self.refused,
            BusError::Broken | BusError::Unexpected | BusError::Port | BusError::TooLong => &mut self.broken,
        };
        *counter = counter.saturating_add(1);
    }
}

/// The state machine: a verdict and what led to it. A servo never heard of is absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Presence {
    health: WheelHealth,
    /// Answers missing in a row.
    missing: u8,
}

impl Presence {
    pub(super) const fn health(&self) -> WheelHealth {
        self.health
    }

    pub(super) const fn is_absent(&self) -> bool {
        matches!(self.health, WheelHealth::Absent)
    }

    /// It answered, with or without the alert.
    pub(super) fn answered(&mut self, alert: bool) {
        self.missing = 0;
        self.health = if alert { WheelHealth::Alert } else { WheelHealth::Ok };
    }

    /// It gave no answer that counts.
    pub(super) fn missed(&mut self) {
        self.missing = self.missing.saturating_add(1);
        if self.missing >= ABSENT_AFTER {
            self.health = WheelHealth::Absent;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_missing_answers_in_a_row_and_it_is_absent() {
        let mut presence = Presence::default();
        assert_eq!(presence.health(), WheelHealth::Absent);
        presence.answered(false);
        presence.missed();
        presence.missed();
        assert_eq!(presence.health(), WheelHealth::Ok);
        presence.answered(true);
        presence.missed();
        presence.missed();
        assert_eq!(presence.health(), WheelHealth::Alert);
        presence.missed();
        assert!(presence.is_absent());
        presence.answered(false);
        assert_eq!(presence.health(), WheelHealth::Ok);
    }
}
