//! `gmr convert`: logs of any format that is read, as one log in CSV, Parquet or MCAP.

use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use log_formats::table::Cell;
use log_formats::write::{Mcap, Parquet};
use logs::foreign::{self, Reading};
use logs::robot::{FOUND, Robot};
use logs::{MASS, RUN, TableReader};
use support::context::Context;
use support::error::{Error, Result};
use support::output;
use support::own::Form;
use support::progress::FileProgress;

use super::overwrite::OverwriteArgument;
use logs::arguments::{Log, paths};

/// Arguments of `gmr convert`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr convert --robot robot.toml --mass 1.06 empty.mcap --out empty.csv")]
pub(crate) struct Arguments {
    /// Robot: a built-in name (burger, turtlebot4, warthog, husky) or a robot.toml; its [topics]
    /// say where a bag has what; auto: the nearest robot.toml upward, else burger
    #[arg(long, value_name = "R.toml", default_value = FOUND)]
    robot: PathBuf,
    /// Total mass of logs that do not tell it, kg
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Read what is there of a bag or ULog that was cut off while it was recorded
    #[arg(long)]
    allow_truncated: bool,
    /// Write to this file; its ending says as what
    #[arg(long, value_name = "OUT.{csv,parquet,mcap}")]
    out: PathBuf,
    /// Answer as JSON
    #[arg(long)]
    json: bool,
    /// The logs; of several, each is a run. The total mass behind the name is written into mass_kg
    #[arg(value_name = "LOG[=KG]", required = true)]
    logs: Vec<Log>,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

impl Arguments {
    /// The total mass that is written for a log, kg.
    fn mass_of(&self, log: &Log) -> Option<f64> {
        log.mass_kg.or(self.mass)
    }
}

#[derive(serde::Serialize)]
struct Report<'a> {
    out: String,
    rows: u64,
    columns: &'a [String],
}

#[derive(Clone, Copy)]
enum Target {
    Csv,
    Parquet,
    Mcap,
}

impl Target {
    fn of(file: &Path) -> Result<Self> {
        match file.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("parquet") => Ok(Self::Parquet),
            Some("mcap") => Ok(Self::Mcap),
            _ => Err(Error::usage("expected a name that ends in .csv, .parquet or .mcap").in_file(file)),
        }
    }
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let target = Target::of(&arguments.out)?;
    if let Some(mass) = arguments.mass.filter(|mass| !(*mass > 0.0 && mass.is_finite())) {
        return Err(Error::usage(format!("--mass {mass}: expected a mass above 0 kg")));
    }
    for log in &arguments.logs {
        if let Some(mass) = log.mass_kg.filter(|mass| !(*mass > 0.0 && mass.is_finite())) {
            let message = format!("={mass}: expected a total mass above 0 kg behind the log's name");
            return Err(Error::usage(message).in_file(&log.path));
        }
    }
    let inputs = arguments.logs.iter().map(AsRef::as_ref).chain([arguments.robot.as_path()]);
    output::check_apart([arguments.out.as_path()], inputs)?;
    output::folder_of(&arguments.out)?;
    arguments.overwrite.check([&arguments.out], Form::Converted)?;
    let robot = Robot::load(context, &arguments.robot)?;
    let reading = Reading { robot, allow_cut: arguments.allow_truncated, verbose: true };
    let context = &context.with_reading(reading);

    let columns = columns(context, arguments)?;
    let mut rows = 0;
    output::write_whole(&arguments.out, |to| {
        let is_text: Vec<bool> = columns.iter().map(|name| name == RUN).collect();
        let refused = |error: io::Error| Error::io(&arguments.out, &error);
        if let Target::Csv = target {
            let mut names = columns.join(",");
            names.push('\n');
            to.write_all(names.as_bytes()).map_err(refused)?;
            rows = each_row(context, arguments, &columns, &mut |row| write_csv(to, row).map_err(refused))?;
            return Ok(());
        }
        // Both formats go back to write what they know at the end only.
        let mut kept = tempfile::tempfile().map_err(refused)?;
        let file: BufWriter<&File> = BufWriter::new(&kept);
        let wrong = |error| foreign::wrong(error).in_file(&arguments.out);
        if let Target::Parquet = target {
            let mut writer = Parquet::new(file, &columns, &is_text).map_err(wrong)?;
            rows = each_row(context, arguments, &columns, &mut |row| writer.row(row).map_err(wrong))?;
            writer.finish().map_err(wrong)?;
        } else {
            let mut writer = Mcap::new(file, &columns, &is_text).map_err(wrong)?;
            rows = each_row(context, arguments, &columns, &mut |row| writer.row(row).map_err(wrong))?;
            writer.finish().map_err(wrong)?;
        }
        kept.rewind().map_err(refused)?;
        io::copy(&mut kept, to).map_err(refused)?;
        Ok(())
    })?;
    if arguments.json {
        return output::print_json(&Report {
            out: arguments.out.display().to_string(),
            rows,
            columns: &columns,
        });
    }
    println!("{}: {rows} rows of {}", arguments.out.display(), columns.join(", "));
    Ok(())
}

