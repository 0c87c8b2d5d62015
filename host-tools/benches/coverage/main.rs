//! How often a stated 95 % interval contains the true mass: kinds of drives × sensor chains.
//!
//!     cargo bench -p host-tools --bench coverage [-- --seeds 3] [--gmr PATH] [--table FILE]
//!
//! Own plant, whose power is the model's own formula: the table says what intervals make of sensors
//! and drives, not what they make of a plant that is another. Everything goes through the command.
//! Coefficients come from a training drive with the same sensors. Beside coverage, each chain is
//! asked with five times its noise whether payloads seem to change, and whether masses beyond the
//! range are told as such. Ends with exit code 1 where a figure is worse than it has to be.

mod drives;
mod table;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use serde_json::Value;

use drives::{DURATION_S, KINDS, Kind};
use table::{Cell, Table};

/// Total masses of the drives, kg: one a drive, over the robot's range of 1 to 6.
const MASSES: [f64; 3] = [1.7, 3.4, 5.2];

/// Masses beyond that range, kg.
const BEYOND: [f64; 5] = [0.8, 0.9, 7.0, 9.0, 15.0];

const WINDOW_S: &str = "25";

/// Sensors, and the same with five times the noise.
struct Chain {
    name: &'static str,
    sensors: &'static [&'static str],
    noise: &'static str,
}

const SERVO: &[&str] = &["--sensors", "servo", "--rate", "200"];

