//! Bytes on USART3, by DMA both ways. Who waits is woken once for a packet that is sent, by its
//! last bit, and once for what has come, by the idle line behind it.
//!
//! The HAL's futures are woken by the end of each stream as well, and look at ring, stream and
//! peripheral at every poll: a tenth of all that the board executed (docs/board.md, "What a tick
//! costs").

use core::future::poll_fn;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicUsize, Ordering, fence};
use core::task::Poll;

use embassy_stm32::interrupt::typelevel::{self, Interrupt};
use embassy_stm32::pac::dma::vals::Dir;
use embassy_stm32::pac::usart::regs::{Icr, Isr};
use embassy_stm32::pac::{GPIOC, USART3};
use embassy_stm32::usart::Error;
use embassy_sync::waitqueue::AtomicWaker;

use crate::boards::opencr::streams::{Controller, Manner, Stream};

/// Bytes that may arrive while nobody reads: 2.5 ms at full speed, more than a sync read's two
/// answers. What comes in a longer stream is lost, and its checksum tells.
const RING_BYTES: usize = 256;
/// The longest packet on the bus.
const MOST_SENT: usize = 64;
const RECEIVING: Stream = Stream { controller: Controller::One, number: 1, channel: 4 };
const SENDING: Stream = Stream { controller: Controller::One, number: 3, channel: 4 };
/// Parity, framing, noise, overrun, idle line and end of sending, as they stand in ISR and ICR.
const FLAGS: u32 = 0x5F;
/// The direction's pin of port C.
const DIRECTION: usize = 9;

/// What was wrong on the line.
const FINE: u8 = 0;
const NOISE: u8 = 1;
const FRAMING: u8 = 2;
const OVERRUN: u8 = 3;

struct Wire {
    /// What DMA receives, round and round.
    ring: [AtomicU8; RING_BYTES],
    /// Where in it the next byte to be read stands.
    next: AtomicUsize,
    error: AtomicU8,
    /// What DMA sends.
    sent: [AtomicU8; MOST_SENT],
    is_sending: AtomicBool,
    /// One task has the port, and waits for one thing at a time.
    waker: AtomicWaker,
}

static WIRE: Wire = Wire {
    ring: [const { AtomicU8::new(0) }; RING_BYTES],
    next: AtomicUsize::new(0),
    error: AtomicU8::new(FINE),
    sent: [const { AtomicU8::new(0) }; MOST_SENT],
    is_sending: AtomicBool::new(false),
    waker: AtomicWaker::new(),
};

/// Lets the peripheral, which has been set up, receive, interrupt and ask for DMA.
#[expect(unsafe_code, reason = "enables an interrupt: no critical section relies on its being masked")]
pub(super) fn enable() {
    RECEIVING.connect(USART3.rdr().as_ptr().cast());
    SENDING.connect(USART3.tdr().as_ptr().cast());
    listen();
    USART3.cr3().modify(|register| {
        register.set_dmar(true);
        register.set_dmat(true);
        register.set_eie(true);
    });
    USART3.cr1().modify(|register| register.set_idleie(true));
    // SAFETY: see above.
    unsafe { typelevel::USART3::enable() };
}

/// Receives from the start of the ring on.
fn listen() {
    WIRE.next.store(0, Ordering::Relaxed);
    RECEIVING.begin(&WIRE.ring, RING_BYTES, Dir::PERIPHERAL_TO_MEMORY, Manner::Circular);
}

/// Sends the bytes, or as many as a packet has, and waits for the last bit of them. How many.
pub(super) async fn send(bytes: &[u8]) -> usize {
    let count = bytes.len().min(MOST_SENT);
    WIRE.sent.iter().zip(bytes).for_each(|(place, byte)| place.store(*byte, Ordering::Relaxed));
    WIRE.is_sending.store(true, Ordering::Relaxed);
    // From here on the flag means the end of these bytes.
    USART3.icr().write(|register| register.set_tc(true));
    critical_section::with(|_| USART3.cr1().modify(|register| register.set_tcie(true)));
    SENDING.begin(&WIRE.sent, count, Dir::MEMORY_TO_PERIPHERAL, Manner::Once);
    poll_fn(|context| {
        WIRE.waker.register(context.waker());
        if WIRE.is_sending.load(Ordering::Acquire) { Poll::Pending } else { Poll::Ready(count) }
    })
    .await
}

/// Waits for bytes, and gives those that there are.
///
/// # Errors
/// The receiver had one; what has come by then is thrown away.
pub(super) async fn receive(buffer: &mut [u8]) -> Result<usize, Error> {
    poll_fn(|context| {
        WIRE.waker.register(context.waker());
        let error = match WIRE.error.swap(FINE, Ordering::Relaxed) {
            FINE if RECEIVING.is_running() => None,
            FRAMING => Some(Error::Framing),
            NOISE => Some(Error::Noise),
            _ => Some(Error::Overrun),
        };
        if let Some(error) = error {
            listen();
            return Poll::Ready(Err(error));
        }
        match take(buffer) {
            0 => Poll::Pending,
            count => Poll::Ready(Ok(count)),
        }
    })
    .await
}

/// What has come since, as far as there is room for it.
fn take(buffer: &mut [u8]) -> usize {
    let end = RING_BYTES.saturating_sub(RECEIVING.remaining()) % RING_BYTES;
    // What DMA has counted is in memory.
    fence(Ordering::SeqCst);
    let next = WIRE.next.load(Ordering::Relaxed);
    // Behind the end of the ring it goes on at its start.
    let count = (if end < next { RING_BYTES } else { end }).saturating_sub(next).min(buffer.len());
    let come = WIRE.ring.get(next..next + count).unwrap_or(&[]);
    buffer.iter_mut().zip(come).for_each(|(place, byte)| *place = byte.load(Ordering::Relaxed));
    WIRE.next.store((next + count) % RING_BYTES, Ordering::Relaxed);
    count
}

/// What the peripheral has to say.
fn serve() {
    let status = USART3.isr().read();
    // Between two bytes, if the stream is late, it sends its last bit as well.
    if status.tc() && USART3.cr1().read().tcie() && SENDING.remaining() == 0 {
        // A servo may answer at once, sooner than a busy task comes to turn the buffer.
        GPIOC.bsrr().write(|register| register.set_br(DIRECTION, true));
        WIRE.is_sending.store(false, Ordering::Release);
        USART3.cr1().modify(|register| register.set_tcie(false));
    }
    if let Some(error) = error(status) {
        WIRE.error.store(error, Ordering::Relaxed);
    }
    // What has been seen, and nothing that came up since.
    USART3.icr().write_value(Icr(status.0 & FLAGS));
    WIRE.waker.wake();
}

fn error(status: Isr) -> Option<u8> {
    if status.ore() {
        Some(OVERRUN)
    } else if status.fe() {
        Some(FRAMING)
    } else if status.ne() {
        Some(NOISE)
    } else {
        None
    }
}

/// The peripheral's interrupt.
pub(in crate::boards::opencr) struct Events;

#[expect(unsafe_code, reason = "the HAL declares handlers unsafe; this one is called for its interrupt only")]
impl typelevel::Handler<typelevel::USART3> for Events {
    unsafe fn on_interrupt() {
        serve();
    }
}
