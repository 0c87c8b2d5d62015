//! A servo XL430-W250 as its bus sees it: the control table, and what writing to it does.
//!
//! Source of every address, default and range: ROBOTIS e-manual, XL430-W250, Control Table.

use std::f64::consts::TAU;

use firmware::dynamixel::status::{ALERT, Refusal};
use plant::encoder::{VELOCITY_COUNT, ticks};

use super::lockstep::WheelState;

/// Model number of the XL430-W250.
pub const MODEL: u16 = 1060;
/// Firmware that it pretends to have: of 2021, with fast sync read.
pub const FIRMWARE: u8 = 46;
/// Code of 1 Mbit/s in the baud register: what the TurtleBot3 uses.
pub const BAUD_1M: u8 = 3;
/// Overload, in the hardware error register.
pub const OVERLOAD: u8 = 1 << 5;

/// Registers by name, as far as the servo itself looks at them.
mod at {
    pub(super) const ID: u16 = 7;
    pub(super) const BAUD: u16 = 8;
    pub(super) const RETURN_DELAY: u16 = 9;
    pub(super) const DRIVE_MODE: u16 = 10;
    pub(super) const OPERATING_MODE: u16 = 11;
    pub(super) const MOVING_THRESHOLD: u16 = 24;
    pub(super) const VELOCITY_LIMIT: u16 = 44;
    pub(super) const TORQUE_ENABLE: u16 = 64;
    pub(super) const STATUS_LEVEL: u16 = 68;
    pub(super) const HARDWARE_ERROR: u16 = 70;
    pub(super) const WATCHDOG: u16 = 98;
    pub(super) const GOALS: std::ops::Range<u16> = 100..120;
    pub(super) const GOAL_VELOCITY: u16 = 104;
    pub(super) const TICK: u16 = 120;
    pub(super) const MOVING: u16 = 122;
    pub(super) const PWM: u16 = 124;
    pub(super) const LOAD: u16 = 126;
    pub(super) const VELOCITY: u16 = 128;
    pub(super) const POSITION: u16 = 132;
    pub(super) const VOLTAGE: u16 = 144;
    pub(super) const TEMPERATURE: u16 = 146;
}

/// First address after the simulated registers; the indirect ones are not simulated.
const END: usize = 147;
/// First address that is not lost without power: below, torque has to be off to write.
const RAM: u16 = 64;
/// Velocity control in the operating mode register.
const VELOCITY_MODE: u8 = 1;
/// The reverse bit of the drive mode.
const REVERSE: u8 = 1;
/// What the watchdog shows when it has tripped: −1.
const TRIPPED: u8 = 0xFF;
/// A period of the watchdog's register, µs.
const WATCHDOG_US: u64 = 20_000;

/// A register: address, bytes, value after power-on, and what may be written.
struct Register(u16, u16, i32, Allowed);

enum Allowed {
    /// The servo only writes it.
    Never,
    /// From, to.
    Within(i32, i32),
    /// Plus and minus the limit in this other register.
    UpTo(u16),
}

use Allowed::{Never, UpTo, Within};

