//! Board time: TIM5, 32 bits at 1 MHz, which wraps once in 71 minutes.
//!
//! The HAL's own driver counts 16 bits and the interrupts between them: while the flash is erased no interrupt runs, and every
//! 65 ms of that are lost. Here nothing is lost as long as no stall lasts an hour.

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
    queue: CriticalSectionMutex<RefCell<Queue>>,
}

embassy_time_driver::time_driver_impl!(static CLOCK: Clock = Clock {
    wraps: CriticalSectionMutex::new(Cell::new(0)),
    queue: CriticalSectionMutex::new(RefCell::new(Queue::new())),
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

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        self.queue.lock(|queue| {
            let mut queue = queue.borrow_mut();
            if queue.schedule_wake(at, waker) {
                self.set_alarm(&mut queue);
            }
        });
    }
}

impl Clock {
    /// Wakes whoever is due and sets the alarm for the next.
    fn set_alarm(&self, queue: &mut Queue) {
        let mut next = queue.next_expiration(self.now());
        while next != u64::MAX {
            let now = self.now();
            TIM5.ccr(ALARM).write_value(next.min(now.saturating_add(FURTHEST)) as u32);
            // What became due while it was being set does not fire.
            if self.now() < next {
                break;
            }
            next = queue.next_expiration(self.now());
        }
        TIM5.dier().modify(|register| register.set_ccie(ALARM, next != u64::MAX));
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
            self.queue.lock(|queue| self.set_alarm(&mut queue.borrow_mut()));
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
