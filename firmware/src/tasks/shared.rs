//! What the tasks have in common.

use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use embassy_sync::blocking_mutex::Mutex;
use embassy_time::Duration;

use crate::link::{Place, State};
use crate::parameters::{SAMPLE_RATE_HZ, SERVO_WATCHDOG, WINDOW_S};
use crate::reset::ResetReport;

/// Records that wait for the host: 5 s of them. They are most of the board's static memory.
pub type Records = [Place; 1000];

/// On a board sampling interrupts whoever else uses the state: interrupts are masked meanwhile.
#[cfg(target_os = "none")]
type Guard = embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
/// On a host nothing interrupts.
#[cfg(not(target_os = "none"))]
type Guard = embassy_sync::blocking_mutex::raw::NoopRawMutex;

/// The state that the link shows.
pub struct Shared {
    state: Mutex<Guard, RefCell<State<'static>>>,
    /// A sample is being taken: the buses are busy.
    is_sampling: AtomicBool,
    /// No sample may begin.
    is_held: AtomicBool,
    /// The flash was written since the last sample: that one may be late.
    has_stalled: AtomicBool,
    /// When each task last worked, µs since start, which wraps in 71 minutes; 0 while it waits for
    /// a host.
    reports: [AtomicU32; Reporter::ALL.len()],
}

/// A task that the watchdog looks after.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reporter {
    /// Takes the samples.
    Measure,
    /// Reads the inertial sensor.
    Orient,
    /// Keeps what is uploaded.
    Keep,
    /// Takes note of what the host does to the bus.
    Usb,
    /// Answers on the port that the ROS node opens.
    NodePort,
    /// Answers on the second port.
    OwnPort,
    /// Shows LEDs, reads buttons and the supply.
    Panel,
}

impl Reporter {
    const ALL: [Self; 7] =
        [Self::Measure, Self::Orient, Self::Keep, Self::Usb, Self::NodePort, Self::OwnPort, Self::Panel];

    /// How long the task may work or wait for a device before it counts as hung.
    const fn limit(self) -> Duration {
        Duration::from_millis(match self {
            // The servos stop by themselves so long after the last packet: from then on nobody
            // drives.
            Self::Measure => SERVO_WATCHDOG as u64 * 20,
            // Starting a sensor takes a tenth of a second.
            Self::Orient => 500,
            // Moving the store: both sectors erased, each in half a second at most (datasheet), and
            // written.
            Self::Keep => 2_000,
            // A reset brings the link back within this time.
            Self::Usb => 200,
            // A packet of six questions, each of whose answers the host may leave for 20 ms; and a
            // signature that is verified meanwhile.
            Self::NodePort | Self::OwnPort => 500,
            Self::Panel => 500,
        })
    }
}

impl Shared {
    /// Nothing measured yet. Samples wait for the host in `records`.
    #[must_use]
    pub const fn new(records: &'static mut [Place]) -> Self {
        Self {
            state: Mutex::new(RefCell::new(State::new(SAMPLE_RATE_HZ as u16, WINDOW_S as u16, records))),
            is_sampling: AtomicBool::new(false),
            is_held: AtomicBool::new(false),
            has_stalled: AtomicBool::new(false),
            reports: [const { AtomicU32::new(1) }; Reporter::ALL.len()],
        }
    }

    /// Why the board has started, for the host.
    pub fn set_reset(&self, report: ResetReport) {
        self.with(|state| state.reset = report);
    }

    /// What the board's panel shows and is told, and its supply voltage: `exchange` gets what the
    /// host wants of the LEDs, and gives the buttons and the voltage.
    pub fn exchange_panel(&self, exchange: impl FnOnce([u8; 4]) -> ([u8; 2], Option<f32>)) {
        self.with(|state| {
            let (buttons, voltage) = exchange(state.panel.leds);
            state.panel.buttons = buttons;
            state.supply_voltage = voltage;
        });
    }

    /// The task works, `now_us` since start.
    pub fn report(&self, reporter: Reporter, now_us: u64) {
        self.note(reporter, (now_us as u32).max(1));
    }

    /// The task waits for a host, for as long as that likes.
    pub(super) fn rest(&self, reporter: Reporter) {
        self.note(reporter, 0);
    }

    fn note(&self, reporter: Reporter, time_us: u32) {
        if let Some(report) = self.reports.get(reporter as usize) {
            report.store(time_us, Ordering::Relaxed);
        }
    }

    /// A task that has worked for longer than it may without a report, if there is one.
    pub(super) fn hung(&self, now_us: u64) -> Option<Reporter> {
        Reporter::ALL.into_iter().zip(&self.reports).find_map(|(reporter, report)| {
            let report = report.load(Ordering::Relaxed);
            // Negative where it has reported since `now_us` was asked for.
            let silence_us = (now_us as u32).wrapping_sub(report) as i32;
            let is_hung = report != 0 && i64::from(silence_us) > reporter.limit().as_micros() as i64;
            is_hung.then_some(reporter)
        })
    }

    /// Uses the state. `work` cannot wait, must not come here again, and is what a sample may have
    /// to wait for: short.
    pub(super) fn with<T>(&self, work: impl FnOnce(&mut State<'static>) -> T) -> T {
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

    /// The processor is about to stand still, for longer than a sample's period: no sample begins
    /// any more until [`Self::resume`]; one may still be under way.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Each task by its own limit, over the wrap of 32 bits of microseconds too; one that waits for
    /// a host for good is not hung.
    #[test]
    fn a_task_hangs_after_its_own_limit() {
        for reporter in Reporter::ALL {
            let limit_us = reporter.limit().as_micros();
            for reported_us in [1, u64::from(u32::MAX) - 1_000] {
                let shared = Shared::new(&mut []);
                Reporter::ALL.into_iter().for_each(|other| shared.rest(other));
                shared.note(reporter, reported_us as u32);
                assert_eq!(shared.hung(reported_us + limit_us), None, "{reporter:?}");
                assert_eq!(shared.hung(reported_us + limit_us + 1), Some(reporter));
                shared.rest(reporter);
                assert_eq!(shared.hung(reported_us + 60_000_000), None, "{reporter:?}");
            }
        }
    }

    /// A task that never began to work is one that hangs.
    #[test]
    fn every_task_has_to_report_after_the_start() {
        let shared = Shared::new(&mut []);
        let silent = |shared: &Shared| shared.hung(3_000_000);
        for _ in Reporter::ALL {
            let reporter = silent(&shared).expect("one more that has not reported");
            shared.note(reporter, 3_000_000);
        }
        assert_eq!(silent(&shared), None);
    }
}
