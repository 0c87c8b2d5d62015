//! Erases a sector of the flash while the watchdog runs.
//!
//! The chip has one bank: while it erases, whatever fetches from it stands still, for longer than
//! the watchdog allows. So the loop that waits is in RAM, and feeds it. Interrupts, whose handlers
//! are in flash, are masked meanwhile.
#![expect(unsafe_code, reason = "device registers from code that may call nothing in flash")]

use core::ptr::{read_volatile, write_volatile};

use embassy_stm32::pac::{FLASH, PWR};

const STATUS: *mut u32 = 0x4002_3C0C as *mut u32;
const CONTROL: *mut u32 = 0x4002_3C10 as *mut u32;
const WATCHDOG: *mut u32 = 0x4000_2C00 as *mut u32;
/// Flags of RM0385, FLASH_SR and FLASH_CR.
const BUSY: u32 = 1 << 16;
const ERRORS: u32 = 0xF0;
const END: u32 = 1;
const ERASE_SECTOR: u32 = 1 << 1;
/// 32 bits at a time: the fastest that 3.3 V allow.
const BY_32: u32 = 2 << 8;
const START: u32 = 1 << 16;
const LOCK: u32 = 1 << 31;
/// The watchdog's counter at its greatest, and its activation bit.
const FED: u32 = 0xFF;

/// Times that the watchdog is fed at most. Each takes eight cycles of 216 MHz or more (a write and
/// a read behind a bus bridge), so these are 4 s at least: no sector takes longer (STM32F746
/// datasheet, flash memory programming). A flash that is busy for ever ends in a reset.
const MOST_FEEDS: u32 = 108_000_000;

/// 2.8 V falling: programming by 32 bits wants 2.7 V (STM32F746 datasheet, flash memory
/// programming).
const LOWEST_SUPPLY: u8 = 6;

/// Watches the chip's supply from now on.
pub(super) fn watch_supply() {
    PWR.cr1().modify(|register| {
        register.set_pls(LOWEST_SUPPLY);
        register.set_pvde(true);
    });
}

/// Whether the supply suffices to erase and to program.
pub(super) fn has_supply() -> bool {
    !PWR.csr1().read().pvdo()
}

/// Erases a sector by its number; whether that went well.
pub(super) fn erase(sector: u32) -> bool {
    critical_section::with(|_| {
        if FLASH.cr().read().lock() {
            FLASH.keyr().write_value(0x4567_0123);
            FLASH.keyr().write_value(0xCDEF_89AB);
        }
        // SAFETY: the flash is unlocked and nobody else runs; the sector is the store's.
        unsafe { erase_from_ram(sector) & ERRORS == 0 }
    })
}

/// The flash's flags after it.
#[inline(never)]
#[unsafe(link_section = ".data.erase_from_ram")]
unsafe fn erase_from_ram(sector: u32) -> u32 {
    // SAFETY: registers of this chip; the caller has masked the interrupts and unlocked the flash.
    unsafe {
        write_volatile(STATUS, ERRORS | END);
        write_volatile(CONTROL, BY_32 | ERASE_SECTOR | sector << 3);
        write_volatile(CONTROL, BY_32 | ERASE_SECTOR | sector << 3 | START);
        let mut feeds = 0;
        loop {
            if feeds < MOST_FEEDS {
                write_volatile(WATCHDOG, FED);
                feeds += 1;
            }
            let status = read_volatile(STATUS);
            if status & BUSY == 0 {
                write_volatile(CONTROL, LOCK);
                return status;
            }
        }
    }
}