const REGISTERS: &[Register] = &[
    Register(0, 2, MODEL as i32, Never),
    Register(2, 4, 0, Never),
    Register(6, 1, FIRMWARE as i32, Never),
    Register(at::ID, 1, 1, Within(0, 252)),
    Register(at::BAUD, 1, BAUD_1M as i32, Within(0, 7)),
    Register(at::RETURN_DELAY, 1, 250, Within(0, 254)),
    Register(at::DRIVE_MODE, 1, 0, Within(0, 5)),
    Register(at::OPERATING_MODE, 1, VELOCITY_MODE as i32, Within(0, 16)),
    Register(12, 1, 255, Within(0, 255)),
    Register(13, 1, 2, Within(1, 2)),
    Register(20, 4, 0, Within(-1_044_479, 1_044_479)),
    Register(at::MOVING_THRESHOLD, 4, 10, Within(0, 1023)),
    Register(31, 1, 72, Within(0, 100)),
    Register(32, 2, 140, Within(60, 140)),
    Register(34, 2, 60, Within(60, 140)),
    Register(36, 2, 885, Within(0, 885)),
    Register(at::VELOCITY_LIMIT, 4, 265, Within(0, 1023)),
    Register(48, 4, 4095, Within(0, 4095)),
    Register(52, 4, 0, Within(0, 4095)),
    Register(60, 1, 0, Within(0, 3)),
    Register(63, 1, 52, Within(0, 63)),
    Register(at::TORQUE_ENABLE, 1, 0, Within(0, 1)),
    Register(65, 1, 0, Within(0, 1)),
    Register(at::STATUS_LEVEL, 1, 2, Within(0, 2)),
    Register(69, 1, 0, Never),
    Register(at::HARDWARE_ERROR, 1, 0, Never),
    Register(76, 2, 1000, Within(0, 16_383)),
    Register(78, 2, 100, Within(0, 16_383)),
    Register(80, 2, 4000, Within(0, 16_383)),
    Register(82, 2, 0, Within(0, 16_383)),
    Register(84, 2, 640, Within(0, 16_383)),
    Register(88, 2, 0, Within(0, 16_383)),
    Register(90, 2, 0, Within(0, 16_383)),
    Register(at::WATCHDOG, 1, 0, Within(0, 127)),
    Register(100, 2, 885, UpTo(36)),
    Register(at::GOAL_VELOCITY, 4, 0, UpTo(at::VELOCITY_LIMIT)),
    Register(108, 4, 0, Within(0, 32_767)),
    Register(112, 4, 0, Within(0, 32_767)),
    Register(116, 4, 0, Within(i32::MIN, i32::MAX)),
    Register(at::TICK, 2, 0, Never),
    Register(at::MOVING, 1, 0, Never),
    Register(123, 1, 0, Never),
    Register(at::PWM, 2, 0, Never),
    Register(at::LOAD, 2, 0, Never),
    Register(at::VELOCITY, 4, 0, Never),
    Register(at::POSITION, 4, 0, Never),
    Register(136, 4, 0, Never),
    Register(140, 4, 0, Never),
    Register(at::VOLTAGE, 2, 0, Never),
    Register(at::TEMPERATURE, 1, 0, Never),
];

/// Winding current at which the load register shows 100 %, A: at stall (e-manual, Specifications,
/// 11.1 V).
const STALL_A: f64 = 1.3;

/// Temperature that the servo shows, °C: warm after a while of driving. It has no part in the
/// model.
const TEMPERATURE: u8 = 32;

/// One servo.
#[derive(Debug, Clone)]
pub struct VirtualServo {
    table: [u8; END],
    /// Its axis points to the robot's left: counter-clockwise, its positive direction, drives
    /// forward.
    faces_left: bool,
    /// What the multi-turn counter has forgotten, rad.
    forgotten_rad: f64,
    angle_rad: f64,
    /// Last instruction from the bus, µs: for the watchdog.
    heard_us: u64,
    /// It is not on the bus: answers nothing.
    pub dead: bool,
    /// So many of its next answers get lost.
    pub drop_next: u32,
    /// Number of its next answers in which one bit flips.
    pub corrupt_next: u32,
}

impl VirtualServo {
    /// The left (ID 1) or right (ID 2, set to reverse) wheel's servo, as the TurtleBot3's set-up
    /// leaves it: velocity mode at 1 Mbit/s; equal signs mean forward on both.
    pub fn new(is_left: bool) -> Self {
        let mut servo = Self {
            table: [0; END],
            faces_left: is_left,
            forgotten_rad: 0.0,
            angle_rad: 0.0,
            heard_us: 0,
            dead: false,
            drop_next: 0,
            corrupt_next: 0,
        };
        for &Register(address, size, value, _) in REGISTERS {
            servo.set(address, size, value);
        }
        servo.set(at::ID, 1, if is_left { 1 } else { 2 });
        servo.set(at::DRIVE_MODE, 1, i32::from(if is_left { 0 } else { REVERSE }));
        servo
    }

    fn set(&mut self, address: u16, size: u16, value: i32) {
        let from = usize::from(address);
        let bytes = value.to_le_bytes();
        self.table[from..from + usize::from(size)].copy_from_slice(&bytes[..usize::from(size)]);
    }

