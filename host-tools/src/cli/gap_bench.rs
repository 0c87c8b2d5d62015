//! `gmr gap-bench`: what the gap workflow finds of effects hidden in simulated runs.

use std::io::IsTerminal;

use gap::bench::{self, Request, coverage, manoeuvre};
use indicatif::{ProgressBar, ProgressStyle};
use logs::robot::Robot;
use support::error::Result;
use support::output::print_json;

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
    /// Of sets that end in a tie: drive the suggested manoeuvre, look again, and count what is then
    /// told apart
    #[arg(long)]
    manoeuvre: bool,
    /// Of sets whose effect is named: add it, estimate masses in runs that nobody has seen, and
    /// count how often the 95 % interval holds
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
    let Arguments { seeds, first_seed, free, removed, pairs, all, json, .. } = *arguments;
    let request =
        Request { only: &arguments.only, sizes: &arguments.sizes, seeds, first_seed, free, removed, pairs };
    let robot = Robot::named("burger")?;
    let cases = request.cases()?;
    let bar = if std::io::stderr().is_terminal() {
        ProgressBar::new(cases.len() as u64)
    } else {
        ProgressBar::hidden()
    };
    bar.set_style(
        ProgressStyle::with_template("{wide_bar} {pos}/{len} {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let sets = cases.len();
    if arguments.manoeuvre {
        let parted = manoeuvre::run(&robot, &cases, &bar)?;
        bar.finish_and_clear();
        if json {
            return print_json(&as_json::parted(&parted, sets));
        }
        text::print_parted(&parted, sets);
        return Ok(());
    }
    if arguments.coverage {
        let covered = coverage::run(&robot, &cases, &bar)?;
        bar.finish_and_clear();
        if json {
            return print_json(&as_json::coverage(&covered));
        }
        text::print_coverage(&covered, all);
        return Ok(());
    }
    let outcomes = bench::run(&robot, &cases, &bar)?;
    bar.finish_and_clear();
    if json {
        return print_json(&as_json::outcomes(&outcomes));
    }
    text::print(&outcomes, all);
    Ok(())
}
