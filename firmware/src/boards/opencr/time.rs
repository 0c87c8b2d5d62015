//! Board time: TIM5, 32 bits at 1 MHz, which wraps once in 71 minutes.
//!
//! The HAL's own driver counts 16 bits and the interrupts between them: while the flash is erased
//! no interrupt runs, and every 65 ms of that are lost. Here nothing is lost as long as no stall
//! lasts an hour.

use core::cell::{Cell, RefCell};
use core::task::Waker;

use embassy_stm32::interrupt::typelevel::{self, Interrupt};
use embassy_stm32::pac::timer::regs::SrGp16;
use embassy_stm32::pac::{RCC, TIM5};
use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_time_driver::Driver;
use embassy_time_queue_utils::Queue;

/// The timers of the slower bus run at twice its 54 MHz (`clock.rs`).
const PRESCALER: u16 = 108 - 1;
/// The compare channel that wakes.
const ALARM: usize = 0;
/// An alarm further away is set again when half the counter has passed.
const FURTHEST: u64 = 1 << 31;

struct Clock {
    /// Times that the counter has wrapped.
    wraps: CriticalSectionMutex<Cell<u64>>,
    timers: CriticalSectionMutex<RefCell<Timers>>,
}

struct Timers {
    queue: Queue,
    /// When the alarm goes off, µs since start.
    alarm: u64,
}

embassy_time_driver::time_driver_impl!(static CLOCK: Clock = Clock {
    wraps: CriticalSectionMutex::new(Cell::new(0)),
    timers: CriticalSectionMutex::new(RefCell::new(Timers { queue: Queue::new(), alarm: u64::MAX })),
});

impl Driver for Clock {
    fn now(&self) -> u64 {
        self.wraps.lock(|wraps| {
            let before = TIM5.cnt().read();
            // A wrap whose interrupt has not run yet counts if the value is from after it.
            let (pending, count) = if TIM5.sr().read().uif() { (1, TIM5.cnt().read()) } else { (0, before) };
            ((wraps.get() + pending) << 32) + u64::from(count)
        })
    }

    /// A future that waits for several things asks for its time whenever one of them moves: only
    /// what is due before the alarm concerns the timer.
    fn schedule_wake(&self, at: u64, waker: &Waker) {
        self.timers.lock(|timers| {
            let mut timers = timers.borrow_mut();
            if timers.queue.schedule_wake(at, waker) && at < timers.alarm {
                self.arm(&mut timers, at);
                // What became due while it was being set does not fire.
                if self.now() >= at {
                    self.set_alarm(&mut timers);
                }
            }
        });
    }
}

impl Clock {
    /// Wakes whoever is due and sets the alarm for the next.
    fn set_alarm(&self, timers: &mut Timers) {
        loop {
            let next = timers.queue.next_expiration(self.now());
            self.arm(timers, next);
            if next == u64::MAX || self.now() < next {
                return;
            }
        }
    }

    /// Sets the alarm; one that is too far away goes off earlier.
    fn arm(&self, timers: &mut Timers, at: u64) {
        timers.alarm = if at == u64::MAX { at } else { at.min(self.now().saturating_add(FURTHEST)) };
        TIM5.ccr(ALARM).write_value(timers.alarm as u32);
        TIM5.dier().modify(|register| register.set_ccie(ALARM, at != u64::MAX));
    }

    fn on_interrupt(&self) {
        let raised = TIM5.sr().read();
        // Flags are cleared by writing 0 to them.
        if raised.uif() {
            self.wraps.lock(|wraps| {
                let mut clear = SrGp16(u32::MAX);
                clear.set_uif(false);
                TIM5.sr().write_value(clear);
                wraps.set(wraps.get() + 1);
            });
        }
        if raised.ccif(ALARM) {
            let mut clear = SrGp16(u32::MAX);
            clear.set_ccif(ALARM, false);
            TIM5.sr().write_value(clear);
            self.timers.lock(|timers| self.set_alarm(&mut timers.borrow_mut()));
        }
    }
}

/// Starts board time at zero. To be called once, when the clocks run.
#[expect(
    unsafe_code,
    reason = "enables an interrupt: no critical section relies on its being masked, none has begun"
)]
pub(super) fn start() {
    RCC.apb1enr().modify(|register| register.set_tim5en(true));
    // Enabled clocks take two cycles.
    cortex_m::asm::dsb();
    TIM5.psc().write_value(PRESCALER);
    TIM5.arr().write_value(u32::MAX);
    // Takes the prescaler over; the flag that this raises is no wrap.
    TIM5.egr().write(|register| register.set_ug(true));
    TIM5.sr().write_value(SrGp16(0));
    TIM5.dier().write(|register| register.set_uie(true));
    TIM5.cr1().modify(|register| register.set_cen(true));
    // SAFETY: see above.
    unsafe { typelevel::TIM5::enable() };
}

/// Board time's interrupt.
pub(super) struct Tick;

#[expect(unsafe_code, reason = "the HAL declares handlers unsafe; this one is called for its interrupt only")]
impl typelevel::Handler<typelevel::TIM5> for Tick {
    unsafe fn on_interrupt() {
        CLOCK.on_interrupt();
    }
}
