//! Terms on logs made from known models: taken where the model has them, and only there.

use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use logs::{RawRow, RawSample};
use model_core::coefficients::Robot as CoreRobot;
use model_core::conditioning::Conditioning;
use model_core::motion::Motion;
use model_core::slip::{Rims, Slip, SlipMemory};
use model_core::torque::TorqueModel;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::physical::{Bounds, FreeTerms, MOST_GEAR_LOSS, solve_within};
use super::super::pilot::Pilots;
use super::term::delays;
use super::{Choice, Judged, TERMS, TERMS_WITH_GYRO, Term, choose, keep_what_stays};

const PERIOD_S: f64 = 0.05;
const ROWS: usize = 4000;
const MASS_KG: f64 = 75.0;

/// What a robot is made of.
#[derive(Clone, Copy, Default)]
struct Truth {
    slip: SlipMemory<f64>,
    /// Samples by which the power is later.
    late: usize,
    imbalance: f64,
    gear_loss: f64,
    wheel_friction_share: f64,
    /// Drives give braking power back, and the robot drives straight, with a third of the friction.
    brakes: bool,
    bridge_drop: f64,
    /// q, s/rad.
    true_slip: f64,
    gyro: Gyroscope,
}

/// What a robot's gyro says.
#[derive(Clone, Copy, Default, PartialEq)]
enum Gyroscope {
    /// There is none.
    #[default]
    Absent,
    /// How the robot turns: wheels slip by 0 to 80 % of what they would turn it, as the ground has
    /// it.
    True,
    /// What the wheels say.
    Wheels,
    /// Nothing that has to do with how the robot turns.
    Noise,
    /// As it turns, but for a hole of two seconds.
    Holed,
    /// As it turns, to three quarters of the log.
    Broken,
}

fn husky() -> (Robot, CoreRobot<f64, 2>) {
    let robot = Robot::named("husky").unwrap();
    // A lower filter makes the steps of sgn and clamp later than the speeds, which is a delay as
    // far as the model goes.
    let core = robot.core::<2>(8.0).unwrap();
    (robot, core)
}

/// The same with drives that give braking power back.
fn regenerative() -> (Robot, CoreRobot<f64, 2>) {
    let text = include_str!("../../../robots/husky.toml");
    let robot = Robot::parse(&text.replace("regeneration = false", "regeneration = true")).unwrap();
    let core = robot.core::<2>(8.0).unwrap();
    (robot, core)
}

/// Smooth speeds of both sides, slow for the filter, curves of every radius and spins.
fn speeds(seed: u64) -> Vec<[f64; 2]> {
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let mut waves = || {
        let parts: [(f64, f64); 4] = std::array::from_fn(|k| {
            (0.25 * (k as f64 + 1.0) * (1.0 + 0.3 * random.random::<f64>()), 6.3 * random.random::<f64>())
        });
        move |t: f64| parts.iter().map(|(rate, phase)| (rate * t + phase).sin()).sum::<f64>()
    };
    let (forward, turn) = (waves(), waves());
    let both = |index: usize| {
        let t = PERIOD_S * index as f64;
        let (forward, turn) = (1.5 * forward(t) + 1.0, 0.6 * turn(t) * (0.05 * t).sin());
        [forward - turn, forward + turn]
    };
    (0..ROWS).map(both).collect()
}

/// Share of what the wheels would turn the robot that they slip, 0 to 0.8: as the ground changes,
/// slowly.
fn slipping(seed: u64) -> Vec<f64> {
    let random = &mut ChaCha8Rng::seed_from_u64(200 + seed);
    let phase = 6.3 * random.random::<f64>();
    let at = |index: usize| {
        let t = PERIOD_S * index as f64;
        0.4 + 0.2 * ((0.31 * t + phase).sin() + (0.083 * t).sin())
    };
    (0..ROWS).map(at).collect()
}

fn difference([left, right]: &[f64; 2]) -> f64 {
    right - left
}

impl Truth {
    fn torque(&self) -> TorqueModel<f64> {
        let easy = if self.brakes { 1.0 / 3.0 } else { 1.0 };
        TorqueModel {
            imbalance: self.imbalance,
            gear_loss: self.gear_loss,
            wheel_friction_share: self.wheel_friction_share,
            bridge_drop: self.bridge_drop,
            ..TorqueModel::from_array([3.0 * easy, 0.02 * easy, 0.5 * easy, 0.1, 1.2, 0.06, 0.25])
        }
    }
}

