//! Laws that the whole plant has to keep, against figures derived by hand.

use super::body::{Body, Wheel};
use super::*;

const ALL: [Kinematics; 4] =
    [Kinematics::Differential, Kinematics::Skid, Kinematics::Omni, Kinematics::Mecanum];

/// A body whose rolling resistance has the torque `rolling`, N·m per wheel, at 1 kg.
fn bench(set: PlantSet, rolling: f64) -> Body {
    let mut robot = Robot::new(set, Kinematics::Differential);
    for wheel in &mut robot.wheels {
        // μ_r = torque / (m g share r)
        wheel.rolling_resistance = rolling / (9.80665 * 0.5 * 0.033);
    }
    Body::new(robot.geometry, robot.gyration_radius_m, robot.wheels)
}

/// A robot without motors and friction.
pub(super) fn free(kinematics: Kinematics) -> (Robot, Body) {
    let mut robot = Robot::new(PlantSet::Servo, kinematics);
    for Wheel { motor, rolling_resistance, .. } in &mut robot.wheels {
        (motor.torque_constant, motor.coulomb, motor.viscous, motor.rotor_inertia) = (0.0, 0.0, 0.0, 0.0);
        *rolling_resistance = 0.0;
    }
    let body = Body::new(robot.geometry, robot.gyration_radius_m, robot.wheels);
    (robot, body)
}

#[test]
fn the_servo_meets_its_no_load_and_stall_figures() {
    // XL430-W250 at 11.1 V: 57 rev/min without load, 1.3 A and 1.4 N·m at stall.
    let mut free = bench(PlantSet::Servo, 0.0);
    let mut held = bench(PlantSet::Servo, 1.401);
    let mut overcome = bench(PlantSet::Servo, 1.399);
    for _ in 0..8000 {
        for body in [&mut free, &mut held, &mut overcome] {
            body.step(&[11.1; MAX_WHEELS], 1.0, 0.25e-3);
        }
    }
    // After 2 s, a hundred time constants of 20 ms, nothing but rounding is left.
    let no_load = 57.0 * std::f64::consts::TAU / 60.0;
    assert!((free.wheel_speeds()[0] / no_load - 1.0).abs() < 1e-9, "{}", free.wheel_speeds()[0]);
    assert!((free.currents()[0] / 0.05 - 1.0).abs() < 1e-9);
    assert!(held.wheel_speeds()[0].abs() < 1e-9, "{}", held.wheel_speeds()[0]);
    assert!((held.currents()[0] / 1.3 - 1.0).abs() < 1e-9);
    assert!(overcome.wheel_speeds()[0] > 1e-3, "{}", overcome.wheel_speeds()[0]);
}

/// By hand, per motor at 0.2 m/s (w = 6.0606 rad/s, shaft 1566.67 rad/s), rolling torque 0.032 m g
/// r / 2:
///
/// - 1 kg: 5.1779e-3 N·m at the wheel, 2.6707e-5 at the shaft with 75 %, viscous 3.1333e-4, so
///   9.1902 mA; 2 · 9.1902 mA · (0.75 Ω · 9.1902 mA + 0.0072 · 1566.67) = 0.207460 W.
/// - 6 kg: six times the rolling torque: 12.7993 mA, 0.289003 W.
#[test]
fn the_table_3_plant_draws_the_power_derived_by_hand() {
    for (mass, by_hand) in [(1.0, 0.207_460), (6.0, 0.289_003)] {
        let kind = ProfileKind::Constant;
        let mut scenario = Scenario::new(PlantSet::Table3, Kinematics::Differential, kind, 40.0, 1);
        let Robot { geometry, limits, .. } = scenario.robot;
        scenario.profile = Profile::constant(&geometry, &limits, [0.2, 0.0, 0.0]);
        scenario.payload = PayloadSchedule::constant(mass);
        let record = simulate(&scenario).unwrap();
        let settled = &record.power_w[1000..];
        let mean = settled.iter().sum::<f64>() / settled.len() as f64;
        // Loop noise of 1.4 mW over 3000 samples: 0.03 mW, three of them and the hand's rounding.
        assert!((mean - by_hand).abs() < 1e-4, "{mass} kg: {mean} W, by hand {by_hand} W");
    }
}

