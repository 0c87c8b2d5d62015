//! Ground that changes along the way, told from an unknown mass.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "tests")]

mod common;

use common::{Rng, burger, coefficients, servo};
use model_core::adapt::belief::{Belief, Evidence};
use model_core::adapt::{Adaptive, Ground};
use model_core::coefficients::{Coefficients, Robot};
use model_core::effects::{Cause, Column, Columns};
use model_core::eq18::Gate;
use model_core::estimator::{Estimator, Sample, Timing, Unfit};
use model_core::model::Model;
use model_core::motion::Motion;
use model_core::payload::schedule::Schedule;
use model_core::payload::window::Window;
use model_core::payload::{Mass, Noise};
use model_core::real::Real;
use model_core::torque::{Drive, TorqueModel};

const PERIOD: f64 = 0.01;
const SIGMA: f64 = 0.03;

fn robot() -> Coefficients<f64, 2> {
    let base = coefficients();
    Coefficients {
        robot: Robot { cutoff_hz: 20.0, ..base.robot },
        noise: Noise { density: SIGMA * SIGMA * PERIOD, model_std: 0.0, tail: 1.0, residual_std: 0.0 },
        ..base
    }
}

/// Seconds that a floor lasts.
const FLOOR_S: usize = 120;

/// A drive over three floors: the fit's, one with more than half as much again of rolling
/// resistance, and the fit's again.
struct Drive3 {
    rng: Rng,
    speeds: fn(f64) -> ([f64; 2], [f64; 2]),
    mass: f64,
    harder: f64,
}

impl Drive3 {
    fn sample(&mut self, time: f64) -> Sample<f64, 2> {
        let floor = (time / FLOOR_S as f64) as usize;
        let rolling = servo().rolling + if floor == 1 { self.harder } else { 0.0 };
        let model = Model::Signed { torque: TorqueModel { rolling, ..servo() }, drive: Drive::Dissipative };
        let (speed, acceleration) = (self.speeds)(time);
        let (_, matrix) = burger();
        let power = model.power(&Motion::new(&speed, &acceleration, &matrix, 0.02), self.mass).unwrap();
        Sample { wheel_speed: speed, wheel_acceleration: None, power: power + SIGMA * self.rng.normal() }
    }
}

/// Speeds that swing: inertia tells the mass.
fn swinging(t: f64) -> ([f64; 2], [f64; 2]) {
    let (left, right) = (4.0 + 2.0 * (1.9 * t).sin(), 4.0 + 2.0 * (1.7 * t).cos());
    ([left, right], [3.8 * (1.9 * t).cos(), -3.4 * (1.7 * t).sin()])
}

/// One speed: nothing but rolling tells the mass.
fn steady(_: f64) -> ([f64; 2], [f64; 2]) {
    ([4.0; 2], [0.0; 2])
}

/// Masses at the end of every second, from the 30th of each floor on; `None` where unknown. With
/// adaptation and without.
fn masses(drive: &mut Drive3) -> [Vec<Option<Mass<f64>>>; 2] {
    let robot = robot();
    let schedule = Schedule::Moving { window: 25 };
    let timing = Timing { period_s: PERIOD, bucket_s: 1.0, schedule, detect_changes: false };
    let method = robot.window(PERIOD);
    let mut plain = Estimator::<f64, Window<f64>, 2, 32>::new(&robot, method, &timing).unwrap();
    let mut adaptive = Adaptive::new(&robot, &Ground::usual(), PERIOD, 1.0).unwrap();
    let (mut adapted, mut fixed) = (vec![], vec![]);
    for i in 0..(3.0 * FLOOR_S as f64 / PERIOD) as usize {
        let sample = drive.sample(i as f64 * PERIOD);
        let (one, other) = (adaptive.push(&sample, PERIOD), plain.push(&sample, PERIOD));
        assert_eq!(one.closed, other.closed, "{i}");
        let second = i / (1.0 / PERIOD) as usize;
        if one.closed && second % FLOOR_S >= 30 {
            adapted.push(one.mass.known());
            fixed.push(other.mass.known());
        }
    }
    [adapted, fixed]
}

