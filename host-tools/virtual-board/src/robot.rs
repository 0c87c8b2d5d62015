//! The robot around a virtual board: its power sensors and servos, in step with the plant.

use firmware::exchange::BusAnswer;
use plant::Scenario;
use plant::noise::{Stream, stream};
use plant::rails::{RAILS, Supply};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use support::error::{Error, Result};

use super::ina219_chip::Ina219Chip;
use super::ina219_chip::Seen;
use super::lockstep::Span;
use super::lockstep::{Lockstep, Truth};
use super::servo::VirtualServo;
use super::servo_bus::{ServoAnswer, ServoBus};

/// Addresses of the sensors of battery, motors, computer and lidar, as soldered.
pub const SENSOR_ADDRESSES: [u8; RAILS] = [0x40, 0x41, 0x44, 0x45];

/// Their shunts, Ω: those of common modules.
const SHUNT_OHM: f64 = 0.1;

/// What a supply's reading scatters by itself, W: computer and scanner have no drives that chop their current. An assumption.
const QUIET_NOISE_W: f64 = 0.01;

/// Settings beside the scenario.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobotOptions {
    /// Standard deviation of a power reading of motors and battery, W, as `gmr simulate --sensors servo` has it.
    pub power_noise_w: f64,
    /// The laser scanner turns.
    pub lidar: bool,
    /// The servos' goal velocities drive, not the scenario's profile.
    pub driven_by_board: bool,
    /// What is in the battery at the start, 0 to 1; without, it never empties.
    pub charge: Option<f64>,
}

impl Default for RobotOptions {
    fn default() -> Self {
        Self { power_noise_w: 0.1, lidar: true, driven_by_board: false, charge: None }
    }
}

/// Plant, sensors and servos. Goes on as far as it is asked; constant in memory.
#[derive(Debug, Clone)]
pub struct VirtualRobot {
    plant: Lockstep,
    /// In the order of [`SENSOR_ADDRESSES`]. Their fields switch faults on.
    pub sensors: [Ina219Chip; RAILS],
    /// Their fields switch faults on.
    pub servo_bus: ServoBus,
    /// A line of the sensors' bus is held low.
    pub is_bus_stuck: bool,
    driven_by_board: bool,
    has_servo_supply: bool,
    noise_w: [f64; RAILS],
    noise: [ChaCha8Rng; RAILS],
}

impl VirtualRobot {
    /// A robot at rest. Sampling rate, sensors and static power of the scenario have no part in it.
    ///
    /// # Errors
    /// What [`Lockstep::new`] finds; a noise that is negative or not finite; a charge beyond 0 and 1.
    pub fn new(scenario: Scenario, options: RobotOptions) -> Result<Self> {
        let RobotOptions { power_noise_w, lidar, driven_by_board, charge } = options;
        if !(power_noise_w >= 0.0 && power_noise_w.is_finite()) {
            return Err(Error::usage(format!("power noise {power_noise_w}; allowed: W, 0 or more")));
        }
        if charge.is_some_and(|charge| !(0.0..=1.0).contains(&charge)) {
            return Err(Error::usage("charge; allowed: a share of the battery's capacity, 0 to 1"));
        }
        let quiet = QUIET_NOISE_W.min(power_noise_w);
        let seed = scenario.seed;
        let mut plant = Lockstep::new(scenario)?;
        if let Some(charge) = charge {
            plant.set_charge(charge);
        }
        plant.power.lidar = lidar;
        Ok(Self {
            plant,
            sensors: std::array::from_fn(|_| Ina219Chip::new(SHUNT_OHM)),
            servo_bus: ServoBus::default(),
            is_bus_stuck: false,
            driven_by_board,
            has_servo_supply: true,
            noise_w: [power_noise_w, power_noise_w, quiet, quiet],
            // One seed for each rail: what one reads does not depend on how the others are set up.
            noise: std::array::from_fn(|rail| {
                stream(seed.wrapping_mul(RAILS as u64).wrapping_add(rail as u64), Stream::RailNoise)
            }),
        })
    }

    /// Since the start, µs.
    pub fn now_us(&self) -> u64 {
        self.plant.now_us()
    }

    /// What is true now.
    pub fn truth(&self) -> Truth {
        self.plant.truth()
    }

    /// What is simulated.
    pub fn scenario(&self) -> &Scenario {
        self.plant.scenario()
    }

    /// Switches the laser scanner.
    pub fn set_lidar(&mut self, on: bool) {
        self.plant.power.lidar = on;
    }

