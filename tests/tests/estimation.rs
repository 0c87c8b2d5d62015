//! The board's estimates in single precision against the same estimator in double, fed as the host
//! replays a recorded log.
#![cfg_attr(target_os = "none", no_std, no_main)]

use firmware::estimation::Estimation;
use firmware::parameters::{SAMPLE_PERIOD_US, WINDOW_S};
use model_core::coefficients::{Coefficients, Name, Robot};
use model_core::conditioning::Conditioning;
use model_core::effects::Columns;
use model_core::estimator::{Estimator, Sample, Timing};
use model_core::kinematics::Kinematics;
use model_core::model::{MassRange, Model};
use model_core::motion::Motion;
use model_core::payload::schedule::Schedule;
use model_core::payload::{MassEstimate, Noise};
use model_core::torque::{Drive, TorqueModel};
use on_target_tests::{Failed, Outcome, close, ensure, tests};

#[allow(dead_code, clippy::excessive_precision, clippy::approx_constant)]
mod power {
    include!("../reference/power.rs");
}

tests!(equals_double_precision, says_nothing_without_coefficients);

const STATIC_W: f32 = 1.25;
const MASS: f64 = 3.0;
const SECONDS: u64 = 40;

fn coefficients() -> Option<Coefficients<f32, 2>> {
    let kinematics = Kinematics::differential(power::WHEEL_RADIUS, power::TRACK).ok()?;
    Some(Coefficients {
        robot: Robot {
            name: Name::new("reference"),
            kinematics,
            gyration_radius: power::GYRATION_RADIUS,
            mass_matrix: kinematics.mass_matrix(power::GYRATION_RADIUS).ok()?,
            dead_band: power::DEAD_BAND,
            cutoff_hz: 2.0,
            conditioning: Conditioning::PLAIN,
            range: MassRange::new(1.0, 6.0)?,
            static_power: STATIC_W,
        },
        model: Model::Signed { torque: TorqueModel::from_array(power::TORQUE), drive: Drive::Dissipative },
        noise: Noise { density: 5e-5, model_std: 0.01, tail: 1.0, residual_std: 0.0 },
        columns: Columns::NONE,
        identifies_mass: true,
        ground_adapts: false,
    })
}

/// Speed and acceleration of a wheel that goes back and forth between ±`peak` rad/s at ±`rate`
/// rad/s².
fn zigzag(t: f64, peak: f64, rate: f64) -> (f64, f64) {
    let length = 4.0 * peak / rate;
    let phase = t % length;
    if phase < length / 2.0 { (rate * phase - peak, rate) } else { (3.0 * peak - rate * phase, -rate) }
}

/// What the sensors give at sample `i`: time in µs, speeds in rad/s, the motors' power in W with
/// 0.1 W of scatter; `None` where a reading is missing.
fn measured(model: &Model<f64>, robot: &Robot<f64, 2>, i: u64) -> (u64, Option<[f32; 2]>, Option<f32>) {
    // A hash for jitter and scatter.
    let hash = (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64 / f64::from(1 << 24);
    let gap = if i > 3200 { 300_000 } else { 0 };
    let time_us = SAMPLE_PERIOD_US * i + (hash * 300.0) as u64 + gap;
    let t = time_us as f64 * 1e-6;
    let ((left, left_rate), (right, right_rate)) = (zigzag(t, 4.0, 5.0), zigzag(t, 5.0, 3.0));
    let motion = Motion::new(&[left, right], &[left_rate, right_rate], &robot.mass_matrix, robot.dead_band);
    let power = model.power(&motion, MASS).unwrap_or(f64::NAN) + f64::from(STATIC_W) + 0.35 * (hash - 0.5);
    let speed = (i % 331 != 7).then_some([left as f32, right as f32]);
    (time_us, speed, (i % 97 != 13).then_some(power as f32))
}

/// Five times the largest difference found; tests/filter.rs and firmware's own tests say what it
/// could be at worst.
const MASS_TOLERANCE_KG: f64 = 5e-4;
const POWER_TOLERANCE_W: f64 = 1e-3;

fn equals_double_precision() -> Outcome {
    let single = coefficients().ok_or(Failed)?;
    let double: Coefficients<f64, 2> = single.convert().ok_or(Failed)?;
    let mut board = Estimation::default();
    board.set_coefficients(Some(&single)).map_err(|_| Failed)?;
    let timing = Timing {
        period_s: 0.005,
        bucket_s: 1.0,
        schedule: Schedule::Moving { window: WINDOW_S },
        detect_changes: true,
    };
    let method = double.window(0.005);
    let mut host = Estimator::<f64, _, 2, 64>::new(&double, method, &timing).map_err(|_| Failed)?;
    let mut last_us = None;
    let mut known = 0;
    for i in 0..200 * SECONDS {
        let (time_us, speed, power) = measured(&double.model, &double.robot, i);
        let found = board.sample(speed, power, time_us);
        let (Some(speed), Some(power)) = (speed, power) else {
            ensure(!found.taken, format_args!("sample {i} is not whole"))?;
            continue;
        };
        let elapsed = (time_us - last_us.unwrap_or(time_us)) as f64 * 1e-6;
        last_us = Some(time_us);
        let power = f64::from(power) - double.robot.static_power;
        let sample = Sample { wheel_speed: speed.map(f64::from), wheel_acceleration: None, power };
        let expected = host.push(&sample, elapsed);
        match (found.mass, expected.mass) {
            (MassEstimate::Known(found), MassEstimate::Known(expected)) => {
                known += 1;
                close(format_args!("mass at {i}"), found.mass, expected.mass, MASS_TOLERANCE_KG)?;
                close(format_args!("low at {i}"), found.low, expected.low, MASS_TOLERANCE_KG)?;
                close(format_args!("high at {i}"), found.high, expected.high, MASS_TOLERANCE_KG)?;
            }
            (MassEstimate::Beyond(found), MassEstimate::Beyond(expected))
                if found.place == expected.place => {}
            (MassEstimate::Unknown(found), MassEstimate::Unknown(expected)) if found == expected => {}
            (found, expected) => return ensure(false, format_args!("{found:?} for {expected:?} at {i}")),
        }
        match (found.predicted_power, expected.power) {
            (Some(found), Some(expected)) => {
                close(format_args!("power at {i}"), found, expected, POWER_TOLERANCE_W)?;
            }
            (None, None) => {}
            (found, expected) => return ensure(false, format_args!("{found:?} for {expected:?} at {i}")),
        }
    }
    ensure(known > 150 * SECONDS, format_args!("known for {known} samples only"))?;
    let mass = host.over_latest(WINDOW_S).and_then(|payload| payload.known()).ok_or(Failed)?;
    close(format_args!("mass"), mass.mass, MASS, 0.1)?;
    let (measured, predicted) = board.energy().ok_or(Failed)?;
    let (expected_measured, expected_predicted) = host.energy();
    close(format_args!("energy"), measured, expected_measured, 1e-5 * expected_measured)?;
    close(format_args!("predicted energy"), predicted, expected_predicted, 1e-5 * expected_predicted)
}

fn says_nothing_without_coefficients() -> Outcome {
    let mut board = Estimation::default();
    for i in 0..1000 {
        let found = board.sample(Some([3.0, 2.0]), Some(2.0), 5_000 * i);
        ensure(!found.taken && found.mass.known().is_none(), format_args!("{found:?}"))?;
    }
    ensure(board.energy().is_none(), format_args!("{:?}", board.energy()))
}