/// A log of such a robot with 2 W of noise.
fn log(core: &CoreRobot<f64, 2>, truth: Truth, seed: u64) -> Pilots {
    let torque = truth.torque();
    let mut speeds = speeds(seed);
    if truth.brakes {
        speeds.iter_mut().for_each(|[left, right]| *right = *left);
    }
    let (matrix, sides) = (&core.mass_matrix, core.mass_matrix.sides().unwrap());
    let mut slip = Slip::default();
    let mut power = Vec::new();
    let ground = slipping(seed);
    let lever = core.kinematics.difference_per_turn();
    let other = self::speeds(seed + 50);
    for (index, speed) in speeds.iter().enumerate() {
        // From both neighbours: from the one before alone it would be late by half a step.
        let (before, after) = (index.saturating_sub(1), (index + 1).min(speeds.len() - 1));
        let steps = (after - before) as f64;
        let acceleration =
            std::array::from_fn(|side| (speeds[after][side] - speeds[before][side]) / (steps * PERIOD_S));
        let rims = sides.rims(speed, core.dead_band);
        let share = if truth.slip.is_off() {
            if rims.difference.abs() > core.dead_band { rims.difference.signum() } else { 0.0 }
        } else {
            truth.slip.step(&mut slip, &Rims { rest: truth.slip.rest_of(core.dead_band), ..rims }, PERIOD_S)
        };
        let share = share + truth.true_slip * ground[index] * rims.difference;
        let motion = Motion::with_scrub(speed, &acceleration, &sides.scrub(share), matrix, core.dead_band);
        let least = if truth.brakes { f64::NEG_INFINITY } else { 0.0 };
        let of_wheel = |wheel| torque.wheel_power(wheel, MASS_KG).max(least);
        power.push(motion.wheels.iter().map(of_wheel).sum::<f64>());
    }
    let random = &mut ChaCha8Rng::seed_from_u64(100 + seed);
    let row = |index: usize| {
        let noise: f64 = random.sample(rand_distr::StandardNormal);
        let elapsed = if index == 0 { f64::NAN } else { PERIOD_S };
        RawRow {
            line: index as u64 + 2,
            sample: RawSample {
                wheel_speed: speeds[index].into(),
                wheel_acceleration: None,
                power: power[index.saturating_sub(truth.late)] + 2.0 * noise,
            },
            elapsed,
            mass: Some(MASS_KG),
            run: 0,
            time: PERIOD_S * index as f64,
            yaw_rate: match truth.gyro {
                Gyroscope::Absent => f64::NAN,
                Gyroscope::Holed if (1000..1040).contains(&index) => f64::NAN,
                Gyroscope::Broken if index >= 3 * ROWS / 4 => f64::NAN,
                Gyroscope::True | Gyroscope::Holed | Gyroscope::Broken => {
                    (1.0 - ground[index]) * difference(&speeds[index]) / lever
                }
                Gyroscope::Wheels => difference(&speeds[index]) / lever,
                Gyroscope::Noise => difference(&other[index]) / lever,
            },
        }
    };
    Pilots::of_rows((0..ROWS).map(row).collect(), PERIOD_S)
}

fn chosen(truth: Truth, seed: u64) -> Choice {
    let (robot, core) = if truth.brakes { regenerative() } else { husky() };
    choose(&robot, &Chassis::new(&core), &TERMS_WITH_GYRO, &log(&core, truth, seed), &|_| false, None)
}

fn taken(choice: &Choice) -> Vec<Term> {
    choice.judged.iter().filter(|judged| judged.taken).map(|judged| judged.term).collect()
}

#[test]
fn nothing_is_taken_where_nothing_is() {
    for seed in 0..3 {
        let choice = chosen(Truth::default(), seed);
        assert_eq!(taken(&choice), [], "{choice:?}");
        assert_eq!(choice.form.conditioning, Conditioning::PLAIN);
        assert_eq!(choice.judged.len(), TERMS.len());
    }
}