    /// Switches the servos' supply. With it they start anew; without, nobody answers.
    pub fn set_servo_supply(&mut self, on: bool) {
        if on != self.has_servo_supply {
            self.servo_bus.servos.iter_mut().for_each(VirtualServo::reboot);
            self.has_servo_supply = on;
        }
    }

    /// Goes to `time_us`; what lies in the past stays as it was.
    pub fn advance_to(&mut self, time_us: u64) {
        if self.driven_by_board {
            let servos = &self.servo_bus.servos;
            self.plant.command = Some(std::array::from_fn(|i| servos[i].goal_rad_s()));
            // Where a profile drives, the plant's static power stands for whoever holds the torque.
            self.plant.power.torque = std::array::from_fn(|i| servos[i].has_torque());
        }
        while let Some(span) = self.plant.advance_towards(time_us) {
            self.observe(span);
        }
    }

    fn observe(&mut self, span: Span) {
        let rails = self.sensors.iter_mut().zip(&mut self.noise).zip(self.noise_w).zip(span.rails);
        for (((chip, rng), noise_w), rail) in rails {
            let Supply { voltage_v, .. } = rail;
            let seen = Seen { current_a: rail.current_a(), bus_v: voltage_v };
            chip.pass(span.length_us, seen, || {
                let unit: f64 = StandardNormal.sample(rng);
                noise_w * unit / voltage_v
            });
        }
    }

    /// A transaction on the sensors' bus now: writes `bytes`, then fills `answer`.
    pub fn i2c(&mut self, address: u8, bytes: &[u8], answer: &mut [u8]) -> BusAnswer {
        if self.is_bus_stuck {
            return BusAnswer::Stuck;
        }
        let place = SENSOR_ADDRESSES.iter().position(|&known| known == address);
        match place.map(|place| self.sensors[place].transact(bytes, answer)) {
            Some(Ok(())) => BusAnswer::Done,
            Some(Err(_)) | None => BusAnswer::NoAcknowledge,
        }
    }

    /// Bytes on the servo bus, the first of them now.
    pub fn servo(&mut self, bytes: &[u8]) -> ServoAnswer {
        let now_us = self.now_us();
        if !self.has_servo_supply {
            return ServoAnswer::default();
        }
        let [_, motors, ..] = self.plant.rails();
        self.servo_bus.sense(now_us, self.plant.wheels(), motors.voltage_v);
        self.servo_bus.exchange(now_us, bytes)
    }
}

#[cfg(test)]
mod tests {
    use plant::{Kinematics, PlantSet, ProfileKind};

    use super::*;

    /// ±320 mV, 32 V, means of four, both continuously: 4.256 ms.
    const SET_UP: [u8; 3] = [0x00, 0x3D, 0x57];

