//! Logs held whole, as recorded: before any filter, with every further column, static power taken
//! off.

use std::path::{Path, PathBuf};

use support::context::Context;
use support::error::Result;
use support::printable;

use super::masses::check_mass;
use super::table::numbers_in_first_row;
use super::{
    Header, MASS, POWER, RUN, RawSample, SIM, SampleReader, TIME, YAW_RATE, acceleration_column, foreign,
    speed_column,
};
use crate::robot::Robot;

/// A run as recorded.
#[derive(Debug, Clone, Default)]
pub struct RawRun {
    /// Its name.
    pub name: String,
    /// Time, sample, mass and further columns of each row.
    pub rows: Vec<(f64, RawSample, f64, Vec<f64>)>,
    /// Names of the further columns.
    pub columns: Vec<String>,
    /// Median sample period, s.
    pub period_s: f64,
}

/// The runs of some logs; each value of a `run` column is one. `powers` are further columns that
/// are powers (`…_w`), where a log has them.
///
/// # Errors
/// A log that cannot be read or is not one of this robot.
pub(super) fn read(
    context: &Context,
    robot: &Robot,
    files: &[PathBuf],
    mass_kg: f64,
    powers: &[String],
) -> Result<Vec<RawRun>> {
    let mut raw = Vec::new();
    foreign::prepare(context, files);
    for file in files {
        raw.extend(read_log(context, robot, file, mass_kg, powers)?);
    }
    Ok(raw)
}

/// Reads a log whole: its runs as recorded, static power taken off.
fn read_log(
    context: &Context,
    robot: &Robot,
    file: &Path,
    mass_kg: f64,
    powers: &[String],
) -> Result<Vec<RawRun>> {
    let columns = further_columns(context, file, robot.wheels(), powers)?;
    let names: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut reader = SampleReader::open_with(context, file, robot, &names)?;
    let yaw_rate = columns.iter().position(|name| name == YAW_RATE);
    let mut runs: Vec<RawRun> = Vec::new();
    while let Some(row) = reader.next_row()? {
        if let Some(mass) = row.mass {
            check_mass(robot, mass).map_err(|error| error.in_file(file).at_line(row.line))?;
        }
        let run = row.run as usize;
        while runs.len() <= run {
            runs.push(RawRun { columns: columns.clone(), period_s: reader.period_s(), ..RawRun::default() });
        }
        let mass = row.mass.unwrap_or(mass_kg);
        let mut further = reader.extras().to_vec();
        if let Some(place) = yaw_rate {
            // Held over short holes, as every reader of it has it.
            further[place] = row.yaw_rate;
        }
        runs[run].rows.push((row.time, row.sample, mass, further));
    }
    let excluded = reader.exclusions();
    if excluded.total() > 0 {
        context.notice(format_args!("{}: {excluded}", file.display()));
    }
    let several = runs.len() > 1;
    for (run, name) in runs.iter_mut().zip(0..) {
        let label = reader.run_names().get(name).cloned().unwrap_or_else(|| name.to_string());
        run.name = printable::name(&file.display().to_string());
        if several {
            run.name += &format!("#{}", printable::name(&label));
        }
    }
    runs.retain(|run| !run.rows.is_empty());
    Ok(runs)
}

/// Columns of what a board estimated while it was recorded.
const BOARD: &str = "board_";

/// Columns beyond those of a drive that hold numbers. Powers (`…_w`) are left out, but for those
/// asked for: they are what is to be explained; and what a board made of them, its mass above all:
/// a gap moves it. What a simulator says explains nothing either.
fn further_columns(context: &Context, file: &Path, wheels: usize, powers: &[String]) -> Result<Vec<String>> {
    let header = Header::open(context, file)?;
    let known = |name: &str| {
        [TIME, POWER, MASS, RUN, ""].contains(&name)
            || (name.ends_with("_w") && !powers.iter().any(|power| power == name))
            || name.starts_with(BOARD)
            || name.starts_with(SIM)
            || (0..wheels).any(|wheel| name == speed_column(wheel) || name == acceleration_column(wheel))
    };
    let numbers = numbers_in_first_row(context, file)?;
    let columns = header.columns().iter().enumerate();
    let wanted =
        columns.filter(|(place, name)| !known(name) && numbers.get(*place).copied().unwrap_or(false));
    Ok(wanted.map(|(_, name)| name.clone()).collect())
}
