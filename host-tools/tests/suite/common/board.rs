//! A board within the test's process, on a clock of its own, and lines that lose what they carry.
#![allow(dead_code, reason = "every test file uses its part")]

use std::collections::VecDeque;
use std::time::Duration;

use board::store_image::StoreImage;
use board::transport::Transport;
use firmware::control_table::{Item, Reason};
use firmware::items::{ITEMS, ItemBytes, Verify, check_signature};
use firmware::link::{Device, LONGEST_ANSWER, State};
use firmware::power_sensors::Health;
use firmware::record::Record;
use logs::robot::Robot;
use model_core::coefficients::Coefficients;
use model_core::effects::Columns;
use model_core::model::Model;
use model_core::payload::{Mass, Noise};
use model_core::torque::{Drive, TorqueModel};
use support::error::{Error, Result};

/// Samples per second.
pub(crate) const RATE_HZ: u64 = 200;
/// Samples that the board remembers.
pub(crate) const MEMORY: usize = 512;
/// How long its processor stands still while it writes its flash.
pub(crate) const WRITING: Duration = Duration::from_millis(700);

/// The firmware's link and store, with samples that are made up. Its time passes while somebody
/// waits for it, and a little with every packet.
pub(crate) struct TestBoard {
    pub(crate) state: State<'static>,
    memory: usize,
    pub(crate) flash: StoreImage,
    device: Device,
    outbox: VecDeque<u8>,
    now: Duration,
    /// When it was switched on.
    started: Duration,
    /// From when on the cable is not plugged in any more.
    pub(crate) pulled_at: Option<Duration>,
    /// When it starts again.
    pub(crate) restart_at: Option<Duration>,
    /// From when on its wheels stand still.
    pub(crate) stands_at: Duration,
    /// Whether its flash does not hold what is written.
    pub(crate) is_worn: bool,
    /// What it verifies signatures with, if it does.
    pub(crate) verify: Option<Verify>,
    /// Whether its flash would have to be erased first; torque is on.
    pub(crate) is_full: bool,
    /// Whether it says that it has stored what it has not.
    pub(crate) is_lying: bool,
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

/// Coefficients that a board takes whose robot was never set: of a signed torque model, as
/// `common::TRUTH` has it.
pub(crate) fn burger_coefficients() -> Vec<u8> {
    coefficients_with(0.01)
}

/// Another set for the same robot.
pub(crate) fn other_coefficients() -> Vec<u8> {
    coefficients_with(0.02)
}

fn coefficients_with(model_std: f32) -> Vec<u8> {
    let robot = Robot::named("burger").unwrap().core::<2>(2.0).unwrap();
    let [a0, a1, g2, g3, g4, kappa] = crate::common::TRUTH;
    let torque = TorqueModel::from_array([a0, a1, g2, g3, g4, kappa, 0.0]);
    let model = Model::Signed { torque, drive: Drive::Dissipative };
    let noise = Noise { density: 1e-4, model_std: model_std.into(), tail: 0.0, residual_std: 0.0 };
    Coefficients { robot, model, noise, columns: Columns::NONE, identifies_mass: true, ground_adapts: false }
        .encode()
        .unwrap()
        .as_bytes()
        .to_vec()
}

/// Switched on just now.
fn fresh(memory: usize) -> State<'static> {
    State::new(RATE_HZ as u16, 25, vec![[0; _]; memory].leak())
}

impl TestBoard {
    pub(crate) fn new() -> Self {
        Self::with_memory(MEMORY)
    }

    /// One that has run for 0.4 s before anybody asks, and remembers so many samples.
    pub(crate) fn with_memory(memory: usize) -> Self {
        let mut board = Self {
            state: fresh(memory),
            memory,
            flash: StoreImage::erased(),
            device: Device::new(),
            outbox: VecDeque::new(),
            now: Duration::ZERO,
            started: Duration::ZERO,
            pulled_at: None,
            restart_at: None,
            stands_at: Duration::ZERO,
            is_worn: false,
            verify: None,
            is_full: false,
            is_lying: false,
            is_sampling: true,
        };
        board.advance(Duration::from_millis(400));
        board
    }

