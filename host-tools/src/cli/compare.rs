//! `gmr compare`: every model and baseline on the same split.

use std::path::PathBuf;

use serde::Serialize;

use crate::baselines;
use crate::compare::{self, Comparison, Entry, HOLD_OUT, LeftOut, MassSource, Settings, Split, compare};
use crate::error::{Error, Result};
use crate::report::{Binned, Page, check_extension};
use crate::robot::Robot;
use crate::with_wheels;

/// Arguments of `gmr compare`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Logs to fit
    #[arg(long, value_name = "RUN.csv", num_args = 1.., required_unless_present = "list")]
    train: Vec<PathBuf>,
    /// Logs to evaluate [default: one in three blocks of time of the training logs, held out]
    #[arg(long, value_name = "RUN.csv", num_args = 1..)]
    test: Vec<PathBuf>,
    /// The robot: a robot.toml, or burger, warthog, husky
    #[arg(long, default_value = "burger")]
    robot: PathBuf,
    /// Length of held-out blocks, s [default: 5, or a sixth of the longest log if that is less]
    #[arg(long, value_name = "S")]
    block: Option<f64>,
    /// Payload window of the models that estimate the mass, s
    #[arg(long, default_value_t = 25.0, value_name = "S")]
    window: f64,
    /// Total mass of logs without a mass_kg column, kg [default: the robot's mass without payload]
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Models to compare [default: all that robot and logs allow; `--list` describes them]
    #[arg(long, value_delimiter = ',', num_args = 1.., value_name = "NAME,…")]
    models: Vec<String>,
    /// List the models with their sources, assumptions and needs, and end
    #[arg(long)]
    list: bool,
    /// Leave out the neural networks
    #[arg(long)]
    no_perceptron: bool,
    /// Draw predicted against measured power, binned as in the paper's Fig. 15
    #[arg(long, value_name = "FILE.svg|png")]
    plot: Option<PathBuf>,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    robot: &'a str,
    train_rows: usize,
    test_rows: usize,
    window_s: f64,
    mape_floor_w: f64,
    held_out_blocks: bool,
    models: &'a [Entry],
    left_out: &'a [LeftOut],
}

/// Bins of the figure over the range of the measured power.
const BINS: f64 = 30.0;

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    if arguments.list {
        print_list();
        return Ok(());
    }
    let robot = Robot::load(&arguments.robot)?;
    if let Some(plot) = &arguments.plot {
        check_extension(plot)?;
    }
    with_wheels!(robot, run_with(&robot, arguments))
}

fn run_with<const N: usize>(robot: &Robot, arguments: &Arguments) -> Result<()> {
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
        Split::Blocks { files: arguments.train.clone(), block_s: arguments.block }
    } else {
        Split::Files { train: arguments.train.clone(), test: arguments.test.clone() }
    };
    let settings = Settings { mass_kg, window_s: arguments.window, models: chosen(arguments)? };
    let comparison = compare::<N>(robot, &split, &settings)?;
    if let Some(plot) = &arguments.plot {
        draw(&comparison)?.save(plot)?;
    }
    if arguments.json {
        return super::print_json(&Report {
            robot: robot.name(),
            train_rows: comparison.train_rows,
            test_rows: comparison.test_rows,
            window_s: comparison.window_s,
            mape_floor_w: robot.mape_floor_w(),
            held_out_blocks: arguments.test.is_empty(),
            models: &comparison.entries,
            left_out: &comparison.left_out,
        });
    }
    print_text(robot, arguments, &comparison);
    Ok(())
}

/// The models that the arguments ask for.
fn chosen(arguments: &Arguments) -> Result<Vec<&'static str>> {
    let network = |name: &str| baselines::ALL.iter().any(|card| card.network && card.name == name);
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

fn print_list() {
    for name in compare::names() {
        let Some(card) = baselines::ALL.iter().find(|card| card.name == name) else { continue };
        println!("{name}: {}", card.source);
        println!("    assumes: {}", card.assumes);
    }
}

fn draw(comparison: &Comparison) -> Result<Page> {
    let highest = comparison.pairs.iter().flatten().map(|(measured, _)| *measured).fold(0.0, f64::max);
    let mut figure = Binned::new("Predicted against measured power", nice(highest / BINS));
    for (entry, pairs) in comparison.entries.iter().zip(&comparison.pairs) {
        if entry.mass == MassSource::Estimated || !entry.name.contains("mass given") {
            for (measured, predicted) in pairs {
                figure.add(&entry.name, *measured, *predicted);
            }
        }
    }
    Ok(Page::new([figure.into()]))
}

/// The next of 1, 2, 5 times a power of ten.
fn nice(width: f64) -> f64 {
    let decade = 10_f64.powf(width.max(1e-6).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|step| step * decade).find(|step| *step >= width).unwrap_or(width)
}

fn print_text(robot: &Robot, arguments: &Arguments, comparison: &Comparison) {
    let split = if arguments.test.is_empty() {
        format!("one in {HOLD_OUT} blocks held out")
    } else {
        format!("payload window {} s", comparison.window_s)
    };
    println!(
        "{}: {} rows to fit, {} to evaluate ({split})",
        robot.name(),
        comparison.train_rows,
        comparison.test_rows
    );
    println!("  {:<28} {:>9} {:>9} {:>10} {:>9}  mass", "model", "R²", "MAPE %", "RMSE W", "fit s");
    let number =
        |value: Option<f64>, digits: usize| value.map_or("–".to_owned(), |v| format!("{v:.digits$}"));
    for entry in &comparison.entries {
        println!(
            "  {:<28} {:>9} {:>9} {:>10.4} {:>9.3}  {}",
            entry.name,
            number(entry.r2, 5),
            number(entry.mape_percent, 2),
            entry.rmse_w,
            entry.fit_s,
            match entry.mass {
                MassSource::Given => "given",
                MassSource::Estimated => "estimated",
                MassSource::Unused => "unused",
            }
        );
    }
    for LeftOut { name, reason } in &comparison.left_out {
        println!("  {name:<28} left out: {reason}");
    }
    if let Some(entry) = comparison.entries.first() {
        println!(
            "MAPE over the {:.0} % of the samples with at least {} W",
            100.0 * entry.mape_share,
            robot.mape_floor_w()
        );
    }
}
