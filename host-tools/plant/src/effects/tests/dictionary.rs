//! What holds for every effect: its size, its time, its seed, and what is refused.

use super::super::super::{
    Kinematics, PayloadSchedule, PlantSet, ProfileKind, Record, Scenario, Sensors, simulate,
};
use super::super::{Effect, entries};
use super::{apart, drive, steady_scenario};

/// Until it begins, an effect is not there.
#[test]
fn effects_begin_when_told() {
    let clean = drive(PlantSet::Gearmotor, &[]);
    for entry in entries().filter(|entry| entry.options.iter().any(|choice| choice.name == "at")) {
        let size = 0.3 * entry.range.1;
        let with = drive(PlantSet::Gearmotor, &[&format!("{}={size}:at=20", entry.id)]);
        assert_eq!(with.power_w[..2000], clean.power_w[..2000], "{}", entry.id);
        assert_eq!(with.wheel_rad_s[0][..2000], clean.wheel_rad_s[0][..2000], "{}", entry.id);
        assert_ne!(with.power_w[2000..], clean.power_w[2000..], "{}", entry.id);
    }
}

fn noisy(kinematics: Kinematics, effects: &[Effect], seed: u64) -> Record {
    let mut scenario = Scenario::new(PlantSet::Servo, kinematics, ProfileKind::Training, 20.0, seed);
    scenario.payload = PayloadSchedule::constant(3.0);
    scenario.sensors = Sensors::servo(scenario.rate_hz);
    scenario.effects = effects.to_vec();
    simulate(&scenario).unwrap()
}

/// Whatever an effect does it does by its size.
#[test]
fn an_effect_of_size_0_changes_not_a_byte() {
    for kinematics in [Kinematics::Differential, Kinematics::Skid, Kinematics::Omni, Kinematics::Mecanum] {
        let clean = noisy(kinematics, &[], 6);
        for entry in entries() {
            assert!(noisy(kinematics, &[Effect::new(entry.id, 0.0).unwrap()], 6) == clean, "{}", entry.id);
        }
    }
}

/// All at once, in either order: the same run for the same seed.
#[test]
fn the_same_seed_gives_the_same_run() {
    let mut all: Vec<Effect> =
        entries().map(|entry| Effect::new(entry.id, 0.02 * entry.range.1).unwrap()).collect();
    let first = noisy(Kinematics::Differential, &all, 3);
    assert!(first == noisy(Kinematics::Differential, &all, 3));
    assert!(first != noisy(Kinematics::Differential, &all, 4));
    // Sums in a different order differ by rounding; random onsets stay with their effects.
    all.retain(|effect| effect.option("at").is_some() || effect.id() == "sensor-delay");
    let first = noisy(Kinematics::Differential, &all, 3);
    all.reverse();
    assert!(apart(&first.true_power_w, &noisy(Kinematics::Differential, &all, 3).true_power_w) < 1e-6);
}

#[test]
fn what_makes_no_sense_is_refused_by_name() {
    for (text, named) in [
        ("slope=1", "effect `slope`; allowed: grade, winding-temperature, windage"),
        ("grade", "allowed: ID=SIZE"),
        ("grade=", "effect grade=; allowed: -0.3 to 0.3 (slope angle, rad)"),
        ("grade=0.31", "effect grade=0.31; allowed: -0.3 to 0.3"),
        ("grade=nan", "allowed: -0.3 to 0.3"),
        ("stribeck=-0.1", "allowed: 0 to 0.5"),
        ("grade=0.1:side=left", "option `side`; allowed: along, heading, at"),
        ("wheel-drag=0.1:side=up", "side=up; allowed: left, right"),
        ("stribeck=0.1:width=0", "width=0; allowed: 0.05 to 20"),
        ("sensor-delay=0.1:at=3", "option `at`; allowed: none"),
    ] {
        let error = Effect::parse(text).unwrap_err();
        assert_eq!(error.exit_code(), 2, "{text}");
        assert!(error.to_string().contains(named), "{text}: {error}");
    }
    // What only the robot can tell.
    for (text, named) in [
        ("wheel-drag=0.1:wheel=3", "wheel=3; allowed: 1 to 2"),
        ("wheel-drag=0.1:wheel=1.5", "wheel=1.5; allowed: 1 to 2"),
        ("payload-offset=0.09", "a wheel would lift off"),
        ("payload-mislabel=-3", "the noted mass is 3 kg"),
        ("winding-temperature=-5", "cannot cool"),
    ] {
        let error = simulate(&steady_scenario([0.1, 0.0, 0.0], &[text])).unwrap_err();
        assert_eq!(error.exit_code(), 2, "{text}");
        assert!(error.to_string().contains(named), "{text}: {error}");
    }
    let mut smooth = steady_scenario([0.1, 0.0, 0.0], &["surface-switch=-0.02"]);
    smooth.robot.wheels[1].rolling_resistance = 0.01;
    assert!(simulate(&smooth).unwrap_err().to_string().contains("the robot's coefficient is 0.01"));
    let mut returns = steady_scenario([0.1, 0.0, 0.0], &["regeneration=1"]);
    returns.drive.regeneration = true;
    assert!(simulate(&returns).unwrap_err().to_string().contains("return all of it already"));
}
