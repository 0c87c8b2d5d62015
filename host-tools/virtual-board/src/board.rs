//! The virtual board as a whole: the emulator, the robot around it, and the link to it.
//!
//! Its time runs only while somebody receives from it or lets it run: it goes as fast as this
//! machine can, nothing piles up, and the same calls give the same bytes.

use std::path::Path;
use std::time::{Duration, Instant};

use board::transport::Transport;
use support::error::{Error, Result};
use tempfile::TempDir;

use super::exchange::ExchangeServer;
use super::flash::VirtualFlash;
use super::one_core::OneCore;
use super::pipes::{VirtualPipes, Waited};
use super::qemu::{BoardLog, Qemu};
use super::robot::VirtualRobot;

/// Instructions of the emulated core take 8 ns: 125 million a second, somewhat less than the real
/// core does.
const DEFAULT_SHIFT: u8 = 3;

/// A board that has asked for nothing for so long hangs. It asks some thousand times a second of
/// its own time.
const SILENCE: Duration = Duration::from_secs(20);

/// How often the emulator is looked at while nothing comes.
const LOOK: Duration = Duration::from_millis(100);

/// An answer of length 0: the end.
const END: [u8; 2] = [0, 0];

/// Settings of the emulator.
#[derive(Debug)]
pub struct BoardOptions {
    /// The store's sectors.
    pub flash: VirtualFlash,
    /// What happens to the board's log.
    pub log: BoardLog,
    /// An instruction takes 2^`shift` ns of the board's time.
    pub shift: u8,
}

impl Default for BoardOptions {
    fn default() -> Self {
        Self { flash: VirtualFlash::default(), log: BoardLog::Discard, shift: DEFAULT_SHIFT }
    }
}

/// Whoever is at the other end of the pipes.
pub trait Peer {
    /// How it ended; `None` while it runs.
    ///
    /// # Errors
    /// Nobody can say.
    fn ended(&mut self) -> Result<Option<String>>;

    /// It was asked to end: waits until it has.
    fn finish(&mut self);
}

impl Peer for Qemu {
    fn ended(&mut self) -> Result<Option<String>> {
        self.ended()
    }

    fn finish(&mut self) {
        self.wait(Duration::from_secs(2));
    }
}

/// A board in lockstep with its robot. Dropped, it ends and leaves only the flash's file. The
/// thread that starts it should be the one that runs it: both stay on one processor core.
pub struct VirtualBoard {
    // Dropped in this order: the process, its pipes, their folder.
    peer: Box<dyn Peer + Send>,
    pipes: VirtualPipes,
    _folder: TempDir,
    _core: OneCore,
    server: ExchangeServer,
    frame: Vec<u8>,
    last_request: Instant,
    has_ended: bool,
}

impl VirtualBoard {
    /// Starts an image on the emulator. It stands still until it is received from or run.
    ///
    /// # Errors
    /// No image, no emulator, no room for FIFOs.
    pub fn start(image: &Path, robot: VirtualRobot, options: BoardOptions) -> Result<Self> {
        let BoardOptions { flash, log, shift } = options;
        Self::with_peer(robot, flash, |folder| {
            Qemu::start(image, folder, shift, &log).map(|qemu| Box::new(qemu) as Box<dyn Peer + Send>)
        })
    }

    /// With whatever `start` makes speak through the FIFOs of a folder.
    ///
    /// # Errors
    /// `start` fails, or there is no room for FIFOs.
    pub fn with_peer(
        robot: VirtualRobot,
        flash: VirtualFlash,
        start: impl FnOnce(&Path) -> Result<Box<dyn Peer + Send>>,
    ) -> Result<Self> {
        let folder = tempfile::Builder::new()
            .prefix("gmr-board-")
            .tempdir()
            .map_err(|error| Error::failed(format!("no temporary folder for the virtual board: {error}")))?;
        let pipes = VirtualPipes::create(folder.path())?;
        let core = OneCore::choose();
        let peer = start(folder.path())?;
        Ok(Self {
            peer,
            pipes,
            _folder: folder,
            _core: core,
            server: ExchangeServer::new(robot, flash),
            frame: Vec::new(),
            last_request: Instant::now(),
            has_ended: false,
        })
    }

    /// The robot, for the truth and for faults.
    pub fn robot_mut(&mut self) -> &mut VirtualRobot {
        &mut self.server.robot
    }

    /// What the board's requests are answered from.
    pub fn server(&self) -> &ExchangeServer {
        &self.server
    }

    /// The same, to note truths or to look into the link.
    pub fn server_mut(&mut self) -> &mut ExchangeServer {
        &mut self.server
    }