/// The filter has the speeds before the memory: slip and relaxation are those of filtered speeds,
/// so some 15 % off.
#[test]
fn slip_memory_is_found() {
    let slip = SlipMemory { half_slip: 0.15, relaxation: 1.5, rest: 0.2 };
    let choice = chosen(Truth { slip, ..Truth::default() }, 1);
    assert_eq!(taken(&choice), [Term::SlipMemory], "{choice:?}");
    let fitted = choice.form.conditioning.slip;
    assert!((fitted.half_slip / slip.half_slip).ln().abs() < 0.15, "{fitted:?}");
    assert!((fitted.relaxation / slip.relaxation).ln().abs() < 0.3, "{fitted:?}");
    assert!((fitted.rest / slip.rest).ln().abs() < 0.3, "{fitted:?}");
}

/// Four samples, to half of one: where a wheel or a turn changes its direction the power steps, and
/// a step passes the filter's fifth order later than the slow speeds do.
#[test]
fn a_delay_is_found() {
    let choice = chosen(Truth { late: 4, ..Truth::default() }, 2);
    assert_eq!(taken(&choice), [Term::Delay], "{choice:?}");
    assert!((choice.form.conditioning.delay - 4.0 * PERIOD_S).abs() < 0.5 * PERIOD_S, "{choice:?}");
}

/// What a servo says of its speed is a mean over 50 ms: 25 ms late. Half a sample of a slow log
/// would be taken for how it smooths.
#[test]
fn delays_between_the_steps_are_whole_samples() {
    let beside = |now: f64, sample_s: f64| {
        let odd = |delay: &f64| (delay / 0.05 - (delay / 0.05).round()).abs() > 1e-6;
        delays(now, sample_s).into_iter().filter(odd).map(|delay| (1e3 * delay).round()).collect::<Vec<_>>()
    };
    assert_eq!(beside(0.0, 0.005), [-25.0, 25.0]);
    assert_eq!(beside(0.1, 0.02), [80.0, 120.0]);
    assert!(beside(0.0, 0.05).is_empty());
}

#[test]
fn unequal_sides_are_found() {
    let choice = chosen(Truth { imbalance: 1.0, ..Truth::default() }, 0);
    assert_eq!(taken(&choice), [Term::UnequalSides], "{choice:?}");
    assert!(choice.form.free_terms.unequal_sides);
}

/// Wheels that the inner side of a turn drives back tell of it.
#[test]
fn the_loss_of_a_gear_is_found() {
    let choice = chosen(Truth { gear_loss: 0.2, ..Truth::default() }, 1);
    assert_eq!(taken(&choice), [Term::GearLoss], "{choice:?}");
    assert_eq!(choice.form.free_terms.gear_loss, Some(0.0));
}

/// A gear that loses more than a fit takes: its loss ends at the bound, and no refit would have it.
#[test]
fn a_loss_that_a_fit_leaves_out_is_not_lacking() {
    let (robot, core) = husky();
    let kept = |gear_loss: f64| {
        let truth = Truth { gear_loss, ..Truth::default() };
        let core = Chassis::new(&core);
        let rows = log(&husky().1, truth, 1).condition(&core, ROWS).unwrap();
        let free_terms = FreeTerms { gear_loss: Some(0.0), ..FreeTerms::default() };
        let bounds = Bounds::of(&core, rows.all(), robot.motor(), free_terms);
        let solution = solve_within(rows.all(), robot.drive(), &bounds);
        let judged = |term| Judged { term, gain: 0.1, std_err: Some(0.01), taken: true };
        let mut judged = vec![judged(Term::Delay), judged(Term::GearLoss)];
        keep_what_stays(&mut judged, &solution);
        judged.len()
    };
    assert_eq!([0.2, 1.5 * MOST_GEAR_LOSS].map(kept), [2, 1]);
}

/// Any braking drives the motor back where friction does not pass the gear, and hard braking alone
/// where it does: drives that give power back tell which.
#[test]
fn the_friction_that_passes_a_gear_is_found() {
    for wheel_friction_share in [0.0, 1.0] {
        for seed in 0..3 {
            let truth = Truth { gear_loss: 0.2, wheel_friction_share, brakes: true, ..Truth::default() };
            let choice = chosen(truth, seed);
            assert_eq!(taken(&choice), [Term::GearLoss], "{choice:?}");
            assert_eq!(choice.form.free_terms.gear_loss, Some(wheel_friction_share), "{choice:?}");
        }
    }
}

