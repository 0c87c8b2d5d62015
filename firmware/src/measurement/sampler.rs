//! Takes the samples.

use embassy_futures::join::join;
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};
use model_core::coefficients::Coefficients;
use model_core::estimator::Unfit;

use super::{BatteryMeter, DriveSnapshot, EstimateSnapshot, RailSnapshot, Snapshot, WheelSnapshot};
use crate::drive::Orders;
use crate::estimation::{Estimated, Estimation};
use crate::power_sensors::{Convert, Health, PowerSensors, RAIL_COUNT, RailName};
use crate::record::Record;
use crate::wheels::{Standstill, SwitchedPort, WHEELS, Wheels};

/// Everything that a sample goes through: `I` is the power sensors' bus, `P` the port of the servo
/// bus, `D` limits the time that is waited there.
pub struct Sampler<I, P, D> {
    sensors: PowerSensors<I>,
    wheels: Wheels<P, D>,
    estimation: Estimation,
    standstill: Standstill,
    battery: BatteryMeter,
    samples: u32,
    latest: Latest,
}

/// The last sample.
#[derive(Debug, Clone, Copy, Default)]
struct Latest {
    time_us: u64,
    /// As measured, rad/s.
    speeds: [Option<f32>; WHEELS],
    estimated: Estimated,
    is_standing: bool,
}

impl<I: Convert, P: Read + Write, D: DelayNs> Sampler<I, P, D> {
    /// Without coefficients and calibration, until they are set.
    pub fn new(sensors: PowerSensors<I>, wheels: Wheels<P, D>) -> Self {
        Self {
            sensors,
            wheels,
            estimation: Estimation::default(),
            standstill: Standstill::default(),
            battery: BatteryMeter::new(),
            samples: 0,
            latest: Latest::default(),
        }
    }

    /// Takes one sample, to be called once a period; `time_us` since start. Whatever fails costs
    /// its own part of the record and a bounded time (see [`PowerSensors::poll`],
    /// [`Wheels::poll`]).
    pub async fn sample(&mut self, time_us: u64) -> Record {
        self.sample_and_drive(time_us, &Orders::NONE).await
    }

    /// The same, and the wheels do what is ordered, as soon as they have been read.
    pub async fn sample_and_drive(&mut self, time_us: u64, orders: &Orders) -> Record {
        let wheels = async {
            let readings = self.wheels.poll(time_us).await;
            self.wheels.drive(time_us, orders).await;
            readings
        };
        let (rails, wheels) = join(self.sensors.poll(time_us), wheels).await;
        let speeds = wheels.map(|reading| reading.map(|reading| reading.speed));
        let wheel_speed = both(speeds);
        let rail_power = rails.map(|reading| reading.map(|reading| reading.power));
        let [battery, ..] = rails;
        self.battery.update(battery, time_us);
        let motors_power = rail_power.get(RailName::Motors as usize).copied().flatten();
        let estimated = self.estimation.sample(wheel_speed, motors_power, time_us);
        let is_still = self.standstill.update(&wheels, time_us, self.estimation.dead_band());
        let is_standing = is_still || self.wheels.is_dead();
        let record = Record {
            sequence: self.samples,
            time_us,
            wheel_speed,
            rail_power,
            battery_voltage: battery.map(|reading| reading.voltage),
            health: self.sensors.statuses().map(|status| status.health()),
            has_coefficients: self.estimation.has_coefficients(),
            is_estimated: estimated.taken,
            has_changed: estimated.changed,
            is_standing,
            predicted_power: estimated.predicted_power,
            mass: estimated.mass.known(),
        };
        self.samples = self.samples.wrapping_add(1);
        self.latest = Latest { time_us, speeds, estimated, is_standing };
        record
    }

    /// Goals alone, between two samples: for a stop that cannot wait.
    pub async fn hurry(&mut self, time_us: u64, orders: &Orders) {
        self.wheels.hurry(time_us, orders).await;
    }

    /// Estimates with these coefficients from the next sample on, or with none.
    ///
    /// # Errors
    /// A filter cutoff that the sample rate cannot have. Everything stays as it was.
    pub fn set_coefficients(
        &mut self,
        coefficients: Option<&Coefficients<f32, WHEELS>>,
    ) -> Result<(), Unfit> {
        self.estimation.set_coefficients(coefficients)
    }

    /// A calibration from the store: true power over measured power of each rail.
    pub fn set_power_factors(&mut self, factors: [f32; RAIL_COUNT]) {
        self.sensors.set_power_factors(factors);
    }