/// Energy into the windings = copper + friction + gear + rolling losses + change of stored energy.
///
/// The mechanical step keeps this to rounding. What is left is back EMF taken at a predicted
/// instead of the true mid-step speed, which errs by h/2 times the change of acceleration from one
/// step to the next. Loop noise of 1.4e-3 rad/s moves voltages by 3 mV and accelerations by 0.06
/// rad/s²: 8e-6 rad/s, 1e-6 of the speed, of either sign. Hence 1e-6 of the energy; dropping any
/// loss or the prediction misses it by orders of magnitude.
#[test]
fn no_energy_is_lost_or_made_in_the_servo_plant() {
    for kinematics in ALL {
        let mut scenario = Scenario::new(PlantSet::Servo, kinematics, ProfileKind::Training, 60.0, 3);
        // A smooth floor, so that the payload drives the gears when the robot brakes.
        for wheel in &mut scenario.robot.wheels {
            wheel.rolling_resistance = 0.005;
        }
        let robot = &scenario.robot;
        let (count, mass, h) = (robot.geometry.wheels(), 4.0, 0.25e-3);
        let mut body = Body::new(robot.geometry, robot.gyration_radius_m, robot.wheels);
        let mut controllers = [controller::Controller::default(); MAX_WHEELS];
        let (mut voltage, mut cursor) = ([0.0; MAX_WHEELS], 0);
        let (mut input, mut lost, mut back_driven) = (0.0, 0.0, 0.0);
        for k in 0..240_000_u32 {
            let before = body.wheel_speeds();
            if k % 4 == 0 {
                let time = f64::from(k) * h;
                let target = scenario.profile.wheel_speeds_at(&robot.geometry, time, &mut cursor);
                for i in 0..count {
                    let noise = 2e-3 * f64::from(k % 7).sin();
                    voltage[i] =
                        controllers[i].update(&robot.gains, target[i], before[i] + noise, 12.0, 1e-3);
                }
            }
            let steps = body.step(&voltage, mass, h);
            let after = body.wheel_speeds();
            for i in 0..count {
                let (step, Wheel { motor, gear, .. }) = (steps[i], robot.wheels[i]);
                let middle = 0.5 * (before[i] + after[i]);
                input += step.voltage * step.current.mean * h;
                let copper = motor.resistance_ohm * step.current.mean_square;
                let viscous = motor.drag(gear.ratio * step.predicted_speed) * gear.ratio * middle;
                let shaft_friction = step.friction_share * motor.coulomb * gear.ratio * middle;
                let gear_loss = step.shaft_torque * (gear.ratio - step.torque_gain) * middle;
                let rolling = step.friction_share * body.rolling_torque(i, mass) * middle;
                // But for rounding and for the one step in which a wheel stops or turns back, whose
                // mean speed has not the sign that friction and gear saw at its end.
                let turning = before[i] * after[i] > 0.0 && after[i].abs() > 1e-3;
                let smallest = shaft_friction.min(rolling).min(gear_loss);
                assert!(!turning || smallest >= -1e-9, "{kinematics:?}: a loss of {smallest} W gives power");
                back_driven += if step.torque_gain > gear.ratio { h } else { 0.0 };
                lost += (copper + viscous + shaft_friction + gear_loss + rolling) * h;
            }
        }
        let [x, y, turn] = body.twist();
        let mut stored = 0.5 * mass * (x * x + y * y + (0.06 * turn).powi(2));
        for i in 0..count {
            let Wheel { motor, gear, .. } = robot.wheels[i];
            stored += 0.5 * motor.rotor_inertia * (gear.ratio * body.wheel_speeds()[i]).powi(2);
            stored += 0.5 * motor.inductance_h * body.currents()[i].powi(2);
        }
        let error = (input - lost - stored) / input;
        assert!(back_driven > 1.0, "{kinematics:?}: gears back-driven for {back_driven} s only");
        assert!(
            error.abs() < 1e-6,
            "{kinematics:?}: {input} J in, {lost} J lost, {stored} J stored: {error}"
        );
    }
}

