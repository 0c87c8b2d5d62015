//! Makes the servos drive: checks how they are set up, switches their torque, sends goals and reads
//! back what they took.
//!
//! A sync write gets no answer, so goals are verified. All of this is one packet more in a sample
//! at most, beside the goals.

use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use super::{ServoCounters, WHEELS};
use crate::drive::Orders;
use crate::dynamixel::bus::{Bus, BusError};
use crate::dynamixel::xl430::{
    ANSWERS_ALL, GOAL_VELOCITY, MODES, PROFILE_ACCELERATION, TORQUE, TORQUE_TO_ERROR_BYTES, TRIPPED,
    VELOCITY_LIMIT, VELOCITY_MODE, WATCHDOG, WATCHDOG_TO_GOAL_BYTES,
};
use crate::parameters::{
    GOAL_PERIOD_US, SERVO_DRIVE_MODES, SERVO_RETRY_US, SERVO_RETURN_DELAY_US, SERVO_WATCHDOG, SERVOS,
    VERIFY_PERIOD_US,
};

/// Whether the robot can drive. Codes as the control table's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum DriveState {
    /// It follows its goals.
    Ready = 0,
    /// A servo does not answer.
    #[default]
    Lost = 1,
    /// A servo is set up in a way that would drive otherwise than asked: see the register that the
    /// fault names.
    Unfit = 2,
    /// Torque was switched off.
    Off = 3,
    /// A servo has switched its torque off for a hardware error.
    Failed = 4,
    /// Being checked, or torque being switched.
    Preparing = 5,
    /// The motors' supply is cut: the battery is low, or the flash is about to be written on a
    /// board without motors.
    CutOff = 6,
}

/// How far a servo is. In this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
enum Step {
    /// Set up otherwise than needed.
    Unfit,
    /// It shut down.
    Failed,
    Reboot,
    #[default]
    ReadTorque,
    ReadModes,
    ReadLimit,
    /// Set up as needed.
    Checked,
    ClearWatchdog,
    SetProfile,
    SwitchOn,
    SetWatchdog,
    Running,
}

#[derive(Debug, Clone, Copy, Default)]
struct Motor {
    step: Step,
    /// The register that does not fit.
    misfit: u8,
    /// It is known to hold no torque: by its own word, or because it acknowledged that it was
    /// switched off.
    is_off: bool,
    /// It has said that it holds one, and was not told to let it go since.
    says_on: bool,
    /// Register 44: never negative, goals are clamped to it.
    limit: i32,
    /// Written last.
    profile: i32,
    retry_us: u64,
}

/// What is known of a servo when its motor is looked after.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub(super) is_absent: bool,
    pub(super) hardware_error: u8,
}

/// Both motors.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Motors {
    motors: [Motor; WHEELS],
    /// Goals on the bus, and since when.
    sent: Option<([i32; WHEELS], u64)>,
    verify_us: u64,
    is_torque_next: bool,
    had_torque: bool,
    state: DriveState,
}

impl Motors {
    pub(super) const fn state(&self) -> DriveState {
        self.state
    }

    /// The register of each servo that does not fit; 0 where none.
    pub(super) fn misfits(&self) -> [u8; WHEELS] {
        self.motors.map(|motor| motor.misfit)
    }

    /// The goals that the servos were told last, positive forward.
    pub(super) fn goals(&self) -> [i32; WHEELS] {
        self.sent.map_or([0; WHEELS], |(goals, _)| goals)
    }

    /// Whether the servos hold their torque.
    pub(super) fn has_torque(&self) -> bool {
        self.motors.iter().all(|motor| motor.step > Step::SwitchOn)
    }

    /// Of each servo, whether it is known to hold no torque. One of which nothing is known may hold
    /// one from before the board's start.
    pub(super) fn are_off(&self) -> [bool; WHEELS] {
        self.motors.map(|motor| motor.is_off)
    }

    /// The supply was cut: nothing that is known of the servos holds, but that they have no torque.
    pub(super) fn forget(&mut self) {
        let motor = Motor { is_off: true, ..Motor::default() };
        *self = Self { motors: [motor; WHEELS], state: DriveState::CutOff, ..Self::default() };
    }

    /// Sends goals where they have changed or are due, and, if there `is_time`, one packet more.
    pub(super) async fn drive<P: Read + Write, D: DelayNs>(
        &mut self,
        bus: &mut Bus<P, D>,
        seen: [Seen; WHEELS],
        is_time: bool,
        orders: &Orders,
        time_us: u64,
        counters: &mut ServoCounters,
    ) {
        let is_switched_on = orders.torque && !self.had_torque;
        self.had_torque = orders.torque;
        for (motor, seen) in self.motors.iter_mut().zip(seen) {
            if seen.is_absent {
                *motor = Motor::default();
            } else if seen.hardware_error != 0 && motor.step > Step::Reboot {
                motor.step = Step::Failed;
            }
            if is_switched_on && motor.step <= Step::Failed {
                // Whoever switches torque on again has looked.
                motor.step = if motor.step == Step::Failed { Step::Reboot } else { Step::ReadTorque };
                motor.misfit = 0;
            }
        }
        self.state = self.judge(seen, orders);
        self.send(bus, orders, time_us, counters).await;
        if is_time {
            self.care(bus, seen, orders, time_us, counters).await;
        }
    }

