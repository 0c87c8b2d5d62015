//! Logs as robots, motor drivers and tools of other makers leave them; their files are those of
//! formats/tests/data/makers (make.py there).

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::common::Bench;

const ROBOT: &str = "\
name = \"Small\"
wheel_radius_m = 0.033
track_m = 0.160
gyration_radius_m = 0.064
mass_no_load_kg = 1.0
mass_full_load_kg = 6.0
filter_cutoff_hz = 1.0
";
const TWO: &str = "kinematics = \"differential\"\n";
/// A geared motor of seven pole pairs, and what a VESC and a mirrored ODrive say of its speed.
const VESC: &str = "[topics]
wheel_speeds = [
    { field = \"/left/sensors/core:state.speed\", unit = \"rpm\", scale = 0.14285714285714285 },
    { field = \"/right/sensors/core:state.speed\", unit = \"rpm\", scale = 0.14285714285714285 },
]
";
const ODRIVE: &str = "[topics]
wheel_speeds = [
    { field = \"/left/controller_status:vel_estimate\", unit = \"rev/s\" },
    { field = \"/right/controller_status:vel_estimate\", unit = \"rev/s\", scale = -1 },
]
";
const ROVER: &str = "[topics]
wheel_speeds = [{ field = \"ESC:RPM\", unit = \"rpm\" }, { field = \"ESC.1:RPM\", unit = \"rpm\" }]
mass = \"PLD:Mass\"
";

/// Each log, what its robot.toml says beyond the robot, and what the power is said to be.
const LOGS: [(&str, &str, &str); 11] = [
    ("turtlebot4.mcap", "", "/battery_state:voltage times −/battery_state:current"),
    (
        "odrive.mcap",
        ODRIVE,
        "/left/odrive_status:bus_voltage times /left/odrive_status:bus_current plus /right/odrive_status:bus_voltage",
    ),
    (
        "vesc.mcap",
        VESC,
        "/left/sensors/core:state.voltage_input times /left/sensors/core:state.current_input plus /right",
    ),
    (
        "clearpath.mcap",
        "",
        "measured_voltages[0] times /r_0000/platform/mcu/status/power:measured_currents[0] plus",
    ),
    (
        "jackal.mcap",
        "",
        "power_w from /r_0000/platform/mcu/status/power:measured_voltages[0] times /r_0000/platform/mcu/status/power:measured_currents[0]\n",
    ),
    ("lynx.mcap", "", "drivers[3].voltage times /r_0000/platform/motors/feedback:drivers[3].current"),
    (
        "husarion.mcap",
        "",
        "driver_states[1].state.voltage times /hardware/robot_driver_state:driver_states[1].state.current",
    ),
    ("ros1-plain.bag", "", "power_w from /power:data"),
    ("ros1-lz4.bag", "", "power_w from /power:data"),
    ("ros1-bz2.bag", "", "power_w from /power:data"),
    ("rover.bin", ROVER, "power_w from BAT:Volt times BAT:Curr"),
];

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("formats/tests/data/makers").join(name)
}

fn bench(logs: &[&str]) -> Bench {
    let bench = Bench::new();
    for log in logs {
        bench.put(log, std::fs::read(data(log)).unwrap());
    }
    bench.put("robot.toml", format!("{TWO}{ROBOT}"));
    bench
}

/// A robot.toml of a log, by its name.
fn robot(bench: &Bench, log: &str, topics: &str) -> String {
    let name = format!("{log}.robot.toml");
    bench.put(&name, format!("{TWO}{ROBOT}{topics}"));
    name
}

fn parameters(bench: &Bench, robot: &str, log: &str) -> (Vec<f64>, String) {
    let ran =
        bench.gmr(&["fit", "--robot", robot, "--out", &format!("{log}.toml"), "--json", "--verbose", log]);
    assert_eq!(ran.code, Some(0), "{log}: {}", ran.stderr);
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(report["rows"], 601, "{log}");
    let fitted = report["parameters"].as_array().unwrap();
    (fitted.iter().map(|parameter| parameter["value"].as_f64().unwrap()).collect(), ran.stderr)
}

/// Voltages, currents and most speeds have 32 bits there.
#[test]
fn the_same_drive_fits_to_the_same_coefficients_from_every_maker() {
    let bench = bench(&["drive.csv"]);
    let (expected, _) = parameters(&bench, "robot.toml", "drive.csv");
    for (log, topics, source) in LOGS {
        bench.put(log, std::fs::read(data(log)).unwrap());
        let (values, said) = parameters(&bench, &robot(&bench, log, topics), log);
        assert!(said.replace(';', "\n").contains(source), "{log}: {said}");
        assert_eq!(values.len(), expected.len(), "{log}");
        for (value, expected) in values.iter().zip(&expected) {
            assert!((value - expected).abs() <= 1e-6 * expected.abs(), "{log}: {value} {expected}");
        }
    }
}

/// `look` needs no robot.toml, `inspect` does; both see the power of the drive.
#[test]
fn every_makers_log_is_looked_at_and_inspected() {
    let bench = bench(&["drive.csv"]);
    let energy = |text: String| {
        let report: Value = serde_json::from_str(&text).unwrap();
        report["energy_j"].as_f64().unwrap_or(f64::NAN)
    };
    let expected = energy(bench.done(&["look", "--json", "drive.csv"]).stdout);
    assert!(expected > 1.0, "{expected}");
    for (log, topics, _) in LOGS {
        bench.put(log, std::fs::read(data(log)).unwrap());
        let joules = energy(bench.done(&["look", "--json", log]).stdout);
        assert!((joules - expected).abs() < 1e-6 * expected, "{log}: {joules} {expected}");
        let inspected = bench.gmr(&["inspect", "--verbose", "--robot", &robot(&bench, log, topics), log]);
        assert!(inspected.code.is_some_and(|code| code < 2), "{log}: {}", inspected.stderr);
        assert!(
            inspected.stderr.contains("601 rows on the clock"),
            "{log}: {}{}",
            inspected.stdout,
            inspected.stderr
        );
    }
}

/// Create 3 turns its orientation about an axis that points left: 0.05 rad with the nose up.
#[test]
fn pitch_comes_from_an_orientation() {
    let bench = bench(&["turtlebot4.mcap"]);
    bench.done(&["convert", "--robot", "turtlebot4", "turtlebot4.mcap", "--out", "out.csv"]);
    let text = bench.text("out.csv");
    let place = text.lines().next().unwrap().split(',').position(|name| name == "pitch_rad").unwrap();
    let pitch: f64 = text.lines().nth(10).unwrap().split(',').nth(place).unwrap().parse().unwrap();
    assert!((pitch - 0.05).abs() < 1e-12, "{pitch}");
}

/// /tf, among other transforms and through half turns, at which quaternions change their sign;
/// odometry that knows the plane only tells none.
#[test]
fn pitch_comes_from_transforms() {
    let bench = bench(&["level.mcap", "planar.mcap"]);
    let said = bench.done(&["convert", "--robot", "burger", "level.mcap", "--out", "out.csv"]).stderr;
    assert!(said.contains("pitch_rad from /tf of odom>base_link"), "{said}");
    let text = bench.text("out.csv");
    let place = text.lines().next().unwrap().split(',').position(|name| name == "pitch_rad").unwrap();
    let pitches: Vec<f64> =
        text.lines().skip(1).filter_map(|line| line.split(',').nth(place).unwrap().parse().ok()).collect();
    // None before the first transform, nor at the three half turns of 7.9 s at 2 rad/s.
    assert!(
        pitches.len() == 80 - 4 && pitches.iter().all(|pitch| (pitch - 0.05).abs() < 1e-6),
        "{pitches:?}"
    );
    bench.done(&["convert", "--robot", "burger", "planar.mcap", "--out", "planar.csv"]);
    assert!(!bench.text("planar.csv").lines().next().unwrap().contains("pitch_rad"));
}

/// Efforts are torques only where robot.toml says so.
#[test]
fn efforts_become_torques_on_request() {
    let bench = bench(&["ros1-lz4.bag"]);
    let efforts = "[topics]\ntorques = [\"/joint_states:velocity[0]\", { field = \"/joint_states:velocity[1]\", scale = -2.0 }]\n";
    let named = robot(&bench, "efforts", efforts);
    bench.done(&["convert", "--robot", &named, "ros1-lz4.bag", "--out", "with.csv"]);
    bench.done(&["convert", "ros1-lz4.bag", "--out", "without.csv"]);
    assert!(!bench.text("without.csv").contains("torque"));
    let with = bench.text("with.csv");
    assert!(
        with.starts_with("time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg,sim_torque1_nm,sim_torque2_nm\n"),
        "{with:.100}"
    );
    let row: Vec<f64> =
        with.lines().nth(100).unwrap().split(',').map(|field| field.parse().unwrap()).collect();
    assert_eq!((row[5], row[6]), (row[1], -2.0 * row[2]));
}

/// Of a whole ride over midnight; the sum of both VESCs on the bus.
#[test]
fn a_ride_that_vesc_tool_logged_is_looked_at() {
    let bench = bench(&["vesc-tool.csv", "drive.csv"]);
    let report =
        |log| -> Value { serde_json::from_str(&bench.done(&["look", "--json", log]).stdout).unwrap() };
    let (ride, expected) = (report("vesc-tool.csv"), report("drive.csv"));
    for key in ["energy_j", "duration_s"] {
        let number = |report: &Value| report[key].as_f64().unwrap();
        assert!((number(&ride) - number(&expected)).abs() < 1e-6 * number(&expected), "{key}: {ride}");
    }
    let straight = "[topics]\nwheel_speeds = [{ field = \"vesc:erpm\", unit = \"rpm\" }, { field = \"vesc:erpm\", unit = \"rpm\" }]\n";
    bench.done(&[
        "convert",
        "--robot",
        &robot(&bench, "vesc", straight),
        "vesc-tool.csv",
        "--out",
        "out.csv",
    ]);
    assert_eq!(bench.text("out.csv").lines().count(), 602);
}

/// One line each, with what to do.
#[test]
fn what_a_makers_log_lacks_is_said_with_the_remedy() {
    let bench = bench(&[
        "odrive.mcap",
        "vesc.mcap",
        "turtlebot4.mcap",
        "clearpath.mcap",
        "ros1-lz4.bag",
        "rover.bin",
    ]);
    bench.put("old.bag", b"#ROSBAG V1.2\n and so on");
    let product = |what: &str| format!("[topics]\npower = [{what}]\n");
    let cases = [
        (
            "vesc.mcap",
            String::new(),
            "say wheel_speeds = [{ field = \"/left/sensors/core:state.speed\", unit = \"rpm\"",
        ),
        (
            "odrive.mcap",
            product("{ voltage = \"/left/odrive_status:bus_voltage\" }"),
            "lacks its current; expected",
        ),
        (
            "odrive.mcap",
            product(
                "{ voltage = \"/left/odrive_status:volts\", current = \"/left/odrive_status:bus_current\" }",
            ),
            "has no number volts; it has: bus_voltage",
        ),
        (
            "odrive.mcap",
            product("{ voltage = 12.5, current = \"/middle/odrive_status:bus_current\" }"),
            "has no topic /middle/odrive_status; it has: /",
        ),
        (
            "odrive.mcap",
            product("{ field = \"/left/odrive_status:bus_voltage\", unit = \"V\" }"),
            "expected of W, mW, kW",
        ),
        ("turtlebot4.mcap", product("\"/wheel_status:current\""), "has no number current; it has: "),
        (
            "clearpath.mcap",
            "[topics]\nwheel_speeds = [\"/r_0000/platform/joint_states:velocity[0]\"]\n".to_owned(),
            "expected 2, one a wheel",
        ),
        (
            "clearpath.mcap",
            "[topics]\ntorques = [\"/r_0000/platform/joint_states:effort[0]\"]\n".to_owned(),
            "1 torques; expected 2",
        ),
        (
            "ros1-lz4.bag",
            "[topics]\npower = \"/powr:data\"\n".to_owned(),
            "has no topic /powr; it has: /power, ",
        ),
        ("rover.bin", ROVER.replace("ESC.1", "ESC.2"), "has no topic ESC.2; it has: ESC.1, "),
        ("rover.bin", ROVER.replace("RPM", "Rpm"), "has no number Rpm; it has: RPM"),
        ("old.bag", String::new(), "expected 2.0 (rosbag migrate)"),
    ];
    for (log, topics, expected) in cases {
        // Without wheels that are found by themselves the speeds have to be named first.
        let named = if topics.contains("power") && log == "odrive.mcap" {
            format!("{ODRIVE}{}", topics.trim_start_matches("[topics]\n"))
        } else {
            topics.clone()
        };
        let robot = robot(&bench, "wrong", &named);
        let ran = bench.gmr(&["fit", "--robot", &robot, "--out", "out.toml", log]);
        assert_eq!(ran.code, Some(1), "{log} {topics}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{log} {topics}: {}", ran.stderr);
        assert!(!bench.path("out.toml").exists(), "{log}");
    }
}

/// A recorder that was killed leaves no index.
#[test]
fn cut_logs_are_refused_and_read_on_request() {
    let bench = bench(&[]);
    for (log, topics) in [("ros1-plain.bag", ""), ("ros1-lz4.bag", ""), ("rover.bin", ROVER)] {
        let bytes = std::fs::read(data(log)).unwrap();
        bench.put(log, &bytes[..bytes.len() * 6 / 10]);
        let robot = robot(&bench, log, topics);
        let refused = bench.gmr(&["convert", "--robot", &robot, log, "--out", "out.csv", "--force"]);
        assert_eq!(refused.code, Some(1), "{log}: {}", refused.stderr);
        assert!(refused.stderr.contains("--allow-truncated reads"), "{log}: {}", refused.stderr);
        assert_eq!(refused.stderr.lines().count(), 1, "{log}: {}", refused.stderr);
        bench.done(&["convert", "--robot", &robot, "--allow-truncated", log, "--out", "out.csv", "--force"]);
        let rows = bench.text("out.csv").lines().count();
        // LZ4 makes so little of the messages that their index alone is cut off.
        assert!((100..=602).contains(&rows), "{log}: {rows}");
    }
}
