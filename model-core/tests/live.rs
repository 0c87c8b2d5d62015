//! Effects along with the estimator: what coefficients hold is taken off the samples that have it.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{Rng, burger, coefficients, servo};
use model_core::coefficients::{Coefficients, Robot};
use model_core::conditioning::Conditioning;
use model_core::effects::live::{Live, Outside};
use model_core::effects::{Cause, Column, Columns, Effect, Extended, Layout, Scene, Side, Term};
use model_core::eq18::Gate;
use model_core::estimator::{Estimator, Sample, Timing, Unfit};
use model_core::model::Model;
use model_core::motion::Motion;
use model_core::payload::Noise;
use model_core::payload::schedule::Schedule;
use model_core::payload::window::Window;
use model_core::slip::SlipMemory;
use model_core::torque::Drive;

const PERIOD: f64 = 0.01;
const SIGMA: f64 = 0.02;
const SECONDS: usize = 60;
const MASS: f64 = 3.3;

type Plain = Estimator<f64, Window<f64>, 2, 32>;

fn pipeline(robot: &Coefficients<f64, 2>) -> (Plain, Live<f64, 2>) {
    (Plain::new(robot, method(), &TIMING).unwrap(), Live::new(robot, PERIOD).unwrap())
}

fn robot(columns: &[Column<f64>]) -> Coefficients<f64, 2> {
    let base = coefficients();
    Coefficients {
        // Little delay, so that P(filtered speed) and filtered P(speed) are the same to a mW.
        robot: Robot { cutoff_hz: 20.0, ..base.robot },
        noise: Noise { density: SIGMA * SIGMA * PERIOD, model_std: 0.0, tail: 1.0, residual_std: 0.0 },
        columns: Columns::new(columns, 2).unwrap(),
        ..base
    }
}

const TIMING: Timing = Timing {
    period_s: PERIOD,
    bucket_s: 1.0,
    schedule: Schedule::Moving { window: 25 },
    detect_changes: true,
};

fn method() -> Window<f64> {
    robot(&[]).window(PERIOD)
}

/// Wheel speeds and accelerations: forward and back, rests, turns both ways.
fn wheels(t: f64) -> ([f64; 2], [f64; 2]) {
    let envelope = (0.35 * t).sin();
    let slope = 0.35 * (0.35 * t).cos();
    let wave = |rate: f64| (1.0 + 0.3 * (rate * t).sin(), 0.3 * rate * (rate * t).cos());
    let wheel = |(shape, shape_rate): (f64, f64)| {
        (5.0 * envelope * shape, 5.0 * (slope * shape + envelope * shape_rate))
    };
    let (left, right) = (wheel(wave(0.9)), wheel(wave(0.7)));
    ([left.0, right.0], [left.1, right.1])
}

/// What the model with one effect measures at each sample, by [`Extended::power`] at the true mass:
/// the speeds as its encoders show them, and the power as late as its sensor is.
fn drive(column: Option<Column<f64>>) -> Vec<(Sample<f64, 2>, Outside<f64, 2>)> {
    let (kinematics, matrix) = burger();
    let effect = column.and_then(|column| {
        let term = match column.cause {
            Cause::Term(term) => term,
            Cause::Hot | Cause::Heat(_) | Cause::Warming(_) | Cause::Temperature(_) => Term::Winding,
            Cause::Delay | Cause::Scale(_) | Cause::HalfSlip => return None,
        };
        Some(Effect { term, coefficient: column.coefficient })
    });
    let effects: Vec<Effect<f64>> = effect.into_iter().collect();
    let layout = Layout::new(&kinematics);
    let extended =
        Extended { torque: servo(), drive: Drive::Dissipative, layout, dead_band: 0.02, effects: &effects };
    let (mut heat, mut heading, mut still) = ([0.0; 2], 0.0_f64, f64::INFINITY);
    let mut truth = |t: f64, advance: bool| {
        let (speed, acceleration) = wheels(t);
        let motion = Motion::new(&speed, &acceleration, &matrix, 0.02);
        let temperature = [25.0 + 0.4 * t, 22.0];
        if advance {
            heading += PERIOD * kinematics.twist(&motion.wheels.map(|wheel| wheel.speed)).omega;
            still = if motion.is_moving() { 0.0 } else { still + PERIOD };
            for (heat, wheel) in heat.iter_mut().zip(&motion.wheels) {
                if let Some(Column { cause: Cause::Heat(time), .. }) = column {
                    *heat +=
                        PERIOD / time * (servo().winding_loss * servo().torque(wheel, MASS).powi(2) - *heat);
                }
            }
        }
        let warmth = match column.map(|column| column.cause) {
            Some(Cause::Heat(_)) => heat,
            Some(Cause::Warming(time)) => [-(-t / time).exp_m1(); 2],
            Some(Cause::Temperature(cold)) => temperature.map(|warm| warm - cold),
            _ => [1.0; 2],
        };
        let (pitch, driver) = (0.05 * (0.1 * t).sin(), 50.0 + 20.0 * (0.2 * t).sin());
        let scene = Scene {
            mass: MASS,
            time: t,
            pitch,
            heading: [heading.cos(), heading.sin()],
            warmth,
            still,
            driver,
        };
        (extended.power(&motion, &scene), Outside { pitch, temperature, driver })
    };
    let mut rng = Rng::new(7);
    (0..SECONDS * 100)
        .map(|i| {
            let t = PERIOD * i as f64;
            let (mut power, outside) = truth(t, true);
            let mut wheel_speed = wheels(t).0;
            match column {
                Some(Column { cause: Cause::Delay, coefficient }) if coefficient > 0.0 => {
                    power = truth(t - coefficient, false).0;
                }
                Some(Column { cause: Cause::Delay, coefficient }) => wheel_speed = wheels(t + coefficient).0,
                // The model turns readings into speeds by the factor.
                Some(Column { cause: Cause::Scale(Side::Left), coefficient }) => {
                    wheel_speed[0] /= 1.0 + coefficient;
                }
                _ => {}
            }
            let power = power + SIGMA * rng.normal();
            (Sample { wheel_speed, wheel_acceleration: None, power }, outside)
        })
        .collect()
}