    fn judge(&self, seen: [Seen; WHEELS], orders: &Orders) -> DriveState {
        let any = |step| self.motors.iter().any(|motor| motor.step == step);
        if !orders.torque {
            DriveState::Off
        } else if seen.iter().any(|seen| seen.is_absent) {
            DriveState::Lost
        } else if any(Step::Unfit) {
            DriveState::Unfit
        } else if any(Step::Failed) {
            DriveState::Failed
        } else if self.motors.iter().all(|motor| motor.step == Step::Running) {
            DriveState::Ready
        } else {
            DriveState::Preparing
        }
    }

    /// Goals, where a servo may follow them. A robot of which one wheel is gone stands still with
    /// the other.
    pub(super) async fn send<P: Read + Write, D: DelayNs>(
        &mut self,
        bus: &mut Bus<P, D>,
        orders: &Orders,
        time_us: u64,
        counters: &mut ServoCounters,
    ) {
        if self.motors.iter().all(|motor| motor.step <= Step::ReadLimit) && self.sent.is_none() {
            return;
        }
        let is_ready = orders.torque && self.state == DriveState::Ready;
        let mut goals = if is_ready { orders.goals } else { [0; WHEELS] };
        for (goal, motor) in goals.iter_mut().zip(&self.motors) {
            *goal = (*goal).max(-motor.limit).min(motor.limit);
        }
        let is_due = self.sent.is_none_or(|(sent, since)| sent != goals || time_us >= since + GOAL_PERIOD_US);
        if !is_due {
            return;
        }
        let mut data = [(0, [0; 4]); WHEELS];
        for ((place, goal), servo) in data.iter_mut().zip(goals).zip(SERVOS) {
            *place = (servo.id, if servo.reversed { -goal } else { goal }.to_le_bytes());
        }
        match bus.sync_write(GOAL_VELOCITY, data).await {
            Ok(()) => self.sent = Some((goals, time_us)),
            Err(error) => counters.add(error),
        }
    }

    async fn care<P: Read + Write, D: DelayNs>(
        &mut self,
        bus: &mut Bus<P, D>,
        seen: [Seen; WHEELS],
        orders: &Orders,
        time_us: u64,
        counters: &mut ServoCounters,
    ) {
        let are_checked = self.motors.iter().all(|motor| motor.step >= Step::Checked);
        let next = self
            .motors
            .iter_mut()
            .zip(seen)
            .zip(SERVOS.iter().zip(SERVO_DRIVE_MODES))
            .zip(orders.profile)
            .find(|(((motor, seen), _), profile)| {
                !seen.is_absent
                    && motor.has_work(orders.torque, are_checked, *profile)
                    && time_us >= motor.retry_us
            });
        if let Some((((motor, _), (servo, drive_mode)), profile)) = next {
            if let Err(error) = motor.work(bus, servo.id, drive_mode, orders.torque, profile).await {
                counters.add(error);
                motor.retry_us = time_us.saturating_add(SERVO_RETRY_US);
            }
        } else if are_checked && orders.torque && time_us >= self.verify_us {
            self.verify_us = time_us.saturating_add(VERIFY_PERIOD_US);
            self.is_torque_next = !self.is_torque_next;
            if self.is_torque_next {
                self.verify_torque(bus, counters).await;
            } else {
                self.verify_goals(bus, counters).await;
            }
        }
    }

    async fn verify_goals<P: Read + Write, D: DelayNs>(
        &mut self,
        bus: &mut Bus<P, D>,
        counters: &mut ServoCounters,
    ) {
        let ids = SERVOS.map(|servo| Some(servo.id));
        let answers = bus.sync_read::<WHEELS, WATCHDOG_TO_GOAL_BYTES>(WATCHDOG, ids).await;
        let sent = self.goals();
        for (((motor, answer), sent), servo) in self.motors.iter_mut().zip(answers).zip(sent).zip(SERVOS) {
            let Some(Ok(answer)) = answer else {
                answer.and_then(Result::err).into_iter().for_each(|error| counters.add(error));
                continue;
            };
            let [watchdog, .., a, b, c, d] = answer.data;
            let goal = i32::from_le_bytes([a, b, c, d]);
            if motor.step == Step::Running && watchdog == TRIPPED {
                counters.tripped = counters.tripped.saturating_add(1);
                motor.step = Step::ClearWatchdog;
            } else if motor.step == Step::Running && watchdog != SERVO_WATCHDOG {
                motor.restarted(counters);
            } else if goal != (if servo.reversed { -sent } else { sent }) {
                counters.unverified = counters.unverified.saturating_add(1);
                self.sent = None;
            }
        }
    }

