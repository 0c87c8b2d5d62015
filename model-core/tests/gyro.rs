//! Laws of true slip, and what it is in the conditioner, the torque model and the estimator.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "tests")]

mod common;

use common::{coefficients, range, servo};
use model_core::coefficients::{Coefficients, Robot};
use model_core::conditioning::Conditioning;
use model_core::effects::live::Outside;
use model_core::estimator::{Conditioned, Conditioner, Estimator, Sample, Timing, Unfit};
use model_core::gyro::{Gyro, GyroConditioner, WithGyro};
use model_core::kinematics::Kinematics;
use model_core::model::Model;
use model_core::motion::Motion;
use model_core::payload::schedule::Schedule;
use model_core::payload::window::Window;
use model_core::slip::SlipMemory;
use model_core::torque::{Drive, TorqueModel};

const PERIOD: f64 = 0.005;
/// Burger: track over wheel radius, rad/s of wheel difference per rad/s turned.
const LEVER: f64 = 0.16 / 0.033;
const MEMORY: SlipMemory<f64> = SlipMemory { half_slip: 0.13, relaxation: 1.8, rest: 0.0 };

fn robot(true_slip: f64, delay: f64) -> Robot<f64, 2> {
    let conditioning = Conditioning { slip: MEMORY, delay, true_slip };
    Robot { conditioning, ..coefficients().robot }
}

/// Curves both ways, fast and slow; the difference of the wheels in rad/s.
fn difference(time: f64) -> f64 {
    1.5 * (1.3 * time).sin() * (0.2 * time).cos()
}

fn sample(time: f64) -> Sample<f64, 2> {
    let (speed, half) = (3.0 + (2.0 * time).sin(), difference(time) / 2.0);
    Sample { wheel_speed: [speed - half, speed + half], wheel_acceleration: None, power: 1.0 + time.cos() }
}

type Row = Option<Conditioned<f64, 2>>;

/// Every row of a drive: the plain conditioner's, and that with a gyro of which `turn_rate` gives
/// the reading.
fn both(robot: &Robot<f64, 2>, turn_rate: impl Fn(f64) -> f64) -> Vec<(Row, Row)> {
    let mut plain = Conditioner::new(robot, PERIOD).unwrap();
    let mut gyro = GyroConditioner::new(robot, PERIOD).unwrap();
    let row = |i: u32| {
        let time = f64::from(i) * PERIOD;
        let elapsed = match i {
            0 => 0.0,
            // A gap: everything starts anew.
            1500 => 3.0,
            _ => PERIOD,
        };
        (plain.push(&sample(time), elapsed), gyro.push(&sample(time), turn_rate(time), elapsed))
    };
    (0..3000).map(row).collect()
}

/// q = 0: bit by bit what it was, and no gyro is asked for.
#[test]
fn without_a_share_it_is_the_plain_model() {
    assert_eq!(Gyro::new(&robot(0.0, 0.0), 0.0, PERIOD), Ok(None));
    for (plain, gyro) in both(&robot(0.0, 0.1), |_| f64::NAN) {
        assert_eq!(plain, gyro);
    }
}

/// A gyro that says what the wheels say adds nothing, whatever is late: it passes the delay, the
/// filter and the gaps that they pass. With a tenth more of slip the share rises by q times a tenth
/// of the difference after the filter.
#[test]
fn only_what_slips_adds() {
    for delay in [0.0, 0.1037, -0.1037] {
        let robot = robot(0.4, delay);
        let sides = *robot.mass_matrix.sides().unwrap();
        for slips in [0.0, 0.1, 1.0] {
            let mut most = 0.0_f64;
            for (plain, gyro) in both(&robot, |time| (1.0 - slips) * difference(time) / LEVER) {
                let (plain, gyro) = (plain.unwrap(), gyro.unwrap());
                assert_eq!((plain.power, plain.settled), (gyro.power, gyro.settled));
                let more =
                    0.4 * slips * sides.rims(&plain.motion.wheels.map(|wheel| wheel.speed), 0.0).difference;
                for (one, other) in gyro.motion.wheels.iter().zip(&plain.motion.wheels) {
                    let expected = other.scrub + more * one.side * one.direction;
                    assert!((one.scrub - expected).abs() < 1e-9, "{delay} {slips} {one:?} {expected}");
                }
                most = most.max(more.abs());
            }
            assert!(slips == 0.0 || most > 0.3 * slips, "{most}");
        }
    }
}

