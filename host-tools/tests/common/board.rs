//! A board within the test's process, on a clock of its own, and lines that lose what they carry.
#![allow(dead_code, reason = "every test file uses its part")]

use std::collections::VecDeque;
use std::time::Duration;

use firmware::control_table::{self as table, BOARD_ID, Register};
use firmware::dynamixel::packet::{Instruction, Parser, encode};
use firmware::power_sensors::Health;
use firmware::record::Record;
use host_tools::board::transport::Transport;
use host_tools::error::{Error, Result};
use model_core::payload::Mass;

/// Samples per second.
pub(crate) const RATE_HZ: u64 = 200;

/// A board that answers reads and writes, and takes samples. Its time passes while somebody waits for it, and a little with
/// every packet.
pub(crate) struct TestBoard {
    memory: Vec<u8>,
    fifo: VecDeque<Record>,
    parser: Parser<4096>,
    outbox: VecDeque<u8>,
    now: Duration,
    /// When it was switched on.
    started: Duration,
    taken: u32,
    /// From when on the cable is not plugged in any more.
    pub(crate) pulled_at: Option<Duration>,
    /// When it starts again.
    pub(crate) restart_at: Option<Duration>,
    /// Samples that its memory holds.
    pub(crate) capacity: usize,
    /// Whether samples are taken at all.
    pub(crate) is_sampling: bool,
}

/// The sample with this number: every number is another, and none is round.
pub(crate) fn sample(sequence: u32) -> Record {
    let phase = sequence as f32 * 0.01;
    Record {
        sequence,
        time_us: u64::from(sequence + 1) * 1_000_000 / RATE_HZ,
        wheel_speed: Some([phase.sin() * 6.0, phase.cos() * -5.0]),
        rail_power: [Some(9.7 + phase.sin()), Some(3.3 - phase.sin()), Some(4.1), None],
        battery_voltage: Some(11.7 - phase * 1e-4),
        health: [Health::Ok, Health::Ok, Health::Ok, Health::Absent],
        has_coefficients: true,
        is_estimated: true,
        has_changed: false,
        is_standing: false,
        predicted_power: Some(3.2 - phase.sin()),
        mass: (sequence >= 100).then_some(Mass { mass: 2.9 + phase * 1e-3, low: 2.7, high: 3.1 }),
    }
}

impl TestBoard {
    pub(crate) fn new() -> Self {
        let mut board = Self {
            memory: vec![0; usize::from(table::END)],
            fifo: VecDeque::new(),
            parser: Parser::default(),
            outbox: VecDeque::new(),
            now: Duration::ZERO,
            started: Duration::ZERO,
            taken: 0,
            pulled_at: None,
            restart_at: None,
            capacity: 512,
            is_sampling: true,
        };
        board.put(&table::MODEL_NUMBER, &table::BOARD_MODEL.to_le_bytes());
        board.put(&table::FIRMWARE_VERSION, &[7]);
        board.put(&table::TABLE_VERSION, &table::VERSION.to_le_bytes());
        board.put(&table::SAMPLE_RATE, &(RATE_HZ as u16).to_le_bytes());
        board.put(&table::RECORD_SIZE, &(firmware::record::RECORD_BYTES as u16).to_le_bytes());
        board.put(&table::ROBOT_NAME, b"Test");
        // It ran for a while before anybody asked.
        board.advance(Duration::from_millis(400));
        board
    }

    /// Sets a register, read-only or not.
    pub(crate) fn put(&mut self, register: &Register, bytes: &[u8]) {
        let start = usize::from(register.address);
        self.memory[start..start + bytes.len()].copy_from_slice(bytes);
    }

    fn word(&self, register: &Register) -> u32 {
        let start = usize::from(register.address);
        u32::from_le_bytes(self.memory[start..start + 4].try_into().unwrap())
    }

    /// Samples taken since it was switched on.
    pub(crate) fn taken(&self) -> u32 {
        self.taken
    }

    /// Lets time pass.
    pub(crate) fn advance(&mut self, time: Duration) {
        self.now += time;
        if self.restart_at.is_some_and(|restart| self.now >= restart) {
            self.restart_at = None;
            self.started = self.now;
            self.taken = 0;
            self.fifo.clear();
        }
        while self.is_sampling && sample(self.taken).time_us <= (self.now - self.started).as_micros() as u64 {
            self.fifo.push_back(sample(self.taken));
            self.taken += 1;
            while self.fifo.len() > self.capacity {
                self.fifo.pop_front();
            }
        }
    }