    /// Requests answered so far.
    pub fn exchanges(&self) -> u64 {
        self.server.exchanges()
    }

    /// Lets the board's clock run for a time.
    ///
    /// # Errors
    /// The board is gone.
    pub fn run_for(&mut self, time: Duration) -> Result<()> {
        let until = self.now() + time;
        while self.now() < until {
            self.exchange()?;
        }
        Ok(())
    }

    /// Answers the board's next request.
    ///
    /// # Errors
    /// The board is gone, hangs or asks for what there is not.
    pub fn exchange(&mut self) -> Result<()> {
        while !self.try_exchange(LOOK)? {}
        Ok(())
    }

    /// Answers the board's next request if it comes within `limit`.
    ///
    /// # Errors
    /// The board is gone, hangs or asks for what there is not.
    pub fn try_exchange(&mut self, limit: Duration) -> Result<bool> {
        match self.pipes.wait(limit)? {
            Waited::Request => {
                self.server.answer(self.pipes.request(), &mut self.frame)?;
                self.pipes.answer(&self.frame)?;
                self.last_request = Instant::now();
                Ok(true)
            }
            Waited::Nothing => {
                if let Some(how) = self.peer.ended()? {
                    self.has_ended = true;
                    return Err(Error::failed(how));
                }
                if self.last_request.elapsed() > SILENCE {
                    let seconds = SILENCE.as_secs();
                    return Err(Error::failed(format!(
                        "the virtual board has asked for nothing for {seconds} s: does it hang?"
                    )));
                }
                Ok(false)
            }
            Waited::Closed => {
                self.has_ended = true;
                // The process ends just after it has closed the pipe.
                let begun = Instant::now();
                while begun.elapsed() < Duration::from_secs(2) {
                    if let Some(how) = self.peer.ended()? {
                        return Err(Error::failed(how));
                    }
                    std::thread::sleep(Duration::from_millis(2));
                }
                Err(Error::failed("the virtual board has closed its pipe"))
            }
        }
    }

    /// Ends the board: the answer to its next request is the end.
    fn end(&mut self) {
        if self.has_ended {
            return;
        }
        self.has_ended = true;
        // Best effort: whatever does not end is killed.
        if matches!(self.pipes.wait(LOOK), Ok(Waited::Request)) && self.pipes.answer(&END).is_ok() {
            self.peer.finish();
        }
    }
}

impl Drop for VirtualBoard {
    fn drop(&mut self) {
        self.end();
    }
}