/// 0.4 V of 24 V, as the winding's loss alone does not show them.
#[test]
fn the_drop_of_a_bridge_is_found() {
    let choice = chosen(Truth { bridge_drop: 0.4, ..Truth::default() }, 2);
    assert_eq!(taken(&choice), [Term::BridgeDrop], "{choice:?}");
    assert!(choice.form.free_terms.bridge_drop);
}

/// Also where it has two of them.
#[test]
fn what_a_known_model_has_is_not_asked_for() {
    let (robot, core) = husky();
    let truth = Truth { imbalance: 1.0, bridge_drop: 0.4, ..Truth::default() };
    let log = log(&core, truth, 0);
    for term in [Term::UnequalSides, Term::BridgeDrop] {
        let of = |known| taken(&choose(&robot, &Chassis::new(&core), &[term], &log, &|_| false, known));
        assert_eq!((of(None), of(Some(&truth.torque()))), (vec![term], vec![]));
    }
}

/// To a tenth: the filter has the speeds before the sign of the turn.
#[test]
fn true_slip_is_found() {
    let truth = Truth { true_slip: 0.4, gyro: Gyroscope::True, ..Truth::default() };
    let choice = chosen(truth, 1);
    assert_eq!(taken(&choice), [Term::TrueSlip], "{choice:?}");
    let fitted = choice.form.conditioning.true_slip;
    assert!((fitted / truth.true_slip).ln().abs() < 0.1, "{fitted}");
}

/// A gyro that says what the wheels say has nothing to add, one that says anything else neither;
/// without slip in the torque a true one has not. All are asked.
#[test]
fn a_gyro_that_adds_nothing_is_not_taken() {
    for gyro in [Gyroscope::True, Gyroscope::Wheels, Gyroscope::Noise] {
        for seed in 0..3 {
            let choice = chosen(Truth { gyro, ..Truth::default() }, seed);
            assert_eq!(taken(&choice), [], "{choice:?}");
            assert_eq!(choice.form.conditioning, Conditioning::PLAIN);
            assert_eq!(choice.judged.len(), TERMS_WITH_GYRO.len());
        }
    }
}

/// Rows without a turn rate are left out of what judges the term, with it and without: a hole does
/// no harm. A gyro that broke off is not asked.
#[test]
fn a_gyro_with_holes() {
    let truth = |gyro| Truth { true_slip: 0.4, gyro, ..Truth::default() };
    let choice = chosen(truth(Gyroscope::Holed), 1);
    assert_eq!(taken(&choice), [Term::TrueSlip], "{choice:?}");
    assert!((choice.form.conditioning.true_slip / 0.4).ln().abs() < 0.1, "{choice:?}");
    let choice = chosen(truth(Gyroscope::Broken), 1);
    assert!(choice.judged.iter().all(|judged| judged.term != Term::TrueSlip), "{choice:?}");
}

/// What is held out is not looked at: with nonsense there the choice is the same to the last digit.
#[test]
fn held_out_times_are_not_seen() {
    let (robot, core) = husky();
    let truth = Truth { late: 4, ..Truth::default() };
    let held_out = |time: f64| time >= 150.0;
    let clean = log(&core, truth, 2);
    let mut spoiled = log(&core, truth, 2);
    // From where not even the filter's memory reaches back.
    spoiled.spoil_from(150.0);
    let of = |pilots: &Pilots| choose(&robot, &Chassis::new(&core), &TERMS, pilots, &held_out, None);
    assert_eq!(of(&clean), of(&spoiled));
}

/// Too short a log has too few blocks to hold out: nothing is asked.
#[test]
fn a_short_log_is_not_asked() {
    let (robot, core) = husky();
    let pilots = log(&core, Truth { late: 4, ..Truth::default() }, 2);
    let choice = choose(&robot, &Chassis::new(&core), &TERMS, &pilots, &|time| time >= 10.0, None);
    assert!(choice.judged.is_empty() && choice.form.conditioning == Conditioning::PLAIN);
}