    /// What is known after the last sample.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            time_us: self.latest.time_us,
            samples: self.samples,
            rails: self.rails(),
            battery: self.battery.known(),
            wheels: self.wheel_snapshots(),
            servo_bus: self.wheels.counters(),
            estimate: self.estimate(),
            is_standing: self.latest.is_standing,
            drive: DriveSnapshot {
                state: self.wheels.drive_state(),
                has_torque: self.wheels.has_torque(),
                are_off: self.wheels.are_off(),
                goals: self.wheels.goals(),
            },
        }
    }

    fn rails(&self) -> [RailSnapshot; RAIL_COUNT] {
        let mut rails = [RailSnapshot::UNKNOWN; RAIL_COUNT];
        let sensors = self.sensors.statuses().into_iter().zip(self.sensors.latest());
        let figures = self.sensors.energies().into_iter().zip(self.sensors.power_factors());
        for ((rail, (status, latest)), (energy, power_factor)) in rails.iter_mut().zip(sensors).zip(figures) {
            let latest = latest.filter(|_| status.health() == Health::Ok);
            *rail = RailSnapshot {
                voltage: latest.map(|reading| reading.voltage),
                current: latest.map(|reading| reading.current),
                power: latest.map(|reading| reading.power),
                energy,
                health: status.health(),
                counters: status.counters(),
                power_factor,
            };
        }
        rails
    }

    fn wheel_snapshots(&self) -> [WheelSnapshot; WHEELS] {
        let filtered = self.latest.estimated.filtered;
        let speeds = filtered.map_or(self.latest.speeds, |filtered| filtered.speed.map(Some));
        let accelerations = filtered.map_or([None; WHEELS], |filtered| filtered.acceleration.map(Some));
        let mut wheels = [WheelSnapshot::UNKNOWN; WHEELS];
        let figures = self.wheels.statuses().into_iter().zip(speeds).zip(accelerations);
        for (wheel, ((status, speed), acceleration)) in wheels.iter_mut().zip(figures) {
            *wheel = WheelSnapshot {
                health: status.health,
                hardware_error: status.hardware_error,
                speed,
                acceleration,
                position: status.present.map(|present| present.position.0),
                odometer: status.odometer,
                velocity_code: status.present.map_or(0, |present| present.velocity.0),
                load_code: status.present.map_or(0, |present| present.load.0),
                misfit: status.misfit,
            };
        }
        wheels
    }

    fn estimate(&self) -> EstimateSnapshot {
        let Estimated { filtered, predicted_power, mass, .. } = self.latest.estimated;
        let energy = self.estimation.energy();
        EstimateSnapshot {
            model: self.estimation.model(),
            mass,
            measured_power: filtered.map(|filtered| filtered.power),
            predicted_power,
            measured_energy: energy.map(|(measured, _)| measured),
            predicted_energy: energy.map(|(_, predicted)| predicted),
            counted: self.estimation.counted(),
            changes: self.estimation.changes(),
        }
    }
}

impl<I: Convert, P: SwitchedPort, D: DelayNs> Sampler<I, P, D> {
    /// Switches the servos' supply.
    pub fn set_servo_supply(&mut self, on: bool) {
        self.wheels.set_supply(on);
    }
}

/// All speeds, or none: a robot that is known by half is not known.
fn both(speeds: [Option<f32>; WHEELS]) -> Option<[f32; WHEELS]> {
    let [left, right] = speeds;
    Some([left?, right?])
}

#[cfg(test)]
mod tests {
    use model_core::payload::{MassEstimate, Unknown};

    use super::*;
    use crate::dynamixel::testing::{Patience, Servos};
    use crate::estimation::Counted;
    use crate::estimation::tests::{coefficients, signed};
    use crate::parameters::SAMPLE_PERIOD_US;
    use crate::power_sensors::testing::Chips;
    use crate::testing::now;
    use crate::wheels::WheelHealth;

    /// Four sensors and two servos.
    struct Robot {
        chips: Chips,
        servos: Servos,
    }

    type Board<'a> = Sampler<&'a Chips, &'a Servos, &'a Patience>;

    impl Robot {
        fn new() -> Self {
            Self { chips: Chips::new(), servos: Servos::new() }
        }

        fn board(&self) -> Board<'_> {
            let sensors = PowerSensors::new(&self.chips);
            Sampler::new(sensors, Wheels::new(&self.servos, &self.servos.patience))
        }

