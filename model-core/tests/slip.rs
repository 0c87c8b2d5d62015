//! Laws of the slip memory, and what it is in the torque model.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "tests")]

mod common;

use common::{close, coefficients, torque_model};
use model_core::coefficients::{Coefficients, Robot};
use model_core::conditioning::Conditioning;
use model_core::estimator::{Conditioned, Conditioner, Sample};
use model_core::kinematics::Kinematics;
use model_core::model::Model;
use model_core::motion::{Motion, Wheel};
use model_core::real::Real;
use model_core::slip::{Rims, Slip, SlipMemory};
use model_core::torque::{Drive, TorqueModel};
use proptest::prelude::*;

const PERIOD: f64 = 0.005;

fn memory() -> impl Strategy<Value = SlipMemory<f64>> {
    (0.01..2.0_f64, 0.0..30.0_f64).prop_map(|(half_slip, relaxation)| SlipMemory {
        half_slip,
        relaxation,
        rest: 0.0,
    })
}

fn rims() -> impl Strategy<Value = Rims<f64>> {
    (-10.0..10.0_f64, 0.0..10.0_f64, 0.0..0.1_f64).prop_map(|(difference, mean, rest)| Rims {
        difference,
        mean,
        rest,
    })
}

fn steady(memory: &SlipMemory<f64>, rims: &Rims<f64>) -> f64 {
    rims.difference / (memory.half_slip * rims.mean).hypot(rims.difference).hypot(rims.rest)
}

proptest! {
    /// A mean of the state before and of the steady curve: it moves towards that, never past it,
    /// whatever the step.
    #[test]
    fn moves_towards_the_steady_curve(
        memory in memory(), first in rims(), then in rims(), elapsed in prop_oneof![0.0..0.1_f64, 0.0..1e6_f64],
    ) {
        let mut slip = Slip::default();
        let before = memory.settle(&mut slip, &first);
        prop_assert!((before - steady(&memory, &first)).abs() < 1e-15);
        let after = memory.step(&mut slip, &then, elapsed);
        let end = steady(&memory, &then);
        let (low, high) = (before.min(end) - 1e-15, before.max(end) + 1e-15);
        prop_assert!(after >= low && after <= high && after.abs() <= 1.0, "{} {} {}", before, after, end);
        prop_assert_eq!(after, slip.share());
    }

    /// A softer tyre has the share of the steady curve that its own slip says.
    #[test]
    fn softer_tyres_have_their_own_steady_curve(memory in memory(), rims in rims(), share in -0.9..9.0_f64) {
        prop_assume!(rims.difference.abs() > 1e-3);
        let softer = SlipMemory { half_slip: memory.half_slip * (1.0 + share), ..memory };
        let softened = memory.softened(&rims, share) * steady(&memory, &rims);
        prop_assert!((softened - steady(&softer, &rims)).abs() < 1e-12);
    }

    /// c → 0 is the sign of the turn at once, λ → 0 the steady curve at once.
    #[test]
    fn limits(memory in memory(), first in rims(), then in rims()) {
        prop_assume!(then.difference.abs() > 1e-3);
        for (limit, expected) in [
            (SlipMemory { half_slip: 1e-12, ..memory }, then.difference.signum()),
            (SlipMemory { relaxation: 0.0, ..memory }, steady(&memory, &then)),
        ] {
            let then = if limit.half_slip < 1e-9 { Rims { rest: 0.0, ..then } } else { then };
            let mut slip = Slip::default();
            memory.settle(&mut slip, &first);
            let share = limit.step(&mut slip, &then, PERIOD);
            prop_assert!((share - expected).abs() < 1e-4, "{} {}", share, expected);
        }
    }

    /// Left and right swapped, the share is the opposite; the unit of time does not matter.
    #[test]
    fn symmetries(memory in memory(), course in proptest::collection::vec(rims(), 1..20), scale in 0.1..10.0_f64) {
        let run = |sign: f64, scale: f64| {
            let mut slip = Slip::default();
            for rims in &course {
                let rims = Rims {
                    difference: sign * scale * rims.difference,
                    mean: scale * rims.mean,
                    rest: scale * rims.rest,
                };
                memory.step(&mut slip, &rims, 0.02 / scale);
            }
            slip.share()
        };
        prop_assert_eq!(run(-1.0, 1.0), -run(1.0, 1.0));
        prop_assert!(close(run(1.0, scale), run(1.0, 1.0), 1.0, 1e-12));
    }

    /// With mass m the power stays a polynomial of it: the share holds no mass. d is Coulomb torque
    /// on the right, less on the left, whichever way the wheels turn. e is what the gear takes of
    /// what passes it, whether the motor drives the wheel or the wheel the motor; friction passes
    /// it or does not, or a part of it does. δ is a speed in the direction of the torque. For the
    /// polynomial both directions are those of the middle mass.
    #[test]
    fn power_is_still_a_polynomial_of_the_mass(
        torque in torque_model(), scrub in 0.0..0.5_f64, imbalance in -0.5..0.5_f64, share in -1.0..1.0_f64,
        gear_loss in 0.0..0.7_f64, bridge_drop in 0.0..2.0_f64,
        wheel_friction_share in prop_oneof![Just(0.0), Just(1.0), 0.0..1.0_f64],
        speed in proptest::array::uniform2(prop_oneof![-9.0..-0.1_f64, 0.1..9.0_f64]), mass in 1.0..6.0_f64,
    ) {
        let torque = TorqueModel { scrub, imbalance, gear_loss, bridge_drop, wheel_friction_share, ..torque };
        let matrix = kinematics().mass_matrix(0.064).unwrap();
        let shares = matrix.sides().unwrap().scrub(share);
        let motion = Motion::with_scrub(&speed, &[0.3, -0.4], &shares, &matrix, 0.02);
        let model = Model::Signed { torque, drive: Drive::Regenerative };
        let torque_of = |side: f64, wheel: &Wheel<f64>, mass: f64, directed_at: f64| {
            let h = wheel.speed.signum();
            let friction = (torque.coulomb + side * imbalance) * h + torque.viscous * wheel.speed;
            let passed = |mass: f64| {
                let load = torque.rolling * h + torque.inertia_gain * wheel.inertial_torque + side * scrub * share;
                wheel_friction_share * friction + mass * load
            };
            let factor = if passed(directed_at) * h > 0.0 { 1.0 + gear_loss } else { 1.0 - gear_loss };
            let before_the_gear = (1.0 - wheel_friction_share) * friction + torque.rotor_inertia * wheel.acceleration;
            before_the_gear + factor * passed(mass)
        };
        let range = common::range();
        // By the directions at this mass.
        let power = |directed_at: f64| -> f64 {
            let of = |(side, wheel): (&f64, &Wheel<f64>)| {
                let tau = torque_of(*side, wheel, mass, directed_at);
                let dropped = bridge_drop * torque_of(*side, wheel, directed_at, directed_at).signum();
                tau * (wheel.speed + dropped) + torque.winding_loss * tau * tau
            };
            [-1.0, 1.0].iter().zip(&motion.wheels).map(of).sum()
        };
        let (expected, response) = (power(range.middle()), model.response(&motion, &range));
        let answered = response.polynomial.at(mass - range.middle());
        let scale = 1e3 * (1.0 + expected.abs());
        prop_assert!(close(answered, expected, scale, 1e-13), "{} {}", answered, expected);
        prop_assert!(close(model.power(&motion, mass).unwrap(), power(mass), scale, 1e-13));
    }
}

