//! `gmr fit` against NumPy and SciPy on ten million rows, in the same run; and what an iteration of
//! Algorithm 1 costs.
//!
//! `cargo bench -p host-tools --bench fit_speed [-- ROUNDS]`. Needs python3 with venv, and the
//! network once, for NumPy and SciPy. Times depend on the machine and on what else it does: only
//! ratios of the same run are claims.

mod log;
mod pgd;
mod python;
mod timed;

use std::error::Error;
use std::path::Path;

use serde_json::Value;

use log::ROWS;
use timed::Timed;

/// Filter's cutoff for both, Hz: what `gmr` chooses by itself on this plant.
const CUTOFF_HZ: &str = "8.0";

/// Coefficients of the two programs agree to this share.
const AGREEMENT: f64 = 1e-3;

/// The log's total mass, kg: without other payloads only sums of coefficients are determined, at
/// this mass.
const MASS_KG: i32 = 1;

/// What is claimed: at least this many times as fast.
const CLAIMED_RATIO: f64 = 5.0;
/// What is claimed: at most so much memory, MB.
const CLAIMED_MEMORY_MB: f64 = 200.0;

/// Coefficients that multiply the same product, but for a power of the mass.
type Groups = &'static [&'static [(usize, i32)]];

const EQ18: Groups = &[
    &[(0, 0), (1, 1), (2, 2)],
    &[(3, 0)],
    &[(4, 0)],
    &[(5, 2)],
    &[(6, 0), (7, 1)],
    &[(8, 0), (9, 1)],
    &[(10, 1), (11, 2)],
    &[(12, 0)],
    &[(13, 1)],
    &[(14, 1)],
];
/// Scrub is left out: this robot has none.
const SIGNED: Groups = &[&[(0, 0), (1, 1)], &[(2, 0)], &[(3, 0)], &[(4, 0)], &[(5, 0)]];

fn main() -> Result<(), Box<dyn Error>> {
    let rounds = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(3);
    let folder = tempfile::tempdir()?;
    let log = log::write(folder.path())?;
    let robot = folder.path().join("burger.toml");
    let burger = include_str!("../../robots/burger.toml");
    std::fs::write(&robot, format!("filter_cutoff_hz = {CUTOFF_HZ}\n{burger}"))?;
    let python = python::with_scipy()?;
    // Once without a clock: the log comes into the page cache, Python compiles its modules.
    python::fit(&python, &log, CUTOFF_HZ, "eq18")?;

    let mut failed = Vec::new();
    for (model, groups) in [("eq18", EQ18), ("signed", SIGNED)] {
        let (mut ours, mut theirs, mut choosing) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..rounds {
            ours.push(fit(&log, &robot, model)?);
            theirs.push(python::fit(&python, &log, CUTOFF_HZ, model)?);
            choosing.push(fit(&log, Path::new("burger"), model)?);
        }
        println!(
            "\n{model}, {ROWS} rows, the same filter for both; medians and extremes of {rounds} alternating runs"
        );
        println!("  gmr                        {}", timed::summary(&ours));
        println!("  NumPy and SciPy            {}", timed::summary(&theirs));
        println!("  gmr, choosing its filter   {}", timed::summary(&choosing));
        let ratio = timed::median(&theirs) / timed::median(&ours);
        println!(
            "  ratio {ratio:.1}; {:.1} if gmr also chooses its filter",
            timed::median(&theirs) / timed::median(&choosing)
        );
        let apart = disagreement(&ours[0].output, &theirs[0].output, groups)?;
        println!("  coefficients agree to {apart:.1e}");
        let memory = ours.iter().chain(&choosing).map(|run| run.memory_mb).fold(0.0, f64::max);
        let claims = [
            (ratio >= CLAIMED_RATIO, format!("{model}: {ratio:.1} times as fast; claimed: {CLAIMED_RATIO}")),
            (apart <= AGREEMENT, format!("{model}: coefficients {apart:.1e} apart; claimed: {AGREEMENT:e}")),
            (
                memory <= CLAIMED_MEMORY_MB,
                format!("{model}: {memory:.0} MB of memory; claimed: {CLAIMED_MEMORY_MB} MB"),
            ),
        ];
        failed.extend(claims.into_iter().filter(|(holds, _)| !holds).map(|(_, text)| text));
    }
    failed.extend(pgd::compare(&log)?);
    if failed.is_empty() { Ok(()) } else { Err(failed.join("; ").into()) }
}

/// `gmr fit --json`, timed.
fn fit(log: &Path, robot: &Path, model: &str) -> Result<Timed, Box<dyn Error>> {
    timed::run(
        std::process::Command::new(env!("CARGO_BIN_EXE_gmr"))
            .arg("fit")
            .arg(log)
            .arg("--robot")
            .arg(robot)
            .args(["--model", model, "--json"]),
    )
}

/// The largest difference of a determined sum of coefficients, as a share of it.
fn disagreement(ours: &str, theirs: &str, groups: Groups) -> Result<f64, Box<dyn Error>> {
    let ours: Value = serde_json::from_str(ours)?;
    let theirs: Value = serde_json::from_str(theirs)?;
    let our = |index: usize| ours["parameters"][index]["value"].as_f64();
    let their = |index: usize| theirs["coefficients"][index].as_f64();
    let sum = |value: &dyn Fn(usize) -> Option<f64>, group: &[(usize, i32)]| {
        group.iter().map(|&(index, power)| Some(value(index)? * f64::from(MASS_KG.pow(power as u32)))).sum()
    };
    let mut largest = 0.0_f64;
    for group in groups {
        let sums: (Option<f64>, Option<f64>) = (sum(&our, group), sum(&their, group));
        let (Some(a), Some(b)) = sums else { return Err("a program printed no coefficients".into()) };
        if a != b {
            largest = largest.max((a - b).abs() / a.abs().max(b.abs()));
        }
    }
    Ok(largest)
}
