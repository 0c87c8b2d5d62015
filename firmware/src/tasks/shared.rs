//! What the tasks have in common.

use core::cell::{Cell, RefCell};

use embassy_time::Instant;

use crate::link::State;
use crate::parameters::{SAMPLE_RATE_HZ, WINDOW_S};
use crate::reset::ResetReport;

/// Records that wait for the host: 5 s of them. They are most of the board's static memory.
pub const FIFO_RECORDS: usize = 1000;

/// The state that the link shows. Not [`Sync`]: for the tasks of one executor.
pub struct Shared {
    state: RefCell<State<FIFO_RECORDS>>,
    /// A sample is being taken: the buses are busy.
    is_sampling: Cell<bool>,
    /// The flash was written since the last sample: that one may be late.
    has_stalled: Cell<bool>,
    /// When those tasks last worked that never wait for long.
    reports: [Cell<Instant>; 2],
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
            state: RefCell::new(State::new(SAMPLE_RATE_HZ as u16, WINDOW_S as u16)),
            is_sampling: Cell::new(false),
            has_stalled: Cell::new(false),
            reports: [const { Cell::new(Instant::MIN) }; 2],
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
        let [measure, keep] = &self.reports;
        match reporter {
            Reporter::Measure => measure.set(Instant::now()),
            Reporter::Keep => keep.set(Instant::now()),
        }
    }

    /// When each task last worked.
    pub(super) fn reports(&self) -> [Instant; 2] {
        let [measure, keep] = &self.reports;
        [measure.get(), keep.get()]
    }

    /// Uses the state. `work` cannot wait, and must not come here again.
    pub(super) fn with<T>(&self, work: impl FnOnce(&mut State<FIFO_RECORDS>) -> T) -> T {
        work(&mut self.state.borrow_mut())
    }

    /// A sample begins or ends.
    pub(super) fn set_sampling(&self, is_sampling: bool) {
        self.is_sampling.set(is_sampling);
    }

    /// Whether one is being taken.
    pub(super) fn is_sampling(&self) -> bool {
        self.is_sampling.get()
    }

    /// The processor is about to stand still, for longer than a sample's period.
    pub(super) fn stall(&self) {
        self.has_stalled.set(true);
    }

    /// Whether it did since the last time somebody asked.
    pub(super) fn take_stall(&self) -> bool {
        self.has_stalled.take()
    }
}
