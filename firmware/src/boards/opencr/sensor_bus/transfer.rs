//! Transactions on I2C1: DMA moves the bytes, the peripheral's interrupts start the next piece, and
//! who waits is woken once, when the last of up to four transactions is over.
//!
//! The HAL's own future is woken four times for each register of a sensor and sets two DMA channels
//! up for three bytes; an interrupt for each byte was an eighth of all that the board executed
//! (docs/board.md, "What a tick costs"). Here a piece, a start with the bytes up to the next, is
//! one word for CR2, made before anything begins.

use core::future::poll_fn;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, AtomicUsize, Ordering, fence};
use core::task::Poll;

use embassy_stm32::i2c::Error;
use embassy_stm32::interrupt::typelevel::{self, Interrupt};
use embassy_stm32::pac::I2C1;
use embassy_stm32::pac::dma::vals;
use embassy_stm32::pac::i2c::regs::{Cr2, Isr};
use embassy_stm32::pac::i2c::vals::{Autoend, Dir};
use embassy_sync::waitqueue::AtomicWaker;
use embedded_hal_async::i2c::Operation;

use crate::boards::opencr::streams::{Controller, Manner, Stream};
use crate::power_sensors::{Conversion, RAIL_COUNT};

/// Of a transaction: what a poll of a sensor sends, receives, and in how many pieces.
const MOST_SENT: usize = 6;
const MOST_RECEIVED: usize = 8;
const MOST_PIECES: usize = 8;
const MOST_TRANSACTIONS: usize = RAIL_COUNT;

const RECEIVING: Stream = Stream { controller: Controller::One, number: 5, channel: 1 };
const SENDING: Stream = Stream { controller: Controller::One, number: 6, channel: 1 };

/// How a transaction ended.
const PENDING: u8 = 0;
const DONE: u8 = 1;
const NACK: u8 = 2;
const BROKEN: u8 = 3;
const ARBITRATION: u8 = 4;
const OVERRUN: u8 = 5;

/// One transaction, as the interrupts carry it out.
struct Transaction {
    /// What DMA sends, and how much of it.
    sent: [AtomicU8; MOST_SENT],
    sending: AtomicUsize,
    /// What DMA has received, and how much it is to be.
    received: [AtomicU8; MOST_RECEIVED],
    wanted: AtomicUsize,
    /// CR2 of each piece; 0 behind the last.
    pieces: [AtomicU32; MOST_PIECES],
    outcome: AtomicU8,
    /// Which conversion all this is made for, as [`key`] says; 0 for none.
    made_for: AtomicU32,
}

impl Transaction {
    const fn new() -> Self {
        Self {
            sent: [const { AtomicU8::new(0) }; MOST_SENT],
            sending: AtomicUsize::new(0),
            received: [const { AtomicU8::new(0) }; MOST_RECEIVED],
            wanted: AtomicUsize::new(0),
            pieces: [const { AtomicU32::new(0) }; MOST_PIECES],
            outcome: AtomicU8::new(PENDING),
            made_for: AtomicU32::new(0),
        }
    }
}

struct Bus {
    transactions: [Transaction; MOST_TRANSACTIONS],
    count: AtomicUsize,
    /// The transaction that is under way, and its next piece.
    at: AtomicUsize,
    next: AtomicUsize,
    is_over: AtomicBool,
    waker: AtomicWaker,
}

static BUS: Bus = Bus {
    transactions: [const { Transaction::new() }; MOST_TRANSACTIONS],
    count: AtomicUsize::new(0),
    at: AtomicUsize::new(0),
    next: AtomicUsize::new(0),
    is_over: AtomicBool::new(true),
    waker: AtomicWaker::new(),
};

