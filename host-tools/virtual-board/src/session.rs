//! A board, its links, and who keeps the time: what `gmr board` is asked to do.

use std::collections::VecDeque;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use board::transport::Transport as _;
use firmware::control_table::BOARD_ID;
use firmware::dynamixel::packet::{Instruction, encode};
use serde::Serialize;
use support::error::{Error, Result};
use support::interrupt;
use support::output::write_whole;

use crate::board::{BoardOptions, VirtualBoard};
use crate::faults::FaultScript;
use crate::flash::VirtualFlash;
use crate::pace::Pace;
use crate::qemu::BoardLog;
use crate::robot::VirtualRobot;
use crate::terminal::{Heard, VirtualTerminal, wait_for_any};
use crate::truth::{HEADER, PERIOD_US, TruthRows};

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

/// Between two reports to a [`Watcher`].
const REPORT: Duration = Duration::from_millis(500);

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The board's image.
    pub image: &'a Path,
    /// How long it runs, s of the board's time.
    pub duration_s: f64,
    /// Board seconds a second; none: as fast as it goes.
    pub speed: Option<f64>,
    /// The board's time waits for an active client.
    pub waits_for_clients: bool,
    /// It stands still until a client has sent its first byte.
    pub waits_for_first: bool,
    /// Symbolic links to the pseudo terminals.
    pub link: Option<&'a Path>,
    /// The same of the node's port.
    pub node: Option<&'a Path>,
    /// A script of faults.
    pub faults: Option<&'a Path>,
    /// Where the flash is kept.
    pub flash: Option<&'a Path>,
    /// Where the truth is written.
    pub truth: Option<&'a Path>,
    /// Whether the board's log is printed.
    pub log: bool,
}

/// What was run.
#[derive(Debug, Serialize)]
pub struct Answer {
    /// The board's time, s.
    pub board_s: f64,
    /// The wall clock's, s.
    pub wall_s: f64,
    /// Board seconds a second.
    pub speed: f64,
    /// Requests of the board that were answered.
    pub exchanges: u64,
    /// The pseudo terminal.
    pub link: PathBuf,
    /// From the client.
    pub received_bytes: u64,
    /// To the client.
    pub sent_bytes: u64,
    /// Energy of the drives, J.
    pub actuation_j: f64,
    /// Total mass at the end, kg.
    pub mass_kg: f64,
    /// What is left in the battery, 0 to 1.
    pub charge: Option<f64>,
}

/// How it goes.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// The board's time, s.
    pub board_s: f64,
    /// Board seconds a second.
    pub speed: f64,
    /// Total mass, kg.
    pub mass_kg: f64,
    /// Of the motors' rail, W.
    pub motors_w: f64,
    /// Of the battery's, W.
    pub battery_w: f64,
}

/// Who is told how it goes.
pub trait Watcher {
    /// From here on a client that opens a port is answered.
    fn links(&mut self, link: &Path, node: &Path);
    /// Twice a second.
    fn at(&mut self, progress: &Progress);
}

/// Runs the firmware with a robot around it until its time is over, or somebody ends it.
///
/// # Errors
/// No emulator or image; scripts and files that cannot be read or written; a board that does not
/// answer.
pub fn session(request: &Request<'_>, robot: VirtualRobot, watcher: &mut dyn Watcher) -> Result<Answer> {
    let interrupted = interrupt::catch();
    let flash = request.flash.map_or_else(|| Ok(VirtualFlash::default()), VirtualFlash::open)?;
    let terminal = VirtualTerminal::hidden(request.link)?;
    let node = VirtualTerminal::hidden(request.node)?;
    let faults = request.faults.map_or_else(|| Ok(FaultScript::default()), FaultScript::read)?;
    let log = if request.log { BoardLog::Print } else { BoardLog::Discard };
    let options = BoardOptions { flash, log, ..BoardOptions::default() };
    let board = VirtualBoard::start(request.image, robot, options)?;
    let mut session = Session {
        board,
        terminal,
        node,
        faults,
        is_waiting: request.waits_for_clients,
        pace: Pace::new(request.speed, Instant::now()),
        begun: Instant::now(),
        looked_at_link: None,
        bytes: [0; 2],
        interrupted,
    };
    match request.truth {
        None => session.run(request, watcher, None)?,
        Some(path) => write_whole(path, |file| session.run(request, watcher, Some((file, path))))?,
    }
    Ok(session.answer())
}

