//! A folder to run `gmr` in, and logs that are made by the signed torque model itself.
#![allow(dead_code, reason = "every test file uses its part")]

pub(crate) mod board;
pub(crate) mod browser;
pub(crate) mod skipped;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;

use skipped::skipped;

/// A folder of its own for one test.
pub(crate) struct Bench {
    folder: tempfile::TempDir,
}

/// How a command ended.
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file.
    pub(crate) fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    /// Names of all files, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs `gmr` in the folder.
    pub(crate) fn gmr(&self, arguments: &[&str]) -> Ran {
        let output = Command::cargo_bin("gmr")
            .unwrap()
            .current_dir(self.folder.path())
            .args(arguments)
            .output()
            .unwrap();
        Ran {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs `gmr`, which has to succeed.
    pub(crate) fn done(&self, arguments: &[&str]) -> Ran {
        let ran = self.gmr(arguments);
        assert_eq!(ran.code, Some(0), "{arguments:?}: {}", ran.stderr);
        ran
    }

    /// The JSON that a command prints; it has to succeed, and what it prints has to be as
    /// docs/json.md has it.
    pub(crate) fn json(&self, arguments: &[&str]) -> Value {
        let ran = self.done(&[arguments, &["--json"]].concat());
        let report = serde_json::from_str(&ran.stdout).unwrap();
        is_documented(arguments[0], &report);
        report
    }

    /// A log of the plant.
    pub(crate) fn simulate(&self, name: &str, arguments: &[&str]) {
        self.done(&[&["simulate", "--out", name], arguments].concat());
    }
}

/// What docs/json.md says of a command's JSON.
pub(crate) fn documentation(command: &str) -> Option<String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/json.md");
    let text = std::fs::read_to_string(file).unwrap();
    let (_, behind) = text.split_once(&format!("\n## `gmr {command}`"))?;
    Some(behind.split("\n## ").next().unwrap().to_owned())
}

/// A version before all else, and no key that the documentation does not name.
pub(crate) fn is_documented(command: &str, report: &Value) {
    let said = documentation(command).unwrap_or_else(|| panic!("docs/json.md does not have gmr {command}"));
    assert_eq!(keys(report)[0], "version", "gmr {command}: {report}");
    // A VDA 5050 state has that of its protocol.
    assert!(report["version"] == 1 || report["version"] == "2.1.0", "gmr {command}: {report}");
    for key in keys(report).into_iter().skip(1) {
        assert!(said.contains(&format!("`{key}`")), "docs/json.md, gmr {command}: no {key}");
    }
}

/// The keys of a JSON object, in order.
pub(crate) fn keys(object: &Value) -> Vec<&str> {
    object.as_object().unwrap().keys().map(String::as_str).collect()
}

/// A number that has to be there.
pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("expected a number, found {value}"))
}

