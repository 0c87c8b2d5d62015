//! One transaction on I2C1, moved byte by byte in its interrupts: who waits for it is woken once, when it is over.
//!
//! The HAL's own future is woken four times for each register of a sensor, sets two DMA channels up for three bytes, and had made up
//! half of all that the board executes (docs/board.md, "What a tick costs").

use core::cell::Cell;
use core::future::poll_fn;
use core::task::Poll;

use embassy_stm32::i2c::Error;
use embassy_stm32::interrupt::typelevel::{self, Interrupt};
use embassy_stm32::pac::I2C1;
use embassy_stm32::pac::i2c::vals::{Autoend, Dir};
use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_sync::waitqueue::AtomicWaker;

/// A register's address and its 16 bits.
const MOST_SENT: usize = 3;
const MOST_RECEIVED: usize = 2;

/// What goes on on the bus.
#[derive(Debug, Clone, Copy)]
struct Transfer {
    /// 7 bits.
    address: u8,
    out: [u8; MOST_SENT],
    sent: usize,
    into: [u8; MOST_RECEIVED],
    received: usize,
    /// Bytes to be received, after those that are sent.
    wanted: usize,
    outcome: Option<Result<(), Error>>,
}

struct Bus {
    transfer: CriticalSectionMutex<Cell<Transfer>>,
    waker: AtomicWaker,
}

static BUS: Bus = Bus {
    transfer: CriticalSectionMutex::new(Cell::new(Transfer {
        address: 0,
        out: [0; MOST_SENT],
        sent: 0,
        into: [0; MOST_RECEIVED],
        received: 0,
        wanted: 0,
        outcome: None,
    })),
    waker: AtomicWaker::new(),
};

/// Lets the peripheral, which has been set up, interrupt.
#[expect(unsafe_code, reason = "enables interrupts: no critical section relies on their being masked")]
pub(super) fn enable() {
    I2C1.cr1().modify(|register| {
        register.set_txie(true);
        register.set_rxie(true);
        register.set_tcie(true);
        register.set_stopie(true);
        register.set_errie(true);
    });
    // SAFETY: see above.
    unsafe {
        typelevel::I2C1_EV::enable();
        typelevel::I2C1_ER::enable();
    }
}

/// Sends `out`, then, after a repeated start, receives as many bytes as fit `into`. The bus has to be free. Waits for good where it is
/// held: the caller has a time limit, and takes the peripheral down after it.
///
/// # Errors
/// Not acknowledged, arbitration lost, a bus error; more bytes than a sensor's registers have.
pub(super) async fn transfer(address: u8, out: &[u8], into: &mut [u8]) -> Result<(), Error> {
    let mut transfer = Transfer {
        address,
        out: [0; MOST_SENT],
        sent: 0,
        into: [0; MOST_RECEIVED],
        received: 0,
        wanted: into.len(),
        outcome: None,
    };
    transfer.out.get_mut(..out.len()).ok_or(Error::Overrun)?.copy_from_slice(out);
    if out.is_empty() || into.len() > MOST_RECEIVED {
        return Err(Error::Overrun);
    }
    BUS.transfer.lock(|place| place.set(transfer));
    I2C1.icr().write(|register| {
        register.set_stopcf(true);
        register.set_nackcf(true);
        register.set_berrcf(true);
        register.set_arlocf(true);
        register.set_ovrcf(true);
    });
    // A byte that was not sent any more would be the next one's first.
    I2C1.isr().write(|register| register.set_txe(true));
    start(address, out.len(), false, into.is_empty());
    let transfer = poll_fn(|context| {
        BUS.waker.register(context.waker());
        let transfer = BUS.transfer.lock(Cell::get);
        if transfer.outcome.is_some() { Poll::Ready(transfer) } else { Poll::Pending }
    })
    .await;
    transfer.outcome.unwrap_or(Err(Error::Bus))?;
    for (place, byte) in into.iter_mut().zip(transfer.into) {
        *place = byte;
    }
    Ok(())
}

/// A start, or a repeated one, and so many bytes; a stop behind the last ones.
fn start(address: u8, bytes: usize, is_read: bool, is_last: bool) {
    I2C1.cr2().write(|register| {
        register.set_sadd(u16::from(address) << 1);
        register.set_dir(if is_read { Dir::READ } else { Dir::WRITE });
        register.set_nbytes(bytes as u8);
        register.set_autoend(if is_last { Autoend::AUTOMATIC } else { Autoend::SOFTWARE });
        register.set_start(true);
    });
}

impl Transfer {
    /// What the peripheral asks for. RM0385, I2C master initialisation to master receiver.
    fn serve(&mut self) {
        let status = I2C1.isr().read();
        if status.txis() {
            let byte = self.out.get(self.sent).copied().unwrap_or(0);
            self.sent += 1;
            I2C1.txdr().write(|register| register.set_txdata(byte));
        }
        if status.rxne() {
            let byte = I2C1.rxdr().read().rxdata();
            if let Some(place) = self.into.get_mut(self.received) {
                *place = byte;
            }
            self.received += 1;
        }
        if status.tc() {
            start(self.address, self.wanted, true, true);
        }
        // Also what is not acknowledged ends with a stop, which the peripheral sends by itself.
        if status.stopf() {
            I2C1.icr().write(|register| {
                register.set_stopcf(true);
                register.set_nackcf(true);
            });
            let is_whole = self.received == self.wanted;
            self.outcome = Some(match (status.nackf(), is_whole) {
                (true, _) => Err(Error::Nack),
                (false, true) => Ok(()),
                (false, false) => Err(Error::Bus),
            });
        }
    }

    /// What has gone wrong.
    fn fail(&mut self) {
        let status = I2C1.isr().read();
        I2C1.icr().write(|register| {
            register.set_berrcf(true);
            register.set_arlocf(true);
            register.set_ovrcf(true);
        });
        self.outcome = Some(Err(if status.arlo() {
            Error::Arbitration
        } else if status.berr() {
            Error::Bus
        } else {
            Error::Overrun
        }));
    }
}

/// Goes on with the transfer, and wakes who waits for it when it is over.
fn go_on(work: impl FnOnce(&mut Transfer)) {
    let is_over = BUS.transfer.lock(|place| {
        let mut transfer = place.get();
        work(&mut transfer);
        place.set(transfer);
        transfer.outcome.is_some()
    });
    if is_over {
        BUS.waker.wake();
    }
}

/// The peripheral's events.
pub(in crate::boards::opencr) struct Events;

#[expect(unsafe_code, reason = "the HAL declares handlers unsafe; this one is called for its interrupt only")]
impl typelevel::Handler<typelevel::I2C1_EV> for Events {
    unsafe fn on_interrupt() {
        go_on(Transfer::serve);
    }
}

/// Its errors.
pub(in crate::boards::opencr) struct Errors;

#[expect(unsafe_code, reason = "the HAL declares handlers unsafe; this one is called for its interrupt only")]
impl typelevel::Handler<typelevel::I2C1_ER> for Errors {
    unsafe fn on_interrupt() {
        go_on(Transfer::fail);
    }
}
