//! What `gmr estimate` asks of a log, and what it is told.

use std::path::Path;

use logs::robot::Robot;
use model::coefficients::{CoefficientsFile, Taking};
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::figure::figure;
use support::output::write_whole;
use support::overwrite::POWER;

use crate::inspect;

use super::board::{self, BoardReport, BoardTrack, Delay};
use super::plot::Track;
use super::{Instant, Payloads, Policy, Recorded, Replay, WindowMass, replay_adapting, replay_at};

/// What is asked for.
#[derive(Debug, Clone)]
pub struct Request<'a> {
    /// The robot, which knows in which units its logs are.
    pub robot: &'a Robot,
    /// The log, and what its robot weighed where that is known beside it.
    pub recorded: Recorded<'a>,
    /// The coefficients.
    pub coeffs: &'a Path,
    /// Whether coefficients are taken that cannot be used.
    pub force: bool,
    /// How the mass is found; none: as the model has it.
    pub payloads: Option<Payloads>,
    /// When the mass is found.
    pub policy: Policy,
    /// Whether rolling resistance and scrub adapt beside the mass.
    pub adapt: bool,
    /// What was true, as a virtual board wrote it.
    pub truth: Option<&'a Path>,
    /// Where power over time is written.
    pub power: Option<&'a Path>,
    /// Where power and mass over time are drawn.
    pub plot: Option<&'a Path>,
}

/// A replay, and what there is beside it.
#[derive(Debug, Clone)]
pub struct Answer {
    /// The log, replayed.
    pub replay: Replay,
    /// The payload now, and since when it is the same, in a line.
    pub headline: String,
    /// Errors of the windows whose true mass the log tells.
    pub mass_error: Option<MassError>,
    /// The estimates that the board made of the same samples, where the log holds them.
    pub board: Option<BoardReport>,
    /// Changes of the true mass, where the truth is given.
    pub true_changes: Vec<Delay>,
}

/// Errors of the windows whose true mass the log tells.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct MassError {
    /// How many there are.
    pub windows: usize,
    /// Mean size.
    pub mean_percent: f64,
    /// The largest.
    pub worst_percent: f64,
    /// Share of the windows whose interval holds the true mass.
    pub interval_contains_truth: f64,
}

impl MassError {
    fn of(windows: &[WindowMass]) -> Option<Self> {
        let known: Vec<(f64, bool)> = windows
            .iter()
            .filter_map(|window| {
                let (mass, truth) = (window.mass_kg?, window.truth_kg?);
                let inside = window.low_kg? <= truth + 1e-9 && truth - 1e-9 <= window.high_kg?;
                Some((100.0 * (mass / truth - 1.0).abs(), inside))
            })
            .collect();
        if known.is_empty() {
            return None;
        }
        let count = known.len() as f64;
        Some(Self {
            windows: known.len(),
            mean_percent: known.iter().map(|(error, _)| error).sum::<f64>() / count,
            worst_percent: known.iter().map(|(error, _)| *error).fold(0.0, f64::max),
            interval_contains_truth: known.iter().filter(|(_, inside)| *inside).count() as f64 / count,
        })
    }
}

