//! What the image tells itself over a reset: why it ended, in memory that no start writes.
//!
//! The bootloader runs in between and may overwrite it; a checksum tells, and then the chip's own
//! flags say what they know.

use core::mem::MaybeUninit;
use core::ptr::{addr_of, addr_of_mut, read_volatile, write_volatile};

use cortex_m::peripheral::SCB;
use embassy_stm32::pac::rcc::regs::Csr;
use embassy_stm32::pac::{GPIOF, RCC};

use crate::reset::{ResetCause, ResetReport};

/// The pin of port F that switches the servos' supply.
const SERVO_SUPPLY: usize = 15;

/// Cause, address, failures, checksum.
type Note = [u32; 4];
/// "gmr!" and a version.
const MAGIC: u32 = 0x676D_7221;
/// No last words.
const NONE: u32 = u32::MAX;

const fn checksum([cause, address, failures, _]: Note) -> u32 {
    MAGIC ^ cause.rotate_left(8) ^ address.rotate_left(16) ^ failures
}

#[expect(unsafe_code, reason = "memory that has to survive a reset is not initialised")]
mod memory {
    use super::{MaybeUninit, Note, addr_of, addr_of_mut, read_volatile, write_volatile};

    #[unsafe(link_section = ".uninit.LAST_WORDS")]
    static mut NOTE: MaybeUninit<Note> = MaybeUninit::uninit();

    pub(super) fn read() -> Note {
        // SAFETY: any four words are a note; whoever writes it resets the chip, or has just
        // started.
        unsafe { read_volatile(addr_of!(NOTE).cast()) }
    }

    pub(super) fn write(note: Note) {
        // SAFETY: as above.
        unsafe { write_volatile(addr_of_mut!(NOTE).cast(), note) }
    }
}

fn keep(cause: u32, address: u32, failures: u32) {
    let mut note = [cause, address, failures, 0];
    note[3] = checksum(note);
    memory::write(note);
}

fn kept() -> Option<Note> {
    let note = memory::read();
    (checksum(note) == note[3]).then_some(note)
}

/// Cuts the motors' supply, whoever holds its pin.
pub(super) fn cut_servo_supply() {
    GPIOF.bsrr().write(|register| register.set_br(SERVO_SUPPLY, true));
}

/// Cuts the motors' supply and starts again.
pub(super) fn reset_because(cause: ResetCause, address: u32) -> ! {
    cut_servo_supply();
    let failures = kept().map_or(0, |[_, _, failures, _]| failures);
    keep(cause as u32, address, failures);
    SCB::sys_reset()
}

/// Why the board started. To be called once, before anything else may fail.
pub(super) fn report() -> ResetReport {
    let flags = RCC.csr().read();
    RCC.csr().modify(|register| register.set_rmvf(true));
    let note = kept();
    let said = note.and_then(|[cause, address, ..]| {
        let cause = u8::try_from(cause).ok().and_then(ResetCause::from_code)?;
        Some((cause, address))
    });
    let (cause, address) = match said {
        Some(said) if flags.sftrstf() => said,
        _ => (from_flags(flags), 0),
    };
    let before = match note {
        Some([_, _, failures, _]) if cause != ResetCause::PowerOn => failures,
        _ => 0,
    };
    let failures = before.saturating_add(u32::from(cause.is_failure()));
    keep(NONE, 0, failures);
    ResetReport { cause, address, failures }
}

/// Every reset pulls the pin too, and a power-on sets the flag of the brown-out.
fn from_flags(flags: Csr) -> ResetCause {
    if flags.wwdgrstf() {
        ResetCause::Hang
    } else if flags.wdgrstf() {
        ResetCause::IndependentWatchdog
    } else if flags.sftrstf() {
        ResetCause::Software
    } else if flags.porrstf() {
        ResetCause::PowerOn
    } else if flags.borrstf() {
        ResetCause::BrownOut
    } else if flags.padrstf() {
        ResetCause::Pin
    } else {
        // The bootloader has cleared them.
        ResetCause::PowerOn
    }
}
