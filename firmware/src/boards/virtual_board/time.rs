//! Board time from two of the machine's timers: one that counts on, one that wakes.
//!
//! Tickless: between two events the emulated core sleeps, and the emulator goes to the next one at
//! once.
#![expect(unsafe_code, reason = "device registers, and the interrupts' own enabling and handler")]

use core::cell::{Cell, RefCell};
use core::ptr::{read_volatile, write_volatile};
use core::task::Waker;

use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;
use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_time_driver::Driver;
use embassy_time_queue_utils::Queue;

/// Both timers count down at the machine's 25 MHz (Arm application note AN500).
const COUNTS_PER_US: u64 = 25;

/// An APB timer of the Cortex-M System Design Kit (Arm DDI0479).
#[derive(Clone, Copy)]
struct Timer(usize);

const COUNTER: Timer = Timer(0x4000_0000);
const ALARM: Timer = Timer(0x4000_1000);

const CTRL: usize = 0x0;
const VALUE: usize = 0x4;
const RELOAD: usize = 0x8;
/// Reading says whether it fired, writing 1 acknowledges that.
const INTERRUPT: usize = 0xC;
const ENABLE: u32 = 1;
const ENABLE_INTERRUPT: u32 = 1 << 3;

impl Timer {
    fn read(self, register: usize) -> u32 {
        // SAFETY: a register of this timer, which only this file touches.
        unsafe { read_volatile((self.0 + register) as *const u32) }
    }

    fn write(self, register: usize, value: u32) {
        // SAFETY: as above.
        unsafe { write_volatile((self.0 + register) as *mut u32, value) }
    }

    fn has_fired(self) -> bool {
        self.read(INTERRUPT) != 0
    }

    fn acknowledge(self) {
        self.write(INTERRUPT, 1);
    }
}

/// The timers' interrupts.
#[derive(Clone, Copy)]
enum Interrupt {
    Counter = 8,
    Alarm = 9,
}

// SAFETY: the two are constants, and the machine has 32 interrupts.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

struct Timers {
    /// Times that the counter has passed zero.
    wraps: CriticalSectionMutex<Cell<u64>>,
    queue: CriticalSectionMutex<RefCell<Queue>>,
}

embassy_time_driver::time_driver_impl!(static TIMERS: Timers = Timers {
    wraps: CriticalSectionMutex::new(Cell::new(0)),
    queue: CriticalSectionMutex::new(RefCell::new(Queue::new())),
});

impl Driver for Timers {
    fn now(&self) -> u64 {
        self.wraps.lock(|wraps| {
            let before = COUNTER.read(VALUE);
            // A zero passed meanwhile whose interrupt has not run yet counts if the value is from
            // after it.
            let (pending, value) = if COUNTER.has_fired() { (1, COUNTER.read(VALUE)) } else { (0, before) };
            (((wraps.get() + pending) << 32) + u64::from(u32::MAX - value)) / COUNTS_PER_US
        })
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        self.queue.lock(|queue| {
            if queue.borrow_mut().schedule_wake(at, waker) {
                self.set_alarm(&mut queue.borrow_mut());
            }
        });
    }
}

impl Timers {
    /// Wakes whoever is due and sets the alarm for the next.
    fn set_alarm(&self, queue: &mut Queue) {
        let now = self.now();
        let next = queue.next_expiration(now);
        ALARM.write(CTRL, 0);
        ALARM.acknowledge();
        if next != u64::MAX {
            // One that is too far for the timer is set again when it fires.
            let counts = next.saturating_sub(now).saturating_mul(COUNTS_PER_US);
            ALARM.write(VALUE, u32::try_from(counts).unwrap_or(u32::MAX).max(1));
            ALARM.write(CTRL, ENABLE | ENABLE_INTERRUPT);
        }
    }

    fn on_interrupt(&self) {
        if COUNTER.has_fired() {
            self.wraps.lock(|wraps| {
                COUNTER.acknowledge();
                wraps.set(wraps.get() + 1);
            });
        }
        if ALARM.has_fired() {
            self.queue.lock(|queue| self.set_alarm(&mut queue.borrow_mut()));
        }
    }
}

/// Starts board time at zero. To be called once, before anything waits.
pub(super) fn start() {
    ALARM.write(CTRL, 0);
    // No reload: it fires once.
    ALARM.write(RELOAD, 0);
    COUNTER.write(RELOAD, u32::MAX);
    COUNTER.write(VALUE, u32::MAX);
    COUNTER.write(CTRL, ENABLE | ENABLE_INTERRUPT);
    // SAFETY: no critical section relies on these being masked: none has begun.
    unsafe {
        NVIC::unmask(Interrupt::Counter);
        NVIC::unmask(Interrupt::Alarm);
    }
}

mod handler {
    use super::TIMERS;

    /// Nothing else here has interrupts.
    #[cortex_m_rt::exception]
    unsafe fn DefaultHandler(_interrupt: i16) {
        TIMERS.on_interrupt();
    }
}
