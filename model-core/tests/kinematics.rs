//! Laws of the wheels' geometry: twists worked out by hand, and M'' as the body's kinetic energy.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use model_core::kinematics::{InvalidLength, Kinematics, Twist};
use proptest::prelude::*;

/// Few roundings of numbers near 1.
const ROUNDING: f64 = 1e-14;

fn assert_twist<const N: usize>(
    kinematics: &Kinematics<f64, N>,
    wheels: [f64; N],
    vx: f64,
    vy: f64,
    omega: f64,
) {
    let twist = kinematics.twist(&wheels);
    let off = (twist.vx - vx).abs() + (twist.vy - vy).abs() + (twist.omega - omega).abs();
    assert!(off < ROUNDING, "{wheels:?}: {twist:?}, expected {vx} {vy} {omega}");
}

/// Radius 0.1 m: 10 rad/s is 1 m/s at the rim. A track of 0.5 m: rims at ∓0.5 m/s turn it at 1 m/s
/// / 0.5 m = 2 rad/s.
#[test]
fn differential_by_hand() {
    let robot = Kinematics::differential(0.1, 0.5).unwrap();
    assert_twist(&robot, [10.0, 10.0], 1.0, 0.0, 0.0);
    assert_twist(&robot, [-5.0, 5.0], 0.0, 0.0, 2.0);
    // About the standing left wheel.
    assert_twist(&robot, [0.0, 10.0], 0.5, 0.0, 2.0);
}

#[test]
fn skid_steer_by_hand() {
    let robot = Kinematics::skid_steer(0.1, 0.5).unwrap();
    assert_twist(&robot, [10.0; 4], 1.0, 0.0, 0.0);
    assert_twist(&robot, [-5.0, 5.0, -5.0, 5.0], 0.0, 0.0, 2.0);
}

/// Forward is between the wheels at ±60°, whose rims then run at cos 30° = √3/2 of the speed, the
/// left one's backwards, the rear wheel's at none; to the left the rear wheel's rim runs at −1 of
/// the speed, the others' at 1/2 of it.
#[test]
fn omni_by_hand() {
    let robot = Kinematics::omni(0.1, 0.2).unwrap();
    let half_root = 3.0_f64.sqrt() / 2.0;
    assert_twist(&robot, [-10.0 * half_root, 0.0, 10.0 * half_root], 1.0, 0.0, 0.0);
    assert_twist(&robot, [5.0, -10.0, 5.0], 0.0, 1.0, 0.0);
    assert_twist(&robot, [4.0; 3], 0.0, 0.0, 2.0);
}

/// Arm 0.3 m + 0.2 m: rims at 1 m/s turn it at 2 rad/s. To the left the front left wheel runs back,
/// the front right forward, the rear ones the other way round.
#[test]
fn mecanum_by_hand() {
    let robot = Kinematics::mecanum(0.1, 0.3, 0.2).unwrap();
    assert_twist(&robot, [10.0; 4], 1.0, 0.0, 0.0);
    assert_twist(&robot, [-10.0, 10.0, 10.0, -10.0], 0.0, 1.0, 0.0);
    assert_twist(&robot, [-10.0, 10.0, -10.0, 10.0], 0.0, 0.0, 2.0);
}

#[test]
fn impossible_lengths_are_named() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let named = |name| Some(InvalidLength { name });
        assert_eq!(Kinematics::differential(bad, 1.0).err(), named("wheel_radius_m"));
        assert_eq!(Kinematics::differential(1.0, bad).err(), named("track_m"));
        assert_eq!(Kinematics::skid_steer(bad, 1.0).err(), named("wheel_radius_m"));
        assert_eq!(Kinematics::skid_steer(1.0, bad).err(), named("track_m"));
        assert_eq!(Kinematics::omni(1.0, bad).err(), named("arm_m"));
        assert_eq!(Kinematics::mecanum(1.0, bad, 1.0).err(), named("half_length_m"));
        assert_eq!(Kinematics::mecanum(1.0, 1.0, bad).err(), named("half_width_m"));
        let robot = Kinematics::differential(1.0, 1.0).unwrap();
        assert_eq!(robot.mass_matrix(bad).err(), named("gyration_radius_m"));
    }
    assert!(Kinematics::from_rows([[0.0; 2]; 3]).is_err());
    assert!(Kinematics::from_rows([[f64::NAN, 1.0], [0.0; 2], [0.0; 2]]).is_err());
}

/// ½ m wᵀ M'' w is ½ m (vx² + vy²) + ½ m k² ω², M'' is symmetric and wᵀ M'' w never negative.
fn assert_kinetic_energy<const N: usize>(
    robot: &Kinematics<f64, N>,
    wheels: &[f64; N],
    gyration_radius: f64,
) -> Result<(), TestCaseError> {
    let matrix = robot.mass_matrix(gyration_radius).unwrap();
    for i in 0..N {
        for j in 0..N {
            prop_assert_eq!(matrix.rows()[i][j], matrix.rows()[j][i]);
        }
    }
    let momentum = matrix.torque_per_kg(wheels);
    let at_wheels: f64 = wheels.iter().zip(momentum).map(|(w, k)| w * k).sum();
    let Twist { vx, vy, omega } = robot.twist(wheels);
    let of_body = vx * vx + vy * vy + (gyration_radius * omega).powi(2);
    // Rounding is relative to the terms of the sums, which may cancel: no larger than with all
    // speeds positive.
    let size: f64 = matrix.rows().iter().flatten().map(|entry| entry.abs()).sum();
    let scale = size * wheels.iter().map(|w| w * w).fold(0.0, f64::max);
    prop_assert!((at_wheels - of_body).abs() <= 1e-14 * scale, "{} {}", at_wheels, of_body);
    prop_assert!(at_wheels >= -1e-14 * scale);
    Ok(())
}