/// By hand: on the spot at ±2 rad/s on ice, nothing turns. s = 4 / √(4² + r²), S = 4 rad/s, q = 0.3
/// s/rad: σ = ±2.2, all but r's share. Wheels at rest have none.
#[test]
fn wheels_that_spin_on_ice() {
    let robot = robot(0.3, 0.0);
    let mut conditioner = GyroConditioner::new(&robot, PERIOD).unwrap();
    let spin = |speed: f64| Sample { wheel_speed: [-speed, speed], wheel_acceleration: None, power: 5.0 };
    let mut shares = |speed| {
        let mut last = None;
        for _ in 0..1000 {
            last = conditioner.push(&spin(speed), 0.0, PERIOD);
        }
        last.unwrap().motion.wheels.map(|wheel| wheel.scrub)
    };
    let [left, right] = shares(2.0);
    let expected = 1.2 + 4.0_f64 / 4.0_f64.hypot(robot.dead_band);
    assert!((left + expected).abs() < 1e-9 && (right - expected).abs() < 1e-9, "{left} {right}");
    // Half the dead band.
    let still = shares(0.01);
    assert_eq!(still, [0.0; 2]);
}

/// The torque stays linear in the mass: the polynomial that windows sum up is the model at every
/// mass.
#[test]
fn the_power_stays_a_quadratic_of_the_mass() {
    let torque = TorqueModel { scrub: 0.2, ..servo() };
    let model = Model::Signed { torque, drive: Drive::Regenerative };
    for (_, gyro) in both(&robot(0.4, 0.0), |time| 0.5 * difference(time) / LEVER) {
        let motion = gyro.unwrap().motion;
        let response = model.response(&motion, &range());
        for mass in [1.0, 2.2, 6.0] {
            let (by_hand, polynomial) =
                (model.power(&motion, mass).unwrap(), response.polynomial.at(mass - range().middle()));
            assert!((by_hand - polynomial).abs() < 1e-9 * by_hand.abs().max(1.0), "{by_hand} {polynomial}");
        }
    }
}

/// A row without a turn rate is as one without a power: nothing is known of it, and it leaves no
/// trace but its time.
#[test]
fn rows_without_a_turn_rate_are_left_out() {
    let robot = robot(0.4, 0.05);
    let (mut whole, mut holed) =
        (GyroConditioner::new(&robot, PERIOD).unwrap(), GyroConditioner::new(&robot, PERIOD).unwrap());
    for i in 0..1000_u32 {
        let time = f64::from(i) * PERIOD;
        let elapsed = if i == 0 { 0.0 } else { PERIOD };
        let rate = if i == 700 { f64::NAN } else { 0.5 * difference(time) / LEVER };
        let broken = Sample { power: if i == 700 { f64::NAN } else { sample(time).power }, ..sample(time) };
        let (expected, seen) = (
            whole.push(&broken, 0.5 * difference(time) / LEVER, elapsed),
            holed.push(&sample(time), rate, elapsed),
        );
        assert_eq!(expected, seen, "{i}");
        assert_eq!(seen.is_none(), i == 700);
    }
}