impl Transport for VirtualBoard {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.server.to_board.extend(bytes);
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> Result<usize> {
        let until = self.now() + limit;
        while self.server.from_board.is_empty() && self.now() < until {
            self.exchange()?;
        }
        let count = buffer.len().min(self.server.from_board.len());
        for (place, byte) in buffer.iter_mut().zip(self.server.from_board.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }

    fn now(&self) -> Duration {
        Duration::from_micros(self.server.board_us())
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::{Read, Write};
    use std::path::PathBuf;
    use std::thread::JoinHandle;

    use firmware::exchange::{Kind, NOTICE_LINK};
    use plant::{Kinematics, PlantSet, ProfileKind, Scenario};

    use super::*;
    use crate::pipes::{ANSWERS, REQUESTS};
    use crate::robot::{RobotOptions, SENSOR_ADDRESSES};

    /// A board on a thread: samples four sensors and both servos at 200 Hz, sends what comes on the
    /// link back, and ends after so many samples, or when told to.
    struct FakeBoard(Option<JoinHandle<u64>>);

    impl FakeBoard {
        fn start(folder: &Path, samples: u64) -> Box<dyn Peer + Send> {
            let folder = folder.to_owned();
            Box::new(Self(Some(std::thread::spawn(move || sample(&folder, samples)))))
        }
    }

    impl Peer for FakeBoard {
        fn ended(&mut self) -> Result<Option<String>> {
            Ok(self.0.as_ref().is_none_or(JoinHandle::is_finished).then(|| "the fake board ended".to_owned()))
        }

        fn finish(&mut self) {
            self.0.take().map(JoinHandle::join);
        }
    }

    struct Ends {
        requests: File,
        answers: File,
    }

    impl Ends {
        /// Opens as the board does.
        fn open(folder: &Path) -> Self {
            let requests = File::options().write(true).open(folder.join(REQUESTS)).unwrap();
            Self { requests, answers: File::open(folder.join(ANSWERS)).unwrap() }
        }

        /// Notices and body; `None` at the end.
        fn ask(&mut self, kind: Kind, time_us: u64, body: &[u8]) -> Option<(u8, Vec<u8>)> {
            let length = (9 + body.len()) as u16;
            let frame = [&length.to_le_bytes()[..], &[kind as u8], &time_us.to_le_bytes(), body].concat();
            self.requests.write_all(&frame).ok()?;
            let mut length = [0; 2];
            self.answers.read_exact(&mut length).ok()?;
            let mut answer = vec![0; usize::from(u16::from_le_bytes(length))];
            self.answers.read_exact(&mut answer).ok()?;
            let (notices, body) = answer.split_first()?;
            Some((*notices, body.to_vec()))
        }
    }

    fn sample(folder: &Path, samples: u64) -> u64 {
        let mut ends = Ends::open(folder);
        let sync_read =
            [0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x09, 0x00, 0x82, 0x84, 0x00, 0x04, 0x00, 0x01, 0x02, 0xCE, 0xFA];
        for sample in 1..=samples {
            let time_us = sample * 5000;
            let Some((mut notices, _)) = ends.ask(Kind::Servo, time_us, &sync_read) else { return sample };
            for address in SENSOR_ADDRESSES {
                for register in [2, 1, 3] {
                    let Some((now, _)) = ends.ask(Kind::I2c, time_us, &[address, 2, register]) else {
                        return sample;
                    };
                    notices |= now;
                }
            }
            if notices & NOTICE_LINK != 0 {
                let Some((_, bytes)) = ends.ask(Kind::Link, time_us, &[64, 0]) else { return sample };
                let echo = [&[0, 0][..], &bytes].concat();
                if ends.ask(Kind::Link, time_us + 300, &echo).is_none() {
                    return sample;
                }
            }
        }
        samples
    }

    fn board(samples: u64) -> VirtualBoard {
        let scenario =
            Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Training, 60.0, 1);
        let robot = VirtualRobot::new(scenario, RobotOptions::default()).unwrap();
        VirtualBoard::with_peer(robot, VirtualFlash::default(), |folder| {
            Ok(FakeBoard::start(folder, samples))
        })
        .unwrap()
    }

    /// The clock runs only during a receive, and stops when something has arrived.
    #[test]
    fn the_link_echoes_in_the_boards_time() {
        let mut board = board(u64::MAX);
        let mut buffer = [0; 16];
        assert_eq!(board.now(), Duration::ZERO);
        assert_eq!(board.receive(&mut buffer, Duration::from_millis(20)).unwrap(), 0);
        assert_eq!(board.now(), Duration::from_millis(20));
        board.send(b"hello").unwrap();
        assert_eq!(board.now(), Duration::from_millis(20));
        assert_eq!(board.receive(&mut buffer[..3], Duration::from_secs(1)).unwrap(), 3);
        assert_eq!(board.receive(&mut buffer[3..], Duration::from_secs(1)).unwrap(), 2);
        assert_eq!(&buffer[..5], b"hello");
        assert!(board.now() <= Duration::from_micros(25_300));
        assert_eq!(board.robot_mut().now_us(), board.now().as_micros() as u64);
    }

    #[test]
    fn a_board_that_ends_is_an_error_in_words() {
        let mut board = board(10);
        let error = board.run_for(Duration::from_secs(1)).unwrap_err();
        assert_eq!(error.to_string(), "the fake board ended");
        assert_eq!(board.now(), Duration::from_millis(50));
    }

    #[test]
    fn nothing_is_left_behind() {
        let mut board = board(u64::MAX);
        board.run_for(Duration::from_millis(100)).unwrap();
        let folder: PathBuf = board._folder.path().to_owned();
        assert!(folder.exists());
        drop(board);
        assert!(!folder.exists());
    }

    #[test]
    fn a_missing_image_names_the_command_that_builds_it() {
        let scenario =
            Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Standstill, 1.0, 1);
        let robot = VirtualRobot::new(scenario, RobotOptions::default()).unwrap();
        let error =
            VirtualBoard::start(Path::new("no/such/image"), robot, BoardOptions::default()).err().unwrap();
        assert!(error.to_string().contains("cargo build --release -p firmware --bin virtual"), "{error}");
    }

    /// What an exchange with the plant costs, pipes included: run by hand with
    /// `--ignored --nocapture`.
    #[test]
    #[ignore = "a measurement"]
    fn speed() {
        let mut board = board(u64::MAX);
        let begun = Instant::now();
        board.run_for(Duration::from_secs(60)).unwrap();
        let wall = begun.elapsed().as_secs_f64();
        let each = wall / board.exchanges() as f64 * 1e6;
        println!("{:.1} × real time, {each:.1} µs an exchange", 60.0 / wall);
    }
}