    async fn verify_torque<P: Read + Write, D: DelayNs>(
        &mut self,
        bus: &mut Bus<P, D>,
        counters: &mut ServoCounters,
    ) {
        let ids = SERVOS.map(|servo| Some(servo.id));
        let answers = bus.sync_read::<WHEELS, TORQUE_TO_ERROR_BYTES>(TORQUE, ids).await;
        for (motor, answer) in self.motors.iter_mut().zip(answers) {
            let Some(Ok(answer)) = answer else {
                answer.and_then(Result::err).into_iter().for_each(|error| counters.add(error));
                continue;
            };
            let [torque, .., hardware_error] = answer.data;
            if motor.step == Step::Running && torque == 0 {
                if hardware_error == 0 {
                    motor.restarted(counters);
                } else {
                    (motor.step, motor.is_off) = (Step::Failed, true);
                }
            }
        }
    }
}

impl Motor {
    fn restarted(&mut self, counters: &mut ServoCounters) {
        counters.restarts = counters.restarts.saturating_add(1);
        *self = Self::default();
    }

    fn has_work(&self, torque: bool, are_checked: bool, profile: i32) -> bool {
        if !torque && !self.is_off {
            return true;
        }
        match self.step {
            Step::Unfit | Step::Failed => false,
            Step::ReadTorque | Step::Reboot => torque,
            Step::Checked => torque && are_checked,
            Step::Running => !torque || self.profile != profile,
            Step::ReadModes
            | Step::ReadLimit
            | Step::ClearWatchdog
            | Step::SetProfile
            | Step::SwitchOn
            | Step::SetWatchdog => true,
        }
    }

    /// One packet, and its answer.
    async fn work<P: Read + Write, D: DelayNs>(
        &mut self,
        bus: &mut Bus<P, D>,
        id: u8,
        drive_mode: u8,
        torque: bool,
        profile: i32,
    ) -> Result<(), BusError> {
        if !torque && !self.is_off {
            return self.switch_off(bus, id).await;
        }
        self.step = match self.step {
            Step::Reboot => {
                bus.reboot(id).await?;
                Step::ReadTorque
            }
            Step::ReadTorque => {
                let [torque, _, _, _, level] = bus.read(id, TORQUE).await?.data;
                self.is_off = torque == 0;
                if level == ANSWERS_ALL { Step::ReadModes } else { self.unfit(TORQUE + 4) }
            }
            Step::ReadModes => {
                let [delay, drive, mode] = bus.read(id, MODES).await?.data;
                let is_slow = 2 * u32::from(delay) > SERVO_RETURN_DELAY_US;
                match (is_slow, drive == drive_mode, mode == VELOCITY_MODE) {
                    (true, ..) => self.unfit(MODES),
                    (_, false, _) => self.unfit(MODES + 1),
                    (.., false) => self.unfit(MODES + 2),
                    _ => Step::ReadLimit,
                }
            }
            Step::ReadLimit => {
                let limit = i32::from_le_bytes(bus.read(id, VELOCITY_LIMIT).await?.data);
                if limit > 0 {
                    self.limit = limit;
                    Step::Checked
                } else {
                    self.unfit(VELOCITY_LIMIT)
                }
            }
            Step::Checked | Step::ClearWatchdog => {
                bus.write(id, WATCHDOG, &[0]).await?;
                Step::SetProfile
            }
            Step::SetProfile => {
                self.write_profile(bus, id, profile).await?;
                Step::SwitchOn
            }
            Step::SwitchOn => {
                // Also where its acknowledgement gets lost.
                self.is_off = false;
                bus.write(id, TORQUE, &[1]).await?;
                Step::SetWatchdog
            }
            Step::SetWatchdog => {
                bus.write(id, WATCHDOG, &[SERVO_WATCHDOG]).await?;
                Step::Running
            }
            Step::Running => {
                self.write_profile(bus, id, profile).await?;
                Step::Running
            }
            Step::Unfit | Step::Failed => self.step,
        };
        Ok(())
    }

    /// Asks whether it holds a torque, and if so takes that: what a servo that acknowledges nothing
    /// did shows with the next question.
    async fn switch_off<P: Read + Write, D: DelayNs>(
        &mut self,
        bus: &mut Bus<P, D>,
        id: u8,
    ) -> Result<(), BusError> {
        if self.step > Step::SwitchOn || self.says_on {
            self.says_on = false;
            self.step = self.step.min(Step::Checked);
            bus.write(id, TORQUE, &[0]).await?;
            self.is_off = true;
        } else {
            let [torque] = bus.read(id, TORQUE).await?.data;
            self.is_off = torque == 0;
            self.says_on = torque != 0;
        }
        Ok(())
    }

    async fn write_profile<P: Read + Write, D: DelayNs>(
        &mut self,
        bus: &mut Bus<P, D>,
        id: u8,
        profile: i32,
    ) -> Result<(), BusError> {
        bus.write(id, PROFILE_ACCELERATION, &profile.to_le_bytes()).await?;
        self.profile = profile;
        Ok(())
    }

    fn unfit(&mut self, register: u16) -> Step {
        self.misfit = register as u8;
        Step::Unfit
    }
}