/// The estimator with a gyro beside no effects has the same rows as the conditioner of logs, and
/// finds the mass that made the power; without it the slip is taken for payload. The filter is fast
/// beside the signals, so that it passes their powers as it passes them.
#[test]
fn the_estimator_sees_the_same() {
    let conditioning = Conditioning { true_slip: 0.4, ..Conditioning::PLAIN };
    let robot = Robot { conditioning, cutoff_hz: 20.0, ..coefficients().robot };
    let torque = TorqueModel { scrub: 0.02, ..servo() };
    let drive = Drive::Regenerative;
    let coefficients = Coefficients { robot, model: Model::Signed { torque, drive }, ..coefficients() };
    let schedule = Schedule::Moving { window: 10 };
    let timing = Timing { period_s: PERIOD, bucket_s: 1.0, schedule, detect_changes: false };
    let window = coefficients.window(PERIOD);
    let estimator = || Estimator::<f64, Window<f64>, 2, 32>::new(&coefficients, window, &timing).unwrap();
    let (mut with, mut without) = (estimator(), estimator());
    let mut gyro = Gyro::new(&robot, 0.0, PERIOD).unwrap().unwrap();
    let mut conditioner = GyroConditioner::new(&robot, PERIOD).unwrap();
    let sides = robot.mass_matrix.sides().unwrap();
    let (mut mass, mut blind) = (None, None);
    for i in 0..6000_u32 {
        let time = f64::from(i) * PERIOD;
        let elapsed = if i == 0 { 0.0 } else { PERIOD };
        let speed = sample(time).wheel_speed;
        let (before, after) = (sample(time - 1e-3).wheel_speed, sample(time + 1e-3).wheel_speed);
        let acceleration = [0, 1].map(|wheel| (after[wheel] - before[wheel]) / 2e-3);
        let scrub = sides.scrub(0.4 * 0.7 * difference(time));
        let motion = Motion::with_scrub(&speed, &acceleration, &scrub, &robot.mass_matrix, robot.dead_band);
        let measured = Sample { power: coefficients.model.power(&motion, 4.0).unwrap(), ..sample(time) };
        let rate = 0.3 * difference(time) / LEVER;
        let seen = conditioner.push(&measured, rate, elapsed);
        let mut nothing = ();
        let mut beside = WithGyro::new(&mut nothing, &mut gyro, rate);
        let estimate = with.push_with(&mut beside, &measured, &Outside::UNKNOWN, elapsed);
        assert_eq!(estimate.conditioned, seen);
        mass = estimate.mass.best();
        blind = without.push(&measured, elapsed).mass.best();
    }
    let (mass, blind) = (mass.unwrap(), blind.unwrap());
    assert!((mass - 4.0).abs() < 1e-4, "{mass}");
    assert!((blind - 4.0).abs() > 0.05, "{blind}");
}

/// No image holds it, no robot without two sides has it, and another precision keeps it.
#[test]
fn who_can_have_it() {
    let slipping = Coefficients { robot: robot(0.4, 0.0), ..coefficients() };
    assert!(slipping.encode().is_none());
    assert!(Coefficients { robot: robot(0.0, 0.0), ..slipping }.encode().is_some());
    assert_eq!(slipping.convert::<f32>().unwrap().robot.conditioning.true_slip, 0.4_f32);
    let omni = Kinematics::<f64, 3>::omni(0.05, 0.2).unwrap();
    let Robot { name, gyration_radius, dead_band, cutoff_hz, conditioning, range, static_power, .. } =
        slipping.robot;
    let mass_matrix = omni.mass_matrix(gyration_radius).unwrap();
    let three = Robot {
        name,
        kinematics: omni,
        gyration_radius,
        mass_matrix,
        dead_band,
        cutoff_hz,
        conditioning,
        range,
        static_power,
    };
    assert_eq!(GyroConditioner::new(&three, PERIOD).err(), Some(Unfit::Sides));
    for unsound in [-0.1, f64::NAN, f64::INFINITY] {
        assert!(!Conditioning { true_slip: unsound, ..Conditioning::PLAIN }.is_sound());
    }
}