    fn byte(&self, address: u16) -> u8 {
        self.table[usize::from(address)]
    }

    fn number(&self, address: u16) -> i32 {
        let from = usize::from(address);
        i32::from_le_bytes([0, 1, 2, 3].map(|i| self.table[from + i]))
    }

    /// Its ID.
    pub fn id(&self) -> u8 {
        self.byte(at::ID)
    }

    /// Whether it understands what comes at 1 Mbit/s.
    pub fn listens(&self) -> bool {
        !self.dead && self.byte(at::BAUD) == BAUD_1M
    }

    /// From the end of an instruction to its answer, µs.
    pub fn return_delay_us(&self) -> u32 {
        2 * u32::from(self.byte(at::RETURN_DELAY))
    }

    /// 0: answers pings only; 1: reads too; 2: everything.
    pub fn status_level(&self) -> u8 {
        self.byte(at::STATUS_LEVEL)
    }

    /// The alert bit of an error byte, as long as the hardware error register is not 0.
    pub fn alert(&self) -> u8 {
        if self.byte(at::HARDWARE_ERROR) == 0 { 0 } else { ALERT }
    }

    /// Torque is switched on.
    pub fn has_torque(&self) -> bool {
        self.byte(at::TORQUE_ENABLE) != 0
    }

    /// A fault that the servo finds in itself: it shuts down, and only a reboot ends that.
    pub fn fail(&mut self, hardware_error: u8) {
        self.table[usize::from(at::HARDWARE_ERROR)] = hardware_error;
        self.table[usize::from(at::TORQUE_ENABLE)] = 0;
    }

    /// +1 where the servo's positive direction drives forward.
    fn direction(&self) -> f64 {
        if self.faces_left == (self.byte(at::DRIVE_MODE) & REVERSE == 0) { 1.0 } else { -1.0 }
    }

    /// The commanded wheel speed, rad/s, positive forward: 0 without torque or in a different mode.
    pub fn goal_rad_s(&self) -> f64 {
        if !self.has_torque()
            || self.byte(at::OPERATING_MODE) != VELOCITY_MODE
            || self.byte(at::WATCHDOG) == TRIPPED
        {
            return 0.0;
        }
        self.direction() * f64::from(self.number(at::GOAL_VELOCITY)) * VELOCITY_COUNT
    }

    /// The present-value registers become what they show at a time.
    pub fn sense(&mut self, time_us: u64, wheel: WheelState, supply_v: f64) {
        let watchdog = self.byte(at::WATCHDOG);
        let quiet_us = time_us.saturating_sub(self.heard_us);
        if (1..=127).contains(&watchdog) && quiet_us > u64::from(watchdog) * WATCHDOG_US {
            self.set(at::WATCHDOG, 1, i32::from(TRIPPED));
            self.set(at::GOAL_VELOCITY, 4, 0);
        }
        self.angle_rad = wheel.angle_rad;
        let direction = self.direction();
        let position = ticks(direction * (wheel.angle_rad - self.forgotten_rad)) as i32;
        let velocity = (direction * wheel.speed_rad_s / VELOCITY_COUNT).round() as i32;
        let moving = velocity.abs() > self.number(at::MOVING_THRESHOLD);
        // The load is positive counter-clockwise whatever the drive mode: inferred, as the servo
        // does without a current sensor.
        let clockwise = if self.faces_left { 1.0 } else { -1.0 };
        let load = (clockwise * wheel.current_a / STALL_A * 1000.0).round().clamp(-1000.0, 1000.0);
        self.set(at::TICK, 2, (time_us / 1000 % 32_768) as i32);
        self.set(at::MOVING, 1, i32::from(moving));
        self.set(at::PWM, 2, (direction * wheel.duty * 885.0).round() as i32);
        self.set(at::LOAD, 2, load as i32);
        self.set(at::VELOCITY, 4, velocity);
        self.set(at::POSITION, 4, position);
        self.set(at::VOLTAGE, 2, (supply_v * 10.0).round() as i32);
        self.set(at::TEMPERATURE, 1, i32::from(TEMPERATURE));
    }