fn speeds<const N: usize>() -> impl Strategy<Value = [f64; N]> {
    proptest::array::uniform(-20.0..20.0_f64)
}

proptest! {
    #[test]
    fn kinetic_energy_at_the_wheels(
        two in speeds::<2>(), three in speeds::<3>(), four in speeds::<4>(),
        r in 0.01..0.5_f64, l in 0.05..1.5_f64, b in 0.05..1.5_f64, k in 0.01..1.0_f64,
        given in proptest::array::uniform3(speeds::<5>()), five in speeds::<5>(),
    ) {
        assert_kinetic_energy(&Kinematics::differential(r, l).unwrap(), &two, k)?;
        assert_kinetic_energy(&Kinematics::omni(r, l).unwrap(), &three, k)?;
        assert_kinetic_energy(&Kinematics::skid_steer(r, l).unwrap(), &four, k)?;
        assert_kinetic_energy(&Kinematics::mecanum(r, l, b).unwrap(), &four, k)?;
        assert_kinetic_energy(&Kinematics::from_rows(given).unwrap(), &five, k)?;
    }

    /// Rim speeds by geometry: wheel i at angle θ on an arm L drives along (−sin θ, cos θ), so it
    /// has to run at (−sin θ vx + cos θ vy + L ω) / r.
    #[test]
    fn omni_inverts_the_geometry(
        vx in -2.0..2.0_f64, vy in -2.0..2.0_f64, omega in -3.0..3.0_f64, r in 0.02..0.2_f64, arm in 0.1..0.5_f64,
    ) {
        let wheels = [60.0, 180.0, 300.0_f64].map(|degrees| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            (-sin * vx + cos * vy + arm * omega) / r
        });
        let twist = Kinematics::omni(r, arm).unwrap().twist(&wheels);
        // Condition: rims carry arm ω, at most 1.5 m/s, beside v; ω is the rims' mean over the arm,
        // at least 0.1 m.
        prop_assert!((twist.vx - vx).abs() < 1e-13 && (twist.vy - vy).abs() < 1e-13, "{:?}", twist);
        prop_assert!((twist.omega - omega).abs() < 1e-12, "{:?}", twist);
    }

    /// A mecanum wheel grips along the axis of the roller on the ground: (1, −1)/√2 front left and
    /// rear right, (1, 1)/√2 at the others (the rollers on top, seen from above, lie the other way
    /// and form the X). Along it the speed of the wheel's centre is that of the rim: ux ∓ uy = r w.
    #[test]
    fn mecanum_inverts_the_geometry(
        vx in -2.0..2.0_f64, vy in -2.0..2.0_f64, omega in -3.0..3.0_f64,
        r in 0.02..0.2_f64, length in 0.1..0.5_f64, width in 0.1..0.5_f64,
    ) {
        let corners = [(length, width, -1.0), (length, -width, 1.0), (-length, width, 1.0), (-length, -width, -1.0)];
        let wheels = corners.map(|(x, y, lean)| {
            let (ux, uy) = (vx - omega * y, vy + omega * x);
            (ux + lean * uy) / r
        });
        let twist = Kinematics::mecanum(r, length, width).unwrap().twist(&wheels);
        prop_assert!((twist.vx - vx).abs() < 1e-13 && (twist.vy - vy).abs() < 1e-13, "{:?}", twist);
        prop_assert!((twist.omega - omega).abs() < 1e-12, "{:?}", twist);
    }

    #[test]
    fn four_skidding_wheels_with_equal_sides_are_two(
        sides in speeds::<2>(), r in 0.01..0.5_f64, track in 0.05..1.5_f64, k in 0.01..1.0_f64,
    ) {
        let [left, right] = sides;
        let (two, four) = (Kinematics::differential(r, track).unwrap(), Kinematics::skid_steer(r, track).unwrap());
        let (of_two, of_four) = (two.twist(&sides), four.twist(&[left, right, left, right]));
        // Four roundings more, of the larger side.
        let rounding = 4.0 * f64::EPSILON * r * (1.0 + 1.0 / track) * left.abs().max(right.abs());
        prop_assert!((of_two.vx - of_four.vx).abs() <= rounding);
        prop_assert!((of_two.omega - of_four.omega).abs() <= rounding);
        // Half of the torque of a side at each of its wheels.
        let torque = two.mass_matrix(k).unwrap().torque_per_kg(&sides);
        let torques = four.mass_matrix(k).unwrap().torque_per_kg(&[left, right, left, right]);
        let scale = r * r * (1.0 + (k / track).powi(2)) * 20.0;
        for (i, of_four) in torques.iter().enumerate() {
            prop_assert!((2.0 * of_four - torque[i % 2]).abs() <= 1e-14 * scale, "{:?} {:?}", torques, torque);
        }
    }
}
