//! `gmr inspect` as users run it: figures, findings, bad input and exit codes.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;

use crate::common::{excerpt, whole_data};

fn gmr(arguments: &[&str]) -> Output {
    Command::cargo_bin("gmr").unwrap().arg("inspect").args(arguments).output().unwrap()
}

fn json(robot: &str, log: &Path) -> Value {
    let output = gmr(&["--robot", robot, "--json", log.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

struct Log {
    folder: tempfile::TempDir,
    path: PathBuf,
}

fn log(content: &str) -> Log {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    std::fs::write(&path, content).unwrap();
    Log { folder, path }
}

/// The one line on standard error for a bad log, behind its path; nothing on standard output, no
/// figure written.
fn complaint(content: &str) -> String {
    let log = log(content);
    let figure = log.folder.path().join("figure.svg");
    let path = log.path.to_str().unwrap();
    let output = gmr(&["--robot", "burger", "--plot", figure.to_str().unwrap(), path]);
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty() && !figure.exists());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(text.lines().count(), 1, "one clear line: {text}");
    text.trim_end().split_once("run.csv").expect("the file is named").1.to_owned()
}

const HEADER: &str = "time_s,wheel1_rad_s,wheel2_rad_s,power_w\n";

/// Rows of a drive at 50 Hz: ramps to two speeds, turns, stops, power from speed and acceleration
/// with a little noise.
fn drive(seconds: f64, mass: impl Fn(f64) -> Option<f64>) -> String {
    let mut text = "time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg\n".to_owned();
    for row in 0..(seconds * 50.0) as u64 {
        let time = row as f64 / 50.0;
        let phase = time % 20.0;
        let ramp = if phase < 5.0 { 0.0 } else { (phase - 5.0).min(1.0).min((20.0 - phase).max(0.0)) };
        let speed = ramp * if time % 40.0 < 20.0 { 3.0 } else { 6.0 };
        let right = if phase > 12.0 { 0.5 * speed } else { speed };
        let noise = 0.02 * ((row * 7919 % 101) as f64 / 50.0 - 1.0);
        let mass = mass(time).map_or(String::new(), |mass| mass.to_string());
        writeln!(text, "{time:.3},{speed:.5},{right:.5},{:.4},{mass}", 0.4 * speed + noise).unwrap();
    }
    text
}

fn texts(report: &Value) -> String {
    let findings = report["findings"].as_array().unwrap();
    findings.iter().map(|finding| finding["text"].as_str().unwrap()).collect::<Vec<_>>().join("\n")
}

#[test]
fn bad_logs_get_one_clear_line_and_exit_code_1() {
    let start = format!("{HEADER}0,1,1,1\n0.1,1,1,1\n");
    let expected = ":1: column power_w is missing; the log has: time_s, wheel1_rad_s, wheel2_rad_s";
    assert_eq!(complaint("time_s,wheel1_rad_s,wheel2_rad_s\n0,1,1\n1,1,1\n"), expected);
    let expected = ":4:power_w: \"high\" is not a number; expected a number";
    assert_eq!(complaint(&format!("{start}0.2,1,1,high\n")), expected);
    let expected = ":4:time_s: time 0.05 follows 0.1; expected time to increase from row to row (sort the rows, or tell runs apart by a column run)";
    assert_eq!(complaint(&format!("{start}0.05,1,1,1\n")), expected);
    assert_eq!(complaint(""), ": is empty; expected a run log: a CSV header and at least two rows");
    assert_eq!(complaint(HEADER), ": the log has no row to use; expected at least two");
    let one = format!("{HEADER}0,1,1,1\n");
    assert_eq!(complaint(&one), ": the log has only one row to use; expected at least two");
    let expected =
        ":1: the log has 3 wheel speed columns, but robot TurtleBot3 Burger has 2 wheels: wrong robot?";
    assert_eq!(
        complaint("time_s,wheel1_rad_s,wheel2_rad_s,wheel3_rad_s,power_w\n0,1,1,1,1\n1,1,1,1,1\n"),
        expected
    );
    let expected =
        ":1: column wheel2_rad_s is missing; the log has: time_s, wheel1_rad_s, wheel3_rad_s, power_w";
    assert_eq!(complaint("time_s,wheel1_rad_s,wheel3_rad_s,power_w\n0,1,1,1\n1,1,1,1\n"), expected);
}

#[test]
fn paths_that_do_not_exist_and_wrong_usage_have_their_exit_codes() {
    let output = gmr(&["--robot", "burger", "no/such/run.csv"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("gmr: no/such/run.csv: No such file"));
    let log = log(&format!("{HEADER}0,1,1,1\n1,1,1,1\n"));
    let path = log.path.to_str().unwrap();
    assert_eq!(gmr(&["--robot", "burgr", path]).status.code(), Some(2), "a robot that does not exist");
    assert_eq!(gmr(&["--robot", "burger", "--plot", "figure.pdf", path]).status.code(), Some(2), "a format");
    assert_eq!(gmr(&[]).status.code(), Some(2), "no log");
}

#[test]
fn what_is_left_out_is_counted() {
    let mut text = drive(60.0, |_| Some(1.0));
    text.push_str("60.00,0,0,NaN,1\n60.02,0,0,,1\n60.04,0,0,0,1\n60.06,0,0,0.");
    let report = json("burger", &log(&text).path);
    assert_eq!(report["exclusions"]["non_finite"], 2);
    assert_eq!(report["exclusions"]["first_non_finite_line"], 3002);
    assert_eq!(report["exclusions"]["cut_line"], 1);
    assert_eq!(report["rows"], 3001);
    assert!(
        texts(&report)
            .contains("excluded 2 rows with NaN, inf or no value (first: line 3002) and 1 last line")
    );
}

#[test]
fn a_good_drive_is_described() {
    let report = json("burger", &log(&drive(200.0, |time| Some(if time < 100.0 { 1.0 } else { 6.0 }))).path);
    assert_eq!(report["rows"], 10_000);
    assert!((report["rate_hz"].as_f64().unwrap() - 50.0).abs() < 1e-6);
    assert_eq!(report["standstill_from"], "wheel speeds");
    let states = report["static_states"].as_array().unwrap();
    assert_eq!(states.len(), 1, "{states:?}");
    assert!(states[0]["mean_w"].as_f64().unwrap().abs() < 0.01);
    let excitation = &report["excitation"];
    assert!((excitation["share_moving"].as_f64().unwrap() - 0.75).abs() < 0.02, "{excitation}");
    assert!(excitation["share_straight"].as_f64().unwrap() > 0.3, "{excitation}");
    assert!(excitation["share_turning"].as_f64().unwrap() > 0.3, "{excitation}");
    assert_eq!(excitation["payloads"][1]["mass_kg"], 6.0);
    assert_eq!(excitation["payloads"][1]["share"], 0.5);
    // Ramps of 3 and 6 rad/s², the inner wheel's half as steep, in 2 of 15 s.
    let steep = excitation["acceleration_quantiles_rad_s2"][1].as_f64().unwrap();
    assert!((2.9..6.2).contains(&steep), "{excitation}");
    let accelerating = excitation["share_accelerating"].as_f64().unwrap();
    assert!((accelerating - 2.0 / 15.0).abs() < 0.03, "{excitation}");
    let findings = report["findings"].as_array().unwrap();
    assert!(findings.iter().all(|finding| finding["severity"] == "note"), "{findings:?}");
    assert!(texts(&report).contains("two payloads: the signed torque model is determined"));
}

#[test]
fn what_a_fit_would_miss_is_said() {
    let one = json("burger", &log(&drive(200.0, |_| Some(1.0))).path);
    assert!(texts(&one).contains("one payload only: a0 (Coulomb torque) and a1"), "{}", texts(&one));
    let none = json("burger", &log(&drive(200.0, |_| None)).path);
    assert!(texts(&none).contains("mass_kg holds no number"), "{}", texts(&none));

    let mut constant = HEADER.to_owned();
    let mut standing = HEADER.to_owned();
    let mut fast = HEADER.to_owned();
    let mut slow = HEADER.to_owned();
    let mut negative = HEADER.to_owned();
    for row in 0..500 {
        let (time, noise) = (f64::from(row) * 0.02, f64::from(row % 7) * 0.001);
        writeln!(constant, "{time},3.{row:03},3,{}", 1.0 + noise).unwrap();
        writeln!(standing, "{time},0,0,{}", 8.0 + noise).unwrap();
        writeln!(fast, "{time},{},900,1", 900.0 + noise).unwrap();
        writeln!(slow, "{},{},3,1", 10.0 * time, 3.0 + noise).unwrap();
        writeln!(negative, "{time},{},3,{}", 3.0 + noise, -1.0 + noise).unwrap();
    }
    let cases = [
        (constant, "constant speed only"),
        (standing, "the robot never moves"),
        (fast, "drives at 29.7 m/s"),
        (slow, "sample rate 5.0 Hz is low"),
        (negative, "power_w is negative in 100 % of the moving rows"),
    ];
    for (text, expected) in cases {
        let report = json("burger", &log(&text).path);
        let findings = texts(&report);
        assert!(findings.contains(expected), "expected {expected:?}, found:\n{findings}");
    }
}

#[test]
fn total_power_is_recognised_and_states_are_told_from_wheels() {
    // Standing at 8.6 W, after 60 s at 9.7 W; the drive adds to it.
    let actuation = drive(120.0, |_| Some(1.0));
    let mut text = HEADER.to_owned();
    for line in actuation.lines().skip(1) {
        let fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        let level = if fields[0] < 60.0 { 8.6 } else { 9.7 };
        writeln!(text, "{},{},{},{}", fields[0], fields[1], fields[2], fields[3] + level).unwrap();
    }
    let report = json("burger", &log(&text).path);
    let states = report["static_states"].as_array().unwrap();
    let means: Vec<f64> = states.iter().map(|state| state["mean_w"].as_f64().unwrap()).collect();
    assert_eq!(means.len(), 2, "{means:?}");
    assert!((means[0] - 8.6).abs() < 0.02 && (means[1] - 9.7).abs() < 0.02, "{means:?}");
    assert!(states.iter().all(|state| state["moving"] == "no"));
    assert!(texts(&report).contains("power_w is total power (8.60 W standing)"), "{}", texts(&report));
}

#[test]
fn gaps_jitter_spikes_and_stuck_sensors_are_found() {
    let mut text = HEADER.to_owned();
    let mut time = 0.0;
    for row in 0..3000 {
        time += match row {
            1000 => 2.0,
            2000 => 1.0,
            _ => 0.02 + 0.001 * f64::from(row % 3 - 1),
        };
        let speed = 3.0 + 2.0 * (0.02 * f64::from(row)).sin();
        // Wheel 2 hangs from row 1200 on.
        let other = 3.0 + 2.0 * (0.02 * f64::from(row.min(1200))).sin();
        let noise = 0.05 * (f64::from(row * 7919 % 101) / 50.0 - 1.0);
        let power = if row == 500 { 60.0 } else { 2.0 + 0.1 * speed + noise };
        writeln!(text, "{time:.4},{speed:.5},{other:.5},{power:.4}").unwrap();
    }
    let report = json("burger", &log(&text).path);
    assert_eq!(report["gap_count"], 2);
    assert_eq!(report["gaps"][0]["line"], 1002);
    assert!((report["jitter"]["std_s"].as_f64().unwrap() - 0.000_816).abs() < 2e-5, "{}", report["jitter"]);
    assert!((report["jitter"]["min_s"].as_f64().unwrap() - 0.019).abs() < 2e-4);
    let power = &report["outliers"][0];
    assert_eq!(
        (&power["quantity"], &power["count"], &power["greatest_line"]),
        (&"power_w".into(), &1.into(), &502.into())
    );
    let stuck = report["stuck"].as_array().unwrap();
    assert_eq!(stuck.len(), 1, "{stuck:?}");
    assert_eq!(stuck[0]["column"], "wheel2_rad_s");
    assert!((stuck[0]["total_s"].as_f64().unwrap() - 36.0).abs() < 0.5, "{stuck:?}");
}

#[test]
fn steps_of_quantisation_are_no_outliers() {
    let mut text = HEADER.to_owned();
    for row in 0..5000 {
        let speed = 5.0 + (0.002 * f64::from(row)).sin();
        writeln!(text, "{:.2},{speed:.3},{speed:.3},{:.2}", f64::from(row) * 0.02, 0.5 * speed).unwrap();
    }
    let report = json("burger", &log(&text).path);
    for outliers in report["outliers"].as_array().unwrap() {
        assert_eq!(outliers["count"], 0, "{outliers}");
    }
}

#[test]
fn figures_are_drawn_and_people_get_one_screen() {
    let log = log(&drive(60.0, |_| Some(1.0)));
    for name in ["figure.svg", "figure.png"] {
        let figure = log.folder.path().join(name);
        let output =
            gmr(&["--robot", "burger", "-v", "--plot", figure.to_str().unwrap(), log.path.to_str().unwrap()]);
        assert!(output.status.success());
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.lines().count() <= 40, "{text}");
        assert!(text.contains("Static power, standstill told from wheel speeds:"), "{text}");
        assert!(figure.metadata().unwrap().len() > 2000);
    }
}

#[test]
fn static_states_of_a_measured_turtlebot3_are_found() {
    static_states(&excerpt("turtlebot3/spin_baseline_1.csv"), [8.62, 9.74], 10.73);
}

#[test]
fn static_states_of_whole_measured_logs_are_found() {
    let Some(data) = whole_data() else { return };
    let cases = [
        ("spin_baseline_1.csv", [8.62, 9.74], 10.73),
        ("spin_baseline_2.csv", [8.62, 9.74], 10.73),
        ("spin_camera_switched_1.csv", [7.82, 8.95], 10.73),
    ];
    for (name, standing, spinning) in cases {
        static_states(&data.join("turtlebot3").join(name), standing, spinning);
    }
}

/// Standby, standing with torque and spin: means over ten runs in the data's own description, the
/// camera off in the one that switches it. Single runs differ by 0.1 W from those.
fn static_states(path: &Path, standing: [f64; 2], spinning: f64) {
    let name = path.display();
    let report = json("burger", path);
    assert_eq!(report["standstill_from"], "power");
    let means = |key: &str| -> Vec<f64> {
        let states = report[key].as_array().unwrap();
        states.iter().map(|state| state["mean_w"].as_f64().unwrap()).collect()
    };
    let levels = means("static_states");
    assert_eq!(levels.len(), 2, "{name}: {levels:?}");
    for (mean, expected) in levels.iter().zip(standing) {
        assert!((mean - expected).abs() < 0.15, "{name}: {levels:?}");
    }
    let moving = means("moving_levels");
    assert!(moving.iter().any(|mean| (mean - spinning).abs() < 0.2), "{name}: {moving:?}");
    let std = report["static_states"][0]["std_w"].as_f64().unwrap();
    assert!((0.4..0.6).contains(&std), "{name}: {std}");
}

#[test]
fn pieces_of_measured_logs_are_inspected() {
    inspect_all(&excerpt(""));
}

#[test]
fn all_measured_logs_are_inspected() {
    let Some(data) = whole_data() else { return };
    inspect_all(&data);
}

fn inspect_all(data: &Path) {
    let mut inspected = 0;
    for (robot, folder) in [("burger", "turtlebot3"), ("warthog", "warthog"), ("husky", "husky-currents")] {
        for entry in std::fs::read_dir(data.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "csv") {
                continue;
            }
            let report = json(robot, &path);
            assert!(report["rows"].as_u64().unwrap() > 50);
            inspected += 1;
        }
    }
    assert!(inspected >= 6, "{inspected}");
}
