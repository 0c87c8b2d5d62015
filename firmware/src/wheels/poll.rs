//! Reads both servos once a sample, and looks after those that are gone or have an error.

use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use super::health::Presence;
use super::motors::{Motors, Seen};
use super::{DriveState, Odometer, Servo, ServoCounters, Speedometer, SwitchedPort, WHEELS, WheelHealth};
use crate::drive::Orders;
use crate::dynamixel::bus::{Answer, Bus, BusError, Timing};
use crate::dynamixel::xl430::{HARDWARE_ERROR, MODEL, PRESENT, PRESENT_BYTES, Present};
use crate::parameters::{SERVO_BAUD, SERVO_MARGIN_US, SERVO_PROBE_US, SERVO_RETURN_DELAY_US, SERVOS};

const TIMING: Timing =
    Timing { baud: SERVO_BAUD, return_delay_us: SERVO_RETURN_DELAY_US, margin_us: SERVO_MARGIN_US };

/// What a wheel's servo said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelReading {
    /// rad/s, positive forward.
    pub speed: f32,
    /// The registers, in the servo's own direction.
    pub present: Present,
}

/// What is known of a wheel's servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WheelStatus {
    /// Whether it can be believed.
    pub health: WheelHealth,
    /// Its register 70, while it has an alert; read some time after the alert came.
    pub hardware_error: u8,
    /// What it measured last; `None` while it is absent.
    pub present: Option<Present>,
    /// Position that goes on over the servo's restarts, 1/4096 turn, positive forward; `None`
    /// before it was ever seen.
    pub odometer: Option<i32>,
    /// The register that does not fit, of a servo that is set up otherwise than needed; else 0.
    pub misfit: u8,
}

/// The wheels' servos on their bus.
///
/// [`Self::poll`] only reads; [`Self::drive`] does what is ordered.
pub struct Wheels<P, D> {
    bus: Bus<P, D>,
    wheels: [Wheel; WHEELS],
    motors: Motors,
    counters: ServoCounters,
    /// There is time for another packet in this sample.
    has_time: bool,
    is_cut_off: bool,
}

#[derive(Debug, Clone, Copy)]
struct Wheel {
    servo: Servo,
    presence: Presence,
    speedometer: Speedometer,
    odometer: Odometer,
    present: Option<Present>,
    hardware_error: u8,
    /// When to look after it again, µs since start.
    care_us: u64,
}

impl Wheel {
    fn new(servo: Servo) -> Self {
        Self {
            servo,
            presence: Presence::default(),
            speedometer: Speedometer::default(),
            odometer: Odometer::default(),
            present: None,
            hardware_error: 0,
            care_us: 0,
        }
    }

    fn answered(&mut self, answer: &Answer<PRESENT_BYTES>, time_us: u64) -> WheelReading {
        self.presence.answered(answer.alert);
        if !answer.alert {
            self.hardware_error = 0;
        }
        let present = Present::decode(&answer.data);
        self.present = Some(present);
        self.odometer.update(&present, time_us);
        let speed = self.speedometer.update(&present, time_us);
        WheelReading { speed: if self.servo.reversed { -speed } else { speed }, present }
    }

    /// Of the servo's own direction the robot's.
    fn forward(&self, value: i32) -> i32 {
        if self.servo.reversed { value.wrapping_neg() } else { value }
    }

    fn missed(&mut self) {
        self.presence.missed();
        if self.presence.is_absent() {
            self.present = None;
            self.hardware_error = 0;
        }
    }

    fn needs_care(&self, time_us: u64) -> bool {
        self.presence.health() != WheelHealth::Ok && time_us >= self.care_us
    }
}

impl<P: Read + Write, D: DelayNs> Wheels<P, D> {
    /// The robot's servos ([`SERVOS`]) behind this port. Nothing is sent yet; each is absent until
    /// it answered a ping.
    pub fn new(port: P, delay: D) -> Self {
        Self {
            bus: Bus::new(port, delay, TIMING),
            wheels: SERVOS.map(Wheel::new),
            motors: Motors::default(),
            counters: ServoCounters::default(),
            has_time: false,
            is_cut_off: false,
        }
    }