/// Replays a log with coefficients, and writes and draws what is asked for.
///
/// # Errors
/// Log, coefficients or truth cannot be read or are not of this robot; the policy's lengths do not
/// fit; a file cannot be written.
pub fn estimate(context: &Context, request: &Request<'_>) -> Result<Answer> {
    let Request { robot, recorded, coeffs, truth, .. } = *request;
    let taking = Taking { true_slip: true, not_usable: request.force.then_some(context) };
    let coefficients = CoefficientsFile::read_taking(coeffs, robot, taking)?.coefficients;
    inspect::check(context, robot, &[recorded.file.to_owned()], request.force)?;
    let payloads = request.payloads.unwrap_or(Payloads::default_for(&coefficients.model));
    let mut track = Track::default();
    let mut board = BoardTrack::open(context, recorded.file, truth, robot.mape_floor_w())?;
    let mut broken = None;
    let mut replay_to = |write: &mut dyn FnMut(&Instant) -> Result<()>| {
        let mut watch = |instant: &Instant| {
            let done = board.add(instant).and_then(|instant| {
                track.add(&instant);
                write(&instant)
            });
            if let Err(error) = done {
                broken.get_or_insert(error);
            }
        };
        if request.adapt {
            let replay =
                replay_adapting(context, robot, &coefficients, &recorded, &request.policy, &mut watch);
            return replay
                .map_err(|error| if error.file().is_none() { error.in_file(coeffs) } else { error });
        }
        replay_at(context, robot, &coefficients, &recorded, payloads, &request.policy, &mut watch)
    };
    let replay = match request.power {
        None => replay_to(&mut |_| Ok(())),
        Some(file) => write_whole(file, |out| {
            let failed = |error: std::io::Error| Error::io(file, &error);
            out.write_all(POWER.as_bytes()).map_err(failed)?;
            replay_to(&mut |instant| out.write_all(power_line(instant).as_bytes()).map_err(failed))
        }),
    }?;
    if let Some(error) = broken {
        return Err(error);
    }
    let end_s = replay.start_s + replay.duration_s;
    let delays = |truth| board::delays(context, truth, replay.start_s, end_s, &replay.changes);
    let true_changes = truth.map_or(Ok(Vec::new()), delays)?;
    let headline = headline(robot, &replay);
    if let Some(plot) = request.plot {
        track.page(&headline).save(plot)?;
    }
    if replay.exclusions.total() > 0 {
        context.notice(format_args!("{}: {}", recorded.file.display(), replay.exclusions));
    }
    let mass_error = MassError::of(&replay.windows);
    Ok(Answer { replay, headline, mass_error, board: board.report(), true_changes })
}

/// A row of [`POWER`]; empty where a figure is not known.
fn power_line(instant: &Instant) -> String {
    let (low, high) = instant.interval_kg.unzip();
    let fields = [Some(instant.measured_w), instant.predicted_w, instant.told_w, instant.mass_kg, low, high];
    let mut line = instant.time_s.to_string();
    for field in fields {
        line.push(',');
        line += &field.map_or_else(String::new, |number| number.to_string());
    }
    line + "\n"
}

/// The payload now, and since when it is the same.
fn headline(robot: &Robot, replay: &Replay) -> String {
    let since = match replay.changes.last() {
        Some(change) => format!("changed at {:.0} s", change.time_s),
        None => format!("no change in {:.0} s", replay.duration_s),
    };
    let known = |window: &&WindowMass| window.mass_kg.is_some();
    let Some(window) = replay.windows.iter().rev().find(known) else {
        let why = replay.windows.last().and_then(|window| window.unknown);
        let why = why.unwrap_or("the log is shorter than the window (--window)");
        return format!("Payload unknown: {why}");
    };
    let empty = robot.mass_no_load_kg();
    let (total, low, high) = match (window.mass_kg, window.low_kg, window.high_kg) {
        (Some(total), Some(low), Some(high)) => (total, low, high),
        (total, ..) => {
            return format!("Payload about {} kg, {since}", figure(total.unwrap_or(empty) - empty));
        }
    };
    let range = match window.range {
        Some("below") => " or less: lighter than the robot without payload",
        Some("above") => " or more: heavier than the robot with its full payload",
        _ => "",
    };
    // As many digits as the interval has.
    let digits = (1.0 - (high - low).max(1e-3).log10().floor()).clamp(0.0, 3.0) as usize;
    let payload = |mass: f64| format!("{:.digits$}", (mass - empty).max(0.0));
    format!(
        "Payload {} kg{range} ({} to {}, 95 %); total {total:.digits$} kg, {since}",
        payload(total),
        payload(low),
        payload(high)
    )
}