fn kinematics() -> Kinematics<f64, 2> {
    Kinematics::differential(0.033, 0.16).unwrap()
}

/// Two sides are those of differential drive and skid steer, whatever the number of wheels; others
/// have none.
#[test]
fn sides_come_from_the_matrix() {
    let rims = |difference, mean| Rims { difference, mean, rest: 0.02 };
    let two = kinematics().sides().unwrap();
    assert_eq!(two.rims(&[2.0, 5.0], 0.02), rims(3.0, 3.5));
    assert_eq!(two.rims(&[-2.0, -5.0], 0.02), rims(-3.0, 3.5));
    let four = Kinematics::<f64, 4>::skid_steer(0.165, 1.07).unwrap().sides().unwrap();
    assert_eq!(four.rims(&[1.0, 4.0, 3.0, 6.0], 0.02), rims(3.0, 3.5));
    assert_eq!(four.scrub(0.5), [-0.5, 0.5, -0.5, 0.5]);
    // Three wheels on one side, one of them mounted the other way round.
    let rows = [[0.1, 0.1, 0.1, -0.1], [0.0; 4], [-0.2, 0.2, 0.2, -0.2]];
    let odd = Kinematics::from_rows(rows).unwrap().sides().unwrap();
    let of_odd = odd.rims(&[2.0, 4.0, 5.0, -6.0], 0.02);
    assert!((of_odd.difference - 3.0).abs() < 1e-12 && (of_odd.mean - 3.5).abs() < 1e-12, "{of_odd:?}");
    assert!(Kinematics::<f64, 4>::mecanum(0.05, 0.2, 0.2).unwrap().sides().is_none());
    assert!(Kinematics::<f64, 3>::omni(0.05, 0.2).unwrap().sides().is_none());
    assert!(Kinematics::from_rows([[0.1, 0.1], [0.0; 2], [0.2, 0.3]]).unwrap().sides().is_none());
}