/// Error of the last mass, kg, and RMS of measured less predicted power over the last half, W.
fn errors(known: &[Column<f64>], samples: &[(Sample<f64, 2>, Outside<f64, 2>)]) -> (f64, f64) {
    let (mut pipeline, mut live) = pipeline(&robot(known));
    let (mut error, mut squares, mut count) = (f64::INFINITY, 0.0, 0.0);
    for (i, (sample, outside)) in samples.iter().enumerate() {
        let out = pipeline.push_with(&mut live, sample, outside, if i == 0 { 0.0 } else { PERIOD });
        if let Some(mass) = out.mass.known() {
            error = (mass.mass - MASS).abs();
        }
        if i > samples.len() / 2
            && let (Some(power), Some(now)) = (out.power, out.conditioned)
        {
            squares += (power - now.power).powi(2);
            count += 1.0;
        }
    }
    assert!(count > 0.0, "the mass was never known");
    (error, (squares / count).sqrt())
}

/// With the effect in the coefficients mass and power are as without any; with coefficients that
/// lack it they are not.
#[test]
fn known_effects_are_taken_off() {
    let (clean_kg, clean_w) = errors(&[], &drive(None));
    assert!(clean_kg < 0.05 && clean_w < 0.02, "{clean_kg} {clean_w}");
    let cases = [
        (Cause::Term(Term::GradeByPitch), 1.3),
        (Cause::Term(Term::GradeAhead), 0.02),
        (Cause::Term(Term::GradeAlong([1.0, 0.0])), 0.05),
        (Cause::Term(Term::GradeAlong([0.0, 1.0])), 0.05),
        (Cause::Hot, 0.5),
        (Cause::Heat(20.0), 3.0),
        (Cause::Warming(20.0), 0.5),
        (Cause::Temperature(20.0), 0.02),
        (Cause::Term(Term::Windage), 0.002),
        (Cause::Term(Term::Stribeck(1.0)), 0.05),
        (Cause::Term(Term::Viscous), 0.005),
        (Cause::Term(Term::WarmUp(60.0)), 0.01),
        (Cause::Term(Term::Rolling), 0.005),
        (Cause::Term(Term::RollingFrom(20.0)), 0.005),
        (Cause::Term(Term::Offset), 0.01),
        (Cause::Term(Term::Drag(1)), 0.02),
        (Cause::Term(Term::Scrub), 0.03),
        (Cause::Term(Term::ScrubPerKg), 0.01),
        (Cause::Term(Term::Sliding(0.5)), 0.01),
        (Cause::Term(Term::OffCentre(1.0)), 0.05),
        (Cause::Term(Term::GearLoad), 3.0),
        (Cause::Term(Term::Sag(0.0)), 0.1),
        (Cause::Term(Term::Gain(0.0)), 0.1),
        (Cause::Term(Term::Constant), 0.1),
        (Cause::Term(Term::StepAt(20.0)), 0.1),
        (Cause::Term(Term::WithMotion(f64::INFINITY)), 0.1),
        (Cause::Term(Term::Driver), 0.002),
        (Cause::Delay, 0.1037),
        (Cause::Delay, -0.1037),
        (Cause::Scale(Side::Left), 0.1),
    ];
    for (cause, coefficient) in cases {
        let column = Column { cause, coefficient };
        let samples = drive(Some(column));
        let (known_kg, known_w) = errors(&[column], &samples);
        let (lacking_kg, lacking_w) = errors(&[], &samples);
        println!("{cause:?}: {known_kg:.3} of {lacking_kg:.3} kg, {known_w:.4} of {lacking_w:.4} W");
        assert!(known_kg < 0.07 && known_w < 1.3 * clean_w, "{cause:?}: {known_kg} kg, {known_w} W");
        assert!(
            lacking_kg > 2.0 * known_kg || lacking_w > 1.5 * known_w,
            "{cause:?}: {lacking_kg} {lacking_w}"
        );
    }
}

