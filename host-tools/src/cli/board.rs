//! `gmr board`: the virtual board and its robot, for whoever opens the link.

use std::io::{IsTerminal as _, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use board::transport::Transport as _;
use firmware::control_table::BOARD_ID;
use firmware::dynamixel::packet::{Instruction, encode};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use plant::{Kinematics, ProfileKind, Robot};
use serde::Serialize;
use support::error::{Error, Result};
use support::interrupt;
use support::output::{check_apart, write_whole};
use support::own::Form;
use virtual_board::board::{BoardOptions, VirtualBoard};
use virtual_board::faults::FaultScript;
use virtual_board::flash::VirtualFlash;
use virtual_board::pace::Pace;
use virtual_board::qemu::BoardLog;
use virtual_board::robot::{RobotOptions, VirtualRobot};
use virtual_board::terminal::{Heard, VirtualTerminal, wait_for_any};
use virtual_board::truth::{HEADER, PERIOD_US, TruthRows};

use super::drive::DriveArguments;
use super::overwrite::OverwriteArgument;

/// Where cargo puts the image.
const IMAGE: &str = "target/thumbv7em-none-eabihf/release/virtual";

/// The profile that lets the board drive.
const DRIVEN_BY_BOARD: &str = "none";

/// Board time between two looks at the link: a tenth of a sample.
const LINK_PERIOD: Duration = Duration::from_micros(500);

/// Bytes that wait on either way of the link at most: some seconds of what a board says.
const MOST_QUEUED: usize = 1 << 16;

/// Bytes of the answer to a ping.
const PING_ANSWER_BYTES: usize = 14;
/// A board answers within milliseconds of its time.
const LONGEST_START: Duration = Duration::from_secs(5);

/// Longest wait for anything, so that Ctrl-C is heard.
const LOOK: Duration = Duration::from_millis(20);

/// Arguments of `gmr board`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr board --link /tmp/board --speed max")]
pub(crate) struct Arguments {
    #[command(flatten)]
    drive: DriveArguments,
    /// Board seconds per second: a number, or max
    #[arg(long, default_value = "1", value_name = "N|max")]
    speed: String,
    /// Keep to wall time whatever clients do: for programs written for the real board, which have
    /// time limits of their own
    #[arg(long, conflicts_with_all = ["speed", "wait"])]
    realtime: bool,
    /// Stand still until a client has sent its first byte
    #[arg(long)]
    wait: bool,
    /// Standard deviation of a power reading of motors and battery, W
    #[arg(long, default_value_t = 0.1, allow_negative_numbers = true)]
    power_noise: f64,
    /// Start with so much in a battery of the TurtleBot3's size, 0 to 1, that empties [default: one
    /// that never does]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    charge: Option<f64>,
    /// The laser scanner stands still
    #[arg(long)]
    no_lidar: bool,
    /// Make a symbolic link to the pseudo terminal
    #[arg(long, value_name = "PATH")]
    link: Option<PathBuf>,
    /// The same for the port of the ROS node, which the stock firmware would have
    #[arg(long, value_name = "PATH")]
    node: Option<PathBuf>,
    /// Inject faults at their times (docs/board.md)
    #[arg(long, value_name = "FILE.toml")]
    faults: Option<PathBuf>,
    /// Keep the board's flash in a file
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,
    /// Write what was true, 200 times a second: speeds, mass, power of drives and rails
    #[arg(long, value_name = "FILE.csv")]
    truth: Option<PathBuf>,
    /// The board's image
    #[arg(long, value_name = "ELF", default_value = IMAGE)]
    image: PathBuf,
    /// Show the board's log (needs defmt-print)
    #[arg(long)]
    log: bool,
    /// Print what was run as JSON, at the end
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Summary<'a> {
    board_s: f64,
    wall_s: f64,
    speed: f64,
    exchanges: u64,
    link: &'a Path,
    received_bytes: u64,
    sent_bytes: u64,
    actuation_j: f64,
    mass_kg: f64,
    /// What is left in the battery, 0 to 1.
    charge: Option<f64>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    check_apart(
        arguments.truth.iter().chain(&arguments.flash).map(PathBuf::as_path),
        [Path::new(&arguments.drive.profile), &arguments.image],
    )?;
    arguments.overwrite.check(&arguments.truth, Form::Truth)?;
    let factor = speed(&arguments.speed)?;
    let robot = robot(arguments)?;
    let interrupted = interrupt::catch();
    let flash = arguments.flash.as_deref().map_or_else(|| Ok(VirtualFlash::default()), VirtualFlash::open)?;
    let terminal = VirtualTerminal::hidden(arguments.link.as_deref())?;
    let node = VirtualTerminal::hidden(arguments.node.as_deref())?;
    let faults = arguments.faults.as_deref().map_or_else(|| Ok(FaultScript::default()), FaultScript::read)?;
    let log = if arguments.log { BoardLog::Print } else { BoardLog::Discard };
    let options = BoardOptions { flash, log, ..BoardOptions::default() };
    let board = VirtualBoard::start(&arguments.image, robot, options)?;

    let mut session = Session {
        board,
        terminal,
        node,
        faults,
        is_waiting: !arguments.realtime,
        pace: Pace::new(factor, Instant::now()),
        begun: Instant::now(),
        looked_at_link: None,
        bytes: [0; 2],
        interrupted,
    };
    match &arguments.truth {
        None => session.run(arguments, None)?,
        Some(path) => write_whole(path, |file| session.run(arguments, Some((file, path))))?,
    }
    session.report(arguments)
}

fn speed(text: &str) -> Result<Option<f64>> {
    if text == "max" {
        return Ok(None);
    }
    let factor = text.parse().ok().filter(|factor: &f64| (1e-3..=1e6).contains(factor));
    factor.map(Some).ok_or_else(|| {
        Error::usage(format!("speed `{text}`; allowed: times real time, 0.001 to 1e6, or max"))
    })
}

fn robot(arguments: &Arguments) -> Result<VirtualRobot> {
    let driven_by_board = arguments.drive.profile == DRIVEN_BY_BOARD;
    let scenario = if driven_by_board {
        {
            let robot = Robot::new(arguments.drive.plant, Kinematics::Differential);
            arguments.drive.scenario_of(ProfileKind::Standstill, robot)?
        }
    } else {
        arguments.drive.scenario(Kinematics::Differential)?
    };
    let options = RobotOptions {
        power_noise_w: arguments.power_noise,
        lidar: !arguments.no_lidar,
        driven_by_board,
        charge: arguments.charge,
    };
    VirtualRobot::new(scenario, options)
}

/// A board, its link, and who keeps the time.
struct Session {
    board: VirtualBoard,
    terminal: VirtualTerminal,
    node: VirtualTerminal,
    faults: FaultScript,
    /// The board's time waits for an active client.
    is_waiting: bool,
    pace: Pace,
    begun: Instant,
    /// The board's time then.
    looked_at_link: Option<Duration>,
    /// From the client, to the client.
    bytes: [u64; 2],
    interrupted: &'static AtomicBool,
}

impl Session {
    /// Until the run is over, or somebody ends it.
    fn run(&mut self, arguments: &Arguments, mut truth: Option<(&mut dyn Write, &Path)>) -> Result<()> {
        let end = Duration::from_secs_f64(arguments.drive.duration);
        let (mut rows, mut text) = (TruthRows::default(), String::from(HEADER));
        if truth.is_some() {
            self.board.server_mut().note_truths(PERIOD_US);
        }
        self.wait_for_board()?;
        self.show_links(arguments)?;
        if arguments.wait {
            while self.bytes == [0; 2] && !self.interrupted.load(Ordering::Relaxed) {
                self.terminal.wait(LOOK);
                self.look_at_link()?;
            }
        }
        self.begun = Instant::now();
        self.pace.restart(self.begun, self.board.now());
        let bar = status_line();
        let mut shown = Instant::now();
        while self.board.now() < end && !self.interrupted.load(Ordering::Relaxed) {
            self.step()?;
            if let Some((file, path)) = &mut truth
                && self.board.server().has_truths()
            {
                for truth in self.board.server_mut().take_truths() {
                    rows.push(&mut text, &truth);
                }
                file.write_all(text.as_bytes()).map_err(|error| Error::io(path, &error))?;
                text.clear();
            }
            if !bar.is_hidden() && shown.elapsed() > Duration::from_millis(500) {
                shown = Instant::now();
                self.show(&bar);
            }
        }
        bar.finish_and_clear();
        Ok(())
    }

    /// Lets the board run until it has answered a ping on both ports: a tenth of a second, in which
    /// the emulator starts.
    fn wait_for_board(&mut self) -> Result<()> {
        let mut buffer = [0; 16];
        let ping = encode(BOARD_ID, Instruction::Ping, &[], &mut buffer)
            .map_err(|_| Error::failed("a ping does not fit its place"))?
            .to_vec();
        let server = self.board.server_mut();
        server.to_board.extend(&ping);
        server.node_to_board.extend(&ping);
        while self.board.server().from_board.len() < PING_ANSWER_BYTES
            || self.board.server().node_from_board.len() < PING_ANSWER_BYTES
        {
            if self.interrupted.load(Ordering::Relaxed) {
                return Ok(());
            }
            if self.board.now() > LONGEST_START {
                return Err(Error::failed(format!(
                    "the virtual board has not answered within {} s of its time",
                    LONGEST_START.as_secs()
                )));
            }
            self.faults.apply(self.board.now(), self.board.robot_mut());
            self.board.try_exchange(LOOK)?;
        }
        let server = self.board.server_mut();
        server.from_board.clear();
        server.node_from_board.clear();
        Ok(())
    }

    /// From here on a client that opens a port is answered.
    fn show_links(&mut self, arguments: &Arguments) -> Result<()> {
        self.terminal.show()?;
        self.node.show()?;
        eprintln!("link: {}", arguments.link.as_deref().unwrap_or(self.terminal.path()).display());
        eprintln!("node: {}", arguments.node.as_deref().unwrap_or(self.node.path()).display());
        Ok(())
    }

    /// One request of the board, or a wait for the client or the clock.
    fn step(&mut self) -> Result<()> {
        let wait = self.pace.wait(Instant::now(), self.board.now());
        if !wait.is_zero() {
            wait_for_any([&self.terminal, &self.node], wait.min(LOOK));
            return self.look_at_link();
        }
        self.faults.apply(self.board.now(), self.board.robot_mut());
        self.board.try_exchange(LOOK)?;
        let due = self.looked_at_link.is_none_or(|at| self.board.now() >= at + LINK_PERIOD);
        if due { self.look_at_link() } else { Ok(()) }
    }

    /// Bytes both ways between terminal and board.
    fn look_at_link(&mut self) -> Result<()> {
        let now = self.board.now();
        self.looked_at_link = Some(now);
        self.look_at_node()?;
        let mut buffer = [0; 4096];
        let server = self.board.server_mut();
        // A client that sends faster than the board reads waits, as on a wire.
        if server.to_board.len() > MOST_QUEUED {
            return Ok(());
        }
        match self.terminal.receive(&mut buffer)? {
            Heard::Bytes(count) => {
                server.to_board.extend(&buffer[..count]);
                self.bytes[0] += count as u64;
                if self.is_waiting {
                    self.pace.hear(Instant::now(), now);
                }
            }
            Heard::Nothing => {}
            Heard::HungUp => {
                // As over USB: what nobody reads is gone.
                server.from_board.clear();
                self.pace.hang_up();
            }
        }
        // A client that has opened the port and reads nothing loses what a host's buffer does not
        // hold.
        if server.from_board.len() > MOST_QUEUED {
            server.from_board.clear();
        }
        while !server.from_board.is_empty() {
            let (front, _) = server.from_board.as_slices();
            let count = self.terminal.send(front)?;
            if count == 0 {
                break;
            }
            server.from_board.drain(..count);
            self.bytes[1] += count as u64;
        }
        Ok(())
    }

    /// The same for the node's port.
    fn look_at_node(&mut self) -> Result<()> {
        let mut buffer = [0; 4096];
        let server = self.board.server_mut();
        match self.node.receive(&mut buffer)? {
            Heard::Bytes(count) => server.node_to_board.extend(&buffer[..count]),
            Heard::Nothing => {}
            Heard::HungUp => server.node_from_board.clear(),
        }
        while !server.node_from_board.is_empty() {
            let (front, _) = server.node_from_board.as_slices();
            let count = self.node.send(front)?;
            if count == 0 {
                break;
            }
            server.node_from_board.drain(..count);
        }
        Ok(())
    }

    fn show(&mut self, bar: &ProgressBar) {
        let (board_s, speed) = (self.board.now().as_secs_f64(), self.speed());
        let truth = self.board.robot_mut().truth();
        let [battery, motors, ..] = truth.rails;
        bar.set_message(format!(
            "{board_s:.1} s, {speed:.1} × real time, {} kg, motors {:.2} W, battery {:.2} W",
            truth.mass_kg, motors.power_w, battery.power_w
        ));
        bar.tick();
    }

    fn speed(&self) -> f64 {
        self.board.now().as_secs_f64() / self.begun.elapsed().as_secs_f64().max(1e-9)
    }

    fn report(mut self, arguments: &Arguments) -> Result<()> {
        let (board_s, wall_s) = (self.board.now().as_secs_f64(), self.begun.elapsed().as_secs_f64());
        let (exchanges, speed) = (self.board.exchanges(), self.speed());
        if !arguments.json {
            eprintln!("{board_s:.3} s in {wall_s:.3} s: {speed:.1} × real time, {exchanges} exchanges");
            return Ok(());
        }
        let truth = self.board.robot_mut().truth();
        support::output::print_json(&Summary {
            board_s,
            wall_s,
            speed,
            exchanges,
            link: self.terminal.path(),
            received_bytes: self.bytes[0],
            sent_bytes: self.bytes[1],
            actuation_j: truth.actuation_j,
            mass_kg: truth.mass_kg,
            charge: truth.charge,
        })
    }
}

/// A line on standard error; none when that is no terminal.
fn status_line() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style =
        ProgressStyle::with_template("{spinner} {msg}").unwrap_or_else(|_| ProgressStyle::default_spinner());
    ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()).with_style(style)
}
