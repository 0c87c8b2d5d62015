//! robot.toml: what loads, what is refused and how.

use logs::robot::{Geometry, Robot};
use support::context::Context;

const BURGER: &str = "name = \"b\"\nkinematics = \"differential\"\nwheel_radius_m = 0.033\ntrack_m = 0.16\n\
                      mass_no_load_kg = 1\nmass_full_load_kg = 6\n";

fn message(text: &str) -> String {
    let error = Robot::parse(text).expect_err("the robot is wrong");
    assert_eq!(error.exit_code(), 1);
    let text = error.in_file("robot.toml").to_string();
    assert_eq!(text.lines().count(), 1, "one clear line: {text}");
    text
}

/// `BURGER` with the line of `key` replaced.
fn with(key: &str, line: &str) -> String {
    BURGER.lines().filter(|old| !old.starts_with(key)).chain([line]).collect::<Vec<_>>().join("\n")
}

#[test]
fn built_in_robots_load_by_lenient_names() {
    for name in
        ["burger", "Burger", "turtlebot3-burger", "TurtleBot3_Burger", "warthog", "husky", "husky-a200"]
    {
        assert_eq!(Robot::load(&Context::default(), name).unwrap().wheels(), 2, "{name}");
    }
    let burger = Robot::named("burger").unwrap();
    assert_eq!(*burger.geometry(), Geometry::DifferentialDrive { wheel_radius_m: 0.033, track_m: 0.16 });
    assert!(!burger.power_is_total(), "logs of the simulator hold actuation power");
    assert!(burger.sensors().is_some());
    assert!(Robot::named("warthog").unwrap().regeneration());
    for robot in ["burger", "warthog", "husky"] {
        assert!(Robot::load(&Context::default(), robot).unwrap().unknown_keys().is_empty(), "{robot}");
    }
}

#[test]
fn what_is_no_robot_says_so() {
    let error = Robot::load(&Context::default(), "burgr").unwrap_err();
    assert_eq!(error.exit_code(), 2, "a name that does not exist is wrong usage");
    assert!(error.to_string().contains("expected burger, turtlebot4, warthog, husky or the path"), "{error}");
    let error = Robot::load(&Context::default(), "no/such/robot.toml").unwrap_err();
    assert_eq!(error.exit_code(), 1);
    assert!(error.to_string().starts_with("no/such/robot.toml: "), "{error}");
}

#[test]
fn defaults_are_the_documented_ones() {
    let robot = Robot::parse(BURGER).unwrap();
    assert_eq!(robot.mape_floor_w(), 0.1);
    assert_eq!(robot.speed_dead_band_rad_s(), 0.02);
    assert!(robot.gyration_is_estimated() && (robot.gyration_radius_m() - 0.4 * 0.16).abs() < 1e-15);
    assert!(!robot.regeneration() && !robot.power_is_total() && robot.filter_cutoff_hz().is_none());
    let total = Robot::parse(&format!("{BURGER}static_power_w = 8.6\n")).unwrap();
    assert!(total.power_is_total());
}

#[test]
fn all_kinematics_are_known_by_their_usual_names() {
    let masses =
        "mass_no_load_kg = 1\nmass_full_load_kg = 6\nwheel_radius_m = 0.05\ngyration_radius_m = 0.1\n";
    let cases = [
        ("diff-drive", "track_m = 0.2", 2, 2),
        ("Differential Drive", "track_m = 0.2", 2, 2),
        ("skid_steer", "track_m = 0.2", 2, 2),
        ("skid-steer", "track_m = 0.2\nwheels = 4", 4, 2),
        ("omni3", "arm_m = 0.1", 3, 3),
        ("three-wheel-omni", "arm_m = 0.1", 3, 3),
        ("mecanum", "half_length_m = 0.1\nhalf_width_m = 0.1", 4, 3),
        ("four-mecanum", "half_length_m = 0.1\nhalf_width_m = 0.1", 4, 3),
        ("matrix", "matrix = [[0.02, 0.02], [-0.2, 0.2]]", 2, 2),
        ("matrix", "matrix = [[1, 2, 3, 4, 5], [1, 2, 3, 4, 5], [1, 2, 3, 4, 5]]", 5, 3),
    ];
    for (name, rest, wheels, components) in cases {
        let robot = Robot::parse(&format!("kinematics = \"{name}\"\n{masses}{rest}\n")).unwrap();
        assert_eq!((robot.wheels(), robot.geometry().twist_components()), (wheels, components), "{name}");
    }
}

#[test]
fn what_is_wrong_is_named_with_line_and_column() {
    let expected = "robot.toml:6:11: track_m = -0.16; expected a number above 0";
    assert_eq!(message(&with("track_m", "track_m = -0.16")), expected);
    let expected = "6:11: track_m = NaN; expected a number above 0";
    assert!(message(&with("track_m", "track_m = nan")).contains(expected));
    assert!(
        message(&with("track_m", "track_m = \"wide\"")).contains("track_m = \"wide\"; expected a number")
    );
    assert!(message(&with("name", "name = 3")).contains("name = 3; expected text in quotes"));
    let expected = "mass_full_load_kg = 1; expected a number above mass_no_load_kg = 1";
    assert!(message(&with("mass_full", "mass_full_load_kg = 1")).contains(expected));
    assert!(message(&with("name", "regeneration = 1")).contains("regeneration = 1; expected true or false"));
    let legs = with("kinematics", "kinematics = \"legs\"");
    assert!(message(&legs).contains("expected differential, skid-steer,"));
    let broken = message("name = \"b\"\ntrack_m = = 1\n");
    assert!(broken.starts_with("robot.toml:2:11: "), "broken TOML has a place too: {broken}");
    let three = with("kinematics", "kinematics = \"skid\"\nwheels = 3");
    assert!(message(&three).contains("wheels = 3; expected 2 "));
    let ragged = with("kinematics", "kinematics = \"matrix\"\ngyration_radius_m = 1\nmatrix = [[1, 2], [1]]");
    assert!(message(&ragged).contains("expected 2 rows (vx, omega) or 3 rows"));
}

#[test]
fn a_missing_key_says_what_these_kinematics_need() {
    let expected = "robot.toml: key track_m is missing; these kinematics need wheel_radius_m, track_m, \
                    mass_no_load_kg, mass_full_load_kg";
    assert_eq!(message(&with("track_m", "")), expected);
    assert!(message(&with("kinematics", "kinematics = \"omni3\"")).contains("key arm_m is missing"));
    assert!(message(&with("kinematics", "")).contains("key kinematics is missing; expected differential"));
}

#[test]
fn unknown_keys_are_named_and_do_no_harm() {
    let robot = Robot::parse(&format!("{BURGER}colour = \"red\"\n")).unwrap();
    let [unknown] = robot.unknown_keys() else { panic!("one key is unknown") };
    assert!(
        unknown.starts_with("7:1: unknown key colour is not used; known are name, kinematics"),
        "{unknown}"
    );
}

#[test]
fn sensors_are_free_form() {
    let table = "[sensors.power]\nchip = \"INA219\"\nrate_hz = 200";
    for sensors in ["sensors = [\"ina219\", \"xl430\"]", "sensors = 3", table] {
        let robot = Robot::parse(&format!("{BURGER}{sensors}\n")).unwrap();
        assert!(robot.sensors().is_some() && robot.unknown_keys().is_empty(), "{sensors}");
    }
}
