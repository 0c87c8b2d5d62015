//! What the node asks for, and for how long it counts.
//!
//! The node shows that it lives by a heartbeat: a register whose value has to *change*. The first
//! value that it writes is the one that stands there from the start, so it counts as living from
//! the second one on. 500 ms after the last change the command is forgotten: it does not come back
//! with the heartbeat, and until then commands are not taken.

use super::{Command, Orders, goals};
use crate::wheels::WHEELS;

/// For how long a change of the heartbeat counts, µs: the stock firmware's.
pub const HEARTBEAT_US: u64 = 500_000;

/// What the host has asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pilot {
    heartbeat: u8,
    /// The last change of the heartbeat, while it counts, µs since start.
    heard_us: Option<u64>,
    command: Command,
    commanded_us: u64,
    command_timeout_ms: u16,
    torque: bool,
    profile: [i32; WHEELS],
    stops: u32,
}

impl Default for Pilot {
    fn default() -> Self {
        Self::new()
    }
}

impl Pilot {
    /// Nobody has asked for anything. Torque is on, as with the stock firmware: the node never
    /// switches it on.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            heartbeat: 0,
            heard_us: None,
            command: [0; 6],
            commanded_us: 0,
            command_timeout_ms: 0,
            torque: true,
            profile: [0; WHEELS],
            stops: 0,
        }
    }

    /// The host writes the heartbeat.
    pub fn beat(&mut self, value: u8, now_us: u64) {
        self.look(now_us);
        if value != self.heartbeat {
            self.heartbeat = value;
            self.heard_us = Some(now_us);
        }
    }

    /// The host commands a motion: those values of it that are given.
    pub fn command(&mut self, values: [Option<i32>; 6], now_us: u64) {
        self.look(now_us);
        if self.heard_us.is_none() || values.iter().all(Option::is_none) {
            return;
        }
        for (place, value) in self.command.iter_mut().zip(values) {
            *place = value.unwrap_or(*place);
        }
        self.commanded_us = now_us;
    }

    /// The host switches the motors' torque.
    pub fn set_torque(&mut self, on: bool) {
        self.torque = on;
    }

    /// The host sets how fast the servos take up a new goal. Negative ones count as 0, as fast as
    /// they can.
    pub fn set_profile(&mut self, values: [Option<i32>; WHEELS]) {
        for (place, value) in self.profile.iter_mut().zip(values) {
            *place = value.map_or(*place, |value| value.clamp(0, 32_767));
        }
    }

    /// For how long a command counts while the node lives, ms; 0: for good, as with the stock
    /// firmware.
    pub fn set_command_timeout(&mut self, timeout_ms: u16) {
        self.command_timeout_ms = timeout_ms;
    }

    /// Forgets what has lasted too long.
    pub fn look(&mut self, now_us: u64) {
        if self.heard_us.is_some_and(|heard| now_us >= heard.saturating_add(HEARTBEAT_US)) {
            self.heard_us = None;
            self.stop();
        }
        if self.stale_us().is_some_and(|stale| now_us >= stale) {
            self.stop();
        }
    }

    fn stop(&mut self) {
        if self.command != [0; 6] {
            self.stops = self.stops.saturating_add(1);
        }
        self.command = [0; 6];
    }

    /// When the command is too old, if it ever is.
    fn stale_us(&self) -> Option<u64> {
        let is_limited = self.command_timeout_ms != 0 && self.command != [0; 6];
        is_limited.then(|| self.commanded_us.saturating_add(1000 * u64::from(self.command_timeout_ms)))
    }

    /// When the wheels have to stop if nothing comes, µs since start; `None` while they stand
    /// anyway.
    #[must_use]
    pub fn stop_us(&self) -> Option<u64> {
        if self.command == [0; 6] {
            return None;
        }
        let silent = self.heard_us.map(|heard| heard.saturating_add(HEARTBEAT_US));
        [silent, self.stale_us()].into_iter().flatten().min()
    }

    /// What the wheels are to do now.
    pub fn orders(&mut self, now_us: u64) -> Orders {
        self.look(now_us);
        Orders { goals: goals(&self.command), torque: self.torque, profile: self.profile }
    }

    /// The heartbeat's last value.
    #[must_use]
    pub const fn heartbeat(&self) -> u8 {
        self.heartbeat
    }

    /// Whether the node lives.
    #[must_use]
    pub const fn is_connected(&self) -> bool {
        self.heard_us.is_some()
    }

    /// The command that counts.
    #[must_use]
    pub const fn commanded(&self) -> Command {
        self.command
    }

    /// Whether torque is wanted.
    #[must_use]
    pub const fn torque(&self) -> bool {
        self.torque
    }

    /// Profile accelerations.
    #[must_use]
    pub const fn profile(&self) -> [i32; WHEELS] {
        self.profile
    }

    /// For how long a command counts, ms; 0: for good.
    #[must_use]
    pub const fn command_timeout_ms(&self) -> u16 {
        self.command_timeout_ms
    }

    /// Times that a motion was ended because heartbeat or command were missing.
    #[must_use]
    pub const fn stops(&self) -> u32 {
        self.stops
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORWARD: [Option<i32>; 6] = [Some(10), Some(0), Some(0), Some(0), Some(0), Some(0)];

    /// Whose heartbeat went from 0 to 1 at 1 s.
    fn living() -> Pilot {
        let mut pilot = Pilot::new();
        pilot.beat(0, 900_000);
        assert!(!pilot.is_connected());
        pilot.beat(1, 1_000_000);
        pilot
    }

    #[test]
    fn a_command_counts_for_half_a_second_after_the_last_change() {
        let mut pilot = living();
        pilot.command(FORWARD, 1_100_000);
        assert_eq!(pilot.orders(1_499_999).goals, [126, 126]);
        assert_eq!(pilot.stop_us(), Some(1_500_000));
        // The same value is no sign of life.
        pilot.beat(1, 1_400_000);
        assert_eq!(pilot.stop_us(), Some(1_500_000));
        pilot.beat(2, 1_450_000);
        assert_eq!(pilot.stop_us(), Some(1_950_000));
        assert_eq!(pilot.orders(1_949_999).goals, [126, 126]);
        assert_eq!(pilot.orders(1_950_000).goals, [0, 0]);
        assert_eq!((pilot.stop_us(), pilot.stops()), (None, 1));
    }

    #[test]
    fn an_old_command_does_not_come_back() {
        let mut pilot = living();
        pilot.command(FORWARD, 1_100_000);
        assert_eq!(pilot.orders(1_600_000).goals, [0, 0]);
        // Nor is one taken before the node lives again.
        pilot.command(FORWARD, 1_700_000);
        pilot.beat(2, 1_800_000);
        assert_eq!(pilot.orders(1_810_000).goals, [0, 0]);
        pilot.command(FORWARD, 1_820_000);
        assert_eq!(pilot.orders(1_830_000).goals, [126, 126]);
    }

    #[test]
    fn without_a_heartbeat_nothing_moves() {
        let mut pilot = Pilot::new();
        pilot.command(FORWARD, 1_000);
        pilot.beat(0, 2_000);
        pilot.command(FORWARD, 3_000);
        assert_eq!(pilot.orders(4_000), Orders { torque: true, ..Orders::NONE });
    }

    /// Off by default; of a node that lives on.
    #[test]
    fn a_stale_command_may_be_ended_too() {
        let mut pilot = living();
        pilot.set_command_timeout(200);
        pilot.command(FORWARD, 1_100_000);
        assert_eq!(pilot.stop_us(), Some(1_300_000));
        assert_eq!(pilot.orders(1_299_999).goals, [126, 126]);
        assert_eq!(pilot.orders(1_300_000).goals, [0, 0]);
        assert!(pilot.is_connected());
    }

    #[test]
    fn parts_of_a_command_leave_the_rest() {
        let mut pilot = living();
        pilot.command([Some(10), None, None, None, None, None], 1_100_000);
        pilot.command([None, None, None, None, None, Some(50)], 1_100_000);
        assert_eq!(pilot.orders(1_200_000).goals, [75, 176]);
        pilot.set_profile([Some(-3), None]);
        pilot.set_profile([None, Some(99_999)]);
        assert_eq!(pilot.profile(), [0, 32_767]);
    }
}