    /// Puts an item into its flash before it is switched on.
    pub(crate) fn holding(mut self, item: Item, bytes: &[u8]) -> Self {
        self.flash.put(item, bytes).unwrap();
        self.load();
        self
    }

    fn load(&mut self) {
        for item in ITEMS {
            let bytes = ItemBytes::new(&self.flash.stored(item).unwrap()).unwrap();
            self.state.load(item, Ok(bytes));
        }
        self.state.load_previous(ItemBytes::new(&self.flash.previous().unwrap()).unwrap());
    }

    /// Lets time pass.
    pub(crate) fn advance(&mut self, time: Duration) {
        self.now += time;
        if self.restart_at.is_some_and(|restart| self.now >= restart) {
            self.restart_at = None;
            self.started = self.now;
            self.state = fresh(self.memory);
            self.load();
        }
        let uptime = self.now - self.started;
        self.state.time_us = uptime.as_micros() as u64;
        while self.is_sampling && sample(self.state.fifo.next()).time_us <= self.state.time_us {
            self.state.fifo.push(sample(self.state.fifo.next()));
        }
        self.state.snapshot.is_standing = self.now >= self.stands_at;
        if let Some((item, bytes)) = self.state.take_pending() {
            let is_signed =
                item != Item::Coefficients || check_signature(bytes.as_slice(), self.verify).is_ok();
            let written = if is_signed { self.write(item, bytes.as_slice()) } else { Err(Reason::Signature) };
            self.state.stored(item, written);
            if self.is_lying {
                self.state.load(item, Ok(ItemBytes::EMPTY));
            }
            self.now += WRITING;
        }
    }

    fn write(&mut self, item: Item, bytes: &[u8]) -> std::result::Result<(), Reason> {
        if self.is_full {
            Err(Reason::Erase)
        } else if self.is_worn {
            Err(Reason::ReadBack)
        } else {
            self.flash.put(item, bytes).map_err(|_| Reason::Flash)
        }
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
            let taken = self.device.feed(rest);
            rest = &rest[taken..];
            let mut buffer = [0; LONGEST_ANSWER];
            while let Some(length) = self.device.answer(&mut self.state, &mut buffer) {
                self.outbox.extend(&buffer[..length]);
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

/// What a bad line does to bytes on their way to the host, and to packets on their way to the
/// board.
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
    /// Every answer is preceded by the one before.
    Repeated,
    /// Every n-th answer is that of three packets of its length before.
    Stale(u64),
    /// Every n-th answer comes so much later.
    LateAnswer(u64, Duration),
}

/// A line with a fault.
pub(crate) struct BadLine<T> {
    pub(crate) inner: T,
    pub(crate) fault: Fault,
    packets: u64,
    /// What was answered.
    answers: Vec<Vec<u8>>,
    /// Bytes on the way, with the time at which they arrive.
    on_the_way: VecDeque<(Duration, Vec<u8>)>,
}

impl<T: Transport> BadLine<T> {
    pub(crate) fn new(inner: T, fault: Fault) -> Self {
        Self { inner, fault, packets: 0, answers: Vec::new(), on_the_way: VecDeque::new() }
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
        self.answers.push(answer.clone());
        let mut earlier = self.answers.iter().rev().skip(1);
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
            Fault::Repeated => answer = [earlier.next().cloned().unwrap_or_default(), answer].concat(),
            Fault::Stale(every) if turn(every) => {
                let length = answer.len();
                let mut same = earlier.filter(|earlier| earlier.len() == length);
                answer = same.nth(2).cloned().unwrap_or(answer);
            }
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

    use board::transport::Transport;
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