struct Session {
    board: VirtualBoard,
    terminal: VirtualTerminal,
    node: VirtualTerminal,
    faults: FaultScript,
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
    fn run(
        &mut self,
        request: &Request<'_>,
        watcher: &mut dyn Watcher,
        mut truth: Option<(&mut dyn Write, &Path)>,
    ) -> Result<()> {
        let end = Duration::from_secs_f64(request.duration_s);
        let (mut rows, mut text) = (TruthRows::default(), String::from(HEADER));
        if truth.is_some() {
            self.board.server_mut().note_truths(PERIOD_US);
        }
        self.wait_for_board()?;
        self.show_links(request, watcher)?;
        if request.waits_for_first {
            while self.bytes == [0; 2] && !self.interrupted.load(Ordering::Relaxed) {
                self.terminal.wait(LOOK);
                self.look_at_link()?;
            }
        }
        self.begun = Instant::now();
        self.pace.restart(self.begun, self.board.now());
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
            if shown.elapsed() > REPORT {
                shown = Instant::now();
                watcher.at(&self.progress());
            }
        }
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
    fn show_links(&mut self, request: &Request<'_>, watcher: &mut dyn Watcher) -> Result<()> {
        self.terminal.show()?;
        self.node.show()?;
        let link = request.link.unwrap_or(self.terminal.path());
        watcher.links(link, request.node.unwrap_or(self.node.path()));
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

    /// Bytes both ways between the terminals and the board.
    fn look_at_link(&mut self) -> Result<()> {
        let now = self.board.now();
        self.looked_at_link = Some(now);
        let server = self.board.server_mut();
        exchange(&mut self.node, &mut server.node_to_board, &mut server.node_from_board)?;
        let (heard, sent) = exchange(&mut self.terminal, &mut server.to_board, &mut server.from_board)?;
        self.bytes[1] += sent;
        match heard {
            Heard::Bytes(count) => {
                self.bytes[0] += count as u64;
                if self.is_waiting {
                    self.pace.hear(Instant::now(), now);
                }
            }
            Heard::Nothing => {}
            Heard::HungUp => self.pace.hang_up(),
        }
        Ok(())
    }

    fn progress(&mut self) -> Progress {
        let (board_s, speed) = (self.board.now().as_secs_f64(), self.speed());
        let truth = self.board.robot_mut().truth();
        let [battery, motors, ..] = truth.rails;
        let (motors_w, battery_w) = (motors.power_w, battery.power_w);
        Progress { board_s, speed, mass_kg: truth.mass_kg, motors_w, battery_w }
    }

    fn speed(&self) -> f64 {
        self.board.now().as_secs_f64() / self.begun.elapsed().as_secs_f64().max(1e-9)
    }

    fn answer(mut self) -> Answer {
        let (board_s, wall_s) = (self.board.now().as_secs_f64(), self.begun.elapsed().as_secs_f64());
        let (exchanges, speed) = (self.board.exchanges(), self.speed());
        let truth = self.board.robot_mut().truth();
        Answer {
            board_s,
            wall_s,
            speed,
            exchanges,
            link: self.terminal.path().to_owned(),
            received_bytes: self.bytes[0],
            sent_bytes: self.bytes[1],
            actuation_j: truth.actuation_j,
            mass_kg: truth.mass_kg,
            charge: truth.charge,
        }
    }
}

/// What the client has sent, and what it takes now: heard, and how many bytes were sent.
fn exchange(
    terminal: &mut VirtualTerminal,
    to_board: &mut VecDeque<u8>,
    from_board: &mut VecDeque<u8>,
) -> Result<(Heard, u64)> {
    let mut buffer = [0; 4096];
    // A client that sends faster than the board reads waits, as on a wire.
    let heard = if to_board.len() > MOST_QUEUED { Heard::Nothing } else { terminal.receive(&mut buffer)? };
    if let Heard::Bytes(count) = heard {
        to_board.extend(&buffer[..count]);
    }
    // As over USB: what nobody reads is gone. A client that has opened the port and reads nothing
    // loses what a host's buffer does not hold.
    if matches!(heard, Heard::HungUp) || from_board.len() > MOST_QUEUED {
        from_board.clear();
    }
    Ok((heard, send(from_board, terminal)?))
}

/// Sends as much as the terminal takes now. Gives the bytes.
fn send(queued: &mut VecDeque<u8>, terminal: &mut VirtualTerminal) -> Result<u64> {
    let mut sent = 0;
    while !queued.is_empty() {
        let count = terminal.send(queued.as_slices().0)?;
        if count == 0 {
            break;
        }
        queued.drain(..count);
        sent += count as u64;
    }
    Ok(sent)
}
