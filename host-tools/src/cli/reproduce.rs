//! `gmr reproduce`: the paper's figures and tables, ours beside them.

use std::path::PathBuf;

use study::baselines;
use study::reproduce::{Settings, output, run as reproduce};
use support::context::Context;
use support::error::{Error, Result};
use support::output::check_room;
use support::progress::CountProgress;

/// Arguments of `gmr reproduce`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr reproduce --out paper/")]
pub(crate) struct Arguments {
    /// The folder to write: index.html, tables.txt, study.json and figures/; an earlier
    /// reproduction is replaced
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Seeds that figures with an interval are over [default: 20, reduced 2]
    #[arg(long, value_name = "COUNT")]
    seeds: Option<u64>,
    /// The first of them; figures over time show this one
    #[arg(long, default_value_t = 1, value_name = "SEED")]
    first_seed: u64,
    /// Two seeds, fewer windows, no neural networks: to see whether anything has changed
    #[arg(long)]
    reduced: bool,
    /// Figures as JSON on standard output, instead of the tables
    #[arg(long)]
    json: bool,
}

/// Windows of the sweep, s: as far as Fig. 12 goes.
const WINDOWS_S: [u32; 12] = [5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60];

/// Those of a reduced one.
const REDUCED_WINDOWS_S: [u32; 3] = [10, 25, 50];

/// A reproduction, the logs that it works on, and an earlier one that it replaces: twice what is
/// written, rounded up.
const ROOM_BYTES: u64 = 64 << 20;

/// Seeds unless told otherwise: as many as an interval is asked over.
const SEEDS: u64 = 20;

/// Those of a reduced one: the fewest that have an interval.
const REDUCED_SEEDS: u64 = 2;

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let settings = settings(arguments)?;
    output::check(&arguments.out)?;
    check_room(&arguments.out, ROOM_BYTES)?;
    let study = {
        let progress = CountProgress::new(context, "seeds", settings.seeds);
        reproduce(context, &settings, &|| progress.one_more())?
    };
    output::save(&study, &arguments.out)?;
    if arguments.json {
        return support::output::print_json(&study.json());
    }
    support::output::print(format_args!("{}", study.text()));
    Ok(())
}

fn settings(arguments: &Arguments) -> Result<Settings> {
    let seeds = arguments.seeds.unwrap_or(if arguments.reduced { REDUCED_SEEDS } else { SEEDS });
    if seeds == 0 || arguments.first_seed.checked_add(seeds).is_none() {
        return Err(Error::usage(format!(
            "--seeds {seeds} from --first-seed {}: expected at least one seed, the last below 2⁶⁴",
            arguments.first_seed
        )));
    }
    let windows_s = if arguments.reduced { REDUCED_WINDOWS_S.to_vec() } else { WINDOWS_S.to_vec() };
    let cards = baselines::every().filter(|card| !(arguments.reduced && card.is_network()));
    Ok(Settings {
        first_seed: arguments.first_seed,
        seeds,
        windows_s,
        baselines: cards.map(|card| card.name).collect(),
    })
}
