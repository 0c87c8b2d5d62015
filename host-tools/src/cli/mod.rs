//! The command line: one file a subcommand. Figures go to standard output, all else to standard
//! error.

#[cfg(target_os = "linux")]
mod board;
mod compare;
mod compare_text;
mod convert;
mod demo;
mod doctor;
mod drive;
mod estimate;
mod export;
mod fit;
mod fit_grams;
mod flash;
mod fleet;
mod gap;
mod gap_bench;
mod gap_bench_json;
mod gap_bench_text;
mod gram;
mod inspect;
mod key;
mod look;
mod new_robot;
mod overwrite;
mod predict;
mod record;
mod reproduce;
mod shell;
mod simulate;
mod watch;

use std::ffi::OsString;

use clap::{CommandFactory as _, Parser, Subcommand};
use support::context::Context;
use support::error::{Error, Result};
use support::program;

pub use self::gram::Sums;

/// How much power does a wheeled robot draw, when nobody told it what it carries?
#[derive(Parser)]
#[command(name = "gmr", version, about, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// From a log to the payload on a simulated robot, in under a minute, on one page: nothing else
    /// is needed
    Demo(demo::Arguments),
    /// Say what is there, what is missing and what comes next: robot.toml, logs, coefficients,
    /// board, sensor, ROS
    Doctor(doctor::Arguments),
    /// Say what is in a log, what the robot's energy goes into, and what can be learned from it: no
    /// robot.toml needed
    Look(look::Arguments),
    /// Say what a log is worth: data quality, excitation, static power
    Inspect(inspect::Arguments),
    /// Turn logs into one of another format: bags of ROS 2, ULog, Parquet, CSV
    Convert(convert::Arguments),
    /// Write logs from the simulated plant
    Simulate(simulate::Arguments),
    /// Fit coefficients to logs with known payload
    Fit(fit::Arguments),
    /// Sum logs up: all that fits need to know of them, a few kilobytes a run
    Gram(gram::Arguments),
    /// Many robots over many days: what a metre costs each, and what changed on which since when
    Fleet(fleet::Arguments),
    /// Replay a log: payload windows, power, energy
    Estimate(estimate::Arguments),
    /// The energy of a planned drive with its interval, by legs, and whether the battery has it
    Predict(predict::Arguments),
    /// A fit in the words of Open-RMF, VDA 5050, Gazebo or MuJoCo
    Export(export::Arguments),
    /// Every model and baseline on the same split, in one table
    Compare(compare::Arguments),
    /// Find where model and measurement disagree, and name the missing effect
    Gap(gap::Arguments),
    /// Hide effects in simulated runs, and count what the gap workflow makes of them
    GapBench(gap_bench::Arguments),
    /// Regenerate the paper's figures and tables, ours beside them
    Reproduce(reproduce::Arguments),
    #[cfg(target_os = "linux")]
    /// Run the virtual board and its robot, with the link as a pseudo terminal
    Board(board::Arguments),
    /// Write a log from a board, live
    Record(record::Arguments),
    /// Store coefficients on a board
    Flash(flash::Arguments),
    /// Make a key that coefficients are signed with, for boards that ask for it
    Key(key::Arguments),
    /// Show what a board measures and estimates, live
    Watch(watch::Arguments),
    /// Payload, battery and what is left on ROS 2's topics, from one power sensor on the robot's
    /// own computer
    Node(::node::command::Arguments),
    /// Write a robot.toml from flags, or from answers
    NewRobot(new_robot::Arguments),
    /// Print what a shell completes commands and arguments by
    Completions(shell::Completions),
    /// Print gmr's man page, or write one of each command
    Man(shell::Man),
}

/// Parses a command line, the program's name first, and runs it. Gives the exit code: 0 done, 1
/// failed, 2 wrong usage.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    program::run("gmr", arguments, execute)
}

/// Runs a command for another program: its arguments without the program's name. In a
/// [job](support::job) what it prints is kept.
///
/// # Errors
/// As the command; help and version, which are the command line's.
pub fn answer(context: &Context, arguments: &[String]) -> Result<()> {
    execute(context, program::parse_given(arguments)?)
}

/// How `gmr gram` with these arguments sums up; the log and the file that they name are not
/// touched.
///
/// # Errors
/// As [`answer`]; arguments of another command.
pub fn sums(context: &Context, arguments: &[String]) -> Result<Sums> {
    match program::parse_given::<Cli>(arguments)?.command {
        Command::Gram(arguments) => Sums::of(context, &arguments),
        _ => Err(Error::usage("expected the arguments of gmr gram")),
    }
}

fn execute(context: &Context, cli: Cli) -> Result<()> {
    match cli.command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Doctor(arguments) => doctor::run(context, &arguments),
        Command::Look(arguments) => look::run(context, &arguments),
        Command::Inspect(arguments) => inspect::run(context, &arguments),
        Command::Convert(arguments) => convert::run(context, &arguments),
        Command::Simulate(arguments) => simulate::run(context, &arguments),
        Command::Fit(arguments) => fit::run(context, &arguments),
        Command::Gram(arguments) => gram::run(context, &arguments),
        Command::Fleet(arguments) => fleet::run(context, &arguments),
        Command::Estimate(arguments) => estimate::run(context, &arguments),
        Command::Predict(arguments) => predict::run(context, &arguments),
        Command::Export(arguments) => export::run(context, &arguments),
        Command::Compare(arguments) => compare::run(context, &arguments),
        Command::Gap(arguments) => gap::run(context, &arguments),
        Command::GapBench(arguments) => gap_bench::run(&arguments),
        Command::Reproduce(arguments) => reproduce::run(context, &arguments),
        #[cfg(target_os = "linux")]
        Command::Board(arguments) => board::run(&arguments),
        Command::Record(arguments) => record::run(&arguments),
        Command::Flash(arguments) => flash::run(context, &arguments),
        Command::Key(arguments) => key::run(&arguments),
        Command::Watch(arguments) => watch::run(&arguments),
        Command::Node(arguments) => ::node::command::run(context, &arguments),
        Command::NewRobot(arguments) => new_robot::run(&arguments),
        Command::Completions(arguments) => shell::completions(&arguments, Cli::command()),
        Command::Man(arguments) => shell::man(&arguments, Cli::command()),
    }
}