/// Columns of the first log, which the others have to have as well; with the run's, where there are
/// several logs.
fn columns(context: &Context, arguments: &Arguments) -> Result<Vec<String>> {
    let mut columns = TableReader::open(context, &arguments.logs[0].path)?.columns().to_vec();
    for log in &arguments.logs[1..] {
        let other = TableReader::open(context, &log.path)?;
        if other.columns() != columns {
            let message = format!(
                "has the columns {}; expected {}, as the first log",
                other.columns().join(", "),
                columns.join(", ")
            );
            return Err(Error::failed(message).in_file(&log.path));
        }
    }
    let weighed = arguments.logs.iter().filter(|log| arguments.mass_of(log).is_some()).count();
    if let Some(log) = arguments.logs.iter().find(|log| weighed > 0 && arguments.mass_of(log).is_none()) {
        let message = format!("has no mass, and others have; expected {}=KG", log.path.display());
        return Err(Error::usage(message).in_file(&log.path));
    }
    if weighed > 0 {
        if columns.iter().any(|name| name == MASS) {
            let message = format!("tells its mass ({MASS}); expected none where --mass is given");
            return Err(Error::usage(message).in_file(&arguments.logs[0].path));
        }
        columns.push(MASS.to_owned());
    }
    if arguments.logs.len() > 1 && !columns.iter().any(|name| name == RUN) {
        columns.push(RUN.to_owned());
    }
    Ok(columns)
}

/// Hands out the rows of all logs. Gives their number.
fn each_row(
    context: &Context,
    arguments: &Arguments,
    columns: &[String],
    take: &mut dyn FnMut(&[Cell]) -> Result<()>,
) -> Result<u64> {
    let several = arguments.logs.len() > 1;
    let mut progress = FileProgress::new(context, &paths(&arguments.logs));
    let mut rows = 0;
    let mut row = Vec::with_capacity(columns.len());
    for (place, log) in arguments.logs.iter().enumerate() {
        let mut reader = TableReader::open(context, &log.path)?;
        let own_run = reader.columns().iter().position(|name| name == RUN);
        // Two logs of one name are two runs still.
        let name = log.path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let name =
            if arguments.logs.iter().filter(|other| other.path.file_stem() == log.path.file_stem()).count()
                > 1
            {
                format!("{}-{name}", place + 1)
            } else {
                name
            };
        while reader.next_row(&mut row)? {
            row.extend(arguments.mass_of(log).map(Cell::Number));
            match own_run {
                Some(run) if several => {
                    if let Cell::Text(own) = &row[run] {
                        row[run] = Cell::Text(format!("{name}#{own}"));
                    }
                }
                None if several => row.push(Cell::Text(name.clone())),
                _ => {}
            }
            take(&row)?;
            rows += 1;
            if rows % 4096 == 0 {
                progress.at(reader.progress());
            }
        }
    }
    progress.finish();
    Ok(rows)
}

fn write_csv(to: &mut dyn Write, row: &[Cell]) -> io::Result<()> {
    for (place, cell) in row.iter().enumerate() {
        if place > 0 {
            to.write_all(b",")?;
        }
        match cell {
            Cell::Number(number) if number.is_nan() => {}
            Cell::Number(number) => write!(to, "{number}")?,
            Cell::Text(text) if text.contains([',', '"']) => write!(to, "\"{}\"", text.replace('"', "\"\""))?,
            Cell::Text(text) => to.write_all(text.as_bytes())?,
        }
    }
    to.write_all(b"\n")
}
