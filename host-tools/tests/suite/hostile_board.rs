//! A board that lies: names that would act on a terminal, registers of any bytes, lengths that are
//! none, a clock that jumps. Whatever it answers, commands end, and every byte that they print is
//! printable.

use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use board::client::Client;
use board::recorder::{Ending, Options, record};
use board::transport::Transport;
use support::error::Result;
use support::printable::is_harmful;

use crate::common::board::terminal::Terminal;
use crate::common::board::{TestBoard, sample};
use crate::common::{Bench, Ran};
use firmware::dynamixel::packet::{Instruction, Parser, encode};
use firmware::record::Record;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Passes on what a good board answers, with other bytes in it.
struct Hostile {
    inner: TestBoard,
    rng: ChaCha8Rng,
    /// Share of the answers that are spoiled.
    share: f64,
    outbox: VecDeque<u8>,
}

/// What a terminal would act on, and numbers that are none: NaN, infinity, the greatest of all
/// kinds.
const WILD: [&[u8]; 6] = [
    b"\x1b]0;owned\x07\x1b[2J",
    b"\ngmr: done\r\x9b2J",
    b"\x00\x00\xc0\x7f\x00\x00\x80\x7f",
    b"\xff\xff\xff\xff\xff\xff\xff\xff",
    b"\xe2\x80\xae\xe2\x80\xa8",
    b"\x00\x00\x00\x80",
];

impl Hostile {
    fn new(seed: u64, share: f64) -> Self {
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Self { inner: TestBoard::new(), rng, share, outbox: VecDeque::new() }
    }

    /// A packet's parameters, the error first; an answer to a ping is left alone, or nobody would
    /// ask further.
    fn spoil(&mut self, parameters: &[u8]) -> Vec<u8> {
        let mut parameters = parameters.to_vec();
        if parameters.len() <= 4 || !self.rng.random_bool(self.share) {
            return parameters;
        }
        for _ in 0..self.rng.random_range(1..=4) {
            let wild = WILD[self.rng.random_range(0..WILD.len())];
            let at = self.rng.random_range(1..parameters.len());
            for (place, byte) in parameters[at..].iter_mut().zip(wild.iter().cycle().take(32)) {
                *place = *byte;
            }
        }
        match self.rng.random_range(0..8) {
            0 => parameters.truncate(self.rng.random_range(0..parameters.len())),
            1 => parameters.extend([0x1b; 40]),
            _ => {}
        }
        parameters
    }
}

impl Transport for Hostile {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.inner.send(bytes)?;
        let mut answers = Vec::new();
        let mut buffer = [0; 4096];
        while let count @ 1.. = self.inner.receive(&mut buffer, Duration::ZERO)? {
            answers.extend_from_slice(&buffer[..count]);
        }
        let mut parser = Parser::<8192>::default();
        let mut rest = &answers[..];
        loop {
            let taken = parser.feed(rest);
            rest = &rest[taken..];
            let Some(packet) = parser.next_packet() else { break };
            let Ok(packet) = packet else { continue };
            let (id, parameters) = (packet.id, packet.parameters.to_vec());
            let parameters = self.spoil(&parameters);
            let mut spoiled = [0; 16384];
            let sent = encode(id, Instruction::Status, &[&parameters], &mut spoiled).unwrap();
            self.outbox.extend(sent);
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> Result<usize> {
        if self.outbox.is_empty() || buffer.is_empty() {
            self.inner.receive(&mut [], limit)?;
        }
        let count = buffer.len().min(self.outbox.len());
        for (place, byte) in buffer.iter_mut().zip(self.outbox.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.inner.now()
    }
}

/// The command ends soon, with a documented code, and prints nothing that acts on a terminal.
fn assert_harmless(bench: &Bench, arguments: &[&str], seed: u64) {
    let begun = Instant::now();
    let Ran { code, stdout, stderr } = bench.gmr(arguments);
    assert!(matches!(code, Some(0 | 1)), "{arguments:?}, seed {seed}: {code:?} {stderr}");
    // A board that does not answer is waited for some seconds.
    assert!(begun.elapsed() < Duration::from_secs(20), "{arguments:?}, seed {seed}: {:?}", begun.elapsed());
    for text in [&stdout, &stderr] {
        assert!(!text.chars().any(|c| c != '\n' && is_harmful(c)), "{arguments:?}, seed {seed}: {text:?}");
        assert!(
            !text.lines().any(|line| line.starts_with("gmr: done")),
            "{arguments:?}, seed {seed}: forged"
        );
    }
}

#[test]
fn whatever_a_board_says_is_printable() {
    let bench = Bench::new();
    for seed in 0..24 {
        let share = [0.1, 0.5, 1.0][seed as usize % 3];
        let terminal = Terminal::new(Hostile::new(seed, share));
        let port = terminal.name();
        let commands: [&[&str]; 4] = [
            &["watch", "--once", "--port", port],
            &["watch", "--once", "--json", "--port", port],
            &["flash", "--read", "--port", port],
            &["record", "--force", "--duration", "0.3", "--port", port, "--out", "run.csv"],
        ];
        assert_harmless(&bench, commands[seed as usize % 4], seed);
    }
}

/// Records up to a jump of the clock, and tells it: no duration is over because of it.
#[test]
fn a_clock_that_jumps_is_no_end_of_a_recording() {
    let mut board = TestBoard::new();
    board.is_sampling = false;
    let first = board.state.fifo.next();
    for number in 0..100 {
        let good = sample(first + number);
        let ahead = if number < 60 { 0 } else { 3_600_000_000 };
        board.state.fifo.push(Record { time_us: good.time_us + ahead, ..good });
    }
    let (mut client, board) = Client::connect(board).unwrap();
    let mut rows = 0;
    let options = Options { duration: Some(Duration::from_secs(60)), backlog: true, ..Options::default() };
    let recording = record(
        &mut client,
        &board,
        &options,
        &mut |lines| {
            rows += lines.lines().count();
            Ok(())
        },
        &mut |_| ControlFlow::Continue(()),
    )
    .unwrap();
    assert!(
        matches!(recording.ending, Ending::Jumped { seconds } if (seconds - 3600.0).abs() < 0.1),
        "{:?}",
        recording.ending
    );
    // The header, what came before this test's samples, and the sixty.
    assert_eq!(rows as u64, recording.rows + 1);
    assert!(recording.rows >= 60 && recording.elapsed < Duration::from_secs(2), "{recording:?}");
}
