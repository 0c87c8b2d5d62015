//! `gmr compare`: every model and baseline on the same split.

use std::path::PathBuf;

use fit::entrance;
use logs::arguments::{Log, UnitArguments, paths};
use logs::checks;
use logs::robot::FOUND;
use report::check_extension;
use serde::Serialize;
use study::baselines;
use study::compare::{self, Entry, LeftOut, Settings, Split, compare};
use support::context::Context;
use support::error::{Error, Result};
use support::output::check_apart;
use support::overwrite::Form;

use super::compare_text::{print_list, print_table};
use super::overwrite::OverwriteArgument;

/// Arguments of `gmr compare`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr compare --robot robot.toml --train empty.csv full.csv --test other.csv\n  gmr compare --list"
)]
pub(crate) struct Arguments {
    /// Logs to fit, with the total mass behind the name where they do not hold it
    #[arg(long, value_name = "LOG[=KG]", num_args = 1.., required_unless_present = "list")]
    train: Vec<Log>,
    /// Logs to evaluate [default: one in three blocks of time of the training logs, held out]
    #[arg(long, value_name = "LOG[=KG]", num_args = 1..)]
    test: Vec<Log>,
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml
    /// upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Length of held-out blocks, s [default: 5, or a sixth of the longest log if that is less]
    #[arg(long, value_name = "S", conflicts_with = "test", allow_negative_numbers = true)]
    block: Option<f64>,
    /// Payload window of the models that estimate the mass, s
    #[arg(long, default_value_t = 25.0, value_name = "S", allow_negative_numbers = true)]
    window: f64,
    /// Total mass of logs without a mass_kg column, kg [default: the robot's mass without payload]
    #[arg(long, value_name = "KG", allow_negative_numbers = true)]
    mass: Option<f64>,
    /// Models to compare; those that robot or logs do not allow are named and left out [default:
    /// all; `--list` describes them]
    #[arg(long, value_delimiter = ',', num_args = 1.., value_name = "NAME,…")]
    models: Vec<String>,
    /// List the models (all, or those asked for) with their sources and assumptions, and what each
    /// needs of this robot's logs, and end
    #[arg(long)]
    list: bool,
    /// Leave out the neural networks
    #[arg(long, conflicts_with = "models")]
    no_perceptron: bool,
    /// Show each model also with a floor that adapts: told the mass, and what the power of the last
    /// minutes says of the floor
    #[arg(long, requires = "test")]
    adapt: bool,
    /// Print all models, and why others were left out, not only the best and ours
    #[arg(long)]
    all: bool,
    /// Draw predicted against measured power, binned as in the paper's Fig. 15: the models asked
    /// for, or the best few
    #[arg(long, value_name = "FILE.svg|png")]
    plot: Option<PathBuf>,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    units: UnitArguments,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

#[derive(Serialize)]
struct Report<'a> {
    robot: &'a str,
    train_rows: usize,
    test_rows: usize,
    window_s: f64,
    mape_floor_w: f64,
    /// Of the filter, Hz: the robot's own, or chosen by models of the literature.
    cutoff_hz: f64,
    /// By how much the power is taken to be later than the speeds, for every model, s.
    delay_s: f64,
    held_out_blocks: bool,
    models: &'a [Entry],
    left_out: &'a [LeftOut],
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let (context, robot) =
        &arguments.units.robot(context, &arguments.robot, arguments.train.iter().chain(&arguments.test))?;
    if arguments.list {
        return print_list(robot, &chosen(arguments)?, arguments.json);
    }
    if let Some(plot) = &arguments.plot {
        check_extension(plot)?;
    }
    let (train, test) = (paths(&arguments.train), paths(&arguments.test));
    let inputs = train.iter().chain(&test).chain([&arguments.robot]);
    check_apart(arguments.plot.as_deref(), inputs.map(PathBuf::as_path))?;
    checks::each_once(&train, &[])?;
    if arguments.mass.is_none() {
        entrance::check_masses(context, robot, &train)?;
    }
    arguments.overwrite.check(&arguments.plot, Form::Drawing)?;
    let mass_kg = arguments.mass.unwrap_or(robot.mass_no_load_kg());
    if !(mass_kg > 0.0 && mass_kg.is_finite()) {
        return Err(Error::usage(format!("--mass {mass_kg}: expected a mass above 0 kg")));
    }
    if let Some(block) = arguments.block
        && !(block > 0.0 && block.is_finite())
    {
        return Err(Error::usage(format!("--block {block}: expected a length above 0 s")));
    }
    let split = if arguments.test.is_empty() {
        Split::Blocks { files: train, block_s: arguments.block }
    } else {
        Split::Files { train, test }
    };
    let models = chosen(arguments)?;
    let settings = Settings { mass_kg, window_s: arguments.window, models, adapt: arguments.adapt };
    let comparison = compare(context, robot, &split, &settings)?;
    if let Some(plot) = &arguments.plot {
        comparison.figure(arguments.models.is_empty()).save(plot)?;
    }
    if arguments.json {
        return support::output::print_json(&Report {
            robot: robot.name(),
            train_rows: comparison.train_rows,
            test_rows: comparison.test_rows,
            window_s: comparison.window_s,
            mape_floor_w: robot.mape_floor_w(),
            cutoff_hz: comparison.cutoff_hz,
            delay_s: comparison.delay_s,
            held_out_blocks: arguments.test.is_empty(),
            models: &comparison.entries,
            left_out: &comparison.left_out,
        });
    }
    print_table(robot, arguments.test.is_empty(), &comparison, arguments.all);
    Ok(())
}

/// The models that the arguments ask for.
fn chosen(arguments: &Arguments) -> Result<Vec<&'static str>> {
    let network = |name: &str| baselines::every().any(|card| card.is_network() && card.name == name);
    if arguments.models.is_empty() {
        return Ok(compare::names().filter(|name| !(arguments.no_perceptron && network(name))).collect());
    }
    let known = |asked: &String| {
        compare::names().find(|name| name == asked).ok_or_else(|| {
            let names: Vec<&str> = compare::names().collect();
            Error::usage(format!("--models {asked}: expected some of {}", names.join(", ")))
        })
    };
    arguments.models.iter().map(known).collect()
}