/// Without effects the general way gives what the plain one gives, to the last bits that a sum's
/// order leaves.
#[test]
fn without_effects_both_ways_are_one() {
    let robot = robot(&[]);
    let mut plain = Plain::new(&robot, method(), &TIMING).unwrap();
    let (mut extending, mut live) = pipeline(&robot);
    for (sample, _) in drive(None) {
        let (one, other) =
            (plain.push(&sample, PERIOD), extending.push_with(&mut live, &sample, &Outside::UNKNOWN, PERIOD));
        assert_eq!(one.conditioned, other.conditioned);
        assert_eq!(one.power.is_some(), other.power.is_some());
        if let (Some(one), Some(other)) = (one.power, other.power) {
            assert!((one - other).abs() < 1e-9, "{one} {other}");
        }
        if let (Some(one), Some(other)) = (one.mass.known(), other.mass.known()) {
            assert!((one.mass - other.mass).abs() < 1e-9 && (one.high - other.high).abs() < 1e-9);
        }
    }
    let ((one, _), (other, _)) = (plain.energy(), extending.energy());
    assert_eq!(one, other);
}

/// A run that follows another begins at time 0, cold.
#[test]
fn the_next_run_begins_anew() {
    let column = Column { cause: Cause::Term(Term::StepAt(20.0)), coefficient: 0.5 };
    let samples = drive(Some(column));
    let (mut pipeline, mut live) = pipeline(&robot(&[column]));
    for _ in 0..2 {
        pipeline.payload_changed();
        live.restart();
        let mut worst = 0.0_f64;
        for (i, (sample, outside)) in samples.iter().enumerate() {
            let out = pipeline.push_with(&mut live, sample, outside, if i == 0 { f64::MAX } else { PERIOD });
            let step = (1990..2020).contains(&i);
            if let (Some(power), Some(now)) = (out.power, out.conditioned)
                && !step
            {
                worst = worst.max((power - now.power).abs());
            }
        }
        assert!(worst < 0.25, "{worst}");
    }
}

#[test]
fn what_cannot_run_is_refused() {
    let live = |robot: &Coefficients<f64, 2>| Live::new(robot, PERIOD).err();
    let refused = |robot: &Coefficients<f64, 2>| live(robot).or(Plain::new(robot, method(), &TIMING).err());
    let delay = |seconds| robot(&[Column { cause: Cause::Delay, coefficient: seconds }]);
    assert_eq!(refused(&delay(1.01)), None);
    assert_eq!(refused(&delay(-1.02)), Some(Unfit::Delay));
    let eq18 = Coefficients { model: Model::Eq18 { gate: Gate::Corrected, beta: [0.1; 15] }, ..robot(&[]) };
    assert_eq!(refused(&eq18), Some(Unfit::Model));
    let base = robot(&[]);
    let fast = Coefficients { robot: Robot { cutoff_hz: 60.0, ..base.robot }, ..base };
    assert!(matches!(refused(&fast), Some(Unfit::Cutoff(_))));
}

/// A column that makes the half slip twice as great is a robot that was fitted with twice as much.
#[test]
fn a_half_slip_that_is_greater_is_the_robots_own() {
    let column = Column { cause: Cause::HalfSlip, coefficient: 1.0 };
    let powers = |half_slip: f64, columns: &[Column<f64>]| {
        let plain = robot(columns);
        let slip = SlipMemory { half_slip, relaxation: 1.2, rest: 0.0 };
        let Model::Signed { torque, drive: of_wheels } = plain.model else { return Vec::new() };
        let torque = model_core::torque::TorqueModel { scrub: 0.02, ..torque };
        let skidding = Coefficients {
            robot: Robot { conditioning: Conditioning { slip, ..Conditioning::PLAIN }, ..plain.robot },
            model: Model::Signed { torque, drive: of_wheels },
            ..plain
        };
        let (mut pipeline, mut live) = pipeline(&skidding);
        let push = |(i, (sample, outside)): (usize, &(Sample<f64, 2>, Outside<f64, 2>))| {
            pipeline.push_with(&mut live, sample, outside, if i == 0 { 0.0 } else { PERIOD }).power
        };
        drive(None).iter().take(1000).enumerate().map(push).collect::<Vec<_>>()
    };
    let fitted = powers(0.5, &[]);
    assert!(powers(0.25, &[column]) == fitted);
    assert!(powers(0.25, &[]) != fitted);
}
