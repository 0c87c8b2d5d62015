//! `cargo xtask bench fleet`: two hundred simulated robots on five days, three of which change; who is named, and how fast.

use std::path::Path;
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

use crate::steps::{Steps, Stop, command};

const ROBOTS: usize = 200;
const DAYS: usize = 5;
const RUNS: usize = 2;
/// s of each run, at 50 Hz.
const LENGTH_S: usize = 60;

/// Robots that change: which, from which day (from 1), by which effect, and the coefficients that are a right name for it.
const CHANGED: [(usize, usize, &str, &[&str]); 3] = [
    (17, 3, "wheel-drag=0.02", &["coulomb of the left wheels"]),
    (101, 4, "viscous-change=0.5", &["viscous"]),
    (160, 2, "rolling-resistance-change=0.01", &["rolling"]),
];

/// Simulates the fleet where it is not there yet, reads it, and holds what is named against what is true.
pub(crate) fn run(steps: &mut Steps) -> Result<(), Stop> {
    let build = "cargo build --release --package host-tools --bin gmr";
    steps.run("fleet: build", command(build))?;
    let gmr = crate::paths::target_folder().join("release/gmr");
    let folder = crate::paths::target_folder().join("bench-fleet");
    steps.work("fleet: simulate", || simulate(&gmr, &folder))?;
    steps.work("fleet: read and judge", || judge(&gmr, &folder))
}

fn simulate(gmr: &Path, folder: &Path) -> Result<(), Stop> {
    let whole = folder.join("whole");
    if whole.exists() {
        return Ok(());
    }
    let made = |arguments: &[&str], out: &Path| -> Result<(), Stop> {
        let mut simulate = Command::new(gmr);
        simulate.args(["simulate", "--rate", "50", "--columns", "command", "--force", "--out"]).arg(out);
        done(simulate.args(arguments))
    };
    std::fs::create_dir_all(folder).map_err(|error| Stop::new(error.to_string()))?;
    let clean = [("empty.csv", "1"), ("full.csv", "6")].map(|(name, mass)| (folder.join(name), mass));
    for (out, mass) in &clean {
        made(&["--duration", "120", "--mass", mass, "--seed", "999983"], out)?;
    }
    let mut fit = Command::new(gmr);
    fit.args(["fit", "--out"]).arg(folder.join("c.toml")).args(clean.map(|(out, _)| out));
    done(&mut fit)?;
    let one = |robot: usize| -> Result<(), Stop> {
        for day in 1..=DAYS {
            let place = folder.join(format!("logs/robot={robot:03}/day=2026-11-{day:02}"));
            std::fs::create_dir_all(&place).map_err(|error| Stop::new(error.to_string()))?;
            for run in 0..RUNS {
                let number = (robot * DAYS + day) * RUNS + run;
                let (seed, mass) = (number.to_string(), (1 + number % 6).to_string());
                let length = LENGTH_S.to_string();
                let mut arguments = vec!["--duration", &length, "--seed", &seed, "--mass", &mass];
                let change = CHANGED.iter().find(|change| change.0 == robot && day >= change.1);
                arguments.extend(change.into_iter().flat_map(|change| ["--effect", change.2]));
                made(&arguments, &place.join(format!("{run}.csv")))?;
            }
        }
        Ok(())
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        let workers: Vec<_> = (0..cores)
            .map(|core| scope.spawn(move || (core..ROBOTS).step_by(cores).try_for_each(one)))
            .collect();
        workers
            .into_iter()
            .try_for_each(|worker| worker.join().unwrap_or_else(|_| Err(Stop::new("a worker panicked"))))
    })?;
    std::fs::write(whole, "").map_err(|error| Stop::new(error.to_string()))
}

fn done(command: &mut Command) -> Result<(), Stop> {
    let output = command.output().map_err(|error| Stop::new(error.to_string()))?;
    if output.status.success() {
        return Ok(());
    }
    Err(Stop::new(String::from_utf8_lossy(&output.stderr).into_owned()))
}

fn judge(gmr: &Path, folder: &Path) -> Result<(), Stop> {
    let out = folder.join("out");
    let _ = std::fs::remove_dir_all(&out);
    let started = Instant::now();
    let mut fleet = Command::new(gmr);
    fleet
        .arg("fleet")
        .arg(folder.join("logs"))
        .arg("--coeffs")
        .arg(folder.join("c.toml"))
        .arg("--out")
        .arg(&out);
    let mut child = fleet.spawn().map_err(|error| Stop::new(error.to_string()))?;
    let mut peak_kb = 0;
    let status = loop {
        // What the kernel calls the high-water mark; the last look is at most 5 ms before the end.
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let mark = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kb = mark.and_then(|mark| mark.split_whitespace().next()?.parse::<u64>().ok());
        peak_kb = peak_kb.max(kb.unwrap_or(0));
        if let Some(status) = child.try_wait().map_err(|error| Stop::new(error.to_string()))? {
            break status;
        }
        thread::sleep(Duration::from_millis(5));
    };
    let seconds = started.elapsed().as_secs_f64();
    if !status.success() {
        return Err(Stop::new(format!("gmr fleet: {status}")));
    }
    let text =
        std::fs::read_to_string(out.join("fleet.json")).map_err(|error| Stop::new(error.to_string()))?;
    let report: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| Stop::new(format!("fleet.json: {error}")))?;
    let rows = report["rows"].as_f64().unwrap_or(0.0);
    let bytes = size(&folder.join("logs")) as f64;
    println!(
        "   {:.2e} rows, {:.0} MB in {seconds:.1} s: {:.2e} rows/s, {:.0} MB/s; at most {:.0} MB of memory",
        rows,
        bytes / 1e6,
        rows / seconds,
        bytes / 1e6 / seconds,
        peak_kb as f64 / 1e3
    );
    let found: Vec<(String, String, String)> = report["changes"]
        .as_array()
        .into_iter()
        .flatten()
        .map(|change| {
            let text = |key: &str| change[key].as_str().unwrap_or("").to_owned();
            (text("robot"), text("since"), text("coefficient"))
        })
        .collect();
    let mut missed = Vec::new();
    for (robot, day, effect, names) in CHANGED {
        let (robot, since) = (format!("{robot:03}"), format!("2026-11-{day:02}"));
        let is_named =
            found.iter().any(|one| one.0 == robot && one.1 == since && names.contains(&one.2.as_str()));
        if !is_named {
            missed.push(format!("{effect} of robot {robot} since {since}"));
        }
    }
    let truly = |robot: &str| CHANGED.iter().any(|change| format!("{:03}", change.0) == robot);
    let wrong: Vec<_> = found.iter().filter(|one| !truly(&one.0)).collect();
    if missed.is_empty() && wrong.is_empty() {
        println!("   the three robots and days are named, no other is");
        return Ok(());
    }
    Err(Stop::new(format!("not named: {missed:?}; named without a change: {wrong:?}; all: {found:?}")))
}

fn size(folder: &Path) -> u64 {
    let Ok(entries) = folder.read_dir() else { return 0 };
    let of = |entry: std::fs::DirEntry| match entry.metadata() {
        Ok(found) if found.is_dir() => size(&entry.path()),
        Ok(found) => found.len(),
        Err(_) => 0,
    };
    entries.flatten().map(of).sum()
}