const CHAINS: [Chain; 7] = [
    Chain { name: "exact speeds", sensors: &["--sensors", "exact", "--rate", "200"], noise: "0.05" },
    Chain { name: "servo, 200 Hz", sensors: SERVO, noise: "0.1" },
    Chain { name: "servo, 20 Hz", sensors: &["--sensors", "paper20", "--rate", "20"], noise: "0.1" },
    Chain {
        name: "correlated noise",
        sensors: &["--sensors", "servo", "--rate", "200", "--power-autocorrelation", "0.98"],
        noise: "0.1",
    },
    Chain {
        name: "heavy-tailed noise",
        sensors: &["--sensors", "servo", "--rate", "200", "--power-noise-tail", "2.5"],
        noise: "0.1",
    },
    Chain {
        name: "coarse speeds",
        sensors: &["--sensors", "servo", "--rate", "100", "--speed-source", "register"],
        noise: "0.1",
    },
    Chain {
        name: "jittered samples",
        sensors: &["--sensors", "servo", "--rate", "200", "--jitter", "0.0008"],
        noise: "0.1",
    },
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    let value = |name: &str| {
        let at = arguments.iter().position(|argument| argument == name)?;
        arguments.get(at + 1).cloned()
    };
    let seeds = value("--seeds").map_or(1, |seeds| seeds.parse().expect("a number of seeds"));
    let gmr = Gmr(value("--gmr").unwrap_or(env!("CARGO_BIN_EXE_gmr").to_owned()).into());
    let folder = tempfile::tempdir().expect("a folder for the logs");
    let mut table = Table::default();
    for (place, chain) in CHAINS.iter().enumerate() {
        let bench = Bench { gmr: &gmr, folder: folder.path(), chain };
        let coefficients = bench.fit();
        for seed in 0..seeds {
            for kind in &KINDS {
                let cell = bench.coverage(kind, &coefficients, seed);
                table.add(place, kind.name, cell);
            }
            table.noise[place] += bench.noisy(&coefficients, seed);
            table.beyond[place] += bench.beyond(&coefficients, seed);
        }
        eprintln!("{}", chain.name);
    }
    let chains = CHAINS.map(|chain| chain.name);
    let text = table.text(&chains);
    println!("{text}");
    if let Some(file) = value("--table") {
        std::fs::write(file, &text).expect("the table is written");
    }
    if table.is_reached() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The command.
struct Gmr(PathBuf);

impl Gmr {
    fn run(&self, arguments: &[&str]) -> Value {
        let output = Command::new(&self.0).args(arguments).output().expect("gmr runs");
        assert!(output.status.success(), "gmr {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap_or(Value::Null)
    }
}

/// One chain of sensors.
struct Bench<'a> {
    gmr: &'a Gmr,
    folder: &'a Path,
    chain: &'a Chain,
}

impl Bench<'_> {
    fn simulate(&self, profile: &str, duration: &str, mass: &str, noise: f64, seed: u64) -> PathBuf {
        let log = self.folder.join("run.csv");
        let (noise, seed) = (noise.to_string(), seed.to_string());
        let mut arguments =
            vec!["simulate", "--plant", "servo", "--profile", profile, "--duration", duration];
        arguments.extend(["--mass", mass, "--power-noise", &noise, "--seed", &seed, "--out", text(&log)]);
        arguments.extend(self.chain.sensors);
        self.gmr.run(&arguments);
        log
    }

    fn noise(&self) -> f64 {
        self.chain.noise.parse().expect("a power in W")
    }

    fn fit(&self) -> PathBuf {
        let log = self.simulate("training", "200", "1@0,6@100", self.noise(), 1);
        let coefficients = self.folder.join("coefficients.toml");
        self.gmr.run(&["fit", "--json", "--out", text(&coefficients), text(&log)]);
        coefficients
    }

    fn estimate(&self, coefficients: &Path, log: &Path) -> Value {
        let found = self.gmr.run(&[
            "estimate",
            "--json",
            "--window",
            WINDOW_S,
            "--coeffs",
            text(coefficients),
            text(log),
        ]);
        std::fs::remove_file(log).expect("the log was there");
        found
    }

    /// One drive a mass.
    fn coverage(&self, kind: &Kind, coefficients: &Path, seed: u64) -> Cell {
        let mut cell = Cell::default();
        for (place, mass) in (0..).zip(MASSES) {
            let seed = 100 + 10 * seed + place;
            let profile = kind.write(self.folder, seed);
            let log =
                self.simulate(text(&profile), &DURATION_S.to_string(), &mass.to_string(), self.noise(), seed);
            let found = self.estimate(coefficients, &log);
            for window in found["windows"].as_array().into_iter().flatten() {
                match (window["low_kg"].as_f64(), window["high_kg"].as_f64()) {
                    (Some(low), Some(high)) => {
                        cell.known += 1;
                        cell.inside += usize::from(low <= mass + 1e-9 && mass - 1e-9 <= high);
                    }
                    _ => cell.unknown += 1,
                }
            }
            cell.changes += found["changes"].as_array().map_or(0, Vec::len);
        }
        cell
    }

    /// Five times the noise: drives of one payload in which it seemed to change, and windows.
    fn noisy(&self, coefficients: &Path, seed: u64) -> Cell {
        let mut cell = Cell::default();
        for (place, mass) in (0..).zip(MASSES) {
            let log =
                self.simulate("test", "100", &mass.to_string(), 5.0 * self.noise(), 500 + 10 * seed + place);
            let found = self.estimate(coefficients, &log);
            cell.changes += usize::from(found["changes"].as_array().is_some_and(|all| !all.is_empty()));
            for window in found["windows"].as_array().into_iter().flatten() {
                match (window["low_kg"].as_f64(), window["high_kg"].as_f64()) {
                    (Some(low), Some(high)) => {
                        cell.known += 1;
                        cell.inside += usize::from(low <= mass && mass <= high);
                    }
                    _ => cell.unknown += 1,
                }
            }
        }
        cell
    }

    /// Windows in which a mass beyond the range is told to be there, its interval reaching out to
    /// it within a twentieth.
    fn beyond(&self, coefficients: &Path, seed: u64) -> Cell {
        let mut cell = Cell::default();
        for (place, mass) in (0..).zip(BEYOND) {
            let log = self.simulate("test", "100", &mass.to_string(), self.noise(), 700 + 10 * seed + place);
            let found = self.estimate(coefficients, &log);
            cell.changes += usize::from(found["changes"].as_array().is_some_and(|all| !all.is_empty()));
            for window in found["windows"].as_array().into_iter().flatten() {
                let Some(range) = window["range"].as_str() else {
                    cell.unknown += 1;
                    continue;
                };
                cell.known += 1;
                let expected = if mass < 3.0 { "below" } else { "above" };
                cell.inside += usize::from(range == expected);
            }
        }
        cell
    }
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a plain path")
}