fn covered(masses: &[Option<Mass<f64>>], truth: f64) -> (usize, usize) {
    let known = masses.iter().flatten();
    (known.clone().filter(|mass| mass.low <= truth && truth <= mass.high).count(), known.count())
}

/// On a floor that is not the fit's the mass is wrong, and its interval with it; with adaptation
/// the interval covers it, and the rolling resistance is found.
#[test]
fn another_floor_is_not_another_mass() {
    let (mut inside, mut known, mut wrong) = (0, 0, 0);
    for (seed, mass) in [(1, 2.0), (2, 3.3), (3, 4.6), (4, 5.5)] {
        let mut drive = Drive3 { rng: Rng::new(seed), speeds: swinging, mass, harder: 0.6 * servo().rolling };
        let [adapted, fixed] = masses(&mut drive);
        let second = FLOOR_S - 30..2 * (FLOOR_S - 30);
        let (covers, of) = covered(&fixed[second.clone()], mass);
        wrong += of - covers;
        let (covers, of) = covered(&adapted, mass);
        assert!(of >= adapted.len() * 9 / 10, "{mass}: known in {of} of {}", adapted.len());
        inside += covers;
        known += of;
        let worst = |masses: &[Option<Mass<f64>>]| {
            masses.iter().flatten().map(|estimate| (estimate.mass / mass - 1.0).abs()).fold(0.0, f64::max)
        };
        let [with, without] = [&adapted, &fixed].map(|masses| worst(&masses[second.clone()]));
        assert!(with < 0.5 * without, "{mass}: {with} {without}");
    }
    assert!(wrong > 300, "{wrong}");
    assert!(inside * 100 >= known * 92, "{inside} of {known}");
}

/// At a mass that somebody told the floor alone adapts: the rolling resistance of each is found,
/// and the mass stays what it was told.
#[test]
fn at_a_told_mass_the_floor_adapts() {
    let (mass, harder) = (3.3, 0.6 * servo().rolling);
    for speeds in [swinging as fn(f64) -> _, steady] {
        let mut drive = Drive3 { rng: Rng::new(7), speeds, mass, harder };
        let mut adaptive = Adaptive::new(&robot(), &Ground::usual(), PERIOD, 1.0).unwrap().with_mass(mass);
        let told = Mass { mass, low: mass, high: mass };
        let mut rolling = vec![];
        for i in 0..(3.0 * FLOOR_S as f64 / PERIOD) as usize {
            let out = adaptive.push(&drive.sample(i as f64 * PERIOD), PERIOD);
            assert_eq!(out.mass.known(), Some(told));
            if out.closed {
                rolling.push(adaptive.adapted().rolling);
            }
        }
        for (floor, truth) in [(0, servo().rolling), (1, servo().rolling + harder), (2, servo().rolling)] {
            let [believed, std] = rolling[(floor + 1) * FLOOR_S - 2];
            assert!(
                (believed - truth).abs() < 3.0 * std && std < 0.2 * harder,
                "{floor}: {believed} ± {std}, {truth}"
            );
        }
        adaptive.payload_changed();
        assert_eq!(adaptive.adapted().mass.known(), Some(told));
    }
}

/// Where nothing but rolling tells the mass, the interval says so: wider than the fit's floor alone
/// would have it, or unknown.
#[test]
fn what_cannot_be_told_apart_is_not_claimed() {
    let mut drive = Drive3 { rng: Rng::new(5), speeds: steady, mass: 3.0, harder: 0.6 * servo().rolling };
    let [adapted, fixed] = masses(&mut drive);
    let (covers, of) = covered(&fixed, 3.0);
    assert!(of > 200 && covers < of * 8 / 10, "{covers} {of}");
    let (covers, of) = covered(&adapted, 3.0);
    assert!(covers == of, "{covers} {of}");
    assert!(adapted.iter().flatten().all(|mass| mass.high - mass.low > 1.0));
}