fn conditioned(
    conditioner: &mut Conditioner<f64, 2>,
    time: f64,
    elapsed: f64,
) -> Option<Conditioned<f64, 2>> {
    let turn = if time < 1.0 { 0.0 } else { 0.4 };
    let speed = 3.0 + (2.0 * time).sin();
    let sample =
        Sample { wheel_speed: [speed - turn, speed + turn], wheel_acceleration: None, power: 1.0 + time };
    conditioner.push(&sample, elapsed)
}

fn robot(slip: SlipMemory<f64>) -> Robot<f64, 2> {
    Robot { conditioning: Conditioning { slip, ..Conditioning::PLAIN }, ..coefficients().robot }
}

/// The conditioner runs the memory on filtered speeds, over the time that passed, and settles it
/// after gaps: whoever has speeds and times can do the same.
#[test]
fn conditioner_runs_the_memory() {
    let memory = SlipMemory { half_slip: 0.13, relaxation: 1.8, rest: 0.0 };
    let robot = robot(memory);
    let mut conditioner = Conditioner::new(&robot, PERIOD).unwrap();
    let sides = *robot.mass_matrix.sides().unwrap();
    let mut slip = Slip::default();
    let (mut time, mut least, mut most) = (0.0, 1.0_f64, 0.0_f64);
    for i in 0..2000 {
        let is_gap = i == 0 || i == 1500;
        let elapsed = match i {
            0 => 0.0,
            1500 => 3.0,
            _ => PERIOD * (1.0 + 0.3 * f64::from(i % 3 - 1)),
        };
        time += elapsed;
        let now = conditioned(&mut conditioner, time, elapsed).unwrap();
        let rims = sides.rims(&now.motion.wheels.map(|wheel| wheel.speed), robot.dead_band);
        let expected =
            if is_gap { memory.settle(&mut slip, &rims) } else { memory.step(&mut slip, &rims, elapsed) };
        assert_eq!(now.motion.wheels.map(|wheel| wheel.scrub), [-expected, expected], "{i}");
        if time > 1.2 && !is_gap {
            (least, most) = (least.min(expected), most.max(expected));
        }
    }
    assert!(least < 0.3 && most > 0.6, "{least} {most}");
}

/// Where nothing turns or rolls, and without a memory, softer tyres change nothing.
#[test]
fn softer_tyres_at_rest_are_as_they_were() {
    let memory = SlipMemory { half_slip: 0.13, relaxation: 1.8, rest: 0.0 };
    assert_eq!(memory.softened(&Rims::default(), 0.5), 1.0);
    assert_eq!(SlipMemory::OFF.softened(&Rims { difference: 0.3, mean: 2.0, rest: 0.02 }, 0.5), 1.0);
}

/// A sample that is no number leaves no trace but its time.
#[test]
fn broken_samples_pass_their_time() {
    let memory = SlipMemory { half_slip: 0.13, relaxation: 1.8, rest: 0.0 };
    let robot = robot(memory);
    let mut conditioner = Conditioner::new(&robot, PERIOD).unwrap();
    let sides = robot.mass_matrix.sides().unwrap();
    let turn = |power| Sample { wheel_speed: [2.0, 3.0], wheel_acceleration: None, power };
    let straight = Sample { wheel_speed: [2.0; 2], wheel_acceleration: None, power: 1.0 };
    conditioner.push(&straight, 0.0);
    let mut slip = Slip::default();
    for i in 0..60 {
        let mut elapsed = PERIOD;
        if i == 40 {
            assert!(conditioner.push(&turn(f64::NAN), PERIOD).is_none());
            elapsed += PERIOD;
        }
        let wheels = conditioner.push(&turn(1.0), PERIOD).unwrap().motion.wheels;
        let expected =
            memory.step(&mut slip, &sides.rims(&wheels.map(|wheel| wheel.speed), robot.dead_band), elapsed);
        assert_eq!(wheels[1].scrub, expected, "{i}");
    }
    assert!(slip.share() > 0.1 && slip.share() < 0.7, "{slip:?}");
}

/// Off, the arithmetic is what it was: the sign of the turn, bit by bit, and for robots that do not
/// scrub none.
#[test]
fn off_is_the_sign_of_the_turn() {
    for scrubs in [false, true] {
        let off = SlipMemory { half_slip: 0.0, relaxation: 1.8, rest: 0.0 };
        let kinematics = kinematics().with_scrub(scrubs);
        let mass_matrix = kinematics.mass_matrix(0.064).unwrap();
        let robot = Robot { kinematics, mass_matrix, ..robot(off) };
        let mut conditioner = Conditioner::new(&robot, PERIOD).unwrap();
        let mut turned = false;
        for i in 0..1000 {
            let now = conditioned(&mut conditioner, f64::from(i) * PERIOD, PERIOD).unwrap();
            let wheels = now.motion.wheels;
            let expected = Motion::new(
                &wheels.map(|wheel| wheel.speed),
                &wheels.map(|wheel| wheel.acceleration),
                &mass_matrix,
                robot.dead_band,
            );
            assert_eq!(now.motion, expected);
            turned |= wheels[1].scrub == 1.0;
        }
        assert_eq!(turned, scrubs);
    }
}