/// Root mean square difference of two series, relative to the root mean square of the second.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    (square / b.iter().map(|b| b * b).sum::<f64>()).sqrt()
}

/// A method of at least first order halves its error when the step is halved: the differences
/// between successive halvings fall by 2 or more (0.6 allows for the noise that the loop adds).
#[test]
fn halving_the_step_converges() {
    for set in [PlantSet::Table3, PlantSet::Servo] {
        let runs = [0.5e-3, 0.25e-3, 0.125e-3, 0.0625e-3].map(|step_s| {
            let kind = ProfileKind::Training;
            let base = Scenario::new(set, Kinematics::Differential, kind, 60.0, 5);
            simulate(&Scenario { step_s, ..base }).unwrap()
        });
        let power = [0, 1, 2].map(|i| difference(&runs[i].power_w, &runs[i + 1].power_w));
        let speed = [0, 1, 2].map(|i| difference(&runs[i].wheel_rad_s[0], &runs[i + 1].wheel_rad_s[0]));
        for errors in [power, speed] {
            assert!(errors[1] < 0.6 * errors[0] && errors[2] < 0.6 * errors[1], "{set:?}: {errors:?}");
        }
        // What is left at the default step, 0.25 ms: about twice the difference to the next
        // halving.
        assert!(power[1] < 1e-3 && speed[1] < 1e-6, "{set:?}: power {power:?}, speed {speed:?}");
    }
}

#[test]
fn a_robot_at_rest_rests_and_draws_nothing() {
    for kinematics in ALL {
        for set in [PlantSet::Table3, PlantSet::Servo] {
            let still = Scenario::new(set, kinematics, ProfileKind::Standstill, 10.0, 1);
            let record = simulate(&still).unwrap();
            assert!(record.power_w.iter().all(|&p| p == 0.0));
            assert!(record.wheel_rad_s.iter().flatten().all(|&w| w == 0.0));

            // Up to speed within 1 s, down again from 3 s to 4 s: from 4.5 s on at rest to the last
            // digit of a log.
            let mut stop = still.clone();
            let twists = [[0.0; 3], [0.1, 0.0, 0.3], [0.1, 0.0, 0.3], [0.0; 3]];
            stop.profile = Profile::from_twists([0.0, 1.0, 3.0, 4.0].into_iter().zip(twists));
            let record = simulate(&stop).unwrap();
            assert!(record.power_w[200..300].iter().all(|&p| p > 0.01), "{set:?} {kinematics:?}");
            assert!(record.power_w[450..].iter().all(|&p| p < 1e-9), "{set:?} {kinematics:?}");
            assert!(record.wheel_rad_s.iter().all(|wheel| wheel[450..].iter().all(|w| w.abs() < 1e-9)));
        }
    }
}

/// Left and right exchanged, without noise: the same power, wheels exchanged. Sums run in a
/// different order, and a gear near zero torque may then pick the other direction, hence a little
/// more than rounding.
#[test]
fn a_mirrored_drive_draws_the_same_power() {
    for kinematics in ALL {
        let mut scenario = Scenario::new(PlantSet::Servo, kinematics, ProfileKind::Training, 60.0, 2);
        scenario.robot.loop_noise_rad_s = 0.0;
        scenario.payload = PayloadSchedule::parse("2@0,5@30").unwrap();
        let straight = simulate(&scenario).unwrap();
        scenario.profile = scenario.profile.mirrored(&scenario.robot.geometry);
        let mirrored = simulate(&scenario).unwrap();
        let error = difference(&straight.power_w, &mirrored.power_w);
        assert!(error < 1e-6, "{kinematics:?}: {error}");
        for k in 0..straight.time_s.len() {
            let mut speeds = [0.0; MAX_WHEELS];
            for (speed, column) in speeds.iter_mut().zip(&straight.wheel_rad_s) {
                *speed = column[k];
            }
            let expected = scenario.robot.geometry.mirrored(speeds);
            for (column, expected) in mirrored.wheel_rad_s.iter().zip(expected) {
                assert!((column[k] - expected).abs() < 1e-6);
            }
        }
    }
}