/// A mass before the gap, another after it: what is known right after it, and then at the end of
/// every second.
fn across<T: Real>(gap: f64, harder: f64) -> (Option<Mass<f64>>, Vec<Option<Mass<f64>>>) {
    let robot: Coefficients<T, 2> = robot().convert().unwrap();
    let ground = Ground { window: T::from_f64(25.0), ..Ground::usual() };
    let mut adaptive = Adaptive::new(&robot, &ground, PERIOD, 1.0).unwrap();
    let mut drive = Drive3 { rng: Rng::new(11), speeds: swinging, mass: 2.0, harder };
    let (mut at_once, mut later) = (None, vec![]);
    for i in 0..12_000 {
        if i == 6000 {
            drive.mass = 5.0;
        }
        let measured = drive.sample(f64::from(i) * PERIOD);
        let sample = Sample {
            wheel_speed: measured.wheel_speed.map(T::from_f64),
            wheel_acceleration: None,
            power: T::from_f64(measured.power),
        };
        let elapsed = if i == 6000 { gap } else { PERIOD };
        let estimate = adaptive.push(&sample, T::from_f64(elapsed));
        let known = estimate.mass.known().map(|mass| Mass {
            mass: mass.mass.to_f64(),
            low: mass.low.to_f64(),
            high: mass.high.to_f64(),
        });
        match i {
            5999 => assert!(known.is_some_and(|mass| mass.low < 2.0 && mass.high > 2.0), "{known:?}"),
            6000 => at_once = known,
            _ if i > 6000 && estimate.closed => later.push(known),
            _ => {}
        }
    }
    (at_once, later)
}

/// A gap that is longer than the window leaves nothing of the mass, as with the plain estimator: it
/// is unknown until the new one is known. A shorter one leaves the old mass, less sure the longer
/// it was.
#[test]
fn a_gap_forgets_the_mass() {
    fn check<T: Real>() {
        let mut width = 0.0;
        for gap in [1.0, 5.0, 12.0, 20.0] {
            let (at_once, _) = across::<T>(gap, 0.0);
            let spread = at_once.unwrap().high - at_once.unwrap().low;
            assert!(spread > width, "{gap} s: {spread} after {width}");
            width = spread;
        }
        for gap in [25.5, 26.3, 60.0, 600.0, 3600.0, 86_400.0, 1e9, f64::from(f32::MAX)] {
            let (at_once, later) = across::<T>(gap, 0.0);
            assert_eq!(at_once, None, "{gap} s");
            assert!(later.len() >= 59, "{gap} s: {}", later.len());
            let known: Vec<&Mass<f64>> = later.iter().flatten().collect();
            let right = known.iter().filter(|mass| mass.low <= 5.0 && mass.high >= 5.0).count();
            // 95 % of 60 seconds, of which one tells much of what the next one does.
            assert!(known.len() > 30 && right * 10 >= known.len() * 9, "{gap} s: {right} of {}", known.len());
        }
    }
    check::<f64>();
    check::<f32>();
}

/// Samples that are no numbers are a gap as well; and of the ground no more is known after an hour
/// than at the start.
#[test]
fn a_gap_forgets_the_ground_and_may_hold_samples() {
    let at_start = Adaptive::new(&robot(), &Ground::usual(), PERIOD, 1.0).unwrap();
    let mut adaptive = at_start;
    let mut drive = Drive3 { rng: Rng::new(12), speeds: swinging, mass: 2.0, harder: 0.6 * servo().rolling };
    let floor = FLOOR_S as f64;
    for i in 0..6000 {
        adaptive.push(&drive.sample(floor + f64::from(i) * PERIOD), PERIOD);
    }
    let spread = |adaptive: &Adaptive<f64, 2>| adaptive.adapted().rolling[1];
    assert!(spread(&adaptive) < 0.5 * spread(&at_start) && adaptive.adapted().mass.known().is_some());
    let nothing = Sample { wheel_speed: [f64::NAN; 2], wheel_acceleration: None, power: 1.0 };
    let mut silent = adaptive;
    let until = (0..4000).position(|_| silent.push(&nothing, PERIOD).mass.known().is_none()).unwrap();
    assert!((2490..2700).contains(&until), "{until}");
    adaptive.push(&drive.sample(floor), 3600.0);
    let ([rolling, _], [fitted, _]) = (adaptive.adapted().rolling, at_start.adapted().rolling);
    assert!(
        (spread(&adaptive) / spread(&at_start) - 1.0).abs() < 1e-9 && (rolling / fitted - 1.0).abs() < 1e-9
    );
}