    /// An instruction has come: the watchdog restarts.
    pub fn hear(&mut self, time_us: u64) {
        self.heard_us = time_us;
    }

    /// Bytes of the table. Addresses between registers read as 0.
    ///
    /// # Errors
    /// Beyond the table, or nothing.
    pub fn read(&self, address: u16, count: u16) -> Result<&[u8], Refusal> {
        let from = usize::from(address);
        match self.table.get(from..from + usize::from(count)) {
            None => Err(Refusal::Access),
            Some([]) => Err(Refusal::Length),
            Some(bytes) => Ok(bytes),
        }
    }

    /// Writes one register, or several that follow each other; all or none.
    ///
    /// # Errors
    /// Why nothing was written.
    pub fn write(&mut self, address: u16, data: &[u8]) -> Result<(), Refusal> {
        if data.is_empty() {
            return Err(Refusal::Length);
        }
        let mut next = address;
        let mut unchecked = data;
        while !unchecked.is_empty() {
            let register = REGISTERS.iter().find(|register| register.0 == next).ok_or(Refusal::Access)?;
            let (value, rest) = unchecked.split_at_checked(usize::from(register.1)).ok_or(Refusal::Length)?;
            self.check(register, value)?;
            next += register.1;
            unchecked = rest;
        }
        let from = usize::from(address);
        let torque = self.byte(at::TORQUE_ENABLE);
        self.table[from..from + data.len()].copy_from_slice(data);
        if self.alert() != 0 {
            // A servo that has shut down stays without torque.
            self.table[usize::from(at::TORQUE_ENABLE)] = 0;
        } else if torque == 0 && self.has_torque() {
            // The goal is not kept from before.
            self.set(at::GOAL_VELOCITY, 4, 0);
        }
        Ok(())
    }

    fn check(&self, Register(address, _, _, allowed): &Register, value: &[u8]) -> Result<(), Refusal> {
        let value = match *value {
            [a] => i32::from(a),
            [a, b] => i32::from(i16::from_le_bytes([a, b])),
            [a, b, c, d] => i32::from_le_bytes([a, b, c, d]),
            _ => return Err(Refusal::Length),
        };
        if *address < RAM && self.has_torque() {
            return Err(Refusal::Access);
        }
        if self.byte(at::WATCHDOG) == TRIPPED && at::GOALS.contains(address) {
            // Goals are read-only until 0 is written to the watchdog.
            return Err(Refusal::Access);
        }
        match *allowed {
            Never => Err(Refusal::Access),
            Within(from, to) if (from..=to).contains(&value) => Ok(()),
            Within(..) => Err(Refusal::Range),
            UpTo(limit) => {
                let limit = if limit == at::VELOCITY_LIMIT { self.number(limit) } else { 885 };
                if (-limit..=limit).contains(&value) { Ok(()) } else { Err(Refusal::Limit) }
            }
        }
    }

