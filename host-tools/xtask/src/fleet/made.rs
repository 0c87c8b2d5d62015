//! The logs of the fleet.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use super::changed::CHANGED;
use crate::paths::target_folder;
use crate::steps::Stop;

const ROBOTS: usize = 200;
const DAYS: usize = 5;
/// Of a robot on a day.
const RUNS: usize = 2;

/// Where it is, and what it is like.
pub(super) struct Fleet {
    pub(super) folder: PathBuf,
    /// s of each run.
    length_s: f64,
    rate_hz: f64,
    is_parquet: bool,
}

impl Fleet {
    /// 6 million rows.
    pub(super) fn small() -> Self {
        Self { folder: target_folder().join("bench-fleet"), length_s: 60.0, rate_hz: 50.0, is_parquet: false }
    }

    /// So many rows, at the rate of the board.
    pub(super) fn of(rows: usize) -> Self {
        let rate_hz = 200.0;
        Self {
            folder: target_folder().join(format!("bench-fleet-{rows}")),
            length_s: rows as f64 / (ROBOTS * DAYS * RUNS) as f64 / rate_hz,
            rate_hz,
            is_parquet: true,
        }
    }

    pub(super) fn logs(&self) -> PathBuf {
        self.folder.join("logs")
    }

    pub(super) fn coefficients(&self) -> PathBuf {
        self.folder.join("c.toml")
    }

    /// `gmr fleet` on it.
    pub(super) fn command(&self, gmr: &Path, out: &Path) -> Command {
        let mut fleet = Command::new(gmr);
        fleet.arg("fleet").arg(self.logs()).arg("--coeffs").arg(self.coefficients()).arg("--out").arg(out);
        fleet
    }

    /// Bytes of its logs.
    pub(super) fn bytes(&self) -> u64 {
        size(&self.logs())
    }

    /// Where it is not there yet.
    pub(super) fn simulate(&self, gmr: &Path) -> Result<(), Stop> {
        let whole = self.folder.join("whole");
        if whole.exists() {
            return Ok(());
        }
        std::fs::create_dir_all(&self.folder).map_err(|error| Stop::new(error.to_string()))?;
        let clean =
            [("empty.csv", "1"), ("full.csv", "6")].map(|(name, mass)| (self.folder.join(name), mass));
        for (out, mass) in &clean {
            self.drive(gmr, &["--duration", "120", "--mass", mass, "--seed", "999983"], out)?;
        }
        let mut fit = Command::new(gmr);
        fit.args(["fit", "--out"]).arg(self.coefficients()).args(clean.map(|(out, _)| out));
        done(&mut fit)?;
        let cores = thread::available_parallelism().map_or(1, usize::from);
        thread::scope(|scope| {
            let workers: Vec<_> = (0..cores)
                .map(|core| {
                    scope.spawn(move || {
                        (core..ROBOTS).step_by(cores).try_for_each(|robot| self.robot(gmr, robot))
                    })
                })
                .collect();
            workers
                .into_iter()
                .try_for_each(|worker| worker.join().unwrap_or_else(|_| Err(Stop::new("a worker panicked"))))
        })?;
        std::fs::write(whole, "").map_err(|error| Stop::new(error.to_string()))
    }

    fn robot(&self, gmr: &Path, robot: usize) -> Result<(), Stop> {
        for day in 1..=DAYS {
            let place = self.logs().join(format!("robot={robot:03}/day=2026-11-{day:02}"));
            std::fs::create_dir_all(&place).map_err(|error| Stop::new(error.to_string()))?;
            for run in 0..RUNS {
                let number = (robot * DAYS + day) * RUNS + run;
                let (seed, mass) = (number.to_string(), (1 + number % 6).to_string());
                let length = self.length_s.to_string();
                let mut arguments = vec!["--duration", &length, "--seed", &seed, "--mass", &mass];
                let change = CHANGED.iter().find(|change| change.0 == robot && day >= change.1);
                arguments.extend(change.into_iter().flat_map(|change| ["--effect", change.2]));
                self.log(gmr, &arguments, &place.join(run.to_string()))?;
            }
        }
        Ok(())
    }

    fn log(&self, gmr: &Path, arguments: &[&str], name: &Path) -> Result<(), Stop> {
        let csv = name.with_extension("csv");
        if !self.is_parquet {
            return self.drive(gmr, arguments, &csv);
        }
        let parquet = name.with_extension("parquet");
        if parquet.exists() {
            return Ok(());
        }
        self.drive(gmr, arguments, &csv)?;
        done(Command::new(gmr).args(["convert", "--force"]).arg(&csv).arg("--out").arg(parquet))?;
        // Both at once would be a disk full.
        std::fs::remove_file(csv).map_err(|error| Stop::new(error.to_string()))
    }

    fn drive(&self, gmr: &Path, arguments: &[&str], out: &Path) -> Result<(), Stop> {
        let mut simulate = Command::new(gmr);
        simulate.args(["simulate", "--rate", &self.rate_hz.to_string(), "--columns", "command", "--force"]);
        done(simulate.arg("--out").arg(out).args(arguments))
    }
}

fn done(command: &mut Command) -> Result<(), Stop> {
    let output = command.output().map_err(|error| Stop::new(error.to_string()))?;
    if output.status.success() {
        return Ok(());
    }
    Err(Stop::new(String::from_utf8_lossy(&output.stderr).into_owned()))
}

fn size(folder: &Path) -> u64 {
    let Ok(entries) = folder.read_dir() else { return 0 };
    let of = |entry: std::fs::DirEntry| match entry.metadata() {
        Ok(file) if file.is_dir() => size(&entry.path()),
        Ok(file) => file.len(),
        Err(_) => 0,
    };
    entries.flatten().map(of).sum()
}
