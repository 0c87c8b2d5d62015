//! Bags, ULog and Parquet in the place of CSV, in every command; their files are those of
//! formats/tests/data (make.py there).

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::common::Bench;

const FORMATS: [&str; 6] =
    ["drive.csv", "drive.mcap", "second.mcap", "drive.db3", "drive.ulg", "drive.parquet"];

/// PX4 has no messages of power and mass with 64 bits; those of the ULog are named here.
const ROBOT: &str = "\
name = \"TurtleBot3 Burger\"
kinematics = \"differential\"
wheel_radius_m = 0.033
track_m = 0.160
gyration_radius_m = 0.064
mass_no_load_kg = 1.0
mass_full_load_kg = 6.0
filter_cutoff_hz = 1.0
";
const PX4: &str = "
[topics]
power = \"drive_power:power_w\"
mass = \"payload:mass_kg\"
";

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("formats/tests/data").join(name)
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT);
    bench.put("px4.toml", format!("{ROBOT}{PX4}"));
    bench
}

fn robot(log: &str) -> &'static str {
    if log.ends_with(".ulg") { "px4.toml" } else { "robot.toml" }
}

fn copy(bench: &Bench, name: &str) {
    bench.put(name, std::fs::read(data(name)).unwrap());
}

/// Times differ by what each format rounds them to, half a nanosecond; everything else is the same
/// number. Every further digit of a parameter would be that rounding's.
#[test]
fn the_same_drive_fits_to_the_same_coefficients_in_every_format() {
    let bench = bench();
    let mut parameters: Vec<Vec<f64>> = Vec::new();
    for log in FORMATS {
        copy(&bench, log);
        let out = format!("{log}.toml");
        let ran = bench.gmr(&["fit", "--robot", robot(log), "--out", &out, "--json", log]);
        assert_eq!(ran.code, Some(0), "{log}: {}", ran.stderr);
        let report: Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!(report["rows"], 1201, "{log}");
        let fitted = report["parameters"].as_array().unwrap();
        parameters.push(fitted.iter().map(|parameter| parameter["value"].as_f64().unwrap()).collect());
    }
    for (log, values) in FORMATS.iter().zip(&parameters) {
        assert_eq!(values.len(), parameters[0].len(), "{log}");
        for (value, expected) in values.iter().zip(&parameters[0]) {
            assert!((value - expected).abs() <= 1e-6 * expected.abs(), "{log}: {value} {expected}");
        }
    }
}

/// As a third writer of MCAP leaves it, ROS 1's messages among them: the bytes are those of the
/// same rows as text.
#[test]
fn every_form_of_mcap_becomes_the_same_text() {
    let bench = bench();
    copy(&bench, "drive.csv");
    let head: String = bench.text("drive.csv").split_inclusive('\n').take(201).collect();
    bench.put("head.csv", head);
    bench.done(&["convert", "head.csv", "--out", "expected.csv"]);
    for log in ["core-zstd.mcap", "core-bare.mcap", "core-plain.mcap", "core-ros1.mcap"] {
        copy(&bench, log);
        bench.done(&["convert", "--robot", "robot.toml", log, "--out", "found.csv", "--force"]);
        assert!(bench.text("found.csv") == bench.text("expected.csv"), "{log}");
    }
}

/// What other commands do with a bag is what they do with its rows.
#[test]
fn every_command_reads_a_bag_as_its_rows() {
    let bench = bench();
    copy(&bench, "drive.csv");
    copy(&bench, "drive.mcap");
    let fit = bench.gmr(&["fit", "--robot", "robot.toml", "--out", "c.toml", "drive.csv"]);
    assert_eq!(fit.code, Some(0), "{}", fit.stderr);
    let commands: [&[&str]; 3] = [
        &["inspect", "--robot", "robot.toml", "--json"],
        &["estimate", "--robot", "robot.toml", "--coeffs", "c.toml", "--json"],
        &["compare", "--robot", "robot.toml", "--models", "signed,linear", "--json", "--train"],
    ];
    for command in commands {
        let of = |log: &str| {
            let mut arguments = [command, &[log][..]].concat();
            if command[0] == "compare" {
                arguments.extend(["--test", log]);
            }
            let ran = bench.gmr(&arguments);
            (ran.code, ran.stdout.replace(log, "LOG"), ran.stderr)
        };
        let (from_text, from_bag) = (of("drive.csv"), of("drive.mcap"));
        assert_eq!(from_text.0, from_bag.0, "{command:?}: {}", from_bag.2);
        let numbers = |text: &str| -> Vec<f64> {
            text.split(|c: char| !matches!(c, '0'..='9' | '.' | '-' | 'e'))
                .filter_map(|word| word.parse().ok())
                .collect()
        };
        let (expected, read) = (numbers(&from_text.1), numbers(&from_bag.1));
        assert_eq!(expected.len(), read.len(), "{command:?}");
        let seconds = |command: &[&str]| command[0] == "compare";
        let differ =
            expected.iter().zip(&read).filter(|(a, b)| (*a - *b).abs() > 1e-6 * a.abs().max(1e-3)).count();
        // Each model's row says how long its fit took.
        assert!(differ == 0 || (seconds(command) && differ <= 8), "{command:?}: {differ}");
    }
}

