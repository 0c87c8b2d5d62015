//! Supply, static power and sensors against the very series that they change.

use super::super::super::{Kinematics, PayloadSchedule, PlantSet, ProfileKind, Scenario, Sensors, simulate};
use super::{apart, drive, steady_scenario};

#[test]
fn wrong_sensors_change_what_is_read_and_nothing_else() {
    let clean = drive(PlantSet::Servo, &[]);
    let gain = drive(PlantSet::Servo, &["sensor-gain=-0.1"]);
    let offset = drive(PlantSet::Servo, &["sensor-offset=0.05"]);
    let power_late = drive(PlantSet::Servo, &["sensor-delay=0.03"]);
    let speed_late = drive(PlantSet::Servo, &["sensor-delay=-0.03"]);
    for wrong in [&gain, &offset, &power_late, &speed_late] {
        assert_eq!(wrong.true_power_w, clean.true_power_w);
    }
    for k in 0..clean.time_s.len() {
        assert!((gain.power_w[k] - 0.9 * clean.power_w[k]).abs() < 1e-12);
        assert!((offset.power_w[k] - clean.power_w[k] - 0.05).abs() < 1e-12);
    }
    // 0.03 s are three samples.
    assert!(power_late.wheel_rad_s == clean.wheel_rad_s && speed_late.power_w == clean.power_w);
    assert!(apart(&power_late.power_w[3..], &clean.power_w) < 1e-12);
    assert!(apart(&speed_late.wheel_rad_s[0][3..], &clean.wheel_rad_s[0]) < 1e-12);
    assert!(power_late.power_w[..3] == [0.0; 3] && speed_late.wheel_rad_s[0][..3] == [0.0; 3]);
}

/// What the sensor averages is delayed, wrong and offset as what it reads at once: within its step
/// of 1.2 mW.
#[test]
fn the_averaging_sensor_is_wrong_by_as_much() {
    let run = |texts: &[&str]| {
        let mut scenario = steady_scenario([0.15, 0.0, 0.0], texts);
        scenario.sensors = Sensors { power_noise_w: 0.0, ..Sensors::servo(scenario.rate_hz) };
        scenario.static_power_w = 2.0;
        simulate(&scenario).unwrap().power_w
    };
    let (clean, wrong) = (run(&[]), run(&["sensor-gain=0.2", "sensor-offset=-0.5", "static-step=0.4:at=0"]));
    assert!(apart(&wrong, &clean.iter().map(|p| 1.2 * (p + 0.4) - 0.5).collect::<Vec<_>>()) < 2.5e-3);
}

#[test]
fn static_power_steps_with_time_or_motion() {
    let clean = drive(PlantSet::Servo, &[]);
    let added = |texts: &[&str]| -> Vec<f64> {
        let with = drive(PlantSet::Servo, texts);
        assert_eq!(with.wheel_rad_s, clean.wheel_rad_s);
        with.power_w.iter().zip(&clean.power_w).map(|(with, clean)| with - clean).collect()
    };
    for (k, added) in added(&["static-step=0.7:at=12"]).into_iter().enumerate() {
        // A reading is that of the step before it.
        assert!((added - if k > 1200 { 0.7 } else { 0.0 }).abs() < 1e-12, "{k}: {added}");
    }
    let drawn = added(&["static-step=0.7"]);
    let begin = drawn.iter().position(|&added| added > 0.35).unwrap();
    assert!((1000..3000).contains(&begin), "{begin}");
    let moving = added(&["static-step=-0.3:on=motion:hold=0"]);
    for (k, added) in moving.into_iter().enumerate() {
        let fastest = clean.wheel_rad_s.iter().map(|wheel| wheel[k].abs()).fold(0.0, f64::max);
        // Near the threshold of 0.02 rad/s a quarter of a millisecond decides.
        if !(0.01..0.03).contains(&fastest) {
            assert!((added - if fastest > 0.02 { -0.3 } else { 0.0 }).abs() < 1e-12, "{k}: {added}");
        }
    }
}

#[test]
fn the_computer_draws_by_its_load() {
    let (clean, with) = (drive(PlantSet::Servo, &[]), drive(PlantSet::Servo, &["compute-load=3"]));
    assert_eq!(clean.cpu_percent, with.cpu_percent);
    let mut steps = 0;
    for k in 1..clean.time_s.len() {
        if with.cpu_percent[k] == with.cpu_percent[k - 1] {
            let added = with.power_w[k] - clean.power_w[k];
            assert!((added - 3.0 * with.cpu_percent[k] / 100.0).abs() < 1e-12);
        } else {
            steps += 1;
        }
    }
    // Loads of 6 s on average: seven in 40 s, 2.6 more or less.
    assert!((1..16).contains(&steps), "{steps}");
    assert!(clean.cpu_percent.iter().all(|load| (5.0..=95.0).contains(load)));
}

#[test]
fn braking_power_returns_by_its_share() {
    let clean = drive(PlantSet::Gearmotor, &[]);
    let half = drive(PlantSet::Gearmotor, &["regeneration=0.5"]);
    let whole = drive(PlantSet::Gearmotor, &["regeneration=1"]);
    let mut returned = 0;
    for k in 0..clean.time_s.len() {
        assert!(whole.power_w[k] <= clean.power_w[k]);
        assert!(
            (clean.power_w[k] - half.power_w[k] - 0.5 * (clean.power_w[k] - whole.power_w[k])).abs() < 1e-12
        );
        returned += usize::from(whole.power_w[k] < -0.01);
    }
    assert!(returned > 10, "{returned}");
    let mut drives_return =
        Scenario::new(PlantSet::Gearmotor, Kinematics::Differential, ProfileKind::Training, 40.0, 4);
    drives_return.payload = PayloadSchedule::constant(3.0);
    drives_return.drive.regeneration = true;
    assert_eq!(simulate(&drives_return).unwrap().power_w, whole.power_w);
}

/// A wrong mass in the log changes the log alone, not the robot.
#[test]
fn a_mislabelled_payload_moves_as_what_it_is() {
    let wrong = drive(PlantSet::Servo, &["payload-mislabel=2"]);
    let mut heavy = Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Training, 40.0, 4);
    heavy.payload = PayloadSchedule::constant(5.0);
    let heavy = simulate(&heavy).unwrap();
    assert!(wrong.power_w == heavy.power_w && wrong.wheel_rad_s == heavy.wheel_rad_s);
    assert!(wrong.mass_kg.iter().all(|&mass| mass == 3.0));
}
