//! The stock loader's call: `opencr_ld` opens the port at 1200 baud and sends a word; the board has
//! to be in its bootloader within 3 s.
//!
//! The bootloader stays when the independent watchdog has reset the chip (docs/board.md, trap B):
//! what the stock firmware does too.

use embassy_stm32::pac::IWDG;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};

const CALL: &[u8] = b"OpenCR 5555AAAA";
const CALLING_BAUD: u32 = 1200;
/// Of 32 kHz through the divider by 4: 10 ms.
const RELOAD: u16 = 80;

/// Goes to the bootloader if that is what the host asks for: both the rate and the word.
pub(super) fn look_for_call(baud: u32, received: &[u8]) {
    if baud == CALLING_BAUD && received.windows(CALL.len()).any(|word| word == CALL) {
        defmt::info!("the loader calls");
        enter();
    }
}

/// With the motors off.
fn enter() -> ! {
    critical_section::with(|_| {
        super::last_words::cut_servo_supply();
        for key in [Key::START, Key::ENABLE] {
            IWDG.kr().write(|register| register.set_key(key));
        }
        IWDG.pr().write(|register| register.set_pr(Pr::DIVIDE_BY4));
        IWDG.rlr().write(|register| register.set_rl(RELOAD));
        IWDG.kr().write(|register| register.set_key(Key::RESET));
        loop {
            super::watchdog::feed();
        }
    })
}