/// Largest distance of s from SciPy's, over a course that stands, creeps, turns both ways and
/// spins.
fn worst<T: Real>() -> f64 {
    let mut rows = include_str!("reference/slip.csv").lines();
    let parameters: Vec<f64> = rows.next().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    let [half_slip, relaxation, rest, period] = parameters[..] else { panic!("{parameters:?}") };
    let memory =
        SlipMemory { half_slip: T::from_f64(half_slip), relaxation: T::from_f64(relaxation), rest: T::ZERO };
    let sides = Kinematics::differential(T::from_f64(0.165), T::from_f64(1.07)).unwrap().sides().unwrap();
    let (mut slip, mut worst, mut most) = (Slip::default(), 0.0_f64, 0.0_f64);
    for row in rows {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let speed = [T::from_f64(cells[0]), T::from_f64(cells[1])];
        let share =
            memory.step(&mut slip, &sides.rims(&speed, T::from_f64(rest)), T::from_f64(period)).to_f64();
        worst = worst.max((share - cells[2]).abs());
        most = most.max(share.abs());
    }
    assert!(most > 0.9, "{most}");
    worst
}

/// `reference_slip.py` solves the differential equation with SciPy's LSODA, speeds between rows
/// straight lines. An implicit step of T errs by T s'' / 2 of the way, that is by T (pull / cλ) of
/// how fast s changes: with 2 ms and |Δ| up to 4 rad/s some 1 % of a change.
#[test]
fn follows_the_differential_equation() {
    let (single, double) = (worst::<f32>(), worst::<f64>());
    assert!(double < 0.01 && single < 0.01, "{double} {single}");
}

/// What no robot has is refused, and the rest runs.
#[test]
fn plausibility() {
    let with = |slip, imbalance, delay| {
        let conditioning = Conditioning { slip, delay, ..Conditioning::PLAIN };
        let base = coefficients();
        let Model::Signed { torque, drive } = base.model else { panic!("signed") };
        let robot = Robot { conditioning, ..base.robot };
        Coefficients {
            robot,
            model: Model::Signed { torque: TorqueModel { imbalance, ..torque }, drive },
            ..base
        }
    };
    let slip = |half_slip, relaxation| SlipMemory { half_slip, relaxation, rest: 0.0 };
    let rests = |rest| with(SlipMemory { rest, ..slip(0.126, 1.79) }, 0.0, 0.0).is_plausible();
    assert!(rests(0.5) && !rests(1.5));
    let loses = |gear_loss| {
        let base = coefficients();
        let Model::Signed { torque, drive } = base.model else { panic!("signed") };
        let model = Model::Signed { torque: TorqueModel { gear_loss, ..torque }, drive };
        Coefficients { model, ..base }.is_plausible()
    };
    assert!(loses(0.5) && !loses(0.8));
    assert!(with(slip(0.126, 1.79), -0.03, 0.25).is_plausible());
    assert!(with(slip(0.0, 0.0), 0.04, -0.25).is_plausible());
    for absurd in [
        with(slip(11.0, 1.0), 0.0, 0.0),
        with(slip(0.1, 2e3), 0.0, 0.0),
        with(SlipMemory::OFF, 0.05, 0.0),
        with(SlipMemory::OFF, -0.05, 0.0),
        with(SlipMemory::OFF, 0.0, 11.0),
    ] {
        assert!(!absurd.is_plausible(), "{absurd:?}");
    }
    // Sides that are none.
    let omni = Kinematics::<f64, 3>::omni(0.05, 0.2).unwrap();
    let two_sided = with(SlipMemory::OFF, 0.0, 0.0);
    let Robot { name, gyration_radius, dead_band, cutoff_hz, range, static_power, .. } = two_sided.robot;
    let three = |slip, imbalance| {
        let Model::Signed { torque, drive } = two_sided.model else { panic!("signed") };
        let mass_matrix = omni.mass_matrix(gyration_radius).unwrap();
        let conditioning = Conditioning { slip, ..Conditioning::PLAIN };
        let robot = Robot {
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
        let model = Model::Signed { torque: TorqueModel { imbalance, ..torque }, drive };
        Coefficients {
            robot,
            model,
            noise: two_sided.noise,
            columns: model_core::effects::Columns::NONE,
            identifies_mass: true,
            ground_adapts: false,
        }
    };
    assert!(three(SlipMemory::OFF, 0.0).is_plausible());
    assert!(!three(slip(0.1, 1.0), 0.0).is_plausible());
    assert!(!three(SlipMemory::OFF, 0.01).is_plausible());
}