    fn execute(&mut self, instruction: u8, parameters: &[u8]) -> (u8, Vec<u8>) {
        let address = |bytes: &[u8]| usize::from(u16::from_le_bytes([bytes[0], bytes[1]]));
        match Instruction::from_code(instruction) {
            Some(Instruction::Ping) => (0, [&self.memory[..2], &self.memory[6..7]].concat()),
            Some(Instruction::Read) => {
                self.show_records();
                let (start, length) = (address(parameters), address(&parameters[2..]));
                match self.memory.get(start..start + length) {
                    Some(bytes) => (0, bytes.to_vec()),
                    None => (4, Vec::new()),
                }
            }
            Some(Instruction::Write) => {
                let start = address(parameters);
                self.memory[start..start + parameters.len() - 2].copy_from_slice(&parameters[2..]);
                (0, Vec::new())
            }
            _ => (2, Vec::new()),
        }
    }

    fn show_records(&mut self) {
        let acknowledged = self.word(&table::FIFO_ACKNOWLEDGE);
        let window: Vec<Record> = self
            .fifo
            .iter()
            .filter(|record| record.sequence >= acknowledged)
            .take(table::FIFO_WINDOW_RECORDS)
            .copied()
            .collect();
        self.put(&table::FIFO_NEXT, &self.taken.to_le_bytes());
        self.put(&table::FIFO_COUNT, &(window.len() as u16).to_le_bytes());
        let bytes: Vec<u8> = window.iter().flat_map(Record::encode).collect();
        self.put(&table::FIFO_WINDOW, &bytes);
    }

    fn check_cable(&self) -> Result<()> {
        match self.pulled_at {
            Some(at) if self.now >= at => Err(Error::failed("the port is gone")),
            _ => Ok(()),
        }
    }
}

impl Transport for TestBoard {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.advance(Duration::from_micros(500));
        self.check_cable()?;
        let mut rest = bytes;
        while !rest.is_empty() {
            let taken = self.parser.feed(rest);
            rest = &rest[taken..];
            while let Some(found) = self.parser.next_packet() {
                let Ok(packet) = found else { continue };
                if packet.id != BOARD_ID {
                    continue;
                }
                let (instruction, parameters) = (packet.instruction, packet.parameters.to_vec());
                let (error, data) = self.execute(instruction, &parameters);
                let mut buffer = [0; 4096];
                let status = encode(BOARD_ID, Instruction::Status, &[&[error], &data], &mut buffer).unwrap();
                self.outbox.extend(status);
            }
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> Result<usize> {
        self.check_cable()?;
        if self.outbox.is_empty() || buffer.is_empty() {
            self.advance(limit);
            self.check_cable()?;
        }
        let count = buffer.len().min(self.outbox.len());
        for (place, byte) in buffer.iter_mut().zip(self.outbox.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.now
    }
}

/// What a bad line does to bytes on their way to the host, and to packets on their way to the board.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Fault {
    /// Every n-th packet to the board is lost.
    LostRequest(u64),
    /// Every n-th packet to the board has a flipped bit.
    BrokenRequest(u64),
    /// Every n-th answer is lost.
    LostAnswer(u64),
    /// Every n-th answer lacks a byte in its middle.
    ShortAnswer(u64),
    /// Every n-th answer has a flipped bit.
    BrokenAnswer(u64),
    /// Every n-th answer comes twice.
    DoubledAnswer(u64),
    /// Every n-th answer comes so much later.
    LateAnswer(u64, Duration),
}

/// A line with a fault.
pub(crate) struct BadLine<T> {
    pub(crate) inner: T,
    pub(crate) fault: Fault,
    packets: u64,
    /// Bytes on the way, with the time at which they arrive.
    on_the_way: VecDeque<(Duration, Vec<u8>)>,
}

impl<T: Transport> BadLine<T> {
    pub(crate) fn new(inner: T, fault: Fault) -> Self {
        Self { inner, fault, packets: 0, on_the_way: VecDeque::new() }
    }

