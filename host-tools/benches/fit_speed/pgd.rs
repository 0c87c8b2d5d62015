//! An iteration of Algorithm 1 on the Gram matrices of few rows and of many.

use std::error::Error;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::time::Instant;

use fit::dataset::Reading;
use fit::gram::{Scaled, Vector};
use fit::pgd::{self, Settings};
use logs::robot::Robot;
use model::coefficients::ModelKind;
use model_core::eq18::REGRESSORS;
use support::context::Context;

/// Rows of the short log.
const FEW: usize = 10_000;
const ITERATIONS: u64 = 20_000;
/// Odd, so that there is a median.
const REPEATS: usize = 101;

/// What is claimed: an iteration's time changes by less than this share from 10⁴ rows to 10⁷.
const CLAIMED_CHANGE: f64 = 0.05;

/// Prints the times; the claim that failed, if it did.
pub(crate) fn compare(log: &Path) -> Result<Option<String>, Box<dyn Error>> {
    let short = log.with_file_name("short.csv");
    let mut out = File::create(&short)?;
    for line in BufReader::new(File::open(log)?).lines().take(FEW + 1) {
        writeln!(out, "{}", line?)?;
    }
    let (few, many) = (problem(&short)?, problem(log)?);
    let (mut few_ns, mut many_ns) = (Vec::new(), Vec::new());
    for _ in 0..REPEATS {
        few_ns.push(iteration_ns(&few));
        many_ns.push(iteration_ns(&many));
    }
    let (few_ns, many_ns) = (median(few_ns), median(many_ns));
    let change = many_ns / few_ns - 1.0;
    println!("\npgd, medians of {REPEATS} alternating descents of {ITERATIONS} iterations");
    println!("  {few_ns:.1} ns an iteration for 10⁴ rows, {many_ns:.1} ns for 10⁷: {:+.1} %", 100.0 * change);
    let fails = change.abs() >= CLAIMED_CHANGE;
    Ok(fails.then(|| format!("pgd: an iteration's time changes by {:.1} %", 100.0 * change)))
}

fn problem(log: &Path) -> Result<Scaled<REGRESSORS>, Box<dyn Error>> {
    let robot = Robot::named("burger")?;
    let reading = Reading {
        gate: ModelKind::Eq18Published.gate(),
        cutoff_hz: Some(8.0),
        mass_kg: robot.mass_no_load_kg(),
    };
    Ok(fit::read(&Context::default(), &robot, &[log.to_owned()], &reading)?.gram().scaled())
}

fn iteration_ns(problem: &Scaled<REGRESSORS>) -> f64 {
    // No tolerance ends it early: both take the same number of iterations, unless steps fall below
    // rounding.
    let settings = Settings { tolerance: 0.0, most_iterations: ITERATIONS, ..Settings::default() };
    let started = Instant::now();
    let solution = pgd::solve(problem, Vector::zeros(), &settings);
    started.elapsed().as_secs_f64() * 1e9 / solution.iterations as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
