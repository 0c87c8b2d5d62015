//! `gmr record`: a live log from a board.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;

use board::client::{Board, Client};
use board::live_view::{ADDRESS, LiveView};
use board::mcap_lines::McapLines;
use board::recorder::{self, Ending, Options, Progress, Recording};
use board::serial::Serial;
use board::{health_text, rail_names};
use firmware::power_sensors::Health;
use serde::Serialize;
use support::error::{Error, Result};
use support::interrupt;
use support::progress::RecordProgress;

/// Arguments of `gmr record`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr record --port /dev/ttyACM1 --mass 1.0 --out empty.csv\n  gmr record --port /dev/ttyACM1 --format mcap --out run.mcap\n  gmr record --port /dev/ttyACM1 --out run.mcap --foxglove"
)]
pub(crate) struct Arguments {
    /// The board's serial port, for example /dev/ttyACM1
    #[arg(long)]
    port: PathBuf,
    /// The log to write. It grows while the board is recorded
    #[arg(long, value_name = "RUN.csv")]
    out: PathBuf,
    /// As what: MCAP with messages in JSON is opened by PlotJuggler and Foxglove without ROS
    /// [default: by the name's ending, else csv]
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Show each sample live over Foxglove's WebSocket as well, as the message of --format mcap
    /// (feature foxglove)
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, default_missing_value = ADDRESS)]
    foxglove: Option<String>,
    /// Length of the log on the board's clock, s [default: until Ctrl-C]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Total mass, kg, where it is known: for gmr fit
    #[arg(long, value_name = "KG", allow_negative_numbers = true)]
    mass: Option<f64>,
    /// Begin with what the board still keeps of the time before: its last seconds
    #[arg(long)]
    backlog: bool,
    /// Write over an existing log
    #[arg(long)]
    force: bool,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    Csv,
    Mcap,
}

#[derive(Serialize)]
struct Report<'a> {
    file: &'a Path,
    rows: u64,
    lost: u64,
    incomplete: u64,
    duration_s: f64,
    rate_hz: f64,
    resent: u64,
    ended: &'static str,
    board: &'a Board,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let options = options(arguments)?;
    if arguments.out.exists() && !arguments.force {
        let message = "exists already; expected another name, or --force to write over it";
        return Err(Error::failed(message).in_file(&arguments.out));
    }
    let mut live = arguments.foxglove.as_deref().map(LiveView::open).transpose()?;
    if let Some(live) = &live {
        eprintln!("live view: {}", live.url());
    }
    let at_port = |error: Error| error.in_file(&arguments.port);
    let (mut client, board) = Client::connect(Serial::open(&arguments.port)?).map_err(at_port)?;
    let stopped = interrupt::catch();
    let is_mcap = arguments.out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
    let format = arguments.format.unwrap_or(if is_mcap { Format::Mcap } else { Format::Csv });
    let mut log =
        Log { path: &arguments.out, force: arguments.force, format, file: None, mcap: None, whole: 0 };
    let mut bar = RecordProgress::new(options.duration);
    let mut take = |lines: &str| {
        log.append(lines)?;
        live.as_mut().map_or(Ok(()), |live| live.append(lines))
    };
    let result = recorder::record(&mut client, &board, &options, &mut take, &mut |now| {
        bar.at(now.elapsed, || describe(now));
        if stopped.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    bar.finish();
    log.finish()?;
    if let Some(live) = live {
        live.finish();
    }
    match result {
        Ok(recording) if recording.rows > 0 => report(arguments, &board, recording, client.retries()),
        Ok(_) => Err(Error::failed("stopped before the first sample").in_file(&arguments.port)),
        Err(error) => Err(at_port(error)),
    }
}

/// The log, which begins to exist with the first sample: a board that is not there costs no older
/// log.
struct Log<'a> {
    path: &'a Path,
    force: bool,
    format: Format,
    file: Option<File>,
    mcap: Option<McapLines<BufWriter<File>>>,
    /// Bytes of whole lines.
    whole: u64,
}

impl Log<'_> {
    /// In one write: whatever ends this process leaves no half of a line, and a full disk none
    /// either.
    fn append(&mut self, lines: &str) -> Result<()> {
        let refused = |error: std::io::Error| Error::io(self.path, &error);
        if let Some(mcap) = &mut self.mcap {
            return mcap.append(lines).map_err(|error| error.in_file(self.path));
        }
        if self.file.is_none() {
            let mut options = File::options();
            options.write(true);
            if self.force {
                options.create(true).truncate(true);
            } else {
                options.create_new(true);
            }
            let file = options.open(self.path).map_err(refused)?;
            if self.format == Format::Mcap {
                let mcap = self.mcap.insert(McapLines::new(BufWriter::new(file)));
                return mcap.append(lines).map_err(|error| error.in_file(self.path));
            }
            self.file = Some(file);
        }
        let Some(file) = &mut self.file else { return Ok(()) };
        if let Err(error) = file.write_all(lines.as_bytes()) {
            // What of the lines found room goes again; a pipe or a device keeps what it has.
            let _ = file.set_len(self.whole);
            return Err(refused(error));
        }
        self.whole += lines.len() as u64;
        Ok(())
    }
}

