//! What logs look like before they are fitted: another unit, a turned sign, a clipped sensor, rows
//! without a mass.

use std::path::{Path, PathBuf};

use logs::foreign;
use logs::robot::Robot;
use logs::standing::{Standings, Stuck};
use logs::suspicion::{Kind, Look, Suspicion};
use logs::{Header, MASS, POWER, SampleReader};
use rayon::prelude::*;
use support::context::Context;
use support::error::{Error, Result};

use super::warning::Warning;

/// Rows of a log that are looked at: half an hour at 200 Hz. What units and signs are is seen in
/// far fewer, and logs of 10⁷ rows are still read about once.
const MOST_ROWS: u64 = 360_000;

/// What there is to doubt of logs that are to be fitted, those without a mass taken for `mass_kg`.
///
/// # Errors
/// A log that cannot be read or is not one of this robot; power that is 0 all the time.
pub fn look(context: &Context, robot: &Robot, files: &[PathBuf], mass_kg: f64) -> Result<Vec<Warning>> {
    let mut warnings = Vec::new();
    let mut untold = Vec::new();
    let mut tells = false;
    foreign::prepare(context, files);
    for files in files.chunks(rayon::current_num_threads()) {
        // Opened in their order: notices are given then, and pipes come one by one.
        let readers: Vec<_> = files.iter().map(|file| SampleReader::open(context, file, robot)).collect();
        let seen: Vec<_> = readers.into_par_iter().map(|reader| look_at(robot, reader?)).collect();
        for (file, seen) in files.iter().zip(seen) {
            let (suspicions, stuck, told) = seen?;
            warnings.extend(stuck.iter().map(|stuck| {
                Warning::of_log(format!(
                    "{}: {stuck}; check the sensor, leave this stretch out",
                    file.display()
                ))
            }));
            tells |= told;
            if !told {
                untold.push(file);
            }
            for suspicion in &suspicions {
                warnings.push(judge(file, suspicion, mass_kg)?);
            }
        }
    }
    // Where no log tells, that is what was asked for.
    if tells && let Some(first) = untold.first() {
        let others = untold.len() - 1;
        let others = if others > 0 { format!(" (and {others} more)") } else { String::new() };
        warnings.push(Warning::of_log(format!(
            "{}{others}: no {MASS}, taken for {mass_kg} kg: --mass says otherwise",
            first.display()
        )));
    }
    Ok(warnings)
}

/// Refuses several logs none of which says what the robot weighed: taken for one mass, they would
/// say nothing of the payload.
///
/// # Errors
/// Says how masses are given (wrong usage); a log that cannot be read.
pub fn check_masses(context: &Context, robot: &Robot, files: &[PathBuf]) -> Result<()> {
    if files.len() < 2 {
        return Ok(());
    }
    for file in files {
        if robot.log_units().mass_of(file).is_some() || Header::open(context, file)?.has(MASS) {
            return Ok(());
        }
    }
    let names: Vec<String> = files.iter().take(2).map(|file| format!("{}=KG", file.display())).collect();
    Err(Error::usage(format!(
        "none of the {} logs says what the robot weighed; expected the total mass behind each name: {}; or --mass KG where it is the same \
         in all",
        files.len(),
        names.join(" ")
    )))
}

/// What there is to doubt of a log, what stands still in it, and whether it tells masses.
fn look_at(robot: &Robot, mut reader: SampleReader) -> Result<(Vec<Suspicion>, Vec<Stuck>, bool)> {
    let gap = logs::MIN_GAP_FACTOR * reader.period_s();
    let mut look = Look::new(robot);
    let mut standings = Standings::new(robot, robot.wheels());
    let mut told = false;
    while reader.rows() < MOST_ROWS
        && let Some(row) = reader.next_row()?
    {
        told |= row.mass.is_some();
        let mass = row.mass.unwrap_or(f64::NAN);
        let fresh = row.elapsed.is_infinite() || row.elapsed > gap;
        standings.add(row.line, row.time, fresh, &row.sample.wheel_speed, row.sample.power);
        look.add(row.time, fresh, &row.sample.wheel_speed, row.sample.power, mass);
    }
    Ok((look.finish(), standings.finish(), told))
}

fn judge(file: &Path, suspicion: &Suspicion, mass_kg: f64) -> Result<Warning> {
    let Suspicion { kind, text, remedy } = suspicion;
    match kind {
        Kind::NoPower => Err(Error::failed(format!("{text}; {remedy}")).in_file(file).in_column(POWER)),
        Kind::Unlabelled => Ok(Warning::of_log(format!(
            "{}: {text}, which are taken for {mass_kg} kg; {remedy}",
            file.display()
        ))),
        _ => Ok(Warning::of_log(format!("{}: {text}; {remedy}", file.display()))),
    }
}
