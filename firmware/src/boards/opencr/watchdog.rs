//! The window watchdog: what hangs ends in a reset, after which the bootloader starts the image
//! again.
//!
//! Not the independent one: after its reset the OpenCR's bootloader stays until somebody presses a
//! button (docs/board.md, trap B). This one counts the slower bus's clock: 38.8 ms at 54 MHz, 131
//! ms before the crystal runs. Once started it cannot be stopped, so the flash is erased by code
//! that feeds it (`erase.rs`).

use embassy_stm32::pac::wwdg::vals::Wdgtb;
use embassy_stm32::pac::{DBGMCU, RCC, WWDG};
use embassy_time::Duration;

/// The counter's greatest value; it resets the chip below 64.
const FULL: u8 = 0x7F;

/// How often it is fed: four times in what it allows.
pub const PERIOD: Duration = Duration::from_millis(9);

/// Starts it. A clock that does not come up is such a hang too.
pub(super) fn start() {
    // Halted by a probe, the chip is not to reset.
    DBGMCU.apb1fzr().modify(|register| register.0 |= 1 << 11);
    RCC.apb1enr().modify(|register| register.set_wwdgen(true));
    cortex_m::asm::dsb();
    WWDG.cfr().write(|register| {
        register.set_w(FULL);
        register.set_wdgtb(Wdgtb::DIV8);
    });
    feed();
}

/// Begins its time anew.
pub fn feed() {
    WWDG.cr().write(|register| {
        register.set_t(FULL);
        register.set_wdga(true);
    });
}
