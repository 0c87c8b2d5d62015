//! What the tasks have in common.

use core::cell::{Cell, RefCell};
use core::sync::atomic::{AtomicBool, Ordering};

use embassy_sync::blocking_mutex::Mutex;
use embassy_time::Instant;

use crate::link::State;
use crate::parameters::{SAMPLE_RATE_HZ, WINDOW_S};
use crate::reset::ResetReport;

/// Records that wait for the host: 5 s of them. They are most of the board's static memory.
pub const FIFO_RECORDS: usize = 1000;

/// On a board sampling interrupts whoever else uses the state: interrupts are masked meanwhile.
#[cfg(target_os = "none")]
type Guard = embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
/// On a host nothing interrupts.
#[cfg(not(target_os = "none"))]
type Guard = embassy_sync::blocking_mutex::raw::NoopRawMutex;

/// The state that the link shows.
pub struct Shared {
    state: Mutex<Guard, RefCell<State<FIFO_RECORDS>>>,
    /// A sample is being taken: the buses are busy.
    is_sampling: AtomicBool,
    /// No sample may begin.
    is_held: AtomicBool,
    /// The flash was written since the last sample: that one may be late.
    has_stalled: AtomicBool,
    /// When those tasks last worked that never wait for long.
    reports: Mutex<Guard, Cell<[Instant; 2]>>,
}

/// A task that never waits for long.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reporter {
    Measure,
    Keep,
}

impl Default for Shared {
    fn default() -> Self {
        Self::new()
    }
}

impl Shared {
    /// Nothing measured yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            state: Mutex::new(RefCell::new(State::new(SAMPLE_RATE_HZ as u16, WINDOW_S as u16))),
            is_sampling: AtomicBool::new(false),
            is_held: AtomicBool::new(false),
            has_stalled: AtomicBool::new(false),
            reports: Mutex::new(Cell::new([Instant::MIN; 2])),
        }
    }

    /// Why the board has started, for the host.
    pub fn set_reset(&self, report: ResetReport) {
        self.with(|state| state.reset = report);
    }

    /// What the board's panel shows and is told, and its supply voltage: `exchange` gets what the host wants of the LEDs, and gives the
    /// buttons and the voltage.
    pub fn exchange_panel(&self, exchange: impl FnOnce([u8; 4]) -> ([u8; 2], Option<f32>)) {
        self.with(|state| {
            let (buttons, voltage) = exchange(state.panel.leds);
            state.panel.buttons = buttons;
            state.supply_voltage = voltage;
        });
    }

    /// The task works.
    pub(super) fn report(&self, reporter: Reporter) {
        let now = Instant::now();
        self.reports.lock(|reports| {
            let [measure, keep] = reports.get();
            reports.set(match reporter {
                Reporter::Measure => [now, keep],
                Reporter::Keep => [measure, now],
            });
        });
    }

    /// When each task last worked.
    pub(super) fn reports(&self) -> [Instant; 2] {
        self.reports.lock(Cell::get)
    }

    /// Uses the state. `work` cannot wait, must not come here again, and is what a sample may have to wait for: short.
    pub(super) fn with<T>(&self, work: impl FnOnce(&mut State<FIFO_RECORDS>) -> T) -> T {
        self.state.lock(|state| work(&mut state.borrow_mut()))
    }

    /// A sample begins or ends.
    pub(super) fn set_sampling(&self, is_sampling: bool) {
        self.is_sampling.store(is_sampling, Ordering::SeqCst);
    }

    /// Whether one is being taken.
    pub(super) fn is_sampling(&self) -> bool {
        self.is_sampling.load(Ordering::SeqCst)
    }

    /// The processor is about to stand still, for longer than a sample's period: no sample begins any more until [`Self::resume`]; one
    /// may still be under way.
    pub(super) fn stall(&self) {
        self.is_held.store(true, Ordering::SeqCst);
        self.has_stalled.store(true, Ordering::SeqCst);
    }

    /// Samples may begin again.
    pub(super) fn resume(&self) {
        self.is_held.store(false, Ordering::SeqCst);
    }

    /// Whether no sample may begin.
    pub(super) fn is_held(&self) -> bool {
        self.is_held.load(Ordering::SeqCst)
    }

    /// Whether it did since the last time somebody asked.
    pub(super) fn take_stall(&self) -> bool {
        self.has_stalled.swap(false, Ordering::SeqCst)
    }
}