/// What is believed after a year of buckets is what dense Gaussian conditioning says:
/// `reference_adapt.py`.
fn worst<T: Real>() -> f64 {
    let mut belief = Belief::<T>::default();
    let mut worst = 0.0_f64;
    for line in include_str!("reference/adapt.csv").lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let number = |place: usize| T::from_f64(cells[place]);
        belief.pass(T::ONE, number(0));
        let mut evidence = Evidence::default();
        for sample in 0..3 {
            let at = 1 + 4 * sample;
            let slopes = [number(at), number(at + 1), number(at + 2)];
            let [m, r, s] = belief.state();
            let expected = slopes[0] * m + slopes[1] * r + slopes[2] * s;
            evidence.add(&slopes, number(at + 3) - expected, T::ONE);
        }
        belief.take(&evidence);
        let covariance = belief.covariance();
        let believed = [belief.state().to_vec(), covariance.as_flattened().to_vec()].concat();
        for (believed, expected) in believed.iter().zip(&cells[13..]) {
            worst = worst.max((believed.to_f64() - expected).abs());
        }
    }
    worst
}

/// Single precision: products of numbers up to 10, three thousand of them, in a filter that
/// forgets.
#[test]
fn belief_is_gaussian_conditioning() {
    let (double, single) = (worst::<f64>(), worst::<f32>());
    assert!(double < 1e-9 && single < 1e-4, "{double} {single}");
}

#[test]
fn what_cannot_adapt_is_refused() {
    let refused = |robot: &Coefficients<f64, 2>| Adaptive::new(robot, &Ground::usual(), PERIOD, 1.0).err();
    assert_eq!(refused(&robot()), None);
    let eq18 = Coefficients { model: Model::Eq18 { gate: Gate::Corrected, beta: [0.1; 15] }, ..robot() };
    assert_eq!(refused(&eq18), Some(Unfit::Model));
    let columns = Columns::new(&[Column { cause: Cause::Hot, coefficient: 0.1 }], 2).unwrap();
    assert_eq!(refused(&Coefficients { columns, ..robot() }), Some(Unfit::Model));
}

/// Whatever numbers come, there is no panic, and nothing is believed that is not a number.
#[test]
fn numbers_that_are_none_are_not_believed() {
    let mut adaptive = Adaptive::new(&robot(), &Ground::usual(), PERIOD, 1.0).unwrap();
    let mut drive = Drive3 { rng: Rng::new(9), speeds: swinging, mass: 3.0, harder: 0.0 };
    for i in 0..6000 {
        let mut sample = drive.sample(f64::from(i) * PERIOD);
        match i % 97 {
            0 => sample.power = f64::NAN,
            1 => sample.wheel_speed[0] = f64::INFINITY,
            2 if i < 3000 => sample.power = 1e300,
            _ => {}
        }
        let elapsed = if i % 1001 == 0 { f64::NAN } else { PERIOD };
        adaptive.push(&sample, elapsed);
    }
    let (measured, predicted) = adaptive.energy();
    assert!(measured.is_finite() && predicted.is_finite(), "{measured} {predicted}");
    let adapted = adaptive.adapted();
    assert!(adapted.rolling.iter().chain(&adapted.scrub).all(|x| x.is_finite()), "{adapted:?}");
}