        /// The `i`th sample, the wheels having turned by 8 counts (2.4 rad/s) and back by 4.
        fn sample(&self, board: &mut Board<'_>, i: u64) -> Record {
            self.turn(board, i, 0)
        }

        /// The same with one count more, or less, in turn.
        fn rough_sample(&self, board: &mut Board<'_>, i: u64) -> Record {
            self.turn(board, i, if i.is_multiple_of(2) { 1 } else { -1 })
        }

        fn turn(&self, board: &mut Board<'_>, i: u64, more: i32) -> Record {
            self.servos.advance([100, -50], [8 + more, -4 - more]);
            now(board.sample(SAMPLE_PERIOD_US * i))
        }
    }

    fn count(speed: f32) -> f32 {
        (speed / (core::f32::consts::TAU / 4096.0) * 0.005).round()
    }

    /// Chips with 10 mV at 12 V: 1.2 W each.
    #[test]
    fn a_record_has_what_the_sensors_say() {
        let robot = Robot::new();
        let mut board = robot.board();
        robot.chips.chips.borrow_mut()[1].shunt_10uv = 2000;
        board.set_power_factors([1.0, 1.0, 1.0, 1.5]);
        let records: Vec<Record> = (0..10).map(|i| robot.sample(&mut board, i)).collect();
        let record = records[9];
        assert_eq!((record.sequence, record.time_us), (9, 45_000));
        assert_eq!(record.wheel_speed.map(|speeds| speeds.map(count)), Some([8.0, -4.0]));
        let powers = record.rail_power.map(|power| (power.unwrap() * 100.0).round());
        assert_eq!(powers, [120.0, 240.0, 120.0, 180.0]);
        assert_eq!(record.battery_voltage.map(f32::round), Some(12.0));
        assert_eq!(record.health, [Health::Ok; RAIL_COUNT]);
        // It says so: nothing is estimated without coefficients.
        assert_eq!((record.has_coefficients, record.is_estimated), (false, false));
        assert_eq!((record.mass, record.predicted_power), (None, None));
        let snapshot = board.snapshot();
        assert_eq!((snapshot.samples, snapshot.time_us), (10, 45_000));
        assert_eq!(snapshot.estimate, EstimateSnapshot::UNKNOWN);
        assert_eq!(snapshot.wheels.map(|wheel| wheel.position), [Some(80), Some(-40)]);
        assert_eq!(snapshot.wheels.map(|wheel| wheel.speed.map(count)), [Some(8.0), Some(-4.0)]);
        assert_eq!(snapshot.wheels.map(|wheel| wheel.acceleration), [None; WHEELS]);
        let rail = snapshot.rails[1];
        assert_eq!(rail.voltage.map(f32::round), Some(12.0));
        assert_eq!(rail.current.map(|current| (current * 1000.0).round()), Some(200.0));
        // Nine steps of 5 ms.
        assert!((rail.energy - 9.0 * 0.005 * 2.4).abs() < 1e-6, "{}", rail.energy);
        assert_eq!((rail.power_factor, snapshot.rails[3].power_factor), (1.0, 1.5));
    }

    /// The filter at 2 Hz of 200 settles within 200 samples: until then speeds are as measured, and
    /// accelerations unknown.
    #[test]
    fn with_coefficients_it_estimates() {
        let robot = Robot::new();
        let mut board = robot.board();
        robot.chips.chips.borrow_mut()[1].shunt_10uv = 1390;
        board.set_coefficients(Some(&coefficients(signed()))).unwrap();
        let mut records: Vec<Record> = (0..200).map(|i| robot.rough_sample(&mut board, i)).collect();
        let unsettled = board.snapshot();
        assert_eq!(unsettled.wheels.map(|wheel| wheel.speed.map(count)), [Some(7.0), Some(-3.0)]);
        assert_eq!(unsettled.wheels.map(|wheel| wheel.acceleration), [None; WHEELS]);
        assert_eq!(unsettled.estimate.measured_power, None);
        records.extend((200..6000).map(|i| robot.rough_sample(&mut board, i)));
        assert!(records.iter().all(|record| record.has_coefficients));
        // The servos were found with the third sample.
        let first = records.iter().position(|record| record.is_estimated);
        assert_eq!(first, Some(2));
        assert!(records[2..].iter().all(|record| record.is_estimated));
        let record = records[5999];
        assert!(record.predicted_power.is_some() && record.mass.is_some(), "{record:?}");
        assert!((record.mass.unwrap().mass - 3.0).abs() < 0.2, "{record:?}");
        let snapshot = board.snapshot();
        assert_eq!(snapshot.estimate.mass.known(), record.mass);
        assert_eq!(snapshot.estimate.predicted_power, record.predicted_power);
        assert_eq!(snapshot.estimate.model, 2);
        // 1.668 W at the rail, 1.25 W of it static: as much as some 3 kg draw at these speeds.
        assert!((snapshot.estimate.measured_power.unwrap() - 0.418).abs() < 1e-3);
        assert!((snapshot.estimate.measured_energy.unwrap() - 0.418 * 5997.0 * 0.005).abs() < 1e-2);
        let count = |counts: fn(&&Record) -> bool| records.iter().filter(counts).count() as u32;
        let counted = Counted {
            measured: count(|record| record.is_estimated),
            predicted: count(|record| record.predicted_power.is_some()),
        };
        assert_eq!((counted.measured, snapshot.estimate.counted), (5998, counted));
        // Behind the filter 7 and 9 counts are 8, 2.4544 rad/s.
        assert!((snapshot.wheels[0].speed.unwrap() - 2.4544).abs() < 1e-3);
        assert!(snapshot.wheels[0].acceleration.unwrap().abs() < 1e-2);
    }

    /// Each costs itself, and the estimator what it needs of it.
    #[test]
    fn what_fails_costs_its_own_part() {
        let robot = Robot::new();
        let mut board = robot.board();
        board.set_coefficients(Some(&coefficients(signed()))).unwrap();
        (0..10).for_each(|i| _ = robot.sample(&mut board, i));

        robot.chips.chips.borrow_mut()[2].is_present = false;
        let record = robot.sample(&mut board, 10);
        assert_eq!(record.rail_power.map(|power| power.is_some()), [true, true, false, true]);
        assert!(record.is_estimated && record.battery_voltage.is_some());

        robot.chips.chips.borrow_mut()[1].is_present = false;
        let record = robot.sample(&mut board, 11);
        assert!(!record.is_estimated && record.wheel_speed.is_some() && record.has_coefficients);
        robot.chips.chips.borrow_mut()[1].is_present = true;

        robot.servos.servos.borrow_mut()[0].is_present = false;
        let record = robot.sample(&mut board, 12);
        assert!(!record.is_estimated && record.wheel_speed.is_none() && record.rail_power[1].is_some());
        assert_eq!(board.snapshot().wheels.map(|wheel| wheel.speed.is_some()), [false, true]);
        (13..20).for_each(|i| _ = robot.sample(&mut board, i));
        let snapshot = board.snapshot();
        assert_eq!(snapshot.wheels.map(|wheel| wheel.health), [WheelHealth::Absent, WheelHealth::Ok]);
        assert_eq!(snapshot.wheels.map(|wheel| wheel.position.is_some()), [false, true]);
        assert_eq!(snapshot.servo_bus.timeouts, 3);
        assert_eq!(snapshot.rails[2].health, Health::Absent);
        assert_eq!((snapshot.rails[2].power, snapshot.rails[2].voltage), (None, None));
        assert!(snapshot.rails[1].power.is_some());
        assert_eq!(snapshot.estimate.mass, MassEstimate::Unknown(Unknown::NoSamples));
    }

    /// What is not new is not in the record; the control table shows the last of a sensor that can
    /// be believed.
    #[test]
    fn a_slow_sensor_shows_its_last_reading() {
        let robot = Robot::new();
        let mut board = robot.board();
        robot.sample(&mut board, 0);
        robot.chips.chips.borrow_mut()[0].has_converted = false;
        let record = robot.sample(&mut board, 1);
        assert_eq!((record.rail_power[0], record.battery_voltage), (None, None));
        assert_eq!(board.snapshot().rails[0].voltage.map(f32::round), Some(12.0));
        (2..4).for_each(|i| _ = robot.sample(&mut board, i));
        let stale = board.snapshot().rails[0];
        assert_eq!((stale.health, stale.voltage), (Health::Stale, None));
    }

    #[test]
    fn stands_still_after_a_second_without_motion() {
        let robot = Robot::new();
        let mut board = robot.board();
        (0..20).for_each(|i| assert!(!robot.sample(&mut board, i).is_standing));
        robot.servos.advance([0, 0], [0, 0]);
        let stands = (20..400).find(|i| now(board.sample(SAMPLE_PERIOD_US * i)).is_standing);
        assert_eq!(stands, Some(220));
        assert!(board.snapshot().is_standing);
        assert!(!robot.sample(&mut board, 400).is_standing);
    }
}
