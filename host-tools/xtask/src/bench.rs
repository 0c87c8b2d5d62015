//! `cargo xtask bench`: the figures of the README, measured again.

use crate::fleet;
use crate::gap;
use crate::instructions;
use crate::kinds;
use crate::logs;
use crate::paths::root;
use crate::predict;
use crate::robots;
use crate::steps::{Steps, Stop, command};

type Measure = fn(&mut Steps) -> Result<(), Stop>;

/// What can be measured.
const BENCHES: [(&str, Measure); 16] = [
    ("accuracy", |steps| host_bench(steps, "accuracy", "accuracy")),
    ("charge", |steps| host_bench(steps, "charge", "charge")),
    ("coverage", coverage),
    ("fit-speed", |steps| host_bench(steps, "fit-speed", "fit_speed")),
    ("fleet", fleet::run),
    ("floors", robots::floors),
    ("gap", gap::run),
    ("instructions", instructions::run),
    ("kinds", kinds::run),
    ("logs", logs::run),
    ("predict", predict::run),
    ("robots", |steps| robots::run(steps, false)),
    ("gap-mujoco", robots::gap),
    ("gap-simulator", robots::simulator),
    ("gap-sizes", robots::sizes),
    ("leaderboard", gap::leaderboard),
];

/// What takes an hour or a night is measured only where it is asked for by name.
const NIGHTLY: [&str; 3] = ["gap", "gap-mujoco", "leaderboard"];

/// Measures one of them, or all but those. True when every figure was reached; `None` for a name
/// that there is not.
pub(crate) fn run(name: Option<&str>) -> Option<bool> {
    let asked = |known: &str| name.map_or(!NIGHTLY.contains(&known), |name| name == known);
    let chosen: Vec<_> = BENCHES.iter().filter(|(known, _)| asked(known)).collect();
    if chosen.is_empty() {
        return None;
    }
    let mut steps = Steps::default();
    let mut reached = true;
    for (name, measure) in chosen {
        if let Err(stop) = measure(&mut steps) {
            println!("{name}: {stop}");
            reached = false;
        }
    }
    steps.print_summary();
    Some(reached)
}

/// The bench of a fleet of so many rows. True when every figure was reached.
pub(crate) fn fleet_of(rows: usize) -> bool {
    let done = fleet::run_large(rows);
    if let Err(stop) = &done {
        println!("fleet: {stop}");
    }
    done.is_ok()
}

/// The bench of engines on a fleet of so many rows. True when it ended well.
pub(crate) fn engines_of(rows: usize) -> bool {
    let done = fleet::run_engines(rows);
    if let Err(stop) = &done {
        println!("engines: {stop}");
    }
    done.is_ok()
}

/// The bench of robots as JSON. True when it ended well.
pub(crate) fn robots_json() -> bool {
    let done = robots::run(&mut Steps::default(), true);
    if let Err(stop) = &done {
        eprintln!("robots: {stop}");
    }
    done.is_ok()
}

/// A bench of host-tools.
fn host_bench(steps: &mut Steps, name: &str, bench: &str) -> Result<(), Stop> {
    steps.run(name, command(&format!("cargo bench --package host-tools --bench {bench}")))
}

/// How often intervals hold the mass: the table is kept, whatever it says.
fn coverage(steps: &mut Steps) -> Result<(), Stop> {
    let mut bench = command("cargo bench --package host-tools --bench coverage -- --table");
    bench.arg(root().join("docs/results/coverage.txt"));
    steps.run("coverage", bench)
}

/// Spoiled inputs, each to the command that reads it. True when every promise was kept.
pub(crate) fn mutants(numbers: &[&str]) -> bool {
    let mut steps = Steps::default();
    let line = format!("cargo bench --package host-tools --bench mutants -- {}", numbers.join(" "));
    let done = steps.run("mutants", command(line.trim_end_matches([' ', '-'])));
    if let Err(stop) = &done {
        println!("mutants: {stop}");
    }
    done.is_ok()
}