/// A piece of a measured log, or a folder of them, as kept in the repository:
/// `tests/data/SOURCES.md`.
pub(crate) fn excerpt(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// The folder of all measured logs, whole; `None`, and the test counted as skipped, where they are
/// not there.
pub(crate) fn whole_data() -> Option<PathBuf> {
    // Beside the project, and beside a working copy that lies one folder deeper.
    for shared in ["../../shared/data", "../../../shared/data"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(shared);
        if path.exists() {
            return Some(path.canonicalize().unwrap());
        }
    }
    skipped("no measured data at ../shared/data");
    None
}

/// Wheel radius and track of [`ROBOT`], m.
pub(crate) const RADIUS: f64 = 0.033;
pub(crate) const TRACK: f64 = 0.16;
/// Radius of gyration of [`ROBOT`], m.
pub(crate) const GYRATION: f64 = 0.06;

/// The robot of [`drive`]. Its filter is fast beside the speeds' own frequencies.
pub(crate) const ROBOT: &str = "name = \"exact\"\nkinematics = \"differential\"\nwheel_radius_m = 0.033\ntrack_m = 0.16\n\
                         gyration_radius_m = 0.06\nmass_no_load_kg = 1\nmass_full_load_kg = 6\nfilter_cutoff_hz = 20\n";

/// a0 N·m, a1 N·m/kg, g2 N·m·s/rad, g3 kg·m², g4, κ W/(N·m)² of [`drive`]: near a servo's.
pub(crate) const TRUTH: [f64; 6] = [0.05, 0.008, 0.007, 0.0065, 1.6, 2.5];
pub(crate) const NAMES: [&str; 6] =
    ["coulomb", "rolling", "viscous", "rotor_inertia", "inertia_gain", "winding_loss"];

/// Speed and acceleration of both wheels at a time: three tones each, up to 0.7 Hz, so that starts,
/// stops, turns and reverse driving all happen.
pub(crate) fn motion(time: f64) -> ([f64; 2], [f64; 2]) {
    let tones = [
        [(3.0, 0.9, 0.0), (1.5, 2.3, 0.4), (0.8, 4.3, 1.0)],
        [(2.6, 0.7, 0.5), (1.7, 1.9, 1.1), (0.7, 3.7, 0.2)],
    ];
    let sum = |tones: [(f64, f64, f64); 3], of: fn(f64, f64, f64) -> f64| -> f64 {
        tones.into_iter().map(|(size, rate, phase)| of(size, rate, rate * time + phase)).sum()
    };
    let speed = tones.map(|wheel| sum(wheel, |size, _, angle| size * angle.sin()));
    let acceleration = tones.map(|wheel| sum(wheel, |size, rate, angle| size * rate * angle.cos()));
    (speed, acceleration)
}

/// P = Σ max(0, τ w + κ τ²), τ = (a0 + a1 m) h + g2 w + g3 a + g4 m K, with K = M'' a worked out by
/// hand: v̇ = r (a1 + a2)/2 and ω̇ = r (a2 − a1)/b give K = r/2 v̇ ∓ k² r/b ω̇.
pub(crate) fn power(speed: [f64; 2], acceleration: [f64; 2], mass: f64) -> f64 {
    let [a0, a1, g2, g3, g4, kappa] = TRUTH;
    let [left, right] = acceleration;
    let forward = RADIUS / 2.0 * (RADIUS * (left + right) / 2.0);
    let turning = GYRATION * GYRATION * RADIUS / TRACK * (RADIUS * (right - left) / TRACK);
    let inertial = [forward - turning, forward + turning];
    (0..2)
        .map(|i| {
            let (w, a) = (speed[i], acceleration[i]);
            let h = if w.abs() > 0.02 { w.signum() } else { 0.0 };
            let torque = (a0 + a1 * mass) * h + g2 * w + g3 * a + g4 * mass * inertial[i];
            (torque * w + kappa * torque * torque).max(0.0)
        })
        .sum()
}

pub(crate) const HEADER: &str = "time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg\n";

/// A log of `seconds` at `rate_hz` that the model made.
pub(crate) fn drive(seconds: f64, rate_hz: f64, mass: impl Fn(f64) -> f64) -> String {
    let mut text = HEADER.to_owned();
    for row in 0..(seconds * rate_hz) as u64 {
        let time = row as f64 / rate_hz;
        let (speed, acceleration) = motion(time);
        let mass = mass(time);
        let power = power(speed, acceleration, mass);
        writeln!(text, "{time:.4},{:.9},{:.9},{power:.9},{mass}", speed[0], speed[1]).unwrap();
    }
    text
}

/// A robot with a battery, and coefficients of a log that the model made, of 1 and 6 kg.
pub(crate) fn fitted() -> Bench {
    let bench = Bench::new();
    bench.put("robot.toml", format!("{ROBOT}[battery]\ncapacity_ah = 1.8\ncells = 3\n"));
    bench.put("log.csv", drive(120.0, 100.0, |time| if time < 60.0 { 1.0 } else { 6.0 }));
    bench.done(&["fit", "--robot", "robot.toml", "--out", "c.toml", "log.csv"]);
    bench
}

/// A run of a robot with gear motors: 60 s at 20 Hz, 0.05 W of noise. Every second is a test drive.
pub(crate) fn simulate(bench: &Bench, name: &str, place: usize, mass: &str, seed: usize, more: &[&str]) {
    let profile = if place.is_multiple_of(2) { "training" } else { "test" };
    let seed = seed.to_string();
    let common = ["--plant", "gearmotor", "--sensors", "servo", "--rate", "20", "--power-noise", "0.05"];
    let drive = ["--duration", "60", "--profile", profile, "--mass", mass, "--seed", &seed];
    bench.simulate(name, &[&common[..], &drive, more].concat());
}

/// A number that is this one to a share of it.
pub(crate) fn near(value: &Value, expected: f64, share: f64) {
    let value = number(value);
    assert!((value - expected).abs() <= share * expected.abs(), "{value}, expected {expected}");
}
