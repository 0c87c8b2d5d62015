//! One transaction on I2C1, moved byte by byte in its interrupts: who waits for it is woken once, when it is over.
//!
//! The HAL's own future is woken four times for each register of a sensor, sets two DMA channels up for three bytes, and had made up
//! half of all that the board executes (docs/board.md, "What a tick costs").

use core::cell::RefCell;
use core::future::poll_fn;
use core::task::Poll;

use embassy_stm32::i2c::Error;
use embassy_stm32::interrupt::typelevel::{self, Interrupt};
use embassy_stm32::pac::I2C1;
use embassy_stm32::pac::i2c::vals::{Autoend, Dir};
use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_sync::waitqueue::AtomicWaker;
use embedded_hal_async::i2c::Operation;

/// A register's address and its 16 bits.
const MOST_SENT: usize = 3;
const MOST_RECEIVED: usize = 2;
/// Registers of a transaction: what a poll of a sensor asks for.
const MOST_STEPS: usize = 4;

/// A write and the read that follows it.
#[derive(Debug, Clone, Copy)]
struct Step {
    out: [u8; MOST_SENT],
    sending: usize,
    into: [u8; MOST_RECEIVED],
    wanted: usize,
}

impl Step {
    const NONE: Self = Self { out: [0; MOST_SENT], sending: 0, into: [0; MOST_RECEIVED], wanted: 0 };
}

/// What goes on on the bus.
#[derive(Debug)]
struct Transfer {
    /// 7 bits.
    address: u8,
    steps: [Step; MOST_STEPS],
    count: usize,
    /// The step that is under way, what of it is sent, what received.
    at: usize,
    sent: usize,
    received: usize,
    outcome: Option<Result<(), Error>>,
}

impl Transfer {
    const NONE: Self = Self {
        address: 0,
        steps: [Step::NONE; MOST_STEPS],
        count: 0,
        at: 0,
        sent: 0,
        received: 0,
        outcome: None,
    };
}

struct Bus {
    transfer: CriticalSectionMutex<RefCell<Transfer>>,
    waker: AtomicWaker,
}

static BUS: Bus =
    Bus { transfer: CriticalSectionMutex::new(RefCell::new(Transfer::NONE)), waker: AtomicWaker::new() };

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

/// Carries the operations out, a write and a read by turns, with a repeated start before each but the first. The bus has to be free. Waits for
/// good where it is held: the caller has a time limit, and takes the peripheral down after it.
///
/// # Errors
/// Not acknowledged, arbitration lost, a bus error; other operations, or more of them or of their bytes, than a poll of a sensor has.
pub(super) async fn transfer(address: u8, operations: &mut [Operation<'_>]) -> Result<(), Error> {
    let pairs = operations.as_chunks_mut::<2>().0;
    let mut steps = [Step::NONE; MOST_STEPS];
    for (step, pair) in steps.iter_mut().zip(&*pairs) {
        let [Operation::Write(out), Operation::Read(into)] = pair else { return Err(Error::Overrun) };
        step.out.get_mut(..out.len()).ok_or(Error::Overrun)?.copy_from_slice(out);
        (step.sending, step.wanted) = (out.len(), into.len());
        if out.is_empty() || into.is_empty() || into.len() > MOST_RECEIVED {
            return Err(Error::Overrun);
        }
    }
    let count = pairs.len();
    if count == 0 || count > MOST_STEPS {
        return Err(Error::Overrun);
    }
    BUS.transfer.lock(|place| {
        *place.borrow_mut() = Transfer { address, steps, count, ..Transfer::NONE };
    });
    I2C1.icr().write(|register| {
        register.set_stopcf(true);
        register.set_nackcf(true);
        register.set_berrcf(true);
        register.set_arlocf(true);
        register.set_ovrcf(true);
    });
    // A byte that was not sent any more would be the next one's first.
    I2C1.isr().write(|register| register.set_txe(true));
    let [first, ..] = steps;
    start(address, first.sending, false, false);
    poll_fn(|context| {
        BUS.waker.register(context.waker());
        BUS.transfer.lock(|place| place.borrow().outcome).map_or(Poll::Pending, Poll::Ready)
    })
    .await?;
    let steps = BUS.transfer.lock(|place| place.borrow().steps);
    for (pair, step) in pairs.iter_mut().zip(steps) {
        if let [_, Operation::Read(into)] = pair {
            into.iter_mut().zip(step.into).for_each(|(place, byte)| *place = byte);
        }
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
        let is_last = self.at + 1 >= self.count;
        let Some(step) = self.steps.get_mut(self.at) else { return };
        if status.txis() {
            let byte = step.out.get(self.sent).copied().unwrap_or(0);
            self.sent += 1;
            I2C1.txdr().write(|register| register.set_txdata(byte));
        }
        if status.rxne() {
            let byte = I2C1.rxdr().read().rxdata();
            if let Some(place) = step.into.get_mut(self.received) {
                *place = byte;
            }
            self.received += 1;
        }
        let is_whole = self.received == step.wanted;
        if status.tc() && is_whole {
            // The next step, which is not the last one's stop.
            self.at += 1;
            (self.sent, self.received) = (0, 0);
            if let Some(next) = self.steps.get(self.at) {
                start(self.address, next.sending, false, false);
            }
        } else if status.tc() {
            start(self.address, step.wanted, true, is_last);
        }
        // Also what is not acknowledged ends with a stop, which the peripheral sends by itself.
        if status.stopf() {
            I2C1.icr().write(|register| {
                register.set_stopcf(true);
                register.set_nackcf(true);
            });
            self.outcome = Some(match (status.nackf(), is_last && is_whole) {
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
        let mut transfer = place.borrow_mut();
        work(&mut transfer);
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
