//! Power over time, thinned as other runs are.

use std::path::{Path, PathBuf};

use answers::inspect::{Block, Blocks};
use logs::{ColumnRequest, Header, LogReader, MIN_GAP_FACTOR, POWER, RUN, Role, TIME, wheel_columns};
use support::context::Context;
use support::error::{Error, Result};

use residuals::thresholds::power_only::ROWS_PER_S;

/// One run.
#[derive(Debug, Clone)]
pub struct PowerRun {
    /// Its log, and its name there where the log holds several.
    pub name: String,
    /// Its power in blocks of half a second or more.
    pub blocks: Vec<Block>,
}

/// Whether none of the logs has a wheel's speed.
///
/// # Errors
/// A log cannot be read. Logs with wheel speeds among logs without.
pub fn is_power_only(context: &Context, files: &[PathBuf]) -> Result<bool> {
    let mut first: Option<(&Path, bool)> = None;
    for file in files {
        let header = Header::open(context, file)?;
        let has = wheel_columns(header.columns()) > 0;
        match first {
            None => first = Some((file, has)),
            Some((other, had)) if had != has => {
                let (with, without) = if has { (file.as_path(), other) } else { (other, file.as_path()) };
                let message = format!(
                    "no wheel speeds, but {} has them; expected wheel1_rad_s, … in every log, or in none",
                    with.display()
                );
                return Err(Error::failed(message).in_file(without).at_line(1));
            }
            Some(_) => {}
        }
    }
    Ok(first.is_some_and(|(_, has)| !has))
}

/// Reads logs of power in units of so many W; each value of a `run` column is a run.
///
/// # Errors
/// A log that cannot be read, or lacks time or power.
pub fn read(context: &Context, files: &[PathBuf], unit_w: f64) -> Result<Vec<PowerRun>> {
    let mut runs = Vec::new();
    for file in files {
        read_log(context, file, unit_w, &mut runs)?;
    }
    Ok(runs)
}

fn read_log(context: &Context, file: &Path, unit_w: f64, runs: &mut Vec<PowerRun>) -> Result<()> {
    let requests = [
        ColumnRequest::required(TIME, Role::Time),
        ColumnRequest::required(POWER, Role::Number),
        ColumnRequest::optional(RUN, Role::Run),
    ];
    let mut reader = LogReader::open(context, file, &requests)?.scaled(vec![1.0, unit_w, 1.0]);
    let mut values = [0.0; 3];
    let mut series: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    while reader.next_row(&mut values)?.is_some() {
        let run = if reader.has(2) { values[2] as usize } else { 0 };
        if series.len() <= run {
            series.resize_with(run + 1, Default::default);
        }
        series[run].0.push(values[0]);
        series[run].1.push(values[1]);
    }
    if reader.exclusions().total() > 0 {
        context.notice(format_args!("{}: {}", file.display(), reader.exclusions()));
    }
    let several = series.len() > 1;
    for (place, (times, power)) in series.iter().enumerate().filter(|(_, (times, _))| !times.is_empty()) {
        let mut name = file.display().to_string();
        if several {
            name += &format!("#{}", reader.run_names().get(place).map_or("", String::as_str));
        }
        runs.push(PowerRun::new(name, times, power));
    }
    Ok(())
}

impl PowerRun {
    /// Of times, s, that increase, and powers, W.
    pub fn new(name: String, times: &[f64], power: &[f64]) -> Self {
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let middle = steps.len() / 2;
        let period = match steps.len() {
            0 => 1.0,
            _ => *steps.select_nth_unstable_by(middle, f64::total_cmp).1,
        };
        let per_row = (1.0 / (ROWS_PER_S * period)).round().max(1.0) as usize;
        let mut blocks = Blocks::new();
        let (mut sum, mut count) = (0.0, 0_usize);
        for (index, (&time, &power)) in times.iter().zip(power).enumerate() {
            if index > 0 && time - times[index - 1] > MIN_GAP_FACTOR * period {
                blocks.restart();
                (sum, count) = (0.0, 0);
            }
            sum += power;
            count += 1;
            if count == per_row {
                blocks.add(time, sum / count as f64, true);
                (sum, count) = (0.0, 0);
            }
        }
        Self { name, blocks: blocks.finish() }
    }
}
