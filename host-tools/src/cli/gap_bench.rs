//! `gmr gap-bench`: what the gap workflow finds of effects hidden in simulated runs.

use std::io::IsTerminal;

use gap::bench::sets::noises;
use gap::bench::{self, Case, coverage, manoeuvre};
use indicatif::{ProgressBar, ProgressStyle};
use logs::robot::Robot;
use support::error::{Error, Result};
use support::output::print_json;

use super::gap_bench_count::label;
use super::{gap_bench_json as as_json, gap_bench_text as text};

/// Arguments of `gmr gap-bench`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr gap-bench --seeds 2 --sizes 1")]
pub(crate) struct Arguments {
    /// Seeds of every effect and size
    #[arg(long, default_value_t = 3)]
    seeds: u64,
    /// The first seed
    #[arg(long, default_value_t = 1)]
    first_seed: u64,
    /// Sizes: RMS of what an effect adds to the power, in standard deviations of its noise
    #[arg(long, value_delimiter = ',', default_value = "0.5,1,2")]
    sizes: Vec<f64>,
    /// Effect-free sets
    #[arg(long, default_value_t = 20)]
    free: u64,
    /// Only these effects
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Sets whose effect is taken out of the dictionary, per effect
    #[arg(long, default_value_t = 0)]
    removed: u64,
    /// Sets with two effects
    #[arg(long, default_value_t = 0)]
    pairs: usize,
    /// Of sets that end in a tie: drive the suggested manoeuvre, look again, and count what is then told apart
    #[arg(long)]
    manoeuvre: bool,
    /// Of sets whose effect is named: add it, estimate masses in runs that nobody has seen, and count how often the 95 % interval holds
    #[arg(long)]
    coverage: bool,
    /// Print every set
    #[arg(long)]
    all: bool,
    /// Every set and the figures as JSON on standard output
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let robot = Robot::named("burger")?;
    let effects: Vec<_> = bench::typical()?
        .into_iter()
        .filter(|effect| arguments.only.is_empty() || arguments.only.iter().any(|only| only == effect.id()))
        .collect();
    let last = arguments.first_seed + arguments.seeds;
    let case =
        |effects: Vec<_>, size, seed| Case { effects, size, seed, noise: noises()[0], removed: Vec::new() };
    let mut cases = Vec::new();
    for effect in &effects {
        for &size in &arguments.sizes {
            for seed in arguments.first_seed..last {
                cases.push(case(vec![effect.clone()], size, seed));
            }
        }
        for seed in arguments.first_seed..arguments.first_seed + arguments.removed {
            let removed = vec![effect.id().to_owned()];
            cases.push(Case { removed, ..case(vec![effect.clone()], 1.0, seed) });
        }
    }
    for pair in 0..arguments.pairs {
        let (first, step) = (pair % effects.len(), 1 + pair / effects.len() * 3 % (effects.len() - 1).max(1));
        let second = (first + step) % effects.len();
        if effects[first].id() != effects[second].id() {
            let both = vec![effects[first].clone(), effects[second].clone()];
            cases.push(case(both, 1.0, arguments.first_seed + pair as u64));
        }
    }
    cases.extend((0..arguments.free).map(|k| bench::effect_free(1000 * arguments.first_seed + k)));
    if cases.is_empty() {
        return Err(Error::usage("no set is asked for"));
    }
    let bar = if std::io::stderr().is_terminal() {
        ProgressBar::new(cases.len() as u64)
    } else {
        ProgressBar::hidden()
    };
    bar.set_style(
        ProgressStyle::with_template("{wide_bar} {pos}/{len} {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    if arguments.manoeuvre {
        let parted = manoeuvre::run(&robot, &cases, &bar)?;
        bar.finish_and_clear();
        if arguments.json {
            return print_json(&as_json::parted(&parted, cases.len()));
        }
        text::print_parted(&parted, cases.len());
        return Ok(());
    }
    if arguments.coverage {
        let covered = coverage::run(&robot, &cases, &bar)?;
        bar.finish_and_clear();
        if arguments.json {
            return print_json(&as_json::coverage(&covered));
        }
        text::print_coverage(&covered, arguments.all);
        return Ok(());
    }
    let mut outcomes = bench::run(&robot, cases, &bar)?;
    bar.finish_and_clear();
    outcomes.sort_by_key(|outcome| (label(outcome), outcome.case.size.to_bits(), outcome.case.seed));
    if arguments.json {
        return print_json(&as_json::outcomes(&outcomes));
    }
    text::print(&outcomes, arguments.all);
    Ok(())
}