impl Log<'_> {
    /// What MCAP ends with; lines are whole as they are.
    fn finish(&mut self) -> Result<()> {
        self.mcap.take().map_or(Ok(()), |mcap| mcap.finish().map_err(|error| error.in_file(self.path)))
    }
}

fn options(arguments: &Arguments) -> Result<Options> {
    if let Some(mass) = arguments.mass
        && !(mass > 0.0 && mass.is_finite())
    {
        return Err(Error::usage(format!("--mass {mass}: expected a mass above 0 kg")));
    }
    let duration = arguments.duration.map(|seconds| match Duration::try_from_secs_f64(seconds) {
        Ok(duration) if !duration.is_zero() => Ok(duration),
        _ => Err(Error::usage(format!("--duration {seconds}: expected a length above 0 s"))),
    });
    Ok(Options { duration: duration.transpose()?, mass_kg: arguments.mass, backlog: arguments.backlog })
}

/// What a recording looks like just now.
fn describe(now: &Progress<'_>) -> String {
    let mut text = format!("{} samples", now.rows);
    if now.elapsed > Duration::ZERO {
        text += &format!(", {:.0} Hz", now.rows.saturating_sub(1) as f64 / now.elapsed.as_secs_f64());
    }
    if now.lost > 0 {
        text += &format!(", {} lost", now.lost);
    }
    let Some(last) = now.last else { return text };
    for (name, power) in rail_names().into_iter().zip(last.rail_power) {
        if name == "motors" {
            text += &power.map_or(", motors ?".to_owned(), |power| format!(", motors {power:.2} W"));
        }
    }
    if last.has_coefficients {
        text += &match last.mass {
            Some(mass) => format!(", {:.2} kg ({:.2} … {:.2})", mass.mass, mass.low, mass.high),
            None => ", mass unknown".to_owned(),
        };
    }
    if last.wheel_speed.is_none() {
        text += ", wheels silent";
    }
    for (name, health) in rail_names().into_iter().zip(last.health) {
        if health != Health::Ok {
            text += &format!(", {name} {}", health_text(health));
        }
    }
    text
}

fn report(arguments: &Arguments, board: &Board, recording: Recording, resent: u64) -> Result<()> {
    let seconds = recording.elapsed.as_secs_f64();
    let rate_hz = if seconds > 0.0 {
        (recording.rows + recording.lost).saturating_sub(1) as f64 / seconds
    } else {
        f64::from(board.sample_rate_hz)
    };
    let report = Report {
        file: &arguments.out,
        rows: recording.rows,
        lost: recording.lost,
        incomplete: recording.incomplete,
        duration_s: seconds,
        rate_hz,
        resent,
        ended: match recording.ending {
            Ending::Complete => "complete",
            Ending::Stopped => "stopped",
            Ending::Restarted => "restarted",
            Ending::Jumped { .. } => "clock jumped",
            Ending::Lost(_) => "lost",
        },
        board,
    };
    if arguments.json {
        support::output::print_json(&report)?;
    }
    let saved =
        format!("{}: {} samples, {seconds:.2} s at {rate_hz:.1} Hz", arguments.out.display(), report.rows);
    if recording.lost > 0 {
        eprintln!("gmr: {} samples were lost: gaps in the log", recording.lost);
    }
    if recording.incomplete > 0 {
        eprintln!(
            "gmr: {} samples lack wheel speeds or the motors' power: other commands leave them out",
            recording.incomplete
        );
    }
    match recording.ending {
        Ending::Complete | Ending::Stopped => {
            eprintln!("{saved}");
            Ok(())
        }
        Ending::Restarted => {
            let message = format!("the board started again, which ends the log; saved up to then: {saved}");
            Err(Error::failed(message).in_file(&arguments.port))
        }
        Ending::Jumped { seconds } => {
            let message = format!(
                "the board's clock jumped by {seconds:.1} s between two samples, which ends the log; saved up to then: {saved}"
            );
            Err(Error::failed(message).in_file(&arguments.port))
        }
        Ending::Lost(error) => {
            let error = error.in_file(&arguments.port);
            Err(Error::failed(format!("{error}; saved up to then: {saved}")))
        }
    }
}