/// Lets the peripheral, which has been set up, interrupt and ask for DMA.
#[expect(unsafe_code, reason = "enables interrupts: no critical section relies on their being masked")]
pub(super) fn enable() {
    RECEIVING.connect(I2C1.rxdr().as_ptr().cast());
    SENDING.connect(I2C1.txdr().as_ptr().cast());
    I2C1.cr1().modify(|register| {
        register.set_txdmaen(true);
        register.set_rxdmaen(true);
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

/// Carries the operations out, a write and a read by turns, with a repeated start before each but
/// the first. The bus has to be free. Waits for good where it is held: the caller has a time limit,
/// and takes the peripheral down after it.
///
/// # Errors
/// Not acknowledged, arbitration lost, a bus error; other operations, or more of them or of their
/// bytes, than a poll of a sensor has.
pub(super) async fn transfer(address: u8, operations: &mut [Operation<'_>]) -> Result<(), Error> {
    let [transaction, ..] = &BUS.transactions;
    let pairs = operations.as_chunks_mut::<2>().0;
    let mut plan = Plan::new(transaction, address);
    for pair in &*pairs {
        let [Operation::Write(out), Operation::Read(into)] = pair else { return Err(Error::Overrun) };
        plan.add(out, into.len())?;
    }
    plan.end()?;
    run(1).await;
    outcome(transaction)?;
    let mut received = transaction.received.iter().map(|byte| byte.load(Ordering::Relaxed));
    for pair in pairs {
        if let [_, Operation::Read(into)] = pair {
            into.iter_mut().zip(&mut received).for_each(|(place, byte)| *place = byte);
        }
    }
    Ok(())
}

/// Carries conversions out, one transaction each; [`collect`] has their answers. The bus has to be
/// free, and the caller has a time limit, as for [`transfer`].
///
/// # Errors
/// More of them than there are rails.
pub(super) async fn convert(conversions: &[Option<Conversion>]) -> Result<(), Error> {
    let mut count = 0;
    for conversion in conversions.iter().flatten() {
        let transaction = BUS.transactions.get(count).ok_or(Error::Overrun)?;
        count += 1;
        // From one sample to the next hardly ever another.
        if transaction.made_for.load(Ordering::Relaxed) == key(conversion) {
            transaction.outcome.store(PENDING, Ordering::Relaxed);
            continue;
        }
        let mut plan = Plan::new(transaction, conversion.address);
        let written = conversion.written();
        let mut rest = &written[..];
        for bytes in Conversion::WRITES {
            let (piece, behind) = rest.split_at_checked(bytes).ok_or(Error::Overrun)?;
            plan.add(piece, 2)?;
            rest = behind;
        }
        plan.end()?;
        transaction.made_for.store(key(conversion), Ordering::Relaxed);
    }
    run(count).await;
    Ok(())
}

/// Tells conversions apart, and from none.
fn key(conversion: &Conversion) -> u32 {
    1 << 31 | u32::from(conversion.address) << 16 | u32::from(conversion.set_up)
}

/// Fills in the answers that there are, whether all of it is over or not.
///
/// # Errors
/// What has gone wrong on the bus, and with which of the conversions that were asked for. A chip
/// that does not acknowledge is no error: it has no answer.
pub(super) fn collect(conversions: &mut [Option<Conversion>]) -> Result<(), (usize, Error)> {
    for (at, (conversion, transaction)) in conversions.iter_mut().flatten().zip(&BUS.transactions).enumerate()
    {
        match outcome(transaction) {
            Ok(()) => conversion.answer = Some(words(transaction)),
            Err(Error::Nack) => {}
            Err(error) => return Err((at, error)),
        }
    }
    Ok(())
}

fn words(transaction: &Transaction) -> [u16; 4] {
    let mut words = [0; 4];
    for (word, [high, low]) in words.iter_mut().zip(transaction.received.as_chunks().0) {
        *word = u16::from_be_bytes([high.load(Ordering::Relaxed), low.load(Ordering::Relaxed)]);
    }
    words
}

fn outcome(transaction: &Transaction) -> Result<(), Error> {
    Err(match transaction.outcome.load(Ordering::Relaxed) {
        DONE => return Ok(()),
        NACK => Error::Nack,
        ARBITRATION => Error::Arbitration,
        OVERRUN => Error::Overrun,
        // PENDING too: none behind one that went wrong begins.
        _ => Error::Bus,
    })
}

/// Makes the pieces of a transaction. Nothing may be under way.
struct Plan {
    transaction: &'static Transaction,
    address: u8,
    count: usize,
}

impl Plan {
    fn new(transaction: &'static Transaction, address: u8) -> Self {
        transaction.outcome.store(PENDING, Ordering::Relaxed);
        transaction.made_for.store(0, Ordering::Relaxed);
        transaction.sending.store(0, Ordering::Relaxed);
        transaction.wanted.store(0, Ordering::Relaxed);
        Self { transaction, address, count: 0 }
    }

    /// A write and the read that follows it.
    fn add(&mut self, out: &[u8], wanted: usize) -> Result<(), Error> {
        let Transaction { sent, sending, wanted: all, .. } = self.transaction;
        let (from, received) = (sending.load(Ordering::Relaxed), all.load(Ordering::Relaxed) + wanted);
        let place = sent.get(from..from + out.len()).ok_or(Error::Overrun)?;
        if out.is_empty() || wanted == 0 || received > MOST_RECEIVED {
            return Err(Error::Overrun);
        }
        place.iter().zip(out).for_each(|(place, byte)| place.store(*byte, Ordering::Relaxed));
        sending.store(from + out.len(), Ordering::Relaxed);
        all.store(received, Ordering::Relaxed);
        self.put(out.len(), Dir::WRITE)?;
        self.put(wanted, Dir::READ)
    }

    fn put(&mut self, bytes: usize, direction: Dir) -> Result<(), Error> {
        let mut piece = Cr2(0);
        piece.set_sadd(u16::from(self.address) << 1);
        piece.set_dir(direction);
        piece.set_nbytes(bytes as u8);
        piece.set_start(true);
        let place = self.transaction.pieces.get(self.count).ok_or(Error::Overrun)?;
        place.store(piece.0, Ordering::Relaxed);
        self.count += 1;
        Ok(())
    }

    /// A stop behind the last bytes.
    fn end(self) -> Result<(), Error> {
        let Self { transaction, count, .. } = self;
        let last =
            count.checked_sub(1).and_then(|last| transaction.pieces.get(last)).ok_or(Error::Overrun)?;
        let mut piece = Cr2(last.load(Ordering::Relaxed));
        piece.set_autoend(Autoend::AUTOMATIC);
        last.store(piece.0, Ordering::Relaxed);
        transaction.pieces.iter().skip(count).for_each(|piece| piece.store(0, Ordering::Relaxed));
        Ok(())
    }
}

/// The first so many transactions, until the last is over or one goes wrong.
async fn run(count: usize) {
    BUS.count.store(count, Ordering::Relaxed);
    BUS.at.store(0, Ordering::Relaxed);
    I2C1.icr().write(|register| {
        register.set_stopcf(true);
        register.set_nackcf(true);
        register.set_berrcf(true);
        register.set_arlocf(true);
        register.set_ovrcf(true);
    });
    BUS.is_over.store(count == 0, Ordering::Relaxed);
    begin(0);
    poll_fn(|context| {
        BUS.waker.register(context.waker());
        if BUS.is_over.load(Ordering::Acquire) { Poll::Ready(()) } else { Poll::Pending }
    })
    .await;
}

/// Begins a transaction: its streams, then its first piece. False where there is none.
fn begin(at: usize) -> bool {
    if at >= BUS.count.load(Ordering::Relaxed) {
        return false;
    }
    let Some(transaction) = BUS.transactions.get(at) else { return false };
    // A byte that was not sent any more would be the next one's first.
    I2C1.isr().write(|register| register.set_txe(true));
    let (wanted, sending) = (&transaction.wanted, &transaction.sending);
    let count = |count: &AtomicUsize| count.load(Ordering::Relaxed);
    RECEIVING.begin(&transaction.received, count(wanted), vals::Dir::PERIPHERAL_TO_MEMORY, Manner::Once);
    SENDING.begin(&transaction.sent, count(sending), vals::Dir::MEMORY_TO_PERIPHERAL, Manner::Once);
    BUS.at.store(at, Ordering::Relaxed);
    BUS.next.store(0, Ordering::Relaxed);
    go_on(transaction)
}

/// The next piece of the transaction. False where there is none.
fn go_on(transaction: &Transaction) -> bool {
    let next = BUS.next.load(Ordering::Relaxed);
    let piece = transaction.pieces.get(next).map_or(0, |piece| piece.load(Ordering::Relaxed));
    BUS.next.store(next + 1, Ordering::Relaxed);
    I2C1.cr2().write_value(Cr2(piece));
    piece != 0
}

/// What the peripheral has to say. RM0385, I2C master initialisation to DMA requests.
fn serve() {
    let status = I2C1.isr().read();
    let at = BUS.at.load(Ordering::Relaxed);
    let Some(transaction) = BUS.transactions.get(at) else { return };
    if status.stopf() {
        stopped(at, transaction, status);
    } else if status.tc() && !go_on(transaction) {
        // Never: the last piece ends with a stop.
        end(transaction, BROKEN);
    }
}

/// The bus is free again. What is not acknowledged ends so too, by a stop that the peripheral sends
/// by itself.
fn stopped(at: usize, transaction: &Transaction, status: Isr) {
    I2C1.icr().write(|register| {
        register.set_stopcf(true);
        register.set_nackcf(true);
    });
    let is_whole = RECEIVING.remaining() == 0;
    if !status.nackf() && !is_whole {
        end(transaction, BROKEN);
        return;
    }
    transaction.outcome.store(if status.nackf() { NACK } else { DONE }, Ordering::Relaxed);
    if !begin(at + 1) {
        over();
    }
}

/// What has gone wrong.
fn fail() {
    let status = I2C1.isr().read();
    I2C1.icr().write(|register| {
        register.set_berrcf(true);
        register.set_arlocf(true);
        register.set_ovrcf(true);
    });
    if let Some(transaction) = BUS.transactions.get(BUS.at.load(Ordering::Relaxed)) {
        end(
            transaction,
            if status.arlo() {
                ARBITRATION
            } else if status.berr() {
                BROKEN
            } else {
                OVERRUN
            },
        );
    }
}

/// Ends all of it.
fn end(transaction: &Transaction, outcome: u8) {
    transaction.outcome.store(outcome, Ordering::Relaxed);
    over();
}

fn over() {
    // What DMA has written is in memory before anybody looks.
    fence(Ordering::SeqCst);
    BUS.is_over.store(true, Ordering::Release);
    BUS.waker.wake();
}

/// The peripheral's events.
pub(in crate::boards::opencr) struct Events;

#[expect(unsafe_code, reason = "the HAL declares handlers unsafe; this one is called for its interrupt only")]
impl typelevel::Handler<typelevel::I2C1_EV> for Events {
    unsafe fn on_interrupt() {
        serve();
    }
}

/// Its errors.
pub(in crate::boards::opencr) struct Errors;

#[expect(unsafe_code, reason = "the HAL declares handlers unsafe; this one is called for its interrupt only")]
impl typelevel::Handler<typelevel::I2C1_ER> for Errors {
    unsafe fn on_interrupt() {
        fail();
    }
}