/// Each robot's bag by its defaults: the speeds are those of the drive that it was made of,
/// averaged over the wheels of a side.
#[test]
fn bags_of_known_robots_need_no_topics() {
    let bench = bench();
    copy(&bench, "drive.csv");
    let drive = bench.text("drive.csv");
    let expected: Vec<Vec<f64>> = numbers(&drive);
    for log in ["odometry.mcap", "clearpath.mcap", "husarion.db3"] {
        copy(&bench, log);
        let ran = bench.gmr(&["convert", log, "--out", "out.csv", "--force"]);
        assert_eq!(ran.code, Some(0), "{log}: {}", ran.stderr);
        assert!(ran.stderr.contains("power_w from"), "{}", ran.stderr);
        let rows = numbers(&bench.text("out.csv"));
        assert_eq!(rows.len(), 400, "{log}");
        for (row, expected) in rows.iter().zip(&expected) {
            // The odometry has gone through the kinematics and back.
            assert!((row[1] - expected[1]).abs() < 1e-12 && (row[2] - expected[2]).abs() < 1e-12, "{log}");
        }
        assert!(rows[4][3].is_finite(), "{log}");
    }
    // Power of a battery every 0.2 s, of floats of four bytes.
    assert!((numbers(&bench.text("out.csv"))[4][3] - expected[4][3]).abs() < 1e-6);
}

fn numbers(csv: &str) -> Vec<Vec<f64>> {
    csv.lines()
        .skip(1)
        .map(|line| line.split(',').map(|field| field.parse().unwrap_or(f64::NAN)).collect())
        .collect()
}

/// From bag to Parquet to MCAP to CSV: the numbers are those of the bag, and two logs are two runs.
#[test]
fn a_log_survives_every_format_it_is_converted_to() {
    let bench = bench();
    copy(&bench, "drive.mcap");
    for (from, to) in
        [("drive.mcap", "a.parquet"), ("a.parquet", "b.mcap"), ("b.mcap", "c.csv"), ("drive.mcap", "d.csv")]
    {
        let ran = bench.gmr(&["convert", from, "--out", to]);
        assert_eq!(ran.code, Some(0), "{from}: {}", ran.stderr);
    }
    assert_eq!(bench.text("c.csv"), bench.text("d.csv"));
    let ran = bench.gmr(&["convert", "c.csv", "d.csv", "--out", "both.csv", "--json"]);
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(report["rows"], 2402, "{}", ran.stderr);
    assert!(bench.text("both.csv").lines().last().unwrap().ends_with(",d"));
}

/// One line each, with the exit code of its kind, and no file left behind.
#[test]
fn what_cannot_be_read_is_said_in_one_line() {
    let bench = bench();
    for log in ["drive.mcap", "turtlebot3.mcap", "compressed.db3"] {
        copy(&bench, log);
    }
    let bytes = std::fs::read(data("drive.mcap")).unwrap();
    bench.put("cut.mcap", &bytes[..bytes.len() / 2]);
    bench.put("packed.mcap", [&[0x28, 0xB5, 0x2F, 0xFD][..], &[0; 100]].concat());
    bench.put("ros1.bag", b"#ROSBAG V2.0\n and so on");
    bench.put("wrong.toml", format!("{ROBOT}\n[topics]\npower = \"/powr:data\"\n"));
    bench.put("field.toml", format!("{ROBOT}\n[topics]\npower = \"/power:watts\"\n"));
    bench.put("key.toml", format!("{ROBOT}\n[topics]\npowre = \"/power:data\"\n"));
    let cases: [(&str, &str, u8, &str); 9] = [
        (
            "robot.toml",
            "turtlebot3.mcap",
            1,
            "turtlebot3.mcap: the current of /battery_state is 0 or missing in all its messages",
        ),
        (
            "robot.toml",
            "compressed.db3",
            1,
            "compressed.db3: topic /odom: its messages are compressed one by one",
        ),
        ("robot.toml", "cut.mcap", 1, "cut.mcap: ends before its format does"),
        (
            "robot.toml",
            "packed.mcap",
            1,
            "packed.mcap: is compressed as a whole (zstd); expected the log itself (zstd -d FILE)",
        ),
        ("robot.toml", "ros1.bag", 1, "ros1.bag: is no ROS 1 file that can be read"),
        ("wrong.toml", "drive.mcap", 1, "drive.mcap: has no topic /powr; it has: /power, "),
        ("field.toml", "drive.mcap", 1, "has no number watts; it has: data"),
        ("key.toml", "drive.mcap", 1, "[topics]: unknown field `powre`"),
        ("robot.toml", "drive.mcap", 2, "drive.mcap: is to be written, but read as well"),
    ];
    for (robot, log, code, expected) in cases {
        let out = if code == 2 { log } else { "out.csv" };
        let ran = bench.gmr(&["convert", "--robot", robot, log, "--out", out]);
        assert_eq!(ran.code, Some(i32::from(code)), "{log}: {}", ran.stderr);
        assert_eq!(ran.stderr.lines().count(), 1, "{log}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{log}: {}", ran.stderr);
        assert!(!bench.path("out.csv").exists(), "{log}");
    }
    let ran = bench.gmr(&["convert", "--allow-truncated", "cut.mcap", "--out", "out.csv"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stderr.contains("what comes before is used"), "{}", ran.stderr);
    assert!(bench.text("out.csv").lines().count() > 400);
}
