//! Data made by each source's own assumptions give its constants back.

use model_core::effects::GRAVITY;
use model_core::kinematics::Kinematics;
use model_core::motion::Wheel;

use super::lugre::{DAMPING_TIME_S, SLIP_DEFLECTION_M};
use crate::baselines::cards::{ANJUM, DATOUO, DOGRU, HOU, TOUZOUT, WAHAB};
use crate::baselines::testing::{drive, drive_on, predict_one_speed, recovers};
use crate::baselines::{Card, Point};

/// Data without noise: rounding of 1e-16, grown by the condition of the Gram matrix, below 1e8 on
/// these drives.
const WITHIN: f64 = 1e-7;

/// Mass, inertia, traction and viscous friction, and the windings' R, i_f and i_K.
const MASS: f64 = 1.3;
const INERTIA: f64 = 0.02;
const TRACTION: f64 = 0.02;
const VISCOUS: f64 = 1e-3;
const WINDING: f64 = 2.0;
const FRICTION_CURRENT: f64 = 0.1;
const INERTIA_CURRENT: f64 = 5.0;

/// The constants in the order of the model with motors.
const WITH_MOTORS: [f64; 7] = [
    MASS,
    INERTIA,
    TRACTION,
    VISCOUS,
    WINDING * FRICTION_CURRENT * FRICTION_CURRENT,
    2.0 * WINDING * FRICTION_CURRENT * INERTIA_CURRENT,
    WINDING * INERTIA_CURRENT * INERTIA_CURRENT,
];

/// Energy that motion gains in a second: half the change of v² and ω², where it grows.
fn kinetic(point: &Point) -> f64 {
    let (v, a) = (point.speed, point.acceleration);
    (MASS * (v.vx * a.vx + v.vy * a.vy)).max(0.0) + (INERTIA * v.omega * a.omega).max(0.0)
}

fn resistance(wheel: &Wheel<f64>) -> f64 {
    TRACTION * wheel.speed.abs() + VISCOUS * wheel.speed.powi(2)
}

fn with_motors(point: &Point) -> f64 {
    let wheel = |wheel: &Wheel<f64>| {
        let current = FRICTION_CURRENT * wheel.direction + INERTIA_CURRENT * wheel.inertial_torque;
        resistance(wheel) + WINDING * current * current
    };
    kinetic(point) + point.wheels.iter().map(wheel).sum::<f64>()
}

#[test]
fn wahab_recovers_its_constants() {
    recovers(&WAHAB, &drive(2000, with_motors), &WITH_MOTORS, WITHIN);
}

#[test]
fn datouo_recovers_its_constants_on_three_omni_wheels() {
    let omni = Kinematics::omni(0.05, 0.15).unwrap();
    recovers(&DATOUO, &drive_on(&omni, 2000, with_motors), &WITH_MOTORS, WITHIN);
}

#[test]
fn hou_recovers_its_constants_on_four_mecanum_wheels() {
    let mecanum = Kinematics::mecanum(0.05, 0.2, 0.15).unwrap();
    recovers(&HOU, &drive_on(&mecanum, 2000, with_motors), &WITH_MOTORS, WITHIN);
}

#[test]
fn dogru_recovers_scrub_and_slope() {
    let husky = Kinematics::differential(0.165, 1.07).unwrap().with_scrub(true);
    let points = drive_on(&husky, 2000, |point| {
        // Each side bears half of the scrub while the robot turns.
        let turns = f64::from(point.speed.omega.abs() > 1e-12);
        let side = (point.wheels[1].speed - point.wheels[0].speed).abs();
        let climb = 40.0 * GRAVITY * point.speed.vx * point.readings.pitch.sin();
        with_motors(point) + 3.0 * side + 0.5 * 2.0 * turns + climb
    });
    let truth: Vec<f64> = WITH_MOTORS.into_iter().chain([3.0, 0.5, 40.0]).collect();
    // A winding loss of half a watt beside scrub and climbs of dozens: the rounding is theirs.
    recovers(&DOGRU, &points, &truth, 100.0 * WITHIN);
}

#[test]
fn touzout_recovers_its_constants() {
    let points = drive(2000, |point| kinetic(point) + point.wheels.iter().map(resistance).sum::<f64>());
    recovers(&TOUZOUT, &points, &[MASS, INERTIA, TRACTION, VISCOUS], WITHIN);
}

/// Bristles integrated in many small steps between points, the wheel's speed constant within.
fn bend(before: f64, rim: f64, seconds: f64) -> f64 {
    const STEPS: u32 = 4_000;
    let step = seconds / f64::from(STEPS);
    let rate = |share: f64| (rim - rim.abs() * share) / SLIP_DEFLECTION_M;
    (0..STEPS).fold(before, |share, _| share + step * rate(share + 0.5 * step * rate(share)))
}

#[test]
fn anjum_recovers_the_stribeck_curve() {
    const RADIUS: f64 = 0.033;
    const STATIC_EXCESS: f64 = 0.03;
    const STRIBECK: f64 = 1.7;
    let mut points = drive(2000, kinetic);
    let mut shares = [0.0; 2];
    for index in 0..points.len() {
        let elapsed = if index == 0 { 0.0 } else { points[index].time - points[index - 1].time };
        let wheels = points[index].wheels;
        for (share, wheel) in shares.iter_mut().zip(wheels.iter()) {
            let after = bend(*share, RADIUS * wheel.speed, elapsed);
            let rate = if elapsed > 0.0 { (after - *share) / elapsed } else { 0.0 };
            *share = after;
            let steady = TRACTION + STATIC_EXCESS * (-(wheel.speed / STRIBECK).powi(2)).exp();
            let torque = steady * (after + DAMPING_TIME_S * rate) + VISCOUS * wheel.speed;
            points[index].power += torque * wheel.speed;
        }
    }
    // The small steps are off by (1800/4000)²/6 of what is left to bend after each, and that only
    // at the few points where a wheel reverses at a crawl.
    let truth = [MASS, INERTIA, TRACTION, STATIC_EXCESS, VISCOUS, STRIBECK];
    recovers(&ANJUM, &points, &truth, 1e-3);
}

const ALL: [&Card; 6] = [&WAHAB, &DATOUO, &HOU, &DOGRU, &TOUZOUT, &ANJUM];

#[test]
fn poor_drives_give_finite_powers() {
    predict_one_speed(&ALL);
}