/// Without motors and friction an omni robot that spins keeps its velocity over ground: seen from
/// the body it turns backwards. The explicit force errs by ω² t h / 2 = 5e-4 of the speed after 1 s
/// at 2 rad/s.
#[test]
fn a_free_body_keeps_its_velocity_over_ground() {
    let (_, mut body) = free(Kinematics::Omni);
    body.set_twist([0.2, 0.0, 2.0]);
    for _ in 0..4000 {
        body.step(&[0.0; MAX_WHEELS], 3.0, 0.25e-3);
    }
    let [x, y, turn] = body.twist();
    assert!((turn - 2.0).abs() < 1e-12);
    assert!((x - 0.2 * 2.0_f64.cos()).abs() < 2e-4 && (y + 0.2 * 2.0_f64.sin()).abs() < 2e-4, "{x} {y}");
}

#[test]
fn the_same_seed_gives_the_same_run_and_another_another() {
    let run = |seed| {
        let kind = ProfileKind::Training;
        let mut scenario = Scenario::new(PlantSet::Servo, Kinematics::Differential, kind, 20.0, seed);
        scenario.sensors = Sensors::servo(scenario.rate_hz);
        simulate(&scenario).unwrap()
    };
    assert_eq!(run(1), run(1));
    assert!(difference(&run(1).power_w, &run(2).power_w) > 0.1);
}

/// Each noise has its own stream: power noise leaves the motion as it was.
#[test]
fn sensors_do_not_disturb_the_plant() {
    let kind = ProfileKind::Test;
    let exact = Scenario::new(PlantSet::Servo, Kinematics::Differential, kind, 20.0, 4);
    let mut noisy = exact.clone();
    noisy.sensors.power_noise_w = 0.1;
    noisy.sensors.power_autocorrelation = 0.6;
    let (exact, noisy) = (simulate(&exact).unwrap(), simulate(&noisy).unwrap());
    assert_eq!(exact.wheel_rad_s, noisy.wheel_rad_s);
    assert_eq!(exact.true_power_w, noisy.true_power_w);
    assert_ne!(exact.power_w, noisy.power_w);
}

#[test]
fn braking_power_returns_only_with_regeneration() {
    let run = |regeneration| {
        let kind = ProfileKind::Training;
        let mut scenario = Scenario::new(PlantSet::Table3, Kinematics::Differential, kind, 100.0, 4);
        scenario.drive.regeneration = regeneration;
        simulate(&scenario).unwrap()
    };
    assert!(run(false).power_w.iter().all(|&p| p >= 0.0));
    assert!(run(true).power_w.iter().any(|&p| p < -0.1));
}

#[test]
fn jitter_moves_the_instants_and_keeps_their_order() {
    let mut scenario =
        Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Training, 20.0, 1);
    scenario.sensors.jitter_s = 1e-3;
    let times = simulate(&scenario).unwrap().time_s;
    let off: Vec<f64> = (0..).zip(&times).map(|(k, t)| t - f64::from(k) * 0.01).collect();
    let rms = (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt();
    // 2000 draws: ±1.6 % standard error; clipping at 3 σ takes 0.7 %, rounding to 0.25 ms adds
    // 0.3 %.
    assert!((rms / 1e-3 - 1.0).abs() < 0.06, "{rms}");
    assert!(times.windows(2).all(|pair| pair[1] > pair[0]));
}

/// Rigid rolling: the four wheels of a skid-steered or mecanum robot have only two or three
/// freedoms.
#[test]
fn redundant_wheels_stay_coupled() {
    let run = |kinematics| {
        simulate(&Scenario::new(PlantSet::Servo, kinematics, ProfileKind::Training, 30.0, 1)).unwrap()
    };
    let skid = run(Kinematics::Skid).wheel_rad_s;
    assert!(skid[0] == skid[2] && skid[1] == skid[3]);
    let mecanum = run(Kinematics::Mecanum).wheel_rad_s;
    let [front_left, front_right, rear_left, rear_right] = &mecanum[..] else { panic!("four wheels") };
    let front = front_left.iter().zip(front_right).map(|(l, r)| l + r);
    let rear = rear_left.iter().zip(rear_right).map(|(l, r)| l + r);
    // The sums agree for every twist.
    assert!(front.zip(rear).all(|(front, rear)| (front - rear).abs() < 1e-9));
}
