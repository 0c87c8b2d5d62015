//! Slopes, friction and off-centre loads against energy and rigid bodies.

use super::super::super::body::{Body, Loads};
use super::super::super::tests::free;
use super::super::super::{Kinematics, MAX_WHEELS, PlantSet, Robot};
use super::{G, steady};

/// On a plane that rises by φ towards a direction, a robot at the bearing θ from it has its nose up
/// by asin(sin φ cos θ).
#[test]
fn the_pitch_follows_the_heading() {
    let record = steady([0.0, 0.0, 1.0], &["grade=0.1:heading=0.5"]);
    let mut turned = 0.0;
    for ((left, right), pitch) in
        record.wheel_rad_s[0].iter().zip(&record.wheel_rad_s[1]).zip(&record.pitch_rad)
    {
        turned += (right - left) * 0.033 / 0.16 * 0.01;
        // Rectangles of 10 ms miss a hundredth of the ramp's rad/s at most.
        assert!((pitch - (0.1_f64.sin() * (turned - 0.5).cos()).asin()).abs() < 1.5e-3, "{pitch} {turned}");
    }
    assert!(turned > 15.0);
}

/// Nothing but gravity: from rest, over s metres down a slope, v² = 2 g s sin φ; the plane keeps
/// the energy.
#[test]
fn gravity_gives_what_the_height_is_worth() {
    let (robot, mut body) = free(Kinematics::Differential);
    let force = [-3.0 * G * 0.2_f64.sin(), 0.0, 0.0];
    body.meet(&robot.wheels, &Loads { force, ..Loads::default() });
    for _ in 0..4000 {
        body.step(&[0.0; MAX_WHEELS], 3.0, 0.25e-3);
    }
    // After 1 s: v = g sin φ, s = v/2.
    assert!((body.twist()[0] + G * 0.2_f64.sin()).abs() < 1e-9);
}

/// A coasting robot slows down by everything that rubs, never speeds up, and stops for good.
#[test]
fn friction_only_takes() {
    let robot = Robot::new(PlantSet::Gearmotor, Kinematics::Differential);
    let mut wheels = robot.wheels;
    for wheel in &mut wheels {
        wheel.motor.torque_constant = 0.0;
        wheel.motor.windage = 1e-8;
    }
    let loads = Loads { wheel_friction: [0.02, 0.03, 0.0, 0.0], turning_friction: 0.05, ..Loads::default() };
    for twist in [[0.5, 0.0, 0.0], [0.0, 0.0, 4.0], [-0.3, 0.0, 2.0]] {
        let mut body = Body::new(robot.geometry, robot.gyration_radius_m, robot.wheels);
        body.meet(&wheels, &loads);
        body.set_twist(twist);
        let energy = |body: &Body| {
            let [x, _, turn] = body.twist();
            let rotors: f64 = body.wheel_speeds()[..2].iter().map(|w| 0.5 * 2e-6 * (30.0 * w).powi(2)).sum();
            0.5 * 2.0 * (x * x + (0.06 * turn).powi(2)) + rotors
        };
        let mut last = energy(&body);
        for _ in 0..8000 {
            body.step(&[0.0; MAX_WHEELS], 2.0, 0.25e-3);
            let now = energy(&body);
            assert!(now <= last + 1e-12, "{now} after {last}");
            last = now;
        }
        assert!(last < 1e-15, "{last}");
    }
}

/// A mass m beside the axle's middle by y: pushed straight, a free robot turns as a rigid body does
/// about its centre of mass, at F y / (m k²), towards the mass.
#[test]
fn an_off_centre_mass_turns_a_pushed_robot() {
    let (robot, mut body) = free(Kinematics::Omni);
    body.meet(&robot.wheels, &Loads { force: [0.5, 0.0, 0.0], offset_m: 0.02, ..Loads::default() });
    body.step(&[0.0; MAX_WHEELS], 3.0, 0.25e-3);
    let alpha = 0.5 * 0.02 / (3.0 * 0.06 * 0.06);
    let [ahead, aside, turn] = body.twist();
    assert!((turn / 0.25e-3 - alpha).abs() < 1e-9, "{turn}");
    assert!((ahead / 0.25e-3 - (0.5 / 3.0 + 0.02 * alpha)).abs() < 1e-9 && aside == 0.0);
}