    fn robot(seed: u64, noise: f64) -> VirtualRobot {
        let scenario =
            Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Training, 30.0, seed);
        VirtualRobot::new(scenario, RobotOptions { power_noise_w: noise, ..RobotOptions::default() }).unwrap()
    }

    fn read(robot: &mut VirtualRobot, address: u8, register: u8) -> u16 {
        let mut answer = [0; 2];
        assert_eq!(robot.i2c(address, &[register], &mut answer), BusAnswer::Done);
        u16::from_be_bytes(answer)
    }

    /// Everything that a board hears in 5 s of sampling at 200 Hz.
    fn heard(robot: &mut VirtualRobot) -> Vec<u8> {
        let mut bytes = Vec::new();
        for address in SENSOR_ADDRESSES {
            robot.i2c(address, &SET_UP, &mut []);
        }
        let sync_read =
            [0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x09, 0x00, 0x82, 0x84, 0x00, 0x04, 0x00, 0x01, 0x02, 0xCE, 0xFA];
        for sample in 1..=1000_u64 {
            robot.advance_to(sample * 5000);
            for address in SENSOR_ADDRESSES {
                for register in [2, 1, 3] {
                    bytes.extend(read(robot, address, register).to_le_bytes());
                }
            }
            bytes.extend(robot.servo(&sync_read).bytes);
        }
        bytes
    }

    #[test]
    fn the_same_seed_gives_the_same_bytes_and_another_others() {
        let once = heard(&mut robot(7, 0.1));
        assert!(once == heard(&mut robot(7, 0.1)));
        assert!(once != heard(&mut robot(8, 0.1)));
    }

    /// Power from the registers, summed up, is the energy that the rail gave: each reading stands for its 4.256 ms, of which the
    /// shunt sees the first half. Over 20 s of driving, within 0.5 % (sampled half of the time, quantised to 0.1 mA and 4 mV).
    #[test]
    fn the_sensors_measure_what_the_rails_give() {
        let mut robot = robot(3, 0.0);
        for address in SENSOR_ADDRESSES {
            robot.i2c(address, &SET_UP, &mut []);
        }
        let mut energy = [0.0; RAILS];
        for reading in 1..=4700_u64 {
            robot.advance_to(reading * 4256);
            for (energy, address) in energy.iter_mut().zip(SENSOR_ADDRESSES) {
                let bus = read(&mut robot, address, 2);
                assert_eq!(bus & 0b11, 0b10, "ready, no overflow");
                let shunt = read(&mut robot, address, 1).cast_signed();
                read(&mut robot, address, 3);
                *energy += f64::from(shunt) * 1e-4 * f64::from(bus >> 3) * 4e-3 * 4.256e-3;
            }
        }
        let truth = robot.truth();
        for (measured, given) in energy.into_iter().zip(truth.rails_j) {
            assert!((measured / given - 1.0).abs() < 5e-3, "{measured} J of {given} J");
        }
        assert!(truth.actuation_j > 5.0);
    }

    /// 0.1 W at 12 V and no motion: readings scatter by 8.3 mA, 83 codes. 2000 readings: the standard deviation within 1.6 %, four
    /// of them 6.4 %; the computer, ten times quieter at 5 V, by 2 mA.
    #[test]
    fn readings_scatter_as_asked() {
        let scenario =
            Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Standstill, 30.0, 1);
        let mut robot = VirtualRobot::new(scenario, RobotOptions::default()).unwrap();
        let mut codes = [Vec::new(), Vec::new()];
        for reading in 1..=2000_u64 {
            robot.advance_to(reading * 1064);
            codes[0].push(f64::from(read(&mut robot, 0x41, 1).cast_signed()));
            codes[1].push(f64::from(read(&mut robot, 0x45, 1).cast_signed()));
        }
        for (codes, expected) in codes.iter().zip([0.1 / 11.943 * 1e4, 0.01 / 5.0 * 1e4]) {
            let mean = codes.iter().sum::<f64>() / codes.len() as f64;
            let variance = codes.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / codes.len() as f64;
            assert!((variance.sqrt() / expected - 1.0).abs() < 0.064, "{} {expected}", variance.sqrt());
        }
    }

    #[test]
    fn torque_shows_in_the_motors_rail_of_a_driving_board() {
        let mut robot = robot(1, 0.0);
        robot.driven_by_board = true;
        robot.advance_to(10_000);
        let before = robot.truth().rails[1].power_w;
        // Write 1 to register 64 of ID 1 (checksum by the codec's tests' vectors: taken from the codec).
        let mut buffer = [0; 32];
        let packet = firmware::dynamixel::packet::encode(
            1,
            firmware::dynamixel::packet::Instruction::Write,
            &[&[64, 0, 1]],
            &mut buffer,
        )
        .unwrap();
        assert_eq!(robot.servo(packet).bytes.len(), 11);
        robot.advance_to(20_000);
        let more = robot.truth().rails[1].power_w - before;
        // 46.7 mA at 11.9 V, the robot still at rest.
        assert!((more - 0.557).abs() < 0.01, "{more}");
    }

    #[test]
    fn a_board_can_drive_the_wheels() {
        let scenario =
            Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Standstill, 30.0, 1);
        let options = RobotOptions { driven_by_board: true, ..RobotOptions::default() };
        let mut robot = VirtualRobot::new(scenario, options).unwrap();
        for servo in &mut robot.servo_bus.servos {
            servo.write(64, &[1]).unwrap();
            servo.write(104, &200_i32.to_le_bytes()).unwrap();
        }
        for step in 1..=200 {
            robot.advance_to(step * 10_000);
        }
        // 200 counts of 0.229 rev/min.
        for speed in robot.truth().wheel_rad_s {
            assert!((speed - 200.0 * 0.023_980_82).abs() < 0.02, "{speed}");
        }
    }

    #[test]
    fn nobody_answers_at_other_addresses_and_on_a_stuck_bus() {
        let mut robot = robot(1, 0.0);
        assert_eq!(robot.i2c(0x42, &[0], &mut [0; 2]), BusAnswer::NoAcknowledge);
        robot.sensors[1].absent = true;
        assert_eq!(robot.i2c(0x41, &[0], &mut [0; 2]), BusAnswer::NoAcknowledge);
        assert_eq!(robot.i2c(0x40, &[0], &mut [0; 2]), BusAnswer::Done);
        robot.is_bus_stuck = true;
        assert_eq!(robot.i2c(0x40, &[0], &mut [0; 2]), BusAnswer::Stuck);
    }
}