    /// Reads what the servos measure, `time_us` since start. One that gives no answer, or no valid
    /// one, costs its own place.
    ///
    /// A servo that is absent is not waited for; it is sought with a ping ten times a second, and
    /// belongs to the robot if it is of the right model. That, and asking for the cause of an
    /// alert, are the one packet more that a poll may send; where an answer was missing there is
    /// none.
    pub async fn poll(&mut self, time_us: u64) -> [Option<WheelReading>; WHEELS] {
        let ids = self.wheels.each_ref().map(|wheel| (!wheel.presence.is_absent()).then_some(wheel.servo.id));
        let answers = self.bus.sync_read(PRESENT, ids).await;
        self.counters.broken = self.counters.broken.saturating_add(self.bus.take_port_errors());
        let mut readings = [None; WHEELS];
        let mut is_late = false;
        for ((wheel, answer), reading) in self.wheels.iter_mut().zip(answers).zip(&mut readings) {
            match answer {
                Some(Ok(answer)) => *reading = Some(wheel.answered(&answer, time_us)),
                Some(Err(error)) => {
                    self.counters.add(error);
                    is_late |= error == BusError::Timeout;
                    wheel.missed();
                }
                None => {}
            }
        }
        self.has_time = !is_late && !self.care(time_us).await;
        readings
    }

    /// Does what is ordered, after a [`Self::poll`] of the same time: goals, and of all that has to
    /// be checked, switched or verified one packet, if the poll has left time for it.
    pub async fn drive(&mut self, time_us: u64, orders: &Orders) {
        if self.is_cut_off {
            return;
        }
        let seen = self.wheels.each_ref().map(|wheel| Seen {
            is_absent: wheel.presence.is_absent(),
            hardware_error: wheel.hardware_error,
        });
        let Self { bus, motors, counters, has_time, .. } = self;
        motors.drive(bus, seen, *has_time, orders, time_us, counters).await;
        // Asked once a poll.
        *has_time = false;
    }

    /// Only the goals, between two samples: for a stop that cannot wait.
    pub async fn hurry(&mut self, time_us: u64, orders: &Orders) {
        if !self.is_cut_off {
            self.motors.send(&mut self.bus, orders, time_us, &mut self.counters).await;
        }
    }

    /// Whether the robot can drive.
    #[must_use]
    pub fn drive_state(&self) -> DriveState {
        self.motors.state()
    }

    /// The goals that the servos were told last, positive forward, in their unit.
    #[must_use]
    pub fn goals(&self) -> [i32; WHEELS] {
        self.motors.goals()
    }

    /// Whether both servos hold their torque.
    #[must_use]
    pub fn has_torque(&self) -> bool {
        self.motors.has_torque()
    }

    /// Of each servo, whether it is known to hold no torque, or does not answer, so that nothing
    /// that the board does reaches it.
    #[must_use]
    pub fn are_off(&self) -> [bool; WHEELS] {
        let mut are_off = self.motors.are_off();
        for (is_off, wheel) in are_off.iter_mut().zip(&self.wheels) {
            *is_off |= wheel.presence.is_absent();
        }
        are_off
    }

    /// Whether the wheels cannot turn by themselves: no servo answers, and their supply is off.
    #[must_use]
    pub fn is_dead(&self) -> bool {
        self.is_cut_off && self.are_absent()
    }

    /// Whether no servo answers.
    #[must_use]
    pub fn are_absent(&self) -> bool {
        self.wheels.iter().all(|wheel| wheel.presence.is_absent())
    }

    /// Seeks a servo that is gone, or asks one why it has an alert. Whether anything was asked.
    async fn care(&mut self, time_us: u64) -> bool {
        let Some(wheel) = self.wheels.iter_mut().find(|wheel| wheel.needs_care(time_us)) else {
            return false;
        };
        wheel.care_us = time_us.saturating_add(SERVO_PROBE_US);
        let id = wheel.servo.id;
        if !wheel.presence.is_absent() {
            if let Ok(Answer { data: [error], .. }) = self.bus.read(id, HARDWARE_ERROR).await {
                wheel.hardware_error = error;
            }
        } else {
            match self.bus.ping(id).await {
                Ok((MODEL, _)) => wheel.presence.answered(false),
                Ok(_) => {}
                Err(_) => self.counters.unanswered_pings = self.counters.unanswered_pings.saturating_add(1),
            }
        }
        true
    }

