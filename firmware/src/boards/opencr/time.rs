//! Board time: TIM5, 32 bits at 1 MHz, which wraps once in 71 minutes.
//!
//! The HAL's own driver counts 16 bits and the interrupts between them: while the flash is erased
//! no interrupt runs, and every 65 ms of that are lost. Here nothing is lost as long as no stall
//! lasts an hour.

use core::cell::{Cell, RefCell};
use core::future::poll_fn;
use core::task::{Poll, Waker};

use embassy_futures::select::{Either, select};
use embassy_stm32::interrupt::typelevel::{self, Interrupt};
use embassy_stm32::pac::timer::regs::SrGp16;
use embassy_stm32::pac::{RCC, TIM5};
use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_sync::waitqueue::AtomicWaker;
use embassy_time_driver::Driver;
use embassy_time_queue_utils::Queue;
use embedded_hal_async::delay::DelayNs;

/// The timers of the slower bus run at twice its 54 MHz (`clock.rs`).
const PRESCALER: u16 = 108 - 1;
/// The compare channel that wakes whoever is in the queue.
const ALARM: usize = 0;
/// Those of the three time limits.
const LIMITS: [usize; 3] = [1, 2, 3];
/// An alarm further away is set again when half the counter has passed.
const FURTHEST: u64 = 1 << 31;

struct Clock {
    /// Times that the counter has wrapped.
    wraps: CriticalSectionMutex<Cell<u64>>,
    timers: CriticalSectionMutex<RefCell<Timers>>,
    /// Who waits for a limit.
    limited: [AtomicWaker; LIMITS.len()],
}

struct Timers {
    queue: Queue,
    /// When the alarm goes off, µs since start.
    alarm: u64,
}

embassy_time_driver::time_driver_impl!(static CLOCK: Clock = Clock {
    wraps: CriticalSectionMutex::new(Cell::new(0)),
    timers: CriticalSectionMutex::new(RefCell::new(Timers { queue: Queue::new(), alarm: u64::MAX })),
    limited: [const { AtomicWaker::new() }; LIMITS.len()],
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
        set_interrupt(ALARM, at != u64::MAX);
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
            clear(ALARM);
            self.timers.lock(|timers| self.set_alarm(&mut timers.borrow_mut()));
        }
        for (channel, waker) in LIMITS.into_iter().zip(&self.limited) {
            if raised.ccif(channel) && TIM5.dier().read().ccie(channel) {
                set_interrupt(channel, false);
                waker.wake();
            }
        }
    }
}

/// Forgets that the channel's time has come. Flags are cleared by writing 0 to them.
fn clear(channel: usize) {
    let mut clear = SrGp16(u32::MAX);
    clear.set_ccif(channel, false);
    TIM5.sr().write_value(clear);
}

fn set_interrupt(channel: usize, is_on: bool) {
    critical_section::with(|_| TIM5.dier().modify(|register| register.set_ccie(channel, is_on)));
}

/// A time limit with a compare channel of its own. A timer in the queue that nobody waits for any
/// more, because what it limits has ended in time, wakes its task all the same: once for every
/// packet and every transaction on a bus. This one is switched off instead.
pub struct Limit {
    channel: usize,
    waker: &'static AtomicWaker,
}

impl Limit {
    /// One for each bus.
    pub(super) fn all() -> [Self; LIMITS.len()] {
        let [first, second, third] = LIMITS;
        let [one, two, three] = &CLOCK.limited;
        [(first, one), (second, two), (third, three)].map(|(channel, waker)| Self { channel, waker })
    }

    /// What the work gives, if it ends within so many µs.
    pub(super) async fn within<T>(&mut self, us: u32, work: impl Future<Output = T>) -> Option<T> {
        match select(work, self.wait(u64::from(us))).await {
            Either::First(done) => Some(done),
            Either::Second(()) => None,
        }
    }

    async fn wait(&mut self, us: u64) {
        let until = CLOCK.now().saturating_add(us);
        let mut waiting = None;
        poll_fn(|context| {
            self.waker.register(context.waker());
            if waiting.is_none() {
                TIM5.ccr(self.channel).write_value(until as u32);
                clear(self.channel);
                set_interrupt(self.channel, true);
                waiting = Some(Waiting(self.channel));
            }
            // What became due while it was being set does not fire.
            if CLOCK.now() >= until { Poll::Ready(()) } else { Poll::Pending }
        })
        .await
    }
}

/// Switches the channel off when it is not waited for any more.
struct Waiting(usize);

impl Drop for Waiting {
    fn drop(&mut self) {
        set_interrupt(self.0, false);
    }
}

impl DelayNs for Limit {
    async fn delay_ns(&mut self, ns: u32) {
        self.wait(u64::from(ns.div_ceil(1000))).await
    }

    async fn delay_us(&mut self, us: u32) {
        self.wait(u64::from(us)).await
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