    /// Takes what the board answered, and spoils it.
    fn collect(&mut self) -> Result<()> {
        let mut answer = Vec::new();
        let mut buffer = [0; 4096];
        loop {
            match self.inner.receive(&mut buffer, Duration::ZERO)? {
                0 => break,
                count => answer.extend_from_slice(&buffer[..count]),
            }
        }
        if answer.is_empty() {
            return Ok(());
        }
        let now = self.inner.now();
        let turn = |every: u64| self.packets.is_multiple_of(every);
        match self.fault {
            Fault::LostAnswer(every) if turn(every) => return Ok(()),
            Fault::ShortAnswer(every) if turn(every) => drop(answer.remove(answer.len() / 2)),
            Fault::BrokenAnswer(every) if turn(every) => {
                let middle = answer.len() / 2;
                answer[middle] ^= 0x10;
            }
            Fault::DoubledAnswer(every) if turn(every) => answer = answer.repeat(2),
            Fault::LateAnswer(every, delay) if turn(every) => {
                self.on_the_way.push_back((now + delay, answer));
                return Ok(());
            }
            _ => {}
        }
        self.on_the_way.push_back((now, answer));
        Ok(())
    }
}

impl<T: Transport> Transport for BadLine<T> {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.packets += 1;
        match self.fault {
            Fault::LostRequest(every) if self.packets.is_multiple_of(every) => Ok(()),
            Fault::BrokenRequest(every) if self.packets.is_multiple_of(every) => {
                let mut bytes = bytes.to_vec();
                let middle = bytes.len() / 2;
                bytes[middle] ^= 1;
                self.inner.send(&bytes)
            }
            _ => self.inner.send(bytes),
        }?;
        self.collect()
    }

    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> Result<usize> {
        let arrives = self.on_the_way.front().map(|(at, _)| *at);
        let now = self.inner.now();
        match arrives {
            Some(at) if at <= now + limit => {
                self.inner.receive(&mut [], at.saturating_sub(now))?;
                let Some((_, bytes)) = self.on_the_way.front_mut() else { return Ok(0) };
                let count = buffer.len().min(bytes.len());
                buffer[..count].copy_from_slice(&bytes[..count]);
                bytes.drain(..count);
                if bytes.is_empty() {
                    self.on_the_way.pop_front();
                }
                Ok(count)
            }
            _ => {
                self.inner.receive(&mut [], limit)?;
                Ok(0)
            }
        }
    }

    fn now(&self) -> Duration {
        self.inner.now()
    }
}

/// A board at the other end of a pseudo terminal, in real time.
#[cfg(unix)]
pub(crate) mod terminal {
    use std::io::{Read as _, Write as _};
    use std::path::PathBuf;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::thread::JoinHandle;
    use std::time::{Duration, Instant};

    use host_tools::board::transport::Transport;
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

    /// Ends the board when dropped.
    pub(crate) struct Terminal {
        pub(crate) path: PathBuf,
        is_pulled: Arc<AtomicBool>,
        thread: Option<JoinHandle<()>>,
    }

    impl Terminal {
        /// Plugs a board in. An error of its transport pulls the cable.
        pub(crate) fn new(mut board: impl Transport + Send + 'static) -> Self {
            let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
            grantpt(&master).unwrap();
            unlockpt(&master).unwrap();
            let path = PathBuf::from(ptsname(&master, Vec::new()).unwrap().into_string().unwrap());
            let flags = rustix::fs::fcntl_getfl(&master).unwrap();
            rustix::fs::fcntl_setfl(&master, flags | rustix::fs::OFlags::NONBLOCK).unwrap();
            let mut master = std::fs::File::from(master);
            let is_pulled = Arc::new(AtomicBool::new(false));
            let pulled = is_pulled.clone();
            let thread = std::thread::spawn(move || {
                let mut last = Instant::now();
                let mut buffer = [0; 4096];
                while !pulled.load(Ordering::Relaxed) {
                    // Nobody there yet is an error too.
                    let count = master.read(&mut buffer).unwrap_or(0);
                    if count > 0 && board.send(&buffer[..count]).is_err() {
                        return;
                    }
                    let elapsed = last.elapsed();
                    last = Instant::now();
                    // With an empty buffer time passes, and nothing is taken.
                    let Ok(count) = board
                        .receive(&mut [], elapsed)
                        .and_then(|_| board.receive(&mut buffer, Duration::ZERO))
                    else {
                        return;
                    };
                    let mut rest = &buffer[..count];
                    while !rest.is_empty() && !pulled.load(Ordering::Relaxed) {
                        rest = &rest[master.write(rest).unwrap_or(0)..];
                    }
                    if count == 0 {
                        std::thread::sleep(Duration::from_micros(500));
                    }
                }
            });
            Self { path, is_pulled, thread: Some(thread) }
        }

        pub(crate) fn name(&self) -> &str {
            self.path.to_str().unwrap()
        }
    }

    impl Drop for Terminal {
        fn drop(&mut self) {
            self.is_pulled.store(true, Ordering::Relaxed);
            let _ = self.thread.take().map(JoinHandle::join);
        }
    }
}