    /// What is known of each servo.
    #[must_use]
    pub fn statuses(&self) -> [WheelStatus; WHEELS] {
        let mut misfits = self.motors.misfits().into_iter();
        self.wheels.each_ref().map(|wheel| WheelStatus {
            health: wheel.presence.health(),
            hardware_error: wheel.hardware_error,
            present: wheel.present,
            odometer: wheel.odometer.position().map(|position| wheel.forward(position)),
            misfit: misfits.next().unwrap_or(0),
        })
    }

    /// What went wrong on the bus so far.
    #[must_use]
    pub fn counters(&self) -> ServoCounters {
        self.counters
    }
}

impl<P: SwitchedPort, D: DelayNs> Wheels<P, D> {
    /// Switches the servos' supply, where it is not so already.
    pub fn set_supply(&mut self, on: bool) {
        if self.is_cut_off == on {
            self.bus.port().set_supply(on);
            self.is_cut_off = !on;
            self.motors.forget();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamixel::packet::Instruction;
    use crate::dynamixel::testing::{Patience, Servos};
    use crate::testing::now;

    const STEP_US: u64 = 5_000;

    fn wheels(servos: &Servos) -> Wheels<&Servos, &Patience> {
        Wheels::new(servos, &servos.patience)
    }

    /// Ten samples.
    fn start(wheels: &mut Wheels<&Servos, &Patience>) {
        (0..10).for_each(|i| _ = now(wheels.poll(STEP_US * i)));
    }

    fn known(readings: [Option<WheelReading>; WHEELS]) -> [bool; WHEELS] {
        readings.map(|reading| reading.is_some())
    }

    fn health(wheels: &Wheels<&Servos, &Patience>) -> [WheelHealth; WHEELS] {
        wheels.statuses().map(|status| status.health)
    }

    /// One ping a poll, then both in one sync read.
    #[test]
    fn finds_the_servos_one_after_the_other() {
        let servos = Servos::new();
        let mut wheels = wheels(&servos);
        let answering: Vec<_> = (0..4).map(|i| known(now(wheels.poll(STEP_US * i)))).collect();
        assert_eq!(answering, [[false, false], [true, false], [true, true], [true, true]]);
        use Instruction::{Ping, SyncRead};
        let sent = [Ping, SyncRead, Ping, SyncRead, SyncRead].map(|instruction| instruction as u8);
        assert_eq!(*servos.instructions.borrow(), sent);
        assert_eq!(wheels.counters(), ServoCounters::default());
    }

    /// 8 counts of position in 5 ms are 2.454 rad/s; 100 of velocity, near enough, 2.398.
    #[test]
    fn speeds_are_positive_forward() {
        let servos = Servos::new();
        let mut wheels = wheels(&servos);
        let mut last = [None; WHEELS];
        for i in 0..100 {
            servos.advance([100, -100], [8, -8]);
            last = now(wheels.poll(STEP_US * i));
        }
        let speeds = last.map(|reading| reading.map(|reading| (reading.speed * 1000.0).round()));
        assert_eq!(speeds, [Some(2454.0), Some(-2454.0)]);
        assert_eq!(wheels.statuses().map(|s| s.present.map(|p| p.position.0)), [Some(800), Some(-800)]);
        wheels.wheels[1].servo.reversed = true;
        servos.advance([100, -100], [8, -8]);
        assert!(now(wheels.poll(STEP_US * 100))[1].unwrap().speed > 2.4);
    }

    /// The left servo, which the right one waits for, is unplugged: it costs itself, three time
    /// limits, and a ping in 100 ms.
    #[test]
    fn an_unplugged_servo_costs_its_own_wheel() {
        let servos = Servos::new();
        let mut wheels = wheels(&servos);
        start(&mut wheels);
        servos.servos.borrow_mut()[0].is_present = false;
        for i in 10..210 {
            let before = servos.patience.0.get();
            assert_eq!(known(now(wheels.poll(STEP_US * i))), [false, true], "sample {i}");
            assert!(servos.patience.0.get() - before <= 1_400, "sample {i}");
        }
        assert_eq!(health(&wheels), [WheelHealth::Absent, WheelHealth::Ok]);
        assert_eq!(wheels.statuses()[0].present, None);
        let expected = ServoCounters { timeouts: 3, unanswered_pings: 10, ..ServoCounters::default() };
        assert_eq!(wheels.counters(), expected);
        let pings =
            servos.instructions.borrow().iter().filter(|code| **code == Instruction::Ping as u8).count();
        assert_eq!(pings, 2 + 10);
        // Back at another position: found within 100 ms, and its first speed is no jump.
        servos.servos.borrow_mut()[0].is_present = true;
        servos.advance([10, 0], [123_456, 0]);
        let back: Vec<f32> = (210..240)
            .filter_map(|i| now(wheels.poll(STEP_US * i))[0].map(|reading| reading.speed))
            .collect();
        assert!(back.len() >= 9, "{}", back.len());
        assert!((back[0] - 0.239_808).abs() < 1e-5, "{}", back[0]);
        assert_eq!(back[1], 0.0);
    }

    #[test]
    fn a_dead_bus_leaves_time_for_the_rest() {
        let servos = Servos::new();
        let mut wheels = wheels(&servos);
        start(&mut wheels);
        servos.servos.borrow_mut().iter_mut().for_each(|servo| servo.is_present = false);
        for i in 10..100 {
            let before = servos.patience.0.get();
            assert_eq!(known(now(wheels.poll(STEP_US * i))), [false, false]);
            assert!(servos.patience.0.get() - before <= 2_800, "sample {i}");
        }
        assert_eq!(health(&wheels), [WheelHealth::Absent; 2]);
        assert_eq!(wheels.counters().timeouts, 6);
    }

    #[test]
    fn a_broken_answer_costs_one_sample_of_one_wheel() {
        let servos = Servos::new();
        let mut wheels = wheels(&servos);
        start(&mut wheels);
        servos.servos.borrow_mut()[0].broken = 1;
        assert_eq!(known(now(wheels.poll(STEP_US * 10))), [false, true]);
        assert_eq!(known(now(wheels.poll(STEP_US * 11))), [true, true]);
        assert_eq!(wheels.counters(), ServoCounters { broken: 1, ..ServoCounters::default() });
        assert_eq!(health(&wheels), [WheelHealth::Ok; 2]);
    }

    /// Overload (bit 5): the data go on, the cause is read, and both end with the alert.
    #[test]
    fn an_alert_is_explained() {
        let servos = Servos::new();
        let mut wheels = wheels(&servos);
        start(&mut wheels);
        servos.servos.borrow_mut()[1].hardware_error = 0x20;
        for i in 60..100 {
            assert_eq!(known(now(wheels.poll(STEP_US * i))), [true, true]);
        }
        assert_eq!(health(&wheels), [WheelHealth::Ok, WheelHealth::Alert]);
        assert_eq!(wheels.statuses().map(|status| status.hardware_error), [0, 0x20]);
        let reads =
            servos.instructions.borrow().iter().filter(|code| **code == Instruction::Read as u8).count();
        assert_eq!(reads, 2);
        servos.servos.borrow_mut()[1].hardware_error = 0;
        now(wheels.poll(STEP_US * 100));
        assert_eq!(health(&wheels), [WheelHealth::Ok; 2]);
        assert_eq!(wheels.statuses()[1].hardware_error, 0);
    }

    /// The sync read and asking the other alone have taken the time.
    #[test]
    fn where_an_answer_is_missing_nothing_more_is_asked() {
        let servos = Servos::new();
        let mut wheels = wheels(&servos);
        start(&mut wheels);
        servos.servos.borrow_mut()[0].is_present = false;
        servos.servos.borrow_mut()[1].hardware_error = 0x20;
        servos.instructions.borrow_mut().clear();
        assert_eq!(known(now(wheels.poll(STEP_US * 60))), [false, true]);
        let sent = [Instruction::SyncRead, Instruction::Read].map(|instruction| instruction as u8);
        assert_eq!(*servos.instructions.borrow(), sent);
        assert_eq!(wheels.statuses()[1].hardware_error, 0);
    }

    /// Another servo with the same ID has other registers.
    #[test]
    fn another_model_is_no_wheel() {
        let servos = Servos::new();
        servos.servos.borrow_mut()[0].model = 1020;
        let mut wheels = wheels(&servos);
        let last = (0..50).map(|i| known(now(wheels.poll(STEP_US * i)))).last();
        assert_eq!(last, Some([false, true]));
        assert_eq!(health(&wheels), [WheelHealth::Absent, WheelHealth::Ok]);
    }
}