    /// Restarts: torque off, errors gone, volatile registers as after power-on; the position counts
    /// from within one turn again.
    pub fn reboot(&mut self) {
        for &Register(address, size, value, _) in REGISTERS.iter().filter(|register| register.0 >= RAM) {
            self.set(address, size, value);
        }
        let within = (self.direction() * self.angle_rad).rem_euclid(TAU);
        self.forgotten_rad = self.angle_rad - self.direction() * within;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORWARD: WheelState = WheelState { angle_rad: 10.0, speed_rad_s: 6.0, duty: 0.8, current_a: 0.13 };

    fn number(servo: &VirtualServo, address: u16, size: u16) -> i32 {
        let mut bytes = [0; 4];
        let read = servo.read(address, size).unwrap();
        bytes[..read.len()].copy_from_slice(read);
        if size == 2 {
            i32::from(i16::from_le_bytes([bytes[0], bytes[1]]))
        } else {
            i32::from_le_bytes(bytes)
        }
    }

    #[test]
    fn registers_are_sorted_and_do_not_overlap() {
        for pair in REGISTERS.windows(2) {
            assert!(pair[0].0 + pair[0].1 <= pair[1].0, "{}", pair[0].0);
        }
    }

    /// By hand: 10 rad are 10 / 2π · 4096 = 6518.99 ticks; 6 rad/s are 57.296 rev/min, 250.2 counts
    /// of 0.229; 0.13 A of 1.3 A are 10 %; 0.8 of 885 is 708. Forward shows with equal signs on
    /// both sides, but for the load.
    #[test]
    fn forward_shows_alike_on_both_sides() {
        for is_left in [true, false] {
            let mut servo = VirtualServo::new(is_left);
            servo.sense(40_000_000, FORWARD, 11.94);
            let shown = [(132, 4), (128, 4), (124, 2), (144, 2), (120, 2), (122, 1)]
                .map(|(address, size)| number(&servo, address, size));
            assert_eq!(shown, [6518, 250, 708, 119, 40_000 % 32_768, 1]);
            assert_eq!(number(&servo, 126, 2), if is_left { 100 } else { -100 });
        }
        // Without the reverse bit the right wheel counts backwards.
        let mut right = VirtualServo::new(false);
        right.write(10, &[0]).unwrap();
        right.sense(0, FORWARD, 12.0);
        assert_eq!((number(&right, 132, 4), number(&right, 128, 4)), (-6519, -250));
    }

    #[test]
    fn what_may_be_written_when() {
        let mut servo = VirtualServo::new(true);
        assert_eq!(servo.read(0, 7).unwrap(), [0x24, 0x04, 0, 0, 0, 0, FIRMWARE]);
        assert_eq!(servo.write(9, &[0]), Ok(()));
        assert_eq!(servo.return_delay_us(), 0);
        assert_eq!(servo.write(64, &[1]), Ok(()));
        assert_eq!(servo.write(9, &[10]), Err(Refusal::Access), "torque is on");
        assert_eq!(servo.write(132, &[0; 4]), Err(Refusal::Access), "read only");
        assert_eq!(servo.write(64, &[2]), Err(Refusal::Range));
        assert_eq!(servo.write(104, &[1, 0]), Err(Refusal::Length));
        assert_eq!(servo.write(104, &266_i32.to_le_bytes()), Err(Refusal::Limit));
        assert_eq!(servo.write(104, &(-265_i32).to_le_bytes()), Ok(()));
        assert!((servo.goal_rad_s() + 265.0 * 0.023_980_82).abs() < 1e-5, "{}", servo.goal_rad_s());
        assert_eq!(servo.read(140, 8), Err(Refusal::Access));
        // Both or none.
        assert_eq!(servo.write(64, &[0, 7]), Err(Refusal::Range));
        assert!(servo.has_torque());
    }

    #[test]
    fn a_shut_down_servo_needs_a_reboot() {
        let mut servo = VirtualServo::new(true);
        servo.write(64, &[1]).unwrap();
        servo.sense(0, FORWARD, 12.0);
        servo.fail(OVERLOAD);
        assert!(!servo.has_torque() && servo.alert() == 0x80);
        servo.write(64, &[1]).unwrap();
        assert!(!servo.has_torque());
        servo.reboot();
        assert_eq!(servo.alert(), 0);
        servo.write(64, &[1]).unwrap();
        assert!(servo.has_torque());
        // 6518 ticks are one turn and 2422.
        servo.sense(0, FORWARD, 12.0);
        assert_eq!(number(&servo, 132, 4), 2422);
    }

    #[test]
    fn the_watchdog_stops_the_wheel() {
        let mut servo = VirtualServo::new(true);
        servo.write(64, &[1]).unwrap();
        servo.write(98, &[25]).unwrap();
        servo.write(104, &100_i32.to_le_bytes()).unwrap();
        servo.hear(1_000_000);
        servo.sense(1_500_000, FORWARD, 12.0);
        assert!(servo.goal_rad_s() > 2.0);
        servo.sense(1_500_001, FORWARD, 12.0);
        assert_eq!((servo.goal_rad_s(), servo.read(98, 1).unwrap()), (0.0, &[0xFF][..]));
        assert_eq!(servo.write(104, &[0; 4]), Err(Refusal::Access));
        servo.write(98, &[0]).unwrap();
        assert_eq!(servo.write(104, &[0; 4]), Ok(()));
    }
}
