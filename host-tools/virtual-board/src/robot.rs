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
use super::mpu9250_chip::{Felt, Mpu9250Chip};
use super::servo::VirtualServo;
use super::servo_bus::{ServoAnswer, ServoBus};

/// Addresses of the sensors of battery, motors, computer and lidar, as soldered.
pub const SENSOR_ADDRESSES: [u8; RAILS] = [0x40, 0x41, 0x44, 0x45];

/// Their shunts, Ω: those of common modules.
const SHUNT_OHM: f64 = 0.1;

/// How far a supply's reading scatters by itself, W. Computer and scanner have no drives that chop
/// their current. An assumption.
const QUIET_NOISE_W: f64 = 0.01;

/// Settings beside the scenario.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobotOptions {
    /// Standard deviation of a power reading of motors and battery, W, as `gmr simulate --sensors
    /// servo` has it.
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
    inertial: Mpu9250Chip,
    inertial_noise: ChaCha8Rng,
    /// Forward speed, m/s, when the inertial sensor was read last, and when, µs.
    speed_before: (f64, u64),
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
    /// What [`Lockstep::new`] finds; a noise that is negative or not finite; a charge beyond 0 and
    /// 1.
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
            inertial: Mpu9250Chip::default(),
            inertial_noise: stream(seed, Stream::InertialChip),
            speed_before: (0.0, 0),
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

    /// A transaction on the inertial sensor's bus now.
    pub fn inertial(&mut self, bytes: &[u8]) -> Vec<u8> {
        let geometry = self.plant.scenario().robot.geometry;
        let [left, right] = self.plant.wheels().map(|wheel| wheel.speed_rad_s * geometry.wheel_radius_m);
        let (speed, now_us) = ((left + right) / 2.0, self.now_us());
        let (before, before_us) = self.speed_before;
        // A reading a millisecond: within one it stays.
        if now_us >= before_us + 1000 {
            let elapsed_s = (now_us - before_us) as f64 * 1e-6;
            let felt = Felt {
                yaw_rad_s: (right - left) / geometry.track_m,
                forward_m_s2: (speed - before) / elapsed_s,
            };
            let rng = &mut self.inertial_noise;
            self.inertial.feel(felt, || StandardNormal.sample(rng));
            self.speed_before = (speed, now_us);
        }
        self.inertial.transact(bytes)
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

    /// Power from the registers, summed up, is the energy that the rail gave: each reading stands
    /// for its 4.256 ms, of which the shunt sees the first half. Over 20 s of driving, within 0.5 %
    /// (sampled half of the time, quantised to 0.1 mA and 4 mV).
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

    /// 0.1 W at 12 V and no motion: readings scatter by 8.3 mA, 83 codes. 2000 readings: the
    /// standard deviation within 1.6 %, four of them 6.4 %; the computer, ten times quieter at 5 V,
    /// by 2 mA.
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
        // Write 1 to register 64 of ID 1 (checksum by the codec's tests' vectors: taken from the
        // codec).
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

    /// On the spot by 100 counts of 0.229 rev/min: 0.033 m over 0.160 m of 2 · 2.398 rad/s, in
    /// counts of 500 °/s / 32,768, with the bias.
    #[test]
    fn the_inertial_sensor_feels_what_the_robot_does() {
        let scenario =
            Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Standstill, 30.0, 1);
        let options = RobotOptions { driven_by_board: true, ..RobotOptions::default() };
        let mut robot = VirtualRobot::new(scenario, options).unwrap();
        let geometry = robot.scenario().robot.geometry;
        robot.inertial(&[0x1B, 0x08, 0x08]);
        let mean = |robot: &mut VirtualRobot, from: u64| {
            let mut sums = [0.0; 2];
            for reading in 0..1000_u64 {
                robot.advance_to(from + reading * 1000);
                let bytes = robot.inertial(&[[0x80 | 0x3B].as_slice(), &[0; 14]].concat());
                let count = |at: usize| f64::from(i16::from_be_bytes([bytes[at], bytes[at + 1]]));
                sums = [sums[0] + count(5), sums[1] + count(13)];
            }
            sums.map(|sum| sum / 1000.0)
        };
        let [gravity, still] = mean(&mut robot, 1000);
        assert!((gravity - 8192.0).abs() < 5.0, "{gravity}");
        for (servo, goal) in robot.servo_bus.servos.iter_mut().zip([-100_i32, 100]) {
            servo.write(64, &[1]).unwrap();
            servo.write(104, &goal.to_le_bytes()).unwrap();
        }
        robot.advance_to(4_000_000);
        let [_, turning] = mean(&mut robot, 4_000_000);
        let [left, right] = robot.truth().wheel_rad_s;
        let rate = ((right - left) * geometry.wheel_radius_m / geometry.track_m).to_degrees();
        assert!(
            rate > 40.0 && ((turning - still) * 500.0 / 32_768.0 - rate).abs() < 0.05 * rate,
            "{turning} {still} {rate}"
        );
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
